"""A stationary pressure table (workbook or text) → gauge readings, each with its place.

Ranges of the lever stand in rows or in columns, and so do the states of the engine and the taps; see
``docs/pressure-table.md``. An empty cell was not measured. Everything wrong is listed at once, with file, sheet, row
and column.
"""

from __future__ import annotations

import hashlib
import re
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import ENGINE_SPEED, TEMPERATURE, AskedNumber, read_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Message, Place, PressureTableError, one_of
from atleak.common.sentences import Sentence
from atleak.common.units import UNIT_KINDS, Unit, unit
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable, ranges_of
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Sheet, column_letter, text_of
from atleak.readers.gauges.gauge_headings import GaugeTable, GaugeWords, Said, find_gauge_tables, likeness
from atleak.readers.gauges.value_table import Faults, ValueFile, asked_in, is_number

# 6 MPa is the most that a gauge in a transmission can show: choice of this project
_PRESSURE = AskedNumber(UNIT_KINDS["pressure"], "kPa", 450.0, (0.0, 6000.0))
_CLOCK = re.compile(r"(\d{1,2}):(\d{2})(?::(\d{2}))?(?:\.\d*)?")
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
        by_cell = defaultdict[GaugeCell, list[tuple[GaugeReading, float | None]]](list)
        for reading, order in self.taken:
            by_cell[reading.cell].append((reading, order))
        for cell, given in by_cell.items():
            if len(self.problems) > FAULTS:
                return
            seen: dict[float | None, GaugeReading] = {}
            for reading, order in given:
                first = seen.get(order) or (seen and order is None and given[0][0])
                if first:
                    named = {"range": cell.range, "engine": cell.engine.label, "tap": cell.tap}
                    problem = Sentence("{range}, {engine}, {tap} stands in {place} already")
                    problem = problem.of(**named, place=replace(first.place, file=None).sentence)
                    expected = Sentence("each once, or a column 'repeat' or 'time' that counts its readings")
                    self.refuse(problem, reading.place, expected=expected)
                seen[order] = reading
            ordered = enumerate(sorted(given, key=lambda pair: pair[1] or 0.0), start=1)
            self.readings += [replace(reading, repeat=number, round=order) for number, (reading, order) in ordered]


def asked_pressure(shown: Unit) -> AskedNumber:
    """Return the pressure that is asked for in a cell, in its unit."""
    return asked_in(_PRESSURE, shown, "pressure")


