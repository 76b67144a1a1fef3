"""atleak: internal leakage of automatic-transmission valve bodies.

The public names below are loaded when they are first used, so that ``import atleak`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from atleak.controller import Controller, load_controller
    from atleak.diagnosis import Diagnosis, diagnose
    from atleak.errors import AtleakError
    from atleak.fluid import Fluid, load_fluid
    from atleak.intake.readings import read_readings
    from atleak.intake.road_test import read_road_test
    from atleak.leakage import LeakageModel
    from atleak.limits import Limits, load_limits
    from atleak.profile import PROFILES, Profile, find_profile
    from atleak.readings import Readings, clearances
    from atleak.report.record import diagnosis_record
    from atleak.road_test import RoadTest

_ROOMS = {
    "AtleakError": "errors",
    "Controller": "controller",
    "load_controller": "controller",
    "Fluid": "fluid",
    "load_fluid": "fluid",
    "Limits": "limits",
    "load_limits": "limits",
    "Profile": "profile",
    "PROFILES": "profile",
    "find_profile": "profile",
    "Readings": "readings",
    "clearances": "readings",
    "read_readings": "intake.readings",
    "RoadTest": "road_test",
    "read_road_test": "intake.road_test",
    "LeakageModel": "leakage",
    "Diagnosis": "diagnosis",
    "diagnose": "diagnosis",
    "diagnosis_record": "report.record",
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
