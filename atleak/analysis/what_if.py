"""Try a unit at another temperature, wear, fluid, speed, gear or position of its spools; the job stays as it is.

`tried` computes it at one condition, beside the job's own result; `map_over` over temperature and wear at once: its
share of the pump's flow and every pressure that it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from atleak.catalogue.controller import Land
from atleak.catalogue.fluid import Fluid, FluidState
from atleak.catalogue.limits import Level
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import InputError, Message, unknown
from atleak.common.sentences import Sentence
from atleak.common.units import RPM
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import Rule, permissible_steps, unit_rules
from atleak.engine.gap_messages import narrow_gap_messages
from atleak.engine.leakage import Clearance, LeakageModel, PumpFlow
from atleak.engine.operation import LINE, Operation, spread_over
from atleak.engine.projection import Projection, model_unworn, project, project_unworn, stated_condition
from atleak.measurements.clearances import LandClearance

COUNT = 31  # of temperatures, and of wears: choice of this project, what lies between is drawn as straight lines
_LOWEST, _HIGHEST = 20.0, 140.0  # [°C] between which ATF works: choice of this project


@dataclass(frozen=True)
class TriedClearance:
    """The clearance of a land as it is tried; arrays of one shape where several wears are."""

    land: Land
    spool_diameter: float  # [m]: the bore wears, the spool keeps its diameter
    radial_clearance: Any  # [m], cold, the mean
    form_moments: tuple[Any, Any]  # [m²], [m³]

    @property
    def sleeve_diameter(self) -> Any:
        """Return the diameter of the worn bore [m]."""
        return self.spool_diameter + 2.0 * self.radial_clearance


def measured_growth(state: LandClearance) -> float:
    """Return by how much a land's clearance has grown over what it may have been when new [m].

    A reading within what new pairs have is no growth; a land that nobody measured, or that is tighter than new, has
    none.
    """
    return max(state.radial_clearance - float(state.land.unworn(state.radial_clearance)), 0.0)


def worn(states: Sequence[LandClearance], factor: Any, further: Any) -> tuple[Clearance, ...]:
    """Return the lands with their measured growth times a factor, and further growth on top; arrays give arrays.

    Parameters
    ----------
    factor
        on the growth of each: 0 is as new, 1 as measured. What makes a worn gap uneven is part of its wear: deviations
        from its mean clearance follow the factor too. A land without growth stays as it is.
    further
        of every land, as a fraction of its clearance when new, the same all around.
    """
    if np.ndim(factor) == np.ndim(further) == 0 and factor == 1.0 and further == 0.0:
        return tuple(states)
    return tuple(_worn(state, factor, further) for state in states)


def _worn(state: LandClearance, factor: Any, further: Any) -> TriedClearance:
    growth, (second, third) = measured_growth(state), state.form_moments
    added = further * state.land.new_clearance
    if not growth:
        return TriedClearance(state.land, state.spool_diameter, state.radial_clearance + added, (second, third))
    mean = state.radial_clearance + (factor - 1.0) * growth + added
    return TriedClearance(state.land, state.spool_diameter, mean, (second * factor**2, third * factor**3))


class Axis(StrEnum):
    """Which of the two kinds of wear is varied."""

    WEAR = "wear"  # the growth that was measured, times a factor
    GROWTH = "growth"  # of every land, on top of that


@dataclass(frozen=True)
class WhatIf:
    """What is tried; None, like the defaults of wear and growth, leaves it as the job has it.

    Attributes
    ----------
    point
        name of the operating point whose pressures hold, and whose temperature, speed and gear where none is given;
        the stated condition unless given.
    temperature_c
        of the fluid [°C].
    engine_speed_rpm
        [rev/min].
    gear
        the gear engaged.
    wear
        factor on the growth of every measured land over a new one: 0 is as new, 1 as measured, 2 twice the wear.
    growth
        of every land's clearance on top of that, as a fraction of its clearance when new: the wear of the source
        study's variants is 0.1 or 0.5 of it.
    fluid
        as its data are; the job's unless given.
    fluid_state
        whether it is fresh or used; as in the job unless given.
    eccentricity
        e/c of every spool, 0 to 1, or ``unknown``.
    """

    point: str | None = None
    temperature_c: float | None = None
    engine_speed_rpm: float | None = None
    gear: int | None = None
    wear: float = 1.0
    growth: float = 0.0
    fluid: Fluid | None = None
    fluid_state: FluidState | None = None
    eccentricity: float | Literal["unknown"] | None = None

    def base(self, diagnosis: Diagnosis) -> OperatingPoint:
        """Return the condition of the job from which this departs.

        Raises
        ------
        InputError
            a point that the job does not have.
        """
        if self.point is None:
            return diagnosis.projection.condition
        points = {each.condition.name: each.condition for each in diagnosis.projections}
        if self.point not in points:
            raise unknown(Sentence("no such condition of the job"), self.point, points)
        return points[self.point]

    def condition(self, diagnosis: Diagnosis) -> OperatingPoint:
        """Return the condition that is tried; that of the job itself where nothing of it differs.

        Raises
        ------
        InputError
            a gear the valve body does not have, or a speed that is not positive.
        """
        base = self.base(diagnosis)
        speed = None if self.engine_speed_rpm is None else self.engine_speed_rpm / RPM
        asked = {"temperature": self.temperature_c, "engine_speed": speed, "gear": self.gear}
        other = {name: value for name, value in asked.items() if value is not None and value != getattr(base, name)}
        return stated_condition(diagnosis.controller, base=base, **other) if other else base  # type: ignore[arg-type]

    def fluid_of(self, diagnosis: Diagnosis) -> Fluid:
        """Return the fluid that is tried, in its state.

        Raises
        ------
        InputError
            data of a used fluid, asked for fresh.
        """
        fluid = diagnosis.fluid if self.fluid is None else self.fluid
        state = self.fluid_state or ("used" if fluid.state == "used" else diagnosis.fluid.state)
        return fluid.in_state(state)

    def model(self, diagnosis: Diagnosis) -> LeakageModel:
        """Return the engine with the job's lands, fluid and profile as they are tried.

        Raises
        ------
        InputError
            a wear or growth below zero, an eccentricity outside 0 to 1, data of a used fluid asked for fresh.
        """
        for problem, value in (
            (Sentence("wear not accepted"), self.wear),
            (Sentence("growth not accepted"), self.growth),
        ):
            if not value >= 0.0:
                raise InputError(problem, value=value, expected=Sentence("0 or more"))
        model = diagnosis.model
        profile = model.profile
        if self.eccentricity is not None:
            profile = profile.with_options(eccentricity=self.eccentricity)
        states = tuple(land.state for land in diagnosis.lands)
        tried_clearances = worn(states, self.wear, self.growth)
        return LeakageModel(model.controller, tried_clearances, self.fluid_of(diagnosis), profile)


@dataclass(frozen=True)
class Tried:
    """The unit as it is tried, and the job beside it."""

    settings: WhatIf  # what is tried
    projection: Projection  # as it is tried
    job: Projection  # of the job, at the condition from which this departs
    total: Rule  # of the total share as it is tried
    pressures: tuple[Rule, ...]  # of reserve, circuits and permissible pressure as they are tried
    messages: tuple[Message, ...]  # where what was tried is outside of what is known, and what is assumed

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that judges the unit as it is tried."""
        return (self.total, *self.pressures)


