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
_BLOCK = 131_072  # numbers of one kind worked on at a time: they stay in the processor's cache
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
    network
        the circuits with their branches.
    sections
        pressures of the sections [Pa], numbers or arrays.
    after
        a balance of the same network at other pressures of the sections: where none of these has changed it is taken
        over, and elsewhere the circuits start from its pressures.
    """
    whole = _Columns.of(network, sections)
    structure, count = whole.structure, len(network.applied)
    names = [*(circuit.id for circuit in network.applied), *structure.vented]
    pressures = np.empty((count, whole.size))
    feeds = np.empty((count, whole.size))
    relief = np.empty((count + len(structure.vented), whole.size))
    converged = np.empty(whole.size, bool)
    block = max(_BLOCK // max(len(structure.branches), 1), 1)
    parts: list[Any] = [slice(start, start + block) for start in range(0, whole.size, block)]
    if after is not None:
        for number, name in enumerate(names):
            relief[number] = whole.flat(after.relief[name])
            if number < count:
                pressures[number], feeds[number] = whole.flat(after.pressures[name]), whole.flat(after.feeds[name])
        converged[:] = whole.flat(after.converged)
        changed = whole.changed_from(after)
        if not changed.all():
            moved = np.flatnonzero(changed)
            parts = [moved[start : start + block] for start in range(0, len(moved), block)]
    for part in parts:
        columns = whole.part(part) if len(parts) > 1 or after is not None else whole
        if network.solved:
            if after is None:
                columns.start_near()
            else:
                columns.start_from(pressures[:, part])
            still = np.zeros((structure.last, columns.size))
            balanced = _newton(columns, _STEPS, still, still + np.inf)
        else:
            balanced = np.ones(columns.size, bool)
        converged[part] = balanced & np.isfinite(columns.pressures).all(axis=0)
        state = _State(columns)
        pressures[:, part] = columns.pressures[:count]
        for number in range(count):
            feeds[number, part], relief[number, part] = state.fed[number], state.relieved[number]
        for number in range(count, len(relief)):
            relief[number, part] = -state.needs[number].value

    def shaped(values: np.ndarray) -> Any:
        return values.reshape(whole.shape) if whole.shape else values.item()

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
        if np.all(condition):
            return self
        if not np.any(condition):
            return other
        slopes = {
            at: np.where(condition, self.slopes.get(at, 0.0), other.slopes.get(at, 0.0))
            for at in {**self.slopes, **other.slopes}
        }
        return _Flow(np.where(condition, self.value, other.value), slopes)


_NOTHING = _Flow(0.0, {})


class _Structure:
    """Which pressures and circuits the branches of a network join: all that no condition changes."""

    def __init__(self, network: Circuits, sections: Iterable[str]) -> None:
        self.network, self.point, self.circuits = network, network.point, network.applied
        self.vented = tuple(sorted(network.vented))
        names = [*(circuit.id for circuit in self.circuits), *self.vented]
        #: the row of each pressure: the circuits', then the vented ones', the sections' and the drain's
        self.rows: dict[str | None, int] = {name: row for row, name in enumerate([*names, *sections])}
        self.rows[None] = len(self.rows)
        touched = set(names)
        branches = [
            each for each in network.branches if {each.high.section, each.low.section} & touched or each.into in touched
        ]
        gaps = [each for each in branches if isinstance(each.restriction, GapBranch)]
        holes = [each for each in branches if not isinstance(each.restriction, GapBranch)]
        self.branches = [*gaps, *holes, *network.feeds]
        self.gaps, self.others = len(gaps), len(branches)  # how many stand first: gaps, and all but feeds
        self.ends = [(self.rows[each.high.section], self.rows[each.low.section]) for each in self.branches]
        self.high, self.low = np.array(self.ends, int).reshape(-1, 2).T
        self.feeds: list[list[int]] = [[] for _ in self.circuits]
        for number, feed in enumerate(network.feeds, start=self.others):
            self.feeds[self.rows[feed.into]].append(number)
        self.last = len(self.circuits)
        #: what a circuit needs, and how that changes with every pressure, as sums over the branches but for feeds
        self.sums: list[_Sum] = [[] for _ in names]
        self.pairs: dict[tuple[int, int], _Sum] = {}
        for number, each in enumerate(self.branches[: self.others]):
            for name, sign in ((each.high.section, 1.0), (each.into, -1.0)):
                if name is not None and self.rows[name] < len(names):
                    self._add(self.rows[name], number, sign)

    def _add(self, circuit: int, number: int, sign: float) -> None:
        """Count a branch among those that a circuit feeds, or is fed by."""
        self.sums[circuit].append((number, sign))
        branch = self.branches[number]
        for end, way in ((branch.high, 1.0), (branch.low, -1.0)):
            other = self.rows[end.section]
            if other < self.last:
                self.pairs.setdefault((circuit, other), []).append((number, sign * way * end.coefficient))

    @cached_property
    def shares(self) -> list[tuple[int, float, float, float]]:
        """Return the branches of which an end is a share of a pressure, or the lower one always the same pressure."""
        whole = ((1.0, 0.0), (0.0, 0.0))
        return [
            (number, each.high.coefficient, each.low.coefficient, each.low.constant)
            for number, each in enumerate(self.branches)
            if each.high.coefficient != 1.0 or (each.low.coefficient, each.low.constant) not in whole
        ]

    @cached_property
    def one_way(self) -> list[int]:
        """Return the branches that let nothing back although their lower pressure may be the higher one."""
        return [
            number
            for number, each in enumerate(self.branches[: self.others])
            if not leaks_both_ways(each, self.network.solved) and (each.low.section or each.low.constant)
        ]


_Sum = list[tuple[int, float]]  # the numbers of branches, each with its factor


def _added(terms: _Sum, values: np.ndarray) -> Any:
    """Return the sum of some rows, each times its factor; of none, zero."""
    total: Any = 0.0
    for number, factor in terms:
        if factor == 1.0:
            total = total + values[number]
        else:
            total = total - values[number] if factor == -1.0 else total + factor * values[number]
    return total


@dataclass
class _Columns:
    """Every number of a network, with a column for each condition."""

    structure: _Structure
    shape: tuple[int, ...]
    size: int
    pressures: np.ndarray  # [Pa], shape (pressures, columns): changed in place until everything balances
    gaps: GapBranch  # stacked, shapes (gaps, 1 or columns)
    orifices: Orifice  # likewise, the feeds last

    @classmethod
    def of(cls, network: Circuits, sections: Mapping[str, Any]) -> _Columns:
        """Stack a network's numbers, with every circuit at its highest pressure; no section counts as below zero."""
        structure = _Structure(network, sections)
        restrictions: list[Any] = [each.restriction for each in structure.branches]
        gaps, orifices = restrictions[: structure.gaps], restrictions[structure.gaps :]
        numbers = [
            [each.conductance for each in gaps],
            [each.bend for each in gaps],
            [each.coefficient for each in orifices],
            [each.transition for each in orifices],
        ]
        shape = np.broadcast_shapes(*(np.shape(each) for each in (*sections.values(), *itertools.chain(*numbers))))
        size = math.prod(shape)
        pressures = np.zeros((len(structure.rows), size))
        for name, pressure in sections.items():
            pressures[structure.rows[name]] = np.maximum(np.broadcast_to(pressure, shape).reshape(-1), 0.0)
        stacked = [_stacked(each, shape) for each in numbers]
        columns = cls(structure, shape, size, pressures, GapBranch(*stacked[:2]), Orifice(*stacked[2:]))
        columns.start_from_above()
        return columns

    def part(self, chosen: Any) -> _Columns:
        """Return some of the columns: a slice, or those that are true."""

        def of(values: np.ndarray) -> np.ndarray:
            return values if values.shape[1] == 1 else values[:, chosen]

        gaps, orifices, pressures = self.gaps, self.orifices, self.pressures[:, chosen].copy()
        return _Columns(
            self.structure,
            pressures.shape[1:],
            pressures.shape[1],
            pressures,
            GapBranch(of(gaps.conductance), of(gaps.bend)),
            Orifice(of(orifices.coefficient), of(orifices.transition)),
        )

    def flat(self, value: Any) -> np.ndarray:
        """Return a number for each column from a number or an array of the network's shape."""
        return np.broadcast_to(value, self.shape).reshape(-1)

    def changed_from(self, other: Balance) -> np.ndarray:
        """Return in which columns any section has another pressure than in a balance."""
        rows, first = self.structure.rows, self.structure.last + len(self.structure.vented)
        changed = np.zeros(self.size, bool)
        for name, row in rows.items():
            if name is not None and row >= first:
                changed |= self.pressures[row] != np.maximum(self.flat(other.pressures[name]), 0.0)
        return changed

    def pressure(self, number: int) -> np.ndarray:
        """Return the pressure of a circuit [Pa]."""
        return self.pressures[number]

    def drops(self, count: int) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
        """Return the pressure drops of the first branches [Pa], and where they would let something back but may not."""
        structure = self.structure
        drops = self.pressures[structure.high[:count]]
        drops -= self.pressures[structure.low[:count]]
        for number, high, low, constant in structure.shares:
            upper, lower = structure.ends[number]
            drops[number] = self.pressures[upper] * high - self.pressures[lower] * low - constant
        backwards = []
        for number in structure.one_way:
            if not drops[number].min(initial=0.0) >= 0.0:
                backwards.append((number, drops[number] >= 0.0))
                np.maximum(drops[number], 0.0, out=drops[number])
        return drops, backwards

    def flows(self, drops: np.ndarray) -> np.ndarray:
        """Return what the first branches let through [m³/s], as many as have a drop."""
        gaps, orifices, last = self.structure.gaps, self.orifices, len(drops) - self.structure.gaps
        flows = np.empty_like(drops)
        flows[:gaps] = self.gaps.flow(drops[:gaps])
        flows[gaps:] = Orifice(orifices.coefficient[:last], orifices.transition[:last]).flow(drops[gaps:])
        return flows

    def flows_and_slopes(self, drops: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what every branch lets through [m³/s], and how steeply that rises [m³/(s Pa)]."""
        gaps, flows, slopes = self.structure.gaps, np.empty_like(drops), np.empty_like(drops)
        flows[:gaps], slopes[:gaps] = self.gaps.flow_and_slope(drops[:gaps])
        flows[gaps:], slopes[gaps:] = self.orifices.flow(drops[gaps:]), self.orifices.slope(drops[gaps:])
        return flows, slopes

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
        """Give every circuit that is solved the pressure that it had [Pa], shape (circuits, columns)."""
        for number, circuit in enumerate(self.structure.circuits):
            if circuit.id in self.structure.network.solved:
                self.pressures[number] = np.minimum(pressures[number], self.top)

    def start_near(self) -> None:
        """Bring every circuit from above near to its balance: that of a turbulent feed against a laminar leak.

        This is the closed form of `atleak.equations.orifice.fed_pressure_turbulent`; the leaks count with what they let
        through per pascal at the highest pressure.
        """
        structure = self.structure
        drops, _ = self.drops(structure.others)
        flows = self.flows(drops)
        for number, feeds in enumerate(structure.feeds):
            if not feeds or not structure.network.solves:
                continue
            coefficient = sum(self.orifices.coefficient[feed - structure.gaps] for feed in feeds)
            source = self.pressures[[structure.ends[feed][0] for feed in feeds]].max(axis=0)
            before = self.pressures[number]
            leak = np.maximum(_added(structure.sums[number], flows), 0.0) / np.where(before > 0.0, before, np.inf)
            near = orifice_equations.fed_pressure_turbulent(source, coefficient, leak)
            limit = self.limit(number)
            self.pressures[number] = np.minimum(near if limit is None else np.minimum(near, limit.value), self.top)


def _stacked(numbers: list[Any], shape: tuple[int, ...]) -> np.ndarray:
    """Return numbers and arrays as rows of one array, with one column where no number is an array."""
    if all(np.ndim(number) == 0 for number in numbers):
        return np.array(numbers, float).reshape(-1, 1)
    return np.array([np.broadcast_to(number, shape).reshape(-1) for number in numbers])


class _State:
    """What flows at the present pressures, by the circuits' numbers, and the equations that are to become zero."""

    def __init__(self, columns: _Columns, *, chords: bool = False) -> None:
        structure = columns.structure
        drops, backwards = columns.drops(len(structure.branches))
        flows, slopes = columns.flows_and_slopes(drops)
        if chords:
            np.divide(flows, drops, out=slopes, where=drops != 0.0)
        for number, forward in backwards:
            slopes[number] *= forward
        self.columns, self.flows, self.slopes = columns, flows, slopes
        #: what leaves each circuit, also for those that it feeds, less what comes in but through its feeds
        self.needs = [_Flow(_added(terms, flows), {}) for terms in structure.sums]
        for (at, other), terms in structure.pairs.items():
            self.needs[at].slopes[other] = _added(terms, slopes)
        count = structure.last
        self.residuals: list[_Flow] = [_NOTHING] * count
        self.errors: list[Any] = [0.0] * count  # of flow [m³/s]
        self.finest: list[Any] = [0.0] * count  # what the last digit of the pressure lets through [m³/s]
        self.fed: list[Any] = [0.0] * count
        self.relieved: list[Any] = [0.0] * count
        self.largest: Any = np.abs(flows[: structure.others]).max(axis=0, initial=0.0)
        for number in reversed(range(count)):  # those that are fed come before those that feed them
            if structure.circuits[number].id in structure.network.solved:
                self._fed(number)
            else:
                self._supplied(number)

    def _supplied(self, number: int) -> None:
        """Balance a circuit at its set pressure, which the line or a feed without any resistance keeps up."""
        columns, need = self.columns, self.needs[number].value
        limit = columns.limit(number)
        self.fed[number], self.relieved[number] = np.maximum(need, 0.0), np.maximum(-need, 0.0)
        if limit is not None:
            self.residuals[number] = _Flow(columns.pressure(number), {number: 1.0}) - limit
            off = np.abs(self.residuals[number].value) > _SAME * columns.top
            self.errors[number] = np.where(off, np.inf, 0.0)

    def _fed(self, number: int) -> None:
        """Balance a circuit with its feeds: a regulator throttles them where they could hold more than it is set to."""
        columns, structure = self.columns, self.columns.structure
        feeds = [(structure.ends[feed][0], self._through(feed)) for feed in structure.feeds[number]]
        need, supply = self.needs[number], feeds[0][1]
        for _, flow in feeds[1:]:
            supply = supply + flow
        surplus, capped = need - supply, None
        steepness = surplus.slopes[number]
        self.errors[number], self.residuals[number], self.fed[number] = surplus.value, surplus, supply.value
        self.finest[number] = steepness * columns.pressure(number) * _LAST_DIGIT
        limit = columns.limit(number)
        if limit is not None:
            over = _Flow(columns.pressure(number), {number: 1.0}) - limit
            too_high = over.value * steepness
            capped = too_high >= surplus.value
            self.residuals[number] = over.where(capped, surplus)
            self.errors[number] = np.where(capped, too_high, surplus.value)
            back = sum(np.minimum(flow.value, 0.0) for _, flow in feeds)
            drawn = need.value - back
            self.relieved[number] = np.where(capped, np.maximum(-drawn, 0.0), 0.0)
            self.fed[number] = np.where(capped, np.maximum(drawn, 0.0) + back, supply.value)
        self.largest = np.maximum(self.largest, np.abs(self.fed[number]))
        self._draw(feeds, need, capped)

    def _draw(self, feeds: list[tuple[int, _Flow]], need: _Flow, capped: Any) -> None:
        """Take what a circuit's feeds bring from the circuits before them: where it is capped, what is drawn."""
        sources = [(source, flow) for source, flow in feeds if source < len(self.needs)]
        part = None
        if sources and np.any(capped):
            forward = [flow.where(flow.value > 0.0, _NOTHING) for _, flow in feeds]
            back = [flow.where(flow.value < 0.0, _NOTHING) for _, flow in feeds]
            drawn = need - sum(back, _NOTHING)
            part = drawn.where(drawn.value > 0.0, _NOTHING).over(sum(forward, _NOTHING)).where(capped, _Flow(1.0, {}))
        for source, flow in sources:
            passed = flow if part is None else flow.product(part).where(flow.value > 0.0, flow)
            self.largest = np.maximum(self.largest, np.abs(passed.value))
            self.needs[source] = self.needs[source] + passed

    def _through(self, feed: int) -> _Flow:
        """Return what a feed lets through where nothing throttles it."""
        high, low = self.columns.structure.ends[feed]
        slope = self.slopes[feed]
        slopes = {low: -slope, high: slope} if high < self.columns.structure.last else {low: -slope}
        return _Flow(self.flows[feed], slopes)

    @cached_property
    def balanced(self) -> np.ndarray:
        """Return in which columns every circuit balances."""
        limit = BALANCED * self.largest
        every = np.ones(self.columns.size, bool)
        for error, finest in zip(self.errors, self.finest, strict=True):
            every &= ~(np.abs(error) > limit + finest)  # where anything is not a number nothing is looked for
        return every


def _newton(columns: _Columns, steps: int, last: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Take Newton's steps from the present pressures, after the given last ones; return which columns then balance.

    Columns that balance take one more step, as exact as numbers can be, and are left alone once they are the most. A
    pressure that turns back after the first steps may go half as far as it came, so that no steps go round in circles.
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
        if balanced.all():
            break
        if 2 * np.count_nonzero(balanced) > columns.size:
            others = ~balanced
            rest = columns.part(others)
            balanced[others] = _newton(rest, left, last[:, others], reach[:, others])
            columns.pressures[:, others] = rest.pressures
            break
    return balanced


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
