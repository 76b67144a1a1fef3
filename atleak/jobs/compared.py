"""Compare two jobs, each a job file or a job of the book: two diagnoses, and what their records say besides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from atleak.comparison import Comparison, compare
from atleak.diagnosis import Diagnosis
from atleak.errors import InputError, Message, Place
from atleak.job.file import read_job_file
from atleak.job.parts import JobFile
from atleak.jobs.book import Book, open_book
from atleak.jobs.named import named_job
from atleak.sentence import Sentence
from atleak.verdicts import level_named
from atleak.version import __version__
from atleak.views.comparison_record import comparison_record


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
    before, after
        the earlier and the later job.
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
        said = (
            Sentence("The result kept with the job before was given by atleak {version}", version=version)
            if job_file is before
            else Sentence("The result kept with the job after was given by atleak {version}", version=version)
        )
        if verdict and verdict != diagnosis.verdict:
            text = Sentence(
                "{kept} and said {verdict}; by this version it is {today}, which is compared",
                kept=said,
                verdict=level_named(verdict),
                today=diagnosis.verdict,
            )
            yield Message("warning", "other_version", text)
        else:
            text = Sentence("{kept}; both jobs are judged anew by {version}", kept=said, version=__version__)
            yield Message("info", "other_version", text)
