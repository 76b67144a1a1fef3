"""The package's own exceptions, and the messages that a result carries.

What equations, the system and Python say in English alone is worded here, so that it reads in any language; what is not
usual stays as they say it.
"""

from __future__ import annotations

import datetime as dt
import difflib
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, Literal, ParamSpec, TypeVar

from atleak import equations
from atleak.common.sentences import Sentence

_NAMES_SHOWN = 40  # of those that would have been valid


class AtleakError(Exception):
    """Everything atleak raises on purpose.

    Parameters
    ----------
    sentence
        what is wrong.
    """

    def __init__(self, sentence: Sentence) -> None:
        super().__init__(sentence)

    @property
    def sentence(self) -> Sentence:
        """Return what is wrong, to be said in the reader's language."""
        said = self.args[0]
        return said if isinstance(said, Sentence) else Sentence("{said}", said=str(said))


class DomainError(AtleakError, ValueError):
    """A number outside the domain in which an equation, or what is known of a fluid, holds."""

    @classmethod
    def of(cls, refused: equations.DomainError) -> DomainError:
        """Return what an equation refused, to be said in the reader's language."""
        limits = {name: _OF_EQUATIONS.get(str(limit), limit) for name, limit in refused.limits.items()}
        unit, expected = refused.unit, _OF_EQUATIONS[refused.expected].of(**limits)
        found = Sentence("{number:g}", number=refused.found)
        said = Sentence(
            "{name} must be {expected}, found {found}",
            name=_OF_EQUATIONS.get(refused.name, refused.name),
            expected=_with_unit(expected, unit) if refused.limited_by_numbers else expected,
            found=_with_unit(found, unit),
        )
        return cls(Sentence("{said} at index {place}", said=said, place=refused.index) if refused.index else said)


def _with_unit(number: Sentence, unit: str) -> Sentence:
    return Sentence("{number} {unit}", number=number, unit=unit) if unit else number


