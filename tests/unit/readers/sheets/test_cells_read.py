"""What became of every cell of a sheet is kept: each number of the size of a diameter has a kind, with a reason."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import openpyxl
import pytest
from openpyxl.styles import Font

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.measurements.readings import SheetCells
from atleak.readers.sheets.controller_names import INCH, MILLIMETRE, Sizes, numbers_of
from atleak.readers.sheets.mapping import remember_sheet
from atleak.readers.sheets.measuring_sheet import ReadingsRefused, read_readings

SAMPLE = Path(__file__).parents[4] / "sample_data" / "measuring_sheet_four_speed.xlsx"
TABLE = [
    ["Temperature", "21.5 °C"],
    ["Valve", "Land", "Part", "Diameter [mm]", "Nominal [mm]", "Remark"],
    ["accumulator", 1, "piston", 17.998, 18.0, "scored at 17.99"],
    ["accumulator", 1, "bore", 18.041, 18.05, ""],
    ["", "", "mean", 18.0195, "", ""],
    ["tcc_regulator", 1, "spool", 10.998, 11.0, ""],
    ["tcc_regulator", 1, "sleeve", 11.031, 11.035, ""],
]


def written(*rows):
    return "\n".join(";".join(map(str, row)) for row in rows).encode()


def kinds(sheet: SheetCells):
    return [[None if one is None else one.kind.value for one in row] for row in sheet.meanings]


def cells(data, controller, **options):
    return read_readings(data, controller, name="sheet", with_cells=True, **options).sheets


def without_a_kind(sheets, controller):
    """Return the numbers of the size of a diameter of which nothing is said."""
    sizes = Sizes(controller)
    return [
        (sheet.name, sheet.numbers[row], cell)
        for sheet in sheets
        for row, of_row in enumerate(sheet.rows)
        for cell, meaning in zip(of_row, sheet.meanings[row], strict=True)
        if meaning is None and any(sizes.near(size, (MILLIMETRE, INCH)) for size in numbers_of(cell))
    ]


def test_every_number_of_the_sample_sheet_has_a_kind():
    controller = load_controller("four_speed_2023")
    sheets = cells(SAMPLE, controller)
    counted = Counter(kind for row in kinds(sheets[0]) for kind in row)
    assert without_a_kind(sheets, controller) == []
    assert counted["spool"] == 2 * counted["sleeve"] == 376  # two coordinates each, one diameter
    assert counted["head"] == 3
    assert counted["refused"] == 0


def test_kinds_of_a_sheet_with_a_mean_and_remarks(example):
    (sheet,) = cells(written(*TABLE), example)
    label = ["label"] * 3
    assert kinds(sheet)[:4] == [
        [None, "head"],
        ["heading"] * 6,
        [*label, "spool", "new", "aside"],
        [*label, "sleeve", "new", None],
    ]
    assert kinds(sheet)[4][2:4] == ["aside", "aside"]
    assert sheet.meanings[4][3].why == "mean"
    assert sheet.numbers == [1, 2, 3, 4, 5, 6, 7]
    assert without_a_kind([sheet], example) == []


def test_no_cells_are_kept_unless_asked_for(example):
    assert read_readings(written(*TABLE), example, name="sheet").sheets == ()


def test_a_sheet_in_three_languages(example):
    head = "Ventil;Steg;część;średnica [mm];Bemerkung"
    (sheet,) = cells(f"{head}\naccumulator;1;suwak;17.998;neu\naccumulator;1;bore;18.041;".encode(), example)
    read = [*["label"] * 3]
    assert [row[:4] for row in kinds(sheet)] == [["heading"] * 4, [*read, "spool"], [*read, "sleeve"]]


def test_what_is_crossed_out_or_hidden_is_left_aside_with_the_reason(example, save_book):
    book = openpyxl.Workbook()
    for row in TABLE[1:]:
        book.active.append(row)
    book.active.append(["tcc_regulator", 1, "sleeve", 11.5, 11.035, "rejected"])
    book.active["D3"].font = Font(strike=True)
    book.active.row_dimensions[5].hidden = True
    (sheet,) = cells(save_book(book), example)
    reasons = [row[3] and (row[3].kind.value, str(row[3].why)) for row in sheet.meanings]
    assert reasons[2:] == [
        ("aside", "crossed out"),
        ("aside", "mean"),
        ("aside", "hidden by hand"),
        ("sleeve", ""),
        ("aside", "a remark says 'rejected'"),
    ]


def test_a_sheet_that_a_person_mapped(example):
    sheet = b"N.;Sezione;Cursore;Sede\naccumulator;1;17.998;18.041"
    mapping = {"component": "N.", "plane": "Sezione", "value spool": "Cursore", "value sleeve": "Sede"}
    (read,) = cells(sheet, example, mapping=mapping)
    assert kinds(read)[1] == ["label", "label", "spool", "sleeve"]


def test_rows_and_columns_exchanged_stand_as_in_the_file(example):
    sheet = b"Valve;accumulator;accumulator\nLand;1;1\nPart;piston;bore\nDiameter [mm];17.998;18.041"
    (read,) = cells(sheet, example)
    assert kinds(read)[3] == ["heading", "spool", "sleeve"]


def test_sheets_of_a_workbook_each_as_it_is(example, filled_in):
    spools = "Valve;Land;Part;Diameter [mm]\naccumulator;1;piston;17.998"
    bores = "Valve;Land;Part;Diameter [mm]\naccumulator;1;bore;18.041"
    book = filled_in({"Spools": spools, "Notes": "Nothing;here", "Bores": bores}, "workbook")
    read = cells(book, example)
    assert [(sheet.name, kinds(sheet)[1][3]) for sheet in read] == [("Spools", "spool"), ("Bores", "sleeve")]
    chosen = cells(book, example, sheet="Spools")
    assert chosen[2].meanings[1][3].why == "a sheet that is not read"
    of_one = read_readings(book, example, name="sheet", mapping={"rows Bores": "1"}, with_cells=True)
    assert [one.part for one in of_one.readings] == ["spool"]
    assert of_one.sheets[1].meanings[1][3].why == "said not to count"


def test_a_refused_sheet_shows_its_cells_and_the_problem(example):
    rows = [*TABLE[:3], ["accumulatr", 1, "bore", "18,0x", "", ""]]
    with pytest.raises(ReadingsRefused) as caught:
        cells(written(*rows), example)
    (sheet,) = caught.value.sheets
    refused = [(row, one) for row, each in enumerate(sheet.meanings) for one in each if one and one.kind == "refused"]
    assert [row for row, _ in refused] == [3, 3]
    assert str(refused[0][1].why).startswith("unknown component")
    assert kinds(sheet)[2][3] == "spool"


# --- rows that do not count -------------------------------------------------------------------------------------------


def test_rows_that_count_may_be_several_ranges(example):
    readings = read_readings(written(*TABLE), example, name="sheet", mapping={"rows": "1-3,5-7"}, with_cells=True)
    assert [round(one.diameter * 1e3, 3) for one in readings.readings] == [17.998, 10.998, 11.031]
    assert readings.sheets[0].meanings[3][3].why == "said not to count"
    assert any(each.text == "row 4 left aside, as said" for each in readings.messages)
    for wrong in ("3-", "1-3;5", "5-3", "1-3,"):
        with pytest.raises(ReadingsError, match="no rows of a sheet"):
            read_readings(written(*TABLE), example, name="sheet", mapping={"rows": wrong})


def test_a_merged_label_outlives_the_row_in_which_it_stands(example, save_book):
    book = openpyxl.Workbook()
    for row in (TABLE[1], TABLE[2], ["", "", "", 17.996], TABLE[3]):
        book.active.append(row)
    for column in "ABC":
        book.active.merge_cells(f"{column}2:{column}3")
    readings = read_readings(save_book(book), example, name="sheet", mapping={"rows": "3-4"})
    assert [round(one.diameter * 1e3, 3) for one in readings.readings] == [17.996, 18.041]


def test_rows_alone_are_not_remembered(example, tmp_path):
    readings = read_readings(written(*TABLE), example, name="sheet", mapping={"rows": "1-3"})
    assert dict(readings.columns) == {"rows": "1-3"}
    remember_sheet(tmp_path / "columns.json", readings)
    assert not (tmp_path / "columns.json").exists()
