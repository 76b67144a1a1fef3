"""What a log says by itself in words, in every language and on every output."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pypdfium2
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import RPM
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.events import AccelerationTest, Event
from atleak.measurements.job_card import Job
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.pdf import write_pdf
from atleak.report.tables.road_words import (
    event_name,
    event_remark,
    log_sentences,
    permitted_sentence,
    pressure_sentences,
)
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook

ENGLISH = wording("en")


@pytest.fixture(scope="module")
def log(sample_log: Path) -> RoadTest:
    return read_road_test(sample_log)


@pytest.fixture(scope="module")
def alone(four_speed: Controller, hipol: Fluid, limits: Limits, log: RoadTest) -> Callable[..., Diagnosis]:
    """The sample log alone, with its main pressure multiplied, or without some of its channels."""

    def build(factor: float = 1.0, without: tuple[str, ...] = (), controller: Controller = four_speed) -> Diagnosis:
        main = log.channels["main_pressure"]
        channels = {**log.channels, "main_pressure": replace(main, values=main.values * factor)}
        kept = {name: channel for name, channel in channels.items() if name not in without}
        return diagnose(controller, hipol, limits, road_test=replace(log, channels=kept, _held={}))

    return build


Alone = Callable[..., Diagnosis]


def test_low_pressure_is_said_with_how_long_where_and_how_far(alone: Alone) -> None:
    said = permitted_sentence(alone(0.4).log, ENGLISH)
    assert said == (
        "Main pressure stayed below what is permitted for 11.9 s of 11.9 s judged, the worst at 11.0 s in gear 4, "
        "driving: 253 kPa where 412 kPa are the least, 159 kPa or 38.6\u00a0% below (✖ critical). That stretch lasts "
        "from 0.0 to 12.0 s."
    )


def test_whose_limits_they_are_is_said_with_them(alone: Alone) -> None:
    sentences = list(pressure_sentences(alone().log, ENGLISH))
    assert sentences[0].startswith("Main pressure stayed nowhere below what is permitted for a second (11.9 s judged)")
    assert sentences[1].startswith("Limits: assumed:")


@pytest.mark.parametrize(
    ("without", "said"),
    [
        (("main_pressure",), "The log holds no main pressure"),
        (("engine_speed",), "the log holds no engine speed"),
        (("gear",), "the log holds no gear"),
    ],
)
def test_what_is_not_judged_says_why(alone: Alone, without: tuple[str, ...], said: str) -> None:
    assert said in permitted_sentence(alone(without=without).log, ENGLISH)


def test_a_sentence_after_a_full_stop_begins_with_a_capital_letter(alone: Alone) -> None:
    built = alone(without=("main_pressure",))
    refused = {"main_pressure": Sentence("it is stated that no column of this log holds it")}
    log = replace(built.log, road_test=replace(built.log.road_test, refused=refused, _held={}))
    assert permitted_sentence(log, ENGLISH).endswith("is not known. It is stated that no column of this log holds it")


def test_the_leakage_of_a_new_unit_is_no_finding_of_a_road_test(
    alone: Alone, capsys: pytest.CaptureFixture[str]
) -> None:
    print_diagnosis(alone())
    assert "largest leakage" not in capsys.readouterr().out.lower()


def test_a_fluid_that_grew_warm_is_told_from_and_to(alone: Alone) -> None:
    log = replace(alone().log, temperatures=(79.6, 91.2))
    for language, said in (("en", "Fluid 80 to 91 °C."), ("de", "Öl 80 bis 91 °C."), ("pl", "Olej od 80 do 91 °C.")):
        assert next(iter(log_sentences(log, wording(language)))) == said


def test_a_valve_body_that_permits_nothing_is_told(alone: Alone, four_speed: Controller) -> None:
    silent = alone(controller=replace(four_speed, permissible=()))
    assert silent.verdict == "not_measured"
    assert "states none that is permitted" in permitted_sentence(silent.log, ENGLISH)


def test_gears_temperatures_and_events_are_told(alone: Alone) -> None:
    assert list(log_sentences(alone().log, ENGLISH)) == [
        "Fluid 80 °C.",
        "Time in gears: 1: 0.9 s, 2: 4.2 s, 3: 3.4 s, 4: 3.5 s.",
        "Events: 1 × minimum-acceleration test, 3 × shift.",
    ]


@pytest.mark.parametrize(
    ("fault", "missing", "said"),
    [
        (None, (), "driven as it is meant to be, the engine at most at 2 690 rpm (4.2 s)"),
        ("too_fast", (), "driven too fast, the engine at 2 690 rpm at 4.2 s, 190 above the 2 500 allowed"),
        ("broken_off", (4, 5), "broken off at 6.0 s, gear 4, 5 not reached, the engine at most at 2 690 rpm (4.2 s)"),
    ],
)
def test_a_test_is_told_with_when_and_by_how_much(fault: str | None, missing: tuple[int, ...], said: str) -> None:
    test = AccelerationTest((1, 2, 3), missing, 2690.0 / RPM, 4.17, 2500.0 / RPM, fault)  # type: ignore[arg-type]
    event = Event("minimum_acceleration", 0.3, 6.0, test=test)
    assert event_remark(event, ENGLISH).replace("\u00a0", " ") == f"{said}; gears 1, 2, 3."
    assert event_name(event, wording("de")) == "Prüfung mit kleinster Beschleunigung"


# --- every output


@pytest.mark.parametrize("language", languages())
def test_the_printed_report_of_a_road_test_alone(alone: Alone, language: str) -> None:
    low, say = alone(0.4), wording(language)
    text = printed(low, language)
    assert squeezed(permitted_sentence(low.log, say)) in text
    assert squeezed(say("findings.alone")) in text
    assert squeezed(say("checks.low_everywhere")) in text
    assert squeezed(say("events.minimum_acceleration")) in text
    assert squeezed(say("bands.green")) not in text.replace(squeezed(say("texts.source_study")), "")
    for section in ("flagged", "matrix", "repair_order", "all"):
        assert squeezed(say(f"sections.{section}")) not in text
    for leakage in ("findings.unmeasured", "instants.max_leakage_sustained", "facts.sections"):
        assert squeezed(say(leakage)) not in text


@pytest.mark.parametrize("complaint", ["", "Slips when hot"])
@pytest.mark.parametrize("language", languages())
def test_the_first_page_of_a_sound_road_test_calls_for_nothing_and_gives_no_all_clear(
    alone: Alone, language: str, complaint: str
) -> None:
    with pypdfium2.PdfDocument(write_pdf(alone(), Job(complaint=complaint), language=language)) as document:
        first = squeezed(document[0].get_textpage().get_text_range())
    say = wording(language)
    assert squeezed(say("customer.urgent_ok_unmeasured")) in first
    assert squeezed(say("customer.urgent_ok")) not in first
    assert (squeezed(say("customer.do_measure_sheet")) in first) == bool(complaint)


def test_a_printed_report_without_main_pressure_says_what_to_gauge(alone: Alone) -> None:
    text = printed(alone(without=("main_pressure",)), "en")
    assert squeezed("Not measured: The log holds no main pressure") in text
    assert squeezed("Gauge it at the main pressure tap") in text


def squeezed(text: str) -> str:
    return "".join(text.replace("\u00ad", "").split())


def printed(diagnosis: Diagnosis, language: str) -> str:
    with pypdfium2.PdfDocument(write_pdf(diagnosis, language=language)) as document:
        return squeezed("".join(page.get_textpage().get_text_range() for page in document)).replace("\ufffe", "-")


def test_the_workbook_of_a_road_test_alone_has_its_events_and_no_lands(alone: Alone) -> None:
    low = alone(0.4)
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(low)))
    assert book.sheetnames == ["Summary", "Road test", "Road test events", "Assumed", "Messages", "Provenance"]
    cells = [str(cell) for row in book["Summary"].iter_rows(values_only=True) for cell in row if cell is not None]
    assert "✖ critical" in cells
    assert permitted_sentence(low.log, ENGLISH) in cells
    assert not any("green" in cell for cell in cells)
    rows = list(book["Road test events"].iter_rows(values_only=True))
    assert [row[0] for row in rows[1:]] == ["minimum-acceleration test", "shift", "shift", "shift"]
    assert [row[1] for row in rows[2:]] == ["1 → 2", "2 → 3", "3 → 4"]


def test_terminal_and_record_say_the_same_of_a_log(alone: Alone, capsys: pytest.CaptureFixture[str]) -> None:
    low = alone(0.4)
    print_diagnosis(low)
    said = " ".join(capsys.readouterr().out.split())
    record = json.loads(to_json(diagnosis_record(low)))["road_test"]
    assert record["check_next"]
    for check in record["check_next"]:
        assert f"{check['text']} ({check['source_text']})" in said
    assert [event["kind"] for event in record["events"]] == [event.kind for event in low.log.events]
    assert set(record["events"][0]) == {
        "kind", "start_s", "end_s", "duration_s", "from_gear", "to_gear", "source", "note", "test",
    }  # fmt: skip
    assert " ".join(record["events"][0]["note"].split()) in said


def test_nothing_that_was_not_measured_is_green(
    unmeasured: Diagnosis, alone: Alone, capsys: pytest.CaptureFixture[str]
) -> None:
    for diagnosis in (unmeasured, alone()):
        record = diagnosis_record(diagnosis)
        assert {condition["band"] for condition in record["conditions"]} == {None}
        assert {end["band"] for end in record["repair_plan_ends"]["conditions"]} == {None}
        assert (record["repair_plan_ends"]["reached"], record["repair_plan"]) == (False, [])
        print_diagnosis(diagnosis)
        assert "green" not in capsys.readouterr().out
        assert "green" not in printed(diagnosis, "en")
