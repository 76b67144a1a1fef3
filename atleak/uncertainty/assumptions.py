"""List what else is uncertain besides the readings: defaults of this project, each settable by the workshop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

from atleak.equations.uncertainty import rectangular
from atleak.errors import InputError, unknown
from atleak.sentence import Sentence
from atleak.written_numbers import decimal_number


@dataclass(frozen=True)
class Assumptions:
    """Standard uncertainties (one standard deviation) of all that is not read from an instrument.

    The defaults are a choice of this project. Relative ones are fractions.
    """

    room_temperature: float = 0.5  # [K] half width about the temperature of measuring, any value alike likely
    contact_length: float = 0.1e-3  # [m] as the valve body's file states it
    measured_contact_length: float = 0.03e-3  # [m] by calliper on this unit: its error, and both edges
    mounting_clearance: float = 0.5e-6  # [m] of the catalogue's value, for this one pair
    nominal_diameter: float = 3.0e-6  # [m] of a part that was not measured
    unseen_ovality: float = 4.0e-6  # [m] of a part measured in one direction, where no other land shows it
    form_residual: float = 0.1  # of ovality and taper: what two directions and a few planes do not average out
    one_sided_wear: float = (
        1.0  # most of a bore's wear that may lie to one side: none, half of this or this, alike likely
    )
    viscosity: float = 0.05  # relative: batch, D341 between two points; fresh or used is asked
    temperature: float = 1.0  # [K] of the fluid in the gaps
    main_pressure: float = 0.02  # relative
    converter_pressure: float = 0.02  # relative
    volumetric_efficiency: float = 0.02  # where the profile takes it as constant
    slip_coefficient: float = 0.2  # relative, where the profile lets the pump slip
    pump_clearance: float = 5e-6  # [m] of each clearance of the pump that was measured in the job
    # what a unit may be like before gauges are read: which of its parts are worn, and by how much on average
    worn_lands: float = 0.2  # of those that nobody measured
    land_wear: float = 12e-6  # [m] exponential
    most_land_wear: float = 60e-6  # [m]
    worn_seals: float = 0.1  # of clutches and bands
    seal_wear: float = 0.3  # leak over what the circuit's feeds can pass, exponential
    worn_pumps: float = 0.2
    pump_wear: float = 1.0  # growth of the slip, exponential
    sticking_regulators: float = 0.05  # of the line
    regulator_fall: float = 0.1  # of line pressure, exponential
    line_setting: float = 0.01  # relative, of what the line is set to
    high_lines: float = 0.1  # that are set higher than the file states
    line_rise: float = 0.1  # by how much, relative, exponential
    feed: float = 0.02  # relative, of the flow through a feed orifice
    gauged_temperature: float = 3.0  # [K] of the fluid while gauges are read

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
            most = _MOST.get(name, math.inf)
            if number is None or not 0.0 <= number * _UNITS[name][1] <= most:
                expected = Sentence("0 or more")
                if not math.isinf(most):
                    expected = Sentence("a number from 0 to {most:g}", most=most / _UNITS[name][1])
                problem = Sentence("assumption {key} does not take this value", key=key)
                raise InputError(problem, value=given, expected=expected)
            changes[name] = number * _UNITS[name][1]
        return replace(self, **changes)


_UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "room_temperature": ("k", 1.0),
        "contact_length": ("mm", 1e-3),
        "measured_contact_length": ("mm", 1e-3),
        "mounting_clearance": ("um", 1e-6),
        "nominal_diameter": ("um", 1e-6),
        "unseen_ovality": ("um", 1e-6),
        "form_residual": ("percent", 1e-2),
        "one_sided_wear": ("percent", 1e-2),
        "viscosity": ("percent", 1e-2),
        "temperature": ("k", 1.0),
        "main_pressure": ("percent", 1e-2),
        "converter_pressure": ("percent", 1e-2),
        "volumetric_efficiency": ("percent", 1e-2),
        "slip_coefficient": ("percent", 1e-2),
        "pump_clearance": ("um", 1e-6),
        "worn_lands": ("percent", 1e-2),
        "land_wear": ("um", 1e-6),
        "most_land_wear": ("um", 1e-6),
        "worn_seals": ("percent", 1e-2),
        "seal_wear": ("percent", 1e-2),
        "worn_pumps": ("percent", 1e-2),
        "pump_wear": ("percent", 1e-2),
        "sticking_regulators": ("percent", 1e-2),
        "regulator_fall": ("percent", 1e-2),
        "line_setting": ("percent", 1e-2),
        "high_lines": ("percent", 1e-2),
        "line_rise": ("percent", 1e-2),
        "feed": ("percent", 1e-2),
        "gauged_temperature": ("k", 1.0),
    }
)

_MOST: Mapping[str, float] = MappingProxyType({"one_sided_wear": 1.0})  # no more than all wear lies to one side

DEFAULTS = Assumptions()
NOTHING_ELSE = Assumptions(**{field.name: 0.0 for field in fields(Assumptions)})  # only the instruments err
