"""Carry uncertain clearances, fluid, pressures and pump into the spread of every flow and of the total.

This is the Monte Carlo method of JCGM 101. An error that lands share is drawn once per trial and used for all of them.
What a share has grown by is judged against the same unit unworn in the same trial: with the same fluid, pressures, pump
and contact lengths, and with mounting clearances drawn from what is known of them. Where only a range or a type's value
is known, a land is unworn as far as its reading may be that of a new pair.

A bore wears to one side, which two-point diameters cannot see: by how much is one fraction of all wear, drawn once per
trial for the whole unit, with a phase of its own for each land. Where nobody knows how the spools lie, e/c is drawn for
each component, the same for its lands now and new.

The circuits' pressures are solved in every trial: a land that leaks more in it finds less pressure before it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import TypeVar

import numpy as np

from atleak.catalogue.limits import Limits, Steps
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.balance import Balance
from atleak.engine.circuits import Network
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import consumed
from atleak.engine.projection import Projection
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.drawn import Condition, Drawn, leakiest
from atleak.uncertainty.draws import (
    LandDraws,
    LandInState,
    Positions,
    common_errors,
    deviates_of_factors,
    land_draws,
    one_sided_fraction,
)
from atleak.uncertainty.linear import LandSlopes, Linear
from atleak.uncertainty.points import Beside, Cube, Draws
from atleak.uncertainty.pressures import DrawnUnit, PressureSpread, pressure_spread
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import Spread, flow_ratio, interval_of, spread_of

Value = TypeVar("Value")
SEED = 7667
_NOW, _NEW, _UNWORN = attrgetter("now"), attrgetter("new"), attrgetter("unworn")  # of the draws of a land
DRAWS = 8_192
DRAWS_OF_CIRCUITS = 4_096  # of a unit with circuits, whose pressures are solved anew in every one


@dataclass(frozen=True)
class LandSpread:
    """The spread of the leakage of one land at one condition, and its slopes for the linear budget."""

    slopes: LandSlopes
    leakage_spread: Spread
    share_spread: Spread


@dataclass(frozen=True)
class TotalSpread:
    """The leakage of the whole controller at one condition, and its spread."""

    leakage_spread: Spread
    share_spread: Spread
    minimum_speed_interval: tuple[float, float]  # [1/s]
    band_probabilities: tuple[float, ...]  # below the first limit, between, above the last
    new_leakage_interval: tuple[float, float]  # [m³/s] of the same unit new
    growth_interval: tuple[float, float]  # of the leakage over that of the same unit new
    pressures: PressureSpread
    effects: dict[str, float]  # change of the share for one standard uncertainty of each source


@dataclass(frozen=True)
class InstantSpread:
    """The intervals of the whole controller's leakage [m³/s] and share at one instant of a log."""

    leakage_interval: tuple[float, float]
    share_interval: tuple[float, float]


@dataclass(frozen=True)
class UnitSpread:
    """The spread of every land, in the order of the controller, and of the total at one condition."""

    lands: tuple[LandSpread, ...]
    total: TotalSpread


class Known:
    """What was carried through for one unit already, by condition; those that were asked for last are kept."""

    MOST = 64

    def __init__(self) -> None:
        """Start with nothing known."""
        self.units: dict[OperatingPoint, UnitSpread] = {}
        self.instants: dict[OperatingPoint, InstantSpread] = {}
        self._settings: tuple[float, int, int] | None = None

    def at(self, coverage: float, draws: int, seed: int) -> Known:
        """Return the same; nothing known where it was carried through in another way."""
        settings = coverage, draws, seed
        if settings != self._settings:
            self.units, self.instants, self._settings = {}, {}, settings
        return self

    def keep(
        self, units: Mapping[OperatingPoint, UnitSpread], instants: Mapping[OperatingPoint, InstantSpread]
    ) -> None:
        """Keep these as the latest."""
        self.units = _latest(self.units, units)
        self.instants = _latest(self.instants, instants)


def _latest(kept: Mapping[OperatingPoint, Value], asked: Mapping[OperatingPoint, Value]) -> dict[OperatingPoint, Value]:
    """Return the same with those that were asked for at the end; a new one, as another thread may read the first."""
    every = {at: value for at, value in kept.items() if at not in asked} | {**asked}
    return dict(list(every.items())[-Known.MOST :])


@dataclass
class Propagated:
    """The spread of every land and of the total, at each condition in the order given; of the instants' totals."""

    lands: list[tuple[LandSpread, ...]]
    totals: list[TotalSpread]
    instants: list[InstantSpread]


