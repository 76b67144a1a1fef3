"""Evaluate a log that is far larger than memory, as a worker of a fleet does, beside a plain look through its numbers.

    python benchmarks/long_log.py [--samples 100000000] [--form parquet] [--form csv] [--folder DIR] [--small]

The log is one of six columns at 100 Hz, accelerations through four gears, one a minute, with noise, cold and hot,
written block by block with a fixed seed; with it goes a measuring sheet of the four-speed valve body. A process of its
own finds the unit in a table and evaluates it with what a worker calls. Another looks through the same file in chunks,
with pandas' reader of CSV or pyarrow's of Parquet, and computes the mean of every column.

Printed are the samples a second of both, and the most memory that the evaluation took, that of the process in which
Parquet is read with it. Goal: 1.5 GB. 10^8 samples take 4 GB on disk as CSV and 1 GB as Parquet, and their evaluation
5 GB for columns beside them, all in a folder that is deleted at the end. ``--small``: 60 000 samples, read in pieces
and whole, whose results must be equal to 1e-12.
"""

from __future__ import annotations

import argparse
import csv
import math
import multiprocessing
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
from fleet import CONTROLLER, sheet
from timing import options

from atleak.catalogue.controller_reading import load_controller
from atleak.fleet.sources import find_units
from atleak.fleet.work import Room, evaluate

FORMS = ("parquet", "csv")
OPTIONS = options(__doc__)
OPTIONS.add_argument("--samples", type=int, default=100_000_000, metavar="N")
OPTIONS.add_argument("--form", action="append", choices=FORMS, help="both unless given")
OPTIONS.add_argument("--folder", type=Path, help="where the log is written; that of temporary files unless given")
SMALL = 60_000
BLOCK = 1 << 20  # samples that are written at once
CHUNK = 1 << 20  # samples that are looked through at once
MEMORY = 1.5e9  # goal [bytes]
CYCLE = 6000  # samples of an acceleration: one a minute, since every event is a row of the result
WARM = 200_000  # samples until the fluid is hot
BYTES = {"parquet": 12.0, "csv": 40.0}  # a sample on disk
COLUMNS = 8 * 8.0  # bytes a sample that its evaluation puts on disk
TOLERANCE = 1e-12
OWN = {"evaluated_at", "seconds", "road_in_pieces", "result_sha256"}  # of a row, what may differ


# --- the log


def blocks(samples: int) -> Iterator[pa.Table]:
    """Yield the log block by block."""
    for number, start in enumerate(range(0, samples, BLOCK)):
        count = np.arange(start, min(start + BLOCK, samples))
        draw = np.random.default_rng(number)
        through = count % CYCLE / CYCLE * 4 % 1.0
        columns = {
            "time [s]": count / 100.0,
            "engine_speed [rpm]": (900.0 + 2600.0 * through).round(1),
            "p_g [kPa]": (480.0 + 500.0 * through + draw.normal(0.0, 2.0, len(count))).round(2),
            "p_k [kPa]": (215.0 + 225.0 * through).round(2),
            "atf_temperature [°C]": (60.0 + 45.0 * np.minimum(count / WARM, 1.0) + 3.0 * np.sin(count / 3e4)).round(1),
            "gear": count % CYCLE * 4 // CYCLE + 1,
        }
        yield pa.table(columns)


def write_log(path: Path, samples: int) -> None:
    """Write the log in the form that its name says."""
    schema = next(blocks(1)).schema
    make = pq.ParquetWriter if path.suffix == ".parquet" else pyarrow.csv.CSVWriter
    with make(path, schema) as writer:
        for block in blocks(samples):
            writer.write_table(block)


def write_unit(folder: Path, log: Path) -> Path:
    """Write the measuring sheet, and the table that names it and the log; return the table's path."""
    (folder / "sheet.csv").write_text(sheet(load_controller(CONTROLLER).lands, 1), encoding="utf-8")
    table = folder / f"{log.suffix[1:]}_unit.csv"
    with table.open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(["sheet", "log", "controller", "job"])
        rows.writerow(["sheet.csv", log.name, CONTROLLER, "J1"])
    return table


# --- processes of their own


def evaluated(table: Path, memory: Sequence[int | None]) -> list[dict[str, list[dict[str, Any]]]]:
    """Evaluate the one unit of a table, as a worker does that may take so much memory [bytes], as often as is said."""
    found = []
    for each in memory:
        (unit,) = find_units([table])
        rows = evaluate(unit, room=Room(each, table.parent))
        told = rows.tables if len(memory) > 1 else {name: rows.tables.get(name) for name in ("units", "errors")}
        found.append({name: table.to_pylist() for name, table in told.items() if table is not None})
    return found


def looked_through(path: Path) -> list[float]:
    """Return the mean of every column, read in chunks."""
    totals, count = 0.0, 0
    for chunk in chunks(path):
        totals, count = totals + chunk.sum(axis=0), count + len(chunk)
    return [float(total) / count for total in totals]


