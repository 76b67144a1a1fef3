"""The engine at one condition: against the exact annulus, and what it says of gaps and pump."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.circuits import PressureRelation
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import DomainError
from atleak.engine.gap_messages import gap_messages, narrow_gap_messages
from atleak.engine.leakage import GapLaw, LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.measurements.clearances import LandClearance, Station, clearances
from tests.unit.equations import referees


def test_mean_diameter_follows_the_exact_annulus(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP.with_options(entry_loss="off"))
    for gap in model.gaps(four_speed.operating_points[0]):
        spool = gap.diameter - gap.effective_clearance
        exact = referees.exact_annulus_flow(
            gap.pressure_drop,
            spool,
            spool + 2.0 * gap.effective_clearance,
            gap.kinematic_viscosity * gap.density,
            gap.contact_length,
        )
        assert gap.leakage == pytest.approx(exact, rel=1e-6, abs=0.0)


def test_flow_between_sections_is_not_drawn_twice(four_speed: Controller, hipol: Fluid) -> None:
    states = clearances(None, four_speed)
    gaps = LeakageModel(four_speed, states, hipol, WORKSHOP).gaps(four_speed.operating_points[0])
    not_drawn = {str(gap.gap.low) for gap in gaps if not gap.drawn_from_pump}
    assert not_drawn == {"p_m"}
    assert all(
        gap.drawn_from_pump
        for gap in LeakageModel(four_speed, states, hipol, PAPER).gaps(four_speed.operating_points[0])
    )


def test_temperature_outside_the_fluid_is_refused(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER)
    hot = replace(four_speed.operating_points[0], temperature=101.0)
    with pytest.raises(DomainError, match=r"101 °C is outside the fluid's data \(tabulated\), -40 to 100 °C"):
        model.gaps(hot)


def test_messages_of_gaps(four_speed: Controller, hipol: Fluid) -> None:
    relations = {**four_speed.relations, "p_s": PressureRelation("line", 0.01, 0.0, None)}
    controller = replace(four_speed, relations=relations)
    model = LeakageModel(controller, clearances(None, controller), hipol, PAPER)
    codes = {
        message.code: message.text
        for message in gap_messages(
            model.law, model.gaps(controller.operating_points[0]), controller.operating_points[0]
        )
    }
    assert "13 land 1" in codes["reversed_pressure_drop"]
    reversed_ = [gap for gap in model.gaps(controller.operating_points[0]) if gap.pressure_drop < 0]
    assert reversed_
    assert all(gap.leakage == 0.0 for gap in reversed_)


def one_wide(controller: Controller, clearance: float) -> tuple[LandClearance, ...]:
    """Every land as new but 25/1, which has that clearance [m]."""
    return tuple(
        replace(state, radial_clearance=clearance, sleeve_diameter=state.spool_diameter + 2.0 * clearance)
        if state.land.key == ("25", 1)
        else state
        for state in clearances(None, controller)
    )


def test_a_large_entry_loss_is_told_with_what_it_takes_off(
    four_speed: Controller, hot_idle: OperatingPoint, hipol: Fluid
) -> None:
    wide = one_wide(four_speed, 490e-6)
    flows, said = {}, {}
    for profile in (WORKSHOP, WORKSHOP.with_options(entry_loss="off")):
        model = LeakageModel(four_speed, wide, hipol, profile)
        gaps = model.gaps(hot_idle)
        flows[profile.entry_loss] = {gap.gap.key: gap.leakage for gap in gaps}
        messages = gap_messages(model.law, gaps, hot_idle)
        said[profile.entry_loss] = next(message for message in messages if message.code == "entry_loss")
    taken = 1.0 - flows["auto"]["25", 1] / flows["off"]["25", 1]
    assert taken > 0.9
    assert said["auto"].level == "info"
    assert said["auto"].text.endswith(f"the entry loss takes off {100.0 * taken:.0f} % at 25 land 1.")
    assert said["off"].level == "warning"
    assert said["off"].text.endswith(f"It would take off {100.0 * taken:.0f} % at 25 land 1.")


def test_an_entry_loss_of_a_few_percent_is_taken_off_and_not_spoken_of(
    four_speed: Controller, hot_idle: OperatingPoint, hipol: Fluid
) -> None:
    states = one_wide(four_speed, 57e-6)
    off = LeakageModel(four_speed, states, hipol, WORKSHOP.with_options(entry_loss="off")).gaps(hot_idle)
    model = LeakageModel(four_speed, states, hipol, WORKSHOP)
    gaps = model.gaps(hot_idle)
    losses = {less.gap.key: 1.0 - less.leakage / more.leakage for less, more in zip(gaps, off, strict=True)}
    assert min(losses.values()) > 0.0
    assert 0.02 < losses["25", 1] < 0.1
    assert "entry_loss" not in {message.code for message in gap_messages(model.law, gaps, hot_idle)}


@pytest.mark.parametrize("profile", [WORKSHOP, WORKSHOP.with_options(eccentricity="unknown"), PAPER])
@given(
    clearance=st.floats(0.0, 500e-6),
    wider=st.floats(1.001, 3.0),
    spread=st.floats(0.0, 1.0),
    skew=st.floats(-2.0, 2.0),
    drop=st.floats(1e3, 3e6),
    viscosity=st.floats(4e-6, 5e-3),
)
def test_flow_always_rises_with_the_clearance(
    profile: Profile, clearance: float, wider: float, spread: float, skew: float, drop: float, viscosity: float
) -> None:
    law = GapLaw(profile)
    m2, m3 = (40e-6 * spread) ** 2, skew * (40e-6 * spread) ** 3

    def flow(mean: float) -> float:
        even = law.flow_clearance(mean, m2, m3)
        return law.flow(drop, law.diameter(14e-3, mean), even, viscosity, 800.0, 5e-3)

    narrow, wide = flow(clearance), flow(clearance * wider)
    assert 0.0 <= narrow <= wide
    assert narrow < wide or clearance < 1e-9


@given(clearance=st.floats(1e-6, 500e-6), drop=st.floats(1e3, 3e6), viscosity=st.floats(4e-6, 5e-3))
def test_an_eccentric_gap_gains_on_friction_alone(clearance: float, drop: float, viscosity: float) -> None:
    factors = (drop, 14e-3, clearance, viscosity, 800.0, 5e-3)
    concentric = GapLaw(WORKSHOP).flow(*factors)
    touching = GapLaw(WORKSHOP.with_options(eccentricity=1.0)).flow(*factors)
    unknown = GapLaw(WORKSHOP.with_options(eccentricity="unknown")).flow(*factors)
    assert concentric <= unknown <= 1.5 * concentric * (1.0 + 1e-12)
    assert unknown <= touching <= 2.5 * concentric * (1.0 + 1e-12)
    without_friction = math.pi * 14e-3 * clearance * math.sqrt(drop / (0.75 * 800.0))
    assert touching < without_friction


def test_an_unknown_position_is_the_mean_over_all_of_them() -> None:
    positions = (np.arange(2000) + 0.5) / 2000
    for profile in (PAPER, WORKSHOP):
        factors = (5e5, 14e-3, 30e-6, 9e-6, 800.0, 5e-3)
        drawn = GapLaw(profile).flow(*factors, 1.0 + 1.5 * positions**2)
        unknown = GapLaw(profile.with_options(eccentricity="unknown"))
        assert unknown.eccentricity_factor == 1.5
        # with entry loss the mean of the flows is not quite that of the mean factor
        assert unknown.flow(*factors) == pytest.approx(float(drawn.mean()), rel=1e-3, abs=0.0)


def test_form_counts_in_the_flow_and_not_in_the_diameter(
    four_speed: Controller, hot_idle: OperatingPoint, hipol: Fluid
) -> None:
    states = clearances(None, four_speed)
    key = ("25", 1)
    spool = next(state.spool_diameter for state in states if state.land.key == key)
    worn = [(0.0, 60e-6), (45.0, 20e-6), (90.0, 10e-6), (135.0, 30e-6)]
    stations = tuple(Station("1", angle, spool, spool + 2.0 * c) for angle, c in worn)
    uneven = tuple(
        replace(state, radial_clearance=30e-6, sleeve_diameter=spool + 60e-6, stations=stations)
        if state.land.key == key
        else state
        for state in states
    )
    of_mean, of_cubes = (
        next(gap for gap in LeakageModel(four_speed, uneven, hipol, profile).gaps(hot_idle) if gap.gap.key == key)
        for profile in (WORKSHOP.with_options(form="cube_of_mean"), WORKSHOP)
    )
    warmed = of_mean.effective_clearance - 30e-6
    warm = np.array([c for _, c in worn]) + warmed
    assert of_cubes.effective_clearance**3 == pytest.approx(float(np.mean(np.power(warm, 3))), rel=1e-12, abs=0.0)
    assert of_cubes.diameter == of_mean.diameter
    assert of_cubes.leakage > 1.5 * of_mean.leakage


def test_a_direction_that_closes_leaks_no_less_than_the_mean_gap() -> None:
    law = GapLaw(WORKSHOP)
    c, m2, m3 = 3e-6, 200e-12, -2000e-18  # of -17, 13 and 13 µm
    assert law.flow_clearance(c, m2, m3) == c
    assert law.flow_clearance(np.array([c, 40e-6]), m2, m3).tolist()[1] > 40e-6


def test_narrow_gaps_are_told_once_with_how_many_lands_have_them(four_speed: Controller, hipol: Fluid) -> None:
    tight = one_wide(four_speed, 12e-6)
    model = LeakageModel(four_speed, tight, hipol, WORKSHOP)
    gaps = [gap for point in four_speed.operating_points for gap in model.gaps(point)]
    (message,) = narrow_gap_messages(gaps)
    lands = {gap.gap.key for gap in gaps}
    narrowest = min(gap.effective_clearance for gap in gaps if gap.gap.key == ("25", 1))
    assert message.code == "partly_closed_gap"
    assert message.text.startswith(f"1 of {len(lands)} lands")
    assert f"25 land 1 with {narrowest * 1e6:.1f} µm" in message.text
    assert (
        narrow_gap_messages(
            LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP).gaps(four_speed.operating_points[0])
        )
        == []
    )


def test_pump_with_slip_and_without(four_speed: Controller, hipol: Fluid) -> None:
    states = clearances(None, four_speed)
    constant = LeakageModel(four_speed, states, hipol, PAPER)
    slipping = LeakageModel(four_speed, states, hipol, WORKSHOP)
    assert constant.pump_capacity(2500 / 60, 8e5, 80.0) * 6e4 == pytest.approx(40.613, abs=5e-4)
    # Wilson: η_v = 1 − C_s Δp / (μ ω)
    viscous = slipping.dynamic_viscosity(80.0)
    efficiency = 1.0 - four_speed.pump.slip_coefficient * 8e5 / (viscous * 2.0 * np.pi * 2500 / 60)
    ideal = constant.pump_capacity(2500 / 60, 8e5, 80.0) / 0.95
    assert slipping.pump_capacity(2500 / 60, 8e5, 80.0) == pytest.approx(ideal * efficiency, rel=1e-12, abs=0.0)
    assert slipping.pump_capacity(0.01, 8e5, 80.0) == 0.0
    leakage = 5e-5
    speed = slipping.minimum_speed(leakage, 8e5, 80.0)
    assert slipping.pump_capacity(speed, 8e5, 80.0) == pytest.approx(leakage, rel=1e-12, abs=0.0)
    assert constant.pump_capacity(constant.minimum_speed(leakage, 8e5, 80.0), 8e5, 80.0) == pytest.approx(
        leakage, rel=1e-12, abs=0.0
    )
    without = replace(four_speed, pump=replace(four_speed.pump, slip_coefficient=None))
    assert not LeakageModel(without, states, hipol, WORKSHOP).uses_slip
