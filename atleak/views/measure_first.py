"""Say which lands a complaint asks to measure first."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.workshop_units import PERCENT


class Doubt(StrEnum):
    """What is open about a land."""

    NOT_MEASURED = "not_measured"
    HALF_MEASURED = "half_measured"  # on the spool or the sleeve only
    CONDITIONAL = "conditional"  # the verdict lies within what the instruments can tell
    NONE = "none"


@dataclass(frozen=True)
class MeasureFirst:
    """A land that can explain a complaint, and why it is to be measured before or after the others."""

    land: LandDiagnosis
    projection: Projection  # the one of the complaint's at which the land carries most
    part: float  # of all that leaks there, whether or not it is drawn from the pump

    @property
    def doubt(self) -> Doubt:
        """Return what is open about the land."""
        if not self.land.state.measured:
            return Doubt.NOT_MEASURED
        if self.land.state.status != "measured":
            return Doubt.HALF_MEASURED
        decided = self.land.deciding_uncertainty
        return Doubt.CONDITIONAL if decided is not None and decided.conditional else Doubt.NONE

    @property
    def reason(self) -> str:
        """Say in plain words what is open about the land and how much it carries."""
        carried = f"{self.part * PERCENT:.1f} % of what leaks at “{self.projection.condition.label}”"
        return _REASONS[self.doubt].format(verdict=self.land.verdict.replace("_", " "), carried=carried)


_REASONS = {
    Doubt.NOT_MEASURED: "not measured; as new it carries {carried}",
    Doubt.HALF_MEASURED: "measured on one part only; with the other one as new it carries {carried}",
    Doubt.CONDITIONAL: "its verdict, {verdict}, is closer to a limit than the readings can tell; it carries {carried}",
    Doubt.NONE: "measured, its verdict is {verdict}; it carries {carried}",
}


def measure_first(diagnosis: Diagnosis) -> tuple[MeasureFirst, ...]:
    """Return the lands that can explain the complaint of a diagnosis, the first to be measured first.

    What is open about a land comes before what is sure; within both, the lands are in the order of how much of the
    leakage they carry at one of the complaint's conditions. None without a complaint.
    """
    complaint, at = diagnosis.complaint, diagnosis.complained
    if complaint is None or not at:
        return ()
    named = [_at_most(land, at) for land in diagnosis.lands if not complaint.lands or land.key in complaint.lands]
    kept = [each for each in named if complaint.lands or each.part > 0.0]
    return tuple(sorted(kept, key=lambda each: (each.doubt is Doubt.NONE, -each.part)))


def _at_most(land: LandDiagnosis, projections: tuple[Projection, ...]) -> MeasureFirst:
    parts = []
    for projection in projections:
        everything = sum(gap.leakage for gap in projection.gaps)
        parts.append(projection.leakage_of(land.key) / everything if everything > 0.0 else 0.0)
    most = max(range(len(parts)), key=parts.__getitem__)
    return MeasureFirst(land, projections[most], parts[most])
