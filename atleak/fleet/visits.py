"""Tell which rows of a fleet are visits of one unit, which of them counts, and lay out the lands of all visits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from atleak.catalogue.repairs import LandKey
from atleak.common.errors import InputError, unknown
from atleak.common.sentences import Sentence
from atleak.common.verdicts import VERDICTS, Verdict
from atleak.fleet.columns import HASH, PARTITION
from atleak.fleet.results import Results
from atleak.fleet.sums import GROUP, MOST_GROUPS
from atleak.job_book.units import key_of_numbers

_COLUMNS = (
    *(HASH, PARTITION, "reference", "name", GROUP, "atleak", "evaluated_at"),
    *("number", "date", "measured_on", "vin", "serial", "mileage_km"),
    *("controller_name", "controller_sha256", "limits_sha256", "fluid_sha256", "profile"),
    *("readings_sha256", "lands_measured", "lands_judged", "lands_total"),
    *("verdict", "decision", "provisional"),
    *("decided_by_kind", "decided_by_component", "decided_by_land", "decided_by_circuit"),
    *("road_rows", "max_share_percent"),
)
_FIRST_MILEAGE = -1.0  # [km] of a visit without one, which comes before those with one of the same day


@dataclass(frozen=True)
class UnitVisits:
    """The rows of `units`, one for each visit, in the order of valve body, unit and time.

    Beside the columns of the data set they have ``unit``, a number of its own for each unit, ``label``, what it states
    under the heading that is asked for, ``by_lands``, whether any of its lands was judged, and two that say which visit
    of a unit counts: ``counts``, the last one at which anything was measured, else the last of all; and ``last_log``,
    the last one with a log.
    """

    rows: pd.DataFrame
    headings: tuple[str, ...]  # under which any of them states something
    by: str | None  # of those, the one that is asked for

    @property
    def counted(self) -> pd.DataFrame:
        """Return the visits that count, one for each unit."""
        return self.rows[self.rows["counts"]]

    def of(self, controller: str) -> UnitVisits:
        """Return the visits of one valve body."""
        return UnitVisits(self.rows[self.rows[PARTITION] == controller].reset_index(drop=True), self.headings, self.by)

    @cached_property
    def _hashes(self) -> pa.Array:
        return pa.array(self.rows[HASH], pa.string())

    def places(self, hashes: pa.ChunkedArray) -> np.ndarray:
        """Return the number of the row of each hash, −1 of those that are of none."""
        return pc.fill_null(pc.index_in(hashes, value_set=self._hashes), -1).to_numpy()


def read_visits(results: Results, *, by: str | None, controller: str | None) -> UnitVisits:
    """Read the rows of all units, or of those of one valve body.

    Raises
    ------
    InputError
        No unit states such a heading, too many different things stand there, or none is of such a valve body.
    """
    if controller is not None and controller not in results.controllers():
        raise unknown(Sentence("no unit of these results has such a valve body"), controller, results.controllers())
    table = results.table("units", [*_COLUMNS, "labels"], None if controller is None else [controller])
    table = table.sort_by(HASH)  # whatever was written first
    rows = table.drop_columns(["labels"]).to_pandas()
    headings = _headings(table)
    heading = None if by is None else _heading(by, headings)
    rows["label"] = None if heading is None else _groups(table, heading)
    rows["lands_measured"] = rows["lands_measured"].fillna(0)
    judged, by_sheet = rows["lands_judged"], rows["lands_measured"].gt(0) | rows["readings_sha256"].notna()
    rows["by_lands"] = judged.gt(0).where(judged.notna(), by_sheet)  # an earlier version does not say how many
    rows["provisional"] = rows["provisional"].eq(True)
    numbers = zip(table["serial"].to_pylist(), table["vin"].to_pylist(), strict=True)
    keys = [key_of_numbers(serial, vin) for serial, vin in numbers]
    identity = pd.Series(keys, dtype=object).fillna("row:" + rows[HASH])
    rows["told"] = [key is not None for key in keys]
    rows["unit"] = rows.groupby([PARTITION, identity], sort=False, dropna=False).ngroup()
    rows["day"] = pd.to_datetime(rows["date"].fillna(rows["measured_on"]))
    rows["driven"] = rows["mileage_km"].fillna(_FIRST_MILEAGE)
    rows = rows.sort_values(
        [PARTITION, "unit", "day", "driven", "evaluated_at", HASH], na_position="first", ignore_index=True
    )
    measured = rows["lands_measured"] > 0
    any_measured = measured.groupby(rows["unit"]).transform("any")
    rows["counts"] = _last(rows, measured | ~any_measured)
    rows["last_log"] = _last(rows, rows["road_rows"].notna())
    return UnitVisits(rows, headings, heading)


def _last(rows: pd.DataFrame, among: pd.Series) -> pd.Series:
    """Return whether each row is the last of its unit among some."""
    return among & ~rows["unit"].where(among).duplicated(keep="last")


def _headings(table: pa.Table) -> tuple[str, ...]:
    keys = {key for chunk in table["labels"].chunks for key in pc.unique(chunk.keys).to_pylist()}
    with_group = pc.any(pc.not_equal(pc.utf8_trim_whitespace(table[GROUP]), "")).as_py()
    return (*((GROUP,) if with_group else ()), *sorted(keys - {GROUP}))


def _heading(asked: str, headings: tuple[str, ...]) -> str:
    """Return the heading that is meant; capitals and blanks around it do not matter."""
    meant = asked.strip().casefold()
    found = [each for each in headings if each == asked] or [each for each in headings if each.casefold() == meant]
    if not found:
        raise unknown(Sentence("no unit of these results states anything under this heading"), asked, headings)
    return found[0]


def _groups(table: pa.Table, heading: str) -> pd.Series:
    """Return what each row states under a heading; not where next to every unit states something else."""
    stated = _stated(table, heading)
    if stated.nunique() > MOST_GROUPS:
        problem = Sentence("{count} different values stand under this heading", count=stated.nunique())
        expected = Sentence("a heading with at most {number} groups of units", number=MOST_GROUPS)
        raise InputError(problem, value=heading, expected=expected)
    return stated


def _stated(table: pa.Table, heading: str) -> pd.Series:
    column = table[GROUP] if heading == GROUP else pc.map_lookup(table["labels"], pa.scalar(heading), "first")
    text = pc.utf8_trim_whitespace(column)
    stated: pd.Series = pc.if_else(pc.equal(text, ""), None, text).to_pandas().astype(object)
    return stated.where(stated.notna(), None)


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


def read_lands(results: Results, controller: str, visits: UnitVisits) -> Lands:
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
