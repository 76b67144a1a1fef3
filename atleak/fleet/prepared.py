"""Prepare a process of dask's for a fleet: ``dask scheduler --preload atleak.fleet.prepared``, and so each worker.

A scheduler then gives a unit whose worker ended back at once, as the run itself tries it again, alone. A worker imports
all that a diagnosis needs before it takes its first unit, works on however full its memory is until its nanny ends it,
and leaves Ctrl-C to the program that hands out the units: a terminal sends it to all processes at once, and the workers
are ended in order.
"""

from __future__ import annotations

import signal

from distributed import Scheduler, Worker

import atleak.fleet.worker  # noqa: F401 (imported so that no unit waits for it)
from atleak.common.memory import set_imports_aside


def dask_setup(server: Scheduler | Worker) -> None:
    """Prepare this process, which becomes a scheduler or worker; dask calls it."""
    if isinstance(server, Scheduler):
        server.allowed_failures = 0
        return
    server.memory_manager.memory_pause_fraction = False  # what was paused for its memory may never go on
    if server.nanny is not None:  # else it lives in another program's process, or a person ends it
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        set_imports_aside()
