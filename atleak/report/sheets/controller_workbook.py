"""Write the workbook that describes a valve body, empty or filled in, its first sheet saying how, with pictures.

Forms have a key on each line, tables a column for each key. `atleak.catalogue.workbook.sheets` declares the sheets;
`atleak.readers.controller_workbook` reads them back.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_col_to_name, xl_rowcol_to_cell
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.workbook.cells import CellForm, ChoiceCell, Gear, Measure, Number, Units, Whole, Wholes, YesNo
from atleak.catalogue.workbook.shapes import SheetColumn, WorkbookSheet
from atleak.catalogue.workbook.sheets import (
    EXAMPLE_MARK,
    FORM_HEADINGS,
    HEAD,
    INSTRUCTIONS,
    LISTS,
    NAMES,
    NOTE_HEADING,
    SHEETS,
    UNIT_LINES,
    UNIT_MARK,
    examples,
)
from atleak.common.errors import OutputError
from atleak.common.sentences import Sentence
from atleak.common.style import SHEET_COLOURS
from atleak.report.sheets.paging import workbook

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
    colours = SHEET_COLOURS
    cell = {"border": 1, "border_color": colours["border"], "valign": "top"}
    entry = {**cell, "bg_color": colours["entry"], "locked": False, "align": "left"}
    heading = {**cell, "bold": True, "text_wrap": True, "align": "center", "valign": "vcenter"}
    given = {**cell, "bg_color": colours["given"], "font_color": colours["soft"]}
    needed = {"bold": True, "bg_color": colours["heading"], "font_color": colours["on_heading"]}
    note = {"italic": True, "font_color": colours["soft"], "valign": "top"}
    small = {"italic": True, "font_size": 9, "text_wrap": True, "valign": "bottom", "font_color": colours["note"]}
    looks = {
        "title": {"bold": True, "font_size": 14},
        "about": {"font_color": colours["soft"]},
        "topic": {"bold": True, "valign": "top"},
        "wrap": {"text_wrap": True, "valign": "top"},
        "help": small,
        "needed": {**heading, **needed},
        "optional": {**heading, "bg_color": colours["given"]},
        "needed field": {**cell, **needed},
        "field": {**cell, "bold": True, "bg_color": colours["given"]},
        "unit": {**given, "align": "center"},
        "example": {**given, "italic": True},
        "example dimension": {**given, "italic": True, "num_format": _DIMENSION},
        "note": note,
        "long note": {**note, "text_wrap": True},
        "text": {**entry, "num_format": "@"},
        "long text": {**entry, "num_format": "@", "text_wrap": True},
        "number": {**entry, "align": "right"},
        "dimension": {**entry, "align": "right", "num_format": _DIMENSION},
        "mark": {**entry, "num_format": "@", "align": "center"},
        "choice": entry,
    }
    return {name: book.add_format(look) for name, look in looks.items()}


class SheetWriter:
    """Writes the sheets of a workbook, and remembers where the columns to fill in stand.

    Parameters
    ----------
    book, styles
        the workbook, and how its cells look.
    data
        the tables to fill in, None for none.
    units
        in which its numbers are written.
    """

    def __init__(self, book: xlsxwriter.Workbook, styles: Styles, data: Data, units: Units) -> None:
        self.book, self.styles, self.data, self.units = book, styles, data, units
        self.columns: dict[tuple[str, str], tuple[int, int, int]] = {}  # first and last row, column, all from 0

    def form(self, page: Worksheet, sheet: WorkbookSheet) -> None:
        """Write a sheet with one key on each line."""
        self._begin(page, sheet)
        for column, (heading, width) in enumerate(zip((NOTE_HEADING, *FORM_HEADINGS), _FORM_WIDTHS, strict=True)):
            page.set_column(column, column, width)
            page.write_string(_HEADINGS, column, heading, self.styles["needed" if 1 <= column <= 2 else "optional"])
        values = {} if self.data is None else next(iter(sheet.rows(self.data)))
        known = {column.how_known: column for column in sheet.columns if column.how_known}
        lines = [column for column in sheet.columns if not column.how_known]
        if sheet is HEAD:
            values = {**values, **{column.heading: getattr(self.units, column.key) for column in UNIT_LINES}}
            lines = [*UNIT_LINES, *lines]
        for row, line in enumerate(lines, start=_HEADINGS + 1):
            page.write_string(row, 1, line.heading, self.styles["needed field" if line.required else "field"])
            value = values.get(line.heading)
            style = "long text" if _style(line.kind) == "text" else ""
            self._write_cell(page, row, 2, line, value, style=style)
            lines_needed = max(len(str(value or "")) // _FORM_WIDTHS[2], len(line.help) // _FORM_WIDTHS[5])
            page.set_row(row, _LINE * (1 + lines_needed))
            self._write_unit(page, row, 3, line.kind)
            origin = known.get(line.key)
            if origin is not None:
                self._write_cell(page, row, 4, origin, values.get(origin.heading))
                _offer(page, row, row, 4, origin)
            page.write_string(row, 5, line.help, self.styles["long note"])
            _offer(page, row, row, 2, line)
        page.freeze_panes(_HEADINGS + 1, 2)

    def table(self, page: Worksheet, sheet: WorkbookSheet) -> None:
        """Write a sheet with a column for each key."""
        self._begin(page, sheet)
        styles, columns = self.styles, sheet.columns_for(self.data or {})
        filled = [] if self.data is None else list(sheet.rows(self.data))
        shown = examples(sheet) if self.data is None else ()
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
            self._write_unit(page, _UNITS, number, column.kind)
            for row, values in enumerate(shown, start=_UNITS + 1):
                style = "example dimension" if _style(column.kind) == "dimension" else "example"
                self._write_cell(page, row, number, column, values.get(column.heading), style)
            for row in range(first, last + 1):
                values = filled[row - first] if row - first < len(filled) else {}
                self._write_cell(page, row, number, column, values.get(column.heading))
            _offer(page, first, last, number, column)
            self.columns[sheet.name, column.heading] = first, last, number
        for row in range(_UNITS + 1, first):
            page.write_string(row, 0, EXAMPLE_MARK, styles["note"])
        page.freeze_panes(_UNITS + 1, 2)
        page.repeat_rows(_HEADINGS, _UNITS)
        page.print_area(0, 0, first + len(filled) + (0 if filled else 20), len(columns))
        page.ignore_errors({"number_stored_as_text": f"A1:{xl_rowcol_to_cell(last, len(columns))}"})

    def names(self, lists: Worksheet) -> None:
        """Define the names that drop-downs offer; where fixed ones come first, all of them stand on a hidden sheet."""
        for number, (names, offered) in enumerate(NAMES.items()):
            first, last, column = self.columns[offered.sheet, offered.heading]
            letter = xl_col_to_name(column, col_abs=True)
            cells = f"'{offered.sheet}'!{letter}${first + 1}:{letter}${last + 1}"
            start, count = f"'{offered.sheet}'!{letter}${first + 1}", f"MAX(1,COUNTA({cells}))"
            if offered.fixed:
                lists.write_column(0, number, offered.fixed)
                for row in range(first, last + 1):
                    source = f"'{offered.sheet}'!{xl_rowcol_to_cell(row, column)}"
                    lists.write_formula(len(offered.fixed) + row - first, number, f'={source}&""', None, "")
                start = f"'{LISTS}'!{xl_col_to_name(number, col_abs=True)}$1"
                count = f"{len(offered.fixed)}+COUNTA({cells})"
            self.book.define_name(_defined_name(names), f"=OFFSET({start},0,0,{count},1)")
        lists.hide()

    def _begin(self, page: Worksheet, sheet: WorkbookSheet) -> None:
        page.write_string(_TITLE, 0, sheet.name, self.styles["title"])
        page.write_string(_ABOUT, 0, sheet.about, self.styles["about"])
        page.set_tab_color(SHEET_COLOURS["heading" if sheet.needed else "border"])
        page.set_landscape()
        page.set_paper(_A4)
        page.fit_to_pages(1, 0)

    def _write_cell(
        self, page: Worksheet, row: int, column: int, declared: SheetColumn, value: Any, style: str = ""
    ) -> None:
        form = self.styles[style or _style(declared.kind)]
        cell = None if value is None else declared.kind.cell(value, self.units)
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

    def _write_unit(self, page: Worksheet, row: int, column: int, kind: CellForm) -> None:
        """Write a unit, as a formula where it follows the choice on the first sheet."""
        label = kind.label(self.units)
        formula = _unit_formula(kind.measure) if isinstance(kind, Number) else ""
        if formula:
            page.write_formula(row, column, formula, self.styles["unit"], label)
        else:
            page.write_string(row, column, label, self.styles["unit"])


def _style(kind: CellForm) -> str:
    if isinstance(kind, Number | Whole):
        return "dimension" if isinstance(kind, Number) and kind.measure.quantity else "number"
    if isinstance(kind, ChoiceCell | YesNo):
        return "choice"
    return "mark" if isinstance(kind, Gear | Wholes) else "text"


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


def _offer(page: Worksheet, first: int, last: int, column: int, declared: SheetColumn) -> None:
    """Add the drop-down of a column; where other names are possible too, it only advises."""
    kind = declared.kind
    offer: dict[str, Any]
    if isinstance(kind, ChoiceCell):
        offer = {"source": list(kind.shown)}
    elif isinstance(kind, YesNo):
        offer = {"source": ["yes", "no"]}
    elif declared.names:
        offer = {"source": f"={_defined_name(declared.names)}", "error_type": "information"}
    else:
        return
    page.data_validation(first, column, last, column, {"validate": "list", **offer})


def _defined_name(names: str) -> str:
    """Return the workbook's name of the cells that a drop-down offers."""
    return f"{names.replace(' ', '_')}_names"


