"""Where today's version judges a kept job otherwise, said in the reader's language."""

from __future__ import annotations

from atleak.common.wording import wording
from atleak.job.result import judged_otherwise

BEFORE = {
    "verdict": "replace",
    "unit": {"decision": "conditional_fail"},
    "lands": [{"component": "25", "land": 1, "verdict": "watch", "decision": None}],
    "conditions": [{"name": "cold_start", "label": "cold start", "band": "red"}],
}
TODAY = {
    "verdict": "not_measured",
    "unit": {},
    "lands": [],
    "conditions": [{"name": "cold_start", "label": "cold start", "band": "amber"}],
}


def test_every_verdict_that_differs_is_said_with_both() -> None:
    assert [str(each) for each in judged_otherwise(BEFORE, TODAY)] == [
        "the unit: replace (conditional fail), today not measured",
        "25/1: watch, today not judged",
        "total at cold start: red, today amber",
    ]
    assert judged_otherwise(BEFORE, BEFORE) == ()


def test_it_is_said_in_the_reader_s_language() -> None:
    assert [wording("de").sentence(each) for each in judged_otherwise(BEFORE, TODAY)] == [
        "das Gerät: ersetzen (bedingt überschritten), heute nicht gemessen",
        "25/1: beobachten, heute nicht beurteilt",
        "Summe bei „cold start“: rot, heute gelb",
    ]


def test_a_number_that_differs_is_said_by_name_in_the_reader_s_units() -> None:
    land = {"component": "25", "land": 1, "verdict": "ok", "radial_clearance_um": 12.5, "share_percent": None}
    other = land | {"radial_clearance_um": 25.4}
    (changed,) = judged_otherwise({"lands": [land]}, {"lands": [other]}, numbers=True)
    assert str(changed) == "25/1: radial clearance 12.5 µm, today radial clearance 25.4 µm"
    said = wording("de", "us").sentence(changed)
    assert said == "25/1: Radialspiel 0,00049 in, heute Radialspiel 0,001 in"
