"""Remembers which columns a workshop chose for a log, by the signature of the log's header."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from atleak.errors import OutputError, Place
from atleak.intake.plain_words import words
from atleak.sentence import Sentence
from atleak.system.files import PRIVATE, replace_file
from atleak.system.home import earlier_file, home, made
from atleak.system.reasons import reason_of

_PATIENCE = 30  # [s] to wait for other writers
_POLL = 0.01  # [s]


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
            replace_file(made(path.parent) / path.name, earlier.read_bytes(), mode=PRIVATE)
        except (OutputError, OSError):
            return earlier
    return path


def recall(path: Path, header: str) -> RememberedColumns | None:
    """Return the choices kept for a header's signature, or None. A damaged file counts as empty."""
    return _understood(_readable(path).get(header)) if header else None


def recall_all(path: Path) -> dict[str, RememberedColumns]:
    """Return everything that is kept, by the header's signature, the latest first."""
    kept = {header: _understood(entry) for header, entry in _readable(path).items()}
    good = [(header, entry) for header, entry in kept.items() if entry is not None]
    return dict(sorted(good, key=lambda pair: pair[1].when, reverse=True))


def _understood(entry: object) -> RememberedColumns | None:
    if not isinstance(entry, dict):
        return None
    mapping, units, columns = entry.get("mapping"), entry.get("units"), entry.get("columns")
    if not isinstance(mapping, dict) or not isinstance(units, dict):
        return None
    return RememberedColumns(
        _texts(mapping),
        _texts(units),
        str(entry.get("format", "")),
        tuple(map(str, columns)) if isinstance(columns, list) else (),
        str(entry.get("when", "")),
    )


def _texts(part: Mapping[Any, Any]) -> dict[str, str]:
    return {str(key): str(value) for key, value in part.items()}


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
    format, columns
        of the log, so that people recognise what is remembered: its format and the names of its columns.

    Raises
    ------
    OutputError
        where the log has no header, or the file cannot be written.
    """
    if not header:
        raise OutputError(Sentence("the log names no columns by which others like it could be told"))
    now = dt.datetime.now(dt.UTC).isoformat(timespec="seconds")
    restore(path, header, RememberedColumns(dict(mapping), dict(units or {}), format, tuple(columns), now))


def restore(path: Path, header: str, entry: RememberedColumns) -> None:
    """Keep choices as they were before they were forgotten.

    Raises
    ------
    OutputError
        where the file cannot be written.
    """
    with _rewritten(path) as entries:
        entries[header] = {**vars(entry), "columns": list(entry.columns)}


def forget(path: Path, header: str) -> None:
    """Delete the choices kept for a header's signature.

    Raises
    ------
    OutputError
        where the file cannot be written.
    """
    if header in _readable(path):
        with _rewritten(path) as entries:
            entries.pop(header, None)


@contextmanager
def _rewritten(path: Path) -> Iterator[dict[str, object]]:
    """Yield the entries of the file to be changed, then write them; no other process or thread writes meanwhile."""
    from filelock import FileLock, Timeout  # 40 ms, and most runs remember nothing

    place = Place(file=str(path))
    lock = FileLock(path.with_suffix(".lock"), timeout=_PATIENCE, mode=PRIVATE)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with lock.acquire(poll_interval=_POLL):
            entries = _load(path)
            yield entries
            replace_file(
                path,
                json.dumps(entries, ensure_ascii=False, indent=1).encode("utf-8", "backslashreplace"),
                mode=PRIVATE,
            )
    except Timeout:
        problem = Sentence("another program has kept it locked for {seconds} s", seconds=_PATIENCE)
        raise OutputError(problem, place=place) from None
    except (OSError, NotImplementedError) as error:  # the latter: a file system without locks
        reason = reason_of(error) if isinstance(error, OSError) and error.strerror else str(error)
        problem = Sentence("cannot be written: {reason}", reason=reason)
        raise OutputError(problem, place=place) from error


def _readable(path: Path) -> dict[str, object]:
    """Return the entries of the file; none where it cannot be read."""
    try:
        return _load(path)
    except OSError:
        return {}


def _load(path: Path) -> dict[str, object]:
    """Return the entries of the file; none where it does not exist or is damaged."""
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError, RecursionError):
        return {}
    return entries if isinstance(entries, dict) else {}
