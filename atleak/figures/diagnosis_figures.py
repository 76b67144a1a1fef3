"""Turn results into plotly figures: transparent, with units on the axes and few points per trace.

Nothing is computed here but what a picture needs. Figures are tested by their trace data.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.catalogue.limits import Limits, RuleKind
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.engine.road_leakage import RoadLeakage
from atleak.events import Event
from atleak.figures.figure import Figure
from atleak.figures.frame import by_land, error_bars, framed
from atleak.look import HATCHING, SCREEN, SUSPECT, look_of
from atleak.road_test import QUANTITIES, Channel, RoadTest
from atleak.rules import Rule
from atleak.thinning import thinned
from atleak.uncertainty import TotalUncertainty
from atleak.verdicts import VERDICTS, Band
from atleak.views.road_series import RoadSeries, road_series
from atleak.views.window import Scales
from atleak.wording import Wording, signed, wording
from atleak.workshop_units import DM3_MIN, PERCENT, UM

POINTS = 3000  # samples of a log that are drawn, besides the edges of its gaps
EVENTS = 60  # most events of a log that are marked
LABELLED = 20  # with more events the figure is too narrow for their names
MARKED = 800  # most suspect samples and breaks of a log that are marked
_NAMED = 0.12  # part of the axis from which on a band has room for its name beside its sign
_NEAR = 0.08  # part of the axis within which a word centred on its mark would be cut by the axis
_HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}
_SYMBOLS = {
    "max_leakage_sustained": "diamond",
    "max_leakage": "diamond-open",
    "min_leakage": "triangle-down-open",
    "max_share_sustained": "star",
    "max_share": "star-open",
}
_OF_SHARE = ("max_share_sustained", "max_share")  # the instants that are marked in the curve of the share


def land_name(land: LandDiagnosis) -> str:
    """Return component and land: ``25 · 1``."""
    component, number = land.key
    return f"{component} · {number}"


def leakage_ranking(diagnosis: Diagnosis, lands: int = 20) -> Figure:
    """Draw the lands by leakage at the stated condition, the largest on top, by verdict, with 95 % intervals.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    ranked = diagnosis.ranked[:lands]
    figure = Figure()
    for verdict in VERDICTS:
        leaking = [land for land in ranked if land.verdict == verdict]
        if not leaking:
            continue
        figure.add_bar(
            x=[land.leakage * DM3_MIN for land in leaking],
            y=[land_name(land) for land in leaking],
            orientation="h",
            name=signed(verdict),
            marker={"color": look_of(verdict).screen, "pattern": _HATCH | {"shape": look_of(verdict).pattern}},
            error_x=error_bars([land.leakage for land in leaking], [_interval(land) for land in leaking], DM3_MIN),
            customdata=[
                (
                    diagnosis.controller.components[land.key[0]],
                    land.state.radial_clearance * UM,
                    land.share * PERCENT,
                )
                for land in leaking
            ],
            hovertemplate="%{y} %{customdata[0]}<br>%{x:.3f} dm³/min, %{customdata[2]:.2f} % of pump flow"
            "<br>radial clearance %{customdata[1]:.1f} µm<extra></extra>",
        )
    figure.add_scatter(
        x=[max(land.leakage, *(_interval(land) or (0.0,))) * DM3_MIN for land in ranked],
        y=[land_name(land) for land in ranked],
        mode="text",
        text=[f"  {look_of(land.verdict).sign} {land.share * PERCENT:.2f} %" for land in ranked],
        textposition="middle right",
        cliponaxis=False,
        showlegend=False,
        hoverinfo="skip",
    )
    largest = max((max(land.leakage, *(_interval(land) or (0.0,))) * DM3_MIN for land in ranked), default=0.0)
    figure.update_xaxes(title="leakage [dm³/min]", range=[0.0, 1.25 * largest or 1.0])
    return by_land(figure, [land_name(land) for land in ranked], 22, bargap=0.25)


def _interval(land: LandDiagnosis) -> tuple[float, float] | None:
    return land.uncertainty.leakage_interval if land.uncertainty else None


