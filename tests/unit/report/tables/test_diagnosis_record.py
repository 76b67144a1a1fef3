"""The JSON record: the keys that scripts rely on, numbers that recompute from their own row, nothing but JSON in it."""

from __future__ import annotations

import gc
import json
import math
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.common.errors import Message, Place
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.engine.projection import stated_condition
from atleak.measurements.readings import Readings
from atleak.report.json.conditions import message_record
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.version import __version__

# What was promised to scripts. A key may be added to the record; none of these may go.
TOP = "format atleak profile controller fluid limits readings lands gaps projection hot_idle road_test messages"
PROFILE = "name diameter viscosity pump_draw pump_efficiency entry_loss eccentricity form"
LAND = (
    "component land spool_diameter_mm sleeve_diameter_mm radial_clearance_um uncertainty_um mounting_clearance_um "
    "wear_percent effective_clearance_um leakage_dm3_min leakage_low_dm3_min leakage_high_dm3_min share_percent "
    "verdict decision probability_over_limit rules messages"
)
RULE = "rule value limit verdict decision"
GAP = (
    "component land section from to pressure_drop_kpa diameter_mm contact_length_mm effective_clearance_um "
    "kinematic_viscosity_mm2_s density_g_cm3 leakage_mm3_s drawn_from_pump"
)
PROJECTION = (
    "temperature_c engine_rpm gear p_g_kpa p_s_kpa p_m_kpa p_k_kpa leakage_dm3_min pump_capacity_dm3_min share_percent "
    "band minimum_engine_rpm concentric_factor_low concentric_factor_high"
)
ROAD = (
    "file sha256 rows duration_s gears sections max_leakage min_leakage max_share max_leakage_sustained "
    "max_share_sustained sustained_over_s start lower_bound messages"
)
INSTANT = (
    "time_s leakage_dm3_min leakage_low_dm3_min leakage_high_dm3_min pump_capacity_dm3_min share_percent "
    "share_low_percent share_high_percent"
)
MESSAGE = "level code text"


@pytest.fixture
def record(sample: Diagnosis) -> dict[str, Any]:
    return json.loads(to_json(diagnosis_record(sample)))


def test_it_is_made_once_and_let_go_with_its_diagnosis(minimal: Controller, hipol: Fluid, limits: Limits) -> None:
    diagnosis = diagnose(minimal, hipol, limits)
    record = diagnosis_record(diagnosis)
    assert diagnosis_record(diagnosis) is record
    assert plan_repairs(diagnosis) is plan_repairs(diagnosis)
    seen = weakref.ref(diagnosis)
    del diagnosis
    gc.collect()
    assert seen() is None


def lacking(promised: str, record: dict[str, Any]) -> list[str]:
    return [key for key in promised.split() if key not in record]


def numbers(value: Any) -> Iterator[float]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for inner in value:
            yield from numbers(inner)
    elif isinstance(value, float):
        yield value


def flow_by_hand(gap: dict[str, Any], profile: dict[str, Any]) -> float:
    """mm³/s from one row alone: kPa, mm, µm, mm²/s and g/cm³; ν·ρ is μ in mPa·s."""
    drop, diameter, length = max(gap["pressure_drop_kpa"], 0.0), gap["diameter_mm"], gap["contact_length_mm"]
    clearance = gap["effective_clearance_um"] * 1e-3
    viscosity, density = gap["kinematic_viscosity_mm2_s"], gap["density_g_cm3"]
    eccentric = 1.5 if profile["eccentricity"] == "unknown" else 1.0 + 1.5 * profile["eccentricity"] ** 2
    laminar = eccentric * 1e6 * math.pi * diameter * clearance**3 / (12.0 * viscosity * density * length)
    if profile["entry_loss"] == "off" or drop == 0.0:
        return laminar * drop
    # Δp = q/laminar + 0.75 ρ (q/(π d c))², solved for q > 0; ρ in g/cm³ and mm²/s² make 1e-6 kPa
    square = 0.75 * density * 1e-6 / (math.pi * diameter * clearance) ** 2
    linear = 1.0 / laminar
    return 2.0 * drop / (linear + math.sqrt(linear**2 + 4.0 * square * drop))


