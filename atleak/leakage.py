"""The engine: clearances, pressures and a fluid in; leakage of every gap, section and controller out.

Flow through a gap is linear in its pressure drop, and its geometry π D c³/12l is a polynomial in T − T₀ because the
clearance grows linearly with temperature. Gaps that share a pressure drop (up to a factor) are therefore one
polynomial, and the total over a log costs the same for 6 gaps as for 600. Two things break that and are computed gap
by gap: the entry loss, and a gap that closes within the log's range of temperature.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from atleak.controller import REFERENCE_TEMPERATURE, SECTIONS, Controller, Gap, Land, OperatingPoint
from atleak.equations import clearance as clearance_equations
from atleak.equations import gap as gap_equations
from atleak.equations import pump as pump_equations
from atleak.errors import Message
from atleak.fluid import Fluid
from atleak.profile import Profile

_CHUNK = 32_768  # samples worked on at a time: the work arrays of one chunk stay in the processor's cache
_RUNS = 32  # runs of one gear in a chunk, above which masks are quicker than slices
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


@dataclass
class LeakageSeries:
    """Leakage over a log [m³/s], shape (samples,); NaN where a channel was not usable.

    ``sections`` is empty unless asked for. ``reversed_samples`` counts, per section, samples whose pressure drop was
    negative in at least one gap of it: they count as zero flow there.
    """

    total: np.ndarray
    sections: dict[str, np.ndarray]
    reversed_samples: dict[str, int] = field(default_factory=lambda: dict.fromkeys(SECTIONS, 0))
    outside_fluid: int = 0  # samples at a temperature the fluid's data do not cover
    other_gear: int = 0  # samples in a gear the controller does not have

    def part(self, samples: slice) -> LeakageSeries:
        """A view of some samples."""
        return LeakageSeries(self.total[samples], {name: flow[samples] for name, flow in self.sections.items()})

    def put(self, samples: Any, total: Any, sections: dict[str, np.ndarray]) -> None:
        """Write the flows of some samples; a section not given gets what the total gets."""
        self.total[samples] = total
        for name, flow in self.sections.items():
            flow[samples] = sections.get(name, total)


@dataclass(frozen=True)
class _GapGeometry:
    """What of a gap does not change with pressure or fluid."""

    gap: Gap
    spool_diameter: float
    contact_length: float
    clearance: float  # cold
    thermal_rate: float  # [m/K]
    drawn: bool

    def clearance_at(self, temperature: Any) -> Any:
        """Radial clearance at a temperature, negative where the spool would bind."""
        return self.clearance + self.thermal_rate * (temperature - REFERENCE_TEMPERATURE)

    def effective_clearance(self, temperature: Any) -> Any:
        return np.maximum(self.clearance_at(temperature), 0.0)

    def diameter(self, effective_clearance: Any, profile: Profile) -> Any:
        return self.spool_diameter + effective_clearance if profile.diameter == "mean" else self.spool_diameter

    def polynomial(self, profile: Profile) -> np.ndarray:
        """π D c³/12l as ascending coefficients of (T − T₀), shape (5,)."""
        c, rate = self.clearance, self.thermal_rate
        cube = (c**3, 3.0 * c**2 * rate, 3.0 * c * rate**2, rate**3, 0.0)
        diameter, growth = self.diameter(c, profile), rate if profile.diameter == "mean" else 0.0
        factor = np.pi / (12.0 * self.contact_length)
        return np.array(
            [factor * (here * diameter + before * growth) for here, before in zip(cube, (0.0, *cube[:4]), strict=True)]
        )

    @cached_property
    def drop(self) -> tuple[tuple[str, float], ...]:
        """The pressure drop as coefficients of the section pressures."""
        coefficients = dict.fromkeys(SECTIONS, 0.0)
        for end, sign in ((self.gap.high, 1.0), (self.gap.low, -1.0)):
            if end.section is not None:
                coefficients[end.section] += sign * end.coefficient
        return tuple((section, value) for section, value in coefficients.items() if value)

    @cached_property
    def direction(self) -> tuple[tuple[str, float], ...]:
        """The drop divided by the size of its first coefficient, so that 0.9 p_g and 0.5 p_g share one."""
        scale = abs(self.drop[0][1])
        return tuple((section, round(value / scale, 12)) for section, value in self.drop)


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
        lands = [state.land for state in self.clearances]
        rates = clearance_equations.thermal_rate(
            np.array([state.sleeve_diameter for state in self.clearances]),
            np.array([state.spool_diameter for state in self.clearances]),
            np.array([land.body_expansion for land in lands]),
            np.array([land.spool_expansion for land in lands]),
        )
        states = {state.land.key: (state, rate) for state, rate in zip(self.clearances, rates.tolist(), strict=True)}
        every = self.profile.pump_draw == "all_gaps"
        return tuple(
            _GapGeometry(
                gap=gap,
                spool_diameter=state.spool_diameter,
                contact_length=state.land.contact_length,
                clearance=state.radial_clearance,
                thermal_rate=rate,
                drawn=every or gap.into_sump,
            )
            for gap in self.controller.gaps
            for state, rate in [states[gap.key]]
        )

    def dynamic_viscosity(self, temperature: Any) -> Any:
        """μ [Pa·s] by the profile's viscosity model; NaN outside the fluid's data."""
        return self.fluid.dynamic_viscosity(temperature, self.profile.viscosity)

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
        drop = float(sum(value * pressures[section] for section, value in geometry.drop))
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

    def _flow(self, drop: Any, diameter: Any, clearance: Any, viscosity: Any, density: Any, length: float) -> Any:
        eccentric = _eccentric(self.profile)
        if self.profile.entry_loss:
            return eccentric * gap_equations.entry_loss_flow(drop, diameter, clearance, viscosity, density, length)
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
            pump.displacement, pump.slip_coefficient, main_pressure, self.dynamic_viscosity(temperature)
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
        self, main_pressure: Any, converter_pressure: Any, temperature: Any, gear: Any, *, sections: bool = False
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
        arrays = [np.asarray(array, dtype=float) for array in (main_pressure, converter_pressure, temperature, gear)]
        size = np.broadcast_shapes(*(array.shape for array in arrays), (1,))[0]
        log = _Log(*(np.broadcast_to(array, (size,)) for array in arrays))
        found = LeakageSeries(np.empty(size), {name: np.empty(size) for name in SECTIONS} if sections else {})
        scratch = np.ones((8, min(_CHUNK, size)))  # taken once: fresh memory costs more than the sums
        for start in range(0, size, _CHUNK):
            part = slice(start, start + _CHUNK)
            self._evaluate(log.part(part), found.part(part), found, scratch[:, : size - start])
        return found

    def _evaluate(self, log: _Log, target: LeakageSeries, count: LeakageSeries, scratch: np.ndarray) -> None:
        """Fill ``target`` with the flows of one chunk and add to the counts."""
        viscous = self.dynamic_viscosity(log.temperature)
        powers, lines = scratch[:5], scratch[5:]  # μ·q = (p_g, p_k, 1) · lines
        _powers(log.temperature, powers)
        span = _span(log.temperature)
        ready: dict[int | None, tuple[_Plan, np.ndarray | None]] = {}
        later = []
        for number, samples in _by_gear(log.gear):
            if number not in self._plans:
                lines[:, samples] = np.nan
                viscous[samples] = 1.0  # left out for its gear, not for its temperature too
                if number is not None:
                    count.other_gear += log.gear[samples].size
                continue
            if number not in ready:
                plan = self._plans[number].within(span)
                ready[number] = plan, None if target.sections else self._affine(plan, log)
            plan, affine = ready[number]
            if affine is None:
                later.append((plan, samples))
                lines[:, samples] = 0.0
            elif isinstance(samples, slice):  # a view: nothing is copied
                np.matmul(affine, powers[:, samples], out=lines[:, samples])
            else:
                lines[:, samples] = affine @ powers[:, samples]
        lines[0] *= log.main_pressure
        lines[1] *= log.converter_pressure
        lines[0] += lines[1]
        lines[0] += lines[2]
        np.divide(lines[0], viscous, out=target.total)
        for flow in target.sections.values():
            flow[:] = target.total
        for plan, samples in later:
            part = log.part(samples)
            target.put(samples, *self._flows(plan, part, viscous[samples], powers[:, samples], count))
        # μ is NaN outside the fluid's data, and only there or where there is no temperature: one sum tells whether
        if np.isnan(viscous.sum()):
            count.outside_fluid += int(np.count_nonzero(np.isnan(viscous) & np.isfinite(log.temperature)))

    @cached_property
    def _plans(self) -> dict[int, _Plan]:
        """How each gear is evaluated."""
        drawn = [geometry for geometry in self._geometries if geometry.drawn]
        return {
            gear: _Plan.of([g for g in drawn if gear in g.gap.gears], self.profile) for gear in self.controller.gears
        }

    def _affine(self, plan: _Plan, log: _Log) -> np.ndarray | None:
        """μ·q as (p_g, p_k, 1) · M · (1, τ, … τ⁴), shape of M (3, 5).

        Section pressures are affine in p_g between their limits, and so are the drops. None where, within the range of
        pressures of these samples, a limit begins, a drop turns negative or a pressure is missing: then the drops are
        computed one by one.
        """
        (low, high), (low_k, high_k) = log.pressure_range
        lines = {"p_g": (1.0, 0.0, 0.0), "p_k": (0.0, 1.0, 0.0)}
        for name in ("p_s", "p_m"):
            line = self.controller.relations[name].line_between(low, high)
            if line is None:
                return None
            lines[name] = (line[0], 0.0, line[1])
        piece = plan.piece(tuple(lines.items()))
        if piece is None:
            return None
        for main, converter, constant in piece.drops:
            least = main * (low if main > 0.0 else high) + converter * (low_k if converter > 0.0 else high_k) + constant
            if not least >= 0.0:
                return None
        return piece.matrix

    def _flows(
        self, plan: _Plan, log: _Log, viscous: np.ndarray, powers: np.ndarray, count: LeakageSeries
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Total and sections, from the drop of every group and of every gap on its own."""
        pressures = self.controller.section_pressures(log.main_pressure, log.converter_pressure)
        sections = {name: np.zeros(len(viscous)) for name in SECTIONS}
        reversed_: dict[str, np.ndarray] = {}

        def drop_of(section: str, direction: Iterable[tuple[str, float]]) -> np.ndarray:
            drop = sum(pressures[name] * factor for name, factor in direction)
            if not np.min(drop) >= 0.0:  # negative somewhere, or not a number
                below = drop < 0.0
                reversed_[section] = reversed_[section] | below if section in reversed_ else below
            return np.maximum(drop, 0.0)

        for group, geometry in zip(plan.groups, plan.matrix @ powers if plan.groups else (), strict=True):
            geometry *= drop_of(group.section, group.drop)
            geometry /= viscous
            sections[group.section] += geometry
        for single in plan.alone:
            clearance = single.effective_clearance(log.temperature)
            density = self.fluid.density(log.temperature, self.profile.viscosity)
            sections[single.gap.section] += self._flow(
                drop_of(single.gap.section, single.drop),
                single.diameter(clearance, self.profile),
                clearance,
                viscous / density,
                density,
                single.contact_length,
            )
        for section, below in reversed_.items():
            count.reversed_samples[section] += int(np.count_nonzero(below))
        total = sum(sections.values())
        if np.isnan(total.sum()):
            for flow in sections.values():
                flow[np.isnan(total)] = np.nan
        return total, sections


