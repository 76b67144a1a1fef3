"""Compute gaps and circuits over a log, so that many gaps cost the same as one.

The clearance of a gap is linear in temperature, ``c = c_r + a τ`` with ``τ = T − T₀``, and so is its diameter D where
that is the mean one. Hence ``π D c³ / 12 l`` is a polynomial of degree 4, and the conductance of the gap is that
polynomial over the dynamic viscosity. Gaps that close, or lose pressure at their entry, are computed on their own.

Main pressure is the measured one: what the pump holds is not asked. The network of one gear is that of
`atleak.engine.leakage` with arrays for numbers, and the same solver solves it. Gaps between the same two pressures are
one branch, and the samples of a gear are worked through in parts that fit the processor's cache.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Gap
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine import network as circuits
from atleak.engine import restrictions
from atleak.engine.balance import Balance
from atleak.engine.leakage import GapGeometry, GapLaw, LeakageModel
from atleak.equations.clearance import effective_clearance

DEGREES = 5  # coefficients, of τ⁰ … τ⁴
ENTRY_LOSS_LEFT_OUT = 0.01  # part of a gap's flow [-] up to which ``auto`` leaves the entry loss out over a whole log


def polynomial(geometry: GapGeometry, law: GapLaw, share: float = 1.0) -> tuple[float, ...]:
    """Return the coefficients of τ⁰ … τ⁴ of a share of μ times the gap's conductance [m³]."""
    c, a = geometry.radial_clearance, geometry.thermal_rate
    m2, m3 = geometry.form_moments if law.counts_form else (0.0, 0.0)
    even = (c**3, 3.0 * c**2 * a, 3.0 * c * a**2, a**3, 0.0)  # cube of c + a τ
    uneven = (3.0 * c * m2 + m3, 3.0 * a * m2, 0.0, 0.0, 0.0)  # what the form of the gap adds to it
    cube = tuple(one + other for one, other in zip(even, uneven, strict=True))
    diameter, growth = law.diameter(geometry.spool_diameter, c), law.diameter(0.0, a)  # of diameter + growth τ
    factor, scale = math.pi / (12.0 * geometry.contact_length), law.eccentricity_factor * share
    before = (0.0, *cube[:4])
    return tuple(scale * (factor * (here * diameter + low * growth)) for here, low in zip(cube, before, strict=True))


def powers(temperature: np.ndarray, out: np.ndarray) -> None:
    """Write τ, … τ⁴ as the rows after the first, with τ = T − T₀; temperature in °C, shape (samples,)."""
    np.subtract(temperature, REFERENCE_TEMPERATURE, out=out[1])
    np.multiply(out[1], out[1], out=out[2])
    np.multiply(out[2], out[1], out=out[3])
    np.multiply(out[2], out[2], out=out[4])


def follows_polynomial(gaps: Sequence[GapGeometry], law: GapLaw, lowest: float, highest: float) -> np.ndarray:
    """Return which gaps follow their polynomials at both ends of a range of temperature [°C], and so all through it.

    One does as long as it is open and, where it is not the same all around, leaks more than its mean clearance would.
    """
    clearance = _clearances(gaps, lowest, highest)
    follows: Any = clearance > 0.0
    if law.counts_form:
        m2, m3 = _moments(gaps)
        follows &= 3.0 * clearance * m2 + m3 >= 0.0
    return follows.all(axis=0)


def without_entry_loss(
    model: LeakageModel, gaps: Sequence[GapGeometry], largest_drops: np.ndarray, temperature: np.ndarray
) -> list[bool]:
    """Return which gaps are computed without entry loss over a whole log.

    ``largest_drops`` [Pa] are those of each gap over the log, ``temperature`` its lowest and highest [°C].
    """
    if model.profile.entry_loss != "auto":
        return [model.law.linear] * len(gaps)
    kind = model.profile.viscosity
    inside = np.clip(temperature, *model.fluid.span(kind))
    viscosity = np.min(model.fluid.kinematic_viscosity(inside, kind))
    density = np.min(model.fluid.density(inside, kind))
    widest = model.law.flow_clearance(np.max(_clearances(gaps, *inside), axis=0), *_moments(gaps))
    lengths = np.array([gap.contact_length for gap in gaps])
    loss = model.law.entry_loss(largest_drops, widest, viscosity, density, lengths)
    return (loss < ENTRY_LOSS_LEFT_OUT).tolist()


def _clearances(gaps: Sequence[GapGeometry], lowest: float, highest: float) -> np.ndarray:
    """Return the mean clearance [m] of each gap at both ends of a range of temperature [°C], shape (2, gaps)."""
    cold = np.array([gap.radial_clearance for gap in gaps])
    rate = np.array([gap.thermal_rate for gap in gaps])
    return effective_clearance(cold, rate, np.array([[lowest], [highest]]) - REFERENCE_TEMPERATURE)


def _moments(gaps: Sequence[GapGeometry]) -> np.ndarray:
    """Return the second [m²] and third [m³] moment of each gap, shape (2, gaps)."""
    return np.array([gap.form_moments for gap in gaps]).reshape(-1, 2).T


_PART = 8192  # samples worked on at a time


