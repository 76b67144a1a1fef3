"""Choose the repairs of a unit: the cheapest, or the fewest, that reach a goal; or offer them all, one by one."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property, partial

import numpy as np

from atleak.analysis.repair.options import Move, MoveKey, Moves, Options, Prices, decimals, together
from atleak.analysis.repair.search import ROUNDS, Search, Target
from atleak.analysis.repair.totals import LandChoice, RepairableUnit, RepairedAt, Total
from atleak.catalogue.repairs import Goal, LandKey
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule

_WORTH_SAYING = 1e-3  # of a limit, by which something must be worse to be named: choice of this project


class Basis(StrEnum):
    """What a choice has least of first."""

    CHEAPEST = "cheapest"  # money, then repairs
    FEWEST = "fewest"  # repairs, then money as far as it is known


@dataclass(frozen=True)
class Gain:
    """What a choice would lack without one of its repairs, where it would lack most."""

    within: Rule  # with all of the choice
    without: Rule  # the same rule without that repair


@dataclass(frozen=True)
class Choice:
    """The repairs that are chosen of a unit, in no order, and what the engine says of the unit so repaired."""

    goal: Goal  # what they are to reach
    basis: Basis  # what they have least of first
    chosen: tuple[Move, ...]  # every repair
    moves: Moves = field(repr=False)  # that were offered
    unit: RepairableUnit = field(repr=False)  # the unit with its lands in every state
    proven: bool  # no other choice of what was offered is better
    rounds: int  # proposals that the engine computed

    @cached_property
    def ends(self) -> tuple[Total, ...]:
        """Return the totals at every condition, the stated one first."""
        return self.totals_of([self.chosen])[0]

    @cached_property
    def states(self) -> LandChoice:
        """Return the state of every land that a chosen repair changes."""
        return self.moves.choice(self.chosen)

    @property
    def lands(self) -> list[tuple[Move, list[LandKey]]]:
        """Return the repairs with their lands, each of which stands with one: as new goes before an option."""
        as_new = {key for move in self.chosen if move.option is None for key in move.lands}
        return [(move, [key for key in move.lands if move.option is None or key not in as_new]) for move in self.chosen]

    @property
    def savings(self) -> dict[LandKey, float]:
        """Return what the repair of each land saves alone, at the condition where it saves most."""
        now, *alone = self.unit.totals([{}, *({key: state} for key, state in self.states.items())])
        return {
            key: max(RepairedAt(*pair).saving for pair in zip(now, after, strict=True))
            for key, after in zip(self.states, alone, strict=True)
        }

    @property
    def reached(self) -> bool:
        """Tell whether totals and pressures are green at every condition."""
        return not any(total.past for total in self.ends)

    def totals_of(self, choices: Iterable[Iterable[Move]]) -> list[tuple[Total, ...]]:
        """Return the totals with each of several sets of repairs, computed at once."""
        return self.unit.totals([self.moves.choice(chosen) for chosen in choices])

    @cached_property
    def gains(self) -> dict[MoveKey, Gain | None]:
        """Return for every repair of the choice what it would lack without it; None where it lacks nothing."""
        without = [[each for each in self.chosen if each is not move] for move in self.chosen]
        return {
            move.key: gain_of(self.ends, totals)
            for move, totals in zip(self.chosen, self.totals_of(without), strict=True)
        }


def gain_of(within: Iterable[Total], without: Iterable[Total]) -> Gain | None:
    """Return the rule that comes nearer to its first limit, or farther past it, than any other without something.

    None where none does by more than can be seen.
    """
    gains: list[tuple[float, Gain]] = []
    for one, other in zip(within, without, strict=True):
        for better, worse in zip((one.rule, *one.pressure_rules), (other.rule, *other.pressure_rules), strict=True):
            lost = _used_up(worse) - _used_up(better)
            if math.isfinite(lost) and lost > _WORTH_SAYING:
                gains.append((lost, Gain(better, worse)))
    return max(gains, key=lambda each: each[0])[1] if gains else None


def _used_up(rule: Rule) -> float:
    """Return how much of a rule's first limit its value takes; of a limit that falls, the other way round.

    Of a limit of zero, such as that of how far a pressure is below the permissible, no part can be taken: the value
    itself, a fraction too.
    """
    limits = [limit for _, limit in rule.steps.levels]
    if rule.steps.falling:
        return max(limits) / rule.value if rule.value else math.inf
    return rule.value / min(limits) if min(limits) else rule.value


def choose(
    diagnosis: Diagnosis,
    goal: Goal = Goal.EVERY_LIMIT,
    prices: Prices | None = None,
    *,
    kept: Iterable[str] = (),
    fewest: bool = False,
    rounds: int = ROUNDS,
) -> Choice:
    """Choose repairs that bring a unit to a goal at every condition that was judged.

    The choice is the cheapest where the cost of every repair of a flagged land is known, all in one currency; lands
    within their limits are then repaired only where that cost is known too, unless nothing else reaches the goal.
    Otherwise it is the one with the fewest repairs, and of these the cheapest as far as prices are known. Of choices
    that are equal in all that, the one that saves most is taken.

    Where totals and pressures cannot be green, each is brought into the best band that repairs can bring it into.

    Parameters
    ----------
    prices
        what repairs cost; as the valve body's file states it unless given.
    kept
        ids of repairs that are taken for their lands, whatever else the file names.
    fewest
        look for the fewest repairs even where every cost is known.
    rounds
        proposals that the engine computes at the most, for each way that is tried.

    Notes
    -----
    Every choice is computed by the engine before it is returned. That it is the best one rests on the balance of
    pressures having one solution that rises and falls with the leaks, which `atleak.analysis.repair.search` says more
    of.
    """
    ended = False
    for basis, search in _searches(diagnosis, goal, prices or Prices(), tuple(kept), fewest=fewest, rounds=rounds):
        best = search.best()
        ended |= search.ended
        if best is not None:
            return Choice(goal, basis, best.moves, search.moves, search.unit, best.proven and not ended, best.rounds)
    return Choice(goal, Basis.FEWEST, (), search.moves, search.unit, False, rounds)


def _searches(
    diagnosis: Diagnosis, goal: Goal, prices: Prices, kept: Sequence[str], *, fewest: bool, rounds: int
) -> Iterator[tuple[Basis, Search]]:
    """Yield the ways in which a choice is looked for, each where the one before found none."""
    lands = [land for land in diagnosis.lands if land.state.judged]
    options = Options(diagnosis)
    flagged = [land.key for land in lands if land.verdict.flagged]
    wanted = [key for key in flagged if (option := options.wanted(key)) and option.repair in diagnosis.repairs]
    for as_new in (False, True):
        moves = Moves(options, lands, prices, kept=kept, as_new=as_new)
        unit = RepairableUnit(diagnosis.valve_body, moves.states)
        required = [key for key in (flagged if goal is Goal.EVERY_LIMIT else wanted) if moves.of_land[key]]
        for end in (_best_states(moves, unit), moves.choice(together(moves.all))):
            targets = (
                [] if diagnosis.impossible else list(_targets(unit, end))
            )  # of such a unit nothing is up to the lands
            for basis in (Basis.FEWEST,) if fewest else _bases(moves, flagged):
                allowed = [move for move in moves.all if basis is Basis.FEWEST or prices.cost(move) is not None]
                objectives = partial(_objectives, moves, basis, unit)
                yield basis, Search(moves, unit, targets, required, objectives, allowed, rounds)


def _bases(moves: Moves, flagged: Sequence[LandKey]) -> tuple[Basis, ...]:
    """Return by what a choice is looked for, the second where the first does not reach the goal."""
    asked = [move for key in flagged for move in moves.of_land[key]] or list(moves.all)
    priced = all(moves.prices.cost(move) is not None for move in asked) and len(moves.currencies) < 2
    return (Basis.CHEAPEST, Basis.FEWEST) if priced and asked else (Basis.FEWEST,)


def _objectives(moves: Moves, basis: Basis, unit: RepairableUnit) -> list[list[int]]:
    """Return what a choice is to have least of, in the order of importance, as whole numbers for each repair."""
    prices = moves.prices
    smallest = [(prices.cost(move), decimals(prices.currency_of(move))) for move in moves.all]
    costs = _unknown_as_most([None if cost is None else int(cost.scaleb(places)) for cost, places in smallest])
    hours = _unknown_as_most([None if (of := prices.hours(move)) is None else round(of * 1000) for move in moves.all])
    count = [1] * len(moves.all)
    money = [costs, hours] if len(moves.currencies) < 2 else []
    first = [costs, count, hours] if basis is Basis.CHEAPEST else [count, *money]
    order = list(range(len(moves.all)))
    return [each for each in first if len(set(each)) > 1 or each is count] + [_savings(moves, unit), order]


def _unknown_as_most(values: Sequence[int | None]) -> list[int]:
    """Return numbers, and in place of an unknown one more than all that are known."""
    more = 1 + sum(value for value in values if value is not None)
    return [more if value is None else value for value in values]


def _savings(moves: Moves, unit: RepairableUnit) -> list[int]:
    """Return for every repair the less, the more it saves alone: of the share, by the limit where it saves most."""
    at_conditions = zip(unit.judged, unit.repaired([{}, *(moves.choice([move]) for move in moves.all)]), strict=True)
    most = np.zeros(len(moves.all))
    for (total, *_), done in at_conditions:
        shares, limit = total.value(done.leakage, done.pressures), total.limit(Verdict.OK)
        if limit and np.all(np.isfinite(shares)):
            most = np.maximum(most, (shares[0] - shares[1:]) / limit)
    return [-round(each * 1e6) for each in most.tolist()]


def _best_states(moves: Moves, unit: RepairableUnit) -> LandChoice:
    """Return every land in the tightest state that any repair leaves it in, whether they go together or not."""
    best: dict[LandKey, int] = {}
    for key, choices in moves.of_land.items():
        numbers = [moves.state_after(move, key) for move in choices]
        if numbers:
            best[key] = min(numbers, key=lambda number: unit.states[key][number - 1].radial_clearance)
    return best


def _targets(unit: RepairableUnit, end: LandChoice) -> Iterator[Target]:
    """Yield the limits that a unit keeps at every condition with its lands in some states."""
    for at, rules, done in zip(unit.conditions, unit.judged, unit.repaired([end]), strict=True):
        for judged in rules:
            for worst in (Verdict.OK, *(verdict for verdict in Verdict if verdict.flagged)):
                limit = judged.limit(worst)
                if limit is None:
                    break
                target = Target(judged, limit, at)
                if np.all(target.kept(done)):
                    yield target
                    break


@dataclass(frozen=True)
class OfferedRepair:
    """One repair that can be chosen, with the lands that it changes, the one that calls for it most first."""

    move: Move
    lands: tuple[LandDiagnosis, ...]
    alone: tuple[RepairedAt, ...]  # what it brings at every condition if nothing else is repaired

    @property
    def key(self) -> MoveKey:
        """Return what names it."""
        return self.move.key

    @property
    def called_for(self) -> bool:
        """Tell whether a land that it treats has reached a limit of its own."""
        return any(land.verdict.flagged and land.key in self.move.treats for land in self.lands)

    @property
    def best_at(self) -> RepairedAt:
        """Return the condition at which it saves most, measured by the limit of that condition."""
        return max(self.alone, key=lambda each: each.saving)


class OfferedRepairs:
    """Every repair that is offered of a diagnosed unit: for flagged lands first, in the order of what each brings."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis, self.prices = diagnosis, Prices()
        lands = [land for land in diagnosis.lands if land.state.judged]
        self.moves = Moves(Options(diagnosis), lands, self.prices)
        self.unit = RepairableUnit(diagnosis.valve_body, self.moves.states)

    @cached_property
    def all(self) -> tuple[OfferedRepair, ...]:
        """Return the repairs, those that flagged lands call for first: the worst verdict, then what saves most."""
        by_key = {land.key: land for land in self.diagnosis.lands}
        now, *after = self._one_by_one
        offered = [
            OfferedRepair(
                move,
                tuple(sorted((by_key[key] for key in move.lands), key=lambda land: -land.verdict.rank)),
                tuple(RepairedAt(one, other) for one, other in zip(now, totals, strict=True)),
            )
            for move, totals in zip(self.moves.all, after, strict=True)
        ]

        def urgency(each: OfferedRepair) -> tuple[bool, int, float]:
            treated = (land.verdict.rank for land in each.lands if land.key in each.move.treats)
            return not each.called_for, -max(treated, default=0) if each.called_for else 0, -each.best_at.saving

        return tuple(sorted(offered, key=urgency))

    @property
    def called_for(self) -> tuple[OfferedRepair, ...]:
        """Return those that flagged lands call for."""
        return tuple(each for each in self.all if each.called_for)

    def chosen(self, keys: Collection[MoveKey]) -> list[Move]:
        """Return the repairs of some keys that go together; keys that nothing here has are left out."""
        return together(move for move in self.moves.all if move.key in keys)

    @cached_property
    def _one_by_one(self) -> list[tuple[Total, ...]]:
        """Return the totals as measured, then with each repair alone."""
        return self.unit.totals([{}, *(self.moves.choice([move]) for move in self.moves.all)])

    def excluded_by(self, key: MoveKey) -> frozenset[MoveKey]:
        """Return the other repairs that do not go together with one."""
        mine = next((move for move in self.moves.all if move.key == key), None)
        others = () if mine is None else (each for each in self.moves.all if not each.goes_with(mine))
        return frozenset(each.key for each in others if each is not mine)
