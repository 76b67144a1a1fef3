"""Describe a pump: what it displaces, through which gaps it slips, and how wide they are, new and in this job."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from atleak.catalogue.pump_tables import PumpKind
from atleak.errors import InputError


@dataclass(frozen=True)
class PumpClearances:
    """The side clearance, which is the whole axial play, and the tip clearance of a pump [m]; None where not known."""

    side: float | None = None
    tip: float | None = None

    @property
    def known(self) -> bool:
        """Return whether either is known."""
        return self.side is not None or self.tip is not None

    def or_else(self, other: PumpClearances) -> PumpClearances:
        """Return these clearances, and of the other ones what is not known here."""
        return PumpClearances(
            other.side if self.side is None else self.side, other.tip if self.tip is None else self.tip
        )


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
    clearances: PumpClearances = PumpClearances()  # when new
    limits: PumpClearances = PumpClearances()  # the most that the manual allows
    measured: PumpClearances = PumpClearances()  # in this job
    as_new: Pump | None = None  # the same pump new, where this one was measured and its slip when new is known

    @property
    def new(self) -> Pump:
        """Return the same pump as it was when new, as far as that is known."""
        return self.as_new or self

    def with_measured(self, measured: PumpClearances, file: str) -> Pump:
        """Return this pump with the clearances that were measured in a job.

        A slip coefficient of the file holds for a new pump, and the gap law adds what the gaps have opened by since.
        Where the file states no clearances of a new pump, the larger counts: its coefficient, or what the gaps give.

        Parameters
        ----------
        measured
            what was measured; nothing leaves the pump as it is.
        file
            of the controller, for messages.

        Raises
        ------
        InputError
            where the file lacks what turns a measured clearance into slip.
        """
        if not measured.known:
            return self
        self._require_gaps(measured, file)
        new, now = self.clearances, measured.or_else(self.clearances)
        stated, coefficient = self.slip_coefficient, self.gaps.coefficient(now)
        if stated is not None:
            compared = all(
                before is not None or after is None
                for before, after in ((new.side, measured.side), (new.tip, measured.tip))
            )
            opened = coefficient - self.gaps.coefficient(new)
            coefficient = max(stated + opened, 0.0) if compared else max(stated, coefficient)
        elif not self.gaps.whole(now):
            raise InputError(
                f"pump clearances were measured, but {file} does not say what else slips in this pump",
                expected="slip_coefficient in its table [pump], or the side and the tip clearance both",
            )
        return replace(self, slip_coefficient=coefficient, measured=measured, as_new=None if stated is None else self)

    def _require_gaps(self, measured: PumpClearances, file: str) -> None:
        gaps = self.gaps
        for name, clearance, per_cube, lacking in (
            ("side", measured.side, gaps.side, gaps.lacking_of_side),
            ("tip", measured.tip, gaps.tip, gaps.lacking_of_tip),
        ):
            if clearance is not None and name == "tip" and not gaps.has_tips:
                problem = "a tip clearance was measured of a vane pump, whose vanes lie against their ring"
                raise InputError(problem, expected="the side clearance alone")
            if clearance is not None and per_cube is None:
                problem = f"the pump's {name} clearance was measured, but {file} does not say what slips through it"
                expected = f"{', '.join(lacking) or 'kind and dimensions'} in the table [pump] of the valve body's file"
                raise InputError(problem, expected=expected)

    def relative_uncertainty(self, clearance: float) -> float:
        """Return the relative standard uncertainty of the slip [-], each measured clearance uncertain by so much [m].

        Clearances count with their cubes; what was not measured in this job adds nothing.
        """
        if not self.slip_coefficient:
            return 0.0
        parts = zip(self.gaps.shares(self.measured), (self.measured.side, self.measured.tip), strict=True)
        return math.hypot(*(3.0 * share / size for share, size in parts if size)) * clearance / self.slip_coefficient
