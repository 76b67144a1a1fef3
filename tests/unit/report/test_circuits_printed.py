"""Workbook and PDF of a unit with circuits, rings and consumers: recalculated, changed and read back."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import openpyxl
import pandas as pd
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.translations import languages
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import begun, signed, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import Rule
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.measurements.job_card import Job
from atleak.report.pdf import report_data, write_pdf
from atleak.report.tables.assumed import assumed_line
from atleak.report.tables.first_sentence import first_sentence
from atleak.report.xlsx import write_workbook
from tests.unit.conftest import first_of
from tests.unit.report.read_back import is_archival, text_of

UM = 1e-6
Sheets = Callable[..., pd.DataFrame]
Unit = Callable[..., Diagnosis]

CONTROLLER = """
id = "with_circuits"
name = "A valve body with circuits"
source = "made up"
date = "2026-11-21"
gears = [1, 2]
[materials.aluminium]
expansion_per_k = 21e-6
source = "made up"
[defaults]
contact_length_mm = 5.0
mounting_clearance_um = 13.0
body = "aluminium"
spool = "aluminium"
[pump]
displacement_mm3 = 18000.0
volumetric_efficiency = 0.92
slip_coefficient = 5.0e-8
source = "made up"
[[operating_points]]
name = "hot_idle"
label = "hot idle"
temperature_c = 100.0
engine_rpm = 700.0
gear = 1
p_g_kpa = 500.0
p_k_kpa = 250.0
source = "made up"
[[operating_points]]
name = "driving"
label = "driving"
temperature_c = 80.0
engine_rpm = 1500.0
gear = 2
p_g_kpa = 800.0
p_k_kpa = 400.0
source = "made up"
[[circuits]]
id = "epc"
name = "pressure control EPC"
feeds = [{ from = "p_g", diameter_mm = 0.8 }]
set_kpa = { hot_idle = 200.0, driving = 250.0 }
source = "made up"
[[circuits]]
id = "clutch_1"
name = "first clutch"
gears = [1]
feeds = [{ from = "p_g", diameter_mm = 0.5, discharge_coefficient = 0.62 }]
source = "made up"
[[circuits]]
id = "clutch_2"
name = "second clutch"
gears = [2]
feeds = [{ from = "p_g", diameter_mm = 1.0 }]
set_kpa = 600.0
source = "made up"
[[leaks]]
id = "rings"
from = "clutch_1"
law = "laminar"
flow_dm3_min = 0.02
at_kpa = 400.0
at_viscosity_mm2_s = 7.0
source = "made up"
[[leaks]]
id = "check_ball"
name = "check ball"
from = "clutch_2"
law = "orifice"
flow_dm3_min = 0.03
at_kpa = 400.0
source = "made up"
[[consumers]]
id = "cooler"
flow_dm3_min = { hot_idle = 3.0, driving = 6.0 }
after_line = true
source = "made up"
[[consumers]]
id = "lubrication"
flow_dm3_min = 1.0
at_kpa = 400.0
source = "made up"
[[permissible_pressure]]
gear = 1
state = "idle"
low_kpa = 480.0
high_kpa = 539.0
source = "made up"
[[components]]
id = "regulator"
name = "pressure regulator"
lands = [{ land = 1, nominal_diameter_mm = 15.0 }, { land = 2, nominal_diameter_mm = 12.5 }]
[[components]]
id = "first"
name = "valve of the first clutch"
lands = [{ land = 1, nominal_diameter_mm = 14.5 }, { land = 2, nominal_diameter_mm = 14.5 }]
[[components]]
id = "second"
name = "valve of the second clutch"
lands = [{ land = 1, nominal_diameter_mm = 14.5 }, { land = 2, nominal_diameter_mm = 14.5 }]
[[components]]
id = "control"
name = "EPC valve"
lands = [{ land = 1, nominal_diameter_mm = 10.0 }]
[[gaps]]
component = "regulator"
land = 1
from = "p_g"
to = "drain"
gears = [1, 2]
[[gaps]]
component = "regulator"
land = 2
from = "p_g"
to = "epc"
gears = [1, 2]
[[gaps]]
component = "first"
land = 1
from = "clutch_1"
to = "drain"
gears = [1]
[[gaps]]
component = "first"
land = 2
from = "clutch_1"
to = "epc"
gears = [1]
[[gaps]]
component = "second"
land = 1
from = "0.5*clutch_2"
to = "drain"
gears = [2]
[[gaps]]
component = "second"
land = 2
from = "p_g"
to = "clutch_2"
gears = [2]
[[gaps]]
component = "control"
land = 1
from = "epc"
to = "35 kPa"
gears = [1, 2]
"""
LAND = dict[tuple[str, int], float]
NEW: LAND = {}
WORN: LAND = {("first", 1): 35.0}
EMPTIED: LAND = {("first", 1): 90.0}  # the clutch holds less than EPC, which leaks back into it
TOO_MUCH: LAND = {("regulator", 1): 150.0, ("regulator", 2): 150.0}  # for the pump: the line falls, EPC relieves
UNITS = {"new": NEW, "worn": WORN, "emptied": EMPTIED, "too much": TOO_MUCH}
SLOW = pytest.mark.slow
every_unit = pytest.mark.parametrize("clearances", UNITS.values(), ids=UNITS)


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Controller:
    path = tmp_path_factory.mktemp("controllers") / "with_circuits.toml"
    path.write_text(CONTROLLER, encoding="utf-8")
    return load_controller(path)


@pytest.fixture(scope="module")
def unit(controller: Controller, readings_of: Any, hipol: Fluid, limits: Limits) -> Unit:
    """A unit with some lands so wide [µm], all others as new; without any readings where none are given."""

    def build(clearances: LAND | None, **options: Any) -> Diagnosis:
        readings = None
        if clearances is not None:
            widths = {land.key: clearances.get(land.key, land.new_clearance / UM) * UM for land in controller.lands}
            found = {
                each.key: (each.nominal_diameter, each.nominal_diameter + 2.0 * widths[each.key])
                for each in controller.lands
            }
            readings = readings_of(controller, found)
        return diagnose(
            options.pop("controller", controller), hipol, options.pop("limits", limits), readings=readings, **options
        )

    return build


def sheet(content: bytes, name: str) -> pd.DataFrame:
    return pd.read_excel(io.BytesIO(content), sheet_name=name, engine="calamine")


def values(content: bytes) -> dict[str, list[Any]]:
    """The sheet of conditions: a quantity's values at every condition."""
    table = sheet(content, "Conditions")
    return {row.iloc[0]: row.iloc[2:].tolist() for _, row in table.iterrows()}


