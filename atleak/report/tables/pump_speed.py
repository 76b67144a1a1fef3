"""Compare what the pump supplies over engine speed with what is taken from it, at several temperatures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.projection import Projection, project

_FEWEST = 4  # temperatures that are drawn, where there are two to draw between: choice of this project
_POINTS = 61  # of the speeds
_BEYOND = 1.25  # part of the speeds that is drawn beyond the last one that matters


@dataclass(frozen=True)
class Demand:
    """What is taken from the pump at one temperature, at the pressure that a condition requires."""

    temperature: float  # [°C]
    leakage: float  # [m³/s]
    slip: float  # [m³/s]
    consumers: float  # [m³/s]
    crossing: float  # [1/s] the lowest engine speed at which the pump supplies as much
    of_condition: bool  # it is the temperature of the condition

    @property
    def flow(self) -> float:
        """Return leakage, slip and consumers together [m³/s]."""
        return self.leakage + self.slip + self.consumers


@dataclass(frozen=True)
class PumpOverSpeed:
    """The pump's supply over engine speed against the demand at each temperature, for one condition."""

    projection: Projection
    speeds: np.ndarray  # [1/s], shape (n,)
    supply: np.ndarray  # [m³/s] before slip, shape (n,)
    demands: tuple[Demand, ...]  # in the order of their temperatures
    marked: tuple[tuple[str, float], ...]  # label and engine speed [1/s]: of the condition, and of idle
    interval: tuple[float, float] | None  # [1/s] of the crossing at the condition's temperature

    @property
    def demand(self) -> Demand:
        """Return that at the condition's temperature."""
        return next(each for each in self.demands if each.of_condition)


def pump_over_speed(diagnosis: Diagnosis, projection: Projection, say: Wording) -> PumpOverSpeed:
    """Compute the pump's supply over engine speed, and what is taken from it at the temperatures of all conditions.

    Gear, required pressure and consumers are those of the condition; leakage and slip follow the temperature. Slip is
    counted with what is taken, so that supply over demand at any speed is the reserve there.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    condition, model = projection.condition, diagnosis.model
    demands = []
    for temperature in _temperatures([each.condition.temperature for each in diagnosis.projections]):
        own = temperature == condition.temperature
        at = projection if own else project(model, replace(condition, temperature=temperature))
        demands.append(Demand(temperature, at.leakage, at.slip, at.consumers, at.minimum_speed, own))
    idle = diagnosis.hot_idle
    marked = [(say.condition(condition), condition.engine_speed)]
    if idle is not None and idle.condition.engine_speed != condition.engine_speed:
        marked.append((say.condition(idle.condition), idle.condition.engine_speed))
    last = max(each.crossing for each in demands if np.isfinite(each.crossing)) if demands else 0.0
    speeds = np.linspace(0.0, _BEYOND * max(last, *(speed for _, speed in marked)), _POINTS)
    total = diagnosis.uncertainty.total(condition.name) if diagnosis.uncertainty else None
    return PumpOverSpeed(
        projection=projection,
        speeds=speeds,
        supply=np.asarray(model.pump.per_revolution * speeds, dtype=float),
        demands=tuple(demands),
        marked=tuple(marked),
        interval=total.minimum_speed_interval if total else None,
    )


def _temperatures(stated: Sequence[float]) -> list[float]:
    """Return the temperatures of the conditions, and a few between them [°C].

    >>> _temperatures([80.0, 100.0, 80.0])
    [80.0, 87.0, 93.0, 100.0]
    """
    known = sorted(set(stated))
    missing = _FEWEST - len(known)
    if len(known) < 2 or missing <= 0:
        return known
    between = np.linspace(known[0], known[-1], missing + 2)[1:-1].round()
    return sorted({*known, *(float(each) for each in between)})
