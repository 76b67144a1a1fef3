"""Two states of a valve body are never averaged as repeats."""

from __future__ import annotations

import datetime

import pytest

from atleak.common.errors import ReadingsError
from atleak.readers.sheets.measuring_sheet import read_readings

HEADINGS = {
    "en": ("Valve", "Land", "Part", "Diameter [mm]"),
    "de": ("Ventil", "Steg", "Teil", "Durchmesser [mm]"),
    "pl": ("Zawór", "Land", "Część", "Średnica [mm]"),
}
PARTS = {"en": ("piston", "bore"), "de": ("Kolben", "Bohrung"), "pl": ("tłok", "otwór")}


def sheet(*lines):
    return "\n".join(";".join(map(str, line)) if not isinstance(line, str) else line for line in lines).encode()


def sizes(readings):
    return [
        (each.component, each.part, each.direction, each.repeat, round(each.diameter * 1e3, 6))
        for each in readings.readings
    ]


def said(readings, code):
    return [message.text for message in readings.messages if message.code == code]


def refusal(data, controller, **options):
    with pytest.raises(ReadingsError) as caught:
        read_readings(data, controller, name="sheet.csv", **options)
    return caught.value


def test_two_readings(controller):
    """Two rows of one station are repeats where no column separates them, as in the sheets below."""
    readings = read_readings(
        sheet(HEADINGS["en"], "accumulator;1;piston;17.998", "accumulator;1;piston;17.996"), controller
    )
    assert sizes(readings) == [
        ("accumulator", "spool", None, 1, 17.998),
        ("accumulator", "spool", None, 2, 17.996),
    ]


# --- numbers in headings ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("language", "one", "other"),
    [
        ("en", "Diameter 50000 km [mm]", "Diameter 90000 km [mm]"),
        ("en", "Diameter 50 h [mm]", "Diameter 90 h [mm]"),
        ("en", "Measurement 1 km [mm]", "Measurement 2 km [mm]"),
        ("en", "Ø at 20°C [mm]", "Ø at 80 °C [mm]"),
        ("en", "Diameter 2023 [mm]", "Diameter 2025 [mm]"),
        ("en", "Measurement 2023 [mm]", "Measurement 2025 [mm]"),
        ("en", "Diameter 05/2024 [mm]", "Diameter 11/2024 [mm]"),
        ("en", "Diameter vehicle 1 [mm]", "Diameter vehicle 2 [mm]"),
        ("en", "Diameter unit 1 [mm]", "Diameter unit 2 [mm]"),
        ("en", "Sample 1 diameter [mm]", "Sample 2 diameter [mm]"),
        ("en", "Diameter 20 [mm]", "Diameter 40 [mm]"),
        ("en", "Diameter before [mm]", "Diameter after [mm]"),
        ("de", "Durchmesser 50000 km [mm]", "Durchmesser 90000 km [mm]"),
        ("de", "Durchmesser Fahrzeug 1 [mm]", "Durchmesser Fahrzeug 2 [mm]"),
        ("pl", "Średnica 50 tys. km [mm]", "Średnica 90 tys. km [mm]"),
        ("pl", "Średnica pojazd 1 [mm]", "Średnica pojazd 2 [mm]"),
    ],
)
def test_columns_of_two_states_are_refused_by_name(controller, language, one, other):
    headings = (*HEADINGS[language][:3], one, other)
    error = refusal(sheet(headings, ("accumulator", 1, PARTS[language][0], 17.998, 17.996)), controller)
    assert error.problem == f"two columns are read as the same diameter: {one!r} and {other!r}"
    assert "one state" in error.expected


@pytest.mark.parametrize(
    ("language", "headings"),
    [
        ("en", ("Diameter 1 [mm]", "Diameter 2 [mm]")),
        ("en", ("Ø 1 [mm]", "Ø 2 [mm]")),
        ("en", ("1st measurement [mm]", "2nd measurement [mm]")),
        ("en", ("Reading no. 1 [mm]", "Reading no. 2 [mm]")),
        ("de", ("Messung 1 [mm]", "Messung 2 [mm]")),
        ("pl", ("Pomiar 1 [mm]", "Pomiar 2 [mm]")),
        ("pl", ("Pomiar I [mm]", "Pomiar II [mm]")),
    ],
)
def test_columns_of_repeats_are_read(controller, language, headings):
    data = sheet((*HEADINGS[language][:3], *headings), ("accumulator", 1, PARTS[language][0], 17.998, 17.996))
    assert [reading[3:] for reading in sizes(read_readings(data, controller))] == [(1, 17.998), (2, 17.996)]


