"""Count units by verdict and decision, what decided their verdicts, and which pairs give the most trouble."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pandas as pd

from atleak.fleet.lands import Lands
from atleak.fleet.summed import Decider, Group, PairTrouble, VerdictCounts
from atleak.spreads import rate, spread
from atleak.uncertainty import DECISIONS, Decision
from atleak.verdicts import FLAGGED, VERDICTS, Verdict

_DECIDED_BY = ["decided_by_kind", "decided_by_component", "decided_by_land", "decided_by_circuit"]


def counts_of(units: pd.DataFrame) -> VerdictCounts:
    """Count some units, a row each."""
    said, decided = units["verdict"].value_counts().to_dict(), units["decision"].value_counts().to_dict()
    verdicts = {verdict: int(said.get(verdict, 0)) for verdict in VERDICTS}
    decisions: dict[Decision | None, int] = {decision: int(decided.get(decision, 0)) for decision in DECISIONS}
    with_verdict = units["verdict"] != Verdict.NOT_MEASURED
    by_lands = with_verdict & units["by_lands"]
    ranks = units["verdict"][by_lands].map({str(verdict): verdict.rank for verdict in Verdict})
    in_part = (units["verdict"] == Verdict.OK) & (units["lands_measured"] < units["lands_total"])
    return VerdictCounts(
        units=len(units),
        verdicts=verdicts,
        decisions={**decisions, None: len(units) - sum(decisions.values())},
        provisional=int(units["provisional"].sum()),
        ok_in_part=int(in_part.sum()),
        rates={level: rate(int((ranks >= level.rank).sum()), len(ranks)) for level in FLAGGED},
        without_sheet=int((with_verdict & ~by_lands).sum()),
    )


def deciders_of(units: pd.DataFrame) -> tuple[Decider, ...]:
    """Count what gave the verdicts of the flagged units, the most frequent first."""
    flagged = units[units["verdict"].isin(FLAGGED)]
    by_what = flagged.groupby(_DECIDED_BY, dropna=False)
    return tuple(sorted((_decider(mine.iloc[0], len(mine), len(flagged)) for _, mine in by_what), key=_most_first))


def _decider(unit: pd.Series, count: int, flagged: int) -> Decider:
    kind, component, land, circuit = (None if pd.isna(unit[each]) else unit[each] for each in _DECIDED_BY)
    return Decider(str(kind), component, None if land is None else int(land), circuit, rate(count, flagged))


def _most_first(decider: Decider) -> tuple[Any, ...]:
    return -decider.units.count, decider.kind, decider.component or "", decider.land or 0, decider.circuit or ""


def groups_of(units: pd.DataFrame) -> tuple[Group, ...]:
    """Count the units of every group, by name; those that state none are in none."""
    return tuple(
        Group(str(name), counts_of(mine), spread(mine["mileage_km"]), int(mine["mileage_km"].isna().sum()))
        for name, mine in units.groupby("label", sort=True)
    )


def troubles_of(lands: Lands, deciders: Iterable[Decider], judged: int) -> tuple[PairTrouble, ...]:
    """Return how often each land is flagged and past *replace* and decides, the most often past *replace* first.

    Parameters
    ----------
    lands
        of the units of one valve body.
    deciders
        of the same.
    judged
        how many of the units have a verdict.
    """
    measured, flagged = lands.measured.sum(axis=0), lands.rank >= FLAGGED[0].rank
    replace = (lands.measured & (lands.rank >= Verdict.REPLACE.rank)).sum(axis=0)
    by_both, by_one = (lands.measured & flagged).sum(axis=0), (~lands.measured & flagged).sum(axis=0)
    deciding = {(each.component, each.land): each.units.count for each in deciders}
    troubles = (
        PairTrouble(
            key=key,
            flagged=rate(by_both[place], measured[place]),
            replace=rate(replace[place], measured[place]),
            deciding=rate(deciding.get(key, 0), judged),
            not_measured=len(lands.measured) - int(measured[place]),
            flagged_by_one_part=int(by_one[place]),
        )
        for place, key in enumerate(lands.keys)
    )
    # sorted keeps the order of components where all are even
    return tuple(sorted(troubles, key=lambda each: (-each.replace.count, -each.flagged.count, -each.deciding.count)))
