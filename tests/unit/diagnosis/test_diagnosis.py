"""From readings to verdicts: which rule, which land first, and what its repair brings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, FluidState, load_fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import DomainError
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, PROFILES, Profile
from atleak.engine.projection import project, repaired, stated_condition
from atleak.measurements.readings import Readings, SheetIdentity
from atleak.report.json.diagnosis import diagnosis_record
from tests.unit.conftest import at_wear, codes

Edited = Callable[..., Path]
Build = Callable[..., Readings]
REGULATOR, SECOND, TCC, PISTON = (
    ("pressure_regulator", 1),
    ("pressure_regulator", 2),
    ("tcc_regulator", 1),
    ("accumulator", 1),
)


# --- the road test's extremes


def test_without_readings_no_extreme_has_an_interval(sample: Diagnosis) -> None:
    bare = diagnose(sample.controller, sample.fluid, sample.limits, road_test=sample.road.road_test)
    record = diagnosis_record(bare)["road_test"]["max_leakage_sustained"]
    assert record["leakage_dm3_min"] > 0.0
    names = ("leakage_low_dm3_min", "leakage_high_dm3_min", "share_low_percent", "share_high_percent")
    assert [record[name] for name in names] == [None] * 4


def test_without_engine_speed_an_extreme_has_an_interval_of_its_leakage_alone(sample: Diagnosis) -> None:
    test = sample.road.road_test
    channels = {name: channel for name, channel in test.channels.items() if name != "engine_speed"}
    log = replace(test, channels=channels, _held={})
    diagnosis = diagnose(
        sample.controller, sample.fluid, sample.limits, readings=sample.readings, road_test=log, profile=sample.profile
    )
    uncertainty = diagnosis.uncertainty.instants[diagnosis.road.max_leakage]
    assert uncertainty.share_interval is None
    known = sample.uncertainty.instants[sample.road.max_leakage]
    assert uncertainty.leakage_interval == pytest.approx(known.leakage_interval, rel=1e-12, abs=0.0)


# --- the state of the fluid


def test_the_width_of_an_estimated_used_viscosity_is_part_of_every_interval(sample: Diagnosis) -> None:
    def of(fluid: Fluid, state: FluidState) -> Diagnosis:
        even = replace(DEFAULTS, one_sided_wear=0.0)
        known = {"readings": sample.readings, "profile": sample.profile, "assumptions": even}
        return diagnose(sample.controller, fluid, sample.limits, fluid_state=state, **known)

    used = of(load_fluid("mobil_atf_220"), "used")
    known = of(replace(used.fluid, viscosity_range=(1.0, 1.0)), "used")
    for wide, narrow in zip(used.uncertainty.totals, known.uncertainty.totals, strict=True):
        assert wide.leakage == narrow.leakage
        assert wide.u_leakage > narrow.u_leakage
        parts = dict(wide.budget)
        ratio = parts["range of the fluid's viscosity"] / parts["viscosity"]
        rectangle = (0.80 - 0.75) / (0.80 + 0.75) / math.sqrt(3.0)
        assert ratio == pytest.approx((rectangle / used.uncertainty.assumptions.viscosity) ** 2, rel=0.02, abs=0.0)
        assert "range of the fluid's viscosity" not in dict(narrow.budget)


# --- verdicts


def test_wear_of_exactly_a_tenth_through_floating_point_is_watch(
    edited: Edited, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        (
            "nominal_diameter_mm = 11.0, mounting_clearance_um = 16.0",
            "nominal_diameter_mm = 12, mounting_clearance_um = 40",
        ),
    )
    controller = load_controller(path)
    diagnosis = diagnose(controller, hipol, limits, readings=readings_of(controller, {TCC: (12.000e-3, 12.088e-3)}))
    land = next(land for land in diagnosis.lands if land.key == TCC)
    assert land.wear == pytest.approx(0.10, rel=1e-9, abs=0.0)
    assert land.rules[0].verdict == "watch"
    assert land.verdict in {"watch", "replace", "critical"}


@pytest.mark.parametrize(
    ("wear", "verdict"),
    # of 14 µm: under 4 µm no workshop gauge tells wear from new
    [(0.1001, "ok"), (0.2856, "ok"), (0.2858, "watch"), (0.4999, "watch"), (0.5001, "replace")],
)
def test_verdicts_of_wear_begin_where_a_gauge_can_tell(
    wear: float, verdict: str, minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    assert minimal.land("solenoid_modulator", 1).mounting_clearance == pytest.approx(14e-6, rel=1e-9, abs=0.0)
    readings = readings_of(minimal, at_wear(minimal, solenoid_modulator=wear))
    diagnosis = diagnose(minimal, hipol, replace(limits, pair_share=None), readings=readings)
    assert [land.verdict for land in diagnosis.lands if land.state.measured] == [verdict]
    assert diagnosis.verdict == verdict
    assert diagnosis.measured == 1


def test_the_worst_rule_gives_the_verdict_and_is_named(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(minimal, at_wear(minimal, pressure_regulator=0.3))
    assert limits.pair_share is not None
    strict = replace(limits, pair_share=replace(limits.pair_share, levels=((Verdict.CRITICAL, 1e-6),), growth={}))
    land = diagnose(minimal, hipol, strict, readings=readings).lands[0]
    assert [rule.id for rule in land.rules] == [
        "wear_percent",
        "share_driving_second_percent",
        "share_hot_idle_percent",
    ]
    assert [rule.verdict for rule in land.rules] == ["watch", "critical", "critical"]
    assert land.verdict == "critical"
    assert land.deciding is land.rules[1]
    assert land.deciding.origin == "choice of this project"
    assert land.deciding.limit == 1e-6
    relaxed = diagnose(minimal, hipol, replace(limits, pair_share=None), readings=readings).lands[0]
    assert relaxed.deciding is not None
    assert (relaxed.verdict, relaxed.deciding.kind, relaxed.deciding.origin) == (
        "watch",
        "wear",
        limits.wear.origin if limits.wear else None,
    )


def test_a_clearance_limit_of_the_workshop_s_own_limits(
    edited: Edited, minimal: Controller, hipol: Fluid, readings_of: Build
) -> None:
    path = edited(
        "limits",
        "project_default",
        (
            "# What all pairs",
            '[clearance_um]\nwatch = 15.0\ncritical = 17.6\norigin = "set by the workshop"\nsource = "own"\n# What all',
        ),
    )
    readings = readings_of(minimal, at_wear(minimal, tcc_regulator=0.05, solenoid_modulator=0.0, accumulator=0.0))
    diagnosis = diagnose(minimal, hipol, replace(load_limits(path), pair_share=None), readings=readings)
    verdicts = {land.key[0]: land.verdict for land in diagnosis.lands if land.state.measured}
    assert verdicts == {"tcc_regulator": "watch", "solenoid_modulator": "ok", "accumulator": "critical"}
    deciding = next(land.deciding for land in diagnosis.lands if land.key == PISTON)
    assert deciding is not None
    assert (deciding.kind, deciding.kind.unit, deciding.origin) == ("radial_clearance", "µm", "set by the workshop")
    assert deciding.value == pytest.approx(20e-6, rel=1e-9, abs=0.0)


def test_a_clearance_limit_of_one_land_goes_before_that_of_all(
    edited: Edited, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        ("mounting_clearance_um = 16.0", "mounting_clearance_um = 16.0, clearance_limit_um = 16.5"),
    )
    controller = load_controller(path)
    assert limits.wear is not None
    everywhere = replace(limits.wear, levels=(("critical", 5e-6),), origin="set by the workshop")
    readings = readings_of(controller, at_wear(controller, tcc_regulator=0.05))
    diagnosis = diagnose(controller, hipol, replace(limits, clearance=everywhere, pair_share=None), readings=readings)
    land = next(land for land in diagnosis.lands if land.key == TCC)
    assert land.deciding is not None
    assert (land.verdict, land.deciding.kind) == ("replace", "radial_clearance")
    assert land.deciding.limit == pytest.approx(16.5e-6, rel=1e-12, abs=0.0)
    assert land.deciding.source == "the valve body's file"
    assert land.uncertainty is not None
    decided = land.uncertainty.on(land.deciding)
    assert decided is not None
    assert decided.probability_over_limit > 0.5  # 16.8 µm against 16.5


def test_lands_that_were_not_measured_are_at_mounting_clearance_and_get_no_verdict(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, at_wear(minimal, accumulator=0.3)))
    for land in diagnosis.lands:
        if land.key == PISTON:
            assert land.verdict != "not_measured"
            continue
        assert (land.verdict, land.wear, land.rules, land.deciding) == ("not_measured", None, (), None)
        assert land.state.radial_clearance == land.state.land.mounting_clearance
        assert land.leakage > 0.0
        assert land.excess_share == pytest.approx(0.0, abs=1e-15)
    assert all(land.verdict != "not_measured" for land in diagnosis.flagged)


def test_half_a_measurement_is_judged_and_flagged(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    nominal = minimal.land(*TCC).nominal_diameter
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, {TCC: (nominal - 20e-6, None)}))
    land = next(land for land in diagnosis.lands if land.key == TCC)
    assert land.state.status == "spool_only"
    assert land.wear == pytest.approx(10.0 / 16.0, rel=1e-6, abs=0.0)
    assert land.verdict in {"replace", "critical"}
    assert "sleeve_missing" in codes(diagnosis)


def test_without_readings_nothing_is_judged(minimal: Controller, hipol: Fluid, limits: Limits) -> None:
    diagnosis = diagnose(minimal, hipol, limits)
    assert diagnosis.verdict == "not_measured"
    assert diagnosis.measured == 0
    assert diagnosis.flagged == plan_repairs(diagnosis).steps == ()
    assert diagnosis.uncertainty is None
    assert diagnosis.projection.leakage > 0.0
    assert "no_readings" in codes(diagnosis)


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_no_land_of_the_study_s_controller_is_flagged_when_new(
    four_speed: Controller, hipol: Fluid, limits: Limits, profile: Profile
) -> None:
    # as the limits of one pair's share say of themselves
    assert limits.pair_share is not None
    diagnosis = diagnose(four_speed, hipol, limits, profile=profile)
    for projection in diagnosis.projections:
        for land in diagnosis.lands:
            assert limits.pair_share.judge(projection.share_drawn_by(land.key), "ok")[0] == "ok"


# --- order


def test_flagged_lands_come_worst_first_then_costliest(sample: Diagnosis) -> None:
    flagged = sample.flagged
    assert {land.verdict for land in flagged} == {"watch", "replace"}
    order = [(-land.verdict.rank, -land.excess_share) for land in flagged]
    assert order == sorted(order)
    assert sample.verdict == flagged[0].verdict == "replace"


def test_ranked_lands_are_all_lands_by_leakage(sample: Diagnosis) -> None:
    flows = [land.leakage for land in sample.ranked]
    assert flows == sorted(flows, reverse=True)
    assert {land.key for land in sample.ranked} == {land.key for land in sample.lands}


def test_excess_is_the_share_above_new_where_it_costs_most(sample: Diagnosis) -> None:
    states = [land.state for land in sample.lands]
    everything_new = repaired(states, [state.land.key for state in states])
    new = LeakageModel(sample.controller, everything_new, sample.fluid, sample.profile)
    for land in sample.lands:
        by_hand = [
            (now.drawn_by(land.key) - project(new, now.condition).drawn_by(land.key)) / now.pump_capacity
            for now in sample.projections
        ]
        assert land.excess_share == pytest.approx(max(by_hand), rel=1e-12, abs=1e-15)


def test_a_leak_into_another_section_costs_the_pump_nothing_twice(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    # land 5/1 leaks from p_g into p_m alone, land 8/2 from p_g into the sump: equally worn, 8/2 is repaired first
    worn = {}
    for key in (("5", 1), ("8", 2)):
        land = four_speed.land(*key)
        worn[key] = (land.nominal_diameter, land.nominal_diameter + 2.0 * 1.6 * land.mounting_clearance)
    readings = readings_of(four_speed, worn)
    workshop = diagnose(four_speed, hipol, limits, readings=readings)
    assert [land.key for land in workshop.flagged] == [("8", 2), ("5", 1)]
    assert workshop.flagged[1].excess_share == 0.0
    paper = diagnose(four_speed, hipol, limits, readings=readings, profile=PAPER)
    assert all(land.excess_share > 0.0 for land in paper.flagged)


def test_without_hot_idle_the_stated_condition_alone_is_reported(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    only = replace(minimal, operating_points=minimal.operating_points[:1])
    diagnosis = diagnose(only, hipol, limits, readings=readings_of(only, at_wear(only, accumulator=0.7)))
    assert diagnosis.hot_idle is None
    assert diagnosis.reported == (diagnosis.projection,)
    assert {step.at.condition.name for step in plan_repairs(diagnosis).steps} == {"driving_second"}
    assert "no_hot_idle" in codes(diagnosis)


# --- conditions


def test_a_stated_condition_is_judged_beside_the_controller_s_own(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    condition = stated_condition(four_speed, temperature=60.0, gear=3)
    readings = readings_of(four_speed, {("25", 1): (16e-3, 16.12e-3)})
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings, condition=condition)
    land = diagnosis.flagged[0]
    names = [rule.condition.name if rule.condition else rule.kind for rule in land.rules]
    assert names == ["wear", "stated", "driving_second", "hot_idle"]
    assert diagnosis.projection.condition is condition
    assert diagnosis.hot_idle is not None
    assert diagnosis.hot_idle.condition.name == "hot_idle"


def test_hot_idle_may_be_the_stated_condition(
    four_speed: Controller, hot_idle: OperatingPoint, hipol: Fluid, limits: Limits
) -> None:
    diagnosis = diagnose(four_speed, hipol, limits, condition=hot_idle)
    assert diagnosis.projection is diagnosis.hot_idle


def test_a_pump_that_delivers_nothing_is_said_and_no_land_suffers(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    condition = stated_condition(four_speed, engine_speed=1.0 / 60.0)
    diameters = {key: (four_speed.land(*key).nominal_diameter,) * 2 for key in [("6", 1), ("26", 1)]}
    new = {
        key: (spool, sleeve + 2.0 * four_speed.land(*key).mounting_clearance)
        for key, (spool, sleeve) in diameters.items()
    }
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, new), condition=condition)
    verdicts = {land.key: land.verdict for land in diagnosis.lands if land.state.measured}
    assert verdicts == {("6", 1): "ok", ("26", 1): "ok"}  # no new unit could hold its pressure there: not up to a land
    assert "pump_delivers_nothing" in codes(diagnosis)
    assert all(math.isfinite(land.excess_share) for land in diagnosis.lands)


def test_temperature_outside_the_fluid_is_refused(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    with pytest.raises(DomainError, match=r"500 °C"):
        diagnose(four_speed, hipol, limits, condition=stated_condition(four_speed, temperature=500.0))
    condition = stated_condition(four_speed, temperature=120.0)
    with pytest.raises(DomainError, match=r"\(tabulated\)"):
        diagnose(four_speed, hipol, limits, profile=PAPER, condition=condition)


# --- what is said of a whole result


def test_the_interval_of_wear_holds_what_is_known_of_the_mounting_clearance(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(minimal, at_wear(minimal, pressure_regulator=0.3))

    def interval(**assumed: float) -> tuple[float, float]:
        diagnosis = diagnose(
            minimal, hipol, limits, readings=readings, assumptions=DEFAULTS.with_settings(assumed), mileage_km=100_000.0
        )
        return next(land for land in diagnosis.lands if land.key == REGULATOR).uncertainty.wear_interval

    sure, unsure = interval(mounting_clearance_um=0.0), interval(mounting_clearance_um=3.0)
    land = minimal.land(*REGULATOR)
    added = 1.959964 * 1.3 * 3e-6 / land.mounting_high
    half_sure, half_unsure = (0.5 * (high - low) for low, high in (sure, unsure))
    assert half_unsure == pytest.approx(math.hypot(half_sure, added), rel=1e-6, abs=0.0)
    assert sum(sure) / 2.0 == pytest.approx(0.3, rel=1e-6, abs=0.0)


def test_hot_idle_as_the_stated_condition_is_one_projection(
    four_speed: Controller, hipol: Fluid, limits: Limits
) -> None:
    idle = four_speed.operating_points[1]
    diagnosis = diagnose(four_speed, hipol, limits, condition=idle)
    assert diagnosis.reported == (diagnosis.projection,)
    assert diagnosis.hot_idle is diagnosis.projection


def test_messages_are_not_repeated(sample: Diagnosis) -> None:
    assert len(set(sample.messages)) == len(sample.messages)
    assert {"mirrored_repeats", "fluid_note"} <= codes(sample)


def test_lands_that_no_gap_names_leak_as_much_as_they_can_and_are_said(
    root: Path, tmp_path: Path, hipol: Fluid, limits: Limits
) -> None:
    """Else a description that is begun with some gaps makes a worn unit green."""
    text = (root / "atleak" / "catalogue" / "controllers" / "minimal_example.toml").read_text(encoding="utf-8")
    path = tmp_path / "begun.toml"
    gap = '[[gaps]]\ncomponent = "accumulator"\nland = 1\nfrom = "p_g"\nto = "drain"\ngears = [1]\n'
    path.write_text(f"{text}\n{gap}", encoding="utf-8")
    none, some = (diagnose(load_controller(each), hipol, limits) for each in ("minimal_example", path))
    assert none.upper_bound
    assert some.upper_bound
    said = {message.code: message.text for message in some.messages}["land_without_gap"]
    assert "tcc_regulator/1" in said
    assert "accumulator/1" not in said
    assert "land_without_gap" not in codes(none)
    for one, other in zip(none.lands, some.lands, strict=True):
        assert other.leakage == one.leakage or one.key == ("accumulator", 1)
    every = {land.key for land in none.controller.lands}
    assert some.controller.gaps_not_described == every - {("accumulator", 1)}


def test_where_every_land_has_its_gap_nothing_is_an_upper_bound(sample: Diagnosis) -> None:
    assert not sample.upper_bound
    assert not sample.controller.gaps_not_described
    assert "land_without_gap" not in codes(sample)


# --- half a pair


@pytest.mark.parametrize(("part", "status"), [("spool", "spool_only"), ("sleeve", "sleeve_only")])
def test_of_half_a_pair_ok_is_not_claimed(
    sample: Diagnosis, hipol: Fluid, limits: Limits, part: str, status: str
) -> None:
    """With one part at its nominal diameter nothing is known of the other one's wear."""
    readings = sample.readings
    assert readings is not None
    kept = tuple(
        reading for reading in readings.readings if reading.component not in {"5", "25"} or reading.part == part
    )
    diagnosis = diagnose(sample.controller, hipol, limits, readings=replace(readings, readings=kept))
    half = {land.key: land for land in diagnosis.lands if land.state.status == status}
    assert half[("5", 1)].verdict == "not_measured"
    assert half[("5", 1)].decision is None
    assert half[("5", 1)].rules
    assert diagnosis.measured == len(diagnosis.lands) - len(half)
    if part == "sleeve":  # the worn bore of land 25/1 crosses its limit whatever its spool
        assert half[("25", 1)].verdict == "replace"


