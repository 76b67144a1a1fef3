"""Name components and lands for people: by their numbers where they have such, else by their names alone."""

from __future__ import annotations

from atleak.catalogue.controller import Controller
from atleak.rules import LandKey
from atleak.wording import Wording, isolated

_LONGEST = 8  # signs of a component's number


def component_words(controller: Controller, component: str, say: Wording) -> str:
    """Name a component: ``25 main pressure valve``, or ``boost valve`` where its id is that name in technical words."""
    name = _name(controller, component, say)
    return f"{component} {name}".strip() if has_number(controller, component) else name


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
