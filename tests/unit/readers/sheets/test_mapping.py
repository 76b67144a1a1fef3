"""A sheet whose columns a person named: it is read, every guard looks at it, and the next one needs no word."""

from __future__ import annotations

import json
import re
import shlex

import openpyxl
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import InputError, ReadingsError
from atleak.readers.remembered_columns import MapFile, recall_all
from atleak.readers.sheets.mapping import is_role, remember_sheet, with_row_turned
from atleak.readers.sheets.measuring_sheet import ReadingsRefused, forget_sheet, read_readings

CHINESE = """测量记录;;;;
零件;位置;类别;方向;直径
accumulator;1;阀芯;0;17.998
accumulator;1;阀芯;90;17.996
accumulator;1;阀孔;0;18.041
accumulator;1;阀孔;90;18.044"""
OF_CHINESE = {
    "component": "零件",
    "plane": "位置",
    "part": "类别",
    "direction": "方向",
    "value": "直径",
    "spool": "阀芯",
    "sleeve": "阀孔",
}
ESTONIAN = "Nr;Lõige;Siiber;Auk\naccumulator;1;17.998;18.041\ntcc_regulator;1;10.998;11.031"
OF_ESTONIAN = {"component": "Nr", "plane": "Lõige", "value spool": "Siiber", "value sleeve": "Auk"}
PLAIN = "Valve;Land;Part;Diameter [mm]\naccumulator;1;piston;17.998\naccumulator;1;bore;18.041"
DIRECTIONS = [("spool", 0.0), ("spool", 90.0), ("sleeve", 0.0), ("sleeve", 90.0)]
PAIRS = [("accumulator", 17.998), ("accumulator", 18.041), ("tcc_regulator", 10.998), ("tcc_regulator", 11.031)]


def read(written, controller, mapping=None, **options):
    data = written.encode() if isinstance(written, str) else written
    return read_readings(data, controller, name="sheet", mapping=mapping, **options)


def sizes(readings):
    return [(one.component, round(one.diameter * 1e3, 4)) for one in readings.readings]


def codes(readings):
    return {message.code for message in readings.messages}


# --- what is read -----------------------------------------------------------------------------------------------------


def test_headings_in_any_language_are_named(example):
    readings = read(CHINESE, example, OF_CHINESE)
    assert [(one.part, one.direction) for one in readings.readings] == DIRECTIONS
    assert readings.readings[0].place.row == 3
    assert sizes(read(ESTONIAN, example, OF_ESTONIAN)) == PAIRS


@pytest.mark.parametrize("named", ["ABCDE", "12345", [f"column {number}" for number in range(1, 6)]])
def test_a_column_is_named_by_letter_or_number(example, named):
    columns = dict(zip(("component", "plane", "part", "direction", "value"), named, strict=True))
    assert sizes(read(CHINESE, example, {**OF_CHINESE, **columns})) == sizes(read(CHINESE, example, OF_CHINESE))


def test_the_refusal_names_the_options_that_settle_the_sheet(example):
    for sheet in (ESTONIAN, PLAIN.replace("Part", "Pt").replace("Valve", "Vv"), "X;Y;Z;W\n" + PLAIN.partition("\n")[2]):
        with pytest.raises(ReadingsError) as caught:
            read(sheet, example)
        words = shlex.split(re.search(r"--map .*", str(caught.value))[0])
        mapping = dict(word.split("=", 1) for word in words if word != "--map")
        assert sizes(read(sheet, example, mapping))[:2] == PAIRS[:2]
    with pytest.raises(ReadingsError, match="component=N° de pièce"):
        read(PLAIN.replace("Valve", "N° de pièce"), example)
    titled = "Gauge #2, micrometer no. 7\n" + PLAIN
    with pytest.raises(ReadingsError, match=r"is left aside.*--map component=Valve .*--map .value=Diameter"):
        read(titled, example)
    assert sizes(read(titled, example, {"header": "2"})) == PAIRS[:2]


def printed(error):
    words = shlex.split(re.search(r"--map .*", str(error))[0])
    mapping = dict(word.split("=", 1) for word in words if word not in ("--map", "--fill-down"))
    return {"mapping": mapping, "fill_down": "--fill-down" in words}


