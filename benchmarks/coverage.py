"""Check that a 95 % interval holds the truth 95 times in 100, on simulated units read with simulated instruments.

    python benchmarks/coverage.py [--small]

Every unit has true clearances, form, fluid, pressures and pump; instruments with common and independent errors read
its diameters and round them; atleak assesses the sheet as it would any other, and is compared with the truth. The true
flow is computed here from the gap law, not by atleak's propagation. Exits with 1 where a stated rate is not met.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from timing import options

from atleak.catalogue.controller import Controller, load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.instruments import Instrument, Instruments, load_instrument
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps, load_limits
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_new
from atleak.readings import Reading, Readings, clearances
from atleak.rules import unit_rules
from atleak.uncertainty import DEFAULTS, LandUncertainty, RuleDecision, UnitUncertainty, assess
from atleak.verdicts import Band, Verdict

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=10_000, help="units of the main population")
OPTIONS.add_argument("--other-units", type=int, default=500, help="units of each wrong assumption")
OPTIONS.add_argument("--workers", type=int, default=os.cpu_count() or 1)
OPTIONS.add_argument("--draws", type=int, default=2_000, help="Monte Carlo draws of each assessment")
OPTIONS.add_argument("--json", action="store_true", help="the same numbers as JSON")
SMALL = {"units": 60, "other_units": 5, "draws": 500}
TOLERANCE, SMALL_TOLERANCE = 1.0, 8.0  # [percentage points] allowed difference from the stated 95 %
SEED = 20231122
LANDS = 12
SPOOL_INSTRUMENTS = ("workshop_microscope", "micrometer", "air_gauge")
SLEEVE_INSTRUMENTS = ("bore_gauge", "air_gauge")
WEAR = 0.15  # mean of the exponential distribution of true wear
CLEARANCE_LIMIT = 1.25  # times the mounting clearance: the limit of the rule on the clearance itself
SHARE_LIMIT = 0.005
TOTAL_LIMIT = 0.031


@dataclass(frozen=True)
class World:
    """How the simulated world differs from what the assessment assumes."""

    name: str
    heavy_tails: bool = False  # every error of an instrument Student t with 3 degrees of freedom, same spread
    common: float = 1.0  # times the declared common error
    calibration: float = 1.0  # times the declared own calibration error
    directions: tuple[float, ...] = (0.0, 90.0)
    ovality: float = 4e-6  # [m] root mean square of the sleeves' difference of diameters
    room_temperature: float = 0.5  # [K] half width of its range


AS_DECLARED = World("as declared")
WORLDS = (
    AS_DECLARED,
    World("heavy tails", heavy_tails=True),
    World("common error twice as declared", common=2.0),
    World("all calibration twice as declared", common=2.0, calibration=2.0),
    World("one direction, ovality as assumed", directions=(0.0,)),
    World("one direction, ovality three times as assumed", directions=(0.0,), ovality=12e-6),
    World("room within 5 K instead of 0.5 K", room_temperature=5.0),
)


@dataclass(frozen=True)
class Truth:
    clearance: dict[tuple[str, int], float]
    wear: dict[tuple[str, int], float]
    leakage: dict[tuple[str, int], float]
    total: float
    capacity: float


@cache
def _catalogue_entries() -> tuple[Controller, Fluid, Limits]:
    whole = load_controller("four_speed_2023")
    point = whole.operating_points[0]
    leaking = {gap.key for gap in whole.gaps_in(point.gear)}
    chosen = [land for land in whole.lands if land.key in leaking][:LANDS]
    lands = tuple(
        replace(
            land,
            planes=(f"{land.land}a", f"{land.land}b") if number % 2 else (f"{land.land}a",),
            clearance_limit=CLEARANCE_LIMIT * land.mounting_clearance,
        )
        for number, land in enumerate(chosen)
    )
    keys = {land.key for land in lands}
    controller = replace(
        whole,
        lands=lands,
        gaps=tuple(gap for gap in whole.gaps if gap.key in keys),
        operating_points=(point,),
    )
    limits = load_limits("project_default")
    own = (LimitOrigin.PROJECT, "benchmark")
    limits = replace(
        limits,
        wear=Steps(((Verdict.WATCH, 0.1), (Verdict.REPLACE, 0.5)), *own),
        pair_share=Steps(((Verdict.WATCH, SHARE_LIMIT),), *own),
        total_share=Steps(((Band.AMBER, TOTAL_LIMIT), (Band.RED, 2 * TOTAL_LIMIT), (Band.CRITICAL, 0.5)), *own),
    )
    return controller, load_fluid("hipol_atf_iid"), limits


@cache
def _instrument(name: str) -> Instrument:
    return load_instrument(name)


def simulate(world: World, unit: int) -> tuple[UnitUncertainty, Truth, int]:
    """Simulate one unit: return its truth, and what atleak says of its measuring sheet."""
    draws, number = _settings()
    rng = np.random.default_rng((SEED, number[world.name], unit))
    controller, fluid, limits = _catalogue_entries()
    instruments = Instruments(
        _instrument(SPOOL_INSTRUMENTS[rng.integers(len(SPOOL_INSTRUMENTS))]),
        _instrument(SLEEVE_INSTRUMENTS[rng.integers(len(SLEEVE_INSTRUMENTS))]),
    )
    repeats = int(rng.integers(1, 4))
    truth, sheet = _unit(rng, world, controller, fluid, instruments, repeats)
    states = clearances(sheet, controller)
    model = LeakageModel(controller, states, fluid, WORKSHOP)
    projections = [project(model, point) for point in controller.operating_points]
    assessed = assess(
        model,
        states,
        projections,
        unit_rules(states, projections, project_new(states, model, projections), limits),
        readings=sheet,
        instruments=instruments,
        draws=draws,
        seed=unit,
    )
    return assessed, truth, repeats


def _settings() -> tuple[int, dict[str, int]]:
    return int(os.environ.get("ATLEAK_COVERAGE_DRAWS", "2000")), {w.name: i for i, w in enumerate(WORLDS)}


def _unit(
    rng: np.random.Generator,
    world: World,
    controller: Controller,
    fluid: Fluid,
    instruments: Instruments,
    repeats: int,
) -> tuple[Truth, Readings]:
    def error(spread: float) -> float:
        if not world.heavy_tails:
            return float(rng.normal(0.0, spread))
        return float(rng.standard_t(3)) * spread / math.sqrt(3.0)

    u = DEFAULTS
    temperature_error = rng.uniform(-world.room_temperature, world.room_temperature)  # [K] than 20 °C
    common = {part: error(world.common * instruments.of(part).common) for part in ("spool", "sleeve")}
    if instruments.err_alike:
        common["spool"] = common["sleeve"]
    clearance, wear, diameter, length, readings = {}, {}, {}, {}, []
    for land in controller.lands:
        mounting = land.mounting_clearance + rng.normal(0.0, u.mounting_clearance)
        worn = rng.exponential(WEAR)
        spool = land.nominal_diameter + rng.normal(0.0, 2e-6)
        sleeve = spool + 2.0 * mounting * (1.0 + worn)
        clearance[land.key], wear[land.key], diameter[land.key] = 0.5 * (sleeve - spool), worn, spool
        length[land.key] = land.contact_length + rng.normal(0.0, u.contact_length)
        for part, true, expansion, oval in (
            ("spool", spool, land.spool_expansion, 1e-6),
            ("sleeve", sleeve, land.body_expansion, world.ovality),
        ):
            tool = instruments.of(part)
            offset = common[part] + error(world.calibration * tool.own) + true * expansion * temperature_error
            ovality, phase = abs(rng.normal(0.0, oval)), rng.uniform(0.0, 180.0)
            four_lobes, taper = rng.normal(0.0, 0.07 * ovality), rng.normal(0.0, 2e-6)
            for place, plane in enumerate(land.planes):
                along = (place - 0.5) * taper if len(land.planes) > 1 else 0.0
                for direction in world.directions:
                    around = 0.5 * ovality * math.cos(2.0 * math.radians(direction - phase)) + four_lobes
                    for repeat in range(repeats):
                        read = true + along + around + offset + error(tool.repeatability)
                        step = tool.resolution
                        read = round(read / step) * step
                        readings.append(
                            Reading(land.component, part, plane, direction, repeat + 1, read)  # type: ignore[arg-type]
                        )
    truth = _truth(rng, controller, fluid, clearance, wear, diameter, length)
    return truth, Readings("simulated", "", None, "mm", False, "tidy", tuple(readings))


def _truth(
    rng: np.random.Generator,
    controller: Controller,
    fluid: Fluid,
    clearance: dict[tuple[str, int], float],
    wear: dict[tuple[str, int], float],
    diameter: dict[tuple[str, int], float],
    length: dict[tuple[str, int], float],
) -> Truth:
    """Compute the flows of the true unit, from the gap law written out once more."""
    u, point, pump = DEFAULTS, controller.operating_points[0], controller.pump
    temperature = point.temperature + rng.normal(0.0, u.temperature)
    viscosity = fluid.kinematic_viscosity(temperature) * math.exp(rng.normal(0.0, u.viscosity))
    mu = viscosity * fluid.density(temperature)
    main = point.main_pressure * (1.0 + rng.normal(0.0, u.main_pressure))
    converter = point.converter_pressure * (1.0 + rng.normal(0.0, u.converter_pressure))
    pressures = controller.section_pressures(main, converter)
    leakage = dict.fromkeys(clearance, 0.0)
    total = 0.0
    for gap in controller.gaps_in(point.gear):
        land = controller.land(*gap.key)
        d = diameter[gap.key]
        sleeve = d + 2.0 * clearance[gap.key]
        rate = 0.5 * (land.body_expansion * sleeve - land.spool_expansion * d)
        c = max(clearance[gap.key] + rate * (temperature - 20.0), 0.0)
        high, low = (
            end.coefficient * float(pressures[end.section]) if end.section else 0.0 for end in (gap.high, gap.low)
        )
        flow = math.pi * (d + c) * c**3 * max(high - low, 0.0) / (12.0 * mu * length[gap.key])
        leakage[gap.key] += flow
        total += flow if gap.into_sump else 0.0
    slip = pump.slip_coefficient * math.exp(rng.normal(0.0, u.slip_coefficient))
    capacity = pump.displacement * (point.engine_speed - slip * main / (2.0 * math.pi * mu))
    return Truth(clearance, wear, leakage, total, capacity)


# --- what is counted


def _inside(interval: tuple[float, float], value: float) -> bool:
    return interval[0] <= value <= interval[1]


def _count(world: World, units: range) -> Counter[str]:
    counts: Counter[str] = Counter()
    for unit in units:
        assessed, truth, repeats = simulate(world, unit)
        for land in assessed.lands:
            key = land.key
            share = truth.leakage[key] / truth.capacity
            counts["lands"] += 1
            for name, interval, value in (
                ("clearance", land.clearance_interval, truth.clearance[key]),
                ("leakage", land.leakage_interval, truth.leakage[key]),
                ("share", land.share_interval, share),
            ):
                inside = _inside(interval, value)
                counts[f"inside {name}"] += inside
                counts[f"{repeats} repeats {name}"] += inside
            counts[f"{repeats} repeats lands"] += 1
            _count_rules(counts, land, truth, share)
        total = assessed.totals[0]
        counts["units"] += 1
        counts["inside total leakage"] += _inside(total.leakage_interval, truth.total)
        counts["inside total share"] += _inside(total.share_interval, truth.total / truth.capacity)
        _count_rule(counts, "total share", total.decision, truth.total / truth.capacity)
    return counts


COUNTED = {RuleKind.WEAR: "wear", RuleKind.CLEARANCE: "clearance", RuleKind.PAIR_SHARE: "share"}


def _count_rules(counts: Counter[str], land: LandUncertainty, truth: Truth, share: float) -> None:
    for rule in land.rules:
        kind = COUNTED[rule.rule.kind]
        true = {"wear": truth.wear[land.key], "clearance": truth.clearance[land.key], "share": share}[kind]
        _count_rule(counts, kind, rule, true)


def _count_rule(counts: Counter[str], kind: str, rule: RuleDecision, true: float) -> None:
    """Count only the first limit of each rule, so that every rule has one population."""
    first = rule.levels[0]
    over = true > first.limit
    counts[f"{kind}: {first.decision}"] += 1
    counts[f"{kind}: {first.decision} and over"] += over
    counts[f"{kind}: unguarded wrong"] += (rule.value > first.limit) != over
    counts[f"{kind}: truly over"] += over
    counts[f"{kind}: all"] += 1


# --- report


def _percent(part: float, whole: float) -> float | None:
    return 100.0 * part / whole if whole else None


def summary(world: World, counts: Counter[str]) -> dict[str, object]:
    """Return the rates of one world [%]."""
    lands, units = counts["lands"], counts["units"]
    coverage = {
        name: _percent(counts[f"inside {name}"], units if name.startswith("total") else lands)
        for name in ("clearance", "leakage", "share", "total leakage", "total share")
    }
    rules = {}
    for kind in ("clearance", "wear", "share", "total share"):
        whole = counts[f"{kind}: all"]
        passed, failed = counts[f"{kind}: pass"], counts[f"{kind}: fail"]
        rules[kind] = {
            "truly_over": _percent(counts[f"{kind}: truly over"], whole),
            "pass": _percent(passed, whole),
            "pass_truly_over": _percent(counts[f"{kind}: pass and over"], passed),
            "conditional": _percent(whole - passed - failed, whole),
            "fail": _percent(failed, whole),
            "fail_truly_under": _percent(failed - counts[f"{kind}: fail and over"], failed),
            "decided_wrongly": _percent(
                counts[f"{kind}: pass and over"] + failed - counts[f"{kind}: fail and over"], whole
            ),
            "unguarded_wrong": _percent(counts[f"{kind}: unguarded wrong"], whole),
        }
    by_repeats = {
        count: {
            name: _percent(counts[f"{count} repeats {name}"], counts[f"{count} repeats lands"])
            for name in ("clearance", "leakage")
        }
        for count in (1, 2, 3)
    }
    return {
        "world": world.name, "units": units, "lands": lands,
        "coverage": coverage, "coverage_by_repeats": by_repeats, "rules": rules,
    }  # fmt: skip


def _show(result: dict[str, object]) -> None:
    def text(value: float | None) -> str:
        return "–" if value is None else f"{value:.2f}"

    print(f"\n{result['world']}: {result['units']} units, {result['lands']} lands")
    print("  95 % interval holds the truth [%]:", end=" ")
    print(", ".join(f"{name} {text(value)}" for name, value in result["coverage"].items()))
    by_repeats = result["coverage_by_repeats"]
    print("  with 1, 2, 3 repeats, clearance [%]:", ", ".join(text(by_repeats[n]["clearance"]) for n in (1, 2, 3)))
    print("  rule         truly over   pass (of them over)   conditional   fail (of them under)   unguarded wrong")
    for kind, rates in result["rules"].items():
        print(
            f"  {kind:12} {text(rates['truly_over']):>10} {text(rates['pass']):>6} ({text(rates['pass_truly_over'])})"
            f" {text(rates['conditional']):>19} {text(rates['fail']):>10} ({text(rates['fail_truly_under'])})"
            f" {text(rates['unguarded_wrong']):>19}"
        )


def _failures(result: dict[str, object], tolerance: float = TOLERANCE) -> list[str]:
    failures = [
        f"coverage of {name} is {value:.2f} %, not 95 ± {tolerance:g} %"
        for name, value in result["coverage"].items()
        if abs(value - 95.0) > tolerance
    ]
    failures += [
        f"{rates['pass_truly_over']:.2f} % of those declared pass by {kind} are over the limit"
        for kind, rates in result["rules"].items()
        if rates["pass_truly_over"] is not None and rates["pass_truly_over"] > 5.0
    ]
    return failures


def main(arguments: argparse.Namespace) -> int:
    if arguments.small:
        arguments = argparse.Namespace(**vars(arguments) | SMALL)
    os.environ["ATLEAK_COVERAGE_DRAWS"] = str(arguments.draws)
    started, results = time.perf_counter(), []
    with ProcessPoolExecutor(arguments.workers) as pool:
        for world in WORLDS:
            units = arguments.units if world is AS_DECLARED else arguments.other_units
            parts = [range(start, min(start + 50, units)) for start in range(0, units, 50)]
            counted = sum(pool.map(_count, [world] * len(parts), parts), Counter())
            results.append(summary(world, counted))
            if not arguments.json:
                _show(results[-1])
    failures = _failures(results[0], SMALL_TOLERANCE if arguments.small else TOLERANCE)
    if arguments.json:
        print(json.dumps({"worlds": results, "failures": failures}, indent=2))
    else:
        print(f"\n{time.perf_counter() - started:.0f} s, {arguments.workers} processes, {arguments.draws} draws")
        print("\n".join(failures) or "All stated rates are met.")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
