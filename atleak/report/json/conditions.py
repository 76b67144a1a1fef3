"""Records of one condition and its pump for scripts: leakage, slip, pressures and circuits; and of a message."""

from __future__ import annotations

import math
from functools import cache, partial
from typing import Any

import numpy as np

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import LandKey, Repair
from atleak.common.errors import Message
from atleak.common.units import DM3_MIN, G_CM3, KPA, MM, MM2_S, MM3_S, PERCENT, RPM, UM
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.missing import Amount, Missing, Row
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import RuleDecision, TotalUncertainty
from atleak.engine.operation import LINE
from atleak.engine.projection import CircuitState, Projection
from atleak.report.tables.names import concentric_factors


def message_record(message: Message) -> dict[str, Any]:
    """Return a message, with its place where it has one."""
    record: dict[str, Any] = {"level": message.level, "code": message.code, "text": message.text}
    if message.place is not None:
        record["place"] = message.place.parts or None
    return record


def finite(value: float) -> float | None:
    """Return a number as JSON can hold it: None for what is no number or has no end."""
    return value if math.isfinite(value) else None


def scaled(value: float | None, factor: float) -> float | None:
    """Return a number in another unit; None where there is none."""
    return None if value is None else finite(value * factor)


_FACTORS: dict[str, float | None] = {  # from SI, by the end of a key; None: as it is
    "_dm3_min": DM3_MIN, "_mm3_s": MM3_S, "_mm2_s": MM2_S, "_g_cm3": G_CM3, "_percent": PERCENT, "_rpm": RPM,
    "_kpa": KPA, "_um": UM, "_mm": MM, "_km": None, "_c": None, "_s": None,
}  # fmt: skip


def named_record(item: Any, *keys: str, **others: str) -> dict[str, Any]:
    """Return attributes of an item by their names, a quantity by name and unit: ``loss_kpa`` is ``loss`` [Pa] in kPa.

    ``others`` are keys of attributes with another name. All of it is None where there is no item.
    """
    record = {}
    for key, name in (*((key, None) for key in keys), *others.items()):
        end = _unit_of(key)
        value = None if item is None else getattr(item, name or key.removesuffix(end))
        factor = _FACTORS.get(end)
        record[key] = value if factor is None else scaled(value, factor)
    return record


@cache
def _unit_of(key: str) -> str:
    return next((end for end in _FACTORS if key.endswith(end)), "")


def of_land(key: LandKey) -> dict[str, Any]:
    """Return by what a land is known."""
    return {"component": key[0], "land": key[1]}


def interval_ends(
    name: str, interval: tuple[float | None, float | None] | None, factor: float = 1.0
) -> dict[str, float | None]:
    """Return the two ends of an interval in another unit, by ``{name}`` with low and high; None where none is known."""
    both = zip(("low", "high"), interval or (None, None), strict=True)
    return {name.format(end): scaled(value, factor) for end, value in both}


def decided_record(decided: RuleDecision | None) -> dict[str, Any]:
    """Return how sure what a rule says is, and how likely its limit is passed."""
    return named_record(decided, "decision", "probability_over_limit")


def condition_record(diagnosis: Diagnosis, projection: Projection) -> dict[str, Any]:
    """Return the record of one condition of a diagnosis."""
    at = projection.condition
    total = diagnosis.uncertainty.total(at.name) if diagnosis.uncertainty else None
    rule = diagnosis.total_rule(projection)
    new, unworn = diagnosis.new_at(projection), diagnosis.unworn_at(projection)  # pressures are judged by the latter
    permissible = projection.permissible
    return {
        **named_record(at, "name", "label", "state", "temperature_c"),
        **named_record(at, engine_rpm="engine_speed", gear="gear"),
        **{f"{name}_kpa": projection.pressures[name] * KPA for name in SECTIONS},
        "p_g_held_kpa": projection.main_pressure_held * KPA,
        **interval_ends("p_g_held_{}_kpa", total.main_pressure_interval if total else None, KPA),
        "p_g_held_new_kpa": unworn.main_pressure_held * KPA,
        **named_record(permissible, permissible_low_kpa="low", permissible_high_kpa="high"),
        "leakage_dm3_min": projection.leakage * DM3_MIN,
        **interval_ends("leakage_{}_dm3_min", total.leakage_interval if total else None, DM3_MIN),
        "leakage_new_dm3_min": new.leakage * DM3_MIN,
        **interval_ends("leakage_new_{}_dm3_min", total.new_leakage_interval if total else None, DM3_MIN),
        "other_leakage_dm3_min": projection.other_leakage * DM3_MIN,
        "growth_percent": scaled(projection.leakage / new.leakage - 1.0, PERCENT) if new.leakage > 0.0 else None,
        **interval_ends("growth_{}_percent", total.growth_interval if total else None, PERCENT),
        **named_record(projection, "pump_supply_dm3_min", pump_slip_dm3_min="slip"),
        "pump_slip_new_dm3_min": scaled(slips(diagnosis, projection)[1], DM3_MIN),
        **named_record(projection, "pump_capacity_dm3_min", "consumers_dm3_min", consumers_starved_dm3_min="starved"),
        "reserve": finite(projection.reserve),
        **interval_ends("reserve_{}", total.reserve_interval if total else None),
        "reserve_new": finite(unworn.reserve),
        "share_percent": finite(projection.share * PERCENT),
        "share_new_percent": finite(new.share * PERCENT),
        "share_unworn_percent": scaled(rule.new, PERCENT),
        "limit_percent": finite(rule.limit * PERCENT),
        "band": diagnosis.band(projection),
        **decided_record(total.decision if total else None),
        "minimum_engine_rpm": projection.minimum_speed * RPM,
        **interval_ends("concentric_factor_{}", concentric_factors(diagnosis.profile, projection)),
        "missing": missing_record(diagnosis.missing_shown(projection, LINE)),
        "circuits": [_circuit(diagnosis, projection, state, total) for state in projection.circuits],
        "rules": [unit_rule_record(diagnosis, each) for each in diagnosis.pressure_rules_at(projection)],
        "source": at.source,
    }