SUGGESTED = {
    "a deviation of each part": (
        "Nr.;Bund;Nennmaß [mm];Abmaß Kolben [µm];Abmaß Bohrung [µm]\n"
        "accumulator;1;18,0;-2;41\ntcc_regulator;1;11,0;-2;31"
    ),
    "a title that speaks of deviations": (
        "Scostamenti dal nominale\nComponente;Piano;Ø nominale (mm);Scost. cassetto (µm);Scost. foro (µm)\n"
        "accumulator;1;18,0;-2;41\ntcc_regulator;1;11,0;-2;31"
    ),
    "words for the parts by size": (
        "Vlv;Ld;Pt;mm\naccumulator;1;Q;17.998\naccumulator;1;R;18.041\ntcc_regulator;1;Q;10.998\ntcc_regulator;1;R;11.031"
    ),
    "words for the parts by size beside directions": (
        "Vlv;Ld;Pt;X向;Y向\naccumulator;1;Q;17.998;17.999\naccumulator;1;R;18.041;18.043"
    ),
    "columns of nominal sizes, means and the largest": (
        "Vlv;Ld;Pt;N;X;Y;M;L\n"
        "pressure_regulator;1;Q;15;14.997;14.996;14.9965;14.997\n"
        "pressure_regulator;1;R;15.036;15.041;15.043;15.042;15.043\n"
        "pressure_regulator;2;Q;12.5;12.498;12.498;12.498;12.498\n"
        "pressure_regulator;2;R;12.536;12.54;12.541;12.5405;12.541"
    ),
    "whole micrometres": "Vlv;Ld;Q [um];R [um]\naccumulator;1;17998;18041\ntcc_regulator;1;10998;11031",
    "a word where nothing was measured": (
        "Vlv;Ld;Q (mm);R (mm)\npressure_regulator;1;14.997;15.034\npressure_regulator;2;12.498;nejde\n"
        "accumulator;1;nejde;18.041"
    ),
    "an unknown column beside a known one": (
        "Ventil;Bund;Kolben (mm);Aloja (mm)\naccumulator;1;17,998;18,041\ntcc_regulator;1;10,998;11,031"
    ),
    "planes and parts in headings": (
        "Valvola;Descr;Qrst 1;Uvwx 1\naccumulator;x;17,998;18,041\ntcc_regulator;y;10,998;11,031"
    ),
    "a number in the cells": "Nr;Bund;Ø T;Ø A\naccumulator;1;17,998;18,041\ntcc_regulator;1;10,998;11,031",
    "titles over tables with the same headings": (
        "QRST (mm)\nRepère;Portée;Cote\naccumulator;1;17,998\ntcc_regulator;1;10,998\n\n"
        "UVWX (mm)\nRepère;Portée;Cote\naccumulator;1;18,041\ntcc_regulator;1;11,031"
    ),
    "headings in a column": "mm;accumulator-1;tcc_regulator-1\nspool;17.998;10.998\nbore;18.041;11.031",
    "no headings and single spaces": (
        "main, today\naccumulator L1 spool 17.998 bore 18.041\ntcc_regulator L1 spool 10.998 bore 11.031\nmm btw"
    ),
    "only the first of a block is named": (
        "X;Y;Ø T (mm);Ø A (mm)\npressure_regulator;1;14.997;15.034\n;2;12.498;12.535"
    ),
}


@pytest.mark.parametrize("sheet", SUGGESTED.values(), ids=SUGGESTED)
def test_the_options_of_a_refusal_were_tried_on_the_sheet_and_settle_it(example, sheet):
    with pytest.raises(ReadingsError) as caught:
        read(sheet, example)
    readings = read(sheet, example, **printed(caught.value))
    assert len(readings.readings) in (4, 8)
    if ";M;" not in sheet:
        assert not [
            one for one in readings.messages if one.code in ("column_aside", "not_read") and one.level != "info"
        ]
    by_part = {part: [one.diameter for one in readings.readings if one.part == part] for part in ("spool", "sleeve")}
    assert all(spool < sleeve for spool, sleeve in zip(*by_part.values(), strict=True))
    assert caught.value.offer == printed(caught.value)["mapping"]


def test_sizes_beside_deviations_are_not_offered_as_readings(example):
    """A heading that nobody here knows may say that they are those of a new unit."""
    rows = "accumulator;1;spool;18,000;-3\naccumulator;1;bore;18,041;+12\ntcc_regulator;1;spool;11,000;-2"
    with pytest.raises(ReadingsError) as caught:
        read(f"Klep;Vlak;Onderdeel;Algus [mm];Hälve [µm]\n{rows}", example)
    assert not caught.value.offer
    assert "value=" not in str(caught.value)


