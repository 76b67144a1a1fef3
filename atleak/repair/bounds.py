"""Say as sums over lands what every choice of repairs must do to keep a limit, and what one that fails to lacks.

Flows through gaps add up where the pressures are given; the pressures themselves do not. So what must hold of every
choice is taken at pressures that those of no choice exceed, or fall below: exact where no circuit feeds another. What
is left is learned from choices that fail: in a network of which every flow rises with the pressure before it and
falls with that behind it, a leak to the sump that becomes smaller lowers no pressure (Rheinboldt, J. Math. Anal. Appl.
32, 1970), so that such a choice lacks a smaller leak somewhere, or another leak from one circuit into the next.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue.limits import RuleKind
from atleak.engine.line import LINE, consumed, sections_held
from atleak.engine.repaired import LandStates
from atleak.engine.restrictions import Branch, Gap
from atleak.repair.totals import NEARLY, Judged, LandChoice
from atleak.rules import LandKey, permissible_low

LandState = tuple[LandKey, int]


@dataclass(frozen=True)
class Sum:
    """A sum over lands in their states that a choice must not exceed."""

    terms: Mapping[LandState, float]
    most: float


@dataclass(frozen=True)
class Target:
    """A limit that a choice of repairs must keep at one condition."""

    judged: Judged
    limit: float
    at: LandStates

    def kept(self, leakage: Any, pressures: Mapping[str, Any]) -> Any:
        """Tell whether the limit is kept, by more than rounding; arrays for several choices."""
        value, spare = self.judged.value(leakage, pressures), NEARLY * abs(self.limit)
        return value > self.limit + spare if self.judged.rule.steps.falling else value < self.limit - spare

    # --- what must hold of every choice

    @cached_property
    def sum(self) -> Sum | None:
        """Return what every choice that keeps the limit must hold to; None where nothing can be said in a sum."""
        kind = self.judged.rule.kind
        if kind is RuleKind.CIRCUIT_LOSS:
            return self._circuit()
        if kind is RuleKind.PERMISSIBLE_PRESSURE:
            return self._line()
        assert self.most_drawn is not None
        return self._draw(self.at.sections, self.most_drawn)

    @property
    def most_drawn(self) -> float | None:
        """Return what may be drawn from the pump at the required line pressure [m³/s]; None where any may."""
        kind, at = self.judged.rule.kind, self.judged.projection
        if kind is RuleKind.RESERVE:
            return at.pump_supply / self.limit - at.slip - at.consumers if self.limit > 0.0 else np.inf
        return self.limit * at.pump_capacity if kind is RuleKind.TOTAL_SHARE else None

    @cached_property
    def adds_up(self) -> bool:
        """Tell whether what a repair saves depends on no other circuit than the one that its land leaks from.

        Then every further repair of a circuit's lands saves at least as much as the one before it: its feed lets
        through ever less per pascal that is lacking.
        """
        network = self.at.networks[0]
        solved = network.solved
        lands_apart = not any(gap.high.section in solved and gap.low.section in solved for gap in self.at.gaps)
        leaks_apart = not any(leak.high.section in solved and leak.low.section in solved for leak in network.leaks)
        feeds_apart = not any(feed.high.section in solved for feed in network.feeds)
        return lands_apart and leaks_apart and feeds_apart and not self._mixed

    @cached_property
    def _mixed(self) -> bool:
        """Tell whether a land leaks into a circuit: its repair raises one pressure and lowers another."""
        return any(self.into_circuit(gap) and np.ptp(gap.restriction.conductance) > 0.0 for gap in self.at.gaps)

    def into_circuit(self, gap: Branch[Gap]) -> bool:
        """Tell whether what leaks through a gap ends in a circuit."""
        return gap.into is not None and any(gap.into == each.id for each in self.at.model.controller.circuits)

    def _extreme(self, sections: Mapping[str, Any], *, leaking: bool) -> Mapping[str, Any]:
        """Return pressures that no choice falls below, or none exceeds, at given pressures of the sections [Pa]."""
        network, circuits = self.at.networks[0], self.at.model.controller.circuits
        if self._mixed and network.solves:
            top = 0.0 if leaking else max(sections.values())
            return {**sections, **dict.fromkeys((each.id for each in circuits), top)}
        pick = np.argmax if leaking else np.argmin
        lands = []
        for gap in self.at.gaps:
            which = pick(gap.restriction.conductance)
            one = Gap(float(gap.restriction.conductance[which]), float(gap.restriction.bend[which]))
            lands.append(gap.with_restriction(one))
        return replace(network, lands=tuple(lands)).balance(sections).pressures

    def _draw(self, sections: Mapping[str, Any], most: float) -> Sum | None:
        """Return that no more than ``most`` is drawn from the pump [m³/s], at the least pressures of the circuits."""
        circuits = {each.id for each in self.at.model.controller.circuits}
        network = self.at.networks[0]
        for branch in (*self.at.gaps, *network.leaks):
            if network.solves and branch.counts and branch.low.section in circuits:
                return None  # it may leak less at higher pressures
        pressures = self._extreme(sections, leaking=True)
        drawn = (branch for branch in (*self.at.gaps, *network.leaks) if branch.counts)
        return self._sum([(branch, network.flow(branch, pressures), 1.0) for branch in drawn], most)

    def _circuit(self) -> Sum | None:
        """Return that a circuit loses no more, at the least pressure that it must hold, than can come in."""
        rule, network = self.judged.rule, self.at.networks[0]
        assert rule.circuit is not None
        name, least = rule.circuit.id, (rule.new or 0.0) - self.limit
        if name not in network.solved or least <= 0.0:
            return None
        pressures = {**self._extreme(self.at.sections, leaking=False), name: least}
        comes_in = sum(
            float(feed.restriction.flow(feed.drop(pressures))) for feed in network.feeds if feed.into == name
        )
        gaps = []
        for branch in (*network.leaks, *self.at.gaps):
            sign = float(branch.high.section == name) - float(branch.into == name)
            if branch.low.section == name and branch.into != name:
                return None  # a drain at a share of this pressure
            if sign:
                gaps.append((branch, network.flow(branch, pressures), sign))
        return self._sum(gaps, comes_in)

    def _line(self) -> Sum | None:
        """Return that the pump covers what is drawn at the least line pressure that must be held."""
        low, at = permissible_low(self.judged.projection), self.at
        if low is None:
            return None
        main, model, point = low * (1.0 - self.limit), at.model, at.point
        supply = model.pump.capacity(point.engine_speed, main, model.dynamic_viscosity(point.temperature))
        most = float(supply) - consumed(at.networks[0], main, point.main_pressure, after_line=False)
        sections = sections_held(model.controller, main, point.converter_pressure)
        return self._draw({name: float(pressure) for name, pressure in sections.items()}, most)

    def _sum(self, flows: Sequence[tuple[Branch[Any], Any, float]], most: float) -> Sum | None:
        """Add up flows with their signs: those of lands by their states, what else leaks is taken off the most."""
        keys = {id(gap): key for gap, key in zip(self.at.gaps, self.at.keys, strict=True)}
        terms: dict[LandState, float] = defaultdict(float)
        for branch, flow, sign in flows:
            key = keys.get(id(branch))
            if key is None:
                most -= sign * float(flow)
                continue
            for state, each in enumerate(flow.tolist()):
                terms[key, state] += sign * each
        return Sum(dict(terms), most) if np.isfinite(most) else None

    # --- what a choice that fails lacks

    def lacking(self, choice: LandChoice, states: Mapping[LandKey, Sequence[int]]) -> set[LandState]:
        """Return the states of lands of which a choice needs one at least that it has not, to keep the limit.

        Parameters
        ----------
        choice
            one that does not keep it.
        states
            the numbers of the states in which each land can be.
        """
        rises = bool(self._too_high(self.at.repaired([choice]).pressures)[0])
        if not rises:
            choice = self._worst_like(choice, states)
        return {
            (key, state)
            for key, numbers in states.items()
            for state in numbers
            if self._helps(key, choice.get(key, 0), state, less=not rises)
        }

    def _too_high(self, pressures: Mapping[str, np.ndarray]) -> np.ndarray:
        """Tell which choices pass the limit by a circuit that holds more than when new."""
        rule = self.judged.rule
        if rule.circuit is None:
            return np.zeros_like(pressures[LINE], bool)
        return pressures[rule.circuit.id] > (rule.new or 0.0)

    def _helps(self, key: LandKey, now: int, then: int, *, less: bool) -> bool:
        """Tell whether another state of a land may help: a gap to the sump leaks less, or more, as is needed."""
        for gap in self._gaps_of.get(key, ()):
            change = gap.restriction.conductance[then] - gap.restriction.conductance[now]
            if change and (self.into_circuit(gap) or (change < 0.0) == less):
                return True
        return False

    @cached_property
    def _gaps_of(self) -> Mapping[LandKey, list[Branch[Gap]]]:
        gaps: dict[LandKey, list[Branch[Gap]]] = defaultdict(list)
        for key, gap in zip(self.at.keys, self.at.gaps, strict=True):
            gaps[key].append(gap)
        return gaps

    def _worst_like(self, choice: LandChoice, states: Mapping[LandKey, Sequence[int]]) -> LandChoice:
        """Return a choice with as many lands repaired as can be while the limit is still not kept.

        Whatever a smaller choice lacks this one lacks too, and it names fewer lands that could help.
        """
        better = {}
        for key, numbers in states.items():
            gaps = self._gaps_of.get(key, ())
            if any(self.into_circuit(gap) and np.ptp(gap.restriction.conductance) > 0.0 for gap in gaps):
                continue
            leaks = [sum(float(gap.restriction.conductance[number]) for gap in gaps) for number in numbers]
            best = numbers[leaks.index(min(leaks))]
            if self._helps(key, choice.get(key, 0), best, less=True):
                better[key] = best
        if not better:
            return choice
        alone = self.at.repaired([{**choice, key: state} for key, state in better.items()])
        values = self.judged.value(alone.leakage, alone.pressures)
        least_help_first = np.argsort(values if self.judged.rule.steps.falling else -values, kind="stable")
        grown, keys = [choice], list(better)
        for number in least_help_first.tolist():
            grown.append({**grown[-1], keys[number]: better[keys[number]]})
        done = self.at.repaired(grown)
        lacks = ~self.kept(done.leakage, done.pressures) & ~self._too_high(done.pressures)
        return grown[int(np.flatnonzero(lacks)[-1])]
