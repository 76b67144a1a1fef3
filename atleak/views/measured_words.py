"""Say in a reader's language what gauges or a log decided, or say where they are all there is."""

from __future__ import annotations

from collections.abc import Iterator

from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.rules import Rule
from atleak.views.gauge_rows import tap_text
from atleak.views.road_words import deciding_sentence as of_log
from atleak.wording import Wording
from atleak.workshop_units import KPA


def measured_sentence(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Return what gauges or the log say where they decided or are all there is; None where clearances did."""
    decided_by, log = diagnosis.decided_by, diagnosis.log
    if isinstance(decided_by, Rule):
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
