"""The pump of a job, measured: what a worn one costs in slip, reserve and pressure, and what it leaves alone."""

from __future__ import annotations

import io
import itertools
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import openpyxl
import pypdfium2
import pytest
from jsonschema import Draft202012Validator

from atleak.analysis.estimate import estimate, with_line, with_repairs
from atleak.analysis.record_doubts import decision_faults
from atleak.analysis.repair.choice import OfferedRepairs
from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances, PumpGaps
from atleak.catalogue.repairs import Repair
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.provisional import AssumedBasis
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.engine.projection import project
from atleak.equations import pump as equations
from atleak.job.result import result_record
from atleak.measurements.clearances import clearances
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.json.schemas import schema
from atleak.report.pdf import write_pdf
from atleak.report.sheets.measuring_columns import PUMP_SIDE, PUMP_TIP, SHEET
from atleak.report.sheets.measuring_sheet import write_readings, write_template
from atleak.report.tables.estimate import EstimateWords, open_words
from atleak.report.tables.first_sentence import first_sentence, pump_sentence
from atleak.report.tables.sentences import counted_in_speed, shares_add_up
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook
from tests.unit.conftest import first_of
from tests.unit.report.sheet_calculator import SheetCalculator

WORN = PumpClearances.of_um(85.0, 160.0)
DM3_MIN = 60e3
Judge, SheetOf = Callable[..., Diagnosis], Callable[..., Readings]


@pytest.fixture(scope="module")
def unit(root: Path) -> Controller:
    """A valve body with circuits and a crescent pump of which everything can be computed."""
    tables: dict[str, Any] = tomllib.loads((root / "tests" / "three_circuits.toml").read_text(encoding="utf-8"))
    tables["pump"] = {
        "kind": "crescent",
        "teeth": 24,
        "ring_teeth": 29,
        "width_mm": 15.0,
        "tip_diameter_mm": 77.5,
        "ring_tip_diameter_mm": 82.5,
        "centre_distance_mm": 7.5,
        "root_diameter_mm": 66.0,
        "shaft_diameter_mm": 48.0,
        "ring_root_diameter_mm": 94.0,
        "ring_outer_diameter_mm": 110.0,
        "tip_land_mm": 2.0,
        "sealing_tips": 3,
        "side_clearance_um": 35.0,
        "side_clearance_limit_um": 50.0,
        "tip_clearance_um": 110.0,
        "slip_coefficient": 5.0e-8,
        "volumetric_efficiency": 0.92,
        "source": "made for tests",
    }
    return checked_controller(tables, "unit.toml")


@pytest.fixture(scope="module")
def read(unit: Controller, readings_of: Callable[..., Readings]) -> Readings:
    """The readings of a unit whose first land is worn to twice its clearance."""
    radial = {land.key: land.new_clearance * (2.0 if land is unit.lands[0] else 1.0) for land in unit.lands}
    return readings_of(
        unit,
        {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * radial[land.key]) for land in unit.lands},
    )


@pytest.fixture(scope="module")
def diagnosed(unit: Controller, read: Readings, hipol: Fluid, limits: Limits) -> Callable[..., Diagnosis]:
    def build(measured: PumpClearances = NO_CLEARANCES, **more: Any) -> Diagnosis:
        return diagnose(unit, hipol, limits, readings=read, pump_clearances=measured, **more)

    return build


@pytest.fixture(scope="module")
def sound(diagnosed: Callable[..., Diagnosis]) -> Diagnosis:
    return diagnosed()


@pytest.fixture(scope="module")
def worn_pump(diagnosed: Callable[..., Diagnosis]) -> Diagnosis:
    return diagnosed(WORN)


