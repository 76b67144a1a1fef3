"""Draw what is not known of a land and of a unit, and say how the draws of a quantity spread.

The draws are points that fill a cube evenly, which a fixed seed scrambles. Intervals from some thousands of them are as
steady as those from several times as many random draws (Owen, SIAM J. Numer. Anal. 34, 1997). The points are Sobol's,
each dimension one quantity; a digital shift and a random triangular matrix for each dimension scramble them, so that
every point alone is spread like a random one (Matoušek, J. Complexity 14, 1998). They have few dimensions, and a unit
has hundreds of quantities: those that belong together, of one land or of the whole unit, share a cube, and every land
goes through its cube in an order of its own (Latin supercube sampling: Owen, ACM Trans. Model. Comput. Simul. 8, 1998).
That order is random only among draws in which what all lands share is about the same (as in array-RQMC: L'Ecuyer, Lécot
& Tuffin, Oper. Res. 56, 2008), because a land's flow depends on both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.sources import (
    EXPONENTS,
    FINEST,
    MEASURING_TEMPERATURE_SOURCE,
    MOUNTING,
    LandSources,
)
from atleak.diagnosis.uncertainty.wear import UnitWear, new_before
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import UNKNOWN
from atleak.equations.clearance import one_sided_moments
from atleak.equations.gap import ECCENTRIC_GAIN, eccentricity_factor
from atleak.equations.statistics import normal_quantile

Interval = tuple[float, float]


@dataclass(frozen=True)
class DrawnSpread:
    """The standard uncertainty and the interval of one quantity, from its draws."""

    standard_uncertainty: float
    interval: Interval
    probabilities: tuple[float, ...]  # that the quantity has reached each of the limits
    level_uncertainties: tuple[float, ...]  # of the quantity over each limit, which may follow what was new


def spread_of(values: np.ndarray, limits: Sequence[Any], coverage: float, *, falling: bool = False) -> DrawnSpread:
    """Return how draws spread, shape (draws,); each limit is a number or has a value for each draw.

    ``falling`` limits are reached by what is under them.
    """
    reached = tuple(
        float(np.count_nonzero(values < limit if falling else values >= limit)) / values.size for limit in limits
    )
    u = _standard_deviation(values)
    finite = math.isfinite(u)
    return DrawnSpread(
        u,
        interval_of(values, coverage),
        reached,
        tuple(_standard_deviation(values - limit) if finite and np.ndim(limit) else u for limit in limits),
    )


def _standard_deviation(values: np.ndarray) -> float:
    """Return it; infinite where a value is no finite number. Several times as quick as NumPy's own."""
    mean = float(np.add.reduce(values)) / values.size
    if not math.isfinite(mean):
        return math.inf
    from_mean = values - mean
    variance = float(np.dot(from_mean, from_mean)) / values.size
    return math.sqrt(variance) if math.isfinite(variance) else math.inf


def interval_of(values: np.ndarray, coverage: float) -> tuple[float, float]:
    """Return the interval of draws that leaves out as much below as above."""
    probabilities = 0.5 - 0.5 * coverage, 0.5 + 0.5 * coverage
    places = [(values.size - 1) * p for p in probabilities]
    edges = [int(place) for place in places]
    ends = sorted({min(edge + step, values.size - 1) for edge in edges for step in (0, 1)})
    ordered = np.partition(values, ends)
    quantiles = []
    for place, edge in zip(places, edges, strict=True):
        low, high = float(ordered[edge]), float(ordered[min(edge + 1, values.size - 1)])
        quantiles.append(low if low == high else low + (place - edge) * (high - low))
    return quantiles[0], quantiles[1]


