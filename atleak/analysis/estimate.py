"""Turn the choice of repairs, the workshop's decisions and its terms into the lines and sums of an estimate, and back.

A line starts as the choice proposes it and follows every new measurement. From the first change on it is the
workshop's own and stays as it is. What nobody knows, a price or hours, is named and counts in no sum.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any, Protocol

from atleak.analysis.record_doubts import covered, is_of_pump
from atleak.analysis.repair.choice import Choice, Gain, OfferedRepairs, choose, gain_of
from atleak.analysis.repair.options import Move, MoveKey, Option, Prices, StatedPrice, amount, product, pump_option
from atleak.analysis.repair.plan import in_order
from atleak.analysis.repair.totals import RepairableUnit, RepairedAt, Total
from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import PUMP, Goal, LandKey
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.projection import repaired
from atleak.measurements.clearances import LandClearance
from atleak.measurements.job_card import EstimateTerms, Job, RepairDecision, RepairState

ORDER: tuple[RepairState, ...] = ("proposed", "approved", "done", "deferred", "declined")
CARRIED_OUT: tuple[RepairState, ...] = ("proposed", "approved", "done")  # as far as anybody knows


@dataclass(frozen=True)
class Line:
    """One repair of an estimate, with the lands that it is about."""

    key: str  # what tells it from the other lines
    decision: RepairDecision  # as the workshop wrote it, or as it is proposed
    place: int | None  # of the workshop's own line in the job record; None while nobody touched it
    lands: tuple[LandDiagnosis, ...]  # of this unit that were measured
    states: Mapping[LandKey, LandClearance]  # in which it leaves them
    mending: frozenset[LandKey]  # those that are then within their limits
    chosen: bool  # whether the choice for the goal contains it
    price: float | None  # of the part; None: nobody knows it
    hours: float | None  # of work; None: nobody knows them
    part: Decimal | None  # the price, rounded
    work: Decimal | None  # None: nobody knows the hours, or the labour rate
    other_currency: str = ""  # in which the file states the price, where that is not the estimate's
    of_pump: bool = False  # whether it is about the pump, which it leaves as new

    @property
    def own(self) -> bool:
        """Tell whether the workshop changed it."""
        return self.place is not None

    @property
    def carried_out(self) -> bool:
        """Tell whether it counts as a repair of the unit: it is neither declined nor deferred nor left open."""
        return self.decision.decision in CARRIED_OUT


@dataclass(frozen=True)
class Sum:
    """What lines cost together: known amounts added, each rounded before, and tax on their sum, rounded once."""

    lines: tuple[Line, ...]
    parts: Decimal | None  # None: no price is known
    work: Decimal | None  # None: of no line the work is known
    tax: Decimal | None  # None: no tax was stated, or there is nothing to tax

    @property
    def net(self) -> Decimal | None:
        """Return parts and work, as far as they are known."""
        return _added((self.parts, self.work))

    @property
    def gross(self) -> Decimal | None:
        """Return parts, work and tax."""
        return _added((self.parts, self.work, self.tax))

    @property
    def complete(self) -> bool:
        """Tell whether every amount of every line is known."""
        return not self.without_price and not self.without_work

    @property
    def without_price(self) -> tuple[Line, ...]:
        """Return the lines whose part has no known price."""
        return tuple(line for line in self.lines if line.part is None)

    @property
    def without_work(self) -> tuple[Line, ...]:
        """Return the lines whose work has no known cost."""
        return tuple(line for line in self.lines if line.work is None)


def _added(amounts: Iterable[Decimal | None]) -> Decimal | None:
    """Return the sum of the amounts that are known; None where none is."""
    known = [each for each in amounts if each is not None]
    return sum(known[1:], known[0]) if known else None


@dataclass(frozen=True)
class Estimate:
    """The lines of an estimate, and what the engine says of a unit repaired by some of them."""

    diagnosis: Diagnosis
    terms: EstimateTerms
    choice: Choice  # for the goal of the terms
    lines: tuple[Line, ...]
    currency: str

    def sum_of(self, *states: RepairState) -> Sum:
        """Add up the lines in some states."""
        lines = tuple(line for line in self.lines if line.decision.decision in states)
        parts, work = _added(line.part for line in lines), _added(line.work for line in lines)
        net, percent = _added((parts, work)), self.terms.tax_percent
        tax = None if net is None or percent is None else amount(net * Decimal(repr(percent)) / 100, self.currency)
        return Sum(lines, parts, work, tax)

    @property
    def sums(self) -> dict[RepairState, Sum]:
        """Return the sums of every state in which there is a line."""
        present = {line.decision.decision for line in self.lines}
        return {state: self.sum_of(state) for state in ORDER if state in present}

    @property
    def total(self) -> Sum:
        """Return the sum of all that is to be done, or was: proposed, approved and done."""
        return self.sum_of(*CARRIED_OUT)

    # --- what the engine says of it

    @cached_property
    def _states(self) -> dict[LandKey, list[LandClearance]]:
        states: dict[LandKey, list[LandClearance]] = {}
        for line in self.lines:
            for key, state in line.states.items():
                states.setdefault(key, []).append(state)
        return states

    def _totals(self, repairs: Sequence[Sequence[Line]]) -> list[tuple[Total, ...]]:
        """Return the totals with several sets of lines, each with the pump new unless its line is in none of them."""
        listed = any(line.of_pump for line in self.lines)
        worn = [listed and not any(line.of_pump for line in lines) for lines in repairs]
        units = {is_worn: self.diagnosis if is_worn else self.diagnosis.valve_body for is_worn in worn}
        totals = {
            is_worn: iter(
                RepairableUnit(unit, self._states).totals(
                    [self._choice(lines) for lines, each in zip(repairs, worn, strict=True) if each is is_worn]
                )
            )
            for is_worn, unit in units.items()
        }
        return [next(totals[each]) for each in worn]

    def _choice(self, lines: Iterable[Line]) -> dict[LandKey, int]:
        chosen: dict[LandKey, int] = {}
        for line in lines:
            for key, state in line.states.items():
                numbers = enumerate(self._states[key], start=1)
                chosen[key] = next(number for number, each in numbers if each is state)
        return chosen

    @cached_property
    def _computed(self) -> tuple[tuple[Total, ...], dict[str, tuple[Total, ...]]]:
        """Return the totals with all lines that are carried out, and with each line the other way round."""
        base = [line for line in self.lines if line.carried_out]
        changed = [
            [each for each in base if each is not line] if line.carried_out else [*base, line] for line in self.lines
        ]
        ends, *others = self._totals([base, *changed])
        return ends, {line.key: totals for line, totals in zip(self.lines, others, strict=True)}

    @property
    def ends(self) -> tuple[Total, ...]:
        """Return the totals with all lines that are carried out, the stated condition first."""
        return self._computed[0]

    @cached_property
    def effect(self) -> tuple[RepairedAt, ...]:
        """Return every condition as measured and with all lines that are carried out, the stated one first."""
        (now,) = self._totals([[]])
        return tuple(RepairedAt(before, after) for before, after in zip(now, self.ends, strict=True))

    def gain_of(self, line: Line) -> Gain | None:
        """Return what the unit lacks most without a line; of one that is not carried out, what it lacks by that."""
        ends, others = self._computed
        pair = (ends, others[line.key]) if line.carried_out else (others[line.key], ends)
        return gain_of(*pair)

    def stays_past(self, line: Line) -> tuple[Rule, ...]:
        """Return the rules of totals and pressures that are past a limit without a line."""
        ends, others = self._computed
        totals = others[line.key] if line.carried_out else ends
        return tuple(rule for total in totals for rule in total.past)

    @property
    def past(self) -> tuple[Rule, ...]:
        """Return the rules of totals and pressures that stay past a limit with all lines that are carried out."""
        return tuple(rule for total in self.ends for rule in total.past)

    @property
    def lands_past(self) -> tuple[LandDiagnosis, ...]:
        """Return the flagged lands that no line which is carried out brings within their limits."""
        mended = {key for line in self.lines if line.carried_out for key in line.mending}
        return tuple(land for land in self.diagnosis.flagged if land.key not in mended)


class Chooser(Protocol):
    """What chooses repairs: `choose`, or something that keeps what that said."""

    def __call__(self, diagnosis: Diagnosis, goal: Goal, prices: Prices, *, kept: Iterable[str]) -> Choice: ...


def estimate(diagnosis: Diagnosis, job: Job, chooser: Chooser = choose) -> Estimate:
    """Make the estimate of a job: the workshop's own lines, and those that are proposed for every other flagged land.

    A line that the goal has no need of is listed without a state, and in no sum.
    """
    terms, prices = job.estimate, prices_of(job, diagnosis.controller)
    decided = sorted(job.repair_decisions, key=lambda each: each.decision not in CARRIED_OUT)
    kept = [each.repair for each in decided if each.repair]
    everything = chooser(diagnosis, Goal.EVERY_LIMIT, prices, kept=kept)
    goal = terms.goal
    choice = everything if goal is Goal.EVERY_LIMIT else chooser(diagnosis, goal, prices, kept=kept)
    make = _Lines(diagnosis, terms, choice, prices.currency)
    lines = [make.own(place, each) for place, each in enumerate(job.repair_decisions) if not each.empty]
    unlisted = not any(line.of_pump for line in lines) and PUMP not in diagnosis.controller.components
    if diagnosis.pump.verdict.flagged and unlisted:
        lines.append(make.of_pump(pump_option(choice.moves.options, prices, kept)))
    wanted = {option.repair.id for option in everything.moves.wanted.values()}
    aside = make.options.keys() - wanted  # of those decided on: another one is taken for a land that they change
    about = (covered(line.decision, diagnosis.controller) for line in lines if line.decision.repair not in aside)
    taken = set[LandKey]().union(*about)
    for offered in (choice, everything):
        for move, _ in in_order(offered, diagnosis):
            if not move.treats <= taken:
                taken |= move.treats
                lines.append(make.proposed(move))
    ranks = {land.key: place for place, land in enumerate(diagnosis.flagged)}

    def urgency(line: Line) -> int:
        if line.of_pump:
            return -1
        return min((ranks[land.key] for land in line.lands if land.key in ranks), default=len(ranks))

    return Estimate(diagnosis, terms, choice, tuple(sorted(lines, key=urgency)), prices.currency)


def with_line(job: Job, line: Line, **changes: Any) -> Job:
    """Return the record with a line as the workshop changed it: from now on it is the workshop's own."""
    decision = line.decision.changed(**changes)
    decisions = list(job.repair_decisions)
    if line.place is None:
        decisions.append(decision)
    else:
        decisions[line.place] = decision
    return job.model_copy(update={"repair_decisions": tuple(decisions)})


