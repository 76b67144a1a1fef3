"""Units that were typed differently are made one, parted again, and pointed out."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from atleak.errors import BookError
from atleak.job.parts import JobParts
from atleak.jobs import merge as module
from atleak.jobs.book import Book
from atleak.jobs.merge import duplicates, merge, merged_rows, part

VIN, SLIP = "WVWZZZ1JZXW000001", "WVWZZZ1JZXW000007"
Small = Callable[..., JobParts]


def unit_of(book: Book, id: str) -> int:
    return next(row.unit for row in book.rows() if row.id == id)


def put(book: Book, small_job: Small, *, vin: str = "", plate: str = "", serial: str = "", number: str = "") -> str:
    vehicle = {"vin": vin, "registration": plate}
    return book.save(small_job(number=number, vehicle=vehicle, transmission={"serial": serial})).id


def test_a_typed_slip_is_merged_and_parted_again(book: Book, small_job: Small) -> None:
    right, slip = put(book, small_job, vin=VIN), put(book, small_job, vin=SLIP)
    kept, gone = unit_of(book, right), unit_of(book, slip)
    merge(book, kept, gone)
    assert unit_of(book, right) == unit_of(book, slip) == kept
    later = put(book, small_job, vin=SLIP)
    assert unit_of(book, later) == kept
    assert [(row.id, row.told_by) for row in merged_rows(book, kept)] == [(gone, f"vin:{SLIP}")]
    part(book, gone)
    assert (unit_of(book, right), unit_of(book, slip), unit_of(book, later)) == (kept, gone, gone)
    assert merged_rows(book, kept) == []


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_what_was_merged_into_a_unit_follows_it(book: Book, small_job: Small) -> None:
    units = [unit_of(book, put(book, small_job, vin=vin)) for vin in ("AAAA", "BBBB", "CCCC")]
    merge(book, units[1], units[2])
    merge(book, units[0], units[1])
    assert {row.unit for row in book.rows()} == {units[0]}


def test_two_who_merge_at_the_same_moment_leave_no_unit_between(
    book: Book, small_job: Small, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second, third = (unit_of(book, put(book, small_job, vin=vin)) for vin in ("AAAA", "BBBB", "CCCC"))
    root_of, other = module._root, threading.Thread(target=merge, args=(book, third, second))

    def crossed(*given: Any) -> int:
        root = root_of(*given)
        if given[-1] == first and not other.ident:
            other.start()
            other.join(0.3)  # it waits, or else it is through by now
        return root

    monkeypatch.setattr(module, "_root", crossed)
    merge(book, second, first)
    other.join()
    assert {row.unit for row in book.rows()} == {third}


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_merging_what_is_no_pair_is_refused(book: Book, small_job: Small) -> None:
    unit = unit_of(book, put(book, small_job, vin=VIN))
    with pytest.raises(BookError, match="merged with itself"):
        merge(book, unit, unit)
    with pytest.raises(BookError, match="no such unit"):
        merge(book, unit, unit + 1000)
    with pytest.raises(BookError, match="merged into another"):
        part(book, unit)


def reasons(book: Book) -> list[str]:
    return [pair.reason for pair in duplicates(book)]


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)  # the databases only list the jobs
@pytest.mark.parametrize(
    ("one", "other", "reason"),
    [
        ({"vin": VIN, "serial": "A1"}, {"vin": VIN}, "same_vin"),
        ({"vin": VIN}, {"vin": SLIP}, "vin_within_one_character"),
        ({"vin": VIN}, {"vin": VIN[:5] + VIN[6:]}, "vin_within_one_character"),
        ({"vin": "WVWZZZ1JZXW000012"}, {"vin": "WVWZZZ1JZXW000021"}, "vin_within_one_character"),
        ({"vin": VIN, "plate": "M-AB 1"}, {"plate": "mab1"}, "same_plate"),
        ({"vin": VIN, "plate": "M-AB 1"}, {"vin": SLIP, "plate": "M-AB 2"}, None),  # two cars of a fleet
        ({"vin": VIN, "serial": "A1"}, {"vin": VIN, "serial": "B2"}, None),  # another transmission in the same car
        ({"vin": VIN}, {"vin": "WVWZZZ1JZXW000110"}, None),
        ({"plate": "M-AB 1", "vin": VIN}, {"plate": "M-AB 1", "vin": "OTHERCAR12345678"}, None),  # a plate passed on
        ({}, {}, None),
    ],
)
def test_units_that_may_be_one_are_pointed_out(
    book: Book, small_job: Small, one: dict[str, str], other: dict[str, str], reason: str | None
) -> None:
    put(book, small_job, **one)
    put(book, small_job, **other)
    assert reasons(book) == ([reason] if reason else [])


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_merged_units_and_archived_jobs_are_pointed_out_no_more(book: Book, small_job: Small) -> None:
    ids = [put(book, small_job, vin=vin) for vin in (VIN, SLIP, VIN[:-1])]
    assert reasons(book) == ["vin_within_one_character"] * 3
    merge(book, unit_of(book, ids[0]), unit_of(book, ids[1]))
    assert reasons(book) == ["vin_within_one_character"]
    book.archive(ids[2])
    assert reasons(book) == []
