"""Repairs of the pump stand among those of components, and leave it as new."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller
from atleak.catalogue.entries import read_tables
from atleak.catalogue.repairs import find_repairs
from atleak.common.errors import CatalogueError, InputError


def unit_with(*repairs: dict[str, Any], component: str | None = None) -> Controller:
    """The minimal example with repairs of its pump, and with another name of its first component."""
    data = copy.deepcopy(read_tables("controllers", "minimal_example")[0])
    of_pump = {"component": "pump", "kind": "overhaul", "name": "overhaul", "source": "made up"}
    data["repairs"] = [{**of_pump, "id": f"repair_{number}", **each} for number, each in enumerate(repairs)]
    data["components"][0]["id"] = component or data["components"][0]["id"]
    data.pop("gaps", None)
    return checked_controller(data)


def test_repairs_of_the_pump_change_no_land_and_only_one_is_chosen() -> None:
    unit = unit_with({}, {"kind": "new_pump", "price": 310.0, "currency": "EUR", "hours": 2.0})
    assert [(repair.of_pump, repair.price) for repair in unit.repairs] == [(True, None), (True, 310.0)]
    assert not any(repair.changes(land.key) for repair in unit.repairs for land in unit.lands)
    with pytest.raises(InputError, match="repair_1 and repair_0 both repair the pump"):
        find_repairs(unit.repairs, ["repair_0", "repair_1"], unit.name)


@pytest.mark.parametrize(
    ("stated", "key"),
    [
        ({"kind": "sleeve"}, "kind"),
        ({"lands": [1]}, "lands"),
        ({"mounting_clearance_um": 20.0}, "mounting_clearance_um"),
        ({"nominal_diameter_mm": 12.0}, "nominal_diameter_mm"),
    ],
)
def test_what_only_a_land_can_have_is_refused_of_the_pump(stated: dict[str, Any], key: str) -> None:
    with pytest.raises(CatalogueError) as caught:
        unit_with(stated)
    assert caught.value.place.steps == ("repairs", 0, key)


def test_a_component_called_pump_goes_before_the_pump() -> None:
    unit = unit_with({"kind": "sleeve"}, component="pump")
    assert [repair.of_pump for repair in unit.repairs] == [False]
    with pytest.raises(CatalogueError, match="a repair of the pump alone"):
        unit_with({"kind": "new_pump"}, component="pump")
