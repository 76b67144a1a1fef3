"""Declare the tables of the job book, on SQLite and PostgreSQL alike, and put rows into them."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy import (
    Boolean,
    Column,
    Date,
    DateTime,
    Dialect,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
)
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite


class Moment(TypeDecorator[dt.datetime]):
    """A moment in UTC: SQLite hands back datetimes without a zone, PostgreSQL with one."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: dt.datetime | None, dialect: Dialect) -> dt.datetime | None:
        return None if value is None else value.astimezone(dt.UTC)

    def process_result_value(self, value: Any | None, dialect: Dialect) -> dt.datetime | None:
        if value is None:
            return None
        return value.replace(tzinfo=dt.UTC) if value.tzinfo is None else value.astimezone(dt.UTC)


REVISION = "0004"
"""The revision of these tables: the newest of the folder ``migrations``."""

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)


def _id() -> Column[int]:
    return Column("id", Integer, primary_key=True)


def key_of_row(text: str) -> str:
    """Return the letters and digits of what people write with blanks and dashes as they like, in upper case."""
    return "".join(letter for letter in text.upper() if letter.isalnum())[:80]


def _job() -> Column[str]:
    return Column("job", ForeignKey("jobs.id", ondelete="CASCADE"), nullable=False)


about = Table(
    "about",
    metadata,
    Column("atleak", String(40), nullable=False),  # version that made these tables as they are
)

units = Table(
    "units",
    metadata,
    _id(),
    Column("key", String(80), nullable=False, unique=True),  # by serial, else VIN, else plate, else the one job
    Column("serial", String(80), nullable=False),
    # the row that tells the unit and leads to none itself; and the one that was it when this row came to it: that merge
    # is undone by taking it away. Written by `atleak.job_book.merges` alone
    Column("merged_into", ForeignKey("units.id"), index=True),
    Column("merged_with", ForeignKey("units.id")),
)

visits = Table(
    "visits",
    metadata,
    _id(),
    Column("unit", ForeignKey("units.id"), nullable=False, index=True),
    Column("number", String(80), nullable=False),  # the workshop's number of the job; a visit can hold several jobs
    Column("date", Date),
    Column("mileage_km", Float),
)

jobs = Table(
    "jobs",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("version", Integer, nullable=False),  # counts the saves: who saves says which one it saw
    Column("erased", Integer),  # the version of it from which the customer was erased last
    Column("visit", ForeignKey("visits.id"), nullable=False, index=True),
    Column("sample", Boolean, nullable=False),  # made of the shipped sample: no unit of the workshop's
    Column("made_at", Moment, nullable=False),
    Column("made_on", Date),  # that day where it was made
    Column("changed_at", Moment, nullable=False),
    Column("archived_at", Moment),
    Column("choices", LargeBinary, nullable=False),  # content of job.json, compressed
    # what the record and the result say, to look a job up by
    Column("number", String(80), nullable=False),
    Column("date", Date),
    Column("technician", Text, nullable=False),
    Column("customer", Text, nullable=False),
    Column("vin", String(80), nullable=False),
    Column("plate", String(80), nullable=False),
    Column("serial", String(80), nullable=False),
    Column("mileage_km", Float),
    Column("controller", Text, nullable=False),  # id
    Column("verdict", String(40), nullable=False),
    Index(None, "changed_at", "id", "archived_at"),
    Index(None, "verdict", "changed_at"),
    Index(None, "verdict", "controller", "changed_at"),
    Index(None, "controller", "changed_at"),
    Index(None, "date"),
)

search_words = Table(
    "search_words",
    metadata,
    _job(),
    Column("field", String(20), nullable=False),  # number, customer, vin, plate or serial
    # a word of it, and how VIN and serial end: letters and digits, upper case
    Column("word", String(80).with_variant(String(80, collation="C"), "postgresql"), nullable=False),
    Index(None, "word", "field", "job"),
    Index(None, "job", "word", "field"),
)

files = Table(
    "files",
    metadata,
    Column("sha256", String(64), primary_key=True),  # of the content as it came
    Column("size", Integer, nullable=False),  # [bytes] as it came
    Column("content", LargeBinary, nullable=False),  # compressed
)

job_files = Table(
    "job_files",
    metadata,
    _id(),
    _job(),
    Column("slot", String(40), nullable=False),  # of the case, or "picture"
    Column("name", Text, nullable=False),
    Column("sha256", ForeignKey("files.sha256"), nullable=False, index=True),
    Index(None, "job"),
)

