"""Read a formula over channels: numbers, names, + − × ÷, parentheses and a few functions. Nothing of it is executed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from atleak.common.errors import FormulaError, nearest_name, one_of
from atleak.common.sentences import Sentence
from atleak.common.units import Unit, find_unit, unit_names

_LONGEST = 300  # characters of a formula
DEEPEST = 40  # parentheses, signs and functions within each other
FUNCTIONS = {"filtered": 2, "mean": 2, "derivative": 1}  # number of their arguments
_KINDS = ("pressure", "rotational_speed", "speed", "temperature", "time", "ratio")  # whose units a number may bear
_SIGNS = {"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "÷": "/", "∕": "/"}
_TOKEN = re.compile(r"(?P<number>\d+(?:[.,]\d+)?|[.]\d+)|(?P<name>[^\W\d]\w*)|(?P<sign>[-−–+*×·⋅/÷∕();,])")
_WHAT = Sentence("a channel, a number, a function or '('")
_OPERATORS = Sentence("+, −, ×, ÷ or ')'")


@dataclass(frozen=True)
class NumberNode:
    """A number as typed; with a unit it is of that unit's kind."""

    at: int
    value: float
    unit: Unit | None = None
    kind: str | None = None


@dataclass(frozen=True)
class NameNode:
    """The name of a channel, or of a formula above."""

    at: int
    name: str


@dataclass(frozen=True)
class Negative:
    """What stands behind a minus sign."""

    at: int
    operand: Node


@dataclass(frozen=True)
class OperationNode:
    """Two operands and the sign between them: ``+``, ``-``, ``*`` or ``/``."""

    at: int
    sign: str
    left: Node
    right: Node


@dataclass(frozen=True)
class Call:
    """A function with its arguments."""

    at: int
    function: str
    arguments: tuple[Node, ...]


Node = NumberNode | NameNode | Negative | OperationNode | Call


@dataclass(frozen=True)
class _Token:
    kind: str  # number, unit, name, sign, end
    text: str
    at: int  # place of the first character, from 1 on


def fault(at: int, problem: Sentence, expected: Sentence | None = None, nearest: str | None = None) -> FormulaError:
    """Make the error for a formula, naming the character."""
    text = Sentence("at character {place}: {problem}", place=at, problem=problem)
    return FormulaError(text, expected=expected, nearest=nearest)


def parse(text: str) -> Node:
    """Read a formula.

    A decimal sign is a comma or a point with digits on both sides; a comma or a semicolon with anything else beside it
    parts the arguments of a function. A number may bear a unit: ``p_g − 100 kPa``.

    Raises
    ------
    FormulaError
        naming the character, what stands there, and what was expected.

    Examples
    --------
    >>> parse("p_g − 1,5 bar").right.value
    1.5
    """
    if len(text) > _LONGEST:
        problem = Sentence("the formula is too long: it has {count} characters", count=len(text))
        raise fault(_LONGEST + 1, problem, Sentence("at most {count}", count=_LONGEST))
    reader = _Reader(_tokens(text))
    tree = reader.sum()
    if reader.now.kind != "end":
        raise fault(reader.now.at, _astray(reader.now.text), Sentence("+, −, ×, ÷ or the end of the formula"))
    return tree


def _tokens(text: str) -> list[_Token]:
    tokens: list[_Token] = []
    place = 0
    while place < len(text):
        if text[place].isspace():
            place += 1
            continue
        if tokens and tokens[-1].kind == "number" and (unit := _unit_at(text, place)):
            tokens.append(_Token("unit", unit, place + 1))
            place += len(unit)
            continue
        match = _TOKEN.match(text, place)
        if match is None:
            raise fault(place + 1, Sentence("{found!r} means nothing in a formula", found=text[place]), _WHAT)
        token = match[0]
        tokens.append(_Token(str(match.lastgroup), _SIGNS.get(token, token), place + 1))
        place = match.end()
    return [*tokens, _Token("end", "", len(text) + 1)]


