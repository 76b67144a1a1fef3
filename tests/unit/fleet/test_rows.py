"""The rows of one unit: what ``atleak diagnose --json`` says of it, in columns."""

from __future__ import annotations

import datetime as dt
import pickle
from dataclasses import dataclass, replace
from typing import Any

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.errors import InputError
from atleak.common.verdicts import BANDS, Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.fleet.columns import DATA_SETS, ERROR_KINDS, HASH, Rows, columns_of
from atleak.fleet.worker import error_rows, rows_of_result
from atleak.job.result import result_record
from atleak.measurements.job_card import Job, Transmission, Vehicle
from atleak.version import __version__


@dataclass(frozen=True)
class Named:
    """What the rows take of a unit."""

    name: str = "north/unit 1.zip"
    reference: str = "file:/fleet/north/unit 1.zip"
    group: str | None = "north"
    labels: tuple[tuple[str, str], ...] = (("supplier", "Almar"), ("batch", "B7"))
    choices: str = '{"fluid": "own.toml"}'
    input_sha256: str = "a" * 64


JOB = Job(
    number="2026-7",
    date=dt.date(2026, 4, 17),
    vehicle=Vehicle(vin="WVWZZZ1JZXW000001", mileage_km=90e3),
    transmission=Transmission(serial="S 7"),
)


@pytest.fixture(scope="module")
def sample(sample_diagnoses: dict[str, Diagnosis]) -> Diagnosis:
    return sample_diagnoses["workshop"]


@pytest.fixture(scope="module")
def record(sample: Diagnosis) -> dict[str, Any]:
    return result_record(sample, JOB)


@pytest.fixture(scope="module")
def rows(sample: Diagnosis) -> Rows:
    return rows_of_result(Named(), sample, JOB, seconds=0.5, tries=2)


def test_the_rows_of_lands_and_conditions_are_those_of_the_record(rows: Rows, record: dict[str, Any]) -> None:
    named = {HASH: Named.input_sha256}
    for data_set in ("lands", "conditions"):
        told = rows.tables[data_set].to_pylist()
        left_out = {"circuits"} if data_set == "conditions" else set()
        assert told == [named | _with_places(each) for each in _without(record[data_set], left_out)]
    assert any(message["place"] for land in rows.tables["lands"].to_pylist() for message in land["messages"])
    events = _without(record["road_test"]["events"], {"test"})
    assert events
    assert rows.tables["events"].to_pylist() == [named | event for event in events]
    assert "circuits" not in rows.tables, "this valve body describes none"


def _without(records: list[dict[str, Any]], keys: set[str]) -> list[dict[str, Any]]:
    return [{key: value for key, value in each.items() if key not in keys} for each in records]


def _with_places(record: dict[str, Any]) -> dict[str, Any]:
    """The same with null for what of a message's place is not known; the steps that lead to it stand in no column."""
    if "messages" not in record:
        return record
    known = ("file", "sheet", "row", "column", "table", "key")
    messages = [
        {**each, "place": each.get("place") and {name: each["place"].get(name) for name in known}}
        for each in record["messages"]
    ]
    return {**record, "messages": messages}


def test_the_rows_of_circuits_are_those_of_the_record(three_circuits: Controller, hipol: Fluid, limits: Limits) -> None:
    diagnosis = diagnose(three_circuits, hipol, limits)
    told = rows_of_result(Named(), diagnosis).tables["circuits"].to_pylist()
    assert told == [
        {HASH: Named.input_sha256, "condition": condition["name"], **circuit}
        for condition in result_record(diagnosis)["conditions"]
        for circuit in condition["circuits"]
    ]
    assert len(told) == len(diagnosis.projections) * len(three_circuits.circuits) > 0


