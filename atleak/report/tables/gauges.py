"""Rows and the JSON record of gauge readings: what was shown, what is permissible, what is expected, the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from atleak.catalogue.circuits import PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.common.units import KPA, PERCENT, RPM
from atleak.common.wording import Wording, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_card import USUAL_FAST_IDLE, CardRow
from atleak.diagnosis.gauge_check import CheckedReading, PressureCheck
from atleak.diagnosis.gauge_patterns import Pattern
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, tap_name
from atleak.report.json.conditions import finite, interval_ends, named_record, of_land, scaled, unit_rule_record
from atleak.report.tables.names import land_words
from atleak.report.tables.table import VERDICT, Column, Table

_WORTH_NAMING, LEAST_OF_A_LAND, MOST_LANDS = 0.05, 0.005, 4  # parts of a loss that causes explain, to be named
MOST_TYPED = 3  # decimal places of a gauge reading [kPa]; more are those of a converted unit


def gauge_record(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the gauge readings as ``atleak diagnose --json`` writes them; None without any."""
    check = diagnosis.pressures
    if check is None:
        return None
    deciding = check.deciding
    return {
        **named_record(check.table, "file", "sha256", "sheet"),
        "verdict": check.verdict,
        **named_record(deciding, "decision"),
        "decided_by": deciding.rule.where if deciding and deciding.rule.verdict.flagged else None,
        "taps": list(check.table.taps),
        "readings": [_reading(diagnosis, each) for each in check.readings],
        "patterns": [_pattern(each, diagnosis.controller) for each in check.patterns],
    }


def _reading(diagnosis: Diagnosis, checked: CheckedReading) -> dict[str, Any]:
    reading, permissible, deciding = checked.reading, checked.permissible, checked.deciding
    line = reading.cell.tap == LINE_TAP
    new, now = (checked.shown.new, checked.shown.now) if checked.shown else (None, None)
    return {
        **_cell(checked.cell),
        "label": checked.label,
        "repeat": reading.repeat,
        "gear": checked.gear,
        **named_record(reading, "pressure_kpa", "temperature_c", engine_rpm="engine_speed"),
        **named_record(permissible, permissible_low_kpa="low", permissible_high_kpa="high"),
        **named_record(permissible, permissible_source="source"),
        **named_record(checked, "stands", over_permissible_kpa="over", expected_kpa="expected"),
        **named_record(now, expected_low_kpa="low", expected_high_kpa="high"),
        **named_record(new, expected_new_kpa="value", expected_new_low_kpa="low", expected_new_high_kpa="high"),
        "stands_to_expected": checked.stands_to_expected,
        **named_record(None if line else checked, "line_kpa", "below_line_kpa"),
        "loss_kpa": scaled(checked.loss, KPA),
        **interval_ends("loss_{}_kpa", checked.loss_interval, KPA),
        **named_record(checked, not_judged="unjudged", verdict="verdict"),
        **named_record(deciding, "decision"),
        "probability_over_limit": finite(deciding.probability_over_limit) if deciding else None,
        "rules": [unit_rule_record(diagnosis, each.rule) for each in checked.decisions],
        "place": reading.place.parts,
    }


def _pattern(pattern: Pattern, controller: Controller) -> dict[str, Any]:
    say = wording("en")
    return {
        "kind": pattern.kind,
        "text": pattern_text(pattern, controller, say),
        "source": say.get("pattern_sources", pattern.source),
        "cells": [_cell(cell) for cell in pattern.cells],
        "lands": [
            {**of_land(key), "share_percent": share * PERCENT}
            for (what, *which), share in pattern.causes.items()
            if what == "land"
            for key in which
        ],
    }


