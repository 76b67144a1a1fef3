"""The source study's pictures by their data: what is drawn and where it is marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.figures.variant_figures import figure
from atleak.intake.road_test import read_road_test
from atleak.road_test import RoadTest
from atleak.variants import VariantResult, run_variants, temperature_curves
from atleak.variants.charts import (
    Chart,
    gear_spans,
    leakage_chart,
    share_chart,
    temperature_chart,
)
from atleak.wording import wording

NAMES = [f"W{number}" for number in range(1, 9)]
DM3_MIN = 6e4

EN = wording("en")


@pytest.fixture(scope="module")
def road_test(sample_log: Path) -> RoadTest:
    return read_road_test(sample_log)


@pytest.fixture(scope="module")
def results(four_speed: Controller, road_test: RoadTest) -> tuple[VariantResult, ...]:
    return run_variants(four_speed, road_test)


@pytest.fixture(scope="module")
def over_time(results, road_test: RoadTest) -> Chart:
    return leakage_chart(results, EN, road_test.values("gear"))


@pytest.fixture(scope="module")
def share(results, road_test: RoadTest) -> Chart:
    return share_chart(results, EN, road_test.values("gear"))


@pytest.fixture(scope="module")
def over_temperature(four_speed: Controller, road_test: RoadTest, results) -> Chart:
    return temperature_chart(temperature_curves(four_speed, road_test), EN, results)


def line(chart: Chart, name: str):
    return next(curve for curve in chart.lines if curve.name.split(":")[0] == name)


# --- Figure 13


def test_leakage_of_every_variant_over_time(over_time: Chart, results) -> None:
    for result in results:
        drawn = line(over_time, result.variant.name)
        assert drawn.x == pytest.approx(result.time, rel=1e-9, abs=0.0)
        assert drawn.y == pytest.approx(result.computed.leakage * DM3_MIN, rel=1e-12, abs=0.0)


def test_pump_capacity_has_its_own_panel(over_time: Chart, results) -> None:
    pump = line(over_time, "pump capacity Q_p")
    assert pump.panel == "upper"
    assert pump.y.max() == pytest.approx(33.6, abs=0.05)
    assert pump.y[0] == pytest.approx(results[0].computed.pump_capacity[0] * DM3_MIN, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("name", NAMES)
def test_least_and_most_of_a_variant_are_marked_on_its_line(name: str, over_time: Chart) -> None:
    drawn = line(over_time, name)
    for word, extreme, symbol in (("least", np.argmin, "triangle-down"), ("most", np.argmax, "triangle-up")):
        mark = line(over_time, f"{name} {word}")
        index = extreme(drawn.y)
        assert (mark.x[0], mark.y[0]) == (
            pytest.approx(drawn.x[index], rel=1e-9, abs=0.0),
            pytest.approx(drawn.y[index], rel=1e-9, abs=0.0),
        )
        assert (mark.symbol, mark.color, mark.dash) == (symbol, drawn.color, None)


def test_instants_of_least_and_most_leakage(over_time: Chart) -> None:
    assert [mark.x for mark in over_time.marks] == pytest.approx([0.96, 2.1], rel=1e-9, abs=0.0)
    assert [mark.text for mark in over_time.marks] == ["least leakage, 0.96 s", "most leakage, 2.1 s"]
    assert len({mark.dash for mark in over_time.marks}) == 2


def test_gears_stand_over_the_test(over_time: Chart) -> None:
    assert [span[2] for span in over_time.spans] == ["gear 1", "gear 2", "gear 3", "gear 4"]
    assert over_time.spans[1][:2] == (pytest.approx(0.9, rel=1e-9, abs=0.0), pytest.approx(5.1, rel=1e-9, abs=0.0))


def test_variants_differ_without_colour(over_time: Chart) -> None:
    """Two lines of one dash lie far apart: W1 and W4, W2 and W8."""
    dashes = {name: line(over_time, name).dash for name in NAMES}
    for first in NAMES:
        for second in NAMES:
            if first < second and dashes[first] == dashes[second]:
                ratio = line(over_time, second).y / line(over_time, first).y
                assert ratio.min() > 3.0


# --- the share


def test_share_is_marked_largest_at_idle(share: Chart) -> None:
    for name in NAMES:
        drawn, worst, most = (line(share, label) for label in (name, f"{name} largest share", f"{name} most leakage"))
        assert worst.y[0] == pytest.approx(drawn.y.max(), rel=1e-9, abs=0.0)
        assert worst.x[0] < 0.1
        assert most.x[0] == pytest.approx(2.1, abs=0.05)
        assert worst.y[0] > 1.3 * most.y[0]
    assert line(share, "W8 most leakage").y[0] == pytest.approx(46.2, abs=0.05)


def test_share_needs_engine_speed(four_speed: Controller, road_test: RoadTest) -> None:
    from dataclasses import replace
    from types import MappingProxyType

    channels = {name: channel for name, channel in road_test.channels.items() if name != "engine_speed"}
    results = run_variants(four_speed, replace(road_test, channels=MappingProxyType(channels), _held={}))
    with pytest.raises(ValueError, match="engine speed"):
        share_chart(results, EN)
    assert not leakage_chart(results, EN).has_upper


# --- Figure 14


def test_most_leakage_over_temperature_with_three_viscosities(over_temperature: Chart) -> None:
    curves = over_temperature.lines[:3]
    assert [curve.name.split()[0] for curve in curves] == ["viscosities", "the", "ASTM"]
    assert len({curve.dash for curve in curves}) == 3
    study, _, d341 = (dict(zip(curve.x, curve.y, strict=True)) for curve in curves)
    assert study[100.0] == pytest.approx(11.23, abs=0.005)
    assert study[80.0] == pytest.approx(6.58, abs=0.005)  # fresh oil
    assert d341[100.0] == pytest.approx(study[100.0], rel=2e-3, abs=0.0)
    assert np.isnan(d341[-40.0])


def test_variants_of_that_wear_printed_and_computed(over_temperature: Chart) -> None:
    printed, computed = over_temperature.lines[3:]
    assert printed.x.tolist() == [-40.0, 20.0, 40.0, 80.0, 100.0]
    assert printed.y.tolist() == [0.021, 0.38, 1.43, 8.56, 11.23]
    assert computed.text == ("W5", "W6", "W7", "W4", "W8")
    assert computed.y == pytest.approx(printed.y, rel=0.01, abs=0.0)
    assert (printed.filled, computed.filled) == (False, True)


# --- drawn


@pytest.mark.parametrize("which", ["over_time", "share", "over_temperature"])
def test_figure_draws_every_line_and_leaves_the_theme_alone(which: str, request: pytest.FixtureRequest) -> None:
    chart = request.getfixturevalue(which)
    drawn = figure(chart).checked()
    traces = {trace.name: trace for trace in drawn.data}
    for curve in chart.lines:
        trace = traces[curve.name]
        assert np.array_equal(np.asarray(trace.x, float), curve.x, equal_nan=True)
        assert np.array_equal(np.asarray(trace.y, float), curve.y, equal_nan=True)
        assert len(trace.x) <= 4000
        assert trace.connectgaps is False
    for mark in chart.marks:
        assert traces[mark.text].line.dash == mark.dash
        assert any(shape.x0 == shape.x1 == mark.x for shape in drawn.layout.shapes)
    assert drawn.layout.paper_bgcolor == drawn.layout.plot_bgcolor == "rgba(0,0,0,0)"
    assert drawn.layout.font.color is None
    axes = {name: axis for name, axis in drawn.layout.to_plotly_json().items() if name[1:5] == "axis"}
    titles = {name: axis["title"]["text"] for name, axis in axes.items() if "title" in axis}
    assert [title for name, title in titles.items() if name[0] == "x"] == [chart.x_label]
    assert {title for name, title in titles.items() if name[0] == "y"} == {chart.y_label, chart.upper_label} - {""}
    for label in (chart.x_label, chart.y_label, chart.upper_label):
        assert not label or label.endswith("]")
    assert drawn.layout.meta["description"] == chart.description


def test_logarithmic_scale(four_speed: Controller, road_test: RoadTest, results) -> None:
    chart = temperature_chart(temperature_curves(four_speed, road_test), EN, results, log_y=True)
    assert figure(chart).layout.yaxis.type == "log"


def test_gears_that_change_without_end_or_are_unknown_are_not_drawn() -> None:
    time = np.arange(100.0)
    assert gear_spans(time, EN, None) == ()
    assert gear_spans(time, EN, np.arange(100) % 2) == ()
    unknown = np.concatenate([np.full(50, 2.0), np.full(50, np.nan)])
    spans = gear_spans(time, EN, unknown)
    assert [span[2] for span in spans] == ["gear 2"]