def test_one_column_of_a_state_is_the_diameter(controller):
    data = sheet("Valve;Land;Part;Diameter 90000 km [mm]", "accumulator;1;piston;17.998")
    assert sizes(read_readings(data, controller)) == [("accumulator", "spool", None, 1, 17.998)]


def test_numbered_columns_that_say_something_else_too(controller):
    data = sheet("Valve;Land;Part;Diameter 1 before [mm];Diameter 2 after [mm]", "accumulator;1;piston;17.998;17.996")
    error = refusal(data, controller)
    assert "'Diameter 1 before [mm]' and 'Diameter 2 after [mm]'" in error.problem
    assert error.value == "after, before"


# --- a column that tells states apart ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("language", "heading", "one", "other"),
    [
        ("en", "Inspection", "May", "November"),
        ("en", "Date", "2025-05-03", "2025-11-04"),
        ("en", "Mileage [km]", "50000", "90000"),
        ("en", "Serial No.", "4711", "4712"),
        ("en", "Sample", "1", "2"),
        ("en", "", "old", "new"),
        ("de", "Datum", "03.05.2025", "04.11.2025"),
        ("de", "Fahrzeug", "A", "B"),
        ("de", "Messung", "Mai", "November"),
        ("pl", "Przebieg", "50000", "90000"),
        ("pl", "Przegląd", "maj", "listopad"),
    ],
)
def test_a_column_nobody_reads_raises_the_question(controller, language, heading, one, other):
    piston, bore = PARTS[language]
    data = sheet(
        (heading, *HEADINGS[language]),
        (one, "accumulator", 1, piston, 17.998),
        (one, "accumulator", 1, bore, 18.041),
        (other, "accumulator", 1, piston, 17.996),
        (other, "accumulator", 1, bore, 18.044),
    )
    error = refusal(data, controller)
    assert "tells states apart that would be averaged as repeats" in error.problem
    assert "rows 2, 4" in error.problem
    assert error.value == f"{one}, {other}"
    assert "--where" in error.expected
    if heading:
        readings = read_readings(data, controller, where={heading: other})
        assert [reading[4] for reading in sizes(readings)] == [17.996, 18.044]
        assert said(readings, "rows_left_out") == [f"rows 2–3 left aside: read were those where {heading} is {other!r}"]


def test_one_station_is_enough(controller):
    data = sheet(
        ("Inspection", *HEADINGS["en"]), "May;accumulator;1;piston;17.998", "November;accumulator;1;piston;17.996"
    )
    error = refusal(data, controller)
    assert (error.place.row, error.place.column) == (1, "Inspection")
    assert "--where Inspection=May" in error.expected


def test_dates_of_a_workbook(controller, make_workbook):
    day = datetime.datetime(2025, 5, 3, 10, 31)
    rows = [
        ("Date", *HEADINGS["en"]),
        (day, "accumulator", 1, "piston", 17.998),
        (day.replace(minute=35), "accumulator", 1, "piston", 17.997),
    ]
    assert len(read_readings(make_workbook(rows), controller).readings) == 2
    rows.append((day.replace(month=11), "accumulator", 1, "piston", 17.990))
    assert refusal(make_workbook(rows), controller).value == "2025-05-03, 2025-11-03"
    for written in ("2025-11-03", "03.11.2025"):
        readings = read_readings(make_workbook(rows), controller, where={"date": written})
        assert [reading[4] for reading in sizes(readings)] == [17.990]


@pytest.mark.parametrize(
    ("heading", "values"),
    [
        ("Operator", ("AB", "CD", "AB", "CD")),
        ("Prüfer", ("AB", "CD", "AB", "CD")),
        ("Time", ("10:31", "10:32", "10:34", "10:35")),
        ("Remark", ("ok", "a scratch", "", "ok")),
        ("Remark", ("1st", "2nd", "1st", "2nd")),
        ("No.", (1, 2, 3, 4)),
        ("Temperature [°C]", (20.1, 20.2, 20.1, 20.3)),
    ],
)
def test_columns_that_tell_only_repeats_apart(controller, heading, values):
    rows = [
        ("accumulator", 1, "piston", 17.998),
        ("accumulator", 1, "piston", 17.996),
        ("accumulator", 1, "bore", 18.041),
        ("accumulator", 1, "bore", 18.043),
    ]
    data = sheet((*HEADINGS["en"], heading), *[(*row, value) for row, value in zip(rows, values, strict=True)])
    assert [reading[4] for reading in sizes(read_readings(data, controller))] == [17.998, 17.996, 18.041, 18.043]


