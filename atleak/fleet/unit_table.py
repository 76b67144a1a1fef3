"""Read a table of units, row by row: each with its files, its choices and what is written down of its job."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

from atleak.catalogue.entries import NO_ENTRY, catalogue_files, own_files, shipped_files
from atleak.catalogue.fluid import FluidState
from atleak.catalogue.written_numbers import (
    ENGINE_SPEED,
    MEASURING_TEMPERATURE,
    MILEAGE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    TEMPERATURE,
    AskedNumber,
    WrittenNumber,
    read_number,
    written,
)
from atleak.common.errors import AtleakError, InputError, Message, Place, one_of, unknown
from atleak.common.file_faults import faults_together, validated
from atleak.common.sentences import Sentence
from atleak.fleet.units import TABLE, FleetUnit, travelling
from atleak.job.case import (
    OWN_FILES,
    SLOTS,
    Case,
    CaseChoice,
    Reader,
    SourceFile,
    named_columns,
    pairs_of,
    with_log_choices,
    with_record,
)
from atleak.job.zip_file import load_job
from atleak.measurements.job_card import Job
from atleak.readers.cells.sheet import Cell
from atleak.readers.dates import DateOrder, day_number, likely_order, sure_date
from atleak.readers.logs import default_path, head_of_parquet, understand
from atleak.readers.sheets.head import written_mileage
from atleak.readers.sheets.words import says
from atleak.readers.unit_table import MEASURED, TableColumn, TableRow, UnitTable, nearest_heading, read_unit_table

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
        value = _text_of(self.cell(meaning))
        self.faults.append(InputError(problem, place=self.place(meaning), value=value, expected=expected))

    def refuse_more_cells_than_headings(self) -> None:
        """Refuse a row of text that a comma in one of its cells has shifted.

        Raises
        ------
        InputError
            naming the first cell without a heading.
        """
        width = max((place + 1 for place, column in enumerate(self._table.columns) if column.heading), default=0)
        more = [text for cell in self._row.cells[width:] if (text := _text_of(cell))]
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
        return _text_of(self.cell(meaning)) or None

    def one_of(self, meaning: str, known: Iterable[str]) -> str | None:
        """Return a word of a list, whatever its case."""
        text, names = self.text(meaning), list(known)
        if text is None or text.lower() in names:
            return None if text is None else text.lower()
        self._fault(meaning, Sentence("not one of those that there are"), one_of(names))
        return None

    def number(self, meaning: str, asked: AskedNumber) -> float | None:
        """Return a number in the unit in which people are asked for it."""
        cell = self.cell(meaning)
        if not (text := _text_of(cell)):
            return None
        if isinstance(cell, int | float) and not isinstance(cell, bool):
            text = written(float(cell), asked)  # a number as it is stored, which can be read in one way
        heading = self.place(meaning).column or ""
        read: WrittenNumber = written_mileage(text, heading) if asked is MILEAGE else read_number(text, asked)
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
        text = self.text(meaning)
        if text is None or says(text, "yes", "counts_not"):
            return None if text is None else True
        if not says(text, "no", "counts_not"):
            self._fault(meaning, Sentence("says neither yes nor no"))
        return False

    def pairs(self, meaning: str) -> tuple[tuple[str, str], ...]:
        """Return what is written as ``NAME=VALUE``, several with semicolons between."""
        parts = [part.partition("=") for part in re.split(r"[;\n]", self.text(meaning) or "") if part.strip()]
        if any(not name.strip() or not sign for name, sign, _ in parts):
            self._fault(meaning, Sentence("no such pairs"), _PAIRS)
            return ()
        return pairs_of({name.strip(): value.strip() for name, _, value in parts})

    def date(self, meaning: str, order: DateOrder | None) -> dt.date | None:
        """Return a date; of one that can be read in two ways the order tells which."""
        cell = self.cell(meaning)
        if isinstance(cell, dt.datetime):
            return cell.date()
        if isinstance(cell, dt.date) or not (text := _text_of(cell)):
            return cell or None
        date = sure_date([text])
        if date is None and order is not None and (day := day_number(text, order)) is not None:
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
        text = self.text(meaning)
        if text is None:
            return None
        found = file_at(self._folder, text)
        if found is None:
            is_folder = _is(Path.is_dir, self._folder / text)
            self._fault(meaning, Sentence("is a folder") if is_folder else Sentence("no such file"), _PATH)
        return found

    def job(self, orders: Mapping[str, DateOrder | None]) -> Job:
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


def _text_of(cell: Cell) -> str:
    """Return a cell as people read it: 3.0 is "3", a day has no time."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    if isinstance(cell, dt.datetime) and cell.time() == dt.time():
        return cell.date().isoformat()
    return cell.isoformat(" ") if isinstance(cell, dt.datetime) else str(cell).strip()


