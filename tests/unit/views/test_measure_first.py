"""Which lands a complaint asks to measure first."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.catalogue.complaints import Complaint
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis import Diagnosis, diagnose
from atleak.readings import Readings
from atleak.views.diagnosis_record import diagnosis_record, to_json
from atleak.views.measure_first import Doubt, head, measure_first, reason
from atleak.wording import languages, wording

Build = Callable[..., Readings]
HOT = Complaint("hot", "Slips hot", ("hot_idle",), (), "test")


def with_complaint(diagnosis: Diagnosis, complaint: Complaint) -> Diagnosis:
    return replace(diagnosis, complaint=complaint)


def test_what_is_open_comes_first_then_what_carries_most(sample: Diagnosis) -> None:
    ranked = measure_first(with_complaint(sample, HOT))
    idle = sample.hot_idle
    assert idle is not None
    everything = sum(gap.leakage for gap in idle.gaps)
    assert {each.land.key for each in ranked} == {gap.gap.key for gap in idle.gaps if gap.leakage > 0.0}
    for each in ranked:
        assert each.part == pytest.approx(idle.leakage_of(each.land.key) / everything, rel=1e-12, abs=0.0)
        assert (each.doubt is Doubt.CONDITIONAL) == (each.land.decision in {"conditional_pass", "conditional_fail"})
    order = [(each.doubt is Doubt.NONE, -each.part) for each in ranked]
    assert order == sorted(order)
    assert len({first for first, _ in order}) == 2


def test_lands_that_nobody_measured_come_before_worn_ones_that_are_sure(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    land, half = minimal.land("accumulator", 1), minimal.land("tcc_regulator", 1)
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 8.0 * land.new_clearance),
        half.key: (half.nominal_diameter, None),
    }
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, diameters), complaint=HOT)
    ranked = measure_first(diagnosis)
    assert ranked[-1].land.key == land.key
    assert ranked[-1].part > 0.5
    doubts = {each.land.key: each.doubt for each in ranked}
    assert doubts.pop(land.key) is Doubt.NONE
    assert doubts.pop(half.key) is Doubt.HALF_MEASURED
    assert set(doubts.values()) == {Doubt.NOT_MEASURED}
    assert "not measured; as new it carries" in reason(ranked[0])


def test_a_complaint_that_names_its_lands_asks_for_those_alone(sample: Diagnosis) -> None:
    named = replace(HOT, lands=(("25", 1), ("6", 1)))  # 6/1 leaks in no operating point
    ranked = measure_first(with_complaint(sample, named))
    assert {each.land.key for each in ranked} == {("25", 1), ("6", 1)}
    silent = next(each for each in ranked if each.land.key == ("6", 1))
    assert silent.part == 0.0


def test_of_several_conditions_the_one_counts_in_which_a_land_carries_most(sample: Diagnosis) -> None:
    both = with_complaint(sample, replace(HOT, conditions=("hot_idle", "driving_second")))
    for each in measure_first(both):
        parts = {}
        for at in both.complained:
            parts[at.condition.name] = at.leakage_of(each.land.key) / sum(gap.leakage for gap in at.gaps)
        assert each.projection.condition.name == max(parts, key=parts.__getitem__)
        assert each.part == pytest.approx(max(parts.values()), rel=1e-12, abs=0.0)


def test_where_nothing_is_open_nothing_is_to_be_measured_first(sample: Diagnosis) -> None:
    ranked = measure_first(with_complaint(sample, HOT))
    sure = [each for each in ranked if each.doubt is Doubt.NONE]
    assert head(ranked) == "Measure first:"
    assert head(sure).startswith("Every land behind it is measured and its verdict is sure")
    assert head([]) == "No land leaks there."


def test_without_a_complaint_nothing_is_asked(sample: Diagnosis) -> None:
    assert measure_first(sample) == ()
    assert diagnosis_record(sample)["complaint"] is None


def test_a_complaint_leads_and_changes_no_number(sample: Diagnosis) -> None:
    led = with_complaint(sample, HOT)
    assert [at.condition.name for at in led.presented] == ["hot_idle", "driving_second"]
    assert led.reported[0] is led.hot_idle
    record, before = diagnosis_record(led), diagnosis_record(sample)
    assert record["complaint"]["measure_first"]
    assert record | {"complaint": None} == before  # the records are kept with the diagnoses: not to be changed


def test_the_record_says_why_each_land_is_to_be_measured(sample: Diagnosis) -> None:
    complaint = json.loads(to_json(diagnosis_record(with_complaint(sample, HOT))))["complaint"]
    assert (complaint["id"], complaint["label"], complaint["conditions"]) == ("hot", "Slips hot", ["hot_idle"])
    for row in complaint["measure_first"]:
        assert row.keys() >= {"component", "land", "reason"}
        assert (
            f"{row['part_percent']:.1f}\N{NO-BREAK SPACE}% of what leaks at “hot idle in drive, 100 °C”"
            in row["reason"]
        )


@pytest.mark.parametrize("language", languages())
def test_every_language_has_words_for_every_doubt(language: str) -> None:
    say = wording(language)
    for doubt in Doubt:
        assert "PART" in say(f"complaint.{doubt}", verdict="V", carried="PART")
