"""Compare two jobs, each a job file or a job of the book: two diagnoses, and what their records say besides.

A job of the book is named by its id, the id's first characters, or the workshop's number of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from atleak.analysis.changes import Comparison
from atleak.analysis.comparison import compare
from atleak.common.errors import BookError, InputError, Message, Place
from atleak.common.sentences import Sentence, counted
from atleak.common.verdicts import level_named
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.parts import JobFile
from atleak.job.zip_file import read_job_file
from atleak.job_book.book import Book, open_book
from atleak.job_book.tables import jobs, key_of_row, search_words
from atleak.report.tables.comparison import comparison_record
from atleak.version import __version__

_SHOWN = 8  # of several that fit
_FEWEST = 4  # characters of an id
_BEHIND = "g"  # sorts behind every further character of an id


def named_job(book: Book, name: str) -> str:
    """Return the id of the job, archived or not, that is named; an id comes before its beginning and a number.

    Raises
    ------
    BookError
        no such job, or several; it names those.
    """
    with book.reading() as connection:
        columns = jobs.c.id, jobs.c.number, jobs.c.customer, jobs.c.date
        found = connection.execute(sa.select(*columns).where(jobs.c.id == name)).all()
        if not found and key_of_row(name):
            words = sa.select(search_words.c.job).where(
                search_words.c.field == "number", search_words.c.word == key_of_row(name)
            )
            numbered = connection.execute(sa.select(*columns).where(jobs.c.id.in_(words))).all()
            found = [row for row in numbered if key_of_row(row.number) == key_of_row(name)]
            if len(name) >= _FEWEST:
                start = name.lower()
                near = jobs.c.id.between(start, start + _BEHIND)  # which the index of ids answers
                begun = sa.select(*columns).where(near, jobs.c.id.startswith(start, autoescape=True))
                found += [row for row in connection.execute(begun) if row not in found]
    place = Place(file=book.name)
    if not found:
        expected = Sentence("an id as `atleak jobs list` shows it, its first characters, or the number of a job")
        raise BookError(Sentence("the job book has no such job"), place=place, value=name, expected=expected)
    if len(found) > 1:
        several = [
            " ".join(str(part) for part in (row.id, row.number, row.customer, row.date or "") if part) for row in found
        ]
        expected = Sentence("one of {names}", names="; ".join(several[:_SHOWN]))
        if len(several) > _SHOWN:
            expected = Sentence("{names} and {count} more", names=expected, count=len(several) - _SHOWN)
        problem = counted(
            len(found), "{count} job of the job book is called so", "{count} jobs of the job book are called so"
        )
        raise BookError(problem, place=place, value=name, expected=expected)
    return str(found[0].id)


@dataclass(frozen=True)
class ComparedJobs:
    """Two jobs and their comparison, whose messages are also those of the two records."""

    before: JobFile
    after: JobFile
    comparison: Comparison


def job_of(name: str, book: Book | None = None) -> JobFile:
    """Return a job by the path of its job file, or by what names it in the job book.

    Parameters
    ----------
    name
        a path, where there is such a file; else as `named_job` takes it.
    book
        the job book; the user's own, which is opened where it is needed, unless given.

    Raises
    ------
    InputError
        a file that is no job file; a name that no job of the book has, or several have.
    """
    if Path(name).is_file():
        return read_job_file(name)
    if Path(name).suffix.lower() == ".zip":
        problem = Sentence("there is no such job file")
        raise InputError(problem, place=Place(file=name), expected=Sentence("a job file (zip)"))
    book = book or open_book()
    return book.load(named_job(book, name)).file


def compare_jobs(before: JobFile, after: JobFile, diagnoses: tuple[Diagnosis, Diagnosis] | None = None) -> ComparedJobs:
    """Compare two jobs of one unit, both judged by this version of atleak.

    Parameters
    ----------
    diagnoses
        of both, where they are known already; else both are diagnosed anew.

    Raises
    ------
    AtleakError
        a job that cannot be diagnosed; two different valve bodies.
    """
    first, second = diagnoses or (before.diagnose(), after.diagnose())
    comparison = compare(first, second)
    messages = (*_of_records(before, after), *_of_results(before, after, comparison), *comparison.messages)
    return ComparedJobs(before, after, replace(comparison, messages=messages))


def compared_record(compared: ComparedJobs) -> dict[str, Any]:
    """Return the record of a comparison with what tells the two jobs apart: ``job`` on either side."""
    record = comparison_record(compared.comparison)
    for side, job_file in (("before", compared.before), ("after", compared.after)):
        record[side] = {"job": job_file.job.identity, **record[side]}
    return record


def _of_records(before: JobFile, after: JobFile) -> Iterator[Message]:
    """Yield what the records say against the two jobs being two visits of one unit in that order."""
    first, second = before.job, after.job
    if first.date and second.date and second.date < first.date:
        text = Sentence(
            "The job after is of {after}, the one before of {before}: they may be exchanged",
            after=second.date,
            before=first.date,
        )
        yield Message("warning", "order_of_dates", text)
    if _differ(first.vehicle.vin, second.vehicle.vin):
        text = Sentence(
            "The two jobs name another VIN: {before} before, {after} after. They may be of two units",
            before=first.vehicle.vin,
            after=second.vehicle.vin,
        )
        yield Message("warning", "other_unit", text)
    if _differ(first.transmission.serial, second.transmission.serial):
        text = Sentence(
            "The two jobs name another serial number of the transmission: {before} before, {after} after. "
            "They may be of two units",
            before=first.transmission.serial,
            after=second.transmission.serial,
        )
        yield Message("warning", "other_unit", text)


def _differ(one: str, other: str) -> bool:
    return bool(one and other) and _bare(one) != _bare(other)


def _bare(name: str) -> str:
    return "".join(filter(str.isalnum, name.upper()))


def _of_results(before: JobFile, after: JobFile, comparison: Comparison) -> Iterator[Message]:
    """Yield which results were given by another version of atleak, and what it said."""
    for job_file, diagnosis in ((before, comparison.before), (after, comparison.after)):
        version, verdict = job_file.result.get("atleak"), job_file.result.get("verdict")
        if not version or version == __version__:
            continue
        versions = (
            Sentence("The result kept with the job before was given by atleak {version}", version=version)
            if job_file is before
            else Sentence("The result kept with the job after was given by atleak {version}", version=version)
        )
        if verdict and verdict != diagnosis.verdict:
            text = Sentence(
                "{kept} and said {verdict}; by this version it is {today}, which is compared",
                kept=versions,
                verdict=level_named(verdict),
                today=diagnosis.verdict,
            )
            yield Message("warning", "other_version", text)
        else:
            text = Sentence("{kept}; both jobs are judged anew by {version}", kept=versions, version=__version__)
            yield Message("info", "other_version", text)
