"""Judge gauge readings: main pressure against what is permissible, a circuit against the line, both as expected."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.circuit_tables import SelectorRange
from atleak.catalogue.circuits import Circuit, StandingPressure
from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.catalogue.limits import Limits, RuleKind
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import Projection, project
from atleak.equations.uncertainty import normal_cdf
from atleak.errors import DomainError, Message, Place
from atleak.gauges.patterns import Pattern, Standing, Stands, find_patterns
from atleak.pressure_table import (
    LINE,
    Cell,
    Engine,
    GaugeReading,
    PressureTable,
    circuit_at,
    gear_in,
    permitted,
    ranges_of,
    tap_name,
    taps_of,
)
from atleak.rules import Rule
from atleak.sentence import Sentence, in_a_row
from atleak.uncertainty import Assumptions, RuleDecision
from atleak.uncertainty.decision import decide_rule
from atleak.unit_systems import Quantity
from atleak.verdicts import Verdict, worst
from atleak.workshop_units import KPA

_SHOWN = 8  # cells named in a message


@dataclass(frozen=True)
class CheckedReading:
    """One gauge reading beside what is permissible, what the engine expects, and the line's own reading."""

    reading: GaugeReading
    tap_name: str
    gear: int | None  # that is taken for the range; None where the gears do not tell
    permissible: StandingPressure | None  # of main pressure; None where the file does not tell
    expected: (
        float | None
    )  # [Pa] that pump or circuit hold there by the engine; None where no operating point is like it
    line: float | None  # [Pa] that the circuit should reach, from the line's gauge beside it; None where it need not
    decisions: tuple[RuleDecision, ...]  # of every rule that judges it

    @property
    def cell(self) -> Cell:
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
    def verdict(self) -> Verdict | None:
        """Return the worst verdict on it; None where no rule judges it, since nothing unjudged is ok."""
        return worst(each.rule.verdict for each in self.decisions) if self.decisions else None

    @property
    def deciding(self) -> RuleDecision | None:
        """Return the decision that belongs to the verdict; None where no rule judges it."""
        return max(self.decisions, key=lambda each: each.severity, default=None)


@dataclass(frozen=True)
class PressureCheck:
    """A pressure table with everything that is said of it."""

    table: PressureTable
    readings: tuple[CheckedReading, ...]  # in the order of the unit's ranges
    patterns: tuple[Pattern, ...]
    messages: tuple[Message, ...]

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
    model: LeakageModel,
    limits: Limits,
    *,
    projections: Sequence[Projection] = (),
    assumptions: Assumptions,
    guard_factor: float,
) -> PressureCheck:
    """Judge every reading of a table.

    Parameters
    ----------
    table
        the gauge readings.
    model
        the engine with the clearances as measured: what pump and circuits hold is expected from it.
    limits
        whose limits below the permissible pressure, and of circuits, are applied.
    projections
        those at hand; at other conditions the model is asked.
    assumptions
        with the gauge's relative standard uncertainty, ``main_pressure``.
    guard_factor
        k of the guard band of every limit.
    """
    checker = _Checker(table, model, limits, projections, assumptions.main_pressure, guard_factor)
    taps, order = taps_of(model.controller), ranges_of(model.controller)
    taken = sorted(
        table.readings,
        key=lambda each: (
            taps.index(each.cell.tap),
            order.index(each.cell.range),
            list(Engine).index(each.cell.engine),
            each.repeat,
        ),
    )
    readings = tuple(checker.check(each) for each in taken)
    patterns = find_patterns([checker.standing(each) for each in readings], checker.applied)
    return PressureCheck(table, readings, patterns, (*table.messages, *checker.messages(readings)))


