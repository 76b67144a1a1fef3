"""Time a job book of 50 000 jobs beside one of 500: list, look-up, open and save.

    python benchmarks/job_book.py [--jobs 50000] [--postgresql] [--small]

The books are filled through their tables with the rows of one job of the sample's 47 lands, each time with another
customer, vehicle, unit, date, verdict and sheet. Customers have five jobs each, units two or three; besides, one job in
fifty is of a dealer with many. Every question is asked of each book in turn; median of 15, with the number of jobs that
are the answer: 200 at most are shown, and where the large book has more of them it takes longer for that alone. Goals:
at most twice the time for as many, 0.3 s for any on SQLite, 1 s for all units of one valve body. With ``--postgresql``
the same on a server of its own. ``--small``: 2000 beside 200.
"""

from __future__ import annotations

import argparse
import contextlib
import datetime as dt
import hashlib
import random
import statistics
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import postgresql
import sqlalchemy as sa
from timing import options

from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book, open_book
from atleak.job_book.search import Query, search_words_of
from atleak.job_book.tables import files, job_files, jobs, key_of_row, lands, results, search_words, units, visits
from atleak.job_book.unit_history import across_units
from atleak.measurements.job_card import Job

OPTIONS = options(__doc__)
OPTIONS.add_argument("--jobs", type=int, default=50_000, metavar="N", help="of the large book")
OPTIONS.add_argument("--postgresql", action="store_true", help="also on PostgreSQL")
SHEET = Path(__file__).resolve().parents[1] / "sample_data" / "measuring_sheet_four_speed.xlsx"
RATIO, LONGEST = 2.0, 0.3  # goals: large over small, and [s]
LONGEST_ACROSS = 1.0  # [s] goal for all units of one valve body
ROUNDS = 15
MANY = 1000  # jobs written at a time
SYLLABLES = ("ko", "wal", "ski", "mül", "ler", "no", "vak", "ber", "ger", "son", "da", "vi", "mar", "ti", "nez", "ro")
DEALER = "Autohaus Nord"
VERDICTS = (*["ok"] * 5, *["watch"] * 2, *["replace"] * 2, "critical")
CONTROLLERS = ("four_speed_2023", "five_speed_2005", "zf_6hp26", "gm_4l60e", "ford_4r70w", "aisin_aw55_50sn")


def sample_job() -> JobParts:
    """Return the sample's measuring sheet as a job."""
    case = Case(readings=SourceFile.at(SHEET), mileage=106_315.0)
    return job_parts(case.diagnose(), Job(), case)


def record_of(number: int) -> Job:
    """Return the record of a job: a unit comes two or three times, a customer five."""
    unit, customer = number * 2 // 5, random.Random(number // 5)
    name = " ".join("".join(customer.choice(SYLLABLES) for _ in range(3)).title() for _ in range(2))
    return Job(
        number=f"2026-{number:06d}",
        date=dt.date(2016, 1, 1) + dt.timedelta(days=number % 3650),
        customer={"name": DEALER if number % 50 == 0 else name, "number": f"K{number // 5:06d}"},  # type: ignore[arg-type]
        vehicle={  # type: ignore[arg-type]
            "vin": f"WDB{hashlib.sha256(str(unit).encode()).hexdigest()[:14].upper()}",
            "registration": f"KR {unit:05d}",
            "mileage_km": 100_000.0 + number,
        },
        transmission={"serial": f"722 {unit:07d}"},  # type: ignore[arg-type]
        notes="torque converter shudders when warm",
    )


def fill(book: Book, count: int) -> None:
    """Put so many jobs into an empty book."""
    template, draw = sample_job(), random.Random(1)
    first = book.save(template)
    with book.writing() as connection:
        rows = {
            table: [dict(row) for row in connection.execute(sa.select(table)).mappings()]
            for table in (jobs, job_files, results, lands, files)
        }
        connection.execute(jobs.delete().where(jobs.c.id == first.id))
        for table in (visits, units):
            connection.execute(table.delete())
    moment = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
    for start in range(0, count, MANY):
        made: dict[sa.Table, list[dict[str, Any]]] = {
            table: [] for table in (units, visits, files, jobs, search_words, job_files, results, lands)
        }
        for number in range(start, min(start + MANY, count)):
            record, id = record_of(number), f"{draw.getrandbits(64):016x}"
            unit = number * 2 // 5 + 1
            if unit != (number - 1) * 2 // 5 + 1 or not number:
                serial = record.transmission.serial
                made[units].append({"id": unit, "key": f"serial:{key_of_row(serial)}", "serial": serial})
            about = {"number": record.number, "date": record.date, "mileage_km": record.vehicle.mileage_km}
            made[visits].append({"id": number + 1, "unit": unit, **about})
            choices = template.choices.model_copy(update={"job": record}).model_dump_json(exclude_defaults=True)
            kept = {
                "visit": number + 1,
                "made_at": moment + dt.timedelta(minutes=number),
                "made_on": (moment + dt.timedelta(minutes=number)).date(),
                "changed_at": moment + dt.timedelta(minutes=number),
                "archived_at": moment if number % 100 == 99 else None,
                "choices": zlib.compress(choices.encode()),
                "customer": record.customer.name,
                "vin": record.vehicle.vin,
                "plate": record.vehicle.registration,
                "serial": record.transmission.serial,
                "controller": draw.choice(CONTROLLERS),
                "verdict": draw.choice(VERDICTS),
            }
            made[jobs].append(rows[jobs][0] | about | kept | {"id": id})
            made[search_words] += [{"job": id, "field": field, "word": word} for field, word in search_words_of(record)]
            sheet = SHEET.read_bytes() + number.to_bytes(4, "big")  # each job has its own
            sha256 = hashlib.sha256(sheet).hexdigest()
            made[files].append({"sha256": sha256, "size": len(sheet), "content": zlib.compress(sheet, 1)})
            for row in rows[job_files]:
                own = {"sha256": sha256} if row["slot"] == "readings" else {}
                made[job_files].append(_copy(row, job=id, **own))
            made[results].append(_copy(rows[results][0], job=id, readings_sha256=sha256))
            made[lands] += [_copy(row, job=id) for row in rows[lands]]
        with book.writing() as connection:
            for table, several in made.items():
                if several:
                    connection.execute(table.insert(), several)


