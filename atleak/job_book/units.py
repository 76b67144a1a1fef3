"""Tell which unit a job is about, and keep what belongs to one visit together.

A unit is told by the transmission's serial number, else by the VIN, else by the plate; a job that states none of them
is a unit of its own. Units that turn out to be one are merged: the row of one leads to the row of the other.
"""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa

from atleak.job.parts import JobParts
from atleak.job_book.tables import jobs, key_of_row, put_once, units, visits


def unit_key(job_id: str, serial: str, vin: str, plate: str) -> str:
    """Return the key by which a job's unit is told; a serial or VIN without a digit, as "unknown", tells none."""
    plate = key_of_row(plate)
    return key_of_numbers(serial, vin) or (f"plate:{plate}" if plate else f"job:{job_id}")


def key_of_numbers(serial: str | None, vin: str | None) -> str | None:
    """Return the key of a unit by its transmission's serial number, or else its vehicle's VIN; None without both.

    >>> key_of_numbers("unknown", "WDB 210 061 1A")
    'vin:WDB2100611A'
    """
    numbers = {"serial": serial or "", "vin": vin or ""}
    keys = {kind: key_of_row(text) for kind, text in numbers.items() if any(letter.isdigit() for letter in text)}
    return next((f"{kind}:{key}"[:80] for kind, key in keys.items() if key), None)


def visit_for(connection: sa.Connection, job_id: str, parts: JobParts, before: int | None) -> int:
    """Return the visit that a job belongs to, made or brought up to date; ``before`` is that of the job so far.

    Jobs of one unit under one number of the workshop are one visit; a job without a number is a visit of its own.
    """
    record = parts.job
    serial, vehicle = record.transmission.serial, record.vehicle
    values = {
        "unit": _unit(connection, unit_key(job_id, serial, vehicle.vin, vehicle.registration), serial),
        "number": record.number[:80],
        "date": record.date,
        "mileage_km": record.mileage_or(parts.diagnosis.mileage),
    }
    same = sa.select(visits.c.id).where(visits.c.unit == values["unit"], visits.c.number == values["number"])
    known = connection.execute(same.order_by(visits.c.id).limit(1)).scalar() if values["number"] else None
    if known is None and before is not None:
        others = sa.select(sa.func.count()).where(jobs.c.visit == before, jobs.c.id != job_id)
        known = before if not connection.execute(others).scalar() else None
    if known is None:
        made = connection.execute(visits.insert().values(**values)).inserted_primary_key
        assert made is not None
        return int(made[0])
    connection.execute(visits.update().where(visits.c.id == known).values(**values))
    return int(known)


def _unit(connection: sa.Connection, key: str, serial: str) -> int:
    """Return the row of a unit, made where there is none; that of a merged one is the one it leads to."""
    wanted = sa.select(sa.func.coalesce(units.c.merged_into, units.c.id)).where(units.c.key == key)
    row = connection.execute(wanted).scalar()
    if row is None:
        put_once(connection, units, {"key": key, "serial": serial[:80]})
        row = connection.execute(wanted).scalar_one()
    return int(row)


def drop_empty(connection: sa.Connection, left: tuple[int, int] | None = None) -> None:
    """Delete every visit and unit that no job has, or of one visit and its unit what corrected typing leaves so."""
    other = units.alias()
    every = sa.true(), sa.true()
    visit, unit = every if left is None else (visits.c.id == left[0], units.c.id == left[1])
    connection.execute(visits.delete().where(visit, ~sa.exists().where(jobs.c.visit == visits.c.id)))
    leads_none = units.c.merged_into.is_(None) & ~sa.exists().where(other.c.merged_into == units.c.id)
    connection.execute(units.delete().where(unit, leads_none, ~sa.exists().where(visits.c.unit == units.c.id)))


def final_unit() -> sa.ColumnElement[int]:
    """Return the unit of a visit as a column, merged ones as the one they lead to; beside the table of visits."""
    merged = sa.select(units.c.merged_into).where(units.c.id == visits.c.unit).scalar_subquery()
    return sa.func.coalesce(merged, visits.c.unit)


def rows_of_unit(unit: int) -> sa.Select[Any]:
    """Return the statement that selects the rows of a unit: its own, and those that were merged into it."""
    return sa.select(units.c.id).where((units.c.id == unit) | (units.c.merged_into == unit))


def unit_of_job(connection: sa.Connection, visit: int) -> int:
    """Return the unit of a visit, the one it leads to where it was merged."""
    return int(connection.execute(sa.select(final_unit()).where(visits.c.id == visit)).scalar_one())
