"""Hold a figure as plain dictionaries: plotly checks every value of its own, which takes fifty times as long.

`Figure.checked` is the same figure as plotly reads it, each value checked: for notebooks and for tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go


class Figure:
    """Traces and layout of a plotly figure, with one plot or several that share their x axis, one above the other.

    Properties are those of plotly; one that is None is left out. A row counts from 1, the first on top.
    """

    def __init__(self, rows: int = 1, spacing: float = 0.0, heights: Sequence[float] | None = None) -> None:
        """Lay out the rows; ``spacing`` between them and their ``heights`` are parts of the whole."""
        self.rows = rows
        self.traces: list[dict[str, Any]] = []
        self.look: dict[str, Any] = {}
        parts = heights or [1.0] * rows
        free, end = 1.0 - spacing * (rows - 1), 1.0
        for row, part in enumerate(parts, start=1):
            begin = max(end - free * part / sum(parts), 0.0)
            x, y = self._axes(row)
            self.look[f"xaxis{x[1:]}"] = {"anchor": y}
            self.look[f"yaxis{y[1:]}"] = {"anchor": x}
            if rows > 1:
                self.look[f"yaxis{y[1:]}"]["domain"] = [begin, min(end, 1.0)]
            if row < rows:
                self.look[f"xaxis{x[1:]}"] |= {"matches": f"x{rows}", "showticklabels": False}
            end = begin - spacing

    @staticmethod
    def _axes(row: int) -> tuple[str, str]:
        """Return the names of a row's axes, as traces and shapes give them."""
        return ("x", "y") if row == 1 else (f"x{row}", f"y{row}")

    def add(self, kind: str, row: int = 1, **properties: Any) -> None:
        """Add a trace of one of plotly's kinds."""
        x, y = self._axes(row)
        self.traces.append({"type": kind, "xaxis": x, "yaxis": y, **_given(properties)})

    def add_scatter(self, row: int = 1, **properties: Any) -> None:
        """Add points, lines or words."""
        self.add("scatter", row, **properties)

    def add_bar(self, **properties: Any) -> None:
        """Add bars."""
        self.add("bar", **properties)

    def add_shape(self, **properties: Any) -> None:
        """Add a line or an area."""
        self.look.setdefault("shapes", []).append(_given(properties))

    def add_annotation(self, **properties: Any) -> None:
        """Add words at a place."""
        self.look.setdefault("annotations", []).append({"showarrow": False, **_given(properties)})

    def add_hline(self, y: float, line: dict[str, Any], row: int = 1, **words: Any) -> None:
        """Draw a level line across a row, with words above its right end, or where else these say."""
        x_axis, y_axis = self._axes(row)
        across = {"xref": f"{x_axis} domain", "yref": y_axis}
        self.add_shape(type="line", x0=0.0, x1=1.0, y0=y, y1=y, line=line, **across)
        if words:
            self.add_annotation(**{"x": 1.0, "y": y, "xanchor": "right", "yanchor": "bottom", **across, **words})

    def add_vline(self, x: float, line: dict[str, Any], **words: Any) -> None:
        """Draw an upright line across every row, with words beside the top of the first, or where else these say."""
        for row in range(1, self.rows + 1):
            x_axis, y_axis = self._axes(row)
            across = {"xref": x_axis, "yref": f"{y_axis} domain"}
            self.add_shape(type="line", x0=x, x1=x, y0=0.0, y1=1.0, line=line, **across)
            if words and row == 1:
                self.add_annotation(**{"x": x, "y": 1.0, "xanchor": "right", "yanchor": "top", **across, **words})

    def update_xaxes(self, row: int | None = None, **properties: Any) -> None:
        """Set properties of the x axis of a row, or of every one."""
        self._update_axes("xaxis", row, properties)

    def update_yaxes(self, row: int | None = None, **properties: Any) -> None:
        """Set properties of the y axis of a row, or of every one."""
        self._update_axes("yaxis", row, properties)

    def _update_axes(self, which: str, row: int | None, properties: dict[str, Any]) -> None:
        given = _given(properties)
        if isinstance(given.get("title"), str):
            given["title"] = {"text": given["title"]}
        for each in range(1, self.rows + 1) if row is None else [row]:
            self.look[f"{which}{each if each > 1 else ''}"].update(given)

    def update_layout(self, **properties: Any) -> None:
        """Set properties of the whole."""
        self.look.update(_given(properties))

    def to_dict(self) -> dict[str, Any]:
        """Return the figure as plotly's JSON has it; its arrays may be numpy's."""
        return {"data": self.traces, "layout": self.look}

    def checked(self) -> go.Figure:
        """Return the figure as plotly reads it.

        Raises
        ------
        ValueError
            a property that plotly does not know, or a value that it does not take.
        """
        return go.Figure(self.to_dict())

    @property
    def data(self) -> Any:
        """Return the traces as plotly reads them."""
        return self.checked().data

    @property
    def layout(self) -> Any:
        """Return the layout as plotly reads it."""
        return self.checked().layout


def _given(properties: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in properties.items() if value is not None}
