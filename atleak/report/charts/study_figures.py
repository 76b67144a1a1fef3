"""Draw studies on the screen: the source study's variants over time and temperature, and a gauge study.

The source study has the article's units (dm³/min, %, °C, s). Dash and symbol tell lines apart without their colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from atleak.analysis.gauge_study import ACCEPTED, MARGINAL, GaugeStudy
from atleak.analysis.source_study import CURVES_WEAR, TemperatureCurve, VariantResult
from atleak.common.style import AS_NEW, CURVES, FAINT_GRID, SCREEN, Look, look_of
from atleak.common.units import DM3_MIN, PERCENT, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.engine.extremes import Instant
from atleak.measurements.road_test import thinned
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.charts.figure import Figure, framed

MOST_POINTS = 2000  # that a line may have before it is thinned
_MOST_GEARS = 40  # stretches in one gear that are named
_HEIGHT, _UPPER = 520, 0.28
_LOOKS = {
    "W1": (CURVES["blue"], "solid"),
    "W2": (CURVES["green"], "dash"),
    "W3": (CURVES["ochre"], "dot"),
    "W4": (CURVES["red"], "solid"),
    "W5": (CURVES["grey"], "dashdot"),
    "W6": (CURVES["teal"], "longdash"),
    "W7": (CURVES["violet"], "longdashdot"),
    "W8": (CURVES["rust"], "dash"),
}
_MODEL_LOOKS = {
    "tabulated": (CURVES["blue"], "solid"),
    "regression": (CURVES["ochre"], "dot"),
    "d341": (CURVES["red"], "dash"),
}


class _Point(NamedTuple):
    """A named instant, with its symbol and the value drawn there."""

    word: str
    symbol: str
    instant: Instant
    value: float


def leakage_over_time(results: Sequence[VariantResult], say: Wording, gear: np.ndarray | None = None) -> Figure:
    """Draw the leakage of every variant and pump flow over time (the article's Figure 13).

    ``gear`` is the road test's, shape (samples,). Upright lines are the instants of least and most leakage of the
    variant that leaks most; triangles show each variant's own.
    """
    first, pump = results[0], results[0].computed.pump_capacity
    drawn = Figure() if pump is None else Figure(2, 0.06, [_UPPER, 1.0 - _UPPER])
    if pump is not None:
        _line(drawn, say("study.pump_capacity"), *_course(first.time, pump * DM3_MIN), CURVES["slate"], "solid", row=1)
        drawn.update_yaxes(title=say("study.axis_pump"), row=1)
    for result in results:
        run = result.computed
        least, most = run.min_leakage, run.max_leakage
        points = (
            _Point(say("study.least"), "triangle-down", least, least.leakage * DM3_MIN),
            _Point(say("study.most"), "triangle-up", most, most.leakage * DM3_MIN),
        )
        _variant(drawn, result, run.leakage * DM3_MIN, points, say)
    leading = max(results, key=lambda result: result.computed.max_leakage.leakage).computed
    _instant(drawn, leading.min_leakage, "least_leakage", CURVES["green"], "dash", say)
    _instant(drawn, leading.max_leakage, "most_leakage", CURVES["red"], "dot", say)
    _gears(drawn, first.time, gear, say)
    return _laid_out(drawn, say("study.axis_time"), say("study.axis_leakage"))


def share_over_time(results: Sequence[VariantResult], say: Wording, gear: np.ndarray | None = None) -> Figure:
    """Draw the leakage share of every variant over time: largest at idle, not at the instant of most leakage.

    Raises
    ------
    ValueError
        where the road test has no engine speed and so no share.
    """
    drawn, largest = Figure(), []
    for result in results:
        run = result.computed
        worst, most = run.max_share, run.max_leakage
        if run.share is None or worst is None or worst.share is None or most.share is None:
            raise ValueError("a road test without engine speed has no leakage share")
        points = (
            _Point(say("study.largest"), "circle", worst, worst.share * PERCENT),
            _Point(say("study.leaks_most"), "triangle-up", most, most.share * PERCENT),
        )
        _variant(drawn, result, run.share * PERCENT, points, say)
        largest.append((most.leakage, worst, most))
    _, worst, most = max(largest, key=lambda each: each[0])
    _instant(drawn, worst, "largest_share", CURVES["red"], "dash", say)
    _instant(drawn, most, "most_leakage", CURVES["green"], "dot", say)
    _gears(drawn, results[0].time, gear, say)
    return _laid_out(drawn, say("study.axis_time"), say("study.axis_share"))


def leakage_over_temperature(
    curves: Sequence[TemperatureCurve],
    say: Wording,
    results: Sequence[VariantResult] = (),
    *,
    printed: bool = True,
    log_y: bool = False,
) -> Figure:
    """Draw the largest leakage against temperature at one wear (the article's Figure 14), by viscosity model.

    ``results`` adds the variants of that wear as computed and, where ``printed``, as Table 3 prints them.
    """
    drawn = Figure()
    for curve in curves:
        name = say.get("study_words", curve.label)
        _line(drawn, name, curve.temperature, curve.max_leakage * DM3_MIN, *_MODEL_LOOKS[curve.model])
    of_wear = sorted(
        (result for result in results if result.variant.wear == CURVES_WEAR),
        key=lambda result: result.variant.temperature,
    )
    at, names = [each.variant.temperature for each in of_wear], [each.variant.name for each in of_wear]
    if of_wear and printed:
        values = [float(each.variant.printed_max_leakage) for each in of_wear]
        _points(drawn, say("study.table_3"), at, values, CURVES["grey"], "square-open")
    if of_wear:
        values = [each.computed.max_leakage.leakage * DM3_MIN for each in of_wear]
        words = {"text": names, "textposition": "top center"}
        _points(drawn, say("study.computed"), at, values, CURVES["blue"], "circle", **words)
    return _laid_out(drawn, say("study.axis_temperature"), say("study.axis_most"), log_y=log_y)


def _variant(drawn: Figure, result: VariantResult, values: np.ndarray, points: Sequence[_Point], say: Wording) -> None:
    """Draw a variant over time, and its points."""
    name, (colour, dash) = result.variant.name, _LOOKS[result.variant.name]
    keep = [int(np.argmin(np.abs(result.time - point.instant.time))) for point in points]
    x, y = _course(result.time, values, keep)
    _line(drawn, variant_label(result, say), x, y, colour, dash, legendgroup=name)
    for point in points:
        legend = {"legendgroup": name, "showlegend": False}
        _points(drawn, f"{name} {point.word}", [point.instant.time], [point.value], colour, point.symbol, **legend)


def _line(
    drawn: Figure,
    name: str,
    x: np.ndarray,
    y: np.ndarray,
    colour: str,
    dash: str,
    row: int | None = None,
    **more: Any,
) -> None:
    at = drawn.rows if row is None else row
    hover = f"{name}<br>%{{x:.4g}}: %{{y:.4g}}"
    drawn.line(x, y, colour, 1.8, dash, name=name, hover=hover, connectgaps=False, row=at, **more)


def _points(
    drawn: Figure, name: str, x: Sequence[float], y: Sequence[float], colour: str, symbol: str, **more: Any
) -> None:
    look = (colour, symbol, 13, 2.0) if symbol.endswith("-open") else (colour, symbol, 9, 0.0)
    hover = f"{name}<br>%{{x:.4g}}: %{{y:.4g}}"
    drawn.marks(y, x, name, look, upright=True, cliponaxis=False, hover=hover, row=drawn.rows, **more)


def variant_label(result: VariantResult, say: Wording) -> str:
    """Return a label such as ``W4: 80 °C, +50 %``; fresh oil and no wear are not mentioned."""
    variant = result.variant
    oil = f", {say('study.used_oil')}" if variant.used_oil and not variant.wear else ""
    worn = f", +{say.plain(variant.wear * PERCENT)} %" if variant.wear else ""
    return f"{variant.name}: {say.plain(variant.temperature)} °C{oil}{worn}"


def _instant(drawn: Figure, instant: Instant, word: str, colour: str, dash: str, say: Wording) -> None:
    """Draw an instant as an upright line, and name it in the legend."""
    line = {"color": colour, "dash": dash, "width": 1.5}
    drawn.add_vline(instant.time, line)
    name = say(f"study.{word}", time=say.plain(instant.time))
    drawn.add_scatter(drawn.rows, x=[None], y=[None], mode="lines", name=name, line=line)


def _gears(drawn: Figure, time: np.ndarray, gear: np.ndarray | None, say: Wording) -> None:
    """Name the stretches in one gear above the figure; none without a gear channel, or where they are too many."""
    if gear is None or not len(time):
        return
    known = np.nan_to_num(gear, nan=np.inf)  # one stretch without a gear is one stretch
    edges = np.flatnonzero(known[1:] != known[:-1]) + 1
    starts, stops = [0, *edges.tolist()], [*edges.tolist(), len(time) - 1]
    spans = [each for each in zip(starts, stops, strict=True) if np.isfinite(gear[each[0]])]
    if len(starts) > _MOST_GEARS:
        return
    for number, (start, stop) in enumerate(spans):
        place = {"x": 0.5 * float(time[start] + time[stop]), "y": 1.0, "xref": "x", "yref": "paper"}
        drawn.add_annotation(
            **place, yanchor="bottom", text=say("study.gear", gear=f"{gear[start]:g}"), font={"size": 12}
        )
        if number:
            drawn.add_vline(float(time[start]), {"color": "rgba(128,128,128,0.5)", "width": 1, "dash": "dot"})


def _laid_out(drawn: Figure, x_title: str, y_title: str, *, log_y: bool = False) -> Figure:
    framed(drawn, _HEIGHT + 140 * (drawn.rows - 1), 30)
    legend = {"orientation": "h", "yref": "container", "yanchor": "bottom", "y": 0.0, "x": 0.0}
    drawn.update_layout(legend=legend | {"groupclick": "togglegroup"})
    drawn.update_xaxes(gridcolor=FAINT_GRID)
    drawn.update_yaxes(gridcolor=FAINT_GRID, zeroline=True, zerolinecolor=FAINT_GRID)
    drawn.update_xaxes(title=x_title, row=drawn.rows)
    drawn.update_yaxes(type="log" if log_y else None, rangemode=None if log_y else "tozero")
    drawn.update_yaxes(title=y_title, row=drawn.rows)
    return drawn


def _course(x: np.ndarray, y: np.ndarray, keep: Sequence[int] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Choose the points of a line that are drawn."""
    index = thinned([y], MOST_POINTS, keep)
    return x[index], y[index]


_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "triangle-down", "pentagon")
_BARS = ("grr", "repeatability", "reproducibility", "part")


def by_part_and_operator(study: GaugeStudy, say: Wording) -> Figure:
    """Draw how far every reading is from the mean of its part [µm], one series for each operator.

    Readings of several parts differ by more than any gauge: from their part's own mean, people and repeats show.
    """
    readings = study.readings
    apart = (readings.values - readings.values.mean(axis=(1, 2), keepdims=True)) * UM
    figure = Figure()
    colours = list(CURVES.values())
    count = len(readings.operators)
    for number, operator in enumerate(readings.operators):
        colour, beside = colours[number % len(colours)], (number - (count - 1) / 2) * 0.6 / count
        places = [place + beside for place in range(len(readings.parts))]
        own, each = apart[:, number], [place for place in places for _ in range(readings.trials)]
        mark = (colour, _SYMBOLS[number % len(_SYMBOLS)], 8, 0.0)
        figure.marks(
            own.ravel(), each, operator, mark, upright=True, legendgroup=operator, opacity=0.75, hover="%{y:.2f} µm"
        )
        figure.line(places, own.mean(axis=1), colour, 1.5, legendgroup=operator)
    figure.add_hline(y=0.0, line={"color": SCREEN.rule, "width": 1})
    figure.update_xaxes(
        title=say("gauge_study_names.part"), tickvals=list(range(len(readings.parts))), ticktext=list(readings.parts)
    )
    figure.update_yaxes(title=f"{say('gauge_study.from_mean')} [µm]")
    return framed(figure, 380, 56)


def component_chart(study: GaugeStudy, say: Wording) -> RowChart:
    """Return the components as shares of the study's variation, and of the tolerance where there is one [%].

    Marks are the bounds within which a gauge is good, or usable for some purposes.
    """
    names = [say(f"gauge_study_names.{component}") for component in _BARS]
    both = [("of_study", replace(AS_NEW, screen=CURVES["blue"]))]
    if study.tolerance is not None:
        both.append(("of_tolerance", replace(AS_NEW, screen=CURVES["ochre"], pattern="/")))

    def bars(number: int, name: str, look: Look) -> LayerOf:
        values = [(getattr(study.of(component), name) or 0.0) * PERCENT for component in _BARS]
        named = say(f"gauge_study.{name}")
        hover = [f"{row}: {say.number(value, 1)} % {named}" for row, value in zip(names, values, strict=True)]
        lift = 0.0 if len(both) == 1 else 0.22 - 0.44 * number
        return named, look, values, {"hover": hover, "thick": 0.8 / len(both), "lift": lift}

    def bound(key: str, level: Verdict, share: float) -> LayerOf:
        of_gauge = [share * PERCENT if component == "grr" else None for component in _BARS]
        return say(f"gauge_study.{key}"), look_of(level), of_gauge, {}

    bounds = bound("marginal", Verdict.WATCH, ACCEPTED), bound("refused", Verdict.REPLACE, MARGINAL)
    layers = (*(bars(number, *each) for number, each in enumerate(both)), *bounds)
    return RowChart(names, layers_of(layers), "%")
