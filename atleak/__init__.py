"""atleak: internal leakage of automatic-transmission valve bodies.

The public names below are loaded when they are first used, so that ``import atleak`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from atleak.version import __version__ as __version__

if TYPE_CHECKING:  # for type checkers; `_MODULES` says the same to the interpreter, and a test compares the two
    from atleak.catalogue.controller import Controller as Controller
    from atleak.catalogue.controller_reading import load_controller as load_controller
    from atleak.catalogue.fluid import Fluid as Fluid
    from atleak.catalogue.fluid import load_fluid as load_fluid
    from atleak.catalogue.limits import Limits as Limits
    from atleak.catalogue.limits import load_limits as load_limits
    from atleak.diagnosis import Diagnosis as Diagnosis
    from atleak.diagnosis import diagnose as diagnose
    from atleak.engine.leakage import LeakageModel as LeakageModel
    from atleak.engine.profile import PROFILES as PROFILES
    from atleak.engine.profile import Profile as Profile
    from atleak.engine.profile import find_profile as find_profile
    from atleak.errors import AtleakError as AtleakError
    from atleak.intake.gauge_table import read_pressure_table as read_pressure_table
    from atleak.intake.readings import read_readings as read_readings
    from atleak.intake.road_test import read_road_test as read_road_test
    from atleak.pressure_table import PressureTable as PressureTable
    from atleak.readings import Readings as Readings
    from atleak.readings import clearances as clearances
    from atleak.repair import plan_repairs as plan_repairs
    from atleak.road_test import RoadTest as RoadTest
    from atleak.views.diagnosis_record import diagnosis_record as diagnosis_record

_MODULES = {
    "AtleakError": "errors",
    "Controller": "catalogue.controller",
    "Diagnosis": "diagnosis",
    "Fluid": "catalogue.fluid",
    "LeakageModel": "engine.leakage",
    "Limits": "catalogue.limits",
    "PROFILES": "engine.profile",
    "PressureTable": "pressure_table",
    "Profile": "engine.profile",
    "Readings": "readings",
    "RoadTest": "road_test",
    "clearances": "readings",
    "diagnose": "diagnosis",
    "diagnosis_record": "views.diagnosis_record",
    "find_profile": "engine.profile",
    "load_controller": "catalogue.controller_reading",
    "load_fluid": "catalogue.fluid",
    "load_limits": "catalogue.limits",
    "plan_repairs": "repair",
    "read_pressure_table": "intake.gauge_table",
    "read_readings": "intake.readings",
    "read_road_test": "intake.road_test",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'atleak' has no attribute {name!r}")
    return getattr(import_module(f"atleak.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return [*globals(), *_MODULES]
