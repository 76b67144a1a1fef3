"""Describe a pump: what it displaces, through which gaps it slips, and how wide they are, new and in this job."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.pump_tables import PumpKind
from atleak.common.sentences import Sentence
from atleak.equations import pump as equations


@dataclass(frozen=True)
class PumpClearances:
    """The side clearance, which is the whole axial play, and the tip clearance of a pump [m]; None where not known."""

    side: float | None = None  # the whole axial play
    tip: float | None = None  # between tip and crescent, housing or other tip

    @classmethod
    def of_um(cls, side: float | None, tip: float | None) -> PumpClearances:
        """Return clearances that are given in µm."""
        return cls(*(None if um is None else um * 1e-6 for um in (side, tip)))

    @property
    def um(self) -> tuple[float | None, float | None]:
        """Return side and tip clearance in µm."""
        side, tip = (None if metres is None else round(metres * 1e6, 9) for metres in (self.side, self.tip))
        return side, tip

    @property
    def any_known(self) -> bool:
        """Return whether either is known."""
        return self.side is not None or self.tip is not None

    def or_else(self, other: PumpClearances) -> PumpClearances:
        """Return these clearances, and of the other ones what is not known here."""
        return PumpClearances(
            other.side if self.side is None else self.side, other.tip if self.tip is None else self.tip
        )


NO_CLEARANCES = PumpClearances()

#: Of warm fluid, for the entry loss of tips, whose flow goes with its root at most [kg/m³]: choice of this project.
TIP_DENSITY = 800.0


@dataclass(frozen=True)
class TipGaps:
    """The gaps over the tips of a pump's rotors, but for their clearance."""

    width: float  # [m] of the rotors
    land: float  # [m] of one tip
    in_a_row: int  # tips of one rim between delivery and suction
    rims: int

    def slip(self, clearance: float, pressure: Any, dynamic_viscosity: Any) -> Any:
        """Return what slips over the tips of all rims [m³/s]."""
        sizes = (clearance, self.width, self.land, self.in_a_row)
        return self.rims * equations.tip_slip(pressure, *sizes, dynamic_viscosity, TIP_DENSITY)


@dataclass(frozen=True)
class PumpGaps:
    """The gaps through which a pump slips; None where the file does not give their dimensions.

    A vane pump has no tips: its vanes lie against their ring.
    """

    side: float | None  # what the faces make of Wilson's C_s, per clearance cubed [1/m³]
    tips: TipGaps | None
    has_tips: bool = True
    lacking_of_side: tuple[str, ...] = ()  # keys of the dimensions that the file would have to state
    lacking_of_tip: tuple[str, ...] = ()

    def whole(self, at: PumpClearances) -> bool:
        """Return whether every gap of the pump is known, its clearance too."""
        tips = not self.has_tips or (self.tips is not None and at.tip is not None)
        return tips and self.side is not None and at.side is not None


