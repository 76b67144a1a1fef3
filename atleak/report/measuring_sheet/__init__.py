"""Write the measuring sheet of a controller as a workbook, empty or filled in.

Its form is that of the source study's Table 1; `atleak.intake.readings.read_readings` reads it back.
"""

from __future__ import annotations

import datetime
import io
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.instruments import Part, load_instrument
from atleak.look import SHEET_COLOURS
from atleak.measuring.plan import DIRECTIONS, PARTS, REPEATS
from atleak.own_lands import OwnLands
from atleak.pressure_table import PressureTable
from atleak.readings import NOMINAL_HEADING, Reading
from atleak.report.lands_sheet import AS_STATED, LANDS, REPRESENTATIVE, write_lands
from atleak.report.measuring_sheet.head import FIELDS, INSTRUMENT, JOB, KINDS, PLACES, code_text
from atleak.report.measuring_sheet.instructions import INSTRUCTIONS, ORDER, write_instructions
from atleak.report.measuring_sheet.paging import BOTTOM, LEFT, RIGHT, TOP, Block, Paging
from atleak.report.measuring_sheet.pictures import COLUMN, HEAD_COLUMN, draw_head, draw_spools
from atleak.report.measuring_sheet.pictures import Block as DrawnBlock
from atleak.report.measuring_sheet.words import PART_NAMES, PUMP_SIDE, PUMP_TIP, SHEET, UNWORN_END
from atleak.report.pressure_sheet import PRESSURES, write_pressures
from atleak.sentence import Name, Sentence
from atleak.system.marks import PROPERTY, sealed, unsealed
from atleak.unit_systems import Quantity
from atleak.wording import Wording, wording
from atleak.workshop_units import MM, UM

__all__ = ["FIELDS", "INSTRUCTIONS", "PUMP_SIDE", "PUMP_TIP", "SHEET", "UNWORN_END", "write_readings", "write_template"]

_HEADINGS = (  # heading, kind of quantity that its unit is of, width in characters
    (Sentence("No."), None, 5),
    (Sentence("Component"), None, 20),
    (Sentence("Part"), None, 8),
    (Sentence("Plane"), None, 7),
    (Sentence("Direction"), None, 9),
    (Sentence("Repeat"), None, 8),
    (Sentence("Coordinate\nx1 (y1)"), "length", 12),
    (Sentence("Coordinate\nx2 (y2)"), "length", 12),
    (Sentence("Diameter"), "length", 12),
    (NOMINAL_HEADING, "length", 10),
    (Sentence("Mounting\nclearance"), "clearance", 10),
    (Sentence("Nominal values\nare"), None, 14),
    (Sentence("Deviation from\nnominal"), "clearance", 11),
    (Sentence("Taken at"), None, 11),
)
_HEADER = 6  # row of the headings, from 0
_TITLE_ROWS = (21.0, 42.0, 45.0)  # [pt] heights: the valve body, what to do, what of it is representative
_HEADINGS_ROW = 54.0  # [pt]
_CHOICES = 255  # characters that a spreadsheet program takes as the choices of a cell
_ANGLES = (0, 45, 90, 135)  # [°] to choose from; another may be typed
_Key = Callable[["_Row"], tuple[Any, ...]]
_TAKEN_AT = 13  # column, from 0
_NUMBER = 5  # characters of a component's number; an id of more is written upright
_FAR = 500  # [µm] from the nominal diameter: from here on the cell is coloured
_CREATED = datetime.datetime(2000, 1, 1)  # fixed, so that the same controller gives the same bytes


@dataclass(frozen=True)
class _Row:
    land: Land
    part: Part
    plane: str
    direction: float | None
    repeat: int
    reading: Reading | None

    @property
    def nominal(self) -> float:
        """Return nominal diameter of the part [m]."""
        return self.land.nominal_of(self.part)


