"""Reads what the lines above a table say of its columns: blocks that define channels, sections of names and units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from atleak.intake.road_test.files.headings import Heading, Row
from atleak.intake.road_test.names.matching import clean_unit, split_unit

# raw whole numbers by the channel's type; pressures are absolute, their zero on the gauge is 1013
_TYPE_UNITS = {
    "enginespeed": "rpm", "temperature": "0.1 K", "pressure": "0.1 kPa abs", "abspressure": "0.1 kPa abs",
    "speed": "0.1 km/h", "gear": "gear",
}  # fmt: skip


def defined_above(rows: Sequence[Row], width: int) -> tuple[Heading, ...] | None:
    """Return the headings that the lines above a table define instead of a row of names; None where they do not."""
    return _in_blocks(rows, width) or _in_sections(rows, width)


def _in_blocks(rows: Sequence[Row], width: int) -> tuple[Heading, ...] | None:
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


def _in_sections(rows: Sequence[Row], width: int) -> tuple[Heading, ...] | None:
    """Return the channels that sections ``[header]`` or ``[column names]`` name, with ``[channel units]``.

    Names with blanks stand whole in ``[header]``, a line each; the units are those of the last channels.
    """
    sections: dict[str, list[str]] = {}
    section = ""
    for row in rows:
        line = " ".join(cell for cell in row if cell)
        if found := _SECTION.match(line):
            section = found[1].strip().lower()
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


def with_stated_units(headings: tuple[Heading, ...], rows: Sequence[Row]) -> tuple[Heading, ...]:
    """Return the headings with the units that a measurement file's head states, ``Y_Unit_Label``, where they have none.

    One column of x stands before all others, or before each (``X_Columns Multi``).
    """
    keyed = {row[0].strip().lower(): row[1:] for row in rows if len(row) > 1}
    units = [clean_unit(unit) for unit in keyed.get("y_unit_label", [])]
    if not any(units):
        return headings
    each = "".join(keyed.get("x_columns", [])[:1]).strip().lower() == "multi"
    of_column = {(2 * place + 1 if each else place + 1): unit for place, unit in enumerate(units) if unit}
    return tuple(
        heading if heading.unit is not None else replace(heading, unit=of_column.get(heading.index))
        for heading in headings
    )