def flow_ratio(flow: np.ndarray, capacity: Any) -> np.ndarray:
    """Return the share of the pump's flow; infinite where the pump delivers nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = flow / capacity
    return share if np.all(capacity) else np.where(np.isnan(share), np.inf, share)


#: Of each dimension after the first: degree and coefficients of its polynomial, and the first direction numbers
#: (Joe & Kuo, SIAM J. Sci. Comput. 30, 2008, the set "new-joe-kuo-6").
_JOE_KUO: tuple[tuple[int, int, tuple[int, ...]], ...] = (
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
    (5, 4, (1, 1, 5, 5, 5)),
    (5, 7, (1, 1, 7, 11, 19)),
    (5, 11, (1, 1, 5, 1, 1)),
    (5, 13, (1, 1, 1, 3, 11)),
    (5, 14, (1, 3, 5, 5, 31)),
    (6, 1, (1, 3, 3, 9, 7, 49)),
    (6, 13, (1, 1, 1, 15, 21, 21)),
    (6, 16, (1, 3, 1, 13, 27, 49)),
)
DIMENSIONS = len(_JOE_KUO) + 1
_TOGETHER = 128  # draws of about the same score, a power of two


@lru_cache(maxsize=8)
def directions(bits: int) -> np.ndarray:
    """Return Sobol's direction numbers, shape (DIMENSIONS, bits), of points with so many binary digits."""
    numbers = np.empty((DIMENSIONS, bits), np.int64)
    numbers[0] = [1 << (bits - 1 - k) for k in range(bits)]
    for row, (degree, coefficients, first) in zip(numbers[1:], _JOE_KUO, strict=True):
        odd = list(first[:bits])
        for k in range(degree, bits):
            number = odd[k - degree] ^ (odd[k - degree] << degree)
            for j in range(1, degree):
                if coefficients >> (degree - 1 - j) & 1:
                    number ^= odd[k - j] << j
            odd.append(number)
        row[:] = [number << (bits - 1 - k) for k, number in enumerate(odd)]
    numbers.flags.writeable = False
    return numbers


def _scrambled(bits: int, stream: np.random.Generator) -> np.ndarray:
    """Return the scrambled points as whole numbers below 2^bits, shape (DIMENSIONS, 2^bits)."""
    plain = directions(bits)
    unit = 1 << np.arange(bits - 1, -1, -1)
    columns = unit + stream.integers(0, unit, size=(DIMENSIONS, bits))  # of a triangular matrix of each dimension
    digits = plain[:, :, None] & unit != 0
    turned = np.bitwise_xor.reduce(np.where(digits, columns[:, None, :], 0), axis=2).astype(np.uint32)
    points = np.empty((DIMENSIONS, 1 << bits), np.uint32)
    points[:, 0] = stream.integers(0, 1 << bits, size=DIMENSIONS)
    for k in range(bits):
        np.bitwise_xor(points[:, : 1 << k], turned[:, k, None], out=points[:, 1 << k : 2 << k])
    return points


@lru_cache(maxsize=8)
def _uniform(bits: int) -> np.ndarray:
    """Return the middles of 2^bits equal parts of 0 … 1."""
    return (np.arange(1 << bits) + 0.5) / (1 << bits)


@lru_cache(maxsize=8)
def _normal(bits: int) -> np.ndarray:
    """Return the normal quantiles of the same."""
    upper = normal_quantile(_uniform(bits)[1 << (bits - 1) :])
    return np.concatenate([-upper[::-1], upper])


class Cube:
    """Points of one cube, from whose dimensions quantities are drawn; ``draws`` is a power of two."""

    def __init__(self, draws: int, *seed: int) -> None:
        self.draws = draws
        self._bits = draws.bit_length() - 1
        self._points = _scrambled(self._bits, stream_of(*seed))
        self._kept: dict[Hashable, np.ndarray] = {}

    def ranks(self, dimension: int) -> np.ndarray:
        """Return the whole numbers below ``draws``, each once: the place of every point in a dimension."""
        return self._points[dimension]

    def values(self, dimension: int, name: Hashable, table: Callable[[int], np.ndarray]) -> np.ndarray:
        """Return a dimension's values, looked up by the points' ranks in a table; kept by name."""
        key = dimension, name
        if key not in self._kept:
            self._kept[key] = table(self._bits)[self._points[dimension]]
        return self._kept[key]


