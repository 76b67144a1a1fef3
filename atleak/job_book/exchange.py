"""Take jobs out of the book as job files and tables, and take job files in."""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import sqlalchemy as sa

from atleak.common.sentences import Sentence
from atleak.job.parts import JobParts, OfBook, job_parts
from atleak.job.result import judged_otherwise
from atleak.job.zip_file import packed_job, read_job_file
from atleak.job_book.book import PICTURE, Book
from atleak.job_book.tables import decisions, job_files, jobs, lands, visits
from atleak.job_book.units import final_unit

_TABLES = ("jobs", "lands", "decisions")
FORMS = ("csv", "parquet")
_OF_ATLEAK = ("atleak",)  # what of a job's choices another version of atleak changes by itself
_MANY = 500  # ids in one statement


# --- out


def job_file_name(id: str, number: str) -> str:
    """Return the name of a job's file.

    >>> job_file_name("0a1b2c3d4e5f6071", "2026/117 b")
    '2026-117-b_0a1b2c3d4e5f6071.zip'
    """
    plain = re.sub(r"[^A-Za-z0-9]+", "-", number).strip("-")[:40]
    return f"{plain}_{id}.zip" if plain else f"{id}.zip"


def job_file(book: Book, id: str) -> bytes:
    """Return a job of the book as job file, with the result as it was stored, and what the book alone knows of it.

    Raises
    ------
    BookError
        an id that the book does not have; a job that was damaged in the database.
    """
    job = book.load(id)
    undated = job.made_on if job.date is None else None
    of_book = OfBook(sample=job.sample, archived_at=job.archived_at, made_on=undated)
    return packed_job(job.choices, job.sources, job.pictures, job.result, of_book)


def tables(book: Book, ids: Iterable[str]) -> dict[str, pd.DataFrame]:
    """Return what the book says of jobs as tables for other programs: jobs, their lands, their repair decisions.

    Every row of lands and decisions names its job; ``unit`` and ``visit`` are numbers of this book.
    """
    names = ("id", "number", "date", "vin", "plate", "serial", "customer", "technician", "mileage_km", "controller")
    columns = [*(jobs.c[name] for name in names), jobs.c.verdict, jobs.c.made_at, jobs.c.changed_at, jobs.c.archived_at]
    of_jobs = sa.select(*columns, final_unit().label("unit"), jobs.c.visit).join(visits, visits.c.id == jobs.c.visit)
    statements = {
        "jobs": (of_jobs, jobs.c.id),
        **{
            name: (sa.select(*(column for column in table.c if column.name != "id")).order_by(table.c.id), table.c.job)
            for name, table in (("lands", lands), ("decisions", decisions))
        },
    }
    wanted = list(dict.fromkeys(ids))
    with book.reading() as connection:
        return {
            name: pd.DataFrame(
                [
                    row
                    for start in range(0, len(wanted), _MANY)
                    for row in connection.execute(statement.where(key.in_(wanted[start : start + _MANY]))).mappings()
                ],
                columns=list(statement.selected_columns.keys()),
            )
            for name, (statement, key) in statements.items()
        }


def table_bytes(frame: pd.DataFrame, form: str) -> bytes:
    """Return a table as Parquet or as CSV, in which no text begins as a formula does."""
    if form == "parquet":
        target = io.BytesIO()
        frame.to_parquet(target, index=False)
        return target.getvalue()
    safe = frame.apply(lambda column: column.map(_no_formula))
    return str(safe.to_csv(index=False, lineterminator="\n")).encode("utf-8", "backslashreplace")


def _no_formula(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r") else value


def exported(book: Book, ids: Sequence[str]) -> Iterator[tuple[Path, bytes]]:
    """Yield the files of an export: a job file of each job, and the tables of all, by their paths in the export.

    Raises
    ------
    BookError
        an id that the book does not have; a job that was damaged in the database.
    """
    paths = export_paths(book, ids)
    for id in ids:
        yield paths[id], job_file(book, id)
    for name, frame in tables(book, ids).items():
        for form in FORMS:
            yield paths[f"{name}.{form}"], table_bytes(frame, form)


def export_zip(book: Book, ids: Sequence[str]) -> bytes:
    """Return an export as one zip.

    Raises
    ------
    BookError
        as `exported`.
    """
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as bundle:
        for path, content in exported(book, ids):
            bundle.writestr(path.as_posix(), content)
    return target.getvalue()


def export_paths(book: Book, ids: Sequence[str]) -> dict[str, Path]:
    """Return the path in an export of every job by its id, and of every table by its file's name."""
    with book.reading() as connection:
        numbers = {row.id: row.number for row in connection.execute(sa.select(jobs.c.id, jobs.c.number))}
    of_jobs = {id: Path(job_file_name(id, numbers.get(id, ""))) for id in ids}
    return {**of_jobs, **{f"{name}.{form}": Path("tables") / f"{name}.{form}" for name in _TABLES for form in FORMS}}


# --- in


@dataclass(frozen=True)
class Imported:
    """What became of a job file."""

    id: str  # of the job in the book
    known: bool  # it was in the book already, and nothing was changed
    verdict: str  # of today's version
    result_by: str  # version that wrote the file
    differs: tuple[Sentence, ...]  # from the result that it wrote


def import_job(book: Book, source: str | Path | bytes, *, name: str = "job file") -> Imported:
    """Take a job file into the book; one whose job is there already, with the same files and choices, is recognised.

    Raises
    ------
    AtleakError
        a file that is no job file, or that this version cannot judge.
    BookError
        where the book cannot be written.
    """
    given = read_job_file(source, name=name)
    diagnosis = given.diagnose()
    parts = job_parts(diagnosis, given.job, given.case)
    known = same_job(book, parts)
    kept = given.of_book.model_dump(exclude={"sample"}, exclude_defaults=True)
    id = known or book.save(parts, sample=given.of_book.sample, kept=kept).id
    otherwise = judged_otherwise(given.result, parts.result, numbers=True)
    return Imported(id, known is not None, str(diagnosis.verdict), given.result_by, otherwise)


def same_job(book: Book, parts: JobParts) -> str | None:
    """Return the id of the job of the book, archived or not, with the same record, choices and files; None without."""
    record, held = parts.job, _held_by(parts)
    alike = sa.select(jobs.c.id, jobs.c.choices).where(
        jobs.c.number == record.number[:80],
        jobs.c.vin == record.vehicle.vin[:80],
        jobs.c.serial == record.transmission.serial[:80],
        jobs.c.controller == parts.diagnosis.controller.id,
        jobs.c.date.is_(None) if record.date is None else jobs.c.date == record.date,
    )
    mine = _compared(parts.choices.model_dump_json(exclude_defaults=True).encode())
    with book.reading() as connection:
        for row in connection.execute(alike.order_by(jobs.c.made_at)).all():
            if _compared(book.unpacked(row.choices, row.id)) != mine:
                continue
            columns = job_files.c.slot, job_files.c.sha256
            files = connection.execute(sa.select(*columns).where(job_files.c.job == row.id)).all()
            if sorted(tuple(each) for each in files) == held:
                return str(row.id)
    return None


def _compared(choices: bytes) -> dict[str, Any]:
    """Return the choices of a job without what another version of atleak changes by itself."""
    return {name: value for name, value in json.loads(choices).items() if name not in _OF_ATLEAK}


def _held_by(parts: JobParts) -> list[tuple[str, str]]:
    own = [(slot, source.sha256) for slot, source in parts.sources.items()]
    return sorted([*own, *((PICTURE, hashlib.sha256(content).hexdigest()) for content in parts.pictures.values())])
