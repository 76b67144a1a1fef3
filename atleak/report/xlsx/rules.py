"""Write the sheets of limits and of rules: what each limit says of the unit at every condition and of each land.

A limit of wear depends on the land's mounting clearance, one of a share on the same share when new; see
`atleak.catalogue.limits.Steps`, which computes what these formulas give.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Literal

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.limits import Level, Limits, RuleKind, Steps
from atleak.catalogue.repairs import LandKey
from atleak.common.sentences import Name, Sentence
from atleak.common.units import PERCENT, UM, UnitOf
from atleak.common.verdicts import BANDS, FLAGGED, Band, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.report.xlsx.book import ReportBook, cell
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    CLEARANCE,
    NOTHING_DELIVERED,
    PRESSURE,
    RANKED,
    ROUNDING_NAME,
    LiveCell,
    LiveColumn,
    LiveSheet,
    component_width,
    fine_of,
    largest_of,
    of_limit,
    share_of,
    verdict_of_rank,
    write_cell,
)
from atleak.report.xlsx.page import SheetPage

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

_Part = Literal["limit", "at_least", "growth", "added", "fall"]  # of a limit: each stands in a row of its own
LIMITS_SHEET = Sentence("Limits")
_LIMIT, _ORIGIN, _SOURCE = Sentence("limit"), Sentence("origin"), Sentence("source")
_LABELS: dict[RuleKind, dict[_Part, Sentence]] = {
    RuleKind.WEAR: {
        "limit": Sentence("wear [%]"),
        "at_least": Sentence("and clearance over c_m and its tolerance [{unit}]", unit=CLEARANCE),
    },
    RuleKind.CLEARANCE: {"limit": Sentence("radial clearance [{unit}]", unit=CLEARANCE)},
    RuleKind.PAIR_SHARE: {
        "limit": Sentence("share of pump flow of one land [%]"),
        "growth": Sentence("and growth over the same land new [%]"),
        "added": Sentence("and points of pump flow added to it"),
    },
    RuleKind.TOTAL_SHARE: {
        "limit": Sentence("share of pump flow of the whole valve body [%]"),
        "growth": Sentence("and growth over the same unit new [%]"),
        "added": Sentence("and points of pump flow added to it"),
    },
    RuleKind.RESERVE: {
        "limit": Sentence("reserve of the pump, under [-]"),
        "fall": Sentence("or, where the same unit new is under it, fall from that [%]"),
    },
    RuleKind.CIRCUIT_LOSS: {"limit": Sentence("pressure that a circuit lost against new [{unit}]", unit=PRESSURE)},
    RuleKind.PERMISSIBLE_PRESSURE: {"limit": Sentence("main pressure below the permissible [%]")},
    RuleKind.COMMANDED_PRESSURE: {"limit": Sentence("main pressure off the commanded [{unit}]", unit=PRESSURE)},
}
_NOTE = Sentence(
    "A level begins where all of its rows are reached; a level of wear never begins below the one before it. An empty "
    "field asks for nothing, and a number filled in there is not followed. A level of the reserve is reached under its "
    "limit, one of a limit of 0 by anything over it."
)


@dataclass(frozen=True)
class _Row:
    kind: RuleKind
    part: _Part
    values: Mapping[Level, float]  # in the unit that people read


class LimitCells:
    """The name of every part of every limit, and the sheet on which they stand."""

    def __init__(self, limits: Limits, say: Wording) -> None:
        self.limits = limits
        self._sheet = say.sentence(LIMITS_SHEET)
        self.levels = list[Level](dict.fromkeys([*FLAGGED, *BANDS[1:]]))  # a column each
        self._rows = [row for kind, steps in limits.rules.items() for row in _rows(kind, steps)]
        self._names = {
            (row.kind, level, row.part): of_limit(row.kind, row.part, level)
            for row in self._rows
            for level in row.values
        }

    def wear(self, level: Level, mounting: str, tolerance: str | None, before: str | None) -> str:
        """Return the formula of a limit of wear [%] from the cells of c_m, its tolerance and the limit before it."""
        kind = RuleKind.WEAR
        terms = [self._names[kind, level, "limit"]]
        if (kind, level, "at_least") in self._names:
            at_least = self._names[kind, level, "at_least"]
            least = f"({at_least}+{tolerance})" if tolerance else at_least
            terms.append(f"{least}/{mounting}*100")
        return largest_of([*terms, *([before] if before else [])])

    def plain(self, kind: RuleKind, level: Level) -> str:
        """Return the cell of a limit that is the same for every value of its kind."""
        return self._names[kind, level, "limit"]

    def reserve(self, level: Level, new: str, worse: str | None) -> str:
        """Return the formula of a limit of the reserve from the cells of that when new and of the worse level's limit.

        See `atleak.catalogue.limits.Steps.under`.
        """
        limit, fall = (self._names[RuleKind.RESERVE, level, part] for part in ("limit", "fall"))
        fallen = f"IF({new}<{limit},(1-{fall}/100)*{new},{limit})"
        return largest_of([fallen, worse or f"MIN({limit},1)"])

    def share(self, kind: RuleKind, level: Level, new: str) -> str:
        """Return the formula of a limit of a share [%] from the cell of the same share when new [%]."""
        terms = [self._names[kind, level, "limit"]] if (kind, level, "limit") in self._names else []
        if (kind, level, "growth") not in self._names:
            return largest_of(terms)
        growth, added = (self._names[kind, level, part] for part in ("growth", "added"))
        grown = largest_of([*terms, f"{new}*(1+{growth}/100)", f"{new}+{added}"])
        return f"MIN({grown},{NOTHING_DELIVERED})"

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write every limit with its origin; what is blue is followed."""
        origin = 1 + len(self.levels)
        page = SheetPage(book, sheet, (46, *[12] * len(self.levels), 24, 70))
        page.headings(0, [_LIMIT, *(book.say.level(level) for level in self.levels), _ORIGIN, _SOURCE])
        for row, each in enumerate(self._rows, start=1):
            first = each.part == "limit"
            page.text(row, 0, _LABELS[each.kind][each.part], bold=first, indent=0 if first else 1)
            for level, value in each.values.items():
                column = 1 + self.levels.index(level)
                of = _quantity(each.kind, each.part)
                form = _as_stated("um", value, of, book.say)
                write_cell(book, sheet, row, column, LiveCell(form, value, look=CHANGEABLE, of=of))
                book.define(self._names[each.kind, level, each.part], row, column, self._sheet)
            if first:
                steps = self.limits.rules[each.kind]
                page.text(row, origin, book.say.get("origins", steps.origin), **AFTER_A_NUMBER)
                page.text(row, origin + 1, Name(steps.source))
        row = page.across(len(self._rows) + 2, _NOTE)
        page.pairs(row, [(Sentence("limit set"), Name(self.limits.name)), (Sentence("note"), Name(self.limits.note))])