class Draws:
    """One quantity after the other, drawn from the dimensions of a cube; shape (draws,)."""

    def __init__(self, cube: Cube, order: np.ndarray | None = None, first: int = 0) -> None:
        """Go through a cube in an order, that of its points unless given, from a first dimension on."""
        self._cube, self._order, self._next = cube, order, first

    def onward_from(self, dimension: int) -> Draws:
        """Return the draws of the same points from another dimension on, whatever was drawn before it."""
        return Draws(self._cube, self._order, dimension)

    def _values(self, name: Hashable, table: Callable[[int], np.ndarray]) -> np.ndarray:
        values = self._cube.values(self._next, name, table)
        self._next += 1
        return values.copy() if self._order is None else values.take(self._order)

    def among(self, name: Hashable, functions: Callable[[np.ndarray], Any], which: np.ndarray) -> np.ndarray:
        """Draw one or another function of a number from 0 … 1.

        ``functions`` returns the values of each in a column, and ``which`` says the column that counts in each draw.
        """
        values = self._cube.values(self._next, name, lambda bits: functions(_uniform(bits)))
        self._next += 1
        order = np.arange(which.size) if self._order is None else self._order
        return values.ravel().take(order * values.shape[1] + which)

    def normal(self) -> np.ndarray:
        """Draw from the standard normal distribution."""
        return self._values("normal", _normal)

    def uniform(self) -> np.ndarray:
        """Draw from 0 … 1, any value alike likely."""
        return self._values("uniform", _uniform)

    def rectangular(self) -> np.ndarray:
        """Draw from a rectangular distribution of unit standard deviation about zero."""
        return self._values("rectangular", lambda bits: (_uniform(bits) - 0.5) * math.sqrt(12.0))

    def of_uniform(self, name: Hashable, function: Callable[[np.ndarray], Any]) -> np.ndarray:
        """Draw a function of a number from 0 … 1; a function of the same name is computed once for a cube."""
        return self._values(name, lambda bits: function(_uniform(bits)))


class Beside:
    """Draws of many, all from one cube and each in an order of its own, beside others that are drawn already.

    What is drawn already has a score in every draw. The first dimension of the cube stands for its rank, so that with
    any score the points spread evenly over the other dimensions; among some draws of about the same score each order
    is a random one.
    """

    def __init__(self, cube: Cube, score: np.ndarray) -> None:
        self._cube = cube
        self._by_score = np.argsort(score, kind="stable")
        together = min(_TOGETHER, cube.draws)
        self._points = np.argsort(cube.ranks(0)).reshape(-1, together)

    def draws(self, *seed: int) -> Draws:
        """Return the draws of one of them; independent of all others but for the score."""
        order = np.empty(self._cube.draws, np.intp)
        order[self._by_score] = stream_of(*seed).permuted(self._points, axis=1).ravel()
        return Draws(self._cube, order, first=1)


def rounded_up(draws: int) -> int:
    """Return the power of two that is a number of draws, or the next one."""
    return 1 << (draws - 1).bit_length()


