"""The measuring sheet: what a person sees in it, and that it reads back."""

from __future__ import annotations

import io
import textwrap
import zipfile
from itertools import pairwise
from xml.etree import ElementTree

import openpyxl
import pypdfium2
import pytest
import zxingcpp
from openpyxl.cell import MergedCell
from PIL import Image

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.common.wording import wording
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import (
    LINE_TAP,
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    applied,
    taps_of,
)
from atleak.measurements.job_card import Job, Vehicle
from atleak.measurements.readings import Reading
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.lands_sheet import LANDS
from atleak.report.sheets.measuring_columns import SHEET
from atleak.report.sheets.measuring_head import MEASURING_HEADER, code_text, fields_of
from atleak.report.sheets.measuring_sheet import MEASURING_INSTRUCTIONS, write_readings, write_template
from atleak.report.sheets.paging import HEADER as PAGED_HEADER
from atleak.report.sheets.pressure_sheet import PRESSURES_TITLE

HEADER = MEASURING_HEADER + 1  # row of the headings as a spreadsheet counts
COMPONENT, NAME, PART, PLANE, DIRECTION, X1, X2, DIAMETER = range(1, 9)
SECOND_DIAMETER, NOMINAL, CLEARANCE, ORIGIN, DEVIATION, SECOND_DEVIATION, TAKEN_AT = range(11, 18)
DIAMETERS = (DIAMETER, SECOND_DIAMETER)  # by their repeats
TABS_FIRST = PAGED_HEADER + 2  # the first row below the headings of the other tabs


@pytest.fixture(scope="module", params=["four_speed_2023", "minimal_example"])
def controller(request):
    return load_controller(request.param)


@pytest.fixture(scope="module")
def template(controller):
    return write_template(controller)


def opened(data):
    return openpyxl.load_workbook(io.BytesIO(data))


@pytest.fixture(scope="module")
def book(template):
    """The template as it is, to look at."""
    return opened(template)


def merged_value(sheet, row, column):
    """What stands in the first cell of the merged range."""
    while isinstance(sheet.cell(row, column), MergedCell):
        row -= 1
    return sheet.cell(row, column).value


def test_the_same_controller_gives_the_same_bytes(controller, template):
    assert write_template(controller) == template


def test_every_plane_of_every_land_has_both_parts_two_directions_and_two_repeats(controller, book):
    sheet = book[SHEET]
    rows = [
        tuple(merged_value(sheet, row, column) for column in (COMPONENT, PART, PLANE, DIRECTION))
        for row in range(HEADER + 1, sheet.max_row + 1)
    ]
    wanted = {
        (land.component, part, plane, direction)
        for land in controller.lands
        for part in (land.part, "sleeve")
        for plane in land.planes
        for direction in (0, 90)
    }
    assert [str(sheet.cell(HEADER, column).value) for column in DIAMETERS] == ["Diameter 1 [mm]", "Diameter 2 [mm]"]
    assert {(str(component), part, str(plane), *rest) for component, part, plane, *rest in rows} == wanted
    assert len(rows) == len(wanted)


def test_names_nominal_diameters_and_clearances_stand_beside_and_say_where_they_are_assumed(controller, book):
    sheet = book[SHEET]
    for row in range(HEADER + 1, sheet.max_row + 1):
        component, name, part, plane, nominal, clearance, origin = (
            merged_value(sheet, row, column) for column in (COMPONENT, NAME, PART, PLANE, NOMINAL, CLEARANCE, ORIGIN)
        )
        land = controller.land_of_plane(str(component), str(plane))
        assert name == controller.components[land.component]
        diameter = land.nominal_sleeve_diameter if part == "sleeve" else land.nominal_diameter
        assert nominal == pytest.approx(diameter * 1e3, abs=1e-9)
        assert clearance == pytest.approx(land.mounting_clearance * 1e6, abs=1e-6)
        assert ("assumed" in origin) == ("mounting_clearance_um" in land.representative)
    assert sheet["A3"].value == wording("en")("how_to_measure.nominal_values")


