"""Have the units of a fleet diagnosed by many workers, and keep what they give: nothing lost, nothing twice."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

    from atleak.common.errors import Message
    from atleak.fleet.columns import ErrorKind
    from atleak.fleet.dispatch import Run
    from atleak.fleet.results import Results
    from atleak.fleet.sources import FoundUnits
    from atleak.fleet.units import FleetUnit

TIME_LIMIT = 1800.0  # [s] for one unit
_SAID_EVERY = 0.5  # [s]


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    done: int  # units to which this run gave a result or an error
    errors: int  # how many of them an error
    before: int  # units that had one or the other before, as far as they had their turn
    of: int  # units in all
    seconds: float  # since the run began
    workers: int  # that are there now

    @property
    def per_second(self) -> float:
        """Return the rate so far [1/s]."""
        return self.done / self.seconds if self.seconds else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Return how long the rest takes at that rate; None before the first unit is done."""
        return (self.of - self.before - self.done) / self.per_second if self.done else None


@dataclass(frozen=True)
class Finished:
    """What became of the units of a run."""

    verdicts: Mapping[str, int]  # verdict → how many units of this run
    errors: Mapping[ErrorKind, int]  # kind of error → how many units of this run
    before: int  # units that had their result, or their error, before this run
    twice: int  # units that are the same as another one, to the last byte
    seconds: float  # [s] that it took

    @property
    def evaluated(self) -> int:
        """Return how many units this run gave a result."""
        return sum(self.verdicts.values())


def run_fleet(
    units: Sequence[FleetUnit] | FoundUnits,
    results: Results,
    client: Client,
    *,
    time_limit: float | None = TIME_LIMIT,
    retry_errors: bool = False,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[Message], object] = lambda message: None,
) -> Finished:
    """Have every unit diagnosed that has no result yet, and write the results.

    What is finished is written some times a minute and at the end, however that comes: also when this is interrupted
    (KeyboardInterrupt goes on to the caller) or the scheduler is lost. Running again goes on from there.

    Parameters
    ----------
    units
        each made when its turn comes.
    time_limit
        [s] for one unit, after which its worker is ended; the unit is tried once more. None: no limit.
    retry_errors
        whether units that ended in an error before are tried again.
    progress
        called about twice a second, and at the end.
    tell
        told, now and then, that there is no worker to wait for.

    Raises
    ------
    FleetError
        the scheduler or all workers are lost for good; what was finished is kept.
    """
    from atleak.fleet.dispatch import Run

    begun = time.monotonic()
    results.tidy()
    known = {sha256: each for sha256, each in results.standing().items() if not (retry_errors and each.failed)}
    reported = begun

    def say(run: Run, *, at_once: bool = False) -> None:
        nonlocal reported
        now = time.monotonic()
        if progress is not None and (at_once or now - reported >= _SAID_EVERY):
            reported = now
            progress(Progress(run.done, run.errors.total(), run.before, len(units), now - begun, run.workers))

    run = Run(units, known, results, client, time_limit, say, tell)
    run.go()
    say(run, at_once=True)
    results.tidy()
    verdicts, errors, before = run.verdicts, run.errors, run.before
    if run.met - results.done():  # of files that were renamed: another content took the place of an earlier result
        run = Run(units, results.standing(), results, client, time_limit, say, tell)
        run.go()
        results.tidy()
        verdicts, errors, before = verdicts + run.verdicts, errors + run.errors, before - run.done
    return Finished(
        verdicts=dict(verdicts),
        errors=dict(errors),
        before=before,
        twice=len(units) - before - verdicts.total() - errors.total(),
        seconds=time.monotonic() - begun,
    )
