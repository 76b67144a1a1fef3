"""Run a fleet on two workers beside two plain processes that diagnose the same files.

    python benchmarks/fleet.py [--units 10000] [--small]

Every unit is a measuring sheet of the four-speed valve body, 47 lands in two directions, and a log of 1200 samples,
both CSV, simulated with a fixed seed: new units and worn ones, cold and hot logs. A table names them with their mileage
and batch. The plain processes take every other unit each and do with it what ``atleak diagnose --json`` does, without
starting anew for each: read the files, diagnose, write the record. The fleet finds the units in the table, has two
workers diagnose them, and keeps the results as Parquet. The plain processes have the first half of the units before the
fleet has all of them, and the second half after it, so that a machine whose speed drifts does the same to both.

Printed are the rates, what a unit costs in processor time of all processes together, and the workers' memory. Goals:
the fleet at 0.9 of the plain processes' rate or more; a unit in the fleet at most 10 % dearer than the diagnosis of its
files alone; memory that stays within 10 % from a tenth of the run on; every result the same. ``--small``: 16 units.
"""

from __future__ import annotations

import argparse
import csv
import json
import multiprocessing
import os
import random
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from timing import options

from atleak.catalogue.controller_file import load_controller
from atleak.fleet.cluster import connected
from atleak.fleet.results import Results
from atleak.fleet.run import Finished, Progress, run_fleet
from atleak.fleet.sources import find_units
from atleak.job.case import Case, SourceFile
from atleak.job.result import result_record
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import to_json

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=10_000, metavar="N")
CONTROLLER = "four_speed_2023"
PROCESSES = 2
SAMPLES = 1200  # of a log, at 100 Hz
BATCHES = ("B1", "B2", "B3")
RATE, OVERHEAD, GROWTH = 0.9, 0.10, 0.10  # goals


# --- the units


def write_units(folder: Path, count: int) -> Path:
    """Write sheets, logs and the table that names them; return the table's path."""
    lands = load_controller(CONTROLLER).lands
    with (folder / "fleet.csv").open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["sheet", "log", "controller", "mileage", "job", "batch"])
        for number in range(count):
            (folder / f"{number}.csv").write_text(sheet(lands, number), encoding="utf-8")
            (folder / f"{number}_log.csv").write_text(log(number), encoding="utf-8")
            batch = BATCHES[number % len(BATCHES)]
            table.writerow([f"{number}.csv", f"{number}_log.csv", CONTROLLER, mileage(number), f"J{number}", batch])
    return folder / "fleet.csv"


def mileage(number: int) -> int:
    """Return the mileage of a unit [km]."""
    return 20_000 + number * 7919 % 300_000


def sheet(lands: Any, number: int) -> str:
    """Return the measuring sheet of a unit: as new, or with lands worn by up to 60 µm."""
    draw = random.Random(number)
    worn, mean = draw.random() < 0.7, draw.uniform(2e-6, 20e-6)
    rows = ["component,part,plane,direction,diameter [mm]"]
    for land in lands:
        wear = min(draw.expovariate(1.0 / mean), 60e-6) if worn and draw.random() < 0.6 else 0.0
        bore = land.nominal_diameter + 2.0 * (land.new_clearance + wear)
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", bore)):
            for plane in land.planes:
                for direction in (0, 90):
                    measured = (diameter + draw.gauss(0.0, 0.4e-6)) * 1e3
                    rows.append(f"{land.component},{part},{plane},{direction},{measured:.4f}")
    return "\n".join(rows)


def log(number: int) -> str:
    """Return the log of an acceleration through four gears."""
    draw = np.random.default_rng(number)
    part = np.linspace(0.0, 1.0, SAMPLES)
    through = part * 4 % 1.0
    columns = (
        np.arange(SAMPLES) * 0.01,
        900.0 + 2600.0 * through,
        480.0 + 500.0 * through + draw.normal(0.0, 2.0, SAMPLES),
        215.0 + 225.0 * through,
        60.0 + 45.0 * part + draw.uniform(-20.0, 10.0),
        np.minimum(np.floor(part * 4) + 1, 4),
    )
    heading = "time [s],engine_speed [rpm],p_g [kPa],p_k [kPa],atf_temperature [°C],gear"
    rows = (f"{a:.2f},{b:.1f},{c:.2f},{d:.2f},{e:.1f},{f:.0f}" for a, b, c, d, e, f in zip(*columns, strict=True))
    return "\n".join([heading, *rows])


# --- two plain processes


@dataclass
class Spent:
    """What units took."""

    units: int = 0
    wall: float = 0.0  # [s]
    cpu: float = 0.0  # [s] of all processes
    client: float = 0.0  # [s] of it, of the one that hands the units out
    diagnosing: float = 0.0  # [s] of it, for the diagnoses alone
    results: dict[str, str] = field(default_factory=dict)  # job → hash of its result

    @property
    def rate(self) -> float:
        """Return how many units a second."""
        return self.units / self.wall


def plainly(folder: Path, numbers: range, ready: Any, said: Any) -> None:
    """Diagnose some units one after another, as a process of its own, and write their records."""
    ready.wait()
    begun, diagnosing, results = time.process_time(), 0.0, {}
    for number in numbers:
        before = time.process_time()
        files = {name: SourceFile.at(folder / f"{number}{end}.csv") for name, end in FILES.items()}
        job = Job(number=f"J{number}")
        diagnosis = Case(**files, controller=CONTROLLER, mileage=float(mileage(number))).diagnose()  # type: ignore[arg-type]
        diagnosing += time.process_time() - before
        record = result_record(diagnosis, job)
        (folder / f"{number}.json").write_text(to_json(record), encoding="utf-8")
        results[f"J{number}"] = record["result_sha256"]
    said.put((time.process_time() - begun, diagnosing, results))


