"""Do for one unit what a worker of dask's does: diagnose it within its time, and make the rows that are kept of it.

A process that takes too long is ended, even where it hangs in compiled code.
"""

from __future__ import annotations

import contextlib
import faulthandler
import itertools
import os
import pickle
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from distributed import get_worker

from atleak.analysis.record_doubts import with_sheet
from atleak.common.damage import unexpected
from atleak.common.errors import AtleakError, InputError
from atleak.fleet.columns import Rows
from atleak.fleet.rows import error_rows, rows_of_result
from atleak.fleet.units import FleetUnit
from atleak.job.case import Case, CaseChoice, Reader, Slot
from atleak.readers.logs import Understood, default_path, understand
from atleak.version import __version__

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


_KEPT = 64  # entries of the catalogue


_ENTRIES: dict[tuple[str, str, str], Any] = {}


class _Reader(Reader):
    """Read every file of a job anew, but keep what jobs take from the catalogue: a fleet is of few valve bodies."""

    def __init__(self, memory: int | None) -> None:
        self._memory = memory

    def log(self, case: Case) -> Understood:
        """Read the job's log.

        Raises
        ------
        RoadTestError
            for a file that is no log, or takes more memory than a unit may.
        """
        file = case.road_test
        assert file is not None
        remembered = default_path() if case.remember else None
        return understand(file.given, name=file.name, memory=self._memory, remembered=remembered, **case.log_choices)

    def entry(self, slot: Slot, choice: CaseChoice) -> Any:
        """Return an entry as it was loaded before, where it is of the same bytes."""
        own = slot.own_file(choice)
        key = (slot.name, str(choice), "") if own is None else (slot.name, own.name, own.sha256)
        entry = _ENTRIES.get(key)
        if entry is None:
            entry = _ENTRIES[key] = super().entry(slot, choice)
            for oldest in list(_ENTRIES)[:-_KEPT]:
                _ENTRIES.pop(oldest, None)  # another thread may have been first
        return entry


def evaluate_unit(unit: FleetUnit, *, tries: int = 1, memory: int | None = None, folder: Path | None = None) -> Rows:
    """Return the rows of a unit: those of its diagnosis, or the one row that says why there is none; never raises.

    A unit for which the memory did not suffice is of the kind ``ended``, as one whose worker was ended for it.

    Parameters
    ----------
    unit
        to be diagnosed, exactly as `atleak.job.case.Case.diagnose` does.
    tries
        how many times it was begun, this time with it.
    memory
        that it may take [bytes]; unless given, as much as is free.
    folder
        where the files of a job are unpacked; unless given, with temporary files. Nothing of them stays there.
    """
    begun = time.perf_counter()
    try:
        with TemporaryDirectory(prefix="atleak-", dir=folder, ignore_cleanup_errors=True) as unpacked:
            case, job = unit.opened(Path(unpacked))
            diagnosis = case.diagnose(_Reader(memory))
            job = with_sheet(job, diagnosis.readings) or job
            return rows_of_result(unit, diagnosis, job, seconds=time.perf_counter() - begun, tries=tries)
    except AtleakError as error:
        if isinstance(error, InputError):
            unit.name_within(error)
        short = any(isinstance(each, MemoryError) for each in _causes(error))
        return error_rows(unit, "ended" if short else "refused", str(error), tries=tries)
    except MemoryError as error:
        return error_rows(unit, "ended", str(unexpected(error, unit.name)), tries=tries)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 (a panic of a library in Rust is no Exception)
        return error_rows(unit, "fault", str(unexpected(error, unit.name)), tries=tries)


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__


OVERDUE = "atleak-fleet-overdue"  # topic of the scheduler's event log: whose time limit was exceeded
BEGUN = "atleak-fleet-begun"  # likewise: which unit is begun now, of those that are tried alone
_OUT = 0.5  # [s] for what is told to get out: a unit may hold the interpreter at once


class OtherVersionError(Exception):
    """A worker has another version of atleak than the one that sent it a unit."""


def on_worker(
    unit: bytes, name: str, tries: int, time_limit: float | None, version: str, *, tell_begun: bool = False
) -> Rows:
    """Evaluate a unit within its time.

    Parameters
    ----------
    unit
        pickled: dask then need not look for anything of its own in it.
    name
        of this try, by which the scheduler's event log is to know it.
    tries
        how often the unit was begun, this time with it.
    time_limit
        [s] after which this process ends; None: never.
    version
        of the atleak that sends the unit.
    tell_begun
        whether the scheduler's event log is told when the unit's time begins.

    Raises
    ------
    OtherVersionError
        this worker has another one, by which the results would not be what the run says they are.
    """
    if version != __version__:
        raise OtherVersionError(__version__)
    worker = get_worker()
    if tell_begun:
        worker.log_event(BEGUN, {"name": name})
        time.sleep(_OUT)
    with ended_after(time_limit, lambda: worker.log_event(OVERDUE, {"name": name, "worker": worker.address})):
        memory, folder = worker.memory_manager.memory_limit or None, Path(worker.local_directory)
        return evaluate_unit(pickle.loads(unit), tries=tries, memory=memory, folder=folder)
