"""Turn a diagnosis into the JSON record that scripts rely on (``format`` 1): unrounded, units in the keys."""

from __future__ import annotations

import json
import math
from typing import Any

from atleak.analysis.repair.plan import PumpStep, RepairPlan, RepairStep, plan_repairs
from atleak.analysis.repair.totals import Total
from atleak.catalogue.limits import Limits, RuleKind, Steps
from atleak.catalogue.repairs import PUMP
from atleak.common.memory import kept_with
from atleak.common.units import DM3_MIN, KPA, MM2_S, PERCENT, UM
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis, PumpDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import LandUncertainty, UnitUncertainty
from atleak.engine.leakage import GapLeakage
from atleak.engine.operation import LINE
from atleak.report.json.answer import answer_record
from atleak.report.json.conditions import (
    condition_record,
    decided_record,
    finite,
    interval_ends,
    message_record,
    named_record,
    of_land,
    pump_record,
    pump_repair_record,
    scaled,
    unit_rule_record,
)
from atleak.report.tables.assumed import assumed_records
from atleak.report.tables.before_opening import flow_record
from atleak.report.tables.complaint import explanations, finding, measure_first, reason
from atleak.report.tables.gauges import gauge_record
from atleak.report.tables.lands import LandAtCondition, MatrixRow, condition_matrix
from atleak.report.tables.repairs import cost_record, option_record, plan_ends
from atleak.report.tables.road_record import road_record, warm_up_record
from atleak.report.tables.vacuum import vacuum_records
from atleak.version import __version__

FORMAT = 1
_DECIDING = {
    RuleKind.TOTAL_SHARE: "total",
    RuleKind.CIRCUIT_LOSS: "circuit",
    RuleKind.BELOW_LINE: "circuit",
    RuleKind.BELOW_EXPECTED: "line",
}  # what decided, where the rule's name differs


def to_json(record: Any) -> str:
    """Return a record as JSON text: UTF-8 signs kept, no NaN or infinity (unknown is null)."""
    return json.dumps(record, ensure_ascii=False, indent=2, allow_nan=False) + "\n"


def diagnosis_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the record of a diagnosis, in the form ``atleak diagnose --json`` writes.

    Parameters
    ----------
    diagnosis
        as `atleak.diagnose` gives it.

    Returns
    -------
    dict
        made once and kept with the diagnosis: not to be changed.
    """
    return kept_with(diagnosis, "record", "", lambda: _record(diagnosis), most=1)


def _record(diagnosis: Diagnosis) -> dict[str, Any]:
    idle, plan = diagnosis.hot_idle, plan_repairs(diagnosis)
    return {
        "format": FORMAT,
        "atleak": __version__,
        **head_record(diagnosis),
        "answer": answer_record(diagnosis),
        "lands": [land_record(diagnosis, row) for row in condition_matrix(diagnosis)],
        "gaps": [_gap(gap) for gap in diagnosis.projection.gaps],
        "projection": condition_record(diagnosis, diagnosis.projection),
        "hot_idle": None if idle is None else condition_record(diagnosis, idle),
        "conditions": [condition_record(diagnosis, each) for each in diagnosis.projections],
        "repair_plan": [_repair_step(step) for step in plan.order],
        "repair_plan_ends": _repair_ends(plan),
        "road_test": road_record(diagnosis),
        "pressure_table": gauge_record(diagnosis),
        "vacuum": vacuum_records(diagnosis),
        "flows": [flow_record(each) for each in diagnosis.flows],
        "warm_up": warm_up_record(diagnosis),
        "messages": [message_record(message) for message in diagnosis.messages],
        "assumed": assumed_records(diagnosis),
    }


def head_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return what a diagnosis rests on, and the verdict of the unit."""
    readings, measured_at = diagnosis.readings, diagnosis.measured_at
    return {
        "profile": {"name": diagnosis.profile.name, **diagnosis.profile.options},
        "controller": {
            **named_record(diagnosis.controller, "id", "name", "source", "sha256"),
            "representative": bool(diagnosis.controller.representative),
            "representative_note": diagnosis.controller.representative or None,
        },
        "fluid": {
            **named_record(diagnosis.fluid, "id", "name", "source"),
            "sha256": diagnosis.fluid.origin.sha256,
            "representative": list(diagnosis.fluid.representative),
            "state": diagnosis.fluid.state,
            "state_assumed": diagnosis.fluid_state_assumed,
            **_required_fluid(diagnosis),
        },
        "pump": {
            **pump_record(diagnosis),
            "rules": [unit_rule_record(diagnosis, rule) for rule in diagnosis.pump.rules],
        },
        "limits": limits_record(diagnosis.limits),
        "mileage_km": diagnosis.mileage,
        "readings": {
            **named_record(readings, "file", "sha256"),
            "date": readings.date.isoformat() if readings and readings.date else None,
            **named_record(measured_at, measuring_temperature_c="value", measuring_temperature_assumed="assumed"),
            "lands_measured": diagnosis.measured,
            "lands_total": len(diagnosis.lands),
        },
        "uncertainty": _uncertainty(diagnosis.uncertainty),
        "complaint": _complaint(diagnosis),
        "verdict": diagnosis.verdict,
        "unit": _unit(diagnosis),
    }