def test_the_published_diameters_of_spool_6_are_not_called_assumed():
    sheet = opened(write_template(load_controller("four_speed_2023")))[SHEET]
    row = next(row for row in range(HEADER + 1, sheet.max_row) if merged_value(sheet, row, COMPONENT) == 6)
    assert merged_value(sheet, row, ORIGIN) == "clearance assumed"


def test_it_is_made_for_filling_in_on_screen_and_on_paper(book):
    sheet = book[SHEET]
    assert book.sheetnames == [SHEET, LANDS, PRESSURES_TITLE, MEASURING_INSTRUCTIONS]
    assert sheet.freeze_panes == f"D{HEADER + 1}"
    assert sheet.print_title_rows == f"${HEADER}:${HEADER}"
    orientations = [tab.page_setup.orientation for tab in book]
    assert orientations == ["portrait", "portrait", "portrait", "portrait"]
    assert sheet.print_area.endswith(f"$N${sheet.max_row}")  # deviations and the ends are for the screen
    validation, taken_at, part, direction, for_spools, for_bores = sheet.data_validations.dataValidation
    assert {str(one.sqref)[0] for one in (part, direction)} == {"C", "E"}
    parts = part.formula1.strip('"').split(",")
    assert parts == list(dict.fromkeys(merged_value(sheet, row, PART) for row in range(HEADER + 1, sheet.max_row + 1)))
    assert (direction.formula1, bool(direction.showErrorMessage)) == ('"0,45,90,135"', False)  # another may be typed
    assert for_spools.formula1 == '"Air gauge,Outside micrometer,Workshop microscope"'
    assert for_bores.formula1 == '"Air gauge,Two-point bore gauge,Workshop microscope"'
    labels = tuple(sheet[str(each.sqref)].offset(0, -2).value for each in (for_spools, for_bores))
    assert labels == ("Instrument for spools", "Instrument for bores")
    assert (taken_at.type, taken_at.formula1) == ("list", '"unworn end"')
    assert str(taken_at.sqref) == f"Q{HEADER + 1}:Q{sheet.max_row}"
    assert (validation.type, validation.operator, validation.formula1) == ("decimal", "greaterThan", "0")
    assert str(validation.sqref) == f"F{HEADER + 1}:K{sheet.max_row}"
    inputs = {sheet.cell(HEADER + 1, column).fill.fgColor.rgb for column in range(X1, SECOND_DIAMETER + 1)}
    assert inputs == {"FFFFF8DC"}
    assert sheet.cell(HEADER + 1, NOMINAL).fill.fgColor.rgb != "FFFFF8DC"
    headings = " ".join(str(cell.value) for cell in sheet[HEADER])
    assert headings.count("[mm]") == 7
    assert "[µm]" in headings


PAPERS = {"9": (210.0, 297.0), "1": (215.9, 279.4)}  # A4 and Letter [mm]


