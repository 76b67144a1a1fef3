"""The workbook's summary follows its sheets: headline, counts and what is flagged since it was issued."""

from __future__ import annotations

import io
from typing import Any

import openpyxl
import pytest

from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.assumed import assumed_line
from atleak.report.tables.first_sentence import first_sentence, lands_part, total_part
from atleak.report.xlsx import write_workbook

UM = 1e-6


def beside(sheet: Any, label: str) -> str:
    """The address of the cell to the right of a label."""
    (cell,) = (cell for row in sheet.iter_rows() for cell in row if cell.value == label)
    return str(cell.offset(column=1).coordinate)


def widened(book: openpyxl.Workbook, found: Diagnosis) -> tuple[str, int]:
    """Widen the sleeve of a land that is within its limits by 60 µm; return the land."""
    land = next(land for land in found.lands if land.state.judged and not land.verdict.flagged)
    lands = book["Lands"]
    (column,) = (cell.column for cell in lands[1] if str(cell.value).startswith("sleeve diameter"))
    row = 1 + next(number for number, each in enumerate(found.lands, start=1) if each is land)
    lands.cell(row, column).value = land.state.sleeve_diameter * 1e3 + 0.060
    return land.key


def since(sheet: Any, value: Any) -> list[tuple[str, Any]]:
    """The lands that are listed as flagged since."""
    (start,) = (row[0].row for row in sheet.iter_rows() if str(row[0].value).startswith("Flagged since"))
    rows = ((value("Summary", f"A{row}"), value("Summary", f"D{row}")) for row in range(start + 1, start + 4))
    return [(str(component), land) for component, land in rows if component]


def test_the_headline_says_what_was_issued_until_a_number_changes(worn_clutch, calculator):
    sheets, say = calculator(write_workbook(worn_clutch)), wording("en")
    said = sheets.value("Summary", "B6")
    assert lands_part(worn_clutch, say) in said
    assert total_part(worn_clutch, say) in said
    assert sheets.book["Summary"]["B7"].value.endswith(
        f"{first_sentence(worn_clutch, say)} {assumed_line(worn_clutch, say)}"
    )


def test_a_widened_sleeve_reaches_headline_counts_and_the_list_of_what_is_flagged_since(worn_clutch, calculator):
    sheets = calculator(write_workbook(worn_clutch))
    component, land = widened(sheets.book, worn_clutch)
    summary, flagged = sheets.book["Summary"], len(worn_clutch.flagged)
    assert sheets.value("Summary", beside(summary, "flagged now")) == flagged + 1
    assert sheets.value("Summary", beside(summary, "flagged as issued")) == flagged
    assert sheets.value("Summary", beside(summary, "■ replace now")) + sheets.value(
        "Summary", beside(summary, "✖ critical now")
    ) == 1 + sum(each.verdict.calls_for_repair for each in worn_clutch.lands)
    assert since(summary, sheets.value) == [(component, land)]
    assert f" of {worn_clutch.judged} measured lands" in sheets.value("Summary", "B6")
    assert (
        sheets.value("Summary", "B6")
        != openpyxl.load_workbook(io.BytesIO(sheets.content), data_only=True)["Summary"]["B6"].value
    )


@pytest.mark.slow  # each time, the calculator says the same
@pytest.mark.parametrize("language", ["en", "de"])
def test_libreoffice_recalculates_headline_and_lists(worn_clutch, recalculated, language):
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(worn_clutch, language=language)))
    summary = book.sheetnames[0]
    say = wording(language)
    before = recalculated(book)(summary, "B6")
    assert lands_part(worn_clutch, say) in before
    assert total_part(worn_clutch, say) in before
    if language == "en":
        component, land = widened(book, worn_clutch)
        value = recalculated(book)
        assert value("Summary", beside(book["Summary"], "flagged now")) == len(worn_clutch.flagged) + 1
        assert since(book["Summary"], value) == [(component, land)]
        assert value("Summary", "B6") != before
