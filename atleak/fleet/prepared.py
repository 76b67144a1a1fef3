"""Prepare a worker process before it takes its first unit: ``dask worker … --preload atleak.fleet.prepared``.

Everything that a diagnosis needs is imported, once. Ctrl-C is left to the program that hands out the units: a terminal
sends it to all processes at once, and the workers are ended in order.
"""

from __future__ import annotations

import signal
from typing import Any

import atleak.fleet.task  # noqa: F401 (imported so that no unit waits for it)
from atleak.system.memory import set_imports_aside


def dask_setup(worker: Any) -> None:
    """Prepare this process; dask calls it.

    Parameters
    ----------
    worker
        that starts.
    """
    if worker.nanny is not None:  # else it lives in another program's process, or a person ends it
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        set_imports_aside()
