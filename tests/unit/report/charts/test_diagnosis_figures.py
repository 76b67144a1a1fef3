"""Figures by their trace data."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.units import DM3_MIN, PERCENT
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.projection import stated_condition
from atleak.measurements.readings import Readings
from atleak.report.charts import land_figures as figures
from atleak.report.charts import land_figures as of_uncertainty
from atleak.report.charts.figure import Figure
from atleak.report.charts.log_figures import log_channels
from atleak.report.tables.road_test import leakage_curves
from tests.unit.conftest import with_clearances

ALL = {
    "ranking": lambda diagnosis: figures.leakage_ranking(diagnosis),
    "share": lambda diagnosis: figures.total_share(diagnosis),
    "road": lambda diagnosis: over_the_log(diagnosis),
    "wear": lambda diagnosis: figures.land_wear(diagnosis),
}


def over_the_log(diagnosis: Diagnosis) -> Figure:
    say = wording("en")
    return log_channels(diagnosis.road.road_test, leakage_curves(diagnosis.road, diagnosis.limits, say), say)


def trace(figure, name: str):
    return next(one for one in figure.data if one.name == name)


@pytest.mark.parametrize("name", ALL)
def test_figures_are_transparent_and_say_their_units(sample: Diagnosis, name: str) -> None:
    figure = ALL[name](sample).checked()
    assert figure.layout.paper_bgcolor == figure.layout.plot_bgcolor == "rgba(0,0,0,0)"
    titles = [axis.title.text or "" for axis in (*figure.select_xaxes(), *figure.select_yaxes())]
    assert any("[" in title for title in titles)
    json.dumps(figure.to_plotly_json(), default=lambda array: array.tolist())


def test_ranking_holds_the_largest_lands_with_their_leakage_and_interval(sample: Diagnosis) -> None:
    figure = figures.leakage_ranking(sample, lands=12)
    bars = [bar for bar in figure.data if bar.type == "bar"]
    drawn = {name: value for bar in bars for name, value in zip(bar.y, bar.x, strict=True)}
    assert drawn == {figures.land_name(land): land.leakage * DM3_MIN for land in sample.ranked[:12]}
    assert list(figure.layout.yaxis.categoryarray)[-1] == figures.land_name(sample.ranked[0])
    for bar in bars:
        assert len(bar.error_x.array) == len(bar.x)
        assert min(bar.error_x.array) >= 0.0
        assert min(bar.error_x.arrayminus) >= 0.0


def test_verdicts_differ_by_sign_and_hatch_and_not_by_colour_alone(sample: Diagnosis) -> None:
    bars = [bar for bar in figures.leakage_ranking(sample, lands=47).data if bar.type == "bar"]
    assert len(bars) > 2
    assert len({bar.marker.pattern.shape for bar in bars}) == len(bars)
    assert len({bar.name[0] for bar in bars}) == len(bars)
    marks = [one.marker.symbol for one in figures.land_wear(sample).data]
    assert len(set(marks)) == len(marks)


def test_total_share_stands_over_the_bands_of_the_limit_set(sample: Diagnosis) -> None:
    figure = figures.total_share(sample)
    points = figure.data[0]
    expected = [point.share * PERCENT for point in sample.reported]
    assert list(points.x[: len(expected)]) == pytest.approx(expected, rel=1e-9, abs=0.0)
    assert points.x[-1] == pytest.approx(sample.road.max_share.share * PERCENT, rel=1e-9, abs=0.0)
    for place, projection in enumerate(sample.reported):
        edges = [shape.x0 for shape in figure.layout.shapes if shape.y0 < place < shape.y1]
        limits = [limit * PERCENT for _, limit in sample.total_rule(projection).steps.levels]
        assert edges == pytest.approx([0.0, *limits], rel=1e-9, abs=0.0)


def test_a_unit_that_nobody_measured_stands_over_no_band(unmeasured: Diagnosis) -> None:
    figure = figures.total_share(unmeasured)
    assert not figure.layout.shapes
    assert figure.data[0].name == "as new: nothing was measured"


def test_total_share_stands_beside_that_of_the_same_unit_new(sample: Diagnosis) -> None:
    new = trace(figures.total_share(sample), "the same unit new")
    assert list(new.x) == pytest.approx([at.share * PERCENT for at in sample.new_projections], rel=1e-9, abs=0.0)
    assert new.marker.symbol == "circle-open"


def test_road_figure_shows_leakage_pump_and_share_with_their_extremes(sample: Diagnosis) -> None:
    figure, road = over_the_log(sample), sample.road
    leakage, share = trace(figure, "leakage"), trace(figure, "share")
    assert np.nanmax(leakage.y) == pytest.approx(road.max_leakage.leakage * DM3_MIN, rel=1e-9, abs=0.0)
    assert np.nanmin(leakage.y) == pytest.approx(road.min_leakage.leakage * DM3_MIN, rel=1e-9, abs=0.0)
    assert np.nanmax(share.y) == pytest.approx(road.max_share.share * PERCENT, rel=1e-9, abs=0.0)
    assert len({trace(figure, name).yaxis for name in ("leakage", "pump flow", "share")}) == 3
    sustained = road.extremes.max_share_sustained
    for instant, how in ((sustained, "sustained"), (road.max_share, "single sample")):
        marked = trace(figure, f"largest share, {how}, {instant.time:.2f} s")
        assert (marked.x[0], marked.y[0]) == pytest.approx((instant.time, instant.share * PERCENT), rel=1e-9, abs=0.0)


def test_a_log_without_engine_speed_shows_leakage_alone(four_speed, hipol, limits, log_of) -> None:
    log = log_of(np.arange(50.0), main_pressure=600e3, converter_pressure=300e3, atf_temperature=80.0, gear=2.0)
    diagnosis = diagnose(four_speed, hipol, limits, road_test=log)
    figure = over_the_log(diagnosis)
    assert {one.name for one in figure.data if one.mode == "lines"} == {"leakage"}
    assert all(one.error_x.array is None for one in figures.leakage_ranking(diagnosis).data)


def test_long_logs_are_thinned_and_keep_a_spike_of_one_sample(four_speed, hipol, limits, log_of) -> None:
    size = 60_000
    pressure = 600e3 + 1e3 * np.sin(np.arange(size))
    pressure[31_234], pressure[1000:1400:2] = 950e3, np.nan
    log = log_of(
        np.arange(size) * 0.01,
        main_pressure=pressure,
        engine_speed=25.0,
        converter_pressure=300e3,
        atf_temperature=80.0,
        gear=2.0,
    )
    diagnosis = diagnose(four_speed, hipol, limits, road_test=log)
    assert all(len(one.x) <= 4000 for one in over_the_log(diagnosis).data)
    leakage = trace(over_the_log(diagnosis), "leakage")
    assert np.nanmax(leakage.y) == pytest.approx(np.nanmax(diagnosis.road.leakage) * DM3_MIN, rel=1e-9, abs=0.0)
    assert np.isclose(leakage.x, 312.34).any()


def test_a_pump_that_delivers_nothing_leaves_no_point(sample: Diagnosis) -> None:
    from dataclasses import replace

    first, *others = sample.projections
    dry = replace(sample, projections=(replace(first, pump_capacity=0.0), *others))
    points = figures.total_share(dry).data[0]
    assert len(points.x) == len(dry.projections) - 1 + (dry.road is not None)
    assert not any(label.startswith("driving") for label in points.y)


def test_total_share_pairs_each_point_with_its_own_interval(sample: Diagnosis) -> None:
    """A stated condition besides the controller's own points must not shift the bars."""
    stated = stated_condition(sample.controller, temperature=120.0)
    diagnosis = diagnose(sample.controller, sample.fluid, sample.limits, readings=sample.readings, condition=stated)
    points = next(one for one in figures.total_share(diagnosis).data if one.error_x.array is not None)
    assert len(points.x) == len(diagnosis.reported) >= 2
    for projection, x, low, high in zip(
        diagnosis.reported, points.x, points.error_x.arrayminus, points.error_x.array, strict=True
    ):
        interval = diagnosis.uncertainty.total(projection.condition.name).share_interval
        assert x - low == pytest.approx(interval[0] * PERCENT, rel=1e-9, abs=0.0)
        assert x + high == pytest.approx(interval[1] * PERCENT, rel=1e-9, abs=0.0)


