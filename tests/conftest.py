"""What every kind of test shares: the catalogue's objects and the sample job."""

from __future__ import annotations

from pathlib import Path

import pytest

from atleak.controller import Controller, load_controller
from atleak.fluid import Fluid, load_fluid
from atleak.limits import Limits, load_limits

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def root() -> Path:
    """The root of the checkout."""
    return ROOT


@pytest.fixture(scope="session")
def sample_readings() -> Path:
    return ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx"


@pytest.fixture(scope="session")
def sample_log() -> Path:
    return ROOT / "sample_data" / "minimum_acceleration_test.csv"


@pytest.fixture(scope="session")
def four_speed() -> Controller:
    return load_controller("four_speed_2023")


@pytest.fixture(scope="session")
def minimal() -> Controller:
    return load_controller("minimal_example")


@pytest.fixture(scope="session")
def hipol() -> Fluid:
    return load_fluid("hipol_atf_iid")


@pytest.fixture(scope="session")
def limits() -> Limits:
    return load_limits("project_default")