@pytest.mark.parametrize(
    "rows",
    [
        "accumulator;1;Q;17.998\naccumulator;1;R;18.041\ntcc_regulator;1;Q;11.031\ntcc_regulator;1;R;10.998",
        "accumulator;1;Q;17.998\naccumulator;1;R;17.999\ntcc_regulator;1;Q;10.998\ntcc_regulator;1;R;10.999",
        "accumulator;1;Q;17.998\naccumulator;1;R;19.998\ntcc_regulator;1;Q;10.998\ntcc_regulator;1;R;12.998",
    ],
    ids=["swapped once", "no clearance", "more than a clearance"],
)
def test_words_for_the_parts_are_not_told_by_sizes_that_disagree(example, rows):
    twice = re.sub(r"(\d+\.\d+)", r"\1;\1", rows)
    for sheet in (f"Vlv;Ld;Pt;mm\n{rows}", f"Vlv;Ld;Pt;X;Y\n{twice}"):
        with pytest.raises(ReadingsError) as caught:
            read(sheet, example)
        assert not caught.value.offer
        assert "spool=" not in str(caught.value)


def test_two_columns_that_are_no_pair_are_not_offered_as_spool_and_bore(example):
    with pytest.raises(ReadingsError) as caught:
        read("Vlv;Ld;Q;R\naccumulator;1;18.041;18.043\ntcc_regulator;1;11.031;11.029", example)
    assert not caught.value.offer
    assert "part=COLUMN" in str(caught.value)


def test_the_refusal_says_of_which_part_columns_are_by_their_sizes(example):
    sheet = "Vlv;Ld;Q a;Q b;R a;R b\npressure_regulator;1;14.997;14.998;15.034;15.036"
    with pytest.raises(ReadingsError, match=r'"value spool which 1=Q a" .*"value sleeve which 4=R b"'):
        read(f"{sheet}\npressure_regulator;2;12.498;12.497;12.535;12.536", example)


def test_a_component_in_a_line_of_its_own_is_named_in_the_words_of_the_sheet():
    controller = load_controller("four_speed_2023")
    sheet = "Lõige;Q;R\nKlapp 14;;\n1;9.987;10.014\nKlapp 17;;\n1;11.993;12.031"
    with pytest.raises(ReadingsError) as caught:
        read(sheet, controller)
    assert {"component 14": "Klapp 14", "component 17": "Klapp 17"}.items() <= caught.value.offer.items()
    readings = read(sheet, controller, caught.value.offer)
    assert sizes(readings) == [("14", 9.987), ("14", 10.014), ("17", 11.993), ("17", 12.031)]


def test_own_words_for_parts_reach_the_names_of_sheets(example, filled_in):
    table = "Componente;Plano;Medido\naccumulator;1;{}\ntcc_regulator;1;{}"
    book = filled_in({"Qua": table.format(17.998, 10.998), "Rua": table.format(18.041, 11.031)}, "workbook")
    with pytest.raises(ReadingsError) as caught:
        read(book, example)
    assert {"spool": "Qua", "sleeve": "Rua"}.items() <= caught.value.offer.items()
    assert len(read(book, example, caught.value.offer).readings) == 4


@pytest.mark.parametrize("headings", ["Shift 1 [mm];Shift 2 [mm]", "Spool Anna;Spool Ben"])
def test_whether_columns_are_repeats_or_two_states_only_a_person_knows(example, headings):
    with pytest.raises(ReadingsError) as caught:
        read(f"Valve;Land;{headings}\ntcc_regulator;1;10.998;10.999\naccumulator;1;17.998;17.999", example)
    assert "repeat" not in str(caught.value).partition("--map")[2]


def test_of_several_columns_the_refusal_asks_of_which_they_are(example):
    sheet = "Valve;Part;1;2\npressure_regulator;spool;14.997;12.498\npressure_regulator;sleeve;15.034;12.535"
    with pytest.raises(ReadingsError, match=r'--map "value which 1=1" --map "value which 2=2"'):
        read(sheet, example)
    with pytest.raises(ReadingsError, match="of which diameters"):
        read(sheet, example, {"value which 1": "1"})


