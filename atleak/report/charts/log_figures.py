"""Draw a road-test log on the screen: its channels over time, and how long and with what share it was driven where."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from atleak.analysis.formulas import FormulaChannel
from atleak.catalogue.limits import Limits
from atleak.common.style import CURVES, SCALE_OF_SHARES, SCALE_OF_TIME, SCREEN, SUSPECT, look_of
from atleak.common.units import DM3_MIN, PERCENT
from atleak.common.wording import Wording
from atleak.engine.road_leakage import RoadLeakage
from atleak.measurements.events import Event
from atleak.measurements.road_test import Channel, RoadTest, thinned
from atleak.report.charts.figure import Figure, framed
from atleak.report.charts.operating_map import Histogram, OperatingMap
from atleak.report.tables.road_test import RoadSeries, Scales, as_it_is, formula_scale, road_series
from atleak.report.tables.road_words import event_name

_POINTS = 2000  # samples of a channel that are drawn, with the lowest and highest of every stretch
_LEAKAGE_POINTS = 3000  # the same of the leakage over it
LINES = 60  # most events that are marked through all curves; the lane above them shows every one
LABELLED = 20  # with more shifts the figure is too narrow for their gears
MARKED = 800  # most suspect samples and breaks of a log that are marked
_FINEST = 1500  # parts of the time shown: events of a kind that lie nearer together are drawn as one
_ROW, _LANE = 130, 22  # pixels
_STEPS = frozenset({"gear", "selector", "lock_up"})


_SYMBOLS = {
    "max_leakage_sustained": "diamond", "max_leakage": "diamond-open", "min_leakage": "triangle-down-open",
    "max_share_sustained": "star", "max_share": "star-open",
}  # fmt: skip
_OF_SHARE = ("max_share_sustained", "max_share")  # the instants that are marked in the curve of the share


@dataclass(frozen=True)
class LaidOver:
    """A second log: its road test, by how much it is shifted [s], and its formulas by name."""

    test: RoadTest  # the second log
    shift: float  # [s] by which it is moved
    formulas: Mapping[str, FormulaChannel] = field(default_factory=dict)  # its computed channels, by name


def log_channels(
    test: RoadTest,
    scales: Scales,
    say: Wording,
    marked: Sequence[Event] = (),
    formulas: Sequence[FormulaChannel] = (),
    over: LaidOver | None = None,
) -> Figure:
    """Draw the events and the channels of a log one above the other, suspect samples crossed, breaks dotted.

    Parameters
    ----------
    scales
        quantity → unit's name and the function from SI to that unit, for quantities shown in another unit than SI.
    marked
        events: every one has its bar in a lane of its own; a few are also marked through all curves.
    formulas
        channels that were computed from this log's.
    over
        another log to lay over it, dashed.
    """
    channels = [channel for channel in test.channels.values() if channel.samples]
    inside = [each for each in marked if each.stop >= test.time[0] and each.start <= test.time[-1]]
    kinds = list(dict.fromkeys(event.kind for event in inside))
    lane = 1 if inside else 0
    rows = lane + len(channels) + len(formulas)
    heights = [_LANE * len(kinds) + 18] * lane + [_ROW] * (rows - lane)
    figure = Figure(max(rows, 1), min(0.02, 0.2 / max(rows, 1)), heights or None)
    if inside:
        _lane(figure, inside, kinds, test, say)
    drawing = _Drawing(figure, test, over)
    for row, channel in enumerate(channels, start=1 + lane):
        unit, convert = scales.get(channel.quantity, (channel.unit, as_it_is))
        shown = _Shown(say(f"log_quantities.{channel.quantity}"), unit, convert, row, channel.quantity in _STEPS)
        drawing.channel(channel, shown)
        drawing.doubtful(channel, shown, say("road_test.suspect"))
        other = None if over is None else over.test.channel(channel.quantity)
        if other is not None and other.samples:
            drawing.channel(other, shown, laid_over=True)
    for row, computed in enumerate(formulas, start=1 + lane + len(channels)):
        shown = _Shown(computed.name, *formula_scale(computed.dimension, say), row)
        drawing.curve(computed.time, computed.values, shown)
        laid = None if over is None else over.formulas.get(computed.name)
        if laid is not None and laid.dimension == computed.dimension:
            drawing.curve(laid.time, laid.values, shown, laid_over=True)
    _mark(figure, test, inside, say)
    figure.update_xaxes(title=f"{say('log_quantities.time')} [s]", row=max(rows, 1))
    return framed(figure, 70 + sum(heights), hovermode="x unified", showlegend=False)


class _Shown(NamedTuple):
    """What a row of the figure shows, in which unit, and how numbers become it."""

    label: str
    unit: str
    convert: Callable[[Any], Any]
    row: int
    steps: bool = False


@dataclass
class _Drawing:
    """The figure of one log, perhaps with another laid over it, and how curves are drawn into it."""

    figure: Figure
    test: RoadTest
    over: LaidOver | None

    def channel(self, channel: Channel, shown: _Shown, laid_over: bool = False) -> None:
        """Draw a channel's good samples; a constant over the whole log."""
        time, good = channel.time, channel.good
        if channel.source == "constant":
            test = self.over.test if laid_over and self.over is not None else self.test
            time, good = test.time[[0, -1]], np.full(2, channel.values[0])
        self.curve(time, good, shown, laid_over)

    def curve(self, time: np.ndarray, values: np.ndarray, shown: _Shown, laid_over: bool = False) -> None:
        """Draw values over time; those of the log laid over the first are dashed and shifted."""
        name, shift, look = shown.label, 0.0, {"color": SCREEN.leakage}
        if laid_over and self.over is not None:
            name, shift = f"{name}, {self.over.test.file}", self.over.shift
            look = {"color": SCREEN.share, "dash": "dash"}
        else:
            words = shown.label.replace(" (", "<br>(")
            self.figure.update_yaxes(title=f"{words}<br>[{shown.unit}]" if shown.unit else words, row=shown.row)
        if not len(values):
            return
        keep = thinned([values], _POINTS)
        self.figure.add_scatter(
            x=time[keep] + shift,
            y=shown.convert(values[keep]),
            name=name,
            mode="lines",
            line={"width": 1.6, "shape": "hv" if shown.steps else "linear", **look},
            connectgaps=False,
            hovertemplate=f"%{{y:.5~g}} {shown.unit}",
            row=shown.row,
        )

    def doubtful(self, channel: Channel, shown: _Shown, name: str) -> None:
        """Cross the samples of a channel that no result uses."""
        doubtful = np.flatnonzero(channel.suspect & np.isfinite(channel.values))
        if not len(doubtful) or channel.source == "constant":
            return
        some = doubtful[:: len(doubtful) // MARKED + 1]
        self.figure.add_scatter(
            x=channel.time[some],
            y=shown.convert(channel.values[some]),
            name=name,
            mode="markers",
            marker={"symbol": "x-thin", "size": 7, "line": {"width": 1.5, "color": SUSPECT}},
            hovertemplate=f"{name}: %{{y:.5~g}}",
            row=shown.row,
        )


def _lane(figure: Figure, inside: Sequence[Event], kinds: Sequence[str], test: RoadTest, say: Wording) -> None:
    """Draw a bar for every event in a lane above the channels, one line for each kind."""
    nearest = (float(test.time[-1]) - float(test.time[0])) / _FINEST
    colours = list(CURVES.values())
    for number, kind in enumerate(kinds):
        label = say(f"events.{kind}")
        x: list[float | None] = []
        words: list[str] = []
        for first, last, text in _merged([each for each in inside if each.kind == kind], nearest, say):
            x += [first, last, None]
            words += [text, text, ""]
        figure.add_scatter(
            x=x,
            y=[label] * len(x),
            name=label,
            mode="lines+markers",
            line={"width": 9, "color": colours[number % len(colours)]},
            marker={"symbol": "line-ns", "size": 9, "line": {"width": 2, "color": colours[number % len(colours)]}},
            connectgaps=False,
            customdata=words,
            hovertemplate="%{customdata}<extra></extra>",
            row=1,
        )
    figure.update_yaxes(type="category", categoryarray=[say(f"events.{kind}") for kind in kinds[::-1]], row=1)


def _merged(events: Sequence[Event], nearest: float, say: Wording) -> list[tuple[float, float, str]]:
    """Return begin, end and words of every bar: events too near together to be told apart share one."""
    bars: list[tuple[float, float, list[Event]]] = []
    for event in sorted(events, key=lambda each: each.start):
        if bars and event.start - bars[-1][1] < nearest:
            begin, end, these = bars[-1]
            these.append(event)
            bars[-1] = (begin, max(end, event.stop), these)
        else:
            bars.append((event.start, event.stop, [event]))
    return [(begin, end, _bar_words(these, begin, end, say)) for begin, end, these in bars]


def _bar_words(events: Sequence[Event], begin: float, end: float, say: Wording) -> str:
    first, last = say.number(begin, 1), say.number(end, 1)
    name = event_name(events[0], say) if len(events) == 1 else f"{len(events)} × {say(f'events.{events[0].kind}')}"
    return say("road_test.from_to", what=name, first=first, last=last)


def _mark(figure: Figure, test: RoadTest, inside: Sequence[Event], say: Wording) -> None:
    """Mark breaks, and a few events, over the whole height, all in one call: plotly is slow to add single ones."""
    first, last = float(test.time[0]), float(test.time[-1])
    upright = {"type": "line", "xref": "x", "yref": "paper", "y0": 0.0, "y1": 1.0}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    for before, after in pairwise(test.segments[:MARKED]):
        at = (before.stop + after.start) / 2.0
        shapes.append({**upright, "x0": at, "x1": at, "line": {"dash": "dot", "width": 1, "color": SCREEN.pump}})
    for event in inside if len(inside) <= LINES else ():
        shift = event.kind == "gear_shift"
        begin, end = max(event.start, first), min(event.stop, last)
        if not shift:
            shade = {"type": "rect", "fillcolor": SCREEN.share, "opacity": 0.08, "line": {"width": 0}}
            shapes.append({**upright, **shade, "x0": begin, "x1": end})
        shapes.append(
            {**upright, "x0": begin, "x1": begin, "line": {"dash": "dash", "width": 1, "color": SCREEN.share}}
        )
        if shift:  # the lane names the others
            notes.append(
                {"x": begin, "y": 1.0, "xref": "x", "yref": "paper", "xanchor": "left", "yanchor": "bottom",
                 "showarrow": False, "font": {"size": 10}, "text": str(event.gears).replace(" ", "")}
            )  # fmt: skip
    figure.update_layout(shapes=shapes, annotations=notes if len(notes) <= LABELLED else [])


def road_leakage(road: RoadLeakage, limits: Limits, say: Wording) -> Figure:
    """Draw leakage, pump flow and share with the edges of its bands over a log, one above the other.

    Without a logged engine speed there is no pump flow and no share, and only leakage is drawn.
    """
    series = road_series(road, _LEAKAGE_POINTS)
    with_share = "share_percent" in series.columns
    figure = Figure(3 if with_share else 1, 0.06)
    curves = [("leakage_dm3_min", "leakage_row", "flow", SCREEN.leakage, "solid")]
    if with_share:
        curves.append(("pump_capacity_dm3_min", "pump_flow", "flow", SCREEN.pump, "dash"))
        curves.append(("share_percent", "share", "percent", SCREEN.share, "dashdot"))
    for row, (column, name, kind, colour, dash) in enumerate(curves, start=1):
        label, unit = say(f"road_test.{name}"), say.unit(kind)
        figure.add_scatter(
            x=series.columns["time_s"],
            y=say.convert(series.columns[column], kind),
            name=label,
            mode="lines",
            line={"color": colour, "dash": dash, "width": 2},
            connectgaps=False,
            hovertemplate=f"%{{y:.2f}} {unit}",
            row=row,
        )
        figure.update_yaxes(title=f"{label}<br>[{unit}]", row=row)
    if with_share:
        _band_edges(figure, limits, float(np.nanmax(series.columns["share_percent"], initial=0.0)), say)
    _instants(figure, series, say)
    figure.update_yaxes(rangemode="tozero")
    figure.update_xaxes(title=f"{say('log_quantities.time')} [s]", row=len(curves))
    return framed(figure, 620 if with_share else 320, hovermode="x unified")


def _band_edges(figure: Figure, limits: Limits, top: float, say: Wording) -> None:
    """Draw the edges of the bands near the log's values: a high limit must not squeeze a low curve."""
    for number, (band, level) in enumerate(limits.fixed_bands):
        edge = level * PERCENT
        if number and edge > 1.5 * top:
            break
        text = say("road_test.band_from", band=say.level(band), edge=say.plain(edge))
        figure.add_hline(
            y=edge, line={"color": look_of(band).screen, "dash": "dot", "width": 1.5}, row=3,
            text=text, font={"size": 11},
        )  # fmt: skip


def _instants(figure: Figure, series: RoadSeries, say: Wording) -> None:
    for row in series.instants:
        instant, share = row.instant, row.name in _OF_SHARE
        value = instant.share if share else instant.leakage
        if value is None:
            continue
        figure.add_scatter(
            x=[instant.time],
            y=[value * PERCENT if share else say.convert(value * DM3_MIN, "flow")],
            name=f"{row.label(say)}, {say.number(instant.time, 2)} s",
            mode="markers",
            marker={
                "symbol": _SYMBOLS[row.name],
                "size": 12,
                "color": SCREEN.share if share else SCREEN.leakage,
                "line": {"width": 1.5},
            },
            hovertemplate="%{y:.2f}",
            row=3 if share else 1,
        )


def operating_map_figure(cells: OperatingMap, speed: str, temperature: str, say: Wording) -> Figure:
    """Draw the share over engine speed and temperature, with the time in each cell; without a share the time alone.

    Parameters
    ----------
    speed, temperature
        units of the axes.
    """
    driven = cells.seconds > 0.0
    shown = cells.seconds if cells.share is None else cells.share
    label = say("operating_map.time") if cells.share is None else say("operating_map.mean_share")
    unit = "s" if cells.share is None else "%"
    largest = cells.largest if cells.largest is not None else np.full_like(shown, np.nan)

    def hover(row: int, column: int) -> str:
        words = say(
            "operating_map.hover",
            speeds=_span(cells.speeds, column, speed, say),
            temperatures=_span(cells.temperatures, row, temperature, say),
            seconds=say.number(cells.seconds[row, column], 1),
        )
        if cells.share is None:
            return words
        mean, most = say.number(cells.share[row, column], 2), say.number(largest[row, column], 2)
        return f"{words}<br>{say('operating_map.hover_share', mean=mean, largest=most)}"

    figure = Figure()
    figure.add(
        "heatmap",
        x=cells.speeds,
        y=cells.temperatures,
        z=np.where(driven, shown, np.nan),
        text=[[_seconds(value, say) if value > 0.0 else "" for value in row] for row in cells.seconds],
        texttemplate="%{text}",
        customdata=[[hover(row, column) for column in range(driven.shape[1])] for row in range(driven.shape[0])],
        hovertemplate="%{customdata}<extra></extra>",
        colorscale=SCALE_OF_TIME if cells.share is None else SCALE_OF_SHARES,
        colorbar={"title": {"text": f"{label} [{unit}]", "side": "right"}},
        xgap=1,
        ygap=1,
    )
    figure.update_xaxes(title=f"{say('log_quantities.engine_speed')} [{speed}]")
    figure.update_yaxes(title=f"{say('log_quantities.atf_temperature')} [{temperature}]")
    return framed(figure, 150 + 34 * max(driven.shape[0], 4))


def histogram_figure(bars: Histogram, label: str, unit: str, say: Wording) -> Figure:
    """Draw how long a channel had its values."""
    figure = Figure()
    figure.add_bar(
        x=(bars.edges[:-1] + bars.edges[1:]) / 2.0,
        y=bars.seconds,
        width=np.diff(bars.edges),
        marker={"color": SCREEN.leakage, "line": {"width": 1, "color": SCREEN.soft}},
        customdata=[
            f"{_span(bars.edges, number, unit, say)}: {say.number(seconds, 1)} s"
            for number, seconds in enumerate(bars.seconds)
        ],
        hovertemplate="%{customdata}<extra></extra>",
    )
    figure.update_xaxes(title=f"{label} [{unit}]" if unit else label)
    figure.update_yaxes(title=f"{say('operating_map.time')} [s]", rangemode="tozero")
    return framed(figure, 320)


def _span(edges: np.ndarray, number: int, unit: str, say: Wording) -> str:
    return f"{say.plain(edges[number])} – {say.plain(edges[number + 1])} {unit}".strip()


def _seconds(value: float, say: Wording) -> str:
    return f"{say.number(value, 0 if value >= 10.0 else 1 if value >= 0.95 else 2)} s"