def test_every_promised_key_is_there(record: dict[str, Any]) -> None:
    assert lacking(TOP, record) == []
    assert record["format"] == 1
    assert record["atleak"] == __version__
    assert lacking(PROFILE, record["profile"]) == []
    assert lacking("id name sha256 representative", record["controller"]) == []
    assert lacking("id", record["fluid"]) == lacking("id", record["limits"]) == []
    assert lacking("file sha256 lands_measured lands_total", record["readings"]) == []
    for land in record["lands"]:
        assert lacking(LAND, land) == []
        assert [rule for rule in land["rules"] if lacking(RULE, rule)] == []
        assert land["verdict"] in {"ok", "watch", "replace", "critical", "not_measured"}
        assert land["decision"] in {"pass", "conditional_pass", "conditional_fail", "fail", None}
    assert [gap for gap in record["gaps"] if lacking(GAP, gap)] == []
    assert lacking(PROJECTION, record["projection"]) == lacking(PROJECTION, record["hot_idle"]) == []
    assert lacking(ROAD, record["road_test"]) == []
    assert set(record["road_test"]["sections"]) == {"p_g", "p_s", "p_m", "p_k"}
    for name in ("max_leakage", "min_leakage", "max_share", "max_leakage_sustained", "max_share_sustained"):
        assert lacking(INSTANT, record["road_test"][name]) == []
    for message in (*record["messages"], *record["road_test"]["messages"]):
        assert lacking(MESSAGE, message) == []
        assert message["level"] in {"info", "warning"}


def test_the_record_is_of_the_files_it_names(
    record: dict[str, Any], sample: Diagnosis, sample_readings: Path, sample_log: Path
) -> None:
    assert record["readings"]["file"] == sample_readings.name
    assert record["road_test"]["file"] == sample_log.name
    assert record["controller"]["sha256"] == sample.controller.sha256
    assert record["controller"]["representative"] is True
    assert record["readings"]["lands_total"] == len(record["lands"]) == 47
    assert record["readings"]["lands_measured"] == 47
    assert record["profile"]["name"] == sample.profile.name


def test_every_gap_recomputes_from_its_own_row(record: dict[str, Any]) -> None:
    for gap in record["gaps"]:
        assert gap["leakage_mm3_s"] == pytest.approx(flow_by_hand(gap, record["profile"]), rel=1e-9, abs=0.0)


@pytest.mark.parametrize(
    "options",
    [{"entry_loss": "off"}, {"eccentricity": "0.6"}, {"eccentricity": "unknown"}, {"diameter": "spool"}],
)
def test_every_gap_recomputes_with_other_options_and_a_reversed_drop(
    options: dict[str, str], four_speed: Controller, hipol: Fluid, limits: Limits
) -> None:
    # over 50 bar of main pressure 0.1 p_g passes the limit of p_s
    condition = replace(four_speed.operating_points[0], name="stated", main_pressure=60e5)
    diagnosis = diagnose(four_speed, hipol, limits, profile=WORKSHOP.with_options(**options), condition=condition)
    record = diagnosis_record(diagnosis)
    assert min(gap["pressure_drop_kpa"] for gap in record["gaps"]) < 0.0
    for gap in record["gaps"]:
        assert gap["leakage_mm3_s"] == pytest.approx(flow_by_hand(gap, record["profile"]), rel=1e-9, abs=0.0)


def test_the_diameter_of_a_row_is_the_one_the_profile_names(record: dict[str, Any]) -> None:
    lands = {(land["component"], land["land"]): land for land in record["lands"]}
    mean = record["profile"]["diameter"] == "mean"
    for gap in record["gaps"]:
        land = lands[gap["component"], gap["land"]]
        expected = land["spool_diameter_mm"] + (land["effective_clearance_um"] * 1e-3 if mean else 0.0)
        assert gap["diameter_mm"] == pytest.approx(expected, rel=1e-12, abs=0.0)


def test_drawn_gaps_sum_to_the_projection(record: dict[str, Any]) -> None:
    drawn = math.fsum(gap["leakage_mm3_s"] for gap in record["gaps"] if gap["drawn_from_pump"])
    assert drawn * 60e-6 == pytest.approx(record["projection"]["leakage_dm3_min"], rel=1e-9, abs=0.0)
    everything = math.fsum(gap["leakage_mm3_s"] for gap in record["gaps"])
    assert (drawn == everything) == (record["profile"]["pump_draw"] == "all_gaps")


