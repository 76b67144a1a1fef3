"""What is typed lands where it was typed, and means what was written."""

from __future__ import annotations

import contextlib
import io
import json
import re
import time
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from PIL import Image
from playwright.sync_api import Locator, Page, expect
from playwright.sync_api import TimeoutError as TooLate

from .conftest import step, to, unfold

SOON = 30.0  # [s]
VEHICLE = {
    "Make": "Mercedes",
    "Model": "W210",
    "Year": "1999",
    "Engine": "3.0 TD",
    "Registration": "KR 12345",
    "VIN": "WDB2100371A123456",
}


def wait_until_idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def form(page: Page) -> Locator:
    """The fold with job, vehicle and customer."""
    return page.get_by_test_id("stExpander").filter(has_text="Job, vehicle and customer")


def field(page: Page, label: str) -> Locator:
    """A field of the form; of the two registrations the vehicle's."""
    return form(page).get_by_role("textbox", name=label, exact=True).last


# Comes back when the page's script has not run for a second.
IDLE = """() => new Promise(done => {
    let since = performance.now()
    const look = () => {
        const app = document.querySelector("[data-testid=stApp]")
        if (app?.dataset.testScriptState !== "notRunning") since = performance.now()
        performance.now() - since > 1000 ? done() : requestAnimationFrame(look)
    }
    look()
})"""


def download(page: Page, button: str) -> bytes:
    """What a button gives; a click that goes astray, because the page is drawn anew meanwhile, is made again."""
    for _ in range(6):
        page.evaluate(IDLE)
        with contextlib.suppress(TooLate):
            with page.expect_download(timeout=15_000) as waiting:
                page.get_by_role("button", name=button).click(delay=80)
            return Path(waiting.value.path()).read_bytes()
    raise AssertionError(f"{button} gives nothing")


def expect_record(page: Page, wanted: dict) -> None:
    """The job record comes to be the wanted one: what was typed last is on its way for a moment."""
    page.wait_for_timeout(500)  # the hand goes from the keyboard to the mouse
    wait_until_idle(page)
    to(page, "Report")
    limit = time.monotonic() + SOON
    while (written := json.loads(download(page, "Job record"))) != wanted and time.monotonic() < limit:
        page.wait_for_timeout(200)
    assert written == wanted


def opened(fold: Locator) -> bool:
    return fold.locator("details").get_attribute("open") is not None


def condition(page: Page) -> Locator:
    """The panel's fold of the stated condition, open."""
    fold = page.get_by_test_id("stSidebar").get_by_test_id("stExpander").filter(has_text="Stated condition")
    if not opened(fold):
        fold.locator("summary").click()
    return fold


def write(fold: Locator, label: str, text: str) -> None:
    box = fold.get_by_label(label)
    box.fill(text)
    box.press("Enter")


@pytest.mark.page("1_Job")
@pytest.mark.parametrize("delay", [60, pytest.param(100, marks=pytest.mark.slow)])
def test_a_vehicle_typed_with_tab_stands_in_its_fields(page: Page, delay: int) -> None:
    wait_until_idle(page)
    field(page, "Make").click()
    for value in VEHICLE.values():
        page.keyboard.type(value, delay=delay)
        page.keyboard.press("Tab")
    wait_until_idle(page)
    assert {label: field(page, label).input_value() for label in VEHICLE} == VEHICLE
    assert opened(form(page))
    expect_record(page, {"vehicle": {label.lower(): value for label, value in VEHICLE.items()}})


