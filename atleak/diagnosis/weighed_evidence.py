"""Weigh all that was shown of a unit: gauges, a log, flows in a jug and plugs of a vacuum test."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import DomainError
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.flows import FlowFinding, caught_error, log_likelihood
from atleak.diagnosis.gauge_card import GaugeCard, point_of, section_of, standing_point
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.uncertainty.posterior import MOST_RISE, Plug, PosteriorUnit
from atleak.diagnosis.uncertainty.weighing import SURELY, FlowShown, Lost, Posterior, Shown, Told
from atleak.diagnosis.vacuum import VacuumFinding
from atleak.engine.operation import LINE as LINE_SECTION
from atleak.engine.operation import Operation, consumed
from atleak.engine.projection import Projection, project
from atleak.engine.road_pressure import AtTemperature
from atleak.measurements.gauge_readings import LINE_TAP, TOGETHER, GaugeReading, PressureTable, applied, circuit_at

_LOG = "the log's sensor"  # a gauge by its own name
_STEP = 5.0  # [K] to which a stated temperature is rounded where losses are drawn
_MOVED = 3.0  # of two readings, by which the line moved between them: choice of this project

_VENTED = Sentence("their circuits are not applied there")
_NO_POINT = Sentence("the valve body's file has no operating point of that gear and state for which to compute them")
_APART = Sentence(
    "the line was read more than {seconds:g} s before or after them, and may have moved", seconds=TOGETHER
)
_NO_LINE = Sentence("the line's gauge shows no pressure there: did the engine run, and was the gauge open?")
TOO_HIGH = Sentence(
    "they, or the line with them, are higher than the valve body's file says they can be: check gauge, unit and tap, "
    "and whether that file describes this unit"
)


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
    """What all evidence together tells of a unit, computed when it is asked for: most of it few readers want."""

    unit: PosteriorUnit  # before any gauge is read
    wanted: Collection[tuple[str, OperatingPoint]]  # line and circuits, and where
    shown: Sequence[Shown]
    flows: Sequence[FlowShown]
    log: Sequence[Shown]
    _lost: dict[tuple[str, OperatingPoint], Lost] = field(default_factory=dict)

    def lost(self, section: str, point: OperatingPoint) -> Lost:
        """Return what the line or a circuit has lost."""
        if (section, point) not in self._lost:
            self._lost[section, point] = self._posterior.lost(section, point)
        return self._lost[section, point]

    @cached_property
    def _posterior(self) -> Posterior:
        return Posterior(self.unit, self.shown, self.flows)

    @cached_property
    def in_log(self) -> Mapping[OperatingPoint, Lost]:
        """Return what the line has lost where a log shows it.

        A log tells of another drive, at other temperatures, by another sensor: it is weighed apart from the gauges, and
        each of its gears and states by itself.
        """
        lost: dict[OperatingPoint, Lost] = {}
        for name in dict.fromkeys(each.point.name for each in self.log):
            alone = [each for each in self.log if each.point.name == name]
            of_log = Posterior(self.unit, alone)
            lost |= {each.point: of_log.lost(LINE_SECTION, each.point) for each in alone}
        return lost

    @cached_property
    def contradicted(self) -> frozenset[tuple[str, OperatingPoint]]:
        """Return taps that showed what the others, or those of another circuit, do not expect there."""
        return frozenset().union(*(self._posterior.contradicted(section) for section, _ in self.wanted))

    @cached_property
    def told(self) -> tuple[Told, ...]:
        """Return what is known of the parts; it rests on the log only where no gauge read the line."""
        if not self.log or any(each.tap == LINE_SECTION for each in self.shown):
            return self._posterior.told()
        return Posterior(self.unit, [*self.shown, *self.log], self.flows).told()

    def let_go(self) -> None:
        """Let go of the draws, some 40 MB: they are the same when they are drawn again."""
        self.__dict__.pop("_posterior", None)
        self.unit.drawn.clear()


class AllEvidence:
    """All that was shown of one unit: gauge readings, and what is beside them.

    Parameters
    ----------
    table
        the gauge readings; `NO_GAUGES` where nobody read one.
    card
        what gauges should show on the unit, with its clearances as measured and what it may be like.
    beside
        what else tells of the same unit.
    projections
        those at hand; at other conditions the model is asked.
    """

    def __init__(
        self, table: PressureTable, card: GaugeCard, beside: Beside, projections: Iterable[Projection]
    ) -> None:
        self.table, self.card, self.beside = table, card, beside
        self.model, self.controller, self.assumptions = card.model, card.model.controller, card.assumptions
        self.uncertainty = card.assumptions.main_pressure  # of a gauge: relative and standard
        self.outside: list[DomainError] = []  # what the engine knows nothing of
        self._at_hand = {projection.condition: projection for projection in projections}

    @cached_property
    def weighed(self) -> Weighed:
        """Return it, kept with what it rests on."""
        log = None if self.beside.log is None else self.beside.log.road_test
        card, sheet = self.card, self.card.readings
        of_card = card.model, card.unworn, sheet and sheet.sha256, card.instruments, card.assumptions
        rests_on = *of_card, self.in_log, self.beside.flows, self.beside.plugs
        owner = self.table if self.table.readings else log
        return self._weighed() if owner is None else kept_with(owner, "weighed", rests_on, self._weighed, most=1)

    def _weighed(self) -> Weighed:
        wanted: dict[tuple[str, OperatingPoint], None] = {}
        shown = []
        for reading in self.table.readings:
            point, tap = self.drawn_at(reading), reading.cell.tap
            if point is None or (tap != LINE_TAP and self.not_comparable(reading) is not None):
                continue
            pressure, section = self.at_the_lines_best(reading), section_of(tap)
            if pressure is not None:
                shown.append(Shown(point, section, pressure, reading.gauge))
            wanted[section, point] = None
        in_log = [Shown(point, LINE_SECTION, at.pressure, _LOG) for point, at in self.in_log]
        wanted |= dict.fromkeys(self._not_read(wanted))
        flows = [*self._flows()]
        of_gauges, of_flows = ([each.point for each in (*shown, *in_log)], [each.point for each in flows])
        at = dict.fromkeys([*of_gauges, *of_flows, *(point for _, point in wanted)])
        projections = (self._at_hand[each] for each in at)
        unit = PosteriorUnit(self.model, self.card.sources, self.assumptions, projections, self.beside.shared)
        return Weighed(unit, wanted, shown, flows, in_log)

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
                reading = math.hypot(u.caught_flow, u.volumetric_efficiency * self._at_hand[point].pump_supply / least)
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
    def in_log(self) -> tuple[tuple[OperatingPoint, AtTemperature], ...]:
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

    def drawn_at(self, reading: GaugeReading) -> OperatingPoint | None:
        """Return the operating point at which losses are drawn for a reading; None where nothing is expected there."""
        return self._drawn(self.point(reading))

    def _drawn(self, point: OperatingPoint | None) -> OperatingPoint | None:
        if point is not None:
            point = replace(point, temperature=_STEP * round(point.temperature / _STEP))
        return point if point is not None and self.projected(point) is not None else None

    def not_comparable(self, reading: GaugeReading) -> Sentence | None:
        """Return why a tap's reading tells nothing of what its circuit lost; None where it does."""
        circuit, point = circuit_at(self.controller, reading.cell.tap), self.drawn_at(reading)
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
        return TOO_HIGH if beside.pressure * (1.0 - SURELY * self.uncertainty) > most else None

    def at_the_lines_best(self, reading: GaugeReading) -> float | None:
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

    def projected(self, point: OperatingPoint) -> Projection | None:
        """Return the unit as measured at an operating point; None outside of what the engine knows."""
        if point not in self._at_hand:
            try:
                self._at_hand[point] = project(self.model, point)
            except DomainError as error:
                self.outside.append(error)
                return None
        return self._at_hand[point]

    def point(self, reading: GaugeReading) -> OperatingPoint | None:
        """Return the operating point of a reading; None where none is like it."""
        return point_of(self.controller, reading.cell, reading.temperature, reading.engine_speed)