def write_template(
    controller: Controller,
    *,
    fields: Mapping[str, str] | None = None,
    language: str = "en",
    units: str = "metric",
) -> bytes:
    """Return an empty measuring sheet: two directions and two repeats in every plane of every land.

    Parameters
    ----------
    controller
        whose lands are to be measured.
    fields
        what is known of the job, by the names of `FIELDS`, such as `atleak.report.measuring_sheet.head.fields_of`
        gives; the code of the job stands beside it.
    language
        one of `atleak.wording.languages`; a sheet in any of them is read back.
    units
        one of `atleak.unit_systems.SYSTEMS`; the headings name them.

    Returns
    -------
    bytes
        of an .xlsx workbook; the same controller gives the same bytes.
    """
    return write_readings(controller, (), fields=fields, language=language, units=units)


def write_readings(
    controller: Controller,
    readings: Iterable[Reading],
    *,
    fields: Mapping[str, str] | None = None,
    blank_rows: bool = True,
    pressures: PressureTable | None = None,
    own_lands: OwnLands = OwnLands(),  # noqa: B008  frozen, so safe to share
    language: str = "en",
    units: str = "metric",
) -> bytes:
    """Return a measuring sheet with readings filled in.

    Parameters
    ----------
    controller
        whose lands the sheet holds, in its order.
    readings
        to fill in; coordinates are written where a reading has them, its diameter otherwise. A reading of a plane that
        the controller does not have is left out.
    fields
        what to write at the head of the sheet, by the names of `FIELDS`.
    blank_rows
        whether planes, directions and repeats without a reading get an empty row; who is to fill them in is shown
        every spool with its planes.
    pressures
        gauge readings to fill in on the tab of pressures, the first of each cell.
    own_lands
        lengths and fitted repairs to fill in on the tab of lands.
    language, units
        as `write_template`.

    Returns
    -------
    bytes
        of an .xlsx workbook. Texts stay texts: nothing a user wrote becomes a formula.
    """
    readings, say = list(readings), wording(language, units)
    empty = not readings and not fields and pressures is None and own_lands == OwnLands()
    rows = _rows(controller, readings, blank_rows)
    buffer = io.BytesIO()
    options = {
        "in_memory": True,
        "strings_to_formulas": False,
        "strings_to_urls": False,
        "strings_to_numbers": False,
        "default_format_properties": {"font_name": "Arial", "font_size": 10},  # as wide in every program
    }
    with xlsxwriter.Workbook(buffer, options) as book:
        book.set_properties({"title": _title(controller, say), "created": _CREATED})
        if empty:
            book.set_custom_property(PROPERTY, unsealed("measuring sheet"))
        formats = _formats(book, say)
        sheet = _Sheet(book.add_worksheet(say.sentence(SHEET)), formats, controller, say)
        sheet.head(fields or {})
        sheet.lay_out(rows)
        sheet.body(rows, drawn=blank_rows)
        sheet.set_up(len(rows), (fields or {}).get(JOB, ""))
        write_lands(book.add_worksheet(say.sentence(LANDS)), formats, controller, own_lands, say)
        write_pressures(book.add_worksheet(say.sentence(PRESSURES)), formats, controller, pressures, say)
        write_instructions(book.add_worksheet(say.sentence(INSTRUCTIONS)), formats, controller, _FAR, say)
    return sealed(buffer.getvalue()) if empty else buffer.getvalue()


def _rows(controller: Controller, readings: Iterable[Reading], blank_rows: bool) -> list[_Row]:
    """Return the rows in the order of measuring that the sheet states, `instructions.ORDER`."""
    given: dict[tuple[Any, ...], dict[int, Reading]] = defaultdict(dict)
    directions: dict[tuple[str, Part, str], list[float | None]] = defaultdict(list)
    for reading in readings:
        repeats = given[reading.station]
        repeats[reading.repeat if reading.repeat not in repeats else max(repeats) + 1] = reading
        known = directions[reading.component, reading.part, reading.plane]
        if reading.direction not in known:
            known.append(reading.direction)

    def of_part(component: str, part: Part) -> Iterator[_Row]:
        for land in controller.lands_of(component):
            for plane in land.planes:
                measured = directions[component, part, plane]
                wanted = [angle for angle in DIRECTIONS if angle not in measured] if blank_rows else []
                for direction in sorted([*measured, *wanted], key=lambda angle: -1.0 if angle is None else angle):
                    repeats = given[component, part, plane, direction]
                    for repeat in {*repeats, *(range(1, REPEATS + 1) if blank_rows else ())}:
                        yield _Row(land, part, plane, direction, repeat, repeats.get(repeat))

    components = dict.fromkeys(land.component for land in controller.lands)
    parts = [of_part(component, part) for component in components for part in PARTS]
    return [row for rows in parts for row in sorted(rows, key=lambda row: row.repeat)]