def file_at(folder: Path, text: str) -> Path | None:
    """Return the file that a path leads to; one that was written on Windows is understood elsewhere too."""
    bare = text.strip("\"'")
    spellings = [bare] if os.name == "nt" else [bare, bare.replace("\\", "/")]
    return next((path for each in spellings if _is(Path.is_file, path := folder / each)), None)


def _is(kind: Callable[[Path], bool], path: Path) -> bool:
    """Tell whether there is a file, or a folder; a path that cannot be one leads to none."""
    try:
        return kind(path)
    except (OSError, ValueError):  # too long, or with a NUL in it
        return False


def day_order(texts: Iterable[str]) -> DateOrder | None:
    """Return the order of day and month in a column of dates, where a date over the 12th tells it; None else."""
    dates = [text for text in dict.fromkeys(texts) if text]
    orders = {likely_order([text], [None]) for text in dates if sure_date([text]) is not None and "/" in text}
    return orders.pop() if len(orders) == 1 else None


_IDENTIFIED_BY = (*MEASURED, "where", "number")  # a row stays the same unit while these stay
_NO_LABELS = ("job_file", "group", "customer", "plate", "technician")  # what leads to a person is kept nowhere
_KEY = 16  # hexadecimal digits
_START = 64 << 10  # bytes of a log in which its header stands
_LOOKED_AT = 20  # rows by which it is seen what a column holds
_GEAR = AskedNumber(Sentence("gear"), "", 3.0, (-9.0, 20.0))
_MEASURED = Sentence("a measuring sheet, a log, gauge readings, a vacuum test, flows or a job file")


