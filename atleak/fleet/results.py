"""Keep the results of a fleet in a folder of Parquet data sets: written whole, read back, and never twice.

A batch of units is written as parts of one name, one for every data set and valve body, `units` and `errors` last: a
part of any other data set counts only beside the part of `units` that it was written with. Of several rows of one unit,
by its reference or its hash, the one written last counts. So a run that ends in the midst of writing leaves nothing
that counts but whole results, and the result of a corrected job takes the place of the earlier one.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress, repeat
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

import pyarrow as pa
import pyarrow.compute as pc
from filelock import FileLock

from atleak.common.damage import DAMAGE, damaged
from atleak.common.errors import FleetError, OutputError, Place, reason_of
from atleak.common.sentences import Sentence
from atleak.fleet.columns import DATA_SETS, HASH, PARTITION, DataSet, Rows, columns_of
from atleak.fleet.folder import (
    BESIDE_UNITS,
    COMMITTING,
    UNFINISHED,
    ResultPart,
    check_free,
    check_readable,
    check_version,
    folder_of,
    locked,
    name_after,
    parts_of,
    read_part,
    remove_empty,
    settle,
    write_columns,
    write_part,
    write_run,
)

_SMALL = 1000  # units: a part with fewer is merged with others
_TRIES = 20  # at reading while a run puts other parts in place of those that were there

Counts = Sequence[bool]  # of the rows of a part of `units` or `errors`


class ResultStanding(NamedTuple):
    """As what a unit stands in the results."""

    reference: str  # of the `FleetUnit`
    group: str | None  # that it is compared in
    failed: bool  # whether it has an error and no result


@dataclass(frozen=True)
class _Units:
    """The units of a part of `units` or `errors`, in the order of its rows."""

    hashes: tuple[str, ...]
    references: tuple[str, ...]
    groups: tuple[str | None, ...]
    beside: tuple[DataSet, ...]  # of which a part was written with it; none of an error


class Results:
    """The results of a fleet in a folder; for writing they are open to one program at a time."""

    def __init__(self, folder: Path, lock: FileLock | None = None, *, made: bool = False) -> None:
        self.folder = folder
        self._lock = lock
        self._made = made  # the folder was not there, and nothing is written to it yet
        self._known: dict[ResultPart, _Units] = {}  # a part never changes

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
            the folder cannot be made or written to, or what is to be replaced cannot be removed.
        """
        folder = Path(folder)
        if not for_writing:
            check_readable(folder)
            return cls(folder)
        results = cls.reserved(folder, replace=replace)
        try:
            results.begin(replace=replace)
        except BaseException:
            results.close()
            raise
        return results

    @classmethod
    def reserved(cls, folder: str | Path, *, replace: bool = False) -> Self:
        """Check a folder as `open` for writing does and keep others from it, but change nothing in it before `begin`.

        Parameters
        ----------
        folder
            of the results. One that is made here goes again where nothing is begun.
        replace
            as of `open`.

        Raises
        ------
        FleetError, OutputError
            as of `open`.
        """
        folder = Path(folder)
        made = not folder.exists()
        check_free(folder)
        results = cls(folder, locked(folder), made=made)
        try:
            if not replace:
                check_version(folder)
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
            if self._made:
                remove_empty(self.folder)

    def standing(self) -> dict[str, ResultStanding]:
        """Return, by the hash of every unit that has a result or an error, as what it stands there."""
        found: dict[str, ResultStanding] = {}
        for part, counts in self._counting():
            units = self._known[part]
            standing = zip(units.references, units.groups, repeat(part.data_set == "errors"))
            found.update(compress(zip(units.hashes, map(ResultStanding._make, standing), strict=True), counts))
        return found

    def done(self) -> set[str]:
        """Return the hashes of all units that have a result or an error."""
        return set(self.standing())

    def failed(self) -> set[str]:
        """Return the hashes of all units that have an error."""
        return {sha256 for sha256, each in self.standing().items() if each.failed}

    def controllers(self) -> tuple[str, ...]:
        """Return the ids of all valve bodies of which there is a result."""
        bodies = {part.controller for part, counts in self._counting() if part.data_set == "units" and any(counts)}
        return tuple(sorted(filter(None, bodies)))

    def state(self) -> str:
        """Return what changes whenever the results do; nothing of them is read for it."""
        parts = sorted(part for data_set in COMMITTING for part in parts_of(self.folder, data_set))
        return hashlib.sha256(repr(parts).encode("utf-8", "surrogatepass")).hexdigest()

    def table(
        self,
        data_set: DataSet,
        columns: Sequence[str] | None = None,
        controllers: Collection[str] | None = None,
        hashes: Collection[str] | None = None,
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
        hashes
            of the units whose rows are read; unless given all.

        Raises
        ------
        FleetError
            a part that is damaged or missing, by its path.
        """
        for tries_left in reversed(range(_TRIES)):
            try:
                return self._table(data_set, columns, controllers, hashes)
            except FileNotFoundError as error:  # a run put a merged part in its place
                if not tries_left:
                    raise self._damaged(Path(error.filename), error) from error
        raise AssertionError

    def add(self, rows: Sequence[Rows]) -> None:
        """Write the rows of some units; they count as soon as this returns.

        Raises
        ------
        OutputError
            naming the part that cannot be written, and why; nothing of these rows is kept.
        """
        name, rows = self._next_name(), _last_of_each(rows)
        tables: dict[ResultPart, list[pa.Table]] = {}
        for data_set in (*BESIDE_UNITS, *COMMITTING):
            for each in rows:
                if data_set in each.tables:
                    part = ResultPart(name, folder_of(each.controller), data_set)
                    tables.setdefault(part, []).append(each.tables[data_set])
        self._commit(tables)

    def tidy(self) -> None:
        """Remove what does not count and merge small parts, so that other programs read one row for every unit.

        Raises
        ------
        FleetError, OutputError
            a part that is damaged, or that cannot be written.
        """
        for parts in _to_rewrite(self._counting()):
            self._rewrite(parts)
        whole = set(parts_of(self.folder, "units"))
        left_over = [
            part for each in BESIDE_UNITS for part in parts_of(self.folder, each) if part.of("units") not in whole
        ]
        self._remove(left_over)
        for data_set in DATA_SETS:
            for path in (self.folder / data_set).glob(f"*/{UNFINISHED}"):
                with contextlib.suppress(OSError):
                    path.unlink()

    def begin(self, *, replace: bool) -> None:
        """Have a folder that is reserved hold results of this version, and nothing else where they are to be replaced.

        Raises
        ------
        OutputError
            it cannot be written to, or what is to be replaced cannot be removed.
        """
        self._made = False
        if replace:
            for part in [part for data_set in COMMITTING for part in parts_of(self.folder, data_set)]:
                _remove_counting(part.under(self.folder))
            self._remove([part for data_set in BESIDE_UNITS for part in parts_of(self.folder, data_set)])
        write_run(self.folder)
        for data_set in DATA_SETS:
            write_columns(self.folder, data_set, anew=replace)

    def _next_name(self) -> str:
        return name_after([part.name for data_set in DATA_SETS for part in parts_of(self.folder, data_set)])

    def _counting(self) -> list[tuple[ResultPart, Counts]]:
        """Return every part of `units` and `errors`, the earliest first, and which of its rows count."""
        parts = sorted(part for data_set in COMMITTING for part in parts_of(self.folder, data_set))
        self._known = {part: self._known.get(part) or self._units_of(part) for part in parts}
        hashes = [sha256 for units in self._known.values() for sha256 in units.hashes]
        references = [reference for units in self._known.values() for reference in units.references]
        of_hash = {sha256: row for row, sha256 in enumerate(hashes)}
        of_reference = {reference: row for row, reference in enumerate(references)}
        pairs = enumerate(zip(hashes, references, strict=True))
        counts = iter([of_hash[sha256] == of_reference[reference] == row for row, (sha256, reference) in pairs])
        return [(part, [next(counts) for _ in units.hashes]) for part, units in self._known.items()]

    def _units_of(self, part: ResultPart) -> _Units:
        table, beside = self._read(part, [HASH, "reference", "group"])
        hashes, references, groups = (tuple(column.to_pylist()) for column in table.columns)
        return _Units(hashes, references, groups, beside)

    def _table(
        self,
        data_set: DataSet,
        columns: Sequence[str] | None,
        controllers: Collection[str] | None,
        hashes: Collection[str] | None,
    ) -> pa.Table:
        schema = columns_of(data_set).append(pa.field(PARTITION, pa.string()))
        wanted = pa.schema([schema.field(name) for name in (schema.names if columns is None else columns)])
        stored = [name for name in wanted.names if name != PARTITION]
        tables = [wanted.empty_table()]
        for part, counts in self._having(data_set, self._of(hashes, self._counting())):
            if controllers is None or part.controller in controllers:
                table = self._rows(part, counts, data_set, stored)
                of_all = pa.repeat(pa.scalar(part.controller, pa.string()), table.num_rows)
                tables.append(table.append_column(schema.field(PARTITION), of_all).select(wanted.names))
        return pa.concat_tables(tables)

    def _of(
        self, hashes: Collection[str] | None, counting: list[tuple[ResultPart, Counts]]
    ) -> list[tuple[ResultPart, Counts]]:
        """Return the parts with, of what counts in them, the rows of some units alone; unless given, of all."""
        if hashes is None:
            return counting
        known = ((part, zip(counts, self._known[part].hashes, strict=True)) for part, counts in counting)
        return [(part, [yes and sha256 in hashes for yes, sha256 in rows]) for part, rows in known]

    def _having(
        self, data_set: DataSet, counting: Iterable[tuple[ResultPart, Counts]]
    ) -> Iterator[tuple[ResultPart, Counts]]:
        """Yield the parts of `units` or `errors` with which rows of a data set were written that count."""
        for part, counts in counting:
            if any(counts) and data_set in (part.data_set, *self._known[part].beside):
                yield part, counts

    def _rows(self, part: ResultPart, counts: Counts, data_set: DataSet, columns: Sequence[str]) -> pa.Table:
        """Return the rows of a data set that count, of the units in a part of `units` or `errors`."""
        table, _ = self._read(part.of(data_set), [HASH, *(name for name in columns if name != HASH)])
        if not all(counts):
            hashes = pa.array(compress(self._known[part].hashes, counts), pa.string())
            table = table.filter(pc.is_in(table[HASH], value_set=hashes))
        return table

    def _read(self, part: ResultPart, columns: Sequence[str]) -> tuple[pa.Table, tuple[DataSet, ...]]:
        try:
            return read_part(self.folder, part, columns)
        except FileNotFoundError:
            raise
        except DAMAGE as error:
            raise self._damaged(part.under(self.folder), error) from error

    def _damaged(self, path: Path, error: Exception) -> FleetError:
        """Return the error of a part that cannot be read; without the one by which it counts, its units are undone."""
        counting = "errors" if path.is_relative_to(self.folder / "errors") else "units"
        undone = self.folder / counting / path.parent.name / path.name
        expected = Sentence(
            "a part as it was written: once {path} is deleted, the next run evaluates its units anew", path=str(undone)
        )
        return FleetError(damaged(error).problem, place=Place(file=str(path)), expected=expected)

    def _commit(self, batch: Mapping[ResultPart, Iterable[pa.Table]]) -> None:
        """Write the parts of a batch, all or none of them; those by which the others count stand last in it."""
        written: list[ResultPart] = []
        try:
            for part, tables in batch.items():
                beside: list[DataSet] = []
                if part.data_set in COMMITTING:
                    settle({each.under(self.folder).parent for each in written})
                if part.data_set == "units":
                    beside = [each.data_set for each in written if each == part.of(each.data_set)]
                written.append(part)
                write_part(self.folder, part, tables, beside)
        except BaseException:
            self._remove(reversed(written))
            raise

    def _rewrite(self, counting: Sequence[tuple[ResultPart, Counts]]) -> None:
        """Write what counts of some parts of `units` or `errors` as one, with what belongs to them, and remove them."""
        first, _ = counting[0]
        merged = ResultPart(self._next_name(), first.folder, first.data_set)
        batch = {
            merged.of(data_set): self._all_rows(data_set, counting)
            for data_set in (*BESIDE_UNITS, merged.data_set)
            if any(self._having(data_set, counting))
        }
        self._commit(batch)
        self._remove(part for part, _ in counting)

    def _all_rows(self, data_set: DataSet, counting: Iterable[tuple[ResultPart, Counts]]) -> Iterator[pa.Table]:
        for part, counts in self._having(data_set, counting):
            yield self._rows(part, counts, data_set, columns_of(data_set).names)

    def _remove(self, parts: Iterable[ResultPart]) -> None:
        """Remove parts as far as that is possible: one that another program holds open stays, and does not count."""
        for part in parts:
            with contextlib.suppress(OSError):
                part.under(self.folder).unlink()


def _remove_counting(path: Path) -> None:
    """Remove a part that counts as long as it is there: beside results of another version, that is never to be."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        problem = Sentence("cannot be removed: {reason}", reason=reason_of(error))
        expected = Sentence("a file that no other program has open")
        raise OutputError(problem, place=Place(file=str(path)), expected=expected) from error


def _last_of_each(rows: Sequence[Rows]) -> list[Rows]:
    """Return the rows of every unit that were given last."""
    by_hash = {each.input_sha256: each for each in rows}
    by_reference = {each.reference: each for each in rows}
    return [each for each in rows if by_hash[each.input_sha256] is by_reference[each.reference] is each]


def _to_rewrite(counting: Iterable[tuple[ResultPart, Counts]]) -> Iterator[list[tuple[ResultPart, Counts]]]:
    """Yield the parts that are better written as one: several small ones, and any of which not every row counts."""
    loose: dict[tuple[DataSet, str], list[tuple[ResultPart, Counts]]] = {}
    for part, counts in counting:
        if sum(counts) < _SMALL or not all(counts):
            loose.setdefault((part.data_set, part.folder), []).append((part, counts))
    for parts in loose.values():
        group: list[tuple[ResultPart, Counts]] = []
        for number, (part, counts) in enumerate(parts, 1):
            group.append((part, counts))
            if number == len(parts) or sum(sum(each) for _, each in group) >= _SMALL:
                if len(group) > 1 or not all(group[0][1]):
                    yield group
                group = []