@pytest.mark.slow
def test_a_vehicle_typed_in_another_order_is_printed_where_it_belongs(page: Page) -> None:
    import pypdfium2

    to(page, "Job")
    order = ["VIN", "Engine", "Make", "Registration", "Year", "Model"]
    for label in order:
        field(page, label).click()
        page.keyboard.type(VEHICLE[label], delay=60)
    field(page, "Job number").click()
    page.keyboard.type("A-17", delay=60)
    page.get_by_role("textbox", name="Notes").click()
    wait_until_idle(page)
    assert {label: field(page, label).input_value() for label in VEHICLE} == VEHICLE
    expect_record(page, {"number": "A-17", "vehicle": {label.lower(): value for label, value in VEHICLE.items()}})
    pages = pypdfium2.PdfDocument(download(page, "PDF"))
    printed = " ".join(each.get_textpage().get_text_range() for each in pages)
    for label in ("Make", "VIN"):
        assert re.search(rf"{re.escape(VEHICLE[label])}", printed)
    assert "Complaint" not in printed
    assert "Fault codes" not in printed


@pytest.mark.page("1_Job")
def test_what_is_typed_last_is_not_lost_by_leaving_the_page(page: Page) -> None:
    wait_until_idle(page)
    field(page, "Make").click()
    page.keyboard.type("Mercedes", delay=60)
    page.keyboard.press("Tab")
    page.keyboard.type("W210", delay=60)
    to(page, "Measure")  # straight from the field
    to(page, "Job")
    assert field(page, "Make").input_value() == "Mercedes"
    assert field(page, "Model").input_value() == "W210"
    expect_record(page, {"vehicle": {"make": "Mercedes", "model": "W210"}})


@pytest.mark.page("1_Job")
@pytest.mark.parametrize("held", [0, pytest.param(30, marks=pytest.mark.slow)])
def test_a_quick_click_on_a_link_straight_from_a_field_leads_to_its_page(page: Page, held: int) -> None:
    wait_until_idle(page)
    field(page, "Technician").click()
    page.keyboard.type("Anna", delay=60)
    step(page, "Diagnosis").click(delay=held)
    expect(page.locator(".st-key-answer")).to_be_visible()
    to(page, "Job")
    expect(field(page, "Technician")).to_have_value("Anna")


@pytest.mark.slow
def test_folds_stay_as_the_user_left_them(page: Page) -> None:
    to(page, "Job")
    fold = page.get_by_test_id("stExpander").filter(has_text="As found")
    assert opened(form(page))
    assert not opened(fold)
    fold.locator("summary").click()
    form(page).locator("summary").click()
    wait_until_idle(page)
    box = fold.get_by_role("textbox", name="Complaint")
    box.click()
    page.keyboard.type("late shift", delay=60)
    page.keyboard.press("Tab")
    page.keyboard.type("P0730", delay=60)
    page.keyboard.press("Tab")
    wait_until_idle(page)
    assert opened(fold)
    assert not opened(form(page))
    write(condition(page), "Temperature [°C]", "190")  # what is refused now stands above the form
    expect(page.get_by_text("These choices cannot be computed")).to_be_visible()
    wait_until_idle(page)
    assert opened(fold)
    assert not opened(form(page))
    to(page, "Measure")
    to(page, "Job")
    assert opened(fold)
    assert not opened(form(page))
    assert box.input_value() == "late shift"
    expect_record(page, {"complaint": "late shift", "fault_codes": ["P0730"]})


@pytest.mark.slow
def test_a_new_photo_can_be_captioned_at_once(page: Page) -> None:
    target = io.BytesIO()
    Image.new("RGB", (40, 30)).save(target, "PNG")
    to(page, "Job")
    fold = page.get_by_test_id("stExpander").filter(has_text="Logo and photos")
    fold.locator("summary").click()
    inputs = fold.get_by_test_id("stFileUploader").filter(has_text="Photos").locator("input[type=file]")
    inputs.set_input_files([{"name": "a.png", "mimeType": "image/png", "buffer": target.getvalue()}])
    caption = fold.get_by_role("textbox", name="Caption")
    expect(caption).to_be_visible()
    caption.click()
    page.keyboard.type("bore 25, scored", delay=60)
    page.keyboard.press("Tab")
    wait_until_idle(page)
    assert caption.input_value() == "bore 25, scored"
    expect_record(page, {"photos": [{"file": "photos/a.png", "caption": "bore 25, scored"}]})


def share(page: Page) -> str:
    """What the bar of the totals says: its conditions, the stated one first, and their shares."""
    return bar(page).text_content() or ""


