"""Judge gauge readings: main pressure against what is permissible, a circuit by what it has lost against new."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import cast

import numpy as np

from atleak.catalogue.circuits import Circuit, PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import Message, Place
from atleak.common.printable import brief
from atleak.common.sentences import Sentence, in_a_row
from atleak.common.units import KPA, Quantity, gear_name
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.gauge_card import Expected, StandsToExpected, held_at, section_of
from atleak.diagnosis.gauge_patterns import GaugeStanding, Pattern, Stands, find_patterns
from atleak.diagnosis.missing import Cause, Missing
from atleak.diagnosis.rules import Rule, permissible_steps
from atleak.diagnosis.uncertainty import RuleDecision
from atleak.diagnosis.uncertainty.decision import decide_normal, decide_rule
from atleak.diagnosis.uncertainty.posterior import Fault
from atleak.diagnosis.uncertainty.weighing import SURELY, Lost
from atleak.diagnosis.weighed_evidence import TOO_HIGH, AllEvidence, Weighed
from atleak.engine.operation import LINE as LINE_SECTION
from atleak.measurements.clearances import LandClearance
from atleak.measurements.gauge_readings import (
    LINE_TAP,
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    circuit_at,
    gear_in,
    permitted,
    ranges_of,
    tap_name,
    taps_of,
)

_SHOWN = 8  # cells named in a message

_NOTHING_PERMITTED = Sentence("the valve body's file says nothing that they must reach")
_CONTRADICT = Sentence(
    "they and the other gauge readings contradict one another: check gauge and tap, and read them again"
)


@dataclass(frozen=True)
class CheckedReading:
    """One gauge reading beside what is permissible, what the engine expects, and the line's own reading."""

    reading: GaugeReading
    tap_name: str
    gear: int | None  # that is taken for the range; None where the gears do not tell
    permissible: PermissiblePressure | None  # of main pressure; None where the file does not tell
    #: [Pa] that pump or circuit hold there by the engine; None where no operating point is like it
    expected: float | None
    line: float | None  # [Pa] that the circuit should reach, from the line's gauge beside it; None where it need not
    decisions: tuple[RuleDecision, ...] = ()  # of every rule that judges it
    lost: Lost | None = None  # by its circuit, or the line, against new; None where that is not judged
    #: against new, and what explains it; None where nothing can be computed there
    missing: Missing | None = field(default=None, compare=False)
    unjudged: Sentence | None = None  # why no rule judges it
    shown: Expected | None = None  # what gauges would show there; None where nothing can be computed

    @property
    def stands_to_expected(self) -> StandsToExpected | None:
        """Return how it stands to what gauges would show of the unit, new and as measured; None where that is open."""
        return None if self.shown is None else self.shown.stands(self.reading.pressure)

    @property
    def cell(self) -> GaugeCell:
        """Return its cell."""
        return self.reading.cell

    @property
    def label(self) -> Sentence:
        """Return its cell's name for people: ``"D, slow idle, line"``."""
        return Sentence(
            "{range}, {engine}, {tap}", range=self.cell.range, engine=self.cell.engine.label, tap=self.tap_name
        )

    @property
    def stands(self) -> Stands | None:
        """Return how main pressure stands to what is permissible; None where nothing is."""
        if self.permissible is None:
            return None
        low, high = self.permissible.low, self.permissible.high
        if low is not None and self.reading.pressure < low:
            return "low"
        return "high" if high is not None and self.reading.pressure > high else "normal"

    @property
    def over(self) -> float | None:
        """Return by how much it is over what is permissible [Pa]; None where it is not."""
        high = self.permissible.high if self.permissible else None
        return self.reading.pressure - high if high is not None and self.stands == "high" else None

    @property
    def below_line(self) -> float | None:
        """Return how far a circuit is below the pressure that it should reach [Pa]; None where it need not."""
        return None if self.line is None else self.line - self.reading.pressure

    @property
    def loss(self) -> float | None:
        """Return what its circuit has lost against new [Pa], as likely more as less; None where that is not judged."""
        return None if self.lost is None else max(self.lost.quantile(0.5), 0.0)

    @property
    def loss_interval(self) -> tuple[float, float] | None:
        """Return between which losses [Pa] it lies in 95 of 100 cases."""
        return None if self.lost is None else (self.lost.quantile(0.025), self.lost.quantile(0.975))

    @property
    def over_limit(self) -> float | None:
        """Return the probability that the loss has reached the limit it is judged by; None where it is not judged."""
        return self.deciding.probability_over_limit if self.lost is not None and self.deciding else None

    @property
    def verdict(self) -> Verdict | None:
        """Return the worst verdict on it; None where no rule judges it, since nothing unjudged is ok."""
        return worst(each.rule.verdict for each in self.decisions) if self.decisions else None

    @property
    def deciding(self) -> RuleDecision | None:
        """Return the decision that belongs to the verdict; None where no rule judges it."""
        return max(self.decisions, key=lambda each: each.severity, default=None)


