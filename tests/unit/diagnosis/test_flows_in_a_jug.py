"""Flows caught in a jug: bound or measurement, right as often as said, against a truth and integrals of their own."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import DEFAULT_LIMITS, load_limits
from atleak.common.units import DM3_MIN
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.flows import left_for, left_over, log_likelihood
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.flows import FlowKind, flows_at
from atleak.engine.operation import Operation
from atleak.measurements.flow_readings import FlowReading, FlowTable

USUAL = 3.8 / DM3_MIN


def found(*readings: tuple[str, str, float], controller: str = "five_speed_2005") -> Diagnosis:
    table = FlowTable("f.csv", "0", None, tuple(FlowReading(at, what, flow / DM3_MIN) for at, what, flow in readings))
    return diagnose(load_controller(controller), load_fluid("hipol_atf_iid"), load_limits(DEFAULT_LIMITS), flows=table)


def test_as_usual_it_is_a_bound_and_below_it_a_measurement() -> None:
    usual, short = found(("hot_idle", "cooler", 3.7), ("hot_idle", "converter_and_cooler", 1.5)).flows
    assert (usual.bound, short.bound) == (True, False)
    assert usual.usual == short.usual == pytest.approx(USUAL, abs=0.0)
    assert usual.left_low * DM3_MIN == pytest.approx(3.7 * (1 - 2.241 * 0.04), abs=0.0)
    assert math.isinf(usual.left_high)
    assert (short.left_low + short.left_high) / 2 * DM3_MIN == pytest.approx(1.5, abs=0.0)
    assert (usual.condition, usual.what, short.what) == ("hot_idle", "cooler", "converter_and_cooler")


def test_what_is_short_is_told_and_what_is_unknown_too() -> None:
    codes = {each.code: each.level for each in found(("hot_idle", "cooler", 1.5)).messages}
    assert codes["flow_below_usual"] == "warning"
    assert "flow_below_usual" not in {each.code for each in found(("hot_idle", "cooler", 3.7)).messages}
    unknown = found(("hot_idle", "cooler", 1.5), controller="four_speed_2023")
    assert unknown.flows[0].bound
    assert (unknown.flows[0].usual, unknown.flows[0].computed) == (None, None)
    assert "flow_without_usual" in {each.code for each in unknown.messages}


def test_a_consumer_before_the_regulator_only_bounds() -> None:
    controller = load_controller("five_speed_2005")
    before = tuple(replace(each, after_line=False) for each in controller.consumers)
    table = FlowTable("f.csv", "0", None, (FlowReading("hot_idle", "cooler", 1.0 / DM3_MIN),))
    unit = replace(controller, consumers=before)
    assert diagnose(unit, load_fluid("hipol_atf_iid"), load_limits(DEFAULT_LIMITS), flows=table).flows[0].bound


def test_without_a_table_nothing_changes() -> None:
    bare = diagnose(load_controller("five_speed_2005"), load_fluid("hipol_atf_iid"), load_limits(DEFAULT_LIMITS))
    assert (bare.flows, bare.flow_table) == ((), None)


@pytest.mark.parametrize("slower", [1.0, 0.42, 0.3])
def test_what_the_line_leaves_is_what_the_flows_from_the_pump_leave(slower: float) -> None:
    """Of the pump's flow nothing else is left when slip, lands, leaks and all other consumers are taken off."""
    model = found(("hot_idle", "cooler", 3.7)).model
    point = next(each for each in model.controller.operating_points if each.name == "hot_idle")
    point = replace(point, engine_speed=point.engine_speed * slower)
    cooler, *others = model.controller.consumers
    from_pump = [each for each in flows_at(model, point).flows if each.source.kind is FlowKind.PUMP]
    supply = sum(each.flow for each in from_pump)
    to_line_and_slip = sum(each.flow for each in from_pump if each.target.kind in (FlowKind.SECTION, FlowKind.SLIP))
    left = supply - to_line_and_slip - sum(each.at(point) for each in others)
    assert left_for(Operation.of(model, point), cooler) == pytest.approx(max(left, 0.0), rel=1e-6, abs=1e-10)
    if slower < 1.0:
        assert left_for(Operation.of(model, point), cooler) < cooler.at(point)


def test_it_is_vectorised_over_draws() -> None:
    model = found(("hot_idle", "cooler", 3.7)).model
    point = next(each for each in model.controller.operating_points if each.name == "hot_idle")
    at = Operation.of(model, point)
    cooler = model.controller.consumers[0]
    two: Any = SimpleNamespace(
        model=at.model, point=at.point, network=at.network, held=at.held, viscosity=np.array([0.5, 1.0]) * at.viscosity
    )
    left = left_for(two, cooler)
    assert left.shape == (2,)
    assert left[0] < left[1] == pytest.approx(float(left_for(at, cooler)), abs=0.0)


