"""A valve body as it is typed on a page: tables of text, which become the tables of its file, and the faults in them.

The tables and their columns are those of `atleak.controller_sheets`. What is typed stays as it is, sign for sign,
whether or not it can be read.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import checked_controller
from atleak.catalogue.entries import id_from_name
from atleak.controller_sheets.description import Description, Fault, Row, Spot
from atleak.controller_sheets.kinds import Kind, NotAccepted
from atleak.controller_sheets.layout import HEAD, SHEETS
from atleak.controller_sheets.meaning import doubts, fault_of_cell
from atleak.controller_sheets.shapes import Column, Sheet
from atleak.controller_sheets.units import Units
from atleak.errors import CatalogueError, InputError

Cells = Mapping[str, str]
"""A row by the headings of its columns; a heading that is missing is an empty cell."""

_SHEETS = {sheet.name: sheet for sheet in SHEETS}
_FORMAT = 1
_DIGITS = range(15, 18)  # of a computed number
_COMPUTED = re.compile(r"-?\d+\.\d+(?:e[+-]\d+)?|-?\d{15,17}")
_LAND_KEYS = ("land", "nominal_diameter_mm", "contact_length_mm")  # what a drawing needs


@dataclass(frozen=True)
class FormFault:
    """What is wrong, and where: table, number of its row from 1 and heading, each as far as it is known."""

    table: str
    row: int | None
    heading: str | None
    text: str

    @property
    def where(self) -> str:
        """Return row and column in words."""
        of_form = self.table in _SHEETS and _SHEETS[self.table].is_form
        row = None if self.row is None or of_form else f"row {self.row}"
        return ", ".join(part for part in (row, self.heading) if part)


@dataclass(frozen=True)
class Draft:
    """What is typed so far: by table the rows, and the units in which its numbers are typed."""

    units: Units = Units()  # noqa: RUF009  frozen
    tables: Mapping[str, tuple[Cells, ...]] = field(default_factory=dict)

    def rows(self, table: str) -> tuple[Cells, ...]:
        """Return the rows of a table; those of a form are one."""
        rows = self.tables.get(table, ())
        return rows or ({},) if _SHEETS[table].is_form else rows

    def cell(self, table: str, heading: str) -> str:
        """Return what stands in a field of a form."""
        return self.rows(table)[0].get(heading, "")

    def with_rows(self, table: str, rows: Iterable[Cells]) -> Draft:
        """Return the draft with other rows of a table; empty ones keep their place, but not at the end."""
        kept = [{heading: text for heading, text in row.items() if text.strip()} for row in rows]
        while kept and not kept[-1]:
            kept.pop()
        return replace(self, tables={**self.tables, table: tuple(kept)})

    def with_cell(self, table: str, heading: str, text: str) -> Draft:
        """Return the draft with another text in a field of a form."""
        return self.with_rows(table, [{**self.rows(table)[0], heading: text}])

    def in_units(self, units: Units) -> Draft:
        """Return the same valve body typed in other units, each number converted exactly; what is none stays."""
        tables = {
            name: tuple(
                {heading: _converted(_SHEETS[name], heading, text, self.units, units) for heading, text in row.items()}
                for row in rows
            )
            for name, rows in self.tables.items()
        }
        return Draft(units, tables)

    def written(self) -> str:
        """Return the draft as JSON, which `read_draft` reads."""
        return json.dumps({"format": _FORMAT, "units": asdict(self.units), "tables": self.tables}, ensure_ascii=False)


@dataclass(frozen=True)
class Checked:
    """What a draft describes: the tables of a file, the controller where nothing is wrong, else every fault."""

    data: Mapping[str, Any]
    controller: Controller | None
    faults: tuple[FormFault, ...]
    notes: tuple[str, ...]  # what was taken for granted, in sentences

    def of(self, table: str) -> tuple[FormFault, ...]:
        """Return the faults in one table."""
        return tuple(fault for fault in self.faults if fault.table == table)


def draft_of(data: Mapping[str, Any], units: Units = Units()) -> Draft:  # noqa: B008  frozen
    """Return a controller's tables as a draft, typed in these units."""
    draft = Draft(units)
    for sheet in SHEETS:
        columns = {column.heading: column for column in sheet.columns_for(data)}
        rows = [
            {heading: _text(columns[heading].kind, value, units) for heading, value in row.items()}
            for row in sheet.rows(data)
        ]
        draft = draft.with_rows(sheet.name, rows)
    return draft