def test_lands_sum_to_the_gaps_and_to_the_projection(record: dict[str, Any]) -> None:
    total = math.fsum(land["drawn_from_pump_dm3_min"] for land in record["lands"])
    assert total == pytest.approx(record["projection"]["leakage_dm3_min"], rel=1e-9, abs=0.0)
    for land in record["lands"]:
        mine = [gap for gap in record["gaps"] if (gap["component"], gap["land"]) == (land["component"], land["land"])]
        flow = math.fsum(gap["leakage_mm3_s"] for gap in mine) * 60e-6
        assert land["leakage_dm3_min"] == pytest.approx(flow, rel=1e-9, abs=0.0)
        for gap in mine:
            assert gap["effective_clearance_um"] >= land["effective_clearance_um"] * (1.0 - 1e-12)


def test_the_clearance_of_a_gap_is_that_of_equal_flow(sample: Diagnosis, record: dict[str, Any]) -> None:
    """The mean of the cubes at every place that was measured, warmed up alike."""
    lands = {(land["component"], land["land"]): land for land in record["lands"]}
    counts = record["profile"]["form"] == "mean_of_cubes"
    states = {land.key: land.state for land in sample.lands}
    wider = set()
    for gap in record["gaps"]:
        state, land = states[gap["component"], gap["land"]], lands[gap["component"], gap["land"]]
        mean = land["effective_clearance_um"]
        opened = mean - land["radial_clearance_um"]
        cube = mean**3
        if counts:
            cube = math.fsum((station.radial_clearance * 1e6 + opened) ** 3 for station in state.stations)
            cube /= len(state.stations)  # as many directions in every plane of the sample
        assert gap["effective_clearance_um"] ** 3 == pytest.approx(cube, rel=1e-9, abs=0.0)
        wider.add(gap["effective_clearance_um"] > mean * 1.001)
    assert (True in wider) == counts


def test_numbers_of_a_land_follow_from_one_another(record: dict[str, Any]) -> None:
    for land in record["lands"]:
        clearance = (land["sleeve_diameter_mm"] - land["spool_diameter_mm"]) / 2.0 * 1e3
        assert land["radial_clearance_um"] == pytest.approx(clearance, rel=1e-9, abs=0.0)
        wear = 100.0 * (land["radial_clearance_um"] / land["mounting_clearance_um"] - 1.0)
        assert land["wear_percent"] == pytest.approx(wear, rel=1e-9, abs=1e-9)
        share = 100.0 * land["drawn_from_pump_dm3_min"] / record["projection"]["pump_capacity_dm3_min"]
        assert land["share_percent"] == pytest.approx(share, rel=1e-9, abs=0.0)
        assert land["leakage_low_dm3_min"] <= land["leakage_dm3_min"] <= land["leakage_high_dm3_min"]
        order = ["ok", "watch", "replace", "critical"]
        assert land["verdict"] == max((rule["verdict"] for rule in land["rules"]), key=order.index)


def test_shares_and_bands_of_the_conditions(record: dict[str, Any]) -> None:
    for name in ("projection", "hot_idle"):
        projection = record[name]
        share = 100.0 * projection["leakage_dm3_min"] / projection["pump_capacity_dm3_min"]
        assert projection["share_percent"] == pytest.approx(share, rel=1e-12, abs=0.0)
        new = 100.0 * projection["leakage_new_dm3_min"] / projection["pump_capacity_dm3_min"]
        red, amber = max(1.5 * new, new + 4.0), max(1.25 * new, new + 2.0)
        bands = [(50.0, "critical"), (red, "red"), (amber, "amber"), (0.0, "green")]
        by_value = next(band for limit, band in bands if share >= limit)
        likely = projection["probability_over_limit"] >= 0.5  # of the band that is more likely than not
        assert projection["band"] == by_value or (likely and projection["limit_percent"] > share)
        assert 0.0 < projection["minimum_engine_rpm"] < projection["engine_rpm"]


def test_road_test_sections_are_parts_of_one_whole(record: dict[str, Any]) -> None:
    road = record["road_test"]
    assert sum(road["sections"].values()) == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert all(share > 0.0 for share in road["sections"].values())
    assert road["gears"] == [1, 2, 3, 4]
    assert road["min_leakage"]["leakage_dm3_min"] < road["max_leakage"]["leakage_dm3_min"]
    for name in ("max_leakage", "min_leakage", "max_share"):
        instant = road[name]
        share = 100.0 * instant["leakage_dm3_min"] / instant["pump_capacity_dm3_min"]
        assert instant["share_percent"] == pytest.approx(share, rel=1e-12, abs=0.0)
        assert instant["share_percent"] <= road["max_share"]["share_percent"]


