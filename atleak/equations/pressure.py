"""Compute control and modulated pressure, which no gauge reaches in a working transmission (equations 6 to 14)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, refuse, result, values


def annulus_area(diameter: ArrayLike, rod_diameter: ArrayLike = 0.0) -> Any:
    """Compute the area of a ring, ``A_W = π (d² − d_w²) / 4``; of a full disc without a rod.

    Parameters
    ----------
    diameter : float or array
        d, outer diameter [m].
    rod_diameter : float or array, optional
        d_w, diameter of the rod [m].

    Returns
    -------
    float or ndarray
        [m²].

    Raises
    ------
    DomainError
        Diameter not positive; rod diameter negative or larger than the diameter.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (9).

    Examples
    --------
    >>> round(annulus_area(0.010, 0.005) * 1e6, 3)
    58.905
    """
    d = positive("diameter", diameter, "m")
    rod = not_negative("rod diameter", rod_diameter, "m")
    refuse("rod diameter", rod, rod > d, "at most the diameter", "m")
    return result((math.pi / 4.0) * ((d - rod) * (d + rod)))


def spring_force(rate: ArrayLike, deflection: ArrayLike) -> Any:
    """Compute the force of a compression spring, ``F = k x``.

    Parameters
    ----------
    rate : float or array
        k [N/m].
    deflection : float or array
        x, from the free length [m].

    Returns
    -------
    float or ndarray
        [N].

    Raises
    ------
    DomainError
        Rate not positive; negative deflection.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (10).

    Examples
    --------
    >>> round(spring_force(1953.125, 0.010), 5)
    19.53125
    """
    return result(positive("spring rate", rate, "N/m") * not_negative("spring deflection", deflection, "m"))


def spring_rate(
    shear_modulus: ArrayLike, wire_diameter: ArrayLike, active_coils: ArrayLike, mean_coil_diameter: ArrayLike
) -> Any:
    """Compute the rate of a helical spring, ``k = G d_w⁴ / (8 z D_p³)``.

    Parameters
    ----------
    shear_modulus : float or array
        G [Pa]; 80 GPa for spring steel.
    wire_diameter : float or array
        d_w [m].
    active_coils : float or array
        z [-].
    mean_coil_diameter : float or array
        D_p, to the middle of the wire [m].

    Returns
    -------
    float or ndarray
        k [N/m].

    Raises
    ------
    DomainError
        A value not positive; a mean coil diameter that is not larger than the wire's.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (11), where 0.8·10⁵ is in MPa, not in GPa as printed.

    Examples
    --------
    >>> round(spring_rate(80e9, 0.001, 10, 0.008), 3)
    1953.125
    """
    g = positive("shear modulus", shear_modulus, "Pa")
    wire = positive("wire diameter", wire_diameter, "m")
    coils = positive("number of active coils", active_coils)
    mean = positive("mean coil diameter", mean_coil_diameter, "m")
    refuse("mean coil diameter", mean, mean <= wire, "larger than the wire's", "m")
    ratio = wire / mean
    return result(g * wire * (ratio * ratio * ratio) / (8.0 * coils))


def spring_deflection(free_length: ArrayLike, length: ArrayLike) -> Any:
    """Compute the deflection of a compression spring, ``x = l_free − l_n``.

    Parameters
    ----------
    free_length : float or array
        Length of the unloaded spring [m].
    length : float or array
        l_n, length in the spool's position [m].

    Returns
    -------
    float or ndarray
        [m].

    Raises
    ------
    DomainError
        A length not positive; a length beyond the free length.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (12); counted from the free length, since from the
    pre-tensioned length, as printed, the preload would be missing.

    Examples
    --------
    >>> round(spring_deflection(0.032, 0.022), 6)
    0.01
    """
    free = positive("free length", free_length, "m")
    installed = positive("spring length", length, "m")
    refuse("spring length", installed, installed > free, "at most the free length", "m")
    return result(free - installed)


def control_pressure(
    main_pressure: ArrayLike,
    spring_force: ArrayLike,
    a_1: ArrayLike,
    a_2w: ArrayLike,
    a_3w: ArrayLike,
    a_g1: ArrayLike,
    a_g2: ArrayLike,
) -> Any:
    """Compute the control pressure that holds the spool of valve 17 in equilibrium.

    ``p_s = [p_g (A_g1 − A_g2) + F_sp] / (A_1 − A_2W + A_3W)``, affine in main pressure.

    Parameters
    ----------
    main_pressure : float or array
        p_g [Pa].
    spring_force : float or array
        F_sp [N].
    a_1 : float or array
        Full end face [m²].
    a_2w, a_3w : float or array
        Rings that control pressure acts on [m²].
    a_g1, a_g2 : float or array
        Rings that main pressure acts on [m²].

    Returns
    -------
    float or ndarray
        p_s [Pa].

    Raises
    ------
    DomainError
        Negative area; no area left for control pressure to act on.

    Notes
    -----
    Solved from `spool_balance`. The article prints another form, which mixes the full face with its ring,
    lacks the factor from N/mm² to kPa and does not follow from its own balance.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (13), solved from eq. (6).

    Examples
    --------
    >>> a_1, ring_2, ring_3 = annulus_area(0.012), annulus_area(0.010, 0.005), annulus_area(0.009, 0.005)
    >>> p_s = control_pressure(800e3, 19.53125, a_1, ring_2, ring_3, ring_2, ring_3)
    >>> round(p_s / 1e3, 4)
    320.5437
    """
    p_g = values(main_pressure)
    control = (
        not_negative("area A_1", a_1, "m²")
        - not_negative("area A_2W", a_2w, "m²")
        + not_negative("area A_3W", a_3w, "m²")
    )
    main = not_negative("area A_g1", a_g1, "m²") - not_negative("area A_g2", a_g2, "m²")
    # What subtraction leaves of equal areas is no area.
    nothing = control <= 1e-12 * values(a_1)
    refuse("area left for control pressure (A_1 - A_2W + A_3W)", control, nothing, "positive", "m²")
    return result((p_g * main + values(spring_force)) / control)


def regulated_pressure(
    main_pressure: ArrayLike, ratio: ArrayLike, offset: ArrayLike = 0.0, limit: ArrayLike | None = None
) -> Any:
    """Compute the pressure that a valve makes of main pressure, a line up to a limit: ``min(α p_g + p_0, limit)``.

    Parameters
    ----------
    main_pressure : float or array
        p_g [Pa].
    ratio : float or array
        α: of modulated pressure as found on road tests, of control pressure as `control_pressure` gives it [-].
    offset : float or array, optional
        p_0, what the spring of the valve holds at no main pressure [Pa].
    limit : float or array, optional
        The highest pressure that the valve lets through [Pa]; None where there is no such limit.

    Returns
    -------
    float or ndarray
        p_m or p_s [Pa].

    Raises
    ------
    DomainError
        Limit not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (14), where p_0 is zero and the limit 500 kPa; eq. (13) is
    such a line, because `control_pressure` is affine in main pressure.

    Examples
    --------
    >>> regulated_pressure([600e3, 1200e3], 0.5, 0.0, 500e3).tolist()
    [300000.0, 500000.0]
    """
    line = values(main_pressure) * values(ratio) + values(offset)
    return result(line if limit is None else np.minimum(line, positive("limit of the pressure", limit, "Pa")))