class TableUnits:
    """The units of a table, in the order of its rows; each is made when its turn comes, and then its files are read.

    Parameters
    ----------
    path
        of the table; the paths in it start at its folder.
    defaults
        the choices for rows that name none.

    Raises
    ------
    InputError
        as `read_unit_table`.
    """

    def __init__(self, path: Path, defaults: Case) -> None:
        self.path, self.table = path.absolute(), read_unit_table(path)
        self._written = written_choices(defaults)
        chosen: dict[str, Any] = {name: travelling_choice(name, getattr(defaults, name), Path.cwd()) for name in SLOTS}
        self._defaults = replace(defaults, remember=False, **chosen)
        self._chosen: dict[tuple[str, str], CaseChoice | None] = {}
        remembered = default_path()
        self._remembered = remembered if remembered.exists() else None

    def __len__(self) -> int:
        return len(self.table.rows)

    def __iter__(self) -> Iterator[FleetUnit]:
        for row, key in zip(self.table.rows, self._keys, strict=True):
            yield self._unit(row, key)

    def find(self, key: str) -> FleetUnit | None:
        """Return the unit whose reference ends with a key; None where no row is that unit any more."""
        rows = zip(self.table.rows, self._keys, strict=True)
        return next((self._unit(row, own) for row, own in rows if own == key), None)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the headings of all columns that are kept as labels, be it of rows alone that name a job file."""
        table = self.table
        if not any(_text_of(table.cell(row, "job_file")) for row in table.rows):
            return table.labels
        return tuple(column.heading for column in table.columns if _is_label(column, every=True))

    def doubts(self) -> Iterator[Message]:
        """Yield what speaks against a column being one of the table's own, though nothing is known by its heading."""
        entries = {entry for slot in SLOTS.values() for entry in catalogue_files(slot.folder)}
        for at, column in enumerate(self.table.columns):
            if column.meaning is not None or not column.heading:
                continue
            cells = [_text_of(row.cells[at]) for row in self.table.rows[:_LOOKED_AT] if at < len(row.cells)]
            said = next((cell for cell in cells if cell in entries or (cell and file_at(self.path.parent, cell))), None)
            nearest = nearest_heading(column.heading)
            if said is None and nearest is None:
                continue
            place = Place(self.table.file, self.table.sheet, column=column.heading)
            if said is None:
                text = Sentence("is a mere label of its units; did you mean '{nearest}'?", nearest=nearest)
            elif nearest is not None:
                text = Sentence(
                    "is a mere label of its units, though it says '{value}'; did you mean '{nearest}'?",
                    value=said,
                    nearest=nearest,
                )
            else:
                text = Sentence("is a mere label of its units, though it says '{value}'", value=said)
            yield Message("warning", "doubtful_label", text, place)

    @cached_property
    def _keys(self) -> list[str]:
        """Return by what each row is known when the table was sorted or has further rows: its files, not its place."""
        seen: Counter[str] = Counter()
        keys = []
        for row in self.table.rows:
            identity = [_text_of(self.table.cell(row, meaning)) for meaning in _IDENTIFIED_BY]
            digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:_KEY]
            seen[digest] += 1
            keys.append(digest if seen[digest] == 1 else f"{digest}-{seen[digest]}")
        return keys

    @cached_property
    def _orders(self) -> Mapping[str, DateOrder | None]:
        """Return, for every column of dates, whether day or month stands first where other rows tell it."""
        return {name: day_order(_text_of(self.table.cell(row, name)) for row in self.table.rows) for name in DATES}

    def _unit(self, row: TableRow, key: str) -> FleetUnit:
        table = self.table
        of_job_file = bool(_text_of(table.cell(row, "job_file")))
        unit = FleetUnit(
            name=str(table.place(row)),
            reference=f"{TABLE}{self.path}#{key}",
            group=_text_of(table.cell(row, "group")) or None,
            labels=tuple(_labels(table, row, every=of_job_file)),
            choices=self._written,
        )
        read = RowCells(table, row, self.path.parent)
        try:
            read.refuse_more_cells_than_headings()
            if of_job_file:
                unit = replace(unit, job_file=read.file("job_file"))
            else:
                job = read.job(self._orders)
                unit = replace(unit, case=self._case(read, job), job=job)
        except AtleakError as error:
            read.faults.append(placed(error, table.place(row)))
        if read.faults:
            return replace(unit, case=None, job=None, job_file=None, fault=faults_together(read.faults))
        return unit

    def _case(self, read: RowCells, job: Job) -> Case:
        changes: dict[str, Any] = {name: read.file(name) for name in OWN_FILES}
        if not any(_text_of(read.cell(name)) for name in changes):
            raise InputError(Sentence("the row names nothing to diagnose"), place=read.place(), expected=_MEASURED)
        changes |= {name: self._choice(read, name) for name in SLOTS}
        changes |= {
            "fluid_state": read.one_of("fluid_state", get_args(FluidState)),
            "temperature": read.number("temperature", TEMPERATURE),
            "gear": read.whole("gear", _GEAR),
            "complaint": read.text("complaint"),
            "repairs": tuple(each.strip() for each in re.split(r"[;,\n]", read.text("repair") or "") if each.strip()),
            "sheet_name": read.text("sheet_name"),
            "sheet_where": read.pairs("where"),
            "sheet_fill_down": read.yes("fill_down"),
            **named_columns(read.pairs("map"), read.pairs("unit"), read.text("sheet_unit")),
        }
        speed = read.number("rpm", ENGINE_SPEED)
        changes["engine_speed"] = None if speed is None else speed / 60.0
        case = replace(self._defaults, **{name: value for name, value in changes.items() if value not in (None, ())})
        case = _recorded(case, job)
        if case.fluid is None and isinstance(case.controller, SourceFile):  # it may name a fluid of the user's own
            key = "fluid of", case.controller.sha256
            if key not in self._chosen:
                usual = Reader().entry(SLOTS["controller"], case.controller).usual_fluid
                self._chosen[key] = travelling_choice("fluid", usual, self.path.parent)
            case = replace(case, fluid=self._chosen[key])
        return case if self._remembered is None else _with_remembered(case, self._remembered)

    def _choice(self, read: RowCells, slot: str) -> CaseChoice | None:
        chosen = read.text(slot)
        if chosen is None:
            return None
        if (slot, chosen) not in self._chosen:
            try:
                self._chosen[slot, chosen] = travelling_choice(slot, chosen, self.path.parent)
            except InputError as error:
                read.faults.append(placed(error, read.place(slot)))
                return None
        return self._chosen[slot, chosen]


