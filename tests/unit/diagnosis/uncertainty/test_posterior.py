"""Losses of circuits given what gauges showed: weights, proposals and causes, beside what is known without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import load_instruments
from atleak.diagnosis.missing import Cause
from atleak.diagnosis.uncertainty import DEFAULTS, Assumptions
from atleak.diagnosis.uncertainty.posterior import PosteriorUnit
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.diagnosis.uncertainty.wear import UnitWear
from atleak.diagnosis.uncertainty.weighing import Posterior, Shown
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings

DRAWS = 2048
CLUTCH = "clutch_a"


def unit_of(
    fluid: Fluid,
    assumptions: Assumptions = DEFAULTS,
    name: str = "zf_6hp26",
    gears: tuple[int, ...] = (1,),
    readings: Readings | None = None,
) -> PosteriorUnit:
    controller = load_controller(name)
    states = clearances(readings, controller)
    model = LeakageModel(controller, states, fluid, WORKSHOP)
    sources, _ = find_sources(states, readings, controller, load_instruments(), assumptions)
    points = [each for each in controller.operating_points if each.gear in gears]
    return PosteriorUnit(model, sources, assumptions, [project(model, each) for each in points])


@pytest.fixture
def unit(hipol: Fluid) -> PosteriorUnit:
    return unit_of(hipol)


def test_where_no_gauge_tells_anything_the_loss_is_that_of_what_is_assumed(unit: PosteriorUnit) -> None:
    point = next(iter(unit.conditions))
    vague = replace(unit.assumptions, main_pressure=1e3)
    unit.assumptions = vague
    lost = Posterior(unit, [Shown(point, CLUTCH, 500e3)], draws=DRAWS).lost(CLUTCH, point)
    assert lost.weights.sum() == pytest.approx(1.0, abs=1e-9)
    assert lost.effective == pytest.approx(DRAWS, rel=1e-3, abs=0.0)
    drawn = unit.draw(DRAWS)
    now, new = (unit.pressures(drawn, point, new=each)[CLUTCH] for each in (False, True))
    assert lost.probability_over(55e3) == pytest.approx(float(np.mean(new - now >= 55e3)), abs=1e-3)


def test_a_unit_of_which_nothing_can_be_worn_has_lost_nothing(hipol: Fluid) -> None:
    sound = replace(DEFAULTS, worn_lands=0.0, worn_seals=0.0, worn_pumps=0.0)
    unit = unit_of(hipol, sound)
    point = next(iter(unit.conditions))
    lost = Posterior(unit, [Shown(point, CLUTCH, 100e3)], draws=DRAWS).lost(CLUTCH, point)
    assert lost.draws == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("missing", [80e3, 200e3, 400e3])
def test_a_loss_that_an_exact_gauge_shows_is_what_is_said(hipol: Fluid, missing: float) -> None:
    unit = unit_of(hipol, replace(DEFAULTS, main_pressure=0.002))
    point = max(unit.conditions, key=lambda each: each.main_pressure)
    new = project(unit.model, point)
    shown = [
        Shown(point, "p_g", new.main_pressure_held),
        Shown(point, CLUTCH, new.circuit(CLUTCH).pressure - missing),
    ]
    lost = Posterior(unit, shown, draws=DRAWS).lost(CLUTCH, point)
    assert lost.quantile(0.5) == pytest.approx(missing, abs=20e3)
    assert lost.quantile(0.025) < lost.quantile(0.5) < lost.quantile(0.975)


def test_drawing_around_what_was_found_changes_how_well_it_is_known_not_what(hipol: Fluid) -> None:
    """Many draws of the prior alone say the same as few that are drawn again around what was found."""
    unit = unit_of(hipol)
    point = max(unit.conditions, key=lambda each: each.main_pressure)
    new = project(unit.model, point)
    shown = [Shown(point, "p_g", new.main_pressure_held), Shown(point, CLUTCH, new.circuit(CLUTCH).pressure - 120e3)]
    few, many = (Posterior(unit, shown, draws=draws).lost(CLUTCH, point) for draws in (1024, 32_768))
    assert len(many.draws) <= 32_768, "so many need no second round"
    assert few.quantile(0.5) == pytest.approx(many.quantile(0.5), abs=15e3)
    assert few.probability_over(55e3) == pytest.approx(many.probability_over(55e3), abs=0.1)


def test_a_split_adds_up_in_every_draw_and_names_lands_of_its_circuits(unit: PosteriorUnit) -> None:
    point = max(unit.conditions, key=lambda each: each.main_pressure)
    held = project(unit.model, point).circuit(CLUTCH).pressure
    split = Posterior(unit, [Shown(point, CLUTCH, held - 300e3)], draws=DRAWS).lost(CLUTCH, point).split
    assert sum(split.rows.values()) == pytest.approx(split.new - split.now, abs=1e-6)
    assert sum(split.flows.values()) == pytest.approx(split.growth, abs=1e-15)
    for row, lands in split.lands.items():
        assert sum(lands.values()) == pytest.approx(split.rows[row], abs=1e-6)
    of_circuit = {gap.key for gap in unit.model.controller.gaps if CLUTCH in (gap.high.section, gap.low.section)}
    assert set(split.lands[Cause.LANDS, CLUTCH]) <= of_circuit


def test_a_worn_seal_leaks_by_one_law_in_every_gear(hipol: Fluid) -> None:
    unit = unit_of(hipol, gears=(1, -1))
    points = [each for each in unit.conditions if each.state == "idle"]
    leaks = [unit._leak("seal", "brake_d", each, 5e-3, 0.5).flow(500e3) for each in points]
    assert len({each.gear for each in points}) == 2
    assert leaks[0] == pytest.approx(leaks[1], rel=1e-12, abs=0.0)


def test_a_measured_land_was_new_in_its_range_and_never_wider_than_it_is(
    hipol: Fluid, readings_of: Callable[..., Readings]
) -> None:
    controller = load_controller("zf_6hp26")
    narrow, wide = controller.lands[:2]
    sizes = {land.key: radial for land, radial in ((narrow, 12e-6), (wide, 45e-6))}
    diameters = {key: (0.012, 0.012 + 2.0 * radial) for key, radial in sizes.items()}
    unit = unit_of(hipol, readings=readings_of(controller, diameters))
    drawn = unit.draw(DRAWS).measured
    for land in (narrow, wide):
        now, new = drawn[land.key].bore.clearance, drawn[land.key].unworn_bore.clearance
        assert np.all(new <= now)
    low, high = wide.mounting_range
    assert np.all((low <= new) & (new <= high))
    unworn = drawn[narrow.key].unworn_bore.clearance == drawn[narrow.key].bore.clearance
    part, mean = UnitWear(unit.sources, unit.assumptions).usual
    assert part > unit.assumptions.worn_lands, "the other land is worn, so that the unit is"
    chance = part * -np.expm1(-(12e-6 - narrow.mounting_range[0]) / mean)
    assert np.mean(~unworn) == pytest.approx(chance / (chance + 1.0 - part), abs=0.03)
