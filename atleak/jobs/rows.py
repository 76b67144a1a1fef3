"""Put rows into tables and copy them, with what the two databases call differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite

from atleak.jobs.tables import about, metadata

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
    """Copy every row of a book into one without rows, whatever their order.

    Parameters
    ----------
    contents
        whether files and results come along; rows alone show whether they fit together.
    """
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
