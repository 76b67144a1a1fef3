"""One row of a table of units, read cell by cell: files, numbers, dates and what is written down of the job."""

from __future__ import annotations

import datetime as dt
import os
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from atleak.errors import AtleakError, InputError, Place, one_of
from atleak.faults import validated
from atleak.fleet.units import travelling
from atleak.intake.dates import Order, day_number, likely_order, sure_date
from atleak.intake.readings.head_identity import written_mileage
from atleak.intake.readings.words import says_no, says_yes
from atleak.intake.sheets.sheet import Cell
from atleak.intake.unit_table import TableRow, UnitTable
from atleak.job.case import SourceFile, pairs_of
from atleak.job.file import load_job
from atleak.job.record import Job
from atleak.sentence import Sentence
from atleak.written_numbers import (
    MEASURING_TEMPERATURE,
    MILEAGE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    AskedNumber,
    WrittenNumber,
    read_number,
    written,
)

DATES = ("date", "measured_on")
_PATH = Sentence("the path of a file, from the folder of the table on")
_PAIRS = Sentence("NAME=VALUE, several with semicolons between")
_TEXTS = {  # column → where the record has it
    "number": ("number",),
    "technician": ("technician",),
    "customer": ("customer", "name"),
    "plate": ("vehicle", "registration"),
    "vin": ("vehicle", "vin"),
    "serial": ("transmission", "serial"),
}
_NUMBERS = {  # likewise
    "mileage": (MILEAGE, ("vehicle", "mileage_km")),
    "measuring_temperature": (MEASURING_TEMPERATURE, ("measuring_temperature_c",)),
    "pump_side_clearance": (PUMP_SIDE_CLEARANCE, ("pump_side_clearance_um",)),
    "pump_tip_clearance": (PUMP_TIP_CLEARANCE, ("pump_tip_clearance_um",)),
}


class RowCells:
    """A row that is read cell by cell; what is wrong with a cell is kept, and the next one is read."""

    def __init__(self, table: UnitTable, row: TableRow, folder: Path) -> None:
        self._table, self._row, self._folder = table, row, folder
        self.faults: list[InputError] = []

    def cell(self, meaning: str) -> Cell:
        """Return what stands in the column of that meaning; "" where nothing does."""
        return self._table.cell(self._row, meaning)

    def place(self, meaning: str | None = None) -> Place:
        """Return where the row, or one of its cells, stands."""
        return self._table.place(self._row, meaning)

    def _fault(self, meaning: str, problem: Sentence, expected: Sentence | None = None) -> None:
        value = text_of(self.cell(meaning))
        self.faults.append(InputError(problem, place=self.place(meaning), value=value, expected=expected))

    def refuse_more_cells_than_headings(self) -> None:
        """Refuse a row of text that a comma in one of its cells has shifted.

        Raises
        ------
        InputError
            naming the first cell without a heading.
        """
        width = max((place + 1 for place, column in enumerate(self._table.columns) if column.heading), default=0)
        more = [text for cell in self._row.cells[width:] if (text := text_of(cell))]
        if more and self._table.sheet is None:
            expected = Sentence("as many cells as headings, quotes around a text with the sign between columns")
            raise InputError(
                Sentence("the row has more cells than there are headings"),
                place=self.place(),
                value=more[0],
                expected=expected,
            )

    def text(self, meaning: str) -> str | None:
        """Return a text; None where there is none."""
        return text_of(self.cell(meaning)) or None

    def one_of(self, meaning: str, known: Iterable[str]) -> str | None:
        """Return a word of a list, whatever its case."""
        said, names = self.text(meaning), list(known)
        if said is None or said.lower() in names:
            return None if said is None else said.lower()
        self._fault(meaning, Sentence("not one of those that there are"), one_of(names))
        return None

    def number(self, meaning: str, asked: AskedNumber) -> float | None:
        """Return a number in the unit in which people are asked for it."""
        cell = self.cell(meaning)
        if not (said := text_of(cell)):
            return None
        if isinstance(cell, int | float) and not isinstance(cell, bool):
            said = written(float(cell), asked)  # a number as it is stored, which can be read in one way
        heading = self.place(meaning).column or ""
        read: WrittenNumber = written_mileage(said, heading) if asked is MILEAGE else read_number(said, asked)
        if read.value is None:
            self._fault(meaning, read.reason)
        return read.value

    def whole(self, meaning: str, asked: AskedNumber) -> int | None:
        """Return a whole number."""
        value = self.number(meaning, asked)
        if value is None or value == int(value):
            return None if value is None else int(value)
        self._fault(meaning, Sentence("a whole number is asked for"))
        return None

    def yes(self, meaning: str) -> bool | None:
        """Return whether a cell says yes; None where it says nothing."""
        said = self.text(meaning)
        if said is None or says_yes(said):
            return None if said is None else True
        if not says_no(said):
            self._fault(meaning, Sentence("says neither yes nor no"))
        return False

    def pairs(self, meaning: str) -> tuple[tuple[str, str], ...]:
        """Return what is written as ``NAME=VALUE``, several with semicolons between."""
        parts = [part.partition("=") for part in re.split(r"[;\n]", self.text(meaning) or "") if part.strip()]
        if any(not name.strip() or not sign for name, sign, _ in parts):
            self._fault(meaning, Sentence("no such pairs"), _PAIRS)
            return ()
        return pairs_of({name.strip(): value.strip() for name, _, value in parts})

    def date(self, meaning: str, order: Order | None) -> dt.date | None:
        """Return a date; of one that can be read in two ways the order tells which."""
        cell = self.cell(meaning)
        if isinstance(cell, dt.datetime):
            return cell.date()
        if isinstance(cell, dt.date) or not (said := text_of(cell)):
            return cell or None
        date = sure_date([said])
        if date is None and order is not None and (day := day_number(said, order)) is not None:
            return dt.date.fromordinal(day)
        if date is None:
            self._fault(meaning, Sentence("no date that can be read in one way"), Sentence("a date such as 2026-04-17"))
        return date

    def file(self, meaning: str) -> SourceFile | None:
        """Return a file as it goes along with the unit."""
        path = self._path(meaning)
        try:
            return None if path is None else travelling(path)
        except InputError as error:
            self.faults.append(placed(error, self.place(meaning)))
            return None

    def _path(self, meaning: str) -> Path | None:
        said = self.text(meaning)
        if said is None:
            return None
        found = file_at(self._folder, said)
        if found is None:
            is_folder = _is(Path.is_dir, self._folder / said)
            self._fault(meaning, Sentence("is a folder") if is_folder else Sentence("no such file"), _PATH)
        return found

    def job(self, orders: Mapping[str, Order | None]) -> Job:
        """Return what the row says of the job, and of the rest what its record says.

        Raises
        ------
        InputError
            a record that cannot be used.
        """
        record = self._path("record")
        data = {} if record is None else load_job(record).record()
        for meaning, steps in _TEXTS.items():
            _put(data, steps, self.text(meaning))
        for meaning, (asked, steps) in _NUMBERS.items():
            _put(data, steps, self.number(meaning, asked))
        for meaning in DATES:
            _put(data, (meaning,), self.date(meaning, orders[meaning]))
        return validated(Job, data, str(self.place()))


