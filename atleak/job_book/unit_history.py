"""Look at a unit over its visits and among all units of its valve body: what became of its repairs, and how it stands.

Across units the latest job with a measuring sheet counts of each, as the result stored with it has it; archived jobs
and the shipped sample do not, and units that were merged are one. The database counts lands in steps of `_STEP`, so
that a book of 50 000 jobs gives back some thousand numbers instead of millions.
"""

from __future__ import annotations

import datetime as dt
import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import sqlalchemy as sa

from atleak.analysis.history.series import Visit
from atleak.analysis.rates import ENOUGH_UNITS, SHOWN_QUANTILES
from atleak.analysis.record_doubts import covered, repaired_lands
from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import AtleakError
from atleak.common.sentences import Sentence
from atleak.common.verdicts import FLAGGED
from atleak.diagnosis.uncertainty import LandSources
from atleak.job.case import SLOTS, Reader
from atleak.job_book.book import Book, StoredJob
from atleak.job_book.search import Query
from atleak.job_book.tables import decisions, jobs, lands, visits
from atleak.job_book.units import final_unit
from atleak.measurements.job_card import RepairDecision, RepairState

_STEP = 0.1  # [µm] in which clearances are counted, well under what any gauge tells: choice of this project


@dataclass(frozen=True)
class LandAcross:
    """One land over all units of a valve body, each as it was measured last."""

    key: LandKey
    units: int  # that were measured
    flagged: int  # of them at *watch* or past it
    clearances: tuple[float, ...]  # [m] at `SHOWN_QUANTILES` of the units
    wear: tuple[float, ...]  # a fraction, at `SHOWN_QUANTILES` of the units; from each unit's own mounting clearance
    counted: tuple[tuple[float, int], ...] = field(repr=False)  # clearance [m] and units, rising


@dataclass(frozen=True)
class ReplacedPair:
    """A pair that was repaired, and in how many units."""

    component: str
    land: int | None  # None where the record names the component alone
    units: int

    @property
    def name(self) -> str:
        """Name it by component and land, or by the component alone."""
        return self.component if self.land is None else f"{self.component}/{self.land}"


@dataclass(frozen=True)
class AcrossUnits:
    """All units of one valve body."""

    controller: str  # id
    units: int
    lands: tuple[LandAcross, ...]
    replaced: tuple[ReplacedPair, ...]  # the most often repaired first

    @property
    def flagged(self) -> tuple[LandAcross, ...]:
        """Return the lands that are flagged in any unit, the most often flagged first."""
        return tuple(sorted((land for land in self.lands if land.flagged), key=lambda land: (-land.flagged, land.key)))


@dataclass(frozen=True)
class Standing:
    """The place of one unit's land among those of its kind."""

    key: LandKey
    clearance: float  # [m]
    narrower: int  # of the other units
    as_wide: int  # within a step
    others: int

    @property
    def enough(self) -> bool:
        """Return whether there are enough units to say where this one stands."""
        return self.others >= ENOUGH_UNITS

    @property
    def part(self) -> float:
        """Return the part of the other units that are narrower, those as wide counted half."""
        return (self.narrower + 0.5 * self.as_wide) / self.others if self.others else math.nan


def day_of_job() -> sa.ColumnElement[Any]:
    """Return the day of a job as a column: as its record states it, else that on which it was first saved."""
    return sa.func.coalesce(jobs.c.date, jobs.c.made_on)


def measured_jobs(controller: str) -> tuple[sa.ColumnElement[bool], ...]:
    """Return the conditions of a job that counts among those of a valve body: measured, not archived, no sample."""
    measured = sa.exists().where(lands.c.job == jobs.c.id, lands.c.measured)
    return (*_counting(controller), measured)


def _counting(controller: str) -> tuple[sa.ColumnElement[bool], ...]:
    return jobs.c.controller == controller, jobs.c.archived_at.is_(None), ~jobs.c.sample


def latest_jobs(controller: str) -> sa.Subquery:
    """Return the latest job with a measuring sheet of every unit of a valve body: columns ``job`` and ``unit``."""
    newest = (day_of_job().desc(), jobs.c.made_at.desc(), jobs.c.id.desc())
    place = sa.func.row_number().over(partition_by=final_unit(), order_by=newest)
    counting = (
        sa.select(jobs.c.id.label("job"), final_unit().label("unit"), place.label("place"))
        .join(visits, visits.c.id == jobs.c.visit)
        .where(*measured_jobs(controller))
        .subquery()
    )
    return sa.select(counting.c.job, counting.c.unit).where(counting.c.place == 1).subquery()


