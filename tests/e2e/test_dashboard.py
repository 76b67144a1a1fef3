"""What a technician does, in a browser."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from PIL import Image

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from atleak.report.tables.lands import CONDITION_WIDTH
from pages.shared import places
from pages.shared.show import PAIR_WIDTH

from .conftest import AT_REST, to, unfold

Visit = Callable[[str], Page]
SHEET = "component;part;plane;direction;diameter [mm]\n" + "".join(
    f"5;{part};1;{direction};{size}\n"
    for part, size in (("piston", "14.0"), ("sleeve", "14.07"))
    for direction in (0, 90)
)


def upload(page: Page, name: str, data: bytes) -> None:
    """Drop a file into the panel."""
    wait_until_idle(page)
    place = page.get_by_test_id("stSidebar").get_by_test_id("stFileUploader")
    place.locator("input[type=file]").set_input_files({"name": name, "mimeType": "", "buffer": data})


def status(page: Page, text: str | re.Pattern[str]) -> None:
    shown = page.get_by_test_id("stSidebar").get_by_text(text).locator("visible=true")  # its place hides a file taken
    expect(shown.first).to_be_visible()


def cells(page: Page, heading: str) -> list[str]:
    """The texts that are drawn of the cells of the table under a heading."""
    table = page.get_by_role("heading", name=heading).locator("xpath=following::*[@data-testid='stDataFrame'][1]")
    table_cells = table.locator("[data-testid^=glide-cell]")
    table_cells.first.wait_for(state="attached")
    return [text.strip() for text in table_cells.all_inner_texts()]


def flagged(page: Page) -> list[str]:
    """The texts of the flagged pairs' rows."""
    rows = page.locator("table.cards").first.locator("tbody tr")
    rows.first.wait_for()
    return rows.all_inner_texts()


def wait_until_idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def verdict(page: Page) -> str:
    return page.get_by_role("heading", level=1).inner_text()


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_a_fresh_start_shows_the_sample_jobs_flagged_pairs(page: Page) -> None:
    texts = flagged(page)
    assert any("■ replace" in text and "25/1 main pressure valve" in text for text in texts)
    assert any("▲ watch" in text for text in texts)
    assert "replace" in verdict(page)


def test_sorting_by_verdict_goes_by_severity(visit: Visit) -> None:
    order = visit("about:blank").evaluate(
        "texts => texts.sort((one, other) => one.localeCompare(other))",
        ["● ok", "\u200a" * 3 + "✖ critical", "\u200a▲ watch", "\u200a\u200a■ replace"],
    )
    assert [text.strip() for text in order] == ["✖ critical", "■ replace", "▲ watch", "● ok"]


@pytest.mark.parametrize("slower", [1, pytest.param(8, marks=pytest.mark.slow)])
def test_files_dropped_one_right_after_another_are_all_taken(
    page: Page, sample_readings: Path, sample_log: Path, slower: int
) -> None:
    side = page.get_by_test_id("stSidebar")
    files = [
        {"name": name, "mimeType": "", "buffer": path.read_bytes()}
        for name, path in (("drive.csv", sample_log), ("mine.xlsx", sample_readings))
    ]
    page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": slower})
    place = side.get_by_test_id("stFileUploader").locator("input[type=file]")
    for gap, order in ((0, files), (150, files[::-1])):  # [ms]
        side.get_by_role("button", name="New, empty job").press("Enter")  # a neighbour's tip may cover it
        for each in files:
            expect(side.get_by_text(each["name"]).locator("visible=true")).to_have_count(0)
        # the new job has a place of its own for files: one dropped before it is there would belong to the job before it
        status(page, "No measuring sheet")
        wait_until_idle(page)
        for each in order:
            place.set_input_files(each)
            page.wait_for_timeout(gap)
        status(page, re.compile("1201 rows"))
        status(page, "47 of 47 lands measured")


