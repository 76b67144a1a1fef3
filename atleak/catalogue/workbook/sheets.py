"""List the sheets of the workbook that describes a valve body, in the order of its tabs.

Their columns follow from the keys of the file's tables, as the models describe them. A key that stood in no column
would be lost on the way through a workbook; a test compares this list with the models.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.controller_tables import (
    CircuitTable,
    ComponentTable,
    ConsumerTable,
    ControllerFile,
    FeedTable,
    GapTable,
    LandTable,
    LeakTable,
    MaterialTable,
    OperatingPointTable,
    PermissiblePressureTable,
    RelationTable,
)
from atleak.catalogue.entries import Evidence
from atleak.catalogue.keys import Key, key_of, unit_of
from atleak.catalogue.pump_tables import PumpTable
from atleak.catalogue.repairs import ALL, PUMP, ComplaintTable, RepairTable
from atleak.catalogue.workbook.cells import (
    CLEARANCE,
    CLEARANCES,
    LENGTHS,
    MEASURES,
    PRESSURE,
    PRESSURES,
    CellForm,
    ChoiceCell,
    Day,
    Gear,
    Gears,
    Measure,
    Names,
    Number,
    Whole,
    Wholes,
    YesNo,
)
from atleak.catalogue.workbook.circuit_sheets import LINE_SHEET, SET_BY, ApplyChart, SetPressures
from atleak.catalogue.workbook.shapes import (
    Form,
    KnownOfAll,
    NamedTables,
    OneOrSeveral,
    Parts,
    SheetColumn,
    Tables,
    ValuesByPoint,
    WorkbookSheet,
)
from atleak.common.file_faults import model_in

EVIDENCE = ChoiceCell(tuple(Evidence))
_OF_ALL = "How known, of all lands that do not say otherwise; empty: not stated"
_OWN_KINDS: dict[str, CellForm] = {  # by key
    "date": Day(),
    "gear": Gear(),
    "gears": Gears(),
    "components": Names(or_every=True),
}


def sheet_columns(
    model: type[BaseModel],
    at: tuple[str, ...] = (),
    *,
    without: Collection[str] = (),
    last: Sequence[str] = (),
    known: ChoiceCell = EVIDENCE,
    known_help: str = "Empty: as the head says",
) -> tuple[SheetColumn, ...]:
    """Return the columns of a table's keys, and of those of the tables in it that have no sheet of their own.

    Parameters
    ----------
    at
        the keys that lead to it from the table of the sheet.
    without, last
        keys that have no column here, and keys that come after the others.
    known, known_help
        what a value can be known from, where a column says it, and the help of that column.
    """
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    columns: list[SheetColumn] = []
    for name in (*(name for name in fields if name not in {*last, *without}), *last):
        field, described = fields[name], key_of(fields[name])
        if described is None:
            continue
        inner = model_in(field.annotation)
        if described.heading:
            columns += _columns(name, field, described, at)
            if described.known:
                columns.append(SheetColumn(described.known, (), known, help=known_help, how_known=name, width=15))
        elif inner is not None:
            columns += sheet_columns(inner, (*at, name))
    return tuple(columns)


def known_of_all(model: type[BaseModel]) -> tuple[SheetColumn, ...]:
    """Return the columns of the head that say how values of all these tables are known."""
    described = {name: key_of(field) for name, field in model.model_fields.items()}
    return tuple(
        KnownOfAll(each.known_of_all, (), EVIDENCE, value_of_all=name, help=_OF_ALL)
        for name, each in described.items()
        if each is not None and each.known_of_all
    )


def with_other(columns: Iterable[SheetColumn], heading: str, **changes: Any) -> tuple[SheetColumn, ...]:
    """Return columns of which one is otherwise than its key says."""
    return tuple(replace(each, **changes) if each.heading == heading else each for each in columns)


def kind_of_sheet(name: str, annotation: Any, described: Key) -> CellForm:
    """Return what cells hold for a key: by its name, which ends in its unit, and by its type."""
    if name in _OWN_KINDS:
        return _OWN_KINDS[name]
    unit, plain = described.unit or unit_of(name)[1].label, _bare(annotation)
    if plain is int:
        return Whole(unit)
    if unit or plain is float:
        return Number(_measure(unit, described))
    if plain is bool:
        return YesNo()
    if get_origin(plain) is Literal:
        return ChoiceCell(get_args(plain))
    if isinstance(plain, type) and issubclass(plain, Enum):
        return ChoiceCell(tuple(plain))
    if get_origin(plain) is list:
        each = _bare(get_args(plain)[0])
        return Wholes() if each is int else Names(get_args(each) if get_origin(each) is Literal else ())
    return CellForm()


def _columns(name: str, field: FieldInfo, described: Key, at: tuple[str, ...]) -> list[SheetColumn]:
    column = (partial(OneOrSeveral, one=described.one) if described.one else SheetColumn)(
        described.heading,
        (*at, name),
        kind_of_sheet(name, field.annotation, described),
        required=field.is_required() and not at,
        help=described.help,
        names=described.names,
        width=described.width,
    )
    heading, help = described.up_to
    if not heading:
        return [column]
    return [replace(column, end=0), replace(column, heading=heading, help=help, end=1)]


def _measure(unit: str, described: Key) -> Measure:
    measure = CLEARANCE if described.radial else MEASURES.get(unit, Measure(unit))
    if described.usual is None or measure.quantity != "length":
        return measure
    of_land = described.radial or unit == "mm"  # what manuals state in either unit, or as bore minus spool
    return replace(measure, usual=described.usual.ends, is_doubted=of_land)


def _bare(annotation: Any) -> Any:
    """Return a type without None and without what pydantic is told of it."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return _bare(next(each for each in get_args(annotation) if each is not type(None)))
    return annotation


