"""Known patterns of a stationary pressure table, said in plain words and hedged: where to look first.

A pattern is a hint, no verdict. It is named only where enough cells were measured to tell it from chance and from the
other patterns; a table of a few cells has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

from atleak.catalogue.controller_tables import SelectorRange
from atleak.diagnosis.uncertainty.posterior import Fault
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell

Stands = Literal["low", "normal", "high"]
PatternKind = Literal["low_at_slow_idle", "one_range_low", "falling", "all_low", "all_high", "circuit_loss"]
PatternSource = Literal["practice", "project", "computed"]  # trade practice; a choice of this project; the engine

RANGES_THAT_TELL = 3  # measured with one state of the engine: choice of this project
STATES_THAT_TELL = 2  # of the engine, for what holds everywhere: choice of this project
READINGS_THAT_FALL = 3  # of one cell, one after the other: choice of this project
_SURELY = 2.0  # standard uncertainties of the gauge


@dataclass(frozen=True)
class GaugeStanding:
    """One gauge reading, as the patterns need it."""

    cell: GaugeCell
    pressure: float  # [Pa]
    repeat: int = 1
    uncertainty: float = 0.0  # [Pa] standard, of the gauge
    stands: Stands | None = None  # to what is permissible; None where nothing is
    loss: float | None = None  # [Pa] of a circuit that is flagged for it; None elsewhere
    causes: Mapping[Fault, float] = field(default_factory=dict)  # the part of that loss which each explains
    measured: bool = False  # whether any land of its circuit was


@dataclass(frozen=True)
class Pattern:
    """A known pattern: who says what it hints at, the cells that show it, and what its sentence names."""

    kind: PatternKind
    source: PatternSource
    cells: tuple[GaugeCell, ...]
    ranges: tuple[SelectorRange, ...] = ()  # that are low
    others: tuple[SelectorRange, ...] = ()  # that are not
    circuits: tuple[str, ...] = ()  # ids of those that may leak
    worst: GaugeCell | None = None  # of those that fall or have lost most
    amount: float | None = None  # there: by which fraction it fell, or what it has lost against new [Pa]
    causes: Mapping[Fault, float] = field(default_factory=dict)  # there: which part of that each explains
    measured: bool = False  # whether any land that explains it was


@dataclass(frozen=True)
class _Line:
    """How main pressure stands in every range, by state of the engine: by the last reading of each cell."""

    readings: Sequence[GaugeStanding]
    of_engine: Mapping[Engine, Mapping[SelectorRange, Stands]] = field(default_factory=dict)

    @classmethod
    def of(cls, readings: Sequence[GaugeStanding]) -> _Line:
        """Return the line's cells that are judged."""
        last: dict[GaugeCell, GaugeStanding] = {}
        for reading in sorted(readings, key=lambda each: each.repeat):
            if reading.cell.tap == LINE_TAP and reading.stands is not None:
                last[reading.cell] = reading
        by_engine: dict[Engine, dict[SelectorRange, Stands]] = {}
        for cell, reading in last.items():
            assert reading.stands is not None
            by_engine.setdefault(cell.engine, {})[cell.range] = reading.stands
        return cls(readings, by_engine)

    def all_are(self, stands: Stands) -> tuple[GaugeCell, ...]:
        """Return all judged cells where every one of them stands so, in enough ranges and states; else none."""
        enough = [engine for engine, ranges in self.of_engine.items() if len(ranges) >= RANGES_THAT_TELL]
        every = {each for ranges in self.of_engine.values() for each in ranges.values()}
        if len(enough) < STATES_THAT_TELL or every != {stands}:
            return ()
        return tuple(GaugeCell(selected, engine) for engine, ranges in self.of_engine.items() for selected in ranges)


def find_patterns(
    readings: Sequence[GaugeStanding], applied: Mapping[SelectorRange, frozenset[str]] | None = None
) -> tuple[Pattern, ...]:
    """Return the patterns that a table shows; none where too few cells were measured to tell.

    ``applied`` are the circuits that are applied in each range, by id, where the controller's file tells.
    """
    line = _Line.of(readings)
    return (
        *_low_at_slow_idle(line),
        *_everywhere(line),
        *_one_range(line, applied or {}),
        *_falling(readings),
        *_circuit_loss(readings),
    )


