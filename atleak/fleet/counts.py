"""Count a fleet's units by verdict and decision; say how wear depends on mileage, shares and pressures on warmth.

Rows of one unit are its visits: the last of them counts, and the lands of all are laid out beside one another.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from atleak.analysis.rates import rate, spread
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import InputError, unknown
from atleak.common.sentences import Sentence
from atleak.common.units import PERCENT
from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS, Band, Verdict
from atleak.diagnosis.uncertainty import DECISIONS, Decision
from atleak.fleet.columns import HASH, PARTITION, DataSet
from atleak.fleet.results import Results
from atleak.fleet.sums import (
    GROUP,
    MOST_GROUPS,
    ConditionSpread,
    Decider,
    Group,
    LandOverMileage,
    MileageClass,
    PairTrouble,
    TemperatureSums,
    VerdictCounts,
)
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
_CLEARANCES = ("mounting_clearance_low_um", "radial_clearance_um", "mounting_clearance_um")
_OF_LANDS = (HASH, "component", "land", "measured", "seal", "fitted_repair", "wear_percent", "verdict", *_CLEARANCES)
_DECIDED_BY = ["decided_by_kind", "decided_by_component", "decided_by_land", "decided_by_circuit"]
_WIDTHS = (5_000.0, 10_000.0, 20_000.0, 25_000.0, 50_000.0, 100_000.0)  # [km] of a class of mileage
_CLASSES, _MOST_UNITS = 8, 0.95  # of which so many hold so great a part of the visits: choices of this project
_BAND_SECONDS = tuple(f"{band}_s" for band in BANDS)
_OF_CLASSES = (
    *(HASH, "temperature_low_c", "temperature_high_c", "seconds", *_BAND_SECONDS),
    *("share_mean_percent", "share_max_percent", "pressure_mean_kpa", "pressure_min_kpa"),
)
_CONDITION = ["name", "temperature_c", "engine_rpm", "gear"]
_OF_CONDITIONS = (HASH, *_CONDITION, "label", "p_g_kpa", "p_g_held_kpa", "share_percent", "band")


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


def counts_of(units: pd.DataFrame) -> VerdictCounts:
    """Count some units, a row each."""
    counted, decided = units["verdict"].value_counts().to_dict(), units["decision"].value_counts().to_dict()
    verdicts = {verdict: int(counted.get(verdict, 0)) for verdict in VERDICTS}
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

    ``lands`` and ``deciders`` are of the units of one valve body; ``judged`` counts those with a verdict.
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


def class_width(mileages: np.ndarray) -> float:
    """Return the width of the classes of mileage [km]: the narrowest round one by which there are few of them."""
    known = mileages[~np.isnan(mileages)]
    wanted = float(np.quantile(known, _MOST_UNITS)) / _CLASSES if known.size else 0.0
    return next((width for width in _WIDTHS if width >= wanted), _WIDTHS[-1])


def classes_of(mileages: np.ndarray, width: float) -> np.ndarray:
    """Return the number of the class of each mileage; NaN without one."""
    return np.floor(mileages / width)


def wear_by_mileage(visits: UnitVisits, lands: Lands) -> tuple[LandOverMileage, ...]:
    """Return the wear of every land of a valve body over mileage; all visits count."""
    mileage, unit = visits.rows["mileage_km"].to_numpy(float), visits.rows["unit"].to_numpy()
    width = class_width(mileage)
    number = classes_of(mileage, width)
    latest = lands.at(visits.rows["counts"].to_numpy())
    measured, repaired = ~np.isnan(lands.wear), (lands.measured & lands.repaired).sum(axis=0)
    found = []
    for place, key in enumerate(lands.keys):
        there = np.flatnonzero(measured[:, place] & ~np.isnan(number))
        found.append(
            LandOverMileage(
                key=key,
                classes=tuple(_classes(lands.wear[there, place], unit[there], number[there], width)),
                without_mileage=int(measured[:, place].sum()) - len(there),
                repaired=int(repaired[place]),
                latest_percent=spread(latest.wear[:, place]),
            )
        )
    return tuple(found)


def _classes(wear: np.ndarray, unit: np.ndarray, number: np.ndarray, width: float) -> Iterator[MileageClass]:
    """Yield the classes of one land, from its measurements in the order of time; of a unit the last counts."""
    for each in np.unique(number):
        within = np.flatnonzero(number == each)[::-1]
        _, last = np.unique(unit[within], return_index=True)
        percent = spread(wear[within[last]])
        if percent is not None:
            yield MileageClass(float(each * width), float((each + 1.0) * width), percent)


def temperatures_of(results: Results, controller: str, visits: UnitVisits) -> tuple[TemperatureSums, ...]:
    """Return the classes of fluid temperature that the logs of a valve body's units pass through, the coldest first.

    Of every unit its last log counts.
    """
    rows = _rows(results, "temperatures", _OF_CLASSES, controller, visits, "last_log")
    return tuple(_class(mine) for _, mine in rows.groupby(["temperature_low_c", "temperature_high_c"], sort=True))


def _class(units: pd.DataFrame) -> TemperatureSums:
    in_bands = units[list(_BAND_SECONDS)].sum()
    in_any = float(in_bands.sum())
    shares = {band: float(in_bands[f"{band}_s"] / in_any * PERCENT) for band in BANDS} if in_any else None
    in_part = float(units.loc[units["lands_measured"] < units["lands_total"], f"{Band.GREEN}_s"].sum())
    return TemperatureSums(
        low_c=float(units["temperature_low_c"].iloc[0]),
        high_c=float(units["temperature_high_c"].iloc[0]),
        seconds=float(units["seconds"].sum()),
        share_mean_percent=_over_time(units, "share_mean_percent"),
        share_percent=spread(units["share_mean_percent"]),
        share_max_percent=_or_none(units["share_max_percent"].max()),
        pressure_mean_kpa=_over_time(units, "pressure_mean_kpa"),
        pressure_kpa=spread(units["pressure_mean_kpa"]),
        pressure_min_kpa=_or_none(units["pressure_min_kpa"].min()),
        bands_percent=shares,
        green_in_part_percent=in_part / in_any * PERCENT if in_any else 0.0,
    )


def _over_time(units: pd.DataFrame, column: str) -> float | None:
    """Return the mean of all units' time; None where no unit has a number."""
    known = units[units[column].notna()]
    seconds = known["seconds"].sum()
    return float((known[column] * known["seconds"]).sum() / seconds) if seconds else None


