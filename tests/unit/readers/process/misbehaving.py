"""Reading functions that do in the child what a damaged file makes native code do there, and some that behave."""

from __future__ import annotations

import datetime as dt
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from atleak.readers.process.child import Refused, of_library

PLAIN: list[Any] = [
    [[1, 2.5, True, None, "µm", ""], (float("inf"), -(1 << 70))],
    {"day": dt.date(2026, 1, 2), "at": dt.datetime(2026, 1, 2, 3, 4, 5), "clock": dt.time(1, 2, 3)},
    {(0, 1): dt.timedelta(seconds=1.5), "raw": b"\0\xff", "array": bytearray(b"\1\2")},
]


def plain(data: bytes) -> Iterator[Any]:
    yield from PLAIN


def number_and_size(data: bytes) -> Iterator[tuple[int, int]]:
    time.sleep(0.05)
    yield os.getpid(), len(data)


def endless(data: bytes) -> Iterator[None]:
    while True:
        time.sleep(0.01)
    yield


def greedy(data: bytes) -> Iterator[None]:
    held = []
    while True:
        held.append(b"\1" * (1 << 22))
        time.sleep(0.001)
    yield


def greedy_at_once(data: bytes) -> Iterator[int]:
    yield len(bytearray(1 << 46))


def talkative(data: bytes) -> Iterator[bytes]:
    while True:
        yield data


def aborts(data: bytes) -> Iterator[str]:
    yield "half of it"
    os.abort()


def panics(data: bytes) -> Iterator[None]:
    raise BaseException("slice index\nstarts at 9")  # as a panic of a native reader comes: no Exception
    yield


def plain_error_of_a_library(data: bytes) -> Iterator[None]:
    with of_library():
        raise ValueError("year 0 is out of range")
    yield


def refuses(data: bytes) -> Iterator[None]:
    raise Refused("nothing in it", sheet="Tab", value="7", expected="more")
    yield


def prints(data: bytes) -> Iterator[str]:
    print("printed")
    print("complained", file=sys.stderr)
    os.write(1, b"written")
    os.write(2, b"written")
    yield "said"


class Foreign:
    """Unpickled by calling a function, as code smuggled into an answer would be."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (Path(self.path),)


def smuggles(data: bytes) -> Iterator[Foreign]:
    yield Foreign(data.decode())
