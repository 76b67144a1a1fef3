"""Results → plotly figures: transparent, units on the axes, signs and dashes besides colour, few points a trace.

Nothing is computed here but what a picture needs. Figures are tested by their trace data.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots
from tsdownsample import MinMaxDownsampler

from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.events import Event
from atleak.limits import Limits
from atleak.report.road_series import RoadSeries, road_series
from atleak.report.text import SYMBOLS, WORDS
from atleak.report.window import Scales
from atleak.road_leakage import RoadLeakage
from atleak.road_test import QUANTITIES, Channel, RoadTest
from atleak.workshop_units import DM3_MIN, PERCENT, UM

POINTS = 3000  # of a log that are drawn, edges of gaps aside
EVENTS = 60  # of a log that are marked at most
LABELLED = 20  # events whose names have room
MARKED = 800  # suspect samples and breaks of a log that are marked at most
COLOURS = {
    "ok": "#2f9e62",
    "watch": "#e8a317",
    "replace": "#d1383d",
    "critical": "#a3278f",
    "not_measured": "#8793a0",
}
BAND_COLOURS = {
    "green": COLOURS["ok"],
    "amber": COLOURS["watch"],
    "red": COLOURS["replace"],
    "critical": COLOURS["critical"],
}
BAND_SYMBOLS = {"green": "●", "amber": "▲", "red": "■", "critical": "✖"}
PATTERNS = {"ok": "", "watch": "/", "replace": "x", "critical": "+", "not_measured": "."}
_HATCH = {"fillmode": "overlay", "fgcolor": "rgba(255,255,255,0.7)", "size": 7, "solidity": 0.2}
LEAKAGE, PUMP, SHARE, ERROR = "#2a86d1", "#8793a0", "#e07b00", "#7b8794"
_INSTANTS = {
    "max_leakage": ("largest leakage", "diamond", "leakage_dm3_min"),
    "min_leakage": ("smallest leakage", "diamond-open", "leakage_dm3_min"),
    "max_share": ("largest share", "star", "share_percent"),
}


def _dressed(figure: go.Figure, height: int, top: int = 32, **layout: object) -> go.Figure:
    figure.update_layout(
        height=height,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        margin={"l": 8, "r": 8, "t": top, "b": 8},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "xanchor": "left"},
        **layout,
    )
    figure.update_xaxes(automargin=True, zeroline=False)
    figure.update_yaxes(automargin=True, zeroline=False)
    return figure


def land_name(found: LandDiagnosis) -> str:
    """``25 · 1``: component and land."""
    return f"{found.state.land.component} · {found.state.land.land}"


def leakage_ranking(diagnosis: Diagnosis, lands: int = 20) -> go.Figure:
    """Lands by leakage at the stated condition, the largest on top, by verdict, with 95 % intervals.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    ranked = diagnosis.ranked[:lands]
    figure = go.Figure()
    for verdict in COLOURS:
        found = [land for land in ranked if land.verdict == verdict]
        if not found:
            continue
        figure.add_bar(
            x=[land.leakage * DM3_MIN for land in found],
            y=[land_name(land) for land in found],
            orientation="h",
            name=f"{SYMBOLS[verdict]} {WORDS[verdict]}",
            marker={"color": COLOURS[verdict], "pattern": _HATCH | {"shape": PATTERNS[verdict]}},
            error_x=_errors([(land.leakage, _interval(land)) for land in found], DM3_MIN),
            customdata=[
                (
                    diagnosis.controller.components[land.state.land.component],
                    land.state.radial_clearance * UM,
                    land.share * PERCENT,
                )
                for land in found
            ],
            hovertemplate="%{y} %{customdata[0]}<br>%{x:.3f} dm³/min, %{customdata[2]:.2f} % of pump flow"
            "<br>radial clearance %{customdata[1]:.1f} µm<extra></extra>",
        )
    figure.add_scatter(
        x=[max(land.leakage, *(_interval(land) or (0.0,))) * DM3_MIN for land in ranked],
        y=[land_name(land) for land in ranked],
        mode="text",
        text=[f"  {SYMBOLS[land.verdict]} {land.share * PERCENT:.2f} %" for land in ranked],
        textposition="middle right",
        cliponaxis=False,
        showlegend=False,
        hoverinfo="skip",
    )
    order = [land_name(land) for land in reversed(ranked)]
    largest = max((max(land.leakage, *(_interval(land) or (0.0,))) * DM3_MIN for land in ranked), default=0.0)
    figure.update_xaxes(title="leakage [dm³/min]", range=[0.0, 1.25 * largest or 1.0])
    figure.update_yaxes(title="component · land", type="category", categoryorder="array", categoryarray=order)
    return _dressed(figure, 110 + 22 * max(len(ranked), 3), bargap=0.25)