def conditions_of(results: Results, controller: str, visits: UnitVisits) -> tuple[ConditionSpread, ...]:
    """Return the stated conditions over the units of a valve body of which anything was measured."""
    rows = _rows(results, "conditions", _OF_CONDITIONS, controller, visits, "counts")
    rows = rows[rows["lands_measured"] > 0]
    return tuple(_conditions(rows))


def _conditions(rows: pd.DataFrame) -> Iterator[ConditionSpread]:
    for _, mine in rows.groupby(_CONDITION, sort=False):
        first = mine.iloc[0]
        bands: dict[Band, int] = {band: int((mine["band"] == band).sum()) for band in BANDS}
        required = mine["p_g_kpa"].unique()
        yield ConditionSpread(
            name=first["name"],
            label=first["label"],
            temperature_c=float(first["temperature_c"]),
            engine_rpm=float(first["engine_rpm"]),
            gear=int(first["gear"]),
            required_kpa=_or_none(required[0]) if len(required) == 1 else None,
            share_percent=spread(mine["share_percent"]),
            pressure_held_kpa=spread(mine["p_g_held_kpa"]),
            bands=bands,
            partly=int((mine["lands_measured"] < mine["lands_total"]).sum()),
        )


def _rows(
    results: Results, data_set: DataSet, columns: tuple[str, ...], controller: str, visits: UnitVisits, which: str
) -> pd.DataFrame:
    """Return the rows of a data set that are of the visits that count, in their order."""
    table = results.table(data_set, columns, [controller])
    places = visits.places(table[HASH])
    rows = table.drop_columns([HASH]).to_pandas()
    rows["place"] = places
    rows = rows[(places >= 0) & visits.rows[which].to_numpy()[places]].sort_values("place", kind="stable")
    return rows.join(visits.rows[["lands_measured", "lands_total"]], on="place")


def _or_none(value: float) -> float | None:
    return None if pd.isna(value) else float(value)