@pytest.mark.parametrize(
    ("name", "language", "units"),
    [
        ("four_speed_2023", "en", "metric"),
        ("four_speed_2023", "de", "us"),
        ("gm_4l60e", "de", "us"),
        ("five_speed_2005", "pl", "metric"),
    ],
)
def test_on_paper_rows_take_a_pencil_columns_fit_a_page_and_no_part_of_a_component_is_cut(name, language, units):
    controller = load_controller(name)
    data = write_template(controller, language=language, units=units)
    sheet, *tabs, _ = opened(data).worksheets
    for tab in tabs:  # of lands and of pressures
        assert_rows_take_a_pencil(tab, TABS_FIRST)
    assert_nothing_of_an_id_is_broken(tabs[0], controller)
    scale = sheet.page_setup.scale / 100
    heights = [sheet.row_dimensions[row].height or 15.0 for row in range(1, sheet.max_row + 1)]
    assert min(heights[3 : HEADER - 1] + heights[HEADER:]) * scale * 25.4 / 72 >= 7.0
    widths = [
        each.width * (min(each.max, ORIGIN) - each.min + 1)
        for each in sheet.column_dimensions.values()
        if each.min <= ORIGIN
    ]
    assert sum(7 * width for width in widths) / 96 * 25.4 * scale < least(0) - 0.6 * 25.4
    assert scale * 10 >= 6.0  # [pt] the smallest letters that are printed
    assert str(sheet.page_setup.paperSize) == ("1" if units == "us" else "9")
    ends = [mark.id for mark in sheet.row_breaks.brk]  # last rows of pages
    margins = sheet.page_margins.top + sheet.page_margins.bottom
    room = (least(1) / 25.4 - margins) * 72 / scale  # [pt]
    for first, last in pairwise([0, *ends, sheet.max_row]):
        repeated = heights[HEADER - 1] if first else 0
        assert repeated + sum(heights[first:last]) <= room
    before, behind = (
        [tuple(merged_value(sheet, last + on, column) for column in (COMPONENT, PART, PLANE)) for last in ends]
        for on in (0, 1)
    )
    assert [one for one, other in zip(before, behind, strict=True) if one == other] == []
    if name == "four_speed_2023":
        assert len(ends) + 1 <= 7


def least(side):
    """The shorter of the papers' widths or heights: what is laid out for it fits on both."""
    return min(paper[side] for paper in PAPERS.values())


@pytest.mark.slow
@pytest.mark.parametrize("units", ["metric", "us"])
def test_the_sheet_of_47_lands_is_printed_on_ten_pages(units, tmp_path, convert):
    (tmp_path / "sheet.xlsx").write_bytes(write_template(load_controller("four_speed_2023"), units=units))
    convert(tmp_path / "sheet.xlsx", "pdf")
    with pypdfium2.PdfDocument(tmp_path / "sheet.pdf") as printed:
        assert len(printed) == 10
        size = [side / 72 * 25.4 for side in printed[0].get_size()]
        assert size == pytest.approx(PAPERS["1" if units == "us" else "9"], abs=1.0)
        assert "ATF temperature [" in printed[8].get_textpage().get_text_range()  # on one line


def assert_rows_take_a_pencil(tab, first):
    """As printed: at a scale that the sheet states, with all columns on the page, by which the heights are chosen."""
    scale = (tab.page_setup.scale or 100) / 100
    assert scale * 10 >= 6.0
    assert not tab.sheet_properties.pageSetUpPr.fitToPage
    widths = [dimension.width * (dimension.max - dimension.min + 1) for dimension in tab.column_dimensions.values()]
    assert (
        sum(7 * width for width in widths) / 96 * 25.4 * scale
        < least(tab.page_setup.orientation == "landscape") - 0.6 * 25.4
    )
    heights = [tab.row_dimensions[row].height for row in range(first, tab.max_row + 1)]
    assert min(heights) * scale * 25.4 / 72 >= 7.0


def assert_nothing_of_an_id_is_broken(lands, controller):
    ids = {1: [land.component for land in controller.lands]}
    if controller.repairs:
        printed = max(each.max for each in lands.column_dimensions.values())  # the mark stands right of it
        ids[printed] = [repair.id for repair in controller.repairs]
    for column, names in ids.items():
        (width,) = [each.width for each in lands.column_dimensions.values() if each.min <= column <= each.max]
        assert width > max(map(len, names))


def test_the_rows_follow_the_order_that_the_sheet_states(controller, book):
    sheet = book[SHEET]
    columns = (COMPONENT, PART, PLANE, DIRECTION)
    rows = [
        tuple(merged_value(sheet, row, column) for column in columns) for row in range(HEADER + 1, sheet.max_row + 1)
    ]
    components = list(dict.fromkeys(land.component for land in controller.lands))
    assert rows == sorted(
        rows, key=lambda row: (components.index(str(row[0])), row[1] == "sleeve", str(row[2]), row[3])
    )
    assert sheet["A2"].value.endswith("all again in the columns of the second repeat; then its bore likewise.")


