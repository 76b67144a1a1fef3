"""Read circuits, leaks, consumers, line and permissible pressures of a controller's file.

Tables are read against one another, and what is wrong with them is gathered.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeVar

from atleak.catalogue.circuits import (
    DRAINS,
    SECTIONS,
    Circuit,
    Consumer,
    Feed,
    Following,
    Leak,
    PermissiblePressure,
    Pressure,
    SetPressure,
)
from atleak.catalogue.controller_tables import (
    ByGearTable,
    CircuitTable,
    ConsumerTable,
    ControllerFile,
    CurrentTable,
    DutyTable,
    FollowingTable,
    LeakTable,
    LineTable,
    PermissiblePressureTable,
    SetTable,
)
from atleak.catalogue.entries import Evidence
from atleak.catalogue.keys import in_si, made
from atleak.common.errors import CatalogueError, KeySteps, nearest_name, one_of
from atleak.common.file_faults import NotAccepted, place_of, place_of_table
from atleak.common.sentences import Sentence

_Entry = TypeVar("_Entry")
_Made = TypeVar("_Made")


@dataclass(frozen=True)
class PartReading:
    """What the tables are read against: the file, its gears, operating points and sections."""

    path: Path
    data: Any  # the file's tables
    gears: Sequence[int]
    points: Sequence[str]
    with_current: bool  # every operating point states a solenoid's current
    with_duty: bool  # every operating point states the lock-up solenoid's duty
    sections: Sequence[str]  # those that pressures may name, circuits included
    kept: Mapping[KeySteps, Sequence[int]]  # by list, where tables were set aside: the places of the others
    faults: list[CatalogueError] = field(default_factory=list)  # gathered so far

    @classmethod
    def of(
        cls, entry: ControllerFile, data: Mapping[str, Any], path: Path, kept: Mapping[KeySteps, Sequence[int]]
    ) -> PartReading:
        """Return what the tables of a file are read against."""
        points = entry.operating_points
        return cls(
            path,
            data,
            entry.gears,
            [point.name for point in points],
            all(point.solenoid_current_ma is not None for point in points),
            all(point.lockup_duty_percent is not None for point in points),
            [*SECTIONS, *(table.id for table in entry.circuits)],
            kept,
        )

    @contextmanager
    def gathering(self) -> Iterator[None]:
        """Gather the fault that reading one table ends in, so that the next can be read."""
        try:
            yield
        except CatalogueError as fault:
            self.faults.append(fault)

    def objects_of(
        self,
        tables: Sequence[_Entry],
        at: KeySteps,
        make: Callable[[_Entry, KeySteps], _Made],
        *,
        twice: Sentence | None = None,
        named_by: str = "id",
    ) -> list[_Made]:
        """Return what is made of each table, gathering the faults of those that are wrong.

        Where they have names and ``twice`` says what is wrong otherwise, no two may have the same.
        """
        objects: list[_Made] = []
        names: set[object] = set()
        for number, table in enumerate(tables):
            where = self.place(at, number)
            with self.gathering():
                name = getattr(table, named_by) if twice else number
                if name in names:
                    raise self.fault((*where, named_by), twice or Sentence(""), value=name)
                names.add(name)
                objects.append(make(table, where))
        return objects

    def place(self, at: KeySteps, number: int) -> KeySteps:
        """Return the steps to a table of a list, of which some may have been set aside."""
        return (*at, self.kept[at][number] if at in self.kept else number)

    def fault(
        self,
        steps: KeySteps,
        problem: Sentence,
        *,
        value: object = None,
        expected: Sentence | None = None,
        refers_to: str | None = None,
    ) -> CatalogueError:
        """Return a fault of the key that the steps lead to; where it refers to nothing, to an entry of which list."""
        place = place_of(steps, self.data, self.path.name)
        fault = CatalogueError(problem, place=place, value=value, expected=expected)
        fault.refers_to = refers_to
        return fault

    def fault_of_table(self, steps: KeySteps, problem: Sentence, *, expected: Sentence | None = None) -> CatalogueError:
        """Return a fault of the whole table that the steps lead to."""
        return CatalogueError(problem, place=place_of_table(steps, self.data, self.path.name), expected=expected)

    def unknown(
        self, steps: KeySteps, problem: Sentence, value: object, known: Collection[str], *, refers_to: str | None = None
    ) -> CatalogueError:
        """Return the fault of a name that is none of the known ones; it lists them and gives the nearest."""
        place = place_of(steps, self.data, self.path.name)
        nearest = nearest_name(str(value), known) if value is not None else None
        fault = CatalogueError(problem, place=place, value=value, expected=one_of(known), nearest=nearest)
        fault.refers_to = refers_to
        return fault

    def unknown_gear(self, steps: KeySteps, gear: int) -> CatalogueError:
        """Return the fault of a gear that the controller does not have."""
        expected = gears_listed(self.gears)
        return self.fault(steps, Sentence("unknown gear"), value=gear, expected=expected, refers_to="gears")

    def pressure(self, text: str, steps: KeySteps) -> Pressure:
        """Read a pressure of one of the sections."""
        try:
            pressure = Pressure.parse(text)
        except NotAccepted as error:
            raise self.fault(steps, Sentence("not a pressure"), value=text, expected=error.wanted) from None
        if pressure.section is not None:
            self.section(pressure.section, steps)
        return pressure

    def ends(self, high: str, low: str, table: KeySteps, what: Literal["gap", "leak"]) -> tuple[Pressure, Pressure]:
        """Read the two pressures between which a gap or leak lies, the first that of a section or circuit."""
        begin, end = self.pressure(high, (*table, "from")), self.pressure(low, (*table, "to"))
        if begin.section is None:
            expected = Sentence("a section such as p_g, or the id of a circuit")
            raise self.fault((*table, "from"), _FROM_NOTHING[what], value=high, expected=expected)
        if begin == end:
            raise self.fault((*table, "to"), _TO_ITSELF[what], value=low, expected=Sentence("another pressure"))
        return begin, end

    def section(self, name: str, steps: KeySteps) -> str:
        """Check the name of a section."""
        if name not in self.sections:
            problem = Sentence("no such section or circuit")
            raise self.unknown(steps, problem, name, self.sections, refers_to="circuits")
        return name

    def gears_of(self, stated: Sequence[int] | None, steps: KeySteps) -> frozenset[int]:
        """Check gears; all of the controller's where none are stated."""
        others = sorted(set(stated or ()) - set(self.gears))
        if others:
            raise self.unknown_gear(steps, others[0])
        return frozenset(self.gears if stated is None else stated)

    def by_point(self, stated: Mapping[str, float], steps: KeySteps, unit: float) -> Mapping[str, float]:
        """Check that every operating point, and nothing else, has its number."""
        for name in stated:
            if name not in self.points:
                problem = Sentence("no such operating point")
                raise self.unknown(steps, problem, name, self.points, refers_to="operating_points")
        missing = tuple(name for name in self.points if name not in stated)
        if missing:
            expected = Sentence("a number for {points} too", points=missing)
            raise self.fault(steps, Sentence("not all operating points are stated"), expected=expected)
        return MappingProxyType({name: number * unit for name, number in stated.items()})

    def set_pressure(self, stated: SetTable | None, steps: KeySteps, gears: Iterable[int]) -> SetPressure | None:
        """Read what a regulator is set to."""
        if stated is None:
            return None
        if isinstance(stated, FollowingTable):
            section = self.section(stated.source, steps)
            return SetPressure(following=Following(section, stated.ratio, stated.offset_kpa * 1e3))
        if isinstance(stated, CurrentTable):
            if not self.with_current:
                problem = Sentence(
                    "the set pressure follows a solenoid's current, which an operating point does not state"
                )
                raise self._without_signal(steps, problem, "solenoid_current_ma")
            return SetPressure(currents=(_scaled(stated.current_ma, 1e-3), _scaled(stated.kpa, 1e3)))
        if isinstance(stated, DutyTable):
            if not self.with_duty:
                problem = Sentence(
                    "the set pressure follows the duty of the lock-up solenoid, which an operating point does not state"
                )
                raise self._without_signal(steps, problem, "lockup_duty_percent")
            return SetPressure(duties=(_scaled(stated.duty_percent, 1e-2), _scaled(stated.kpa, 1e3)))
        if isinstance(stated, ByGearTable):
            by_gear = {int(gear): kpa * 1e3 for gear, kpa in stated.gear.items()}
            self.gears_of(list(by_gear), steps)
            if missing := sorted(set(gears) - set(by_gear)):
                expected = Sentence("a pressure for gears {gears} too", gears=missing)
                raise self.fault(steps, Sentence("not all gears are stated"), expected=expected)
            return SetPressure(gears=MappingProxyType(by_gear))
        if isinstance(stated, dict):
            return SetPressure(points=self.by_point(stated, steps, 1e3))
        return SetPressure(number=stated * 1e3)

    def _without_signal(self, steps: KeySteps, problem: Sentence, key: str) -> CatalogueError:
        expected = Sentence("{key} in every table [[operating_points]]", key=key)
        return self.fault(steps, problem, expected=expected)