def stream_of(*seed: int) -> np.random.Generator:
    """Return the random numbers of a seed: the same ones each time."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))


#: Part of the wear to one side that the directions of a sheet show at least. Two directions at a right angle never show
#: less than π/4. One alone, laid across the worn side, shows nothing of it, which no interval can bound: the clearance
#: is then called a lower bound, and up to twice the wear that shows is reckoned with. Choice of this project.
LEAST_SEEN = 0.5

NORMAL_FACTORS = ("viscosity", "temperature", "main pressure", "converter pressure", "pump efficiency")
FLUID_STATE = "range of the fluid's viscosity"  # rectangular: of one without data of its own used state, or assumed
FACTORS = (*NORMAL_FACTORS, FLUID_STATE)


_SHORTEST = 0.1  # fraction of the nominal contact length; shorter draws are raised to it


@dataclass(frozen=True)
class Bore:
    """The clearance of a land as drawn: its mean around the circumference, and how it spreads there."""

    clearance: Any  # [m] radial, cold
    square: Any = 0.0  # [m²] second central moment over the circumference
    cube: Any = 0.0  # [m³] third
    entry_loss: Any = 1.0  # over that of the even gap of the same mean cube


def deviates_of_factors(shared: Draws) -> dict[str, np.ndarray]:
    """Draw the standard deviates of `FACTORS`."""
    deviates = {name: shared.normal() for name in NORMAL_FACTORS}
    deviates[FLUID_STATE] = shared.rectangular()
    return deviates


def common_errors(stream: Draws, lands: Sequence[LandSources]) -> dict[str, np.ndarray]:
    """Draw the errors that lands share, by their groups, each of shape (draws,) and of unit standard deviation."""
    names = sorted({group for land in lands for group in land.groups})
    return {name: stream.rectangular() if name == MEASURING_TEMPERATURE_SOURCE else stream.normal() for name in names}


#: Of all wear to one side: which part, with which n of `EXPONENTS`, and how likely before anything is measured. Choice
#: of this project: nothing, half and all of it alike likely, and so are the three shapes.
SIDES = tuple((part, place, 1.0 / (3 * len(EXPONENTS))) for part in (0.0, 0.5, 1.0) for place in range(len(EXPONENTS)))
_PARTS, _PLACES, _CHANCES = map(np.array, zip(*SIDES, strict=True))
_EVEN = (_PARTS == 0.0) / len(EXPONENTS)
_OF_ONE = np.array([one_sided_moments(1.0, n) for n in EXPONENTS])  # moments of a mean wear of 1 m
#: How far the differences between directions count. Lands may be worn to one side by parts of their own, so that they
#: tell less of what they have in common than if each were drawn anew. Choice of this project.
_EACH_LAND_COUNTS = 0.5
LEAST_EVEN = (
    0.1  # chance that wear is even, whatever directions differ by: for they may differ by the form of new bores
)
_OVALITIES = 1.0, 2.0, 4.0  # times the assumed one, that new bores may have


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
    expected = shown[:, None, None] * wear + oval[:, None] + read + FINEST**2  # shape (sides, ovalities, lands)
    log = -0.5 * _EACH_LAND_COUNTS * (np.log(expected) + differ / expected).sum(axis=2)
    chances = _CHANCES * np.exp(log - log.max()).sum(axis=1)
    chances /= chances.sum()
    lacking = max(LEAST_EVEN - chances[_PARTS == 0.0].sum(), 0.0)
    return np.asarray((1.0 - lacking) * chances + lacking * _EVEN)


LandInState = tuple[LandSources, Bore, Any, Any]  # with its contact length, and where its spool lies


@dataclass(frozen=True)
class LandDraws:
    """What is not known of one land, drawn: its bore now, new and unworn, its contact length, where its spool lies."""

    land: LandSources
    bore: Bore
    new_bore: Bore
    unworn_bore: Bore
    length: Any
    position: Any

    @property
    def now(self) -> LandInState:
        """Return what `Drawn.leakage` asks for, with the bore as it is; so do the two below, as it was."""
        return self.land, self.bore, self.length, self.position

    @property
    def new(self) -> LandInState:
        return self.land, self.new_bore, self.length, self.position

    @property
    def unworn(self) -> LandInState:
        return self.land, self.unworn_bore, self.length, self.position


def land_draws(
    stream: Draws,
    land: LandSources,
    common: dict[str, np.ndarray],
    one_sided: OneSided,
    assumptions: Assumptions,
    position: Any,
    readings: Draws | None = None,
    length: Draws | None = None,
) -> LandDraws:
    """Draw all that is not known of one land.

    ``readings`` draws the errors of what was measured, ``length`` the contact length of the file, and ``stream`` all
    else that a unit keeps between two visits; one and the same unless given.
    """
    readings = readings or stream
    new = new_bore(stream, land)
    # what was not measured is as new: the same in every trial
    bore = unworn = new
    if land.state.measured:
        measured = measured_clearance(readings, land, common, new.clearance)
        bore = worn_bore(stream, land, measured, new.clearance, one_sided)
        unworn = unworn_bore(land, measured, new)
    nominal, by_calliper = land.state.land.contact_length, land.state.land.contact_length_measured
    drawn: float | np.ndarray = nominal
    uncertain = assumptions.of_contact_length(measured=by_calliper)
    if uncertain:
        lengths = (readings if by_calliper else length or stream).normal()
        lengths *= uncertain
        lengths += nominal
        drawn = np.maximum(lengths, _SHORTEST * nominal, out=lengths)
    return LandDraws(land, bore, new, unworn, drawn, position)


def measured_clearance(stream: Draws, land: LandSources, common: dict[str, np.ndarray], new: np.ndarray) -> np.ndarray:
    """Draw what the mean clearance may be that the diameters show [m].

    Parameters
    ----------
    common
        the errors that lands share, each of shape (draws,).
    new
        what the pair had when new [m], shape (draws,): a sleeve that was not measured is as it was then.
    """
    own = [source for source in land.sources if source.group is None and source.kind != MOUNTING]
    normal = math.fsum(source.standard_uncertainty**2 for source in own if source.shape == "normal")
    clearance = stream.normal()
    clearance *= math.sqrt(normal)
    clearance += land.state.radial_clearance
    for source in own:
        if source.shape == "rectangular" and source.standard_uncertainty:
            clearance += stream.rectangular() * source.standard_uncertainty
    for name, u in land.groups.items():
        if u:
            clearance += u * common[name]
    if any(source.kind == MOUNTING for source in land.sources):
        clearance += new - land.state.land.new_clearance
    return clearance


def new_bore(stream: Draws, land: LandSources) -> Bore:
    """Draw what the land's clearance may have been when new, from what is known of it."""
    low, high = land.state.land.mounting_range
    if low < high:
        return Bore(low + (high - low) * stream.uniform())
    return Bore(low + land.u_mounting * stream.normal())


