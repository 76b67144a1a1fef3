"""Say how fast every land of a unit wears, and at which mileage it reaches its limits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from atleak.catalogue.limits import Limits, RuleKind, reaches
from atleak.errors import Message
from atleak.history.series import Restart, Series, series_of
from atleak.history.visits import Visit, Visits, in_order
from atleak.replace_mileage import NO_RATE
from atleak.rules import LandKey, clearance_limits
from atleak.sentence import Sentence, some
from atleak.uncertainty import LandSources
from atleak.verdicts import Verdict
from atleak.wear_line import Crossing, WearLine

_NAMED = 12  # lands that a message lists


@dataclass(frozen=True)
class LandLimit:
    """A limit of a land's clearance, and the mileage at which it is reached."""

    kind: RuleKind  # of wear, or of the clearance itself
    level: Verdict
    clearance: float  # [m]
    past: bool  # at the last visit
    at: Crossing | None  # None where it is past, or without a line


@dataclass(frozen=True)
class LandWear:
    """The wear of one land over the mileage of its unit."""

    series: Series
    line: WearLine | None
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
    messages: tuple[Message, ...]

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
    ordered = in_order(visits)
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
    return some([f"{component}/{land}" for component, land in (each.key for each in lands)], _NAMED)
