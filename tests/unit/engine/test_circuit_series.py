"""The circuits of a log against the engine at one condition, sample by sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine import log_gaps as circuit_series
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import project
from atleak.engine.series import LeakageSeries, leakage_series
from atleak.measurements.clearances import LandClearance, clearances

ON = WORKSHOP.with_options(entry_loss="on")
LOSSLESS = WORKSHOP.with_options(entry_loss="off")
PROFILES = {
    "on": ON,
    "lossless": LOSSLESS,
    "paper": PAPER,
    "paper_solved": PAPER.with_options(circuits="on"),
    "off": LOSSLESS.with_options(circuits="off"),
    "eccentric": LOSSLESS.with_options(eccentricity="unknown"),
}


def worn(controller: Controller, low: float = 10e-6, high: float = 60e-6) -> tuple[LandClearance, ...]:
    """Lands from narrow to wide, among them one that closes in the cold."""
    states = clearances(None, controller)
    widths = [1e-6, *np.linspace(low, high, len(states) - 1).tolist()]
    return tuple(
        replace(state, radial_clearance=width, sleeve_diameter=state.spool_diameter + 2.0 * width)
        for state, width in zip(states, widths, strict=True)
    )


def log(size: int, seed: int = 3) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        "main_pressure": rng.uniform(0.0, 14e5, size),
        "converter_pressure": rng.uniform(0.0, 6e5, size),
        "temperature": rng.uniform(20.0, 100.0, size),
        "gear": rng.choice([1.0, 2.0], size),
    }


def at_sample(channels: dict[str, np.ndarray], sample: int, like: OperatingPoint) -> OperatingPoint:
    """The condition of one sample, with an engine so quick that the pump holds every pressure."""
    main, converter, temperature, gear = (float(channel[sample]) for channel in channels.values())
    return replace(
        like,
        temperature=temperature,
        engine_speed=1e4,
        gear=int(gear),
        main_pressure=main,
        converter_pressure=converter,
        values_of=like.like,
    )


def agrees(model: LeakageModel, channels: dict[str, np.ndarray], series: LeakageSeries, like: OperatingPoint) -> None:
    """Every sample is what the engine computes at its condition."""
    for sample in range(len(series.total)):
        one = project(model, at_sample(channels, sample, like))
        assert series.total[sample] == pytest.approx(one.leakage, rel=1e-9, abs=1e-18)
        for circuit in model.controller.circuits:
            held = series.circuits[circuit.id][sample]
            assert held == pytest.approx(one.pressures[circuit.id], rel=1e-9, abs=1e-3)


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_sample_is_what_the_engine_computes_at_its_condition(
    three_circuits: Controller, hipol: Fluid, name: str, number: int
) -> None:
    model, channels = LeakageModel(three_circuits, worn(three_circuits), hipol, PROFILES[name]), log(40)
    assumed = three_circuits.operating_points[number]
    series = leakage_series(model, **channels, sections=True, assumed=assumed)
    agrees(model, channels, series, assumed)
    np.testing.assert_allclose(sum(series.sections.values()), series.total, rtol=1e-12)
    assert series.unbalanced == 0
    total = leakage_series(model, **channels, assumed=assumed).total
    np.testing.assert_allclose(total, series.total, rtol=1e-12)


@given(
    main=st.floats(0.0, 3e6),
    converter=st.floats(0.0, 1e6),
    temperature=st.floats(-20.0, 140.0),
    width=st.floats(1, 300),
)
def test_any_single_sample_agrees_with_the_engine(
    three_circuits: Controller, hipol: Fluid, main: float, converter: float, temperature: float, width: float
) -> None:
    model = LeakageModel(three_circuits, worn(three_circuits, 5e-6, width * 1e-6), hipol, ON)
    point = three_circuits.operating_points[0]
    for gear in three_circuits.gears:
        channels = {
            "main_pressure": np.array([main]),
            "converter_pressure": np.array([converter]),
            "temperature": np.array([temperature]),
            "gear": np.array([float(gear)]),
        }
        agrees(model, channels, leakage_series(model, **channels), point)


def test_a_log_of_several_parts_is_what_each_sample_is_alone(
    three_circuits: Controller, hipol: Fluid, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, channels = LeakageModel(three_circuits, worn(three_circuits), hipol, WORKSHOP), log(500)
    whole = leakage_series(model, **channels)
    monkeypatch.setattr(circuit_series, "_PART", 7)
    parts = leakage_series(model, **channels)
    np.testing.assert_allclose(parts.total, whole.total, rtol=1e-9)
    for name, pressure in whole.circuits.items():
        np.testing.assert_allclose(parts.circuits[name], pressure, rtol=1e-9, atol=1e-3)


def test_samples_that_cannot_be_used_have_no_pressure(three_circuits: Controller, hipol: Fluid) -> None:
    model, channels = LeakageModel(three_circuits, worn(three_circuits), hipol, WORKSHOP), log(8)
    channels["main_pressure"][0] = np.nan
    channels["converter_pressure"][1] = np.nan
    channels["temperature"][2:4] = (np.nan, 190.0)
    channels["gear"][4:6] = (np.nan, 7.0)
    series = leakage_series(model, **channels, sections=True)
    for values in (series.total, *series.circuits.values(), *series.sections.values()):
        assert np.isnan(values).tolist() == [True] * 6 + [False] * 2
    assert (series.outside_fluid, series.other_gear) == (1, 1)


def test_a_circuit_is_vented_in_the_gears_in_which_it_is_not_applied(three_circuits: Controller, hipol: Fluid) -> None:
    model, channels = LeakageModel(three_circuits, worn(three_circuits), hipol, WORKSHOP), log(30)
    held = leakage_series(model, **channels).circuits
    first = channels["gear"] == 1.0
    assert (held["clutch_c2"][first] == 0.0).all()
    assert (held["clutch_c1"][~first] == 0.0).all()
    assert (held["clutch_c1"][first] > 0.0).all()
    assert (held["clutch_c2"][~first] <= 600e3 * (1.0 + 1e-12)).all()


def test_a_sensor_that_reads_below_zero_counts_as_no_pressure(three_circuits: Controller, hipol: Fluid) -> None:
    model = LeakageModel(three_circuits, worn(three_circuits), hipol, ON)
    below, zero = (leakage_series(model, 5e5, converter, 80.0, [1.0, 2.0]) for converter in (-2e4, 0.0))
    for name, pressure in zero.circuits.items():
        np.testing.assert_allclose(below.circuits[name], pressure, rtol=1e-12)
    nothing = leakage_series(model, -1e4, -1e4, 80.0, [1.0, 2.0])
    assert all((pressure == 0.0).all() for pressure in nothing.circuits.values())
    assert nothing.unbalanced == 0


def test_auto_leaves_the_entry_loss_out_of_gaps_it_hardly_matters_to(three_circuits: Controller, hipol: Fluid) -> None:
    """Of narrow gaps it is left out, of wide ones it is not: there the log agrees with the engine again."""
    channels = log(60)
    apart = []
    for width in (20e-6, 120e-6):
        states = tuple(replace(state, radial_clearance=width) for state in clearances(None, three_circuits))
        exact, auto = (
            leakage_series(LeakageModel(three_circuits, states, hipol, profile), **channels)
            for profile in (ON, WORKSHOP)
        )
        np.testing.assert_allclose(auto.total, exact.total, rtol=0.01)
        apart.append(float(np.max(np.abs(auto.total / exact.total - 1.0))))
    assert 1e-7 < apart[0] < 1e-3
    assert apart[1] < 1e-12


def test_reversed_drops_of_circuits_are_counted_but_not_those_that_leak_backwards(
    three_circuits: Controller, hipol: Fluid
) -> None:
    model = LeakageModel(three_circuits, worn(three_circuits), hipol, WORKSHOP)
    series = leakage_series(model, 9e5, [5e5, 1e5], 80.0, 2.0)
    assert series.reversed_samples["epc"] == 1  # 0.8 of its 200 kPa against p_k of 500 kPa
    assert "clutch_c1" not in series.reversed_samples  # vented
    assert series.reversed_samples["p_g"] == 0


@pytest.mark.parametrize("profile", [WORKSHOP, PAPER])
def test_a_unit_without_circuits_has_none_and_costs_no_balance(
    four_speed: Controller, hipol: Fluid, profile: Profile, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[object] = []
    monkeypatch.setattr(circuit_series.CircuitLog, "parts", lambda *_: calls.append(1) or [])
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, profile)
    assert leakage_series(model, **log(50)).circuits == {}
    assert not calls
