"""Lay out the sheet of rules: what each limit says of the unit at every condition and of each land."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.limits import Level, RuleKind
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    RANKED,
    Cell,
    LiveColumn,
    LiveSheet,
    component_width,
    fine_of,
    share_of,
    verdict_of_rank,
)
from atleak.report.xlsx.names import NOTHING_DELIVERED, ROUNDED
from atleak.rules import LandKey, Rule
from atleak.sentence import Sentence
from atleak.verdicts import FLAGGED, Band, Verdict

if TYPE_CHECKING:
    from atleak.report.xlsx.live import LiveSheets

RULES = Sentence("Rules")
_FORMATS = {RuleKind.RESERVE: "reserve", RuleKind.PAIR_SHARE: "share", RuleKind.TOTAL_SHARE: "share"}
OF_THE_UNIT = Sentence("whole unit")  # in place of a component


@dataclass(frozen=True)
class _Line:
    """One rule on the sheet."""

    rule: Rule
    land: LandDiagnosis | None = None  # None for the whole unit


@dataclass(frozen=True)
class _Asked:
    """What the formulas of a rule ask for: cells of other sheets."""

    value: str  # the formula of its value
    new: str | None = None  # the same when new, which limits may follow; None where it is as issued
    mounting: str | None = None  # the mounting clearance
    tolerance: str | None = None  # of the mounting clearance


class RuleCells:
    """Where every rule stands on its sheet: those of the whole unit first, then those of the lands."""

    def __init__(self, live: LiveSheets) -> None:
        self.live, self.diagnosis, self.say, self.limits = live, live.diagnosis, live.say, live.limits
        at_conditions = [at.projection for at in live.conditions]
        of_unit = [self.diagnosis.total_rule(at) for at in at_conditions]
        of_unit += [rule for at in at_conditions for rule in self.diagnosis.pressure_rules_at(at)]
        lines = [_Line(rule) for rule in of_unit]
        lines += [_Line(rule, land) for land in self.diagnosis.lands for rule in land.rules]
        self.sheet = LiveSheet(self.say.sentence(RULES), self._columns(), lines)
        self._row = {id(line.rule): row for row, line in enumerate(lines, start=1)}

    def _columns(self) -> Sequence[LiveColumn]:
        width = component_width(self.diagnosis.controller.components)
        levels = (
            LiveColumn(level, Sentence("{level} from", level=self.say.level(level)), width=12) for level in FLAGGED
        )
        return (
            LiveColumn("component", Sentence("component"), width=width),
            LiveColumn("land", Sentence("land"), width=7),
            LiveColumn("rule", Sentence("rule"), width=54),
            LiveColumn("unit", Sentence("unit"), width=7),
            LiveColumn("value", Sentence("value"), width=16),  # a demand says so behind its number
            LiveColumn("new", Sentence("when new"), width=12),
            *levels,
            LiveColumn("verdict", Sentence("verdict"), width=16),
            LiveColumn("rank", Sentence("rank"), width=7),
            LiveColumn("decision", Sentence("decision as issued"), width=18),
            LiveColumn("origin", Sentence("origin of the limit"), width=24),
            LiveColumn("source", Sentence("source"), width=60),
            LiveColumn("issued", Sentence("value as issued"), width=16),  # of a rule whose level is the likelier one
        )

    @property
    def ranks(self) -> str:
        """Return the stretch of cells with the ranks of all verdicts."""
        return self.sheet.whole("rank")

    def ranks_of(self, key: LandKey) -> str | None:
        """Return the stretch of cells with the ranks of one land's verdicts; None where no rule judges it."""
        lines = enumerate(self.sheet.items, start=1)
        rows = [row for row, line in lines if line.land is not None and line.land.key == key]
        return self.sheet.span(rows[0], rows[-1], "rank") if rows else None

    def rank(self, rule: Rule) -> str:
        """Return the cell with the rank of a rule's verdict."""
        return self.sheet.cell(self._row[id(rule)], "rank")

    def verdict(self, land: LandDiagnosis, rule: Rule) -> str:
        """Return the formula of what one rule says of a land; half a pair is never called ok."""
        return verdict_of_rank(self.rank(rule), self.say, fine_of(land))

    def limits_and_rank(self, rule: Rule) -> tuple[dict[Level, str], str]:
        """Return the cells with the limits of a rule of the unit, by level, and with its rank."""
        row = self._row[id(rule)]
        return {level: self.sheet.cell(row, _verdict(level)) for level, _ in rule.steps.levels}, self.rank(rule)

    def of_unit(self, rule: Rule) -> str:
        """Return the formula of what one rule says of the unit; one that nobody measured is never called ok."""
        return verdict_of_rank(self.rank(rule), self.say, self.diagnosis.within(rule))

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write what each rule says."""
        self.sheet.write(book, sheet, 2, self._cells)
        sheet.print_area(0, 0, len(self.sheet.items), len(self.sheet.columns) - 3)  # sources stand beside the limits

    def _asked(self, line: _Line, row: int) -> _Asked:
        rule, held = line.rule, self.live.circuits.held
        at = next((at for at in self.live.conditions if at.projection.condition == rule.condition), None)
        if line.land is not None:
            return self._asked_of_land(rule, line.land.key, line.land.state.land.mounting_tolerance is not None)
        assert at is not None
        if rule.kind is RuleKind.TOTAL_SHARE:
            return _Asked(at("share"), at("share_new"))
        if rule.kind is RuleKind.RESERVE:
            return _Asked(at("reserve"), at("reserve_new"))
        if rule.circuit is not None:
            now, new = (held(at, rule.circuit, column) for column in ("held", "new"))
            return _Asked(f"ABS({cell(row, self.sheet.place['new'])}-{now})", new)
        return _Asked(f"(1-{at('p_g_held')}/MIN({at('permissible_low')},{at('p_g')}))*100")

    def _asked_of_land(self, rule: Rule, key: LandKey, tolerated: bool) -> _Asked:
        of_land = self.live.of_land
        if rule.kind is RuleKind.WEAR:
            tolerance = of_land(key, "tolerance") if tolerated else None
            return _Asked(of_land(key, "wear"), mounting=of_land(key, "c_m"), tolerance=tolerance)
        if rule.kind is RuleKind.CLEARANCE:
            return _Asked(of_land(key, "c_r"))
        at = next(at for at in self.live.conditions if at.projection.condition == rule.condition)
        if self.diagnosis.pump_new is None:
            return _Asked(of_land(key, ("share", at.prefix)), of_land(key, ("new_share", at.prefix)))
        now, new = (of_land(key, (name, at.prefix)) for name in ("drawn", "new_drawn"))
        capacity = f"MAX({at('supply')}-{at('slip_new')},0)"  # of a new pump: a worn one makes no land worn
        return _Asked(share_of(now, capacity), share_of(new, capacity))

    def _cells(self, row: int, line: _Line) -> dict[Any, Cell]:
        rule, factor, asked = line.rule, line.rule.kind.factor, self._asked(line, row)
        here = {key: cell(row, column) for key, column in self.sheet.place.items()}
        kind = _FORMATS.get(rule.kind, rule.kind.suffix)
        fine = Verdict.OK if line.land is not None else self.diagnosis.within(rule)
        verdict = fine if rule.verdict == Verdict.OK else rule.verdict
        component, number = line.land.key if line.land else (OF_THE_UNIT, None)
        decided = None if line.land is not None else self.diagnosis.decided(rule)  # those of lands stand beside them
        given = {"component": component, "land": number, "rule": _named(rule), "unit": rule.kind.unit}
        cells = {key: Cell("plain", value, look={"align": "left"}) for key, value in given.items()}
        cells["value"] = Cell(kind, rule.value * factor, asked.value)
        if asked.new is not None and rule.new is not None:
            cells["new"] = Cell(kind, rule.new * factor, asked.new)
        for level, limit in rule.steps.levels:
            text = self._limit(here, rule, asked, level)
            by_file = text is None
            cells[_verdict(level)] = (
                Cell(rule.kind.suffix, limit * factor, look=CHANGEABLE) if by_file else Cell(kind, limit * factor, text)
            )
        if rule.probable and isfinite(rule.value):
            cells["issued"] = Cell(kind, rule.value * factor)
        cells["rank"] = Cell("plain", RANKED.index(rule.verdict) + 1, _rank(rule, here))
        words = verdict_of_rank(here["rank"], self.say, fine)
        behind = {
            "verdict": Cell("plain", self.say.signed(verdict), words, AFTER_A_NUMBER),
            "decision": Cell("plain", decided and self.say.get("decisions", decided.decision), look=AFTER_A_NUMBER),
            "origin": Cell("plain", self.say.get("origins", rule.origin), look=AFTER_A_NUMBER),
            "source": Cell("plain", rule.source, look=AFTER_A_NUMBER),
        }
        return cells | behind

    def _limit(self, here: dict[Any, str], rule: Rule, asked: _Asked, level: Level) -> str | None:
        """Return the formula of the limit at which a level begins; None where it is not of the set of limits."""
        cells = [None, *(here[_verdict(name)] for name, _ in rule.steps.levels), None]
        place = [name for name, _ in rule.steps.levels].index(level)
        milder, worse = cells[place], cells[place + 2]
        if rule.kind.is_share:
            return self.limits.share(rule.kind, level, here["new"])
        if rule.steps.falling:
            return self.limits.reserve(level, here["new"], worse)
        if asked.mounting is not None:
            return self.limits.wear(level, asked.mounting, asked.tolerance, milder)
        own = rule.steps is not self.diagnosis.limits.rules.get(rule.kind)
        return None if own else self.limits.plain(rule.kind, level)


def _rank(rule: Rule, here: dict[Any, str]) -> str:
    """Return the formula of a rule's rank: of the worst level reached, or of the likelier one as long as it is that."""
    rank, value = "1", here["value"]
    for level, _ in rule.steps.levels:
        rank = f"IF({_reached(rule, value, here[_verdict(level)])},{RANKED.index(_verdict(level)) + 1},{rank})"
    if not rule.probable:
        return rank
    issued, by_value = (RANKED.index(each.verdict) + 1 for each in (rule, replace(rule, reached=None)))
    known = here["issued"] if isfinite(rule.value) else NOTHING_DELIVERED  # until it is another value, or a better one
    same = f"ABS({known})*{ROUNDED}"
    if issued <= by_value:
        return f"IF(ABS({value}-{known})<={same},{issued},{rank})"
    past = f"{value}<={known}+{same}" if rule.steps.falling else f"{value}>={known}-{same}"
    return f"IF({past},MAX({issued},{rank}),{rank})"  # what is worse still is no milder


def _named(rule: Rule) -> str:
    """Name a rule; the headings say *from*, and a reserve reaches a level under its limit."""
    return Sentence("{rule}, reached under its limit", rule=rule.label) if rule.steps.falling else rule.label


def _reached(rule: Rule, value: str, limit: str) -> str:
    """Return the formula of whether a value has reached a limit; see `atleak.catalogue.limits.reaches`."""
    if rule.steps.falling:
        return f"{value}<{limit}*(1-{ROUNDED})"
    factor = f"{rule.kind.factor:g}".replace("e+0", "E").replace("e-0", "E-")  # as a formula takes it: 1000, 1E6
    return f"{value}>=MAX({limit}*(1-{ROUNDED}),{ROUNDED}*{factor})"


def _verdict(level: Level) -> Verdict:
    return level.verdict if isinstance(level, Band) else level