SPOOL_PICTURE = Path(__file__).with_name("spool.png")
"""What the sheet of lands asks for; drawn by ``tools/spool_picture.py``."""

_HOW_TO = (
    (
        "What it is",
        "Everything atleak has to know of a transmission's valve body to judge its leakage. Fill it in, then "
        "'atleak controller check FILE' lists all that is wrong with it at once, and 'atleak controller from-workbook "
        "FILE -o UNIT.toml' makes the file that every command and the dashboard take.",
    ),
    (
        "Where to begin",
        "With the sheets whose tabs are dark: Head, Materials, Components, Lands, Pump, Operating points. That is "
        "enough for a first verdict. Circuits, Feeds, Gaps and the rest sharpen it: a land without "
        "any gap is taken to leak from main pressure to the drain, which is an upper bound.",
    ),
    (
        "Units",
        "Choose on the sheet Head: mm or inch, radial or diametral clearance, kPa, psi or bar. The units under the "
        "headings follow. Change them before you fill in numbers: what stands there already is not converted.",
    ),
    (
        "Clearance",
        "Diametral is bore minus spool, as manuals and part makers state it; radial is half of that. It is what the "
        "pair had when it was new: from the maker, from a new part, or from an unworn end of the bore. Where only the "
        "range of new pairs is known, write both ends.",
    ),
    (
        "How known",
        "Measured: on such a unit, by you. Published: in the source beside it. Representative: what such units "
        "commonly have, to be measured later. Empty: not stated; of the pump: published.",
    ),
    ("Gears", "R is reverse, N and P are neutral, the others are numbers: R N 1 2 3, or 1-5, or all."),
    (
        "Ids",
        "Components, circuits and operating points have short names of yours; other sheets offer them in their "
        "drop-downs. Small letters, digits and _ (components may have any).",
    ),
    (
        "Rows and columns",
        f"Yellow cells are to be filled in; dark headings must be. Rows marked {EXAMPLE_MARK!r} in the column "
        f"{NOTE_HEADING} are examples and are not read: leave or delete them. What else stands in that column is a "
        "remark of yours, and not carried over. Rows and columns may stand in any order, and empty rows between.",
    ),
    (
        "Numbers",
        "Decimal point or comma, as your program writes them. A unit of its own may stand behind a number: 25 µm, "
        "0.57 in, 110 psi.",
    ),
)