def copy_of(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a controller's tables as those of another one: under another name, from which its id will be made."""
    return {key: value for key, value in data.items() if key != "id"} | {"name": f"{data['name']}, own copy"}


def read_draft(text: str) -> Draft | None:
    """Read a draft that was kept; None where it is damaged or of another version."""
    try:
        stored = json.loads(text)
        if stored["format"] != _FORMAT:
            return None
        draft = Draft(Units(**stored["units"]))
        for name, rows in stored["tables"].items():
            if name in _SHEETS:
                draft = draft.with_rows(name, [{str(key): str(cell) for key, cell in row.items()} for row in rows])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return draft


def checked(draft: Draft) -> Checked:
    """Read a draft and check it as its file would be, and name everything that is wrong in one list."""
    into, rows = Description(), {}
    for sheet in SHEETS:
        rows[sheet.name] = _rows(draft, sheet, into)
        sheet.fill(rows[sheet.name], into)
    if "id" not in into.data and (made := id_from_name(into.data.get("name", "unnamed"))):
        into.data["id"] = made
    faults = [_of_cell(fault) for fault in into.faults]
    controller = None
    try:
        controller = checked_controller(into.data)
    except CatalogueError as error:
        further = [fault for fault in (error, *error.others) if not into.is_unread(fault.place.steps)]
        faults += [_of_cell(_in_its_cell(fault, into, rows, draft.units)) for fault in further]
    order = {name: number for number, name in enumerate(_SHEETS)}
    faults = sorted(dict.fromkeys(faults), key=lambda fault: (order.get(fault.table, -1), fault.row or 0))
    wrong = {(fault.table, fault.row, fault.heading) for fault in faults}
    for sheet in SHEETS:
        asked = (_of_cell(Fault(spot, text)) for spot, text in doubts(sheet, rows[sheet.name], draft.units))
        into.notes += [
            f"{doubt.table}, {doubt.where}: {doubt.text}"
            for doubt in asked
            if (doubt.table, doubt.row, doubt.heading) not in wrong
        ]
    return Checked(into.data, None if faults else controller, tuple(faults), tuple(into.notes))


def sketch(data: Mapping[str, Any]) -> Controller | None:
    """Return a controller with the components and lands that can be drawn so far; None without any.

    Nothing of it is for computing: all but sizes and names is made up.
    """
    components = []
    length = data.get("defaults", {}).get("contact_length_mm")
    for table in data.get("components", ()):
        lands = {
            land["land"]: {"contact_length_mm": length or 5.0} | {key: land[key] for key in _LAND_KEYS if key in land}
            for land in table.get("lands", ())
            if "land" in land and "nominal_diameter_mm" in land
        }
        good = [land for land in lands.values() if _can_be_drawn(land)]
        if "id" in table and good:
            components.append({"id": table["id"], "name": table.get("name", table["id"]), "lands": good})
    known = {table["id"]: table for table in components}
    return _controller_of(list(known.values())) if known else None


def _can_be_drawn(land: Mapping[str, Any]) -> bool:
    return _controller_of([{"id": "one", "name": "one", "lands": [land]}]) is not None


def _controller_of(components: Sequence[Mapping[str, Any]]) -> Controller | None:
    made_up = "made up for a drawing"
    stand_in = {
        "id": "drawing", "name": "drawing", "source": made_up, "date": "2000-01-01", "gears": [1],
        "materials": {"any": {"expansion_per_k": 1e-5, "source": made_up}},
        "defaults": {"mounting_clearance_um": 10.0, "body": "any", "spool": "any"},
        "pump": {"displacement_mm3": 1.0, "volumetric_efficiency": 1.0, "source": made_up},
        "operating_points": [
            {"name": "any", "label": "any", "temperature_c": 20.0, "engine_rpm": 1000.0, "gear": 1, "p_g_kpa": 1.0,
             "p_k_kpa": 0.0, "source": made_up}
        ],
    }  # fmt: skip
    try:
        return checked_controller({**stand_in, "components": list(components)})
    except CatalogueError:
        return None


# --- cells --------------------------------------------------------------------------------------------------------


def _rows(draft: Draft, sheet: Sheet, into: Description) -> list[Row]:
    """Read the cells of a table; each that cannot be read is a fault."""
    rows = []
    for number, cells in enumerate(draft.rows(sheet.name), start=1):
        if not cells and not sheet.is_form:
            continue
        spot, values = Spot(sheet.name, number), {}
        for heading, text in cells.items():
            column = _column(sheet, heading)
            if column is None:
                into.faults.append(Fault(replace(spot, heading=heading), "no column of this table", text))
                continue
            try:
                values[heading] = column.kind.value(_cell(text), draft.units)
            except NotAccepted as error:
                into.faults.append(Fault(replace(spot, heading=heading), "cannot be read", text, str(error)))
        rows.append(Row(spot, dict(cells), values))
    return rows


def _column(sheet: Sheet, heading: str) -> Column | None:
    declared = next((column for column in sheet.columns if column.heading == heading), None)
    return declared or sheet.further_column(heading)


def _converted(sheet: Sheet, heading: str, text: str, before: Units, after: Units) -> str:
    column = _column(sheet, heading)
    if column is None or column.kind.label(before) == column.kind.label(after):
        return text
    try:
        return _text(column.kind, column.kind.value(_cell(text), before), after)
    except NotAccepted:
        return text


def _text(kind: Kind, value: Any, units: Units) -> str:
    """Return what is typed for a value of the file, so that it is read back to the last digit."""
    cell = kind.cell(value, units)
    if isinstance(cell, float):
        texts = (f"{cell:.{digits}g}" for digits in _DIGITS)
        return next((text for text in texts if kind.value(_cell(text), units) == value), repr(cell))
    return str(cell)


def _cell(text: str) -> str | float:
    """Return a text as a cell: a number of so many digits was computed, not typed, and is one of a workbook's."""
    digits = len(text.split("e")[0].replace(".", "").lstrip("-0"))
    return float(text) if digits in _DIGITS and _COMPUTED.fullmatch(text) else text


# --- faults -------------------------------------------------------------------------------------------------------


def _of_cell(fault: Fault) -> FormFault:
    said = str(InputError(fault.problem, value=fault.value, expected=fault.expected, nearest=fault.nearest))
    return FormFault(fault.spot.sheet, fault.spot.row, fault.spot.heading, said)


def _in_its_cell(error: InputError, into: Description, rows: Mapping[str, Sequence[Row]], units: Units) -> Fault:
    """Return a fault of the tables where it stands on the page."""
    spot = into.spot(error.place.steps)
    if spot is None:
        sheet = next((sheet for sheet in SHEETS if sheet.at[:1] == error.place.steps[:1]), HEAD)
        problem = "nothing is filled in yet" if len(error.place.steps) == 1 else error.problem
        return Fault(Spot(sheet.name), problem, error.value, error.expected, error.nearest)
    row = next((row for row in rows[spot.sheet] if row.spot.row == spot.row), None)
    column = None if spot.heading is None else _column(_SHEETS[spot.sheet], spot.heading)
    if row is not None and column is not None:
        return fault_of_cell(error, column, row, units)
    problem = error.problem if row is None or row.cells else "nothing is filled in yet"
    return Fault(spot, problem, error.value, error.expected, error.nearest)
