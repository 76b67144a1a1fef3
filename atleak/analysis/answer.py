"""Answer the question a rebuilder pays for: which part is it, what to do about it, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any

import numpy as np

from atleak.analysis.repair.options import Cost, cost_of
from atleak.analysis.repair.plan import PumpStep, RepairPlan, RepairStep, plan_repairs
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.missing import PUMP_ROW, Cause, Missing, Row
from atleak.diagnosis.uncertainty.posterior import PosteriorUnit
from atleak.engine.operation import LINE
from atleak.engine.projection import Projection

SURE = 0.9  # probability from which on no further cause is named: choice of this project
_WORTH_NAMING = 0.15  # of what is missing that a further cause explains at least
_LEAST = 0.05  # of what is missing that a land explains, to be repaired for it
_RISK = 0.025  # that a flow has not grown, and lands are named for it
_MOST_NEXT = 3  # lands that are named to be measured next


@dataclass(frozen=True)
class NextMeasurement:
    """A part to be measured next, and how much of what is missing it may explain [Pa]; None where that is not known."""

    component: str  # "pump" for the pump
    land: int | None
    part: str  # spool and sleeve, side or tip clearance
    value: float | None


@dataclass(frozen=True)
class Answer:
    """Which cause explains most of what is missing, or of what is drawn from the pump more than when new."""

    diagnosis: Diagnosis
    cause: Cause
    also: tuple[Cause, ...] = ()  # that these readings cannot tell from it
    missing: Missing | None = None  # the pressure that it is about; None where nothing was computed
    by_flow: bool = False  # no pressure is missing: the causes are those of the pump's growth of demand

    @property
    def amounts(self) -> dict[Row, np.ndarray]:
        """Return what each row explains, in each draw, the most first.

        Pressure [Pa], or flow [m³/s] where no pressure is missing.
        """
        if self.missing is None:
            return {}
        rows = self.missing.split.flows if self.by_flow else self.missing.rows
        return dict(sorted(rows.items(), key=lambda each: -float(np.mean(each[1]))))

    def lands_of(self, row: Row) -> dict[LandKey, np.ndarray]:
        """Return what each land of a row explains, likewise."""
        if self.missing is None:
            return {}
        split = self.missing.split
        lands = (split.flows_of_lands if self.by_flow else split.lands).get(row, {})
        return dict(sorted(lands.items(), key=lambda each: -float(np.mean(each[1]))))

    def total_in(self, missing: Missing) -> np.ndarray:
        """Return what is to be explained of a pressure, in each draw, in the same unit."""
        return missing.split.growth if self.by_flow else missing.missing

    @property
    def total(self) -> np.ndarray:
        return np.zeros(1) if self.missing is None else self.total_in(self.missing)

    @cached_property
    def row(self) -> Row | None:
        """Return the row of the cause that explains most; of flows only where they have surely grown."""
        of_cause = ((row, values) for row, values in self.amounts.items() if row[0] is self.cause)
        surely = ((row, values) for row, values in of_cause if not self.by_flow or np.quantile(values, _RISK) > 0.0)
        return next((row for row, _ in surely), None)

    @property
    def circuit(self) -> str | None:
        """Return the circuit in which the cause lies; None on the line itself, and of the pump."""
        return self.row[1] if self.row else None

    @property
    def land(self) -> LandKey | None:
        """Return the land that explains most, where lands are the cause."""
        return next(iter(self.lands_of(self.row)), None) if self.row else None

    @property
    def condition(self) -> str | None:
        """Return the name of the operating point, or ``road_test`` where a log shows it."""
        if self.missing is None:
            return None
        return "road_test" if self.missing.seconds is not None else self.missing.point.name

    @cached_property
    def probability(self) -> float | None:
        """Return the probability that the cause and what cannot be told from it explain more than half."""
        if self.missing is None or self.total.size < 2:
            return None
        return _more_than_half(self, (self.cause, *self.also))

    @cached_property
    def steps(self) -> tuple[PumpStep | RepairStep, ...]:
        """Return the steps of the repair plan that mend what explains it, a pump past its limits first.

        Where no pressure is missing, lands that can wait are left out.
        """
        if self.missing is None or self.cause in (Cause.UNEXPLAINED, Cause.CLUTCH_SEAL, Cause.NONE):
            return ()
        least = _LEAST * float(np.mean(self.total))
        explain = {row for row, values in self.amounts.items() if float(np.mean(values)) >= least}
        lands = {
            key for row in explain for key, values in self.lands_of(row).items() if float(np.mean(values)) >= least
        }
        pump = [] if self.plan.pump is None else [self.plan.pump]
        waiting = {each.key for each in self.diagnosis.lands if self.by_flow and self.diagnosis.can_wait(each)}
        now = {key for key, each in self.diagnosis.consequences.items() if each is Consequence.NOW}
        named = (lands - waiting) | now
        steps = self.plan.steps
        return (*pump, *(each for each in steps if {each.land.key, *(one.key for one in each.together)} & named))

    @property
    def cost(self) -> Cost | None:
        """Return what those steps cost together; None where the file names no repair for any of them."""
        return cost_of([step.chosen for step in self.steps]) if any(step.options for step in self.steps) else None

    @cached_property
    def plan(self) -> RepairPlan:
        """Return the plan of all repairs."""
        return plan_repairs(self.diagnosis)

    @cached_property
    def next_measurements(self) -> tuple[NextMeasurement, ...]:
        """Return what would make it surer: the pump's clearances, lands that nobody measured."""
        if self.cause is Cause.NONE or self.missing is None or self.missing.doubted:
            return ()
        found = []
        pump = self.diagnosis.controller.pump
        if Cause.PUMP in (self.cause, *self.also) and not pump.measured.any_known:
            of_pump = self.amounts.get(PUMP_ROW)
            value = None if of_pump is None or self.by_flow else float(np.mean(of_pump))
            found = [NextMeasurement("pump", None, part, value) for part in ("side", "tip")]
        open_, split, least = self.diagnosis.open_lands, self.missing.split, _LEAST * float(np.mean(self.total))
        worth = [(key, float(np.mean(each))) for row in split.lands.values() for key, each in row.items()]
        ranked: list[tuple[LandKey, float | None]] = [
            *sorted((each for each in worth if each[0] in open_ and each[1] > least), key=lambda each: -each[1])
        ]
        if not ranked and (self.missing.measured is None or Cause.LANDS in (self.cause, *self.also)):
            ranked = [(key, None) for part in split.path.parts.values() for key in part if key in open_]
        return (*found, *(NextMeasurement(*key, "spool and sleeve", value) for key, value in ranked[:_MOST_NEXT]))


