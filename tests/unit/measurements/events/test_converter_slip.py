"""The slip of the converter: engine minus turbine speed while the car drives."""

from __future__ import annotations

import pytest

from atleak.measurements.events import converter_slip
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test


def log(head: str, row: str) -> RoadTest:
    rows = (row.format(t=i / 10, rpm=1500, slipping=1500 - (300 if i < 150 else 20), lock="On" if i >= 150 else "Off", kmh=0 if i < 50 else 40) for i in range(300))  # fmt: skip  # noqa: E501
    return read_road_test("\n".join([head, *rows]).encode())


def test_slip_while_driving_and_with_lock_up_commanded() -> None:
    slip = converter_slip(log("Time (s),RPM,Turbine RPM,TCC,Speed (km/h)", "{t},{rpm},{slipping},{lock},{kmh}"))
    assert slip is not None
    found = [each * 60 for each in (slip.low, slip.median, slip.high, slip.commanded_median)]
    assert found == pytest.approx([20, 20, 300, 20], rel=1e-9, abs=0.0)
    assert (slip.locked_seconds, slip.commanded_seconds) == pytest.approx((14.9, 14.9), rel=1e-9, abs=0.0)


def test_without_lock_up_in_the_log_nothing_is_said_of_its_command() -> None:
    slip = converter_slip(log("Time (s),RPM,Turbine RPM", "{t},{rpm},{slipping}"))
    assert slip is not None
    assert (slip.commanded_seconds, slip.commanded_median) == (None, None)


@pytest.mark.parametrize(
    ("head", "row"),
    [("Time (s),RPM", "{t},{rpm}"), ("Time (s),RPM,Turbine RPM,Speed (km/h)", "{t},{rpm},{slipping},0")],
)
def test_there_is_none_without_a_turbine_or_while_the_car_stands(head: str, row: str) -> None:
    assert converter_slip(log(head, row)) is None
