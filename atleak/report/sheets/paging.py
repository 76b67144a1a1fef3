"""Lay a measuring sheet's tabs out on paper: rows high enough for a pencil, no block of rows cut by a page's end.

Not every program fits rows to their texts, nor has every one the same font: heights are computed here.
"""

from __future__ import annotations

import datetime as dt
import io
import math
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.common.seals import PROPERTY, SealedKind, sealed, unsealed
from atleak.common.sentences import Sentence
from atleak.common.style import DEFAULT_PAPER, PAPERS
from atleak.common.wording import Wording
from atleak.measurements.own_forms import OwnForm

_PIXEL = 0.75  # [pt] to which workbooks round a row's height
ROW = 7.0  # [mm] least height of a row on paper, to write in by hand: choice of this project
_UPRIGHT, _ACROSS = (210.0, 279.4), (279.4, 210.0)  # [mm] of A4 and Letter the lesser side: a layout fits on both
_LEAST_SCALE = 60  # [%] of letters of 10 pt
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.3, 0.3, 0.3, 0.45  # [in] margins
_INCH, _POINT = 25.4, 25.4 / 72.0  # [mm]
_PIXELS = 96.0  # of an inch
_SPARE = 0.92  # of the width that is used: programs round the widths of columns, each its own way
_LINE = 13.5  # [pt] height of a line of text
LINE_OF_A_BOOK = 15.0  # [pt] height of a row unless another is set
_FULL, _FULL_BOLD = 0.9, 0.8  # of a column's characters: without the sheet's font a program takes a wider one

LETTERS = 10  # [pt]
HEADER = 5
"""Row of the headings of a table on a tab, from 0."""
_BOLD_BESIDE = 2  # characters beside the longest word of a heading

RowBlock = Sequence["RowBlock"] | int  # blocks within a block; at the end a number of rows


UNDATED = dt.datetime(2000, 1, 1)  # the creation of a workbook without a date: the same content gives the same bytes


def workbook(
    write: Callable[[xlsxwriter.Workbook], None],
    title: str,
    *,
    mark: SealedKind | None = None,
    created: dt.datetime = UNDATED,
    properties: Mapping[str, str] | None = None,
) -> bytes:
    """Return the bytes of a workbook: texts stay texts, nothing that a user typed becomes a formula or a link.

    Parameters
    ----------
    write
        writes its sheets.
    mark
        what it is known by as made by atleak, so that it may be written again; None for one that is filled in.
    properties
        further properties of the document.
    """
    target = io.BytesIO()
    as_texts = dict.fromkeys(("strings_to_formulas", "strings_to_urls", "strings_to_numbers"), False)
    font = {"default_format_properties": {"font_name": "Arial", "font_size": LETTERS}}  # as wide in every program
    with xlsxwriter.Workbook(target, {"in_memory": True, **as_texts, **font}) as book:
        book.set_properties({"title": title, "created": created, **(properties or {})})
        if mark is not None:
            book.set_custom_property(PROPERTY, unsealed(mark))
        write(book)
    return target.getvalue() if mark is None else sealed(target.getvalue())


def put(sheet: Worksheet, row: int, column: int, value: str | float | None, form: Format) -> None:
    """Write a value in its cell: numbers as such, words as words, nothing as a blank to fill in."""
    if value is None or value == "":
        sheet.write_blank(row, column, None, form)
    elif isinstance(value, str) and not (value.isdecimal() and str(int(value)) == value):
        sheet.write_string(row, column, value, form)
    else:
        sheet.write_number(row, column, float(value), form)


def only(validate: str, title: Sentence, message: Sentence, say: Wording, **how: Any) -> dict[str, Any]:
    """Return what a cell takes, and what is said where anything else is typed, as xlsxwriter wants it."""
    said = say.sentence(message)[:255]  # characters that a spreadsheet program takes
    return {"validate": validate, **how, "error_title": say.sentence(title), "error_message": said}


