"""Results of a fleet that nobody diagnosed: made up by chance, in the data sets that a run writes."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pyarrow as pa

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import BANDS, Verdict
from atleak.fleet.columns import ERROR_KINDS, HASH, DataSet, Rows, columns_of
from atleak.fleet.results import Results
from atleak.fleet.summary import summed_up
from atleak.fleet.sums import FleetSummary
from atleak.version import __version__

CONTROLLERS = ("four_speed_2023", "five_speed_2005")
GROUPS = ("north", "south", "west")
WORSE = "west"  # its units are worn by `WORSE_BY` more than those of the others
WORSE_BY = 12.0  # [percentage points]
SUPPLIERS = ("Almar", "Borsig")  # of which neither is worse
POINTS = ("hot_idle", "cruise", "cold_start")  # names of the conditions
POINT_TEMPERATURES = (110.0, 90.0, 20.0)  # [°C]
CLASSES = tuple(range(60, 110, 5))  # [°C] lower ends of the classes of fluid temperature
ERRORS = 4  # one of each kind
_BEGUN = dt.datetime(2026, 4, 1, 18, tzinfo=dt.UTC)


@dataclass(frozen=True)
class Fleet:
    """What a made-up fleet is like; units of `varied` ones are measured in part or not, and decided in other ways."""

    controllers: Sequence[str] = CONTROLLERS
    suppliers: Sequence[str] = SUPPLIERS
    keys: Sequence[LandKey] | None = None  # of all lands; unless given, those of the valve body
    lands: int | None = None  # so many of them alone
    logs: bool = True
    mileage: bool = True
    flagged: bool = True
    errors: bool = True
    name: str = "{group}/unit_{number:05}.zip"
    varied: bool = False

    def worn(self, controller: str) -> tuple[Sequence[LandKey], np.ndarray]:
        """The lands of a valve body, and the largest clearance of each when new [µm]."""
        if self.keys is not None:
            return self.keys[: self.lands], np.full(len(self.keys[: self.lands]), 20.0)
        lands = load_controller(controller).lands[: self.lands]
        return [land.key for land in lands], np.array([land.mounting_high * 1e6 for land in lands])


@cache
def summary(
    controllers: tuple[str, ...] = ("four_speed_2023",),
    *,
    units: int = 200,
    groups: tuple[str, ...] = GROUPS,
    **more: Any,
) -> FleetSummary:
    """The summary of a varied fleet by supplier; each valve body has so many units."""
    fleet = Fleet(controllers, groups, varied=True, **more)
    with TemporaryDirectory(prefix="atleak-test-") as folder:
        results = made_up_results(Path(folder) / "results of week 17", units * len(controllers), fleet=fleet)
        made = summed_up(results, by="supplier" if groups else None)
    return replace(made, folder="/hall/results of week 17")


def made_up_results(folder: Path, units: int = 200, seed: int = 18, fleet: Fleet = Fleet()) -> Results:
    """Write the results of a fleet, open for reading: two valve bodies, three groups, two suppliers, some errors.

    Wear grows with the mileage, of every land at its own rate; units of the group `WORSE` are worn more, and
    suppliers do not differ.
    """
    random = np.random.default_rng(seed)
    rows: list[Rows] = []
    each, more = divmod(units, len(fleet.controllers))
    for number, controller in enumerate(fleet.controllers):
        rows += _of_controller(controller, each + (number < more), len(rows), random, fleet)
    rows += [_error(number, kind) for number, kind in enumerate(ERROR_KINDS)] if fleet.errors else []
    with Results.open(folder, for_writing=True) as results:
        results.add(rows)
    return Results.open(folder)


def _of_controller(controller: str, units: int, first: int, random: np.random.Generator, fleet: Fleet) -> list[Rows]:
    keys, mounting = fleet.worn(controller)
    group = random.choice(GROUPS, units)
    mileage = np.where(random.random(units) < 0.05, np.nan, random.uniform(20e3, 320e3, units))
    rate = random.uniform(2.0, 25.0, len(keys))  # [%] per 100 000 km of each land
    driven = np.where(np.isnan(mileage), 150e3, mileage)[:, None] / 100e3
    wear = driven * rate * random.lognormal(0.0, 0.25, (units, len(keys))) + WORSE_BY * (group == WORSE)[:, None]
    wear[random.random(wear.shape) < 0.02] = np.nan
    if fleet.varied:
        wear[7::17] = np.nan  # units of which nothing was measured
        wear[::3, :1] = np.nan if len(keys) > 1 else wear[::3, :1]
    if not fleet.flagged:
        wear *= 0.0
    clearance = mounting * (1.0 + np.nan_to_num(wear) / 100.0)
    verdicts = _level(wear, (45.0, 70.0, 110.0), list(Verdict)[1:])
    verdicts[np.isnan(wear)] = Verdict.NOT_MEASURED
    leakage = 2e-6 * clearance**3 * random.uniform(0.8, 1.2, clearance.shape)
    total = leakage.sum(axis=1)[:, None] * np.array([1.0, 0.8, 0.15])
    capacity = np.array([14.0, 30.0, 16.0]) + np.zeros((units, 1))
    share = total / capacity * 100.0
    ranks = np.vectorize(lambda word: Verdict(word).rank)(verdicts)
    worst = ranks.argmax(axis=1)
    each = np.arange(units)
    hashes = [hashlib.sha256(f"{controller} {first + number}".encode()).hexdigest() for number in range(units)]
    supplier = random.choice(fleet.suppliers or [""], units)
    verdict = verdicts[each, worst]
    decided = ranks[each, worst] > Verdict.OK.rank
    number = np.arange(units)
    kind = np.where(decided, np.where(fleet.varied & (number % 9 == 4), "total", "land"), None)
    by_land = kind == "land"
    of_lands = np.repeat(hashes, len(keys))
    of_points = np.repeat(hashes, len(POINTS))
    of_classes = np.repeat(hashes, len(CLASSES))
    heat = np.tile(CLASSES, units)
    log_share = np.repeat(share[:, 0], len(CLASSES)) * (0.4 + 0.6 * (heat - 60) / 50.0)
    seconds = random.uniform(1.0, 60.0, len(heat))
    bands = _level(log_share, (20.0, 30.0, 45.0), list(BANDS))
    levels = {"decision": np.where(decided, "fail", "pass")}
    tables: dict[DataSet, pa.Table] = {
        "units": _table(
            "units",
            {
                HASH: hashes,
                "reference": [f"file:/fleet/{group[n]}/unit_{first + n:05}.zip" for n in range(units)],
                "name": [fleet.name.format(group=group[n], number=first + n) for n in range(units)],
                "group": group,
                "labels": [[("supplier", str(name)), ("batch", f"B{n % 7}")] for n, name in enumerate(supplier)],
                "atleak": __version__,
                "evaluated_at": [_BEGUN + dt.timedelta(seconds=n) for n in range(units)],
                "tries": 1,
                "seconds": random.uniform(0.2, 0.6, units),
                "number": [f"2026-{first + n:05}" for n in range(units)],
                "date": [dt.date(2026, 1, 1) + dt.timedelta(days=n % 90) for n in range(units)],
                "serial": [f"S{first + n:06}" for n in range(units)],
                "mileage_km": mileage if fleet.mileage else np.full(units, np.nan),
                "controller_name": controller.replace("_", " "),
                "controller_sha256": hashlib.sha256(controller.encode()).hexdigest(),
                "fluid": "hipol_atf_iid",
                "fluid_sha256": [f"{n % 2 * fleet.varied}" for n in range(units)],
                "limits": "project_default",
                "profile": "workshop",
                "lands_measured": len(keys) - np.isnan(wear).sum(axis=1),
                "lands_total": len(keys),
                "verdict": verdict,
                "decision": levels["decision"],
                "provisional": fleet.varied & (number % 10 == 3),
                "decided_by_kind": kind,
                "decided_by_component": np.where(by_land, [keys[at][0] for at in worst], None),
                "decided_by_land": [keys[at][1] if yes else None for at, yes in zip(worst, by_land, strict=True)],
                "road_rows": 1200 if fleet.logs else None,
                "road_duration_s": 120.0,
                "road_in_pieces": False,
                "max_leakage_dm3_min": total[:, 0] * 1.1,
                "max_share_percent": share[:, 0] * 1.1,
                "min_leakage_dm3_min": total[:, 2],
                "below_s": np.where(share[:, 0] > 40.0, 3.0, 0.0),
                "worst_below_kpa": np.where(share[:, 0] > 40.0, 35.0, 0.0),
                "result_sha256": [hashlib.sha256(sha256.encode()).hexdigest() for sha256 in hashes],
            },
        ),
        "lands": _table(
            "lands",
            {
                HASH: of_lands,
                "component": [component for component, _ in keys] * units,
                "land": [land for _, land in keys] * units,
                "measured": np.where(np.isnan(wear), "none", "measured").ravel(),
                "radial_clearance_um": clearance.ravel(),
                "uncertainty_um": 1.5,
                "mounting_clearance_um": np.tile(mounting, units),
                "new_clearance_um": np.tile(mounting, units),
                "wear_percent": wear.ravel(),
                "leakage_dm3_min": leakage.ravel(),
                "share_percent": (leakage / capacity[:, :1] * 100.0).ravel(),
                "verdict": verdicts.ravel(),
                "decision": np.where(ranks > Verdict.OK.rank, "fail", "pass").ravel(),
                "suspect": False,
            },
        ),
        "conditions": _table(
            "conditions",
            {
                HASH: of_points,
                "name": POINTS * units,
                "label": [point.replace("_", " ") for point in POINTS] * units,
                "temperature_c": POINT_TEMPERATURES * units,
                "engine_rpm": (750.0, 2000.0, 800.0) * units,
                "gear": (1, 4, 1) * units,
                "p_g_kpa": (450.0, 700.0, 600.0) * units,
                "p_g_held_kpa": np.minimum(1.0, 60.0 / share).ravel() * np.tile([450.0, 700.0, 600.0], units),
                "leakage_dm3_min": total.ravel(),
                "pump_capacity_dm3_min": capacity.ravel(),
                "share_percent": share.ravel(),
                "band": _level(share, (20.0, 30.0, 45.0), list(BANDS)).ravel(),
                "decision": np.where(share > 30.0, "fail", "pass").ravel(),
                "reserve": (capacity / (total + 3.0)).ravel(),
            },
        ),
        "temperatures": _table(
            "temperatures",
            {
                HASH: of_classes,
                "temperature_low_c": heat.astype(float),
                "temperature_high_c": heat + 5.0,
                "seconds": seconds,
                **{f"{band}_s": np.where(bands == band, seconds, 0.0) for band in BANDS},
                "share_mean_percent": log_share,
                "share_max_percent": log_share * 1.2,
                "pressure_mean_kpa": 620.0 - 1.2 * heat + random.normal(0.0, 8.0, len(heat)),
                "pressure_min_kpa": 540.0 - 1.2 * heat,
                "leakage_mean_dm3_min": log_share * 0.14,
            },
        ),
    }
    if not fleet.logs:
        del tables["temperatures"]
    heads = [tables["units"].slice(n, 1) for n in range(units)]
    size = {data_set: table.num_rows // units for data_set, table in tables.items()}
    return [
        Rows(
            controller=controller,
            input_sha256=hashes[n],
            reference=head["reference"][0].as_py(),
            verdict=Verdict(verdict[n]),
            tables={each: table.slice(n * size[each], size[each]) for each, table in tables.items()},
        )
        for n, head in enumerate(heads)
    ]


def _level(values: np.ndarray, limits: tuple[float, ...], words: list[Any]) -> np.ndarray:
    """The word for each value: the first below all limits, the last past all."""
    return np.array([str(word) for word in words], dtype=object)[np.searchsorted(limits, values, side="right")]


def _error(number: int, kind: Any) -> Rows:
    sha256 = hashlib.sha256(f"error {number}".encode()).hexdigest()
    reference = f"file:/fleet/north/bad_{number}.zip"
    row = {
        HASH: [sha256],
        "reference": [reference],
        "name": [f"north/bad_{number}.zip"],
        "group": "north",
        "labels": [[("supplier", SUPPLIERS[0])]],
        "atleak": __version__,
        "evaluated_at": [_BEGUN],
        "tries": 1 if kind == "refused" else 2,
        "kind": kind,
        "message": f"bad_{number}.zip: this is what a person would have been told",
    }
    controller = None if kind == "refused" else CONTROLLERS[0]
    return Rows(controller, sha256, reference, None, {"errors": _table("errors", row)})


def _table(data_set: DataSet, columns: Mapping[str, Any]) -> pa.Table:
    """The columns given, one value standing for all of its column; every other column is null."""
    schema = columns_of(data_set)
    assert set(columns) <= set(schema.names)
    rows = len(columns[HASH])

    def column(field: pa.Field) -> pa.Array:
        values = columns.get(field.name)
        if values is None:
            return pa.nulls(rows, field.type)
        if isinstance(values, str | bool | int | float):
            return pa.repeat(pa.scalar(values, field.type), rows)
        return pa.array(values, field.type, from_pandas=True)

    return pa.table([column(field) for field in schema], schema=schema)
