"""Find the pressure that each circuit holds: what its feeds bring in is what its gaps and leaks let out.

A valve body in one gear is a network: sections whose pressures are given, circuits whose pressures are looked for, and
branches between them (gaps, leaks, feed orifices), each with a flow that rises with its pressure drop. For a circuit i

    out_i(p) − in_i(p) = feeds_i(p)            where its feeds cannot hold more than its set pressure,
    p_i = set_i, the feeds pass what is drawn   where they can: a regulator throttles them,
    p_i = 0, the feeds are shut                 where the gear vents it.

What flows into a circuit at its set pressure beyond what leaves it is relieved to the sump, as is all that flows into a
vented one. Every flow out of a circuit rises with its own pressure and falls with its neighbours', so the balances form
an M-function: there is one solution, and steps that start with every circuit at its highest pressure come down to it
(Rheinboldt, J. Math. Anal. Appl. 32, 1970). Which circuits are at their set pressure follows in each step from the
balance there, as in Howard's policy iteration.

Pressures, conductances and all else may be arrays of one shape: conditions, samples of a log or draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from atleak.catalogue import controller as catalogue
from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.catalogue.section_pressures import Pressure
from atleak.equations import fluid as fluid_equations
from atleak.equations import gap as gap_equations
from atleak.equations import orifice as orifice_equations

BALANCED = 1e-9  # mass balance of every circuit, over the largest flow of its network
_EXACT = 1e-13  # at which steps end; what they reach beyond it is rounding
_LAST_DIGITS = 1e-12  # relative: a pressure that equals another but for rounding
_STEPS = 60  # of Newton's, after which circuits that are not balanced are worked out one by one
_SWEEPS, _HALVINGS = 400, 60  # over all circuits, and of the pressures between which one of them lies
_LEAST_DROP = 1.0  # [Pa] at which the slope of a sharp leak is taken for smaller drops, where it has no bound


class Restriction(Protocol):
    """Something that fluid is forced through: its flow rises with the pressure drop and is odd in it."""

    def flow(self, drop: Any) -> Any:
        """Return the flow [m³/s] at a pressure drop [Pa]."""

    def slope(self, drop: Any) -> Any:
        """Return how steeply the flow rises [m³/(s Pa)]."""


@dataclass(frozen=True)
class Gap:
    """An annular gap, or another laminar leak: `restricted_flow`."""

    conductance: Any  # [m³/(s Pa)]
    bend: Any = 0.0  # [1/Pa] of the entry loss

    def flow(self, drop: Any) -> Any:
        return gap_equations.restricted_flow(drop, self.conductance, self.bend)

    def slope(self, drop: Any) -> Any:
        return gap_equations.restricted_slope(drop, self.conductance, self.bend)


@dataclass(frozen=True)
class Orifice:
    """A feed: `orifice_flow`."""

    coefficient: Any  # [m³/(s √Pa)]
    transition: Any  # [Pa]

    def flow(self, drop: Any) -> Any:
        return orifice_equations.orifice_flow(drop, self.coefficient, self.transition)

    def slope(self, drop: Any) -> Any:
        return orifice_equations.orifice_slope(drop, self.coefficient, self.transition)


@dataclass(frozen=True)
class SharpLeak:
    """A leak through a hole: in proportion to the root of the pressure drop, `orifice_leak`."""

    measured: float  # [m³/s]
    at_pressure_drop: float  # [Pa]
    at_density: float  # [kg/m³]
    density: Any

    def flow(self, drop: Any) -> Any:
        return orifice_equations.orifice_leak(drop, self.measured, self.at_pressure_drop, self.at_density, self.density)

    def slope(self, drop: Any) -> Any:
        size = np.maximum(np.abs(drop), _LEAST_DROP)
        return 0.5 * self.flow(size) / size


AnyRestriction = TypeVar("AnyRestriction", bound=Restriction, covariant=True)


@dataclass(frozen=True)
class Branch(Generic[AnyRestriction]):
    """A restriction between two pressures."""

    high: Pressure
    low: Pressure
    restriction: AnyRestriction
    into: str | None  # the section or circuit that the flow ends in; None: the sump
    counts: bool  # as drawn from the pump

    def drop(self, pressures: Mapping[str, Any]) -> Any:
        """Return the pressure drop [Pa], with its sign."""
        return self.high.at(pressures) - self.low.at(pressures)


@dataclass(frozen=True)
class Balance:
    """Every pressure of a network and the flows of its circuits; arrays where anything was one."""

    pressures: Mapping[str, Any]  # [Pa] of every section and circuit
    feeds: Mapping[str, Any]  # [m³/s] what each circuit takes through its feeds
    relief: Mapping[str, Any]  # [m³/s] what each circuit relieves to the sump
    converged: Any  # whether every mass balance was reached


@dataclass(frozen=True)
class Network:
    """A valve body in one gear: its circuits and every branch between its pressures."""

    controller: Controller
    point: OperatingPoint
    lands: tuple[Branch[Gap], ...]  # the gaps
    leaks: tuple[Branch[Restriction], ...]  # rings and check balls
    feeds: tuple[Branch[Orifice], ...]  # each into the circuit that it feeds; only of circuits that are not vented
    solves: bool  # whether pressures follow from the balance; else circuits hold what they are set to, or fed with

    @property
    def branches(self) -> tuple[Branch[Restriction], ...]:
        """Return all but the feeds."""
        return (*self.lands, *self.leaks)

    @cached_property
    def vented(self) -> frozenset[str]:
        """Return the circuits that are not applied in this gear."""
        return frozenset(each.id for each in self.controller.circuits if self.point.gear not in each.gears)

    @cached_property
    def applied(self) -> tuple[Circuit, ...]:
        """Return the other circuits, each behind those that feed it or that its set pressure follows."""
        left = [each for each in self.controller.circuits if each.id not in self.vented]
        ordered: list[Circuit] = []
        while left:
            waiting = {each.id for each in left}
            free = [each for each in left if not _needs(each) & (waiting - {each.id})]
            for each in free or left[:1]:  # circuits that feed one another come in the order of the file
                ordered.append(each)
                left.remove(each)
        return tuple(ordered)

    @cached_property
    def solved(self) -> frozenset[str]:
        """Return the circuits whose pressure follows from a balance."""
        return frozenset(each.id for each in self.applied if each.feeds) if self.solves else frozenset()

    @property
    def has_circuits(self) -> bool:
        """Return whether there is any circuit, vented ones included."""
        return bool(self.controller.circuits)

    def flow(self, branch: Branch[Restriction], pressures: Mapping[str, Any]) -> Any:
        """Return the flow of a gap or leak [m³/s], negative where it leaks backwards."""
        drop = branch.drop(pressures)
        return branch.restriction.flow(drop if leaks_both_ways(branch, self.solved) else np.maximum(drop, 0.0))

    def balance(self, sections: Mapping[str, Any]) -> Balance:
        """Find the pressures that the circuits hold at given pressures of the sections [Pa]."""
        return _Solver(self, sections).balance()

    def drawn_from_pump(self, balance: Balance) -> Any:
        """Return what all gaps and leaks that count draw from the pump, and what is relieved [m³/s]."""
        flows = [self.flow(branch, balance.pressures) for branch in self.branches if branch.counts]
        return sum(flows) + sum(balance.relief.values())

    def beside_lands(self, balance: Balance) -> Any:
        """Return the part of it that no land leaks [m³/s]: rings, check balls and what is relieved."""
        leaks = [self.flow(branch, balance.pressures) for branch in self.leaks if branch.counts]
        return sum(leaks) + sum(balance.relief.values())


class _Ends(Protocol):
    @property
    def high(self) -> Pressure: ...

    @property
    def low(self) -> Pressure: ...


def leaks_both_ways(ends: _Ends, solved: frozenset[str]) -> bool:
    """Return whether a gap leaks backwards too: between two sections of which one at least is a solved circuit.

    A drain leaks nothing back, nor does one that is a share of a pressure.
    """
    return ends.low.is_section and bool({ends.high.section, ends.low.section} & solved)


def network(
    controller: Controller,
    point: OperatingPoint,
    gaps: Iterable[tuple[catalogue.Gap, Gap, bool]],
    kinematic_viscosity: Any,
    density: Any,
    *,
    solves: bool,
) -> Network:
    """Make the network of a controller in the gear of an operating point.

    Parameters
    ----------
    gaps
        those of that gear, each with its restriction and whether it counts as drawn from the pump.
    kinematic_viscosity, density
        of the fluid [m²/s, kg/m³]; numbers or arrays.
    solves
        whether the circuits' pressures follow from their balance.
    """
    viscosity = fluid_equations.dynamic_viscosity(kinematic_viscosity, density)
    leaks = []
    for leak in controller.leaks:
        if point.gear in leak.gears:
            restriction: Restriction = SharpLeak(leak.flow, leak.pressure_drop, leak.density, density)
            if leak.viscosity is not None:
                measured = leak.flow, leak.pressure_drop, leak.viscosity
                restriction = Gap(orifice_equations.laminar_leak(1.0, *measured, viscosity))
            into = None if leak.into_sump else leak.low.section
            leaks.append(Branch(leak.high, leak.low, restriction, into, leak.into_sump))
    feeds = []
    for circuit in controller.circuits:
        for feed in circuit.feeds if point.gear in circuit.gears else ():
            opening = feed.diameter, feed.discharge_coefficient
            orifice = Orifice(
                orifice_equations.turbulent_coefficient(*opening, density),
                orifice_equations.transition_pressure(*opening, kinematic_viscosity, density),
            )
            feeds.append(Branch(Pressure(1.0, feed.source), Pressure(1.0, circuit.id), orifice, circuit.id, False))
    lands = tuple(
        Branch(gap.high, gap.low, restriction, None if gap.into_sump else gap.low.section, counts)
        for gap, restriction, counts in gaps
    )
    return Network(controller, point, lands, tuple(leaks), tuple(feeds), solves)


def _needs(circuit: Circuit) -> set[str]:
    """Return the sections and circuits that feed a circuit or that its set pressure follows."""
    needs = {feed.source for feed in circuit.feeds}
    following = circuit.set_pressure.following if circuit.set_pressure is not None else None
    return needs | {following.section} if following is not None else needs


class _Solver:
    """One balance: the pressures of the circuits are changed in place until everything balances."""

    def __init__(self, network: Network, sections: Mapping[str, Any]) -> None:
        self.network, self.point = network, network.point
        self.circuits = network.applied
        self.number = {circuit.id: number for number, circuit in enumerate(self.circuits)}
        self.pressures: dict[str, Any] = dict(sections)
        self.pressures.update(dict.fromkeys(network.vented, 0.0))
        #: no circuit can hold more: all that comes in comes from the sections
        self.top = np.maximum.reduce(np.broadcast_arrays(*(np.asarray(each, float) for each in sections.values())))
        self.line = sections["p_g"]
        for circuit in self.circuits:  # from above
            self.pressures[circuit.id] = self._highest(circuit)
        touched = {*self.number, *network.vented}
        self.branches = [
            (branch, leaks_both_ways(branch, network.solved))
            for branch in network.branches
            if {branch.high.section, branch.low.section} & touched or branch.into in touched
        ]
        self.feeds = {
            circuit.id: [feed for feed in network.feeds if feed.into == circuit.id] for circuit in self.circuits
        }

    def _set(self, circuit: Circuit) -> Any:
        """Return the highest pressure that a circuit's regulator lets it have [Pa]; infinite without one."""
        limit = np.inf
        if circuit.set_pressure is not None:
            limit = circuit.set_pressure.with_pressures(self.point, self.pressures)
        if not circuit.feeds:  # supplied by the line without any resistance
            limit = np.minimum(limit, self.line)
        return limit

    def _at_limit(self, circuit: Circuit) -> Any:
        """Return whether a circuit is at the pressure that it is set to."""
        return self.pressures[circuit.id] >= self._set(circuit) * (1.0 - _LAST_DIGITS)

    def _highest(self, circuit: Circuit) -> Any:
        """Return the pressure that a circuit has where nothing leaks."""
        sources = [self.pressures.get(feed.source, self.top) for feed in circuit.feeds]
        return np.minimum(self._set(circuit), self.top if self.network.solves or not sources else max_of(sources))

    def balance(self) -> Balance:
        """Step down to the solution and add up what flows."""
        converged: Any = True
        if self.network.solved:
            converged = self._newton()
            if not np.all(converged):
                converged = self._one_by_one(converged)
        state = self._state()
        feeds, relief = {}, {}
        for number, circuit in enumerate(self.circuits):
            need = state.out[number] - state.inward[number]
            drawn = np.maximum(need, 0.0)
            feeds[circuit.id] = np.minimum(drawn, state.feeds[number]) if circuit.id in self.network.solved else drawn
            relief[circuit.id] = np.where(self._at_limit(circuit), np.maximum(-need, 0.0), 0.0)
        for name in self.network.vented:
            relief[name] = state.vented.get(name, 0.0)
        return Balance(self.pressures, feeds, relief, converged)

    # --- all circuits at once

    def _newton(self) -> Any:
        """Take Newton's steps with all circuits at once; return where they balance."""
        converged: Any = False
        for _ in range(_STEPS):
            state = self._state()
            residuals, rows, error = self._equations(state)
            converged = error <= BALANCED
            if np.all(error <= _EXACT):
                break
            steps = _solve(rows, residuals)
            moved = 0.0
            for number, circuit in enumerate(self.circuits):
                before = self.pressures[circuit.id]
                after = np.clip(before - steps[number], 0.0, self.top)
                self.pressures[circuit.id] = after
                moved = np.maximum(moved, np.abs(after - before))
            if np.all((moved <= 1e-15 * self.top) & converged):
                break
        return converged

    def _equations(self, state: _State) -> tuple[list[Any], list[dict[int, Any]], Any]:
        """Return what is left of every circuit's equation, its derivatives, and the error over the largest flow."""
        residuals, rows, error = [], [], 0.0
        for number, circuit in enumerate(self.circuits):
            limit = self._set(circuit)
            over = self.pressures[circuit.id] - limit  # −inf without a regulator
            row = state.rows[number]
            if circuit.id not in self.network.solved:
                residuals.append(over)
                rows.append(self._set_row(circuit, number))
                error = np.maximum(error, np.abs(over) / self.top_or_one)
                continue
            surplus = state.out[number] - state.inward[number] - state.feeds[number]
            capped = over >= surplus / row[number]
            if not np.any(capped):
                residuals.append(surplus)
                rows.append(row)
                error = np.maximum(error, np.abs(surplus) / state.largest)
                continue
            set_row = self._set_row(circuit, number)
            columns = {*row, *set_row}
            residuals.append(np.where(capped, np.where(np.isfinite(over), over, 0.0), surplus))
            rows.append({at: np.where(capped, set_row.get(at, 0.0), row.get(at, 0.0)) for at in columns})
            relative = np.where(capped, np.abs(over) / self.top_or_one, np.abs(surplus) / state.largest)
            error = np.maximum(error, relative)
        return residuals, rows, error

    @cached_property
    def top_or_one(self) -> Any:
        """Return the highest pressure [Pa], one where there is none, to compare others with."""
        return np.where(self.top > 0.0, self.top, 1.0)

    def _set_row(self, circuit: Circuit, number: int) -> dict[int, Any]:
        """Return the derivatives of p_i − set_i."""
        row: dict[int, Any] = {number: 1.0}
        following = circuit.set_pressure.following if circuit.set_pressure is not None else None
        if following is not None and following.section in self.number:
            at = self.number[following.section]
            row[at] = row.get(at, 0.0) - following.ratio
        return row

    def _state(self) -> _State:
        """Add up every flow and slope at the present pressures."""
        count = len(self.circuits)
        state = _State(count)
        for branch, both_ways in self.branches:
            drop = branch.drop(self.pressures)
            forward = True if both_ways else drop > 0.0
            drop = drop if both_ways else np.maximum(drop, 0.0)
            flow, slope = branch.restriction.flow(drop), branch.restriction.slope(drop) * forward
            state.add(flow)
            ends = self._ends(branch, slope)
            high = self.number.get(branch.high.section or "")
            if high is not None:
                state.leaves(high, flow, ends, 1.0)
            into = self.number.get(branch.into or "")
            if into is not None:
                state.enters(into, flow, ends)
            elif branch.into in self.network.vented:
                state.vented[branch.into] = state.vented.get(branch.into, 0.0) + flow
        for number in reversed(range(count)):  # those that are fed come before those that feed them
            circuit = self.circuits[number]
            flows = [(feed, feed.restriction, feed.drop(self.pressures)) for feed in self.feeds[circuit.id]]
            slopes = [restriction.slope(drop) for _, restriction, drop in flows]
            given = [restriction.flow(drop) for _, restriction, drop in flows]
            for (feed, _, _), flow, slope in zip(flows, given, slopes, strict=True):
                state.add(flow)
                state.feed(number, flow, self._ends(feed, slope))
            if not any(feed.high.section in self.number for feed, _, _ in flows):
                continue
            part = self._throttled(circuit, number, state)
            for (feed, _, _), flow, slope in zip(flows, given, slopes, strict=True):
                source = self.number.get(feed.high.section or "")
                if source is not None:
                    ends = {at: value * (part == 1.0) for at, value in self._ends(feed, slope).items()}
                    state.leaves(source, flow * part, ends, 1.0)
        return state

    def _throttled(self, circuit: Circuit, number: int, state: _State) -> Any:
        """Return which part of what its feeds could bring a circuit at its set pressure takes; 1 for one below it."""
        capacity = state.feeds[number]
        need = state.out[number] - state.inward[number]
        at_limit = self._at_limit(circuit) & (capacity > 0.0)
        return np.where(at_limit, np.clip(need / np.where(capacity > 0.0, capacity, 1.0), 0.0, 1.0), 1.0)

    def _ends(self, branch: Branch[Restriction], slope: Any) -> dict[int, Any]:
        """Return how the flow of a branch changes with the pressure of each circuit."""
        ends: dict[int, Any] = {}
        for end, sign in ((branch.high, 1.0), (branch.low, -1.0)):
            at = self.number.get(end.section or "")
            if at is not None:
                ends[at] = ends.get(at, 0.0) + sign * end.coefficient * slope
        return ends

    # --- one circuit after the other

    def _one_by_one(self, converged: Any) -> Any:
        """Bring down one circuit after the other where Newton's steps failed: slow, and sure from above."""
        failed = ~np.asarray(converged)
        for circuit in self.circuits:
            self.pressures[circuit.id] = np.where(failed, self._highest(circuit), self.pressures[circuit.id])
        error: Any = np.inf
        for _ in range(_SWEEPS):
            for number, circuit in enumerate(self.circuits):
                highest = np.minimum(self._set(circuit), self.top)
                if circuit.id in self.network.solved:
                    highest = self._root(circuit, number, highest)
                self.pressures[circuit.id] = np.where(failed, highest, self.pressures[circuit.id])
            _, _, error = self._equations(self._state())
            if np.all(error <= BALANCED):
                break
        return error <= BALANCED

    def _root(self, circuit: Circuit, number: int, highest: Any) -> Any:
        """Return the pressure at which a circuit balances among its neighbours, or the highest it may have."""
        kept = self.pressures[circuit.id]

        def surplus(pressure: Any) -> Any:
            self.pressures[circuit.id] = pressure
            state = self._state()
            return state.out[number] - state.inward[number] - state.feeds[number]

        high = np.asarray(highest, float)
        low, holds = np.zeros_like(high), surplus(high) <= 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            over = surplus(middle) > 0.0
            high, low = np.where(over, middle, high), np.where(over, low, middle)
        self.pressures[circuit.id] = kept
        return np.where(holds, highest, low)