def test_what_holds_for_all_rows_is_a_value_behind_an_equals_sign(example):
    rows = "accumulator;1;17.998\ntcc_regulator;1;10.998"
    columns = {"component": "A", "plane": "B", "value": "C", "part": "=piston", "direction": "=90°", "repeat": "=2"}
    readings = read(rows, example, columns)
    assert [(one.part, one.direction) for one in readings.readings] == [("spool", 90.0)] * 2
    columns = {"component": "=accumulator", "plane": "1", "value": "2", "part": "3"}
    of_one = read("1;17.998;piston\n1;18.041;bore", example, columns)
    assert sizes(of_one) == PAIRS[:2]


def test_one_option_is_enough_where_the_other_headings_are_understood(example):
    mean = "No.;Part;Plane;Mean of 10 [mm];s [µm];n\naccumulator;spool;1;17.998;1.1;10\naccumulator;bore;1;18.041;1;10"
    with pytest.raises(ReadingsError, match=r"a mean, is no measurement.*--map .value=Mean of 10 \[mm\]"):
        read(mean, example)
    readings = read(mean, example, {"value": "Mean of 10 [mm]"})
    assert sizes(readings) == PAIRS[:2]
    (told,) = [message.text for message in readings.messages if message.code == "means_as_readings"]
    assert told == "column 'Mean of 10 [mm]' holds means, by its heading: each counts as one reading"


def test_a_sheet_has_its_own_words_for_components_and_lands(example):
    sheet = "Valve;Land;Spool mm;Bore mm\nAccum.;A;17.998;18.041\nTCC reg.;A;10.998;11.034"
    with pytest.raises(ReadingsError) as caught:
        read(sheet, example)
    assert '--map "component …=Accum."' in str(caught.value)
    assert [(one.role, one.value) for one in caught.value.problems][:2] == [
        ("component", "Accum."),
        ("component", "TCC reg."),
    ]
    words = {"component accumulator": "Accum.", "component tcc_regulator": "TCC reg."}
    with pytest.raises(ReadingsError, match=r"--map .land …=A"):
        read(sheet, example, words)
    readings = read(sheet, example, {**words, "land 1": "A"})
    assert sizes(readings)[:2] == PAIRS[:2]
    assert [one.component for one in readings.readings] == ["accumulator"] * 2 + ["tcc_regulator"] * 2
    with pytest.raises(ReadingsError, match="unknown component"):
        read(sheet, example, {**words, "component tcc_regulator": "TCC", "land 1": "A"})


@pytest.mark.parametrize(
    ("words", "refused"),
    [
        ({"land 1": "0"}, "two words of one column are said to be the same"),
        ({"land 1": "0", "land 2": "0"}, "one word is said to be two things"),
        ({"component accumulator": "Acc", "component tcc_regulator": "acc"}, "one word is said to be two things"),
        ({"component pressure_regulator": "main"}, "two words of one column are said to be the same"),
    ],
)
def test_words_that_would_average_two_lands_or_valves_are_refused(example, words, refused):
    sheet = (
        "Valve;Land;Spool mm;Bore mm\npressure_regulator;0;14.987;15.028\npressure_regulator;1;12.486;12.511\n"
        "main;2;12.486;12.511"
    )
    with pytest.raises(ReadingsError, match=refused):
        read(sheet, example, words)


def test_one_word_may_be_a_land_of_another_valve_too(example):
    sheet = "Sheet;1;;\nValve;Land;Spool mm;Bore mm\naccumulator;A;17.998;18.041\ntcc_regulator;1;10.998;11.034"
    assert sizes(read(sheet, example, {"land 1": "A"}))[:2] == PAIRS[:2]


def test_a_deviation_below_nominal_is_not_added(example):
    sheet = "Valve,Land,Nominal (mm),Spool below nominal (µm)\naccumulator,1,18,8"
    with pytest.raises(ReadingsError, match="which way its numbers count"):
        read(sheet, example, {"new": "Nominal (mm)", "deviation spool": "Spool below nominal (µm)"})


def test_what_a_sheet_calls_its_components_is_remembered_with_its_columns(example, tmp_path):
    sheet = "Valve;Land;Spool mm;Bore mm\nAccum.;1;17.998;18.041"
    remember_sheet(tmp_path / "columns.json", read(sheet, example, {"component accumulator": "Accum."}))
    later = read(sheet.replace("17.998", "17.996") + "\nTCC;1;10.998;11.034", example,
                 {"component tcc_regulator": "TCC"}, remembered=tmp_path / "columns.json")  # fmt: skip
    assert [one.component for one in later.readings] == ["accumulator"] * 2 + ["tcc_regulator"] * 2


