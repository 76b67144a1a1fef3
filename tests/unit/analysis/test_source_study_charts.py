"""The source study's pictures by their data: what is drawn and where it is marked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from atleak.analysis.source_study import VariantResult, run_variants, temperature_curves
from atleak.catalogue.controller import Controller
from atleak.common.wording import wording
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test
from atleak.report.charts.figure import Figure
from atleak.report.charts.study_figures import leakage_over_temperature, leakage_over_time, share_over_time

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
def over_time(results, road_test: RoadTest) -> Figure:
    return leakage_over_time(results, EN, road_test.values("gear"))


@pytest.fixture(scope="module")
def share(results, road_test: RoadTest) -> Figure:
    return share_over_time(results, EN, road_test.values("gear"))


@pytest.fixture(scope="module")
def over_temperature(four_speed: Controller, road_test: RoadTest, results) -> Figure:
    return leakage_over_temperature(temperature_curves(four_speed, road_test), EN, results)


def line(drawn: Figure, name: str):
    return next(trace for trace in drawn.data if trace.name.split(":")[0] == name)


# --- Figure 13


def test_leakage_of_every_variant_over_time(over_time: Figure, results) -> None:
    for result in results:
        drawn = line(over_time, result.variant.name)
        assert drawn.x == pytest.approx(result.time, rel=1e-9, abs=0.0)
        assert drawn.y == pytest.approx(result.computed.leakage * DM3_MIN, rel=1e-12, abs=0.0)


def test_pump_capacity_has_its_own_panel(over_time: Figure, results) -> None:
    pump = line(over_time, "pump capacity Q_p")
    assert (over_time.rows, pump.yaxis) == (2, "y")
    assert pump.y.max() == pytest.approx(33.6, abs=0.05)
    assert pump.y[0] == pytest.approx(results[0].computed.pump_capacity[0] * DM3_MIN, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("name", NAMES)
def test_least_and_most_of_a_variant_are_marked_on_its_line(name: str, over_time: Figure) -> None:
    drawn = line(over_time, name)
    for word, extreme, symbol in (("least", np.argmin, "triangle-down"), ("most", np.argmax, "triangle-up")):
        mark = line(over_time, f"{name} {word}")
        index = extreme(drawn.y)
        assert (mark.x[0], mark.y[0]) == pytest.approx((drawn.x[index], drawn.y[index]), rel=1e-9, abs=0.0)
        assert (mark.marker.symbol, mark.marker.color, mark.mode) == (symbol, drawn.line.color, "markers")


def test_instants_of_least_and_most_leakage(over_time: Figure) -> None:
    named = {trace.name: trace.line.dash for trace in over_time.data if trace.x[0] is None}
    assert list(named) == ["least leakage, 0.96 s", "most leakage, 2.1 s"]
    assert len(set(named.values())) == 2
    drawn = {shape.x0 for shape in over_time.layout.shapes if shape.line.width == 1.5}
    assert sorted(drawn) == pytest.approx([0.96, 2.1], rel=1e-9, abs=0.0)


def test_gears_stand_over_the_test(over_time: Figure) -> None:
    gears = over_time.layout.annotations
    assert [gear.text for gear in gears] == ["gear 1", "gear 2", "gear 3", "gear 4"]
    assert gears[1].x == pytest.approx(0.5 * (0.9 + 5.1), rel=1e-9, abs=0.0)


def test_variants_differ_without_colour(over_time: Figure) -> None:
    """Two lines of one dash lie far apart: W1 and W4, W2 and W8."""
    lines = {name: line(over_time, name) for name in NAMES}
    for first in NAMES:
        for second in NAMES:
            if first < second and lines[first].line.dash == lines[second].line.dash:
                assert (lines[second].y / lines[first].y).min() > 3.0


# --- the share


def test_share_is_marked_largest_at_idle(share: Figure) -> None:
    for name in NAMES:
        drawn, worst, most = (line(share, label) for label in (name, f"{name} largest share", f"{name} most leakage"))
        assert worst.y[0] == pytest.approx(drawn.y.max(), rel=1e-9, abs=0.0)
        assert worst.x[0] < 0.1
        assert most.x[0] == pytest.approx(2.1, abs=0.05)
        assert worst.y[0] > 1.3 * most.y[0]
    assert line(share, "W8 most leakage").y[0] == pytest.approx(46.2, abs=0.05)


def test_share_needs_engine_speed(four_speed: Controller, road_test: RoadTest) -> None:
    channels = {name: channel for name, channel in road_test.channels.items() if name != "engine_speed"}
    results = run_variants(four_speed, replace(road_test, channels=MappingProxyType(channels), _held={}))
    with pytest.raises(ValueError, match="engine speed"):
        share_over_time(results, EN)
    assert leakage_over_time(results, EN).rows == 1


# --- Figure 14


def test_most_leakage_over_temperature_with_three_viscosities(over_temperature: Figure) -> None:
    curves = over_temperature.data[:3]
    assert [curve.name.split()[0] for curve in curves] == ["viscosities", "the", "ASTM"]
    assert len({curve.line.dash for curve in curves}) == 3
    study, _, d341 = (dict(zip(curve.x, curve.y, strict=True)) for curve in curves)
    assert study[100.0] == pytest.approx(11.23, abs=0.005)
    assert study[80.0] == pytest.approx(6.58, abs=0.005)  # fresh oil
    assert d341[100.0] == pytest.approx(study[100.0], rel=2e-3, abs=0.0)
    assert np.isnan(d341[-40.0])


def test_variants_of_that_wear_printed_and_computed(over_temperature: Figure) -> None:
    printed, computed = over_temperature.data[3:]
    assert list(printed.x) == [-40.0, 20.0, 40.0, 80.0, 100.0]
    assert list(printed.y) == [0.021, 0.38, 1.43, 8.56, 11.23]
    assert computed.text == ("W5", "W6", "W7", "W4", "W8")
    assert computed.y == pytest.approx(printed.y, rel=0.01, abs=0.0)
    assert (printed.marker.symbol, computed.marker.symbol) == ("square-open", "circle")


# --- drawn


@pytest.mark.parametrize("which", ["over_time", "share", "over_temperature"])
def test_figure_says_its_units_and_leaves_the_theme_alone(which: str, request: pytest.FixtureRequest) -> None:
    drawn = request.getfixturevalue(which).checked()
    for trace in drawn.data:
        assert len(trace.x) <= 4000
        assert trace.connectgaps is (False if trace.mode == "lines" and trace.x[0] is not None else None)
    assert drawn.layout.paper_bgcolor == drawn.layout.plot_bgcolor == "rgba(0,0,0,0)"
    assert drawn.layout.font.color is None
    axes = {name: axis for name, axis in drawn.layout.to_plotly_json().items() if name[1:5] == "axis"}
    titles = [axis["title"]["text"] for axis in axes.values() if "title" in axis]
    assert len(titles) == len(axes) - ("xaxis2" in axes)
    assert all(title.endswith("]") for title in titles)


def test_logarithmic_scale(four_speed: Controller, road_test: RoadTest, results) -> None:
    drawn = leakage_over_temperature(temperature_curves(four_speed, road_test), EN, results, log_y=True)
    assert drawn.layout.yaxis.type == "log"


def test_gears_that_change_without_end_or_are_unknown_are_not_drawn(results) -> None:
    samples = len(results[0].time)
    unknown = np.where(np.arange(samples) < samples // 2, 2.0, np.nan)
    for gear, named in ((None, []), (np.arange(samples) % 2, []), (unknown, ["gear 2"])):
        assert [each.text for each in leakage_over_time(results, EN, gear).layout.annotations] == named
