"""Parts of two units are not put together, and what a sheet says besides its diameters is not lost."""

from __future__ import annotations

import io
import re

import openpyxl
import pytest

from atleak.common.errors import ReadingsError
from atleak.measurements.readings import Readings
from atleak.readers.sheets.measuring_sheet import read_readings

PAIR = ("tcc_regulator", "1", "10.998", "11.032")
LANDS = (PAIR, ("accumulator", "1", "17.998", "18.041"))


def read(controller, *lines, **choices) -> Readings:
    return read_readings("\n".join(lines).encode(), controller, name="sheet.csv", **choices)


def refusal(controller, *lines, **choices) -> str:
    with pytest.raises(ReadingsError) as refused:
        read(controller, *lines, **choices)
    return str(refused.value)


def said(readings, code):
    return [message.text for message in readings.messages if message.code == code]


def halves(first, second):
    spools = [f"{component};{land};{spool}" for component, land, spool, _ in LANDS]
    bores = [f"{component};{land};{bore}" for component, land, _, bore in LANDS]
    return (first, "Valve;Land;Spool [mm]", *spools, "", second, "Valve;Land;Bore [mm]", *bores)


@pytest.mark.parametrize(
    ("first", "second"),
    [("Gearbox 1", "Gearbox 2"), ("Unit A (Smith)", "Unit B (Jones)"), ("Getriebe Nr. 7", "Getriebe Nr. 8")],
)
def test_titles_of_two_units_are_refused_with_both_names(controller, first, second):
    assert f"{first!r} and {second!r}" in refusal(controller, *halves(first, second))


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Gearbox 1", "Gearbox 1"),
        ("Unit A: spools", "Unit A: bores"),
        ("Spools", "Unit: mm"),
        ("Micrometer serial 4711", "Comparator serial 8822"),
    ],
)
def test_titles_of_one_unit_are_read_as_one_measurement(controller, first, second):
    assert len(read(controller, *halves(first, second)).readings) == 4


def test_sheets_of_two_units_are_refused_and_one_can_be_chosen(controller):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, (component, land, spool, bore) in zip(("Unit A (Smith)", "Unit B (Jones)"), LANDS, strict=True):
        sheet = book.create_sheet(name)
        sheet.append(["Valve", "Land", "Spool [mm]", "Bore [mm]"])
        sheet.append([component, int(land), float(spool), float(bore)])
    stream = io.BytesIO()
    book.save(stream)
    with pytest.raises(ReadingsError, match=r'--sheet "Unit A \(Smith\)"'):
        read_readings(stream.getvalue(), controller, name="sheet.xlsx")
    chosen = read_readings(stream.getvalue(), controller, name="sheet.xlsx", sheet="Unit B (Jones)")
    assert {reading.component for reading in chosen.readings} == {"accumulator"}


SERIALS = (
    "Valve;Land;Part;Serial;Diameter [mm]",
    *(f"{component};{land};spool;A17;{spool}" for component, land, spool, _ in LANDS),
    *(f"{component};{land};bore;B18;{bore}" for component, land, _, bore in LANDS),
)


def test_a_column_of_two_serial_numbers_is_refused_until_rows_are_chosen(controller):
    assert '--where "Serial=A17"' in refusal(controller, *SERIALS)
    assert len(read(controller, *SERIALS, where={"Serial": "A17"}).readings) == 2


@pytest.mark.parametrize("heading", ["Gauge serial", "Micrometer S/N", "Part serial", "Spool serial"])
def test_the_serial_number_of_a_gauge_or_part_is_no_question(controller, heading):
    lines = (SERIALS[0].replace("Serial", heading), *SERIALS[1:])
    assert len(read(controller, *lines).readings) == 4


def test_a_serial_number_for_every_part_is_no_question(controller):
    lines = [line.replace("A17", f"A{at}").replace("B18", f"B{at}") for at, line in enumerate(SERIALS)]
    assert len(read(controller, *lines).readings) == 4


@pytest.mark.parametrize("heading", ["Clearance [µm]", "Spiel [µm]", "Gap [µm]", "Bore wear [µm]", "Szczelina [µm]"])
def test_a_clearance_without_the_other_part_is_named(controller, heading):
    readings = read(controller, f"Valve;Land;Spool [mm];{heading}", "tcc_regulator;1;10.998;94")
    (text,) = said(readings, "clearance_not_used")
    assert text.startswith(f"column {heading!r} is not used in row 2, where only one part was measured")


def test_a_clearance_of_a_land_whose_parts_stand_in_two_rows_is_used(controller):
    lines = ("tcc_regulator;1;spool;10.998;34", "tcc_regulator;1;bore;11.032;34")
    readings = read(controller, "Valve;Land;Part;Diameter [mm];Clearance [µm]", *lines)
    assert not said(readings, "clearance_not_used")


