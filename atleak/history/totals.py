"""Foresee what the whole unit leaks at later mileages: every land at its own line, through the engine."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atleak.catalogue.limits import Level, reaches
from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis import Diagnosis
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import Operation, spread_over
from atleak.engine.projection import repaired
from atleak.errors import Message
from atleak.history.land_wear import LandWear, WearHistory
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.wear_line import COVERAGE, FARTHEST, Crossing

AHEAD = 200_000.0  # [km] over which totals are foreseen: choice of this project
_STEPS = 12  # of that way
_DRAWS = 1000
_SEED = 7667

Draws = NDArray[np.float64]


@dataclass(frozen=True)
class TotalLimit:
    """A limit of the total share, and the mileage at which it is reached."""

    level: Level
    share: float  # a fraction
    past: bool  # at the last visit
    at: Crossing | None  # None where it is past


@dataclass(frozen=True)
class TotalOverMileage:
    """The total share at one condition over mileage: median and interval by what measuring leaves open."""

    condition: OperatingPoint
    mileages: tuple[float, ...]  # [km] from the last visit on
    low: tuple[float, ...]  # a fraction, as the others
    median: tuple[float, ...]
    high: tuple[float, ...]
    limits: tuple[TotalLimit, ...]


@dataclass(frozen=True)
class TotalsOverMileage:
    """The totals at every condition that is judged; none where no land tells a rate of wear."""

    totals: tuple[TotalOverMileage, ...]
    growing: int  # lands that follow their own line
    lands: int  # of the valve body: the others stay as they are
    messages: tuple[Message, ...]


def totals_over_mileage(history: WearHistory, diagnosis: Diagnosis) -> TotalsOverMileage:
    """Foresee the total share at every condition.

    Parameters
    ----------
    history
        of the unit.
    diagnosis
        of its last visit: its fluid, pressures, pump and limits are taken as they are.

    Notes
    -----
    The lines of all lands are drawn together, with the errors of measuring that lands and visits share. A land without
    a rate stays as it was measured, one that was repaired since or was never measured is as a new one. A drawn rate may
    be below zero: what measuring leaves open goes both ways, and one-sided draws would add up to wear that nobody saw.
    """
    present, growing = history.present, len(history.with_rate)
    lands = len(diagnosis.controller.lands)
    if present is None or not growing or not diagnosis.judged:
        return TotalsOverMileage((), growing, lands, ())
    mileages = np.linspace(present, min(present + AHEAD, max(FARTHEST, present + 1.0)), _STEPS + 1)
    model = _worn(diagnosis, drawn_clearances(history, mileages))
    totals = tuple(_total(diagnosis, model, place, mileages) for place in range(len(diagnosis.projections)))
    text = Sentence(
        "{count} of {lands} lands have no rate of wear and stay as they are in the totals over mileage: what they will "
        "wear comes on top.",
        count=lands - growing,
        lands=lands,
    )
    messages = () if growing == lands else (Message("info", "lands_without_rate", text),)
    return TotalsOverMileage(totals, growing, lands, messages)


def drawn_clearances(
    history: WearHistory, mileages: Sequence[float] | Draws, draws: int = _DRAWS
) -> dict[LandKey, Draws]:
    """Draw the clearance of every land that was measured at some mileages [m], each of shape (draws, mileages).

    Clearances of one draw err together, as far as they share what errs. None is below zero.
    """
    at = np.asarray(mileages, float)
    stream = np.random.Generator(np.random.PCG64(_SEED))
    shared: dict[Hashable, Draws] = defaultdict(lambda: stream.standard_normal(draws))
    drawn = {}
    for land in history.lands:
        clearances = _drawn(land, at, draws, stream, shared)
        if clearances is not None:
            drawn[land.key] = np.maximum(clearances, 0.0)
    return drawn


def _drawn(
    land: LandWear, at: Draws, draws: int, stream: np.random.Generator, shared: Mapping[Hashable, Draws]
) -> Draws | None:
    errors = []
    for point in land.series.counted:
        error = np.sqrt(point.own_variance) * stream.standard_normal(draws)
        for name, factor in point.factors.items():
            error += factor * shared[name]
        errors.append(error)
    if land.line is not None:
        line = land.line
        moved = line.scatter * (line.weights @ np.array(errors))  # of clearance and rate, shape (2, draws)
        way = at - line.origin
        return (line.clearance - moved[0])[:, None] + (line.rate - moved[1])[:, None] * way
    if land.series.measured:
        return np.repeat((land.series.counted[-1].clearance - errors[-1])[:, None], at.size, axis=1)
    return None


def _worn(diagnosis: Diagnosis, drawn: Mapping[LandKey, Draws]) -> LeakageModel:
    """Return the model with arrays of clearances, all draws and mileages in one row; a land without any is new."""
    others = [land.key for land in diagnosis.lands if land.key not in drawn]
    clearances: list[Any] = []
    for state in repaired((land.state for land in diagnosis.lands), others):
        cold: Any = drawn[state.land.key].ravel() if state.land.key in drawn else state.radial_clearance
        clearances.append(replace(state, radial_clearance=cold))
    return replace(diagnosis.model, clearances=tuple(clearances))


def _total(diagnosis: Diagnosis, model: LeakageModel, place: int, mileages: Draws) -> TotalOverMileage:
    now = diagnosis.projections[place]
    flows = spread_over(Operation.of(model, now.condition).leakage, (_DRAWS * mileages.size,))
    flows = flows.reshape(_DRAWS, mileages.size)
    share = flows / now.pump_capacity if now.pump_capacity > 0.0 else np.full(flows.shape, np.inf)
    low, median, high = np.quantile(share, _PARTS, axis=0)
    rule = diagnosis.total_rule(now)
    limits = []
    for level, limit in rule.steps.levels:
        past = reaches(rule.value, limit)
        limits.append(TotalLimit(level, limit, past, None if past else _reached(share, limit, mileages)))
    return TotalOverMileage(
        now.condition,
        tuple(mileages.tolist()),
        low=tuple(low.tolist()),
        median=tuple(median.tolist()),
        high=tuple(high.tolist()),
        limits=tuple(limits),
    )


_PARTS = (0.5 - 0.5 * COVERAGE, 0.5, 0.5 + 0.5 * COVERAGE)


def _reached(share: Draws, limit: float, mileages: Draws) -> Crossing:
    """Return at which mileage the draws reach a limit; what is not reached over the way ahead is not foreseen."""
    over = share >= limit
    first = np.argmax(over, axis=1)
    rows = np.arange(len(share))
    before = np.maximum(first - 1, 0)
    below, above = share[rows, before], share[rows, first]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(first > 0, (limit - below) / (above - below), 0.0)
    reached = mileages[before] + part * (mileages[first] - mileages[before])
    reached = np.sort(np.where(over.any(axis=1), reached, np.inf))
    low, median, high = (float(reached[round(part * (reached.size - 1))]) for part in _PARTS)
    return Crossing(median, min(low, float(mileages[-1])), high, float(mileages[0]))
