"""Keep the results of a fleet in a folder of Parquet data sets: written whole, read back, and never twice.

A batch of units is written as parts of one name, a part for every data set and valve body, `units` and `errors` last: a
part of any other data set counts only beside the part of `units` that it was written with, which says how many rows it
has. Of several rows of one unit, by its reference or its hash, the one written last counts. So a run that ends in the
midst of writing leaves nothing that counts but whole results, and those of a corrected job take the place of the
earlier ones.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import json
import os
import re
import secrets
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import quote, unquote

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from filelock import FileLock, Timeout

from atleak.doors import DAMAGE, damaged
from atleak.errors import FleetError, Place
from atleak.fleet.columns import DATA_SETS, HASH, PARTITION, DataSet, columns_of
from atleak.sentence import Sentence, some
from atleak.system.files import not_written, replace_file, replacing
from atleak.system.reasons import reason_of
from atleak.version import __version__

if TYPE_CHECKING:
    from atleak.fleet.rows import Rows

FORMAT = 1  # of the data sets
NOT_KNOWN = "not-known"  # in a folder's name, in the place of a valve body's id: no id has a hyphen
_RUN, _LOCK, _COLUMNS = "run.json", "run.lock", "schema.parquet"
_KIND = "atleak fleet"  # says in `run.json` whose folder it is
_BESIDE: tuple[DataSet, ...] = tuple(each for each in DATA_SETS if each not in ("units", "errors"))
_COMMITTING: tuple[DataSet, ...] = ("units", "errors")
_WITH = b"atleak.with"  # in a part of `units`: the data sets of which a part was written with it
_SMALL = 1000  # units: a part with fewer is merged with others
_TRIES = 20  # at reading while a run puts other parts in place of those that were there
_TOGETHER = 20_000  # rows that are written at a time
_NAME = re.compile(r"part-(\d{8}T\d{6}\.\d{6})Z-[0-9a-f]{8}\.parquet")
_STAMP = "%Y%m%dT%H%M%S.%f"
_NOT_OURS = {".DS_Store", "Thumbs.db", "desktop.ini"}  # that systems put into any folder
_FREE = Sentence("a folder that is new or empty, or one with results of a fleet")


@dataclass(frozen=True, order=True)
class _Part:
    """A part of a data set; those of one batch have one name, and the name of a later batch sorts after it."""

    name: str
    folder: str  # of the valve body
    data_set: DataSet

    def of(self, data_set: DataSet) -> _Part:
        """Return the part of another data set that was written with it."""
        return _Part(self.name, self.folder, data_set)

    @property
    def controller(self) -> str | None:
        """Return the valve body's id; None where it is not known."""
        said = unquote(self.folder.partition("=")[2])
        return None if said == NOT_KNOWN else said


@dataclass(frozen=True)
class _Units:
    """The units of a part of `units` or `errors`, in the order of its rows."""

    hashes: tuple[str, ...]
    references: tuple[str, ...]
    beside: tuple[DataSet, ...]  # of which parts were written with it


Batch = Sequence[tuple[_Part, Iterable[pa.Table]]]


