"""Compute leakage at one condition: the flow of every gap and of the pump, from clearances, pressures and fluid.

To change the physics read only this file. It calls the published equations of `atleak.equations` and adds nothing but
the order in which they are used:

1. The clearance of a gap grows with temperature (`GapGeometry.effective_clearance`); where it differs around the
   circumference, an even gap that leaks as much stands for it (`GapLaw.flow_clearance`).
2. The pressures before and behind it follow from main and converter pressure (`GapGeometry.pressure_drop`); a negative
   drop leaks nothing.
3. The gap law gives the flow (`GapLaw.flow`), with the fluid's viscosity and density at that temperature.
4. The pump delivers what it displaces less its slip (`PumpFlow.capacity`).

`atleak.engine.series` computes the leakage of every sample of a log by other means, because going through this file for
each gap and each sample would take a hundred times as long. It must give the same numbers:
``tests/unit/engine/test_series.py`` shows whether it does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Gap, Land
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.common.errors import translates_refusals
from atleak.common.printable import brief
from atleak.engine import network as circuits
from atleak.engine import restrictions
from atleak.engine.profile import UNKNOWN, Profile
from atleak.equations import clearance as clearance_equations
from atleak.equations import gap as gap_equations
from atleak.equations import pump as pump_equations

Moments = tuple[float, float]  # second [m²] and third [m³] central moment of a radial clearance


class Clearance(Protocol):
    """The measured, assumed or tried clearance of a land, as far as the engine needs it."""

    @property
    def land(self) -> Land: ...

    @property
    def spool_diameter(self) -> float:
        """Return the mean diameter of the spool [m]."""

    @property
    def sleeve_diameter(self) -> float:
        """Return the mean diameter of the sleeve [m]."""

    @property
    def radial_clearance(self) -> float:
        """Return the cold radial clearance [m], the mean over directions and planes."""

    @property
    def form_moments(self) -> Moments:
        """Return the central moments of the radial clearance over the directions and planes measured."""


@dataclass(frozen=True)
class GapLeakage:
    """One gap at one condition: every factor of its gap law, and the flow."""

    gap: Gap  # as the controller's file describes it
    pressure_drop: float  # [Pa], with its sign: a negative one leaks nothing, or backwards
    leaks_back: bool  # whether it leaks where the drop is negative: between two live sections, one of them solved
    diameter: float  # [m], the one in the gap law
    contact_length: float  # [m]
    effective_clearance: float  # [m], the one in the gap law: of an even gap that leaks as much
    kinematic_viscosity: float  # [m²/s]
    density: float  # [kg/m³]
    leakage: float  # [m³/s], with the spool where the profile takes it to lie
    concentric_leakage: float  # [m³/s], with the spool concentric
    touching_leakage: float  # [m³/s], with the spool touching its bore
    drawn_from_pump: bool  # counts as leakage
    reynolds_number: float  # over 1000 the flow may not be laminar


# --- a gap


@dataclass(frozen=True)
class GapGeometry:
    """A gap with the clearance of its land: the part of its flow that neither pressure nor fluid changes."""

    gap: Gap  # as the controller's file describes it
    spool_diameter: float  # [m]
    contact_length: float  # [m]
    radial_clearance: float  # [m], cold, the mean
    form_moments: Moments  # central moments of its clearance
    thermal_rate: float  # [m/K]
    drawn_from_pump: bool  # counts as leakage

    def effective_clearance(self, temperature: Any) -> Any:
        """Return the mean radial clearance [m] at a temperature [°C]: zero where the spool binds."""
        rise = temperature - REFERENCE_TEMPERATURE
        return clearance_equations.effective_clearance(self.radial_clearance, self.thermal_rate, rise)

    def pressure_drop(self, pressures: Mapping[str, Any]) -> Any:
        """Return the pressure before the gap minus that behind it [Pa] from the pressures of the sections."""
        drop = sum(coefficient * pressures[section] for section, coefficient in self.drop_coefficients)
        return drop - self.gap.low.constant if self.gap.low.constant else drop

    @property
    def follows_sections(self) -> bool:
        """Return whether the drop is in proportion to pressures of sections, so that no circuit has to be solved."""
        ends = (self.gap.high, self.gap.low)
        return not self.gap.low.constant and all(end.section is None or end.section in SECTIONS for end in ends)

    @cached_property
    def drop_coefficients(self) -> tuple[tuple[str, float], ...]:
        """List (section, coefficient) of the pressures that make up the drop: p_g to 0.1 p_g is 0.9 p_g."""
        coefficients = dict.fromkeys(SECTIONS, 0.0)
        for end, sign in ((self.gap.high, 1.0), (self.gap.low, -1.0)):
            if end.section is not None:
                coefficients[end.section] = coefficients.get(end.section, 0.0) + sign * end.coefficient
        return tuple((section, value) for section, value in coefficients.items() if value)


@dataclass(frozen=True)
class GapLaw:
    """The law of the annular gap with the options of a profile: diameter, form, eccentricity and entry loss."""

    profile: Profile

    @property
    def linear(self) -> bool:
        """Return whether the flow is in proportion to the pressure drop and to one over the dynamic viscosity."""
        return self.profile.entry_loss == "off"

    @property
    def counts_form(self) -> bool:
        """Return whether a clearance that differs around the circumference leaks more than its mean."""
        return self.profile.form == "mean_of_cubes"

    @cached_property
    def eccentricity_factor(self) -> float:
        """Compute how much more than a concentric gap every gap leaks by friction alone [-].

        Of a spool of which nobody knows where it lies, this is the mean over all its positions.
        """
        if self.profile.eccentricity == UNKNOWN:
            return gap_equations.MEAN_ECCENTRIC
        return float(gap_equations.eccentricity_factor(self.profile.eccentricity, 1.0))

    def diameter(self, spool_diameter: Any, clearance: Any) -> Any:
        """Return the diameter [m] on which the gap's circumference is taken, from its mean effective clearance [m]."""
        return spool_diameter + clearance if self.profile.diameter == "mean" else spool_diameter

    def flow_clearance(self, clearance: Any, m2: Any, m3: Any) -> Any:
        """Return the clearance [m] that `flow` asks for, from the mean effective clearance and its central moments.

        Where the profile takes the cube of the mean, this is the mean itself.
        """
        if not self.counts_form or not (np.any(m2) or np.any(m3)):
            return clearance
        return gap_equations.flow_equal_clearance(clearance, m2, m3)

    def flow(
        self,
        pressure_drop: Any,
        diameter: Any,
        clearance: Any,
        kinematic_viscosity: Any,
        density: Any,
        contact_length: Any,
        eccentricity_factor: Any = None,
    ) -> Any:
        """Return the volume flow [m³/s]; arguments as those of `atleak.equations.gap.annular_flow`.

        ``eccentricity_factor`` [-] takes the place of the profile's, for spools that lie elsewhere.
        """
        factors = (pressure_drop, diameter, clearance, kinematic_viscosity, density, contact_length)
        eccentric = self.eccentricity_factor if eccentricity_factor is None else eccentricity_factor
        if self.linear:
            return eccentric * gap_equations.annular_flow(*factors)
        return gap_equations.entry_loss_flow(*factors, eccentricity_factor=eccentric)

    def restriction(
        self,
        diameter: Any,
        clearance: Any,
        kinematic_viscosity: Any,
        density: Any,
        contact_length: Any,
        eccentricity_factor: Any = None,
    ) -> restrictions.GapBranch:
        """Return a gap as a restriction of a network: its `flow` at any pressure drop, with the same arguments."""
        factors = (diameter, clearance, kinematic_viscosity, density, contact_length)
        eccentric = self.eccentricity_factor if eccentricity_factor is None else eccentricity_factor
        loss = 0.0 if self.linear else gap_equations.ENTRY_AND_EXIT_LOSS
        return restrictions.GapBranch(*gap_equations.entry_loss_terms(*factors, loss, eccentric))

    def entry_loss(
        self, pressure_drop: Any, clearance: Any, kinematic_viscosity: Any, density: Any, contact_length: Any
    ) -> Any:
        """Return the fraction of the flow by friction alone that the entry loss takes off, computed or not [-]."""
        factors = (1.0, clearance, kinematic_viscosity, density, contact_length)  # no diameter changes it
        eccentric = self.eccentricity_factor
        lossless = eccentric * gap_equations.annular_flow(1.0, *factors)  # per pascal
        lossy = gap_equations.entry_loss_flow(pressure_drop, *factors, eccentricity_factor=eccentric)
        whole = np.where((pressure_drop > 0.0) & (clearance > 0.0), lossless * pressure_drop, 0.0)
        flows = whole > 0.0  # a drop can be so small that nothing flows
        return np.where(flows, 1.0 - lossy / np.where(flows, whole, 1.0), 0.0)


