"""Turn the keys of a file's tables, as their models describe them, into the columns of sheets and forms."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from enum import Enum
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from atleak.catalogue.entries import Evidence
from atleak.catalogue.keys import Key, key_of, unit_of
from atleak.controller_sheets.kinds import Choice, Day, Gear, Gears, Kind, Names, Number, Whole, Wholes, YesNo
from atleak.controller_sheets.shapes import Column, KnownOfAll
from atleak.controller_sheets.units import CLEARANCE, MEASURES, Measure
from atleak.faults import model_in

EVIDENCE = Choice(tuple(Evidence))
_OF_ALL = "How known, of all lands that do not say otherwise; empty: not stated"
_OWN_KINDS: dict[str, Kind] = {"date": Day(), "gear": Gear(), "gears": Gears()}  # by key


def columns_of(
    model: type[BaseModel],
    at: tuple[str, ...] = (),
    *,
    without: Collection[str] = (),
    last: Sequence[str] = (),
    known: Choice = EVIDENCE,
    known_help: str = "Empty: as the head says",
) -> tuple[Column, ...]:
    """Return the columns of a table's keys, and of those of the tables in it that have no sheet of their own.

    Parameters
    ----------
    model
        of the table.
    at
        the keys that lead to it from the table of the sheet.
    without, last
        keys that have no column here, and keys that come after the others.
    known, known_help
        what a value can be known from, where a column says it, and the help of that column.
    """
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    columns: list[Column] = []
    for name in (*(name for name in fields if name not in {*last, *without}), *last):
        field, described = fields[name], key_of(fields[name])
        if described is None:
            continue
        inner = model_in(field.annotation)
        if described.heading:
            columns += _columns(name, field, described, at)
            if described.known:
                columns.append(Column(described.known, (), known, help=known_help, how_known=name, width=15))
        elif inner is not None:
            columns += columns_of(inner, (*at, name))
    return tuple(columns)


def known_of_all(model: type[BaseModel]) -> tuple[Column, ...]:
    """Return the columns of the head that say how values of all these tables are known."""
    described = {name: key_of(field) for name, field in model.model_fields.items()}
    return tuple(
        KnownOfAll(each.known_of_all, (), EVIDENCE, value_of_all=name, help=_OF_ALL)
        for name, each in described.items()
        if each is not None and each.known_of_all
    )


def in_kind(columns: Iterable[Column], heading: str, kind: Kind) -> tuple[Column, ...]:
    """Return columns of which one has another kind than its key says."""
    return tuple(replace(each, kind=kind) if each.heading == heading else each for each in columns)


def kind_of(name: str, annotation: Any, described: Key) -> Kind:
    """Return what cells hold for a key: by its name, which ends in its unit, and by its type."""
    if name in _OWN_KINDS:
        return _OWN_KINDS[name]
    unit, plain = described.unit or unit_of(name)[1].label, _bare(annotation)
    if plain is int:
        return Whole(unit)
    if unit or plain is float:
        return Number(_measure(unit, described))
    if plain is bool:
        return YesNo()
    if get_origin(plain) is Literal:
        return Choice(get_args(plain))
    if isinstance(plain, type) and issubclass(plain, Enum):
        return Choice(tuple(plain))
    if get_origin(plain) is list:
        each = _bare(get_args(plain)[0])
        return Wholes() if each is int else Names(get_args(each) if get_origin(each) is Literal else ())
    return Kind()


def _columns(name: str, field: FieldInfo, described: Key, at: tuple[str, ...]) -> list[Column]:
    column = Column(
        described.heading,
        (*at, name),
        kind_of(name, field.annotation, described),
        required=field.is_required() and not at,
        help=described.help,
        names=described.names,
        width=described.width,
    )
    heading, help = described.up_to
    if not heading:
        return [column]
    return [replace(column, end=0), replace(column, heading=heading, help=help, end=1)]


def _measure(unit: str, described: Key) -> Measure:
    measure = CLEARANCE if described.radial else MEASURES.get(unit, Measure(unit))
    if described.usual is None or measure.quantity != "length":
        return measure
    of_land = described.radial or unit == "mm"  # what manuals state in either unit, or as bore minus spool
    return replace(measure, usual=described.usual.ends, is_doubted=of_land)


def _bare(annotation: Any) -> Any:
    """Return a type without None and without what pydantic is told of it."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return _bare(next(each for each in get_args(annotation) if each is not type(None)))
    return annotation
