"""Reach the workers of a fleet run: processes of this machine, or any dask scheduler by its address."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, cast

from atleak.common.errors import FleetError, Message, extra_installed
from atleak.common.sentences import Sentence

if TYPE_CHECKING:
    from distributed import Client

HERE = "127.0.0.1"
_ANSWER = 15.0  # [s] within which a scheduler has to answer
_MEMORY = 0.9  # part of this machine's memory that all workers together may take
_CLOSING = 2.0  # [s] for a client to end that could not be made
_SCHEMES = ("tcp", "tls", "ws", "wss")
_ADDRESS = Sentence("the address that the scheduler said when it was started, as tcp://10.0.0.5:8786")
_LEAST = 500_000_000  # bytes for a worker: what one holds with a unit of 47 lands, twice
_COMPARED = ("python", "numpy", "pandas", "dask", "distributed")
SETTINGS: Mapping[str, Any] = {
    # a unit whose worker ended is tried again by the run itself, which knows when it is alone
    "distributed.scheduler.allowed-failures": 0,
    # a worker that computes for minutes in compiled code says nothing meanwhile; the unit's time limit ends it
    "distributed.scheduler.worker-ttl": None,
    "distributed.deploy.lost-worker-timeout": "1 day",  # a worker that is slow to start anew is not given up
    # a worker past its memory is ended; one that only paused would never go on, as a unit keeps nothing afterwards
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": 0.95,
    "distributed.worker.memory.monitor-interval": "250ms",  # at 100 ms it is half of what dask itself takes
    "distributed.worker.multiprocessing-method": "spawn",
    "distributed.worker.profile.enabled": False,
    # what dask watches of itself, more seldom
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "2s",
    "distributed.admin.system-monitor.disk": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.diagnostics.nvml": False,
    "distributed.worker.http.routes": [],
    "distributed.scheduler.http.routes": [],
    # large units are expected
    "distributed.admin.large-graph-warning-threshold": "1 GiB",
    "distributed.nanny.pre-spawn-environ": {
        **{f"{library}_NUM_THREADS": 1 for library in ("OMP", "MKL", "OPENBLAS")},
        "DASK_LOGGING__DISTRIBUTED": "critical",
        # and not dask's own threshold of the C library's memory, which makes a diagnosis a twentieth slower
    },
}


@contextmanager
def connected(
    scheduler: str | None = None,
    workers: int | None = None,
    memory_limit: int | None = None,
    *,
    tell: Callable[[Message], object] = lambda message: None,
) -> Iterator[Client]:
    """Give a client of the workers, which are started here and ended again unless a scheduler is named.

    Parameters
    ----------
    scheduler
        address of a scheduler that runs already, as ``tcp://10.0.0.5:8786``; unless given, workers are started on this
        machine, reached from this machine alone.
    workers
        how many of them to start; unless given as many as there are processors, or fewer where memory is short.
    memory_limit
        of each worker started here, in bytes; unless given, its part of the machine's memory. A worker that takes more
        is ended and started anew.
    tell
        told what to know of workers that were there already.

    Raises
    ------
    FleetError
        dask.distributed is not installed, nobody answers at the address, or no worker can be started.
    """
    try:
        import dask
        import distributed  # noqa: F401
    except ImportError as error:
        problem = Sentence("a fleet run needs dask.distributed, which is not installed")
        raise FleetError(problem, expected=extra_installed("fleet")) from error
    with _quiet(), _same_environment(), dask.config.set(SETTINGS):
        if scheduler is None:
            with _started_here(workers, memory_limit) as client:
                yield client
        else:
            with _reached(scheduler, tell) as client:
                yield client


@contextmanager
def _started_here(workers: int | None, memory_limit: int | None) -> Iterator[Client]:
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster, Security
    from distributed.system import MEMORY_LIMIT

    memory = int(_MEMORY * MEMORY_LIMIT)
    count = workers or max(min(CPU_COUNT, memory // _LEAST), 1)
    started = ExitStack()
    try:
        with _undisturbed():
            try:
                cluster = LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    processes=True,
                    host=HERE,
                    dashboard_address=f"{HERE}:0",
                    protocol="tls://",
                    security=Security.temporary(),  # nobody else on this machine can hand it anything to do
                    memory_limit=memory_limit or memory // count,
                    preload=["atleak.fleet.prepared"],
                    silence_logs=logging.CRITICAL,
                )
            except (OSError, RuntimeError, TimeoutError) as error:
                problem = Sentence("the worker processes cannot be started: {reason}", reason=str(error))
                raise FleetError(problem) from error
            started.enter_context(cluster)
            client = started.enter_context(Client(cluster, set_as_default=False, direct_to_workers=True))
        yield client
    finally:
        with _undisturbed():
            started.close()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Hold Ctrl-C back until all is started or ended; processes that are started meanwhile never get it.

    On Windows nothing holds it back: there a worker may complain that is interrupted while it starts.
    """
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # else it is started with the first process, and lets Ctrl-C through from then on
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _reached(address: str, tell: Callable[[Message], object]) -> Iterator[Client]:
    from distributed import Client

    class Closing(Client):
        """One that is closed where it cannot be made; else it goes on trying until the program ends."""

        def start(self, **options: Any) -> None:
            try:
                super().start(**options)
            except BaseException:
                self.close(timeout=_CLOSING)
                raise

    _check_address(address)
    try:
        with ThreadPoolExecutor(1) as elsewhere:  # a notebook has a loop of its own running here
            # a client waits longer for its own end than for an answer
            elsewhere.submit(asyncio.run, _answering(address)).result()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a table of other versions: it is said below
            client = Closing(address, timeout=_ANSWER, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:  # some of TLS without certificates
        problem = Sentence("no dask scheduler answers there: {reason}", reason=str(error) or type(error).__name__)
        raise FleetError(problem, value=address, expected=_ADDRESS) from error
    with client:
        for message in _other_versions(cast(Mapping[str, Any], client.get_versions())):
            tell(message)
        yield client


def _check_address(address: str) -> None:
    """Refuse what is no address of a scheduler before anything tries to reach it."""
    scheme, found, rest = address.rpartition("://")
    host, _, port = rest.rpartition(":")
    sound = host and port.isdecimal() and port.isascii() and 0 < int(port) < 1 << 16
    if not sound or (found and scheme not in _SCHEMES):
        raise FleetError(Sentence("is no address of a scheduler"), value=address, expected=_ADDRESS)


async def _answering(address: str) -> None:
    """See whether a scheduler answers, within the time it has for it."""
    from distributed.comm import connect
    from distributed.security import Security

    arguments = Security().get_connection_args("client")
    try:
        async with asyncio.timeout(_ANSWER):
            comm = await connect(address, timeout=_ANSWER, **arguments)
            await comm.close()
    except TimeoutError as error:
        raise OSError(Sentence("no answer within {seconds:g} s", seconds=_ANSWER)) from error


def _other_versions(versions: Mapping[str, Any]) -> Iterator[Message]:
    """Say which packages are others at the workers than here: results may differ in their last digits."""
    here = versions["client"]["packages"]
    other: dict[str, set[str]] = {}
    for worker in versions["workers"].values():
        for name in _COMPARED:
            if worker["packages"].get(name) != here.get(name):
                other.setdefault(name, set()).add(str(worker["packages"].get(name)))
    if other:
        names = tuple(f"{name} {', '.join(sorted(found))} ({here.get(name)})" for name, found in other.items())
        text = Sentence(
            "workers have other versions than this machine, so that last digits may differ: {names}", names=names
        )
        yield Message("warning", "other_versions", text)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what dask logs out of the terminal: what matters of it is said by the run, in words."""
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    levels = [each.level for each in loggers]
    for each in loggers:
        each.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for each, level in zip(loggers, levels, strict=True):
            each.setLevel(level)


@contextmanager
def _same_environment() -> Iterator[None]:
    """Give back the environment's variables that dask sets here so that its workers have them."""
    before = dict(os.environ)
    try:
        yield
    finally:
        for name in os.environ.keys() - before.keys():
            del os.environ[name]
        os.environ.update(before)
