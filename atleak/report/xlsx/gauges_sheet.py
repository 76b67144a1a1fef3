"""Write the sheet of gauge readings: what was shown, what is permissible and expected, verdicts, patterns."""

from __future__ import annotations

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.report.xlsx.book import Book
from atleak.sentence import Sentence
from atleak.views.gauge_rows import gauge_table, pattern_sentences

SHEET = Sentence("Gauge readings")


def write_gauges(book: Book, sheet: Worksheet, diagnosis: Diagnosis) -> None:
    """Write a row for every reading, in the order of the ranges, and the patterns below."""
    check, say = diagnosis.pressures, book.say
    if check is None:
        return
    free = book.table(sheet, 0, gauge_table(check, book.metric).without("lost_between"))
    notes = [(Sentence("file"), check.table.file), (Sentence("sheet"), check.table.sheet or "")]
    notes += [(Sentence("permitted by"), text) for text in dict.fromkeys(_sources(diagnosis))]
    notes += [(Sentence("pattern"), each) for each in pattern_sentences(check, diagnosis.controller, say)]
    for row, (name, text) in enumerate((note for note in notes if note[1]), start=free + 1):
        book.put(sheet, row, 0, name, book.bold)
        book.put(sheet, row, 1, text)


def _sources(diagnosis: Diagnosis) -> list[str]:
    readings = diagnosis.pressures.readings if diagnosis.pressures else ()
    return [each.permissible.source for each in readings if each.permissible]
