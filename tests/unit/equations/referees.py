"""Published equations and closed forms that no job is computed with: tests hold the product's equations against them.

SI units throughout. They check nothing of what they are given. Equation numbers are those of Dziubak & Szczepaniak,
Energies 2023, 16, 7667.
"""

from __future__ import annotations

import decimal
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.linalg import spsolve

from atleak.equations.statistics import normal_cdf, normal_quantile


def effective_clearance_two_temperatures(
    c_r: float, sleeve: float, spool: float, beta_k: float, beta_s: float, body_rise: float, spool_rise: float
) -> float:
    """Compute the radial clearance [m] with body and spool at temperatures of their own, eq. (2).

    ``c_re = c_r + (β_k D ΔT_k − β_s d ΔT_s) / 2``; rises over the temperature of the measurement [K].
    """
    return c_r + 0.5 * (beta_k * sleeve * body_rise - beta_s * spool * spool_rise)


def annular_flow_compressible(
    pressure_drop: float, d: float, c: float, viscosity: float, length: float, mean_density: float, density: float
) -> float:
    """Compute the leakage [m³/s] of a fluid whose density depends on pressure, eq. (3).

    ``π Δp d c³ ρ(p̄) / (12 μ l ρ(0))``; the article's μ in Pa·s stands beside a factor that closes only for mPa·s.
    """
    return math.pi * pressure_drop * d * c**3 / (12.0 * viscosity * length) * (mean_density / density)


def exact_annulus_flow(pressure_drop: float, spool: float, sleeve: float, viscosity: float, length: float) -> float:
    """Compute the laminar flow [m³/s] through a concentric annulus of any thickness.

    ``π Δp / (8 μ l) · [r_o⁴ − r_i⁴ − (r_o² − r_i²)² / ln(r_o/r_i)]``, in 60 decimal digits: a thin gap takes all of a
    float's. Bird, Stewart, Lightfoot, Transport Phenomena, 2nd ed., Wiley 2002, section 2.4.
    """
    with decimal.localcontext() as context:
        context.prec = 60
        r_i, r_o = decimal.Decimal(spool) / 2, decimal.Decimal(sleeve) / 2
        bracket = r_o**4 - r_i**4 - (r_o**2 - r_i**2) ** 2 / (r_o / r_i).ln()
        return math.pi * pressure_drop / (8.0 * viscosity * length) * float(bracket)


def flow_of_strips(drop: float, d: float, h: Any, nu: float, rho: float, length: float, loss: float = 1.5) -> float:
    """Compute the flow [m³/s] through a gap of thickness ``h`` around a bore, every strip by itself.

    Each solves ``Δp = 12 ν ρ l u / h² + K ρ u² / 2``; nothing flows from one to the next.
    """
    friction = 12.0 * nu * rho * length / np.maximum(h, 1e-12) ** 2
    return math.pi * d * float(np.mean(h * 2.0 * drop / (friction + np.sqrt(friction**2 + 2.0 * loss * rho * drop))))


def flow_around(
    drop: float, d: float, thickness: Callable[[Any], Any], nu: float, rho: float, length: float, loss: float = 1.5
) -> float:
    """Compute the same with flow around the spool: Reynolds' equation over the unrolled half of a gap.

    At every place of the entrance K velocity heads are lost. Finite volumes, Newton's steps; ``thickness`` [m] of the
    angle is the same on both sides of zero.
    """
    angles, rows = 48, 16
    step, along = math.pi / angles, length / rows
    h, across = thickness((np.arange(angles) + 0.5) * step), 0.5 * d * step
    down = sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(rows, rows)).tolil()
    down[0, 0], down[-1, -1] = 1.0, 3.0  # nothing but the inflow, and half a cell to the outlet
    apart = sparse.diags([-1.0, 1.0], [0, 1], shape=(angles - 1, angles))
    aside = apart.T @ sparse.diags(thickness(np.arange(1, angles) * step) ** 3) @ apart
    conducts = sparse.kron(sparse.diags(h**3 * across / along), down) + sparse.kron(
        aside * (along / across), sparse.eye(rows)
    )
    conducts = (conducts / (12.0 * nu * rho)).tocsc()
    first, friction = np.arange(angles) * rows, 6.0 * nu * rho * along / h**2  # of half a cell
    pressure, inflow, slope = np.zeros((3, angles * rows))
    for _ in range(30):
        left = drop - pressure[first]
        root = np.sqrt(friction**2 + 2.0 * loss * rho * np.abs(left))
        inflow[first], slope[first] = h * across * 2.0 * left / (friction + root), h * across / root
        change = spsolve(conducts + sparse.diags(slope), inflow - conducts @ pressure)
        pressure += change
        if np.max(np.abs(change)) < 1e-8 * drop:
            return 2.0 * float(np.sum(inflow))
    raise ArithmeticError("no balance found")


