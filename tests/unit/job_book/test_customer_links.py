"""The addresses at which a customer answers: one job, for a time, whole answers alone, and nothing left when erased."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from typing import Any

import pytest

from atleak.common.errors import BookError
from atleak.job.parts import JobParts
from atleak.job_book.book import Book
from atleak.job_book.customer_links import (
    DAYS,
    CustomerLink,
    close_link,
    link_of,
    links_of_job,
    make_link,
    take_answer,
)
from atleak.job_book.erasure import erase
from atleak.job_book.tables import customer_links
from atleak.measurements.job_card import Customer
from atleak.report.customer_screen import asked_for
from atleak.report.pdf.customer_screen import customer_screen

DECISIONS = ({"component": "tcc_regulator", "land": 1, "price": 120.5, "decision": "proposed"},)


@pytest.fixture
def link(book: Book, small_job: Callable[..., JobParts]) -> CustomerLink:
    parts = small_job(11.09, customer=Customer(name="Ana Lima"), repair_decisions=DECISIONS)
    return make_link(book, book.save(parts).id, customer_screen(parts.diagnosis, parts.job))


def answered(link: CustomerLink, said: str = "yes") -> dict[str, str]:
    return dict.fromkeys(asked_for(link.screen), said)


def change(book: Book, **values: Any) -> None:
    with book.writing() as connection:
        connection.execute(customer_links.update().values(**values))


def test_an_address_leads_to_its_job_for_thirty_days_and_no_other_does(book: Book, link: CustomerLink) -> None:
    assert link_of(book, link.token) == link
    assert (link.until - link.made_at).days == DAYS == 30
    assert len(link.token) * 6 >= 128  # bits, in letters of base 64
    assert link_of(book, link.token[:-1]) is None
    assert link_of(book, "") is None
    change(book, until=dt.datetime.now(dt.UTC) - dt.timedelta(seconds=1))
    assert link_of(book, link.token) is None


def test_an_address_that_was_closed_shows_nothing_and_keeps_what_was_answered(book: Book, link: CustomerLink) -> None:
    assert take_answer(book, link, " Ana  Lima ", answered(link))
    close_link(book, link.id)
    assert link_of(book, link.token) is None
    (kept,) = links_of_job(book, book.rows()[0].id)
    assert kept.closed_at is not None
    assert kept.answer is not None
    assert (kept.answer.name, set(kept.answer.agreed.values())) == ("Ana Lima", {True})


@pytest.mark.parametrize(
    ("name", "said"),
    [("", "yes"), ("   ", "yes"), ("A" * 81, "yes"), ("Ana", ""), ("Ana", "perhaps"), ("Ana", "YES")],
)
def test_what_is_no_whole_answer_is_not_kept(book: Book, link: CustomerLink, name: str, said: str) -> None:
    assert not take_answer(book, link, name, answered(link, said))
    assert not [each.answer for each in links_of_job(book, book.rows()[0].id) if each.answer]


def test_what_an_address_does_not_ask_for_is_left_aside_and_the_last_answer_counts(
    book: Book, link: CustomerLink
) -> None:
    assert take_answer(book, link, "Ana", {**answered(link), "number": "yes", "other/1": "no"})
    assert take_answer(book, link, "Ana", answered(link, "no"))
    (answer,) = [each.answer for each in links_of_job(book, book.rows()[0].id) if each.answer]
    assert answer.agreed == dict.fromkeys(asked_for(link.screen), False)


def test_no_address_is_made_of_a_job_that_the_book_lacks(book: Book, link: CustomerLink) -> None:
    with pytest.raises(BookError):
        make_link(book, "nowhere", link.screen)


def test_erasing_the_customer_takes_the_addresses_away(book: Book, link: CustomerLink) -> None:
    assert take_answer(book, link, "Ana Lima", answered(link))
    erase(book, [book.rows()[0].id])
    assert link_of(book, link.token) is None
    assert not links_of_job(book, book.rows()[0].id)