@brief
@dataclass(frozen=True)
class PressureCheck:
    """A pressure table with everything that is said of it."""

    table: PressureTable
    readings: tuple[CheckedReading, ...]  # in the order of the unit's ranges
    patterns: tuple[Pattern, ...]
    messages: tuple[Message, ...]
    #: what is missing of main pressure where a log shows it
    logged: tuple[Missing, ...] = field(default=(), compare=False)
    weighed: Weighed = field(kw_only=True, compare=False, repr=False)

    @cached_property
    def decisions(self) -> tuple[RuleDecision, ...]:
        """Return the decision on every rule that judges a reading."""
        return tuple(each for reading in self.readings for each in reading.decisions)

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that judges a reading."""
        return tuple(each.rule for each in self.decisions)

    @property
    def verdict(self) -> Verdict | None:
        """Return the worst verdict on any reading; None where no rule judges one."""
        return worst(rule.verdict for rule in self.rules) if self.decisions else None

    @property
    def deciding(self) -> RuleDecision | None:
        """Return the decision that belongs to the verdict; None where no rule judges any reading."""
        return max(self.decisions, key=lambda each: each.severity, default=None)


def check_pressures(shown: AllEvidence, limits: Limits, guard_factor: float) -> PressureCheck:
    """Judge every reading of a table."""
    table, checker = shown.table, _Checker(shown, limits, guard_factor)
    taps, order = taps_of(shown.controller), ranges_of(shown.controller)
    taken = sorted(
        table.readings,
        key=lambda each: (
            taps.index(each.cell.tap),
            order.index(each.cell.range),
            list(Engine).index(each.cell.engine),
            each.repeat,
        ),
    )
    checked = [checker.checked(each) for each in taken]
    logged: tuple[Missing, ...] = ()
    if limits.circuit_loss is not None:
        logged = checker.logged()
        checked = [checker.with_loss(checker.with_missing(each)) for each in checked]
    judged = tuple(each if each.decisions else checker.unjudged(each) for each in checked)
    patterns = find_patterns([checker.standing(each) for each in judged], checker.applied)
    messages = (*table.messages, *checker.messages(judged))
    shown.weighed.let_go()
    return PressureCheck(table, judged, patterns, messages, logged, weighed=shown.weighed)


@dataclass
class _Checker:
    """Judges the readings of one table."""

    evidence: AllEvidence
    limits: Limits
    guard_factor: float

    @property
    def table(self) -> PressureTable:
        return self.evidence.table

    @property
    def controller(self) -> Controller:
        return self.evidence.controller

    @property
    def uncertainty(self) -> float:
        return self.evidence.uncertainty

    def checked(self, reading: GaugeReading) -> CheckedReading:
        """Return one reading beside what is permissible and expected, main pressure judged."""
        cell, permissible = reading.cell, permitted(self.controller, reading.cell)
        point, decisions = self.evidence.point(reading), tuple[RuleDecision, ...]()
        projection = None if point is None else self.evidence.projected(point)
        steps = None if permissible is None else permissible_steps(permissible, self.limits)
        if permissible is not None and permissible.low is not None and steps is not None:
            below, u = 1.0 - reading.pressure / permissible.low, self.uncertainty * reading.pressure / permissible.low
            rule = Rule(RuleKind.PERMISSIBLE_PRESSURE, None, below, steps, where=_where(cell))
            decisions = (self._decide(rule, u),)
        return CheckedReading(
            reading=reading,
            tap_name=tap_name(self.controller, cell.tap),
            gear=gear_in(cell.range, self.controller.gears),
            permissible=permissible,
            expected=None if projection is None else held_at(projection, cell.tap),
            shown=None if projection is None else self.evidence.card.at(projection, cell.tap),
            line=self._line(reading),
            decisions=decisions,
        )

    # --- what circuits have lost

    def logged(self) -> tuple[Missing, ...]:
        """Return what is missing of main pressure where a log shows it."""
        losses = self.evidence.weighed.in_log
        return tuple(
            Missing(
                point,
                LINE_SECTION,
                losses[point].split,
                shown.pressure,
                shown.seconds,
                error=self.uncertainty * shown.pressure,
            )
            for point, shown in self.evidence.in_log
        )

    def _lost(self, section: str, point: OperatingPoint | None) -> Lost | None:
        weighed = self.evidence.weighed
        return weighed.lost(section, point) if point is not None and (section, point) in weighed.wanted else None

    def _doubted(self, section: str, point: OperatingPoint, lost: Lost) -> bool:
        """Return whether gauges contradict one another on a section, or on what was read of it with another one."""
        return bool(lost.contradicted) or (section, point) in self.evidence.weighed.contradicted

    def with_missing(self, checked: CheckedReading) -> CheckedReading:
        """Return a reading with what is missing of its pressure."""
        section, point = section_of(checked.cell.tap), self.evidence.drawn_at(checked.reading)
        lost = self._lost(section, point)
        if lost is None or point is None:
            return checked
        showed, doubted = checked.reading.pressure, self._doubted(section, point, lost)
        missing = Missing(point, section, lost.split, showed, error=self.uncertainty * showed, doubted=doubted)
        return replace(checked, missing=missing)

    def with_loss(self, checked: CheckedReading) -> CheckedReading:
        """Return a reading with what its circuit or the line lost, judged; one that is judged already as it is."""
        reading, steps, tap = checked.reading, self.limits.circuit_loss, checked.cell.tap
        circuit, point = circuit_at(self.controller, tap), self.evidence.drawn_at(reading)
        lost = self._lost(section_of(tap), point)
        if steps is None or checked.decisions:
            return checked
        if lost is None:
            return self._by_the_line(checked, steps) if point is None else checked
        reason = None if tap == LINE_TAP else self.evidence.not_comparable(reading)
        showed = self.evidence.at_the_lines_best(reading)
        surely = (showed or 0.0) * (1.0 - SURELY * self.uncertainty)
        if surely > lost.highest:
            reason = reason or TOO_HIGH
        elif checked.missing is not None and checked.missing.doubted:
            reason = reason or _CONTRADICT
        if reason is not None:
            return replace(checked, unjudged=reason)
        kind = RuleKind.BELOW_EXPECTED if tap == LINE_TAP else RuleKind.CIRCUIT_LOSS
        if showed is None:  # the line fell after it was at its highest, by which the draws are weighed
            below = replace(lost, draws=lost.draws + lost.expected - reading.pressure)
            u = math.hypot(self.uncertainty * reading.pressure, below.standard_uncertainty)
            rule = Rule(kind, None, max(below.quantile(0.5), 0.0), steps, where=_where(reading.cell))
            return replace(checked, decisions=(self._decide(rule, u),))
        value = max(lost.quantile(0.5), 0.0)
        rule = Rule(kind, None, value, steps, circuit=circuit, where=_where(reading.cell))
        over = tuple(lost.probability_over(limit) for _, limit in steps.levels)
        uncertainties = (lost.standard_uncertainty,) * len(over)
        decided = decide_rule(rule, uncertainties, over, self.guard_factor, skewed=True)
        return replace(checked, lost=lost, decisions=(decided,))

    def _by_the_line(self, checked: CheckedReading, steps: Steps) -> CheckedReading:
        """Return a tap's reading where nothing can be computed, judged by what it is surely below the line's gauge."""
        below, circuit = checked.below_line, circuit_at(self.controller, checked.cell.tap)
        if below is None or checked.line is None or checked.line <= 0.0:
            return checked
        u = self.uncertainty * math.hypot(checked.line, checked.reading.pressure)
        surely = max(below - self.guard_factor * u, 0.0)
        if steps.origin is LimitOrigin.PROJECT:  # of the line less a circuit the same pressures are published
            steps = replace(steps, origin=LimitOrigin.PUBLISHED)
        rule = Rule(RuleKind.BELOW_LINE, None, surely, steps, circuit=circuit, where=_where(checked.cell))
        return replace(checked, decisions=(self._decide(rule, u),))

    def unjudged(self, checked: CheckedReading) -> CheckedReading:
        """Return a reading that no rule judges with the reason for it."""
        tap = checked.cell.tap != LINE_TAP and self.limits.circuit_loss is not None
        reason = checked.unjudged or (self.evidence.not_comparable(checked.reading) if tap else None)
        return replace(checked, unjudged=reason or _NOTHING_PERMITTED)

    def _decide(self, rule: Rule, u: float) -> RuleDecision:
        return decide_normal(rule, u, self.guard_factor)

    def _line(self, reading: GaugeReading) -> float | None:
        """Return the pressure that a circuit should reach by the line's gauge [Pa]; None where it cannot be told.

        It is line pressure, or what its regulator is set to where that is less and the file states a number.
        """
        circuit = circuit_at(self.controller, reading.cell.tap)
        beside = None if circuit is None else self.table.line_beside(reading)
        if circuit is None or beside is None:
            return None
        return _reached(circuit, gear_in(reading.cell.range, self.controller.gears), beside.pressure)

    def standing(self, checked: CheckedReading) -> GaugeStanding:
        """Return a reading as the patterns need it."""
        reading = checked.reading
        return GaugeStanding(
            cell=reading.cell,
            pressure=reading.pressure,
            repeat=reading.repeat,
            uncertainty=self.uncertainty * reading.pressure,
            stands=checked.stands,
            loss=checked.loss if reading.cell.tap != LINE_TAP and checked.verdict is not Verdict.OK else None,
            causes=_causes_of_loss(checked.missing) if checked.missing is not None else {},
            measured=any(
                each.measured and reading.cell.tap in (gap.high.section, gap.low.section)
                for gap in self.controller.gaps
                for each in cast("Sequence[LandClearance]", self.evidence.model.clearances)
                if each.land.key == gap.key
            ),
        )

    @property
    def applied(self) -> dict[SelectorRange, frozenset[str]]:
        """Return the ids of the circuits that are applied in each range."""
        gears = {selected: gear_in(selected, self.controller.gears) for selected in ranges_of(self.controller)}
        return {
            selected: frozenset(circuit.id for circuit in self.controller.circuits if gear in circuit.gears)
            for selected, gear in gears.items()
        }

    def messages(self, readings: Sequence[CheckedReading]) -> Iterator[Message]:
        """Say which gears stand for ranges, what could not be judged, and what is over the permissible."""
        place = Place(self.table.file, self.table.sheet)
        yield from self._ranges_as_gears(readings, place)
        yield from _not_judged(readings, place)
        if all(each.cell.tap != LINE_TAP for each in readings):
            alone = [each.label for each in readings if each.lost is not None and each.line is None]
            if alone:
                text = Sentence(
                    "The line was not read: whether a circuit lost its pressure by itself or with the line cannot be "
                    "told from {cells}.",
                    cells=in_a_row(alone[:_SHOWN]),
                )
                yield Message("info", "line_not_read", text, place)
        for checked in readings:
            high = checked.permissible.high if checked.permissible else None
            if checked.over is not None and high is not None:
                text = Sentence(
                    "Main pressure is over the permissible: {cell}, {pressure} of at most {high} {high.unit}.",
                    cell=checked.label,
                    pressure=Quantity(checked.reading.pressure * KPA, "pressure"),
                    high=Quantity(high * KPA, "pressure"),
                )
                yield Message("warning", "over_permissible", text, checked.reading.place)
        for reason in dict.fromkeys(error.sentence for error in self.evidence.outside):
            text = Sentence("No pressure is expected from the engine: {reason}", reason=reason)
            yield Message("warning", "pressure_not_expected", text, place)

    def _ranges_as_gears(self, readings: Sequence[CheckedReading], place: Place) -> Iterator[Message]:
        by_gear: dict[int, list[str]] = {}
        for selected in dict.fromkeys(each.cell.range for each in readings):
            gear = gear_in(selected, self.controller.gears)
            if gear is not None:
                by_gear.setdefault(gear, []).append(selected)
        if by_gear:
            text = Sentence(
                "Gauge readings of a standing vehicle: {taken} where the file names no range (choice of this project).",
                taken=in_a_row(
                    Sentence("{ranges} as gear {gear}", ranges=ranges, gear=gear_name(gear))
                    for gear, ranges in by_gear.items()
                ),
            )
            yield Message("info", "ranges_as_gears", text, place)


def _not_judged(readings: Sequence[CheckedReading], place: Place) -> Iterator[Message]:
    by_reason: dict[Sentence, list[Sentence]] = {}
    for checked in readings:
        if checked.unjudged is not None:
            by_reason.setdefault(checked.unjudged, []).append(checked.label)
    for reason, labels in by_reason.items():
        named = in_a_row(labels[:_SHOWN])
        text = Sentence(
            "{count} of {readings} gauge readings cannot be judged, since {reason}: {cells}.",
            count=len(labels),
            readings=len(readings),
            reason=reason,
            cells=Sentence("{named} …", named=named) if len(labels) > _SHOWN else named,
        )
        yield Message("info", "pressure_not_judged", text, place)


def _causes_of_loss(missing: Missing) -> dict[Fault, float]:
    """Return which part of what a circuit lost each land, its seal, and all that lowers the line with it explain."""
    found: dict[Fault, float] = {}
    for row, lands in missing.split.lands.items():
        if row == (Cause.LANDS, missing.tap):
            found |= {("land", key): float(np.mean(values)) for key, values in lands.items()}
    found["seal", missing.tap] = float(np.mean(missing.split.seal))
    found["line",] = float(np.mean(missing.missing)) - math.fsum(found.values())
    kept = {cause: part for cause, part in found.items() if part > 0.0}
    total = math.fsum(kept.values())
    return {cause: part / total for cause, part in sorted(kept.items(), key=lambda each: -each[1])}


def _where(cell: GaugeCell) -> Sentence:
    return Sentence("{range}, {engine}", range=cell.range, engine=cell.engine.label)


def _reached(circuit: Circuit, gear: int | None, line: float) -> float | None:
    """Return what a circuit that holds without loss reaches [Pa]; None where it is not applied or it cannot be told."""
    if gear not in circuit.gears or any(feed.source != "p_g" for feed in circuit.feeds):
        return None
    stated = circuit.set_pressure
    if stated is None:
        return line
    if stated.gears is not None:
        return min(line, stated.gears.get(gear, 0.0))
    return None if stated.number is None else min(line, stated.number)