# What equations expect, and the quantities that a file or a person can state so that no equation holds; any other is
# named to programmers only.
_OF_EQUATIONS: Mapping[str, Sentence] = {
    str(words): words
    for words in (
        Sentence("positive"), Sentence("zero or positive"), Sentence("between {low:g} and {high:g}"),
        Sentence("above {low:g}"), Sentence("above the {other}"), Sentence("above 0 and below 1"),
        Sentence("above its working circle's, 2 a z/(Z − z)"), Sentence("above the pinion's"),
        Sentence("at least the spool's"), Sentence("at most the diameter"), Sentence("at most the free length"),
        Sentence("at most the number of units"), Sentence("at most the radial clearance"),
        Sentence("below its working circle's, 2 a Z/(Z − z)"), Sentence("different from the first"),
        Sentence("larger than the wire's"), Sentence("one at which ASTM D341 is finite"), Sentence("one or more"),
        Sentence("such that viscosity falls as temperature rises"),
        Sentence("area left for control pressure (A_1 - A_2W + A_3W)"), Sentence("centre distance"),
        Sentence("density"), Sentence("diameter"), Sentence("diameter of the cam ring"), Sentence("dynamic viscosity"),
        Sentence("eccentricity"), Sentence("free length"), Sentence("gear width"), Sentence("inner diameter"),
        Sentence("kinematic viscosity"), Sentence("length of a tip"), Sentence("limit of the pressure"),
        Sentence("mean coil diameter"), Sentence("number of active coils"), Sentence("number of lobes"),
        Sentence("number of sealing tips"), Sentence("number of teeth"), Sentence("number of the ring gear's teeth"),
        Sentence("number of vanes"), Sentence("outer diameter of the land"), Sentence("pump displacement"),
        Sentence("pump speed"), Sentence("radial clearance"), Sentence("rod diameter"), Sentence("root diameter"),
        Sentence("rotor width"), Sentence("second kinematic viscosity"), Sentence("second temperature"),
        Sentence("shear modulus"), Sentence("side clearance"), Sentence("sleeve diameter"),
        Sentence("slip coefficient"), Sentence("spool diameter"), Sentence("spring deflection"),
        Sentence("spring length"), Sentence("spring rate"), Sentence("temperature"), Sentence("tip clearance"),
        Sentence("tip diameter"), Sentence("tip diameter of the ring gear"), Sentence("tooth height"),
        Sentence("tooth module"), Sentence("vane width"), Sentence("volumetric efficiency"), Sentence("wire diameter"),
    )
}  # fmt: skip

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def translates_refusals(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """Decorate a function that computes with equations: what they refuse is an error of the package, like any other."""

    @wraps(function)
    def computed(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Answer:
        try:
            return function(*args, **kwargs)
        except equations.DomainError as refused:
            raise DomainError.of(refused) from refused

    return computed


KeySteps = tuple[str | int, ...]
"""Where in a file's tables a value stands: ``("components", 2, "lands", 0, "contact_length_mm")``."""


@dataclass(frozen=True)
class Place:
    """Where in the user's material something stands; any part may be unknown."""

    file: str | None = None  # its name
    sheet: str | None = None  # of a workbook
    row: int | None = None  # counted from 1, as a spreadsheet does
    column: str | None = None  # its letter or heading
    table: str | None = None  # of a TOML file
    key: str | None = None  # of a TOML file
    steps: KeySteps = field(default=(), compare=False)  # through the file's tables as data, list entries counted from 0

    @property
    def parts(self) -> dict[str, Any]:
        """Return what is known of the place, by the names of its parts."""
        return {name: value for name, value in vars(self).items() if value not in (None, ())}

    @property
    def sentence(self) -> Sentence:
        """Return the place in words; nothing where nothing of it is known."""
        parts = (
            self.file,
            Sentence("sheet {name!r}", name=self.sheet) if self.sheet else None,
            Sentence("row {number}", number=self.row) if self.row is not None else None,
            Sentence("column {name}", name=self.column) if self.column is not None else None,
            f"[{self.table}]" if self.table else None,
            Sentence("key {name!r}", name=self.key) if self.key else None,
        )
        return Sentence("{parts}", parts=tuple(part for part in parts if part))

    def __str__(self) -> str:
        return str(self.sentence)


class InputError(AtleakError):
    """Something a user gave cannot be used: says where, what stood there and what was expected.

    ``others`` are further faults of the same material, listed below the first, ``others_shown`` of them.
    """

    others_shown = 9

    def __init__(
        self,
        problem: Sentence,
        *,
        place: Place | None = None,
        value: object = None,
        expected: Sentence | None = None,
        nearest: str | None = None,
        others: Sequence[InputError] = (),
    ) -> None:
        self.problem, self.place, self.value = problem, place or Place(), value
        self.expected, self.nearest, self.others = expected, nearest, tuple(others)
        super().__init__(self.sentence)

    @property
    def sentence(self) -> Sentence:
        """Return where what stands, what was expected there, and the further faults, a line each."""
        said, where = self.problem, self.place.sentence
        if where:
            said = Sentence("{where}: {problem}", where=where, problem=said)
        if self.value is not None:
            stands = str(self.value) if isinstance(self.value, dt.date | dt.time) else self.value
            said = Sentence("{problem} (found {value!r})", problem=said, value=stands)
        if self.expected:
            said = Sentence("{problem}; expected {expected}", problem=said, expected=self.expected)
        if self.nearest:
            said = Sentence("{problem}; did you mean {nearest!r}?", problem=said, nearest=self.nearest)
        for other in self.others[: self.others_shown]:
            said = Sentence("{problem}\n  {other}", problem=said, other=other.sentence)
        if len(self.others) > self.others_shown:
            more = len(self.others) - self.others_shown
            said = Sentence("{problem}\n  … and {count} more", problem=said, count=more)
        return said

    def __str__(self) -> str:
        return str(self.sentence)

    def rename_file(self, renamed: Callable[[str | None], str | None]) -> None:
        """Name the file, of this fault and of the others, as the user knows it."""
        for fault in (*self.others, self):
            fault.place = replace(fault.place, file=renamed(fault.place.file))
            fault.args = (fault.sentence,)


class CatalogueError(InputError):
    """A controller, fluid, limits or instrument file that does not say what it must."""

    others_shown = 59  # a whole valve body described wrongly can be mended in one go
    refers_to: str | None = None  # of a reference to nothing: the list of tables or gears that has no such entry


class ReadingsError(InputError):
    """A measuring sheet that cannot be used."""

    role = ""  # component, plane or land: the word that was found may be the sheet's own; columns: which is what
    offer: Mapping[str, str] = {}  # what is said of the columns where the sheet can be read so


class OtherControllerError(ReadingsError):
    """A measuring sheet whose head names another controller than the one it is read for."""

    named = ""  # as it is written there


class RoadTestError(InputError):
    """A road-test log that cannot be used."""


class FormulaError(InputError):
    """A formula over a log's channels that cannot be read or computed; the problem names the character."""


class PressureTableError(InputError):
    """A table of gauge readings that cannot be used."""


class VacuumTableError(InputError):
    """A table of a vacuum test that cannot be used."""


class FlowTableError(InputError):
    """A table of flows that cannot be used."""


class OutputError(InputError):
    """A file that cannot be written, or that may not be written over."""


class BookError(InputError):
    """A job book that cannot be read or written, or that does not hold what was asked of it."""


class ChangedElsewhere(BookError):
    """A job that somebody else has saved since it was opened here; nothing was written over."""


class ErasedElsewhere(ChangedElsewhere):
    """A job whose customer was erased since it was opened here: what was opened must not come back."""


class FleetError(InputError):
    """A run over a fleet, or its results, that cannot be begun, gone on with or read."""


AnyInputError = TypeVar("AnyInputError", bound=InputError)


def unknown(
    problem: Sentence,
    value: object,
    known: Iterable[str],
    *,
    kind: type[AnyInputError] = InputError,  # type: ignore[assignment]
    place: Place | None = None,
    otherwise: Sentence | None = None,
) -> AnyInputError:
    """Make the error for a name that is none of the known ones; it lists them and names the nearest.

    Parameters
    ----------
    problem
        what is wrong, as a person reads it: ``Sentence("no such profile")``.
    value
        the name that was given; None where there is none.
    otherwise
        what else is accepted besides these names.

    Examples
    --------
    >>> print(unknown(Sentence("no such profile"), "papper", ["workshop", "paper"]))
    no such profile (found 'papper'); expected one of workshop, paper; did you mean 'paper'?
    """
    names = list(known)
    expected = one_of(names)
    if otherwise:
        expected = Sentence("{first}, or {second}", first=expected, second=otherwise) if expected else otherwise
    nearest = None if value is None else nearest_name(str(value), names)
    return kind(problem, place=place, value=value, expected=expected, nearest=nearest)


def one_of(known: Iterable[str]) -> Sentence | None:
    """Write the valid names as what is expected; None where there are none.

    >>> one_of(["paper", "workshop", "paper"])
    'one of paper, workshop'
    """
    names = tuple(dict.fromkeys(known))
    if len(names) > _NAMES_SHOWN:
        return Sentence("one of {names} …", names=names[:_NAMES_SHOWN])
    return Sentence("one of {names}", names=names) if names else None


def extra_installed(name: str) -> Sentence:
    """Return how the libraries of one of atleak's extras are installed, as what is expected.

    >>> extra_installed("mdf")
    'python -m pip install ".[mdf]" in the folder from which atleak was installed'
    """
    command = f'python -m pip install ".[{name}]"'
    return Sentence("{command} in the folder from which atleak was installed", command=command)


MessageLevel = Literal["info", "warning"]


@dataclass(frozen=True)
class Message:
    """What a result has to say besides its numbers: ``code`` for programs, ``text`` for people."""

    level: MessageLevel  # how much it matters
    code: str  # for programs
    text: Sentence  # for people
    place: Place | None = None  # what it speaks of in the user's material


def nearest_name(name: str, names: Iterable[str]) -> str | None:
    """The valid name closest to a mistyped one, or None.

    >>> nearest_name("Paper_", ["paper", "workshop"])
    'paper'
    """
    by_case = {known.casefold(): known for known in names}
    found = difflib.get_close_matches(name.casefold(), list(by_case), n=1, cutoff=0.5)
    return by_case[found[0]] if found else None


_LONGEST = 300  # characters of a parser's message worth showing
_KNOWN = (
    Sentence("Permission denied"), Sentence("Operation not permitted"), Sentence("No such file or directory"),
    Sentence("File exists"), Sentence("Is a directory"), Sentence("Not a directory"), Sentence("File name too long"),
    Sentence("No space left on device"), Sentence("Read-only file system"), Sentence("Input/output error"),
    Sentence("Device or resource busy"),
    # of text that is no UTF-8
    Sentence("invalid start byte"), Sentence("invalid continuation byte"), Sentence("unexpected end of data"),
    # of a TOML file
    Sentence("Invalid statement"), Sentence("Expected newline or end of document after a statement"),
    Sentence("Cannot overwrite a value"), Sentence("Expected ']' at the end of a table declaration"),
    Sentence("Expected ']]' at the end of an array declaration"),
    Sentence("Expected '=' after a key in a key/value pair"), Sentence("Invalid initial character for a key part"),
    Sentence("Unclosed array"), Sentence("Unclosed inline table"), Sentence("Unescaped '\\' in a string"),
    Sentence("Invalid hex value"), Sentence("Escaped character is not a Unicode scalar value"),
    Sentence("Unterminated string"), Sentence("Invalid date or datetime"), Sentence("Invalid value"),
    Sentence("maximum recursion depth exceeded"),
    # of a JSON file
    Sentence("Expecting value"), Sentence("Expecting property name enclosed in double quotes"),
    Sentence("Expecting ',' delimiter"), Sentence("Expecting ':' delimiter"), Sentence("Extra data"),
    Sentence("Unterminated string starting at"), Sentence("Invalid control character at"),
)  # fmt: skip
_BY_TEXT = {str(reason): reason for reason in _KNOWN}
_OF_ONE: Mapping[str, Callable[[str], Sentence]] = {  # of a TOML file too: what a single thing stands in
    r"Cannot declare (.+) twice": lambda key: Sentence("Cannot declare {key} twice", key=key),
    r"Cannot mutate immutable namespace (.+)": lambda key: Sentence("Cannot mutate immutable namespace {key}", key=key),
    r"Cannot redefine namespace (.+)": lambda key: Sentence("Cannot redefine namespace {key}", key=key),
    r"Duplicate inline table key (.+)": lambda key: Sentence("Duplicate inline table key {key}", key=key),
    r"Found invalid character (.+)": lambda sign: Sentence("Found invalid character {sign}", sign=sign),
    r"Illegal character (.+)": lambda sign: Sentence("Illegal character {sign}", sign=sign),
    r"Expected (\S+)": lambda sign: Sentence("Expected {sign}", sign=sign),
}
_PLACE = re.compile(r"(.+) \(at (?:line (\d+), column (\d+)|end of document)\)", re.DOTALL)


def reason_of(error: OSError) -> Sentence:
    """Return why: what the error carries, else what the system says, which may be in the system's language.

    >>> reason_of(PermissionError(13, "Permission denied"))
    'Permission denied'
    """
    said = error.strerror
    return said if isinstance(said, Sentence) else _known(str(said))


def text_reason(error: Exception) -> Sentence:
    """Return why a text is no TOML or JSON in UTF-8, as `tomllib`, `json` and `bytes.decode` say it.

    >>> text_reason(ValueError("Invalid value (at line 1, column 5)"))
    'Invalid value (at line 1, column 5)'
    """
    if isinstance(error, UnicodeDecodeError):
        return _undecoded(error)
    if isinstance(error, json.JSONDecodeError):
        return Sentence(
            "{reason}: line {line} column {column} (char {position})",
            reason=_known(error.msg),
            line=error.lineno,
            column=error.colno,
            position=error.pos,
        )
    text = str(error)
    at = _PLACE.fullmatch(text)
    if at is None or len(text) > _LONGEST:
        return _known(text[:_LONGEST])
    reason, line, column = _known(at[1]), at[2], at[3]
    if line is None:
        return Sentence("{reason} (at end of document)", reason=reason)
    return Sentence("{reason} (at line {line}, column {column})", reason=reason, line=line, column=column)


def _undecoded(error: UnicodeDecodeError) -> Sentence:
    first, last, reason = error.start, error.end - 1, _known(error.reason)
    if first < last:
        return Sentence(
            "'{encoding}' codec can't decode bytes in position {first}-{last}: {reason}",
            encoding=error.encoding,
            first=first,
            last=last,
            reason=reason,
        )
    return Sentence(
        "'{encoding}' codec can't decode byte 0x{byte:02x} in position {position}: {reason}",
        encoding=error.encoding,
        byte=error.object[first],
        position=first,
        reason=reason,
    )


def _known(text: str) -> Sentence:
    if text in _BY_TEXT:
        return _BY_TEXT[text]
    for pattern, said in _OF_ONE.items():
        if found := re.fullmatch(pattern, text):
            return said(found[1])
    return Sentence("{reason}", reason=text)
