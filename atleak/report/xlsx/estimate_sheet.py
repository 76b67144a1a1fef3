"""Write the estimate of a job as a sheet: lines, sums, and what is open."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.job.estimate import estimate
from atleak.job.record import Job
from atleak.report.estimate_words import EstimateWords
from atleak.report.xlsx.book import Book, put
from atleak.wording import wording

SHEET = "Estimate"
_WIDTHS = (30, 34, 18, 12, 10, 12, 12, 14, 30, 60)


def write_estimate(book: Book, sheet: Worksheet, diagnosis: Diagnosis, job: Job) -> None:
    """Write lines and sums as numbers, rounded as in the printed estimate."""
    words = EstimateWords(estimate(diagnosis, job), wording("en"))
    for column, width in enumerate(_WIDTHS):
        sheet.set_column(column, column, width)
    currency = words.estimate.currency
    lines: list[dict[str, Any]] = [
        {
            "pair": words.pair(line),
            "work": words.work(line),
            "part no.": line.decision.part_number,
            "price": _number(line.part),
            "hours": line.hours,
            "labour": _number(line.work),
            "currency": currency,
            "state": words.state(line),
            "reason": line.decision.reason,
            "without it": words.lacks(line),
        }
        for line in words.estimate.lines
    ]
    row = book.records(sheet, 0, lines) + 1
    sums: list[dict[str, Any]] = [
        {
            "state": name,
            "parts": _number(each.parts),
            "labour": _number(each.work),
            "net": _number(each.net),
            "tax": _number(each.tax),
            "total": _number(each.gross),
            "currency": currency,
            "complete": each.complete,
        }
        for name, each in words.sums
    ]
    row = book.records(sheet, row, sums) + 1
    for sentence in (*words.chosen_by(), *words.missing(), *words.ends(), words.rounding()):
        put(sheet, row, 0, sentence)
        row += 1


def _number(value: Decimal | None) -> float | None:
    return None if value is None else float(value)
