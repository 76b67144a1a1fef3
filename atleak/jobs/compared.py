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
        raise InputError("there is no such job file", place=Place(file=name), expected="a job file (zip)")
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
        record[side] = {"job": _identity(job_file), **record[side]}
    return record


def _identity(job_file: JobFile) -> dict[str, Any]:
    job = job_file.job
    return {
        "number": job.number or None,
        "date": job.date.isoformat() if job.date else None,
        "vin": job.vehicle.vin or None,
        "plate": job.vehicle.registration or None,
        "serial": job.transmission.serial or None,
        "mileage_km": job.vehicle.mileage_km,
    }


def _of_records(before: JobFile, after: JobFile) -> Iterator[Message]:
    """Yield what the records say against the two jobs being two visits of one unit in that order."""
    first, second = before.job, after.job
    if first.date and second.date and second.date < first.date:
        text = f"The job after is of {second.date}, the one before of {first.date}: they may be exchanged"
        yield Message("warning", "order_of_dates", text)
    for called, one, other in (
        ("VIN", first.vehicle.vin, second.vehicle.vin),
        ("serial number of the transmission", first.transmission.serial, second.transmission.serial),
    ):
        if one and other and _bare(one) != _bare(other):
            text = f"The two jobs name another {called}: {one} before, {other} after. They may be of two units"
            yield Message("warning", "other_unit", text)


def _bare(name: str) -> str:
    return "".join(filter(str.isalnum, name.upper()))


def _of_results(before: JobFile, after: JobFile, comparison: Comparison) -> Iterator[Message]:
    """Yield which results were given by another version of atleak, and what it said."""
    sides = (("before", before, comparison.before), ("after", after, comparison.after))
    for side, job_file, diagnosis in sides:
        version, verdict = job_file.result.get("atleak"), job_file.result.get("verdict")
        if not version or version == __version__:
            continue
        said = f"The result kept with the job {side} was given by atleak {version}"
        if verdict and verdict != diagnosis.verdict:
            text = f"{said} and said {verdict}; by this version it is {diagnosis.verdict}, which is compared"
            yield Message("warning", "other_version", text)
        else:
            yield Message("info", "other_version", f"{said}; both jobs are judged anew by {__version__}")
