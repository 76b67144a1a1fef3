"""Show a unit as it is tried as rows: totals and pressures beside those of the job, and beside the source study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.what_if import StudyTrial, Tried
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, RPM

Rows = list[dict[str, Any]]


def condition_words(projection: Projection, say: Wording) -> str:
    """Say a condition in the reader's words and units: temperature, engine speed, gear."""
    at = projection.condition
    temperature = say.plain_quantity(at.temperature, "temperature")
    speed = say.quantity(at.engine_speed * RPM, "engine_speed")
    return say("what_if.condition", temperature=temperature, speed=speed, gear=at.gear)


def tried_words(tried: Tried, say: Wording) -> str:
    """Say everything that is tried: the condition, and in what else it departs from the job."""
    at, parts = tried.settings, [condition_words(tried.projection, say)]
    if at.wear != 1.0:
        parts.append(say("what_if.with_wear", factor=say.plain(at.wear)))
    if at.growth:
        parts.append(say("what_if.with_growth", growth=say.percent(at.growth, 0)))
    if at.fluid is not None:
        parts.append(say.name(at.fluid.name))
    if at.fluid_state is not None:
        parts.append(say("what_if.with_fluid", state=say(f"what_if.{at.fluid_state}")))
    if at.eccentricity is not None:
        unknown = isinstance(at.eccentricity, str)
        parts.append(say("what_if.position_unknown") if unknown else f"e/c {say.plain(float(at.eccentricity))}")
    return ", ".join(parts)


def total_rows(diagnosis: Diagnosis, tried: Tried, say: Wording) -> Rows:
    """Return a row for the job and one for what is tried; nothing is judged of a unit that nobody measured."""
    bands = (diagnosis.total_rule(tried.job).level, tried.total.level) if diagnosis.judged else (None, None)
    return [
        {
            "verdict": band,
            "what_if": say(f"what_if.{name}"),
            "tried_at": condition_words(tried.job, say) if projection is tried.job else tried_words(tried, say),
            "share": projection.share * PERCENT,
            "leakage": projection.leakage * DM3_MIN,
            "reserve": projection.reserve,
            "required": projection.condition.main_pressure * KPA,
            "line_held": projection.main_pressure_held * KPA,
        }
        for name, projection, band in zip(("the_job", "tried"), (tried.job, tried.projection), bands, strict=True)
    ]


def circuit_rows(diagnosis: Diagnosis, tried: Tried, say: Wording) -> Rows:
    """Return a row for every circuit that is applied as it is tried; none where no pressure is solved."""
    if diagnosis.profile.circuits != "on":
        return []
    rules = {
        rule.circuit.id: rule
        for rule in tried.pressures
        if rule.circuit is not None and rule.kind is RuleKind.CIRCUIT_LOSS
    }
    rows = []
    for state in tried.projection.circuits:
        if state.vented:
            continue
        job, rule = tried.job.circuit(state.circuit.id), rules.get(state.circuit.id)
        rows.append(
            {
                "verdict": diagnosis.verdict_on(rule) if diagnosis.judged else None,
                "circuit": say.name(state.circuit.name),
                "job_held": None if job.vented else job.pressure * KPA,
                "tried_held": state.pressure * KPA,
                "new_held": None if rule is None or rule.new is None else rule.new * KPA,
                "set_pressure": None if state.set_pressure is None else state.set_pressure * KPA,
            }
        )
    return rows


def study_rows(trials: Sequence[StudyTrial], say: Wording) -> Rows:
    """Return a row for every variant of the source study: this unit tried likewise, and what the article prints."""
    return [
        {
            "study_variant": trial.variant.name,
            "temperature": trial.variant.temperature,
            "study_growth": trial.variant.wear * PERCENT,
            "fluid_is": say("what_if.used" if trial.variant.used_oil else "what_if.fresh"),
            "share_here": None if trial.here is None else trial.here.share * PERCENT,
            "share_printed": float(trial.variant.printed_max_share),
        }
        for trial in trials
    ]