def _unit_at(text: str, place: int) -> str | None:
    """Return the longest name of a unit that stands here, as a word of its own."""
    names = (name for kind in _KINDS for name in unit_names(kind) if not name[0].isdigit())
    for name in sorted(names, key=len, reverse=True):
        end = place + len(name)
        if text[place:end].casefold() == name.casefold() and not (end < len(text) and _goes_on(text[end])):
            return text[place:end]
    return None


def _goes_on(letter: str) -> bool:
    return letter.isalnum() or letter == "_"


class _Reader:
    """Reads tokens from left to right; every method reads one kind of part."""

    def __init__(self, tokens: Sequence[_Token]) -> None:
        self.tokens, self.place, self.depth = tokens, 0, 0

    @property
    def now(self) -> _Token:
        return self.tokens[self.place]

    def take(self) -> _Token:
        token = self.now
        self.place += 1
        return token

    def sum(self) -> Node:
        left = self.product()
        while self.now.text in ("+", "-"):
            sign = self.take()
            left = OperationNode(sign.at, sign.text, left, self.product())
        return left

    def product(self) -> Node:
        left = self.signed()
        while self.now.text in ("*", "/"):
            sign = self.take()
            left = OperationNode(sign.at, sign.text, left, self.signed())
        return left

    def signed(self) -> Node:
        self.depth += 1
        if self.depth > DEEPEST:
            problem = Sentence("too many parentheses and signs within each other")
            raise fault(self.now.at, problem, Sentence("at most {count}", count=DEEPEST))
        if self.now.text in ("+", "-"):
            sign = self.take()
            node = self.signed()
            node = Negative(sign.at, node) if sign.text == "-" else node
        else:
            node = self.part()
        self.depth -= 1
        return node

    def part(self) -> Node:
        token = self.take()
        if token.kind == "number":
            return self._number(token)
        if token.kind == "name":
            return self._call(token) if self.now.text == "(" else NameNode(token.at, token.text)
        if token.text == "(":
            node = self.sum()
            self._close(token, _OPERATORS)
            return node
        where = Sentence("the formula ends here") if token.kind == "end" else _astray(token.text)
        raise fault(token.at, where, _WHAT)

    def _number(self, token: _Token) -> NumberNode:
        value = float(token.text.replace(",", "."))
        if self.now.kind != "unit":
            return NumberNode(token.at, value)
        name = self.take().text
        kind = next(kind for kind in _KINDS if find_unit(name, kind))
        return NumberNode(token.at, value, find_unit(name, kind), kind)

    def _call(self, name: _Token) -> Call:
        function = name.text.casefold()
        if function not in FUNCTIONS:
            nearest = nearest_name(name.text, FUNCTIONS)
            problem = Sentence("there is no function {name!r}", name=name.text)
            raise fault(name.at, problem, one_of(FUNCTIONS), nearest)
        opened, wanted = self.take(), FUNCTIONS[function]
        arguments = [self.sum()]
        while self.now.text in (",", ";"):
            self.take()
            arguments.append(self.sum())
        self._close(opened, _OPERATORS if len(arguments) >= wanted else Sentence("',' and a time in seconds"))
        if len(arguments) != wanted:
            shape = Sentence("{function}(channel, seconds)", function=function)
            if wanted == 1:
                shape = Sentence("{function}(channel)", function=function)
            problem = Sentence("{function} has {count} argument(s)", function=function, count=len(arguments))
            raise fault(name.at, problem, shape)
        return Call(name.at, function, tuple(arguments))

    def _close(self, opened: _Token, expected: Sentence) -> None:
        if self.now.text != ")":
            ends = Sentence("the formula ends") if self.now.kind == "end" else _astray(self.now.text)
            problem = Sentence(
                "{problem}, and the '(' at character {place} is still open", problem=ends, place=opened.at
            )
            raise fault(self.now.at, problem, expected)
        self.take()


def _astray(found: str) -> Sentence:
    return Sentence("{found!r} does not belong here", found=found)
