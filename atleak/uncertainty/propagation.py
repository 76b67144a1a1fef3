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

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.catalogue.limits import Limits, Steps
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import consumed
from atleak.engine.projection import Projection
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.drawn import Drawn, DrawnLands, leakiest
from atleak.uncertainty.draws import (
    Positions,
    common_errors,
    deviates_of_factors,
    land_draws,
    one_sided_fraction,
)
from atleak.uncertainty.linear import LandSlopes, Linear
from atleak.uncertainty.points import Beside, Cube, Draws
from atleak.uncertainty.pressures import PressureSpread, pressure_spread
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import Interval, Spread, flow_ratio, interval_of, spread_of

SEED = 7667
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
Known = dict[Any, Any]  # what was carried through for one unit already, by condition; the latest at the end
MOST_KNOWN = 64


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
    known
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

    def key(which: str, each: Projection) -> Any:
        return which, each.condition, coverage, draws, seed

    asked = {key("unit", each): each for each in projections} | {key("instant", each): each for each in instants}
    known = {} if known is None else known
    found = {each: before for each in asked if (before := known.get(each)) is not None}
    if len(found) < len(asked):
        # at one and the same condition, so that what else is asked for does not change what is drawn
        first = model.controller.operating_points[0]
        leading = next((each for each in projections if each.condition == first), projections[0])
        trials = _Trials(model, sources, assumptions, leading, draws, seed)
        for each, projection in asked.items():
            if each not in found:
                found[each] = (
                    trials.unit(projection, limits, coverage)
                    if each[0] == "unit"
                    else trials.instant(projection, coverage)
                )
    for each in asked:
        known.pop(each, None)
        known[each] = found[each]
    for each in list(known)[:-MOST_KNOWN]:  # another thread may take out the same
        known.pop(each, None)
    return [found[key("unit", each)] for each in projections], [found[key("instant", each)] for each in instants]


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
        fraction = one_sided_fraction(shared, model, assumptions)
        score = self._at(leading).score(leakiest(sources, leading), common, fraction)
        own = Beside(Cube(draws, seed, 3), score)
        positions = Positions(model, own, seed)
        self._spread_of_positions = positions.relative_spread
        self._lands = [
            land_draws(own.draws(seed, 1, number), land, common, fraction, assumptions, positions.of(land))
            for number, land in enumerate(sources)
        ]

    def _at(self, projection: Projection) -> Drawn:
        return Drawn(self._model, projection, self._assumptions, self._deviates)

    def instant(self, projection: Projection, coverage: float) -> InstantSpread:
        """Return the intervals of the total at an instant."""
        lands = DrawnLands(self._at(projection), (each.now for each in self._lands))
        for each in self._lands:
            lands.count(*each.now)
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
        for each, slopes in zip(every, linear.lands, strict=True):
            flow, drawn = now.count(*each.now)
            as_new = drawn if same_pressures and each.bore is each.new_bore else new.flow(*each.new)[1]
            known = (same_pressures or same_bores) and each.unworn_bore is each.new_bore
            as_unworn = as_new if known else unworn.flow(*each.unworn)[1]
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


def _share_spread(share: np.ndarray, unworn: np.ndarray, steps: Steps | None, coverage: float) -> Spread:
    """Return the spread of a share, and how likely it has reached each limit beside that of an unworn land or unit."""
    return spread_of(share, [limit for _, limit in steps.over(unworn)] if steps else (), coverage)
