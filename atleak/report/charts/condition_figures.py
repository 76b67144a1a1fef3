"""Draw on the screen what depends on the condition: the pump over speed, a unit over temperature and wear, a fluid."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from atleak.analysis.what_if import Axis, Border, Map
from atleak.catalogue.fluid import Fluid
from atleak.common.style import CURVES, FAINT_GRID, SCREEN, look_of
from atleak.common.units import DM3_MIN, KPA, MM2_S, PERCENT, RPM
from atleak.common.wording import Wording, wording
from atleak.report.charts.figure import Figure, framed
from atleak.report.tables.pressures import Demand, PumpOverSpeed

_COLOURS = tuple(CURVES.values())
_DASHES = ("dot", "dash", "longdash", "dashdot", "longdashdot")


def pump_speed_chart(data: PumpOverSpeed, say: Wording | None = None) -> Figure:
    """Draw the pump's supply over engine speed against the demand at each temperature, with their crossings.

    The demand at the condition's own temperature is drawn thick, with the 95 % interval of its crossing. English unless
    ``say`` is given.
    """
    say = say or wording("en")
    figure, scale = Figure(), say.convert(DM3_MIN, "flow")
    rpm, unit = say.unit("engine_speed"), say.unit("flow")
    hover = f"%{{x:.0f}} {rpm}: {say('figures.pump_supplies')} %{{y:.1f}} {unit}"
    figure.line(data.speeds * RPM, data.supply * scale, SCREEN.pump, 4, name=say("flows.pump"), hover=hover)
    last = float(data.speeds[-1]) * RPM
    for number, demand in enumerate(data.demands):
        look = (_COLOURS[-1 - number % len(_COLOURS)], 1.5, _DASHES[number % len(_DASHES)])
        colour, width, dash = (SCREEN.leakage, 3.0, "solid") if demand.of_condition else look
        name = say("figures.taken_at", temperature=say.plain_quantity(demand.temperature, "temperature"))
        flows = [demand.flow * scale] * 2
        figure.line([0.0, last], flows, colour, width, dash, name=name, hover=_parts(demand, say))
    crossing = [each for each in data.demands if math.isfinite(each.crossing)]
    mine = [each is data.demand for each in crossing]
    speeds = [f"<b>{say.quantity(each.crossing * RPM, 'engine_speed')}</b>" for each in crossing]
    figure.marks(
        [each.crossing for each in crossing],
        [each.flow * scale for each in crossing],
        say("figures.covered_from_here"),
        (SCREEN.share, "circle", [13 if own else 8 for own in mine], 0.0),
        factor=RPM,
        spans=[data.interval if own else None for own in mine],
        text=[speed if own else "" for speed, own in zip(speeds, mine, strict=True)],
        textposition="top left",
        told=[
            say("figures.covered_at", temperature=say.plain_quantity(each.temperature, "temperature"))
            for each in crossing
        ],
        hover=f"%{{customdata}} %{{x:.0f}} {rpm}",
    )
    for number, (label, speed) in enumerate(data.marked):
        figure.add_vline(
            x=speed * RPM,
            line={"color": SCREEN.soft, "width": 1.5, "dash": "dash" if number else "solid"},
            text=f"{label}: {say.quantity(speed * RPM, 'engine_speed')}",
            font={"size": 11},
            textangle=-90,
        )
    figure.update_xaxes(title=f"{say('figures.engine_speed')} [{rpm}]", range=[0.0, last])
    figure.update_yaxes(title=f"{say('figures.flow')} [{unit}]", rangemode="tozero")
    return framed(figure, 380)


def _parts(demand: Demand, say: Wording) -> str:
    parts = {name: say.value(getattr(demand, name) * DM3_MIN, "flow") for name in ("leakage", "slip", "consumers")}
    flow = say.quantity(demand.flow * DM3_MIN, "flow")
    temperature = say.plain_quantity(demand.temperature, "temperature")
    return say("figures.taken_parts", temperature=temperature, flow=flow, **parts)


_MORE = [[0.0, "rgba(42, 134, 209, 0.06)"], [1.0, "rgba(42, 134, 209, 0.85)"]]  # seen on white and on black
_LESS = [[0.0, _MORE[1][1]], [1.0, _MORE[0][1]]]
_TRIAL_DASHES = ("solid", "dash", "dot", "dashdot")
_HEIGHT = 440

MapPlace = tuple[float, float]  # temperature [°C] and wear


def share_map(over: Map, job: MapPlace, tried: MapPlace, say: Wording) -> Figure:
    """Draw the share of the pump's flow over temperature and wear, with the borders of its bands.

    Parameters
    ----------
    job, tried
        temperature [°C] and wear of the job and of what is tried, marked on the map.
    """
    values = np.where(np.isfinite(over.share), over.share, np.nan) * PERCENT
    figure = Figure()
    _shade(figure, over, values, say("what_if.share_unit"), _MORE, say)
    _borders(figure, over, [(border, over.share_reaches(border)) for border in over.share_borders], say)
    return _laid_out(figure, over, job, tried, say)


def pressure_map(over: Map, name: str, job: MapPlace, tried: MapPlace, say: Wording) -> Figure:
    """Draw the pressure that the line, ``p_g``, or a circuit holds, with the borders of its levels.

    Parameters
    ----------
    name
        ``p_g`` or the id of a circuit that is applied.
    job, tried
        temperature [°C] and wear of the job and of what is tried, marked on the map.
    """
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
    for dash, (border, wears) in zip(_TRIAL_DASHES, borders, strict=False):
        if np.isfinite(wears).any():
            named = say("what_if.from_here", level=say.signed(border.level))
            at, colour = say.convert(over.temperatures, "temperature"), look_of(border.level).screen
            hover = f"{named}: %{{x:.0f}} {temperature}, {wear}"
            figure.line(at, _wears(over, wears), colour, 3, dash, name=named, connectgaps=False, hover=hover)


def _laid_out(figure: Figure, over: Map, job: MapPlace, tried: MapPlace, say: Wording) -> Figure:
    for place, name, symbol, size in ((job, "the_job", "circle-open", 22), (tried, "tried", "diamond", 11)):
        wear, at = _wears(over, np.array([place[1]])).tolist(), [float(say.convert(place[0], "temperature"))]
        figure.marks(wear, at, say(f"what_if.{name}"), (SCREEN.ink, symbol, size, 3.0), upright=True, cliponaxis=False)
    ends = say.convert(over.temperatures[[0, -1]], "temperature").tolist()
    figure.update_xaxes(title=say("what_if.axis_temperature", unit=say.unit("temperature")), range=ends)
    figure.update_yaxes(title=say(f"what_if.axis_{over.axis}"), range=_wears(over, over.wears[[0, -1]]).tolist())
    return framed(figure, _HEIGHT)


def _wears(over: Map, wears: np.ndarray) -> np.ndarray:
    return wears * PERCENT if over.axis is Axis.GROWTH else wears


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
