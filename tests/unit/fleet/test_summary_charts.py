"""Charts of a fleet: what they draw of counts, spreads and differences, and what they leave to words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.analysis.rates import Rate, Spread
from atleak.common.style import LOOKS, OK_IN_PART
from atleak.common.verdicts import BANDS, FLAGGED, Band, Verdict
from atleak.common.wording import Wording, wording
from atleak.diagnosis.uncertainty import DECISIONS
from atleak.fleet.summary_charts import FleetCharts
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.sums import (
    Difference,
    Group,
    LandOverMileage,
    MileageClass,
    PairTrouble,
    TemperatureSums,
    VerdictCounts,
    WearDifference,
)
from atleak.report.charts.chart import Chart
from atleak.report.charts.figure import Figure
from atleak.report.charts.screen import drawn
from tests.unit.fleet.made_up import summary

SAY = wording("en")
US = wording("en", "us")
MADE = summary(units=4, lands=1)
BODY = MADE.bodies[0]
CHARTS = FleetCharts(FleetWords(MADE, SAY))
GREEN = LOOKS[Verdict.OK].screen
FEW = Spread(4, 21.0, 10.0, 20.0, 34.0, None)


def on_screen(chart: Chart, say: Wording = SAY) -> Figure:
    return drawn(chart, say)


def spread(median: float, units: int = 40) -> Spread:
    """Quantiles at 5, 25, 50, 75 and 95 % of the units that are 4 and 1 from the median."""
    return Spread(
        units, median + 0.5, median - 6, median, median + 7, tuple(median + each for each in (-4, -1, 0, 1, 4))
    )


def rate(count: int, of: int) -> Rate:
    return Rate(count, of, *((100.0 * count / of - 5.0, 100.0 * count / of + 6.0) if of >= 10 else (None, None)))


def counts(ok: int, watch: int, replaced: int, critical: int, unmeasured: int = 0, in_part: int = 0) -> VerdictCounts:
    verdicts = dict(zip(Verdict, (unmeasured, ok, watch, replaced, critical), strict=True))
    judged = ok + watch + replaced + critical
    past = {level: sum(n for each, n in verdicts.items() if each.rank >= level.rank) for level in FLAGGED}
    return VerdictCounts(
        units=judged + unmeasured,
        verdicts=verdicts,
        decisions=dict.fromkeys((*DECISIONS, None), 0),
        provisional=0,
        ok_in_part=in_part,
        rates={level: rate(past[level], judged) for level in FLAGGED},
    )


# --- verdicts


def test_bars_are_parts_of_the_units_and_say_how_many() -> None:
    rows = [("all", counts(30, 10, 8, 2)), ("north", counts(10, 0, 10, 0))]
    figure = on_screen(CHARTS.verdicts(rows)).checked()
    drawn = {trace.name: trace for trace in figure.data}
    assert list(drawn) == ["✖ critical", "■ replace", "▲ watch", "● ok"]
    assert list(drawn["■ replace"].x) == pytest.approx([16.0, 50.0], abs=1e-9)
    assert list(drawn["■ replace"].text) == ["8", "10"]
    assert [sum(trace.x[row] for trace in figure.data) for row in range(2)] == pytest.approx([100.0] * 2, abs=1e-9)
    assert drawn["✖ critical"].customdata[0] == "all<br>✖ critical: 2 of 50, 4.0 %"
    assert [note.text for note in figure.layout.annotations] == ["all", "north"]
    heights = [note.y for note in figure.layout.annotations]
    assert heights[0] - drawn["● ok"].y[0] == pytest.approx(heights[1] - drawn["● ok"].y[1], abs=1e-12)
    assert drawn["● ok"].y[0] > drawn["● ok"].y[1]


def test_nothing_unmeasured_is_green() -> None:
    figure = on_screen(CHARTS.verdicts([("all", counts(30, 0, 0, 0, unmeasured=10, in_part=30))])).checked()
    assert {trace.name: list(trace.x) for trace in figure.data} == {
        "● ok as far as measured": [75.0],
        "○ not measured": [25.0],
    }
    assert GREEN not in {trace.marker.color for trace in figure.data}
    assert figure.data[0].marker.color == OK_IN_PART.screen
    partly = on_screen(CHARTS.verdicts([("all", counts(30, 0, 0, 0, in_part=12))])).checked()
    assert {trace.marker.color: trace.x[0] for trace in partly.data} == {GREEN: 60.0, OK_IN_PART.screen: 40.0}


def test_no_unit_is_no_bar() -> None:
    assert on_screen(CHARTS.verdicts([("all", counts(0, 0, 0, 0))])).traces == []


# --- pairs


def test_pairs_have_both_rates_the_interval_of_the_worse_and_what_gave_the_verdict() -> None:
    many = PairTrouble(("25", 1), rate(40, 80), rate(20, 80), rate(8, 100), 20, 0)
    few = PairTrouble(("7", 2), rate(3, 5), rate(1, 5), rate(0, 100), 95, 0)
    figure = on_screen(CHARTS.pairs([many, few], ["25/1 valve", "7/2 damper"])).checked()
    flagged, replaced, deciding, beside = figure.data
    assert (flagged.name, replaced.name) == ("▲ watch or worse", "■ replace or worse")
    assert list(flagged.x) == [50.0, 60.0]
    assert list(replaced.x) == [25.0, 20.0]
    assert list(beside.text) == ["25.0 %, 20 of 80", "too few units: 1 of 5"]
    assert (list(replaced.error_x.array), list(replaced.error_x.arrayminus)) == ([6.0, 0.0], [5.0, 0.0])
    assert (
        replaced.customdata[0]
        == "25/1 valve<br>■ replace or worse: 20 of 80 (25.0\u00a0%, 95\u00a0% interval 20.0–31.0)"
    )
    assert replaced.customdata[1] == "7/2 damper<br>■ replace or worse: 1 of 5"
    assert (list(deciding.x), list(deciding.y)) == ([8.0], [flagged.y[0]])


# --- wear and temperatures


def land(*classes: tuple[float, float, Spread]) -> LandOverMileage:
    return LandOverMileage(("25", 1), tuple(MileageClass(*each) for each in classes), 0, 0, None)


def by_name(figure, row: str = "y") -> dict[str, object]:
    return {trace.name: trace for trace in figure.data if (trace.yaxis or "y") == row}


def test_wear_is_boxes_where_there_are_enough_units_and_lines_where_not() -> None:
    worn = land((0.0, 50e3, FEW), (50e3, 100e3, spread(30.0)), (150e3, 200e3, spread(50.0, 12)))
    figure = on_screen(CHARTS.wear(BODY, worn)).checked()
    wear, units = by_name(figure), by_name(figure, "y2")
    most, half = wear["nine of ten units"], wear["half of the units"]
    assert list(most.x) == [75e3, 175e3]
    assert (list(most.base), list(most.y)) == ([26.0, 46.0], [8.0, 8.0])
    assert (list(half.base), list(half.y)) == ([29.0, 49.0], [2.0, 2.0])
    assert max(half.width) < min(most.width) < 50e3
    few = wear["too few units: least to most"]
    assert (list(few.x), list(few.y)) == ([25e3, 25e3, None], [10.0, 34.0, None])
    median = wear["median"]
    assert (list(median.x), list(median.y)) == ([25e3, 75e3, 175e3], [20.0, 30.0, 50.0])
    assert list(median.marker.symbol) == ["circle-open", "circle", "circle"]
    assert "4 units: too few for more" in median.customdata[0]
    assert median.customdata[1].endswith(
        "nine of ten units: 26.0–34.0\u00a0%<br>half of the units: 29.0–31.0\u00a0%<br>40 units"
    )
    assert list(units["units"].y) == [4, 40, 12]


def test_mileage_and_pressure_are_in_the_readers_units() -> None:
    charts = FleetCharts(FleetWords(MADE, US))
    figure = on_screen(charts.wear(BODY, land((0.0, 80_467.2, spread(30.0)))), US).checked()
    assert by_name(figure)["median"].x[0] == pytest.approx(25_000.0, abs=1e-6)
    figure = on_screen(charts.temperatures([heat(80.0)]), US).checked()
    assert by_name(figure, "y2")["median"].y[0] == pytest.approx(500.0 / 6.894757, abs=1e-3)
    assert by_name(figure, "y2")["median"].x[0] == pytest.approx(180.5, abs=1e-9)


def heat(low: float, **other: object) -> TemperatureSums:
    made = TemperatureSums(
        low_c=low,
        high_c=low + 5.0,
        seconds=7200.0,
        share_mean_percent=21.0,
        share_percent=spread(20.0),
        share_max_percent=33.0,
        pressure_mean_kpa=510.0,
        pressure_kpa=spread(500.0),
        pressure_min_kpa=380.0,
        bands_percent=dict(zip(BANDS, (70.0, 20.0, 10.0, 0.0), strict=True)),
    )
    return replace(made, **other)  # type: ignore[arg-type]  # columns by name


def test_temperatures_have_shares_pressures_and_the_time_in_bands() -> None:
    figure = on_screen(CHARTS.temperatures([heat(80.0), heat(85.0, share_percent=None, share_mean_percent=None)]))
    share, pressure, bands = (by_name(figure.checked(), row) for row in ("y", "y2", "y3"))
    assert list(share["median"].x) == [82.5]
    assert (list(share["mean of all the time"].y), list(share["largest of any unit"].y)) == ([21.0], [33.0, 33.0])
    assert list(pressure["lowest of any unit"].y) == [380.0, 380.0]
    assert list(pressure["nine of ten units"].base) == [496.0, 496.0]
    assert [trace.y[0] for trace in bands.values()] == [70.0, 0.0, 20.0, 10.0, 0.0]
    assert [trace.base[0] for trace in bands.values()] == [0.0, 70.0, 70.0, 90.0, 100.0]
    assert bands[SAY.signed(Band.RED)].customdata[0] == "2.0 h of logs"
    assert not bands[SAY.signed(Band.CRITICAL)].showlegend


def test_time_of_units_that_were_measured_in_part_is_not_green() -> None:
    figure = on_screen(CHARTS.temperatures([heat(80.0, green_in_part_percent=70.0)])).checked()
    bands = by_name(figure, "y3")
    assert (bands["● green"].y[0], bands["● green"].showlegend) == (0.0, False)
    in_part = bands["● green as far as measured"]
    assert (in_part.y[0], in_part.base[0], in_part.marker.color) == (70.0, 0.0, OK_IN_PART.screen)
    assert {trace.marker.color for trace in bands.values() if trace.y[0]}.isdisjoint({GREEN})


def test_what_no_log_tells_takes_no_room() -> None:
    silent = {"share_percent": None, "share_mean_percent": None, "share_max_percent": None, "bands_percent": None}
    figure = on_screen(CHARTS.temperatures([heat(80.0, **silent)]))
    assert figure.rows == 2
    assert by_name(figure.checked())["median"].y[0] == 500.0
    assert figure.checked().layout.yaxis.title.text == "pressure [kPa]"


# --- groups


def test_groups_have_their_rates_with_intervals_and_words_where_they_are_too_few() -> None:
    groups = [Group("north", counts(60, 20, 15, 5), None, 0), Group("south", counts(3, 1, 2, 0), None, 0)]
    figure = on_screen(CHARTS.groups(groups)).checked()
    marks = {trace.name: trace for trace in figure.data if trace.mode == "markers"}
    assert [list(trace.x) for trace in marks.values()] == [[40.0], [20.0], [5.0]]
    assert list(marks["■ replace or worse"].error_x.array) == [6.0]
    words = next(trace for trace in figure.data if trace.mode == "text")
    assert list(words.text) == ["n = 100", "too few units: 2 of 6"]
    assert [note.text for note in figure.layout.annotations] == ["north", "south"]
    assert words.y[1] < marks["■ replace or worse"].y[0]


def test_differences_are_filled_where_one_is_called_and_left_out_without_an_interval() -> None:
    called = Difference(12.0, 9.0, 15.0, 7.0, 17.0)
    open_ = Difference(-2.0, -5.0, 1.0, -7.0, 3.0)
    few = Difference(40.0, None, None, None, None)

    def of(number: int, mean: Difference | None, same: Difference | None) -> WearDifference:
        return WearDifference("north", None, ("25", number), spread(30.0), spread(18.0), mean, 11.0, same)

    found = [of(1, called, open_), of(2, few, None), of(3, open_, called)]
    figure = on_screen(CHARTS.differences(BODY, found)).checked()
    mean, same = figure.data
    assert (list(mean.x), list(same.x)) == ([12.0, -2.0], [-2.0, 12.0])
    assert list(mean.marker.symbol) == ["circle", "circle-open"]
    assert list(same.marker.symbol) == ["diamond-open", "diamond"]
    assert (list(mean.error_x.array), list(mean.error_x.arrayminus)) == ([5.0, 5.0], [5.0, 5.0])
    said = "25/3 main pressure valve: north against all others<br>−2.0\u00a0(−7.0\u00a0…\u00a03.0)<br>in the mean"
    assert mean.customdata[1] == said
    first, second, third = (note.y for note in figure.layout.annotations)
    assert first > mean.y[0] > second > third > mean.y[1]
