"""Compute flow through the annular gap between a spool and its sleeve (equations 3 to 5) and its closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, refuse, result, values

#: Below this Reynolds number gap flow is laminar for certain [-]: choice of this project, half of the 2000 from which
#: on flow in a duct is commonly taken as turbulent.
LAMINAR_REYNOLDS = 1000.0

#: What the square of the relative eccentricity e/c adds to the flow [-] (Energies 2023, 16, 7667, eq. 5).
ECCENTRIC_GAIN = 1.5

#: How many times the flow of a concentric gap a fully eccentric one has, e = c [-].
FULLY_ECCENTRIC = 1.0 + ECCENTRIC_GAIN

#: The same on average, where e/c is anywhere from 0 to 1 alike likely: the mean of 1 + 1.5 e²/c² [-].
MEAN_ECCENTRIC = 1.0 + ECCENTRIC_GAIN / 3.0

#: Loss of a sharp-edged entrance (0.5) and of an exit (1.0), in velocity heads [-] (White F. M., Fluid Mechanics,
#: 7th ed., McGraw-Hill 2011, section 6.9).
ENTRY_AND_EXIT_LOSS = 1.5

#: Above this radial clearance a gap is free of obliteration [m] (Energies 2023, 16, 7667, assumptions under eq. 5).
FREE_CLEARANCE = 20e-6

#: Below this radial clearance the boundary layer closes a gap [m] (same place).
CLOSED_CLEARANCE = 5e-6


def annular_flow(
    pressure_drop: ArrayLike,
    diameter: ArrayLike,
    clearance: ArrayLike,
    kinematic_viscosity: ArrayLike,
    density: ArrayLike,
    contact_length: ArrayLike,
    eccentricity: ArrayLike = 0.0,
) -> Any:
    """Compute the laminar leakage through a thin annular gap, concentric or eccentric.

    ``q = π Δp d c³ (1 + 1.5 e²/c²) / (12 ν ρ l)``

    Parameters
    ----------
    pressure_drop : float or array
        Pressure before the gap minus pressure behind it [Pa]. A negative drop gives a negative flow.
    diameter : float or array
        Diameter on which the gap's circumference is taken [m]: the spool's in the source study; the mean
        diameter, spool plus radial clearance, is the better approximation.
    clearance : float or array
        Radial clearance [m].
    kinematic_viscosity : float or array
        [m²/s].
    density : float or array
        [kg/m³].
    contact_length : float or array
        Length over which spool and sleeve face each other [m].
    eccentricity : float or array, optional
        Distance between the axes of spool and sleeve [m], 0 … clearance.

    Returns
    -------
    float or ndarray
        Volume flow over the whole circumference [m³/s].

    Raises
    ------
    DomainError
        Negative clearance; eccentricity below zero or above the clearance; diameter, viscosity, density or
        contact length not positive.

    Notes
    -----
    Valid for laminar flow (see `reynolds_number`), a clearance small against the diameter, no entry loss (see
    `entry_loss_flow`) and clearances above 20 µm (see `obliteration`).

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (4) and (5), with μ = ν ρ.

    Examples
    --------
    A land of 10 mm, 30 µm radial clearance, 8 mm long, at 80 °C and 800 kPa, in mm³/s:

    >>> q = annular_flow(800e3, 0.010, 30e-6, 10.93e-6, 783.0, 0.008)
    >>> round(q * 1e9, 1)
    825.9
    >>> round(annular_flow(800e3, 0.010, 30e-6, 10.93e-6, 783.0, 0.008, eccentricity=30e-6) / q, 12)
    2.5
    """
    p = values(pressure_drop)
    d = positive("diameter", diameter, "m")
    c = not_negative("radial clearance", clearance, "m")
    nu = positive("kinematic viscosity", kinematic_viscosity, "m²/s")
    rho = positive("density", density, "kg/m³")
    length = positive("contact length", contact_length, "m")
    e = _eccentricity(eccentricity, c)
    cube = c * (c * c + ECCENTRIC_GAIN * (e * e))
    return result((math.pi / 12.0) * (d * cube / length) * p / (nu * rho))


def eccentricity_factor(eccentricity: ArrayLike, clearance: ArrayLike) -> Any:
    """Compute how much more an eccentric gap leaks than a concentric one, ``1 + 1.5 e²/c²``.

    Parameters
    ----------
    eccentricity : float or array
        Distance between the axes of spool and sleeve [m].
    clearance : float or array
        Radial clearance [m].

    Returns
    -------
    float or ndarray
        Factor on the concentric flow, 1 … 2.5 [-]; 1 for a gap without clearance.

    Raises
    ------
    DomainError
        Negative clearance; eccentricity below zero or above the clearance.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (5).

    Examples
    --------
    >>> eccentricity_factor(15e-6, 30e-6)
    1.375
    """
    c = not_negative("radial clearance", clearance, "m")
    e = _eccentricity(eccentricity, c)
    ratio = e / np.where(c == 0.0, 1.0, c)
    return result(1.0 + ECCENTRIC_GAIN * (ratio * ratio))


def entry_loss_flow(
    pressure_drop: ArrayLike,
    diameter: ArrayLike,
    clearance: ArrayLike,
    kinematic_viscosity: ArrayLike,
    density: ArrayLike,
    contact_length: ArrayLike,
    loss_coefficient: ArrayLike = ENTRY_AND_EXIT_LOSS,
    eccentricity_factor: ArrayLike = 1.0,
) -> Any:
    """Compute the laminar leakage through a thin gap that also spends pressure on accelerating the fluid.

    The mean velocity u solves ``|Δp| = 12 ν ρ l u / (F c²) + K ρ u² / 2``; the flow is ``q = π d c u`` with the
    sign of the pressure drop. F is what eccentricity takes off the viscous resistance.

    Parameters
    ----------
    pressure_drop : float or array
        Pressure before the gap minus pressure behind it [Pa].
    diameter : float or array
        Diameter of the gap [m].
    clearance : float or array
        Radial clearance [m].
    kinematic_viscosity : float or array
        [m²/s].
    density : float or array
        [kg/m³].
    contact_length : float or array
        [m].
    loss_coefficient : float or array, optional
        K, entry and exit together, in velocity heads [-]. Zero gives `annular_flow`.
    eccentricity_factor : float or array, optional
        F, of `eccentricity_factor` [-]; 1 for a concentric gap.

    Returns
    -------
    float or ndarray
        Volume flow [m³/s], never larger than F times that of `annular_flow`, nor than F times this one's with F = 1.

    Raises
    ------
    DomainError
        Negative clearance or loss coefficient; diameter, viscosity, density, contact length or factor not positive.

    Notes
    -----
    Not linear in the pressure drop. Matters for wide, short and hot gaps: with ATF at 100 °C and 45 µm it
    takes about 2 % at 5 mm contact length and 10 % at 2 mm.

    An eccentric gap gains on friction only: where all pressure goes into velocity it leaks as much as a concentric one
    of the same area. The exact loss is not the mean velocity's, as the wide side is quicker: integrated around the
    circumference, the flow of an eccentric gap is up to 12 % lower than this one.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (4), with the loss coefficients of a sharp-edged
    entrance (0.5) and an exit (1.0) of White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, section 6.9.

    Examples
    --------
    >>> long_gap = entry_loss_flow(800e3, 0.010, 30e-6, 10.93e-6, 783.0, 0.008)
    >>> round(long_gap * 1e9, 1)
    825.5
    """
    factors = (diameter, clearance, kinematic_viscosity, density, contact_length, loss_coefficient, eccentricity_factor)
    return restricted_flow(pressure_drop, *entry_loss_terms(*factors))


def entry_loss_terms(
    diameter: ArrayLike,
    clearance: ArrayLike,
    kinematic_viscosity: ArrayLike,
    density: ArrayLike,
    contact_length: ArrayLike,
    loss_coefficient: ArrayLike = ENTRY_AND_EXIT_LOSS,
    eccentricity_factor: ArrayLike = 1.0,
) -> tuple[Any, Any]:
    """Compute what of `entry_loss_flow` no pressure drop changes: the laminar conductance and how the loss bends it.

    ``G = F π d c³ / (12 ν ρ l)`` and ``B = 2 K ρ c⁴ F² / (12 ν ρ l)²``.

    Parameters
    ----------
    diameter, clearance : float or array
        of the gap [m]; the clearance is radial.
    kinematic_viscosity : float or array
        [m²/s].
    density : float or array
        [kg/m³].
    contact_length : float or array
        [m].
    loss_coefficient, eccentricity_factor : float or array, optional
        as those of `entry_loss_flow`.

    Returns
    -------
    tuple of float or ndarray
        G [m³/(s Pa)] and B [1/Pa], for `restricted_flow`; B is zero without a loss.

    Raises
    ------
    DomainError
        as `entry_loss_flow`.

    References
    ----------
    as `entry_loss_flow`.

    Examples
    --------
    >>> conductance, bend = entry_loss_terms(0.010, 30e-6, 10.93e-6, 783.0, 0.008)
    >>> round(conductance * 800e3 * 1e9, 1)
    825.9
    """
    d = positive("diameter", diameter, "m")
    c = not_negative("radial clearance", clearance, "m")
    nu = positive("kinematic viscosity", kinematic_viscosity, "m²/s")
    rho = positive("density", density, "kg/m³")
    length = positive("contact length", contact_length, "m")
    k = not_negative("loss coefficient", loss_coefficient)
    square = c * c
    per_viscous = positive("eccentricity factor", eccentricity_factor) / (12.0 * nu * rho * length)
    ratio = square * per_viscous
    return result(math.pi * d * c * ratio), result((2.0 * k * rho) * (ratio * ratio))


def restricted_flow(pressure_drop: ArrayLike, conductance: ArrayLike, bend: ArrayLike = 0.0) -> Any:
    """Compute the flow through a laminar restriction with entry loss, ``q = 2 G Δp / (1 + √(1 + B |Δp|))``.

    Parameters
    ----------
    pressure_drop : float or array
        Δp [Pa]. A negative drop gives a negative flow.
    conductance : float or array
        G [m³/(s Pa)], of `entry_loss_terms`.
    bend : float or array, optional
        B [1/Pa]; zero gives G Δp.

    Returns
    -------
    float or ndarray
        Volume flow [m³/s]; it rises with the pressure drop everywhere, as `restricted_flow_and_slope` says.

    Raises
    ------
    DomainError
        Negative conductance or bend.

    References
    ----------
    as `entry_loss_flow`: the root of its quadratic, with the sum below the line so that nothing cancels.

    Examples
    --------
    >>> restricted_flow(100e3, 2e-12), restricted_flow(100e3, 2e-12, 3e-5)
    (2e-07, 1.3333333333333334e-07)
    """
    p, g, b = _restriction(pressure_drop, conductance, bend)
    if not b.any():
        return result(g * p)
    root = b * np.abs(p)
    root += 1.0  # in place: drawn thousands of times, every array that is made costs as much as a sum
    root = np.sqrt(root)
    root += 1.0
    flow = g * p
    flow *= 2.0
    return result(flow / root)


def restricted_flow_and_slope(
    pressure_drop: ArrayLike, conductance: ArrayLike, bend: ArrayLike = 0.0, out: Any = (None, None)
) -> Any:
    """Compute `restricted_flow`, and how steeply it rises, ``dq/dΔp = G / √(1 + B |Δp|)``: they share a root.

    Parameters
    ----------
    pressure_drop, conductance, bend : float or array
        as those of `restricted_flow`.
    out : tuple of ndarray, optional
        Two arrays for the result, of its shape, as NumPy's functions take them.

    Returns
    -------
    tuple of float or ndarray
        Volume flow [m³/s], and how steeply it rises [m³/(s Pa)].

    Raises
    ------
    DomainError
        Negative conductance or bend.

    References
    ----------
    as `restricted_flow`, and its derivative by the pressure drop.

    Examples
    --------
    >>> restricted_flow_and_slope(100e3, 2e-12, 3e-5)
    (1.3333333333333334e-07, 1e-12)
    """
    p, g, b = _restriction(pressure_drop, conductance, bend)
    root = np.abs(p, out=out[1])
    root = np.multiply(b, root, out=out[1])
    root += 1.0
    root = np.sqrt(root, out=out[1])
    root += 1.0
    flow = np.multiply(g, p, out=out[0])
    flow *= 2.0
    flow = np.divide(flow, root, out=out[0])
    root -= 1.0
    return result(flow), result(np.divide(g, root, out=out[1]))


def _restriction(pressure_drop: ArrayLike, conductance: ArrayLike, bend: ArrayLike) -> tuple[Any, Any, Any]:
    g = not_negative("conductance", conductance, "m³/(s Pa)")
    return values(pressure_drop), g, not_negative("bend of the entry loss", bend, "1/Pa")


def reynolds_number(flow: ArrayLike, diameter: ArrayLike, kinematic_viscosity: ArrayLike) -> Any:
    """Compute the Reynolds number of the flow through an annular gap, on its hydraulic diameter 2c.

    ``Re = 2 |q| / (π d ν)``: the clearance cancels.

    Parameters
    ----------
    flow : float or array
        Volume flow [m³/s], of either sign.
    diameter : float or array
        Diameter of the gap [m].
    kinematic_viscosity : float or array
        [m²/s].

    Returns
    -------
    float or ndarray
        [-]. Laminar for certain below `LAMINAR_REYNOLDS`.

    Raises
    ------
    DomainError
        Diameter or viscosity not positive.

    References
    ----------
    White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, section 6.8 (noncircular ducts).

    Examples
    --------
    >>> round(reynolds_number(826e-9, 0.010, 10.93e-6), 2)
    4.81
    """
    q = values(flow)
    d = positive("diameter", diameter, "m")
    nu = positive("kinematic viscosity", kinematic_viscosity, "m²/s")
    return result((2.0 / math.pi) * np.abs(q) / (d * nu))


def flow_equal_clearance(clearance: ArrayLike, second_moment: ArrayLike, third_moment: ArrayLike) -> Any:
    """Compute the clearance of the even gap that leaks as much as one whose clearance varies around its mean.

    The mean of c³ is ``c³ + 3 c m₂ + m₃`` with the mean clearance and its central moments; this is its cube root.

    Parameters
    ----------
    clearance : float or array
        Mean radial clearance [m].
    second_moment : float or array
        m₂, mean square of the deviations from it [m²].
    third_moment : float or array
        m₃, mean cube of the deviations from it [m³]; positive where few places are far wider than the rest.

    Returns
    -------
    float or ndarray
        [m], never below the mean clearance, and rising with it.

    Raises
    ------
    DomainError
        Negative clearance or second moment.

    Notes
    -----
    Exact as long as the gap is open everywhere. Where it closes in places the moments count a cube below zero there and
    the result is too low; it is held at the mean clearance, below which a mean of cubes cannot be.

    References
    ----------
    Paths side by side add their flows; the thin-gap law, Dziubak & Szczepaniak, Energies 2023, 16, 7667,
    eq. (4), averaged around the circumference.

    Examples
    --------
    Half of the circumference at 20 µm and half at 40 µm:

    >>> round(flow_equal_clearance(30e-6, 100e-12, 0.0) * 1e6, 3)
    33.019
    """
    c = not_negative("radial clearance", clearance, "m")
    m2 = not_negative("second moment", second_moment, "m²")
    gain = 3.0 * c * m2 + values(third_moment)
    return result(np.cbrt(c * (c * c) + np.maximum(gain, 0.0)))


def obliteration(clearance: ArrayLike) -> Any:
    """Tell whether the boundary layer on the walls closes a gap.

    Parameters
    ----------
    clearance : float or array
        Radial clearance [m].

    Returns
    -------
    str or ndarray of str
        ``"free"`` above 20 µm, ``"partial"`` from 5 to 20 µm, ``"closed"`` below 5 µm, ``""`` for NaN. Both
        limits belong to ``"partial"``, also where subtracting two diameters left a last-digit error.

    Raises
    ------
    DomainError
        Negative clearance.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, the assumptions under eq. (5).

    Examples
    --------
    >>> obliteration(30e-6)
    'free'
    >>> obliteration([4e-6, 5e-6, 20e-6, 21e-6]).tolist()
    ['closed', 'partial', 'partial', 'free']
    """
    c = not_negative("radial clearance", clearance, "m")
    hair = 1e-9
    states = np.select(
        [c > FREE_CLEARANCE * (1.0 + hair), c < CLOSED_CLEARANCE * (1.0 - hair), ~np.isnan(c)],
        ["free", "closed", "partial"],
        default="",
    )
    return str(states) if states.ndim == 0 else states


def _eccentricity(eccentricity: ArrayLike, clearance: Any) -> Any:
    """Return the eccentricity, none below zero and none above the clearance."""
    e = not_negative("eccentricity", eccentricity, "m")
    if e.ndim or e != 0.0:
        refuse("eccentricity", e, e > clearance, "at most the radial clearance", "m")
    return e
