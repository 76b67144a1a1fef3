"""Hand out a fleet's units to dask's workers, a few at a time, and take back what they give.

A unit whose worker ended is tried again alone, at the end: nobody knows which of the units that the worker had took it
along. One that took too long was named before its worker left, and is tried again like any other.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import itertools
import pickle
import queue
import secrets
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from typing import Any

from distributed import Client, Future
from distributed.scheduler import KilledWorker

from atleak.common.damage import unexpected
from atleak.common.errors import FleetError, InputError, Message, Place
from atleak.common.sentences import Sentence
from atleak.fleet.columns import ErrorKind, Rows
from atleak.fleet.results import Results, ResultStanding
from atleak.fleet.units import FleetUnit
from atleak.fleet.worker import BEGUN, OVERDUE, OtherVersionError, error_rows, on_worker
from atleak.version import __version__

_AHEAD = 2  # units at a worker: the one it works on, and the next
TRIES_OVERDUE = 2  # of a unit that takes too long
TRIES_ALONE = 2  # of a unit whose worker ended, after the one among others
WRITTEN_EVERY = 20.0  # [s]
WRITTEN_AT = 500  # units
PATIENCE = 300.0  # [s] without any worker
TOLD_AFTER, TOLD_EVERY = 10.0, 60.0  # [s] without any worker
_NO_ANSWER = 60.0  # [s] without an answer of a scheduler that seems to be there
_TICK = 0.5  # [s]
_LOOK = 2.0  # [s] between two looks at which workers there are
_MOMENT = 0.02  # [s] between two looks at whether a unit is done
_MEMORY = "worker-restart-memory"  # dask's topic of workers that took more memory than they may
_TOLD_WITHIN = 1.0  # [s] after such a worker has ended


@dataclass(frozen=True)
class _Try:
    """A unit that is handed out, or that is to be."""

    unit: FleetUnit
    tries: int = 1  # this one with it
    alone: int = 0  # how many of them alone
    name: str = ""  # of this try


class Run:
    """A run under way.

    Parameters
    ----------
    units
        each is asked for when its turn comes.
    known
        by its hash, each unit that has a result, or an error, already, and as what it stands there: one that was moved
        is evaluated anew, and takes the place of what stands there.
    results
        open for writing.
    client
        of the workers.
    time_limit
        [s] for one unit; None: none.
    say
        called about twice a second with this run.
    tell
        told, now and then, that there is no worker.
    """

    def __init__(
        self,
        units: Iterable[FleetUnit],
        known: Mapping[str, ResultStanding],
        results: Results,
        client: Client,
        time_limit: float | None,
        say: Callable[[Run], object],
        tell: Callable[[Message], object] = lambda message: None,
    ) -> None:
        self.verdicts: Counter[str] = Counter()
        self.errors: Counter[ErrorKind] = Counter()
        self.before = 0  # units that are known already
        self.workers = 0
        self._results, self._client, self._time_limit, self._say = results, client, time_limit, say
        self._tell = tell
        self._units, self._all_seen = iter(units), False
        self._known = known
        self.met: set[str] = set()  # hashes of the units that had their turn
        self._waiting: deque[_Try] = deque()  # to be handed out next
        self._alone: deque[_Try] = deque()  # to be handed out once all others are done
        self._under_way: dict[Future, _Try] = {}
        self._ended: queue.SimpleQueue[tuple[Future, Rows | None]] = queue.SimpleQueue()
        self._overdue: queue.SimpleQueue[dict[str, str]] = queue.SimpleQueue()
        self._begun: dict[str, float] = {}  # name of a try alone → when its worker said that it begins
        self._left: set[str] = set()  # addresses of workers that left because a unit took too long
        self._finished: list[Rows] = []  # not yet written
        self._written = time.monotonic()
        self._threads = 0
        self._looked = 0.0  # when
        self._seen = self._answered = time.monotonic()  # when there was a worker, and a scheduler
        self._told_at = self._seen + TOLD_AFTER  # when it is told next that there is no worker
        run = secrets.token_hex(6)
        self._names = (f"{run}-{number}" for number in itertools.count())

    @property
    def done(self) -> int:
        """Return how many units have a result or an error by now."""
        return self.verdicts.total() + self.errors.total()

    def go(self) -> None:
        """Have all units evaluated; what is finished is written however this ends.

        Raises
        ------
        FleetError
            no worker is left, the scheduler is lost, or the workers cannot run this version of atleak.
        """
        self._client.subscribe_topic(OVERDUE, lambda event: self._overdue.put(event[1]))
        self._client.subscribe_topic(BEGUN, lambda event: self._begun.update({event[1]["name"]: time.monotonic()}))
        try:
            while not self._all_seen or self._waiting or self._alone or self._under_way:
                self._draw()
                try:
                    self._look()
                    self._hand_out()
                    self._take_back()
                except FleetError:
                    raise
                except Exception as error:
                    if self._client.status == "running" and not isinstance(error, OSError | CancelledError):
                        raise
                    self._wait_for_scheduler(error)  # in whatever way the connection's end was noticed
                self._write()
                self._say(self)
        finally:
            self._write(at_once=True)
            self._let_go()

    # --- handing out

    def _look(self) -> None:
        """See which workers there are, now and then."""
        now = time.monotonic()
        if self._threads and now - self._looked < _LOOK:
            return
        threads = self._client.nthreads()
        self.workers, self._threads = len(threads), sum(threads.values())
        self._looked = self._answered = now
        if self._threads:
            self._seen, self._told_at = now, now + TOLD_AFTER
        elif now - self._seen > PATIENCE:
            problem = Sentence("there has been no worker for {seconds:.0f} s", seconds=now - self._seen)
            raise FleetError(problem, expected=_AGAIN)
        elif now >= self._told_at:
            self._told_at = now + TOLD_EVERY
            self._tell(Message("warning", "no_worker", self._without_worker(now - self._seen)))

    def _without_worker(self, seconds: float) -> Sentence:
        until = dt.datetime.now() + dt.timedelta(seconds=PATIENCE - seconds)
        return Sentence(
            "no worker for {seconds:.0f} s at {address}; waiting until {time}",
            seconds=seconds,
            address=self._client.scheduler.address,
            time=f"{until:%H:%M}",
        )

    def _hand_out(self) -> None:
        handed = [self._waiting.popleft() for _ in range(min(self._room, len(self._waiting)))]
        if self._threads and self._alone and self._all_seen and not (handed or self._under_way):
            handed = [self._alone.popleft()]
        if not handed:
            return
        named = [replace(each, name=next(self._names)) for each in handed]
        futures = self._client.map(
            on_worker,
            [pickle.dumps(each.unit, protocol=pickle.HIGHEST_PROTOCOL) for each in named],
            [each.name for each in named],
            [each.tries for each in named],
            key=[("unit", each.name) for each in named],
            time_limit=self._time_limit,
            version=__version__,
            tell_begun=any(each.alone for each in named),
            pure=False,
        )
        for future, each in zip(futures, named, strict=True):
            self._under_way[future] = each
            self._client.loop.add_callback(self._follow, future)  # type: ignore[union-attr]

    async def _follow(self, future: Future) -> None:
        """Queue a unit once its task has ended, with what it gave.

        dask's `as_completed` never tells of a task whose result went with its worker and whose next tries failed.
        """
        rows: Rows | None = None
        try:
            with contextlib.suppress(OSError, AttributeError):  # a client has no scheduler while it looks for it again
                rows = next(iter(await self._client.gather([future], errors="skip", asynchronous=True)), None)
        finally:
            self._ended.put((future, rows))

    @property
    def _room(self) -> int:
        """Return how many units more can be handed out."""
        return max(_AHEAD * self._threads - len(self._under_way), 0)

    def _draw(self) -> None:
        """Have as many units wait as can be handed out, or as are found among those known already within a moment."""
        until = time.monotonic() + _TICK
        while not self._all_seen and len(self._waiting) < self._room and time.monotonic() < until:
            unit = next(self._units, None)
            if unit is None:
                self._all_seen = True
            elif unit.input_sha256 not in self.met:  # else it is the same as another one
                self.met.add(unit.input_sha256)
                if self._stands(unit):
                    self.before += 1
                else:
                    self._waiting.append(_Try(unit))

    def _stands(self, unit: FleetUnit) -> bool:
        known = self._known.get(unit.input_sha256)
        return known is not None and (known.reference, known.group) == (unit.reference, unit.group)

    # --- taking back

    def _take_back(self) -> None:
        """Wait a little for units that are done, one way or another, and see what became of them."""
        until = time.monotonic() + _TICK
        while self._ended.empty() and time.monotonic() < until:
            time.sleep(_MOMENT)
        self._take_out_overdue()
        while not self._ended.empty():
            future, rows = self._ended.get()
            if future not in self._under_way:
                continue
            if future.status == "error":
                self._sort_out(future)
            elif rows is not None:
                self._take(future, rows)
            else:
                raise OSError("the scheduler has let go of the units")

    def _take(self, future: Future, rows: Rows) -> None:
        if rows.error == "ended" and self._under_way[future].alone < TRIES_ALONE:
            self._again_alone(future)
        else:
            self._keep(future, rows)

    def _sort_out(self, future: Future) -> None:
        """Decide what becomes of a unit whose task ended in an error, which none does by itself."""
        each, error = self._under_way[future], future.exception()
        if isinstance(error, KilledWorker):
            self._under_way[future] = replace(each, tries=each.tries + error.allowed_failures)
            self._killed(future, error)
        elif isinstance(error, OtherVersionError | ImportError | AttributeError):
            problem = Sentence(
                "the workers cannot run this atleak, {version}: {reason}",
                version=__version__,
                reason=_error_text(error),
            )
            raise FleetError(
                problem, expected=Sentence("the same version of atleak, and of dask, on every machine")
            ) from error
        else:
            self._fail(future, "fault", unexpected(error, each.unit.name))

    def _killed(self, future: Future, error: KilledWorker) -> None:
        each, worker = self._under_way[future], error.last_worker.address
        begun = self._begun.get(each.name)  # not said: the worker ended before, be it that it was only starting
        took = 0.0 if begun is None else time.monotonic() - begun
        if worker in self._left:  # it was at a worker that left because of another unit
            self._waiting.append(self._under_way.pop(future))
        elif each.alone and self._time_limit is not None and took >= self._time_limit:
            self._fail(future, "time limit", self._too_long(each))
        elif each.alone < TRIES_ALONE:
            self._again_alone(future)
        else:
            self._fail(future, "ended", self._why_ended(each, worker))

    def _take_out_overdue(self) -> None:
        """Take out units that took too long: a scheduler may have them tried by one worker after another."""
        if self._overdue.empty():
            return
        by_name = {each.name: future for future, each in self._under_way.items()}
        with contextlib.suppress(queue.Empty):
            while True:
                message = self._overdue.get_nowait()
                future = by_name.get(message["name"])
                if future is None or future not in self._under_way:  # of another run, or of an earlier try
                    continue
                self._left.add(message["worker"])
                self._client.cancel([future], force=True)
                each = self._under_way[future]
                if each.tries < TRIES_OVERDUE:
                    self._again(future)
                else:
                    self._fail(future, "time limit", self._too_long(each))

    def _too_long(self, each: _Try) -> InputError:
        problem = Sentence("takes longer than the {seconds:g} s that one unit may take", seconds=self._time_limit)
        return InputError(problem, place=Place(file=each.unit.name))

    def _why_ended(self, each: _Try, worker: str) -> InputError:
        time.sleep(_TOLD_WITHIN)
        taken = [message["rss"] for _, message in self._client.get_events(_MEMORY) if message["worker"] == worker]
        if taken:
            problem = Sentence(
                "needs more memory than a worker may take: it had {size:.1f} GB when it was ended",
                size=max(taken) / 1e9,
            )
        else:
            problem = Sentence("the process that worked on it ended each time, {count} times in all", count=each.tries)
        return InputError(problem, place=Place(file=each.unit.name))

    def _again(self, future: Future) -> None:
        each = self._under_way.pop(future)
        self._waiting.append(replace(each, tries=each.tries + 1))

    def _again_alone(self, future: Future) -> None:
        each = self._under_way.pop(future)
        self._alone.append(replace(each, tries=each.tries + 1, alone=each.alone + 1))

    def _fail(self, future: Future, kind: ErrorKind, error: InputError) -> None:
        each = self._under_way[future]
        self._keep(future, error_rows(each.unit, kind, str(error), tries=each.tries))

    def _keep(self, future: Future, rows: Rows) -> None:
        del self._under_way[future]
        self._finished.append(rows)
        if rows.error is not None:
            self.errors[rows.error] += 1
        elif rows.verdict is not None:
            self.verdicts[rows.verdict.value] += 1

    # --- writing, and what the connection does

    def _write(self, *, at_once: bool = False) -> None:
        now = time.monotonic()
        due = now - self._written >= WRITTEN_EVERY or len(self._finished) >= WRITTEN_AT
        if self._finished and (due or at_once):
            self._results.add(self._finished)
            self._finished, self._written = [], now

    def _wait_for_scheduler(self, error: Exception) -> None:
        """Wait while the client tries to reach the scheduler again; what was under way is handed out anew."""
        for future in list(self._under_way):
            each = self._under_way.pop(future)
            (self._alone if each.alone else self._waiting).appendleft(each)
        self._threads = 0
        while True:
            time.sleep(_TICK)
            self._say(self)
            if self._client.status == "closed" or time.monotonic() - self._answered > _NO_ANSWER:
                problem = Sentence("the scheduler does not answer any more ({reason})", reason=_error_text(error))
                raise FleetError(problem, expected=_AGAIN) from error
            if self._client.status == "running":
                return

    def _let_go(self) -> None:
        """Let the scheduler forget what is under way."""
        if self._client.status == "running":
            with contextlib.suppress(OSError):  # of a scheduler that is gone at last
                self._client.unsubscribe_topic(OVERDUE)
                self._client.unsubscribe_topic(BEGUN)
                self._client.cancel(list(self._under_way), force=True)
        self._under_way.clear()


_AGAIN = Sentence("the run to be started again: it goes on from here, as what was finished is kept")


def _error_text(error: Any) -> str:
    return f"{type(error).__name__}: {error}"
