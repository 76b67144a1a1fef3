"""Find the pairs that give the most trouble."""

from __future__ import annotations

import numpy as np
import pandas as pd

from atleak.fleet.lands import Lands
from atleak.fleet.spreading import rate
from atleak.fleet.summed import PairTrouble
from atleak.verdicts import FLAGGED, Verdict


def troubles_of(units: pd.DataFrame, lands: Lands, judged: int) -> tuple[PairTrouble, ...]:
    """Return how often each land is flagged and past *replace* and decides, the most often past *replace* first.

    Parameters
    ----------
    units
        of one valve body, a row each.
    lands
        of the same rows.
    judged
        how many of the units have a verdict.
    """
    measured, flagged = lands.measured.sum(axis=0), lands.rank >= FLAGGED[0].rank
    replace = (lands.measured & (lands.rank >= Verdict.REPLACE.rank)).sum(axis=0)
    by_both, by_one = (lands.measured & flagged).sum(axis=0), (~lands.measured & flagged).sum(axis=0)
    deciding = _deciding(units, lands)
    troubles = (
        PairTrouble(
            key=key,
            flagged=rate(by_both[place], measured[place]),
            replace=rate(replace[place], measured[place]),
            deciding=rate(deciding[place], judged),
            not_measured=len(units) - int(measured[place]),
            flagged_by_one_part=int(by_one[place]),
        )
        for place, key in enumerate(lands.keys)
    )
    # sorted keeps the order of components where all are even
    return tuple(sorted(troubles, key=lambda each: (-each.replace.count, -each.flagged.count, -each.deciding.count)))


def _deciding(units: pd.DataFrame, lands: Lands) -> np.ndarray:
    """Return how many units each land gave their verdict."""
    decided = units[units["verdict"].isin(FLAGGED) & units["decided_by_land"].notna()]
    keys = zip(decided["decided_by_component"], decided["decided_by_land"].astype(int), strict=True)
    counted = pd.Series(list(keys), dtype=object).value_counts()
    return np.array([counted.get(key, 0) for key in lands.keys])
