"""Say what a file that somebody hands over is to a job: diameters, gauge readings, a log, a valve body, a whole job.

Only its content counts, never its name, but for a TOML file with a fault. Nothing is read to the end here: whoever
reads the file says what is wrong with it.
"""

from __future__ import annotations

import io
import json
import re
import zipfile
from enum import StrEnum
from functools import cache
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.common.damage import DAMAGE, is_own_fault, own_errors_only
from atleak.common.errors import InputError, ReadingsError
from atleak.job.case import SLOTS, SourceFile
from atleak.measurements.job_card import Job
from atleak.measurements.own_forms import FLOWS, GAUGES, MEASUREMENTS, PRESSURES, TYPED, VACUUM
from atleak.readers.cells.sheet import Sheet
from atleak.readers.cells.sheet_file import read_sheets
from atleak.readers.controller_workbook import describes_controller
from atleak.readers.gauges import gauge_table
from atleak.readers.gauges.vacuum_table import vacuum_finder
from atleak.readers.gauges.value_table import flow_finder
from atleak.readers.logs.log_file import form_of
from atleak.readers.own_forms import own_form_of
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.layout import find_tables, looks_measured
from atleak.readers.sheets.words import is_word

_REFUSED: tuple[type[Exception], ...] = (ReadingsError, *DAMAGE)
_SHORT, _SURE = 400, 4  # rows of a sheet that may be of another valve body, and planes of that found in it
_START, _START_OF_LARGE, _LARGE = 60_000, 15_000, 1_000_000  # bytes of a text that are looked at; of one so large
_PICTURES = (b"\x89PNG\r\n", b"\xff\xd8\xff")
_TOML = re.compile(r"(\s*#.*\n|\s*\n)*\s*(\w+ *= *[\"'0-9\[]|\[\w+\])")
_TOP = re.compile(r"^\[*([a-z_]+)[\].]|^([a-z_]+)\s*=", re.MULTILINE)


class TableKind(StrEnum):
    """What a file of values may hold, by the name of the job's part that it becomes."""

    READINGS = "readings"
    ROAD_TEST = "road_test"
    PRESSURES = "pressures"
    VACUUM = "vacuum"
    FLOWS = "flows"
    CONTROLLER = "controller"


_OF_FORM = {
    **dict.fromkeys((MEASUREMENTS.mark, TYPED.mark), TableKind.READINGS),
    **dict.fromkeys((PRESSURES.mark, GAUGES.mark), TableKind.PRESSURES),
    VACUUM.mark: TableKind.VACUUM,
    FLOWS.mark: TableKind.FLOWS,
}


def table_kind(data: bytes, controller: Controller) -> TableKind:
    """Return what a workbook or a text holds.

    Returns
    -------
    Table
        a workbook in which nothing is understood counts as a measuring sheet, any other file as a log.
    """
    if form_of(data) not in ("text", "workbook"):
        return TableKind.ROAD_TEST
    is_workbook = form_of(data) == "workbook"
    if not is_workbook:
        start = _START if len(data) < _LARGE else _START_OF_LARGE
        data = data[:start].rpartition(b"\n")[0] if len(data) > start else data
    names, likeness = ControllerNames(controller), gauge_table.likeness_of(controller)
    of_rows = {TableKind.VACUUM: vacuum_finder(controller), TableKind.FLOWS: flow_finder(controller)}

    def diameters(sheet: Sheet) -> float:
        return max((table.score for table in find_tables(sheet, names) if table.complete), default=0.0)

    def score(sheet: Sheet) -> float:
        return max(diameters(sheet), likeness(sheet), *(finder.likeness(sheet) for finder in of_rows.values()))

    try:
        sheets = read_sheets(data, "", score, is_word, only_look=True)
    except _REFUSED as error:
        if is_own_fault(error):
            raise
        return TableKind.READINGS if is_workbook else TableKind.ROAD_TEST  # whoever reads it says what is wrong with it
    if describes_controller(sheets):
        return TableKind.CONTROLLER
    own = [_OF_FORM[form.mark] for form in map(own_form_of, sheets) if form is not None and form.mark in _OF_FORM]
    if own:
        return own[0]
    if any(map(diameters, sheets)):
        return TableKind.READINGS
    if gauge_table.find_tabs(sheets, controller).tables:
        return TableKind.PRESSURES
    for kind, finder in of_rows.items():
        if any(finder.rows_of(sheet) for sheet in sheets if finder.find(sheet)):
            return kind
    measured = any(looks_measured(sheet, names) for sheet in sheets)  # under headings that nobody knows
    short = [sheet for sheet in sheets if len(sheet.rows) <= _SHORT]
    measured = measured or any(looks_measured(sheet, other, _SURE) for sheet in short for other in _shipped_names())
    return TableKind.ROAD_TEST if not measured and any(sheet.rows for sheet in sheets) else TableKind.READINGS


