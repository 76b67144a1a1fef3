"""From a measuring sheet to intervals, totals and decisions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps
from atleak.common.errors import InputError
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import wording
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import DEFAULTS, NOTHING_ELSE, assess
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.equations import statistics as equations
from atleak.measurements.clearances import clearances
from atleak.report.tables.clearances import budget_rows
from tests.unit.conftest import first_of
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, new_at, two_instruments
from tests.unit.equations import referees

UM = 1e-6
# eq. (4) with the spool's diameter is a pure cube; the paper profile's viscosity, pump and draw do not matter here
CUBE = WORKSHOP.with_options(diameter="spool", entry_loss="off")


@pytest.mark.parametrize(("common_part", "percent"), first_of([(0.5, 6.16), (0.0, 1.90), (1.0, 8.50)]))
def test_twenty_lands_with_a_common_error(
    judge: Callable, twenty_lands: Controller, common_part: float, percent: float
) -> None:
    bare = judge(a_sheet(twenty_lands), controller=twenty_lands, profile=CUBE)
    hot = bare.projections[0].gaps[0].effective_clearance
    tools = two_instruments(calibration=0.0283 * hot * math.sqrt(2.0), common_part=common_part)
    draws = 40_000
    case = judge(a_sheet(twenty_lands), controller=twenty_lands, profile=CUBE, instruments=tools, draws=draws)
    total = case.unit.totals[0]
    drawn_percent = 100.0 * total.u_leakage / total.leakage
    u = 0.0283 * hot
    own = referees.cube_variance(hot, u)
    shared = referees.cube_covariance(hot, u, hot, u, common_part)
    exact = 100.0 * math.sqrt(20 * own + 380 * shared) / (20 * hot**3)
    assert exact == pytest.approx(percent, abs=0.005)
    assert abs(drawn_percent - exact) < 3.0 * exact * math.sqrt(
        0.6 / draws
    )  # standard error, a little more than normal


def test_flow_is_three_times_as_uncertain_as_the_clearance(judge: Callable, twenty_lands: Controller) -> None:
    case = judge(a_sheet(twenty_lands, clearance=25 * UM), controller=twenty_lands, profile=CUBE)
    land, hot = case.unit.lands[0], case.projections[0].gaps[0].effective_clearance
    assert land.u_clearance / (25 * UM) == pytest.approx(0.0424, abs=0.0005)
    stated = land.conditions[0]
    # the gap has opened with heat, its uncertainty has not grown
    assert stated.u_leakage / stated.leakage == pytest.approx(3.0 * land.u_clearance / hot, rel=0.01, abs=0.0)


def test_draws_agree_with_the_closed_form_within_three_standard_errors(
    judge: Callable, twenty_lands: Controller
) -> None:
    draws = 100_000
    case = judge(a_sheet(twenty_lands, clearance=20 * UM), controller=twenty_lands, profile=CUBE, draws=draws)
    gap, land = case.projections[0].gaps[0], case.unit.lands[0]
    factor, u = gap.leakage / gap.effective_clearance**3, land.u_clearance
    exact = factor * math.sqrt(referees.cube_variance(gap.effective_clearance, u))
    stated = land.conditions[0]
    assert abs(stated.u_leakage / exact - 1.0) < 3.0 * math.sqrt(0.6 / draws)
    for p, drawn_end in zip((0.025, 0.975), stated.leakage_interval, strict=True):
        end = factor * referees.cube_quantile(p, gap.effective_clearance, u)
        z = equations.normal_quantile(p)
        c = gap.effective_clearance + z * u
        density = referees.normal_density(z) / (factor * 3.0 * c * c * u)
        assert abs(drawn_end - end) < 3.0 * math.sqrt(p * (1 - p) / draws) / density


@pytest.mark.parametrize("profile", [WORKSHOP, PAPER, WORKSHOP.with_options(entry_loss="on", eccentricity=0.5)])
def test_values_as_measured_are_the_engines_own(judge: Callable, four_speed: Controller, profile: object) -> None:
    case = judge(a_sheet(four_speed), profile=profile, assumptions=DEFAULTS, draws=500)
    for projection, total in zip(case.projections, case.unit.totals, strict=True):
        assert total.leakage == projection.leakage
        assert total.leakage_interval[0] < projection.leakage < total.leakage_interval[1]
        for land in case.unit.lands:
            at = next(at for at in land.conditions if at.condition == projection.condition.name)
            assert at.leakage == pytest.approx(projection.leakage_of(land.key), rel=1e-12, abs=1e-30)
            gaps = projection.gaps_of(land.key)
            assert at.eccentric[0] == sum(gap.concentric_leakage for gap in gaps)
            assert at.eccentric[1] == sum(gap.touching_leakage for gap in gaps)
            assert at.eccentric[0] <= at.leakage * (1.0 + 1e-12)
            assert at.leakage <= at.eccentric[1] <= 2.5 * at.eccentric[0] * (1.0 + 1e-12)


def test_total_is_the_sum_of_its_lands_draw_by_draw(judge: Callable, twenty_lands: Controller) -> None:
    """With one error common to all, the total's interval is the sum of the lands' intervals."""
    case = judge(
        a_sheet(twenty_lands),
        controller=twenty_lands,
        instruments=two_instruments(common_part=1.0),
        assumptions=replace(DEFAULTS, contact_length=0.0, mounting_clearance=0.0, unseen_ovality=0.0),
    )
    total = case.unit.totals[0]
    for end in (0, 1):
        parts = math.fsum(land.leakage_interval[end] for land in case.unit.lands)
        assert total.leakage_interval[end] == pytest.approx(parts, rel=2e-3, abs=0.0)


def test_same_input_gives_the_same_digits(judge: Callable, four_speed: Controller) -> None:
    sheet = a_sheet(four_speed, repeats=2, noise=1 * UM, step=1 * UM)
    first, second = (judge(sheet, assumptions=DEFAULTS, draws=2000).unit for _ in range(2))
    assert first.totals == second.totals
    assert [land.conditions for land in first.lands] == [land.conditions for land in second.lands]
    other = judge(sheet, assumptions=DEFAULTS, draws=2000, seed=1).unit
    assert other.totals[0].leakage_interval != first.totals[0].leakage_interval
    assert other.lands[0].u_clearance == first.lands[0].u_clearance


def test_a_land_keeps_its_draws_when_another_one_changes(judge: Callable, four_speed: Controller) -> None:
    whole = judge(a_sheet(four_speed), assumptions=DEFAULTS, draws=2000).unit
    last = four_speed.lands[-1].key
    fewer = judge(a_sheet(four_speed, leave_out=(last,)), assumptions=DEFAULTS, draws=2000).unit
    changed = fewer.lands[-1]
    assert changed.u_clearance is None
    assert changed.decision is None
    assert changed.leakage_interval is None
    for before, after in zip(whole.lands[:3], fewer.lands[:3], strict=True):
        assert before.conditions == after.conditions


def test_draws_below_zero_leak_nothing(judge: Callable, twenty_lands: Controller) -> None:
    sheet = a_sheet(twenty_lands, clearance=1 * UM)
    rough = two_instruments(calibration=8 * UM)
    case = judge(sheet, controller=twenty_lands, profile=CUBE, instruments=rough, draws=200_000)
    land, gap = case.unit.lands[0], case.projections[0].gaps[0]
    assert land.clearance_interval[0] == 0.0
    assert land.leakage_interval[0] == 0.0
    _, variance = referees.truncated_cube_moments(gap.effective_clearance, land.u_clearance)
    exact = gap.leakage / gap.effective_clearance**3 * math.sqrt(variance)
    assert land.conditions[0].u_leakage == pytest.approx(exact, rel=0.02, abs=0.0)


def test_probability_and_decision_follow_the_reading(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    steps = Steps(((Verdict.REPLACE, 30 * UM),), LimitOrigin.WORKSHOP, "")
    only = replace(limits, wear=None, clearance=steps, pair_share=None)
    seen, new = [], new_at(four_speed, 24 * UM)
    for clearance in (27.0, 29.5, 30.5, 33.0):
        land = judge(a_sheet(new, clearance=clearance * UM), controller=new, limits=only).unit.lands[0]
        expected = equations.probability_over(clearance, 30.0, land.u_clearance / UM)
        assert land.probability_over_limit == pytest.approx(expected, abs=1e-6)
        seen.append(land.decision)
    assert seen == ["pass", "conditional_pass", "conditional_fail", "fail"]
    sheet = a_sheet(new, clearance=29.5 * UM)
    firm = judge(sheet, controller=new, limits=only, guard_factor=0.1).unit.lands[0]
    assert firm.decision == "pass"


def test_wear_is_judged_against_an_uncertain_mounting_clearance(judge: Callable, four_speed: Controller) -> None:
    given = replace(NOTHING_ELSE, mounting_clearance=1 * UM)
    land = judge(a_sheet(four_speed, clearance=30 * UM), assumptions=given).unit.lands[0]
    rule = next(decided for decided in land.rules if decided.rule.kind is RuleKind.WEAR)
    mounting = land.sources.state.land.mounting_clearance
    rng = np.random.default_rng(0)
    new = rng.normal(mounting, 1 * UM, 400_000)
    wear = rng.normal(30 * UM, land.u_clearance, 400_000) / new - 1.0
    for level in rule.levels:
        drawn = np.mean(wear > level.limit)
        error = 3.0 * math.sqrt(max(drawn * (1 - drawn), 1e-6) / 400_000)
        assert level.probability_over == pytest.approx(drawn, abs=error)


def test_bands_of_the_total_have_probabilities(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    share = judge(a_sheet(four_speed)).projections[0].share
    steps = Steps(((Band.AMBER, share), (Band.RED, 1.2 * share), (Band.CRITICAL, 9.0)), LimitOrigin.WORKSHOP, "")
    total = judge(a_sheet(four_speed), limits=replace(limits, total_share=steps), assumptions=DEFAULTS).unit.totals[0]
    bands = dict(total.band_probabilities)
    assert math.fsum(bands.values()) == pytest.approx(1.0, abs=1e-12)
    assert bands["green"] == pytest.approx(0.5, abs=0.05)
    assert bands["critical"] == 0.0
    assert total.decision.decision in {"conditional_pass", "conditional_fail"}
    assert total.minimum_speed_interval[0] < total.minimum_speed_interval[1]
    assert math.fsum(part for _, part in total.budget) == pytest.approx(1.0, rel=1e-9, abs=0.0)


def test_pump_that_delivers_nothing_is_over_every_limit(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    slow = replace(four_speed.operating_points[0], engine_speed=0.05)
    sheet = a_sheet(four_speed)
    states = clearances(sheet, four_speed)
    model = LeakageModel(four_speed, states, hipol, WORKSHOP)
    at = [project(model, slow)]
    unit = assess(
        model, states, at, unit_rules(states, at, project_unworn(states, model, at), limits), readings=sheet, draws=500
    )
    total = unit.totals[0]
    assert math.isinf(total.share)
    assert total.decision.decision == "fail"
    assert dict(total.band_probabilities)["critical"] == 1.0


def test_shape_shows_what_the_mean_hides(judge: Callable, four_speed: Controller) -> None:
    land = judge(a_sheet(four_speed, clearance=30 * UM, ovality=12 * UM)).unit.lands[0]
    shape = land.shape
    assert shape.worst_direction == 0.0
    assert shape.worst_clearance == pytest.approx(36 * UM, rel=1e-6, abs=0.0)
    mean = 0.5 * (30.0**3 + 36.0**3)
    assert shape.effective_clearance == pytest.approx(mean ** (1 / 3) * UM, rel=1e-6, abs=0.0)
    assert shape.cube_factor == pytest.approx(mean / 33.0**3, rel=1e-6, abs=0.0)
    assert not shape.lower_bound


def test_sleeve_in_one_direction_is_a_lower_bound_and_says_so(judge: Callable, four_speed: Controller) -> None:
    case = judge(a_sheet(four_speed, directions=(0.0,)), assumptions=DEFAULTS)
    assert all(land.shape.lower_bound for land in case.unit.lands)
    assert "clearance_lower_bound" in {message.code for message in case.unit.messages}
    kinds = dict(case.unit.lands[0].budget)
    assert kinds["sleeve: form"] > 0.1
    crossed = judge(a_sheet(four_speed), assumptions=DEFAULTS)
    assert not any(land.shape.lower_bound for land in crossed.unit.lands)


def test_messages_name_what_is_representative_and_missing(judge: Callable, four_speed: Controller) -> None:
    last = four_speed.lands[-1].key
    case = judge(a_sheet(four_speed, leave_out=(last,)), instruments=load_instruments(), assumptions=DEFAULTS)
    texts = {message.code: message.text for message in case.unit.messages}
    assert "uncertainty of its calibration" in texts["instrument_representative"]
    assert "_" not in texts["instrument_representative"]
    assert "No independent repeats" in texts["no_independent_repeats"]
    assert texts["total_with_unmeasured"].startswith("1 of ")


def test_nothing_measured_says_nothing(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    states = clearances(None, four_speed)
    model = LeakageModel(four_speed, states, hipol, WORKSHOP)
    projections = [project(model, point) for point in four_speed.operating_points]
    unit = assess(
        model,
        states,
        projections,
        unit_rules(states, projections, project_unworn(states, model, projections), limits),
        draws=500,
    )
    assert all(land.u_clearance is None and land.decision is None for land in unit.lands)
    assert len(unit.totals) == len(projections)


def test_the_sources_of_a_budget_add_up_to_the_whole(judge: Callable, four_speed: Controller) -> None:
    case = judge(a_sheet(four_speed, clearance=30 * UM), assumptions=DEFAULTS, draws=500)
    budget = budget_rows(next(land for land in case.unit.lands if land.conditions[0].share > 0.0), wording("en"))
    assert sum(each["of_clearance"] for each in budget) == pytest.approx(100.0, rel=1e-9, abs=0.0)
    assert sum(each["of_share"] for each in budget) == pytest.approx(100.0, rel=1e-9, abs=0.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [({"coverage": 95.0}, "coverage"), ({"guard_factor": -1.0}, "guard"), ({"draws": 10}, "draws")],
)
def test_settings_that_make_no_sense_are_refused(
    judge: Callable, four_speed: Controller, given: dict, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        judge(a_sheet(four_speed), **given)


def test_wider_coverage_gives_wider_intervals(judge: Callable, four_speed: Controller) -> None:
    sheet = a_sheet(four_speed)
    units = [judge(sheet, assumptions=DEFAULTS, coverage=p).unit for p in (0.68, 0.99)]
    narrow, wide = (next(land for land in unit.lands if land.conditions[0].share > 0.0) for unit in units)
    for name in ("clearance_interval", "leakage_interval", "share_interval"):
        (a, b), (c, d) = getattr(narrow, name), getattr(wide, name)
        assert c < a < b < d


def test_a_unit_of_sixty_lands_is_assessed(
    judge: Callable, four_speed: Controller, hipol: Fluid, limits: Limits
) -> None:
    more = [replace(land, component=f"{land.component} again") for land in four_speed.lands[:13]]
    gaps = [
        replace(gap, component=f"{gap.component} again")
        for gap in four_speed.gaps
        if f"{gap.component} again" in {land.component for land in more}
        and (f"{gap.component} again", gap.land) in {land.key for land in more}
    ]
    sixty = replace(four_speed, lands=(*four_speed.lands, *more), gaps=(*four_speed.gaps, *gaps))
    assert len(sixty.lands) == 60
    sheet = a_sheet(sixty, repeats=2, noise=1 * UM, step=1 * UM)
    states = clearances(sheet, sixty)
    model = LeakageModel(sixty, states, hipol, WORKSHOP)
    projections = [project(model, point) for point in sixty.operating_points]
    unit = assess(
        model,
        states,
        projections,
        unit_rules(states, projections, project_unworn(states, model, projections), limits),
        readings=sheet,
        draws=8_192,
    )
    assert unit.draws == 8_192
    assert len(unit.lands) == 60
    assert all(land.u_clearance for land in unit.lands)
