"""Carry uncertain clearances, fluid, pressures and pump into the spread of every flow and of the total.

This is the Monte Carlo method of JCGM 101. An error that lands share is drawn once per trial and used for all of them.
What a share has grown by is judged against the same unit unworn in the same trial: with the same fluid, pressures, pump
and contact lengths, and with mounting clearances drawn from what is known of them. Where only a range or a type's value
is known, a land is unworn as far as its reading may be that of a new pair.

A bore wears to one side, which two-point diameters cannot see: one fraction of all wear and one shape are drawn once
per trial for the whole unit, with a phase of its own for each land; a bore measured in four directions shows its own.
Where nobody knows how the spools lie, e/c is drawn for each component, the same for its lands now and new. The
circuits' pressures are solved in every trial: a land that leaks more in it finds less pressure before it.

The linear budget of every land and of the total changes one factor at a time, by central differences, with the
circuits' pressures as they are with the unit as measured.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.catalogue.limits import Limits, Steps
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.drawn_unit import (
    FACTORS,
    Drawn,
    DrawnLands,
    PressureSpread,
    deviates_of_factors,
    leakiest,
    pressure_spread,
)
from atleak.diagnosis.uncertainty.draws import (
    Beside,
    Cube,
    DrawnSpread,
    Draws,
    Interval,
    flow_ratio,
    interval_of,
    spread_of,
)
from atleak.diagnosis.uncertainty.land_draws import LandInState, Positions, common_errors, land_draws
from atleak.diagnosis.uncertainty.one_sided_wear import (
    EXPONENTS,
    SIDES,
    Bore,
    chances_of_sides,
    one_sided_wear,
    with_one_side,
)
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import consumed
from atleak.engine.projection import Projection
from atleak.equations.clearance import one_sided_moments

ONE_SIDE, POSITION = "wear to one side", "where the spool lies"  # names in the budgets

_SMALL = 0.01  # step of the derivatives, as a fraction of a standard uncertainty
#: Two columns per factor, one for each of `SIDES`, two of the clearance, two of the contact length, one as it is.
_COLUMNS = 2 * len(FACTORS) + len(SIDES) + 5
_ASIDE, _WIDER, _LONGER = slice(2 * len(FACTORS), -5), -5, -3  # the column after the last two is the other way


@dataclass(frozen=True)
class LandSlopes:
    """The leakage of one land at one condition, and how its share follows what is uncertain."""

    leakage: float  # [m³/s] at the values as measured
    share_per_clearance: float  # [1/m]
    share_effects: dict[str, float]  # change of the share for one standard uncertainty


class Linear:
    """The lands of a unit at one condition as measured, with one thing changed in each column."""

    def __init__(
        self,
        model: LeakageModel,
        projection: Projection,
        sources: Sequence[LandSources],
        assumptions: Assumptions,
        position: float,
    ) -> None:
        """Evaluate them; ``position`` is the relative standard deviation of a flow by where the spool lies."""
        self._sources, self._position = sources, position
        self._chances = chances_of_sides(sources, assumptions.one_sided_wear, assumptions)
        self._probe = Drawn(model, projection, assumptions, _deviates())
        lands = DrawnLands(self._probe, map(_as_measured, sources))
        self._beside = lands.leakage
        self._steps = np.array([_SMALL * (land.standard_uncertainty or 1e-7) for land in sources])
        bore, lengths = self._changed(assumptions)
        self._flow, self._drawn = lands.flows(sources, bore, lengths)

    def _changed(self, assumptions: Assumptions) -> tuple[Bore, np.ndarray]:
        """Return bores and contact lengths [m], shapes (lands, columns)."""
        lands, shape = [source.state for source in self._sources], (len(self._sources), _COLUMNS)
        rows = np.array(
            [
                (each.radial_clearance, *each.form_moments, each.land.contact_length, uncertain)
                for each in lands
                for uncertain in [assumptions.of_contact_length(measured=each.land.contact_length_measured)]
            ]
        ).reshape(-1, 5)
        clearance, square, cube, length = (np.broadcast_to(row[:, None], shape).copy() for row in rows.T[:4])
        for at, sign in ((_WIDER, 1.0), (_WIDER + 1, -1.0)):
            clearance[:, at] += sign * self._steps
        for at, sign in ((_LONGER, 1.0), (_LONGER + 1, -1.0)):
            length[:, at] += sign * _SMALL * rows[:, 4]
        if self._probe.model.law.counts_form:
            worn = np.array(["sleeve" in source.plans for source in self._sources])
            new = np.array([each.land.new_clearance for each in lands])
            most = assumptions.one_sided_wear
            shown = np.where(worn, np.maximum(rows[:, 0] - new, 0.0), 0.0)
            sides = [
                with_one_side(one_sided_moments(part * most * shown, EXPONENTS[place]), rows[:, 1], rows[:, 2])
                for part, place, _ in SIDES
            ]
            square[:, _ASIDE], cube[:, _ASIDE] = (np.stack(each, axis=1) for each in zip(*sides, strict=True))
        return Bore(clearance, square, cube), length

    @cached_property
    def lands(self) -> tuple[LandSlopes, ...]:
        """Return the slopes of every land."""
        share = self._share(self._drawn)
        effects = self._effects(share)
        names, values = [*effects], np.array(list(effects.values())).T.tolist()
        per_clearance = (_difference(share, _WIDER) / self._steps).tolist()
        each = zip(self._flow[:, -1].tolist(), per_clearance, values, strict=True)
        return tuple(LandSlopes(flow, slope, dict(zip(names, of, strict=True))) for flow, slope, of in each)

    def _share(self, drawn: np.ndarray) -> np.ndarray:
        return flow_ratio(drawn, np.broadcast_to(self._probe.capacity, drawn.shape))

    def total_effects(self) -> dict[str, float]:
        """Return the change of the total's share for one standard uncertainty of each source."""
        total = self._beside + sum(self._drawn)  # in the order of the lands
        share = self._share(total[None])
        capacity = float(np.broadcast_to(self._probe.capacity, _COLUMNS)[-1])
        per_flow = 1.0 / capacity if capacity > 0.0 else math.nan
        slopes = (_difference(self._drawn, _WIDER) / self._steps).tolist()
        lengths = (_difference(self._drawn, _LONGER) / _SMALL).tolist()
        own = 0.0  # variance from errors that no land shares
        shared: dict[str, float] = defaultdict(float)
        components: dict[str, float] = defaultdict(float)  # drawn, as measured
        for land, slope, by_length, flow in zip(
            self._sources, slopes, lengths, self._drawn[:, -1].tolist(), strict=True
        ):
            own += slope**2 * land.own_variance + by_length**2
            components[land.key[0]] += flow
            for name, u in land.groups.items():
                shared[name] += slope * u
        effects = {name: float(values[0]) for name, values in _of_factors(share).items()}
        effects["each land's own readings and contact length"] = math.sqrt(own) * per_flow
        effects[ONE_SIDE] = float(self._one_side_effect(share)[0])
        effects[POSITION] = self._position * math.hypot(*components.values()) * per_flow
        return effects | {f"common to all lands: {name}": slope * per_flow for name, slope in shared.items()}

    def _effects(self, values: np.ndarray) -> dict[str, np.ndarray]:
        with np.errstate(invalid="ignore"):  # a share is infinite where the pump delivers nothing
            by_position = self._position * values[:, -1]
        return _of_factors(values) | {
            "contact length": _difference(values, _LONGER) / _SMALL,
            ONE_SIDE: self._one_side_effect(values),
            POSITION: by_position,
        }

    def _one_side_effect(self, values: np.ndarray) -> np.ndarray:
        """Return the standard deviation over `SIDES`, as likely as they are in this unit."""
        sides = values[:, _ASIDE]
        finite = np.isfinite(sides).all(axis=1)
        sides = np.where(finite[:, None], sides, 0.0)
        off = sides - (sides @ self._chances)[:, None]
        return np.where(finite, np.sqrt(off**2 @ self._chances), math.nan)


