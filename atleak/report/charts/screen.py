"""Draw a chart on the screen: rows over one axis, or spreads over classes of a quantity.

What is spread over units is drawn as boxes: a pale one in which nine of ten units are, a darker one with half of them,
and the median. Of too few units there is a thin line from the least to the most in place of the boxes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from atleak.analysis.rates import Spread
from atleak.common.style import FAINT_GRID, SCREEN, SPREADS_ON_SCREEN, Look
from atleak.common.wording import Wording
from atleak.report.charts.chart import Chart, ClassChart, Field, Layer, RowChart
from atleak.report.charts.figure import HATCH, Figure, error_bars, framed

_WIDTH = 0.86  # of a box, of its class
_ABOVE = 0.27  # the middle of a row, parts of its height: where its name stands
_THICK = 0.7  # of a bar here, of what it is on paper, where its name stands beside it
_ROOM = 4.0  # [%] of a bar's length that a number in it takes
_APART, _BESIDE = 0.01, 1.35  # of the longest row: how far its words stand behind it, and how much room they take
_MIDDLE = SCREEN.leakage  # colour of medians


def drawn(chart: Chart, say: Wording) -> Figure:
    """Return a chart as a figure; of several small ones the first."""
    if isinstance(chart, RowChart):
        return _rows(chart)
    return _classes(chart if isinstance(chart, ClassChart) else chart[0], say)


# --- rows


def _rows(chart: RowChart) -> Figure:
    figure, rows = Figure(), len(chart.names)
    places = list(range(rows))[::-1]
    for number, layer in enumerate(chart.layers):
        named = any((layer.name, layer.look) == (each.name, each.look) for each in chart.layers[:number])
        here = [row for row in range(rows) if layer.values[row] is not None]
        _layer(figure, chart, layer, here, [places[row] + 0.6 * layer.lift for row in here], named=named)
    ends = [max([0.0, *(layer.reach(row) for layer in chart.layers)]) for row in range(rows)]
    longest = max(ends, default=0.0)
    beside = any(chart.beside) and not chart.stacked
    if beside:
        figure.add_scatter(
            x=[end + _APART * longest for end in ends],
            y=places,
            mode="text",
            text=list(chart.beside),
            textposition="middle right",
            cliponaxis=False,
            showlegend=False,
            hoverinfo="skip",
        )
    if chart.zero:
        figure.add_vline(x=0.0, line={"color": SCREEN.rule, "width": 1.5, "dash": "dot"})
    for name, place in zip(chart.names, places, strict=True):  # above its row: names are long, and a phone is narrow
        figure.add_annotation(x=0.0, y=place + _ABOVE, xref="x domain", text=name, xanchor="left", yanchor="bottom")
    most = 100.0 if chart.stacked else _BESIDE * longest if beside and not chart.zero else 0.0
    figure.update_xaxes(title=chart.axis, range=[0.0, most] if most > 0.0 else None)
    figure.update_xaxes(rangemode=None if chart.zero or chart.stacked else "tozero")
    figure.update_yaxes(range=[-_ABOVE - 0.1, rows - 0.2], showticklabels=False, showgrid=False)
    return framed(figure, 170 + 46 * max(rows, 1), barmode="stack" if chart.stacked else "overlay")


def _layer(
    figure: Figure, chart: RowChart, layer: Layer, here: Sequence[int], places: Sequence[float], *, named: bool
) -> None:
    """Draw a layer in the rows where it has a value; ``named`` where another one has its entry of the legend."""
    values, spans = [layer.values[row] or 0.0 for row in here], [layer.span(row) for row in here]
    look = _bars(layer, here, values, stacked=chart.stacked) if layer.thick else _marks(layer, here)
    figure.add(
        "bar" if layer.thick else "scatter",
        x=values,
        y=places,
        name=layer.name,
        showlegend=False if named else None,
        error_x=error_bars(values, spans, 1.0, *(() if layer.thick else (layer.look.screen,))),
        customdata=[layer.hover[row] for row in here] if layer.hover else None,
        hovertemplate="%{customdata}<extra></extra>" if layer.hover else f"{layer.name}: %{{x:.4g}}<extra></extra>",
        **look,
    )


def _bars(layer: Layer, here: Sequence[int], values: Sequence[float], *, stacked: bool) -> dict[str, Any]:
    inside = [layer.inside[number] for number in here] if layer.inside else []
    words = {
        "text": [said if value >= _ROOM else "" for said, value in zip(inside, values, strict=False)],
        "textposition": "inside",
        "insidetextanchor": "middle",
        "constraintext": "none",
        "textangle": 0,
    }
    return {
        "orientation": "h",
        "width": _THICK * layer.thick,
        "marker": {**shade(layer.look), **({"line": {"width": 0}} if stacked else {})},
        **(words if inside else {}),
    }


def _marks(layer: Layer, here: Sequence[int]) -> dict[str, Any]:
    symbol, colour = layer.look.marker, layer.look.screen
    is_open = [layer.open[number] for number in here] if layer.open else [False] * len(here)
    return {
        "mode": "markers",
        "cliponaxis": False,
        "marker": {
            "symbol": [f"{symbol}-open" if each else symbol for each in is_open],
            "size": 10,
            "color": colour,
            "line": {"width": 2 if layer.open or symbol == "line-ns" else 1, "color": colour},
        },
    }


def shade(look: Look) -> dict[str, Any]:
    """Return the colour of a level's bars, and the pattern that tells it without colour."""
    return {"color": look.screen, "pattern": HATCH | {"shape": look.pattern}}