def test_repeats_by_their_number_end_the_question_with_a_word(controller):
    rows = ["May;accumulator;1;piston;1;17.998", "November;accumulator;1;piston;2;17.996"]
    readings = read_readings(sheet("Inspection;Valve;Land;Part;Repeat;Diameter [mm]", *rows), controller)
    assert len(readings.readings) == 2
    assert "(May, November)" in said(readings, "repeats_of_several_states")[0]


def test_the_same_repeat_in_two_states_names_the_column(controller):
    rows = [f"{when};accumulator;1;piston;{repeat};17.998" for when in ("May", "November") for repeat in (1, 2)]
    error = refusal(sheet("Inspection;Valve;Land;Part;Repeat;Diameter [mm]", *rows), controller)
    assert "--where Inspection=May" in error.expected


@pytest.mark.parametrize(
    ("where", "problem", "expected"),
    [
        ({"Inspection": "June"}, "no row has 'June' there", "one of May, November"),
        ({"Insp": "May"}, "no column is headed 'Insp'", "one of Inspection, Valve, Land, Part, Diameter [mm]"),
    ],
)
def test_rows_told_that_are_not_there(controller, where, problem, expected):
    data = sheet(
        ("Inspection", *HEADINGS["en"]), "May;accumulator;1;piston;17.998", "November;accumulator;1;piston;17.996"
    )
    error = refusal(data, controller, where=where)
    assert (error.problem, error.expected) == (problem, expected)


# --- blocks -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("language", "one", "other"),
    [("en", "May", "November"), ("de", "vorher", "nachher"), ("pl", "przed", "po naprawie")],
)
def test_stations_that_return_under_another_title(controller, language, one, other):
    piston, bore = PARTS[language]
    data = sheet(
        HEADINGS[language],
        f"{one};;;",
        f"accumulator;1;{piston};17.998",
        f"accumulator;1;{bore};18.041",
        f"{other};;;",
        f"accumulator;1;{piston};17.996",
        f"accumulator;1;{bore};18.044",
    )
    error = refusal(data, controller)
    assert "stands in row 3 and returns in row 6" in error.problem
    assert error.value == other


def test_one_station_alone_under_two_titles(controller):
    data = sheet(HEADINGS["en"], "before;;;", "accumulator;1;piston;17.998", "after;;;", "accumulator;1;piston;17.996")
    assert refusal(data, controller).value == "after"


@pytest.mark.parametrize("title", ["", "90000 km"])
def test_stations_that_return_under_headings_of_their_own(controller, title):
    block = [HEADINGS["en"], "accumulator;1;piston;17.998", "accumulator;1;bore;18.041", ""]
    error = refusal(sheet("50000 km" if title else "", *block, title, *block), controller)
    assert "repeats, or two states?" in error.problem


@pytest.mark.parametrize(
    ("language", "titles"),
    [
        ("en", ("1st measurement", "2nd measurement")),
        ("de", ("Messung 1", "Messung 2")),
        ("pl", ("Pomiar 1", "Pomiar 2")),
    ],
)
@pytest.mark.parametrize("again", [False, True])
def test_titles_that_number_the_repeats(controller, language, titles, again):
    piston, bore = PARTS[language]
    block = [f"accumulator;1;{piston};17.998", f"accumulator;1;{bore};18.041"]
    headings = HEADINGS[language]
    lines = (
        [titles[0], headings, *block, "", titles[1], headings, *block]
        if again
        else [headings, titles[0], *block, titles[1], *block]
    )
    assert [reading[3] for reading in sizes(read_readings(sheet(*lines), controller))] == [1, 1, 2, 2]