def total_share(diagnosis: Diagnosis, say: Wording | None = None) -> Figure:
    """Draw the total share at each condition over the bands that apply there, and the worst of the road test.

    An open mark is the same unit new. A unit that nobody measured has no bands. Bars are the 95 % intervals of the
    measurement, where readings are there; the hover says how likely each band is. English unless ``say`` is given.
    """
    say = say or wording("en")
    unit, reported = diagnosis.uncertainty, diagnosis.reported
    totals = [unit.total(point.condition.name) if unit else None for point in reported]
    rules = [diagnosis.total_rule(point) for point in reported]
    points = [
        (_named(point, say), point.share, total.share_interval if total else None, _likely_bands(total, say))
        for point, total in zip(reported, totals, strict=True)
    ]
    worst = diagnosis.road.max_share if diagnosis.road else None
    if worst is not None and worst.share is not None:
        points.append((say("figures.worst_of_log", time=say.number(worst.time, 1)), worst.share, None, ""))
    ends = [
        end * PERCENT for _, share, interval, _ in points for end in (share, *(interval or ())) if math.isfinite(end)
    ]
    figure = Figure()
    right = _bands(figure, rules if diagnosis.judged else [], max(ends, default=0.0), say)
    new = [
        (_named(point, say), rule.new)
        for point, rule in zip(reported, rules, strict=True)
        if rule.new is not None and math.isfinite(rule.new)
    ]
    shown = [point for point in points if math.isfinite(point[1])]
    figure.add_scatter(
        x=[share * PERCENT for _, share, _, _ in shown],
        y=[_two_lines(label) for label, _, _, _ in shown],
        mode="markers+text",
        marker={"symbol": "diamond", "size": 14, "color": SCREEN.leakage, "line": {"width": 1.5, "color": "white"}},
        text=[f"<b>{say.percent(share)}</b>" for _, share, _, _ in shown],
        textposition=["top right" if share * PERCENT < _NEAR * right else "top center" for _, share, _, _ in shown],
        error_x=error_bars([share for _, share, _, _ in shown], [end for _, _, end, _ in shown], PERCENT),
        customdata=[likely for _, _, _, likely in shown],
        hovertemplate="%{y}: %{x:.2f} %<br>%{customdata}<extra></extra>",
        name=say("figures.as_measured" if diagnosis.judged else "figures.as_new"),
    )
    figure.add_scatter(
        x=[share * PERCENT for _, share in new],
        y=[_two_lines(label) for label, _ in new],
        mode="markers",
        marker={"symbol": "circle-open", "size": 12, "color": SCREEN.leakage, "line": {"width": 2}},
        hovertemplate=f"%{{y}}: %{{x:.2f}} % {say('figures.new')}<extra></extra>",
        name=say("figures.same_unit_new"),
    )
    figure.update_xaxes(title=say("figures.drawn_share"), range=[0.0, right])
    order = [_two_lines(label) for label, _, _, _ in points]
    figure.update_yaxes(type="category", categoryarray=order, range=[len(points) - 0.4, -0.8])
    return framed(figure, 130 + 56 * len(points), top=40)


def _two_lines(label: str) -> str:
    return label.replace(", ", ",<br>")


def _named(point: Projection, say: Wording) -> str:
    return say.name(point.condition.label)


def _likely_bands(total: TotalUncertainty | None, say: Wording) -> str:
    """Return how likely each band is; bands below half a percent are left out."""
    if total is None:
        return ""
    return ", ".join(f"{say.level(band)} {say.percent(p, 0)}" for band, p in total.band_probabilities if p >= 0.005)


def _bands(figure: Figure, rules: Sequence[Rule], largest: float, say: Wording) -> float:
    """Draw each condition's own bands behind its bar, with signs and words; return the right end of the axis [%]."""
    limits = [[min(limit, 10.0) * PERCENT for _, limit in rule.steps.levels] for rule in rules]
    right = max([1.1 * largest, *(1.2 * edge for edges in limits for edge in edges)])
    for place, (rule, begins) in enumerate(zip(rules, limits, strict=True)):
        edges = [0.0, *np.minimum.accumulate(begins[::-1])[::-1], right]  # a band ends where a worse one begins
        names = [Band.GREEN, *(name for name, _ in rule.steps.levels)]
        for name, low, high in zip(names, edges[:-1], edges[1:], strict=True):
            if low >= high:
                continue
            look = look_of(name)
            figure.add_shape(
                type="rect", x0=low, x1=high, y0=place - 0.45, y1=place + 0.45,
                fillcolor=look.screen, opacity=0.28, line={"width": 0}, layer="below",
            )  # fmt: skip
            figure.add_annotation(
                x=low, y=place + 0.45, xanchor="left", yanchor="bottom", xshift=2,
                text=f"{look.sign} {say.level(name)}" if high - low > _NAMED * right else look.sign, font={"size": 10},
            )  # fmt: skip
    return right


