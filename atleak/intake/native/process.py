"""Calls a reading function in a child process, within limits of time and memory.

Children keep running for the next file of the same kind and serve one thread at a time. When one dies, or is ended at a
limit, the file it was reading is refused; the next file gets a new child.

To have another kind of file read there, write a function that takes the file's bytes and yields plain data (None,
numbers, texts, sentences, bytes, bytearrays, dates, times, and lists, tuples and dicts of them), in a module that
imports nothing heavy at its top, and hand it to `read_apart`.
"""

from __future__ import annotations

import atexit
import contextlib
import datetime
import io
import math
import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal, TypeVar, cast

import psutil

from atleak.doors import own_fault
from atleak.errors import InputError, Place
from atleak.intake.native.child import Request, receive, send
from atleak.sentence import Sentence

Item = TypeVar("Item")
Answers = Generator[Any, None, tuple[str, Any]]
"""The items of an answer; at the end, how it ended, and what came with its end."""

CHILDREN = 2
"""Files read at the same time; a third waits. Each may take the memory of its budget."""
IDLE = 4
"""Children that are kept for the next file, of all kinds together."""
KEPT = 300 << 20
"""Bytes of memory above which a child is ended after its file instead of kept: memory once used is not given back."""
START = 30.0
"""Seconds a child may take to start: it takes 0.02, on a cold disk behind a virus scanner a hundred times that."""
CHECK_INTERVAL = 0.02
"""Seconds between two checks of a child: memory fills at 2 GB/s at most, so a limit is passed by 40 MB."""
EXPLAIN = 10.0
"""Seconds that may be spent on a better reason for a refusal."""
LEAVE = 5.0
"""Seconds a child may take to end by itself when it is no longer needed."""


@dataclass(frozen=True)
class Budget:
    """What reading a file may use: memory [bytes] and time [s], each with a part for every byte of the file."""

    kind: Sentence
    memory: int
    memory_per_byte: float
    seconds: float
    seconds_per_byte: float
    suspicion: Sentence
    expected: Sentence

    def limits(self, size: int) -> tuple[int, float]:
        """Return the memory [bytes] and time [s] allowed for a file of ``size`` bytes."""
        return int(self.memory + self.memory_per_byte * size), self.seconds + self.seconds_per_byte * size


# An xlsx of 104 MB (720 000 rows of 12 columns) takes 310 MB and 6 s, because it is read in slices. Laid out whole, as
# an xls, xlsb or ods is, it takes 8 bytes of memory a byte of file; packed four times as tightly, as a log of round
# numbers is, 32. A measuring sheet takes 30 MB and 0.03 s.
WORKBOOK = Budget(
    kind=Sentence("workbook"),
    memory=400 << 20,
    memory_per_byte=30.0,
    seconds=10.0,
    seconds_per_byte=2e-6,
    suspicion=Sentence("it is damaged, or has cells far outside its table"),
    expected=Sentence(
        "a workbook as a spreadsheet program saves it: open it there, delete what lies outside the table, save it "
        "anew as .xlsx, or the table as .csv"
    ),
)
# asammdf alone takes 130 MB and a second to load.
MDF = Budget(
    kind=Sentence("MDF file"),
    memory=700 << 20,
    memory_per_byte=30.0,
    seconds=30.0,
    seconds_per_byte=2e-6,
    suspicion=Sentence("it is damaged"),
    expected=Sentence("the log saved anew, or exported as .csv, by the logger's own program"),
)

# pyarrow takes 80 MB. Of a table whose columns hardly change, a byte of file unfolds to many.
PARQUET = Budget(
    kind=Sentence("Parquet file"),
    memory=700 << 20,
    memory_per_byte=30.0,
    seconds=30.0,
    seconds_per_byte=2e-6,
    suspicion=Sentence("it is damaged"),
    expected=Sentence("the log saved anew, or exported as .csv, by the logger's own program"),
)


