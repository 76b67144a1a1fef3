"""Clearances before and after, and two logs over one another, by the figures' data."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.analysis.changes import LogComparison, match_events
from atleak.analysis.comparison import compare
from atleak.common.wording import wording
from atleak.diagnosis.road import RoadFindings
from atleak.measurements.events import Event
from atleak.measurements.road_test import RoadTest
from atleak.report.charts.comparison_figures import clearance_chart, logs_over_one_another


def test_every_land_has_its_clearance_of_both_visits_and_its_limit(worn_clutch) -> None:
    comparison = compare(worn_clutch, worn_clutch)
    lands = comparison.flagged
    chart = clearance_chart(lands, [str(land.key) for land in lands], wording("en"))
    expected = [land.before.state.radial_clearance * 1e6 for land in lands]
    for side in ("Before", "After"):
        layers = [layer for layer in chart.layers if layer.name.startswith(side)]
        values = [next(filter(None, row), None) for row in zip(*(layer.values for layer in layers), strict=True)]
        assert values == pytest.approx(expected, abs=1e-9)
        assert all(layer.open == [side == "Before"] * len(lands) for layer in layers)
        for layer in layers:
            known = [
                low < value < high
                for value, (low, high) in zip(layer.values, layer.spans, strict=True)
                if value is not None
            ]
            assert all(known)
    limits = next(layer for layer in chart.layers if layer.name == "first limit of clearance")
    assert None not in limits.values


def test_each_log_is_drawn_from_the_start_of_its_own_event(log_of) -> None:
    def findings(start: float, height: float) -> RoadFindings:
        time = np.arange(0.0, 40.0, 0.1)
        test: RoadTest = log_of(time, main_pressure=500e3 + height * (time >= start), engine_speed=20.0)
        return RoadFindings(test, (Event("gear_shift", start, start + 0.5, 1, 2),), {}, None, "no_gear", None, ())

    before, after = findings(10.0, 100e3), findings(25.0, 200e3)
    logs = LogComparison(before, after, match_events(before.events, after.events))
    figure = logs_over_one_another(
        logs, logs.pairs[0], {"main_pressure": ("kPa", lambda pascal: pascal / 1e3)}, wording("en")
    )
    pressure = figure.data[:2]
    assert [trace.name for trace in pressure] == ["Before", "After"]
    for trace, high in zip(pressure, (600.0, 700.0), strict=True):
        time, values = np.array(trace.x), np.array(trace.y)
        assert values[time < -0.05] == pytest.approx(500.0, abs=1e-9)
        assert values[time > 0.05] == pytest.approx(high, abs=1e-9)
    assert pressure[0].line.dash == "dash"
    assert pressure[1].line.dash != "dash"
    assert [trace.showlegend for trace in figure.data] == [True, True, False, False]