def _required_fluid(diagnosis: Diagnosis) -> dict[str, Any]:
    required = diagnosis.controller.fluid
    low, high = (required and required.viscosity_100) or (None, None)
    return {
        "required": required and required.required,
        "taken_as": required and required.choice(diagnosis.fluid),
        "required_viscosity_100_low_mm2_s": low and low * MM2_S,
        "required_viscosity_100_high_mm2_s": high and high * MM2_S,
    }


def _unit(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the verdict of the unit, how sure it is, and the land, total or pressure that gave it."""
    decided_by = diagnosis.decided_by
    verdict = {
        "verdict": diagnosis.verdict,
        "decision": diagnosis.decision,
        "provisional": bool(diagnosis.provisional),
        "provisional_because": list(diagnosis.provisional),
        "upper_bound": diagnosis.upper_bound,
    }
    if decided_by is None:
        nothing = dict.fromkeys(("condition", "component", "land", "circuit", "where", "rule", "value", "limit"))
        return {**verdict, "decided_by": {"kind": "readings", **nothing} if diagnosis.verdict.flagged else None}
    rule = decided_by if isinstance(decided_by, Rule) else decided_by.deciding
    component, land = decided_by.key if isinstance(decided_by, LandDiagnosis) else (None, None)
    kind = "pump" if isinstance(decided_by, PumpDiagnosis) else "land"
    if decided_by in diagnosis.vacuum_rules:
        kind = "vacuum"
    elif isinstance(decided_by, Rule):
        kind = _DECIDING.get(decided_by.kind, decided_by.kind)
    return {
        **verdict,
        "decided_by": {
            "kind": kind,
            "condition": rule.condition.name if rule and rule.condition else None,
            "component": component,
            "land": land,
            "circuit": rule.circuit.id if rule and rule.circuit else None,
            "where": rule.where if rule and rule.where else None,
            **named_record(rule, rule="id"),
            "value": finite(rule.value * rule.kind.factor) if rule else None,
            "limit": finite(rule.limit * rule.kind.factor) if rule else None,
        },
    }


def _complaint(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the customer's complaint, where it can show, what explains it, and the lands to measure first."""
    complaint = diagnosis.complaint
    if complaint is None:
        return None
    return {
        **named_record(complaint, "id", "label", "source"),
        "conditions": list(complaint.conditions),
        "measure_first": [
            {
                **of_land(each.land.key),
                "doubt": each.doubt,
                "condition": each.projection.condition.name,
                "part_percent": each.part * PERCENT,
                "reason": reason(each, wording("en")),
            }
            for each in measure_first(diagnosis)
        ],
        "text": finding(diagnosis, wording("en")),
        "explained_by": [
            {
                "rule": each.rule.id,
                "condition": each.rule.condition.name if each.rule.condition else None,
                "circuit": each.rule.circuit.id if each.rule.circuit else None,
                **named_record(each.held, held_kpa="now", new_kpa="new"),
                "lands": [of_land(key) for key in each.lands],
            }
            for each in explanations(diagnosis, complaint)
        ],
    }


def _uncertainty(unit: UnitUncertainty | None) -> dict[str, Any] | None:
    """Return the assumptions that the intervals and decisions depend on."""
    if unit is None:
        return None
    return {
        "spool_instrument": unit.instruments.spool.id,
        "sleeve_instrument": unit.instruments.sleeve.id,
        "assumptions": dict(unit.assumptions.settings),
        **named_record(unit, "coverage", "guard_factor", "draws", "seed"),
    }


def limits_record(limits: Limits) -> dict[str, Any]:
    """Return a limit set with every limit and its origin."""
    return {
        **named_record(limits, "id", "name", "source"),
        "sha256": limits.origin.sha256,
        "rules": {kind: _steps(kind, steps) for kind, steps in limits.rules.items()},
    }


def _steps(kind: RuleKind, steps: Steps) -> dict[str, Any]:
    levels: dict[str, float] = {}
    for level, limit in steps.levels:
        if steps.has_limit(level):
            levels["_".join(filter(None, (level, kind.suffix)))] = limit * kind.factor
        if level in steps.at_least:
            levels[f"{level}_at_least_um"] = steps.at_least[level] * UM
        if level in steps.growth:
            growth, added = steps.growth[level]
            levels |= {f"{level}_growth_percent": growth * PERCENT, f"{level}_added_points": added * PERCENT}
    if steps.fall is not None:
        levels["fall_percent"] = steps.fall * PERCENT
    return {**levels, "origin": steps.origin, "source": steps.source}


def land_record(diagnosis: Diagnosis, row: MatrixRow) -> dict[str, Any]:
    """Return the record of one land at every condition."""
    land = row.land
    state, nominal, uncertainty = land.state, land.state.land, land.uncertainty
    at = land.replace_mileage
    return {
        **of_land(land.key),
        "measured": state.status,
        **named_record(state, "spool_readings", "sleeve_readings"),
        **named_record(state, "spool_diameter_mm", "sleeve_diameter_mm", "radial_clearance_um"),
        **named_record(uncertainty, uncertainty_um="u_clearance"),
        **named_record(nominal, "contact_length_mm", "contact_length_measured", "position_mm", "seal"),
        **named_record(nominal, fitted_repair="fitted", mounting_clearance_um="mounting_high"),
        "mounting_clearance_low_um": nominal.mounting_range[0] * UM,
        **named_record(nominal, "mounting_tolerance_um", "new_clearance_um", "new_origin"),
        **named_record(land, "wear_percent", "effective_clearance_um", "leakage_dm3_min", "drawn_from_pump_dm3_min"),
        **interval_ends("leakage_{}_dm3_min", uncertainty.leakage_interval if uncertainty else None, DM3_MIN),
        **named_record(land, "share_percent", "verdict", "decision", "suspect", "probability_over_limit"),
        "consequence": diagnosis.consequences[land.key],
        **named_record(uncertainty, "advice"),
        "replace_mileage_km": at.value if at and math.isfinite(at.high) else None,
        **interval_ends("replace_mileage_{}_km", (at.low, at.high) if at else None),
        "representative": list(nominal.representative),
        "conditions": [_at_condition(cell) for cell in row.cells],
        "rules": [_rule(rule, uncertainty) for rule in land.rules],
        "messages": [message_record(message) for message in land.messages],
    }


def _at_condition(cell: LandAtCondition) -> dict[str, Any]:
    return {
        **named_record(cell.projection.condition, "name", "label"),
        **named_record(cell, "leakage_dm3_min", "drawn_from_pump_dm3_min", "share_percent", "loss_kpa", "verdict"),
        "elsewhere": cell.elsewhere or None,
    }


def _rule(rule: Rule, uncertainty: LandUncertainty | None) -> dict[str, Any]:
    decided = uncertainty.on(rule) if uncertainty else None
    return {
        "rule": rule.id,
        "value": finite(rule.value * rule.kind.factor),
        "limit": finite(rule.limit * rule.kind.factor),
        "verdict": rule.verdict,
        **decided_record(decided),
        "measurable": uncertainty.measurable(decided) if uncertainty and decided else None,
        "new": scaled(rule.new, rule.kind.factor),
        "growth_percent": scaled(rule.growth, PERCENT),
        "origin": rule.origin,
    }


def _gap(leak: GapLeakage) -> dict[str, Any]:
    gap = leak.gap
    return {
        **named_record(gap, "component", "land", "section"),
        "from": str(gap.high),
        "to": str(gap.low),
        **named_record(leak, "pressure_drop_kpa", "diameter_mm", "contact_length_mm", "effective_clearance_um"),
        **named_record(leak, "kinematic_viscosity_mm2_s", "density_g_cm3", "leakage_mm3_s"),
        **named_record(leak, "drawn_from_pump", "reynolds_number"),
        "published": gap.published,
    }


def _repair_step(step: PumpStep | RepairStep) -> dict[str, Any]:
    if isinstance(step, PumpStep):
        repaired: dict[str, Any] = {
            "component": PUMP,
            "land": None,
            "verdict": step.verdict,
            "consequence": step.consequence,
            "for_total": False,
            "together": [],
            "options": [pump_repair_record(option.repair) for option in step.options],
        }
    else:
        repaired = {
            **of_land(step.land.key),
            "verdict": step.verdict,
            "consequence": step.consequence,
            "for_total": step.for_total,
            "together": [of_land(each.key) for each in step.together],
            "options": [option_record(option, step.land.key) for option in step.options],
        }
    return {
        **repaired,
        "chosen": None if step.chosen is None else step.chosen.repair.id,
        **named_record(step.at.condition, at="name", at_label="label"),
        **named_record(step.at.before, share_before_percent="share"),
        **named_record(step.at.after, share_after_percent="share"),
        "conditions": [
            {
                **named_record(each.condition, "name", "label"),
                **named_record(each.before, share_before_percent="share"),
                **named_record(each.after, share_after_percent="share", band_after="band"),
                **_held(each.after),
            }
            for each in step.conditions
        ],
    }


def _repair_ends(plan: RepairPlan) -> dict[str, Any]:
    """Return the totals that the plan ends at, and what else than lands those may be up to that are not green."""
    return {
        "reached": plan.reached,
        "chosen_by": plan.choice.basis,
        "proven_best": plan.choice.proven,
        "conditions": [_end(total, judged=plan.judged) for total in plan.ends],
        "remaining": [
            {
                **_end(left.total, judged=plan.judged),
                **named_record(left, "new_share_percent", "kinematic_viscosity_mm2_s", "pump_loss_percent"),
            }
            for left in plan.remaining
        ],
        "pressures_past": [rule.id for rule in plan.pressures_past],
        "lands_not_measured": plan.unmeasured,
        "cost": cost_record(plan.cost),
        "text": " ".join(plan_ends(plan, wording("en"))),
    }


def _end(total: Total, *, judged: bool) -> dict[str, Any]:
    """Return a total at the end of the plan; one of a unit that was not measured has no band."""
    return {
        **named_record(total.condition, "name", "label"),
        "share_percent": finite(total.share * PERCENT),
        "band": total.band if judged else None,
        **_held(total),
    }


def _held(total: Total) -> dict[str, Any]:
    """Return the reserve and the pressures that hold with some lands repaired."""
    circuits = {name: pressure * KPA for name, pressure in total.pressures.items() if name != LINE}
    return {
        "reserve_after": finite(total.reserve),
        "p_g_held_after_kpa": total.pressures[LINE] * KPA,
        "circuits_after_kpa": circuits,
    }
