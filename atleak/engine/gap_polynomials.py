"""Write gaps as polynomials in temperature, so that a log costs the same for many gaps as for one.

The clearance of a gap is linear in temperature, ``c = c_r + a τ`` with ``τ = T − T₀``, and so is its diameter D where
that is the mean one. Hence ``π D c³ / 12 l`` is a polynomial of degree 4, and the conductance of the gap is that
polynomial over the dynamic viscosity. Gaps that close, or lose pressure at their entry, leave it: they are computed on
their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
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

    Parameters
    ----------
    largest_drops
        [Pa] of each gap over the log.
    temperature
        lowest and highest of the log [°C].
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
