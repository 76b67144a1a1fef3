"""Typed entries as the measuring sheet in which a job keeps them: text, every sign as it was typed.

`atleak.intake.readings.read_readings` reads it as any other sheet. A column says of every row whether it counts, so
that nothing that cannot be a reading enters a verdict, and nothing typed is lost.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict, replace

from pydantic import TypeAdapter

from atleak.catalogue.controller import Controller
from atleak.doors import own_errors_only
from atleak.errors import InputError
from atleak.intake.sheets.text import csv_bytes, csv_rows
from atleak.intake.units import unit, unit_names
from atleak.measuring.plan import PARTS, Cell, Plan
from atleak.measuring.typed import Entry, Typed, cell_of, in_mm
from atleak.readings import TYPED_MARK, Readings

TYPED_FILE = "typed readings.csv"
_SEPARATED = b"sep=;\r\n"  # so that a spreadsheet program, and the intake, need not guess
_KEYS = ("No.", "Part", "Plane", "Direction", "Repeat")
_COORDINATES = ("Coordinate x1 [mm]", "Coordinate x2 [mm]")
_LAST = ("Counts", "Taken at")
_UNWORN = "unworn end"
_MM = unit("mm", "length")
_OF_LANDS = ("No.", "Land", "Contact length [mm]", "Position from left end [mm]", "Fitted repair")


def written(typed: Typed, counting: Collection[Cell], controller: Controller) -> bytes | None:
    """Return the file; None where nothing was typed.

    Parameters
    ----------
    typed
        all entries.
    counting
        the cells of which the readings count.
    controller
        whose lands they are of.
    """
    if not typed.entries:
        return None
    rows = [[TYPED_MARK, json.dumps(asdict(typed.plan))], [f"Controller {controller.id}"]]
    rows += [*_head(typed.sheet), _headings(typed.unit)]
    for cell in typed.plan.in_order(controller, typed.entries):
        rows.append([*_labels(cell), *_values(typed.entries[cell]), "yes" if cell in counting else "no", ""])
    for reading in typed.sheet.unworn if typed.sheet else ():
        size = f"{in_mm(reading.diameter)} mm"
        rows.append([*_labels(cell_of(reading)), *_values(Entry(size, reading.coordinates)), "yes", _UNWORN])
    return _SEPARATED + csv_bytes([*rows, *_of_lands(typed.sheet)])


def _headings(unit: str) -> list[str]:
    return [*_KEYS, *_COORDINATES, f"Diameter [{unit}]", *_LAST]


def _labels(cell: Cell) -> list[str]:
    direction = "" if cell.direction is None else f"{cell.direction:.12g}"
    return [cell.component, cell.part, cell.plane, direction, str(cell.repeat)]


def _values(entry: Entry) -> list[str]:
    if entry.coordinates is None:
        return ["", "", entry.text]
    return [*map(in_mm, entry.coordinates), ""]


def _head(sheet: Readings | None) -> Iterator[list[str]]:
    """Yield what the sheet that is gone on from states of the measurement as a whole."""
    if sheet is None:
        return
    if sheet.temperature is not None:
        yield ["Measuring temperature", f"{sheet.temperature:.12g} °C"]
    if sheet.date is not None:
        yield ["Date", sheet.date.isoformat()]
    for name, um in zip(("side", "tip"), sheet.pump.um, strict=True):
        if um is not None:
            yield [f"Pump {name} clearance [µm]", f"{um:.12g}"]


def _of_lands(sheet: Readings | None) -> Iterator[list[str]]:
    """Yield, as a table of its own, what that sheet states of lands themselves."""
    if sheet is None or not (sheet.own_lands.lengths or sheet.own_lands.fitted):
        return
    yield []
    yield [*_OF_LANDS]
    for each in sheet.own_lands.lengths:
        sizes = (each.contact_length, each.position)
        yield [each.component, str(each.land), *("" if size is None else in_mm(size) for size in sizes), ""]
    for fitted in sheet.own_lands.fitted:
        yield [fitted.component, "", "", "", fitted.repair]


@own_errors_only(InputError)
def typed_in(content: bytes, sheet: Readings, controller: Controller) -> Typed | None:
    """Return the entries of a file that `written` gave; None for any other file, and for another valve body's.

    Parameters
    ----------
    content
        of the file.
    sheet
        what `read_readings` reads of that same file.
    controller
        whose lands it names.

    Raises
    ------
    InputError
        where atleak itself fails on it.
    """
    rows = csv_rows(content.removeprefix(_SEPARATED))
    if not rows or rows[0][:1] != [TYPED_MARK]:
        return None
    units = {tuple(_headings(name)): name for name in unit_names("length")}
    head = next((number for number, row in enumerate(rows) if tuple(row) in units), None)
    if head is None:
        return None
    try:
        plan = TypeAdapter(Plan).validate_json(rows[0][1] if len(rows[0]) > 1 else "")
        entries = dict(_entries(rows[head + 1 :]))
    except ValueError:  # somebody has edited it
        return None
    if any(controller.land_of_plane(cell.component, cell.plane) is None for cell in entries):
        return None
    return Typed(entries, plan, units[tuple(rows[head])], sheet=replace(sheet, readings=()))


def _entries(rows: Iterable[list[str]]) -> Iterator[tuple[Cell, Entry]]:
    """Yield the entries of the table that begins here.

    Raises
    ------
    ValueError
        where it is not as `written` gave it.
    """
    for row in itertools.takewhile(bool, rows):
        component, part, plane, direction, repeat, first, second, text, _, taken_at = row
        if taken_at:
            continue
        cell = Cell(component, PARTS[PARTS.index(part)], plane, float(direction) if direction else None, int(repeat))
        if text:
            yield cell, Entry(text)
        else:
            ends = _MM.to_si(float(first)), _MM.to_si(float(second))
            yield cell, Entry(in_mm(abs(ends[0] - ends[1])), ends)
