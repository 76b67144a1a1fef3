"""Calls a reading function in a child process, within limits of time and memory.

Children keep running for the next file of the same kind and serve one thread at a time. When one dies, or is ended at a
limit, the file it was reading is refused; the next file gets a new child.

To have another kind of file read there, write a function that takes the file's bytes or path and yields plain data
(None, numbers, texts, sentences, bytes, bytearrays, dates, times, and lists, tuples and dicts of them), in a module
that imports nothing heavy at its top, and hand it to `read_apart`.
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
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, Literal, TypeVar, cast

from atleak.common.damage import own_fault
from atleak.common.errors import InputError, Place
from atleak.common.sentences import Sentence
from atleak.readers.process.child import Request, receive, send

_Item = TypeVar("_Item")

CHILDREN = 2  # files read at the same time; a third waits. Each may take the memory of its budget
IDLE = 4  # children that are kept for the next file, of all kinds together
KEPT = 300 << 20  # bytes above which a child is ended after its file: memory once used is not given back
START = 30.0  # [s] a child may take to start: it takes 0.02, on a cold disk behind a virus scanner a hundred times that
CHECK_INTERVAL = 0.02  # [s] between two checks: memory fills at 2 GB/s at most, so a limit is passed by 40 MB
LEAVE = 5.0  # [s] a child may take to end by itself when it is no longer needed


@dataclass(frozen=True)
class ProcessBudget:
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


# A workbook takes 8 bytes of memory a byte of file; packed four times as tightly, as a log of round numbers is, 32. A
# measuring sheet takes 30 MB and 0.03 s.
WORKBOOK = ProcessBudget(
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
MDF = ProcessBudget(
    kind=Sentence("MDF file"),
    memory=700 << 20,
    memory_per_byte=30.0,
    seconds=30.0,
    seconds_per_byte=2e-6,
    suspicion=Sentence("it is damaged"),
    expected=Sentence("the log saved anew, or exported as .csv, by the logger's own program"),
)
# pyarrow takes 80 MB. Of a table whose columns hardly change, a byte of file unfolds to many.
PARQUET = replace(MDF, kind=Sentence("Parquet file"))


_GONE = {
    "time": Sentence("reading this {kind} took longer than {limit:.0f} s and was stopped; {suspicion}"),
    "memory": Sentence("reading this {kind} took more than {limit} MB of memory and was stopped; {suspicion}"),
    "death": Sentence("this {kind} cannot be read: what reads it broke down; {suspicion}"),
}


def read_apart(
    function: Callable[..., Iterator[_Item]],  # at the top level of a module the child can import; yields plain data
    source: bytes | Path,  # the file's bytes, or where it lies: the function gets the path as text
    file: str,  # its name in messages
    error: type[InputError],  # says why the file is refused
    budget: ProcessBudget,
    **asked: Any,  # what else the function is to know, plain data too
) -> list[_Item]:
    """Call a reading function in a child process and return all it yields about a file.

    Raises
    ------
    InputError
        of type ``error``: where the function refuses the file, a library fails on it or atleak itself does, where
        reading it takes more than its budget or ends the child, and where no child can be started.
    """
    return list(read_apart_in_parts(function, source, file, error, budget, streamed=False, **asked))


def read_apart_in_parts(
    function: Callable[..., Iterator[_Item]],
    source: bytes | Path,
    file: str,
    error: type[InputError],
    budget: ProcessBudget,
    *,
    streamed: bool = True,
    **asked: Any,
) -> Generator[_Item]:
    """Call a reading function in a child process and yield what it yields, as it comes, as `read_apart` does.

    ``streamed``, a file may be larger than memory: each part has the budget of the whole, and the child waits until the
    part before is taken. Whoever does not take all of them closes the iterator.
    """
    memory, seconds = budget.limits(len(source) if isinstance(source, bytes) else source.stat().st_size)
    kind, content = "end", dict[str, Any]()
    try:
        request = Request(function.__module__, function.__qualname__, memory, seconds, asked)
        for kind, content in _pool.read(request, source, streamed=streamed):
            if kind == "item":
                yield content
    except _ChildGone as gone:
        limit = seconds if gone.reason == "time" else memory >> 20
        problem = _GONE[gone.reason].of(kind=budget.kind, limit=limit, suspicion=budget.suspicion)
        raise error(problem, place=Place(file), expected=budget.expected) from None
    except OSError as fault:
        text = Sentence("a {kind} is read by a second Python process, and none can be started: {reason}")
        expected = Sentence("a plain Python installation, or the table as .csv, which needs no second process")
        raise error(text.of(kind=budget.kind, reason=str(fault)), place=Place(file), expected=expected) from fault
    if kind == "refused":
        sheet, value, expected = (content[name] for name in ("sheet", "value", "expected"))
        raise error(content["problem"], place=Place(file, sheet), value=value, expected=expected)
    if kind == "fault":
        raise error(own_fault(content["said"], content["at"]), place=Place(file)) from FaultOfChild(content["trace"])
    if kind == "damaged":
        text = Sentence("this {kind} is damaged or of a kind that cannot be read ({reason})")
        raise error(text.of(kind=budget.kind, reason=content), place=Place(file), expected=budget.expected)


class FaultOfChild(Exception):
    """A fault of atleak's own in the child process, with its traceback there."""


