"""Draw pressures on the screen: what the pump supplies over speed, and what the line and every circuit hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from atleak.catalogue.limits import Level
from atleak.figures.figure import Figure
from atleak.figures.frame import error_bars, framed
from atleak.look import CURVES, HATCHING, SCREEN, look_of
from atleak.verdicts import Verdict
from atleak.views.pressures import HeldPressure, PressuresAt
from atleak.views.pump_speed import Demand, PumpOverSpeed
from atleak.wording import signed
from atleak.workshop_units import DM3_MIN, KPA, RPM

_HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}
_COLOURS = tuple(CURVES.values())
_DASHES = ("dot", "dash", "longdash", "dashdot", "longdashdot")
_BAR = 26  # pixels of a bar
LINE_NAME = "main pressure"


def pump_over_speed(data: PumpOverSpeed) -> Figure:
    """Draw the pump's supply over engine speed against the demand at each temperature, with their crossings.

    The demand at the condition's own temperature is drawn thick, with the 95 % interval of its crossing.
    """
    figure = Figure()
    figure.add_scatter(
        x=data.speeds * RPM,
        y=data.supply * DM3_MIN,
        mode="lines",
        name="pump",
        line={"color": SCREEN.pump, "width": 4},
        hovertemplate="%{x:.0f} rpm: the pump supplies %{y:.1f} dm³/min<extra></extra>",
    )
    last = float(data.speeds[-1]) * RPM
    for number, demand in enumerate(data.demands):
        colour = SCREEN.leakage if demand.of_condition else _COLOURS[-1 - number % len(_COLOURS)]
        flow = demand.flow * DM3_MIN
        dash = "solid" if demand.of_condition else _DASHES[number % len(_DASHES)]
        figure.add_scatter(
            x=[0.0, last],
            y=[flow, flow],
            mode="lines",
            name=f"taken at {demand.temperature:g} °C",
            line={"color": colour, "width": 3 if demand.of_condition else 1.5, "dash": dash},
            hovertemplate=_parts(demand),
        )
    crossing = [each for each in data.demands if math.isfinite(each.crossing)]
    own = data.demand
    figure.add_scatter(
        x=[each.crossing * RPM for each in crossing],
        y=[each.flow * DM3_MIN for each in crossing],
        mode="markers+text",
        name="covered from here",
        text=[f"<b>{each.crossing * RPM:.0f} rpm</b>" if each is own else "" for each in crossing],
        textposition="top left",
        marker={"symbol": "circle", "size": [13 if each is own else 8 for each in crossing], "color": SCREEN.share},
        error_x=error_bars(
            [each.crossing for each in crossing], [data.interval if each is own else None for each in crossing], RPM
        ),
        customdata=[each.temperature for each in crossing],
        hovertemplate="at %{customdata:g} °C covered from %{x:.0f} rpm<extra></extra>",
    )
    for number, (label, speed) in enumerate(data.marked):
        figure.add_vline(
            x=speed * RPM,
            line={"color": SCREEN.soft, "width": 1.5, "dash": "dash" if number else "solid"},
            text=f"{label}: {speed * RPM:.0f} rpm",
            font={"size": 11},
            textangle=-90,
        )
    figure.update_xaxes(title="engine speed [rpm]", range=[0.0, last])
    figure.update_yaxes(title="flow [dm³/min]", rangemode="tozero")
    return framed(figure, 380)


def _parts(demand: Demand) -> str:
    leakage, slip, consumers = (each * DM3_MIN for each in (demand.leakage, demand.slip, demand.consumers))
    return (
        f"{demand.temperature:g} °C: {demand.flow * DM3_MIN:.2f} dm³/min are taken<br>leakage {leakage:.2f}, "
        f"slip {slip:.2f}, consumers {consumers:.2f}<extra></extra>"
    )


def circuit_pressures(at: PressuresAt) -> Figure:
    """Draw what the line and every applied circuit hold: new, now with its interval, and with the planned repairs.

    Marks are the limits that apply: where a loss is judged worse, what a regulator is set to, and the permissible
    main pressure.
    """
    held = at.applied
    names = [name_of(each) for each in held]
    figure = Figure()
    repaired = [each for each in held if each.repaired is not None]
    if repaired:
        figure.add_bar(
            x=[(each.repaired or 0.0) * KPA for each in repaired],
            y=[name_of(each) for each in repaired],
            orientation="h",
            name="after repair",
            offsetgroup="repaired",
            marker={"color": SCREEN.leakage, "pattern": _HATCH | {"shape": "-"}},
            hovertemplate="%{y}: %{x:.0f} kPa after repair<extra></extra>",
        )
    for verdict in (*Verdict, None):
        these = [each for each in held if each.verdict == verdict]
        if these:
            look = None if verdict is None else look_of(verdict)
            figure.add_bar(
                x=[each.now * KPA for each in these],
                y=[name_of(each) for each in these],
                orientation="h",
                name="now" if verdict is None else f"now: {signed(verdict)}",
                offsetgroup="now",
                marker={
                    "color": SCREEN.rule if look is None else look.screen,
                    "pattern": _HATCH | {"shape": "" if look is None else look.pattern},
                },
                error_x=error_bars([each.now for each in these], [each.interval for each in these], KPA),
                hovertemplate="%{y}: %{x:.0f} kPa now<extra></extra>",
            )
    figure.add_bar(
        x=[each.new * KPA for each in held],
        y=names,
        orientation="h",
        name="new",
        offsetgroup="new",
        marker={"color": "rgba(128,128,128,0.15)", "line": {"color": SCREEN.soft, "width": 1.5}},
        hovertemplate="%{y}: %{x:.0f} kPa new<extra></extra>",
    )
    for mark in _marks(held):
        figure.add_scatter(
            x=[pressure * KPA for _, pressure, _ in mark.places],
            y=[where for where, _, _ in mark.places],
            mode="markers",
            name=mark.name,
            marker={
                "symbol": [symbol for _, _, symbol in mark.places],
                "size": mark.size,
                "color": mark.colour,
                "line": {"width": 2.5, "color": mark.colour},
            },
            hovertemplate=f"%{{y}}: %{{x:.0f}} kPa, {mark.name}<extra></extra>",
        )
    figure.update_xaxes(title="pressure [kPa]", rangemode="tozero")
    figure.update_yaxes(type="category", categoryorder="array", categoryarray=names[::-1])
    groups = 3 if repaired else 2
    return framed(figure, 150 + (_BAR * groups + 14) * len(held), top=60, barmode="group", bargap=0.2)


def name_of(held: HeldPressure) -> str:
    """Return the name of the line or of a circuit, with the sign of its verdict."""
    name = LINE_NAME if held.circuit is None else held.circuit.name
    return name if held.verdict is None else f"{look_of(held.verdict).sign} {name}"


@dataclass
class _Mark:
    """Limits of one name: each with the bars beside which it stands, its pressure [Pa] and its symbol."""

    name: str
    colour: str
    size: int = 11
    places: list[tuple[str, float, str]] = field(default_factory=list)

    def add(self, where: HeldPressure, pressure: float | None, symbol: str) -> None:
        if pressure is not None and pressure > 0.0:
            self.places.append((name_of(where), pressure, symbol))


def _marks(held: Sequence[HeldPressure]) -> list[_Mark]:
    """Return the limits that apply: levels of a loss, what is set or required, and what is permissible."""
    levels: dict[Level, _Mark] = {}
    stated, permitted = _Mark("set, or required", SCREEN.share, 20), _Mark("permissible, from and up to", SCREEN.share)
    for each in held:
        stated.add(each, each.set_pressure, "line-ns")
        if each.permissible is not None:
            permitted.add(each, each.permissible.low, "triangle-right")
            permitted.add(each, each.permissible.high, "triangle-left")
        for level, pressure in each.limits if each.circuit else ():
            look = look_of(level)
            mark = levels.setdefault(level, _Mark(f"{signed(level)} from here down", look.screen))
            mark.add(each, pressure, f"{look.marker}-open")
    return [mark for mark in (*levels.values(), stated, permitted) if mark.places]
