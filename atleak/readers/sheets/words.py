"""What single cells say: numbers, parts, directions, names; and the vocabulary of headings."""

from __future__ import annotations

import datetime
import re
import unicodedata
from collections.abc import Iterable
from functools import cache, lru_cache
from typing import Literal

from atleak.catalogue.instruments import Part
from atleak.catalogue.written_numbers import decimal_number
from atleak.common.errors import Place, ReadingsError
from atleak.common.sentences import Sentence
from atleak.common.units import Unit, find_unit
from atleak.readers import dates as plain_words
from atleak.readers.cells.sheet import Cell
from atleak.readers.cells.sheet import text_of as text_of

_SPACES = re.compile(r"\s+")
_LETTERS = re.compile(r"[^\W\d_]+")
_NUMBER_AND_UNIT = re.compile(r"(.*\d[.,]?)\s*([^\d.,\s+\-]\D*)", re.DOTALL)
NO_NUMBER, A_DIAMETER = Sentence("not a number"), Sentence("a diameter such as 9.939")
_SINGLE_LETTERS = 2  # words up to this length keep their case: d is the spool, D the sleeve


@lru_cache(maxsize=8192)
def plain(text: str) -> str:
    """Return a text in lower case, without accents, with single spaces: for comparing words.

    >>> plain("Średnica\\n Tłoka")
    'srednica tloka'
    """
    if text.isascii():  # most words are, and this is quick
        return " ".join(text.lower().split())
    folded = unicodedata.normalize("NFKD", text).lower().replace("ł", "l").replace("ß", "ss")
    return _SPACES.sub(" ", "".join(sign for sign in folded if not unicodedata.combining(sign))).strip()


_LISTED = plain_words.vocabulary(__package__, "vocabulary.toml")


class Vocabulary:
    """Words of one meaning in all languages; some as the beginning of a word."""

    def __init__(self, words: Iterable[str]) -> None:
        listed = [plain(word) for word in words]
        self._words = frozenset(word for word in listed if not word.endswith("*"))
        self._stems = tuple(word[:-1] for word in listed if word.endswith("*"))

    def __contains__(self, word: str) -> bool:
        return word in self._words or (bool(self._stems) and word.startswith(self._stems))


@cache
def sheet_vocabulary(*meanings: str) -> Vocabulary:
    """Return the words for one or several meanings of ``vocabulary.toml``.

    >>> "solldurchmesser" in sheet_vocabulary("specification", "specification_title")
    True
    """
    return Vocabulary(word for meaning in meanings for word in _listed(meaning))


def is_word(word: str) -> bool:
    """Return whether measuring sheets use a word, in any meaning: it tells how a text file is encoded."""
    return plain(word) in sheet_vocabulary(*_LISTED)


_TOGETHER = {  # several meanings under one name
    "of_specification": ("specification", "specification_title"),
    "of_reading": ("reading", "actual"),
    "of_repeat": ("repeat", "reading"),
    "of_size": ("diameter", "coordinate"),
    "of_quantity": ("quantity", "clearance", "error", "spread"),
}


def _listed(meaning: str) -> list[str]:
    tables = (_LISTED[table_name] for table_name in _TOGETHER.get(meaning, (meaning,)))
    return [word for table in tables for words in table.values() for word in words]


class Words(tuple[str, ...]):
    """The words of a text, folded, that can be asked what they mean."""

    __slots__ = ()

    def of(self, *meanings: str) -> set[str]:
        """Return the words that have one of these meanings.

        >>> letters("Solldurchmesser in mm").of("specification", "specification_title")
        {'solldurchmesser'}
        """
        vocabulary = sheet_vocabulary(*meanings)
        return {word for word in self if word in vocabulary}

    def any(self, *meanings: str) -> bool:
        """Return whether one of the words has one of these meanings."""
        vocabulary = sheet_vocabulary(*meanings)
        return any(word in vocabulary for word in self)

    def only(self, *meanings: str) -> bool:
        """Return whether every word has one of these meanings; of no words they all have."""
        vocabulary = sheet_vocabulary(*meanings)
        return all(word in vocabulary for word in self)

    def but(self, *meanings: str) -> Words:
        """Return the words that have none of these meanings."""
        vocabulary = sheet_vocabulary(*meanings)
        return Words(word for word in self if word not in vocabulary)


@lru_cache(maxsize=8192)
def letters(text: str) -> Words:
    """Return the words of a text, folded, without its numbers and signs."""
    return Words(_LETTERS.findall(plain(text)))