# --- the pump


@dataclass(frozen=True)
class PumpFlow:
    """The flow that the pump delivers, with Wilson's slip or with a constant volumetric efficiency.

    The slip factor and the pump's efficiency may be arrays, as may every argument.
    """

    pump: Pump  # as the controller's file, or a job, has it
    with_slip: bool  # only where the pump has a slip coefficient
    slip_factor: Any = 1.0  # on its slip, where that is uncertain

    @property
    def per_revolution(self) -> Any:
        """Return what the pump delivers in one revolution before slip [m³]."""
        return self.pump.displacement * (1.0 if self.with_slip else self.pump.volumetric_efficiency)

    def slip(self, main_pressure: Any, dynamic_viscosity: Any) -> Any:
        """Return the flow that slips back [m³/s] at any speed; zero where the efficiency is a constant."""
        if not self.with_slip:
            return 0.0
        return self.slip_factor * self.pump.slip(main_pressure, dynamic_viscosity)

    def capacity(self, engine_speed: Any, main_pressure: Any, dynamic_viscosity: Any) -> Any:
        """Return what the pump delivers [m³/s] at an engine speed [1/s]; never below zero."""
        if not self.with_slip:
            return pump_equations.capacity(self.pump.displacement, engine_speed, self.pump.volumetric_efficiency)
        displaced = pump_equations.capacity(self.pump.displacement, engine_speed, 1.0)
        return np.maximum(displaced - self.slip(main_pressure, dynamic_viscosity), 0.0)

    def minimum_speed(self, leakage: Any, main_pressure: Any, dynamic_viscosity: Any) -> Any:
        """Return the lowest engine speed [1/s] at which the pump covers a leakage [m³/s] and its own slip."""
        return pump_equations.minimum_speed(leakage, self.slip(main_pressure, dynamic_viscosity), self.per_revolution)