#: Of some samples: the balance of the circuits, what is drawn from the pump by the section or circuit that it leaves
#: [m³/s], and by section where the drop of a gap is negative and leaks nothing; arrays of shape (samples,).
_Flows = tuple[Balance, dict[str, Any], dict[str, np.ndarray]]
_Joined = tuple[Gap, bool, np.ndarray]  # gaps between the same two pressures: one for all, and their polynomials' sum


@dataclass(frozen=True)
class CircuitLog:
    """All of a unit that does not follow from the pressures of the sections alone, ready for any sample of a log."""

    model: LeakageModel
    assumed: OperatingPoint  # whose set pressures hold, where they do not go by gear
    in_sums: tuple[GapGeometry, ...]  # gaps that follow their polynomials all through the log
    alone: tuple[GapGeometry, ...]  # the others

    @classmethod
    def of(
        cls, model: LeakageModel, assumed: OperatingPoint, highest: float, temperature: np.ndarray
    ) -> CircuitLog | None:
        """Prepare a log; None for a unit that has nothing of the kind.

        Parameters
        ----------
        highest
            pressure of any section in the log [Pa].
        temperature
            lowest and highest of the log [°C].
        """
        controller = model.controller
        gaps = [geometry for geometry in model.geometries if not geometry.follows_sections]
        if not (gaps or controller.circuits or controller.leaks):
            return None
        if not gaps:
            return cls(model, assumed, (), ())
        inside = np.clip(temperature, *model.fluid.span(model.profile.viscosity))
        joined = np.array(without_entry_loss(model, gaps, np.full(len(gaps), highest), temperature), bool)
        joined &= follows_polynomial(gaps, model.law, *inside)
        in_sums, alone = (
            tuple(gap for gap, chosen in zip(gaps, joined.tolist(), strict=True) if chosen is kind)
            for kind in (True, False)
        )
        return cls(model, assumed, in_sums, alone)

    def _joined(self, gear: int) -> list[_Joined]:
        """Return the gaps of a gear that follow their polynomials, added up where drawn from the pump alike."""
        sums: dict[Any, _Joined] = {}
        for geometry in self.in_sums:
            gap, counts = geometry.gap, geometry.drawn_from_pump
            if gear in gap.gears:
                key = gap.high, gap.low, gap.into_sump, counts
                first, _, before = sums.get(key, (gap, counts, np.zeros(DEGREES)))
                sums[key] = first, counts, before + np.array(polynomial(geometry, self.model.law))
        return list(sums.values())

    def parts(
        self, gear: int, samples: np.ndarray, main_pressure: np.ndarray, converter: np.ndarray, temperature: np.ndarray
    ) -> Iterator[tuple[np.ndarray, _Flows]]:
        """Solve some samples of one gear, in parts: yield which samples and what flows there.

        Parameters
        ----------
        samples
            numbers of the samples, of which every channel is a number and within the fluid's data.
        main_pressure, converter, temperature
            of the whole log [Pa, Pa, °C], shape (samples,).
        """
        joined = self._joined(gear)
        for start in range(0, len(samples), _PART):
            part = samples[start : start + _PART]
            yield part, self._flows(gear, joined, main_pressure[part], converter[part], temperature[part])

    def _flows(
        self, gear: int, joined: list[_Joined], main: np.ndarray, converter: np.ndarray, temperature: np.ndarray
    ) -> _Flows:
        model = self.model
        dynamic = model.dynamic_viscosity(temperature)
        density = model.fluid.density(temperature, model.profile.viscosity)
        kinematic = dynamic / density
        rises = np.ones((DEGREES, len(temperature)))
        powers(temperature, rises)
        gaps = [(gap, restrictions.GapBranch(summed @ rises / dynamic), counts) for gap, counts, summed in joined]
        for geometry in self.alone:
            if gear in geometry.gap.gears:
                mean = geometry.effective_clearance(temperature)
                clearance = model.law.flow_clearance(mean, *geometry.form_moments)
                factors = model.law.diameter(geometry.spool_diameter, mean), clearance, kinematic, density
                restriction = model.law.restriction(*factors, geometry.contact_length)
                gaps.append((geometry.gap, restriction, geometry.drawn_from_pump))
        point, solves = replace(self.assumed, gear=gear), model.profile.circuits == "on"
        network = circuits.network(model.controller, point, gaps, kinematic, density, solves=solves)
        sections = model.controller.section_pressures(main, converter)
        balance = network.balance({name: np.maximum(pressure, 0.0) for name, pressure in sections.items()})
        names = (*SECTIONS, *(circuit.id for circuit in model.controller.circuits))
        drawn: dict[str, Any] = dict.fromkeys(names, 0.0)
        for branch in network.branches:
            if branch.counts:
                section = branch.high.section or ""
                drawn[section] = drawn[section] + network.flow(branch, balance.pressures)
        for name, relief in balance.relief.items():
            drawn[name] = drawn[name] + relief
        return balance, drawn, _reversed(network, balance)


def _reversed(network: circuits.Network, balance: Balance) -> dict[str, np.ndarray]:
    """Return by section where a gap's drop is negative, so that it leaks nothing; vented circuits have none."""
    found: dict[str, np.ndarray] = {}
    for branch in network.lands:
        section = branch.high.section or ""
        if section in network.vented or restrictions.leaks_both_ways(branch, network.solved):
            continue
        drop = branch.drop(balance.pressures)
        if np.min(drop) < 0.0:
            found[section] = found.get(section, False) | (drop < 0.0)
    return found
