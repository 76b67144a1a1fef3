"""The job book on both of its databases: a test that asks for `book` runs on SQLite and on a real PostgreSQL server."""

from __future__ import annotations

import functools
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from atleak.catalogue.entries import catalogue_files
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book, open_book
from atleak.job_book.tables import REVISION, about, metadata
from atleak.measurements.job_card import Job


@pytest.fixture(scope="session")
def postgresql(benchmark_of: Callable[[str], ModuleType]) -> Iterator[Any]:
    """A PostgreSQL server for the tests of this process, started by the first test that asks."""
    module = benchmark_of("postgresql")
    try:
        module.programs()
    except module.NoServer as error:
        pytest.skip(f"{error}; the same tests run on SQLite")
    with module.running() as server:
        yield server


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest) -> str:
    """The kind of database that a test runs on: each test of a book runs on both."""
    return request.param


@pytest.fixture(scope="session")
def sqlite_template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty book as a file to be copied, which is quicker than making it anew for every test."""
    path = tmp_path_factory.mktemp("template") / "book.sqlite"
    open_book(f"sqlite:///{path}").engine.dispose()
    return path


@pytest.fixture(scope="session")
def emptied() -> list[str]:
    """Addresses of books on PostgreSQL that earlier tests have left empty: quicker than new databases of 7 MB each."""
    return []


@pytest.fixture
def new_book_on(request: pytest.FixtureRequest, tmp_path: Path, emptied: list[str]) -> Iterator[Callable[[str], Book]]:
    """Opens books without a job, each in a database of its own, of the kind that is asked for."""
    opened: list[Book] = []

    def make(kind: str) -> Book:
        if kind == "sqlite":
            path = tmp_path / f"book_{len(opened)}.sqlite"
            shutil.copyfile(request.getfixturevalue("sqlite_template"), path)
            address = f"sqlite:///{path}"
        elif not (address := emptied.pop() if emptied else ""):
            server = request.getfixturevalue("postgresql")
            address = server.address(server.new_database())
        opened.append(open_book(address))
        return opened[-1]

    yield make
    for book in opened:
        if book.engine.dialect.name == "postgresql":
            _empty(book, emptied)
        book.engine.dispose()


def _empty(book: Book, emptied: list[str]) -> None:
    with book.writing() as connection:
        for table in reversed([table for table in metadata.sorted_tables if table is not about]):
            connection.execute(table.delete())
        if connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar_one() == REVISION:
            emptied.append(book.engine.url.render_as_string())


@pytest.fixture
def new_book(database: str, new_book_on: Callable[[str], Book]) -> Callable[[], Book]:
    """Opens books without a job, on the database of the test."""
    return lambda: new_book_on(database)


@pytest.fixture
def book(new_book: Callable[[], Book]) -> Book:
    """A book without a job."""
    return new_book()


@pytest.fixture(scope="session")
def small_job() -> Callable[..., JobParts]:
    """Makes a job of one land of the minimal example; the keywords are those of its record."""

    @functools.cache
    def diagnosed(sleeve: float) -> tuple[Case, Diagnosis]:
        rows = ["component,part,plane,direction,diameter [mm]"]
        for direction in (0, 90):
            rows += [f"tcc_regulator,spool,1,{direction},11.000", f"tcc_regulator,sleeve,1,{direction},{sleeve:.3f}"]
        case = Case(readings=SourceFile("small.csv", "\n".join(rows).encode()), controller="minimal_example")
        return case, case.diagnose()

    def make(sleeve: float = 11.04, **record: Any) -> JobParts:
        case, diagnosis = diagnosed(sleeve)
        return job_parts(diagnosis, Job(**record), case)

    return make


@pytest.fixture
def with_repair() -> Callable[[Case], Case]:
    """Puts repairs into the valve body's file of a case: of the regulator's first land, and a cleaning of the TCC's."""
    repair = """
[[repairs]]
id = "oversize"
component = "pressure_regulator"
lands = [1]
kind = "oversize_valve"
name = "oversize regulator valve"
nominal_diameter_mm = 15.8
mounting_clearance_um = [10.0, 14.0]
source = "made up for this test"
evidence = "representative"

[[repairs]]
id = "clean"
component = "tcc_regulator"
kind = "clean_and_reuse"
name = "clean and reuse"
source = "made up for this test"
"""
    content = catalogue_files("controllers")["minimal_example"].read_bytes() + repair.encode()

    def changed(case: Case) -> Case:
        return replace(case, controller=SourceFile("own.toml", content))

    return changed