def _more_than_half(answer: Answer, causes: Iterable[Cause]) -> float:
    total = answer.total
    named = set(causes)
    explained = sum((values for (cause, _), values in answer.amounts.items() if cause in named), np.zeros_like(total))
    if Cause.UNEXPLAINED in named and answer.missing is not None and not answer.by_flow:
        explained = explained + answer.missing.unexplained
    return float(np.mean(explained > 0.5 * total))


def answer_of(diagnosis: Diagnosis) -> Answer:
    """Return the answer of a diagnosis.

    Measured pressures that are past a limit lead, the one of which most is missing; then pressures that are past a
    limit by the clearances; then, where no pressure is lost, the growth of what the pump has to deliver.
    """

    def found() -> dict[str, Any]:  # without the diagnosis, which it is kept with
        values = vars(_answer(diagnosis))
        return {each.name: values[each.name] for each in fields(Answer) if each.name != "diagnosis"}

    return Answer(diagnosis, **kept_with(diagnosis, "answer", "", found, most=1))


def _answer(diagnosis: Diagnosis) -> Answer:
    if diagnosis.impossible:
        return Answer(diagnosis, Cause.UNEXPLAINED)
    if diagnosis.decided_by is None:
        return Answer(diagnosis, Cause.NONE)
    flagged = sorted(diagnosis.missing_flagged, key=lambda each: (each.doubted, -_beyond_the_line(diagnosis, each)))
    measured = flagged[0] if flagged else None
    if measured is not None and measured.doubted:
        return Answer(diagnosis, Cause.UNEXPLAINED, missing=measured)
    if measured is not None and _mean(measured) > 0.0:
        return _of_pressure(diagnosis, measured)
    computed = max(_computed(diagnosis), key=_mean, default=None)
    if computed is not None and _mean(computed) > 0.0:
        return _of_pressure(diagnosis, computed)
    if diagnosis.decided_by in diagnosis.vacuum_rules:  # which of the lands is worn, nobody knows
        return Answer(diagnosis, Cause.NONE)
    if not diagnosis.judged:
        return Answer(diagnosis, Cause.UNEXPLAINED, missing=measured)
    return _of_flow(diagnosis)