def read_apart(
    function: Callable[[bytes], Iterator[Item]],
    data: bytes,
    file: str,
    error: type[InputError],
    budget: Budget,
    explain: Callable[[bytes], Iterator[object]] | None = None,
    size: int | None = None,
) -> list[Item]:
    """Call a reading function in a child process and return all it yields about a file.

    Parameters
    ----------
    function
        at the top level of a module the child can import; yields plain data.
    data
        the file's bytes.
    file
        the file's name in messages.
    error
        the exception that says why the file is refused.
    budget
        what reading it may use.
    explain
        called on a file that ended its reader, to refuse it with a better reason.
    size
        of the file [bytes], where ``data`` only says where it lies.

    Raises
    ------
    InputError
        of type ``error``: where the function refuses the file, a library fails on it or atleak itself does, where
        reading it takes more than its budget or ends the child, and where no child can be started.
    """
    return list(_answers(function, data, file, error, budget, explain, size, streamed=False))


def read_apart_in_parts(
    function: Callable[[bytes], Iterator[Item]],
    data: bytes,
    file: str,
    error: type[InputError],
    budget: Budget,
    size: int,
) -> Generator[Item]:
    """Call a reading function in a child process and yield what it yields, as it comes.

    It does what `read_apart` does, but a file may be larger than memory: each part has the budget of the whole, and
    the child waits until the part before is taken. Whoever does not take all of them closes the iterator.

    Raises
    ------
    InputError
        as `read_apart`.
    """
    return _answers(function, data, file, error, budget, None, size, streamed=True)


def _answers(
    function: Callable[[bytes], Iterator[Item]],
    data: bytes,
    file: str,
    error: type[InputError],
    budget: Budget,
    explain: Callable[[bytes], Iterator[object]] | None,
    size: int | None,
    *,
    streamed: bool,
) -> Generator[Item]:
    memory, seconds = budget.limits(len(data) if size is None else size)
    place = Place(file)
    try:
        ending, answer = yield from _pool.read(_request(function, memory, seconds), data, streamed=streamed)
    except _ChildGone as gone:
        answer = None if explain is None or gone.reason == "time" else _explained_refusal(explain, data, memory)
        if answer is None:
            kind, suspicion = budget.kind, budget.suspicion
            problem = {
                "time": Sentence(
                    "reading this {kind} took longer than {limit:.0f} s and was stopped; {suspicion}",
                    kind=kind,
                    limit=seconds,
                    suspicion=suspicion,
                ),
                "memory": Sentence(
                    "reading this {kind} took more than {limit} MB of memory and was stopped; {suspicion}",
                    kind=kind,
                    limit=memory >> 20,
                    suspicion=suspicion,
                ),
                "death": Sentence(
                    "this {kind} cannot be read: what reads it broke down; {suspicion}", kind=kind, suspicion=suspicion
                ),
            }[gone.reason]
            raise error(problem, place=place, expected=budget.expected) from None
        ending, answer = answer
    except OSError as fault:
        raise error(
            Sentence(
                "a {kind} is read by a second Python process, and none can be started: {reason}",
                kind=budget.kind,
                reason=str(fault),
            ),
            place=place,
            expected=Sentence("a plain Python installation, or the table as .csv, which needs no second process"),
        ) from fault
    if ending == "refused":
        raise error(
            answer["problem"], place=Place(file, answer["sheet"]), value=answer["value"], expected=answer["expected"]
        )
    if ending == "fault":
        raise error(own_fault(answer["said"], answer["at"]), place=place) from FaultOfChild(answer["trace"])
    if ending == "damaged":
        problem = Sentence(
            "this {kind} is damaged or of a kind that cannot be read ({reason})", kind=budget.kind, reason=answer
        )
        raise error(problem, place=place, expected=budget.expected)


def _request(function: Callable[[bytes], Iterator[Any]], memory: int, seconds: float) -> Request:
    return Request(function.__module__, function.__qualname__, memory, seconds)


