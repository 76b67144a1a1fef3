"""The leakage of a log against a slow loop over its samples and gaps, and against the engine at one condition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.leakage import GapLaw, LeakageModel
from atleak.engine.log_gaps import ENTRY_LOSS_LEFT_OUT
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.series import leakage_series
from atleak.equations import gap as gap_equations
from atleak.measurements.clearances import LandClearance, Station, clearances
from tests.unit.conftest import first_of
from tests.unit.equations import referees

LOSSLESS = WORKSHOP.with_options(entry_loss="off")
PROFILES = {
    "paper": PAPER,
    "lossless": LOSSLESS,
    "entry_loss": WORKSHOP.with_options(entry_loss="on"),
    "eccentric": PAPER.with_options(eccentricity="0.7"),
    "unknown": LOSSLESS.with_options(eccentricity="unknown"),
    "all": WORKSHOP.with_options(entry_loss="on", eccentricity="0.5"),
    "mean_all_gaps": PAPER.with_options(diameter="mean"),
    "regression": PAPER.with_options(viscosity="regression"),
}


@pytest.fixture(scope="module")
def log() -> dict[str, np.ndarray]:
    """300 samples with every trouble: reversed drops, limits, unknown gears, gaps in every channel."""
    rng = np.random.default_rng(7)
    size = 300
    p_g = rng.uniform(1e5, 12e5, size)
    p_g[10:20] = 2e4  # so low that 0.1 p_g … and so high that p_m is limited
    p_g[20:25] = 40e5  # p_s below 0.1 p_g? no: its limit, 500 kPa, is above; 0.1·(60 bar) is not
    p_g[25:30] = 60e5
    p_g[30] = np.nan
    p_k = rng.uniform(0.0, 5e5, size)
    p_k[40:45] = -1e4
    p_k[45] = np.nan
    temperature = rng.uniform(20.0, 100.0, size)
    temperature[50] = np.nan
    temperature[51] = 190.0
    gear = rng.choice([1.0, 2.0, 3.0, 4.0], size)
    gear[60:63] = (0.0, np.nan, 7.0)
    return {"main_pressure": p_g, "converter_pressure": p_k, "temperature": temperature, "gear": gear}


def uneven(controller: Controller) -> tuple[LandClearance, ...]:
    """Every land at its mean mounting clearance, but measured in two planes and three directions that differ."""
    deviations = {"1": (-5e-6, 1e-6, 7e-6), "2": (-9e-6, 0.0, 6e-6)}
    return tuple(
        replace(
            state,
            stations=tuple(
                Station(
                    plane,
                    60.0 * number,
                    state.spool_diameter,
                    state.spool_diameter + 2.0 * (state.radial_clearance + by),
                )
                for plane, several in deviations.items()
                for number, by in enumerate(several)
            ),
        )
        for state in clearances(None, controller)
    )


def mean_cube(state: LandClearance, clearance: float) -> float:
    """Mean of the cubes at a mean effective clearance, from the deviations at every place; never under its own cube."""
    places = [station.radial_clearance - state.radial_clearance for station in state.stations]
    return max(float(np.mean([(clearance + by) ** 3 for by in places])), clearance**3)


def slow_loop(model: LeakageModel, log: dict[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Sample by sample, gap by gap, with nothing shared between them but the equations."""
    controller, fluid, profile = model.controller, model.fluid, model.profile
    states = {state.land.key: state for state in model.clearances}
    total = np.full(len(log["gear"]), np.nan)
    sections = {name: np.full(len(total), np.nan) for name in ("p_g", "p_s", "p_m", "p_k")}
    low, high = fluid.span(profile.viscosity)
    for i in range(len(total)):
        p_g, p_k, temperature, gear = (
            float(log[name][i]) for name in ("main_pressure", "converter_pressure", "temperature", "gear")
        )
        if not low <= temperature <= high or gear not in controller.gears or np.isnan(p_g):
            continue
        pressures = controller.section_pressures(p_g, p_k)
        nu, rho = (
            fluid.kinematic_viscosity(temperature, profile.viscosity),
            fluid.density(temperature, profile.viscosity),
        )
        flows = dict.fromkeys(sections, 0.0)
        for gap in controller.gaps:
            if gear not in gap.gears or (profile.pump_draw == "into_sump" and not gap.into_sump):
                continue
            state = states[gap.key]
            upper, lower = (
                0.0 if end.section is None else end.coefficient * float(pressures[end.section])
                for end in (gap.high, gap.low)
            )
            clearance = referees.effective_clearance_two_temperatures(
                state.radial_clearance,
                state.sleeve_diameter,
                state.spool_diameter,
                state.land.body_expansion,
                state.land.spool_expansion,
                temperature - 20.0,
                temperature - 20.0,
            )
            diameter = state.spool_diameter + (clearance if profile.diameter == "mean" else 0.0)
            drop, length = max(upper - lower, 0.0) if not np.isnan(upper - lower) else np.nan, state.land.contact_length
            if profile.form == "mean_of_cubes":
                clearance = mean_cube(state, clearance) ** (1.0 / 3.0)
            eccentric = 1.5 if profile.eccentricity == "unknown" else 1.0 + 1.5 * profile.eccentricity**2
            if profile.entry_loss == "on":
                flow = gap_equations.entry_loss_flow(drop, diameter, clearance, nu, rho, length, 1.5, eccentric)
            else:
                flow = eccentric * gap_equations.annular_flow(drop, diameter, clearance, nu, rho, length)
            flows[gap.section] += flow
        total[i] = sum(flows.values())
        for name, flow in flows.items():
            sections[name][i] = flow if not np.isnan(total[i]) else np.nan
    return total, sections


