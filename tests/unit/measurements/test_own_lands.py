"""Contact lengths, positions and fitted repairs of one unit: read from its sheet, and what follows in its result."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import Repair
from atleak.common.errors import ReadingsError
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import FittedRepair, OwnLands, OwnLength, Reading
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.sheets.lands_sheet import LANDS
from atleak.report.sheets.measuring_columns import SHEET
from atleak.report.sheets.measuring_sheet import write_readings, write_template
from atleak.report.sheets.paging import HEADER
from atleak.report.tables.lands import condition_matrix
from atleak.report.terminal import print_diagnosis
from tests.unit.conftest import first_of

Edited = Callable[..., Path]
REPAIRS = """
[[repairs]]
id = "oversize"
component = "pressure_regulator"
lands = [1]
kind = "oversize_valve"
name = "oversize regulator valve"
part_number = "MADE-UP-1"
nominal_diameter_mm = 15.8
mounting_clearance_um = [10.0, 14.0]
source = "made up for this test"
evidence = "representative"

[[repairs]]
id = "sleeve"
component = "pressure_regulator"
lands = [1, 2]
kind = "sleeve"
name = "bore sleeved"
mounting_clearance_um = 12.0
source = "made up for this test"
"""
SHEETS = {
    "a column among the diameters": (
        "Valve;Land;Part;Diameter [mm];Contact length [mm]\n"
        "pressure_regulator;1;spool;14.998;4.2\n"
        "pressure_regulator;1;bore;15.058;\n"
    ),
    "in inches": (
        "Valve;Land;Part;Diameter [mm];Contact length [in]\n"
        "pressure_regulator;1;spool;14.998;0.16535433\n"
        "pressure_regulator;1;bore;15.058;0.16535433\n"
    ),
    "with a column of units": (
        "Valve;Land;Part;Unit;Diameter;Contact length\n"
        "pressure_regulator;1;spool;mm;14.998;4.2\n"
        "pressure_regulator;1;bore;mm;15.058;4.2\n"
    ),
    "a table of its own": (
        "Valve;Land;Part;Diameter [mm]\n"
        "pressure_regulator;1;spool;14.998\n"
        "pressure_regulator;1;bore;15.058\n"
        "\n"
        "Valve;Land;Contact length [mm];Position from left end [mm]\n"
        "pressure_regulator;1;4,2;0\n"
    ),
    "in German": (
        "Ventil;Steg;Teil;Durchmesser [mm];Kontaktlänge [mm]\n"
        "pressure_regulator;1;Schieber;14,998;4,2\n"
        "pressure_regulator;1;Bohrung;15,058;4,2\n"
    ),
}


@pytest.fixture(scope="module")
def own_box(tmp_path_factory: pytest.TempPathFactory) -> Controller:
    path = tmp_path_factory.mktemp("box") / "own.toml"
    shipped = load_controller("minimal_example").origin.path.read_text(encoding="utf-8")
    path.write_text(shipped + REPAIRS, encoding="utf-8")
    return load_controller(path)


def diagnosed(sheet: str | bytes, controller: Controller, hipol: Fluid, limits: Limits, **options: object) -> Diagnosis:
    data = sheet if isinstance(sheet, bytes) else sheet.encode()
    readings = read_readings(data, controller, name="own.csv" if isinstance(sheet, str) else "own.xlsx")
    return diagnose(controller, hipol, limits, readings=readings, **options)


def refused(sheet: str, controller: Controller) -> str:
    with pytest.raises(ReadingsError) as caught:
        read_readings(sheet.encode(), controller, name="own.csv")
    return str(caught.value)


@pytest.mark.parametrize("sheet", SHEETS.values(), ids=SHEETS)
def test_a_contact_length_is_read_wherever_it_stands_and_computed_with(
    sheet: str, own_box: Controller, hipol: Fluid, limits: Limits
) -> None:
    diagnosis = diagnosed(sheet, own_box, hipol, limits)
    without = diagnosed(SHEETS["a table of its own"].split("\n\n")[0], own_box, hipol, limits)
    land = next(each for each in diagnosis.lands if each.key == ("pressure_regulator", 1))
    plain = next(each for each in without.lands if each.key == land.key)
    stated = own_box.land(*land.key).contact_length
    assert land.state.land.contact_length == pytest.approx(4.2e-3, abs=1e-9)
    assert land.leakage == pytest.approx(plain.leakage * stated / 4.2e-3, abs=0.02 * plain.leakage)  # entry loss
    assert [each.code for each in diagnosis.messages].count("contact_length_measured") == 1
    gap = next(each for each in diagnosis_record(diagnosis)["gaps"] if each["component"] == "pressure_regulator")
    assert gap["contact_length_mm"] == pytest.approx(4.2, abs=1e-6)
    rows = {(each["component"], each["land"]): each for each in diagnosis_record(diagnosis)["lands"]}
    assert rows[land.key]["contact_length_measured"] is True
    assert [row["contact_length_measured"] for key, row in rows.items() if key != land.key].count(True) == 0
    assert not [each for each in diagnosis.messages if each.code in ("not_read", "column_aside")]


def test_a_measured_contact_length_is_surer_than_one_of_the_file(
    own_box: Controller, hipol: Fluid, limits: Limits
) -> None:
    sheet = SHEETS["a column among the diameters"].replace("4.2", f"{own_box.lands[0].contact_length * 1e3}")
    of_lengths = []
    for heading in ("Contact length", "Length"):  # the second one is no contact length: the file's counts
        diagnosis = diagnosed(sheet.replace("Contact length", heading), own_box, hipol, limits)
        land = next(each for each in diagnosis.lands if each.key == ("pressure_regulator", 1))
        assert land.uncertainty is not None
        part = dict(land.uncertainty.conditions[0].budget)["contact length"]
        of_lengths.append(part / (1.0 - part))
    assert of_lengths[0] / of_lengths[1] == pytest.approx(0.3**2, abs=1e-6)  # 0.03 mm, and 0.1 mm of the file


def test_a_length_that_is_none_is_refused_with_its_cell(own_box: Controller) -> None:
    sheet = SHEETS["a column among the diameters"]
    assert "size of the land's diameter" in refused(sheet.replace(";4.2", ";15.01"), own_box)
    assert "another unit" in refused(sheet.replace(";4.2", ";0.16"), own_box)
    assert "stands in" in refused(sheet.replace("15.058;", "15.058;4.3"), own_box)
    message = refused(sheet.replace(";4.2", ";long"), own_box)
    assert "row 2, column Contact length [mm]" in message
    assert "a length such as 5.25" in message


def test_a_length_of_a_component_that_is_none_is_refused_and_never_lost(own_box: Controller) -> None:
    among = SHEETS["a column among the diameters"] + "pressure_regulater;1;spool;;4.4\n"
    beside = SHEETS["a table of its own"] + "pressure_regulater;1;4.4;\n"
    for sheet in (among, beside):
        assert "did you mean 'pressure_regulator'" in refused(sheet, own_box)


def test_a_length_far_from_the_stated_one_is_taken_with_a_warning(own_box: Controller) -> None:
    readings = read_readings(SHEETS["a column among the diameters"].replace(";4.2", ";1.9").encode(), own_box)
    warning = next(each for each in readings.messages if each.code == "contact_length_differs")
    assert warning.level == "warning"
    assert "1.9 mm as measured" in warning.text


@pytest.mark.parametrize(
    "heading",
    ["Length [mm]", "Contact length nominal [mm]", "Position [mm]", "Position", "Fitted", "Contact length new"],
)
def test_a_column_that_says_anything_else_is_no_contact_length(heading: str, own_box: Controller) -> None:
    sheet = SHEETS["a column among the diameters"].replace("Contact length [mm]", heading)
    assert read_readings(sheet.encode(), own_box).own_lands == OwnLands()


def test_the_form_takes_what_lands_have_and_reads_back(own_box: Controller) -> None:
    land = own_box.land("pressure_regulator", 1)
    readings = [
        Reading(land.component, part, land.planes[0], 0.0, 1, diameter)
        for part, diameter in (("spool", 15.8e-3), ("sleeve", 15.83e-3))
    ]
    own = OwnLands(
        (OwnLength(*land.key, 4.2e-3, 1.5e-3), OwnLength("pressure_regulator", 2, None, 12.0e-3)),
        (FittedRepair("pressure_regulator", "oversize"),),
    )
    again = read_readings(write_readings(own_box, readings, own_lands=own), own_box, name="sheet.xlsx").own_lands
    assert [(each.key, each.contact_length, each.position) for each in again.lengths] == [
        (land.key, pytest.approx(4.2e-3, abs=1e-12), pytest.approx(1.5e-3, abs=1e-12)),
        (("pressure_regulator", 2), None, pytest.approx(12.0e-3, abs=1e-12)),
    ]
    assert [(each.component, each.repair) for each in again.fitted] == [("pressure_regulator", "oversize")]


def test_the_form_offers_the_repairs_of_each_component_and_none_where_there_are_none(own_box: Controller) -> None:
    sheet = openpyxl.load_workbook(io.BytesIO(write_template(own_box)))[LANDS]
    choices = {each.formula1 for each in sheet.data_validations.dataValidation if each.type == "list"}
    assert choices == {'"oversize,sleeve"', '"sleeve"'}
    plain = openpyxl.load_workbook(io.BytesIO(write_template(load_controller("minimal_example"))))[LANDS]
    assert "Fitted repair" not in [cell.value for cell in plain[HEADER + 1]]


def test_the_sheet_that_is_asked_for_leaves_the_tab_of_lands_its_say(own_box: Controller) -> None:
    land = own_box.land("pressure_regulator", 1)
    readings = [Reading(land.component, "spool", land.planes[0], 0.0, 1, 15.0e-3)]
    data = write_readings(own_box, readings, own_lands=OwnLands((OwnLength(*land.key, 4.2e-3, None),)))
    assert read_readings(data, own_box, name="sheet.xlsx", sheet=SHEET).own_lands.lengths


def test_a_repair_that_is_fitted_is_the_new_state_of_its_lands(
    own_box: Controller, hipol: Fluid, limits: Limits, capsys: pytest.CaptureFixture[str]
) -> None:
    sheet = (
        "Valve;Land;Part;Diameter [mm];Fitted repair\n"
        "pressure_regulator;1;spool;15.800;oversize\n"
        "pressure_regulator;1;bore;15.826;\n"
    )
    diagnosis = diagnosed(sheet, own_box, hipol, limits)
    land = next(each for each in diagnosis.lands if each.key == ("pressure_regulator", 1))
    nominal = land.state.land
    assert nominal.nominal_diameter == pytest.approx(15.8e-3, abs=1e-9)
    assert nominal.mounting_range == pytest.approx((10e-6, 14e-6), abs=1e-12)
    assert nominal.new_origin is NewOrigin.RANGE
    assert "mounting_clearance_um" in nominal.representative  # the repair says so
    assert land.wear == pytest.approx(13.0 / 14.0 - 1.0, abs=1e-6)
    assert land.verdict is Verdict.OK
    other = next(each for each in diagnosis.lands if each.key == ("pressure_regulator", 2))
    assert other.state.land == own_box.land("pressure_regulator", 2)
    assert "far_from_nominal" not in {each.code for each in diagnosis.messages}
    plain = diagnosed(sheet.replace("oversize\n", "\n"), own_box, hipol, limits)
    assert "far_from_nominal" in {each.code for each in plain.messages}
    said = [each for each in diagnosis.messages if each.code == "repair_fitted"]
    assert len(said) == 1
    assert "oversize regulator valve (MADE-UP-1)" in said[0].text
    row = next(each for each in diagnosis_record(diagnosis)["lands"] if each["component"] == "pressure_regulator")
    assert row["fitted_repair"] == "oversize"
    print_diagnosis(diagnosis)
    assert said[0].text in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("unit", first_of(["minimal_example", "five_speed_2005", "zf_6hp26", "gm_4l60e"]))
def test_a_pair_that_was_only_cleaned_is_the_worn_one_that_it_was(unit: str, hipol: Fluid, limits: Limits) -> None:
    controller = load_controller(unit)
    controller = replace(controller, lands=tuple(replace(each, mounting_measured=True) for each in controller.lands))
    lands = [each for each in controller.lands if not each.seal]
    cleaned, other = lands[0], next(each for each in lands if each.component != lands[0].component)
    repair = Repair("clean", (cleaned.key,), "clean_and_reuse", "clean", "made up")
    rows = ["Component;Plane;Part;Diameter [mm];Fitted repair"]
    for land in (cleaned, other):
        named = "clean" if land is cleaned else ""
        spool, bore = land.nominal_diameter * 1e3, (land.nominal_diameter + 2.2 * land.mounting_high) * 1e3
        rows += [f"{land.component};{land.planes[0]};spool;{spool:.4f};{named}"]
        rows += [f"{land.component};{land.planes[0]};bore;{bore:.4f};"]
    with_clean = replace(controller, repairs=(*controller.repairs, repair))
    found = diagnosed("\n".join(rows), with_clean, hipol, limits, mileage_km=100_000.0)
    plain = diagnosed("\n".join(rows).replace("clean", ""), with_clean, hipol, limits, mileage_km=100_000.0)
    assert [land.replace_mileage for land in found.lands] == [land.replace_mileage for land in plain.lands]
    assert found.lands[0].state == plain.lands[0].state
    assert found.lands[0].replace_mileage is not None
    [said] = [each.text for each in found.messages if each.code == "repair_fitted"]
    assert "none is new" in said


def test_a_fitted_repair_that_cannot_be_is_refused_with_its_cell(own_box: Controller) -> None:
    sheet = (
        "Valve;Land;Part;Diameter [mm];Fitted repair\n"
        "pressure_regulator;1;spool;15.000;oversized\n"
        "pressure_regulator;2;spool;12.500;\n"
    )
    message = refused(sheet, own_box)
    assert "column Fitted repair" in message
    assert "did you mean 'oversize'" in message
    assert "does not change land 2" in refused(
        sheet.replace("oversized", "sleeve").replace("12.500;", "12.500;oversize"), own_box
    )
    assert "one repair of each land" in refused(
        sheet.replace("oversized", "oversize").replace("12.500;", "12.500;sleeve"), own_box
    )
    plain = load_controller("minimal_example")
    assert "has no repairs of component" in refused(sheet, plain)


def test_a_sealed_land_leaks_nothing_and_is_shown_but_not_judged(edited: Edited, hipol: Fluid, limits: Limits) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        ("{ land = 1, nominal_diameter_mm = 15.0", '{ land = 1, seal = "o_ring", nominal_diameter_mm = 15.0'),
    )
    sheet = SHEETS["a column among the diameters"].replace("15.058", "15.198")  # 100 µm, far past every limit
    controller = load_controller(path)
    diagnosis = diagnosed(sheet, controller, hipol, limits)
    land = next(each for each in diagnosis.lands if each.key == ("pressure_regulator", 1))
    assert land.state.radial_clearance == pytest.approx(100e-6, abs=1e-9)
    assert land.leakage == 0.0
    assert land.rules == ()
    assert land.decision is None
    assert land.verdict is Verdict.NOT_MEASURED  # never green: nothing of it was judged
    assert not diagnosis.flagged
    assert diagnosis.judged == sum(each.state.measured for each in diagnosis.lands) - 1
    codes = [each.code for each in diagnosis.messages]
    assert "land_sealed" in codes
    assert "land_without_gap" not in codes
    judged = diagnosed(sheet, load_controller("minimal_example"), hipol, limits)
    assert judged.verdict.flagged


def test_a_unit_of_which_only_a_sealed_land_was_measured_is_not_called_ok(
    edited: Edited, hipol: Fluid, limits: Limits
) -> None:
    line = "{ land = 1, nominal_diameter_mm = 15.0"
    path = edited("controllers", "minimal_example", (line, line.replace("land = 1,", 'land = 1, seal = "o_ring",')))
    sheet = "Valve;Land;Part;Diameter [mm]\npressure_regulator;1;spool;15.000\npressure_regulator;1;sleeve;15.030\n"
    assert diagnosed(sheet, load_controller("minimal_example"), hipol, limits).verdict is Verdict.OK
    diagnosis = diagnosed(sheet, load_controller(path), hipol, limits)
    assert (diagnosis.verdict, diagnosis.judged) == (Verdict.NOT_MEASURED, 0)
    assert not plan_repairs(diagnosis).judged
    (row,) = (each for each in condition_matrix(diagnosis) if each.land.key == ("pressure_regulator", 1))
    assert {cell.verdict for cell in row.cells} == {Verdict.NOT_MEASURED}


def test_an_end_plug_and_a_sleeved_bore_are_named_in_the_form_and_the_catalogue(edited: Edited) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        ('id = "pressure_regulator"', 'id = "pressure_regulator"\npart = "end_plug"\nbore = "sleeved"'),
    )
    controller = load_controller(path)
    assert controller.land("pressure_regulator", 1).built == ("end plug", "bore sleeved")
    sheet = openpyxl.load_workbook(io.BytesIO(write_template(controller)))
    notes = [cell.value for row in sheet[LANDS] for cell in row if isinstance(cell.value, str)]
    assert any(note.startswith("end plug; bore sleeved") for note in notes)
    parts = {cell.value for row in sheet[SHEET] for cell in row}
    assert "end plug" in parts


def test_a_repair_with_another_land_s_diameter_is_refused(edited: Edited) -> None:
    path = edited("controllers", "minimal_example")
    path.write_text(
        path.read_text(encoding="utf-8") + REPAIRS.replace("lands = [1]\n", "lands = [1, 2]\n"), encoding="utf-8"
    )
    with pytest.raises(Exception, match="no oversize of it") as caught:
        load_controller(path)
    assert caught.value.place.steps == ("repairs", 0, "nominal_diameter_mm")


@pytest.mark.parametrize("name", ["four_speed_2023", "gm_4l60e"])  # without and with repairs: other words stand above
def test_a_length_typed_into_a_printed_form_of_a_shipped_valve_body_is_read(name: str) -> None:
    controller = load_controller(name)
    land, stated = controller.lands[0], controller.lands[0].contact_length
    readings = [
        Reading(land.component, part, plane, direction, 1, diameter)
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", land.nominal_sleeve_diameter))
        for plane in land.planes
        for direction in (0.0, 90.0)
    ]
    book = openpyxl.load_workbook(io.BytesIO(write_readings(controller, readings)))
    book[LANDS].cell(HEADER + 2, 4).value = stated * 1e3 - 0.2
    target = io.BytesIO()
    book.save(target)
    read = read_readings(target.getvalue(), controller)
    assert [(each.key, round(each.contact_length or 0.0, 9)) for each in read.own_lands.lengths] == [
        (land.key, round(stated - 0.2e-3, 9))
    ]
    assert not [message.text for message in read.messages if message.code == "table_aside"]