def unit_rule_record(diagnosis: Diagnosis, rule: Rule) -> dict[str, Any]:
    """Return the record of a rule of the whole unit: a reserve, a circuit or a permissible pressure."""
    return {
        "rule": rule.id,
        "kind": rule.kind,
        "circuit": rule.circuit.id if rule.circuit else None,
        "value": finite(rule.value * rule.kind.factor),
        "limit": finite(rule.limit * rule.kind.factor),
        "level": rule.level,
        "verdict": diagnosis.verdict_on(rule),
        **decided_record(diagnosis.decided(rule)),
        "origin": rule.origin,
    }


def _circuit(
    diagnosis: Diagnosis, projection: Projection, state: CircuitState, total: TotalUncertainty | None
) -> dict[str, Any]:
    circuit = state.circuit
    new = diagnosis.unworn_at(projection).circuit(circuit.id).pressure
    rule = diagnosis.pressure_rule(projection, RuleKind.CIRCUIT_LOSS, circuit)
    decided = diagnosis.decided(rule) if rule else None
    return {
        **named_record(circuit, "id", "name"),
        **named_record(state, "vented", "pressure_kpa"),
        **interval_ends("pressure_{}_kpa", total.circuit_intervals.get(circuit.id) if total else None, KPA),
        "pressure_new_kpa": new * KPA,
        "set_kpa": scaled(state.set_pressure, KPA),
        "loss_kpa": (new - state.pressure) * KPA,
        **named_record(state, "feed_dm3_min", "relief_dm3_min"),
        "verdict": diagnosis.verdict_on(rule),
        "decision": decided.decision if decided else None,
        "missing": None if state.vented else missing_record(diagnosis.missing_shown(projection, circuit.id)),
        "causes": [
            {**of_land(key), "loss_kpa": loss * KPA}
            for key, loss in diagnosis.losses_at(projection).get(circuit.id, {}).items()
        ],
    }


def slips(diagnosis: Diagnosis, projection: Projection) -> tuple[float, float | None]:
    """Return what the pump slips at a condition, and what it did when new [m³/s]; None where that is not known."""
    compared = diagnosis.controller.pump.as_new is not None
    return projection.slip, diagnosis.new_at(projection).slip if compared else None


OF_REPAIR = ("id", "kind", "name", "part_number", "price", "currency", "hours", "tool")
_AS_NEW = "as_new"  # the work on every pump


def kit_components(repair: Repair | None) -> list[str] | None:
    """Return the components that a kit mends; None of the repair of one."""
    return list(repair.components) if repair is not None and len(repair.components) > 1 else None


def pump_repair_record(repair: Repair) -> dict[str, Any]:
    """Return a repair of the pump as plain values: what it is, and what it costs."""
    return {"work": _AS_NEW, **named_record(repair, *OF_REPAIR, "evidence", "source")}


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
    verdict, of_file = diagnosis.pump.verdict, [each for each in diagnosis.controller.repairs if each.of_pump]
    repairs = list(map(pump_repair_record, of_file)) or [{"work": _AS_NEW}]
    record |= {"verdict": verdict, "repairs": repairs if verdict.flagged else []}
    for number, name in enumerate(("side", "tip")):
        record |= {f"{name}_clearance_{which}_um": each.um[number] for which, each in of.items()}
    return record


def missing_record(missing: Missing) -> dict[str, Any]:
    """Return what is missing of one pressure, and what explains it."""
    return {
        **named_record(missing, "measured_kpa", "expected_kpa"),
        **_amount(missing.amount(lambda each: each.missing), "missing_"),
        "explained": explained_record(missing),
        **unexplained_record(missing),
    }


def logged_record(missing: Missing) -> dict[str, Any]:
    """Return the same of main pressure where a log shows it, with where that was."""
    at = named_record(missing.point, "state", "gear", "temperature_c", engine_rpm="engine_speed")
    return {**at, **missing_record(missing)}


def explained_record(missing: Missing) -> list[dict[str, Any]]:
    """Return what each cause explains, the most first."""
    return [
        {
            "cause": row[0],
            "circuit": row[1],
            **_amount(missing.amount(partial(Missing.of_row, row=row))),
            "dm3_min": missing.amount(partial(Missing.flow_of, row=row)).value * DM3_MIN,
            "lands": _lands(missing, row),
        }
        for row in missing.rows
    ]


def _lands(missing: Missing, row: Row) -> list[dict[str, Any]]:
    flows = missing.split.flows_of_lands.get(row, {})
    return [
        {
            **of_land(key),
            **_amount(missing.amount(partial(Missing.of_row, row=row, land=key))),
            "dm3_min": missing.amount(partial(Missing.flow_of, row=row, land=key)).value * DM3_MIN,
        }
        for key in sorted(flows, key=lambda key: -float(np.mean(flows[key])))
    ]


def unexplained_record(missing: Missing) -> dict[str, Any]:
    """Return what no cause explains."""
    return _amount(missing.amount(lambda each: each.unexplained), "unexplained_")


def _amount(amount: Amount, name: str = "") -> dict[str, float | None]:
    value, low, high = (scaled(each, KPA) for each in amount)
    return {f"{name}kpa": value, f"{name}low_kpa": low, f"{name}high_kpa": high}
