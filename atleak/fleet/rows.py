"""Write what a diagnosis says of a unit as the rows of the fleet's data sets."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

from atleak.common.units import DM3_MIN, KPA, PERCENT
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.road_pressure import TemperatureClass
from atleak.fleet.columns import HASH, DataSet, ErrorKind, Rows, columns_of
from atleak.fleet.folder import folder_of
from atleak.fleet.units import FleetUnit
from atleak.job.result import result_sha256
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import diagnosis_record
from atleak.version import __version__

_INSTANTS = {  # of the record of a road test: the columns of `units` that stand in it
    "max_leakage": ("leakage_dm3_min", "leakage_low_dm3_min", "leakage_high_dm3_min"),
    "max_share": ("share_percent", "share_low_percent", "share_high_percent"),
    "min_leakage": ("leakage_dm3_min",),
}


def rows_of_result(
    unit: FleetUnit,
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    seconds: float | None = None,
    tries: int = 1,
) -> Rows:
    """Return the rows of a unit that was diagnosed.

    Parameters
    ----------
    unit
        what it is called, and its hash.
    diagnosis
        its result.
    job
        what the workshop wrote down of it.
    seconds
        that its evaluation took so far [s].
    tries
        how often it was begun.

    Raises
    ------
    InputError
        the id of the valve body is too long for the name of a folder.
    """
    folder_of(diagnosis.controller.id)  # here, where an id that names no folder concerns this unit alone
    record = diagnosis_record(diagnosis)
    road = record["road_test"]
    of_unit = {
        **_named(unit, tries),
        "seconds": seconds,
        **_written_down(job, record),
        **_diagnosed_with(record),
        "lands_judged": diagnosis.judged,
        **_judged(record["unit"]),
        **_road(road),
        "result_sha256": result_sha256(record),
    }
    own = {HASH: unit.input_sha256}
    rows: dict[DataSet, list[dict[str, Any]]] = {
        "units": [of_unit],
        "lands": [{**own, **land} for land in record["lands"]],
        "conditions": [{**own, **condition} for condition in record["conditions"]],
        "circuits": [
            {**own, "condition": condition["name"], **circuit}
            for condition in record["conditions"]
            for circuit in condition["circuits"]
        ],
        "events": [{**own, **event} for event in (road["events"] if road else ())],
        "temperatures": [{**own, **_temperature(each)} for each in diagnosis.temperature_classes],
    }
    return Rows(
        controller=diagnosis.controller.id,
        input_sha256=unit.input_sha256,
        reference=unit.reference,
        verdict=diagnosis.verdict,
        tables={data_set: _table(data_set, of_set) for data_set, of_set in rows.items() if of_set},
    )


def error_rows(unit: FleetUnit, kind: ErrorKind, message: str, *, tries: int = 1) -> Rows:
    """Return the row of a unit without a result: why it has none, what a person is told, how often it was begun."""
    row = {**_named(unit, tries), "kind": kind, "message": message}
    tables: dict[DataSet, pa.Table] = {"errors": _table("errors", [row])}
    return Rows(None, unit.input_sha256, unit.reference, None, tables)


def _table(data_set: DataSet, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Return rows as a table: what they say beyond its columns is left out, what they do not say is null."""
    columns = columns_of(data_set)
    whole = pa.array(rows, pa.struct(columns))
    return pa.Table.from_arrays(whole.flatten(), schema=columns)


def _named(unit: FleetUnit, tries: int) -> dict[str, Any]:
    return {
        HASH: unit.input_sha256,
        "reference": unit.reference,
        "name": unit.name,
        "group": unit.group,
        "labels": list(unit.labels),
        "choices": unit.choices,
        "atleak": __version__,
        "evaluated_at": dt.datetime.now(dt.UTC),
        "tries": tries,
    }


def _written_down(job: Job | None, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what tells the job from others; the mileage is that with which the result was computed."""
    identity = {} if job is None else job.identity
    mileage = record["mileage_km"]
    return {
        **{name: identity.get(name) for name in ("number", "vin", "serial")},
        "date": None if job is None else job.date,
        "mileage_km": identity.get("mileage_km") if mileage is None else mileage,
    }


def _diagnosed_with(record: Mapping[str, Any]) -> dict[str, Any]:
    controller, fluid, limits, readings = (record[name] for name in ("controller", "fluid", "limits", "readings"))
    options = {name: str(value) for name, value in record["profile"].items() if name != "name"}
    uncertainty, complaint = record["uncertainty"], record["complaint"]
    return {
        "controller_name": controller["name"],
        "controller_sha256": controller["sha256"],
        "fluid": fluid["id"],
        "fluid_sha256": fluid["sha256"],
        "fluid_state": fluid["state"],
        "limits": limits["id"],
        "limits_sha256": limits["sha256"],
        "profile": record["profile"]["name"],
        "options": list(options.items()),
        "assumptions": None if uncertainty is None else list(uncertainty["assumptions"].items()),
        "guard_factor": None if uncertainty is None else uncertainty["guard_factor"],
        "complaint": None if complaint is None else complaint["id"],
        "readings_sha256": readings["sha256"],
        "measured_on": None if readings["date"] is None else dt.date.fromisoformat(readings["date"]),
        "lands_measured": readings["lands_measured"],
        "lands_total": readings["lands_total"],
    }


def _judged(unit: Mapping[str, Any]) -> dict[str, Any]:
    decided_by = unit["decided_by"] or {}
    return {
        **{name: unit[name] for name in ("verdict", "decision", "provisional")},
        **{
            f"decided_by_{name}": decided_by.get(name) for name in ("kind", "condition", "component", "land", "circuit")
        },
    }


def _road(road: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what the record of a road test says of the unit; nothing without one."""
    if road is None:
        return {}
    instants = {
        f"{name.partition('_')[0]}_{column}": road[name][column]
        for name, columns in _INSTANTS.items()
        for column in columns
        if road[name] is not None
    }
    permissible, commanded = road["permissible_pressure"], road["commanded_pressure"]
    verdicts = [Verdict(each["verdict"]) for each in (permissible, commanded) if each and each["verdict"]]
    return {
        "road_sha256": road["sha256"],
        "road_rows": road["rows"],
        "road_duration_s": road["duration_s"],
        "road_in_pieces": False,
        **instants,
        "below_s": permissible["below_s"] if permissible else None,
        "worst_below_kpa": permissible["worst_below_kpa"] if permissible else None,
        "road_verdict": worst(verdicts) if verdicts else None,
    }


def _temperature(each: TemperatureClass) -> dict[str, Any]:
    def scaled(value: float | None, factor: float) -> float | None:
        return None if value is None else value * factor

    return {
        "temperature_low_c": each.low,
        "temperature_high_c": each.high,
        "seconds": each.seconds,
        **{f"{band}_s": seconds for band, seconds in each.in_bands.items()},
        "share_mean_percent": scaled(each.share_mean, PERCENT),
        "share_max_percent": scaled(each.share_max, PERCENT),
        "pressure_mean_kpa": scaled(each.pressure_mean, KPA),
        "pressure_min_kpa": scaled(each.pressure_min, KPA),
        "leakage_mean_dm3_min": each.leakage_mean * DM3_MIN,
    }
