"""atleak: internal leakage of automatic-transmission valve bodies.

The public names below are loaded when they are first used, so that ``import atleak`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from atleak.version import __version__ as __version__

if TYPE_CHECKING:  # for type checkers; `_MODULES` says the same to the interpreter, and a test compares the two
    from atleak.analysis.repair.plan import plan_repairs as plan_repairs
    from atleak.catalogue.controller import Controller as Controller
    from atleak.catalogue.controller_file import load_controller as load_controller
    from atleak.catalogue.fluid import Fluid as Fluid
    from atleak.catalogue.fluid import load_fluid as load_fluid
    from atleak.catalogue.limits import Limits as Limits
    from atleak.catalogue.limits import load_limits as load_limits
    from atleak.common.errors import AtleakError as AtleakError
    from atleak.diagnosis.diagnosis import Diagnosis as Diagnosis
    from atleak.diagnosis.examination import diagnose as diagnose
    from atleak.engine.leakage import LeakageModel as LeakageModel
    from atleak.engine.profile import PROFILES as PROFILES
    from atleak.engine.profile import Profile as Profile
    from atleak.engine.profile import find_profile as find_profile
    from atleak.engine.unit import Unit as Unit
    from atleak.engine.unit import load as load
    from atleak.measurements.clearances import clearances as clearances
    from atleak.measurements.gauge_readings import PressureTable as PressureTable
    from atleak.measurements.readings import Readings as Readings
    from atleak.measurements.road_test import RoadTest as RoadTest
    from atleak.readers.gauges.gauge_table import read_pressure_table as read_pressure_table
    from atleak.readers.logs import read_road_test as read_road_test
    from atleak.readers.sheets.measuring_sheet import read_readings as read_readings
    from atleak.report.json.diagnosis import diagnosis_record as diagnosis_record

_MODULES = {
    "AtleakError": "common.errors",
    "Controller": "catalogue.controller",
    "Diagnosis": "diagnosis.diagnosis",
    "Fluid": "catalogue.fluid",
    "LeakageModel": "engine.leakage",
    "Limits": "catalogue.limits",
    "PROFILES": "engine.profile",
    "PressureTable": "measurements.gauge_readings",
    "Profile": "engine.profile",
    "Readings": "measurements.readings",
    "RoadTest": "measurements.road_test",
    "Unit": "engine.unit",
    "clearances": "measurements.clearances",
    "diagnose": "diagnosis.examination",
    "diagnosis_record": "report.json.diagnosis",
    "find_profile": "engine.profile",
    "load": "engine.unit",
    "load_controller": "catalogue.controller_file",
    "load_fluid": "catalogue.fluid",
    "load_limits": "catalogue.limits",
    "plan_repairs": "analysis.repair.plan",
    "read_pressure_table": "readers.gauges.gauge_table",
    "read_readings": "readers.sheets.measuring_sheet",
    "read_road_test": "readers.logs",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'atleak' has no attribute {name!r}")
    return getattr(import_module(f"atleak.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return [*globals(), *_MODULES]
