"""Prepare the pictures of the source study as plain arrays, once, to be drawn by plotly and by matplotlib.

Every chart comes in the units people read (dm³/min, %, °C, s). Colours keep a contrast of 3:1 or more on white and on
near-black; dash and symbol distinguish the lines without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from atleak.engine.extremes import Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.look import CURVES
from atleak.thinning import thinned
from atleak.variants.run import TemperatureCurve, VariantResult
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, PERCENT

MOST_POINTS = 2000  # that a line may have before it is thinned

Dash = Literal["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"]
Symbol = Literal["circle", "square", "diamond", "cross", "x", "star", "triangle-up", "triangle-down", "hexagon"]
Panel = Literal["upper", "lower"]


@dataclass(frozen=True)
class Line:
    """One line, or one set of points where ``dash`` is None."""

    name: str
    x: np.ndarray
    y: np.ndarray
    color: str
    dash: Dash | None = "solid"
    symbol: Symbol | None = None  # None: no markers
    filled: bool = True
    panel: Panel = "lower"
    width: float = 1.8
    text: tuple[str, ...] = ()  # beside each point
    in_legend: bool = True
    group: str = ""  # shown and hidden together in a legend


@dataclass(frozen=True)
class Mark:
    """An instant marked by a vertical line, which its text and dash distinguish, not its colour alone."""

    x: float
    text: str
    color: str
    dash: Dash


@dataclass(frozen=True)
class _Point:
    """A named instant, with its marker and the value drawn there."""

    word: str
    symbol: Symbol
    instant: Instant
    value: float


@dataclass(frozen=True)
class Chart:
    """A picture before it is drawn. An upper panel exists where a line asks for it; both share x."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    upper_label: str = ""
    marks: tuple[Mark, ...] = ()
    spans: tuple[tuple[float, float, str], ...] = ()  # (from x, to x, text), such as the gears
    description: str = ""  # for people who cannot see the picture
    log_y: bool = False

    @property
    def has_upper(self) -> bool:
        """Return whether a line asks for the upper panel."""
        return any(line.panel == "upper" for line in self.lines)


_STYLE: dict[str, tuple[str, Dash, Symbol]] = {
    "W1": (CURVES["blue"], "solid", "circle"),
    "W2": (CURVES["green"], "dash", "square"),
    "W3": (CURVES["ochre"], "dot", "diamond"),
    "W4": (CURVES["red"], "solid", "triangle-up"),
    "W5": (CURVES["grey"], "dashdot", "x"),
    "W6": (CURVES["teal"], "longdash", "cross"),
    "W7": (CURVES["violet"], "longdashdot", "hexagon"),
    "W8": (CURVES["rust"], "dash", "star"),
}
_PUMP, _LEAST, _MOST = CURVES["slate"], CURVES["green"], CURVES["red"]
_MODEL_STYLE: dict[str, tuple[str, Dash]] = {
    "tabulated": (CURVES["blue"], "solid"),
    "regression": (CURVES["ochre"], "dot"),
    "d341": (CURVES["red"], "dash"),
}


def leakage_chart(results: Sequence[VariantResult], say: Wording, gear: np.ndarray | None = None) -> Chart:
    """Prepare the leakage of every variant and pump flow over time (the article's Figure 13).

    ``gear`` is the road test's, shape (samples,). The marks are the instants of least and most leakage of the variant
    that leaks most; triangles show each variant's own.
    """
    lines = []
    first = results[0]
    if first.computed.pump_capacity is not None:
        x, y = _course(first.time, first.computed.pump_capacity * DM3_MIN)
        lines.append(Line(say("study.pump_capacity"), x, y, _PUMP, "solid", panel="upper"))
    for result in results:
        run = result.computed
        points = (
            _Point(say("study.least"), "triangle-down", run.min_leakage, run.min_leakage.leakage * DM3_MIN),
            _Point(say("study.most"), "triangle-up", run.max_leakage, run.max_leakage.leakage * DM3_MIN),
        )
        lines += _variant_lines(result, run.leakage * DM3_MIN, points, say)
    leading = max(results, key=lambda result: result.computed.max_leakage.leakage).computed
    least, most = leading.min_leakage.time, leading.max_leakage.time
    return Chart(
        title=say("study.title_time"),
        x_label=say("study.axis_time"),
        y_label=say("study.axis_leakage"),
        upper_label=say("study.axis_pump"),
        lines=tuple(lines),
        marks=(
            Mark(least, say("study.least_leakage", time=say.plain(least)), _LEAST, "dash"),
            Mark(most, say("study.most_leakage", time=say.plain(most)), _MOST, "dot"),
        ),
        spans=gear_spans(first.time, say, gear),
        description="; ".join(
            [
                say("study.about_time"),
                *(
                    say(
                        "study.variant_between",
                        variant=result.variant.name,
                        low=say.plain(result.computed.min_leakage.leakage * DM3_MIN, 3),
                        high=say.plain(result.computed.max_leakage.leakage * DM3_MIN, 3),
                    )
                    for result in results
                ),
            ]
        ),
    )


