"""Describe circuits: sections whose pressure follows from their feeds and leaks, and what else the pump supplies.

A circuit is fed through orifices, held down to a set pressure by a regulator, or vented in gears in which it is not
applied. Beside the lands leak rings and check balls; consumers take their flow from the pump.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from atleak.catalogue.circuit_tables import SelectorRange, StandingState
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.section_pressures import Pressure
from atleak.common.errors import unknown
from atleak.common.sentences import Sentence


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
        """Return the set pressure [Pa] at a point from the pressures that it may follow; never below zero."""
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
