"""Check on simulated units that gauge readings find circuits that have lost pressure, and accuse no others.

    python benchmarks/gauges.py [--small]

Units of shipped valve bodies wear, in a world of its own (`simulated/gauged.py`); gauges are read on line and clutches
in drive and reverse, and atleak judges the table like any other. Counted by circuit, at its largest true loss against
new: found are those that have truly lost the limit of *watch* or more and are flagged, false alarms those that have
not and are. Goals: at most 1 % false alarms; with gauges of 2 % at least 75 % found, with gauges of 0.5 % 90 %. Gauges
err in each reading by itself, or alike at each tap. Of sound units one in `SOUND` is diagnosed and counts for all of
them. Exits with 1 where a stated rate is not met.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

from simulated.gauged import Gauges, file_of, simulate
from timing import options

from atleak.catalogue.limits import load_limits
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=1000, help="units of each valve body")
OPTIONS.add_argument("--valve-body", action="append", help="only this one, or several")
OPTIONS.add_argument("--workers", type=int, default=os.cpu_count() or 1)
VALVE_BODIES = ("five_speed_2005", "zf_6hp26", "chrysler_41te")
CASES: tuple[tuple[float, Gauges, float], ...] = (  # what gauges err by, what errs alike, and what is to be found [%]
    (0.02, "each reading", 75.0),
    (0.02, "each tap", 75.0),
    (0.005, "each reading", 90.0),
)
FALSE_ALARMS = 1.0  # [%] of sound circuits at most
SOUND = 8
PORTION, SMALL_UNITS, SMALL_SPARE = 20, 40, 15.0  # units of a task and of a small run; percentage points it may miss


def main(arguments: argparse.Namespace) -> int:
    started, failures = time.perf_counter(), []
    units, spare = (SMALL_UNITS, SMALL_SPARE) if arguments.small else (arguments.units, 0.0)
    bodies = arguments.valve_body or VALVE_BODIES[: 1 if arguments.small else None]
    with ProcessPoolExecutor(arguments.workers) as pool:
        for gauge, alike, least in CASES[: 1 if arguments.small else None]:
            for body in bodies:
                parts = [range(start, min(start + PORTION, units)) for start in range(0, units, PORTION)]
                counts = sum(pool.map(partial(counted, body, gauge, alike), parts), Counter())
                found, alarms = rates(counts)
                name = f"{body}, gauges {100 * gauge:g} % ({alike})"
                print(
                    f"{name}: found {found:.1f} % of {counts['lost']}, "
                    f"false alarms {alarms:.2f} % of {counts['sound']}, "
                    f"{counts['cpu ms'] / max(counts['tables'], 1):.0f} ms of CPU a table",
                    flush=True,
                )
                failures += [f"{name}: found {found:.1f} %, goal {least}"] if found < least - spare else []
                failures += [f"{name}: {alarms:.2f} % false"] if alarms > FALSE_ALARMS + 0.2 * spare else []
    print(f"\n{time.perf_counter() - started:.0f} s, {arguments.workers} processes")
    print("\n".join(failures) or "All stated rates are met.")
    return 1 if failures else 0


def counted(body: str, gauge: float, alike: Gauges, numbers: range) -> Counter[str]:
    """Count over some units of a valve body; sound circuits of a unit that is diagnosed for others count for them."""
    counts: Counter[str] = Counter()
    controller, fluid = file_of(body)
    limits, assumptions = load_limits("project_default"), replace(DEFAULTS, main_pressure=gauge)
    assert limits.circuit_loss is not None
    limit = limits.circuit_loss.levels[0][1]
    for number in numbers:
        unit = simulate(body, number, gauge, alike)
        worn = max(unit.worst.values()) >= limit
        if not worn and number % SOUND:
            continue
        began = time.process_time()
        check = diagnose(controller, fluid, limits, pressures=unit.table, assumptions=assumptions).pressures
        counts["cpu ms"] += round(1000.0 * (time.process_time() - began))
        counts["tables"] += 1
        assert check is not None
        for tap, loss in unit.worst.items():
            verdicts = [each.verdict for each in check.readings if each.cell.tap == tap]
            flagged = any(verdict is not None and verdict.flagged for verdict in verdicts)
            counts["lost" if loss >= limit else "sound"] += 1 if worn else SOUND
            counts["found" if loss >= limit else "alarms"] += (1 if worn else SOUND) * flagged
    return counts


def rates(counts: Counter[str]) -> tuple[float, float]:
    """Return what was found of the circuits that lost pressure, and the false alarms of the others [%]."""
    return 100.0 * counts["found"] / max(counts["lost"], 1), 100.0 * counts["alarms"] / max(counts["sound"], 1)


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