@lru_cache(maxsize=4096)
def says_specification(text: str) -> bool:
    """Return whether a cell says, and says nothing else, that its row is what a diameter should be."""
    words = letters(text)
    return words.any("of_specification") and words.only("of_specification", "diameter", "reading")


_ABSENT = frozenset(("", *map(plain, _listed("absent"))))
_DASHES = re.compile(r"[-‐–—−_.…/\s]+")


def is_blank(cell: Cell) -> bool:
    """Return whether nothing was measured here: an empty cell, dashes, "n/a", "nicht gem."."""
    return cell is None or (isinstance(cell, str) and (not cell or _says_absent(cell)))


@lru_cache(maxsize=16384)
def _says_absent(text: str) -> bool:
    return plain(text) in _ABSENT or _DASHES.fullmatch(text) is not None


def number(cell: Cell) -> tuple[float, Unit | None]:
    """Return a cell's number and the unit behind it, if any; the error says, without place, what it holds instead.

    >>> number("12,034"), number("1 234,5")[0], number("1,234.5")[0]
    ((12.034, None), 1234.5, 1234.5)
    """
    if isinstance(cell, bool):
        raise ReadingsError(NO_NUMBER, value=cell, expected=A_DIAMETER)
    if isinstance(cell, int | float):
        return float(cell), None
    if isinstance(cell, datetime.date | datetime.time | datetime.timedelta):
        raise ReadingsError(
            Sentence("the spreadsheet program has turned this number into a date or time"),
            value=str(cell),
            expected=Sentence("a diameter such as 9.939: format the cell as number or text and type it again"),
        )
    text, unit = _undressed(str(cell)), None
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is not None and (unit := find_unit(match[2], "length")):
        text = match[1]
    value = decimal_number(text)
    if value is not None:
        return value, unit
    raise ReadingsError(NO_NUMBER, value=str(cell), expected=Sentence("a diameter such as 9.939 or 9,939"))


def diameter(cell: Cell) -> tuple[float, Unit | None]:
    """Return a cell's diameter and the unit behind it, as `number` does; one of zero or less is refused."""
    value, unit = number(without_remark(cell))
    if value <= 0.0:
        raise ReadingsError(Sentence("a diameter must be positive"), value=value, expected=A_DIAMETER)
    return value, unit


_DRESSED = re.compile(
    r"(?:[øØ⌀∅φΦ]\s*=?\s*)?(?P<number>.*?\d[.,]?)\s*(?:(?:±|\+\s?/?\s?[-−–])\s*\d[\d.,]*)?(?P<unit>\s*[^\d.,\s*†‡±?]*)\s*[*†‡?]*",
    re.DOTALL,
)


_IN_BRACKETS = re.compile(r"^\(\s*(\d+[.,]\d+)\s*\)(?=\D*$)")


def _undressed(text: str) -> str:
    """Return a number as written without the sign for a diameter, its uncertainty, and stars; its unit stays."""
    stripped = _IN_BRACKETS.sub(r"\1", text.strip())
    if stripped[:1].isdigit() and stripped[-1:].isdigit() and "±" not in stripped and "/" not in stripped:
        return stripped
    match = _DRESSED.fullmatch(stripped)
    return stripped if match is None else match["number"] + match["unit"]


_REMARKED = re.compile(r"([^\s\d]*\s*\d{1,2}[.,]\d{2,}(?:\s?(?:mm|µm|in|\")(?!\w))?)[\s,;:(*]+(\D*[^\W\d_]{4}\D*)")
_NO_REMARK = (
    *("of_specification", "of_quantity", "mean", "sum", "raw", "corrected", "earlier", "new", "state", "gauge"),
    *("counts_not", "changes_readings", "before_unit", "absent", "spread", "count", "person"),
)  # words that change what the number before them is


def without_remark(cell: Cell) -> Cell:
    """Return a number as it is written without words behind it that say nothing else of it.

    >>> without_remark("9,941 scored"), without_remark("9,941 mean"), without_remark("9.941 kg")
    ('9,941', '9,941 mean', '9.941 kg')
    """
    match = _REMARKED.fullmatch(cell.strip()) if isinstance(cell, str) and number_of(cell) is None else None
    if match is None or number_of(match[1]) is None or letters(match[2]).any(*_NO_REMARK):
        return cell
    return match[1]


