"""Sheets that a person reads without doubt are read as that person would, or asked about; none is read wrongly.

They stand in ``layouts.toml`` and ``wordings.toml``.
"""

from __future__ import annotations

import csv
import datetime
import io
import tomllib
from pathlib import Path

import openpyxl
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.measurements.readings import Reading
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_readings


def _listed(name):
    return tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))


TRUTHS = _listed("layouts")["truths"]


def examples():
    """Return every sheet in one of the forms that can hold it, turn by turn."""
    listed = [entry for name in ("layouts", "wordings") for entry in _listed(name)["example"]]
    params = []
    for number, entry in enumerate(listed):
        form = "workbook" if "merged" in entry or ("encoding" not in entry and number % 4 == 0) else "text"
        if form not in entry.get("forms", (form,)):
            form = entry["forms"][0]
        params.append(pytest.param(entry, form, id=f"{entry['name']}-{form}"))
    return params


def written(entry, form, filled_in):
    sheet = "\n".join(["Notes of the day"] * entry.get("above", 0) + [entry["sheet"].strip("\n")])
    if form == "text":
        return sheet.encode(entry.get("encoding", "utf-8"))
    return filled_in(sheet, form, entry.get("merged", ()))


def stations(readings):
    """Return the diameters in mm by component, plane, part and direction, repeats in their order."""
    found: dict[str, list[float]] = {}
    for one in sorted(readings.readings, key=lambda each: each.repeat):
        direction = "" if one.direction is None else f" {one.direction:g}"
        found.setdefault(f"{one.component}/{one.plane}/{one.part}{direction}", []).append(round(one.diameter * 1e3, 4))
    return found


def truth(entry):
    if "reads" in entry:
        return entry["reads"]
    return {key: sizes for name in entry.get("truths", [entry.get("truth")]) for key, sizes in TRUTHS[name].items()}


@pytest.mark.parametrize(("entry", "form"), examples())
def test_a_sheet_that_a_person_understands_is_read_or_asked_about(example, filled_in, entry, form):
    controller = load_controller(entry["controller"]) if "controller" in entry else example
    options = {"fill_down": True} if entry.get("fill_down") else {}
    data = written(entry, form, filled_in)
    if "map" in entry:
        with pytest.raises(ReadingsError) as caught:
            read_readings(data, controller, **options)
        assert "--map" in str(caught.value)
        options["mapping"] = entry["map"]
    if word := entry.get("asked", entry.get("refused")):
        with pytest.raises(ReadingsError) as caught:
            read_readings(data, controller, **options)
        assert word in str(caught.value)
        return
    readings = read_readings(data, controller, **options)
    assert stations(readings) == truth(entry)
    texts = " ".join(message.text for message in readings.messages)
    for word in entry.get("said", ()):
        assert word in texts


@pytest.mark.parametrize(
    ("entry", "form"), [each for each in examples() if not {"asked", "refused"} & each.values[0].keys()]
)
def test_no_number_of_an_unusual_sheet_is_lost(example, filled_in, entry, form):
    """Another number of that size, wherever it stands, is named, or the sheet is refused; the readings stay theirs."""
    controller = load_controller(entry["controller"]) if "controller" in entry else example
    options = {"fill_down": True} if entry.get("fill_down") else {}
    options["mapping"] = entry.get("map")
    stray = {"four_speed_2023": "11.871"}.get(controller.id, "17.871")
    lines = entry["sheet"].strip("\n").split("\n")
    widest = max(line.count(";") for line in lines)
    below = {**entry, "sheet": "\n".join([*lines, "", f"{stray} on another day"])}
    sizes = {f"{size:.3f}" for listed in truth(entry).values() for size in listed}
    read = [at for at, line in enumerate(lines) if any(cell.replace(",", ".") in sizes for cell in line.split(";"))]
    line = next(iter(read), len(lines) - 1)
    lines[line] += ";" * (widest - lines[line].count(";") + 2) + stray
    beside = {**entry, "sheet": "\n".join(lines)}
    for changed in (below,) if "forms" in entry else (below, beside):
        try:
            readings = read_readings(written(changed, form, filled_in), controller, **options)
        except ReadingsError:
            continue
        assert stations(readings) == truth(entry)
        texts = " ".join(message.text.replace(",", ".") for message in readings.messages)
        assert stray in texts


