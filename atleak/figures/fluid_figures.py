"""Draw a fluid's viscosity over temperature on the screen."""

from __future__ import annotations

import numpy as np

from atleak.catalogue.fluid import Fluid
from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.look import FAINT_GRID, SCREEN
from atleak.wording import Wording
from atleak.workshop_units import MM2_S

_HOTTEST = 150.0  # [°C]
_STEP = 2.0  # [°C]
_TICKS = [step * 10**power for power in range(5) for step in (1, 2, 5)]  # [mm²/s]


def viscosity_curve(fluid: Fluid, say: Wording) -> Figure:
    """Draw ASTM D341 through a fluid's data-sheet points, dashed beyond them, the viscosity on a logarithmic axis."""
    degrees, mm2_s = say.unit("temperature"), say.unit("viscosity")
    low, high = fluid.span()
    first, last = fluid.points[0][0], fluid.points[-1][0]
    figure = Figure()
    for name, spans, dash in (
        ("between", [(first, last)], "solid"),
        ("beyond", [(low, first), (last, min(high, max(_HOTTEST, last)))], "dash"),
    ):
        at, viscosities = _curve(fluid, spans)
        figure.add_scatter(
            x=[say.convert(each, "temperature") for each in at],
            y=viscosities,
            mode="lines",
            name=say(f"catalogue.{name}"),
            line={"color": SCREEN.leakage, "width": 2.5, "dash": dash},
            hovertemplate=f"%{{x:.0f}} {degrees}: %{{y:.3g}} {mm2_s}<extra></extra>",
        )
    for name, rows, symbol, colour in (
        ("sheet_points", [(at, nu) for at, nu in fluid.points], "circle", SCREEN.share),
        ("source_table", [(at, nu) for at, nu, _ in fluid.table], "x-thin-open", SCREEN.soft),
    ):
        if rows:
            figure.add_scatter(
                x=[say.convert(at, "temperature") for at, _ in rows],
                y=[nu * MM2_S for _, nu in rows],
                mode="markers",
                name=say(f"catalogue.{name}"),
                marker={"symbol": symbol, "size": 11, "color": colour},
                hovertemplate=f"{say(f'catalogue.{name}')}, %{{x:g}} {degrees}: %{{y:g}} {mm2_s}<extra></extra>",
            )
    figure.update_xaxes(title=say("catalogue.axis_temperature", unit=degrees))
    figure.update_yaxes(
        title=say("catalogue.axis_viscosity", unit=mm2_s), type="log", tickvals=_TICKS, gridcolor=FAINT_GRID
    )
    return framed(figure, 360)


def _curve(fluid: Fluid, spans: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    """Return temperatures [°C] and viscosities [mm²/s] over stretches, NaN between two of them."""
    temperatures: list[float] = []
    for start, end in spans:
        if end > start:
            steps = max(int((end - start) / _STEP), 1)
            temperatures += [*np.linspace(start, end, steps + 1).tolist(), float("nan")]
    inside = np.asarray(temperatures[:-1])
    known = np.where(np.isnan(inside), fluid.points[0][0], inside)
    viscosities = np.where(np.isnan(inside), np.nan, fluid.kinematic_viscosity(known) * MM2_S)
    return inside.tolist(), viscosities.tolist()
