"""Show a controller's circuits as rows for people: feeds, set pressures, leaks, consumers, permissible pressures."""

from __future__ import annotations

from collections.abc import Iterable
from operator import methodcaller
from typing import Any

from atleak.catalogue.circuits import Circuit, SetPressure
from atleak.catalogue.controller import Controller
from atleak.views.table import Column, Table, columns
from atleak.wording import Wording, isolated
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM, PERCENT

MILLIAMPERE = 1.0e3
MILLIPASCAL_SECOND = 1.0e3


def circuit_tables(controller: Controller, say: Wording) -> list[Table]:
    """Return the tables of circuits, other leaks, consumers and permissible pressures; some may be without a row."""
    gears = Column("gears", of=lambda each: gears_words(each.gears))
    circuits = [*_line_row(controller, say), *(_circuit_row(each, controller, say) for each in controller.circuits)]
    circuit = columns("circuit", "gears", "fed_from", "set_to", "source")
    leak = columns(
        Column("leak", of=lambda leak: say.name(leak.name)),
        Column("flows_from", of=lambda leak: str(leak.high)),
        Column("flows_to", of=lambda leak: str(leak.low)),
        Column("law", of=lambda leak: say(f"catalogue.{leak.law}")),
        Column("flow", "flow", times=DM3_MIN),
        Column("at_pressure", "pressure", of="pressure_drop", times=KPA),
        Column("at_viscosity", digits=2, of="viscosity", times=MILLIPASCAL_SECOND),
        Column("at_density", "density", of="density", times=G_CM3),
        gears,
        "source",
    )
    points = (
        Column(point.name, "flow", words=say.condition(point), of=methodcaller("at", point), times=DM3_MIN)
        for point in controller.operating_points
    )
    consumer = columns(
        Column("consumer", of=lambda each: say.name(each.name)),
        *points,
        Column("law", of=lambda each: say(f"catalogue.{'constant' if each.after_line else each.law}")),
        Column("at_pressure", "pressure", of="pressure", times=KPA),
        Column("starves_first", of=lambda each: say(f"answers.{'yes' if each.after_line else 'no'}")),
        "source",
    )
    permissible = columns(
        gears,
        Column("state", of=lambda each: say.get("states", each.state)),
        Column("lowest", "pressure", of="low", times=KPA),
        Column("highest", "pressure", of="high", times=KPA),
        "source",
    )
    return [
        Table("circuits", circuit, circuits, say),
        Table("leaks", leak, controller.leaks, say),
        Table("consumers", consumer, controller.consumers, say),
        Table("permissible", permissible, controller.permissible_in_gear, say),
    ]


def set_pressure_words(stated: SetPressure | None, controller: Controller, say: Wording) -> str:
    """Say what a regulator is set to, at each operating point where it is stated by these."""
    if stated is None:
        return say("catalogue.not_regulated")
    if stated.following is not None:
        ratio, offset = stated.following.ratio, stated.following.offset
        plus = f" {'+' if offset > 0 else '−'} {_pressure(abs(offset), say)}" if offset else ""
        return f"{say.plain(ratio)} × {stated.following.section}{plus}"
    if stated.number is not None:
        return _pressure(stated.number, say)
    if stated.points is not None:
        points = {point.name: say.condition(point) for point in controller.operating_points}
        return _listed(((points.get(name, name), pressure) for name, pressure in stated.points.items()), say)
    if stated.gears is not None:
        return _listed(
            ((say("catalogue.in_gear", gear=gear), pressure) for gear, pressure in stated.gears.items()), say
        )
    curve, unit, scale = stated.currents or ((), ()), "mA", MILLIAMPERE
    if stated.duties is not None:
        curve, unit, scale = stated.duties, say("catalogue.duty"), PERCENT
    return _listed(
        ((f"{say.plain(value * scale)} {unit}", pressure) for value, pressure in zip(*curve, strict=True)), say
    )


def gears_words(gears: Iterable[int]) -> str:
    """Return gears in their order: ``2, 5``."""
    return ", ".join(map(str, sorted(gears)))


def _listed(named: Iterable[tuple[str, float]], say: Wording) -> str:
    return "; ".join(f"{name}: {_pressure(pressure, say)}" for name, pressure in named)


def _pressure(pressure: float, say: Wording) -> str:
    return say.plain_quantity(pressure * KPA, "pressure")


def _line_row(controller: Controller, say: Wording) -> Iterable[dict[str, Any]]:
    if controller.line is not None:
        yield {
            "circuit": f"p_g · {say('figures.main_pressure')}",
            "gears": gears_words(controller.gears),
            "fed_from": say("catalogue.the_pump"),
            "set_to": set_pressure_words(controller.line, controller, say),
            "source": controller.line_source,
        }


def _circuit_row(circuit: Circuit, controller: Controller, say: Wording) -> dict[str, Any]:
    feeds = (
        f"{feed.source} ⌀ {say.plain_quantity(feed.diameter * MM, 'length')}, "
        f"C_d {say.plain(feed.discharge_coefficient)}"
        for feed in circuit.feeds
    )
    return {
        "circuit": f"{circuit.id} · {isolated(say.name(circuit.name))}",
        "gears": gears_words(circuit.gears),
        "fed_from": "; ".join(feeds),
        "set_to": set_pressure_words(circuit.set_pressure, controller, say),
        "source": circuit.source,
    }
