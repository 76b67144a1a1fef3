"""Reads the tables of Parquet files (pyarrow) in the child process, block by block."""

from __future__ import annotations

import io
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from atleak.common.sentences import Sentence
from atleak.readers.process.child import Damaged, Refused, of_library

ParquetPart = tuple[str, Any]

_BLOCK = 1 << 24  # bytes of numbers that are handed over together
_BUFFER = 1 << 20  # bytes of a column that are read from the file at once
_FEWEST = 1 << 10  # rows of a block
_TYPE_SHOWN = 100  # characters
_UNITS = ("unit", "units", "uom", "einheit", "jednostka")
_INDEX = "__index_level_"
_NOT = -(1 << 63)  # the stamp of a blank cell


def parquet_parts(
    source: bytes | str,
    columns: Sequence[int] = (),  # their places among all; none: only what the file says of itself is wanted
    limit: int | None = None,  # bytes of numbers beyond which a table is refused before it is read; None: no limit
    rows: int | None = None,  # how many of the first rows are enough; None: all
) -> Iterator[ParquetPart]:
    """Yield what a Parquet file holds, part by part.

    ``table`` with its ``rows`` and its ``columns``: of each the ``name``, the ``unit`` that the file states or None,
    and its ``kind``. Then ``block`` after ``block`` of rows, a list with the cells of every column that is
    asked for, by its kind: of ``number`` the bytes of floats, NaN where a cell is blank; of ``stamp`` those of whole
    numbers (int64), nanoseconds since 1970 in UTC; of ``text`` the list of the different texts, and the bytes of each
    cell's place among them (int32), -1 where it is blank.
    """
    with _opened(source) as file:
        with of_library():
            schema, count = file.schema_arrow, file.metadata.num_rows
        left_out = _twice(schema)
        places = [place for place in range(len(schema)) if place not in left_out]
        yield "table", {"rows": count, "columns": [_described(schema.field(place)) for place in places]}
        if not columns:
            return
        if limit is not None and count * len(columns) * 8 > limit:
            problem = Sentence("unfolds to {rows} rows of {columns} columns", rows=count, columns=len(columns))
            raise Refused(problem, expected=Sentence("at most {size} MB of numbers", size=limit >> 20))
        wanted = [places[column] for column in columns]
        names = [schema.names[place] for place in wanted]
        keys = [(name, schema.names[:place].count(name)) for name, place in zip(names, wanted, strict=True)]
        batches = _batches(file, max(_BLOCK // 8 // len(columns), _FEWEST) if rows is None else rows, names)
        left = count
        while True:
            with of_library():
                batch = next(batches, None)
                cells = [] if batch is None else [_cells(each) for each in _columns(batch, keys)]
            left -= 0 if batch is None else batch.num_rows
            if left < 0 or (batch is None and left):
                raise Damaged(f"it has {count - left} rows and says {count}")
            if batch is None:
                return
            yield "block", cells
            if rows is not None:
                return


def _batches(file: Any, length: int, names: Sequence[str]) -> Iterator[Any]:
    """Yield the rows of a file, some groups of them at a time: what reads groups keeps something of each."""
    import pyarrow as pa

    groups: list[int] = []
    rows = 0
    for group in range(file.num_row_groups):
        groups.append(group)
        rows += file.metadata.row_group(group).num_rows
        if rows >= length or group + 1 == file.num_row_groups:
            yield from file.iter_batches(length, groups, columns=names, use_threads=False)
            pa.default_memory_pool().release_unused()
            groups, rows = [], 0


def parquet_head(source: bytes | str, rows: int) -> Iterator[bytes]:
    """Yield the bytes of a Parquet file with the same columns, what is said of them, and the first rows alone."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with _opened(source) as file, of_library():
        head = next(file.iter_batches(rows, use_threads=False), None)
        target = io.BytesIO()
        pq.write_table(pa.Table.from_batches([] if head is None else [head], file.schema_arrow), target)
    yield target.getvalue()


@contextmanager
def _opened(source: bytes | str) -> Iterator[Any]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pa.set_memory_pool(pa.system_memory_pool())  # the others keep what they once had
    with of_library():  # pyarrow itself opens no path that is not UTF-8
        stream = io.BytesIO(source) if isinstance(source, bytes) else open(source, "rb")  # noqa: SIM115, PTH123
    with stream:
        with of_library():
            file = pq.ParquetFile(stream, buffer_size=_BUFFER, pre_buffer=False)
        with file:
            yield file


def _columns(batch: Any, keys: Sequence[tuple[str, int]]) -> list[Any]:
    """Return columns of a block by their names, and how many of the same name stand before.

    Where ``a`` is asked for, some versions of pyarrow also bring ``a.b``.
    """
    names: list[str] = batch.schema.names
    places: dict[tuple[str, int], int] = {}
    counts: Counter[str] = Counter()
    for place, name in enumerate(names):
        places[name, counts[name]] = place
        counts[name] += 1
    return [batch.column(places[key]) for key in keys]


def _twice(schema: Any) -> set[int]:
    """Return the places of index columns of pandas whose values another column holds."""
    with suppress(ValueError, LookupError, TypeError):
        pandas = json.loads((schema.metadata or {}).get(b"pandas", b"{}"))
        names = {each["field_name"]: each["name"] for each in pandas["columns"]}
        columns = {name for name in schema.names if not name.startswith(_INDEX)}
        return {at for at, name in enumerate(schema.names) if name not in columns and names.get(name) in columns}
    return set()


def _described(field: Any) -> dict[str, Any]:
    """Return what is known of a column."""
    metadata = {key.decode("utf-8", "replace").strip().lower(): value for key, value in (field.metadata or {}).items()}
    unit = next((metadata[key].decode("utf-8", "replace").strip() for key in _UNITS if key in metadata), "")
    kind = _kind(_plain(field.type))
    if kind is None:
        text = Sentence("its column {column!r} holds several values in a cell ({type})")
        expected = Sentence("columns of numbers, texts or times, with one value in a cell")
        raise Refused(text.of(column=field.name, type=str(field.type)[:_TYPE_SHOWN]), expected=expected)
    return {"name": field.name, "unit": unit or None, "kind": kind}


def _plain(kind: Any) -> Any:
    """Return the type of the values themselves."""
    import pyarrow as pa

    while True:
        if isinstance(kind, pa.BaseExtensionType):
            kind = kind.storage_type
        elif pa.types.is_dictionary(kind) or pa.types.is_run_end_encoded(kind):
            kind = kind.value_type
        else:
            return kind


def _kind(kind: Any) -> str | None:
    import pyarrow as pa

    types = pa.types
    if types.is_timestamp(kind) or types.is_date(kind):
        return "stamp"
    numbers = ("null", "boolean", "integer", "floating", "decimal", "duration")
    if any(getattr(types, f"is_{number}")(kind) for number in numbers):
        return "number"
    return None if types.is_nested(kind) else "text"


def _cells(array: Any) -> Any:
    """Return the cells of a column in a block, by their kind."""
    import pyarrow as pa

    types = pa.types
    while True:
        if isinstance(array.type, pa.BaseExtensionType):
            array = array.storage
        elif types.is_dictionary(array.type):
            array = array.dictionary_decode()
        else:
            break
    kind = _kind(array.type)
    if kind == "stamp":
        stamps = array.cast(pa.timestamp("ns", getattr(array.type, "tz", None))).cast(pa.int64())
        return bytearray(stamps.fill_null(_NOT).to_numpy(zero_copy_only=False))
    if kind == "text":
        return _texts(array)
    if types.is_duration(array.type):
        scale = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[array.type.unit]
        return bytearray(_floats(array.cast(pa.int64())) / scale)
    return bytearray(_floats(array))


def _floats(array: Any) -> Any:
    import numpy as np
    import pyarrow as pa

    if pa.types.is_boolean(array.type):
        array = array.cast(pa.int8())
    if not pa.types.is_float16(array.type):  # which not every version of pyarrow casts
        array = array.cast(pa.float64(), safe=False)
    return np.ascontiguousarray(array.to_numpy(zero_copy_only=False), np.float64)


def _texts(array: Any) -> tuple[list[str], bytearray]:
    import numpy as np
    import pyarrow as pa

    if pa.types.is_time(array.type):
        array = array.cast(pa.string())
    distinct = array.dictionary_encode()
    cells = distinct.dictionary.to_pylist()
    texts = [each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each) for each in cells]
    codes = distinct.indices.fill_null(-1).to_numpy(zero_copy_only=False)
    return texts, bytearray(np.ascontiguousarray(codes, np.int32))
