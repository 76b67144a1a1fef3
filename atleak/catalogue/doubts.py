"""Doubt what a catalogue file states and its checks accept: numbers that are possible, and probably a slip.

Each doubt is a message with the place of its value, so that a page can show it at the field. What is usual stands with
the keys.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from statistics import median
from typing import Any

from pydantic import BaseModel

from atleak.catalogue.entries import read_tables, shipped_files
from atleak.catalogue.keys import usual_values
from atleak.catalogue.usual_values import (
    DISPLACEMENT,
    EACH,
    NEW_CLEARANCE,
    THICKEST,
    THINNEST,
    WIDEST_NEW,
    KeyPattern,
    Usual,
)
from atleak.common.errors import KeySteps, Message
from atleak.common.file_faults import place_of
from atleak.common.sentences import Sentence
from atleak.equations.fluid import astm_d341, astm_d341_coefficients

_CLEARANCE = "mounting_clearance_um"
_OF_USED = "mounting_clearance_of_used_unit"
_FEWEST_LANDS = 3  # whose median says something
_COLD, _HOT = -20.0, 200.0  # [°C] between which it is known what is usual: under the first D341 under-predicts


def doubts_of(
    kind: str, model: type[BaseModel], data: Mapping[str, Any], file: str, *, displacement: float | None = None
) -> tuple[Message, ...]:
    """Return what to ask about the tables of a catalogue file, whether or not they are complete.

    Parameters
    ----------
    kind
        the folder of the catalogue: controllers, fluids, limits or instruments.
    model
        of such files, whose keys say what is usual.
    data
        the tables as a TOML file of the same content gives them; what is no number is passed over.
    file
        what the messages call the file.
    displacement
        of a controller's pump [m³/rev] where its dimensions give it, else None.
    """
    found: list[tuple[KeySteps, Sentence]] = []
    for pattern, usual in usual_values(model).items():
        found += _unusual(data, pattern, usual)
    if kind == "controllers":
        found += _of_clearances(data)
        follows = None if "displacement_mm3" in _table(data, "pump") else displacement
        if follows is not None and (doubt := DISPLACEMENT.doubt(follows * 1e9)):
            found.append((("pump", "kind"), Sentence("By the dimensions of the pump, {doubt}", doubt=doubt)))
    if kind == "limits":
        found += _of_origins(data)
    if kind == "fluids":
        found += _of_viscosities(data)
    return tuple(
        Message("warning", "unusual_value", text, place_of(steps, data, file)) for steps, text in dict.fromkeys(found)
    )


def _unusual(data: Mapping[str, Any], pattern: KeyPattern, usual: Usual) -> Iterator[tuple[KeySteps, Sentence]]:
    for steps, value in _at(data, pattern, ()):
        ends = value if isinstance(value, list) else [value]
        for end in ends:
            if _is_number(end) and (text := usual.doubt(float(end))):
                yield steps, text
                break


def _at(table: Any, pattern: KeyPattern, before: KeySteps) -> Iterator[tuple[KeySteps, Any]]:
    """Yield every value to which the pattern leads, with the steps to it."""
    if not pattern:
        yield before, table
        return
    step, *rest = pattern
    inside: Iterable[tuple[Any, Any]]
    if step == EACH:
        inside = table.items() if isinstance(table, Mapping) else enumerate(table) if isinstance(table, list) else ()
    else:
        inside = ((step, table[step]),) if isinstance(table, Mapping) and step in table else ()
    for name, value in inside:
        yield from _at(value, tuple(rest), (*before, name))


def _of_clearances(data: Mapping[str, Any]) -> Iterator[tuple[KeySteps, Sentence]]:
    """Ask whether mounting clearances are diametral, where their median is over what new valves have.

    Up to `WIDEST_NEW` only where nobody says that they were measured (on a used unit too) or published.
    """
    defaults = _table(data, "defaults")
    widths: list[float] = []
    first: KeySteps | None = None
    stated = True
    for steps, land in _at(data, ("components", EACH, "lands", EACH), ()):
        if not isinstance(land, Mapping):
            continue
        own = _CLEARANCE in land
        ends = land[_CLEARANCE] if own else defaults.get(_CLEARANCE)
        ends = ends if isinstance(ends, list) else [ends]
        if not ends or not all(_is_number(end) for end in ends):
            continue
        widths.append(sum(ends) / len(ends))
        first = first or ((*steps, _CLEARANCE) if own else ("defaults", _CLEARANCE))
        stated = stated and any(_CLEARANCE in _listed(table) or table.get(_OF_USED) for table in (land, defaults))
    if first is None or len(widths) < _FEWEST_LANDS:
        return
    middle = median(widths)
    if middle > (WIDEST_NEW if stated else NEW_CLEARANCE.high):
        low, high = NEW_CLEARANCE.low, NEW_CLEARANCE.high
        yield (
            first,
            Sentence(
                "The median of all mounting clearances is {middle:.4g} µm; new valves have {low:g} to {high:g} µm "
                "radial, which is {twice_low:.3g} to {twice_high:.3g} µm of bore minus spool (published, Sonnax). "
                "Half of bore minus spool is asked for: are these the whole of it?",
                middle=middle,
                low=low,
                high=high,
                twice_low=2 * low,
                twice_high=2 * high,
            ),
        )


def _listed(table: Mapping[str, Any]) -> list[Any]:
    """Return what a table calls measured or published."""
    lists = (table.get(name) for name in ("measured", "published"))
    return [name for each in lists if isinstance(each, list) for name in each]


def _of_origins(data: Mapping[str, Any]) -> Iterator[tuple[KeySteps, Sentence]]:
    """Doubt limits that are called a choice of this project, or published, and that no shipped file calls so.

    A copy of a shipped set keeps saying whose its limits are, whatever they were changed to.
    """
    for name, table in data.items():
        if not isinstance(table, Mapping) or "origin" not in table:
            continue
        shipped = [each[name] for each in _shipped_limits() if name in each]
        alike = [each for each in shipped if all(each[key] == table.get(key) for key in ("origin", "source"))]
        if alike and all(_numbers(each) != _numbers(table) for each in alike):
            yield (
                (name, "origin"),
                Sentence(
                    "'{origin}', but these numbers are not those that this source is given for in a shipped set: "
                    "were they set by the workshop?",
                    origin=table["origin"],
                ),
            )


def _numbers(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a table of limits states besides whose they are; a plain limit as its longer form."""
    return {
        level: {"percent": float(value)} if _is_number(value) else value
        for level, value in table.items()
        if level not in ("origin", "source")
    }


