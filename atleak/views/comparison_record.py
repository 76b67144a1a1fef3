"""Turn a comparison into the JSON record that scripts rely on: each side by the keys of a diagnosis, and changes."""

from __future__ import annotations

from typing import Any

from atleak.comparison import Change, Comparison, ConditionComparison, EventPair, LandComparison
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.events import Event
from atleak.land_diagnosis import LandDiagnosis
from atleak.version import __version__
from atleak.views.condition_matrix import MatrixRow
from atleak.views.condition_record import condition_record, finite, scaled
from atleak.views.diagnosis_record import FORMAT, head_record, land_record
from atleak.views.message_record import message_record
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, UM


def comparison_record(comparison: Comparison) -> dict[str, Any]:
    """Return the record of a comparison, in the form ``atleak compare --json`` writes.

    ``before`` and ``after`` hold what ``atleak diagnose --json`` says of the same job; ``alike`` is the unit after by
    the choices of the job before, null where no choice differs. Changes of conditions are to ``alike``.
    """
    before, after = comparison.before, comparison.after
    alike = comparison.alike if comparison.differing else None
    return {
        "format": FORMAT,
        "atleak": __version__,
        "before": head_record(before),
        "after": head_record(after),
        "alike": None if alike is None else head_record(alike),
        "differing": [vars(each) for each in comparison.differing],
        "lands_compared": len(comparison.compared),
        "lands_changed": len(comparison.changed),
        "lands": [_land(comparison, land) for land in comparison.lands],
        "conditions": [_condition(comparison, each) for each in comparison.conditions],
        "events": None if comparison.logs is None else [_pair(pair) for pair in comparison.logs.pairs],
        "messages": [message_record(message) for message in comparison.messages],
    }


def _land(comparison: Comparison, land: LandComparison) -> dict[str, Any]:
    component, number = land.key
    change = land.change
    low, high = (change.interval if change else None) or (None, None)
    return {
        "component": component,
        "land": number,
        "before": _side_of_land(comparison.before, land.before),
        "after": _side_of_land(comparison.after, land.after),
        "change_um": scaled(change.value, UM) if change else None,
        "change_u_um": scaled(change.standard_uncertainty, UM) if change else None,
        "change_low_um": scaled(low, UM),
        "change_high_um": scaled(high, UM),
        "significant": change.significant if change else None,
    }


def _side_of_land(diagnosis: Diagnosis, land: LandDiagnosis | None) -> dict[str, Any] | None:
    return None if land is None else land_record(MatrixRow.of(land, diagnosis, diagnosis.projections))


def _condition(comparison: Comparison, each: ConditionComparison) -> dict[str, Any]:
    record = {
        "name": each.name,
        "label": each.projection.condition.label,
        "before": _side(comparison.before, each.before),
        "after": _side(comparison.after, each.after),
        "alike": _side(comparison.alike, each.alike) if comparison.differing else None,
        **_change("leakage", "dm3_min", each.leakage, DM3_MIN),
        **_change("share", "percent", each.share, PERCENT),
        **_change("reserve", "", each.reserve, 1.0),
        **_change("p_g_held", "kpa", each.main_pressure, KPA),
    }
    record["circuits"] = [
        {"id": one.circuit.id, "name": one.circuit.name, **_change("pressure", "kpa", one.change, KPA)}
        for one in each.circuits
    ]
    return record


def _side(diagnosis: Diagnosis, at: Projection | None) -> dict[str, Any] | None:
    return None if at is None else condition_record(diagnosis, at)


def _change(name: str, unit: str, change: Change | None, factor: float) -> dict[str, Any]:
    """Return a change with its interval, the unit last in each key."""
    low, high = (change.interval if change else None) or (None, None)
    values = {"change": change.value if change else None, "change_low": low, "change_high": high}
    record: dict[str, Any] = {
        "_".join(filter(None, (name, what, unit))): None if value is None else finite(value * factor)
        for what, value in values.items()
    }
    return {**record, f"{name}_significant": change.significant if change else None}


def _pair(pair: EventPair) -> dict[str, Any]:
    event = pair.event
    return {
        "kind": event.kind,
        "from_gear": event.from_gear,
        "to_gear": event.to_gear,
        "order": pair.order,
        "before": _event(pair.before),
        "after": _event(pair.after),
    }


def _event(event: Event | None) -> dict[str, Any] | None:
    return None if event is None else {"start_s": event.start, "stop_s": event.stop}
