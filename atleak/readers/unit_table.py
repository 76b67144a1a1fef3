"""Read a table of units from text, workbook or Parquet: one row for each, with its files and what is known of it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, cached_property
from itertools import islice
from pathlib import Path

from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Place, ReadingsError, reason_of
from atleak.common.sentences import Sentence
from atleak.readers.cells.extent import EXPECTED
from atleak.readers.cells.sheet import NO_WIDTH, Cell
from atleak.readers.dates import vocabulary, words
from atleak.readers.logs.log_file import form_of
from atleak.readers.logs.text_lines import to_text
from atleak.readers.sheets.head import identity_field

_NEAR = 0.8  # of the letters of two headings that are taken for the same
_SHORT = 4  # letters: shorter ones are near to anything
UNCLEAR = "unclear"  # the meaning of a heading that can be understood in two ways: nothing is guessed
# what a unit is diagnosed by: the columns of which a row fills at least one
MEASURED = ("job_file", "readings", "road_test", "pressures", "vacuum", "flows")
# fields of the head of a measuring sheet, and the column that holds the same
_OF_HEAD = {"job": "number", "vin": "vin", "serial": "serial", "mileage": "mileage", "technician": "technician"}


@cache
def _names() -> Mapping[str, str]:
    return {words(name): column for column, name in spellings()}


def spellings() -> Iterator[tuple[str, str]]:
    """Yield every column with a heading that it may have, the English ones first."""
    for column, by_language in vocabulary(__package__, "unit_vocabulary.toml").items():
        yield from ((column, name) for names in by_language.values() for name in names)


def nearest_heading(heading: str) -> str | None:
    """Return the known heading that one which is none may be a misspelling of; None where none is near.

    >>> nearest_heading("Schieberkastn"), nearest_heading("Straßenfahrt"), nearest_heading("Batch")
    ('Schieberkasten', None, None)
    """
    written = {words(name): name for _, name in spellings()}
    heading_words = words(heading)
    near = get_close_matches(heading_words, [name for name in written if len(name) >= _SHORT], n=1, cutoff=_NEAR)
    return written[near[0]] if near and len(heading_words) >= _SHORT else None


def column_meant(heading: str) -> str | None:
    """Return the column that a heading stands for, `UNCLEAR`, or None: a column of the table's own.

    >>> column_meant("Messblatt"), column_meant("road_test"), column_meant("Laufleistung [km]"), column_meant("Batch")
    ('readings', 'road_test', 'mileage', None)
    """
    named = _names().get(words(heading))
    return named or _OF_HEAD.get(identity_field(heading) or "")


SUFFIXES = (".csv", ".tsv", ".txt", ".parquet", ".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")  # of such a table's file
_ROWS, _COLUMNS, _SIZE = 1_000_000, 300, 256 << 20  # bytes, at most
_INDEX = "__index_level_"  # a column in which pandas writes the numbers of its rows
_DELIMITERS = ";\t,|"
_LOOKED_AT = 20  # rows among which the headings are sought: titles may stand above them
_EXPECTED = Sentence(
    "a row of headings over one row for each unit, with a column of measuring sheets (sheet), logs (log), gauge "
    "readings (pressures), vacuum tests (vacuum), flows (flows) or job files (job file)"
)
_KINDS = Sentence("a table of units as CSV, xlsx or Parquet")


@dataclass(frozen=True)
class TableColumn:
    """A column: its heading as it is written, and the part of a job that it stands for; None for one of its own."""

    heading: str
    meaning: str | None


@dataclass(frozen=True)
class TableRow:
    """A row: its number in the file, and its cells by the headings' places; empty ones are ""."""

    number: int
    cells: Sequence[Cell]


@dataclass(frozen=True)
class UnitTable:
    """A table of units as it was read."""

    file: str
    sheet: str | None  # of a workbook
    columns: tuple[TableColumn, ...]
    rows: tuple[TableRow, ...]  # but for those that are empty

    @cached_property
    def by_meaning(self) -> Mapping[str, int]:
        """Return the place of every column that stands for a part of a job."""
        return {column.meaning: place for place, column in enumerate(self.columns) if column.meaning is not None}

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the headings of the table's own columns."""
        return tuple(column.heading for column in self.columns if column.meaning is None and column.heading)

    def cell(self, row: TableRow, meaning: str) -> Cell:
        """Return what a row says of a part of a job; "" where it says nothing."""
        place = self.by_meaning.get(meaning)
        return "" if place is None or place >= len(row.cells) else row.cells[place]

    def place(self, row: TableRow, meaning: str | None = None) -> Place:
        """Return where a row, or what it says of a part of a job, stands."""
        at = None if meaning is None else self.by_meaning.get(meaning)
        return Place(self.file, self.sheet, row.number, None if at is None else self.columns[at].heading)


def is_unit_table(path: Path, head: bytes) -> bool:
    """Tell whether a file may be a table of units, by the ending of its name and its first bytes."""
    return path.suffix.lower() in SUFFIXES or form_of(head) == "parquet"


