"""Lay out lands as a table of words: verdict, name, share at each condition, wear, clearance, what decided."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import partial

from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.land_diagnosis import LandDiagnosis
from atleak.verdicts import Verdict
from atleak.views.condition_matrix import LandAtCondition, land_at
from atleak.views.sentences import land_in_words, rule_reached, wear_words
from atleak.views.table import VERDICT, Column, Judged, Table
from atleak.wording import Wording
from atleak.workshop_units import MM, UM


def pair_table(
    diagnosis: Diagnosis,
    lands: Sequence[LandDiagnosis],
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

    def share_at(projection: Projection, land: LandDiagnosis) -> Judged:
        return share_cell(land_at(land, diagnosis, projection), say)

    at = diagnosis.reported if at is None else at
    shares = (
        Column(
            each.condition.name,
            words=say("diagnosis.column_share", condition=say.condition(each.condition)),
            of=partial(share_at, each),
        )
        for each in at
    )
    columns = (
        Column("verdict", VERDICT),
        Column("pair", of=lambda land: land_in_words(diagnosis, land.key, say)),
        *shares,
        Column("clearance", of=lambda land: clearance(land, say)),
        Column("wear", of=lambda land: wear_words(land, say)),
        Column("decided_by", of=lambda land: "; ".join(why(land, say)) or None),
        Column("decision", of=lambda land: land.decision and decision(land, say)),
    )
    return Table("lands", columns, lands, say)


def share_cell(cell: LandAtCondition, say: Wording) -> Judged:
    """Return a share at one condition in the colour of its own verdict; nothing where nothing leaks."""
    if cell.leakage == 0.0:
        return Judged(None)
    return Judged(say.percent(cell.share, 2) if math.isfinite(cell.share) else say("diagnosis.no_flow"), cell.verdict)


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
