# ruff: noqa: E501
"""Unit names into SI, with pint as referee."""

from __future__ import annotations

import pint
import pytest

from atleak.common.errors import InputError
from atleak.common.units import find_unit, kinds_of, unit, unit_names

REFEREE = {
    "length": ("m", {"mm": "mm", "µm": "um", "inch": "inch", "mil": "thou", "cm": "cm", "m": "m"}),
    "pressure": (
        "Pa",
        {
            "kPa": "kPa",
            "bar": "bar",
            "mbar": "mbar",
            "MPa": "MPa",
            "psi": "psi",
            "Pa": "Pa",
            "kgf/cm²": "kgf/cm**2",
            "0.1 kPa": "hPa",
        },
    ),
    "temperature": ("degC", {"°C": "degC", "°F": "degF", "K": "kelvin"}),
    "rotational_speed": ("rps", {"rpm": "rpm", "1/s": "rps", "rad/s": "rad/s"}),
    "speed": ("m/s", {"km/h": "km/hour", "mph": "mph", "m/s": "m/s"}),
    "time": ("s", {"s": "s", "ms": "ms", "µs": "us", "min": "min", "h": "hour", "ns": "ns", "d": "day"}),
}


@pytest.fixture(scope="module")
def registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


@pytest.mark.parametrize(
    ("kind", "name", "other"),
    [(kind, name, other) for kind, (_, names) in REFEREE.items() for name, other in names.items()],
)
@pytest.mark.parametrize("value", [-3.5, 0.0, 71.25, 4000.0])
def test_agrees_with_pint(registry: pint.UnitRegistry, kind: str, name: str, other: str, value: float) -> None:
    value += 300.0 * (other == "kelvin")  # nothing is colder than zero kelvin
    expected = registry.Quantity(value, other).to(REFEREE[kind][0]).magnitude
    tested_unit = unit(name, kind)
    assert tested_unit.to_si(value) == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert tested_unit.from_si(tested_unit.to_si(value)) == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("written", "kind", "name"),
    [
        ("℃", "temperature", "°C"), ("*C", "temperature", "°C"), ("deg C", "temperature", "°C"), ("C", "temperature", "°C"), ("°С", "temperature", "°C"),
        ("ºF", "temperature", "°F"), ("degF", "temperature", "°F"), ("â°C", "temperature", "°C"),
        ("/min", "rotational_speed", "rpm"), ("U/min", "rotational_speed", "rpm"), ("min⁻¹", "rotational_speed", "rpm"), ("об/мин", "rotational_speed", "rpm"),
        ("tr/min", "rotational_speed", "rpm"), ("obr/min", "rotational_speed", "rpm"),
        ("kph", "speed", "km/h"), ("MPH", "speed", "mph"), ("Meters/second", "speed", "m/s"), ("км/ч", "speed", "km/h"),
        ("hPa", "pressure", "mbar"), ("кПа", "pressure", "kPa"), ("kg/cm2", "pressure", "kgf/cm²"), ("BAR", "pressure", "bar"),
        ("msec", "time", "ms"), ("sec.", "time", "s"), ("с", "time", "s"),
    ],
)  # fmt: skip
def test_spellings(written: str, kind: str, name: str) -> None:
    assert find_unit(written, kind).name == name


def test_kinds_stay_apart() -> None:
    assert find_unit("%", "pressure") is None
    assert find_unit("V", "temperature") is None
    assert kinds_of("m") == ["length"]
    assert kinds_of("furlong") == []


@pytest.mark.parametrize("kind", REFEREE)
def test_unknown_unit_names_the_nearest(kind: str) -> None:
    wrong = unit_names(kind)[0] + "x"
    with pytest.raises(InputError, match="expected one of") as caught:
        unit(wrong, kind)
    assert caught.value.value == wrong
