"""Put rows into tables, with what the two databases call differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite


def put_once(connection: sa.Connection, table: sa.Table, values: Mapping[str, Any]) -> None:
    """Put a row into a table unless one of its key is there, put by whomever in the meantime."""
    insert = insert_postgresql if connection.dialect.name == "postgresql" else insert_sqlite
    connection.execute(insert(table).values(**values).on_conflict_do_nothing())


def replace_rows(connection: sa.Connection, table: sa.Table, job: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Put rows of a job in the place of all that a table has of it."""
    connection.execute(table.delete().where(table.c.job == job))
    if rows:
        connection.execute(table.insert(), [{"job": job, **row} for row in rows])
