"""The picture of a log by its traces: channels, events, formulas, a second log; the operating map by its cells."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from atleak.analysis.formulas import formula_channel
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.road_pressure import permitted_pressure
from atleak.measurements.events import Event
from atleak.measurements.road_test import Channel
from atleak.report.charts.figure import Figure
from atleak.report.charts.log_figures import LINES, histogram_figure, log_channels, operating_map_figure
from atleak.report.charts.operating_map import histogram, operating_map
from atleak.report.tables.road_test import LaidOver, log_curves

SAY = wording("en")


def drawn(log, marked=(), **more: Any) -> Figure:
    return log_channels(log, log_curves(log, SAY, **more), SAY, marked)


def curve(figure: Figure, name: str) -> Any:
    return next(one for one in figure.data if one.name == name)


def test_long_logs_are_thinned_and_keep_a_spike_of_one_sample(log_of) -> None:
    size = 60_000
    pressure = 600e3 + 1e3 * np.sin(np.arange(size))
    pressure[31_234], pressure[1000:1400:2] = 950e3, np.nan
    figure = drawn(log_of(np.arange(size) * 0.01, main_pressure=pressure, gear=2.0))
    assert all(len(one.x) <= 4000 for one in figure.data)
    line = curve(figure, "main (line) pressure")
    assert np.nanmax(line.y) == 950.0
    assert np.isnan(np.asarray(line.y, dtype=float)).any()
    assert line.connectgaps is False


def test_where_the_cursor_may_stand_every_curve_has_its_own_sample_however_long_the_log_is(log_of) -> None:
    time = np.arange(60_000) * 0.01
    held = {"engine_speed": 25.0 + 15.0 * np.sin(time / 7.0), "main_pressure": 600e3 + 90e3 * np.cos(time / 3.0)}
    figure = drawn(log_of(time, **held), over=LaidOver(log_of(time, **held), 0.25))
    stamps = np.asarray(figure.layout.meta["stamps"])
    assert (stamps[0], stamps[-1]) == (time[0], time[-1])
    for name, factor in (("engine speed", 60.0), ("main (line) pressure", 1e-3)):
        values = factor * held["engine_speed" if factor > 1.0 else "main_pressure"]
        for line, shift in ((curve(figure, name), 0.0), (curve(figure, f"{name}, own.csv"), 0.25)):
            inside = stamps[stamps >= shift]
            shown = np.asarray(line.y)[np.searchsorted(line.x, inside, side="right") - 1]
            true = values[np.searchsorted(time + shift, inside, side="right") - 1]
            assert shown == pytest.approx(true, rel=1e-12, abs=0.0)


def test_a_part_without_a_sample_has_no_curve_of_a_constant(log_of) -> None:
    one, other = (log_of(np.arange(5.0), main_pressure=600e3, gear=2.0) for _ in range(2))
    gear = Channel("gear", other.time[:1], np.array([2.0]), np.array([False]), source="constant", independent=1)
    other = replace(other, channels={**other.channels, "gear": gear})
    whole, away = (drawn(one, over=LaidOver(other.window(*ends), 9.0)) for ends in ((0.0, 4.0), (7.0, 8.0)))
    assert list(curve(whole, "gear, own.csv").x) == [9.0, 13.0]
    assert "gear, own.csv" not in {line.name for line in away.data}


def test_channels_are_drawn_in_the_unit_asked_for_and_suspect_samples_are_crossed(log_of) -> None:
    log = log_of(np.arange(4.0), main_pressure=np.array([600e3, 610e3, 5000e3, 620e3]))
    log.channels["main_pressure"].suspect[2] = True
    figure = drawn(log)
    line, crosses = figure.data
    assert np.asarray(line.y, dtype=float) == pytest.approx(
        [600.0, 610.0, np.nan, 620.0], nan_ok=True, rel=1e-9, abs=0.0
    )
    assert (list(crosses.x), list(crosses.y)) == ([2.0], [5000.0])
    assert "[kPa]" in figure.layout.yaxis.title.text


def test_events_are_marked_where_they_begin_and_shaded_where_they_last(log_of) -> None:
    log = log_of(np.arange(20.0), main_pressure=600e3, engine_speed=20.0)
    events = [Event("gear_shift", 3.0, 3.5, 1, 2), Event("hot_idle", 8.0, 12.0), Event("stall", 40.0, 41.0)]
    figure = drawn(log, events)
    assert [note.text for note in figure.layout.annotations] == ["1→2"]
    assert {shape.x0 for shape in figure.layout.shapes if shape.type == "line"} == {3.0, 8.0}
    assert {(shape.x0, shape.x1) for shape in figure.layout.shapes if shape.type == "rect"} == {(8.0, 12.0)}
    assert list(curve(figure, "hot idle").x)[:2] == [8.0, 12.0]
    assert "stall" not in {one.name for one in figure.data}  # it lies outside


def test_every_event_is_drawn_however_many_there_are(log_of) -> None:
    log = log_of(np.arange(0.0, 18_000.0, 10.0), main_pressure=600e3)
    many = [Event("gear_shift", 1.0 + 8.0 * number, 1.5 + 8.0 * number, 1, 2) for number in range(2000)]
    figure = drawn(log, many)
    lane = curve(figure, "shift")
    ends = [each for each in lane.x if each is not None]
    assert (ends[0], ends[-1]) == (many[0].start, many[-1].stop)
    bars = [(first, last) for first, last in zip(ends[::2], ends[1::2], strict=True)]
    assert all(any(first <= event.start and event.stop <= last for first, last in bars) for event in many[::97])
    assert len(lane.x) <= 4500
    assert not figure.layout.shapes  # lines through all curves are for up to so many
    assert len(drawn(log, many[:LINES]).layout.shapes) == LINES


def test_a_log_without_a_channel_has_no_axes_for_one(log_of) -> None:
    assert not drawn(log_of(np.arange(3.0))).data


def test_another_log_is_laid_over_it_dashed_and_shifted(log_of) -> None:
    one = log_of(np.arange(5.0), main_pressure=600e3, engine_speed=20.0)
    other = log_of(np.arange(5.0), main_pressure=650e3)
    figure = drawn(one, over=LaidOver(other, 2.5))
    laid = [line for line in figure.data if line.line.dash == "dash"]
    assert len(laid) == 1
    assert list(laid[0].x) == [2.5, 3.5, 4.5, 5.5, 6.5]
    assert set(laid[0].y) == {650.0}
    assert laid[0].name == "main (line) pressure, own.csv"


def test_a_formula_is_a_curve_of_its_own_over_both_logs(log_of) -> None:
    one, other = (log_of(np.arange(5.0), main_pressure=p, converter_pressure=300e3) for p in (600e3, 650e3))
    drops = [formula_channel("drop", "p_g − p_k", log) for log in (one, other)]
    figure = drawn(one, formulas=drops[:1], over=LaidOver(other, 0.0, {"drop": drops[1]}))
    assert set(curve(figure, "drop").y) == {300.0}
    assert set(curve(figure, "drop, own.csv").y) == {350.0}
    assert figure.layout.yaxis3.title.text == "drop<br>[kPa]"


def test_what_is_permitted_and_the_leakage_are_curves_among_the_channels(worn: Diagnosis) -> None:
    test = worn.road.road_test
    permitted = permitted_pressure(worn.controller, test)
    figure = drawn(test, permitted=permitted, road=worn.road, limits=worn.limits)
    least, pressure = curve(figure, "permitted at least"), curve(figure, "main (line) pressure")
    assert (least.yaxis, least.meta) == (pressure.yaxis, {"unit": "kPa", "look": "least"})
    assert np.unique(least.y[np.isfinite(least.y)]) == pytest.approx(np.unique(permitted[0]) / 1e3, rel=1e-12, abs=0.0)
    assert max(curve(figure, "share").y) == pytest.approx(np.nanmax(worn.road.share) * 100.0, rel=1e-12, abs=0.0)
    (first, _), *_ = worn.limits.fixed_bands
    assert next(note.text for note in figure.layout.annotations if "%" in note.text).startswith(SAY.level(first))


def test_the_map_writes_the_time_into_every_cell_that_was_driven(log_of) -> None:
    log = log_of([0.0, 10.0, 30.0, 31.0], engine_speed=[10.0, 30.0, 30.0, 30.0], atf_temperature=[60, 90, 90, 90])
    cells = operating_map(log, None, ("rpm", lambda value: value * 60.0), ("°C", lambda value: value))
    figure = operating_map_figure(cells, "rpm", "°C", SAY)
    (heat,) = figure.data
    assert sorted(text for row in heat.text for text in row if text) == ["10\u00a0s".replace("\u00a0", " "), "21 s"]
    assert np.isfinite(np.asarray(heat.z, dtype=float)).sum() == 2
    lightness = [sum(int(colour[place : place + 2], 16) for place in (1, 3, 5)) for _, colour in heat.colorscale]
    assert lightness == sorted(lightness, reverse=True)  # much is dark, in the browser too
    assert "[°C]" in figure.layout.yaxis.title.text


def test_a_histogram_shows_the_time_at_each_value(log_of) -> None:
    log = log_of([0.0, 1.0, 3.0], main_pressure=600e3)
    (bars,) = histogram_figure(histogram(log, np.array([1.0, 2.0, 2.0])), "gear", "", SAY).data
    assert sum(bars.y) == pytest.approx(3.0, rel=1e-12, abs=0.0)
