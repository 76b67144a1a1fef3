"""Draw pressures on the screen: what the pump supplies over speed, and what the line and every circuit hold."""

from __future__ import annotations

import math

from atleak.figures.charts import drawn
from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.look import CURVES, SCREEN
from atleak.views.pressure_tables import pressure_chart
from atleak.views.pressures import PressuresAt
from atleak.views.pump_speed import Demand, PumpOverSpeed
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, RPM

_COLOURS = tuple(CURVES.values())
_DASHES = ("dot", "dash", "longdash", "dashdot", "longdashdot")


def pump_over_speed(data: PumpOverSpeed, say: Wording | None = None) -> Figure:
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


def circuit_pressures(at: PressuresAt, say: Wording | None = None) -> Figure:
    """Draw what the line and every applied circuit hold; English unless ``say`` is given."""
    say = say or wording("en")
    return drawn(pressure_chart(at, say), say)
