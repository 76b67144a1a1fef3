"""Draw a road-test log on the screen: its channels over time, and how long and with what share it was driven where."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.common.style import CURVES, SCALE_OF_SHARES, SCALE_OF_TIME, SCREEN, SUSPECT
from atleak.common.wording import Wording
from atleak.measurements.events import Event
from atleak.measurements.road_test import RoadTest, thinned
from atleak.report.charts.figure import Figure, framed
from atleak.report.charts.operating_map import Histogram, OperatingMap
from atleak.report.tables.road_test import Curve
from atleak.report.tables.road_words import event_name

_POINTS = 2000  # samples of a channel that are drawn, with the lowest and highest of every stretch
LINES = 60  # most events that are marked through all curves; the lane above them shows every one
LABELLED = 20  # with more shifts the figure is too narrow for their gears
MARKED = 800  # most suspect samples and breaks of a log that are marked
_FINEST = 1500  # parts of the time shown: events of a kind that lie nearer together are drawn as one
_ROW, _LANE = 130, 22  # pixels


def log_channels(test: RoadTest, curves: Sequence[Curve], say: Wording, marked: Sequence[Event] = ()) -> Figure:
    """Draw the events and the curves of a log one above the other, suspect samples crossed, breaks dotted.

    Each trace of a curve says in its ``meta`` its unit and what it is, for the cursor that a page lays over them; the
    layout's says at which stamps it may stand. There every curve has its own sample, however much it is thinned.

    Parameters
    ----------
    marked
        events: every one has its bar in a lane of its own; a few are also marked through all curves.
    """
    inside = [each for each in marked if each.stop >= test.time[0] and each.start <= test.time[-1]]
    times = {id(each.time): each.time for each in curves}
    stamps = np.unique(np.concatenate([test.time[:1], *times.values()]))
    if len(stamps) > _POINTS:
        stamps = stamps[np.linspace(0, len(stamps) - 1, _POINTS // 2).astype(int)]
    kinds = list(dict.fromkeys(event.kind for event in inside))
    lane = 1 if inside else 0
    rows = lane + len(curves)
    heights = [_LANE * len(kinds) + 18] * lane + [_ROW] * (rows - lane)
    figure = Figure(max(rows, 1), min(0.02, 0.2 / max(rows, 1)), heights or None)
    if inside:
        _lane(figure, inside, kinds, test, say)
    _mark(figure, test, inside, say)
    for row, curve in enumerate(curves, start=1 + lane):
        words = curve.name.replace(" (", "<br>(")
        title = f"{words}<br>[{curve.unit}]" if curve.unit else words
        figure.update_yaxes(title=title, rangemode="tozero" if curve.from_zero else None, row=row)
        for each in (*curve.beside[::-1], curve):  # the log's own on top
            _curve(figure, each, row, stamps)
        if curve.suspect is not None:
            _crosses(figure, *curve.suspect, say("road_test.suspect"), row)
        for stamp, value, words, symbol in curve.marks:
            marker = {"symbol": symbol, "size": 12, "color": SCREEN.leakage, "line": {"width": 1.5}}
            told = {"hovertemplate": "%{y:.2f}"}
            figure.add_scatter(x=[stamp], y=[value], name=words, mode="markers", marker=marker, row=row, **told)
    figure.update_xaxes(title=f"{say('log_quantities.time')} [s]", row=max(rows, 1))
    figure.update_layout(meta={"stamps": stamps.tolist()})
    return framed(figure, 70 + sum(heights), hovermode="closest", showlegend=False)


_DRAWN = {
    "own": {"color": SCREEN.leakage, "width": 1.6},
    "over": {"color": SCREEN.share, "width": 1.6, "dash": "dash"},
}
_LIMIT = {"color": SUSPECT, "width": 1.2, "dash": "dot"}


def _curve(figure: Figure, curve: Curve, row: int, stamps: np.ndarray) -> None:
    if curve.look == "edge":
        figure.add_hline(y=float(curve.values[0]), line=_LIMIT, row=row, text=curve.name, font={"size": 11})
    elif len(curve.values):
        there = np.searchsorted(curve.time, stamps, side="right") - 1  # the last sample at or before each
        keep = np.union1d(thinned([curve.values], _POINTS), there[there >= 0])
        figure.add_scatter(
            x=curve.time[keep],
            y=curve.values[keep],
            name=curve.name,
            meta={"unit": curve.unit, "look": curve.look},
            mode="lines",
            line={"shape": "hv" if curve.steps else "linear", **_DRAWN.get(curve.look, _LIMIT)},
            connectgaps=False,
            hoverinfo="skip",
            row=row,
        )


def _crosses(figure: Figure, time: np.ndarray, values: np.ndarray, name: str, row: int) -> None:
    """Cross the samples that no result uses."""
    every = len(time) // MARKED + 1
    figure.add_scatter(
        x=time[::every],
        y=values[::every],
        name=name,
        mode="markers",
        marker={"symbol": "x-thin", "size": 7, "line": {"width": 1.5, "color": SUSPECT}},
        hovertemplate=f"{name}: %{{y:.5~g}}",
        row=row,
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
