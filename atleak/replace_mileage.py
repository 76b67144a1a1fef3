"""Foresee the mileage at which a land reaches the limit of wear for replacing, where one visit tells it.

A straight line needs two points. The second one, at 0 km, is the mounting clearance, where that was measured: on this
pair when it was new, or on new units of its type. One visit and a mounting clearance that nobody measured tell no rate.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from atleak.catalogue.limits import RuleKind
from atleak.errors import Message
from atleak.rules import Rule
from atleak.sentence import Sentence
from atleak.uncertainty import LandUncertainty
from atleak.uncertainty.sources import LandSources
from atleak.unit_systems import Quantity
from atleak.verdicts import Verdict
from atleak.wear_line import Crossing, WearLine, wear_line

NO_RATE = "no_wear_over_mileage"  # code of the message that one visit gives none


def known_at_start(land: LandSources) -> bool:
    """Return whether the clearance that a land had at 0 km was measured; of one that was repaired since it was not."""
    return land.state.land.mounting_measured and land.state.land.fitted is None


def replace_mileage(
    rules: Iterable[Rule], mileage: float | None, uncertainty: LandUncertainty | None
) -> Crossing | None:
    """Return the mileage at which a land reaches the wear limit; None where one visit cannot tell it, or it is passed.

    Parameters
    ----------
    rules
        of the land, judged.
    mileage
        of the vehicle [km]; None where it is not known.
    uncertainty
        of the land; None where it was not measured.
    """
    rule = next((rule for rule in rules if rule.kind is RuleKind.WEAR), None)
    if rule is None or uncertainty is None:
        return None
    line = _line_from_new(uncertainty.sources, mileage)
    if line is None or mileage is None:
        return None
    worn = rule.steps.limit_of(Verdict.REPLACE) or rule.steps.levels[-1][1]
    state = uncertainty.sources.state
    limit = (1.0 + worn) * state.land.mounting_high
    return None if state.radial_clearance >= limit else line.reaches(limit, mileage)


def _line_from_new(land: LandSources, mileage: float | None) -> WearLine | None:
    """Return the line from the mounting clearance at 0 km to the clearance as measured; None where either lacks."""
    if mileage is None or land.state.status != "measured" or not known_at_start(land):
        return None
    of_both = np.diag([land.u_mounting**2, land.standard_uncertainty**2])
    return wear_line([0.0, mileage], [land.state.land.new_clearance, land.state.radial_clearance], of_both)


def without_rate(lands: Iterable[LandUncertainty], mileage: float | None) -> Message | None:
    """Say how many measured lands have no rate of wear; None where all have one, or no mileage asks for it."""
    measured = [land.sources for land in lands if land.sources.state.can_be_ok]
    unknown = sum(not known_at_start(land) for land in measured)
    if mileage is None or not unknown:
        return None
    text = Sentence(
        "One visit tells no wear over mileage of {unknown} of {measured} measured lands: what they had at {start} "
        "{start.unit} was not measured. A second visit tells it, or mounting clearances that are learned from new "
        "units.",
        unknown=unknown,
        measured=len(measured),
        start=Quantity(0.0, "distance"),
    )
    return Message("info", NO_RATE, text)
