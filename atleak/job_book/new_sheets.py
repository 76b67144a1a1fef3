"""Find the measuring sheets of the book that show new pairs: of new units, and of what was repaired at a visit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import groupby, pairwise
from typing import Any

import sqlalchemy as sa

from atleak.analysis.record_doubts import repaired_lands
from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Instruments
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import BookError, InputError, Place
from atleak.common.sentences import Sentence
from atleak.common.units import Quantity
from atleak.diagnosis.uncertainty.sources import PARTS
from atleak.job.case import SLOTS, Case, Reader
from atleak.job.parts import JobFile
from atleak.job_book.book import Book
from atleak.job_book.tables import decisions, jobs, visits
from atleak.job_book.unit_history import day_of_job, measured_jobs
from atleak.job_book.units import final_unit
from atleak.measurements.readings import Readings

NEW_UNTIL = 1000.0  # [km] up to which a unit, or what was repaired, is new: choice of this project

_INSTRUMENTS = tuple(f"{part}_instrument" for part in PARTS)


@dataclass(frozen=True)
class NewSheet:
    """A sheet of which all lands are new ones, or those that were repaired before it was measured."""

    job: str  # id
    name: str  # of the job and its file, each another one
    case: Case
    repaired: frozenset[LandKey] | None  # None: the unit was new, and all of its lands count

    def readings(self, controller: Controller) -> Readings:
        """Return the readings that are of new pairs of a valve body.

        Raises
        ------
        AtleakError
            a sheet that cannot be read any more.
        """
        reader = Reader()
        sheet = reader.readings(self.case, reader.entry(SLOTS["controller"], self.case.controller))
        if self.repaired is not None:
            kept = (each for each in sheet.readings if self._was_repaired(controller, each.component, each.plane))
            sheet = replace(sheet, readings=tuple(kept), unworn=())
        measured_at = self.case.measuring_temperature
        return replace(sheet, file=self.name, temperature=sheet.temperature if measured_at is None else measured_at)

    def _was_repaired(self, controller: Controller, component: str, plane: str) -> bool:
        land = controller.land_of_plane(component, plane)
        return land is not None and land.key in (self.repaired or ())


def new_sheets(book: Book, controller: str) -> tuple[NewSheet, ...]:
    """Return the sheets of new pairs of a valve body; of one unit one sheet.

    A unit is new up to `NEW_UNTIL`. What a job's record calls done is new where the unit's next sheet was measured no
    later than that after it. Archived jobs and the shipped sample do not count.

    Raises
    ------
    BookError
        the book holds no such sheet, or cannot be used.
    """
    with book.reading() as connection:
        every = connection.execute(_measured(controller)).all()
        done = set(connection.execute(_done(controller)).scalars())

    @cache
    def renewed(job: str) -> frozenset[LandKey]:
        return _repaired(book.load(job).file) if job in done else frozenset()

    chosen = [found for _, rows in groupby(every, lambda row: row.unit) for found in _of_unit(list(rows), renewed)]
    if not chosen:
        expected = Sentence(
            "a job at up to {mileage:,.0f} {mileage.unit}, or one measured after a repair that an earlier job calls "
            "done",
            mileage=Quantity(NEW_UNTIL, "distance"),
        )
        problem = Sentence(
            "the job book has no measuring sheet of a new or repaired {controller}", controller=controller
        )
        raise BookError(problem, place=Place(file=book.name), expected=expected)
    sheets: list[NewSheet] = []
    for job, repaired in chosen:
        file = book.load(job).file
        name = Sentence("job {name}", name=file.job.number or job)
        if any(sheet.name == name for sheet in sheets):
            name = Sentence("{job} ({id})", job=name, id=job)
        sheets.append(NewSheet(job, name, file.case, repaired))
    return tuple(sheets)


def shared_instruments(sheets: Sequence[NewSheet]) -> Instruments:
    """Return the instruments with which all sheets were measured.

    Raises
    ------
    InputError
        sheets that were measured with different ones.
    """
    reader = Reader()
    found = [
        Instruments(*(reader.entry(SLOTS[name], getattr(sheet.case, name)) for name in _INSTRUMENTS))
        for sheet in sheets
    ]
    for sheet, gauges in zip(sheets, found, strict=True):
        if any(gauges.of(part).id != found[0].of(part).id for part in PARTS):
            names = {"sheet": sheet.name, "other": sheets[0].name}
            problem = Sentence("{sheet} was measured with other instruments than {other}", **names)
            expected = Sentence("--spool-instrument and --sleeve-instrument, to count for all of them")
            raise InputError(problem, expected=expected)
    return found[0]


def _measured(controller: str) -> sa.Select[Any]:
    """Select the measured jobs of a valve body, those of one unit together, the earliest first."""
    unit = final_unit().label("unit")
    return (
        sa.select(unit, jobs.c.id, jobs.c.mileage_km)
        .join(visits, visits.c.id == jobs.c.visit)
        .where(*measured_jobs(controller))
        .order_by(unit, day_of_job(), jobs.c.made_at, jobs.c.id)
    )


def _done(controller: str) -> sa.Select[Any]:
    """Select the jobs at which repairs were done on a valve body."""
    return (
        sa.select(decisions.c.job)
        .join(jobs, jobs.c.id == decisions.c.job)
        .where(jobs.c.controller == controller, decisions.c.decision == "done")
        .distinct()
    )


def _repaired(file: JobFile) -> frozenset[LandKey]:
    return repaired_lands(file.job, Reader().entry(SLOTS["controller"], file.case.controller))


def _of_unit(
    rows: Sequence[Any], renewed: Callable[[str], frozenset[LandKey]]
) -> Iterator[tuple[str, frozenset[LandKey] | None]]:
    """Yield the one sheet of a unit that shows the most new pairs: all of them, or what was repaired last.

    With it the lands that were; None for all of them. ``renewed`` says which a job's record calls repaired.
    """
    new = [row for row in rows if row.mileage_km is not None and row.mileage_km <= NEW_UNTIL and not renewed(row.id)]
    if new:
        yield new[-1].id, None
        return
    for before, after in reversed(list(pairwise(rows))):
        known = before.mileage_km is not None and after.mileage_km is not None
        if known and 0.0 <= after.mileage_km - before.mileage_km <= NEW_UNTIL and renewed(before.id):
            yield after.id, renewed(before.id)
            return
