"""Say an estimate in a reader's language: its lines, its sums, and what is open, for pages, PDF and workbook alike."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from decimal import Decimal

from atleak.analysis.estimate import CARRIED_OUT, Estimate, Line, Sum
from atleak.analysis.record_doubts import components_of, pump_undecided, undecided, without_reason
from atleak.analysis.repair.options import decimals
from atleak.catalogue.controller import Controller
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.measurements.job_card import Job, RepairDecision
from atleak.report.tables.names import component_words, components_words, has_number, land_number
from atleak.report.tables.sentences import rule_limited, rule_value

_COLUMNS = (
    "component", "lands", "repair", "work", "part_number", "price", "hours", "labour", "currency", "state", "reason",
)  # fmt: skip


@dataclass(frozen=True)
class EstimateWords:
    """The words and numbers of one estimate."""

    estimate: Estimate
    say: Wording

    def pair(self, line: Line) -> str:
        """Name the component with the lands that a line is about, ``8/1, 8/2 valve``, or those that a kit mends."""
        controller, decision = self.estimate.diagnosis.controller, line.decision
        if len(components := components_of(decision, controller)) > 1:
            return components_words(controller, components, self.say)
        lands = self.lands(line)
        if lands == component_words(controller, decision.component, self.say):
            return lands
        name = isolated(self.say.name(controller.components.get(decision.component, "")))
        return f"{lands} {name}".strip() if has_number(controller, decision.component) else lands

    def lands(self, line: Line) -> str:
        """Name the lands that a line is about in short, ``8/1, 8/2``; the component where it is about none."""
        controller, decision = self.estimate.diagnosis.controller, line.decision
        keys = [land.key for land in line.lands]
        if not keys and decision.land:
            keys = [(decision.component, decision.land)]
        lands = ", ".join(land_number(controller, key, self.say) for key in keys)
        return lands or component_words(controller, decision.component, self.say)

    def work(self, line: Line) -> str:
        """Say what is done."""
        named = self.say.name(line.decision.work) or line.decision.repair
        return named or self.say("estimate.as_new")

    def state(self, line: Line) -> str:
        """Say what was decided, and where the customer said so on his screen, who and when."""
        decision, say = line.decision, self.say
        state = say("estimate.open") if decision.decision is None else say.get("job_decisions", decision.decision)
        if not decision.decided_by or decision.decided_at is None:
            return state
        return f"{state} ({isolated(decision.decided_by)}, {say.moment(decision.decided_at)})"

    def agreed(self, line: Line) -> dict[str, list[str]] | str:
        """Return the boxes in which to agree to a line or not, as a cell holds them; else what was decided."""
        if line.decision.decision in (None, "proposed"):
            return {"boxes": [self.say("estimate.yes"), self.say("estimate.no")]}
        return self.state(line)

    def money(self, value: Decimal | None) -> str:
        """Write an amount with the currency's decimals; a dash where it is unknown."""
        return self.say.number(None if value is None else float(value), decimals(self.estimate.currency))

    def summed(self, value: Decimal | None, complete: bool) -> str:
        """Write a sum; before one from which an amount is missing, that it is at least so much."""
        return self.money(value) if complete or value is None else f"≥ {self.money(value)}"

    def sum_row(self, name: str, each: Sum) -> tuple[str, ...]:
        """Return the cells of a sum: its name, parts, labour, net, tax and total."""
        parts = self.summed(each.parts, not each.without_price)
        work = self.summed(each.work, not each.without_work)
        return name, parts, work, *(self.summed(value, each.complete) for value in (each.net, each.tax, each.gross))

    def hours(self, line: Line) -> str:
        """Write the hours of work; a dash where they are unknown."""
        hours = line.hours
        return "–" if hours is None else self.say.plain(hours)

    def amount(self, line: Line) -> str:
        """Write part and work together; a dash where neither is known."""
        known = [each for each in (line.part, line.work) if each is not None]
        return self.money(sum(known, Decimal(0)) if known else None)

    def lacks(self, line: Line) -> str:
        """Say what is worse most without the line."""
        rule, within, without = self.lacking(line)
        return self.say("estimate.lacks", rule=rule, within=within, without=without) if without else rule

    def lacking(self, line: Line) -> tuple[str, str, str]:
        """Return what is worse most without the line, its value with and without it; no values where nothing is."""
        gain = self.estimate.gain_of(line)
        if gain is None:
            return self.say("estimate.lacks_nothing"), "", ""
        return self.rule(gain.without), self._value(gain.within), self._value(gain.without)

    def rule(self, rule: Rule) -> str:
        """Name what a rule limits, of which circuit and at which condition."""
        condition = (
            "" if rule.condition is None else self.say("estimate.at", condition=self.say.condition(rule.condition))
        )
        return ", ".join(filter(None, (rule_limited(rule, self.say), condition)))

    def past(self, rule: Rule) -> str:
        """Say where a rule is past its limit, and which level it has reached."""
        return f"{self.rule(rule)} {self._value(rule)} ({self.say.level(rule.level)})"

    def _value(self, rule: Rule) -> str:
        return rule_value(rule.value, rule.kind, self.say)

    @property
    def sums(self) -> list[tuple[str, Sum]]:
        """Return the sums by state, that of all that is to be done or was last, where it is not one state alone."""
        rows = [(self.say.get("job_decisions", state), each) for state, each in self.estimate.sums.items()]
        due = [state for state in self.estimate.sums if state in CARRIED_OUT]
        return [*rows, (self.say("estimate.all_due"), self.estimate.total)] if len(due) > 1 else rows

    def chosen_by(self) -> Iterator[str]:
        """Say the goal, by what the repairs were chosen, and whether that is sure."""
        say, choice = self.say, self.estimate.choice
        yield say(f"estimate.goal_{choice.goal}")
        if choice.chosen:
            yield say(f"estimate.{choice.basis}")
        if not choice.proven:
            yield say("estimate.not_proven", rounds=choice.rounds)

    def ends(self) -> Iterator[str]:
        """Say what the unit is like with all lines that are carried out, by the engine."""
        say, estimate = self.say, self.estimate
        if past := estimate.past:
            yield say("estimate.past", rules="; ".join(map(self.past, past)))
        elif estimate.diagnosis.judged:  # of a unit that nobody measured nothing is green
            yield say("estimate.green")
        if estimate.lands_past:
            lands = _numbers_of(estimate.lands_past, estimate.diagnosis.controller, say)
            yield say("estimate.lands_past", lands=lands)

    def missing(self, aside: Collection[Line] = ()) -> Iterator[str]:
        """Say what is in no sum, and why, of all lines but those ``aside``."""
        due = self.estimate.total
        price, work = ([line for line in lines if line not in aside] for lines in (due.without_price, due.without_work))
        if price and price == work:
            yield self.say("estimate.without_both", lines="; ".join(map(self._unpriced, price)))
            return
        if price:
            yield self.say("estimate.without_price", lines="; ".join(map(self._unpriced, price)))
        if work:
            yield self.say("estimate.without_work", lines="; ".join(map(self.lands, work)))

    def _unpriced(self, line: Line) -> str:
        other, lands = line.other_currency, self.lands(line)
        return self.say("estimate.other_currency", line=lands, currency=other) if other else lands

    def rounding(self) -> str:
        """Say the currency, and how amounts are rounded."""
        say, tax = self.say, self.estimate.terms.tax_percent
        currency = self.estimate.currency or say("estimate.no_currency")
        said = say("estimate.rounding", currency=currency, decimals=decimals(currency))
        percent = None if tax is None else f"{say.plain(tax)}\u00a0%"
        return said if percent is None else f"{said} {say('estimate.rounding_tax', tax=percent)}"

    def csv(self) -> bytes:
        """Return lines and sums as a table for other programs: with a point as decimal sign, UTF-8 with a mark."""
        target = io.StringIO()
        table = csv.writer(target, lineterminator="\r\n")
        table.writerow(_COLUMNS)
        for line in self.estimate.lines:
            decision = line.decision
            lands = " ".join(f"{component}/{land}" for component, land in (each.key for each in line.lands))
            components = " ".join(components_of(decision, self.estimate.diagnosis.controller))
            row: list[object] = [components, lands, decision.repair, self.work(line), decision.part_number]
            row += [line.part, line.hours, line.work, self.estimate.currency, decision.decision, decision.reason]
            table.writerow([_safe(each) for each in row])
        table.writerow([])
        table.writerow(["sum", "parts", "labour", "net", "tax", "total", "currency", "complete"])
        for name, each in self.sums:
            amounts = (each.parts, each.work, each.net, each.tax, each.gross)
            table.writerow([name, *map(_safe, amounts), self.estimate.currency, each.complete])
        return target.getvalue().encode("utf-8-sig")