@pytest.mark.slow
def test_a_file_that_ends_its_reader_ends_nothing_else(
    visit: Visit, page: Page, server: str, sample_readings: Path, stray_workbook: bytes
) -> None:
    upload(page, "hostile.xlsx", stray_workbook)
    message = page.get_by_test_id("stMain").get_by_test_id("stAlert").first
    expect(message).to_contain_text("hostile.xlsx was not taken")
    expect(message).to_contain_text("delete what lies outside the table")
    other = visit(f"{server}/Diagnosis")
    other.get_by_text("Sample job: made-up data").wait_for()
    upload(other, "mine.xlsx", sample_readings.read_bytes())
    status(other, "mine.xlsx")


@pytest.mark.slow
@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_leaving_a_page_and_coming_back_keeps_the_job(page: Page, sample_readings: Path) -> None:
    upload(page, "mine.xlsx", sample_readings.read_bytes())
    status(page, "mine.xlsx")
    side = page.get_by_test_id("stSidebar")
    side.get_by_text("Stated condition and mileage").click()
    box = side.get_by_label("Temperature [°C]")
    box.fill("92.715")
    box.press("Enter")
    bar = page.locator(".js-plotly-plot").first
    expect(bar).to_contain_text("92.715 °C")
    wait_until_idle(page)
    before = verdict(page), flagged(page)
    to(page, "Measure")
    expect(page.get_by_text("376 readings in mm")).to_be_visible()
    to(page, "Diagnosis")
    expect(bar).to_contain_text("92.715 °C")
    wait_until_idle(page)
    assert (verdict(page), flagged(page)) == before
    status(page, "mine.xlsx")


@pytest.mark.page("6_Report")
def test_json_and_workbook_are_downloaded(page: Page) -> None:
    with page.expect_download() as waiting:
        page.get_by_role("button", name="JSON").click()
    record = json.loads(Path(waiting.value.path()).read_text(encoding="utf-8"))
    assert record["format"] == 1
    assert any(land["verdict"] == "replace" for land in record["lands"])
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Excel workbook").click()
    assert waiting.value.suggested_filename == "atleak.xlsx"
    assert "Lands" in openpyxl.load_workbook(io.BytesIO(Path(waiting.value.path()).read_bytes())).sheetnames


TWO_PRESSURES = (
    "time [s];engine_speed [rpm];line pressure 1 [kPa];line pressure 2 [kPa];ATF temperature [°C];gear\n"
    + "".join(f"{step / 10};800;{600 + step};{900 - step};80;2\n" for step in range(100))
)


@pytest.mark.slow
def test_a_log_settled_by_hand_goes_into_the_job_file_and_out_of_it(page: Page, sample_readings: Path) -> None:
    upload(page, "mine.xlsx", sample_readings.read_bytes())
    place = page.get_by_test_id("stSidebar").get_by_test_id("stFileUploader").locator("input[type=file]")
    place.set_input_files({"name": "two.csv", "mimeType": "", "buffer": TWO_PRESSURES.encode()})  # while that is read
    status(page, "mine.xlsx")
    status(page, "In the job book")
    expect(page.get_by_test_id("stSidebar").get_by_text("not taken.").first).to_be_visible()
    to(page, "In the car")
    main = page.get_by_test_id("stMain")
    expect(main.get_by_text("Which column is it?").first).to_be_visible()
    columns = main.get_by_role("combobox", name=re.compile(r"^.*main \(line\)"))
    columns.scroll_into_view_if_needed()
    columns.evaluate(AT_REST)  # its choices close where the page still moves
    columns.click()
    page.get_by_role("option", name="line pressure 2 [kPa]").click()
    main.get_by_role("button", name=re.compile("Use and remember")).click()
    status(page, re.compile("100 rows"))
    to(page, "Report")
    with page.expect_download() as waiting:
        main.get_by_role("button", name="Job file").click()
    job = Path(waiting.value.path()).read_bytes()
    side = page.get_by_test_id("stSidebar")
    side.get_by_role("button", name="Take the sample job").click()
    status(page, "minimum_acceleration_test.csv")
    upload(page, "job.zip", job)
    status(page, "two.csv")
    status(page, "mine.xlsx")
    to(page, "In the car")
    unfold(page, "The log in full")
    expect(main.get_by_text("As understood")).to_be_visible()
    wait_until_idle(page)
    assert "line pressure 2 [kPa]" in cells(page, "As understood")
    assert page.get_by_test_id("stException").count() == 0


