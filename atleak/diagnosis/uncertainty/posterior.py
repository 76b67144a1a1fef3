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
from typing import Any, NamedTuple

import numpy as np

from atleak.catalogue.circuits import Pressure
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.missing import PUMP_PART, Path, Split, split
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.drawn_unit import DemandShape, Drawn, DrawnLands
from atleak.diagnosis.uncertainty.draws import (
    FLUID_STATE,
    Beside,
    Bore,
    Cube,
    Draws,
    LandDraws,
    LandInState,
    Positions,
    common_errors,
    land_draws,
    one_sided_fraction,
    stream_of,
)
from atleak.diagnosis.uncertainty.propagation import SEED
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.network import SHARP, Network
from atleak.engine.operation import LINE
from atleak.engine.projection import Projection
from atleak.engine.restrictions import Branch, GapBranch, Orifice, Restriction
from atleak.equations.statistics import normal_cdf

_DRAWS = 8_192  # of units before any gauge is read, and half as many at a time around what was found
ENOUGH = 200  # effective draws
SURELY = 4.0  # standard uncertainties by which a gauge shows more than there can be: choice of this project
_ROUNDS = 4  # of drawing around what was found
_PRIOR_COUNTS = 20.0  # effective draws that the prior stands for while a proposal is fitted
_NARROWEST = 0.2  # standard deviation of a proposal, over that of the prior
_READ_OFF = 0.1  # of a named gauge's variance: what differs from reading to reading
_UNNAMED = 0.7  # the same of gauges that nobody named: which was where is not known
_LEAST = 0.25  # of the highest pressure shown: a gauge errs no less than it does there
_FINEST = 1e3  # [Pa] that a gauge tells apart
_LAND, _SEAL, _HOLE, _PUMP, _LINE, _SET = "land", "seal", "hole", "pump", "line", "set"
OF_A_SPLIT = 256  # draws
_BORES = ("bore", "new_bore", "unworn_bore")
MOST_RISE = 5.0  # of a line that is set high, over the mean rise
_SEALS = _SEAL, _HOLE
_LEAST_WEAR = 0.1e-6  # [m]
_COUNTS = 1e-6  # of the largest weight, from which on a draw is looked at again

