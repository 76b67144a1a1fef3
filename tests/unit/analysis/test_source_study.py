"""W1-W8 through the engine: what is varied and what is not, a slow referee, other people's controllers and logs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from atleak.analysis.source_study import (
    VARIANTS,
    VariantResult,
    compare_options,
    compare_points,
    gear_at_most_leakage,
    reaches_digits,
    run_variants,
    variant_fluid,
    variant_road_test,
)
from atleak.catalogue.controller import Controller
from atleak.common.errors import RoadTestError
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.equations.gap import annular_flow
from atleak.measurements.clearances import clearances
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test
from atleak.report.json.diagnosis import to_json
from atleak.report.tables.source_study import variants_record
from tests.unit.equations.referees import effective_clearance_two_temperatures

DM3_MIN = 6e4


@pytest.fixture(scope="module")
def road_test(sample_log: Path) -> RoadTest:
    return read_road_test(sample_log)


@pytest.fixture(scope="module")
def results(four_speed: Controller, road_test: RoadTest) -> tuple[VariantResult, ...]:
    return run_variants(four_speed, road_test)


def without(road_test: RoadTest, *quantities: str) -> RoadTest:
    kept = {name: channel for name, channel in road_test.channels.items() if name not in quantities}
    return replace(road_test, channels=MappingProxyType(kept), _held={})


@pytest.mark.parametrize("index", [0, 90, 96, 210, 700, 1100], ids=lambda index: f"sample-{index}")
@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_a_sample_equals_the_sum_of_its_gaps_one_by_one(
    variant, index: int, four_speed: Controller, road_test: RoadTest, results: tuple[VariantResult, ...]
) -> None:
    """Each gap by the equations alone: wear scales the cold clearance, heat is added after it."""
    p_g, p_k, gear = (
        float(road_test.values(quantity)[index]) for quantity in ("main_pressure", "converter_pressure", "gear")
    )
    pressures = {name: float(value) for name, value in four_speed.section_pressures(p_g, p_k).items()}
    rise = variant.temperature - 20.0
    total = 0.0
    for gap in four_speed.gaps_in(int(gear)):
        land = four_speed.land(*gap.key)
        ends = [end.coefficient * pressures[end.section] if end.section else 0.0 for end in (gap.high, gap.low)]
        cold = land.mounting_clearance * (1.0 + variant.wear)
        hot = effective_clearance_two_temperatures(
            cold, land.nominal_diameter + 2.0 * cold, land.nominal_diameter,
            land.body_expansion, land.spool_expansion, rise, rise,
        )  # fmt: skip
        total += annular_flow(
            ends[0] - ends[1], land.nominal_diameter, hot, variant.viscosity_of_results, variant.density,
            land.contact_length,
        )  # fmt: skip
    result = next(each for each in results if each.variant is variant)
    assert result.computed.leakage[index] == pytest.approx(total, rel=1e-12, abs=0.0)


def test_the_logs_own_temperature_is_not_used(four_speed: Controller, road_test: RoadTest, results) -> None:
    colder = run_variants(four_speed, variant_road_test(road_test, -10.0))
    for again, before in zip(colder, results, strict=True):
        assert np.array_equal(again.computed.leakage, before.computed.leakage)


def test_a_variant_gives_the_road_test_one_temperature(road_test: RoadTest) -> None:
    cold = variant_road_test(road_test, -40.0)
    assert np.array_equal(cold.values("atf_temperature"), np.full(len(road_test.time), -40.0))
    assert road_test.values("atf_temperature").max() > 79.0
    assert cold.values("main_pressure") is not None


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_fluid_of_a_variant(variant) -> None:
    computed, tabulated = variant_fluid(variant), variant_fluid(variant, as_tabulated=True)
    at = variant.temperature
    assert computed.kinematic_viscosity(at, "tabulated") == pytest.approx(
        variant.viscosity_of_results, rel=1e-12, abs=0.0
    )
    assert tabulated.kinematic_viscosity(at, "tabulated") == pytest.approx(
        variant.kinematic_viscosity, rel=1e-12, abs=0.0
    )
    assert computed.density(at, "tabulated") == pytest.approx(variant.density, rel=1e-12, abs=0.0)
    assert (computed.id == "hipol_atf_iid_used") == (variant.name in {"W2", "W3", "W4"})
    assert (tabulated.id == "hipol_atf_iid_used") == (variant.name == "W2")


def test_used_oil_leaks_in_inverse_proportion_to_viscosity(results) -> None:
    w3 = next(each for each in results if each.variant.name == "W3")
    ratio = w3.as_tabulated.leakage / w3.computed.leakage
    assert ratio == pytest.approx(8.40 / 10.93, rel=1e-9, abs=0.0)


def test_reaches_digits() -> None:
    w5 = next(variant for variant in VARIANTS if variant.name == "W5")
    assert reaches_digits(w5.printed_max_leakage, 0.0214)
    assert not reaches_digits(w5.printed_max_leakage, 0.0216)


# --- other controllers and logs


def test_a_workshops_own_controller_runs_through_the_same_variants(minimal: Controller, road_test: RoadTest) -> None:
    computed_variants = run_variants(minimal, road_test)
    assert [result.variant.name for result in computed_variants] == [variant.name for variant in VARIANTS]
    leakage = [result.computed.max_leakage.leakage for result in computed_variants]
    assert leakage[1] / leakage[0] == pytest.approx(10.93 / 8.40, rel=1e-9, abs=0.0)
    assert leakage[3] > leakage[2] > leakage[1]


def test_log_without_engine_speed_has_no_share(four_speed: Controller, road_test: RoadTest, results) -> None:
    computed_variants = run_variants(four_speed, without(road_test, "engine_speed"))
    assert computed_variants[0].computed.share is None
    assert computed_variants[0].computed.max_share is None
    assert computed_variants[0].computed.max_leakage.leakage == results[0].computed.max_leakage.leakage
    record = variants_record(computed_variants, four_speed, road_test)["variants"][0]["computed"]
    assert record["share_at_max_leakage_percent"] is None
    assert record["max_share_percent"] is None
    assert "no_engine_speed" in {message.code for message in computed_variants[0].messages}
    assert {point.point.variant for point in compare_points(computed_variants)} == {"W4", "W8"}


def test_log_without_gear_takes_the_first_operating_points(four_speed: Controller, road_test: RoadTest) -> None:
    computed_variants = run_variants(four_speed, without(road_test, "gear", "converter_pressure"))
    assert {"assumed_gear", "assumed_converter_pressure"} <= {message.code for message in computed_variants[0].messages}
    assert {gear_at_most_leakage(result.computed) for result in computed_variants} == {
        four_speed.operating_points[0].gear
    }


def test_log_without_main_pressure_is_refused(four_speed: Controller, road_test: RoadTest) -> None:
    with pytest.raises(RoadTestError, match="main pressure"):
        run_variants(four_speed, without(road_test, "main_pressure"))


# --- options


def test_workshop_leaves_out_what_its_viscosity_does_not_cover(four_speed: Controller, road_test: RoadTest) -> None:
    names = [result.variant.name for result in run_variants(four_speed, road_test, profile=WORKSHOP)]
    assert names == ["W1", "W2", "W3", "W4", "W6", "W7", "W8"]


def test_options_one_at_a_time_and_all_together(four_speed: Controller, road_test: RoadTest) -> None:
    rows = compare_options(four_speed, road_test)
    assert rows[0].profile.options == PAPER.options
    changed = [
        {name for name, value in row.profile.options.items() if value != PAPER.options[name]} for row in rows[1:6]
    ]
    assert changed == [{"diameter"}, {"viscosity"}, {"pump_draw"}, {"pump_efficiency"}, {"entry_loss"}]
    assert rows[6].profile.options == WORKSHOP.options | {"entry_loss": "off"}
    assert rows[7].profile.options == WORKSHOP.options | {"entry_loss": "on"}
    base, mean, d341, sump, slip, entry, lossless, workshop = (
        {name: run and run.max_leakage.leakage for name, run in row.runs.items()} for row in rows
    )
    assert mean["W4"] > base["W4"] > entry["W4"] > sump["W4"]
    assert slip["W4"] == base["W4"]
    assert rows[4].runs["W8"].max_share.share > rows[0].runs["W8"].max_share.share
    assert (d341["W5"], workshop["W5"]) == (None, None)
    assert workshop["W4"] < lossless["W4"]


def test_record_has_what_scripts_rely_on(four_speed: Controller, road_test: RoadTest, results) -> None:
    record = json.loads(to_json(variants_record(results, four_speed, road_test)))
    assert [row["variant"] for row in record["variants"]] == [variant.name for variant in VARIANTS]
    for row in record["variants"]:
        assert {
            "variant", "temperature_c", "wear_percent", "kinematic_viscosity_mm2_s", "density_g_cm3",
            "kinematic_viscosity_used_mm2_s", "printed", "computed", "as_tabulated", "note",
        } <= set(row)  # fmt: skip
        assert set(row["printed"]) == {"max_leakage_dm3_min", "max_share_percent"}
        assert {
            "max_leakage_dm3_min", "max_share_percent", "min_leakage_dm3_min", "share_at_max_leakage_percent",
        } <= set(row["computed"])  # fmt: skip
        assert {"max_leakage_dm3_min", "max_share_percent"} <= set(row["as_tabulated"])
    w3 = record["variants"][2]
    assert w3["kinematic_viscosity_mm2_s"] == pytest.approx(10.93, rel=1e-9, abs=0.0)
    assert w3["kinematic_viscosity_used_mm2_s"] == pytest.approx(8.40, rel=1e-9, abs=0.0)
    assert w3["wear_percent"] == pytest.approx(10.0, rel=1e-9, abs=0.0)
    assert w3["computed"]["max_leakage_dm3_min"] == pytest.approx(3.64, rel=0.01, abs=0.0)
    assert w3["as_tabulated"]["max_leakage_dm3_min"] == pytest.approx(2.80, rel=0.01, abs=0.0)
    assert "8.40" in w3["note"]
    assert record["variants"][0]["note"] is None
    assert record["controller"]["sha256"] == four_speed.sha256
    assert record["road_test"]["sha256"] == road_test.sha256
    assert record["profile"]["name"] == "paper"


# --- the shipped controller and test


def test_shipped_geometry_is_plausible(four_speed: Controller) -> None:
    for land in four_speed.lands:
        assert 20e-6 < land.mounting_clearance <= 40e-6
        assert 3e-3 <= land.contact_length <= 12e-3
        assert land.body_material == "aluminium"
        per_diameter = land.mounting_clearance / land.nominal_diameter
        assert 2.2e-3 < per_diameter < 2.8e-3
    materials = {land.spool_material for land in four_speed.lands}
    assert materials == {"steel", "aluminium"}
    assert {land.spool_material for land in four_speed.lands if land.part == "piston"} == {"steel"}


def test_shipped_test_is_plausible(four_speed: Controller, road_test: RoadTest, results) -> None:
    p_g, p_k, speed, gear = (
        road_test.values(name) for name in ("main_pressure", "converter_pressure", "engine_speed", "gear")
    )
    pressures = four_speed.section_pressures(p_g, p_k)
    assert p_g.max() <= 1000e3
    assert pressures["p_m"].max() <= 500e3
    assert (p_k < p_g).all()
    assert (pressures["p_s"] > 0.1 * p_g).all()
    assert 750 <= speed.min() * 60 <= 850
    assert speed.max() * 60 <= 2500
    assert speed[0] == pytest.approx(speed.min(), rel=1e-3, abs=0.0)
    assert np.unique(gear).tolist() == [1, 2, 3, 4]
    assert (np.diff(gear) >= 0).all()
    assert not {message.code for result in results for message in result.messages}


def test_hot_idle_of_a_unit_as_mounted_stays_below_20_percent(four_speed: Controller, hipol) -> None:
    from atleak.engine.leakage import LeakageModel
    from atleak.engine.projection import project

    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER)
    for point in four_speed.operating_points:
        projection = project(model, point)
        assert projection.share < 0.20
        assert min(gap.pressure_drop for gap in projection.gaps) > 0.0


@pytest.mark.slow
def test_fit_gives_the_shipped_files_again(root: Path) -> None:
    command = [sys.executable, str(root / "tools" / "fit_source_study.py"), "--check"]
    utf8 = {**os.environ, "PYTHONUTF8": "1"}
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", env=utf8, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "would change" not in done.stdout
