"""Verdicts on units that are not the source study's: new ones are green, worn ones are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid, fluids, load_fluid
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import Rule, unit_rules
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PROFILES, Profile
from atleak.engine.projection import project, project_unworn
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings
from tests.unit.conftest import by_turns

Build = Callable[..., Readings]
UM = 1e-6


def known_by_range() -> Controller:
    """The source study's valve body as a shop would know a modern one: new pairs lie between 6.4 and 20 µm."""
    study = load_controller("four_speed_2023")
    lands = (replace(each, mounting_clearance=(6.4 * UM, 20 * UM), new_origin=NewOrigin.RANGE) for each in study.lands)
    return replace(study, id="known_by_range", lands=tuple(lands))


UNITS = {each.id: each for each in (*controllers(), known_by_range())}
IN_EVERY_ROUND = ("four_speed_2023", "five_speed_2005", "minimal_example", "known_by_range")
every_unit = pytest.mark.parametrize(  # test_units_with_circuits judges all of them without the draws
    ("controller", "profile"),
    [
        pytest.param(unit, profile, id=unit.id, marks=() if unit.id in IN_EVERY_ROUND else pytest.mark.slow)
        for unit, profile in by_turns(UNITS.values(), PROFILES.values())
    ],
)


def widened(controller: Controller, times: float, readings_of: Build) -> Readings:
    """A sheet with every clearance so many times that of a new pair."""
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * times * land.new_clearance)
        for land in controller.lands
    }
    return readings_of(controller, diameters)