def prices_of(job: Job, controller: Controller) -> Prices:
    """Return what repairs cost in a job: as its terms and decisions state it, else as the valve body's file does."""
    stated = (each.currency for each in controller.repairs if each.price is not None)
    currency = job.estimate.currency or next(stated, None) or ""
    return Prices(job.estimate.labour_rate, currency, _typed(job))


def _typed(job: Job) -> dict[MoveKey, StatedPrice]:
    """Return what the workshop typed of prices and hours, by the repair or the land."""
    typed: dict[MoveKey, StatedPrice] = {}
    for each in job.repair_decisions:
        if each.repair:
            typed[each.repair] = StatedPrice(each.price, each.hours)
        elif each.land is not None:
            typed[each.component, each.land] = StatedPrice(each.price, each.hours)
    return typed


def decision_on(move: Move) -> RepairDecision:
    """Return a repair as a line of the job record that proposes it; price and hours stay as known elsewhere."""
    (component, land), *others = sorted(move.treats)
    repair = move.option.repair if move.option is not None else None
    return RepairDecision(
        component=component,
        land=None if others or (repair is not None and len(repair.lands) > 1) else land,
        repair=repair.id if repair is not None else "",
        work=repair.name if repair is not None else "",
        part_number=(repair.part_number or "") if repair is not None else "",
        decision="proposed",
    )


