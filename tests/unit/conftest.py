"""Shared by the tests of single rooms: catalogue files with a few words changed, and the sample job diagnosed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from atleak import catalogue
from atleak.controller import Controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.fluid import Fluid
from atleak.intake.readings import read_readings
from atleak.intake.road_test import read_road_test
from atleak.limits import Limits
from atleak.profile import PROFILES
from atleak.readings import Reading, Readings
from atleak.road_test import Channel, RoadTest

Edited = Callable[..., Path]


@pytest.fixture
def edited(tmp_path: Path) -> Edited:
    """Writes a shipped catalogue file as ``own.toml`` with each first ``old`` replaced by ``new``."""

    def write(kind: str, name: str, *changes: tuple[str, str]) -> Path:
        path = tmp_path / "own.toml"
        shutil.copyfile(catalogue.catalogue_files(kind)[name], path)
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, f"{old!r} is not in {name}.toml"
            text = text.replace(old, new, 1)
        path.write_text(text, encoding="utf-8")
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
            four_speed, hipol, limits, readings=readings, road_test=road_test, profile=profile, mileage=106_315.0
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
