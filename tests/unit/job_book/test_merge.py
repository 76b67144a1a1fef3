"""Units that were typed differently are made one, parted again, and pointed out."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError
from atleak.job.parts import JobParts
from atleak.job_book import merges as module
from atleak.job_book.backup import backup, restore, verify
from atleak.job_book.book import Book
from atleak.job_book.erasure import erase
from atleak.job_book.merges import duplicates, merge, merged_rows, part
from atleak.job_book.tables import units

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
    root_of, other = module.root_of, threading.Thread(target=merge, args=(book, third, second))

    def crossed(*given: Any) -> int:
        root = root_of(*given)
        if given[-1] == first and not other.ident:
            other.start()
            other.join(0.3)  # it waits, or else it is through by now
        return root

    monkeypatch.setattr(module, "root_of", crossed)
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


def partition(book: Book) -> set[frozenset[str]]:
    """The numbers of the jobs of each unit."""
    units = {row.unit for row in book.rows()}
    return {frozenset(row.number for row in book.rows() if row.unit == unit) for unit in units}


@pytest.fixture
def three(book: Book, small_job: Small) -> list[int]:
    """The units of three jobs."""
    return [unit_of(book, put(book, small_job, vin=VIN[:-1] + number, number=number)) for number in "123"]


def test_undoing_a_merge_leaves_those_before_it(book: Book, three: list[int]) -> None:
    merge(book, three[0], three[1])
    moved = merge(book, three[2], three[0])  # a slip
    assert partition(book) == {frozenset("123")}
    part(book, moved)
    assert partition(book) == {frozenset("12"), frozenset("3")}
    part(book, three[1])
    assert partition(book) == {frozenset("1"), frozenset("2"), frozenset("3")}


def test_a_merge_is_undone_by_the_row_that_it_names(book: Book, three: list[int]) -> None:
    merge(book, three[0], three[1])
    moved = merge(book, three[2], three[1])
    assert moved == three[0]  # of which the second one is part
    part(book, moved)
    assert partition(book) == {frozenset("12"), frozenset("3")}


def test_an_earlier_merge_is_undone_and_the_later_one_stays(book: Book, three: list[int]) -> None:
    merge(book, three[0], three[1])
    merge(book, three[2], three[0])
    part(book, three[1])
    assert partition(book) == {frozenset("13"), frozenset("2")}


def test_jobs_of_one_number_that_share_a_visit_only_by_a_merge_are_told_apart_again(
    book: Book, small_job: Small
) -> None:
    numbered = [{"vin": vin, "number": "7"} for vin in (VIN, SLIP)]
    right, slip = (put(book, small_job, **each) for each in numbered)
    moved = merge(book, unit_of(book, right), unit_of(book, slip))
    later = put(book, small_job, vin=SLIP, number="7")
    assert len({row.visit for row in book.rows() if row.id in (right, later)}) == 1
    part(book, moved)
    assert unit_of(book, right) != unit_of(book, slip) == unit_of(book, later)
    visits = {row.id: row.visit for row in book.rows()}
    assert visits[slip] == visits[later] != visits[right]
    assert verify(book) == ()


def test_what_told_a_unit_is_gone_with_its_last_job(book: Book, small_job: Small) -> None:
    first, second = (put(book, small_job, vin=vin) for vin in (VIN, SLIP))
    moved = merge(book, unit_of(book, first), unit_of(book, second))
    book.save(small_job(vehicle={"vin": "OTHERCAR12345678"}), id=first, version=1)
    part(book, moved)
    with book.reading() as connection:
        assert set(connection.execute(sa.select(units.c.key)).scalars()) == {f"vin:{SLIP}", "vin:OTHERCAR12345678"}


def test_after_merging_and_erasing_the_book_is_backed_up_and_restored(
    new_book: Callable[[], Book], small_job: Small, tmp_path: Path
) -> None:
    """Whatever the order in which jobs are erased: no unit leads to one that leads on."""
    for number, order in enumerate(((0, 1), (1, 0))):
        book, restored = new_book(), new_book()
        ids = [put(book, small_job), put(book, small_job, serial="A1")]
        merge(book, unit_of(book, ids[1]), unit_of(book, ids[0]))
        erase(book, [ids[each] for each in order])
        assert len({row.unit for row in book.rows()}) == 1
        assert verify(book) == ()
        backup(book, tmp_path / f"{number}.backup")
        assert restore(tmp_path / f"{number}.backup", restored) == 2
        assert {row.id: row.unit for row in restored.rows()} == {row.id: row.unit for row in book.rows()}


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_unit_that_leads_to_one_that_leads_on_is_no_whole_book(book: Book, three: list[int]) -> None:
    merge(book, three[0], three[1])
    with book.writing() as connection:
        connection.execute(units.update().where(units.c.id == three[0]).values(merged_into=three[2]))
    (*faults,) = map(str, verify(book))
    assert faults
    assert all("which is no unit of its own" in fault for fault in faults)