def _interval(land: LandDiagnosis) -> tuple[float, float] | None:
    return land.uncertainty.leakage_interval if land.uncertainty else None


def _errors(values: list[tuple[float, tuple[float, float] | None]], factor: float) -> dict[str, Any] | None:
    """Asymmetric error bars from values and their intervals; None where nothing has an interval."""
    if all(interval is None for _, interval in values):
        return None
    ends = [(value, value) if interval is None else interval for value, interval in values]
    return {
        "type": "data",
        "symmetric": False,
        "array": [(high - value) * factor for (value, _), (_, high) in zip(values, ends, strict=True)],
        "arrayminus": [(value - low) * factor for (value, _), (low, _) in zip(values, ends, strict=True)],
        "color": ERROR,
        "thickness": 1.5,
        "width": 4,
    }


def total_share(diagnosis: Diagnosis) -> go.Figure:
    """Total share at each condition and the worst of the road test, over the bands of the limit set.

    Bars are the 95 % intervals of the measurement, where readings are there.
    """
    points = [(point.condition.label, point.share * PERCENT) for point in diagnosis.projections]
    worst = diagnosis.road.max_share if diagnosis.road else None
    if worst is not None and worst.share is not None:
        points.append((f"worst of the road test, at {worst.time:.1f} s", worst.share * PERCENT))
    unit = diagnosis.uncertainty
    sure = [unit.total(point.condition.name) if unit else None for point in diagnosis.projections]
    intervals = [total.share_interval if total else None for total in sure]
    intervals += [None] * (len(points) - len(intervals))
    spread = [(share / PERCENT, interval) for (_, share), interval in zip(points, intervals, strict=True)]
    finite = [share for _, share in points if math.isfinite(share)]
    edges = [0.0, *(level * PERCENT for _, level in diagnosis.limits.total_share.levels)]
    right = max(1.2 * edges[-1], 1.1 * max(finite, default=0.0))
    figure = go.Figure()
    names = ["green", *(name for name, _ in diagnosis.limits.total_share.levels)]
    for name, low, high in zip(names, edges, [*edges[1:], right], strict=True):
        figure.add_vrect(x0=low, x1=high, fillcolor=BAND_COLOURS[name], opacity=0.28, line_width=0, layer="below")
        figure.add_annotation(
            x=(low + high) / 2.0, y=1.0, yref="paper", yanchor="bottom", showarrow=False,
            text=f"{BAND_SYMBOLS[name]}<br>{name}", font={"size": 11},
        )  # fmt: skip
    figure.add_scatter(
        x=[share if math.isfinite(share) else None for _, share in points],
        y=[label.replace(", ", ",<br>") for label, _ in points],
        mode="markers+text",
        marker={"symbol": "diamond", "size": 14, "color": LEAKAGE, "line": {"width": 1.5, "color": "white"}},
        text=[f"<b>{share:.1f} %</b>" if math.isfinite(share) else "" for _, share in points],
        textposition="top center",
        error_x=_errors(spread, PERCENT) if all(math.isfinite(share) for share, _ in spread) else None,
        hovertemplate="%{y}: %{x:.2f} %<extra></extra>",
        showlegend=False,
    )
    figure.update_xaxes(title="leakage as a share of the pump's flow [%]", range=[0.0, right])
    figure.update_yaxes(type="category", range=[len(points) - 0.4, -0.8])
    return _dressed(figure, 100 + 56 * len(points), top=40)


def road_leakage(road: RoadLeakage, limits: Limits, points: int = POINTS) -> go.Figure:
    """Leakage, pump flow and share with the edges of its bands over a log, one above the other.

    Without a logged engine speed there is no pump flow and no share, and only leakage is drawn.
    """
    series = road_series(road, points)
    with_share = "share_percent" in series.columns
    figure = make_subplots(rows=3 if with_share else 1, cols=1, shared_xaxes=True, vertical_spacing=0.06)
    _line(figure, series, "leakage_dm3_min", "leakage", LEAKAGE, 1)
    if with_share:
        _line(figure, series, "pump_capacity_dm3_min", "pump flow", PUMP, 2, dash="dash")
        _line(figure, series, "share_percent", "share", SHARE, 3, dash="dashdot")
        _band_edges(figure, limits, float(np.nanmax(series.columns["share_percent"], initial=0.0)))
        figure.update_yaxes(title="pump flow<br>[dm³/min]", row=2, col=1)
        figure.update_yaxes(title="share [%]", row=3, col=1)
    _instants(figure, series)
    figure.update_yaxes(title="leakage<br>[dm³/min]", row=1, col=1)
    figure.update_yaxes(rangemode="tozero")
    figure.update_xaxes(title="time [s]", row=3 if with_share else 1, col=1)
    return _dressed(figure, 620 if with_share else 320, hovermode="x unified")


