"""Find the table of a gauge study in a sheet: its row of headings, and what each column holds."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from atleak.intake.plain_words import vocabulary, words
from atleak.intake.sheets.sheet import Sheet, text_of
from atleak.intake.units import Unit, find_unit

KEYS = ("part", "operator", "trial")
_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
_PERSON_AND_TRIAL = re.compile(r"(?P<operator>.*?)[\s_./·#-]*(?P<trial>\d+)")
_SEARCHED = 60  # rows in which the headings are looked for


@dataclass(frozen=True)
class StudyTable:
    """A table of readings. ``keys`` lead from part, operator and trial to the column that states each.

    ``values`` lead from the columns of readings to what their headings say: of which part, operator or trial.
    """

    sheet: Sheet
    row: int  # of the headings, from 0
    keys: Mapping[str, int]
    values: Mapping[int, Mapping[str, str]]
    units: Mapping[int, Unit]  # by column of readings


@cache
def _vocabulary() -> dict[str, str]:
    return {
        phrase: name
        for name, phrases in vocabulary(__package__, "study_vocabulary.toml")["column"].items()
        for phrase in phrases
    }


def likeness(sheet: Sheet) -> float:
    """Count the headings of a sheet that are understood: of a text file, whether it is split the right way."""
    table = find_table(sheet)
    return 0.0 if table is None else len(table.keys) + min(len(table.values), 20)


def find_table(sheet: Sheet) -> StudyTable | None:
    """Return the table of a sheet; None where no row holds its headings."""
    for row in range(min(len(sheet.rows), _SEARCHED)):
        table = _at(sheet, row)
        if table is not None:
            return table
    return None


def _at(sheet: Sheet, row: int) -> StudyTable | None:
    keys: dict[str, int] = {}
    readings: list[int] = []
    others: list[int] = []
    units: dict[int, Unit] = {}
    for column in range(sheet.width):
        text = text_of(sheet.filled(row, column))
        if not text:
            continue
        inside = _BRACKETS.search(text)
        of_column = find_unit(inside[1], "length") if inside else None
        if of_column is not None:
            units[column] = of_column
        kind = _vocabulary().get(words(_BRACKETS.sub(" ", text)))
        if kind in KEYS and kind not in keys:
            keys[kind] = column
        elif kind == "reading":
            readings.append(column)
        elif kind != "aside":
            others.append(column)
    if {"part", "operator"} <= keys.keys() and len(readings) == 1 and not others:
        return StudyTable(sheet, row, keys, {readings[0]: {}}, units)
    if not {"part", "operator"} & keys.keys():
        return None
    values = _side_by_side(sheet, row, keys, sorted((*readings, *others)))
    return None if len(values) < 2 and "trial" not in keys else StudyTable(sheet, row, keys, values, units)


def _side_by_side(sheet: Sheet, row: int, keys: Mapping[str, int], columns: list[int]) -> dict[int, Mapping[str, str]]:
    """Return what the headings of readings side by side say; the only key that no column states, or two of them."""
    missing = [key for key in ("part", "operator") if key not in keys]
    values: dict[int, Mapping[str, str]] = {}
    for number, column in enumerate(columns, start=1):
        name = text_of(_BRACKETS.sub(" ", text_of(sheet.filled(row, column))))
        if not missing:
            values[column] = {"trial": str(number)}
        elif missing == ["part"] or "trial" in keys:
            values[column] = {missing[0]: name}
        else:
            both = _PERSON_AND_TRIAL.fullmatch(name)
            if both is not None and both["operator"]:
                values[column] = {"operator": both["operator"], "trial": both["trial"]}
    return values