class _Reader:
    """Reads the rows of one table."""

    def __init__(self, table: GaugeTable, controller: Controller, rows: _Rows) -> None:
        self.table, self.sheet, self.rows = table, table.sheet, rows
        self.words, self.ranges = GaugeWords.of(controller), ranges_of(controller)

    def read(self) -> None:
        """Read every row that holds a reading, and say what was left aside and assumed."""
        before = len(self.rows.taken)
        for row, columns in self.table.filled(self.table.rows, self.rows):
            self._row(row, columns)
        if len(self.rows.taken) == before:
            return
        self._unknown_columns()
        if "tap" not in self.table.columns and any(said.tap is None for said in self.table.values.values()):
            text = Sentence("the table names no tap: its readings are taken as main pressure, at the line's tap")
            self.rows.messages.append(Message("info", "tap_assumed", text, self.table.place(self.table.row)))

    def _row(self, row: int, columns: Sequence[int]) -> None:
        named = self._named(row)
        if named is None:
            return
        temperature = self._number(row, "temperature", TEMPERATURE, "temperature")
        if "temperature" not in self.table.columns:
            temperature = self._temperature_above
        speed = self._number(row, "engine_speed", ENGINE_SPEED, "rotational_speed")
        time, order = self._order(row, "time"), self._order(row, "repeat")
        order = time if order is None else order
        for column in columns:
            said = named.over(self.table.values[column])
            if said.range is None or said.range not in self.ranges or said.engine is None:
                place = self.table.place(self.table.row, column)
                heading = self.table.headings[column].text
                self.rows.refuse(_NOT_UNDERSTOOD["range"][1], place, heading, self.ranges, once=True)
                continue
            cell = GaugeCell(said.range, said.engine, said.tap or LINE_TAP)
            problem = Sentence("{cell}: not a pressure").of(cell=(cell.range, cell.engine.label))
            pressure = self.table.number(self.rows, row, column, _PRESSURE, "pressure", problem=problem)
            if pressure is None:
                continue
            self.rows.units[pressure.unit.name] = None
            reading = GaugeReading(
                cell,
                pressure.si,
                time=time,
                gauge=text_of(self.table.cell(row, "gauge")),
                temperature=temperature,
                engine_speed=speed if speed is not None else said.engine_speed,
                place=self.table.place(row, column),
            )
            counted = order if order is not None else (None if said.repeat is None else float(said.repeat))
            self.rows.taken.append((reading, counted))

    def _named(self, row: int) -> Said | None:
        """Return what the cells of a row say of its readings; None where one of them is not understood."""
        named, understood = Said(), True
        engines = tuple(str(engine.label) for engine in Engine)
        for kind, names in {"range": self.ranges, "engine": engines, "tap": self.words.tap_ids}.items():
            if kind not in self.table.columns:
                continue
            cell = self.table.cell(row, kind)
            said = self.words.said_by(cell, kind)
            if said is None or (said.range is not None and said.range not in self.ranges):
                problem, found = _NOT_UNDERSTOOD[kind][cell != ""], text_of(cell) or None
                self.rows.refuse(problem, self.table.place_of(row, kind), found, names)
                understood = False
            else:
                named = said.over(named)
        return named if understood else None

    def _number(self, row: int, kind: str, asked: AskedNumber, of: str) -> float | None:
        """Return the number of a row in SI, °C for a temperature; None where there is none or it is a problem."""
        if self.table.cell(row, kind) == "":
            return None
        number = self.table.number(self.rows, row, self.table.columns[kind], asked, of, unit(asked.unit, of))
        return None if number is None else number.si

    @cached_property
    def _temperature_above(self) -> float | None:
        """Return the temperature above the table [°C]; None where there is none or it is a problem."""
        if self.table.head.temperature is None:
            return None
        cell, place, said = self.table.head.temperature
        number = self.rows.number(cell, place, TEMPERATURE, "temperature", (said, place), unit("°C", "temperature"))
        return None if number is None else number.si

    def _order(self, row: int, kind: str) -> float | None:
        """Return a repeat, or a time [s]: a clock's, or a number of seconds unless its heading says minutes."""
        cell = self.table.cell(row, kind)
        if cell == "":
            return None
        clock = _CLOCK.fullmatch(str(cell).strip())
        if clock:
            return int(clock[1]) * 3600.0 + int(clock[2]) * 60.0 + int(clock[3] or 0)
        number = read_number(str(cell), AskedNumber(Sentence("repeat"), "", 2.0)).value
        if number is None:
            place, expected = self.table.place_of(row, kind), Sentence("1, 2, 3 … or a time")
            self.rows.refuse(Sentence("not a repeat"), place, str(cell), expected=expected)
        heading = self.table.heading(self.table.columns[kind]).lower()
        minutes = kind == "time" and re.search(r"\b(min|minut\w*)\b", heading)
        return number * 60.0 if number is not None and minutes else number

    def _unknown_columns(self) -> None:
        """Refuse a column of numbers whose heading says nothing known; name what is left aside."""
        aside = []
        for column in range(self.sheet.width):
            heading = self.table.headings.get(column)
            known = heading is not None and heading.kind not in (None, "aside")
            if known or not any(is_number(self.sheet.cell(row, column)) for row in self.table.rows):
                continue
            if heading is None or heading.kind == "aside":
                aside.append(column_letter(column) if heading is None else heading.text)
            else:
                labels = {*self.ranges, *(str(engine.label) for engine in Engine), *self.words.tap_ids}
                names = one_of(sorted(labels, key=len))
                expected = Sentence("{names}; or 'note' over what is no reading", names=names)
                place = self.table.place(self.table.row, column)
                self.rows.refuse(Sentence("no such column of a pressure table"), place, heading.text, expected=expected)
        if aside:
            shown = tuple(map(repr, aside[:_ASIDE_SHOWN]))
            text = Sentence("columns left aside, which hold no readings: {columns}", columns=shown)
            self.rows.messages.append(Message("info", "column_aside", text, self.table.place(self.table.row)))


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
    words = GaugeWords.of(controller)
    missing = PressureTableError(Sentence("holds no table of gauge readings"), expected=_HEADINGS)
    find = partial(find_gauge_tables, words=words)
    held = ValueFile.open(source, name, find, likeness_of(controller), missing, _WANTED)
    table = _read(held, controller)
    if table is None:
        first = held.tables[0]
        place = Place(held.file, first.sheet.name, first.sheet.row_number(first.row))
        expected = Sentence("at least one gauge reading")
        raise PressureTableError(Sentence("no pressure is filled in"), place=place, expected=expected)
    return table


def _read(held: ValueFile[GaugeTable], controller: Controller) -> PressureTable | None:
    """Return the gauge readings of all tables; None where none of them is filled in."""
    rows = _Rows()
    for table in held.tables:
        _Reader(table, controller, rows).read()
    rows.count_repeats()
    rows.settle()
    if not rows.readings:
        return None
    readings, messages = tuple(rows.readings), (*held.notes, *rows.messages)
    return PressureTable(held.file, held.sha256, held.sheet, tuple(rows.units), readings, messages)


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
        return _read(ValueFile(file, hashlib.sha256(data).hexdigest(), self.tables), self.controller)


def likeness_of(controller: Controller) -> Callable[[Sheet], float]:
    """Return how to count the headings of a sheet that are understood as those of gauge readings."""
    return partial(likeness, words=GaugeWords.of(controller))


def find_tabs(sheets: Sequence[Sheet], controller: Controller) -> PressureTabs:
    """Find the sheets that hold tables of gauge readings; hidden ones do not count."""
    words = GaugeWords.of(controller)
    shown = [sheet for sheet in sheets if not sheet.hidden]
    return PressureTabs([table for sheet in shown for table in find_gauge_tables(sheet, words)], controller)