def travelling_choice(slot: str, chosen: CaseChoice | None, folder: Path) -> CaseChoice | None:
    """Return a choice from the catalogue as it goes along with a unit: the id of a shipped entry, or a file's bytes.

    Parameters
    ----------
    chosen
        an id, or the path of a file; None stays so.
    folder
        from which that path leads.

    Raises
    ------
    InputError
        neither an id of the catalogue nor a file.
    """
    kind = SLOTS[slot].folder
    if chosen is None or isinstance(chosen, SourceFile) or chosen in shipped_files(kind):
        return chosen
    own = own_files(kind).get(chosen)
    path = file_at(folder, chosen) if own is None else own
    if path is not None:
        return travelling(path)
    raise unknown(NO_ENTRY[kind], chosen, catalogue_files(kind), otherwise=Sentence("the path of a TOML file"))


def written_choices(case: Case) -> str:
    """Return the choices of a run as text: those that differ from the defaults, a path in full."""
    chosen = {name: value for name, value in vars(case).items() if value != vars(_DEFAULTS)[name]}
    for name in SLOTS:
        choice = chosen.get(name)
        path = choice.path if isinstance(choice, SourceFile) else file_at(Path.cwd(), choice) if choice else None
        if path is not None:
            chosen[name] = str(path.absolute())
    return json.dumps(chosen, ensure_ascii=False) if chosen else ""


def choices_read(text: str) -> Case:
    """Return the choices that `written_choices` wrote."""
    return Case(**{name: _tuples(value) for name, value in json.loads(text or "{}").items()})


_DEFAULTS = Case()


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _recorded(case: Case, job: Job) -> Case:
    """Return a case with what the row's record says of the measuring, which counts before the choice for all rows."""
    recorded = with_record(replace(case, measuring_temperature=None), job)
    return recorded if recorded.measuring_temperature is not None else with_record(case, job)


def _labels(table: UnitTable, row: TableRow, *, every: bool) -> Iterator[tuple[str, str]]:
    """Yield what stands in the table's own columns; beside a job file also what its record would have said."""
    for column, cell in zip(table.columns, row.cells, strict=False):
        if _is_label(column, every=every) and (text := _text_of(cell)):
            yield column.heading, text


def _is_label(column: TableColumn, *, every: bool) -> bool:
    return bool(column.heading) and (column.meaning is None or (every and column.meaning not in _NO_LABELS))


def _with_remembered(case: Case, remembered: Path) -> Case:
    """Return the case with its log's columns as they were settled on this computer: elsewhere it then reads the same.

    The head of a log of text or of Parquet is enough for that; nothing is remembered of MDF files.
    """
    log = case.road_test
    if log is None:
        return case
    try:
        understood = understand(_head_of(log), name=log.name, remembered=remembered, **case.log_choices)
    except AtleakError:  # whoever reads the whole log says what is wrong with it
        return case
    return with_log_choices(replace(case, remember=True), understood)


def _head_of(log: SourceFile) -> bytes | Path:
    """Return the lines of a log in which its header stands; all of a workbook.

    Raises
    ------
    RoadTestError
        a damaged Parquet file.
    """
    if log.path is None:
        start = log.content[:_START]
    else:
        with log.path.open("rb") as stream:
            start = stream.read(_START)
    if start.startswith((b"PK", b"\xd0\xcf\x11\xe0")):
        return log.given
    if start.startswith(b"PAR1"):
        return head_of_parquet(log.given, log.name)
    return start if len(start) < _START else start.rpartition(b"\n")[0]
