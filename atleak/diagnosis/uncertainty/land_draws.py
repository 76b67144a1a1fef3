"""Draw what is not known of one land: its bore now, new and unworn, its contact length, and where its spool lies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.draws import Beside, Draws
from atleak.diagnosis.uncertainty.one_sided_wear import Bore, OneSided, worn_bore
from atleak.diagnosis.uncertainty.sources import MEASURING_TEMPERATURE_SOURCE, MOUNTING, LandSources
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import UNKNOWN
from atleak.equations.gap import ECCENTRIC_GAIN, eccentricity_factor

_SHORTEST = 0.1  # fraction of the nominal contact length; shorter draws are raised to it

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


def common_errors(stream: Draws, lands: Sequence[LandSources]) -> dict[str, np.ndarray]:
    """Draw the errors that lands share, by their groups, each of shape (draws,) and of unit standard deviation."""
    names = sorted({group for land in lands for group in land.groups})
    return {name: stream.rectangular() if name == MEASURING_TEMPERATURE_SOURCE else stream.normal() for name in names}


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
