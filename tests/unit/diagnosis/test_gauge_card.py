"""What gauges should show, new and as measured: against the engine, and against the readings that come back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.gauge_card import CardRow, Expected, Shows
from atleak.diagnosis.uncertainty import DEFAULTS, NOTHING_ELSE
from atleak.engine.projection import project
from atleak.job.case import Case, SourceFile
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, applied
from atleak.report.tables.gauges import gauge_record

UNIT = "five_speed_2005"
SHEET = SourceFile.at(Path(__file__).parents[3] / "sample_data" / "measuring_sheet_five_speed.xlsx")
SLOW, FAST, STALL = Engine.SLOW_IDLE, Engine.FAST_IDLE, Engine.STALL


def rows_of(diagnosis: Diagnosis, **options) -> dict[tuple[str, str, Engine], CardRow]:
    rows = diagnosis.gauge_card.rows(**options)
    return {(row.tap, selected, row.engine): row for row in rows for selected in row.ranges}


@pytest.fixture(scope="module")
def measured() -> Diagnosis:
    return Case(controller=UNIT, readings=SHEET).diagnose()


@pytest.fixture(scope="module")
def unmeasured() -> Diagnosis:
    return Case(controller=UNIT).diagnose()


def test_every_number_is_what_the_engine_holds_there(measured: Diagnosis) -> None:
    computed = {key: row for key, row in rows_of(measured).items() if row.expected is not None}
    assert {key[0] for key in computed} > {LINE_TAP, "forward_clutch", "reverse_servo"}
    for (tap, _, _), row in computed.items():
        now, new = project(measured.model, row.point), project(measured.as_unworn, row.point)
        held = [each.main_pressure_held if tap == LINE_TAP else each.circuit(tap).pressure for each in (new, now)]
        assert [row.expected.new.value, row.expected.now.value] == pytest.approx(held, abs=1e-3)
        for shows in (row.expected.new, row.expected.now):
            assert shows.low <= shows.value <= shows.high


def test_it_is_at_the_temperature_and_speed_of_the_operating_point(measured: Diagnosis) -> None:
    points = {each.name: each for each in measured.controller.operating_points}
    rows = rows_of(measured, fast_idle=1800.0 / 60.0)
    assert rows[LINE_TAP, "D", SLOW].point == points["hot_idle"]
    assert rows[LINE_TAP, "D", STALL].point == points["stall"]
    assert rows[LINE_TAP, "R", SLOW].point == points["reverse_idle"]
    fast = rows[LINE_TAP, "D", FAST].point
    assert (fast.engine_speed, fast.temperature) == (1800.0 / 60.0, points["hot_idle"].temperature)
    assert rows_of(measured)[LINE_TAP, "D", FAST].point.engine_speed == 1500.0 / 60.0


def test_a_tap_that_is_vented_is_not_on_the_card_and_the_line_always_is(unmeasured: Diagnosis) -> None:
    rows, unit = rows_of(unmeasured), unmeasured.controller
    assert {selected for tap, selected, _ in rows if tap == LINE_TAP} == {"P", "R", "N", "D", "4", "3", "2", "1"}
    assert {selected for tap, selected, _ in rows if tap == "forward_clutch"} == {"D", "4", "3", "2", "1"}
    assert {selected for tap, selected, _ in rows if tap == "reverse_servo"} == {"R"}
    assert "overdrive_band" not in {tap for tap, _, _ in rows}, "only in gears in which no vehicle stands"
    assert all(applied(unit, GaugeCell(selected, engine, tap)) for tap, selected, engine in rows)
    assert not any(engine is STALL and selected in ("P", "N") for _, selected, engine in rows)


def test_a_unit_without_circuits_has_the_line_alone_and_says_where_nothing_is_computed() -> None:
    rows = rows_of(Case(controller="four_speed_2023").diagnose())
    assert {tap for tap, _, _ in rows} == {LINE_TAP}
    assert rows[LINE_TAP, "D", SLOW].expected is not None
    missing = [(selected, engine) for (_, selected, engine), row in rows.items() if row.expected is None]
    assert {("P", SLOW), ("R", SLOW), ("R", STALL), ("D", STALL)} <= set(missing)


def test_a_unit_without_operating_points_of_idle_computes_nothing_there() -> None:
    unit = load_controller(UNIT)
    driving = tuple(each for each in unit.operating_points if each.state == "driving")
    unit = replace(unit, operating_points=driving)
    rows = rows_of(diagnose(unit, load_fluid("hipol_atf_iid"), load_limits("project_default")))
    assert rows
    assert all(row.point is None and row.expected is None for row in rows.values())


def test_without_a_sheet_now_is_new_and_a_worn_land_shows_only_at_its_own_tap(
    unmeasured: Diagnosis, measured: Diagnosis
) -> None:
    assert all(not row.expected.measured for row in rows_of(unmeasured).values() if row.expected)
    worn, beside = (rows_of(measured)[tap, "D", STALL].expected for tap in ("forward_clutch", "solenoid_feed"))
    assert worn.measured
    assert worn.now.high < worn.new.low
    assert beside.now == pytest.approx(beside.new, abs=1.0)


def test_a_gauge_that_errs_more_shows_more_and_nothing_uncertain_shows_one_pressure() -> None:
    unit, fluid, limits = load_controller(UNIT), load_fluid("hipol_atf_iid"), load_limits("project_default")

    def line(assumptions) -> Shows:
        rows = rows_of(diagnose(unit, fluid, limits, assumptions=assumptions))
        return rows[LINE_TAP, "D", SLOW].expected.new

    usual, exact = line(DEFAULTS), line(replace(DEFAULTS, main_pressure=0.0))
    assert exact.high - exact.low < usual.high - usual.low
    # two independent parts of 1 % and 2 %, a normal gauge on a nearly normal line
    assert (usual.high - usual.low) / usual.value == pytest.approx(2 * 1.96 * 0.0224, abs=0.005)
    none = line(NOTHING_ELSE)
    assert (none.low, none.high) == pytest.approx((none.value, none.value), rel=1e-3, abs=1e-9)


@pytest.mark.parametrize(
    ("pressure", "word"),
    [(100.0, "as_new"), (95.0, "as_new"), (94.0, "between"), (80.0, "as_measured"), (69.0, "below"), (106.0, "above")],
)
def test_a_reading_is_as_new_before_it_is_as_measured(pressure: float, word: str) -> None:
    expected = Expected(Shows(100.0, 95.0, 105.0), Shows(80.0, 70.0, 90.0))
    assert expected.stands(pressure) == word


def test_what_comes_back_says_how_it_stands(measured: Diagnosis) -> None:
    table = "range;tap;slow idle [kPa];fast idle [kPa];stall [kPa]\nD;line;890;890;1000\nD;forward_clutch;;;1390\n"
    table += "R;forward_clutch;20;;\nP;line;900;;\n"
    diagnosis = Case(controller=UNIT, readings=SHEET, pressures=SourceFile("g.csv", table.encode())).diagnose()
    record = gauge_record(diagnosis)["readings"]
    stands = {(each["tap"], each["range"], each["state"]): each["stands_to_expected"] for each in record}
    assert stands == {
        ("line", "D", "slow_idle"): "as_new",
        ("line", "D", "fast_idle"): None,  # no speed is stated
        ("line", "D", "stall"): "below",
        ("forward_clutch", "D", "stall"): "as_measured",
        ("forward_clutch", "R", "slow_idle"): None,  # vented
        ("line", "P", "slow_idle"): None,  # no operating point
    }
    row = rows_of(measured)["forward_clutch", "D", STALL].expected
    (tap,) = (each for each in record if (each["tap"], each["state"]) == ("forward_clutch", "stall"))
    on_card = [*row.now, *row.new]
    keys = ("", "_low", "_high", "_new", "_new_low", "_new_high")
    assert [tap[f"expected{key}_kpa"] * 1e3 for key in keys] == pytest.approx(on_card, abs=1e-6)