def _explained_refusal(explain: Callable[[bytes], Iterator[Any]], data: bytes, memory: int) -> Any:
    """Return how ``explain`` ended and the reason for which it refuses the file; None where it gives none."""
    with contextlib.suppress(_ChildGone, OSError):
        ending, answer = _ending_of(_pool.read(_request(explain, memory, EXPLAIN), data))
        return (ending, answer) if ending in ("refused", "fault") else None
    return None


def _ending_of(answers: Answers) -> tuple[str, Any]:
    """Return how answers end."""
    while True:
        try:
            next(answers)
        except StopIteration as end:
            ending: tuple[str, Any] = end.value
            return ending


class FaultOfChild(Exception):
    """A fault of atleak's own in the child process, with its traceback there."""


class _ChildGone(Exception):
    """The child ended, or was ended, before it had answered."""

    def __init__(self, reason: Literal["time", "memory", "death"]) -> None:
        super().__init__(reason)
        self.reason = reason


_TIMES = (datetime.date, datetime.datetime, datetime.time, datetime.timedelta)


class _PlainUnpickler(pickle.Unpickler):
    """Accepts plain data alone: a child that a damaged file has taken over must not run code in its parent."""

    _PLAIN = {(kind.__module__, kind.__name__): kind for kind in (*_TIMES, Sentence)}

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in self._PLAIN:
            return self._PLAIN[module, name]
        raise pickle.UnpicklingError(f"{module}.{name} is no plain data")


@dataclass
class _Deadline:
    """When a child is to have answered, by the monotonic clock [s]."""

    at: float


