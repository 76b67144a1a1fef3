"""Numbers that no unit has: every number of a catalogue file, made absurd, is refused with its place."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.controller_file import checked_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import checked_fluid
from atleak.catalogue.instruments import checked_instrument
from atleak.catalogue.limits import checked_limits
from atleak.common.errors import CatalogueError

CHECKED = {
    "controllers": checked_controller,
    "fluids": checked_fluid,
    "instruments": checked_instrument,
    "limits": checked_limits,
}
OF_CONTROLLERS = ("five_speed_2005", "four_speed_2023")
THREE_CIRCUITS = Path(__file__).parents[2] / "three_circuits.toml"
Steps = tuple[str | int, ...]


def numbers_in(table: Any, steps: Steps = ()) -> Iterator[Steps]:
    if isinstance(table, dict | list):
        for name, value in table.items() if isinstance(table, dict) else enumerate(table):
            yield from numbers_in(value, (*steps, name))
    elif isinstance(table, int | float) and not isinstance(table, bool):
        yield steps


def changed(table: Any, steps: Steps, value: float) -> Any:
    """The tables with one number replaced."""
    if not steps:
        return value
    first, *rest = steps
    copy: Any = dict(table) if isinstance(table, dict) else list(table)
    copy[first] = changed(table[first], tuple(rest), value)
    return copy


def numbers(kind: str) -> Iterator[tuple[dict[str, Any], Steps]]:
    """Every number that shipped files of a kind state, one of those under the same keys, and the tables around it."""
    paths = [path for name, path in shipped_files(kind).items() if kind != "controllers" or name in OF_CONTROLLERS]
    seen = set()
    for path in (*paths, *([THREE_CIRCUITS] if kind == "controllers" else [])):
        data = tomllib.loads(path.read_text(encoding="utf-8"))
        for steps in numbers_in(data):
            keys = tuple(step for step in steps if isinstance(step, str))
            if keys not in seen:
                seen.add(keys)
                yield data, steps


def refusal(kind: str, data: dict[str, Any], steps: Steps, value: float) -> str | None:
    """What is said of a file with this number; None where it is taken."""
    try:
        CHECKED[kind](changed(data, steps, value), "own.toml")
    except CatalogueError as fault:
        return str(fault)
    return None


@pytest.mark.parametrize("kind", CHECKED)
@pytest.mark.parametrize("value", [10**400, -(10**400)])
def test_a_whole_number_of_400_digits_is_refused_in_words(kind: str, value: int) -> None:
    for data, steps in numbers(kind):
        said = refusal(kind, data, steps, value)
        assert said is not None, steps
        assert "own.toml" in said
        assert "could not make sense" not in said, said


@pytest.mark.parametrize("kind", ["fluids", "instruments", "limits"])
@pytest.mark.parametrize("value", [1e308, 7e26, 1e6 + 1.0, -1e6, math.inf, -math.inf, math.nan])
def test_no_number_of_a_fluid_an_instrument_or_a_limit_may_be_absurd(kind: str, value: float) -> None:
    for data, steps in numbers(kind):
        said = refusal(kind, data, steps, value)
        assert said is not None, steps
        assert f"own.toml, [{steps[0]}" in said or f"own.toml, key '{steps[0]}'" in said
        assert f"(found {value}" in said
        assert "expected" in said


@pytest.mark.parametrize(
    ("table", "level", "value", "most"),
    [
        ("total_share_percent", "critical", 5000.0, 1000),
        ("below_permissible_percent", "critical", 250.0, 100),
        ("clearance_um", "replace", 600.0, 500),
    ],
)
def test_a_limit_that_its_quantity_cannot_reach_is_refused(table: str, level: str, value: float, most: int) -> None:
    data = tomllib.loads(shipped_files("limits")["project_default"].read_text(encoding="utf-8"))
    data.setdefault(table, {"origin": "set by the workshop", "source": "a slip"})[level] = value
    with pytest.raises(CatalogueError, match=rf"at most {most} in {table}\.{level}, not {value:g}$"):
        checked_limits(data, "own.toml")
    data[table][level] = float(most)
    assert checked_limits(data, "own.toml").doubts
