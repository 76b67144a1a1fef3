"""Find the job that somebody names: by its id, the id's first characters, or the workshop's number of it."""

from __future__ import annotations

import sqlalchemy as sa

from atleak.errors import BookError, Place
from atleak.jobs.book import Book
from atleak.jobs.tables import jobs, key_of, search_words
from atleak.sentence import Sentence

_SHOWN = 8  # of several that fit
_FEWEST = 4  # characters of an id
_BEHIND = "g"  # sorts behind every further character of an id


def named_job(book: Book, name: str) -> str:
    """Return the id of the job, archived or not, that is named; an id comes before its beginning and a number.

    Raises
    ------
    BookError
        no such job, or several; it names those.
    """
    with book.reading() as connection:
        columns = jobs.c.id, jobs.c.number, jobs.c.customer, jobs.c.date
        found = connection.execute(sa.select(*columns).where(jobs.c.id == name)).all()
        if not found and key_of(name):
            words = sa.select(search_words.c.job).where(
                search_words.c.field == "number", search_words.c.word == key_of(name)
            )
            numbered = connection.execute(sa.select(*columns).where(jobs.c.id.in_(words))).all()
            found = [row for row in numbered if key_of(row.number) == key_of(name)]
            if len(name) >= _FEWEST:
                start = name.lower()
                near = jobs.c.id.between(start, start + _BEHIND)  # which the index of ids answers
                begun = sa.select(*columns).where(near, jobs.c.id.startswith(start, autoescape=True))
                found += [row for row in connection.execute(begun) if row not in found]
    place = Place(file=book.name)
    if not found:
        expected = Sentence("an id as `atleak jobs list` shows it, its first characters, or the number of a job")
        raise BookError(Sentence("the job book has no such job"), place=place, value=name, expected=expected)
    if len(found) > 1:
        several = [
            " ".join(str(part) for part in (row.id, row.number, row.customer, row.date or "") if part) for row in found
        ]
        expected = Sentence("one of {names}", names="; ".join(several[:_SHOWN]))
        if len(several) > _SHOWN:
            expected = Sentence("{names} and {count} more", names=expected, count=len(several) - _SHOWN)
        problem = Sentence("{count} jobs of the job book are called so", count=len(found))
        raise BookError(problem, place=place, value=name, expected=expected)
    return str(found[0].id)
