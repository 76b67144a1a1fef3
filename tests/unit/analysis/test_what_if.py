"""What is tried departs from the job and leaves it as it is; maps agree with single conditions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.analysis.what_if import Axis, WhatIf, map_over, temperatures_to_try, tried, wears_to_try
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.errors import DomainError, InputError
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import Readings
from atleak.report.tables.what_if import tried_circuit_table, tried_words
from tests.unit.conftest import first_of

UNITS = ("ford_4r70w", "gm_4l60e", "zf_6hp26")  # with circuits, and not the source study's


@pytest.fixture(scope="session")
def worn_units(hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> dict[str, Diagnosis]:
    """Three shipped valve bodies: every third land new, the others worn by 30 and 60 % of their clearance."""
    units = {}
    for name in UNITS:
        controller = load_controller(name)
        diameters = {
            land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.widest_new * (1.0 + 0.3 * (place % 3)))
            for place, land in enumerate(controller.lands)
        }
        units[name] = diagnose(controller, hipol, limits, readings=readings_of(controller, diameters))
    return units


@pytest.fixture(params=["sample", "clutch", *UNITS])
def unit(
    request: pytest.FixtureRequest,
    sample_diagnoses: dict[str, Diagnosis],
    worn_clutch: Diagnosis,
    worn_units: dict[str, Diagnosis],
) -> Diagnosis:
    return {"sample": sample_diagnoses["workshop"], "clutch": worn_clutch, **worn_units}[request.param]


def test_at_the_job_s_own_settings_it_is_the_job(unit: Diagnosis) -> None:
    for settings in (WhatIf(), WhatIf(fluid=unit.fluid, fluid_state=unit.fluid.state, wear=1.0, growth=0.0)):
        here, job = tried(unit, settings), unit.projection
        assert here.projection == here.job == job
        assert here.total == unit.total_rules[0]
        assert here.pressures == unit.pressure_rules_at(job)


def test_at_every_point_of_the_job_the_map_is_the_job(unit: Diagnosis) -> None:
    for job in unit.projections:
        at = map_over(unit, WhatIf(point=job.condition.name), [job.condition.temperature], [1.0])
        assert at.share[0, 0] == pytest.approx(job.share, abs=1e-9)
        assert at.pressures["p_g"][0, 0] == pytest.approx(job.main_pressure_held, abs=1e-3)
        for state in job.circuits:
            assert state.vented or at.pressures[state.circuit.id][0, 0] == pytest.approx(state.pressure, abs=1e-3)


def test_the_share_grows_with_wear_and_with_temperature(unit: Diagnosis) -> None:
    settings = WhatIf()
    wide = map_over(unit, settings, temperatures_to_try(unit, settings), wears_to_try(unit, settings))
    assert wide.axis is Axis.WEAR
    assert np.isfinite(wide.share).all()
    assert (np.diff(wide.share, axis=0) > 0.0).all()
    assert (np.diff(wide.share, axis=1) > 0.0).all()


def test_no_pressure_rises_with_wear(unit: Diagnosis) -> None:
    wide = map_over(unit, WhatIf(), [40.0, 90.0, 130.0], [0.0, 1.0, 2.0, 3.0])
    fed = {state.circuit.id for state in unit.projection.circuits if state.circuit.feeds}
    for name in ("p_g", *fed & wide.pressures.keys()):
        assert (np.diff(wide.pressures[name], axis=0) <= 1e-3).all(), name


def test_a_map_agrees_with_single_trials(worn_units: dict[str, Diagnosis]) -> None:
    unit = worn_units["zf_6hp26"]
    settings = WhatIf(point="hot_idle", engine_speed_rpm=720.0, growth=0.2, eccentricity=0.6, fluid_state="used")
    many = map_over(unit, settings, [60.0, 110.0], [0.5, 2.0])
    for row, wear in enumerate(many.wears):
        for column, temperature in enumerate(many.temperatures):
            one = tried(unit, replace(settings, temperature_c=float(temperature), wear=float(wear)))
            assert many.share[row, column] == pytest.approx(one.projection.share, abs=1e-9)
            for state in one.projection.circuits:
                if not state.vented:
                    pressure = many.pressures[state.circuit.id][row, column]
                    assert pressure == pytest.approx(state.pressure, abs=1e-2)
            begins = {border.level: border.value[column] for border in many.share_borders}
            assert begins == pytest.approx(dict(one.total.steps.levels), abs=1e-9)
            for rule in one.pressures:
                if rule.kind is RuleKind.CIRCUIT_LOSS and rule.circuit is not None and rule.new is not None:
                    under = [border.value[column] for border in many.pressure_borders[rule.circuit.id]]
                    wanted = [max(rule.new - limit, 0.0) for _, limit in rule.steps.levels]
                    assert under == pytest.approx(wanted, abs=1e-2)


def test_without_wear_a_unit_is_as_it_may_have_been_when_new(worn_units: dict[str, Diagnosis]) -> None:
    for unit in worn_units.values():  # none of their pairs is tighter than new
        new = unit.unworn_at(unit.projection)
        assert tried(unit, WhatIf(wear=0.0)).projection.share == pytest.approx(new.share, abs=1e-9)


def test_twice_the_wear_is_twice_the_growth_of_each_land(worn_clutch: Diagnosis) -> None:
    model = WhatIf(wear=2.0).model(worn_clutch)
    for land, wide in zip(worn_clutch.lands, model.clearances, strict=True):
        growth = land.state.radial_clearance - land.state.land.new_clearance
        assert wide.radial_clearance == pytest.approx(land.state.land.new_clearance + 2.0 * growth, abs=1e-12)
        assert wide.sleeve_diameter - wide.spool_diameter == pytest.approx(2.0 * wide.radial_clearance, abs=1e-12)


def test_a_pair_tighter_than_new_stays_as_it_was_measured(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    tight = minimal.lands[0]
    diameters = {
        land.key: (
            land.nominal_diameter,
            land.nominal_diameter + 2.0 * land.new_clearance * (0.7 if land is tight else 1.4),
        )
        for land in minimal.lands
    }
    unit = diagnose(minimal, hipol, limits, readings=readings_of(minimal, diameters))
    for wear in (0.0, 3.0):
        first = WhatIf(wear=wear).model(unit).clearances[0]
        assert first.radial_clearance == pytest.approx(0.7 * tight.new_clearance, abs=1e-12)


def test_of_a_unit_that_nobody_measured_further_growth_is_varied(unmeasured: Diagnosis) -> None:
    wears = wears_to_try(unmeasured, WhatIf())
    wide = map_over(unmeasured, WhatIf(), [80.0], wears)
    assert wide.axis is Axis.GROWTH
    assert wide.share[0, 0] == pytest.approx(tried(unmeasured, WhatIf(temperature_c=80.0)).projection.share, abs=1e-9)
    assert (np.diff(wide.share[:, 0]) > 0.0).all()


def test_outside_the_fluid_s_data_nothing_is_known(worn_clutch: Diagnosis) -> None:
    wide = map_over(worn_clutch, WhatIf(), [80.0, 151.0], [1.0])
    assert np.isfinite(wide.share[0, 0])
    assert np.isnan(wide.share[0, 1])
    assert np.isnan(wide.pressures["p_g"][0, 1])
    assert all(np.isnan(border.value[1]) for border in wide.share_borders)
    nowhere = map_over(worn_clutch, WhatIf(), [151.0], [1.0])
    assert np.isnan(nowhere.share).all()
    with pytest.raises(DomainError, match="151 °C is outside the fluid's data"):
        tried(worn_clutch, WhatIf(temperature_c=151.0))


def test_beyond_the_data_sheet_s_points_the_result_says_so(worn_clutch: Diagnosis) -> None:
    codes = {message.code for message in tried(worn_clutch, WhatIf(temperature_c=130.0)).messages}
    assert "viscosity_extrapolated" in codes
    assert "viscosity_extrapolated" not in {each.code for each in tried(worn_clutch, WhatIf()).messages}


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (WhatIf(wear=-0.1), "wear not accepted"),
        (WhatIf(growth=float("nan")), "growth not accepted"),
        (WhatIf(eccentricity=1.2), "eccentricity"),
        (WhatIf(gear=9), "no such gear"),
        (WhatIf(engine_speed_rpm=0.0), "engine speed not accepted"),
        (WhatIf(point="hot_idel"), "no such condition of the job"),
        (WhatIf(fluid=load_fluid("hipol_atf_iid_used"), fluid_state="fresh"), "describe a used fluid"),
    ],
    ids=["wear", "growth", "eccentricity", "gear", "speed", "point", "fluid"],
)
def test_a_setting_that_cannot_be_is_refused(worn_clutch: Diagnosis, settings: WhatIf, said: str) -> None:
    with pytest.raises(InputError, match=said):
        tried(worn_clutch, settings)


def test_a_used_fluid_stays_used_where_the_job_says_nothing(worn_clutch: Diagnosis) -> None:
    used = load_fluid("hipol_atf_iid_used")
    assert WhatIf(fluid=used).fluid_of(worn_clutch) is used
    thinner = tried(worn_clutch, WhatIf(fluid_state="used")).projection
    assert thinner.share > worn_clutch.projection.share


@pytest.mark.parametrize("name", ["minimal_example", "five_speed_2005", "zf_6hp26", "gm_4l60e"])
@pytest.mark.parametrize("fluid", first_of(["mobil_atf_220", "hipol_atf_iid"]))
def test_a_job_with_used_fluid_is_tried_with_fresh_one(name: str, fluid: str, limits: Limits) -> None:
    controller, data = load_controller(name), load_fluid(fluid)
    fresh, used = (diagnose(controller, data, limits, fluid_state=state) for state in ("fresh", "used"))
    again = tried(used, WhatIf(fluid_state="fresh"))
    assert again.projection.share == pytest.approx(fresh.projection.share, rel=1e-9, abs=0.0)


def test_circuits_whose_set_pressure_follows_the_condition_have_rows_of_their_own(
    three_circuits: Controller, worn_clutch: Diagnosis
) -> None:
    rows = tried_circuit_table(worn_clutch, tried(worn_clutch, WhatIf(wear=2.0)), wording("en")).records()
    assert {row["circuit"] for row in rows} <= {circuit.name for circuit in three_circuits.circuits}
    assert any(row["new_held"] is not None for row in rows)


def test_a_band_begins_where_a_single_trial_reaches_it(worn_units: dict[str, Diagnosis]) -> None:
    unit = worn_units["ford_4r70w"]
    wide = map_over(unit, WhatIf(), [70.0, 100.0], np.linspace(0.0, 3.0, 301).tolist())
    for border in wide.share_borders[:2]:
        for temperature, wear in zip(wide.temperatures, wide.share_reaches(border), strict=True):
            below, past = (
                tried(unit, WhatIf(temperature_c=float(temperature), wear=float(wear + step))).total
                for step in (-0.02, 0.02)
            )
            begins = dict(past.steps.levels)[border.level]
            assert below.value < begins <= past.value


def test_a_level_that_no_wear_of_the_map_reaches_begins_nowhere(worn_clutch: Diagnosis) -> None:
    cold = map_over(worn_clutch, WhatIf(), [-20.0], [0.0, 1.0])
    assert np.isnan(cold.share_reaches(cold.share_borders[-1])).all()


def test_a_worn_clutch_holds_too_little_from_less_wear_the_hotter_it_is(worn_clutch: Diagnosis) -> None:
    wide = map_over(worn_clutch, WhatIf(), [60.0, 80.0, 100.0], np.linspace(0.0, 3.0, 31).tolist())
    watch = wide.pressure_borders["clutch_c1"][0]
    wears = wide.pressure_reaches("clutch_c1", watch)
    assert np.isfinite(wears).all()
    assert (np.diff(wears) < 0.0).all()


def test_all_that_is_tried_is_said(worn_clutch: Diagnosis) -> None:
    settings = WhatIf(temperature_c=95.5, wear=1.25, growth=0.1, fluid_state="used", eccentricity=0.5)
    said = tried_words(tried(worn_clutch, settings), wording("de")).replace("\u00a0", " ")
    assert said.startswith("95,5 °C, ")
    assert said.endswith("Verschleiß × 1,25, 10 % weiterer Zuwachs, Öl gebraucht, e/c 0,5")
    unknown = tried(worn_clutch, WhatIf(eccentricity="unknown"))
    assert tried_words(unknown, wording("en")).endswith("unknown: mean of all positions")


def test_circuits_are_named_in_the_reader_s_language(worn_units: dict[str, Diagnosis]) -> None:
    unit = worn_units["gm_4l60e"]
    here = tried(unit, WhatIf())
    names = {
        say.language: {row["circuit"] for row in tried_circuit_table(unit, here, say).records()}
        for say in map(wording, ("en", "de"))
    }
    assert "forward clutch" in names["en"]
    assert "Vorwärtskupplung" in names["de"]
    assert "forward clutch" not in names["de"]