def test_the_row_of_a_unit_says_whose_it_is_and_what_became_of_it(rows: Rows, record: dict[str, Any]) -> None:
    (told,) = rows.tables["units"].to_pylist()
    road, decided_by = record["road_test"], record["unit"]["decided_by"]
    assert dt.datetime.now(dt.UTC) - told.pop("evaluated_at") < dt.timedelta(hours=1)
    assert told == {
        HASH: Named.input_sha256,
        "reference": Named.reference,
        "name": Named.name,
        "group": "north",
        "labels": [("supplier", "Almar"), ("batch", "B7")],
        "choices": Named.choices,
        "atleak": __version__,
        "tries": 2,
        "seconds": 0.5,
        "number": "2026-7",
        "date": dt.date(2026, 4, 17),
        "vin": "WVWZZZ1JZXW000001",
        "serial": "S 7",
        "mileage_km": 106315.0,  # with which the result was computed
        "controller_name": record["controller"]["name"],
        "controller_sha256": record["controller"]["sha256"],
        "fluid": record["fluid"]["id"],
        "fluid_sha256": record["fluid"]["sha256"],
        "fluid_state": "fresh",
        "limits": record["limits"]["id"],
        "limits_sha256": record["limits"]["sha256"],
        "profile": "workshop",
        "options": [(name, str(value)) for name, value in record["profile"].items() if name != "name"],
        "assumptions": list(record["uncertainty"]["assumptions"].items()),
        "guard_factor": record["uncertainty"]["guard_factor"],
        "complaint": None,
        "readings_sha256": record["readings"]["sha256"],
        "measured_on": record["readings"]["date"] and dt.date.fromisoformat(record["readings"]["date"]),
        "lands_measured": 47,
        "lands_judged": 47,
        "lands_total": 47,
        "verdict": record["verdict"],
        "decision": record["unit"]["decision"],
        "provisional": record["unit"]["provisional"],
        **{f"decided_by_{each}": decided_by[each] for each in ("kind", "condition", "component", "land", "circuit")},
        "road_sha256": road["sha256"],
        "road_rows": 1201,
        "road_duration_s": road["duration_s"],
        "road_in_pieces": False,
        "max_leakage_dm3_min": road["max_leakage"]["leakage_dm3_min"],
        "max_leakage_low_dm3_min": road["max_leakage"]["leakage_low_dm3_min"],
        "max_leakage_high_dm3_min": road["max_leakage"]["leakage_high_dm3_min"],
        "max_share_percent": road["max_share"]["share_percent"],
        "max_share_low_percent": road["max_share"]["share_low_percent"],
        "max_share_high_percent": road["max_share"]["share_high_percent"],
        "min_leakage_dm3_min": road["min_leakage"]["leakage_dm3_min"],
        "below_s": road["permissible_pressure"]["below_s"],
        "worst_below_kpa": road["permissible_pressure"]["worst_below_kpa"],
        "road_verdict": road["permissible_pressure"]["verdict"],
        "result_sha256": record["result_sha256"],
    }
    assert (rows.controller, rows.input_sha256) == (record["controller"]["id"], Named.input_sha256)
    assert (rows.reference, rows.verdict) == (Named.reference, Verdict(record["verdict"]))


def test_the_classes_of_temperature_stand_in_the_units_of_their_names(rows: Rows, sample: Diagnosis) -> None:
    road = sample.road
    assert road is not None
    told = rows.tables["temperatures"].to_pylist()
    assert [each["temperature_high_c"] - each["temperature_low_c"] for each in told] == [5.0] * len(told)
    assert sum(each["seconds"] for each in told) == pytest.approx(
        sum(each[f"{band}_s"] for each in told for band in BANDS), rel=1e-9, abs=0.0
    )
    assert max(each["share_max_percent"] for each in told) == pytest.approx(
        road.max_share.share * 100.0, rel=1e-9, abs=0.0
    )
    assert all(each["share_mean_percent"] <= each["share_max_percent"] for each in told)
    assert all(100.0 < each["pressure_min_kpa"] <= each["pressure_mean_kpa"] < 3000.0 for each in told)
    assert all(
        road.min_leakage.leakage * 6e4 <= each["leakage_mean_dm3_min"] <= road.max_leakage.leakage * 6e4
        for each in told
    )


def test_a_unit_of_which_nothing_is_known_has_a_row_too(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    bare = Named(group=None, labels=())
    rows = rows_of_result(bare, diagnose(four_speed, hipol, limits))
    assert set(rows.tables) == {"units", "lands", "conditions"}
    (told,) = rows.tables["units"].to_pylist()
    assert (told["verdict"], told["decision"], told["lands_measured"]) == ("not_measured", None, 0)
    nothing = ("number", "date", "group", "mileage_km", "road_sha256", "road_in_pieces", "below_s", "road_verdict")
    assert [told[name] for name in nothing] == [None] * len(nothing)
    assert told["labels"] == []


def test_the_mileage_of_the_record_stands_where_none_was_computed_with(
    four_speed: Controller, hipol: Fluid, limits: Limits
) -> None:
    rows = rows_of_result(Named(), diagnose(four_speed, hipol, limits), JOB)
    assert rows.tables["units"]["mileage_km"].to_pylist() == [90e3]


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_a_unit_without_a_result_has_one_row_that_says_why(kind: Any) -> None:
    rows = error_rows(Named(), kind, "sheet.xlsx: no readings", tries=3)
    assert (rows.controller, rows.verdict, set(rows.tables)) == (None, None, {"errors"})
    (told,) = rows.tables["errors"].to_pylist()
    assert told.pop("evaluated_at").tzinfo is not None
    assert told == {
        HASH: Named.input_sha256,
        "reference": Named.reference,
        "name": Named.name,
        "group": "north",
        "labels": [("supplier", "Almar"), ("batch", "B7")],
        "choices": Named.choices,
        "atleak": __version__,
        "tries": 3,
        "kind": kind,
        "message": "sheet.xlsx: no readings",
    }


def test_rows_travel_between_processes_with_their_columns(rows: Rows) -> None:
    again = pickle.loads(pickle.dumps(rows))
    assert again == rows
    assert all(again.tables[each].schema == columns_of(each) for each in DATA_SETS if each in again.tables)


def test_a_valve_body_whose_id_names_no_folder_is_refused(sample: Diagnosis) -> None:
    odd = replace(sample, controller=replace(sample.controller, id="x" * 201))
    with pytest.raises(InputError, match=r"too long for the name of a folder .*200 characters at most"):
        rows_of_result(Named(), odd)
