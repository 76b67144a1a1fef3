"""A unit as engineers take it up: loaded, changed, swept; the same numbers as the diagnosis of the same clearances."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from atleak.catalogue.limits import Limits
from atleak.common.errors import DomainError, InputError
from atleak.common.units import DM3_MIN, KPA
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER
from atleak.engine.projection import project, stated_condition
from atleak.engine.unit import load
from atleak.measurements.readings import Readings

UNITS = {"four_speed_2023": "25/1", "five_speed_2005": "manual_valve/3", "gm_4l60e": None, "zf_6hp26": None}


@pytest.mark.parametrize("name", UNITS)
def test_a_changed_clearance_is_that_of_a_sheet_that_reads_it(
    name: str, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    unit = load(name)
    land = unit.controller.lands[0] if UNITS[name] is None else unit.land(UNITS[name] or "")
    wide, diameter = 40e-6, land.nominal_diameter
    readings = readings_of(unit.controller, {land.key: (diameter, diameter + 2.0 * wide)})
    measured = diagnose(unit.controller, None, limits, readings=readings)
    changed = unit.with_clearance("{}/{}".format(*land.key), um=40.0)
    for point in unit.controller.operating_points:
        found, expected = project(changed, point), measured.at(point)
        assert found.leakage == pytest.approx(expected.leakage, rel=1e-9, abs=0.0)
        assert found.main_pressure_held == pytest.approx(expected.main_pressure_held, rel=1e-9, abs=0.0)
    assert unit == load(name), "a unit never changes"


def test_form_and_mean_diameter_follow_the_clearance(sample_diagnoses: dict[str, Diagnosis]) -> None:
    unit = sample_diagnoses["workshop"].model
    oval = next(state for state in unit.clearances if state.land.key == ("25", 1))
    assert oval.form_moments[0] > 0.0
    changed = unit.with_clearance("25/1", um=34.0)
    (even,) = (state for state in changed.clearances if state.land.key == oval.land.key)
    assert even.form_moments == (0.0, 0.0)
    assert even.sleeve_diameter == even.spool_diameter + 2.0 * 34e-6
    assert (even.min_clearance, even.max_clearance, even.sleeve_ovality) == (34e-6, 34e-6, None)
    kept = replace(oval, radial_clearance=34e-6)  # which keeps ovality and sleeve as they were read
    only_mean = replace(unit, clearances=tuple(kept if each is oval else each for each in unit.clearances))
    hot = "hot_idle"
    assert changed.sweep(hot)["leakage_dm3_min"].item() < only_mean.sweep(hot)["leakage_dm3_min"].item()


@pytest.mark.parametrize("name", UNITS)
def test_a_sweep_is_each_of_its_projections(name: str) -> None:
    unit = load(name)
    frame = unit.sweep("hot_idle", temperature_c=range(40, 121, 40), engine_rpm=700)
    assert frame.index.name == "temperature_c"
    assert frame.index.to_list() == [40, 80, 120]
    for temperature, row in frame.iterrows():
        base = next(each for each in unit.controller.operating_points if each.name == "hot_idle")
        point = stated_condition(
            unit.controller, temperature=float(str(temperature)), engine_speed=700.0 / 60.0, base=base
        )
        found = project(unit, point)
        assert row["leakage_dm3_min"] == found.leakage * DM3_MIN
        assert row["p_g_held_kpa"] == found.main_pressure_held * KPA
        for each in found.circuits:
            assert row[f"{each.circuit.id}_kpa"] == each.pressure * KPA
    assert frame["leakage_dm3_min"].is_monotonic_increasing


def test_several_ranges_are_each_combination_and_a_land_s_leakage_follows_the_cube() -> None:
    unit = load("four_speed_2023", profile="paper")
    frame = unit.sweep("hot_idle", main_pressure_kpa=[400, 800], land="25/1", clearance_um=[20, 40])
    assert frame.index.names == ["main_pressure_kpa", "clearance_um"]
    assert len(frame) == 4
    leaks = frame["land_leakage_dm3_min"]
    warm = [
        state.effective_clearance(point.temperature)
        for um in (20, 40)
        for state in unit.with_clearance("25/1", um=um).clearances
        for point in unit.controller.operating_points
        if (state.land.key, point.name) == (("25", 1), "hot_idle")
    ]
    assert leaks[400, 40] / leaks[400, 20] == pytest.approx((warm[1] / warm[0]) ** 3, rel=1e-9, abs=0.0)
    assert leaks[800, 20] > leaks[400, 20]


def test_what_a_reader_must_know_of_a_row_is_in_its_notes() -> None:
    starved = load("four_speed_2023").with_clearance("25/1", um=400).sweep("hot_idle", engine_rpm=[300, 3000])
    assert "demand_over_pump" in starved["notes"][300]
    assert "demand_over_pump" not in starved["notes"][3000]
    assert starved["p_g_held_kpa"][300] < starved["p_g_held_kpa"][3000]


def test_a_sweep_is_drawn_by_pandas() -> None:
    axes = load("four_speed_2023").sweep(temperature_c=range(20, 121, 10)).plot(y="leakage_dm3_min")
    assert axes.get_xlabel() == "temperature_c"


def test_a_profile_and_its_options_are_chosen_by_name() -> None:
    unit = load("four_speed_2023", fluid="hipol_atf_iid", profile="paper", eccentricity=1.0)
    assert unit.profile == PAPER.with_options(eccentricity=1.0)


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"land": "25/9"}, "no such land"),
        ({"clearance_um": 40}, "no such land"),
        ({"land": "25/1", "clearance_um": -1.0}, "clearance not accepted"),
        ({"land": "25/1", "clearance_um": math.nan}, "clearance not accepted"),
        ({"at": "hot_idel"}, "no such operating point"),
        ({"main_pressure_kpa": 0}, "main pressure not accepted"),
        ({"engine_rpm": -800}, "engine speed not accepted"),
        ({"gear": [1, 9]}, "no such gear"),
        ({"temperature_c": "80"}, "temperature_c: not a number .found '80'"),
        ({"temperature_c": np.array(80)}, "temperature_c: not a number"),
        ({"engine_rpm": [800, "fast"]}, "engine_rpm: not a number .found 'fast'"),
    ],
)
def test_what_cannot_be_swept(stated: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        load("four_speed_2023").sweep(**stated)


def test_outside_the_fluid_s_data_there_is_no_number() -> None:
    with pytest.raises(DomainError):
        load("four_speed_2023").sweep(temperature_c=[20, 500])


def test_nothing_stated_is_the_first_operating_point() -> None:
    unit = load("four_speed_2023")
    frame = unit.sweep()
    assert isinstance(frame, pd.DataFrame)
    assert frame["leakage_dm3_min"].item() == project(unit, unit.controller.operating_points[0]).leakage * DM3_MIN
