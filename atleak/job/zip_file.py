"""Read the job record from a TOML or JSON file, and write a whole job as a zip that gives the same verdict again."""

from __future__ import annotations

import io
import json
import tomllib
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from atleak.common.damage import DAMAGE, own_errors_only, own_line
from atleak.common.errors import AtleakError, InputError, Place, reason_of, text_reason
from atleak.common.file_faults import validated
from atleak.common.seals import PACKINGS, RECORD_LIMIT
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import OWN_FILES, SLOTS, Case
from atleak.job.parts import JobFile, OfBook, entry_of, job_parts, json_of
from atleak.job.photos import without_notes
from atleak.measurements.job_card import Job, picture_name

SIZE_LIMIT = 1 << 30  # bytes of all files of a job, unpacked
_PICTURE_LIMIT = 40 << 20
_OF_BOOK = "book.json"
_LIMITS = {  # bytes of a file of the job's own, unpacked, where it is no table; a workbook of readings may hold photos
    "job.json": RECORD_LIMIT,
    "result.json": RECORD_LIMIT,
    _OF_BOOK: RECORD_LIMIT,
    "road_test": 800 << 20,
}
_TABLE_LIMIT, _CATALOGUE_LIMIT = 200 << 20, 4 << 20
# A log packs to a tenth or fiftieth of its size, a megabyte of one sign to a thousandth.
_SPARE, _TIGHTEST = 32 << 20, 200  # bytes that any file may unpack to, and how many times its packed size at most
_LARGE = 16 << 20  # bytes of a log from which on it is unpacked to the disk where there is a folder for it
_STEP = 1 << 20  # bytes that are unpacked at once
_ENTRIES = 1000
_STAMP = (1980, 1, 1, 0, 0, 0)  # date of every file in the zip, fixed so that the same job gives the same bytes


# --- the record alone


@own_errors_only(InputError, "path")
def load_job(path: str | Path) -> Job:
    """Read a job record.

    Parameters
    ----------
    path
        of a ``.toml`` or ``.json`` file; pictures lie beside it.

    Raises
    ------
    InputError
        naming file, table and key: what cannot be read, an unknown key, a value of the wrong kind, a picture that is
        missing.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        expected = Sentence("a job record in TOML or JSON")
        raise InputError(problem, place=Place(file=str(path)), expected=expected) from error
    if len(content) > RECORD_LIMIT:
        raise InputError(Sentence("too large for a job record"), place=Place(file=path.name))
    job = parse_job(content, path.name)
    return job.with_pictures({name: _picture_beside(path, name) for name in job.picture_names})


@own_errors_only(InputError, "name")
def parse_job(content: bytes, name: str) -> Job:
    """Read a job record from the bytes of a TOML or JSON file, without its pictures.

    Raises
    ------
    InputError
        as `load_job`.
    """
    try:
        text = content.decode("utf-8-sig")
        data = json.loads(text) if Path(name).suffix.lower() == ".json" else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        problem = Sentence("is not valid: {reason}", reason=text_reason(error))
        expected = Sentence("a job record in TOML or JSON, UTF-8")
        raise InputError(problem, place=Place(file=name), expected=expected) from error
    return validated(Job, data, name)


def _picture_beside(record: Path, name: str) -> bytes:
    folder = record.resolve().parent
    path = (folder / name).resolve()
    place = Place(file=record.name, key=name)
    if not path.is_relative_to(folder):
        raise InputError(Sentence("picture outside the job's folder"), place=place)
    try:
        if path.stat().st_size > _PICTURE_LIMIT:
            expected = Sentence("at most {size} MB", size=_PICTURE_LIMIT >> 20)
            raise InputError(Sentence("picture too large"), place=place, expected=expected)
        return path.read_bytes()
    except OSError as error:
        problem = Sentence("picture cannot be read: {reason}", reason=reason_of(error))
        raise InputError(problem, place=place, expected=Sentence("a file beside the job record")) from error


# --- the job with all its files


def write_job_file(diagnosis: Diagnosis, job: Job | None = None, case: Case | None = None) -> bytes:
    """Return the bytes of the zip: job record, measuring sheet, log, gauges, pictures, catalogue files, result.

    Parameters
    ----------
    case
        the files and choices that the result follows from; none for a unit that nobody measured or drove.

    Raises
    ------
    InputError
        files that are missing, or not those that the diagnosis rests on.
    """
    parts = job_parts(diagnosis, job, case)
    choices = parts.choices.model_dump_json(indent=2, exclude_defaults=True).encode()
    sources = {slot: source.content for slot, source in parts.sources.items()}
    return packed_job(choices, sources, parts.pictures, parts.result)


def packed_job(
    choices: bytes,
    sources: Mapping[str, bytes],
    pictures: Mapping[str, bytes],
    result: Mapping[str, Any],
    of_book: OfBook | None = None,
) -> bytes:
    """Return the bytes of the zip of a job that is given as what `JobFile.of` puts together; the same give the same."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as bundle:
        _add(bundle, "job.json", choices)
        _add(bundle, "result.json", json.dumps(result, ensure_ascii=False, indent=2).encode())
        if of_book not in (None, OfBook()):
            _add(bundle, _OF_BOOK, of_book.model_dump_json(indent=2, exclude_defaults=True).encode())
        for slot in sorted(sources, key=[*OWN_FILES, *SLOTS].index):
            _add(bundle, entry_of(slot), sources[slot])
        for name, content in sorted(pictures.items()):
            _add(bundle, f"pictures/{name}", without_notes(content))
    return target.getvalue()


