"""Count how the assessments of simulated units agree with their truth, and turn the counts into rates."""

from __future__ import annotations

import statistics
from collections import Counter
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty import LandUncertainty, RuleDecision, TotalUncertainty
from simulated import population, worlds
from simulated.pairs import Pair
from simulated.population import Known
from simulated.worlds import World

QUANTITIES = ("clearance", "leakage", "share", "total leakage", "total share")
COUNTED = {RuleKind.WEAR: "wear", RuleKind.CLEARANCE: "clearance", RuleKind.PAIR_SHARE: "share"}
GROWN, GROWN_BY = 0.5, 4e-6  # of the clearance when new, and [m]: a land truly grown so far must be no plain pass
WIDTH = "width of a total: "  # to two places, over the total that is shown
PAST = 1.25  # times the limit of a pair's share: a land truly there must be flagged


def percent(part: float, whole: float) -> float | None:
    """Return a part of a whole [%]; None of nothing."""
    return 100.0 * part / whole if whole else None


# --- worlds


def count_world(world: World, units: range, draws: int) -> Counter[str]:
    """Count over some units of a world."""
    counts: Counter[str] = Counter()
    for unit in units:
        simulated = worlds.simulate(world, unit, draws)
        for pair, land in zip(simulated.pairs, simulated.assessed.lands, strict=True):
            _count_land(counts, simulated, pair, land)
        total, true = simulated.assessed.totals[0], simulated.true
        counts["units"] += 1
        for name, interval, value in (
            ("total leakage", total.leakage_interval, true.total),
            ("total share", total.share_interval, true.total / true.capacity),
        ):
            counts[name] += 1
            _count_side(counts, name, interval, value)
        counts["width"] += _width(total)  # type: ignore[assignment]  # a sum, not a count
        _count_rule(counts, "total share", total.decision, true.total / true.capacity)
    return counts


def _count_land(counts: Counter[str], simulated: worlds.Simulated, pair: Pair, land: LandUncertainty) -> None:
    share = simulated.true.share(land.key)
    counts["lands"] += 1
    counts[f"{simulated.repeats} repeats lands"] += 1
    for name, interval, value in (
        ("clearance", land.clearance_interval, pair.clearance),
        ("leakage", land.leakage_interval, simulated.true.leakage[land.key]),
        ("share", land.share_interval, share),
    ):
        assert interval is not None
        if value == 0.0:  # drawn from another circuit: nothing to hold
            continue
        counts[name] += 1
        inside = _count_side(counts, name, interval, value)
        counts[f"{simulated.repeats} repeats {name}"] += inside
    truth = {"wear": pair.wear / pair.mounting, "clearance": pair.clearance, "share": share}
    for rule in land.rules:
        kind = COUNTED[rule.rule.kind]
        if truth[kind] > 0.0:
            _count_rule(counts, kind, rule, truth[kind])


def _width(total: TotalUncertainty) -> float:
    """Return the width of a total's interval over the total that is shown."""
    low, high = total.leakage_interval
    return (high - low) / total.leakage


def _count_side(counts: Counter[str], name: str, interval: tuple[float, float], value: float) -> bool:
    side = "below" if value < interval[0] else "above" if value > interval[1] else "inside"
    counts[f"{side} {name}"] += 1
    return side == "inside"


def _count_rule(counts: Counter[str], kind: str, rule: RuleDecision, true: float) -> None:
    """Count only the first limit of each rule, so that every rule has one population."""
    first = rule.levels[0]
    over = true > first.limit
    counts[f"{kind}: {first.decision}"] += 1
    counts[f"{kind}: {first.decision} and over"] += over
    counts[f"{kind}: unguarded wrong"] += (rule.value > first.limit) != over
    counts[f"{kind}: truly over"] += over
    counts[f"{kind}: all"] += 1


def world_rates(world: World, counts: Counter[str]) -> dict[str, Any]:
    """Return the rates of one world [%]."""
    rules = {}
    for kind in ("clearance", "wear", "share", "total share"):
        every = counts[f"{kind}: all"]
        passed, failed = counts[f"{kind}: pass"], counts[f"{kind}: fail"]
        wrongly = counts[f"{kind}: pass and over"] + failed - counts[f"{kind}: fail and over"]
        rules[kind] = {
            "truly_over": percent(counts[f"{kind}: truly over"], every),
            "pass": percent(passed, every),
            "pass_truly_over": percent(counts[f"{kind}: pass and over"], passed),
            "conditional": percent(every - passed - failed, every),
            "fail": percent(failed, every),
            "fail_truly_under": percent(failed - counts[f"{kind}: fail and over"], failed),
            "decided_wrongly": percent(wrongly, every),
            "unguarded_wrong": percent(counts[f"{kind}: unguarded wrong"], every),
        }
    by_repeats = {
        count: {
            name: percent(counts[f"{count} repeats {name}"], counts[f"{count} repeats lands"])
            for name in ("clearance", "leakage")
        }
        for count in (1, 2, 3)
    }
    return {
        "world": world.name,
        "units": counts["units"],
        "lands": counts["lands"],
        "coverage": {name: percent(counts[f"inside {name}"], counts[name]) for name in QUANTITIES},
        "missed_above": {name: percent(counts[f"above {name}"], counts[name]) for name in QUANTITIES},
        "width_of_total": percent(counts["width"], counts["total leakage"]),
        "coverage_by_repeats": by_repeats,
        "rules": rules,
    }


