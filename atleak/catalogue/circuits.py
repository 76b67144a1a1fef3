"""Describe circuits: sections whose pressure follows from their feeds and leaks, and what else the pump supplies.

A circuit is fed through orifices, held down to a set pressure by a regulator, or vented in gears in which it is not
applied. Beside the lands leak rings and check balls; consumers take their flow from the pump.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from atleak.catalogue.circuit_tables import (
    ByGearTable,
    CircuitTable,
    ConsumerTable,
    CurrentTable,
    FollowingTable,
    LeakTable,
    LineTable,
    PermissiblePressureTable,
    SelectorRange,
    SetTable,
    StandingState,
    State,
)
from atleak.catalogue.entries import catalogue_error
from atleak.catalogue.section_pressures import DRAINS, SECTIONS, Pressure
from atleak.errors import unknown

if TYPE_CHECKING:
    from atleak.catalogue.controller import OperatingPoint

IDLE_SPEED = (
    1000.0 / 60.0
)  # [1/s] under which an engine in gear idles, where nothing else says so: choice of this project


@dataclass(frozen=True)
class Following:
    """A set pressure that follows another: ratio times it, plus an offset [Pa]."""

    section: str
    ratio: float
    offset: float


@dataclass(frozen=True)
class SetPressure:
    """What a regulator is set to: a number, by operating point, gear or solenoid current, or following a circuit."""

    number: float | None = None  # [Pa]
    points: Mapping[str, float] | None = None  # [Pa] by the name of an operating point
    gears: Mapping[int, float] | None = None  # [Pa]
    currents: tuple[tuple[float, ...], tuple[float, ...]] | None = None  # [A] rising, [Pa]
    following: Following | None = None

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
    discharge_coefficient: float


@dataclass(frozen=True)
class Circuit:
    """A section of its own: its feeds, and the pressure that a regulator holds it down to."""

    id: str
    name: str
    gears: frozenset[int]  # in the others it is vented and its feeds are shut
    feeds: tuple[Feed, ...]
    set_pressure: SetPressure | None
    source: str


@dataclass(frozen=True)
class Leak:
    """A leak beside the lands (rings, O-rings, check balls), known from one measured or stated point."""

    id: str
    name: str
    high: Pressure
    low: Pressure
    law: Literal["laminar", "orifice"]
    flow: float  # [m³/s]
    pressure_drop: float  # [Pa] at which it flows
    viscosity: float | None  # [Pa·s] at which a laminar one flows
    density: float  # [kg/m³] at which one through an orifice flows
    gears: frozenset[int]
    into_sump: bool
    source: str


@dataclass(frozen=True)
class Consumer:
    """What takes its flow from the pump: converter and cooler, lubrication, the fill of a clutch."""

    id: str
    name: str
    flow: float | Mapping[str, float]  # [m³/s], for all operating points or for each by name
    after_line: bool  # supplied with what the line's regulator leaves over: it starves first
    source: str

    def at(self, point: OperatingPoint) -> float:
        """Return the flow at an operating point [m³/s].

        Raises
        ------
        InputError
            the flow is stated by operating point, and this is none of the file's.
        """
        return _at_point(self.flow, point) if isinstance(self.flow, Mapping) else self.flow


@dataclass(frozen=True)
class PermissiblePressure:
    """Between which pressures main pressure must lie in some gears and one state of driving."""

    gears: frozenset[int]
    state: State
    low: float | None  # [Pa]
    high: float | None  # [Pa]
    source: str


@dataclass(frozen=True)
class StandingPressure:
    """The same for gauge readings of a standing vehicle: in gears, and in ranges of the selector lever by name."""

    gears: frozenset[int]
    ranges: frozenset[SelectorRange]
    state: StandingState
    low: float | None  # [Pa]
    high: float | None  # [Pa]
    source: str


def _at_point(stated: Mapping[str, float], point: OperatingPoint) -> float:
    """Return what is stated for an operating point, or for the one of the file whose values hold there."""
    if point.like not in stated:
        raise unknown("the valve body's file states nothing for this operating point", point.like, stated)
    return stated[point.like]


@dataclass(frozen=True)
class Reading:
    """What the tables are read against: the file, its gears, operating points and sections."""

    path: Path
    gears: Sequence[int]
    points: Sequence[str]
    with_current: bool  # every operating point states a solenoid's current
    sections: Sequence[str]  # those that pressures may name, circuits included

    def pressure(self, text: str, table: str, key: str) -> Pressure:
        """Read a pressure of one of the sections."""
        try:
            pressure = Pressure.parse(text)
        except ValueError as error:
            raise catalogue_error(self.path, table, key, "not a pressure", value=text, expected=str(error)) from None
        if pressure.section is not None:
            self.section(pressure.section, table, key)
        return pressure

    def ends(self, high: str, low: str, table: str, what: str) -> tuple[Pressure, Pressure]:
        """Read the two pressures between which a gap or leak lies, the first that of a section or circuit."""
        begin, end = self.pressure(high, table, "from"), self.pressure(low, table, "to")
        if begin.section is None:
            problem, expected = f"a {what} that leaks from no section", "a section such as p_g, or the id of a circuit"
            raise catalogue_error(self.path, table, "from", problem, value=high, expected=expected)
        return begin, end

    def section(self, name: str, table: str, key: str) -> str:
        """Check the name of a section."""
        if name not in self.sections:
            expected = f"one of {', '.join(self.sections)}"
            raise catalogue_error(self.path, table, key, "no such section or circuit", value=name, expected=expected)
        return name

    def gears_of(self, stated: Sequence[int] | None, table: str, key: str = "gears") -> frozenset[int]:
        """Check gears; all of the controller's where none are stated."""
        others = sorted(set(stated or ()) - set(self.gears))
        if others:
            expected = f"one of {list(self.gears)}"
            raise catalogue_error(self.path, table, key, "unknown gear", value=others[0], expected=expected)
        return frozenset(self.gears if stated is None else stated)

    def by_point(self, stated: Mapping[str, float], table: str, key: str, unit: float) -> Mapping[str, float]:
        """Check that every operating point, and nothing else, has its number."""
        for name in stated:
            if name not in self.points:
                expected = f"one of {', '.join(self.points)}"
                raise catalogue_error(self.path, table, key, "no such operating point", value=name, expected=expected)
        missing = [name for name in self.points if name not in stated]
        if missing:
            expected = f"a number for {', '.join(missing)} too"
            raise catalogue_error(self.path, table, key, "not all operating points are stated", expected=expected)
        return MappingProxyType({name: number * unit for name, number in stated.items()})

    def set_pressure(self, stated: SetTable | None, table: str, gears: Iterable[int]) -> SetPressure | None:
        """Read what a regulator is set to."""
        key = "set_kpa"
        if stated is None:
            return None
        if isinstance(stated, FollowingTable):
            section = self.section(stated.source, table, key)
            return SetPressure(following=Following(section, stated.ratio, stated.offset_kpa * 1e3))
        if isinstance(stated, CurrentTable):
            if not self.with_current:
                problem = "the set pressure follows a solenoid's current, which an operating point does not state"
                expected = "solenoid_current_ma in every table [[operating_points]]"
                raise catalogue_error(self.path, table, key, problem, expected=expected)
            currents = tuple(current * 1e-3 for current in stated.current_ma), tuple(kpa * 1e3 for kpa in stated.kpa)
            return SetPressure(currents=currents)
        if isinstance(stated, ByGearTable):
            by_gear = {int(gear): kpa * 1e3 for gear, kpa in stated.gear.items()}
            self.gears_of(list(by_gear), table, key)
            missing = sorted(set(gears) - set(by_gear))
            if missing:
                expected = f"a pressure for gears {', '.join(map(str, missing))} too"
                raise catalogue_error(self.path, table, key, "not all gears are stated", expected=expected)
            return SetPressure(gears=MappingProxyType(by_gear))
        if isinstance(stated, dict):
            return SetPressure(points=self.by_point(stated, table, key, 1e3))
        return SetPressure(number=stated * 1e3)


