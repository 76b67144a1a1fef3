"""How the pages of a whole report are filled, whatever the names, in every language and on every paper."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import pikepdf
import pypdfium2
import pytest
from PIL import Image

import atleak
from atleak.catalogue.controller_file import load_controller
from atleak.common.style import PAPERS
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.job.case import Case, SourceFile
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Reading, Readings
from atleak.report.pdf import write_pdf

LONG = "Hydraulischer Hauptdruck-Regelventilkolben mit Verstärkungshülse und Rückstellfeder"
SHORT = "Valve"
FILLED = 0.5  # of a page that is followed by another one
MARGIN = 40.0  # [pt] in which nothing stands; text begins at 42.5
FOOT = 0.93  # of the page's height, above which its footer begins


def job_of(name: str) -> Job:
    picture = io.BytesIO()
    Image.new("RGB", (40, 30), "#336699").save(picture, "PNG")
    work = ("proposed", "approved", "done", "declined", "deferred")
    return Job(
        number="2026-0417-with-a-long-number",
        date="2026-03-14",
        workshop={"name": f"{name} {name}", "address": f"{name}\n00-001 {name}", "email": "somebody@example.org"},
        customer={"name": name, "email": "a-long-address-without-any-space-in-it@example.org"},
        vehicle={"make": name, "model": name, "registration": "KR 1234", "vin": "WEXAMPLE123456789"},
        technician=name,
        approved_by=name,
        complaint=f"{name} shifts late when hot.",
        estimate={"currency": "EUR", "labour_rate": 80.0, "tax_percent": 23.0},
        repair_decisions=[
            {
                "component": "25",
                "land": number,
                "work": name,
                "decision": each,
                "reason": name,
                "price": 1234.5,
                "hours": 2,
            }
            for number, each in enumerate(work, start=1)
        ],
        photos=[{"file": "open.png", "caption": name}],
        scratches=[{"component": "25", "description": name, "part": "spool"}],
        notes=f"{name}. " * 8,
    ).with_pictures({"open.png": picture.getvalue()})


@pytest.fixture(scope="module")
def units(worn: Diagnosis, hipol, limits) -> Callable[[str, str], Diagnosis]:
    """The worn unit, and one with circuits of which every land is worn, with valves of one name."""

    @cache
    def named(unit: str, name: str) -> Diagnosis:
        if unit == "four_speed":
            components = MappingProxyType({key: f"{name} {key}" for key in worn.controller.components})
            return replace(worn, controller=replace(worn.controller, components=components))
        controller = load_controller(unit)
        components = MappingProxyType({key: f"{name} {key}" for key in controller.components})
        readings = [
            Reading(land.component, part, land.planes[0], direction, 1, land.nominal_diameter + wider)
            for number, land in enumerate(controller.lands)
            for part, wider in (("spool", 0.0), ("sleeve", (2.0 + number % 4) * land.mounting_high))
            for direction in (0.0, 90.0)
        ]
        sheet = Readings("sheet.xlsx", "0" * 64, "readings", "mm", False, "tidy", tuple(readings))
        complaint = controller.complaint("slips_hot")
        return diagnose(replace(controller, components=components), hipol, limits, readings=sheet, complaint=complaint)

    return named


class Pages:
    """What one report shows of its pages, read back."""

    def __init__(self, content: bytes) -> None:
        with pypdfium2.PdfDocument(content) as document:
            self.size = document[0].get_size()
            self.images = [np.asarray(page.render(scale=0.5, grayscale=True).to_pil()) for page in document]
            self.texts = [page.get_textpage().get_text_range() for page in document]
            self.covered = [(number, said) for number, page in enumerate(document, 1) for said in _covered(page)]
        with pikepdf.open(io.BytesIO(content)) as document:
            numbers = {page.objgen: number for number, page in enumerate(document.pages, 1)}
            self.blocks = list(_blocks(document.Root.StructTreeRoot, numbers))

    def outside(self) -> list[tuple[int, str]]:
        """Pages of which something stands in a margin."""
        edge = int(MARGIN / 2.0)
        sides = {"left": np.s_[:, :edge], "right": np.s_[:, -edge:], "top": np.s_[:10], "bottom": np.s_[-10:]}
        return [
            (number, side)
            for number, image in enumerate(self.images, start=1)
            for side, part in sides.items()
            if image[part].min() < 255
        ]

    def filled(self) -> list[float]:
        """How far down each page is filled above its footer."""
        rows = [np.flatnonzero(image[: int(FOOT * len(image))].min(axis=1) < 200) for image in self.images]
        return [float(found[-1]) / (FOOT * len(image)) for found, image in zip(rows, self.images, strict=True)]

    def left_alone(self) -> list[tuple[str, int]]:
        """Headings that end a page, and tables of which one row stands alone on a page."""
        alone = [
            (f"heading {here}", here)
            for (kind, (here, *_)), (_, (then, *_)) in pairwise(self.blocks)
            if kind == "/H2" and here != then
        ]
        for kind, rows in self.blocks:
            if kind == "/Table":
                places = [page for page in rows[1:] if page]  # without the head
                if rows[0] != places[0]:
                    alone.append(("head of a table", rows[0]))
                alone += [("row", page) for page in set(places) if places.count(page) == 1 < len(places)]
        return alone


def _covered(page: pypdfium2.PdfPage) -> Iterator[str]:
    """Words that another word covers: what no cell of a table may do to its neighbour."""
    written = page.get_textpage()
    boxes = np.array([written.get_rect(each) for each in range(written.count_rects())]).reshape(-1, 4)
    for place, (left, low, right, high) in enumerate(boxes):
        others = boxes[place + 1 :]
        across = np.minimum(right, others[:, 2]) - np.maximum(left, others[:, 0])
        up = np.minimum(high, others[:, 3]) - np.maximum(low, others[:, 1])
        least = np.minimum(high - low, others[:, 3] - others[:, 1])
        if ((across > 1.0) & (up > 0.5 * least)).any():
            yield written.get_text_bounded(left, low, right, high)


def _blocks(node: pikepdf.Object, numbers: dict[tuple[int, int], int]) -> Iterator[tuple[str, list[int]]]:
    """Everything that stands by itself, with its pages: of a table those of each row, its head first."""
    for child in _children(node):
        kind = str(child.get("/S", ""))
        if kind == "/Table":
            yield kind, [min(_pages(row, numbers), default=0) for row in _rows(child)]
        elif kind in ("/H1", "/H2", "/P", "/Figure", "/L"):
            yield kind, sorted(_pages(child, numbers)) or [0]
        else:
            yield from _blocks(child, numbers)


def _rows(node: pikepdf.Object) -> Iterator[pikepdf.Object]:
    for child in _children(node):
        if str(child.get("/S", "")) == "/TR":
            yield child
        else:
            yield from _rows(child)


def _children(node: pikepdf.Object) -> list[pikepdf.Dictionary]:
    children = node.get("/K", ())
    children = children if isinstance(children, pikepdf.Array) else (children,)
    return [each for each in children if isinstance(each, pikepdf.Dictionary)]


def _pages(node: pikepdf.Object, numbers: dict[tuple[int, int], int]) -> set[int]:
    """The pages on which something of a tagged element stands."""
    own = {numbers[node.Pg.objgen]} if "/Pg" in node else set()
    return own.union(*(_pages(child, numbers) for child in _children(node)))


def check(pages: Pages, language: str, paper: str) -> None:
    say = wording(language)
    assert [round(side) for side in pages.size] == ([595, 842] if paper == "a4" else [612, 792])
    assert pages.outside() == []
    assert pages.covered == []
    assert pages.left_alone() == []
    behind = say("customer.follows", part=say("documents.workshop"))
    of_customer = next(number for number, text in enumerate(pages.texts, start=1) if behind in text)
    before_annex = next((number for number, text in enumerate(pages.texts) if say("documents.annex") in text), 0)
    filled = [each for each in enumerate(pages.filled(), start=1) if each[0] not in (of_customer, before_annex)]
    assert [(number, round(part, 2)) for number, part in filled[:-1] if part < FILLED] == []
    assert say("customer_screen.title") in pages.texts[0]
    assert of_customer <= 2
    assert say("texts.sign_customer") in pages.texts[of_customer - 1]
    assert say("texts.sign_approver") in pages.texts[of_customer - 1]


QUICK = [("four_speed", "en", "a4", LONG)]
ALL = [  # every unit in every language, every language on every paper; long names and short ones by turns
    (unit, language, [*PAPERS][(turn + number) % len(PAPERS)], (LONG, SHORT)[number % 2])
    for turn, unit in enumerate(("four_speed", "gm_4l60e"))
    for number, language in enumerate(languages())
]
SLOW = [pytest.param(*each, marks=pytest.mark.slow) for each in ALL if each not in QUICK]


@pytest.mark.parametrize(("unit", "language", "paper", "name"), [*QUICK, *SLOW])
def test_nothing_is_cut_covered_or_left_alone_and_no_page_is_mostly_empty(
    units: Callable[[str, str], Diagnosis], unit: str, language: str, paper: str, name: str
) -> None:
    check(Pages(write_pdf(units(unit, name), job_of(name), language=language, paper=paper)), language, paper)


def test_in_us_units_nothing_is_cut_or_covered_and_small_uncertainties_have_digits(
    units: Callable[[str, str], Diagnosis],
) -> None:
    pages = Pages(write_pdf(units("four_speed", SHORT), job_of(SHORT), units="us"))
    assert pages.outside() == []
    assert pages.covered == []
    budgets = next(text for text in pages.texts if "c · u(x)" in text)
    assert "µin" in budgets
    assert "0.000000" not in budgets
    assert not re.search(r"\d\s(µm|K)\b|/K\b", budgets)


READERS = [
    {"language": "en"},
    *(
        pytest.param(each, marks=pytest.mark.slow)
        for each in (
            {"language": "de", "units": "metric_bar"},
            {"language": "pl"},
            {"language": "en", "units": "us", "paper": "letter"},
        )
    ),
]


@pytest.fixture(scope="module", params=["sample", "wreck"])
def full(request, four_speed, hipol, limits, sample_readings, sample_log) -> tuple[Diagnosis, Job]:
    """All that a job of 47 lands can hold: the sample's sheet, or one of which every land is worn."""
    sheet = atleak.read_readings(sample_readings, four_speed)
    if request.param == "wreck":
        wider = {land.key: (2.0 + number % 4) * land.mounting_high for number, land in enumerate(four_speed.lands)}
        readings = [
            Reading(key[0], part, four_speed.land(*key).planes[0], direction, repeat, diameter + repeat * 0.4e-6)
            for key, wide in wider.items()
            for part, more in (("spool", 0.0), ("sleeve", wide))
            for diameter in (four_speed.land(*key).nominal_diameter + more,)
            for direction in (0.0, 90.0)
            for repeat in (1, 2)
        ]
        sheet = replace(sheet, readings=tuple(readings))
    ranges = [("P", 640), ("R", 980), ("N", 640), ("D", 600), ("3", 610)]
    gauges = "\n".join(("range;state;pressure [kPa]", *(f"{name};slow idle;{shown}" for name, shown in ranges)))
    case = Case(
        road_test=SourceFile.at(sample_log), pressures=SourceFile("gauges.csv", gauges.encode()), complaint="slips_hot"
    )
    found = diagnose(
        four_speed,
        hipol,
        limits,
        readings=sheet,
        road_test=atleak.read_road_test(sample_log),
        pressures=case.diagnose().pressures.table,
        complaint=four_speed.complaint("slips_hot"),
        mileage_km=106_315.0,
    )
    assert len(found.lands) == 47
    picture = io.BytesIO()
    Image.new("RGB", (400, 300), "#336699").save(picture, "PNG")
    proposed = (("25", "ream and fit oversize spool", 180.0, 2.0), ("26", "new sleeve", 90.0, 1.0))
    job = Job(
        number="2026-0417",
        date="2026-03-14",
        technician="B. Nowak",
        complaint="Shifts late from first to second when hot, and a jerk at the lights.",
        workshop={"name": "Łódź Automaty", "address": "ul. Długa 12\n00-001 Łódź", "phone": "+48 42 555 01 01"},
        customer={"name": "Ana Lima"},
        vehicle={"make": "Volvo", "model": "S60", "registration": "PO 1234"},
        estimate={"currency": "EUR", "labour_rate": 80.0, "tax_percent": 23.0},
        repair_decisions=[
            {"component": component, "work": work, "price": price, "hours": hours, "decision": "proposed"}
            for component, work, price, hours in proposed
        ],
        photos=[{"file": "bore.png", "component": "25", "caption": "scored bore"}],
    ).with_pictures({"bore.png": picture.getvalue()})
    return found, job


@pytest.mark.parametrize("reader", READERS)
def test_of_47_lands_a_workshop_report_has_four_pages_and_the_annex_eight_at_most(
    full: tuple[Diagnosis, Job], reader: dict[str, str]
) -> None:
    found, job = full
    pages = {name: Pages(write_pdf(found, job, document=name, **reader)) for name in ("workshop", "annex")}
    assert len(pages["workshop"].texts) <= 4
    assert len(pages["annex"].texts) <= 8
    for each in pages.values():
        assert each.outside() == []
        assert each.covered == []
        assert each.left_alone() == []
