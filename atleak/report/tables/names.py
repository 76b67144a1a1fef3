"""Name components and lands for people: by their numbers where they have such, else by their names alone.

It also says where the spools are taken to lie, and between which shares the total may lie with them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import PUMP, LandKey
from atleak.common.sentences import Sentence
from atleak.common.units import PERCENT
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.profile import UNKNOWN, Profile
from atleak.engine.projection import Projection

_LONGEST = 8  # signs of a component's number
_NAMED = 4  # components in a row


def component_words(controller: Controller, component: str, say: Wording) -> str:
    """Name a component, or the pump: ``25 main pressure valve``, ``boost valve`` where its id is that name in words."""
    if component == PUMP and component not in controller.components:
        return say("pump.name")
    name = _name(controller, component, say)
    return f"{component} {name}".strip() if has_number(controller, component) else name


def components_words(controller: Controller, components: Sequence[str], say: Wording) -> str:
    """Name components in a row: all of several as the whole valve body, else some of them and how many more."""
    if is_whole_body(controller, components):
        return say("plan.whole_body")
    named = ", ".join(component_words(controller, each, say) for each in components[:_NAMED])
    more = len(components) - _NAMED
    return named if more <= 0 else say("diagnosis.and_more", named=named, count=more)


def is_whole_body(controller: Controller, components: Collection[str]) -> bool:
    """Tell whether components are all that have lands, and several."""
    return len(components) > 1 and {land.component for land in controller.lands} <= set(components)


def land_number(controller: Controller, key: LandKey, say: Wording) -> str:
    """Name a land in short: ``25/1``, or ``boost valve/1``."""
    component, land = key
    return f"{component if has_number(controller, component) else _name(controller, component, say)}/{land}"


def land_words(controller: Controller, key: LandKey, say: Wording) -> str:
    """Name a land, its number first, so that a narrow column cuts the name only: ``25/1 main pressure valve``."""
    component, _ = key
    short = land_number(controller, key, say)
    return f"{short} {_name(controller, component, say)}".strip() if has_number(controller, component) else short


def has_number(controller: Controller, component: str) -> bool:
    """Tell whether a component's id is a number that people use; one in words only repeats its name.

    Of components of one name, or without one, the id is all that tells them apart.
    """
    name = controller.components.get(component, "")
    if not name or list(controller.components.values()).count(name) > 1:
        return True
    return len(component) <= _LONGEST and "_" not in component and any(sign.isdigit() for sign in component)


def _name(controller: Controller, component: str, say: Wording) -> str:
    return isolated(say.name(controller.components.get(component, "")))


def positions(diagnosis: Diagnosis, projection: Projection) -> str:
    """Say in English for which position of the spools flows are given, and the total share as they may lie."""
    band = position_band(diagnosis, projection)
    if band is None or projection.pump_capacity <= 0.0:
        return spools_taken(diagnosis.profile)
    low, high = (each * PERCENT for each in band)
    digits = 0 if high >= 10.0 else 1  # a small share rounded to 0 would say that nothing leaks
    return f"{spools_taken(diagnosis.profile)}, {low:.{digits}f} to {high:.{digits}f} % as they may lie"


def spools_taken(profile: Profile) -> Sentence:
    """Say where a profile takes the spools to lie.

    >>> from atleak.engine.profile import WORKSHOP
    >>> spools_taken(WORKSHOP)
    'spools concentric'
    """
    eccentricity = profile.eccentricity
    if eccentricity == UNKNOWN:
        return Sentence("mean over all positions of the spools")
    if eccentricity:
        return Sentence("spools at e/c = {eccentricity:g}", eccentricity=eccentricity)
    return Sentence("spools concentric")


def position_band(diagnosis: Diagnosis, projection: Projection) -> tuple[float, float] | None:
    """Return the total share with every spool concentric and with every one touching its bore, as fractions.

    None where the profile sets the position.
    """
    if diagnosis.profile.sets_position:
        return None
    return projection.share_of(projection.concentric_leakage), projection.share_of(projection.touching_leakage)


def concentric_factors(profile: Profile, projection: Projection) -> tuple[float, float]:
    """Return between which factors the leakage may lie of that with every spool concentric [-]; 1 if nothing leaks.

    Narrow gaps give 1 and 2.5, wide ones less, because their entry loss does not depend on where the spool lies. Where
    the profile sets the position, both are the factor there.
    """
    concentric, touching = projection.concentric_leakage, projection.touching_leakage
    if not concentric:
        return 1.0, 1.0
    if profile.sets_position:
        return (projection.leakage / concentric,) * 2
    return 1.0, touching / concentric
