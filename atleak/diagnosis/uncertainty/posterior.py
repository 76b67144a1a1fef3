"""Say how much pressure the circuits of a unit have lost, given what gauges showed: draws of units, weighed by that.

A unit is drawn from what is known before any gauge is read: lands that were measured as their readings say, the others
new or worn, and so its seals, pump and line regulator; fluid, temperature and feeds as uncertain as they are. The
engine says what gauges would show on each, and each counts the more the nearer that comes to what they did show:

    w ∝ prior / proposal · exp(−½ rᵀ C⁻¹ r),        r reading less expectation, C the gauges' covariance.

Where few draws carry the weight, more are drawn around them, with the first ones kept beside (a defensive mixture:
Owen & Zhou, J. Am. Stat. Assoc. 95, 2000; all draws share the weights of the mixture: Veach & Guibas, SIGGRAPH 1995).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Pressure
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.drawn_unit import Drawn, DrawnLands, demand_shape
from atleak.diagnosis.uncertainty.draws import (
    FLUID_STATE,
    Beside,
    Bore,
    Cube,
    Draws,
    LandDraws,
    Positions,
    common_errors,
    land_draws,
    one_sided_fraction,
    stream_of,
)
from atleak.diagnosis.uncertainty.propagation import SEED
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import SHARP, Network
from atleak.engine.operation import LINE
from atleak.engine.projection import Projection
from atleak.engine.restrictions import Branch, GapBranch, Orifice, Restriction
from atleak.equations.statistics import normal_cdf

_DRAWS = 8_192  # of units before any gauge is read, and half as many at a time around what was found
ENOUGH = 200  # effective draws
_ROUNDS = 4  # of drawing around what was found
_PRIOR_COUNTS = 20.0  # effective draws that the prior stands for while a proposal is fitted
_NARROWEST = 0.2  # standard deviation of a proposal, over that of the prior
_READ_OFF = 0.1  # of a named gauge's variance: what differs from reading to reading
_UNNAMED = 0.7  # the same of gauges that nobody named: which was where is not known
_LEAST = 0.25  # of the highest pressure shown: a gauge errs no less than it does there
_FINEST = 1e3  # [Pa] that a gauge tells apart
_LAND, _SEAL, _HOLE, _PUMP, _LINE, _SET = "land", "seal", "hole", "pump", "line", "set"
MOST_RISE = 5.0  # of a line that is set high, over the mean rise
_SEALS = _SEAL, _HOLE

Cause = tuple[Any, ...]  # (what, which): ("land", key), ("seal", circuit), ("pump",), ("line",)


@dataclass(frozen=True)
class Shown:
    """One gauge reading as evidence: where it was taken, what it showed, and how its gauge may err."""

    point: OperatingPoint
    tap: str  # "p_g" of the line, or the id of a circuit
    pressure: float  # [Pa]
    gauge: str = ""  # its name; readings of one gauge share its error


@dataclass(frozen=True)
class Lost:
    """What a circuit has lost against the same unit new at one operating point, as far as all gauges tell."""

    draws: np.ndarray  # [Pa]
    expected: np.ndarray  # [Pa] that the circuit holds
    weights: np.ndarray  # their sum is 1
    effective: float  # number of draws that the weights are worth
    causes: Mapping[Cause, float]  # the part of the loss that each explains, the largest first
    highest: float  # [Pa] that it holds in 999 of 1000 units, before any gauge is read

    @property
    def standard_uncertainty(self) -> float:
        """Return the standard deviation of the loss [Pa]."""
        mean = float(self.weights @ self.draws)
        return math.sqrt(max(float(self.weights @ (self.draws - mean) ** 2), 0.0))

    def probability_over(self, limit: float) -> float:
        """Return the probability that the loss has reached a limit [Pa]."""
        return float(np.sum(self.weights, where=self.draws >= limit))

    def quantile(self, probability: float, of: np.ndarray | None = None) -> float:
        """Return a quantile of the loss, or of another quantity of the draws."""
        values = self.draws if of is None else of
        order = np.argsort(values)
        return float(
            values[order[np.searchsorted(np.cumsum(self.weights[order]), probability).clip(0, len(order) - 1)]]
        )


@dataclass(frozen=True)
class _Drawn:
    """Draws of units: standard deviates, shape (quantities, draws), and how far causes have gone, (causes, draws)."""

    deviates: np.ndarray
    wear: np.ndarray
    new: Mapping[LandKey, np.ndarray]  # [m] clearance when new of lands that nobody measured
    measured: Mapping[LandKey, LandDraws]  # lands whose readings draw them
    positions: Mapping[str, Any]  # of the spools, by component


@dataclass(frozen=True)
class _Proposal:
    """From what units are drawn: the prior, or narrower around what gauges showed."""

    chance: np.ndarray  # of each cause
    mean: np.ndarray  # of its exponential
    most: np.ndarray
    centre: np.ndarray  # of each deviate
    spread: np.ndarray

    def draw(self, stream: np.random.Generator, draws: int) -> tuple[np.ndarray, np.ndarray]:
        deviates = self.centre[:, None] + self.spread[:, None] * stream.standard_normal((len(self.centre), draws))
        shape, cut = (len(self.mean), draws), -np.expm1(-self.most / self.mean)
        gone = -self.mean[:, None] * np.log1p(-stream.random(shape) * cut[:, None])
        return deviates, np.where(stream.random(shape) < self.chance[:, None], gone, 0.0)

    def log_density(self, deviates: np.ndarray, wear: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density, but for a constant that all proposals of a unit share."""
        z = (deviates - self.centre[:, None]) / self.spread[:, None]
        normal = -0.5 * np.sum(z * z, axis=0) - np.sum(np.log(self.spread))
        with np.errstate(divide="ignore"):
            off, on = np.log1p(-self.chance), np.log(self.chance)
        on = on - np.log(self.mean) - np.log(-np.expm1(-self.most / self.mean))
        worn = on[:, None] - wear / self.mean[:, None]
        return np.asarray(normal + np.sum(np.where(wear > 0.0, worn, off[:, None]), axis=0))

    def around(
        self, deviates: np.ndarray, wear: np.ndarray, weights: np.ndarray, near: tuple[np.ndarray, np.ndarray]
    ) -> _Proposal:
        """Return a proposal around weighed draws, this one being the prior; only what is ``near`` moves."""
        effective = 1.0 / float(np.sum(weights * weights))
        trust = effective / (effective + _PRIOR_COUNTS)
        centre = trust * (deviates @ weights)
        square = trust * ((deviates**2) @ weights) + (1.0 - trust)
        spread = np.sqrt(np.maximum(square - centre**2, _NARROWEST**2))
        worn = (wear > 0.0) @ weights
        chance = np.clip(trust * worn + (1.0 - trust) * self.chance, 0.5 * self.chance, 0.95)
        gone = (wear @ weights + self.mean * 0.1) / (worn + 0.1)
        mean = np.clip(trust * gone + (1.0 - trust) * self.mean, 0.2 * self.mean, self.most)
        quantities, causes = near
        return _Proposal(
            np.where(causes, np.where(self.chance > 0.0, chance, 0.0), self.chance),
            np.where(causes, mean, self.mean),
            self.most,
            np.where(quantities, centre, self.centre),
            np.where(quantities, spread, self.spread),
        )


