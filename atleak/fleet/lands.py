"""Lay out the lands of one valve body: a row for each visit, a column for each land."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from atleak.fleet.columns import HASH
from atleak.fleet.results import Results
from atleak.fleet.visits import Visits
from atleak.rules import LandKey
from atleak.verdicts import VERDICTS, Verdict

_CLEARANCES = ("mounting_clearance_low_um", "radial_clearance_um", "mounting_clearance_um")
_COLUMNS = (HASH, "component", "land", "measured", "seal", "fitted_repair", "wear_percent", "verdict", *_CLEARANCES)
Table = np.ndarray
"""A value of every land (column) at every visit (row)."""


@dataclass(frozen=True)
class Lands:
    """What is known of every land at every visit of a valve body, in the order of `Visits.rows`."""

    keys: tuple[LandKey, ...]  # by component and land
    measured: Table  # whether both of its parts were, and no ring seals it
    rank: Table  # of its verdict
    repaired: Table  # whether a repair was fitted
    wear: Table  # [%]; none within what new ones have; NaN where not measured, and of a land that was repaired

    def at(self, visits: np.ndarray) -> Lands:
        """Return the same at some visits."""
        return Lands(self.keys, *(each[visits] for each in (self.measured, self.rank, self.repaired, self.wear)))


def read_lands(results: Results, controller: str, visits: Visits) -> Lands:
    """Read the lands of one valve body."""
    table = results.table("lands", _COLUMNS, [controller])
    places = visits.places(table[HASH])
    table, places = table.filter(pa.array(places >= 0)), places[places >= 0]
    component, land = table["component"].combine_chunks().dictionary_encode(), table["land"].to_numpy()
    names = component.dictionary.to_pylist()
    codes = component.indices.to_numpy()
    pairs, column = np.unique(np.stack([codes, land], axis=1), axis=0, return_inverse=True)
    keys = [(names[code], int(number)) for code, number in pairs]
    order = sorted(range(len(keys)), key=lambda each: _by_number(keys[each]))
    column = np.argsort(order)[column.ravel()]
    shape = (len(visits.rows), len(keys))

    def laid_out(values: np.ndarray, otherwise: float | bool) -> Table:
        out = np.full(shape, otherwise, dtype=values.dtype)
        out[places, column] = values
        return out

    ranks = pc.index_in(table["verdict"], value_set=pa.array([str(each) for each in VERDICTS]))
    measured = laid_out(pc.and_(pc.equal(table["measured"], "measured"), pc.is_null(table["seal"])).to_numpy(), False)
    repaired = laid_out(pc.is_valid(table["fitted_repair"]).to_numpy(), False)
    low, clearance, high = (table[name].to_numpy() for name in _CLEARANCES)
    within_new = (low < high) & (low <= clearance) & (clearance <= high)
    wear = laid_out(np.where(within_new, 0.0, table["wear_percent"].to_numpy()), np.nan)
    return Lands(
        keys=tuple(keys[each] for each in order),
        measured=measured,
        rank=laid_out(pc.fill_null(ranks, 0).to_numpy(), Verdict.NOT_MEASURED.rank),
        repaired=repaired,
        wear=np.where(measured & ~repaired, wear, np.nan),
    )


def _by_number(key: LandKey) -> tuple[tuple[int, str], int]:
    """Return what sorts components as people count them: 2 before 10."""
    component, land = key
    digits = "".join(letter for letter in component if letter.isdigit())
    return (int(digits) if digits else 0, component), land