def propagate(
    model: LeakageModel,
    sources: Sequence[LandSources],
    projections: Sequence[Projection],
    assumptions: Assumptions,
    *,
    limits: Limits,
    coverage: float,
    draws: int,
    seed: int,
    instants: Sequence[Projection] = (),
    known: Known | None = None,
) -> Propagated:
    """Carry every uncertainty through the gap law.

    Parameters
    ----------
    limits
        of shares, reserve and pressures: the probability of having reached each is computed, growth against the same
        land or unit new included.
    coverage
        probability of the intervals, 0 … 1; they leave out as much below as above.
    draws, seed
        number of draws, a power of two, and seed of the Monte Carlo: the same input gives the same digits.
    instants
        conditions of which only the total's interval is wanted: those of some instants of a log.
    known
        what was carried through before, of the same unit with the same of all that stands above but the conditions:
        only what is new is computed, and added to it.

    Raises
    ------
    DomainError
        A condition's temperature outside the fluid's data.
    """
    known = (known or Known()).at(coverage, draws, seed)
    of_units, of_instants = known.units, known.instants  # another thread may replace them
    units = {each.condition: of_units[each.condition] for each in projections if each.condition in of_units}
    totals = {each.condition: of_instants[each.condition] for each in instants if each.condition in of_instants}
    new = [each for each in projections if each.condition not in units]
    moments = [each for each in instants if each.condition not in totals]
    if new or moments:
        # at one and the same condition, so that what else is asked for does not change what is drawn
        first = model.controller.operating_points[0]
        leading = next((each for each in projections if each.condition == first), projections[0])
        trials = _Trials(model, sources, assumptions, leading, draws, seed)
        new_units, new_totals = trials.carry(new, moments, limits, coverage)
        units |= new_units
        totals |= new_totals
    known.keep(units, totals)
    return Propagated(
        [tuple(units[each.condition].lands[number] for each in projections) for number in range(len(sources))],
        [units[each.condition].total for each in projections],
        [totals[each.condition] for each in instants],
    )


class _Trials:
    """The draws of all that conditions share: one trial is one unit, whatever it is asked for."""

    def __init__(
        self,
        model: LeakageModel,
        sources: Sequence[LandSources],
        assumptions: Assumptions,
        leading: Projection,
        draws: int,
        seed: int,
    ) -> None:
        """Draw what all lands share; the land that leaks most at the ``leading`` condition is drawn most evenly."""
        self._model, self._sources, self._assumptions = model, sources, assumptions
        shared = Draws(Cube(draws, seed, 0))
        self._deviates = deviates_of_factors(shared)
        common = common_errors(shared, sources)
        fraction = one_sided_fraction(shared, model, assumptions)
        drawn = Condition(model, leading, assumptions).at(self._deviates)
        own = Beside(Cube(draws, seed, 3), drawn.score(leakiest(sources, leading), common, fraction))
        positions = Positions(model, own, seed)
        self._spread_of_positions = positions.relative_spread
        # circuits need all lands at once; without any, one land's draws make room for the next one's
        self._lands: Iterable[LandDraws] = (
            land_draws(own.draws(seed, 1, number), land, common, fraction, assumptions, positions.of(land))
            for number, land in enumerate(sources)
        )
        self._at_once: Sequence[LandDraws] = ()
        if model.controller.circuits:
            self._lands = self._at_once = list(self._lands)

    def carry(
        self, projections: Sequence[Projection], instants: Sequence[Projection], limits: Limits, coverage: float
    ) -> tuple[dict[OperatingPoint, UnitSpread], dict[OperatingPoint, InstantSpread]]:
        """Return how the lands and the total spread at each condition, and the total at each of the instants."""
        units = {each.condition: self._unit(each, limits, coverage) for each in projections}
        totals = {each.condition: self._total(each) for each in instants}
        for land in self._lands:
            for unit in units.values():
                unit.add(land)
            for total in totals.values():
                total.add(land)
        return (
            {at: UnitSpread(tuple(unit.spreads), unit.total()) for at, unit in units.items()},
            {
                at: InstantSpread(interval_of(total.drawn, coverage), interval_of(total.share, coverage))
                for at, total in totals.items()
            },
        )

    def _unit(self, projection: Projection, limits: Limits, coverage: float) -> _Unit:
        condition = Condition(self._model, projection, self._assumptions)
        linear = Linear(condition, self._sources, self._assumptions, self._spread_of_positions)
        drawn = condition.at(self._deviates)
        return _Unit(self._model, projection, drawn, linear, self._at_once, limits, coverage)

    def _total(self, instant: Projection) -> _Total:
        drawn = Condition(self._model, instant, self._assumptions).at(self._deviates)
        return _Total(_NOW, drawn.with_circuits(map(_NOW, self._at_once)))