@dataclass(frozen=True)
class Pump:
    """The pump on the engine's shaft, as it is in this job: as its file has a new one, unless it was measured."""

    displacement: float  # [m³/rev] of the full stroke
    volumetric_efficiency: float  # η_v, a fraction
    slip_coefficient: float | None  # Wilson's C_s, of all but `tips`; None where nothing gives one
    representative: tuple[str, ...]  # which of its values are representative
    kind: PumpKind | None = None  # how it is built; None where the file is silent
    held_at_demand: bool = False  # the stroke falls to what is taken
    gaps: PumpGaps = PumpGaps(None, None)  # that its slip is computed from
    tips: tuple[tuple[float, float], ...] = ()  # sign and clearance [m]: slip over tips that C_s lacks, or holds
    clearances: PumpClearances = NO_CLEARANCES  # when new
    limits: PumpClearances = NO_CLEARANCES  # the most that the manual allows
    measured: PumpClearances = NO_CLEARANCES  # in this job
    counted: PumpClearances = NO_CLEARANCES  # of those, what makes its slip
    as_new: Pump | None = None  # the same pump new, where this one was measured and its slip when new is known

    @property
    def new(self) -> Pump:
        """Return the same pump as it was when new, as far as that is known."""
        return self.as_new or self

    def slip(self, pressure: Any, dynamic_viscosity: Any) -> Any:
        """Return the flow that slips back [m³/s] at any speed, of a pump with a slip coefficient; never below zero.

        Parameters
        ----------
        pressure
            of the line [Pa], a number or an array.
        dynamic_viscosity
            of the fluid [Pa·s], likewise.
        """
        assert self.slip_coefficient is not None
        flow = equations.slip_flow(self.displacement, self.slip_coefficient, pressure, dynamic_viscosity)
        if self.gaps.tips is None or not self.tips:
            return flow
        over_tips = (sign * self.gaps.tips.slip(size, pressure, dynamic_viscosity) for sign, size in self.tips)
        return np.maximum(flow + sum(over_tips), 0.0)

    def with_gaps(self) -> Pump:
        """Return this pump, of which no slip is stated, with that of its gaps, where every one is known."""
        now = self.measured.or_else(self.clearances)
        if not self.gaps.whole(now) or self.gaps.side is None or now.side is None:
            return self
        tips = () if now.tip is None or not self.gaps.has_tips else ((1.0, now.tip),)
        return replace(self, slip_coefficient=self.gaps.side * now.side**3, tips=tips)

    def with_measured(self, measured: PumpClearances) -> Pump:
        """Return this pump with the clearances that were measured in a job, and with the slip that they make.

        The slip of the file holds for a new pump, and the gap law adds what a gap has opened by since. Of a gap that
        lacks its dimensions, or its clearance when new beside a stated slip, nothing is added; `counted` says what is.

        Parameters
        ----------
        measured
            side and tip clearance of this job's pump [m]; None where not measured.

        Returns
        -------
        Pump
            the same pump where neither was measured.
        """
        if not measured.any_known:
            return self
        known, gaps, new = replace(self, measured=measured), self.gaps, self.clearances
        if self.slip_coefficient is None:
            of_gaps = known.with_gaps()
            return known if of_gaps is known else replace(of_gaps, counted=measured)
        coefficient, tips, counted = self.slip_coefficient, self.tips, NO_CLEARANCES
        if gaps.side is not None and measured.side is not None and new.side is not None:
            coefficient = max(coefficient + gaps.side * (measured.side**3 - new.side**3), 0.0)
            counted = replace(counted, side=measured.side)
        if gaps.tips is not None and measured.tip is not None and new.tip is not None:
            tips = ((1.0, measured.tip), *(() if tips else ((-1.0, new.tip),)))
            counted = replace(counted, tip=measured.tip)
        if not counted.any_known:
            return known
        return replace(known, slip_coefficient=coefficient, tips=tips, counted=counted, as_new=self)

    @property
    def left_out(self) -> tuple[tuple[str, Sentence], ...]:
        """Return which measured clearances make no slip here, ``side`` or ``tip``, and what the file lacks for it."""
        gaps, out = self.gaps, []
        for name, measured, counted, lacking in (
            ("side", self.measured.side, self.counted.side, gaps.lacking_of_side),
            ("tip", self.measured.tip, self.counted.tip, gaps.lacking_of_tip),
        ):
            if measured is None or counted is not None:
                continue
            if name == "tip" and not gaps.has_tips:
                missing = Sentence("the vanes of such a pump lie against their ring")
            elif self.kind is None:
                missing = Sentence("its file does not state the kind of the pump")
            elif lacking:
                missing = Sentence("its file does not state {keys}", keys=lacking)
            elif self.slip_coefficient is None:
                missing = Sentence("its file states neither slip_coefficient nor both clearances of a new pump")
            else:
                missing = Sentence("its file does not state {name}_clearance_um, that of a new pump", name=name)
            out.append((name, missing))
        return tuple(out)

    def relative_uncertainty(self, clearance: float, pressure: float, dynamic_viscosity: float) -> float:
        """Return the relative standard uncertainty of the slip [-], each measured clearance uncertain by so much [m].

        What was not measured in this job adds nothing.

        Parameters
        ----------
        clearance
            standard uncertainty of each measured clearance [m].
        pressure
            of the line [Pa].
        dynamic_viscosity
            of the fluid [Pa·s].

        Returns
        -------
        float
            [-]; 0 where nothing slips.
        """
        side, tip, gaps = self.counted.side, self.counted.tip, self.gaps
        slip = float(self.slip(pressure, dynamic_viscosity)) if self.counted.any_known else 0.0
        if slip <= 0.0:
            return 0.0
        by_side = by_tip = 0.0
        if side is not None and gaps.side is not None:
            opened = 3.0 * gaps.side * side**2 * clearance
            by_side = equations.slip_flow(self.displacement, opened, pressure, dynamic_viscosity)
        if tip is not None and gaps.tips is not None:
            ends = (gaps.tips.slip(max(tip + way * clearance, 0.0), pressure, dynamic_viscosity) for way in (1, -1))
            by_tip = 0.5 * (next(ends) - next(ends))
        return math.hypot(by_side, by_tip) / slip
