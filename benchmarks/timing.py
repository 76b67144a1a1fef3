"""Provide what every benchmark shares: its one option, and the median of some runs in one process."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any


def options(doc: str) -> argparse.ArgumentParser:
    """Return the command line of a benchmark: its docstring, and ``--small`` for a run of seconds."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--small", action="store_true", help="seconds instead of minutes: that it runs, not how fast")
    return parser


def median_time(run: Callable[[], Any], rounds: int = 7, clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the median duration of a run [s], by the clock on the wall or by another one."""
    times = []
    for _ in range(rounds):
        start = clock()
        run()
        times.append(clock() - start)
    return statistics.median(times)
