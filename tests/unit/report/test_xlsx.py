"""The workbook, read back, recalculated and changed."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import openpyxl
import pandas as pd
import pytest
from python_calamine import CalamineWorkbook

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import InputError
from atleak.common.wording import signed, wording
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.measurements.job_card import Job
from atleak.report.tables.lands import condition_matrix
from atleak.report.tables.repairs import plan_ends
from atleak.report.xlsx import write_workbook
from atleak.report.xlsx.book import NUMBER_FORMATS

SHEETS = ["Summary", "Lands", "Land by condition", "Gaps", "Gaps hot idle", "Rules", "Readings", "Directions"]
SHEETS += ["Instruments", "Uncertainty budget", "Road test", "Road test events", "Conditions", "Limits", "Constants"]

# the first of the hostile texts at once, the others in the longer round
FIRST_AND_THE_REST = pytest.mark.parametrize(
    "some", [slice(1), pytest.param(slice(1, None), marks=pytest.mark.slow)], ids=["first", "rest"]
)

# test_circuits_printed.py has a small unit calculated with each of these options every time
WITH_OPTIONS = [
    WORKSHOP.with_options(entry_loss="off", form="cube_of_mean"),
    WORKSHOP.with_options(eccentricity="0.4"),
    WORKSHOP.with_options(eccentricity="unknown", entry_loss="off"),
    WORKSHOP.with_options(viscosity="regression"),
]


def column_of(book: openpyxl.Workbook, sheet: str, heading: str) -> str:
    """The letter of the column under a heading."""
    letters = [cell.column_letter for cell in book[sheet][1] if str(cell.value).startswith(heading)]
    assert letters, (heading, [cell.value for cell in book[sheet][1]])
    return letters[0]


def summary_cells(content: bytes) -> list[str]:
    sheet = pd.read_excel(io.BytesIO(content), sheet_name="Summary", header=None, engine="calamine")
    return sheet.fillna("").astype(str).to_numpy().ravel().tolist()


@pytest.fixture(scope="module")
def content(worn) -> bytes:
    return write_workbook(worn)


def test_sheets_and_numbers_are_read_by_pandas(worn, content):
    sheets = pd.read_excel(io.BytesIO(content), sheet_name=None, engine="calamine")
    assert list(sheets) == [*SHEETS, "Assumed", "Messages", "Provenance"]
    lands = sheets["Lands"]
    assert lands["component"].astype(str).tolist() == [land.state.land.component for land in worn.lands]
    clearances = [land.state.radial_clearance * 1e6 for land in worn.lands]
    assert lands["radial clearance c_r [µm]"].tolist() == pytest.approx(clearances, rel=1e-12, abs=0.0)
    shares = [land.share * 100 for land in worn.lands]
    assert lands["share of pump capacity [%], stated condition"].tolist() == pytest.approx(shares, rel=1e-12, abs=0.0)
    assert len(sheets["Gaps"]) == len(worn.projection.gaps)
    assert sheets["Gaps"]["leakage q [mm³/s], spools concentric"].sum() == pytest.approx(
        sum(gap.leakage for gap in worn.projection.gaps) * 1e9, rel=1e-12, abs=0.0
    )
    assert len(sheets["Readings"]) == len(worn.readings.readings)


def test_calamine_and_openpyxl_see_the_same_cells(content):
    calamine = CalamineWorkbook.from_filelike(io.BytesIO(content))
    book = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
    assert calamine.sheet_names == book.sheetnames
    for name in ("Lands", "Gaps", "Rules"):
        rows = calamine.get_sheet_by_name(name).to_python(skip_empty_area=False)
        for row, cells in zip(rows, book[name].iter_rows(values_only=True), strict=True):
            assert [value or None for value in row] == [value or None for value in cells]


@pytest.mark.parametrize(
    "profile",
    [
        pytest.param(WORKSHOP, id="workshop"),
        *(pytest.param(profile, id=profile.label, marks=pytest.mark.slow) for profile in (PAPER, *WITH_OPTIONS)),
    ],
)
def test_every_formula_gives_its_cached_value(worn, profile, calculator):
    diagnosis = diagnose(worn.controller, worn.fluid, worn.limits, readings=worn.readings, profile=profile)
    sheets = calculator(write_workbook(diagnosis))
    assert len(sheets.formulas()) > 1500
    assert sheets.wrong() == []


def test_a_changed_diameter_changes_clearance_flow_share_and_verdict(worn, content, calculator):
    """What the sheet then says is what atleak says of a unit with that diameter."""
    sheets = calculator(content)
    row = 2  # component 5, not worn
    land = worn.lands[0].state.land
    change = 14.25e-3 - worn.lands[0].state.sleeve_diameter  # everywhere alike, so that the form of the gap stays
    sheets.set("Lands", f"{column_of(sheets.book, 'Lands', 'sleeve diameter')}{row}", 14.25)
    readings = replace(
        worn.readings,
        readings=tuple(
            replace(reading, diameter=reading.diameter + change)
            if reading.component == land.component and reading.part == "sleeve"
            else reading
            for reading in worn.readings.readings
        ),
    )
    other = diagnose(worn.controller, worn.fluid, worn.limits, readings=readings)
    expected = {
        "radial clearance": other.lands[0].state.radial_clearance * 1e6,
        "effective clearance": other.lands[0].effective_clearance * 1e6,
        "leakage q": other.lands[0].leakage * 6e4,
        "share of pump capacity": other.lands[0].share * 100,
        "wear Z": other.lands[0].wear * 100,
    }
    for heading, value in expected.items():
        computed = sheets.value("Lands", f"{column_of(sheets.book, 'Lands', heading)}{row}")
        assert computed == pytest.approx(value, rel=1e-9, abs=0.0), heading
    assert worn.lands[0].verdict == "ok"
    assert other.lands[0].verdict != "ok"
    assert sheets.value("Lands", f"{column_of(sheets.book, 'Lands', 'verdict')}{row}") == signed(other.lands[0].verdict)
    total = sheets.book.defined_names["stated_share"].attr_text.split("!")
    assert sheets.value(*total) == pytest.approx(other.projection.share * 100, rel=1e-9, abs=0.0)
    touching = sheets.book.defined_names["stated_share_touching"].attr_text.split("!")
    share = other.projection.share_of(other.projection.touching_leakage)
    assert sheets.value(*touching) == pytest.approx(share * 100, rel=1e-9, abs=0.0)


def test_a_changed_reading_changes_the_mean_diameter(worn, content, calculator):
    sheets = calculator(content)
    column, row = column_of(sheets.book, "Lands", "spool diameter"), 2
    before = sheets.value("Lands", f"{column}{row}")
    sheets.set("Readings", "G2", sheets.value("Readings", "G2") + 0.004)  # one of four readings of one plane
    assert sheets.value("Lands", f"{column}{row}") == pytest.approx(before + 0.001, abs=1e-12)


def test_a_changed_temperature_changes_the_viscosity(worn, content, calculator):
    sheets = calculator(content)
    at = sheets.book.defined_names["stated_T"].attr_text.split("!")
    sheets.set(at[0], at[1].replace("$", ""), 95.0)
    nu = sheets.book.defined_names["stated_nu"].attr_text.split("!")
    assert sheets.value(*nu) == pytest.approx(worn.fluid.kinematic_viscosity(95.0) * 1e6, rel=1e-12, abs=0.0)


@pytest.mark.slow
def test_libreoffice_recalculates_atleaks_numbers(content, recalculated, referee):
    """An office suite that must calculate every cell itself arrives at the cached values."""
    cached = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
    formulas = openpyxl.load_workbook(io.BytesIO(content))
    assert referee.differing(formulas, recalculated(formulas), cached) == []


@pytest.mark.slow
def test_libreoffice_shows_a_negative_wear_with_its_sign(worn, tmp_path, convert):
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(replace(worn, road=None))))
    for name in book.sheetnames:
        if name != "Lands":
            del book[name]
    column = column_of(book, "Lands", "wear Z")
    for row, value in enumerate((-3.2, 0.0, 3.2, 9.99e99), start=2):
        book["Lands"][f"{column}{row}"] = value  # in place of the formula, whose other sheets are gone
    book.save(tmp_path / "in.xlsx")
    convert(tmp_path / "in.xlsx", "csv:Text - txt - csv (StarCalc):44,34,76,1,,0,false,true,true")
    lands = pd.read_csv(tmp_path / "in.csv", dtype=str)
    shown = lands[next(name for name in lands.columns if name.startswith("wear Z"))]
    assert shown.tolist()[:4] == ["-3.20", "0.00", "3.20", "pump delivers nothing"]


def test_every_number_format_keeps_the_sign_of_a_negative_number():
    """A format of several parts shows a negative number without its sign unless one part is for negative numbers."""
    several = {name: form.split(";") for name, form in NUMBER_FORMATS.items() if ";" in form}
    assert several.pop("share")  # of a flow, which is never below zero
    assert several
    assert [name for name, parts in several.items() if not parts[1].startswith("[<0]-")] == []


def test_a_measuring_temperature_is_in_the_formulas_of_the_diameters(worn, calculator):
    warm = diagnose(worn.controller, worn.fluid, worn.limits, readings=worn.readings, measuring_temperature_c=35.0)
    content = write_workbook(warm)
    summary = pd.read_excel(io.BytesIO(content), sheet_name="Summary", header=None, engine="calamine")
    assert "35 °C, diameters corrected to 20 °C" in summary[1].tolist()
    sheets = calculator(content)
    for heading, part in (("spool diameter", "spool_diameter"), ("sleeve diameter", "sleeve_diameter")):
        at = f"{column_of(sheets.book, 'Lands', heading)}2"
        assert sheets.value("Lands", at) == pytest.approx(getattr(warm.lands[0].state, part) * 1e3, abs=1e-12)
    beta = f"{column_of(sheets.book, 'Lands', 'expansion of body')}2"
    before = sheets.value("Lands", f"{column_of(sheets.book, 'Lands', 'sleeve diameter')}2")
    sheets.set("Lands", beta, sheets.value("Lands", beta) + 1.0)  # 1e-6/K more
    after = sheets.value("Lands", f"{column_of(sheets.book, 'Lands', 'sleeve diameter')}2")
    assert after == pytest.approx(before * (1 - 15e-6), rel=1e-8, abs=0.0)


def test_without_a_measuring_temperature_the_workbook_says_that_20_degrees_are_assumed(content):
    summary = pd.read_excel(io.BytesIO(content), sheet_name="Summary", header=None, engine="calamine")
    assert "assumed 20 °C, none is stated" in summary[1].tolist()


@FIRST_AND_THE_REST
def test_nothing_a_user_typed_becomes_a_formula(worn, hostile, some):
    for text in hostile[some]:
        readings = replace(worn.readings, file=text)
        job = Job(customer={"name": text}, notes=text)
        book = openpyxl.load_workbook(
            io.BytesIO(write_workbook(replace(worn, readings=readings, road=None), job)), rich_text=False
        )
        cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value == text.strip()]
        assert len(cells) >= 3, text
        assert {cell.data_type for cell in cells} == {"s"}
        assert all(cell.hyperlink is None for cell in cells)


def test_long_notes_are_not_cut(unmeasured):
    notes = "".join(f"line {number}\n" for number in range(9000))
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(unmeasured, Job(notes=notes))))
    text = "".join(str(row[1]) for row in book["Job"].iter_rows(values_only=True) if row[1] is not None)
    assert text == notes.strip()


def test_a_unit_nobody_measured(unmeasured):
    sheets = pd.read_excel(io.BytesIO(write_workbook(unmeasured)), sheet_name=None, engine="calamine")
    assert set(sheets["Lands"]["verdict"]) == {"○ not measured"}
    assert "Road test" not in sheets
    assert "Readings" not in sheets
    assert "Job" not in sheets


def test_job_prints_no_empty_label(unmeasured):
    job = Job(number="17", vehicle={"vin": "WVWZZZ1JZXW000001"}, repair_decisions=[{"component": "8", "work": "ream"}])
    sheets = pd.read_excel(io.BytesIO(write_workbook(unmeasured, job)), sheet_name=None, header=None, engine="calamine")
    rows = sheets["Job"].fillna("").astype(str).to_numpy().tolist()
    assert ["vin", "WVWZZZ1JZXW000001"] in rows
    assert ["work", "ream"] in rows
    assert not any("customer" in row[0] or "mileage" in row[0] for row in rows)


def test_conditions_are_named_by_their_labels_and_the_speed_says_what_it_leaves_out(content):
    cells = summary_cells(content)
    assert "hot idle in drive, 100 °C" in cells
    names = {point.name for point in load_controller("four_speed_2023").operating_points}
    assert not names & set(cells)
    assert any("converter, lubrication and clutch fill are not in it" in cell for cell in cells)


def test_road_series_keeps_a_spike_and_the_gap(worn, content):
    sheets = pd.read_excel(io.BytesIO(content), sheet_name="Road test", header=None, engine="calamine")
    first = int(np.flatnonzero(sheets[0] == "time [s]")[-1])
    series = sheets.iloc[first + 1 :].astype(float)
    assert len(series) <= 2500
    peak = series[1].max()
    assert peak == pytest.approx(worn.road.max_leakage.leakage * 6e4, rel=1e-12, abs=0.0)
    assert series[1].isna().any()


def test_same_job_same_bytes(worn):
    assert write_workbook(worn, Job(date="2026-03-04")) == write_workbook(worn, Job(date="2026-03-04"))


def test_unit_without_hot_idle(worn):
    only = replace(worn.controller, operating_points=worn.controller.operating_points[:1])
    other = diagnose(only, worn.fluid, worn.limits, readings=worn.readings)
    sheets = pd.read_excel(io.BytesIO(write_workbook(other)), sheet_name=None, engine="calamine")
    assert "Gaps hot idle" not in sheets


def test_every_land_stands_beside_every_condition(worn, content):
    matrix = pd.read_excel(io.BytesIO(content), sheet_name="Land by condition", engine="calamine")
    rows = condition_matrix(worn)
    for number, projection in enumerate(worn.projections):
        label = projection.condition.label
        shares = [row.cells[number].share * 100.0 for row in rows]
        assert matrix[f"share of pump capacity [%], {label}"].tolist() == pytest.approx(shares, rel=1e-12, abs=1e-15)
        verdicts = [None if row.cells[number].rule is None else signed(row.cells[number].verdict) for row in rows]
        issued = matrix[f"verdict of the share, {label}"].tolist()
        assert [None if pd.isna(verdict) else verdict for verdict in issued] == verdicts
        assert sum(shares) == pytest.approx(projection.share * 100.0, rel=1e-9, abs=0.0)
    assert matrix["elsewhere, as issued"].iloc[0] == "leaks into p_m, not drawn from the pump"


def test_half_a_pair_is_called_ok_at_no_condition(worn, calculator):
    kept = tuple(reading for reading in worn.readings.readings if reading.part == "spool")
    half = diagnose(worn.controller, worn.fluid, worn.limits, readings=replace(worn.readings, readings=kept))
    sheets = calculator(write_workbook(half))
    for row, land in enumerate(half.lands, start=2):
        if land.state.measured:
            shown = {sheets.value("Land by condition", f"{letter}{row}") for letter in "EG"}
            assert shown == {"○ not measured"}


def test_a_changed_diameter_reaches_the_land_s_share_at_every_condition(worn, content, calculator):
    sheets = calculator(content)
    row = next(number for number, land in enumerate(worn.lands, start=2) if land.key == ("26", 1))
    before = {letter: sheets.value("Land by condition", f"{letter}{row}") for letter in "DF"}
    sheets.set("Lands", f"{column_of(sheets.book, 'Lands', 'sleeve diameter')}{row}", 20.3)
    for letter, share in before.items():
        assert sheets.value("Land by condition", f"{letter}{row}") > 2.0 * share


def test_the_summary_holds_the_repairs_their_end_and_the_complaint(worn):
    complaint = worn.controller.complaint("slips_hot")
    content = write_workbook(replace(worn, complaint=complaint))
    rows = pd.read_excel(io.BytesIO(content), sheet_name="Summary", header=None, engine="calamine").fillna("")
    cells = [str(cell) for row in rows.to_numpy().tolist() for cell in row if cell != ""]
    plan = plan_repairs(worn)
    assert all(sentence in cells for sentence in plan_ends(plan, wording("en")))
    assert plan.steps
    for each in plan.steps[-1].conditions:
        shares = rows[rows.isin([f"total after [%], {each.condition.label}"]).any(axis=1)].index
        column = rows.columns[rows.loc[shares[0]] == f"total after [%], {each.condition.label}"][0]
        after = rows.loc[shares[0] + len(plan.steps), column]
        assert after == pytest.approx(each.after.share * 100.0, rel=1e-12, abs=0.0)
    assert complaint.label in cells
    assert f"{worn.worst.condition.label}; the worst, as issued" in cells
    totals = [cell for cell in cells if cell.startswith(("hot idle in drive", "driving in second"))]
    assert totals[1].startswith("hot idle")  # beside "shows at": the complaint's condition comes first


def test_conditions_with_long_or_odd_names_have_sheets_and_names_of_their_own(worn, calculator):
    idle = worn.controller.operating_points[1]
    names = ["driving", "a_very_long_name_of_a_condition_1", "a_very_long_name_of_a_condition_2", "2nd"]
    points = [replace(idle, name=name, label=f"label of {name}") for name in names]
    controller = replace(worn.controller, operating_points=tuple(points))
    diagnosis = diagnose(controller, worn.fluid, worn.limits, readings=worn.readings)
    sheets = calculator(write_workbook(diagnosis))
    gaps = [name for name in sheets.book.sheetnames if name.startswith("Gaps")]
    assert len(gaps) == len(names)
    assert max(map(len, gaps)) <= 31
    assert {"_2nd_T", "a_very_long_name_of_a_condition_1_T"} <= set(sheets.book.defined_names)
    assert sheets.wrong() == []


def test_a_pump_that_delivers_nothing_and_another_controller(worn, calculator):
    standing = replace(worn.projection.condition, name="stated", engine_speed=1e-3)
    still = diagnose(worn.controller, worn.fluid, worn.limits, readings=worn.readings, condition=standing)
    minimal = load_controller("minimal_example")
    other = diagnose(minimal, worn.fluid, worn.limits)
    for each in (still, other):
        sheets = calculator(write_workbook(each))
        assert sheets.wrong() == []


@pytest.mark.parametrize(("paper", "number"), [("a4", 9), ("letter", 1)])
def test_every_sheet_prints_on_the_paper_that_was_chosen(unmeasured, paper, number):
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(unmeasured, paper=paper)))
    assert {int(sheet.page_setup.paperSize) for sheet in book} == {number}


def test_an_unknown_paper_is_refused(unmeasured):
    with pytest.raises(InputError, match="did you mean 'letter'"):
        write_workbook(unmeasured, paper="leter")


def test_a_decision_is_named_as_the_texts_name_it(worn, monkeypatch):
    decisions = {land.uncertainty.decision for land in worn.lands if land.uncertainty is not None} - {None}
    for decision in decisions:
        monkeypatch.setitem(wording("en").table("decisions"), decision, f"decided: {decision}")
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(worn)), data_only=True)
    column = column_of(book, "Lands", "decision as issued")
    assert {cell.value for cell in book["Lands"][column][1:]} - {None} == {f"decided: {name}" for name in decisions}
    assert decisions
