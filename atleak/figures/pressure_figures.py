"""Draw pressures on the screen: what the pump supplies over speed, and what the line and every circuit hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from atleak.catalogue.limits import Level
from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.look import CURVES, SCREEN, Look, look_of
from atleak.verdicts import Verdict
from atleak.views.pressures import HeldPressure, PressuresAt
from atleak.views.pump_speed import Demand, PumpOverSpeed
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import DM3_MIN, KPA, RPM

_BARS = {"repaired": "after_repair", "now": "now", "new": "new"}  # and how each is called
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

    def bar(of: str, shown: Sequence[HeldPressure], look: Look | tuple[str, str], named: str = "", **more: Any) -> None:
        what, names = say(f"figures.{_BARS[of]}"), [name_of(each, say) for each in shown]
        more = {"offsetgroup": of, "hover": f"{number} {what}", **more}
        figure.bars([getattr(each, of) for each in shown], names, f"{what}{named}", look, factor=scale, **more)

    repaired = [each for each in held if each.repaired is not None]
    if repaired:
        bar("repaired", repaired, (SCREEN.leakage, "-"))
    for verdict in (*Verdict, None):
        these = [each for each in held if each.verdict == verdict]
        if these:
            look = (SCREEN.rule, "") if verdict is None else look_of(verdict)
            named = "" if verdict is None else f": {say.signed(verdict)}"
            bar("now", these, look, named, spans=[each.interval for each in these])
    frame = {"color": "rgba(128,128,128,0.15)", "line": {"color": SCREEN.soft, "width": 1.5}}
    bar("new", held, ("", ""), marker=frame)
    for mark in _marks(held, say):
        places, pressures, symbols = (list(each) for each in zip(*mark.places, strict=True))
        drawn = (mark.colour, symbols, mark.size, 2.5)
        figure.marks(pressures, places, mark.name, drawn, factor=scale, hover=f"{number}, {mark.name}")
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
