"""Say what one visit tells of a unit's wear, and which points of a land lie on one line.

A repair, or another odometer, begins a series anew.
"""

from __future__ import annotations

import datetime as dt
import math
from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from atleak.catalogue.controller import Land
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message
from atleak.common.sentences import Sentence
from atleak.common.units import Quantity
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import WearLine, wear_line
from atleak.diagnosis.uncertainty import LandSources
from atleak.diagnosis.uncertainty.sources import MEASURING_TEMPERATURE_SOURCE


@dataclass(frozen=True)
class Visit:
    """One stay of a unit in the workshop: its mileage, and its lands as they were measured."""

    date: dt.date  # of the measurement
    mileage: float | None  # [km]
    controller: str  # id of the valve body
    lands: tuple[LandSources, ...]  # none where nothing was measured
    repaired: frozenset[LandKey] = frozenset()  # by the record, after they were measured
    name: str = ""  # number of the job, as the workshop knows it

    @classmethod
    def of(
        cls,
        diagnosis: Diagnosis,
        date: dt.date,
        *,
        mileage_km: float | None = None,
        repaired: Iterable[LandKey] = (),
        name: str = "",
    ) -> Visit:
        """Return the visit at which a unit was so diagnosed.

        Parameters
        ----------
        mileage_km
            of the vehicle [km]; as the diagnosis has it unless given.
        repaired
            the lands that were repaired at this visit, after they were measured.
        """
        lands = diagnosis.uncertainty.lands if diagnosis.uncertainty is not None else ()
        return cls(
            date,
            diagnosis.mileage if mileage_km is None else mileage_km,
            diagnosis.controller.id,
            tuple(land.sources for land in lands),
            frozenset(repaired),
            name,
        )

    @property
    def label(self) -> Sentence:
        """Name the visit: ``2026-05-04 (job 1042)``."""
        date = self.date.isoformat()
        return Sentence("{date} (job {job})", date=date, job=self.name) if self.name else Sentence("{date}", date=date)

    def measured(self, key: LandKey) -> LandSources | None:
        """Return a land of which both parts were measured and whose clearance counts; None where they were not."""
        land = self._lands.get(key)
        return land if land is not None and land.state.can_be_ok else None

    @cached_property
    def _lands(self) -> dict[LandKey, LandSources]:
        return {land.key: land for land in self.lands}


@dataclass(frozen=True)
class Visits:
    """The visits of one unit in the order of their dates, and what is to be known about them."""

    visits: tuple[Visit, ...]  # of one valve body
    turned_back: frozenset[int]  # of the visits: those at which the mileage is less than at the one before
    messages: tuple[Message, ...]  # what is to be known about them

    @property
    def present(self) -> float | None:
        """Return the latest mileage [km]; None where no visit states one."""
        return next((visit.mileage for visit in reversed(self.visits) if visit.mileage is not None), None)


def visits_in_order(visits: Sequence[Visit]) -> Visits:
    """Return the visits of one unit in the order of their dates.

    Parameters
    ----------
    visits
        of one day in their order. Those of another valve body than that of the last one are left out; a mileage that
        falls begins a new series, as nobody can tell whether the odometer was changed or a digit is wrong.
    """
    ordered = sorted(visits, key=lambda visit: visit.date)
    kept = [visit for visit in ordered if visit.controller == ordered[-1].controller]
    messages = [
        Message(
            "warning",
            "visit_of_another_valve_body",
            Sentence(
                "The visit of {visit} is left out: its valve body is {controller}, that of the last visit {last}.",
                visit=visit.label,
                controller=visit.controller,
                last=kept[-1].controller,
            ),
        )
        for visit in ordered
        if visit.controller != kept[-1].controller
    ]
    unstated = Sentence("The visit of {visit} states no mileage: its clearances count in no rate of wear.")
    messages += [
        Message("warning", "visit_without_mileage", unstated.of(visit=visit.label))
        for visit in kept
        if visit.mileage is None and visit.lands
    ]
    turned_back = set()
    stated = [(place, visit, visit.mileage) for place, visit in enumerate(kept) if visit.mileage is not None]
    for (_, before, more), (place, after, less) in pairwise(stated):
        if less < more:
            turned_back.add(place)
            text = Sentence(
                "The mileage falls from {more:,.0f} {more.unit} on {before} to {less:,.0f} {less.unit} on {after}: "
                "another odometer, or a slip. No visit before that counts in any rate of wear.",
                more=Quantity(more, "distance"),
                before=before.label,
                less=Quantity(less, "distance"),
                after=after.label,
            )
            messages.append(Message("warning", "mileage_falls", text))
        elif less == more and before.lands and after.lands:
            text = Sentence(
                "{before} and {after} state the same mileage, {mileage:,.0f} {mileage.unit}: together they tell a "
                "clearance better, and no wear between them.",
                before=before.label,
                after=after.label,
                mileage=Quantity(less, "distance"),
            )
            messages.append(Message("info", "mileage_unchanged", text))
    return Visits(tuple(kept), frozenset(turned_back), tuple(messages))


Factors = Mapping[Hashable, float]  # [m] by which one standard deviation of each shared error acts on a clearance


def factors_of(land: LandSources, visit: int) -> Factors:
    """Return the errors that a clearance shares with others; ``visit`` is its number among those of the unit."""
    factors: dict[Hashable, float] = defaultdict(float)
    for source in land.sources:
        if source.group == MEASURING_TEMPERATURE_SOURCE:
            factors[visit, MEASURING_TEMPERATURE_SOURCE] += source.standard_uncertainty
        elif source.group is not None and source.part is not None:
            factors[visit, source.group, land.instruments.of(source.part).id] += source.standard_uncertainty
    return dict(factors)


