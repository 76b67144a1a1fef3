"""Limits, instruments and fluids as subjects that can be typed in forms and tables, like a valve body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, get_args

from atleak.catalogue.entries import Evidence
from atleak.catalogue.fluid import FluidFile, FluidState, checked_fluid
from atleak.catalogue.instruments import InstrumentFile, Part, checked_instrument
from atleak.catalogue.limits import LimitOrigin, LimitsFile, RuleKind, checked_limits
from atleak.controller_sheets.kinds import Choice, Day, Names, Number, YesNo
from atleak.controller_sheets.shapes import KPA, PLAIN, UM, Column, Form, Tables, in_unit
from atleak.controller_sheets.units import EXPANSION
from atleak.errors import Steps
from atleak.verdicts import BANDS, FLAGGED
from atleak.views.entry_form import Subject

_PERCENT = in_unit("%")
_UNITS = MappingProxyType({"%": _PERCENT, "µm": UM, "kPa": KPA, "": PLAIN})
_LEVEL = "percent"  # key of a limit in the table of its level, whatever its unit
_REPRESENTATIVE = Choice((Evidence.REPRESENTATIVE,))


@dataclass(frozen=True)
class LimitColumn(Column):
    """A field with the limit itself: a fault of the whole level is its own."""

    def steps(self) -> list[Steps]:
        return [self.keys[:1], self.keys]


def _head(*more: Column, about: str) -> Form:
    return Form(
        "Head",
        about,
        (
            Column("Name", ("name",), required=True, help="What people see"),
            Column("Id", ("id",), help="Small letters, digits and _; made from the name unless stated"),
            Column("Source", ("source",), required=True, help="Where the numbers come from"),
            Column("Date", ("date",), Day(), required=True, help="Of the source or of this entry, such as 2026-01-31"),
            Column("Note", ("note",), help="Anything a reader of the result must know"),
            *more,
        ),
        needed=True,
    )


# --- limits -------------------------------------------------------------------------------------------------------

_TABLES = MappingProxyType(  # of the file, each with the name of its form and of what it limits
    {
        "wear_percent": ("Wear", RuleKind.WEAR),
        "clearance_um": ("Clearance", RuleKind.CLEARANCE),
        "pair_share_percent": ("Share of a pair", RuleKind.PAIR_SHARE),
        "total_share_percent": ("Share of the unit", RuleKind.TOTAL_SHARE),
        "reserve": ("Reserve", RuleKind.RESERVE),
        "circuit_loss_kpa": ("Loss of a circuit", RuleKind.CIRCUIT_LOSS),
        "below_permissible_percent": ("Below the permissible", RuleKind.PERMISSIBLE_PRESSURE),
        "commanded_pressure_kpa": ("Off the commanded", RuleKind.COMMANDED_PRESSURE),
    }
)
_ABOUT = MappingProxyType(
    {
        RuleKind.WEAR: "Growth of a land's radial clearance over that when new",
        RuleKind.CLEARANCE: "Radial clearance of a land, whatever it was when new",
        RuleKind.PAIR_SHARE: "What one pair draws of the pump's flow; growth is over the same pair new",
        RuleKind.TOTAL_SHARE: "What the whole unit draws of the pump's flow; growth is over the same unit new",
        RuleKind.RESERVE: "What the pump displaces over all that leaves the line: the smaller, the worse",
        RuleKind.CIRCUIT_LOSS: "Pressure that a circuit has lost, or gained, against the same unit new",
        RuleKind.PERMISSIBLE_PRESSURE: "How far main pressure is below what the valve body's file permits",
        RuleKind.COMMANDED_PRESSURE: "How far main pressure is from what the control unit commands",
    }
)


def _limit_form(table: str, name: str, kind: RuleKind) -> Form:
    columns: list[Column] = []
    for level in [band for band in BANDS if band.verdict.flagged] if kind.in_bands else FLAGGED:
        heading, key, number = level.value.capitalize(), level.value, _UNITS[kind.unit]
        if kind is RuleKind.RESERVE:
            columns.append(Column(heading, (key,), number))
            continue
        columns.append(LimitColumn(heading, (key, _LEVEL), number))
        if kind is RuleKind.WEAR:
            columns.append(Column(f"{heading}: at least", (key, "at_least_um"), UM))
        if kind.is_share:
            columns.append(Column(f"{heading}: growth over new", (key, "growth_percent"), _PERCENT))
            columns.append(Column(f"{heading}: added points", (key, "added_points"), _PERCENT))
    if kind is RuleKind.RESERVE:
        help = "Of a unit that has less than a limit when new: its level begins where the reserve has fallen by this"
        columns.append(Column("Fall from new", ("fall_percent",), _PERCENT, help=help))
    whose = Choice(tuple(LimitOrigin), symbols=True)
    columns.append(Column("Limit is", ("origin",), whose, help="Published, chosen by atleak or set by you"))
    columns.append(Column("Source of the limit", ("source",), help="Manual and page, or whose experience"))
    return Form(name, _ABOUT[kind], tuple(columns), (table,))


def _opened(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a limits file with every plain limit in a table of its own, as its longer form has it."""
    opened = dict(data)
    for name in set(_TABLES) - {"reserve"} & set(data):
        opened[name] = {
            key: {_LEVEL: value} if _is_limit(value) else value for key, value in dict(data.get(name, {})).items()
        }
    return {name: table for name, table in opened.items() if table != {}}