@pytest.mark.parametrize("name", PROFILES)
def test_series_equals_slow_loop(four_speed: Controller, hipol: Fluid, log: dict[str, np.ndarray], name: str) -> None:
    model = LeakageModel(four_speed, uneven(four_speed), hipol, PROFILES[name])
    total, sections = slow_loop(model, log)
    scale = np.nanmax(np.abs(total))
    for with_sections in (False, True):
        series = leakage_series(model, **log, sections=with_sections)
        np.testing.assert_allclose(series.total, total, rtol=1e-12)
        assert np.isnan(series.total).sum() == np.isnan(total).sum() > 3
        assert np.nansum(series.total) == pytest.approx(np.nansum(total), rel=1e-12, abs=0.0)
        assert set(series.sections) == (set(sections) if with_sections else set())
        for section, flow in series.sections.items():
            np.testing.assert_allclose(flow, sections[section], rtol=1e-12, atol=1e-15 * scale)


def test_series_counts_what_it_leaves_out(four_speed: Controller, hipol: Fluid, log: dict[str, np.ndarray]) -> None:
    series = leakage_series(LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER), **log)
    assert series.outside_fluid == 1
    assert series.other_gear == 2  # the third is not known at all
    assert series.reversed_samples["p_s"] >= 5  # where p_s is at its limit and 0.1 p_g above it
    assert series.reversed_samples["p_k"] >= 4  # where the converter's sensor reads below zero
    assert series.reversed_samples["p_g"] == 0