def test_no_number_is_rounded_or_infinite(record: dict[str, Any], sample: Diagnosis) -> None:
    assert all(math.isfinite(number) for number in numbers(record))
    for land, row in zip(sample.lands, record["lands"], strict=True):
        assert row["leakage_dm3_min"] == land.leakage * 6e4
        assert row["radial_clearance_um"] == land.state.radial_clearance * 1e6


def test_what_is_infinite_is_null(four_speed: Controller, hipol: Fluid, limits: Limits, sample: Diagnosis) -> None:
    condition = stated_condition(four_speed, engine_speed=1.0 / 60.0)
    diagnosis = diagnose(four_speed, hipol, limits, readings=sample.readings, condition=condition)
    record = json.loads(to_json(diagnosis_record(diagnosis)))
    assert record["projection"]["share_percent"] is None
    assert record["projection"]["band"] == "critical"
    assert "condition_impossible" in {message["code"] for message in record["messages"]}  # nor could a new unit
    assert "description_impossible" not in {message["code"] for message in record["messages"]}
    assert not any(rule["rule"] == "share_stated_percent" for land in record["lands"] for rule in land["rules"])


def test_json_refuses_what_is_no_json() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_json({"share": math.nan})
    assert to_json({"unit": "µm"}) == '{\n  "unit": "µm"\n}\n'


def test_unknown_is_null(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    only = replace(four_speed, operating_points=four_speed.operating_points[:1])
    record = diagnosis_record(diagnose(only, hipol, limits, profile=PAPER))
    assert record["readings"] == {
        "file": None,
        "sha256": None,
        "date": None,
        "measuring_temperature_c": None,
        "measuring_temperature_assumed": None,
        "lands_measured": 0,
        "lands_total": 47,
    }
    assert record["hot_idle"] is record["road_test"] is record["mileage_km"] is None
    assert record["verdict"] == "not_measured"
    assert record["repair_plan"] == []
    for land in record["lands"]:
        assert lacking(LAND, land) == []
        for key in ("wear_percent", "uncertainty_um", "leakage_low_dm3_min", "decision", "probability_over_limit"):
            assert land[key] is None
        assert land["rules"] == []


def test_limits_state_unit_and_origin(edited: Callable[..., Path], minimal: Controller, hipol: Fluid) -> None:
    path = edited(
        "limits",
        "project_default",
        ("# What all", '[clearance_um]\nreplace = 60.0\norigin = "set by the workshop"\nsource = "own"\n# What all'),
    )
    rules = diagnosis_record(diagnose(minimal, hipol, load_limits(path)))["limits"]["rules"]
    assert rules["radial_clearance"]["replace_um"] == pytest.approx(60.0, rel=1e-12, abs=0.0)
    assert rules["radial_clearance"]["origin"] == "set by the workshop"
    assert rules["wear"]["replace_percent"] == pytest.approx(50.0, rel=1e-12, abs=0.0)
    assert rules["total_share"]["critical_percent"] == pytest.approx(50.0, rel=1e-12, abs=0.0)


def test_a_rule_of_clearance_is_in_micrometres(
    edited: Callable[..., Path], minimal: Controller, hipol: Fluid, readings_of: Callable[..., Readings]
) -> None:
    path = edited(
        "limits",
        "project_default",
        ("# What all", '[clearance_um]\nreplace = 15.0\norigin = "set by the workshop"\nsource = "own"\n# What all'),
    )
    readings = readings_of(minimal, {("tcc_regulator", 1): (11e-3, 11.04e-3)})
    record = diagnosis_record(diagnose(minimal, hipol, load_limits(path), readings=readings))
    land = next(land for land in record["lands"] if land["component"] == "tcc_regulator")
    rule = next(rule for rule in land["rules"] if rule["rule"] == "radial_clearance_um")
    assert rule["value"] == pytest.approx(20.0, rel=1e-9, abs=0.0)
    assert rule["limit"] == pytest.approx(15.0, rel=1e-9, abs=0.0)
    assert rule["origin"] == "set by the workshop"


def test_a_message_keeps_its_place() -> None:
    plain = Message("info", "code", "text")
    assert message_record(plain) == {"level": "info", "code": "code", "text": "text"}
    placed = replace(plain, place=Place(file="a.csv", row=3))
    assert message_record(placed)["place"] == {"file": "a.csv", "row": 3}