@cache
def _shipped_names() -> tuple[ControllerNames, ...]:
    return tuple(ControllerNames(load_controller(name)) for name in shipped_files("controllers"))


class FileKind(StrEnum):
    """What a file is; those of a job's own parts have the parts' names."""

    JOB = "job"
    CONTROLLER_WORKBOOK = "controller_workbook"
    CONTROLLER = "controller"
    FLUID = "fluid"
    LIMITS = "limits"
    INSTRUMENT = "instrument"
    RECORD = "record"
    READINGS = "readings"
    ROAD_TEST = "road_test"
    PRESSURES = "pressures"
    VACUUM = "vacuum"
    FLOWS = "flows"
    PICTURE = "picture"


_FOLDERS = {
    FileKind.CONTROLLER: "controllers",
    FileKind.FLUID: "fluids",
    FileKind.LIMITS: "limits",
    FileKind.INSTRUMENT: "instruments",
}
_TABLES = {TableKind.CONTROLLER: FileKind.CONTROLLER_WORKBOOK}


@own_errors_only(InputError, "file")
def kind_of(file: SourceFile, controller: Controller) -> FileKind:
    """Return what a file is: a job file, a job record, a picture, readings, a log, or an entry of the catalogue.

    Parameters
    ----------
    file
        as it was handed over. Nothing of it is checked here.

    Raises
    ------
    InputError
        where atleak itself fails on it: a damaged file is what its beginning looks like.
    """
    content = file.content
    if content.startswith(_PICTURES) or (content[:4] == b"RIFF" and content[8:12] == b"WEBP"):
        return FileKind.PICTURE
    if content.startswith(b"PK") and _holds_job(content):
        return FileKind.JOB
    named = _written_kind(file)
    if named is not None:
        return named
    table = table_kind(content, controller)
    return _TABLES.get(table) or FileKind(table)


def slots_of(kind: FileKind, entry: object) -> tuple[str, ...]:
    """Return which choices of a job an entry of the catalogue can make: an instrument as many as it measures parts."""
    folder = _FOLDERS[kind]
    return tuple(
        slot.name
        for slot in SLOTS.values()
        if slot.folder == folder and (slot.part is None or slot.part in getattr(entry, "measures", ()))
    )


def _holds_job(content: bytes) -> bool:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as bundle:
            return "job.json" in bundle.namelist()
    except DAMAGE as error:
        if is_own_fault(error):
            raise
        return False


def _written_kind(file: SourceFile) -> FileKind | None:
    """Return what a file of named values is, by the names at its head; None where it is no such file."""
    text = file.content[:200_000].decode("utf-8-sig", "replace")
    if text.lstrip().startswith("{"):
        try:
            tables = set(json.loads(file.content))
        except (ValueError, RecursionError):  # no JSON, or none that ends
            tables = set()
    elif Path(file.name).suffix.lower() == ".toml" or _TOML.match(text):
        tables = {"".join(match) for match in _TOP.findall(text)}
    else:
        return None
    shared = {kind: len(tables & names) / len(names | tables) for kind, names in _names().items()}
    best = max(shared, key=shared.__getitem__)
    return best if shared[best] else None


@cache
def _names() -> dict[FileKind, frozenset[str]]:
    """Return the names at the head of the files of each kind: of a job record, and of every shipped entry."""
    of_entries = {
        kind: frozenset(
            "".join(match)
            for path in shipped_files(folder).values()
            for match in _TOP.findall(path.read_text(encoding="utf-8"))
        )
        for kind, folder in _FOLDERS.items()
    }
    return {FileKind.RECORD: frozenset(Job.model_fields), **of_entries}
