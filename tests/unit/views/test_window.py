"""Events and values of a part of a road test, as people read them."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.diagnosis import Diagnosis
from atleak.events import Event
from atleak.views.window import event_label, event_rows, window_rows


def test_rows_hold_least_mean_and_largest_of_good_samples(worn: Diagnosis) -> None:
    road = worn.road
    rows = {row["what"]: row for row in window_rows(road.road_test, road, {"engine_speed": ("rpm", lambda v: v * 60)})}
    speed = road.road_test.values("engine_speed") * 60.0
    assert rows["engine speed"]["unit"] == "rpm"
    assert rows["engine speed"]["mean"] == pytest.approx(speed.mean(), rel=1e-9, abs=0.0)
    assert rows["engine speed"]["largest"] == pytest.approx(speed.max(), rel=1e-9, abs=0.0)
    assert rows["converter pressure"]["samples"] == len(speed) - 20  # the suspect stretch is left out
    assert rows["leakage"]["largest"] == pytest.approx(road.max_leakage.leakage * 6e4, rel=1e-9, abs=0.0)
    assert rows["share"]["largest"] == pytest.approx(np.nanmax(road.share) * 100.0, rel=1e-9, abs=0.0)


def test_without_an_engine_only_the_channels_are_told(worn: Diagnosis) -> None:
    rows = window_rows(worn.road.road_test, None, {})
    assert "leakage" not in {row["what"] for row in rows}


def test_a_channel_without_a_good_sample_has_no_row(worn: Diagnosis) -> None:
    part = worn.road.road_test.window(300.0, 301.5)  # inside the suspect stretch of the converter pressure
    assert "converter pressure" not in {row["what"] for row in window_rows(part, None, {})}


def test_events_are_told_in_words() -> None:
    shift = Event("gear_shift", 0.89, 1.4, 1, 2)
    idle = Event("hot_idle", 3.0, 9.0, note="warm")
    assert event_label(shift) == "shift 1 → 2, 0.9 to 1.4 s"
    rows = event_rows([shift, idle])
    assert [row["gears"] for row in rows] == ["1 → 2", None]
    assert rows[1]["lasts [s]"] == pytest.approx(6.0, rel=1e-9, abs=0.0)
    assert rows[1]["note"] == "warm"
