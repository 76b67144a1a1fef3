"""Turn the jobs of one unit into visits, and say what became of the repairs that were proposed at each."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from atleak.errors import AtleakError
from atleak.history.visits import Visit
from atleak.job.case import SLOTS, Case, Reader
from atleak.job.decisions import covered, repaired_lands
from atleak.job.record import RepairDecision, RepairState
from atleak.jobs.book import Book, StoredJob
from atleak.jobs.search import Query
from atleak.jobs.tables import jobs, visits
from atleak.jobs.units import final_unit
from atleak.rules import LandKey
from atleak.uncertainty import LandSources

MeasuredOf = Callable[[Case], tuple[LandSources, ...]]


@dataclass(frozen=True)
class VisitedJob:
    """A job of a unit, and what its sheet tells of wear."""

    stored: StoredJob
    visit: Visit  # without lands where nothing was measured, or the sheet cannot be read any more
    problem: str  # why it cannot; "" where it can
    decisions: tuple[tuple[RepairDecision, frozenset[LandKey]], ...] = ()  # each with the lands that it covers

    @property
    def date(self) -> dt.date:
        """Return the day on which the unit was there, as far as anybody wrote it down."""
        return self.visit.date

    def decided(self, state: RepairState) -> tuple[RepairDecision, ...]:
        """Return the repairs of which the record says that."""
        return tuple(each for each, _ in self.decisions if each.decision == state)


def unit_of_job(book: Book, job: str) -> int | None:
    """Return the unit that a job of the book is about; None where the book does not have the job."""
    wanted = sa.select(final_unit()).join(jobs, jobs.c.visit == visits.c.id).where(jobs.c.id == job)
    with book.reading() as connection:
        unit = connection.execute(wanted).scalar()
    return None if unit is None else int(unit)


def visits_of_unit(book: Book, unit: int, measured: MeasuredOf = Case.measured) -> tuple[VisitedJob, ...]:
    """Return the jobs of a unit that are not archived, the earliest first.

    Parameters
    ----------
    unit
        as `JobRow.unit` names it; jobs of units that were merged into it are among them.
    measured
        gives what the sheet of a case says of its lands; a caller may keep what it has read.

    Raises
    ------
    BookError
        where the database cannot be used.
    """
    stored = [book.load(row.id) for row in book.rows(Query(unit=unit, limit=None))]
    found = [_visited(each, measured) for each in stored]
    return tuple(sorted(found, key=lambda each: (each.date, each.stored.made_at)))


def _visited(stored: StoredJob, measured: MeasuredOf) -> VisitedJob:
    job, case = stored.file.job, stored.file.case
    lands: tuple[LandSources, ...] = ()
    repaired: frozenset[LandKey] = frozenset()
    decisions = tuple((each, frozenset[LandKey]()) for each in job.repair_decisions)
    problem = ""
    try:
        if decisions:
            controller = Reader().entry(SLOTS["controller"], case.controller)
            repaired = repaired_lands(job, controller)
            decisions = tuple((each, covered(each, controller)) for each in job.repair_decisions)
        lands = measured(case)
    except AtleakError as error:
        problem = str(error)
    visit = Visit(
        job.date or stored.made_at.date(),
        job.vehicle.mileage_km if job.vehicle.mileage_km is not None else case.mileage,
        str(stored.file.result["controller"]["id"]),
        lands,
        repaired,
        job.number,
    )
    return VisitedJob(stored, visit, problem, decisions)


def left_undone(visited: Sequence[VisitedJob]) -> tuple[tuple[VisitedJob, RepairDecision], ...]:
    """Return the repairs that were declined or deferred and not done since, each with the visit at which that was last.

    Parameters
    ----------
    visited
        the jobs of a unit, the earliest first, as from `visits_of_unit`.
    """
    undone: dict[tuple[str, int | None], tuple[VisitedJob, RepairDecision, frozenset[LandKey]]] = {}
    for each in visited:
        for decision, lands in each.decisions:
            pair = decision.component, decision.land
            if decision.decision in ("declined", "deferred"):
                undone.pop(pair, None)
                undone[pair] = each, decision, lands
            elif decision.decision == "done":
                done = [key for key, (*_, left) in undone.items() if key == pair or (left and left <= lands)]
                for key in done:
                    del undone[key]
    return tuple((each, decision) for each, decision, _ in reversed(undone.values()))
