"""Known patterns of a stationary pressure table, said in plain words and hedged: where to look first.

A pattern is a hint, no verdict. It is named only where enough cells were measured to tell it from chance and from the
other patterns; a table of a few cells has none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

from atleak.catalogue.circuit_tables import SelectorRange
from atleak.pressure_table import LINE, Cell, Engine
from atleak.workshop_units import KPA, PERCENT

Stands = Literal["low", "normal", "high"]
PatternKind = Literal["low_at_slow_idle", "one_range_low", "falling", "all_low", "all_high", "below_line"]

RANGES_THAT_TELL = 3  # measured with one state of the engine: choice of this project
STATES_THAT_TELL = 2  # of the engine, for what holds everywhere: choice of this project
READINGS_THAT_FALL = 3  # of one cell, one after the other: choice of this project

PRACTICE = "trade practice in reading stationary pressure tables"
SHARED = "what all ranges share (choice of this project)"
FORD = "Ford clutch pressure test: more than 103 kPa below line pressure"


@dataclass(frozen=True)
class Standing:
    """One gauge reading, as the patterns need it."""

    cell: Cell
    pressure: float  # [Pa]
    repeat: int = 1
    uncertainty: float = 0.0  # [Pa] standard, of the gauge
    stands: Stands | None = None  # to what is permissible; None where nothing is
    below_line: float | None = None  # [Pa] of a circuit's tap that line pressure should reach; None elsewhere


@dataclass(frozen=True)
class Pattern:
    """A known pattern: what it hints at, in one sentence, who says so, and the cells that show it."""

    kind: PatternKind
    text: str
    source: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class _Line:
    """How main pressure stands in every range, by state of the engine: by the last reading of each cell."""

    readings: Sequence[Standing]
    of_engine: Mapping[Engine, Mapping[SelectorRange, Stands]] = field(default_factory=dict)

    @classmethod
    def of(cls, readings: Sequence[Standing]) -> _Line:
        """Return the line's cells that are judged."""
        last: dict[Cell, Standing] = {}
        for each in sorted(readings, key=lambda each: each.repeat):
            if each.cell.tap == LINE and each.stands is not None:
                last[each.cell] = each
        by_engine: dict[Engine, dict[SelectorRange, Stands]] = {}
        for cell, each in last.items():
            assert each.stands is not None
            by_engine.setdefault(cell.engine, {})[cell.range] = each.stands
        return cls(readings, by_engine)

    def all_are(self, stands: Stands) -> tuple[Cell, ...]:
        """Return all judged cells where every one of them stands so, in enough ranges and states; else none."""
        enough = [engine for engine, ranges in self.of_engine.items() if len(ranges) >= RANGES_THAT_TELL]
        every = {each for ranges in self.of_engine.values() for each in ranges.values()}
        if len(enough) < STATES_THAT_TELL or every != {stands}:
            return ()
        return tuple(Cell(selected, engine) for engine, ranges in self.of_engine.items() for selected in ranges)


def find_patterns(
    readings: Sequence[Standing],
    *,
    loss: float,
    loss_source: str = FORD,
    applied: Mapping[SelectorRange, frozenset[str]] | None = None,
) -> tuple[Pattern, ...]:
    """Return the patterns that a table shows; none where too few cells were measured to tell.

    Parameters
    ----------
    readings
        every reading, with how it stands to what is permissible.
    loss
        by which a circuit's tap may be below line pressure [Pa].
    loss_source
        who says so.
    applied
        names of the circuits that are applied in each range, where the controller's file tells.
    """
    line = _Line.of(readings)
    found = [
        *_low_at_slow_idle(line),
        *_everywhere(line),
        *_one_range(line, applied or {}),
        *_falling(readings),
        *_below_line(readings, loss, loss_source),
    ]
    return tuple(found)


