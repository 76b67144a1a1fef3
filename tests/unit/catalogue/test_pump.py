"""A pump in a controller's file: its displacement by the calliper, its slip by its clearances, new and measured."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest

from atleak.catalogue.controller_file import checked_controller
from atleak.catalogue.entries import Evidence, read_tables
from atleak.catalogue.known_values import known_values
from atleak.catalogue.pump import Pump, PumpClearances
from atleak.catalogue.pump_dimensions import other_dimensions
from atleak.catalogue.pump_tables import PumpTable
from atleak.common.errors import CatalogueError
from atleak.equations import pump as equations

GEAR: dict[str, Any] = {
    "kind": "external_gear",
    "teeth": 12,
    "width_mm": 16.0,
    "tip_diameter_mm": 50.0,
    "centre_distance_mm": 42.0,
}
CRESCENT: dict[str, Any] = {
    "kind": "crescent",
    "teeth": 24,
    "ring_teeth": 29,
    "width_mm": 12.0,
    "tip_diameter_mm": 77.5,
    "ring_tip_diameter_mm": 82.5,
    "centre_distance_mm": 7.5,
}
GEROTOR: dict[str, Any] = {
    "kind": "gerotor",
    "teeth": 8,
    "width_mm": 12.0,
    "tip_diameter_mm": 60.0,
    "root_diameter_mm": 50.0,
}
VANE: dict[str, Any] = {
    "kind": "vane",
    "vanes": 13,
    "width_mm": 18.0,
    "cam_ring_diameter_mm": 70.0,
    "eccentricity_mm": 6.0,
    "held_at_demand": True,
}
LANDS: dict[str, Any] = {
    "root_diameter_mm": 66.0,
    "shaft_diameter_mm": 48.0,
    "ring_root_diameter_mm": 94.0,
    "ring_outer_diameter_mm": 110.0,
    "tip_land_mm": 2.0,
    "sealing_tips": 3,
}
NEW: dict[str, Any] = {"side_clearance_um": 35.0, "tip_clearance_um": 110.0}


def tables(pump: dict[str, Any]) -> dict[str, Any]:
    data = copy.deepcopy(read_tables("controllers", "minimal_example")[0])
    data["pump"] = {"volumetric_efficiency": 0.92, "source": "calliper", **pump}
    return data


def pump_of(**pump: Any) -> Pump:
    return checked_controller(tables(pump)).pump


def faults_of(**pump: Any) -> dict[tuple[str | int, ...], CatalogueError]:
    with pytest.raises(CatalogueError) as caught:
        checked_controller(tables(pump))
    faults = [caught.value, *caught.value.others]
    return {fault.place.steps: fault for fault in faults}  # type: ignore[misc]


@pytest.mark.parametrize(
    ("pump", "displacement"),
    [
        (GEAR, equations.gear_pair_displacement(0.050, 0.042, 0.016, 12)),
        (CRESCENT, equations.crescent_displacement(0.0775, 0.0825, 0.0075, 0.012, 24, 29)),
        (GEROTOR, equations.gerotor_displacement(0.060, 0.050, 0.012, 8)),
        (VANE, equations.vane_displacement(0.070, 0.006, 0.018, 13)),
        (
            {**{key: VANE[key] for key in VANE if key != "eccentricity_mm"}, "rotor_diameter_mm": 58.0},
            equations.vane_displacement(0.070, 0.006, 0.018, 13),
        ),
        (
            {"kind": "crescent", "module_mm": 4.5, "teeth": 12, "width_mm": 12.0, "tooth_height_mm": 8.4},
            equations.displacement(0.0045, 12, 0.012, 0.0084),
        ),
        ({"kind": "gerotor", "displacement_mm3": 12e3, "tip_diameter_mm": 60.0, "shaft_diameter_mm": 30.0}, 12e-6),
    ],
    ids=["gears", "crescent", "gerotor", "vane", "vane by its rotor", "module", "stated beside dimensions of its gaps"],
)
def test_each_kind_displaces_what_its_dimensions_say(pump: dict[str, Any], displacement: float) -> None:
    read = pump_of(**pump)
    assert read.displacement == pytest.approx(displacement, rel=1e-12, abs=0.0)
    assert read.kind == pump["kind"]
    assert read.held_at_demand == pump.get("held_at_demand", False)
    assert read.slip_coefficient is None


@pytest.mark.parametrize(
    ("pump", "steps", "words"),
    [
        ({}, ("pump",), ("nothing says what the pump displaces", "either displacement_mm3", "dimensions of one kind")),
        ({"kind": "vane"}, ("pump",), ("dimensions of a vane pump", "cam_ring_diameter_mm, eccentricity_mm")),
        ({**GEAR, "displacement_mm3": 17e3}, ("pump",), ("centre_distance_mm", "not both")),
        ({"module_mm": 4.5, "teeth": 12, "width_mm": 12.0}, ("pump", "tooth_height_mm"), ("missing beside module_mm",)),
        ({**GEROTOR, "vanes": 9}, ("pump", "vanes"), ("no dimension of a gerotor", "root_diameter_mm")),
        ({"displacement_mm3": 17e3, "vanes": 9}, ("pump", "kind"), ("no kind of pump", "gerotor, vane")),
        (
            {**GEROTOR, "root_diameter_mm": 61.0},
            ("pump", "tip_diameter_mm"),
            ("too small beside root_diameter_mm", "found 60", "more than root_diameter_mm, 61 mm"),
        ),
        (
            {**GEAR, "centre_distance_mm": 55.0},
            ("pump", "tip_diameter_mm"),
            ("too small beside centre_distance_mm", "more than centre_distance_mm, 55 mm"),
        ),
        (
            {**CRESCENT, "tip_diameter_mm": 63.2, "centre_distance_mm": 8.1, "teeth": 19, "ring_teeth": 23},
            ("pump", "tip_diameter_mm"),
            ("tips of 63.2 mm, axes 8.1 mm apart, and 19 and 23 teeth", "tips above 76.95 mm", "check tip diameter"),
        ),
        (
            {**CRESCENT, "ring_tip_diameter_mm": 90.0},
            ("pump", "ring_tip_diameter_mm"),
            ("tips of 90 mm, axes 7.5 mm apart, and 24 and 29 teeth", "tips below 87.00 mm", "centre distance"),
        ),
        ({**CRESCENT, "ring_teeth": 24}, ("pump",), ("above the pinion's",)),
        ({**GEROTOR, **NEW, "tip_clearance_limit_um": 90.0}, ("pump", "tip_clearance_limit_um"), ("at least 110 µm",)),
        ({**VANE, "tip_clearance_um": 30.0}, ("pump", "tip_clearance_um"), ("vanes lie against the ring",)),
        (
            {**GEROTOR, "shaft_diameter_mm": 50.0},
            ("pump", "shaft_diameter_mm"),
            ("end where it begins", "less than root_diameter_mm"),
        ),
        ({**GEAR, "measured": ["teeth", "tooth"]}, ("pump", "measured"), ("'tooth'",)),
    ],
)
def test_what_cannot_be_a_pump_is_named_with_its_key(
    pump: dict[str, Any], steps: tuple[str, ...], words: tuple[str, ...]
) -> None:
    faults = faults_of(**pump)
    assert list(faults) == [steps] or (steps[-1] == "measured" and list(faults) == [(*steps, 1)])
    for word in words:
        assert word in str(next(iter(faults.values())))


def test_all_that_is_wrong_with_a_pump_is_named_at_once() -> None:
    pump = {"kind": "crescent", "teeth": 24, "width_mm": 12.0, "vanes": 9, **NEW, "side_clearance_limit_um": 20.0}
    missing = ("tip_diameter_mm", "ring_tip_diameter_mm", "centre_distance_mm", "ring_teeth")
    named = {("pump", key) for key in (*missing, "vanes", "side_clearance_limit_um")}
    assert set(faults_of(**pump)) == named


def test_every_key_of_a_pump_says_what_it_is() -> None:
    assert all((field.description or "")[0].isupper() or name in {"kind", "held_at_demand"}
               for name, field in PumpTable.model_fields.items())  # fmt: skip


# --- slip


@pytest.mark.parametrize(
    ("pump", "faces", "tips"),
    [
        ({**GEAR, "root_diameter_mm": 33.0, "shaft_diameter_mm": 22.0, "tip_land_mm": 1.2, "sealing_tips": 4},
         [(0.033, 0.022), (0.033, 0.022)], (0.016, 0.0012, 4, 2)),
        ({**CRESCENT, **LANDS}, [(0.066, 0.048), (0.110, 0.094)], (0.012, 0.002, 3, 2)),
        ({**GEROTOR, "shaft_diameter_mm": 30.0, "ring_outer_diameter_mm": 80.0, "tip_land_mm": 1.1},
         [(0.050, 0.030), (0.080, 0.065)], (0.012, 0.0011, 1, 1)),
    ],
    ids=["gears", "crescent", "gerotor"],
)  # fmt: skip
def test_both_clearances_of_a_new_pump_give_its_slip(
    pump: dict[str, Any], faces: list[tuple[float, float]], tips: tuple[float, float, int, int]
) -> None:
    width, land, in_a_row, rims = tips
    read = pump_of(**pump, **NEW)
    slips = sum(equations.face_slip(35e-6, *ends) for ends in faces) * 5e5 / 6e-3
    slips += rims * equations.tip_slip(5e5, 110e-6, width, land, in_a_row, 6e-3, 800.0)
    assert read.slip(5e5, 6e-3) == pytest.approx(slips, rel=1e-12, abs=0.0)
    assert pump_of(**pump, side_clearance_um=35.0).slip_coefficient is None  # the tips slip too, by an unknown amount


def test_the_vanes_of_a_pump_leave_only_its_faces() -> None:
    read = pump_of(**VANE, rotor_diameter_mm=57.0, shaft_diameter_mm=35.0, side_clearance_um=40.0)
    slips = equations.slip_coefficient(equations.face_slip(40e-6, 0.057, 0.035), read.displacement)
    assert read.slip_coefficient == pytest.approx(slips, rel=1e-12, abs=0.0)
    measured = read.with_measured(PumpClearances(tip=50e-6))
    assert measured.slip_coefficient == read.slip_coefficient
    assert measured.left_out == (("tip", "the vanes of such a pump lie against their ring"),)


def test_a_measured_pump_slips_what_its_gaps_have_opened_by() -> None:
    stated = pump_of(**CRESCENT, **LANDS, **NEW, slip_coefficient=5e-8)
    worn = stated.with_measured(PumpClearances(85e-6, 160e-6))
    opened = equations.face_slip(85e-6, 0.066, 0.048) + equations.face_slip(85e-6, 0.110, 0.094)
    opened -= equations.face_slip(35e-6, 0.066, 0.048) + equations.face_slip(35e-6, 0.110, 0.094)
    more = opened * 5e5 / 6e-3
    more += 2 * equations.tip_slip(5e5, 160e-6, 0.012, 0.002, 3, 6e-3, 800.0)
    more -= 2 * equations.tip_slip(5e5, 110e-6, 0.012, 0.002, 3, 6e-3, 800.0)
    before = equations.slip_flow(stated.displacement, 5e-8, 5e5, 6e-3)
    assert stated.slip(5e5, 6e-3) == before
    assert worn.slip(5e5, 6e-3) == pytest.approx(before + more, rel=1e-12, abs=0.0)
    assert (worn.new, worn.measured, worn.counted) == (stated, PumpClearances(85e-6, 160e-6), worn.measured)
    as_new = stated.with_measured(PumpClearances(35e-6, 110e-6))
    assert as_new.slip(5e5, 6e-3) == pytest.approx(before, rel=1e-12, abs=0.0)
    assert stated.with_measured(PumpClearances()) is stated


def test_a_pump_of_which_only_the_gaps_are_known_slips_by_them_alone() -> None:
    by_gaps = pump_of(**CRESCENT, **LANDS, **NEW)
    worn = by_gaps.with_measured(PumpClearances(tip=160e-6))
    same = pump_of(**CRESCENT, **LANDS, **{**NEW, "tip_clearance_um": 160.0})
    assert worn.slip(5e5, 6e-3) == pytest.approx(same.slip(5e5, 6e-3), rel=1e-12, abs=0.0)
    assert worn.new == by_gaps
    measured = pump_of(**CRESCENT, **LANDS).with_measured(PumpClearances(35e-6, 160e-6))
    assert measured.slip(5e5, 6e-3) == pytest.approx(same.slip(5e5, 6e-3), rel=1e-12, abs=0.0)
    assert measured.as_new is None  # what it slipped when new nobody knows


@pytest.mark.parametrize(
    ("pump", "measured", "name", "words"),
    [
        ({"displacement_mm3": 17e3}, PumpClearances(side=5e-5), "side", "does not state the kind"),
        (GEROTOR, PumpClearances(side=5e-5), "side", "state shaft_diameter_mm, ring_outer_diameter_mm"),
        (CRESCENT, PumpClearances(tip=5e-5), "tip", "state tip_land_mm, sealing_tips"),
        ({**CRESCENT, **LANDS}, PumpClearances(side=5e-5), "side", "neither slip_coefficient nor both"),
        ({**CRESCENT, **LANDS, "slip_coefficient": 5e-8}, PumpClearances(side=5e-5), "side", "state side_clearance_um"),
    ],
)
def test_a_measured_clearance_that_the_file_cannot_turn_into_slip_says_what_lacks(
    pump: dict[str, Any], measured: PumpClearances, name: str, words: str
) -> None:
    read = pump_of(**pump)
    known = read.with_measured(measured)
    assert (known.slip_coefficient, known.measured, known.counted.any_known) == (read.slip_coefficient, measured, False)
    ((which, why),) = known.left_out
    assert which == name
    assert words in why


def test_an_uncertain_clearance_moves_the_slip() -> None:
    worn = pump_of(**CRESCENT, **LANDS, **NEW).with_measured(PumpClearances(85e-6, 160e-6))
    step = 1e-8
    moved = [
        (worn.new.with_measured(measured).slip(5e5, 6e-3) - worn.slip(5e5, 6e-3)) / step * 5e-6
        for measured in (PumpClearances(85e-6 + step, 160e-6), PumpClearances(85e-6, 160e-6 + step))
    ]
    relative = math.hypot(*moved) / worn.slip(5e5, 6e-3)
    assert worn.relative_uncertainty(5e-6, 5e5, 6e-3) == pytest.approx(relative, rel=2e-3, abs=0.0)
    assert worn.new.relative_uncertainty(5e-6, 5e5, 6e-3) == 0.0


def test_what_a_pump_is_known_from_is_that_of_its_least_sure_dimension() -> None:
    pump = {**GEROTOR, **NEW, "shaft_diameter_mm": 30.0, "side_clearance_limit_um": 50.0}
    measured = ["teeth", "width_mm", "tip_diameter_mm", "root_diameter_mm"]

    def known(**lists: list[str]) -> dict[str, Evidence | None]:
        entry = checked_controller(tables({**pump, "measured": measured, **lists})).entry
        assert entry is not None
        return {each.value: each.evidence for each in known_values(entry) if each.table == "pump"}

    assert known(representative=["tip_clearance_um"], published=["side_clearance_um"]) == {
        "displacement": Evidence.MEASURED,
        "gaps": Evidence.REPRESENTATIVE,
        "limits": Evidence.PUBLISHED,
        "volumetric_efficiency": Evidence.PUBLISHED,
    }
    assert known(published=["side_clearance_limit_um"]) == known()
    assert known(representative=["side_clearance_limit_um"])["limits"] == Evidence.REPRESENTATIVE
    with pytest.raises(CatalogueError, match="teeth in one list alone"):
        known(published=["teeth"])


def test_dimensions_of_other_kinds_are_known_by_their_keys() -> None:
    assert "vanes" in other_dimensions("gerotor")
    assert "vanes" not in other_dimensions("vane")
    assert "width_mm" not in {*other_dimensions(None), *other_dimensions("vane"), *other_dimensions("gerotor")}