def _quantity(kind: RuleKind, part: _Part) -> str | None:
    return kind.quantity if part == "limit" else "clearance" if part == "at_least" else None


def _as_stated(number: str, value: float, of: str | None, say: Wording) -> str:
    """Return the format of a limit: in another unit than its file's with the digits that its source may have had."""
    if of is None or say.units == "metric":
        return number
    _, point, places = f"{say.system[of].stated(value):.6g}".partition(".")
    return f"0{point}{'0' * len(places)}"


def _rows(kind: RuleKind, steps: Steps) -> Iterable[_Row]:
    """Return the rows of one quantity: its limits first, then what else a level asks for."""
    yield _Row(kind, "limit", {level: limit * kind.factor for level, limit in steps.levels if steps.has_limit(level)})
    at_least = {level: value * UM for level, value in steps.at_least.items()}
    growth = {level: grown * PERCENT for level, (grown, _) in steps.growth.items()}
    added = {level: points * PERCENT for level, (_, points) in steps.growth.items()}
    fall = {} if steps.fall is None else {level: steps.fall * PERCENT for level, _ in steps.levels}
    others: tuple[tuple[_Part, dict[Level, float]], ...] = (
        ("at_least", at_least), ("growth", growth), ("added", added), ("fall", fall),
    )  # fmt: skip
    for part, values in others:
        if values:
            yield _Row(kind, part, values)