def _title(controller: Controller, say: Wording) -> str:
    return say.sentence(Sentence("Measuring sheet: {name}", name=Name(controller.name)))


def _formats(book: xlsxwriter.Workbook, say: Wording) -> dict[str, Format]:
    length = f"0.{'0' * say.digits('length', 3)}"
    cell = {"border": 1, "border_color": SHEET_COLOURS["border"], "valign": "vcenter"}
    given = {**cell, "bg_color": SHEET_COLOURS["given"]}
    return {
        "title": book.add_format({"bold": True, "font_size": 14}),
        "label": book.add_format({"bold": True}),
        "field label": book.add_format({"bold": True, "text_wrap": True, "valign": "vcenter"}),
        "field": book.add_format({"bottom": 1, "bg_color": SHEET_COLOURS["entry"], "valign": "vcenter"}),
        "note": book.add_format(
            {"italic": True, "font_size": 8, "font_color": SHEET_COLOURS["note"], "text_wrap": True, "valign": "top"}
        ),
        "heading": book.add_format(
            {
                **cell,
                "bold": True,
                "text_wrap": True,
                "align": "center",
                "bg_color": SHEET_COLOURS["heading"],
                "font_color": SHEET_COLOURS["on_heading"],
            }
        ),
        "text": book.add_format({**given, "text_wrap": True, "align": "left"}),
        "upright": book.add_format({**given, "align": "center", "rotation": 90}),
        "on top": book.add_format({**given, "text_wrap": True, "align": "left", "valign": "top"}),
        "number": book.add_format({**given, "align": "center"}),
        "angle": book.add_format({**given, "align": "center", "num_format": '0"°"'}),
        "input": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "num_format": length, "locked": False}),
        "choice": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "locked": False}),
        "nominal": book.add_format({**given, "num_format": length, "font_color": SHEET_COLOURS["soft"]}),
        "clearance": book.add_format({**given, "num_format": "0.0", "font_color": SHEET_COLOURS["soft"]}),
        "pressure": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "num_format": "0.0", "locked": False}),
        "origin": book.add_format({**given, "font_color": SHEET_COLOURS["soft"], "italic": True, "text_wrap": True}),
        "deviation": book.add_format({**given, "num_format": "0"}),
        "alarm": book.add_format(
            {"bg_color": SHEET_COLOURS["alarm"], "font_color": SHEET_COLOURS["on_heading"], "bold": True}
        ),
        "wrap": book.add_format({"text_wrap": True, "valign": "top"}),
        "topic": book.add_format({"bold": True, "text_wrap": True, "valign": "top"}),
    }


