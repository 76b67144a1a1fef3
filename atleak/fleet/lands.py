"""Lay out the lands of one valve body: a row for each visit, a column for each land."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from atleak.fleet.columns import HASH
from atleak.fleet.results import Results
from atleak.fleet.visits import Visits
from atleak.rules import LandKey
from atleak.verdicts import VERDICTS, Verdict

_CLEARANCES = ("mounting_clearance_low_um", "radial_clearance_um", "mounting_clearance_um")
_OF_LANDS = (HASH, "component", "land", "measured", "seal", "fitted_repair", "wear_percent", "verdict", *_CLEARANCES)


@dataclass(frozen=True)
class Lands:
    """What is known of every land (column) at every visit (row) of a valve body, in the order of `Visits.rows`."""

    keys: tuple[LandKey, ...]  # by component and land
    measured: np.ndarray  # whether both of its parts were, and no ring seals it
    rank: np.ndarray  # of its verdict
    repaired: np.ndarray  # whether a repair was fitted
    wear: np.ndarray  # [%]; none within what new ones have; NaN where not measured, and of a land that was repaired

    def at(self, visits: np.ndarray) -> Lands:
        """Return the same at some visits."""
        return Lands(self.keys, *(each[visits] for each in (self.measured, self.rank, self.repaired, self.wear)))


def read_lands(results: Results, controller: str, visits: Visits) -> Lands:
    """Read the lands of one valve body."""
    frame = results.table("lands", _OF_LANDS, [controller])
    frame = frame.to_pandas().assign(visit=visits.places(frame[HASH]))
    frame = frame[frame["visit"] >= 0]
    low, clearance, high = (frame[name] for name in _CLEARANCES)
    frame = frame.assign(
        measured=(frame["measured"] == "measured") & frame["seal"].isna(),
        repaired=frame["fitted_repair"].notna(),
        rank=frame["verdict"].map({str(each): each.rank for each in VERDICTS}),
        wear=frame["wear_percent"].mask((low < high) & (low <= clearance) & (clearance <= high), 0.0),
    )
    keys = sorted(set(zip(frame["component"], frame["land"], strict=True)), key=_by_number)

    def laid_out(name: str) -> pd.DataFrame:
        wide = frame.pivot(index="visit", columns=["component", "land"], values=name)  # noqa: PD010 - nothing to average
        return wide[keys].reindex(visits.rows.index)

    measured, repaired = (laid_out(name).eq(True).to_numpy(bool) for name in ("measured", "repaired"))
    return Lands(
        keys=tuple(keys),
        measured=measured,
        rank=laid_out("rank").fillna(Verdict.NOT_MEASURED.rank).to_numpy(int),
        repaired=repaired,
        wear=np.where(measured & ~repaired, laid_out("wear").to_numpy(float), np.nan),
    )


def _by_number(key: LandKey) -> tuple[tuple[int, str], int]:
    """Return what sorts components as people count them: 2 before 10."""
    component, land = key
    digits = "".join(letter for letter in component if letter.isdigit())
    return (int(digits) if digits else 0, component), land
