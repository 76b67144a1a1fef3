"""Which cells there are, and in which order they are measured."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller import Controller
from atleak.measurements.measuring_plan import PLAN_PARTS, Order, Plan, PlanCell

PAIRS = ["pressure_regulator", "tcc_regulator", "solenoid_modulator", "accumulator"]


def test_every_land_has_two_directions_and_two_repeats_of_both_parts(minimal: Controller) -> None:
    cells = Plan().cells(minimal)
    assert len(cells) == len(set(cells)) == 2 * 2 * 2 * len(minimal.lands)
    assert {(cell.direction, cell.repeat) for cell in cells} == {(0.0, 1), (0.0, 2), (90.0, 1), (90.0, 2)}


def test_all_spools_come_before_all_bores(minimal: Controller) -> None:
    parts = [cell.part for cell in Plan().cells(minimal)]
    assert parts == sorted(parts, key=PLAN_PARTS.index)


@pytest.mark.parametrize(
    ("order", "runs"),
    [
        (Order.COMPONENTS, [(name, part) for name in PAIRS for part in PLAN_PARTS]),
        (Order.PARTS, [(name, part) for part in PLAN_PARTS for name in PAIRS]),
    ],
)
def test_one_part_of_a_component_is_measured_in_one_go(minimal: Controller, order: Order, runs: list) -> None:
    assert list(dict.fromkeys((cell.component, cell.part) for cell in Plan(order).cells(minimal))) == runs


def test_land_by_land_the_bore_follows_its_spool(minimal: Controller) -> None:
    cells = Plan(Order.LANDS).cells(minimal)
    assert [(cell.plane, cell.part) for cell in cells[:16:4]] == [
        ("1", "spool"), ("1", "sleeve"), ("2", "spool"), ("2", "sleeve"),
    ]  # fmt: skip


def test_the_cells_of_one_part_stand_as_on_the_printed_sheet(minimal: Controller) -> None:
    first = [(cell.plane, cell.direction, cell.repeat) for cell in Plan().cells(minimal)[:5]]
    assert first == [("1", 0.0, 1), ("1", 0.0, 2), ("1", 90.0, 1), ("1", 90.0, 2), ("2", 0.0, 1)]


def test_only_the_lands_that_are_wanted_have_cells(minimal: Controller) -> None:
    plan = Plan(directions=3, repeats=1, lands=(("accumulator", 1),))
    assert [(cell.component, cell.part, cell.direction) for cell in plan.cells(minimal)] == [
        ("accumulator", part, angle) for part in PLAN_PARTS for angle in (0.0, 60.0, 120.0)
    ]


def test_what_is_held_beyond_the_plan_stays(minimal: Controller) -> None:
    third, elsewhere = PlanCell("accumulator", "spool", "1", 45.0, 3), PlanCell("tcc_regulator", "spool", "1", None, 1)
    plan = Plan(lands=(("accumulator", 1),))
    cells = plan.cells(minimal, [third, elsewhere, PlanCell("nothing", "spool", "1", 0.0, 1)])
    assert third in cells
    assert elsewhere not in cells
    assert cells.index(third) == 2  # between 0° and 90°


def test_a_quick_pass_takes_the_lands_as_listed_once_each_in_the_middle_plane(four_speed: Controller) -> None:
    """The sleeve follows its spool at once: one land is read before the next."""
    several = [land for land in four_speed.lands if len(land.planes) > 2]
    lands = [*several[:1], *(land for land in four_speed.lands if len(land.planes) == 1)][:3][::-1]
    cells = Plan.quick(land.key for land in lands).cells(four_speed)
    assert [(cell.component, cell.part, cell.plane) for cell in cells] == [
        (land.component, part, land.planes[(len(land.planes) - 1) // 2]) for land in lands for part in PLAN_PARTS
    ]
    assert {(cell.direction, cell.repeat) for cell in cells} == {(0.0, 1)}
