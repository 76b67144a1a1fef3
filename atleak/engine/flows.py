"""Follow the flow from the pump to the sump at the pressures that hold: through sections, circuits, lands and leaks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.engine.balance import Balance
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import Network
from atleak.engine.operation import LINE, Operation, wanted

_ROUNDING = 1e-9  # relative to the pump's flow: less than that is no flow


class FlowKind(StrEnum):
    """What fluid passes on its way from the pump."""

    PUMP = "pump"
    BEYOND = "beyond"  # what is drawn and no pump delivers: a demand, where pressures are not solved
    SLIP = "slip"
    CONSUMER = "consumer"
    LEFT = "left"  # what the line's regulator leaves over
    SECTION = "section"  # the line, a section or a circuit
    LAND = "land"
    LEAK = "leak"  # rings, check balls
    ELSEWHERE = "elsewhere"  # circuits that the valve body's file does not describe: not counted as drawn
    SUMP = "sump"


@dataclass(frozen=True)
class FlowPlace:
    """A place that fluid passes, named as in the controller's file."""

    kind: FlowKind
    name: str = ""  # of a section, circuit, leak or consumer; the component of a land
    land: int = 0  # of a component
    path: int = 0  # of a land that leaks in several ways: which of them


@dataclass(frozen=True)
class Flow:
    """What flows from one place to the next."""

    source: FlowPlace
    target: FlowPlace
    flow: float  # [m³/s], never negative


@dataclass(frozen=True)
class Flows:
    """Every flow of a unit at one operating point: at each place between the pump and an end as much comes as goes."""

    pressures: Mapping[str, float]  # [Pa] that every section and circuit holds
    flows: tuple[Flow, ...]


_PUMP, _SUMP, _LINE, _ELSEWHERE = (
    FlowPlace(FlowKind.PUMP),
    FlowPlace(FlowKind.SUMP),
    FlowPlace(FlowKind.SECTION, LINE),
    FlowPlace(FlowKind.ELSEWHERE),
)


class _Sums:
    """Flows between places, added up."""

    def __init__(self) -> None:
        self.flows: dict[tuple[FlowPlace, FlowPlace], float] = {}

    def add(self, source: FlowPlace, target: FlowPlace, flow: float) -> None:
        ends, flow = ((source, target), flow) if flow >= 0.0 else ((target, source), -flow)
        self.flows[ends] = self.flows.get(ends, 0.0) + flow

    def missing_at(self, place: FlowPlace) -> float:
        """Return what leaves a place beyond what comes in [m³/s]."""
        return sum(flow * ((source == place) - (target == place)) for (source, target), flow in self.flows.items())


def flows_at(model: LeakageModel, point: OperatingPoint) -> Flows:
    """Compute where the pump's flow goes at an operating point, with the pressures that hold there.

    Sections that are given a pressure take from the line what leaks out of them; what leaks into one beyond that goes
    elsewhere. Consumers behind the line's regulator get what all others leave.
    """
    at, controller = Operation.of(model, point), model.controller
    network, viscosity, held = at.network, at.viscosity, at.held
    sums = _Sums()
    for ends in (*_through(model, network, held.balance), *_fed(network, held.balance)):
        sums.add(*ends)
    places = {place for ends in sums.flows for place in ends if place.kind is FlowKind.SECTION}
    circuits = {FlowPlace(FlowKind.SECTION, circuit.id) for circuit in controller.circuits}
    vented = {FlowPlace(FlowKind.SECTION, name) for name in network.vented}
    for section in sorted(places - {_LINE} - circuits | places & vented, key=lambda place: place.name):
        missing = sums.missing_at(section)
        end = _SUMP if section in vented else _ELSEWHERE
        sums.add(*((_LINE, section) if missing > 0.0 else (section, end)), abs(missing))
    supply, drawn = float(model.pump.per_revolution * point.engine_speed), sums.missing_at(_LINE)
    slip = min(float(model.pump.slip(held.main_pressure, viscosity)), supply)
    given = min(drawn, supply - slip)
    sums.add(_PUMP, _LINE, given)
    sums.add(FlowPlace(FlowKind.BEYOND), _LINE, drawn - given)
    sums.add(_PUMP, FlowPlace(FlowKind.SLIP), slip)
    left = supply - slip - given
    for after_line in (False, True):
        flows = wanted(network, held.main_pressure, held.required, after_line=after_line)
        part = min(left / total, 1.0) if (total := float(sum(flows.values()))) > 0.0 else 0.0
        for name, flow in flows.items():
            sums.add(_PUMP, FlowPlace(FlowKind.CONSUMER, name), part * float(flow))
        left -= part * total
    sums.add(_PUMP, FlowPlace(FlowKind.LEFT), left)
    least = _ROUNDING * max(supply, drawn)
    return Flows(
        MappingProxyType({name: float(pressure) for name, pressure in held.balance.pressures.items()}),
        tuple(Flow(*ends, flow) for ends, flow in sums.flows.items() if flow > least),
    )


def _through(model: LeakageModel, network: Network, balance: Balance) -> Iterator[tuple[FlowPlace, FlowPlace, float]]:
    """Return the flows through every land and leak: from its section to it, and on from there."""
    gear = network.point.gear
    paths: Counter[LandKey] = Counter()
    lands = []
    for gap in model.gaps_in(gear):
        lands.append(FlowPlace(FlowKind.LAND, *gap.key, paths[gap.key]))
        paths[gap.key] += 1
    leaks = [FlowPlace(FlowKind.LEAK, leak.id) for leak in model.controller.leaks if gear in leak.gears]
    for place, branch in zip([*lands, *leaks], network.branches, strict=True):
        flow = float(network.flow(branch, balance.pressures))
        source = FlowPlace(FlowKind.SECTION, branch.high.section or LINE)
        target = _SUMP if branch.counts else _ELSEWHERE
        if not branch.counts and branch.into is not None:
            target = FlowPlace(FlowKind.SECTION, branch.into)
        yield source, place, flow
        yield place, target, flow


def _fed(network: Network, balance: Balance) -> Iterator[tuple[FlowPlace, FlowPlace, float]]:
    """Return what every circuit takes through each of its feeds, and what it relieves to the sump."""
    for circuit in network.controller.circuits:
        place = FlowPlace(FlowKind.SECTION, circuit.id)
        if circuit.id not in network.vented:
            yield place, _SUMP, float(balance.relief[circuit.id])
        taken = float(balance.feeds.get(circuit.id, 0.0))
        feeds = [feed for feed in network.feeds if feed.into == circuit.id]
        could = [float(feed.restriction.flow(feed.drop(balance.pressures))) for feed in feeds]
        back = [min(flow, 0.0) if circuit.id in network.solved else 0.0 for flow in could]  # nothing throttles that
        most = sum(max(flow, 0.0) for flow in could)
        for feed, flow, backward in zip(feeds, could, back, strict=True):
            part = max(flow, 0.0) / most if most > 0.0 else 1.0 / len(feeds)
            yield FlowPlace(FlowKind.SECTION, feed.high.section or LINE), place, (taken - sum(back)) * part + backward
        if not feeds:  # supplied by the line without any resistance
            yield _LINE, place, taken
