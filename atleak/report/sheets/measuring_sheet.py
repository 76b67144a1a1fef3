"""Write the measuring sheet of a controller as a workbook, empty or filled in, with a tab that says how to measure.

Its form is that of the source study's Table 1; `atleak.readers.sheets.measuring_sheet.read_readings` reads it back.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_rowcol_to_cell
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Land
from atleak.common.sentences import Name, Sentence
from atleak.common.units import MM, UM, Quantity
from atleak.common.wording import Wording, wording
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.measuring_plan import PLAN_PARTS, REPEATS, Plan
from atleak.measurements.own_forms import INSTRUCTIONS, MEASUREMENTS, REPEATED
from atleak.measurements.readings import OwnLands, Reading
from atleak.report.sheets.lands_sheet import LANDS, write_lands
from atleak.report.sheets.measuring_columns import (
    AS_STATED,
    FORM_PART_NAMES,
    PUMP_SIDE,
    PUMP_TIP,
    REPRESENTATIVE,
    SHEET,
    UNWORN_END,
    FormColumn,
    FormRow,
    blocks_of,
    formats_of,
    heading_of,
    of_component,
    of_part,
    of_plane,
    of_repeat,
    rows_of_form,
    rows_of_plan,
    runs_of_cells,
)
from atleak.report.sheets.measuring_head import (
    INSTRUMENT_ROWS,
    JOB,
    MEASURING_HEADER,
    PICTURES,
    PLACES,
    TITLE_HEIGHTS,
    ComponentRows,
    code_text,
    draw_head,
    draw_spools,
    instruments_for,
    label_of,
)
from atleak.report.sheets.paging import Paging, Tab, only, put, row_height, width_for, workbook
from atleak.report.sheets.pressure_sheet import PRESSURES_TITLE, write_pressures

MEASURING_INSTRUCTIONS = Sentence("How to measure")
_WIDTHS = (22, 98)
_BETWEEN = 6.0  # [pt] height of the row below a topic, which also keeps words of several from being read as headings
_TOPICS = (
    "before", "temperature", "pump", "where", "in_which_order", "drawing", "code", "how_often", "what_to_write",
    "bores", "unworn_ends", "not_measured", "more_rows", "lands", "pressures", "check", "refused", "nominal_values",
)  # fmt: skip

_WHOLE = "in_which_order", "drawing", "how_often"  # topics of a whole sheet alone


def _write_instructions(tab: Tab, controller: Controller, far: float, *, quick: bool) -> None:
    """Write a row for every topic, as high as its text is long.

    Parameters
    ----------
    far
        how far from the nominal diameter a cell is coloured [µm].
    quick
        whether every land is measured once, in the order of the rows.
    """
    sheet, formats, say = tab.sheet, tab.formats, tab.say
    values = {
        "reference": say.plain_quantity(REFERENCE_TEMPERATURE, "temperature"),
        "bore": say.plain_quantity(15.0, "length"),
        "more": say.plain_quantity(2.0, "clearance"),
        "warm": say.plain_quantity(35.0, "temperature"),
        "most": say.plain_quantity(0.5, "length"),
        "far": say.plain_quantity(far, "clearance"),
        "order": say("how_to_measure.order"),
        "choice": repr(say.sentence(UNWORN_END)),
        "third": repr(heading_of("diameter, repeat 3", "length", say)),
    }
    tabs = {"lands": LANDS, "pressures": PRESSURES_TITLE}
    Paging(_WIDTHS).set_up(sheet, say)
    sheet.write_string(0, 0, say.sentence(MEASURING_INSTRUCTIONS), formats["title"])
    sheet.write_string(0, len(_WIDTHS), INSTRUCTIONS.mark, formats["mark"])
    left_out = {*(_WHOLE if quick else ()), *(() if controller.representative else _TOPICS[-1:])}
    for number, topic in enumerate(topic for topic in _TOPICS if topic not in left_out):
        row, title = 2 * number + 2, say(f"how_to_measure.{topic}_title")
        key = "in_inches" if topic == "what_to_write" and say.unit("length") != "mm" else topic
        said = say(f"how_to_measure.{key}", tab=say.sentence(tabs.get(topic, "")), **values)
        sheet.write_string(row, 0, title, formats["topic"])
        sheet.write_string(row, 1, said, formats["wrap"])
        sheet.set_row(row, row_height(zip((title, said), _WIDTHS, strict=True)))
        sheet.set_row(row + 1, _BETWEEN)
    sheet.print_area(0, 0, row, len(_WIDTHS) - 1)


_HEADINGS_ROW = 42.0  # [pt]
_CHOICES = 255  # characters that a spreadsheet program takes as the choices of a cell
_ANGLES = (0, 45, 90, 135)  # [°] to choose from; another may be typed
_NUMBER = 5  # characters of a component's number; an id of more is written upright
_FAR = 500  # [µm] from the nominal diameter: from here on the cell is coloured
_KEYS = (of_component, of_part, of_plane)  # what a page's end had better not cut, and what it never cuts
_DEVIATIONS = (FormColumn.DEVIATION, FormColumn.SECOND_DEVIATION)  # of the repeats that have one


def write_template(
    controller: Controller,
    *,
    plan: Plan | None = None,
    fields: Mapping[str, str] | None = None,
    language: str = "en",
    units: str = "metric",
) -> bytes:
    """Return an empty measuring sheet: two directions and two repeats in every plane of every land.

    Parameters
    ----------
    plan
        of a quick pass, `atleak.diagnosis.evidence.quick_pass`: its readings alone, in its order.
    fields
        what is known of the job, by the names of `FIELDS`, such as `atleak.report.sheets.measuring_head.fields_of`
        gives; the code of the job stands beside it.
    language
        one of `atleak.common.wording.languages`; a sheet in any of them is read back.
    units
        one of `atleak.common.units.SYSTEMS`; the headings name them.

    Returns
    -------
    bytes
        of an .xlsx workbook; the same controller gives the same bytes.
    """
    return write_readings(controller, (), plan=plan, fields=fields, language=language, units=units)


def write_readings(
    controller: Controller,
    readings: Iterable[Reading],
    *,
    plan: Plan | None = None,
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
    plan
        whose readings the sheet asks for instead, where it is empty.
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
    rows = rows_of_form(controller, readings, blank_rows) if plan is None else rows_of_plan(controller, plan)

    def write(book: xlsxwriter.Workbook) -> None:
        formats = formats_of(book, say)
        sheet = _Sheet(book.add_worksheet(say.sentence(SHEET)), formats, controller, say, quick=plan is not None)
        sheet.head(fields or {})
        sheet.body(rows, drawn=blank_rows)
        sheet.set_up(len(rows), (fields or {}).get(JOB, ""))
        lands, gauges, instructions = (
            Tab(book.add_worksheet(say.sentence(name)), formats, say)
            for name in (LANDS, PRESSURES_TITLE, MEASURING_INSTRUCTIONS)
        )
        write_lands(lands, controller, own_lands)
        write_pressures(gauges, controller, pressures)
        _write_instructions(instructions, controller, _FAR, quick=plan is not None)

    return workbook(write, _title(controller, say), mark="measuring sheet" if empty else None)


def _title(controller: Controller, say: Wording) -> str:
    return say.sentence(Sentence("Measuring sheet: {name}", name=Name(controller.name)))


class _Sheet:
    """Writes the sheet of measurements."""

    def __init__(
        self, sheet: Worksheet, formats: Mapping[str, Format], controller: Controller, say: Wording, *, quick: bool
    ) -> None:
        self.sheet, self.formats, self.controller, self.say = sheet, formats, controller, say
        self.quick = quick  # a land has two rows: too low for an id to stand upright
        self.widths = [column.width(say) for column in FormColumn]
        origins = (say.sentence(_origin(land)) for land in controller.lands)
        self.widths[FormColumn.ORIGIN] = width_for(origins, self.widths[FormColumn.ORIGIN])
        if quick:
            self.widths[FormColumn.COMPONENT] = max(self.widths[0], 1 + max(map(len, controller.components)))
        printed = tuple(self.widths[: FormColumn.ORIGIN + 1])
        fields = (Paging(printed).row_height,) * (MEASURING_HEADER - len(TITLE_HEIGHTS))  # for a pencil too
        self.paging, self.breaks = Paging(printed, (*TITLE_HEIGHTS, *fields, _HEADINGS_ROW)), list[int]()

    def head(self, fields: Mapping[str, str]) -> None:
        sheet, formats, controller, say = self.sheet, self.formats, self.controller, self.say
        told = Sentence(
            "Controller {id}. Yellow cells are to be filled in. All dimensions in {unit}",
            id=controller.id,
            unit=say.unit("length"),
        )
        told_all = f"{say.sentence(told)}\n{say('how_to_measure.quick' if self.quick else 'how_to_measure.order')}"
        note = say("how_to_measure.nominal_values") if controller.representative else ""
        titles = ((_title(controller, say), "title"), (told_all, "wrap"), (note, "note"))
        for row, (text, form) in enumerate(titles):
            sheet.merge_range(row, 0, row, PICTURES - 1, "", formats[form])
            sheet.write_string(row, 0, text, formats[form])
        gaps = controller.pump.gaps
        left_out = {name for name, slips in ((PUMP_SIDE, gaps.side), (PUMP_TIP, gaps.tips)) if slips is None}
        for field, (row, label, first, last) in PLACES.items():
            if field in left_out - fields.keys():
                continue  # the file does not say what would slip through it
            for start, end, text, form in (
                (label, first - 1, label_of(field, say), "field label"),
                (first, last, fields.get(field, ""), "field"),
            ):
                if end > start:
                    sheet.merge_range(row, start, row, end, "", formats[form])
                sheet.write_string(row, start, text, formats[form])
        sheet.write_string(0, len(FormColumn), MEASUREMENTS.mark, formats["mark"])  # beside what is printed
        for column in FormColumn:
            sheet.write_string(MEASURING_HEADER, column, column.said(say), formats["heading"])
        for row, height in enumerate(self.paging.above):
            sheet.set_row(row, height)
        draw_head(sheet, code_text(controller, fields), say)

    def body(self, rows: Sequence[FormRow], *, drawn: bool) -> None:
        """Write a row for every reading; what several rows share is merged, on each page anew, with its spool drawn."""
        uncut = (blocks_of(rows, _KEYS[coarsest:]) for coarsest in range(len(_KEYS)))
        self.breaks = min(map(self.paging.breaks, uncut), key=len)  # the fewest pages, and then the fewest cuts
        for row in range(len(rows)):
            self.sheet.set_row(MEASURING_HEADER + 1 + row, self.paging.row_height)
        pages = [bisect_right(self.breaks, row) for row in range(len(rows))]
        numbered = list(enumerate(rows, start=MEASURING_HEADER + 1))
        on_pages = {
            first: (last, entry.land.component) for first, last, entry in runs_of_cells(numbered, pages, of_component)
        }
        blocks = [
            ComponentRows(component, first, (last - first + 1) * self.paging.row_height)
            for first, (last, component) in on_pages.items()
        ]
        width = self.paging.widths[FormColumn.NAME]
        with_spool = draw_spools(self.sheet, self.controller, blocks if drawn else (), width, self.say)
        on_top = {block.row for block in with_spool}
        for first, (last, component) in on_pages.items():
            name = self.say.name(self.controller.components[component])
            self._label(
                first,
                last,
                FormColumn.COMPONENT,
                component,
                "text" if self.quick or len(component) <= _NUMBER else "upright",
            )
            self._label(first, last, FormColumn.NAME, name, "on top" if first in on_top else "text")
        for first, last, entry in runs_of_cells(numbered, pages, of_part):
            self._label(first, last, FormColumn.PART, self._part_name(entry), "text")
        for first, last, entry in runs_of_cells(numbered, pages, of_plane):
            self._label(first, last, FormColumn.PLANE, entry.plane, "number")
            self._label(first, last, FormColumn.NOMINAL, self._shown(entry.nominal), "nominal")
            clearance = round(float(self.say.convert(entry.land.mounting_high * UM, "clearance")), 6)
            self._label(first, last, FormColumn.CLEARANCE, clearance, "clearance")
            self._label(first, last, FormColumn.ORIGIN, self.say.sentence(_origin(entry.land)), "origin")
            for row in range(first, last + 1):
                for repeat in range(1, REPEATS + 1):
                    self._deviation(row, first, rows[row - MEASURING_HEADER - 1], repeat)
        self._beyond(range(REPEATS + 1, 1 + max((repeat for row in rows for repeat in row.repeats), default=0)))
        for row, entry in numbered:
            put(self.sheet, row, FormColumn.DIRECTION, entry.direction, self.formats["angle"])
            self.sheet.write_blank(row, FormColumn.TAKEN_AT, None, self.formats["choice"])
            for repeat in {**dict.fromkeys(range(1, REPEATS + 1)), **entry.repeats}:
                form = self.formats["input" if repeat in entry.repeats else "number"]
                for column, metres in zip(of_repeat(repeat), _values(entry.repeats.get(repeat)), strict=True):
                    put(self.sheet, row, column, None if metres is None else self._shown(metres), form)

    def _beyond(self, repeats: range) -> None:
        """Head the columns of repeats that were taken beyond those that the sheet asks for."""
        for repeat in repeats:
            for column, like in zip(
                of_repeat(repeat), (FormColumn.X1, FormColumn.X2, FormColumn.DIAMETER), strict=True
            ):
                key = f"{REPEATED[like.holds][0]}, repeat {repeat}"
                said = heading_of(key, "length", self.say) if key in REPEATED else ""
                self.sheet.write_string(MEASURING_HEADER, column, said, self.formats["heading"])
                self.widths.append(self.widths[like])

    def _part_name(self, entry: FormRow) -> str:
        return self.say.sentence(FORM_PART_NAMES[entry.land.part_name if entry.part == "spool" else "sleeve"])

    def _label(self, first: int, last: int, column: int, value: str | float | None, name: str) -> None:
        """Write one value over several rows, merged as in Table 1."""
        form = self.formats[name]
        if last > first:
            self.sheet.merge_range(first, column, last, column, "", form)
        put(self.sheet, first, column, value, form)

    def _shown(self, metres: float) -> float:
        """Return a length in the unit of the headings, to a tenth of a nanometre: the decimal digits as typed."""
        return round(float(self.say.convert(metres * MM, "length")), 7 if self.say.unit("length") == "mm" else 8)

    def _deviation(self, row: int, first: int, entry: FormRow, repeat: int) -> None:
        one, other, size = (xl_rowcol_to_cell(row, column) for column in of_repeat(repeat))
        reading = entry.repeats.get(repeat)
        given = f"${FormColumn.NOMINAL.letter}${first + 1}"
        nominal = given if self.say.unit("length") == "mm" else _in_mm(given)
        measured = f"IF(ISNUMBER({size}),{_in_mm(size)},ABS({_in_mm(one)}-{_in_mm(other)}))"
        factor = round(float(self.say.convert(UM / MM, "clearance")), 6)
        filled = f"OR(ISNUMBER({size}),AND(ISNUMBER({one}),ISNUMBER({other})))"
        off = None if reading is None else (reading.diameter - entry.nominal) * UM
        known = "" if off is None else round(float(self.say.convert(off, "clearance")), 6)
        self.sheet.write_formula(
            row,
            _DEVIATIONS[repeat - 1],
            f'=IF({filled},{factor:.10g}*({measured}-{nominal}),"")',
            self.formats["deviation"],
            known,
        )

    def _choose(self, rows: tuple[int, int], column: int, choices: Iterable[str], *, others: bool = False) -> None:
        """Let cells be chosen from a list, which commas part; others too where they may be typed."""
        known = [choice for choice in choices if "," not in choice]
        while len(",".join(known)) > _CHOICES:
            known.pop()
        told, title = Sentence("One of the list: {choices}", choices=tuple(known)), Sentence("Not in the list")
        choice = only("list", title, told, self.say, source=known, show_error=not others)
        self.sheet.data_validation(rows[0], column, rows[1], column, choice)

    def set_up(self, rows: int, job: str) -> None:
        """Add what a person needs who fills it in on a screen or on paper."""
        sheet, say, first, last = self.sheet, self.say, MEASURING_HEADER + 1, MEASURING_HEADER + max(rows, 1)
        far = float(say.convert(_FAR, "clearance"))
        sheet.freeze_panes(first, FormColumn.PLANE)
        told = Sentence(
            "A number in the unit of the heading, larger than 0, such as {example}. Leave empty what was not measured.",
            example=Quantity(9.939, "length", 3),
        )
        sizes = only("decimal", Sentence("Not a dimension"), told, say, criteria=">", value=0)
        sheet.data_validation(first, FormColumn.X1, last, FormColumn.SECOND_DIAMETER, sizes)
        self._choose((first, last), FormColumn.TAKEN_AT, [say.sentence(UNWORN_END)])
        parts = [
            self._part_name(FormRow(land, part, "", None, {})) for land in self.controller.lands for part in PLAN_PARTS
        ]
        self._choose((first, last), FormColumn.PART, dict.fromkeys(parts))
        self._choose((first, last), FormColumn.DIRECTION, map(str, _ANGLES), others=True)
        for part, field in INSTRUMENT_ROWS.items():
            place = PLACES[field]
            names = [say.name(name) for name in instruments_for(part)]
            self._choose((place.row, place.row), place.first, names, others=True)
        deviation = _DEVIATIONS[0]
        alarm = {"type": "cell", "criteria": "not between", "minimum": -far, "maximum": far}
        empty = {"type": "formula", "criteria": f"=NOT(ISNUMBER({deviation.letter}{first + 1}))", "stop_if_true": True}
        for rule in (empty, {**alarm, "format": self.formats["alarm"]}):
            sheet.conditional_format(first, deviation, last, _DEVIATIONS[-1], rule)
        self.paging.set_up(sheet, say)
        for column, width in enumerate(self.widths):
            sheet.set_column(column, column, width)
        sheet.set_h_pagebreaks([first + row for row in self.breaks])
        sheet.repeat_rows(MEASURING_HEADER)
        sheet.print_area(0, 0, last, FormColumn.ORIGIN)
        page = say("title.page", page="&P", pages="&N")
        name = " · ".join(filter(None, (job, say.name(self.controller.name))))
        sheet.set_footer(f"&L{name.replace('&', '&&')[:120]}&R{page}")
        sheet.ignore_errors(
            {
                "number_stored_as_text": (
                    f"{FormColumn.COMPONENT.letter}{first + 1}:{FormColumn.DIRECTION.letter}{last + 1}"
                )
            }
        )


def _in_mm(cell: str) -> str:
    """Return the formula of a cell's length in mm, whether its heading says [mm] or [inch]."""
    return f'{cell}*IF(ISNUMBER(FIND("[in",LOWER({cell.lstrip("$")[0]}${MEASURING_HEADER + 1}))),25.4,1)'


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
        return Sentence("diameter assumed")
    return Sentence("clearance assumed") if clearance else AS_STATED