class _Checker:
    """Judges the readings of one table."""

    def __init__(
        self,
        table: PressureTable,
        model: LeakageModel,
        limits: Limits,
        projections: Sequence[Projection],
        uncertainty: float,
        guard_factor: float,
    ) -> None:
        self.table, self.model, self.limits = table, model, limits
        self.controller: Controller = model.controller
        self.uncertainty, self.guard_factor = uncertainty, guard_factor
        self.at_hand = {projection.condition: projection for projection in projections}
        self.outside: list[DomainError] = []

    def check(self, reading: GaugeReading) -> CheckedReading:
        """Judge one reading."""
        cell = reading.cell
        permissible, line = permitted(self.controller, cell), self._line(reading)
        checked = CheckedReading(
            reading=reading,
            tap_name=tap_name(self.controller, cell.tap),
            gear=gear_in(cell.range, self.controller.gears),
            permissible=permissible,
            expected=self._expected(reading),
            line=line,
            decisions=(),
        )
        rules = []
        if permissible is not None and permissible.low is not None and self.limits.below_permissible is not None:
            below, u = 1.0 - reading.pressure / permissible.low, self.uncertainty * reading.pressure / permissible.low
            kind, steps = RuleKind.PERMISSIBLE_PRESSURE, self.limits.below_permissible
            rules.append((Rule(kind, None, below, steps, where=_where(cell)), u))
        if line is not None and self.limits.circuit_loss is not None:
            u = self.uncertainty * math.hypot(line, reading.pressure)
            circuit = circuit_at(self.controller, cell.tap)
            kind, steps = RuleKind.BELOW_LINE, self.limits.circuit_loss
            rule = Rule(kind, None, line - reading.pressure, steps, circuit=circuit, where=_where(cell))
            rules.append((rule, u))
        return replace(checked, decisions=tuple(self._decide(rule, u) for rule, u in rules))

    def _decide(self, rule: Rule, u: float) -> RuleDecision:
        levels = rule.steps.levels
        over = tuple(_probability_over(rule.value, limit, u) for _, limit in levels)
        return decide_rule(rule, (u,) * len(levels), over, self.guard_factor, skewed=False)

    def _line(self, reading: GaugeReading) -> float | None:
        """Return the pressure that a circuit should reach by the line's gauge [Pa]; None where it cannot be told.

        It is line pressure, or what its regulator is set to where that is less and the file states a number.
        """
        circuit = circuit_at(self.controller, reading.cell.tap)
        at_line = self.table.at(replace(reading.cell, tap=LINE))
        if circuit is None or not at_line:
            return None
        gear = gear_in(reading.cell.range, self.controller.gears)
        beside = next((each for each in at_line if each.round == reading.round), at_line[-1])
        return _reached(circuit, gear, beside.pressure)

    def _expected(self, reading: GaugeReading) -> float | None:
        """Return what pump or circuit hold in a cell [Pa]; None where no operating point is like it."""
        point = self._point(reading)
        if point is None:
            return None
        if point not in self.at_hand:
            try:
                self.at_hand[point] = project(self.model, point)
            except DomainError as error:
                self.outside.append(error)
                return None
        projection, tap = self.at_hand[point], reading.cell.tap
        return projection.main_pressure_held if tap == LINE else self._of_circuit(projection, tap)

    def _of_circuit(self, projection: Projection, tap: str) -> float | None:
        return next((each.pressure for each in projection.circuits if each.circuit.id == tap), None)

    def _point(self, reading: GaugeReading) -> OperatingPoint | None:
        """Return the operating point of the same gear and state, at the temperature and speed that were stated.

        At a fast idle line pressure is that of idle, and only a stated speed says what the pump delivers.
        """
        gear, engine = gear_in(reading.cell.range, self.controller.gears), reading.cell.engine
        state = "stall" if engine is Engine.STALL else "idle"
        points = (each for each in self.controller.operating_points if each.gear == gear and each.state == state)
        point = next(points, None)
        if point is None or (engine is Engine.FAST_IDLE and reading.engine_speed is None):
            return None
        return replace(
            point,
            temperature=point.temperature if reading.temperature is None else reading.temperature,
            engine_speed=point.engine_speed if reading.engine_speed is None else reading.engine_speed,
            stated_state=point.stated_state if reading.engine_speed is None else point.state,
        )

    def standing(self, checked: CheckedReading) -> Standing:
        """Return a reading as the patterns need it."""
        reading = checked.reading
        return Standing(
            cell=reading.cell,
            pressure=reading.pressure,
            repeat=reading.repeat,
            uncertainty=self.uncertainty * reading.pressure,
            stands=checked.stands,
            below_line=checked.below_line,
        )

    @property
    def applied(self) -> dict[SelectorRange, frozenset[str]]:
        """Return the ids of the circuits that are applied in each range."""
        gears = {selected: gear_in(selected, self.controller.gears) for selected in ranges_of(self.controller)}
        return {
            selected: frozenset(circuit.id for circuit in self.controller.circuits if gear in circuit.gears)
            for selected, gear in gears.items()
        }

    def messages(self, readings: Sequence[CheckedReading]) -> Iterable[Message]:
        """Say which gears stand for ranges, what could not be judged, and what is over the permissible."""
        place = Place(self.table.file, self.table.sheet)
        by_gear: dict[int, list[str]] = {}
        for selected in dict.fromkeys(each.cell.range for each in readings):
            gear = gear_in(selected, self.controller.gears)
            if gear is not None:
                by_gear.setdefault(gear, []).append(selected)
        if by_gear:
            text = Sentence(
                "Gauge readings of a standing vehicle: {taken} where the file names no range (choice of this project).",
                taken=in_a_row(
                    Sentence("{ranges} as gear {gear}", ranges=ranges, gear=gear) for gear, ranges in by_gear.items()
                ),
            )
            yield Message("info", "ranges_as_gears", text, place)
        unjudged = [each.label for each in readings if not each.decisions]
        if unjudged:
            named = in_a_row(unjudged[:_SHOWN])
            text = Sentence(
                "{count} of {readings} gauge readings cannot be judged, since the valve body's file says nothing that "
                "they must reach: {cells}.",
                count=len(unjudged),
                readings=len(readings),
                cells=Sentence("{named} …", named=named) if len(unjudged) > _SHOWN else named,
            )
            yield Message("info", "pressure_not_judged", text, place)
        for each in readings:
            high = each.permissible.high if each.permissible else None
            if each.over is not None and high is not None:
                text = Sentence(
                    "Main pressure is over the permissible: {cell}, {pressure} of at most {high} {high.unit}.",
                    cell=each.label,
                    pressure=Quantity(each.reading.pressure * KPA, "pressure"),
                    high=Quantity(high * KPA, "pressure"),
                )
                yield Message("warning", "over_permissible", text, each.reading.place)
        for reason in dict.fromkeys(error.sentence for error in self.outside):
            text = Sentence("No pressure is expected from the engine: {reason}", reason=reason)
            yield Message("warning", "pressure_not_expected", text, place)


def _where(cell: Cell) -> Sentence:
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


def _probability_over(value: float, limit: float, u: float) -> float:
    return float(normal_cdf((value - limit) / u)) if u > 0.0 else float(value > limit)