def test_every_spool_is_drawn_within_its_component_s_rows_and_named_for_who_cannot_see_it(controller, template, book):
    sheet = book[SHEET]
    drawn = {}
    for picture, mark in zip(sheet._images, marks_of(template), strict=True):
        row, below = picture.anchor._from.row + 1, picture.anchor.to.row + 1
        if row > HEADER:
            assert merged_value(sheet, row, COMPONENT) == merged_value(sheet, below, COMPONENT)
            assert picture.anchor._from.col == picture.anchor.to.col == NAME - 1
            drawn[str(merged_value(sheet, row, COMPONENT))] = mark
    assert list(drawn) == list(dict.fromkeys(land.component for land in controller.lands))
    for component, mark in drawn.items():
        name = controller.components[component]
        assert mark == f"component {component}, {name}: lands and measuring planes"
    assert len(template) < 90_000


def marks_of(data):
    """The alternative text of every picture of a sheet, in the order of its pictures."""
    with zipfile.ZipFile(io.BytesIO(data)) as parts:
        drawing = ElementTree.fromstring(parts.read("xl/drawings/drawing1.xml"))
    return [each.attrib.get("descr") for each in drawing.iter() if each.tag.endswith("}cNvPr")]


def test_a_job_that_is_known_stands_in_the_head_with_a_code_to_scan(controller):
    vehicle = Vehicle(make="Volvo", model="V70", registration="AB 123", vin="YV1SW61", mileage_km=212000.0)
    job = Job(number="2026-0417", technician="K. Weber", measured_on="2026-04-17", vehicle=vehicle)
    fields = fields_of(job)
    assert fields == {
        "Job": "2026-0417",
        "Vehicle": "Volvo V70, AB 123",
        "Date": "2026-04-17",
        "Measured by": "K. Weber",
        "VIN": "YV1SW61",
        "Mileage": "212000 km",
    }
    assert code_text(controller, fields) == f"2026-0417 {controller.id}"
    known, unknown = write_template(controller, fields=fields), write_template(controller, fields={"Vehicle": "Volvo"})
    assert write_template(controller, fields=fields) == known
    assert f"QR code: 2026-0417 {controller.id}" in marks_of(known)
    assert not any("QR" in mark for mark in marks_of(unknown))
    with zipfile.ZipFile(io.BytesIO(known)) as parts:
        pictures = [Image.open(io.BytesIO(parts.read(part))) for part in parts.namelist() if part.endswith(".png")]
    (code,) = [code for picture in pictures for code in zxingcpp.read_barcodes(picture)]
    assert (code.text, code.format) == (f"2026-0417 {controller.id}", zxingcpp.BarcodeFormat.QRCode)
    assert {"2026-0417", "Volvo V70, AB 123", "212000 km"} <= {
        cell.value for row in opened(known)[SHEET] for cell in row
    }


@pytest.mark.parametrize(
    ("used", "spools", "bores"),
    [
        (("M 1", "B 2"), "M 1", "B 2"),
        (("Two-point bore gauge", "Outside micrometer"), "Outside micrometer", "Two-point bore gauge"),
        (("Outside micrometer",), "Outside micrometer", None),
        (("Workshop microscope",), "Workshop microscope", "Workshop microscope"),
    ],
)
def test_the_instruments_of_a_record_stand_where_they_measure(used, spools, bores):
    fields = fields_of(Job(instruments=[{"name": name} for name in used]))
    assert (fields.get("Instrument for spools"), fields.get("Instrument for bores")) == (spools, bores)


def test_without_a_number_the_code_names_the_transmission_and_else_the_vehicle(controller):
    fields = {"Serial number": "T 1", "VIN": "YV1SW61"}
    assert code_text(controller, fields) == f"T 1 {controller.id}"
    assert code_text(controller, {"VIN": "YV1SW61"}) == f"YV1SW61 {controller.id}"
    assert code_text(controller, {"VIN": "1" * 4000}) == ""  # no code holds so much