# --- the workbook computes


@every_unit
def test_every_formula_gives_what_atleak_gives(unit: Unit, clearances: LAND, calculator: Any) -> None:
    assert calculator(write_workbook(unit(clearances))).wrong() == []


@pytest.mark.parametrize(
    "profile",
    first_of(
        [
            PAPER,
            WORKSHOP.with_options(circuits="off"),
            WORKSHOP.with_options(entry_loss="off", eccentricity="unknown"),
            WORKSHOP.with_options(form="cube_of_mean", viscosity="regression", eccentricity="0.4"),
        ]
    ),
    ids=["paper", "circuits off", "no entry loss", "cube of mean"],
)
def test_every_formula_does_so_in_other_profiles(unit: Unit, profile: Any, calculator: Any) -> None:
    assert calculator(write_workbook(unit(EMPTIED, profile=profile))).wrong() == []


@pytest.mark.slow
@pytest.mark.parametrize("clearances", [EMPTIED, TOO_MUCH], ids=["back", "falls"])
def test_libreoffice_gives_what_atleak_gives(unit: Unit, clearances: LAND, recalculated: Any, referee: Any) -> None:
    content = write_workbook(unit(clearances))
    book, issued = (openpyxl.load_workbook(io.BytesIO(content), data_only=data) for data in (False, True))
    assert referee.differing(book, recalculated(book), issued) == []


def test_the_total_is_made_of_gaps_rings_and_what_circuits_relieve(unit: Unit) -> None:
    found = unit(TOO_MUCH)
    projection, rows = found.projection, values(write_workbook(found))
    assert projection.relieved * 6e4 == pytest.approx(
        rows["relieved to the sump by circuits, as issued"][0], rel=1e-12, abs=0.0
    )
    assert rows["leak: rings"][0] == pytest.approx(projection.leaks[0].flow * 6e4, rel=1e-12, abs=0.0)
    assert rows["leak: check ball"][0] == 0.0  # not in first gear
    drawn = sum(gap.leakage for gap in projection.gaps if gap.drawn_from_pump)
    total = drawn + projection.leaks[0].flow + projection.relieved
    assert projection.relieved > 0.01 * drawn
    assert rows["leakage drawn from the pump, spools concentric"][0] == pytest.approx(total * 6e4, rel=1e-12, abs=0.0)


