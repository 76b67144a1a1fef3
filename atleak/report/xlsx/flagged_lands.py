"""Write the flagged lands of the summary: those as issued, and live those that are flagged since."""

from __future__ import annotations

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.report.xlsx.book import Book, cell, formula, span
from atleak.report.xlsx.headline import Headline
from atleak.report.xlsx.live import LiveSheets
from atleak.report.xlsx.live_cells import ColumnKey
from atleak.rules import Rule
from atleak.sentence import Name, Sentence
from atleak.verdicts import VERDICTS

OF_A_LAND = (Sentence("component"), Sentence("name"), Sentence("verdict"), Sentence("land"))
_COLUMNS: tuple[ColumnKey, ...] = ("component", "name", "verdict", "land")  # the same on the sheet of lands
ALSO = 8  # rows for lands that are flagged since


class FlaggedLands:
    """The flagged lands of one diagnosis."""

    def __init__(self, book: Book, diagnosis: Diagnosis, live: LiveSheets, headline: Headline) -> None:
        self.book, self.diagnosis, self.live, self.headline = book, diagnosis, live, headline
        shown = [at for at in live.conditions if any(at.projection is each for each in diagnosis.reported)]
        self._values: list[ColumnKey] = ["c_r", "c_m", "wear", *(("share", at.prefix) for at in shown)]

    def write(self, sheet: Worksheet, row: int) -> int:
        """Write how many are flagged now and as issued, both lists; return the next free row."""
        book, flagged = self.book, self.diagnosis.flagged
        book.put(sheet, row, 0, Sentence("Flagged lands as issued, the worst first"), book.bold)
        self._counts(sheet, row)
        headings = [self.live.columns[self.live.column_of[key]].heading for key in self._values]
        row += 1
        if flagged:
            book.headings(sheet, row, [*OF_A_LAND, *headings, Sentence("because, as issued")], lines=4)
            self._issued(sheet, row + 1)
            row += len(flagged) + 1
        else:
            book.put(sheet, row - 1, 1, Sentence("none"))
        rows = min(ALSO, len(self.live.lands) - len(flagged))
        if not rows:
            return row
        book.put(sheet, row, 0, Sentence("Flagged since, by the numbers of this workbook"), book.bold)
        for number in range(1, rows + 1):
            self._since(sheet, row + number, number)
        self._more(sheet, row, rows)
        book.colour_words(sheet, (row + 1, 2), (row + rows, 2), VERDICTS)
        return row + rows + 1

    def _counts(self, sheet: Worksheet, row: int) -> None:
        """Write the number of flagged lands by level, now and as issued, beside one another."""
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
        for number, (now, issued, count, known) in enumerate(pairs):
            column = 2 + 4 * number
            book.put(sheet, row, column, now, book.bold)
            formula(sheet, row, column + 1, count, known, book.form("count", **left))
            book.put(sheet, row, column + 2, issued)
            book.put(sheet, row, column + 3, known, book.form("count", **left))

    def _issued(self, sheet: Worksheet, first: int) -> None:
        book, live, say = self.book, self.live, self.book.say
        for row, flag in enumerate(self.diagnosis.flagged, start=first):
            (component, number), at = flag.key, live.row_of[flag.key]
            book.put(sheet, row, 0, component, book.bold)
            book.put(sheet, row, 1, Name(self.diagnosis.controller.components[component]))
            verdict = cell(at, live.column_of["verdict"], live.sheet)
            formula(sheet, row, 2, verdict, say.signed(flag.verdict), book.bold)
            book.put(sheet, row, 3, number, book.form(align="left"))
            for column, key in enumerate(self._values, start=4):
                content = live.land_cell(flag, key)
                if content.value is not None:
                    address = cell(at, live.column_of[key], live.sheet)
                    formula(sheet, row, column, address, content.value, book.form(content.kind, align="left"))
            if flag.deciding is not None:
                book.put(sheet, row, 4 + len(self._values), self._because(flag.deciding))
        book.colour_words(sheet, (first, 2), (first + len(self.diagnosis.flagged) - 1, 2), VERDICTS)

    def _because(self, rule: Rule) -> Sentence:
        return Sentence("{rule} ({origin})", rule=rule.label, origin=self.book.say.get("origins", rule.origin))

    def _since(self, sheet: Worksheet, row: int, number: int) -> None:
        """Write the land at this place among those flagged since; cells stay empty where there are not so many."""
        book, live = self.book, self.live
        first, here = (cell(at, live.column_of["also"], live.sheet) for at in (1, number))
        largest = f"LARGE({self._column('also')},ROWS({first}:{here.rpartition('!')[2]}))"
        place = f"MATCH({largest},{self._column('also')},0)"
        for column, key in enumerate((*_COLUMNS, *self._values)):
            kind = live.land_cell(live.lands[0], key).kind
            look = {"bold": key in ("component", "verdict"), "align": "left"}
            shown = f'IF({largest}>0,INDEX({self._column(key)},{place}),"")'
            formula(sheet, row, column, shown, "", book.form(kind, **look))

    def _more(self, sheet: Worksheet, row: int, rows: int) -> None:
        """Write how many more lands are flagged since than there are rows."""
        count = f'COUNTIF({self._column("also")},">0")'
        self.book.put(sheet, row, 2, Sentence("further lands flagged since, not listed here"), self.book.bold)
        listed = span(row + 1, row + rows, 0)
        formula(sheet, row, 4, f"MAX({count}-ROWS({listed}),0)", 0, self.book.form("count", align="left"))

    def _column(self, key: ColumnKey) -> str:
        return span(1, len(self.live.lands), self.live.column_of[key], self.live.sheet)