class Results:
    """The results of a fleet in a folder; for writing they are open to one program at a time."""

    def __init__(self, folder: Path, lock: FileLock | None = None) -> None:
        self.folder = folder
        self._lock = lock
        self._known: dict[_Part, _Units] = {}

    @classmethod
    def open(cls, folder: str | Path, *, for_writing: bool = False, replace: bool = False) -> Self:
        """Open the results in a folder.

        Parameters
        ----------
        folder
            made where there is none, for writing.
        for_writing
            whether results are added; nobody else adds any meanwhile.
        replace
            whether to begin anew: what the folder holds of earlier runs is removed.

        Raises
        ------
        FleetError
            the folder holds something else, or results of another version; another run is writing there.
        OutputError
            the folder cannot be made or written to.
        """
        folder = Path(folder)
        if not for_writing:
            _check_readable(folder)
            return cls(folder)
        _check_free(folder)
        results = cls(folder, _locked(folder))
        try:
            results._begin(replace=replace)
        except BaseException:
            results.close()
            raise
        return results

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let others write."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def done(self) -> set[str]:
        """Return the hashes of all units that have a result or an error."""
        return {sha256 for part, counts in self._counting() for sha256 in compress(self._known[part].hashes, counts)}

    def failed(self) -> set[str]:
        """Return the hashes of all units that have an error."""
        errors = [(part, counts) for part, counts in self._counting() if part.data_set == "errors"]
        return {sha256 for part, counts in errors for sha256 in compress(self._known[part].hashes, counts)}

    def controllers(self) -> tuple[str, ...]:
        """Return the ids of all valve bodies of which there is a result."""
        bodies = {part.controller for part, counts in self._counting() if part.data_set == "units" and any(counts)}
        return tuple(sorted(filter(None, bodies)))

    def table(
        self, data_set: DataSet, columns: Sequence[str] | None = None, controllers: Collection[str] | None = None
    ) -> pa.Table:
        """Return the rows of a data set that count; a column that an earlier version did not write is null.

        Parameters
        ----------
        data_set
            one of `DATA_SETS`.
        columns
            those that are read; unless given all, and at the end ``controller``, the valve body's id.
        controllers
            ids of the valve bodies whose rows are read; unless given all.

        Raises
        ------
        FleetError
            a part that is damaged or missing, by its path.
        """
        for tries_left in reversed(range(_TRIES)):
            try:
                return self._table(data_set, columns, controllers)
            except FileNotFoundError as error:  # a run put a merged part in its place
                if not tries_left:
                    raise self._damaged(error.filename, error) from error
        raise AssertionError

    def add(self, rows: Sequence[Rows]) -> None:
        """Write the rows of some units; they count as soon as this returns.

        Raises
        ------
        OutputError
            naming the part that cannot be written, and why; nothing of these rows is kept.
        """
        name, rows = self._next_name(), _last_of_each(rows)
        tables: dict[_Part, list[pa.Table]] = {}
        for data_set in (*_BESIDE, *_COMMITTING):
            for each in rows:
                if data_set in each.tables:
                    tables.setdefault(_Part(name, _folder(each.controller), data_set), []).append(each.tables[data_set])
        self._commit(list(tables.items()))

    def tidy(self) -> None:
        """Remove what does not count and merge small parts, so that other programs read one row for every unit.

        Raises
        ------
        FleetError, OutputError
            a part that is damaged, or that cannot be written.
        """
        counting = self._counting()
        for parts in _to_rewrite(counting):
            self._rewrite({part: counts for part, counts in counting if part in parts})
        whole = set(self._parts("units"))
        self._remove(part for data_set in _BESIDE for part in self._parts(data_set) if part.of("units") not in whole)
        for unfinished in self.folder.rglob(".atleak-*.part"):
            with contextlib.suppress(OSError):
                unfinished.unlink()

    def _begin(self, *, replace: bool) -> None:
        run = _run_of(self.folder)
        if run is not None and not replace:
            _check_version(self.folder, run)
        if replace:
            self._remove([part for data_set in (*_COMMITTING, *_BESIDE) for part in self._parts(data_set)])
        if run is None or replace:
            text = json.dumps({"kind": _KIND, "format": FORMAT, "atleak": __version__}, indent=2)
            replace_file(self.folder / _RUN, f"{text}\n".encode())
        for data_set in DATA_SETS:
            path = self.folder / data_set / _folder(None) / _COLUMNS
            if replace or not path.is_file():
                _write(path, columns_of(data_set), ())

    def _next_name(self) -> str:
        """Return a name for the parts of a batch that sorts after those of all others, whatever the clock shows."""
        stamp = dt.datetime.now(dt.UTC).replace(tzinfo=None)
        names = [part.name for data_set in DATA_SETS for part in self._parts(data_set)]
        if names:
            latest = _NAME.fullmatch(max(names))
            assert latest is not None
            stamp = max(stamp, dt.datetime.strptime(latest[1], _STAMP) + dt.timedelta(microseconds=1))
        return f"part-{stamp.strftime(_STAMP)}Z-{secrets.token_hex(4)}.parquet"

    def _parts(self, data_set: DataSet) -> list[_Part]:
        found = (self.folder / data_set).glob(f"{PARTITION}=*/*.parquet")
        return [_Part(path.name, path.parent.name, data_set) for path in found if _NAME.fullmatch(path.name)]

    def _path(self, part: _Part) -> Path:
        return self.folder / part.data_set / part.folder / part.name

    def _counting(self) -> list[tuple[_Part, list[bool]]]:
        """Return every part of `units` and `errors`, the earliest first, and which of its rows count."""
        parts = sorted(part for data_set in _COMMITTING for part in self._parts(data_set))
        self._known = {part: self._known.get(part) or self._units_of(part) for part in parts}
        by_hash: dict[str, int] = {}
        by_reference: dict[str, int] = {}
        row = 0
        for part in parts:
            for sha256, reference in zip(self._known[part].hashes, self._known[part].references, strict=True):
                by_hash[sha256] = by_reference[reference] = row
                row += 1
        counting, row = [], 0
        for part in parts:
            counts = []
            for sha256, reference in zip(self._known[part].hashes, self._known[part].references, strict=True):
                counts.append(by_hash[sha256] == by_reference[reference] == row)
                row += 1
            counting.append((part, counts))
        return counting

    def _units_of(self, part: _Part) -> _Units:
        table = self._read(part, [HASH, "reference"])
        beside = json.loads((table.schema.metadata or {}).get(_WITH, b"[]"))
        return _Units(tuple(table[HASH].to_pylist()), tuple(table["reference"].to_pylist()), tuple(beside))

    def _table(self, data_set: DataSet, columns: Sequence[str] | None, controllers: Collection[str] | None) -> pa.Table:
        schema = columns_of(data_set).append(pa.field(PARTITION, pa.string()))
        wanted = pa.schema([schema.field(name) for name in (schema.names if columns is None else columns)])
        owner = data_set if data_set in _COMMITTING else "units"
        tables = [wanted.empty_table()]
        for part, counts in self._counting():
            if part.data_set != owner or not any(counts) or data_set not in (owner, *self._known[part].beside):
                continue
            if controllers is None or part.controller in controllers:
                table = self._rows(part, counts, data_set, [name for name in wanted.names if name != PARTITION])
                of_all = pa.repeat(pa.scalar(part.controller, pa.string()), table.num_rows)
                tables.append(table.append_column(schema.field(PARTITION), of_all).select(wanted.names))
        return pa.concat_tables(tables)

    def _rows(self, part: _Part, counts: Sequence[bool], data_set: DataSet, columns: Sequence[str]) -> pa.Table:
        """Return the rows of a data set that count, of the units in a part of `units` or `errors`."""
        table = self._read(part.of(data_set), [*columns, *({HASH} - set(columns))])
        if not all(counts):
            hashes = pa.array(compress(self._known[part].hashes, counts), pa.string())
            table = table.filter(pc.is_in(table[HASH], value_set=hashes))
        schema = columns_of(data_set)
        return (
            pa.table(
                [_grown(table, schema.field(name)) for name in columns], schema=pa.schema(map(schema.field, columns))
            )
            if columns
            else table.select([])
        )

    def _read(self, part: _Part, columns: Sequence[str]) -> pa.Table:
        """Read columns of a part, as far as they were written."""
        path = self._path(part)
        try:
            with path.open("rb") as stream, pq.ParquetFile(stream, page_checksum_verification=True) as file:
                there = set(file.schema_arrow.names)
                return file.read([name for name in columns if name in there])
        except FileNotFoundError:
            raise
        except DAMAGE as error:
            raise self._damaged(path, error) from error

    def _damaged(self, path: str | Path, error: Exception) -> FleetError:
        """Return the error of a part that cannot be read; without the one that makes it count its units are missing."""
        path = Path(path)
        owner = path.parents[1].name if path.parents[1].name in _COMMITTING else "units"
        counting = self.folder / owner / path.parent.name / path.name
        expected = Sentence(
            "a part as it was written: once {path} is deleted, the next run evaluates its units anew",
            path=str(counting),
        )
        return FleetError(damaged(error).problem, place=Place(file=str(path)), expected=expected)

    def _commit(self, batch: Batch) -> None:
        """Write the parts of a batch, all of them or none: in the order given, those by which others count last."""
        written: list[_Part] = []
        try:
            for part, tables in batch:
                beside = [each.data_set for each in written if each.folder == part.folder]
                if part.data_set in _COMMITTING:
                    _settle({self._path(each).parent for each in written})
                written.append(part)
                schema = columns_of(part.data_set).with_metadata({_WITH: json.dumps(beside)})
                _write(self._path(part), schema, tables)
        except BaseException:
            self._remove(reversed(written))
            raise

    def _rewrite(self, counting: Mapping[_Part, Sequence[bool]]) -> None:
        """Write what counts of some parts of one valve body as one, and remove them."""
        of_any = next(iter(counting))
        merged = _Part(self._next_name(), of_any.folder, of_any.data_set)
        batch = []
        for data_set in (*_BESIDE, "units") if of_any.data_set == "units" else ("errors",):
            having = {
                part: counts
                for part, counts in counting.items()
                if any(counts) and data_set in (part.data_set, *self._known[part].beside)
            }
            if having:
                batch.append((merged.of(data_set), self._all_rows(having, data_set)))
        self._commit(batch)
        self._remove(counting)

    def _all_rows(self, counting: Mapping[_Part, Sequence[bool]], data_set: DataSet) -> Iterator[pa.Table]:
        for part, counts in counting.items():
            yield self._rows(part, counts, data_set, columns_of(data_set).names)

    def _remove(self, parts: Iterable[_Part]) -> None:
        """Remove parts as far as possible: one that another program reads stays, and does not count."""
        for part in parts:
            with contextlib.suppress(OSError):
                self._path(part).unlink()