@pytest.mark.parametrize(
    ("sentence", "is_told"),
    [
        ("Zero error of the micrometer: +0.004 mm (to be subtracted)", True),
        ("The zero error of the bore gauge was 3 µm", True),
        ("Nullpunktfehler der Messschraube: +0,004 mm (abzuziehen)", True),
        ("Błąd zera mikrometru: +0,004 mm", True),
        ("Zero error of the micrometer: 0.000 mm", False),
        ("Diameters corrected for the zero error of the micrometer: +0.004 mm", False),
        ("Micrometer zeroed at 18 mm", False),
    ],
)
def test_a_zero_error_in_a_sentence_above_the_table_is_told(controller, sentence, is_told):
    table = "Valve;Land;Spool [mm];Bore [mm]\ntcc_regulator;1;10.998;11.032"
    readings = read_readings(f"{sentence}\n\n{table}".encode(), controller, name="sheet.csv")
    found = said(readings, "correction_not_applied")
    assert bool(found) == is_told
    assert not is_told or repr(sentence) in str(found)


@pytest.mark.parametrize("heading", ["Zero [mm]", "Zero error [mm]", "Gauge zero [mm]", "Nullpunkt [mm]"])
@pytest.mark.parametrize("zero", ["0.012", "0"])
def test_a_zero_that_is_not_zero_is_told(controller, heading, zero):
    readings = read(controller, f"Valve;Land;Spool [mm];Bore [mm];{heading}", f"tcc_regulator;1;10.998;11.032;{zero}")
    assert bool(said(readings, "correction_not_applied")) == (zero != "0")


def test_a_ring_that_the_gauge_was_set_with_is_no_correction(controller):
    lines = ("Zero set with ring 15.000 mm", "Readings of today", "Valve;Land;Spool [mm];Bore [mm]", ";".join(PAIR))
    assert not said(read(controller, *lines), "correction_not_applied")


def test_two_lands_exchanged_are_refused_naming_both(controller):
    lines = (
        "Valve;Land;Spool [mm];Bore [mm]",
        "pressure_regulator;2;14.997;15.034",
        "pressure_regulator;1;12.498;12.535",
    )
    text = refusal(controller, *lines)
    assert "component pressure_regulator land 2 measures like component pressure_regulator land 1" in text


SIZES = {("pressure_regulator", "1"): (14.997, 15.034), ("pressure_regulator", "2"): (12.498, 12.535),
         ("tcc_regulator", "1"): (10.998, 11.032)}  # fmt: skip


@pytest.mark.parametrize("onward", [1, 2])
def test_three_lands_exchanged_in_a_circle_are_refused_naming_all(controller, onward):
    lands = list(SIZES)
    rows = [
        f"{component};{land};{SIZES[lands[(number + onward) % 3]][0]};{SIZES[lands[(number + onward) % 3]][1]}"
        for number, (component, land) in enumerate(lands)
    ]
    text = refusal(controller, "Valve;Land;Spool [mm];Bore [mm]", *rows)
    like = " land ".join(lands[onward])
    assert f"component pressure_regulator land 1 measures like component {like}: the readings of component " in text
    assert text.count("exchanged in a circle?") == 3
    assert "pressure_regulator land 2 and component tcc_regulator land 1 exchanged in a circle?" in text


def test_lands_that_measure_like_others_without_a_circle_are_not_called_exchanged(controller):
    rows = ("pressure_regulator;1;12.498;12.535", "pressure_regulator;2;10.998;11.032", "tcc_regulator;1;10.998;11.032")
    assert len(read(controller, "Valve;Land;Spool [mm];Bore [mm]", *rows).readings) == 6


def test_a_column_of_temperatures_is_named_unless_the_head_states_one(controller):
    table = ("Valve;Land;Spool [mm];Bore [mm];Temp [°C]", *(";".join((*pair, "38")) for pair in LANDS))
    (text,) = said(read(controller, *table), "temperature_not_read")
    assert text.startswith("column 'Temp [°C]' says 38 and is not read")
    stated = read(controller, "Temperature:;38", "", *table)
    assert stated.temperature == 38.0
    assert not said(stated, "temperature_not_read")


def test_a_row_of_sigma_is_a_spread(controller):
    rows = [f"tcc_regulator;1;{part}" for part in ("spool", "bore")]
    sizes = [("R1", "10.998", "11.032"), ("avg", "10.998", "11.032"), ("σ", "0.001", "0.001")]
    lines = [f"{row};{repeat};{size[at]}" for at, row in enumerate(rows) for repeat, *size in sizes]
    readings = read(controller, "Valve;Land;Part;Repeat;Diameter [mm]", *lines)
    assert len(readings.readings) == 2
    assert not said(readings, "summary_disagrees")


