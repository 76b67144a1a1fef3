"""Show a controller's circuits as rows for people: feeds, set pressures, leaks, consumers, permissible pressures."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.catalogue.circuits import Circuit, SetPressure
from atleak.catalogue.controller import Controller
from atleak.views.catalogue_table import CatalogueTable, Rows, columns
from atleak.views.table import Column
from atleak.wording import Wording, isolated
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM, PERCENT

MILLIAMPERE = 1.0e3
MILLIPASCAL_SECOND = 1.0e3
_LEAKS = columns(
    "leak",
    "flows_from",
    "flows_to",
    "law",
    Column("flow", "flow"),
    Column("at_pressure", "pressure"),
    Column("at_viscosity", digits=2),
    Column("at_density", "density"),
    "gears",
    "source",
)
_PERMISSIBLE = columns("gears", "state", Column("lowest", "pressure"), Column("highest", "pressure"), "source")


def circuit_tables(controller: Controller, say: Wording) -> list[CatalogueTable]:
    """Return the tables of circuits, other leaks, consumers and permissible pressures; some may be without a row."""
    points = {
        point.name: Column(point.name, "flow", words=say.condition(point)) for point in controller.operating_points
    }
    circuits = [*_line_row(controller, say), *(_circuit_row(each, controller, say) for each in controller.circuits)]
    return [
        CatalogueTable("circuits", columns("circuit", "gears", "fed_from", "set_to", "source"), circuits),
        CatalogueTable("leaks", _LEAKS, _leak_rows(controller, say)),
        CatalogueTable(
            "consumers",
            columns("consumer", *points.values(), "law", Column("at_pressure", "pressure"), "starves_first", "source"),
            [
                {
                    "consumer": say.name(consumer.name),
                    **{point.name: consumer.at(point) * DM3_MIN for point in controller.operating_points},
                    "law": say(f"catalogue.{'constant' if consumer.after_line else consumer.law}"),
                    "at_pressure": None if consumer.pressure is None else consumer.pressure * KPA,
                    "starves_first": say(f"answers.{'yes' if consumer.after_line else 'no'}"),
                    "source": consumer.source,
                }
                for consumer in controller.consumers
            ],
        ),
        CatalogueTable(
            "permissible",
            _PERMISSIBLE,
            [
                {
                    "gears": gears_words(each.gears),
                    "state": say.get("states", each.state),
                    "lowest": None if each.low is None else each.low * KPA,
                    "highest": None if each.high is None else each.high * KPA,
                    "source": each.source,
                }
                for each in controller.permissible
            ],
        ),
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


def _leak_rows(controller: Controller, say: Wording) -> Rows:
    return [
        {
            "leak": say.name(leak.name),
            "flows_from": str(leak.high),
            "flows_to": str(leak.low),
            "law": say(f"catalogue.{leak.law}"),
            "flow": leak.flow * DM3_MIN,
            "at_pressure": leak.pressure_drop * KPA,
            "at_viscosity": None if leak.viscosity is None else leak.viscosity * MILLIPASCAL_SECOND,
            "at_density": leak.density * G_CM3,
            "gears": gears_words(leak.gears),
            "source": leak.source,
        }
        for leak in controller.leaks
    ]


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
