"""Write the flagged lands of the summary: those as issued, and live those that are flagged since."""

from __future__ import annotations

from typing import Any

from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.xlsx.book import Book, formula, span
from atleak.report.xlsx.headline import Headline
from atleak.report.xlsx.live import LiveSheets
from atleak.report.xlsx.live_cells import Cell, ColumnKey
from atleak.report.xlsx.summary_page import SummaryPage
from atleak.sentence import Name, Sentence
from atleak.verdicts import VERDICTS

OF_A_LAND = (Sentence("component"), Sentence("name"), Sentence("verdict"), Sentence("land"))
_COLUMNS: tuple[ColumnKey, ...] = ("component", "name", "verdict", "land")  # the same on the sheet of lands
_BOLD = {"bold": True}
ALSO = 8  # rows for lands that are flagged since


class FlaggedLands:
    """The flagged lands of one diagnosis."""

    def __init__(self, book: Book, diagnosis: Diagnosis, live: LiveSheets, headline: Headline) -> None:
        self.book, self.diagnosis, self.live, self.headline = book, diagnosis, live, headline
        shown = [at for at in live.conditions if any(at.projection is each for each in diagnosis.reported)]
        self._values: list[ColumnKey] = ["c_r", "c_m", "wear", *(("share", at.prefix) for at in shown)]

    @property
    def columns(self) -> int:
        """Return how many columns their list has; its last takes the room of three."""
        return len(OF_A_LAND) + len(self._values) + 3

    def write(self, page: SummaryPage, row: int) -> int:
        """Write how many are flagged now and as issued, both lists; return the next free row."""
        flagged = self.diagnosis.flagged
        row = page.across(row, Sentence("Flagged lands as issued, the worst first"), bold=True)
        row = self._counts(page, row)
        columns = self.live.sheet.columns
        headings = [columns[self.live.sheet.place[key]].heading for key in self._values]
        if flagged:
            first, names = row + 1, [*OF_A_LAND, *headings, Sentence("because, as issued")]
            row = page.table(row, names, map(self._issued, flagged))
            self.book.colour_words(page.sheet, (first, 2), (row - 1, 2), VERDICTS)
        else:
            row = page.across(row, Sentence("none"))
        rows = min(ALSO, len(self.live.lands) - len(flagged))
        if not rows:
            return row
        title = page.across(row, Sentence("Flagged since, by the numbers of this workbook"), bold=True) - 1
        for number in range(1, rows + 1):
            self._since(page, row + number, number)
        self._more(page, title, rows)
        self.book.colour_words(page.sheet, (row + 1, 2), (row + rows, 2), VERDICTS)
        return row + rows + 2

    def _counts(self, page: SummaryPage, row: int) -> int:
        """Write the number of flagged lands by level, now and as issued, beside one another; return the next row."""
        book, say, left = self.book, self.book.say, {"align": "left"}
        lands = self.diagnosis.lands
        pairs = [
            (Sentence("flagged now"), Sentence("flagged as issued"), self.headline.flagged, len(self.diagnosis.flagged))
        ]
        pairs += [
            (
                Sentence("{level} now", level=say.signed(level)),
                Sentence("{level} as issued", level=say.signed(level)),
                count,
                sum(land.verdict == level for land in lands),
            )
            for level, count in self.headline.counts.items()
        ]
        for at, (now, issued, count, known) in enumerate(pairs, start=row):
            page.text(at, 0, now, bold=True)
            formula(page.sheet, at, 1, count, known, book.form("count", **left))
            page.text(at, 2, issued)
            book.put(page.sheet, at, 3, known, book.form("count", **left))
        return row + len(pairs)

    def _issued(self, flag: LandDiagnosis) -> list[Any]:
        live, rule, (component, number), at = self.live, flag.deciding, flag.key, self.live.row_of[flag.key]
        values = {key: live.land_cell(flag, key) for key in self._values}
        origin = None if rule is None else self.book.say.get("origins", rule.origin)
        return [
            Cell("plain", component, look=_BOLD),
            Name(self.diagnosis.controller.components[component]),
            Cell("plain", self.book.say.signed(flag.verdict), live.sheet.cell(at, "verdict"), _BOLD),
            number,
            *(Cell(each.kind, each.value, live.sheet.cell(at, key)) for key, each in values.items()),
            None if rule is None else Sentence("{rule} ({origin})", rule=rule.label, origin=origin),
        ]

    def _since(self, page: SummaryPage, row: int, number: int) -> None:
        """Write the land at this place among those flagged since; cells stay empty where there are not so many."""
        live = self.live
        first, here = (live.sheet.cell(at, "also") for at in (1, number))
        largest = f"LARGE({self._column('also')},ROWS({first}:{here.rpartition('!')[2]}))"
        place = f"MATCH({largest},{self._column('also')},0)"
        for column, key in enumerate((*_COLUMNS, *self._values)):
            kind = live.land_cell(live.lands[0], key).kind
            shown = f'IF({largest}>0,INDEX({self._column(key)},{place}),"")'
            if key in _COLUMNS:
                page.formula(row, column, shown, "", bold=key in ("component", "verdict"))
            else:
                formula(page.sheet, row, column, shown, "", page.number(kind))

    def _more(self, page: SummaryPage, title: int, rows: int) -> None:
        """Write below their list how many more lands are flagged since than it has rows."""
        row, count = title + rows + 1, f'COUNTIF({self._column("also")},">0")'
        page.text(row, 0, Sentence("further lands flagged since, not listed here"), bold=True)
        listed = span(title + 1, title + rows, 0)
        left = self.book.form("count", align="left")
        formula(page.sheet, row, 1, f"MAX({count}-ROWS({listed}),0)", 0, left)

    def _column(self, key: ColumnKey) -> str:
        return self.live.sheet.whole(key)
