"""Write and read the parts of a fleet's data sets: files of one batch of units, of one data set and valve body each."""

from __future__ import annotations

import contextlib
import datetime as dt
import json
import os
import re
import secrets
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote, unquote

import pyarrow as pa
import pyarrow.parquet as pq

from atleak.errors import InputError
from atleak.fleet.columns import DATA_SETS, PARTITION, DataSet, columns_of
from atleak.sentence import Sentence
from atleak.system.files import not_written, replacing

COMMITTING: tuple[DataSet, ...] = ("units", "errors")  # written last: by their parts those of the others count
BESIDE: tuple[DataSet, ...] = tuple(each for each in DATA_SETS if each not in COMMITTING)
_NOT_KNOWN = "not-known"  # in a folder's name, in the place of a valve body's id: no id has a hyphen
_COLUMNS = "schema.parquet"  # without a row, for those who read a data set to which nothing was written yet
_LONGEST = 200  # characters of a valve body's id
_WITH = b"atleak.with"  # in a part of `units`: the data sets of which a part was written with it
_NAME = re.compile(r"part-(\d{8}T\d{6}\.\d{6})Z-[0-9a-f]{8}\.parquet")
_STAMP = "%Y%m%dT%H%M%S.%f"
UNFINISHED = ".atleak-*.part"  # files of a process that ended in the midst of writing


@dataclass(frozen=True, order=True)
class Part:
    """A part of a data set; those of one batch have one name, and the name of a later batch sorts after it."""

    name: str
    folder: str  # of the valve body
    data_set: DataSet

    def of(self, data_set: DataSet) -> Part:
        """Return the part of another data set that was written with it."""
        return Part(self.name, self.folder, data_set)

    @property
    def controller(self) -> str | None:
        """Return the valve body's id; None where it is not known.

        >>> Part("", "controller=four_speed_2023", "units").controller
        'four_speed_2023'
        """
        said = unquote(self.folder.partition("=")[2])
        return None if said == _NOT_KNOWN else said

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


def parts_of(folder: Path, data_set: DataSet) -> list[Part]:
    """Return all parts of a data set that are there, whether they count or not."""
    found = (folder / data_set).glob(f"{PARTITION}=*/*.parquet")
    return [Part(path.name, path.parent.name, data_set) for path in found if _NAME.fullmatch(path.name)]


def name_after(names: Collection[str]) -> str:
    """Return a name for the parts of a batch that sorts after some others, whatever the clock shows."""
    stamp = dt.datetime.now(dt.UTC).replace(tzinfo=None)
    latest = _NAME.fullmatch(max(names, default=""))
    if latest is not None:
        stamp = max(stamp, dt.datetime.strptime(latest[1], _STAMP) + dt.timedelta(microseconds=1))
    return f"part-{stamp.strftime(_STAMP)}Z-{secrets.token_hex(4)}.parquet"


def write_part(folder: Path, part: Part, tables: Iterable[pa.Table], beside: Sequence[DataSet] = ()) -> None:
    """Write a part whole, or nothing of it.

    Parameters
    ----------
    folder
        of the results.
    part
        what is written, and where.
    tables
        its rows.
    beside
        the data sets of which a part was written with it.

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
    part = Part(_COLUMNS, folder_of(None), data_set)
    if anew or not part.under(folder).is_file():
        write_part(folder, part, ())


def read_part(folder: Path, part: Part, columns: Sequence[str]) -> tuple[pa.Table, tuple[DataSet, ...]]:
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