def _deviates() -> dict[str, np.ndarray]:
    deviates = {}
    for number, name in enumerate(FACTORS):
        column = np.zeros(_COLUMNS)
        column[2 * number], column[2 * number + 1] = _SMALL, -_SMALL
        deviates[name] = column
    return deviates


def _as_measured(land: LandSources) -> LandInState:
    """Return a land as its readings have it."""
    state = land.state
    return land, Bore(state.radial_clearance, *state.form_moments), state.land.contact_length, None


def _of_factors(values: np.ndarray) -> dict[str, np.ndarray]:
    return {name: _difference(values, 2 * number) / _SMALL for number, name in enumerate(FACTORS)}


def _difference(values: np.ndarray, column: int) -> np.ndarray:
    first, second = values[:, column], values[:, column + 1]
    finite = np.isfinite(first) & np.isfinite(second)
    return np.where(finite, 0.5 * (np.where(finite, first, 0.0) - np.where(finite, second, 0.0)), math.nan)


SEED = 7667
DRAWS = 8_192
DRAWS_OF_CIRCUITS = 4_096  # of a unit with circuits, whose pressures are solved anew in every one


@dataclass(frozen=True)
class LandSpread:
    """The spread of the leakage of one land at one condition, and its slopes for the linear budget."""

    slopes: LandSlopes
    leakage_spread: DrawnSpread
    share_spread: DrawnSpread


