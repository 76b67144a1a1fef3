"""Compute a vacuum test: air that comes in past lands into a plugged circuit, and leaves it through a stand's orifice.

The stand draws at a supply vacuum through an orifice. The pressure in the circuit settles where as much air comes in as
leaves: the wider the gaps, the less vacuum the gauge shows. All pressures are absolute, air is an ideal gas at one
temperature, of R = 287 J/(kg K) and κ = 1.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import above, not_negative, positive, refuse, result, values
from atleak.equations.gap import ENTRY_AND_EXIT_LOSS

GAS_CONSTANT = 287.0  #: R of air [J/(kg K)]
HEAT_RATIO = 1.4  #: κ of air [-]
CHOKED = 0.5283  #: p₂/p₁ at and below which air passes an orifice at the speed of sound [-]
STANDARD_ATMOSPHERE = 101_325.0  #: [Pa]
_ZERO = 273.15  # [K]
_SUTHERLAND = 110.4  # [K]
_HALVINGS = 60  # of a bracketed root: to the last digit of a pressure
_STEPS = 5  # of Newton's method, from below, on a curve that bends once: to the last digit from 2 to 500 µm


def air_viscosity(temperature: ArrayLike) -> Any:
    """Compute the dynamic viscosity of air, ``μ = μ₀ (T/T₀)^1.5 (T₀ + S)/(T + S)``, S = 110.4 K.

    Parameters
    ----------
    temperature : float or array
        [°C], above -100.

    Returns
    -------
    float or ndarray
        μ [Pa·s]; within 2 % from -50 to 200 °C at any pressure of a vacuum test.

    Raises
    ------
    DomainError
        Temperature not above -100 °C.

    References
    ----------
    White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, eq. (1.29) (Sutherland) and table A.4, from which
    μ₀ = 1.81e-5 Pa·s at 20 °C.

    Examples
    --------
    >>> air_viscosity(20.0)
    1.81e-05
    """
    kelvin = _kelvin(temperature)
    at = _ZERO + 20.0
    return result(1.81e-5 * (kelvin / at) * np.sqrt(kelvin / at) * ((at + _SUTHERLAND) / (kelvin + _SUTHERLAND)))


def gap_air_flow(
    pressure: ArrayLike,
    ambient: ArrayLike,
    diameter: ArrayLike,
    clearance: ArrayLike,
    contact_length: ArrayLike,
    temperature: ArrayLike,
    viscosity: ArrayLike,
    eccentricity_factor: ArrayLike = 1.0,
    loss_coefficient: ArrayLike = ENTRY_AND_EXIT_LOSS,
) -> Any:
    """Compute the mass flow of air past a land into a circuit under vacuum, laminar and compressible.

    The mass flux G solves ``p_a² − p² = 24 μ R T l G / (F c²) + K R T G²``; the flow is ``m = π D c G``. Without loss
    it is ``m = F π D c³ (p_a² − p²) / (24 μ R T l)``.

    Parameters
    ----------
    pressure : float or array
        p, in the circuit [Pa].
    ambient : float or array
        p_a [Pa].
    diameter : float or array
        D, of the gap [m].
    clearance : float or array
        c, radial [m]: the cube root of the mean cube where it varies around the circumference.
    contact_length : float or array
        l [m].
    temperature : float or array
        of the air [°C].
    viscosity : float or array
        μ, of the air [Pa·s], of `air_viscosity`.
    eccentricity_factor : float or array, optional
        F [-], 1 for a concentric spool to 2.5 for one that touches its bore.
    loss_coefficient : float or array, optional
        K, entry and exit together, in velocity heads [-].

    Returns
    -------
    float or ndarray
        m [kg/s]; zero where the circuit is at ambient pressure or above.

    Raises
    ------
    DomainError
        Negative pressure, clearance or loss coefficient; ambient pressure, diameter, contact length, viscosity or
        eccentricity factor not positive; temperature not above -100 °C.

    Notes
    -----
    Valid below Re = 2 G c / μ of 2000; a land of 60 µm at a stand's 1 mm reaches 170. The loss takes 2 % of the flow
    from about 30 µm on at 5 mm contact length, 6 % at 60 µm.

    That air slips along walls is neglected. Its mean free path is 0.065 µm at 101 kPa and 0.33 µm at 20 kPa; with slip
    the flow is ``1 + 12 λ_a p_a / (c (p_a + p))`` times this one (first order, λ_a at ambient pressure): 11 % more at
    6 µm and 20 kPa, 6 % at 10 µm, 2 % at 30 µm. So a clearance computed from a flow is up to 3.5 % too large at 6 µm
    (0.2 µm), 2 % at 10 µm and less above: not to the workshop's harm.

    References
    ----------
    White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, sections 4.10 (flow between plates) and 6.9 (losses), with
    ρ = p/(R T) integrated along the gap. Slip: Arkilic E. B., Schmidt M. A., Breuer K. S., J. Microelectromech. Syst. 6
    (1997) 167-178.

    Examples
    --------
    A land of 14.5 mm, 30 µm and 5 mm at 61 kPa, in g/s:

    >>> round(gap_air_flow(61e3, 101325.0, 0.0145, 30e-6, 0.005, 20.0, 1.81e-5) * 1e3, 4)
    0.0432
    """
    p = not_negative("pressure", pressure, "Pa")
    p_a = positive("ambient pressure", ambient, "Pa")
    squares = np.maximum(p_a * p_a - p * p, 0.0)
    d, viscous, k = _gap(diameter, contact_length, temperature, viscosity, loss_coefficient)
    c = not_negative("radial clearance", clearance, "m")
    ease = positive("eccentricity factor", eccentricity_factor) * (c * c)
    flow, _ = _flow_and_root(squares, d, c, ease, viscous, k)
    return result(flow)


def orifice_air_flow(
    pressure: ArrayLike, back_pressure: ArrayLike, flow_area: ArrayLike, temperature: ArrayLike
) -> Any:
    """Compute the mass flow of air through an orifice, choked where the pressure behind it is low enough.

    ``m = C_d A p √(2κ/((κ−1) R T) · (r^(2/κ) − r^((κ+1)/κ)))`` with ``r = max(p_v/p, 0.5283)``.

    Parameters
    ----------
    pressure : float or array
        p, before the orifice [Pa].
    back_pressure : float or array
        p_v, behind it [Pa].
    flow_area : float or array
        C_d A, discharge coefficient times area [m²].
    temperature : float or array
        of the air before the orifice [°C].

    Returns
    -------
    float or ndarray
        m [kg/s]; zero where the pressure behind is as high or higher.

    Raises
    ------
    DomainError
        Negative pressure before or behind; flow area negative; temperature not above -100 °C.

    Notes
    -----
    The discharge coefficient is taken as constant; that of a sharp edge rises from about 0.6 to 0.85 as the flow
    chokes, that of a drilled jet lies near 0.8: which is what calibrating the stand with known orifices settles.

    References
    ----------
    White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, section 9.4, eqs. (9.46) and (9.47).

    Examples
    --------
    An orifice of 1 mm, C_d 0.8, from 61 kPa to 16.7 kPa, in g/s:

    >>> round(orifice_air_flow(61e3, 16.7e3, 0.8 * math.pi / 4 * 1e-6, 20.0) * 1e3, 4)
    0.0905
    """
    p = not_negative("pressure", pressure, "Pa")
    p_v = not_negative("pressure behind the orifice", back_pressure, "Pa")
    area = not_negative("flow area", flow_area, "m²")
    ratio = np.clip(p_v / np.where(p == 0.0, 1.0, p), CHOKED, 1.0)
    root = np.power(ratio, 2.0 / HEAT_RATIO) - np.power(ratio, (HEAT_RATIO + 1.0) / HEAT_RATIO)
    gain = 2.0 * HEAT_RATIO / ((HEAT_RATIO - 1.0) * GAS_CONSTANT * _kelvin(temperature))
    return result(area * p * np.sqrt(gain * np.maximum(root, 0.0)))


def circuit_pressure(
    supply: ArrayLike,
    ambient: ArrayLike,
    flow_area: ArrayLike,
    diameters: ArrayLike,
    clearances: ArrayLike,
    contact_lengths: ArrayLike,
    temperature: ArrayLike,
    viscosity: ArrayLike,
    eccentricity_factors: ArrayLike = 1.0,
    loss_coefficient: ArrayLike = ENTRY_AND_EXIT_LOSS,
) -> Any:
    """Compute the pressure at which as much air comes in past all lands as leaves through the stand's orifice.

    Parameters
    ----------
    supply : float or array
        p_v, behind the stand's orifice [Pa].
    ambient : float or array
        p_a [Pa], above the supply's.
    flow_area : float or array
        C_d A of the stand's orifice [m²].
    diameters, clearances, contact_lengths, eccentricity_factors : float or array
        of the lands, as `gap_air_flow` takes them [m, -]: the first axis counts the lands, a number is one land.
    temperature, viscosity : float or array
        of the air [°C, Pa·s].
    loss_coefficient : float, optional
        K [-] as there.

    Returns
    -------
    float or ndarray
        p [Pa], from p_v without clearance to nearly p_a.

    Raises
    ------
    DomainError
        as `gap_air_flow` and `orifice_air_flow`; ambient pressure not above the supply's; flow area not positive.

    Notes
    -----
    What comes in falls with p and what leaves rises, so there is one root; it is bracketed. Validity as `gap_air_flow`.

    References
    ----------
    as `gap_air_flow` and `orifice_air_flow`; the balance of both.

    Examples
    --------
    Two lands of 20 µm behind an orifice of 1 mm, in in-Hg below ambient, laminar:

    >>> area, supply = 0.8 * math.pi / 4 * 1e-6, 101325.0 - 25 * 3386.39
    >>> lands = [0.0145] * 2, [20e-6] * 2, [0.005] * 2
    >>> p = circuit_pressure(supply, 101325.0, area, *lands, 19.85, 1.81e-5, loss_coefficient=0.0)
    >>> round((101325.0 - p) / 3386.39, 3)
    22.132
    """
    p_v, p_a = _supplied(supply, ambient)
    area = positive("flow area", flow_area, "m²")
    lands = (diameters, clearances, contact_lengths, eccentricity_factors)
    d, c, length, factors = (np.atleast_1d(values(each)) for each in lands)

    def lacking(p: Any) -> Any:
        into = gap_air_flow(p, p_a, d, c, length, temperature, viscosity, factors, loss_coefficient)
        return np.asarray(into).sum(axis=0) - orifice_air_flow(p, p_v, area, temperature)

    return result(_falling_root(lacking, p_v, p_a))


def equal_clearance(
    flow: ArrayLike,
    pressure: ArrayLike,
    ambient: ArrayLike,
    diameters: ArrayLike,
    contact_lengths: ArrayLike,
    temperature: ArrayLike,
    viscosity: ArrayLike,
    eccentricity_factors: ArrayLike = 1.0,
    loss_coefficient: ArrayLike = ENTRY_AND_EXIT_LOSS,
) -> Any:
    """Compute the clearance that lands have which pass a flow of air together, if all have the same.

    Parameters
    ----------
    flow : float or array
        m, that leaves the circuit, of `orifice_air_flow` [kg/s].
    pressure : float or array
        p, that the gauge shows in the circuit [Pa absolute].
    ambient : float or array
        p_a [Pa].
    diameters, contact_lengths, eccentricity_factors : float or array
        of the lands [m, -]: the first axis counts the lands, a number is one land.
    temperature, viscosity : float or array
        of the air [°C, Pa·s].
    loss_coefficient : float, optional
        K [-] of `gap_air_flow`.

    Returns
    -------
    float or ndarray
        c [m], of one land its cube-mean clearance; zero where nothing flows.

    Raises
    ------
    DomainError
        as `gap_air_flow`; negative flow; ambient pressure not above that in the circuit: no gap is wide enough.

    Notes
    -----
    The inverse of the sum of `gap_air_flow`. Without loss it is the cube root of ``24 μ R T m / (π (p_a² − p²))`` over
    ``Σ F D / l``; from there, which is too small, Newton's method on ln m over ln c, of slope 3 (friction) to 1 (loss).

    References
    ----------
    as `gap_air_flow`.

    Examples
    --------
    A reading of 12.30 in-Hg of two lands behind an orifice of 1 mm, in µm:

    >>> ambient, inch = 101325.0, 3386.39
    >>> p = ambient - 12.30 * inch
    >>> flow = orifice_air_flow(p, ambient - 25 * inch, 0.8 * math.pi / 4 * 1e-6, 19.85)
    >>> round(equal_clearance(flow, p, ambient, [0.0145] * 2, [0.005] * 2, 19.85, 1.81e-5) * 1e6, 1)
    30.0
    """
    p, p_a = not_negative("pressure", pressure, "Pa"), positive("ambient pressure", ambient, "Pa")
    refuse("ambient pressure", p_a, p_a <= p, "above the {other}", "Pa", other="pressure in the circuit")
    wanted = not_negative("flow of air", flow, "kg/s")
    sizes = (np.atleast_1d(values(each)) for each in (diameters, contact_lengths))
    d, viscous, k = _gap(next(sizes), next(sizes), temperature, viscosity, loss_coefficient)
    factor = np.atleast_1d(positive("eccentricity factor", eccentricity_factors))
    squares = p_a * p_a - p * p
    c = np.cbrt(wanted / (math.pi * squares * np.sum(factor * d / viscous, axis=0)))
    for _ in range(_STEPS):
        each, root = _flow_and_root(squares, d, c, factor * (c * c), viscous, k)
        total = each.sum(axis=0)
        slope = np.sum(each * (1.0 + 2.0 * viscous / root), axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.exp(np.log(wanted / total) * total / slope)
        c = np.where(total > 0.0, c * step, c)
    return result(c)


def stand_flow_area(
    orifices: ArrayLike,
    pressures: ArrayLike,
    supply: float,
    ambient: float,
    discharge_coefficient: float,
    uncertainty: float,
) -> tuple[float, float]:
    """Compute C_d A of a stand's orifice from readings of known orifices, by least squares.

    Parameters
    ----------
    orifices : array
        diameters of the known orifices, through which air came in [m].
    pressures : array
        what the gauge showed in the circuit with each [Pa absolute].
    supply, ambient : float
        p_v and p_a [Pa].
    discharge_coefficient : float
        C_d of the known orifices [-].
    uncertainty : float
        standard uncertainty of a reading [Pa].

    Returns
    -------
    tuple of float
        C_d A [m²] and its standard uncertainty by the readings [m²], wider where they scatter more than they should.
        That of the known orifices' C_d comes on top, in proportion.

    Raises
    ------
    DomainError
        as `orifice_air_flow`; a pressure not between the supply's and ambient; an uncertainty not positive.

    Notes
    -----
    The temperature drops out: the same air passes both orifices.

    References
    ----------
    as `orifice_air_flow`; Birge R. T., Phys. Rev. 40 (1932) 207-227 for the scatter.

    Examples
    --------
    A stand of 1 mm whose C_d is 0.75, calibrated with jets of 0.5 and 1 mm, in mm²:

    >>> area, u = stand_flow_area([0.5e-3, 1e-3], [27407.8, 83799.0], 16665.25, 101325.0, 0.8, 1000.0)
    >>> round(area * 1e6, 2), round(u * 1e6, 2)
    (0.59, 0.02)
    """
    from scipy.optimize import least_squares  # dear to import, and seldom needed

    p_v, p_a = _supplied(supply, ambient)
    p = above("pressure", pressures, float(p_v), "Pa")
    refuse("ambient pressure", p_a, p_a <= p, "above the {other}", "Pa", other="pressure in the circuit")
    u = positive("uncertainty of a reading", uncertainty, "Pa")
    d = positive("orifice diameter", orifices, "m")
    known = positive("discharge coefficient", discharge_coefficient) * (math.pi / 4.0) * (d * d)
    first = orifice_air_flow(p_a, p, known, 20.0) / orifice_air_flow(p, p_v, 1.0, 20.0)
    scale = float(np.mean(first))

    def apart(fraction: Any) -> Any:
        def lacking(at: Any) -> Any:
            return orifice_air_flow(p_a, at, known, 20.0) - orifice_air_flow(at, p_v, fraction[0] * scale, 20.0)

        return (_falling_root(lacking, p_v, p_a + np.zeros_like(p)) - p) / u

    found = least_squares(apart, [1.0], bounds=(1e-3, 1e3), xtol=1e-12, ftol=1e-14)
    degrees = p.size - 1
    scatter = max(math.sqrt(2.0 * found.cost / degrees), 1.0) if degrees else 1.0
    return scale * float(found.x[0]), scale * scatter / math.sqrt(float((found.jac**2).sum()))


def _kelvin(temperature: ArrayLike) -> Any:
    return above("temperature", temperature, -100.0, "°C") + _ZERO


def _supplied(supply: ArrayLike, ambient: ArrayLike) -> tuple[Any, Any]:
    p_v, p_a = not_negative("supply pressure", supply, "Pa"), positive("ambient pressure", ambient, "Pa")
    refuse("ambient pressure", p_a, p_a <= p_v, "above the {other}", "Pa", other="supply pressure")
    return p_v, p_a


def _gap(
    diameter: Any, contact_length: Any, temperature: Any, viscosity: Any, loss_coefficient: Any
) -> tuple[Any, ...]:
    """Return diameter, 24 μ R T l and K R T of gaps."""
    d, length = positive("diameter", diameter, "m"), positive("contact length", contact_length, "m")
    mu, gas = positive("dynamic viscosity", viscosity, "Pa·s"), GAS_CONSTANT * _kelvin(temperature)
    return d, 24.0 * mu * gas * length, not_negative("loss coefficient", loss_coefficient) * gas


def _flow_and_root(squares: Any, d: Any, c: Any, ease: Any, viscous: Any, k: Any) -> tuple[Any, Any]:
    """Return the flow through gaps [kg/s], and the root of its quadratic; ``ease`` is F c²."""
    root = np.sqrt(viscous * viscous + 4.0 * k * squares * (ease * ease))
    return math.pi * d * c * ease * (2.0 * squares / (viscous + root)), root


def _falling_root(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Return where a function that falls with its argument is zero, between two bounds."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        positive_there = function(middle) > 0.0
        low, high = np.where(positive_there, middle, low), np.where(positive_there, high, middle)
    return 0.5 * (low + high) + 0.0 * function(0.5 * (low + high))
