"""Write a page of a sheet: texts that wrap, names with their values, tables and sections, one below the other.

Every text wraps in its cell, or in as many cells as it may run over, and each row is as high as its texts need: not
every program fits rows to them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.common.verdicts import BANDS, VERDICTS
from atleak.report.sheets.paging import LINE_OF_A_BOOK, row_height
from atleak.report.tables.table import VERDICT, Column, Facts, Points, Section, Table, Text
from atleak.report.xlsx.book import CELL_LIMIT, HIGHEST_ROW, ReportBook, formula
from atleak.report.xlsx.live_sheet import LiveCell, write_cell

_LEAST, _MOST, _ROOM = 13, 48, 205  # [characters] width of a column, and of all of them
_ALONE = 120  # the same where no table stands on the page


class SheetPage:
    """A sheet whose texts wrap.

    Parameters
    ----------
    widths
        of its columns [characters]; a text that stands alone runs over all of them.
    """

    def __init__(self, book: ReportBook, sheet: Worksheet, widths: Iterable[float]) -> None:
        self.book, self.sheet, self.widths = book, sheet, tuple(widths)
        self.last = len(self.widths) - 1
        for column, width in enumerate(self.widths):
            sheet.set_column(column, column, width)
        self._heights: dict[int, float] = {}

    def lines(self, rows: int) -> float:
        """Return how high the first rows are, in rows of one line."""
        return sum(self._heights.get(row, LINE_OF_A_BOOK) for row in range(rows)) / LINE_OF_A_BOOK

    def text(self, row: int, column: int, text: Any, last: int | None = None, **look: Any) -> None:
        """Write a text that wraps, from a column to the last one that is given."""
        form = self._room(row, column, self.book.words(text), last, **look)
        self.book.put(self.sheet, row, column, text, form)

    def put(self, row: int, column: int, content: Any, last: int | None = None) -> None:
        """Write what a cell holds: words wrap, numbers grow smaller where words beside them need the room."""
        known = content if isinstance(content, LiveCell) else LiveCell("plain", content)
        if not isinstance(known.value, str):
            look = {"align": "left", "shrink": True}
            write_cell(
                self.book, self.sheet, row, column, LiveCell(known.kind, known.value, known.formula, look, known.of)
            )
        elif known.formula is None:
            self.text(row, column, known.value, last, **known.look)
        else:
            self.formula(row, column, known.formula, self.book.words(known.value), last, **known.look)

    def table(self, row: int, headings: Sequence[Any], rows: Iterable[Sequence[Any]]) -> int:
        """Write headings and rows of what cells hold, the last column as far as the page goes; return the next row."""
        self.headings(row, headings)
        for cells in rows:
            row += 1
            for column, content in enumerate(cells):
                self.put(row, column, content, self.last if column == len(headings) - 1 else None)
        return row + 1

    def across(self, row: int, text: Any, **look: Any) -> int:
        """Write a text that stands alone, over all columns; return the next row."""
        self.text(row, 0, text, self.last, **look)
        return row + 1

    def formula(self, row: int, column: int, text: str, value: str, last: int | None = None, **look: Any) -> None:
        """Write a formula that gives a text, in a cell as high as its present value needs."""
        formula(self.sheet, row, column, text, value, self._room(row, column, value, last, **look))

    def number(self, kind: str, of: str | None) -> Format:
        """Return the format of a number, which grows smaller where words beside it need the room."""
        return self.book.form(kind, of, align="left", shrink=True)

    def headings(self, row: int, names: Sequence[Any]) -> None:
        """Write a row of headings, the last one as far as the page goes."""
        for column, name in enumerate(names):
            last = self.last if column == len(names) - 1 else None
            self._merged(row, column, last, self.book.heading)
            self.book.put(self.sheet, row, column, name, self.book.heading)
            self._grow(row, [(self.book.words(name), self._width(column, last))], bold=True)

    def section(self, row: int, section: Section) -> int:
        """Write a title with the sentences, lists and tables below it; return the next free row."""
        row = self.across(row, section.title, bold=True)
        for part in section.parts:
            if isinstance(part, Table):
                row = self.printed(row, part) + 1
            elif isinstance(part, Facts):
                row = self.pairs(row, part.rows)
            for words in (part.words,) if isinstance(part, Text) else part.items if isinstance(part, Points) else ():
                row = self.across(row, words)
        return row + 1

    def printed(self, row: int, content: Table) -> int:
        """Write a table, numbers as exact as they are, verdicts in their colours; return the next row."""
        say, first = content.say, row + 1

        def cell(column: Column, item: Any) -> Any:
            value, level = column.cell(item, say), column.judged(item).level
            if level and column.kind == VERDICT:
                return say.signed(level)
            if isinstance(value, bool) or not isinstance(value, int | float):
                return None if value is None else column.text(item, say)
            places = column.places(say) if column.is_number else 0
            return LiveCell("#,##0" + ("." + "0" * places if places else ""), value)

        row = self.table(
            row, content.headings, ([cell(column, item) for column in content.columns] for item in content.rows)
        )
        for number, column in enumerate(content.columns):
            if column.kind == VERDICT:
                self.book.colour_words(self.sheet, (first, number), (row - 1, number), (*VERDICTS, *BANDS))
        return row

    def pairs(self, row: int, pairs: Iterable[tuple[str, Any]]) -> int:
        """Write names and values below one another, without unknown and empty values; return the next free row."""
        for name, value in pairs:
            if value is None or value in ("", [], ()):
                continue
            self.text(row, 0, name, bold=True)
            if isinstance(value, str):
                text = self.book.words(value)
                for start in range(0, len(text), CELL_LIMIT):  # continued below where one cell cannot hold it
                    self.text(row, 1, text[start : start + CELL_LIMIT], self.last)
                    row += 1
            else:
                self.book.put(self.sheet, row, 1, value, self.book.form(align="left"))
                row += 1
        return row

    def _room(self, row: int, column: int, text: str, last: int | None, **look: Any) -> Format:
        form = self.book.form(**{"align": "left", "text_wrap": True, **look})
        self._merged(row, column, last, form)
        self._grow(row, [(text, self._width(column, last))], bold=bool(look.get("bold")))
        return form

    def _merged(self, row: int, column: int, last: int | None, form: Format) -> None:
        if last is not None and last > column:
            self.sheet.merge_range(row, column, row, last, "", form)

    def _width(self, column: int, last: int | None) -> float:
        return sum(self.widths[column : (column if last is None else last) + 1])

    def _grow(self, row: int, cells: Iterable[tuple[str, float]], *, bold: bool) -> None:
        height = min(row_height(cells, bold=bold), HIGHEST_ROW)
        if height > self._heights.get(row, LINE_OF_A_BOOK):
            self._heights[row] = height
            self.sheet.set_row(row, height)


def widths_for(tables: Iterable[Table]) -> list[int]:
    """Return the widths [characters] of columns for tables below one another: as wide as words and page allow."""
    longest: list[int] = []
    for table in tables:
        longest += [_LEAST] * (len(table.columns) - len(longest))
        for number, column in enumerate(table.columns):
            letters = max((len(column.text(item, table.say)) for item in table.rows), default=0)
            longest[number] = max(longest[number], letters + letters // 8 + 2)
    tried = ([min(width, most) for width in longest] for most in range(_MOST, _LEAST, -1))
    return next((widths for widths in tried if sum(widths) <= _ROOM), [_LEAST] * len(longest))


def write_sections(book: ReportBook, sheet: Worksheet, sections: Sequence[Section]) -> None:
    """Write sections below one another, on a page as wide as their tables."""
    tables = (part for section in sections for part in section.parts if isinstance(part, Table))
    page, row = SheetPage(book, sheet, widths_for(tables) or [_ALONE]), 0
    for section in sections:
        row = page.section(row, section)
