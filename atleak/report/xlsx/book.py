"""Write cells, formats and pages: everything that gets into the workbook passes here."""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Iterable
from functools import cache
from itertools import accumulate
from typing import Any, NamedTuple

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_col_to_name
from xlsxwriter.worksheet import Worksheet

from atleak.common.sentences import Name, Sentence
from atleak.common.style import HEADING, LOOKS, Paper, look_of
from atleak.common.units import SYSTEMS, UnitOf
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording
from atleak.measurements.job_card import clean_text
from atleak.report.sheets.paging import LETTERS, LINE_OF_A_BOOK, row_height

_FIRST_YEAR = 1900  # of which Excel knows dates
CELL_LIMIT = 32_767  # characters Excel allows in a cell
HIGHEST_ROW = 409.0  # [pt] that Excel allows
NO_DELIVERY = 9.99e99  # stands for an infinite share: a sheet has no infinity
_NOTHING, _DEMAND = Sentence("pump delivers nothing"), Sentence("demand")

NUMBER_FORMATS = {
    "mm": "0.0000",
    "um": "0.00",
    "kpa": "0.0",
    "flow": "0.0000",
    "mm3": "0.000",
    "percent": f'[>={NO_DELIVERY / 10:.0E}]"{_NOTHING}";[<0]-0.00;0.00',  # a negative keeps its sign
    "share": f'[>={NO_DELIVERY / 10:.0E}]"{_NOTHING}";[>100]0.00" {_DEMAND}";0.00',  # never below 0
    "reserve": "0.000",
    "temperature": "0.0",
    "rpm": "0",
    "nu": "0.0000",
    "rho": "0.0000",
    "time": "0.00",
    "count": "0",
    "degrees": "0.0",  # of freedom, effective ones
    "scientific": "0.00E+00",
    "plain": "General",
}


_MARGIN, _FOOT = 0.4, 0.6  # [in] of every page; the lower one has the footer
_LEAST_LETTERS, _WIDER = 6.0, 1.06  # [pt] as printed; programs draw columns wider, each its own way
_PIXELS_ACROSS, _PIXELS_UPRIGHT = (
    (millimetres / 25.4 - 2 * _MARGIN) * 96 * LETTERS / (_LEAST_LETTERS * _WIDER) for millimetres in (279.4, 210.0)
)  # that columns may take on a page, whether A4 or Letter

Place = tuple[str, int, int]  # of a cell: sheet, row and column

_ALLOWED = {  # on a protected sheet, besides changing what is unlocked: no number changes by it
    "format_cells": True, "format_columns": True, "format_rows": True, "autofilter": True, "sort": True,
}  # fmt: skip


class _Sheet(Worksheet):
    """A sheet whose formulas are written as they are: none has a function that Excel wants with a prefix.

    Cells are told by row and column, never as "A1".
    """

    write_number, write_string = Worksheet._write_number, Worksheet._write_string
    write_formula = Worksheet._write_formula

    def _prepare_formula(self, formula: str, expand_future_functions: bool = False) -> str:
        return formula.removeprefix("=")


class Number(NamedTuple):
    """What a cell that computes was written with: number, formula and format, in the units of atleak's records."""

    value: float | str
    formula: str | None
    form: Format
    of: str | None  # kind of quantity


