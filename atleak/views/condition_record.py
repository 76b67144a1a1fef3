"""Turn one condition of a diagnosis, and its pump, into JSON records: leakage, slip, pressures and circuits."""

from __future__ import annotations

import math
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.catalogue.section_pressures import SECTIONS
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import CircuitState, Projection
from atleak.rules import Rule
from atleak.uncertainty import TotalUncertainty
from atleak.views.positions import concentric_factors
from atleak.workshop_units import DM3_MIN, KPA, MM3_S, PERCENT, RPM


def finite(value: float) -> float | None:
    """Return a number as JSON can hold it: None for what is no number or has no end."""
    return value if math.isfinite(value) else None


def scaled(value: float | None, factor: float) -> float | None:
    """Return a number in another unit; None where there is none."""
    return None if value is None else finite(value * factor)


def condition_record(diagnosis: Diagnosis, projection: Projection) -> dict[str, Any]:
    """Return the record of one condition of a diagnosis."""
    at = projection.condition
    total = diagnosis.uncertainty.total(at.name) if diagnosis.uncertainty else None
    low, high = total.leakage_interval if total else (None, None)
    held_low, held_high = total.main_pressure_interval if total else (None, None)
    reserve_low, reserve_high = total.reserve_interval if total else (None, None)
    rule = diagnosis.total_rule(projection)
    new, unworn = diagnosis.new_at(projection), diagnosis.unworn_at(projection)  # pressures are judged by the latter
    least, largest = concentric_factors(diagnosis.profile, projection)
    permissible = projection.permissible
    return {
        "name": at.name,
        "label": at.label,
        "state": at.state,
        "temperature_c": at.temperature,
        "engine_rpm": at.engine_speed * RPM,
        "gear": at.gear,
        **{f"{name}_kpa": projection.pressures[name] * KPA for name in SECTIONS},
        "p_g_held_kpa": projection.main_pressure_held * KPA,
        "p_g_held_low_kpa": scaled(held_low, KPA),
        "p_g_held_high_kpa": scaled(held_high, KPA),
        "p_g_held_new_kpa": unworn.main_pressure_held * KPA,
        "permissible_low_kpa": scaled(permissible.low, KPA) if permissible else None,
        "permissible_high_kpa": scaled(permissible.high, KPA) if permissible else None,
        "leakage_dm3_min": projection.leakage * DM3_MIN,
        "leakage_low_dm3_min": scaled(low, DM3_MIN),
        "leakage_high_dm3_min": scaled(high, DM3_MIN),
        "leakage_new_dm3_min": new.leakage * DM3_MIN,
        "leakage_new_low_dm3_min": scaled(total.new_leakage_interval[0], DM3_MIN) if total else None,
        "leakage_new_high_dm3_min": scaled(total.new_leakage_interval[1], DM3_MIN) if total else None,
        "other_leakage_dm3_min": projection.other_leakage * DM3_MIN,
        "growth_percent": scaled(projection.leakage / new.leakage - 1.0, PERCENT) if new.leakage > 0.0 else None,
        "growth_low_percent": scaled(total.growth_interval[0], PERCENT) if total else None,
        "growth_high_percent": scaled(total.growth_interval[1], PERCENT) if total else None,
        "pump_supply_dm3_min": projection.pump_supply * DM3_MIN,
        "pump_slip_dm3_min": projection.slip * DM3_MIN,
        "pump_slip_new_dm3_min": scaled(slips(diagnosis, projection)[1], DM3_MIN),
        "pump_capacity_dm3_min": projection.pump_capacity * DM3_MIN,
        "consumers_dm3_min": projection.consumers * DM3_MIN,
        "consumers_starved_dm3_min": projection.starved * DM3_MIN,
        "reserve": finite(projection.reserve),
        "reserve_low": scaled(reserve_low, 1.0),
        "reserve_high": scaled(reserve_high, 1.0),
        "reserve_new": finite(unworn.reserve),
        "share_percent": finite(projection.share * PERCENT),
        "share_new_percent": finite(new.share * PERCENT),
        "share_unworn_percent": scaled(rule.new, PERCENT),
        "limit_percent": finite(rule.limit * PERCENT),
        "band": diagnosis.band(projection),
        "decision": total.decision.decision if total else None,
        "probability_over_limit": total.decision.probability_over_limit if total else None,
        "minimum_engine_rpm": projection.minimum_speed * RPM,
        "concentric_factor_low": least,
        "concentric_factor_high": largest,
        "circuits": [_circuit(diagnosis, projection, state, total) for state in projection.circuits],
        "rules": [unit_rule_record(diagnosis, each) for each in diagnosis.pressure_rules_at(projection)],
        "source": at.source,
    }


