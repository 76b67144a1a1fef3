"""A stationary pressure table (workbook or text) → gauge readings, each with its place.

Ranges of the lever stand in rows or in columns, and so do the states of the engine and the taps; see
``docs/pressure-table.md``. An empty cell was not measured. Everything wrong is listed at once, with file, sheet, row
and column.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.written_numbers import ENGINE_SPEED, TEMPERATURE, AskedNumber, read_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Message, Place, PressureTableError, one_of
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.common.units import UNIT_KINDS, Unit, find_unit, unit_names
from atleak.measurements.gauge_readings import LINE_TAP, GaugeCell, GaugeReading, PressureTable, ranges_of
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Cell as SheetCell
from atleak.readers.cells.sheet import Sheet, column_letter, text_of
from atleak.readers.cells.sheet_file import open_sheets
from atleak.readers.gauges.gauge_headings import (
    GaugeTable,
    GaugeWords,
    Said,
    engine_words,
    find_gauge_tables,
    is_blank_heading,
    likeness,
)
from atleak.readers.gauges.value_table import Faults, in_si, is_number, not_typed_as_number, split_cell, written_in_cell
from atleak.readers.own_forms import form_doubts

HIGHEST = 6.0e6  # [Pa] that a gauge in a transmission can show: choice of this project
_ASIDE_SHOWN = 6
_NOT_UNDERSTOOD = {  # what is said of an empty cell, and of one that names nothing known
    "range": (Sentence("no range in this row"), Sentence("no such range of this unit")),
    "engine": (Sentence("nothing says what the engine does in this row"), Sentence("no such state of the engine")),
    "tap": (Sentence("no tap in this row"), Sentence("no such tap of this unit")),
}


@dataclass
class _Rows(Faults):
    """What the rows of all tables give."""

    error: type[InputError] = PressureTableError
    readings: list[GaugeReading] = field(default_factory=list)
    units: dict[str, None] = field(default_factory=dict)
    taken: list[tuple[GaugeReading, float | None]] = field(default_factory=list)  # with what counts its repeats

    def count_repeats(self) -> None:
        """Number the readings of each cell; one that is given twice, and that nothing counts, is a problem."""
        by_cell: dict[GaugeCell, list[tuple[GaugeReading, float | None]]] = {}
        for reading, order in self.taken:
            by_cell.setdefault(reading.cell, []).append((reading, order))
        for cell, given in by_cell.items():
            if len(self.problems) > FAULTS:
                return
            seen: dict[float | None, GaugeReading] = {}
            for reading, order in given:
                first = seen.get(order) or (seen and order is None and given[0][0])
                if first:
                    problem = Sentence("{range}, {engine}, {tap} stands in {place} already")
                    before = replace(first.place, file=None).sentence
                    self.refuse(
                        problem.of(range=cell.range, engine=cell.engine.label, tap=cell.tap, place=before),
                        reading.place,
                        expected=Sentence("each once, or a column 'repeat' or 'time' that counts its readings"),
                    )
                seen[order] = reading
            ordered = sorted(given, key=lambda pair: pair[1] or 0.0)
            self.readings += [
                replace(reading, repeat=number, round=order) for number, (reading, order) in enumerate(ordered, start=1)
            ]


def asked_pressure(unit: Unit) -> AskedNumber:
    """Return the pressure that is asked for in a cell, in its unit."""
    return AskedNumber(UNIT_KINDS["pressure"], unit.name, round(450e3 / unit.factor, 3), (0.0, HIGHEST / unit.factor))


def _read_rows(tables: Sequence[GaugeTable], words: GaugeWords, ranges: Sequence[SelectorRange]) -> _Rows:
    """Return the readings of several tables of one file, and what of them cannot be read."""
    rows = _Rows()
    for table in tables:
        _Reader(table, words, ranges, rows).read()
    rows.count_repeats()
    return rows


class _Reader:
    """Reads the rows of one table."""

    def __init__(self, table: GaugeTable, words: GaugeWords, ranges: Sequence[SelectorRange], rows: _Rows) -> None:
        self.table, self.sheet, self.words, self.ranges, self.rows = table, table.sheet, words, ranges, rows
        self.columns = {
            kind: table.column(kind)
            for kind in ("range", "engine", "tap", "temperature", "engine_speed", "repeat", "time", "gauge", "unit")
        }

    def read(self) -> None:
        """Read every row that holds a reading."""
        before = len(self.rows.taken)
        for row in self.table.rows:
            filled = [column for column in self.table.values if self._is_reading(row, column)]
            if len(self.rows.problems) > FAULTS:
                return
            if filled:
                self._row(row, filled)
        if len(self.rows.taken) > before:
            self._unknown_columns()
            self._say_what_was_taken()

    def _is_reading(self, row: int, column: int) -> bool:
        """Return whether a reading stands in a cell: what is crossed out is none, and a message says so."""
        return self.rows.holds(self.sheet, row, column, self._place(row, column))

    def _row(self, row: int, filled: Sequence[int]) -> None:
        named = self._named(row)
        if named is None:
            return
        head = self.table.head.temperature
        if self.columns["temperature"] is None and head is not None:
            temperature = self._in_si(head[0], TEMPERATURE, head[3], self._place(*head[1:3]))
        else:
            temperature = self._number(row, "temperature", TEMPERATURE)
        speed = self._number(row, "engine_speed", ENGINE_SPEED)
        time, order = self._time(row), self._order(row, "repeat")
        order = time if order is None else order
        gauge = self._cell(row, "gauge")
        for column in filled:
            said, place = named.over(self.table.said(column)), self._place(row, column)
            if said.range is None or said.range not in self.ranges or said.engine is None:
                heading = self.table.headings[column].text
                place = self._place(self.table.row, column)
                self.rows.refuse(_NOT_UNDERSTOOD["range"][1], place, heading, self.ranges, once=True)
                continue
            cell = GaugeCell(said.range, said.engine, said.tap or LINE_TAP)
            pressure = self._pressure(row, column, cell)
            if pressure is None:
                continue
            reading = GaugeReading(
                cell,
                pressure,
                time=time,
                gauge="" if gauge is None else text_of(gauge),
                temperature=temperature,
                engine_speed=speed if speed is not None else said.engine_speed,
                place=place,
            )
            counted = order if order is not None else (None if said.repeat is None else float(said.repeat))
            self.rows.taken.append((reading, counted))

    def _cell(self, row: int, kind: str) -> SheetCell | None:
        """Return what a row says in the column of a kind; None where there is no such column, or nothing in it."""
        column = self.columns[kind]
        cell = None if column is None else self.sheet.filled(row, column)
        return None if is_blank_heading(cell) else cell

    def _named(self, row: int) -> Said | None:
        """Return what the cells of a row say of its readings; None where one of them is not understood."""
        named, understood = Said(), True
        accepted = {"range": self.ranges, "engine": engine_words(), "tap": self.words.tap_ids}
        for kind, names in accepted.items():
            column = self.columns[kind]
            if column is None:
                continue
            cell = self._cell(row, kind)
            said = None if cell is None else self.words.said_by(cell, kind)
            if said is None or (said.range is not None and said.range not in self.ranges):
                problem = _NOT_UNDERSTOOD[kind][cell is not None]
                self.rows.refuse(problem, self._place(row, column), None if cell is None else text_of(cell), names)
                understood = False
            else:
                named = said.over(named)
        return named if understood else None

    def _pressure(self, row: int, column: int, of: GaugeCell) -> float | None:
        """Return a cell's pressure [Pa]; None where it is a problem."""
        place, cell = self._place(row, column), self.sheet.cell(row, column)
        fault = self.sheet.faults.get((row, column))
        template, value, expected = Sentence("{cell}: not a pressure"), str(cell), None
        unit = None
        if fault is not None:
            template, value = Sentence("{cell}: a formula without a usable result"), fault
            expected = Sentence("a pressure")
        elif not_typed_as_number(cell):
            template = Sentence("{cell}: not a number")
            expected = Sentence("a pressure: format the cell as number or text and type it again")
        else:
            text, written = split_cell(cell)
            unit = find_unit(written, "pressure") if written else self._unit(row, column)
            if unit is not None:
                number = written_in_cell(cell, text, asked_pressure(unit))
                expected = number.reason
                if number.value is not None:
                    self.rows.units[unit.name] = None
                    return float(unit.to_si(number.value))
            elif written:
                units = one_of(unit_names("pressure"))
                expected = Sentence("a number, and behind it nothing or {units}", units=units)
        if expected is not None:
            self.rows.refuse(template.of(cell=(of.range, of.engine.label)), place, value, expected=expected)
        return None

    def _unit(self, row: int, column: int) -> Unit | None:
        """Return the unit of a reading: in its row, in its heading, or above the table; None where it is a problem."""
        heading, head = self.table.headings[column], self.table.head.unit
        stated = self._cell(row, "unit")
        if stated is not None:
            name, place = str(stated), self._place(row, self.columns["unit"])
        elif heading.unit is not None:
            return heading.unit
        elif head is not None and heading.wrong_unit is None:
            name, place = head[0], self._place(*head[1:])
        else:
            name, place = heading.wrong_unit or "", self._place(self.table.row, column)
        unit = find_unit(name, "pressure") if name else None
        if unit is None:
            problem = Sentence("unknown unit of pressure") if name else Sentence("no unit of the pressures")
            expected = Sentence("{units}, in the heading as in 'slow idle [kPa]'", units=one_of(unit_names("pressure")))
            self.rows.refuse(problem, place, name or heading.text or None, expected=expected, once=True)
        return unit

    def _number(self, row: int, kind: str, asked: AskedNumber) -> float | None:
        """Return the number of a row in SI, °C for a temperature; None where there is none or it is a problem."""
        column, cell = self.columns[kind], self._cell(row, kind)
        if column is None or cell is None:
            return None
        return self._in_si(cell, asked, self.table.headings[column].unit, self._place(row, column))

    def _in_si(self, cell: SheetCell, asked: AskedNumber, stated: Unit | None, place: Place) -> float | None:
        """Return a temperature [°C] or speed [1/s]; its unit stands behind it, in the heading, or is the usual one."""
        kind = "temperature" if asked is TEMPERATURE else "rotational_speed"
        number = in_si(cell, asked, kind, stated)
        if number.value is not None:
            return number.value
        low, high = asked.limits
        expected = Sentence("{low:g} to {high:g} {unit}", low=low, high=high, unit=asked.unit)
        problem = Sentence("not one temperature") if asked is TEMPERATURE else Sentence("not one engine speed")
        self.rows.refuse(problem, place, str(cell), expected=expected)
        return None

    def _time(self, row: int) -> float | None:
        """Return the time of a row [s]: a clock's, or a number of what its heading names, seconds unless that does."""
        column, cell, time = self.columns["time"], self._cell(row, "time"), self._order(row, "time")
        if column is None or time is None:
            return None
        clock = isinstance(cell, dt.time) or ":" in str(cell)
        minutes = re.search(r"\b(min|minut\w*)\b", self.table.headings[column].text.lower())
        return time * 60.0 if minutes and not clock else time

    def _order(self, row: int, kind: str) -> float | None:
        cell = self._cell(row, kind)
        if cell is None:
            return None
        if isinstance(cell, dt.time):
            return cell.hour * 3600.0 + cell.minute * 60.0 + cell.second
        clock = re.fullmatch(r"(\d{1,2}):(\d{2})(?::(\d{2}))?", str(cell).strip())
        if clock:
            return int(clock[1]) * 3600.0 + int(clock[2]) * 60.0 + int(clock[3] or 0)
        number = read_number(str(cell), AskedNumber(Sentence("repeat"), "", 2.0)).value
        if number is None:
            place, expected = self._place(row, self.columns[kind]), Sentence("1, 2, 3 … or a time")
            self.rows.refuse(Sentence("not a repeat"), place, str(cell), expected=expected)
        return number

    def _unknown_columns(self) -> None:
        """Refuse a column of numbers whose heading says nothing known; name what is left aside."""
        aside = []
        labels = {*self.ranges, *engine_words(), *self.words.tap_ids}
        for column in range(self.sheet.width):
            heading = self.table.headings.get(column)
            if heading is not None and heading.kind not in (None, "aside"):
                continue
            if not any(is_number(self.sheet.cell(row, column)) for row in self.table.rows):
                continue
            if heading is None or heading.kind == "aside":
                aside.append(column_letter(column) if heading is None else heading.text)
            else:
                names = one_of(sorted(labels, key=len))
                expected = Sentence("{names}; or 'note' over what is no reading", names=names)
                place = self._place(self.table.row, column)
                problem = Sentence("no such column of a pressure table")
                self.rows.refuse(problem, place, heading.text, expected=expected)
        if aside:
            text = Sentence(
                "columns left aside, which hold no readings: {columns}",
                columns=tuple(map(repr, aside[:_ASIDE_SHOWN])),
            )
            self.rows.messages.append(Message("info", "column_aside", text, self._place(self.table.row)))

    def _say_what_was_taken(self) -> None:
        taps = [self.table.said(column).tap for column in self.table.values]
        if self.columns["tap"] is None and None in taps:
            text = Sentence("the table names no tap: its readings are taken as main pressure, at the line's tap")
            self.rows.messages.append(Message("info", "tap_assumed", text, self._place(self.table.row)))

    def _place(self, row: int, column: int | None = None) -> Place:
        heading: Any = self.table.headings.get(column) if column is not None else None
        return self.sheet.place(row, column, heading.text if heading is not None else "")


