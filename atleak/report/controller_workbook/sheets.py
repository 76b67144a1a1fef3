"""Write the sheets to fill in: forms with a key on each line, and tables with a column for each key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_col_to_name, xl_rowcol_to_cell
from xlsxwriter.worksheet import Worksheet

from atleak.controller_sheets.kinds import Choice, Gear, Gears, Kind, Names, Number, Whole, Wholes, YesNo
from atleak.controller_sheets.layout import (
    EXAMPLE_MARK,
    FORM_HEADINGS,
    HEAD,
    LISTS,
    NAMES,
    NOTE_HEADING,
    UNIT_LINES,
    UNIT_MARK,
    examples,
)
from atleak.controller_sheets.shapes import Column, Sheet
from atleak.controller_sheets.units import Measure, Units
from atleak.errors import OutputError
from atleak.look import SHEET_COLOURS
from atleak.sentence import Sentence


@dataclass
class Places:
    """Where the columns to fill in were written: first and last row and column, all from 0, by sheet and heading."""

    columns: dict[tuple[str, str], tuple[int, int, int]] = field(default_factory=dict)


def defined_name(names: str) -> str:
    """Return the workbook's name of the cells that a drop-down offers.

    >>> defined_name("operating point")
    'operating_point_names'
    """
    return f"{names.replace(' ', '_')}_names"


def write_names(book: xlsxwriter.Workbook, lists: Worksheet, places: Places) -> None:
    """Define the names; where fixed ones come first, all of them stand on a hidden sheet.

    Parameters
    ----------
    book, lists
        the workbook, and its sheet for what no other sheet holds as a column.
    places
        of the columns that hold the names.
    """
    for number, (names, offered) in enumerate(NAMES.items()):
        first, last, column = places.columns[offered.sheet, offered.heading]
        letter = xl_col_to_name(column, col_abs=True)
        cells = f"'{offered.sheet}'!{letter}${first + 1}:{letter}${last + 1}"
        count = f"COUNTA({cells})"
        if not offered.fixed:
            start = f"'{offered.sheet}'!{letter}${first + 1}"
            book.define_name(defined_name(names), f"=OFFSET({start},0,0,MAX(1,{count}),1)")
            continue
        for row, name in enumerate(offered.fixed):
            lists.write_string(row, number, name)
        for row in range(first, last + 1):
            source = f"'{offered.sheet}'!{xl_rowcol_to_cell(row, column)}"
            lists.write_formula(len(offered.fixed) + row - first, number, f'={source}&""', None, "")
        start = f"'{LISTS}'!{xl_col_to_name(number, col_abs=True)}$1"
        book.define_name(defined_name(names), f"=OFFSET({start},0,0,{len(offered.fixed)}+{count},1)")
    lists.hide()


_TITLE, _ABOUT, _HEADINGS = 0, 1, 3  # rows, from 0
_HELP, _UNITS = 2, 4
_FORM_WIDTHS = (8, 34, 60, 16, 16, 70)  # in characters
_NOTE_WIDTH = 8
_LINE = 16  # height of a line of text in points
_SPARE_ROWS = 25  # to fill in below those that are filled
_LEAST_ROWS = 40
_A4 = 9
_DIMENSION = "0.0####"  # how lengths and pressures look; a cell keeps every digit
_LONGEST = 32_767  # characters that a cell holds

Data = Mapping[str, Any] | None
Styles = Mapping[str, Format]


def formats(book: xlsxwriter.Workbook) -> Styles:
    """Return how the cells look."""
    cell = {"border": 1, "border_color": SHEET_COLOURS["border"], "valign": "top"}
    entry = {**cell, "bg_color": SHEET_COLOURS["entry"], "locked": False}
    heading = {**cell, "bold": True, "text_wrap": True, "align": "center", "valign": "vcenter"}
    given = {**cell, "bg_color": SHEET_COLOURS["given"], "font_color": SHEET_COLOURS["soft"]}
    return {
        "title": book.add_format({"bold": True, "font_size": 14}),
        "about": book.add_format({"font_color": SHEET_COLOURS["soft"]}),
        "topic": book.add_format({"bold": True, "valign": "top"}),
        "wrap": book.add_format({"text_wrap": True, "valign": "top"}),
        "help": book.add_format(
            {"italic": True, "font_size": 9, "text_wrap": True, "valign": "bottom", "font_color": SHEET_COLOURS["note"]}
        ),
        "needed": book.add_format(
            {**heading, "bg_color": SHEET_COLOURS["heading"], "font_color": SHEET_COLOURS["on_heading"]}
        ),
        "optional": book.add_format({**heading, "bg_color": SHEET_COLOURS["given"]}),
        "needed field": book.add_format(
            {**cell, "bold": True, "bg_color": SHEET_COLOURS["heading"], "font_color": SHEET_COLOURS["on_heading"]}
        ),
        "field": book.add_format({**cell, "bold": True, "bg_color": SHEET_COLOURS["given"]}),
        "unit": book.add_format({**given, "align": "center"}),
        "example": book.add_format({**given, "italic": True}),
        "example dimension": book.add_format({**given, "italic": True, "num_format": _DIMENSION}),
        "note": book.add_format({"italic": True, "font_color": SHEET_COLOURS["soft"], "valign": "top"}),
        "long note": book.add_format(
            {"italic": True, "text_wrap": True, "font_color": SHEET_COLOURS["soft"], "valign": "top"}
        ),
        "text": book.add_format({**entry, "num_format": "@", "align": "left"}),
        "long text": book.add_format({**entry, "num_format": "@", "text_wrap": True, "align": "left"}),
        "number": book.add_format({**entry, "align": "right"}),
        "dimension": book.add_format({**entry, "align": "right", "num_format": _DIMENSION}),
        "mark": book.add_format({**entry, "num_format": "@", "align": "center"}),
        "choice": book.add_format({**entry, "align": "left"}),
    }


def write_form(page: Worksheet, styles: Styles, sheet: Sheet, data: Data, units: Units, places: Places) -> None:
    """Write a sheet with one key on each line.

    Parameters
    ----------
    page, styles
        the sheet to write and how its cells look.
    sheet
        as it is declared.
    data
        the tables to fill in, None for none.
    units
        in which its numbers are written.
    places
        takes where the columns to fill in stand.
    """
    _begin(page, styles, sheet)
    for column, (heading, width) in enumerate(zip((NOTE_HEADING, *FORM_HEADINGS), _FORM_WIDTHS, strict=True)):
        page.set_column(column, column, width)
        page.write_string(_HEADINGS, column, heading, styles["needed" if 1 <= column <= 2 else "optional"])
    values = {} if data is None else next(iter(sheet.rows(data)))
    known = {column.how_known: column for column in sheet.columns if column.how_known}
    lines = [column for column in sheet.columns if not column.how_known]
    if sheet is HEAD:
        values = {**values, **{column.heading: getattr(units, column.keys[0]) for column in UNIT_LINES}}
        lines = [*UNIT_LINES, *lines]
    for row, line in enumerate(lines, start=_HEADINGS + 1):
        page.write_string(row, 1, line.heading, styles["needed field" if line.required else "field"])
        value = values.get(line.heading)
        style = "long text" if _style(line.kind) == "text" else ""
        _write_cell(page, styles, row, 2, line, value, units, style=style)
        lines_needed = max(len(str(value or "")) // _FORM_WIDTHS[2], len(line.help) // _FORM_WIDTHS[5])
        page.set_row(row, _LINE * (1 + lines_needed))
        _write_unit(page, row, 3, line.kind, units, styles["unit"])
        origin = known.get(line.key)
        if origin is not None:
            _write_cell(page, styles, row, 4, origin, values.get(origin.heading), units)
            _offer(page, row, row, 4, origin)
        page.write_string(row, 5, line.help, styles["long note"])
        _offer(page, row, row, 2, line)
    page.freeze_panes(_HEADINGS + 1, 2)
    _finish(page, sheet)


def write_table(page: Worksheet, styles: Styles, sheet: Sheet, data: Data, units: Units, places: Places) -> None:
    """Write a sheet with a column for each key; parameters as of `write_form`."""
    _begin(page, styles, sheet)
    columns = sheet.columns_for(data or {})
    filled = [] if data is None else list(sheet.rows(data))
    shown = examples(sheet) if data is None else ()
    page.set_column(0, 0, _NOTE_WIDTH)
    page.write_string(_HEADINGS, 0, NOTE_HEADING, styles["optional"])
    page.write_string(_UNITS, 0, UNIT_MARK, styles["note"])
    first = _UNITS + 1 + len(shown)
    last = first + max(len(filled) + _SPARE_ROWS, _LEAST_ROWS) - 1
    page.set_row(_HELP, 4 * _LINE)
    page.set_row(_HEADINGS, 2 * _LINE)
    for number, column in enumerate(columns, start=1):
        page.set_column(number, number, column.width)
        page.write_string(_HELP, number, column.help, styles["help"])
        page.write_string(_HEADINGS, number, column.heading, styles["needed" if column.required else "optional"])
        _write_unit(page, _UNITS, number, column.kind, units, styles["unit"])
        for row, values in enumerate(shown, start=_UNITS + 1):
            style = "example dimension" if _style(column.kind) == "dimension" else "example"
            _write_cell(page, styles, row, number, column, values.get(column.heading), units, style)
        for row in range(first, last + 1):
            values = filled[row - first] if row - first < len(filled) else {}
            _write_cell(page, styles, row, number, column, values.get(column.heading), units)
        _offer(page, first, last, number, column)
        places.columns[sheet.name, column.heading] = first, last, number
    for row in range(_UNITS + 1, first):
        page.write_string(row, 0, EXAMPLE_MARK, styles["note"])
    page.freeze_panes(_UNITS + 1, 2)
    page.repeat_rows(_HEADINGS, _UNITS)
    page.print_area(0, 0, first + len(filled) + (0 if filled else 20), len(columns))
    page.ignore_errors({"number_stored_as_text": f"A1:{xl_rowcol_to_cell(last, len(columns))}"})
    _finish(page, sheet)


def _begin(page: Worksheet, styles: Styles, sheet: Sheet) -> None:
    page.write_string(_TITLE, 0, sheet.name, styles["title"])
    page.write_string(_ABOUT, 0, sheet.about, styles["about"])


def _finish(page: Worksheet, sheet: Sheet) -> None:
    page.set_tab_color(SHEET_COLOURS["heading" if sheet.needed else "border"])
    page.set_landscape()
    page.set_paper(_A4)
    page.fit_to_pages(1, 0)


def _write_cell(
    page: Worksheet, styles: Styles, row: int, column: int, declared: Column, value: Any, units: Units, style: str = ""
) -> None:
    form = styles[style or _style(declared.kind)]
    cell = None if value is None else declared.kind.cell(value, units)
    if isinstance(cell, str) and len(cell) > _LONGEST:
        problem = Sentence("{heading} is too long for a cell", heading=declared.heading)
        expected = Sentence("{count} characters at most", count=_LONGEST)
        raise OutputError(problem, value=f"{cell[:40]} …", expected=expected)
    if cell is None or cell == "":
        page.write_blank(row, column, None, form)
    elif isinstance(cell, str):
        page.write_string(row, column, cell, form)
    else:
        page.write_number(row, column, cell, form)


def _style(kind: Kind) -> str:
    if isinstance(kind, Number | Whole):
        return "dimension" if isinstance(kind, Number) and kind.measure.quantity else "number"
    if isinstance(kind, Choice | YesNo):
        return "choice"
    return "mark" if isinstance(kind, Gear | Wholes) else "text"


def _write_unit(page: Worksheet, row: int, column: int, kind: Kind, units: Units, form: Format) -> None:
    """Write a unit, as a formula where it follows the choice on the first sheet."""
    label = kind.label(units)
    formula = _unit_formula(kind.measure) if isinstance(kind, Number) else ""
    if formula:
        page.write_formula(row, column, formula, form, label)
    else:
        page.write_string(row, column, label, form)


def _unit_formula(measure: Measure) -> str:
    """Return the formula of a unit's label; "" where it does not depend on a choice."""
    cells = {
        line.keys[0]: f"'{HEAD.name}'!{xl_rowcol_to_cell(row, 2, row_abs=True, col_abs=True)}"
        for row, line in enumerate(UNIT_LINES, start=_HEADINGS + 1)
    }
    if measure.of_pressure:
        return f"={cells['pressure']}"
    if not measure.inch:
        return ""
    unit = f'IF({cells["length"]}="inch","{measure.inch}","{measure.metric}")'
    return f'={unit}&", "&{cells["clearance"]}' if measure.of_clearance else f"={unit}"


def _offer(page: Worksheet, first: int, last: int, column: int, declared: Column) -> None:
    """Add the drop-down of a column; where other names are possible too, it only advises."""
    kind = declared.kind
    if isinstance(kind, Choice):
        page.data_validation(first, column, last, column, {"validate": "list", "source": list(kind.shown)})
    elif isinstance(kind, YesNo):
        page.data_validation(first, column, last, column, {"validate": "list", "source": ["yes", "no"]})
    elif declared.names:
        source = f"={defined_name(declared.names)}"
        page.data_validation(
            first, column, last, column, {"validate": "list", "source": source, "error_type": "information"}
        )
    elif isinstance(kind, Gears | Names):
        return