_FROM_NOTHING = {
    "gap": Sentence("a gap that leaks from no section"),
    "leak": Sentence("a leak that leaks from no section"),
}
_TO_ITSELF = {
    "gap": Sentence("a gap that ends where it begins"),
    "leak": Sentence("a leak that ends where it begins"),
}


def gears_listed(gears: Iterable[int]) -> Sentence | None:
    """List the gears that would have been right, as files write them and as people do.

    >>> gears_listed([-1, 0, 1, 2])
    'one of R (-1), N (0), 1, 2'
    """
    letters = {-1: "R (-1)", 0: "N (0)"}
    return one_of([letters.get(gear, str(gear)) for gear in gears])


def _scaled(values: Sequence[float], unit: float) -> tuple[float, ...]:
    return tuple(value * unit for value in values)


def read_circuits(tables: Sequence[CircuitTable], reading: PartReading) -> tuple[Circuit, ...]:
    """Return the circuits of a file.

    What is wrong is gathered: an id given twice or that means something else, an unknown section, gear or operating
    point, circuits that follow or feed themselves.
    """

    def circuit(table: CircuitTable, where: KeySteps) -> Circuit:
        if table.id in {*SECTIONS, *DRAINS} or table.id.isdigit():
            problem, expected = Sentence("an id that already names something else"), Sentence("another id")
            raise reading.fault((*where, "id"), problem, value=table.id, expected=expected)
        gears = reading.gears_of(table.gears, (*where, "gears"))
        feeds = []
        for number, feed in enumerate(table.feeds):
            at = (*where, "feeds", number, "from")
            if feed.source == table.id:
                problem, expected = Sentence("a circuit that feeds itself"), Sentence("another section")
                raise reading.fault(at, problem, value=table.id, expected=expected)
            feeds.append(made(Feed, feed, source=reading.section(feed.source, at)))
        set_pressure = reading.set_pressure(table.set_kpa, (*where, "set_kpa"), gears)
        return made(Circuit, table, gears=gears, feeds=tuple(feeds), set_pressure=set_pressure)

    circuits = reading.objects_of(tables, ("circuits",), circuit, twice=Sentence("circuit given twice"))
    _refuse_circles(circuits, tables, reading)
    return tuple(circuits)


