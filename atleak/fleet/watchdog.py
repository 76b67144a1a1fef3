"""End a process that works on something for too long, even where it hangs in compiled code."""

from __future__ import annotations

import contextlib
import faulthandler
import itertools
import os
import threading
import time
from collections.abc import Callable, Iterator

STATUS = 75  # with which the process ends
_LAST_WORDS = 0.5  # [s] for what is told to get out
_GRACE = 5.0  # [s] later the process is ended without a word

_lock = threading.Lock()
_deadlines: dict[int, float] = {}  # of whatever is under way in this process, by the clock that never goes back
_numbers = itertools.count()
_nowhere: int | None = None


@contextlib.contextmanager
def ended_after(seconds: float | None, tell: Callable[[], object]) -> Iterator[None]:
    """End this process where the block takes longer.

    A thread of Python's does it and says why. Where one piece of compiled code holds the interpreter, no thread of
    Python's runs: then a timer of the C library's does it, a little later and without a word.

    Parameters
    ----------
    seconds
        for the block; None: as long as it takes.
    tell
        called first, by another thread; what it begins has half a second to get out.
    """
    if seconds is None:
        yield
        return
    timer = threading.Timer(seconds, _leave, (tell,))
    timer.daemon = True
    number = next(_numbers)
    timer.start()
    _set(number, time.monotonic() + seconds + _GRACE)
    try:
        yield
    finally:
        _set(number, None)
        timer.cancel()


def _set(number: int, deadline: float | None) -> None:
    """Enter or strike out a deadline and set the C library's timer, of which there is one, to the first of them."""
    global _nowhere
    with _lock:
        _deadlines.pop(number, None)
        if deadline is not None:
            _deadlines[number] = deadline
        if not _deadlines:
            faulthandler.cancel_dump_traceback_later()
            return
        if _nowhere is None:
            _nowhere = os.open(os.devnull, os.O_WRONLY)  # as long as the process
        left = max(min(_deadlines.values()) - time.monotonic(), 0.001)
        faulthandler.dump_traceback_later(left, exit=True, file=_nowhere)


def _leave(tell: Callable[[], object]) -> None:
    try:
        tell()
        time.sleep(_LAST_WORDS)
    finally:
        os._exit(STATUS)