def circuit_ids(tables: Sequence[CircuitTable], path: Path) -> list[str]:
    """Return the ids of the circuits, each once and none that of a section.

    Raises
    ------
    CatalogueError
        an id given twice, or one that means something else.
    """
    ids: list[str] = []
    for number, table in enumerate(tables, start=1):
        if table.id in {*SECTIONS, *DRAINS} or table.id.isdigit():
            problem = "an id that already names something else"
            raise catalogue_error(path, f"circuits[{number}]", "id", problem, value=table.id, expected="another id")
        if table.id in ids:
            raise catalogue_error(path, f"circuits[{number}]", "id", "circuit given twice", value=table.id)
        ids.append(table.id)
    return ids


def read_circuits(tables: Sequence[CircuitTable], reading: Reading) -> tuple[Circuit, ...]:
    """Return the circuits of a file.

    Raises
    ------
    CatalogueError
        an unknown section, gear or operating point, or circuits that follow or feed themselves.
    """
    circuits: list[Circuit] = []
    for number, table in enumerate(tables, start=1):
        where = f"circuits[{number}] ({table.id})"
        gears = reading.gears_of(table.gears, where)
        feeds = []
        for feed in table.feeds:
            if feed.source == table.id:
                problem = "a circuit that feeds itself"
                raise catalogue_error(reading.path, where, "feeds", problem, value=table.id, expected="another section")
            source = reading.section(feed.source, where, "feeds")
            feeds.append(Feed(source, feed.diameter_mm * 1e-3, feed.discharge_coefficient))
        set_pressure = reading.set_pressure(table.set_kpa, where, gears)
        circuits.append(Circuit(table.id, table.name, gears, tuple(feeds), set_pressure, table.source))
    _refuse_circles(circuits, reading.path)
    return tuple(circuits)


