"""Summaries of fleets that nobody evaluated: made by hand, with whatever a paper must be able to show."""

from __future__ import annotations

import datetime as dt
import math
import random
from collections.abc import Sequence
from itertools import combinations

from atleak.catalogue.controller_reading import load_controller
from atleak.errors import Message
from atleak.fleet.summed import (
    MOST_IN_PAIRS,
    ConditionSpread,
    Decider,
    Difference,
    ErrorKind,
    FleetSummary,
    Group,
    GroupComparison,
    LandOverMileage,
    MileageClass,
    PairTrouble,
    RateDifference,
    SummedUnit,
    TemperatureClass,
    ValveBody,
    VerdictCounts,
    WearDifference,
)
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.spreads import ENOUGH_UNITS, Rate, Spread
from atleak.verdicts import BANDS, FLAGGED, Verdict

POINTS = (("hot_idle", "hot idle", 110.0, 750.0, 1), ("cruise", "cruise", 90.0, 2000.0, 4))


def rate(count: int, of: int) -> Rate:
    """Wilson's interval, from enough units on."""
    if of < ENOUGH_UNITS:
        return Rate(count, of, None, None)
    z = 1.959964
    middle, share = 1.0 + z * z / of, count / of
    reach = z * math.sqrt(share * (1.0 - share) / of + z * z / (4.0 * of * of))
    ends = ((share + z * z / (2.0 * of) - reach) / middle, (share + z * z / (2.0 * of) + reach) / middle)
    return Rate(count, of, max(ends[0] * 100.0, 0.0), min(ends[1] * 100.0, 100.0))


def spread(middle: float, reach: float, units: int) -> Spread:
    """Values around a middle."""
    parts = tuple(middle + part * reach for part in (-0.8, -0.4, 0.0, 0.45, 1.0))
    quantiles = parts if units >= ENOUGH_UNITS else None
    return Spread(units, middle + 0.05 * reach, middle - reach, middle, middle + 1.3 * reach, quantiles)


def counts(units: int, chance: random.Random, *, flagged: bool = True) -> VerdictCounts:
    """Verdicts of so many units, the worse the rarer."""
    parts = (0.05, 0.35, 0.3, 0.22, 0.08) if flagged else (0.0, 1.0, 0.0, 0.0, 0.0)
    drawn = chance.choices(list(Verdict), parts, k=units)
    verdicts = {verdict: drawn.count(verdict) for verdict in Verdict}
    judged = units - verdicts[Verdict.NOT_MEASURED]
    past = {level: sum(n for verdict, n in verdicts.items() if verdict.rank >= level.rank) for level in FLAGGED}
    return VerdictCounts(
        units=units,
        verdicts=verdicts,
        decisions={"pass": verdicts[Verdict.OK], "fail": judged - verdicts[Verdict.OK], None: units - judged},
        provisional=units // 10,
        ok_in_part=verdicts[Verdict.OK] // 3,
        rates={level: rate(past[level], judged) for level in FLAGGED},
    )


