"""Write the estimate of a job as a sheet: lines, sums, and what is open."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.analysis.estimate import estimate
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.tables.estimate import EstimateWords
from atleak.report.xlsx.book import ReportBook

ESTIMATE_SHEET = Sentence("Estimate")
_WIDTHS = (30, 34, 18, 12, 10, 12, 12, 14, 30, 60)


def write_estimate(book: ReportBook, sheet: Worksheet, diagnosis: Diagnosis, job: Job) -> None:
    """Write lines and sums as numbers, rounded as in the printed estimate."""
    words = EstimateWords(estimate(diagnosis, job), book.say)
    for column, width in enumerate(_WIDTHS):
        sheet.set_column(column, column, width)
    currency = words.estimate.currency
    lines: list[dict[Sentence, Any]] = [
        {
            Sentence("pair"): words.pair(line),
            Sentence("work"): words.work(line),
            Sentence("part no."): line.decision.part_number,
            Sentence("price"): _number(line.part),
            Sentence("hours"): line.hours,
            Sentence("labour"): _number(line.work),
            Sentence("currency"): currency,
            Sentence("state"): words.state(line),
            Sentence("reason"): line.decision.reason,
            Sentence("without it"): words.lacks(line),
        }
        for line in words.estimate.lines
    ]
    row = book.records(sheet, 0, lines) + 1
    sums: list[dict[Sentence, Any]] = [
        {
            Sentence("state"): name,
            Sentence("parts"): _number(each.parts),
            Sentence("labour"): _number(each.work),
            Sentence("net"): _number(each.net),
            Sentence("tax"): _number(each.tax),
            Sentence("total"): _number(each.gross),
            Sentence("currency"): currency,
            Sentence("complete"): each.complete,
        }
        for name, each in words.sums
    ]
    row = book.records(sheet, row, sums) + 1
    for sentence in (*words.chosen_by(), *words.missing(), *words.ends(), words.rounding()):
        book.put(sheet, row, 0, sentence)
        row += 1


def _number(value: Decimal | None) -> float | None:
    return None if value is None else float(value)