def _refuse_circles(circuits: Sequence[Circuit], path: Path) -> None:
    """Refuse set pressures that follow one another in a circle, and circuits that feed one another in one."""
    follows = {
        circuit.id: {circuit.set_pressure.following.section}
        for circuit in circuits
        if circuit.set_pressure is not None and circuit.set_pressure.following is not None
    }
    fed = {circuit.id: {feed.source for feed in circuit.feeds} for circuit in circuits}
    for key, leads, problem in (
        ("set_kpa", follows, "a set pressure that follows itself"),
        ("feeds", fed, "circuits that feed one another in a circle"),
    ):
        for number, circuit in enumerate(circuits, start=1):
            before: set[str] = set()
            next_ones = leads.get(circuit.id, set())
            while next_ones:
                before |= next_ones
                next_ones = {other for one in next_ones for other in leads.get(one, ())} - before
            if circuit.id in before:
                where, value = f"circuits[{number}] ({circuit.id})", ", ".join(sorted(leads[circuit.id]))
                raise catalogue_error(path, where, key, problem, value=value, expected="another circuit")


def read_line(table: LineTable, reading: Reading) -> SetPressure | None:
    """Return the set pressure of the line, which may follow a circuit.

    Raises
    ------
    CatalogueError
        a set pressure that follows a section that the line supplies, or the line itself.
    """
    stated = reading.set_pressure(table.set_kpa, "line", reading.gears)
    if stated is not None and stated.following is not None and stated.following.section in SECTIONS:
        problem = "the line's set pressure follows a section that it supplies"
        value = stated.following.section
        raise catalogue_error(reading.path, "line", "set_kpa", problem, value=value, expected="the id of a circuit")
    return stated