# --- the whole


class _Factors(NamedTuple):
    """The factors of the gap law at one condition, in its order; arrays have a number for each gap of its gear."""

    diameter: np.ndarray  # [m]
    clearance: np.ndarray  # [m]
    kinematic_viscosity: float  # [m²/s]
    density: float  # [kg/m³]
    length: np.ndarray  # [m]


@brief
@dataclass(frozen=True)
class LeakageModel:
    """A controller with given clearances, a fluid and a profile, ready to be evaluated at any condition.

    Attributes
    ----------
    controller
        whose gaps leak.
    clearances
        of every land, as `atleak.clearances` gives them.
    fluid
        in its state.
    profile
        how to compute; its ``pump_draw`` says which gaps count as leakage: every gap, or those that end in the sump.
    """

    controller: Controller
    clearances: tuple[Clearance, ...]
    fluid: Fluid
    profile: Profile

    @cached_property
    def law(self) -> GapLaw:
        """Return the gap law as the profile has it."""
        return GapLaw(self.profile)

    @cached_property
    def pump(self) -> PumpFlow:
        """Return the pump as the profile counts it: with slip only where the controller states a coefficient."""
        pump = self.controller.pump
        return PumpFlow(pump, self.profile.pump_efficiency == "wilson" and pump.slip_coefficient is not None)

    @cached_property
    def geometries(self) -> tuple[GapGeometry, ...]:
        """List every gap of the controller, in its order, with the clearance of its land."""
        of_lands = {
            state.land.key: (
                state.spool_diameter,
                state.land.contact_length,
                state.radial_clearance,
                state.form_moments,
                state.land.thermal_rate(state.spool_diameter, state.sleeve_diameter),
            )
            for state in self.clearances
        }
        counts_every_gap = self.profile.pump_draw == "all_gaps"
        return tuple(
            GapGeometry(gap, *of_lands[gap.key], counts_every_gap or gap.into_sump) for gap in self.controller.gaps
        )

    def gaps_in(self, gear: int) -> tuple[Gap, ...]:
        """Return the gaps that see a pressure drop in a gear, in the order of `network` and `gaps`.

        Parameters
        ----------
        gear
            the gear engaged.
        """
        return tuple(geometry.gap for geometry in self.geometries if gear in geometry.gap.gears)

    @translates_refusals
    def network(self, condition: OperatingPoint, temperature_c: Any = None) -> circuits.Network:
        """Set up the gaps, leaks and feeds of the condition's gear, with its fluid, as a network.

        Parameters
        ----------
        condition
            the operating point.
        temperature_c
            [°C] in place of the condition's; an array gives a network of arrays.

        Returns
        -------
        Network
            ready to be balanced against the pressures of the sections.

        Raises
        ------
        DomainError
            a temperature outside the fluid's data.
        """
        temperature_c = condition.temperature if temperature_c is None else temperature_c
        factors = self._factors(condition.gear, temperature_c)
        terms = self.law.restriction(*factors)
        stacked = np.broadcast_arrays(terms.conductance, terms.bend)
        rows = [row if row.ndim > 1 else row.tolist() for row in stacked]
        restricted = (restrictions.GapBranch(*each) for each in zip(*rows, strict=True))
        gaps = [
            (geometry.gap, restriction, geometry.drawn_from_pump)
            for geometry, restriction in zip(self._in_gear(condition.gear), restricted, strict=True)
        ]
        solves = self.profile.circuits == "on"
        return circuits.network(
            self.controller, condition, gaps, factors.kinematic_viscosity, factors.density, solves=solves
        )

    def _in_gear(self, gear: int) -> list[GapGeometry]:
        return [geometry for geometry in self.geometries if gear in geometry.gap.gears]

    @cached_property
    def _numbers_by_gear(self) -> dict[int, np.ndarray]:
        return {}

    def _numbers_in(self, gear: int) -> np.ndarray:
        """Return what `_factors` asks of every gap of a gear; shape (6, gaps), and more where clearances are arrays."""
        if gear not in self._numbers_by_gear:
            rows = [
                (each.spool_diameter, each.contact_length, each.radial_clearance, *each.form_moments, each.thermal_rate)
                for each in self._in_gear(gear)
            ]
            if all(isinstance(value, float) for row in rows for value in row):
                numbers = np.array(rows, float).reshape(-1, 6)
            else:
                shape = np.broadcast_shapes(*(np.shape(value) for row in rows for value in row))
                wide = [[np.broadcast_to(value, shape) for value in row] for row in rows]
                numbers = np.array(wide, float).reshape(-1, 6, *shape)
            self._numbers_by_gear[gear] = np.moveaxis(numbers, 1, 0)
        return self._numbers_by_gear[gear]

    @cached_property
    def _last_factors(self) -> dict[tuple[int, float], _Factors]:
        return {}

    def _factors(self, gear: int, temperature: Any) -> _Factors:
        """Return the factors of the gap law of every gap of a gear; gaps come first where temperatures are several.

        Those of one temperature are kept until another one is asked for: one condition asks for them twice.
        """
        if np.ndim(temperature):
            return self._factors_at(gear, temperature)
        if (gear, temperature) not in self._last_factors:
            factors = self._factors_at(gear, temperature)
            self._last_factors.clear()
            self._last_factors[gear, temperature] = factors
        return self._last_factors[gear, temperature]

    def _factors_at(self, gear: int, temperature: Any) -> _Factors:
        viscosity, density = self._fluid_at(temperature)
        numbers = self._numbers_in(gear)
        own = numbers.shape[2:]
        shape = np.broadcast_shapes(np.shape(temperature), own)
        if shape != own:
            numbers = numbers.reshape(*numbers.shape[:2], *(1,) * (len(shape) - len(own)), *own)
            numbers = np.broadcast_to(numbers, (*numbers.shape[:2], *shape))
        spool, length, radial, m2, m3, rate = numbers
        rise = temperature - REFERENCE_TEMPERATURE
        mean = clearance_equations.effective_clearance(radial, rate, rise)
        uneven = (m2 != 0.0) | (m3 != 0.0)
        clearance = np.where(uneven, self.law.flow_clearance(mean, m2, m3), mean)
        return _Factors(self.law.diameter(spool, mean), clearance, viscosity, density, length)

    def _fluid_at(self, temperature: Any) -> tuple[Any, Any]:
        """Return ν [m²/s] and ρ [kg/m³]; DomainError outside the fluid's data."""
        model = self.profile.viscosity
        for end in {float(np.min(temperature)), float(np.max(temperature))}:
            self.fluid.require(end, model)
        return self.fluid.kinematic_viscosity(temperature, model), self.fluid.density(temperature, model)

    def gaps(
        self,
        condition: OperatingPoint,
        pressures: Mapping[str, Any] | None = None,
        network: circuits.Network | None = None,
    ) -> tuple[GapLeakage, ...]:
        """Compute every gap of the condition's gear.

        Parameters
        ----------
        condition
            the operating point.
        pressures
            [Pa] of every section and circuit; as the condition has them unless given.
        network
            that of the condition, where it is at hand.

        Returns
        -------
        tuple of GapLeakage
            in the order of `gaps_in`, with pressure drop [Pa] and leakage [m³/s].

        Raises
        ------
        DomainError
            temperature outside the fluid's data.
        """
        factors, geometries = self._factors(condition.gear, condition.temperature), self._in_gear(condition.gear)
        network = network or self.network(condition)
        if pressures is None:
            sections = self.controller.section_pressures(condition.main_pressure, condition.converter_pressure)
            pressures = network.balance(sections).pressures
        drops = [float(each.pressure_drop(pressures)) for each in geometries]
        both_ways = [restrictions.leaks_both_ways(each.gap, network.solved) for each in geometries]
        driving = [drop if back else max(drop, 0.0) for drop, back in zip(drops, both_ways, strict=True)]
        diameter, clearance, viscosity, density, length = factors
        positions = np.array([self.law.eccentricity_factor, 1.0, gap_equations.FULLY_ECCENTRIC])
        columns = np.array(driving, float)[:, None], diameter[:, None], clearance[:, None], viscosity, density
        flows = self.law.flow(*columns, length[:, None], positions)
        reynolds = gap_equations.reynolds_number(flows[:, 0], diameter, viscosity)
        rows = np.column_stack([diameter, length, clearance, reynolds, flows]).tolist()
        return tuple(
            GapLeakage(
                gap=geometry.gap,
                pressure_drop=drop,
                leaks_back=back,
                diameter=row[0],
                contact_length=row[1],
                effective_clearance=row[2],
                kinematic_viscosity=viscosity,
                density=density,
                leakage=row[4],
                concentric_leakage=row[5],
                touching_leakage=row[6],
                drawn_from_pump=geometry.drawn_from_pump,
                reynolds_number=row[3],
            )
            for geometry, drop, back, row in zip(geometries, drops, both_ways, rows, strict=True)
        )

    def dynamic_viscosity(self, temperature_c: Any) -> Any:
        """Return μ [Pa·s] by the profile's viscosity model; NaN outside the fluid's data.

        Parameters
        ----------
        temperature_c
            [°C], a number or an array.
        """
        return self.fluid.dynamic_viscosity(temperature_c, self.profile.viscosity)

    @translates_refusals
    def pump_capacity(self, engine_speed: Any, main_pressure: Any, temperature_c: Any) -> Any:
        """Compute what the pump delivers, never less than nothing.

        Parameters
        ----------
        engine_speed
            [1/s], a number or an array, as the others.
        main_pressure
            p_g [Pa].
        temperature_c
            [°C]; it and the pressure count only where the profile takes slip.

        Returns
        -------
        float or array
            Q [m³/s]; arrays broadcast.
        """
        return self.pump.capacity(engine_speed, main_pressure, self._viscosity_for_slip(temperature_c))

    def pump_slip(self, main_pressure: Any, temperature_c: Any) -> Any:
        """Return Wilson's slip flow [m³/s], which does not depend on speed.

        Parameters
        ----------
        main_pressure
            p_g [Pa], a number or an array.
        temperature_c
            [°C], likewise.
        """
        return self.pump.slip(main_pressure, self._viscosity_for_slip(temperature_c))

    @property
    def pump_open(self) -> bool:
        """Tell whether the pump may slip more than when new and no clearance that counts says how much."""
        return self.uses_slip and not self.controller.pump.counted.any_known

    @property
    def uses_slip(self) -> bool:
        """Return whether the pump's efficiency follows from slip rather than from a constant."""
        return self.pump.with_slip

    def minimum_speed(self, leakage: float, main_pressure: float, temperature_c: float) -> float:
        """Return the lowest engine speed at which the pump covers a leakage, n_min [1/s].

        Parameters
        ----------
        leakage
            [m³/s].
        main_pressure
            p_g that is to be held [Pa].
        temperature_c
            [°C].
        """
        return float(self.pump.minimum_speed(leakage, main_pressure, self._viscosity_for_slip(temperature_c)))

    def _viscosity_for_slip(self, temperature: Any) -> Any:
        """Compute μ [Pa·s] only where there is slip to compute: over a log it takes longer than all the rest."""
        return self.dynamic_viscosity(temperature) if self.uses_slip else None