@pytest.mark.parametrize("size", [1, 40_000, 300_000])
def test_affine_pieces_equal_drop_by_drop(four_speed: Controller, hipol: Fluid, size: int) -> None:
    """The quick way (no limit begins, no drop turns) against the way that keeps sections, over several chunks."""
    rng = np.random.default_rng(3)
    p_g = rng.uniform(5e5, 9e5, size)
    gear = np.repeat([1.0, 2.0, 3.0, 4.0], -(-size // 4))[:size]
    log = (p_g, 0.4 * p_g, rng.uniform(40.0, 110.0, size), gear)
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    kept = leakage_series(model, *log, sections=True)
    np.testing.assert_allclose(leakage_series(model, *log).total, kept.total, rtol=1e-13)
    np.testing.assert_allclose(sum(kept.sections.values()), kept.total, rtol=1e-13)


def test_gear_that_flickers(four_speed: Controller, hipol: Fluid) -> None:
    gear = np.tile([1.0, 2.0, np.nan, 3.0], 500)
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    flickering = leakage_series(model, 7e5, 3e5, 80.0, gear).total
    for number in (1.0, 2.0, 3.0):
        assert np.all(
            flickering[gear == number]
            == pytest.approx(leakage_series(model, 7e5, 3e5, 80.0, number).total[0], rel=1e-12, abs=0.0)
        )
    assert np.isnan(flickering[np.isnan(gear)]).all()


@given(
    p_g=arrays(float, 8, elements=st.floats(0.0, 3e6)),
    p_k=arrays(float, 8, elements=st.floats(-1e5, 1e6)),
    temperature=st.floats(-30.0, 140.0),
    profile=st.sampled_from([PAPER.with_options(viscosity="d341"), LOSSLESS, WORKSHOP.with_options(entry_loss="on")]),
)
def test_series_equals_gaps_at_one_condition(
    four_speed: Controller, hipol: Fluid, p_g: np.ndarray, p_k: np.ndarray, temperature: float, profile: Profile
) -> None:
    if temperature < hipol.span("d341")[0]:
        temperature = 0.0
    model = LeakageModel(four_speed, uneven(four_speed), hipol, profile)
    series = leakage_series(model, p_g, p_k, temperature, 2).total
    for i in range(8):
        point = OperatingPoint("x", "x", temperature, 20.0, 2, float(p_g[i]), float(p_k[i]), "test")
        flow = sum(gap.leakage for gap in model.gaps(point) if gap.drawn_from_pump)
        assert series[i] == pytest.approx(flow, rel=1e-12, abs=1e-22)


def test_gap_that_closes_in_the_cold(four_speed: Controller, hipol: Fluid) -> None:
    """A tight aluminium body on steel closes below zero: it leaks nothing there and its polynomial is not used."""
    tight = tuple(
        replace(state, radial_clearance=2e-6, sleeve_diameter=state.spool_diameter + 4e-6)
        if state.land.key == ("25", 1)
        else state
        for state in clearances(None, four_speed)
    )
    model = LeakageModel(four_speed, tight, hipol, PAPER)
    temperature = np.array([-40.0, -20.0, 20.0, 80.0])
    log = {
        "main_pressure": np.full(4, 7e5),
        "converter_pressure": np.full(4, 3e5),
        "temperature": temperature,
        "gear": np.full(4, 2.0),
    }
    closed = next(g for g in model.geometries if g.gap.key == ("25", 1))
    assert closed.effective_clearance(-40.0) == 0.0 < closed.effective_clearance(20.0)
    others = LeakageModel(
        replace(four_speed, gaps=tuple(g for g in four_speed.gaps if g.key != ("25", 1))), tight, hipol, PAPER
    )
    series = leakage_series(model, **log).total
    assert series[0] == pytest.approx(leakage_series(others, **log).total[0], rel=1e-12, abs=0.0)
    assert series[3] > leakage_series(others, **log).total[3]


@pytest.mark.parametrize("with_sections", [False, True], ids=["total", "sections"])
@pytest.mark.parametrize("width", first_of([35e-6, 150e-6, 60e-6, 490e-6]))
def test_auto_leaves_out_less_than_a_hundredth_of_any_flow(
    four_speed: Controller, hipol: Fluid, log: dict[str, np.ndarray], width: float, with_sections: bool
) -> None:
    """Every gap is looked at alone, so that a gap that is too high cannot hide among others."""
    left_out = set()
    for number, gap in enumerate(four_speed.gaps):
        alone = replace(four_speed, gaps=(gap,))
        states = tuple(
            replace(state, radial_clearance=width) if state.land.key == gap.key and number % 2 else state
            for state in uneven(four_speed)
        )
        auto, on = (
            leakage_series(LeakageModel(alone, states, hipol, profile), **log, sections=with_sections)
            for profile in (WORKSHOP, WORKSHOP.with_options(entry_loss="on"))
        )
        finite = np.isfinite(on.total)
        assert np.array_equal(finite, np.isfinite(auto.total))
        assert (on.total[finite] <= auto.total[finite] * (1.0 + 1e-12)).all()
        assert (auto.total[finite] * (1.0 - ENTRY_LOSS_LEFT_OUT) <= on.total[finite]).all()
        for section, flow in auto.sections.items():
            np.testing.assert_allclose(on.sections[section], flow, rtol=ENTRY_LOSS_LEFT_OUT * 1.01, atol=0.0)
        flowing = finite & (on.total > 0.0)
        left_out.add(bool((auto.total[flowing] > on.total[flowing] * (1.0 + 1e-9)).any()))
    assert left_out == {False, True}  # some gaps are under the limit in all of this log, some are not


def test_a_wide_gap_does_not_slow_the_others_down(
    four_speed: Controller, hipol: Fluid, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One wide gap is computed on its own, beside the sum of the others, whose flow does not change."""
    wide = tuple(
        replace(state, radial_clearance=200e-6) if state.land.key == ("25", 1) else state
        for state in uneven(four_speed)
    )
    rng = np.random.default_rng(5)
    log = (rng.uniform(5e5, 9e5, 4000), 3e5, rng.uniform(60.0, 100.0, 4000), 2.0)
    calls = []
    flow = GapLaw.flow
    monkeypatch.setattr(GapLaw, "flow", lambda law, *factors: calls.append(law) or flow(law, *factors))
    without = replace(four_speed, gaps=tuple(gap for gap in four_speed.gaps if gap.key != ("25", 1)))
    only = replace(four_speed, gaps=tuple(gap for gap in four_speed.gaps if gap.key == ("25", 1)))
    totals = [leakage_series(LeakageModel(c, wide, hipol, WORKSHOP), *log).total for c in (four_speed, without, only)]
    assert len(calls) == 2  # once for the whole unit, once for the gap alone
    np.testing.assert_allclose(totals[0], totals[1] + totals[2], rtol=1e-13)


def test_auto_decides_by_the_whole_log_and_not_by_its_parts(four_speed: Controller, hipol: Fluid) -> None:
    """A gap that is past the limit at the log's end only is computed with its loss from the beginning."""
    pressure = np.full(70_000, 3e5)
    pressure[-1] = 15e5
    only = replace(four_speed, gaps=tuple(gap for gap in four_speed.gaps if gap.key == ("25", 1)))
    states = tuple(replace(state, radial_clearance=45e-6) for state in clearances(None, four_speed))
    exact, auto = (
        leakage_series(LeakageModel(only, states, hipol, profile), pressure, 2e5, 80.0, 2.0).total
        for profile in (WORKSHOP.with_options(entry_loss="on"), WORKSHOP)
    )
    np.testing.assert_allclose(auto[0], exact[0], rtol=1e-12)
    lone = leakage_series(LeakageModel(only, states, hipol, WORKSHOP), pressure[:10], 2e5, 80.0, 2.0).total
    assert lone[0] > exact[0] * (1.0 + 1e-4)


def test_a_log_without_any_usable_sample_gives_none(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    assert np.isnan(leakage_series(model, np.full(3, np.nan), np.nan, np.nan, 2.0).total).all()
