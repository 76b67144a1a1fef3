"""Shared by the tests of single rooms: catalogue files with a few words changed, and the sample job diagnosed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak import catalogue
from atleak.controller import Controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.fluid import Fluid
from atleak.intake.readings import read_readings
from atleak.intake.road_test import read_road_test
from atleak.limits import Limits
from atleak.profile import PROFILES

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