def test_the_part_may_stand_before_the_number_and_with_words_that_change_nothing(example):
    sheet = "Feature;MEAS\nspool accumulator/1;17.998\nbore accumulator/1;18.041"
    feature = {"component": "Feature", "plane": "Feature", "part": "Feature", "value": "MEAS"}
    assert sizes(read(sheet, example, feature)) == PAIRS[:2]
    sheet = "Valve;Land;Kind;Measured mm\naccumulator;1;Spool diameter;17.998\naccumulator;1;Bore diameter;18.041"
    assert sizes(read(sheet, example, {"part": "Kind"})) == PAIRS[:2]
    with pytest.raises(ReadingsError, match=r"unknown part.*'Bore length'"):
        read(sheet.replace("Bore diameter", "Bore length"), example, {"part": "Kind"})


def test_deviations_are_from_a_nominal_size_in_the_unit_of_its_heading(example):
    sheet = "Valve,Land,Nominal (in),Spool dev. (in)\naccumulator,1,0.70866,-0.00007"
    columns = {"new": "Nominal (in)", "deviation spool": "Spool dev. (in)"}
    (reading,) = read(sheet, example, columns).readings
    assert round(reading.diameter / 25.4e-3, 6) == 0.70859


def test_the_number_of_a_unit_is_no_unit_of_length(example):
    sheet = "Unit SN,Valve,Land,Spool mm,Bore mm\nA1107,accumulator,1,17.998,18.041\nA1193,accumulator,1,17.99,18.04"
    with pytest.raises(ReadingsError, match='--where "Unit SN=A1107"'):
        read(sheet, example)
    assert sizes(read(sheet, example, where={"Unit SN": "A1107"})) == PAIRS[:2]


def test_several_readings_in_a_cell_are_asked_about_and_count_each(example):
    sheet = "Valve;Plane;Part;Diameter [mm]\naccumulator;1;spool;17.998 / 17.997 / 17.999\naccumulator;1;bore;18.041"
    with pytest.raises(ReadingsError, match=r"each of them is a reading.*--map .value=Diameter \[mm\]"):
        read(sheet, example)
    readings = read(sheet, example, {"value": "Diameter [mm]"})
    assert [(one.part, one.repeat, round(one.diameter * 1e3, 4)) for one in readings.readings] == [
        ("spool", 1, 17.998),
        ("spool", 2, 17.997),
        ("spool", 3, 17.999),
        ("sleeve", 1, 18.041),
    ]
    assert {one.place.row for one in readings.readings} == {2, 3}
    assert "several_in_a_cell" in [message.code for message in readings.messages]


def test_what_stands_for_no_reading_and_numbers_in_brackets(example):
    sheet = PLAIN + "\ntcc_regulator;1;spool;#N/A\ntcc_regulator;1;sleeve;(11.031)"
    with pytest.raises(ReadingsError, match=r"missing=#N/A"):
        read(sheet, example)
    readings = read(sheet, example, {"missing": "?|#N/A"})
    assert sizes(readings) == [*PAIRS[:2], PAIRS[3]]
    assert {"numbers_marked", "rows_not_measured"} <= codes(readings)


def test_an_error_of_a_formula_is_no_reading_only_where_that_is_said(example, filled_in, tmp_path):
    book = openpyxl.load_workbook(__import__("io").BytesIO(filled_in(PLAIN, "workbook")))
    book.active.append(["tcc_regulator", 1, "spool", "#N/A"])
    book.active["D4"].data_type = "e"
    book.save(tmp_path / "sheet.xlsx")
    with pytest.raises(ReadingsError):
        read_readings(tmp_path / "sheet.xlsx", example)
    assert sizes(read_readings(tmp_path / "sheet.xlsx", example, mapping={"missing": "#N/A"})) == PAIRS[:2]


