"""Looking jobs up gives the same whichever way the database goes about it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from atleak.job.parts import JobParts
from atleak.job_book.book import Book
from atleak.job_book.search import Query

QUERIES = [
    Query(text="k"),
    Query(text="kr 2026"),
    Query(customer="nowak"),
    Query(customer="nowak", verdict="watch"),
    Query(vin="wdb1", text="ana"),
    Query(text="no such word"),
    Query(text="2026-3 minimal_example"),  # as the code of a measuring sheet has it
    Query(text="2026-3 four_speed_2023"),
]


def test_jobs_of_a_word_that_very_many_have_are_those_that_a_rare_word_would_give(
    book: Book, small_job: Callable[..., JobParts], monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(6):
        record = {
            "number": f"2026-{number}",
            "customer": {"name": "Ana Nowak" if number % 2 else "Kowalski", "number": f"K{number}"},
            "vehicle": {"vin": f"WDB{number % 3}", "registration": f"KR {number}"},
        }
        book.save(small_job(11.04 if number < 4 else 11.02, **record))
    rare = [[row.number for row in book.rows(query)] for query in QUERIES]
    assert [len(numbers) for numbers in rare] == [6, 6, 3, 2, 1, 0, 1, 0]
    monkeypatch.setattr("atleak.job_book.search._MANY", 1)
    assert [[row.number for row in book.rows(query)] for query in QUERIES] == rare
    assert [book.count(query) for query in QUERIES] == [6, 6, 3, 2, 1, 0, 1, 0]
