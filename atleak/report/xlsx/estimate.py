"""Write the estimate: prices, hours, labour rate and tax may be changed, and lines and sums follow from them."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from xlsxwriter.worksheet import Worksheet

from atleak.analysis.estimate import ORDER, Sum, estimate
from atleak.analysis.repair.options import decimals
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.tables.estimate import EstimateWords
from atleak.report.xlsx.book import ReportBook, cell, cell_span, formula
from atleak.report.xlsx.live_sheet import AFTER_A_NUMBER, CHANGEABLE, quote
from atleak.report.xlsx.page import SheetPage

ESTIMATE_SHEET = Sentence("Estimate")
_LINES = {  # headings with the widths of their columns
    Sentence("pair"): 26, Sentence("work"): 30, Sentence("part no."): 14, Sentence("price"): 11, Sentence("hours"): 9,
    Sentence("labour"): 11, Sentence("line total"): 11, Sentence("currency"): 10, Sentence("state"): 15,
    Sentence("reason"): 24, Sentence("without it"): 48,
}  # fmt: skip
_PAIR, _WORK, _PART_NUMBER, _PRICE, _HOURS, _LABOUR, _LINE, _CURRENCY, _STATE, _REASON, _WITHOUT = range(len(_LINES))
_TERMS = Sentence("labour rate per hour"), Sentence("tax [%]")
_TAX, _TOTAL, _COMPLETE = _CURRENCY, _STATE, _REASON  # columns of the sums: the others stand below what they add up
_SUMS = {
    _PAIR: Sentence("state"), _PRICE: Sentence("parts"), _LABOUR: Sentence("labour"), _LINE: Sentence("net"),
    _TAX: Sentence("tax"), _TOTAL: Sentence("total"), _COMPLETE: Sentence("complete"),
}  # fmt: skip


def write_estimate(book: ReportBook, sheet: Worksheet, diagnosis: Diagnosis, job: Job) -> None:
    """Write lines and sums, rounded as in the printed estimate, as formulas of what may be changed."""
    words = EstimateWords(estimate(diagnosis, job), book.say)
    _EstimateCells(book, sheet, words).write()


class _EstimateCells:
    def __init__(self, book: ReportBook, sheet: Worksheet, words: EstimateWords) -> None:
        self.book, self.sheet, self.words = book, sheet, words
        self.places = decimals(words.estimate.currency)
        self.money = f"0.{'0' * self.places}" if self.places else "0"
        # lines of a state, and of all that is to be done, are neighbours: a function takes 255 cells, or a span of any
        self.lines = sorted(words.estimate.lines, key=lambda line: (*ORDER, None).index(line.decision.decision))
        self.rows = {line.key: row for row, line in enumerate(self.lines, start=1)}
        self.terms = len(self.lines) + 2  # row of the first of them

    def write(self) -> None:
        book, sheet, words = self.book, self.sheet, self.words
        page = SheetPage(book, sheet, _LINES.values())
        page.headings(0, list(_LINES))
        self._lines(page)
        terms = words.estimate.terms
        for row, (label, value) in enumerate(
            zip(_TERMS, (terms.labour_rate, terms.tax_percent), strict=True), start=self.terms
        ):
            book.put(sheet, row, _PAIR, label, book.bold)
            self._input(row, _PRICE, value, "General")
        sums = self.terms + len(_TERMS) + 1
        for column in range(_COMPLETE + 1):
            book.put(sheet, sums, column, _SUMS.get(column, ""), book.heading)
        for row, (name, each) in enumerate(words.sums, start=sums + 1):
            self._sum(row, name, each)
        texts = (*words.chosen_by(), *words.missing(), *words.ends(), words.rounding())
        notes = sums + len(words.sums) + 2
        book.put(sheet, notes, 0, Sentence("as issued"), book.bold)  # they do not follow a price that is changed
        for row, text in enumerate(texts, start=notes + 1):
            page.across(row, text)

    def _lines(self, page: SheetPage) -> None:
        words = self.words
        for row, line in enumerate(self.lines, start=1):
            texts = {
                _PAIR: words.pair(line),
                _WORK: words.work(line),
                _PART_NUMBER: line.decision.part_number,
                _STATE: words.state(line),
                _REASON: line.decision.reason,
                _WITHOUT: words.lacks(line),
            }
            for column, text in texts.items():
                page.text(row, column, text)
            self.book.put(self.sheet, row, _CURRENCY, words.estimate.currency, self.book.form(**AFTER_A_NUMBER))
            self._input(row, _PRICE, line.part, self.money)
            self._input(row, _HOURS, line.hours, "General")
            hours, rate = cell(row, _HOURS), cell(self.terms, _PRICE)
            work = f'IF(COUNT({hours},{rate})=2,ROUND({hours}*{rate},{self.places}),"")'
            self._amount(row, _LABOUR, work, line.work)
            known = [each for each in (line.part, line.work) if each is not None]
            self._amount(row, _LINE, self._added(row, (_PRICE, _LABOUR)), sum(known, Decimal(0)) if known else None)

    def _sum(self, row: int, name: str, each: Sum) -> None:
        """Write what some lines cost together: what is known of it, and whether that is all."""
        rows = [self.rows[line.key] for line in each.lines]
        prices, works = (cell_span(min(rows), max(rows), column) for column in (_PRICE, _LABOUR))
        net, percent, taxed = cell(row, _LINE), cell(self.terms + 1, _PRICE), cell(row, _TAX)
        self.book.put(self.sheet, row, _PAIR, name, self.book.form())
        self._amount(row, _PRICE, self._total([prices]), each.parts)
        self._amount(row, _LABOUR, self._total([works]), each.work)
        self._amount(row, _LINE, self._added(row, (_PRICE, _LABOUR)), each.net)
        tax = f'IF(COUNT({net},{percent})=2,ROUND({net}*{percent}/100,{self.places}),"")'
        self._amount(row, _TAX, tax, each.tax)
        self._amount(row, _TOTAL, self._total([net, taxed]), each.gross)
        yes, no = (self.book.say(f"estimate.{word}") for word in ("yes", "no"))
        left = self.book.form(**AFTER_A_NUMBER)
        known = f"COUNT({prices},{works})={2 * len(rows)}"
        formula(self.sheet, row, _COMPLETE, f"IF({known},{quote(yes)},{quote(no)})", yes if each.complete else no, left)

    def _added(self, row: int, columns: Sequence[int]) -> str:
        return self._total([cell(row, column) for column in columns])

    def _total(self, cells: Sequence[str]) -> str:
        """Return the formula of the sum of what is known; an empty text where nothing is."""
        listed = ",".join(cells)
        return f'IF(COUNT({listed})>0,ROUND(SUM({listed}),{self.places}),"")'

    def _input(self, row: int, column: int, value: float | Decimal | None, kind: str) -> None:
        """Write what may be changed: an empty cell where nobody knows it."""
        form = self.book.form(kind, **CHANGEABLE)
        if value is None:
            self.sheet.write_blank(row, column, None, form)
        else:
            self.sheet.write_number(row, column, float(value), form)

    def _amount(self, row: int, column: int, text: str, value: Decimal | None) -> None:
        formula(self.sheet, row, column, text, "" if value is None else float(value), self.book.form(self.money))