def _line(
    figure: go.Figure, series: RoadSeries, name: str, label: str, colour: str, row: int, dash: str = "solid"
) -> None:
    figure.add_trace(
        go.Scatter(
            x=series.columns["time_s"],
            y=series.columns[name],
            name=label,
            mode="lines",
            line={"color": colour, "dash": dash, "width": 2},
            connectgaps=False,
            hovertemplate="%{y:.2f}",
        ),
        row=row,
        col=1,
    )


def _band_edges(figure: go.Figure, limits: Limits, top: float) -> None:
    """The edges of the bands that the log comes near, so that a low curve is not squeezed by a high limit."""
    for number, (name, level) in enumerate(limits.total_share.levels):
        edge = level * PERCENT
        if number and edge > 1.5 * top:
            break
        figure.add_hline(
            y=edge, line={"color": BAND_COLOURS[name], "dash": "dot", "width": 1.5}, row=3, col=1,
            annotation={"text": f"{name} from {edge:g} %", "font": {"size": 11}}, annotation_position="top right",
        )  # fmt: skip


def _instants(figure: go.Figure, series: RoadSeries) -> None:
    for name, instant in series.instants.items():
        label, symbol, column = _INSTANTS[name]
        share = column == "share_percent"
        value = instant.share if share else instant.leakage
        if value is None:
            continue
        figure.add_trace(
            go.Scatter(
                x=[instant.time],
                y=[value * (PERCENT if share else DM3_MIN)],
                name=f"{label}, {instant.time:.2f} s",
                mode="markers",
                marker={"symbol": symbol, "size": 12, "color": SHARE if share else LEAKAGE, "line": {"width": 1.5}},
                hovertemplate="%{y:.2f}",
            ),
            row=3 if share else 1,
            col=1,
        )


def wear(diagnosis: Diagnosis, lands: Sequence[LandDiagnosis] | None = None) -> go.Figure:
    """Wear of every measured land against the limits of the set, the most worn on top."""
    chosen = diagnosis.lands if lands is None else lands
    found = sorted((land for land in chosen if land.wear is not None), key=lambda land: land.wear)
    figure = go.Figure()
    for verdict in COLOURS:
        these = [land for land in found if land.verdict == verdict]
        if these:
            figure.add_scatter(
                x=[land.wear * PERCENT for land in these],
                y=[land_name(land) for land in these],
                mode="markers",
                name=f"{SYMBOLS[verdict]} {WORDS[verdict]}",
                marker={"color": COLOURS[verdict], "symbol": _MARKERS[verdict], "size": 11},
                hovertemplate="%{y}: %{x:.1f} %<extra></extra>",
            )
    for name, level in diagnosis.limits.wear.levels if diagnosis.limits.wear else ():
        figure.add_vline(
            x=level * PERCENT, line={"color": COLOURS[name], "dash": "dot"},
            annotation={"text": f"{name} {level * PERCENT:g} %"},
        )  # fmt: skip
    order = [land_name(land) for land in found]
    figure.update_xaxes(title="wear against the mounting clearance [%]")
    figure.update_yaxes(title="component · land", type="category", categoryorder="array", categoryarray=order)
    return _dressed(figure, 120 + 18 * max(len(found), 3))


def road_channels(
    test: RoadTest,
    scales: Scales,
    marked: Sequence[Event] = (),
    over: tuple[RoadTest, float] | None = None,
    points: int = 2000,
) -> go.Figure:
    """The channels of a log one above the other over a common time axis, suspect samples crossed, breaks dotted.

    Parameters
    ----------
    scales
        quantity → unit's name and the function from SI to that unit, for quantities shown in another unit than SI.
    marked
        events to mark where they begin and, if they last, to shade.
    over
        another log to lay over it, dashed, and by how much it is shifted [s].
    points
        of a channel that are drawn; every stretch keeps its lowest and highest sample.
    """
    channels = [channel for channel in test.channels.values() if channel.samples]
    figure = make_subplots(rows=max(len(channels), 1), cols=1, shared_xaxes=True, vertical_spacing=0.02)
    for row, channel in enumerate(channels, start=1):
        unit, convert = scales.get(channel.quantity, (channel.unit, lambda value: value))
        _channel(figure, channel, test, convert, row, points)
        other = None if over is None else over[0].channel(channel.quantity)
        if over is not None and other is not None and other.samples:
            _line_of(figure, other, over[0], convert, row, points, shift=over[1])
        label = QUANTITIES[channel.quantity].label
        figure.update_yaxes(title=f"{label.replace(' (', '<br>(')}<br>[{unit}]" if unit else label, row=row, col=1)
    _mark(figure, test, marked)
    figure.update_xaxes(title="time [s]", row=max(len(channels), 1), col=1)
    return _dressed(figure, 90 + 130 * max(len(channels), 1), hovermode="x unified", showlegend=False)