@own_errors_only(InputError, "source", "name")
def read_job_file(
    source: str | Path | bytes, *, name: str = "job file", size_limit: int = SIZE_LIMIT, folder: Path | None = None
) -> JobFile:
    """Read a job from its zip; no path of the zip is followed.

    Parameters
    ----------
    source
        a path, or the zip's bytes (then ``name`` names it in messages).
    size_limit
        bytes that it may unpack to.
    folder
        in which a large log is unpacked; unless given, nothing is written to disk.

    Raises
    ------
    InputError
        a file that is no job file, is damaged, would unpack to more than ``size_limit`` bytes, or holds entries that
        no job has.
    """
    name = name if isinstance(source, bytes) else Path(source).name
    return _job_file(_unpacked(source, name, size_limit, folder), name)


def _unpacked(source: str | Path | bytes, name: str, size_limit: int, folder: Path | None) -> dict[str, bytes | Path]:
    """Return the entries of a job's zip by their names."""
    place = Place(file=name)
    try:
        content = io.BytesIO(source) if isinstance(source, bytes) else Path(source).open("rb")  # noqa: SIM115  below
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else str(error)
        problem = Sentence("cannot be read: {reason}", reason=reason)
        raise InputError(problem, place=place, expected=Sentence("a job file (zip)")) from error
    try:
        with content, zipfile.ZipFile(content) as bundle:
            return dict(_entries(bundle, name, size_limit, folder))
    except AtleakError:
        raise
    except DAMAGE as error:
        if isinstance(error, MemoryError) or own_line(error) is not None:
            raise  # no fault of the zip
        problem = Sentence("is no sound zip: {reason}", reason=str(error)[:100])
        raise InputError(problem, place=place, expected=Sentence("a job file of atleak")) from error


def _job_file(entries: dict[str, bytes | Path], name: str) -> JobFile:
    held = {entry: content for entry, content in entries.items() if isinstance(content, bytes)}
    if "job.json" not in held:
        problem = Sentence("holds no job.json")
        raise InputError(problem, place=Place(file=name), expected=Sentence("a job file of atleak"))
    result = json_of(held.get("result.json", b"{}"), Sentence("{name}: {file}", name=name, file="result.json"))
    named = {entry_of(slot): slot for slot in (*OWN_FILES, *SLOTS)}
    sources = {named[entry]: content for entry, content in entries.items() if entry in named}
    pictures = {
        entry.removeprefix("pictures/"): content for entry, content in held.items() if entry.startswith("pictures/")
    }
    called = Sentence("{name}: {file}", name=name, file=_OF_BOOK)
    of_book = validated(OfBook, json_of(held.get(_OF_BOOK, b"{}"), called), called)
    result = result if isinstance(result, dict) else {}
    return JobFile.of(held["job.json"], sources, pictures, result, name=name, of_book=of_book)


# --- in and out of the zip


def _add(bundle: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name, _STAMP)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o600 << 16
    bundle.writestr(entry, content)


def _entries(
    bundle: zipfile.ZipFile, name: str, size_limit: int, folder: Path | None
) -> Iterator[tuple[str, bytes | Path]]:
    infos = bundle.infolist()
    place = Place(file=name)
    if len(infos) > _ENTRIES:
        expected = Sentence("at most {count}", count=_ENTRIES)
        raise InputError(Sentence("holds too many files"), place=place, value=len(infos), expected=expected)
    names = [info.filename for info in infos]
    if len(set(names)) != len(names):
        raise InputError(Sentence("holds a file twice"), place=place, value=max(names, key=names.count))
    total = sum(info.file_size for info in infos)
    if total > size_limit:
        expected = Sentence("at most {size} bytes unpacked", size=size_limit)
        raise InputError(Sentence("too large"), place=place, value=total, expected=expected)
    for info in infos:
        if info.filename.endswith("/"):
            continue  # left by programs that zip folders
        if info.flag_bits & 0x1:
            raise InputError(Sentence("is encrypted"), place=place, value=info.filename)
        if info.compress_type not in PACKINGS:
            problem = Sentence("is packed in a way that no job is")
            raise InputError(problem, place=place, value=info.filename, expected=Sentence("deflate"))
        if (limit := _entry_limit(info.filename)) is None:
            raise InputError(Sentence("holds a file that no job has"), place=place, value=info.filename)
        if folder is not None and info.filename == entry_of("road_test") and info.file_size > _LARGE:
            path = folder / info.filename
            with path.open("wb") as target:
                _unpack(bundle, info, limit, place, target)
            yield info.filename, path
            continue
        held = io.BytesIO()
        _unpack(bundle, info, limit, place, held)
        yield info.filename, held.getvalue()


def _unpack(bundle: zipfile.ZipFile, info: zipfile.ZipInfo, limit: int, place: Place, target: IO[bytes]) -> None:
    """Write the content of an entry; refuse it as soon as it is longer than such a file can be."""
    most, size = min(limit, _SPARE + _TIGHTEST * info.compress_size), 0
    with bundle.open(info) as stream:
        while max(info.file_size, size) <= most and (part := stream.read(_STEP)):
            target.write(part)
            size += len(part)
    if max(info.file_size, size) > most:
        expected = Sentence("at most {size} bytes unpacked", size=most)
        problem = Sentence("{file}: too large", file=info.filename)
        raise InputError(problem, place=place, value=max(info.file_size, size), expected=expected)


def _entry_limit(name: str) -> int | None:
    """Return how many bytes an entry may unpack to; None where no job has one of that name."""
    if name in _LIMITS:
        return _LIMITS[name]
    if name in map(entry_of, OWN_FILES):
        return _TABLE_LIMIT
    if name in map(entry_of, SLOTS):
        return _CATALOGUE_LIMIT
    picture = name.removeprefix("pictures/")
    try:
        return _PICTURE_LIMIT if name != picture and picture_name(picture) == picture else None
    except ValueError:
        return None
