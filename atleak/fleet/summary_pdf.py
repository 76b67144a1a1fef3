"""Print a fleet's summary as a PDF: the headline first, then each valve body's pairs, wear, temperatures and groups.

PDF/A-2a and PDF/UA-1 where the fonts allow, as every report of atleak; the same summary gives the same bytes.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from atleak.fleet.summary_printed import DETAILED, PrintedBody, rate_columns
from atleak.fleet.summary_words import NAME, TERMS, FleetWords, within
from atleak.fleet.summed import FleetSummary, SummedUnit
from atleak.job.record import Job
from atleak.look import HEADING
from atleak.paper import DEFAULT_PAPER, find_paper
from atleak.report.own_font import OwnFont
from atleak.report.pdf.blocks import Block, PrintedColumn, facts, grouped_table, joined, table, text, with_notes
from atleak.report.pdf.compiling import common_data, compile_pdf
from atleak.report.pictures import write_pictures
from atleak.report.printed_charts.fleet import STACKED, VerdictRow, verdicts_chart
from atleak.verdicts import Verdict
from atleak.views.drawing import shortened
from atleak.wording import wording

UNITS = {1: 20, 2: 16, 3: 10}  # that are listed, by the valve bodies with sections; the workbook lists more
ROWS = 12  # most rows of valve bodies, and of groups, in a table
_UNIT_NAME = 48  # letters of a unit's name
_MESSAGE = 260  # letters of an error's message


def write_summary_pdf(
    summary: FleetSummary,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    units: str = "metric",
    font: OwnFont | None = None,
    letterhead: Job | None = None,
) -> bytes:
    """Return the bytes of the PDF.

    Parameters
    ----------
    summary
        the fleet in numbers; nothing is computed from it.
    language
        one of `atleak.wording.languages`.
    paper
        one of `atleak.paper.PAPERS`.
    units
        one of `atleak.unit_systems.SYSTEMS`.
    font
        for characters that the bundled fonts lack.
    letterhead
        a job record whose workshop stands at the head, with its logo; nothing else of it is printed.

    Raises
    ------
    InputError
        if the language, the paper or the system of units is unknown, or the logo cannot be read.

    Notes
    -----
    The first `DETAILED` valve bodies have sections of their own, the more of them the shorter; all are in the table of
    verdicts, and in the workbook.
    """
    say, size = wording(language, units), find_paper(paper)
    printed = _Printed(FleetWords(summary, say))
    head = Job() if letterhead is None else letterhead.letterhead
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        data = {
            **common_data(
                say("fleet_summary.title"),
                say("fleet_summary.subject"),
                head,
                size,
                say,
                write_pictures(head, Path(folder)),
            ),
            **printed.data(),
        }
        return compile_pdf("fleet", Path(folder), data, None, say, font)


class _Printed:
    """The content of the PDF, in one language."""

    def __init__(self, words: FleetWords) -> None:
        self.words, self.say, self.summary = words, words.say, words.summary
        self.charts: dict[str, str] = {}

    @property
    def _detailed(self) -> int:
        """Return how many valve bodies have sections of their own, or one without any valve body."""
        return max(min(len(self.summary.bodies), DETAILED), 1)

    def data(self) -> dict[str, Any]:
        """Return what the template places."""
        sections = [section for section in self._sections() if section["blocks"] or section["level"] == 1]
        name = Path(self.summary.folder).name
        return {
            "name": joined((self.say("fleet_summary.title"), name), " · "),
            "running": shortened(name, 60),
            "subtitle": self.say("fleet_summary.subtitle", folder=self.summary.folder),
            "headline": self.words.headline(),
            "findings": " ".join(self.words.findings()),
            "facts": self._facts(),
            "ground": HEADING,
            "sections": sections,
            "charts": self.charts,
        }

    def _facts(self) -> list[list[str]]:
        say, summary = self.say, self.summary
        bodies = [self.words.body(body.controller) for body in summary.bodies]
        rows = [
            ("units", say.number(summary.counts.units, 0)),
            ("judged", say.number(summary.counts.judged, 0)),
            ("visits", say.number(summary.visits, 0)),
            ("body", bodies[0]) if len(bodies) == 1 else ("bodies", say.number(len(bodies), 0)),
            ("failed", say.number(sum(each.count for each in summary.errors), 0)),
            ("by", self.words.heading() or say("fleet_summary.by_nothing")),
        ]
        return [[say(f"fleet_summary.fact_{name}"), value] for name, value in rows]

    def _section(self, name: str, blocks: Iterator[Block], level: int = 2) -> dict[str, Any]:
        made = [block for block in with_notes(blocks) if block]
        return {"title": self.say(f"fleet_summary.section_{name}"), "level": level, "blocks": made}

    def _sections(self) -> Iterator[dict[str, Any]]:
        yield self._section("verdicts", self._verdicts())
        yield self._section("know", self._know())
        bodies = self.summary.bodies
        for number, body in enumerate(bodies[:DETAILED], start=1):
            printed = PrintedBody(self.words, body, number, self._detailed)
            if len(bodies) > 1:
                yield {"title": self.words.body(body.controller), "level": 1, "blocks": [*printed.intro()]}
            for name, blocks in printed.sections():
                yield self._section(name, blocks)
            self.charts |= printed.charts
        if len(bodies) > 1:
            yield self._section("units_and_files", iter(()), level=1)
        yield self._section("worst", self._worst())
        yield self._section("errors", self._errors())
        yield self._section("rests_on", self._rests_on(), level=1 if len(bodies) > 1 else 2)

    # --- verdicts

    def _verdicts(self) -> Iterator[Block]:
        say, summary = self.say, self.summary
        if not summary.counts.units:
            yield text(say("fleet_summary.no_units"))
            return
        rows = [(say("fleet_summary.all_units"), summary.counts)]
        bodies = summary.bodies[:ROWS] if len(summary.bodies) > 1 else ()
        rows += [(self.words.body(body.controller), body.counts) for body in bodies]
        self.charts["verdicts"] = verdicts_chart(
            [VerdictRow(name, counts.verdicts, counts.ok_in_part) for name, counts in rows],
            say("fleet_summary.chart_verdicts"),
            say,
        )
        counted = joined(
            f"{say.level(verdict)} {say.number(summary.counts.verdicts[verdict], 0)}" for verdict in STACKED
        )
        yield {
            "kind": "image",
            "file": "verdicts",
            "alt": say("fleet_summary.alt_verdicts", counted=counted),
            "caption": say("fleet_summary.caption_verdicts"),
            "legend": [[verdict, say.level(verdict)] for verdict in STACKED],
        }
        columns = [
            PrintedColumn(say("fleet_summary.of_which"), lambda row: row[0], width=1),
            PrintedColumn(say("fleet_columns.units"), lambda row: say.number(row[1].units, 0), side="r"),
            PrintedColumn(say("fleet_columns.judged"), lambda row: say.number(row[1].judged, 0), side="r"),
            *rate_columns(self.words, lambda row: row[1]),
        ]
        yield table(columns, rows)
        left = len(summary.bodies) - ROWS
        said = [say("fleet_summary.note_rates")]
        if left > 0:
            said.append(say("fleet_summary.more_bodies", count=left))
        yield text(" ".join(said), small=True)

    def _know(self) -> Iterator[Block]:
        summary = self.summary
        items = self.words.messages(summary.messages)
        if len(summary.bodies) == 1:
            items += self.words.messages(summary.bodies[0].messages)
        beyond = summary.bodies[DETAILED:]
        if beyond:
            items.append(self.say("fleet_summary.beyond", count=len(beyond), detailed=DETAILED))
        if items:
            yield {"kind": "list", "items": items}

    # --- units and files

    def _worst(self) -> Iterator[Block]:
        say, summary = self.say, self.summary
        listed = [unit for unit in summary.worst if unit.verdict.flagged][: UNITS[self._detailed]]
        if not listed:
            yield text(say("fleet_summary.none_flagged"))
            return
        columns = [
            PrintedColumn(say("fleet_columns.name"), lambda unit: within(unit.name, _UNIT_NAME), width=4),
            PrintedColumn(say("fleet_columns.told_by"), _told_by, width=3),
            PrintedColumn(self.words.heading(), lambda unit: within(unit.label or "", NAME), width=2),
            PrintedColumn(
                say("fleet_columns.mileage"),
                lambda unit: say.value(unit.mileage_km, "distance", 0),
                say.unit("distance"),
                side="r",
            ),
            PrintedColumn(
                say("fleet_columns.verdict"), lambda unit: {"sign": unit.verdict, "text": say.level(unit.verdict)}
            ),
            PrintedColumn(say("fleet_columns.decided_by"), self.words.decided_by, width=4),
            PrintedColumn(say("fleet_columns.lands_past"), lambda unit: say.number(unit.lands_past, 0), side="r"),
        ]
        yield table(columns, listed, empty=False)
        said = [say("fleet_summary.note_worst")]
        flagged = sum(summary.counts.verdicts[verdict] for verdict in Verdict if verdict.flagged)
        if flagged > len(listed):
            said.append(say("fleet_summary.more_units", count=say.number(flagged - len(listed), 0)))
        yield text(" ".join(said), small=True)

    def _errors(self) -> Iterator[Block]:
        say, summary = self.say, self.summary
        if not summary.errors:
            yield text(say("fleet_summary.no_errors"))
            return
        columns = [
            PrintedColumn(say("fleet_columns.name"), lambda row: within(row[0], _UNIT_NAME), width=1),
            PrintedColumn(say("fleet_columns.message"), lambda row: shortened(row[1], _MESSAGE), width=2),
        ]
        titles = [f"{self.words.kind_of_error(each)}: {say.number(each.count, 0)}" for each in summary.errors]
        yield grouped_table(columns, zip(titles, (each.first for each in summary.errors), strict=True))
        yield text(say("fleet_summary.note_errors"), small=True)

    def _rests_on(self) -> Iterator[Block]:
        yield facts([(self.say(f"fleet_terms.{name}"), self.say(f"fleet_meaning.{name}")) for name in TERMS])


def _told_by(unit: SummedUnit) -> str:
    """Return the number by which people tell a unit: of its transmission, its vehicle or its job."""
    return unit.serial or unit.vin or unit.number or ""
