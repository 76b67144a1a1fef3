"""Draw a chart on paper: rows over one axis, or spreads over classes of a quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from atleak.analysis.rates import Spread
from atleak.common.style import PAPER_INKS, SPREADS, Look
from atleak.common.wording import Wording
from atleak.report.charts import paper_axes as plotting
from atleak.report.charts.chart import Chart, ClassChart, Field, Layer, RowChart
from atleak.report.charts.paper_axes import (
    BELOW,
    SIZE,
    WIDTH,
    axis_words,
    bar_of,
    interval,
    places,
    rows_of_labels,
    sign,
    upright_title,
    widest,
)
from atleak.report.printed_fonts import fitting, width_of

_ROW, _MARK, _THIN = 14.0, 4.5, 0.7  # [pt] of a row, and of each further mark in it; height of a bar, of its row
_LEFT, _RIGHT = 48.0, 14.0  # [pt] of a field: for its values and title, and to the edge
_ACROSS, _BETWEEN = 2, 20.0  # charts beside one another
_TICKS, _THOUSAND = 5, 1000.0  # of a small chart: numbers of neighbours would run into one another
_TITLE, _UNITS, _SMALL = 15.0, 11.0, 62.0  # [pt] heights of a small chart: title, numbers of units, field
_HIGH = 254.0  # [pt] of all fields above one another
_GAP = 12.0  # [pt] between them
_GROUND = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85}  # behind words on a grid
_BOLD = 1.1  # how much wider bold letters are than plain ones, at most


def drawn_on_paper(chart: Chart, say: Wording, *, scale: float = 1.0) -> str:
    """Return a chart as SVG; ``scale`` is that of the height of plots above one another, where there is little room."""
    if isinstance(chart, RowChart):
        return _rows(chart, say)
    return _fields(chart, say, scale) if isinstance(chart, ClassChart) else _small_charts(chart, say)


# --- rows


def _rows(chart: RowChart, say: Wording) -> str:
    rows = range(len(chart.names))
    high = max(chart.ends, default=1.0)
    marks = sum(not layer.thick for layer in chart.layers)
    right = 100.0 if chart.stacked else high * (1.04 if marks > 1 else 1.0)
    height = _ROW + 5.0 if chart.stacked else _ROW + _MARK * max(marks - 1, 0)
    room = widest(chart.beside) + 12.0
    with rows_of_labels(chart.names, height, right, room, chart.axis, say) as (figure, axes):
        if chart.zero:
            axes.set_xlim(min([0.0, *chart.ends]), max([0.0, *chart.ends]))
            axes.axvline(0.0, color=PAPER_INKS.rule, lw=1.0, ls=":")
        point = axes.get_position().width * WIDTH / right  # [pt] of a unit of the axis
        for row, place in zip(rows, places(chart.names), strict=True):
            reached = 0.0
            for layer in chart.layers:
                if layer.values[row] is not None:
                    begin = reached if chart.stacked else 0.0
                    reached = max(reached, _drawn(axes, layer, row, place, begin, point))
            if chart.beside:
                at = right if chart.stacked or marks > 1 else reached
                axis_words(axes, (at, place), chart.beside[row], (5.0, 0.0), bbox=None if chart.stacked else _GROUND)
        for number in range(1, len(chart.names) if marks > 1 else 0):
            axes.axhline(number - 0.5, color=PAPER_INKS.rule, lw=0.5)
        return plotting.svg(figure)


def _drawn(axes: Axes, layer: Layer, number: int, place: int, begin: float, point: float) -> float:
    """Draw what a layer shows of a row, and return where it ends; ``point`` is the width of a unit on paper [pt]."""
    value, at = layer.values[number] or 0.0, place + layer.lift
    end = begin + value
    if not layer.thick:
        span = layer.span(number)
        if span is not None:
            interval(axes, *span, at)
        sign(axes, layer.look, value, at)
        return 0.0
    if value:
        bar_of(axes, end, at, layer.thick, layer.look, begin)
    said = layer.inside[number] if layer.inside else ""
    if said and width_of(said, SIZE) + 5.0 < value * point:  # strokes of a hatch stand back from them
        ground = {"boxstyle": "square,pad=0.12", "fc": layer.look.fill, "ec": "none"} if layer.look.hatch else None
        middle = 0.5 * (begin + end), at
        axis_words(axes, middle, said, ha="center", color=layer.look.on_fill, bbox=ground, zorder=4)
    span = layer.span(number)
    if span is not None:
        interval(axes, *span, at)
    return max(end, span[1]) if span is not None else end


# --- classes


def _small_charts(charts: Sequence[ClassChart], say: Wording) -> str:
    """Draw the first plot of several charts, all over the same axes, with the number of units of each class.

    A wide box holds nine of ten units, a narrow one half of them; the line in it is the median. Fewer than ten units
    are a line from the least to the most.
    """
    low, high = _ends(charts)
    bottom, top = _reach([spread for chart in charts for spread in chart.fields[0].spreads], ())
    rows = math.ceil(len(charts) / _ACROSS)
    height = _TITLE + _UNITS + _SMALL + _GAP
    wide = (WIDTH - _LEFT - _RIGHT - _BETWEEN * (_ACROSS - 1)) / _ACROSS
    with plotting.drawing():
        figure = plotting.figure_of(rows * height + BELOW)
        for number, chart in enumerate(charts):
            row, column = divmod(number, _ACROSS)
            left, (field, *_) = _LEFT + column * (wide + _BETWEEN), chart.fields
            axes = plotting.field(figure, left, left + wide, row * height + _TITLE + _UNITS, _SMALL)
            axes.set_xlim(low, high)
            axes.set_ylim(bottom, top)
            plotting.number_axes(axes, say, "x", "y", most=5)
            last = number + _ACROSS >= len(charts)
            axes.xaxis.set_major_locator(MaxNLocator(_TICKS, steps=(1, 2, 5, 10)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value / _THOUSAND, 5)))
            axes.tick_params(labelbottom=last, labelleft=column == 0)
            if last:
                axes.set_xlabel(chart.thousands)
            if column == 0:
                upright_title(axes, field.title, _LEFT)
            name = fitting(chart.name, SIZE, wide / _BOLD)
            axis_words(axes, (low, top), name, (0.0, _UNITS + 6.0), fontweight="bold", va="center")
            for edge, spread in zip(chart.edges, field.spreads, strict=True):
                _spread(axes, edge, spread)
            _units_above(axes, chart, field, wide / (high - low))
        return plotting.svg(figure)


def _ends(charts: Sequence[ClassChart]) -> tuple[float, float]:
    edges = [edge for chart in charts for edge in chart.edges]
    return min((low for low, _ in edges), default=0.0), max((high for _, high in edges), default=1.0)


def _units_above(axes: Axes, chart: ClassChart, field: Field, point: float) -> None:
    """Write the number of units over each class, or over every so many classes where they are narrow.

    ``point`` is the width on paper of a unit of the axis [pt].
    """
    (_, top), units = axes.get_ylim(), [str(each.units) if each else "" for each in field.spreads]
    narrowest = min(((end - begin) * point for begin, end in chart.edges), default=1.0)
    step = max(math.ceil((widest(units) + 5.0) / narrowest), 1)
    for (begin, end), number in list(zip(chart.edges, units, strict=True))[::step]:
        axis_words(axes, (0.5 * (begin + end), top), number, (0.0, 6.0), ha="center", color=PAPER_INKS.soft)


def _reach(
    spreads: Sequence[Spread | None], beside: Sequence[float | None], *, from_zero: bool = True
) -> tuple[float, float]:
    """Return between which values an axis shows spreads and what is drawn beside them."""
    ends = [end for each in spreads if each for end in each.most_of_all] + [each for each in beside if each is not None]
    low, high = min(ends, default=0.0), max(ends, default=0.0)
    if from_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    room = 0.06 * (high - low) or 1.0
    return (low if low == 0.0 else low - room), high + room


def _spread(axes: Axes, edge: tuple[float, float], spread: Spread | None, scale: float = 1.0) -> None:
    """Draw how values of units are spread, over a stretch of the axis; ``scale`` is from their unit to the axis'."""
    if spread is None:
        return
    middle, wide = 0.5 * sum(edge), edge[1] - edge[0]
    low, high = (end * scale for end in spread.most_of_all)
    if spread.quantiles is None:
        axes.plot([middle, middle], [low, high], color=PAPER_INKS.soft, lw=0.8, marker="_", ms=4, zorder=3)
        part = 0.3
    else:
        half = spread.quantiles[1] * scale, spread.quantiles[-2] * scale
        for (bottom, top), part, colour in ((low, high), 0.8, SPREADS[0]), (half, 0.5, SPREADS[1]):
            _bar(axes, edge, bottom, top - bottom, part, color=colour, edgecolor=PAPER_INKS.ink)
    reach = 0.5 * part * wide
    axes.plot([middle - reach, middle + reach], [spread.median * scale] * 2, color=PAPER_INKS.ink, lw=1.6, zorder=4)