RULES = Sentence("Rules")
_RULE = 54  # [characters] of the column of rules
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
        self._ends: dict[LandKey, tuple[int, int]] = {}  # first and last row of a land
        for row, line in enumerate(lines, start=1):
            if line.land is not None:
                self._ends[line.land.key] = self._ends.get(line.land.key, (row, row))[0], row

    def _columns(self) -> Sequence[LiveColumn]:
        width = component_width(self.diagnosis.controller.components)
        levels = (
            LiveColumn(level, Sentence("{level} from", level=self.say.level(level)), width=12) for level in FLAGGED
        )
        return (
            LiveColumn("component", Sentence("component"), width=width),
            LiveColumn("land", Sentence("land"), width=7),
            LiveColumn("rule", Sentence("rule"), width=_RULE),
            LiveColumn("unit", Sentence("unit"), width=9),
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
        return self.sheet.span(*self._ends[key], "rank") if key in self._ends else None

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

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write what each rule says."""
        self.sheet.write(book, sheet, self._cells)

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

    def _cells(self, row: int, line: _Line) -> dict[Any, LiveCell]:
        rule, factor, asked = line.rule, line.rule.kind.factor, self._asked(line, row)
        here = {key: cell(row, column) for key, column in self.sheet.place.items()}
        kind, of = _FORMATS.get(rule.kind, rule.kind.suffix), rule.kind.quantity
        fine = Verdict.OK if line.land is not None else self.diagnosis.within(rule)
        verdict = fine if rule.verdict == Verdict.OK else rule.verdict
        component, number = line.land.key if line.land else (OF_THE_UNIT, None)
        decided = None if line.land is not None else self.diagnosis.decided(rule)  # those of lands stand beside them
        given = {
            "component": component,
            "land": number,
            "rule": _named(rule),
            "unit": UnitOf(rule.kind.quantity) if rule.kind.quantity else rule.kind.unit,
        }
        cells = {key: LiveCell("plain", value, look={"align": "left"}) for key, value in given.items()}
        if len(self.say.sentence(given["rule"])) > _RULE + _RULE // 8:  # letters are narrower than digits
            cells["rule"] = LiveCell("plain", given["rule"], look={"align": "left", "text_wrap": True})
        cells["value"] = LiveCell(kind, rule.value * factor, asked.value, of=of)
        if asked.new is not None and rule.new is not None:
            cells["new"] = LiveCell(kind, rule.new * factor, asked.new, of=of)
        for level, limit in rule.steps.levels:
            text = self._limit(here, rule, asked, level)
            form = _as_stated(kind if text else rule.kind.suffix, limit * factor, of, self.say)
            look: Mapping[str, Any] = {} if text else CHANGEABLE  # of the valve body's file
            cells[_verdict(level)] = LiveCell(form, limit * factor, text, look, of)
        if rule.probable and isfinite(rule.value):
            cells["issued"] = LiveCell(kind, rule.value * factor, of=of)
        cells["rank"] = LiveCell("plain", RANKED.index(rule.verdict) + 1, _rank(rule, here))
        words = verdict_of_rank(here["rank"], self.say, fine)
        behind = {
            "verdict": LiveCell("plain", self.say.signed(verdict), words, AFTER_A_NUMBER),
            "decision": LiveCell("plain", decided and self.say.get("decisions", decided.decision), look=AFTER_A_NUMBER),
            "origin": LiveCell("plain", self.say.get("origins", rule.origin), look=AFTER_A_NUMBER),
            "source": LiveCell("plain", self.say.name(rule.source), look=AFTER_A_NUMBER),
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
    same = f"ABS({known})*{ROUNDING_NAME}"
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
        return f"{value}<{limit}*(1-{ROUNDING_NAME})"
    factor = f"{rule.kind.factor:g}".replace("e+0", "E").replace("e-0", "E-")  # as a formula takes it: 1000, 1E6
    return f"{value}>=MAX({limit}*(1-{ROUNDING_NAME}),{ROUNDING_NAME}*{factor})"


def _verdict(level: Level) -> Verdict:
    return level.verdict if isinstance(level, Band) else level
