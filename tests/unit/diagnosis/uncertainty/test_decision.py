"""A value near its limit: which decisions, how likely, and what would settle it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps
from atleak.common.errors import InputError
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import NOTHING_ELSE, Assumptions, decide
from atleak.diagnosis.uncertainty.decision import decide_rule
from atleak.equations import DomainError
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, new_at, two_instruments

UM = 1e-6


@pytest.mark.parametrize(
    ("value", "decision"),
    [
        (30.0 - 1.645, "pass"),
        (30.0 - 1.644, "conditional_pass"),
        (29.999, "conditional_pass"),
        (30.0, "conditional_fail"),  # at the limit is past it, as for the verdict
        (30.0 + 1.645, "conditional_fail"),
        (30.0 + 1.646, "fail"),
    ],
)
def test_guard_band_of_one_standard_uncertainty(value: float, decision: str) -> None:
    assert decide(value, 30.0, 1.0) == decision


@pytest.mark.parametrize("mounting", [20.0, 25.0, 30.0, 35.0, 40.0])
def test_a_value_at_its_limit_but_for_rounding_is_on_the_verdict_s_side(mounting: float) -> None:
    clearance = mounting * 1.1
    wear = (clearance - mounting) / mounting
    assert Steps(((Verdict.WATCH, 0.1),), LimitOrigin.PUBLISHED, "").judge(wear, Verdict.OK)[0] == "watch"
    assert decide(wear, 0.1, 0.01) == "conditional_fail"


def test_guard_band_can_be_set_and_be_none() -> None:
    assert decide(29.0, 30.0, 1.0, guard_factor=0.9) == "pass"
    assert decide(29.0, 30.0, 1.0, guard_factor=2.0) == "conditional_pass"
    assert decide(29.9999, 30.0, 0.0) == "pass"
    assert decide(30.0001, 30.0, 0.0) == "fail"
    with pytest.raises(DomainError):
        decide(29.0, 30.0, -1.0)


def test_a_skewed_distribution_does_not_pass_on_its_standard_uncertainty_alone() -> None:
    assert decide(28.0, 30.0, 1.0, probability_over=0.049) == "pass"
    assert decide(28.0, 30.0, 1.0, probability_over=0.06) == "conditional_pass"
    assert decide(33.0, 30.0, 1.0, probability_over=0.9) == "conditional_fail"


@pytest.mark.parametrize(
    ("interval", "skewed"),
    [((60.0, 140.0), False), ((90.0, 130.0), True), ((50.0, 110.0), True), ((100.0, 100.0), False), (None, False)],
)
def test_a_distribution_is_skewed_where_one_end_is_much_farther_than_the_other(interval, skewed: bool) -> None:
    steps = Steps((("watch", 55.0),), LimitOrigin.PROJECT, "test")
    rule = Rule(RuleKind.CLEARANCE, None, 100.0, steps)
    assert decide_rule(rule, (10.0,), (1.0,), 1.0, skewed=True, interval=interval).skewed == skewed


def test_without_a_finite_uncertainty_only_the_draws_decide() -> None:
    infinite = float("inf")
    assert decide(infinite, 0.1, infinite, probability_over=1.0) == "fail"
    assert decide(0.05, 0.1, infinite, probability_over=0.0) == "pass"
    assert decide(0.05, 0.1, infinite) == "conditional_pass"


def test_a_rule_is_about_the_limit_it_reached() -> None:
    steps = Steps(((Verdict.WATCH, 10.0), (Verdict.REPLACE, 50.0)), LimitOrigin.PUBLISHED, "")
    decided = decide_rule(Rule(RuleKind.WEAR, None, 49.0, steps), (2.0, 3.0), (1.0, 0.37), 1.645, skewed=False)
    assert (decided.rule.verdict, decided.about, decided.limit, decided.decision) == ("watch", "watch", 10.0, "fail")
    above = decided.at_next_level
    assert above is not None
    assert (above.about, above.decision, above.probability_over_limit) == ("replace", "conditional_pass", 0.37)
    assert above.standard_uncertainty == 3.0
    assert above.at_next_level is None
    low = decide_rule(Rule(RuleKind.WEAR, None, 3.0, steps), (2.0, 3.0), (0.0, 0.0), 1.645, skewed=False)
    assert (low.rule.verdict, low.about, low.decision) == ("ok", "watch", "pass")


def test_of_two_levels_that_begin_together_the_worse_one_is_named() -> None:
    steps = Steps(((Verdict.WATCH, 0.625), (Verdict.REPLACE, 0.625)), LimitOrigin.PROJECT, "")
    decided = decide_rule(Rule(RuleKind.WEAR, None, 0.64, steps), (0.1, 0.2), (0.6, 0.55), 1.645, skewed=False)
    assert (decided.rule.verdict, decided.about, decided.standard_uncertainty) == ("replace", "replace", 0.2)
    assert decided.at_next_level is None


def test_a_fixed_limit_under_those_of_growth_is_the_first_to_be_reached() -> None:
    steps = Steps(((Band.AMBER, 0.525), (Band.RED, 0.63), (Band.CRITICAL, 0.5)), LimitOrigin.PROJECT, "")
    below = decide_rule(Rule(RuleKind.TOTAL_SHARE, None, 0.49, steps), (0.03,) * 3, (0.1, 0.0, 0.4), 1.645, skewed=True)
    assert (below.rule.level, below.about, below.limit) == ("green", "critical", 0.5)
    assert (below.decision, below.probability_over_limit) == ("conditional_pass", 0.4)
    assert below.at_first_level == below
    past = decide_rule(Rule(RuleKind.TOTAL_SHARE, None, 0.51, steps), (0.03,) * 3, (0.3, 0.0, 0.6), 1.645, skewed=True)
    assert (past.rule.level, past.at_next_level) == ("critical", None)


def test_of_a_reserve_the_highest_limit_is_the_first_to_be_reached() -> None:
    steps = Steps(((Band.AMBER, 1.5), (Band.RED, 1.2), (Band.CRITICAL, 1.0)), LimitOrigin.PROJECT, "", fall=0.0)
    low = decide_rule(Rule(RuleKind.RESERVE, None, 1.1, steps), (0.1,) * 3, (1.0, 0.8, 0.2), 1.645, skewed=False)
    first, last = low.at_first_level, low.at_next_level
    assert (first.about, first.limit, first.decision) == ("amber", 1.5, "fail")
    assert (low.about, low.limit, low.decision) == ("red", 1.2, "conditional_fail")
    assert last is not None
    assert (last.about, last.limit, last.decision) == ("critical", 1.0, "conditional_pass")


def _limits(limits: Limits, clearance: float) -> Limits:
    steps = Steps(((Verdict.REPLACE, clearance),), LimitOrigin.WORKSHOP, "")
    return replace(limits, wear=None, clearance=steps, pair_share=None)


def test_over_the_limit_but_within_what_the_instruments_can_tell(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    sleeve_worse = two_instruments(calibration=1.0 * UM)
    sleeve_worse = replace(sleeve_worse, sleeve=replace(sleeve_worse.sleeve, calibration=1.53 * UM))
    sheet = a_sheet(four_speed, clearance=31 * UM)
    case = judge(
        sheet, controller=new_at(four_speed, 24 * UM), instruments=sleeve_worse, limits=_limits(limits, 30 * UM)
    )
    land = case.unit.lands[0]
    rule = land.deciding
    assert rule.decision == "conditional_fail"
    assert rule.limit == 30 * UM
    assert land.probability_over_limit == pytest.approx(0.863, abs=0.001)  # Φ(1/0.914)
    assert land.advice is not None
    assert land.advice.startswith("radial clearance 31.0 µm is over the replace limit of 30.0 µm, but within what ")
    assert "measure again, D first, it carries 70 % of the uncertainty" in land.advice
    remedy = land.remedy(rule)
    assert remedy.first == "sleeve"
    assert remedy.fraction == pytest.approx(0.7, abs=0.01)
    assert remedy.repeats is None  # it is calibration, not repeatability
    assert (("sleeve", "air gauge"),) in remedy.instruments


def test_no_gauge_is_advised_where_it_is_open_what_the_pair_was_when_new(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    growth = {Verdict.WATCH: (0.25, 0.0)}
    steps = Steps(((Verdict.WATCH, 1e-6),), LimitOrigin.PROJECT, "", growth=growth)
    of_growth = replace(limits, wear=None, clearance=None, pair_share=steps)
    unit = new_at(four_speed, 13 * UM)
    open_new = replace(NOTHING_ELSE, mounting_clearance=3 * UM)
    exact = two_instruments(calibration=0.01 * UM)
    sheet = a_sheet(unit, clearance=13 * UM)
    case = judge(sheet, controller=unit, instruments=exact, limits=of_growth, assumptions=open_new)
    land = next(land for land in case.unit.lands if land.deciding and land.deciding.value > 0.0)
    # cold, 13 µm leaks 1.25 times what 12.07 µm leak, under which it was when new with 38 %; warm it is a little less
    assert land.probability_over_limit == pytest.approx(0.34, abs=0.02)
    remedy = land.remedy(land.deciding)
    assert (land.deciding.decision, remedy.repeats, remedy.instruments) == ("conditional_pass", None, ())
    assert remedy.reading_part < 0.01
    assert "what the pair was when new" in land.advice
    assert "Measuring again will not settle it" in land.advice


def test_repeats_settle_what_repeats_can_settle(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    noisy = two_instruments(calibration=0.2 * UM, repeatability=1.5 * UM)
    sheet = a_sheet(four_speed, clearance=29 * UM)
    case = judge(sheet, controller=new_at(four_speed, 24 * UM), instruments=noisy, limits=_limits(limits, 30 * UM))
    land = case.unit.lands[0]
    rule = land.deciding
    assert rule.decision == "conditional_pass"
    remedy = land.remedy(rule)
    assert remedy.repeats is not None
    assert f"{remedy.repeats} independent repeats" in land.advice
    # with so many it is settled, with one fewer it is not
    for repeats, settled in ((remedy.repeats, True), (remedy.repeats - 1, False)):
        count = dict.fromkeys(remedy.repeat_parts, repeats)
        u = land.sources.variance_with(repeats=count) ** 0.5
        assert (decide(rule.value, rule.limit, u) == "pass") is settled


def test_measuring_again_does_not_help_where_the_fluid_is_the_trouble(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    case = judge(
        a_sheet(four_speed),
        instruments=load_instruments("air_gauge", "air_gauge"),
        assumptions=Assumptions(viscosity=0.4),
        limits=replace(limits, wear=None),
    )
    land = max(case.unit.lands, key=lambda land: land.conditions[0].share)
    share = land.conditions[0].share
    near = replace(limits, wear=None, pair_share=Steps(((Verdict.WATCH, 1.02 * share),), LimitOrigin.WORKSHOP, ""))
    again = judge(
        a_sheet(four_speed),
        instruments=load_instruments("air_gauge", "air_gauge"),
        assumptions=Assumptions(viscosity=0.4),
        limits=near,
    ).unit.land(land.key)
    assert again.rules[0].decision == "conditional_pass"
    assert "Measuring again will not settle it" in again.advice_on(again.rules[0])


def test_a_settled_land_says_nothing(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    new = new_at(four_speed, 20 * UM)
    case = judge(a_sheet(new), controller=new, limits=_limits(limits, 30 * UM))
    for land in case.unit.lands:
        assert land.decision == "pass"
        assert land.advice is None
        assert land.remedy(land.deciding) is None


def test_a_verdict_that_may_be_worse_says_so(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    steps = Steps(((Verdict.WATCH, 20 * UM), (Verdict.REPLACE, 32 * UM)), LimitOrigin.WORKSHOP, "")
    near = replace(limits, wear=None, clearance=steps, pair_share=None)
    sheet = a_sheet(four_speed, clearance=31 * UM)
    land = judge(sheet, controller=new_at(four_speed, 24 * UM), limits=near).unit.lands[0]
    assert land.decision == "fail"  # over the limit to watch, without doubt
    assert "under the replace limit of 32.0 µm" in land.advice


def test_a_pair_tighter_than_new_is_suspect_and_never_a_plain_pass(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    new = new_at(four_speed, 24 * UM)
    only = _limits(limits, 40 * UM)
    u = judge(a_sheet(new), controller=new, limits=only).unit.lands[0].u_clearance
    for under, suspect in ((2.9 * u, False), (3.1 * u, True), (12 * UM, True)):
        land = judge(a_sheet(new, clearance=24 * UM - under), controller=new, limits=only).unit.lands[0]
        assert land.deciding.decision == "pass"
        assert (land.suspect, land.decision) == (suspect, "conditional_pass" if suspect else "pass")
        assert ("tighter than when new" in (land.advice or "")) is suspect


def test_what_is_known_of_the_mounting_clearance_decides_who_is_suspect(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    sheet, only = a_sheet(four_speed, clearance=12 * UM), _limits(limits, 40 * UM)
    by_value = new_at(four_speed, 24 * UM)
    by_type = replace(by_value, lands=tuple(replace(land, mounting_tolerance=8 * UM) for land in by_value.lands))
    by_range = new_at(four_speed, (6.4 * UM, 24 * UM))
    for controller, suspect in ((by_value, True), (by_type, False), (by_range, False)):
        lands = judge(sheet, controller=controller, limits=only).unit.lands
        assert {land.suspect for land in lands} == {suspect}
    tight = a_sheet(four_speed, clearance=1 * UM)
    assert all(land.suspect for land in judge(tight, controller=by_range, limits=only).unit.lands)


def test_half_a_pair_is_not_suspect(judge: Callable, four_speed: Controller, limits: Limits) -> None:
    sheet = a_sheet(four_speed, clearance=10 * UM)
    sleeves = replace(sheet, readings=tuple(each for each in sheet.readings if each.part == "sleeve"))
    assert not any(land.suspect for land in judge(sleeves, limits=_limits(limits, 40 * UM)).unit.lands)


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ({"viscosity_percent": -1}, "0 or more"),
        ({"viscosity": 3}, "viscosity_percent"),
        ({"temperature_k": "x"}, "0 or"),
        ({"one_sided_wear_percent": 300}, "a number from 0 to 100"),
    ],
)
def test_assumptions_refuse_what_they_do_not_know(setting: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Assumptions().with_settings(setting)


def test_a_pair_exactly_at_its_limit_passes_in_five_cases_of_a_hundred() -> None:
    readings = np.random.default_rng(4).normal(30.0, 1.0, 20_000)
    passed = np.mean([decide(float(value), 30.0, 1.0) == "pass" for value in readings])
    assert passed == pytest.approx(0.05, abs=3.0 * (0.05 * 0.95 / 20_000) ** 0.5)


def test_a_limit_finer_than_the_gauge_is_not_measurable_with_it(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    """A tenth of 13 µm is 1.3 µm, about one standard uncertainty of micrometer and bore gauge."""
    unit = replace(four_speed, lands=tuple(replace(land, mounting_clearance=13 * UM) for land in four_speed.lands))
    fine = Steps(((Verdict.WATCH, 0.1), (Verdict.REPLACE, 0.5)), LimitOrigin.PROJECT, "")
    sheet = a_sheet(unit, repeats=2, noise=0.5 * UM, step=1 * UM)
    workshop = {
        "controller": unit,
        "instruments": load_instruments("micrometer", "bore_gauge"),
        "assumptions": Assumptions(),
    }
    land = judge(sheet, limits=replace(limits, wear=fine, pair_share=None), **workshop)
    decided = land.unit.lands[0]
    rule = decided.rules[0].at_first_level
    assert rule.conditional
    assert not decided.measurable(rule)
    assert decided.advice is not None
    assert "is not measurable with this outside micrometer and this two-point bore gauge" in decided.advice
    texts = {message.code: message.text for message in land.unit.messages}
    assert texts["limit_finer_than_gauge"].startswith("Not measurable with this gauge")
    assert "air gauge" in texts["limit_finer_than_gauge"]
    # with a least wear of 4 µm the same gauges do
    default = judge(sheet, limits=replace(limits, pair_share=None), **workshop).unit
    assert all(each.measurable(each.rules[0]) for each in default.lands)
    assert "limit_finer_than_gauge" not in {message.code for message in default.messages}


def test_more_directions_are_advised_where_form_carries_the_uncertainty(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    exact = two_instruments(calibration=0.1 * UM, repeatability=0.1 * UM)
    sheet = a_sheet(four_speed, clearance=29 * UM, ovality=30 * UM)
    case = judge(
        sheet,
        instruments=exact,
        assumptions=replace(Assumptions(), contact_length=0.0),
        limits=_limits(limits, 38.5 * UM),
    )
    land = case.unit.lands[0]
    rule = land.deciding
    assert rule is not None
    assert rule.decision == "conditional_pass"
    remedy = land.remedy(rule)
    assert remedy is not None
    assert remedy.form > 0.9
    assert remedy.directions == ("sleeve",)
    assert land.advice is not None
    assert "D in four directions (0, 45, 90 and 135°)" in land.advice


def test_a_value_that_no_measurement_can_decide_is_not_asked_to_be_measured_again(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    sheet = a_sheet(four_speed, clearance=30.01 * UM)
    land = judge(sheet, controller=new_at(four_speed, 24 * UM), limits=_limits(limits, 30 * UM)).unit.lands[0]
    assert land.decision == "conditional_fail"
    assert not land.remedy(land.deciding).decides
    assert "decide by judgement" in land.advice
    assert "measure again" not in land.advice