def _bar(axes: Axes, edge: tuple[float, float], bottom: float, high: float, part: float = 0.8, **look: Any) -> None:
    """Draw an upright bar over a part of a stretch of the axis."""
    axes.bar(0.5 * sum(edge), high, bottom=bottom, width=part * (edge[1] - edge[0]), lw=0.5, zorder=2, **look)


def _fields(chart: ClassChart, say: Wording, scale: float) -> str:
    """Draw plots above one another. Boxes are as of small charts; a diamond is the mean of all."""
    heights = [_HIGH * scale * field.height for field in chart.fields]
    with plotting.drawing():
        figure = plotting.figure_of(6.0 + sum(heights) + _GAP * (len(heights) - 1) + BELOW)
        above = 6.0
        for field, height in zip(chart.fields, heights, strict=True):
            axes = plotting.field(figure, _LEFT, WIDTH - _RIGHT, above, height)
            _field(axes, chart, field, say)
            axes.set_xlim(*_ends([chart]))
            plotting.number_axes(axes, say, "x", most=10)
            plotting.number_axes(axes, say, "y", most=max(int(height / 18.0), 2))
            if field.units:  # of which there is no half
                axes.yaxis.set_major_locator(MaxNLocator(max(int(height / 18.0), 2), integer=True))
            upright_title(axes, field.title, _LEFT)
            axes.tick_params(labelbottom=field is chart.fields[-1], bottom=field is chart.fields[-1])
            above += height + _GAP
        axes.set_xlabel(chart.axis)
        return plotting.svg(figure)