def _closed(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a limits file with a plain number wherever a level states nothing else."""
    closed = dict(data)
    for name in set(_TABLES) & set(data):
        closed[name] = {
            key: value[_LEVEL] if isinstance(value, Mapping) and set(value) == {_LEVEL} else value
            for key, value in data[name].items()
        }
    return closed


def _is_limit(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


LIMITS = Subject(
    "limits",
    (
        _head(about="What these limits are, and whose"),
        *(_limit_form(table, name, kind) for table, (name, kind) in _TABLES.items()),
    ),
    LimitsFile,
    checked_limits,
    opened=_opened,
    closed=_closed,
)

# --- instruments --------------------------------------------------------------------------------------------------


def _measured(heading: str, key: str, kind: Number, help: str, *, required: bool = False) -> tuple[Column, Column]:
    """Return a field of an instrument and the one that says that its value comes from no certificate."""
    column = Column(heading, (key,), kind, required=required, help=help)
    help = "Empty: from a certificate or a measurement"
    return column, Column(f"{heading} is", (), _REPRESENTATIVE, how_known=key, help=help)


INSTRUMENT = Subject(
    "instruments",
    (
        _head(
            Column(
                "Measures",
                ("measures",),
                Names(get_args(Part)),
                required=True,
                help="spool, sleeve, or both with a comma",
            ),
            about="What this instrument is, and where its numbers come from",
        ),
        Form(
            "Uncertainty",
            "Standard uncertainties of one diameter: of a certificate that says U = 3 µm with k = 2, 1.5 µm",
            (
                *_measured("Resolution", "resolution_um", UM, "Step between two possible readings", required=True),
                *_measured(
                    "Calibration",
                    "calibration_um",
                    UM,
                    "Standard uncertainty of its calibration, setting and scale",
                    required=True,
                ),
                *_measured(
                    "Common part",
                    "common_part",
                    PLAIN,
                    "Part of the calibration's variance that all readings share, 0 to 1: zero, setting ring, scale",
                    required=True,
                ),
                *_measured(
                    "Repeatability",
                    "repeatability_um",
                    UM,
                    "Standard deviation of one reading; empty where it is not known",
                ),
                *_measured("Expansion", "expansion_per_k", Number(EXPANSION), "Of its scale or masters; 11.5 of steel"),
                Column(
                    "Errs alike inside and outside",
                    ("alike_inside_and_outside",),
                    YesNo(),
                    help="Its common error is the same in a bore and on a spool; yes unless stated",
                ),
            ),
        ),
    ),
    InstrumentFile,
    checked_instrument,
)

# --- fluids -------------------------------------------------------------------------------------------------------

_AT = Column("Temperature", ("temperature_c",), in_unit("°C"), required=True)
_VISCOSITY = Column(
    "Kinematic viscosity",
    ("kinematic_viscosity_mm2_s",),
    in_unit("mm²/s"),
    required=True,
    help="1 mm²/s is 1 cSt",
    width=22,
)
FLUID = Subject(
    "fluids",
    (
        _head(
            Column(
                "State", ("state",), Choice(get_args(FluidState)), help="Of which the data are; fresh unless stated"
            ),
            Column("Entry of the used fluid", ("used",), help="Id of a shipped entry with its data after use"),
            Column("Pour point", ("pour_point_c",), in_unit("°C"), help="Under it nothing is computed"),
            Column(
                "Representative", ("representative",), Names(), help="What no data sheet gives, with commas between"
            ),
            Column(
                "Study's regression holds", ("study_regression",), YesNo(), help="Of the source study's fluid alone"
            ),
            about="What this fluid is, and where its numbers come from",
        ),
        Form(
            "Density",
            "One value of the data sheet, and how it falls with temperature",
            (
                Column("Density", ("density_g_cm3",), in_unit("g/cm³"), required=True, help="Such as 0.85"),
                Column("At", ("at_c",), in_unit("°C"), help="15 °C unless stated"),
                Column(
                    "Slope",
                    ("density_slope_g_cm3_k",),
                    in_unit("g/(cm³·K)"),
                    required=True,
                    help="Negative: −0.0007 is representative of transmission fluids",
                ),
            ),
            ("density",),
        ),
        Tables(
            "Viscosity",
            "Points of the data sheet, two at least: usually at 40 and 100 °C",
            (_AT, _VISCOSITY),
            ("viscosity",),
        ),
        Tables(
            "Table",
            "Where a source tabulates viscosity and density together; may be left empty",
            (_AT, _VISCOSITY, Column("Density", ("density_g_cm3",), in_unit("g/cm³"), required=True)),
            ("table",),
        ),
    ),
    FluidFile,
    checked_fluid,
)

SUBJECTS: Mapping[str, Subject] = MappingProxyType({each.kind: each for each in (LIMITS, INSTRUMENT, FLUID)})
"""By folder of the catalogue."""