def test_a_worn_pump_slips_more_and_delivers_less(unit: Controller, sound: Diagnosis, worn_pump: Diagnosis) -> None:
    before, after = sound.hot_idle, worn_pump.hot_idle
    assert before is not None
    assert after is not None
    viscosity, main = float(sound.model.dynamic_viscosity(before.condition.temperature)), before.condition.main_pressure
    opened = equations.face_slip(85e-6, 0.066, 0.048) + equations.face_slip(85e-6, 0.110, 0.094)
    opened -= equations.face_slip(35e-6, 0.066, 0.048) + equations.face_slip(35e-6, 0.110, 0.094)
    more = opened * main / viscosity
    for sign, clearance in ((1, 160e-6), (-1, 110e-6)):
        more += sign * 2 * equations.tip_slip(main, clearance, 0.015, 0.002, 3, viscosity, 800.0)
    assert more * DM3_MIN > 1.0
    assert after.slip - before.slip == pytest.approx(more, rel=1e-9, abs=0.0)
    assert before.pump_capacity - after.pump_capacity == pytest.approx(more, rel=1e-9, abs=0.0)
    assert after.share > before.share
    assert after.reserve < before.reserve
    assert after.minimum_speed - before.minimum_speed == pytest.approx(more / unit.pump.displacement, rel=1e-9, abs=0)
    assert after.leakage == before.leakage


def test_the_same_unit_new_has_a_new_pump_where_pressures_are_judged(sound: Diagnosis, worn_pump: Diagnosis) -> None:
    for now, as_new, of_sound in zip(
        worn_pump.projections, worn_pump.unworn_projections, sound.unworn_projections, strict=True
    ):
        assert (as_new.reserve, as_new.main_pressure_held) == (of_sound.reserve, of_sound.main_pressure_held)
        rule, before = (each.pressure_rule(each.at(now.condition), RuleKind.RESERVE) for each in (worn_pump, sound))
        assert rule is not None
        assert before is not None
        assert (rule.new, rule.steps) == (before.new, before.steps)
        low, high = worn_pump.uncertainty.total(now.condition.name).reserve_interval  # type: ignore[union-attr]
        assert low < now.reserve < high


def test_a_worn_pump_blames_no_land(sound: Diagnosis, worn_pump: Diagnosis) -> None:
    """What a land and the valve body draw is compared with the same drawn when new, from the same pump."""
    for now, new, before, before_new in zip(
        worn_pump.projections,
        worn_pump.new_projections,
        sound.projections,
        sound.new_projections,
        strict=True,
    ):
        assert now.share / new.share == pytest.approx(before.share / before_new.share, rel=1e-12, abs=0.0)
    assert [land.wear for land in worn_pump.lands] == [land.wear for land in sound.lands]


@pytest.fixture(scope="module")
def judge(hipol: Fluid, limits: Limits) -> Callable[..., Diagnosis]:
    """A unit with its sheet and what was measured of its pump [µm], diagnosed once."""
    kept: dict[object, Diagnosis] = {}

    def judged(unit: Controller, sheet: Readings, side: float | None = None, tip: float | None = None) -> Diagnosis:
        measured, key = PumpClearances.of_um(side, tip), (unit.id, unit.pump.limits, sheet.readings, side, tip)
        if key not in kept:
            kept[key] = diagnose(unit, hipol, limits, readings=sheet, pump_clearances=measured)
        return kept[key]

    return judged


@pytest.fixture(scope="module")
def sheet_of(readings_of: Callable[..., Readings]) -> Callable[..., Readings]:
    """A sheet of new pairs, 1 µm wider than the mean, but for one land that is so many times as wide."""

    def sheet(unit: Controller, times: float = 1.0, key: tuple[str, int] | None = None) -> Readings:
        worn = key or unit.lands[0].key
        wide = {land.key: land.new_clearance * (times if land.key == worn else 1.0) + 0.5e-6 for land in unit.lands}
        diameters = ((land, land.nominal_diameter) for land in unit.lands)
        return readings_of(unit, {land.key: (d, d + 2.0 * wide[land.key]) for land, d in diameters})

    return sheet


