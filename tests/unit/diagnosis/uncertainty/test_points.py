"""The points that draws are made of: Sobol's, scrambled, and gone through by every land in an order of its own."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import assess
from atleak.diagnosis.uncertainty.draws import DIMENSIONS, Beside, Cube, Draws, directions, rounded_up
from atleak.diagnosis.uncertainty.propagation import DRAWS as DRAWS_FOR_USERS
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings

BITS = 10
DRAWS = 1 << BITS


def test_the_points_are_those_of_scipy() -> None:
    points = np.zeros((DIMENSIONS, DRAWS), np.int64)
    for k in range(BITS):
        points[:, 1 << k : 2 << k] = points[:, : 1 << k] ^ directions(BITS)[:, k, None]
    theirs = qmc.Sobol(DIMENSIONS, scramble=False).random_base2(BITS)
    assert {*map(tuple, points.T.tolist())} == {*map(tuple, (theirs * DRAWS).astype(int).tolist())}


def test_each_quantity_has_a_point_in_every_part_of_its_distribution() -> None:
    order = Beside(Cube(DRAWS, 3), np.random.default_rng(1).random(DRAWS)).draws(5)
    for draws in (Draws(Cube(DRAWS, 1)), order):
        assert np.array_equal(np.sort(draws.uniform()), (np.arange(DRAWS) + 0.5) / DRAWS)
        normal, rectangular = draws.normal(), draws.rectangular()
        assert [normal.mean(), normal.std()] == pytest.approx([0.0, 1.0], abs=2e-3)
        assert [rectangular.mean(), rectangular.std()] == pytest.approx([0.0, 1.0], abs=1e-6)
        assert np.abs(rectangular).max() < np.sqrt(3.0)


def test_two_quantities_of_one_cube_fill_every_box_of_their_plane_alike() -> None:
    cube = Cube(DRAWS, 11)
    draws = Draws(cube)
    first, second = draws.uniform(), draws.uniform()
    boxes = np.histogram2d(first, second, bins=32, range=[(0, 1), (0, 1)])[0]
    assert (boxes == 1).all()


def test_quantities_of_different_lands_have_nothing_in_common() -> None:
    own = Beside(Cube(4096, 3), np.random.default_rng(1).random(4096))
    lands = [own.draws(number) for number in range(12)]
    normals = [land.normal() for land in lands]
    for one, other in itertools.combinations(normals, 2):
        assert abs(np.corrcoef(one, other)[0, 1]) < 5.0 / np.sqrt(4096)


def test_what_is_a_lands_own_is_spread_alike_over_every_score() -> None:
    score = np.random.default_rng(1).random(DRAWS)
    uniform = Beside(Cube(DRAWS, 3), score).draws(5).uniform()
    eighth = np.argsort(score).reshape(8, -1)
    assert np.abs(uniform[eighth].mean(axis=1) - 0.5).max() < 0.005
    assert abs(np.corrcoef(score, uniform)[0, 1]) < 0.01


def test_a_seed_gives_the_same_draws_and_another_one_others() -> None:
    def drawn(seed: int) -> np.ndarray:
        return Draws(Cube(DRAWS, seed)).normal()

    assert np.array_equal(drawn(1), drawn(1))
    assert not np.array_equal(drawn(1), drawn(2))


def test_a_number_of_draws_is_rounded_up_to_a_power_of_two() -> None:
    assert [rounded_up(draws) for draws in (100, 1000, 1024, 1025, 8192)] == [128, 1024, 1024, 2048, 8192]


@pytest.mark.parametrize(
    ("conditions", "draws", "seeds", "most", "worst"),
    [
        pytest.param(1, 2048, 6, 0.08, 0.25, id="quick"),
        pytest.param(2, DRAWS_FOR_USERS, 40, 0.035, 0.06, id="as for users", marks=pytest.mark.slow),
    ],
)
def test_ends_of_intervals_hardly_depend_on_the_seed(
    four_speed: Controller,
    hipol: Fluid,
    limits: Limits,
    sample_readings: Path,
    conditions: int,
    draws: int,
    seeds: int,
    most: float,
    worst: float,
) -> None:
    """For users the ends scatter by some 0.03 u (standard deviation over seeds; root mean square over all lands)."""
    readings = read_readings(sample_readings, four_speed)
    states = clearances(readings, four_speed)
    model = LeakageModel(four_speed, states, hipol, WORKSHOP)
    projections = [project(model, point) for point in four_speed.operating_points[:conditions]]
    rules = unit_rules(states, projections, project_unworn(states, model, projections), limits)
    of_lands: list[list[tuple[float, float]]] = []
    of_total: list[list[tuple[float, float]]] = []
    for seed in range(seeds):
        unit = assess(model, states, projections, rules, readings=readings, draws=draws, seed=seed)
        at = [each for land in unit.lands for each in land.conditions if each.u_share > 0.0]
        of_lands.append([each.share_interval for each in at])
        of_total.append([each.share_interval for each in unit.totals])
    for ends, u in ((of_lands, [each.u_share for each in at]), (of_total, [each.u_share for each in unit.totals])):
        noise = np.std(ends, axis=0, ddof=1) / np.array(u)[:, None]
        assert np.sqrt((noise**2).mean(axis=0)).max() < most
        assert noise.max() < worst