class PosteriorUnit:
    """A unit before any gauge is read: draws of it, and what gauges would show on each."""

    def __init__(
        self,
        model: LeakageModel,
        sources: Sequence[LandSources],
        assumptions: Assumptions,
        projections: Iterable[Projection],
    ) -> None:
        """Take a unit with the sources of its lands' uncertainty, at the operating points at which gauges were read."""
        self.model, self.sources, self.assumptions = model, sources, assumptions
        self._own = replace(assumptions, temperature=assumptions.gauged_temperature, main_pressure=1.0)
        self.conditions = {each.condition: each for each in projections}
        self._shapes = {point: demand_shape(model, point) for point in self.conditions}
        controller = model.controller
        gears = {point.gear for point in self.conditions}
        leaking = {gap.key for gap in controller.gaps if not gears.isdisjoint(gap.gears)}
        self._open = [  # lands that nobody measured
            land for land in sources if not land.state.measured and not land.state.land.seal and land.key in leaking
        ]
        self._fed = [each for each in controller.circuits if each.feeds]
        # what is applied in some gears only is a clutch or a band, and has a seal
        self._sealed = [each.id for each in self._fed if each.gears != frozenset(controller.gears)]
        self.quantities: list[Cause] = [
            *((name,) for name in ("viscosity", "temperature", "main pressure", "converter pressure", "pump", "state")),
            *(("feed", each.id) for each in self._fed),
            *((_LAND, land.key) for land in self._open),
        ]
        gone = self._gone()
        self.causes = [cause for cause, *_ in gone]
        chance, mean, most = np.array([[max(number, 1e-30) for number in row] for _, *row in gone]).T
        count = len(self.quantities)
        self.prior = _Proposal(np.where(chance > 1e-30, chance, 0.0), mean, most, np.zeros(count), np.ones(count))

    def _gone(self) -> list[tuple[Cause, float, float, float]]:
        """Return every cause of a leak with its chance, and mean and most of how far it goes."""
        u = self.assumptions
        gone: list[tuple[Cause, float, float, float]] = [
            *(((_LAND, land.key), u.worn_lands, u.land_wear, u.most_land_wear) for land in self._open),
            # a worn seal leaks as a gap does, a torn one or a cracked ring as a hole
            *(
                ((what, name), 0.5 * u.worn_seals, u.seal_wear, 20.0 * u.seal_wear)
                for what in _SEALS
                for name in self._sealed
            ),
            ((_LINE,), u.sticking_regulators, u.regulator_fall, 0.9),
            ((_SET,), u.high_lines, u.line_rise, MOST_RISE * u.line_rise),
        ]
        if self.model.uses_slip and not self.model.controller.pump.counted.any_known:
            gone.append(((_PUMP,), u.worn_pumps, u.pump_wear, 10.0 * u.pump_wear))
        return gone

    def draw(self, proposal: _Proposal, draws: int, seed: int) -> _Drawn:
        """Draw units; ``draws`` is a power of two."""
        deviates, wear = proposal.draw(stream_of(SEED, 11, seed), draws)
        shared = Draws(Cube(draws, SEED, 12, seed))
        measured = [land for land in self.sources if land.state.measured]
        common, fraction = common_errors(shared, measured), one_sided_fraction(shared, self.model, self.assumptions)
        own = Beside(Cube(draws, SEED, 13, seed), fraction)
        positions = Positions(self.model, own, SEED + seed)
        return _Drawn(
            deviates,
            wear,
            {land.key: self._new(deviates, land) for land in self._open},
            {
                land.key: land_draws(
                    own.draws(SEED, 14, seed, number), land, common, fraction, self.assumptions, positions.of(land)
                )
                for number, land in enumerate(measured)
            },
            {land.key[0]: positions.of(land) for land in self._open},
        )

    def leaks(self, drawn: _Drawn, circuit: str, point: OperatingPoint, held: Any) -> dict[Cause, np.ndarray]:
        """Return what leaks out of a circuit beyond what leaked when new, by cause [m³/s], entry loss left out."""
        wear, own = dict(zip(self.causes, drawn.wear, strict=True)), {land.key: land for land in self._open}
        viscosity = self.model.dynamic_viscosity(point.temperature)
        flows: dict[Cause, np.ndarray] = {}
        for gap in self.model.controller.gaps:
            if gap.high.section != circuit or point.gear not in gap.gears or (_LAND, gap.key) in flows:
                continue
            if gap.key in own:
                state, new = own[gap.key].state, drawn.new[gap.key]
                cubes = (new + wear[_LAND, gap.key]) ** 3 - new**3
            elif gap.key in drawn.measured:
                each = drawn.measured[gap.key]
                state, cubes = each.land.state, np.maximum(each.bore.clearance**3 - each.unworn_bore.clearance**3, 0.0)
            else:
                continue
            slope = math.pi * state.spool_diameter / (12.0 * viscosity * state.land.contact_length)
            flows[_LAND, gap.key] = slope * cubes * held
        if circuit in self._sealed:
            leaks = (self._leak(what, circuit, point, viscosity, wear[what, circuit]) for what in _SEALS)
            flows[_SEAL, circuit] = sum(leak.flow(held) for leak in leaks)
        return flows

    def _new(self, deviates: np.ndarray, land: LandSources) -> np.ndarray:
        deviate = deviates[self.quantities.index((_LAND, land.key))]
        low, high = land.state.land.mounting_range
        if low < high:
            return np.asarray(low + (high - low) * normal_cdf(deviate))
        return np.maximum(low + land.u_mounting * deviate, 0.0)

    def pressures(self, drawn: _Drawn, point: OperatingPoint, *, new: bool = False) -> Mapping[str, Any]:
        """Return what the line, as p_g, and every circuit hold in each draw [Pa], or held when new."""
        wear = dict.fromkeys(self.causes, 0.0) if new else dict(zip(self.causes, drawn.wear, strict=True))
        at, u = dict(zip(self.quantities, drawn.deviates, strict=True)), self.assumptions
        # what a line is set to, or fallen to by its regulator, is the same for the unit when new
        higher, fallen = (drawn.wear[self.causes.index((what,))] for what in (_SET, _LINE))
        line = (1.0 + u.line_setting * at["main pressure",] + higher) * (1.0 - fallen) - 1.0
        given = Drawn(
            self.model,
            self.conditions[point],
            self._own,
            {
                "viscosity": at["viscosity",],
                "temperature": at["temperature",],
                "main pressure": line,
                "converter pressure": at["converter pressure",],
                "pump efficiency": at["pump",],
                FLUID_STATE: math.sqrt(3.0) * (2.0 * normal_cdf(at["state",]) - 1.0),  # rectangular
            },
        )
        lands = []
        for land in self._open:
            clearance = drawn.new[land.key] + wear[_LAND, land.key]
            state = land.state.land
            lands.append((land, Bore(clearance), state.contact_length, drawn.positions[land.key[0]]))
        lands += [each.unworn if new else each.now for each in drawn.measured.values()]

        def with_rest(network: Network) -> Network:
            scaled = tuple(
                each.with_restriction(
                    Orifice(
                        each.restriction.coefficient * np.exp(u.feed * at["feed", each.into]),
                        each.restriction.transition,
                    )
                )
                for each in network.feeds
            )
            seals = tuple(
                Branch(
                    Pressure(1.0, name),
                    Pressure(0.0, None),
                    self._leak(what, name, point, given.viscosity, gone),
                    None,
                    True,
                )
                for what in _SEALS
                for name in self._sealed
                if name in network.solved and np.any(gone := wear[what, name])
            )
            return replace(network, feeds=scaled, leaks=(*network.leaks, *seals))

        counted = DrawnLands(given, lands, with_rest)
        leakage = counted.leakage + sum(counted.flow(*land)[1] for land in lands)
        pump = given.new_pump if new else given.pump
        if (_PUMP,) in wear:
            pump = replace(pump, slip_factor=pump.slip_factor * (1.0 + wear[_PUMP,]))
        main, held = replace(counted.unit(pump), leakage=leakage).held(point, self._shapes[point])
        return {**held, LINE: main}

    def _leak(self, what: str, name: str, point: OperatingPoint, viscosity: Any, gone: Any) -> Restriction:
        """Return a leak that takes ``gone`` times what the circuit's feeds pass at line pressure without any."""
        network = self._networks[point.gear]
        pressure, nominal = network.point.main_pressure, self.model.dynamic_viscosity(network.point.temperature)
        through = gone * sum(each.restriction.flow(pressure) for each in network.feeds if each.into == name)
        if what == _HOLE:
            return Orifice(through / math.sqrt(pressure), SHARP)
        return GapBranch(through / pressure * nominal / viscosity)

    @cached_property
    def _networks(self) -> dict[int, Network]:
        return {point.gear: self.model.network(point) for point in self.conditions}

    def near(self, circuit: str) -> tuple[np.ndarray, np.ndarray]:
        """Return which quantities and which causes act on a circuit first: its own and those of what feeds it."""
        controller = self.model.controller
        following = controller.line.following if controller.line else None
        sections, count = {circuit} | ({following.section} if following else set()), 0
        while len(sections) > count:
            count = len(sections)
            sections |= {feed.source for each in self._fed if each.id in sections for feed in each.feeds} - {LINE}
        lands = {gap.key for gap in controller.gaps if {gap.high.section, gap.low.section} & sections}

        def acts(cause: Cause) -> bool:
            return len(cause) == 1 or cause[1] in (lands if cause[0] == _LAND else sections)

        return np.array([acts(each) for each in self.quantities]), np.array([acts(each) for each in self.causes])