@dataclass(frozen=True)
class Paging:
    """How the sheet is shrunk to a page's width, and what that makes of heights.

    Parameters
    ----------
    widths
        of the columns, in characters.
    above
        heights of the rows over the first one to fill in [pt]; the last of them is repeated on every page.
    """

    widths: tuple[int, ...]
    above: tuple[float, ...] = ()

    @property
    def page(self) -> tuple[float, float]:
        """Return width and height of the paper [mm]: upright, unless letters became too small."""
        return _UPRIGHT if self._scale(_UPRIGHT) >= _LEAST_SCALE else _ACROSS

    @property
    def scale(self) -> int:
        """Return the scale of printing [%] at which all columns stand side by side."""
        return self._scale(self.page)

    def _scale(self, page: tuple[float, float]) -> int:
        drawn = sum(7 * width + 5 for width in self.widths) / _PIXELS * _INCH
        return int(min(100.0, 100.0 * _SPARE * (page[0] - (_LEFT + _RIGHT) * _INCH) / drawn))

    @property
    def row_height(self) -> float:
        """Return the height of a row [pt], at least `ROW` when printed, in whole pixels as workbooks keep it."""
        return math.ceil(ROW / _POINT * 100.0 / self.scale / _PIXEL) * _PIXEL

    def set_up(self, sheet: Worksheet, say: Wording) -> None:
        """Give columns their widths, and have the sheet printed at this scale."""
        for column, width in enumerate(self.widths):
            sheet.set_column(column, column, width)
        if self.page == _ACROSS:
            sheet.set_landscape()
        sheet.set_paper(PAPERS[DEFAULT_PAPER if say.unit("length") == "mm" else "letter"].excel)
        sheet.set_print_scale(self.scale)
        sheet.set_margins(left=_LEFT, right=_RIGHT, top=_TOP, bottom=_BOTTOM)

    def breaks(self, blocks: Sequence[RowBlock]) -> list[int]:
        """Return the rows before which a page begins, counted from the first row to fill in.

        A block that fits on a page stands on one; of a larger one its own blocks do. The first page has the head, so
        that of its first block too the own blocks may have to.
        """
        found: list[int] = []
        used = self._printed(sum(self.above))
        blocks = list(blocks)
        while blocks and not isinstance(blocks[0], int) and used + self._height(blocks[0]) > self._room:
            blocks[:1] = blocks[0]
        for row, rows in self._pieces(blocks):
            height = self._printed(rows * self.row_height)
            if row and used + height > self._room:
                found.append(row)
                used = self._printed(self.above[-1])
            used += height
        return found

    def _pieces(self, blocks: Sequence[RowBlock]) -> Iterator[tuple[int, int]]:
        """Yield first row and number of rows of what must not be cut."""
        row = 0
        for block in blocks:
            rows = _rows_of(block)
            fits = self._printed(self.above[-1] + rows * self.row_height) <= self._room
            if fits or isinstance(block, int):
                yield row, rows
            else:
                yield from ((row + first, many) for first, many in self._pieces(block))
            row += rows

    def _height(self, block: RowBlock) -> float:
        return self._printed(_rows_of(block) * self.row_height)

    def _printed(self, points: float) -> float:
        """Return a height on paper [mm]."""
        return points * _POINT * self.scale / 100.0

    @property
    def _room(self) -> float:
        """Return the height of a page between its margins [mm]."""
        return self.page[1] - (_TOP + _BOTTOM) * _INCH


@dataclass(frozen=True)
class Tab:
    """A tab of a measuring sheet that is being written, with the workbook's formats and the reader's words."""

    sheet: Worksheet
    formats: Mapping[str, Format]
    say: Wording


class PagedTable:
    """A table on a tab, below a title and what to do; its headings stand in row `HEADER`.

    Parameters
    ----------
    tab
        on which nothing is written yet.
    form
        that the tab is, by whose mark it is known when it is read.
    headings
        as the reader has them.
    widths
        of the columns at least, in characters; no word of a heading is broken.
    """

    def __init__(self, tab: Tab, form: OwnForm, headings: Sequence[str], widths: Iterable[int]) -> None:
        self._tab, self._form, self._headings = tab, form, headings
        self.widths = tuple(
            width_for([said], width, beside=_BOLD_BESIDE) for said, width in zip(headings, widths, strict=True)
        )
        self.row_height = Paging(self.widths).row_height

    def write(self, above: Iterable[Sentence], last: int, frozen: int) -> None:
        """Write title and what to do as wide as the table, where no page cuts them off, and the headings."""
        sheet, formats = self._tab.sheet, self._tab.formats
        Paging(self.widths).set_up(sheet, self._tab.say)
        for row, text in enumerate(map(self._tab.say.sentence, above)):
            form = formats["wrap" if row else "title"]
            sheet.merge_range(row, 0, row, len(self.widths) - 1, "", form)
            sheet.write_string(row, 0, text, form)
            if row:
                sheet.set_row(row, row_height([(text, sum(self.widths))]))
        sheet.write_string(0, len(self.widths), self._form.mark, formats["mark"])
        for column, said in enumerate(self._headings):
            sheet.write_string(HEADER, column, said, formats["heading"])
        sheet.set_row(HEADER, row_height(zip(self._headings, self.widths, strict=True), bold=True))
        sheet.freeze_panes(HEADER + 1, frozen)
        sheet.print_area(0, 0, last, len(self.widths) - 1)
        sheet.repeat_rows(HEADER)
        sheet.ignore_errors({"number_stored_as_text": f"A{HEADER + 2}:A{last + 1}"})

    def fit(self, row: int, texts: Mapping[int, str]) -> None:
        """Make a row as high as its texts need, by column, and as a pencil does."""
        needed = row_height((text, self.widths[column]) for column, text in texts.items())
        self._tab.sheet.set_row(row, max(self.row_height, needed))


def _rows_of(block: RowBlock) -> int:
    return block if isinstance(block, int) else sum(map(_rows_of, block))


def height_of(text: str, width: float, *, bold: bool = False) -> float:
    """Return the height of a text [pt] in a column of so many characters, broken at spaces and line ends.

    >>> height_of("contact length", 20) < height_of("contact length of the land", 20)
    True
    """
    most = max(int((_FULL_BOLD if bold else _FULL) * width), 1)
    return _LINE * sum(max(len(textwrap.wrap(part, most)), 1) for part in text.split("\n"))


def width_for(texts: Iterable[str], least: int, *, beside: int = 1) -> int:
    """Return the characters of a column in which no word of these texts is broken, with so many beside the longest.

    >>> width_for(["pressure_regulator", "main valve"], 8)
    19
    """
    return max((least, *(beside + len(word) for text in texts for word in text.split())))


def row_height(cells: Iterable[tuple[str, float]], *, bold: bool = False) -> float:
    """Return the height of a row [pt] whose texts stand in columns of so many characters each."""
    return max(height_of(text, width, bold=bold) for text, width in cells)