def bar(page: Page) -> Locator:
    return page.locator(".js-plotly-plot").first


@pytest.mark.slow
def test_a_decimal_comma_is_the_decimal_sign(page: Page) -> None:
    fold = condition(page)
    write(fold, "Engine speed [rpm]", "850.5")
    expect(bar(page)).to_contain_text(re.compile(r"85[01] rpm"))
    wait_until_idle(page)
    with_point = share(page)
    write(fold, "Engine speed [rpm]", "2000")
    expect(bar(page)).not_to_have_text(with_point)
    write(fold, "Engine speed [rpm]", "850,5")
    expect(bar(page)).to_contain_text(re.compile(r"85[01] rpm"))
    wait_until_idle(page)
    assert share(page) == with_point
    assert fold.get_by_label("Engine speed [rpm]").input_value() == "850,5"
    assert fold.get_by_test_id("stAlert").count() == 0


@pytest.mark.parametrize(
    ("label", "text", "said"),
    [
        ("Mileage [km]", "123.456", "write 123456 for 123456 km, or 123.4560 for 123.456 km. No mileage is used."),
        pytest.param("Temperature [°C]", "", "80 °C stays in use", marks=pytest.mark.slow),
        pytest.param(
            "Engine speed [rpm]",
            "8505",
            "8505 rpm is taken, but unusual: the engine speed is mostly from 400 to 7000 rpm",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_doubt_stands_beneath_its_field_and_is_there_after_another_page(
    page: Page, label: str, text: str, said: str
) -> None:
    before = share(page)
    fold = condition(page)
    write(fold, label, text)
    doubt = fold.get_by_test_id("stAlert")
    expect(doubt).to_contain_text(said)
    wait_until_idle(page)
    box = fold.get_by_label(label)
    assert box.input_value() == text
    if "is taken" in said:
        expect(bar(page)).to_contain_text(f"{text} rpm")
    else:
        assert share(page) == before
    below, beside = doubt.bounding_box(), box.bounding_box()
    assert 0.0 <= below["y"] - (beside["y"] + beside["height"]) < 40.0
    to(page, "Measure")
    to(page, "Diagnosis")
    assert fold.get_by_label(label).input_value() == text
    expect(doubt).to_contain_text(said)
    assert page.get_by_test_id("stException").count() == 0


@pytest.mark.slow
def test_a_temperature_is_taken_as_it_was_written(page: Page) -> None:
    fold = condition(page)
    write(fold, "Temperature [°C]", "−5")
    expect(bar(page)).to_contain_text("-5 °C")
    wait_until_idle(page)
    assert fold.get_by_test_id("stAlert").count() == 0


def gauge(page: Page, cell: str) -> Locator:
    return page.get_by_role("textbox", name=f"{cell} [kPa]", exact=True)


@pytest.mark.slow
@pytest.mark.page("3_In_the_car")
def test_gauge_readings_typed_with_tab_stand_in_their_cells_and_stay(page: Page) -> None:
    unfold(page, "Type readings, or drop a table")
    wait_until_idle(page)
    values = {
        f"{selected}, {engine}": text
        for selected, texts in {"P": ("400", "", ""), "R": ("650,5", "720", ""), "N": ("405,25", "", "")}.items()
        for engine, text in zip(("slow idle", "fast idle", "stall"), texts, strict=True)
    }
    gauge(page, "P, slow idle").click()
    for value in values.values():
        page.keyboard.type(value, delay=60)
        page.keyboard.press("Tab")
    gauge(page, "D, slow idle").click()
    page.keyboard.type("300,5", delay=60)
    page.wait_for_timeout(500)  # the hand goes from the keyboard to the mouse
    to(page, "Diagnosis")
    expect(page.get_by_text("300 kPa where 412 kPa are the least")).to_be_visible()
    to(page, "In the car")
    for cell, text in {**values, "D, slow idle": "300,5"}.items():
        expect(gauge(page, cell)).to_have_value(text)
