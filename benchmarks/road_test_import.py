"""Time the import of a road-test log against pandas' own reader, in the same run.

    python benchmarks/road_test_import.py [--rows 1800000] [--repeat 5] [--small]

Prints the ratio of medians for a clean CSV, the same with ``;`` and decimal comma, and one whose clock strings need
parsing, and the peak memory of each import against 6 times the file's size plus 200 MB.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from timing import options

from atleak.readers.logs import read_road_test

OPTIONS = options(__doc__)
OPTIONS.add_argument("--rows", type=int, default=1_800_000)
OPTIONS.add_argument("--repeat", type=int, default=5)
OPTIONS.add_argument("--json", action="store_true", help="print one JSON object")
SMALL = {"rows": 2_000, "repeat": 1}
LIMITS = {"clean": 1.4, "decimal comma": 1.4, "clock strings": 1.4}


def write_logs(folder: Path, rows: int) -> dict[str, Path]:
    """Write three logs of the same drive: six columns, 100 Hz."""
    noise = np.random.default_rng(7)
    seconds = np.arange(rows) * 0.01
    engine = 800 + 1000 * (1 + np.sin(seconds / 30)) + noise.normal(0, 5, rows)
    frame = pd.DataFrame(
        {
            "time [s]": seconds.round(2),
            "engine_speed [rpm]": engine.round(2),
            "p_g [kPa]": (400 + 0.2 * engine + noise.normal(0, 3, rows)).round(1),
            "p_k [kPa]": (300 + 0.05 * engine + noise.normal(0, 2, rows)).round(1),
            "atf_temperature [°C]": (80 + 10 * np.sin(seconds / 2000)).round(1),
            "gear": 1 + (seconds // 40 % 5).astype(int),
        }
    )
    paths = {name: folder / f"{name.replace(' ', '_')}.csv" for name in LIMITS}
    frame.to_csv(paths["clean"], index=False)
    frame.to_csv(paths["decimal comma"], index=False, sep=";", decimal=",")
    clock = pd.Timestamp("2026-03-01 08:00:00") + pd.to_timedelta(np.arange(rows) * 10, unit="ms")
    frame = frame.rename(columns={"time [s]": "Time"}).assign(Time=clock.strftime("%Y-%m-%d %H:%M:%S.%f").str[:-3])
    frame.to_csv(paths["clock strings"], index=False)
    return paths


def bare(name: str, path: Path) -> Callable[[], object]:
    """Read the file with pandas alone."""
    options = {
        "clean": {},
        "decimal comma": {"sep": ";", "decimal": ","},
        "clock strings": {"parse_dates": ["Time"]},
    }[name]
    return lambda: pd.read_csv(path, engine="c", **options)


def timed(work: Callable[[], object]) -> float:
    """Return the seconds that one call takes."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


PEAK = """
import sys
from atleak.readers.logs import read_road_test
read_road_test(sys.argv[1])
with open("/proc/self/status", encoding="ascii") as status:
    print(next(line.split()[1] for line in status if line.startswith("VmHWM")))
"""


def peak_megabytes(path: Path) -> float | None:
    """Return the peak memory of a process that only imports the log, None where the system does not tell."""
    if not Path("/proc/self/status").exists():
        return None
    run = subprocess.run([sys.executable, "-c", PEAK, str(path)], capture_output=True, text=True, check=True)
    return int(run.stdout) / 1024


def main(arguments: argparse.Namespace) -> int:
    """Run the benchmark; return exit status 1 past a limit, which the small size does not check."""
    if arguments.small:
        arguments = argparse.Namespace(**vars(arguments) | SMALL)
    results, passed = {}, True
    with tempfile.TemporaryDirectory() as folder:
        for name, path in write_logs(Path(folder), arguments.rows).items():
            ours, theirs = [], []
            timed(lambda path=path: read_road_test(path))
            for _ in range(arguments.repeat):  # in turn, so that a busy machine hurts both alike
                theirs.append(timed(bare(name, path)))
                ours.append(timed(lambda path=path: read_road_test(path)))
            ratio = statistics.median(ours) / statistics.median(theirs)
            size, peak = path.stat().st_size / 2**20, peak_megabytes(path)
            results[name] = {
                "file_mb": size, "import_s": statistics.median(ours), "pandas_s": statistics.median(theirs),
                "ratio": ratio, "limit": LIMITS[name], "peak_mb": peak, "peak_limit_mb": 6 * size + 200,
            }  # fmt: skip
            passed &= ratio <= LIMITS[name] and (peak is None or peak <= 6 * size + 200)
    if arguments.json:
        print(json.dumps(results, indent=1))
    else:
        for name, row in results.items():
            peak = f"{row['peak_mb']:.0f}" if row["peak_mb"] else "?"
            print(
                f"{name:14} import {row['import_s']:.3f} s, pandas {row['pandas_s']:.3f} s, ratio {row['ratio']:.2f} "
                f"(limit {row['limit']}), peak {peak} MB (limit {row['peak_limit_mb']:.0f})"
            )
    return 0 if passed or arguments.small else 1


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
