"""Keep the addresses at which a customer sees one job and says yes or no to its repairs, and what he said."""

from __future__ import annotations

import datetime as dt
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from atleak.common.sentences import Sentence
from atleak.job_book.book import Book, packed
from atleak.job_book.tables import customer_links
from atleak.measurements.job_card import clean_text
from atleak.report.customer_screen import LETTERS, Answer, asked_for

DAYS = 30  # for which an address is good
_BYTES = 16  # of its secret: 128 random bits


@dataclass(frozen=True)
class CustomerLink:
    """An address of one job."""

    id: int
    token: str  # the secret in it
    made_at: dt.datetime
    until: dt.datetime
    closed_at: dt.datetime | None  # by the workshop
    screen: dict[str, Any]  # what it shows
    answer: Answer | None  # the one that was given last

    @property
    def open(self) -> bool:
        """Tell whether it still shows anything."""
        return self.closed_at is None and dt.datetime.now(dt.UTC) < self.until


def make_link(book: Book, job: str, screen: Mapping[str, Any]) -> CustomerLink:
    """Make an address that shows a screen of a job of the book, and return it.

    Raises
    ------
    BookError
        a database that cannot be used, or a job that it does not have.
    """
    book.version(job)
    token, now = secrets.token_urlsafe(_BYTES), dt.datetime.now(dt.UTC)
    values = {"job": job, "token": token, "made_at": now, "until": now + dt.timedelta(days=DAYS)}
    content = packed(json.dumps(screen, ensure_ascii=False).encode())
    with book.writing() as connection:
        connection.execute(customer_links.insert().values(**values, screen=content, name="", agreed="{}"))
    link = link_of(book, token)
    assert link is not None
    return link


def link_of(book: Book, token: str) -> CustomerLink | None:
    """Return an address by its secret; None where there is none, or none any more that shows anything."""
    found = _found(book, customer_links.c.token == token)
    return next((each for each in found if each.open), None)


def links_of_job(book: Book, job: str) -> list[CustomerLink]:
    """Return the addresses of a job, the newest first, closed ones too."""
    return _found(book, customer_links.c.job == job)


def close_link(book: Book, id: int) -> None:
    """Close an address: it shows nothing from now on; what was answered stays."""
    with book.writing() as connection:
        now = dt.datetime.now(dt.UTC)
        connection.execute(customer_links.update().where(customer_links.c.id == id).values(closed_at=now))


def take_answer(book: Book, link: CustomerLink, name: str, said: Mapping[str, str]) -> bool:
    """Keep what a customer answered; return whether it was a whole answer to an open address: else nothing is kept.

    Parameters
    ----------
    name
        as typed.
    said
        ``yes`` or ``no`` by the key of every line that the address asks about; anything else is left aside.
    """
    name, asked = clean_text(" ".join(name.split())), asked_for(link.screen)
    if not name or len(name) > LETTERS or not asked or any(said.get(key) not in ("yes", "no") for key in asked):
        return False
    now = dt.datetime.now(dt.UTC)
    values = {
        "name": name,
        "answered_at": now,
        "agreed": json.dumps({key: said[key] == "yes" for key in asked}),
    }
    with book.writing() as connection:
        still_open = customer_links.c.id == link.id, customer_links.c.closed_at.is_(None), customer_links.c.until > now
        return connection.execute(customer_links.update().where(*still_open).values(**values)).rowcount == 1


def _found(book: Book, which: sa.ColumnElement[bool]) -> list[CustomerLink]:
    with book.reading() as connection:
        newest = sa.select(customer_links).where(which).order_by(customer_links.c.id.desc())
        rows = connection.execute(newest).all()
    return [
        CustomerLink(
            row.id,
            row.token,
            row.made_at,
            row.until,
            row.closed_at,
            json.loads(book.unpacked(row.screen, Sentence("what a customer is shown"))),
            None if row.answered_at is None else Answer(row.name, row.answered_at, json.loads(row.agreed)),
        )
        for row in rows
    ]
