"""What a job record says beside its result is doubted where the two cannot both be so."""

from __future__ import annotations

import pytest

from atleak.analysis.pressures import behind_limits
from atleak.analysis.record_doubts import record_doubts
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job


def instruments(*names: str) -> Job:
    return Job(instruments=[{"name": name, "serial": "0042"} for name in names])


def test_instruments_of_the_record_that_are_not_those_of_the_uncertainty_are_told(worn: Diagnosis) -> None:
    job = instruments("bore gauge BG-1188", "micrometer 0-25 mm")
    (doubt,) = record_doubts(job, worn)
    assert (doubt.level, doubt.code) == ("warning", "instruments_differ")
    assert "the uncertainty of the spools is computed with Workshop microscope" in doubt.text
    assert "bore gauge BG-1188, micrometer 0-25 mm" in doubt.text
    assert "Werkstattmikroskop" in wording("de").sentence(doubt.text)


@pytest.mark.parametrize(
    "names",
    [(), ("Two-point bore gauge", "WORKSHOP MICROSCOPE 12"), ("workshop_microscope", "bore gauge"), ("bore gauge",)],
)
def test_the_same_instruments_in_other_words_are_not_doubted(worn: Diagnosis, names: tuple[str, ...]) -> None:
    assert record_doubts(instruments(*names), worn) == ()


@pytest.mark.parametrize("language", languages())
def test_an_instrument_may_be_named_in_any_language(worn: Diagnosis, language: str) -> None:
    taken = worn.uncertainty.instruments
    names = [wording(language).name(each.name) for each in (taken.spool, taken.sleeve)]
    assert record_doubts(instruments(*names), worn) == ()


def test_parts_that_the_valve_body_does_not_have_are_told_with_the_nearest(worn: Diagnosis) -> None:
    job = Job(
        scratches=[{"component": "8"}, {"component": "255"}, {"description": "all over"}],
        photos=[{"file": "a.png", "component": "266"}],
        repair_decisions=[{"component": "99"}],
    )
    said = [doubt.text for doubt in record_doubts(job, worn)]
    assert all("has no such component" in text for text in said)
    assert [text.split("]")[0].split("[")[1] for text in said] == ["repair_decisions 1", "scratches 2", "photos 1"]
    assert "did you mean '25'?" in said[1]
    assert "did you mean '26'?" in said[2]


@pytest.mark.parametrize("language", languages())
def test_work_that_no_limit_asks_for_is_doubted_until_it_is_done_or_declined(worn: Diagnosis, language: str) -> None:
    sound = next(land.key for land in worn.lands if land.key not in behind_limits(worn))
    due = worn.flagged[0].key

    def doubts(decision: str, *keys: tuple[str, int]) -> list[str]:
        decisions = [{"component": key[0], "land": key[1], "work": "ream", "decision": decision} for key in keys]
        found = record_doubts(Job(repair_decisions=decisions), worn)
        assert {each.code for each in found} <= {"work_without_need"}
        return [wording(language).sentence(each.text) for each in found]

    for decision in ("proposed", "approved"):
        (said,) = doubts(decision, sound, due)
        assert f"{sound[0]}/{sound[1]}" in said
        assert wording(language).name(worn.controller.components[sound[0]]) in said
    assert not [*doubts("done", sound), *doubts("declined", sound), *doubts("deferred", sound)]


def test_work_on_a_land_behind_a_lost_pressure_is_not_doubted(worn_clutch: Diagnosis) -> None:
    keys = behind_limits(worn_clutch)
    assert keys >= {land.key for land in worn_clutch.flagged}
    decisions = [{"component": key[0], "land": key[1], "decision": "approved"} for key in sorted(keys)]
    assert not record_doubts(Job(repair_decisions=decisions), worn_clutch)