class ReportBook:
    """The workbook with its formats, in a reader's language; text is always written as text."""

    def __init__(self, workbook: xlsxwriter.Workbook, paper: Paper, say: Wording) -> None:
        self.workbook, self.paper, self.say = workbook, paper, say
        self._formats: dict[tuple[Any, ...], Format] = {}
        self.numbers: dict[Place, Number] | None = None  # by where they stand, for a reader of other units
        if say.system is not SYSTEMS["metric"]:
            self.numbers = {}
        self.named: dict[str, Place] = {}  # where the cells stand that have a name

    def form(self, number: str = "plain", of: str | None = None, **properties: Any) -> Format:
        """Return the format for a kind of number, with the digits of a quantity in the reader's unit; made once."""
        key = number, of, *properties.items()
        made = self._formats.get(key)
        if made is None:
            said = NUMBER_FORMATS.get(number, number)
            if of is not None and number != said and said.strip("0") == ".":
                places = self.say.digits(of, len(said) - said.index(".") - 1)
                said = f"0.{'0' * places}" if places else "0"
            for words in (_NOTHING, _DEMAND):
                said = said.replace(words, self.say.sentence(words))
            made = self.workbook.add_format({"num_format": said, "valign": "top", **properties})
            self._formats[key] = made
        return made

    @property
    def heading(self) -> Format:
        return self.form(bold=True, bottom=1, text_wrap=True, bg_color=HEADING)

    @property
    def title(self) -> Format:
        return self.form(bold=True, font_size=15)

    @property
    def bold(self) -> Format:
        return self.form(bold=True)

    @property
    def wrapped(self) -> Format:
        return self.form(text_wrap=True)

    def sheet(
        self, name: str, *, frozen: tuple[int, int] = (0, 0), landscape: bool = True, protected: bool = True
    ) -> Worksheet:
        """Add a sheet, ready to print: one page wide, headings repeated, numbered.

        One that is ``protected``, without a password, takes no change but in its unlocked cells.
        """
        sheet = self.workbook.add_worksheet(self.words(name), _Sheet)
        if protected:
            sheet.protect("", _ALLOWED)
        sheet.set_paper(self.paper.excel)
        if landscape:
            sheet.set_landscape()
        sheet.fit_to_pages(1, 0)
        sheet.set_footer("&L&A&R&P / &N")
        if frozen != (0, 0):
            sheet.freeze_panes(*frozen)
        if frozen[0]:
            sheet.repeat_rows(0, frozen[0] - 1)
        sheet.set_margins(_MARGIN, _MARGIN, _MARGIN, _FOOT)
        sheet.ignore_errors({"number_stored_as_text": "A1:XFD1048576"})  # a component is called "5", a plane "1"
        return sheet

    def few_pages(self, sheet: Worksheet, rows: float, lines: float) -> None:
        """Have so many rows, below a heading of so many lines, printed on as few pages as letters can be read on."""
        high = 72 * ((279.4 if sheet.orientation else 210.0) / 25.4 - _MARGIN - _FOOT)
        of_page = high * LETTERS / _LEAST_LETTERS / LINE_OF_A_BOOK - lines
        sheet.fit_to_pages(1, math.ceil(rows / of_page))

    def print_table(self, sheet: Worksheet, last: int, widths: Iterable[float], rows: float, lines: float) -> None:
        """Have a table printed with as many of its columns, of so many characters, as a page takes in legible size.

        It is as high as so many rows of one line, below a heading of so many lines.
        """
        self.few_pages(sheet, rows, lines)
        room = _PIXELS_UPRIGHT if sheet.orientation else _PIXELS_ACROSS
        taken = accumulate(7 * width + 5 for width in widths)
        sheet.print_area(0, 0, last, max(sum(each <= room for each in taken) - 1, 0))

    def for_screen(self, sheet: Worksheet, row: int, column: int) -> None:
        """Have nothing of a sheet printed with the workbook: the print area is a cell behind all that stands on it."""
        sheet.print_area(row, column, row, column)

    def headings(self, sheet: Worksheet, row: int, names: Iterable[str], widths: Iterable[float]) -> float:
        """Write a row of headings, as high as columns of so many characters need it; return how many lines that is."""
        words = list(map(self.words, names))
        height = max(row_height(zip(words, widths, strict=True), bold=True), LINE_OF_A_BOOK)
        sheet.set_row(row, height)
        for column, text in enumerate(words):
            sheet.write_string(row, column, text, self.heading)
        return height / LINE_OF_A_BOOK

    def colour_words(
        self, sheet: Worksheet, first: tuple[int, int], last: tuple[int, int], levels: Iterable[Verdict | Band]
    ) -> None:
        """Colour cells that hold a verdict or a band; in greyscale the word and the sign still say it."""
        if last[0] < first[0]:
            return
        for level in levels:
            look = look_of(level)
            form = self.workbook.add_format(
                {"bg_color": look.tint, "font_color": look.on_tint, "bold": look is not LOOKS[Verdict.OK]}
            )
            rule = {"type": "text", "criteria": "ends with", "value": self.say.level(level), "format": form}
            sheet.conditional_format(*first, *last, rule)

    def words(self, value: Any) -> str:
        """Return a text as its cell shows it: sentences and names of valves, circuits … in the reader's language."""
        if isinstance(value, Sentence):
            return self.say.sentence(value)
        if isinstance(value, UnitOf):
            return self.say.unit(value.kind)
        return self.say.name(value) if isinstance(value, Name) else str(value)

    def define(self, name: str, row: int, column: int, sheet: str) -> None:
        """Give a cell a name."""
        self.named[name] = sheet, row, column
        self.workbook.define_name(name, f"={cell(row, column, sheet)}")

    def put(self, sheet: Worksheet, row: int, column: int, value: Any, form: Format | None = None) -> None:
        """Write a value in a cell: numbers and dates as such, all else as text, an unknown value as an empty cell."""
        form = form or self.form()
        if isinstance(value, bool):
            sheet.write_string(row, column, self.say("estimate.yes" if value else "estimate.no"), form)
        elif isinstance(value, int | float):
            if math.isfinite(value):
                sheet.write_number(row, column, value, form)
            elif value > 0.0:
                sheet.write_number(row, column, NO_DELIVERY, form)
        elif isinstance(value, list | tuple) and not isinstance(value, UnitOf):
            self.put(sheet, row, column, ", ".join(map(self.words, value)), form)
        elif isinstance(value, dt.date) and value.year >= _FIRST_YEAR:
            pattern = self.say.table("language")["date"].format(day="dd", month="mm", year="yyyy")
            sheet.write_datetime(row, column, value, self.form(pattern, align="left"))
        elif value is not None:
            sheet.write_string(row, column, clean_text(self.words(value))[:CELL_LIMIT], form)


@cache
def column_name(column: int) -> str:
    """Return what a spreadsheet calls a column.

    >>> column_name(0), column_name(27)
    ('A', 'AB')
    """
    return str(xl_col_to_name(column))


def formula(sheet: Worksheet, row: int, column: int, text: str, value: float | str, form: Format | None = None) -> None:
    """Write a live formula with the value it gives, so that a preview or pandas sees it without calculating."""
    if isinstance(value, float) and not math.isfinite(value):
        value = NO_DELIVERY
    sheet.write_formula(row, column, f"={text}", form, value)


def cell(row: int, column: int, sheet: str | None = None) -> str:
    """Return the address of a cell, fixed in row and column: ``Lands!$D$3``."""
    address = f"${column_name(column)}${row + 1}"
    return address if sheet is None else f"{_quoted(sheet)}!{address}"


def cell_span(first: int, last: int, column: int, sheet: str | None = None) -> str:
    """Return the address of several cells of one column."""
    name = column_name(column)
    address = f"${name}${first + 1}:${name}${last + 1}"
    return address if sheet is None else f"{_quoted(sheet)}!{address}"


def _quoted(sheet: str) -> str:
    return f"'{sheet}'" if not (sheet.isascii() and sheet.isidentifier()) else sheet


def exact(value: float) -> str:
    """Return a number as a formula takes it, with every digit; negative ones in brackets."""
    text = repr(float(value)).upper()
    return f"({text})" if value < 0 else text
