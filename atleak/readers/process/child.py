"""Runs in the reading process: it takes a file's bytes, calls one function on them and answers with plain data.

This module and those with the functions import nothing heavy at their top: the process starts as fast as they do.

Parent and child exchange frames, eight bytes of length and then the content. The child greets with its process number.
A request is two frames: the function with its limits and perhaps the file's path, then the file where there is none.
The answer is one frame for each item the function yields, then one that ends it or says why the file is refused.
"""

from __future__ import annotations

import contextlib
import faulthandler
import os
import pickle
import queue
import signal
import struct
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any, BinaryIO

from atleak.common.sentences import Sentence

_LENGTH = struct.Struct(">Q")
ADDRESSES = 1 << 30  # bytes beyond the memory limit: libraries, stacks, what is reserved and never used
_ERROR_SHOWN = 200  # characters of a reader's own message
_TRACE_SHOWN = 5000


class Refused(Exception):
    """Raised by a reading function: why the file cannot be used, in the words of `atleak.common.errors.InputError`."""

    def __init__(
        self, problem: Sentence, *, expected: Sentence | None = None, sheet: str | None = None, value: str | None = None
    ) -> None:
        super().__init__(problem)
        self.words = {"problem": problem, "expected": expected, "sheet": sheet, "value": value}


class Damaged(Exception):
    """Raised by a reading function: a library cannot make sense of the file, for the reason that it gives."""


@contextlib.contextmanager
def of_library() -> Iterator[None]:
    """Take whatever a compiled library raises here for what it says of the file: panics and plain errors alike."""
    try:
        yield
    except (Refused, MemoryError, GeneratorExit):
        raise
    except BaseException as error:
        raise Damaged(_said(error)) from error


@dataclass(frozen=True)
class Request:
    """One file to read: by which function, within which limits [bytes], [s], and what it is asked."""

    module: str
    function: str
    memory: int
    seconds: float
    asked: dict[str, Any]


def send(stream: BinaryIO, content: bytes) -> None:
    """Write one frame."""
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: BinaryIO, limit: int | None = None) -> bytes:
    """Read one frame: `EOFError` where the stream ends before it does, `OverflowError` where it is over the limit."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    if limit is not None and length > limit:
        raise OverflowError
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content


def serve() -> None:
    """Answer requests until standard input is closed, which also happens when the parent dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is meant for the parent
    source, target = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    silence = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):  # what a library prints must reach neither the answer nor the user's terminal
        os.dup2(silence, standard)
    _no_dumps()
    requests: queue.SimpleQueue[tuple[bytes, bytes]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(source, requests), daemon=True).start()
    send(target, pickle.dumps(os.getpid()))
    while True:
        packed_request, data = requests.get()
        request: Request
        request, path = pickle.loads(packed_request)
        _limit_addresses(request.memory + ADDRESSES)
        # a thread below Python ends the process if the parent is no longer there to do so
        faulthandler.dump_traceback_later(2 * request.seconds, exit=True)
        for answer in _answers(request, data if path is None else path):
            send(target, pickle.dumps(answer, protocol=5))
            faulthandler.dump_traceback_later(2 * request.seconds, exit=True)  # anew: the parent may take its time
        faulthandler.cancel_dump_traceback_later()
        del packed_request, data, answer


def _listen(source: BinaryIO, requests: queue.SimpleQueue[tuple[bytes, bytes]]) -> None:
    while True:
        try:
            requests.put((receive(source), receive(source)))
        except EOFError:
            os._exit(0)


def _answers(request: Request, source: bytes | str) -> Iterator[tuple[str, Any]]:
    try:
        function: Callable[..., Iterator[Any]] = getattr(import_module(request.module), request.function)
        for item in function(source, **request.asked):
            yield "item", item
    except Refused as refused:
        yield "refused", refused.words
    except MemoryError:
        yield "memory", None
    except BaseException as error:  # noqa: BLE001 - readers raise errors without a common base, panics among them
        yield _damage_or_fault(error)
    else:
        yield "end", None


def _said(error: BaseException) -> str:
    return " ".join(str(error).split())[:_ERROR_SHOWN] or type(error).__name__


def _damage_or_fault(error: BaseException) -> tuple[str, Any]:
    """Return what ends the answer: why a library calls the file damaged, or which line of atleak failed on it."""
    from atleak.common.damage import own_line, reason_in_short  # here, because a sound file does without

    at = own_line(error) if type(error).__module__ == "builtins" else None  # a library's own kind is the library's
    if at is None:
        return "damaged", _said(error)
    shown = "".join(traceback.format_exception(error))[-_TRACE_SHOWN:]
    return "fault", {"said": reason_in_short(error), "at": at, "trace": shown}


def _no_dumps() -> None:
    """Make a crash leave no file on the disk and no window on the screen."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.SetErrorMode(msvcrt.SEM_FAILCRITICALERRORS | msvcrt.SEM_NOGPFAULTERRORBOX)
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _limit_addresses(limit: int) -> None:
    """Let the system itself refuse memory, where it can, before the parent's next check."""
    if sys.platform == "win32":
        return
    import resource

    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    wanted = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    with contextlib.suppress(ValueError, OSError):  # macOS knows the limit but does not accept it
        resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))
