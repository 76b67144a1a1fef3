"""Tables that state a nominal diameter and how far the measured one is from it: the diameter is their sum."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from atleak.errors import Message, ReadingsError
from atleak.intake.readings.one_heading import Column, read_heading, split_unit
from atleak.intake.readings.sizes import MM as MILLIMETRE
from atleak.intake.readings.table import Table
from atleak.intake.readings.words import is_blank, letters, number, part_in, part_of
from atleak.intake.sheets.sheet import Cell
from atleak.sentence import Sentence

_IN_BRACKETS = re.compile(r"\[[^\[\]]*\]|\([^()]*\)")
_WORD = re.compile(r"[^\W\d_]+")
_DIGITS = 6  # of a sum in mm, that no digit of the sheet is lost in


def with_deviations(table: Table) -> Table:
    """Return a table with diameters behind its last column, if it has none but nominal ones and deviations from them.

    The columns whose numbers went into them are ``used``, and ``told`` says so.
    """
    pairs = [] if table.values else list(_pairs(table))
    if not pairs:
        return table
    columns = [(_as_diameter(table, deviation, nominal), deviation.index) for nominal, deviation in pairs]

    def sums(row: int) -> Iterator[Cell]:
        for nominal, deviation in pairs:
            yield _sum(table, row, nominal, deviation) if row > table.last else ""

    used = frozenset(column.index for pair in pairs for column in pair)
    told = tuple(_told(table, *pair) for pair in pairs)
    return replace(table.with_columns(columns, sums, used), used=used, told=told)


def _pairs(table: Table) -> Iterator[tuple[Column, Column]]:
    """Yield each deviation behind a nominal diameter that it may be from: of its part, where headings say one."""
    sizes = [column for column in table.of("specification") if not _is_permitted(column)]
    for deviation in filter(_is_deviation, table.of("quantity")):
        part = part_in(deviation.heading)
        for nominal in sizes:
            of = part_in(nominal.heading)
            if (part is not None and of == part) or (len(sizes) < 2 and None in (part, of)):
                yield nominal, deviation


def _is_deviation(column: Column) -> bool:
    words = letters(_without_brackets(column))
    beside = words.but("deviation", "beside_deviation", "diameter", "of_reading", "direction", "repeat")
    return words.any("deviation") and all(map(part_of, beside))  # no standard and no permitted deviation


def _without_brackets(column: Column) -> str:
    """Return a heading without its unit, and without what brackets hold of which nothing is known: "[0.01 mm]"."""
    said, unit = split_unit(column.heading)
    if unit is not None:
        return said
    return _IN_BRACKETS.sub(lambda held: held[0] if any(map(part_of, letters(held[0]))) else " ", said)


def _as_diameter(table: Table, deviation: Column, nominal: Column) -> Column:
    """Return the column of the diameters that deviations make: what their heading says besides is theirs."""
    said = _WORD.sub(
        lambda word: "diameter" if letters(word[0]).any("deviation") else word[0], _without_brackets(deviation)
    )
    read = read_heading(said)
    if read is None or read.role != "diameter":
        read = Column(0, "", "diameter")
    return replace(
        read,
        heading=deviation.heading,
        unit=MILLIMETRE,
        part=read.part or part_in(nominal.heading),
        tentative=False,
        otherwise=None,
        unsure=_says_no_unit(table, deviation),
    )


def _is_permitted(column: Column) -> bool:
    """Return whether a heading says a deviation or tolerance, which no diameter is: "Upper dev", "Lower tol"."""
    return letters(split_unit(column.heading)[0]).any("deviation", "permitted")


def _sum(table: Table, row: int, nominal: Column, deviation: Column) -> Cell:
    size, off = table.sheet.filled(row, nominal.index), table.sheet.cell(row, deviation.index)
    if is_blank(off):
        return ""
    try:
        value, of_value = number(size)
        apart, of_apart = number(off)
    except ReadingsError:
        return f"{size} {off}"
    unit, small = of_value or nominal.unit or MILLIMETRE, of_apart or deviation.unit or MILLIMETRE
    return round((unit.to_si(value) + small.to_si(apart)) / MILLIMETRE.factor, _DIGITS)


def _told(table: Table, nominal: Column, deviation: Column) -> Message:
    text = Sentence(
        "diameters are those of column {nominal!r} plus the deviations of column {deviation!r}",
        nominal=nominal.name,
        deviation=deviation.name,
    )
    return Message("info", "diameters_of_deviations", text, table.place(table.last, deviation))


def _says_no_unit(table: Table, deviation: Column) -> bool:
    """Return whether neither the heading nor every cell says in which unit the deviations are."""
    for cell in table.cells(deviation.index).values() if deviation.unit is None else ():
        try:
            if number(cell)[1] is None:
                return True
        except ReadingsError:
            continue
    return False
