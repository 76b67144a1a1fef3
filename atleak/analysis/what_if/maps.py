"""Compute a unit over temperature and wear at once: its share of the pump's flow and every pressure that it holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.analysis.what_if.trial import Axis, WhatIf, measured_growth, worn
from atleak.catalogue.limits import Level
from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import permissible_steps
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.operation import LINE, Operation, spread_over
from atleak.engine.projection import model_unworn

COUNT = 31  # of temperatures, and of wears: choice of this project, what lies between is drawn as straight lines
_LOWEST, _HIGHEST = 20.0, 140.0  # [°C] between which ATF works: choice of this project
_MOST = {Axis.WEAR: 3.0, Axis.GROWTH: 1.0}  # wear that a map shows at least: likewise


@dataclass(frozen=True)
class Border:
    """Where a level begins on a map, at each of its temperatures."""

    level: Level
    value: np.ndarray  # fraction of the pump's flow, or [Pa]; shape (temperatures,), NaN where nothing is known


@dataclass(frozen=True)
class Map:
    """A unit over temperature and wear; arrays of shape (wears, temperatures), NaN outside the fluid's data."""

    axis: Axis
    temperatures: np.ndarray  # [°C]
    wears: np.ndarray  # factor on the measured wear, or further growth as a fraction
    share: np.ndarray  # of the pump's flow; infinite where the pump delivers nothing
    pressures: Mapping[str, np.ndarray]  # [Pa] that the line, as p_g, and every circuit that is applied hold
    share_borders: tuple[Border, ...]  # over which a band begins, the mildest first
    pressure_borders: Mapping[str, tuple[Border, ...]]  # under which a level begins, the mildest first

    def share_reaches(self, border: Border) -> np.ndarray:
        """Return from which wear on a band is reached, at each temperature; NaN where it is not on this map."""
        return _first(self.wears, self.share - border.value)

    def pressure_reaches(self, name: str, border: Border) -> np.ndarray:
        """Return from which wear on the line or a circuit holds so little that a level is reached, likewise."""
        return _first(self.wears, border.value - self.pressures[name])