@cache
def _shipped_limits() -> tuple[dict[str, Any], ...]:
    return tuple(read_tables("limits", name)[0] for name in shipped_files("limits"))


def _of_viscosities(data: Mapping[str, Any]) -> Iterator[tuple[KeySteps, Sentence]]:
    """Doubt viscosities that no transmission fluid has at their temperature."""
    key = "kinematic_viscosity_mm2_s"
    for name in ("viscosity", "table"):
        for steps, row in _at(data, (name, EACH), ()):
            stated = row if isinstance(row, Mapping) else {}
            if not _is_number(stated.get("temperature_c")) or not _is_number(stated.get(key)):
                continue
            at, value = float(stated["temperature_c"]), float(stated[key])
            if not _COLD <= at <= _HOT:
                continue
            low, high = (float(f"{_viscosity(ends, at):.2g}") for ends in (THINNEST, THICKEST))
            fluid = Sentence("a transmission fluid at {temperature:g} °C", temperature=at)
            usual = Usual(fluid, "mm²/s", low, high, {"m²/s": 1e6, "µm²/s": 1e-6})
            if text := usual.doubt(value):
                yield (*steps, key), text


def _viscosity(at_40_and_100: tuple[float, float], temperature: float) -> float:
    """Return the viscosity [mm²/s] on the ASTM D341 line through those at 40 and 100 °C."""
    cold, hot = (each * 1e-6 for each in at_40_and_100)
    return float(astm_d341(temperature, *astm_d341_coefficients(40.0, cold, 100.0, hot))) * 1e6


def _table(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = data.get(name)
    return table if isinstance(table, Mapping) else {}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
