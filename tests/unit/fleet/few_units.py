"""Results of a few units that a test states one by one."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pyarrow as pa

from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import Verdict, worst
from atleak.fleet.columns import HASH, DataSet, Rows, columns_of
from atleak.fleet.results import Results
from atleak.version import __version__


@dataclass(frozen=True)
class Measured:
    """A land as it was measured: its wear [%], its verdict, and what is particular about it."""

    wear: float | None = 10.0
    verdict: Verdict = Verdict.OK
    status: str = "measured"
    seal: str | None = None
    fitted_repair: str | None = None
    clearances: tuple[float | None, ...] = (None, None, None)  # [µm] of the narrowest new pair, as measured, the widest


@dataclass(frozen=True)
class Unit:
    """A row of `units` and what belongs to it; what a test does not state is plain."""

    name: str
    lands: Mapping[LandKey, Measured] = field(default_factory=dict)
    controller: str = "body_a"
    verdict: Verdict | None = None  # the worst of its lands unless given
    conditions: Sequence[Mapping[str, Any]] = ()
    temperatures: Sequence[Mapping[str, Any]] = ()
    own: Mapping[str, Any] = field(default_factory=dict)  # columns of `units`

    @property
    def input_sha256(self) -> str:
        return hashlib.sha256(self.name.encode()).hexdigest()

    @property
    def judged(self) -> Verdict:
        if self.verdict is not None:
            return self.verdict
        verdicts = [each.verdict for each in self.lands.values() if each.verdict is not Verdict.NOT_MEASURED]
        return worst(verdicts) if verdicts else Verdict.NOT_MEASURED

    def rows(self) -> Rows:
        sha256 = self.input_sha256
        decided = next((key for key, each in self.lands.items() if each.verdict == self.judged), None)
        of_unit = {
            "reference": f"file:/{self.name}",
            "name": self.name,
            "atleak": __version__,
            "evaluated_at": dt.datetime(2026, 4, 1, tzinfo=dt.UTC),
            "serial": f"S-{self.name} 1",
            "lands_measured": sum(each.status != "not_measured" for each in self.lands.values()),
            "lands_total": len(self.lands),
            "verdict": self.judged,
            "decision": "fail" if self.judged.flagged else "pass",
            "provisional": False,
            "road_rows": 1200 if self.temperatures else None,
            **self.own,
        }
        if self.judged.flagged and decided is not None:
            names = ("decided_by_kind", "decided_by_component", "decided_by_land")
            of_unit = dict(zip(names, ("land", *decided), strict=True)) | of_unit
        of_lands = [
            {
                "component": component,
                "land": land,
                "measured": each.status,
                "seal": each.seal,
                "fitted_repair": each.fitted_repair,
                "wear_percent": each.wear,
                "verdict": each.verdict,
                "mounting_clearance_low_um": each.clearances[0],
                "radial_clearance_um": each.clearances[1],
                "mounting_clearance_um": each.clearances[2],
            }
            for (component, land), each in self.lands.items()
        ]
        rows: dict[DataSet, Sequence[Mapping[str, Any]]] = {
            "units": [of_unit],
            "lands": of_lands,
            "conditions": self.conditions,
            "temperatures": self.temperatures,
        }
        tables = {name: _table(name, [{HASH: sha256, **row} for row in of_set]) for name, of_set in rows.items()}
        return Rows(self.controller, sha256, of_unit["reference"], self.judged, tables)


def results_of(folder: Path, units: Iterable[Unit]) -> Results:
    """Write the results of some units; open for reading."""
    with Results.open(folder, for_writing=True) as results:
        results.add([unit.rows() for unit in units])
    return Results.open(folder)


def condition(share: float | None = 20.0, **others: Any) -> dict[str, Any]:
    """A stated condition."""
    plain = {"name": "hot_idle", "label": "hot idle", "temperature_c": 110.0, "engine_rpm": 750.0, "gear": 1}
    return {**plain, "p_g_kpa": 450.0, "p_g_held_kpa": 440.0, "share_percent": share, "band": "green", **others}


def temperature_class(low: float = 80.0, **others: Any) -> dict[str, Any]:
    """A class of temperature of a log."""
    plain = {"temperature_low_c": low, "temperature_high_c": low + 5.0, "seconds": 60.0, "share_mean_percent": 10.0}
    return {**plain, "share_max_percent": 15.0, "pressure_mean_kpa": 500.0, "pressure_min_kpa": 400.0, **others}


def _table(data_set: DataSet, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    schema = columns_of(data_set)
    return pa.table([pa.array([row.get(column.name) for row in rows], column.type) for column in schema], schema=schema)
