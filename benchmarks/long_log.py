"""Read a log of more than a day at 100 Hz, beside pandas' readers of the same columns in the same run.

    python benchmarks/long_log.py [--samples 10000000] [--form parquet] [--form csv] [--folder DIR] [--small]

The log has time and five channels that are known, accelerations through four gears, one a minute, with noise, cold and
hot, and ten columns that nobody knows, written block by block with a fixed seed. A process of its own reads it into a
road test, another one reads the same six columns with `pandas.read_csv` or `pandas.read_parquet` into a frame.

Printed are the time of both, and the most memory that they took, with that of the process in which Parquet is
read. Goals: 1 GB at 10 million samples in the process that holds the log, and no more time than twice pandas'. The file
takes 0.9 GB as CSV and 0.2 GB as Parquet, in a folder that is deleted at the end. ``--small``: 60 000 samples.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
from timing import options

from atleak.readers.logs import read_road_test

FORMS = ("parquet", "csv")
OPTIONS = options(__doc__)
OPTIONS.add_argument("--samples", type=int, default=10_000_000, metavar="N")
OPTIONS.add_argument("--form", action="append", choices=FORMS, help="both unless given")
OPTIONS.add_argument("--folder", type=Path, help="where the log is written; that of temporary files unless given")
SMALL = 60_000
BLOCK = 1 << 19  # samples that are written at once
CYCLE = 6000  # samples of an acceleration
WARM = 200_000  # samples until the fluid is hot
MEMORY, TIMES = 1e9, 2.0  # goals [bytes], and times pandas


def blocks(samples: int) -> Iterator[pa.Table]:
    """Yield the log block by block."""
    for number, start in enumerate(range(0, samples, BLOCK)):
        count = np.arange(start, min(start + BLOCK, samples))
        draw = np.random.default_rng(number)
        through = count % CYCLE / CYCLE * 4 % 1.0
        known = {
            "time [s]": count / 100.0,
            "engine_speed [rpm]": (900.0 + 2600.0 * through).round(1),
            "p_g [kPa]": (480.0 + 500.0 * through + draw.normal(0.0, 2.0, len(count))).round(2),
            "p_k [kPa]": (215.0 + 225.0 * through).round(2),
            "atf_temperature [°C]": (60.0 + 45.0 * np.minimum(count / WARM, 1.0) + 3.0 * np.sin(count / 3e4)).round(1),
            "gear": count % CYCLE * 4 // CYCLE + 1,
        }
        others = {f"sensor {each} [V]": draw.normal(5.0, 1.0, len(count)).round(2) for each in range(10)}
        yield pa.table(known | others)


def write_log(path: Path, samples: int) -> None:
    """Write the log in the form that its name says."""
    make = pq.ParquetWriter if path.suffix == ".parquet" else pyarrow.csv.CSVWriter
    with make(path, next(blocks(1)).schema) as writer:
        for block in blocks(samples):
            writer.write_table(block)


def read_here(path: Path) -> list[float]:
    """Return the mean of every column of the road test."""
    test = read_road_test(path)
    return [float(np.mean(test.time)), *(float(np.nanmean(test.channels[name].good)) for name in test.channels)]


def read_plainly(path: Path) -> list[float]:
    """Return the mean of the same columns."""
    names = next(blocks(1)).column_names[:6]
    frame = pd.read_parquet(path, columns=names) if path.suffix == ".parquet" else pd.read_csv(path, usecols=names)
    return [float(frame[name].mean()) for name in names]


def _answer(work: Callable[..., Any], given: tuple[Any, ...], said: Any) -> None:
    begun = time.perf_counter()
    answer = work(*given)
    said.send((time.perf_counter() - begun, answer))


def apart(work: Callable[..., Any], *given: Any) -> tuple[float, tuple[int, int], Any]:
    """Do some work in a process of its own; return its time [s], the most memory [bytes] and its answer.

    The memory is that of the process alone, and with those that it starts.
    """
    start = multiprocessing.get_context("spawn")
    hears, says = start.Pipe(duplex=False)
    process = start.Process(target=_answer, args=(work, given, says))
    process.start()
    says.close()
    with watched(process.pid) as most:
        seconds, answer = hears.recv()
    process.join()
    return seconds, (most[0], most[1]), answer


@contextmanager
def watched(pid: int | None) -> Iterator[list[int]]:
    """Note the most memory that a process has taken [bytes], alone and with those it starts."""
    most, done, process = [0, 0], threading.Event(), psutil.Process(pid)

    def watch() -> None:
        while not done.wait(0.02):
            with suppress(psutil.Error):
                own = process.memory_info().rss
                most[0] = max(most[0], own)
                most[1] = max(most[1], own + sum(each.memory_info().rss for each in process.children(recursive=True)))

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield most
    finally:
        done.set()
        thread.join()


def run(folder: Path, form: str, samples: int, *, small: bool) -> bool:
    """Write and read one log; return whether the goals are met."""
    path = folder / f"log.{form}"
    write_log(path, samples)
    print(f"{form}: {samples} samples of 16 columns, {path.stat().st_size / 1e9:.2f} GB")
    plain, (least, _), expected = apart(read_plainly, path)
    seconds, (alone, most), found = apart(read_here, path)
    path.unlink()
    if not np.isclose(found[0], expected[0], rtol=1e-12) or len(found) != len(expected):
        raise SystemExit(f"{form}: not the log that was written")
    print(f"  read in {seconds:.1f} s; by pandas in {plain:.1f} s: {seconds / plain:.2f} times")
    memory = ", ".join(f"{each / 1e6:.0f}" for each in (alone, most, least))
    print(f"  at most MB of memory: {memory} (alone, with the child process, pandas)")
    met = small or (alone <= MEMORY and seconds <= TIMES * plain)
    if not met:
        print("  past the goal")
    return met


def main(arguments: argparse.Namespace) -> None:
    samples = SMALL if arguments.small else arguments.samples
    with tempfile.TemporaryDirectory(prefix="atleak-long-log-", dir=arguments.folder) as name:
        met = [run(Path(name), form, samples, small=arguments.small) for form in arguments.form or FORMS]
    if not all(met):
        raise SystemExit(1)


if __name__ == "__main__":
    main(OPTIONS.parse_args())
