"""Describe what can be typed on a page: valve bodies, limits, instruments and fluids."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import CONTROLLERS, checked_controller
from atleak.catalogue.entries import Evidence
from atleak.catalogue.fluid import FLUIDS, DensityTable, FluidFile, PropertyTable, ViscosityTable
from atleak.catalogue.instruments import INSTRUMENTS, InstrumentFile
from atleak.catalogue.keys import LIMIT, Key, key_of
from atleak.catalogue.limits import BESIDE_LIMIT, LIMIT_SETS, LevelLimit, LevelTable, LimitsFile
from atleak.catalogue.workbook.cells import ChoiceCell
from atleak.catalogue.workbook.draft import Subject
from atleak.catalogue.workbook.shapes import Form, SheetColumn, Tables
from atleak.catalogue.workbook.sheets import NAMES, SHEETS, kind_of_sheet, sheet_columns
from atleak.common.errors import CatalogueError, KeySteps
from atleak.common.file_faults import model_in

CONTROLLER = Subject(CONTROLLERS, SHEETS, NAMES)
_LAND_KEYS = ("land", "nominal_diameter_mm", "contact_length_mm")  # what a drawing needs


def sketch(data: Mapping[str, Any]) -> Controller | None:
    """Return a controller with the components and lands that can be drawn so far; None without any.

    Nothing of it is for computing: all but sizes and names is made up.
    """
    components = {}
    length = data.get("defaults", {}).get("contact_length_mm")
    for table in data.get("components", ()):
        lands = {
            land["land"]: {"contact_length_mm": length or 5.0} | {key: land[key] for key in _LAND_KEYS if key in land}
            for land in table.get("lands", ())
            if "land" in land and "nominal_diameter_mm" in land
        }
        good = [land for land in lands.values() if _controller_of([{"id": "one", "name": "one", "lands": [land]}])]
        if "id" in table and good:
            components[table["id"]] = {"id": table["id"], "name": table.get("name", table["id"]), "lands": good}
    return _controller_of([*components.values()]) if components else None


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


@dataclass(frozen=True)
class LevelColumn(SheetColumn):
    """A field of a level of limits, which a file states as a plain number where it says nothing but the limit itself.

    A fault of the whole level is one of the limit.
    """

    def of(self, table: Mapping[str, Any], end: int | None = None) -> Any:
        stated = table.get(self.keys[0])
        plain = {} if isinstance(stated, Mapping) else {self.keys[0]: {LIMIT: stated}}
        return super().of({**table, **plain}, end)

    def put(self, table: dict[str, Any], value: Any) -> None:
        level, key = self.keys
        if key == LIMIT:  # the first of a level; what could not be read stays a cell of its own
            table[level] = value if isinstance(value, float) else {LIMIT: value}
            return
        stated = table.get(level, {})
        table[level] = {**(stated if isinstance(stated, Mapping) else {LIMIT: stated}), key: value}

    def steps(self) -> list[KeySteps]:
        return [self.keys[:1], self.keys] if self.key == LIMIT else [self.keys]


def _head(about: str, columns: tuple[SheetColumn, ...]) -> Form:
    """Return the form of the head: the id is made from the name unless it is typed."""
    id, *others = columns
    id = replace(id, required=False, help="Small letters, digits and _; made from the name unless stated")
    return Form("Head", about, (others[0], id, *others[1:]), needed=True)


# --- limits -------------------------------------------------------------------------------------------------------

_TABLES = {name for name, field in LimitsFile.model_fields.items() if model_in(field.annotation) is not None}
_OF_LEVELS = _TABLES - {"reserve"}  # whose levels are numbers, or tables


def _limit_form(name: str) -> Form:
    field = LimitsFile.model_fields[name]
    described, model = key_of(field), model_in(field.annotation)
    assert described is not None
    assert model is not None
    of_levels = (
        tuple(column for level in model.model_fields for column in _of_level(name, level)) if name in _OF_LEVELS else ()
    )
    others = sheet_columns(model, last=("origin", "source"))
    return Form(
        described.heading, described.help, (*of_levels, *(replace(each, required=False) for each in others)), (name,)
    )


def _of_level(name: str, level: str) -> Iterator[SheetColumn]:
    """Yield the fields of a level: the limit itself, and what else may be asked for."""
    if level in LevelTable.model_fields:
        return
    heading = level.capitalize()
    yield LevelColumn(heading, (level, LIMIT), kind_of_sheet(name, float, Key()))
    others = LevelLimit.model_fields.keys() - set(BESIDE_LIMIT.get(name, ()))
    for column in sheet_columns(LevelLimit, without=others):
        yield LevelColumn(f"{heading}: {column.heading}", (level, column.key), column.kind, help=column.help)


LIMITS = Subject(
    LIMIT_SETS,
    (
        _head("What these limits are, and whose", sheet_columns(LimitsFile, without=_TABLES)),
        *(_limit_form(name) for name in LimitsFile.model_fields if name in _TABLES),
    ),
)

# --- instruments --------------------------------------------------------------------------------------------------

_OF_HEAD = ("id", "name", "source", "date", "note", "measures")
INSTRUMENT = Subject(
    INSTRUMENTS,
    (
        _head(
            "What this instrument is, and where its numbers come from",
            sheet_columns(InstrumentFile, without=InstrumentFile.model_fields.keys() - set(_OF_HEAD)),
        ),
        Form(
            "Uncertainty",
            "Standard uncertainties of one diameter: of a certificate that says U = 3 µm with k = 2, 1.5 µm",
            sheet_columns(
                InstrumentFile,
                without=_OF_HEAD,
                last=("alike_inside_and_outside",),
                known=ChoiceCell((Evidence.REPRESENTATIVE,)),
                known_help="Empty: from a certificate or a measurement",
            ),
        ),
    ),
)

# --- fluids -------------------------------------------------------------------------------------------------------

FLUID = Subject(
    FLUIDS,
    (
        _head(
            "What this fluid is, and where its numbers come from",
            sheet_columns(FluidFile, last=("representative", "study_regression")),
        ),
        Form(
            "Density",
            "One value of the data sheet, and how it falls with temperature",
            sheet_columns(DensityTable),
            ("density",),
        ),
        Tables(
            "Viscosity",
            "Points of the data sheet, two at least: usually at 40 and 100 °C",
            sheet_columns(ViscosityTable),
            ("viscosity",),
        ),
        Tables(
            "Table",
            "Where a source tabulates viscosity and density together; may be left empty",
            sheet_columns(PropertyTable),
            ("table",),
        ),
    ),
)

SUBJECTS: Mapping[str, Subject] = MappingProxyType({each.kind: each for each in (LIMITS, INSTRUMENT, FLUID)})
"""By folder of the catalogue."""
