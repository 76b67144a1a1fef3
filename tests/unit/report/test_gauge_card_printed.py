"""The gauge card, read back: its numbers, its empty column, and what it says where nothing is computed."""

from __future__ import annotations

import re
from pathlib import Path

import pypdfium2
import pytest

from atleak.common.style import PAPERS
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.measurements.gauge_readings import LINE_TAP, Engine
from atleak.measurements.job_card import Job, Vehicle
from atleak.report.pdf.gauge_card import write_gauge_card
from atleak.report.tables.gauges import card_notes, card_table
from tests.unit.report.read_back import is_archival, text_of

SHEET = Path(__file__).parents[3] / "sample_data" / "measuring_sheet_five_speed.xlsx"
UNIT = "five_speed_2005"


@pytest.fixture(scope="module")
def measured() -> Diagnosis:
    return Case(controller=UNIT, readings=SourceFile.at(SHEET)).diagnose()


@pytest.mark.parametrize("language", languages())
def test_new_and_now_stand_beside_room_for_what_is_read(measured: Diagnosis, language: str) -> None:
    say, content = wording(language), write_gauge_card(measured, language=language)
    text = text_of(content)
    assert is_archival(content)
    for word in ("card_new", "card_now", "card_read", "temperature"):
        assert say(f"columns.{word}") in text
    assert say("gauge_page.temperature") in text
    for row in measured.gauge_card.rows():
        for shows in (row.expected.new, row.expected.now) if row.expected else ():
            value, low, high = (say.value(each / 1e3, "pressure", 0).replace("\u00a0", " ") for each in shows)
            assert f"{value} ({low}–{high})" in text
    assert len(re.findall(re.escape(say("gauge_card.not_computed")), text)) >= 2


def test_of_a_new_unit_no_now_is_printed_and_a_vented_tap_is_not_on_it() -> None:
    text = text_of(write_gauge_card(Case(controller=UNIT).diagnose()))
    assert "Now" not in text
    assert "Forward clutch" in text
    assert "verdrive band" not in text
    assert "assumed: 1 500 rpm" in text


def test_a_unit_without_circuits_has_the_line_alone() -> None:
    diagnosis = Case(controller="four_speed_2023").diagnose()
    rows = card_table(diagnosis, wording("en")).records()
    assert {row["tap"] for row in rows} == {"line"}
    assert "no operating point of that gear and state" in text_of(write_gauge_card(diagnosis))


def test_it_is_in_the_readers_units_on_either_paper(measured: Diagnosis) -> None:
    row = next(
        each
        for each in measured.gauge_card.rows()
        if (each.tap, each.engine, each.ranges[0]) == (LINE_TAP, Engine.STALL, "D")
    )
    widths = set()
    for paper in PAPERS:
        content = write_gauge_card(measured, units="us", paper=paper)
        text = text_of(content)
        value, low, high = (round(each / 6894.757) for each in row.expected.new)
        assert f"{value} ({low}–{high})" in text
        assert "194" in text, "90 °C"
        assert "psi" in text
        with pypdfium2.PdfDocument(content) as document:
            widths.add(document[0].get_width())
    assert len(widths) == len(PAPERS)


def test_a_speed_that_the_readings_state_is_taken_and_not_called_assumed() -> None:
    table = SourceFile("g.csv", b"range;fast idle 1800 rpm [kPa]\nD;890\n")
    diagnosis = Case(controller=UNIT, pressures=table).diagnose()
    speeds = {row["engine_speed"] for row in card_table(diagnosis, wording("en")).records()}
    assert 1800.0 in {speed and round(speed, 6) for speed in speeds}
    assert not any("assumed" in note for note in card_notes(diagnosis, wording("en")))


def test_the_head_has_what_is_known_of_the_job_and_lines_for_the_rest(measured: Diagnosis) -> None:
    job = Job(number="2026-0417", vehicle=Vehicle(make="Ford", model="Explorer"))
    known, empty = (text_of(write_gauge_card(measured, each)) for each in (job, None))
    assert "2026-0417" in known
    assert "Ford Explorer" in known
    assert "Vehicle" in empty