def test_headings_of_the_next_page_between_two_repeats_are_asked_about(controller, refused):
    data = sheet(
        HEADINGS["en"],
        "accumulator;1;bore;18.041",
        HEADINGS["en"],
        "accumulator;1;bore;18.042",
        "tcc_regulator;1;spool;10.998",
    )
    assert "repeats, or two states?" in str(refused(data))


def test_a_block_pasted_twice_is_told(controller):
    block = ["accumulator;1;piston;17.998", "accumulator;1;bore;18.041"]
    readings = read_readings(sheet(HEADINGS["en"], *block, *block), controller)
    assert len(readings.readings) == 4
    assert said(readings, "block_repeated")[0].startswith(
        "rows 4–5 hold the same readings in the same order as rows 2–3"
    )


@pytest.mark.parametrize(("parts", "told"), [(("piston",), False), (("piston", "bore"), True)])
def test_one_part_that_measures_the_same_in_its_second_round_is_not_called_pasted(controller, parts, told):
    rounds = [
        f"accumulator;1;{part};{angle};{repeat};{18.041 if part == 'bore' else 17.998}"
        for repeat in (1, 2)
        for part in parts
        for angle in (0, 90)
    ]
    readings = read_readings(sheet("component;plane;part;direction;repeat;diameter [mm]", *rounds), controller)
    assert bool(said(readings, "block_repeated")) == told


def test_stations_that_merely_return_are_told(controller):
    data = sheet(
        HEADINGS["en"],
        "accumulator;1;piston;17.998",
        "accumulator;1;bore;18.041",
        "accumulator;1;piston;17.996",
        "accumulator;1;bore;18.042",
    )
    readings = read_readings(data, controller)
    assert said(readings, "block_repeated") == []
    assert said(readings, "rows_as_repeats")[0].endswith(
        "stands in row 2 and again in row 4, and so does 1 more: counted as repeats"
    )


def test_rows_are_chosen_in_the_table_that_has_the_column(controller):
    data = sheet(
        ("Inspection", *HEADINGS["en"]),
        "May;accumulator;1;piston;17.998",
        "November;accumulator;1;piston;17.996",
        "",
        "Valve;Land;Part;Diameter [mm]",
        "accumulator;1;bore;18.041",
    )
    readings = read_readings(data, controller, where={"Inspection": "May"})
    assert [reading[4] for reading in sizes(readings)] == [17.998, 18.041]


def test_rows_that_return_behind_an_empty_row_are_a_warning(controller):
    rows = ["accumulator;1;piston;17.998", "accumulator;1;bore;18.041"]
    for lines, level in ((rows + rows, "info"), ([*rows, "", *rows], "warning")):
        readings = read_readings(sheet(HEADINGS["en"], *lines), controller)
        assert len(readings.readings) == 4
        assert [message.level for message in readings.messages if message.code == "rows_as_repeats"] == [level]


@pytest.mark.parametrize(
    ("heading", "rows", "unit", "level"),
    [
        ("Nr", ("17.998", "17.996"), "mm", "info"),
        ("Nr", ("17.998", "17.990"), "mm", "warning"),
        ("#", ("17998", "17990"), "µm", "warning"),
        ("Technician", ("17.998", "17.994"), "mm", "warning"),
    ],
)
def test_rows_that_return_with_other_values_are_a_warning(controller, heading, rows, unit, level):
    bore = "18.041" if unit == "mm" else "18041"
    lines = [
        line
        for number, piston in enumerate(rows, 1)
        for line in (f"{number};accumulator;1;piston;{piston}", f"{number};accumulator;1;bore;{bore}")
    ]
    found = read_readings(sheet((heading, "Valve", "Land", "Part", f"Diameter [{unit}]"), *lines), controller)
    messages = [message for message in found.messages if message.code == "rows_as_repeats"]
    assert [message.level for message in messages] == [level]
    assert ("µm apart: counted as repeats" in messages[0].text) == (level == "warning")


@pytest.mark.parametrize("heading", ["Box", "Kiste", "Pudełko", "Tray"])
def test_a_column_that_counts_things_tells_states_apart(controller, heading):
    block = ["accumulator;1;piston;17.998", "accumulator;1;bore;18.041"]
    lines = [f"{number};{line}" for number in (1, 2) for line in block]
    with pytest.raises(ReadingsError, match=f"column '{heading}' tells states apart"):
        read_readings(sheet((heading, *HEADINGS["en"]), *lines), controller)
