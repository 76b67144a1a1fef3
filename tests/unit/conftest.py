"""Shared by the tests of single rooms: catalogue files with a few words changed, and the sample job diagnosed."""

from __future__ import annotations

import importlib.util
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

import numpy as np
import pytest
from openpyxl.worksheet.merge import MergedCellRange

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.common.errors import Place
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PROFILES
from atleak.measurements.readings import Reading, Readings
from atleak.measurements.road_test import Channel, RoadTest, Segment
from atleak.readers.logs import read_road_test
from atleak.readers.sheets.measuring_sheet import read_readings

Edited = Callable[..., Path]


def first_of(values: Iterable[Any]) -> list[Any]:
    """The values of a parameter: the first one in every round, the others in the slow one."""
    first, *others = (each if isinstance(each, tuple) else (each,) for each in values)
    return [pytest.param(*first), *(pytest.param(*each, marks=pytest.mark.slow) for each in others)]


def by_turns(*values: Iterable[Any]) -> list[tuple[Any, ...]]:
    """The values of several parameters: all of each, those of the shorter ones by turns, not each with each."""
    lists = [[*each] for each in values]
    return [tuple(each[turn % len(each)] for each in lists) for turn in range(max(map(len, lists)))]


@pytest.fixture(scope="session", autouse=True)
def borders_as_written() -> Iterator[None]:
    """Let openpyxl load merged cells without making their borders anew: most of its time on a measuring sheet."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MergedCellRange, "format", lambda merged: None)
        yield


@pytest.fixture
def edited(tmp_path: Path) -> Edited:
    """Writes a shipped catalogue file as ``own.toml`` with each first ``old`` replaced by ``new``."""

    def write(kind: str, name: str, *changes: tuple[str, str]) -> Path:
        path = tmp_path / "own.toml"
        shutil.copyfile(catalogue_files(kind)[name], path)
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, f"{old!r} is not in {name}.toml"
            text = text.replace(old, new, 1)
        path.write_text(text, encoding="utf-8")
        return path

    return write


_PERMISSIBLE = re.compile(r"\[\[permissible_pressure\]\]\n(?:\w+ = [^\n]*\n)+")


@pytest.fixture
def permitting(edited: Edited) -> Callable[[str], Path]:
    """Writes the study's controller as ``own.toml`` with other permissible pressures in place of its own."""

    def write(tables: str) -> Path:
        path = edited("controllers", "four_speed_2023")
        bare, count = _PERMISSIBLE.subn("", path.read_text(encoding="utf-8"))
        assert count, "the study's controller permits no pressures"
        path.write_text(f"{bare}\n{tables}", encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def sample_diagnoses(
    four_speed: Controller, hipol: Fluid, limits: Limits, sample_readings: Path, sample_log: Path
) -> dict[str, Diagnosis]:
    """The sample job in both profiles, at 106 315 km."""
    readings, road_test = read_readings(sample_readings, four_speed), read_road_test(sample_log)
    return {
        name: diagnose(
            four_speed, hipol, limits, readings=readings, road_test=road_test, profile=profile, mileage_km=106_315.0
        )
        for name, profile in PROFILES.items()
    }


@pytest.fixture(params=["workshop", "paper"])
def sample(request: pytest.FixtureRequest, sample_diagnoses: dict[str, Diagnosis]) -> Diagnosis:
    """The sample job in each profile."""
    return sample_diagnoses[request.param]


@pytest.fixture(scope="session")
def readings_of() -> Callable[..., Readings]:
    """Readings in two directions of ``{(component, land): (spool, sleeve)}``, diameters in m; None where not read."""

    def build(controller: Controller, diameters: dict[tuple[str, int], tuple[float | None, float | None]]) -> Readings:
        found = [
            Reading(component, part, plane, direction, 1, diameter)
            for (component, land), pair in diameters.items()
            for part, diameter in zip(("spool", "sleeve"), pair, strict=True)
            for plane in controller.land(component, land).planes
            for direction in (0.0, 90.0)
            if diameter is not None
        ]
        return Readings("own.csv", "0" * 64, None, "mm", False, "tidy", tuple(found))

    return build


@pytest.fixture(scope="session")
def log_of() -> Callable[..., RoadTest]:
    """A road test of plain channels on one time base; a channel's NaN are suspect samples."""

    def build(time: Any, **channels: Any) -> RoadTest:
        base = np.asarray(time, dtype=float)
        found = {}
        for quantity, values in channels.items():
            array = np.broadcast_to(np.asarray(values, dtype=float), base.shape).copy()
            found[quantity] = Channel(quantity, base, array, np.isnan(array))
        return RoadTest("own.csv", "0" * 64, len(base), float(base[-1] - base[0]), base, MappingProxyType(found))

    return build


@pytest.fixture(scope="session")
def benchmark_of(root: Path) -> Callable[[str], ModuleType]:
    """Imports a benchmark by the name of its file."""
    folder = root / "benchmarks"

    def load(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(f"{name}_benchmark", folder / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        with pytest.MonkeyPatch.context() as patch:
            patch.syspath_prepend(str(folder))  # a benchmark imports what stands beside it
            patch.setitem(sys.modules, spec.name, module)  # dataclasses look their module up
            spec.loader.exec_module(module)
        return module

    return load


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
        mileage_km=106_315.0,
    )


@pytest.fixture(scope="session")
def unmeasured() -> Diagnosis:
    controller = load_controller("four_speed_2023")
    return diagnose(controller, load_fluid("hipol_atf_iid"), load_limits("project_default"))


@pytest.fixture(scope="session")
def hostile() -> tuple[str, ...]:
    """Names that somebody might type, or try."""
    return HOSTILE


def with_clearances(
    controller: Controller, build: Callable[..., Readings], clearances: dict[tuple[str, int], float]
) -> Readings:
    """Readings of a unit that is as new but for the radial clearances [m] given."""
    radial = {land.key: clearances.get(land.key, land.new_clearance) for land in controller.lands}
    diameters = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * radial[land.key]) for land in controller.lands
    }
    return build(controller, diameters)


@pytest.fixture(scope="session")
def worn_clutch(
    three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> Diagnosis:
    """The small valve body with circuits, both lands of the valve of clutch C1 at 35 µm."""
    clearances = {("2", 1): 35e-6, ("2", 2): 35e-6}
    readings = with_clearances(three_circuits, readings_of, clearances)
    return diagnose(three_circuits, hipol, limits, readings=readings)


def at_wear(controller: Controller, **wear: float) -> dict[tuple[str, int], tuple[float, float]]:
    """Diameters of the first land of some components at a given wear."""
    diameters = {}
    for component, fraction in wear.items():
        land = controller.land(component, 1)
        clearance = land.mounting_clearance * (1.0 + fraction)
        diameters[component, 1] = (land.nominal_diameter, land.nominal_diameter + 2.0 * clearance)
    return diameters


def codes(diagnosis: Diagnosis) -> set[str]:
    return {message.code for message in diagnosis.messages}
