"""What is accepted and doubted: slips of unit and decimal sign in catalogue files, each with the place of its value."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from atleak.catalogue.controller_file import checked_controller, load_controller
from atleak.catalogue.controller_tables import ControllerFile
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import KINDS, read_tables, shipped_files
from atleak.catalogue.fluid import FluidFile, checked_fluid, load_fluid
from atleak.catalogue.instruments import checked_instrument, load_instrument
from atleak.catalogue.limits import LimitsFile, checked_limits, load_limits
from atleak.common.errors import CatalogueError
from atleak.diagnosis.examination import diagnose

LOAD: Mapping[str, Callable[[str], Any]] = {
    "controllers": load_controller, "fluids": load_fluid, "limits": load_limits, "instruments": load_instrument,
}  # fmt: skip
CHECKED: Mapping[str, Callable[[Mapping[str, Any]], Any]] = {
    "controllers": checked_controller, "fluids": checked_fluid, "limits": checked_limits,
    "instruments": checked_instrument,
}  # fmt: skip
EXAMPLE = {
    "controllers": "minimal_example", "fluids": "mobil_atf_220", "limits": "project_default",
    "instruments": "micrometer",
}  # fmt: skip
Steps = tuple[str | int, ...]


def changed(kind: str, *changes: tuple[Steps, Any]) -> dict[str, Any]:
    """The tables of a shipped entry with values put at these steps."""
    data = copy.deepcopy(read_tables(kind, EXAMPLE[kind])[0])
    for steps, value in changes:
        table: Any = data
        for step in steps[:-1]:
            table = table[step]
        table[steps[-1]] = value
    return data


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind in KINDS for name in shipped_files(kind)])
def test_nothing_that_ships_is_doubted(kind: str, name: str) -> None:
    assert LOAD[kind](name).doubts == ()


def test_a_line_that_is_set_to_another_pressure_than_a_point_states_is_doubted_beyond_rounding() -> None:
    data = copy.deepcopy(read_tables("controllers", "zf_6hp26")[0])  # 606.5 kPa, of which [line] makes 606.484
    data["operating_points"][1]["p_g_kpa"] = 607.5
    (doubt,) = checked_controller(data).doubts
    assert (doubt.code, doubt.level) == ("line_apart", "warning")
    assert "[line] gives 606.5 kPa, p_g_kpa states 607.5 kPa; that of [line] is taken." in str(doubt.text)
    assert "p_g_kpa" in str(doubt.place)


@pytest.mark.parametrize(
    ("kind", "steps", "value", "said"),
    [
        ("controllers", ("pump", "displacement_mm3"), 18.0, "18 mm³ is unusual for the displacement of one revolution"),
        ("controllers", ("pump", "displacement_mm3"), 18.0, "Was it in cm³?"),
        ("controllers", ("pump", "volumetric_efficiency"), 0.2, "a volumetric efficiency"),
        ("controllers", ("operating_points", 0, "engine_rpm"), 8500.0, "an engine speed"),
        ("controllers", ("operating_points", 1, "p_g_kpa"), 4.2, "Was it in bar?"),
        ("controllers", ("components", 0, "lands", 0, "nominal_diameter_mm"), 0.591, "Was it in inch?"),
        ("controllers", ("components", 0, "lands", 0, "mounting_clearance_um"), 180.0, "a radial clearance when new"),
        ("controllers", ("materials", "aluminium", "expansion_per_k"), 2.1e-4, "a linear expansion"),
        ("limits", ("wear_percent", "replace"), 5000.0, "5000 % is unusual for a limit of wear"),
        ("limits", ("wear_percent", "watch"), {"percent": 0.1}, "Was it in parts of one?"),
        ("limits", ("total_share_percent", "critical"), 120.0, "the unit's share of the pump"),
        ("limits", ("pair_share_percent", "watch"), {"percent": 2.0, "growth_percent": 0.25}, "growth over a new one"),
        ("limits", ("reserve", "amber"), 5.0, "a limit of the pump's reserve"),
        ("limits", ("commanded_pressure_kpa", "watch"), 0.69, "Was it in bar"),
        ("instruments", ("calibration_um",), 1000.0, "the standard uncertainty of a gauge for diameters"),
        ("instruments", ("calibration_um",), 0.0, "the standard uncertainty of a gauge for diameters"),
        ("instruments", ("resolution_um",), 0.001, "Was it in mm?"),
        ("instruments", ("repeatability_um",), 100.0, "the standard deviation of one reading"),
        ("fluids", ("viscosity", 0, "kinematic_viscosity_mm2_s"), 9000.0, "a transmission fluid at 40 °C"),
        ("fluids", ("viscosity", 1, "kinematic_viscosity_mm2_s"), 0.7, "a transmission fluid at 100 °C"),
        ("fluids", ("density", "density_g_cm3"), 1.2, "the density of a transmission fluid"),
        ("fluids", ("pour_point_c",), 15.0, "the pour point of a transmission fluid"),
    ],
)
def test_a_value_that_is_possible_and_unusual_is_doubted_at_its_place(
    kind: str, steps: Steps, value: Any, said: str
) -> None:
    entry = CHECKED[kind](changed(kind, (steps, value)))
    doubts = {doubt.place.steps: doubt for doubt in entry.doubts if "source is given for" not in doubt.text}
    (found,) = doubts
    assert found[: len(steps)] == steps
    assert said in doubts[found].text
    assert doubts[found].level == "warning"


def test_a_viscosity_of_7000_at_100_degrees_is_doubted_and_refused_as_rising() -> None:
    data = changed("fluids", (("viscosity", 1, "kinematic_viscosity_mm2_s"), 7000.0))
    (doubt,) = doubts_of("fluids", FluidFile, data, "own.toml")
    assert str(doubt.place) == "own.toml, [viscosity[2]], key 'kinematic_viscosity_mm2_s'"
    assert "7000 mm²/s is unusual for a transmission fluid at 100 °C: most are from 2.7 to 14 mm²/s" in doubt.text
    with pytest.raises(CatalogueError, match="viscosity must fall from 40 to 100") as caught:
        checked_fluid(data)
    assert caught.value.place.steps == ("viscosity", 1, "kinematic_viscosity_mm2_s")


def with_clearances(*um: float, **more: Any) -> dict[str, Any]:
    lands = [{"land": number, "mounting_clearance_um": each} for number, each in enumerate(um, start=1)]
    return {"components": [{"id": "8", "lands": lands}], **more}


@pytest.mark.parametrize(
    ("data", "doubted"),
    [
        (with_clearances(12.7, 25.4, 40.0, 30.0), True),  # the published diametral range, typed as radial
        (with_clearances(6.4, 13.0, 20.0, 14.0), False),
        (with_clearances(28.0, 28.0, 28.0, defaults={"published": ["mounting_clearance_um"]}), False),
        (with_clearances(28.0, 28.0, 28.0, defaults={"mounting_clearance_of_used_unit": True}), False),
        (with_clearances(57.0, 57.0, 57.0, defaults={"measured": ["mounting_clearance_um"]}), True),
        (with_clearances(30.0, 30.0), False),  # two lands have no median that says anything
    ],
    ids=["diametral", "radial", "published", "of a used unit", "twice as wide", "two lands"],
)
def test_mounting_clearances_that_may_be_diametral_are_asked_about(data: dict[str, Any], doubted: bool) -> None:
    doubts = doubts_of("controllers", ControllerFile, data, "own.toml")
    assert [doubt.place.steps for doubt in doubts] == (
        [("components", 0, "lands", 0, "mounting_clearance_um")] if doubted else []
    )
    assert all("are these the whole of it?" in doubt.text for doubt in doubts)


def test_a_range_of_clearances_counts_by_its_middle_and_for_lands_that_state_none() -> None:
    lands = [{"land": number} for number in (1, 2, 3)]
    data = {
        "components": [{"id": "8", "lands": lands}],
        "defaults": {"mounting_clearance_um": [12.7, 40.0]},
    }
    (doubt,) = doubts_of("controllers", ControllerFile, data, "own.toml")
    assert doubt.place.steps == ("defaults", "mounting_clearance_um")
    assert "26.35 µm" in doubt.text


def test_a_displacement_that_follows_from_dimensions_is_doubted_too() -> None:
    (doubt,) = doubts_of("controllers", ControllerFile, {"pump": {"kind": "vane"}}, "own.toml", displacement=1.8e-8)
    assert doubt.text.startswith("By the dimensions of the pump, 18 mm³ is unusual")
    assert doubts_of("controllers", ControllerFile, {"pump": {"kind": "vane"}}, "own.toml", displacement=1.8e-5) == ()


def test_changed_limits_that_keep_a_shipped_source_are_doubted_until_they_are_the_workshops() -> None:
    (doubt,) = checked_limits(changed("limits", (("wear_percent", "replace"), 40.0))).doubts
    assert doubt.place.steps == ("wear_percent", "origin")
    assert "were they set by the workshop?" in doubt.text
    own = (("wear_percent", "origin"), "set by the workshop")
    assert checked_limits(changed("limits", (("wear_percent", "replace"), 40.0), own)).doubts == ()


def test_what_is_no_number_is_passed_over() -> None:
    data = {"pump": "none", "components": [{"lands": "two"}, 3], "operating_points": [{"engine_rpm": "fast"}]}
    assert doubts_of("controllers", ControllerFile, data, "own.toml") == ()
    assert doubts_of("limits", LimitsFile, {"wear_percent": {"watch": True, "replace": "much"}}, "own.toml") == ()


def test_a_result_says_what_of_its_own_entries_is_doubted() -> None:
    controller = checked_controller(changed("controllers", (("pump", "displacement_mm3"), 18.0)))
    limits = checked_limits(changed("limits", (("reserve", "amber"), 5.0)))
    result = diagnose(controller, load_fluid("mobil_atf_220"), limits)
    said = [message.text for message in result.messages if message.code == "unusual_value"]
    assert any("18 mm³" in text for text in said)
    assert any("5 is unusual for a limit of the pump's reserve" in text for text in said)


def test_a_description_by_which_a_new_unit_cannot_hold_its_pressure_is_doubted() -> None:
    controller = checked_controller(changed("controllers", (("pump", "displacement_mm3"), 18.0)))
    result = diagnose(controller, load_fluid("mobil_atf_220"), load_limits("project_default"))
    (said,) = [message for message in result.messages if message.code == "description_impossible"]
    assert "With every land and its pump new it could not hold its pressure" in said.text
    sound = diagnose(load_controller("minimal_example"), result.fluid, result.limits)
    assert "description_impossible" not in {message.code for message in sound.messages}
