"""Find the pressures at which every circuit of a network balances: what its feeds bring in is what leaves it.

For a circuit i, with flows that rise with their pressure drops,

    out_i(p) − in_i(p) = feeds_i(p)            where its feeds cannot hold more than its set pressure,
    p_i = set_i, the feeds pass what is drawn   where they can: a regulator throttles them.

Every flow out of a circuit rises with its own pressure and falls with its neighbours', so the balances form an
M-function: there is one solution, and steps from above come down to it (Rheinboldt, J. Math. Anal. Appl. 32, 1970).
Which circuits are at their set pressure follows in each step from the balance there, as in Howard's policy iteration.

All numbers are stacked: a row for each pressure and each branch, a column for each condition, sample or draw.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.restrictions import Branch, GapBranch, Orifice, Restriction, leaks_both_ways
from atleak.equations import orifice as orifice_equations

BALANCED = 1e-9  # mass balance of every circuit, over the largest flow of its network
_LAST_DIGIT = 4e-16  # of a pressure, relative: nothing can be balanced finer
_SAME = 1e-12  # of the highest pressure: by which a pressure may differ from the one that it is set to
_BLOCK = 150_000  # numbers of one kind worked on at a time: they stay in the processor's cache
_FEW, _MANY = 64, 512  # columns that are solved first of so many: all others start from their mean
_STEPS, _FREE = 120, 6  # of Newton's at the most, and of those that may go as far as they like


@dataclass(frozen=True)
class Balance:
    """Every pressure of a network and the flows of its circuits; arrays where anything was one."""

    pressures: Mapping[str, Any]  # [Pa] of every section and circuit
    feeds: Mapping[str, Any]  # [m³/s] what each circuit takes through its feeds
    relief: Mapping[str, Any]  # [m³/s] what each circuit relieves to the sump
    converged: Any  # whether every mass balance was reached


class Circuits(Protocol):
    """A network of circuits, as far as its balance needs it."""

    @property
    def point(self) -> OperatingPoint: ...

    @property
    def solves(self) -> bool: ...

    @property
    def applied(self) -> tuple[Circuit, ...]: ...

    @property
    def vented(self) -> frozenset[str]: ...

    @property
    def solved(self) -> frozenset[str]: ...

    @property
    def branches(self) -> tuple[Branch[Restriction], ...]: ...

    @property
    def feeds(self) -> tuple[Branch[Orifice], ...]: ...


def balance(network: Circuits, sections: Mapping[str, Any], after: Balance | None = None) -> Balance:
    """Find the pressures of the circuits, and add up what flows at them.

    Parameters
    ----------
    sections
        pressures of the sections [Pa], numbers or arrays.
    after
        a balance of the same network at other pressures of the sections: where none of these has changed it is taken
        over, and elsewhere the circuits start from its pressures.
    """
    structure = _Structure(network, sections)
    numbers, count = _Numbers.of(structure, sections), len(network.applied)
    size, names = numbers.size, [*(circuit.id for circuit in network.applied), *structure.vented]
    pressures, feeds = np.empty((count, size)), np.empty((count, size))
    relief, converged = np.empty((len(names), size)), np.empty(size, bool)
    most = max(_BLOCK // max(len(structure.branches), 1), 4 * _FEW)
    block = math.ceil(size / max(math.ceil(size / most), 1))
    room = np.empty((3, structure.gaps, block))
    parts: list[Any] = [slice(start, start + block) for start in range(0, size, max(block, 1))]
    if after is not None:
        for number, name in enumerate(names):
            relief[number] = _flat(after.relief[name], numbers.shape)
            if number < count:
                pressures[number] = _flat(after.pressures[name], numbers.shape)
                feeds[number] = _flat(after.feeds[name], numbers.shape)
        converged[:] = _flat(after.converged, numbers.shape)
        moved, before = numbers.moved_from(after)
        changed = np.flatnonzero(moved)
        parts = [changed[start : start + block] for start in range(0, len(changed), block)]
    few = slice(0, size, max(size // _FEW, 1))
    if after is None and network.solved and size >= _MANY:
        parts.insert(0, few)
    mean: np.ndarray | None = None  # what the circuits of a few columns hold, over the highest pressure
    for part in parts:
        columns = numbers.columns(part, room)
        near = None if mean is None else mean * columns.top
        if after is not None:  # as the sections rise or fall, the circuits do
            near = pressures[:, part] * (columns.top / np.where(before[part] > 0.0, before[part], np.inf))
        converged[part], feeds[:, part], relief[:, part] = _solved(columns, near)
        pressures[:, part] = columns.pressures[:count]
        sound = converged[part] & (columns.top > 0.0)
        if part is few and sound.any():
            mean = (columns.pressures[:count, sound] / columns.top[sound]).mean(axis=1, keepdims=True)

    def shaped(values: np.ndarray) -> Any:
        return values.reshape(numbers.shape) if numbers.shape else values.item()

    held = {circuit.id: shaped(each) for circuit, each in zip(network.applied, pressures, strict=True)}
    return Balance(
        dict(sections) | dict.fromkeys(network.vented, 0.0) | held,
        {circuit.id: shaped(each) for circuit, each in zip(network.applied, feeds, strict=True)},
        {name: shaped(each) for name, each in zip(names, relief, strict=True)},
        shaped(converged),
    )


@dataclass(frozen=True)
class _Flow:
    """A flow [m³/s] or pressure [Pa], and how it changes with the pressure of each circuit, by its number."""

    value: Any
    slopes: dict[int, Any]

    def __add__(self, other: _Flow) -> _Flow:
        slopes = dict(self.slopes)
        for at, slope in other.slopes.items():
            slopes[at] = slopes[at] + slope if at in slopes else slope
        return _Flow(self.value + other.value, slopes)

    def __sub__(self, other: _Flow) -> _Flow:
        slopes = dict(self.slopes)
        for at, slope in other.slopes.items():
            slopes[at] = slopes[at] - slope if at in slopes else -slope
        return _Flow(self.value - other.value, slopes)

    def times(self, factor: Any) -> _Flow:
        """Return it times a number that no pressure changes."""
        return _Flow(self.value * factor, {at: slope * factor for at, slope in self.slopes.items()})

    def over(self, other: _Flow) -> _Flow:
        """Return the ratio of two flows; zero where the other is."""
        inverse = 1.0 / np.where(other.value == 0.0, np.inf, other.value)
        ratio = self.value * inverse
        return _Flow(ratio, (self.times(inverse) - other.times(ratio * inverse)).slopes)

    def product(self, other: _Flow) -> _Flow:
        slopes = self.times(other.value) + other.times(self.value)
        return _Flow(self.value * other.value, slopes.slopes)

    def where(self, condition: Any, other: _Flow) -> _Flow:
        """Return this where a condition holds, elsewhere the other."""
        if condition.all():
            return self
        if not condition.any():
            return other
        slopes = {
            at: np.where(condition, self.slopes.get(at, 0.0), other.slopes.get(at, 0.0))
            for at in {**self.slopes, **other.slopes}
        }
        return _Flow(np.where(condition, self.value, other.value), slopes)


_NOTHING = _Flow(0.0, {})


class _Structure:
    """Which pressures and circuits the branches of a network join: all that no condition changes.

    Gaps between the same two pressures are one way for the fluid, every other branch is one of its own.
    """

    def __init__(self, network: Circuits, sections: Iterable[str]) -> None:
        self.network, self.point, self.circuits = network, network.point, network.applied
        self.vented = tuple(sorted(network.vented))
        names = [*(circuit.id for circuit in self.circuits), *self.vented]
        #: the row of each pressure: the circuits', then the vented ones', the sections' and the drain's
        self.rows: dict[str | None, int] = {name: row for row, name in enumerate([*names, *sections])}
        self.rows[None] = len(self.rows)
        self.last, touched = len(self.circuits), set(names)
        alike: dict[Any, list[Branch[Any]]] = {}  # gaps, by their ends
        holes: list[Branch[Any]] = []
        for each in network.branches:
            if {each.high.section, each.low.section} & touched or each.into in touched:
                if isinstance(each.restriction, GapBranch):
                    alike.setdefault((each.high, each.low, each.into), []).append(each)
                else:
                    holes.append(each)
        solved = [circuit.id in network.solved for circuit in self.circuits]
        #: circuits that a regulator or the line keeps at a pressure, wherever there is enough of it
        self.kept = [
            number
            for number, circuit in enumerate(self.circuits)
            if not solved[number] or circuit.set_pressure is not None
        ]
        feeds = sorted(network.feeds, key=lambda feed: self.rows[feed.into] in self.kept)
        #: the branches: gaps, those of a way together; holes; feeds, those into kept circuits last
        self.branches = [*itertools.chain(*alike.values()), *holes, *feeds]
        self.ways = [*(gaps[0] for gaps in alike.values()), *holes, *feeds]
        self.gaps, self.gap_ways = sum(map(len, alike.values())), len(alike)
        edges = list(itertools.accumulate(map(len, alike.values()), initial=0))
        self.together = [slice(*ends) for ends in itertools.pairwise(edges)]  # the gaps of each way
        self.way_of_gap = np.repeat(np.arange(self.gap_ways), [len(gaps) for gaps in alike.values()])
        self.ends = [(self.rows[each.high.section], self.rows[each.low.section]) for each in self.ways]
        self.high, self.low = np.array(self.ends, int).reshape(-1, 2).T
        #: of each circuit that is solved the ways that feed it
        self.feeds: list[list[int]] = [[] for _ in self.circuits]
        #: what leaves each circuit less what comes in with no feed throttled, and how that changes with every pressure,
        #: as sums over the ways
        self.sums: list[_Sum] = [[] for _ in names]
        self.pairs: dict[tuple[int, int], _Sum] = {}
        self.free = len(self.ways)  # all ways but those that feed kept circuits
        for number, each in enumerate(self.ways):
            into = None if each.into is None else self.rows[each.into]
            if number >= len(self.ways) - len(feeds) and into is not None:
                self.free -= into in self.kept
                if not solved[into]:
                    continue  # it is fed without any resistance
                self.feeds[into].append(number)
            for row, sign in ((self.rows[each.high.section], 1.0), (into, -1.0)):
                if row is not None and row < len(names):
                    self._add(row, number, sign)

    def _add(self, circuit: int, number: int, sign: float) -> None:
        """Count a way among those that a circuit feeds, or is fed by."""
        self.sums[circuit].append((number, sign))
        way = self.ways[number]
        for end, up in ((way.high, 1.0), (way.low, -1.0)):
            other = self.rows[end.section]
            if other < self.last:
                self.pairs.setdefault((circuit, other), []).append((number, sign * up * end.coefficient))

    @cached_property
    def shares(self) -> list[tuple[int, float, float, float]]:
        """Return the ways of which an end is a share of a pressure, or the lower one always the same pressure."""
        whole = ((1.0, 0.0), (0.0, 0.0))
        return [
            (number, each.high.coefficient, each.low.coefficient, each.low.constant)
            for number, each in enumerate(self.ways)
            if each.high.coefficient != 1.0 or (each.low.coefficient, each.low.constant) not in whole
        ]

    @cached_property
    def one_way(self) -> list[int]:
        """Return the ways that let nothing back although their lower pressure may be the higher one."""
        return [
            number
            for number, each in enumerate(self.ways[: len(self.ways) - len(self.network.feeds)])
            if not leaks_both_ways(each, self.network.solved) and (each.low.section or each.low.constant)
        ]


_Sum = list[tuple[int, float]]  # the numbers of ways, each with its factor


def _added(terms: _Sum, values: np.ndarray) -> Any:
    """Return the sum of some rows, each times its factor; of none, zero."""
    total: Any = 0.0
    for number, factor in terms:
        if factor == 1.0:
            total = total + values[number]
        else:
            total = total - values[number] if factor == -1.0 else total + factor * values[number]
    return total


@dataclass(frozen=True)
class _Numbers:
    """Every number of a network, each a single one or with one for each of all columns."""

    structure: _Structure
    shape: tuple[int, ...]
    size: int
    sections: Mapping[int, Any]  # [Pa] by row, shape (columns,); no section counts as below zero
    restrictions: tuple[list[Any], ...]  # conductances and bends of gaps, coefficients and transitions of orifices

    @classmethod
    def of(cls, structure: _Structure, sections: Mapping[str, Any]) -> _Numbers:
        """Lay the numbers of a network out flat."""
        restrictions: list[Any] = [each.restriction for each in structure.branches]
        gaps, orifices = restrictions[: structure.gaps], restrictions[structure.gaps :]
        given = (
            [each.conductance for each in gaps],
            [each.bend for each in gaps],
            [each.coefficient for each in orifices],
            [each.transition for each in orifices],
        )
        shape = np.broadcast_shapes(*(np.shape(each) for each in (*sections.values(), *itertools.chain(*given))))
        flat = {structure.rows[name]: np.maximum(_flat(each, shape), 0.0) for name, each in sections.items()}
        rows = ([each if np.ndim(each) == 0 else _flat(each, shape) for each in kind] for kind in given)
        return cls(structure, shape, math.prod(shape), flat, tuple(rows))

    def columns(self, chosen: Any, room: np.ndarray) -> _Columns:
        """Stack some of the columns, with every circuit at its highest pressure; ``room`` has space for as many."""
        pressures = np.zeros((len(self.structure.rows), len(self.sections[self.structure.rows["p_g"]][chosen])))
        for row, pressure in self.sections.items():
            pressures[row] = pressure[chosen]
        stacked = [_stacked(rows, chosen, pressures.shape[1]) for rows in self.restrictions]
        columns = _Columns(self.structure, pressures, GapBranch(*stacked[:2]), Orifice(*stacked[2:]), room)
        columns.start_from_above()
        return columns

    def moved_from(self, other: Balance) -> tuple[np.ndarray, np.ndarray]:
        """Return which columns have another pressure of any section than in a balance, and their highest one there."""
        changed, highest = np.zeros(self.size, bool), np.zeros(self.size)
        for name, row in self.structure.rows.items():
            if row in self.sections and name is not None:
                pressure = np.maximum(_flat(other.pressures[name], self.shape), 0.0)
                changed |= self.sections[row] != pressure
                np.maximum(highest, pressure, out=highest)
        return changed, highest


def _flat(value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return a number for each column from a number or an array of the network's shape."""
    if np.shape(value) == shape and len(shape) == 1:
        return value
    return np.broadcast_to(value, shape).reshape(-1)