def pattern_text(pattern: Pattern, controller: Controller, say: Wording) -> str:
    """Return a pattern as sentences in a language, with where to look first."""
    worst, amount = pattern.worst, pattern.amount or 0.0
    circuits = ", ".join(tap_text(controller, name, say) for name in pattern.circuits)
    key = f"{pattern.kind}_named" if pattern.kind == "one_range_low" and circuits else pattern.kind
    sentence = say(
        f"patterns.{key}",
        ranges=", ".join(pattern.ranges),
        others=", ".join(pattern.others),
        circuits=circuits,
        count=len(pattern.cells),
        worst="" if worst is None else f"{worst.range}, {say.sentence(worst.engine.label)}",
        percent=say.percent(amount, 0),
        kpa=say.value(amount * KPA, "pressure", 0),
    )
    assumed = "" if pattern.measured else "_assumed"  # no reading tells how likely each cause is

    def part(what: str, share: float) -> str:
        return what if assumed else say("patterns.part_of_it", what=what, percent=say.percent(share, 0))

    lands = [
        part(land_words(controller, which[0], say), share)
        for (what, *which), share in pattern.causes.items()
        if what == "land" and share >= LEAST_OF_A_LAND
    ][:MOST_LANDS]
    others = [
        part(say(f"patterns.cause_{what}"), share)
        for (what, *_), share in pattern.causes.items()
        if what != "land" and share >= _WORTH_NAMING
    ]
    named = [say(f"patterns.lands_first{assumed}", lands=", ".join(lands))] if lands else []
    beside = [say(f"patterns.besides{assumed}", causes=", ".join(others))] if others else []
    by_a_land = bool(assumed) or next(iter(pattern.causes), ("land",))[0] == "land"
    return " ".join([sentence, *(named + beside if by_a_land else beside + named)])


def _cell(cell: GaugeCell) -> dict[str, Any]:
    return {"range": cell.range, "state": cell.engine, "tap": cell.tap}


def permissible_text(permissible: PermissiblePressure | None, say: Wording) -> str | None:
    """Return what is permissible in a reader's language and unit; None where nothing is stated.

    >>> permissible_text(PermissiblePressure(frozenset(), "idle", 412e3, None, ""), wording("en"))
    'from 412'
    """
    if permissible is None:
        return None
    low, high = ("" if end is None else _kpa(end, say) for end in (permissible.low, permissible.high))
    key = "low_and_high" if low and high else "low" if low else "high"
    return say(f"permissible.{key}", low=low, high=high)


def _kpa(pressure: float, say: Wording) -> str:
    kpa = round(pressure * KPA, 1)
    return say.value(kpa, "pressure", 0 if kpa.is_integer() else 1)


def tap_text(controller: Controller, tap: str, say: Wording) -> str:
    """Return the name of a tap in a language."""
    return say("permissible.line") if tap == LINE_TAP else say.name(tap_name(controller, tap))


def gauge_table(check: PressureCheck, say: Wording) -> Table:
    """Return a row for every reading: what was shown, permitted, expected, and the verdict; no column is empty."""
    repeated = any(each.reading.repeat > 1 for each in check.readings)
    circuits = any(each.cell.tap != LINE_TAP for each in check.readings)

    def tap(each: CheckedReading) -> str:
        return say("permissible.line") if each.cell.tap == LINE_TAP else say.name(each.tap_name)

    shown = (
        Column("verdict", VERDICT, width=92, of=lambda each: each.verdict or say("texts.not_judged")),
        Column("range", of=lambda each: each.cell.range),
        Column("engine_state", width=150, of=lambda each: say.sentence(each.cell.engine.label)),
        Column("tap", width=150, of=lambda each: tap(each) if circuits else None),
        Column("reading_number", digits=0, width=44, of=lambda each: each.reading.repeat if repeated else None),
        Column("gauge", "pressure", _typed_places(check), of=lambda each: each.reading.pressure, times=KPA),
        Column("permitted", words_of="pressure", of=lambda each: permissible_text(each.permissible, say)),
        Column("expected", "pressure", of=lambda each: each.expected, times=KPA),
        Column("expected_new", "pressure", of=_when_new, times=KPA),
        Column("stands_to_expected", width=120, of=lambda each: _stands(each, say)),
        Column("lost", "pressure", of=lambda each: each.loss, times=KPA),
        Column("lost_between", words_of="pressure", of=lambda each: _between(each, say)),
        Column("past_limit", of=lambda each: None if each.over_limit is None else say.percent(each.over_limit, 0)),
        Column("decision", width=110, of=lambda each: each.deciding and say.get("decisions", each.deciding.decision)),
    )
    return Table("gauges", shown, check.readings, say).filled


