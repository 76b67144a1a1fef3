"""Which part it is: what the answer takes, what it names, and that every split adds up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from atleak.analysis.answer import Answer, answer_of
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.pump import PumpClearances
from atleak.catalogue.repairs import LandKey
from atleak.common.wording import wording
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.missing import Cause
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LINE
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.answer import answer_lines
from tests.unit.conftest import first_of, with_clearances

UNITS = {"five_speed_2005": "forward_clutch", "zf_6hp26": "clutch_a", "ford_4r70w": "forward_clutch"}


@pytest.fixture(scope="module")
def table_of(hipol: Fluid) -> Callable[..., PressureTable]:
    """Return what gauges would show on a new unit in drive, each less by a fraction."""

    def table(
        unit: Controller, line: float = 0.0, clutch: float = 0.0, tap: str = "", **speeds: float
    ) -> PressureTable:
        readings = []
        for engine, state in ((Engine.SLOW_IDLE, "idle"), (Engine.STALL, "stall"), (Engine.FAST_IDLE, "idle")):
            point = next((each for each in unit.operating_points if (each.gear, each.state) == (1, state)), None)
            speed = speeds.get(engine.value)
            if point is None or (engine is Engine.FAST_IDLE and speed is None):
                continue
            point = point if speed is None else replace(point, engine_speed=speed)
            new = project(LeakageModel(unit, clearances(None, unit), hipol, WORKSHOP), point)
            shown = {LINE_TAP: new.main_pressure_held * (1.0 - line)}
            if tap:
                shown[tap] = new.circuit(tap).pressure * (1.0 - line) * (1.0 - clutch)
            cells = ((GaugeCell("D", engine, each), pressure) for each, pressure in shown.items())
            readings += [GaugeReading(cell, pressure, engine_speed=speed) for cell, pressure in cells]
        return PressureTable("gauges.csv", "0" * 64, None, ("kPa",), tuple(readings))

    return table


@pytest.fixture(scope="module")
def judged(hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> Callable[..., Diagnosis]:
    def judge(unit: Controller, wide: dict[LandKey, float] | None = None, **more: Any) -> Diagnosis:
        return diagnose(unit, hipol, limits, readings=with_clearances(unit, readings_of, wide or {}), **more)

    return judge


def splits_of(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Return every split of a record."""
    found = [each["missing"] for each in record["conditions"]]
    found += [each["missing"] for condition in record["conditions"] for each in condition["circuits"]]
    return [each for each in found if each is not None]


@pytest.mark.parametrize("name", first_of(UNITS))
def test_a_sound_unit_has_no_cause_and_nothing_to_do(judged, table_of, name: str) -> None:
    unit = load_controller(name)
    diagnosis = judged(unit, pressures=table_of(unit, tap=UNITS[name]))
    assert answer_of(diagnosis).cause is Cause.NONE
    lines = answer_lines(answer_of(diagnosis), wording("en"))
    assert lines.wrong == "Nothing is past a limit."
    assert lines.do == "Nothing has to be done."


@pytest.mark.parametrize("name", first_of(UNITS))
def test_a_worn_land_that_the_gauge_shows_is_named_with_what_it_costs(judged, table_of, name: str) -> None:
    unit, clutch = load_controller(name), UNITS[name]
    land = next(gap.key for gap in unit.gaps if gap.high.section == clutch and gap.into_sump and 1 in gap.gears)
    worn = judged(unit, {land: 60e-6})
    stall = next(each for each in worn.projections if (each.condition.gear, each.condition.state) == (1, "stall"))
    lost = 1.0 - stall.circuit(clutch).pressure / worn.unworn_at(stall).circuit(clutch).pressure
    diagnosis = judged(unit, {land: 60e-6}, pressures=table_of(unit, clutch=lost, tap=clutch))
    answer = answer_of(diagnosis)
    assert (answer.cause, answer.circuit, answer.land) == (Cause.LANDS, clutch, land)
    assert answer.probability is not None
    assert answer.probability > 0.9
    assert diagnosis.consequences[land] is Consequence.NOW
    record = diagnosis_record(diagnosis)
    for each in splits_of(record):
        rows = sum(row["kpa"] for row in each["explained"])
        assert rows + each["unexplained_kpa"] == pytest.approx(each["missing_kpa"], abs=1e-6)
        for row in each["explained"]:
            if row["lands"]:
                assert sum(of_land["kpa"] for of_land in row["lands"]) == pytest.approx(row["kpa"], abs=1e-6)
        measured = each["measured_kpa"] is not None
        assert (each["missing_low_kpa"] is not None) is measured
        if measured:
            assert each["missing_kpa"] == pytest.approx(each["expected_kpa"] - each["measured_kpa"], abs=1e-6)
            assert all(row["low_kpa"] <= row["kpa"] <= row["high_kpa"] for row in each["explained"])
    assert (record["answer"]["component"], record["answer"]["land"]) == land


