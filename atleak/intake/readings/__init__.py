"""A measuring sheet (workbook or text) → readings.

The form is that of the source study's Table 1, a tidy table, or a table with several diameters in a row; see
``docs/measuring-sheet.md``. Everything wrong is told at once, with file, sheet, row and column.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from atleak.controller import Controller
from atleak.errors import Message, Place, ReadingsError, nearest_name
from atleak.intake.readings.checks import check
from atleak.intake.readings.columns import count_values
from atleak.intake.readings.files import read_bytes, read_sheets
from atleak.intake.readings.headings import EXPECTED, Header, find_header
from atleak.intake.readings.names import Names
from atleak.intake.readings.problems import ReadingsRefused
from atleak.intake.readings.rows import Table, read_rows
from atleak.intake.readings.sheet import Sheet
from atleak.intake.units import unit as unit_named
from atleak.readings import Readings

__all__ = ["ReadingsRefused", "check", "read_readings"]


def read_readings(
    source: str | Path | bytes,
    controller: Controller,
    *,
    name: str | None = None,
    sheet: str | None = None,
    unit: str | None = None,
) -> Readings:
    """The readings of a measuring sheet.

    Parameters
    ----------
    source
        path of a file, or its bytes: ``.xlsx`` (also xls, ods), or text with columns separated by comma, semicolon or
        tab.
    controller
        whose components and planes the sheet names. Its nominal diameters tell a wrong unit.
    name
        what to call the file in messages; the path's own name by default.
    sheet
        the workbook's sheet to read, where more than one holds readings.
    unit
        unit of the diameters ("mm", "µm", "inch" …), instead of what the headings say.

    Returns
    -------
    Readings
        diameters in metres, each with its place in the file; ``messages`` say what was assumed.

    Raises
    ------
    ReadingsRefused
        with all problems found: an unknown component, part or plane, a cell that is no diameter, a repeat given twice,
        a diameter off its nominal one by a factor, a sleeve smaller than its spool, a clearance over 0.5 mm …
    ReadingsError
        where the file as a whole cannot be read: no such file, empty, damaged, a picture, no measuring sheet in it,
        several of them, or none filled in.
    """
    told = None if unit is None else unit_named(unit, "length")
    data, file = read_bytes(source, name)
    headers: dict[int, Header | None] = {}

    def header_of(found: Sheet) -> Header | None:
        if id(found) not in headers:
            headers[id(found)] = find_header(found)
        return headers[id(found)]

    def score(found: Sheet) -> float:
        header = find_header(found)
        return -1.0 if header is None else header.score + 0.01 * min(count_values(found, header), 10)

    sheets = read_sheets(data, file, score)
    candidates = [(found, header_of(found)) for found in sheets]
    chosen, header, messages = _choose(candidates, file, sheet)
    table = read_rows(chosen, header, Names(controller), told)
    converted = table.converted
    result = Readings(
        file=file,
        sha256=hashlib.sha256(data).hexdigest(),
        sheet=chosen.name,
        unit=", ".join(converted.units) or (told.name if told else "mm"),
        unit_assumed=converted.unit_assumed,
        layout=_layout(table, header),
        readings=tuple(converted.readings),
        messages=(*messages, *table.messages, *_about(table, chosen)),
    )
    problems = [*table.problems, *check(result, controller)]
    if problems:
        raise ReadingsRefused(sorted(problems, key=lambda problem: problem.place.row or 0))
    if not result.readings:
        raise _not_filled_in(file, chosen, header)
    return result


def _choose(
    candidates: Sequence[tuple[Sheet, Header | None]], file: str, wanted: str | None
) -> tuple[Sheet, Header, list[Message]]:
    """The one sheet that holds readings."""
    if wanted is not None and any(found.name is not None for found, _ in candidates):
        by_name = {found.name: (found, header) for found, header in candidates if found.name is not None}
        if wanted not in by_name:
            raise ReadingsError(
                "the workbook has no such sheet",
                place=Place(file),
                value=wanted,
                expected="one of " + ", ".join(by_name),
                nearest=nearest_name(wanted, by_name),
            )
        found, header = by_name[wanted]
        if header is None or not header.complete:
            usable = [each.name for each, other in candidates if other is not None and other.complete]
            hint = f"; readings are in sheet {', '.join(map(repr, usable))}" if usable else ""
            raise ReadingsError(f"this sheet holds no readings{hint}", place=Place(file, wanted), expected=EXPECTED)
        return found, header, []
    complete = [(found, header) for found, header in candidates if header is not None and header.complete]
    if not complete:
        raise _no_header(candidates, file)
    filled = [(found, header) for found, header in complete if count_values(found, header)]
    if not filled:
        raise _not_filled_in(file, *complete[0])
    if len(filled) > 1:
        # a hidden sheet is no one's answer while a visible one is there
        filled = [pair for pair in filled if not pair[0].hidden] or filled
    if len(filled) > 1:
        names = [found.name for found, _ in filled]
        raise ReadingsError(
            f"{len(names)} sheets hold readings",
            place=Place(file),
            value=", ".join(repr(each) for each in names),
            expected="one: say which sheet, or delete the others",
        )
    (found, header), messages = filled[0], []
    others = [each.name for each, _ in complete if each is not found]
    if others:
        messages.append(
            Message(
                "info",
                "sheet_chosen",
                f"read from sheet {found.name!r}; left aside: {', '.join(repr(each) for each in others)}",
                Place(file, found.name),
            )
        )
    return found, header, messages


def _no_header(candidates: Sequence[tuple[Sheet, Header | None]], file: str) -> ReadingsError:
    if not any(any(any(str(cell).strip() for cell in row) for row in found.rows) for found, _ in candidates):
        return ReadingsError("the workbook is empty", place=Place(file), expected="a measuring sheet filled in")
    best = max(candidates, key=lambda pair: pair[1].score if pair[1] else 0.0)
    found, header = best
    if header is None:
        names = [each.name for each, _ in candidates if each.name is not None]
        looked = f" in any of the sheets {', '.join(repr(each) for each in names)}" if len(names) > 1 else ""
        return ReadingsError(
            f"no row of headings found{looked}: not a measuring sheet?",
            place=Place(file, found.name if len(candidates) == 1 else None),
            expected=EXPECTED,
        )
    missing = []
    if not header.of("component"):
        missing.append("component")
    if not header.values:
        missing.append("diameter, or coordinate x1 and coordinate x2")
    headings = ", ".join(repr(" ".join(column.heading.split())) for column in header.columns)
    return ReadingsError(
        f"no heading for {' nor for '.join(missing)}",
        place=found.place(header.last),
        value=headings,
        expected=EXPECTED,
    )


def _not_filled_in(file: str, found: Sheet, header: Header) -> ReadingsError:
    return ReadingsError(
        "no readings are filled in: every diameter is empty",
        place=Place(file, found.name, found.row_number(header.last)),
        expected="at least one diameter, or two coordinates",
    )


def _layout(table: Table, header: Header) -> Literal["table", "tidy", "columns"]:
    if any(reading.coordinates is not None for reading in table.converted.readings):
        return "table"
    return "columns" if len({column.group for column in header.values}) > 1 else "tidy"


def _about(table: Table, chosen: Sheet) -> list[Message]:
    messages = []
    if chosen.note:
        messages.append(Message("info", "read_as", chosen.note, Place(chosen.file)))
    if table.rows_without_reading:
        rows = table.rows_without_reading
        messages.append(
            Message(
                "info",
                "rows_not_measured",
                f"{rows} row{'s' if rows > 1 else ''} without a reading: not measured",
                Place(chosen.file, chosen.name),
            )
        )
    return messages
