"""Wear to one side of a bore: how much of it there may be, what directions tell of it, and what it makes of a bore."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from atleak.common.memory import kept_with
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.draws import Draws
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.diagnosis.uncertainty.wear import UnitWear, new_before
from atleak.engine.leakage import LeakageModel
from atleak.equations.clearance import one_sided_moments, seen_of_one_sided

#: The n of the shapes w₀ max(cos θ, 0)^n that wear to one side is taken to have, alike likely: choice of this project.
EXPONENTS = 1.0, 2.0, 3.0
_EVEN_ROUND = 0.2  # part of a two-lobe form that directions around the bore leave in their mean at most
_FITTED_FROM = 4  # directions in every plane show the shape of a bore
_PHASES, _WEARS = np.pi * np.arange(36) / 36.0, np.arange(27) / 24.0  # of the grid on which it is fitted
_AROUND = np.stack([np.maximum(np.cos(np.pi * np.arange(90) / 45.0), 0.0) ** n for n in EXPONENTS])
_PROFILES = _AROUND / _AROUND.mean(axis=1, keepdims=True) - 1.0  # of the wear around the bore, past its mean
_FINEST, _ANY_MEAN = 1e-7, 1e-4  # [m] that directions differ at least by chance, and as far as their mean may be off
#: Of all wear to one side: which part, with which n of `EXPONENTS`, and how likely before anything is measured. Choice
#: of this project: nothing, half and all of it alike likely, and so are the three shapes.
SIDES = tuple((part, place, 1.0 / (3 * len(EXPONENTS))) for part in (0.0, 0.5, 1.0) for place in range(len(EXPONENTS)))
_PARTS, _PLACES, _CHANCES = map(np.array, zip(*SIDES, strict=True))
_EVEN = (_PARTS == 0.0) / len(EXPONENTS)
_OF_ONE = np.array([one_sided_moments(1.0, n) for n in EXPONENTS])  # moments of a mean wear of 1 m
#: How far the differences between directions count. Lands may be worn to one side by parts of their own, so that they
#: tell less of what they have in common than if each were drawn anew. Choice of this project.
_EACH_LAND_COUNTS = 0.5
#: Chance that wear is even, whatever directions differ by: for they may differ by the form of new bores.
_LEAST_EVEN = 0.1
_OVALITIES = 1.0, 2.0, 4.0  # times the assumed one, that new bores may have
#: Part of the wear to one side that the directions of a sheet show at least. Two directions at a right angle never show
#: less than π/4. One alone, laid across the worn side, shows nothing of it, which no interval can bound: the clearance
#: is then called a lower bound, and up to twice the wear that shows is reckoned with. Choice of this project.
_LEAST_SEEN = 0.5


@dataclass(frozen=True)
class Bore:
    """The clearance of a land as drawn: its mean around the circumference, and how it spreads there."""

    clearance: Any  # [m] radial, cold
    square: Any = 0.0  # [m²] second central moment over the circumference
    cube: Any = 0.0  # [m³] third
    entry_loss: Any = 1.0  # over that of the even gap of the same mean cube


@dataclass(frozen=True)
class OneSided:
    """Wear to one side as drawn for a unit: one part of all wear, of one shape; arrays of shape (draws,)."""

    most: float  # the largest part that it may be
    fraction: np.ndarray  # of all wear
    place: np.ndarray  # of the shape among `EXPONENTS`
    usual: tuple[float, float]  # which part of the unit's lands is worn, and how far on average [m]

    @cached_property
    def _moments(self) -> np.ndarray:
        return _OF_ONE.T.take(self.place, axis=1)

    def moments(self, wear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return second [m²] and third [m³] central moment of the clearance where the mean of wear to one side is so.

        They are those of `one_sided_moments`, looked up: the same factors for all lands.
        """
        squared, (square, cube) = wear * wear, self._moments
        return square * squared, cube * (squared * wear)


