"""How the pages of the printed report are set: nothing over its edge, nothing left alone, no small print."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import pypdfium2
import pypdfium2.raw as pdfium
import pytest

from atleak.diagnosis import Diagnosis, diagnose
from atleak.job.record import Job
from atleak.report.pdf import write_pdf
from atleak.report.pdf.blocks import PrintedColumn, grouped_table, table, text, with_notes
from atleak.wording import languages

LEAST = 8.9  # [pt]: 9 pt as the file rounds it
SECTIONS = ("flagged", "matrix", "all", "repair", "signatures")
NAMED = "Hydraulischer Hauptdruck-Regelventilkolben mit Verstärkungshülse und Rückstellfeder"


def sizes(content: bytes) -> Iterator[tuple[int, float, str]]:
    """Page, size [pt] and letter of everything that is printed in words."""
    with pypdfium2.PdfDocument(content) as document:
        for number, page in enumerate(document, start=1):
            written = page.get_textpage()
            letters = written.get_text_range()
            for place, letter in enumerate(letters[: pdfium.FPDFText_CountChars(written)]):
                if letter.isalnum():
                    yield number, pdfium.FPDFText_GetFontSize(written, place), letter


@pytest.fixture(scope="module")
def long_named(worn: Diagnosis) -> Diagnosis:
    """The worn unit, its valves under names as long as a line."""
    named = MappingProxyType({key: f"{NAMED} {key}" for key in worn.controller.components})
    controller = replace(worn.controller, components=named)
    return diagnose(controller, worn.fluid, worn.limits, readings=worn.readings)


def test_tables_and_sentences_are_no_smaller_than_9_points(worn):
    content = write_pdf(worn, Job(number="1", customer={"name": "A. Customer"}), sections=["flagged", "all", "limits"])
    small = [(page, size, letter) for page, size, letter in sizes(content) if page > 1 and size < LEAST]
    assert small == []


def overflowing(content: bytes) -> list[tuple[int, str]]:
    """Words that another word covers, by page: what no cell of a table may do to its neighbour."""
    covered = []
    with pypdfium2.PdfDocument(content) as document:
        for number, page in enumerate(document, start=1):
            written = page.get_textpage()
            boxes = [written.get_rect(each) for each in range(written.count_rects())]
            for place, (left, low, right, high) in enumerate(boxes):
                for other_left, other_low, other_right, other_high in boxes[place + 1 :]:
                    across = min(right, other_right) - max(left, other_left)
                    up = min(high, other_high) - max(low, other_low)
                    if across > 1.0 and up > 0.5 * min(high - low, other_high - other_low):
                        covered.append((number, written.get_text_bounded(left, low, right, high)))
    return covered


@pytest.mark.parametrize("paper", ["a4", pytest.param("letter", marks=pytest.mark.slow)])
@pytest.mark.parametrize("language", languages())
def test_no_cell_runs_into_its_neighbour_however_long_the_names(long_named, language, paper):
    job = Job(
        repair_decisions=[
            {"component": "25", "land": 1, "work": "69 % wear", "decision": decision, "reason": "said so"}
            for decision in ("proposed", "approved", "done", "declined", "deferred")
        ]
    )
    content = write_pdf(long_named, job, language=language, paper=paper, sections=SECTIONS)
    assert overflowing(content) == []


@pytest.mark.parametrize("language", languages())
def test_all_rows_of_the_table_of_lands_are_of_one_height(worn, language):
    diameter = re.compile(r"\d+[.,]\d{4}")
    with pypdfium2.PdfDocument(write_pdf(worn, language=language, sections=["all"])) as document:
        heights = []
        for page in list(document)[2:]:
            written = page.get_textpage()
            boxes = [written.get_rect(each) for each in range(written.count_rects())]
            rows = {round(box[1], 1) for box in boxes if diameter.match(written.get_text_bounded(*box).strip())}
            heights += [round(one - other, 1) for other, one in pairwise(sorted(rows))]
    row = min(heights)
    assert len(heights) > 20
    assert [each for each in heights if abs(each - row) > 0.3 and abs(each - 2.0 * row) > 0.3] == []  # with a title


def test_a_note_below_a_table_belongs_to_it_and_another_paragraph_does_not():
    column = PrintedColumn("a", str)
    rows, note, more = table([column], [1, 2]), text("said of it", small=True), text("next", small=True)
    noted, after = with_notes([rows, {}, note, more])
    assert noted["note"] == "said of it"
    assert after is more
    assert list(with_notes([rows, text("large")])) == [rows, text("large")]
    long = text("x" * 4000, small=True)
    assert list(with_notes([rows, long])) == [rows, long]


def test_rows_of_a_group_stand_below_its_title_and_hold_together():
    made = grouped_table([PrintedColumn("a", str), PrintedColumn("b", str)], [("first", [1, 2]), ("second", [3])])
    assert made["rows"] == [["first"], ["1", "1"], ["2", "2"], ["second"], ["3", "3"]]
    assert made["groups"] == [3, 2]
    assert grouped_table([PrintedColumn("a", str)], []) == {}


@pytest.mark.parametrize("count", [2, 3, 5, *(pytest.param(each, marks=pytest.mark.slow) for each in range(6, 60, 3))])
def test_no_page_begins_with_the_last_row_of_a_table(unmeasured, count):
    """Decisions of one line each: as many as end anywhere on a page."""
    filling = "\n".join(f"line {number}" for number in range(20))
    decisions = [{"component": "8", "work": f"work {number}", "decision": "done"} for number in range(count)]
    job = Job(repair_decisions=decisions, fluid_condition={"note": filling})
    with pypdfium2.PdfDocument(write_pdf(unmeasured, job, sections=["repair"])) as document:
        pages = [page.get_textpage().get_text_range() for page in document]
    rows = [[line for line in page.splitlines() if " work " in line and line.startswith("8")] for page in pages]
    assert sum(map(len, rows)) == count
    assert all(len(each) != 1 for each in rows if count > 1)