@pytest.mark.parametrize(("growth", "verdict"), [(1.10, "watch"), (1.3, "replace"), (2.0, "critical")])
def test_the_worst_of_lands_and_totals_is_the_verdict_of_the_unit(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build, growth: float, verdict: str
) -> None:
    """At +10 % no land reaches a limit of its own, yet at hot idle all together draw a quarter more than new."""
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * growth * land.mounting_clearance)
        for land in four_speed.lands
    }
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, diameters))
    assert diagnosis.verdict == verdict
    assert isinstance(diagnosis.decided_by, Rule)
    assert diagnosis.decided_by.condition is not None
    assert diagnosis.at(diagnosis.decided_by.condition).share == diagnosis.decided_by.value
    assert all(land.verdict.rank <= diagnosis.verdict.rank for land in diagnosis.lands)
    assert growth > 1.3 or all(land.verdict.rank < diagnosis.verdict.rank for land in diagnosis.lands)


def test_a_total_at_a_third_condition_that_decides_is_reported(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """At stall the pump is slow and the pressure high: what decides must stand in every table of totals."""
    idle = four_speed.operating_points[1]
    stall = replace(idle, name="stall", label="stall, 100 °C", engine_speed=idle.engine_speed / 2.0)
    unit = replace(four_speed, operating_points=(*four_speed.operating_points, stall))
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 3.0 * land.mounting_clearance) for land in unit.lands
    }
    found = diagnose(unit, hipol, limits, readings=readings_of(unit, diameters))
    assert isinstance(found.decided_by, Rule)
    assert found.decided_by.condition == stall
    assert [at.condition.name for at in found.reported] == ["driving_second", "hot_idle", "stall"]
    record = diagnosis_record(found)
    assert record["unit"]["decided_by"]["value"] == pytest.approx(record["conditions"][2]["share_percent"], abs=1e-9)
    assert record["unit"]["decided_by"]["limit"] == 50.0


