"""A log's values over a part, as a page lists them."""

from __future__ import annotations

from typing import Any

import numpy as np

from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.events import Event
from atleak.measurements.road_test import RoadTest
from atleak.report.tables.road_test import LaidOver, event_table, log_curves, short, value_rows, whole

SAY = wording("en")


def rows_of(test: RoadTest, **more: Any) -> dict[str, dict[str, str]]:
    return {row["log_channel"]: row for row in value_rows(log_curves(test, SAY, **more), SAY)}


def test_rows_hold_least_mean_and_largest_of_good_samples(worn: Diagnosis) -> None:
    road = worn.road
    rows = rows_of(road.road_test, road=road)
    speed = road.road_test.values("engine_speed") * 60.0
    row = rows["engine speed"]
    assert row["log_in"] == "rpm"
    assert [row[key] for key in ("log_least", "log_mean", "log_largest")] == [
        short(float(each), SAY) for each in (speed.min(), speed.mean(), speed.max())
    ]
    good = road.road_test.values("converter_pressure") / 1e3
    assert np.isnan(good).sum() == 20  # the suspect stretch, which is left out
    assert rows["converter pressure"]["log_mean"] == short(float(np.nanmean(good)), SAY)
    assert rows["leakage"]["log_largest"] == short(road.max_leakage.leakage * 6e4, SAY)
    assert rows["share"]["log_largest"] == short(float(np.nanmax(road.share)) * 100.0, SAY)


def test_without_an_engine_only_the_channels_are_listed(worn: Diagnosis) -> None:
    assert "leakage" not in rows_of(worn.road.road_test)


def test_a_channel_without_a_good_sample_has_no_row(worn: Diagnosis) -> None:
    part = worn.road.road_test.window(300.0, 301.5)  # inside the suspect stretch of the converter pressure
    assert "converter pressure" not in rows_of(part)


def test_a_second_log_is_named_beside_its_channels(log_of) -> None:
    test = log_of(np.arange(5.0), engine_speed=20.0)
    rows = rows_of(test, over=LaidOver(log_of(np.arange(5.0), engine_speed=21.0), 1.5))
    assert [(name, row["log_mean"]) for name, row in rows.items()] == [
        ("engine speed", whole(1200, SAY)), ("engine speed, own.csv", whole(1260, SAY)),
    ]  # fmt: skip


def test_counts_are_plain_numbers_with_their_thousands_parted() -> None:
    assert whole(1_800_000, SAY).replace("\u00a0", " ") == "1 800 000"
    assert short(1_800_000.0, SAY).replace("\u00a0", " ") == "1 800 000"
    assert [short(value, SAY) for value in (1.6543, 92.71, 0.00012, 4.0)] == ["1.65", "92.7", "0.000", "4"]


def test_events_are_listed_in_the_readers_language_with_their_gears_and_remarks() -> None:
    events = [Event("gear_shift", 0.891, 1.4, 1, 2), Event("hot_idle", 3.0, 9.0, note="warm")]
    shift, idle = event_table(events, wording("de")).frame(rounded=True).to_dict("records")
    assert shift["Ereignis"] == wording("de")("events.gear_shift") != SAY("events.gear_shift")
    assert (shift["Gänge"], shift["Beginn [s]"], shift["Dauer [s]"]) == ("1 → 2", 0.89, 0.51)
    assert (idle["Gänge"], idle["Bemerkung"]) == (None, "warm")
