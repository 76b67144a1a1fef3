"""Every picture that is kept is shown, every one that is shown is kept, and diagrams are what is drawn today."""

from __future__ import annotations

import re
import struct
import tomllib
from collections.abc import Callable
from importlib import import_module
from types import ModuleType

import pytest

from atleak.common.units import UM
from tests.unit.docs.pages import ROOT, links, pages, text_of

PICTURES = ROOT / "docs" / "pictures"
KEPT = sorted(path for path in PICTURES.iterdir() if path.suffix in (".png", ".svg"))
LARGEST = 150_000  # bytes of a photograph of the screen
LARGEST_DRAWING = 60_000  # bytes
WIDEST = 1200  # [px]


@pytest.fixture
def tool(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """Imports one of the tools as it is when it runs."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return import_module


def shown() -> set[str]:
    """The names of all pictures of the folder that pages show."""
    found = (re.search(r"(?:^|/)pictures/([\w.-]+)$", link) for page in pages() for link in links(text_of(page)))
    return {name[1] for name in found if name}


def test_pages_show_all_pictures_that_are_kept_and_no_others() -> None:
    assert {path.name for path in PICTURES.iterdir()} == shown()
    assert len(KEPT) > 20


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.name)
def test_a_picture_is_small_and_no_wider_than_a_page(path) -> None:
    content = path.read_bytes()
    if path.suffix == ".svg":
        assert len(content) <= LARGEST_DRAWING
        assert b"<svg" in content[:600]
        assert b"#FFFFFF" in content[:1200]  # its own ground, so that it can be read on a dark page
        return
    width, height = struct.unpack(">II", content[16:24])
    assert len(content) <= LARGEST
    assert 300 <= width <= WIDEST
    assert 100 <= height <= 2600


@pytest.mark.parametrize(
    "name", [pytest.param("eccentricity", marks=pytest.mark.slow), "gap", "spool-measuring", "pressure-distribution"]
)
def test_a_diagram_is_drawn_again_as_it_is_kept(tool: Callable[[str], ModuleType], name: str) -> None:
    diagrams = tool("diagrams")
    assert diagrams.same(diagrams.DIAGRAMS[name](), (PICTURES / f"{name}.svg").read_text(encoding="utf-8"))


def test_the_visits_that_pictures_compare_are_those_of_the_tutorial(tool: Callable[[str], ModuleType]) -> None:
    page = text_of("docs/before-and-after.md")
    jobs = tool("picture_jobs")
    (_, before, _), (_, after, record) = jobs.visits()
    for key in (*jobs.REPAIRED, ("17", 2)):
        (was,), (now,) = ([land for land in unit.lands if land.key == key] for unit in (before, after))
        widths = [f"{land.state.radial_clearance * UM:.1f} µm" for land in (was, now)]
        assert re.search(rf"^\| {key[0]}/{key[1]} [^|]+ \| {widths[0]} \| {widths[1]} \|", page, re.MULTILINE), widths
    (stated,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    done = [each.model_dump(exclude_unset=True) for each in record.repair_decisions]
    assert done == tomllib.loads(stated)["repair_decisions"]


def test_drawings_with_another_word_or_another_place_are_not_the_same(tool: Callable[[str], ModuleType]) -> None:
    same = tool("diagrams").same
    drawing = '<text x="10.02" y="5">6.6 %</text>'
    assert same(drawing, drawing.replace("10.02", "10.04"))
    assert not same(drawing, drawing.replace("10.02", "11.02"))
    assert not same(drawing, drawing.replace("6.6", "6.8"))
    assert not same(drawing, drawing.replace("%", "dm"))


def test_a_chart_is_the_same_where_another_version_of_matplotlib_writes_it(tool: Callable[[str], ModuleType]) -> None:
    same = tool("diagrams").same
    chart = (
        '<svg xmlns="http://www.w3.org/2000/svg"><g id="matplotlib.axis_1"><path d="M 52 196 L 490 12" '
        'style="fill: none; stroke: #b8c2cb" clip-path="url(#one)"/>'
        '<path d="M 10 20 \nL 10 5 \nL 30 5 \nL 30 20 \nz\n"/>'
        '<text x="116.9" y="224.6" style="font-size: 9px; fill: #1b2733">1.5 %</text></g></svg>'
    )
    other = chart.replace("font-size: 9px; fill: #1b2733", "fill: #1b2733; font: 9px").replace("#one", "#other")
    assert same(chart, other.replace("224.6", "221.8"))
    assert same(chart, other.replace("L 10 5 \nL 30 5 \nL 30 20 ", "L 30 20 \nL 30 5 \nL 10 5 "))
    for drawn, instead in (
        ("490 12", "490 14"),
        ("L 30 5", "L 30 9"),
        ("#b8c2cb", "#b8c2cc"),
        ("1.5 %", "1.6 %"),
        ("224.6", "240.6"),
    ):
        assert drawn in other
        assert not same(chart, other.replace(drawn, instead))


def test_a_picture_of_something_else_differs_clearly_and_a_little_noise_does_not(
    tool: Callable[[str], ModuleType],
) -> None:
    pytest.importorskip("playwright.sync_api")
    image = pytest.importorskip("PIL.Image")
    difference = tool("screenshots").difference
    kept = image.new("RGB", (320, 240), "#FFFFFF")
    kept.paste("#102030", (20, 40, 200, 60))
    moved, noisy = kept.copy(), kept.copy()
    moved.paste("#102030", (20, 140, 60, 160))
    noisy.paste("#FDFDFD", (0, 100, 320, 200))
    assert difference(noisy, kept) == ""
    assert "255 shades" in difference(moved, kept)
    assert "height" in difference(kept.resize((320, 280)), kept)
