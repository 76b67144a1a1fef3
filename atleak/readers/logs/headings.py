"""Says what each column of a log's table is called.

Names, units and sources stand in the rows above the data, or in blocks that define channels.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from atleak.readers.dates import words
from atleak.readers.logs.log_cells import is_clock
from atleak.readers.logs.names import clean_unit, is_unit, match_name, split_unit

HeadRow = list[str]
_LONGEST_UNIT = 10  # characters; what is longer is a name
# names that spreadsheets give to columns without any
_NAMELESS = re.compile(r"(?:column|spalte|kolumna|colonne|coluna|columna|столбец)[ _]?\d+\Z")
_SOURCE = re.compile(r"\d+\s*:\s*[a-z ]+\Z|(?:calc|gps|can ?bus|can|obd2?|obd-ii|accelerometer|gyroscope)\Z")
_NOT_OF_THE_CAR = re.compile(r"\b(?:gps|calc|accelerometer|gyroscope|phone)\b")


@dataclass(frozen=True)
class Heading:
    """A column as the rows above the data describe it.

    ``label`` is the name as written (the caller maps by it), ``names`` every name that may tell the quantity,
    the most telling first, without unit; ``unit`` the unit's text or None. ``source`` is the device that a row of
    sources names; ``stamped``: in place of a unit it is said that the column holds the time stamps of a group.
    """

    index: int
    label: str
    names: tuple[str, ...]
    unit: str | None
    source: str = ""
    stamped: bool = False

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
    names = [row for row in header if not _is_sources(row)]
    sources = next((row for row in header if _is_sources(row)), [])
    place = _units_place(names)
    units = names.pop(place) if place is not None else []
    names = _straight(names, width)
    names = sorted(names, key=known_names, reverse=True)
    columns = max([width, *(filled_width(row) for row in names)])
    return tuple(_heading(index, names, units, sources) for index in range(columns))


def _heading(index: int, names: Sequence[HeadRow], units: HeadRow, sources: HeadRow) -> Heading:
    written = [row[index] for row in names if index < len(row) and row[index]]
    split = [split_unit(name) for name in written]
    unit = next((part.unit for part in split if part.unit is not None), None)
    below = clean_unit(units[index]) if index < len(units) else ""
    stamped = _is_stamp(below)
    if unit is None and below and not stamped:
        unit = below
    label = written[0].replace("\ufeff", "").strip() if written else f"column {index + 1}"
    label = split[0].text if label.count("|") >= 2 else label
    source = sources[index].strip().lower() if index < len(sources) else ""
    return Heading(index, label, tuple(dict.fromkeys(part.text for part in split)), unit, source, stamped)


def names_columns(header: Sequence[HeadRow]) -> bool:
    """Return whether rows above the data name columns: a spreadsheet's own *Column1*, *Column2* name nothing."""
    return any(cell and not _NAMELESS.match(words(cell)) for row in header for cell in row)


def nameless(heading: Heading) -> bool:
    """Return whether nothing names a column, or only a spreadsheet's own *Column1*."""
    return not heading.names or bool(_NAMELESS.match(words(heading.names[0])))


def _is_stamp(cell: str) -> bool:
    """Return whether a cell in a row of units says *STAMP*, *MARKE*: the column holds the time of a group."""
    match = match_name(cell) if len(cell) > 2 and not is_unit(cell) else None
    return match is not None and match.quantity == "time"


def _is_sources(row: HeadRow) -> bool:
    filled = [cell.strip().lower() for cell in row if cell]
    return bool(filled) and all(map(_SOURCE.match, filled)) and any(cell[0].isdigit() for cell in filled)


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
        if len(cell) > _LONGEST_UNIT or (not is_unit(cell) and not _is_stamp(cell) and match_name(cell) is not None):
            return 0
    return len(units)


def _straight(names: list[HeadRow], width: int) -> list[HeadRow]:
    """Leave out rows of descriptions that are shifted against the data: shorter than the table, without a blank."""

    def straight(row: HeadRow) -> bool:
        end = filled_width(row)
        return abs(end - width) <= 1 or not all(row[:end])

    return [row for row in names if straight(row)] or names


def units_share(row: HeadRow) -> float:
    """Return which share of a row's cells are units."""
    filled = [cell for cell in row if cell.strip() and cell.strip() != "-"]
    if not filled:
        return 0.0
    return sum(is_unit(cell) for cell in filled) / len(filled)


