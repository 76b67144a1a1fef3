"""A key is described once: its unit by its name, what is usual and what becomes of it beside its type."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from pydantic import BaseModel

from atleak.catalogue.controller_tables import ControllerFile, OperatingPointTable
from atleak.catalogue.fluid import FluidFile
from atleak.catalogue.instruments import InstrumentFile
from atleak.catalogue.keys import key, key_of, made, unit_of, usual_values
from atleak.catalogue.limits import LimitsFile
from atleak.common.file_faults import model_in


class Table(BaseModel):
    name: str = key("Name")
    p_g_kpa: float = key("Pressure", becomes="pressure")
    engine_rpm: float = key("Speed")
    flow_dm3_min: float | None = key("Flow", default=None)
    clearance_um: float | list[float] = key("Clearance")
    evidence: str = "measured"


@dataclass(frozen=True)
class Made:
    name: str
    pressure: float
    engine: float
    flow: float | None
    clearance: float | tuple[float, ...]
    of: str


def test_an_object_takes_the_values_of_its_table_in_si_units() -> None:
    table = Table(name="idle", p_g_kpa=420.0, engine_rpm=660.0, clearance_um=[6.4, 20.0])
    assert made(Made, table, of="a test") == Made("idle", 420e3, 11.0, None, (6.4 * 1e-6, 20.0 * 1e-6), "a test")
    assert made(Made, table, of="", flow=2.0, clearance=1.0).clearance == 1.0  # as given, in SI already


@pytest.mark.parametrize(
    ("name", "short", "label"),
    [
        ("kinematic_viscosity_mm2_s", "kinematic_viscosity", "mm²/s"),
        ("displacement_mm3", "displacement", "mm³"),
        ("nominal_diameter_mm", "nominal_diameter", "mm"),
        ("density_slope_g_cm3_k", "density_slope", "g/(cm³·K)"),
        ("density_g_cm3", "density", "g/cm³"),
        ("expansion_per_k", "expansion", "1/K"),
        ("pour_point_c", "pour_point", "°C"),
        ("teeth", "teeth", ""),
    ],
)
def test_a_key_ends_in_its_unit(name: str, short: str, label: str) -> None:
    found, unit = unit_of(name)
    assert (found, unit.label) == (short, label)


def described(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Each key that says what is usual of it: its unit by its name, and the one in which the usual range stands."""
    for name, field in model.model_fields.items():
        mine, inner = key_of(field), model_in(field.annotation)
        if mine is not None and mine.usual is not None:
            yield mine.unit or unit_of(name)[1].label, mine.usual.unit
        if inner is not None:
            yield from described(inner)


@pytest.mark.parametrize("model", [ControllerFile, LimitsFile, InstrumentFile, FluidFile])
def test_what_is_usual_stands_in_the_unit_of_its_key(model: type[BaseModel]) -> None:
    units = list(described(model))
    assert units
    assert [pair for pair in units if pair[0] != pair[1]] == []


def test_what_is_usual_is_found_through_lists_and_names_and_levels() -> None:
    of_controllers, of_limits = usual_values(ControllerFile), usual_values(LimitsFile)
    assert ("components", "*", "lands", "*", "mounting_clearance_um") in of_controllers
    assert ("materials", "*", "expansion_per_k") in of_controllers
    assert {("wear_percent", "*"), ("wear_percent", "*", "percent")} <= of_limits.keys()
    assert ("reserve", "amber") in of_limits


def test_a_key_that_may_be_left_out_is_not_required() -> None:
    required = {name for name, field in OperatingPointTable.model_fields.items() if field.is_required()}
    assert required == {"name", "label", "temperature_c", "engine_rpm", "gear", "p_g_kpa", "p_k_kpa", "source"}
