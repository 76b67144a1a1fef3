"""What a complaint has to do with what was found, and which lands it asks to measure first."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.repairs import Complaint
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.tables.complaint import Doubt, explanations, finding, measure_first, reason

EN = wording("en")

Build = Callable[..., Readings]
HOT = Complaint("hot", "Slips hot", ("hot_idle",), (), "test")


def with_complaint(diagnosis: Diagnosis, complaint: Complaint) -> Diagnosis:
    return replace(diagnosis, complaint=complaint)


@pytest.fixture
def partly(minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> Diagnosis:
    """One land worn and measured, one of which the spool alone was, the others not measured."""
    land, half = minimal.land("accumulator", 1), minimal.land("tcc_regulator", 1)
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 8.0 * land.new_clearance),
        half.key: (half.nominal_diameter, None),
    }
    return diagnose(minimal, hipol, limits, readings=readings_of(minimal, diameters), complaint=HOT)


def test_only_lands_that_are_not_measured_are_to_be_measured_first_those_that_carry_most_before(partly) -> None:
    ranked, idle = measure_first(partly), partly.hot_idle
    everything = sum(gap.leakage for gap in idle.gaps)
    leaking = {gap.gap.key for gap in idle.gaps if gap.leakage > 0.0}
    assert {each.land.key for each in ranked} == leaking & {land.key for land in partly.unmeasured}
    for each in ranked:
        assert each.part == pytest.approx(idle.leakage_of(each.land.key) / everything, rel=1e-12, abs=0.0)
    assert [-each.part for each in ranked] == sorted(-each.part for each in ranked)
    doubts = {each.land.key: each.doubt for each in ranked}
    assert ("accumulator", 1) not in doubts
    assert doubts.pop(("tcc_regulator", 1)) is Doubt.HALF_MEASURED
    assert set(doubts.values()) == {Doubt.NOT_MEASURED}
    assert "not measured; as new it carries" in next(
        reason(each, EN) for each in ranked if each.doubt == "not_measured"
    )
    assert finding(partly, EN).endswith("Measure first:")


def test_a_complaint_that_names_its_lands_asks_for_those_alone(unmeasured: Diagnosis) -> None:
    named = replace(HOT, lands=(("25", 1), ("6", 1)))  # 6/1 leaks in no operating point
    ranked = measure_first(with_complaint(unmeasured, named))
    assert {each.land.key for each in ranked} == {("25", 1), ("6", 1)}
    silent = next(each for each in ranked if each.land.key == ("6", 1))
    assert silent.part == 0.0


def test_of_several_conditions_the_one_counts_in_which_a_land_carries_most(unmeasured: Diagnosis) -> None:
    both = with_complaint(unmeasured, replace(HOT, conditions=("hot_idle", "driving_second")))
    for each in measure_first(both):
        parts = {}
        for at in both.complained:
            parts[at.condition.name] = at.leakage_of(each.land.key) / sum(gap.leakage for gap in at.gaps)
        assert each.projection.condition.name == max(parts, key=parts.__getitem__)
        assert each.part == pytest.approx(max(parts.values()), rel=1e-12, abs=0.0)


def test_of_a_unit_that_is_measured_nothing_is_to_be_measured_first(sample: Diagnosis) -> None:
    found = with_complaint(sample, HOT)
    assert measure_first(found) == ()
    assert finding(found, EN).endswith("Every land that leaks there is measured.")


# --- what explains a complaint


def test_a_leak_without_effect_on_a_pressure_explains_no_complaint(worn: Diagnosis) -> None:
    """Lands of the sample's unit are worn past their limits, and every pressure is held."""
    found = with_complaint(worn, HOT)
    assert found.flagged
    assert not explanations(found, HOT)
    said = finding(found, EN)
    assert "the leaks have no effect on a pressure there" in said
    assert "Next to check: clutch plates" in said
    assert "describes no circuits: only the line is judged" in said
    assert diagnosis_record(found)["complaint"]["explained_by"] == []


def test_where_no_pressure_is_solved_no_leak_is_said_to_have_no_effect(sample: Diagnosis) -> None:
    paper = replace(sample, profile=PAPER, complaint=HOT)
    assert "none is solved" in finding(paper, EN)
    assert "no effect" not in finding(paper, EN)


