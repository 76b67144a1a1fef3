"""Compute what pumps of four kinds displace and deliver, and what they lose to slip through their own gaps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, refuse, result, values, within
from atleak.equations.gap import entry_loss_terms, restricted_flow

#: Working pressure angle of a pump's involute gears where only their outlines are known [rad]: the usual 20°, choice of
#: this project. At 27° a displacement is 1 % larger.
WORKING_ANGLE = math.radians(20.0)


def displacement(module: ArrayLike, teeth: ArrayLike, width: ArrayLike, tooth_height: ArrayLike) -> Any:
    """Compute the displacement of an internal-gear pump with a crescent, ``q_p = π m z b h``.

    Parameters
    ----------
    module : float or array
        m, tooth module [m].
    teeth : float or array
        z, teeth of the pinion [-].
    width : float or array
        b, width of pinion and rotor gear [m].
    tooth_height : float or array
        h [m].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution].

    Raises
    ------
    DomainError
        A value not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, section 2, pump unit capacity (unnumbered).

    Examples
    --------
    >>> round(displacement(0.0045, 12, 0.012, 0.0084) * 1e9, 3)
    17100.317
    """
    m = positive("tooth module", module, "m")
    z = positive("number of teeth", teeth)
    b = positive("gear width", width, "m")
    h = positive("tooth height", tooth_height, "m")
    return result(math.pi * m * z * b * h)


def gerotor_displacement(tip_diameter: ArrayLike, root_diameter: ArrayLike, width: ArrayLike, lobes: ArrayLike) -> Any:
    """Compute the displacement of a gerotor from its inner rotor, ``π/4 (D² − d²) b sin(π/k)/(π/k)``, k = z + 1.

    The lobes of the inner rotor sweep the ring between its root and its tips; the k chambers, one more than lobes, do
    not open and close at one point, which takes the last factor off.

    Parameters
    ----------
    tip_diameter : float or array
        D, of the inner rotor over the tips of its lobes [m].
    root_diameter : float or array
        d, of the inner rotor at the roots between them [m].
    width : float or array
        b, of both rotors [m].
    lobes : float or array
        z, of the inner rotor [-].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution of the inner rotor].

    Raises
    ------
    DomainError
        A value not positive, or a tip diameter not above the root diameter.

    Notes
    -----
    The exact displacement is z b times what a chamber's area changes by, and depends on the profile a little. Against
    generated trochoids without undercut this is at most 1 % low with 8 lobes or more, 2 % with 5 to 7 and 3.5 % with 4;
    without the last factor it would be up to 6 % high.

    References
    ----------
    Colbourne J. R., Gear shape and theoretical flow rate in internal gear pumps, Trans. CSME 3 (1975), 215-223, for
    the exact one; the factor is that of `vane_displacement`, a choice of this project.

    Examples
    --------
    A pump of 8 lobes, 60 over 50 mm, 12 mm wide, in mm³:

    >>> round(gerotor_displacement(0.060, 0.050, 0.012, 8) * 1e9)
    10158
    """
    over, root = _diameters("tip diameter", tip_diameter, "root diameter", root_diameter)
    b = positive("rotor width", width, "m")
    chambers = positive("number of lobes", lobes) + 1.0
    return result(math.pi / 4.0 * (over * over - root * root) * b * _finite(chambers))


def vane_displacement(ring_diameter: ArrayLike, eccentricity: ArrayLike, width: ArrayLike, vanes: ArrayLike) -> Any:
    """Compute the displacement of a vane pump with a round cam ring, ``2 π e D b sin(π/z)/(π/z)``.

    Parameters
    ----------
    ring_diameter : float or array
        D, bore of the cam ring [m].
    eccentricity : float or array
        e, between the axes of ring and rotor; at full stroke the largest [m].
    width : float or array
        b, of the vanes [m].
    vanes : float or array
        z [-].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution].

    Raises
    ------
    DomainError
        A value not positive.

    Notes
    -----
    Exact to (e/D)² for a chamber that closes where it is largest, and for vanes under which the fluid is pumped too:
    where the slots under them are not connected to the chambers beside them, a vane of thickness s takes 2 e s b off.

    References
    ----------
    Ivantysyn J., Ivantysynova M., Hydrostatic Pumps and Motors, Akademia Books 2001, section on vane pumps (ideal
    displacement 2 π e D b); the last factor is the integral of a chamber's area over its opening angle 2π/z.

    Examples
    --------
    A ring of 70 mm with 6 mm of eccentricity, 13 vanes of 18 mm, in mm³:

    >>> round(vane_displacement(0.070, 0.006, 0.018, 13) * 1e9)
    47040
    """
    d = positive("diameter of the cam ring", ring_diameter, "m")
    e = positive("eccentricity", eccentricity, "m")
    b = positive("vane width", width, "m")
    return result(2.0 * math.pi * e * d * b * _finite(positive("number of vanes", vanes)))


def gear_pair_displacement(
    tip_diameter: ArrayLike, centre_distance: ArrayLike, width: ArrayLike, teeth: ArrayLike
) -> Any:
    """Compute the displacement of two equal spur gears, ``π/2 b (D² − a² − p²/3)``, p = π a cos α / z.

    Parameters
    ----------
    tip_diameter : float or array
        D, of each gear over the tips of its teeth [m].
    centre_distance : float or array
        a, between the axes [m].
    width : float or array
        b, of the gears [m].
    teeth : float or array
        z, of each gear [-].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution].

    Raises
    ------
    DomainError
        A value not positive, or a tip diameter not above the centre distance.

    Notes
    -----
    Exact for involute teeth of working pressure angle α with relief grooves that part delivery from suction in the
    middle of the mesh; α is taken as `WORKING_ANGLE`. The simpler ``π/2 b (D² − a²)`` of repair shops leaves the base
    pitch p out, which is what the mesh carries back, and is 3 to 8 % too large with 8 to 14 teeth.

    References
    ----------
    Ivantysyn J., Ivantysynova M., Hydrostatic Pumps and Motors, Akademia Books 2001, section on external gear pumps.

    Examples
    --------
    Two gears of 12 teeth, 50 over 42 mm, 16 mm wide, in mm³:

    >>> round(gear_pair_displacement(0.050, 0.042, 0.016, 12) * 1e9)
    17603
    """
    over, a = _diameters("tip diameter", tip_diameter, "centre distance", centre_distance)
    b = positive("gear width", width, "m")
    pitch = _base_pitch(a, positive("number of teeth", teeth))
    return result(math.pi / 2.0 * b * (over * over - a * a - pitch * pitch / 3.0))


def crescent_displacement(
    tip_diameter: ArrayLike,
    ring_tip_diameter: ArrayLike,
    centre_distance: ArrayLike,
    width: ArrayLike,
    teeth: ArrayLike,
    ring_teeth: ArrayLike,
) -> Any:
    """Compute the displacement of a pinion in a ring gear from what a calliper reaches.

    ``π b (r² − w² + z/Z (W² − R²) − (1 − z/Z) p²/12)`` with the working radii ``w = a z/(Z − z)`` and
    ``W = a Z/(Z − z)`` and the base pitch ``p = 2π w cos α / z``.

    Parameters
    ----------
    tip_diameter : float or array
        2 r, of the pinion over the tips of its teeth [m].
    ring_tip_diameter : float or array
        2 R, of the ring gear between the tips of its teeth [m].
    centre_distance : float or array
        a, between the axes of pinion and ring gear [m].
    width : float or array
        b, of both gears [m].
    teeth, ring_teeth : float or array
        z and Z [-].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution of the pinion].

    Raises
    ------
    DomainError
        A value not positive; a ring gear with no more teeth than the pinion; a pinion that does not reach over its
        working circle, or a ring gear that does not reach under its own: the centre distance or a count is wrong.

    Notes
    -----
    Exact for involute teeth with relief grooves that part delivery from suction in the middle of the mesh; α is taken
    as `WORKING_ANGLE`, which matters little. An error of the centre distance δ counts as ``2 π b w δ``: 0.1 mm in a
    usual pump is 2 to 4 %.

    References
    ----------
    Colbourne J. R., Gear shape and theoretical flow rate in internal gear pumps, Trans. CSME 3 (1975), 215-223;
    derived from the power of both gears, ``p Q = T ω + T' ω'``.

    Examples
    --------
    A pinion of 24 teeth in a ring gear of 29, centres 7.5 mm apart, 12 mm wide, in mm³:

    >>> round(crescent_displacement(0.0775, 0.0825, 0.0075, 0.012, 24, 29) * 1e9)
    13656
    """
    z, ring_z = positive("number of teeth", teeth), positive("number of the ring gear's teeth", ring_teeth)
    refuse("number of the ring gear's teeth", ring_z, ring_z <= z, "above the pinion's")
    a = positive("centre distance", centre_distance, "m")
    b = positive("gear width", width, "m")
    over = 0.5 * positive("tip diameter", tip_diameter, "m")
    ring = 0.5 * positive("tip diameter of the ring gear", ring_tip_diameter, "m")
    ratio = z / ring_z
    working, ring_working = a * z / (ring_z - z), a * ring_z / (ring_z - z)
    refuse("tip diameter", 2.0 * over, over <= working, "above its working circle's, 2 a z/(Z − z)", "m")
    too_far = ring >= ring_working
    refuse("tip diameter of the ring gear", 2.0 * ring, too_far, "below its working circle's, 2 a Z/(Z − z)", "m")
    pitch = _base_pitch(2.0 * working, z)
    swept = over * over - working * working + ratio * (ring_working * ring_working - ring * ring)
    return result(math.pi * b * (swept - (1.0 - ratio) * pitch * pitch / 12.0))


def _finite(chambers: Any) -> Any:
    """Return what a finite number of chambers leaves of the displacement that infinitely many would have."""
    half = math.pi / chambers
    return np.sin(half) / half


def _base_pitch(working_diameter: Any, teeth: Any) -> Any:
    return math.pi * working_diameter * math.cos(WORKING_ANGLE) / teeth


def _diameters(name: str, large: ArrayLike, other: str, small: ArrayLike) -> tuple[Any, Any]:
    """Return two diameters, the first above the second."""
    over, under = positive(name, large, "m"), positive(other, small, "m")
    refuse(name, over, over <= under, "above the {other}", "m", other=other)
    return over, under


def capacity(displacement: ArrayLike, speed: ArrayLike, volumetric_efficiency: ArrayLike) -> Any:
    """Compute the flow that a pump delivers, ``Q_p = q_p n η_v``.

    Parameters
    ----------
    displacement : float or array
        q_p [m³ per revolution].
    speed : float or array
        n, of the pump, which is the engine's [1/s].
    volumetric_efficiency : float or array
        η_v, 0 … 1 [-].

    Returns
    -------
    float or ndarray
        Q_p [m³/s].

    Raises
    ------
    DomainError
        Displacement not positive; negative speed; efficiency outside 0 … 1.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, section 2, pump capacity (unnumbered).

    Examples
    --------
    In dm³/min at 2500 revolutions per minute:

    >>> q_p = displacement(0.0045, 12, 0.012, 0.0084)
    >>> round(capacity(q_p, 2500 / 60, 0.95) * 60e3, 3)
    40.613
    """
    q_p = positive("pump displacement", displacement, "m³")
    n = not_negative("pump speed", speed, "1/s")
    return result(q_p * n * within("volumetric efficiency", volumetric_efficiency, 0.0, 1.0))


def slip_flow(
    displacement: ArrayLike, slip_coefficient: ArrayLike, pressure: ArrayLike, dynamic_viscosity: ArrayLike
) -> Any:
    """Compute the flow that slips back inside a pump, whatever its speed, ``q_p C_s Δp / (2 π μ)``.

    Parameters
    ----------
    displacement : float or array
        q_p [m³ per revolution].
    slip_coefficient : float or array
        C_s [-].
    pressure : float or array
        Δp, from suction to delivery [Pa].
    dynamic_viscosity : float or array
        μ [Pa·s].

    Returns
    -------
    float or ndarray
        [m³/s], of the sign of the pressure.

    Raises
    ------
    DomainError
        Displacement or viscosity not positive; negative slip coefficient.

    References
    ----------
    Wilson W. E., Positive-Displacement Pumps and Fluid Motors, Pitman 1950; ``q_p n (1 − η_v)`` with his η_v.

    Examples
    --------
    >>> round(slip_flow(17100.317e-9, 1e-7, 800e3, 8.55819e-3) * 60e3, 3)
    1.526
    """
    q_p = positive("pump displacement", displacement, "m³")
    c_s = not_negative("slip coefficient", slip_coefficient)
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    return result(q_p * c_s * values(pressure) / ((2.0 * math.pi) * mu))


def face_slip(side_clearance: ArrayLike, outer_diameter: ArrayLike, inner_diameter: ArrayLike) -> Any:
    """Compute what slips past both side faces of a rotor per pressure and fluidity, ``π s³ / (48 ln(D/d))``.

    Half a turn of the rim is at delivery pressure. From there the fluid crosses the sealing land of each face, between
    the roots of the teeth and the shaft: two plane gaps of s/2, ``q = π (s/2)³ Δp / (12 μ ln(D/d))`` each.

    Parameters
    ----------
    side_clearance : float or array
        s, total axial play: depth of the pocket less width of the rotor [m].
    outer_diameter : float or array
        D, where the land begins: at the roots of the teeth; of a ring gear its outside [m].
    inner_diameter : float or array
        d, where it ends: at the shaft or its bore; of a ring gear its roots [m].

    Returns
    -------
    float or ndarray
        G [m³], with which ``q = G Δp / μ`` in laminar flow.

    Raises
    ------
    DomainError
        Negative clearance; a diameter not positive, or the outer not above the inner.

    Notes
    -----
    Choices of this project: the play lies half on either face (all on one leaks four times as much), the rim is at
    delivery pressure over half a turn, and what passes the sides of the teeth from chamber to chamber is left out.
    Against the lubrication equation solved over a face with its teeth this is 15 % high to 6 % low for lands of D/d
    from 1.15 to 1.4, and up to 25 % low to 2.

    References
    ----------
    Plane gap of Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (3), in plane polar coordinates.

    Examples
    --------
    A play of 40 µm over a land from 66 to 48 mm, in dm³/min at 500 kPa and 6 mPa·s:

    >>> round(face_slip(40e-6, 0.066, 0.048) * 500e3 / 6e-3 * 60e3, 4)
    0.0658
    """
    s = not_negative("side clearance", side_clearance, "m")
    over, under = _diameters("outer diameter of the land", outer_diameter, "inner diameter", inner_diameter)
    return result(math.pi * s * s * s / (48.0 * np.log(over / under)))


def tip_slip(
    pressure: ArrayLike,
    tip_clearance: ArrayLike,
    width: ArrayLike,
    tip_land: ArrayLike,
    sealing_tips: ArrayLike,
    dynamic_viscosity: ArrayLike,
    density: ArrayLike,
) -> Any:
    """Compute what slips over the tips of one rim: a plane gap at each of n tips in a row, with its entry loss.

    The mean velocity u over a tip solves ``Δp/n = 12 μ l u / c² + K ρ u² / 2``; the flow is ``b c u``.

    Parameters
    ----------
    pressure : float or array
        Δp, from suction to delivery [Pa]. A negative one gives a negative flow.
    tip_clearance : float or array
        c, between the tips and what they seal against [m].
    width : float or array
        b, of the rotor [m].
    tip_land : float or array
        l, length of one tip in the direction of the flow [m].
    sealing_tips : float or array
        n, that lie between delivery and suction, one after another [-].
    dynamic_viscosity : float or array
        μ [Pa·s].
    density : float or array
        ρ [kg/m³].

    Returns
    -------
    float or ndarray
        [m³/s].

    Raises
    ------
    DomainError
        Negative clearance; width, land, number of tips, viscosity or density not positive.

    Notes
    -----
    Tips are short and their clearance is wide: hot, the entry loss takes off half at 110 µm, four fifths at 200 µm.
    What the turning tips drag along is left out: it does not depend on pressure, and acts against this flow. A round
    tip of radius r has the land of about 1.2 √(2 r c).

    References
    ----------
    Plane gap of Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (3), with the loss coefficients of
    `atleak.equations.gap.entry_loss_flow`.

    Examples
    --------
    Three tips of 2 mm at 120 µm, 12 mm wide, in dm³/min at 500 kPa and 6 mPa·s:

    >>> round(tip_slip(500e3, 120e-6, 0.012, 0.002, 3, 6e-3, 800.0) * 60e3, 3)
    0.89
    """
    n = positive("number of sealing tips", sealing_tips)
    b = positive("rotor width", width, "m")
    c = not_negative("tip clearance", tip_clearance, "m")
    length = positive("length of a tip", tip_land, "m")
    rho = positive("density", density, "kg/m³")
    nu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s") / rho
    return restricted_flow(values(pressure) / n, *entry_loss_terms(b / math.pi, c, nu, rho, length))


def slip_coefficient(slip: ArrayLike, displacement: ArrayLike) -> Any:
    """Compute Wilson's slip coefficient from what slips through gaps, ``C_s = 2 π G / q_p``.

    Parameters
    ----------
    slip : float or array
        G, of `face_slip` [m³].
    displacement : float or array
        q_p [m³ per revolution].

    Returns
    -------
    float or ndarray
        C_s [-], with which `slip_flow` gives ``G Δp / μ`` again.

    Raises
    ------
    DomainError
        Negative slip; displacement not positive.

    References
    ----------
    Wilson W. E., Positive-Displacement Pumps and Fluid Motors, Pitman 1950: `slip_flow`, solved for C_s.

    Examples
    --------
    >>> c_s = slip_coefficient(2.0e-13, 17100.317e-9)
    >>> round(slip_flow(17100.317e-9, c_s, 800e3, 8.55819e-3), 12) == round(2.0e-13 * 800e3 / 8.55819e-3, 12)
    True
    """
    g = not_negative("slip", slip, "m³")
    return result(2.0 * math.pi * g / positive("pump displacement", displacement, "m³"))


def minimum_speed(leakage: ArrayLike, slip: ArrayLike, displacement: ArrayLike) -> Any:
    """Compute the speed below which the pump cannot make up for what is lost, ``n_min = (q + slip) / q_p``.

    Parameters
    ----------
    leakage : float or array
        q, drawn from the pump by the controller [m³/s].
    slip : float or array
        What slips back inside the pump, of `slip_flow` [m³/s].
    displacement : float or array
        q_p [m³ per revolution].

    Returns
    -------
    float or ndarray
        n_min [1/s]. Below it main pressure cannot be held.

    Raises
    ------
    DomainError
        Displacement not positive.

    References
    ----------
    Balance of the pump, ``q_p n = slip + q``, with the slip of Wilson W. E., Positive-Displacement Pumps and
    Fluid Motors, Pitman 1950.

    Examples
    --------
    In revolutions per minute:

    >>> round(minimum_speed(8e-5, 2.5e-5, 17100.317e-9) * 60, 1)
    368.4
    """
    q_p = positive("pump displacement", displacement, "m³")
    return result((values(leakage) + values(slip)) / q_p)
