"""Say which sheets the workbook that describes a valve body has, in the order of its tabs.

What stands in their columns say the models of the file's tables. A key that stood in no column would be lost on the way
through a workbook; a test compares this declaration with the models.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from atleak.catalogue.circuit_tables import (
    CircuitTable,
    ConsumerTable,
    FeedTable,
    LeakTable,
    PermissiblePressureTable,
)
from atleak.catalogue.complaints import ComplaintTable
from atleak.catalogue.controller_tables import (
    ComponentTable,
    ControllerFile,
    GapTable,
    LandTable,
    MaterialTable,
    OperatingPointTable,
    RelationTable,
)
from atleak.catalogue.entries import Evidence
from atleak.catalogue.pump_tables import PumpTable
from atleak.catalogue.repairs import RepairTable
from atleak.catalogue.section_pressures import SECTIONS
from atleak.controller_sheets.circuit_shapes import LINE, SET_BY, ApplyChart, SetPressures
from atleak.controller_sheets.fields import columns_of, in_kind, known_of_all
from atleak.controller_sheets.kinds import Choice, Gears, Number
from atleak.controller_sheets.shapes import Column, Form, NamedTables, Parts, Sheet, Tables, ValuesByPoint
from atleak.controller_sheets.units import CLEARANCES, LENGTHS, PRESSURE, PRESSURES, Measure


@dataclass(frozen=True)
class Offered:
    """The names that a drop-down offers: fixed ones, then those of a column of another sheet."""

    sheet: str
    heading: str
    fixed: tuple[str, ...] = ()


NAMES = {
    "component": Offered("Components", "Id"),
    "circuit": Offered("Circuits", "Id"),
    "line or circuit": Offered("Circuits", "Id", (LINE,)),
    "pressure": Offered("Circuits", "Id", (*SECTIONS, "drain")),
    "section": Offered("Circuits", "Id", SECTIONS),
    "operating point": Offered("Operating points", "Name"),
    "material": Offered("Materials", "Name"),
    "consumer": Offered("Consumers", "Id"),
}

UNIT_LINES = (  # at the head of the first sheet; no keys of the file
    Column("Lengths are in", ("length",), Choice(LENGTHS), required=True),
    Column("Clearances are", ("clearance",), Choice(CLEARANCES), required=True),
    Column("Pressures are in", ("pressure",), Choice(PRESSURES), required=True),
)

_OF_HEAD = in_kind(columns_of(ControllerFile), "Gears", Gears(or_every=False))
_TO_GEARS = [column.heading for column in _OF_HEAD].index("Gears") + 1
HEAD = Form(
    "Head",
    "What this valve body is, and what the numbers of this workbook are written in",
    (*_OF_HEAD[:_TO_GEARS], *known_of_all(LandTable), *_OF_HEAD[_TO_GEARS:]),
    needed=True,
)
_CIRCUIT = Column("Circuit", (), required=True, names="circuit", width=20)

SHEETS: tuple[Sheet, ...] = (
    HEAD,
    NamedTables(
        "Materials",
        "Materials of bodies and spools. The clearance opens with heat where the body expands more than the spool",
        (Column("Name", (), required=True, help="A name of your own"), *columns_of(MaterialTable)),
        ("materials",),
        needed=True,
    ),
    Tables(
        "Components",
        "One row for each valve, damper or end plug. Their lands stand under Lands",
        columns_of(ComponentTable),
        ("components",),
        needed=True,
    ),
    Parts(
        "Lands",
        "One row for each land: a cylindrical section of a spool, as the picture shows",
        (
            Column("Component", (), required=True, names="component", width=28),
            *columns_of(LandTable, last=("planes", "position_mm", "seal", "body", "spool")),
        ),
        ("components",),
        needed=True,
        under="lands",
    ),
    Form(
        "Pump",
        "Either what one revolution displaces, or the dimensions of its kind, from which that follows",
        columns_of(PumpTable, last=("source",), known=Choice((Evidence.MEASURED, Evidence.REPRESENTATIVE))),
        ("pump",),
        needed=True,
    ),
    Tables(
        "Operating points",
        "Conditions at which leakage is judged, the usual one first. Name one hot_idle: there a worn unit fails first",
        columns_of(OperatingPointTable),
        ("operating_points",),
        needed=True,
    ),
    Tables(
        "Circuits",
        "Clutches, bands, control circuits: fed through an orifice (Feeds), held by a regulator (Set pressures), or "
        "both",
        columns_of(CircuitTable, last=("evidence", "set_evidence")),
        ("circuits",),
    ),
    Parts(
        "Feeds",
        "The orifices that supply circuits, mostly holes in the separator plate: measure them with a drill gauge",
        (_CIRCUIT, *columns_of(FeedTable)),
        ("circuits",),
        under="feeds",
    ),
    SetPressures(
        "Set pressures",
        "What regulators hold circuits down to, one row for each pressure. p_g stands for the line",
        (
            Column("Circuit", (), required=True, names="line or circuit", width=20),
            Column("Set by", (), Choice(SET_BY), required=True, width=18),
            Column("Which", (), help="The operating point, gear or circuit", width=20),
            Column("At", (), Number(Measure("mA or %")), help="The solenoid's current or duty"),
            Column("Pressure", (), Number(PRESSURE)),
            Column("Ratio", (), Number(), help="To the pressure of the circuit that it follows"),
            Column("Offset", (), Number(PRESSURE), help="Added to that"),
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
        columns_of(GapTable, last=("section", "published", "evidence")),
        ("gaps",),
    ),
    Tables(
        "Line pressures",
        "Between which values main pressure must lie: by range of the lever, by gear, or both",
        columns_of(PermissiblePressureTable),
        ("permissible_pressure",),
        one=("gear", "gears"),
    ),
    NamedTables(
        "Section pressures",
        "How p_s and p_m follow from main pressure, where a gap uses them",
        (
            Column("Section", (), Choice(("p_s", "p_m"), symbols=True), required=True, width=10),
            *columns_of(RelationTable, last=("source", "evidence")),
        ),
        ("pressures",),
    ),
    Tables(
        "Leaks",
        "What leaks beside the lands: sealing rings, O-rings, check balls, each known from one measurement or "
        "statement",
        columns_of(LeakTable),
        ("leaks",),
    ),
    Tables(
        "Consumers",
        "What takes its flow from the pump and is no leak: converter and cooler, lubrication",
        columns_of(ConsumerTable, without=("flow_dm3_min",)),
        ("consumers",),
    ),
    ValuesByPoint(
        "Consumer flows",
        "How much each consumer takes: one row, or one for every operating point",
        (
            Column("Consumer", (), required=True, names="consumer", width=24),
            Column("Operating point", (), names="operating point", help="Empty: the same at all", width=20),
            *(column for column in columns_of(ConsumerTable) if column.key == "flow_dm3_min"),
        ),
        ("consumers",),
    ),
    Tables(
        "Repairs",
        "What can be done about a worn component: used by the plan of repair and by the estimate",
        columns_of(RepairTable),
        ("repairs",),
    ),
    Tables(
        "Complaints",
        "What customers say, and where the leakage behind it shows",
        columns_of(ComplaintTable),
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
def examples(sheet: Sheet) -> tuple[Mapping[str, Any], ...]:
    """Return the rows of a sheet that show how it is filled in."""
    text = (Path(__file__).parent / "example.toml").read_text(encoding="utf-8")
    return tuple(sheet.rows(tomllib.loads(text)))