def known_names(row: HeadRow) -> int:
    """Return how many cells of a row name a quantity."""
    return sum(match_name(split_unit(cell).text) is not None for cell in row if cell)


def filled_width(row: HeadRow) -> int:
    """Return the number of cells up to the last one that is not blank."""
    return max((index + 1 for index, cell in enumerate(row) if cell), default=0)


def named_by_a_date(heading: Heading) -> bool:
    """Return whether a column's header is itself a date, which one app writes above its clock."""
    return bool(heading.names) and is_clock(heading.names[0])


# raw whole numbers by the channel's type; pressures are absolute, their zero on the gauge is 1013
_TYPE_UNITS = {
    "enginespeed": "rpm", "temperature": "0.1 K", "pressure": "0.1 kPa abs", "abspressure": "0.1 kPa abs",
    "speed": "0.1 km/h", "gear": "gear",
}  # fmt: skip


def defined_above(rows: Sequence[HeadRow], width: int) -> tuple[Heading, ...] | None:
    """Return the headings that the lines above a table define instead of a row of names; None where they do not."""
    return _in_blocks(rows, width) or _in_sections(rows, width)


def _in_blocks(rows: Sequence[HeadRow], width: int) -> tuple[Heading, ...] | None:
    """Return the channels defined in blocks ``Channel : …``, ``ID : …``, ``Type : …`` above data without names.

    The first column of the data is the clock, the others follow the order of the blocks.
    """
    channels: list[list[str]] = []
    for row in rows:
        key, _, value = ",".join(row).partition(":")
        key = key.strip().lower()
        if key == "channel" and value.strip():
            channels.append([value.strip(), ""])
        elif key == "type" and channels:
            channels[-1][1] = value.strip()
    if not channels or abs(len(channels) + 1 - width) > 1:
        return None
    headings = [Heading(0, "time of day", ("time",), None)]
    for index, (name, kind) in enumerate(channels, start=1):
        unit = _TYPE_UNITS.get(kind.lower(), kind or None)
        headings.append(Heading(index, name, (name,), unit))
    return tuple(headings)


_SECTION = re.compile(r"\[([^\[\]]+)\]\Z")


def _in_sections(rows: Sequence[HeadRow], width: int) -> tuple[Heading, ...] | None:
    """Return the channels that sections ``[header]`` or ``[column names]`` name, with ``[channel units]``.

    Names with blanks stand whole in ``[header]``, a line each; the units are those of the last channels.
    """
    sections: dict[str, list[str]] = {}
    section = ""
    for row in rows:
        line = " ".join(cell for cell in row if cell)
        if match := _SECTION.match(line):
            section = match[1].strip().lower()
        elif line:
            sections.setdefault(section, []).append(line)
    if "header" not in sections and "column names" not in sections:
        return None
    torn = " ".join(sections.get("column names", [])).split()
    names = next((each for each in (sections.get("header", []), torn) if len(each) == width), None)
    if names is None:
        return None
    units = sections.get("channel units", [])[:width]
    stated = [None] * (width - len(units)) + [clean_unit(unit) or None for unit in units]
    headings = []
    for index, (name, unit) in enumerate(zip(names, stated, strict=True)):
        split = split_unit(name)
        headings.append(Heading(index, name, (split.text,), split.unit or unit))
    return tuple(headings)


def with_stated_units(headings: tuple[Heading, ...], rows: Sequence[HeadRow]) -> tuple[Heading, ...]:
    """Return the headings with the units that a measurement file's head states, ``Y_Unit_Label``, where they have none.

    One column of x stands before all others, or before each (``X_Columns Multi``).
    """
    keyed = {row[0].strip().lower(): row[1:] for row in rows if len(row) > 1}
    units = [clean_unit(unit) for unit in keyed.get("y_unit_label", [])]
    if not any(units):
        return headings
    before_each = "".join(keyed.get("x_columns", [])[:1]).strip().lower() == "multi"
    of_column = {(2 * place + 1 if before_each else place + 1): unit for place, unit in enumerate(units) if unit}
    return tuple(
        heading if heading.unit is not None else replace(heading, unit=of_column.get(heading.index))
        for heading in headings
    )
