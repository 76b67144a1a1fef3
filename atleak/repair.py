"""Plan the repairs of a unit: which lands, in which order, what each brings at every condition, and where that ends.

A repaired land is as new. Flows add up, so what a repair saves at a condition does not depend on the repairs before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.controller import OperatingPoint
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.rules import Rule
from atleak.verdicts import BANDS, Band

_NEARLY = 1e-8  # relative: a total must be under its limit by more than floating point can tell
_NODES = 20_000  # of the search for the fewest lands; beyond it a few more than the fewest may be named


@dataclass(frozen=True)
class Total:
    """The total at one condition with some lands repaired, judged by the rule of that condition."""

    projection: Projection  # as measured
    leakage: float  # [m³/s] drawn from the pump
    rule: Rule  # of the total as measured, whose limits hold after a repair too

    @property
    def condition(self) -> OperatingPoint:
        """Return the condition."""
        return self.projection.condition

    @property
    def share(self) -> float:
        """Return leakage / pump capacity; infinite where the pump delivers nothing."""
        return self.projection.share_of(self.leakage)

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
        return saved / self.before.limit_above(Band.GREEN) if math.isfinite(saved) else 0.0


@dataclass(frozen=True)
class RepairStep:
    """The repair of one land, after the steps before it."""

    land: LandDiagnosis
    conditions: tuple[RepairedAt, ...]  # in the order of the diagnosis, the stated one first

    @property
    def for_total(self) -> bool:
        """Tell whether the land is within its limits, and is repaired for the sake of the total alone."""
        return not self.land.verdict.flagged

    @cached_property
    def at(self) -> RepairedAt:
        """Return the condition that the repair helps most, measured by its limit."""
        return max(self.conditions, key=lambda each: each.saving)

    @property
    def helps(self) -> bool:
        """Tell whether the repair lowers the total at any condition."""
        return self.at.saving > 0.0

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
    unmeasured: int  # lands of which a part was not measured and is computed as new
    judged: bool = True  # whether any land was measured: else there is nothing to plan

    @property
    def reached(self) -> bool:
        """Tell whether the plan ends green at every condition."""
        return self.judged and not self.remaining

    @property
    def for_total(self) -> int:
        """Count the steps whose lands are within their limits."""
        return sum(step.for_total for step in self.steps)


def plan_repairs(diagnosis: Diagnosis) -> RepairPlan:
    """Plan the repairs that a diagnosis calls for, over every condition that was judged.

    First come the lands that reached a limit of their own, the worst verdict first; of equal ones that which saves
    most, measured by the limit of the condition at which it saves most. Where totals are still not green, the fewest
    lands within their limits follow that bring each into the best band that repairs can bring it into.
    """
    lands = [land for land in diagnosis.lands if land.state.measured]
    saved = {land.key: _saved_by(land, diagnosis) for land in lands}
    totals = tuple(Total(each, each.leakage, diagnosis.total_rule(each)) for each in diagnosis.projections)

    def saving(land: LandDiagnosis) -> float:
        return max(step.saving for step in _repaired(totals, saved[land.key]))

    flagged = sorted(
        (land for land in lands if land.verdict.flagged), key=lambda land: (-land.verdict.rank, -saving(land))
    )
    steps = _steps(flagged, totals, saved)
    ends = _ends(steps, totals)
    others = [land for land in lands if not land.verdict.flagged and saving(land) > 0.0]
    more = sorted(_best_bands(others, ends, saved), key=lambda land: -saving(land))
    steps = _steps([*flagged, *more], totals, saved)
    ends = _ends(steps, totals)
    return RepairPlan(
        steps=steps,
        ends=ends,
        remaining=tuple(
            _remainder(diagnosis, end, new)
            for end, new in zip(ends, diagnosis.new_projections, strict=True)
            if end.band is not Band.GREEN
        ),
        unmeasured=len(diagnosis.lands) - diagnosis.measured,
        judged=bool(lands),
    )


def _saved_by(land: LandDiagnosis, diagnosis: Diagnosis) -> tuple[float, ...]:
    """Return how much less a land draws from the pump when it is new [m³/s], at every condition."""
    both = zip(diagnosis.projections, diagnosis.new_projections, strict=True)
    return tuple(now.drawn_by(land.key) - new.drawn_by(land.key) for now, new in both)


def _repaired(totals: Iterable[Total], saved: Iterable[float]) -> tuple[RepairedAt, ...]:
    """Return what a repair that saves so much [m³/s] at each condition brings."""
    return tuple(
        RepairedAt(total, Total(total.projection, total.leakage - less, total.rule))
        for total, less in zip(totals, saved, strict=True)
    )


def _steps(
    lands: Iterable[LandDiagnosis], totals: tuple[Total, ...], saved: dict[tuple[str, int], tuple[float, ...]]
) -> tuple[RepairStep, ...]:
    steps: list[RepairStep] = []
    for land in lands:
        steps.append(RepairStep(land, _repaired(_ends(steps, totals), saved[land.key])))
    return tuple(steps)


def _ends(steps: Sequence[RepairStep], totals: tuple[Total, ...]) -> tuple[Total, ...]:
    """Return the totals after the last step."""
    return tuple(each.after for each in steps[-1].conditions) if steps else totals


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
    lands: Sequence[LandDiagnosis], totals: Sequence[Total], saved: dict[tuple[str, int], tuple[float, ...]]
) -> list[LandDiagnosis]:
    """Return the fewest lands whose repair brings every total into the best band that repairs can bring it into."""
    gains: list[list[float]] = [[] for _ in lands]
    needs: list[float] = []
    for number, total in enumerate(totals):
        less = [max(saved[land.key][number], 0.0) for land in lands]
        best = replace(total, leakage=total.leakage - sum(less)).band
        if best is total.band:
            continue
        limit = total.limit_above(best)
        needs.append(total.share / limit - 1.0 + _NEARLY)
        for gain, flow in zip(gains, less, strict=True):
            gain.append(total.projection.share_of(flow) / limit)
    return [lands[number] for number in fewest(gains, needs)]


def fewest(gains: Sequence[Sequence[float]], needs: Sequence[float]) -> list[int]:
    """Return the numbers of the fewest rows whose gains add up to every need.

    Parameters
    ----------
    gains
        one row for each choice, with its gain towards each need.
    needs
        each within what all gains together give.

    Notes
    -----
    The search looks for one row, then two, and so on, the most useful rows first, and leaves out what the largest
    gains that are left could not complete. After twenty thousand steps it gives up and names rows that suffice: each
    time the most useful one, without those that the later ones made needless.

    Examples
    --------
    >>> fewest([[1.0, 0.0], [0.0, 1.0], [0.6, 0.6], [0.3, 0.3]], [1.0, 1.0])
    [0, 1]
    """
    if not needs:
        return []
    order = sorted(range(len(gains)), key=lambda row: -_use(gains[row], needs))
    enough = _enough(order, gains, needs)
    most = [_largest_sums([gains[row][need] for row in order]) for need in range(len(needs))]
    steps = 0

    def search(start: int, count: int, left: list[float]) -> list[int] | None:
        nonlocal steps
        if max(left) <= 0.0:
            return []
        if count == 0:
            return None
        for place in range(start, len(order) - count + 1):
            steps += 1
            if steps > _NODES or any(most[need][place][count] < each for need, each in enumerate(left)):
                return None
            row = order[place]
            rest = search(place + 1, count - 1, [each - gain for each, gain in zip(left, gains[row], strict=True)])
            if rest is not None:
                return [row, *rest]
        return None

    for count in range(1, len(enough)):
        found = search(0, count, list(needs))
        if found is not None:
            return sorted(found)
    return sorted(enough)


def _use(gains: Sequence[float], needs: Sequence[float]) -> float:
    """Return how much of the needs a row serves; a need that is met asks for nothing."""
    return sum(min(gain, need) / need for gain, need in zip(gains, needs, strict=True) if need > 0.0)


def _enough(order: Sequence[int], gains: Sequence[Sequence[float]], needs: Sequence[float]) -> list[int]:
    """Return rows that meet every need, the most useful one each time, without those that are not needed."""
    chosen: list[int] = []
    left = list(needs)
    while max(left) > 0.0 and len(chosen) < len(order):  # floating point may leave a need open with every row chosen
        rest = [row for row in order if row not in chosen]
        uses = [_use(gains[row], left) for row in rest]
        best = rest[uses.index(max(uses))]
        chosen.append(best)
        left = [each - gain for each, gain in zip(left, gains[best], strict=True)]
    for row in reversed(chosen.copy()):
        spare = [each + gain for each, gain in zip(left, gains[row], strict=True)]
        if max(spare) <= 0.0:
            chosen.remove(row)
            left = spare
    return chosen


def _largest_sums(values: Sequence[float]) -> list[list[float]]:
    """Return, for every place, the sums of the 0, 1, 2 … largest values from there on."""
    table = []
    for start in range(len(values) + 1):
        sums = [0.0]
        for value in sorted(values[start:], reverse=True):
            sums.append(sums[-1] + value)
        table.append(sums)
    return table
