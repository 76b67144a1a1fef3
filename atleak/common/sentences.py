"""Sentences of the program that can be read in another language: each keeps how it is worded and what fills it in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from gettext import NullTranslations
from typing import Any


class Name(str):
    """Words of a catalogue's file, of which the reader's language may have its own: a valve's name, a circuit's."""

    __slots__ = ()


class Option(str):
    """An option of the command line with its value, in a sentence; where there is none, a page names its own field.

    >>> Option("map", "header=3"), Option("map", "header=3").name
    ('--map header=3', 'map')
    """

    __slots__ = ("name", "value")
    name: str
    value: str  # "" where a page needs none: what it would say is filled in already

    def __new__(cls, name: str, value: str = "", text: str = "") -> Option:
        """Write the option as it is typed, or as ``text`` has it."""
        said = super().__new__(cls, text or f"--{name} {value}".rstrip())
        said.name, said.value = name, value
        return said


class Sentence(str):
    """A sentence for people, or a part of one: English as it stands, and able to be said in another language.

    It is a text like any other. `template` is how the code words it, with ``{places}`` as of `str.format`; `values`
    fill them in. `atleak.common.wording.Wording.sentence` says it in the reader's language and units.

    A value is best given as what it is: a number, a further `Sentence`, a `Name`, an operating point, or a
    `atleak.common.units.Quantity` where the reader's units apply (``{clearance} {clearance.unit}``). Of a tuple
    each is written, with commas between. Without values the template stands as it is, braces too.

    Parameters
    ----------
    template
        a literal of the code; the languages' catalogues have their own wording of exactly this text.
    values
        what stands at its places.

    Examples
    --------
    >>> said = Sentence("{count} readings of {planes}", count=3, planes=("I", "II"))
    >>> said, said.template
    ('3 readings of I, II', '{count} readings of {planes}')
    """

    template: str
    values: Mapping[str, Any]
    several: str = ""  # the template where ``{count}`` is another number than one

    def __new__(cls, template: str, /, **values: Any) -> Sentence:
        """Write the sentence in English."""
        said = super().__new__(cls, filled(template, values))
        said.template, said.values = str(template), values
        return said

    def of(self, **values: Any) -> Sentence:
        """Return the same wording filled in with values: one of a table of sentences.

        >>> Sentence("{count} rows of {what}").of(count=2, what="means")
        '2 rows of means'
        """
        return type(self)(self.template, **values)

    def with_options(self, said: Callable[[Option], str]) -> Sentence:
        """Return the sentence with its options said otherwise.

        >>> Sentence("or {option}", option=Option("map", "header=3")).with_options(lambda option: option.value)
        'or header=3'
        """
        own = {name: said(each) for name, each in self.values.items() if isinstance(each, Option)}
        parts = {name: each for name, each in self.values.items() if isinstance(each, Sentence)}
        own |= {name: new for name, each in parts.items() if (new := each.with_options(said)) is not each}
        values = {**self.values, **own}
        if not own:
            return self
        one = not self.several or values["count"] == 1
        made = Sentence.__new__(type(self), self.template if one else self.several, **values)
        made.template, made.several = self.template, self.several
        return made

    def translated(self, catalogue: NullTranslations) -> str:
        """Return the template in the language of a catalogue, in the plural form of ``count`` if it has several."""
        if self.several:
            return catalogue.ngettext(self.template, self.several, self.values["count"])
        return catalogue.gettext(self.template) if self.template else ""


def counted(count: int, one: str, several: str, /, **values: Any) -> Sentence:
    """Write one wording or the other, by how many there are; ``{count}`` says it. A language may have further forms.

    >>> counted(2, "{count} row of {what}", "{count} rows of {what}", what="means")
    '2 rows of means'
    """
    said = Sentence.__new__(Sentence, one if count == 1 else several, count=count, **values)
    said.template, said.several = one, several
    return said


def in_a_row(parts: Iterable[Any]) -> Sentence:
    """Write parts with semicolons between: sentences, names, operating points; at least one.

    >>> in_a_row(["D as gear 1", "R as gear -1"])
    'D as gear 1; R as gear -1'
    """
    return reduce(lambda first, second: Sentence("{first}; {second}", first=first, second=second), map(_part, parts))


def all_of(parts: Iterable[Any]) -> Sentence:
    """Write parts with "and" between; at least one.

    >>> all_of(["spool", "sleeve"])
    'spool and sleeve'
    """
    return reduce(lambda first, second: Sentence("{first} and {second}", first=first, second=second), map(_part, parts))


def any_of(parts: Iterable[Any]) -> Sentence:
    """Write parts with "or" between; at least one.

    >>> any_of(["mm", "inch"])
    'mm or inch'
    """
    return reduce(lambda first, second: Sentence("{first} or {second}", first=first, second=second), map(_part, parts))


def _part(part: Any) -> Sentence:
    return part if isinstance(part, Sentence) else Sentence("{part}", part=part)


def some(names: Sequence[str], most: int) -> Sentence:
    """Write names with commas between, and of more than so many how many others there are.

    >>> some(["25/1", "8/2", "8/3"], 2)
    '25/1, 8/2 and 1 more'
    """
    if len(names) > most:
        return Sentence("{names} and {count} more", names=tuple(names[:most]), count=len(names) - most)
    return Sentence("{names}", names=tuple(names))


class Listed:
    """Several values, written with commas between; ``{values!r}`` quotes them as Python does."""

    __slots__ = ("values",)

    def __init__(self, values: Sequence[Any]) -> None:
        self.values = values

    def __repr__(self) -> str:
        return repr(self.values)

    def __str__(self) -> str:
        return format(self, "")

    def __format__(self, specification: str) -> str:
        return ", ".join(format(each, specification) for each in self.values)


def filled(template: str, values: Mapping[str, Any]) -> str:
    """Write a template with its values; without values it stands as it is."""
    if not values:
        return str(template)
    listed = {name: Listed(value) if type(value) in (tuple, list) else value for name, value in values.items()}
    return str(template).format_map(listed)