def losses(
    unit: PosteriorUnit, shown: Sequence[Shown], wanted: Iterable[tuple[str, OperatingPoint]], draws: int = _DRAWS
) -> dict[tuple[str, OperatingPoint], Lost]:
    """Return what circuits have lost against new at operating points, given every reading.

    Parameters
    ----------
    unit
        before any gauge is read, at all the operating points of ``shown`` and ``wanted``.
    shown
        the readings. Those of a circuit, of what feeds it and of the line tell of it; what others show acts on it by
        the line alone, which was read.
    wanted
        circuits by id, each with an operating point in whose gear it is applied; or the line, as p_g, whose regulator
        then counts as new too: it loses what that lets it fall, and not what it is set to.
    draws
        a power of two.
    """
    asked: dict[str, list[OperatingPoint]] = {}
    for circuit, point in wanted:
        asked.setdefault(circuit, []).append(point)
    first = unit.draw(unit.prior, draws, 0)
    held = {point: unit.pressures(first, point) for point in unit.conditions}
    lost = {}
    for circuit, points in asked.items():
        draws_of = _WeighedDraws(unit, circuit, shown)
        draws_of.add(unit.prior, first, held)
        while draws_of.effective < ENOUGH and len(draws_of.parts) <= _ROUNDS:
            draws_of.add_around(points)
        lost.update({(circuit, point): draws_of.lost(point) for point in points})
    return lost


