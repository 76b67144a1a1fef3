"""Plan the repairs of a unit: which lands, in which order, what each brings at every condition, and where that ends.

A repaired land is as its repair leaves it where the controller's file names one, and as new otherwise. What a repair
saves depends on those before it where lands share a circuit, so every stage of the plan is computed as a whole:
leakage, line pressure and what each circuit holds.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from atleak.analysis.repair.choice import Choice, choose
from atleak.analysis.repair.options import Cost, Move, Option, Options, Prices, cost_of, pump_option
from atleak.analysis.repair.totals import RepairableUnit, RepairedAt, Total
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.common.printable import brief
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis, PumpDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.projection import Projection


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of a plan: what it brings after the steps before it, and by which repair."""

    conditions: tuple[RepairedAt, ...]  # in the order of the diagnosis, the stated one first
    options: tuple[Option, ...] = ()  # of the controller's file for what calls for it, in its order
    chosen: Option | None = None  # None: as new, as no option mends it

    @cached_property
    def at(self) -> RepairedAt:
        """Return the condition whose total the repair helps most, measured by its limit."""
        return max(self.conditions, key=lambda each: each.saving)


@dataclass(frozen=True, kw_only=True)
class PumpStep(Step):
    """The repair of a pump past its limits, which comes before all others and leaves it as new."""

    pump: PumpDiagnosis

    @property
    def consequence(self) -> Consequence:
        """Return that it is needed now."""
        return Consequence.NOW

    @property
    def verdict(self) -> Verdict:
        """Return the verdict on the pump."""
        return self.pump.verdict

    @cached_property
    def at(self) -> RepairedAt:
        """Return the condition of what the pump lacks most; where it lacks nothing, of the largest total."""
        lacking = next((rule.condition for rule in self.pump.lacking if rule.condition is not None), None)
        worst = max(self.conditions, key=lambda each: each.before.share)
        return next((each for each in self.conditions if each.condition == lacking), worst)

    @property
    def helps(self) -> bool:
        """Tell whether it is known what a new pump brings: less slip at any condition."""
        return any(each.after.projection.slip < each.before.projection.slip for each in self.conditions)


@dataclass(frozen=True, kw_only=True)
class RepairStep(Step):
    """The repair of one land, and of what is mended together with it."""

    land: LandDiagnosis  # the one that calls for it
    consequence: Consequence  # the worst of its lands; now where a limit of the unit would stay passed without it
    together: tuple[LandDiagnosis, ...] = ()  # further lands of the component that the chosen one changes

    @property
    def verdict(self) -> Verdict:
        """Return the verdict on the land."""
        return self.land.verdict

    @property
    def for_total(self) -> bool:
        """Tell whether the land is within its limits, and is repaired for the sake of a total or a pressure alone."""
        return not self.land.verdict.flagged

    @property
    def stays_past(self) -> tuple[LandDiagnosis, ...]:
        """Return the flagged lands that the chosen repair leaves past a limit of their own."""
        option, lands = self.chosen, (self.land, *self.together)
        return tuple(each for each in lands if option and each.verdict.flagged and not option.mends(each.key))

    @property
    def helps(self) -> bool:
        """Tell whether the repair lowers the total, or raises a pressure, at any condition."""
        return self.at.saving > 0.0 or any(each.gained > 0.0 for each in self.conditions)

    @property
    def leaks(self) -> bool:
        """Tell whether the land leaks at any condition as it was measured."""
        return any(each.before.projection.leakage_of(self.land.key) > 0.0 for each in self.conditions)


@dataclass(frozen=True)
class Remainder:
    """A total that stays past its limits when the plan is carried out, and what else than the lands it may be up to."""

    total: Total  # the total, as the plan leaves it
    new_share: float  # of the same unit with every land new
    kinematic_viscosity: float  # [m²/s] of the fluid there
    pump_loss: float  # part of what the pump displaces that it does not deliver there

    @property
    def new_is_past(self) -> bool:
        """Tell whether a unit with every land new is past its limits there too."""
        return Band(self.total.rule.steps.judge(self.new_share, Band.GREEN)[0]) is not Band.GREEN


