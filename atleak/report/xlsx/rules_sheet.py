"""Write the sheet of rules: what each limit says of the unit at every condition and of each land."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.limits import Level, RuleKind
from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.xlsx.book import Book, cell, formula, span
from atleak.report.xlsx.limit_cells import LimitCells
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    RANKED,
    ColumnKey,
    SheetCondition,
    component_width,
    fine_of,
    share_of,
    verdict_of_rank,
)
from atleak.report.xlsx.names import NOTHING_DELIVERED, ROUNDED
from atleak.rules import LandKey, Rule
from atleak.sentence import Sentence
from atleak.verdicts import FLAGGED, VERDICTS, Band, Verdict
from atleak.wording import Wording

RULES = Sentence("Rules")
_VALUE, _NEW, _FIRST_LEVEL = 4, 5, 6
_VERDICT = _FIRST_LEVEL + len(FLAGGED)  # behind a limit for every level
_RANK, _DECISION, _ISSUED = _VERDICT + 1, _VERDICT + 2, _VERDICT + 5
_FORMATS = {RuleKind.RESERVE: "reserve", RuleKind.PAIR_SHARE: "share", RuleKind.TOTAL_SHARE: "share"}
OF_THE_UNIT = Sentence("whole unit")  # in place of a component
_BEFORE_LEVELS = (
    Sentence("component"),
    Sentence("land"),
    Sentence("rule"),
    Sentence("unit"),
    Sentence("value"),
    Sentence("when new"),
)
_BEHIND_LEVELS = (
    Sentence("verdict"),
    Sentence("rank"),
    Sentence("decision as issued"),
    Sentence("origin of the limit"),
    Sentence("source"),
    Sentence("value as issued"),  # of a rule whose level is the likelier one
)


@dataclass(frozen=True)
class _Line:
    """One rule on the sheet, with what its formulas ask for."""

    rule: Rule
    land: LandDiagnosis | None  # None for the whole unit
    value: str  # the formula of its value
    new: str | None = None  # the cell with the same when new, which limits may follow; None where it is as issued
    mounting: str | None = None  # the cell with the mounting clearance
    tolerance: str | None = None  # the cell with that of the mounting clearance


class RuleCells:
    """Where every rule stands on its sheet: those of the whole unit first, then those of the lands."""

    def __init__(
        self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], limits: LimitCells, say: Wording
    ) -> None:
        self.diagnosis, self.conditions, self.limits, self.say = diagnosis, conditions, limits, say
        self.sheet = say.sentence(RULES)
        self._of_unit = [diagnosis.total_rule(at.projection) for at in conditions]
        self._of_unit += [rule for at in conditions for rule in diagnosis.pressure_rules_at(at.projection)]
        rows = len(self._of_unit) + 1
        self._of_land: dict[LandKey, tuple[int, int]] = {}
        for land in diagnosis.lands:
            if land.rules:
                self._of_land[land.key] = (rows, rows + len(land.rules) - 1)
                rows += len(land.rules)
        self.last = rows - 1

    @property
    def ranks(self) -> str:
        """Return the stretch of cells with the ranks of all verdicts."""
        return span(1, self.last, _RANK, self.sheet)

    def ranks_of(self, key: LandKey) -> str | None:
        """Return the stretch of cells with the ranks of one land's verdicts; None where no rule judges it."""
        rows = self._of_land.get(key)
        return None if rows is None else span(*rows, _RANK, self.sheet)

    def verdict(self, land: LandDiagnosis, rule: Rule) -> str:
        """Return the formula of what one rule says of a land; half a pair is never called ok."""
        rank = cell(self._of_land[land.key][0] + land.rules.index(rule), _RANK, self.sheet)
        return verdict_of_rank(rank, self.say, fine_of(land))

    def limits_and_rank(self, rule: Rule) -> tuple[dict[Level, str], str]:
        """Return the cells with the limits of a rule of the unit, by level, and with its rank."""
        row = self._unit_row(rule)
        limits = {level: cell(row, _column(level), self.sheet) for level, _ in rule.steps.levels}
        return limits, cell(row, _RANK, self.sheet)

    def of_unit(self, rule: Rule) -> str:
        """Return the formula of what one rule says of the unit; one that nobody measured is never called ok."""
        return verdict_of_rank(cell(self._unit_row(rule), _RANK, self.sheet), self.say, self.diagnosis.within(rule))

    def _unit_row(self, rule: Rule) -> int:
        return 1 + next(number for number, each in enumerate(self._of_unit) if each is rule)

    def write(
        self,
        book: Book,
        sheet: Worksheet,
        of_land: Callable[[LandKey, ColumnKey], str],
        held: Callable[[SheetCondition, Circuit, str], str],
    ) -> None:
        """Write what each rule says; ``of_land`` gives a cell of the sheet of lands, ``held`` that of a circuit."""
        levels = (Sentence("{level} from", level=self.say.level(level)) for level in FLAGGED)
        names = [*_BEFORE_LEVELS, *levels, *_BEHIND_LEVELS]
        book.headings(sheet, 0, names)
        for row, rule in enumerate(self._of_unit, start=1):
            self._write(book, sheet, row, self._unit_line(rule, row, held))
        for land in self.diagnosis.lands:
            for row, rule in enumerate(land.rules, start=self._of_land.get(land.key, (0, 0))[0]):
                self._write(book, sheet, row, self._line(land, rule, of_land))
        for column, width in enumerate(
            (
                component_width(self.diagnosis.controller.components),
                7,
                54,
                7,
                16,  # a demand says so behind its number
                12,
                *(12 for _ in FLAGGED),
                16,
                7,
                18,
                24,
                60,
                16,
            )
        ):
            sheet.set_column(column, column, width)
        sheet.autofilter(0, 0, self.last, len(names) - 1)
        sheet.print_area(0, 0, self.last, len(names) - 3)  # the sources stand beside the limits
        book.colour_words(sheet, (1, _VERDICT), (self.last, _VERDICT), VERDICTS)

    def _unit_line(self, rule: Rule, row: int, held: Callable[[SheetCondition, Circuit, str], str]) -> _Line:
        at = next(at for at in self.conditions if at.projection.condition == rule.condition)
        if rule.kind is RuleKind.TOTAL_SHARE:
            return _Line(rule, None, at("share"), at("share_new"))
        if rule.kind is RuleKind.RESERVE:
            return _Line(rule, None, at("reserve"), at("reserve_new"))
        if rule.circuit is not None:
            now, new = (held(at, rule.circuit, column) for column in ("held", "new"))
            return _Line(rule, None, f"ABS({cell(row, _NEW)}-{now})", new)
        return _Line(rule, None, f"(1-{at('p_g_held')}/MIN({at('permissible_low')},{at('p_g')}))*100")

    def _line(self, land: LandDiagnosis, rule: Rule, of_land: Callable[[LandKey, ColumnKey], str]) -> _Line:
        if rule.kind is RuleKind.WEAR:
            known = land.state.land.mounting_tolerance is not None
            tolerance = of_land(land.key, "tolerance") if known else None
            wear, mounting = of_land(land.key, "wear"), of_land(land.key, "c_m")
            return _Line(rule, land, wear, mounting=mounting, tolerance=tolerance)
        if rule.kind is RuleKind.CLEARANCE:
            return _Line(rule, land, of_land(land.key, "c_r"))
        at = next(at for at in self.conditions if at.projection.condition == rule.condition)
        names = ("share", "new_share") if self.diagnosis.pump_new is None else ("drawn", "new_drawn")
        now, new = (of_land(land.key, (name, at.prefix)) for name in names)
        if self.diagnosis.pump_new is None:
            return _Line(rule, land, now, new)
        capacity = f"MAX({at('supply')}-{at('slip_new')},0)"  # of a new pump: a worn one makes no land worn
        return _Line(rule, land, share_of(now, capacity), share_of(new, capacity))

    def _write(self, book: Book, sheet: Worksheet, row: int, line: _Line) -> None:
        rule, factor = line.rule, line.rule.kind.factor
        component, number = line.land.key if line.land else (OF_THE_UNIT, None)
        form = book.form(_FORMATS.get(rule.kind, rule.kind.suffix))
        for column, value in enumerate((component, number, _named(rule), rule.kind.unit)):
            book.put(sheet, row, column, value, book.form(align="left"))
        formula(sheet, row, _VALUE, line.value, rule.value * factor, form)
        if line.new is not None and rule.new is not None:
            formula(sheet, row, _NEW, line.new, rule.new * factor, form)
        rank = "1"
        for level, limit in rule.steps.levels:
            column = _column(level)
            text = self._limit(row, line, level)
            if text is None:  # by the valve body's file
                book.put(sheet, row, column, limit * factor, book.form(rule.kind.suffix, **CHANGEABLE))
            else:
                formula(sheet, row, column, text, limit * factor, form)
            reached = RANKED.index(_verdict(level)) + 1
            rank = f"IF({_reached(rule, cell(row, _VALUE), cell(row, column))},{reached},{rank})"
        fine = Verdict.OK if line.land is not None else self.diagnosis.within(rule)
        verdict = fine if rule.verdict == Verdict.OK else rule.verdict
        issued = RANKED.index(rule.verdict) + 1
        if rule.probable:  # as issued, until it is another value, or a better one
            value, known = cell(row, _VALUE), NOTHING_DELIVERED
            if isfinite(rule.value):
                known = cell(row, _ISSUED)
                book.put(sheet, row, _ISSUED, rule.value * factor, form)
            same, by_value = f"ABS({known})*{ROUNDED}", RANKED.index(replace(rule, reached=None).verdict) + 1
            if issued > by_value:  # what is worse still is no milder
                past = f"{value}<={known}+{same}" if rule.steps.falling else f"{value}>={known}-{same}"
                rank = f"IF({past},MAX({issued},{rank}),{rank})"
            else:
                rank = f"IF(ABS({value}-{known})<={same},{issued},{rank})"
        formula(sheet, row, _RANK, rank, issued)
        words = verdict_of_rank(cell(row, _RANK), self.say, fine)
        formula(sheet, row, _VERDICT, words, self.say.signed(verdict), book.form(**AFTER_A_NUMBER))
        origin = self.say.get("origins", rule.origin)
        for column, text in enumerate((self._decision(line), origin, rule.source), start=_DECISION):
            book.put(sheet, row, column, text, book.form(**AFTER_A_NUMBER))

    def _decision(self, line: _Line) -> str | None:
        """Return how sure a rule of the unit is; those of lands stand beside the lands."""
        decided = None if line.land is not None else self.diagnosis.decided(line.rule)
        return None if decided is None else self.say.get("decisions", decided.decision)

    def _limit(self, row: int, line: _Line, level: Level) -> str | None:
        """Return the formula of the limit at which a level begins; None where it is not of the set of limits."""
        rule, limits = line.rule, self.limits
        cells = [None, *(cell(row, _column(name)) for name, _ in rule.steps.levels), None]
        place = [name for name, _ in rule.steps.levels].index(level)
        milder, worse = cells[place], cells[place + 2]
        if rule.kind.is_share:
            return limits.share(rule.kind, level, cell(row, _NEW))
        if rule.steps.falling:
            return limits.reserve(level, cell(row, _NEW), worse)
        if line.mounting is not None:
            return limits.wear(level, line.mounting, line.tolerance, milder)
        own = rule.steps is not self.diagnosis.limits.rules.get(rule.kind)
        return None if own else limits.plain(rule.kind, level)


def _named(rule: Rule) -> str:
    """Name a rule; the headings say *from*, and a reserve reaches a level under its limit."""
    return Sentence("{rule}, reached under its limit", rule=rule.label) if rule.steps.falling else rule.label


def _reached(rule: Rule, value: str, limit: str) -> str:
    """Return the formula of whether a value has reached a limit; see `atleak.catalogue.limits.reaches`."""
    if rule.steps.falling:
        return f"{value}<{limit}*(1-{ROUNDED})"
    return f"{value}>=MAX({limit}*(1-{ROUNDED}),{ROUNDED}*{_factor(rule.kind.factor)})"


def _factor(factor: float) -> str:
    """Return the factor from SI to the unit of a rule as a formula takes it: ``1000``, ``0.001``, ``1E6``."""
    return f"{factor:g}".replace("e+0", "E").replace("e-0", "E-")


def _verdict(level: Level) -> Verdict:
    return level.verdict if isinstance(level, Band) else level


def _column(level: Level) -> int:
    return _FIRST_LEVEL + FLAGGED.index(_verdict(level))
