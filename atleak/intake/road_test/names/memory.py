"""Remembers which columns a workshop chose for a log, by the signature of the log's header."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from atleak.errors import OutputError, Place
from atleak.intake.plain_words import words
from atleak.system.files import PRIVATE, replace_file
from atleak.system.home import earlier_file, home, made

_PATIENCE = 30  # [s] to wait for other writers
_POLL = 0.01  # [s]


@dataclass(frozen=True)
class RememberedColumns:
    """The user's choices for a header: quantity → column, quantity → unit."""

    mapping: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)


def signature(labels: Iterable[str]) -> str:
    """Return a header's signature: the same for every log with these column names in this order.

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
    entry = _readable(path).get(header)
    if not isinstance(entry, dict):
        return None
    mapping, units = entry.get("mapping"), entry.get("units")
    if not isinstance(mapping, dict) or not isinstance(units, dict):
        return None
    return RememberedColumns(_texts(mapping), _texts(units))


def _texts(part: Mapping[Any, Any]) -> dict[str, str]:
    return {str(key): str(value) for key, value in part.items()}


def remember(path: Path, header: str, mapping: Mapping[str, str], units: Mapping[str, str] | None = None) -> None:
    """Keep the choices for a header's signature; they replace those kept before.

    Raises
    ------
    OutputError
        where the file cannot be written.
    """
    with _rewritten(path) as entries:
        entries[header] = {"mapping": dict(mapping), "units": dict(units or {})}


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
            replace_file(path, json.dumps(entries, ensure_ascii=False, indent=1).encode("utf-8"), mode=PRIVATE)
    except Timeout:
        raise OutputError(f"another program has kept it locked for {_PATIENCE} s", place=place) from None
    except (OSError, NotImplementedError) as error:  # the latter: a file system without locks
        raise OutputError(f"cannot be written: {getattr(error, 'strerror', None) or error}", place=place) from error


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
