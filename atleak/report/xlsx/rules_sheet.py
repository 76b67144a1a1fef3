"""Write the sheet of rules: what each limit says of the total at every condition and of each land."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.limits import ROUNDING, Level, RuleKind
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.report.xlsx.book import Book, cell, formula, put, span
from atleak.report.xlsx.limit_cells import LimitCells
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    RANKED,
    ColumnKey,
    SheetCondition,
    component_width,
    fine_of,
    verdict_of_rank,
)
from atleak.rules import LandKey, Rule
from atleak.verdicts import FLAGGED, VERDICTS, Band, Verdict
from atleak.wording import signed

_SHEET = "Rules"
_VALUE, _NEW, _FIRST_LEVEL = 4, 5, 6
_VERDICT = _FIRST_LEVEL + len(FLAGGED)  # behind a limit for every level
_RANK = _VERDICT + 1
OF_THE_UNIT = "whole unit"  # in place of a component


@dataclass(frozen=True)
class _Line:
    """One rule on the sheet, with what its formulas ask for."""

    rule: Rule
    land: LandDiagnosis | None  # None for a total
    value: str  # the cell with its value
    base: str | None = None  # the cell that its limits grow from: the same share when new, or the mounting clearance
    tolerance: str | None = None  # the cell with that of the mounting clearance


class RuleCells:
    """Where every rule stands on its sheet: those of the totals first, then those of the lands."""

    def __init__(self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], limits: LimitCells) -> None:
        self.diagnosis, self.conditions, self.limits = diagnosis, conditions, limits
        rows = len(conditions) + 1
        self._of_land: dict[LandKey, tuple[int, int]] = {}
        for land in diagnosis.lands:
            if land.rules:
                self._of_land[land.key] = (rows, rows + len(land.rules) - 1)
                rows += len(land.rules)
        self.last = rows - 1

    @property
    def ranks(self) -> str:
        """Return the stretch of cells with the ranks of all verdicts."""
        return span(1, self.last, _RANK, _SHEET)

    def ranks_of(self, key: LandKey) -> str | None:
        """Return the stretch of cells with the ranks of one land's verdicts; None where no rule judges it."""
        rows = self._of_land.get(key)
        return None if rows is None else span(*rows, _RANK, _SHEET)

    def verdict(self, land: LandDiagnosis, rule: Rule) -> str:
        """Return the formula of what one rule says of a land; half a pair is never called ok."""
        return verdict_of_rank(cell(self._of_land[land.key][0] + land.rules.index(rule), _RANK, _SHEET), fine_of(land))

    def of_total(self, at: SheetCondition) -> tuple[dict[Level, str], str]:
        """Return the cells with the limits of the total at a condition, by band, and with its rank."""
        row = self._total_row(at)
        limits = {level: cell(row, _column(level), _SHEET) for level, _ in self._total(at).steps.levels}
        return limits, cell(row, _RANK, _SHEET)

    def _total(self, at: SheetCondition) -> Rule:
        return self.diagnosis.total_rule(at.projection)

    def _total_row(self, at: SheetCondition) -> int:
        return 1 + list(self.conditions).index(at)

    def write(self, book: Book, sheet: Worksheet, of_land: Callable[[LandKey, ColumnKey], str]) -> None:
        """Write what each rule says; ``of_land`` gives a cell of the sheet of lands."""
        names = ["component", "land", "rule", "unit", "value", "when new", *(f"{level} from" for level in FLAGGED)]
        names += ["verdict", "rank", "origin of the limit", "source"]
        book.headings(sheet, 0, names)
        for at in self.conditions:
            line = _Line(self._total(at), None, at("share"), at("share_new"))
            self._write(book, sheet, self._total_row(at), line)
        for land in self.diagnosis.lands:
            for row, rule in enumerate(land.rules, start=self._of_land.get(land.key, (0, 0))[0]):
                self._write(book, sheet, row, self._line(land, rule, of_land))
        for column, width in enumerate(
            (
                component_width(self.diagnosis.controller.components),
                7,
                48,
                7,
                12,
                12,
                *(12 for _ in FLAGGED),
                14,
                7,
                24,
                60,
            )
        ):
            sheet.set_column(column, column, width)
        sheet.autofilter(0, 0, self.last, len(names) - 1)
        sheet.print_area(0, 0, self.last, len(names) - 2)  # the sources stand beside the limits
        book.colour_words(sheet, (1, _VERDICT), (self.last, _VERDICT), VERDICTS)

    def _line(self, land: LandDiagnosis, rule: Rule, of_land: Callable[[LandKey, ColumnKey], str]) -> _Line:
        if rule.kind is RuleKind.WEAR:
            known = land.state.land.mounting_tolerance is not None
            tolerance = of_land(land.key, "tolerance") if known else None
            return _Line(rule, land, of_land(land.key, "wear"), of_land(land.key, "c_m"), tolerance)
        if rule.kind is RuleKind.CLEARANCE:
            return _Line(rule, land, of_land(land.key, "c_r"))
        prefix = next(at.prefix for at in self.conditions if at.projection.condition == rule.condition)
        share, new = (of_land(land.key, (name, prefix)) for name in ("share", "new_share"))
        return _Line(rule, land, share, new)

    def _write(self, book: Book, sheet: Worksheet, row: int, line: _Line) -> None:
        rule, factor = line.rule, line.rule.kind.factor
        component, number = line.land.key if line.land else (OF_THE_UNIT, None)
        form = book.form("share" if rule.new is not None else rule.kind.suffix)
        for column, value in enumerate((component, number, rule.label, rule.kind.unit)):
            put(sheet, row, column, value, book.form(align="left"))
        formula(sheet, row, _VALUE, line.value, rule.value * factor, form)
        if line.base is not None and rule.new is not None:
            formula(sheet, row, _NEW, line.base, rule.new * factor, form)
        rank, before = "1", None
        for level, limit in rule.steps.levels:
            column = _column(level)
            text = self._limit(row, line, level, before)
            if text is None:  # of the land alone, by the valve body's file
                put(sheet, row, column, limit * factor, book.form(rule.kind.suffix, **CHANGEABLE))
            else:
                formula(sheet, row, column, text, limit * factor, form)
            before = cell(row, column)
            reached = RANKED.index(_verdict(level)) + 1
            rank = f"IF({cell(row, _VALUE)}>={before}*(1-{ROUNDING:E}),{reached},{rank})"
        formula(sheet, row, _RANK, rank, RANKED.index(rule.verdict) + 1)
        formula(
            sheet, row, _VERDICT, verdict_of_rank(cell(row, _RANK)), signed(rule.verdict), book.form(**AFTER_A_NUMBER)
        )
        for column, text in enumerate((rule.origin, rule.source), start=_RANK + 1):
            put(sheet, row, column, text, book.form(**AFTER_A_NUMBER))

    def _limit(self, row: int, line: _Line, level: Level, before: str | None) -> str | None:
        """Return the formula of the limit at which a level begins; None where it is the land's own."""
        kind = line.rule.kind
        if line.rule.new is not None:
            return self.limits.share(kind, level, cell(row, _NEW))
        if line.base is not None:
            return self.limits.wear(level, line.base, line.tolerance, before)
        own = line.land is not None and line.land.state.land.clearance_limit is not None
        return None if own else self.limits.clearance(level)


def _verdict(level: Level) -> Verdict:
    return level.verdict if isinstance(level, Band) else level


def _column(level: Level) -> int:
    return _FIRST_LEVEL + FLAGGED.index(_verdict(level))