def _refuse_circles(circuits: Sequence[Circuit], tables: Sequence[CircuitTable], reading: PartReading) -> None:
    """Refuse set pressures that follow one another in a circle, and circuits that feed one another in one."""
    follows = {
        circuit.id: {circuit.set_pressure.following.section}
        for circuit in circuits
        if circuit.set_pressure is not None and circuit.set_pressure.following is not None
    }
    fed = {circuit.id: {feed.source for feed in circuit.feeds} for circuit in circuits}
    for key, leads, problem in (
        ("set_kpa", follows, Sentence("a set pressure that follows itself")),
        ("feeds", fed, Sentence("circuits that feed one another in a circle")),
    ):
        for number, table in enumerate(tables):
            before: set[str] = set()
            next_ones = leads.get(table.id, set())
            while next_ones:
                before |= next_ones
                next_ones = {other for one in next_ones for other in leads.get(one, ())} - before
            if table.id in before:
                value = ", ".join(sorted(leads[table.id]))
                at = (*reading.place(("circuits",), number), key)
                expected = Sentence("another circuit")
                reading.faults.append(reading.fault(at, problem, value=value, expected=expected))
                break  # the others of the circle would say the same


def read_line(table: LineTable, reading: PartReading) -> SetPressure | None:
    """Return the set pressure of the line, which may follow a circuit but no section that the line supplies."""
    at = ("line", "set_kpa")
    with reading.gathering():
        stated = reading.set_pressure(table.set_kpa, at, reading.gears)
        if stated is not None and stated.following is not None and stated.following.section in SECTIONS:
            problem = Sentence("the line's set pressure follows a section that it supplies")
            value, expected = stated.following.section, Sentence("the id of a circuit")
            raise reading.fault(at, problem, value=value, expected=expected)
        return stated
    return None


