"""Draw what is not known of a land: its clearance, how its bore is worn, what it was when new, how its spool lies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import UNKNOWN
from atleak.equations.clearance import one_sided_moments
from atleak.equations.gap import ECCENTRIC_GAIN, eccentricity_factor
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.points import Beside, Draws
from atleak.uncertainty.sources import MEASURING_TEMPERATURE, MOUNTING, LandSources

#: Part of the wear to one side that the directions of a sheet show at least. Two directions at a right angle never show
#: less than π/4. One alone, laid across the worn side, shows nothing of it, which no interval can bound: the clearance
#: is then called a lower bound, and up to twice the wear that shows is reckoned with. Choice of this project.
LEAST_SEEN = 0.5

NORMAL_FACTORS = ("viscosity", "temperature", "main pressure", "converter pressure", "pump efficiency")
FLUID_STATE = "viscosity of the used fluid"  # rectangular; only where the fluid has no data of its own used state
FACTORS = (*NORMAL_FACTORS, FLUID_STATE)


_SHORTEST = 0.1  # fraction of the nominal contact length; shorter draws are raised to it


@dataclass(frozen=True)
class Bore:
    """The clearance of a land as drawn: its mean around the circumference, and how it spreads there."""

    clearance: Any  # [m] radial, cold
    square: Any = 0.0  # [m²] second central moment over the circumference
    cube: Any = 0.0  # [m³] third


def deviates_of_factors(shared: Draws) -> dict[str, np.ndarray]:
    """Draw the standard deviates of `FACTORS`."""
    deviates = {name: shared.normal() for name in NORMAL_FACTORS}
    deviates[FLUID_STATE] = shared.rectangular()
    return deviates


def common_errors(stream: Draws, lands: Sequence[LandSources]) -> dict[str, np.ndarray]:
    """Draw the errors that lands share, by their groups, each of shape (draws,) and of unit standard deviation."""
    names = sorted({group for land in lands for group in land.groups})
    return {name: stream.rectangular() if name == MEASURING_TEMPERATURE else stream.normal() for name in names}


def one_sided_fraction(stream: Draws, model: LeakageModel, assumptions: Assumptions) -> np.ndarray:
    """Draw how much of all wear lies to one side of the bores; the cube of the mean clearance knows no sides."""
    most = assumptions.one_sided_wear if model.law.counts_form else 0.0
    return 0.5 * most * np.floor(3.0 * stream.uniform())


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
    fraction: np.ndarray,
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
        bore = worn_bore(stream, land, measured, new.clearance, fraction)
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


def worn_bore(stream: Draws, land: LandSources, clearance: np.ndarray, new: np.ndarray, fraction: np.ndarray) -> Bore:
    """Draw the true mean clearance and its spread around the circumference, where part of the wear is to one side.

    Parameters
    ----------
    clearance, new
        the mean clearance that the diameters show, and that of the pair when new [m]; shape (draws,).
    fraction
        of the wear that lies to one side, shape (draws,).

    Notes
    -----
    According to where its directions lie, a sheet shows more or less than the mean of wear to one side. The spread is
    never less than what the directions themselves show.
    """
    square, cube = land.state.form_moments
    plan = land.plans.get("sleeve")
    if plan is None or not fraction.any():  # of a bore that was not measured no wear is known
        return Bore(clearance, square, cube)
    shown = np.maximum(clearance - new, 0.0)
    angles = tuple(plan.angles.items())
    seen = stream.of_uniform(("seen of one side", angles), lambda part: plan.seen_of_one_side(math.pi * part))
    wear = shown / np.maximum(1.0 - fraction + fraction * seen, LEAST_SEEN)
    return Bore(clearance + (wear - shown), *with_one_side(fraction * wear, square, cube))


def with_one_side(mean_wear: Any, square: Any, cube: Any) -> tuple[Any, Any]:
    """Return the moments of wear to one side of that mean [m], or those measured where these are larger."""
    one_sided, third = one_sided_moments(mean_wear)
    larger = one_sided > square
    return np.where(larger, one_sided, square), np.where(larger, third, cube)


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