def one_sided_wear(
    stream: Draws, model: LeakageModel, assumptions: Assumptions, lands: Sequence[LandSources]
) -> OneSided:
    """Draw how much of all wear lies to one side of the bores; the cube of the mean clearance knows no sides."""
    most = assumptions.one_sided_wear if model.law.counts_form else 0.0
    chances = chances_of_sides(lands, most, assumptions)
    side = np.searchsorted(np.cumsum(chances)[:-1], stream.uniform())
    return OneSided(most, most * _PARTS.take(side), _PLACES.take(side), UnitWear(lands, assumptions).usual)


def chances_of_sides(lands: Sequence[LandSources], most: float, assumptions: Assumptions) -> np.ndarray:
    """Return how likely each of `SIDES` is in a unit whose directions differ as much as they do.

    Parameters
    ----------
    lands
        of which those count whose bores were measured in several directions.
    most
        the largest part of all wear that may lie to one side.

    Notes
    -----
    What directions differ by is taken as χ² of one degree of freedom in each land, about what its wear, readings and
    the ovality of new bores make of it at any phase. Directions that read alike in every land were copied.
    """
    rows = [
        (land.state.form_moments[0], max(land.state.radial_clearance - land.state.land.new_clearance, 0.0), u, v)
        for land in lands
        if land.sees_sides
        for u, v in [(math.hypot(land.standard_uncertainty, land.u_mounting), 0.5 * land.direction_variance)]
    ]
    if not any(row[0] for row in rows):
        return _CHANCES
    differ, wear, u, read = np.array(rows).T
    wear = np.maximum(wear**2 - u**2, 0.0)
    shown = 0.5 * (_OF_ONE[_PLACES, 0] - 1.0) * (most * _PARTS) ** 2  # the variance of half of |cos|^n, over its mean²
    oval = assumptions.unseen_ovality**2 / 32.0 * np.square(_OVALITIES)
    expected = shown[:, None, None] * wear + oval[:, None] + read + _FINEST**2  # shape (sides, ovalities, lands)
    log = -0.5 * _EACH_LAND_COUNTS * (np.log(expected) + differ / expected).sum(axis=2)
    chances = _CHANCES * np.exp(log - log.max()).sum(axis=1)
    chances /= chances.sum()
    lacking = max(_LEAST_EVEN - chances[_PARTS == 0.0].sum(), 0.0)
    return np.asarray((1.0 - lacking) * chances + lacking * _EVEN)


@dataclass(frozen=True)
class FittedSide:
    """What a bore's own directions tell of its wear to one side: what that may be, and how likely; shapes (cells,)."""

    cumulative: np.ndarray  # probability of the cells up to each
    wear: np.ndarray  # [m] mean around the circumference
    seen: np.ndarray  # of it, in the mean diameter
    moments: tuple[np.ndarray, np.ndarray]  # second [m²] and third [m³] central moment of the clearance
    entry_loss: np.ndarray  # over that of the even gap of the same mean cube: where a gap is wide it is quick


def fitted_side(land: LandSources) -> FittedSide | None:
    """Return what four or more directions tell of wear to one side; None where they are fewer, or nothing is worn.

    Every amount up to all that is worn, every side and each of `EXPONENTS` is alike likely but for how well it
    agrees with the differences between the directions, beside a two-lobe form as it was when new.
    """
    return kept_with(land, "fitted_side", "", partial(_fitted, land), most=1)