class _Lines:
    """The lines of one estimate, each made from a decision."""

    def __init__(self, diagnosis: Diagnosis, terms: EstimateTerms, choice: Choice, currency: str) -> None:
        self.diagnosis, self.terms, self.choice, self.currency = diagnosis, terms, choice, currency
        self.options = {option.repair.id: option for option in choice.moves.options.all}
        self.keys: set[str] = set()
        self.counted: set[tuple[str, bool]] = set()  # repairs whose cost a line has, and whether it is carried out

    def own(self, place: int, decision: RepairDecision) -> Line:
        """Return a line that the workshop wrote."""
        controller = self.diagnosis.controller
        about = covered(decision, controller)
        chosen = any(move.treats & about for move in self.choice.chosen)
        chosen |= self.diagnosis.pump.verdict.flagged and is_of_pump(decision, controller)
        return self._line(decision, place, chosen=chosen)

    def of_pump(self, option: Option | None) -> Line:
        """Return the line of a worn pump that nobody touched; None where the file names no repair of it."""
        decision = RepairDecision(component=PUMP, decision="proposed")
        if option is not None:
            named = {"repair": option.repair.id, "work": option.repair.name}
            decision = decision.model_copy(update={**named, "part_number": option.repair.part_number or ""})
        return self._line(decision, None, chosen=True)

    def proposed(self, move: Move) -> Line:
        """Return the line of a repair that nobody touched."""
        chosen = any(each.key == move.key for each in self.choice.chosen)
        prices = self.choice.moves.prices
        decision = decision_on(move).model_copy(
            update={
                "price": prices.price(move),
                "hours": prices.hours(move),
                "decision": "proposed" if chosen else None,
            }
        )
        return self._line(decision, None, chosen=chosen)

    def _line(self, decision: RepairDecision, place: int | None, *, chosen: bool) -> Line:
        option, rate = self.options.get(decision.repair), self.terms.labour_rate
        price, hours, other = decision.price, decision.hours, ""
        counted = decision.repair, decision.decision in CARRIED_OUT
        if option is not None and counted in self.counted:  # a kit costs once, whatever component names it
            price, hours = price or 0.0, hours or 0.0
        elif option is not None:
            self.counted.add(counted)
            hours = option.repair.hours if hours is None else hours
            if price is None and option.repair.price is not None:
                mine = option.repair.currency == self.currency
                price, other = (option.repair.price, "") if mine else (None, option.repair.currency or "")
        about = covered(decision, self.diagnosis.controller)
        lands = tuple(land for land in self.diagnosis.lands if land.key in about and land.state.measured)
        new = repaired([land.state for land in lands], about)
        return Line(
            self._key(decision),
            decision,
            place,
            lands,
            {state.land.key: state for state in new} if option is None else option.states,
            about if option is None else option.mending,
            chosen,
            price,
            hours,
            None if price is None else amount(price, self.currency),
            None if rate is None or hours is None else product(hours, rate, self.currency),
            other,
            is_of_pump(decision, self.diagnosis.controller),
        )

    def _key(self, decision: RepairDecision) -> str:
        """Return what tells a line from the others, the same before and after it is touched."""
        key = first = decision.repair or decision.pair
        while key in self.keys:
            key = f"{first} {len(self.keys)}"
        self.keys.add(key)
        return key


