"""How a test tells that work grows no faster than what is worked on: by counting it, as a clock tells of the machine.

`most_calls` counts every call of a function, Python's and C's: a loop that runs too often fails, the same everywhere.
What one call does by itself is not counted. Where that could explode, in a regular expression that tries every way or a
range that is written out, the input is so large that it would take many minutes, and `in_time` bounds it generously.
How fast the code is, `benchmarks` say, as a ratio.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from cProfile import Profile

MINUTE = 60.0  # [s] of this process's own time


@contextmanager
def most_calls(number: int) -> Iterator[None]:
    """Fail where more functions are called than so many, in this thread."""
    profile = Profile()
    profile.enable()
    try:
        yield
    finally:
        profile.disable()
    made = sum(entry.callcount for entry in profile.getstats())
    assert made <= number, f"{made} calls, where {number} are enough"


@contextmanager
def in_time() -> Iterator[None]:
    """Fail where what takes a moment takes a minute of this process's own time, however busy the machine is."""
    start = time.process_time()
    yield
    assert time.process_time() - start < MINUTE
