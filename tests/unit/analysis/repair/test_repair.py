"""Which repairs, in which order, what each brings at every condition, and where the plan ends."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.analysis.repair.plan import RepairPlan, plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.common.verdicts import Band
from atleak.common.wording import wording
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import project, repaired, stated_condition
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.tables.repairs import no_help, plan_ends
from tests.unit.conftest import first_of

EN = wording("en")


Edited = Callable[..., Path]
Build = Callable[..., Readings]
BANDS_OF_SHARE_ALONE = (
    "[total_share_percent]\namber = { growth_percent = 25.0, added_points = 2.0 }\n"
    "red = { growth_percent = 50.0, added_points = 4.0 }",
    "[total_share_percent]\namber = 10.0\nred = 20.0",
)
REVERSE = """
id = "with_reverse"
name = "Unit with a reverse boost valve"
source = "made for this test"
date = "2026-11-21"
gears = [-1, 1, 2]

[materials.aluminium]
expansion_per_k = 21.3e-6
source = "handbook"

[defaults]
contact_length_mm = 5.0
body = "aluminium"
spool = "aluminium"

[pump]
displacement_mm3 = 18000.0
volumetric_efficiency = 0.92
source = "made for this test"

[[operating_points]]
name = "hot_idle"
label = "hot idle in drive, 100 °C"
temperature_c = 100.0
engine_rpm = 700.0
gear = 1
p_g_kpa = 420.0
p_k_kpa = 250.0
source = "made for this test"

[[operating_points]]
name = "reverse_idle"
label = "reverse at idle, 100 °C"
temperature_c = 100.0
engine_rpm = 700.0
gear = -1
p_g_kpa = 1100.0
p_k_kpa = 250.0
source = "made for this test"

[[components]]
id = "boost"
name = "boost valve"
lands = [{ land = 2, nominal_diameter_mm = 15.0, mounting_clearance_um = 18.0 }]

[[components]]
id = "pr"
name = "pressure regulator valve"
lands = [
  { land = 1, nominal_diameter_mm = 14.5, mounting_clearance_um = 18.0 },
  { land = 2, nominal_diameter_mm = 14.5, mounting_clearance_um = 18.0 },
]

[[components]]
id = "spare"
name = "valve that no operating point uses"
lands = [{ land = 1, nominal_diameter_mm = 12.0, mounting_clearance_um = 18.0 }]

[[gaps]]
component = "boost"
land = 2
section = "p_g"
from = "p_g"
to = "drain"
gears = [-1]

[[gaps]]
component = "pr"
land = 1
section = "p_g"
from = "p_g"
to = "drain"
gears = [-1, 1]

[[gaps]]
component = "pr"
land = 2
section = "p_g"
from = "p_g"
to = "drain"
gears = [1]

