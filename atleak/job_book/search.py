"""Look jobs up in the book by what a workshop knows of them."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from atleak.job_book.tables import jobs, key_of_row, search_words, visits
from atleak.job_book.units import final_unit, rows_of_unit
from atleak.measurements.job_card import Job

_KNOWN_BY_THEIR_END = ("vin", "serial")
_ENDS = range(4, 9)  # characters of that end
_EVERY = chr(0x10FFFF)  # sorts behind every letter
_MANY = 4000  # words: the jobs of fewer are sooner fetched and sorted than the newest jobs are looked through


@dataclass(frozen=True)
class Query:
    """What to look for; everything that is given must fit."""

    text: str = (
        ""  # beginnings of words of number, customer, VIN, plate or serial, ends of VIN or serial, or a valve body's id
    )
    vin: str = ""
    plate: str = ""
    serial: str = ""
    customer: str = ""
    number: str = ""
    date_from: dt.date | None = None
    date_to: dt.date | None = None
    verdict: str = ""
    controller: str = ""
    unit: int | None = None
    archived: bool | None = False  # those that were archived instead of the others; None: all of them
    limit: int | None = 200
    offset: int = 0


def search_words_of(record: Job) -> set[tuple[str, str]]:
    """Return the words by which a job is found, each with the field it stands in."""
    vehicle, customer = record.vehicle, record.customer
    texts = {
        "number": (record.number,),
        "customer": (customer.name, customer.number),
        "vin": (vehicle.vin,),
        "plate": (vehicle.registration,),
        "serial": (record.transmission.serial,),
    }
    words = {
        (field, key_of_row(word))
        for field, several in texts.items()
        for text in several
        for word in (text, *text.split())
    }
    for field, whole in [*words]:
        if field in _KNOWN_BY_THEIR_END:
            words |= {(field, whole[-count:]) for count in _ENDS if count < len(whole)}
    return {(field, word) for field, word in words if word}


def found_by(connection: sa.Connection, query: Query) -> sa.Select[Any]:
    """Return the statement that selects the columns of a `JobRow`."""
    columns = [
        jobs.c[name]
        for name in (
            *("id", "number", "vin", "plate", "serial", "customer", "date", "controller", "verdict", "mileage_km"),
            *("visit", "made_on", "changed_at", "archived_at", "sample"),
        )
    ]
    statement = sa.select(*columns, final_unit().label("unit")).join(visits, visits.c.id == jobs.c.visit)
    statement = statement.where(*_conditions(connection, query))
    return statement.order_by(jobs.c.changed_at.desc(), jobs.c.id.desc()).limit(query.limit).offset(query.offset)


def counted_by(connection: sa.Connection, query: Query) -> sa.Select[Any]:
    """Return the statement that counts all jobs that a query asks for."""
    return sa.select(sa.func.count()).select_from(jobs).where(*_conditions(connection, query))


def _conditions(connection: sa.Connection, query: Query) -> Iterator[sa.ColumnElement[bool]]:
    if query.archived is not None:
        is_archived = jobs.c.archived_at.is_not(None)
        yield is_archived if query.archived else ~is_archived
    asked = [("", word) for word in query.text.split()]
    asked += [(field, getattr(query, field)) for field in ("vin", "plate", "serial", "customer", "number")]
    for field, word in asked:
        if start := key_of_row(word):
            found = _has_word(connection, field, start)
            is_id = not field and _is_controller(connection, word)
            yield sa.or_(jobs.c.controller == word, found) if is_id else found
    if query.date_from is not None:
        yield jobs.c.date >= query.date_from
    if query.date_to is not None:
        yield jobs.c.date <= query.date_to
    if query.verdict:
        yield jobs.c.verdict == query.verdict
    if query.controller:
        yield jobs.c.controller == query.controller
    if query.unit is not None:
        yield jobs.c.visit.in_(sa.select(visits.c.id).where(visits.c.unit.in_(rows_of_unit(query.unit))))


def _is_controller(connection: sa.Connection, word: str) -> bool:
    """Tell whether a word is the id of a valve body that the book has jobs of, as a measuring sheet's code says it."""
    held = sa.select(sa.literal(1)).where(jobs.c.controller == word).limit(1)
    return connection.execute(held).first() is not None


def _has_word(connection: sa.Connection, field: str, start: str) -> sa.ColumnElement[bool]:
    """Return the condition that a job has a word that begins so, in a field or in any.

    The jobs of a rare word are looked up by the word. One that very many jobs have, such as a first letter, is looked
    up in the newest jobs one by one, until as many have it as are asked for.
    """
    fits = [search_words.c.word >= start, search_words.c.word < start + _EVERY]
    if field:
        fits.append(search_words.c.field == field)
    some = sa.select(sa.literal(1)).where(*fits).limit(_MANY).subquery()
    if connection.execute(sa.select(sa.func.count()).select_from(some)).scalar_one() < _MANY:
        return jobs.c.id.in_(sa.select(search_words.c.job).where(*fits))
    return sa.exists().where(search_words.c.job == jobs.c.id, *fits)


def controllers_held(connection: sa.Connection) -> list[str]:
    """Return the ids of the valve bodies of which the book holds jobs."""
    return list(connection.execute(sa.select(jobs.c.controller).distinct().order_by(jobs.c.controller)).scalars())