class _ChildGone(Exception):
    """The child ended, or was ended, before it had answered: the reason is one of `_GONE`."""

    @property
    def reason(self) -> str:
        return str(self.args[0])


_TIMES = (datetime.date, datetime.datetime, datetime.time, datetime.timedelta)


class _PlainUnpickler(pickle.Unpickler):
    """Accepts plain data alone: a child that a damaged file has taken over must not run code in its parent."""

    _PLAIN = {(kind.__module__, kind.__name__): kind for kind in (*_TIMES, Sentence)}

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in self._PLAIN:
            return self._PLAIN[module, name]
        raise pickle.UnpicklingError(f"{module}.{name} is no plain data")


class _Child:
    """One child process."""

    def __init__(self, module: str) -> None:
        # what a library has taken of the addresses stays taken, and of those each kind of file has a number of its own
        self.module = module
        if not sys.executable or getattr(sys, "frozen", False):
            raise OSError(f"this Python names no interpreter to start (sys.executable is {sys.executable!r})")
        path = [entry or str(Path.cwd()) for entry in sys.path]
        code = "import sys; sys.path[:] = sys.argv[1:]; from atleak.readers.process.child import serve; serve()"
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
        import psutil  # a sheet or a log of plain text needs no process of its own

        self._gone, self._dead = psutil.Error, (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
        self._killed, self._deadline = False, math.inf  # by the monotonic clock [s]
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
        except self._gone:
            return 0
        return max(usage.rss, getattr(usage, "private", 0))  # Windows: also what was moved out to the disk

    def usable(self) -> bool:
        """Return whether it may read another file."""
        if self._killed or self.process.poll() is not None:
            return False
        with contextlib.suppress(self._gone):
            # a child killed while several of its threads ran is dead for a moment before poll() can say so
            return self._watched.status() not in self._dead
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
        with contextlib.suppress(self._gone):
            self._watched.kill()
        with contextlib.suppress(OSError):
            self.process.kill()

    def read(self, request: Request, source: bytes | Path, *, streamed: bool) -> Iterator[tuple[str, Any]]:
        """Read a file: yield its items, and at last how the answer ended; `_ChildGone` where that is cut short.

        The limits are those of the whole answer, or of each item where these are taken one by one.
        """
        with self._limits(request.memory, request.seconds):
            path = None if isinstance(source, bytes) else str(source.absolute())
            send(self._input, pickle.dumps((request, path)))
            send(self._input, source if isinstance(source, bytes) else b"")
            left, kind = request.memory, "item"
            while kind == "item":
                frame = receive(self._output, left)
                left -= 0 if streamed else len(frame)
                kind, content = _plain_data(frame)
                del frame
                if kind == "memory":
                    raise _ChildGone("memory")
                if streamed:
                    self._deadline = math.inf  # while others work on it, the child waits
                yield kind, content
                if streamed:
                    self._deadline = time.monotonic() + request.seconds

    @contextlib.contextmanager
    def _limits(self, memory: int, seconds: float) -> Iterator[None]:
        """End the child when it passes a limit; the exchange with it then fails with `_ChildGone`."""
        done = threading.Event()
        passed: list[Literal["time", "memory"]] = []
        self._deadline = time.monotonic() + seconds

        def watch() -> None:
            while not done.wait(CHECK_INTERVAL):
                late = time.monotonic() > self._deadline
                if late or self.memory() > memory:
                    passed.append("time" if late else "memory")
                    self.kill()
                    return

        watcher = threading.Thread(target=watch, name="atleak reading limits", daemon=True)
        watcher.start()
        try:
            yield
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

    def read(self, request: Request, source: bytes | Path, *, streamed: bool = False) -> Iterator[tuple[str, Any]]:
        """Read a file as `_Child.read` does, with a child that is free; `OSError` where none can be started.

        It is kept for the next file if it answered in full and stayed small.
        """
        with self._places:
            child = self._taken(request.module) or _Child(request.module)
            try:
                yield from child.read(request, source, streamed=streamed)
            except BaseException:  # the rest of its answer is not read, so it cannot be used again
                child.kill()
                child.end()
                raise
            surplus = [child]
            if child.usable() and child.memory() < KEPT:
                with self._lock:
                    self._idle.append(child)
                    surplus = [self._idle.pop(0) for _ in range(len(self._idle) - IDLE)]
            for each in surplus:
                each.end()

    def _taken(self, module: str) -> _Child | None:
        """Return the idle child that was used last on files of a kind; None where there is none."""
        while True:
            with self._lock:
                child = next((each for each in reversed(self._idle) if each.module == module), None)
                if child is None:
                    return None
                self._idle.remove(child)
            if child.usable():
                return child
            child.end()

    def close(self) -> None:
        """End the idle children."""
        while self._idle:
            with contextlib.suppress(IndexError):
                self._idle.pop().end()

    def disown(self) -> None:
        """Leave the children alone, in a process forked off the parent, which alone may end them."""
        for child in self._idle:
            child.process.returncode = 0


_pool = _Pool()
atexit.register(lambda: _pool.close())


def _after_fork() -> None:
    global _pool
    _pool.disown()
    _pool = _Pool()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
