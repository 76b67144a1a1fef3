"""One worn unit with a road test, and one that nobody measured: what every report is tested on."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from atleak.controller import Controller, load_controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.errors import Place
from atleak.fluid import load_fluid
from atleak.limits import load_limits
from atleak.readings import Reading, Readings
from atleak.road_test import Channel, RoadTest, Segment

HOSTILE = (
    '=HYPERLINK("http://example.com","x")',
    "+1+1",
    "-2+3",
    "@SUM(A1)",
    "\t=1+1",
    "<b>bold</b>",
    '#panic("no")',
    "$x$ *bold* _it_ @ref <label> \\ ` // /* ~",
    "x" * 400,
    "שלום עולם مرحبا",
    "wrench 🔧 and family 👩‍👩‍👧",
    "Žluťoučký Łódź Straße Привет Ωμέγα",
    "=cmd|' /C calc'!A0",
)


def worn_readings(controller: Controller, file: str = "sheet.xlsx") -> Readings:
    """Two directions, two repeats of every land but the last; wear grows from land to land and starts again."""
    found = []
    for number, land in enumerate(controller.lands[:-1]):
        wear = (0.0, 0.08, 0.15, 0.6, 1.4)[number % 5]
        sleeve = land.nominal_sleeve_diameter + 2.0 * land.mounting_clearance * wear
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", sleeve)):
            for plane in land.planes:
                for direction in (0.0, 90.0):
                    for repeat in (1, 2):
                        measured = diameter + (0.4e-6 if repeat == 2 else -0.3e-6) + 1e-6 * (direction > 0)
                        place = Place(file=file, sheet="readings", row=len(found) + 2, column="D")
                        found.append(
                            Reading(land.component, part, plane, direction, repeat, measured, place)  # type: ignore[arg-type]
                        )
    return Readings(file, "ab" * 32, "readings", "mm", False, "tidy", tuple(found))


def road_test(rows: int = 6000, file: str = "drive.csv") -> RoadTest:
    """Acceleration through four gears, with a stretch in which the converter pressure is not usable."""
    time = np.arange(rows) * 0.1
    part = time / time[-1]
    gear = np.minimum(np.floor(part * 4) + 1, 4)
    speed = (900.0 + 2600.0 * ((part * 4) % 1.0)) / 60.0
    main = 480e3 + 500e3 * ((part * 4) % 1.0) + 20e3 * np.sin(time)
    converter = 0.45 * main
    temperature = 60.0 + 45.0 * part
    suspect = np.zeros(rows, bool)
    suspect[rows // 2 : rows // 2 + 20] = True

    def channel(name: str, values: np.ndarray, unit: str) -> Channel:
        doubt = suspect if name == "converter_pressure" else np.zeros(rows, bool)
        return Channel(name, time, values, doubt, column=name, unit=unit, sampling_hz=10.0)

    channels = {
        "engine_speed": channel("engine_speed", speed, "rpm"),
        "atf_temperature": channel("atf_temperature", temperature, "°C"),
        "main_pressure": channel("main_pressure", main, "kPa"),
        "converter_pressure": channel("converter_pressure", converter, "kPa"),
        "gear": channel("gear", gear, ""),
    }
    return RoadTest(
        file=file,
        sha256="cd" * 32,
        rows=rows,
        duration=float(time[-1]),
        time=time,
        channels=MappingProxyType(channels),
        segments=(Segment(0, rows, 0.0, float(time[-1])),),
    )


@pytest.fixture(scope="session")
def worn() -> Diagnosis:
    controller = load_controller("four_speed_2023")
    return diagnose(
        controller,
        load_fluid("hipol_atf_iid"),
        load_limits("project_default"),
        readings=worn_readings(controller),
        road_test=road_test(),
        mileage=106_315.0,
    )


@pytest.fixture(scope="session")
def unmeasured() -> Diagnosis:
    controller = load_controller("four_speed_2023")
    return diagnose(controller, load_fluid("hipol_atf_iid"), load_limits("project_default"))


@pytest.fixture(scope="session")
def hostile() -> tuple[str, ...]:
    """Names that somebody might type, or try."""
    return HOSTILE


@pytest.fixture(scope="session")
def calculator() -> type:
    """The referee that calculates a workbook's formulas."""
    path = Path(__file__).with_name("sheet_calculator.py")
    spec = importlib.util.spec_from_file_location("sheet_calculator", path)
    module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
    spec.loader.exec_module(module)  # type: ignore[union-attr]
    return module.SheetCalculator
