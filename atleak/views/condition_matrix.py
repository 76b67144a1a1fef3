"""Lay out what every land leaks at every condition: the matrix that record, page, terminal and reports show."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import Rule
from atleak.sentence import Name, Sentence
from atleak.verdicts import Verdict

ANOTHER_CIRCUIT = Sentence("another circuit")


@dataclass(frozen=True)
class LandAtCondition:
    """What one land leaks at one condition, and what its share of the pump's flow is judged to be there."""

    projection: Projection
    leakage: float  # [m³/s] through every gap of the land
    drawn_from_pump: float  # [m³/s] the part of it that counts in the total
    share: float  # drawn from the pump / pump capacity: the shares of all lands, and what leaks beside them, add up
    rule: Rule | None  # of the land's share there; None where nothing was measured or no such limit is set
    verdict: Verdict | None  # of that share alone; None where no such limit is set
    loss: float | None  # [Pa] that it costs the circuit that loses most by it; None where no pressure is solved
    #: sections into which it leaks without drawing from the pump; None for one that the valve body's file does not name
    circuits: tuple[str | None, ...]

    @property
    def elsewhere(self) -> Sentence:
        """Say into which circuits it leaks without drawing from the pump; an empty text where it does not."""
        return elsewhere(self.circuits)


@dataclass(frozen=True)
class MatrixRow:
    """One land at every condition."""

    land: LandDiagnosis
    cells: tuple[LandAtCondition, ...]

    @classmethod
    def of(cls, land: LandDiagnosis, diagnosis: Diagnosis, projections: Iterable[Projection]) -> MatrixRow:
        """Return one land at some of the conditions of its diagnosis."""
        return cls(land, tuple(land_at(land, diagnosis, projection) for projection in projections))

    @property
    def leaks(self) -> bool:
        """Tell whether the land leaks at any condition."""
        return any(cell.leakage > 0.0 for cell in self.cells)

    @property
    def worst(self) -> LandAtCondition:
        """Return the condition at which the land's share is judged worst; of several, where it is largest."""
        return max(self.cells, key=lambda cell: (-1 if cell.verdict is None else cell.verdict.rank, cell.share))

    @property
    def circuits(self) -> tuple[str | None, ...]:
        """Return the sections into which it leaks at any condition without drawing from the pump."""
        return tuple(dict.fromkeys(circuit for cell in self.cells for circuit in cell.circuits))

    @property
    def elsewhere(self) -> Sentence:
        """Say into which circuits it leaks at any condition without drawing from the pump; empty where it does not."""
        return elsewhere(self.circuits)


def elsewhere(circuits: Iterable[str | None]) -> Sentence:
    """Say that a land leaks into live circuits.

    >>> elsewhere(["p_m"])
    'leaks into p_m, not drawn from the pump'
    >>> elsewhere([])
    ''
    """
    names = [Name(circuit) if circuit else ANOTHER_CIRCUIT for circuit in circuits]
    if not names:
        return Sentence("")
    said: Sentence | Name = names[0]
    for name in names[1:]:
        said = Sentence("{first} and {second}", first=said, second=name)
    return Sentence("leaks into {circuits}, not drawn from the pump", circuits=said)


def condition_matrix(diagnosis: Diagnosis, projections: Sequence[Projection] | None = None) -> tuple[MatrixRow, ...]:
    """Return every land at every condition, lands in the controller's order.

    Parameters
    ----------
    projections
        those of the diagnosis that are wanted, in their order; all of them, the stated one first, unless given.
    """
    at = diagnosis.projections if projections is None else projections
    return tuple(MatrixRow.of(land, diagnosis, at) for land in diagnosis.lands)


def leaking_worst_first(diagnosis: Diagnosis, projections: Sequence[Projection] | None = None) -> tuple[MatrixRow, ...]:
    """Return the lands that leak at any of the conditions: the worst verdict first, then the largest share anywhere."""
    rows = [row for row in condition_matrix(diagnosis, projections) if row.leaks or row.land.verdict.flagged]
    return tuple(sorted(rows, key=lambda row: (-row.land.verdict.rank, -_largest(row))))


def land_at(land: LandDiagnosis, diagnosis: Diagnosis, projection: Projection) -> LandAtCondition:
    """Return what one land leaks at one of the conditions of its diagnosis."""
    shares = (rule for rule in land.rules if rule.kind is RuleKind.PAIR_SHARE)
    rule = next((rule for rule in shares if rule.condition == projection.condition), None)
    aside = [gap.gap for gap in projection.gaps_of(land.key) if gap.leakage > 0.0 and not gap.drawn_from_pump]
    return LandAtCondition(
        projection=projection,
        leakage=projection.leakage_of(land.key),
        drawn_from_pump=projection.drawn_by(land.key),
        share=projection.share_drawn_by(land.key),
        rule=rule,
        loss=diagnosis.loss_by(land, projection),
        verdict=_verdict(land, rule),
        circuits=tuple(dict.fromkeys(gap.low.section for gap in aside)),
    )


def _verdict(land: LandDiagnosis, rule: Rule | None) -> Verdict | None:
    """Return the verdict of a land's share; half a measurement can pass a limit, but never be called ok."""
    if rule is None:
        return None if land.state.judged else Verdict.NOT_MEASURED
    return rule.verdict if land.state.can_be_ok or rule.verdict.flagged else Verdict.NOT_MEASURED


def _largest(row: MatrixRow) -> float:
    return max((cell.share for cell in row.cells if math.isfinite(cell.share)), default=0.0)