Fault = tuple[Any, ...]  # (what, which): ("land", key), ("seal", circuit), ("pump",), ("line",)


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
    highest: float  # [Pa] that it holds in 999 of 1000 units, before any gauge is read
    split: Split  # of all that it lost with the line, by draws of equal weight
    contradicted: frozenset[tuple[str, OperatingPoint]] = frozenset()  # taps that showed what none of the draws expects

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
        self._before: dict[int, tuple[_Drawn, dict[OperatingPoint, Mapping[str, Any]]]] = {}
        self._demands = {point: DemandShape(model, point) for point in self.conditions}
        controller = model.controller
        gears = {point.gear for point in self.conditions}
        leaking = {gap.key for gap in controller.gaps if not gears.isdisjoint(gap.gears)}
        self._open = [  # lands that nobody measured
            land for land in sources if not land.state.measured and not land.state.land.seal and land.key in leaking
        ]
        self._fed = [each for each in controller.circuits if each.feeds]
        # what is applied in some gears only is a clutch or a band, and has a seal
        self._sealed = [each.id for each in self._fed if each.gears != frozenset(controller.gears)]
        self.quantities: list[Fault] = [
            *((name,) for name in ("viscosity", "temperature", "main pressure", "converter pressure", "pump", "state")),
            *(("feed", each.id) for each in self._fed),
            *((_LAND, land.key) for land in self._open),
        ]
        gone = self._gone()
        self.causes = [cause for cause, *_ in gone]
        chance, mean, most = np.array([[max(number, 1e-30) for number in row] for _, *row in gone]).T
        count = len(self.quantities)
        self.prior = _Proposal(np.where(chance > 1e-30, chance, 0.0), mean, most, np.zeros(count), np.ones(count))

    def _gone(self) -> list[tuple[Fault, float, float, float]]:
        """Return every cause of a leak with its chance, and mean and most of how far it goes."""
        u = self.assumptions
        gone: list[tuple[Fault, float, float, float]] = [
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
        if self.model.pump_open:
            gone.append(((_PUMP,), u.worn_pumps, u.pump_wear, 6.0 * u.pump_wear))
        return gone

    def before(self, draws: int) -> tuple[_Drawn, dict[OperatingPoint, Mapping[str, Any]]]:
        """Return draws of the unit before any gauge is read, the same each time, and where to keep what they hold."""
        if draws not in self._before:
            self._before[draws] = self.draw(self.prior, draws, 0), {}
        return self._before[draws]

    def draw(self, proposal: _Proposal, draws: int, seed: int, *, as_judged: bool = False) -> _Drawn:
        """Draw units; ``draws`` is a power of two.

        A measured land was new anywhere in its range; ``as_judged`` as wide as it may have been, as rules take it.
        """
        deviates, wear = proposal.draw(stream_of(SEED, 11, seed), draws)
        shared = Draws(Cube(draws, SEED, 12, seed))
        measured = [land for land in self.sources if land.state.measured]
        common, fraction = common_errors(shared, measured), one_sided_fraction(shared, self.model, self.assumptions)
        own = Beside(Cube(draws, SEED, 13, seed), fraction)
        positions = Positions(self.model, own, SEED + seed)
        found = {
            land.key: land_draws(
                own.draws(SEED, 14, seed, number), land, common, fraction, self.assumptions, positions.of(land)
            )
            for number, land in enumerate(measured)
        }
        if not as_judged:
            chances = stream_of(SEED, 15, seed)
            found = {key: self._with_unworn(each, *chances.random((2, draws))) for key, each in found.items()}
        return _Drawn(
            deviates,
            wear,
            {land.key: self._new(deviates, land) for land in self._open},
            found,
            {land.key[0]: positions.of(land) for land in self._open},
        )

    def _new(self, deviates: np.ndarray, land: LandSources) -> np.ndarray:
        deviate = deviates[self.quantities.index((_LAND, land.key))]
        low, high = land.state.land.mounting_range
        if low < high:
            return np.asarray(low + (high - low) * normal_cdf(deviate))
        return np.maximum(low + land.u_mounting * deviate, 0.0)

    def _with_unworn(self, drawn: LandDraws, first: np.ndarray, second: np.ndarray) -> LandDraws:
        """Return a measured land with what it was when new, given what it is: as wide, or worn from a narrower one.

        ``first`` and ``second`` are two numbers from 0 … 1 in each draw. New pairs are alike likely anywhere in their
        range; a land is worn as one that nobody measured would be.
        """
        u, now, (low, high) = self.assumptions, drawn.bore, drawn.land.state.land.mounting_range
        new, worn = drawn.new_bore.clearance, now.clearance > drawn.new_bore.clearance
        if low < high:
            mean = max(u.land_wear, _LEAST_WEAR)
            ways = np.clip(now.clearance, low, high) - low  # from where it may have worn
            by_wear = -u.worn_lands * np.expm1(-ways / mean)
            worn = (now.clearance > high) | (first * (by_wear + 1.0 - u.worn_lands) < by_wear)
            new = low + mean * np.log1p(second * np.expm1(ways / mean))
        both = zip((new, 0.0, 0.0), vars(now).values(), strict=True)
        return replace(drawn, unworn_bore=Bore(*(np.where(worn, each, as_is) for each, as_is in both)))

    def pressures(self, drawn: _Drawn, point: OperatingPoint, *, new: bool = False) -> Mapping[str, Any]:
        """Return what the line, as p_g, and every circuit hold in each draw [Pa], or held when new."""
        wear = dict.fromkeys(self.causes, 0.0) if new else dict(zip(self.causes, drawn.wear, strict=True))
        # what a line is set to, or fallen to by its regulator, is the same for the unit when new
        given = self._given(drawn, point, drawn.wear[self.causes.index((_LINE,))])
        lands = [new_ if new else now for now, new_ in self._in_both_states(drawn)]
        counted, leakage = self._solved(drawn, given, lands, wear)
        return self._held(counted, leakage, wear, pump_new=new)

    def _given(self, drawn: _Drawn, point: OperatingPoint, fallen: Any) -> Drawn:
        """Return a condition with all that is drawn of it, the line fallen by so much through its regulator."""
        at, u = dict(zip(self.quantities, drawn.deviates, strict=True)), self.assumptions
        higher = drawn.wear[self.causes.index((_SET,))]
        return Drawn(
            self.model,
            self.conditions[point],
            self._own,
            {
                "viscosity": at["viscosity",],
                "temperature": at["temperature",],
                "main pressure": (1.0 + u.line_setting * at["main pressure",] + higher) * (1.0 - fallen) - 1.0,
                "converter pressure": at["converter pressure",],
                "pump efficiency": at["pump",],
                FLUID_STATE: math.sqrt(3.0) * (2.0 * normal_cdf(at["state",]) - 1.0),  # rectangular
            },
        )

    def _in_both_states(self, drawn: _Drawn) -> list[tuple[LandInState, LandInState]]:
        """Return every land that leaks as it is, and as it was when new."""
        wear = dict(zip(self.causes, drawn.wear, strict=True))
        lands: list[tuple[LandInState, LandInState]] = []
        for land in self._open:
            new, state, position = drawn.new[land.key], land.state.land, drawn.positions[land.key[0]]
            bores = Bore(new + wear[_LAND, land.key]), Bore(new)
            now, before = ((land, bore, state.contact_length, position) for bore in bores)
            lands.append((now, before))
        return [*lands, *((each.now, each.unworn) for each in drawn.measured.values())]

    def _solved(
        self, drawn: _Drawn, given: Drawn, lands: Sequence[LandInState], wear: Mapping[Fault, Any]
    ) -> tuple[DrawnLands, Any]:
        """Return the unit with lands in a state and seals worn so far, and what it draws from the pump [m³/s]."""
        at, u = dict(zip(self.quantities, drawn.deviates, strict=True)), self.assumptions

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
                    self._leak(what, name, given.point, given.viscosity, gone),
                    None,
                    True,
                )
                for what in _SEALS
                for name in self._sealed
                if name in network.solved and np.any(gone := wear[what, name])
            )
            return replace(network, feeds=scaled, leaks=(*network.leaks, *seals))

        counted = DrawnLands(given, lands, with_rest)
        return counted, counted.leakage + sum(counted.flow(*land)[1] for land in lands)

    def _held(
        self, counted: DrawnLands, leakage: Any, wear: Mapping[Fault, Any], *, pump_new: bool
    ) -> Mapping[str, Any]:
        given = counted.given
        unit = replace(counted.unit(self._pump(given, wear, new=pump_new)), leakage=leakage)
        main, held = unit.held(self._demands[given.point])
        return {**held, LINE: main}

    def _pump(self, given: Drawn, wear: Mapping[Fault, Any], *, new: bool) -> PumpFlow:
        """Return the pump as drawn; of one that nobody measured its slip has grown by so much."""
        pump = given.new_pump if new else given.pump
        if (_PUMP,) in wear and not new:
            pump = replace(pump, slip_factor=pump.slip_factor * (1.0 + wear[_PUMP,]))
        return pump

    def split(self, drawn: _Drawn, point: OperatingPoint, tap: str) -> Split:
        """Split what a tap has lost in each draw by its causes; its clutch's seal counts last.

        Wear of lands and pump that nobody measured counts as theirs. A line that its regulator lets fall and other
        circuits' seals stay out of every row.
        """
        wear, states = dict(zip(self.causes, drawn.wear, strict=True)), self._in_both_states(drawn)
        sound = wear | {cause: 0.0 for cause in self.causes if cause[0] in _SEALS}
        given = self._given(drawn, point, 0.0)
        path = Path.of(self.model.controller, point.gear, tap)
        known = {now[0].key for now, _ in states}
        path = path.without(
            set(path.circuits) - known, pump=(_PUMP,) in wear or given.pump.pump is not given.new_pump.pump
        )

        def made(sets: Sequence[frozenset[str]]) -> tuple[np.ndarray, np.ndarray]:
            of_lands = [path.lands_of(each) for each in sets]
            distinct = list(dict.fromkeys(of_lands))
            chosen = [_stacked(now, new, [now[0].key in each for each in distinct]) for now, new in states]
            counted, leakage = self._solved(drawn, given, chosen, sound)
            pressure: list[np.ndarray] = []
            demand: list[np.ndarray] = []
            for pump_new in (False, True):
                held = self._held(counted, leakage, sound, pump_new=pump_new)[tap]
                slip = self._pump(given, sound, new=pump_new).slip(given.pressures[LINE], given.viscosity)
                for rows, values in ((pressure, held), (demand, leakage + slip)):
                    rows.append(np.broadcast_to(values, (len(distinct), drawn.wear.shape[1])))
            of_sets = zip(sets, of_lands, strict=True)
            places = [(int(PUMP_PART in each), distinct.index(lands)) for each, lands in of_sets]
            return np.array([pressure[a][b] for a, b in places]), np.array([demand[a][b] for a, b in places])

        counted, _ = self._solved(drawn, given, [now for now, _ in states], sound)
        excess = {now[0].key: counted.more_than(now, new) for now, new in states}
        found = split(path, made, excess)
        if tap not in self._sealed:
            return found
        seals = [self.causes.index((what, tap)) for what in _SEALS]
        tight = drawn.wear.copy()
        tight[seals] = 0.0
        beside, with_it_tight = (self.pressures(each, point)[tap] for each in (drawn, replace(drawn, wear=tight)))
        return replace(found, seal=with_it_tight - beside, seal_worn=float(np.mean(drawn.wear[seals].any(axis=0))))

    @cached_property
    def as_measured(self) -> _Drawn:
        """Return draws of the unit by what was measured alone: no fault that nobody saw is drawn."""
        drawn = self.draw(self.prior, OF_A_SPLIT, 0, as_judged=True)
        return replace(drawn, wear=np.zeros_like(drawn.wear))

    def split_as_measured(self, point: OperatingPoint, tap: str) -> Split:
        """Split what a tap has lost by what was measured alone."""
        return self.split(self.as_measured, point, tap)

    def _leak(self, what: str, name: str, point: OperatingPoint, viscosity: Any, gone: Any) -> Restriction:
        """Return a leak that takes ``gone`` times what the circuit's feeds pass at the highest line pressure."""
        highest, feeds = max(self.conditions, key=lambda each: each.main_pressure), self._networks[point.gear].feeds
        pressure, nominal = highest.main_pressure, self.model.dynamic_viscosity(highest.temperature)
        through = gone * sum(each.restriction.flow(pressure) for each in feeds if each.into == name)
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

        def acts(cause: Fault) -> bool:
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
    lost: dict[tuple[str, OperatingPoint], Lost] = {}
    rounds = [_Round(unit.prior, *unit.before(draws))]
    for circuit in sorted(asked, key=lambda each: each != LINE):  # what the line tells serves every circuit
        draws_of = _WeighedDraws(unit, circuit, asked[circuit], shown)
        draws_of.add(*rounds)
        for _ in range(_ROUNDS):
            if draws_of.effective < ENOUGH:
                draws_of.add_around()
        rounds = draws_of.rounds if circuit == LINE else rounds
        lost |= {(circuit, point): draws_of.lost(point) for point in asked[circuit]}
    return lost


