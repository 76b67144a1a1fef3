"""The pages under a finger, and on paper."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from .conftest import AT_REST, SOON, playwright_api, unfold

pypdfium2 = pytest.importorskip("pypdfium2")
axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()

SWIPE = 210  # [px]
LEAST_MOVED = 150  # [px] that the page moves by it
LEAST_TARGET = 44  # [px]
STREAMLITS = {"presentation-role-conflict", "region"}  # of its place for files, of what it lays over the page
SCROLLED = "document.querySelector('[data-testid=stMain]').scrollTop"
# Buttons, links to pages and folds that are smaller than a finger.
TOUCHED = "[data-testid^=stBaseButton], summary, [data-testid=stMainMenuButton], [data-testid=stPageLink-NavLink]"
SMALL = f"""() => [...document.querySelectorAll("{TOUCHED}")]
    .filter(each => each.offsetParent && each.checkVisibility({{opacityProperty: true, visibilityProperty: true}}))
    .map(each => [each.getBoundingClientRect(), each.innerText || each.dataset.testid])
    .filter(([box]) => box.right > 0 && Math.min(box.width, box.height) < {LEAST_TARGET})
    .map(([box, name]) => `${{name}}: ${{box.width}} x ${{box.height}}`)"""

# What lies over something else: a button over a button, a link over a link, a tab's words over another's, a table's
# toolbar over what it belongs to or stands below.
OVER = """() => {
    const shown = kind => [...document.querySelectorAll(kind)]
        .filter(each => each.checkVisibility({opacityProperty: true, visibilityProperty: true}))
        .map(each => {
            const words = document.createRange()
            words.selectNodeContents(each)
            return [each, (each.role === "tab" ? words : each).getBoundingClientRect()]
        })
    const depth = (a, b) => Math.min(
        Math.min(a.right, b.right) - Math.max(a.left, b.left), Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top))
    const lies = ([a, box], [b, other]) => a !== b && !a.contains(b) && !b.contains(a) && depth(box, other) > 1
    const name = ([each, box]) => `${each.innerText || each.ariaLabel || each.dataset.testid} ${JSON.stringify(box)}`
    const over = (upper, lower) => upper.flatMap(
        each => lower.filter(other => lies(each, other)).map(other => `${name(each)} over ${name(other)}`))
    const main = "[data-testid=stMain]", texts = ["h1", "h2", "h3", "p", "li", "label", "summary", "canvas", "img"]
    const alike = [main, "[data-testid=stSidebar]", "[data-testid=stHeader]"].flatMap(
        place => ["button:not([role=tab])", "[role=tab]", "[data-testid=stPageLink-NavLink]"].map(
            kind => shown(`${place} ${kind}`)))
    return alike.flatMap(kind => over(kind, kind))
        .concat(over(shown(`${main} [data-testid=stElementToolbar]`), shown(`${main} :is(${texts})`)))
}"""
JOB, OTHERS = (  # the pages of a job, and all others
    sorted(path.stem for path in Path(__file__).parents[2].joinpath("pages").glob(numbered))
    for numbered in ("[1-9]_*.py", "[1-9][0-9]_*.py")
)
# Goes to a page as the browser's own buttons do.
GO = "name => { history.pushState({}, '', name + location.search); dispatchEvent(new PopStateEvent('popstate')) }"
ANOTHER = "heading => ![heading, undefined].includes(document.querySelector('h1')?.innerText)"


def against_everyone(page: playwright_api.Page) -> list[tuple[str, str]]:
    """What keeps someone from reading or using the page, once its own parts have drawn themselves."""
    against: list[tuple[str, str]] = []
    for _ in range(10):
        violations = axe.run(page).response["violations"]
        against = [(each["id"], each["nodes"][0]["html"]) for each in violations if each["id"] not in STREAMLITS]
        if not against:
            break
        page.wait_for_timeout(1000)
    return against


@pytest.mark.parametrize(
    ("job", "scheme", "pages"),
    [
        ("sample", "dark", JOB),
        pytest.param("sample", "dark", OTHERS, marks=pytest.mark.slow),
        pytest.param("empty", "light", [*JOB, *OTHERS], marks=pytest.mark.slow),
    ],
    ids=["the sample's pages", "other pages", "an empty job"],
)
def test_every_page_is_for_everyone_and_nothing_lies_over_what_is_touched(
    browser: playwright_api.Browser, server: str, job: str, scheme: str, pages: list[str]
) -> None:
    context = browser.new_context(
        viewport={"width": 820, "height": 1180}, has_touch=True, is_mobile=True, color_scheme=scheme
    )
    context.set_default_timeout(SOON)
    page, found = context.new_page(), {}  # by page, or by page and width
    sample, idle = page.get_by_text("Sample job: made-up data"), "stApp][data-test-script-state=notRunning"
    page.goto(f"{server}/Settings")
    sample.wait_for()
    if job == "empty":
        page.get_by_role("button", name="New, empty job").tap()
        sample.wait_for(state="detached")
    for stem in pages:
        name, heading = stem.partition("_")[2], page.locator("h1").first.inner_text()
        if not page.url.partition("?")[0].endswith(f"/{name}"):
            page.evaluate(GO, f"/{name}")
            page.wait_for_function(ANOTHER, arg=heading)
        page.locator(f"[data-testid={idle}]").wait_for()
        if against := against_everyone(page):
            found[name] = against
        for width in (820, 390):
            page.set_viewport_size({"width": width, "height": 1180})
            page.wait_for_timeout(300)  # the panel moves
            if over := page.evaluate(OVER):
                found[name, width] = over
        page.set_viewport_size({"width": 820, "height": 1180})
    context.close()
    assert found == {}


# The steps of the job that stand on the screen, whole and over all else, and the height of the page.
SEEN = """() => [...document.querySelectorAll(".st-key-steps a")].slice(0, 6).filter(each => {
    const {left, right, top, bottom} = each.getBoundingClientRect()
    return left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight
        && each.contains(document.elementFromPoint((left + right) / 2, (top + bottom) / 2))
}).map(each => each.innerText.split(" · ")[0])"""
HEIGHT = "document.querySelector('[data-testid=stMainBlockContainer]').getBoundingClientRect().height"
STEPS = ["Job", "Measure", "In the car", "Diagnosis", "Plan", "Report"]


def test_a_diagnosis_stands_on_one_screen_and_on_three_of_a_phone(browser: playwright_api.Browser, server: str) -> None:
    screens = (((1366, 700), False, 900), ((820, 1180), True, 2000), ((390, 800), True, 3 * 800))
    for size, touched, most in screens:
        context = browser.new_context(
            viewport=dict(zip(("width", "height"), size, strict=True)), has_touch=touched, is_mobile=touched
        )
        context.set_default_timeout(SOON)
        page = context.new_page()
        page.goto(f"{server}/Diagnosis")
        page.locator(".js-plotly-plot").first.wait_for()
        page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()
        page.locator(".st-key-steps").evaluate(AT_REST)
        assert page.evaluate(SEEN) == STEPS, size
        assert page.evaluate(HEIGHT) <= most, size
        assert not touched or page.evaluate(SMALL) == [], size
        context.close()


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_a_finger_scrolls_over_a_chart_and_finds_what_it_touches(
    browser: playwright_api.Browser, server: str, scheme: str
) -> None:
    context = browser.new_context(
        viewport={"width": 390, "height": 800}, has_touch=True, is_mobile=True, color_scheme=scheme
    )
    context.set_default_timeout(SOON)
    page = context.new_page()
    page.goto(f"{server}/Road_test")  # an address of before leads to where a mouse that drags marks a stretch
    unfold(page, "The log in full")
    chart = page.locator(".js-plotly-plot").first
    chart.wait_for()
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()
    chart.evaluate("chart => chart.scrollIntoView({block: 'center'})")
    playwright_api.expect(chart.locator(".nsewdrag").first).to_be_attached()
    box, before = chart.bounding_box(), page.evaluate(SCROLLED)
    assert box is not None
    fingers = context.new_cdp_session(page)
    x, y = box["x"] + box["width"] / 2, 600
    fingers.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    for moved in range(0, SWIPE + 1, 10):
        touch = {"type": "touchMove", "touchPoints": [{"x": x, "y": y - moved}]}
        fingers.send("Input.dispatchTouchEvent", touch)
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_function(f"{SCROLLED} > {before + LEAST_MOVED}", timeout=20_000)
    assert page.evaluate(SMALL) == []
    context.close()


@pytest.mark.slow
@pytest.mark.page("5_Plan?plan=what_if")
def test_on_paper_stands_the_page_alone_and_nothing_is_cut(page: playwright_api.Page, tmp_path: Path) -> None:
    page.locator(".js-plotly-plot").first.wait_for()
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()
    target = tmp_path / "page.pdf"
    page.pdf(path=target, format="A4", print_background=True, margin=dict.fromkeys(("left", "right"), "10mm"))
    printed = pypdfium2.PdfDocument(target)
    texts = [sheet.get_textpage() for sheet in printed]
    words = "\n".join(text.get_text_range() for text in texts)
    assert "Try this unit at another temperature" in words
    for of_panel in ("Files of the job", "Take the sample job", "Deploy"):
        assert of_panel not in words
    assert re.search(r"ATF temperature", words)
    for sheet, text in zip(printed, texts, strict=True):  # the last tick of an axis stands on the sheet, whole
        right = max((text.get_charbox(at)[2] for at in range(text.count_chars())), default=0.0)
        assert right <= sheet.get_width()
    ends = [line for line in words.split() if line == "140"]
    assert len(ends) >= 1