# --- classes


def _classes(chart: ClassChart, say: Wording) -> Figure:
    rows = len(chart.fields)
    figure = Figure(rows=rows, spacing=0.05, heights=[field.height for field in chart.fields])
    for row, field in enumerate(chart.fields, start=1):
        if any(field.spreads):
            _boxes(figure, row, chart, field, say)
            _medians(figure, row, chart, field, say)
            _beside(figure, row, chart, field, say)
        if field.stack:
            _stack(figure, row, chart, field)
        if field.units:
            figure.add_bar(
                row=row,
                **_over(chart.edges),
                y=list(field.units),
                name=field.title,
                marker={"color": SCREEN.rule, "opacity": 0.5, "line": {"width": 0}},
                showlegend=False,
                hovertemplate="%{y:,.0f}<extra></extra>",
            )
            most = max(field.units)
            figure.update_yaxes(row=row, rangemode="tozero", nticks=3, dtick=1 if most < 3 else None)
        figure.update_yaxes(row=row, title=field.title, gridcolor=FAINT_GRID)
    if chart.edges:
        figure.update_xaxes(range=[chart.edges[0][0], chart.edges[-1][1]])
    figure.update_xaxes(row=rows, title=chart.axis)
    return framed(figure, 140 + round(330 * sum(field.height for field in chart.fields)), barmode="overlay")


def _over(edges: Sequence[tuple[float, float]], narrower: float = 0.0) -> dict[str, Any]:
    """Return where bars stand over classes, and how wide they are."""
    return {
        "x": [0.5 * (low + high) for low, high in edges],
        "width": [(high - low) * (_WIDTH - narrower) for low, high in edges],
    }


def _boxes(figure: Figure, row: int, chart: ClassChart, field: Field, say: Wording) -> None:
    """Draw boxes where there are enough units, thin lines elsewhere."""
    known = chart.known(field)
    boxed = [
        (edge, [float(say.convert(part, field.kind)) for part in spread.quantiles])
        for edge, spread, _ in known
        if spread.quantiles is not None
    ]
    edges = [edge for edge, _ in boxed]
    for number, shade_of_box in enumerate(SPREADS_ON_SCREEN):
        figure.add_bar(
            row=row,
            **_over(edges, 0.3 * number),
            base=[parts[number] for _, parts in boxed],
            y=[parts[-1 - number] - parts[number] for _, parts in boxed],
            name=say(f"fleet.{'half' if number else 'most'}"),
            legendgroup=f"spread-{number}",
            showlegend=row == 1,
            marker={"color": shade_of_box, "line": {"width": 0}},
            hoverinfo="skip",
        )
    few = [(0.5 * sum(edge), spread) for edge, spread, _ in known if spread.quantiles is None]
    ends = [end for _, spread in few for end in (spread.least, spread.most, None)]
    figure.add_scatter(
        row=row,
        x=[at for middle, _ in few for at in (middle, middle, None)],
        y=[None if end is None else float(say.convert(end, field.kind)) for end in ends],
        mode="lines",
        name=say("fleet.few"),
        legendgroup="few",
        showlegend=row == 1 and bool(few),
        line={"color": _MIDDLE, "width": 1.5},
        hoverinfo="skip",
    )


