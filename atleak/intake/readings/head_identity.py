"""Whose unit the sheet is of, and who measured it with what, as its head says it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from atleak.errors import Message
from atleak.intake.readings.head_labels import Stated, means, stated_values
from atleak.intake.readings.words import letters, plain, text_of
from atleak.intake.sheets.sheet import Sheet
from atleak.readings import SheetIdentity
from atleak.sentence import Sentence, all_of
from atleak.workshop_units import MILE
from atleak.written_numbers import MILEAGE, WrittenNumber, read_number

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
        taken = {(each.sheet.name, each.row, each.column) for each in every}
        found = [
            each
            for each in stated_values(heads, words, beside, None)
            if (each.sheet.name, each.row, each.column) not in taken and len(text_of(each.value)) <= _LONGEST
        ]
        every += found
        told = {plain(text_of(each.value)): each for each in found}
        if len(told) > 1:
            messages.append(several([(text_of(one.value), one) for one in told.values()], what))
        for each in told.values() if len(told) == 1 else ():
            value = _mileage(each, messages) if name == "mileage" else text_of(each.value)
            if value not in ("", None):
                values[name] = value
    instruments = [str(values.pop(name)) for name in _INSTRUMENTS if name in values]
    identity = SheetIdentity(**values, instruments=tuple(dict.fromkeys(instruments)))  # type: ignore[arg-type]
    return identity, every, messages


def several(stated: Sequence[tuple[str, Stated]], what: Sentence) -> Message:
    """Tell that the heads state one thing differently: each as it reads, and where it stands."""
    named = all_of(Sentence("{value!r} ({place})", value=value, place=each.place.sentence) for value, each in stated)
    text = Sentence(
        "the head states the {what} more than once, differently: {named}. None is taken", what=what, named=named
    )
    return Message("warning", "head_unclear", text, stated[0][1].place)


def _mileage(stated: Stated, messages: list[Message]) -> float | None:
    """Return a mileage [km], None where it cannot be read; a message then says so."""
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