@brief
@dataclass(frozen=True)
class RepairPlan:
    """The repairs in their order, and the totals that they end at."""

    pump: PumpStep | None  # where the pump is past its limits: it comes first, and counts as new in all that follows
    steps: tuple[RepairStep, ...]  # of lands, in the order in which they are to be done
    ends: tuple[Total, ...]  # at every condition, the stated one first
    remaining: tuple[Remainder, ...]  # the ends that are not green
    pressures_past: tuple[Rule, ...]  # rules of reserve and pressures that stay past a limit
    unmeasured: int  # lands of which a part was not measured and is computed as new
    choice: Choice  # that the steps carry out
    judged: bool = True  # whether any land was measured: else there is nothing to plan

    @property
    def order(self) -> tuple[PumpStep | RepairStep, ...]:
        """Return every step: the pump's, then those of lands."""
        return self.steps if self.pump is None else (self.pump, *self.steps)

    @property
    def cost(self) -> Cost | None:
        """Return what the chosen options cost together; None where the controller's file names none for any step."""
        return cost_of([step.chosen for step in self.order]) if any(step.options for step in self.order) else None

    @property
    def reached(self) -> bool:
        """Tell whether the plan ends green at every condition, with every pressure and land within its limits."""
        return self.judged and not self.remaining and not self.pressures_past and not self.lands_past

    @property
    def lands_past(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands that stay past a limit of their own with the repair that the workshop chose."""
        return tuple(land for step in self.steps for land in step.stays_past)

    @property
    def for_total(self) -> int:
        """Count the steps whose lands are within their limits."""
        return sum(step.for_total for step in self.steps)


def plan_repairs(diagnosis: Diagnosis) -> RepairPlan:
    """Plan the repairs that a diagnosis calls for, over every condition that was judged.

    First comes a pump past its limits, and all that follows is computed with a new one. Then come the lands that
    reached a limit of their own, the worst verdict first; of equal ones that which saves most, measured by the limit of
    the condition at which it saves most. Where totals or pressures are then not green, those lands within their limits
    follow that bring each into the best band that repairs can bring it into. Last come lands past a limit of their own
    whose wear does nothing before the next service, and then those whose wear does nothing at all.

    Where the controller's file names repairs, a land is mended by one that leaves it within its limits of clearance,
    wear and share, with the clearance that this leaves; where none does, or none is named, it is made as new. Which
    of them, and which lands within their limits, `choose` says for `Goal.EVERY_LIMIT`: the cheapest, or the fewest.

    Parameters
    ----------
    diagnosis
        as `atleak.diagnose` gives it.

    Returns
    -------
    RepairPlan
        steps in their order, what each brings, and what stays past its limits.
    """
    return kept_with(diagnosis, "repair plan", "", lambda: _planned(diagnosis), most=1)


def _planned(diagnosis: Diagnosis) -> RepairPlan:
    choice, valve_body = choose(diagnosis), diagnosis.valve_body
    jobs = in_order(choice, diagnosis)
    done: list[LandKey] = []
    after_each = [done := [*done, *(land.key for land in lands)] for _, lands in jobs]
    stages = choice.unit.totals([{}, *({key: choice.states[key] for key in keys} for keys in after_each)])
    ends, options = stages[-1], choice.moves.options
    past = [[rule.verdict.rank for total in stage for rule in (total.rule, *total.pressure_rules)] for stage in stages]
    needed = past.index(past[-1])  # repairs, until the unit is past no limit that they mend
    return RepairPlan(
        pump=_pump_step(diagnosis, options, stages[0]),
        steps=tuple(
            RepairStep(
                land=lands[0],
                conditions=_repaired(before, after),
                options=options.of(lands[0].key),
                chosen=move.option,
                consequence=Consequence.NOW
                if number < needed
                else max((diagnosis.consequences[land.key] for land in lands), key=lambda each: each.rank),
                together=tuple(lands[1:]),
            )
            for number, ((move, lands), before, after) in enumerate(zip(jobs, stages, stages[1:], strict=False))
        ),
        ends=ends,
        remaining=tuple(
            _remainder(diagnosis, end, new)
            for end, new in zip(ends, valve_body.new_projections, strict=True)
            if end.band is not Band.GREEN
        ),
        pressures_past=tuple(rule for end in ends for rule in end.pressure_rules if rule.verdict.flagged),
        unmeasured=len(diagnosis.lands) - diagnosis.measured,
        choice=choice,
        judged=any(land.state.judged for land in diagnosis.lands),
    )


def _pump_step(diagnosis: Diagnosis, options: Options, after: Iterable[Total]) -> PumpStep | None:
    if not diagnosis.pump.verdict.flagged:
        return None
    (before,) = RepairableUnit(diagnosis, {}).totals([{}])
    return PumpStep(
        pump=diagnosis.pump,
        conditions=_repaired(before, after),
        options=options.of_pump,
        chosen=pump_option(options, Prices()),
    )


def _repaired(before: Iterable[Total], after: Iterable[Total]) -> tuple[RepairedAt, ...]:
    return tuple(itertools.starmap(RepairedAt, zip(before, after, strict=True)))


def in_order(choice: Choice, diagnosis: Diagnosis) -> list[tuple[Move, list[LandDiagnosis]]]:
    """Return the repairs of a choice in their order, each with its lands, the one that calls for it first."""
    later = {Consequence.BEFORE_NEXT_SERVICE: 1, Consequence.NONE: 2}
    by_key = {land.key: land for land in diagnosis.valve_body.lands}
    treated, saving = {key for move in choice.chosen for key in move.treats}, choice.savings

    def urgency(key: LandKey) -> tuple[bool, int, int, float]:
        verdict = by_key[key].verdict
        waits = later.get(diagnosis.consequences[key], 0) if verdict.flagged else 0
        return key not in treated, waits, -verdict.rank if verdict.flagged else 0, -saving[key]

    jobs = [(move, sorted(keys, key=urgency)) for move, keys in choice.lands if keys]
    jobs.sort(key=lambda job: urgency(job[1][0]))
    return [(move, [by_key[key] for key in keys]) for move, keys in jobs]


def _remainder(diagnosis: Diagnosis, end: Total, new: Projection) -> Remainder:
    condition, model = end.condition, diagnosis.model
    displaced = model.controller.pump.displacement * condition.engine_speed
    return Remainder(
        total=end,
        new_share=new.share,
        kinematic_viscosity=float(
            diagnosis.fluid.kinematic_viscosity(condition.temperature, diagnosis.profile.viscosity)
        ),
        pump_loss=1.0 - end.projection.pump_capacity / displaced,
    )
