"""The coverage benchmark, small: that it runs, repeats itself and would notice a wrong interval."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.equations.clearance import one_sided_moments
from atleak.measurements.clearances import clearances

DRAWS = 500


@pytest.fixture(scope="module")
def benchmark(benchmark_of: Callable[[str], ModuleType]) -> ModuleType:
    return benchmark_of("coverage")


# lands of one unit share an error: the standard error is about 1 % with 150 units, 3 % with 20
@pytest.mark.parametrize(("units", "tolerance"), [(20, 8.0), pytest.param(150, 3.0, marks=pytest.mark.slow)])
def test_intervals_hold_the_truth(benchmark: ModuleType, units: int, tolerance: float) -> None:
    counted = benchmark.count_world(benchmark.AS_DECLARED, range(units), 2 * DRAWS)
    rates = benchmark.world_rates(benchmark.AS_DECLARED, counted)
    for name in ("clearance", "leakage", "share"):
        assert rates["coverage"][name] == pytest.approx(95.0, abs=tolerance)
    for rule in rates["rules"].values():
        assert rule["pass_truly_over"] <= 5.0
        assert rule["decided_wrongly"] < rule["unguarded_wrong"]
    again = benchmark.count_world(benchmark.AS_DECLARED, range(units), 2 * DRAWS)
    assert again == counted


def test_a_worse_instrument_than_declared_is_noticed(benchmark: ModuleType) -> None:
    world = next(world for world in benchmark.WORLDS if world.calibration == 2.0)
    rates = benchmark.world_rates(world, benchmark.count_world(world, range(60), DRAWS))
    assert rates["coverage"]["clearance"] < 85.0
    as_if_declared = rates | {"world": benchmark.AS_DECLARED.name}
    assert any(name in text for text in benchmark.world_failures(as_if_declared, 0.0) for name in ("clearance", "leak"))


def test_a_pair_worn_to_one_side_has_the_mean_cube_of_its_closed_form(benchmark: ModuleType) -> None:
    from simulated.pairs import Form, Pair

    round_form = Form(0.0, 0.0, 0.0, 0.0)
    land = load_controller("four_speed_2023").lands[0]
    pair = Pair(land, 14e-3, 20e-6, 10e-6, 0.8, 0.7, 9e-3, {"spool": round_form, "sleeve": round_form})
    sharp, w = replace(pair, exponent=3), 8e-6
    square, cube = one_sided_moments(w, 3.0)
    assert np.mean(sharp.around() ** 3) == pytest.approx(30e-6**3 + 3.0 * 30e-6 * square + cube, rel=1e-4, abs=0.0)
    around = [sharp.diameter("sleeve", direction, 0.0) for direction in np.arange(0.0, 180.0, 1.0)]
    assert np.mean(around) - pair.spool == pytest.approx(2.0 * pair.clearance, abs=1e-9)
    even, deepest = 20e-6 + 0.2 * 10e-6, math.pi * 0.8 * 10e-6
    # of h = max(cos θ, 0): E h = 1/π, E h² = 1/4, E h³ = 2/(3π)
    cube = (
        even**3 + 3.0 * even**2 * deepest / math.pi + 3.0 * even * deepest**2 / 4.0 + deepest**3 * 2.0 / 3.0 / math.pi
    )
    assert np.mean(pair.around() ** 3) == pytest.approx(cube, rel=1e-4, abs=0.0)
    eccentric = replace(pair, wear=0.0, eccentricity=0.5)
    assert np.mean(eccentric.around() ** 3) == pytest.approx(20e-6**3 * (1.0 + 1.5 * 0.5**2), rel=1e-9, abs=0.0)
    # two opposite points see the sum of both sides; around the bore they see the mean
    around = [pair.diameter("sleeve", direction, 0.0) for direction in np.arange(0.0, 180.0, 1.0)]
    assert np.mean(around) - pair.spool == pytest.approx(2.0 * pair.clearance, abs=1e-9)
    assert pair.diameter("sleeve", math.degrees(0.7), 0.0) == pytest.approx(14e-3 + 2.0 * even + deepest, abs=1e-12)


def test_the_population_is_the_same_whatever_the_file_knows_of_new(benchmark: ModuleType) -> None:
    from simulated import population

    worn = next(unit for unit in range(10) if not population.simulate(population.Known.PAIR, unit).is_new)
    known, other = (population.simulate(case, worn) for case in (population.Known.PAIR, population.Known.RANGE))
    assert known.pairs == other.pairs
    assert known.diagnosis.readings == other.diagnosis.readings
    assert {pair.mounting for pair in known.pairs} != {
        land.mounting_clearance for land in known.diagnosis.controller.lands
    }
    case = population.Known.PAIR, "as assumed", (0.0, 90.0), population.WITHOUT_CIRCUITS
    rates = benchmark.population_rates("a name", benchmark.count_population(*case, range(worn, worn + 1)))
    assert rates["unworn"]["lands"] + rates["worn"]["lands"] == len(known.pairs)
    assert sum(rates["worn"][name] for name in ("pass", "conditional", "flagged")) == pytest.approx(100.0, abs=1e-9)
    impossible = rates | {"unworn": {"pass": 80.0, "flagged": 2.0}}
    assert len(benchmark.population_failures(impossible, 0.0)) >= 2


def test_true_pressures_are_those_of_the_gaps_of_the_true_unit(benchmark: ModuleType) -> None:
    """Unworn and round bores at the stated condition hold what the engine computes for the file's own clearances."""
    from simulated.flows import Circumstances, flows_in_circuits
    from simulated.pairs import Form, Pair

    controller, forms = load_controller("five_speed_2005"), dict.fromkeys(("spool", "sleeve"), Form(0.0, 0.0, 0.0, 0.0))
    fluid, point = load_fluid("hipol_atf_iid"), controller.operating_points[1]
    pairs = [
        Pair(
            land,
            land.nominal_diameter,
            13e-6,
            0.0,
            0.0,
            0.0,
            land.contact_length,
            forms,
        )
        for land in controller.lands
    ]
    true = flows_in_circuits(pairs, controller, fluid, point, Circumstances(0.0, 0.0, 0.0, 0.0, 0.0), DEFAULTS)
    states = [replace(each, radial_clearance=13e-6) for each in clearances(None, controller)]
    said = project(LeakageModel(controller, tuple(states), fluid, WORKSHOP), point)
    assert true.total == pytest.approx(said.leakage, rel=1e-2, abs=0.0)
    for each in said.circuits:
        if each.circuit.feeds:
            assert true.pressures[each.circuit.id] == pytest.approx(each.pressure, rel=1e-3, abs=0.0)
