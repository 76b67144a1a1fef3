"""Keep entries in a JSON file that several programs change: each change is written whole, one at a time."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from atleak.errors import OutputError, Place
from atleak.sentence import Sentence
from atleak.system.files import PRIVATE, replace_file
from atleak.system.reasons import reason_of

_PATIENCE = 30  # [s] to wait for other writers
_POLL = 0.01  # [s]


@contextmanager
def rewritten(path: Path) -> Iterator[dict[str, object]]:
    """Yield the entries of the file to be changed, then write them; no other process or thread writes meanwhile.

    Raises
    ------
    OutputError
        where the file cannot be written, or another program keeps it locked.
    """
    from filelock import FileLock, Timeout  # 40 ms, and most runs change nothing

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


def readable(path: Path) -> dict[str, object]:
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
