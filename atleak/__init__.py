"""atleak: internal leakage of automatic-transmission valve bodies.

The public names below are loaded when they are first used, so that ``import atleak`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from atleak.version import __version__ as __version__

if TYPE_CHECKING:
    from atleak.catalogue.controller import Controller, load_controller
    from atleak.catalogue.fluid import Fluid, load_fluid
    from atleak.catalogue.limits import Limits, load_limits
    from atleak.diagnosis import Diagnosis, diagnose
    from atleak.engine.leakage import LeakageModel
    from atleak.engine.profile import PROFILES, Profile, find_profile
    from atleak.errors import AtleakError
    from atleak.intake.readings import read_readings
    from atleak.intake.road_test import read_road_test
    from atleak.readings import Readings, clearances
    from atleak.road_test import RoadTest
    from atleak.views.diagnosis_record import diagnosis_record

_ROOMS = {
    "AtleakError": "errors",
    "Controller": "catalogue.controller",
    "load_controller": "catalogue.controller",
    "Fluid": "catalogue.fluid",
    "load_fluid": "catalogue.fluid",
    "Limits": "catalogue.limits",
    "load_limits": "catalogue.limits",
    "Profile": "engine.profile",
    "PROFILES": "engine.profile",
    "find_profile": "engine.profile",
    "Readings": "readings",
    "clearances": "readings",
    "read_readings": "intake.readings",
    "RoadTest": "road_test",
    "read_road_test": "intake.road_test",
    "LeakageModel": "engine.leakage",
    "Diagnosis": "diagnosis",
    "diagnose": "diagnosis",
    "diagnosis_record": "views.diagnosis_record",
}

__all__ = [
    "PROFILES",
    "AtleakError",
    "Controller",
    "Diagnosis",
    "Fluid",
    "LeakageModel",
    "Limits",
    "Profile",
    "Readings",
    "RoadTest",
    "clearances",
    "diagnose",
    "diagnosis_record",
    "find_profile",
    "load_controller",
    "load_fluid",
    "load_limits",
    "read_readings",
    "read_road_test",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'atleak' has no attribute {name!r}")
    return getattr(import_module(f"atleak.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return [*globals(), *_ROOMS]
