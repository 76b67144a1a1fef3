"""Lay out every figure on the screen: transparent ground, legend on top, space for labels, error bars."""

from __future__ import annotations

from collections.abc import Sequence

from atleak.figures.figure import Figure
from atleak.look import CLEAR, FAINT_GRID
from atleak.wording import Wording, wording


def framed(figure: Figure, height: int, top: int = 36, **layout: object) -> Figure:
    """Give the figure the page's ground and narrow margins; ``height`` and ``top`` in pixels."""
    figure.update_layout(
        height=height,
        paper_bgcolor=CLEAR,
        plot_bgcolor=CLEAR,
        margin={"l": 8, "r": 8, "t": top, "b": 8},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "xanchor": "left"},
        **layout,
    )
    figure.update_xaxes(automargin=True, zeroline=False, gridcolor=FAINT_GRID)
    figure.update_yaxes(automargin=True, zeroline=False)
    return figure


def by_land(
    figure: Figure, names: Sequence[str], height: int, say: Wording | None = None, bargap: float | None = None
) -> Figure:
    """Give a figure one row per land, the first on top; ``height`` is that of a row in pixels."""
    order = list(reversed(names))
    figure.update_yaxes(
        title=(say or wording("en"))("figures.by_land"), type="category", categoryorder="array", categoryarray=order
    )
    return framed(figure, 110 + height * max(len(names), 3), bargap=bargap)