class _WeighedDraws:
    """Draws of a unit from one proposal after the other, weighed by what gauges showed that tells of one circuit."""

    def __init__(self, unit: PosteriorUnit, circuit: str, shown: Sequence[Shown]) -> None:
        self.unit, self.circuit, self.near = unit, circuit, unit.near(circuit)
        feeds = zip(unit.quantities, self.near[0], strict=True)
        taps = {circuit, LINE, *(each[1] for each, acts in feeds if acts and each[0] == "feed")}
        self.evidence = [each for each in shown if each.tap in taps]
        self._likely = _likelihood(self.evidence, unit.assumptions.main_pressure)
        self.parts: list[tuple[_Drawn, Mapping[OperatingPoint, Mapping[str, Any]]]] = []
        self._proposals: list[_Proposal] = []
        self._log_likely: list[np.ndarray] = []

    def add(self, proposal: _Proposal, drawn: _Drawn, held: Mapping[OperatingPoint, Mapping[str, Any]]) -> None:
        """Add draws from a proposal, the prior first, with the pressures that they hold, and weigh all anew."""
        self.parts.append((drawn, held))
        self._proposals.append(proposal)
        size = drawn.wear.shape[1]
        expected = [np.broadcast_to(held[each.point][each.tap], size) for each in self.evidence]
        self._log_likely.append(self._likely(np.array(expected)))
        self._deviates = np.concatenate([each.deviates for each, _ in self.parts], axis=1)
        self._wear = np.concatenate([each.wear for each, _ in self.parts], axis=1)
        sizes = np.array([each.wear.shape[1] for each, _ in self.parts])
        logs = np.array([each.log_density(self._deviates, self._wear) for each in self._proposals])
        mixture = np.logaddexp.reduce(logs + np.log(sizes / sum(sizes))[:, None], axis=0)
        self._log_weight = np.concatenate(self._log_likely) + logs[0] - mixture

    def add_around(self, points: Iterable[OperatingPoint]) -> None:
        """Add half as many draws as there were at first, around those that carry the weight."""
        around = self.unit.prior.around(self._deviates, self._wear, _flattened(self._log_weight), self.near)
        again = self.unit.draw(around, self.parts[0][0].wear.shape[1] // 2, len(self.parts))
        at = dict.fromkeys([*(each.point for each in self.evidence), *points])
        self.add(around, again, {point: self.unit.pressures(again, point) for point in at})

    @property
    def effective(self) -> float:
        """Return how many draws of equal weight they are worth."""
        weights = _normed(self._log_weight)
        return 1.0 / float(np.sum(weights * weights))

    def _of_all(self, values: Iterable[Any]) -> np.ndarray:
        """Return what each part gives as one array over all draws."""
        parts = zip(values, self.parts, strict=True)
        return np.concatenate([np.broadcast_to(each, drawn.wear.shape[1]) for each, (drawn, _) in parts])

    def lost(self, point: OperatingPoint) -> Lost:
        """Return what the circuit has lost against new at an operating point."""
        circuit, drawn = self.circuit, [each for each, _ in self.parts]
        weights = _flattened(self._log_weight)
        kept = weights > 1e-9 * weights.max()
        new_units = [replace(each, wear=0.0 * each.wear) for each in drawn] if circuit == LINE else drawn
        when_new = [self.unit.pressures(each, point, new=True) for each in new_units]
        now, line = (self._of_all(held[point][name] for _, held in self.parts) for name in (circuit, LINE))
        new, line_new = (self._of_all(held[name] for held in when_new) for name in (circuit, LINE))
        leaks = [self.unit.leaks(each, circuit, point, held[point][circuit]) for each, held in self.parts]
        flows = {cause: self._of_all(each[cause] for each in leaks) for cause in leaks[0]}
        causes = _shares(flows, new - now, line_new - line, weights)
        highest = float(np.quantile(self.parts[0][1][point][circuit], 0.999))
        return Lost((new - now)[kept], now[kept], weights[kept], self.effective, causes, highest)


def _normed(log_weight: np.ndarray) -> np.ndarray:
    weights = np.exp(log_weight - log_weight.max())
    return np.asarray(weights / weights.sum())


def _flattened(log_weight: np.ndarray) -> np.ndarray:
    """Return weights flattened until they are worth some draws: one that carries all would draw all others to it."""
    for power in 0.7 ** np.arange(20):
        weights = _normed(power * log_weight)
        if float(np.sum(weights * weights)) * ENOUGH <= 4.0:
            break
    return weights


def _likelihood(shown: Sequence[Shown], relative: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return what gives the logarithm of the likelihood of the readings from what is expected, shape (readings, draws).

    A gauge that is named errs alike in all that it showed, but for what is read off it. Of others nobody knows which
    was where: part of their variance is shared by the readings of one tap.
    """
    showed = np.array([each.pressure for each in shown])
    errs = relative * np.maximum(showed, _LEAST * showed.max(initial=0.0))
    errs = np.maximum(errs, _FINEST)
    own = np.array([_READ_OFF if each.gauge else _UNNAMED for each in shown])
    alike = np.array([[_one_gauge(a, b) for b in shown] for a in shown])
    covariance = np.outer(errs, errs) * (np.diag(own) + alike * np.sqrt(np.outer(1.0 - own, 1.0 - own)))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def log_likelihood(expected: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.sum((whiten @ (showed[:, None] - expected)) ** 2, axis=0))

    return log_likelihood


def _one_gauge(a: Shown, b: Shown) -> bool:
    return a.gauge == b.gauge and (bool(a.gauge) or a.tap == b.tap)


def _shares(
    flows: Mapping[Cause, np.ndarray], loss: np.ndarray, of_line: np.ndarray, weights: np.ndarray
) -> dict[Cause, float]:
    """Return the part of the loss that each cause explains: what the line lost, the rest by what leaks more."""
    lost = weights * np.maximum(loss, 0.0)
    by_line = lost * np.clip(of_line / np.where(loss > 0.0, loss, np.inf), 0.0, 1.0)
    leaked = sum(flows.values(), np.zeros_like(loss))
    per_flow = (lost - by_line) / np.where(leaked > 0.0, leaked, np.inf)
    parts = {cause: float(flow @ per_flow) for cause, flow in flows.items()} | {(_LINE,): float(by_line.sum())}
    total = max(math.fsum(parts.values()), 1e-12)
    ranked = sorted(parts.items(), key=lambda each: -each[1])
    return {cause: part / total for cause, part in ranked if part > 0.0}
