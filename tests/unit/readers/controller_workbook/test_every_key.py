"""Everything that a controller's file can say goes through a workbook and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import UnionType
from typing import Any, Union, get_args, get_origin

import pytest
from pydantic import BaseModel

from atleak.catalogue.controller_file import checked_controller, written_toml
from atleak.catalogue.controller_tables import ControllerFile
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.workbook.cells import Units
from atleak.catalogue.workbook.sheets import SHEETS
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.report.sheets.controller_workbook import write_controller_workbook
from tests.unit.conftest import by_turns

Tables = Callable[[str], dict[str, Any]]

# keys that several columns or rows make up together, or that another key says as well
TOGETHER = {
    ("circuits", "gears"),  # the apply chart
    ("circuits", "set_kpa"),  # the sheet Set pressures
    ("line", "set_kpa"),
    ("components", "lands", "published"),  # the columns that say how a value is known
    ("components", "lands", "measured"),
    ("components", "lands", "representative"),
    ("representative_values",),  # the head's fields that say so of all lands
    ("defaults", "published"),
    ("defaults", "measured"),
    ("pump", "representative"),
    ("pump", "measured"),
    ("pump", "published"),
    ("permissible_pressure", "gear"),  # gears with one gear
    ("repairs", "component"),  # components with one
}


def _keys(model: type[BaseModel], at: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    for name, field in model.model_fields.items():
        key = (*at, field.alias or name)
        inner = _model(field.annotation)
        if inner is None:
            yield key
        else:
            yield from _keys(inner, key)


def _model(annotation: Any) -> type[BaseModel] | None:
    """The model of the tables under a key: alone, in a list, or by name."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if get_origin(annotation) in (list, dict, Union, UnionType):
        return next((model for each in get_args(annotation) if (model := _model(each))), None)
    return None


def test_every_key_of_a_file_has_its_column() -> None:
    declared = set()
    for sheet in SHEETS:
        under = (*sheet.at, *([sheet.under] if getattr(sheet, "under", "") else []))
        declared |= {(*map(str, under), *column.keys) for column in sheet.columns if column.keys}
    of_the_file = set(_keys(ControllerFile))
    assert of_the_file - declared == TOGETHER
    assert declared <= of_the_file


MM, INCH = Units(), Units("inch", "diametral", "psi")
QUICK = {("three_circuits", MM), ("four_speed_2023", INCH)}


@pytest.mark.parametrize(
    ("name", "units"),
    [
        pytest.param(name, units, marks=() if (name, units) in QUICK else pytest.mark.slow, id=f"{name}-{units.length}")
        for name, units in by_turns(("three_circuits", *shipped_files("controllers")), (MM, INCH))
    ],
)
def test_a_valve_body_is_the_same_after_a_workbook(tables: Tables, name: str, units: Units) -> None:
    data = tables(name)
    controller = checked_controller(data)
    workbook = write_controller_workbook(data, units)
    described = read_controller_workbook(workbook, name="unit.xlsx")
    assert replace(described.controller, origin=controller.origin) == controller
    assert described.units == units
    assert described.notes == ()
    assert written_toml(described.data) == written_toml(read_controller_workbook(workbook, name="again.xlsx").data)


def test_what_no_shipped_file_says_is_kept_too(tables: Tables) -> None:
    data = tables("three_circuits")
    data["components"][0] |= {"bore": "sleeved"}
    data["components"][0]["lands"][0] |= {
        "planes": ["1", "1b"],
        "position_mm": 3.175,
        "seal": "teflon_ring",
        "learned_from_units": 12,
        "mounting_clearance_um": 13.35,
        "mounting_tolerance_um": 2.6180339887,
        "measured": ["contact_length_mm"],
        "published": ["nominal_diameter_mm"],
    }
    data["consumers"] += [
        {"id": "bleed", "flow_dm3_min": 0.7, "at_kpa": 437.5, "source": "made up", "evidence": "measured"},
        {"id": "pump_of_its_own", "flow_dm3_min": 0.3, "law": "constant", "source": "made up"},
    ]
    component = data["components"][0]["id"]
    data["repairs"] = [
        {
            "id": "oversize",
            "component": component,
            "lands": [data["components"][0]["lands"][0]["land"]],
            "kind": "oversize_valve",
            "name": "oversize valve",
            "part_number": "00012",
            "price": 39.9,
            "currency": "EUR",
            "hours": 1.5,
            "tool": "reamer",
            "nominal_diameter_mm": 15.367,
            "mounting_clearance_um": [6.4, 20.0],
            "source": "made up for this test",
            "evidence": "representative",
        },
        {
            "id": "kit",
            "components": [each["id"] for each in data["components"][:2]],
            "kind": "other",
            "name": "kit",
            "source": "made up",
        },
        {"id": "body", "components": "all", "kind": "other", "name": "remanufactured body", "source": "made up"},
    ]
    data["repairs"].append(
        {"id": "pump", "component": "pump", "kind": "overhaul", "name": "pump overhaul", "source": "made up"}
    )
    data["pump"] |= {
        "kind": "external_gear",
        "side_clearance_um": 35.0,
        "side_clearance_limit_um": 99.06,
        "tip_clearance_limit_um": 300.0,
        "measured": ["volumetric_efficiency"],
        "published": ["kind", "side_clearance_um", "side_clearance_limit_um"],
        "representative": ["displacement_mm3", "tip_clearance_limit_um", "slip_coefficient"],
    }
    data["permissible_pressure"].append(
        {"ranges": ["P", "N"], "state": "fast_idle", "high_kpa": 700.0, "source": "made up", "evidence": "published"}
    )
    controller = checked_controller(data)
    for units in (Units(), Units("inch", "diametral", "bar")):
        described = read_controller_workbook(write_controller_workbook(data, units), name="unit.xlsx")
        assert replace(described.controller, origin=controller.origin) == controller
        assert described.data["repairs"] == data["repairs"]
        assert described.data["pump"] == data["pump"]
