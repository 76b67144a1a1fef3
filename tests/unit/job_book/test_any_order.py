"""Whatever is done to a book and in which order: nothing that was saved is lost, mixed or left where it was erased."""

from __future__ import annotations

import shutil
import tempfile
import zlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import sqlalchemy as sa
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from atleak.job.parts import JobParts
from atleak.job_book.backup import backup, restore, verify
from atleak.job_book.book import Book
from atleak.job_book.erasure import erase
from atleak.job_book.exchange import import_job, job_file
from atleak.job_book.merges import merge, part
from atleak.job_book.search import Query
from atleak.job_book.tables import metadata, units
from atleak.job_book.units import unit_key

Small = Callable[..., JobParts]

SERIALS, VINS, PLATES = ("", "SER1111", "SER2222"), ("", "WVWAAA0000000001", "WVWBBB0000000002"), ("", "PL-1A")
RECORDS = st.fixed_dictionaries(
    {
        "number": st.sampled_from(["", "NR7001", "NR8002"]),
        "customer": st.sampled_from(["", "Kowalska", "Lindqvist"]),
        "serial": st.sampled_from(SERIALS),
        "vin": st.sampled_from(VINS),
        "plate": st.sampled_from(PLATES),
    }
)
WHICH = st.integers(0, 99)


@dataclass
class Known:
    """A job as it was acknowledged."""

    version: int
    record: dict[str, str]
    sample: bool
    archived: bool = False
    erased: bool = False
    said: set[str] = field(default_factory=set)  # every text that any version of it stated


