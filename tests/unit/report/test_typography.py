"""How the pages of the printed report are set: nothing over its edge, nothing left alone, no small print."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

import pypdfium2
import pypdfium2.raw as pdfium
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.measurements.job_card import Job
from atleak.report.charts.drawing import controller_svg
from atleak.report.pdf import write_pdf
from atleak.report.pdf.blocks import listed, text, with_notes
from atleak.report.pdf.body import picture_look
from atleak.report.tables.table import Column

LEAST, DENSE = 8.9, 7.9  # [pt]: 9 pt as the file rounds it, and 8 of the annex's tables


def sizes(content: bytes) -> Iterator[tuple[int, float, str]]:
    """Page, size [pt] and letter of everything that is printed in words."""
    with pypdfium2.PdfDocument(content) as document:
        for number, page in enumerate(document, start=1):
            written = page.get_textpage()
            letters = written.get_text_range()
            for place, letter in enumerate(letters[: pdfium.FPDFText_CountChars(written)]):
                if letter.isalnum():
                    yield number, pdfium.FPDFText_GetFontSize(written, place), letter


def test_sentences_are_no_smaller_than_9_points_and_tables_of_many_rows_and_the_annex_than_8(worn):
    decisions = [{"component": "25", "land": 1, "work": "ream", "decision": "done"}]
    job = Job(number="1", customer={"name": "A. Customer"}, repair_decisions=decisions)
    content = write_pdf(worn, job, document="workshop", sections=["again", "road_test", "repair"])
    small = [(page, size, letter) for page, size, letter in sizes(content) if size < LEAST]
    assert {page for page, *_ in small} <= {1}, "none but those of the totals"
    workshop = write_pdf(worn, job, document="workshop", sections=["flagged", "repair_order", "estimate"])
    assert min(size for _, size, _ in sizes(workshop)) > DENSE
    annex = write_pdf(worn, document="annex", sections=["all", "limits", "assumptions", "readings", "provenance"])
    assert min(size for _, size, _ in sizes(annex)) > DENSE


@pytest.mark.parametrize("language", languages())
def test_no_row_of_the_table_of_lands_has_more_than_two_lines_and_most_have_one(worn, language):
    clearance = re.compile(r"\d+[.,]\d ± ")
    with pypdfium2.PdfDocument(write_pdf(worn, language=language, sections=["all"])) as document:
        heights = []
        for page in list(document)[1:]:
            written = page.get_textpage()
            boxes = [written.get_rect(each) for each in range(written.count_rects())]
            rows = {round(box[1], 1) for box in boxes if clearance.match(written.get_text_bounded(*box).strip())}
            heights += [round(one - other, 1) for other, one in pairwise(sorted(rows))]
    row = min(heights)
    assert len(heights) > 20
    assert max(heights) < row + 10.0  # a line of 8 points
    assert sum(each < row + 0.3 for each in heights) > 0.6 * len(heights)


@pytest.mark.parametrize("name", ["five_speed_2005", "ford_4r70w", "four_speed_2023", "gm_4l60e"])
def test_names_in_the_drawing_of_a_valve_body_are_no_smaller_than_7_5_points(name):
    controller = load_controller(name)
    columns, letters = picture_look(len({land.component for land in controller.lands}))
    for language in languages():
        drawn = controller_svg(controller, columns=columns, named=wording(language).name, letters=letters)
        width, height = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', drawn).groups())
        scale = min(180.0 / width, 120.0 / height) * 72.0 / 25.4  # points of a unit, as the template places it
        assert min(map(float, re.findall(r'font-size="([\d.]+)"', drawn))) * scale >= 7.5


COLUMNS = [Column(name, words=name, of=str) for name in "ab"]


def test_a_note_below_a_table_belongs_to_it_and_another_paragraph_does_not():
    rows, note, more = listed(wording("en"), [1, 2], *COLUMNS), text("said of it", small=True), text("next", small=True)
    noted, after = with_notes([rows, {}, note, more])
    assert noted["note"] == "said of it"
    assert after is more
    assert list(with_notes([rows, text("large")])) == [rows, text("large")]
    long = text("x" * 4000, small=True)
    assert list(with_notes([rows, long])) == [rows, long]


def test_rows_of_a_group_stand_below_its_title_and_hold_together():
    made = listed(wording("en"), [1, 2, 3], *COLUMNS, group=lambda item: "first" if item < 3 else "second")
    assert made["rows"] == [["first"], ["1", "1"], ["2", "2"], ["second"], ["3", "3"]]
    assert made["groups"] == [3, 2]
    assert listed(wording("en"), [], *COLUMNS) == {}


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
