"""Show a controller's circuits as rows for people: feeds, set pressures, leaks, consumers, permissible pressures."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.catalogue.circuits import Circuit, SetPressure
from atleak.catalogue.controller import Controller
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM, PERCENT

Rows = list[dict[str, Any]]
MILLIAMPERE = 1.0e3
MILLIPASCAL_SECOND = 1.0e3


def circuit_tables(controller: Controller) -> dict[str, Rows]:
    """Return the tables of circuits, other leaks, consumers and permissible pressures; some may be without a row."""
    labels = {point.name: point.label for point in controller.operating_points}
    return {
        "Circuits": [*_line_row(controller, labels), *(_circuit_row(each, labels) for each in controller.circuits)],
        "Leaks beside the lands": [
            {
                "leak": leak.name,
                "from": str(leak.high),
                "to": str(leak.low),
                "law": leak.law,
                "flow [dm³/min]": leak.flow * DM3_MIN,
                "at [kPa]": leak.pressure_drop * KPA,
                "at viscosity [mPa·s]": None if leak.viscosity is None else leak.viscosity * MILLIPASCAL_SECOND,
                "at density [g/cm³]": leak.density * G_CM3,
                "gears": _gears(leak.gears),
                "source": leak.source,
            }
            for leak in controller.leaks
        ],
        "Consumers": [
            {
                "consumer": consumer.name,
                **{f"{point.label} [dm³/min]": consumer.at(point) * DM3_MIN for point in controller.operating_points},
                "starves before the line": "yes" if consumer.after_line else "no",
                "source": consumer.source,
            }
            for consumer in controller.consumers
        ],
        "Permissible main pressure": [
            {
                "gears": _gears(each.gears),
                "state": each.state,
                "low [kPa]": None if each.low is None else each.low * KPA,
                "high [kPa]": None if each.high is None else each.high * KPA,
                "source": each.source,
            }
            for each in controller.permissible
        ],
    }


def set_pressure_words(stated: SetPressure | None, labels: dict[str, str]) -> str:
    """Say what a regulator is set to; ``labels`` are those of the operating points by name."""
    if stated is None:
        return "not regulated"
    if stated.following is not None:
        ratio, offset = stated.following.ratio, stated.following.offset
        plus = f" {'+' if offset > 0 else '−'} {abs(offset) * KPA:g} kPa" if offset else ""
        return f"{ratio:g} × {stated.following.section}{plus}"
    if stated.number is not None:
        return f"{stated.number * KPA:g} kPa"
    if stated.points is not None:
        return "; ".join(f"{labels[name]}: {pressure * KPA:g} kPa" for name, pressure in stated.points.items())
    if stated.gears is not None:
        return "; ".join(f"gear {gear}: {pressure * KPA:g} kPa" for gear, pressure in stated.gears.items())
    curve, unit, scale = stated.currents or ((), ()), "mA", MILLIAMPERE
    if stated.duties is not None:
        curve, unit, scale = stated.duties, "% duty", PERCENT
    return "; ".join(
        f"{value * scale:g} {unit}: {pressure * KPA:g} kPa" for value, pressure in zip(*curve, strict=True)
    )


def _line_row(controller: Controller, labels: dict[str, str]) -> Iterable[dict[str, Any]]:
    if controller.line is not None:
        yield {
            "circuit": "p_g · main pressure",
            "gears": _gears(controller.gears),
            "fed from": "the pump",
            "set to": set_pressure_words(controller.line, labels),
            "source": controller.line_source,
        }


def _circuit_row(circuit: Circuit, labels: dict[str, str]) -> dict[str, Any]:
    feeds = (f"{feed.source} ⌀ {feed.diameter * MM:g} mm, C_d {feed.discharge_coefficient:g}" for feed in circuit.feeds)
    return {
        "circuit": f"{circuit.id} · {circuit.name}",
        "gears": _gears(circuit.gears),
        "fed from": "; ".join(feeds),
        "set to": set_pressure_words(circuit.set_pressure, labels),
        "source": circuit.source,
    }


def _gears(gears: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(gears)))
