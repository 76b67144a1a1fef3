"""Say how share and pressure depend on temperature: as logs met it, and at the stated conditions."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from atleak.fleet.columns import HASH, DataSet
from atleak.fleet.results import Results
from atleak.fleet.summed import ConditionSpread, TemperatureClass
from atleak.fleet.visits import Visits
from atleak.spreads import spread
from atleak.verdicts import BANDS, Band
from atleak.workshop_units import PERCENT

_BAND_SECONDS = tuple(f"{band}_s" for band in BANDS)
_OF_CLASSES = (
    *(HASH, "temperature_low_c", "temperature_high_c", "seconds", *_BAND_SECONDS),
    *("share_mean_percent", "share_max_percent", "pressure_mean_kpa", "pressure_min_kpa"),
)
_CONDITION = ["name", "temperature_c", "engine_rpm", "gear"]
_OF_CONDITIONS = (HASH, *_CONDITION, "label", "p_g_kpa", "p_g_held_kpa", "share_percent", "band")


def temperatures_of(results: Results, controller: str, visits: Visits) -> tuple[TemperatureClass, ...]:
    """Return the classes of fluid temperature that the logs of a valve body's units pass through, the coldest first.

    Of every unit its last log counts.
    """
    rows = _rows(results, "temperatures", _OF_CLASSES, controller, visits, "last_log")
    return tuple(_class(mine) for _, mine in rows.groupby(["temperature_low_c", "temperature_high_c"], sort=True))


def _class(units: pd.DataFrame) -> TemperatureClass:
    in_bands = units[list(_BAND_SECONDS)].sum()
    in_any = float(in_bands.sum())
    shares = {band: float(in_bands[f"{band}_s"] / in_any * PERCENT) for band in BANDS} if in_any else None
    in_part = float(units.loc[units["lands_measured"] < units["lands_total"], f"{Band.GREEN}_s"].sum())
    return TemperatureClass(
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


def conditions_of(results: Results, controller: str, visits: Visits) -> tuple[ConditionSpread, ...]:
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
    results: Results, data_set: DataSet, columns: tuple[str, ...], controller: str, visits: Visits, which: str
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