def road_leakage(road: RoadLeakage, limits: Limits, points: int = POINTS) -> Figure:
    """Draw leakage, pump flow and share with the edges of its bands over a log, one above the other.

    Without a logged engine speed there is no pump flow and no share, and only leakage is drawn.
    """
    series = road_series(road, points)
    with_share = "share_percent" in series.columns
    figure = Figure(3 if with_share else 1, 0.06)
    _line(figure, series, "leakage_dm3_min", "leakage", SCREEN.leakage, 1)
    if with_share:
        _line(figure, series, "pump_capacity_dm3_min", "pump flow", SCREEN.pump, 2, dash="dash")
        _line(figure, series, "share_percent", "share", SCREEN.share, 3, dash="dashdot")
        _band_edges(figure, limits, float(np.nanmax(series.columns["share_percent"], initial=0.0)))
        figure.update_yaxes(title="pump flow<br>[dm³/min]", row=2)
        figure.update_yaxes(title="share [%]", row=3)
    _instants(figure, series)
    figure.update_yaxes(title="leakage<br>[dm³/min]", row=1)
    figure.update_yaxes(rangemode="tozero")
    figure.update_xaxes(title="time [s]", row=3 if with_share else 1)
    return framed(figure, 620 if with_share else 320, hovermode="x unified")


def _line(
    figure: Figure, series: RoadSeries, name: str, label: str, colour: str, row: int, dash: str = "solid"
) -> None:
    figure.add_scatter(
        x=series.columns["time_s"],
        y=series.columns[name],
        name=label,
        mode="lines",
        line={"color": colour, "dash": dash, "width": 2},
        connectgaps=False,
        hovertemplate="%{y:.2f}",
        row=row,
    )


def _band_edges(figure: Figure, limits: Limits, top: float) -> None:
    """Return the edges of the bands near the log's values: a high limit must not squeeze a low curve."""
    for number, (name, level) in enumerate(limits.fixed_bands):
        edge = level * PERCENT
        if number and edge > 1.5 * top:
            break
        figure.add_hline(
            y=edge, line={"color": look_of(name).screen, "dash": "dot", "width": 1.5}, row=3,
            text=f"{name} from {edge:g} %", font={"size": 11},
        )  # fmt: skip