def _folder(controller: str | None) -> str:
    return f"{PARTITION}={NOT_KNOWN if controller is None else quote(controller, safe='')}"


def _last_of_each(rows: Sequence[Rows]) -> list[Rows]:
    """Return the rows of each unit that were given last."""
    by_hash = {each.input_sha256: each for each in rows}
    by_reference = {each.reference: each for each in rows}
    return [each for each in rows if by_hash[each.input_sha256] is by_reference[each.reference] is each]


def _to_rewrite(counting: Sequence[tuple[_Part, Sequence[bool]]]) -> Iterator[set[_Part]]:
    """Yield the parts that are better written as one: several small ones, and any of which not every row counts."""
    loose: dict[tuple[DataSet, str], list[tuple[_Part, Sequence[bool]]]] = {}
    for part, counts in counting:
        if sum(counts) < _SMALL or not all(counts):
            loose.setdefault((part.data_set, part.folder), []).append((part, counts))
    for parts in loose.values():
        group: list[tuple[_Part, Sequence[bool]]] = []
        for number, (part, counts) in enumerate(parts, 1):
            group.append((part, counts))
            if sum(sum(each) for _, each in group) >= _SMALL or number == len(parts):
                if len(group) > 1 or not all(group[0][1]):
                    yield {each for each, _ in group}
                group = []