@dataclass(frozen=True)
class TotalSpread:
    """The leakage of the whole controller at one condition, and its spread."""

    leakage_spread: DrawnSpread
    share_spread: DrawnSpread
    minimum_speed_interval: Interval  # [1/s]
    band_probabilities: tuple[float, ...]  # below the first limit, between, above the last
    new_leakage_interval: Interval  # [m³/s] of the same unit new
    growth_interval: Interval  # of the leakage over that of the same unit new
    pressures: PressureSpread
    effects: dict[str, float]  # change of the share for one standard uncertainty of each source


@dataclass(frozen=True)
class UnitSpread:
    """The spread of every land, in the order of the controller, and of the total at one condition."""

    lands: tuple[LandSpread, ...]
    total: TotalSpread


InstantSpread = tuple[Interval, Interval]  # of the whole controller's leakage [m³/s] and share at an instant of a log
SpreadCache = dict[Any, Any]  # what was carried through for one unit already, by condition; the latest at the end
MOST_KEPT = 64


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
    cache: SpreadCache | None = None,
) -> tuple[list[UnitSpread], list[InstantSpread]]:
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
    cache
        what was carried through before, of the same unit with the same of all that stands above but the conditions:
        only what is new is computed, and added to it.

    Returns
    -------
    tuple
        the spread of the unit at each of the projections, and the intervals at each of the instants.

    Raises
    ------
    DomainError
        A condition's temperature outside the fluid's data.
    """

    def key(which: str, at: Projection) -> Any:
        return which, at.condition, coverage, draws, seed

    asked = {key("unit", each): each for each in projections} | {key("instant", each): each for each in instants}
    cache = {} if cache is None else cache
    spreads = {each: before for each in asked if (before := cache.get(each)) is not None}
    if len(spreads) < len(asked):
        # at one and the same condition, so that what else is asked for does not change what is drawn
        first = model.controller.operating_points[0]
        leading = next((each for each in projections if each.condition == first), projections[0])
        trials = _Trials(model, sources, assumptions, leading, draws, seed)
        for each, projection in asked.items():
            if each not in spreads:
                spreads[each] = (
                    trials.unit(projection, limits, coverage)
                    if each[0] == "unit"
                    else trials.instant(projection, coverage)
                )
    for each in asked:
        cache.pop(each, None)
        cache[each] = spreads[each]
    for each in list(cache)[:-MOST_KEPT]:  # another thread may take out the same
        cache.pop(each, None)
    return [spreads[key("unit", each)] for each in projections], [spreads[key("instant", each)] for each in instants]


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
        """Draw all lands; the one that leaks most at the ``leading`` condition is drawn most evenly."""
        self._model, self._sources, self._assumptions = model, sources, assumptions
        shared = Draws(Cube(draws, seed, 0))
        self._deviates = deviates_of_factors(shared)
        common = common_errors(shared, sources)
        one_sided = one_sided_wear(shared, model, assumptions, sources)
        score = self._at(leading).score(leakiest(sources, leading), common, one_sided)
        own = Beside(Cube(draws, seed, 3), score)
        positions = Positions(model, own, seed)
        self._spread_of_positions = positions.relative_spread
        self._lands = [
            land_draws(own.draws(seed, 1, number), land, common, one_sided, assumptions, positions.of(land))
            for number, land in enumerate(sources)
        ]

    def _at(self, projection: Projection) -> Drawn:
        return Drawn(self._model, projection, self._assumptions, self._deviates)

    def instant(self, projection: Projection, coverage: float) -> InstantSpread:
        """Return the intervals of the total at an instant."""
        lands = DrawnLands(self._at(projection), (each.now for each in self._lands))
        for land in self._lands:
            lands.count(*land.now)
        return interval_of(lands.leakage, coverage), interval_of(lands.share, coverage)

    def unit(self, projection: Projection, limits: Limits, coverage: float) -> UnitSpread:
        """Return how the lands and the total spread at one condition, beside the unit new and unworn."""
        given, every = self._at(projection), self._lands
        linear = Linear(self._model, projection, self._sources, self._assumptions, self._spread_of_positions)
        now = DrawnLands(given, (each.now for each in every))
        new = DrawnLands(given, (each.new for each in every))
        same_bores = all(each.unworn_bore is each.new_bore for each in every)
        unworn = new.copy() if same_bores else DrawnLands(given, (each.unworn for each in every))
        # at the same pressures a land draws the same with the same bore
        same_pressures = not now.network.has_circuits
        spreads = []
        for land, slopes in zip(every, linear.lands, strict=True):
            flow, drawn = now.count(*land.now)
            as_new = drawn if same_pressures and land.bore is land.new_bore else new.flow(*land.new)[1]
            same_flow = (same_pressures or same_bores) and land.unworn_bore is land.new_bore
            as_unworn = as_new if same_flow else unworn.flow(*land.unworn)[1]
            new.leakage += as_new
            unworn.leakage += as_unworn
            shares = flow_ratio(drawn, given.capacity), flow_ratio(as_unworn, given.capacity)
            share = _share_spread(*shares, limits.pair_share, coverage)
            spreads.append(LandSpread(slopes, spread_of(flow, (), coverage), share))
        return UnitSpread(tuple(spreads), self._total(projection, (now, new, unworn), linear, limits, coverage))

    def _total(
        self,
        projection: Projection,
        states: tuple[DrawnLands, DrawnLands, DrawnLands],
        linear: Linear,
        limits: Limits,
        coverage: float,
    ) -> TotalSpread:
        """Return the spread of the whole, every land counted as it is, new and unworn."""
        now, new, unworn = states
        given, main = now.given, now.given.pressures["p_g"]
        share_spread = _share_spread(
            now.share, flow_ratio(unworn.leakage, given.capacity), limits.total_share, coverage
        )
        # a band counts as reached where a worse one is
        over = (1.0, *np.maximum.accumulate(share_spread.probabilities[::-1])[::-1].tolist(), 0.0)
        speed = given.pump.minimum_speed(now.leakage + consumed(now.network, main, main), main, given.viscosity)
        units = now.unit(), unworn.unit(given.new_pump)
        return TotalSpread(
            leakage_spread=spread_of(now.leakage, (), coverage),
            share_spread=share_spread,
            minimum_speed_interval=interval_of(speed, coverage),
            band_probabilities=tuple(max(a - b, 0.0) for a, b in pairwise(over)),
            new_leakage_interval=interval_of(new.leakage, coverage),
            growth_interval=interval_of(flow_ratio(now.leakage, new.leakage) - 1.0, coverage),
            pressures=pressure_spread(projection, self._model, *units, limits, coverage),
            effects=linear.total_effects(),
        )


# --- what the draws say


def _share_spread(share: np.ndarray, unworn: np.ndarray, steps: Steps | None, coverage: float) -> DrawnSpread:
    """Return the spread of a share, and how likely it has reached each limit beside that of an unworn land or unit."""
    return spread_of(share, [limit for _, limit in steps.over(unworn)] if steps else (), coverage)