class _Total:
    """What a unit draws at one condition in one state: its lands are added one by one."""

    def __init__(self, state: Callable[[LandDraws], LandInState], solved: tuple[Drawn, Network, Balance]) -> None:
        """Start without any land; ``state`` picks a land's bore, with which the circuits are solved."""
        self._state = state
        self.solved, self.network, self.balance = solved
        self.drawn = np.zeros(self.solved.viscosity.shape) + self.network.beside_lands(self.balance)  # [m³/s]

    def add(self, land: LandDraws) -> tuple[np.ndarray, np.ndarray]:
        """Count a land; return its flow, and the part of it that is drawn from the pump [m³/s]."""
        flow, drawn = self.solved.leakage(*self._state(land))
        self.drawn += drawn
        return flow, drawn

    def count(self, drawn: np.ndarray) -> np.ndarray:
        """Count a land of which it is known already what it draws [m³/s]."""
        self.drawn += drawn
        return drawn

    @property
    def share(self) -> np.ndarray:
        """Return it as a share of the pump's flow."""
        return flow_ratio(self.drawn, self.solved.capacity)


class _Unit:
    """A unit at one condition: as it is, new, and as it may have been when new."""

    def __init__(
        self,
        model: LeakageModel,
        projection: Projection,
        drawn: Drawn,
        linear: Linear,
        at_once: Sequence[LandDraws],
        limits: Limits,
        coverage: float,
    ) -> None:
        self._model, self._projection, self._given = model, projection, drawn
        self._linear, self._limits, self._coverage = linear, limits, coverage
        self._slopes = iter(linear.lands)
        now, new = (drawn.with_circuits(map(state, at_once)) for state in (_NOW, _NEW))
        same = all(each.unworn_bore is each.new_bore for each in at_once)
        unworn = new if same else drawn.with_circuits(map(_UNWORN, at_once))
        self._now, self._new, self._unworn = _Total(_NOW, now), _Total(_NEW, new), _Total(_UNWORN, unworn)
        # at the same pressures a land draws the same with the same bore
        self._new_as_now, self._unworn_as_new = new[0] is now[0], unworn[0] is new[0]
        self.spreads: list[LandSpread] = []  # of the lands added so far

    def add(self, each: LandDraws) -> None:
        """Count a land, and work out its spread."""
        flow, drawn = self._now.add(each)
        as_new = self._new_as_now and each.bore is each.new_bore
        new = self._new.count(drawn) if as_new else self._new.add(each)[1]
        as_unworn = self._unworn_as_new and each.unworn_bore is each.new_bore
        unworn = self._unworn.count(new) if as_unworn else self._unworn.add(each)[1]
        capacity = self._now.solved.capacity
        shares = flow_ratio(drawn, capacity), flow_ratio(unworn, capacity)
        self.spreads.append(
            LandSpread(
                slopes=next(self._slopes),
                leakage_spread=spread_of(flow, (), self._coverage),
                share_spread=_share_spread(*shares, self._limits.pair_share, self._coverage),
            )
        )

    def total(self) -> TotalSpread:
        """Return the spread of the whole, once every land is counted."""
        given, now, coverage = self._given, self._now, self._coverage
        measured, unworn = (
            DrawnUnit(each.network, each.balance, each.drawn, given.pressures, pump, given.viscosity)
            for each, pump in ((now, given.pump), (self._unworn, given.new_pump))
        )
        unworn_share = flow_ratio(self._unworn.drawn, now.solved.capacity)
        share_spread = _share_spread(now.share, unworn_share, self._limits.total_share, coverage)
        # a band counts as reached where a worse one is
        over = (1.0, *np.maximum.accumulate(share_spread.probabilities[::-1])[::-1].tolist(), 0.0)
        main = now.solved.pressures["p_g"]
        speed = given.pump.minimum_speed(now.drawn + consumed(now.network, main, main), main, given.viscosity)
        return TotalSpread(
            leakage_spread=spread_of(now.drawn, (), coverage),
            share_spread=share_spread,
            minimum_speed_interval=interval_of(speed, coverage),
            band_probabilities=tuple(max(a - b, 0.0) for a, b in pairwise(over)),
            new_leakage_interval=interval_of(self._new.drawn, coverage),
            growth_interval=interval_of(flow_ratio(now.drawn, self._new.drawn) - 1.0, coverage),
            pressures=pressure_spread(self._projection, self._model, measured, unworn, self._limits, coverage),
            effects=self._linear.total_effects(),
        )


# --- what the draws say


def _share_spread(share: np.ndarray, unworn: np.ndarray, steps: Steps | None, coverage: float) -> Spread:
    """Return the spread of a share, and how likely it has reached each limit beside that of an unworn land or unit."""
    return spread_of(share, [limit for _, limit in steps.over(unworn)] if steps else (), coverage)
