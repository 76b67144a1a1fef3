"""Verdicts on the photo of a valve body: a leader to each bore that is flagged, no label on another or cut off."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

import pytest
from PIL import Image

from atleak.catalogue.castings import Casting, keep_casting
from atleak.common.style import look_of
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.charts.casting import casting_drawing
from atleak.report.customer_screen import written
from atleak.report.pdf import write_pdf
from atleak.report.pdf.customer_screen import customer_screen
from atleak.report.tables.lands import component_verdict, leader
from tests.unit.report.read_back import squeezed, text_of

SVG = "{http://www.w3.org/2000/svg}"
EN = wording("en")
Box = tuple[float, float, float, float]  # edges: left, upper, right, lower


def photo(width: int, height: int) -> Casting:
    target = io.BytesIO()
    Image.new("RGB", (width, height), "grey").save(target, "PNG")
    return Casting.of_photo("casting.png", target.getvalue())


LAYOUTS: dict[str, Callable[[int, int], tuple[float, float]] | None] = {
    "in rows": lambda number, count: (0.1 + 0.8 * (number % 3) / 2, number / count),
    "one above another at the left": lambda number, count: (0.05, number / count),
    "all in one place": lambda number, count: (0.5, 0.5),
    "at the right lower corner": lambda number, count: (1.0, 1.0),
    "nowhere": None,
}


def marked(diagnosis: Diagnosis, size: tuple[int, int], layout: str) -> Casting:
    names = list(diagnosis.controller.components)
    place = LAYOUTS[layout]
    return photo(*size).marked({name: place(number, len(names)) for number, name in enumerate(names) if place})


def boxes_of(svg: str) -> list[Box]:
    """The labels of a drawing."""
    found = (
        [float(box.attrib[each]) for each in ("x", "y", "width", "height")]
        for box in ElementTree.fromstring(svg).iter(f"{SVG}rect")
    )
    return [(x, y, x + width, y + height) for x, y, width, height in found]


def flagged_of(diagnosis: Diagnosis) -> set[str]:
    return {land.key[0] for land in diagnosis.flagged}


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("size", [(400, 300), (300, 400), (900, 60), (30, 900)])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_labels_lie_on_no_other_and_within_the_picture(
    worn: Diagnosis, layout: str, size: tuple[int, int], language: str
) -> None:
    svg = casting_drawing(marked(worn, size, layout), worn, wording(language)).svg
    left, top, width, height = map(float, ElementTree.fromstring(svg).attrib["viewBox"].split())
    boxes = boxes_of(svg)
    assert len(boxes) == len(flagged_of(worn))
    for one, other in itertools.combinations(boxes, 2):
        assert one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
    assert all(left <= box[0] and top <= box[1] and box[2] <= left + width and box[3] <= top + height for box in boxes)


@pytest.mark.parametrize("layout", [name for name, place in LAYOUTS.items() if place])
def test_each_flagged_bore_has_a_leader_from_its_label_to_its_mark(worn: Diagnosis, layout: str) -> None:
    casting = marked(worn, (400, 300), layout)
    tree = ElementTree.fromstring(casting_drawing(casting, worn, EN).svg)
    shown = {name: float(tree.find(f"{SVG}image").attrib[name]) for name in ("x", "y", "width", "height")}
    lines = {path.attrib["d"] for path in tree.iter(f"{SVG}path") if path.get("class") == "leader"}
    ends = [[tuple(map(float, point.split())) for point in line.strip("M").split("L")] for line in lines]
    for name in flagged_of(worn):
        across, down = casting.marks[name]
        bore = shown["x"] + across * shown["width"], shown["y"] + down * shown["height"]
        assert any(end == pytest.approx(bore, abs=0.1) for _, end in ends), name
    edges = {round(edge, 1) for box in boxes_of(casting_drawing(casting, worn, EN).svg) for edge in (box[0], box[2])}
    assert {start[0] for start, _ in ends} <= edges
    assert len(ends) == len(flagged_of(worn))


def test_a_bore_has_the_worst_verdict_of_its_lands_by_sign_and_word_too(worn: Diagnosis) -> None:
    tree = ElementTree.fromstring(casting_drawing(marked(worn, (400, 300), "in rows"), worn, EN, pressed=True).svg)
    bores = {group.attrib["data-pair"]: group for group in tree.iter(f"{SVG}g") if "data-pair" in group.attrib}
    assert set(bores) == {land.component for land in worn.controller.lands}
    for name, bore in bores.items():
        verdict = component_verdict(worn, name)
        assert EN.signed(verdict) in bore.attrib["aria-label"]
        signs = [sign.attrib["fill"] for sign in bore.iter(f"{SVG}polygon")]
        assert bool(signs) == verdict.flagged
        assert not signs or look_of(verdict).on_fill in signs
        said = [leader(worn, land, EN) for land in worn.flagged if land.key[0] == name]
        assert all(each in bore.attrib["aria-label"] for each in said)
    assert not [
        group
        for group in ElementTree.fromstring(casting_drawing(photo(4, 3), worn, EN).svg).iter()
        if "data-pair" in group.attrib
    ]


def test_a_flagged_bore_without_a_mark_stands_below_the_photo(worn: Diagnosis) -> None:
    name = next(iter(flagged_of(worn)))
    casting = photo(400, 300).marked({name: (0.5, 0.5), "of another description": (0.1, 0.1)})
    tree = ElementTree.fromstring(casting_drawing(casting, worn, EN).svg)
    shown = tree.find(f"{SVG}image")
    below = [box for box in boxes_of(casting_drawing(casting, worn, EN).svg) if box[1] > float(shown.attrib["height"])]
    assert len(below) == len(flagged_of(worn)) - 1
    assert EN("casting.unmarked") in [text.text for text in tree.iter(f"{SVG}text")]


def test_names_of_a_workshops_own_stay_text(worn: Diagnosis, hostile: tuple[str, ...]) -> None:
    for text in hostile:
        named = MappingProxyType(dict.fromkeys(worn.controller.components, text))
        other = replace(worn, controller=replace(worn.controller, components=named))
        drawn = casting_drawing(marked(other, (400, 300), "in rows"), other, EN, pressed=True)
        kinds = {element.tag.rpartition("}")[2] for element in ElementTree.fromstring(drawn.html).iter()}
        drawn_with = {"svg", "title", "image", "path", "g", "circle", "polygon", "rect", "text"}
        assert kinds <= {*drawn_with, "div", "style", "button", "span", "b"}


def test_the_customer_and_the_pdf_are_shown_the_photo_that_the_workshop_keeps(own_home: Path, worn: Diagnosis) -> None:
    leaders = [leader(worn, land, EN) for land in worn.flagged]

    def shown() -> tuple[str, str]:
        return unescape(written(customer_screen(worn, Job()))), squeezed(text_of(write_pdf(worn, sections=["picture"])))

    html, pdf = shown()
    assert EN("customer.schematic") in html
    assert squeezed(EN("casting.schematic")) in pdf
    casting = marked(worn, (400, 300), "in rows")
    keep_casting(worn.controller.id, casting)
    html, pdf = shown()
    assert casting.photo in html
    assert html.count('class="leader"') == 2 * len(flagged_of(worn))
    assert all(each in html for each in leaders)
    assert all(squeezed(each) in pdf for each in leaders)
    assert EN("customer.schematic") not in html
    assert not re.search(r"(?:src|href)=\"(?!data:)", html), "the page needs nothing else"
    urgent = dict.fromkeys(flagged_of(worn), Verdict.WATCH)
    assert look_of(Verdict.WATCH).line in casting_drawing(casting, worn, EN, verdicts=urgent).svg
