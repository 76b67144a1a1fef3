"""Judge gauge readings: main pressure against what is permissible, a circuit by what it has lost against new."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import cast

import numpy as np

from atleak.catalogue.circuits import Circuit, PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import DomainError, Message, Place
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence, in_a_row
from atleak.common.units import KPA, Quantity, gear_name
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.flows import FlowFinding, caught_error, log_likelihood
from atleak.diagnosis.gauge_card import Expected, GaugeCard, StandsToExpected, held_at, point_of, standing_point
from atleak.diagnosis.gauge_patterns import GaugeStanding, Pattern, Stands, find_patterns
from atleak.diagnosis.missing import Cause, Missing
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.rules import Rule, permissible_steps
from atleak.diagnosis.uncertainty import Assumptions, RuleDecision
from atleak.diagnosis.uncertainty.decision import decide_normal, decide_rule
from atleak.diagnosis.uncertainty.posterior import MOST_RISE, Fault, Plug, PosteriorUnit
from atleak.diagnosis.uncertainty.weighing import SURELY, FlowShown, Lost, Posterior, Shown, Told
from atleak.diagnosis.vacuum import VacuumFinding
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LINE as LINE_SECTION
from atleak.engine.operation import Operation, consumed
from atleak.engine.projection import Projection, project
from atleak.engine.road_pressure import AtTemperature
from atleak.measurements.clearances import LandClearance
from atleak.measurements.gauge_readings import (
    LINE_TAP,
    NO_GAUGES,
    TOGETHER,
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    applied,
    circuit_at,
    gear_in,
    permitted,
    ranges_of,
    tap_name,
    taps_of,
)

_SHOWN = 8  # cells named in a message
_LOG = "the log's sensor"  # a gauge by its own name
_STEP = 5.0  # [K] to which a stated temperature is rounded where losses are drawn
_MOVED = 3.0  # of two readings, by which the line moved between them: choice of this project

_NOTHING_PERMITTED = Sentence("the valve body's file says nothing that they must reach")
_VENTED = Sentence("their circuits are not applied there")
_NO_POINT = Sentence("the valve body's file has no operating point of that gear and state for which to compute them")
_APART = Sentence(
    "the line was read more than {seconds:g} s before or after them, and may have moved", seconds=TOGETHER
)
_NO_LINE = Sentence("the line's gauge shows no pressure there: did the engine run, and was the gauge open?")
_TOO_HIGH = Sentence(
    "they, or the line with them, are higher than the valve body's file says they can be: check gauge, unit and tap, "
    "and whether that file describes this unit"
)
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
    expected: (
        float | None
    )  # [Pa] that pump or circuit hold there by the engine; None where no operating point is like it
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


@dataclass(frozen=True)
class Beside:
    """What else was shown of a unit, beside gauges and the readings of its lands."""

    log: RoadFindings | None = None  # whose main pressure tells of it
    flows: tuple[FlowFinding, ...] = ()  # in a jug
    plugs: tuple[VacuumFinding, ...] = ()  # of a vacuum test

    @property
    def shared(self) -> tuple[Plug, ...]:
        """Return the plugs on several lands: one on a single land measured it."""
        several = (each for each in self.plugs if len(each.lands) > 1)
        return tuple(
            Plug(tuple(land.key for land in each.lands), each.passes, each.u_passes, each.open) for each in several
        )


@dataclass(frozen=True, eq=False)
class Weighed:
    """What all evidence together tells of a unit: of line and circuits, of the line by the log alone, of its parts."""

    lost: Mapping[tuple[str, OperatingPoint], Lost]  # by section and operating point
    in_log: Mapping[OperatingPoint, Lost]
    told: tuple[Told, ...]


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


def check_pressures(
    table: PressureTable,
    card: GaugeCard,
    limits: Limits,
    *,
    beside: Beside,
    projections: Sequence[Projection] = (),
    guard_factor: float,
) -> PressureCheck:
    """Judge every reading of a table.

    Parameters
    ----------
    table
        the gauge readings.
    card
        what gauges should show on the unit, with its clearances as measured and what it may be like.
    limits
        whose limits below the permissible pressure, and of circuits, are applied.
    beside
        what else tells of the same unit.
    projections
        those at hand; at other conditions the model is asked.
    guard_factor
        k of the guard band of every limit.
    """
    at_hand = {projection.condition: projection for projection in projections}
    checker = _Checker(table, card, limits, at_hand, guard_factor, beside)
    taps, order = taps_of(checker.controller), ranges_of(checker.controller)
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
    if limits.circuit_loss is not None:
        checker.logged = checker.of_log(checker.weighed.in_log)
        checked = [checker.with_loss(checker.with_missing(each)) for each in checked]
    judged = tuple(each if each.decisions else checker.unjudged(each) for each in checked)
    patterns = find_patterns([checker.standing(each) for each in judged], checker.applied)
    messages = (*table.messages, *checker.messages(judged))
    return PressureCheck(table, judged, patterns, messages, checker.logged, weighed=checker.weighed)


def weigh(card: GaugeCard, limits: Limits, beside: Beside, projections: Sequence[Projection]) -> Weighed:
    """Weigh what is known of a unit whose gauges nobody read.

    Parameters
    ----------
    card, limits, beside, projections
        as of `check_pressures`.
    """
    return _Checker(NO_GAUGES, card, limits, {each.condition: each for each in projections}, 0.0, beside).weighed


@dataclass
class _Checker:
    """Judges the readings of one table."""

    table: PressureTable
    card: GaugeCard
    limits: Limits
    at_hand: dict[OperatingPoint, Projection]
    guard_factor: float
    beside: Beside
    logged: tuple[Missing, ...] = ()
    outside: list[DomainError] = field(default_factory=list)

    @property
    def model(self) -> LeakageModel:
        return self.card.model

    @property
    def controller(self) -> Controller:
        return self.model.controller

    @property
    def assumptions(self) -> Assumptions:
        return self.card.assumptions

    @property
    def uncertainty(self) -> float:
        """Return the gauge's relative standard uncertainty."""
        return self.assumptions.main_pressure

    def checked(self, reading: GaugeReading) -> CheckedReading:
        """Return one reading beside what is permissible and expected, main pressure judged."""
        cell, permissible = reading.cell, permitted(self.controller, reading.cell)
        point, rules = self._point(reading), []
        projection = None if point is None else self._projected(point)
        steps = None if permissible is None else permissible_steps(permissible, self.limits)
        if permissible is not None and permissible.low is not None and steps is not None:
            below, u = 1.0 - reading.pressure / permissible.low, self.uncertainty * reading.pressure / permissible.low
            rules.append((Rule(RuleKind.PERMISSIBLE_PRESSURE, None, below, steps, where=_where(cell)), u))
        return CheckedReading(
            reading=reading,
            tap_name=tap_name(self.controller, cell.tap),
            gear=gear_in(cell.range, self.controller.gears),
            permissible=permissible,
            expected=None if projection is None else held_at(projection, cell.tap),
            shown=None if projection is None else self.card.at(projection, cell.tap),
            line=self._line(reading),
            decisions=tuple(self._decide(rule, u) for rule, u in rules),
        )

    # --- what circuits have lost

    @cached_property
    def weighed(self) -> Weighed:
        """Return it, kept with what it rests on."""
        log = None if self.beside.log is None else self.beside.log.road_test
        card, sheet = self.card, self.card.readings
        of_card = card.model, card.unworn, sheet and sheet.sha256, card.instruments, card.assumptions
        rests_on = *of_card, self._in_log, self.beside.flows, self.beside.plugs
        owner = self.table if self.table.readings else log
        return self._weighed() if owner is None else kept_with(owner, "weighed", rests_on, self._weighed, most=1)

    def _weighed(self) -> Weighed:
        """Return what line and circuits have lost wherever they were read, and the line where a log shows it.

        A log tells of another drive, at other temperatures, by another sensor: it is weighed apart from the gauges, and
        each of its gears and states by itself. What is told of the parts rests on it only where no gauge read the line.
        """
        wanted: dict[tuple[str, OperatingPoint], None] = {}
        shown = []
        for reading in self.table.readings:
            point, tap = self._drawn_at(reading), reading.cell.tap
            if point is None or (tap != LINE_TAP and self._not_comparable(reading) is not None):
                continue
            pressure, section = self._at_the_lines_best(reading), _section(tap)
            if pressure is not None:
                shown.append(Shown(point, section, pressure, reading.gauge))
            wanted[section, point] = None
        in_log = [Shown(point, LINE_SECTION, at.pressure, _LOG) for point, at in self._in_log]
        wanted |= dict.fromkeys(self._not_read(wanted))
        flows = [*self._flows()]
        of_gauges, of_flows = ([each.point for each in (*shown, *in_log)], [each.point for each in flows])
        at = dict.fromkeys([*of_gauges, *of_flows, *(point for _, point in wanted)])
        projections = (self.at_hand[each] for each in at)
        unit = PosteriorUnit(self.model, self.card.sources, self.assumptions, projections, self.beside.shared)
        by_log: dict[OperatingPoint, Lost] = {}
        for name in dict.fromkeys(each.point.name for each in in_log):
            alone = [each for each in in_log if each.point.name == name]
            of_log = Posterior(unit, alone)
            by_log |= {each.point: of_log.lost(LINE_SECTION, each.point) for each in alone}
        posterior = Posterior(unit, shown, flows)
        lost = {each: posterior.lost(*each) for each in wanted}
        read = any(each.tap == LINE_SECTION for each in shown)
        whole = posterior if read or not in_log else Posterior(unit, [*shown, *in_log], flows)
        return Weighed(lost, by_log, whole.told())

    def _flows(self) -> Iterator[FlowShown]:
        """Yield every flow in a jug that tells what the line leaves for it."""
        u = self.assumptions
        for each in self.beside.flows:
            point = self._drawn(each.point)
            if point is not None and each.usual is not None and each.consumer is not None and each.consumer.after_line:
                at = Operation.of(self.model, point)
                others = consumed(at.network, at.held.required, at.held.required, after_line=True) - each.usual
                # what is left is known no better than what the pump delivers
                least = float(caught_error(each.flow, each.usual, 1.0))
                reading = math.hypot(u.caught_flow, u.volumetric_efficiency * self.at_hand[point].pump_supply / least)
                likely = partial(log_likelihood, each.flow, usual=each.usual, spread=u.consumer_flow, reading=reading)
                yield FlowShown(point, float(others), likely)

    def _not_read(self, read: Iterable[tuple[str, OperatingPoint]]) -> Iterator[tuple[str, OperatingPoint]]:
        """Yield line and circuits that no gauge read: at an operating point at which others were, or else at idle."""
        taps, points = {tap for tap, _ in read}, [point for _, point in read]
        stated = [self._drawn(each) for each in self.controller.operating_points if each.state == "idle"]
        if LINE_SECTION not in taps:
            yield from ((LINE_SECTION, each) for each in [each for each in stated if each is not None][:1])
        for circuit in self.controller.circuits if self.model.profile.circuits == "on" else ():
            if circuit.feeds and circuit.id not in taps:
                known = (each for each in (*points, *stated) if each is not None and each.gear in circuit.gears)
                yield from ((circuit.id, each) for each in [*known][:1])

    @cached_property
    def _in_log(self) -> tuple[tuple[OperatingPoint, AtTemperature], ...]:
        """Return where a log shows main pressure that is known as required, as cold and as hot as it was there."""
        permitted = None if self.beside.log is None else self.beside.log.permitted
        found = []
        for place in permitted.places if permitted is not None else ():
            for shown in dict.fromkeys([*place.held[:1], *place.held[-1:]]) if place.state != "driving" else ():
                point = self._drawn(
                    standing_point(self.controller, place.gear, place.state, shown.temperature, shown.engine_speed)
                )
                if point is not None:
                    found.append((point, shown))
        return tuple(found)

    def of_log(self, losses: Mapping[OperatingPoint, Lost]) -> tuple[Missing, ...]:
        """Return what is missing of main pressure where a log shows it."""
        return tuple(
            Missing(
                point,
                LINE_SECTION,
                losses[point].split,
                shown.pressure,
                shown.seconds,
                error=self.uncertainty * shown.pressure,
            )
            for point, shown in self._in_log
        )

    def _drawn_at(self, reading: GaugeReading) -> OperatingPoint | None:
        """Return the operating point at which losses are drawn for a reading; None where nothing is expected there."""
        return self._drawn(self._point(reading))

    def _drawn(self, point: OperatingPoint | None) -> OperatingPoint | None:
        if point is not None:
            point = replace(point, temperature=_STEP * round(point.temperature / _STEP))
        return point if point is not None and self._projected(point) is not None else None

    def _not_comparable(self, reading: GaugeReading) -> Sentence | None:
        """Return why a tap's reading tells nothing of what its circuit lost; None where it does."""
        circuit, point = circuit_at(self.controller, reading.cell.tap), self._drawn_at(reading)
        if not applied(self.controller, reading.cell):
            return _VENTED
        if circuit is None or not circuit.feeds or point is None or self.model.profile.circuits != "on":
            return _NO_POINT
        beside = self.table.line_beside(reading)
        if beside is None:
            return _APART if self.table.at(replace(reading.cell, tap=LINE_TAP)) else None
        if beside.pressure <= 0.0:
            return _NO_LINE
        most = point.main_pressure * (1.0 + MOST_RISE * self.assumptions.line_rise)
        return _TOO_HIGH if beside.pressure * (1.0 - SURELY * self.uncertainty) > most else None

    def _at_the_lines_best(self, reading: GaugeReading) -> float | None:
        """Return what a gauge showed [Pa], had it been read while the line was at its highest in that cell.

        Only where the line moved by more than its gauge errs: a tap that hangs on the line goes with it, and of the
        line's own readings the highest counts.
        """
        line = [each.pressure for each in self.table.at(replace(reading.cell, tap=LINE_TAP))]
        highest, lowest = max(line, default=0.0), min(line, default=0.0)
        if highest - lowest <= _MOVED * np.sqrt(2.0) * self.uncertainty * highest:
            return reading.pressure
        if reading.cell.tap == LINE_TAP:
            return reading.pressure if reading.pressure == highest else None
        circuit, beside = circuit_at(self.controller, reading.cell.tap), self.table.line_beside(reading)
        follows = circuit is not None and circuit.set_pressure is None and beside is not None and beside.pressure > 0.0
        return reading.pressure * highest / beside.pressure if follows and beside else reading.pressure

    def _lost(self, section: str, point: OperatingPoint | None) -> Lost | None:
        return None if point is None else self.weighed.lost.get((section, point))

    def _doubted(self, section: str, point: OperatingPoint, lost: Lost) -> bool:
        """Return whether gauges contradict one another on a section, or on what was read of it with another one."""
        others = self.weighed.lost.values()
        return bool(lost.contradicted) or any((section, point) in each.contradicted for each in others)

    def with_missing(self, checked: CheckedReading) -> CheckedReading:
        """Return a reading with what is missing of its pressure."""
        section, point = _section(checked.cell.tap), self._drawn_at(checked.reading)
        lost = self._lost(section, point)
        if lost is None or point is None:
            return checked
        showed, doubted = checked.reading.pressure, self._doubted(section, point, lost)
        missing = Missing(point, section, lost.split, showed, error=self.uncertainty * showed, doubted=doubted)
        return replace(checked, missing=missing)

    def with_loss(self, checked: CheckedReading) -> CheckedReading:
        """Return a reading with what its circuit or the line lost, judged; one that is judged already as it is."""
        reading, steps, tap = checked.reading, self.limits.circuit_loss, checked.cell.tap
        circuit, point = circuit_at(self.controller, tap), self._drawn_at(reading)
        lost = self._lost(_section(tap), point)
        if steps is None or checked.decisions:
            return checked
        if lost is None:
            return self._by_the_line(checked, steps) if point is None else checked
        reason = None if tap == LINE_TAP else self._not_comparable(reading)
        showed = self._at_the_lines_best(reading)
        surely = (showed or 0.0) * (1.0 - SURELY * self.uncertainty)
        if surely > lost.highest:
            reason = reason or _TOO_HIGH
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
        reason = checked.unjudged or (self._not_comparable(checked.reading) if tap else None)
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

    def _projected(self, point: OperatingPoint) -> Projection | None:
        if point not in self.at_hand:
            try:
                self.at_hand[point] = project(self.model, point)
            except DomainError as error:
                self.outside.append(error)
                return None
        return self.at_hand[point]

    def _point(self, reading: GaugeReading) -> OperatingPoint | None:
        return point_of(self.controller, reading.cell, reading.temperature, reading.engine_speed)

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
                for each in cast("Sequence[LandClearance]", self.model.clearances)
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
        for reason in dict.fromkeys(error.sentence for error in self.outside):
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


def _section(tap: str) -> str:
    return LINE_SECTION if tap == LINE_TAP else tap


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
