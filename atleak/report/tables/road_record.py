"""Turn a road test, what it says by itself and the leakage over it into the record that scripts rely on."""

from __future__ import annotations

from typing import Any

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.limits import RuleKind
from atleak.common.units import DM3_MIN, KPA, PERCENT, UM
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.road import NO_LEAKAGE, RoadFindings
from atleak.diagnosis.uncertainty import RuleDecision, UnitUncertainty
from atleak.engine.extremes import Extremes
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import Departure
from atleak.measurements.events import Event
from atleak.report.json.conditions import logged_record, message_record, named_record, of_land, scaled
from atleak.report.tables.road_test import instant_record
from atleak.report.tables.road_words import check_text, checks_of, event_remark

_INSTANTS = ("max_leakage_sustained", "max_share_sustained", "max_leakage", "min_leakage", "max_share")


def road_record(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the record of a road test; None without one. What cannot be computed over it is null."""
    log, road, uncertainty = diagnosis.log, diagnosis.road, diagnosis.uncertainty
    if log is None:
        return None
    test = log.road_test
    why = tuple(each for each in diagnosis.messages if each.code == NO_LEAKAGE)
    messages = why if road is None else road.messages
    low, high = log.temperatures or (None, None)
    return {
        **named_record(test, "file", "sha256", "rows", "duration_s"),
        "gears": list(road.gears if road is not None else log.gears),
        "time_in_gears_s": {str(gear): time for gear, time in log.gears.items()},
        "temperature_low_c": low,
        "temperature_high_c": high,
        "permissible_pressure": _permissible(log),
        "permissible_pressure_not_judged": log.not_judged,
        "missing": [logged_record(each) for each in diagnosis.logged],
        "commanded_pressure": _commanded(log),
        "converter_slip": _slip(log),
        "events": [event_record(event) for event in log.events],
        "check_next": _checks(diagnosis),
        **_leakage(road, uncertainty, measured=diagnosis.judged > 0),
        "messages": [message_record(message) for message in (*test.messages, *messages)],
    }


def warm_up_record(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the record of what the log tells of leakage by main pressure; None where it does not say enough for that.

    Where the line was held throughout only the high ends are known.
    """
    told, u = diagnosis.warm_up, diagnosis.gauge_card.assumptions
    if told is None:
        return None
    bound, (cold, hot), at = told.found == "held", told.temperatures or (None, None), told.at
    amounts: dict[str, Any] = {}
    for name, unit, amount, times in (
        ("gaps", "_dm3_min", told.gaps, DM3_MIN),
        ("holes", "_dm3_min", told.holes, DM3_MIN),
        ("total", "_dm3_min", told.total, DM3_MIN),
        ("bore", "_um", told.bore, UM),
        ("pump_side_clearance", "_um", told.side, UM),
        ("pump_slip", "_times", told.slip, 1.0),
    ):
        for end, value in zip(("", "_low", "_high"), amount or (None,) * 3, strict=True):
            amounts[f"{name}{end}{unit}"] = scaled(None if bound and end != "_high" else value, times)
    return {
        "found": told.found,
        "required": "commanded" if told.by_command else "permissible",
        "temperature_low_c": cold,
        "temperature_high_c": hot,
        "at": at
        and {
            **named_record(at.like, "gear", "state"),
            **named_record(at, "temperature_c", engine_rpm="engine_speed"),
            **named_record(at, measured_kpa="pressure", required_kpa="required"),
        },
        **amounts,
        "lands": [of_land(land.key) for land in told.lands],
        **named_record(told, "told_apart", "left_dm3_min"),
        "assumed": {
            **named_record(u, displacement_percent="volumetric_efficiency", slip_percent="slip_coefficient"),
            **named_record(u, "viscosity_percent", "main_pressure_percent", temperature_k="gauged_temperature"),
            "consumers": [each.id for each in diagnosis.controller.consumers if not each.after_line],
        },
    }


def _leakage(road: RoadLeakage | None, uncertainty: UnitUncertainty | None, *, measured: bool) -> dict[str, Any]:
    if road is None:
        nothing = ("leakage_as_new", *_INSTANTS, "start", "sustained_over_s", "lower_bound")
        return {"sections": dict.fromkeys(SECTIONS), "circuits": [], **dict.fromkeys(nothing)}
    start = road.start
    return {
        "leakage_as_new": not measured,
        "sections": dict(road.section_shares),
        "circuits": _circuits(road),
        **_extremes(road.extremes, uncertainty),
        "start": None if start is None else {"samples": start.samples, **_extremes(start, uncertainty)},
        **named_record(road.extremes, sustained_over_s="window"),
        "lower_bound": road.lower_bound,
    }


def _circuits(road: RoadLeakage) -> list[dict[str, Any]]:
    """Return what every circuit holds at the measured line pressure, while it is applied and the engine turns."""
    return [
        {
            "id": name,
            "name": each.circuit.name,
            **named_record(each, "lowest_kpa", p_g_there_kpa="main_pressure", at_s="time"),
            **named_record(each, "mean_kpa", "samples"),
        }
        for name, each in road.circuit_ranges.items()
    ]


def _extremes(extremes: Extremes, uncertainty: UnitUncertainty | None) -> dict[str, Any]:
    named = {name: getattr(extremes, name) for name in _INSTANTS}
    return {name: instant and instant_record(instant, uncertainty) for name, instant in named.items()}


def _permissible(log: RoadFindings) -> dict[str, Any] | None:
    """Return how main pressure stood beside what is permitted; None where it was not judged."""
    permitted, decided = log.permitted, log.decided(RuleKind.PERMISSIBLE_PRESSURE)
    if permitted is None:
        return None
    lowest = permitted.lowest
    below = lowest is not None and permitted.below > 0.0
    return {
        "verdict": None if decided is None else decided.rule.verdict,
        **named_record(permitted, "judged_s", "below_s"),
        "worst_below_kpa": lowest.outside * KPA if below and lowest else 0.0,
        "worst_below_percent": lowest.fraction * PERCENT if below and lowest else 0.0,
        **named_record(lowest, "at_s"),
        "lowest": _departure(lowest),
        "above_s": permitted.above,
        "highest": _departure(permitted.highest),
        "places": [
            {
                **named_record(place, "gear", "state", "judged_s", "below_s", "above_s"),
                "lowest": _departure(place.worst),
                "by_temperature": [
                    named_record(each, "temperature_c", "pressure_kpa", "seconds") for each in place.by_temperature
                ],
            }
            for place in permitted.places
        ],
        **_decision(decided),
    }


def _departure(departure: Departure | None) -> dict[str, Any] | None:
    """Return where pressure is farthest outside a limit, or nearest to it: outside counts positive."""
    if departure is None:
        return None
    return {
        **named_record(departure, "gear", "state", "at_s", "start_s", end_s="stop"),
        **named_record(departure, "pressure_kpa", "limit_kpa", "outside_kpa"),
        **named_record(departure, outside_percent="fraction", source="source"),
    }


def _slip(log: RoadFindings) -> dict[str, float | None] | None:
    """Return how far the converter slips while the car drives; None where the log does not show it."""
    slip = log.slip
    if slip is None:
        return None
    return {
        **named_record(slip, "low_rpm", "median_rpm", "high_rpm", locked_s="locked_seconds"),
        **named_record(slip, lock_up_commanded_s="commanded_seconds", lock_up_commanded_median_rpm="commanded_median"),
    }


def _commanded(log: RoadFindings) -> dict[str, Any] | None:
    """Return measured minus commanded main pressure where they differ most; None where one of them is not logged."""
    compared, decided = log.commanded, log.decided(RuleKind.COMMANDED_PRESSURE)
    if compared is None:
        return None
    return {
        "verdict": None if decided is None else decided.rule.verdict,
        **named_record(compared, "difference_kpa", "at_s", "start_s", end_s="stop"),
        **named_record(compared, "actual_kpa", "commanded_kpa", "compared_s"),
        **_decision(decided),
    }


def _decision(decided: RuleDecision | None) -> dict[str, Any]:
    """Return the limit that a log was judged by, whose it is, and how sure the verdict is."""
    if decided is None:
        return dict.fromkeys(("decision", "probability_over_limit", "origin", "limit_source"))
    rule = decided.rule
    return {
        f"limit_{rule.kind.suffix}": decided.limit * rule.kind.factor,
        f"standard_uncertainty_{rule.kind.suffix}": decided.standard_uncertainty * rule.kind.factor,
        **named_record(decided, "decision", "probability_over_limit"),
        **named_record(rule, "origin", limit_source="source"),
    }


def event_record(event: Event) -> dict[str, Any]:
    """Return an event; of a minimum-acceleration test also how it was driven."""
    test = event.test
    return {
        **named_record(event, "kind", "start_s", end_s="stop"),
        **named_record(event, "duration_s", "from_gear", "to_gear", "source"),
        "note": event_remark(event, wording("en")) or None,
        "test": test
        and {
            "fault": test.fault,
            "gears": list(test.gears),
            "gears_not_reached": list(test.missing),
            **named_record(test, highest_engine_rpm="highest_speed", highest_at_s="highest_at"),
            **named_record(test, limit_rpm="speed_limit", over_by_rpm="over_by"),
        },
    }


def _checks(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    say = wording("en")
    return [
        {
            "code": check.code,
            "text": check_text(check, say),
            "source": check.source,
            "source_text": say(f"check_sources.{check.source}"),
        }
        for check in checks_of(diagnosis)
    ]
