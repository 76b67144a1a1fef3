"""Lay out the summary: every text wraps in its cell, each row is as high as its texts need, one page wide in print."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.report.sheets.paging import LINE_OF_A_BOOK, row_height
from atleak.report.tables.section import Facts, Points, Section, Text
from atleak.report.tables.table import Column, Table
from atleak.report.xlsx.book import ReportBook, formula
from atleak.report.xlsx.live_sheet import LiveCell, write_cell

_LABELS = 25, 42  # [characters] least and most width of the first column
_NAMES, _VERDICTS, _OTHERS = 22, 15, 12  # width of the second, the third and any other
_ROOM = 190  # of all columns, which prints at three quarters of its size on A4
_SIDES, _TOP = 0.3, 0.5  # [in] margins
_HIGHEST = 409.0  # [pt] that Excel allows


class SummaryPage:
    """The sheet of the summary with its columns.

    Parameters
    ----------
    columns
        how many the widest of its tables has; a text that stands alone runs over all of them.
    """

    def __init__(self, book: ReportBook, sheet: Worksheet, columns: int) -> None:
        self.book, self.sheet, self.last = book, sheet, columns - 1
        others = _NAMES, _VERDICTS, *[_OTHERS] * (columns - 3)
        least, most = _LABELS
        self.widths = (min(max(_ROOM - sum(others), least), most), *others)
        for column, width in enumerate(self.widths):
            sheet.set_column(column, column, width)
        sheet.set_margins(left=_SIDES, right=_SIDES, top=_TOP)
        self._heights: dict[int, float] = {}

    def text(self, row: int, column: int, text: Any, last: int | None = None, **look: Any) -> None:
        """Write a text that wraps, from a column to the last one that is given."""
        form = self._room(row, column, self.book.words(text), last, **look)
        self.book.put(self.sheet, row, column, text, form)

    def put(self, row: int, column: int, content: Any, last: int | None = None) -> None:
        """Write what a cell holds: words wrap, numbers grow smaller where words beside them need the room."""
        known = content if isinstance(content, LiveCell) else LiveCell("plain", content)
        if not isinstance(known.value, str):
            look = {"align": "left", "shrink": True}
            write_cell(self.book, self.sheet, row, column, LiveCell(known.kind, known.value, known.formula, look))
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

    def number(self, kind: str) -> Format:
        """Return the format of a number, which grows smaller where words beside it need the room."""
        return self.book.form(kind, align="left", shrink=True)

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
        """Write a table; return the next row."""

        def cell(column: Column, item: Any) -> Any:
            value = column.cell(item, content.say)
            if not isinstance(value, float):
                return column.text(item, content.say)
            places = column.places(content.say)
            return LiveCell("#,##0" + ("." + "0" * places if places else ""), value)

        rows = ([cell(column, item) for column in content.columns] for item in content.rows)
        return self.table(row, content.headings, rows)

    def pairs(self, row: int, pairs: Iterable[tuple[str, Any]]) -> int:
        """Write names and values below one another, without unknown and empty values; return the next free row."""
        for name, value in pairs:
            if value is None or value in ("", [], ()):
                continue
            self.text(row, 0, name, bold=True)
            if isinstance(value, str):
                self.text(row, 1, value, self.last)
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
        height = min(row_height(cells, bold=bold, line=LINE_OF_A_BOOK), _HIGHEST)
        if height > self._heights.get(row, LINE_OF_A_BOOK):
            self._heights[row] = height
            self.sheet.set_row(row, height)
