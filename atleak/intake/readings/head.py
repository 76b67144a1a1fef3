"""What stands above the headings about the measurement itself: the temperature of gauge and parts, and the date."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from atleak.errors import Message, Place, ReadingsError
from atleak.intake.dates import sure_date
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.words import Vocabulary, is_blank, letters, text_of, vocabulary
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import Unit, find_unit, unit
from atleak.written_numbers import MEASURING_TEMPERATURE, possible_values, read_number

_TEMPERATURE, _DATE = vocabulary("temperature"), vocabulary("date")
_BESIDE = vocabulary("beside_head")
# words that head cells of their own: one of these beside a label is no value of it
_OTHER_LABELS = vocabulary(
    *("state", "person", "quantity", "remark", "gauge", "name", "number", "component", "part", "unit", "date")
)
_LABEL = re.compile(r"(?P<label>[^:=\d]*?[^:=\d\s+\-−])\s*(?:[:=]\s*(?P<told>.*)|(?P<number>[+\-−]?\d.*))?", re.DOTALL)
_VALUE = re.compile(
    r"(?P<number>[+\-−]?\s?\d[\d.,]*)\s*(?:(?:±|\+/?-)\s*[\d.,]+\s*)?(?P<unit>[^\d\s.,±].*)?", re.DOTALL
)
_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
_REACH = 2  # cells to the right of a label in which its value may stand
_CELSIUS = unit("°C", "temperature")
_ONE_TEMPERATURE = "one temperature, such as 21.5 °C"


@dataclass(frozen=True)
class Head:
    """The measuring temperature [°C] and the date that a sheet's head states, None where it states none.

    ``cells`` are those read, as sheet, row and column.
    """

    temperature: float | None = None
    date: dt.date | None = None
    cells: tuple[tuple[str | None, int, int], ...] = ()
    messages: tuple[Message, ...] = ()
    problems: tuple[ReadingsError, ...] = ()


@dataclass(frozen=True)
class _Stated:
    """A value beside its label: its cell, and the unit that the label says."""

    sheet: Sheet
    row: int
    column: int
    value: Cell
    unit: Unit | None

    @property
    def place(self) -> Place:
        """Return where it stands."""
        return self.sheet.place(self.row, self.column)


def read_head(tables: Sequence[Table], sheets: Sequence[Sheet]) -> Head:
    """Read what stands above the first headings of every sheet that holds one of the tables.

    Two temperatures that differ are named, and none of them is taken. A temperature that is none is a problem; a date
    whose day and month may be swapped is not taken.
    """
    first: dict[str | None, int] = {}
    for table in tables:
        first[table.sheet.name] = min(table.header.first, first.get(table.sheet.name, table.header.first))
    heads = [(sheet, range(max(first[sheet.name], 0))) for sheet in sheets if sheet.name in first]
    temperatures: dict[float, _Stated] = {}
    problems = []
    stated = [each for sheet, rows in heads for each in _values(sheet, rows, _TEMPERATURE)]
    for each in stated:
        try:
            temperatures.setdefault(_celsius(each), each)
        except ReadingsError as error:
            problems.append(error)
    dates = [each for sheet, rows in heads for each in _values(sheet, rows, _DATE)]
    known = {date for each in dates if (date := _date(each.value)) is not None}
    return Head(
        temperature=next(iter(temperatures)) if len(temperatures) == 1 else None,
        date=max(known, default=None),
        cells=tuple((each.sheet.name, each.row, each.column) for each in (*stated, *dates)),
        messages=tuple(_several(temperatures)),
        problems=tuple(problems),
    )


def _several(temperatures: Mapping[float, _Stated]) -> Iterator[Message]:
    if len(temperatures) > 1:
        named = " and ".join(f"{value:g} °C ({each.place})" for value, each in temperatures.items())
        text = f"the head states several temperatures, {named}: none is taken. State the one of gauge and parts"
        yield Message("warning", "measuring_temperature_unclear", text, next(iter(temperatures.values())).place)


def _values(sheet: Sheet, rows: range, meaning: Vocabulary) -> Iterator[_Stated]:
    """Yield what stands behind, beside or under every label of this meaning."""
    for row in rows:
        for column, cell in enumerate(sheet.rows[row]):
            match = _LABEL.fullmatch(cell.strip()) if isinstance(cell, str) else None
            if match is None or sheet.is_struck(row, column) or not _means(match["label"], meaning):
                continue
            in_cell = (match["told"] or match["number"] or "").strip()
            stated = _Stated(sheet, row, column, in_cell, _unit_in(match["label"]))
            found = stated if in_cell else _beside(stated, row + 1 in rows)
            if found is not None and not sheet.is_struck(found.row, found.column):
                yield found


def _means(label: str, meaning: Vocabulary) -> bool:
    words = letters(label)
    return any(word in meaning for word in words) and all(word in meaning or word in _BESIDE for word in words)


def _unit_in(label: str) -> Unit | None:
    bracketed = [match[1] for match in _BRACKETS.finditer(label)]
    written = [*bracketed, *label.split()[-1:]]
    return next((found for text in written if (found := find_unit(text.strip(), "temperature"))), None)


def _beside(label: _Stated, has_row_below: bool) -> _Stated | None:
    """Return the value of a label that stands alone: to its right, or under it where labels stand in a row."""
    sheet, row = label.sheet, label.row
    for column in range(label.column + 1, label.column + 1 + _REACH):
        cell = sheet.cell(row, column)
        if is_blank(cell):
            continue
        if not _is_label(cell):
            following = text_of(sheet.cell(row, column + 1))
            if sheet.is_text and text_of(cell).isdecimal() and following[:1].isdecimal():
                cell = f"{cell} | {following}"  # a decimal comma that the file also uses between its columns
            return _Stated(sheet, row, column, cell, find_unit(following, "temperature") or label.unit)
        break
    below = sheet.cell(row + 1, label.column) if has_row_below else ""
    if is_blank(below) or _is_label(below):
        return None
    return _Stated(sheet, row + 1, label.column, below, label.unit)


def _is_label(cell: Cell) -> bool:
    """Return whether a cell heads something else: words without a number, one of them a usual label."""
    if not isinstance(cell, str) or re.search(r"\d", cell):
        return False
    return cell.rstrip().endswith(":") or any(word in _OTHER_LABELS for word in letters(cell))


def _celsius(stated: _Stated) -> float:
    """Return a temperature [°C].

    Raises
    ------
    ReadingsError
        with its place: no number, another unit, or no temperature at which anybody measures.
    """
    number, written = stated.value, stated.unit or _CELSIUS
    if isinstance(number, str):
        match = _VALUE.fullmatch(re.sub(r"\s*\([^()]*\)$", "", number.strip()))
        values = possible_values(match["number"]) if match else ()
        behind = match["unit"] if match else None
        found = find_unit(behind, "temperature") if behind else written
        if not values or found is None:
            raise ReadingsError("no temperature", place=stated.place, value=number, expected=_ONE_TEMPERATURE)
        number, written = values[0], found
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise ReadingsError("no temperature", place=stated.place, value=str(number), expected=_ONE_TEMPERATURE)
    celsius = round(float(written.to_si(float(number))), 9)
    doubt = read_number(repr(celsius), MEASURING_TEMPERATURE)
    if doubt.value is None:
        low, high = MEASURING_TEMPERATURE.limits
        raise ReadingsError(
            "no temperature at which anybody measures",
            place=stated.place,
            value=stated.value,
            expected=f"the temperature of gauge and parts, from {low:g} to {high:g} °C".replace("-", "−"),
        )
    return celsius


def _date(cell: Cell) -> dt.date | None:
    if isinstance(cell, dt.datetime):
        return cell.date()
    if isinstance(cell, dt.date):
        return cell
    return sure_date([cell]) if isinstance(cell, str) else None
