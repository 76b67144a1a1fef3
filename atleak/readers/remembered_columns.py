"""Remembers which columns a workshop chose for a log or a measuring sheet, by the signature of its headings."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from atleak.common.errors import InputError, Message, OutputError, Place, reason_of
from atleak.common.files import PRIVATE, earlier_file, home, made_folder, readable, replace_file, rewritten
from atleak.common.sentences import Sentence
from atleak.readers.dates import words

_SETTLED_EARLIER = Sentence(
    "columns are taken as settled earlier for files with these headings; 'Remembered columns' or --forget ends that"
)
_SETTLED_ON = Sentence(
    "columns are taken as settled on {date} for files with these headings; 'Remembered columns' or --forget ends that"
)
NOT_LOGGED = ""  # in place of a column: the user says that no column holds the quantity
CONSTANT = "="  # in front of what holds for all rows of a sheet, in place of a column


@dataclass(frozen=True)
class RememberedColumns:
    """The user's choices for a header: quantity or role → column (`NOT_LOGGED` for none), and → unit.

    ``format``, ``columns`` and ``when`` (UTC, ISO 8601) say of which files, and since when; what versions before 0.2.0
    remembered has none of them.
    """

    mapping: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    format: str = field(default="", repr=False, compare=False)
    columns: tuple[str, ...] = field(default=(), repr=False, compare=False)
    when: str = field(default="", repr=False, compare=False)

    @property
    def note(self) -> Message:
        """Return what is said first of a file that was read with it: since when, and how to undo it."""
        if not self.when:
            return Message("info", "remembered", _SETTLED_EARLIER)
        date = dt.datetime.fromisoformat(self.when).date()
        return Message("info", "remembered", _SETTLED_ON.of(date=date))


def signature(labels: Iterable[str]) -> str:
    """Return a header's signature: the same for every log with these column names in this order.

    A log whose header names no column has none, "": nothing is remembered for it, since logs of any logger look so.

    >>> signature(["Time (s)", "RPM"]) == signature(["time (s) ", "rpm"])
    True
    """
    text = "\x1f".join(words(label) for label in labels)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:16]


def default_path() -> Path:
    """Return where the choices are kept: in the user's folder, into which a file of version 0.1.0 is taken over once.

    Where that file cannot be copied, it stays the one that is used.
    """
    path = home() / "road-test-columns.json"
    earlier = None if path.exists() else earlier_file(path.name)
    if earlier is not None:
        try:
            replace_file(made_folder(path.parent) / path.name, earlier.read_bytes(), mode=PRIVATE)
        except (OutputError, OSError):
            return earlier
    return path


def recall(path: Path, header: str) -> RememberedColumns | None:
    """Return the choices kept for a header's signature, or None. A damaged file counts as empty."""
    return _understood(readable(path).get(header)) if header else None


def recall_all(path: Path) -> dict[str, RememberedColumns]:
    """Return everything that is kept, by the header's signature, the latest first."""
    kept = {header: _understood(entry) for header, entry in readable(path).items()}
    good = [(header, entry) for header, entry in kept.items() if entry is not None]
    return dict(sorted(good, key=lambda pair: pair[1].when, reverse=True))


def _understood(entry: object) -> RememberedColumns | None:
    if not isinstance(entry, dict):
        return None
    mapping, units, columns = entry.get("mapping"), entry.get("units"), entry.get("columns")
    if not isinstance(mapping, dict) or not isinstance(units, dict):
        return None
    mapping, units = ({str(key): str(value) for key, value in part.items()} for part in (mapping, units))
    columns = tuple(map(str, columns)) if isinstance(columns, list) else ()
    return RememberedColumns(mapping, units, str(entry.get("format", "")), columns, str(entry.get("when", "")))


