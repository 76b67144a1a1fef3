"""The instants of a road test as people read them: sustained first, in every report alike."""

from __future__ import annotations

import io
import json
from collections.abc import Callable

import numpy as np
import pandas as pd
import pypdfium2
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import Readings
from atleak.measurements.road_test import RoadTest
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.pdf import write_pdf
from atleak.report.tables.road_test import instant_table, road_instants
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook

EN = wording("en")
LogOf = Callable[..., RoadTest]
Build = Callable[..., Readings]


@pytest.fixture(scope="module")
def with_start(four_speed: Controller, hipol: Fluid, limits: Limits, log_of: LogOf, readings_of: Build) -> Diagnosis:
    """One land measured, and a log in which the engine is started, its last sample hotter than the fluid's data."""
    land = four_speed.land("25", 1)
    readings = readings_of(four_speed, {land.key: (land.nominal_diameter, land.nominal_sleeve_diameter)})
    time = np.round(np.arange(0.0, 12.0, 0.1), 9)
    log = log_of(
        time,
        main_pressure=np.select([time < 2.0, time < 4.0], [0.0, 900e3], 600e3),
        converter_pressure=200e3,
        atf_temperature=np.where(time < time[-1], 80.0, 160.0),
        gear=2.0,
        engine_speed=np.where(time < 2.0, 0.0, 800.0 / 60.0),
    )
    return diagnose(four_speed, hipol, limits, readings=readings, road_test=log)


def test_the_sustained_extremes_come_first(worn: Diagnosis) -> None:
    rows = road_instants(worn.road)
    names = ["max_leakage_sustained", "max_share_sustained", "max_leakage", "max_share", "min_leakage"]
    assert [row.name for row in rows] == names
    assert [row.leads for row in rows] == [True, True, False, False, True]


def test_a_log_too_short_to_sustain_anything_leads_with_its_single_samples(
    four_speed: Controller, hipol: Fluid, limits: Limits, log_of: LogOf
) -> None:
    log = log_of([0.0, 0.1, 0.2], main_pressure=600e3, converter_pressure=200e3, atf_temperature=80.0, gear=2.0)
    diagnosis = diagnose(four_speed, hipol, limits, road_test=log)
    assert [(row.name, row.leads) for row in road_instants(diagnosis.road)] == [
        ("max_leakage", True),
        ("min_leakage", True),
    ]
    record = json.loads(to_json(diagnosis_record(diagnosis)))["road_test"]
    assert record["max_leakage_sustained"] is record["max_share_sustained"] is record["start"] is None


def test_the_record_gives_the_start_apart(with_start: Diagnosis) -> None:
    road = json.loads(to_json(diagnosis_record(with_start)))["road_test"]
    assert 2.0 <= road["start"]["max_leakage"]["time_s"] < 4.0
    assert road["start"]["max_leakage"]["leakage_dm3_min"] > 1.2 * road["max_leakage"]["leakage_dm3_min"]
    assert road["max_leakage"]["time_s"] > 5.0
    assert road["start"]["samples"] == 31
    assert road["lower_bound"] is True
    assert road["sustained_over_s"] == pytest.approx(0.5, rel=1e-9, abs=0.0)


def test_terminal_and_workbook_say_the_same_in_the_same_order(
    with_start: Diagnosis, capsys: pytest.CaptureFixture[str]
) -> None:
    print_diagnosis(with_start)
    said = " ".join(capsys.readouterr().out.split()).lower()  # what begins a sentence has a capital
    labels = [row["instant"] for row in instant_table(with_start.road, None, EN).records()]
    assert labels[-1] == "after a start of the engine: largest share, sustained"
    shown = [label for label in labels if label != "smallest leakage"]
    places = [said.index(label.lower()) for label in shown]
    assert places == sorted(places)
    assert "lower bounds" in said
    sheet = pd.read_excel(
        io.BytesIO(write_workbook(with_start)), sheet_name="Road test", header=None, engine="calamine"
    )
    column = sheet[0].fillna("").astype(str).tolist()
    first = column.index("Instant") + 1
    assert column[first : first + len(labels)] == labels
    assert "a few wrong samples" in column[first + len(labels)]


def test_terminal_and_page_rows_give_the_intervals(worn: Diagnosis, capsys: pytest.CaptureFixture[str]) -> None:
    print_diagnosis(worn)
    said = " ".join(capsys.readouterr().out.split())
    first = instant_table(worn.road, worn.uncertainty, EN).records()[0]
    assert first["instant"] == "largest leakage, sustained"
    for name, unit, digits in (("leakage", "dm³/min", 2), ("share", "% of the pump's flow", 1)):
        low, value, high = (first[f"instant_{name}{end}"] for end in ("_low", "", "_high"))
        assert low < value < high
        assert f"{value:.{digits}f} {unit}, {low:.{digits}f} to {high:.{digits}f}" in said
    assert "instant_leakage_low" not in instant_table(worn.road, None, EN).records()[0]


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", ("largest leakage, sustained", "after a start of the engine: largest share, sustained", "lower bounds")),
        ("de", ("größte Leckage, anhaltend", "nach dem Anlassen des Motors: größter Anteil", "untere Schranken")),
        ("pl", ("największy przeciek, utrzymujący się", "po uruchomieniu silnika: największy udział", "od dołu")),
    ],
)
def test_the_printed_report_says_it_in_every_language(
    with_start: Diagnosis, language: str, words: tuple[str, ...]
) -> None:
    with pypdfium2.PdfDocument(write_pdf(with_start, language=language, sections=["road_test"])) as document:
        said = "".join("".join(page.get_textpage().get_text_range().split()) for page in document)
    for text in words:
        assert "".join(text.split()) in said