def test_a_gap_that_leaks_back_has_a_negative_flow(unit: Unit) -> None:
    gaps = sheet(write_workbook(unit(EMPTIED)), "Gaps")
    (back,) = gaps[gaps["component"].eq("first") & gaps["land"].eq(2)].to_dict("records")
    assert back["to"] == "epc"
    assert back["pressure drop Δp [kPa]"] < -50.0
    assert back["leakage q [mm³/s], spools concentric"] < -1.0
    assert back["Reynolds number"] > 0.0


def test_flows_follow_a_changed_pressure_of_a_circuit(unit: Unit, calculator: Any) -> None:
    sheets = calculator(write_workbook(unit(WORN)))
    name = sheets.book.defined_names["stated_c_clutch_1"]
    place, _, address = name.attr_text.rpartition("!")
    heads = {cell.value: cell.column_letter for cell in sheets.book["Gaps"][1]}
    row = next(cells[0].row for cells in sheets.book["Gaps"].iter_rows(min_row=2) if cells[0].value == "first")
    flow = f"{heads['leakage q [mm³/s], spools concentric']}{row}"
    before, pressure = sheets.value("Gaps", flow), sheets.value(place, address)
    sheets.set(place, address.replace("$", ""), pressure * 2.0)
    assert sheets.value("Gaps", flow) == pytest.approx(2.0 * before, rel=0.05, abs=0.0)  # but for the entry loss
    assert "not followed by the sheet" in str(list(sheets.book["Circuits"].values)[-1][0])


def test_changed_consumers_and_limits_give_what_atleak_gives(
    unit: Unit, controller: Controller, limits: Limits, calculator: Any, referee: Any
) -> None:
    sheets = calculator(write_workbook(unit(WORN)))
    for name, value in (
        ("stated_consumer_1", 5.0),
        ("driving_consumer_1", 9.0),
        ("stated_consumer_2_at", 250.0),
        ("driving_consumer_2_at", 250.0),
    ):
        place, _, address = sheets.book.defined_names[name].attr_text.rpartition("!")
        sheets.set(place, address.replace("$", ""), value)
    lubrication = replace(controller.consumers[1], pressure=250e3)
    cooler = replace(controller.consumers[0], flow={"hot_idle": 5.0 / 6e4, "driving": 9.0 / 6e4})
    for label, level, value in (
        ("reserve of the pump, under", "amber", 2.2),
        ("reserve of the pump, under", "red", 1.5),
        ("or, where the same unit new is under it", "amber", 1.0),
        ("or, where the same unit new is under it", "red", 1.0),
        ("or, where the same unit new is under it", "critical", 1.0),
        ("pressure that a circuit lost", "watch", 20.0),
    ):
        row = next(row for row in sheets.book["Limits"].iter_rows() if str(row[0].value).startswith(label))
        (column,) = (cell.column for cell in sheets.book["Limits"][1] if cell.value == level)
        assert row[column - 1].value is not None
        sheets.set("Limits", row[column - 1].coordinate, value)
    assert limits.reserve is not None
    assert limits.circuit_loss is not None
    (amber, _), (red, _), critical = limits.reserve.levels
    reserve = replace(limits.reserve, levels=((amber, 2.2), (red, 1.5), critical), fall=0.01)
    loss = replace(limits.circuit_loss, levels=((Verdict.WATCH, 20e3), limits.circuit_loss.levels[1]))
    changed = unit(
        WORN,
        controller=replace(controller, consumers=(cooler, lubrication)),
        limits=replace(limits, reserve=reserve, circuit_loss=loss),
    )
    assert {rule.verdict for rule in changed.pressure_rules if rule.kind is RuleKind.RESERVE} != {Verdict.OK}
    expected = openpyxl.load_workbook(io.BytesIO(write_workbook(changed)), data_only=True)
    assert referee.differing(sheets.book, sheets.value, expected) == []


