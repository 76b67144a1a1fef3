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
        hover, named = f"%{{x:.0f}} {degrees}: %{{y:.3g}} {mm2_s}", say(f"catalogue.{name}")
        shown = [say.convert(each, "temperature") for each in at]
        figure.line(shown, viscosities, SCREEN.leakage, 2.5, dash, name=named, hover=hover)
    for name, rows, symbol, colour in (
        ("sheet_points", [(at, nu) for at, nu in fluid.points], "circle", SCREEN.share),
        ("source_table", [(at, nu) for at, nu, _ in fluid.table], "x-open", SCREEN.soft),
    ):
        if rows:
            named = say(f"catalogue.{name}")
            values, places = [nu for _, nu in rows], [say.convert(at, "temperature") for at, _ in rows]
            mark, hover = (colour, symbol, 11, 0.0), f"{named}, %{{x:g}} {degrees}: %{{y:g}} {mm2_s}"
            figure.marks(values, places, named, mark, factor=MM2_S, upright=True, hover=hover)
    figure.update_xaxes(title=say("catalogue.axis_temperature", unit=degrees))
    figure.update_yaxes(
        title=say("catalogue.axis_viscosity", unit=mm2_s), type="log", tickvals=_TICKS, gridcolor=FAINT_GRID
    )
    return framed(figure, 360)


def _curve(fluid: Fluid, spans: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    """Return temperatures [°C] and viscosities [mm²/s] over stretches, NaN between two of them."""
    temperatures: list[float] = []
    viscosities: list[float] = []
    for start, end in spans:
        if end > start:
            at = np.linspace(start, end, max(int((end - start) / _STEP), 1) + 1)
            temperatures += [*at.tolist(), float("nan")]
            viscosities += [*(fluid.kinematic_viscosity(at) * MM2_S).tolist(), float("nan")]
    return temperatures[:-1], viscosities[:-1]