def _put(data: dict[str, Any], steps: tuple[str, ...], value: Any) -> None:
    """Put a value into the tables of a record; nothing where there is none."""
    if value is None:
        return
    for step in steps[:-1]:
        data = data.setdefault(step, {})
    data[steps[-1]] = value


def placed(error: AtleakError, place: Place) -> InputError:
    """Return an error with the place of its row in front; the file's own place stays in it."""
    if not isinstance(error, InputError):
        return InputError(error.sentence, place=place)
    if error.place == Place():
        return InputError(error.problem, place=place, value=error.value, expected=error.expected, nearest=error.nearest)
    return error if error.place.file == place.file else InputError(error.sentence, place=place)


def text_of(cell: Cell) -> str:
    """Return a cell as people read it: 3.0 is "3", a day has no time."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    if isinstance(cell, dt.datetime) and cell.time() == dt.time():
        return cell.date().isoformat()
    return cell.isoformat(" ") if isinstance(cell, dt.datetime) else str(cell).strip()


def file_at(folder: Path, said: str) -> Path | None:
    """Return the file that a path leads to; one that was written on Windows is understood elsewhere too."""
    bare = said.strip("\"'")
    spellings = [bare] if os.name == "nt" else [bare, bare.replace("\\", "/")]
    return next((path for each in spellings if _is(Path.is_file, path := folder / each)), None)


def _is(kind: Callable[[Path], bool], path: Path) -> bool:
    """Tell whether there is a file, or a folder; a path that cannot be one leads to none."""
    try:
        return kind(path)
    except (OSError, ValueError):  # too long, or with a NUL in it
        return False


def day_order(texts: Iterable[str]) -> Order | None:
    """Return the order of day and month in a column of dates, where a date over the 12th tells it; None else."""
    dates = [text for text in dict.fromkeys(texts) if text]
    orders = {likely_order([text], [None]) for text in dates if sure_date([text]) is not None and "/" in text}
    return orders.pop() if len(orders) == 1 else None