@pytest.mark.page("3_In_the_car")
def test_dragging_across_the_log_sets_the_part_shown(page: Page) -> None:
    unfold(page, "The log in full")
    chart = page.locator("[data-testid=stPlotlyChart] .nsewdrag").first
    chart.wait_for()
    wait_until_idle(page)  # a script that still runs draws the chart anew and loses the drag
    chart.scroll_into_view_if_needed()
    page.evaluate(AT_REST, chart.element_handle())  # plotly lays itself out anew after scrolling
    cursors = page.get_by_test_id("stSliderThumbValue")
    first = cursors.filter(has_text=re.compile(r"^[23](\.\d+)?$"))
    for _ in range(3):  # on a busy machine the chart may be drawn anew in the middle of a drag: then one drags again
        box = chart.bounding_box()
        middle = box["y"] + box["height"] / 2.0
        page.mouse.move(box["x"] + 0.25 * box["width"], middle)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.40 * box["width"], middle + 5.0, steps=5)
        page.mouse.move(box["x"] + 0.50 * box["width"], middle + 5.0, steps=5)
        page.mouse.up()
        page.wait_for_timeout(2000)
        wait_until_idle(page)
        if first.count():
            break
    expect(first).to_have_count(1)
    expect(cursors.filter(has_text=re.compile(r"^[56](\.\d+)?$"))).to_have_count(1)
    expect(page.locator(".st-key-log-cursor dl div").first).to_contain_text("rpm")  # the cursor reads that part