class _State:
    """What flows at the present pressures, by number of the circuit, with the slopes."""

    def __init__(self, count: int) -> None:
        self.out: list[Any] = [0.0] * count  # through gaps and leaks, and into the feeds of others
        self.inward: list[Any] = [0.0] * count  # through gaps
        self.feeds: list[Any] = [0.0] * count  # what they could bring
        self.rows: list[dict[int, Any]] = [{} for _ in range(count)]
        self.vented: dict[str, Any] = {}
        self.largest: Any = 1e-30

    def add(self, flow: Any) -> None:
        self.largest = np.maximum(self.largest, np.abs(flow))

    def leaves(self, number: int, flow: Any, ends: Mapping[int, Any], sign: float) -> None:
        self.out[number] = self.out[number] + flow
        self._change(number, ends, sign)

    def enters(self, number: int, flow: Any, ends: Mapping[int, Any]) -> None:
        self.inward[number] = self.inward[number] + flow
        self._change(number, ends, -1.0)

    def feed(self, number: int, flow: Any, ends: Mapping[int, Any]) -> None:
        self.feeds[number] = self.feeds[number] + flow
        self._change(number, ends, -1.0)

    def _change(self, number: int, ends: Mapping[int, Any], sign: float) -> None:
        row = self.rows[number]
        for at, slope in ends.items():
            row[at] = row.get(at, 0.0) + sign * slope


def _solve(rows: list[dict[int, Any]], residuals: list[Any]) -> list[Any]:
    """Solve the linear equations of one step, whose numbers may be arrays: elimination without pivots, as few fill-ins.

    The matrix is that of an M-function, for which no pivots are needed.
    """
    rows, right = [dict(row) for row in rows], list(residuals)
    for number, row in enumerate(rows):
        for below in range(number + 1, len(rows)):
            factor = rows[below].pop(number, None)
            if factor is None:
                continue
            factor = factor / row[number]
            for at, value in row.items():
                if at > number:
                    rows[below][at] = rows[below].get(at, 0.0) - factor * value
            right[below] = right[below] - factor * right[number]
    for number in reversed(range(len(rows))):
        known = sum(value * right[at] for at, value in rows[number].items() if at > number)
        right[number] = (right[number] - known) / rows[number][number]
    return right


def max_of(values: Sequence[Any]) -> Any:
    """Return the largest of several numbers or arrays, element by element."""
    return np.maximum.reduce(np.broadcast_arrays(*(np.asarray(value, float) for value in values)))