def test_numbers_typed_as_text_with_a_decimal_comma_are_read_back(controller, template):
    book = opened(template)
    sheet = book[SHEET]
    for row in range(HEADER + 1, sheet.max_row + 1):
        for column in DIAMETERS:
            sheet.cell(row, column, f"{merged_value(sheet, row, NOMINAL):.3f}".replace(".", ","))
    target = io.BytesIO()
    book.save(target)
    readings = read_readings(target.getvalue(), controller)
    assert len(readings.readings) == 2 * (sheet.max_row - HEADER)
    for reading in readings.readings:
        nominal = controller.land_of_plane(reading.component, reading.plane).nominal_of(reading.part)
        assert reading.diameter == pytest.approx(nominal, abs=0.6e-6)


def test_the_instructions_are_as_high_as_their_texts_are_long(controller, book):
    sheet = book[MEASURING_INSTRUCTIONS]
    for row in sheet.iter_rows(min_row=3, max_col=2):
        for cell, width in zip(row, (22, 98), strict=True):
            lines = len(textwrap.wrap(cell.value or "", 0.9 * width))
            assert sheet.row_dimensions[cell.row].height >= 13.5 * lines


def test_the_instructions_are_there(controller, book):
    text = " ".join(str(cell.value) for row in book[MEASURING_INSTRUCTIONS].iter_rows() for cell in row if cell.value)
    text = text.replace("\u00a0", " ")
    for word in ("twice", "20 °C", "lower bound", "0.001", "marked assumed are neither measured nor published"):
        assert word in text


def test_an_empty_one_says_that_nothing_is_filled_in(controller, template):
    with pytest.raises(ReadingsError, match="no readings are filled in") as caught:
        read_readings(template, controller, name="sheet.xlsx")
    assert (caught.value.place.sheet, caught.value.place.row) == (SHEET, HEADER)


@pytest.mark.parametrize("with_coordinates", [True, False])
def test_filled_in_it_reads_back(controller, template, with_coordinates):
    book = opened(template)
    sheet = book[SHEET]
    for row in range(HEADER + 1, sheet.max_row + 1):
        worn = 0.004 if merged_value(sheet, row, PART) == "sleeve" else 0.0
        for repeat, column in enumerate(DIAMETERS):
            diameter = round(merged_value(sheet, row, NOMINAL) + worn + 0.001 * repeat, 3)
            if with_coordinates:
                sheet.cell(row, column - 2, 20.0 + 0.001 * row)
                sheet.cell(row, column - 1, round(20.0 + 0.001 * row + diameter, 3))
            else:
                sheet.cell(row, column, diameter)
    buffer = io.BytesIO()
    book.save(buffer)
    readings = read_readings(buffer.getvalue(), controller, name="sheet.xlsx")
    assert (readings.sheet, readings.unit, readings.unit_assumed) == (SHEET, "mm", False)
    assert readings.layout == ("table" if with_coordinates else "columns")
    assert len(readings.readings) == 2 * (sheet.max_row - HEADER)
    for state in clearances(readings, controller):
        assert state.status == "measured"
        rounding = 0.5e-6  # the sheet takes micrometres
        assert state.radial_clearance == pytest.approx(state.land.mounting_clearance + 2e-6, abs=1.01 * rounding)
        assert (state.spool_repeats, state.sleeve_repeats) == (2, 2)
        assert state.messages == ()


