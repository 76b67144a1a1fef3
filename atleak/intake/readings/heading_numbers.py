"""What the numbers in the heading of a diameter say: a repeat, a coordinate, an angle, or something else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from atleak.intake.readings.words import UNITS_BEHIND, direction_of, part_of, vocabulary

_COUNTED = vocabulary("repeat", "reading", "actual")
_SIZE = vocabulary("diameter", "coordinate")
_DIAMETER = vocabulary("diameter")
_NUMBER = vocabulary("number")
_PART_OR_OTHER = vocabulary("part_or_other")
_EXPLAINED = vocabulary("repeat", "reading", "actual", "diameter", "coordinate", "number")
_ORDINAL = {"st", "nd", "rd", "th"}
_ENDS = {"x1", "x2", "y1", "y2"}
_AXES = _ENDS | {"x", "y", "i", "ii", "dx", "dy"}
_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4"}
_MOST_REPEATS = 30
_PLAIN_ANGLES = {"0", "90"}  # behind the word for the diameter also without "°"


def numbers_of_heading(role: str, tokens: Sequence[str]) -> tuple[int | None, float | None, int | None]:
    """Return coordinate 1 or 2, direction [°] and repeat from the words of a value's heading.

    A number is a repeat behind a word for one or beside the word for the diameter. In front of a unit, in a date, or
    behind any other word it says something else: a mileage, a temperature, a vehicle.

    >>> numbers_of_heading("diameter", ["diameter", "2"]), numbers_of_heading("diameter", ["diameter", "50", "km"])
    ((None, None, 2), (None, None, None))
    """
    angles = [token for token, after in _followed(tokens) if is_angle(token) and after not in UNITS_BEHIND]
    angles += [
        token
        for before, (token, after) in zip(("", *tokens), _followed(tokens), strict=False)
        if token in _PLAIN_ANGLES and before in _SIZE and after not in UNITS_BEHIND
    ]
    direction = next(map(direction_of, angles), None)
    axes = {token for token in tokens if token in _ENDS}
    letters = {axis[0] for axis in axes}
    if len(letters) == 1 and direction is None:
        direction = 0.0 if letters == {"x"} else 90.0
    repeat = coordinate = None
    beside: list[int] = []
    for before, token, after in _numbered(tokens):
        glued = re.fullmatch(r"([^\W\d]+)(\d+)", token)
        word, number = (glued[1], int(glued[2])) if glued else (before, int(token))
        if after in UNITS_BEHIND or after[:1].isdigit() or before.isdigit() or not 0 < number <= _MOST_REPEATS:
            continue
        if word in _COUNTED or word in {"#", "r"}:
            repeat = number if repeat is None else repeat
        elif word in _SIZE or _may_be_numbered(word, after):
            beside.append(number)
    if role == "coordinate":
        ends = {axis[1] for axis in axes}
        if len(ends) == 1:
            coordinate = int(ends.pop())
        elif beside:
            coordinate = beside.pop(0)
    if repeat is None and beside:
        repeat = beside[0]
    return coordinate, direction, repeat


def besides_numbers(words: Iterable[str]) -> frozenset[str]:
    """Return the words of a value's heading that say neither what it is nor of which part, and numbers of no repeat.

    >>> besides_numbers({"diameter", "1", "before", "spool"}), besides_numbers({"measurement", "2024"})
    (frozenset({'before'}), frozenset({'2024'}))
    """
    return frozenset(
        word
        for word in words
        if (word.isdigit() and int(word) > _MOST_REPEATS)
        or (
            word.isalpha()
            and len(word) > 1
            and not (word in _EXPLAINED or word in _ORDINAL or word in _AXES or word in _ROMAN)
            and part_of(word) is None
        )
    )


def is_angle(word: str) -> bool:
    return re.fullmatch(r"\d+(?:°|deg)", word) is not None


def _followed(tokens: Sequence[str]) -> Iterator[tuple[str, str]]:
    return zip(tokens, (*tokens[1:], ""), strict=True)


def _numbered(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield each number with the word before it, past "no.", and the word behind it, past "st" and "nd"."""
    words = [token for token in tokens if (token not in _NUMBER or token == "#") and token not in _ORDINAL]
    words = [
        _ROMAN[token] if token in _ROMAN and before in _COUNTED else token
        for before, token in zip(("", *words), words, strict=False)
    ]
    for before, (token, after) in zip(("", *words), _followed(words), strict=False):
        if token.isdigit() or (re.fullmatch(r"[^\W\d]+\d+", token) and token not in _AXES):
            yield before, token, after


def _may_be_numbered(word: str, after: str) -> bool:
    """Return whether a part, a direction, or nothing stands before the word for the diameter: "1. diameter"."""
    if word == "":
        return after in _DIAMETER or after in _COUNTED or part_of(after) is not None
    return (part_of(word) is not None and word not in _PART_OR_OTHER) or word in _AXES or is_angle(word)