def test_rows_and_headings_are_counted_as_the_sheet_counts_them(example):
    two = PLAIN + "\n" + PLAIN.partition("\n")[2].replace("17.998", "17.990").replace("18.041", "18.050")
    assert sizes(read(two, example, {"rows": "2-3"})) == PAIRS[:2]
    assert sizes(read(two, example, {"header": "1", "rows": "4-5"})) == [("accumulator", 17.99), ("accumulator", 18.05)]
    levels = "Typ;Ort;Innen;Innen\n;;0 Grad;90 Grad\naccumulator;1;18.041;18.044"
    columns = {"component": "A", "plane": "B", "value sleeve 0°": "C", "value sleeve 90°": "D", "header": "1-2"}
    assert [one.direction for one in read(levels, example, columns).readings] == [0.0, 90.0]


def test_a_row_counts_again_also_where_the_rows_of_all_sheets_were_said(example, filled_in):
    book = filled_in({"S": PLAIN}, "workbook")
    sheet = read(book, example, with_cells=True).sheets[0]
    assert with_row_turned({"rows": "1-2"}, sheet, 3) == {"rows": "1-2", "rows S": "1-3"}
    assert with_row_turned({"rows S": "1-2"}, sheet, 3) == {}
    assert sizes(read(book, example, {"rows": "1-2", "rows S": "1-3"})) == PAIRS[:2]


def test_rows_none_says_that_it_leaves_all_rows_out(example):
    with pytest.raises(ReadingsError, match="no reading is left: rows 2–3 left aside, as said"):
        read(PLAIN, example, {"rows": "none"})


def test_headings_that_run_down_a_column(example):
    across = "Sheet of today;;\n零件;accumulator;accumulator\n类别;spool;sleeve\n直径;17.998;18.041"
    columns = {"header": "A", "component": "零件", "part": "类别", "value": "直径"}
    assert sizes(read(across, example, columns)) == PAIRS[:2]


def test_a_sheet_of_a_workbook_is_found_by_its_columns(example, filled_in):
    book = filled_in({"Notes": "Nothing;here", "Messung": CHINESE.replace("测量记录;;;;\n", "")}, "workbook")
    readings = read(book, example, OF_CHINESE)
    assert readings.sheet == "Messung"
    with pytest.raises(ReadingsError, match="零件"):
        read(book, example, OF_CHINESE, sheet="Notes")


def test_several_things_in_one_cell_are_taken_apart(example):
    sheet = "Spot;Diameter [mm]\naccumulator/1 piston;17.998\naccumulator/1 bore;18.041\nball 7;7.0"
    columns = dict.fromkeys(("component", "plane", "part"), "Spot")
    readings = read(sheet, example, columns)
    assert sizes(readings) == PAIRS[:2]
    assert any(message.code == "notes_left_aside" and "ball 7" in message.text for message in readings.messages)


@pytest.mark.parametrize(
    ("headings", "spool", "bore", "named", "read_as"),
    [
        (
            "Deviation 1 [µm];Deviation 2 [µm]",
            "-2;-3",
            "32;33",
            "deviation repeat {}",
            [10.998, 10.997, 11.032, 11.033],
        ),
        ("Abw. (0°) [1/100 mm];Abw. (90°) [1/100 mm]", "-0,2;-0,3", "3,2;3,3", "deviation", None),
        ("Deviation in 1/1000 mm;Upper dev [µm]", "-2;8", "32;45", "deviation", [10.998, 11.032]),
    ],
)
def test_deviations_from_a_nominal_diameter_are_named(example, headings, spool, bore, named, read_as):
    lines = (
        f"Valve;Land;Part;Nominal [mm];{headings}",
        f"tcc_regulator;1;spool;11.0;{spool}",
        f"tcc_regulator;1;bore;11.0;{bore}",
    )
    first, second = headings.split(";")
    columns = {"new": "Nominal [mm]", named.format(1): first}
    columns |= {"deviation repeat 2": second} if "{}" in named else {}
    if read_as is None:
        columns = {"new": "Nominal [mm]", "deviation 0°": first, "deviation 90°": second}
        read_as = [10.998, 10.997, 11.032, 11.033]
    readings = read("\n".join(lines), example, columns)
    assert [round(one.diameter * 1e3, 6) for one in readings.readings] == read_as
    assert "diameters_of_deviations" in codes(readings)
    assert readings.readings[0].place.column == first


