"""Read the tables of a controller's file against one another, and gather what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeVar

from atleak.catalogue.circuit_tables import ByGearTable, CurrentTable, DutyTable, FollowingTable, SetTable
from atleak.catalogue.circuits import Following, SetPressure
from atleak.catalogue.section_pressures import Pressure
from atleak.errors import CatalogueError, Steps, nearest_name, one_of
from atleak.faults import NotAccepted, place_of, place_of_table
from atleak.sentence import Sentence

Entry = TypeVar("Entry")
Made = TypeVar("Made")


@dataclass(frozen=True)
class Reading:
    """What the tables are read against: the file, its gears, operating points and sections."""

    path: Path
    data: Any  # the file's tables
    gears: Sequence[int]
    points: Sequence[str]
    with_current: bool  # every operating point states a solenoid's current
    with_duty: bool  # every operating point states the lock-up solenoid's duty
    sections: Sequence[str]  # those that pressures may name, circuits included
    kept: Mapping[Steps, Sequence[int]]  # by list, where tables were set aside: the places of the others
    faults: list[CatalogueError] = field(default_factory=list)  # gathered so far

    @contextmanager
    def gathering(self) -> Iterator[None]:
        """Gather the fault that reading one table ends in, so that the next can be read."""
        try:
            yield
        except CatalogueError as fault:
            self.faults.append(fault)

    def each(
        self,
        tables: Sequence[Entry],
        at: Steps,
        make: Callable[[Entry, Steps], Made],
        *,
        twice: Sentence | None = None,
        named_by: str = "id",
    ) -> list[Made]:
        """Return what is made of each table, gathering the faults of those that are wrong.

        Where they have names and ``twice`` says what is wrong otherwise, no two may have the same.
        """
        objects: list[Made] = []
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

    def place(self, at: Steps, number: int) -> Steps:
        """Return the steps to a table of a list, of which some may have been set aside."""
        return (*at, self.kept[at][number] if at in self.kept else number)

    def fault(
        self,
        steps: Steps,
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

    def fault_of_table(self, steps: Steps, problem: Sentence, *, expected: Sentence | None = None) -> CatalogueError:
        """Return a fault of the whole table that the steps lead to."""
        return CatalogueError(problem, place=place_of_table(steps, self.data, self.path.name), expected=expected)

    def unknown(
        self, steps: Steps, problem: Sentence, value: object, known: Collection[str], *, refers_to: str | None = None
    ) -> CatalogueError:
        """Return the fault of a name that is none of the known ones; it lists them and gives the nearest."""
        place = place_of(steps, self.data, self.path.name)
        nearest = nearest_name(str(value), known) if value is not None else None
        fault = CatalogueError(problem, place=place, value=value, expected=one_of(known), nearest=nearest)
        fault.refers_to = refers_to
        return fault

    def unknown_gear(self, steps: Steps, gear: int) -> CatalogueError:
        """Return the fault of a gear that the controller does not have."""
        expected = gears_listed(self.gears)
        return self.fault(steps, Sentence("unknown gear"), value=gear, expected=expected, refers_to="gears")

    def pressure(self, text: str, steps: Steps) -> Pressure:
        """Read a pressure of one of the sections."""
        try:
            pressure = Pressure.parse(text)
        except NotAccepted as error:
            raise self.fault(steps, Sentence("not a pressure"), value=text, expected=error.wanted) from None
        if pressure.section is not None:
            self.section(pressure.section, steps)
        return pressure

    def ends(self, high: str, low: str, table: Steps, what: Literal["gap", "leak"]) -> tuple[Pressure, Pressure]:
        """Read the two pressures between which a gap or leak lies, the first that of a section or circuit."""
        begin, end = self.pressure(high, (*table, "from")), self.pressure(low, (*table, "to"))
        if begin.section is None:
            expected = Sentence("a section such as p_g, or the id of a circuit")
            raise self.fault((*table, "from"), _FROM_NOTHING[what], value=high, expected=expected)
        if begin == end:
            raise self.fault((*table, "to"), _TO_ITSELF[what], value=low, expected=Sentence("another pressure"))
        return begin, end

    def section(self, name: str, steps: Steps) -> str:
        """Check the name of a section."""
        if name not in self.sections:
            problem = Sentence("no such section or circuit")
            raise self.unknown(steps, problem, name, self.sections, refers_to="circuits")
        return name

    def gears_of(self, stated: Sequence[int] | None, steps: Steps) -> frozenset[int]:
        """Check gears; all of the controller's where none are stated."""
        others = sorted(set(stated or ()) - set(self.gears))
        if others:
            raise self.unknown_gear(steps, others[0])
        return frozenset(self.gears if stated is None else stated)

    def by_point(self, stated: Mapping[str, float], steps: Steps, unit: float) -> Mapping[str, float]:
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

    def set_pressure(self, stated: SetTable | None, steps: Steps, gears: Iterable[int]) -> SetPressure | None:
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

    def _without_signal(self, steps: Steps, problem: Sentence, key: str) -> CatalogueError:
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
