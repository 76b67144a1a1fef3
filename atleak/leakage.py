"""The engine: clearances, pressures and a fluid in; leakage of every gap, section and controller out.

Flow through a gap is linear in its pressure drop, and its geometry π D c³/12l is a polynomial in T − T₀ because the
clearance grows linearly with temperature. Gaps that share a pressure drop (up to a factor) are therefore one
polynomial, and the total over a log costs the same for 6 gaps as for 600. Two things break that and are computed gap
by gap: the entry loss, and a gap that closes within the log's range of temperature.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from atleak.controller import REFERENCE_TEMPERATURE, SECTIONS, Controller, Gap, Land, OperatingPoint
from atleak.equations import gap as gap_equations
from atleak.equations import pump as pump_equations
from atleak.errors import Message
from atleak.fluid import Fluid
from atleak.profile import Profile

_CHUNK = 16_384  # samples worked on at a time: the work arrays of one chunk stay in the processor's cache
_ENTRY_LOSS_WORTH_SAYING = 0.02
_LAMINAR_BELOW = 1000.0


class Clearance(Protocol):
    """What the engine needs to know of a land's measured or assumed state."""

    land: Land
    spool_diameter: float  # [m]
    sleeve_diameter: float  # [m]
    radial_clearance: float  # [m]


@dataclass(frozen=True)
class GapLeakage:
    """One gap at one condition: every factor of its gap law, and the flow."""

    gap: Gap
    pressure_drop: float  # [Pa], as it is: a negative one leaks nothing
    diameter: float  # [m], the one in the gap law
    contact_length: float  # [m]
    effective_clearance: float  # [m]
    kinematic_viscosity: float  # [m²/s]
    density: float  # [kg/m³]
    leakage: float  # [m³/s]
    drawn_from_pump: bool
    reynolds_number: float


@dataclass(frozen=True)
class LeakageSeries:
    """Leakage over a log [m³/s], shape (samples,); NaN where a channel was not usable.

    ``sections`` is empty unless asked for. ``reversed_samples`` counts, per section, samples whose pressure drop was
    negative in at least one gap of it: they count as zero flow there.
    """

    total: np.ndarray
    sections: dict[str, np.ndarray]
    reversed_samples: dict[str, int]
    outside_fluid: int  # samples at a temperature the fluid's data do not cover
    other_gear: int  # samples in a gear the controller does not have


@dataclass(frozen=True)
class _GapGeometry:
    """What of a gap does not change with pressure or fluid."""

    gap: Gap
    spool_diameter: float
    contact_length: float
    clearance: float  # cold
    thermal_rate: float  # [m/K]
    drawn: bool

    def effective_clearance(self, temperature: Any) -> Any:
        return np.maximum(self.clearance + self.thermal_rate * (temperature - REFERENCE_TEMPERATURE), 0.0)

    def diameter(self, effective_clearance: Any, profile: Profile) -> Any:
        return (
            self.spool_diameter + effective_clearance if profile.diameter == "mean" else self.spool_diameter
        )

    def polynomial(self, profile: Profile) -> np.ndarray:
        """π D c³ f(e)/12l as ascending coefficients of (T − T₀), shape (5,)."""
        clearance = np.array([self.clearance, self.thermal_rate])
        diameter = (
            clearance + [self.spool_diameter, 0.0] if profile.diameter == "mean" else [self.spool_diameter]
        )
        cube = np.convolve(np.convolve(clearance, clearance), clearance)
        factor = np.pi * _eccentric(profile) / (12.0 * self.contact_length)
        coefficients = np.convolve(cube, diameter) * factor
        return np.pad(coefficients, (0, 5 - len(coefficients)))

    @property
    def drop(self) -> dict[str, float]:
        """The pressure drop as coefficients of the section pressures."""
        coefficients = dict.fromkeys(SECTIONS, 0.0)
        for end, sign in ((self.gap.high, 1.0), (self.gap.low, -1.0)):
            if end.section is not None:
                coefficients[end.section] += sign * end.coefficient
        return {section: value for section, value in coefficients.items() if value}


@dataclass(frozen=True)
class _Group:
    """All gaps of one section whose pressure drops are the same up to a positive factor."""

    section: str
    drop: tuple[tuple[str, float], ...]
    polynomial: np.ndarray