def test_deviations_without_a_unit_or_from_nothing_are_refused(example):
    sheet = "Valve;Land;Part;Nominal [mm];Deviation [0.01 mm]\ntcc_regulator;1;spool;11.0;-2"
    with pytest.raises(ReadingsError, match="in which unit the deviations are"):
        read(sheet, example, {"new": "Nominal [mm]", "deviation": "Deviation [0.01 mm]"})
    with pytest.raises(ReadingsError, match="what the deviations are from"):
        read(sheet, example, {"deviation": "Deviation [0.01 mm]"})


# --- what every guard says of it --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "options", "word"),
    [
        ({"value spool": "Auk", "value sleeve": "Siiber"}, {}, "swapped"),
        ({}, {"unit": "inch"}, "a wrong unit"),
        ({"component": "Lõige", "plane": "Nr"}, {}, "unknown component"),
        ({"value sleeve": "Siiber"}, {}, "one column is named for several"),
        ({"value spool": "Lõige"}, {}, "."),
    ],
)
def test_a_wrong_column_is_refused_as_a_wrong_sheet_is(example, changed, options, word):
    with pytest.raises(ReadingsError, match=word):
        read(ESTONIAN, example, {**OF_ESTONIAN, **changed}, **options)


def test_a_radius_and_a_wrong_clearance_are_refused(example):
    radii = ESTONIAN.replace("17.998;18.041", "8.999;9.0205").replace("10.998;11.031", "5.499;5.5155")
    with pytest.raises(ReadingsRefused, match="a radius"):
        read(radii, example, OF_ESTONIAN, unit="mm")
    with pytest.raises(ReadingsRefused, match="clearance"):
        read(ESTONIAN.replace("18.041", "19.441"), example, OF_ESTONIAN)


def test_states_are_asked_about_and_contradictions_told(example):
    states = "零件;类别;日期;直径\naccumulator;spool;2024-05-01;17.998\naccumulator;spool;2025-05-01;17.990"
    columns = {"component": "零件", "part": "类别", "value": "直径"}
    with pytest.raises(ReadingsError, match="averaged as repeats"):
        read(states, example, columns)
    where = {"日期": "2024-05-01"}
    assert sizes(read(states, example, columns, where=where)) == PAIRS[:1]
    clearances = "Nr;Lõige;Siiber;Auk;Clearance D-d [µm]\naccumulator;1;17.998;18.041;63"
    assert "clearance_disagrees" in codes(read(clearances, example, OF_ESTONIAN))


def test_no_number_of_the_size_of_a_diameter_is_lost(example):
    beside = ESTONIAN.replace("Auk", "Auk;Muu").replace("18.041", "18.041;17.871").replace("11.031", "11.031;10.9")
    readings = read(beside, example, OF_ESTONIAN)
    assert any(message.level == "warning" and "17.871" in message.text for message in readings.messages)
    slipped = ESTONIAN.replace(";18.041", ";;18.041").replace("Auk", "Auk;Muu")
    with pytest.raises(ReadingsError, match=r"18\.041"):
        read(slipped, example, OF_ESTONIAN)


def test_rows_of_means_and_rejected_rows_stay_out(example):
    sheet = "零件;类别;Repeat;直径;备注\n" + "\n".join(
        f"accumulator;spool;{repeat};{size};{remark}"
        for repeat, size, remark in ((1, 17.998, ""), (2, 17.996, ""), (3, 17.9, "rejected"), ("mean", 17.997, ""))
    )
    columns = {"component": "零件", "part": "类别", "value": "直径"}
    assert sizes(read(sheet, example, columns)) == [("accumulator", 17.998), ("accumulator", 17.996)]


def test_a_decimal_comma_that_ends_a_cell_is_told_without_headings_too(example):
    columns = {"component": "A", "plane": "B", "part": "C", "value": "D"}
    with pytest.raises(ReadingsError, match="decimal comma"):
        read("accumulator,1,spool,17,998\naccumulator,1,sleeve,18,041", example, columns)


@pytest.mark.parametrize(
    ("mapping", "word"),
    [
        ({"pressure": "A"}, "main_pressure.*"),
        ({"value": "Durchmesser"}, "no column is headed 'Durchmesser'.*did you mean 'Diameter \\[mm\\]'|no column"),
        ({"value": "Z"}, "no column is headed 'Z'"),
        ({"value largest": "D"}, "of which diameters"),
        ({"part": "=ball"}, "not understood as part"),
        ({"component": "=valve 99"}, "unknown component"),
        ({"rows": "9-2"}, "no rows"),
        ({"header": "x"}, "no rows"),
    ],
)
def test_a_mapping_that_cannot_be_is_refused(example, mapping, word):
    with pytest.raises(InputError, match=word):
        read(PLAIN, example, mapping)


