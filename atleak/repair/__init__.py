"""Plan the repairs of a unit: which lands, in which order, what each brings at every condition, and where that ends.

A repaired land is as its repair leaves it where the controller's file names one, and as new otherwise. What a repair
saves depends on those before it where lands share a circuit, so every stage of the plan is computed as a whole:
leakage, line pressure and what each circuit holds.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.controller import OperatingPoint
from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import LINE
from atleak.engine.projection import Projection
from atleak.engine.repaired import WORTH_NAMING, with_new
from atleak.repair.fewest import fewest
from atleak.repair.options import Cost, Option, Options, cost_of
from atleak.rules import LandKey, Rule, permissible_low
from atleak.verdicts import BANDS, Band

__all__ = [
    "Cost",
    "Option",
    "Remainder",
    "RepairPlan",
    "RepairStep",
    "RepairedAt",
    "Total",
    "fewest",
    "plan_repairs",
]

_NEARLY = 1e-8  # relative: a total must be under its limit by more than floating point can tell
_WORTH_A_REPAIR = (
    0.01  # of how far pressures are past their limits, that one more land must help: choice of this project
)


@dataclass(frozen=True)
class Total:
    """The total at one condition with some lands repaired, judged by the rule of that condition."""

    projection: Projection  # as measured
    leakage: float  # [m³/s] drawn from the pump
    rule: Rule  # of the total as measured, whose limits hold after a repair too
    pressures: Mapping[str, float]  # [Pa] that the line, as p_g, and every circuit hold
    measured_rules: tuple[Rule, ...]  # of reserve and pressures as measured
    unworn: Projection  # of the unit as it may have been when new

    @property
    def condition(self) -> OperatingPoint:
        """Return the condition."""
        return self.projection.condition

    @property
    def share(self) -> float:
        """Return leakage / pump capacity; infinite where the pump delivers nothing."""
        return self.projection.share_of(self.leakage)

    @property
    def reserve(self) -> float:
        """Return the pump's reserve."""
        return replace(self.projection, leakage=self.leakage).reserve

    @cached_property
    def pressure_rules(self) -> tuple[Rule, ...]:
        """Return the rules of reserve, circuits and permissible pressure, judged anew."""
        return tuple(replace(rule, value=self._value(rule)) for rule in self.measured_rules)

    def _value(self, rule: Rule) -> float:
        if rule.kind is RuleKind.RESERVE:
            return self.reserve
        if rule.circuit is not None:
            return abs((rule.new or 0.0) - self.pressures[rule.circuit.id])
        low = permissible_low(self.projection, self.unworn)
        return 1.0 - self.pressures[LINE] / low if low else rule.value

    @property
    def past(self) -> tuple[Rule, ...]:
        """Return every rule, the total's first, that is past a limit."""
        rules = replace(self.rule, value=self.share), *self.pressure_rules
        return tuple(rule for rule in rules if rule.verdict.flagged)

    @property
    def band(self) -> Band:
        """Return the band that the share has reached."""
        return Band(self.rule.steps.judge(self.share, Band.GREEN)[0])

    def limit_above(self, band: Band) -> float:
        """Return the share at which a band ends: the lowest limit of those that are worse."""
        return min(limit for level, limit in self.rule.steps.levels if BANDS.index(Band(level)) > BANDS.index(band))


@dataclass(frozen=True)
class RepairedAt:
    """What one repair brings at one condition."""

    before: Total
    after: Total

    @property
    def condition(self) -> OperatingPoint:
        """Return the condition."""
        return self.before.condition

    @property
    def saving(self) -> float:
        """Return the share that is saved over the share at which green ends: so that conditions can be compared."""
        saved = self.before.share - self.after.share
        if abs(saved) <= _NEARLY * self.before.share:  # what rounding leaves of nothing
            return 0.0
        return saved / self.before.limit_above(Band.GREEN) if math.isfinite(saved) else 0.0

    @property
    def gained(self) -> float:
        """Return the pressure that the line, or the circuit that gains most by the repair, gains [Pa]."""
        both = self.before.pressures, self.after.pressures
        gain = max(both[1][name] - both[0][name] for name in both[0])
        return gain if gain >= WORTH_NAMING else 0.0