class _Round(NamedTuple):
    """Draws of units from one proposal, with what they hold where that was asked for."""

    proposal: _Proposal
    drawn: _Drawn
    held: dict[OperatingPoint, Mapping[str, Any]]

    @property
    def draws(self) -> int:
        return int(self.drawn.wear.shape[1])


class _WeighedDraws:
    """Draws of a unit from one proposal after the other, weighed by what gauges showed that tells of one circuit."""

    def __init__(
        self, unit: PosteriorUnit, circuit: str, points: Sequence[OperatingPoint], shown: Sequence[Shown]
    ) -> None:
        self.unit, self.circuit, self.near = unit, circuit, unit.near(circuit)
        feeds = zip(unit.quantities, self.near[0], strict=True)
        taps = {circuit, LINE, *(each[1] for each, acts in feeds if acts and each[0] == "feed")}
        self.evidence = [each for each in shown if each.tap in taps]
        self._likely = _likelihood(self.evidence, unit.assumptions.main_pressure)
        self._points = dict.fromkeys([*(each.point for each in self.evidence), *points])
        self.rounds: list[_Round] = []
        self._expected = np.empty((len(self.evidence), 0))

    def add(self, *rounds: _Round) -> None:
        """Add rounds of draws, that from the prior first, and weigh all anew."""
        for each in rounds:
            for point in self._points:
                if point not in each.held:
                    each.held[point] = self.unit.pressures(each.drawn, point)
            expected = [np.broadcast_to(each.held[one.point][one.tap], each.draws) for one in self.evidence]
            self._expected = np.concatenate([self._expected, np.reshape(expected, (-1, each.draws))], axis=1)
        self.rounds += rounds
        self._deviates = np.concatenate([each.drawn.deviates for each in self.rounds], axis=1)
        self._wear = np.concatenate([each.drawn.wear for each in self.rounds], axis=1)
        sizes = np.array([each.draws for each in self.rounds])
        logs = np.array([each.proposal.log_density(self._deviates, self._wear) for each in self.rounds])
        mixture = np.logaddexp.reduce(logs + np.log(sizes / sum(sizes))[:, None], axis=0)
        self._log_weight = self._likely(self._expected) + logs[0] - mixture

    def add_around(self) -> None:
        """Add half as many draws as there were at first, around those that carry the weight."""
        around = self.unit.prior.around(self._deviates, self._wear, _flattened(self._log_weight), self.near)
        self.add(_Round(around, self.unit.draw(around, self.rounds[0].draws // 2, len(self.rounds)), {}))

    @property
    def effective(self) -> float:
        """Return how many draws of equal weight they are worth."""
        weights = _normed(self._log_weight)
        return 1.0 / float(np.sum(weights * weights))

    @property
    def contradicted(self) -> frozenset[tuple[str, OperatingPoint]]:
        """Return where a gauge showed surely more, or less, than the units do that agree best with all gauges."""
        weights, errs = _flattened(self._log_weight), _errs(self.evidence, self.unit.assumptions.main_pressure)
        found = set()
        for each, expected, err in zip(self.evidence, self._expected, errs, strict=True):
            order = np.argsort(expected)
            ends = np.searchsorted(np.cumsum(weights[order]), (0.025, 0.975)).clip(0, len(order) - 1)
            low, high = expected[order][ends]
            if not low - SURELY * err <= each.pressure <= high + SURELY * err:
                found.add((each.tap, each.point))
        return frozenset(found)

    def equally_likely(self) -> _Drawn:
        """Return draws of equal weight out of all of them."""
        chosen = np.searchsorted(np.cumsum(_flattened(self._log_weight)), (np.arange(OF_A_SPLIT) + 0.5) / OF_A_SPLIT)
        return self._chosen(np.minimum(chosen, self._wear.shape[1] - 1))

    def _chosen(self, chosen: np.ndarray) -> _Drawn:
        """Return some of all draws, by their places."""
        parts = [each.drawn for each in self.rounds]

        def taken(values: Sequence[Any]) -> Any:
            return np.concatenate(values, axis=-1)[..., chosen] if all(np.ndim(each) for each in values) else values[0]

        def bore(each: Sequence[Bore]) -> Bore:
            return Bore(*(taken(values) for values in zip(*(vars(one).values() for one in each), strict=True)))

        first = parts[0]
        return _Drawn(
            taken([each.deviates for each in parts]),
            taken([each.wear for each in parts]),
            {key: taken([each.new[key] for each in parts]) for key in first.new},
            {
                key: LandDraws(
                    land.land,
                    *(bore([getattr(each.measured[key], name) for each in parts]) for name in _BORES),
                    *(taken([getattr(each.measured[key], name) for each in parts]) for name in ("length", "position")),
                )
                for key, land in first.measured.items()
            },
            {key: taken([each.positions[key] for each in parts]) for key in first.positions},
        )

    def lost(self, point: OperatingPoint) -> Lost:
        """Return what the circuit has lost against new at an operating point."""
        circuit, weights = self.circuit, _flattened(self._log_weight)
        kept = np.flatnonzero(weights > _COUNTS * weights.max())
        weights, drawn = weights[kept] / weights[kept].sum(), self._chosen(kept)
        sound = replace(drawn, wear=np.zeros_like(drawn.wear)) if circuit == LINE else drawn
        now = np.concatenate([np.broadcast_to(each.held[point][circuit], each.draws) for each in self.rounds])[kept]
        new = np.broadcast_to(self.unit.pressures(sound, point, new=True)[circuit], kept.shape)
        highest = float(np.quantile(self.rounds[0].held[point][circuit], 0.999))
        by_cause = self.unit.split(self.equally_likely(), point, circuit)
        return Lost(new - now, now, weights, self.effective, highest, by_cause, self.contradicted)


def _stacked(now: LandInState, new: LandInState, made_new: Sequence[bool]) -> LandInState:
    """Return a land in one state or the other by the sets, its bore of shape (sets, draws); as it is where it stays."""
    if not any(made_new):
        return now
    mask = np.array(made_new)[:, None]
    bores = zip(vars(new[1]).values(), vars(now[1]).values(), strict=True)
    return now[0], Bore(*(np.where(mask, *both) for both in bores)), *now[2:]


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
    showed, errs = np.array([each.pressure for each in shown]), _errs(shown, relative)
    own = np.array([_READ_OFF if each.gauge else _UNNAMED for each in shown])
    alike = np.array([[_one_gauge(a, b) for b in shown] for a in shown])
    covariance = np.outer(errs, errs) * (np.diag(own) + alike * np.sqrt(np.outer(1.0 - own, 1.0 - own)))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def log_likelihood(expected: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.sum((whiten @ (showed[:, None] - expected)) ** 2, axis=0))

    return log_likelihood


def _errs(shown: Sequence[Shown], relative: float) -> np.ndarray:
    """Return the standard uncertainty of every reading [Pa]."""
    showed = np.array([each.pressure for each in shown])
    return np.maximum(relative * np.maximum(showed, _LEAST * showed.max(initial=0.0)), _FINEST)


def _one_gauge(a: Shown, b: Shown) -> bool:
    return a.gauge == b.gauge and (bool(a.gauge) or a.tap == b.tap)