def test_limits_and_mounting_clearances_lie_open_under_the_values(sample: Diagnosis) -> None:
    drawn = [
        (one.name, one.marker.symbol) for one in of_uncertainty.land_clearances(sample.uncertainty, wording("en")).data
    ]
    assert [name for name, _ in drawn[:2]] == ["mounting clearance", "limit"]
    assert all(symbol.endswith("-open") for _, symbol in drawn[:2])
    assert len(drawn) > 3


def test_totals_tell_how_likely_each_band_is(sample: Diagnosis) -> None:
    points = figures.total_share(sample).data[0]
    for text, projection in zip(points.customdata, sample.reported, strict=False):
        bands = sample.uncertainty.total(projection.condition.name).band_probabilities
        likeliest = max(bands, key=lambda item: item[1])
        assert f"{likeliest[0]} {100 * likeliest[1]:.0f}\u00a0%" in str(text)


def test_a_share_near_the_left_end_is_written_beside_its_mark(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings], sample: Diagnosis
) -> None:
    """Centred on it, its first digit would be cut by the axis."""
    readings = with_clearances(minimal, readings_of, {})
    figure = figures.total_share(diagnose(minimal, hipol, limits, readings=readings))
    _, right = figure.layout.xaxis.range
    points = figure.data[0]
    assert min(points.x) < 0.08 * right
    for share, place in zip(points.x, points.textposition, strict=True):
        assert place == ("top right" if share < 0.08 * right else "top center")
    assert "top center" in figures.total_share(sample).data[0].textposition


def test_bands_of_the_totals_are_named_under_their_sign(sample: Diagnosis) -> None:
    notes = [note.text for note in figures.total_share(sample).layout.annotations]
    bands = ["● green", "▲ amber", "■ red", "✖ critical"] * len(sample.reported)
    assert all(band.startswith(note) and band[0] == note[0] for band, note in zip(bands, notes, strict=True))


def test_wear_stands_beside_the_limits_of_its_own_land(sample: Diagnosis) -> None:
    """A tenth of 24.5 µm is less than the 4 µm that are asked for, so that limits differ from land to land."""
    figure = figures.land_wear(sample)
    watch = trace(figure, "watch from here")
    limits = dict(zip(watch.y, watch.x, strict=True))
    for land in sample.lands:
        expected = max(10.0, 100.0 * 4e-6 / land.state.land.mounting_high)
        assert limits[figures.land_name(land)] == pytest.approx(expected, rel=1e-9, abs=0.0)
