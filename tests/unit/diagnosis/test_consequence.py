"""What a land's wear does: now, before the next service, or nothing; and what that makes of the unit's urgency."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

import pytest

from atleak.catalogue.circuits import Circuit, Feed, Pressure
from atleak.catalogue.controller import Controller, Gap
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import Verdict
from atleak.diagnosis.consequence import Consequence, consequences
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import SERVICE_INTERVAL, wear_line
from atleak.diagnosis.rules import unit_rules
from atleak.engine.projection import project, repaired
from atleak.measurements.readings import Readings
from tests.unit.conftest import with_clearances

Build = Callable[..., Readings]
Judge = Callable[..., Diagnosis]
FIRST, SECOND, LINE = ("tcc_regulator", 1), ("tcc_regulator", 2), ("pressure_regulator", 1)
UM = 1e-6


@pytest.fixture(scope="module")
def fed(minimal: Controller) -> Controller:
    """A clutch with a feed of 0.5 mm and two lands of 13 µm that leak from it, and a land on the line."""
    new = {"mounting_clearance": 13 * UM, "nominal_diameter": 14.5e-3, "new_origin": NewOrigin.PAIR}
    measured = {**new, "mounting_measured": True}
    clutch, line = minimal.land(*FIRST), minimal.land(*LINE)
    lands = [replace(clutch, land=number, planes=(str(number),), **measured) for number in (1, 2)]
    gears = frozenset(minimal.gears)
    gaps = [
        Gap(*land.key, section, Pressure(1.0, section), Pressure(0.0, None), gears, True, False)
        for land, section in ((lands[0], "c1"), (lands[1], "c1"), (line, "p_g"))
    ]
    return replace(
        minimal,
        lands=(*lands, replace(line, **measured)),
        gaps=tuple(gaps),
        gaps_not_described=frozenset(),
        circuits=(Circuit("c1", "clutch C1", gears, (Feed("p_g", 0.5e-3, 0.62),), None, "test"),),
    )


@pytest.fixture(scope="module")
def judge(fed: Controller, readings_of: Build, hipol: Fluid, limits: Limits) -> Judge:
    def build(
        clearances_um: Mapping[LandKey, float], unit: Controller = fed, mileage: float | None = None
    ) -> Diagnosis:
        readings = with_clearances(unit, readings_of, {key: um * UM for key, um in clearances_um.items()})
        return diagnose(unit, hipol, limits, readings=readings, mileage_km=mileage)

    return build


def test_a_land_that_costs_its_clutch_the_pressure_matters_now(judge: Judge) -> None:
    found = judge({FIRST: 40.0})
    assert found.consequences == {FIRST: Consequence.NOW, SECOND: Consequence.NONE, LINE: Consequence.NONE}
    assert found.urgency is found.verdict is Verdict.REPLACE


def test_wear_alone_has_no_consequence_and_is_to_be_watched(judge: Judge) -> None:
    found = judge({LINE: 25.0})
    (land,) = found.flagged
    assert (land.key, land.verdict, found.verdict) == (LINE, Verdict.REPLACE, Verdict.REPLACE)
    assert found.consequences[LINE] is Consequence.NONE
    assert found.urgency_of(land) is Verdict.WATCH
    assert found.urgency is Verdict.WATCH


def test_of_two_lands_that_no_single_repair_makes_up_for_both_matter_now(judge: Judge) -> None:
    both = judge({FIRST: 60.0, SECOND: 60.0})
    alone = judge({FIRST: 60.0})
    rules = [rule.level for rule in both.pressure_rules if rule.circuit]
    assert rules == [rule.level for rule in alone.pressure_rules if rule.circuit] == [Verdict.REPLACE] * 2
    assert both.consequences == {FIRST: Consequence.NOW, SECOND: Consequence.NOW, LINE: Consequence.NONE}


def test_a_land_that_the_worse_one_leaves_no_room_for_matters_only_where_the_limit_stays_passed(judge: Judge) -> None:
    found = judge({FIRST: 60.0, SECOND: 15.0})
    assert found.consequences[FIRST] is Consequence.NOW
    assert found.consequences[SECOND] is Consequence.NONE  # with the first one new its 2 µm cost nothing


@pytest.mark.parametrize(
    ("unit", "factors"),
    [
        ("five_speed_2005", {3: 3.0}),
        ("five_speed_2005", {2: 2.2}),
        ("chrysler_41te", {2: 2.0}),
        ("gm_4l60e", {5: 4.0, 3: 1.6}),
    ],
)
def test_with_the_lands_that_matter_now_new_nothing_stays_past_that_all_new_would_mend(
    unit: str, factors: Mapping[int, float], judge: Judge
) -> None:
    """Every so many lands are worn so many times; the engine computes the repaired unit by itself."""
    controller = load_controller(unit)
    worn = {
        land.key: land.widest_new / UM * next((times for every, times in factors.items() if not at % every), 1.0)
        for at, land in enumerate(controller.lands)
    }
    found = judge(worn, controller)
    now = {key for key, consequence in found.consequences.items() if consequence is Consequence.NOW}
    assert any(rule.verdict.flagged for rule in found.unit_rules)
    assert now

    def levels(new: Collection[LandKey]) -> list[int]:
        model = replace(found.model, clearances=repaired([land.state for land in found.lands], new))
        projections = [project(model, each.condition) for each in found.projections]
        return [
            rule.verdict.rank for rule in unit_rules((), projections, found.unworn_projections, found.limits).of_unit
        ]

    assert levels(now) == levels(worn.keys())
    assert max(levels({land.key for land in found.lands if land.verdict.flagged} - now)) >= Verdict.WATCH.rank


def test_by_its_wear_line_a_land_matters_before_the_next_service(judge: Judge) -> None:
    found = judge({FIRST: 20.0}, mileage=30_000.0)  # 34 µm at 90 000 km
    assert not any(rule.verdict.flagged for rule in found.pressure_rules)
    assert found.consequences[FIRST] is Consequence.BEFORE_NEXT_SERVICE
    assert judge({FIRST: 20.0}).consequences[FIRST] is Consequence.NONE  # nothing gives a line
    assert judge({FIRST: 20.0}, mileage=300_000.0).consequences[FIRST] is Consequence.NONE  # 21.4 µm then
    assert {*found.consequences.values()} == {Consequence.BEFORE_NEXT_SERVICE, Consequence.NONE}


def test_lines_of_several_visits_are_taken_where_they_are_given(judge: Judge, fed: Controller) -> None:
    unit = replace(fed, lands=tuple(replace(land, mounting_measured=False) for land in fed.lands))
    found = judge({FIRST: 20.0}, unit, 30_000.0)
    assert found.consequences[FIRST] is Consequence.NONE
    exact = [[1e-18, 0.0], [0.0, 1e-18]]
    line = wear_line([15_000.0, 30_000.0], [16 * UM, 20 * UM], exact)
    assert line is not None
    assert line.at(30_000.0 + SERVICE_INTERVAL) == pytest.approx(36 * UM, rel=1e-9, abs=0.0)
    assert replace(found, lines_of_visits={FIRST: line}).consequences[FIRST] is Consequence.BEFORE_NEXT_SERVICE


def test_what_cannot_be_computed_is_unknown(judge: Judge, fed: Controller, readings_of: Build, hipol, limits) -> None:
    half = readings_of(fed, {FIRST: (14.5e-3, None), SECOND: (14.5e-3, 14.526e-3)})
    by_land = diagnose(fed, hipol, limits, readings=half).consequences
    assert by_land == {FIRST: Consequence.UNKNOWN, SECOND: Consequence.NONE, LINE: Consequence.UNKNOWN}
    nowhere = replace(fed, gaps=tuple(gap for gap in fed.gaps if gap.key != LINE))
    assert judge({LINE: 25.0}, nowhere).consequences[LINE] is Consequence.UNKNOWN
    open_ones = replace(fed, gaps_not_described=frozenset([LINE]))
    found = judge({LINE: 25.0}, open_ones)
    assert found.consequences[LINE] is Consequence.UNKNOWN
    assert found.urgency is Verdict.REPLACE  # nobody knows that it can wait


def test_a_description_that_cannot_be_right_tells_nothing(judge: Judge, fed: Controller) -> None:
    small = replace(fed, pump=replace(fed.pump, displacement=1e-8))
    found = judge({FIRST: 60.0}, small)
    assert found.impossible
    assert {*found.consequences.values()} == {Consequence.UNKNOWN}


def test_a_land_found_responsible_for_a_measured_pressure_matters_now(judge: Judge) -> None:
    found = judge({LINE: 25.0})
    assert consequences(found, [LINE])[LINE] is Consequence.NOW
