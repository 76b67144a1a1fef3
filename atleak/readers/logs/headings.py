"""Says what each column of a log's table is called.

Names, units and sources stand in the rows above the data.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from atleak.readers.dates import words
from atleak.readers.logs.names import clean_unit, is_unit, match_name, split_unit

HeadRow = list[str]
_LONGEST_UNIT = 10  # characters; what is longer is a name
# names that spreadsheets give to columns without any
_NAMELESS = re.compile(r"(?:column|spalte|kolumna|colonne|coluna|columna|столбец)[ _]?\d+\Z")
VALUE_HEADERS = frozenset(  # what a column of numbers is called whose quantity is named elsewhere
    {
        "value", "values", "wert", "messwert", "reading", "wartosc", "valeur", "valor", "значение", "data",
        "physical value",
    }
)  # fmt: skip
_NOT_OF_THE_CAR = re.compile(r"\b(?:gps|calc|accelerometer|gyroscope|phone)\b")


@dataclass(frozen=True)
class Heading:
    """A column as the rows above the data describe it.

    ``label`` is the name as written (the caller maps by it), ``names`` every name that may tell the quantity,
    the most telling first, without unit; ``unit`` the unit's text or None. ``source`` is the device that a row of
    sources names.
    """

    index: int
    label: str
    names: tuple[str, ...]
    unit: str | None
    source: str = ""

    @property
    def numbered(self) -> str:
        """Return its name with its place and source, by which it is told from others of the same name."""
        return f"{self.label} ({', '.join(filter(None, (f'column {self.index + 1}', self.source)))})"

    @property
    def foreign(self) -> bool:
        """Return whether the column comes from a device beside the car: a GPS receiver, a phone, a computation."""
        return bool(_NOT_OF_THE_CAR.search(self.source))


def headings_of(header: Sequence[HeadRow], width: int) -> tuple[Heading, ...]:
    """Return the headings of a table's columns from the rows above its data."""
    names = list(header)
    place = _units_place(names)
    units = names.pop(place) if place is not None else []
    return headings_by_rows(names, units, [], width)


def headings_by_rows(names: Sequence[HeadRow], units: HeadRow, sources: HeadRow, width: int) -> tuple[Heading, ...]:
    """Return the headings of a table's columns from rows of which it is known what they hold."""
    names = sorted(names, key=known_names, reverse=True)
    filled = (index + 1 for row in names for index, cell in enumerate(row) if cell)
    return tuple(_heading(index, names, units, sources) for index in range(max(width, *filled, 0)))


def _heading(index: int, names: Sequence[HeadRow], units: HeadRow, sources: HeadRow) -> Heading:
    written = [row[index] for row in names if index < len(row) and row[index]]
    split = [split_unit(name) for name in written]
    unit = next((part.unit for part in split if part.unit is not None), None)
    if unit is None and index < len(units):
        unit = clean_unit(units[index]) or None
    label = written[0].replace("\ufeff", "").strip() if written else f"column {index + 1}"
    label = split[0].text if label.count("|") >= 2 else label
    source = sources[index].strip().lower() if index < len(sources) else ""
    return Heading(index, label, tuple(dict.fromkeys(part.text for part in split)), unit, source)


def names_columns(header: Sequence[HeadRow]) -> bool:
    """Return whether rows above the data name columns: a spreadsheet's own *Column1*, *Column2* name nothing."""
    return any(cell and not _NAMELESS.match(words(cell)) for row in header for cell in row)


def nameless(heading: Heading) -> bool:
    """Return whether nothing names a column, or only a spreadsheet's own *Column1*."""
    return not heading.names or bool(_NAMELESS.match(words(heading.names[0])))


def _units_place(header: Sequence[HeadRow]) -> int | None:
    """Return which row above the data holds units: mostly units, or some below a row of names that differ."""
    if len(header) < 2:
        return None
    share, place = max((units_share(row), index) for index, row in enumerate(header))
    others = [row for index, row in enumerate(header) if index != place]
    named = any(not is_unit(cell) and match_name(split_unit(cell).text) is not None for cell in header[place] if cell)
    if named and not any(map(known_names, others)):  # groups stand above the names
        return None
    if share >= 0.5 and (place > 0 or max(map(known_names, others)) >= known_names(header[0])):
        return place
    first = [cell for cell in header[0] if cell]
    if len(set(first)) < len(first):
        return None
    clear = [(_clear_units(row), -index) for index, row in enumerate(header) if index > 0]
    count, place = max(clear)
    return -place if count else None


def _clear_units(row: HeadRow) -> int:
    """Return how many cells are units beyond doubt; 0 where the row also holds names."""
    filled = [clean_unit(cell) for cell in row if cell.strip()]
    units = [cell for cell in filled if is_unit(cell) and (len(cell) > 1 or cell in "%°")]
    for cell in filled:
        match = match_name(cell)  # a unit of time may be a name of the time
        if len(cell) > _LONGEST_UNIT or (not is_unit(cell) and match is not None and match.quantity != "time"):
            return 0
    return len(units)


def units_share(row: HeadRow) -> float:
    """Return which share of a row's cells are units."""
    filled = [cell for cell in row if cell.strip() and cell.strip() != "-"]
    if not filled:
        return 0.0
    return sum(is_unit(cell) for cell in filled) / len(filled)


def known_names(row: HeadRow) -> int:
    """Return how many cells of a row name a quantity."""
    return sum(match_name(split_unit(cell).text) is not None for cell in row if cell)