def _copy(row: dict[str, Any], **changed: Any) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name != "id"} | changed


def questions(book: Book, count: int) -> dict[str, Callable[[], Any]]:
    """Return what is asked of a book of so many jobs, each time about another one."""
    draw, saved = random.Random(2), sample_job()
    ids = [row.id for row in book.rows(Query(limit=count))]

    def of_one(make: Callable[[Job], Query]) -> Callable[[], Any]:
        return lambda: book.rows(make(record_of(draw.randrange(count))))

    def save() -> None:
        id = draw.choice(ids)
        parts = replace(saved, choices=saved.choices.model_copy(update={"job": record_of(draw.randrange(count))}))
        book.save(parts, id=id, version=book.version(id))

    return {
        "list": lambda: book.rows(),
        "list, page 3": lambda: book.rows(Query(limit=50, offset=100)),
        "count": lambda: book.count(),
        "archived": lambda: book.rows(Query(archived=True)),
        "VIN": of_one(lambda record: Query(vin=record.vehicle.vin)),
        "end of a VIN": of_one(lambda record: Query(text=record.vehicle.vin[-6:])),
        "part of a customer": of_one(lambda record: Query(customer=record.customer.name[:-2])),
        "two words": of_one(lambda record: Query(text=f"{record.customer.name.split()[0]} {record.number}")),
        "a dealer's": lambda: book.rows(Query(customer="autoh")),
        "first letter": lambda: book.rows(Query(text="k")),
        "verdict and valve body": lambda: book.rows(Query(verdict="critical", controller="zf_6hp26")),
        "dates": lambda: book.rows(Query(date_from=dt.date(2018, 3, 1), date_to=dt.date(2018, 3, 14))),
        "unit's visits": lambda: book.rows(Query(unit=draw.randrange(count * 2 // 5) + 1)),
        "open": lambda: book.load(draw.choice(ids)),
        "save": save,
    }


def compare(name: str, small: Book, large: Book, counts: tuple[int, int]) -> None:
    """Time every question on both books in turn."""
    asked = [questions(book, count) for book, count in zip((small, large), counts, strict=True)]
    print(f"\n{name:26s}{counts[0]:>10d} jobs{counts[1]:>10d} jobs   ratio")
    for question in asked[0]:
        times: tuple[list[float], list[float]] = ([], [])
        answers = [0, 0]
        for _ in range(ROUNDS):
            for number, (each, kept) in enumerate(zip(asked, times, strict=True)):
                start = time.perf_counter()
                answer = each[question]()
                kept.append(time.perf_counter() - start)
                answers[number] = max(answers[number], len(answer) if isinstance(answer, list) else 1)
        before, after = (statistics.median(kept) for kept in times)
        as_many = answers[1] <= RATIO * answers[0]
        missed = "   past the goal" if after > LONGEST or (as_many and after > RATIO * before) else ""
        said = (
            f"{seconds * 1e3:7.1f} ms ({found:3d})" for seconds, found in zip((before, after), answers, strict=True)
        )
        print(f"  {question:24s}{''.join(said)}{after / before:8.2f}{missed}")


def look_across(book: Book) -> None:
    """Time what all units of one valve body show; how many there are grows with the book, and the time with them."""
    times = []
    for _ in range(ROUNDS // 3):
        start = time.perf_counter()
        across = across_units(book, CONTROLLERS[2])
        times.append(time.perf_counter() - start)
    missed = "" if statistics.median(times) <= LONGEST_ACROSS else "   past the goal"
    print(f"  {across.units} units of one valve body {statistics.median(times) * 1e3:14.1f} ms{missed}")


@contextlib.contextmanager
def filled(address: str, count: int) -> Iterator[Book]:
    """Open a new book of so many jobs."""
    book = open_book(address)
    start = time.perf_counter()
    fill(book, count)
    if book.engine.dialect.name == "sqlite":
        size = Path(book.name).stat().st_size / count
        print(f"{count} jobs in {time.perf_counter() - start:.0f} s, {size / 1e3:.0f} kB a job on disk")
    else:
        with book.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.exec_driver_sql("ANALYZE")  # as the server does by itself after a while
    yield book
    book.engine.dispose()


def main(arguments: argparse.Namespace) -> None:
    counts = (200, 2000) if arguments.small else (500, arguments.jobs)
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as open_books:
        books = [
            open_books.enter_context(filled(f"sqlite:///{Path(folder) / f'{count}.sqlite'}", count)) for count in counts
        ]
        compare("SQLite", *books, counts)
        look_across(books[-1])
    if arguments.postgresql:
        with postgresql.running(durable=True) as server, contextlib.ExitStack() as open_books:
            addresses = [server.address(server.new_database()) for _ in counts]
            books = [
                open_books.enter_context(filled(address, count))
                for address, count in zip(addresses, counts, strict=True)
            ]
            compare("PostgreSQL", *books, counts)
            look_across(books[-1])


if __name__ == "__main__":
    main(OPTIONS.parse_args())
