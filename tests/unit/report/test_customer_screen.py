"""The customer's screen: what it says and asks, what it keeps to itself, and that nobody's text becomes its code."""

from __future__ import annotations

import datetime as dt
import json
import re
from collections.abc import Callable

import pytest

from atleak.analysis.comparison import compare
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.translations import languages
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.job_card import Customer, EstimateTerms, Job, RepairDecision, Vehicle, Workshop
from atleak.measurements.readings import Readings
from atleak.report.customer_screen import Answer, asked_for, closed, shows_the_same, written
from atleak.report.pdf.customer_screen import customer_screen

LINES = (
    RepairDecision(component="25", price=120.0, hours=1.5, decision="proposed"),
    RepairDecision(component="26", price=80.0, hours=1.0, decision="declined", reason="too dear"),
    RepairDecision(component="20", price=8.0, hours=0.5, decision="done"),
)
JOB = Job(
    number="K-7",
    complaint="Ana Lima says it slips",
    workshop=Workshop(name="Gears & Sons"),
    customer=Customer(name="Lima, Ana", phone="555 1234", address="Main Street 1"),
    vehicle=Vehicle(make="Volvo", model="S60", registration="PO 1234", vin="WVWZZZ1JZXW000001"),
    estimate=EstimateTerms(currency="EUR", labour_rate=60.0, tax_percent=19.0),
    repair_decisions=LINES,
)


@pytest.fixture(scope="module")
def unit(sample_diagnoses: dict[str, Diagnosis]) -> Diagnosis:
    return sample_diagnoses["workshop"]


def test_it_says_what_is_wrong_what_it_costs_and_asks_about_what_is_not_done(unit: Diagnosis) -> None:
    screen = customer_screen(unit, JOB)
    cost = screen["cost"]
    assert screen["headline"] == "The valve body needs repair."
    amounts = [line["amount"] for line in cost["lines"]]
    assert amounts[:3] == ["210.00", "140.00", "38.00"]
    assert {*amounts[3:]} <= {"not priced yet"}
    assert {"25", "26"} <= {*asked_for(screen)}
    assert "20" not in asked_for(screen)  # it is done
    assert sorted(str(line["agreed"]) for line in cost["lines"] if line["asked"])[:2] == ["False", "None"]
    assert not any(line["asked"] for line in cost["lines"] if line["amount"] == "not priced yet")
    widths = {bar["name"]: bar["width"] for bar in screen["bars"]}
    assert widths["now"] > widths["with these repairs"] > 0.0
    assert json.loads(json.dumps(screen)) == screen  # as the job book keeps it


@pytest.mark.parametrize("worn", [60e-6, 35e-6])
def test_beside_another_visit_it_says_what_was_lost_then_and_is_lost_now(
    worn_clutch: Diagnosis, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings], worn: float
) -> None:
    controller = worn_clutch.controller
    sizes = {land.key: land.nominal_diameter for land in controller.lands}
    radial = {land.key: worn if land.component == "2" else land.new_clearance for land in controller.lands}
    diameters = {key: (size, size + 2.0 * radial[key]) for key, size in sizes.items()}
    other = diagnose(controller, hipol, limits, readings=readings_of(controller, diameters))
    visits = compare(other, worn_clutch)
    later, earlier = (customer_screen(each, Job(), visits=visits) for each in (worn_clutch, other))
    assert visits.leading is not None
    assert later["sentence"].startswith("At the visit before, ") == (visits.leading.share.significant is not False)
    shown = [{bar["name"]: bar["litres"] for bar in screen["bars"]} for screen in (later, earlier)]
    assert shown[0]["at the visit before"] == shown[1]["now"] == f"{visits.leading.share.before * 100:.0f}"
    assert shown[0]["now"] == shown[1]["at a later visit"] == f"{visits.leading.share.after * 100:.0f}"
    assert not shows_the_same(later, customer_screen(worn_clutch, Job()))