@dataclass(frozen=True)
class Offered:
    """The names that a drop-down offers: fixed ones, then those of a column of another sheet."""

    sheet: str
    heading: str
    fixed: tuple[str, ...] = ()


NAMES = {
    "component": Offered("Components", "Id"),
    "repaired part": Offered("Components", "Id", (ALL, PUMP)),
    "circuit": Offered("Circuits", "Id"),
    "line or circuit": Offered("Circuits", "Id", (LINE_SHEET,)),
    "pressure": Offered("Circuits", "Id", (*SECTIONS, "drain")),
    "section": Offered("Circuits", "Id", SECTIONS),
    "operating point": Offered("Operating points", "Name"),
    "material": Offered("Materials", "Name"),
    "consumer": Offered("Consumers", "Id"),
}

UNIT_LINES = (  # at the head of the first sheet; no keys of the file
    SheetColumn("Lengths are in", ("length",), ChoiceCell(LENGTHS), required=True),
    SheetColumn("Clearances are", ("clearance",), ChoiceCell(CLEARANCES), required=True),
    SheetColumn("Pressures are in", ("pressure",), ChoiceCell(PRESSURES), required=True),
)

_OF_HEAD = with_other(sheet_columns(ControllerFile), "Gears", kind=Gears(or_every=False))
_TO_GEARS = [column.heading for column in _OF_HEAD].index("Gears") + 1
HEAD = Form(
    "Head",
    "What this valve body is, and what the numbers of this workbook are written in",
    (*_OF_HEAD[:_TO_GEARS], *known_of_all(LandTable), *_OF_HEAD[_TO_GEARS:]),
    needed=True,
)
_CIRCUIT = SheetColumn("Circuit", (), required=True, names="circuit", width=20)