[[gaps]]
component = "spare"
land = 1
section = "p_g"
from = "p_g"
to = "drain"
gears = [2]
"""


@pytest.fixture
def reversing(tmp_path: Path) -> Controller:
    path = tmp_path / "with_reverse.toml"
    path.write_text(REVERSE, encoding="utf-8")
    return load_controller(path)


def worn(controller: Controller, growth: dict[tuple[str, int], float]) -> dict[tuple[str, int], tuple[float, float]]:
    """Diameters of lands whose clearance has grown by a fraction of that of a new one."""
    return {
        key: (land.nominal_diameter, land.nominal_diameter + 2.0 * (1.0 + growth[key]) * land.new_clearance)
        for key in growth
        for land in [controller.land(*key)]
    }


def alike(controller: Controller, growth: float) -> dict[tuple[str, int], float]:
    return {land.key: growth for land in controller.lands}


def steps_of(plan: RepairPlan) -> list[tuple[str, int]]:
    return [step.land.key for step in plan.steps]


def mended(diagnosis: Diagnosis, keys: Iterable[tuple[str, int]]) -> list[float]:
    """The total share at every condition of the unit with those lands repaired, by the engine."""
    states = repaired([land.state for land in diagnosis.lands], keys)
    model = LeakageModel(diagnosis.controller, states, diagnosis.fluid, diagnosis.profile)
    return [project(model, each.condition).share for each in diagnosis.projections]


# --- steps


def test_every_step_is_the_unit_with_those_lands_repaired_at_every_condition(sample: Diagnosis) -> None:
    plan = plan_repairs(sample)
    assert set(steps_of(plan)) >= {land.key for land in sample.flagged}
    before = [each.share for each in sample.projections]
    for number, step in enumerate(plan.steps, start=1):
        after = mended(sample, steps_of(plan)[:number])
        assert [each.before.share for each in step.conditions] == pytest.approx(before, rel=1e-9, abs=0.0)
        assert [each.after.share for each in step.conditions] == pytest.approx(after, rel=1e-9, abs=0.0)
        before = after
    assert [end.share for end in plan.ends] == pytest.approx(before, rel=1e-9, abs=0.0)


def test_the_band_after_a_step_is_that_of_a_unit_so_repaired(sample: Diagnosis, limits: Limits) -> None:
    even = replace(DEFAULTS, one_sided_wear=0.0)  # by the shares alone
    known = {"readings": sample.readings, "profile": sample.profile, "assumptions": even}
    found = diagnose(sample.controller, sample.fluid, limits, **known)
    for step in plan_repairs(found).steps:
        for each, now, new in zip(step.conditions, found.projections, found.new_projections, strict=True):
            edges = limits.total_share.over(new.share)
            reached = [band for band, limit in edges if each.after.share >= limit]
            assert each.after.band == (reached[-1] if reached else Band.GREEN)
            assert each.condition == now.condition


def test_lands_come_worst_first_then_by_what_they_save_of_a_limit(sample: Diagnosis) -> None:
    """Worked out from the projections alone: the share saved over the limit at which green ends, where that is most."""
    savings = {}
    for land in sample.flagged:
        savings[land.key] = max(
            (now.drawn_by(land.key) - new.drawn_by(land.key)) / now.pump_capacity
            / min(limit for _, limit in rule.steps.levels)
            for now, new, rule in zip(sample.projections, sample.new_projections, sample.total_rules, strict=True)
        )  # fmt: skip
    expected = sorted(sample.flagged, key=lambda land: (-land.verdict.rank, -savings[land.key]))
    plan = plan_repairs(sample)
    assert steps_of(plan)[: len(expected)] == [land.key for land in expected]
    for step in plan.steps[: len(expected)]:
        assert step.at.saving == pytest.approx(savings[step.land.key], rel=1e-9, abs=1e-15)
        assert step.at.saving == max(each.saving for each in step.conditions)


def test_a_reverse_boost_valve_is_repaired_for_what_it_costs_in_reverse(
    reversing: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """At the stated condition, drive at idle, it leaks nothing: there its repair would bring nothing."""
    boost = ("boost", 2)
    readings = readings_of(reversing, worn(reversing, alike(reversing, 0.0) | {boost: 0.81}))
    diagnosis = diagnose(reversing, hipol, limits, readings=readings)
    land = next(each for each in diagnosis.lands if each.key == boost)
    assert land.leakage == 0.0
    (step,) = plan_repairs(diagnosis).steps
    assert step.land.key == boost
    assert step.at.condition.name == "reverse_idle"
    saved = {each.condition.name: each.before.share - each.after.share for each in step.conditions}
    assert saved["hot_idle"] == 0.0
    assert saved["reverse_idle"] > 0.02
    assert diagnosis.worst.condition.name == "reverse_idle"
    row = diagnosis_record(diagnosis)["repair_plan"][0]
    assert (row["at"], row["component"], row["land"]) == ("reverse_idle", *boost)
    assert row["share_before_percent"] - row["share_after_percent"] == pytest.approx(
        100 * saved["reverse_idle"], abs=1e-9
    )


def test_a_land_that_lowers_no_total_says_why_it_is_on_the_list(
    reversing: Controller, four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(reversing, worn(reversing, {("spare", 1): 0.8}))
    (step,) = plan_repairs(diagnose(reversing, hipol, limits, readings=readings)).steps
    assert not step.helps
    assert no_help(step, EN) == "for its own verdict: no operating point lets it leak"
    # land 5/1 of the study leaks from main into modulated pressure, which ends in the sump elsewhere
    readings = readings_of(four_speed, worn(four_speed, {("5", 1): 0.8}))
    (step,) = plan_repairs(diagnose(four_speed, hipol, limits, readings=readings)).steps
    assert not step.helps
    assert "it draws no more from the pump" in no_help(step, EN)


# --- many small leaks


def test_where_only_the_total_is_past_its_limit_the_fewest_lands_bring_it_back(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.11)))
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings)
    assert diagnosis.flagged == ()
    assert {diagnosis.band(each) for each in diagnosis.projections} == {Band.AMBER}
    plan = plan_repairs(diagnosis)
    assert plan.steps
    assert plan.reached
    assert plan.for_total == len(plan.steps)
    edges = [min(limit for _, limit in rule.steps.levels) for rule in diagnosis.total_rules]
    assert all(share < edge for share, edge in zip(mended(diagnosis, steps_of(plan)), edges, strict=True))
    both = list(zip(diagnosis.projections, diagnosis.new_projections, strict=True))
    saved = [
        [now.share_drawn_by(land.key) - new.share_drawn_by(land.key) for now, new in both] for land in diagnosis.lands
    ]
    fewer = itertools.combinations(saved, len(plan.steps) - 1)
    excess = [now.share - edge for (now, _), edge in zip(both, edges, strict=True)]
    assert not any(
        all(sum(column) > need for column, need in zip(zip(*lands, strict=True), excess, strict=True))
        for lands in fewer
    )
    said = " ".join(plan_ends(plan, EN))
    assert f"named for the total alone: {len(plan.steps)}." in said
    assert "green at every condition" in said


def test_lands_that_only_the_total_asks_for_come_after_flagged_ones_and_before_those_that_can_wait(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.13) | {("14", 1): 0.6}))
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings)
    plan = plan_repairs(diagnosis)
    waits = {key for key, consequence in diagnosis.consequences.items() if consequence is Consequence.NONE}
    kinds = [1 if step.for_total else 2 * (step.land.key in waits) for step in plan.steps]
    assert {*kinds} == {0, 1, 2}
    assert kinds == sorted(kinds)
    assert plan.reached


def test_the_steps_that_are_needed_now_mend_the_unit_and_the_others_can_wait(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.13) | {("14", 1): 0.6}))
    plan = plan_repairs(diagnose(four_speed, hipol, limits, readings=readings))
    now = [step for step in plan.steps if step.consequence is Consequence.NOW]
    assert 0 < len(now) < len(plan.steps)
    assert plan.steps[: len(now)] == tuple(now)
    assert any(step.for_total for step in now)
    *_, last = now
    assert not [rule for at in last.conditions for rule in at.after.past]
    assert [rule for at in last.conditions for rule in at.before.past]


# --- the end


def test_a_unit_within_its_limits_needs_nothing(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(minimal, worn(minimal, alike(minimal, 0.0)))
    plan = plan_repairs(diagnose(minimal, hipol, limits, readings=readings))
    assert (plan.steps, plan.reached, plan.unmeasured) == ((), True, 0)
    assert list(plan_ends(plan, EN)) == ["Every total is green as it is."]


def test_lands_that_nobody_measured_are_counted_and_never_repaired(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    half = {("tcc_regulator", 1): (minimal.land("tcc_regulator", 1).nominal_diameter, None)}
    readings = readings_of(minimal, worn(minimal, {("accumulator", 1): 0.9}) | half)
    plan = plan_repairs(diagnose(minimal, hipol, limits, readings=readings))
    assert steps_of(plan) == [("accumulator", 1)]
    assert plan.unmeasured == 4  # three on neither part, one on its spool only
    assert "Not measured on both parts: 4 lands" in " ".join(plan_ends(plan, EN))
    nothing = plan_repairs(diagnose(minimal, hipol, limits))
    assert (nothing.steps, nothing.unmeasured) == ((), 5)


def test_what_no_land_can_mend_is_said_with_what_else_it_may_be_up_to(
    edited: Edited, four_speed: Controller, hipol: Fluid, readings_of: Build
) -> None:
    """By bands of the share alone the study's unit is amber at hot idle when new: no repair makes it green there."""
    own = load_limits(edited("limits", "project_default", BANDS_OF_SHARE_ALONE))
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.0) | {("25", 1): 0.7}))
    diagnosis = diagnose(four_speed, hipol, own, readings=readings)
    plan = plan_repairs(diagnosis)
    assert steps_of(plan) == [("25", 1)]
    assert not plan.reached
    (left,) = plan.remaining
    assert left.total.condition.name == "hot_idle"
    assert left.new_is_past
    assert left.new_share == pytest.approx(left.total.share, rel=1e-9, abs=0.0)
    assert left.kinematic_viscosity == pytest.approx(float(hipol.kinematic_viscosity(100.0)), rel=1e-12, abs=0.0)
    point = left.total.condition
    delivered = diagnosis.projections[1].pump_capacity / (four_speed.pump.displacement * point.engine_speed)
    assert left.pump_loss == pytest.approx(1.0 - delivered, rel=1e-12, abs=0.0)
    said = " ".join(plan_ends(plan, EN)).replace("\N{NO-BREAK SPACE}", " ")
    assert "the total stays at 16.4 % (amber)" in said
    assert "not up to the lands but to the limit, the fluid" in said