@dataclass(frozen=True)
class _Log:
    """The channels of a log, or of a part of one; all of one length."""

    main_pressure: np.ndarray
    converter_pressure: np.ndarray
    temperature: np.ndarray
    gear: np.ndarray

    def part(self, samples: Any) -> _Log:
        return _Log(
            self.main_pressure[samples], self.converter_pressure[samples], self.temperature[samples], self.gear[samples]
        )

    @cached_property
    def pressure_range(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Lowest and highest p_g and p_k; NaN where a sample is missing."""
        channels = (self.main_pressure, self.converter_pressure)
        return tuple((float(channel.min()), float(channel.max())) for channel in channels)  # type: ignore[return-value]


@dataclass(frozen=True)
class _Piece:
    """A plan where every section pressure is affine in (p_g, p_k, 1)."""

    drops: tuple[tuple[float, float, float], ...]  # of every group
    matrix: np.ndarray  # shape (3, 5)


@dataclass(frozen=True)
class _Plan:
    """How one gear is evaluated: groups by polynomial, the rest gap by gap."""

    geometries: tuple[_GapGeometry, ...]
    profile: Profile
    groups: tuple[_Group, ...]
    alone: tuple[_GapGeometry, ...]

    @classmethod
    def of(cls, geometries: Iterable[_GapGeometry], profile: Profile, alone: Sequence[_GapGeometry] = ()) -> _Plan:
        geometries = tuple(geometry for geometry in geometries if geometry.drop)
        if profile.entry_loss:
            return cls(geometries, profile, (), geometries)
        polynomials: dict[tuple[str, tuple[tuple[str, float], ...]], np.ndarray] = {}
        eccentric = _eccentric(profile)
        for geometry in geometries:
            if any(geometry is single for single in alone):
                continue
            key = (geometry.gap.section, geometry.direction)
            scale = eccentric * abs(geometry.drop[0][1])
            polynomials[key] = polynomials.get(key, 0.0) + scale * geometry.polynomial(profile)
        groups = tuple(_Group(*key, polynomial) for key, polynomial in polynomials.items())
        return cls(geometries, profile, groups, tuple(alone))

    def within(self, span: tuple[float, float]) -> _Plan:
        """This plan, or between these temperatures one that takes the gaps that close there on their own."""
        cold, rate = self._clearances
        if self.profile.entry_loss or all((cold + rate * (at - REFERENCE_TEMPERATURE)).min() > 0.0 for at in span):
            return self
        closing = [g for g in self.geometries if min(g.clearance_at(at) for at in span) <= 0.0]
        return _Plan.of(self.geometries, self.profile, closing)

    @cached_property
    def _clearances(self) -> np.ndarray:
        return np.array([(g.clearance, g.thermal_rate) for g in self.geometries] or [(1.0, 0.0)]).T

    @cached_property
    def matrix(self) -> np.ndarray:
        return np.stack([group.polynomial for group in self.groups])

    @cached_property
    def _pieces(self) -> dict[Any, _Piece]:
        return {}

    def piece(self, lines: tuple[tuple[str, tuple[float, float, float]], ...]) -> _Piece | None:
        """The plan with section pressures as lines in (p_g, p_k, 1); None where gaps are computed on their own."""
        if self.alone or not self.groups:
            return None
        if lines not in self._pieces:
            coefficients = {name: np.array(line) for name, line in lines}
            drops = [sum(factor * coefficients[name] for name, factor in group.drop) for group in self.groups]
            self._pieces[lines] = _Piece(tuple(map(tuple, drops)), np.array(drops).T @ self.matrix)
        return self._pieces[lines]


def _powers(temperature: np.ndarray, out: np.ndarray) -> None:
    """τ, … τ⁴ as the rows after the first, with τ = T − T₀."""
    np.subtract(temperature, REFERENCE_TEMPERATURE, out=out[1])
    np.multiply(out[1], out[1], out=out[2])
    np.multiply(out[2], out[1], out=out[3])
    np.multiply(out[2], out[2], out=out[4])


def _span(temperature: np.ndarray) -> tuple[float, float]:
    span = float(temperature.min()), float(temperature.max())
    if np.isnan(span[0]):
        finite = temperature[np.isfinite(temperature)]
        return _span(finite) if finite.size else (REFERENCE_TEMPERATURE,) * 2
    return span


def _by_gear(gear: np.ndarray) -> Iterator[tuple[int | None, Any]]:
    """(gear, samples) of a chunk: a slice for each run of one gear or, where they are many, a mask for each gear."""
    starts = np.flatnonzero(gear[1:] != gear[:-1]) + 1
    if len(starts) <= _RUNS:
        bounds = [0, *starts.tolist(), len(gear)]
        for start, stop in pairwise(bounds):
            yield _gear_number(gear[start]), slice(start, stop)
        return
    for number in np.unique(gear):  # several NaN are one
        yield _gear_number(number), np.isnan(gear) if np.isnan(number) else gear == number


def _gear_number(value: float) -> int | None:
    """The gear as the plans name it; None where it is not known."""
    return None if np.isnan(value) else int(value) if value.is_integer() else -1


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