def _mark(figure: go.Figure, test: RoadTest, marked: Sequence[Event]) -> None:
    """Breaks and events over the whole height; set in one go, since plotly takes seconds to add some hundred."""
    first, last = float(test.time[0]), float(test.time[-1])
    upright = {"type": "line", "xref": "x", "yref": "paper", "y0": 0.0, "y1": 1.0}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    for before, after in pairwise(test.segments[:MARKED]):
        at = (before.stop + after.start) / 2.0
        shapes.append({**upright, "x0": at, "x1": at, "line": {"dash": "dot", "width": 1, "color": PUMP}})
    inside = [event for event in marked if event.stop >= first and event.start <= last][:EVENTS]
    for event in inside:
        shift = event.kind == "gear_shift"
        begin, end = max(event.start, first), min(event.stop, last)
        if not shift:
            shade = {"type": "rect", "fillcolor": SHARE, "opacity": 0.08, "line": {"width": 0}}
            shapes.append({**upright, **shade, "x0": begin, "x1": end})
        shapes.append({**upright, "x0": begin, "x1": begin, "line": {"dash": "dash", "width": 1, "color": SHARE}})
        text = f"{event.from_gear}→{event.to_gear}" if shift else event.kind.replace("_", " ")
        notes.append(
            {"x": begin, "y": 1.0, "xref": "x", "yref": "paper", "xanchor": "left", "yanchor": "bottom",
             "showarrow": False, "font": {"size": 10}, "text": text}
        )  # fmt: skip
    figure.update_layout(shapes=shapes, annotations=notes if len(notes) <= LABELLED else [])


def _channel(
    figure: go.Figure, channel: Channel, test: RoadTest, convert: Callable[[Any], Any], row: int, points: int
) -> None:
    _line_of(figure, channel, test, convert, row, points)
    doubtful = np.flatnonzero(channel.suspect & np.isfinite(channel.values))
    if len(doubtful) and channel.source != "constant":
        shown = doubtful[:: len(doubtful) // MARKED + 1]
        figure.add_trace(
            go.Scatter(
                x=channel.time[shown],
                y=convert(channel.values[shown]),
                name="suspect",
                mode="markers",
                marker={"symbol": "x-thin", "size": 7, "line": {"width": 1.5, "color": COLOURS["replace"]}},
                hovertemplate="suspect: %{y:.5g}",
            ),
            row=row,
            col=1,
        )


def _line_of(
    figure: go.Figure,
    channel: Channel,
    test: RoadTest,
    convert: Callable[[Any], Any],
    row: int,
    points: int,
    shift: float | None = None,
) -> None:
    """A channel's good samples; ``shift`` [s] tells a log that is laid over another."""
    constant = channel.source == "constant"
    time = test.time[[0, -1]] if constant else channel.time
    good = np.full(2, channel.values[0]) if constant else channel.good
    keep = _kept(good, points)
    name = QUANTITIES[channel.quantity].label
    look = {"color": LEAKAGE} if shift is None else {"color": SHARE, "dash": "dash"}
    steps = channel.quantity in {"gear", "selector", "lock_up"}
    figure.add_trace(
        go.Scatter(
            x=time[keep] + (shift or 0.0),
            y=convert(good[keep]),
            name=name if shift is None else f"{name}, {test.file}",
            mode="lines",
            line={"width": 1.6, "shape": "hv" if steps else "linear", **look},
            connectgaps=False,
            hovertemplate="%{y:.5g}",
        ),
        row=row,
        col=1,
    )


def _kept(values: np.ndarray, points: int) -> np.ndarray:
    """Indices of about ``points`` samples: ends, extremes of every stretch, edges of what is missing."""
    size = len(values)
    if size <= points:
        return np.arange(size)
    chosen = MinMaxDownsampler().downsample(np.ascontiguousarray(values, dtype=float), n_out=points // 2 * 2)
    known = np.isfinite(values)
    edges = np.flatnonzero(known[1:] != known[:-1])
    edges = np.concatenate([edges, edges + 1])[:MARKED]
    return np.unique(np.concatenate([[0, size - 1], np.asarray(chosen, dtype=int), edges]))


_MARKERS = {"ok": "circle", "watch": "triangle-up", "replace": "square", "critical": "x", "not_measured": "circle-open"}