@dataclass(frozen=True)
class LeakageModel:
    """A controller with given clearances, a fluid and a profile, ready to be evaluated at any condition.

    Leakage is what the profile's ``pump_draw`` says: every gap, or what ends in the sump.
    """

    controller: Controller
    clearances: tuple[Clearance, ...]
    fluid: Fluid
    profile: Profile

    @cached_property
    def _geometries(self) -> tuple[_GapGeometry, ...]:
        states = {state.land.key: state for state in self.clearances}
        found = []
        for gap in self.controller.gaps:
            state = states[gap.key]
            found.append(
                _GapGeometry(
                    gap=gap,
                    spool_diameter=state.spool_diameter,
                    contact_length=state.land.contact_length,
                    clearance=state.radial_clearance,
                    thermal_rate=state.land.thermal_rate(state.spool_diameter, state.sleeve_diameter),
                    drawn=gap.into_sump or self.profile.pump_draw == "all_gaps",
                )
            )
        return tuple(found)

    def viscosity_times_density(self, temperature: Any) -> Any:
        """ν·ρ = μ [Pa·s]; NaN outside the fluid's data."""
        model = self.profile.viscosity
        return self.fluid.kinematic_viscosity(temperature, model) * self.fluid.density(temperature, model)

    # --- one condition

    def gaps(self, condition: OperatingPoint) -> tuple[GapLeakage, ...]:
        """Every gap of the condition's gear.

        Raises
        ------
        DomainError
            temperature outside the fluid's data.
        """
        self.fluid.require(condition.temperature, self.profile.viscosity)
        viscosity = self.fluid.kinematic_viscosity(condition.temperature, self.profile.viscosity)
        density = self.fluid.density(condition.temperature, self.profile.viscosity)
        pressures = self.controller.section_pressures(condition.main_pressure, condition.converter_pressure)
        return tuple(
            self._gap_leakage(geometry, pressures, condition.temperature, viscosity, density)
            for geometry in self._geometries
            if condition.gear in geometry.gap.gears
        )

    def _gap_leakage(
        self,
        geometry: _GapGeometry,
        pressures: dict[str, Any],
        temperature: float,
        viscosity: float,
        density: float,
    ) -> GapLeakage:
        drop = float(sum(value * pressures[section] for section, value in geometry.drop.items()))
        clearance = float(geometry.effective_clearance(temperature))
        diameter = float(geometry.diameter(clearance, self.profile))
        flow = self._flow(max(drop, 0.0), diameter, clearance, viscosity, density, geometry.contact_length)
        return GapLeakage(
            gap=geometry.gap,
            pressure_drop=drop,
            diameter=diameter,
            contact_length=geometry.contact_length,
            effective_clearance=clearance,
            kinematic_viscosity=viscosity,
            density=density,
            leakage=flow,
            drawn_from_pump=geometry.drawn,
            reynolds_number=gap_equations.reynolds_number(flow, diameter, viscosity),
        )

    def _flow(
        self, drop: Any, diameter: Any, clearance: Any, viscosity: Any, density: Any, length: float
    ) -> Any:
        eccentric = _eccentric(self.profile)
        if self.profile.entry_loss:
            return eccentric * gap_equations.entry_loss_flow(
                drop, diameter, clearance, viscosity, density, length
            )
        return gap_equations.annular_flow(
            drop, diameter, clearance, viscosity, density, length, self.profile.eccentricity * clearance
        )

    def pump_capacity(self, engine_speed: Any, main_pressure: Any, temperature: Any) -> Any:
        """What the pump delivers [m³/s] at an engine speed [1/s]; never below zero."""
        pump = self.controller.pump
        if not self.uses_slip:
            return pump_equations.capacity(pump.displacement, engine_speed, pump.volumetric_efficiency)
        slip = self.pump_slip(main_pressure, temperature)
        return np.maximum(pump_equations.capacity(pump.displacement, engine_speed, 1.0) - slip, 0.0)

    def pump_slip(self, main_pressure: Any, temperature: Any) -> Any:
        """Wilson's slip flow [m³/s], which does not depend on speed."""
        pump = self.controller.pump
        return pump_equations.slip_flow(
            pump.displacement, pump.slip_coefficient, main_pressure, self.viscosity_times_density(temperature)
        )

    @property
    def uses_slip(self) -> bool:
        """Whether the pump's efficiency follows from slip rather than from a constant."""
        return self.profile.pump_efficiency == "wilson" and self.controller.pump.slip_coefficient is not None

    def minimum_speed(self, leakage: float, main_pressure: float, temperature: float) -> float:
        """Lowest engine speed [1/s] at which the pump covers a leakage [m³/s] at that pressure."""
        pump = self.controller.pump
        if self.uses_slip:
            slip = float(self.pump_slip(main_pressure, temperature))
            return pump_equations.minimum_speed(leakage, slip, pump.displacement)
        return pump_equations.minimum_speed(leakage, 0.0, pump.displacement * pump.volumetric_efficiency)

    # --- a log

    def series(
        self,
        main_pressure: Any,
        converter_pressure: Any,
        temperature: Any,
        gear: Any,
        *,
        sections: bool = False,
    ) -> LeakageSeries:
        """Leakage of every sample of a log.

        Parameters
        ----------
        main_pressure, converter_pressure
            [Pa], shape (samples,) or scalar; NaN gives NaN.
        temperature
            [°C], likewise.
        gear
            Likewise; a gear the controller does not have, or NaN, gives NaN.
        sections
            Whether the totals of p_g, p_s, p_m and p_k are kept too.
        """
        arrays = np.broadcast_arrays(
            *(np.asarray(a, float) for a in (main_pressure, converter_pressure, temperature))
        )
        gear = np.asarray(gear)
        size = max(arrays[0].size, gear.size)
        p_g, p_k, temperature = (np.broadcast_to(array, (size,)) for array in arrays)
        gear = np.broadcast_to(gear, (size,))
        work = _Work(np.empty(size), {name: np.zeros(size) for name in SECTIONS} if sections else {})
        finite = temperature[np.isfinite(temperature)] if size else temperature
        span = (float(finite.min()), float(finite.max())) if finite.size else (REFERENCE_TEMPERATURE,) * 2
        plans = {number: self._plan(number, span) for number in self.controller.gears}
        outside = other = 0
        for start in range(0, size, _CHUNK):
            part = slice(start, start + _CHUNK)
            viscous = self.viscosity_times_density(temperature[part])
            outside += int(np.count_nonzero(np.isnan(viscous) & np.isfinite(temperature[part])))
            for number, samples in _by_gear(gear[part]):
                if number not in plans:
                    work.blank(start, samples)
                    other += (
                        int(np.count_nonzero(samples)) if isinstance(samples, np.ndarray) else len(viscous)
                    )
                    continue
                self._evaluate(
                    plans[number],
                    work,
                    start,
                    samples,
                    p_g[part][samples],
                    p_k[part][samples],
                    temperature[part][samples],
                    viscous[samples],
                )
        return LeakageSeries(work.total, work.sections, work.reversed_samples, outside, other)

    def _plan(self, gear: int, span: tuple[float, float]) -> _Plan:
        geometries = [g for g in self._geometries if gear in g.gap.gears and g.drawn]
        if self.profile.entry_loss:
            return _Plan((), tuple(geometries))
        alone = [
            g
            for g in geometries
            if min(g.clearance + g.thermal_rate * (t - REFERENCE_TEMPERATURE) for t in span) <= 0.0
        ]
        polynomials: dict[tuple[str, tuple[tuple[str, float], ...]], np.ndarray] = {}
        for geometry in geometries:
            if geometry in alone or not geometry.drop:
                continue
            scale = abs(next(iter(geometry.drop.values())))
            direction = tuple((name, round(value / scale, 12)) for name, value in geometry.drop.items())
            key = (geometry.gap.section, direction)
            polynomials[key] = polynomials.get(key, 0.0) + scale * geometry.polynomial(self.profile)
        groups = tuple(_Group(*key, polynomial) for key, polynomial in polynomials.items())
        return _Plan(groups, tuple(alone))

    def _evaluate(
        self,
        plan: _Plan,
        work: _Work,
        start: int,
        samples: Any,
        p_g: np.ndarray,
        p_k: np.ndarray,
        temperature: np.ndarray,
        viscous: np.ndarray,
    ) -> None:
        pressures = self.controller.section_pressures(p_g, p_k)
        flows: list[tuple[str, np.ndarray]] = []
        reversed_: dict[str, np.ndarray] = {}
        if plan.groups:
            rise = temperature - REFERENCE_TEMPERATURE
            square = rise * rise
            powers = np.stack([np.ones_like(rise), rise, square, square * rise, square * square])
            geometry = plan.matrix @ powers
            for row, group in zip(geometry, plan.groups, strict=True):
                drop = _drop(group.drop, pressures)
                _note_reversed(reversed_, group.section, drop)
                np.maximum(drop, 0.0, out=drop)
                row *= drop
                flows.append((group.section, row))
        for single in plan.alone:
            drop = _drop(tuple(single.drop.items()), pressures)
            _note_reversed(reversed_, single.gap.section, drop)
            clearance = single.effective_clearance(temperature)
            density = self.fluid.density(temperature, self.profile.viscosity)
            flow = self._flow(
                np.maximum(drop, 0.0),
                single.diameter(clearance, self.profile),
                clearance,
                viscous / density,
                density,
                single.contact_length,
            )
            flows.append((single.gap.section, flow * viscous))
        work.put(start, samples, flows, viscous)
        for section, samples_below in reversed_.items():
            work.reversed_samples[section] += int(np.count_nonzero(samples_below))