def _fitted(land: LandSources) -> FittedSide | None:
    plan, new = land.plans.get("sleeve"), land.state.land.mounting_range[0]
    most = land.assumptions.one_sided_wear * max(land.state.radial_clearance - new, 0.0)
    if plan is None or plan.residual * _FITTED_FROM > 2.0 or plan.two_lobe > _EVEN_ROUND or not most:
        return None
    planes: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for station in land.state.stations:
        planes[station.plane].append((math.radians(station.direction or 0.0), station.radial_clearance))
    found: dict[float, list[float]] = defaultdict(list)
    for directions in planes.values():
        mean = math.fsum(clearance for _, clearance in directions) / len(directions)
        for angle, clearance in directions:
            found[angle].append(clearance - mean)
    angles, differ = np.array([*found]), np.array([np.mean(each) for each in found.values()])
    new_form = land.assumptions.unseen_ovality**2 / 32.0 * np.cos(2.0 * (angles[:, None] - angles))
    noise = np.eye(angles.size) * (land.direction_variance / len(planes) + _FINEST**2)
    weights = np.linalg.inv(new_form + noise + _ANY_MEAN**2)
    shapes = [seen_of_one_sided(angles[:, None] - _PHASES, n) for n in EXPONENTS]
    shows = np.stack([each - each.mean(axis=0) for each in shapes])
    wear = most * _WEARS[:, None, None]
    log = wear * np.einsum("i,ij,njp->np", differ, weights, shows)
    log = log - 0.5 * wear**2 * np.einsum("nip,ij,njp->np", shows, weights, shows)
    square, cube = (of_one[:, None] * wear**power for power, of_one in enumerate(_OF_ONE.T, 2))
    seen = np.stack([_seen(plan.angles, _PHASES, n) for n in EXPONENTS])
    around = np.maximum(land.state.radial_clearance + wear * _PROFILES, 0.0)
    # small losses go as c⁴, and by them the flow as c⁷; where all is loss the flow goes as c: between the two
    loss = np.sqrt(np.mean(around**7, axis=2) / np.mean(around**3, axis=2) ** (5.0 / 3.0)) / around.mean(axis=2)
    cells = (wear, seen, square, cube, loss[:, :, None])
    wear, seen, square, cube, loss = (np.broadcast_to(each, log.shape).ravel() for each in cells)
    cumulative = np.cumsum(np.exp(log - log.max()))
    return FittedSide(cumulative / cumulative[-1], wear, seen, (square, cube), loss)


def worn_bore(stream: Draws, land: LandSources, clearance: np.ndarray, new: np.ndarray, one_sided: OneSided) -> Bore:
    """Draw the true mean clearance and its spread around the circumference, where part of the wear is to one side.

    Parameters
    ----------
    clearance, new
        the mean clearance that the diameters show, and that of the pair when new [m]; shape (draws,).
    one_sided
        the wear that lies to one side in the unit; a bore measured in four directions or more shows its own.

    Notes
    -----
    According to where its directions lie, a sheet shows more or less than the mean of wear to one side. The spread is
    never less than what the directions themselves show.
    """
    square, cube = land.state.form_moments
    plan, fraction = land.plans.get("sleeve"), one_sided.fraction
    if plan is None or not one_sided.most:  # of a bore that was not measured no wear is known
        return Bore(clearance, square, cube)
    fitted = fitted_side(land)
    if fitted is not None:
        cell = np.searchsorted(fitted.cumulative, stream.uniform())
        drawn = (fitted.wear, fitted.seen, fitted.entry_loss, *fitted.moments)
        wear, seen, loss, *of_wear = (each.take(cell) for each in drawn)
        return Bore(clearance + wear * (1.0 - seen), *with_one_side(of_wear, square, cube), loss)
    low, high = land.state.land.mounting_range
    if low < high:
        new = new_before(clearance, (low, high), one_sided.usual, stream.uniform())
    shown = np.maximum(clearance - new, 0.0)
    angles = tuple(plan.angles.items())
    seen = stream.among(
        ("seen of one side", angles),
        lambda part: np.stack([_seen(plan.angles, math.pi * part, n) for n in EXPONENTS], axis=1),
        one_sided.place,
    )
    wear = shown / np.maximum(1.0 - fraction + fraction * seen, _LEAST_SEEN)
    moments = one_sided.moments(fraction * wear)
    return Bore(clearance + (wear - shown), *with_one_side(moments, square, cube))


def with_one_side(one_sided: Sequence[Any], square: Any, cube: Any) -> tuple[Any, Any]:
    """Return the moments that wear to one side makes, or those measured where these are larger."""
    larger = one_sided[0] > square
    return np.where(larger, one_sided[0], square), np.where(larger, one_sided[1], cube)


def _seen(angles: Mapping[float, float], phase: Any, exponent: float) -> Any:
    """Return how much of the mean wear the two-point diameters show where a bore is worn to the side at ``phase``.

    The wear is w₀ max(cos θ, 0)^n, and ``exponent`` the n; ``angles`` [rad] have their weights in the mean diameter.
    """
    return sum(weight * seen_of_one_sided(angle - phase, exponent) for angle, weight in angles.items())
