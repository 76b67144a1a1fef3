"""Describe a key of a catalogue file once, on the model of its table.

What a key is called, what it means, between which values it usually lies and what becomes of it in SI units follows for
the reader of files, the sheets of the workbook and the forms of the pages. The unit is the end of the key's own name.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, Field
from pydantic.fields import FieldInfo

from atleak.catalogue.usual_values import EACH, KeyPattern, Usual
from atleak.common.file_faults import model_in

_Made = TypeVar("_Made")
_KEY = "key"
LIMIT = "percent"  # key of a limit in the table of its level, whatever its unit


class _Unit(NamedTuple):
    """A unit as people read it, and how many of the SI unit it is: ``size``, or one part in ``parts``."""

    label: str
    size: float = 1.0
    parts: float = 1.0

    def in_si(self, value: Any) -> Any:
        """Return a number, or a list of them as a tuple, in SI units; anything else as it is."""
        if isinstance(value, float):
            return value * self.size / self.parts
        return tuple(map(self.in_si, value)) if isinstance(value, list) else value


NO_UNIT = _Unit("")
_UNITS: Mapping[str, _Unit] = MappingProxyType(  # by the end of a key, the longer ones first
    {
        "_g_cm3_k": _Unit("g/(cm³·K)", 1e3),
        "_g_cm3": _Unit("g/cm³", 1e3),
        "_dm3_min": _Unit("dm³/min", parts=60e3),
        "_mm2_s": _Unit("mm²/s", 1e-6),
        "_percent": _Unit("%", 1e-2),
        "_per_k": _Unit("1/K"),
        "_mm3": _Unit("mm³", 1e-9),
        "_rpm": _Unit("rpm", parts=60.0),
        "_kpa": _Unit("kPa", 1e3),
        "_mpa": _Unit("MPa", 1e6),
        "_mm": _Unit("mm", 1e-3),
        "_um": _Unit("µm", 1e-6),
        "_ma": _Unit("mA", 1e-3),
        "_c": _Unit("°C"),
    }
)


@dataclass(frozen=True)
class Key:
    """What people read of a key beside its value; without a heading the keys of its table stand in its place."""

    heading: str = ""
    help: str = ""
    unit: str = ""  # where the key's own name does not end in it
    radial: bool = False  # a clearance that people may know as bore minus spool
    usual: Usual | None = None  # outside of it the value is doubted
    known: str = ""  # heading over what its value is known from, where the table lists such keys
    known_of_all: str = ""  # likewise, of all lands
    up_to: tuple[str, str] = ("", "")  # heading and help of the upper end, where it may be a range
    names: str = ""  # whose names may stand here: "material"
    width: int = 14  # of its column, in characters
    one: str = ""  # key of a single value, where this one is of several
    becomes: str = ""  # name of the value in SI units, where that is not the key without its unit


def key(heading: str = "", help: str = "", **more: Any) -> Any:
    """Return the field of a model for a key: ``more`` has parameters of `Key`, and those of `pydantic.Field`."""
    own = {name: more.pop(name) for name in Key.__dataclass_fields__ if name in more}
    described = Key(heading, help, **own)
    return Field(description=help or None, json_schema_extra={_KEY: described}, **more)  # type: ignore[dict-item]


def key_of(field: FieldInfo) -> Key | None:
    """Return how a key is described; None where people meet it under no heading of its own."""
    extra = field.json_schema_extra
    described = extra.get(_KEY) if isinstance(extra, dict) else None
    return described if isinstance(described, Key) else None


def unit_of(name: str) -> tuple[str, _Unit]:
    """Return the name of a key without its unit, and that unit.

    >>> unit_of("contact_length_mm")[0], unit_of("contact_length_mm")[1].label, unit_of("land")
    ('contact_length', 'mm', ('land', _Unit(label='', size=1.0, parts=1.0)))
    """
    for end, unit in _UNITS.items():
        if name.endswith(end):
            return name.removesuffix(end), unit
    return name, NO_UNIT


def made(kind: type[_Made], table: BaseModel, /, **more: Any) -> _Made:
    """Return the object of a table: each of its values that such an object has, in SI units, and what is given."""
    plan: Any = _plan  # whose types are hashable
    stated = vars(table)
    return kind(**{name: unit.in_si(stated[key]) for name, key, unit in plan(type(table), kind)} | more)


def in_si(table: BaseModel) -> dict[str, Any]:
    """Return the values of a table in SI units, each under the name of its key without the unit, or what it becomes."""
    return {name: unit.in_si(getattr(table, key)) for name, key, unit in _plan(type(table))}


@cache
def _plan(model: type[BaseModel], kind: Any = None) -> tuple[tuple[str, str, _Unit], ...]:
    """Return the names of values with those of their keys and units: all of a table, or those of an object."""
    wanted = None if kind is None else {each.name for each in dataclasses.fields(kind)}
    plan = []
    for key, field in model.model_fields.items():
        described, (name, unit) = key_of(field), unit_of(key)
        name = (described.becomes if described else "") or name
        if wanted is None or name in wanted:
            plan.append((name, key, unit))
    return tuple(plan)


@cache
def usual_values(model: type[BaseModel]) -> Mapping[KeyPattern, Usual]:
    """Return between which values the numbers of a file usually lie, by the steps to them through its tables."""
    return MappingProxyType(dict(_usual(model, ())))


def _usual(model: type[BaseModel], at: KeyPattern) -> Iterator[tuple[KeyPattern, Usual]]:
    for name, field in model.model_fields.items():
        described, inner = key_of(field), model_in(field.annotation)
        here = (*at, field.alias or name)
        if described is not None and described.usual is not None:
            yield here, described.usual
            if inner is not None:  # of limits: each level is a number, or a table that states it
                yield from (((*here, EACH), described.usual), ((*here, EACH, LIMIT), described.usual))
        if inner is not None:
            several = getattr(field.annotation, "__origin__", None) in (list, dict)
            yield from _usual(inner, (*here, EACH) if several else here)