def summary(
    controllers: Sequence[str] = ("four_speed_2023",),
    *,
    units: int = 200,
    groups: Sequence[str] = ("north", "south", "west"),
    keys: Sequence[LandKey] | None = None,
    lands: int | None = None,
    logs: bool = True,
    mileage: bool = True,
    flagged: bool = True,
    errors: bool = True,
    name: str = "west/unit_{:05}.zip",
    seed: int = 18,
) -> FleetSummary:
    """A summary; each valve body has so many units, and of its lands the first so many."""
    chance = random.Random(seed)
    bodies = tuple(
        _body(controller, units, groups, _keys(controller, keys)[:lands], logs, mileage, flagged, chance)
        for controller in controllers
    )
    whole = counts(units * len(bodies), chance, flagged=flagged)
    return FleetSummary(
        folder="/hall/results of week 17",
        atleak="0.2.0",
        by="supplier" if groups else None,
        visits=whole.units + whole.units // 20,
        counts=whole,
        groups=tuple(_group(each, units // max(len(groups), 1), mileage, flagged, chance) for each in groups),
        not_stated=3 if groups else 0,
        headings=("group", "supplier"),
        bodies=bodies,
        errors=_errors() if errors else (),
        worst=tuple(_unit(number, bodies, groups, name, mileage, flagged, chance) for number in range(min(units, 50))),
        messages=(
            Message(
                "info", "not_told_apart", Sentence("{count} of {all} results state no serial number.", count=3, all=9)
            ),
        ),
    )


def _keys(controller: str, keys: Sequence[LandKey] | None) -> Sequence[LandKey]:
    return [land.key for land in load_controller(controller).lands] if keys is None else keys


def _body(
    controller: str,
    units: int,
    groups: Sequence[str],
    keys: Sequence[LandKey],
    logs: bool,
    mileage: bool,
    flagged: bool,
    chance: random.Random,
) -> ValveBody:
    whole = counts(units, chance, flagged=flagged)
    order = sorted(keys, key=lambda key: chance.random())
    pairs = []
    for place, key in enumerate(order):
        measured = max(units - chance.randrange(3), 0)
        past = min(int(measured * 0.4 * 0.9**place), measured) if flagged else 0
        watched = min(int(past * 1.5) + (place % 3), measured) if flagged else 0
        deciding = rate(past // 2, whole.judged)
        pairs.append(
            PairTrouble(key, rate(watched, measured), rate(past, measured), deciding, units - measured, place % 2)
        )
    return ValveBody(
        controller=controller,
        visits=units + units // 20,
        counts=whole,
        deciders=_deciders(order, whole) if flagged else (),
        pairs=tuple(pairs),
        wear=tuple(_wear(key, units, mileage, chance) for key in sorted(order)),
        temperatures=tuple(_temperature(low, units) for low in range(-10, 120, 5)) if logs else (),
        conditions=tuple(
            ConditionSpread(
                *point,
                required_kpa=450.0,
                share_percent=spread(22.0, 9.0, units),
                pressure_held_kpa=spread(440.0, 30.0, units),
                bands=dict(zip(BANDS, (units - units // 3, units // 6, units // 6, 0), strict=True)),
                partly=units // 8,
            )
            for point in POINTS
        ),
        comparison=_comparison(groups, units, order, mileage, flagged, chance) if len(groups) > 1 else None,
        messages=(Message("warning", "various_fluid", Sentence("{count} different fluids.", count=2)),),
    )


def _deciders(order: Sequence[LandKey], whole: VerdictCounts) -> tuple[Decider, ...]:
    flagged = sum(whole.verdicts[level] for level in FLAGGED)
    lands = [Decider("land", *key, None, rate(flagged // (place + 3), flagged)) for place, key in enumerate(order[:4])]
    others = [("total", None), ("circuit", "clutch_c1"), ("permissible_pressure", None)]
    whole_unit = [Decider(kind, None, None, circuit, rate(flagged // 20, flagged)) for kind, circuit in others]
    return tuple(decider for decider in (*lands, *whole_unit) if decider.units.count)


def _wear(key: LandKey, units: int, mileage: bool, chance: random.Random) -> LandOverMileage:
    per = chance.uniform(2.0, 14.0)
    classes = tuple(
        MileageClass(
            40_000.0 * number,
            40_000.0 * (number + 1),
            spread(per * (number + 0.5), 2.0 + per * 0.4 * (number + 1), max(units // (2 + abs(number - 3)), 1)),
        )
        for number in range(9)
    )
    return LandOverMileage(
        key, classes if mileage else (), units // 20 if mileage else units, 2, spread(3 * per, per, units)
    )


def _temperature(low: int, units: int) -> TemperatureClass:
    here = max(units // (1 + abs(low - 85) // 20), 1)
    share = 6.0 + 0.15 * (low + 10)
    red = max(0.0, (low - 70) / 2.0)
    return TemperatureClass(
        low_c=float(low),
        high_c=low + 5.0,
        seconds=here * 40.0,
        share_mean_percent=share * 1.03,
        share_percent=spread(share, 0.4 * share, here),
        share_max_percent=share * 2.5,
        pressure_mean_kpa=610.0 - low,
        pressure_kpa=spread(612.0 - low, 25.0, here),
        pressure_min_kpa=480.0 - low,
        bands_percent=dict(zip(BANDS, (85.0 - red, 15.0, red * 0.8, red * 0.2), strict=True)),
    )


def _group(name: str, units: int, mileage: bool, flagged: bool, chance: random.Random) -> Group:
    return Group(
        name, counts(units, chance, flagged=flagged), spread(150e3, 90e3, units) if mileage and units else None, 2
    )


def _comparison(
    groups: Sequence[str], units: int, keys: Sequence[LandKey], mileage: bool, flagged: bool, chance: random.Random
) -> GroupComparison:
    each = max(units // len(groups), 1)
    made = tuple(_group(name, each, mileage, flagged, chance) for name in sorted(groups))
    in_pairs = len(groups) <= MOST_IN_PAIRS
    sides = list(combinations(sorted(groups), 2)) if in_pairs else [(name, None) for name in sorted(groups)]
    enough = each >= ENOUGH_UNITS

    def difference(value: float, reach: float) -> Difference:
        if not enough:
            return Difference(value, None, None, None, None)
        return Difference(value, value - reach, value + reach, value - 1.6 * reach, value + 1.6 * reach)

    return GroupComparison(
        groups=made,
        not_stated=3,
        verdicts=tuple(
            RateDifference(*pair, level, each, each, difference(chance.uniform(-20.0, 20.0) if flagged else 0.0, 9.0))
            for pair in sides
            for level in FLAGGED
        ),
        lands=tuple(
            WearDifference(
                *pair,
                key,
                spread(30.0, 12.0, each),
                spread(22.0, 12.0, each),
                difference(12.0 - place, 3.0),
                11.0 - place,
                difference(10.0 - place, 3.5) if mileage else None,
            )
            for place, key in enumerate(keys)
            for pair in sides
        ),
        messages=(),
    )


def _unit(
    number: int,
    bodies: Sequence[ValveBody],
    groups: Sequence[str],
    name: str,
    mileage: bool,
    flagged: bool,
    chance: random.Random,
) -> SummedUnit:
    body = bodies[number % len(bodies)]
    verdict = (Verdict.CRITICAL if number < 8 else Verdict.REPLACE) if flagged else Verdict.OK
    by = chance.choice(list(groups)) if groups else None
    named = name.format(number)
    return SummedUnit(
        controller=body.controller,
        reference=f"file:/fleet/{named}",
        name=named,
        group=by,
        label=by,
        number=f"2026-{number:04}",
        date=dt.date(2026, 4, 1 + number % 28),
        vin=None,
        serial=f"S{number:06}",
        mileage_km=150e3 + number * 1000.0 if mileage else None,
        verdict=verdict,
        decision="fail" if flagged else "pass",
        provisional=number % 7 == 0,
        decided_by=(body.pairs[0].key if number % 4 else "total") if flagged else None,
        lands_past=max(9 - number, 0) if flagged else 0,
        max_share_percent=60.0 - number if number % 5 else None,
        visits=1 + number % 2,
    )


def _errors() -> tuple[ErrorKind, ...]:
    long = "sheet.xlsx, sheet “Tabelle 1”, row 12, column D: no number (found 'about 12'); expected millimetres. " * 6
    return (
        ErrorKind("refused", 12, (("north/bad_1.zip", long), ("north/bad_2.zip", "bad_2.zip: not a zip file"))),
        ErrorKind("time limit", 1, (("south/slow.zip", "slow.zip: took longer than 60 s"),)),
    )
