"""Draw a fluid's viscosity over temperature on the screen."""

from __future__ import annotations

import numpy as np

from atleak.catalogue.fluid import Fluid
from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.look import FAINT_GRID, SCREEN
from atleak.workshop_units import MM2_S

BETWEEN, BEYOND = "between the data sheet's points", "beyond them"
POINTS, TABLE = "data sheet", "table of the source"
_HOTTEST = 150.0  # [°C]
_STEP = 2.0  # [°C]
_TICKS = [step * 10**power for power in range(5) for step in (1, 2, 5)]  # [mm²/s]


def viscosity_curve(fluid: Fluid) -> Figure:
    """Draw ASTM D341 through a fluid's data-sheet points, dashed beyond them, the viscosity on a logarithmic axis."""
    low, high = fluid.span()
    first, last = fluid.points[0][0], fluid.points[-1][0]
    figure = Figure()
    for name, spans, dash in (
        (BETWEEN, [(first, last)], "solid"),
        (BEYOND, [(low, first), (last, min(high, max(_HOTTEST, last)))], "dash"),
    ):
        at, viscosities = _curve(fluid, spans)
        figure.add_scatter(
            x=at,
            y=viscosities,
            mode="lines",
            name=name,
            line={"color": SCREEN.leakage, "width": 2.5, "dash": dash},
            hovertemplate="%{x:.0f} °C: %{y:.3g} mm²/s<extra></extra>",
        )
    for name, rows, symbol, colour in (
        (POINTS, [(at, nu) for at, nu in fluid.points], "circle", SCREEN.share),
        (TABLE, [(at, nu) for at, nu, _ in fluid.table], "x-thin-open", SCREEN.soft),
    ):
        if rows:
            figure.add_scatter(
                x=[at for at, _ in rows],
                y=[nu * MM2_S for _, nu in rows],
                mode="markers",
                name=name,
                marker={"symbol": symbol, "size": 11, "color": colour},
                hovertemplate=f"{name}, %{{x:g}} °C: %{{y:g}} mm²/s<extra></extra>",
            )
    figure.update_xaxes(title="temperature [°C]")
    figure.update_yaxes(title="kinematic viscosity [mm²/s]", type="log", tickvals=_TICKS, gridcolor=FAINT_GRID)
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
