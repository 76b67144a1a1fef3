"""The pressures that circuits hold, against formulas of their own, scipy's root finder and sweeps from above."""

from __future__ import annotations

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from atleak.catalogue.circuits import Following, Pressure, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.balance import BALANCED, Balance
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import Network
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.engine.restrictions import GapBranch
from atleak.equations import gap as gap_equations
from atleak.equations import orifice as orifice_equations
from atleak.measurements.clearances import clearances


def _referee() -> ModuleType:
    path = Path(__file__).with_name("circuit_referee.py")
    spec = importlib.util.spec_from_file_location("circuit_referee", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


referee = _referee()
DRAIN = referee.DRAIN
LINE = {"p_g": 414e3, "p_s": 200e3, "p_m": 100e3, "p_k": 150e3}
seeds = st.integers(0, 10**6)


@pytest.fixture(scope="module")
def point(three_circuits: Controller) -> OperatingPoint:
    return three_circuits.operating_points[0]


def drawn(controller: Controller, seed: int) -> tuple[Any, dict[str, float]]:
    """A random network, still as a builder, and pressures of its sections."""
    builder = referee.random_builder(controller, controller.operating_points[0], seed)
    return builder, referee.random_sections(np.random.default_rng(seed + 10**6))


def scaled(network: Network, factors: dict[str, Any]) -> Network:
    """The network with the gaps from some circuits to the sump wider or narrower."""
    lands = tuple(
        replace(branch, restriction=GapBranch(branch.restriction.conductance * factor, branch.restriction.bend))
        for branch in network.lands
        for factor in [factors.get(branch.high.section or "", 1.0) if branch.into_sump else 1.0]
    )
    return replace(network, lands=lands)


# --- known cases


@pytest.mark.parametrize(
    ("clearance_um", "kilopascals", "dm3_min"),
    [(13.0, 410.8596, 0.016643), (20.0, 389.1379, 0.057397), (35.0, 209.3679, 0.165505), (50.0, 90.3221, 0.208162)],
)
def test_a_fed_circuit_holds_the_pressure_of_the_worked_table(
    three_circuits: Controller, point: OperatingPoint, clearance_um: float, kilopascals: float, dm3_min: float
) -> None:
    conductance = gap_equations.annular_flow(1.0, 14.5e-3, clearance_um * 1e-6, 6.2e-6, 797.0, 5e-3)
    builder = referee.Builder(three_circuits, point)
    builder.circuit("c", ("p_g", 0.5e-3))
    builder.branches += [referee.gap("c", DRAIN, conductance)] * 2
    network = builder.network()
    balance = network.balance(LINE)
    assert balance.pressures["c"] / 1e3 == pytest.approx(kilopascals, abs=1e-4)
    assert balance.feeds["c"] * 60e3 == pytest.approx(dm3_min, abs=1e-6)
    assert network.drawn_from_pump(balance) == pytest.approx(balance.feeds["c"], rel=1e-9, abs=0.0)


@given(st.floats(1e-12, 1e-10), st.floats(1e5, 2e6))
def test_a_feed_that_is_turbulent_holds_what_the_closed_form_says(
    three_circuits: Controller, conductance: float, source: float
) -> None:
    builder = referee.Builder(three_circuits, three_circuits.operating_points[0])
    builder.circuit("c", ("p_g", 0.5e-3))
    builder.branches.append(referee.gap("c", DRAIN, conductance))
    feed = builder.feeds[0].restriction
    builder.feeds[0] = replace(builder.feeds[0], restriction=replace(feed, transition=1e-3))
    held = builder.network().balance({**LINE, "p_g": source}).pressures["c"]
    closed = orifice_equations.fed_pressure_turbulent(source, feed.coefficient, conductance)
    assert held == pytest.approx(closed, rel=1e-9, abs=0.0)


def test_without_any_leak_a_circuit_holds_its_source_or_its_set_pressure(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("free", ("p_g", 1e-3))
    builder.circuit("behind", ("free", 1e-3))
    builder.circuit("set", ("p_g", 1e-3), limit=100e3)
    builder.circuit("over", ("p_g", 1e-3), limit=900e3)
    builder.circuit("supplied", limit=900e3)
    builder.circuit("vented", ("p_g", 1e-3), vented=True)
    balance = builder.network().balance(LINE)
    held = {name: balance.pressures[name] for name in ("free", "behind", "set", "over", "supplied", "vented")}
    expected = {"free": 414e3, "behind": 414e3, "set": 100e3, "over": 414e3, "supplied": 414e3, "vented": 0.0}
    assert held == pytest.approx(expected, rel=1e-12, abs=0.0)
    assert set(balance.feeds.values()) | set(balance.relief.values()) == {0.0}
    assert balance.converged is True


def test_without_line_pressure_no_circuit_has_any(three_circuits: Controller) -> None:
    for seed in range(5):
        builder, _ = drawn(three_circuits, seed)
        builder.circuits = [each for each in builder.circuits if each.set_pressure is None or each.feeds]
        balance = scaled(builder.network(), {}).balance(dict.fromkeys(LINE, 0.0))
        assert set(balance.pressures.values()) == {0.0}
        assert balance.converged is True


# --- against the referee


@given(seeds)
def test_every_circuit_balances_by_formulas_of_its_own(three_circuits: Controller, seed: int) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    balance = network.balance(sections)
    assert balance.converged is True
    errors = referee.Referee(network, sections).errors(balance.pressures)
    assert max(errors.values(), default=0.0) <= BALANCED


@given(seeds)
def test_what_leaves_the_sections_is_what_reaches_the_sump(three_circuits: Controller, seed: int) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    balance = network.balance(sections)
    account = referee.Referee(network, sections).account(balance.pressures)
    largest = account["largest"][""]
    for name in balance.feeds:
        assert balance.feeds[name] == pytest.approx(account["fed"][name], rel=0.0, abs=BALANCED * largest)
    for name in balance.relief:
        assert balance.relief[name] == pytest.approx(account["relief"][name], rel=0.0, abs=BALANCED * largest)
    supplied = sum(account["out"][name] - account["in"][name] for name in sections)
    reached = account["in"]["sump"] + sum(balance.relief.values())
    assert supplied == pytest.approx(reached, rel=0.0, abs=6 * BALANCED * largest)
    into_sump = network.drawn_from_pump(balance)
    assert into_sump == pytest.approx(reached, rel=0.0, abs=6 * BALANCED * largest)


@pytest.mark.parametrize("seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(10, 40))])
def test_sweeps_from_above_and_scipy_end_at_the_same_pressures(three_circuits: Controller, seed: int) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    held = network.balance(sections).pressures
    other = referee.Referee(network, sections)
    swept = other.from_above(300)
    if swept is not None:
        for name in other.live:
            assert held[name] == pytest.approx(swept[name], rel=0.0, abs=1e-8 * other.top)
    solved = other.by_scipy(swept or held)
    for name in other.live:
        assert held[name] == pytest.approx(solved[name], rel=0.0, abs=1e-7 * other.top)


# --- properties


@given(seeds)
def test_no_pressure_is_negative_above_its_set_pressure_or_above_every_section(
    three_circuits: Controller, seed: int
) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    held = network.balance(sections).pressures
    other = referee.Referee(network, sections)
    for name in other.live:
        assert 0.0 <= held[name] <= min(other.limit(name, held), other.top) * (1.0 + 1e-12)
    assert all(held[name] == 0.0 for name in other.vented)


@given(seeds, st.floats(1.01, 30.0))
def test_pressures_fall_with_every_clearance_to_the_sump(three_circuits: Controller, seed: int, factor: float) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    before = network.balance(sections).pressures
    for name in [each.id for each in network.applied]:
        after = scaled(network, {name: factor}).balance(sections).pressures
        for other in before:
            assert after[other] <= before[other] + 1e-9 * max(sections.values())


@given(seeds, st.floats(-14.0, -9.0))
def test_a_gap_between_live_circuits_lowers_the_upper_and_raises_the_lower(
    three_circuits: Controller, seed: int, size: float
) -> None:
    """Whichever way round the file names its ends: it leaks both ways. No circuit here is set by another's pressure."""
    rng = np.random.default_rng(seed)
    builder = referee.Builder(three_circuits, three_circuits.operating_points[0])
    for name in ("a", "b"):
        builder.circuit(name, ("p_g", float(rng.uniform(0.3e-3, 2e-3))))
        builder.branches.append(referee.gap(name, DRAIN, 10.0 ** rng.uniform(-12.0, -10.0)))
    apart = builder.network().balance(LINE).pressures
    joined = []
    for ends in (("a", "b"), ("b", "a")):
        both = replace(builder, branches=[*builder.branches, referee.gap(*ends, 10.0**size)])
        joined.append(both.network().balance(LINE).pressures)
    assert joined[0] == pytest.approx(joined[1], rel=1e-9, abs=0.0)
    lower, upper = sorted("ab", key=lambda name: apart[name])
    assert joined[0][lower] >= apart[lower] * (1.0 - 1e-12)
    assert joined[0][upper] <= apart[upper] * (1.0 + 1e-12)
    assert joined[0][lower] <= joined[0][upper] * (1.0 + 1e-9)


@given(seeds, st.sampled_from([(), (1,), (3,), (2, 2)]))
def test_arrays_of_any_shape_give_what_numbers_give_one_by_one(
    three_circuits: Controller, seed: int, shape: tuple[int, ...]
) -> None:
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    factors = np.random.default_rng(seed).uniform(0.5, 20.0, shape)
    name = builder.circuits[0].id
    many = {section: pressure * np.ones(shape[-1:]) for section, pressure in sections.items()}
    stacked = scaled(network, {name: factors}).balance(many)
    for index in np.ndindex(shape):
        one = scaled(network, {name: float(factors[index])}).balance(sections)
        for kind in ("pressures", "feeds", "relief"):
            scale = max(sections.values()) if kind == "pressures" else max(map(abs, one.feeds.values()), default=1.0)
            for at, value in getattr(one, kind).items():
                whole = np.broadcast_to(getattr(stacked, kind)[at], shape)
                assert whole[index] == pytest.approx(value, rel=0.0, abs=1e-8 * scale)
    assert np.all(stacked.converged)


@given(seeds)
@example(245)
def test_many_columns_that_start_from_the_mean_of_a_few_give_what_numbers_give(
    three_circuits: Controller, seed: int
) -> None:
    """However unlike the columns are, and whatever some of them lack."""
    builder, sections = drawn(three_circuits, seed)
    network, rng, name = builder.network(), np.random.default_rng(seed), builder.circuits[0].id
    factors, falls = rng.uniform(0.01, 20.0, 700), rng.choice([0.0, 0.3, 1.0, math.nan], 700)
    many = scaled(network, {name: factors}).balance({key: pressure * falls for key, pressure in sections.items()})
    assert many.converged.tolist() == np.isfinite(falls).tolist()
    for index in rng.choice(np.flatnonzero(np.isfinite(falls)), 5):
        at = {key: pressure * float(falls[index]) for key, pressure in sections.items()}
        one = scaled(network, {name: float(factors[index])}).balance(at)
        for circuit, pressure in one.pressures.items():
            held = np.broadcast_to(many.pressures[circuit], factors.shape)[index]
            assert held == pytest.approx(pressure, rel=0.0, abs=1e-7 * max(sections.values()))  # 0.05 Pa of 500 kPa


def test_gaps_between_the_same_pressures_leak_what_they_leak_together(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    """One that the fluid must pass quickly bends its flow, and so they are no single wider gap."""
    builder = referee.Builder(three_circuits, point)
    builder.circuit("c", ("p_g", 1.0e-3))
    gaps = [referee.gap("c", DRAIN, 3e-12, 2e-5), referee.gap("c", DRAIN, 5e-12), referee.gap("c", DRAIN, 1e-12, 1e-3)]
    builder.branches += gaps
    held = builder.network().balance(LINE)
    leaving = math.fsum(float(each.restriction.flow(held.pressures["c"])) for each in gaps)
    assert held.feeds["c"] == pytest.approx(leaving, rel=1e-9, abs=0.0)


@given(seeds)
def test_a_balance_near_another_one_is_the_same_as_anew(three_circuits: Controller, seed: int) -> None:
    """Whatever the other one was: some columns stay as they are, and some lose all pressure or gain some."""
    builder, sections = drawn(three_circuits, seed)
    network = builder.network()
    factors = np.array([1.0, 0.999, 0.0, 0.5, 1.3])
    at_once = {name: pressure * np.ones(len(factors)) for name, pressure in sections.items()}
    changed = {name: pressure * factors for name, pressure in sections.items()}
    anew, near = network.balance(changed), network.balance(changed, network.balance(at_once))
    for kind in ("pressures", "feeds", "relief"):
        largest = max([values.max() for values in anew.feeds.values()] + [1e-12])  # [m³/s]: next to nothing flows
        scale = max(sections.values()) if kind == "pressures" else largest
        for name, values in getattr(anew, kind).items():
            assert getattr(near, kind)[name] == pytest.approx(values, rel=0.0, abs=1e-7 * scale)  # 0.05 Pa of 500 kPa
    assert np.all(near.converged)


def test_where_no_section_changes_a_balance_is_taken_over(three_circuits: Controller, hipol: Fluid) -> None:
    model = LeakageModel(three_circuits, clearances(None, three_circuits), hipol, WORKSHOP)
    network = model.network(three_circuits.operating_points[0])
    known = network.balance(LINE)
    marked = replace(known, feeds={name: feed + 1.0 for name, feed in known.feeds.items()})
    assert network.balance(LINE, marked).feeds == marked.feeds
    assert network.balance({**LINE, "p_g": 400e3}, marked).feeds != marked.feeds


def test_numbers_give_numbers_and_an_array_gives_arrays_of_its_shape(three_circuits: Controller, hipol: Fluid) -> None:
    model = LeakageModel(three_circuits, clearances(None, three_circuits), hipol, WORKSHOP)
    network = model.network(three_circuits.operating_points[0])
    assert {type(pressure) for pressure in network.balance(LINE).pressures.values()} == {float}
    for shape in ((5,), (2, 3), (1,)):
        balance = network.balance({**LINE, "p_g": np.full(shape, 414e3)})
        for circuit in three_circuits.circuits:
            if circuit.id not in network.vented:
                assert np.shape(balance.pressures[circuit.id]) == shape
                assert np.shape(balance.feeds[circuit.id]) == shape
        assert np.shape(balance.converged) == shape


def test_a_sample_that_is_not_a_number_leaves_the_others_as_they_are(three_circuits: Controller, hipol: Fluid) -> None:
    model = LeakageModel(three_circuits, clearances(None, three_circuits), hipol, WORKSHOP)
    network = model.network(three_circuits.operating_points[0])
    balance = network.balance({**LINE, "p_g": np.array([414e3, math.nan, 700e3])})
    assert balance.converged.tolist() == [True, False, True]
    assert np.isnan(balance.pressures["clutch_c1"]).tolist() == [False, True, False]
    alone = network.balance({**LINE, "p_g": 700e3}).pressures
    assert balance.pressures["clutch_c1"][2] == pytest.approx(alone["clutch_c1"], rel=1e-9, abs=0.0)


# --- regulators, chains and vents


def test_a_regulator_takes_from_the_circuit_that_feeds_it_only_what_is_drawn(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("upper", ("p_g", 0.5e-3))
    builder.circuit("lower", ("upper", 1e-3), limit=100e3)
    builder.branches.append(referee.gap("lower", DRAIN, 1e-12))
    builder.branches.append(referee.gap("upper", DRAIN, 2e-12))
    held = builder.network().balance(LINE)
    assert held.pressures["lower"] == pytest.approx(100e3, rel=1e-12, abs=0.0)
    assert held.feeds["lower"] == pytest.approx(1e-12 * 100e3, rel=1e-9, abs=0.0)
    leaked = 2e-12 * held.pressures["upper"] + held.feeds["lower"]
    assert held.feeds["upper"] == pytest.approx(leaked, rel=1e-9, abs=0.0)


def test_a_circuit_at_its_set_pressure_relieves_what_others_push_into_it(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("c", ("p_g", 0.5e-3), limit=100e3)
    builder.branches += [referee.gap("c", DRAIN, 1e-12), referee.gap("p_g", "c", 2e-12)]
    network = builder.network()
    held = network.balance(LINE)
    pushed = 2e-12 * 314e3 - 1e-12 * 100e3
    assert held.relief["c"] == pytest.approx(pushed, rel=1e-9, abs=0.0)
    assert held.feeds["c"] == 0.0
    assert network.drawn_from_pump(held) == pytest.approx(2e-12 * 314e3, rel=1e-9, abs=0.0)


def test_a_vented_circuit_lets_out_what_leaks_into_it_also_through_a_feed(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("off", ("p_g", 1e-3), vented=True)
    builder.circuit("on", ("p_g", 1e-3), ("off", 0.5e-3))
    builder.branches += [referee.gap("p_g", "off", 1e-12), referee.gap("off", "on", 3e-12)]
    network = builder.network()
    held = network.balance(LINE)
    back = builder.feeds[1].restriction.flow(held.pressures["on"])
    leaked = 1e-12 * 414e3 + 3e-12 * held.pressures["on"] + back
    assert held.relief["off"] == pytest.approx(leaked, rel=1e-9, abs=0.0)
    assert network.drawn_from_pump(held) == pytest.approx(leaked, rel=1e-9, abs=0.0)
    assert back > 1e-12 * 414e3


@pytest.mark.parametrize("ratio", [0.5, 2.5])
def test_a_set_pressure_follows_a_worn_circuit_down(
    three_circuits: Controller, point: OperatingPoint, ratio: float
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("epc", ("p_g", 0.5e-3), limit=150e3)
    following = SetPressure(following=Following("epc", ratio, 10e3))
    builder.circuit("fed", ("p_g", 2e-3), limit=following)
    builder.circuit("supplied", limit=following)
    builder.branches.append(referee.gap("fed", DRAIN, 1e-13))
    for conductance in (0.0, 1e-11, 3e-11, 1e-10):
        worn = replace(builder, branches=[*builder.branches, referee.gap("epc", DRAIN, conductance)])
        held = worn.network().balance(LINE).pressures
        expected = min(ratio * held["epc"] + 10e3, LINE["p_g"])
        assert held["supplied"] == pytest.approx(expected, rel=1e-12, abs=0.0)
        assert held["fed"] == pytest.approx(expected, rel=1e-3, abs=0.0)
        assert (held["epc"] < 150e3 * (1.0 - 1e-9)) == (conductance > 2e-11)


def test_a_circuit_may_feed_the_one_that_its_set_pressure_follows(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    """Whichever of the two the file names first, the one that feeds comes first."""
    held = []
    for order in (1, -1):
        builder = referee.Builder(three_circuits, point)
        following = SetPressure(following=Following("signal", 0.5, 150e3))
        builder.circuit("clutch", ("p_g", 1e-3), limit=following)
        builder.circuit("signal", ("clutch", 0.5e-3))
        builder.branches += [referee.gap("clutch", DRAIN, 1e-12), referee.gap("signal", DRAIN, 2e-11)]
        builder.circuits = builder.circuits[::order]
        network = builder.network()
        assert [each.id for each in network.applied] == ["clutch", "signal"]
        held.append(network.balance(LINE))
    pressures = held[0].pressures
    assert pressures["clutch"] == pytest.approx(0.5 * pressures["signal"] + 150e3, rel=1e-9, abs=0.0)
    assert held[0].feeds["signal"] == pytest.approx(2e-11 * pressures["signal"], rel=1e-9, abs=0.0)
    drawn = 1e-12 * pressures["clutch"] + held[0].feeds["signal"]
    assert held[0].feeds["clutch"] == pytest.approx(drawn, rel=1e-9, abs=0.0)
    assert held[1].pressures == pytest.approx(held[0].pressures, rel=1e-9, abs=0.0)


def test_what_ends_in_the_sump_or_is_a_share_of_a_pressure_leaks_nothing_back(
    three_circuits: Controller, point: OperatingPoint
) -> None:
    builder = referee.Builder(three_circuits, point)
    builder.circuit("c", ("p_s", 0.5e-3))
    alone = builder.network().balance(LINE).pressures["c"]
    into_sump = replace(referee.gap("c", "p_g", 1e-11), into=None, counts=True)
    for branch in (
        referee.gap("c", Pressure(0.9, "p_g"), 1e-11),
        referee.gap(Pressure(0.5, "c"), "p_g", 1e-11),
        referee.gap("c", Pressure(0.0, None, 300e3), 1e-11),
        into_sump,
    ):
        closed = replace(builder, branches=[branch]).network()
        assert closed.balance(LINE).pressures["c"] == pytest.approx(alone, rel=1e-12, abs=0.0)
        assert closed.drawn_from_pump(closed.balance(LINE)) == 0.0
    both_ways = replace(builder, branches=[referee.gap("c", "p_g", 1e-11)]).network()
    assert both_ways.balance(LINE).pressures["c"] > alone * 1.1


def test_with_the_balance_switched_off_circuits_hold_what_they_are_set_to_or_fed_with(
    three_circuits: Controller, hipol: Fluid
) -> None:
    worn = tuple(replace(state, radial_clearance=80e-6) for state in clearances(None, three_circuits))
    for profile in (PAPER, WORKSHOP.with_options(circuits="off")):
        network = LeakageModel(three_circuits, worn, hipol, profile).network(three_circuits.operating_points[0])
        held = network.balance(LINE).pressures
        expected = {"epc": 200e3, "clutch_c1": 414e3, "clutch_c2": 0.0, "lock_up": 150e3, "signal": 100e3}
        assert {name: held[name] for name in expected} == pytest.approx(expected, rel=1e-12, abs=0.0)


def test_a_controller_without_circuits_has_the_pressures_of_its_sections(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    balance = model.network(four_speed.operating_points[0]).balance(LINE)
    assert balance == Balance(LINE, {}, {}, True)
