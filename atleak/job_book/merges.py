"""Make one of two units that were typed differently, undo that, and say which units may be one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal

import sqlalchemy as sa

from atleak.common.errors import BookError, Place
from atleak.common.sentences import Sentence, in_a_row
from atleak.job_book.book import Book
from atleak.job_book.tables import jobs, key_of_row, units, visits
from atleak.job_book.units import drop_empty, final_unit, rows_of_unit, unit_key

Reason = Literal["same_vin", "vin_within_one_character", "same_plate"]
REASONS: dict[Reason, Sentence] = {
    "same_vin": Sentence("the same VIN, the serial stated only once"),
    "vin_within_one_character": Sentence("VINs that differ in one character"),
    "same_plate": Sentence("the same plate"),
}


_PLACEHOLDER = 20  # units of one VIN or plate: so many share what somebody types where none is known
_SHORTEST = 8  # characters of a VIN that may be another one mistyped; older cars have fewer than 17


@dataclass
class UnitSeen:
    """What the jobs of a unit state of it: how each was typed."""

    id: int
    jobs: list[str] = field(default_factory=list)  # ids, archived ones left out
    serials: set[str] = field(default_factory=set)
    vins: set[str] = field(default_factory=set)
    plates: set[str] = field(default_factory=set)
    customers: set[str] = field(default_factory=set)

    @property
    def in_words(self) -> Sentence:
        """Return the unit in words."""
        sentences = [
            self.serials and Sentence("serial {texts}", texts=sorted(self.serials)),
            self.vins and Sentence("VIN {texts}", texts=sorted(self.vins)),
            self.plates and Sentence("plate {texts}", texts=sorted(self.plates)),
            *sorted(self.customers),
        ]
        parts = [part for part in sentences if isinstance(part, str)]
        return in_a_row(parts) if parts else Sentence("nothing that tells it")


@dataclass(frozen=True)
class Duplicate:
    """Two units that may be one."""

    one: UnitSeen
    other: UnitSeen
    reason: Reason

    @property
    def why(self) -> Sentence:
        """Return what speaks for it."""
        return REASONS[self.reason]


@dataclass(frozen=True)
class MergedRow:
    """A unit that was merged into another one."""

    id: int
    told_by: str  # kind and text by which jobs told it: serial:A123


# --- merging


def merge(book: Book, unit: int, other: int) -> int:
    """Make two units one: jobs of both stand on one page from now on, also those that are typed the other way later.

    Parameters
    ----------
    unit
        that stays.
    other
        that leads to it; where it was merged before, the unit that it is part of does.

    Returns
    -------
    int
        the row that leads to the other one now: `part` of it undoes this merge.

    Raises
    ------
    BookError
        a unit that the book does not have; twice the same one.
    """
    with book.writing() as connection:
        kept, gone = (root_of(connection, book, each) for each in (unit, other))
        if kept == gone:
            already = Sentence("these are one unit already")
            problem = already if unit != other else Sentence("a unit cannot be merged with itself")
            raise BookError(problem, place=Place(file=book.name), value=other, expected=Sentence("two units"))
        lead(connection, gone, kept)
    return gone


def lead(connection: sa.Connection, gone: int, kept: int) -> None:
    """Let one unit lead to another, with all that lead to it; neither leads anywhere yet, as `root_of` gives them."""
    connection.execute(units.update().where(units.c.id == gone).values(merged_with=kept))
    connection.execute(units.update().where(units.c.id.in_(rows_of_unit(gone))).values(merged_into=kept))


def part(book: Book, row: int) -> None:
    """Undo a merge: the unit stands by itself again as it did before, with the units that had been merged into it.

    Jobs that were saved in between are of the unit that their own record tells.

    Parameters
    ----------
    row
        the unit that was merged, as `merged_rows` names it.

    Raises
    ------
    BookError
        a unit that was not merged.
    """
    with book.writing() as connection:
        found = connection.execute(sa.select(units.c.merged_with).where(units.c.id == row)).scalar()
        if found is None:
            problem = Sentence("no unit that was merged into another one")
            raise BookError(problem, place=Place(file=book.name), value=row)
        left = root_of(connection, book, row)
        family = {
            each.id: each for each in connection.execute(sa.select(units).where(units.c.id.in_(rows_of_unit(left))))
        }
        apart = {row}
        while more := {each.id for each in family.values() if each.merged_with in apart} - apart:
            apart |= more
        connection.execute(units.update().where(units.c.id == row).values(merged_with=None, merged_into=None))
        connection.execute(units.update().where(units.c.id.in_(apart - {row})).values(merged_into=row))
        unit_of_key = {each.key: row if each.id in apart else left for each in family.values()}
        _sort(connection, unit_of_key, {id: row if id in apart else left for id in family})
        drop_empty(connection)


def _sort(connection: sa.Connection, unit_of_key: Mapping[str, int], units_of: Mapping[int, int]) -> None:
    """Put jobs to visits of the units that their records tell; ``units_of`` are those that visits name so far."""
    held = sa.select(jobs.c.id, jobs.c.serial, jobs.c.vin, jobs.c.plate, jobs.c.visit, visits.c.unit)
    held = held.join(visits, visits.c.id == jobs.c.visit).where(visits.c.unit.in_(units_of)).order_by(jobs.c.made_at)
    for job in connection.execute(held).all():
        unit = units_of[job.unit]
        wanted = unit_of_key.get(unit_key(job.id, job.serial, job.vin, job.plate), unit)
        if wanted != unit:
            visit = connection.execute(sa.select(visits).where(visits.c.id == job.visit)).mappings().one()
            same = sa.select(visits.c.id).where(visits.c.number == visit["number"])
            same = same.where(visits.c.unit.in_([row for row in units_of if units_of[row] == wanted]))
            known = connection.execute(same.order_by(visits.c.id)).scalar() if visit["number"] else None
            if known is None:
                values = {**visit, "unit": wanted}
                values.pop("id")
                made = connection.execute(visits.insert().values(**values)).inserted_primary_key
                known = None if made is None else made[0]
            connection.execute(jobs.update().where(jobs.c.id == job.id).values(visit=known))


def merged_rows(book: Book, unit: int) -> list[MergedRow]:
    """Return the units that were merged into one."""
    with book.reading() as connection:
        found = connection.execute(sa.select(units).where(units.c.merged_into == unit).order_by(units.c.id)).all()
    return [MergedRow(row.id, row.key) for row in found]


def root_of(connection: sa.Connection, book: Book, unit: int) -> int:
    """Return the unit that a unit leads to, held until the transaction ends: nobody merges it meanwhile."""
    row = connection.execute(sa.select(units).where(units.c.id == unit).with_for_update()).one_or_none()
    if row is None:
        raise BookError(Sentence("the job book has no such unit"), place=Place(file=book.name), value=unit)
    return int(row.id) if row.merged_into is None else root_of(connection, book, row.merged_into)


# --- which units may be one


def duplicates(book: Book) -> list[Duplicate]:
    """Return pairs of units that may be one transmission, the surest reason first; samples and archived jobs left out.

    Two units whose serials, or whose plates, are stated and differ are taken for two.
    """
    seen = _units_seen(book)
    found: dict[tuple[int, int], Reason] = {}
    looked_for: dict[Reason, Iterator[tuple[int, int]]] = {
        "same_vin": _sharing(seen, "vins"),
        "vin_within_one_character": _alike(seen),
        "same_plate": _sharing(seen, "plates"),
    }
    for reason, pairs in looked_for.items():
        for pair in pairs:
            one, other = (seen[unit] for unit in pair)
            if _may_be_one(one, other, reason):
                found.setdefault(pair, reason)
    order = list(REASONS)
    ranked = sorted(found.items(), key=lambda item: (order.index(item[1]), item[0]))
    return [Duplicate(seen[one], seen[other], reason) for (one, other), reason in ranked]


def _units_seen(book: Book) -> dict[int, UnitSeen]:
    columns = jobs.c.id, jobs.c.serial, jobs.c.vin, jobs.c.plate, jobs.c.customer, final_unit().label("unit")
    live = sa.select(*columns).join(visits, visits.c.id == jobs.c.visit)
    live = live.where(jobs.c.archived_at.is_(None), ~jobs.c.sample)
    seen: dict[int, UnitSeen] = {}
    with book.reading() as connection:
        for row in connection.execute(live):
            unit = seen.setdefault(row.unit, UnitSeen(row.unit))
            unit.jobs.append(row.id)
            for texts, text in ((unit.serials, row.serial), (unit.vins, row.vin), (unit.plates, row.plate)):
                texts |= {key_of_row(text)} - {""}
            unit.customers |= {row.customer} - {""}
    return seen


def _may_be_one(one: UnitSeen, other: UnitSeen, reason: Reason) -> bool:
    names = ("serials", "plates") if reason != "same_plate" else ("serials", "vins")
    return all(
        not getattr(one, name) or not getattr(other, name) or getattr(one, name) & getattr(other, name)
        for name in names
    )


def _sharing(seen: dict[int, UnitSeen], name: str) -> Iterator[tuple[int, int]]:
    by_text: dict[str, set[int]] = defaultdict(set)
    for unit in seen.values():
        for text in getattr(unit, name):
            by_text[text].add(unit.id)
    yield from _pairs(by_text.values())


def _alike(seen: dict[int, UnitSeen]) -> Iterator[tuple[int, int]]:
    """Yield units with VINs within one character: wrong, missing, one too many, or two changed about.

    Such VINs are the same but for one character that is left out of each, or of one of them.
    """
    by_rest: dict[str, set[tuple[int, str]]] = defaultdict(set)
    for unit in seen.values():
        for vin in (each for each in unit.vins if len(each) >= _SHORTEST):
            for rest in (vin, *(vin[:at] + vin[at + 1 :] for at in range(len(vin)))):
                by_rest[rest].add((unit.id, vin))
    for group in (each for each in by_rest.values() if len(each) <= _PLACEHOLDER):
        for (one, vin), (other, again) in combinations(sorted(group), 2):
            if one != other and vin != again and _one_slip(vin, again):
                yield min(one, other), max(one, other)


def _one_slip(one: str, other: str) -> bool:
    if len(one) != len(other):
        return True  # of strings that are the same without one character, the shorter is the longer without it
    differ = [at for at, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]
    return len(differ) == 1 or (
        len(differ) == 2
        and differ[1] == differ[0] + 1
        and one[differ[0]] == other[differ[1]]
        and one[differ[1]] == other[differ[0]]
    )


def _pairs(groups: Iterable[set[int]]) -> Iterator[tuple[int, int]]:
    for group in groups:
        if len(group) <= _PLACEHOLDER:
            yield from combinations(sorted(group), 2)
