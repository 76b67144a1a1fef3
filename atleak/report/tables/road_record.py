"""Turn a road test, what it says by itself and the leakage over it into the record that scripts rely on."""

from __future__ import annotations

from typing import Any

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.limits import RuleKind
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM, UM
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.road import NO_LEAKAGE, RoadFindings
from atleak.diagnosis.uncertainty import RuleDecision, UnitUncertainty
from atleak.engine.extremes import Extremes
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import Departure
from atleak.measurements.events import Event
from atleak.report.json.conditions import logged_record, message_record
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
        "file": test.file,
        "sha256": test.sha256,
        "rows": test.rows,
        "duration_s": test.duration,
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
            amounts[f"{name}{end}{unit}"] = _scaled(None if bound and end != "_high" else value, times)
    return {
        "found": told.found,
        "required": "commanded" if told.by_command else "permissible",
        "temperature_low_c": cold,
        "temperature_high_c": hot,
        "at": None
        if at is None
        else {
            "gear": at.like.gear,
            "state": at.like.state,
            "temperature_c": at.temperature,
            "engine_rpm": at.engine_speed * RPM,
            "measured_kpa": at.pressure * KPA,
            "required_kpa": at.required * KPA,
        },
        **amounts,
        "lands": [{"component": land.component, "land": land.land} for land in told.lands],
        "told_apart": told.told_apart,
        "left_dm3_min": _scaled(told.left, DM3_MIN),
        "assumed": {
            "displacement_percent": u.volumetric_efficiency * PERCENT,
            "slip_percent": u.slip_coefficient * PERCENT,
            "viscosity_percent": u.viscosity * PERCENT,
            "main_pressure_percent": u.main_pressure * PERCENT,
            "temperature_k": u.gauged_temperature,
            "consumers": [each.id for each in diagnosis.controller.consumers if not each.after_line],
        },
    }


def _scaled(value: float | None, times: float) -> float | None:
    return None if value is None else value * times


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
        "sustained_over_s": road.extremes.window,
        "lower_bound": road.lower_bound,
    }


def _circuits(road: RoadLeakage) -> list[dict[str, Any]]:
    """Return what every circuit holds at the measured line pressure, while it is applied and the engine turns."""
    return [
        {
            "id": name,
            "name": each.circuit.name,
            "lowest_kpa": each.lowest * KPA,
            "p_g_there_kpa": each.main_pressure * KPA,
            "at_s": each.time,
            "mean_kpa": each.mean * KPA,
            "samples": each.samples,
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
        "judged_s": permitted.judged,
        "below_s": permitted.below,
        "worst_below_kpa": lowest.outside * KPA if below and lowest else 0.0,
        "worst_below_percent": lowest.fraction * PERCENT if below and lowest else 0.0,
        "at_s": None if lowest is None else lowest.at,
        "lowest": _departure(lowest),
        "above_s": permitted.above,
        "highest": _departure(permitted.highest),
        "places": [
            {
                "gear": place.gear,
                "state": place.state,
                "judged_s": place.judged,
                "below_s": place.below,
                "above_s": place.above,
                "lowest": _departure(place.worst),
                "by_temperature": [
                    {"temperature_c": each.temperature, "pressure_kpa": each.pressure * KPA, "seconds": each.seconds}
                    for each in place.by_temperature
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
        "gear": departure.gear,
        "state": departure.state,
        "at_s": departure.at,
        "start_s": departure.start,
        "end_s": departure.stop,
        "pressure_kpa": departure.pressure * KPA,
        "limit_kpa": departure.limit * KPA,
        "outside_kpa": departure.outside * KPA,
        "outside_percent": departure.fraction * PERCENT,
        "source": departure.source,
    }


def _slip(log: RoadFindings) -> dict[str, float | None] | None:
    """Return how far the converter slips while the car drives; None where the log does not show it."""
    slip = log.slip
    if slip is None:
        return None
    return {
        "low_rpm": slip.low * RPM,
        "median_rpm": slip.median * RPM,
        "high_rpm": slip.high * RPM,
        "locked_s": slip.locked_seconds,
        "lock_up_commanded_s": slip.commanded_seconds,
        "lock_up_commanded_median_rpm": None if slip.commanded_median is None else slip.commanded_median * RPM,
    }


def _commanded(log: RoadFindings) -> dict[str, Any] | None:
    """Return measured minus commanded main pressure where they differ most; None where one of them is not logged."""
    compared, decided = log.commanded, log.decided(RuleKind.COMMANDED_PRESSURE)
    if compared is None:
        return None
    return {
        "verdict": None if decided is None else decided.rule.verdict,
        "difference_kpa": compared.difference * KPA,
        "at_s": compared.at,
        "start_s": compared.start,
        "end_s": compared.stop,
        "actual_kpa": compared.actual * KPA,
        "commanded_kpa": compared.commanded * KPA,
        "compared_s": compared.compared,
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
        "decision": decided.decision,
        "probability_over_limit": decided.probability_over_limit,
        "origin": rule.origin,
        "limit_source": rule.source,
    }


def event_record(event: Event) -> dict[str, Any]:
    """Return an event; of a minimum-acceleration test also how it was driven."""
    test = event.test
    return {
        "kind": event.kind,
        "start_s": event.start,
        "end_s": event.stop,
        "duration_s": event.duration,
        "from_gear": event.from_gear,
        "to_gear": event.to_gear,
        "source": event.source,
        "note": event_remark(event, wording("en")) or None,
        "test": test
        and {
            "fault": test.fault,
            "gears": list(test.gears),
            "gears_not_reached": list(test.missing),
            "highest_engine_rpm": test.highest_speed * RPM,
            "highest_at_s": test.highest_at,
            "limit_rpm": test.speed_limit * RPM,
            "over_by_rpm": test.over_by * RPM,
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
