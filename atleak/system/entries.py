"""Keep entries in a JSON file that several programs change: each change is written whole, one at a time."""

from __future__ import annotations

import datetime as dt
import glob
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from atleak.errors import OutputError, Place
from atleak.sentence import Sentence
from atleak.system.files import PRIVATE, replace_file
from atleak.system.home import made
from atleak.system.reasons import reason_of

_PATIENCE = 30  # [s] to wait for other writers
_POLL = 0.01  # [s]
_DAMAGED = ".damaged-"


@contextmanager
def rewritten(path: Path) -> Iterator[dict[str, object]]:
    """Yield the entries of the file to be changed, then write them; no other process or thread writes meanwhile.

    A damaged file is set aside, and said, before another one takes its place.

    Raises
    ------
    OutputError
        where the file cannot be written, or another program keeps it locked.
    """
    from filelock import FileLock, Timeout  # 40 ms, and most runs change nothing

    place = Place(file=str(path))
    lock = FileLock(path.with_suffix(".lock"), timeout=_PATIENCE, mode=PRIVATE)
    try:
        made(path.parent)
        with lock.acquire(poll_interval=_POLL):
            entries = _load(path)
            if entries is None:
                _set_aside(path)
                entries = {}
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
        return _load(path) or {}
    except OSError:
        return {}


def _load(path: Path) -> dict[str, object] | None:
    """Return the entries of the file, empty where there is none; None where it is damaged."""
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (ValueError, RecursionError):
        return None
    return entries if isinstance(entries, dict) else None


def _set_aside(path: Path) -> None:
    """Keep a damaged file under another name, where somebody may mend it, and say so to whoever runs the program."""
    name = f"{path.name}{_DAMAGED}{dt.date.today()}"
    aside = next(other for number in count(1) if not (other := path.with_name(f"{name}-{number}")).exists())
    path.rename(aside)
    problem = Sentence("was damaged and begins anew; what it held is in {file}", file=aside.name)
    logging.getLogger(__name__).warning("atleak: %s: %s", path, problem)


def damaged_before(path: Path) -> list[Path]:
    """Return what of a file was set aside because it was damaged, the earliest first; one that is so now goes there."""
    with suppress(OSError, OutputError):  # it stays where nothing may be written
        if _load(path) is None:
            with rewritten(path):
                pass
    return sorted(path.parent.glob(f"{glob.escape(path.name)}{_DAMAGED}*"))
