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


def median_time(run: Callable[[], Any], rounds: int = 7) -> float:
    """Return the median duration of a run [s]."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)
