"""Name the cells that formulas ask for by name: constants, and what belongs to the instrument of a part.

Names of conditions begin with the condition's own; `RESERVED` are beginnings that no condition has.
"""

from __future__ import annotations

from atleak.catalogue.instruments import Part
from atleak.catalogue.section_pressures import Pressure

RESERVED = frozenset({"const", "limit", "spool", "sleeve"})

REFERENCE = "const_reference_temperature"
MEASURED_AT = "const_measured_at"
GAIN = "const_eccentric_gain"
ECCENTRICITY = "const_eccentricity"
MEAN_OF_POSITIONS = "const_mean_eccentric"
FULLY = "const_fully_eccentric"
ENTRY_LOSS = "const_entry_loss"
D341_A, D341_B, D341_SHIFT, ABSOLUTE = "const_d341_A", "const_d341_B", "const_d341_shift", "const_zero_celsius"
DENSITY_AT, DENSITY, DENSITY_SLOPE = "const_density_at", "const_density", "const_density_slope"
STUDY_NAMES = ("const_study_nu", "const_study_exponent", "const_study_rho", "const_study_slope")
ROUNDED = "const_rounding"
NOTHING_DELIVERED = "const_no_delivery"
LARGEST_SHARE = "const_largest_share"
COVERAGE = "const_coverage"
ROOM_TEMPERATURE = "const_room_temperature"
FORM_RESIDUAL = "const_form_residual"
UNSEEN_OVALITY = "const_unseen_ovality"
NOMINAL_DIAMETER = "const_nominal_diameter"
OWN_MOUNTING = "const_own_mounting"
TOLERANCE_COVERAGE = "const_tolerance_coverage"
REPEATS_APART = "const_repeats_apart"
VISIBLE_STEP = "const_visible_step"
AVERAGED = "const_averaged_from"
TRUSTED_DEGREES = "const_trusted_degrees"


def of_limit(kind: str, part: str, level: str) -> str:
    """Return the name of a part of a limit, such as the growth that it asks for.

    >>> of_limit("wear", "limit", "watch"), of_limit("wear", "at_least", "watch")
    ('limit_wear_watch', 'limit_wear_at_least_watch')
    """
    return "_".join(("limit", kind, *(() if part == "limit" else (part,)), level))


def of_relation(section: str, what: str) -> str:
    """Return the name of a constant of the line that gives a section's pressure."""
    return f"const_{section}_{what}"


def share_of_pressure(pressure: Pressure) -> str:
    """Return the name of the share of a section's pressure that a gap sees."""
    return f"const_share_{_digits(pressure.coefficient)}"


def constant_pressure(pressure: Pressure) -> str:
    """Return the name of a pressure that stays the same."""
    return f"const_pressure_{_digits(pressure.constant)}_Pa"


def of_leak(number: int, what: str) -> str:
    """Return the name of a constant of a leak beside the lands."""
    return f"const_leak_{number}_{what}"


def of_tips(end: str, number: int, what: str) -> str:
    """Return the name of a constant of the slip over a pump's tips."""
    return f"const_tips{end}_{number}_{what}"


def of_part(part: Part, what: str) -> str:
    """Return the name of a cell on the instrument of a part, or on what its repeats show."""
    return f"{part}_{what}"


def _digits(number: float) -> str:
    """Return the digits of a number as a name holds them: ``0.35`` is ``0_35``.

    >>> _digits(0.35), _digits(1e-07)
    ('0_35', '1em07')
    """
    return repr(number).replace(".", "_").replace("-", "m").replace("+", "")
