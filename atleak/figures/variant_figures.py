"""Draw the source study's charts with plotly; background and text are left to the page's theme."""

from __future__ import annotations

from typing import Any

from atleak.figures.figure import Figure
from atleak.variants.charts import Chart, Line

_HEIGHT, _UPPER = 520, 0.28
_GRID = "rgba(128,128,128,0.25)"  # seen on white and on black


def figure(chart: Chart) -> Figure:
    """Return a chart of `atleak.variants.charts` as a plotly figure."""
    rows = 2 if chart.has_upper else 1
    drawn = Figure(rows, 0.06, [_UPPER, 1.0 - _UPPER] if rows == 2 else None)
    for line in chart.lines:
        drawn.add_scatter(1 if line.panel == "upper" else rows, **_properties(line))
    for mark in chart.marks:
        drawn.add_vline(mark.x, {"color": mark.color, "dash": mark.dash, "width": 1.5})
        key = {"color": mark.color, "dash": mark.dash, "width": 1.5}
        drawn.add_scatter(rows, x=[None], y=[None], mode="lines", name=mark.text, line=key)
    _draw_spans(drawn, chart)
    drawn.update_xaxes(gridcolor=_GRID, zeroline=False)
    drawn.update_yaxes(gridcolor=_GRID, zerolinecolor=_GRID)
    drawn.update_xaxes(title=chart.x_label, row=rows)
    drawn.update_yaxes(title=chart.y_label, type="log" if chart.log_y else "linear", row=rows)
    if not chart.log_y:
        drawn.update_yaxes(rangemode="tozero")
    if rows == 2:
        drawn.update_yaxes(title=chart.upper_label, row=1)
    drawn.update_layout(
        height=_HEIGHT if rows == 1 else _HEIGHT + 140,
        margin={"l": 10, "r": 10, "t": 30, "b": 10},
        legend={
            "orientation": "h",
            "yref": "container",
            "yanchor": "bottom",
            "y": 0.0,
            "x": 0.0,
            "groupclick": "togglegroup",
        },
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        meta={"description": chart.description},
    )
    return drawn


def _properties(line: Line) -> dict[str, Any]:
    """Return plotly's properties of a line's trace."""
    modes = [word for word, wanted in (("lines", line.dash), ("markers", line.symbol), ("text", line.text)) if wanted]
    stroke = {"color": line.color, "dash": line.dash, "width": line.width} if line.dash else None
    marker = None
    if line.symbol:
        shape = line.symbol if line.filled else f"{line.symbol}-open"
        edge = 0 if line.filled else 2
        marker = {"color": line.color, "symbol": shape, "size": 9 if line.filled else 13, "line": {"width": edge}}
    return {
        "x": line.x,
        "y": line.y,
        "name": line.name,
        "mode": "+".join(modes),
        "line": stroke,
        "marker": marker,
        "text": line.text or None,
        "textposition": "top center",
        "legendgroup": line.group or None,
        "showlegend": line.in_legend,
        "connectgaps": False,
        "cliponaxis": line.dash is not None,
        "hovertemplate": f"{line.name}<br>%{{x:.4g}}: %{{y:.4g}}<extra></extra>",
    }


def _draw_spans(drawn: Figure, chart: Chart) -> None:
    for start, stop, text in chart.spans:
        drawn.add_annotation(
            x=0.5 * (start + stop), y=1.0, yref="paper", xref="x", yanchor="bottom", text=text,
            font={"size": 12},
        )  # fmt: skip
    for start, _, _ in chart.spans[1:]:
        drawn.add_vline(start, {"color": "rgba(128,128,128,0.5)", "width": 1, "dash": "dot"})