class _Sheet:
    """Writes the sheet of measurements."""

    def __init__(self, sheet: Worksheet, formats: Mapping[str, Format], controller: Controller, say: Wording) -> None:
        self.sheet, self.formats, self.controller, self.say = sheet, formats, controller, say
        widths = (
            max(width, 1 + max(map(len, self._heading(heading, kind).split()))) for heading, kind, width in _HEADINGS
        )
        paging = Paging(tuple(widths), ())
        fields = (paging.row_height,) * (_HEADER - len(_TITLE_ROWS))  # for a pencil too
        self.paging, self.breaks = replace(paging, above=(*_TITLE_ROWS, *fields, _HEADINGS_ROW)), list[int]()

    def _heading(self, heading: Sentence, kind: str | None) -> str:
        return self.say.sentence(heading) + (f" [{self.say.unit(kind)}]" if kind else "")

    def head(self, fields: Mapping[str, str]) -> None:
        sheet, formats, controller, say = self.sheet, self.formats, self.controller, self.say
        told = Sentence(
            "Controller {id}. Yellow cells are to be filled in. All dimensions in {unit}",
            id=controller.id,
            unit=say.unit("length"),
        )
        told_all = f"{say.sentence(told)}\n{say.sentence(ORDER)}"
        titles = ((_title(controller, say), "title"), (told_all, "wrap"), (say.name(controller.representative), "note"))
        for row, (text, form) in enumerate(titles):
            sheet.merge_range(row, 0, row, HEAD_COLUMN - 1, "", formats[form])
            sheet.write_string(row, 0, text, formats[form])
        gaps = controller.pump.gaps
        left_out = {name for name, slips in ((PUMP_SIDE, gaps.side), (PUMP_TIP, gaps.tips)) if slips is None}
        for field, (row, label, first, last) in PLACES.items():
            if field in left_out - fields.keys():
                continue  # the file does not say what would slip through it
            for start, end, text, form in (
                (label, first - 1, self._heading(field, KINDS.get(field)), "field label"),
                (first, last, fields.get(field, ""), "field"),
            ):
                if end > start:
                    sheet.merge_range(row, start, row, end, "", formats[form])
                sheet.write_string(row, start, text, formats[form])
        for column, (heading, kind, _) in enumerate(_HEADINGS):
            sheet.write_string(_HEADER, column, self._heading(heading, kind), formats["heading"])
            sheet.set_column(column, column, self.paging.widths[column])
        for row, height in enumerate(self.paging.above):
            sheet.set_row(row, height)
        draw_head(sheet, code_text(controller, fields), say)

    def lay_out(self, rows: Sequence[_Row]) -> None:
        """Find where pages begin, so that none cuts a component, or a part or plane of a large one."""
        self.breaks = self.paging.breaks(_nested(rows, (_component, _part, _round, _plane)))
        for row in range(len(rows)):
            self.sheet.set_row(_HEADER + 1 + row, self.paging.row_height)

    def body(self, rows: Sequence[_Row], *, drawn: bool) -> None:
        """Write a row for every reading; what several rows share is merged, on each page anew, with its spool drawn."""
        pages = [bisect_right(self.breaks, row) for row in range(len(rows))]
        numbered = list(enumerate(rows, start=_HEADER + 1))
        on_pages = {first: (last, entry.land.component) for first, last, entry in _runs(numbered, pages, _component)}
        blocks = [
            DrawnBlock(component, first, (last - first + 1) * self.paging.row_height)
            for first, (last, component) in on_pages.items()
        ]
        width = self.paging.widths[COLUMN]
        with_spool = draw_spools(self.sheet, self.controller, blocks if drawn else (), width, self.say)
        on_top = {block.row for block in with_spool}
        for first, (last, component) in on_pages.items():
            name = self.say.name(self.controller.components[component])
            self._label(first, last, 0, component, "text" if len(component) <= _NUMBER else "upright")
            self._label(first, last, COLUMN, name, "on top" if first in on_top else "text")
        for first, last, entry in _runs(numbered, pages, _part):
            self._label(first, last, 2, self._part_name(entry), "text")
        for first, last, entry in _runs(numbered, pages, _plane):
            self._label(first, last, 3, entry.plane, "number")
            self._label(first, last, 9, self._shown(entry.nominal), "nominal")
            clearance = round(float(self.say.convert(entry.land.mounting_high * UM, "clearance")), 6)
            self._label(first, last, 10, clearance, "clearance")
            self._label(first, last, 11, self.say.sentence(_origin(entry.land)), "origin")
            for row in range(first, last + 1):
                self._deviation(row, first, rows[row - _HEADER - 1])
        for first, last, entry in _runs(numbered, pages, _direction):
            self._label(first, last, 4, entry.direction, "angle")
        for row, entry in numbered:
            self.sheet.write_number(row, 5, entry.repeat, self.formats["number"])
            self.sheet.write_blank(row, _TAKEN_AT, None, self.formats["choice"])
            for column, metres in zip((6, 7, 8), _values(entry.reading), strict=True):
                if metres is None:
                    self.sheet.write_blank(row, column, None, self.formats["input"])
                else:
                    self.sheet.write_number(row, column, self._shown(metres), self.formats["input"])

    def _part_name(self, entry: _Row) -> str:
        return self.say.sentence(PART_NAMES[entry.land.part_name if entry.part == "spool" else "sleeve"])

    def _label(self, first: int, last: int, column: int, value: str | float | None, name: str) -> None:
        """Write one value over several rows, merged as in Table 1."""
        form = self.formats[name]
        if last > first:
            self.sheet.merge_range(first, column, last, column, "", form)
        if value is None:
            self.sheet.write_blank(first, column, None, form)
        elif isinstance(value, str) and not (value.isdecimal() and str(int(value)) == value):
            self.sheet.write_string(first, column, value, form)
        else:
            self.sheet.write_number(first, column, float(value), form)

    def _shown(self, metres: float) -> float:
        """Return a length in the unit of the headings, to a tenth of a nanometre: the decimal digits as typed."""
        return round(float(self.say.convert(metres * MM, "length")), 7 if self.say.unit("length") == "mm" else 8)

    def _instruments(self) -> list[str]:
        """Return the instruments to choose from, those that come with atleak; another may be typed."""
        return [self.say.name(load_instrument(each).name) for each in sorted(shipped_files("instruments"))]

    def _deviation(self, row: int, first: int, entry: _Row) -> None:
        one, other, size, given = f"G{row + 1}", f"H{row + 1}", f"I{row + 1}", f"$J${first + 1}"
        nominal = given if self.say.unit("length") == "mm" else _in_mm(given)
        measured = f"IF(ISNUMBER({size}),{_in_mm(size)},ABS({_in_mm(one)}-{_in_mm(other)}))"
        factor = round(float(self.say.convert(UM / MM, "clearance")), 6)
        filled = f"OR(ISNUMBER({size}),AND(ISNUMBER({one}),ISNUMBER({other})))"
        off = None if entry.reading is None else (entry.reading.diameter - entry.nominal) * UM
        known = "" if off is None else round(float(self.say.convert(off, "clearance")), 6)
        self.sheet.write_formula(
            row, 12, f'=IF({filled},{factor:.10g}*({measured}-{nominal}),"")', self.formats["deviation"], known
        )

    def _choose(self, rows: tuple[int, int], column: int, choices: Iterable[str], *, others: bool = False) -> None:
        """Let cells be chosen from a list, which commas part; others too where they may be typed."""
        known = [choice for choice in choices if "," not in choice]
        while len(",".join(known)) > _CHOICES:
            known.pop()
        told = Sentence("One of the list: {choices}", choices=tuple(known))
        self.sheet.data_validation(
            rows[0],
            column,
            rows[1],
            column,
            {
                "validate": "list",
                "source": known,
                "show_error": not others,
                "error_title": self.say.sentence(Sentence("Not in the list")),
                "error_message": self.say.sentence(told)[:_CHOICES],
            },
        )

    def set_up(self, rows: int, job: str) -> None:
        """Add what a person needs who fills it in on a screen or on paper."""
        sheet, say, first, last = self.sheet, self.say, _HEADER + 1, _HEADER + max(rows, 1)
        far = float(say.convert(_FAR, "clearance"))
        sheet.freeze_panes(first, 3)
        sheet.data_validation(
            first,
            6,
            last,
            8,
            {
                "validate": "decimal",
                "criteria": ">",
                "value": 0,
                "error_title": say.sentence(Sentence("Not a dimension")),
                "error_message": say.sentence(
                    Sentence(
                        "A number in the unit of the heading, larger than 0, such as {example}. Leave empty what was "
                        "not measured.",
                        example=Quantity(9.939, "length", 3),
                    )
                ),
            },
        )
        self._choose((first, last), _TAKEN_AT, [say.sentence(UNWORN_END)])
        parts = [
            self._part_name(_Row(land, part, "", None, 1, None)) for land in self.controller.lands for part in PARTS
        ]
        self._choose((first, last), 2, dict.fromkeys(parts))
        self._choose((first, last), 4, map(str, _ANGLES), others=True)
        row, _, column, _ = PLACES[INSTRUMENT]
        self._choose((row, row), column, self._instruments(), others=True)
        alarm = {"type": "cell", "criteria": "not between", "minimum": -far, "maximum": far}
        empty = {"type": "formula", "criteria": f"=NOT(ISNUMBER($M{first + 1}))", "stop_if_true": True}
        sheet.conditional_format(first, 12, last, 12, empty)
        sheet.conditional_format(first, 12, last, 12, {**alarm, "format": self.formats["alarm"]})
        sheet.set_landscape()
        sheet.set_paper(9)  # A4
        sheet.set_print_scale(self.paging.scale)
        sheet.set_h_pagebreaks([first + row for row in self.breaks])
        sheet.repeat_rows(_HEADER)
        sheet.print_area(0, 0, last, len(_HEADINGS) - 1)
        sheet.set_margins(left=LEFT, right=RIGHT, top=TOP, bottom=BOTTOM)
        page = say("title.page", page="&P", pages="&N")
        name = " · ".join(filter(None, (job, say.name(self.controller.name))))
        sheet.set_footer(f"&L{name.replace('&', '&&')[:120]}&R{page}")
        sheet.ignore_errors({"number_stored_as_text": f"A{first + 1}:E{last + 1}"})