def test_a_sheet_names_the_right_cells_of_a_turned_table(example):
    lines = ["Valve;accumulator;accumulator", "Land;1;1", "Part;piston;bore", "Diameter [mm];17.998;18.041"]
    readings = read_readings("\n".join(lines).encode(), example)
    assert [(one.place.row, one.place.column) for one in readings.readings] == [(4, "2"), (4, "3")]
    assert "sheet_turned" in [message.code for message in readings.messages]
    hot = "\n".join(["Temperature;25 °C", *lines]).encode()
    assert read_readings(hot, example).temperature == 25.0


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ((";;bore;18.041", ";;bore;18.041\n;;bore;17.041"), "nominal"),
        (("tcc_regulator;1;spool;10.998\n;;sleeve;11.031", ";1;piston;17.996\n;;bore;18.043"), "already"),
        (("tcc_regulator;1;spool", "\n;1;spool"), "Valve"),
    ],
)
def test_a_row_that_cannot_go_on_with_the_one_above_is_refused(example, changed, word):
    sheet = (
        "Valve;Land;Part;Diameter [mm]\naccumulator;1;piston;17.998\n;;bore;18.041\n"
        "tcc_regulator;1;spool;10.998\n;;sleeve;11.031"
    )
    assert len(read_readings(sheet.encode(), example, fill_down=True).readings) == 4
    with pytest.raises(ReadingsError) as caught:
        read_readings(sheet.replace(*changed).encode(), example, fill_down=True)
    assert word in str(caught.value)


def test_the_own_form_saved_as_text_is_read_without_being_told(example, tmp_path):
    taken = [
        Reading(component, part, "1", direction, repeat, size * 1e-3)
        for component, sizes in (("accumulator", (17.998, 18.041)), ("tcc_regulator", (10.998, 11.031)))
        for part, size in zip(("spool", "sleeve"), sizes, strict=True)
        for direction in (0.0, 90.0)
        for repeat in (1, 2)
    ]
    book = openpyxl.load_workbook(io.BytesIO(write_readings(example, taken)))
    rows = [["" if cell is None else str(cell).replace("\n", " ") for cell in row] for row in book.active.values]
    buffer = io.StringIO()
    csv.writer(buffer, delimiter=";").writerows(rows)
    readings = read_readings(buffer.getvalue().encode(), example)
    assert sorted(stations(readings).items()) == [
        (f"{component}/1/{part} {direction}", [size, size])
        for component, sizes in (("accumulator", (18.041, 17.998)), ("tcc_regulator", (11.031, 10.998)))
        for part, size in zip(("sleeve", "spool"), sizes, strict=True)
        for direction in (0, 90)
    ]
    assert "filled_down" in [message.code for message in readings.messages]


@pytest.mark.parametrize("written_as", [datetime.datetime(2026, 8, 1), "08-Jan", "1. Aug"])
def test_component_and_plane_that_became_a_date_are_called_a_date(make_workbook, written_as):
    rows = [("No.", "Part", "Diameter [mm]"), (written_as, "spool", 9.998), ("8/2", "sleeve", 12.055)]
    with pytest.raises(ReadingsError) as caught:
        read_readings(make_workbook(rows), load_controller("four_speed_2023"))
    assert "date" in str(caught.value)
    assert "text" in str(caught.value.expected)


@pytest.mark.parametrize(
    "sheet",
    [
        "Valve;Land;Part;Nominal [mm];Standard deviation [µm]\naccumulator;1;piston;18.000;2",
        "Count of Diameter [mm];Part;\nValve;piston;bore\naccumulator;2;2",
        "Valve;Land;Part;Diameter [mm]\npressure_regulator/1;2;spool;12.498",
        "Valve;Part;Diameter [mm]\npressure_regulator/1 bore;spool;14.997",
        "Valve;Land;Part;X [mm];Y [mm]\naccumulator;1;piston;17.998;17.996",
        "Valve;Part;Diameter 1 [mm];Diameter 2 [mm]\npressure_regulator;spool;12.498;14.997",
        "Valve;Land;Piston [mm];;Bore [mm];\n;;2023;2024;2023;2024\naccumulator;1;17.998;17.996;18.041;18.044",
        "Valve;Land;Part;Diameter [mm]\naccumulator;1;piston;17.998\nacumulator;;;18.041",
    ],
)
def test_what_looks_like_one_of_these_and_is_not_is_refused(example, sheet):
    with pytest.raises(ReadingsError):
        read_readings(sheet.encode(), example)


@pytest.mark.parametrize(
    ("cell", "component"),
    [
        ("20 – converter", "20"),
        ("wandler (20)", "20"),
        ("V. 14: shift 1-2", None),
        ("14 – Kick-down valve", None),
        ("14 or 15", None),
        ("14 mm", None),
        ("14 cambio 1-2", "14"),
        ("Klep nr. 20", "20"),
        ("3 o'clock", None),
    ],
)
def test_the_number_of_a_component_counts_beside_a_name_and_no_other(cell, component):
    names = ControllerNames(load_controller("four_speed_2023"))
    assert names.component(cell) == component


@pytest.mark.parametrize(
    ("title", "component"),
    [
        ("Zawór nr 14 – zmiana biegów 1-2", "14"),
        ("VÁLVULA 18: de presión 18", "18"),
        ("Valve body 14", None),
        ("Job 14", None),
        ("Ventil 14 und 15", None),
        ("Valve 14: Kick-down valve", None),
    ],
)
def test_a_title_names_a_component_by_its_number_behind_the_word_for_one(title, component):
    names = ControllerNames(load_controller("four_speed_2023"))
    assert names.component_in(title) == component
