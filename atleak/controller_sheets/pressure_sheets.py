"""Declare the sheets about pressures: circuits with all that belongs to them, gaps, leaks and consumers."""

from __future__ import annotations

from typing import get_args

from atleak.catalogue.circuit_tables import SelectorRange, StandingState
from atleak.controller_sheets.circuit_shapes import SET_BY, ApplyChart, SetPressures
from atleak.controller_sheets.kinds import Choice, Gears, Names, Number, Whole, YesNo
from atleak.controller_sheets.shapes import (
    KPA,
    MM,
    OF_ORIFICE,
    PLAIN,
    Column,
    NamedTables,
    Parts,
    Tables,
    ValuesByPoint,
    evidence,
    in_unit,
    source,
)
from atleak.controller_sheets.units import Measure

CIRCUITS = Tables(
    "Circuits",
    "Clutches, bands, control circuits: fed through an orifice (Feeds), held by a regulator (Set pressures), or both",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _", width=20),
        Column("Name", ("name",), required=True, width=30),
        source(),
        evidence(heading="Gears are"),
        evidence("set_evidence", "Set pressure is"),
    ),
    ("circuits",),
    examples=(
        {
            "Id": "forward_clutch",
            "Name": "forward clutch",
            "Source": "application chart, page 8",
            "Gears are": "published",
        },
    ),
)

FEEDS = Parts(
    "Feeds",
    "The orifices that supply circuits, mostly holes in the separator plate: measure them with a drill gauge",
    (
        Column("Circuit", (), required=True, names="circuit", width=20),
        Column("Fed from", ("from",), required=True, names="section", help="p_g is the line", width=20),
        Column("Diameter", ("diameter_mm",), OF_ORIFICE, required=True),
        Column("Discharge coefficient", ("discharge_coefficient",), PLAIN, help="0.62 unless stated"),
        evidence(),
    ),
    ("circuits",),
    examples=({"Circuit": "forward_clutch", "Fed from": "p_g", "Diameter": 1.6, "How known": "measured"},),
    under="feeds",
)

SET_PRESSURES = SetPressures(
    "Set pressures",
    "What regulators hold circuits down to, one row for each pressure. p_g stands for the line",
    (
        Column("Circuit", (), required=True, names="line or circuit", width=20),
        Column("Set by", (), Choice(SET_BY), required=True, width=18),
        Column("Which", (), help="The operating point, gear or circuit", width=20),
        Column("At", (), Number(Measure("mA or %")), help="The solenoid's current or duty"),
        Column("Pressure", (), KPA),
        Column("Ratio", (), PLAIN, help="To the pressure of the circuit that it follows"),
        Column("Offset", (), KPA, help="Added to that"),
    ),
    examples=(
        {"Circuit": "epc", "Set by": "solenoid current", "At": 100.0, "Pressure": 620.0},
        {"Circuit": "epc", "Set by": "solenoid current", "At": 1000.0, "Pressure": 20.0},
    ),
)

APPLY_CHART = ApplyChart(
    "Apply chart",
    "An x where a circuit is applied; without a row it is in every gear. Change the gears in the headings",
    (Column("Circuit", (), required=True, names="circuit", width=20),),
    examples=({"Circuit": "forward_clutch", "1": True, "2": True, "3": True},),
)

GAPS = Tables(
    "Gaps",
    "Which pressures each land parts, and when. Without any row every land leaks from main pressure to the drain",
    (
        Column("Component", ("component",), required=True, names="component", width=28),
        Column("Land", ("land",), Whole(), required=True, width=7),
        Column("From", ("from",), required=True, names="pressure", help="Also a share of one: 0.5*p_m", width=18),
        Column("To", ("to",), required=True, names="pressure", help="Also 0.1*p_g, 35 kPa or drain", width=18),
        Column("Gears", ("gears",), Gears(), required=True, help="Such as R N 1 2, 1-5 or all", width=18),
        Column("Ends in", ("ends_in",), Choice(("sump", "section")), help="Follows from To unless stated"),
        Column("Section", ("section",), help="Need not be said: follows from From"),
        Column("Published", ("published",), YesNo(), help="Of older files: yes is published"),
        evidence(),
    ),
    ("gaps",),
    examples=(
        {
            "Component": "boost_valve",
            "Land": 1,
            "From": "epc",
            "To": "drain",
            "Gears": [-1, 1, 2, 3],
            "How known": "representative",
        },
    ),
)

