"""Compute a unit whose lands are repaired one way or another, and judge what it then does at every condition."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import BANDS, Band
from atleak.diagnosis.consequence import JudgedTotal
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.operation import WORTH_NAMING, LandStates, Repaired
from atleak.engine.projection import Projection
from atleak.measurements.clearances import LandClearance

LandChoice = Mapping[LandKey, int]  # the state of each land by its number; as measured where it is not named

NEARLY = 1e-8  # relative: a value must be within its limit by more than floating point can tell


@dataclass(frozen=True)
class Total:
    """The total at one condition with some lands repaired, judged by the rule of that condition."""

    total: JudgedTotal  # as measured
    others: tuple[JudgedTotal, ...]  # reserve and pressures
    leakage: float  # [m³/s] drawn from the pump
    pressures: Mapping[str, float]  # [Pa] that the line, as p_g, and every circuit hold
    repaired: bool  # whether any land was

    @property
    def projection(self) -> Projection:
        """Return the projection as measured."""
        return self.total.projection

    @property
    def condition(self) -> OperatingPoint:
        """Return the condition."""
        return self.projection.condition

    @cached_property
    def rule(self) -> Rule:
        """Return the rule of the total, judged anew."""
        return self.total.after(self.leakage, self.pressures, repaired=self.repaired)

    @property
    def share(self) -> float:
        """Return leakage / pump capacity; infinite where the pump delivers nothing."""
        return self.rule.value

    @property
    def reserve(self) -> float:
        """Return the pump's reserve."""
        return replace(self.projection, leakage=self.leakage).reserve

    @cached_property
    def pressure_rules(self) -> tuple[Rule, ...]:
        """Return the rules of reserve, circuits and permissible pressure, judged anew."""
        return tuple(each.after(self.leakage, self.pressures, repaired=self.repaired) for each in self.others)

    @property
    def past(self) -> tuple[Rule, ...]:
        """Return every rule, the total's first, that is past a limit."""
        return tuple(rule for rule in (self.rule, *self.pressure_rules) if rule.verdict.flagged)

    @property
    def band(self) -> Band:
        """Return the band that the share has reached."""
        return Band(self.rule.level)

    def limit_above(self, band: Band) -> float:
        """Return the share at which a band ends: the lowest limit of those that are worse."""
        return min(limit for level, limit in self.rule.steps.levels if BANDS.index(Band(level)) > BANDS.index(band))


@dataclass(frozen=True)
class RepairedAt:
    """What one repair brings at one condition."""

    before: Total  # the total before it, with the steps before it done
    after: Total  # the total with it

    @property
    def condition(self) -> OperatingPoint:
        """Return the condition."""
        return self.before.condition

    @property
    def saving(self) -> float:
        """Return the share that is saved over the share at which green ends: so that conditions can be compared."""
        saved = self.before.share - self.after.share
        if abs(saved) <= NEARLY * self.before.share:  # what rounding leaves of nothing
            return 0.0
        return saved / self.before.limit_above(Band.GREEN) if math.isfinite(saved) else 0.0

    @property
    def gained(self) -> float:
        """Return the pressure that the line, or the circuit that gains most by the repair, gains [Pa]."""
        both = self.before.pressures, self.after.pressures
        gain = max(both[1][name] - both[0][name] for name in both[0])
        return gain if gain >= WORTH_NAMING else 0.0


class RepairableUnit:
    """A diagnosed unit of which each land is as measured, state 0, or as one of several repairs leaves it.

    ``states`` holds the further states of each land, the first of them with the number 1.
    """

    def __init__(self, diagnosis: Diagnosis, states: Mapping[LandKey, Sequence[LandClearance]]) -> None:
        self.controller, self.states = diagnosis.controller, states
        self.judged = tuple(JudgedTotal.all_at(diagnosis, each) for each in diagnosis.projections)
        """The rules of every condition, that of its total first."""
        model = diagnosis.model
        models = [model]
        for number in range(max(map(len, states.values()), default=0)):
            clearances = (
                states[each.land.key][number] if number < len(states.get(each.land.key, ())) else each
                for each in model.clearances
            )
            models.append(replace(model, clearances=tuple(clearances)))
        self._models = models

    @cached_property
    def conditions(self) -> tuple[LandStates, ...]:
        """Return the unit at every condition, the stated one first."""
        return tuple(LandStates.of(self._models, total.projection.condition) for total, *_ in self.judged)

    def repaired(self, choices: Sequence[LandChoice]) -> list[Repaired]:
        """Compute every condition for several choices at once."""
        return [at.repaired(choices) for at in self.conditions]

    def totals(self, choices: Sequence[LandChoice]) -> list[tuple[Total, ...]]:
        """Return the totals at every condition, the stated one first, for each of several choices."""
        at_conditions = list(zip(self.judged, self.repaired(choices), strict=True))
        return [
            tuple(
                Total(
                    total,
                    tuple(others),
                    float(done.leakage[number]),
                    {name: float(pressure[number]) for name, pressure in done.pressures.items()},
                    repaired=bool(choices[number]),
                )
                for (total, *others), done in at_conditions
            )
            for number in range(len(choices))
        ]
