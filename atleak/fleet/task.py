"""Run one unit as a task of dask's: a worker calls this."""

from __future__ import annotations

import pickle
import time
from pathlib import Path

from distributed import get_worker

from atleak.fleet.columns import Rows
from atleak.fleet.watchdog import ended_after
from atleak.fleet.work import evaluate
from atleak.version import __version__

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
        return evaluate(pickle.loads(unit), tries=tries, memory=memory, folder=folder)