log_tables = Table(
    "log_tables",
    metadata,
    Column("job", ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("sha256", String(64), nullable=False),  # of the log
    Column("rows", Integer, nullable=False),
    Column("parquet", LargeBinary, nullable=False),  # the log's channels in SI, as they were understood
)

results = Table(
    "results",
    metadata,
    _id(),
    _job(),
    Column("atleak", String(40), nullable=False),  # version that gave it
    Column("made_at", Moment, nullable=False),
    Column("key", String(64), nullable=False),  # of files and choices, as `Case.key`
    Column("profile", Text, nullable=False),
    Column("controller_sha256", String(64), nullable=False),
    Column("fluid_sha256", String(64), nullable=False),
    Column("readings_sha256", String(64)),
    Column("road_test_sha256", String(64)),
    Column("verdict", String(40), nullable=False),
    Column("record", LargeBinary, nullable=False),  # as `diagnose --json`, compressed
    Index("uq_results_job_atleak", "job", "atleak", unique=True),
)

lands = Table(
    "lands",
    metadata,
    _id(),
    _job(),
    Column("component", Text, nullable=False),
    Column("land", Integer, nullable=False),
    Column("measured", Boolean, nullable=False),
    Column("spool_diameter_mm", Float),
    Column("sleeve_diameter_mm", Float),
    Column("radial_clearance_um", Float),
    Column("uncertainty_um", Float),
    Column("mounting_clearance_um", Float),
    Column("wear_percent", Float),
    Column("verdict", String(40), nullable=False),
    Index(None, "job"),
)

decisions = Table(
    "decisions",
    metadata,
    _id(),
    _job(),
    Column("component", Text, nullable=False),
    Column("land", Integer),
    Column("work", Text, nullable=False),
    Column("decision", String(40), nullable=False),
    Column("reason", Text, nullable=False),
    Column("date", Date),
    Index(None, "job"),
)

customer_links = Table(
    "customer_links",
    metadata,
    _id(),
    _job(),
    Column("token", String(40), nullable=False, unique=True),
    Column("made_at", Moment, nullable=False),
    Column("until", Moment, nullable=False),
    Column("closed_at", Moment),  # by the workshop
    Column("screen", LargeBinary, nullable=False),  # what it shows, as JSON, compressed
    Column("name", String(80), nullable=False),  # of who answered
    Column("answered_at", Moment),
    Column("agreed", Text, nullable=False),  # JSON: yes or no, by the key of the estimate's line
    Index(None, "job"),
)


COPIED = [table for table in metadata.sorted_tables if table is not about]  # what refers to others behind them
_ROWS = 2000  # at a time
_ROWS_WITH_FILES = 20


def put_once(connection: sa.Connection, table: sa.Table, values: Mapping[str, Any]) -> None:
    """Put a row into a table unless one of its key is there, put by whomever in the meantime."""
    insert = insert_postgresql if connection.dialect.name == "postgresql" else insert_sqlite
    connection.execute(insert(table).values(**values).on_conflict_do_nothing())


def replace_rows(connection: sa.Connection, table: sa.Table, job: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Put rows of a job in the place of all that a table has of it."""
    connection.execute(table.delete().where(table.c.job == job))
    if rows:
        connection.execute(table.insert(), [{"job": job, **row} for row in rows])


def copy_rows(source: sa.Connection, target: sa.Connection, *, contents: bool = True) -> None:
    """Copy every row of a book into one without rows, in any order; files and results only with ``contents``."""
    for table in COPIED:
        bulky = [column for column in table.c if isinstance(column.type, sa.LargeBinary)]
        held = [column if contents or column not in bulky else sa.literal(b"").label(column.name) for column in table.c]
        several = _ROWS_WITH_FILES if bulky and contents else _ROWS
        within = [column for column in table.c if any(key.column.table is table for key in column.foreign_keys)]
        later = dict.fromkeys(column.name for column in within)  # to rows of the table that may come behind
        for rows in source.execute(sa.select(*held).execution_options(yield_per=several)).mappings().partitions():
            target.execute(table.insert(), [{**row, **later} for row in rows])
        for column in within:
            to_row = table.update().where(*(key == sa.bindparam("row") for key in table.primary_key))
            leading = sa.select(*table.primary_key, column).where(column.is_not(None))
            if led := [{"row": row[0], "to": row[1]} for row in source.execute(leading)]:
                target.execute(to_row.values({column: sa.bindparam("to")}), led)