def test_a_heading_that_stands_twice_is_named_by_its_letter(example):
    sheet = "零件;类别;直径;直径\naccumulator;spool;1;17.998\naccumulator;sleeve;1;18.041"
    columns = {"component": "零件", "part": "类别", "value": "直径"}
    with pytest.raises(ReadingsError, match=r"C, D"):
        read(sheet, example, columns)
    assert sizes(read(sheet, example, {**columns, "value": "D"})) == PAIRS[:2]


def test_roles_and_quantities_have_no_name_in_common():
    from atleak.measurements.road_test import QUANTITIES

    assert not [name for name in QUANTITIES if is_role(name)]
    assert all(map(is_role, ("component", "value", "value spool 0°", "new", "rows")))
    assert not any(map(is_role, ("values", "components", "diameter 2", "")))


# --- remembered and shared --------------------------------------------------------------------------------------------


def test_the_next_sheet_with_these_headings_needs_no_word(example, tmp_path):
    store = tmp_path / "columns.json"
    first = read(CHINESE, example, OF_CHINESE)
    remember_sheet(store, first, "mm")
    (kept,) = recall_all(store).values()
    another = "另一行;;;;\n\n" + CHINESE.replace("17.998", "17.997")
    again = read(another, example, remembered=store)
    note = again.messages[0]
    assert note.code == "remembered"
    assert kept.when[:10] in note.text
    assert "--forget" in note.text
    assert sizes(again)[0] == ("accumulator", 17.997)
    assert not again.unit_assumed  # the unit that was stated
    assert read(another, example, dict(again.columns), unit="mm").readings == again.readings  # a job reads it elsewhere
    forget_sheet(another.encode(), store)
    assert recall_all(store) == {}


def test_what_is_remembered_is_looked_at_by_every_guard(example, tmp_path):
    store = tmp_path / "columns.json"
    remember_sheet(store, read(ESTONIAN, example, OF_ESTONIAN))
    swapped = "Nr;Lõige;Siiber;Auk\naccumulator;1;18.041;17.998\ntcc_regulator;1;11.031;10.998"
    with pytest.raises(ReadingsRefused) as caught:
        read(swapped, example, remembered=store)
    assert "swapped" in str(caught.value)
    assert "settled on" in str(caught.value)
    now = {"value spool": "Auk", "value sleeve": "Siiber"}  # what is said now goes first
    assert len(read(swapped, example, now, remembered=store).readings) == 4


def test_other_headings_and_logs_recall_nothing(example, tmp_path):
    store = tmp_path / "columns.json"
    remember_sheet(store, read(ESTONIAN, example, OF_ESTONIAN))
    assert "remembered" not in codes(read(PLAIN, example, remembered=store))
    from atleak.readers.logs import understand

    log = "Nr;Lõige;Siiber;Auk\n" + "\n".join(f"{n};{700 + n};{n};1" for n in range(9))
    assert "remembered" not in {message.code for message in understand(log.encode(), remembered=store).messages}


def test_a_mapping_is_written_and_read_as_it_was(tmp_path):
    mapping = {**OF_CHINESE, "header": "2-3", "missing": "#N/A|-", "repeat": "", "value sleeve": "直径"}
    file = MapFile(mapping, {"value": "mm"}, "表1")
    path = tmp_path / "map.json"
    path.write_text(file.text(), encoding="utf-8")
    assert MapFile.read(path) == MapFile({**mapping}, {"value": "mm"}, "表1")
    content = json.loads(file.text())
    assert content["dialect"] == {"header": True, "headerRows": [2, 3], "sheetName": "表1"}
    assert content["schema"]["missingValues"] == ["", "#N/A", "-"]
    assert {"name": "零件", "type": "any", "atleak:roles": ["component"]} in content["schema"]["fields"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": {"fields": [1]}}', "\x00", "[" * 100_000])
def test_a_file_that_is_no_mapping_is_refused(tmp_path, text):
    path = tmp_path / "map.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"map\.json"):
        MapFile.read(path)
    with pytest.raises(InputError, match="cannot be read"):
        MapFile.read(tmp_path / "none.json")