# --- what stands where


@every_unit
def test_every_circuit_stands_with_its_pressures_verdict_and_causes(unit: Unit, clearances: LAND) -> None:
    found = unit(clearances)
    table = sheet(write_workbook(found), "Circuits").dropna(subset="circuit")
    assert len(table) == len(found.projections) * (1 + len(found.controller.circuits))
    at = found.projection
    (row,) = table[table["condition"].eq("hot idle") & table["circuit"].eq("clutch_1")].to_dict("records")
    state, new = at.circuit("clutch_1"), found.new_at(at).circuit("clutch_1")
    low, high = found.uncertainty.total(at.condition.name).circuit_intervals["clutch_1"]
    rule = found.pressure_rule(at, RuleKind.CIRCUIT_LOSS, state.circuit)
    expected = {
        "pressure held, as issued [kPa]": state.pressure / 1e3,
        "low, as issued [kPa]": low / 1e3,
        "high, as issued [kPa]": high / 1e3,
        "pressure held when new, as issued [kPa]": new.pressure / 1e3,
        "lost against new [kPa]": (new.pressure - state.pressure) / 1e3,
    }
    assert {name: row[name] for name in expected} == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert row["verdict"] == signed(rule.verdict)
    assert row["decision as issued"] == wording("en").get("decisions", found.decided(rule).decision)
    (vented,) = table[table["condition"].eq("hot idle") & table["circuit"].eq("clutch_2")].to_dict("records")
    assert vented["verdict"] == "vented in this gear"
    causes = found.losses_at(at)["clutch_1"]
    said = "; ".join(f"{component}/{land} {loss / 1e3:.1f} kPa" for (component, land), loss in causes.items())
    assert row["what a land costs it (with that land new), as issued"] == (
        said or pytest.approx(float("nan"), abs=0.0, nan_ok=True)
    )


def test_without_circuits_the_line_and_the_reserve_stand_among_the_conditions(worn: Diagnosis) -> None:
    content = write_workbook(worn)
    assert "Circuits" not in pd.ExcelFile(io.BytesIO(content), engine="calamine").sheet_names
    rows, shown = values(content), worn.presented
    assert rows["main pressure held, as issued"] == pytest.approx(
        [at.main_pressure_held / 1e3 for at in shown], abs=1e-9
    )
    reserve = "reserve of the pump: supply / (leakage + slip + consumers)"
    assert rows[reserve] == pytest.approx([at.reserve for at in shown], rel=1e-9, abs=0.0)
    assert rows["consumers (the valve body's file states none)"] == [0.0] * len(shown)


def test_every_rule_of_a_pressure_has_its_row_and_its_decision(unit: Unit) -> None:
    found = unit(TOO_MUCH)
    rules = sheet(write_workbook(found), "Rules")
    of_unit = rules[rules["component"] == "whole unit"].set_index("rule")
    assert len(of_unit) == len(found.unit_rules)
    for rule in found.unit_rules:
        row = of_unit.loc[rule.label + ", reached under its limit" * (rule.kind is RuleKind.RESERVE)]
        assert row["value"] == pytest.approx(rule.value * rule.kind.factor, rel=1e-9, abs=1e-9)
        assert row["verdict"] == signed(rule.verdict)
        assert row["decision as issued"] == wording("en").get("decisions", found.decided(rule).decision)
    below = of_unit.loc["main pressure below the permissible, hot idle"]
    assert below["critical from"] == 0.0  # published: the limit is the manual's own
    assert below["value"] > 1.0


def test_a_limit_of_nothing_is_a_zero_and_not_an_empty_cell(unit: Unit) -> None:
    limits = sheet(write_workbook(unit(NEW)), "Limits").set_index("limit")
    assert limits.loc["main pressure below the permissible [%]", "watch"] == 0.0
    assert limits.loc["reserve of the pump, under [-]", ["amber", "red"]].tolist() == [1.5, 1.2]


def test_nothing_that_was_not_measured_is_called_ok(unit: Unit, calculator: Any) -> None:
    content = write_workbook(unit(None))
    assert calculator(content).wrong() == []
    fine = signed(Verdict.OK)
    for name in ("Circuits", "Rules"):
        assert fine not in sheet(content, name)["verdict"].tolist()
        assert signed(Verdict.NOT_MEASURED) in sheet(content, name)["verdict"].tolist()


