"""Say which limits a choice of repairs must keep, and what one lacks that does not.

In a network of which every flow rises with the pressure before it and falls with that behind it, a leak to the sump
that becomes smaller lowers no pressure (Rheinboldt, J. Math. Anal. Appl. 32, 1970), so that such a choice lacks a
smaller leak somewhere, or another leak from one circuit into the next.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue.limits import RuleKind
from atleak.engine.line import LINE
from atleak.engine.repaired import LandStates
from atleak.engine.restrictions import Branch, Gap
from atleak.repair.totals import NEARLY, Judged, LandChoice
from atleak.rules import LandKey

LandState = tuple[LandKey, int]


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

    @property
    def most_drawn(self) -> float | None:
        """Return what may be drawn from the pump at the required line pressure [m³/s]; None where any may."""
        kind, at = self.judged.rule.kind, self.judged.projection
        if kind is RuleKind.RESERVE:
            return at.pump_supply / self.limit - at.slip - at.consumers if self.limit > 0.0 else np.inf
        return self.limit * at.pump_capacity if kind is RuleKind.TOTAL_SHARE else None

    def into_circuit(self, gap: Branch[Gap]) -> bool:
        """Tell whether what leaks through a gap ends in a circuit."""
        return gap.into is not None and any(gap.into == each.id for each in self.at.model.controller.circuits)

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
