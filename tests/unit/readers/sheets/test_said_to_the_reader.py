"""What is wrong with a measuring sheet is said wholly in the reader's language, and in the reader's units."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import ReadingsError
from atleak.common.wording import wording
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.column_headings import read_heading
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.sheets.table import EXPECTED_SHEET

Row = list[object]
HEADINGS: Row = ["No.", "Part", "Plane", "Direction", "Diameter [mm]"]
ENGLISH = re.compile(r"\b(?:the|row|column|sheet|is|are|of|not|and|or|expected|found|spool|sleeve|land|times|rows)\b")


def _rows(controller: Controller) -> list[Row]:
    """Two lands as they are when new, spool and sleeve in two directions."""
    return [
        [land.component, part, land.planes[0], f"{direction}°", round(1e3 * size, 4)]
        for land in controller.lands[:2]
        for part, size in (("spool", land.nominal_diameter), ("sleeve", land.nominal_sleeve_diameter))
        for direction in (0, 90)
    ]


def _refusal(rows: list[Row], controller: Controller) -> ReadingsError:
    text = "\n".join(";".join(map(str, row)) for row in rows)
    with pytest.raises(ReadingsError) as refused:
        read_readings(text.encode(), controller, name="blatt.csv")
    return refused.value


def _in_inches(rows: list[Row]) -> list[Row]:
    return [HEADINGS, *([*row[:4], float(str(row[4])) / 25.4] for row in rows)]


def _without_parts(rows: list[Row]) -> list[Row]:
    return [[*row[:1], *row[2:]] for row in (HEADINGS, *rows)]


def _with_text(rows: list[Row]) -> list[Row]:
    return [HEADINGS, [*rows[0][:4], "zwölf"], [*rows[1][:1], "Kugel", *rows[1][2:]], *rows[2:]]


def _swapped(rows: list[Row]) -> list[Row]:
    other = {"spool": "sleeve", "sleeve": "spool"}
    return [HEADINGS, *([row[0], other[str(row[1])], *row[2:]] for row in rows)]


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (_in_inches, "eine falsche Einheit (Zoll?)"),
        (_without_parts, "keine Spalte nennt das Teil (Schieber oder Hülse)"),
        (_with_text, "blatt.csv, Zeile 2, Spalte Diameter [mm]: keine Zahl (gefunden: 'zwölf')"),
        (_swapped, "Schieber und Hülse im ganzen Messblatt vertauscht?"),
    ],
)
def test_a_broken_sheet_is_refused_in_german(
    broken: Callable[[list[Row]], list[Row]], said: str, controller: Controller
) -> None:
    error = _refusal(broken(_rows(controller)), controller)
    german = wording("de").sentence(error.sentence)
    assert said in german
    assert ENGLISH.search(re.sub(r"Spalte Diameter \[mm\]|'[^']*'", "", german)) is None
    assert ENGLISH.search(str(error)) is not None, "English stays English"


def test_what_was_probably_meant_is_said_in_the_reader_s_language(controller: Controller) -> None:
    rows = _rows(controller)
    rows[0][1] = "spol"
    error = _refusal([HEADINGS, *rows], controller)
    assert error.nearest == PART_WORDS["spool"]
    assert wording("de").sentence(error.sentence).endswith("ist 'Schieber' gemeint?")


def test_a_file_refused_by_the_process_that_reads_it_says_so_in_the_reader_s_language(controller: Controller) -> None:
    with pytest.raises(ReadingsError) as refused:
        read_readings(b"PK\x05\x06" + 18 * b"\0", controller, name="a.xlsx")
    assert wording("pl").sentence(refused.value.problem) == "ten plik to archiwum ZIP, nie skoroszyt"


def test_sizes_are_said_in_the_reader_s_units_with_the_places_that_they_need(controller: Controller) -> None:
    rows = [*_rows(controller), ["pressure_regulator", "spool", "1", "0°", 14.9405]]
    text = "\n".join(";".join(map(str, row)) for row in (HEADINGS, *rows))
    first, *_ = clearances(read_readings(text.encode(), controller), controller)
    (said,) = (each.text for each in first.messages if each.code == "repeats_disagree")
    assert "repeats are 59.5 µm apart (15, 14.9405 mm), more than 5 µm" in said
    assert "59,5 µm auseinander (15,000; 14,9405 mm), mehr als 5,0 µm" in wording("de").sentence(said)
    assert "0.00234 in apart (0.5906, 0.58821 in), more than 0.00020 in" in wording("en", "us").sentence(said)


@pytest.mark.parametrize(
    ("language", "headings"),
    [
        ("de", ["Nr.", "Teil", "Ebene", "Bund", "Durchmesser", "Koordinate x1", "Richtung", "Wiederholung", "Einheit"]),
        (
            "pl",
            [
                "Nr",
                "część",
                "płaszczyzna",
                "stopień",
                "średnica",
                "współrzędna x1",
                "kierunek",
                "powtórzenie",
                "jednostka",
            ],
        ),
    ],
)
def test_headings_that_are_asked_for_are_understood(language: str, headings: list[str]) -> None:
    roles = ["component", "part", "plane", "land", "diameter", "coordinate", "direction", "repeat", "unit"]
    assert [heading for heading in headings if heading not in wording(language).sentence(EXPECTED_SHEET)] == []
    assert [column.role for heading in headings if (column := read_heading(heading))] == roles
