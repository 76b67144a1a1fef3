"""Declare the sheets about the valve body itself: its head, materials, components, lands, pump and repairs."""

from __future__ import annotations

from typing import get_args

from atleak.catalogue.circuit_tables import State
from atleak.catalogue.controller_tables import Bore, PartKind, Seal
from atleak.catalogue.entries import Evidence
from atleak.catalogue.pump_tables import PumpKind, PumpTable
from atleak.catalogue.repairs import REPAIR_KINDS
from atleak.controller_sheets.kinds import Choice, Day, Gear, Gears, Kind, Names, Number, Whole, Wholes, YesNo
from atleak.controller_sheets.shapes import (
    C_R,
    EVIDENCE,
    KPA,
    L_C,
    MM,
    MM3,
    OF_LAND,
    PLAIN,
    UM,
    Column,
    Form,
    KnownOfAll,
    NamedTables,
    Parts,
    Tables,
    evidence,
    in_unit,
    known,
    source,
)
from atleak.controller_sheets.units import EXPANSION

_OF_ALL = "How known, of all lands that do not say otherwise; empty: not stated"

HEAD = Form(
    "Head",
    "What this valve body is, and what the numbers of this workbook are written in",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _, such as ford_4r44e_1996"),
        Column("Name", ("name",), required=True, help="What people see"),
        Column("Source", ("source",), required=True, help="Where the numbers come from"),
        Column("Date", ("date",), Day(), required=True, help="Of the source or of this entry, such as 2026-01-31"),
        Column("Note", ("note",), help="Anything a reader of the result must know"),
        Column("Representative", ("representative",), help="In a sentence: what of it is representative"),
        Column("Gears", ("gears",), Gears(or_every=False), required=True, help="Such as R N 1 2 3 4; P counts as N"),
        KnownOfAll("Diameters are", (), EVIDENCE, value_of_all="nominal_diameter_mm", help=_OF_ALL),
        KnownOfAll("Contact lengths are", (), EVIDENCE, value_of_all="contact_length_mm", help=_OF_ALL),
        KnownOfAll("New clearances are", (), EVIDENCE, value_of_all="mounting_clearance_um", help=_OF_ALL),
        Column("Contact length unless stated", ("defaults", "contact_length_mm"), L_C, help="Of lands that state none"),
        Column(
            "Mounting clearance unless stated",
            ("defaults", "mounting_clearance_um"),
            C_R,
            end=0,
            help="Of lands that state none, when new. Bore minus spool where diametral, half of it where radial",
        ),
        Column(
            "Up to, where it is a range",
            ("defaults", "mounting_clearance_um"),
            C_R,
            end=1,
            help="Its upper end",
        ),
        Column(
            "Tolerance of mounting clearances",
            ("defaults", "mounting_tolerance_um"),
            C_R,
            help="± that holds 95 % of new pairs, where it is a value of the unit's type",
        ),
        Column(
            "Clearances are of a used unit",
            ("defaults", "mounting_clearance_of_used_unit"),
            YesNo(),
            help="Measured on a used unit and taken as new",
        ),
        Column("Material of the body", ("defaults", "body"), names="material", help="A name of the sheet Materials"),
        Column("Material of spools", ("defaults", "spool"), names="material", help="A name of the sheet Materials"),
        Column(
            "Source of the line's set pressure",
            ("line", "source"),
            help="Only where the sheet Set pressures has rows of p_g",
        ),
        Column("How that is known", ("line", "evidence"), EVIDENCE),
    ),
    needed=True,
)

MATERIALS = NamedTables(
    "Materials",
    "Materials of bodies and spools. The clearance opens with heat where the body expands more than the spool",
    (
        Column("Name", (), required=True, help="A name of your own"),
        Column(
            "Expansion",
            ("expansion_per_k",),
            Number(EXPANSION),
            required=True,
            help="21.3 for cast aluminium, 12 for steel",
        ),
        source(),
        evidence(),
    ),
    ("materials",),
    needed=True,
    examples=(
        {"Name": "aluminium", "Expansion": 2.13e-05, "Source": "handbook value of A356", "How known": "published"},
    ),
)

COMPONENTS = Tables(
    "Components",
    "One row for each valve, damper or end plug. Their lands stand under Lands",
    (
        Column("Id", ("id",), required=True, help="As on the drawing: 8, 12', boost_valve", width=28),
        Column("Name", ("name",), required=True, width=34),
        Column("Part", ("part",), Choice(get_args(PartKind)), help="Spool unless stated"),
        Column("Bore", ("bore",), Choice(get_args(Bore)), help="Plain unless stated"),
    ),
    ("components",),
    needed=True,
    examples=({"Id": "boost_valve", "Name": "line boost valve", "Part": "spool"},),
)

