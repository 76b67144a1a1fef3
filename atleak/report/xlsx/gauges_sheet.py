"""Write the sheet of gauge readings: what was shown, what is permissible and expected, verdicts, patterns."""

from __future__ import annotations

from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.report.xlsx.book import Book
from atleak.sentence import Sentence
from atleak.verdicts import VERDICTS
from atleak.views.gauge_rows import gauge_rows, pattern_text

SHEET = Sentence("Gauge readings")
_VERDICT, _NOT_JUDGED = Sentence("Verdict"), Sentence("not judged")
_WIDTHS = {"Verdict": 14, "Range": 8, "State": 12, "Tap": 26, "Permitted [kPa]": 16, "Decision": 18}


def write_gauges(book: Book, sheet: Worksheet, diagnosis: Diagnosis) -> None:
    """Write a row for every reading, in the order of the ranges, and the patterns below."""
    check, say = diagnosis.pressures, book.say
    if check is None:
        return
    rows: list[dict[str, Any]] = [
        {_VERDICT: _NOT_JUDGED if each.verdict is None else say.signed(each.verdict), **row}
        for each, row in zip(check.readings, gauge_rows(check, say), strict=True)
    ]
    numbers = {name: "kpa" for name in rows[0] if name.endswith("[kPa]") and name not in _WIDTHS}
    free = book.records(sheet, 0, rows, numbers)
    for column, name in enumerate(rows[0]):
        sheet.set_column(column, column, _WIDTHS.get(name, 13))
    book.colour_words(sheet, (1, 0), (len(rows), 0), VERDICTS)
    notes = [(Sentence("file"), check.table.file), (Sentence("sheet"), check.table.sheet or "")]
    notes += [(Sentence("permitted by"), text) for text in dict.fromkeys(_sources(diagnosis))]
    for pattern in check.patterns:
        source = say.get("pattern_sources", pattern.source)
        notes.append((Sentence("pattern"), f"{pattern_text(pattern, diagnosis.controller, say)} ({source})"))
    for row, (name, text) in enumerate((note for note in notes if note[1]), start=free + 1):
        book.put(sheet, row, 0, name, book.bold)
        book.put(sheet, row, 1, text)


def _sources(diagnosis: Diagnosis) -> list[str]:
    readings = diagnosis.pressures.readings if diagnosis.pressures else ()
    return [each.permissible.source for each in readings if each.permissible]