def tried(diagnosis: Diagnosis, settings: WhatIf) -> Tried:
    """Compute what a unit would do at other settings; the diagnosis stays as it is.

    Returns
    -------
    Tried
        judged by the job's limits, beside the same unit new at the tried condition with the tried fluid.

    Raises
    ------
    DomainError
        a temperature outside the fluid's data.
    InputError
        a setting that cannot be: see `WhatIf`.
    """
    model, condition = settings.model(diagnosis), settings.condition(diagnosis)
    projection = project(model, condition)
    states = [land.state for land in diagnosis.lands]
    unworn = project_unworn(states, model, [projection])
    rules = unit_rules((), [projection], unworn, diagnosis.limits, diagnosis.controller.operating_points)
    temperature = condition.temperature
    return Tried(
        settings=settings,
        projection=projection,
        job=diagnosis.at(settings.base(diagnosis)),
        total=rules.totals[0],
        pressures=rules.pressures,
        messages=(
            *model.fluid.messages(temperature, temperature, model.profile.viscosity),
            *projection.messages,
            *narrow_gap_messages(projection.gaps),
        ),
    )


_MOST = {Axis.WEAR: 3.0, Axis.GROWTH: 1.0}  # wear that a map shows at least: likewise


@dataclass(frozen=True)
class Border:
    """Where a level begins on a map, at each of its temperatures."""

    level: Level  # that begins there
    value: np.ndarray  # fraction of the pump's flow, or [Pa]; shape (temperatures,), NaN where nothing is known


@dataclass(frozen=True)
class Map:
    """A unit over temperature and wear; arrays of shape (wears, temperatures), NaN outside the fluid's data."""

    axis: Axis  # what runs along it
    temperatures: np.ndarray  # [°C]
    wears: np.ndarray  # factor on the measured wear, or further growth as a fraction
    share: np.ndarray  # of the pump's flow; infinite where the pump delivers nothing
    pressures: Mapping[str, np.ndarray]  # [Pa] that the line, as p_g, and every circuit that is applied hold
    share_borders: tuple[Border, ...]  # over which a band begins, the mildest first
    pressure_borders: Mapping[str, tuple[Border, ...]]  # under which a level begins, the mildest first

    def share_reaches(self, border: Border) -> np.ndarray:
        """Return from which wear on a band is reached, at each temperature; NaN where it is not on this map.

        Parameters
        ----------
        border
            one of `share_borders`.

        Returns
        -------
        numpy.ndarray
            wear as on the map's axis, shape (temperatures,).
        """
        return _first(self.wears, self.share - border.value)

    def pressure_reaches(self, name: str, border: Border) -> np.ndarray:
        """Return from which wear on the line or a circuit holds so little that a level is reached, likewise.

        Parameters
        ----------
        name
            of the line, p_g, or the id of a circuit.
        border
            one of `pressure_borders` of that name.

        Returns
        -------
        numpy.ndarray
            wear as on the map's axis, shape (temperatures,).
        """
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


def map_over(diagnosis: Diagnosis, settings: WhatIf, temperatures_c: ArrayLike, wears: ArrayLike) -> Map:
    """Compute a unit for every temperature with every wear, all else as the settings have it.

    Parameters
    ----------
    temperatures_c
        [°C], shape (temperatures,); where one is outside the fluid's data nothing is known.
    wears
        shape (wears,), in place of the settings' wear, or of their growth where no land has grown: see `axis_of`.

    Returns
    -------
    Map
        computed at these temperatures and wears, with nothing between them.

    Raises
    ------
    InputError
        a setting that cannot be: see `WhatIf`.
    """
    axis, at, many = axis_of(diagnosis), np.array(temperatures_c, float), np.array(wears, float)
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