def _stacked(rows: list[Any], chosen: Any, size: int) -> np.ndarray:
    """Return some columns of rows of numbers, with one column where no row is an array."""
    if all(np.ndim(row) == 0 for row in rows):
        return np.array(rows, float).reshape(-1, 1)
    stacked = np.empty((len(rows), size))
    for number, row in enumerate(rows):
        stacked[number] = row if np.ndim(row) == 0 else row[chosen]
    return stacked


@dataclass
class _Columns:
    """Some columns of the numbers of a network: conditions, samples or draws."""

    structure: _Structure
    pressures: np.ndarray  # [Pa], shape (pressures, columns): changed in place until everything balances
    gaps: GapBranch  # stacked, shapes (gaps, 1 or columns)
    orifices: Orifice  # likewise, the feeds last
    room: np.ndarray  # where drops, flows and slopes of gaps are written, shape (3, gaps, at least so many columns)

    @property
    def size(self) -> int:
        """Return how many columns there are."""
        return self.pressures.shape[1]

    def part(self, chosen: np.ndarray) -> _Columns:
        """Return the columns that are true."""

        def of(values: np.ndarray) -> np.ndarray:
            return values if values.shape[1] == 1 else values[:, chosen]

        gaps, orifices = self.gaps, self.orifices
        return _Columns(
            self.structure,
            self.pressures[:, chosen],
            GapBranch(of(gaps.conductance), of(gaps.bend)),
            Orifice(of(orifices.coefficient), of(orifices.transition)),
            self.room,
        )

    def drops(self) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
        """Return the pressure drop of every way [Pa], and where they would let something back but may not."""
        structure = self.structure
        drops = self.pressures[structure.high]
        drops -= self.pressures[structure.low]
        for number, high, low, constant in structure.shares:
            upper, lower = structure.ends[number]
            drops[number] = self.pressures[upper] * high - self.pressures[lower] * low - constant
        backwards = []
        for number in structure.one_way:
            if not drops[number].min(initial=0.0) >= 0.0:
                backwards.append((number, drops[number] >= 0.0))
                np.maximum(drops[number], 0.0, out=drops[number])
        return drops, backwards

    def flows_and_slopes(self, drops: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what every way lets through [m³/s], and how steeply that rises [m³/(s Pa)]."""
        structure, gaps = self.structure, self.structure.gap_ways
        every, flows, slopes = self.room[:, :, : self.size]
        np.take(drops, structure.way_of_gap, axis=0, out=every, mode="clip")
        self.gaps.flow_and_slope(every, (flows, slopes))
        summed = np.empty((2, *drops.shape))
        for number, gap in enumerate(structure.together):
            np.add.reduce(flows[gap], axis=0, out=summed[0, number])
            np.add.reduce(slopes[gap], axis=0, out=summed[1, number])
        summed[0, gaps:], summed[1, gaps:] = self.orifices.flow_and_slope(drops[gaps:])
        return summed[0], summed[1]

    @cached_property
    def line(self) -> np.ndarray:
        """Return the line's pressure [Pa]."""
        return self.pressures[self.structure.rows["p_g"]]

    @cached_property
    def top(self) -> np.ndarray:
        """Return the highest pressure [Pa]: no circuit can hold more, as all that comes in comes from the sections."""
        first = self.structure.last + len(self.structure.vented)
        return np.maximum(self.pressures[first:].max(axis=0), 0.0)

    def limit(self, number: int) -> _Flow | None:
        """Return the highest pressure that a circuit's regulator lets it have [Pa]; None without one."""
        circuit = self.structure.circuits[number]
        unfed = not circuit.feeds  # supplied by the line without any resistance
        if circuit.set_pressure is None:
            return _Flow(self.line, {}) if unfed else None
        following = circuit.set_pressure.following
        if following is None:
            stated = circuit.set_pressure.at(self.structure.point)
            assert stated is not None  # it follows nothing
            return _Flow(np.minimum(stated, self.line) if unfed else stated, {})
        row = self.structure.rows[following.section]
        value = following.ratio * self.pressures[row] + following.offset
        slopes = {row: np.where(value > 0.0, following.ratio, 0.0)} if row < self.structure.last else {}
        limit = _Flow(np.maximum(value, 0.0), slopes)
        return _Flow(self.line, {}).where(limit.value >= self.line, limit) if unfed else limit

    def start_from_above(self) -> None:
        """Give every circuit the pressure that it has where nothing leaks."""
        structure = self.structure
        for number, circuit in enumerate(structure.circuits):
            highest = self.top
            if circuit.feeds and not structure.network.solves:
                highest = self.pressures[[structure.rows[feed.source] for feed in circuit.feeds]].max(axis=0)
            limit = self.limit(number)
            self.pressures[number] = highest if limit is None else np.minimum(limit.value, highest)

    def start_from(self, pressures: np.ndarray) -> None:
        """Give every circuit that is solved a pressure [Pa], shape (circuits, columns), at most its highest."""
        for number, circuit in enumerate(self.structure.circuits):
            if circuit.id in self.structure.network.solved:
                limit = self.limit(number)
                highest = self.top if limit is None else np.minimum(limit.value, self.top)
                self.pressures[number] = np.minimum(pressures[number], highest)

    def start_near(self) -> None:
        """Bring every circuit from above near to its balance: that of a turbulent feed against a laminar leak.

        This is the closed form of `atleak.equations.orifice.fed_pressure_turbulent`; the leaks count with what they let
        through per pascal at the highest pressure, those of a circuit also for the one that feeds it.
        """
        structure = self.structure
        flows, _ = self.flows_and_slopes(self.drops()[0])
        leaks = []  # [m³/(s Pa)]
        for number, feeds in enumerate(structure.feeds):
            through = _added([each for each in structure.sums[number] if each[0] not in feeds], flows)
            highest = self.pressures[number]
            leaks.append(np.maximum(through, 0.0) / np.where(highest > 0.0, highest, np.inf))
        fed = [(number, feeds) for number, feeds in enumerate(structure.feeds) if feeds]
        for upward in (True, False):
            for number, feeds in reversed(fed) if upward else fed:
                coefficient = sum(self.orifices.coefficient[feed - structure.gap_ways] for feed in feeds)
                sources = [structure.ends[feed][0] for feed in feeds]
                source = self.pressures[sources].max(axis=0)
                near = orifice_equations.fed_pressure_turbulent(source, coefficient, leaks[number])
                limit = self.limit(number)
                near = np.minimum(near if limit is None else np.minimum(near, limit.value), self.top)
                if not upward:
                    self.pressures[number] = near
                elif sources[0] < structure.last:
                    leaks[sources[0]] += leaks[number] * near / np.where(source > 0.0, source, np.inf)


class _State:
    """What flows at the present pressures, by the circuits' numbers, and the equations that are to become zero."""

    def __init__(self, columns: _Columns, *, chords: bool = False) -> None:
        self.columns, self.structure = columns, columns.structure
        drops, backwards = columns.drops()
        flows, slopes = columns.flows_and_slopes(drops)
        if chords:
            np.divide(flows, drops, out=slopes, where=drops != 0.0)
        for number, forward in backwards:
            slopes[number] *= forward
        self.flows, self.slopes, count = flows, slopes, self.structure.last
        #: what leaves each circuit, also for those that it feeds, less what comes in, also through its feeds
        self.surplus = [_Flow(_added(terms, flows), {}) for terms in self.structure.sums]
        for (at, other), terms in self.structure.pairs.items():
            self.surplus[at].slopes[other] = _added(terms, slopes)
        self.residuals: list[_Flow] = self.surplus[:count]
        self.capped: dict[int, Any] = {}  # where kept circuits take no more than is drawn
        self.errors = np.zeros((count, columns.size))  # of flow [m³/s]
        self.largest: Any = np.abs(flows[: self.structure.free]).max(axis=0, initial=0.0)
        for number in reversed(self.structure.kept):  # those that are fed come before those that feed them
            circuit = self.structure.circuits[number]
            if circuit.id in self.structure.network.solved:
                self._throttled(number)
            else:
                self._supplied(number)
        for number in set(range(count)).difference(self.structure.kept):
            self.residuals[number] = self.surplus[number]
            self.errors[number] = self.surplus[number].value

    def _supplied(self, number: int) -> None:
        """Balance a circuit at its set pressure, which the line or a feed without any resistance keeps up."""
        columns, need = self.columns, self.surplus[number]
        limit, self.residuals[number], self.capped[number] = columns.limit(number), _NOTHING, np.True_
        if limit is not None:
            self.residuals[number] = _Flow(columns.pressures[number], {number: 1.0}) - limit
            off = np.abs(self.residuals[number].value) > _SAME * columns.top
            self.errors[number] = np.where(off, np.inf, 0.0)
        self.largest = np.maximum(self.largest, need.value)

    def _throttled(self, number: int) -> None:
        """Balance a circuit whose regulator throttles its feeds where they could hold more than it is set to."""
        columns, surplus, feeds = self.columns, self.surplus[number], self.structure.feeds[number]
        limit = columns.limit(number)
        assert limit is not None
        over = _Flow(columns.pressures[number], {number: 1.0}) - limit
        too_high = over.value * surplus.slopes[number]
        self.capped[number] = capped = too_high >= surplus.value
        self.residuals[number] = over.where(capped, surplus)
        self.errors[number] = np.maximum(too_high, surplus.value)
        taken, _ = self._regulated(number)
        self.largest = np.maximum(self.largest, np.abs(taken.value))
        sources = [(self.structure.ends[feed][0], self._through(feed)) for feed in feeds]
        if capped.any() and any(source < len(self.surplus) for source, _ in sources):
            back = self._back(number)
            part = (taken - back).over(self._supply(number) - back).where(capped, _Flow(1.0, {}))
            for source, flow in sources:
                if source < len(self.surplus):  # from the circuits before it comes what is drawn
                    passed = flow.product(part).where(flow.value > 0.0, flow)
                    self.surplus[source] = self.surplus[source] + (passed - flow)

    def _supply(self, number: int) -> _Flow:
        """Return what a circuit's feeds let in where nothing throttles them."""
        return sum(map(self._through, self.structure.feeds[number]), _NOTHING)

    def _back(self, number: int) -> _Flow:
        """Return the part of it that is negative: what they let back."""
        flows = map(self._through, self.structure.feeds[number])
        return sum((flow.where(flow.value < 0.0, _NOTHING) for flow in flows), _NOTHING)

    def _regulated(self, number: int) -> tuple[_Flow, _Flow]:
        """Return what a kept circuit takes, and what it relieves to the sump.

        Where its feeds are throttled it takes what is drawn; what comes in beside them, and is not drawn, is relieved.
        """
        supply, capped = self._supply(number), self.capped[number]
        if not capped.any():
            return supply, _NOTHING
        back = self._back(number)
        drawn = self.surplus[number] + supply - back
        taken = drawn.where(np.logical_not(drawn.value <= 0.0), _NOTHING)
        relieved = (_NOTHING - drawn).where(np.logical_not(drawn.value >= 0.0), _NOTHING)
        return (taken + back).where(capped, supply), relieved.where(capped, _NOTHING)

    def _through(self, feed: int) -> _Flow:
        """Return what a feed lets through where nothing throttles it."""
        high, low = self.structure.ends[feed]
        slope = self.slopes[feed]
        slopes = {low: -slope, high: slope} if high < self.structure.last else {low: -slope}
        return _Flow(self.flows[feed], slopes)

    def at_circuits(self, changes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what each circuit takes and what each relieves [m³/s], after small changes of their pressures [Pa]."""
        count = self.structure.last
        taken = np.zeros((count, self.columns.size))
        relieved = np.zeros((len(self.surplus), self.columns.size))
        for number in range(len(self.surplus)):
            if number in self.capped:
                flows = self._regulated(number)
            elif number < count:
                flows = self._supply(number), _NOTHING
            else:  # vented
                flows = _NOTHING, _NOTHING - self.surplus[number]
            for row, flow in zip((taken[number : number + 1], relieved[number : number + 1]), flows, strict=True):
                row += flow.value
                for at, slope in flow.slopes.items():
                    row += slope * changes[at]
        return taken, relieved

    @property
    def balanced(self) -> np.ndarray:
        """Return in which columns every circuit balances."""
        finest = np.zeros_like(self.errors)  # what the last digit of a pressure lets through [m³/s]
        for number, circuit in enumerate(self.structure.circuits):
            if circuit.id in self.structure.network.solved:
                np.multiply(self.surplus[number].slopes[number], self.columns.pressures[number], out=finest[number])
        finest *= _LAST_DIGIT
        finest += BALANCED * self.largest
        # where anything is not a number nothing is looked for
        return np.logical_not(np.any(np.abs(self.errors) > finest, axis=0))


def _solved(columns: _Columns, near: np.ndarray | None) -> tuple[Any, Any, Any]:
    """Find the pressures of some columns, starting from those given for their circuits, or near to their balance.

    Return which of them balance, and what their circuits take and relieve [m³/s]. Where the steps come to no end,
    others that start from above do.
    """
    count = columns.structure.last
    if not columns.structure.network.solved:
        state = _State(columns)
        return np.isfinite(columns.pressures).all(axis=0), *state.at_circuits(np.zeros((count, 1)))
    if near is None:
        columns.start_near()
    else:
        columns.start_from(near)
    still = np.zeros((count, columns.size))
    balanced, taken, relieved = _newton(columns, _STEPS, still, still + np.inf)
    lost = np.isfinite(columns.top) & ~balanced
    if lost.any():
        rest, again = columns.part(lost), still[:, lost]
        rest.start_from_above()
        balanced[lost], taken[:, lost], relieved[:, lost] = _newton(rest, _STEPS, again, again + np.inf)
        columns.pressures[:, lost] = rest.pressures
    return balanced, taken, relieved


def _newton(columns: _Columns, steps: int, last: np.ndarray, reach: np.ndarray) -> tuple[Any, Any, Any]:
    """Take Newton's steps from the present pressures, after the given last ones; return what `_solved` does.

    Columns that balance take one more step, as exact as numbers can be, which their flows follow by their slopes. They
    are left alone once they are the most. A pressure that turns back after the first steps may go half as far as it
    came, so that no steps go round in circles.
    """
    circuits = slice(columns.structure.last)
    for left in reversed(range(steps)):
        state = _State(columns, chords=left < _STEPS - _FREE and left % 4 == 0)
        balanced = state.balanced
        changes = np.array(np.broadcast_arrays(*_eliminated(state.residuals), columns.top))[:-1]
        if left < _STEPS - _FREE:
            turns = changes * last < 0.0
            reach = np.where(turns, 0.5 * np.minimum(reach, np.abs(last)), 1.25 * reach)
            changes = np.clip(changes, -reach, reach)
        before = columns.pressures[circuits].copy()
        columns.pressures[circuits] = np.clip(before - changes, 0.0, columns.top)
        last = before - columns.pressures[circuits]
        most = 2 * np.count_nonzero(balanced) > columns.size
        if most or not left:
            break
    fed, relieved = state.at_circuits(-last)
    converged = balanced & np.isfinite(columns.pressures).all(axis=0)
    if left and not balanced.all():
        others = ~balanced
        rest = columns.part(others)
        converged[others], fed[:, others], relieved[:, others] = _newton(rest, left, last[:, others], reach[:, others])
        columns.pressures[:, others] = rest.pressures
    return converged, fed, relieved


def _eliminated(equations: Sequence[_Flow]) -> list[Any]:
    """Solve the linear equations of one step: elimination without pivots, those that are fed first: hardly any fill-in.

    The matrix is that of an M-function, for which no pivots are needed.
    """
    rows, right = [dict(each.slopes) for each in equations], [each.value for each in equations]
    for number in reversed(range(len(rows))):
        row = rows[number]
        for above in range(number):
            factor = rows[above].pop(number, None)
            if factor is None:
                continue
            factor = factor / row[number]
            for at, value in row.items():
                if at < number:
                    rows[above][at] = rows[above].get(at, 0.0) - factor * value
            right[above] = right[above] - factor * right[number]
    for number, row in enumerate(rows):
        known = sum((value * right[at] for at, value in row.items() if at < number), 0.0)
        right[number] = (right[number] - known) / row[number]
    return right
