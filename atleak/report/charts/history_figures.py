"""Draw a unit's history on the screen: clearance and total over mileage, and what is flagged and replaced in all."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from atleak.analysis.history.series import Point, Visit
from atleak.analysis.history.wear import LandWear, TotalOverMileage
from atleak.catalogue.limits import Level
from atleak.common.style import SCREEN, look_of
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.land import FARTHEST, MILEAGE_COVERAGE, WearLine
from atleak.report.charts.figure import Figure, framed

_AHEAD = 100_000.0  # [km] that a line is drawn on, where no limit is reached later
_WHOLE = 10  # units up to which an axis names each number
_STEPS = 41  # of the band, whose edges are no straight lines
_BAND = "rgba(42, 134, 209, 0.18)"
_DEVIATE = 1.6448536269514722  # of the interval of a single point, as wide as that of the line


def clearance_over_mileage(land: LandWear, visits: Sequence[Visit], present: float | None, say: Wording) -> Figure:
    """Draw the clearance of a land at every visit with its line, the band of that, and the limits.

    Points of an earlier series, before a repair or another odometer, are open.
    """
    figure, um = Figure(), say.convert(UM, "clearance")
    series = land.series
    last = present if present is not None else max((point.mileage for point in series.counted), default=0.0)
    end = _end(land, last)
    if land.line is not None:
        first = min(point.mileage for point in series.counted)
        _band(figure, land.line, first, end, say)
    as_new = [point for point in series.counted if point.visit is None]
    for points, name, symbol in (
        (series.earlier, "before", "circle-open"),
        (series.measured, "measured", "circle"),
        (as_new, "when_new", "diamond"),
    ):
        _points(figure, points, visits, say(f"history.{name}"), symbol, say)
    for limit in land.limits:
        value = say.value(limit.clearance * UM, "clearance", 1)
        _limit(figure, limit.level, limit.clearance * um, f"{value} {say.unit('clearance')}", say)
    if series.since is not None and (since := visits[series.since].mileage) is not None:
        figure.add_vline(x=say.convert(since, "distance"), line={"color": SCREEN.rule, "dash": "dot", "width": 1.5})
    figure.update_xaxes(title=_mileage(say), range=[0.0, say.convert(end, "distance") * 1.02], tickformat=",.0f")
    unit = say.unit("clearance")
    figure.update_yaxes(title=say("history.clearance", unit=unit, coverage=say.percent(MILEAGE_COVERAGE, 0)))
    return framed(figure, 420)


def _end(land: LandWear, last: float) -> float:
    """Return up to which mileage a line is drawn: to its last limit, where that is not too far."""
    reached = [limit.at.value for limit in land.limits if limit.at is not None]
    most = max(last * 2.0, last + _AHEAD)
    ends = [each + 0.1 * _AHEAD for each in reached if each <= most]
    return min(max([last + _AHEAD, *ends]), max(FARTHEST, last))


def _band(figure: Figure, line: WearLine, first: float, end: float, say: Wording) -> None:
    um = say.convert(UM, "clearance")
    mileages = np.linspace(first, end, _STEPS)
    edges = np.array([line.band(float(each)) for each in mileages]) * um
    shown = say.convert(mileages, "distance")
    figure.band(shown, edges[:, 0], edges[:, 1], say("history.band", coverage=say.percent(MILEAGE_COVERAGE, 0)), _BAND)
    ends = [line.at(first) * um, line.at(end) * um]
    figure.line([shown[0], shown[-1]], ends, SCREEN.leakage, 2, name=say("history.line"), hover=_hover(say))


def _points(
    figure: Figure, points: Sequence[Point], visits: Sequence[Visit], name: str, symbol: str, say: Wording
) -> None:
    if not points:
        return
    values = [point.clearance for point in points]
    reach = [_DEVIATE * point.standard_uncertainty for point in points]
    figure.marks(
        values,
        [say.convert(point.mileage, "distance") for point in points],
        name,
        (SCREEN.leakage, symbol, 11, 2.0),
        factor=say.convert(UM, "clearance"),
        spans=[(value - each, value + each) for value, each in zip(values, reach, strict=True)],
        upright=True,
        told=[say("history.when_new") if point.visit is None else visits[point.visit].label for point in points],
        hover=f"%{{customdata}}<br>{_hover(say)}",
    )


def _limit(figure: Figure, level: Level, value: float, written: str, say: Wording) -> None:
    look = look_of(level)
    figure.add_hline(
        y=value,
        line={"color": look.screen, "dash": "dash", "width": 2},
        text=f"{say.signed(level)}: {written}",
        xanchor="left",
        x=0.01,
    )


def total_over_mileage(total: TotalOverMileage, say: Wording) -> Figure:
    """Draw the total share at one condition over the mileage ahead, with its interval and the limits of its bands."""
    figure = Figure()
    low, median, high = (np.array(each) * PERCENT for each in (total.low, total.median, total.high))
    mileages = [say.convert(each, "distance") for each in total.mileages]
    figure.band(mileages, low, high, say.percent(MILEAGE_COVERAGE, 0), _BAND)
    hover = f"%{{x:,.0f}} {say.unit('distance')}: %{{y:.1f}} % (%{{customdata[0]:.1f}} – %{{customdata[1]:.1f}})"
    told, name = np.column_stack([low, high]), say("history.total")
    figure.line(mileages, median, SCREEN.leakage, 3, name=name, told=told, hover=hover)
    top = max(float(high[np.isfinite(high)].max(initial=1.0)), 1.0)
    for limit in total.limits:
        if limit.share * PERCENT <= 1.5 * top:
            _limit(figure, limit.level, limit.share * PERCENT, say.percent(limit.share), say)
    figure.update_xaxes(title=_mileage(say), tickformat=",.0f")
    figure.update_yaxes(title=say("history.share"), rangemode="tozero")
    return framed(figure, 380)


def pareto(names: Sequence[str], counts: Sequence[int], of: int, what: str, say: Wording) -> Figure:
    """Draw how often pairs were flagged or replaced, the most often first, with their part of all such pairs so far.

    Parameters
    ----------
    names, counts
        of the pairs, the most often first.
    of
        units that were looked at.
    what
        was done to them: ``"flagged"`` or ``"repaired"``.
    """
    total = sum(counts)
    passed = [sum(counts[: place + 1]) / total * PERCENT if total else math.nan for place in range(len(counts))]
    figure = Figure()
    hover = f"%{{y}}: %{{text}}; %{{customdata:.0f}} % {say('history.with_those_above')}"
    said = {"text": [say("history.of", count=count, of=of) for count in counts], "textposition": "outside"}
    figure.bars(counts, names, say(f"history.{what}"), look_of(Verdict.WATCH), told=passed, hover=hover, **said)
    most = max(counts, default=1)
    figure.update_xaxes(title=say(f"history.{what}"), dtick=1 if most <= _WHOLE else None, range=[0.0, 1.25 * most])
    figure.update_yaxes(type="category", categoryorder="array", categoryarray=list(reversed(names)))
    return framed(figure, 110 + 26 * max(len(names), 3))


def _hover(say: Wording) -> str:
    """Return what a point says of itself: a clearance at a mileage."""
    digits, unit = say.digits("clearance", 1), say.unit("clearance")
    return f"%{{x:,.0f}} {say.unit('distance')}: %{{y:.{digits}f}} {unit}"


def _mileage(say: Wording) -> str:
    return f"{say('columns.mileage')} [{say.unit('distance')}]"
