"""Say what was measured of this job's pump and what it slips, and what the shares of a pump held at demand are of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import project
from atleak.rules import Rule, unit_rules
from atleak.views.condition_record import slips
from atleak.views.pressures import pressures_at
from atleak.views.sentences import pressure_sentence, reserve_sentence
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, UM


def pump_sentence(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say which clearances of this job's pump were measured, beside new ones and limits, and what they make it slip.

    The slip is that at hot idle, or else at the stated condition. None where nothing was measured of the pump.
    """
    pump = diagnosis.controller.pump
    if not pump.measured.known:
        return None
    measured = say("pump.measured", clearances=say("pump.and").join(_clearances(diagnosis, say)))
    if not (pump.counted.known and diagnosis.model.uses_slip):
        return f"{measured} {say('pump.counts_nowhere')}"
    projection = diagnosis.hot_idle or diagnosis.projection
    slip, new = slips(diagnosis, projection)
    words = {"condition": say.condition(projection.condition), "slip": say.value(slip * DM3_MIN, "flow", 2)}
    if new is None:
        return f"{measured} {say('pump.slips', **words)}"
    return f"{measured} {say('pump.slips_more', new=say.value(new * DM3_MIN, 'flow', 2), **words)}"


def worn_pump(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say what is past a limit by the pump, and that new valves would not mend it; None where it is within limits."""
    pump = diagnosis.pump
    if not pump.verdict.flagged:
        return None
    limited = [_limited(each.rule, say) for each in pump.decisions if each.rule.verdict.flagged]
    said = [say("pump.worn", what=say("pump.and").join(limited))]
    if pump.lacking and pump.lacking[0].condition is not None:
        now = diagnosis.at(pump.lacking[0].condition)
        at = pressures_at(diagnosis, now)
        said.append(pressure_sentence(at, say) if now.pressure_falls else reserve_sentence(at, say))
        new = project(replace(diagnosis.as_unworn, controller=diagnosis.model.controller), now.condition)
        rules = unit_rules((), [new], [diagnosis.unworn_at(now)], diagnosis.limits).of_unit
        if any(rule.id == pump.lacking[0].id and rule.verdict.flagged for rule in rules):
            missing, with_new = (each.condition.main_pressure - each.main_pressure_held for each in (now, new))
            if now.pressure_falls and with_new > _SAME * missing:
                said.append(say("pump.as_missing"))
            elif new.reserve < now.reserve / _SAME:
                said.append(say("pump.as_short"))
    new_rules = () if diagnosis.pump_new is None else diagnosis.pump_new.unit_rules
    if pump.lacking and not any(rule.verdict.flagged for rule in new_rules):
        said.append(say("pump.new_does"))
    return " ".join([*said, say("pump.repair_first")])


_SAME = 0.9  # part of what is missing that would be missing with new valves, too: choice of this project


def _limited(rule: Rule, say: Wording) -> str:
    now, limit = (say.quantity(each * UM, "clearance", 0) for each in (rule.value, rule.limit))
    key = "pump.side" if rule.kind is RuleKind.PUMP_SIDE else "pump.tip"
    return say("pump.limit", clearance=say(key, clearance=now), limit=limit)


def _clearances(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    pump = diagnosis.controller.pump
    for name, now, new, most in zip(("side", "tip"), pump.measured.um, pump.clearances.um, pump.limits.um, strict=True):
        if now is not None:
            beside = [
                say(f"pump.{word}", clearance=say.plain_quantity(um, "clearance"))
                for word, um in (("new", new), ("most", most))
                if um is not None
            ]
            said = say(f"pump.{name}", clearance=say.plain_quantity(now, "clearance"))
            yield f"{said} ({', '.join(beside)})" if beside else said