def _first(wears: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Return the wear at which something is first not below zero, on straight lines between the wears of the map."""
    reached = beyond >= 0.0
    at = reached.argmax(axis=0)
    columns = np.arange(beyond.shape[1])
    after, before = beyond[at, columns], beyond[np.maximum(at - 1, 0), columns]
    between = (at > 0) & np.isfinite(after) & np.isfinite(before)
    part = np.divide(after, after - before, out=np.zeros_like(after), where=between)
    wear = wears[at] - part * (wears[at] - wears[np.maximum(at - 1, 0)])
    return np.where(reached.any(axis=0), wear, np.nan)


def axis_of(diagnosis: Diagnosis) -> Axis:
    """Return which wear can be varied: the measured one or, where no land has grown, the further growth of all."""
    grown = any(measured_growth(land.state) for land in diagnosis.lands)
    return Axis.WEAR if grown else Axis.GROWTH


def temperatures_to_try(diagnosis: Diagnosis, settings: WhatIf) -> np.ndarray:
    """Return the temperatures of a map [°C]: where ATF works, wide enough for the one that is tried."""
    return _spread(_LOWEST, _HIGHEST, settings.condition(diagnosis).temperature)


def wears_to_try(diagnosis: Diagnosis, settings: WhatIf) -> np.ndarray:
    """Return the wears of a map, wide enough for the one that is tried."""
    axis = axis_of(diagnosis)
    return _spread(0.0, _MOST[axis], getattr(settings, axis))


def _spread(low: float, high: float, within: float) -> np.ndarray:
    return np.linspace(min(low, within), max(high, within), COUNT)


def map_over(diagnosis: Diagnosis, settings: WhatIf, temperatures: ArrayLike, wears: ArrayLike) -> Map:
    """Compute a unit for every temperature with every wear, all else as the settings have it.

    Parameters
    ----------
    temperatures
        [°C]; where one is outside the fluid's data nothing is known.
    wears
        in place of the settings' wear, or of their growth where no land has grown: see `axis_of`.

    Returns
    -------
    Map
        computed at these temperatures and wears, with nothing between them.

    Raises
    ------
    InputError
        a setting that cannot be: see `WhatIf`.
    """
    axis, at, many = axis_of(diagnosis), np.array(temperatures, float), np.array(wears, float)
    model, point = settings.model(diagnosis), settings.condition(diagnosis)
    low, high = model.fluid.span(model.profile.viscosity)
    known = (at >= low) & (at <= high)
    states = [land.state for land in diagnosis.lands]
    wear, warm = (each.ravel() for each in np.meshgrid(many, at[known], indexing="ij"))
    varied: dict[Axis, Any] = {Axis.WEAR: settings.wear, Axis.GROWTH: settings.growth, axis: wear}
    tried = replace(model, clearances=worn(states, varied[Axis.WEAR], varied[Axis.GROWTH]))

    def mapped(values: np.ndarray) -> np.ndarray:
        whole = np.full((len(many), len(at)), np.nan)
        whole[:, known] = values.reshape(len(many), -1)
        return whole

    def over_temperatures(values: np.ndarray) -> np.ndarray:
        whole = np.full(len(at), np.nan)
        whole[known] = values
        return whole

    share, pressures = _held(tried, model.pump, point, warm)
    new_share, new_pressures = _held(model_unworn(states, model), model.pump, point, at[known])
    borders = {
        name: tuple(Border(level, over_temperatures(value)) for level, value in each)
        for name, each in _pressure_limits(diagnosis, point, new_pressures).items()
    }
    return Map(
        axis=axis,
        temperatures=at,
        wears=many,
        share=mapped(share),
        pressures=MappingProxyType({name: mapped(values) for name, values in pressures.items()}),
        share_borders=tuple(
            Border(level, over_temperatures(np.broadcast_to(value, new_share.shape)))
            for level, value in diagnosis.limits.total_share.over(new_share)
        ),
        pressure_borders=MappingProxyType(borders),
    )


def _held(
    model: LeakageModel, pump: PumpFlow, point: OperatingPoint, temperatures: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return shares of what ``pump`` delivers and pressures held [Pa], at temperatures [°C] with clearances of each."""
    shape = temperatures.shape
    if not temperatures.size:
        return np.array([]), {}
    at = Operation.of(model, point, temperatures)
    capacity = spread_over(pump.capacity(point.engine_speed, point.main_pressure, at.viscosity), shape)
    leakage = spread_over(at.leakage, shape)
    without_pump = np.where(leakage > 0.0, np.inf, 0.0)
    share = np.divide(leakage, capacity, out=without_pump, where=capacity > 0.0)
    return share, at.pressures((circuit.id for circuit in at.network.applied), shape)


def _pressure_limits(
    diagnosis: Diagnosis, point: OperatingPoint, new: Mapping[str, np.ndarray]
) -> dict[str, list[tuple[Level, np.ndarray]]]:
    """Return under which pressures [Pa] a level begins, by what the same unit new holds at each temperature."""
    limits = diagnosis.limits
    lost = limits.circuit_loss.levels if limits.circuit_loss else ()
    pressures = {
        name: [(level, np.maximum(held - limit, 0.0)) for level, limit in lost]
        for name, held in new.items()
        if name != LINE
    }
    permissible = diagnosis.controller.permissible_at(point.gear, point.state)
    below = None if permissible is None else permissible_steps(permissible, limits)
    if LINE in new and permissible is not None and permissible.low is not None and below is not None:
        low = np.full_like(new[LINE], min(permissible.low, point.main_pressure))
        pressures[LINE] = [(level, low * (1.0 - limit)) for level, limit in below.levels]
    return pressures