def _instants(figure: Figure, series: RoadSeries) -> None:
    for row in series.instants:
        instant, share = row.instant, row.name in _OF_SHARE
        value = instant.share if share else instant.leakage
        if value is None:
            continue
        figure.add_scatter(
            x=[instant.time],
            y=[value * (PERCENT if share else DM3_MIN)],
            name=f"{row.label(wording('en'))}, {instant.time:.2f} s",
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


def wear(diagnosis: Diagnosis, lands: Sequence[LandDiagnosis] | None = None) -> Figure:
    """Draw the wear of every measured land against the limits that apply to it, the most worn on top."""
    chosen = diagnosis.lands if lands is None else lands
    worn = [(land.wear, land) for land in chosen if land.wear is not None]
    worn.sort(key=lambda pair: pair[0])
    figure = Figure()
    for verdict in VERDICTS:
        these = [(wear, land) for wear, land in worn if land.verdict == verdict]
        if these:
            figure.add_scatter(
                x=[wear * PERCENT for wear, _ in these],
                y=[land_name(land) for _, land in these],
                mode="markers",
                name=wording("en").level(verdict),
                marker={"color": look_of(verdict).screen, "symbol": look_of(verdict).marker, "size": 11},
                hovertemplate="%{y}: %{x:.1f} %<extra></extra>",
            )
    rules = [(rule, land) for _, land in worn for rule in land.rules if rule.kind is RuleKind.WEAR]
    for level in dict.fromkeys(level for rule, _ in rules for level, _ in rule.steps.levels):
        limits = [(rule.steps.limit_of(level), land) for rule, land in rules]
        figure.add_scatter(
            x=[limit * PERCENT for limit, _ in limits if limit is not None],
            y=[land_name(land) for limit, land in limits if limit is not None],
            mode="markers",
            name=f"{level} from here",
            marker={"symbol": f"{look_of(level).marker}-open", "color": look_of(level).screen, "size": 9},
            hovertemplate="%{y}: %{x:.1f} %<extra></extra>",
        )
    figure.update_xaxes(title="wear against the mounting clearance [%]")
    return by_land(figure, [land_name(land) for _, land in reversed(worn)], 18)


def road_channels(
    test: RoadTest,
    scales: Scales,
    marked: Sequence[Event] = (),
    over: tuple[RoadTest, float] | None = None,
    points: int = 2000,
) -> Figure:
    """Draw the channels of a log one above the other, suspect samples crossed, breaks dotted.

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
    figure = Figure(max(len(channels), 1), 0.02)
    for row, channel in enumerate(channels, start=1):
        unit, convert = scales.get(channel.quantity, (channel.unit, lambda value: value))
        _channel(figure, channel, test, convert, row, points)
        other = None if over is None else over[0].channel(channel.quantity)
        if over is not None and other is not None and other.samples:
            _line_of(figure, other, over[0], convert, row, points, shift=over[1])
        label = QUANTITIES[channel.quantity].label
        figure.update_yaxes(title=f"{label.replace(' (', '<br>(')}<br>[{unit}]" if unit else label, row=row)
    _mark(figure, test, marked)
    figure.update_xaxes(title="time [s]", row=max(len(channels), 1))
    return framed(figure, 90 + 130 * max(len(channels), 1), hovermode="x unified", showlegend=False)


def _mark(figure: Figure, test: RoadTest, marked: Sequence[Event]) -> None:
    """Mark breaks and events over the whole height, all in one call: plotly takes seconds to add some hundred."""
    first, last = float(test.time[0]), float(test.time[-1])
    upright = {"type": "line", "xref": "x", "yref": "paper", "y0": 0.0, "y1": 1.0}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    for before, after in pairwise(test.segments[:MARKED]):
        at = (before.stop + after.start) / 2.0
        shapes.append({**upright, "x0": at, "x1": at, "line": {"dash": "dot", "width": 1, "color": SCREEN.pump}})
    inside = [event for event in marked if event.stop >= first and event.start <= last][:EVENTS]
    for event in inside:
        shift = event.kind == "gear_shift"
        begin, end = max(event.start, first), min(event.stop, last)
        if not shift:
            shade = {"type": "rect", "fillcolor": SCREEN.share, "opacity": 0.08, "line": {"width": 0}}
            shapes.append({**upright, **shade, "x0": begin, "x1": end})
        shapes.append(
            {**upright, "x0": begin, "x1": begin, "line": {"dash": "dash", "width": 1, "color": SCREEN.share}}
        )
        text = f"{event.from_gear}→{event.to_gear}" if shift else event.kind.replace("_", " ")
        notes.append(
            {"x": begin, "y": 1.0, "xref": "x", "yref": "paper", "xanchor": "left", "yanchor": "bottom",
             "showarrow": False, "font": {"size": 10}, "text": text}
        )  # fmt: skip
    figure.update_layout(shapes=shapes, annotations=notes if len(notes) <= LABELLED else [])


def _channel(
    figure: Figure, channel: Channel, test: RoadTest, convert: Callable[[Any], Any], row: int, points: int
) -> None:
    _line_of(figure, channel, test, convert, row, points)
    doubtful = np.flatnonzero(channel.suspect & np.isfinite(channel.values))
    if len(doubtful) and channel.source != "constant":
        shown = doubtful[:: len(doubtful) // MARKED + 1]
        figure.add_scatter(
            x=channel.time[shown],
            y=convert(channel.values[shown]),
            name="suspect",
            mode="markers",
            marker={"symbol": "x-thin", "size": 7, "line": {"width": 1.5, "color": SUSPECT}},
            hovertemplate="suspect: %{y:.5g}",
            row=row,
        )


def _line_of(
    figure: Figure,
    channel: Channel,
    test: RoadTest,
    convert: Callable[[Any], Any],
    row: int,
    points: int,
    shift: float | None = None,
) -> None:
    """Draw a channel's good samples; a ``shift`` [s] marks the trace of a second log laid over the first."""
    constant = channel.source == "constant"
    time = test.time[[0, -1]] if constant else channel.time
    good = np.full(2, channel.values[0]) if constant else channel.good
    keep = thinned([good], points)
    name = QUANTITIES[channel.quantity].label
    look = {"color": SCREEN.leakage} if shift is None else {"color": SCREEN.share, "dash": "dash"}
    steps = channel.quantity in {"gear", "selector", "lock_up"}
    figure.add_scatter(
        x=time[keep] + (shift or 0.0),
        y=convert(good[keep]),
        name=name if shift is None else f"{name}, {test.file}",
        mode="lines",
        line={"width": 1.6, "shape": "hv" if steps else "linear", **look},
        connectgaps=False,
        hovertemplate="%{y:.5g}",
        row=row,
    )