def test_lands_bring_back_what_they_can_where_one_condition_stays_past_its_limit(
    edited: Edited, four_speed: Controller, hipol: Fluid, readings_of: Build
) -> None:
    own = load_limits(edited("limits", "project_default", BANDS_OF_SHARE_ALONE))
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.12)))
    diagnosis = diagnose(four_speed, hipol, own, readings=readings)
    assert [diagnosis.band(each) for each in diagnosis.projections] == [Band.AMBER, Band.RED]
    plan = plan_repairs(diagnosis)
    assert [end.band for end in plan.ends] == [Band.GREEN, Band.AMBER]
    assert 0 < plan.for_total < 47


def test_a_pump_that_delivers_nothing_is_not_up_to_the_lands(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(four_speed, worn(four_speed, alike(four_speed, 0.3)))
    still = stated_condition(four_speed, engine_speed=1.0 / 60.0)
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings, condition=still)
    plan = plan_repairs(diagnosis)
    assert [left.total.condition.name for left in plan.remaining] == ["stated"]
    assert math.isinf(plan.remaining[0].total.share)
    assert "the pump delivers nothing: that is not up to the lands" in " ".join(plan_ends(plan, EN))
    assert all(math.isfinite(step.at.saving) for step in plan.steps)


# --- the record