# --- the PDF


@pytest.mark.parametrize(
    ("clearances", "language"),
    [  # one unit in every language; the others in the longer round
        pytest.param(
            unit,
            language,
            id=f"{name}-{language}",
            marks=[] if name == "worn" else pytest.mark.slow,
        )
        for name, unit in UNITS.items()
        for language in languages()
    ],
)
def test_the_pdf_says_what_every_circuit_holds(unit: Unit, clearances: LAND, language: str) -> None:
    found, say = unit(clearances), wording(language)
    content = write_pdf(found, language=language)
    assert is_archival(content)
    text = text_of(write_pdf(found, language=language, sections=["pressures"]))
    assert say("sections.pressures") in text
    assert say("texts.held").replace(" ", "") in text.replace(" ", "")  # a line may end behind a hyphen
    for at in found.projections:
        assert say.number(at.reserve, 2) in text
        assert say.number(at.main_pressure_held / 1e3, 0) in text
        for state in at.circuits:
            assert state.circuit.name in text
            if not state.vented:
                loss = found.new_at(at).circuit(state.circuit.id).pressure - state.pressure
                assert say.number(state.pressure / 1e3, 0) in text
                assert say.number(loss / 1e3, 0) in text
    for rule in found.pressure_rules:
        assert say.level(rule.level) in text


@pytest.mark.parametrize("language", languages())
def test_the_pdf_of_a_unit_that_nobody_measured_calls_no_pressure_ok(unit: Unit, language: str) -> None:
    say = wording(language)
    text = text_of(write_pdf(unit(None), language=language, sections=["pressures"]))
    section = text[text.index(say("sections.pressures")) :]
    assert say.level(Verdict.NOT_MEASURED) in section
    assert not re.search(rf"\b{say.level(Verdict.OK)}\b", section)


@pytest.mark.parametrize("language", languages())
def test_the_pdf_names_the_consumers_that_the_lowest_speed_counts(unit: Unit, worn: Diagnosis, language: str) -> None:
    say = wording(language)
    consumers = ", ".join(map(say.name, ("cooler", "lubrication")))
    assert say("texts.counted_in_speed", consumers=consumers) in text_of(write_pdf(unit(WORN), language=language))
    assert say("texts.left_out_of_speed") in text_of(write_pdf(worn, language=language, sections=["limits"]))


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", ("amber under 1.5", "where the same unit new is under it, 10 % less than that", "watch over 0 %")),
        ("de", ("gelb unter 1,5", "10 % weniger als diese", "beobachten über 0 %")),
        ("pl", ("poniżej 1,5", "o 10 % mniej niż on", "powyżej 0 %")),
    ],
)
def test_the_limits_table_says_which_limits_fall_and_which_begin_at_nothing(
    unit: Unit, language: str, said: tuple[str, ...]
) -> None:
    text = text_of(write_pdf(unit(NEW), language=language, sections=["limits"])).replace("\u00a0", " ")
    assert [words for words in said if words not in text] == []


def test_the_matrix_says_what_leaks_beside_the_lands(unit: Unit) -> None:
    found = unit(TOO_MUCH)
    text = text_of(write_pdf(found, sections=["matrix"])).replace("\u00a0", " ")
    at = found.projection
    others = f"{at.share_of(at.other_leakage) * 100:.1f} % ({wording('en').condition(at.condition)})"
    assert "together with what leaks beside them" in text
    assert others in text


# --- what decided


def judged_by(kind: RuleKind, limits: Limits) -> Limits:
    """Limits that one kind of pressure is past first, and no land and no total."""
    assert limits.wear is not None
    assert limits.reserve is not None
    assert limits.below_permissible is not None
    wear = replace(limits.wear, levels=((Verdict.WATCH, 1e3),), at_least={})
    bands = (Band.AMBER, Band.RED, Band.CRITICAL)
    generous = replace(
        limits.total_share, levels=tuple((band, 50.0 + place) for place, band in enumerate(bands)), growth={}
    )
    reserve = replace(limits.reserve, levels=((Band.AMBER, 2.58), (Band.RED, 2.57), (Band.CRITICAL, 2.56)), fall=0.0)
    return replace(
        limits,
        wear=wear,
        pair_share=None,
        total_share=generous,
        reserve=reserve if kind is RuleKind.RESERVE else None,
        circuit_loss=limits.circuit_loss if kind is RuleKind.CIRCUIT_LOSS else None,
        below_permissible=limits.below_permissible if kind is RuleKind.PERMISSIBLE_PRESSURE else None,
    )