@pytest.mark.parametrize(
    ("headings", "row", "says"),
    [
        (
            "Valve;Land;Part;Mean [mm];SD [mm]",
            "tcc_regulator;1;spool;10.998;0.002",
            "and a mean, is no measurement ('Mean [mm]')",
        ),
        (
            "Valve;Land;Spool Anna;Spool Ben",
            "tcc_regulator;1;10.998;10.999",
            '"value which 1=Spool Anna"',
        ),
        (
            "Valve;Land;Part;Shift 1 [mm];Shift 2 [mm]",
            "tcc_regulator;1;spool;10.998;11.010",
            '"value which 1=Shift 1 [mm]"',
        ),
        (
            "Valve;Land;Nominal [mm];Spool dev Anna [µm];Spool dev Ben [µm]",
            "tcc_regulator;1;11.0;-2;-3",
            '"deviation which 1=Spool dev Anna [µm]" --map "deviation which 2=Spool dev Ben [µm]"',
        ),
    ],
)
def test_the_refusal_of_headings_names_the_columns_that_hold_the_numbers(controller, headings, row, says):
    assert says in refusal(controller, headings, row)


def test_remarks_that_return_at_every_land_are_refused_with_the_word_that_strikes_a_row_out(controller):
    rows = [
        f"{component};{land};spool;{spool};{said}" for component, land, spool, _ in LANDS for said in ("dirty", "clean")
    ]
    headings = "Valve;Land;Part;Diameter [mm];Remark"
    assert "the remark 'rejected'" in refusal(controller, headings, *rows)
    assert len(read(controller, headings, *(row.replace("dirty", "rejected") for row in rows)).readings) == 2


@pytest.mark.parametrize("heading", ["Diameter [1/100 mm]", "Diameter (1/100 mm)", "Diameter in 1/100 mm"])
def test_hundredths_of_a_millimetre_are_a_unit(controller, heading):
    pair = ("tcc_regulator;1;spool;1099.8", "tcc_regulator;1;bore;1103.2")
    readings = read(controller, f"Valve;Land;Part;{heading}", *pair)
    assert [round(each.diameter * 1e3, 6) for each in readings.readings] == [10.998, 11.032]
    assert readings.unit == "1/100 mm"
    lines = ("tcc_regulator;1;spool;1099.8;1/100 mm", "tcc_regulator;1;bore;11032;1/1000 mm")
    assert read(controller, "Valve;Land;Part;Diameter;Unit", *lines).unit == "1/100 mm, µm"


TABLE = "Valve;Land;Spool [mm];Bore [mm];Code\ntcc_regulator;1;10.998;11.032;V\naccumulator;1;17.998;18.041;"


@pytest.mark.parametrize(
    ("before", "behind", "left"),
    [
        ("", "gauge reads 0.003 low", 4),
        ("add 3 µm to all bores", "", 4),
        ("", "Zero offset 0.002 mm", 4),
        ("", "Messschraube zeigt 0,003 zu wenig", 4),
        ("", "Zero error of the micrometer: +0.004 mm", 4),
        ("", "V = void", 2),
        ("", "V – ungültig", 2),
    ],
)
def test_a_line_that_changes_readings_is_asked_about_and_the_rows_that_count_settle_it(
    controller, before, behind, left
):
    written = "\n".join(filter(None, (before, TABLE, behind))).encode()
    with pytest.raises(ReadingsError, match="line") as caught:
        read_readings(written, controller, name="sheet.csv")
    role, rows = re.search(r'--map "(rows)=([^"]*)"', str(caught.value)).groups()
    readings = read_readings(written, controller, name="sheet.csv", mapping={role: rows})
    assert len(readings.readings) == left


@pytest.mark.parametrize(
    "line",
    [
        "measured at 20 °C, micrometer 0-25",
        "Spools under the lens 20x",
        "V = new bore",
        "corrected for an offset of 0.003",
    ],
)
def test_a_line_that_changes_nothing_is_no_question(controller, line):
    assert len(read_readings(f"{TABLE}\n{line}".encode(), controller, name="sheet.csv").readings) == 4


@pytest.mark.parametrize("head", ["Valve body;AW55", "AW55-50SN valve body", "Transmission: 4L60E"])
def test_a_head_that_names_another_model_of_the_catalogue_is_refused(controller, head):
    with pytest.raises(ReadingsError, match="made for controller"):
        read_readings(f"{head}\n{TABLE}".encode(), controller, name="sheet.csv")