def test_readings_are_written_and_read_back_with_their_places(controller):
    land = controller.lands[-1]
    diameter = land.nominal_diameter
    given = [
        Reading(land.component, "spool", land.planes[0], 0.0, 1, diameter, coordinates=(0.05, 0.05 + diameter)),
        Reading(land.component, "spool", land.planes[0], 45.0, 1, diameter),
        Reading(land.component, "sleeve", land.planes[0], 0.0, 3, diameter + 70e-6),
        Reading("no such component", "sleeve", "1", 0.0, 1, 0.01),
    ]
    for blank_rows in (True, False):
        data = write_readings(controller, given, blank_rows=blank_rows)
        read_back = read_readings(data, controller)
        assert {(one.part, one.direction, one.repeat) for one in read_back.readings} == {
            ("spool", 0.0, 1),
            ("spool", 45.0, 1),
            ("sleeve", 0.0, 3),
        }
        for one in read_back.readings:
            wanted = given[[(each.part, each.direction) for each in given].index((one.part, one.direction))]
            assert one.diameter == pytest.approx(wanted.diameter, rel=1e-12, abs=0.0)
            sheet = opened(data)[SHEET]
            column = openpyxl.utils.column_index_from_string(one.place.column)
            assert isinstance(sheet.cell(one.place.row, column).value, float | int)


def test_the_deviation_from_the_nominal_diameter_is_a_formula_with_its_value(controller):
    land = controller.lands[0]
    reading = Reading(land.component, "spool", land.planes[0], 0.0, 1, land.nominal_diameter - 7e-6)
    data = write_readings(controller, [reading])
    values = openpyxl.load_workbook(io.BytesIO(data), data_only=True)[SHEET]
    assert values.cell(HEADER + 1, DEVIATION).value == pytest.approx(-7.0, abs=1e-6)
    formula = opened(data)[SHEET].cell(HEADER + 1, DEVIATION).value
    assert formula.startswith("=IF(")
    assert f"$L${HEADER + 1}" in formula


def test_the_deviation_follows_a_heading_in_inches(controller, calculator):
    nominal, row = controller.lands[0].nominal_diameter, HEADER + 1
    book = calculator(write_template(controller))
    book.set(SHEET, f"G{HEADER}", "x2 [in]")
    book.set(SHEET, f"F{row}", 5.0)
    book.set(SHEET, f"G{row}", (nominal + 5e-3 - 3e-6) / 0.0254)
    for column in "HIJ":
        book.set(SHEET, f"{column}{row}", float("nan"))  # stands for an empty cell, which counts as 0 in a spreadsheet
    assert book.value(SHEET, f"O{row}") == pytest.approx(-3.0, abs=1e-6)
    book.set(SHEET, f"K{HEADER}", "Diameter [inch]")
    book.set(SHEET, f"K{row}", (nominal + 7e-6) / 0.0254)
    assert book.value(SHEET, f"P{row}") == pytest.approx(7.0, abs=1e-6)


def test_nothing_that_a_user_wrote_becomes_a_formula_or_a_link(tmp_path):
    source = load_controller("minimal_example").origin.path.read_text(encoding="utf-8")
    evil = ("=1+1", "http://example.invalid/", "@SUM(A1)", "&[Path]")
    for number, name in enumerate(("pressure regulator valve", "accumulator piston", "solenoid modulator valve")):
        assert name in source
        source = source.replace(name, evil[number])
    source = source.replace('name = "Example of a workshop\'s own description"', 'name = "=cmd|calc & co"')
    path = tmp_path / "evil.toml"
    path.write_text(source, encoding="utf-8")
    controller = load_controller(path)
    assert controller.name == "=cmd|calc & co"
    data = write_readings(controller, (), fields={"Job": "=2+2", "Vehicle": "+3", "Date": "-4"})
    sheet = opened(data)[SHEET]
    for row in sheet.iter_rows():
        for cell in row:
            if cell.data_type == "f":
                assert cell.column in (DEVIATION, SECOND_DEVIATION)
            assert cell.hyperlink is None
    texts = {cell.value for row in sheet.iter_rows() for cell in row if cell.data_type == "s"}
    assert {"=1+1", "http://example.invalid/", "@SUM(A1)", "=2+2", "+3", "-4"} <= texts
    assert "=cmd|calc && co" in sheet.oddFooter.left.text


# --- the tab of pressures