def chunks(path: Path) -> Iterator[np.ndarray]:
    """Yield the numbers of a log."""
    if path.suffix == ".parquet":
        for batch in pq.ParquetFile(path).iter_batches(CHUNK):
            yield np.column_stack([column.to_numpy() for column in batch.columns])
    else:
        with pd.read_csv(path, chunksize=CHUNK) as reader:
            for frame in reader:
                yield frame.to_numpy()


def _answer(work: Callable[..., Any], given: tuple[Any, ...], said: Any) -> None:
    begun = time.perf_counter()
    answer = work(*given)
    said.send((time.perf_counter() - begun, answer))


def apart(work: Callable[..., Any], *given: Any) -> tuple[float, int, Any]:
    """Do some work in a process of its own; return its time [s], the most memory it took [bytes] and its answer."""
    start = multiprocessing.get_context("spawn")
    hears, says = start.Pipe(duplex=False)
    process = start.Process(target=_answer, args=(work, given, says))
    process.start()
    says.close()
    with watched(process.pid) as most:
        seconds, answer = hears.recv()
    process.join()
    return seconds, most[0], answer


@contextmanager
def watched(pid: int | None) -> Iterator[list[int]]:
    """Note the most memory that a process and those it starts have taken together [bytes]."""
    most, done, process = [0], threading.Event(), psutil.Process(pid)

    def watch() -> None:
        while not done.wait(0.05):
            with suppress(psutil.Error):
                all_ = [process, *process.children(recursive=True)]
                most[0] = max(most[0], sum(each.memory_info().rss for each in all_))

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield most
    finally:
        done.set()
        thread.join()


# --- what comes out


def differences(one: Any, other: Any, at: str = "") -> Iterator[str]:
    """Yield where two results differ by more than the tolerance."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in one.keys() | other.keys():
            if key not in OWN:
                yield from differences(one.get(key), other.get(key), f"{at}.{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for place, pair in enumerate(zip(one, other, strict=True)):
            yield from differences(*pair, f"{at}[{place}]")
    elif isinstance(one, float) and isinstance(other, float):
        if not math.isclose(one, other, rel_tol=TOLERANCE) and not (one != one and other != other):
            yield f"{at}: {one!r}, {other!r}"
    elif one != other:
        yield f"{at}: {one!r}, {other!r}"


def run(folder: Path, form: str, samples: int, *, small: bool) -> bool:
    """Write, evaluate and look through one log; return whether the goal is met."""
    path = folder / f"log.{form}"
    begun = time.perf_counter()
    write_log(path, samples)
    size = path.stat().st_size / 1e9
    print(f"{form}: {samples} samples of 6 columns, {size:.2f} GB, written in {time.perf_counter() - begun:.0f} s")
    table = write_unit(folder, path)
    plain, least, _ = apart(looked_through, path)
    seconds, most, (found, *whole) = apart(evaluated, table, (0, None) if small else (None,))
    for error in found.get("errors", ()):
        raise SystemExit(f"{form}: {error['message']}")
    (unit,) = found["units"]
    if not unit["road_in_pieces"] or unit["road_rows"] != samples:
        raise SystemExit(f"{form}: not read in pieces, or only {unit['road_rows']} samples")
    print(
        f"  evaluated in {seconds:.1f} s, {samples / seconds / 1e6:.2f} million samples/s; plainly in {plain:.1f} s, "
        f"{samples / plain / 1e6:.2f}: ratio {plain / seconds:.3f}"
    )
    print(f"  at most {most / 1e6:.0f} MB of memory ({least / 1e6:.0f} plainly){past(most > MEMORY)}")
    if small:
        different = [*differences(whole[0], found)]
        if different:
            raise SystemExit(f"{form}: in pieces it differs from the whole: {'; '.join(different[:5])}")
        print(f"  all {sum(map(len, found.values()))} rows are those of the log that is read whole")
    path.unlink()
    return most <= MEMORY


def past(missed: bool) -> str:
    """Say that a goal is missed."""
    return "   past the goal" if missed else ""


def main(arguments: argparse.Namespace) -> None:
    samples = SMALL if arguments.small else arguments.samples
    met = []
    with tempfile.TemporaryDirectory(prefix="atleak-long-log-", dir=arguments.folder) as name:
        for form in arguments.form or FORMS:
            needed, free = samples * (BYTES[form] + COLUMNS), shutil.disk_usage(name).free
            if needed > free:
                raise SystemExit(f"{form}: {needed / 1e9:.0f} GB are needed in {name}, {free / 1e9:.0f} are free")
            met.append(run(Path(name), form, samples, small=arguments.small))
    if not all(met) and not arguments.small:
        raise SystemExit(1)


if __name__ == "__main__":
    main(OPTIONS.parse_args())