_WANTED = Sentence("a table of gauge readings as .xlsx workbook or .csv text")
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
    data, file, sheets = open_sheets(source, name, likeness_of(controller), PressureTableError, _WANTED)
    tabs = find_tabs(sheets, controller)
    if not tabs.tables:
        raise PressureTableError(Sentence("holds no table of gauge readings"), place=Place(file), expected=_HEADINGS)
    table = tabs.read(file, data)
    if table is None:
        first = tabs.tables[0]
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
        rows = _read_rows(self.tables, GaugeWords.of(self.controller), ranges_of(self.controller))
        if rows.problems:
            raise faults_together(sorted(rows.problems, key=lambda each: (each.place.sheet or "", each.place.row or 0)))
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
            messages=(
                *(Message("info", "read_as", note, Place(file)) for note in notes),
                *form_doubts(table.sheet for table in self.tables),
                *rows.messages,
            ),
        )


def likeness_of(controller: Controller) -> Callable[[Sheet], float]:
    """Return how to count the headings of a sheet that are understood as those of gauge readings."""
    return partial(likeness, words=GaugeWords.of(controller))


def find_tabs(sheets: Sequence[Sheet], controller: Controller) -> PressureTabs:
    """Find the sheets that hold tables of gauge readings; hidden ones do not count."""
    words = GaugeWords.of(controller)
    shown = [sheet for sheet in sheets if not sheet.hidden]
    return PressureTabs([table for sheet in shown for table in find_gauge_tables(sheet, words)], controller)
