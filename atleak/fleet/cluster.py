"""Reach the workers of a fleet run: processes of this machine, or any dask scheduler by its address."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client


@contextmanager
def connected(
    scheduler: str | None = None, workers: int | None = None, memory_limit: str | int | None = None
) -> Iterator[Client]:
    """Give a client of the workers, which are started here and ended again unless a scheduler is named.

    Parameters
    ----------
    scheduler
        address of a scheduler that runs already, as ``tcp://10.0.0.5:8786``; unless given, workers are started on this
        machine, reached from this machine alone.
    workers
        how many of them to start; as many as there are processors unless given.
    memory_limit
        of each worker started here, in bytes or as ``2 GB``; unless given, its part of the machine's memory. A worker
        that takes more is ended and started anew.

    Raises
    ------
    FleetError
        dask.distributed is not installed, nobody answers at the address, or the workers have another version of atleak.
    """
    raise NotImplementedError
    yield
