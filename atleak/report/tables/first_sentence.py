"""Say a diagnosis in one sentence: how it stands, by what, what it leaks, what is not measured, what is in doubt.

Its parts say what gauges or a log decided, and what the pump was measured to slip.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

from atleak.analysis.pressures import pressures_at, worst_pressure
from atleak.catalogue.limits import RuleKind
from atleak.common.units import DM3_MIN, KPA, UM
from atleak.common.verdicts import FLAGGED, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule, unit_rules
from atleak.engine.projection import project
from atleak.report.json.conditions import slips
from atleak.report.tables.gauges import tap_text
from atleak.report.tables.names import land_number
from atleak.report.tables.road_words import deciding_sentence as of_log
from atleak.report.tables.sentences import (
    because_of,
    land_in_words,
    may_be,
    nothing_now,
    pressure_sentence,
    reserve_sentence,
    rule_reached,
)
from atleak.report.tables.vacuum import plugged


def measured_sentence(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Return what gauges or the log say where they decided or are all there is; None where clearances did."""
    decided_by, log = diagnosis.decided_by, diagnosis.log
    if isinstance(decided_by, Rule):
        if decided_by in diagnosis.vacuum_rules:
            return _of_plug(diagnosis, decided_by, say)
        if decided_by in diagnosis.gauge_rules:
            return _of_gauge(diagnosis, decided_by, say)
        if log is not None and decided_by in log.rules:
            return of_log(log, decided_by, say)
    if decided_by is not None or not diagnosis.without_sheet:
        return None
    return " ".join(_within(diagnosis, say))