@pytest.mark.page("3_In_the_car")
def test_one_cursor_reads_every_curve_of_the_log(page: Page, sample_log: Path) -> None:
    unfold(page, "The log in full")
    unfold(page, "Lay another log over it: before and after a repair")
    page.get_by_test_id("stMain").locator("input[type=file]").last.set_input_files(sample_log)
    values = page.locator(".st-key-log-cursor dl")
    speed = values.locator("div").filter(has_text="engine speed").locator("dd")
    expect(speed).to_contain_text(" | ")
    wait_until_idle(page)
    rows = [line.split(";") for line in sample_log.read_text(encoding="utf-8").splitlines()]
    slider, time = page.get_by_role("slider", name="Cursor"), page.locator(".st-key-log-cursor output")
    slider.focus()
    slider.press("Home")
    page.keyboard.press("ArrowRight")
    expect(time).to_have_text(f"{float(rows[2][0]):.2f} s")
    same = f"{float(rows[2][1]):.0f} rpm | {float(rows[2][1]):.0f} (0)"
    expect(speed).to_have_text(same)
    expect(values).to_contain_text("≥ ")  # the main pressure that is permitted
    expect(values).to_contain_text("dm³/min")  # the leakage
    chart = page.locator("[class*='st-key-channels-'] .nsewdrag").first
    chart.scroll_into_view_if_needed()
    page.evaluate(AT_REST, chart.element_handle())
    box = chart.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    middle = (float(rows[1][0]) + float(rows[-1][0])) / 2.0
    expect(time).to_have_text(re.compile(rf"^{middle:.0f}\.\d\d s$|^{middle - 1:.0f}\.\d\d s$"))
    assert slider.evaluate("each => each.getBoundingClientRect().top") >= 0.0  # in sight beside the curves


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_flagged_pairs_are_cards_on_a_phone_and_the_matrix_shows_two_conditions(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    card = page.locator("table.cards tbody tr").first
    card.wait_for()
    main = page.get_by_test_id("stMain")
    assert main.evaluate("element => element.scrollWidth <= element.clientWidth")
    for words in ("■ replace", "25/1 main pressure valve", "6.58"):
        box = card.get_by_text(words).first.bounding_box()
        assert box is not None
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= 390.0
    press = card.get_by_role("button").bounding_box()
    assert press is not None
    assert press["height"] >= 44.0
    page.get_by_text("All 47 lands", exact=True).click()
    by_condition = page.locator("h2", has_text="Lands at each condition")
    matrix = by_condition.locator("xpath=following::*[@data-testid='stDataFrame'][1]")
    matrix.locator("thead th").first.wait_for(state="attached")
    headings = [text.strip() for text in matrix.locator("thead th").all_inner_texts()]
    assert headings[:3] == ["Pair", "Driving in second, 80 °C [%]", "Hot idle in drive, 100 °C [%]"]
    assert matrix.bounding_box()["width"] + 2.0 >= PAIR_WIDTH + 2 * CONDITION_WIDTH


def test_every_page_opens_at_its_address_asks_no_other_host_and_the_console_stays_silent(
    visit: Visit, server: str
) -> None:
    page = visit("about:blank")
    wrong: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"{server}/Gauge_study?before=kept")  # an address of before leads to where the page is today
    expect(page.get_by_role("heading", name="Library", level=1)).to_be_visible()
    expect(page.get_by_role("radio", name="Gauge study")).to_be_checked()
    page.wait_for_url(re.compile(r"/Library\?(?=.*before=kept)(?=.*library=gauge_study)"))
    expect(page.get_by_test_id("stSidebar").get_by_text("Files of the job").first).to_be_visible()
    # Streamlit itself looks for its server beside a page's address first, which the console tells
    page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    for path in (*places.EVERY, places.page("Diagnosis")):
        address = places.name_of(path)
        to(page, address.replace("_", " "))
        assert page.get_by_test_id("stException").count() == 0
        assert page.url.partition("?")[0] == f"{server}/{address}"
    page.get_by_test_id("stPlotlyChart").first.wait_for()
    assert wrong == []
    assert not [url for url in asked if not url.startswith((server, "data:", "blob:", server.replace("http", "ws")))]


@pytest.mark.slow
def test_files_of_several_kinds_are_dropped_at_once_and_undone(visit: Visit, server: str, sample_log: Path) -> None:
    page = visit(server)
    page.get_by_test_id("stMain").get_by_role("button", name="New, empty job").click()
    expect(page.get_by_role("heading", name="Job", level=1)).to_be_visible()
    wait_until_idle(page)
    picture = io.BytesIO()
    Image.new("RGB", (40, 30)).save(picture, "PNG")
    files = {
        "hund.dat": SHEET.replace(".", ",").encode(),
        "katze.dat": sample_log.read_bytes(),
        "maus.dat": picture.getvalue(),
        "record.json": b'{"number": "2026-0417"}',
    }
    place = page.get_by_test_id("stSidebar").get_by_test_id("stFileUploader").locator("input[type=file]")
    place.set_input_files([{"name": name, "mimeType": "", "buffer": data} for name, data in files.items()])
    status(page, re.compile("hund.dat · 1 of 47 lands measured"))
    status(page, re.compile("katze.dat · 1201 rows"))
    wait_until_idle(page)
    expect(page.get_by_label("Job number").last).to_have_value("2026-0417")  # beside the old form for a moment
    page.get_by_text("Logo and photos").click()
    expect(page.get_by_role("textbox", name="Caption")).to_be_visible()
    page.locator(".st-key-away-readings button").first.click()
    status(page, "No measuring sheet yet")
    page.get_by_role("button", name="Undo: hund.dat taken away").click()
    status(page, re.compile("hund.dat · 1 of 47 lands measured"))
    assert page.get_by_test_id("stException").count() == 0