def test_the_record_tells_every_step_at_every_condition_and_the_end(sample: Diagnosis) -> None:
    record = json.loads(to_json(diagnosis_record(sample)))
    shares = {row["name"]: row["share_percent"] for row in record["conditions"]}
    for row in record["repair_plan"]:
        assert [each["name"] for each in row["conditions"]] == list(shares)
        at = next(each for each in row["conditions"] if each["name"] == row["at"])
        assert (row["share_before_percent"], row["share_after_percent"]) == (
            at["share_before_percent"],
            at["share_after_percent"],
        )
        for each in row["conditions"]:
            assert each["share_before_percent"] == pytest.approx(shares[each["name"]], rel=1e-12, abs=0.0)
            shares[each["name"]] = each["share_after_percent"]
            assert each["band_after"] in set(Band)
    ends = record["repair_plan_ends"]
    assert {row["name"]: row["share_percent"] for row in ends["conditions"]} == shares
    assert ends["reached"] == all(row["band"] == "green" for row in ends["conditions"])
    assert bool(ends["remaining"]) != ends["reached"]
    assert ends["lands_not_measured"] == 0


@pytest.mark.parametrize("language", ["de", "en", "pl"])
def test_every_language_says_where_a_plan_ends(
    language: str, edited: Edited, four_speed: Controller, hipol: Fluid, readings_of: Build
) -> None:
    own = load_limits(edited("limits", "project_default", BANDS_OF_SHARE_ALONE))
    readings = readings_of(four_speed, worn(four_speed, {("25", 1): 0.7}))
    say = wording(language)
    plan = plan_repairs(diagnose(four_speed, hipol, own, readings=readings))
    sentences = list(plan_ends(plan, say))
    assert len(sentences) == 2
    assert say.condition(plan.remaining[0].total.projection.condition) in sentences[0]
    assert say.percent(plan.remaining[0].total.share) in sentences[0]
    assert "46" in sentences[1]


@pytest.mark.parametrize("name", first_of(["chrysler_41te", "zf_6hp26", "gm_4l60e"]))
def test_a_plan_is_judged_by_the_likely_value_as_the_unit_is(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    """Every land a little wider than new pairs may be: totals are likely past a limit that their values keep."""
    unit = load_controller(name)
    wide = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.24 * land.mounting_range[1]) for land in unit.lands
    }
    diagnosis = diagnose(unit, hipol, limits, readings=readings_of(unit, wide))
    probable = [rule for rule in diagnosis.total_rules if rule.probable and rule.verdict.flagged]
    assert probable
    plan = plan_repairs(diagnosis)
    for end in plan.ends:
        assert end.total.likely > 1.0 or end.total.rule not in probable
        within = end.share * end.total.likely < end.limit_above(Band.GREEN)
        assert within is (end.band is Band.GREEN)
