"""Keep the folder of a fleet's results: whose it is, which version wrote it, its parts, and where there are others.

One program writes at a time. A part is a file of one batch of units, of one data set and valve body. The folders that
somebody worked with on this computer are remembered, as nobody types a path into a page: who reaches a dashboard over a
network sees those and no other.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import hashlib
import json
import os
import re
import secrets
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pyarrow as pa
import pyarrow.parquet as pq
from filelock import FileLock, Timeout

from atleak.common.errors import AtleakError, FleetError, InputError, Place, reason_of
from atleak.common.files import damaged_before, home, not_written, readable, replace_file, replacing, rewritten
from atleak.common.sentences import Sentence, some
from atleak.fleet.columns import DATA_SETS, PARTITION, DataSet, columns_of
from atleak.version import __version__

_FORMAT = 1  # of the data sets
_RUN, _LOCK = "run.json", "run.lock"
_KIND = "atleak fleet"  # says in `run.json` whose folder it is
_NOT_OURS = {".DS_Store", "Thumbs.db", "desktop.ini"}  # that systems put into any folder
_FREE = Sentence("a folder that is new or empty, or one with results of a fleet")


def check_readable(folder: Path) -> None:
    """Check that a folder holds results of a fleet that this version can read.

    Raises
    ------
    FleetError
        it holds none, or those of a later version.
    """
    run = _run_of(folder)
    if run is None:
        problem = Sentence("holds no results of a fleet")
        expected = Sentence("the folder that 'atleak fleet run' was given for its results")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected)
    if run["format"] > _FORMAT:
        raise _other_version(folder, run)


def check_version(folder: Path) -> None:
    """Check that a folder holds no results of another version, beside which none of this can be written.

    Raises
    ------
    FleetError
        naming both versions.
    """
    run = _run_of(folder)
    if run is not None and (run["format"], run.get("atleak")) != (_FORMAT, __version__):
        raise _other_version(folder, run, Sentence("another folder, or --replace to begin anew"))


def _other_version(folder: Path, run: Mapping[str, Any], expected: Sentence | None = None) -> FleetError:
    problem = Sentence(
        "holds results of atleak {theirs}, and this is atleak {own}", theirs=run.get("atleak"), own=__version__
    )
    return FleetError(problem, place=Place(file=str(folder)), expected=expected)


def check_free(folder: Path) -> None:
    """Make a folder unless it is there, and check that it is empty or a fleet's, before anything is written to it.

    Raises
    ------
    FleetError
        it holds something else.
    OutputError
        it cannot be made.
    """
    if _run_of(folder) is not None:
        return
    if folder.is_symlink() and not folder.exists():
        raise FleetError(Sentence("is a link to something that is not there"), place=Place(str(folder)), expected=_FREE)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        names = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        raise not_written(folder, error) from error
    others = [name for name in names if name != _LOCK and name not in _NOT_OURS and not name.startswith(".atleak-")]
    if others:
        problem = Sentence("holds something else: {names}", names=some(others, 3))
        raise FleetError(problem, place=Place(file=str(folder)), expected=_FREE)


def locked(folder: Path) -> FileLock:
    """Lock a folder for writing until this program lets it go, or ends.

    Raises
    ------
    FleetError
        another program writes there.
    OutputError
        it cannot be locked.
    """
    lock = FileLock(folder / _LOCK, timeout=0, thread_local=False)
    try:
        lock.acquire()
    except Timeout as error:
        problem = Sentence("another run is writing its results there")
        expected = Sentence("another folder, or that run to end first")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected) from error
    except OSError as error:
        raise not_written(folder / _LOCK, error) from error
    return lock


def remove_empty(folder: Path) -> None:
    """Remove a folder in which nothing but its lock stands, as far as that is possible."""
    with contextlib.suppress(OSError):
        (folder / _LOCK).unlink(missing_ok=True)
        folder.rmdir()


def write_run(folder: Path) -> None:
    """Write down that a folder holds results of this version.

    Raises
    ------
    OutputError
        it cannot be written.
    """
    text = json.dumps({"kind": _KIND, "format": _FORMAT, "atleak": __version__}, indent=2)
    replace_file(folder / _RUN, f"{text}\n".encode())


def _run_of(folder: Path) -> dict[str, Any] | None:
    """Return what the folder says of the run whose results it holds; None where it holds none."""
    path = folder / _RUN
    if folder.exists() and not folder.is_dir():
        raise FleetError(Sentence("is a file"), place=Place(file=str(folder)), expected=_FREE)
    try:
        content = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise FleetError(problem, place=Place(file=str(path))) from error
    except ValueError:
        content = None
    if not isinstance(content, dict) or content.get("kind") != _KIND or not isinstance(content.get("format"), int):
        raise FleetError(Sentence("is not what a fleet's run wrote"), place=Place(file=str(path)), expected=_FREE)
    return content


COMMITTING: tuple[DataSet, ...] = ("units", "errors")  # written last: by their parts those of the others count
BESIDE_UNITS: tuple[DataSet, ...] = tuple(each for each in DATA_SETS if each not in COMMITTING)
_NOT_KNOWN = "not-known"  # in a folder's name, in the place of a valve body's id: no id has a hyphen
_COLUMNS = "schema.parquet"  # without a row, for those who read a data set to which nothing was written yet
_LONGEST = 200  # characters of a valve body's id
_WITH = b"atleak.with"  # in a part of `units`: the data sets of which a part was written with it
_NAME = re.compile(r"part-(\d{8}T\d{6}\.\d{6})Z-[0-9a-f]{8}\.parquet")
_STAMP = "%Y%m%dT%H%M%S.%f"
UNFINISHED = ".atleak-*.part"  # files of a process that ended in the midst of writing


@dataclass(frozen=True, order=True)
class ResultPart:
    """A part of a data set; those of one batch have one name, and the name of a later batch sorts after it."""

    name: str
    folder: str  # of the valve body
    data_set: DataSet

    def of(self, data_set: DataSet) -> ResultPart:
        """Return the part of another data set that was written with it."""
        return ResultPart(self.name, self.folder, data_set)

    @property
    def controller(self) -> str | None:
        """Return the valve body's id; None where it is not known.

        >>> ResultPart("", "controller=four_speed_2023", "units").controller
        'four_speed_2023'
        """
        controller = unquote(self.folder.partition("=")[2])
        return None if controller == _NOT_KNOWN else controller

    def under(self, folder: Path) -> Path:
        """Return where it stands in a folder of results."""
        return folder / self.data_set / self.folder / self.name


def folder_of(controller: str | None) -> str:
    """Return the name of a valve body's folder in every data set, as programs that read Parquet understand it.

    >>> folder_of("four_speed_2023"), folder_of("Ä/b"), folder_of(None)
    ('controller=four_speed_2023', 'controller=%C3%84%2Fb', 'controller=not-known')

    Raises
    ------
    InputError
        an id that is too long for the name of a folder.
    """
    name = _NOT_KNOWN if controller is None else quote(controller, safe="")
    if len(name) > _LONGEST:
        problem = Sentence("the valve body's id is too long for the name of a folder")
        raise InputError(problem, value=controller, expected=Sentence("{count} characters at most", count=_LONGEST))
    return f"{PARTITION}={name}"


def parts_of(folder: Path, data_set: DataSet) -> list[ResultPart]:
    """Return all parts of a data set that are there, whether they count or not."""
    found = (folder / data_set).glob(f"{PARTITION}=*/*.parquet")
    return [ResultPart(path.name, path.parent.name, data_set) for path in found if _NAME.fullmatch(path.name)]


def name_after(names: Collection[str]) -> str:
    """Return a name for the parts of a batch that sorts after some others, whatever the clock shows."""
    stamp = dt.datetime.now(dt.UTC).replace(tzinfo=None)
    latest = _NAME.fullmatch(max(names, default=""))
    if latest is not None:
        stamp = max(stamp, dt.datetime.strptime(latest[1], _STAMP) + dt.timedelta(microseconds=1))
    return f"part-{stamp.strftime(_STAMP)}Z-{secrets.token_hex(4)}.parquet"


def write_part(folder: Path, part: ResultPart, tables: Iterable[pa.Table], beside: Sequence[DataSet] = ()) -> None:
    """Write the tables of a part whole, or nothing of it; ``beside`` are the data sets that were written with it.

    Raises
    ------
    OutputError
        naming the file or folder that cannot be written, and why.
    """
    schema = columns_of(part.data_set).with_metadata({_WITH: json.dumps(beside)})
    path = part.under(folder)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(path.parent, error) from error
    whole = pa.concat_tables([schema.empty_table(), *tables])
    with replacing(path) as new, new.open("wb") as stream:
        pq.write_table(whole, stream, compression="zstd", write_page_checksum=True)


def write_columns(folder: Path, data_set: DataSet, *, anew: bool) -> None:
    """Write the part of a data set that has its columns and no rows, unless it is there.

    Raises
    ------
    OutputError
        it cannot be written.
    """
    part = ResultPart(_COLUMNS, folder_of(None), data_set)
    if anew or not part.under(folder).is_file():
        write_part(folder, part, ())


def read_part(folder: Path, part: ResultPart, columns: Sequence[str]) -> tuple[pa.Table, tuple[DataSet, ...]]:
    """Read some columns of a part, and of which data sets a part was written with it.

    A column that an earlier version of atleak did not write is null.

    Raises
    ------
    FileNotFoundError, ValueError, OSError
        as Python and Arrow raise them on a file that is missing or damaged.
    """
    with part.under(folder).open("rb") as stream, pq.ParquetFile(stream, page_checksum_verification=True) as file:
        there = set(file.schema_arrow.names)
        table = file.read([name for name in columns if name in there])
        beside = tuple(json.loads((file.schema_arrow.metadata or {}).get(_WITH, b"[]")))
        rows = file.metadata.num_rows
    schema = columns_of(part.data_set)
    fields = [schema.field(name) for name in columns]
    grown = [_grown(table, field, rows) for field in fields]
    return pa.table(grown, schema=pa.schema(fields)), beside


def settle(folders: Iterable[Path]) -> None:
    """Have the disk keep the names of files in some folders before anything that is written later."""
    for folder in folders:
        with contextlib.suppress(OSError):  # Windows opens no folder, and keeps the order by itself
            handle = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def _grown(table: pa.Table, field: pa.Field, rows: int) -> pa.ChunkedArray:
    """Return a column as it is written today; null where an earlier version did not write it, or a part of it."""
    if field.name not in table.schema.names:
        return pa.chunked_array([pa.nulls(rows, field.type)])
    column = table[field.name]
    return column if column.type == field.type else pa.chunked_array([pa.array(column.to_pylist(), field.type)])


_MOST = 50  # folders that are remembered, those that were used last
_ID = 12  # digits


@dataclass(frozen=True)
class KnownFolder:
    """A folder with results of a fleet, as it was known when a command used it last."""

    path: Path
    when: str  # UTC, ISO 8601

    @property
    def id(self) -> str:
        """Return by what an address names it: no path stands there."""
        return hashlib.sha256(str(self.path).encode("utf-8", "surrogatepass")).hexdigest()[:_ID]

    @property
    def is_there(self) -> bool:
        """Tell whether it still holds results that can be read."""
        try:
            check_readable(self.path)
        except (AtleakError, OSError):
            return False
        return True


def note(folder: str | Path) -> None:
    """Remember a folder as the one that was used last; the one that was used longest ago goes from too many.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    now = dt.datetime.now(dt.UTC).isoformat(timespec="microseconds")
    with rewritten(_path()) as entries:
        entries[str(Path(folder).resolve())] = now
        for other in sorted(entries, key=lambda each: str(entries[each]), reverse=True)[_MOST:]:
            del entries[other]


def known_folders() -> tuple[KnownFolder, ...]:
    """Return the folders that are remembered, the one that was used last first, whether or not they are still there."""
    entries = readable(_path()).items()
    known = [KnownFolder(Path(path), when) for path, when in entries if isinstance(when, str)]
    return tuple(sorted(known, key=lambda each: each.when, reverse=True))


def set_aside() -> list[Path]:
    """Return the files of such folders that were set aside because they were damaged, the earliest first."""
    return damaged_before(_path())


def forget(folder: KnownFolder) -> None:
    """Remember a folder no longer; its results stay where they are.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    with rewritten(_path()) as entries:
        entries.pop(str(folder.path), None)


def _path() -> Path:
    return home() / "fleets.json"