def test_the_tab_of_pressures_has_a_row_for_every_range_and_what_the_file_permits(permitting):
    permissible = (
        '\n[[permissible_pressure]]\ngear = 1\nstate = "idle"\nlow_kpa = 412.0\nhigh_kpa = 539.0\nsource = "own"\n'
    )
    sheet = opened(write_template(load_controller(permitting(permissible))))[PRESSURES_TITLE]
    rows = [[cell.value for cell in row] for row in sheet.iter_rows(min_row=7)]
    assert [row[0] for row in rows] == ["P", "R", "N", "D", "3", "2", "1"]
    assert {row[1] for row in rows} == {"line"}
    assert {row[0]: row[5] for row in rows}["D"] == "412 to 539"
    assert {row[0]: row[6] for row in rows}["D"] == "from 412"
    assert not rows[0][5]


def test_readings_on_the_tab_of_pressures_read_back_and_an_empty_tab_is_no_table(controller):
    cells = [GaugeCell("D", Engine.SLOW_IDLE), GaugeCell("R", Engine.STALL)]
    given = tuple(GaugeReading(cell, 412_345.6 + number) for number, cell in enumerate(cells))
    table = PressureTable("", "", None, (), given)
    back = read_readings(write_readings(controller, (), pressures=table), controller).pressures
    assert [each.cell for each in back.readings] == [GaugeCell("R", Engine.STALL), GaugeCell("D", Engine.SLOW_IDLE)]
    assert sorted(each.pressure for each in back.readings) == pytest.approx([412_345.6, 412_346.6], abs=1e-6)
    with pytest.raises(ReadingsError, match="no readings are filled in"):
        read_readings(write_template(controller), controller)


def test_the_field_of_the_fluids_temperature_on_the_tab_holds_for_all_readings(controller):
    table = PressureTable("", "", None, (), (GaugeReading(GaugeCell("D", Engine.SLOW_IDLE), 412e3),))
    book = opened(write_readings(controller, (), pressures=table))
    book[PRESSURES_TITLE]["C4"] = "82,5"
    target = io.BytesIO()
    book.save(target)
    assert read_readings(target.getvalue(), controller).pressures.readings[0].temperature == 82.5


def test_every_cell_of_the_tab_is_read_back_at_the_tap_of_its_circuit():
    controller = load_controller("five_speed_2005")
    book = opened(write_template(controller))
    sheet = book[PRESSURES_TITLE]
    for row in range(7, sheet.max_row + 1):
        for column in range(3, 6):
            sheet.cell(row, column).value = 100 + 10 * row + column
    target = io.BytesIO()
    book.save(target)
    table = read_readings(target.getvalue(), controller).pressures
    assert table.taps == tuple(tap for tap in taps_of(controller) if tap in table.taps)
    assert {"forward_clutch", "direct_clutch", "epc"} < set(table.taps)
    assert "overdrive_band" not in table.taps  # which no range applies while the vehicle stands
    assert {"P", "R", "N", "D", "4", "1"} <= {each.cell.range for each in table.readings if each.cell.tap == LINE_TAP}
    for each in table.readings:
        assert each.pressure == (100 + 10 * each.place.row + 3 + list(Engine).index(each.cell.engine)) * 1e3
        assert applied(controller, each.cell)
    assert len(table.readings) == 3 * (sheet.max_row - 6)


def test_the_lands_of_end_plugs_and_pistons_are_read_back():
    controller = load_controller("gm_4l60e")
    assert {land.part for land in controller.lands} == {"end_plug", "piston", "spool"}
    lands = {land.key: land.nominal_diameter for land in controller.lands}
    written = [
        Reading(component, part, plane, 0.0, 1, lands[component, land] + wider)
        for component, land in lands
        for plane in controller.land(component, land).planes
        for part, wider in (("spool", 0.0), ("sleeve", 30e-6))
    ]
    states = clearances(read_readings(write_readings(controller, written), controller), controller)
    assert {state.land.key for state in states} == set(lands)
    assert [state.radial_clearance for state in states] == pytest.approx([15e-6] * len(lands), abs=1e-9)
