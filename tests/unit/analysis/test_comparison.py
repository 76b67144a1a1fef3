"""Two visits of one unit side by side: what is called changed, what stands on one side, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.analysis.changes import Comparison
from atleak.analysis.comparison import compare
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.pump import PumpClearances
from atleak.common.errors import InputError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.drawn_unit import deviates_of_factors
from atleak.diagnosis.uncertainty.draws import Cube, Draws
from atleak.diagnosis.uncertainty.one_sided_wear import one_sided_wear
from atleak.diagnosis.uncertainty.paired import PairedVisit, _drawn_lands
from atleak.engine.projection import stated_condition
from atleak.measurements.readings import Readings
from tests.unit.conftest import first_of

WORN = {("2", 1): 35e-6, ("2", 2): 35e-6, ("4", 1): 30e-6}

Diagnosed = Callable[..., Diagnosis]


def clearances_of(controller: Controller, worn: dict[tuple[str, int], float]) -> dict[tuple[str, int], float]:
    return {land.key: worn.get(land.key, land.new_clearance) for land in controller.lands}


@pytest.fixture(scope="module")
def visit(three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> Diagnosed:
    """Diagnoses the small valve body with circuits: new but for the clearances given; ``only`` names lands measured."""

    def judge(
        worn: dict, *, only: set | None = None, sha256: str = "1" * 64, fluid: Fluid = hipol, **choices
    ) -> Diagnosis:
        lands = {land.key: land for land in three_circuits.lands}
        diameters = {
            key: (lands[key].nominal_diameter, lands[key].nominal_diameter + 2.0 * clearance)
            for key, clearance in clearances_of(three_circuits, worn).items()
            if only is None or key in only
        }
        readings = replace(readings_of(three_circuits, diameters), sha256=sha256)
        return diagnose(three_circuits, fluid, limits, readings=readings, **choices)

    return judge


@pytest.fixture(scope="module")
def worn(visit: Diagnosed) -> Diagnosis:
    return visit(WORN)


@pytest.fixture(scope="module")
def repaired(worn: Diagnosis, visit: Diagnosed) -> Comparison:
    """Both lands of component 2 made as new, that of component 4 left as it was."""
    return compare(worn, visit({("4", 1): 30e-6}, sha256="2" * 64))


def codes(comparison: Comparison) -> set[str]:
    return {message.code for message in comparison.messages}


def test_exactly_the_repaired_lands_changed(repaired: Comparison) -> None:
    assert {land.key for land in repaired.changed} == {("2", 1), ("2", 2)}
    for land in repaired.changed:
        assert land.change.value < -10e-6
        assert land.before.verdict.flagged
        assert not land.after.verdict.flagged
    assert {land.key for land in repaired.flagged} == {("2", 1), ("2", 2), ("4", 1)}
    assert not codes(repaired)


def test_the_uncertainty_of_a_change_is_that_of_both_measurements(repaired: Comparison) -> None:
    land = next(each for each in repaired.lands if each.key == ("2", 1))
    change = land.change
    us = [side.uncertainty.u_clearance for side in (land.before, land.after)]
    assert change.standard_uncertainty == pytest.approx(math.hypot(*us), abs=1e-15)
    reach = 1.959964 * change.standard_uncertainty
    assert change.interval == pytest.approx((change.value - reach, change.value + reach), abs=1e-11)


def test_totals_and_the_circuit_of_the_repaired_valve_changed_beyond_their_uncertainty(repaired: Comparison) -> None:
    leading = repaired.leading
    for each in repaired.conditions:
        for change in (each.share, each.leakage):
            assert change.interval[0] <= change.value <= change.interval[1]
    fed = [one for each in repaired.conditions for one in each.circuits if one.change and one.change.significant]
    assert fed
    assert all(one.change.value > 0.0 for one in fed)
    assert leading.share.significant


SHIPPED = ["four_speed_2023", "five_speed_2005", "zf_6hp26", "gm_4l60e"]


def two_visits(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings], speed: float | None = None
) -> list[Diagnosis]:
    """Two visits of a shipped unit: a pair measured at both; at the first also a spool alone, and another pair."""
    controller = load_controller(name)
    lands = [land for land in controller.lands if not land.seal][:3]
    pairs = {land.key: (land.nominal_diameter, land.nominal_diameter + 3.0 * land.mounting_high) for land in lands}
    both, spool_alone, _ = pairs
    measured = ({**pairs, spool_alone: (pairs[spool_alone][0], None)}, {both: pairs[both]})
    point = stated_condition(controller, engine_speed=speed)
    return [
        diagnose(
            controller, hipol, limits, readings=replace(readings_of(controller, each), sha256=n * 64), condition=point
        )
        for n, each in zip("12", measured, strict=True)
    ]


@pytest.mark.parametrize("name", first_of(SHIPPED))
def test_a_length_that_nobody_measured_is_one_at_both_visits_whatever_else_was_measured(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    visits = [
        PairedVisit(each.model, [land.sources for land in each.uncertainty.lands], list(each.projections))
        for each in two_visits(name, hipol, limits, readings_of)
    ]
    statuses = {
        tuple(land.state.status for land in lands) for lands in zip(*(each.lands for each in visits), strict=True)
    }
    assert len(statuses) == 4  # a spool alone and a whole pair at one visit only, a pair at both, the others at neither
    shared = Draws(Cube(256, 7, 0))
    deviates = deviates_of_factors(shared)
    one_sided = one_sided_wear(shared, visits[0].model, DEFAULTS, visits[0].lands)
    before, after = _drawn_lands(*visits, deviates, one_sided, DEFAULTS, 7)
    for one, other in zip(before, after, strict=True):
        assert np.ptp(one.length) > 0.0
        assert np.array_equal(one.length, other.length)


@pytest.mark.parametrize("name", first_of(SHIPPED))
def test_where_the_pump_delivers_nothing_no_change_is_told(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    first, second = two_visits(name, hipol, limits, readings_of, speed=1.0 / 60.0)
    assert first.projection.pump_capacity == 0.0
    stated = compare(first, second).leading  # warnings are errors
    assert stated.share is None
    assert stated.leakage.interval is not None


def test_the_same_job_twice_changed_nothing(worn: Diagnosis) -> None:
    twice = compare(worn, worn)
    assert not twice.changed
    assert not any(
        change.significant
        for each in twice.conditions
        for change in (
            each.share,
            each.leakage,
            each.reserve,
            each.main_pressure,
            *(one.change for one in each.circuits),
        )
        if change is not None
    )
    assert codes(twice) == {"same_sheet"}


def test_a_land_measured_once_is_compared_by_nothing_and_named(worn: Diagnosis, visit: Diagnosed) -> None:
    later = visit({}, only={("2", 1)}, sha256="2" * 64)
    found = compare(worn, later)
    assert [land.key for land in found.compared] == [("2", 1)]
    assert next(land for land in found.lands if land.key == ("2", 2)).only_on("before")
    assert "measured_only_before" in codes(found)
    assert any("2/2" in message.text and "count as new" in message.text for message in found.messages)
    assert "measured_only_after" in codes(compare(later, worn))


def test_without_a_sheet_on_one_side_nothing_is_sure(worn: Diagnosis, three_circuits, hipol, limits) -> None:
    found = compare(worn, diagnose(three_circuits, hipol, limits))
    assert not found.compared
    assert all(each.share.significant is None for each in found.conditions)
    assert found.leading is None  # the totals of what nobody measured are those of a new unit
    assert "no_sheet" in codes(found)


def test_two_valve_bodies_are_refused_in_words(worn: Diagnosis, minimal: Controller, hipol, limits) -> None:
    with pytest.raises(InputError) as raised:
        compare(worn, diagnose(minimal, hipol, limits))
    said = str(raised.value)
    for words in ("two different valve bodies", worn.controller.name, "own description", "two jobs of one unit"):
        assert words in said


def test_another_file_of_the_same_valve_body_is_compared_with_a_warning(worn: Diagnosis) -> None:
    other = replace(worn, controller=replace(worn.controller, origin=replace(worn.controller.origin, sha256="f" * 64)))
    assert "other_controller_file" in codes(compare(worn, other))


def test_a_land_that_only_one_of_the_files_describes_is_named_once(worn: Diagnosis) -> None:
    fewer = replace(worn, lands=worn.lands[:-1])
    last = worn.lands[-1].key
    found = compare(fewer, worn)
    assert next(land for land in found.lands if land.key == last).before is None
    assert [message.text for message in found.messages if message.code.startswith(("land_only", "measured_only"))] == [
        f"Only the valve body's file of the job after has these lands: {last[0]}/{last[1]}"
    ]
    assert found.lands[-1].key == last
    assert compare(worn, fewer).lands[-1].after is None


def test_another_fluid_is_no_change_of_the_unit(worn: Diagnosis, visit: Diagnosed) -> None:
    thinner = visit(WORN, fluid=load_fluid("mobil_atf_220"), sha256="2" * 64)
    found = compare(worn, thinner)
    assert [each.name for each in found.differing] == ["fluid"]
    assert "other_choices" in codes(found)
    assert found.alike is not found.after
    for each in found.conditions:
        assert not each.share.significant
        assert each.alike.share == pytest.approx(each.before.share, abs=1e-12)
        assert each.after.share != pytest.approx(each.before.share, abs=1e-6)


def test_another_stated_condition_is_judged_alike_and_stands_on_its_own_side(worn: Diagnosis, visit: Diagnosed) -> None:
    colder = visit(WORN, condition=stated_condition(worn.controller, temperature=60.0), sha256="2" * 64)
    found = compare(worn, colder)
    assert [each.name for each in found.differing] == ["condition"]
    first = found.conditions[0]
    assert first.before is worn.projection
    assert first.alike.share == pytest.approx(worn.projection.share, abs=1e-12)
    last = found.conditions[-1]
    assert (last.before, last.after, last.share) == (None, colder.projection, None)
    assert "conditions_on_one_side" in codes(found)


def test_a_measured_pump_counts_once_where_a_job_is_judged_again(three_circuits, hipol, limits, readings_of) -> None:
    controller = replace(three_circuits, pump=load_controller("ford_4r70w").pump)
    land = controller.lands[0]
    readings = readings_of(controller, {land.key: (land.nominal_diameter, land.nominal_diameter + 40e-6)})
    readings = replace(readings, pump=PumpClearances(side=80e-6))
    first = diagnose(controller, hipol, limits, readings=readings)
    later = diagnose(controller, load_fluid("mobil_atf_220"), limits, readings=readings)
    assert first.controller.pump != controller.pump
    found = compare(first, later)
    assert found.alike.controller.pump == first.controller.pump
    assert found.alike.projection.pump_capacity == pytest.approx(first.projection.pump_capacity, abs=1e-15)


@pytest.mark.slow
def test_of_lands_that_did_not_change_one_in_twenty_at_most_is_called_changed(
    three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    """Two visits with two sets of the catalogue's gauges, each with a calibration error of its own."""
    random = np.random.default_rng(7667)
    template = diagnose(
        three_circuits,
        hipol,
        limits,
        readings=readings_of(
            three_circuits,
            {land.key: (land.nominal_diameter, land.nominal_diameter + 60e-6) for land in three_circuits.lands},
        ),
    )
    unit = template.uncertainty
    assert unit is not None
    called = compared = totals = judged = 0
    for _ in range(60):
        visits = []
        for _ in range(2):
            common = {name: random.standard_normal() for land in unit.lands for name in land.sources.groups}
            diameters = {}
            for land in unit.lands:
                # each source of the budget, drawn as stated: a radial error is half of that in the sleeve's diameter
                error = sum(u * common[name] for name, u in land.sources.groups.items())
                error += math.sqrt(land.sources.own_variance) * random.standard_normal()
                state = land.sources.state
                diameters[land.key] = (state.spool_diameter, state.sleeve_diameter + 2.0 * error)
            readings = replace(readings_of(three_circuits, diameters), sha256=f"{random.integers(1 << 60):064x}")
            visits.append(diagnose(three_circuits, hipol, limits, readings=readings))
        found = compare(*visits)
        called += len(found.changed)
        compared += len(found.compared)
        changes = [each.share for each in found.conditions if each.share is not None]
        totals += sum(bool(change.significant) for change in changes)
        judged += len(changes)
    assert called / compared == pytest.approx(0.05, abs=0.03)
    # 60 pairs of visits, whose two totals err together: 5 % within two and a half standard errors
    assert totals / judged <= 0.12