SMALL = Path(__file__).parents[2] / "three_circuits.toml"
BODIES = (SMALL, "ford_4r70w", "jatco_jf506e")
NEW_UM, LIMIT_UM = 35.0, 50.0


@cache
def with_gap(name: str | Path) -> Controller:
    """A valve body with a pump whose side clearance makes it slip, from 35 µm when new to 50 µm at the most."""
    unit = load_controller(name)
    of_side = PumpClearances.of_um(NEW_UM, None), PumpClearances.of_um(LIMIT_UM, None)
    gaps = PumpGaps(1.2e6, None)
    return replace(unit, pump=replace(unit.pump, gaps=gaps, clearances=of_side[0], limits=of_side[1]))


def leakiest(unit: Controller, fluid: Fluid) -> tuple[str, int]:
    """The land that draws most from the pump when new."""
    new = project(LeakageModel(unit, clearances(None, unit), fluid, WORKSHOP), unit.operating_points[0])
    return max(unit.lands, key=lambda land: new.drawn_by(land.key)).key


@pytest.mark.parametrize(
    ("name", "side_um"),
    first_of([(SMALL, 70.0), *itertools.product(BODIES[1:], (70.0, 100.0))]),
)
def test_a_worn_pump_is_named_first_and_no_unworn_valve(
    name: str, side_um: float, judge: Judge, sheet_of: SheetOf, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = with_gap(name)
    sheet = sheet_of(unit)
    assert judge(unit, sheet).verdict == Verdict.OK
    diagnosis = judge(unit, sheet, side_um)
    record = diagnosis_record(diagnosis)
    to_json(record)
    assert record["unit"]["decided_by"]["kind"] == "pump"
    assert record["unit"]["verdict"] == record["pump"]["verdict"] != "ok"
    assert not diagnosis.flagged
    (step,) = record["repair_plan"]
    assert (step["component"], step["land"], step["chosen"], step["options"]) == ("pump", None, None, [])
    for before, after in zip(record["conditions"], step["conditions"], strict=True):
        assert after["p_g_held_after_kpa"] >= before["p_g_held_kpa"]
        assert after["reserve_after"] > before["reserve"]
    assert record["repair_plan_ends"]["reached"]
    assert "description_impossible" not in {message["code"] for message in record["messages"]}
    if side_um > 90.0:
        assert min(each["p_g_held_kpa"] / each["p_g_kpa"] for each in record["conditions"]) < 0.95
        assert "With every valve as new the same pressure would be missing." in first_sentence(diagnosis, wording("en"))
    print_diagnosis(diagnosis)
    printed = " ".join(capsys.readouterr().out.split())
    assert f"The pump: side clearance {side_um:.0f} µm, limit 50 µm." in printed.replace("\u00a0", " ")
    assert max(map(printed.index, ("The pump: side", "Repair the pump first."))) < printed.index("1. ")
    assert "1. pump (as new: the valve body's file names no repair of it): " in printed
    assert not re.search(r"\binf\b|∞|Look first", printed)
    with pypdfium2.PdfDocument(write_pdf(diagnosis)) as document:
        page = " ".join(document[0].get_textpage().get_text_range().split())
        assert "–\u00a0%" not in document[1].get_textpage().get_text_range()
    assert "The pump is worn and has to be repaired first." in page
    assert "Repair:" not in page
    assert "∞" not in page


@pytest.mark.parametrize("name", first_of(BODIES))
def test_a_worn_land_does_not_hide_behind_a_worn_pump(name: str, hipol: Fluid, judge: Judge, sheet_of: SheetOf) -> None:
    unit = with_gap(name)
    key = leakiest(unit, hipol)
    sheet = sheet_of(unit, 4.0, key)
    sound, both = (judge(unit, sheet, um) for um in (None, 100.0))
    assert [land.key for land in sound.flagged] == [key]
    for before, after in zip(sound.lands, both.lands, strict=True):
        assert (after.key, after.verdict, after.decision) == (before.key, before.verdict, before.decision)
        assert [rule.value for rule in after.rules] == [rule.value for rule in before.rules]
    assert {step.land.key for step in plan_repairs(both).steps} == {step.land.key for step in plan_repairs(sound).steps}
    assert diagnosis_record(both)["unit"]["decided_by"]["kind"] == "pump"


REPAIRS = (
    Repair("new_one", (), "new_pump", "new pump", "made up", "MADE-UP-9", 310.0, "EUR", 2.0),
    Repair("overhauled", (), "overhaul", "pump overhaul", "made up", price=95.5, currency="EUR"),
)


@pytest.mark.parametrize("name", first_of(BODIES))
def test_a_worn_pump_is_the_first_step_of_the_plan_with_its_repair(
    name: str, hipol: Fluid, judge: Judge, sheet_of: SheetOf, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = replace(with_gap(name), repairs=REPAIRS, id=f"{name}_with_repairs")
    key = leakiest(unit, hipol)
    diagnosis = judge(unit, sheet_of(unit, 4.0, key), 100.0)
    plan = plan_repairs(diagnosis)
    pump, land = plan.order
    assert pump is plan.pump
    assert pump.chosen is not None
    assert (pump.chosen.repair.id, land.land.key) == ("overhauled", key)  # type: ignore[union-attr]
    assert plan.cost is not None
    assert (plan.cost.prices, plan.cost.without_hours, plan.cost.without_option) == ({"EUR": 95.5}, 1, 1)
    for end, new in zip(plan.ends, diagnosis.pump_new.new_projections, strict=True):  # type: ignore[union-attr]
        assert end.reserve == pytest.approx(new.reserve, rel=0.02, abs=0.0)
    for before, as_measured in zip(pump.conditions, diagnosis.projections, strict=True):
        assert before.before.reserve == pytest.approx(as_measured.reserve, rel=1e-9, abs=0.0)

    wanted = replace(diagnosis, repairs=REPAIRS[:1])
    record = diagnosis_record(wanted)
    Draft202012Validator(schema("diagnose")).validate(result_record(wanted, None))
    assert [each["id"] for each in record["pump"]["repairs"]] == ["new_one", "overhauled"]
    step, of_land = record["repair_plan"]
    assert (step["component"], step["land"], step["chosen"]) == ("pump", None, "new_one")
    assert step["options"] == record["pump"]["repairs"]
    assert (of_land["component"], of_land["land"]) == key
    assert record["repair_plan_ends"]["cost"]["prices"] == [{"price": 310.0, "currency": "EUR"}]
    print_diagnosis(wanted)
    printed = " ".join(capsys.readouterr().out.split())
    assert re.search(
        r"1\. pump: .* → new pump \(MADE-UP-9\), as new, 310.00 EUR, 2.0 h or pump overhaul.* 2\. ", printed
    )
    with pypdfium2.PdfDocument(write_pdf(wanted)) as document:
        assert "Repair the pump first: new pump (MADE-UP-9)." in " ".join(
            document[0].get_textpage().get_text_range().split()
        )
    summary = openpyxl.load_workbook(io.BytesIO(write_workbook(wanted)), read_only=True).worksheets[0]
    cells = [[str(cell) for cell in row if cell is not None] for row in summary.iter_rows(values_only=True)]
    assert any(row[0] == "pump" for row in cells if row)
    assert any("new pump (MADE-UP-9)" in row for row in cells)


@pytest.mark.parametrize("name", first_of(BODIES))
def test_an_estimate_lists_the_pump_first_and_without_it_the_pump_stays_worn(
    name: str, judge: Judge, sheet_of: SheetOf
) -> None:
    unit = replace(with_gap(name), repairs=REPAIRS, id=f"{name}_with_repairs")
    diagnosis, job = judge(unit, sheet_of(unit), 100.0), Job()
    made = estimate(diagnosis, job)
    (line,) = made.lines
    assert (line.of_pump, line.price, line.carried_out, line.chosen) == (True, 95.5, True, True)
    assert made.past == ()
    assert any("pump" in each for each in open_words(diagnosis, job, wording("en"), closing=True))
    declined = with_line(job, line, decision="declined", reason="the customer sells the car")
    without = estimate(diagnosis, declined)
    assert [(each.of_pump, each.own) for each in without.lines] == [(True, True)]
    assert {rule.id for rule in without.past} >= {rule.id for rule in diagnosis.pump.lacking}
    assert made.stays_past(line) == without.past
    assert [at.after.share for at in without.effect] == [at.before.share for at in made.effect]
    assert all(at.before.share > at.after.share for at in made.effect), "a worn pump delivers less"
    assert EstimateWords(without, wording("de")).pair(without.lines[0]) == "Pumpe"
    assert list(open_words(diagnosis, declined, wording("en"), closing=True)) == []
    assert list(decision_faults(declined, unit)) == []
    assert with_repairs(OfferedRepairs(diagnosis), job, ()).repair_decisions == ()


@pytest.mark.parametrize("name", first_of(BODIES))
def test_a_pump_within_its_limit_is_not_worn_and_leads_over_no_worn_land(
    name: str, hipol: Fluid, judge: Judge, sheet_of: SheetOf, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = with_gap(name)
    unit = replace(unit, pump=replace(unit.pump, limits=PumpClearances.of_um(120.0, None)))
    key = leakiest(unit, hipol)
    unworn, worn = (judge(unit, sheet_of(unit, times, key), 70.0) for times in (1.0, 4.0))
    for diagnosis in (unworn, worn):
        record = diagnosis_record(diagnosis)
        assert (record["pump"]["verdict"], record["pump"]["repairs"], diagnosis.pump.lacking) == ("ok", [], ())
        assert record["unit"]["decided_by"]["kind"] != "pump"
        assert plan_repairs(diagnosis).pump is None
        assert "Repair the pump first" not in first_sentence(diagnosis, wording("en"))
    assert not unworn.flagged
    assert unworn.verdict.flagged
    print_diagnosis(unworn)
    printed = " ".join(capsys.readouterr().out.split())
    assert "With a new pump it would be within its limits." in printed
    assert "Look first" not in printed
    assert [land.key for land in worn.flagged] == [key]


@pytest.mark.parametrize("name", first_of(BODIES))
def test_new_valves_are_said_to_be_as_short_only_where_they_are_past_a_limit(
    name: str, judge: Judge, sheet_of: SheetOf, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = with_gap(name)
    sheet = sheet_of(unit, 3.0)
    for side_um in (51.0, 60.0, 100.0):
        if "With every valve as new" in first_sentence(judge(unit, sheet, side_um), wording("en")):
            assert any(rule.verdict.flagged for rule in judge(unit, sheet_of(unit), side_um).unit_rules)
    unit = replace(unit, pump=replace(unit.pump, limits=PumpClearances.of_um(50.0, 30.0)))
    one = judge(unit, sheet, 60.0, 20.0)
    said = first_sentence(one, wording("en"))
    assert "The pump: side clearance 60\u00a0µm, limit 50\u00a0µm." in said
    assert "tip clearance" not in said
    print_diagnosis(one)
    assert "first.," not in " ".join(capsys.readouterr().out.split())


def test_a_pump_over_its_limit_is_past_it_whatever_the_valves_do(
    diagnosed: Callable[..., Diagnosis], worn_pump: Diagnosis, sound: Diagnosis
) -> None:
    assert sound.pump.verdict == Verdict.NOT_MEASURED
    assert worn_pump.pump.verdict.calls_for_repair
    at_limit = diagnosed(PumpClearances.of_um(50.0, None))
    assert [each.rule.verdict for each in at_limit.pump.decisions] == [Verdict.OK]  # so much its manual allows
    over = diagnosed(PumpClearances.of_um(51.0, None))
    assert [(each.rule.verdict, each.decision) for each in over.pump.decisions] == [
        (Verdict.REPLACE, "conditional_fail")
    ]


@pytest.mark.parametrize("known", ["published", "representative"])
def test_a_verdict_by_a_representative_limit_of_the_pump_is_provisional(
    known: str, unit: Controller, read: Readings, hipol: Fluid, limits: Limits
) -> None:
    assert unit.entry is not None
    data = unit.entry.model_dump(by_alias=True, exclude_unset=True)
    data["pump"][known] = ["side_clearance_limit_um"]
    described = checked_controller(data, "unit.toml")
    over = diagnose(described, hipol, limits, readings=read, pump_clearances=PumpClearances.of_um(51.0, None))
    assert over.decided_by is over.pump
    assert (AssumedBasis.PUMP in over.provisional) is (known == "representative")


def test_how_sure_the_reserve_is_follows_from_the_clearances_too(
    diagnosed: Callable[..., Diagnosis], worn_pump: Diagnosis
) -> None:
    sure = diagnosed(WORN, assumptions=replace(worn_pump.uncertainty.assumptions, pump_clearance=0.0))  # type: ignore[union-attr]

    def width(diagnosis: Diagnosis) -> float:
        low, high = diagnosis.uncertainty.total("hot_idle").reserve_interval  # type: ignore[union-attr]
        return high - low

    assert width(worn_pump) > 1.02 * width(sure)


def test_one_line_says_it_in_every_language(worn_pump: Diagnosis, sound: Diagnosis) -> None:
    idle = worn_pump.hot_idle
    assert idle is not None
    now, new = (f"{each.slip * DM3_MIN:.2f}" for each in (idle, worn_pump.new_at(idle)))
    said = pump_sentence(worn_pump, wording("en"))
    assert said == (
        "This job's pump was measured: side clearance 85\u00a0µm (new 35\u00a0µm, at most 50\u00a0µm), "
        f"tip clearance 160\u00a0µm (new 110\u00a0µm). At “hot idle” it slips {now} dm³/min, {new} when new."
    )
    for language in ("de", "pl"):
        translated = pump_sentence(worn_pump, wording(language))
        assert translated is not None
        assert all(number.replace(".", ",") in translated for number in (now, new))
    assert pump_sentence(sound, wording("en")) is None


def test_the_record_holds_the_pump_and_its_slip_beside_that_when_new(worn_pump: Diagnosis, sound: Diagnosis) -> None:
    record, idle = diagnosis_record(worn_pump), worn_pump.hot_idle
    assert idle is not None
    pump = record["pump"]
    assert (pump["kind"], pump["held_at_demand"]) == ("crescent", False)
    assert (pump["side_clearance_measured_um"], pump["side_clearance_new_um"]) == (85.0, 35.0)
    assert (pump["tip_clearance_measured_um"], pump["side_clearance_limit_um"]) == (160.0, 50.0)
    assert pump["slip_coefficient"] > pump["slip_coefficient_new"] == 5e-8
    assert record["hot_idle"]["pump_slip_dm3_min"] == pytest.approx(idle.slip * DM3_MIN, rel=1e-12, abs=0.0)
    assert record["hot_idle"]["pump_slip_new_dm3_min"] < record["hot_idle"]["pump_slip_dm3_min"]
    assert diagnosis_record(sound)["hot_idle"]["pump_slip_new_dm3_min"] is None
    codes = {message["code"]: message["text"] for message in record["messages"]}
    assert "85 µm is over the 50 µm" in codes["pump_clearance_over_limit"]


def test_the_workbook_s_formulas_give_the_slip_and_both_reserves(worn_pump: Diagnosis) -> None:
    content, idle = write_workbook(worn_pump), worn_pump.hot_idle
    assert idle is not None
    sheets, names = SheetCalculator(content), openpyxl.load_workbook(io.BytesIO(content)).defined_names
    new = worn_pump.unworn_at(idle)
    assert sheets.wrong() == []
    prefix = "stated" if idle is worn_pump.projection else "hot_idle"
    for name, value in (
        ("slip", idle.slip * DM3_MIN),
        ("slip_new", new.slip * DM3_MIN),
        ("reserve", idle.reserve),
        ("reserve_new", new.reserve),
    ):
        sheet, address = names[f"{prefix}_{name}"].attr_text.split("!")
        assert sheets.value(sheet.strip("'"), address.replace("$", "")) == pytest.approx(value, rel=1e-9, abs=0.0)


# --- where it is written


def test_the_sheet_s_head_asks_for_what_the_file_can_use_and_is_read_back(
    unit: Controller, read: Readings, minimal: Controller, hipol: Fluid, limits: Limits
) -> None:
    cells = {
        cell.value: cell
        for row in openpyxl.load_workbook(io.BytesIO(write_template(unit)))[SHEET]["A4:N7"]
        for cell in row
        if cell.value
    }
    asked = {f"{PUMP_SIDE} [µm]", f"{PUMP_TIP} [µm]"}
    assert asked <= cells.keys()
    bare = openpyxl.load_workbook(io.BytesIO(write_template(minimal)))[SHEET]["A4:N7"]
    assert not asked & {cell.value for row in bare for cell in row}
    fields = {PUMP_SIDE: "85", PUMP_TIP: "0.0063 in"}
    again = read_readings(write_readings(unit, read.readings, fields=fields), unit, name="sheet.xlsx")
    assert again.pump.um == (85.0, 160.02)
    of_sheet = diagnose(unit, hipol, limits, readings=again)
    assert of_sheet.controller.pump.measured.um == (85.0, 160.02)
    of_job = diagnose(unit, hipol, limits, readings=again, pump_clearances=PumpClearances.of_um(60.0, None))
    assert of_job.controller.pump.measured.um == (60.0, 160.02)
    texts = {message.code: message.text for message in of_job.messages}
    assert "states a pump side clearance of 85 µm, the job 60 µm" in texts["pump_clearance_differs"]


def test_a_profile_with_a_constant_efficiency_says_that_the_clearances_count_nowhere(
    diagnosed: Callable[..., Diagnosis],
) -> None:
    paper, without = diagnosed(WORN, profile=PAPER), diagnosed(profile=PAPER)
    assert paper.projection.share == without.projection.share
    assert "pump_clearance_left_out" in {message.code for message in paper.messages}
    assert "no slip in this result" in (pump_sentence(paper, wording("en")) or "")


def test_clearances_of_a_pump_that_the_file_does_not_describe_are_said_to_count_nowhere(
    minimal: Controller, hipol: Fluid, limits: Limits
) -> None:
    without = diagnose(minimal, hipol, limits)
    measured = diagnose(minimal, hipol, limits, pump_clearances=WORN)
    assert measured.projection.share == without.projection.share
    texts = [message.text for message in measured.messages if message.code == "pump_clearance_left_out"]
    assert len(texts) == 2
    assert "does not state the kind of the pump" in texts[0]


# --- a pump held at demand


def test_shares_and_speed_of_a_pump_held_at_demand_are_said_to_be_of_its_full_stroke(
    unit: Controller, hipol: Fluid, limits: Limits, sound: Diagnosis
) -> None:
    held = replace(unit, pump=replace(unit.pump, held_at_demand=True))
    diagnosis = diagnose(held, hipol, limits)
    for language, words in (("en", "full stroke"), ("de", "vollen Hub"), ("pl", "pełnego skoku")):
        say = wording(language)
        assert words in counted_in_speed(diagnosis, say)
        assert shares_add_up(diagnosis, say).endswith(f"{words}.")
        assert words not in counted_in_speed(sound, say) + shares_add_up(sound, say)
    assert diagnosis.projection.pump_supply == unit.pump.displacement * diagnosis.projection.condition.engine_speed
    assert "pump_full_stroke" in {message.code for message in diagnosis.messages}
    assert diagnosis_record(diagnosis)["pump"]["held_at_demand"] is True