def _write_instructions(page: Worksheet, styles: Styles) -> None:
    """Write the sheet."""
    page.set_column(0, 0, 18)
    page.set_column(1, 1, 100)
    page.write_string(0, 0, INSTRUCTIONS, styles["title"])
    row = 2
    for row, (topic, text) in enumerate(_HOW_TO, start=2):
        page.write_string(row, 0, topic, styles["topic"])
        page.write_string(row, 1, text, styles["wrap"])
        page.set_row(row, 16 * (1 + len(text) // 105))
    page.insert_image(
        row + 2,
        0,
        str(SPOOL_PICTURE),
        {
            "description": "A spool in its bore: two lands with diameter, contact length, position and clearance",
            "x_scale": 0.5,
            "y_scale": 0.5,
        },
    )
    row += 21
    page.write_string(row, 0, "The sheets", styles["topic"])
    for sheet in SHEETS:
        row += 1
        page.write_url(row, 0, f"internal:'{sheet.name}'!A1", string=sheet.name)
        page.write_string(row, 1, sheet.about, styles["wrap"])
    page.set_paper(9)  # A4
    page.fit_to_pages(1, 1)


def write_controller_workbook(data: Mapping[str, Any] | None = None, units: Units | None = None) -> bytes:
    """Return the workbook of a valve body.

    Parameters
    ----------
    data
        the tables of a controller's file, as a TOML file of the same content gives them; without them the workbook is
        empty, but for rows marked as examples.
    units
        in which its numbers are written: mm, radial and kPa unless given.

    Returns
    -------
    bytes
        of an .xlsx workbook; the same tables and units give the same bytes. Texts stay texts, never formulas.
    """

    def write_sheets(book: xlsxwriter.Workbook) -> None:
        styles = formats(book)
        _write_instructions(book.add_worksheet(INSTRUCTIONS), styles)
        writer = SheetWriter(book, styles, data, units or Units())
        for sheet in SHEETS:
            write = writer.form if sheet.is_form else writer.table
            write(book.add_worksheet(sheet.name), sheet)
        writer.names(book.add_worksheet(LISTS))

    title = "Valve body to describe" if data is None else f"Valve body: {data.get('name', '')}"[:200]
    return workbook(write_sheets, title, mark="controller workbook")