def _numbers_of(lands: Iterable[LandDiagnosis], controller: Controller, say: Wording) -> str:
    """Name lands in short: ``8/1, 8/2``, or ``manual valve/3`` where components have no numbers."""
    return ", ".join(land_number(controller, land.key, say) for land in lands)


def open_words(diagnosis: Diagnosis, job: Job, say: Wording, *, closing: bool) -> Iterator[str]:
    """Say what is to be replaced, lands or pump, without a decision, and what was declined without a reason."""
    open_lands = _numbers_of(undecided(diagnosis, job, closing=closing), diagnosis.controller, say)
    pump = say("pump.name") if pump_undecided(diagnosis, job, closing=closing) else ""
    if pump or open_lands:
        yield say("estimate.undecided", lands=", ".join(filter(None, (pump, open_lands))))
    declined = without_reason(job)
    if declined:
        yield say(
            "estimate.reason_asked", lines="; ".join(_called(each, diagnosis.controller, say) for each in declined)
        )


def _called(decision: RepairDecision, controller: Controller, say: Wording) -> str:
    """Name a decision by its component and land, or by its work."""
    component, land = decision.component, decision.land
    if len(components := components_of(decision, controller)) > 1:
        return components_words(controller, components, say)
    if component not in controller.components:
        return f"{component}{'' if land is None else f'/{land}'}" or decision.repair or decision.work
    return (
        component_words(controller, component, say) if land is None else land_number(controller, (component, land), say)
    )


def _safe(value: object) -> object:
    """Return a cell that no spreadsheet takes for a formula."""
    text = isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r")
    return f"'{value}" if text else "" if value is None else value