def test_a_screen_kept_by_an_older_version_is_written_and_shows_the_same(unit: Diagnosis) -> None:
    screen = customer_screen(unit, JOB)
    bars = [{name: each for name, each in bar.items() if name != "now"} for bar in screen["bars"]]
    older = screen | {"bars": bars}
    assert shows_the_same(older, screen)
    assert bars[0]["litres"] in written(older)
    assert not shows_the_same(screen | {"bars": bars[1:]}, screen)


def test_of_personal_data_it_holds_plate_and_first_name(unit: Diagnosis) -> None:
    page = written(customer_screen(unit, JOB), asks=True)
    assert "Ana" in page
    assert "PO 1234" in page
    for kept_back in ("Lima", "555", "Main Street", "WVW", "slips", "K-7"):
        assert kept_back not in page, kept_back


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("Ana Lima", "Ana"),
        ("Lima, Ana", "Ana"),
        ("Lima,Ana", "Ana"),
        ("Lima", ""),
        ("Dr. Lima", ""),
        ("Taxi Nord Ltd", ""),
    ],
)
def test_a_first_name_is_shown_where_it_is_one(unit: Diagnosis, name: str, shown: str) -> None:
    about = customer_screen(unit, JOB.model_copy(update={"customer": Customer(name=name)}))["about"]
    assert about.partition(" · ")[0] == (shown or "PO 1234")


def test_only_an_address_takes_an_answer_and_no_page_needs_anything_else(unit: Diagnosis) -> None:
    screen = customer_screen(unit, JOB)
    file, page = written(screen), written(screen, asks=True)
    assert "<input" not in file
    assert page.count('value="yes"') == page.count('value="no"') == len(asked_for(screen))
    for html in (file, page, closed("en")):
        assert "default-src 'none'" in html
        assert not re.search(r"(?:src|href)=[\"'](?!#|data:)", html)


def test_text_of_the_job_is_never_code_of_the_page(unit: Diagnosis) -> None:
    evil = '<script>alert("1")</script>'
    lines = (LINES[0].model_copy(update={"work": evil}),)
    job = JOB.model_copy(update={"workshop": Workshop(name=evil), "repair_decisions": lines})
    screen = customer_screen(unit, job)
    answer = Answer(f'">{evil}', dt.datetime.now(dt.UTC), dict.fromkeys(asked_for(screen), True))
    page = written(screen, asks=True, answer=answer)
    assert page.count("<script>") == 1  # the page's own
    assert "&lt;script&gt;alert" in page


def test_an_answer_is_shown_and_what_was_not_whole_is_said(unit: Diagnosis) -> None:
    screen = customer_screen(unit, JOB)
    answer = Answer("Ana", dt.datetime(2026, 11, 29, 10, 12, tzinfo=dt.UTC), {"25": True, "26": False})
    page = written(screen, asks=True, answer=answer)
    assert "Thank you, Ana." in page
    assert re.search(r'name="25" value="yes" checked', page)
    assert re.search(r'name="26" value="no" checked', page)
    assert "Not sent" in written(screen, asks=True, sent={"name": "Ana", "25": "yes"})


def test_a_screen_is_another_one_once_a_price_has_changed_but_not_once_it_was_answered(unit: Diagnosis) -> None:
    screen = customer_screen(unit, JOB)
    agreed = JOB.model_copy(update={"repair_decisions": (LINES[0].changed(decision="approved"), *LINES[1:])})
    dearer = JOB.model_copy(update={"repair_decisions": (LINES[0].changed(price=130.0), *LINES[1:])})
    assert shows_the_same(screen, customer_screen(unit, agreed))
    assert not shows_the_same(screen, customer_screen(unit, dearer))


@pytest.mark.parametrize("language", languages())
def test_every_language_has_a_whole_page(unit: Diagnosis, language: str) -> None:
    screen = customer_screen(unit, JOB, language=language)
    assert f'<html lang="{language}">' in written(screen, asks=True)
    assert f'<html lang="{language}">' in closed(language)


def test_a_unit_that_needs_nothing_asks_nothing(unit: Diagnosis) -> None:
    nobody_measured = diagnose(unit.controller, unit.fluid, unit.limits)
    screen = customer_screen(nobody_measured, Job())
    assert screen["cost"] is None
    assert screen["bars"] == []
    assert "<form" not in written(screen, asks=True)
