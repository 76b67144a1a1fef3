"""Say what became of the cells of a measuring sheet: of one, of a row and of a column as a whole."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from atleak.catalogue.words import PART_WORDS
from atleak.common.sentences import Sentence
from atleak.common.wording import Wording
from atleak.measurements.readings import CellKind, CellMeaning, Reading, SheetCells
from atleak.readers.sheets.words import number_of

WHAT_WAS_READ = Sentence("What was read")
WHAT_BECAME = Sentence("What became of it")
KIND_WORDS: Mapping[CellKind, Sentence] = {  # in the order of the legend
    CellKind.SPOOL: Sentence("diameter of a spool"),
    CellKind.SLEEVE: Sentence("diameter of a sleeve"),
    CellKind.LABEL: Sentence("says what a diameter is of"),
    CellKind.NEW: Sentence("nominal diameter, or when new"),
    CellKind.HEAD: Sentence("field of the head"),
    CellKind.LAND: Sentence("of a land itself"),
    CellKind.HEADING: Sentence("heading"),
    CellKind.ASIDE: Sentence("left aside"),
    CellKind.REFUSED: Sentence("refused"),
}
_PLAIN = re.compile(r"-?(0|[1-9]\d*)?([.,]\d+)?")  # a number that is the same without its text
_DIAMETERS = (CellKind.SPOOL, CellKind.SLEEVE)
_OF_ROWS = (*_DIAMETERS, CellKind.LABEL)
_SHORT: Mapping[CellKind, Sentence] = {  # of a whole column
    **KIND_WORDS,
    CellKind.SPOOL: Sentence("spool"),
    CellKind.SLEEVE: Sentence("sleeve"),
    CellKind.NEW: Sentence("nominal"),
}


def kinds_in(sheets: Iterable[SheetCells]) -> list[CellKind]:
    """Return the kinds that the cells of sheets are of, in the order of the legend."""
    found = {meaning.kind for sheet in sheets for row in sheet.meanings for meaning in row if meaning is not None}
    return [kind for kind in KIND_WORDS if kind in found]


def meaning_said(meaning: CellMeaning, say: Wording, *, short: bool = False) -> str:
    """Return what a cell became, with the reason where there is one."""
    if short and meaning.kind is CellKind.LABEL:
        return say.sentence(meaning.why)
    words = (_SHORT if short else KIND_WORDS)[meaning.kind]
    return f"{say.sentence(words)}: {say.sentence(meaning.why)}" if meaning.why else say.sentence(words)


def row_said(sheet: SheetCells, row: int, say: Wording) -> str:
    """Return what became of a row; "" where nothing was to be made of it."""
    counted = Counter(meaning for meaning in sheet.meanings[row] if meaning is not None)
    refused = next((meaning for meaning in counted if meaning.kind is CellKind.REFUSED), None)
    kinds = {meaning.kind for meaning in counted}
    if refused is not None or not kinds:
        return "" if refused is None else meaning_said(refused, say)
    if kinds.intersection(_DIAMETERS):
        return say.sentence(Sentence("this row counts"))
    if CellKind.LABEL in kinds:
        return say.sentence(Sentence("nothing measured"))
    return meaning_said(counted.most_common(1)[0][0], say)


def column_said(sheet: SheetCells, column: int, say: Wording) -> str:
    """Return what most cells of a column became, in a word or two, in rows that say what a diameter is of."""
    rows = (row for row in sheet.meanings if column < len(row) and any(one and one.kind in _OF_ROWS for one in row))
    counted = Counter(row[column] for row in rows if row[column] is not None)
    kinds = [meaning for meaning, _ in counted.most_common() if meaning is not None]
    first = next((meaning for meaning in kinds if meaning.kind in _DIAMETERS or meaning.kind is CellKind.LABEL), None)
    both = [meaning_said(CellMeaning(kind), say, short=True) for kind in _DIAMETERS if CellMeaning(kind) in counted]
    if len(both) == len(_DIAMETERS):
        return " / ".join(both)
    return meaning_said(first or kinds[0], say, short=True) if kinds else ""


def as_written(cell: Any) -> Any:
    """Return a cell of a file to be shown: a number as one, a date without a time of midnight, else its text."""
    if isinstance(cell, int | float | bool):
        return cell
    number = number_of(cell) if isinstance(cell, str) and _PLAIN.fullmatch(cell) else None
    return str(cell).removesuffix(" 00:00:00") if number is None else number


def reading_said(reading: Reading, say: Wording) -> str:
    """Return of what a diameter was read."""
    said = Sentence(
        "component {component}, {part}, plane {plane}", component=reading.component, part=PART_WORDS[reading.part],
        plane=reading.plane,
    )  # fmt: skip
    angle = "" if reading.direction is None else f", {say.number(reading.direction, 0)}°"
    repeat = say.sentence(Sentence("repeat {repeat}", repeat=reading.repeat))
    return f"{say.sentence(said)}{angle}, {repeat}"
