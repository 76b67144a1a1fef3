"""The same controller at stated conditions: with other speeds, other wear, repaired."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.common.errors import DomainError, InputError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import Projection, project, repaired, stated_condition, with_wear
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings


def test_nothing_stated_is_the_first_operating_point(four_speed: Controller) -> None:
    assert stated_condition(four_speed) is four_speed.operating_points[0]


def test_what_is_stated_takes_the_place_of_the_first_operating_point_s(four_speed: Controller) -> None:
    first = four_speed.operating_points[0]
    condition = stated_condition(four_speed, temperature=95.0, engine_speed=20.0, gear=3)
    assert (condition.name, condition.temperature, condition.engine_speed, condition.gear) == ("stated", 95.0, 20.0, 3)
    assert (condition.main_pressure, condition.converter_pressure) == (first.main_pressure, first.converter_pressure)
    assert condition.label == "gear 3, 95 °C, 1200 rpm"
    assert first.label in condition.source
    warmer = stated_condition(four_speed, temperature=95.0)
    assert (warmer.engine_speed, warmer.gear) == (first.engine_speed, first.gear)


@pytest.mark.parametrize(
    ("stated", "value", "expected"),
    [
        ({"gear": 9}, 9, "one of 1, 2, 3, 4"),
        ({"gear": 0}, 0, "one of 1, 2, 3, 4"),
        ({"engine_speed": 0.0}, 0.0, "more than 0 rpm"),
        ({"engine_speed": -10.0}, -600.0, "more than 0 rpm"),
        ({"engine_speed": math.inf}, math.inf, "more than 0 rpm"),
        ({"temperature": math.inf}, math.inf, "a number in °C"),
    ],
)
def test_a_condition_that_cannot_be(
    stated: dict[str, float], value: float, expected: str, four_speed: Controller
) -> None:
    with pytest.raises(InputError) as caught:
        stated_condition(four_speed, **stated)  # type: ignore[arg-type]
    assert (caught.value.value, caught.value.expected) == (value, expected)


def test_a_projection_adds_up(sample: Diagnosis) -> None:
    for projection in sample.projections:
        drawn = [gap.leakage for gap in projection.gaps if gap.drawn_from_pump]
        assert projection.leakage == pytest.approx(math.fsum(drawn), rel=1e-12, abs=0.0)
        assert projection.share == projection.leakage / projection.pump_capacity
        keys = {gap.gap.key for gap in projection.gaps}
        by_land = math.fsum(projection.drawn_by(key) for key in keys)
        assert by_land == pytest.approx(projection.leakage, rel=1e-12, abs=0.0)
        for key in keys:
            assert projection.leakage_of(key) >= projection.drawn_by(key) >= 0.0


def test_paper_draws_every_gap_and_workshop_what_ends_in_the_sump(sample_diagnoses: dict[str, Diagnosis]) -> None:
    assert all(gap.drawn_from_pump for gap in sample_diagnoses["paper"].projection.gaps)
    for gap in sample_diagnoses["workshop"].projection.gaps:
        assert gap.drawn_from_pump == gap.gap.into_sump


def test_at_the_minimum_speed_the_pump_just_covers_the_leakage(sample: Diagnosis) -> None:
    model = LeakageModel(sample.controller, tuple(land.state for land in sample.lands), sample.fluid, sample.profile)
    for projection in sample.projections:
        at = projection.condition
        capacity = model.pump_capacity(projection.minimum_speed, at.main_pressure, at.temperature)
        assert float(capacity) == pytest.approx(projection.leakage, rel=1e-9, abs=0.0)


def test_a_pump_that_delivers_nothing_has_no_share_to_give(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    projection = project(model, stated_condition(four_speed, engine_speed=0.1))
    assert projection.pump_capacity == 0.0
    assert projection.share == math.inf
    assert projection.share_of(0.0) == 0.0


def test_a_share_over_100_percent_is_called_a_demand(four_speed: Controller, hipol: Fluid) -> None:
    states = clearances(None, four_speed)
    for wear, told in ((0.0, []), (2.0, ["demand_over_pump"])):
        projection = project(
            LeakageModel(four_speed, with_wear(states, wear), hipol, WORKSHOP), four_speed.operating_points[1]
        )
        demands = [message for message in projection.messages if message.code == "demand_over_pump"]
        assert [message.code for message in demands] == told
        assert (projection.share > 1.0) == bool(told)
    (demand,) = demands
    assert demand.level == "warning"
    for words in (projection.condition.label, f"{100.0 * projection.share:.0f} %", "cannot meet", "pressure will fall"):
        assert words in demand.text


@pytest.mark.parametrize("profile", [WORKSHOP, PAPER])
@pytest.mark.parametrize("eccentricity", [0.0, 0.6, 1.0, "unknown"])
def test_a_projection_knows_its_leakage_with_the_spools_concentric_and_touching(
    four_speed: Controller, hipol: Fluid, profile: Profile, eccentricity: object
) -> None:
    states = with_wear(clearances(None, four_speed), 5.0)

    def projected(position: object) -> Projection:
        model = LeakageModel(four_speed, states, hipol, profile.with_options(eccentricity=position))
        return project(model, four_speed.operating_points[0])

    taken, concentric, touching = (projected(position) for position in (eccentricity, 0.0, 1.0))
    assert taken.concentric_leakage == pytest.approx(concentric.leakage, rel=1e-12, abs=0.0)
    assert taken.touching_leakage == pytest.approx(touching.leakage, rel=1e-12, abs=0.0)
    for gap, least, largest in zip(taken.gaps, concentric.gaps, touching.gaps, strict=True):
        assert gap.concentric_leakage == pytest.approx(least.leakage, rel=1e-12, abs=0.0)
        assert gap.touching_leakage == pytest.approx(largest.leakage, rel=1e-12, abs=0.0)


def test_outside_the_fluid_there_is_no_projection(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER)
    with pytest.raises(DomainError, match="101 °C"):
        project(model, stated_condition(four_speed, temperature=101.0))


def test_a_reversed_drop_is_said(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    point = replace(four_speed.operating_points[0], main_pressure=60e5)  # p_s is limited to 500 kPa, 0.1 p_g is not
    projection = project(model, point)
    assert "reversed_pressure_drop" in {message.code for message in projection.messages}
    below = [gap for gap in projection.gaps if gap.pressure_drop < 0.0]
    assert below
    assert all(gap.leakage == 0.0 for gap in below)


def test_control_pressure_above_main_pressure_is_said(
    four_speed: Controller, minimal: Controller, hipol: Fluid
) -> None:
    for controller, main_pressure, codes in (
        (four_speed, 234e3, {"pressure_relation"}),
        (four_speed, 235e3, set()),
        (minimal, 1e3, set()),
    ):
        model = LeakageModel(controller, clearances(None, controller), hipol, WORKSHOP)
        point = replace(controller.operating_points[0], main_pressure=main_pressure)
        codes_given = {message.code for message in project(model, point).messages}
        assert codes_given & {"pressure_relation"} == codes


# --- other wear


def test_wear_leaves_the_form_of_a_gap(sample: Diagnosis) -> None:
    states = [land.state for land in sample.lands]
    moments = [state.form_moments for state in states]
    assert any(m2 > 0.0 for m2, _ in moments)
    assert [state.form_moments for state in with_wear(states, 0.5)] == moments


@given(increment=st.floats(0.0, 2.0))
def test_wear_scales_the_cold_clearance_and_leaves_the_spool(increment: float, four_speed: Controller) -> None:
    before = clearances(None, four_speed)
    for old, new in zip(before, with_wear(before, increment), strict=True):
        assert new.radial_clearance == pytest.approx(old.radial_clearance * (1.0 + increment), rel=1e-12, abs=0.0)
        assert new.spool_diameter == old.spool_diameter
        assert (new.sleeve_diameter - new.spool_diameter) / 2.0 == pytest.approx(
            new.radial_clearance, rel=1e-9, abs=0.0
        )


def test_wear_leaves_the_thermal_term_unscaled(four_speed: Controller, hipol: Fluid) -> None:
    point = four_speed.operating_points[0]
    new = clearances(None, four_speed)
    worn = with_wear(new, 0.5)
    gaps = [
        {gap.gap.key: gap for gap in LeakageModel(four_speed, states, hipol, PAPER).gaps(point)}
        for states in (new, worn)
    ]
    for state in new:
        key = state.land.key
        if key not in gaps[0]:
            continue
        growth = gaps[1][key].effective_clearance - gaps[0][key].effective_clearance
        # the sleeve's own growth on half a clearance more: β·c·ΔT, some 0.02 µm
        assert growth == pytest.approx(0.5 * state.radial_clearance, rel=2e-3, abs=0.0)


def test_repaired_lands_are_new_and_the_others_as_they_were(sample: Diagnosis) -> None:
    states = [land.state for land in sample.lands]
    chosen = sample.flagged[0].key
    for old, new in zip(states, repaired(states, [chosen]), strict=True):
        if old.land.key == chosen:
            assert new.radial_clearance == old.land.mounting_clearance != old.radial_clearance
            assert new.spool_diameter == old.spool_diameter
            assert new.form_moments == (0.0, 0.0) != old.form_moments
        else:
            assert new is old


def test_repairing_a_new_unit_changes_nothing(minimal: Controller, readings_of: Callable[..., Readings]) -> None:
    states = clearances(None, minimal)
    again = repaired(states, [state.land.key for state in states])
    for old, new in zip(states, again, strict=True):
        assert new.radial_clearance == old.radial_clearance
        assert new.sleeve_diameter == pytest.approx(old.sleeve_diameter, rel=1e-15, abs=0.0)
