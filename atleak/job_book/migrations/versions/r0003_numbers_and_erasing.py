"""No plan of typed readings for a job's number, and the version of a job by which it was erased.

Which number goes is said by the rule that job files are read by: it is of what 0.2.0 wrote, which changes no more.
"""

import json
import zlib

import sqlalchemy as sa
from alembic import op

from atleak.analysis.record_doubts import without_plan_as_number

revision = "0003"
down_revision = "0002"

_JOBS = sa.table(
    "jobs", *map(sa.column, ("id", "version", "visit", "choices", "number", "mileage_km")), sa.column("date", sa.Date)
)
_VISITS = sa.Table(
    "visits",
    sa.MetaData(),
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("unit", sa.Integer),
    sa.Column("number", sa.String(80)),
    sa.Column("date", sa.Date),
    sa.Column("mileage_km", sa.Float),
)
_FILES = sa.table("files", sa.column("sha256"), sa.column("content"))
_HELD = sa.table("job_files", *map(sa.column, ("job", "slot", "sha256")))
_WORDS = sa.table("search_words", *map(sa.column, ("job", "field")))


def upgrade() -> None:
    """Empty such numbers; jobs that such a number alone had made one visit are visits of their own."""
    op.add_column("jobs", sa.Column("erased", sa.Integer))
    connection = op.get_bind()
    sheets = _HELD.c.job == _JOBS.c.id, _HELD.c.slot == "readings", _FILES.c.sha256 == _HELD.c.sha256
    of_plan = _JOBS.c.number.like('"%')  # as every one does
    for id in connection.execute(sa.select(_JOBS.c.id).where(of_plan).order_by(_JOBS.c.id)).scalars().all():
        row = connection.execute(sa.select(_JOBS, _FILES.c.content).where(_JOBS.c.id == id, *sheets)).one_or_none()
        if row is None:
            continue
        try:
            choices = json.loads(zlib.decompress(row.choices))
            kept = without_plan_as_number(choices, zlib.decompress(row.content))
        except (zlib.error, ValueError):  # damaged: `verify` names it
            continue
        if kept is not choices:
            _empty(connection, row, zlib.compress(json.dumps(kept, ensure_ascii=False).encode()))


def _empty(connection: sa.Connection, row: sa.Row, choices: bytes) -> None:
    visit, own = row.visit, {"number": "", "date": row.date, "mileage_km": row.mileage_km}
    if connection.execute(sa.select(_JOBS.c.id).where(_JOBS.c.visit == visit, _JOBS.c.id != row.id)).first():
        unit = connection.execute(sa.select(_VISITS.c.unit).where(_VISITS.c.id == visit)).scalar_one()
        made = connection.execute(_VISITS.insert().values(unit=unit, **own)).inserted_primary_key
        assert made is not None
        visit = made[0]
    else:
        connection.execute(_VISITS.update().where(_VISITS.c.id == visit).values(**own))
    values = {"number": "", "visit": visit, "choices": choices, "version": row.version + 1}
    connection.execute(_JOBS.update().where(_JOBS.c.id == row.id).values(**values))
    connection.execute(_WORDS.delete().where(_WORDS.c.job == row.id, _WORDS.c.field == "number"))
