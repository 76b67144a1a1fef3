"""Turn the jobs of one unit into visits, and say what became of the repairs that were proposed at each."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa

from atleak.analysis.history.series import Visit
from atleak.analysis.record_doubts import covered, repaired_lands
from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import AtleakError
from atleak.common.sentences import Sentence
from atleak.diagnosis.uncertainty import LandSources
from atleak.job.case import SLOTS, Reader
from atleak.job_book.book import Book, StoredJob
from atleak.job_book.search import Query
from atleak.job_book.tables import jobs, visits
from atleak.job_book.units import final_unit
from atleak.measurements.job_card import RepairDecision, RepairState


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
    loader
        reads the files of the jobs; unless given, each is read anew.

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
