"""What every kind of test shares: the catalogue's objects and the sample job."""

from __future__ import annotations

import os
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import settings

from atleak.controller import HOT_IDLE, Controller, OperatingPoint, load_controller
from atleak.fluid import Fluid, load_fluid
from atleak.limits import Limits, load_limits

ROOT = Path(__file__).resolve().parents[1]

# No deadline: how long an example takes says more about the machine than about the code.
settings.register_profile("atleak", deadline=None)
settings.load_profile("atleak")

# A machine without a browser or an office program skips the tests that need one. Where everything is installed, as in
# continuous integration, a skip is a failure.
NOTHING_MAY_SKIP = bool(os.environ.get("ATLEAK_NOTHING_MAY_SKIP"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if NOTHING_MAY_SKIP and report.skipped:
        report.outcome = "failed"
        report.longrepr = f"skipped where nothing may skip: {report.longrepr}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    if NOTHING_MAY_SKIP and report.skipped:
        report.outcome = "failed"
        report.longrepr = f"skipped where nothing may skip: {report.longrepr}"
    return report


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
def hot_idle(four_speed: Controller) -> OperatingPoint:
    return next(point for point in four_speed.operating_points if point.name == HOT_IDLE)


@pytest.fixture(scope="session")
def minimal() -> Controller:
    return load_controller("minimal_example")


@pytest.fixture(scope="session")
def hipol() -> Fluid:
    return load_fluid("hipol_atf_iid")


@pytest.fixture(scope="session")
def limits() -> Limits:
    return load_limits("project_default")
