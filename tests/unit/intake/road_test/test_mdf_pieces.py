"""An MDF file that is read in ranges is understood, to the last bit, as one that is read whole."""

from __future__ import annotations

import gzip
import io
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from atleak.intake.road_test.outcome import Understood
from atleak.intake.road_test.pieces import mdf_ranges, read_large_log
from tests.unit.drives import drive
from tests.unit.intake.road_test.test_pieces import assert_same, cut, read_both, room_asked_and_taken

asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
CHANNELS = {
    "engine_speed": ("Engine Speed", "rpm", 60.0), "vehicle_speed": ("Vehicle Speed", "km/h", 3.6),
    "main_pressure": ("Line Pressure", "kPa", 1e-3), "atf_temperature": ("ATF Temperature", "°C", 1.0),
    "gear": ("Gear", "", 1.0),
}  # fmt: skip


@pytest.fixture(autouse=True)
def small_pieces() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        cut(patch, 700, 23)
        patch.setattr(mdf_ranges, "PIECE", 23)
        patch.setattr(mdf_ranges, "RANGE", 41)
        yield


def mdf(groups: list[list[Any]]) -> bytes:
    with asammdf.MDF(version="4.10") as file:
        for signals in groups:
            file.append(signals)
        stream = io.BytesIO()
        file.save(stream, compression=2)
        return stream.getvalue()


def messy_mdf(seed: int, seconds: float = 20.0) -> bytes:
    """Channels in groups of their own rates, some with the same clock, with stray values and clocks that begin anew."""
    generator = np.random.default_rng(seed)
    test = drive(seed, seconds, tuple(CHANNELS), breaks=bool(generator.random() < 0.4))
    groups: dict[int, list[Any]] = {}
    for name, (label, unit, factor) in CHANNELS.items():
        if generator.random() < 0.15:
            continue
        values, time = np.asarray(test.values(name)) * factor, test.time.copy()
        if generator.random() < 0.3:
            values[generator.integers(0, len(values), 3)] = generator.choice([65535.0, np.nan, 9999.0])
        group = int(generator.integers(0, 3))
        if group == 2 and generator.random() < 0.5:  # the clock begins anew
            time[len(time) // 2 :] -= time[-1] * 0.4
        if generator.random() < 0.5 and name != "gear":
            values = values.astype(np.float32)
        each = (1, 3, 1)[group]
        groups.setdefault(group, []).append(asammdf.Signal(values[::each], time[::each], name=label, unit=unit))
    return mdf([*groups.values()] or [[asammdf.Signal(test.time, test.time, name="Load", unit="%")]])


def test_files_with_all_that_goes_wrong_are_understood_as_the_whole() -> None:
    codes = sum((assert_same(*read_both(messy_mdf(seed))) for seed in range(8)), Counter())
    assert {"suspect_samples", "clock_restarted"} <= {*codes}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8, 60))
def test_many_files_are_understood_as_the_whole(seed: int) -> None:
    assert_same(*read_both(messy_mdf(seed, 45.0)))


TIME = np.arange(500) / 10
SPEED = asammdf.Signal(900.0 + np.arange(500), TIME, name="Engine Speed", unit="rpm")


def test_a_file_without_known_channels_has_the_clock_of_its_longest_group() -> None:
    others = [asammdf.Signal(TIME[::2], TIME[::2], name="Load", unit="%")]
    whole, pieces = read_both(mdf([others, [asammdf.Signal(TIME, TIME, name="Throttle", unit="%")]]))
    assert isinstance(pieces, Understood)
    assert pieces.rows == 500
    assert_same(whole, pieces)


def test_choices_count_as_for_the_whole() -> None:
    load = asammdf.Signal(300.0 + np.arange(500.0), TIME, name="Sensor 7")
    choices = {"mapping": {"main_pressure": "Sensor 7"}, "units": {"main_pressure": "psi"}}
    whole, pieces = read_both(mdf([[SPEED, load]]), **choices)
    assert isinstance(pieces, Understood)
    assert pieces.road_test is not None
    assert "main_pressure" in pieces.road_test.channels
    assert_same(whole, pieces)


def marked(values: np.ndarray, invalid: slice, label: str, unit: str, time: np.ndarray = TIME) -> Any:
    bits = np.zeros(len(values), bool)
    bits[invalid] = True
    return asammdf.Signal(values, time, name=label, unit=unit, invalidation_bits=bits)


@pytest.mark.parametrize("invalid", [slice(100, 300), slice(0, 60), slice(0, 0), slice(410, 500, 3)])
def test_samples_that_are_marked_as_invalid_are_no_values(invalid: slice) -> None:
    oil = np.full(500, 80.0)
    oil[invalid] = 20.0
    load = asammdf.Signal(np.where(np.arange(500) < 250, 100.0, 400.0), TIME, name="Line Pressure", unit="kPa")
    whole, pieces = read_both(mdf([[SPEED, marked(oil, invalid, "ATF Temperature", "°C"), load]]))
    assert isinstance(whole, Understood)
    assert whole.road_test is not None
    assert np.nanmin(whole.road_test.values("atf_temperature")) == pytest.approx(80.0, rel=1e-12, abs=0.0)
    assert_same(whole, pieces)


def test_the_channel_of_the_clock_may_have_invalid_samples_too() -> None:
    oil = asammdf.Signal(np.linspace(60.0, 80.0, 500), TIME, name="ATF Temperature", unit="°C")
    speed = marked(900.0 + np.arange(500), slice(30, 400, 2), "Engine Speed", "rpm")
    assert_same(*read_both(mdf([[speed, oil]])))


def test_as_much_room_is_asked_for_as_is_taken() -> None:
    oil = marked(np.full(500, 80.0), slice(100, 300), "ATF Temperature", "°C")
    rare = [asammdf.Signal(TIME[::50], TIME[::50], name="Vehicle Speed", unit="km/h")]
    asked, taken = room_asked_and_taken(mdf([[SPEED, oil], rare]))
    assert taken <= asked <= 2.5 * taken


def test_a_channel_without_a_valid_sample_is_refused_with_what_to_do() -> None:
    _, pieces = read_both(mdf([[SPEED, marked(np.zeros(500), slice(None), "ATF Temperature", "°C")]]))
    assert isinstance(pieces, str)
    assert "a channel without a valid sample is not read in pieces" in pieces


def test_a_packed_file_is_read_in_pieces_too(tmp_path: Path) -> None:
    path = tmp_path / "log.gz"
    path.write_bytes(gzip.compress(mdf([[SPEED]])))
    log = read_large_log(path)
    assert log.head.rows == len(log) == 500
    log.close()


def test_a_recording_of_a_bus_is_refused_with_what_to_do() -> None:
    frames = np.zeros(30, dtype=[("CAN_DataFrame.ID", "<u4"), ("CAN_DataFrame.DataBytes", "u1", (8,))])
    signal = asammdf.Signal(frames, np.arange(30) * 0.1, name="CAN_DataFrame")
    _, pieces = read_both(mdf([[signal], [SPEED]]))
    assert isinstance(pieces, str)
    assert "a recording of a CAN bus is not read in pieces" in pieces
    assert "decoded (physical) channels" in pieces


def test_a_damaged_file_is_refused_in_the_same_words() -> None:
    data = mdf([[SPEED]])
    assert_same(*read_both(data[:64] + bytes(200)))
    whole, pieces = read_both(data[: len(data) // 2])
    assert isinstance(whole, str)
    assert isinstance(pieces, str)
    assert "this MDF file is damaged" in pieces
