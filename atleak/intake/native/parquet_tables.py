"""Reads the tables of Parquet files (pyarrow) in the child process, block by block."""

from __future__ import annotations

import io
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from atleak.intake.native.child import Damaged, Refused, of_library
from atleak.sentence import Sentence

ParquetPart = tuple[str, Any]

_BLOCK = 1 << 24  # bytes of numbers that are handed over together
_BUFFER = 1 << 20  # bytes of a column that are read from the file at once
_FEWEST = 1 << 10  # rows of a block
_TYPE_SHOWN = 100  # characters
_UNITS = ("unit", "units", "uom", "einheit", "jednostka")
_INDEX = "__index_level_"
_NOT = -(1 << 63)  # the stamp of a blank cell


def parquet_parts(request: bytes) -> Iterator[ParquetPart]:
    """Yield what a Parquet file holds, part by part.

    ``table`` with its ``rows`` and its ``columns``: of each the ``name``, the ``unit`` that the file states or None,
    and its ``kind``. Then ``block`` after ``block`` of rows, a list with the cells of every column that is
    asked for, by its kind: of ``number`` the bytes of floats, NaN where a cell is blank; of ``stamp`` those of whole
    numbers (int64), nanoseconds since 1970 in UTC; of ``text`` the list of the different texts, and the bytes of each
    cell's place among them (int32), -1 where it is blank.

    Parameters
    ----------
    request
        what `request_of` makes.
    """
    with _opened(request) as (asked, file):
        with of_library():
            schema, rows = file.schema_arrow, file.metadata.num_rows
        left_out = _twice(schema)
        fields = [field for place, field in enumerate(schema) if place not in left_out]
        columns = [_described(field) for field in fields]
        yield "table", {"rows": rows, "columns": columns}
        wanted: Sequence[int] = asked["columns"]
        if not wanted:
            return
        limit = asked["limit"]
        if limit is not None and rows * len(wanted) * 8 > limit:
            problem = Sentence("unfolds to {rows} rows of {columns} columns", rows=rows, columns=len(wanted))
            raise Refused(problem, expected=Sentence("at most {size} MB of numbers", size=limit >> 20))
        names = [fields[place].name for place in wanted]
        numbers = [place for place in range(len(schema)) if place not in left_out]
        chosen = [(schema.names[numbers[place]], schema.names[: numbers[place]]) for place in wanted]
        keys = [(name, before.count(name)) for name, before in chosen]
        length = max(_BLOCK // 8 // len(wanted), _FEWEST)
        first = asked["rows"]
        batches = _batches(file, length if first is None else first, names)
        left = rows
        while True:
            with of_library():
                batch = next(batches, None)
                cells = [] if batch is None else [_cells(each) for each in _columns(batch, keys)]
            left -= 0 if batch is None else batch.num_rows
            if left < 0 or (batch is None and left):
                raise Damaged(f"it has {rows - left} rows and says {rows}")
            if batch is None:
                return
            yield "block", cells
            if first is not None:
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


def parquet_head(request: bytes) -> Iterator[bytes]:
    """Yield the bytes of a Parquet file with the same columns, what is said of them, and the first rows alone."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with _opened(request) as (asked, file), of_library():
        rows = next(file.iter_batches(asked["rows"], use_threads=False), None)
        target = io.BytesIO()
        pq.write_table(pa.Table.from_batches([] if rows is None else [rows], file.schema_arrow), target)
    yield target.getvalue()


@contextmanager
def _opened(request: bytes) -> Iterator[tuple[dict[str, Any], Any]]:
    """Give what is asked for, and the file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    header, _, content = request.partition(b"\n")
    asked = json.loads(header)
    pa.set_memory_pool(pa.system_memory_pool())  # the others keep what they once had
    with of_library():  # pyarrow itself opens no path that is not UTF-8
        source = io.BytesIO(content) if asked["path"] is None else open(asked["path"], "rb")  # noqa: SIM115, PTH123
    with source:
        with of_library():
            file = pq.ParquetFile(source, buffer_size=_BUFFER, pre_buffer=False)
        with file:
            yield asked, file


def request_of(
    content: bytes | None, path: str | None, columns: Sequence[int], *, limit: int | None, rows: int | None = None
) -> bytes:
    """Return the request for some columns of a Parquet file.

    Parameters
    ----------
    content
        the file's bytes; None where it is to be read from ``path``, in full.
    columns
        their places among all; none: only what the file says of itself is wanted.
    limit
        bytes of numbers beyond which a table is refused before it is read; None: it is handed over block by block.
    rows
        how many of the first rows are enough; None: all.
    """
    header = json.dumps({"path": path, "columns": list(columns), "limit": limit, "rows": rows})
    return header.encode("ascii") + b"\n" + (content or b"")


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
    try:
        told = json.loads((schema.metadata or {}).get(b"pandas", b"{}"))
        names = {each["field_name"]: each["name"] for each in told["columns"]}
    except (ValueError, LookupError, TypeError):
        return set()
    columns = {field.name for field in schema if not field.name.startswith(_INDEX)}
    return {
        place
        for place, field in enumerate(schema)
        if field.name.startswith(_INDEX) and names.get(field.name) in columns
    }


def _described(field: Any) -> dict[str, Any]:
    """Return what is known of a column.

    Raises
    ------
    Refused
        where its cells hold several values each.
    """
    told = {key.decode("utf-8", "replace").strip().lower(): value for key, value in (field.metadata or {}).items()}
    unit = next((told[key].decode("utf-8", "replace").strip() for key in _UNITS if key in told), "")
    kind = _kind(_plain(field.type))
    if kind is None:
        said = {"column": field.name, "type": str(field.type)[:_TYPE_SHOWN]}
        raise Refused(
            Sentence("its column {column!r} holds several values in a cell ({type})", **said),
            expected=Sentence("columns of numbers, texts or times, with one value in a cell"),
        )
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
    if types.is_null(kind) or types.is_boolean(kind) or types.is_integer(kind) or types.is_floating(kind):
        return "number"
    if types.is_decimal(kind) or types.is_duration(kind):
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
    texts = [
        each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each)
        for each in distinct.dictionary.to_pylist()
    ]
    codes = distinct.indices.fill_null(-1).to_numpy(zero_copy_only=False)
    return texts, bytearray(np.ascontiguousarray(codes, np.int32))