def across_units(book: Book, controller: str) -> AcrossUnits:
    """Return how wide the lands of all units of one valve body are, and what was flagged and replaced in them.

    Raises
    ------
    BookError
        where the database cannot be used.
    """
    latest = latest_jobs(controller)
    step = sa.func.round(lands.c.radial_clearance_um / _STEP)
    over = sa.case((lands.c.verdict.in_([str(level) for level in FLAGGED]), 1), else_=0)
    group = (lands.c.component, lands.c.land, step, lands.c.mounting_clearance_um)
    counting = (
        sa.select(*group, sa.func.count(), sa.func.sum(over))
        .join(latest, latest.c.job == lands.c.job)
        .where(lands.c.measured)
        .group_by(*group)
    )
    with book.reading() as connection:
        units = connection.execute(sa.select(sa.func.count()).select_from(latest)).scalar_one()
        counted = connection.execute(counting).all()
        replaced = connection.execute(_replaced(controller)).all()
    by_land: dict[LandKey, list[Sequence[Any]]] = defaultdict(list)
    for component, land, *rest in counted:
        by_land[component, land].append(rest)
    return AcrossUnits(
        controller,
        int(units),
        tuple(_land(key, rows) for key, rows in sorted(by_land.items())),
        tuple(ReplacedPair(*row) for row in replaced),
    )


def _land(key: LandKey, rows: Iterable[Sequence[Any]]) -> LandAcross:
    clearances: dict[float, int] = defaultdict(int)
    wear: dict[float, int] = defaultdict(int)
    flagged = 0
    for steps, mounting, count, over in rows:
        clearance = float(steps) * _STEP
        clearances[clearance * 1e-6] += count
        wear[clearance / mounting - 1.0] += count
        flagged += over
    counted = tuple(sorted(clearances.items()))
    units = sum(clearances.values())
    return LandAcross(key, units, flagged, _quantiles(counted), _quantiles(sorted(wear.items())), counted)


def _quantiles(counted: Sequence[tuple[float, int]]) -> tuple[float, ...]:
    """Return the values at `SHOWN_QUANTILES` of what was counted, each value with how often it is there, rising."""
    total = sum(count for _, count in counted)
    found, passed, place = [], 0, 0
    for part in SHOWN_QUANTILES:
        while place < len(counted) - 1 and passed + counted[place][1] < part * total:
            passed += counted[place][1]
            place += 1
        found.append(counted[place][0])
    return tuple(found)


def _replaced(controller: str) -> sa.Select[Any]:
    """Count the units in which each pair was repaired, over all their jobs."""
    units = sa.func.count(final_unit().distinct())
    return (
        sa.select(decisions.c.component, decisions.c.land, units.label("units"))
        .join(jobs, jobs.c.id == decisions.c.job)
        .join(visits, visits.c.id == jobs.c.visit)
        .where(*_counting(controller), decisions.c.decision == "done")
        .group_by(decisions.c.component, decisions.c.land)
        .order_by(units.desc(), decisions.c.component, decisions.c.land)
    )


def standing(book: Book, across: AcrossUnits, unit: int) -> tuple[Standing, ...]:
    """Return where the lands of one unit stand among those of all units of its valve body, the widest place first.

    Raises
    ------
    BookError
        where the database cannot be used.
    """
    latest = latest_jobs(across.controller)
    wanted = (
        sa.select(lands.c.component, lands.c.land, sa.func.round(lands.c.radial_clearance_um / _STEP))
        .join(latest, latest.c.job == lands.c.job)
        .where(latest.c.unit == unit, lands.c.measured)
    )
    with book.reading() as connection:
        own = {(component, land): float(steps) * _STEP * 1e-6 for component, land, steps in connection.execute(wanted)}
    places = (_standing(land, own[land.key]) for land in across.lands if land.key in own)
    return tuple(sorted(places, key=lambda each: -each.part))