@dataclass(frozen=True)
class _Plan:
    """How one gear is evaluated: groups by polynomial, the rest gap by gap."""

    groups: tuple[_Group, ...]
    alone: tuple[_GapGeometry, ...]

    @cached_property
    def matrix(self) -> np.ndarray:
        return np.stack([group.polynomial for group in self.groups])


class _Work:
    """The output arrays of one run over a log."""

    def __init__(self, total: np.ndarray, sections: dict[str, np.ndarray]) -> None:
        self.total, self.sections = total, sections
        self.reversed_samples = dict.fromkeys(SECTIONS, 0)

    def put(self, start: int, samples: Any, flows: list[tuple[str, np.ndarray]], viscous: np.ndarray) -> None:
        """Store flows that still lack the division by μ."""
        size = len(viscous)
        total = np.zeros(size)
        for section, flow in flows:
            total += flow
            if self.sections:
                target = self.sections[section][start : start + _CHUNK]
                target[samples] += flow / viscous
        total /= viscous
        self.total[start : start + _CHUNK][samples] = total

    def blank(self, start: int, samples: Any) -> None:
        for target in (self.total, *self.sections.values()):
            target[start : start + _CHUNK][samples] = np.nan


def _by_gear(gear: np.ndarray) -> Iterator[tuple[Any, Any]]:
    """(gear, samples) of a chunk: one slice where the gear does not change, else a mask for each gear."""
    if gear.size == 0:
        return
    first = gear[0]
    if np.all(gear == first):
        yield _gear_number(first), slice(None)
        return
    numbers = np.unique(gear)
    for number in numbers[~np.isnan(numbers)] if gear.dtype.kind == "f" else numbers:
        yield _gear_number(number), gear == number
    if gear.dtype.kind == "f":
        unknown = np.isnan(gear)
        if unknown.any():
            yield None, unknown