@pytest.mark.parametrize("name", first_of(UNITS))
def test_a_line_that_no_measured_part_explains_is_said_to_be_unexplained(judged, table_of, name: str) -> None:
    unit = load_controller(name)
    answer = answer_of(judged(unit, pressures=table_of(unit, line=0.35)))
    assert answer.cause is Cause.UNEXPLAINED
    assert answer.missing is not None
    bores = np.mean(answer.missing.of(Cause.LANDS) + answer.missing.of(Cause.LINE_SETTING))
    assert abs(bores) < 0.1 * np.mean(answer.missing.missing)
    assert answer.steps == ()
    lines = answer_lines(answer, wording("en"))
    assert "The measured bores explain" in lines.wrong
    assert "fluid level and filter" in lines.do


def test_what_one_speed_cannot_tell_from_a_worn_pump_is_named_beside_it(judged, table_of) -> None:
    unit = load_controller("chrysler_41te")
    table = table_of(unit, line=0.35)
    idle = tuple(each for each in table.readings if each.cell.engine is Engine.SLOW_IDLE)
    answer = answer_of(judged(unit, pressures=replace(table, readings=idle)))
    assert (answer.cause, answer.also) == (Cause.UNEXPLAINED, (Cause.PUMP,))
    assert {each.component for each in answer.next_measurements[:2]} == {"pump"}
    assert "these readings cannot tell" in answer_lines(answer, wording("en")).wrong


def test_where_no_pressure_is_lost_the_growth_of_what_leaks_is_split(worn: Diagnosis) -> None:
    answer = answer_of(worn)
    assert answer.by_flow
    assert answer.cause is Cause.LANDS
    total = np.mean(answer.total)
    assert sum(np.mean(each) for each in answer.amounts.values()) == pytest.approx(total, rel=1e-9, abs=0.0)
    assert answer_lines(answer, wording("en")).wrong.startswith("No pressure is lost yet.")
    assert all(not worn.can_wait(step.land) for step in answer.steps)


def test_a_unit_that_nobody_measured_is_asked_to_be_measured(unmeasured: Diagnosis) -> None:
    lines = answer_lines(answer_of(unmeasured), wording("en"))
    assert (lines.wrong, lines.do) == ("Nothing can be judged yet.", "Measure the lands first.")


def test_the_same_probability_stands_in_the_answer_and_in_its_draws(judged, table_of) -> None:
    unit = load_controller("five_speed_2005")
    answer = answer_of(judged(unit, pressures=table_of(unit, line=0.3)))
    assert answer.missing is not None
    missing = answer.missing
    explained = sum(missing.of(cause) for cause in (answer.cause, *answer.also))
    assert answer.probability == np.mean(explained > 0.5 * missing.missing)
    assert diagnosis_record(answer.diagnosis)["answer"]["cause_probability"] == answer.probability


def test_an_amount_and_a_probability_are_those_of_what_is_named(judged) -> None:
    unit, tap = load_controller("zf_6hp26"), "clutch_e"
    lands = {gap.key for gap in unit.gaps if tap in (gap.high.section, gap.low.section)}
    answer = answer_of(judged(unit, dict.fromkeys(lands, 75e-6)))
    assert (answer.cause, answer.circuit) == (Cause.LANDS, tap)
    assert answer.missing is not None
    assert answer.row is not None
    assert answer.missing.best is not None
    lines, of_lands = answer_lines(answer, wording("en")), answer.missing.best.lands[answer.row]
    assert len(of_lands) > 2
    named = sum(float(np.mean(of_lands[key])) for key in list(answer.lands_of(answer.row))[:2])
    assert f": {named / 1e3:.0f}\xa0kPa (" in lines.wrong
    assert named / 1e3 < np.mean(answer.missing.best.rows[answer.row]) / 1e3 - 1.0
    assert lines.wrong[0].isupper()
    assert (
        "more than 99\xa0% probability most of the loss is due to worn valves. The pump was not measured and counts as "
        "new." in lines.sure
    )  # the pump


def test_pressures_that_are_taken_as_given_are_not_said_to_be_held(judged) -> None:
    unit = load_controller("five_speed_2005")
    land = next(gap.key for gap in unit.gaps if gap.high.section == "forward_clutch" and gap.into_sump)
    answer = answer_of(judged(unit, {land: 90e-6}, profile=PAPER))
    assert answer.by_flow
    assert answer_lines(answer, wording("en")).wrong.startswith("Pressures are taken as given. ")


def test_lands_of_the_circuit_that_the_line_follows_are_lands_where_no_pressure_is_lost(judged) -> None:
    unit = load_controller("five_speed_2005")
    assert unit.line is not None
    assert unit.line.following is not None
    followed = unit.line.following.section
    land = next(gap.key for gap in unit.gaps if gap.high.section == followed and gap.into_sump)
    diagnosis = judged(unit, {land: 24e-6})
    missing = diagnosis.missing_at(diagnosis.projection, LINE)
    lines = answer_lines(Answer(diagnosis, Cause.LINE_SETTING, missing=missing, by_flow=True), wording("en"))
    assert "set too low" not in lines.wrong


