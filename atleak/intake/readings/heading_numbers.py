"""What the words and numbers in the heading of a diameter say: land, plane, direction, repeat, coordinate, or else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache

from atleak.intake.readings.words import ORDINALS, Words, direction_of, part_of, plain, vocabulary

_EXPLAINED = (
    *("repeat", "reading", "actual", "diameter", "coordinate", "number", "direction", "outer", "inner", "dimension"),
    *("land", "plane"),
)  # what words of a heading may say of the place and the repeat of a diameter
_BESIDE_A_PART = {"of", "the", "der", "des", "du", "de", "la", "l", "le", "del", "at", "in", "an", "am"}
_ENDS = {"x1", "x2", "y1", "y2"}
_DIRECTED = {"x": 0.0, "dx": 0.0, "x-x": 0.0, "a-a": 0.0, "y": 90.0, "dy": 90.0, "y-y": 90.0, "b-b": 90.0}
_AXES = _ENDS | {"i", "ii", *_DIRECTED}
_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4"}
_SAY_NO_MORE = ORDINALS | _AXES | {*_ROMAN, *_BESIDE_A_PART, "od", "id", "o", "clock", "uhr"}
_MOST_REPEATS = 30
_PLAIN_ANGLES = {"0", "90"}  # behind the word for the diameter also without "°"


_TOKEN = re.compile(
    r"(?<![^\W_])(?:x-x|y-y|a-a|b-b)(?![^\W_])|(?:12-6|6-12|3-9|9-3)(?=\s*(?:o'?\s?clock|uhr|godz|h\b))"
    r"|\d+(?:°|deg\b)|[ø⌀φ#]|[^\W\d_øφ]+\d*|\d+"
)
_COMPOUND = re.compile(r"(\w{4,}?)(durchmesser|durchm|mass)")


@lru_cache(maxsize=4096)
def tokens_of(text: str) -> Words:
    """Return the words and numbers of a heading without its unit; of a compound that names a part its two words.

    >>> tokens_of("Hülsendurchmesser 2"), tokens_of("Solldurchmesser"), tokens_of("Ø A-A")
    (('hulsen', 'durchmesser', '2'), ('solldurchmesser',), ('ø', 'a-a'))
    """
    return Words(word for token in _TOKEN.findall(plain(text).replace("_", " ")) for word in _halves(token))


def _halves(word: str) -> tuple[str, ...]:
    match = _COMPOUND.fullmatch(word)
    if match is None:
        return (word,)
    first = match[1]
    for known in (first, first.removesuffix("s"), first.removesuffix("en"), first.removesuffix("n")):
        if part_of(known) is not None or known in {"aussen", "innen"}:
            return known, match[2]
    return (word,)


def spot_of_heading(tokens: Sequence[str]) -> tuple[dict[str, str], Words]:
    """Return where a heading says that its diameters were taken: land, plane, direction by name; and its other words.

    >>> spot_of_heading(["spool", "land", "2"]), spot_of_heading(["2", "ebene", "ø"])
    (({'land': '2'}, ('spool',)), ({'plane': '2'}, ('ø',)))
    """
    words = [token for token in tokens if token not in ORDINALS]
    said: dict[str, str] = {}
    others: list[str] = []
    at = 0
    while at < len(words):
        glued = re.fullmatch(r"([^\W\d]+)(\d{1,2})", words[at])
        kind = _kind(glued[1] if glued else words[at])
        step = 2 if at + 1 < len(words) and words[at + 1] in vocabulary("number") else 1
        name = glued[2] if glued else words[at + step] if at + step < len(words) else ""
        if kind is not None and kind not in said and _names_spot(name, kind):
            said[kind] = _ROMAN.get(name, name)
            at += 1 if glued else step + 1
        elif kind in ("land", "plane") and kind not in said and others and others[-1].isdigit():
            said[kind] = others.pop()
            at += 1
        else:
            others.append(words[at])
            at += 1
    return said, Words(others)


def _kind(word: str) -> str | None:
    if word == "l":
        return "land"
    return next((kind for kind in ("land", "plane", "direction") if word in vocabulary(kind)), None)


def _names_spot(name: str, kind: str) -> bool:
    if kind == "direction":
        return direction_of(name) is not None
    return bool(re.fullmatch(r"\d{1,2}|[a-h]", name)) or name in _ROMAN


def is_explained(tokens: Iterable[str]) -> bool:
    """Return whether words say only of which part and place a diameter is, and which repeat."""
    return all(
        token in vocabulary(*_EXPLAINED)
        or token in _SAY_NO_MORE
        or token.isdigit()
        or is_angle(token)
        or part_of(token) is not None
        or direction_of(token) is not None
        for token in tokens
    )


def numbers_of_heading(role: str, tokens: Sequence[str]) -> tuple[int | None, float | None, int | None]:
    """Return coordinate 1 or 2, direction [°] and repeat from the words of a value's heading.

    A number is a repeat behind a word for one or beside the word for the diameter. In front of a unit, in a date, or
    behind any other word it says something else: a mileage, a temperature, a vehicle.

    >>> numbers_of_heading("diameter", ["diameter", "2"]), numbers_of_heading("diameter", ["diameter", "50", "km"])
    ((None, None, 2), (None, None, None))
    """
    repeat, beside = _counted(tokens)
    coordinate = None
    if role == "coordinate":
        ends = {token[1] for token in tokens if token in _ENDS}
        coordinate = int(ends.pop()) if len(ends) == 1 else beside.pop(0) if beside else None
    return coordinate, _direction(role, tokens), beside[0] if repeat is None and beside else repeat


def _direction(role: str, tokens: Sequence[str]) -> float | None:
    around = [each for each in _around(tokens) if each[2] not in vocabulary("before_unit")]
    angles = [token for _, token, _ in around if is_angle(token)]
    angles += [
        token
        for before, token, _ in around
        if token in _PLAIN_ANGLES and (before in vocabulary("of_size") or part_of(before))
    ]
    angles += [token for token in tokens if "-" in token or (token.isalpha() and len(token) > 3)]
    said = [angle for each in angles if (angle := direction_of(each)) is not None]
    if role == "diameter":
        said += [_DIRECTED[token] for token in tokens if token in _DIRECTED]
    axes = {token[0] for token in tokens if token in _ENDS}
    said += [0.0 if axes == {"x"} else 90.0] if len(axes) == 1 else []
    return next(iter(said), None)


def _counted(tokens: Sequence[str]) -> tuple[int | None, list[int]]:
    """Return the number behind a word for a repeat, and those beside a word for the diameter or a part."""
    repeat = None
    beside: list[int] = []
    for before, token, after in _numbered(tokens):
        glued = re.fullmatch(r"([^\W\d]+)(\d+)", token)
        word, number = (glued[1], int(glued[2])) if glued else (before, int(token))
        another = after in vocabulary("before_unit") or after[:1].isdigit() or before.isdigit()
        if another or not 0 < number <= _MOST_REPEATS:
            continue
        if word in vocabulary("repeat", "of_reading") or word in {"#", "r"}:
            repeat = number if repeat is None else repeat
        elif word in vocabulary("of_size") or _may_be_numbered(word, after):
            beside.append(number)
    return repeat, beside


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
            and not (word in vocabulary(*_EXPLAINED) or word in ORDINALS or word in _AXES or word in _ROMAN)
            and part_of(word) is None
        )
    )


def is_angle(word: str) -> bool:
    return re.fullmatch(r"\d+(?:°|deg)", word) is not None


def _around(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield every word with those before and behind it, "" where there is none."""
    return zip(("", *tokens), tokens, (*tokens[1:], ""), strict=False)


def _numbered(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield each number with the word before it, past "no.", and the word behind it, past "st" and "nd"."""
    words = [token for token in tokens if (token not in vocabulary("number") or token == "#") and token not in ORDINALS]
    words = [
        _ROMAN[token] if token in _ROMAN and before in vocabulary("repeat", "of_reading") else token
        for before, token, _ in _around(words)
    ]
    for before, token, after in _around(words):
        if token.isdigit() or (re.fullmatch(r"[^\W\d]+\d+", token) and token not in _AXES):
            yield before, token, after


def _may_be_numbered(word: str, after: str) -> bool:
    """Return whether a part, a direction, or nothing stands before the word for the diameter: "1. diameter"."""
    if word == "":
        return after in vocabulary("diameter", "repeat", "of_reading") or part_of(after) is not None
    return (part_of(word) is not None and word not in vocabulary("part_or_other")) or word in _AXES or is_angle(word)
