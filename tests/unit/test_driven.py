"""A unit with a log that comes in pieces: its record is that with the whole log."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis import Diagnosis, diagnose
from atleak.intake.readings import read_readings
from atleak.intake.road_test import read_road_test
from atleak.large_log import LargeLog
from atleak.road_test import RoadTest
from atleak.views.diagnosis_record import diagnosis_record
from tests.unit.drives import ALL, drive

_RESTS_ON_DRAWS = 1e-9  # intervals: the instants' conditions differ by rounding


def leaves(record: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(record, dict | list):
        for key, each in record.items() if isinstance(record, dict) else enumerate(record):
            yield from leaves(each, f"{place}/{key}")
    else:
        yield place, record


@pytest.fixture(params=["sample", "made up", "without pressure"])
def road_test(request: pytest.FixtureRequest, sample_log: Path) -> RoadTest:
    if request.param == "sample":
        return read_road_test(sample_log)
    return drive(5, 60.0, ALL if request.param == "made up" else ("engine_speed", "gear", "atf_temperature"))


def test_the_record_of_a_unit_is_the_same(
    four_speed: Controller, hipol: Fluid, limits: Limits, sample_readings: Path, road_test: RoadTest
) -> None:
    readings = read_readings(sample_readings, four_speed)
    whole, pieces = (
        diagnose(four_speed, hipol, limits, readings=readings, road_test=each)
        for each in (road_test, LargeLog.of(road_test, 333))
    )
    told, expected = (dict(leaves(diagnosis_record(each))) for each in (pieces, whole))
    assert told.keys() == expected.keys()
    for place, value in expected.items():
        if isinstance(value, float):
            close = _RESTS_ON_DRAWS if "_low" in place or "_high" in place else 1e-12
            assert told[place] == pytest.approx(value, rel=close, abs=1e-12), place
        else:
            assert told[place] == value, place
    assert_no_samples(pieces)


def assert_no_samples(diagnosis: Diagnosis) -> None:
    """Nothing of the result holds the samples."""
    log, road = diagnosis.log, diagnosis.road
    assert log is not None
    assert log.road_test.in_pieces
    assert len(log.road_test.time) == 0
    assert all(len(channel.values) <= 1 for channel in log.road_test.channels.values())
    assert road is None or len(road.leakage) == len(road.time) == 0
