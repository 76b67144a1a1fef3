"""Lay out lands as a table of words: verdict, name, share at each condition, wear, clearance, what decided."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import LandKey
from atleak.verdicts import Band, Verdict
from atleak.views.condition_matrix import LandAtCondition, MatrixRow
from atleak.views.sentences import land_in_words, rule_reached, wear_words
from atleak.wording import Wording
from atleak.workshop_units import MM, PERCENT, UM


@dataclass(frozen=True)
class Cell:
    """A cell's text, and the verdict in whose colour it stands."""

    text: str
    level: Verdict | Band | None = None


@dataclass(frozen=True)
class Row:
    """A row of a table; ``key`` is the land that it is about."""

    key: LandKey | None
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Table:
    """A table in a reader's language: as many cells in every row as there are headings."""

    headings: tuple[str, ...]
    rows: tuple[Row, ...]


def pair_table(
    diagnosis: Diagnosis,
    lands: Iterable[LandDiagnosis],
    say: Wording,
    *,
    at: Sequence[Projection] | None = None,
) -> Table:
    """Return lands as a table, in their order.

    Parameters
    ----------
    at
        the conditions whose shares are wanted; those that every report must show unless given.
    """
    at = diagnosis.reported if at is None else at
    headings = [say("diagnosis.column_verdict"), say("diagnosis.column_pair")]
    headings += [say("diagnosis.column_share", condition=say.condition(each.condition)) for each in at]
    headings += [say(f"diagnosis.column_{name}") for name in ("clearance", "wear", "decided_by", "decision")]
    rows = tuple(Row(land.key, tuple(_cells(diagnosis, land, at, say))) for land in lands)
    return Table(tuple(headings), rows)


def _cells(diagnosis: Diagnosis, land: LandDiagnosis, at: Sequence[Projection], say: Wording) -> Iterable[Cell]:
    yield Cell(say.signed(land.verdict), land.verdict)
    yield Cell(land_in_words(diagnosis, land.key, say))
    for cell in MatrixRow.of(land, diagnosis, at).cells:
        yield share_cell(cell, say)
    yield Cell(clearance(land, say))
    yield Cell(wear_words(land, say))
    yield Cell("; ".join(why(land, say)) or "–")
    yield Cell("–" if land.decision is None else decision(land, say))


def share_cell(cell: LandAtCondition, say: Wording) -> Cell:
    """Return a share at one condition with the sign of its own verdict; a dash where nothing leaks."""
    if cell.leakage == 0.0:
        return Cell("–")
    text = say.number(cell.share * PERCENT, 2) if math.isfinite(cell.share) else say("diagnosis.no_flow")
    return Cell(f"{text}\u00a0%" if math.isfinite(cell.share) else text, cell.verdict)


def clearance(land: LandDiagnosis, say: Wording) -> str:
    """Return the radial clearance with its 95 % interval; without one where nothing was measured."""
    value = say.quantity(land.state.radial_clearance * UM, "clearance")
    interval = land.uncertainty.clearance_interval if land.uncertainty else None
    if interval is None:
        return value
    low, high = (say.spelled(end * UM, "clearance") for end in interval)
    return say("diagnosis.between", value=value, low=low, high=high)


def why(land: LandDiagnosis, say: Wording) -> Iterable[str]:
    """Say which rule gave the verdict, which part was not measured, and what contradicts itself."""
    rule = None if land.verdict == Verdict.NOT_MEASURED else land.deciding
    if rule is not None:
        yield rule_reached(rule, say)
    if land.state.status == "spool_only":
        yield say("diagnosis.sleeve_unmeasured")
    elif land.state.status == "sleeve_only":
        yield say("diagnosis.spool_unmeasured")
    yield from doubts(land, say)


def doubts(land: LandDiagnosis, say: Wording) -> Iterable[str]:
    """Say what in a land's readings contradicts itself, and what was made of it."""
    for doubt in land.state.doubts:
        first = doubt.repeats[0]
        values = ", ".join(say.quantity(each.diameter * MM, "length", 4) for each in doubt.repeats)
        yield say(
            "diagnosis.slip_left_out" if doubt.agreed else "diagnosis.repeats_apart",
            part=say(f"diagnosis.{first.part}"),
            plane=first.plane,
            apart=say.quantity(doubt.apart * UM, "clearance"),
            values=values,
        )
    if land.suspect:
        yield say("diagnosis.tighter_than_new")


def decision(land: LandDiagnosis, say: Wording) -> str:
    """Say how sure the verdict is, and how likely the true value is past the limit."""
    words = say.get("decisions", str(land.decision))
    chance = land.probability_over_limit
    return words if chance is None else say("diagnosis.chance", decision=words, chance=say.percent(chance, 0))