def covariance(points: Sequence[tuple[Factors, float]]) -> NDArray[np.float64]:
    """Return the covariance of clearances [m²], each with its shared errors and the variance that it has alone."""
    names = {name for factors, _ in points for name in factors}
    shared = np.array([[factors.get(name, 0.0) for name in names] for factors, _ in points])
    alone = np.diag([variance for _, variance in points])
    return alone + shared @ shared.T if names else alone


SURELY_NARROWER = 3.0  # standard uncertainties of the difference of two visits: choice of this project


class Restart(StrEnum):
    """Why a series begins at a later visit than the first."""

    REPAIRED = "repaired"  # by the record of the visit before
    FITTED = "fitted"  # by the sheet, which names a repair that the visit before did not have
    NARROWER = "narrower"  # than at the visit before, by more than measuring can be off
    ODOMETER = "odometer"  # the mileage falls


@dataclass(frozen=True)
class Point:
    """A clearance of a land at one mileage, with the errors that it shares with others."""

    visit: int | None  # its number among those of the unit; None: the mounting clearance
    mileage: float  # [km]
    clearance: float  # [m]
    factors: Factors  # errors of measuring that it shares with other points
    own_variance: float  # [m²]

    @property
    def standard_uncertainty(self) -> float:
        """Return the standard uncertainty of the clearance [m]."""
        return math.sqrt(self.own_variance + math.fsum(factor**2 for factor in self.factors.values()))


@dataclass(frozen=True)
class Series:
    """The points of one land: those that count, in the order of the visits, and those of an earlier series."""

    key: LandKey  # component and land
    land: LandSources | None  # as last measured, if that counts; None where it was repaired since
    counted: tuple[Point, ...]  # in the order of the visits
    earlier: tuple[Point, ...]  # of an earlier series
    restart: Restart | None  # why those do not count
    since: int | None  # number of the visit from which on points count; None: from the first

    @property
    def measured(self) -> tuple[Point, ...]:
        """Return the points that count and were measured at a visit."""
        return tuple(point for point in self.counted if point.visit is not None)

    @property
    def line(self) -> WearLine | None:
        """Return the straight line through the points that count; None through fewer than two mileages."""
        if not self.measured:
            return None
        of_all = covariance([(point.factors, point.own_variance) for point in self.counted])
        return wear_line([point.mileage for point in self.counted], [point.clearance for point in self.counted], of_all)


def series_of(key: LandKey, visits: Visits) -> Series:
    """Return the series of one land over the visits of a unit.

    What counts begins after the last repair, fall of the mileage, or visit at which the land measured narrower than at
    the one before by more than measuring can be off. What the land had at the very beginning counts where it was
    measured: at 0 km, or, of a new part, at the mileage of the repair.
    """
    building = _Building()
    for number, visit in enumerate(visits.visits):
        if number in visits.turned_back:
            building.restart(Restart.ODOMETER, number)
        land = visit.measured(key)
        if land is not None:
            building.add(land, number, visit.mileage)
        if key in visit.repaired:
            building.restart(Restart.REPAIRED, number, visit.mileage)
    counted = tuple(building.points)
    first = _when_new(building)
    return Series(
        key,
        building.last,
        counted if first is None else (first, *counted),
        tuple(building.earlier),
        building.why,
        building.since,
    )


class _Building:
    """A series as far as the visits so far make it."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.earlier: list[Point] = []
        self.last: LandSources | None = None
        self.number: int | None = None  # of the visit at which it was measured last
        self.start: float | None = 0.0  # [km] at which the pair was new; None where that is not known
        self.why: Restart | None = None
        self.since: int | None = None

    def restart(self, why: Restart, number: int, start: float | None = None) -> None:
        self.earlier += self.points
        self.points, self.last, self.number = [], None, None
        self.start, self.why, self.since = start, why, number

    def add(self, land: LandSources, number: int, mileage: float | None) -> None:
        if self.last is not None and self.number is not None:
            if land.state.land.fitted != self.last.state.land.fitted:
                self.restart(Restart.FITTED, number)
            elif self._narrower(self.last, self.number, land, number):
                self.restart(Restart.NARROWER, number)
        self.last, self.number = land, number
        if mileage is not None:
            clearance = land.state.radial_clearance
            self.points.append(Point(number, mileage, clearance, factors_of(land, number), land.own_variance))

    @staticmethod
    def _narrower(before: LandSources, first: int, after: LandSources, second: int) -> bool:
        points = [(factors_of(before, first), before.own_variance), (factors_of(after, second), after.own_variance)]
        of_both = covariance(points)
        u = math.sqrt(max(float(of_both[0, 0] + of_both[1, 1] - 2.0 * of_both[0, 1]), 0.0))
        return after.state.radial_clearance - before.state.radial_clearance < -SURELY_NARROWER * u - 1e-12


def _when_new(building: _Building) -> Point | None:
    """Return the mounting clearance as a point, where it was measured and it is known when the pair was new."""
    if building.last is None or building.start is None:
        return None
    land = building.last.state.land
    if not _known_when_new(land, repaired=building.why is Restart.REPAIRED):
        return None
    return Point(None, building.start, land.new_clearance, {}, building.last.u_mounting**2)


def _known_when_new(land: Land, *, repaired: bool) -> bool:
    """Return whether what a pair had when new was measured: a new part has what its type has, not what the old had."""
    of_this_pair = (land.fitted is not None or land.new_origin is NewOrigin.TYPE) if repaired else land.fitted is None
    return land.mounting_measured and of_this_pair