@every_unit
def test_a_new_unit_is_green_at_every_operating_point(
    controller: Controller, profile: Profile, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    sheet = widened(controller, 1.0, readings_of)
    diagnosis = diagnose(controller, hipol, limits, readings=sheet, profile=profile)
    assert diagnosis.verdict == Verdict.OK
    assert {diagnosis.band(point) for point in diagnosis.projections} == {Band.GREEN}
    assert {land.verdict for land in diagnosis.lands} == {Verdict.OK}


@every_unit
def test_no_fluid_makes_a_new_unit_worn(
    controller: Controller, profile: Profile, limits: Limits, readings_of: Build
) -> None:
    states = clearances(widened(controller, 1.0, readings_of), controller)
    judged = 0
    for fluid in fluids():
        low, high = fluid.span(profile.viscosity)
        points = [point for point in controller.operating_points if low <= point.temperature <= high]
        model = LeakageModel(controller, states, fluid, profile)
        projections = [project(model, point) for point in points]
        rules = unit_rules(states, projections, project_unworn(states, model, projections), limits)
        judged += len(projections)
        assert {rule.verdict for rule in (*rules.totals, *chain(*rules.lands.values()))} == {Verdict.OK}
    assert judged >= 2 * len(fluids()) - 2


@pytest.mark.parametrize(
    ("unit", "times", "verdict", "by_total"),
    [
        ("four_speed_2023", 1.08, "ok", False),
        ("four_speed_2023", 1.10, "watch", True),
        ("four_speed_2023", 1.25, "replace", True),
        ("four_speed_2023", 2.0, "critical", True),
        ("minimal_example", 1.10, "ok", False),
        ("minimal_example", 1.3, "watch", False),
        ("minimal_example", 2.0, "replace", False),
        ("five_speed_2005", 1.10, "ok", False),
        ("five_speed_2005", 1.4, "ok", False),  # at 20 µm every pair may still be new
        ("known_by_range", 1.10, "ok", False),
        ("known_by_range", 1.4, "ok", False),  # at 20 µm every pair may still be new
        ("known_by_range", 1.7, "replace", True),
        ("known_by_range", 2.0, "replace", True),
    ],
)
def test_a_worn_unit_is_judged_by_what_it_has_grown(
    unit: str, times: float, verdict: str, by_total: bool, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    controller = UNITS[unit]
    diagnosis = diagnose(controller, hipol, limits, readings=widened(controller, times, readings_of))
    assert diagnosis.verdict == verdict
    assert isinstance(diagnosis.decided_by, Rule) == by_total


def test_used_fluid_makes_no_new_unit_worn(limits: Limits, readings_of: Build) -> None:
    """Thin fluid raises what a new unit draws, and with it the limit."""
    study = UNITS["four_speed_2023"]
    sheet = widened(study, 1.0, readings_of)
    fresh, used = (
        diagnose(study, load_fluid(name), limits, readings=sheet) for name in ("hipol_atf_iid", "hipol_atf_iid_used")
    )
    assert used.worst_total.value > 1.3 * fresh.worst_total.value
    assert (fresh.verdict, used.verdict) == ("ok", "ok")


# --- what new was


def one_land(unit: Controller, clearance_um: float, readings_of: Build) -> Readings:
    land = unit.lands[0]
    return readings_of(unit, {land.key: (land.nominal_diameter, land.nominal_diameter + 2e-6 * clearance_um)})


def with_new(unit: Controller, new: float | tuple[float, float], tolerance: float | None = None) -> Controller:
    lands = tuple(replace(land, mounting_clearance=new, mounting_tolerance=tolerance) for land in unit.lands)
    return replace(unit, lands=lands)


def test_wear_is_judged_from_the_upper_end_of_a_range(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = with_new(minimal, (6.4 * UM, 20 * UM))
    for clearance, verdict in ((19.0, "ok"), (23.9, "ok"), (24.1, "watch"), (30.1, "replace")):
        land = diagnose(unit, hipol, limits, readings=one_land(unit, clearance, readings_of)).lands[0]
        assert (land.state.radial_clearance / UM, land.verdict) == (pytest.approx(clearance, abs=1e-6), verdict)
        assert land.wear == pytest.approx(clearance / 20.0 - 1.0, abs=1e-6)


def test_the_tolerance_of_a_type_makes_wear_less_sure(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    decided: dict[str, Diagnosis] = {}
    for name, unit in {"pair": with_new(minimal, 13 * UM), "type": with_new(minimal, 13 * UM, 4 * UM)}.items():
        decided[name] = diagnose(unit, hipol, limits, readings=one_land(unit, 21.0, readings_of))
    pair, kind = (each.lands[0] for each in decided.values())
    assert pair.verdict == kind.verdict == "replace"
    assert (pair.decision, kind.decision) == ("conditional_fail", "conditional_fail")
    assert pair.probability_over_limit is not None
    assert kind.probability_over_limit is not None
    assert pair.probability_over_limit > kind.probability_over_limit


def test_wear_of_a_type_is_judged_over_the_widest_that_its_new_pairs_commonly_have(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = with_new(minimal, 13 * UM, 2 * UM)
    for clearance, verdict in ((18.9, "ok"), (19.1, "watch"), (19.6, "replace")):
        land = diagnose(unit, hipol, limits, readings=one_land(unit, clearance, readings_of)).lands[0]
        assert (land.state.radial_clearance / UM, land.verdict) == (pytest.approx(clearance, abs=1e-6), verdict)
        assert land.wear == pytest.approx(clearance / 13.0 - 1.0, abs=1e-6)
    # a new pair at the wide end of its type, 15 µm, is no doubtful one
    land = diagnose(unit, hipol, limits, readings=one_land(unit, 15.0, readings_of)).lands[0]
    assert (land.verdict, land.decision) == ("ok", "pass")


def test_unmeasured_lands_of_a_range_leak_its_mean_cube_with_all_of_it_in_the_interval(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = with_new(minimal, (6.4 * UM, 20 * UM))
    diagnosis = diagnose(unit, hipol, limits, readings=one_land(unit, 13.0, readings_of))
    assert diagnosis.uncertainty is not None
    assert diagnosis.lands[1].state.radial_clearance == pytest.approx(14.2774 * UM, rel=1e-4, abs=0.0)
    low, high = diagnosis.uncertainty.totals[0].new_leakage_interval
    assert low < diagnosis.new_projections[0].leakage < high
    assert high > 2.0 * low


@pytest.mark.parametrize(
    ("unit", "code"),
    [
        ("four_speed_2023", "mounting_clearance_used_unit"),
        ("known_by_range", "mounting_clearance_range"),
        ("minimal_example", None),
    ],
)
def test_a_result_says_what_its_mounting_clearances_are(
    unit: str, code: str | None, hipol: Fluid, limits: Limits
) -> None:
    codes = {each.code for each in diagnose(UNITS[unit], hipol, limits).messages}
    assert {each for each in codes if each.startswith("mounting_clearance_")} == ({code} if code else set())


@pytest.mark.parametrize(("new_um", "tolerance_um"), [((6.4, 20.0), None), (13.0, 5.0)], ids=["range", "type"])
@given(place=st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5))
def test_new_pairs_anywhere_in_what_is_known_of_them_are_green_on_a_small_pump(
    minimal: Controller,
    hipol: Fluid,
    limits: Limits,
    readings_of: Build,
    new_um: float | tuple[float, float],
    tolerance_um: float | None,
    place: list[float],
) -> None:
    """The pump delivers a fifth of what it does, so that a new pair at the wide end draws much more than the mean."""
    tolerance = None if tolerance_um is None else tolerance_um * UM
    new = (new_um[0] * UM, new_um[1] * UM) if isinstance(new_um, tuple) else new_um * UM
    unit = with_new(minimal, new, tolerance)
    unit = replace(unit, pump=replace(unit.pump, displacement=0.2 * unit.pump.displacement))
    sheet = {}
    for land, where in zip(unit.lands, place, strict=True):
        low = land.mounting_range[0] - (land.mounting_tolerance or 0.0)
        clearance = low + where * (land.widest_new - low)
        sheet[land.key] = (land.nominal_diameter, land.nominal_diameter + 2.0 * clearance)
    states = clearances(readings_of(unit, sheet), unit)
    model = LeakageModel(unit, states, hipol, PROFILES["workshop"])
    projections = [project(model, point) for point in unit.operating_points]
    rules = unit_rules(states, projections, project_unworn(states, model, projections), limits)
    assert {rule.verdict for rule in (*rules.totals, *chain(*rules.lands.values()))} == {Verdict.OK}