def _low_at_slow_idle(line: _Line) -> Iterator[Pattern]:
    slow, fast = (line.of_engine.get(engine, {}) for engine in (Engine.SLOW_IDLE, Engine.FAST_IDLE))
    both = [selected for selected in slow if selected in fast]
    if len(both) < RANGES_THAT_TELL or set(slow.values()) != {"low"} or "low" in fast.values():
        return
    text = (
        f"Main pressure is low in all ranges at slow idle ({_listed(slow)}) and not at fast idle: look at the pump "
        "first; internal leakage is possible, since a pump that turns faster covers it."
    )
    cells = [Cell(selected, engine) for engine in (Engine.SLOW_IDLE, Engine.FAST_IDLE) for selected in both]
    yield Pattern("low_at_slow_idle", text, PRACTICE, tuple(cells))


def _everywhere(line: _Line) -> Iterator[Pattern]:
    low, high = line.all_are("low"), line.all_are("high")
    if low:
        text = (
            f"Main pressure is low everywhere it was measured and judged ({len(low)} cells): what all ranges share "
            "comes first, that is fluid level, filter, pump and the regulation of main pressure; leakage ahead of the ranges "
            "is possible."
        )
        yield Pattern("all_low", text, SHARED, low)
    if high:
        text = (
            f"Main pressure is high everywhere it was measured and judged ({len(high)} cells): the regulation of main "
            "pressure comes first, its valve, its solenoid or cable and what commands it; leakage does not raise it."
        )
        yield Pattern("all_high", text, SHARED, high)


def _one_range(line: _Line, applied: Mapping[SelectorRange, frozenset[str]]) -> Iterator[Pattern]:
    judged = {engine: ranges for engine, ranges in line.of_engine.items() if len(ranges) >= RANGES_THAT_TELL}
    low = {selected for ranges in line.of_engine.values() for selected, stands in ranges.items() if stands == "low"}
    cells = [Cell(each, engine) for engine, ranges in judged.items() for each in ranges if ranges[each] == "low"]
    if len(low) != 1 or not cells:
        return
    (selected,) = low
    others = {each for ranges in judged.values() for each in ranges if each != selected}
    alone = applied.get(selected, frozenset()).difference(*(applied.get(other, frozenset()) for other in others))
    named = f" ({_listed(sorted(alone))})" if alone else ""
    text = (
        f"Main pressure is low in {selected} alone and not in {_listed(sorted(others))}: the circuit of the clutch or "
        f"brake that is applied in {selected}{named} may leak."
    )
    yield Pattern("one_range_low", text, PRACTICE, tuple(cells))


def _falling(readings: Sequence[Standing]) -> Iterator[Pattern]:
    by_cell: dict[Cell, list[Standing]] = {}
    for each in sorted(readings, key=lambda each: each.repeat):
        by_cell.setdefault(each.cell, []).append(each)
    fell = {}
    for cell, taken in by_cell.items():
        steadily = all(after.pressure < before.pressure for before, after in pairwise(taken))
        fall = taken[0].pressure - taken[-1].pressure
        if len(taken) >= READINGS_THAT_FALL and steadily and fall > 2.0 * taken[0].uncertainty:
            fell[cell] = fall / taken[0].pressure
    if fell:
        worst = max(fell, key=lambda cell: fell[cell])
        text = (
            f"Pressure falls with every reading, in {worst.range} at {worst.engine.label} by "
            f"{fell[worst] * PERCENT:.0f} %: the filter may be clogging, or the pump may be drawing air."
        )
        yield Pattern("falling", text, PRACTICE, tuple(fell))


def _below_line(readings: Sequence[Standing], loss: float, source: str) -> Iterator[Pattern]:
    far: dict[str, list[Standing]] = {}
    for each in readings:
        if each.below_line is not None and each.below_line > loss:
            far.setdefault(each.cell.tap, []).append(each)
    for tap, found in far.items():
        worst = max(found, key=lambda each: each.below_line or 0.0)
        text = (
            f"{tap} is up to {(worst.below_line or 0.0) * KPA:.0f} kPa below line pressure (in {worst.cell.range} at "
            f"{worst.cell.engine.label}), more than {loss * KPA:.0f} kPa: that circuit may leak."
        )
        yield Pattern("below_line", text, source, tuple(dict.fromkeys(each.cell for each in found)))


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
