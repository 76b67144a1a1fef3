"""What a vacuum test tells, on every medium; the workbook's formulas give the same clearances, budgets and flows."""

from __future__ import annotations

import io
from collections.abc import Callable

import openpyxl
import pytest
from jsonschema import Draft202012Validator

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.json.schemas import schema
from atleak.report.pdf import write_pdf
from atleak.report.tables.table import Table
from atleak.report.tables.vacuum import vacuum_section
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook
from tests.unit.diagnosis.test_vacuum import plug, table
from tests.unit.report.read_back import squeezed, text_of

UM = 1e-6


@pytest.fixture(scope="module")
def tested(hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> Diagnosis:
    """One land by its leak, worn and repaired; one beside its diameters, one by diameters alone, a circuit of three."""
    unit = load_controller("five_speed_2005")
    one, both, only = (unit.land("boost_valve", number) for number in (1, 2, 3))
    several = unit.lands_around(unit.circuits[0].id)
    sizes = {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * c) for land, c in
             ((both, 24 * UM), (only, 15 * UM))}  # fmt: skip
    readings = (
        plug([one], [40 * UM]),
        plug([one], [26 * UM], repaired=True, row=3),
        plug([both], [25 * UM], row=4),
        plug(several, [35 * UM, *(land.new_clearance for land in several[1:])], circuit=unit.circuits[0].id, row=5),
    )
    return diagnose(unit, hipol, limits, readings=readings_of(unit, sizes), vacuum=table(*readings))


def test_the_record_is_what_its_schema_says(tested: Diagnosis) -> None:
    record = diagnosis_record(tested)
    Draft202012Validator({"$ref": "#/$defs/result", "$defs": schema("diagnose")["$defs"]}).validate(record)
    one, both, several = record["vacuum"]
    assert one["repaired"]
    assert one["low_um"] < one["clearance_um"] < one["high_um"]
    assert one["leakage_low_dm3_min"] < one["leakage_dm3_min"] < one["leakage_high_dm3_min"]
    assert one["change"]["significant"]
    assert both["circuit"] is None
    assert both["alone_worn"] == []
    assert several["circuit"] == tested.controller.circuits[0].id
    assert [each["land"] for each in several["alone_worn"]] == [each["land"] for each in several["lands"]]
    assert len(several["lands"]) == 3
    measured = {each["land"]: each["measured"] for each in record["lands"] if each["component"] == "boost_valve"}
    assert measured == {1: "vacuum", 2: "measured", 3: "measured"}


def test_without_a_vacuum_test_the_list_is_empty(tested: Diagnosis, hipol: Fluid, limits: Limits) -> None:
    assert diagnosis_record(diagnose(tested.controller, hipol, limits))["vacuum"] == []


@pytest.mark.parametrize("language", ["en", "de", "pl"])
def test_every_medium_says_it(language: str, tested: Diagnosis, capsys: pytest.CaptureFixture[str]) -> None:
    say = wording(language)
    section = vacuum_section(tested, say)
    first, shares, changes = (part for part in section.parts if isinstance(part, Table))
    assert (len(first.rows), len(shares.rows), len(changes.rows)) == (3, 3, 1)
    printed = squeezed(text_of(write_pdf(tested, language=language, sections=["before_opening", "budget"])))
    for words in (section.title, say("vacuum.changes"), say.get("uncertainty_sources", "vacuum stand")):
        assert squeezed(words) in printed, words
    if language == "en":
        print_diagnosis(tested)
        shown = capsys.readouterr().out
        assert "Where a spool lay in the test is not known" in shown
        assert "in-Hg" in shown


@pytest.mark.parametrize("units", ["metric", "us"])
def test_the_workbook_recomputes_what_atleak_says(units: str, tested: Diagnosis, calculator: type) -> None:
    sheets = calculator(write_workbook(tested, units=units))
    assert "Before opening" in sheets.book.sheetnames
    assert sheets.wrong() == []


def test_another_clearance_by_vacuum_moves_the_flow(tested: Diagnosis, calculator: type) -> None:
    sheets = calculator(write_workbook(tested))
    lands = sheets.book["Lands"]
    headings = {str(cell.value).partition(" [")[0]: cell.column_letter for cell in lands[1]}
    rows = {(row[0].value, row[2].value): row[0].row for row in lands.iter_rows(min_row=2)}
    row = rows["boost_valve", 1]
    place = f"{headings['clearance by the vacuum test']}{row}"
    clearance = f"{headings['radial clearance c_r']}{row}"
    sheets.set("Lands", place, 2.0 * sheets.value("Lands", place))
    assert sheets.value("Lands", clearance) == pytest.approx(sheets.value("Lands", place), rel=1e-9, abs=0.0)


def test_a_land_without_diameters_stands_open_to_be_measured_and_green_as_tested(
    tested: Diagnosis, hipol: Fluid, limits: Limits
) -> None:
    unit: Controller = tested.controller
    land = unit.land("boost_valve", 1)
    bare = diagnose(unit, hipol, limits, vacuum=table(plug([land], [land.new_clearance])))
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(bare)), data_only=True)
    words = [cell.value for row in book["Lands"].iter_rows() for cell in row if isinstance(cell.value, str)]
    say = wording("en")
    assert words.count("vacuum test") == 1
    assert words.count(say.signed(Verdict.OK)) == 1
    assert bare.measured == 1
