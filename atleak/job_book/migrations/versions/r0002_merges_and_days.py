"""Merges that can be undone, none of which leads to a row that leads on; days on which jobs were made; long names.

The table of vehicles goes: nothing read it, and it kept what jobs had stated before.
"""

import datetime as dt

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

_LONG = {"jobs": ("controller",), "results": ("profile",), "lands": ("component",), "decisions": ("component",)}


def upgrade() -> None:
    """Bring the tables and what they hold up to date; the days are those of the zone of the machine that does it."""
    connection = op.get_bind()
    op.execute("ALTER TABLE units ADD COLUMN merged_with INTEGER CONSTRAINT fk_units_merged_with REFERENCES units (id)")
    op.add_column("jobs", sa.Column("made_on", sa.Date))
    op.execute("UPDATE visits SET vehicle = NULL")
    op.execute("DELETE FROM vehicles")
    if connection.dialect.name == "postgresql":  # SQLite counts no letters, and drops no column that leads elsewhere
        op.drop_column("visits", "vehicle")
        op.drop_table("vehicles")
        for table, columns in _LONG.items():
            for column in columns:
                op.alter_column(table, column, type_=sa.Text())
    units = sa.table("units", sa.column("id"), sa.column("merged_into"), sa.column("merged_with"))
    into = {row.id: row.merged_into for row in connection.execute(sa.select(units.c.id, units.c.merged_into))}
    for row, first in into.items():
        last, passed = first, {row}
        while last is not None and into[last] is not None and last not in passed:
            passed.add(last)
            last = into[last]
        if first is not None:
            led = {"merged_with": first, "merged_into": last}
            connection.execute(units.update().where(units.c.id == row).values(**led))
    jobs = sa.table("jobs", sa.column("id"), sa.column("made_at", sa.DateTime(timezone=True)), sa.column("made_on"))
    for id, moment in connection.execute(sa.select(jobs.c.id, jobs.c.made_at)).all():
        day = (moment if moment.tzinfo else moment.replace(tzinfo=dt.UTC)).astimezone().date()
        connection.execute(jobs.update().where(jobs.c.id == id).values(made_on=sa.bindparam("day", day, sa.Date())))
