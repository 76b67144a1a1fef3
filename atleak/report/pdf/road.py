"""Build the section on the road test: what the log says by itself, what to check next, and the leakage over it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from atleak.engine.road_leakage import RoadLeakage
from atleak.report.pdf.blocks import Block, PrintedColumn, facts, joined, printed, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.road_findings import RoadFindings
from atleak.views.log_rows import event_table, place_table
from atleak.views.road_series import RoadSeries
from atleak.views.road_words import (
    check_sentences,
    log_sentences,
    pressure_sentences,
    test_sentences,
)

EVENTS = 40  # that are listed one by one; the others stand in the workbook and in the JSON


class RoadTestSection:
    """The section on the road test; ``series`` is the thinned leakage over it, None where there is none."""

    def __init__(self, names: PrintedNames, series: RoadSeries | None) -> None:
        self.names, self.series = names, series
        self.diagnosis, self.say = names.diagnosis, names.say

    def blocks(self, charts: dict[str, str]) -> Iterable[Block]:
        """Yield what the log says by itself, then the leakage over it."""
        log, road = self.diagnosis.log, self.diagnosis.road
        if log is None:
            return
        say, test = self.say, log.road_test
        yield facts(
            [
                [say("facts.road_test"), test.file],
                [say("facts.duration"), f"{say.number(test.duration, 1)} s"],
                [say("facts.samples"), say.number(test.rows, 0)],
            ]
        )
        yield from (text(each) for each in pressure_sentences(log, say))
        yield self._places(log)
        yield from (text(each) for each in (*test_sentences(log, say), *log_sentences(log, say)))
        checks = check_sentences(self.diagnosis, say)
        if checks:
            yield text(say("findings.check_next"))
            yield {"kind": "list", "items": checks}
        yield from self._events(log)
        if road is not None and self.series is not None:
            yield from self._leakage(road, self.series, charts)

    def _places(self, log: RoadFindings) -> Block:
        """Return main pressure in each gear and state beside what is permitted there."""
        if log.permitted is None:
            return {}
        return printed(place_table(log.permitted, self.say).without("place_source"))

    def _events(self, log: RoadFindings) -> Iterator[Block]:
        events = event_table(log.events[:EVENTS], self.say).without("event_lasts", "event_source")
        yield printed(events)
        more = len(log.events) - EVENTS
        if more > 0:
            yield text(self.say("findings.more_events", count=more), small=True)

    # --- leakage over the log

    def _leakage(self, road: RoadLeakage, series: RoadSeries, charts: dict[str, str]) -> Iterator[Block]:
        say, names = self.say, self.names
        shares = joined(
            f"{self.names.section(name)} {say.percent(share, 0)}"
            for name, share in road.section_shares.items()
            if share is not None
        )
        yield facts(
            [
                [say("facts.gears"), joined(map(str, road.gears))],
                [say("facts.sections"), shares],
            ]
        )
        marked = [row for row in series.instants if row.leads]
        spoken = " ".join(
            say(
                "charts.instant_alt",
                instant=row.label(say),
                share=say.percent(row.instant.share)
                if row.instant.share is not None
                else f"{names.flow(row.instant.leakage)} dm³/min",
                time=say.number(row.instant.time, 1),
            )
            for row in marked
        )
        thinned = ""
        if series.thinned:
            kept = say.number(len(series.columns["time_s"]), 0)
            thinned = say("charts.caption_thinned", kept=kept, samples=say.number(series.samples, 0))
        listed = joined(f"{number} {row.label(say)}" for number, row in enumerate(marked, start=1))
        known = "charts.road_alt" if road.share is not None else "charts.road_alt_no_share"
        yield {
            "kind": "image",
            "file": charts["road"],
            "alt": say(known, instants=spoken),
            "caption": say("charts.caption_road", instants=listed, thinned=thinned).strip(),
        }
        columns = [
            PrintedColumn("", lambda row: str(1 + marked.index(row)) if row in marked else "", side="r"),
            PrintedColumn(say("printed.instant"), lambda row: row.label(say), width=4),
            PrintedColumn(say("printed.time"), lambda row: f"{say.number(row.instant.time, 1)} s", width=2, side="r"),
            PrintedColumn(say("printed.leakage"), lambda row: names.instant_leakage(row.instant), width=2, side="r"),
            PrintedColumn(
                say("printed.capacity"),
                lambda row: names.flow_with_unit(row.instant.pump_capacity),
                width=2,
                side="r",
            ),
            PrintedColumn(say("printed.share"), lambda row: names.instant_share(row.instant), width=2, side="r"),
        ]
        yield table(columns, series.instants)
        notes = [say("texts.sustained", seconds=say.plain(road.extremes.window))]
        notes += [say("texts.lower_bound")] if road.lower_bound else []
        yield text(" ".join(notes), small=True)
