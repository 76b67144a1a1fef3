"""Tables that state a nominal diameter and how far the measured one is from it: the diameter is their sum."""

from __future__ import annotations

import re
from dataclasses import replace

from atleak.errors import Message, ReadingsError
from atleak.intake.readings.headings import Header
from atleak.intake.readings.one_heading import Column, read_heading, split_unit
from atleak.intake.readings.sizes import MM as MILLIMETRE
from atleak.intake.readings.words import is_blank, letters, number, part_in, part_of, vocabulary
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.sentence import Sentence

_DEVIATION = vocabulary("deviation")
_BESIDE = vocabulary("beside_deviation", "diameter", "actual", "reading")  # no standard and no permitted deviation
_PERMITTED = vocabulary("permitted")
_STATION = vocabulary("direction", "repeat")
_IN_BRACKETS = re.compile(r"\[[^\[\]]*\]|\([^()]*\)")
_WORD = re.compile(r"[^\W\d_]+")
_DIGITS = 6  # of a sum in mm, that no digit of the sheet is lost in


def with_deviations(sheet: Sheet, header: Header) -> tuple[Sheet, Header, frozenset[int], tuple[Message, ...]]:
    """Return a table with diameters behind its last column, if it has none but nominal ones and deviations from them.

    Also returned are the columns whose numbers went into them, and what is to be said about it.
    """
    if header.values:
        return sheet, header, frozenset(), ()
    pairs = [
        (nominal, deviation)
        for deviation in header.columns
        if deviation.role == "quantity" and _is_deviation(deviation)
        for nominal in _nominal_of(deviation, header)
    ]
    if not pairs:
        return sheet, header, frozenset(), ()
    first = max(sheet.width, len(header.texts))
    columns = [
        replace(_as_diameter(deviation, nominal), index=first + at, unsure=_says_no_unit(sheet, header, deviation))
        for at, (nominal, deviation) in enumerate(pairs)
    ]
    rows = [
        [
            *cells,
            *[""] * (first - len(cells)),
            *(_sum(sheet, row, nominal, deviation) if row > header.last else "" for nominal, deviation in pairs),
        ]
        for row, cells in enumerate(sheet.rows)
    ]
    used = frozenset(column.index for pair in pairs for column in pair)
    texts = (*header.texts, *[""] * (first - len(header.texts)), *(deviation.heading for _, deviation in pairs))
    kept = tuple(column for column in header.columns if column.index not in used)
    derived = {column.index: deviation.index for column, (_, deviation) in zip(columns, pairs, strict=True)}
    return (
        replace(sheet, rows=rows, derived={**sheet.derived, **derived}),
        replace(header, columns=(*kept, *columns), texts=texts),
        used,
        tuple(_told(sheet, header, *pair) for pair in pairs),
    )


def _is_deviation(column: Column) -> bool:
    words = letters(_said(column))
    beside = [word for word in words if word not in _DEVIATION]
    return len(beside) < len(words) and all(word in _BESIDE or word in _STATION or part_of(word) for word in beside)


def _said(column: Column) -> str:
    """Return a heading without its unit, and without what brackets hold of which nothing is known: "[0.01 mm]"."""
    said, unit = split_unit(column.heading)
    if unit is not None:
        return said
    return _IN_BRACKETS.sub(lambda held: held[0] if any(map(part_of, letters(held[0]))) else " ", said)


def _as_diameter(deviation: Column, nominal: Column) -> Column:
    """Return the column of the diameters that deviations make: what their heading says besides is theirs."""
    said = _WORD.sub(lambda word: "diameter" if letters(word[0])[0] in _DEVIATION else word[0], _said(deviation))
    read = read_heading(said)
    if read is None or read.role != "diameter":
        read = Column(0, "", "diameter")
    part = read.part or part_in(nominal.heading)
    return replace(read, heading=deviation.heading, unit=MILLIMETRE, part=part, tentative=False, otherwise=None)


def _is_permitted(column: Column) -> bool:
    """Return whether a heading says a deviation or tolerance, which no diameter is: "Upper dev", "Lower tol"."""
    return any(word in _DEVIATION or word in _PERMITTED for word in letters(split_unit(column.heading)[0]))


def _nominal_of(deviation: Column, header: Header) -> list[Column]:
    """Return the nominal diameters that a deviation may be from: those of its part, where headings say one."""
    nominal = [column for column in header.of("specification") if not _is_permitted(column)]
    part = part_in(deviation.heading)
    if len(nominal) < 2:
        return [column for column in nominal if None in (part, of := part_in(column.heading)) or of == part]
    return [column for column in nominal if part is not None and part_in(column.heading) == part]


def _sum(sheet: Sheet, row: int, nominal: Column, deviation: Column) -> Cell:
    size, off = sheet.filled(row, nominal.index), sheet.cell(row, deviation.index)
    if is_blank(off):
        return ""
    try:
        value, of_value = number(size)
        apart, of_apart = number(off)
    except ReadingsError:
        return f"{size} {off}"
    unit, small = of_value or nominal.unit or MILLIMETRE, of_apart or deviation.unit or MILLIMETRE
    return round((unit.to_si(value) + small.to_si(apart)) / MILLIMETRE.factor, _DIGITS)


def _told(sheet: Sheet, header: Header, nominal: Column, deviation: Column) -> Message:
    text = Sentence(
        "diameters are those of column {nominal!r} plus the deviations of column {deviation!r}",
        nominal=nominal.name,
        deviation=deviation.name,
    )
    place = sheet.place(header.last, deviation.index, deviation.heading)
    return Message("info", "diameters_of_deviations", text, place)


def _says_no_unit(sheet: Sheet, header: Header, deviation: Column) -> bool:
    """Return whether neither the heading nor every cell says in which unit the deviations are."""
    if deviation.unit is not None:
        return False
    for row in range(header.last + 1, len(sheet.rows)):
        cell = sheet.cell(row, deviation.index)
        try:
            if not is_blank(cell) and number(cell)[1] is None:
                return True
        except ReadingsError:
            continue
    return False
