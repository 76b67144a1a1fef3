"""Join the circuits of a valve body into a network, of which `atleak.engine.balance` finds the pressures.

A valve body in one gear is a network: sections whose pressures are given, circuits whose pressures are looked for, and
branches between them (gaps, leaks, feed orifices), each with a flow that rises with its pressure drop. For a circuit i

    out_i(p) − in_i(p) = feeds_i(p)            where its feeds cannot hold more than its set pressure,
    p_i = set_i, the feeds pass what is drawn   where they can: a regulator throttles them,
    p_i = 0, the feeds are shut                 where the gear vents it.

What flows into a circuit at its set pressure beyond what leaves it is relieved to the sump, as is all that flows into a
vented one. Pressures, conductances and all else may be arrays of one shape: conditions, samples of a log or draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue import controller as catalogue
from atleak.catalogue.circuits import Circuit, Pressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.balance import Balance, balance
from atleak.engine.restrictions import Branch, GapBranch, Orifice, Restriction, leaks_both_ways
from atleak.equations import fluid as fluid_equations
from atleak.equations import orifice as orifice_equations

SHARP = 1e-3  # [Pa] down to which a leak through a hole is turbulent: no pressure drop that matters is smaller
_LARGE = 1_000  # numbers: so many are computed gap by gap as quickly as all gaps at once, in less memory


@dataclass(frozen=True)
class Network:
    """A valve body in one gear: its circuits and every branch between its pressures."""

    controller: Controller  # whose circuits they are
    point: OperatingPoint  # operating point, with the gear
    lands: tuple[Branch[GapBranch], ...]  # the gaps
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
        """Return the others, each behind those that feed it and, if it can be, those that its set pressure follows."""
        left = [each for each in self.controller.circuits if each.id not in self.vented]
        ordered: list[Circuit] = []
        while left:
            waiting = {each.id for each in left}
            free = [each for each in left if not _needs(each) & (waiting - {each.id})]
            fed = (each for each in left if not {feed.source for feed in each.feeds} & waiting)
            for each in free or [next(fed)]:  # no file lets circuits feed one another in a circle
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
        """Return the flow of a gap or leak [m³/s], negative where it leaks backwards.

        Parameters
        ----------
        branch
            one of `branches`.
        pressures
            [Pa] of every section and circuit, as `Balance.pressures` has them.

        Returns
        -------
        float or numpy.ndarray
            [m³/s]; 0 against a drop that leaks nothing back.
        """
        drop = branch.drop(pressures)
        return branch.restriction.flow(drop if leaks_both_ways(branch, self.solved) else np.maximum(drop, 0.0))

    def balance(self, sections: Mapping[str, Any], after: Balance | None = None) -> Balance:
        """Find the pressures that the circuits hold at given pressures of the sections [Pa].

        Parameters
        ----------
        sections
            [Pa] by section, numbers or arrays.
        after
            this network's balance at other pressures, near to which the new one is soon found.

        Returns
        -------
        Balance
            pressures [Pa] and flows [m³/s]; ``converged`` says whether every mass balance was reached.
        """
        return balance(self, sections, after) if self.has_circuits else Balance(dict(sections), {}, {}, True)

    def drawn_from_pump(self, balance: Balance) -> Any:
        """Return what all gaps and leaks that count draw from the pump, and what is relieved [m³/s]."""
        gaps = [branch for branch in self.lands if branch.counts]
        leaks = [self.flow(branch, balance.pressures) for branch in self.leaks if branch.counts]
        return sum([*self._through(gaps, balance.pressures), *leaks]) + sum(balance.relief.values())

    def _through(self, gaps: Sequence[Branch[GapBranch]], pressures: Mapping[str, Any]) -> Iterable[Any]:
        """Return the flow of each gap [m³/s], of all at once where they are alike in shape and not large."""
        drops = [branch.drop(pressures) for branch in gaps]
        drops = [
            drop if leaks_both_ways(branch, self.solved) else np.maximum(drop, 0.0)
            for branch, drop in zip(gaps, drops, strict=True)
        ]
        restrictions = [branch.restriction for branch in gaps]
        columns = ([each.conductance for each in restrictions], [each.bend for each in restrictions], drops)
        unlike = any(len({getattr(value, "shape", ()) for value in column}) != 1 for column in columns)
        if not gaps or unlike or np.size(drops[0]) > _LARGE:
            return [branch.restriction.flow(drop) for branch, drop in zip(gaps, drops, strict=True)]
        stacked = [np.array(column, float) for column in columns]
        deepest = max(column.ndim for column in stacked)
        conductance, bend, drop = (
            column.reshape(len(gaps), *(1,) * (deepest - column.ndim), *column.shape[1:]) for column in stacked
        )
        return list(GapBranch(conductance, bend).flow(drop))

    def beside_lands(self, balance: Balance) -> Any:
        """Return the part of it that no land leaks [m³/s]: rings, check balls and what is relieved."""
        leaks = [self.flow(branch, balance.pressures) for branch in self.leaks if branch.counts]
        return sum(leaks) + sum(balance.relief.values())


def network(
    controller: Controller,
    point: OperatingPoint,
    gaps: Iterable[tuple[catalogue.Gap, GapBranch, bool]],
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
            measured = leak.flow, leak.pressure_drop
            restriction: Restriction
            if leak.viscosity is None:
                restriction = Orifice(orifice_equations.orifice_leak(1.0, *measured, leak.density, density), SHARP)
            else:
                restriction = GapBranch(orifice_equations.laminar_leak(1.0, *measured, leak.viscosity, viscosity))
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