def is_marked(cell: Cell) -> bool:
    """Return whether a star, a dagger, brackets or words stand at a cell's number, which may point to a note."""
    if not isinstance(cell, str) or number_of(text := without_remark(cell)) is None:
        return False
    return text != cell or cell.rstrip()[-1:] in {"*", "†", "‡", "?"} or _IN_BRACKETS.match(cell.strip()) is not None


_PARTS: tuple[Part, ...] = ("spool", "sleeve")
_PART_WORDS: dict[str, Part] = {
    word if len(word) <= _SINGLE_LETTERS else plain(word): part
    for part in _PARTS
    for word in _listed(part)
    if not word.endswith("*")
}
_PART_STEMS: dict[Part, Vocabulary] = {
    part: Vocabulary(word for word in _listed(part) if word.endswith("*")) for part in _PARTS
}
_SIDES: tuple[tuple[Part, str, re.Pattern[str]], ...] = (
    ("spool", "outer", re.compile(r"(?<![^\W\d_])(?:OD|O\.D\.?)(?![^\W\d_])")),
    ("sleeve", "inner", re.compile(r"(?<![^\W\d_])(?:ID|I\.D\.?)(?![^\W\d_])")),
)


_OF_SIDES = {"o", "i", "d", "od", "id"}  # of "OD", "I.D."


PART_SPELLINGS = tuple(word for word in _PART_WORDS if len(word) > _SINGLE_LETTERS)


@lru_cache(maxsize=4096)
def part_of(text: str) -> Part | None:
    """Return the part a cell names, or None.

    >>> part_of("Spool"), part_of("Bohrung"), part_of("opening (sleeve)"), part_of("D"), part_of("d")
    ('spool', 'sleeve', 'sleeve', 'sleeve', 'spool')
    """
    stripped = text.strip().rstrip(".:")
    if len(stripped) <= _SINGLE_LETTERS:
        return _PART_WORDS.get(stripped)
    folded = plain(stripped)
    named = _PART_WORDS.get(folded) or _PART_WORDS.get(re.sub(r"\s*[\(\[/].*$", "", folded))
    return named or next((part for part, stems in _PART_STEMS.items() if " " not in folded and folded in stems), None)


@lru_cache(maxsize=4096)
def side_of(text: str) -> Part | None:
    """Return whose diameter an outer or an inner one is: the spool has the outer one, its bore the inner one.

    >>> side_of("Outer diameter"), side_of("Bore ID"), side_of("Innen-Ø"), side_of("Valve id")
    ('spool', 'sleeve', 'sleeve', None)
    """
    sides = {part for part, meaning, sign in _SIDES if letters(text).any(meaning) or sign.search(text)}
    return sides.pop() if len(sides) == 1 else None


@lru_cache(maxsize=4096)
def part_said(text: str) -> Part | None:
    """Return the part that a cell names, by a word for it or as the one with an outer or inner diameter.

    >>> part_said("Spool diameter"), part_said("outer diameter"), part_said("ID"), part_said("outside the box")
    ('spool', 'spool', 'sleeve', None)
    """
    part, side = part_of(text), side_of(text)
    if part is not None or re.search(r"\d", text):
        return part
    others = [word for word in letters(text).but("diameter", "outer", "inner") if word not in _OF_SIDES]
    said = {part_of(word) for word in others} | ({side} if side else set())
    return said.pop() if len(said) == 1 else None


@lru_cache(maxsize=4096)
def part_in(text: str) -> Part | None:
    """Return the one part a title speaks of, or None."""
    words = letters(text).but("part_or_other")
    parts = {part for word in words if len(word) > 2 and (part := part_of(word)) is not None}
    return parts.pop() if len(parts) == 1 else None


_ANGLE = re.compile(
    r"([+\-]?\d+(?:[.,]\d+)?)(?:°|o|deg|degree|degrees|grad|st|stopni)?(?:[-/](\d+)(?:°|o|deg|grad|st)?)?"
)
_DIRECTIONS = {
    plain(word).replace(" ", ""): angle
    for meaning, angle in (("direction_0", 0.0), ("direction_90", 90.0))
    for word in _listed(meaning)
}


_CLOCK = re.compile(r"(?<=\d)\s*(?:o'?\s?clock|uhr|godz\.?|h)$")
_HOURS = {"12": 90.0, "6": 90.0, "3": 0.0, "9": 0.0}  # of one end of a diameter, on the clock