def remember(
    path: Path,
    header: str,
    mapping: Mapping[str, str],
    units: Mapping[str, str] | None = None,
    *,
    format: str = "",
    columns: Iterable[str] = (),
) -> None:
    """Keep the choices for a header's signature from now on; they replace those kept before.

    An `OutputError` says that the file has no header. By ``format`` and ``columns`` people recognise what is kept.
    """
    if not header:
        raise OutputError(Sentence("the file names no columns by which others like it could be told"))
    now = dt.datetime.now(dt.UTC).isoformat(timespec="seconds")
    restore_columns(path, header, RememberedColumns(dict(mapping), dict(units or {}), format, tuple(columns), now))


def restore_columns(path: Path, header: str, entry: RememberedColumns) -> None:
    """Keep choices as they were before they were forgotten."""
    with rewritten(path) as entries:
        entries[header] = {**vars(entry), "columns": list(entry.columns)}


def forget_columns(path: Path, header: str) -> None:
    """Delete the choices kept for a header's signature."""
    if header in readable(path):
        with rewritten(path) as entries:
            entries.pop(header, None)


# --- a file that people share: Frictionless' Table Dialect and Table Schema, with what these lack under our own names

_ROLES, _OWN = "atleak:roles", "atleak"
_MISSING, _NO_HEADER = "missing", "none"  # names of a sheet's mapping that the dialect and the schema hold


@dataclass(frozen=True)
class MapFile:
    """What a mapping file says: which column is what, in which unit, and of which sheet of a workbook."""

    mapping: Mapping[str, str]
    units: Mapping[str, str] = field(default_factory=dict)
    sheet: str | None = None

    def text(self) -> str:
        """Return the file."""
        roles: dict[str, list[str]] = {}
        own = {name: column for name, column in self.mapping.items() if name not in (_MISSING, "header")}
        header = self.mapping.get("header", "")
        for name, column in list(own.items()):
            if column and not column.startswith(CONSTANT) and name not in ("rows", "spool", "sleeve"):
                roles.setdefault(column, []).append(name)
                del own[name]
        first, _, last = header.partition("-")
        rows = list(range(int(first), int(last or first) + 1)) if first.isdigit() else []
        dialect: dict[str, Any] = {"header": header != _NO_HEADER} | ({"headerRows": rows} if rows else {})
        dialect |= {"sheetName": self.sheet} if self.sheet else {}
        missing = [text.strip() for text in self.mapping.get(_MISSING, "").split("|") if text.strip()]
        fields = [{"name": column, "type": "any", _ROLES: names} for column, names in roles.items()]
        content = {
            "dialect": dialect,
            "schema": {"fields": fields, "fieldsMatch": "subset", "missingValues": ["", *missing]},
            _OWN: {"also": own, "units": dict(self.units)},
        }
        return json.dumps(content, ensure_ascii=False, indent=2) + "\n"

    @classmethod
    def read(cls, path: Path) -> MapFile:
        """Read the file; an `InputError` says that it cannot be read, or is no mapping."""
        place = Place(file=path.name)
        try:
            content = json.loads(path.read_text(encoding="utf-8-sig"))
            dialect, schema, own = (content.get(part, {}) for part in ("dialect", "schema", _OWN))
            mapping = {name: str(field["name"]) for field in schema["fields"] for name in field.get(_ROLES, ())}
            mapping |= {str(name): str(text) for name, text in own.get("also", {}).items()}
            units = {str(name): str(unit) for name, unit in own.get("units", {}).items()}
            missing = [str(text) for text in schema.get("missingValues", ()) if text]
            rows = [int(row) for row in dialect.get("headerRows", ())]
            sheet = dialect.get("sheetName")
        except OSError as error:
            raise InputError(Sentence("cannot be read: {reason}", reason=reason_of(error)), place=place) from error
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
            expected = Sentence("the file that --map-file writes: JSON with dialect, schema and its fields")
            raise InputError(Sentence("no mapping of columns"), place=place, expected=expected) from error
        mapping |= {_MISSING: "|".join(missing)} if missing else {}
        mapping |= {"header": f"{rows[0]}-{rows[-1]}"} if rows else {}
        mapping |= {"header": _NO_HEADER} if dialect.get("header") is False else {}
        return cls(mapping, units, None if sheet is None else str(sheet))
