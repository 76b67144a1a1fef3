"""Remembers which columns a workshop chose for a log, by the signature of the log's header."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from atleak.common.errors import OutputError
from atleak.common.files import PRIVATE, earlier_file, home, made_folder, readable, replace_file, rewritten
from atleak.common.sentences import Sentence
from atleak.readers.dates import words

NOT_LOGGED = ""  # in place of a column: the user says that no column holds the quantity


@dataclass(frozen=True)
class RememberedColumns:
    """The user's choices for a header: quantity → column (`NOT_LOGGED` for none), quantity → unit.

    ``format``, ``columns`` and ``when`` (UTC, ISO 8601) say of which logs, and since when; what versions before 0.2.0
    remembered has none of them.
    """

    mapping: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    format: str = field(default="", repr=False, compare=False)
    columns: tuple[str, ...] = field(default=(), repr=False, compare=False)
    when: str = field(default="", repr=False, compare=False)


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
    """Return the choices kept for a header's signature, or None. A damaged file counts as empty.

    Parameters
    ----------
    path
        of the file in which they are kept, such as `default_path`.
    header
        the log's signature, as `Understood.signature`.

    Returns
    -------
    RememberedColumns or None
        columns and units by quantity.
    """
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

    Parameters
    ----------
    path
        of the file in which they are kept.
    header
        the log's signature, as `Understood.signature`.
    mapping
        quantity → column.
    units
        quantity → unit.
    format
        of the log, by which people recognise what is remembered.
    columns
        their names, likewise.

    Raises
    ------
    OutputError
        where the log has no header, or the file cannot be written.
    """
    if not header:
        raise OutputError(Sentence("the log names no columns by which others like it could be told"))
    now = dt.datetime.now(dt.UTC).isoformat(timespec="seconds")
    restore_columns(path, header, RememberedColumns(dict(mapping), dict(units or {}), format, tuple(columns), now))


def restore_columns(path: Path, header: str, entry: RememberedColumns) -> None:
    """Keep choices as they were before they were forgotten.

    Raises
    ------
    OutputError
        where the file cannot be written.
    """
    with rewritten(path) as entries:
        entries[header] = {**vars(entry), "columns": list(entry.columns)}


def forget_columns(path: Path, header: str) -> None:
    """Delete the choices kept for a header's signature.

    Raises
    ------
    OutputError
        where the file cannot be written.
    """
    if header in readable(path):
        with rewritten(path) as entries:
            entries.pop(header, None)
