"""List what else is uncertain besides the readings: defaults of this project, each settable by the workshop."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

from atleak.catalogue.written_numbers import decimal_number
from atleak.common.errors import InputError, unknown
from atleak.common.sentences import Sentence
from atleak.common.units import IN_HG, Quantity
from atleak.equations.statistics import rectangular


def _in(unit: str, size: float, kind: str) -> Callable[[float], Any]:
    """Return what makes a field, its default in SI, of a quantity that people state in a unit of that size."""
    return lambda default: field(default=default, metadata={"unit": (unit, size), "kind": kind})


_k, _percent = _in("k", 1.0, "temperature_difference"), _in("percent", 1e-2, "percent")
_mm, _um = _in("mm", 1e-3, "length"), _in("um", 1e-6, "clearance")
_in_hg = _in("in_hg", 1.0 / IN_HG, "vacuum")


@dataclass(frozen=True)
class Assumptions:
    """Standard uncertainties (one standard deviation) of all that is not read from an instrument.

    The defaults are a choice of this project. Relative ones are fractions.
    """

    room_temperature: float = _k(0.5)  # [K] half width about the temperature of measuring, any value alike likely
    contact_length: float = _mm(0.1e-3)  # [m] as the valve body's file states it
    measured_contact_length: float = _mm(0.03e-3)  # [m] by calliper on this unit: its error, and both edges
    mounting_clearance: float = _um(0.5e-6)  # [m] of the catalogue's value, for this one pair
    nominal_diameter: float = _um(3.0e-6)  # [m] of a part that was not measured
    unseen_ovality: float = _um(4.0e-6)  # [m] of a part measured in one direction, where no other land shows it
    form_residual: float = _percent(0.1)  # of ovality and taper: what two directions and a few planes leave
    one_sided_wear: float = _percent(1.0)  # most of a bore's wear to one side: none, half of this or this, alike likely
    viscosity: float = _percent(0.05)  # relative: batch, D341 between two points; fresh or used is asked
    temperature: float = _k(1.0)  # [K] of the fluid in the gaps
    main_pressure: float = _percent(0.02)  # relative
    converter_pressure: float = _percent(0.02)  # relative
    volumetric_efficiency: float = _percent(0.02)  # where the profile takes it as constant
    slip_coefficient: float = _percent(0.2)  # relative, where the profile lets the pump slip
    pump_clearance: float = _um(5e-6)  # [m] of each clearance of the pump that was measured in the job
    # what a unit may be like before gauges are read: which of its parts are worn, and by how much on average
    worn_lands: float = _percent(0.2)  # of those that nobody measured
    land_wear: float = _um(12e-6)  # [m] exponential
    most_land_wear: float = _um(60e-6)  # [m]
    worn_seals: float = _percent(0.1)  # of clutches and bands
    seal_wear: float = _percent(0.3)  # leak over what the circuit's feeds can pass, exponential
    worn_pumps: float = _percent(0.2)
    pump_wear: float = _percent(5.0)  # growth of the slip, exponential
    sticking_regulators: float = _percent(0.05)  # of the line
    regulator_fall: float = _percent(0.1)  # of line pressure, exponential
    line_setting: float = _percent(0.01)  # relative, of what the line is set to
    high_lines: float = _percent(0.1)  # that are set higher than the file states
    line_rise: float = _percent(0.1)  # by how much, relative, exponential
    feed: float = _percent(0.02)  # relative, of the flow through a feed orifice
    consumer_flow: float = _percent(0.2)  # relative, of what the file states that a consumer takes
    caught_flow: float = _percent(0.04)  # relative, of a flow that was caught in a jug
    gauged_temperature: float = _k(3.0)  # [K] of the fluid while gauges are read
    # of a vacuum test
    vacuum_gauge: float = _in_hg(0.5 / IN_HG)  # [Pa] half width about a reading, any value alike likely
    discharge_coefficient: float = _percent(0.8)  # C_d itself: of known orifices, and of a stand without calibration
    discharge: float = _percent(0.05)  # relative, of C_d
    tested_position: float = _percent(1.0)  # e/c, up to which a spool may lie in a test, any alike likely; 1 touches

    @cached_property
    def u_room_temperature(self) -> float:
        """Return the standard uncertainty of the temperature of measuring [K]."""
        return float(rectangular(self.room_temperature))

    def of_contact_length(self, *, measured: bool) -> float:
        """Return the standard uncertainty of a contact length [m]: measured on this unit, or as the file states it."""
        return self.measured_contact_length if measured else self.contact_length

    @property
    def settings(self) -> dict[str, float]:
        """Return every assumption under its name for people, with the unit in the name."""
        return {
            f"{field.name}_{_UNITS[field.name][0]}": getattr(self, field.name) / _UNITS[field.name][1]
            for field in fields(self)
        }

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Return every assumption under the same names, as a quantity that each reader has in units of their own."""
        kinds = (field.metadata["kind"] for field in fields(self))
        return {name: Quantity(value, kind) for (name, value), kind in zip(self.settings.items(), kinds, strict=True)}

    @cached_property
    def priors(self) -> dict[str, Quantity]:
        """Return those of them that say what a unit may be like before anything was read of it."""
        first = {f"{name}_{_UNITS[name][0]}" for name in ("viscosity", "slip_coefficient", "mounting_clearance")}
        rest = [*self.quantities].index("worn_lands_percent")
        return {name: each for at, (name, each) in enumerate(self.quantities.items()) if at >= rest or name in first}

    def with_settings(self, settings: Mapping[str, Any]) -> Assumptions:
        """Return these assumptions with some changed, by the names of `settings`: ``{"viscosity_percent": 3}``.

        Raises
        ------
        InputError
            unknown name, or a number below zero or above what there can be.

        Examples
        --------
        >>> Assumptions().with_settings({"room_temperature_k": "2,5"}).room_temperature
        2.5
        """
        names = {f"{name}_{unit}": name for name, (unit, _) in _UNITS.items()}
        changes: dict[str, float] = {}
        for key, given in settings.items():
            if key not in names:
                raise unknown(Sentence("no such assumption"), key, names)
            name = names[key]
            number = decimal_number(str(given))
            least, most = _ENDS.get(name, (0.0, math.inf))
            if number is None or not least <= number * _UNITS[name][1] <= most:
                expected, size = Sentence("0 or more"), _UNITS[name][1]
                if not math.isinf(most):
                    expected = Sentence("a number from {least:g} to {most:g}", least=least / size, most=most / size)
                problem = Sentence("assumption {key} does not take this value", key=key)
                raise InputError(problem, value=given, expected=expected)
            changes[name] = number * _UNITS[name][1]
        return replace(self, **changes)


_UNITS: dict[str, tuple[str, float]] = {each.name: each.metadata["unit"] for each in fields(Assumptions)}
_ENDS = {  # least and most: all wear to one side, a spool at its bore, nearly all parts worn
    **dict.fromkeys(("one_sided_wear", "tested_position"), (0.0, 1.0)),
    **dict.fromkeys(("worn_lands", "worn_seals", "worn_pumps", "sticking_regulators", "high_lines"), (0.0, 0.95)),
    "discharge_coefficient": (0.3, 1.0),
}

DEFAULTS = Assumptions()
NOTHING_ELSE = Assumptions(  # only the instruments err
    **{each.name: 0.0 for each in fields(Assumptions)} | {"discharge_coefficient": DEFAULTS.discharge_coefficient}
)
