"""Describe the pressures of a valve body's sections, and the circuits: sections that follow from their feeds and leaks.

Gaps see shares of a section's pressure; relations say how p_s and p_m follow. A circuit is fed through orifices, held
down to a set pressure by a regulator, or vented in gears in which it is not applied. Beside the lands leak rings and
check balls; consumers take their flow from the pump.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from atleak.catalogue.controller_tables import RelationTable, SelectorRange, StandingState
from atleak.catalogue.keys import in_si
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import unknown
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

        Parameters
        ----------
        text
            as a valve body's file states it.

        Returns
        -------
        Pressure
            a number in kPa as a constant [Pa]; a drain as zero.

        Raises
        ------
        NotAccepted
            a `ValueError`: no such form, or a share that is not more than 0 and at most 1.

        Examples
        --------
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
        """Return the pressure [Pa] from those of the sections.

        Parameters
        ----------
        pressures
            [Pa] by section and circuit, numbers or arrays.
        """
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
        """Return (ratio, offset) valid for all p_g between two values; None where the limit begins between them.

        Parameters
        ----------
        low, high
            main pressures [Pa].

        Returns
        -------
        tuple or None
            ratio [-] and offset [Pa]; ratio 0 and the limit where all of it is at the limit.
        """
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


@dataclass(frozen=True)
class Following:
    """A set pressure that follows another: ratio times it, plus an offset [Pa]."""

    section: str  # section or circuit that it follows
    ratio: float  # times the pressure followed
    offset: float  # [Pa] added to it


@dataclass(frozen=True)
class SetPressure:
    """What a regulator is set to: a number, by operating point, gear or a solenoid's signal, or following a circuit."""

    number: float | None = None  # [Pa]
    points: Mapping[str, float] | None = None  # [Pa] by the name of an operating point
    gears: Mapping[int, float] | None = None  # [Pa]
    currents: tuple[tuple[float, ...], tuple[float, ...]] | None = None  # [A] rising, [Pa]
    duties: tuple[tuple[float, ...], tuple[float, ...]] | None = None  # [-] rising, of the lock-up solenoid; [Pa]
    following: Following | None = None  # the pressure that it follows

    def at(self, point: OperatingPoint) -> float | None:
        """Return the set pressure at an operating point [Pa]; None where it follows another circuit.

        Parameters
        ----------
        point
            whose name, gear, solenoid current or lock-up duty counts.

        Returns
        -------
        float or None
            [Pa]; 0 in a gear for which none is stated, None where the point lacks the solenoid's signal.

        Raises
        ------
        InputError
            it is stated by operating point, and this is none of the file's.
        """
        if self.number is not None:
            return self.number
        if self.points is not None:
            return _at_point(self.points, point)
        if self.gears is not None:
            return self.gears.get(point.gear, 0.0)
        if self.currents is not None and point.solenoid_current is not None:
            return float(np.interp(point.solenoid_current, *self.currents))
        if self.duties is not None and point.lockup_duty is not None:
            return float(np.interp(point.lockup_duty, *self.duties))
        return None

    def with_pressures(self, point: OperatingPoint, pressures: Mapping[str, Any]) -> Any:
        """Return the set pressure [Pa] at a point from the pressures that it may follow; never below zero.

        Parameters
        ----------
        point
            as `at` takes it.
        pressures
            [Pa] by section and circuit, numbers or arrays.

        Returns
        -------
        float, numpy.ndarray or None
            [Pa]; None where the point lacks the solenoid's signal.

        Raises
        ------
        InputError
            as `at` raises it.
        """
        if self.following is None:
            return self.at(point)
        following = self.following
        return np.maximum(following.ratio * pressures[following.section] + following.offset, 0.0)


@dataclass(frozen=True)
class Feed:
    """An orifice through which a circuit is supplied."""

    source: str  # a section or circuit
    diameter: float  # [m]
    discharge_coefficient: float  # C_d, a fraction


@dataclass(frozen=True)
class Circuit:
    """A section of its own: its feeds, and the pressure that a regulator holds it down to."""

    id: str  # by which gaps and feeds name it
    name: str  # what people see
    gears: frozenset[int]  # in the others it is vented and its feeds are shut
    feeds: tuple[Feed, ...]  # orifices through which it is supplied
    set_pressure: SetPressure | None  # what its regulator holds it down to; None without one
    source: str  # who states this


@dataclass(frozen=True)
class Leak:
    """A leak beside the lands (rings, O-rings, check balls), known from one measured or stated point."""

    id: str  # by which results name it
    name: str  # what people see
    high: Pressure  # pressure before it
    low: Pressure  # pressure behind it
    law: Literal["laminar", "orifice"]  # how its flow goes with the pressure drop
    flow: float  # [m³/s]
    pressure_drop: float  # [Pa] at which it flows
    viscosity: float | None  # [Pa·s] at which a laminar one flows
    density: float  # [kg/m³] at which one through an orifice flows
    gears: frozenset[int]  # in which it leaks
    into_sump: bool  # ends in the sump, not in another section
    source: str  # who states this


@dataclass(frozen=True)
class Consumer:
    """What takes its flow from the pump: converter and cooler, lubrication, the fill of a clutch."""

    id: str  # by which results name it
    name: str  # what people see
    flow: float | Mapping[str, float]  # [m³/s], for all operating points or for each by name
    after_line: bool  # supplied with what the line's regulator leaves over: it starves first
    source: str  # who states this
    law: Literal["orifice", "constant"] = "orifice"  # of one before the line's regulator
    pressure: float | None = None  # [Pa] of the line, at which an orifice takes its flow; None: the required one

    def at(self, point: OperatingPoint) -> float:
        """Return the flow stated for an operating point [m³/s].

        Raises
        ------
        InputError
            the flow is stated by operating point, and this is none of the file's.
        """
        return _at_point(self.flow, point) if isinstance(self.flow, Mapping) else self.flow


@dataclass(frozen=True)
class PermissiblePressure:
    """Between which pressures main pressure must lie in one state: in gears, and in ranges of the selector lever."""

    gears: frozenset[int]  # in which it holds
    state: StandingState  # of the engine
    low: float | None  # [Pa]
    high: float | None  # [Pa]
    source: str  # who states this
    published: bool = True  # else representative
    ranges: frozenset[SelectorRange] = frozenset()  # for gauge readings of a standing vehicle


def _at_point(stated: Mapping[str, float], point: OperatingPoint) -> float:
    """Return what is stated for an operating point, or for the one of the file whose values hold there."""
    if point.like not in stated:
        problem = Sentence("the valve body's file states nothing for this operating point")
        raise unknown(problem, point.like, stated)
    return stated[point.like]