class _Child:
    """One child process."""

    def __init__(self, module: str) -> None:
        # what a library has taken of the addresses stays taken, and of those each kind of file has a number of its own
        self.module = module
        if not sys.executable or getattr(sys, "frozen", False):
            raise OSError(f"this Python names no interpreter to start (sys.executable is {sys.executable!r})")
        path = [entry or str(Path.cwd()) for entry in sys.path]
        code = "import sys; sys.path[:] = sys.argv[1:]; from atleak.intake.native.child import serve; serve()"
        self.process = subprocess.Popen(
            # without the site's own start-up, which is most of the time to start: its paths come from the parent
            [sys.executable, "-S", "-s", "-P", "-c", code, *path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "ARROW_IO_THREADS": "1"},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._input, self._output = cast(BinaryIO, self.process.stdin), cast(BinaryIO, self.process.stdout)
        self._killed = False
        try:
            self._watched = psutil.Process(self.process.pid)
            with self._limits(sys.maxsize, START):
                # where an environment's python only starts another one, as on Windows, the greeting names that one
                self._watched = psutil.Process(_plain_data(receive(self._output, 1000)))
        except (_ChildGone, psutil.Error, TypeError) as fault:
            self.kill()
            self.end()
            raise OSError(f"{sys.executable} does not start as a Python interpreter") from fault

    def memory(self) -> int:
        """Return the bytes of memory it uses; 0 when it has ended."""
        try:
            usage = self._watched.memory_info()
        except psutil.Error:
            return 0
        return max(usage.rss, getattr(usage, "private", 0))  # Windows: also what was moved out to the disk

    def usable(self) -> bool:
        """Return whether it may read another file."""
        if self._killed or self.process.poll() is not None:
            return False
        with contextlib.suppress(psutil.Error):
            # a child killed while several of its threads ran is dead for a moment before poll() can say so
            return self._watched.status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
        return False

    def end(self) -> None:
        """End it by closing its pipe; kill it where it does not react."""
        with contextlib.suppress(OSError):
            self._input.close()
        if not self._killed:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(LEAVE)
        self.kill()
        self.process.wait()
        self._output.close()

    def kill(self) -> None:
        """End it at once; the closed pipe ends the wait for its answer."""
        self._killed = True
        with contextlib.suppress(psutil.Error):
            self._watched.kill()
        with contextlib.suppress(OSError):
            self.process.kill()

    def disown(self) -> None:
        """Leave the child alone, in a process forked off the parent, which alone may end it."""
        self.process.returncode = 0

    def read(self, request: Request, data: bytes, *, streamed: bool) -> Answers:
        """Read a file. The limits are those of the whole answer, or of each item where these are taken one by one.

        Raises
        ------
        _ChildGone
            where the child ends before it has answered in full.
        """
        with self._limits(request.memory, request.seconds) as deadline:
            send(self._input, pickle.dumps(request))
            send(self._input, data)
            left = request.memory
            while True:
                frame = receive(self._output, left)
                left -= 0 if streamed else len(frame)
                kind, content = _plain_data(frame)
                if kind == "memory":
                    raise _ChildGone("memory")
                if kind != "item":
                    return kind, content
                del frame
                if streamed:
                    deadline.at = math.inf  # while others work on it, the child waits
                yield content
                if streamed:
                    deadline.at = time.monotonic() + request.seconds

    @contextlib.contextmanager
    def _limits(self, memory: int, seconds: float) -> Iterator[_Deadline]:
        """End the child when it passes a limit; the exchange with it then fails with `_ChildGone`."""
        done = threading.Event()
        passed: list[Literal["time", "memory"]] = []
        deadline = _Deadline(time.monotonic() + seconds)

        def watch() -> None:
            while not done.wait(CHECK_INTERVAL):
                if self.memory() > memory or time.monotonic() > deadline.at:
                    passed.append("time" if time.monotonic() > deadline.at else "memory")
                    self.kill()
                    return

        watcher = threading.Thread(target=watch, name="atleak reading limits", daemon=True)
        watcher.start()
        try:
            yield deadline
        except OverflowError as fault:
            raise _ChildGone("memory") from fault
        except (EOFError, OSError, pickle.UnpicklingError) as fault:
            done.set()
            watcher.join()
            raise _ChildGone(passed[0] if passed else "death") from fault
        finally:
            done.set()
            watcher.join()


def _plain_data(frame: bytes) -> Any:
    try:
        return _PlainUnpickler(io.BytesIO(frame)).load()
    except Exception as fault:  # a child gone wrong may send anything
        raise pickle.UnpicklingError("no plain data") from fault


class _Pool:
    """The children, of which at most `CHILDREN` read at the same time."""

    def __init__(self) -> None:
        self._places = threading.BoundedSemaphore(CHILDREN)
        self._idle: list[_Child] = []
        self._lock = threading.Lock()

    def read(self, request: Request, data: bytes, *, streamed: bool = False) -> Answers:
        """Read a file as `_Child.read` does, with a child that is free.

        Raises
        ------
        _ChildGone
            where the child ends before it has answered in full.
        OSError
            where no child can be started.
        """
        with self._borrowed(request.module) as child:
            return (yield from child.read(request, data, streamed=streamed))

    @contextlib.contextmanager
    def _borrowed(self, module: str) -> Iterator[_Child]:
        """Provide a child for one file; keep it afterwards if it answered in full and stayed small."""
        with self._places:
            child = self._take(module)
            try:
                yield child
            except BaseException:  # the rest of its answer is not read, so it cannot be used again
                child.kill()
                child.end()
                raise
            if child.usable() and child.memory() < KEPT:
                self._keep(child)
            else:
                child.end()

    def _keep(self, child: _Child) -> None:
        with self._lock:
            self._idle.append(child)
            surplus = [self._idle.pop(0) for _ in range(len(self._idle) - IDLE)]
        for each in surplus:
            each.end()

    def _take(self, module: str) -> _Child:
        while True:
            with self._lock:  # the one used last
                places = [place for place, each in enumerate(self._idle) if each.module == module]
                child = self._idle.pop(places[-1]) if places else None
            if child is None:
                return _Child(module)
            if child.usable():
                return child
            child.end()

    def close(self) -> None:
        """End the idle children."""
        while self._idle:
            with contextlib.suppress(IndexError):
                self._idle.pop().end()

    def disown(self) -> None:
        """Forget the children, which belong to the process this one was forked off."""
        for child in self._idle:
            child.disown()


_pool = _Pool()
atexit.register(lambda: _pool.close())


def _after_fork() -> None:
    global _pool
    _pool.disown()
    _pool = _Pool()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
