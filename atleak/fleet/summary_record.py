"""Turn a summary of a fleet into the JSON record that scripts rely on: unrounded, units in the keys."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from atleak.fleet.summed import (
    ConditionSpread,
    Difference,
    FleetSummary,
    Group,
    GroupComparison,
    LandOverMileage,
    PairTrouble,
    RateDifference,
    SummedUnit,
    TemperatureClass,
    ValveBody,
    VerdictCounts,
    WearDifference,
)
from atleak.rules import LandKey
from atleak.spreads import PARTS, Rate, Spread
from atleak.version import __version__
from atleak.views.diagnosis_record import FORMAT
from atleak.views.message_record import message_record
from atleak.workshop_units import PERCENT


def summary_record(summary: FleetSummary) -> dict[str, Any]:
    """Return the record of a summary, in the form ``atleak fleet summary --json`` writes."""
    return {
        "format": FORMAT,
        "atleak": __version__,
        "folder": summary.folder,
        "results_by": summary.atleak,
        "by": summary.by,
        "headings": list(summary.headings),
        "visits": summary.visits,
        "counts": _counts(summary.counts),
        "groups": [_group(each) for each in summary.groups],
        "group_not_stated": summary.not_stated,
        "controllers": [_body(each) for each in summary.bodies],
        "errors": [
            {
                "kind": each.kind,
                "count": each.count,
                "first": [{"name": name, "message": message} for name, message in each.first],
            }
            for each in summary.errors
        ],
        "worst": [_unit(each) for each in summary.worst],
        "messages": [message_record(each) for each in summary.messages],
    }


def _rate(each: Rate) -> dict[str, Any]:
    return {**asdict(each), "percent": each.percent}


def _spread(each: Spread | None) -> dict[str, Any] | None:
    if each is None:
        return None
    names = [f"p{part * PERCENT:.0f}" for part in PARTS]
    quantiles = None if each.quantiles is None else dict(zip(names, each.quantiles, strict=True))
    return {**asdict(each), "quantiles": quantiles}


def _counts(each: VerdictCounts) -> dict[str, Any]:
    return {
        "units": each.units,
        "judged": each.judged,
        "verdicts": dict(each.verdicts),
        "decisions": {decision or "none": count for decision, count in each.decisions.items()},
        "provisional": each.provisional,
        "ok_in_part": each.ok_in_part,
        "without_sheet": each.without_sheet,
        "rates": {level: _rate(of_level) for level, of_level in each.rates.items()},
    }


def _group(each: Group) -> dict[str, Any]:
    return {
        "name": each.name,
        "counts": _counts(each.counts),
        "mileage_km": _spread(each.mileage_km),
        "without_mileage": each.without_mileage,
    }


def _body(body: ValveBody) -> dict[str, Any]:
    return {
        "controller": body.controller,
        "name": body.name,
        "visits": body.visits,
        "counts": _counts(body.counts),
        "deciders": [{**asdict(each), "units": _rate(each.units)} for each in body.deciders],
        "lands": [_trouble(each) for each in body.pairs],
        "wear_over_mileage": [_over_mileage(each) for each in body.wear],
        "temperatures": [_temperature(each) for each in body.temperatures],
        "conditions": [_condition(each) for each in body.conditions],
        "comparison": None if body.comparison is None else _comparison(body.comparison),
        "messages": [message_record(each) for each in body.messages],
    }


def _key(key: LandKey) -> dict[str, Any]:
    component, land = key
    return {"component": component, "land": land}


def _trouble(each: PairTrouble) -> dict[str, Any]:
    return {
        **_key(each.key),
        "flagged": _rate(each.flagged),
        "replace": _rate(each.replace),
        "deciding": _rate(each.deciding),
        "not_measured": each.not_measured,
        "flagged_by_one_part": each.flagged_by_one_part,
    }


def _over_mileage(each: LandOverMileage) -> dict[str, Any]:
    return {
        **_key(each.key),
        "classes": [
            {"low_km": part.low_km, "high_km": part.high_km, "wear_percent": _spread(part.wear_percent)}
            for part in each.classes
        ],
        "without_mileage": each.without_mileage,
        "repaired": each.repaired,
        "latest_percent": _spread(each.latest_percent),
    }


def _temperature(each: TemperatureClass) -> dict[str, Any]:
    return {
        **asdict(each),
        "share_percent": _spread(each.share_percent),
        "pressure_kpa": _spread(each.pressure_kpa),
        "bands_percent": None if each.bands_percent is None else dict(each.bands_percent),
        "green_in_part_percent": each.green_in_part_percent,
    }


def _condition(each: ConditionSpread) -> dict[str, Any]:
    return {
        **asdict(each),
        "share_percent": _spread(each.share_percent),
        "pressure_held_kpa": _spread(each.pressure_held_kpa),
        "bands": dict(each.bands),
    }


def _comparison(each: GroupComparison) -> dict[str, Any]:
    return {
        "in_pairs": each.in_pairs,
        "groups": [_group(group) for group in each.groups],
        "group_not_stated": each.not_stated,
        "verdicts": [_of_rates(difference) for difference in each.verdicts],
        "lands": [_of_wear(difference) for difference in each.lands],
        "messages": [message_record(message) for message in each.messages],
    }


def _of_rates(each: RateDifference) -> dict[str, Any]:
    return {**asdict(each), "points": _difference(each.points)}


def _of_wear(each: WearDifference) -> dict[str, Any]:
    return {
        "first": each.first,
        "second": each.second,
        **_key(each.key),
        "first_percent": _spread(each.first_percent),
        "second_percent": _spread(each.second_percent),
        "mean_points": _difference(each.mean_points),
        "median_points": each.median_points,
        "same_mileage_points": _difference(each.same_mileage_points),
    }


def _difference(each: Difference | None) -> dict[str, Any] | None:
    return None if each is None else {**asdict(each), "differs": each.differs}


def _unit(each: SummedUnit) -> dict[str, Any]:
    decided_by: dict[str, Any] = {"kind": None, "component": None, "land": None}
    if isinstance(each.decided_by, tuple):
        decided_by = {"kind": "land", **_key(each.decided_by)}
    elif each.decided_by is not None:
        decided_by["kind"] = each.decided_by
    date = each.date.isoformat() if each.date is not None else None
    return {**asdict(each), "date": date, "decided_by": decided_by}