@dataclass(frozen=True)
class RepairStep:
    """The repair of one land, and of what is mended together with it, after the steps before it."""

    land: LandDiagnosis
    conditions: tuple[RepairedAt, ...]  # in the order of the diagnosis, the stated one first
    options: tuple[Option, ...] = ()  # of the controller's file for this land, in its order
    chosen: Option | None = None  # None: as new, as no option mends the land
    together: tuple[LandDiagnosis, ...] = ()  # further lands of the component that the chosen one changes

    @property
    def for_total(self) -> bool:
        """Tell whether the land is within its limits, and is repaired for the sake of a total or a pressure alone."""
        return not self.land.verdict.flagged

    @cached_property
    def at(self) -> RepairedAt:
        """Return the condition whose total the repair helps most, measured by its limit."""
        return max(self.conditions, key=lambda each: each.saving)

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

    total: Total
    new_share: float  # of the same unit with every land new
    kinematic_viscosity: float  # [m²/s] of the fluid there
    pump_loss: float  # part of what the pump displaces that it does not deliver there

    @property
    def new_is_past(self) -> bool:
        """Tell whether a unit with every land new is past its limits there too."""
        return Band(self.total.rule.steps.judge(self.new_share, Band.GREEN)[0]) is not Band.GREEN


@dataclass(frozen=True)
class RepairPlan:
    """The repairs in their order, and the totals that they end at."""

    steps: tuple[RepairStep, ...]
    ends: tuple[Total, ...]  # at every condition, the stated one first
    remaining: tuple[Remainder, ...]  # the ends that are not green
    pressures_past: tuple[Rule, ...]  # rules of reserve and pressures that stay past a limit
    unmeasured: int  # lands of which a part was not measured and is computed as new
    judged: bool = True  # whether any land was measured: else there is nothing to plan

    @property
    def cost(self) -> Cost | None:
        """Return what the chosen options cost together; None where the controller's file names none for any step."""
        return cost_of([step.chosen for step in self.steps]) if any(step.options for step in self.steps) else None

    @property
    def reached(self) -> bool:
        """Tell whether the plan ends green at every condition, with every pressure within its limits."""
        return self.judged and not self.remaining and not self.pressures_past

    @property
    def for_total(self) -> int:
        """Count the steps whose lands are within their limits."""
        return sum(step.for_total for step in self.steps)


def plan_repairs(diagnosis: Diagnosis) -> RepairPlan:
    """Plan the repairs that a diagnosis calls for, over every condition that was judged.

    First come the lands that reached a limit of their own, the worst verdict first; of equal ones that which saves
    most, measured by the limit of the condition at which it saves most. Where totals are still not green, the fewest
    lands within their limits follow that bring each into the best band that repairs can bring it into. Where a pressure
    is still past a limit, those follow that help it most, one after the other.

    Where the controller's file names repairs, a land is mended by the cheapest option that leaves it within its limit
    of clearance, with the clearance that this option leaves; where none does, or none is named, it is made as new. An
    option that changes several lands mends them in one step. What the workshop chose goes before the cheapest.
    """
    options = Options(diagnosis)
    mended = options.model(options.single)
    lands = [land for land in diagnosis.lands if land.state.judged]
    totals, *alone = _totals(diagnosis, mended, [[], *([land] for land in lands)])
    single = {land.key: _both(totals, after) for land, after in zip(lands, alone, strict=True)}

    def saving(land: LandDiagnosis) -> float:
        return max(each.saving for each in single[land.key])

    flagged = sorted(
        (land for land in lands if land.verdict.flagged), key=lambda land: (-land.verdict.rank, -saving(land))
    )
    ends = _totals(diagnosis, mended, [flagged])[0]
    others = [land for land in lands if not land.verdict.flagged]
    more = _best_bands([land for land in others if saving(land) > 0.0], ends, single)
    more += _for_pressures(diagnosis, mended, [*flagged, *more], [land for land in others if land not in more])
    chosen = options.by_component([*flagged, *sorted(more, key=lambda land: -saving(land))])
    jobs = _jobs(diagnosis, chosen)
    done: list[LandDiagnosis] = []
    after_each = [done := [*done, *job] for job in jobs]
    stages = _totals(diagnosis, options.model(chosen), [[], *after_each])
    ends = stages[-1]
    return RepairPlan(
        steps=tuple(
            RepairStep(
                job[0], _both(before, after), options.of(job[0].key), chosen[job[0].key], together=tuple(job[1:])
            )
            for job, before, after in zip(jobs, stages, stages[1:], strict=False)
        ),
        ends=ends,
        remaining=tuple(
            _remainder(diagnosis, end, new)
            for end, new in zip(ends, diagnosis.new_projections, strict=True)
            if end.band is not Band.GREEN
        ),
        pressures_past=tuple(rule for end in ends for rule in end.pressure_rules if rule.verdict.flagged),
        unmeasured=len(diagnosis.lands) - diagnosis.measured,
        judged=bool(lands),
    )


