"""Describe a pump: what it displaces, through which gaps it slips, and how wide they are, new and in this job."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from atleak.catalogue.pump_tables import PumpKind


@dataclass(frozen=True)
class PumpClearances:
    """The side clearance, which is the whole axial play, and the tip clearance of a pump [m]; None where not known."""

    side: float | None = None
    tip: float | None = None

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
    def known(self) -> bool:
        """Return whether either is known."""
        return self.side is not None or self.tip is not None

    def or_else(self, other: PumpClearances) -> PumpClearances:
        """Return these clearances, and of the other ones what is not known here."""
        return PumpClearances(
            other.side if self.side is None else self.side, other.tip if self.tip is None else self.tip
        )


NO_CLEARANCES = PumpClearances()


@dataclass(frozen=True)
class PumpGaps:
    """What a pump's gaps make of Wilson's C_s, per clearance cubed [1/m³]; None where dimensions are not known.

    A vane pump has no tips: its vanes lie against their ring.
    """

    side: float | None
    tip: float | None
    has_tips: bool = True
    lacking_of_side: tuple[str, ...] = ()  # keys of the dimensions that the file would have to state
    lacking_of_tip: tuple[str, ...] = ()

    def shares(self, at: PumpClearances) -> tuple[float, float]:
        """Return what the faces and what the tips make of C_s; zero where a clearance or its gap is not known."""
        return _cubed(self.side, at.side), _cubed(self.tip, at.tip)

    def coefficient(self, at: PumpClearances) -> float:
        """Return what all gaps together make of C_s."""
        return sum(self.shares(at))

    def whole(self, at: PumpClearances) -> bool:
        """Return whether every gap of the pump is known, its clearance too."""
        tips = not self.has_tips or (self.tip is not None and at.tip is not None)
        return tips and self.side is not None and at.side is not None


def _cubed(per_cube: float | None, clearance: float | None) -> float:
    return 0.0 if per_cube is None or clearance is None else per_cube * clearance**3


@dataclass(frozen=True)
class Pump:
    """The pump on the engine's shaft, as it is in this job: as its file has a new one, unless it was measured."""

    displacement: float  # [m³/rev] of the full stroke
    volumetric_efficiency: float
    slip_coefficient: float | None  # Wilson's C_s, None where nothing gives one
    representative: tuple[str, ...]
    kind: PumpKind | None = None
    held_at_demand: bool = False  # the stroke falls to what is taken
    gaps: PumpGaps = PumpGaps(None, None)
    clearances: PumpClearances = NO_CLEARANCES  # when new
    limits: PumpClearances = NO_CLEARANCES  # the most that the manual allows
    measured: PumpClearances = NO_CLEARANCES  # in this job
    counted: PumpClearances = NO_CLEARANCES  # of those, what makes its slip
    as_new: Pump | None = None  # the same pump new, where this one was measured and its slip when new is known

    @property
    def new(self) -> Pump:
        """Return the same pump as it was when new, as far as that is known."""
        return self.as_new or self

    def with_measured(self, measured: PumpClearances) -> Pump:
        """Return this pump with the clearances that were measured in a job, and with the slip that they make.

        A slip coefficient of the file holds for a new pump, and the gap law adds what the gaps have opened by since.
        Where the file states no clearances of a new pump, the larger counts: its coefficient, or what the gaps give.
        What the file lacks the dimensions for counts nowhere; `counted` says what does.
        """
        if not measured.known:
            return self
        known, gaps = replace(self, measured=measured), self.gaps
        counted = PumpClearances(
            None if gaps.side is None else measured.side, None if gaps.tip is None else measured.tip
        )
        new, now = self.clearances, counted.or_else(self.clearances)
        if not counted.known or (self.slip_coefficient is None and not gaps.whole(now)):
            return known
        coefficient, stated = gaps.coefficient(now), self.slip_coefficient
        if stated is not None:
            compared = all(
                before is not None or after is None
                for before, after in ((new.side, counted.side), (new.tip, counted.tip))
            )
            opened = coefficient - gaps.coefficient(new)
            coefficient = max(stated + opened, 0.0) if compared else max(stated, coefficient)
        as_new = None if stated is None else self
        return replace(known, slip_coefficient=coefficient, counted=counted, as_new=as_new)

    @property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """Return which measured clearances make no slip here, ``side`` or ``tip``, and what the file lacks for it."""
        gaps, out = self.gaps, []
        for name, clearance, counted, lacking in (
            ("side", self.measured.side, self.counted.side, gaps.lacking_of_side),
            ("tip", self.measured.tip, self.counted.tip, gaps.lacking_of_tip),
        ):
            if clearance is not None and counted is None:
                if name == "tip" and not gaps.has_tips:
                    missing = "the vanes of such a pump lie against their ring"
                elif self.kind is None:
                    missing = "its file does not state the kind of the pump"
                elif lacking:
                    missing = f"its file does not state {', '.join(lacking)}"
                else:
                    missing = (
                        "its file does not say what else slips: slip_coefficient, or both clearances of a new pump"
                    )
                out.append((name, missing))
        return tuple(out)

    def relative_uncertainty(self, clearance: float) -> float:
        """Return the relative standard uncertainty of the slip [-], each measured clearance uncertain by so much [m].

        Clearances count with their cubes; what was not measured in this job adds nothing.
        """
        if not self.slip_coefficient:
            return 0.0
        parts = zip(self.gaps.shares(self.counted), (self.counted.side, self.counted.tip), strict=True)
        return math.hypot(*(3.0 * share / size for share, size in parts if size)) * clearance / self.slip_coefficient
