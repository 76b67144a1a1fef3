"""Say how fast every land wears and when it reaches its limits, and what the whole unit will leak at later mileages."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atleak.analysis.history.series import Restart, Series, Visit, Visits, series_of, visits_in_order
from atleak.catalogue.limits import Level, Limits, RuleKind, reaches
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message
from atleak.common.sentences import Sentence, some
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import FARTHEST, MILEAGE_COVERAGE, NO_RATE, Crossing, WearLine
from atleak.diagnosis.messages import LANDS_LISTED
from atleak.diagnosis.rules import clearance_limits
from atleak.diagnosis.uncertainty import LandSources
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import Operation, spread_over
from atleak.engine.projection import repaired


@dataclass(frozen=True)
class LandLimit:
    """A limit of a land's clearance, and the mileage at which it is reached."""

    kind: RuleKind  # of wear, or of the clearance itself
    level: Verdict  # that begins at the limit
    clearance: float  # [m]
    past: bool  # at the last visit
    at: Crossing | None  # None where it is past, or without a line


@dataclass(frozen=True)
class LandWear:
    """The wear of one land over the mileage of its unit."""

    series: Series  # its clearances by mileage
    line: WearLine | None  # None where no rate can be told
    limits: tuple[LandLimit, ...]  # rising; none of a land that was repaired since it was measured

    @property
    def key(self) -> LandKey:
        """Return component and number of the land."""
        return self.series.key

    @property
    def next_limit(self) -> LandLimit | None:
        """Return the next limit that the land has not reached; None past all, or where there is none."""
        return next((limit for limit in self.limits if not limit.past), None)


@dataclass(frozen=True)
class WearHistory:
    """The wear of every land of a unit over its mileage, and what is to be known about it."""

    visits: tuple[Visit, ...]  # in order, of one valve body
    present: float | None  # [km] the latest mileage
    lands: tuple[LandWear, ...]  # those measured at any visit, in the valve body's order
    messages: tuple[Message, ...]  # what is to be known about it

    @property
    def with_rate(self) -> tuple[LandWear, ...]:
        """Return the lands of which the points tell a rate."""
        return tuple(land for land in self.lands if land.line is not None)

    def land(self, key: LandKey) -> LandWear:
        """Return one land by component and number."""
        return next(land for land in self.lands if land.key == key)


def wear_over_mileage(visits: Sequence[Visit], limits: Limits) -> WearHistory:
    """Return how every land of a unit wears over its visits.

    Parameters
    ----------
    visits
        of one unit, in any order; of one day in the order in which they were.
    limits
        of wear and clearance, of which the mileages are looked for.

    Notes
    -----
    A rate and a mileage rest on the uncertainty of measuring alone. Errors that two visits share leave the rate alone.
    """
    ordered = visits_in_order(visits)
    keys = dict.fromkeys(land.key for visit in reversed(ordered.visits) for land in visit.lands)
    every = (series_of(key, ordered) for key in keys)
    lands = tuple(_land(each, ordered, limits) for each in every if each.counted or each.earlier or each.land)
    return WearHistory(ordered.visits, ordered.present, lands, (*ordered.messages, *_messages(lands, ordered)))


def _land(series: Series, visits: Visits, limits: Limits) -> LandWear:
    line, present, found = series.line, visits.present, []
    if series.land is not None:
        now = series.land.state.radial_clearance
        for kind, level, limit in _limits(series.land, limits):
            past = reaches(now, limit)
            at = None if past or line is None or present is None else line.reaches(limit, present)
            found.append(LandLimit(kind, level, limit, past, at))
    return LandWear(series, line, tuple(sorted(found, key=lambda each: each.clearance)))


def _limits(land: LandSources, limits: Limits) -> Iterator[tuple[RuleKind, Verdict, float]]:
    """Yield every limit of a land's clearance [m], that of its wear over the mounting clearance included."""
    pair = land.state.land
    if limits.wear is not None:
        for level, fraction in limits.wear.of_wear(pair.mounting_high, pair.mounting_tolerance or 0.0):
            yield RuleKind.WEAR, Verdict(level), (1.0 + fraction) * pair.mounting_high
    steps = clearance_limits(land.state, limits)
    for level, limit in () if steps is None else steps.levels:
        yield RuleKind.CLEARANCE, Verdict(level), limit


def _messages(lands: Sequence[LandWear], visits: Visits) -> Iterator[Message]:
    without = [land for land in lands if land.line is None]
    if without:
        text = Sentence(
            "{count} of {lands} measured lands tell a rate of wear: it takes two visits with their mileages since the "
            "last repair, or one visit and a mounting clearance that was measured.",
            count=len(lands) - len(without),
            lands=len(lands),
        )
        yield Message("info", NO_RATE, text)
    yield from _restarts(lands, visits)
    bent = [land for land in lands if land.line is not None and not land.line.straight]
    if bent:
        text = Sentence(
            "The clearance of {lands} does not grow in a straight line: measuring does not explain how its points "
            "scatter, so its intervals are widened by as much. Wear that grows faster is of the last visits.",
            lands=_listed(bent),
        )
        yield Message("warning", "wear_not_straight", text)