def read_leaks(tables: Sequence[LeakTable], reading: PartReading) -> tuple[Leak, ...]:
    """Return the leaks beside the lands.

    What is wrong is gathered: an unknown section or gear, an id given twice, a leak that could leak nothing.
    """

    def leak(table: LeakTable, where: KeySteps) -> Leak:
        high, low = reading.ends(table.high, table.low, where, "leak")
        at = in_si(table)
        return made(
            Leak,
            table,
            name=table.name or table.id.replace("_", " "),
            high=high,
            low=low,
            viscosity=at["at_viscosity"] * at["density"] if table.law == "laminar" else None,
            gears=reading.gears_of(table.gears, (*where, "gears")),
            into_sump=not low.is_section,
        )

    return tuple(reading.objects_of(tables, ("leaks",), leak, twice=Sentence("leak given twice")))


def read_consumers(tables: Sequence[ConsumerTable], reading: PartReading) -> tuple[Consumer, ...]:
    """Return the consumers.

    What is wrong is gathered: an operating point that is unknown or not stated, or an id given twice.
    """

    def consumer(table: ConsumerTable, where: KeySteps) -> Consumer:
        stated, per_minute = table.flow_dm3_min, 1.0 / 60e3
        by_point = isinstance(stated, dict)
        flow = reading.by_point(stated, (*where, "flow_dm3_min"), per_minute) if by_point else stated / 60e3
        name, law = table.name or table.id.replace("_", " "), table.law or "orifice"
        return made(Consumer, table, name=name, flow=flow, law=law)

    return tuple(reading.objects_of(tables, ("consumers",), consumer, twice=Sentence("consumer given twice")))


def read_permissible(
    tables: Sequence[PermissiblePressureTable], reading: PartReading
) -> tuple[PermissiblePressure, ...]:
    """Return between which pressures main pressure must lie.

    What is wrong is gathered: an unknown gear, or a gear or range given twice in one state.
    """
    known: list[PermissiblePressure] = []

    def permissible(table: PermissiblePressureTable, where: KeySteps) -> None:
        stated = (table.gears or []) if table.gear is None else [table.gear]
        key = "gears" if table.gear is None else "gear"
        gears = reading.gears_of(stated, (*where, key))
        ranges = frozenset(table.ranges or ())
        for other in known:
            if other.state == table.state:
                twice = Sentence("gear given twice for the state {state}", state=table.state)
                _refuse_twice(twice, key, gears & other.gears, where, reading)
                twice = Sentence("range given twice for the state {state}", state=table.state)
                _refuse_twice(twice, "ranges", ranges & other.ranges, where, reading)
        published = table.evidence is not Evidence.REPRESENTATIVE
        known.append(made(PermissiblePressure, table, gears=gears, ranges=ranges, published=published))

    reading.objects_of(tables, ("permissible_pressure",), permissible)
    return tuple(known)


def _refuse_twice(
    problem: Sentence, key: str, both: Iterable[int | str], where: KeySteps, reading: PartReading
) -> None:
    """Refuse a gear or range whose permissible pressures another table states for the same state."""
    for value in sorted(both, key=str):
        raise reading.fault((*where, key), problem, value=value)
