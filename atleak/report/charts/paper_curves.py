"""Draw curves on paper as SVG, told apart by dashes: leakage over a road test, the pump over engine speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter

import numpy as np
from matplotlib.axes import Axes

from atleak.common.style import PAPER_INKS
from atleak.common.units import DM3_MIN, RPM
from atleak.common.verdicts import Band
from atleak.common.wording import Wording
from atleak.report.charts import paper_axes as plotting
from atleak.report.charts.paper_axes import BELOW, SIZE, WIDTH, axis_words, interval, upright_title, widest
from atleak.report.printed_fonts import fitting, width_of
from atleak.report.tables.pressures import PumpOverSpeed
from atleak.report.tables.road_test import RoadSeries

_RIGHT = WIDTH - 14.0
_BETWEEN = 10.0  # two fields
_HIGH, _LOW, _PUMP = 82.0, 66.0, 76.0  # heights of fields
_DASHES = ((5, 2), (2, 1.5), (1, 1.5), (8, 2, 1, 2), (5, 2, 1, 2, 1, 2))  # of curves that differ by temperature
_LEGEND_ROW, _MARK_ROW = 13.0, 12.0  # of the legend, and of the words of engine speeds below it
_FIELD = 50.0  # about where a field begins

_Mark = tuple[float, float | None, float | None]


def road_chart(series: RoadSeries, marks: Sequence[_Mark], bands: Sequence[tuple[Band, float]], say: Wording) -> str:
    """Draw leakage over time and, where they are known, the pump's capacity and the share, each over its own axis.

    Parameters
    ----------
    marks
        (time [s], leakage [dm³/min], share [%]) of the instants to number, in their order.
    bands
        (name, share [%]) at which each band begins.
    """
    columns, unit = series.columns, say.unit("flow")
    leakage, share = say.convert(columns["leakage_dm3_min"], "flow"), columns.get("share_percent")
    curves = [(say("charts.leakage_in", unit=unit), leakage, _HIGH, PAPER_INKS.leakage)]
    if share is not None:
        capacity = say.convert(columns["pump_capacity_dm3_min"], "flow")
        curves.append((say("charts.capacity_in", unit=unit), capacity, _LOW, PAPER_INKS.pump))
        curves.append((say("charts.share"), share, _HIGH, PAPER_INKS.ink))
    time, tops = columns["time_s"], [_top_of(values) for _, values, *_ in curves]
    left = _left_of(tops, say)
    with plotting.drawing():
        figure = plotting.figure_of(8.0 + sum(height + _BETWEEN for _, _, height, _ in curves) - _BETWEEN + BELOW)
        fields, above = [], 8.0
        for (title, values, height, colour), top in zip(curves, tops, strict=True):
            axes = plotting.field(figure, left, _RIGHT, above, height)
            axes.plot(time, values, color=colour, lw=1.2)
            axes.set_ylim(0.0, top)
            axes.set_xlim(float(time[0]), max(float(time[-1]), float(time[0]) + 1.0))
            plotting.number_axes(axes, say, "x")  # the same lines in all of them
            plotting.number_axes(axes, say, "y", most=max(int(height / 18.0), 2))
            upright_title(axes, title, left)
            axes.tick_params(labelbottom=False, bottom=False)
            fields.append(axes)
            above += height + _BETWEEN
        fields[-1].tick_params(labelbottom=True, bottom=True)
        fields[-1].set_xlabel(say("charts.time"))
        if share is not None:
            _bands(fields[-1], bands, say)
        for number, (at, leaks, part) in enumerate(marks, start=1):
            _mark(fields[0], at, None if leaks is None else say.convert(leaks, "flow"), number)
            if share is not None:
                _mark(fields[-1], at, part, number)
        return plotting.svg(figure)


def _top_of(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return (1.12 * float(known.max()) if len(known) else 1.0) or 1.0


def _left_of(tops: Sequence[float], say: Wording) -> float:
    """Return the room for a title and for the values beside axes that end there."""
    digits = [f"{10.0 ** math.floor(math.log10(top)):g}" for top in tops]
    return 26.0 + widest([say.plain(2.5 * float(each), 5) for each in digits], SIZE)


def _bands(axes: Axes, bands: Sequence[tuple[Band, float]], say: Wording) -> None:
    (_, top), (_, end) = axes.get_ylim(), axes.get_xlim()
    for name, begins in bands:
        if begins < top:
            axes.axhline(begins, color=PAPER_INKS.ink, lw=0.7, ls=(0, (1.5, 1.5)))
            halo = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85}
            said = f"{say.level(name)} ≥ {say.plain(begins)} %"
            axis_words(axes, (end, begins), said, (-2.0, 1.5), ha="right", va="bottom", bbox=halo, zorder=4)


def _mark(axes: Axes, time: float, value: float | None, number: int) -> None:
    if value is None or not math.isfinite(value):
        return
    axes.plot(
        [time],
        [value],
        marker="o",
        ms=10.5,
        mfc="white",
        mec=PAPER_INKS.ink,
        mew=0.9,
        ls="none",
        zorder=5,
        clip_on=False,
    )
    axis_words(axes, (time, value), str(number), ha="center", va="center_baseline", zorder=6)


def pump_chart(data: PumpOverSpeed, say: Wording) -> str:
    """Draw the pump's supply over engine speed against what is taken from it at each temperature.

    The crossing at the condition's own temperature carries its engine speed and its 95 % interval; upright lines are
    the engine speeds that are marked.
    """
    flow = say.convert(DM3_MIN, "flow")
    names = [say("charts.supply")]
    for each in data.demands:
        names.append(say("charts.taken_at", temperature=say.plain_value(each.temperature, "temperature")))
    columns = max(int((WIDTH - 16.0) / (widest(names) + 42.0)), 1)
    top = 8.0 + _LEGEND_ROW * math.ceil(len(names) / columns) + _MARK_ROW * len(data.marked)
    highest = 1.05 * max(float(data.supply[-1]), *(each.flow for each in data.demands)) * flow or 1.0
    with plotting.drawing():
        figure = plotting.figure_of(top + _PUMP + BELOW)
        axes = plotting.field(figure, _left_of([highest], say), _RIGHT, top, _PUMP)
        axes.plot(data.speeds * RPM, data.supply * flow, color=PAPER_INKS.pump, lw=1.6, label=names[0])
        for number, (each, name) in enumerate(zip(data.demands, names[1:], strict=True)):
            own, taken = each.of_condition, each.flow * flow
            look = (
                (PAPER_INKS.leakage, 1.4, "-") if own else (PAPER_INKS.soft, 0.8, (0, _DASHES[number % len(_DASHES)]))
            )
            axes.axhline(taken, color=look[0], lw=look[1], ls=look[2], label=name)
            axes.plot([each.crossing * RPM], [taken], "o", ms=6 if own else 3, color=PAPER_INKS.ink, zorder=5)
        axes.set_xlim(0.0, float(data.speeds[-1]) * RPM)
        axes.set_ylim(0.0, highest)
        for number, (label, speed) in enumerate(sorted(data.marked, key=itemgetter(1))):
            _marked_speed(axes, speed * RPM, number, f"{label}: {say.quantity(speed * RPM, 'engine_speed')}")
        _crossing(axes, data, say)
        axes.set_xlabel(say("charts.speed"))
        upright_title(axes, say("charts.flow"), _left_of([highest], say))
        plotting.number_axes(axes, say, "x", "y")
        lines = axes.get_legend_handles_labels()[0]
        by_column = [line for column in range(columns) for line in lines[column::columns]]  # to be read along the rows
        figure.legend(
            handles=by_column,
            loc="upper left",
            ncols=columns,
            frameon=False,
            fontsize=SIZE,
            borderaxespad=0.0,
            bbox_to_anchor=(0.0, 1.0),
        )
        return plotting.svg(figure)


def _marked_speed(axes: Axes, speed: float, row: int, said: str) -> None:
    """Draw an engine speed as an upright line, its words in a row above the field on the side that has more room.

    The lowest speed has the lowest row, so that no line crosses the words of another one.
    """
    (_, end), (_, top) = axes.get_xlim(), axes.get_ylim()
    above = (row + 0.5) * _MARK_ROW
    reach = top * (1.0 + (above + 3.0) / _PUMP)
    axes.plot([speed, speed], [0.0, reach], color=PAPER_INKS.ink, lw=0.8, ls=(0, (6, 2)), clip_on=False)
    place = speed / end
    room, off, side = ((1.0 - place), 4.0, "left") if place < 0.5 else (place, -4.0, "right")
    axis_words(axes, (speed, top), fitting(said, SIZE, room * (_RIGHT - _FIELD) - 6.0), (off, above), ha=side)


def _crossing(axes: Axes, data: PumpOverSpeed, say: Wording) -> None:
    """Mark where the supply meets what is taken at the condition's temperature, with the speed and its interval."""
    demand, flow = data.demand, say.convert(DM3_MIN, "flow")
    speed, taken, (_, end) = demand.crossing * RPM, demand.flow * flow, axes.get_xlim()
    if not speed <= end:
        return
    if data.interval is not None:
        low, high = (min(each * RPM, end) for each in data.interval)
        interval(axes, low, high, taken)
    said = say.quantity(speed, "engine_speed")
    left = 1.1 * width_of(said, SIZE) + 4.0 < speed / end * (_RIGHT - 60.0)
    off, side = ((-4.0, 9.0), "right") if left else ((4.0, 9.0), "left")
    axis_words(axes, (speed, taken), said, off, ha=side, fontsize=SIZE, fontweight="bold")
