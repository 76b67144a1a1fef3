"""Build the section on the road test: what the log says by itself, what to check next, and the leakage over it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from atleak.engine.road_leakage import RoadLeakage
from atleak.report.pdf.blocks import Block, bullets, joined, named_facts, picture, printed, text
from atleak.report.pdf.printed_names import Part, PrintedNames
from atleak.report.printed_charts import road_chart
from atleak.road_findings import RoadFindings
from atleak.views.log_rows import event_table, place_table
from atleak.views.road_instants import RoadInstant, instant_table
from atleak.views.road_series import RoadSeries
from atleak.views.road_words import check_sentences, log_sentences, pressure_sentences, test_sentences
from atleak.views.table import Column
from atleak.workshop_units import DM3_MIN, PERCENT

EVENTS = 40  # that are listed one by one; the others stand in the workbook and in the JSON


class RoadTestSection(Part):
    """The section on the road test; ``series`` is the thinned leakage over it, None where there is none."""

    def __init__(self, names: PrintedNames, series: RoadSeries | None) -> None:
        super().__init__(names)
        self.series = series

    def blocks(self) -> Iterable[Block]:
        """Yield what the log says by itself, then the leakage over it."""
        log, road, say = self.diagnosis.log, self.diagnosis.road, self.say
        if log is None:
            return
        test = log.road_test
        duration, samples = f"{say.number(test.duration, 1)} s", say.number(test.rows, 0)
        yield named_facts("facts", say, road_test=test.file, duration=duration, samples=samples)
        yield from map(text, pressure_sentences(log, say))
        if log.permitted is not None:
            yield printed(place_table(log.permitted, say).without("place_source"))
        yield from map(text, (*test_sentences(log, say), *log_sentences(log, say)))
        checks = check_sentences(self.diagnosis, say)
        if checks:
            yield text(say("findings.check_next"))
            yield bullets(checks)
        yield from self._events(log)
        if road is not None and self.series is not None:
            yield from self._leakage(road, self.series)

    def _events(self, log: RoadFindings) -> Iterator[Block]:
        yield printed(event_table(log.events[:EVENTS], self.say).without("event_lasts", "event_source"))
        more = len(log.events) - EVENTS
        if more > 0:
            yield text(self.say("findings.more_events", count=more), small=True)

    # --- leakage over the log

    def _leakage(self, road: RoadLeakage, series: RoadSeries) -> Iterator[Block]:
        say, names = self.say, self.names
        shares = joined(
            f"{names.section(name)} {say.percent(share, 0)}"
            for name, share in road.section_shares.items()
            if share is not None
        )
        yield named_facts("facts", say, gears=joined(map(str, road.gears)), sections=shares)
        yield self._drawing(road, series)
        numbers = {row.label(say): number for number, row in enumerate(_marked(series), start=1)}
        number = Column("", digits=0, words="", of=lambda row: numbers.get(row["instant"]))
        table = instant_table(road, self.diagnosis.uncertainty, say)
        yield printed(replace(table, columns=(number, *table.columns)))
        notes = [say("texts.sustained", seconds=say.plain(road.extremes.window))]
        notes += [say("texts.lower_bound")] if road.lower_bound else []
        yield text(" ".join(notes), small=True)

    def _drawing(self, road: RoadLeakage, series: RoadSeries) -> Block:
        """Return the leakage over the log with the instants that are read first marked by numbers."""
        say = self.say
        marked = _marked(series)
        points = [
            (at.time, at.leakage * DM3_MIN, None if at.share is None else at.share * PERCENT)
            for at in (row.instant for row in marked)
        ]
        bands = [(band, limit * PERCENT) for band, limit in self.diagnosis.limits.fixed_bands]
        spoken = " ".join(
            say(
                "charts.instant_alt",
                instant=row.label(say),
                share=say.quantity(leakage, "flow", 2) if share is None else say.number(share, 1) + "\u00a0%",
                time=say.number(time, 1),
            )
            for row, (time, leakage, share) in zip(marked, points, strict=True)
        )
        thinned = ""
        if series.thinned:
            kept = say.number(len(series.columns["time_s"]), 0)
            thinned = say("charts.caption_thinned", kept=kept, samples=say.number(series.samples, 0))
        listed = joined(f"{number} {row.label(say)}" for number, row in enumerate(marked, start=1))
        return picture(
            road_chart(series, points, bands, say),
            say("charts.road_alt" if road.share is not None else "charts.road_alt_no_share", instants=spoken),
            say("charts.caption_road", instants=listed, thinned=thinned).strip(),
        )


def _marked(series: RoadSeries) -> list[RoadInstant]:
    return [row for row in series.instants if row.leads]