def _jobs(diagnosis: Diagnosis, chosen: Mapping[LandKey, Option | None]) -> list[list[LandDiagnosis]]:
    """Return the lands that each repair mends, the one that calls for it first; each land once."""
    by_key = {land.key: land for land in diagnosis.lands}
    jobs: list[list[LandDiagnosis]] = []
    done: set[LandKey] = set()
    for key, option in chosen.items():
        if key not in done:
            changed = option.lands if option is not None else ()
            together = [each for each in changed if each not in {key, *done} and chosen.get(each, option) is option]
            jobs.append([by_key[each] for each in (key, *together)])
            done.update((key, *together))
    return jobs


def _totals(
    diagnosis: Diagnosis, mended: LeakageModel, choices: Sequence[Sequence[LandDiagnosis]]
) -> list[tuple[Total, ...]]:
    """Return the totals at every condition, the stated one first, for each choice of lands as in ``mended``."""
    chosen = [{land.key for land in choice} for choice in choices]
    by_condition: list[list[Total]] = []
    for projection in diagnosis.projections:
        done = with_new(diagnosis.model, mended, projection.condition, chosen)
        of_total, of_pressure = diagnosis.total_rule(projection), diagnosis.pressure_rules_at(projection)
        by_condition.append(
            [
                Total(
                    projection,
                    float(done.leakage[number]),
                    of_total,
                    {name: float(pressure[number]) for name, pressure in done.pressures.items()},
                    of_pressure,
                    diagnosis.unworn_at(projection),
                )
                for number in range(len(choices))
            ]
        )
    return list(zip(*by_condition, strict=True))


def _both(before: Iterable[Total], after: Iterable[Total]) -> tuple[RepairedAt, ...]:
    """Return what a repair brings at every condition."""
    return tuple(itertools.starmap(RepairedAt, zip(before, after, strict=True)))


def _for_pressures(
    diagnosis: Diagnosis, mended: LeakageModel, chosen: Sequence[LandDiagnosis], others: Sequence[LandDiagnosis]
) -> list[LandDiagnosis]:
    """Return the lands that help most, one after the other, as long as a pressure is past a limit and one helps it."""
    added: list[LandDiagnosis] = []
    while True:
        left = [land for land in others if land not in added]
        now, *with_one_more = _totals(
            diagnosis, mended, [[*chosen, *added], *([*chosen, *added, land] for land in left)]
        )
        past = _past_pressures(now)
        gains = [past - _past_pressures(after) for after in with_one_more]
        if past == 0.0 or not gains or max(gains) <= _WORTH_A_REPAIR * past:
            return added
        added.append(left[gains.index(max(gains))])


def _past_pressures(totals: Iterable[Total]) -> float:
    """Return how far all pressures that are past a limit are past it, each as a fraction of that."""
    rules = (rule for total in totals for rule in total.pressure_rules if rule.verdict.flagged)
    return sum(rule.past_first for rule in rules)


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


# --- the fewest lands that bring the totals into their best bands


def _best_bands(
    lands: Sequence[LandDiagnosis], totals: Sequence[Total], single: Mapping[LandKey, Sequence[RepairedAt]]
) -> list[LandDiagnosis]:
    """Return the fewest lands whose repair brings every total into the best band that repairs can bring it into.

    Parameters
    ----------
    single
        what the repair of each land alone brings at every condition; savings are taken to add up.
    """
    gains: list[list[float]] = [[] for _ in lands]
    needs: list[float] = []
    for number, total in enumerate(totals):
        less = [_saved(single[land.key][number]) for land in lands]
        best = replace(total, leakage=total.leakage - sum(less)).band
        if best is total.band:
            continue
        limit = total.limit_above(best)
        needs.append(total.share / limit - 1.0 + _NEARLY)
        for gain, flow in zip(gains, less, strict=True):
            gain.append(total.projection.share_of(flow) / limit)
    return [lands[number] for number in fewest(gains, needs)]


def _saved(each: RepairedAt) -> float:
    """Return how much less is drawn from the pump [m³/s], never less than nothing."""
    return max(each.before.leakage - each.after.leakage, 0.0)