@own_errors_only(InputError, "path")
def read_unit_table(path: Path) -> UnitTable:
    """Read a table of units; an `InputError` says why a file is none, or which of its headings is not clear."""
    try:
        if path.stat().st_size > _SIZE:
            problem, expected = Sentence("too large"), Sentence("at most {size} MB", size=_SIZE >> 20)
            raise InputError(problem, place=Place(path.name), expected=expected)
        data = path.read_bytes()
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise InputError(problem, place=Place(str(path)), expected=_KINDS) from error
    if not data.strip(b"\0 \t\r\n\xef\xbb\xbf"):
        raise InputError(Sentence("the file is empty"), place=Place(path.name), expected=_EXPECTED)
    read = {"parquet": _parquet, "workbook": _workbook}.get(form_of(data), _text)
    sheet, rows = read(data, path.name)
    place = Place(path.name, sheet)
    header = _headings(rows)
    if header is None:
        first = next((cells for _, cells in rows if any(map(_said, cells))), ())
        value = ", ".join(_said(cell) for cell in first if _said(cell))[:200] or None
        problem = Sentence("no headings of a table of units are found")
        raise InputError(problem, place=place, value=value, expected=_EXPECTED)
    at, columns = header
    _check_columns(columns, Place(path.name, sheet, rows[at][0]))
    below = [TableRow(number, cells) for number, cells in rows[at + 1 :] if any(map(_said, cells))]
    if not below:
        raise InputError(Sentence("no row stands under the headings"), place=place, expected=_EXPECTED)
    if len(below) > _ROWS:
        problem, expected = Sentence("holds too many rows"), Sentence("at most {count}", count=_ROWS)
        raise InputError(problem, place=place, value=len(below), expected=expected)
    return UnitTable(path.name, sheet, columns, tuple(below))


_Rows = list[tuple[int, Sequence[Cell]]]  # each with its number in the file


def _headings(rows: _Rows) -> tuple[int, tuple[TableColumn, ...]] | None:
    """Return the row of the headings and what they mean: the first that has one of what units are diagnosed by."""
    for at, (_, cells) in enumerate(rows[:_LOOKED_AT]):
        columns = tuple(TableColumn(_said(cell), column_meant(_said(cell))) for cell in cells)
        if any(column.meaning in MEASURED for column in columns):
            return at, columns
    return None


def _check_columns(columns: Sequence[TableColumn], place: Place) -> None:
    if len(columns) > _COLUMNS:
        problem, expected = Sentence("holds too many columns"), Sentence("at most {count}", count=_COLUMNS)
        raise InputError(problem, place=place, value=len(columns), expected=expected)
    seen: dict[str, str] = {}
    for column in columns:
        key = column.heading.casefold() if column.meaning is None else column.meaning
        where = Place(place.file, place.sheet, place.row, column.heading or None)
        if column.meaning == UNCLEAR:
            expected = Sentence("'measuring temperature', or 'stated temperature' for that of the fluid")
            raise InputError(Sentence("this heading can be understood in two ways"), place=where, expected=expected)
        if key and key in seen:
            problem = Sentence("says the same as the column {other}", other=seen[key])
            raise InputError(problem, place=where, expected=Sentence("one column for each thing"))
        seen[key] = column.heading


def _said(cell: Cell) -> str:
    return "" if cell is None else str(cell).translate(NO_WIDTH).strip()


def _text(data: bytes, file: str) -> tuple[None, _Rows]:
    """Read text: of the signs that may stand between columns, that by which most headings are understood."""
    text = to_text(data)
    content = text.decode(text.data)
    first = content[:8].lower().lstrip('"')
    stated = first[4] if first.startswith("sep=") and first[4:5] and first[4] in _DELIMITERS else None

    def understood(delimiter: str) -> int:
        header = _headings(list(_records(content, delimiter, _LOOKED_AT)))
        return 0 if header is None else sum(column.meaning is not None for column in header[1])

    best = stated or max(_DELIMITERS, key=understood)
    rows = list(_records(content, best, _ROWS + _LOOKED_AT + 1))
    return None, rows[1:] if stated else rows


def _records(content: str, delimiter: str, most: int) -> Iterator[tuple[int, Sequence[Cell]]]:
    records = islice(csv.reader(io.StringIO(content, newline=""), delimiter=delimiter), most)
    yield from ((number, [cell.strip() for cell in record]) for number, record in enumerate(records, start=1))


def _workbook(data: bytes, file: str) -> tuple[str | None, _Rows]:
    """Read a workbook: of its sheets the first that is not hidden and has headings that are understood."""
    from atleak.readers.cells.sheet_file import read_sheets

    try:
        sheets = [sheet for sheet in read_sheets(data, file, lambda _: 0.0) if not sheet.hidden]
    except ReadingsError as error:
        expected = Sentence("a table of so many units as CSV or Parquet") if error.expected == EXPECTED else _KINDS
        raise InputError(error.problem, place=error.place, value=error.value, expected=expected) from error
    tables = [(sheet.name, list(enumerate(sheet.rows, start=1))) for sheet in sheets]
    return next((table for table in tables if _headings(table[1])), tables[0] if tables else (None, []))


def _parquet(data: bytes, file: str) -> tuple[None, _Rows]:
    """Read Parquet, whose rows are counted from 1 and whose headings stand in none of them."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        source = pq.ParquetFile(io.BytesIO(data))
        if source.metadata.num_rows > _ROWS or source.metadata.num_columns > _COLUMNS:
            expected = Sentence("at most {rows} rows and {columns} columns", rows=_ROWS, columns=_COLUMNS)
            raise InputError(Sentence("too large"), place=Place(file), expected=expected)
        table = source.read()
    except pa.ArrowException as error:
        problem = Sentence("is no sound Parquet file: {reason}", reason=str(error)[:200])
        raise InputError(problem, place=Place(file), expected=_KINDS) from error
    table = table.select([name for name in table.column_names if not name.startswith(_INDEX)])
    # empty cells are None, or NaN as pandas writes them
    columns = [
        ["" if value is None or value != value else value for value in each.to_pylist()] for each in table.columns
    ]
    rows: _Rows = [(0, table.column_names)]
    rows += [(number, cells) for number, cells in enumerate(zip(*columns, strict=True), start=1)]
    return None, rows