def unworn_bore(land: LandSources, clearance: np.ndarray, new: Bore) -> Bore:
    """Return what a measured land may have been when new, draw by draw; ``new`` where that is this pair's own."""
    pair = land.state.land
    return new if pair.widest_new == pair.mounting_range[0] else Bore(pair.unworn(clearance))


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
    fitted = land.fitted_side
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
        lambda part: np.stack([plan.seen_of_one_side(math.pi * part, n) for n in EXPONENTS], axis=1),
        one_sided.place,
    )
    wear = shown / np.maximum(1.0 - fraction + fraction * seen, LEAST_SEEN)
    moments = one_sided.moments(fraction * wear)
    return Bore(clearance + (wear - shown), *with_one_side(moments, square, cube))


def with_one_side(one_sided: Sequence[Any], square: Any, cube: Any) -> tuple[Any, Any]:
    """Return the moments that wear to one side makes, or those measured where these are larger."""
    larger = one_sided[0] > square
    return np.where(larger, one_sided[0], square), np.where(larger, one_sided[1], cube)


class Positions:
    """Where the spool of each component lies, drawn once for all its lands, now and new."""

    def __init__(self, model: LeakageModel, own: Beside, seed: int) -> None:
        self._unknown = model.profile.eccentricity == UNKNOWN
        self._mean, self._own, self._seed = model.law.eccentricity_factor, own, seed
        self._numbers = {number: place for place, number in enumerate(model.controller.components)}
        self._drawn: dict[str, np.ndarray] = {}

    def of(self, land: LandSources) -> np.ndarray | None:
        """Return the factor of a land's spool over a concentric one, shape (draws,); None where the profile sets it."""
        if not self._unknown:
            return None
        component = land.key[0]
        if component not in self._drawn:
            ratio = self._own.draws(self._seed, 2, self._numbers[component]).uniform()
            self._drawn[component] = eccentricity_factor(ratio, 1.0)
        return self._drawn[component]

    @property
    def relative_spread(self) -> float:
        """Return the standard deviation of the factor 1 + 1.5 e², e/c uniform, over its mean; 0 where it is set."""
        return ECCENTRIC_GAIN * math.sqrt(1.0 / 5.0 - 1.0 / 9.0) / self._mean if self._unknown else 0.0
