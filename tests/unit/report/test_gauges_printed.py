"""Gauge readings in the PDF and the workbook, read back."""

from __future__ import annotations

import io
from pathlib import Path

import openpyxl
import pandas as pd
import pytest

from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.measurements.gauge_readings import Engine
from atleak.report.pdf import write_pdf
from atleak.report.xlsx import write_workbook
from atleak.report.xlsx.live_sheet import RANKED
from atleak.report.xlsx.road_sheet import ROAD_SHEET
from tests.unit.conftest import first_of
from tests.unit.report.read_back import text_of

TABLE = """range;tap;slow idle [kPa];fast idle 1500 rpm [kPa]
R;line;900;1000
D;line;700;800
2;line;690;790
P;line;700;
D;forward_clutch;480;
"""


@pytest.fixture(scope="module")
def gauged() -> Diagnosis:
    return Case(controller="five_speed_2005", pressures=SourceFile("gauges.csv", TABLE.encode())).diagnose()


@pytest.mark.parametrize("language", languages())
def test_the_pdf_lists_every_reading_and_what_the_table_hints_at(gauged: Diagnosis, language: str) -> None:
    say = wording(language)
    printed = write_pdf(gauged, language=language, sections=["gauges"])
    text = " ".join(text_of(printed).split())
    assert b"<pdfaid:part>2<" in printed
    assert say("sections.gauges") in text
    for reading in ("900", "690", "480"):
        assert reading in text
    for word in (say.level("critical"), say.sentence(Engine.FAST_IDLE.label).split()[0], "gauges.csv"):
        assert word in text
    for kind in ("low_at_slow_idle", "circuit_loss"):
        start = say.table("patterns")[kind].split("{")[0].strip() or say.name("forward clutch")
        assert start[:30] in text


def readings_in(content: bytes) -> pd.DataFrame:
    frame = pd.read_excel(io.BytesIO(content), sheet_name=ROAD_SHEET, engine="calamine", dtype={"Range": str})
    return frame[frame["State"].notna()]


@pytest.mark.parametrize("language", languages())
def test_a_reading_for_which_the_file_permits_nothing_is_not_judged(language: str) -> None:
    table = SourceFile("gauges.csv", b"range;slow idle [kPa]\nD;700\n")
    diagnosis = Case(controller="minimal_example", pressures=table).diagnose()
    assert readings_in(write_workbook(diagnosis))["Verdict"].tolist() == ["not judged"]
    text = text_of(write_pdf(diagnosis, language=language, sections=["gauges"]))
    assert wording(language)("texts.not_judged").split()[0] in text


def test_the_workbook_has_a_sheet_of_them_with_numbers(gauged: Diagnosis) -> None:
    content = write_workbook(gauged)
    readings = readings_in(content)
    whole = readings["Range"].isna() | (readings["Range"] == "Tap")
    readings = readings[: int(whole.to_numpy().argmax())]  # below stands what is missing, split by cause
    assert readings["Range"].tolist() == ["P", "R", "R", "D", "D", "2", "2", "D"]
    assert readings["Gauge [kPa]"].astype(float).tolist() == [700.0, 900.0, 1000.0, 700.0, 800.0, 690.0, 790.0, 480.0]
    assert readings["Verdict"].iloc[0] == "✖ critical"  # park is judged as neutral is
    assert float(readings["Lost [kPa]"].iloc[-1]) > 103.0
    sheet = openpyxl.load_workbook(io.BytesIO(content))[ROAD_SHEET]
    notes = " ".join(str(row[1].value) for row in sheet.iter_rows() if row[0].value == "pattern")
    assert "look at the pump first" in notes
    assert "computed from the valve body" in notes


def test_a_job_without_gauges_has_neither_sheet_nor_section() -> None:
    diagnosis = Case(controller="minimal_example").diagnose()
    assert ROAD_SHEET not in openpyxl.load_workbook(io.BytesIO(write_workbook(diagnosis))).sheetnames
    text = text_of(write_pdf(diagnosis, sections=["gauges", "signatures"]))
    assert wording("en")("sections.gauges") not in text


@pytest.mark.parametrize("language", languages())
def test_a_job_of_gauges_alone_says_what_they_decided_and_nothing_of_measured_lands(
    gauged: Diagnosis, language: str
) -> None:
    say, text = wording(language), " ".join(text_of(write_pdf(gauged, language=language)).split())
    assert say("findings.alone") in text
    assert say("sections.gauges") in text
    for section in ("flagged", "matrix", "pressures", "repair_order", "all"):
        assert say(f"sections.{section}") not in text
    assert say.level(gauged.verdict).capitalize() in text
    names = openpyxl.load_workbook(io.BytesIO(write_workbook(gauged))).sheetnames
    assert names == ["Summary", ROAD_SHEET, "Before opening", "Assumed", "Messages", "Provenance"]


@pytest.mark.parametrize(("drive", "verdict"), first_of([(450.0, "■ replace"), (200.0, "✖ critical")]))
def test_the_workbooks_verdict_counts_what_gauges_showed(sample_readings: Path, drive: float, verdict: str) -> None:
    gauges = SourceFile("gauges.csv", f"range;slow idle [kPa]\nD;{drive}\n".encode())
    diagnosis = Case(readings=SourceFile.at(sample_readings), pressures=gauges).diagnose()
    content = write_workbook(diagnosis)
    summary = openpyxl.load_workbook(io.BytesIO(content))["Summary"]
    assert openpyxl.load_workbook(io.BytesIO(content), data_only=True)["Summary"]["B5"].value == verdict
    assert f",{1 + RANKED.index(diagnosis.pressures.verdict)})" in summary["B5"].value
    if drive == 200.0:
        assert "Gauge at the line, D, slow idle: 200 kPa where 412 kPa are the least" in summary["B7"].value


def test_gauges_that_are_within_say_so(sample_readings: Path) -> None:
    gauges = SourceFile("gauges.csv", b"range;slow idle [kPa]\nD;450\nP;400\n")
    text = " ".join(text_of(write_pdf(Case(pressures=gauges).diagnose(), sections=[])).split())
    assert "1 of 2 gauge readings can be judged; none has reached a limit." in text
