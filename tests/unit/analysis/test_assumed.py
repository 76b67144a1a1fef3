"""What is assumed is listed with what it does to the verdict, as a diagnosis with the value moved has it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from atleak.analysis.assumed import AssumedValue, Ending, assumed_values
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty import DEFAULTS, Assumptions
from atleak.measurements.readings import Readings
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.tables.assumed import assumed_line, assumed_records, assumed_table
from tests.unit.conftest import first_of

SHEET = Path("sample_data/measuring_sheet_five_speed.xlsx")
Unit = tuple[Controller, Fluid, Assumptions]


def judged(controller: Controller, fluid: Fluid, assumptions: Assumptions = DEFAULTS) -> Diagnosis:
    described = load_controller(controller.id)
    limits, readings = load_limits("project_default"), read_readings(SHEET, described)
    return diagnose(controller, fluid, limits, readings=readings, assumptions=assumptions)


@pytest.fixture(scope="module")
def worn() -> Diagnosis:
    return judged(load_controller("five_speed_2005"), load_fluid("hipol_atf_iid"))


@pytest.fixture(scope="module")
def values(worn: Diagnosis) -> dict[str, AssumedValue]:
    return {each.what: each for each in assumed_values(worn)}


def thinner(by: float) -> Callable[[Controller, Fluid], Unit]:
    def made(controller: Controller, fluid: Fluid) -> Unit:
        points = tuple((temperature, nu * (1.0 + by)) for temperature, nu in fluid.points)
        return controller, replace(fluid, points=points), DEFAULTS.with_settings({"viscosity_percent": 0})

    return made


def larger_pump(by: float) -> Callable[[Controller, Fluid], Unit]:
    def made(controller: Controller, fluid: Fluid) -> Unit:
        pump = controller.pump
        return replace(controller, pump=replace(pump, displacement=pump.displacement * (1.0 + by))), fluid, DEFAULTS

    return made


def longer(by: float) -> Callable[[Controller, Fluid], Unit]:
    def made(controller: Controller, fluid: Fluid) -> Unit:
        lands = tuple(replace(land, contact_length=land.contact_length + by) for land in controller.lands)
        return replace(controller, lands=lands), fluid, DEFAULTS

    return made


@pytest.mark.parametrize(
    ("what", "end", "moved"),
    [
        ("viscosity", 1, thinner(-0.098)),
        ("viscosity", 2, thinner(0.098)),
        ("displacement", 2, larger_pump(0.1)),
        ("contact_length", 1, longer(-0.196e-3)),
    ],
)
def test_an_end_is_what_a_diagnosis_with_the_value_there_says(
    worn: Diagnosis,
    values: dict[str, AssumedValue],
    what: str,
    end: int,
    moved: Callable[[Controller, Fluid], Unit],
) -> None:
    again, ends = judged(*moved(worn.controller, worn.fluid)), values[what].ends
    assert ends is not None
    assert said(ends[end]) == likely(again)


def said(end: Ending) -> tuple[Any, ...]:
    return end.verdict, end.decision, pytest.approx(end.probability, abs=0.05)


def likely(found: Diagnosis) -> tuple[Any, ...]:
    assert isinstance(found.decided_by, LandDiagnosis)
    return found.verdict, found.decision, found.decided_by.probability_over_limit


@pytest.mark.parametrize("name", first_of(["five_speed_2005", "chrysler_41te", "gm_4l60e", "zf_6hp26"]))
def test_ends_of_what_is_lopsided_are_what_a_diagnosis_says(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    """Of lands worn to one side in an unknown shape, which counts less where the spool lies at the wall."""
    controller = load_controller(name)
    lands = [land for land in controller.lands if not land.seal]
    worn = {lands[3].key: 22e-6, lands[7].key: 22e-6}
    sheet = readings_of(
        controller,
        {
            land.key: (
                land.nominal_diameter,
                land.nominal_diameter + 2.0 * (land.new_clearance + worn.get(land.key, 0.0)),
            )
            for land in lands
        },
    )
    found = diagnose(controller, hipol, limits, readings=sheet)
    ends = {each.what: each.ends for each in assumed_values(found)}
    at_the_wall = diagnose(controller, hipol, limits, readings=sheet, profile=replace(found.profile, eccentricity=1.0))
    even = DEFAULTS.with_settings({"one_sided_wear_percent": 0})
    all_even = diagnose(controller, hipol, limits, readings=sheet, assumptions=even)
    assert ends["eccentricity"] is not None
    assert ends["one_sided_wear"] is not None
    assert said(ends["eccentricity"][2]) == likely(at_the_wall)
    assert said(ends["one_sided_wear"][1]) == likely(all_even)


def test_what_it_is_now_is_the_verdict_of_the_unit(worn: Diagnosis, values: dict[str, AssumedValue]) -> None:
    moved = [each.ends for each in values.values() if each.ends is not None]
    assert {(ends[0].verdict, ends[0].decision) for ends in moved} == {(worn.verdict, worn.decision)}
    assert (values["eccentricity"].changes, values["contact_length"].changes) == ("decision", "nothing")
    assert values["gaps"].changes is None


def test_the_line_names_those_that_change_the_verdict_and_the_table_has_them_first(
    worn: Diagnosis, sample_diagnoses: dict[str, Diagnosis]
) -> None:
    say, sample = wording("en"), sample_diagnoses["workshop"]
    said, first = assumed_line(sample, say), assumed_table(sample, say).records()[0]
    assert said.startswith(f"{len(assumed_values(sample))} kinds of value are assumed: neither measured nor published.")
    assert first["assumed_changes"] == "the verdict"
    assert first["assumed_what"] in said
    assert assumed_line(worn, say).endswith("change the verdict by itself: how much of the wear is to one side.")


@pytest.mark.parametrize("radial", [22.7e-6, 25.4e-6, 28.2e-6])
def test_of_a_land_known_by_a_range_what_it_is_now_is_the_verdict_too(
    radial: float, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    controller = load_controller("five_speed_2005")
    land = controller.lands[0]
    sheet = readings_of(controller, {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * radial)})
    found = diagnose(controller, hipol, limits, readings=sheet)
    ends = [each.ends[0] for each in assumed_values(found) if each.ends is not None]
    assert {(each.verdict, each.decision) for each in ends} == {(found.verdict, found.decision)}


def test_limits_are_assumed_where_this_project_chose_them(worn: Diagnosis, values: dict[str, AssumedValue]) -> None:
    assert values["limit_circuit_loss"].values == (55.0, 103.0)
    assert "limit_commanded_pressure" not in values
    (row,) = (each for each in assumed_records(worn) if each["what"] == "limit_circuit_loss")
    assert (row["stands_in"], row["unit"], row["off"], row["off_is_percent"]) == ("project_default", "kPa", 10.0, True)


def test_what_the_workshop_states_is_not_assumed(worn: Diagnosis, values: dict[str, AssumedValue]) -> None:
    own = judged(worn.controller, worn.fluid, DEFAULTS.with_settings({"viscosity_percent": 3}))
    assert {each.what for each in assumed_values(own)} == {*values} - {"viscosity"}


def test_where_nothing_was_measured_nothing_is_said_of_effects(
    four_speed: Controller, hipol: Fluid, limits: Limits
) -> None:
    new = diagnose(four_speed, hipol, limits)
    assert {each.changes for each in assumed_values(new)} == {None}
    assert "verdict" not in assumed_line(new, wording("en"))
