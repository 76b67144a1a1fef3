"""Draw units as they may be before any gauge is read, and say what each of them holds.

Lands that were measured are drawn as their readings say, the others new or worn, and so seals, pump and line regulator;
fluid, temperature and feeds as uncertain as they are.
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
from atleak.diagnosis.missing import PUMP_PART, Path, Split, split
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.drawn_unit import FLUID_STATE, DemandShape, Drawn, DrawnLands
from atleak.diagnosis.uncertainty.draws import Beside, Cube, Draws, stream_of
from atleak.diagnosis.uncertainty.land_draws import LandDraws, LandInState, Positions, common_errors, land_draws
from atleak.diagnosis.uncertainty.one_sided_wear import Bore, one_sided_wear
from atleak.diagnosis.uncertainty.propagation import SEED
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.diagnosis.uncertainty.wear import UnitWear, new_before
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.network import SHARP, Network
from atleak.engine.operation import LINE, consumed
from atleak.engine.projection import Projection
from atleak.engine.restrictions import Branch, GapBranch, Orifice, Restriction
from atleak.equations.gap import eccentricity_factor
from atleak.equations.statistics import normal_cdf

_ANY = 1e5  # [1/m] by which clearances are scaled before they are cubed, so that a worn one is near 1
_LAND, _SEAL, _HOLE, _PUMP, _LINE, _SET = "land", "seal", "hole", "pump", "line", "set"
OF_A_SPLIT = 256  # draws
_BORES = ("bore", "new_bore", "unworn_bore")
MOST_RISE = 5.0  # of a line that is set high, over the mean rise
_SEALS = _SEAL, _HOLE
_TRIED = 65_536  # draws of the lands of a plug
_FINEST_PLUG = 0.02  # of what a plug passes: it is known no better
# beside the pressures of a unit: what its line leaves to consumers [m³/s], and whether it falls below what it is set to
LEFT, FALLS = "left", "falls"
_HELD = 0.9999  # of what a line is set to

Fault = tuple[Any, ...]  # (what, which): ("land", key), ("seal", circuit), ("pump",), ("line",)


@dataclass(frozen=True)
class UnitDraws:
    """Draws of units: standard deviates, shape (quantities, draws), and how far causes have gone, (causes, draws)."""

    deviates: np.ndarray
    wear: np.ndarray
    new: Mapping[LandKey, np.ndarray]  # [m] clearance when new of lands that nobody measured
    measured: Mapping[LandKey, LandDraws]  # lands whose readings draw them
    positions: Mapping[str, Any]  # of the spools, by component

    @classmethod
    def chosen(cls, parts: Sequence[UnitDraws], places: np.ndarray) -> UnitDraws:
        """Return some of the draws of several parts, by their places in all of them."""

        def taken(values: Sequence[Any]) -> Any:
            return np.concatenate(values, axis=-1)[..., places] if all(np.ndim(each) for each in values) else values[0]

        def bore(each: Sequence[Bore]) -> Bore:
            return Bore(*(taken(values) for values in zip(*(vars(one).values() for one in each), strict=True)))

        first = parts[0]
        return cls(
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


@dataclass(frozen=True)
class Effects:
    """What pressures are nearly linear in, each of shape (rows, draws)."""

    shared: np.ndarray  # standard deviates of what acts on the whole unit, and of feeds
    positions: np.ndarray  # of the spool of each part: its factor over a concentric one
    parts: np.ndarray  # cubes of clearances; how far other causes have gone

    @property
    def rows(self) -> np.ndarray:
        """Return all of them."""
        return np.concatenate([self.shared, self.positions * self.parts])


@dataclass(frozen=True)
class Prior:
    """From what units are drawn before any gauge is read: standard deviates, and causes by chance."""

    chance: np.ndarray  # of each cause
    mean: np.ndarray  # of its exponential
    most: np.ndarray

    def draw(self, stream: np.random.Generator, quantities: int, draws: int) -> tuple[np.ndarray, np.ndarray]:
        deviates = stream.standard_normal((quantities, draws))
        shape, cut = (len(self.mean), draws), -np.expm1(-self.most / self.mean)
        gone = -self.mean[:, None] * np.log1p(-stream.random(shape) * cut[:, None])
        return deviates, np.where(stream.random(shape) < self.chance[:, None], gone, 0.0)


@dataclass(frozen=True)
class Plug:
    """What a vacuum test says of lands that share a plug: what their gaps pass together, Σ F·D·c³/l over them."""

    lands: tuple[LandKey, ...]
    passes: float  # [m³], F 1 of a concentric spool
    uncertainty: float  # [m³] one standard deviation
    at_least: bool = False  # hardly any vacuum: they pass so much or more


class PosteriorUnit:
    """A unit before any gauge is read: draws of it, and what gauges would show on each."""

    def __init__(
        self,
        model: LeakageModel,
        sources: Sequence[LandSources],
        assumptions: Assumptions,
        projections: Iterable[Projection],
        plugs: Sequence[Plug] = (),
    ) -> None:
        """Take a unit with the sources of its lands' uncertainty, at the operating points at which gauges were read.

        Lands of ``plugs`` that nobody measured alone are drawn as what their plug passes leaves them.
        """
        self.model, self.sources, self.assumptions = model, sources, assumptions
        self._own = replace(assumptions, temperature=assumptions.gauged_temperature, main_pressure=1.0)
        self.conditions = {each.condition: each for each in projections}
        #: before any gauge is read, by their number
        self.drawn: dict[int, tuple[UnitDraws, dict[OperatingPoint, Mapping[str, Any]]]] = {}
        self._demands: dict[OperatingPoint, DemandShape] = {}
        self._networks: dict[int, Network] = {}
        controller = model.controller
        # lands that nobody measured
        self._open = [land for land in sources if not land.state.shows_wear and not land.state.land.seal]
        self._fed = [each for each in controller.circuits if each.feeds]
        # what is applied in some gears only is a clutch or a band, and has a seal
        self._sealed = [each.id for each in self._fed if each.gears != frozenset(controller.gears)]
        self.quantities: list[Fault] = [
            *((name,) for name in ("viscosity", "temperature", "main pressure", "converter pressure", "pump", "state")),
            *(("feed", each.id) for each in self._fed),
            *((_LAND, land.key) for land in self._open),
        ]
        known = {land.key for land in self._open}
        self._plugs = [each for each in plugs if known.intersection(each.lands)]
        self._plugged = {key for each in self._plugs for key in each.lands}
        gone = self._gone()
        self.causes = [cause for cause, *_ in gone]
        chance, mean, most = np.array([[max(number, 1e-30) for number in row] for _, *row in gone]).T
        self.prior = Prior(np.where(chance > 1e-30, chance, 0.0), mean, most)
        others = [cause for cause in self.causes if cause[0] != _LAND]
        #: of each row of the effects of parts: the cause that is drawn by itself, if one is
        self.parts: list[Fault | None] = [
            *(None if land.key in self._plugged else (_LAND, land.key) for land in self._open),
            *(None for land in sources if land.state.shows_wear),
            *others,
        ]

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

    def before(self, draws: int) -> tuple[UnitDraws, dict[OperatingPoint, Mapping[str, Any]]]:
        """Return draws of the unit before any gauge is read, the same each time, and where to keep what they hold."""
        if draws not in self.drawn:
            self.drawn[draws] = self.draw(draws), {}
        return self.drawn[draws]

    def draw(self, draws: int, *, as_judged: bool = False) -> UnitDraws:
        """Draw units; ``draws`` is a power of two.

        A measured land was new anywhere in its range; ``as_judged`` as wide as it may have been, as rules take it.
        """
        deviates, wear = self.prior.draw(stream_of(SEED, 11, 0), len(self.quantities), draws)
        shared = Draws(Cube(draws, SEED, 12, 0))
        measured = [land for land in self.sources if land.state.shows_wear]
        common, one_sided = (
            common_errors(shared, measured),
            one_sided_wear(shared, self.model, self.assumptions, measured),
        )
        own = Beside(Cube(draws, SEED, 13, 0), one_sided.fraction)
        positions = Positions(self.model, own, SEED)
        found = {
            land.key: land_draws(
                own.draws(SEED, 14, 0, number), land, common, one_sided, self.assumptions, positions.of(land)
            )
            for number, land in enumerate(measured)
        }
        if not as_judged:
            chances = stream_of(SEED, 15, 0)
            found = {key: self._with_unworn(each, chances.random(draws)) for key, each in found.items()}
        for number, plugs in enumerate(self._joined):
            self._fill(plugs, deviates, wear, found, stream_of(SEED, 16, 0, number))
        return UnitDraws(
            deviates,
            wear,
            {land.key: self._new(deviates, land) for land in self._open},
            found,
            {land.key[0]: positions.of(land) for land in self._open},
        )

    @cached_property
    def _joined(self) -> list[list[Plug]]:
        """Return the plugs, those in one that share lands that nobody measured."""
        open_, joined = {land.key for land in self._open}, list[list[Plug]]()
        for plug in self._plugs:
            shares = [each for each in joined if any(open_ & set(plug.lands) & set(one.lands) for one in each)]
            with_it = [*(one for each in shares for one in each), plug]
            joined = [*(each for each in joined if each not in shares), with_it]
        return joined

    def _fill(
        self,
        plugs: Sequence[Plug],
        deviates: np.ndarray,
        wear: np.ndarray,
        measured: Mapping[LandKey, LandDraws],
        stream: np.random.Generator,
    ) -> None:
        """Draw the lands of plugs anew, as likely as they are before gauges are read and together as what each passes.

        Where the spool lay in the test is not known, and says nothing of where it lies in service.
        """
        keys = dict.fromkeys(key for plug in plugs for key in plug.lands)
        lands = [land for land in self._open if land.key in keys]
        rows = [self.quantities.index((_LAND, land.key)) for land in lands]
        causes = [self.causes.index((_LAND, land.key)) for land in lands]
        tried, gone = self.prior.draw(stream, len(self.quantities), _TRIED)
        factor = {key[0]: np.asarray(eccentricity_factor(stream.random(_TRIED), 1.0)) for key in keys}
        passes = {
            land.key: factor[land.key[0]] * _passes(land, self._new(tried, land) + gone[cause])
            for land, cause in zip(lands, causes, strict=True)
        }
        for key in sorted(set(keys).intersection(measured)):
            clearance = stream.permutation(np.resize(measured[key].bore.clearance, _TRIED))
            passes[key] = factor[key[0]] * _passes(measured[key].land, clearance)
        apart = np.zeros(_TRIED)
        for plug in plugs:
            more = np.sum([passes[key] for key in plug.lands if key in passes], axis=0) - plug.passes
            apart += (np.minimum(more, 0.0) if plug.at_least else more) ** 2 / (
                max(plug.uncertainty, _FINEST_PLUG * plug.passes, 1e-18) ** 2
            )
        weights = np.cumsum(np.exp(-0.5 * (apart - np.min(apart))))
        places = np.searchsorted(weights, weights[-1] * stream.random(wear.shape[1])).clip(0, _TRIED - 1)
        deviates[rows], wear[causes] = tried[rows][:, places], gone[causes][:, places]

    def _new(self, deviates: np.ndarray, land: LandSources) -> np.ndarray:
        deviate = deviates[self.quantities.index((_LAND, land.key))]
        low, high = land.state.land.mounting_range
        if low < high:
            return np.asarray(low + (high - low) * normal_cdf(deviate))
        return np.maximum(low + land.u_mounting * deviate, 0.0)

    @cached_property
    def _usual(self) -> tuple[float, float]:
        return UnitWear(self.sources, self.assumptions).usual

    def _with_unworn(self, drawn: LandDraws, uniform: np.ndarray) -> LandDraws:
        """Return a measured land with what it was when new, given what it is: as wide, or worn from a narrower one.

        ``uniform`` is a number from 0 … 1 in each draw. New pairs are alike likely anywhere in their range; a land is
        worn as those of its unit are that were measured.
        """
        now, (low, high) = drawn.bore, drawn.land.state.land.mounting_range
        new = drawn.new_bore.clearance
        if low < high:
            new = new_before(now.clearance, (low, high), self._usual, uniform)
        both = zip((new, 0.0, 0.0, 1.0), vars(now).values(), strict=True)
        return replace(drawn, unworn_bore=Bore(*(np.where(now.clearance > new, each, as_is) for each, as_is in both)))

    def pressures(self, drawn: UnitDraws, point: OperatingPoint, *, new: bool = False) -> Mapping[str, Any]:
        """Return what the line, as p_g, and every circuit hold in each draw [Pa], or held when new."""
        wear = dict.fromkeys(self.causes, 0.0) if new else dict(zip(self.causes, drawn.wear, strict=True))
        # what a line is set to, or fallen to by its regulator, is the same for the unit when new
        given = self._given(drawn, point, drawn.wear[self.causes.index((_LINE,))])
        lands = [new_ if new else now for now, new_ in self._in_both_states(drawn)]
        counted, leakage = self._solved(drawn, given, lands, wear)
        return self._held(counted, leakage, wear, pump_new=new)

    def demand(self, drawn: UnitDraws, point: OperatingPoint, required: float) -> tuple[np.ndarray, ...]:
        """Return what leaves the pump in each draw at a line pressure that was measured, all slip included.

        Parameters
        ----------
        point
            with that pressure; as uncertain as the line's setting is among the assumptions.
        required
            what the line should hold there [Pa]: consumers take what is stated then, and less below it.

        Returns
        -------
        tuple
            the flow [m³/s] without consumers behind the line's regulator, the pressure [Pa] and the viscosity [Pa·s].
        """
        given, wear = self._given(drawn, point, 0.0), dict.fromkeys(self.causes, 0.0)
        counted, leakage = self._solved(drawn, given, [now for now, _ in self._in_both_states(drawn)], wear)
        main = given.pressures[LINE]
        slip = self._pump(given, wear, new=False).slip(main, given.viscosity)
        taken = consumed(counted.network, main, required, after_line=False)
        return leakage + slip + taken, main, given.viscosity

    def _given(self, drawn: UnitDraws, point: OperatingPoint, fallen: Any) -> Drawn:
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

    def _in_both_states(self, drawn: UnitDraws) -> list[tuple[LandInState, LandInState]]:
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
        self, drawn: UnitDraws, given: Drawn, lands: Sequence[LandInState], wear: Mapping[Fault, Any]
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
        if given.point not in self._demands:
            self._demands[given.point] = DemandShape(self.model, given.point)
        main, held = unit.held(self._demands[given.point])
        falls = main < _HELD * given.pressures[LINE]
        return {**held, LINE: main, LEFT: unit.left(given.point), FALLS: falls}

    def _pump(self, given: Drawn, wear: Mapping[Fault, Any], *, new: bool) -> PumpFlow:
        """Return the pump as drawn; of one that nobody measured its slip has grown by so much."""
        pump = given.new_pump if new else given.pump
        if (_PUMP,) in wear and not new:
            pump = replace(pump, slip_factor=pump.slip_factor * (1.0 + wear[_PUMP,]))
        return pump

    def split(self, drawn: UnitDraws, point: OperatingPoint, tap: str) -> Split:
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
    def as_measured(self) -> UnitDraws:
        """Return draws of the unit by what was measured alone: no fault that nobody saw is drawn."""
        drawn = self.draw(OF_A_SPLIT, as_judged=True)
        return replace(drawn, wear=np.zeros_like(drawn.wear))

    def split_as_measured(self, point: OperatingPoint, tap: str) -> Split:
        """Split what a tap has lost by what was measured alone."""
        return self.split(self.as_measured, point, tap)

    def _leak(self, what: str, name: str, point: OperatingPoint, viscosity: Any, gone: Any) -> Restriction:
        """Return a leak that takes ``gone`` times what the circuit's feeds pass at the highest line pressure."""
        stated = self.model.controller.operating_points
        highest, feeds = max(stated, key=lambda each: each.main_pressure), self._network(point.gear).feeds
        pressure, nominal = highest.main_pressure, self.model.dynamic_viscosity(highest.temperature)
        through = gone * sum(each.restriction.flow(pressure) for each in feeds if each.into == name)
        if what == _HOLE:
            return Orifice(through / math.sqrt(pressure), SHARP)
        return GapBranch(through / pressure * nominal / viscosity)

    def _network(self, gear: int) -> Network:
        if gear not in self._networks:
            self._networks[gear] = self.model.network(next(each for each in self.conditions if each.gear == gear))
        return self._networks[gear]

    @cached_property
    def followed(self) -> frozenset[str]:
        """Return the ids of the circuit that line pressure follows, and of those that feed it; none without one."""
        line = self.model.controller.line
        following = line.following if line is not None else None
        return self.fed_from(following.section) if following is not None and following.section else frozenset()

    def fed_from(self, circuit: str) -> frozenset[str]:
        """Return the ids of a circuit and of all circuits that feed it."""
        sections, waiting = {circuit}, [circuit]
        while waiting:
            fed = waiting.pop()
            new = {feed.source for each in self._fed if each.id == fed for feed in each.feeds} - {LINE} - sections
            sections |= new
            waiting += new
        return frozenset(sections)

    def effects(self, drawn: UnitDraws) -> Effects:
        """Return what pressures are nearly linear in: slip and line by their logarithms, leaks as they are."""
        size = drawn.wear.shape[1]
        lands = [now for now, _ in self._in_both_states(drawn)]
        ways: dict[str, Callable[..., np.ndarray]] = {
            _PUMP: np.log1p,
            _SET: np.log1p,
            _LINE: lambda gone: np.log1p(-gone),
        }
        gone = dict(zip(self.causes, drawn.wear, strict=True))
        others = [ways.get(what[0], np.asarray)(gone[what]) for what in self.causes if what[0] != _LAND]
        positions = [*(1.0 if land[3] is None else land[3] for land in lands), *(1.0 for _ in others)]
        parts = [*(np.maximum(_ANY * land[1].clearance, 0.0) ** 3 for land in lands), *others]
        both = (np.array([np.broadcast_to(each, size) for each in rows]) for rows in (positions, parts))
        return Effects(drawn.deviates[self._shared], *both)

    @cached_property
    def _shared(self) -> np.ndarray:
        return np.array([each[0] != _LAND for each in self.quantities])

    def put_together(
        self, drawn: UnitDraws, places: np.ndarray, own: Mapping[int, np.ndarray], shared: np.ndarray
    ) -> UnitDraws:
        """Return units put together from draws: some parts from other places than the rest, shared deviates anew."""
        made = UnitDraws.chosen([drawn], places)
        made.deviates[self._shared] = shared
        for row, place in own.items():
            part = self.parts[row]
            assert part is not None
            cause = self.causes.index(part)
            made.wear[cause] = drawn.wear[cause, place]
            if part[0] == _LAND:
                quantity = self.quantities.index(part)
                made.deviates[quantity] = drawn.deviates[quantity, place]
                made.new[part[1]][:] = drawn.new[part[1]][place]
        return made

    @property
    def lands(self) -> tuple[LandKey, ...]:
        """Return every land of which the clearance is drawn, by component and land."""
        return tuple(land.key for land in self.sources if not land.state.land.seal)

    def clearances(self, drawn: UnitDraws) -> dict[LandKey, tuple[np.ndarray, np.ndarray]]:
        """Return the clearance of every land in each draw, and what it was when new [m]."""
        size = drawn.wear.shape[1]
        lands = ((now[0].key, now[1].clearance, new[1].clearance) for now, new in self._in_both_states(drawn))
        return {key: (np.broadcast_to(now, size), np.broadcast_to(new, size)) for key, now, new in lands}

    def growth_of_slip(self, drawn: UnitDraws) -> np.ndarray:
        """Return by which fraction the pump's slip has grown in each draw; measured clearances that count tell it."""
        if (_PUMP,) in self.causes:
            return drawn.wear[self.causes.index((_PUMP,))]
        given = self._given(drawn, next(iter(self.conditions)), 0.0)
        now, new = (each.slip(given.pressures[LINE], given.viscosity) for each in (given.pump, given.new_pump))
        return np.broadcast_to(np.divide(now, new, out=np.ones_like(now), where=new > 0.0) - 1.0, drawn.wear.shape[1])


def _passes(land: LandSources, clearance: Any) -> Any:
    """Return D·c³/l of a land [m³], what it passes with its spool in the middle."""
    return land.state.spool_diameter * np.maximum(clearance, 0.0) ** 3 / land.state.land.contact_length


def _stacked(now: LandInState, new: LandInState, made_new: Sequence[bool]) -> LandInState:
    """Return a land in one state or the other by the sets, its bore of shape (sets, draws); as it is where it stays."""
    if not any(made_new):
        return now
    mask = np.array(made_new)[:, None]
    bores = zip(vars(new[1]).values(), vars(now[1]).values(), strict=True)
    return now[0], Bore(*(np.where(mask, *both) for both in bores)), *now[2:]
