"""Draw a unit over temperature and wear: its share of the pump's flow, or a pressure that it holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.look import SCREEN, look_of
from atleak.what_if import Axis, Border, Map
from atleak.wording import Wording
from atleak.workshop_units import KPA, PERCENT

_MORE = [[0.0, "rgba(42, 134, 209, 0.06)"], [1.0, "rgba(42, 134, 209, 0.85)"]]  # seen on white and on black
_LESS = [[0.0, _MORE[1][1]], [1.0, _MORE[0][1]]]
_DASHES = ("solid", "dash", "dot", "dashdot")
_HEIGHT = 440

Place = tuple[float, float]  # temperature [°C] and wear


def share_map(over: Map, job: Place, tried: Place, say: Wording) -> Figure:
    """Draw the share of the pump's flow over temperature and wear, with the borders of its bands."""
    values = np.where(np.isfinite(over.share), over.share, np.nan) * PERCENT
    figure = Figure()
    _shade(figure, over, values, say("what_if.share_unit"), _MORE, say)
    _borders(figure, over, [(border, over.share_reaches(border)) for border in over.share_borders], say)
    return _laid_out(figure, over, job, tried, say)


def pressure_map(over: Map, name: str, job: Place, tried: Place, say: Wording) -> Figure:
    """Draw the pressure that the line, ``p_g``, or a circuit holds, with the borders of its levels."""
    values = say.convert(over.pressures[name] * KPA, "pressure")
    figure = Figure()
    _shade(figure, over, values, say.unit("pressure"), _LESS, say)
    borders = over.pressure_borders.get(name, ())
    _borders(figure, over, [(border, over.pressure_reaches(name, border)) for border in borders], say)
    return _laid_out(figure, over, job, tried, say)


def _shade(figure: Figure, over: Map, values: np.ndarray, unit: str, scale: list[list[object]], say: Wording) -> None:
    temperature, wear = say.unit("temperature"), say(f"what_if.hover_{over.axis}")
    figure.add(
        "contour",
        x=say.convert(over.temperatures, "temperature"),
        y=_wears(over, over.wears),
        z=np.round(values, 2),
        colorscale=scale,
        contours={"coloring": "heatmap", "showlabels": True, "labelfont": {"size": 11}},
        line={"width": 0.6, "color": "rgba(128, 128, 128, 0.5)"},
        ncontours=10,
        colorbar={"title": {"text": unit}, "thickness": 12, "outlinewidth": 0},
        hovertemplate=f"%{{x:.0f}} {temperature}, {wear}<br>%{{z:.1f}} {unit}<extra></extra>",
        name="",
    )


def _borders(figure: Figure, over: Map, borders: Sequence[tuple[Border, np.ndarray]], say: Wording) -> None:
    temperature, wear = say.unit("temperature"), say(f"what_if.hover_{over.axis}")
    for dash, (border, wears) in zip(_DASHES, borders, strict=False):
        if np.isfinite(wears).any():
            named = say("what_if.from_here", level=say.signed(border.level))
            at, colour = say.convert(over.temperatures, "temperature"), look_of(border.level).screen
            hover = f"{named}: %{{x:.0f}} {temperature}, {wear}"
            figure.line(at, _wears(over, wears), colour, 3, dash, name=named, connectgaps=False, hover=hover)


def _laid_out(figure: Figure, over: Map, job: Place, tried: Place, say: Wording) -> Figure:
    for place, name, symbol, size in ((job, "the_job", "circle-open", 22), (tried, "tried", "diamond", 11)):
        wear, at = _wears(over, np.array([place[1]])).tolist(), [float(say.convert(place[0], "temperature"))]
        figure.marks(wear, at, say(f"what_if.{name}"), (SCREEN.ink, symbol, size, 3.0), upright=True, cliponaxis=False)
    ends = say.convert(over.temperatures[[0, -1]], "temperature").tolist()
    figure.update_xaxes(title=say("what_if.axis_temperature", unit=say.unit("temperature")), range=ends)
    figure.update_yaxes(title=say(f"what_if.axis_{over.axis}"), range=_wears(over, over.wears[[0, -1]]).tolist())
    return framed(figure, _HEIGHT)


def _wears(over: Map, wears: np.ndarray) -> np.ndarray:
    return wears * PERCENT if over.axis is Axis.GROWTH else wears