class AnyOrder(RuleBasedStateMachine):
    """What a workshop does to its book, beside what it must hold then."""

    def __init__(self, new_book: Callable[[], Book], small_job: Small) -> None:
        super().__init__()
        self.new_book, self.small_job = new_book, small_job
        self.book = new_book()
        self.folder = Path(tempfile.mkdtemp())
        self.known: dict[str, Known] = {}
        self.leads: dict[str, str] = {}  # what tells a unit, and the unit into which it was merged
        self.moved: list[tuple[int, str]] = []  # rows that were merged, and what tells them
        self.told = True  # whether records alone still tell the units

    def teardown(self) -> None:
        if self.known:
            assert verify(self.book) == ()
        shutil.rmtree(self.folder)

    # --- what is known

    def one(self, which: int) -> str:
        return list(self.known)[which % len(self.known)]

    def parts(self, record: dict[str, str]) -> JobParts:
        return self.small_job(
            number=record["number"],
            customer={"name": record["customer"]},
            vehicle={"vin": record["vin"], "registration": record["plate"]},
            transmission={"serial": record["serial"]},
        )

    def key(self, id: str) -> str:
        record = self.known[id].record
        return unit_key(id, record["serial"], record["vin"], record["plate"])

    def root(self, key: str) -> str:
        return self.root(self.leads[key]) if key in self.leads else key

    def units(self) -> set[frozenset[str]]:
        """The jobs of the book, those of one unit together."""
        together = defaultdict(set)
        for row in self.book.rows(Query(archived=None, limit=None)):
            together[row.unit].add(row.id)
        return {frozenset(ids) for ids in together.values()}

    def row(self, id: str) -> int:
        return next(row.unit for row in self.book.rows(Query(archived=None, limit=None)) if row.id == id)

    # --- what is done

    @initialize(
        records=st.tuples(RECORDS, RECORDS, RECORDS), pairs=st.lists(st.tuples(WHICH, WHICH), min_size=1, max_size=2)
    )
    def first(self, records: tuple[dict[str, str], ...], pairs: list[tuple[int, int]]) -> None:
        """Begin with three units, one of which nothing tells, and the merges of some of them."""
        for record, serial in zip(records, SERIALS, strict=True):
            none = {"vin": "", "plate": ""} if not serial else {}
            self.save({**record, "serial": serial, **none}, sample=False)
        for one, other in pairs:
            self.merge_two(one, other)

    @rule(record=RECORDS, sample=st.booleans())
    def save(self, record: dict[str, str], sample: bool) -> None:
        saved = self.book.save(self.parts(record), sample=sample)
        self.known[saved.id] = Known(saved.version, record, sample, said=set(record.values()))

    @rule(which=WHICH, record=RECORDS, same_unit=st.booleans())
    def save_again(self, which: int, record: dict[str, str], same_unit: bool) -> None:
        known = self.known[id := self.one(which)]
        if same_unit:
            record = {**record, **{name: known.record[name] for name in ("serial", "vin", "plate")}}
        known.version = self.book.save(self.parts(record), id=id, version=known.version, sample=known.sample).version
        known.record, known.said, known.erased = record, known.said | set(record.values()), False

    @rule(which=WHICH)
    def archive(self, which: int) -> None:
        known = self.known[id := self.one(which)]
        self.book.archive(id, back=known.archived)
        known.archived = not known.archived

    @rule(one=WHICH, other=WHICH)
    def merge_two(self, one: int, other: int) -> None:
        several = sorted(self.units(), key=lambda unit: min(map([*self.known].index, unit)))
        if len(several) == 1:
            return
        into = several.pop(one % len(several))
        ids = [min(unit, key=[*self.known].index) for unit in (into, several[other % len(several)])]
        kept, gone = map(self.row, ids)
        before = self.units()
        part(self.book, merge(self.book, kept, gone))
        assert self.units() == before
        row = merge(self.book, kept, gone)
        if self.told:
            to, away = (self.root(self.key(id)) for id in ids)
            self.leads[away] = to
            self.moved.append((row, away))
        assert self.row(ids[0]) == self.row(ids[1])

    @precondition(lambda self: self.moved and self.told)
    @rule(which=WHICH)
    def part_again(self, which: int) -> None:
        row, key = self.moved.pop(which % len(self.moved))
        part(self.book, row)
        del self.leads[key]

    @rule(which=WHICH, order=st.randoms(use_true_random=False), whole=st.booleans())
    def erase_some(self, which: int, order: Random, whole: bool) -> None:
        """Erase one job, or all of its unit in any order."""
        ids = [self.one(which)]
        if whole:
            of_unit = next(unit for unit in self.units() if ids[0] in unit)
            ids = [id for id in self.known if id in of_unit]
            order.shuffle(ids)
        before = self.units()
        erase(self.book, ids)
        self.told = False
        for id in ids:
            self.known[id].erased = True
            self.known[id].version += 1
            self.known[id].record = dict.fromkeys(self.known[id].record, "")
        if any(set(ids) <= unit for unit in before):
            assert any(set(ids) <= unit for unit in self.units())
        others = [known.said for known in self.known.values() if not known.erased]
        gone = set().union(*(self.known[id].said for id in ids)).difference(*others, {""})
        left = everything(self.book)
        assert not [text for text in gone if text in left or text.replace("-", "") in left]

    @rule()
    def back_up_and_restore(self) -> None:
        path = self.folder / "backup"
        assert backup(self.book, path) == len(self.known)
        before, other = rows(self.book), self.new_book()
        assert restore(path, other) == len(self.known)
        assert rows(other) == before
        assert restore(path, self.book, force=True) == len(self.known)
        assert rows(self.book) == before

    @rule()
    def take_to_another_book(self) -> None:
        other = self.new_book()
        for id, known in self.known.items():
            taken = import_job(other, job_file(self.book, id))
            stored = other.load(taken.id)
            if not taken.known:  # else an equal job was taken in before
                assert (stored.sample, stored.archived_at is not None) == (known.sample, known.archived)
            assert stored.file.job.number == known.record["number"]

    # --- what must hold

    @invariant()
    def is_whole(self) -> None:
        held = {row.id: row for row in self.book.rows(Query(archived=None, limit=None))}
        assert set(held) == set(self.known)
        for id, known in self.known.items():
            row = held[id]
            said = {name: getattr(row, name) for name in known.record}
            assert said == known.record
            assert (row.sample, row.archived_at is not None) == (known.sample, known.archived)
            assert self.book.version(id) == known.version
        if self.told:
            together = defaultdict(set)
            for id in self.known:
                together[self.root(self.key(id))].add(id)
            assert self.units() == {frozenset(ids) for ids in together.values()}
        leading, led = units.alias(), units.alias()
        chains = (
            sa.select(leading.c.id).join(led, led.c.id == leading.c.merged_into).where(led.c.merged_into.is_not(None))
        )
        with self.book.reading() as connection:
            assert connection.execute(chains).all() == []


def rows(book: Book) -> dict[str, list[tuple[Any, ...]]]:
    with book.reading() as connection:
        return {
            table.name: sorted(map(tuple, connection.execute(sa.select(table))), key=repr)
            for table in metadata.sorted_tables
        }


def everything(book: Book) -> str:
    """All that the tables hold, unpacked."""
    said = []
    for table in rows(book).values():
        for value in (value for row in table for value in row):
            try:
                said.append(
                    zlib.decompress(value).decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
                )
            except zlib.error:
                said.append(repr(value))  # a table of channels
    return "\n".join(said)


def test_nothing_is_lost_or_mixed_in_any_order(new_book: Callable[[], Book], small_job: Small) -> None:
    run_state_machine_as_test(
        lambda: AnyOrder(new_book, small_job),
        settings=settings(max_examples=max(settings().max_examples // 8, 4), stateful_step_count=6),
    )