def _stands(each: CheckedReading, say: Wording) -> str | None:
    """Return how a reading stands to what gauges would show of the unit new, and of it as measured, in words."""
    stands = each.stands_to_expected
    if stands in ("below", "above") and each.shown is not None and each.shown.measured:
        return say(f"stands_to_expected.{stands}_both")
    return None if stands is None else say(f"stands_to_expected.{stands}")


def _when_new(each: CheckedReading) -> float | None:
    """Return what a new unit would show [Pa], where that is not what is expected anyway."""
    return each.shown.new.value if each.shown is not None and each.shown.measured else None


def _typed_places(check: PressureCheck) -> int:
    """Return how many decimal places of a kPa were typed; one of another unit seldom has a whole number of them."""
    decimals = [len(f"{each.reading.pressure * KPA:.9g}".partition(".")[2]) for each in check.readings]
    return max((places for places in decimals if places <= MOST_TYPED), default=0)


def _between(each: CheckedReading, say: Wording) -> str | None:
    if each.loss_interval is None:
        return None
    low, high = (say.value(max(end, 0.0) * KPA, "pressure", 0) for end in each.loss_interval)
    return say("permissible.low_and_high", low=low, high=high)


def card_table(diagnosis: Diagnosis, say: Wording) -> Table:
    """Return what gauges should show on a unit, a row for every tap, range and state of the engine."""
    card = diagnosis.gauge_card

    def shows(name: str) -> Column:
        def end(row: CardRow, number: int) -> float | str | None:
            if row.expected is None:
                return None if number else say("gauge_card.not_computed")
            return float(getattr(row.expected, name)[number]) * KPA

        keys = (f"card_{name}{which}" for which in ("", "_low", "_high"))
        parts = tuple(Column(key, "pressure", 0, of=partial(end, number=number)) for number, key in enumerate(keys))

        def said(row: CardRow) -> str:
            value, low, high = (each.text(row, say) for each in parts)
            return value if row.expected is None else f"{value} ({low}–{high})"

        return Column(f"card_{name}", words_of="pressure", of=said, parts=parts)

    columns = (
        Column("tap", of=lambda row: tap_text(diagnosis.controller, row.tap, say)),
        Column("range", width=100, of=lambda row: ", ".join(row.ranges)),
        Column("engine_state", width=100, of=lambda row: say.sentence(row.engine.label)),
        shows("new"),
        *([shows("now")] if card.measured else []),
        Column("temperature", "temperature", 0, of=lambda row: row.point and row.point.temperature),
        Column("engine_speed", "engine_speed", of=lambda row: row.point and row.point.engine_speed, times=RPM),
    )
    return Table("gauge_card", columns, list(card.rows(_stated_fast_idle(diagnosis) or USUAL_FAST_IDLE)), say)


def card_notes(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    """Yield what a reader of the card must know."""
    file = diagnosis.readings.file if diagnosis.readings else ""
    if diagnosis.gauge_card.measured:
        yield say("gauge_card.now", file=file) if file else say("gauge_card.now_pump")
    yield say("gauge_card.interval")
    if _stated_fast_idle(diagnosis) is None:
        yield say("gauge_card.fast_idle", speed=say.value(USUAL_FAST_IDLE * RPM, "engine_speed", 0))
    if any(row.point is None for row in diagnosis.gauge_card.rows()):
        yield say("gauge_card.no_point")


def _stated_fast_idle(diagnosis: Diagnosis) -> float | None:
    """Return the speed of a fast idle that the gauge readings state [1/s]; None where they do not."""
    taken = diagnosis.pressures.table.readings if diagnosis.pressures else ()
    speeds = (each.engine_speed for each in taken if each.cell.engine is Engine.FAST_IDLE)
    return next(filter(None, speeds), None)


def pattern_sentences(check: PressureCheck, controller: Controller, say: Wording) -> list[str]:
    """Return what the readings hint at together, each hint with where it is known from."""
    return [
        f"{pattern_text(each, controller, say)} ({say.get('pattern_sources', each.source)})" for each in check.patterns
    ]