def _gear_number(value: Any) -> int | None:
    number = float(value)
    return int(number) if number.is_integer() else None


def _drop(direction: Sequence[tuple[str, float]], pressures: dict[str, Any]) -> np.ndarray:
    (name, factor), *rest = direction
    total = pressures[name] * factor
    for name, factor in rest:
        total += pressures[name] * factor
    return total


def _note_reversed(found: dict[str, np.ndarray], section: str, drop: np.ndarray) -> None:
    if drop.size and np.nanmin(drop) < 0.0 if not np.isnan(drop).all() else False:
        below = drop < 0.0
        found[section] = found[section] | below if section in found else below


def _eccentric(profile: Profile) -> float:
    return float(gap_equations.eccentricity_factor(profile.eccentricity, 1.0))


def gap_messages(gaps: Sequence[GapLeakage], condition: OperatingPoint) -> list[Message]:
    """What a reader must know of the gaps of one condition: reversed drops, narrow gaps, entry loss, turbulence."""
    found = []
    at = condition.label

    def names(chosen: list[GapLeakage]) -> str:
        return ", ".join(sorted({f"{gap.gap.component} land {gap.gap.land}" for gap in chosen}))

    reversed_ = [gap for gap in gaps if gap.pressure_drop < 0]
    if reversed_:
        text = f"{at}: the pressure drop is negative and counts as no leakage at {names(reversed_)}."
        found.append(Message("warning", "reversed_pressure_drop", text))
    regime = gap_equations.obliteration(np.array([gap.effective_clearance for gap in gaps]))
    narrow = [gap for gap, state in zip(gaps, regime, strict=True) if state != "free"]
    if narrow:
        text = (
            f"{at}: under 20 µm the boundary layer partly closes a gap, so the leakage given is an upper bound: "
            f"{names(narrow)}."
        )
        found.append(Message("info", "partly_closed_gap", text))
    lossy = [gap for gap in gaps if entry_loss_share(gap) > _ENTRY_LOSS_WORTH_SAYING]
    if lossy:
        text = f"{at}: entry loss would take more than 2 % off the flow at {names(lossy)}."
        found.append(Message("info", "entry_loss", text))
    fast = [gap for gap in gaps if gap.reynolds_number > _LAMINAR_BELOW]
    if fast:
        text = f"{at}: Reynolds number over 1000, the flow may not be laminar, at {names(fast)}."
        found.append(Message("warning", "not_laminar", text))
    return found


def entry_loss_share(gap: GapLeakage) -> float:
    """Which fraction of the gap law's flow the entry loss would take off."""
    if gap.pressure_drop <= 0 or gap.effective_clearance <= 0:
        return 0.0
    factors = (
        gap.pressure_drop,
        gap.diameter,
        gap.effective_clearance,
        gap.kinematic_viscosity,
        gap.density,
        gap.contact_length,
    )
    return 1.0 - gap_equations.entry_loss_flow(*factors) / gap_equations.annular_flow(*factors)
