"""Sum up the results of 10 000 units with 47 lands each: time of the processor, and memory.

    python benchmarks/fleet_summary.py [--units 10000] [--small]

The results are made up with a fixed seed and written as a run writes them: units of one valve body in seven batches
with all lands, three stated conditions and ten classes of temperature. They are summed up as they are, with batches
compared each with all others, and with three groups compared in pairs. Goals: 10 s of the processor for any, and 1 GB.
``--small``: 500 units.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pyarrow as pa
from timing import options

from atleak.catalogue.controller_file import load_controller
from atleak.common.verdicts import VERDICTS, Verdict
from atleak.fleet.columns import HASH, DataSet, Rows, columns_of
from atleak.fleet.results import Results
from atleak.fleet.summary import summed_up
from atleak.version import __version__

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=10_000, metavar="N")
CONTROLLER = "four_speed_2023"
SECONDS, MEGABYTES = 10.0, 1000.0  # goals
BATCH = 500  # units that are written at a time
LIMITS = (45.0, 70.0, 110.0)  # [%] of wear


def write_results(folder: Path, count: int) -> None:
    """Write the results of so many units."""
    keys = [land.key for land in load_controller(CONTROLLER).lands]
    draw = np.random.default_rng(18)
    rate = draw.uniform(2.0, 25.0, len(keys))  # [%] of wear per 100 000 km
    with Results.open(folder, for_writing=True) as results:
        for first in range(0, count, BATCH):
            results.add([_unit(number, keys, rate, draw) for number in range(first, min(first + BATCH, count))])


def _unit(number: int, keys: list[tuple[str, int]], rate: np.ndarray, draw: np.random.Generator) -> Rows:
    own = {HASH: hashlib.sha256(str(number).encode()).hexdigest()}
    mileage = draw.uniform(20e3, 320e3)
    wear = mileage / 1e5 * rate * draw.lognormal(0.0, 0.4, len(keys))
    verdicts = [VERDICTS[1 + int(level)] for level in np.searchsorted(LIMITS, wear, side="right")]
    worst = int(np.argmax([verdict.rank for verdict in verdicts]))
    head = {
        "reference": f"file:/fleet/{number}.zip",
        "name": f"{number}.zip",
        "group": "abc"[number % 3],
        "labels": [("batch", f"B{number % 7}")],
        "serial": f"S{number}",
        "mileage_km": mileage,
        "atleak": __version__,
        "evaluated_at": dt.datetime(2026, 4, 1, tzinfo=dt.UTC),
        "tries": 1,
        "lands_measured": len(keys),
        "lands_total": len(keys),
        "road_rows": 1200,
        "provisional": False,
        "verdict": verdicts[worst],
        "decision": "fail" if verdicts[worst].flagged else "pass",
        "decided_by_kind": "land",
        "decided_by_component": keys[worst][0],
        "decided_by_land": keys[worst][1],
    }
    share = float(wear.mean())
    lands = [
        {"component": component, "land": land, "measured": "measured", "wear_percent": each, "verdict": verdict}
        for (component, land), each, verdict in zip(keys, wear.tolist(), verdicts, strict=True)
    ]
    conditions = [
        {"name": str(at), "label": str(at), "temperature_c": at, "engine_rpm": 750.0, "gear": 1, "p_g_kpa": 450.0}
        | {"p_g_held_kpa": 440.0, "share_percent": share * at / 110.0, "band": "green"}
        for at in (20.0, 90.0, 110.0)
    ]
    classes = [
        {"temperature_low_c": low, "temperature_high_c": low + 5.0, "seconds": 30.0, "share_mean_percent": share}
        | {"share_max_percent": 2.0 * share, "pressure_mean_kpa": 500.0, "pressure_min_kpa": 400.0, "green_s": 30.0}
        for low in range(60, 110, 5)
    ]
    rows: Mapping[DataSet, list[dict[str, Any]]] = {
        "units": [head],
        "lands": lands,
        "conditions": conditions,
        "temperatures": classes,
    }
    tables = {name: _table(name, [{**own, **row} for row in of_set]) for name, of_set in rows.items()}
    return Rows(CONTROLLER, own[HASH], head["reference"], Verdict(head["verdict"]), tables)


def _table(data_set: DataSet, rows: list[dict[str, Any]]) -> pa.Table:
    return pa.Table.from_pylist(rows, schema=columns_of(data_set))


class Memory:
    """The most memory that this process holds while something is done [MB]."""

    def __enter__(self) -> Memory:
        self._process, self._done = psutil.Process(), threading.Event()
        self.most = self._process.memory_info().rss
        self._watching = threading.Thread(target=self._watch)
        self._watching.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._watching.join()

    @property
    def megabytes(self) -> float:
        return self.most / 1e6

    def _watch(self) -> None:
        while not self._done.wait(0.01):
            self.most = max(self.most, self._process.memory_info().rss)


def main() -> None:
    given = OPTIONS.parse_args()
    count = 500 if given.small else given.units
    with tempfile.TemporaryDirectory(prefix="atleak-") as folder:
        write_results(Path(folder), count)
        results = Results.open(folder)
        for by in (None, "batch", "group"):
            with Memory() as memory:
                start, wall = time.process_time(), time.perf_counter()
                summary = summed_up(results, by=by)
                seconds, wall = time.process_time() - start, time.perf_counter() - wall
            assert summary.counts.units == count
            met = "met" if seconds <= SECONDS and memory.megabytes <= MEGABYTES else "MISSED"
            print(
                f"{count} units by {by or 'nothing'}: {seconds:.1f} s of the processor, {wall:.1f} s, "
                f"{memory.megabytes:.0f} MB; goals {met}"
            )


if __name__ == "__main__":
    main()