def share_chart(results: Sequence[VariantResult], say: Wording, gear: np.ndarray | None = None) -> Chart:
    """Prepare the leakage share of every variant over time: largest at idle, not at the instant of most leakage.

    Raises
    ------
    ValueError
        where the road test has no engine speed and so no share.
    """
    lines: list[Line] = []
    drawn: list[tuple[RoadLeakage, _Point]] = []
    summaries: list[str] = []
    for result in results:
        run = result.computed
        share, worst, most = run.share, run.max_share, run.max_leakage
        if share is None or worst is None or worst.share is None or most.share is None:
            raise ValueError("a road test without engine speed has no leakage share")
        largest = _Point(say("study.largest"), "circle", worst, worst.share * PERCENT)
        at_most = _Point(say("study.leaks_most"), "triangle-up", most, most.share * PERCENT)
        lines += _variant_lines(result, share * PERCENT, (largest, at_most), say)
        drawn.append((run, largest))
        summaries.append(
            say(
                "study.variant_share",
                variant=result.variant.name,
                largest=say.plain(largest.value, 3),
                at_most=say.plain(at_most.value, 3),
            )
        )
    leading, largest = max(drawn, key=lambda pair: pair[0].max_leakage.leakage)
    worst_time, most_time = largest.instant.time, leading.max_leakage.time
    return Chart(
        title=say("study.title_share"),
        x_label=say("study.axis_time"),
        y_label=say("study.axis_share"),
        lines=tuple(lines),
        marks=(
            Mark(worst_time, say("study.largest_share", time=say.plain(worst_time)), _MOST, "dash"),
            Mark(most_time, say("study.most_leakage", time=say.plain(most_time)), _LEAST, "dot"),
        ),
        spans=gear_spans(leading.time, say, gear),
        description="; ".join([say("study.about_share"), *summaries]),
    )


def temperature_chart(
    curves: Sequence[TemperatureCurve],
    say: Wording,
    results: Sequence[VariantResult] = (),
    *,
    wear: float = 0.5,
    printed: bool = True,
    log_y: bool = False,
) -> Chart:
    """Prepare the largest leakage against temperature at one wear (the article's Figure 14), by viscosity model.

    ``results`` adds the variants of that wear as computed and, where ``printed``, as Table 3 prints them.
    """
    lines = []
    for curve in curves:
        color, dash = _MODEL_STYLE[curve.model]
        lines.append(
            Line(say.get("study_words", curve.label), curve.temperature, curve.max_leakage * DM3_MIN, color, dash)
        )
    of_wear = sorted(
        (result for result in results if result.variant.wear == wear), key=lambda result: result.variant.temperature
    )
    if of_wear:
        at = np.array([result.variant.temperature for result in of_wear])
        names = tuple(result.variant.name for result in of_wear)
        if printed:
            values = np.array([float(result.variant.printed_max_leakage) for result in of_wear])
            lines.append(Line(say("study.table_3"), at, values, CURVES["grey"], None, "square", filled=False))
        values = np.array([result.computed.max_leakage.leakage * DM3_MIN for result in of_wear])
        lines.append(Line(say("study.computed"), at, values, CURVES["blue"], None, "circle", text=names))
    return Chart(
        title=say("study.title_temperature", wear=say.percent(wear, 0)),
        x_label=say("study.axis_temperature"),
        y_label=say("study.axis_most"),
        lines=tuple(lines),
        description="; ".join(
            say(
                "study.curve_at",
                curve=say.get("study_words", curve.label),
                warm=say.plain(_value_at(curve, 40.0), 3),
                hot=say.plain(_value_at(curve, 100.0), 3),
            )
            for curve in curves
        ),
        log_y=log_y,
    )


def _variant_lines(result: VariantResult, values: np.ndarray, points: Sequence[_Point], say: Wording) -> list[Line]:
    """Return a variant over time, and its points."""
    name, (color, dash, _) = result.variant.name, _STYLE[result.variant.name]
    x, y = _course(result.time, values, keep=[_index(result.time, point.instant) for point in points])
    lines = [Line(variant_label(result, say), x, y, color, dash, group=name)]
    for point in points:
        at = np.array([point.instant.time]), np.array([point.value])
        lines.append(Line(f"{name} {point.word}", *at, color, None, point.symbol, group=name, in_legend=False))
    return lines


def variant_label(result: VariantResult, say: Wording) -> str:
    """Return a label such as ``W4: 80 °C, +50 %``; fresh oil and no wear are not mentioned."""
    variant = result.variant
    oil = f", {say('study.used_oil')}" if variant.used_oil and not variant.wear else ""
    worn = f", +{say.plain(variant.wear * PERCENT)} %" if variant.wear else ""
    return f"{variant.name}: {say.plain(variant.temperature)} °C{oil}{worn}"


def gear_spans(time: np.ndarray, say: Wording, gear: np.ndarray | None) -> tuple[tuple[float, float, str], ...]:
    """Return the stretches in one gear as (from, to, text); empty without a gear channel or with over 40 stretches."""
    if gear is None or not len(time):
        return ()
    known = np.nan_to_num(gear, nan=np.inf)  # one stretch without a gear is one stretch
    edges = np.flatnonzero(known[1:] != known[:-1]) + 1
    starts, stops = [0, *edges.tolist()], [*edges.tolist(), len(time) - 1]
    if len(starts) > 40:
        return ()
    return tuple(
        (float(time[start]), float(time[stop]), say("study.gear", gear=f"{gear[start]:g}"))
        for start, stop in zip(starts, stops, strict=True)
        if np.isfinite(gear[start])
    )


def _course(x: np.ndarray, y: np.ndarray, keep: Sequence[int] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Choose the points of a line that are drawn."""
    index = thinned([y], MOST_POINTS, keep)
    return x[index], y[index]


def _index(time: np.ndarray, instant: Instant) -> int:
    return int(np.argmin(np.abs(time - instant.time)))


def _value_at(curve: TemperatureCurve, temperature: float) -> float:
    return float(np.interp(temperature, curve.temperature, curve.max_leakage)) * DM3_MIN