@pytest.fixture(
    params=[(RuleKind.CIRCUIT_LOSS, WORN), (RuleKind.RESERVE, WORN), (RuleKind.PERMISSIBLE_PRESSURE, TOO_MUCH)],
    ids=["circuit", "reserve", "permissible"],
)
def decided(request: pytest.FixtureRequest, unit: Unit, limits: Limits) -> tuple[Diagnosis, list[float]]:
    """A unit that a pressure decides, and the numbers that say it: kPa, or the reserve and its limit."""
    kind, clearances = request.param
    found = unit(clearances, limits=judged_by(kind, limits))
    rule = found.decided_by
    assert isinstance(rule, Rule)
    assert rule.kind is kind
    at = found.at(rule.condition)
    if rule.circuit is not None:
        circuits = (each.circuit(rule.circuit.id).pressure / 1e3 for each in (at, found.new_at(at)))
        return found, [float(f"{pressure:.0f}") for pressure in circuits]
    if kind is RuleKind.RESERVE:
        return found, [round(at.reserve, 2), round(rule.limit, 2)]
    return found, [float(f"{at.main_pressure_held / 1e3:.0f}"), at.permissible.low / 1e3]


@pytest.mark.parametrize("language", languages())
def test_the_first_page_says_which_pressure_decided_with_its_numbers(
    decided: tuple[Diagnosis, list[float]], language: str
) -> None:
    (found, numbers), say = decided, wording(language)
    text = text_of(write_pdf(found, language=language, sections=["limits"]))
    first = text[: text.index(begun(say("printed.band")))]
    digits = 2 if found.decided_by.kind is RuleKind.RESERVE else 0
    assert say.level(found.verdict).capitalize() in first
    assert [number for number in numbers if say.number(number, digits).replace("\u00a0", " ") not in first] == []
    if found.decided_by.circuit:
        assert found.decided_by.circuit.name in first


def test_the_summary_says_so_too_and_its_verdict_follows_the_rules(
    decided: tuple[Diagnosis, list[float]], calculator: Any
) -> None:
    found, numbers = decided
    sheets = calculator(write_workbook(found))
    assert sheets.value("Summary", "B5") == signed(found.verdict)
    issued = sheets.book["Summary"]["B7"].value
    say = wording("en")
    assert issued == f"{signed(found.verdict)}: {first_sentence(found, say)} {assumed_line(found, say)}"
    assert [number for number in numbers if f"{number:g}" not in issued] == []


# --- drawings


def printed(found: Diagnosis, language: str = "en") -> dict[str, Any]:
    """What the template is given of the section on pressures."""
    return report_data(found, Job(), wording(language), ("pressures",), {})


@pytest.mark.parametrize("language", languages())
def test_drawings_say_in_words_what_they_show(unit: Unit, language: str) -> None:
    found, say = unit(TOO_MUCH), wording(language)
    data = printed(found, language)
    (section,) = data["parts"][0]["sections"]
    pump, pressures, flows = (block for block in section["blocks"] if block["kind"] == "image")
    assert say("conditions.hot_idle") in pump["svg"]
    at = found.projection  # at which the line falls
    assert f"{say.quantity(at.minimum_speed * 60.0, 'engine_speed')}" in pump["alt"]
    for state in at.circuits:
        if not state.vented:
            assert f"{state.circuit.name} " in pressures["alt"]
            assert say.number(state.pressure / 1e3, 0) in pressures["alt"]
            assert state.circuit.name in flows["alt"]


def test_without_circuits_only_the_pump_is_drawn_and_nothing_where_pressures_are_given(
    unit: Unit, worn: Diagnosis
) -> None:
    for found, drawn in ((worn, 1), (unit(WORN, profile=PAPER), 0)):
        data = printed(found)
        (section,) = data["parts"][0]["sections"]
        assert sum(block["kind"] == "image" for block in section["blocks"]) == drawn
        assert data["customer"]["drawings"]
