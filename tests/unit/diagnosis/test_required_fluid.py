"""The fluid that a maker requires: taken unless another is chosen, and uncertain where it is only the nearest known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import Fluid, RequiredFluid, load_fluid
from atleak.catalogue.limits import load_limits
from atleak.common.errors import CatalogueError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.report.json.diagnosis import diagnosis_record

Edited = Callable[..., Path]
STATED = RequiredFluid("Mercon V", "mobil_multi_vehicle_atf", (6.8e-6, 7.5e-6), "manual, page 1")


def said(diagnosis: Diagnosis) -> dict[str, str]:
    return {each.code: each.text for each in diagnosis.messages}


def of(controller: Controller, fluid: Fluid | None = None, **more: object) -> Diagnosis:
    return diagnose(controller, fluid, load_limits("project_default"), **more)


@pytest.mark.parametrize("name", shipped_files("controllers"))
def test_every_shipped_unit_names_a_shipped_fluid_and_who_requires_it(name: str) -> None:
    required = load_controller(name).fluid
    assert required is not None
    assert required.entry in shipped_files("fluids")
    assert required.source
    if required.viscosity_100 is not None:
        low, high = required.viscosity_100
        assert low <= load_fluid(required.entry).kinematic_viscosity(100.0) * (1.0 + 1e-12)
        assert high >= load_fluid(required.entry).kinematic_viscosity(100.0) * (1.0 - 1e-12)


def test_the_study_s_unit_keeps_the_study_s_fluid() -> None:
    found = of(load_controller("four_speed_2023"))
    assert (found.fluid.id, found.controller.fluid.choice(found.fluid)) == ("hipol_atf_iid", "required")
    assert not {"fluid_assumed", "fluid_not_required"} & said(found).keys()


def test_a_unit_without_a_fluid_of_its_own_takes_the_one_of_all_jobs_before() -> None:
    found = of(replace(load_controller("chrysler_41te"), fluid=None))
    record = diagnosis_record(found)["fluid"]
    assert (record["id"], record["required"], record["taken_as"]) == ("hipol_atf_iid", None, None)


def test_the_required_fluid_is_taken_and_another_one_is_said_once() -> None:
    unit = load_controller("chrysler_41te")
    own, other = of(unit), of(unit, load_fluid("hipol_atf_iid"))
    assert own.fluid.id == "mobil_atf_plus_4"
    assert "fluid_not_required" not in said(own)
    assert [each.level for each in other.messages if each.code == "fluid_not_required"] == ["warning"]
    assert "requires ATF+4" in said(other)["fluid_not_required"]
    records = [diagnosis_record(each)["fluid"] for each in (own, other)]
    assert [record["taken_as"] for record in records] == ["required", "other"]
    assert [record["required"] for record in records] == ["ATF+4"] * 2


def test_an_assumed_fluid_says_between_which_viscosities_it_may_lie() -> None:
    found = of(load_controller("five_speed_2005"))
    record = diagnosis_record(found)["fluid"]
    assert (record["id"], record["taken_as"]) == ("mobil_multi_vehicle_atf", "assumed")
    ends = record["required_viscosity_100_low_mm2_s"], record["required_viscosity_100_high_mm2_s"]
    assert ends == pytest.approx((6.8, 7.5), rel=1e-12, abs=0.0)
    assert "6.8 to 7.5 mm²/s" in said(found)["fluid_assumed"]


@pytest.mark.parametrize("state", ["fresh", "used"])
def test_the_range_of_an_assumed_fluid_widens_every_interval(sample: Diagnosis, state: str) -> None:
    known = replace(STATED, viscosity_100=None)
    wide, narrow = (
        diagnose(
            replace(sample.controller, fluid=required), None, sample.limits, fluid_state=state, readings=sample.readings
        )
        for required in (replace(STATED, viscosity_100=(4.5e-6, 7.5e-6)), known)
    )
    assert wide.fluid.points == narrow.fluid.points
    for of_wide, of_narrow in zip(wide.uncertainty.totals, narrow.uncertainty.totals, strict=True):
        assert of_wide.u_leakage > of_narrow.u_leakage
        assert dict(of_wide.budget)["range of the fluid's viscosity"] > dict(of_narrow.budget).get(
            "range of the fluid's viscosity", 0.0
        )


def test_the_draws_of_an_assumed_fluid_fill_its_range_and_nothing_else() -> None:
    fluid = STATED.taken(load_fluid("mobil_multi_vehicle_atf"))
    ends = fluid.viscosity_factor(math.sqrt(3.0) * np.array([-1.0, 1.0])) * fluid.kinematic_viscosity(100.0)
    assert ends == pytest.approx([6.8e-6, 7.5e-6], rel=1e-12, abs=0.0)
    assert STATED.taken(fluid) is fluid  # a job of another one's result is not widened twice
    used = fluid.in_state("used")
    assert used.viscosity_range == pytest.approx(
        (fluid.viscosity_range[0] * 0.75 / 0.775, fluid.viscosity_range[1] * 0.80 / 0.775), rel=1e-12, abs=0.0
    )
    other = load_fluid("mobil_atf_220")
    assert STATED.taken(other) is other


def test_the_used_data_of_the_required_fluid_are_no_other_fluid() -> None:
    found = of(load_controller("four_speed_2023"), load_fluid("hipol_atf_iid_used"))
    assert "fluid_not_required" not in said(found)


def test_a_fluid_that_bears_the_name_of_the_required_one_is_that() -> None:
    own = replace(load_fluid("mobil_atf_220"), id="mine", name="Our drum of mercon v, data sheet")
    assert STATED.choice(own) == STATED.choice(own.in_state("used")) == "required"
    assert STATED.messages(own) == []
    assert STATED.taken(own) is own
    assert STATED.choice(load_fluid("mobil_atf_220")) == "other"


def test_the_range_of_fresh_fluid_is_not_laid_over_data_of_a_used_one() -> None:
    required = RequiredFluid("an ATF", "hipol_atf_iid", (6.8e-6, 7.5e-6), "manual, page 1")
    fresh, used = load_fluid("hipol_atf_iid"), load_fluid("hipol_atf_iid_used")
    assert required.taken(used).viscosity_range == required.taken(fresh).viscosity_range


def test_a_fluid_that_is_not_in_the_catalogue_is_named() -> None:
    unit = load_controller("five_speed_2005")
    with pytest.raises(CatalogueError, match="mobil_multi_vehicle_atf"):
        of(replace(unit, fluid=replace(unit.fluid, entry="mobil_multi_vehicel_atf")))


@pytest.mark.parametrize("value", ["7.0", "[7.0]", "[7.5, 6.8]", '["6.8", 7.5]', "[0.0, 7.5]"])
def test_a_range_of_viscosities_is_two_numbers_the_lower_first(edited: Edited, value: str) -> None:
    path = edited(
        "controllers", "five_speed_2005", ("viscosity_100_mm2_s = [6.8, 7.5]", f"viscosity_100_mm2_s = {value}")
    )
    with pytest.raises(CatalogueError, match=r"the lower end first, such as \[4.5, 7.5\]"):
        load_controller(path)