def _restarts(lands: Sequence[LandWear], visits: Visits) -> Iterator[Message]:
    for why in _BEGINS:
        numbers = {land.series.since for land in lands if land.series.restart is why}
        for number in sorted(number for number in numbers if number is not None):
            at = [land for land in lands if land.series.restart is why and land.series.since == number]
            text = _BEGINS[why].of(lands=_listed(at), visit=visits.visits[number].label)
            yield Message("warning" if why is Restart.NARROWER else "info", f"series_{why}", text)


_BEGINS = {
    Restart.REPAIRED: Sentence("{lands} repaired at the visit of {visit}: the series begins there."),
    Restart.FITTED: Sentence("{lands} another part since the visit of {visit}: the series begins there."),
    Restart.NARROWER: Sentence(
        "{lands} measured narrower at the visit of {visit} than at the one before, by more than measuring can be off: "
        "a repair that no record names, or a slip. The series begins there."
    ),
}


def _listed(lands: Iterable[LandWear]) -> Sentence:
    return some([f"{component}/{land}" for component, land in (each.key for each in lands)], LANDS_LISTED)


_AHEAD = 200_000.0  # [km] over which totals are foreseen: choice of this project
_STEPS = 12  # of that way
_DRAWS = 1000
_SEED = 7667

_Draws = NDArray[np.float64]


@dataclass(frozen=True)
class TotalLimit:
    """A limit of the total share, and the mileage at which it is reached."""

    level: Level  # that begins at the limit
    share: float  # a fraction
    past: bool  # at the last visit
    at: Crossing | None  # None where it is past


@dataclass(frozen=True)
class TotalOverMileage:
    """The total share at one condition over mileage: median and interval by what measuring leaves open."""

    condition: OperatingPoint  # at which the total is computed
    mileages: tuple[float, ...]  # [km] from the last visit on
    low: tuple[float, ...]  # a fraction, as the others
    median: tuple[float, ...]  # of the share, a fraction, at each mileage
    high: tuple[float, ...]  # upper end of the interval
    limits: tuple[TotalLimit, ...]  # of the share, in their order


@dataclass(frozen=True)
class TotalsOverMileage:
    """The totals at every condition that is judged; none where no land tells a rate of wear."""

    totals: tuple[TotalOverMileage, ...]  # one for each condition
    growing: int  # lands that follow their own line
    lands: int  # of the valve body: the others stay as they are
    messages: tuple[Message, ...]  # what is to be known about them


def totals_over_mileage(history: WearHistory, diagnosis: Diagnosis) -> TotalsOverMileage:
    """Foresee the total share at every condition.

    Parameters
    ----------
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
    mileages = np.linspace(present, min(present + _AHEAD, max(FARTHEST, present + 1.0)), _STEPS + 1)
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
    history: WearHistory, mileages: Sequence[float] | _Draws, draws: int = _DRAWS
) -> dict[LandKey, _Draws]:
    """Draw the clearance of every land that was measured at some mileages [m], each of shape (draws, mileages).

    Clearances of one draw err together, as far as they share what errs. None is below zero.
    """
    at = np.asarray(mileages, float)
    stream = np.random.Generator(np.random.PCG64(_SEED))
    shared: dict[Hashable, _Draws] = defaultdict(lambda: stream.standard_normal(draws))
    drawn = {}
    for land in history.lands:
        clearances = _drawn(land, at, draws, stream, shared)
        if clearances is not None:
            drawn[land.key] = np.maximum(clearances, 0.0)
    return drawn


def _drawn(
    land: LandWear, at: _Draws, draws: int, stream: np.random.Generator, shared: Mapping[Hashable, _Draws]
) -> _Draws | None:
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


def _worn(diagnosis: Diagnosis, drawn: Mapping[LandKey, _Draws]) -> LeakageModel:
    """Return the model with arrays of clearances, all draws and mileages in one row; a land without any is new."""
    others = [land.key for land in diagnosis.lands if land.key not in drawn]
    clearances: list[Any] = []
    for state in repaired((land.state for land in diagnosis.lands), others):
        cold: Any = drawn[state.land.key].ravel() if state.land.key in drawn else state.radial_clearance
        clearances.append(replace(state, radial_clearance=cold))
    return replace(diagnosis.model, clearances=tuple(clearances))


def _total(diagnosis: Diagnosis, model: LeakageModel, place: int, mileages: _Draws) -> TotalOverMileage:
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


_PARTS = (0.5 - 0.5 * MILEAGE_COVERAGE, 0.5, 0.5 + 0.5 * MILEAGE_COVERAGE)


def _reached(share: _Draws, limit: float, mileages: _Draws) -> Crossing:
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
