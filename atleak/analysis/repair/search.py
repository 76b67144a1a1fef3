"""Find the repairs that cost least and keep every limit, by linear programming in whole numbers.

What the programme proposes is computed by the engine. A proposal that leaves a limit unkept is cut off, together with
every other one that lacks the same, and the next is asked for.

What it lacks: in a network of which every flow rises with the pressure before it and falls with that behind it, a leak
to the sump that becomes smaller lowers no pressure (Rheinboldt, J. Math. Anal. Appl. 32, 1970). So such a choice lacks
a smaller leak somewhere, or another leak from one circuit into the next.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations, starmap
from typing import Any

import numpy as np

from atleak.analysis.repair.options import Move, Moves, together
from atleak.analysis.repair.totals import NEARLY, LandChoice, RepairableUnit
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.consequence import JudgedTotal
from atleak.engine.operation import LINE, LandStates, Repaired
from atleak.engine.restrictions import Branch, GapBranch

LandState = tuple[LandKey, int]


@dataclass(frozen=True)
class Target:
    """A limit that a choice of repairs must keep at one condition."""

    judged: JudgedTotal
    limit: float
    at: LandStates

    def kept(self, done: Repaired) -> Any:
        """Tell of every choice that was computed whether it keeps the limit, by more than rounding."""
        value, spare = self.judged.value(done.leakage, done.pressures), NEARLY * abs(self.limit)
        return value > self.limit + spare if self.judged.rule.steps.falling else value < self.limit - spare

    def too_high(self, done: Repaired) -> np.ndarray:
        """Tell of every choice that was computed whether its circuit holds more than when new."""
        rule = self.judged.rule
        if rule.circuit is None:
            return np.zeros_like(done.pressures[LINE], bool)
        return done.pressures[rule.circuit.id] > (rule.new or 0.0)

    @property
    def most_drawn(self) -> float | None:
        """Return what may be drawn from the pump at the required line pressure [m³/s]; None where any may."""
        kind, at = self.judged.rule.kind, self.judged.projection
        if kind is RuleKind.RESERVE:
            return at.pump_supply / self.limit - at.slip - at.consumers if self.limit > 0.0 else np.inf
        return self.limit * at.pump_capacity if kind is RuleKind.TOTAL_SHARE else None


@dataclass(frozen=True)
class Attempt:
    """A choice of repairs as the engine computes it at one condition, and what it lacks to keep a limit there."""

    at: LandStates
    choice: LandChoice
    done: Repaired
    states: Mapping[LandKey, Sequence[int]]  # the numbers of the states in which each land can be

    def lacking(self, target: Target) -> set[LandState]:
        """Return the states of lands of which the choice needs one at least that it has not, to keep a limit."""
        rises = bool(target.too_high(self.done)[0])
        choice = self.choice if rises else self._worst_like(target)
        return {
            (key, state)
            for key, numbers in self.states.items()
            for state in numbers
            if self._helps(key, choice.get(key, 0), state, less=not rises)
        }

    def _worst_like(self, target: Target) -> LandChoice:
        """Return a choice with as many lands repaired as can be while the limit is still not kept.

        Whatever a smaller choice lacks this one lacks too, and it names fewer lands that could help.
        """
        if not self._better:
            return self.choice
        values = target.judged.value(self._alone.leakage, self._alone.pressures)
        least_help_first = np.argsort(values if target.judged.rule.steps.falling else -values, kind="stable")
        grown, keys = [self.choice], list(self._better)
        for number in least_help_first.tolist():
            grown.append({**grown[-1], keys[number]: self._better[keys[number]]})
        done = self.at.repaired(grown)
        return grown[int(np.flatnonzero(~target.kept(done) & ~target.too_high(done))[-1])]

    @cached_property
    def _better(self) -> Mapping[LandKey, int]:
        """Return the tightest state of every land that could leak less; of none that leaks into a circuit."""
        better = {}
        for key, numbers in self.states.items():
            gaps = self.at.gaps_of.get(key, ())
            if any(self._into_circuit(gap) and np.ptp(gap.restriction.conductance) > 0.0 for gap in gaps):
                continue
            leaks = [sum(float(gap.restriction.conductance[number]) for gap in gaps) for number in numbers]
            best = numbers[leaks.index(min(leaks))]
            if self._helps(key, self.choice.get(key, 0), best, less=True):
                better[key] = best
        return better

    @cached_property
    def _alone(self) -> Repaired:
        """Return the unit with each of these lands repaired besides, one at a time."""
        return self.at.repaired([{**self.choice, key: state} for key, state in self._better.items()])

    def _helps(self, key: LandKey, now: int, then: int, *, less: bool) -> bool:
        """Tell whether another state of a land may help: a gap to the sump leaks less, or more, as is needed."""
        for gap in self.at.gaps_of.get(key, ()):
            change = gap.restriction.conductance[then] - gap.restriction.conductance[now]
            if change and (self._into_circuit(gap) or (change < 0.0) == less):
                return True
        return False

    def _into_circuit(self, gap: Branch[GapBranch]) -> bool:
        """Tell whether what leaks through a gap ends in a circuit."""
        return gap.into is not None and any(gap.into == each.id for each in self.at.model.controller.circuits)


ROUNDS = 100  # of proposals at the most; then repairs are named that suffice, and may not be the best
_COUPLED = 0.05  # of a saving, by which it may differ as circuits feed one another: choice of this project
_SLACK = 1e-7  # of a sum, in which the programme may be off: the engine has the last word


@dataclass(frozen=True)
class Best:
    """The repairs that a search ended with."""

    moves: tuple[Move, ...]
    proven: bool  # whether no other choice is better
    rounds: int  # proposals that the engine computed


@dataclass
class Search:
    """A search for the best choice of repairs of a unit.

    Parameters
    ----------
    moves
        the repairs that are offered.
    unit
        with each land in every state that they leave it in.
    targets
        the limits to keep.
    required
        lands that must be repaired.
    objectives
        returns what a choice is to have least of, in the order of importance: a whole number for each repair.
    allowed
        the repairs that may be chosen, of those that are offered.
    """

    moves: Moves
    unit: RepairableUnit
    targets: Sequence[Target]
    required: Sequence[LandKey]
    objectives: Callable[[], Sequence[Sequence[int]]]
    allowed: Sequence[Move]
    rounds: int = ROUNDS
    _rows: list[tuple[dict[int, float], float]] = field(default_factory=list)  # Σ factor · variable ≥ least
    _saved: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)  # by condition
    _used: int = 0

    def best(self) -> Best | None:
        """Return the best choice that keeps every limit; None where none does."""
        forced = self._forced()
        if self._repairs_all(forced) and not self._unkept(forced):
            return Best(tuple(forced), proven=True, rounds=1)
        self._state_rows()
        for target, attempt in self._attempts(()):
            self._add_draw(target, attempt, ())
        chosen: list[Move] | None = None
        objectives = self.objectives()
        for objective in objectives:
            found = self._least(objective)
            if found is None:
                break
            chosen = found
            spent = sum(objective[self._place[move.key]] for move in chosen)
            self._rows.append(({place: -float(cost) for place, cost in enumerate(objective)}, -spent - 0.5))
        if chosen is None and self.ended:
            chosen = self._enough(objectives[0])
        return None if chosen is None else Best(tuple(chosen), not self.ended, self._used)

    @property
    def ended(self) -> bool:
        """Tell whether no further proposal may be computed, whatever there is still to learn."""
        return self._used >= self.rounds

    @cached_property
    def _place(self) -> Mapping[Any, int]:
        return {move.key: place for place, move in enumerate(self.moves.all)}

    def _forced(self) -> list[Move]:
        """Return the repairs without which a required land is not repaired at all."""
        single = [self.moves.of_land[key] for key in self.required]
        keys = {choices[0].key for choices in single if len(choices) == 1}
        return [move for move in self.allowed if move.key in keys]

    def _repairs_all(self, chosen: Sequence[Move]) -> bool:
        treated = {key for move in chosen for key in move.treats}
        return treated >= set(self.required) and all(starmap(Move.goes_with, combinations(chosen, 2)))

    def _attempts(self, chosen: Iterable[Move]) -> list[tuple[Target, Attempt]]:
        """Return every limit with a choice as the engine computes it at the condition of the limit."""
        choice = self.moves.choice(chosen)
        attempts = {
            id(at): Attempt(at, choice, done, self._numbers)
            for at, done in zip(self.unit.conditions, self.unit.repaired([choice]), strict=True)
        }
        return [(target, attempts[id(target.at)]) for target in self.targets]

    def _unkept(self, chosen: Iterable[Move]) -> list[tuple[Target, Attempt]]:
        """Return the limits that a choice leaves unkept."""
        return [
            (target, attempt) for target, attempt in self._attempts(chosen) if not np.all(target.kept(attempt.done))
        ]

    # --- the programme

    def _least(self, objective: Sequence[int]) -> list[Move] | None:
        """Return the choice that has least of one thing; None where there is none, or no round is left."""
        while not self.ended:
            chosen = self._proposed(objective)
            if chosen is None:
                return None
            self._used += 1
            unkept = self._unkept(chosen)
            if not unkept:
                return chosen
            for target, attempt in unkept:
                self._add_draw(target, attempt, chosen)
                self._add_needed(attempt.lacking(target))
        return None

    def _proposed(self, objective: Sequence[int]) -> list[Move] | None:
        from scipy.optimize import Bounds, LinearConstraint, milp  # dear to import, and seldom needed
        from scipy.sparse import lil_array

        count = len(self.moves.all) + len(self._overridden)
        table = lil_array((len(self._rows), count))
        for number, (factors, _) in enumerate(self._rows):
            for place, factor in factors.items():
                table[number, place] = factor
        least = np.array([least for _, least in self._rows])
        result = milp(
            np.concatenate([np.asarray(objective, float), np.zeros(len(self._overridden))]),
            integrality=np.ones(count),
            bounds=Bounds(0.0, self._most),
            constraints=LinearConstraint(table.tocsr(), least, np.inf) if self._rows else (),
            options={"mip_rel_gap": 0.0},
        )
        if result.x is None:
            return None
        return [move for place, move in enumerate(self.moves.all) if result.x[place] > 0.5]

    @cached_property
    def _most(self) -> np.ndarray:
        """Return how often each variable can be chosen: not at all where its repair is not allowed."""
        allowed = {move.key for move in self.allowed}
        moves = [float(move.key in allowed) for move in self.moves.all]
        return np.array([*moves, *(1.0 for _ in self._overridden)])

    @cached_property
    def _numbers(self) -> Mapping[LandKey, Sequence[int]]:
        """Return the numbers of the states in which each land can be."""
        return {key: range(1 + len(states)) for key, states in self.unit.states.items()}

    @cached_property
    def _overridden(self) -> Mapping[tuple[LandKey, int], int]:
        """Return the variables of lands that an option changes, mends not, and that can be made as new besides."""
        pairs: dict[tuple[LandKey, int], int] = {}
        as_new = {move.lands[0] for move in self.moves.all if move.option is None}
        for place, move in enumerate(self.moves.all):
            for key in move.lands:
                if key in as_new and move.option is not None and not move.option.mends(key):
                    pairs[key, place] = len(self.moves.all) + len(pairs)
        return pairs

    def _state_rows(self) -> None:
        """Add that every required land is repaired, what goes not together, and that as new goes before an option."""
        place_of = self._place
        for key in self.required:
            self._rows.append(({place_of[move.key]: 1.0 for move in self.moves.of_land[key]}, 1.0))
        for (place, move), (further, other) in combinations(enumerate(self.moves.all), 2):
            if not move.goes_with(other):
                self._rows.append(({place: -1.0, further: -1.0}, -1.0))
        for (key, place), variable in self._overridden.items():
            new = place_of[key]
            self._rows += [
                ({place: 1.0, variable: -1.0}, 0.0),
                ({new: -1.0, variable: -1.0}, -1.0),
                ({variable: 1.0, place: -1.0, new: 1.0}, 0.0),
            ]

    @cached_property
    def _variables(self) -> Mapping[LandKey, Mapping[int, int]]:
        """Return by land and state the variable that says that the land is in it; it is as measured where none does."""
        variables: dict[LandKey, dict[int, int]] = defaultdict(dict)
        for place, move in enumerate(self.moves.all):
            for key in move.lands:
                own = place if move.option is None else self._overridden.get((key, place), place)
                variables[key][self.moves.state_after(move, key)] = own
        return variables

    def _add_needed(self, states: Iterable[LandState]) -> None:
        """Add that one land at least is in one of some states."""
        factors: dict[int, float] = defaultdict(float)
        least = 1.0
        for key, number in states:
            if number:
                factors[self._variables[key][number]] += 1.0
                continue
            least -= 1.0
            for variable in self._variables[key].values():
                factors[variable] -= 1.0
        self._rows.append((factors or {0: 0.0}, least))

    def _add_draw(self, target: Target, attempt: Attempt, chosen: Sequence[Move]) -> None:
        """Add how much more must be saved than a choice saves: by what its repairs save at least, others at most."""
        most = target.most_drawn
        if most is None or not np.isfinite(most) or self._overridden or not self.unit.states:
            return
        drawn = float(attempt.done.leakage[0])
        least, largest = self._savings(target)
        mine = np.array([any(move is each for each in chosen) for move in self.moves.all])
        factors, needed = np.where(mine, least, largest), drawn + float(least[mine].sum()) - most
        scale = float(np.abs(factors).max())
        if scale > 0.0:
            row = {place: factor / scale for place, factor in enumerate(factors.tolist())}
            self._rows.append((row, (needed - _SLACK * max(abs(most), drawn)) / scale))

    def _savings(self, target: Target) -> tuple[np.ndarray, np.ndarray]:
        """Return what each repair saves at a condition, alone and after all others [m³/s]: the less and the more."""
        if id(target.at) not in self._saved:
            best = self.moves.choice(together(self.moves.all))
            choices: list[LandChoice] = [{}]
            for move in self.moves.all:
                mine = self.moves.choice([move])
                choices += [mine, {**best, **mine}, {**best, **dict.fromkeys(mine, 0)}]
            drawn = target.at.repaired(choices).leakage
            alone, last = drawn[0] - drawn[1::3], drawn[3::3] - drawn[2::3]
            both = np.minimum(alone, last), np.maximum(alone, last)
            spare = _COUPLED * np.maximum(abs(alone), abs(last))
            self._saved[id(target.at)] = both[0] - spare, both[1] + spare
        return self._saved[id(target.at)]

    # --- where it takes too long

    def _enough(self, costs: Sequence[int]) -> list[Move] | None:
        """Return repairs that keep every limit, without those that can be left out; None where none are at hand."""
        chosen = together(self.allowed)
        if not self._repairs_all(chosen) or self._unkept(chosen):
            return None
        for move in sorted(chosen, key=lambda move: -costs[self._place[move.key]]):
            fewer = [each for each in chosen if each is not move]
            if self._repairs_all(fewer) and not self._unkept(fewer):
                chosen = fewer
        return chosen
