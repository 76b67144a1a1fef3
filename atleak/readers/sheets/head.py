"""What stands above the headings: temperature and date of measuring, the pump's clearances, and whose unit it is.

A value stands behind, beside or under its label.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.catalogue.written_numbers import (
    MEASURING_TEMPERATURE,
    MILEAGE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    AskedNumber,
    WrittenNumber,
    possible_values,
    read_number,
)
from atleak.common.errors import Message, Place, ReadingsError
from atleak.common.sentences import Sentence, all_of
from atleak.common.units import MILE, Unit, find_unit, unit
from atleak.measurements.own_forms import TYPED
from atleak.measurements.readings import SheetIdentity
from atleak.readers.cells.sheet import BRACKETS, Cell, Sheet
from atleak.readers.dates import sure_date
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import is_blank, letters, plain, text_of

# words that head cells of their own: one of these beside a label is no value of it
_OTHER_LABELS = (
    *("state", "person", "pump", "quantity", "remark", "gauge", "name", "number", "component", "part", "unit", "date"),
)
_FIELDS = (
    *(f"head_{field}" for field in ("job", "vehicle", "vin", "serial", "mileage", "technician", "instrument")),
    *("date", "temperature", "pump"),
)
_OF_FIELDS = (*_FIELDS, "beside_identity", "beside_head", "pump_side", "pump_tip", "beside_pump")
_LABEL = re.compile(r"(?P<label>[^:=\d]*?[^:=\d\s+\-−])\s*(?:[:=]\s*(?P<value>.*)|(?P<number>[+\-−]?\d.*))?", re.DOTALL)
_REACH = 2  # cells to the right of a label in which its value may stand


@dataclass(frozen=True)
class Stated:
    """A value beside its label: its cell, and the unit that the label says."""

    sheet: Sheet
    row: int
    column: int
    value: Cell
    unit: Unit | None
    label: str  # as it is written

    @property
    def place(self) -> Place:
        """Return where it stands."""
        return self.sheet.place(self.row, self.column)


def stated_values(
    heads: Sequence[tuple[Sheet, range]], meaning: Sequence[str], beside: Sequence[str], kind: str | None
) -> Iterator[Stated]:
    """Yield what stands behind, beside or under every label of this meaning, in the rows above the headings of sheets.

    A label has a word of each ``meaning``, and no others than those that may stand ``beside``. ``kind`` is that of the
    units of its value; None where it is a text.
    """
    for sheet, rows in heads:
        cells = [(row, column, cell) for row in rows for column, cell in enumerate(sheet.rows[row])]
        for row, column, cell in cells:
            match = _LABEL.fullmatch(cell.strip()) if isinstance(cell, str) else None
            if match is None or sheet.is_struck(row, column) or not means(match["label"], meaning, beside):
                continue
            in_cell = (match["value"] or match["number"] or "").strip()
            label = match["label"]
            written = [*(inner[1] for inner in BRACKETS.finditer(label)), *label.split()[-1:]]
            unit = next((unit for text in written if (unit := _unit(text.strip(), kind))), None)
            stated = Stated(sheet, row, column, in_cell, unit, label)
            field = stated if in_cell else _beside(stated, row + 1 in rows, kind)
            if field is not None and not sheet.is_struck(field.row, field.column):
                yield field


def means(label: str, meaning: Sequence[str], beside: Sequence[str]) -> bool:
    """Tell whether a label has a word of each meaning, and no words but these and those that may stand beside."""
    words = letters(label)
    return words.only(*meaning, *beside) and all(map(words.any, meaning))


def _unit(text: str, kind: str | None) -> Unit | None:
    return None if kind is None else find_unit(text, kind)


def _beside(label: Stated, has_row_below: bool, kind: str | None) -> Stated | None:
    """Return the value of a label that stands alone: to its right, or under it where labels stand in a row."""
    sheet, row = label.sheet, label.row
    is_label = _heads_a_field if kind is None else _heads_something
    for column in range(label.column + 1, label.column + 1 + _REACH):
        cell = sheet.cell(row, column)
        if is_blank(cell):
            continue
        if is_label(cell):
            break
        following = text_of(sheet.cell(row, column + 1))
        if kind and sheet.is_text and text_of(cell).isdecimal() and following[:1].isdecimal():
            cell = f"{cell} | {following}"  # a decimal comma that the file also uses between its columns
        return Stated(sheet, row, column, cell, _unit(following, kind) or label.unit, label.label)
    below = sheet.cell(row + 1, label.column) if has_row_below else ""
    if is_blank(below) or is_label(below):
        return None
    return Stated(sheet, row + 1, label.column, below, label.unit, label.label)


def _heads_something(cell: Cell) -> bool:
    """Tell whether a cell heads something else than a number: words without one, one of them a usual label."""
    if not isinstance(cell, str) or re.search(r"\d", cell):
        return False
    return cell.rstrip().endswith(":") or letters(cell).any(*_OTHER_LABELS)


def _heads_a_field(cell: Cell) -> bool:
    """Tell whether a cell where a text may stand heads another field: all its words are those of labels."""
    if not isinstance(cell, str):
        return False
    bare = BRACKETS.sub("", cell.split(":")[0].split("=")[0])
    # an "air gauge" has words that stand beside a label, and is none itself
    instrument = means(bare, ("head_instrument",), ("head_of_spools", "head_of_bores", "beside_identity"))
    is_field = instrument or (means(bare, (), _OF_FIELDS) and letters(bare).any(*_FIELDS))
    return cell.rstrip().endswith(":") or (is_field and not re.search(r"\d", bare))


_LONGEST = 200  # signs of a text; what is longer is no entry of a field
_BESIDE, _OF_VEHICLE = ("beside_identity",), ("beside_identity", "head_vehicle")
_DISTANCE = re.compile(r"(?P<number>.*?)\s*(?P<unit>km|kms|mi|mile|miles)\.?", re.IGNORECASE | re.DOTALL)
_OF_MILES = frozenset(("mi", "mile", "miles"))  # in a label
_MILES = replace(MILEAGE, unit="mi")


# by the meaning of which words a label is known, one of each, and what else may stand in it; the field in a message. In
# the order in which a label is tried: "vehicle identification number" is no vehicle
_OF_JOB: Mapping[str, tuple[tuple[str, ...], tuple[str, ...], Sentence]] = {
    "vin": (("head_vin",), _OF_VEHICLE, Sentence("VIN")),
    "mileage": (("head_mileage",), _OF_VEHICLE, Sentence("mileage")),
    "vehicle": (("head_vehicle",), _BESIDE, Sentence("vehicle")),
    "serial": (("head_serial",), _BESIDE, Sentence("serial number")),
    "job": (("head_job",), _BESIDE, Sentence("job")),
    "technician": (("head_technician",), _BESIDE, Sentence("name of who measured")),
    "for spools": (("head_instrument", "head_of_spools"), _BESIDE, Sentence("instrument for spools")),
    "for bores": (("head_instrument", "head_of_bores"), _BESIDE, Sentence("instrument for bores")),
    "for all": (("head_instrument",), _BESIDE, Sentence("instrument")),
}
_INSTRUMENTS = ("for spools", "for bores", "for all")


def read_identity(heads: Sequence[tuple[Sheet, range]]) -> tuple[SheetIdentity, list[Stated], list[Message]]:
    """Return the fields of the job from the rows above the headings, where they stand, and what is doubtful of them.

    Of a field that is stated twice, differently, nothing is taken, nor is a mileage that cannot be read: a message says
    so. No field makes a sheet unusable.
    """
    every: list[Stated] = []
    messages: list[Message] = []
    values: dict[str, str | float] = {}
    for name, (words, beside, what) in _OF_JOB.items():
        taken = {(stated.sheet.name, stated.row, stated.column) for stated in every}
        fields = [
            stated
            for stated in stated_values(heads, words, beside, None)
            if (stated.sheet.name, stated.row, stated.column) not in taken and len(text_of(stated.value)) <= _LONGEST
        ]
        every += fields
        by_text = {plain(text_of(stated.value)): stated for stated in fields}
        if len(by_text) > 1:
            messages.append(several([(text_of(one.value), one) for one in by_text.values()], what))
        for stated in by_text.values() if len(by_text) == 1 else ():
            value = _mileage(stated, messages) if name == "mileage" else text_of(stated.value)
            if value not in ("", None):
                values[name] = value
    instruments = [str(values.pop(name)) for name in _INSTRUMENTS if name in values]
    identity = SheetIdentity(**values, instruments=tuple(dict.fromkeys(instruments)))  # type: ignore[arg-type]
    return identity, every, messages


def several(stated: Sequence[tuple[str, Stated]], what: Sentence) -> Message:
    """Tell that the heads state one thing differently: each as it reads, and where it stands."""
    named = all_of(Sentence("{value!r} ({place})", value=value, place=entry.place.sentence) for value, entry in stated)
    text = Sentence(
        "the head states the {what} more than once, differently: {named}. None is taken", what=what, named=named
    )
    return Message("warning", "head_unclear", text, stated[0][1].place)


def _mileage(stated: Stated, messages: list[Message]) -> float | None:
    read = written_mileage(text_of(stated.value), stated.label)
    if read.value is None:
        text = Sentence("the mileage in the head is not taken: {reason}", reason=read.reason)
        messages.append(Message("warning", "head_unclear", text, stated.place))
    return read.value


def written_mileage(written: str, label: str) -> WrittenNumber:
    """Read a mileage, in km or in miles as it or its label says.

    >>> written_mileage("106 315", "Mileage [km]").value, round(written_mileage("66 061 mi", "Odometer").value)
    (106315.0, 106315)
    """
    match = _DISTANCE.fullmatch(written)
    unit = match["unit"] if match else ""
    in_miles = unit.lower().startswith("mi") or (not unit and not _OF_MILES.isdisjoint(letters(label)))
    read = read_number(match["number"] if match else written, _MILES if in_miles else MILEAGE)
    return replace(read, value=read.value * MILE / 1e3) if in_miles and read.value is not None else read


def identity_field(label: str) -> str | None:
    """Return which field of the job a label names, as ``vin`` or ``mileage``; None where it names none.

    >>> identity_field("Chassis no."), identity_field("Kilometerstand"), identity_field("Supplier")
    ('vin', 'mileage', None)
    """
    return next((name for name, (words, beside, _) in _OF_JOB.items() if means(label, words, beside)), None)


_VALUE = re.compile(
    r"(?P<number>[+\-−]?\s?[.,]?\d[\d.,]*)\s*(?:(?:±|\+/?-)\s*[\d.,]+\s*)?(?P<unit>[^\d\s.,±].*)?", re.DOTALL
)


@dataclass(frozen=True)
class _Quantity:
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
        text = Sentence("the head states several {what}s, {named}: none is taken. State the one {of}")
        text = text.of(what=quantity.what, named=named, of=quantity.of)
        messages.append(Message("warning", quantity.code, text, next(iter(values.values())).place))
    return next(iter(values)) if len(values) == 1 else None


def _without_the_word(heads: Sequence[tuple[Sheet, range]]) -> Iterator[Stated]:
    """Yield what is told by its unit to be a temperature: "measured at 24.1 °C", "referred to 20 °C"."""
    for stated in stated_values(heads, ("at_temperature",), ("beside_head", "beside_at_temperature"), "temperature"):
        match = _VALUE.fullmatch(text_of(stated.value))
        if match and match["unit"] and find_unit(match["unit"], "temperature") is not None:
            yield stated


def _number(stated: Stated, quantity: _Quantity) -> float:
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