# --- the population


def count_population(known: Known, shape: str, directions: tuple[float, ...], body: str, units: range) -> Counter[str]:
    """Count over some units of the population, by what the valve body's file says of the clearance when new."""
    counts: Counter[str] = Counter()
    for number in units:
        unit = population.simulate(known, number, shape, directions, body)
        diagnosis = unit.diagnosis
        assert diagnosis.uncertainty is not None
        first_limit = diagnosis.limits.pair_share.levels[0][1] if diagnosis.limits.pair_share else 0.0
        for pair, land in zip(unit.pairs, diagnosis.lands, strict=True):
            state = "unworn" if pair.wear == 0.0 else "worn"
            counts[f"{state} lands"] += 1
            counts[f"{state} {_outcome(land)}"] += 1
            if pair.wear >= max(GROWN * pair.mounting, GROWN_BY):
                counts["grown lands"] += 1
                counts[f"grown {_outcome(land)}"] += 1
            if unit.greatest_share(pair) >= PAST * first_limit:
                counts["past lands"] += 1
                counts[f"past {_outcome(land)}"] += 1
            assert land.uncertainty is not None
            assert land.uncertainty.clearance_interval is not None
            counts["clearance"] += 1
            _count_side(counts, "clearance", land.uncertainty.clearance_interval, pair.clearance)
            for at in land.uncertainty.conditions:
                leakage = unit.true[at.condition].leakage[land.key]
                if leakage > 0.0:  # a land that no pressure acts on has nothing to hold
                    counts["leakage"] += 1
                    _count_side(counts, "leakage", at.leakage_interval, leakage)
        for total in diagnosis.uncertainty.totals:
            counts["total leakage"] += 1
            _count_side(counts, "total leakage", total.leakage_interval, unit.true[total.condition].total)
            counts[f"{WIDTH}{_width(total):.2f}"] += 1
            pressures = unit.true[total.condition].pressures
            for circuit in total.circuit_intervals.keys() & pressures.keys():  # those applied there
                counts["pressure"] += 1
                # the dangerous side of a pressure is below its interval
                low, high = total.circuit_intervals[circuit]
                _count_side(counts, "pressure", (-high, -low), -pressures[circuit])
        counts["units"] += 1
        if unit.is_new:
            counts["new units"] += 1
            counts[f"new units {diagnosis.verdict}"] += 1
            counts["new units green"] += all(diagnosis.band(each) is Band.GREEN for each in diagnosis.projections)
    return counts


def _outcome(land: LandDiagnosis) -> str:
    if land.verdict.flagged:
        return "flagged"
    return "pass" if land.verdict is Verdict.OK and land.decision == "pass" else "conditional"


def population_rates(name: str, counts: Counter[str]) -> dict[str, Any]:
    """Return the rates of the population in one case [%]."""

    def outcomes(state: str) -> dict[str, Any]:
        whole = counts[f"{state} lands"]
        return {"lands": whole} | {
            name: percent(counts[f"{state} {name}"], whole) for name in ("pass", "conditional", "flagged")
        }

    held = [name for name in ("clearance", "leakage", "total leakage", "pressure") if counts[name]]
    widths = Counter({float(name[len(WIDTH) :]): number for name, number in counts.items() if name.startswith(WIDTH)})
    return {
        "known": name,
        "units": counts["units"],
        "unworn": outcomes("unworn"),
        "worn": outcomes("worn"),
        "grown": outcomes("grown"),
        "past": outcomes("past"),
        "coverage": {name: percent(counts[f"inside {name}"], counts[name]) for name in held},
        "missed_above": {name: percent(counts[f"above {name}"], counts[name]) for name in held},
        "width_of_total": 100.0 * statistics.median(widths.elements()),
        "new_units": counts["new units"],
        "new_units_ok": percent(counts[f"new units {Verdict.OK}"], counts["new units"]),
        "new_units_green": percent(counts["new units green"], counts["new units"]),
    }
