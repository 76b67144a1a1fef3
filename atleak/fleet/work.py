"""Do for one unit what a worker does: diagnose it, and make the rows that are kept of it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from atleak.doors import unexpected
from atleak.errors import AtleakError, InputError
from atleak.fleet.rows import Rows, error_rows, rows_of
from atleak.fleet.units import FleetUnit
from atleak.intake.road_test import Understood, default_path, understand
from atleak.job.case import Case, Choice, Reader, Slot
from atleak.job.of_sheet import with_sheet

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

    def entry(self, slot: Slot, choice: Choice) -> Any:
        """Return an entry as it was loaded before, where it is of the same bytes."""
        own = slot.own_file(choice)
        key = (slot.name, str(choice), "") if own is None else (slot.name, own.name, own.sha256)
        entry = _ENTRIES.get(key)
        if entry is None:
            entry = _ENTRIES[key] = super().entry(slot, choice)
            for oldest in list(_ENTRIES)[:-_KEPT]:
                _ENTRIES.pop(oldest, None)  # another thread may have been first
        return entry


def evaluate(unit: FleetUnit, *, tries: int = 1, memory: int | None = None, folder: Path | None = None) -> Rows:
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
            return rows_of(unit, diagnosis, job, seconds=time.perf_counter() - begun, tries=tries)
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