def read_leaks(tables: Sequence[LeakTable], reading: Reading) -> tuple[Leak, ...]:
    """Return the leaks beside the lands.

    Raises
    ------
    CatalogueError
        an unknown section or gear, an id given twice, or a leak that could leak nothing.
    """
    leaks: list[Leak] = []
    for number, table in enumerate(tables, start=1):
        where = f"leaks[{number}] ({table.id})"
        if any(table.id == leak.id for leak in leaks):
            raise catalogue_error(reading.path, where, "id", "leak given twice", value=table.id)
        density = table.at_density_g_cm3 * 1e3
        high, low = reading.ends(table.high, table.low, where, "leak")
        if high == low:
            problem, expected = "a leak that ends where it begins", "another pressure"
            raise catalogue_error(reading.path, where, "to", problem, value=table.low, expected=expected)
        viscosity = None if table.at_viscosity_mm2_s is None else table.at_viscosity_mm2_s * 1e-6 * density
        leaks.append(
            Leak(
                id=table.id,
                name=table.name or table.id.replace("_", " "),
                high=high,
                low=low,
                law=table.law,
                flow=table.flow_dm3_min / 60e3,
                pressure_drop=table.at_kpa * 1e3,
                viscosity=viscosity if table.law == "laminar" else None,
                density=density,
                gears=reading.gears_of(table.gears, where),
                into_sump=not low.is_section,
                source=table.source,
            )
        )
    return tuple(leaks)


def read_consumers(tables: Sequence[ConsumerTable], reading: Reading) -> tuple[Consumer, ...]:
    """Return the consumers.

    Raises
    ------
    CatalogueError
        an operating point that is unknown or not stated, or an id given twice.
    """
    consumers: list[Consumer] = []
    for number, table in enumerate(tables, start=1):
        where, stated = f"consumers[{number}] ({table.id})", table.flow_dm3_min
        if any(table.id == consumer.id for consumer in consumers):
            raise catalogue_error(reading.path, where, "id", "consumer given twice", value=table.id)
        flow = (
            reading.by_point(stated, where, "flow_dm3_min", 1.0 / 60e3) if isinstance(stated, dict) else stated / 60e3
        )
        name = table.name or table.id.replace("_", " ")
        consumers.append(Consumer(table.id, name, flow, table.after_line, table.source))
    return tuple(consumers)


def read_standing(tables: Sequence[PermissiblePressureTable], reading: Reading) -> tuple[StandingPressure, ...]:
    """Return between which pressures main pressure must lie, for gauge readings of a standing vehicle.

    Raises
    ------
    CatalogueError
        an unknown gear, or a gear or range given twice in one state.
    """
    standing: list[StandingPressure] = []
    for number, table in enumerate(tables, start=1):
        where = f"permissible_pressure[{number}]"
        stated = (table.gears or []) if table.gear is None else [table.gear]
        gears = reading.gears_of(stated, where, "gears" if table.gear is None else "gear")
        ranges = frozenset(table.ranges or ())
        for other in standing:
            if other.state == table.state:
                _refuse_twice("gear", gears & other.gears, table.state, where, reading.path)
                _refuse_twice("range", ranges & other.ranges, table.state, where, reading.path)
        low, high = (None if kpa is None else kpa * 1e3 for kpa in (table.low_kpa, table.high_kpa))
        standing.append(StandingPressure(gears, ranges, table.state, low, high, table.source))
    return tuple(standing)


def permissible_in_gear(standing: Iterable[StandingPressure]) -> tuple[PermissiblePressure, ...]:
    """Return those of them that hold in gears, at operating points and over logs."""
    return tuple(
        PermissiblePressure(each.gears, each.state, each.low, each.high, each.source)
        for each in standing
        if each.gears and each.state != "fast_idle"
    )


def _refuse_twice(what: str, both: Iterable[int | str], state: str, where: str, path: Path) -> None:
    """Refuse a gear or range whose permissible pressures another table states for the same state."""
    for value in sorted(both, key=str):
        raise catalogue_error(path, where, f"{what}s", f"{what} given twice for the state {state}", value=value)