def test_the_worst_condition_is_reported_whatever_decides(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """A land's wear decides, and no total is past its limit: the condition that takes most is named all the same."""
    driving = minimal.operating_points[0]
    reverse = replace(driving, name="reverse", label="reverse at idle", engine_speed=10.0, main_pressure=14e5)
    unit = replace(minimal, operating_points=(*minimal.operating_points, reverse))
    wear_alone = replace(limits, pair_share=None)
    found = diagnose(unit, hipol, wear_alone, readings=readings_of(unit, at_wear(unit, solenoid_modulator=0.6)))
    assert found.decided_by is not None
    assert not isinstance(found.decided_by, Rule)
    assert {found.band(each) for each in found.projections} == {"green"}
    assert found.worst.condition.name == "reverse"
    assert found.worst.share == max(each.share for each in found.projections)
    assert [at.condition.name for at in found.reported] == ["driving_second", "hot_idle", "reverse"]


def test_of_equally_bad_lands_the_surest_decides(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """The costlier land comes first in the repairs, but a verdict is not reported as open where one land is sure."""
    wear = limits.wear
    assert wear is not None
    lands = [land for land in minimal.lands if land.land == 1][:2]
    worn = {lands[0].component: 0.52, lands[1].component: 1.5}
    only_wear = replace(limits, pair_share=None)
    found = diagnose(minimal, hipol, only_wear, readings=readings_of(minimal, at_wear(minimal, **worn)))
    assert {land.decision for land in found.flagged} == {"conditional_fail", "fail"}
    assert found.decision == "fail"
    assert found.decided_by is not None
    assert not isinstance(found.decided_by, Rule)
    assert found.decided_by.key == lands[1].key


def test_a_unit_within_its_limits_says_how_sure_that_is(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    just_under = {minimal.lands[0].component: 3.9e-6 / minimal.lands[0].new_clearance}
    found = diagnose(minimal, hipol, limits, readings=readings_of(minimal, at_wear(minimal, **just_under)))
    assert (found.verdict, found.decided_by, found.decision) == ("ok", None, "conditional_pass")


def test_a_unit_of_which_no_pair_is_known_on_both_parts_is_not_decided(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    spools = {land.key: (land.nominal_diameter, None) for land in minimal.lands}
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, spools))
    assert (diagnosis.verdict, diagnosis.decision) == ("not_measured", None)


def test_the_mileage_of_the_sheets_head_counts_where_none_is_given(sample: Diagnosis) -> None:
    assert sample.readings is not None
    assert (sample.readings.identity.mileage, sample.mileage) == (106_315.0, 106_315.0)
    assert sample.with_mileage(90_000.0).mileage == 90_000.0
    assert sample.with_mileage(90_000.0).with_mileage(None).mileage == 106_315.0


def test_another_mileage_changes_what_a_diagnosis_with_it_says_and_nothing_else(sample: Diagnosis) -> None:
    assert sample.readings is not None
    unstated = replace(sample.readings, identity=SheetIdentity())

    def at(mileage: float | None) -> Diagnosis:
        return diagnose(
            sample.controller,
            sample.fluid,
            sample.limits,
            readings=unstated,
            profile=sample.profile,
            mileage_km=mileage,
        )

    without, there = at(None), at(120_000.0)
    moved = without.with_mileage(120_000.0)
    assert [land.replace_mileage for land in moved.lands] == [land.replace_mileage for land in there.lands]
    assert any(land.replace_mileage for land in moved.lands) or moved.messages != without.messages
    assert (moved.messages, moved.mileage, moved.verdict) == (there.messages, 120_000.0, there.verdict)
    assert moved.with_mileage(None).messages == without.messages
    assert moved.uncertainty is without.uncertainty
