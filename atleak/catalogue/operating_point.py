"""Describe the conditions at which leakage and pump are compared."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.catalogue.controller_tables import State

HOT_IDLE = "hot_idle"
STATED = "stated"  # name of the condition that a job states: no point of a file has it
IDLE_SPEED = 1000.0 / 60.0
"""[1/s] under which an engine in gear idles, where nothing else says so: choice of this project."""


@dataclass(frozen=True)
class OperatingPoint:
    """A stated condition at which leakage and pump are compared."""

    name: str
    label: str
    temperature: float  # [°C]
    engine_speed: float  # [1/s]
    gear: int
    main_pressure: float  # [Pa]
    converter_pressure: float  # [Pa]
    source: str
    stated_state: State | None = None  # where the file says it
    solenoid_current: float | None = None  # [A]
    lockup_duty: float | None = None  # [-] of the lock-up solenoid, 0 to 1
    values_of: str = ""  # name of the file's point whose set pressures and flows hold here; "" for its own

    def __format__(self, specification: str) -> str:
        """Write the point's label, as the file has it."""
        return format(self.label, specification)

    @property
    def is_stated(self) -> bool:
        """Whether a job states it, so that no file names it."""
        return self.name == STATED

    @property
    def state(self) -> State:
        """Return whether the engine idles, the converter stalls or the vehicle drives; by speed unless stated."""
        return self.stated_state or ("idle" if self.engine_speed < IDLE_SPEED else "driving")

    @property
    def like(self) -> str:
        """Return the name of the point of the controller's file whose set pressures and flows hold here."""
        return self.values_of or self.name
