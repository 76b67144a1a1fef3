"""Say a diagnosis in one sentence: how it stands, by what, what it leaks, what is not measured, what is in doubt."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import Rule
from atleak.verdicts import FLAGGED, Verdict
from atleak.views.land_names import land_number
from atleak.views.measured_words import measured_sentence
from atleak.views.pressures import worst_pressure
from atleak.views.pump_words import worn_pump
from atleak.views.sentences import because_of, land_in_words, may_be, rule_reached
from atleak.wording import Wording
from atleak.workshop_units import KPA

NAMED = 4  # lands that the sentence names one by one: choice of this project


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
        yield pump
    if diagnosis.without_sheet:
        yield say("findings.alone")
        return
    yield lands_part(diagnosis, say)
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
    more = len(names) - NAMED
    said = ", ".join(names[:NAMED])
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
