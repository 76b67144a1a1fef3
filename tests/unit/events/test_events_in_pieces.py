"""The events of a log that comes in pieces are those of the whole, wherever it is cut."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.events import events
from atleak.events.in_pieces import events_in_pieces
from atleak.large_log import LargeLog
from tests.unit.drives import ALL, drive

GEARS = (1, 2, 3, 4)
CHANNELS = (
    ALL,
    ("engine_speed", "gear"),
    ("engine_speed",),
    ("engine_speed", "vehicle_speed"),
    ("engine_speed", "turbine_speed", "output_speed"),
    ("engine_speed", "output_speed", "lock_up", "gear", "atf_temperature"),
    ("main_pressure", "gear"),
)


def same(seed: int, channels: tuple[str, ...], piece: int, seconds: float) -> Counter[str]:
    road_test = drive(seed, seconds, channels)
    expected = events(road_test, gears=GEARS)
    assert events_in_pieces(LargeLog.of(road_test, piece), gears=GEARS) == expected
    return Counter(event.kind for event in expected)


@pytest.mark.parametrize("channels", CHANNELS, ids=" ".join)
def test_every_kind_of_event_is_found_as_in_the_whole(channels: tuple[str, ...]) -> None:
    kinds = sum((same(seed, channels, 100 + 37 * seed, 90.0) for seed in range(8)), Counter())
    assert kinds["minimum_acceleration"] or "engine_speed" not in channels or "turbine_speed" in channels
    assert kinds["gear_shift"] or channels[1:2] != ("gear",)


def test_all_kinds_of_events_are_among_them() -> None:
    kinds = sum((same(seed, ALL, 211, 200.0) for seed in range(3)), Counter())
    assert len(kinds) == 7, kinds


@settings(max_examples=12)
@given(st.integers(0, 10_000), st.sampled_from(CHANNELS), st.integers(1, 400))
def test_a_log_may_be_cut_anywhere(seed: int, channels: tuple[str, ...], piece: int) -> None:
    same(seed, channels, piece, 20.0)


@pytest.mark.slow
@settings(max_examples=120)
@given(st.integers(0, 1_000_000), st.sampled_from(CHANNELS), st.integers(1, 900), st.floats(2.0, 80.0))
def test_many_logs_may_be_cut_anywhere(seed: int, channels: tuple[str, ...], piece: int, seconds: float) -> None:
    same(seed, channels, piece, seconds)