def decided_repairs(repairs: OfferedRepairs, job: Job) -> frozenset[MoveKey]:
    """Return the offered repairs that the record proposes, has approved or done."""
    carried_out = [each for each in job.repair_decisions if each.decision in CARRIED_OUT]
    controller = repairs.diagnosis.controller
    moves = [move for move in repairs.moves.all if any(_is_about(each, move, controller) for each in carried_out)]
    return frozenset(move.key for move in repairs.chosen([move.key for move in moves]))


def with_repairs(repairs: OfferedRepairs, job: Job, keys: Collection[MoveKey]) -> Job:
    """Return the record with decisions that carry out the offered repairs of some keys, and no other offered repair.

    What was decided already stays as it is where it agrees: an approved repair stays approved, a declined one keeps its
    reason. A repair that is taken back is left open. Decisions about anything that is not offered are not touched.
    """
    chosen, controller = repairs.chosen(keys), repairs.diagnosis.controller
    decisions: list[RepairDecision] = []
    for each in job.repair_decisions:
        about = [move for move in repairs.moves.all if _is_about(each, move, controller)]
        wanted = any(move is other for move in about for other in chosen)
        if about and wanted != (each.decision in CARRIED_OUT):
            each = each.changed(decision="proposed" if wanted else None)
        decisions.append(each)
    carried_out = [each for each in decisions if each.decision in CARRIED_OUT]
    missing = [move for move in chosen if not any(_is_about(each, move, controller) for each in carried_out)]
    decisions += [decision_on(move) for move in missing]
    changed = job.model_copy(update={"repair_decisions": tuple(decisions)})
    return _nothing_besides(repairs.diagnosis, changed)


def with_repair(made: Estimate, repairs: OfferedRepairs, job: Job, key: MoveKey, *, on: bool) -> Job:
    """Return the record with one offered repair taken in or out; what does not go with it is taken out too.

    Lines about anything else follow the verdict as before, as long as nobody touches them.
    """
    controller = repairs.diagnosis.controller

    def lines(keys: Collection[MoveKey]) -> list[Line]:
        moves = [move for move in repairs.moves.all if move.key in keys]
        return [line for line in made.lines if any(_is_about(line.decision, move, controller) for move in moves)]

    for line in lines(repairs.excluded_by(key) if on else {key}):
        if line.carried_out:
            job = with_line(job, line, decision=None)
    if not on:
        return job
    if mine := lines({key}):
        return job if any(line.carried_out for line in mine) else with_line(job, mine[0], decision="proposed")
    decisions = *job.repair_decisions, *(decision_on(move) for move in repairs.chosen({key}))
    return job.model_copy(update={"repair_decisions": decisions})


def _nothing_besides(diagnosis: Diagnosis, job: Job) -> Job:
    """Return the record with what its estimate proposes by itself left open, until it proposes nothing more.

    A pump past its limits stays proposed: what is offered for the lands is computed with a new one.
    """
    while besides := [
        each for each in estimate(diagnosis, job).lines if not (each.own or each.of_pump) and each.carried_out
    ]:
        for line in besides:
            job = with_line(job, line, decision=None, price=None, hours=None)
    return job


def _is_about(decision: RepairDecision, move: Move, controller: Controller) -> bool:
    """Tell whether a decision is about an offered repair: it names it, or names none and covers its lands."""
    if decision.repair:
        return move.option is not None and move.option.repair.id == decision.repair
    return bool(move.treats) and move.treats <= covered(decision, controller)
