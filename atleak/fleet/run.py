"""Have the units of a fleet diagnosed by many workers, and keep what they give: nothing lost, nothing twice."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

    from atleak.fleet.columns import ErrorKind
    from atleak.fleet.results import Results
    from atleak.fleet.running import Run
    from atleak.fleet.units import FleetUnit

TIME_LIMIT = 1800.0  # [s] for one unit


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    done: int  # units of this run with a result or an error
    errors: int  # how many of them with an error
    of: int  # units that this run has to do
    seconds: float  # since it began
    workers: int  # that are there now

    @property
    def per_second(self) -> float:
        """Return the rate so far [1/s]."""
        return self.done / self.seconds if self.seconds else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Return how long the rest takes at that rate; None before the first unit is done."""
        return (self.of - self.done) / self.per_second if self.done else None


@dataclass(frozen=True)
class Finished:
    """What became of the units of a run."""

    verdicts: Mapping[str, int]  # verdict → how many units of this run
    errors: Mapping[ErrorKind, int]  # kind of error → how many units of this run
    before: int  # units that had their result, or their error, before this run
    twice: int  # units given that are the same as another one, to the last byte
    seconds: float

    @property
    def evaluated(self) -> int:
        """Return how many units this run gave a result."""
        return sum(self.verdicts.values())


def run_fleet(
    units: Sequence[FleetUnit],
    results: Results,
    client: Client,
    *,
    time_limit: float | None = TIME_LIMIT,
    retry_errors: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> Finished:
    """Have every unit diagnosed that has no result yet, and write the results.

    What is finished is written some times a minute and at the end, however that comes: also when this is interrupted
    (KeyboardInterrupt goes on to the caller) or the scheduler is lost. Running again goes on from there.

    Parameters
    ----------
    units
        as `find_units` gives them.
    results
        opened for writing.
    client
        as `atleak.fleet.cluster.connected` gives it.
    time_limit
        [s] for one unit, after which its worker is ended; it is tried once more, alone. None: no limit.
    retry_errors
        whether units that ended in an error before are tried again.
    progress
        called about twice a second, and at the end.

    Raises
    ------
    FleetError
        the scheduler or all workers are lost for good; what was finished is kept.
    """
    from atleak.fleet.running import Run

    begun = time.monotonic()
    results.tidy()
    done = results.done() - (results.failed() if retry_errors else set())
    given = {unit.input_sha256: unit for unit in units}
    wanted = [unit for sha256, unit in given.items() if sha256 not in done]

    def say(run: Run) -> None:
        if progress is not None:
            progress(Progress(run.done, run.errors.total(), len(wanted), time.monotonic() - begun, run.workers))

    run = Run(wanted, results, client, time_limit, say)
    run.go()
    results.tidy()
    return Finished(
        verdicts=dict(run.verdicts),
        errors=dict(run.errors),
        before=len(given) - len(wanted),
        twice=len(units) - len(given),
        seconds=time.monotonic() - begun,
    )