def _low_at_slow_idle(line: _Line) -> Iterator[Pattern]:
    """All ranges low at slow idle but not with the pump turning faster: the pump first, or internal leakage.

    Without readings at fast idle those at stall show it.
    """
    slow = line.of_engine.get(Engine.SLOW_IDLE, {})
    faster = Engine.FAST_IDLE if line.of_engine.get(Engine.FAST_IDLE) else Engine.STALL
    fast = line.of_engine.get(faster, {})
    both = [selected for selected in slow if selected in fast]
    if len(both) >= RANGES_THAT_TELL and set(slow.values()) == {"low"} and "low" not in fast.values():
        cells = [GaugeCell(selected, engine) for engine in (Engine.SLOW_IDLE, faster) for selected in both]
        yield Pattern("low_at_slow_idle", "practice", tuple(cells), ranges=tuple(slow))


def _everywhere(line: _Line) -> Iterator[Pattern]:
    """All low, or all high, with every state of the engine: what all ranges share."""
    if low := line.all_are("low"):
        yield Pattern("all_low", "project", low)
    if high := line.all_are("high"):
        yield Pattern("all_high", "project", high)


def _one_range(line: _Line, applied: Mapping[SelectorRange, frozenset[str]]) -> Iterator[Pattern]:
    """One range low and the others not: the circuit of its clutch or brake."""
    judged = {engine: ranges for engine, ranges in line.of_engine.items() if len(ranges) >= RANGES_THAT_TELL}
    low = {selected for ranges in line.of_engine.values() for selected, stands in ranges.items() if stands == "low"}
    cells = [GaugeCell(each, engine) for engine, ranges in judged.items() for each in ranges if ranges[each] == "low"]
    if len(low) != 1 or not cells:
        return
    (selected,) = low
    others = [each for each in dict.fromkeys(each for ranges in judged.values() for each in ranges) if each != selected]
    alone = applied.get(selected, frozenset()).difference(*(applied.get(other, frozenset()) for other in others))
    yield Pattern(
        "one_range_low",
        "practice",
        tuple(cells),
        ranges=(selected,),
        others=tuple(others),
        circuits=tuple(sorted(alone)),
    )


def _falling(readings: Sequence[GaugeStanding]) -> Iterator[Pattern]:
    """Pressure that falls with every reading, by more than the gauge may err: the filter."""
    by_cell: dict[GaugeCell, list[GaugeStanding]] = {}
    for reading in sorted(readings, key=lambda each: each.repeat):
        by_cell.setdefault(reading.cell, []).append(reading)
    fell = {}
    for cell, taken in by_cell.items():
        steadily = all(after.pressure < before.pressure for before, after in pairwise(taken))
        fall = taken[0].pressure - taken[-1].pressure
        if len(taken) >= READINGS_THAT_FALL and steadily and fall > _SURELY * taken[0].uncertainty:
            fell[cell] = fall / taken[0].pressure
    if fell:
        worst = max(fell, key=lambda cell: fell[cell])
        yield Pattern("falling", "practice", tuple(fell), worst=worst, amount=fell[worst])


def _circuit_loss(readings: Sequence[GaugeStanding]) -> Iterator[Pattern]:
    """Circuits that have lost more than their limit: where to look, the likeliest first."""
    lost: dict[str, dict[GaugeCell, GaugeStanding]] = {}
    for reading in readings:
        if reading.loss is not None:
            lost.setdefault(reading.cell.tap, {})[reading.cell] = reading
    for tap, cells in lost.items():
        worst = max(cells.values(), key=lambda each: each.loss or 0.0)
        yield Pattern(
            "circuit_loss",
            "computed",
            tuple(cells),
            circuits=(tap,),
            worst=worst.cell,
            amount=worst.loss,
            causes=worst.causes,
            measured=worst.measured,
        )
