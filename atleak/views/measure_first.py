"""Say which lands a complaint asks to measure first, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.land_diagnosis import LandDiagnosis
from atleak.wording import Wording, wording


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


def head(ranked: Sequence[MeasureFirst], say: Wording | None = None) -> str:
    """Say what a list of lands is: those to measure first, or only what each carries where nothing is open.

    Parameters
    ----------
    say
        the words of a language; English unless given.
    """
    say = say or wording("en")
    if not ranked:
        return say("complaint.nothing")
    return say("complaint.sure" if all(each.doubt is Doubt.NONE for each in ranked) else "complaint.first")


def reason(each: MeasureFirst, say: Wording | None = None) -> str:
    """Say what is open about a land and how much it carries.

    Parameters
    ----------
    say
        the words of a language; English unless given.
    """
    say = say or wording("en")
    carried = say("complaint.carried", part=say.percent(each.part), condition=say.condition(each.projection.condition))
    return say(f"complaint.{each.doubt}", verdict=say.level(each.land.verdict), carried=carried)


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
