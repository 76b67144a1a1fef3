"""Sheets of hands that nobody has seen: read as they are, or asked about with options that settle them."""

from __future__ import annotations

import re

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.readers.sheets.measuring_sheet import read_readings

OPTION = re.compile(r'--map (?:"([^"=]+)=([^"]*)"|([^\s=]+)=(\S+))')


@pytest.fixture(scope="module")
def controller():
    return load_controller("four_speed_2023")


def sizes(controller, sheet, **said):
    """Return diameters in mm by component, plane, part and direction."""
    readings = read_readings(sheet.encode(), controller, name="sheet.csv", **said)
    return [
        (one.component, one.plane, one.part, one.direction, round(one.diameter * 1e3, 4)) for one in readings.readings
    ]


def told(controller, sheet):
    """Return what is printed that settles a sheet."""
    with pytest.raises(ReadingsError) as caught:
        read_readings(sheet.encode(), controller, name="sheet.csv")
    text = str(caught.value).partition("which column is what:")[2].splitlines()[0]
    return {role or name: word or column for role, word, name, column in OPTION.findall(text)}


PAIRS = [
    ("6", "1", "spool", 9.937),
    ("6", "1", "sleeve", 9.990),
    ("6", "2", "spool", 9.940),
    ("6", "2", "sleeve", 9.994),
]
PAIRS += [("8", "1", "spool", 9.998), ("8", "1", "sleeve", 10.052), ("8", "2", "spool", 11.997)]
PAIRS += [("8", "2", "sleeve", 12.061), ("12'", "1", "spool", 12.998), ("12'", "1", "sleeve", 13.064)]
UNDIRECTED = [(*place, None, size) for *place, size in PAIRS]


def long(heading, word, ditto=None):
    lines, before = [heading], ["", ""]
    for component, plane, part, size in PAIRS:
        labels = [component, plane]
        given = [ditto if ditto and labels[: at + 1] == before[: at + 1] else label for at, label in enumerate(labels)]
        lines.append(";".join([*given, word(part, plane), f"{size:.3f}"]))
        before = labels
    return "\n".join(lines)


@pytest.mark.parametrize("mark", ["〃", "—〃—", "„", "dto.", "j.w."])
def test_a_ditto_mark_says_what_stands_above(controller, mark):
    sheet = long("Valve;Land;Part;Diameter [mm]", lambda part, _: part, mark)
    assert sizes(controller, sheet) == UNDIRECTED


def test_a_ditto_mark_is_no_diameter(controller):
    sheet = "Valve;Land;Part;Diameter [mm]\n12';1;spool;12.998\n12';1;sleeve;〃"
    with pytest.raises(ReadingsError, match="not a number"):
        read_readings(sheet.encode(), controller, name="sheet.csv")


@pytest.mark.parametrize("written", ["12,998 scored", "12,998 (scored on one side)", "12,998 mm, riefig", "12,998?"])
def test_words_beside_a_number_are_told_and_the_number_counts(controller, written):
    sheet = f"Valve;Land;Part;Diameter [mm]\n12';1;spool;{written}\n12';1;sleeve;13,064"
    readings = read_readings(sheet.encode(), controller, name="sheet.csv")
    assert [round(one.diameter * 1e3, 3) for one in readings.readings] == [12.998, 13.064]
    assert any(written.rstrip(")") in str(message.text) for message in readings.messages)


@pytest.mark.parametrize("written", ["12,998 mean", "12,998 nominal", "12,998 rejected", "12,998 kg", "12,998 before"])
def test_words_that_change_a_number_are_refused(controller, written):
    sheet = f"Valve;Land;Part;Diameter [mm]\n12';1;spool;{written}\n12';1;sleeve;13,064"
    with pytest.raises(ReadingsError, match="not a number"):
        read_readings(sheet.encode(), controller, name="sheet.csv")


def test_lands_with_a_letter_before_their_number(controller):
    rows = "\n".join(f"{valve};P{land};{part};{size}" for valve, land, part, size in PAIRS)
    assert sizes(controller, f"Valve;Land;Part;Diameter [mm]\n{rows}") == UNDIRECTED


def test_two_directions_in_one_cell_are_those_of_the_heading(controller):
    sheet = "Valve;Land;Spool 0°/90° [mm];Bore 0°/90° [mm]\n12';1;12.998 / 12.997;13.064 / 13.070"
    assert sizes(controller, sheet) == [
        ("12'", "1", "spool", 0.0, 12.998),
        ("12'", "1", "spool", 90.0, 12.997),
        ("12'", "1", "sleeve", 0.0, 13.064),
        ("12'", "1", "sleeve", 90.0, 13.07),
    ]
    with pytest.raises(ReadingsError):
        sizes(controller, sheet.replace("12.998 / 12.997", "12.998 / 12.997 / 12.999"))


@pytest.mark.parametrize(
    "sheet",
    [
        "Valve;Land;Part;vertical [mm];horizontal [mm]\n12';1;spool;12.998;12.997\n12';1;sleeve;13.064;13.070",
        "Valve;Land;Part;Direction;Diameter [mm]\n12';1;spool;vertical;12.998\n12';1;spool;horizontal;12.997",
    ],
)
def test_words_for_directions_are_told_with_their_angles(controller, sheet):
    readings = read_readings(sheet.encode(), controller, name="sheet.csv")
    (message,) = [each for each in readings.messages if each.code == "directions_in_words"]
    assert message.text == "directions count: 'vertical' as 90° and 'horizontal' as 0°"


