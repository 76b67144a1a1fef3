"""A figure held as plain dictionaries is what plotly makes of the same words, without plotly checking each of them."""

from __future__ import annotations

import json

import plotly.graph_objects as go
import pytest
from plotly.subplots import make_subplots

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts import land_figures as figures
from atleak.report.charts.figure import Figure


@pytest.mark.parametrize(("rows", "spacing", "heights"), [(1, 0.0, None), (3, 0.06, None), (2, 0.1, [0.28, 0.72])])
def test_rows_lie_where_plotly_lays_them(rows: int, spacing: float, heights: list[float] | None) -> None:
    mine = Figure(rows, spacing, heights)
    theirs = make_subplots(rows=rows, shared_xaxes=True, vertical_spacing=spacing, row_heights=heights)
    for row in range(1, rows + 1):
        mine.add_scatter(row, x=[1.0, 2.0], y=[3.0, 4.0])
        theirs.add_trace(go.Scatter(x=[1.0, 2.0], y=[3.0, 4.0]), row=row, col=1)
    whole = (0.0, 1.0)  # as plotly takes an axis that says nothing
    for row in range(1, rows + 1):
        name = "yaxis" if row == 1 else f"yaxis{row}"
        assert (mine.layout[name].domain or whole) == pytest.approx(theirs.layout[name].domain, abs=1e-12)
    for mine_axis, their_axis in zip(mine.checked().select_xaxes(), theirs.select_xaxes(), strict=True):
        assert (mine_axis.matches, mine_axis.showticklabels) == (their_axis.matches, their_axis.showticklabels)
    assert [(trace.xaxis, trace.yaxis) for trace in mine.data] == [(trace.xaxis, trace.yaxis) for trace in theirs.data]


def test_lines_across_a_plot_are_those_of_plotly() -> None:
    mine, theirs = Figure(), go.Figure()
    for figure in (mine, theirs):
        figure.add_scatter(x=[0.0, 4.0], y=[0.0, 2.0])
        figure.add_hline(y=1.0, line={"width": 2})
        figure.add_vline(x=3.0, line={"width": 1})
    for shape, other in zip(mine.layout.shapes, theirs.layout.shapes, strict=True):
        assert shape.to_plotly_json() == other.to_plotly_json()


def test_a_property_that_plotly_does_not_know_is_found_by_the_check() -> None:
    figure = Figure()
    figure.add_scatter(x=[1.0], y=[2.0], colour="red")
    with pytest.raises(ValueError, match="colour"):
        figure.checked()


def test_what_is_not_given_is_left_out() -> None:
    figure = Figure()
    figure.add_scatter(x=[1.0], y=[2.0], error_x=None)
    figure.update_layout(bargap=None)
    assert json.loads(json.dumps(figure.to_dict()))["data"] == [
        {"type": "scatter", "xaxis": "x", "yaxis": "y", "x": [1.0], "y": [2.0]}
    ]
    assert "bargap" not in figure.to_dict()["layout"]


def test_drawing_the_totals_asks_plotly_for_nothing(sample: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("plotly checks every value: fifty times the time")

    for name in ("Figure", "Scatter", "Bar"):
        monkeypatch.setattr(go, name, never)
    assert figures.total_share(sample).to_dict()["data"]