def _medians(figure: Figure, row: int, chart: ClassChart, field: Field, say: Wording) -> None:
    known = chart.known(field)
    figure.add_scatter(
        row=row,
        x=[0.5 * sum(edge) for edge, _, _ in known],
        y=[float(say.convert(spread.median, field.kind)) for _, spread, _ in known],
        mode="markers+lines",
        name=say("fleet.median"),
        legendgroup="median",
        showlegend=row == 1,
        line={"color": _MIDDLE, "width": 2},
        marker={
            "size": 9,
            "color": _MIDDLE,
            "symbol": ["circle" if spread.quantiles else "circle-open" for _, spread, _ in known],
            "line": {"width": 2, "color": _MIDDLE},
        },
        customdata=[f"{name}<br>{_spread_words(spread, field.kind, say)}" for _, spread, name in known],
        hovertemplate="%{customdata}<extra></extra>",
    )


def _spread_words(spread: Spread, kind: str, say: Wording) -> str:
    units = say("fleet.units", count=spread.units)
    median = say("fleet.median_of", value=say.quantity(spread.median, kind))
    if spread.quantiles is None:
        ends = say("fleet.from_to", ends=say.span([spread.least, spread.most], kind))
        return f"{median}, {ends}<br>{say('fleet.few_of', units=units)}"
    most, half = (say.span([spread.quantiles[at], spread.quantiles[-1 - at]], kind) for at in range(2))
    return f"{median}<br>{say('fleet.most')}: {most}<br>{say('fleet.half')}: {half}<br>{units}"


def _beside(figure: Figure, row: int, chart: ClassChart, field: Field, say: Wording) -> None:
    """Draw the mean of all, and the largest or the lowest of any."""
    pointed = "triangle-up-open" if field.extreme == "largest" else "triangle-down-open"
    for what, values, symbol in (("mean", field.means, "diamond"), (field.extreme, field.extremes, pointed)):
        here = [(edge, value) for edge, value in zip(chart.edges, values, strict=False) if value is not None]
        if here:
            figure.add_scatter(
                row=row,
                x=[0.5 * sum(edge) for edge, _ in here],
                y=[float(say.convert(value, field.kind)) for _, value in here],
                mode="markers",
                name=say(f"fleet.{what}"),
                legendgroup=what,
                showlegend=what != "mean" or row == 1,
                marker={"symbol": symbol, "size": 8, "color": SCREEN.ink, "line": {"width": 1.5, "color": SCREEN.ink}},
                customdata=[say.quantity(value, field.kind) for _, value in here],
                hovertemplate=f"{say(f'fleet.{what}')}: %{{customdata}}<extra></extra>",
            )


def _stack(figure: Figure, row: int, chart: ClassChart, field: Field) -> None:
    base = [0.0] * len(chart.edges)
    for name, look, parts in field.stack:
        figure.add_bar(
            row=row,
            **_over(chart.edges),
            y=list(parts),
            base=list(base),
            name=name,
            showlegend=any(parts),
            marker={**shade(look), "line": {"width": 0}},
            customdata=list(field.hover),
            hovertemplate=f"{name}: %{{y:.1f}} %<br>%{{customdata}}<extra></extra>",
        )
        base = [below + part for below, part in zip(base, parts, strict=True)]
    figure.update_yaxes(row=row, range=[0.0, 100.0])
