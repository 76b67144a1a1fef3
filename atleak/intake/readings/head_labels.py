"""Find the labels that stand above the headings of a sheet, and what stands behind, beside or under each."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from atleak.errors import Place
from atleak.intake.readings.words import is_blank, letters, text_of
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import Unit, find_unit

# words that head cells of their own: one of these beside a label is no value of it
_OTHER_LABELS = (
    *("state", "person", "pump", "quantity", "remark", "gauge", "name", "number", "component", "part", "unit", "date"),
)
_FIELDS = (
    *(f"head_{field}" for field in ("job", "vehicle", "vin", "serial", "mileage", "technician", "instrument")),
    *("date", "temperature", "pump"),
)
_OF_FIELDS = (*_FIELDS, "beside_identity", "beside_head", "pump_side", "pump_tip", "beside_pump")
_LABEL = re.compile(r"(?P<label>[^:=\d]*?[^:=\d\s+\-−])\s*(?:[:=]\s*(?P<told>.*)|(?P<number>[+\-−]?\d.*))?", re.DOTALL)
_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
_REACH = 2  # cells to the right of a label in which its value may stand


@dataclass(frozen=True)
class Stated:
    """A value beside its label: its cell, and the unit that the label says."""

    sheet: Sheet
    row: int
    column: int
    value: Cell
    unit: Unit | None
    label: str  # as it is written

    @property
    def place(self) -> Place:
        """Return where it stands."""
        return self.sheet.place(self.row, self.column)


def stated_values(
    heads: Sequence[tuple[Sheet, range]], meaning: Sequence[str], beside: Sequence[str], kind: str | None
) -> Iterator[Stated]:
    """Yield what stands behind, beside or under every label of this meaning.

    Parameters
    ----------
    heads
        sheets, each with the rows above its headings.
    meaning
        of each of these a label has a word.
    beside
        meanings of the words that it may have beside them; it has no others.
    kind
        of the units of its value; None where it is a text.
    """
    for sheet, rows in heads:
        cells = [(row, column, cell) for row in rows for column, cell in enumerate(sheet.rows[row])]
        for row, column, cell in cells:
            match = _LABEL.fullmatch(cell.strip()) if isinstance(cell, str) else None
            if match is None or sheet.is_struck(row, column) or not means(match["label"], meaning, beside):
                continue
            in_cell = (match["told"] or match["number"] or "").strip()
            stated = Stated(sheet, row, column, in_cell, _unit_in(match["label"], kind), match["label"])
            found = stated if in_cell else _beside(stated, row + 1 in rows, kind)
            if found is not None and not sheet.is_struck(found.row, found.column):
                yield found


def means(label: str, meaning: Sequence[str], beside: Sequence[str]) -> bool:
    """Tell whether a label has a word of each meaning, and no words but these and those that may stand beside."""
    words = letters(label)
    return words.only(*meaning, *beside) and all(map(words.any, meaning))


def _unit_in(label: str, kind: str | None) -> Unit | None:
    written = [*(match[1] for match in _BRACKETS.finditer(label)), *label.split()[-1:]]
    return next((found for text in written if (found := _unit(text.strip(), kind))), None)


def _unit(text: str, kind: str | None) -> Unit | None:
    return None if kind is None else find_unit(text, kind)


def _beside(label: Stated, has_row_below: bool, kind: str | None) -> Stated | None:
    """Return the value of a label that stands alone: to its right, or under it where labels stand in a row."""
    sheet, row = label.sheet, label.row
    is_label = _heads_a_field if kind is None else _heads_something
    for column in range(label.column + 1, label.column + 1 + _REACH):
        cell = sheet.cell(row, column)
        if is_blank(cell):
            continue
        if is_label(cell):
            break
        following = text_of(sheet.cell(row, column + 1))
        if kind and sheet.is_text and text_of(cell).isdecimal() and following[:1].isdecimal():
            cell = f"{cell} | {following}"  # a decimal comma that the file also uses between its columns
        return Stated(sheet, row, column, cell, _unit(following, kind) or label.unit, label.label)
    below = sheet.cell(row + 1, label.column) if has_row_below else ""
    if is_blank(below) or is_label(below):
        return None
    return Stated(sheet, row + 1, label.column, below, label.unit, label.label)


def _heads_something(cell: Cell) -> bool:
    """Tell whether a cell heads something else than a number: words without one, one of them a usual label."""
    if not isinstance(cell, str) or re.search(r"\d", cell):
        return False
    return cell.rstrip().endswith(":") or letters(cell).any(*_OTHER_LABELS)


def _heads_a_field(cell: Cell) -> bool:
    """Tell whether a cell where a text may stand heads another field: all its words are those of labels."""
    if not isinstance(cell, str):
        return False
    bare = _BRACKETS.sub("", cell.split(":")[0].split("=")[0])
    # an "air gauge" has words that stand beside a label, and is none itself
    instrument = means(bare, ("head_instrument",), ("head_of_spools", "head_of_bores", "beside_identity"))
    is_field = instrument or (means(bare, (), _OF_FIELDS) and letters(bare).any(*_FIELDS))
    return cell.rstrip().endswith(":") or (is_field and not re.search(r"\d", bare))


def is_row_of_fields(row: Sequence[Cell]) -> bool:
    """Tell whether a row begins with a field of the job and has another, as the last one above the headings does."""
    texts = [cell for cell in row if isinstance(cell, str) and cell.strip()]
    return len(texts) > 1 and _heads_a_field(texts[0]) and any(map(_heads_a_field, texts[1:]))
