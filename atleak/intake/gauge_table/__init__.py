"""A stationary pressure table (workbook or text) → gauge readings.

Ranges of the lever stand in rows or in columns, and so do the states of the engine and the taps; see
``docs/pressure-table.md``. An empty cell was not measured. Everything wrong is listed at once, with file, sheet, row
and column.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.doors import own_errors_only
from atleak.errors import Message, Place, PressureTableError
from atleak.faults import together
from atleak.intake.gauge_table.rows import read_rows
from atleak.intake.gauge_table.tables import GaugeTable, find_gauge_tables, likeness
from atleak.intake.gauge_table.words import Words
from atleak.intake.sheets.sheet import Sheet
from atleak.intake.sheets.sheet_file import open_sheets
from atleak.pressure_table import PressureTable, ranges_of
from atleak.sentence import Sentence

__all__ = ["PressureTabs", "find_tabs", "likeness_of", "read_pressure_table"]

WANTED = Sentence("a table of gauge readings as .xlsx workbook or .csv text")
_HEADINGS = Sentence(
    "headings for the range (P R N D 3 2 1), the engine (slow idle, fast idle, stall) and the pressure with its unit, "
    "such as: range, slow idle [kPa], fast idle [kPa], stall [kPa]"
)


@own_errors_only(PressureTableError, "name", "source")
def read_pressure_table(
    source: str | Path | bytes, controller: Controller, *, name: str | None = None
) -> PressureTable:
    """Return the gauge readings of a pressure table that is a file of its own.

    Parameters
    ----------
    source
        path of a file, or its bytes: ``.xlsx`` (also xls, ods), or text with columns separated by comma, semicolon or
        tab.
    controller
        whose circuits the taps name.
    name
        what to call the file in messages; the path's own name by default.

    Returns
    -------
    PressureTable
        pressures in pascals, each with its place in the file; ``messages`` say what was assumed.

    Raises
    ------
    PressureTableError
        with all problems found: an unknown range, state of the engine, tap or unit, a cell that is no pressure, a
        cell given twice; or where the file as a whole holds no such table, or none filled in.
    """
    data, file, sheets = open_sheets(source, name, likeness_of(controller), PressureTableError, WANTED)
    found = find_tabs(sheets, controller)
    if not found.tables:
        raise PressureTableError(Sentence("holds no table of gauge readings"), place=Place(file), expected=_HEADINGS)
    table = found.read(file, data)
    if table is None:
        first = found.tables[0]
        place = Place(file, first.sheet.name, first.sheet.row_number(first.row))
        expected = Sentence("at least one gauge reading")
        raise PressureTableError(Sentence("no pressure is filled in"), place=place, expected=expected)
    return table


class PressureTabs:
    """The sheets of a file that hold tables of gauge readings."""

    def __init__(self, tables: Sequence[GaugeTable], controller: Controller) -> None:
        self.tables, self.controller = tuple(tables), controller

    def __contains__(self, sheet: Sheet) -> bool:
        return any(table.sheet is sheet for table in self.tables)

    def read(self, file: str, data: bytes) -> PressureTable | None:
        """Return the gauge readings of all tables; None where none of them is filled in.

        Raises
        ------
        PressureTableError
            as `read_pressure_table`.
        """
        rows = read_rows(self.tables, Words.of(self.controller), ranges_of(self.controller))
        if rows.problems:
            raise together(sorted(rows.problems, key=lambda each: (each.place.sheet or "", each.place.row or 0)))
        if not rows.readings:
            return None
        names = dict.fromkeys(table.sheet.name for table in self.tables if table.sheet.name is not None)
        notes = dict.fromkeys(table.sheet.note for table in self.tables if table.sheet.note)
        return PressureTable(
            file=file,
            sha256=hashlib.sha256(data).hexdigest(),
            sheet=", ".join(names) or None,
            units=tuple(rows.units),
            readings=tuple(rows.readings),
            messages=(*(Message("info", "read_as", note, Place(file)) for note in notes), *rows.messages),
        )


def likeness_of(controller: Controller) -> Callable[[Sheet], float]:
    """Return how to count the headings of a sheet that are understood as those of gauge readings."""
    return partial(likeness, words=Words.of(controller))


def find_tabs(sheets: Sequence[Sheet], controller: Controller) -> PressureTabs:
    """Find the sheets that hold tables of gauge readings; hidden ones do not count."""
    words = Words.of(controller)
    shown = [sheet for sheet in sheets if not sheet.hidden]
    return PressureTabs([table for sheet in shown for table in find_gauge_tables(sheet, words)], controller)