def _mean(missing: Missing) -> float:
    return float(np.mean(missing.missing))


def _beyond_the_line(diagnosis: Diagnosis, missing: Missing) -> float:
    """Return what is missing of a pressure beyond what the line lacks there, as a gauge shows it [Pa]."""
    line = [each for each in diagnosis.missing_measured if (each.point, each.tap) == (missing.point, LINE)]
    return _mean(missing) - (max(map(_mean, line), default=0.0) if missing.tap != LINE else 0.0)


def _computed(diagnosis: Diagnosis) -> Iterator[Missing]:
    """Yield the pressures that are past a limit by the clearances, and that no gauge shows within it."""
    fine = {(each.point.name, each.tap) for each in diagnosis.missing_measured}
    for rule in diagnosis.pressure_rules:
        tap = rule.circuit.id if rule.circuit else LINE
        if rule.verdict.flagged and rule.condition is not None and (rule.condition.name, tap) not in fine:
            projection = diagnosis.at(rule.condition)
            if not (projection.pressure_falls and (rule.condition.name, LINE) in fine):  # the line holds by its gauge
                yield diagnosis.missing_at(projection, tap)


def _drawn(diagnosis: Diagnosis, projection: Projection, tap: str) -> Missing:
    """Return what is missing of a pressure that nobody measured, with draws of the unit as measured."""
    unit = diagnosis.uncertainty
    if unit is None:
        return diagnosis.missing_at(projection, tap)
    sources = [land.sources for land in unit.lands]
    drawn = PosteriorUnit(diagnosis.model, sources, unit.assumptions, [projection])
    split, best = drawn.split_as_measured(projection.condition, tap), diagnosis.missing_at(projection, tap).split
    return Missing(projection.condition, tap, split, best=best)


def _of_pressure(diagnosis: Diagnosis, missing: Missing) -> Answer:
    if missing.measured is None:
        missing = _drawn(diagnosis, diagnosis.at(missing.point), missing.tap)
    named = [cause for cause in Cause if cause is not Cause.NONE]
    score = {cause: missing.amount(partial(Missing.of, cause=cause)).value for cause in named}
    cause = max(score, key=lambda each: score[each])
    answer = Answer(diagnosis, cause, missing=missing)
    hidden = missing.measured is not None and diagnosis.model.pump_open and cause in (Cause.PUMP, Cause.UNEXPLAINED)
    alike: list[Cause] = []
    if hidden and not diagnosis.told_by_speed(missing):  # a worn pump, its filter and a stuck regulator look alike
        cause, alike = Cause.UNEXPLAINED, [Cause.PUMP]
    near = diagnosis.open_lands.intersection(missing.split.path.nearest)
    if missing.measured is not None and near:  # nor are such lands told apart
        seal = Cause.CLUTCH_SEAL if missing.split.seal_worn else Cause.UNEXPLAINED
        alike.append(seal if cause is Cause.LANDS else Cause.LANDS)
    also = [each for each in alike if each is not cause]
    for other in sorted(score, key=lambda each: -score[each]):
        if _more_than_half(answer, (cause, *also)) >= SURE:
            break
        if other not in (cause, *also) and score[other] >= _WORTH_NAMING * _mean(missing):
            also.append(other)
    return Answer(diagnosis, cause, tuple(also), missing)


def _of_flow(diagnosis: Diagnosis) -> Answer:
    """Return the answer where no pressure is lost: what adds most to the pump's work, where that has grown most."""
    nominal = [diagnosis.missing_at(projection, LINE) for projection in diagnosis.projections]
    capacity = [projection.pump_supply for projection in diagnosis.projections]
    worst = max(range(len(nominal)), key=lambda at: float(nominal[at].split.growth[0]) / capacity[at])
    missing = _drawn(diagnosis, diagnosis.projections[worst], LINE)
    answer = Answer(diagnosis, Cause.LANDS, missing=missing, by_flow=True)
    first = next((row for row, values in answer.amounts.items() if float(np.mean(values)) > 0.0), None)
    return Answer(diagnosis, first[0] if first else Cause.LANDS, missing=missing, by_flow=True)