def test_a_block_of_lands_across_has_its_valve_in_a_title(controller):
    blocks = []
    for valve in ("6", "8", "12'"):
        lands = [land for of, land, part, _ in PAIRS if of == valve and part == "spool"]
        blocks.append(f"Valve {valve}\n;" + ";".join(f"Land {land}" for land in lands))
        for part in ("spool", "sleeve"):
            row = [f"{size:.3f}" for of, _, named, size in PAIRS if of == valve and named == part]
            blocks.append(";".join([part, *row]))
        blocks.append("")
    assert sorted(sizes(controller, "\n".join(blocks))) == sorted(UNDIRECTED)
    directed = "\n".join(blocks).replace("spool;", "spool 90°;").replace("sleeve;", "bore 90°;")
    assert {one[3] for one in sizes(controller, directed)} == {90.0}


def test_a_title_says_the_direction_of_its_table(controller):
    tables = [
        f"{angle}\nValve;Land;Spool [mm];Bore [mm]\n12';1;{spool};{bore}\n"
        for angle, spool, bore in (("0°", "12.998", "13.064"), ("90°", "12.997", "13.071"))
    ]
    found = sizes(controller, "\n".join(tables))
    assert [(part, angle) for _, _, part, angle, _ in found] == [
        ("spool", 0.0),
        ("sleeve", 0.0),
        ("spool", 90.0),
        ("sleeve", 90.0),
    ]


@pytest.mark.parametrize(
    ("sheet", "settled"),
    [
        (
            long("Valve;Land;Part;Diameter [mm]", lambda part, _: {"spool": "S", "sleeve": "B"}[part]),
            {"spool": "S", "sleeve": "B"},
        ),
        (
            "Valve;Land;Part;Diameter [mm]\n"
            + "\n".join(f"{valve};{'AB'[int(land) - 1]};{part};{size}" for valve, land, part, size in PAIRS),
            {"plane 1": "A", "plane 2": "B"},
        ),
        (
            "Valve;Land;Part;left edge;right edge\n"
            + "\n".join(
                f"{valve};{land};{part};{20.0 + at};{round(20.0 + at + size, 3)}"
                for at, (valve, land, part, size) in enumerate(PAIRS)
            ),
            {
                "component": "Valve",
                "part": "Part",
                "plane": "Land",
                "coordinate 1": "left edge",
                "coordinate 2": "right edge",
            },
        ),
        (
            "Valve;Land;Part;von;bis;Ø\n"
            + "\n".join(
                f"{valve};{land};{part};{size // 0.01 / 100 - 0.006:.3f};{size // 0.01 / 100 + 0.014:.3f};{size}"
                for valve, land, part, size in PAIRS
            ),
            {"component": "Valve", "part": "Part", "plane": "Land", "value": "Ø"},
        ),
    ],
    ids=["words for the parts", "lettered lands", "edges", "limits by their width"],
)
def test_what_is_asked_is_settled_word_for_word(controller, sheet, settled):
    assert told(controller, sheet) == settled
    assert sizes(controller, sheet, mapping=settled) == UNDIRECTED


def test_deviations_of_two_directions_are_offered_together(controller):
    sheet = "Valve;Land;Part;Nominal [mm];Dev. 0° [µm];Dev. 90° [µm]\n12';1;spool;13.0;-2;-3\n12';1;sleeve;13.062;2;10"
    settled = told(controller, sheet)
    assert [one[3:] for one in sizes(controller, sheet, mapping=settled)] == [
        (0.0, 12.998),
        (90.0, 12.997),
        (0.0, 13.064),
        (90.0, 13.072),
    ]


def test_titles_in_own_words_are_told_by_sizes(controller):
    rows = {
        part: "\n".join(f"{v};{p};{size}" for v, p, of, size in PAIRS if of == part) for part in ("spool", "sleeve")
    }
    sheet = f"Zeta\nValve;Land;mm\n{rows['spool']}\n\nAlpha\nValve;Land;mm\n{rows['sleeve']}"
    settled = told(controller, sheet)
    assert (settled["spool"], settled["sleeve"]) == ("Zeta", "Alpha")
    assert sorted(sizes(controller, sheet, mapping=settled)) == sorted(UNDIRECTED)


def test_words_alone_do_not_choose_between_columns(controller):
    sheet = "Valve;Land;Part;Diameter [mm];Again ?\n" + "\n".join(
        f"{valve};{land};{'Q' if part == 'spool' else 'R'};{size};{size + 0.001:.3f}"
        for valve, land, part, size in PAIRS
    )
    with pytest.raises(ReadingsError, match="which is the measurement"):
        sizes(controller, sheet, mapping={"spool": "Q", "sleeve": "R"})


def test_two_units_in_one_table_are_no_repeats(controller):
    rows = [f"{valve};{land};{part};{size + apart:.3f}" for valve, land, part, size in PAIRS for apart in (0.0, 0.012)]
    with pytest.raises(ReadingsError, match="further apart than repeats"):
        sizes(controller, "\n".join(["Valve;Land;Part;Diameter [mm]", *rows]))
    numbered = [f"{row};{at % 2 + 1}" for at, row in enumerate(rows)]
    assert len(sizes(controller, "\n".join(["Valve;Land;Part;Diameter [mm];Repeat", *numbered]))) == len(rows)


def test_a_list_of_nominal_sizes_is_refused(controller):
    rows = [
        (land.component, land.land, land.nominal_diameter, land.nominal_sleeve_diameter) for land in controller.lands
    ]
    lines = [f"{valve};{land};{spool * 1e3:.3f};{bore * 1e3:.3f}" for valve, land, spool, bore in rows]
    with pytest.raises(ReadingsError, match="a list of sizes"):
        sizes(controller, "\n".join(["Valve;Land;Spool [mm];Bore [mm]", *lines]))
    assert len(sizes(controller, "\n".join(["Valve;Land;Spool [mm];Bore [mm]", *lines[:5]]))) == 10
