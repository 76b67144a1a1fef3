"""Kill a process in the middle of its saves, again and again: no acknowledged job may be lost, none may be half.

    python benchmarks/book_kills.py [--sqlite 1000] [--postgresql 200] [--small]

A process saves new jobs and earlier ones with another sheet, record and picture, as fast as it can, and says each save
that it was told is safe. After some of them it gets SIGKILL. Then the book is opened again: every job must hold the
version that was acknowledged last, or the whole of the one that was under way; it must open, its files must have their
SHA-256, and its stored result must be that of its sheet. PostgreSQL is a server of its own on loopback. Wants a system
that forks. ``--small``: 25 and 10.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import postgresql
from timing import options

from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.backup import problems_of, verify
from atleak.job_book.book import Book, open_book
from atleak.job_book.search import Query
from atleak.measurements.job_card import Job

OPTIONS = options(__doc__)
OPTIONS.add_argument("--sqlite", type=int, default=1000, metavar="N", help="kills on SQLite")
OPTIONS.add_argument("--postgresql", type=int, default=200, metavar="N", help="kills on PostgreSQL")
SHEETS = 4  # sheets that jobs are saved with
SAVES = 4  # a process is killed after none to so many of its saves
PAUSE = 0.03  # [s] after that at most: about what a save takes
START = 30.0  # [s] until a process must have saved

Known = dict[str, int]  # the version of every job that was acknowledged last


def prepared_jobs() -> list[JobParts]:
    """Return small jobs that differ in sheet, picture and result."""
    found = []
    for number in range(SHEETS):
        rows = ["component,part,plane,direction,diameter [mm]"]
        for direction in (0, 90):
            rows += [f"tcc_regulator,spool,1,{direction},11.000"]
            rows += [f"tcc_regulator,sleeve,1,{direction},{11.03 + 0.1 * number:.3f}"]
        case = Case(readings=SourceFile("sheet.csv", "\n".join(rows).encode()), controller="minimal_example")
        parts = job_parts(case.diagnose(), Job(photos=[{"file": "bore.png"}]), case)  # type: ignore[list-item]
        found.append(replace(parts, pictures={"bore.png": random.Random(number).randbytes(30_000)}))
        assert found[-1].result["lands"]
    return found


def as_saved(parts: JobParts, version: int) -> JobParts:
    """Return a job whose record says which version it is."""
    record = parts.job.model_copy(update={"number": str(version), "notes": f"version {version}"})
    return replace(parts, choices=parts.choices.model_copy(update={"job": record}))


def save_until_killed(address: str, jobs: list[JobParts], known: Known, seed: int, said: int) -> None:
    """Save, saying what begins and what was acknowledged, one line each."""
    draw, book = random.Random(seed), open_book(address)
    while True:
        id = draw.choice(list(known)) if known and draw.random() < 0.7 else None
        version = None if id is None else book.version(id)
        parts = as_saved(draw.choice(jobs), 1 if version is None else version + 1)
        os.write(said, b"begins\n")
        saved = book.save(parts, id=id, version=version)
        known[saved.id] = saved.version
        os.write(said, f"{saved.id} {saved.version}\n".encode())


def killed_once(address: str, jobs: list[JobParts], known: Known, draw: random.Random) -> tuple[list[str], bool]:
    """Start a process, kill it, and return the jobs it acknowledged and whether a save was under way."""
    reading, writing = os.pipe()
    seed, wanted, pause = draw.getrandbits(32), draw.randrange(SAVES + 1), draw.random() * PAUSE
    process = os.fork()
    if process == 0:
        try:
            os.close(reading)
            save_until_killed(address, jobs, known, seed, writing)
        except BaseException as error:  # noqa: BLE001  the parent reads it
            os.write(writing, f"failed: {error}\n".encode())
        finally:
            os._exit(1)
    os.close(writing)
    text, limit = b"", time.monotonic() + START
    while text.count(b"\n") < 2 * wanted + 1 and b"failed" not in text and time.monotonic() < limit:
        if select.select([reading], [], [], 1.0)[0]:
            text += os.read(reading, 65536)
    time.sleep(pause)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    while more := os.read(reading, 65536):
        text += more
    os.close(reading)
    lines = text.decode().splitlines()
    if not lines or any(line.startswith("failed") for line in lines):
        raise RuntimeError(f"the saving process could not save: {lines[-1:]}")
    acknowledged = [line for line in lines if line != "begins"]
    for line in acknowledged:
        id, version = line.split()
        known[id] = int(version)
    return [line.split()[0] for line in acknowledged], lines[-1] == "begins"


def faults_of(book: Book, known: Known, ids: set[str]) -> Iterator[tuple[str, str]]:
    """Say which acknowledged jobs are lost, and which jobs are half."""
    there = {row.id for row in book.rows(Query(limit=None))}
    for id in ids | there.difference(known):
        if id not in there:
            yield "lost", f"job {id} is not there"
            continue
        stored = book.load(id)
        if not known.get(id, 1) <= stored.version <= known.get(id, 0) + 1:
            yield "lost", f"job {id} has version {stored.version}, acknowledged was {known.get(id)}"
        if stored.file.job.notes != f"version {stored.version}":
            yield "half", f"job {id} says {stored.file.job.notes!r}, and is version {stored.version}"
        yield from (("half", f"job {id}: {problem}") for problem in problems_of(book, id))
        known[id] = stored.version


def kill(name: str, address: str, kills: int) -> bool:
    """Kill so many processes on a book; return whether nothing was lost or half."""
    jobs, draw, known, counts = prepared_jobs(), random.Random(1), Known(), Counter()
    open_book(address).engine.dispose()
    begun = time.perf_counter()
    for _ in range(kills):
        before = {id for id in known if draw.random() < 0.1}  # some of the others too: the last check is of all
        acknowledged, under_way = killed_once(address, jobs, known, draw)
        counts["acknowledged"] += len(acknowledged)
        counts["under way"] += under_way
        book = open_book(address)
        for kind, said in faults_of(book, known, {*acknowledged, *before}):
            counts[kind] += 1
            print(f"{name}: {kind}: {said}", file=sys.stderr)
        book.engine.dispose()
    book = open_book(address)
    for kind, said in faults_of(book, known, {*known}):
        counts[kind] += 1
        print(f"{name}: {kind}: {said}", file=sys.stderr)
    faults = verify(book)
    book.engine.dispose()
    print(
        f"{name}: {kills} kills, {counts['under way']} of them in the middle of a save; {counts['acknowledged']} "
        f"acknowledged saves of {len(known)} jobs: {counts['lost']} lost, {counts['half']} half; verify finds "
        f"{len(faults)} faults ({time.perf_counter() - begun:.0f} s)"
    )
    return not (counts["lost"] or counts["half"] or faults)


@contextmanager
def server() -> Iterator[postgresql.Server | None]:
    """Run PostgreSQL, where it is installed."""
    try:
        postgresql.programs()
    except postgresql.NoServer as error:
        if os.environ.get("ATLEAK_NOTHING_MAY_SKIP"):
            raise
        print(f"{error}: left out")
        yield None
        return
    with postgresql.running() as running:
        yield running


def main(arguments: argparse.Namespace) -> None:
    on_sqlite, on_server = (25, 10) if arguments.small else (arguments.sqlite, arguments.postgresql)
    with tempfile.TemporaryDirectory() as folder:
        whole = kill("SQLite", f"sqlite:///{Path(folder) / 'book.sqlite'}", on_sqlite)
    with server() as running:
        if running is not None:
            whole = kill("PostgreSQL", running.address(running.new_database()), on_server) and whole
    if not whole:
        raise SystemExit(1)


if __name__ == "__main__":
    main(OPTIONS.parse_args())
