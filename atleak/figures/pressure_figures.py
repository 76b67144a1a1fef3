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
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import DM3_MIN, KPA, RPM

_HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}
_COLOURS = tuple(CURVES.values())
_DASHES = ("dot", "dash", "longdash", "dashdot", "longdashdot")
_BAR = 26  # pixels of a bar


def pump_over_speed(data: PumpOverSpeed, say: Wording | None = None) -> Figure:
    """Draw the pump's supply over engine speed against the demand at each temperature, with their crossings.

    The demand at the condition's own temperature is drawn thick, with the 95 % interval of its crossing. English unless
    ``say`` is given.
    """
    say = say or wording("en")
    figure, scale = Figure(), say.convert(DM3_MIN, "flow")
    rpm, unit = say.unit("engine_speed"), say.unit("flow")
    figure.add_scatter(
        x=data.speeds * RPM,
        y=data.supply * scale,
        mode="lines",
        name=say("flows.pump"),
        line={"color": SCREEN.pump, "width": 4},
        hovertemplate=f"%{{x:.0f}} {rpm}: {say('figures.pump_supplies')} %{{y:.1f}} {unit}<extra></extra>",
    )
    last = float(data.speeds[-1]) * RPM
    for number, demand in enumerate(data.demands):
        colour = SCREEN.leakage if demand.of_condition else _COLOURS[-1 - number % len(_COLOURS)]
        flow = demand.flow * scale
        dash = "solid" if demand.of_condition else _DASHES[number % len(_DASHES)]
        figure.add_scatter(
            x=[0.0, last],
            y=[flow, flow],
            mode="lines",
            name=say("figures.taken_at", temperature=say.plain_quantity(demand.temperature, "temperature")),
            line={"color": colour, "width": 3 if demand.of_condition else 1.5, "dash": dash},
            hovertemplate=_parts(demand, say),
        )
    crossing = [each for each in data.demands if math.isfinite(each.crossing)]
    own = data.demand
    figure.add_scatter(
        x=[each.crossing * RPM for each in crossing],
        y=[each.flow * scale for each in crossing],
        mode="markers+text",
        name=say("figures.covered_from_here"),
        text=[
            f"<b>{say.quantity(each.crossing * RPM, 'engine_speed')}</b>" if each is own else "" for each in crossing
        ],
        textposition="top left",
        marker={"symbol": "circle", "size": [13 if each is own else 8 for each in crossing], "color": SCREEN.share},
        error_x=error_bars(
            [each.crossing for each in crossing], [data.interval if each is own else None for each in crossing], RPM
        ),
        customdata=[
            say("figures.covered_at", temperature=say.plain_quantity(each.temperature, "temperature"))
            for each in crossing
        ],
        hovertemplate=f"%{{customdata}} %{{x:.0f}} {rpm}<extra></extra>",
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
    return f"{say('figures.taken_parts', temperature=temperature, flow=flow, **parts)}<extra></extra>"


def circuit_pressures(at: PressuresAt, say: Wording | None = None) -> Figure:
    """Draw what the line and every applied circuit hold: new, now with its interval, and with the planned repairs.

    Marks are the limits that apply: where a loss is judged worse, what a regulator is set to, and the permissible
    main pressure. English unless ``say`` is given.
    """
    say = say or wording("en")
    scale, unit = say.convert(KPA, "pressure"), say.unit("pressure")
    number = f"%{{y}}: %{{x:.{say.digits('pressure', 0)}f}} {unit}"
    held = at.applied
    names = [name_of(each, say) for each in held]
    figure = Figure()
    repaired = [each for each in held if each.repaired is not None]
    if repaired:
        figure.add_bar(
            x=[(each.repaired or 0.0) * scale for each in repaired],
            y=[name_of(each, say) for each in repaired],
            orientation="h",
            name=say("figures.after_repair"),
            offsetgroup="repaired",
            marker={"color": SCREEN.leakage, "pattern": _HATCH | {"shape": "-"}},
            hovertemplate=f"{number} {say('figures.after_repair')}<extra></extra>",
        )
    for verdict in (*Verdict, None):
        these = [each for each in held if each.verdict == verdict]
        if these:
            look = None if verdict is None else look_of(verdict)
            figure.add_bar(
                x=[each.now * scale for each in these],
                y=[name_of(each, say) for each in these],
                orientation="h",
                name=say("figures.now") if verdict is None else f"{say('figures.now')}: {say.signed(verdict)}",
                offsetgroup="now",
                marker={
                    "color": SCREEN.rule if look is None else look.screen,
                    "pattern": _HATCH | {"shape": "" if look is None else look.pattern},
                },
                error_x=error_bars([each.now for each in these], [each.interval for each in these], scale),
                hovertemplate=f"{number} {say('figures.now')}<extra></extra>",
            )
    figure.add_bar(
        x=[each.new * scale for each in held],
        y=names,
        orientation="h",
        name=say("figures.new"),
        offsetgroup="new",
        marker={"color": "rgba(128,128,128,0.15)", "line": {"color": SCREEN.soft, "width": 1.5}},
        hovertemplate=f"{number} {say('figures.new')}<extra></extra>",
    )
    for mark in _marks(held, say):
        figure.add_scatter(
            x=[pressure * scale for _, pressure, _ in mark.places],
            y=[where for where, _, _ in mark.places],
            mode="markers",
            name=mark.name,
            marker={
                "symbol": [symbol for _, _, symbol in mark.places],
                "size": mark.size,
                "color": mark.colour,
                "line": {"width": 2.5, "color": mark.colour},
            },
            hovertemplate=f"{number}, {mark.name}<extra></extra>",
        )
    figure.update_xaxes(title=f"{say('figures.pressure')} [{unit}]", rangemode="tozero")
    figure.update_yaxes(type="category", categoryorder="array", categoryarray=names[::-1])
    groups = 3 if repaired else 2
    return framed(figure, 150 + (_BAR * groups + 14) * len(held), top=60, barmode="group", bargap=0.2)


def name_of(held: HeldPressure, say: Wording) -> str:
    """Return the name of the line or of a circuit, with the sign of its verdict."""
    name = say("figures.main_pressure") if held.circuit is None else isolated(say.name(held.circuit.name))
    return name if held.verdict is None else f"{look_of(held.verdict).sign} {name}"


@dataclass
class _Mark:
    """Limits of one name: each with the bars beside which it stands, its pressure [Pa] and its symbol."""

    name: str
    say: Wording
    colour: str
    size: int = 11
    places: list[tuple[str, float, str]] = field(default_factory=list)

    def add(self, where: HeldPressure, pressure: float | None, symbol: str) -> None:
        if pressure is not None and pressure > 0.0:
            self.places.append((name_of(where, self.say), pressure, symbol))


def _marks(held: Sequence[HeldPressure], say: Wording) -> list[_Mark]:
    """Return the limits that apply: levels of a loss, what is set or required, and what is permissible."""
    levels: dict[Level, _Mark] = {}
    stated = _Mark(say("figures.set_or_required"), say, SCREEN.share, 20)
    permitted = _Mark(say("figures.permissible"), say, SCREEN.share)
    for each in held:
        stated.add(each, each.set_pressure, "line-ns")
        if each.permissible is not None:
            permitted.add(each, each.permissible.low, "triangle-right")
            permitted.add(each, each.permissible.high, "triangle-left")
        for level, pressure in each.limits if each.circuit else ():
            look = look_of(level)
            mark = levels.setdefault(
                level, _Mark(say("figures.from_here_down", level=say.signed(level)), say, look.screen)
            )
            mark.add(each, pressure, f"{look.marker}-open")
    return [mark for mark in (*levels.values(), stated, permitted) if mark.places]