def _in_mm(cell: str) -> str:
    """Return the formula of a cell's length in mm, whether its heading says [mm] or [inch]."""
    return f'{cell}*IF(ISNUMBER(FIND("[in",LOWER({cell.lstrip("$")[0]}${_HEADER + 1}))),25.4,1)'


def _component(entry: _Row) -> tuple[Any, ...]:
    return (entry.land.component,)


def _part(entry: _Row) -> tuple[Any, ...]:
    return *_component(entry), entry.part


def _round(entry: _Row) -> tuple[Any, ...]:
    return *_part(entry), entry.repeat


def _plane(entry: _Row) -> tuple[Any, ...]:
    return *_round(entry), entry.plane


def _direction(entry: _Row) -> tuple[Any, ...]:
    return *_plane(entry), entry.direction


def _runs(numbered: Sequence[tuple[int, _Row]], pages: Sequence[int], key: _Key) -> Iterator[tuple[int, int, _Row]]:
    """Return first row, last row and first entry of every run of entries with the same key on the same page."""
    for _, block in groupby(zip(numbered, pages, strict=True), key=lambda each: (each[1], key(each[0][1]))):
        inside = [entry for entry, _ in block]
        yield inside[0][0], inside[-1][0], inside[0][1]


def _nested(rows: Sequence[_Row], keys: Sequence[_Key]) -> list[Block]:
    """Return the numbers of rows of components, within them of parts, of the rounds of measuring, of planes."""
    key, *finer = keys
    groups = [list(block) for _, block in groupby(rows, key=key)]
    return [_nested(group, finer) if finer else len(group) for group in groups]


def _values(reading: Reading | None) -> tuple[float | None, float | None, float | None]:
    if reading is None:
        return None, None, None
    if reading.coordinates is not None:
        return *reading.coordinates, None
    return None, None, reading.diameter


def _origin(land: Land) -> Sentence:
    diameter, clearance = (key in land.representative for key in ("nominal_diameter_mm", "mounting_clearance_um"))
    if diameter and clearance:
        return REPRESENTATIVE
    if diameter:
        return Sentence("diameter representative")
    return Sentence("clearance representative") if clearance else AS_STATED
