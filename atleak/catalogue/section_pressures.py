"""Describe the pressures of a controller's sections: shares of them that gaps see, and how p_s and p_m follow."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from atleak.catalogue.controller_tables import RelationTable
from atleak.catalogue.keys import in_si
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence
from atleak.equations import pressure as pressure_equations

SECTIONS = ("p_g", "p_s", "p_m", "p_k")
DRAINS = ("0", "drain")
_PRESSURE = re.compile(r"^\s*(?:(?P<factor>\d*\.?\d+)\s*\*\s*)?(?P<section>[a-z0-9_]*[a-z][a-z0-9_]*)\s*$")
_ABSOLUTE = re.compile(r"^\s*(?P<number>\d+\.?\d*)\s*kPa\s*$")


@dataclass(frozen=True)
class Pressure:
    """A share of one section's pressure, or a pressure that stays the same: that of a drain is zero."""

    coefficient: float
    section: str | None
    constant: float = 0.0  # [Pa] above that of the surrounding air, where there is no section

    @classmethod
    def parse(cls, text: str) -> Pressure:
        """Read ``"p_g"``, ``"0.1*p_g"``, the id of a circuit, ``"35 kPa"``, ``"0"`` or ``"drain"``.

        >>> Pressure.parse("0.1*p_g")
        Pressure(coefficient=0.1, section='p_g', constant=0.0)
        """
        if text.strip() in DRAINS:
            return cls(0.0, None)
        absolute = _ABSOLUTE.match(text)
        if absolute is not None:
            return cls(0.0, None, float(absolute["number"]) * 1e3)
        match = _PRESSURE.match(text)
        if match is None:
            raise NotAccepted(Sentence("'p_g', '0.1*p_g' (also p_s, p_m, p_k or a circuit), '35 kPa', '0' or 'drain'"))
        factor = float(match["factor"] or 1.0)
        if not 0.0 < factor <= 1.0:
            raise NotAccepted(Sentence("a share of a pressure, more than 0 and at most 1"))
        return cls(factor, match["section"])

    @property
    def is_section(self) -> bool:
        """Return whether this is a section itself and not a share of it, nor a drain."""
        return self.section is not None and self.coefficient == 1.0

    def at(self, pressures: Mapping[str, Any]) -> Any:
        """Return the pressure [Pa] from those of the sections."""
        return self.constant if self.section is None else self.coefficient * pressures[self.section]

    def __str__(self) -> str:
        if self.section is None:
            return f"{self.constant / 1e3:g} kPa" if self.constant else "drain"
        return self.section if self.coefficient == 1.0 else f"{self.coefficient:g}*{self.section}"


@dataclass(frozen=True)
class PressureRelation:
    """A section's pressure as a line in p_g: ``min(ratio · p_g + offset, limit)``.

    Eq. (14) is such a line with offset 0; so is eq. (13), whose spool balance is affine in p_g.
    """

    relation: Literal["spool_balance", "line"]
    ratio: float
    offset: float  # [Pa]
    limit: float | None  # [Pa], the valve's own

    def __call__(self, main_pressure: Any) -> Any:
        return pressure_equations.regulated_pressure(main_pressure, self.ratio, self.offset, self.limit)

    def line_between(self, low: float, high: float) -> tuple[float, float] | None:
        """Return (ratio, offset) valid for all p_g between two values; None where the limit begins between them."""
        if self.limit is None:
            return self.ratio, self.offset
        ends = self(low), self(high)
        if max(ends) < self.limit:
            return self.ratio, self.offset
        return (0.0, self.limit) if min(ends) >= self.limit else None


def read_relation(table: RelationTable) -> PressureRelation:
    """Return the relation of a section from its table.

    Raises
    ------
    DomainError
        diameters or lengths that cannot be those of one valve.
    """
    of = in_si(table)
    if table.relation == "line":
        return PressureRelation("line", float(table.ratio or 0.0), of["offset"], of["limit"])
    area, rod, spring = pressure_equations.annulus_area, of["rod_diameter"], in_si(table.spring) if table.spring else {}
    sizes = (spring[name] for name in ("shear_modulus", "wire_diameter", "active_coils", "mean_coil_diameter"))
    deflection = pressure_equations.spring_deflection(spring["free_length"], spring["working_length"])
    force = pressure_equations.spring_force(pressure_equations.spring_rate(*sizes), deflection)
    areas = (
        area(of["diameter_1"]),
        area(of["diameter_2"], rod),
        area(of["diameter_3"], rod),
        area(of["diameter_g1"] or of["diameter_2"], rod),
        area(of["diameter_g2"] or of["diameter_3"], rod),
    )
    offset = pressure_equations.control_pressure(0.0, force, *areas)
    ratio = pressure_equations.control_pressure(1.0, 0.0, *areas)
    return PressureRelation("spool_balance", ratio, offset, of["limit"])
