"""Record for scripts which part it is."""

from __future__ import annotations

from typing import Any

from atleak.analysis.answer import Answer, answer_of
from atleak.analysis.repair.plan import RepairStep
from atleak.catalogue.repairs import PUMP
from atleak.common.units import KPA
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.json.conditions import (
    explained_record,
    kit_components,
    named_record,
    of_land,
    scaled,
    unexplained_record,
)
from atleak.report.tables.answer import answer_lines

_NOTHING = dict.fromkeys(("unexplained_kpa", "unexplained_low_kpa", "unexplained_high_kpa"))


def answer_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the answer of a diagnosis, in the form of ``diagnose --json``."""
    answer, say = answer_of(diagnosis), wording("en")
    land, cost, missing = answer.land, answer.cost, answer.missing
    prices = {} if cost is None else cost.prices
    currency = next(iter(prices)) if len(prices) == 1 else None
    return {
        "cause": answer.cause,
        "also": list(answer.also),
        "circuit": answer.circuit,
        "component": land[0] if land else None,
        "land": land[1] if land else None,
        "cause_probability": answer.probability,
        "condition": answer.condition,
        "missing_kpa": None if missing is None else missing.amount(lambda each: each.missing).value * KPA,
        "explained": [] if missing is None else explained_record(missing),
        **(_NOTHING if missing is None else unexplained_record(missing)),
        "text": answer_lines(answer, say)._asdict(),
        "do": _do(answer),
        "cost": prices.get(currency) if currency else None,
        "currency": currency,
        "next_measurement": [
            {**named_record(each, "component", "land", "part"), "value": scaled(each.value, KPA)}
            for each in answer.next_measurements
        ],
    }


def _do(answer: Answer) -> list[dict[str, Any]]:
    return [
        {
            **(of_land(step.land.key) if isinstance(step, RepairStep) else {"component": PUMP, "land": None}),
            "components": kit_components(step.chosen.repair if step.chosen else None),
            **named_record(step.chosen and step.chosen.repair, repair="id", price="price", hours="hours"),
        }
        for step in answer.steps
    ]