def test_lands_that_explain_next_to_nothing_are_not_asked_for(hipol: Fluid, limits: Limits, table_of) -> None:
    unit = load_controller("four_speed_2023")
    table = table_of(unit, line=0.4)
    answer = answer_of(diagnose(unit, hipol, limits, pressures=table))
    assert answer.missing is not None
    assert answer.next_measurements
    least = 0.05 * np.mean(answer.missing.missing)
    assert all(each.value is None or each.value >= least for each in answer.next_measurements)


@pytest.mark.usefixtures("all_draws")
def test_a_cause_is_named_beside_another_once_and_counts_in_the_probability(hipol: Fluid, limits: Limits, table_of):
    unit = load_controller("five_speed_2005")
    table = table_of(unit, line=0.4, clutch=0.3, tap="forward_clutch")
    answer = answer_of(diagnose(unit, hipol, limits, pressures=table))
    assert answer.also
    assert len({answer.cause, *answer.also}) == 1 + len(answer.also)
    assert "most of the loss is due to a cause that was not measured" in answer_lines(answer, wording("en")).sure


@pytest.mark.parametrize(
    ("clearances", "part", "wrong", "do"),
    [
        ({}, "", "Nothing that was measured is past a limit.", "No repair is due by what was measured."),
        ({}, "spool", "Nothing can be judged yet.", "Measure the lands first."),
        (2e-6, "", "Pairs measure tighter than new ones", "Measure these pairs again"),
    ],
)
def test_a_unit_within_its_limits_is_called_so_as_far_as_it_was_measured(
    judged, hipol, limits, readings_of, clearances: Any, part: str, wrong: str, do: str
) -> None:
    unit = load_controller("five_speed_2005")
    wide = dict.fromkeys((land.key for land in unit.lands), clearances) if clearances else {}
    readings = with_clearances(unit, readings_of, wide)
    kept = [each for each in readings.readings if each.part == part] if part else readings.readings
    if not clearances and not part:
        kept = [each for each in kept if each.component != unit.lands[0].component]
    diagnosis = diagnose(unit, hipol, limits, readings=replace(readings, readings=tuple(kept)))
    lines = answer_lines(answer_of(diagnosis), wording("en"))
    assert lines.wrong.startswith(wrong)
    assert lines.do.startswith(do)


def test_a_pressure_that_cannot_be_split_is_still_said_to_be_missing(hipol: Fluid, limits: Limits, table_of) -> None:
    unit = load_controller("five_speed_2005")
    diagnosis = diagnose(unit, hipol, limits, profile=PAPER, pressures=table_of(unit, line=0.6))
    lines = answer_lines(answer_of(diagnosis), wording("en"))
    assert diagnosis.verdict.flagged
    assert lines.wrong


def test_a_pump_whose_clearance_counts_for_nothing_is_not_to_be_repaired(
    hipol: Fluid, limits: Limits, table_of
) -> None:
    unit = load_controller("five_speed_2005")
    unit = replace(unit, pump=unit.pump.with_measured(PumpClearances(30e-6, None)))
    assert not unit.pump.counted.any_known
    diagnosis = diagnose(unit, hipol, limits, pressures=table_of(unit, line=0.5))
    answer = Answer(diagnosis, Cause.PUMP, missing=diagnosis.missing_flagged[0])
    lines = answer_lines(answer, wording("en"))
    assert "filter" in lines.wrong
    assert lines.do.startswith("Check fluid level and filter")


@pytest.mark.parametrize("measured", [False, True])
def test_lands_that_no_plan_repairs_do_not_wait_where_a_gauge_misses_pressure(
    judged, hipol: Fluid, limits: Limits, table_of, measured: bool
) -> None:
    unit = load_controller("five_speed_2005")
    table = table_of(unit, clutch=0.3, tap="forward_clutch")
    diagnosis = judged(unit, pressures=table) if measured else diagnose(unit, hipol, limits, pressures=table)
    answer = Answer(diagnosis, Cause.LANDS, missing=diagnosis.missing_flagged[0])
    assert not answer.steps
    do = answer_lines(answer, wording("en")).do
    assert do.endswith(": make as new.") if measured else do.startswith("Measure ")


def test_a_circuit_that_lacks_pressure_beside_a_sound_line_is_not_blamed_on_filter_or_level(
    hipol: Fluid, limits: Limits, table_of
) -> None:
    unit = load_controller("five_speed_2005")
    diagnosis = diagnose(unit, hipol, limits, pressures=table_of(unit, clutch=0.2, tap="forward_clutch"))
    missing = next(each for each in diagnosis.missing_flagged if each.tap == "forward_clutch")
    lines = answer_lines(Answer(diagnosis, Cause.UNEXPLAINED, missing=missing), wording("en"))
    assert lines.do.startswith("Check forward clutch itself")
    line = replace(missing, tap=LINE)
    assert "filter" in answer_lines(Answer(diagnosis, Cause.UNEXPLAINED, missing=line), wording("en")).do