def _within(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    if diagnosis.pressures is not None:
        readings = diagnosis.pressures.readings
        judged = sum(each.verdict is not None for each in readings)
        yield say(f"gauges.{'within' if judged else 'unjudged'}", judged=judged, count=len(readings))
    if diagnosis.log is not None:
        yield of_log(diagnosis.log, None, say)


def _of_plug(diagnosis: Diagnosis, rule: Rule, say: Wording) -> str:
    finding = next(each for each in diagnosis.vacuum if each.decided and each.decided.rule == rule)
    return say(
        "vacuum.decides",
        target=plugged(diagnosis, finding, say),
        count=len(finding.lands),
        clearance=say.quantity(finding.clearance * UM, "clearance", 1),
        new=say.quantity(finding.new_clearance * UM, "clearance", 1),
        verdict=say.signed(rule.verdict),
    )


def _of_gauge(diagnosis: Diagnosis, rule: Rule, say: Wording) -> str:
    readings = diagnosis.pressures.readings if diagnosis.pressures else ()
    each = next(each for each in readings if any(decided.rule == rule for decided in each.decisions))
    pressure, of_new = each.reading.pressure, rule.kind is RuleKind.BELOW_EXPECTED
    limit = pressure + rule.value if of_new else (each.permissible.low if each.permissible else None) or 0.0
    decided = None if rule.kind is RuleKind.PERMISSIBLE_PRESSURE else diagnosis.decided(rule)
    below = rule.value if rule.circuit is not None else limit - pressure
    return say(
        f"gauges.{'below_new' if of_new else 'below' if rule.circuit is None else 'circuit'}",
        tap=tap_text(diagnosis.controller, each.cell.tap, say),
        cell=f"{each.cell.range}, {say.sentence(each.cell.engine.label)}",
        pressure=say.value(pressure * KPA, "pressure", 0),
        limit=say.value(limit * KPA, "pressure", 0),
        kpa=say.value(below * KPA, "pressure", 0),
        percent=say.percent(rule.value, 1) if decided is None else say.percent(decided.probability_over_limit, 0),
        verdict=say.signed(rule.verdict),
    )


def pump_sentence(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say which clearances of this job's pump were measured, beside new ones and limits, and what they make it slip.

    The slip is that at hot idle, or else at the stated condition. None where nothing was measured of the pump.
    """
    pump = diagnosis.controller.pump
    if not pump.measured.any_known:
        return None
    measured = say("pump.measured", clearances=say("pump.and").join(_clearances(diagnosis, say)))
    if not (pump.counted.any_known and diagnosis.model.uses_slip):
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
    return " ".join(said)


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


_NAMED = 4  # lands that the sentence names one by one: choice of this project


def shown_verdict(diagnosis: Diagnosis) -> Verdict:
    """Return the verdict that a page may show: a unit of which anything is open or in doubt is not ok."""
    if diagnosis.verdict == Verdict.OK and not diagnosis.passed:
        return Verdict.NOT_MEASURED
    return diagnosis.verdict


def first_sentence(diagnosis: Diagnosis, say: Wording) -> str:
    """Return the sentence without the verdict's sign and word, which stand before it."""
    return f"{'; '.join(part.removesuffix('.') for part in _parts(diagnosis, say))}."


def _parts(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    measured = measured_sentence(diagnosis, say)
    if measured is not None:
        yield measured
    pump = worn_pump(diagnosis, say)
    if diagnosis.impossible:
        yield impossible_part(diagnosis, say)
    elif pump is not None:
        yield f"{pump} {say('pump.repair_first')}"
    if diagnosis.without_sheet:
        yield say("findings.alone")
        return
    yield lands_part(diagnosis, say)
    yield from filter(None, [nothing_now(diagnosis, say)])
    decided_by = diagnosis.decided_by
    if isinstance(decided_by, LandDiagnosis):
        rule = decided_by.deciding
        reached = "" if rule is None else rule_reached(rule, say)
        yield say("diagnosis.decides", land=land_in_words(diagnosis, decided_by.key, say), rule=reached)
        pressure = worst_pressure(diagnosis)
        if pressure is not None and pressure not in diagnosis.pump.lacking:
            yield f"{say.signed(pressure.verdict)} {because_of(diagnosis, pressure, say) or ''}".rstrip()
    elif isinstance(decided_by, Rule) and measured is None and not diagnosis.impossible:
        because = because_of(diagnosis, decided_by, say)
        yield because or say("diagnosis.by_rule", rule=rule_reached(decided_by, say))
    yield from may_parts(diagnosis, say)
    yield from _open(diagnosis, say)
    yield total_part(diagnosis, say)


def lands_part(diagnosis: Diagnosis, say: Wording) -> str:
    """Say how many of the measured lands are past a limit."""
    counts = {level: sum(land.verdict == level for land in diagnosis.lands) for level in reversed(FLAGGED)}
    flagged = [f"{count} {say.signed(level)}" for level, count in counts.items() if count]
    if flagged:
        return say("diagnosis.flagged", flagged=", ".join(flagged), measured=diagnosis.judged)
    if diagnosis.passed:
        return say("diagnosis.all_within", measured=diagnosis.judged)
    if diagnosis.judged:
        return say("diagnosis.none_past", measured=diagnosis.judged)
    none_counts = diagnosis.readings is not None and not diagnosis.readings.readings
    return say(f"diagnosis.nothing_{'counts' if none_counts else 'measured'}")


def impossible_part(diagnosis: Diagnosis, say: Wording) -> str:
    """Say that the description cannot be right, by the condition at which its new unit lacks most."""
    new = min(diagnosis.impossible, key=lambda each: (each.main_pressure_held, each.reserve))
    return say(
        "diagnosis.impossible" if new.pressure_falls else "diagnosis.impossible_reserve",
        condition=say.condition(new.condition),
        held=say.value(new.main_pressure_held * KPA, "pressure", 0),
        required=say.value(new.condition.main_pressure * KPA, "pressure", 0),
        reserve=say.number(new.reserve, 2),
    )


def may_parts(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    """Say how far a pressure within its limits may fall, where that is not sure: the one likeliest past a limit."""
    decided = [diagnosis.decided(rule) for rule in diagnosis.pressure_rules if not rule.verdict.flagged]
    open_ones = [each.at_first_level for each in decided if each is not None and each.at_first_level.conditional]
    worst = max(open_ones, key=lambda each: each.probability_over_limit, default=None)
    said = None if worst is None else may_be(diagnosis, worst.rule, say)
    if said is not None:
        yield said


def _open(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    """Name what was not measured, or on one part only, and what contradicts itself."""
    half = [land for land in diagnosis.unmeasured if land.state.measured]
    none = [land for land in diagnosis.unmeasured if not land.state.measured]
    if diagnosis.judged and none:
        yield say(
            "diagnosis.unmeasured", count=len(none), lands=len(diagnosis.lands), named=_named(diagnosis, none, say)
        )
    if half:
        yield say("diagnosis.half_measured", count=len(half), named=_named(diagnosis, half, say))
    if diagnosis.in_doubt:
        yield say("diagnosis.in_doubt", count=len(diagnosis.in_doubt), named=_named(diagnosis, diagnosis.in_doubt, say))


def _named(diagnosis: Diagnosis, lands: Iterable[LandDiagnosis], say: Wording) -> str:
    names = [land_number(diagnosis.controller, land.key, say) for land in lands]
    more = len(names) - _NAMED
    said = ", ".join(names[:_NAMED])
    return said if more <= 0 else say("diagnosis.and_more", named=said, count=more)


def total_part(diagnosis: Diagnosis, say: Wording) -> str:
    """Say what the unit leaks where that is worst, and which band that is."""
    worst = diagnosis.worst
    band, condition = diagnosis.band(worst), say.condition(worst.condition)
    if not math.isfinite(worst.share):
        return say("diagnosis.no_delivery", condition=condition)
    key = "as_new" if band is None else "leaks" if diagnosis.passed or band.verdict.flagged else "leaks_open"
    sign = "" if band is None else say.signed(band)
    return say(f"diagnosis.{key}", share=say.percent(worst.share), condition=condition, band=sign)
