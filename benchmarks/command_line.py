"""Time start-up and run of ``atleak diagnose`` on the sample job, beside importing NumPy and pandas.

    python benchmarks/command_line.py [--small]

Whole processes, imports compiled beforehand, median of 5 taken in turn. Goal: at most 3 times.
"""

from __future__ import annotations

import argparse
import compileall
import os
import statistics
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

from timing import options

OPTIONS = options(__doc__)
ROOT = Path(__file__).resolve().parents[1]
SAMPLE = ROOT / "sample_data"
PEER = [sys.executable, "-c", "import numpy, pandas"]
RUN = [
    *(sys.executable, "-m", "atleak", "diagnose", str(SAMPLE / "measuring_sheet_four_speed.xlsx")),
    *("--road-test", str(SAMPLE / "minimum_acceleration_test.csv"), "--json", os.devnull),
]


def main(chosen: argparse.Namespace) -> None:
    spec = find_spec("atleak")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    for folder in spec.submodule_search_locations:
        compileall.compile_dir(folder, quiet=2)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    times: dict[str, list[float]] = {"peer": [], "run": []}
    for _ in range(2 if chosen.small else 6):
        for name, command in (("peer", PEER), ("run", RUN)):
            start = time.perf_counter()
            subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
            times[name].append(time.perf_counter() - start)
    # the first run of each compiles the modules that are not compiled yet
    peer, run = (statistics.median(durations[1:]) for durations in times.values())
    print(f"atleak diagnose / import numpy, pandas   {run / peer:.2f}   ({run * 1e3:.0f} ms / {peer * 1e3:.0f} ms)")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