def direction_of(cell: Cell) -> float | None:
    """Return the angle [°] from 0 to below 180 that a cell names, or None: 270° is the same diameter as 90°.

    >>> direction_of("90°"), direction_of("y1-y2"), direction_of("II"), direction_of(270), direction_of("up")
    (90.0, 90.0, 90.0, 90.0, None)
    """
    if isinstance(cell, bool):
        return None
    text, hours = _CLOCK.subn("", plain(text_of(cell)))
    text = text.replace(" ", "").replace("–", "-").replace("÷", "-")
    if hours and text.isdigit():
        return _HOURS.get(text)
    if text in _DIRECTIONS:
        return _DIRECTIONS[text]
    # NFKD leaves ° as it is and turns º into o
    match = _ANGLE.fullmatch(text)
    if match is None or (match[2] and (float(match[2]) - float(match[1])) % 360.0 != 180.0):
        return None
    return float(match[1].replace(",", ".")) % 180.0


_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4", "v": "5"}


def repeat_of(cell: Cell) -> int | None:
    """Return the number of a repeat, or None."""
    text = plain(text_of(cell))
    match = re.fullmatch(r"[a-z#]*[ .#]*([0-9]{1,4})\.?", text)
    return int(match[1] if match else _ROMAN.get(text, "0")) or None


def stated_number(cell: Cell) -> tuple[float, Unit | None] | None:
    """Return a cell's number and the unit behind it; None where it holds no number."""
    try:
        return number(cell)
    except ReadingsError:
        return None


@lru_cache(maxsize=16384)
def number_of(text: str) -> float | None:
    """Return the number that a text is, or None."""
    stated = stated_number(text)
    return None if stated is None else stated[0]


def several_in(cell: Cell) -> tuple[str, ...]:
    """Return the readings that stand in one cell; none where there are not several, or other words.

    >>> several_in("13.998 / 13.997 / 13.999"), several_in("18.041 ± 0.002"), several_in("12/05/2026")
    (('13.998', '13.997', '13.999'), (), ())
    """
    parts = tuple(part.strip() for part in re.split(r"[/|;\n]", cell)) if isinstance(cell, str) else ()
    return parts if len(parts) > 1 and all(_IN_TEXT.fullmatch(part) for part in parts) else ()


_NOT_AMONG_DIGITS = r"(?<![\d.,:/\-])"
_IN_TEXT = re.compile(
    _NOT_AMONG_DIGITS + r"(\d{1,2}[.,]\d{3,4}|\d{1,2}[.,]\d{1,2}(?=\s?mm)|0?[.,]\d{3,5})(?![.,:/]?\d)"
)


@lru_cache(maxsize=16384)
def numbers_in(text: str) -> tuple[float, ...]:
    """Return the number that a text is, or the diameters that are mentioned in it."""
    whole = number_of(text)
    if whole is not None:
        return (whole,)
    return tuple(float(match[1].replace(",", ".")) for match in _IN_TEXT.finditer(text))


def plane_names(cell: Cell) -> list[str]:
    """Return the names by which a controller may know the plane in a cell, the literal one first.

    >>> plane_names("Plane II"), plane_names("P1")
    (['Plane II', 'II', '2'], ['P1', '1'])
    """
    text = text_of(cell)
    match = re.fullmatch(r"(?:measur\w+ )?([^\W\d_]+)\.?\s*(\S.*)", text, re.IGNORECASE)
    word = plain(match[1]) if match else ""
    named = word in sheet_vocabulary("plane", "land", "number") or (word == "l" and match is not None)
    short = (match[2] if match and named else text).strip("\"'“”„ .°º")
    names = [text, short]
    if short.lower() in _ROMAN:
        names.append(_ROMAN[short.lower()])
    if lettered := re.fullmatch(r"[^\W\d_]{1,2}[ .-]?(\d)", short):
        names.append(lettered[1])
    return list(dict.fromkeys(names))


def at(place: Place, error: ReadingsError) -> ReadingsError:
    """Return the error with its place."""
    error.place = place
    return error


Summary = Literal["mean", "sum", "largest", "smallest", "spread", "count"]

_KINDS: tuple[Summary, ...] = ("mean", "sum", "largest", "smallest", "spread", "count")
_SUMMARY_WORDS: dict[str, Summary] = {
    plain(word): kind
    for kind in _KINDS
    for word in (*_listed(kind), *(_listed("mean_in_cell") if kind == "mean" else ()))
}
_SUMMARY_SIGNS = {"ø", "⌀", "∅", "x̄", "x̅", "x̿", "x-bar", "x bar", "x quer", "σ", "∑"}