FILES = {"readings": "", "road_test": "_log"}


def plain(folder: Path, numbers: range, spent: Spent) -> None:
    """Have two processes diagnose some units, timed once both have imported what they need."""
    start = multiprocessing.get_context("spawn")
    ready, said = start.Barrier(PROCESSES + 1), start.Queue()
    of_each = [numbers[first::PROCESSES] for first in range(PROCESSES)]
    processes = [start.Process(target=plainly, args=(folder, each, ready, said)) for each in of_each]
    for process in processes:
        process.start()
    ready.wait()
    begun = time.perf_counter()
    for cpu, diagnosing, results in [said.get() for _ in processes]:
        spent.cpu += cpu
        spent.diagnosing += diagnosing
        spent.results |= results
    spent.wall += time.perf_counter() - begun
    spent.units += len(numbers)
    for process in processes:
        process.join()


# --- the fleet


@dataclass
class Memory:
    """What the workers hold, as the run goes on."""

    workers: list[psutil.Process]
    marks: dict[str, list[float]] = field(default_factory=dict)  # of the run → [MB] of each worker

    def see(self, mark: str) -> None:
        """Note it once for each mark."""
        if mark not in self.marks:
            self.marks[mark] = [worker.memory_info().rss / 1e6 for worker in self.workers]

    def cpu(self) -> float:
        """Return the processor time that the workers have taken [s]."""
        return sum(sum(each.cpu_times()[:2]) for each in self.workers)


def fleet(table: Path, out: Path, spent: Spent) -> tuple[Finished, Memory]:
    """Run all units on two workers that are there and have imported what they need."""
    found = find_units([table])
    marks = {"a tenth": 0.1, "a quarter": 0.25, "half": 0.5, "three quarters": 0.75}

    def seen(progress: Progress) -> None:
        for mark, part in marks.items():
            if progress.done >= part * progress.of:
                memory.see(mark)

    with Results.open(out, for_writing=True) as results, connected(workers=PROCESSES) as client:
        memory = Memory([psutil.Process(pid) for pid in client.run(os.getpid).values()])
        memory.see("start")
        before, own = memory.cpu(), time.process_time()
        finished = run_fleet(found, results, client, progress=seen)
        spent.wall, spent.units, spent.client = finished.seconds, finished.evaluated, time.process_time() - own
        spent.cpu = memory.cpu() - before + spent.client
        memory.see("end")
        own = psutil.Process().memory_info().rss / 1e6
        size = sum(path.stat().st_size for path in out.rglob("*.parquet")) / finished.evaluated
        print(f"the client holds {own:.0f} MB; results take {size / 1e3:.1f} kB a unit on disk")
        rows = results.table("units", ["number", "result_sha256"]).to_pylist()
        spent.results = {row["number"]: row["result_sha256"] for row in rows}
    return finished, memory


def main(arguments: argparse.Namespace) -> None:
    count = 16 if arguments.small else arguments.units
    alone, together = Spent(), Spent()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        table = write_units(folder, count)
        print(f"{count} units written; load of this machine {loads()}")
        plain(folder, range(count // 2), alone)
        finished, memory = fleet(table, folder / "out", together)
        plain(folder, range(count // 2, count), alone)
    print(f"load of this machine {loads()}; verdicts {json.dumps(finished.verdicts)}")
    for name, spent in (("plain processes", alone), ("workers", together)):
        cost = f"{1e3 * spent.cpu / count:8.1f} ms of processor time a unit"
        print(
            f"{PROCESSES} {name:15s}{spent.rate:8.2f} units/s{cost}, the client's {1e3 * spent.client / count:.1f} ms"
        )
    ratio, by_cpu = together.rate / alone.rate, alone.cpu / together.cpu
    print(
        f"rate of the fleet over the plain processes' {ratio:.3f} (by processor time {by_cpu:.3f}){past(ratio < RATE)}"
    )
    overhead = together.cpu / alone.diagnosing - 1.0
    print(
        f"overhead per unit over its diagnosis alone, {1e3 * alone.diagnosing / count:.1f} ms: {overhead:+.1%}"
        f"{past(overhead > OVERHEAD)}"
    )
    for mark, sizes in memory.marks.items():
        print(f"  memory of the workers at {mark:15s}{', '.join(f'{size:.0f} MB' for size in sizes)}")
    grown = max(end / tenth for end, tenth in zip(memory.marks["end"], memory.marks["a tenth"], strict=True)) - 1.0
    print(f"  from a tenth to the end {grown:+.1%}{past(grown > GROWTH)}")
    if together.results != alone.results or finished.errors:
        raise SystemExit(f"the fleet's results differ from those of the plain processes; errors {finished.errors}")
    print(f"all {count} results are the same")


def loads() -> str:
    """Return the machine's load over the last 1, 5 and 15 minutes."""
    return ", ".join(f"{each:.1f}" for each in psutil.getloadavg())


def past(missed: bool) -> str:
    """Say that a goal is missed."""
    return "   past the goal" if missed else ""


if __name__ == "__main__":
    main(OPTIONS.parse_args())
