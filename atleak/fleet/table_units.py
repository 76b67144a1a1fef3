"""The rows of a table as units of a fleet: each with its files, its choices and what is written down of it."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

from atleak.catalogue.entries import NO_ENTRY, catalogue_files, own_files, shipped_files
from atleak.catalogue.fluid import FluidState
from atleak.errors import AtleakError, InputError, Message, Place, unknown
from atleak.faults import together
from atleak.fleet.table_cells import DATES, RowCells, day_order, file_at, placed, text_of
from atleak.fleet.units import TABLE, FleetUnit, travelling
from atleak.intake.dates import Order
from atleak.intake.road_test import default_path, head_of_parquet, understand
from atleak.intake.unit_table import MEASURED, TableColumn, TableRow, UnitTable, nearest_heading, read_unit_table
from atleak.job.case import SLOTS, Case, Choice, SourceFile, with_log_choices, with_record
from atleak.job.record import Job
from atleak.sentence import Sentence
from atleak.written_numbers import (
    ENGINE_SPEED,
    TEMPERATURE,
    AskedNumber,
)

_IDENTIFIED_BY = (*MEASURED, "where", "number")  # a row stays the same unit while these stay
_NO_LABELS = ("job_file", "group", "customer", "plate", "technician")  # what leads to a person is kept nowhere
_KEY = 16  # hexadecimal digits
_START = 64 << 10  # bytes of a log in which its header stands
_LOOKED_AT = 20  # rows by which it is seen what a column holds
_GEAR = AskedNumber(Sentence("gear"), "", 3.0, (-9.0, 20.0))
_MEASURED = Sentence("a measuring sheet, a log, gauge readings or a job file")


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
        self._chosen: dict[tuple[str, str], Choice] = {}
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
        if not any(text_of(table.cell(row, "job_file")) for row in table.rows):
            return table.labels
        return tuple(column.heading for column in table.columns if _is_label(column, every=True))

    def doubts(self) -> Iterator[Message]:
        """Yield what speaks against a column being one of the table's own, though nothing is known by its heading."""
        entries = {entry for slot in SLOTS.values() for entry in catalogue_files(slot.folder)}
        for at, column in enumerate(self.table.columns):
            if column.meaning is not None or not column.heading:
                continue
            cells = [text_of(row.cells[at]) for row in self.table.rows[:_LOOKED_AT] if at < len(row.cells)]
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
            told = [text_of(self.table.cell(row, meaning)) for meaning in _IDENTIFIED_BY]
            digest = hashlib.sha256(json.dumps(told).encode()).hexdigest()[:_KEY]
            seen[digest] += 1
            keys.append(digest if seen[digest] == 1 else f"{digest}-{seen[digest]}")
        return keys

    @cached_property
    def _orders(self) -> Mapping[str, Order | None]:
        """Return, for every column of dates, whether day or month stands first where other rows tell it."""
        return {name: day_order(text_of(self.table.cell(row, name)) for row in self.table.rows) for name in DATES}

    def _unit(self, row: TableRow, key: str) -> FleetUnit:
        table = self.table
        of_job_file = bool(text_of(table.cell(row, "job_file")))
        unit = FleetUnit(
            name=str(table.place(row)),
            reference=f"{TABLE}{self.path}#{key}",
            group=text_of(table.cell(row, "group")) or None,
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
            return replace(unit, case=None, job=None, job_file=None, fault=together(read.faults))
        return unit

    def _case(self, read: RowCells, job: Job) -> Case:
        changes: dict[str, Any] = {name: read.file(name) for name in ("readings", "road_test", "pressures")}
        if not any(text_of(read.cell(name)) for name in changes):
            raise InputError(Sentence("the row names nothing to diagnose"), place=read.place(), expected=_MEASURED)
        changes |= {name: self._choice(read, name) for name in SLOTS}
        changes |= {
            "fluid_state": read.one_of("fluid_state", get_args(FluidState)),
            "temperature": read.number("temperature", TEMPERATURE),
            "gear": read.whole("gear", _GEAR),
            "complaint": read.text("complaint"),
            "repairs": tuple(each.strip() for each in re.split(r"[;,\n]", read.text("repair") or "") if each.strip()),
            "sheet_name": read.text("sheet_name"),
            "sheet_unit": read.text("sheet_unit"),
            "sheet_where": read.pairs("where"),
            "sheet_fill_down": read.yes("fill_down"),
            "columns": read.pairs("map"),
            "units": read.pairs("unit"),
        }
        speed = read.number("rpm", ENGINE_SPEED)
        changes["engine_speed"] = None if speed is None else speed / 60.0
        case = replace(self._defaults, **{name: value for name, value in changes.items() if value not in (None, ())})
        case = _recorded(case, job)
        return case if self._remembered is None else _with_remembered(case, self._remembered)

    def _choice(self, read: RowCells, slot: str) -> Choice | None:
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


def travelling_choice(slot: str, chosen: Choice, folder: Path) -> Choice:
    """Return a choice from the catalogue as it goes along with a unit: the id of a shipped entry, or a file's bytes.

    Parameters
    ----------
    slot
        name of the choice in `Case`.
    chosen
        an id, or the path of a file.
    folder
        from which that path leads.

    Raises
    ------
    InputError
        neither an id of the catalogue nor a file.
    """
    kind = SLOTS[slot].folder
    if isinstance(chosen, SourceFile) or chosen in shipped_files(kind):
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
        if _is_label(column, every=every) and (text := text_of(cell)):
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
