"""The report workbook in the reader's language: every word of it, with formulas that give the same."""

from __future__ import annotations

import io

import openpyxl
import pytest
from babel.messages.pofile import read_po

from atleak.common.translations import source
from atleak.common.wording import wording
from atleak.report.xlsx import write_workbook


@pytest.fixture(scope="module")
def german(worn_clutch) -> bytes:
    return write_workbook(worn_clutch, language="de")


def texts_of(content: bytes) -> set[str]:
    book = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
    cells = (cell.value for sheet in book for row in sheet.iter_rows() for cell in row)
    return {value for value in cells if isinstance(value, str)} | set(book.sheetnames)


def test_every_formula_of_another_language_gives_its_cached_value(german, calculator):
    assert calculator(german).wrong() == []


@pytest.mark.parametrize("language", ["de", "pl"])
def test_no_cell_stays_in_english(worn_clutch, language):
    with source(language).open("rb") as file:
        texts = {message.id: message.string for message in read_po(file) if message.id}
    # of several words: a name of one may be that of somebody's own circuit
    english = {text for text, said in texts.items() if " " in text and text != said and "{" not in text}
    shown = texts_of(write_workbook(worn_clutch, language=language))
    assert shown & english - set(map(str, texts.values())) == set()
    assert not [text for text in shown if " kPa], as issued" in text or "spools concentric" in text]


def test_sheets_verdicts_and_conditions_have_the_words_of_the_report(worn_clutch, german):
    say, book = wording("de"), openpyxl.load_workbook(io.BytesIO(german), data_only=True)
    assert book.sheetnames[:3] == ["Übersicht", "Bünde", "Bund je Betriebspunkt"]
    summary = book["Übersicht"]
    assert summary["B5"].value == say.signed(worn_clutch.verdict)
    assert summary["B7"].value.startswith(f"{say.signed(worn_clutch.verdict)}: ")
    headings = {str(cell.value) for cell in book["Bund je Betriebspunkt"][1]}
    assert f"Befund des Anteils, {say.condition(worn_clutch.worst.condition)}" in headings