def unit_rule_record(diagnosis: Diagnosis, rule: Rule) -> dict[str, Any]:
    """Return the record of a rule of the whole unit: a reserve, a circuit or a permissible pressure."""
    decided = diagnosis.decided(rule)
    return {
        "rule": rule.id,
        "kind": rule.kind,
        "circuit": rule.circuit.id if rule.circuit else None,
        "value": finite(rule.value * rule.kind.factor),
        "limit": finite(rule.limit * rule.kind.factor),
        "level": rule.level,
        "verdict": diagnosis.verdict_on(rule),
        "decision": decided.decision if decided else None,
        "probability_over_limit": decided.probability_over_limit if decided else None,
        "origin": rule.origin,
    }


def _circuit(
    diagnosis: Diagnosis, projection: Projection, state: CircuitState, total: TotalUncertainty | None
) -> dict[str, Any]:
    circuit = state.circuit
    low, high = total.circuit_intervals.get(circuit.id, (None, None)) if total else (None, None)
    new = diagnosis.unworn_at(projection).circuit(circuit.id).pressure
    rule = diagnosis.pressure_rule(projection, RuleKind.CIRCUIT_LOSS, circuit)
    decided = diagnosis.decided(rule) if rule else None
    return {
        "id": circuit.id,
        "name": circuit.name,
        "vented": state.vented,
        "pressure_kpa": state.pressure * KPA,
        "pressure_low_kpa": scaled(low, KPA),
        "pressure_high_kpa": scaled(high, KPA),
        "pressure_new_kpa": new * KPA,
        "set_kpa": scaled(state.set_pressure, KPA),
        "loss_kpa": (new - state.pressure) * KPA,
        "feed_dm3_min": state.feed * DM3_MIN,
        "relief_dm3_min": state.relief * DM3_MIN,
        "verdict": diagnosis.verdict_on(rule),
        "decision": decided.decision if decided else None,
        "causes": [
            {"component": component, "land": land, "loss_kpa": loss * KPA}
            for (component, land), loss in diagnosis.losses_at(projection).get(circuit.id, {}).items()
        ],
    }


def slips(diagnosis: Diagnosis, projection: Projection) -> tuple[float, float | None]:
    """Return what the pump slips at a condition, and what it did when new [m³/s]; None where that is not known."""
    compared = diagnosis.controller.pump.as_new is not None
    return projection.slip, diagnosis.new_at(projection).slip if compared else None


def pump_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the pump as ``atleak diagnose --json`` has it."""
    pump = diagnosis.controller.pump
    record: dict[str, Any] = {
        "kind": pump.kind,
        "displacement_mm3": pump.displacement * MM3_S,
        "held_at_demand": pump.held_at_demand,
        "slip_coefficient": pump.slip_coefficient if diagnosis.model.uses_slip else None,
        "slip_coefficient_new": pump.as_new.slip_coefficient if pump.as_new is not None else None,
    }
    of = {"measured": pump.measured, "new": pump.clearances, "limit": pump.limits}
    verdict = diagnosis.pump.verdict
    record |= {"verdict": verdict, "repairs": [{"work": "as_new"}] if verdict.flagged else []}
    for number, name in enumerate(("side", "tip")):
        record |= {f"{name}_clearance_{which}_um": each.um[number] for which, each in of.items()}
    return record
