"""A column headed "Measurement" or "Reading" that counts 1, 2, 3 beside a column of diameters: the repeat."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from atleak.intake.readings.headings import Header
from atleak.intake.readings.one_heading import Column, Role
from atleak.intake.readings.words import is_blank, letters, repeat_of, summary_of, vocabulary
from atleak.intake.sheets.sheet import Sheet

_READING = vocabulary("reading")
_NUMBER = vocabulary("number")


def with_counts(sheet: Sheet, header: Header) -> Header:
    """Return the headings with such a column as the repeat; a column that numbers all rows through says nothing."""
    columns = list(header.columns)
    for index in range(len(header.texts)):
        words = letters(header.text(index))
        others = [column for column in header.values if column.index != index]
        if not others or not any(word in _READING for word in words):
            continue
        if not all(word in _READING or word in _NUMBER for word in words):
            continue
        below = range(header.last + 1, len(sheet.rows))
        rows = [row for row in below if any(not is_blank(sheet.cell(row, column.index)) for column in others)]
        cells = [cell for row in rows if not is_blank(cell := sheet.filled(row, index))]
        read = [repeat_of(cell) for cell in cells if summary_of(cell, key=True) is None]
        numbers = [number for number in read if number is not None]
        if not numbers or len(numbers) < len(read) or sorted(set(numbers)) != list(range(1, len(set(numbers)) + 1)):
            continue
        restarts = any(after <= before for before, after in pairwise(numbers))
        role: Role = "repeat" if (restarts or len(numbers) < len(cells)) and not header.of("repeat") else "remark"
        columns = [column for column in columns if column.index != index]
        columns.append(Column(index, header.texts[index], role))
    return replace(header, columns=tuple(sorted(columns, key=lambda column: column.index)))