SHEETS: tuple[WorkbookSheet, ...] = (
    HEAD,
    NamedTables(
        "Materials",
        "Materials of bodies and spools. The clearance opens with heat where the body expands more than the spool",
        (SheetColumn("Name", (), required=True, help="A name of your own"), *sheet_columns(MaterialTable)),
        ("materials",),
        needed=True,
    ),
    Tables(
        "Components",
        "One row for each valve, damper or end plug. Their lands stand under Lands",
        sheet_columns(ComponentTable),
        ("components",),
        needed=True,
    ),
    Parts(
        "Lands",
        "One row for each land: a cylindrical section of a spool, as the picture shows",
        (
            SheetColumn("Component", (), required=True, names="component", width=28),
            *sheet_columns(LandTable, last=("planes", "position_mm", "seal", "body", "spool")),
        ),
        ("components",),
        needed=True,
        under="lands",
    ),
    Form(
        "Pump",
        "Either what one revolution displaces, or the dimensions of its kind, from which that follows",
        sheet_columns(PumpTable, last=("source",)),
        ("pump",),
        needed=True,
    ),
    Tables(
        "Operating points",
        "Conditions at which leakage is judged, the usual one first. Name one hot_idle: there a worn unit fails first",
        sheet_columns(OperatingPointTable),
        ("operating_points",),
        needed=True,
    ),
    Tables(
        "Circuits",
        "Clutches, bands, control circuits: fed through an orifice (Feeds), held by a regulator (Set pressures), or "
        "both",
        sheet_columns(CircuitTable, last=("evidence", "set_evidence")),
        ("circuits",),
    ),
    Parts(
        "Feeds",
        "The orifices that supply circuits, mostly holes in the separator plate: measure them with a drill gauge",
        (_CIRCUIT, *sheet_columns(FeedTable)),
        ("circuits",),
        under="feeds",
    ),
    SetPressures(
        "Set pressures",
        "What regulators hold circuits down to, one row for each pressure. p_g stands for the line",
        (
            SheetColumn("Circuit", (), required=True, names="line or circuit", width=20),
            SheetColumn("Set by", (), ChoiceCell(SET_BY), required=True, width=18),
            SheetColumn("Which", (), help="The operating point, gear or circuit", width=20),
            SheetColumn("At", (), Number(Measure("mA or %")), help="The solenoid's current or duty"),
            SheetColumn("Pressure", (), Number(PRESSURE)),
            SheetColumn("Ratio", (), Number(), help="To the pressure of the circuit that it follows"),
            SheetColumn("Offset", (), Number(PRESSURE), help="Added to that"),
        ),
    ),
    ApplyChart(
        "Apply chart",
        "An x where a circuit is applied; without a row it is in every gear. Change the gears in the headings",
        (_CIRCUIT,),
    ),
    Tables(
        "Gaps",
        "Which pressures each land parts, and when. Without any row every land leaks from main pressure to the drain",
        sheet_columns(GapTable, last=("section", "published", "evidence")),
        ("gaps",),
    ),
    Tables(
        "Line pressures",
        "Between which values main pressure must lie: by range of the lever, by gear, or both",
        sheet_columns(PermissiblePressureTable),
        ("permissible_pressure",),
    ),
    NamedTables(
        "Section pressures",
        "How p_s and p_m follow from main pressure, where a gap uses them",
        (
            SheetColumn("Section", (), ChoiceCell(("p_s", "p_m"), symbols=True), required=True, width=10),
            *sheet_columns(RelationTable, last=("source", "evidence")),
        ),
        ("pressures",),
    ),
    Tables(
        "Leaks",
        "What leaks beside the lands: sealing rings, O-rings, check balls, each known from one measurement or "
        "statement",
        sheet_columns(LeakTable),
        ("leaks",),
    ),
    Tables(
        "Consumers",
        "What takes its flow from the pump and is no leak: converter and cooler, lubrication",
        sheet_columns(ConsumerTable, without=("flow_dm3_min",)),
        ("consumers",),
    ),
    ValuesByPoint(
        "Consumer flows",
        "How much each consumer takes: one row, or one for every operating point",
        (
            SheetColumn("Consumer", (), required=True, names="consumer", width=24),
            SheetColumn("Operating point", (), names="operating point", help="Empty: the same at all", width=20),
            *(column for column in sheet_columns(ConsumerTable) if column.key == "flow_dm3_min"),
        ),
        ("consumers",),
    ),
    Tables(
        "Repairs",
        "What can be done about a worn component, or the pump: used by the plan of repair and by the estimate",
        with_other(sheet_columns(RepairTable), "Component", required=True),
        ("repairs",),
    ),
    Tables(
        "Complaints",
        "What customers say, and where the leakage behind it shows",
        sheet_columns(ComplaintTable),
        ("complaints",),
    ),
)
"""Every sheet, in the order in which a workbook is written and read: an id stands before it is used."""
INSTRUCTIONS = "How to fill in"

NOTE_HEADING, UNIT_MARK, EXAMPLE_MARK = "Note", "unit", "e.g."
"""The first column of every sheet: it marks the row of units and of examples; all else in it is a remark, not read."""
FIELD, VALUE, UNIT, HOW_KNOWN, ABOUT = FORM_HEADINGS = ("Field", "Value", "Unit", "How known", "About")
LISTS = "Lists"
"""A hidden sheet with the names that drop-downs offer."""


@cache
def examples(sheet: WorkbookSheet) -> tuple[Mapping[str, Any], ...]:
    """Return the rows of a sheet that show how it is filled in."""
    text = (Path(__file__).parent / "example.toml").read_text(encoding="utf-8")
    return tuple(sheet.rows(tomllib.loads(text)))