LANDS = Parts(
    "Lands",
    "One row for each land: a cylindrical section of a spool, as the picture shows",
    (
        Column("Component", (), required=True, names="component", width=28),
        Column("Land", ("land",), Whole(), required=True, help="Its number on this component, 1 to 9", width=7),
        Column("Diameter", ("nominal_diameter_mm",), OF_LAND, required=True, help="Of the spool, not of the bore"),
        known("Diameter is", "nominal_diameter_mm"),
        Column("Contact length", ("contact_length_mm",), L_C, help="Over which spool and bore face each other"),
        known("Length is", "contact_length_mm"),
        Column("Mounting clearance", ("mounting_clearance_um",), C_R, end=0, help="When new; the lower end of a range"),
        Column("Up to", ("mounting_clearance_um",), C_R, end=1, help="The upper end, where it is a range"),
        Column("Tolerance", ("mounting_tolerance_um",), C_R, help="± that holds 95 % of new pairs of this type"),
        known("Clearance is", "mounting_clearance_um"),
        Column("Of a used unit", ("mounting_clearance_of_used_unit",), YesNo(), help="Measured used and taken as new"),
        Column("Learned from", ("learned_from_units",), Whole("units"), help="How many new units gave the clearance"),
        Column("Limit", ("clearance_limit_um",), C_R, help="Your own: at or past it the verdict is replace"),
        Column("Planes", ("planes",), Names(), help="Measurement planes, with commas; the land's number unless stated"),
        Column("Position", ("position_mm",), MM, help="Near edge from the end that the drawing shows left"),
        Column("Seal", ("seal",), Choice(get_args(Seal))),
        Column("Body", ("body",), names="material", help="Material, where it is not that of the head"),
        Column("Spool", ("spool",), names="material", help="Material, where it is not that of the head"),
    ),
    ("components",),
    needed=True,
    examples=(
        {
            "Component": "boost_valve",
            "Land": 1,
            "Diameter": 9.855,
            "Diameter is": "published",
            "Contact length": 5.0,
            "Length is": "measured",
            "Mounting clearance": 6.4,
            "Up to": 20.0,
            "Clearance is": "published",
        },
    ),
    under="lands",
)

_PUMP_KNOWN = Choice((Evidence.MEASURED, Evidence.REPRESENTATIVE))


def _pump(heading: str, key: str, kind: Kind) -> tuple[Column, Column]:
    """Return the field of a key of the pump and the one that says how it is known; its help is the key's own."""
    field = PumpTable.model_fields[key]
    column = Column(heading, (key,), kind, required=field.is_required(), help=field.description or "")
    return column, known(f"{heading} is", key, kind=_PUMP_KNOWN)


PUMP = Form(
    "Pump",
    "Either what one revolution displaces, or the dimensions of its kind, from which that follows",
    (
        *_pump("Kind", "kind", Choice(get_args(PumpKind))),
        *_pump("Displacement of one revolution", "displacement_mm3", MM3),
        *_pump("Held at demand", "held_at_demand", YesNo()),
        *_pump("Module", "module_mm", MM),
        *_pump("Teeth", "teeth", Whole()),
        *_pump("Teeth of the ring gear", "ring_teeth", Whole()),
        *_pump("Width", "width_mm", MM),
        *_pump("Height of a tooth", "tooth_height_mm", MM),
        *_pump("Diameter over the tips", "tip_diameter_mm", MM),
        *_pump("Diameter at the roots", "root_diameter_mm", MM),
        *_pump("Ring gear between tips", "ring_tip_diameter_mm", MM),
        *_pump("Ring gear between roots", "ring_root_diameter_mm", MM),
        *_pump("Outside of the ring gear or outer rotor", "ring_outer_diameter_mm", MM),
        *_pump("Distance of the axes", "centre_distance_mm", MM),
        *_pump("Vanes", "vanes", Whole()),
        *_pump("Bore of the vanes' ring", "cam_ring_diameter_mm", MM),
        *_pump("Diameter of the vanes' rotor", "rotor_diameter_mm", MM),
        *_pump("Eccentricity", "eccentricity_mm", MM),
        *_pump("Shaft, hub or bushing", "shaft_diameter_mm", MM),
        *_pump("Length of a tip's land", "tip_land_mm", MM),
        *_pump("Sealing tips", "sealing_tips", Whole()),
        *_pump("Side clearance", "side_clearance_um", UM),
        *_pump("Limit of the side clearance", "side_clearance_limit_um", UM),
        *_pump("Tip clearance", "tip_clearance_um", UM),
        *_pump("Limit of the tip clearance", "tip_clearance_limit_um", UM),
        *_pump("Volumetric efficiency", "volumetric_efficiency", PLAIN),
        *_pump("Slip coefficient", "slip_coefficient", PLAIN),
        Column("Source", ("source",), required=True, help=PumpTable.model_fields["source"].description or ""),
    ),
    ("pump",),
    needed=True,
)