LINE_PRESSURES = Tables(
    "Line pressures",
    "Between which values main pressure must lie: by range of the lever, by gear, or both",
    (
        Column("Ranges", ("ranges",), Names(get_args(SelectorRange)), help="Of the lever, such as P N", width=12),
        Column("Gears", ("gears",), Gears(), help="R N 1 2 or all; one of both is needed", width=16),
        Column("State", ("state",), Choice(get_args(StandingState)), required=True),
        Column("Lowest", ("low_kpa",), KPA),
        Column("Highest", ("high_kpa",), KPA),
        source(),
        evidence(),
    ),
    ("permissible_pressure",),
    one=("gear", "gears"),
    examples=(
        {
            "Ranges": ["D"],
            "Gears": [1, 2, 3],
            "State": "idle",
            "Lowest": 758.0,
            "Highest": 1034.0,
            "Source": "pressure chart, page 3",
            "How known": "published",
        },
    ),
)

SECTION_PRESSURES = NamedTables(
    "Section pressures",
    "How p_s and p_m follow from main pressure, where a gap uses them",
    (
        Column("Section", (), Choice(("p_s", "p_m"), symbols=True), required=True, width=10),
        Column("Relation", ("relation",), Choice(("line", "spool_balance")), required=True),
        Column("Ratio", ("ratio",), PLAIN, help="Of a line"),
        Column("Offset", ("offset_kpa",), KPA, help="Of a line"),
        Column("Limit", ("limit_kpa",), KPA, help="It does not rise above"),
        Column("Diameter 1", ("diameter_1_mm",), MM, help="Of a spool balance: full end face"),
        Column("Diameter 2", ("diameter_2_mm",), MM),
        Column("Diameter 3", ("diameter_3_mm",), MM),
        Column("Rod diameter", ("rod_diameter_mm",), MM),
        Column("Diameter g1", ("diameter_g1_mm",), MM),
        Column("Diameter g2", ("diameter_g2_mm",), MM),
        Column("Shear modulus of the spring", ("spring", "shear_modulus_mpa"), in_unit("MPa")),
        Column("Wire diameter", ("spring", "wire_diameter_mm"), MM),
        Column("Active coils", ("spring", "active_coils"), PLAIN),
        Column("Mean coil diameter", ("spring", "mean_coil_diameter_mm"), MM),
        Column("Free length", ("spring", "free_length_mm"), MM),
        Column("Working length", ("spring", "working_length_mm"), MM),
        source(),
        evidence(),
    ),
    ("pressures",),
    examples=(
        {
            "Section": "p_m",
            "Relation": "line",
            "Ratio": 0.5,
            "Limit": 500.0,
            "Source": "manual, page 9",
            "How known": "published",
        },
    ),
)

LEAKS = Tables(
    "Leaks",
    "What leaks beside the lands: sealing rings, O-rings, check balls, each known from one measurement or statement",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _", width=20),
        Column("Name", ("name",), width=30),
        Column("From", ("from",), required=True, names="pressure", width=18),
        Column("To", ("to",), names="pressure", help="Drain unless stated"),
        Column("Law", ("law",), Choice(("laminar", "orifice")), required=True, help="Rings, or holes"),
        Column("Flow", ("flow_dm3_min",), in_unit("dm³/min"), required=True),
        Column("At pressure", ("at_kpa",), KPA, required=True),
        Column("At viscosity", ("at_viscosity_mm2_s",), in_unit("mm²/s"), help="Needed where laminar"),
        Column("At density", ("at_density_g_cm3",), in_unit("g/cm³"), help="0.83 unless stated"),
        Column("Gears", ("gears",), Gears(), help="All unless stated", width=16),
        source(),
        evidence(),
    ),
    ("leaks",),
    examples=(
        {
            "Id": "forward_rings",
            "Name": "rings of the forward clutch",
            "From": "forward_clutch",
            "Law": "laminar",
            "Flow": 0.2,
            "At pressure": 900.0,
            "At viscosity": 7.0,
            "Source": "own measurement",
            "How known": "measured",
        },
    ),
)

CONSUMERS = Tables(
    "Consumers",
    "What takes its flow from the pump and is no leak: converter and cooler, lubrication",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _", width=24),
        Column("Name", ("name",), width=30),
        Column("Law", ("law",), Choice(("orifice", "constant")), help="Orifice unless stated or after the line"),
        Column("At pressure", ("at_kpa",), KPA, help="The required main pressure unless stated"),
        Column("After the line", ("after_line",), YesNo(), help="Supplied with what the regulator leaves over"),
        source(),
        evidence(),
    ),
    ("consumers",),
    examples=(
        {
            "Id": "converter_and_cooler",
            "Name": "converter and cooler",
            "After the line": True,
            "Source": "jug and watch at the return line",
            "How known": "measured",
        },
    ),
)

FLOWS = ValuesByPoint(
    "Consumer flows",
    "How much each consumer takes: one row, or one for every operating point",
    (
        Column("Consumer", (), required=True, names="consumer", width=24),
        Column("Operating point", (), names="operating point", help="Empty: the same at all", width=20),
        Column("Flow", ("flow_dm3_min",), in_unit("dm³/min"), required=True),
    ),
    ("consumers",),
    examples=({"Consumer": "converter_and_cooler", "Operating point": "hot_idle", "Flow": 3.8},),
)