def _standing(land: LandAcross, clearance: float) -> Standing:
    narrower = sum(count for each, count in land.counted if each < clearance - 1e-12)
    as_wide = sum(count for each, count in land.counted if abs(each - clearance) <= 1e-12)
    return Standing(land.key, clearance, narrower, max(as_wide - 1, 0), land.units - 1)  # itself is one of them


@dataclass(frozen=True)
class VisitedJob:
    """A job of a unit, and what its sheet tells of wear."""

    stored: StoredJob
    controller: Controller | None  # None where its file cannot be used any more
    visit: Visit  # without lands where nothing was measured, or the sheet cannot be read any more
    problem: Sentence  # why it cannot or does not count; "" where it does

    @property
    def date(self) -> dt.date:
        """Return the day on which the unit was there, as far as anybody wrote it down."""
        return self.visit.date

    @property
    def decisions(self) -> tuple[RepairDecision, ...]:
        """Return what the record says about repairs."""
        return self.stored.file.job.repair_decisions

    def decided(self, state: RepairState) -> tuple[RepairDecision, ...]:
        """Return the repairs of which the record says that."""
        return tuple(each for each in self.decisions if each.decision == state)

    def covered(self, decision: RepairDecision) -> frozenset[LandKey]:
        """Return the lands that a decision is about; what names no land of the valve body stands for itself."""
        lands = frozenset() if self.controller is None else covered(decision, self.controller)
        return lands or frozenset({(decision.component, decision.land or 0)})


def unit_of_visit(book: Book, job: str) -> int | None:
    """Return the unit that a job of the book is about; None where the book does not have the job."""
    wanted = sa.select(final_unit()).join(jobs, jobs.c.visit == visits.c.id).where(jobs.c.id == job)
    with book.reading() as connection:
        unit = connection.execute(wanted).scalar()
    return None if unit is None else int(unit)


def visits_of_unit(book: Book, unit: int, loader: Reader | None = None) -> tuple[VisitedJob, ...]:
    """Return the jobs of a unit that are not archived, the earliest first.

    Parameters
    ----------
    unit
        as `JobRow.unit` names it; jobs of units that were merged into it are among them.

    Raises
    ------
    BookError
        where the database cannot be used.
    """
    stored = [(book.load(row.id), row.mileage_km) for row in book.rows(Query(unit=unit, limit=None))]
    found = sorted(
        (_visited(*each, loader or Reader()) for each in stored), key=lambda each: (each.date, each.stored.made_at)
    )
    sheets: dict[str, str] = {}
    for number, each in enumerate(found):
        sheet = each.stored.file.case.readings
        if sheet is not None and each.visit.lands:
            first = sheets.setdefault(sheet.sha256, each.stored.id)
            if first != each.stored.id:  # one measurement, which would count as two
                again = Sentence("its measuring sheet is that of job {id}, and counts once", id=first)
                found[number] = replace(each, visit=replace(each.visit, lands=()), problem=again)
    return tuple(found)


def _visited(stored: StoredJob, mileage: float | None, loader: Reader) -> VisitedJob:
    job, case = stored.file.job, stored.file.case
    controller: Controller | None = None
    lands: tuple[LandSources, ...] = ()
    problem = Sentence("")
    try:
        controller = loader.entry(SLOTS["controller"], case.controller)
        lands = case.measured(loader)
    except AtleakError as error:
        problem = error.sentence
    visit = Visit(
        job.date or stored.made_on or stored.made_at.date(),
        mileage,
        str(stored.file.result["controller"]["id"]),
        lands,
        repaired=frozenset() if controller is None else repaired_lands(job, controller),
        name=job.number,
    )
    return VisitedJob(stored, controller, visit, problem)


def left_undone(visited: Sequence[VisitedJob]) -> tuple[tuple[VisitedJob, RepairDecision], ...]:
    """Return the repairs that were declined or deferred last, and neither approved nor done since, the latest first."""
    undone: list[tuple[VisitedJob, RepairDecision, frozenset[LandKey]]] = []
    for each in visited:
        for decision in each.decisions:
            if decision.decision in (None, "proposed"):
                continue
            lands = each.covered(decision)
            undone = [(job, earlier, left - lands) for job, earlier, left in undone if left - lands]
            if decision.decision in ("declined", "deferred"):
                undone.append((each, decision, lands))
    return tuple((job, decision) for job, decision, _ in reversed(undone))
