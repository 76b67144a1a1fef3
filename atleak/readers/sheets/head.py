"""What stands above the headings: temperature and date of measuring, the pump's clearances, and whose unit it is."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.catalogue.written_numbers import (
    MEASURING_TEMPERATURE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    AskedNumber,
    possible_values,
    read_number,
)
from atleak.common.errors import Message, ReadingsError
from atleak.common.sentences import Sentence, all_of
from atleak.common.units import Unit, find_unit, unit
from atleak.measurements.own_forms import TYPED
from atleak.measurements.readings import SheetIdentity
from atleak.readers.cells.sheet import Cell, Sheet
from atleak.readers.dates import sure_date
from atleak.readers.sheets.head_fields import Stated, read_identity, several, stated_values
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import text_of

_VALUE = re.compile(
    r"(?P<number>[+\-−]?\s?[.,]?\d[\d.,]*)\s*(?:(?:±|\+/?-)\s*[\d.,]+\s*)?(?P<unit>[^\d\s.,±].*)?", re.DOTALL
)


@dataclass(frozen=True)
class _Quantity:
    """A number that a head may state: by which words its label is known, and in which units it is read."""

    words: tuple[str, ...]  # a label has one of each of these meanings
    beside: tuple[str, ...]  # and no other words but of these
    unit: Unit  # where none is written, and for people
    kind: str  # of its units
    asked: AskedNumber
    what: Sentence  # it is, in a message
    of: Sentence  # what
    unlikely: Sentence  # what is said of one outside the limits
    code: str  # of the message that several are stated


_TEMPERATURE = _Quantity(
    *(("temperature",), ("beside_head",), unit("°C", "temperature"), "temperature", MEASURING_TEMPERATURE),
    *(Sentence("temperature"), Sentence("of gauge and parts"), Sentence("at which anybody measures")),
    "measuring_temperature_unclear",
)
_CLEARANCES = tuple(
    _Quantity(
        *(("pump", words), ("beside_pump", "beside_head"), unit("µm", "length"), "length", asked),
        *(what, Sentence("of this pump"), Sentence("that a pump has")),
        "pump_clearance_unclear",
    )
    for words, asked, what in (
        ("pump_side", PUMP_SIDE_CLEARANCE, Sentence("pump side clearance")),
        ("pump_tip", PUMP_TIP_CLEARANCE, Sentence("pump tip clearance")),
    )
)


@dataclass(frozen=True)
class SheetHead:
    """Temperature [°C] and date of measuring and the pump's clearances as a head states them, and whose unit it is.

    ``cells`` are those read, as sheet, row and column.
    """

    temperature: float | None = None
    date: dt.date | None = None
    pump: PumpClearances = NO_CLEARANCES
    identity: SheetIdentity = field(default_factory=SheetIdentity)
    cells: tuple[tuple[str | None, int, int], ...] = ()
    messages: tuple[Message, ...] = ()
    problems: tuple[ReadingsError, ...] = ()


def read_head(tables: Sequence[HeadedTable], sheets: Sequence[Sheet]) -> SheetHead:
    """Read what stands above the first headings of every sheet that holds one of the tables.

    Two temperatures or dates that differ are named, and none of them is taken. A temperature that is none is a problem;
    a date whose day and month may be swapped is named and not taken.
    """
    first: dict[str | None, int] = {}
    for table in tables:
        first[table.sheet.name] = min(table.first, first.get(table.sheet.name, table.first))
    heads = [
        (sheet, range(is_typed(sheet), max(first[sheet.name], 0)))  # the plan of what is typed is no field of the job
        for sheet in sheets
        if sheet.name in first
    ]
    messages: list[Message] = []
    problems: list[ReadingsError] = []
    cells: list[Stated] = []

    def values(quantity: _Quantity) -> float | None:
        stated = [*stated_values(heads, quantity.words, quantity.beside, quantity.kind)]
        stated += _without_the_word(heads) if quantity is _TEMPERATURE else ()
        cells.extend(stated)
        return _value(stated, quantity, messages, problems)

    temperature, side, tip = (values(quantity) for quantity in (_TEMPERATURE, *_CLEARANCES))
    dates = list(stated_values(heads, ("date",), ("beside_head",), "temperature"))
    date, doubts = _read_date(dates)
    identity, fields, of_identity = read_identity(heads)
    return SheetHead(
        temperature=temperature,
        date=date,
        pump=PumpClearances.of_um(side, tip),
        identity=identity,
        cells=tuple((at.sheet.name, at.row, at.column) for at in (*cells, *dates, *fields)),
        messages=(*messages, *doubts, *of_identity),
        problems=tuple(problems),
    )


def is_typed(sheet: Sheet) -> bool:
    """Return whether the readings of a sheet are being typed in: its first row says so, and holds their plan."""
    return any(TYPED.mark in row for row in sheet.rows[:1])


def _value(
    stated: Sequence[Stated], quantity: _Quantity, messages: list[Message], problems: list[ReadingsError]
) -> float | None:
    """Return the value of a quantity in the unit in which people are asked for it; of several that differ none."""
    values: dict[float, Stated] = {}
    for entry in stated:
        try:
            values.setdefault(_number(entry, quantity), entry)
        except ReadingsError as error:
            problems.append(error)
    if len(values) > 1:
        template = Sentence("{value:g} {unit} ({place})")
        named = all_of(
            template.of(value=value, unit=quantity.asked.unit, place=entry.place.sentence)
            for value, entry in values.items()
        )
        text = Sentence(
            "the head states several {what}s, {named}: none is taken. State the one {of}",
            what=quantity.what,
            named=named,
            of=quantity.of,
        )
        messages.append(Message("warning", quantity.code, text, next(iter(values.values())).place))
    return next(iter(values)) if len(values) == 1 else None


def _without_the_word(heads: Sequence[tuple[Sheet, range]]) -> Iterator[Stated]:
    """Yield what is told by its unit to be a temperature: "measured at 24.1 °C", "referred to 20 °C"."""
    for stated in stated_values(heads, ("at_temperature",), ("beside_head", "beside_at_temperature"), "temperature"):
        match = _VALUE.fullmatch(text_of(stated.value))
        if match and match["unit"] and find_unit(match["unit"], "temperature") is not None:
            yield stated


def _number(stated: Stated, quantity: _Quantity) -> float:
    """Return a number in the unit in which people are asked for it; an error with its place where there is none."""
    number, unit, asked = stated.value, stated.unit or quantity.unit, quantity.asked
    if isinstance(number, str):
        match = _VALUE.fullmatch(re.sub(r"\s*\([^()]*\)$", "", number.strip()))
        values = possible_values(match["number"]) if match else ()
        stated_unit = find_unit(match["unit"], quantity.kind) if match and match["unit"] else unit
        if values and stated_unit is not None:
            number, unit = values[0], stated_unit
    if isinstance(number, bool) or not isinstance(number, int | float):
        problem = Sentence("no {what}", what=quantity.what)
        expected = Sentence("one {what}, such as {example:g} {unit}")
        expected = expected.of(what=quantity.what, example=asked.example, unit=asked.unit)
        raise ReadingsError(problem, place=stated.place, value=str(number), expected=expected)
    value = round(float(quantity.unit.from_si(unit.to_si(float(number)))), 9)
    if read_number(repr(value), asked).value is None:
        low, high = (f"{end:g}".replace("-", "−") for end in asked.limits)
        problem = Sentence("no {what} {unlikely}", what=quantity.what, unlikely=quantity.unlikely)
        expected = Sentence("the {what} {of}, from {low} to {high} {unit}")
        expected = expected.of(what=quantity.what, of=quantity.of, low=low, high=high, unit=asked.unit)
        raise ReadingsError(problem, place=stated.place, value=stated.value, expected=expected)
    return value


def _read_date(stated: Sequence[Stated]) -> tuple[dt.date | None, list[Message]]:
    """Return the date of measuring, and why none is taken of those that the heads state."""
    dates: dict[dt.date, Stated] = {}
    messages = []
    for entry in stated:
        date = _date(entry.value)
        if date is not None:
            dates.setdefault(date, entry)
        elif re.search(r"\d", str(entry.value)):
            text = Sentence(
                "the date {date!r} in the head is not taken: it can be read in two ways, or is none. Write it as "
                "2026-04-17",
                date=str(entry.value),
            )
            messages.append(Message("warning", "head_unclear", text, entry.place))
    if len(dates) > 1:
        messages.append(several([(date.isoformat(), entry) for date, entry in dates.items()], Sentence("date")))
    return next(iter(dates)) if len(dates) == 1 else None, messages


def _date(cell: Cell) -> dt.date | None:
    if isinstance(cell, dt.datetime):
        return cell.date()
    if isinstance(cell, dt.date):
        return cell
    return sure_date([cell]) if isinstance(cell, str) else None