POINTS = Tables(
    "Operating points",
    "Conditions at which leakage is judged, the usual one first. Name one hot_idle: there a worn unit fails first",
    (
        Column("Name", ("name",), required=True, help="Small letters, digits and _", width=18),
        Column("Label", ("label",), required=True, help="What people see", width=28),
        Column("Fluid temperature", ("temperature_c",), in_unit("°C"), required=True),
        Column("Engine speed", ("engine_rpm",), in_unit("rpm"), required=True),
        Column("Gear", ("gear",), Gear(), required=True, help="R, N or a number", width=7),
        Column("Main pressure", ("p_g_kpa",), KPA, required=True, help="That a sound unit has there, gauge"),
        Column("Converter pressure", ("p_k_kpa",), KPA, required=True, help="Likewise"),
        Column("State", ("state",), Choice(get_args(State)), help="Idle under 1000 rpm, else driving, unless stated"),
        Column("Solenoid current", ("solenoid_current_ma",), in_unit("mA"), help="Where a set pressure follows it"),
        Column("Lock-up duty", ("lockup_duty_percent",), in_unit("%"), help="Where a set pressure follows it"),
        source(),
        evidence(),
    ),
    ("operating_points",),
    needed=True,
    examples=(
        {
            "Name": "hot_idle",
            "Label": "hot idle in drive, 100 °C",
            "Fluid temperature": 100.0,
            "Engine speed": 650.0,
            "Gear": 1,
            "Main pressure": 890.0,
            "Converter pressure": 300.0,
            "State": "idle",
            "Source": "manual, page 12",
            "How known": "published",
        },
    ),
)

REPAIRS = Tables(
    "Repairs",
    "What can be done about a worn component: used by the plan of repair and by the estimate",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _", width=20),
        Column("Component", ("component",), required=True, names="component", width=20),
        Column("Lands", ("lands",), Wholes(), help="All of the component unless stated"),
        Column(
            "Kind",
            ("kind",),
            Choice(REPAIR_KINDS),
            required=True,
            width=16,
        ),
        Column("Name", ("name",), width=30),
        Column("Part number", ("part_number",)),
        Column("Price", ("price",), PLAIN),
        Column("Currency", ("currency",)),
        Column("Hours", ("hours",), in_unit("h")),
        Column("Tool", ("tool",), width=20),
        Column("New diameter", ("nominal_diameter_mm",), OF_LAND, help="Of an oversize valve"),
        Column("New clearance", ("mounting_clearance_um",), C_R, end=0, help="Afterwards; the lower end of a range"),
        Column("Up to", ("mounting_clearance_um",), C_R, end=1),
        Column("Tolerance", ("mounting_tolerance_um",), C_R),
        source(),
        evidence(),
    ),
    ("repairs",),
    examples=(
        {
            "Id": "boost_kit",
            "Component": "boost_valve",
            "Kind": "new_valve",
            "Name": "boost valve and sleeve",
            "Part number": "12345-01",
            "Price": 45.0,
            "Currency": "USD",
            "Hours": 0.5,
            "New clearance": 6.4,
            "Up to": 20.0,
            "Source": "made-up example",
            "How known": "representative",
        },
    ),
)

COMPLAINTS = Tables(
    "Complaints",
    "What customers say, and where the leakage behind it shows",
    (
        Column("Id", ("id",), required=True, help="Small letters, digits and _", width=20),
        Column("Label", ("label",), required=True, help="What people see", width=30),
        Column(
            "Operating points",
            ("conditions",),
            Names(),
            required=True,
            help="Their names, with commas",
            width=28,
        ),
        Column("Lands", ("lands",), Names(), help="That can explain it: boost_valve/2, 8/1", width=24),
        source(needed=False),
    ),
    ("complaints",),
    examples=(
        {
            "Id": "late_reverse",
            "Label": "Late reverse",
            "Operating points": ["reverse_idle"],
            "Lands": ["boost_valve/2"],
            "Source": "hydraulic diagram, page 12",
        },
    ),
)