def summary_of(cell: Cell, *, key: bool = False) -> Summary | None:
    """Return whether a row with this label holds a mean or a sum of others, in place of a reading.

    ``key`` is for cells that should say a component, part, plane, direction or repeat and do not: there one such word
    is enough ("accumulator Average"). Elsewhere, in remarks, nothing else may be said.

    >>> summary_of("Mittelwert aus 3 Messungen"), summary_of("below average finish"), summary_of("Grand Total")
    ('mean', None, 'sum')
    """
    if not isinstance(cell, str):
        return None
    return _summary(cell.strip(), key)


@lru_cache(maxsize=4096)
def _summary(text: str, key: bool) -> Summary | None:
    sign = text.strip(" .:")
    if key and sign.lower() in _SUMMARY_SIGNS:
        return "spread" if sign == "σ" else "sum" if sign in {"Σ", "∑"} else "mean"
    words = letters(text)
    kinds = [_SUMMARY_WORDS[word] for word in words if word in _SUMMARY_WORDS]
    if not kinds and key and words and words[-1] == "ergebnis":  # as a German spreadsheet program ends a subtotal
        return "sum"
    if not kinds:
        return None
    others = [word for word in words.but("beside_summary") if word not in _SUMMARY_WORDS]
    return kinds[0] if key or not others else None


def says(cell: Cell, *meanings: str) -> bool:
    """Return whether a cell is nothing but a word of one of these meanings.

    >>> says("Nein", "no"), says(False, "no"), says(0.0, "no"), says("x", "yes"), says("", "yes")
    (True, True, True, True, False)
    """
    return plain(text_of(cell)).strip(" .!()") in sheet_vocabulary(*meanings)


@lru_cache(maxsize=4096)
def says_unworn(text: str) -> bool:
    """Return whether a cell says that its row was measured at an unworn end, and says nothing else.

    >>> says_unworn("unworn end"), says_unworn("at the new end of the bore"), says_unworn("looks unworn")
    (True, True, False)
    """
    words = letters(text)
    return words.any("unworn") and words.any("end") and words.only("unworn", "end", "beside_end", "spool", "sleeve")


_STATE_VALUE = re.compile(
    r"(?:19|20)\d\d|\d[\d ., ]*(?:km|mi|miles|h|hours|std|godz)\.?|\d{1,4}[./-]\d{1,2}[./-]\d{1,4}|"
    r"(?:jan|feb|mar|apr|may|jun|jul|aug|sep|oct|nov|dec|mai|okt|dez|marz|sty|lut|kwi|maj|cze|lip|sie|wrz|paz|lis|gru)"
    r"[a-z]*\.?(?: \d{2,4})?|before|after|old|new|worn|repaired|vorher|nachher|alt|neu|vor|nach|przed|po|stary|nowy"
)


def is_state(cell: Cell) -> bool:
    """Return whether a cell says a time, a mileage or a state."""
    return isinstance(cell, datetime.date) or _STATE_VALUE.fullmatch(plain(text_of(cell))) is not None


ORDINALS = {"st", "nd", "rd", "th"}


def is_repeat_title(text: str) -> bool:
    """Return whether a title over a block of rows numbers a repeat, and says nothing else."""
    others = letters(text).but("repeat", "reading", "number")
    return ORDINALS.issuperset(others) and bool(letters(text)) and re.search(r"(?<!\d)\d{1,2}(?!\d)", text) is not None


def is_page_title(text: str) -> bool:
    """Return whether a line only counts the pages."""
    return bool(letters(text)) and letters(text).only("page")


_MONTH = (
    r"(?:jan|feb|mar|apr|may|mai|maj|jun|jul|aug|sep|oct|okt|nov|dec|dez|sty|lut|kwi|cze|lip|sie|wrz|paz|lis|gru)"
    r"[a-z]*\.?"
)
_DATE = re.compile(rf"\d{{1,2}}[-. ]+{_MONTH}|{_MONTH}[-. ]+\d{{1,2}}|\d{{4}}-\d\d-\d\d(?:[t ]00:00(?::00)?)?")


def says_date(cell: Cell) -> bool:
    """Return whether a spreadsheet program may have made a date of "8-1" here."""
    if isinstance(cell, datetime.date):
        return True
    return isinstance(cell, str) and _DATE.fullmatch(plain(cell)) is not None