# --- how often it is right


@pytest.mark.parametrize("spread", ["normal", "uniform"])
@pytest.mark.parametrize("left", [0.0, 0.05, 0.3, 0.5, 0.58, 0.62, 0.7, 0.8, 0.9, 1.0, 1.2, 2.0])
def test_the_interval_covers_what_is_left(left: float, spread: str) -> None:
    """A truth of its own: every flow as it is caught, at every state of the line, not on average alone."""
    random, draws = np.random.default_rng(11), 4000
    own = random.normal(1.0, 0.2, draws) if spread == "normal" else random.uniform(0.8, 1.2, draws)
    flow = np.minimum(own, left)
    caught = np.maximum(flow + random.normal(0.0, 1.0, draws) * 0.04 * np.maximum(flow, 0.1), 0.0)
    ends = np.array([left_over(each, 1.0, 0.2, 0.04) for each in caught])
    covered = (ends[:, 0] <= left) & (left <= ends[:, 1])
    assert covered.mean() >= 0.93
    if left >= 1.2:
        assert np.isinf(ends[:, 1]).mean() > 0.95
    elif left <= 0.5:
        assert np.isfinite(ends[:, 1]).mean() > 0.95
        assert np.ptp(ends, axis=1).max() < 0.25


def test_without_a_usual_flow_it_is_a_bound() -> None:
    assert left_over(2.0, None, 0.2, 0.04) == (pytest.approx(2.0 * (1.0 - 2.241 * 0.04), abs=0.0), math.inf)


# --- the likelihood


@pytest.mark.parametrize("measured", [0.0, 0.03, 0.5, 0.9, 1.3])
@pytest.mark.parametrize("left", [0.0, 0.2, 0.5, 0.9, 1.1, 3.0, math.inf])
def test_the_likelihood_is_the_integral_over_the_usual_flow(measured: float, left: float) -> None:
    error = 0.04 * max(measured, 0.1)

    def density(own: float) -> float:
        return float(norm.pdf(own, 1.0, 0.2) * norm.pdf(measured, min(own, left), error))

    ends = sorted({-1.0, measured - 8 * error, measured, measured + 8 * error, min(left, 3.0), 3.0})
    whole = sum(quad(density, *pair, epsabs=1e-14)[0] for pair in itertools.pairwise(ends))
    given = float(np.exp(log_likelihood(measured, left, 1.0, 0.2, 0.04)))
    assert given == pytest.approx(whole, rel=1e-5, abs=1e-9)


def test_the_likelihood_is_a_density_of_each_draw() -> None:
    left, usual = np.array([0.4, 0.9, 2.0]), np.array([0.9, 1.0, 1.1])
    grid = np.linspace(-1.0, 3.0, 40001)
    made = np.array([log_likelihood(each, left, usual, 0.2, 0.04) for each in grid[::8]])
    assert made.shape == (5001, 3)
    # the error is taken at the flow that was caught, so that the sum differs from 1 by its square
    assert np.exp(made).sum(axis=0) * (grid[8] - grid[0]) == pytest.approx(1.0, abs=0.01)
    assert np.isfinite(log_likelihood(0.0, np.array([0.0, 50.0]), 1.0, 0.2, 0.04)).all()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("spread", "jug"), [(0.0, 0.04), (0.2, 0.0), (0.0, 0.0)])
def test_a_flow_that_is_taken_as_exact_has_a_likelihood_too(spread: float, jug: float) -> None:
    left = np.array([0.0, 0.5, 0.6, 2.0, math.inf])
    assert np.isfinite(log_likelihood(0.5, left[:-1], 1.0, spread, jug)).all()
    assert np.argmax(log_likelihood(0.5, left, 1.0, spread, jug)) == 1
    low, high = left_over(0.5, 1.0, spread, jug)
    assert low < 0.5 < high < math.inf


def test_the_assumptions_are_settable() -> None:
    assert DEFAULTS.settings["consumer_flow_percent"] == 20.0
    assert DEFAULTS.settings["caught_flow_percent"] == 4.0
    controller = load_controller("five_speed_2005")
    table = FlowTable("f.csv", "0", None, (FlowReading("hot_idle", "cooler", 3.0 / DM3_MIN),))
    sure = DEFAULTS.with_settings({"consumer_flow_percent": 5, "caught_flow_percent": 1})
    limits, fluid = load_limits(DEFAULT_LIMITS), load_fluid("hipol_atf_iid")
    assert diagnose(controller, fluid, limits, flows=table).flows[0].bound
    assert not diagnose(controller, fluid, limits, flows=table, assumptions=sure).flows[0].bound
