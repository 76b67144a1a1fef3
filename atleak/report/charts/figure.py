"""Figures on the screen as plain dictionaries: plotly checks every value of its own, which takes fifty times as long.

`Figure.checked` is the same figure as plotly reads it, each value checked: for notebooks and for tests. All have a
transparent ground, the legend on top and room for labels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from atleak.common.style import CLEAR, FAINT_GRID, HATCHING, SCREEN, Look
from atleak.common.wording import Wording, wording

if TYPE_CHECKING:
    import plotly.graph_objects as go

_Span = tuple[float, float]
_Values = Sequence[float | None]
_Mark = tuple[str, str | list[str], int | list[int], float]
HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}


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

    def marks(self, values: _Values, places: Sequence[Any], name: str, look: _Mark, **more: Any) -> None:
        """Draw values as points of a colour, a symbol, a size and a width of outline.

        Values are along the x axis and places along the y axis, or the other way round where ``upright``. With a
        ``factor`` values and their ``spans`` are in SI. ``hover`` is what is said of a point, with what is ``told`` of
        it. Other properties are plotly's.
        """
        colour, symbol, size, edge = look
        line = (
            {"width": edge}
            if isinstance(symbol, str) and symbol.endswith("-open")
            else {"width": edge, "color": colour}
        )
        more["marker"] = {"color": colour, "symbol": symbol, "size": size, "line": line}
        more["mode"] = "markers+text" if more.get("text") else "markers"
        self._valued("scatter", values, places, colour, name=name, **more)

    def bars(
        self, values: _Values, places: Sequence[Any], name: str, look: Look | tuple[str, str], **more: Any
    ) -> None:
        """Draw values as bars, in the shade and hatch of a level or in a colour and a pattern; see `marks`."""
        colour, pattern = (look.screen, look.pattern) if isinstance(look, Look) else look
        more = {"marker": {"color": colour, "pattern": HATCH | {"shape": pattern}}, **more}
        self._valued(
            "bar", values, places, SCREEN.soft, name=name, orientation=None if more.get("upright") else "h", **more
        )

    def line(
        self, x: Any, y: Any, colour: str, width: float, dash: str = "solid", *, shape: str = "linear", **more: Any
    ) -> None:
        """Draw a line, which stands in the legend where it has a name; ``more`` as of `marks`."""
        stroke = {"color": colour, "width": width, "dash": dash, "shape": shape}
        self._hovered("scatter", x=x, y=y, mode="lines", line=stroke, **more)

    def band(self, x: Any, low: Any, high: Any, name: str, colour: str) -> None:
        """Draw the area between two curves."""
        around: dict[str, Any] = {"x": [*x, *reversed(x)], "y": [*high, *reversed(low)], "line": {"width": 0}}
        self._hovered("scatter", **around, fill="toself", fillcolor=colour, name=name)

    def _valued(
        self,
        kind: str,
        values: _Values,
        places: Sequence[Any],
        colour: str,
        *,
        factor: float = 1.0,
        spans: Sequence[_Span | None] | None = None,
        upright: bool = False,
        **more: Any,
    ) -> None:
        across, along = ("y", "x") if upright else ("x", "y")
        known = [0.0 if value is None else value for value in values]
        more[f"error_{across}"] = None if spans is None else error_bars(known, spans, factor, colour)
        more[across] = [None if value is None else value * factor for value in values]
        self._hovered(kind, **{along: places, **more})

    def _hovered(
        self, kind: str, *, hover: str | None = None, told: Any = None, row: int = 1, **properties: Any
    ) -> None:
        """Add a trace; ``hover`` is what it says under the pointer, with what is ``told`` of each point."""
        said = {"hoverinfo": "skip"} if hover is None else {"hovertemplate": f"{hover}<extra></extra>"}
        legend = None if properties.get("name") else False
        self.add(kind, row, **{"showlegend": legend, "customdata": told, **said, **properties})

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
        import plotly.graph_objects as go  # dear to import, and seldom needed

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


def error_bars(
    values: Sequence[float], intervals: Sequence[_Span | None], factor: float, colour: str = SCREEN.soft
) -> dict[str, Any] | None:
    """Return asymmetric error bars; None where nothing has an interval.

    Parameters
    ----------
    values, intervals
        in SI; an interval that is None has no length.
    factor
        from SI to the unit of the axis.
    """
    if all(interval is None for interval in intervals):
        return None
    ends = [(value, value) if end is None else end for value, end in zip(values, intervals, strict=True)]
    return {
        "type": "data",
        "symmetric": False,
        "array": [(high - value) * factor for value, (_, high) in zip(values, ends, strict=True)],
        "arrayminus": [(value - low) * factor for value, (low, _) in zip(values, ends, strict=True)],
        "color": colour,
        "thickness": 1.6,
        "width": 5,
    }


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