def _field(axes: Axes, chart: ClassChart, field: Field, say: Wording) -> None:
    scale = say.convert(1.0, field.kind)
    if field.spreads:
        axes.set_ylim(*(end * scale for end in _reach(field.spreads, field.means, from_zero=field.from_zero)))
    for edge, spread in zip(chart.edges, field.spreads, strict=False):
        _spread(axes, edge, spread, scale)
    for edge, mean in zip(chart.edges, field.means, strict=False):
        if mean is not None:
            axes.plot([0.5 * sum(edge)], [mean * scale], "D", ms=3.5, color=PAPER_INKS.leakage, mec="white", zorder=5)
    if field.stack:
        axes.set_ylim(0.0, 100.0)
        _stack(axes, chart, field.stack)
    for edge, units in zip(chart.edges, field.units, strict=False):
        _bar(axes, edge, 0.0, units, color=PAPER_INKS.metal, edgecolor=PAPER_INKS.ink)


def _stack(axes: Axes, chart: ClassChart, stack: Sequence[tuple[str, Look, Sequence[float]]]) -> None:
    for number, edge in enumerate(chart.edges):
        bottom = 0.0
        for _, look, parts in stack:
            if parts[number]:
                _bar(axes, edge, bottom, parts[number], color=look.fill, edgecolor=look.line, hatch=look.hatch)
            bottom += parts[number]
