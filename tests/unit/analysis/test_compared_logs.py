"""Events of two logs are matched by kind, gears and order, and each log is aligned at the event's own start."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.analysis.changes import MARGIN, LogComparison, match_events
from atleak.diagnosis.road import RoadFindings
from atleak.measurements.events import Event


def shift(start: float, gears: tuple[int, int] = (1, 2)) -> Event:
    return Event("gear_shift", start, start + 0.5, *gears)


def idle(start: float) -> Event:
    return Event("hot_idle", start, start + 10.0)


def test_shifts_are_matched_by_their_gears_and_order() -> None:
    before = [idle(0.0), shift(12.0), shift(15.0, (2, 3)), shift(40.0)]
    after = [shift(3.0, (2, 3)), shift(5.0), idle(20.0), idle(60.0)]
    pairs = match_events(before, after)
    assert [(pair.before and pair.before.start, pair.after and pair.after.start) for pair in pairs] == [
        (0.0, 20.0), (12.0, 5.0), (15.0, 3.0), (40.0, None), (None, 60.0),
    ]  # fmt: skip
    assert [pair.order for pair in pairs] == [1, 1, 1, 2, 2]
    assert [pair.matched for pair in pairs] == [True, True, True, False, False]


def findings(log_of, events: tuple[Event, ...]) -> RoadFindings:
    time = np.arange(0.0, 60.0, 0.5)
    test = log_of(time, main_pressure=500e3 + time)
    return RoadFindings(test, events, {}, None, "no_engine_speed", None, ())


def test_both_parts_reach_equally_far_from_the_start_of_their_own_event(log_of) -> None:
    before, after = findings(log_of, (idle(10.0),)), findings(log_of, (Event("hot_idle", 30.0, 34.0),))
    logs = LogComparison(before, after, match_events(before.events, after.events))
    (first, start_before), (second, start_after) = logs.windows(logs.pairs[0])
    assert (start_before, start_after) == (10.0, 30.0)
    for part, start in ((first, start_before), (second, start_after)):
        assert part.time[0] - start == pytest.approx(-MARGIN, abs=1e-9)
        assert part.time[-1] - start == pytest.approx(10.0 + MARGIN, abs=1e-9)
