"""Read the circuits, leaks, consumers, line and permissible pressures of a controller's file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from atleak.catalogue.circuit_tables import (
    CircuitTable,
    ConsumerTable,
    LeakTable,
    LineTable,
    PermissiblePressureTable,
)
from atleak.catalogue.circuits import (
    Circuit,
    Consumer,
    Feed,
    Leak,
    PermissiblePressure,
    SetPressure,
)
from atleak.catalogue.entries import Evidence
from atleak.catalogue.keys import in_si, made
from atleak.catalogue.reading import Reading, Steps
from atleak.catalogue.section_pressures import DRAINS, SECTIONS
from atleak.sentence import Sentence


def read_circuits(tables: Sequence[CircuitTable], reading: Reading) -> tuple[Circuit, ...]:
    """Return the circuits of a file.

    What is wrong is gathered: an id given twice or that means something else, an unknown section, gear or operating
    point, circuits that follow or feed themselves.
    """

    def circuit(table: CircuitTable, where: Steps) -> Circuit:
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

    circuits = reading.each(tables, ("circuits",), circuit, twice=Sentence("circuit given twice"))
    _refuse_circles(circuits, tables, reading)
    return tuple(circuits)


def _refuse_circles(circuits: Sequence[Circuit], tables: Sequence[CircuitTable], reading: Reading) -> None:
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


def read_line(table: LineTable, reading: Reading) -> SetPressure | None:
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


def read_leaks(tables: Sequence[LeakTable], reading: Reading) -> tuple[Leak, ...]:
    """Return the leaks beside the lands.

    What is wrong is gathered: an unknown section or gear, an id given twice, a leak that could leak nothing.
    """

    def leak(table: LeakTable, where: Steps) -> Leak:
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

    return tuple(reading.each(tables, ("leaks",), leak, twice=Sentence("leak given twice")))


def read_consumers(tables: Sequence[ConsumerTable], reading: Reading) -> tuple[Consumer, ...]:
    """Return the consumers.

    What is wrong is gathered: an operating point that is unknown or not stated, or an id given twice.
    """

    def consumer(table: ConsumerTable, where: Steps) -> Consumer:
        stated, per_minute = table.flow_dm3_min, 1.0 / 60e3
        by_point = isinstance(stated, dict)
        flow = reading.by_point(stated, (*where, "flow_dm3_min"), per_minute) if by_point else stated / 60e3
        name, law = table.name or table.id.replace("_", " "), table.law or "orifice"
        return made(Consumer, table, name=name, flow=flow, law=law)

    return tuple(reading.each(tables, ("consumers",), consumer, twice=Sentence("consumer given twice")))


def read_permissible(tables: Sequence[PermissiblePressureTable], reading: Reading) -> tuple[PermissiblePressure, ...]:
    """Return between which pressures main pressure must lie.

    What is wrong is gathered: an unknown gear, or a gear or range given twice in one state.
    """
    known: list[PermissiblePressure] = []

    def permissible(table: PermissiblePressureTable, where: Steps) -> None:
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

    reading.each(tables, ("permissible_pressure",), permissible)
    return tuple(known)


def _refuse_twice(problem: Sentence, key: str, both: Iterable[int | str], where: Steps, reading: Reading) -> None:
    """Refuse a gear or range whose permissible pressures another table states for the same state."""
    for value in sorted(both, key=str):
        raise reading.fault((*where, key), problem, value=value)
