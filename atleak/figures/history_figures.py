"""Draw a unit's history on the screen: clearance and total over mileage, and what is flagged and replaced in all."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from atleak.catalogue.limits import Level
from atleak.figures.figure import Figure
from atleak.figures.frame import error_bars, framed
from atleak.history.land_wear import LandWear
from atleak.history.series import Point
from atleak.history.totals import TotalOverMileage
from atleak.history.visits import Visit
from atleak.look import HATCHING, SCREEN, look_of
from atleak.verdicts import Verdict
from atleak.wear_line import COVERAGE, FARTHEST, WearLine
from atleak.wording import signed
from atleak.workshop_units import PERCENT, UM

_AHEAD = 100_000.0  # [km] that a line is drawn on, where no limit is reached later
_WHOLE = 10  # units up to which an axis names each number
_STEPS = 41  # of the band, whose edges are no straight lines
_BAND = "rgba(42, 134, 209, 0.18)"
_HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}
_DEVIATE = 1.6448536269514722  # of the interval of a single point, as wide as that of the line


def clearance_over_mileage(land: LandWear, visits: Sequence[Visit], present: float | None) -> Figure:
    """Draw the clearance of a land at every visit with its line, the band of that, and the limits.

    Points of an earlier series, before a repair or another odometer, are open.
    """
    figure = Figure()
    series = land.series
    last = present if present is not None else max((point.mileage for point in series.counted), default=0.0)
    end = _end(land, last)
    if land.line is not None:
        first = min(point.mileage for point in series.counted)
        _band(figure, land.line, first, end)
    _points(figure, series.earlier, visits, "before", "circle-open")
    _points(figure, series.measured, visits, "measured", "circle")
    _points(
        figure, [point for point in series.counted if point.visit is None], visits, "when new, as measured", "diamond"
    )
    for limit in land.limits:
        _limit(figure, limit.level, limit.clearance * UM, "µm")
    since = None if series.since is None else visits[series.since].mileage
    if since is not None:
        figure.add_vline(x=since, line={"color": SCREEN.rule, "dash": "dot", "width": 1.5})
    figure.update_xaxes(title="mileage [km]", range=[0.0, end * 1.02], tickformat=",.0f")
    figure.update_yaxes(title=f"radial clearance [µm], {COVERAGE:.0%} intervals")
    return framed(figure, 420)


def _end(land: LandWear, last: float) -> float:
    """Return up to which mileage a line is drawn: to its last limit, where that is not too far."""
    reached = [limit.at.value for limit in land.limits if limit.at is not None]
    most = max(last * 2.0, last + _AHEAD)
    ends = [each + 0.1 * _AHEAD for each in reached if each <= most]
    return min(max([last + _AHEAD, *ends]), max(FARTHEST, last))


def _band(figure: Figure, line: WearLine, first: float, end: float) -> None:
    mileages = np.linspace(first, end, _STEPS)
    edges = np.array([line.band(float(each)) for each in mileages]) * UM
    figure.add_scatter(
        x=[*mileages, *mileages[::-1]],
        y=[*edges[:, 1], *edges[::-1, 0]],
        fill="toself",
        fillcolor=_BAND,
        line={"width": 0},
        name=f"{COVERAGE:.0%} of the line",
        hoverinfo="skip",
    )
    figure.add_scatter(
        x=[first, end],
        y=[line.at(first) * UM, line.at(end) * UM],
        mode="lines",
        name="line",
        line={"color": SCREEN.leakage, "width": 2},
        hovertemplate="%{x:,.0f} km: %{y:.1f} µm<extra></extra>",
    )


def _points(figure: Figure, points: Sequence[Point], visits: Sequence[Visit], name: str, symbol: str) -> None:
    if not points:
        return
    values = [point.clearance for point in points]
    reach = [_DEVIATE * point.standard_uncertainty for point in points]
    intervals = [(value - each, value + each) for value, each in zip(values, reach, strict=True)]
    figure.add_scatter(
        x=[point.mileage for point in points],
        y=[value * UM for value in values],
        mode="markers",
        name=name,
        marker={"color": SCREEN.leakage, "symbol": symbol, "size": 11, "line": {"width": 2}},
        error_y=error_bars(values, intervals, UM),
        customdata=["when new" if point.visit is None else visits[point.visit].label for point in points],
        hovertemplate="%{customdata}<br>%{x:,.0f} km: %{y:.1f} µm<extra></extra>",
    )


def _limit(figure: Figure, level: Level, value: float, unit: str) -> None:
    look = look_of(level)
    figure.add_hline(
        y=value,
        line={"color": look.screen, "dash": "dash", "width": 2},
        text=f"{signed(level)}: {value:.1f} {unit}",
        xanchor="left",
        x=0.01,
    )


def total_over_mileage(total: TotalOverMileage) -> Figure:
    """Draw the total share at one condition over the mileage ahead, with its interval and the limits of its bands."""
    figure = Figure()
    low, median, high = (np.array(each) * PERCENT for each in (total.low, total.median, total.high))
    figure.add_scatter(
        x=[*total.mileages, *total.mileages[::-1]],
        y=[*high, *low[::-1]],
        fill="toself",
        fillcolor=_BAND,
        line={"width": 0},
        name=f"{COVERAGE:.0%}",
        hoverinfo="skip",
    )
    figure.add_scatter(
        x=total.mileages,
        y=median,
        mode="lines",
        name="total share",
        line={"color": SCREEN.leakage, "width": 3},
        customdata=np.column_stack([low, high]),
        hovertemplate="%{x:,.0f} km: %{y:.1f} % (%{customdata[0]:.1f} to %{customdata[1]:.1f})<extra></extra>",
    )
    top = max(float(high[np.isfinite(high)].max(initial=1.0)), 1.0)
    for limit in total.limits:
        if limit.share * PERCENT <= 1.5 * top:
            _limit(figure, limit.level, limit.share * PERCENT, "%")
    figure.update_xaxes(title="mileage [km]", tickformat=",.0f")
    figure.update_yaxes(title="share of the pump's flow [%]", rangemode="tozero")
    return framed(figure, 380)


def pareto(names: Sequence[str], counts: Sequence[int], of: int, what: str) -> Figure:
    """Draw how often pairs were flagged or replaced, the most often first, with their part of all such pairs so far.

    Parameters
    ----------
    names, counts
        of the pairs, the most often first.
    of
        units that were looked at.
    what
        was done to them: ``"flagged"``.
    """
    total = sum(counts)
    passed = [sum(counts[: place + 1]) / total * PERCENT if total else math.nan for place in range(len(counts))]
    figure = Figure()
    figure.add_bar(
        y=names,
        x=counts,
        orientation="h",
        name=what,
        marker={"color": look_of(Verdict.WATCH).screen, "pattern": {**_HATCH, "shape": look_of(Verdict.WATCH).pattern}},
        text=[f"{count} of {of}" for count in counts],
        textposition="outside",
        customdata=passed,
        hovertemplate="%{y}: %{text} units; %{customdata:.0f} % of all with those above<extra></extra>",
    )
    most = max(counts, default=1)
    figure.update_xaxes(title=f"units {what}", dtick=1 if most <= _WHOLE else None, range=[0.0, 1.25 * most])
    figure.update_yaxes(type="category", categoryorder="array", categoryarray=list(reversed(names)))
    return framed(figure, 110 + 26 * max(len(names), 3))