def _write(path: Path, schema: pa.Schema, tables: Iterable[pa.Table]) -> None:
    """Write a part whole, or nothing of it."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(path.parent, error) from error
    with (
        replacing(path) as beside,
        beside.open("wb") as stream,
        pq.ParquetWriter(stream, schema, compression="zstd", write_page_checksum=True) as writer,
    ):
        for table in _together(tables):
            writer.write_table(table)


def _together(tables: Iterable[pa.Table]) -> Iterator[pa.Table]:
    """Yield small tables as larger ones, in the same order."""
    gathered: list[pa.Table] = []
    for table in tables:
        gathered.append(table)
        if sum(each.num_rows for each in gathered) >= _TOGETHER:
            yield pa.concat_tables(gathered)
            gathered = []
    if gathered:
        yield pa.concat_tables(gathered)


def _settle(folders: Iterable[Path]) -> None:
    """Have the disk keep the names of files in some folders before anything that is written later."""
    for folder in folders:
        with contextlib.suppress(OSError):  # Windows opens no folder, and keeps the order by itself
            handle = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def _grown(table: pa.Table, field: pa.Field) -> pa.ChunkedArray:
    """Return a column as it is written today; null where an earlier version did not write it."""
    if field.name not in table.schema.names:
        return pa.chunked_array([pa.nulls(table.num_rows, field.type)])
    column = table[field.name]
    return pa.chunked_array([_as(chunk, field.type) for chunk in column.chunks], field.type)


def _as(array: pa.Array, kind: pa.DataType) -> pa.Array:
    if array.type == kind:
        return array
    if pa.types.is_struct(kind) and pa.types.is_struct(array.type):
        there = {field.name for field in array.type}
        parts = [
            _as(pc.struct_field(array, field.name), field.type)
            if field.name in there
            else pa.nulls(len(array), field.type)
            for field in kind
        ]
        return pa.StructArray.from_arrays(parts, fields=list(kind), mask=array.is_null())
    if pa.types.is_list(kind) and pa.types.is_list(array.type):
        lengths = pc.fill_null(pc.list_value_length(array), 0)
        ends = pc.cumulative_sum(lengths)
        offsets = pa.concat_arrays([pa.array([0], pa.int32()), ends.cast(pa.int32())])
        items = _as(array.flatten(), kind.value_type)
        return pa.ListArray.from_arrays(offsets, items, type=kind, mask=array.is_null())
    return array.cast(kind)


def _run_of(folder: Path) -> dict[str, Any] | None:
    """Return what the folder says of the run whose results it holds; None where it holds none."""
    path = folder / _RUN
    try:
        said = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise FleetError(problem, place=Place(file=str(path))) from error
    except ValueError:
        said = None
    if not isinstance(said, dict) or said.get("kind") != _KIND or not isinstance(said.get("format"), int):
        raise FleetError(Sentence("is not what a fleet's run wrote"), place=Place(file=str(path)), expected=_FREE)
    return said


def _check_readable(folder: Path) -> None:
    run = _run_of(folder)
    if run is None:
        problem = Sentence("holds no results of a fleet")
        expected = Sentence("the folder that 'atleak fleet run' was given for its results")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected)
    if run["format"] > FORMAT:
        _check_version(folder, run)


def _check_version(folder: Path, run: Mapping[str, Any]) -> None:
    if (run["format"], run.get("atleak")) != (FORMAT, __version__):
        problem = Sentence(
            "holds results of atleak {theirs}, and this is atleak {own}", theirs=run.get("atleak"), own=__version__
        )
        expected = Sentence("another folder, or --replace to begin anew")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected)


def _check_free(folder: Path) -> None:
    """Check that a folder is new, empty or a fleet's, before anything is written to it."""
    if _run_of(folder) is not None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
        names = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        raise not_written(folder, error) from error
    others = [name for name in names if name != _LOCK and name not in _NOT_OURS and not name.startswith(".atleak-")]
    if others:
        problem = Sentence("holds something else: {names}", names=some(others, 3))
        raise FleetError(problem, place=Place(file=str(folder)), expected=_FREE)


def _locked(folder: Path) -> FileLock:
    """Lock a folder for writing until this program lets it go, or ends."""
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
