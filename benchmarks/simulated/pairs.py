"""The true shape of a spool in its bore: the diameters that two points see of it, and the clearance that flow sees."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.controller import Land
from atleak.catalogue.instruments import Part

ANGLES = np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False)
MEAN_OF_ONE_SIDED = {1: 1.0 / math.pi, 2: 0.25, 3: 2.0 / (3.0 * math.pi)}  # of max(cos θ, 0)^n around the bore


@dataclass(frozen=True)
class Form:
    """How one part differs from a straight, round cylinder; all of it in its diameter [m]."""

    ovality: float  # largest less smallest diameter of the two-lobe form
    phase: float  # [rad] of the largest
    four_lobes: float  # amplitude of a form that two perpendicular diameters see alike
    taper: float  # from one measured plane to the next

    def deviation(self, angle: float | np.ndarray) -> float | np.ndarray:
        """Return how much the diameter at an angle [rad] is above its mean [m]."""
        return 0.5 * self.ovality * np.cos(2.0 * (angle - self.phase)) + self.four_lobes * np.cos(4.0 * angle)


@dataclass(frozen=True)
class Pair:
    """One land of a simulated unit: its true sizes, cold."""

    land: Land  # as the valve body's file describes it
    spool: float  # [m] mean diameter
    mounting: float  # [m] its own radial clearance when it was new
    wear: float  # [m] mean over the circumference
    one_sided: float  # fraction of the wear that is max(cos(θ − φ), 0)^n of one side; the rest is even
    side: float  # [rad] φ, the middle of the worn side
    length: float  # [m] of contact
    forms: Mapping[Part, Form]
    exponent: int = 1  # n
    eccentricity: float = 0.0  # of the spool's axis over the clearance of the even gap
    lies: float = 0.0  # [rad] the direction in which the gap is widest for that

    @property
    def clearance(self) -> float:
        """Return the mean radial clearance [m]."""
        return self.mounting + self.wear

    @property
    def even(self) -> float:
        """Return the radial clearance [m] without what was worn to one side."""
        return self.mounting + (1.0 - self.one_sided) * self.wear

    @property
    def deepest(self) -> float:
        """Return the wear at the middle of the worn side [m], w0 = fraction · mean over that of the profile."""
        return self.one_sided * self.wear / MEAN_OF_ONE_SIDED[self.exponent]

    def diameter(self, part: Part, direction: float, along: float) -> float:
        """Return the diameter [m] that two opposite points have.

        Parameters
        ----------
        direction
            [°] around the axis.
        along
            place of the plane in units of the taper, −½ … ½.
        """
        angle, form = math.radians(direction), self.forms[part]
        shape = float(form.deviation(angle)) + along * form.taper
        if part == "spool":
            return self.spool + shape
        # c(θ) + c(θ + π): of max(cos, 0) at both ends one is zero
        return self.spool + 2.0 * self.even + self.deepest * abs(math.cos(angle - self.side)) ** self.exponent + shape

    def around(self, widened: float = 0.0) -> np.ndarray:
        """Return the radial clearance at `ANGLES` [m]; ``widened`` [m] is what warmth adds all around."""
        radial = self.even + self.deepest * np.maximum(np.cos(ANGLES - self.side), 0.0) ** self.exponent + widened
        radial += 0.5 * (self.forms["sleeve"].deviation(ANGLES) - self.forms["spool"].deviation(ANGLES))
        # a spool off the middle leaves more room on one side and as much less on the other
        radial += self.eccentricity * (self.even + widened) * np.cos(ANGLES - self.lies)
        return np.maximum(radial, 0.0)


def random_forms(rng: np.random.Generator, sleeve_ovality: float, spool_ovality: float = 1e-6) -> dict[Part, Form]:
    """Draw the form of both parts; the ovalities are root mean squares [m]."""
    forms: dict[Part, Form] = {}
    for part, oval in (("spool", spool_ovality), ("sleeve", sleeve_ovality)):
        ovality = abs(rng.normal(0.0, oval))
        phase = rng.uniform(0.0, math.pi)
        forms[part] = Form(ovality, phase, rng.normal(0.0, 0.07 * ovality), rng.normal(0.0, 2e-6))  # type: ignore[index]
    return forms


def sides_as_assumed(rng: np.random.Generator) -> tuple[float, int]:
    """Draw which part of a unit's wear is to one side, and with which exponent, as the assessment assumes it."""
    return float(rng.choice((0.0, 0.5, 1.0), p=(0.25, 0.25, 0.5))), int(rng.integers(1, 4))
