"""Say what a file that somebody hands over is to a job. Only its content counts, but for a TOML file with a fault."""

from __future__ import annotations

import io
import json
import re
import zipfile
from enum import StrEnum
from functools import cache
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import shipped_files
from atleak.common.damage import DAMAGE, is_own_fault, own_errors_only
from atleak.common.errors import InputError
from atleak.job.case import SLOTS, SourceFile
from atleak.measurements.job_card import Job
from atleak.readers.file_kinds import TableKind, table_kind

_PICTURES = (b"\x89PNG\r\n", b"\xff\xd8\xff")
_TOML = re.compile(r"(\s*#.*\n|\s*\n)*\s*(\w+ *= *[\"'0-9\[]|\[\w+\])")
_TOP = re.compile(r"^\[*([a-z_]+)[\].]|^([a-z_]+)\s*=", re.MULTILINE)


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
    controller
        of the job: a measuring sheet may use the names of its components.

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