def spool_balance(
    p_s: float, p_g: float, force: float, a_1: float, a_2w: float, a_3w: float, a_g1: float, a_g2: float
) -> float:
    """Compute what is left of the forces [N] on the spool of valve 17, eq. (6) to (8); zero in equilibrium."""
    return p_s * (a_1 - a_2w + a_3w) - p_g * (a_g1 - a_g2) - force


def wilson_efficiency(slip: float, pressure: float, viscosity: float, speed: float) -> float:
    """Compute the volumetric efficiency of a pump with laminar slip, ``η_v = 1 − C_s Δp / (μ ω)``, ``ω = 2 π n``.

    Not clipped: zero or below means that the pump cannot hold this pressure at this speed. Wilson W. E.,
    Positive-Displacement Pumps and Fluid Motors, Pitman 1950.
    """
    return 1.0 - slip * pressure / (2.0 * math.pi * viscosity * speed)


def walther(temperature: Any) -> Any:
    """Compute ν [m²/s] by ASTM D341 of a fluid of 42 and 7.0 mm²/s at 40 and 100 °C, as HIPOL ATF IID is."""
    ends = [math.log10(math.log10(nu + 0.7)) for nu in (42.0, 7.0)]
    logs = [math.log10(t + 273.15) for t in (40.0, 100.0)]
    slope = (ends[1] - ends[0]) / (logs[1] - logs[0])
    return (10.0**10.0 ** (ends[0] + slope * (np.log10(temperature + 273.15) - logs[0])) - 0.7) * 1e-6


def normal_density(z: ArrayLike) -> Any:
    """Compute the density of the standard normal distribution."""
    return np.exp(-0.5 * np.square(z)) / math.sqrt(2.0 * math.pi)


def correlated_sum(u: ArrayLike, correlation: float) -> float:
    """Compute the standard uncertainty of a sum whose terms are all correlated alike, JCGM 100:2008 (GUM), eq. (16)."""
    return math.sqrt((1.0 - correlation) * np.sum(np.square(u)) + correlation * np.sum(u) ** 2)


def cube_mean(c: float, s: float) -> float:
    """Compute the mean of the cube of a normal variable of mean c and standard deviation s."""
    return c**3 + 3.0 * c * s**2


def cube_variance(c: float, s: float) -> float:
    """Compute the variance of the cube of a normal variable."""
    return 9.0 * c**4 * s**2 + 36.0 * c**2 * s**4 + 15.0 * s**6


def cube_covariance(c_1: float, s_1: float, c_2: float, s_2: float, correlation: float) -> float:
    """Compute the covariance of the cubes of two normal variables: both in Hermite polynomials, mixed means k! ρᵏ."""
    joint = correlation * s_1 * s_2
    return joint * (9.0 * (c_1**2 + s_1**2) * (c_2**2 + s_2**2) + joint * (18.0 * c_1 * c_2 + 6.0 * joint))


def cube_quantile(probability: float, c: float, s: float) -> float:
    """Compute the quantile of the cube of a normal variable: exact, because the cube rises throughout."""
    return (c + normal_quantile(probability) * s) ** 3


def truncated_cube_moments(c: float, s: float) -> tuple[float, float]:
    """Compute mean and variance of ``max(X, 0)³`` for a normal X: a clearance below zero leaks nothing."""
    below, density = normal_cdf(c / s), normal_density(c / s)
    mean = (c**3 + 3.0 * c * s**2) * below + s * (c**2 + 2.0 * s**2) * density
    square = (c**6 + 15.0 * c**4 * s**2 + 45.0 * c**2 * s**4 + 15.0 * s**6) * below
    square += s * (c**5 + 14.0 * c**3 * s**2 + 33.0 * c * s**4) * density
    return mean, square - mean**2