def test_nothing_is_said_of_a_unit_that_nobody_measured(unmeasured: Diagnosis) -> None:
    assert finding(with_complaint(unmeasured, HOT), EN) == "Measure first:"


@pytest.fixture(scope="module")
def clutch(worn_clutch) -> Diagnosis:
    """The small valve body whose clutch C1 loses pressure past its limit, because of the valve that feeds it."""
    return worn_clutch


def test_a_complaint_is_linked_to_the_lands_that_take_a_pressure_past_its_limit(clutch: Diagnosis) -> None:
    names = tuple(point.condition.name for point in clutch.projections)
    anywhere = Complaint("slips", "Slips", names, (), "test")
    found = with_complaint(clutch, anywhere)
    linked = explanations(found, anywhere)
    past = [rule for rule in clutch.pressure_rules if rule.verdict.flagged]
    assert {each.rule.id for each in linked} <= {rule.id for rule in past}
    assert linked[0].held is not None
    assert linked[0].held.loss >= linked[0].held.rule.steps.levels[0][1]
    for each in linked:
        losses = clutch.losses_at(clutch.at(each.rule.condition))[each.held.id]
        assert all(losses[key] > 0.0 for key in each.lands)
    assert "The leaks can explain it, because of" in finding(found, EN)
    rows = diagnosis_record(found)["complaint"]["explained_by"]
    assert [row["rule"] for row in rows] == [each.rule.id for each in linked]
    others = {land.key for land in clutch.lands} - {key for each in linked for key in each.lands}
    elsewhere = replace(anywhere, lands=tuple(sorted(others)))
    assert not explanations(with_complaint(clutch, elsewhere), elsewhere)


@pytest.mark.parametrize(("wanted", "linked"), [(1.2, False), (0.9, True), (0.45, False)])
def test_a_reserve_explains_a_complaint_only_where_worn_lands_make_the_pump_fall_short(
    worn: Diagnosis, wanted: float, linked: bool
) -> None:
    """At 1.2 it is to be watched, and every pressure is held; at 0.45 no new unit holds it: nothing is judged there."""
    idle = worn.hot_idle
    assert idle is not None
    speed = idle.condition.engine_speed * wanted / idle.reserve
    slow = replace(idle.condition, name="stated", engine_speed=speed)
    found = diagnose(
        worn.controller,
        worn.fluid,
        worn.limits,
        readings=worn.readings,
        condition=slow,
        complaint=replace(HOT, conditions=("stated",)),
    )
    assert found.complaint is not None
    rule = found.pressure_rule(found.projection, RuleKind.RESERVE)
    assert (rule is None) == (wanted == 0.45)
    assert rule is None or rule.verdict.flagged
    assert found.projection.reserve == pytest.approx(wanted, abs=1e-6)
    by_reserve = [each for each in explanations(found, found.complaint) if each.held is None]
    assert bool(by_reserve) == linked


def test_a_pressure_that_a_new_unit_lacks_too_is_explained_by_no_land(clutch: Diagnosis) -> None:
    names = tuple(point.condition.name for point in clutch.projections)
    anywhere = Complaint("slips", "Slips", names, (), "test")
    weak = replace(clutch, unworn_projections=clutch.projections)
    assert not [each for each in explanations(weak, anywhere) if each.held is not None]


def test_without_a_complaint_nothing_is_asked(sample: Diagnosis) -> None:
    assert measure_first(sample) == ()
    assert diagnosis_record(sample)["complaint"] is None


def test_a_complaint_leads_and_changes_no_number(sample: Diagnosis) -> None:
    led = with_complaint(sample, HOT)
    assert [at.condition.name for at in led.presented] == ["hot_idle", "driving_second"]
    assert led.reported[0] is led.hot_idle
    record, before = diagnosis_record(led), diagnosis_record(sample)
    assert record["complaint"]["text"]
    assert record | {"complaint": None} == before  # the records are kept with the diagnoses: not to be changed


def test_the_record_says_why_each_land_is_to_be_measured(unmeasured: Diagnosis) -> None:
    complaint = json.loads(to_json(diagnosis_record(with_complaint(unmeasured, HOT))))["complaint"]
    assert complaint["measure_first"]
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
        assert "PART" in say(f"complaint.{doubt}", carried="PART")
