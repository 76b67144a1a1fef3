"""Check on simulated units, read with simulated instruments, that intervals hold the truth and verdicts fit it.

    python benchmarks/coverage.py [--small] [--part worlds|population|shapes]

Worlds: every unit has true clearances, form, fluid, pressures and pump; instruments with common and independent errors
read its diameters and round them; atleak assesses the sheet as it would any other. In the first world all is as the
assessment assumes and wear is even, in the next five bores are worn to one side, then spools lie anywhere and the
profile says so; in the rest an assumption is wrong, or bores are measured in four directions.

Population: units as a workshop gets them, new and worn, of pairs that were new at 6.4 to 20 µm, diagnosed with what a
valve body's file can know of that; where each pair's own clearance is known, also with all wear of one shape, and with
four directions, and with circuits, whose pressures are counted too: above it is then below what was said.

The true flow is computed here from the gap law, not by atleak's propagation. Exits with 1 where a stated rate is not
met.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from simulated.counted import QUANTITIES, count_population, count_world, population_rates, world_rates
from simulated.population import SHAPES, WITH_CIRCUITS, WITHOUT_CIRCUITS, Known
from simulated.worlds import AS_ASSUMED, AS_DECLARED, WORLDS
from timing import options

OPTIONS = options(__doc__)
OPTIONS.add_argument("--part", choices=("worlds", "population", "shapes"), help="only one of them")
OPTIONS.add_argument("--units", type=int, default=1_000, help="units of each world in which no assumption is wrong")
OPTIONS.add_argument("--other-units", type=int, default=500, help="units of each wrong assumption")
OPTIONS.add_argument("--population-units", type=int, default=600, help="units of the population, in each case")
OPTIONS.add_argument("--workers", type=int, default=os.cpu_count() or 1)
OPTIONS.add_argument("--draws", type=int, default=2_000, help="Monte Carlo draws of each assessment of a world")
OPTIONS.add_argument("--json", action="store_true", help="the same numbers as JSON")
SMALL = {"units": 40, "other_units": 5, "population_units": 8, "draws": 500}
HELD = 93.0  # [%] of the intervals hold the truth, of any quantity
UNWORN_PASS_OF_RANGE, GROWN_PASS = 60.0, 1.0  # [%] where only a range is known of new; in each case
HELD_SHAPED, ABOVE_SHAPED = 90.0, 7.0  # [%] of the intervals, and of the truths above them, with all wear of one shape
UNWORN_PASS, UNWORN_FLAGGED, PAST_FLAGGED, NEW_GREEN = 90.0, 1.0, 90.0, 99.0  # [%]
TWO, FOUR = (0.0, 90.0), (0.0, 45.0, 90.0, 135.0)
CASES = tuple((known, "as assumed", TWO, WITHOUT_CIRCUITS) for known in Known)
SHAPED = (
    *((Known.PAIR, shape, TWO, WITHOUT_CIRCUITS) for shape, sides in SHAPES.items() if sides),
    *((Known.PAIR, shape, FOUR, WITHOUT_CIRCUITS) for shape in SHAPES),
    *((Known.PAIR, shape, TWO, WITH_CIRCUITS) for shape in SHAPES),
)
SMALL_SPARE = 7.0  # [percentage points] by which a small run may miss what is stated
SLOWER = 4  # times is a unit with circuits, of which fewer are simulated
PORTION = 25  # units that one task of a process counts


def main(arguments: argparse.Namespace) -> int:
    if arguments.small:
        arguments = argparse.Namespace(**vars(arguments) | SMALL)
    spare = SMALL_SPARE if arguments.small else 0.0
    started, failures = time.perf_counter(), []
    worlds, population = [], []
    with ProcessPoolExecutor(arguments.workers) as pool:
        for world in WORLDS if arguments.part in (None, "worlds") else ():
            parts = _portions(arguments.units if world in AS_ASSUMED else arguments.other_units)
            counts = pool.map(count_world, [world] * len(parts), parts, [arguments.draws] * len(parts))
            worlds.append(world_rates(world, sum(counts, Counter())))
            failures += world_failures(worlds[-1], spare)
            if not arguments.json:
                show_world(worlds[-1])
        for case in (*CASES, *SHAPED):
            if arguments.part not in (None, "shapes" if case in SHAPED else "population"):
                continue
            parts = _portions(arguments.population_units // (1 if case[-1] == WITHOUT_CIRCUITS else SLOWER))
            counts = pool.map(count_population, *([each] * len(parts) for each in case), parts)
            name = ", ".join((str(case[0]), f"wear {case[1]}", f"{len(case[2])} directions", case[3]))
            population.append(population_rates(name, sum(counts, Counter())))
            failures += population_failures(population[-1], spare, shaped=case in SHAPED)
            if not arguments.json:
                show_population(population[-1])
    if arguments.json:
        print(json.dumps({"worlds": worlds, "population": population, "failures": failures}, indent=2))
    else:
        print(f"\n{time.perf_counter() - started:.0f} s, {arguments.workers} processes, {arguments.draws} draws")
        print("\n".join(failures) or "All stated rates are met.")
    return 1 if failures else 0


def _portions(units: int) -> list[range]:
    return [range(start, min(start + PORTION, units)) for start in range(0, units, PORTION)]


# --- what is required


def world_failures(rates: dict[str, Any], spare: float) -> list[str]:
    """Say which of the stated rates a world does not meet; of a world that is wrongly assumed none is stated."""
    name, coverage = rates["world"], rates["coverage"]
    if name not in {world.name for world in AS_ASSUMED}:
        return []
    failures = [
        f"{name}: coverage of {quantity} is {coverage[quantity]:.2f} %, less than {HELD:g} %"
        for quantity in QUANTITIES
        if coverage[quantity] < HELD - spare
    ]
    if name == AS_DECLARED.name:
        failures += [
            f"{name}: {rule['pass_truly_over']:.2f} % of those declared pass by {kind} are over the limit"
            for kind, rule in rates["rules"].items()
            if rule["pass_truly_over"] is not None and rule["pass_truly_over"] > 5.0 + spare
        ]
    return failures


def population_failures(rates: dict[str, Any], spare: float, *, shaped: bool = False) -> list[str]:
    """Say which of the stated rates a case of the population does not meet; less is held of one shape alone."""
    least, most = (HELD_SHAPED, ABOVE_SHAPED) if shaped else (HELD, 100.0 - HELD)
    passing = UNWORN_PASS_OF_RANGE if rates["known"].startswith(Known.RANGE) else UNWORN_PASS
    stated = (
        ("unworn lands are a plain pass", rates["unworn"]["pass"], passing - spare, 100.0),
        ("lands grown by half are a plain pass", rates["grown"]["pass"], 0.0, GROWN_PASS + spare),
        ("unworn lands are flagged", rates["unworn"]["flagged"], 0.0, UNWORN_FLAGGED + spare),
        ("lands past the limit of their share are flagged", rates["past"]["flagged"], PAST_FLAGGED - spare, 100.0),
        ("new units have every total green", rates["new_units_green"], NEW_GREEN - spare, 100.0),
        *((f"intervals hold the {name}", held, least - spare, 100.0) for name, held in rates["coverage"].items()),
        *((f"truths are above it, {name}", above, 0.0, most + spare) for name, above in rates["missed_above"].items()),
    )
    return [
        f"{rates['known']}: {value:.2f} % of {what}, not {low:g} … {high:g} %"
        for what, value, low, high in stated
        if value is not None and not low <= value <= high
    ]


# --- what is shown


def show_world(rates: dict[str, Any]) -> None:
    """Print the rates of one world."""
    print(f"\n{rates['world']}: {rates['units']} units, {rates['lands']} lands")
    print("  95 % interval holds the truth [%]:", _each(rates["coverage"]))
    print("  the truth is above it [%]:", _each(rates["missed_above"]))
    print("  mean width of the total's interval, of the total shown [%]:", _text(rates["width_of_total"]))
    by_repeats = rates["coverage_by_repeats"]
    print("  with 1, 2, 3 repeats, clearance [%]:", ", ".join(_text(by_repeats[n]["clearance"]) for n in (1, 2, 3)))
    print("  rule         truly over   pass (of them over)   conditional   fail (of them under)   unguarded wrong")
    for kind, rule in rates["rules"].items():
        print(
            f"  {kind:12} {_text(rule['truly_over']):>10} {_text(rule['pass']):>6} ({_text(rule['pass_truly_over'])})"
            f" {_text(rule['conditional']):>19} {_text(rule['fail']):>10} ({_text(rule['fail_truly_under'])})"
            f" {_text(rule['unguarded_wrong']):>19}"
        )


def show_population(rates: dict[str, Any]) -> None:
    """Print the rates of one case of the population."""
    print(f"\nclearance when new: {rates['known']}: {rates['units']} units")
    for state, words in (
        ("unworn", "truly unworn"),
        ("worn", "truly worn"),
        ("grown", "truly grown by half and 4 µm"),
        ("past", "truly at or past 1.25 x the limit of a pair's share"),
    ):
        outcomes = rates[state]
        print(
            f"  {outcomes['lands']} lands {words} [%]: plain pass {_text(outcomes['pass'])}, "
            f"conditional {_text(outcomes['conditional'])}, flagged {_text(outcomes['flagged'])}"
        )
    print("  95 % interval holds the truth [%]:", _each(rates["coverage"]))
    print("  the truth is above it [%]:", _each(rates["missed_above"]))
    print("  median width of the total's interval, of the total shown [%]:", _text(rates["width_of_total"]))
    print(
        f"  {rates['new_units']} units without any wear [%]: ok {_text(rates['new_units_ok'])}, "
        f"every total green {_text(rates['new_units_green'])}"
    )


def _each(values: dict[str, float | None]) -> str:
    return ", ".join(f"{name} {_text(value)}" for name, value in values.items())


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
