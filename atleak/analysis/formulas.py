"""Compute further channels of a road test from those it has, by formulas that people type: ``p_g − p_k``.

`parse` reads a formula into a tree, and nothing of it is executed; `evaluate` computes the tree over a road test:
numbers with their kind of quantity, each at the stamps of its channels.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from atleak.common.errors import FormulaError, nearest_name, one_of
from atleak.common.sentences import Sentence
from atleak.common.units import UNIT_KINDS, Unit, find_unit, unit_names
from atleak.engine.extremes import clock_at, running_median
from atleak.measurements.road_test import QUANTITIES, RoadTest, Segment, hold

_LONGEST = 300  # characters of a formula
DEEPEST = 40  # parentheses, signs and functions within each other
FUNCTIONS = {"filtered": 2, "mean": 2, "derivative": 1}  # number of their arguments
_KINDS = ("pressure", "rotational_speed", "speed", "temperature", "time", "ratio")  # whose units a number may bear
_SIGNS = {"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "÷": "/", "∕": "/"}
_TOKEN = re.compile(r"(?P<number>\d+(?:[.,]\d+)?|[.]\d+)|(?P<name>[^\W\d]\w*)|(?P<sign>[-−–+*×·⋅/÷∕();,])")
_WHAT = Sentence("a channel, a number, a function or '('")
_OPERATORS = Sentence("+, −, ×, ÷ or ')'")
Dimension = tuple[tuple[str, int], ...]  # kinds of quantity with their powers, by name; of a plain number none
CHANNEL_NAMES: Mapping[str, str] = MappingProxyType({
    "p_g": "main_pressure", "p_k": "converter_pressure", "p_commanded": "commanded_pressure", "n": "engine_speed",
    "n_turbine": "turbine_speed", "n_output": "output_speed", "v": "vehicle_speed", "T": "atf_temperature",
})  # fmt: skip
"""Short names of channels; a channel's own name serves as well."""
_KIND_NAMES: Mapping[str, Sentence] = MappingProxyType(
    {**UNIT_KINDS, "temperature_difference": Sentence("temperature difference")}
)
_OPERATIONS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}
_ABSOLUTE: Dimension = (("temperature", 1),)
_DIFFERENCE: Dimension = (("temperature_difference", 1),)
_TIME: Dimension = (("time", 1),)
_PLAIN: Dimension = ()
_LONGEST_WINDOW = 3600.0  # [s] that a filter may look at


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


@dataclass(frozen=True, eq=False)
class FormulaChannel:
    """What a formula gives over a log.

    Parameters
    ----------
    name, formula
        as they were typed.
    time
        stamps [s], ascending, on the road test's time axis.
    values
        in SI (temperatures in °C), at those stamps; NaN where a channel has no good sample.
    dimension
        kinds of quantity, as `atleak.measurements.road_test.QUANTITIES` names them, with their powers: ``(("pressure",
        1),)``.
    undefined
        samples at which the channels have values and the formula has none, as where it divides by zero.
    """

    name: str
    formula: str
    time: np.ndarray
    values: np.ndarray
    dimension: Dimension
    undefined: int = 0


@dataclass(frozen=True, eq=False)
class _Series:
    """Numbers in SI with their dimension; of a number that was typed ``time`` is None and it is the same throughout."""

    values: np.ndarray
    time: np.ndarray | None
    dimension: Dimension


def formula_channel(
    name: str, formula: str, test: RoadTest, above: Mapping[str, FormulaChannel] | None = None
) -> FormulaChannel:
    """Compute a formula over a road test.

    Parameters
    ----------
    above
        formulas computed before, by name, which this one may use.

    Raises
    ------
    FormulaError
        for a formula that cannot be read, names what the log lacks, joins quantities of different kinds, or has no
        channel in it.
    """
    return evaluate(parse(formula), test, name, formula, above)


def evaluate(
    tree: Node, test: RoadTest, name: str = "", formula: str = "", above: Mapping[str, FormulaChannel] | None = None
) -> FormulaChannel:
    """Compute a formula that was read, as `formula_channel`."""
    evaluator = _Evaluator(test, above or {})
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        result = evaluator.value_of(tree)
    if result.time is None:
        expected = Sentence("a channel, such as {names}", names=tuple(evaluator.names[:6]))
        raise fault(1, Sentence("nothing here changes over the log"), expected)
    empty = ~np.isfinite(result.values)
    values = np.where(empty, np.nan, result.values)
    return FormulaChannel(name, formula, result.time, values, result.dimension, evaluator.undefined)


def kind_in_words(dimension: Dimension) -> Sentence:
    """Return what a dimension is called: ``pressure``, ``pressure per time``, ``plain number``.

    >>> kind_in_words((("pressure", 1), ("time", -1))), kind_in_words(())
    ('pressure per time', 'plain number')
    """

    def named(power: int) -> list[Sentence]:
        return [_KIND_NAMES[kind] for kind, each in dimension for _ in range(each * power)]

    above, below = named(1), named(-1)
    if not above:
        above = [Sentence("1") if below else Sentence("plain number")]
    text = above[0]
    for each in above[1:]:
        text = Sentence("{one} times {other}", one=text, other=each)
    for each in below:
        text = Sentence("{one} per {other}", one=text, other=each)
    return text


class _Evaluator:
    """Computes a tree from its leaves up."""

    def __init__(self, test: RoadTest, above: Mapping[str, FormulaChannel]) -> None:
        self.test, self.above, self.undefined = test, above, 0
        held = [quantity for quantity in test.channels if test.channels[quantity].samples]
        short = {quantity: name for name, quantity in CHANNEL_NAMES.items()}
        self.names = [*above, *(short.get(quantity, quantity) for quantity in held)]

    def value_of(self, node: Node) -> _Series:
        match node:
            case NumberNode():
                return _typed(node)
            case NameNode():
                return self._named(node)
            case Negative():
                operand = self.value_of(node.operand)
                if operand.dimension == _ABSOLUTE:
                    problem = Sentence("a temperature in °C cannot change its sign")
                    raise fault(node.at, problem, Sentence("a difference of temperatures"))
                return replace(operand, values=-operand.values)
            case OperationNode():
                return self._joined(node, self.value_of(node.left), self.value_of(node.right))
            case Call():
                return self._called(node)

    def _named(self, node: NameNode) -> _Series:
        if node.name in self.above:
            computed = self.above[node.name]
            return _Series(computed.values, computed.time, computed.dimension)
        by_case = {name.casefold(): quantity for name, quantity in CHANNEL_NAMES.items()}
        quantity = CHANNEL_NAMES.get(node.name) or by_case.get(node.name.casefold(), node.name.casefold())
        if quantity not in QUANTITIES or quantity == "time":
            nearest = nearest_name(node.name, self.names)
            problem = Sentence("there is no channel {name!r}", name=node.name)
            raise fault(node.at, problem, self._offered(), nearest)
        channel = self.test.channel(quantity)
        if channel is None or not channel.samples:
            problem = Sentence("this log has no {quantity}", quantity=QUANTITIES[quantity].label)
            raise fault(node.at, problem, self._offered())
        kind = QUANTITIES[quantity].unit_kind
        dimension = ((kind, 1),) if kind is not None else _PLAIN
        if channel.source == "constant":
            return _Series(np.full(len(self.test.time), channel.values[0]), self.test.time, dimension)
        return _Series(channel.good, channel.time, dimension)

    def _offered(self) -> Sentence:
        return one_of(self.names) or Sentence("a log with channels")

    def _joined(self, node: OperationNode, left: _Series, right: _Series) -> _Series:
        dimension = _sum(node, left, right) if node.sign in "+-" else _product(node, left, right)
        one, other, time = self._together(left, right)
        values = _OPERATIONS[node.sign](one, other)
        if node.sign == "/":
            self.undefined += int(np.count_nonzero(np.isfinite(one) & (other == 0.0)))
        return _Series(values, time, dimension)

    def _together(self, left: _Series, right: _Series) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return both at the same stamps: their own where they share them, else those of the log's rows."""
        if left.time is None or right.time is None or left.time is right.time:
            return left.values, right.values, right.time if left.time is None else left.time
        if np.array_equal(left.time, right.time):
            return left.values, right.values, left.time
        return self._at_rows(left), self._at_rows(right), self.test.time

    def _at_rows(self, series: _Series) -> np.ndarray:
        assert series.time is not None
        if series.time is self.test.time:
            return series.values
        return hold(series.time, series.values, self.test.time, self.test.segments)

    def _called(self, node: Call) -> _Series:
        series = self.value_of(node.arguments[0])
        if series.time is None:
            problem = Sentence("{function} needs what changes over the log", function=node.function)
            raise fault(node.arguments[0].at, problem, Sentence("a channel"))
        if node.function == "derivative":
            return self._derivative(series)
        window = self._window(node)
        make = running_median if node.function == "filtered" else _running_mean
        smooth = make(series.values, clock_at(series.time, self._segments(series.time), window), window)
        known = np.isfinite(series.values)
        if known.any() and not np.isfinite(smooth[known]).any():
            step = float(np.median(np.diff(series.time))) if len(series.time) > 1 else 0.0
            raise fault(
                node.arguments[1].at,
                Sentence(
                    "{window:g} s hold too few samples of this channel, one of which comes every {step:.3g} s",
                    window=window,
                    step=step,
                ),
                Sentence("a longer time, such as {time:.2g}", time=10.0 * step),
            )
        return replace(series, values=np.where(known, smooth, np.nan))

    def _window(self, node: Call) -> float:
        asked = node.arguments[1]
        window = self.value_of(asked)
        if window.time is not None or window.dimension not in (_PLAIN, _TIME):
            problem = Sentence("{function} needs a time that is the same throughout", function=node.function)
            raise fault(asked.at, problem, Sentence("seconds, such as {time}", time=0.5))
        seconds = float(window.values)
        if not 0.0 < seconds <= _LONGEST_WINDOW:
            raise fault(
                asked.at,
                Sentence("{seconds:g} s cannot be filtered over", seconds=seconds),
                Sentence("more than 0 and at most {longest:g} s", longest=_LONGEST_WINDOW),
            )
        return seconds

    def _derivative(self, series: _Series) -> _Series:
        """Differentiate between neighbours that have values, never over a break."""
        time = series.time
        assert time is not None
        values = np.full(len(time), np.nan)
        edges = [segment.start_row for segment in self._segments(time)]
        for start, stop in zip(edges, [*edges[1:], len(time)], strict=True):
            known = start + np.flatnonzero(np.isfinite(series.values[start:stop]))
            if len(known) > 1:
                slope = np.gradient(series.values[known], time[known])
                values[known] = np.where(np.isfinite(slope), slope, np.nan)
        dimension = _DIFFERENCE if series.dimension == _ABSOLUTE else series.dimension
        return _Series(values, time, _powers(dimension, _TIME, -1))

    def _segments(self, time: np.ndarray) -> Sequence[Segment]:
        """Return the log's segments counted on stamps of a channel of its own; at least one."""
        if time is self.test.time:
            counted = list(self.test.segments)
        else:
            counted = []
            for each in self.test.segments:
                low, high = np.searchsorted(time, [each.start, each.stop + 1e-9])
                if high > low:
                    counted.append(replace(each, start_row=int(low), rows=int(high - low)))
        if not counted or counted[0].start_row > 0:
            counted.insert(0, Segment(0, len(time), float(time[0]) if len(time) else 0.0, 0.0))
        return counted


def _typed(node: NumberNode) -> _Series:
    if node.unit is None or node.kind is None:
        return _Series(np.asarray(node.value), None, _PLAIN)
    if node.unit.name == "K":  # of a difference: absolute temperatures are typed in °C or °F
        return _Series(np.asarray(node.value), None, _DIFFERENCE)
    dimension = _PLAIN if node.kind == "ratio" else ((node.kind, 1),)
    return _Series(np.asarray(node.unit.to_si(node.value)), None, dimension)


def _sum(node: OperationNode, left: _Series, right: _Series) -> Dimension:
    """Return the kind of a sum or difference: both of one kind; of temperatures in °C only the difference."""
    one, other = left.dimension, right.dimension
    if one == other == _ABSOLUTE:
        if node.sign == "-":
            return _DIFFERENCE
        problem = Sentence("two temperatures in °C cannot be added")
        raise fault(node.at, problem, Sentence("their difference, or a temperature + 10 K"))
    if one == _ABSOLUTE and other == _DIFFERENCE:
        return _ABSOLUTE
    if one == _DIFFERENCE and other == _ABSOLUTE and node.sign == "+":
        return _ABSOLUTE
    if one == other:
        return one
    first, second = kind_in_words(one), kind_in_words(other)
    if node.sign == "-":
        problem = Sentence("a {second} cannot be taken from a {first}", second=second, first=first)
    else:
        problem = Sentence("a {second} cannot be added to a {first}", second=second, first=first)
    expected = Sentence("two of one kind")
    if _PLAIN in (one, other) and (left.time is None or right.time is None):
        expected = Sentence("a number with its unit, such as 100 kPa")
    raise fault(node.at, problem, expected)


def _product(node: OperationNode, left: _Series, right: _Series) -> Dimension:
    if _ABSOLUTE in (left.dimension, right.dimension):
        problem = Sentence("a temperature in °C cannot be divided: it does not begin at zero")
        if node.sign == "*":
            problem = Sentence("a temperature in °C cannot be multiplied: it does not begin at zero")
        raise fault(node.at, problem, Sentence("a difference, such as T − 20 °C"))
    return _powers(left.dimension, right.dimension, 1 if node.sign == "*" else -1)


def _powers(one: Dimension, other: Dimension, sign: int) -> Dimension:
    powers = dict(one)
    for kind, power in other:
        powers[kind] = powers.get(kind, 0) + sign * power
    return tuple(sorted((kind, power) for kind, power in powers.items() if power))


def _running_mean(values: np.ndarray, clock: np.ndarray, window: float) -> np.ndarray:
    """Compute the mean of the values around each stamp, as `running_median` does its median."""
    known = np.isfinite(values)
    centre = float(np.mean(values[known])) if known.any() else 0.0  # keeps the running sums small
    sums = np.concatenate([[0.0], np.cumsum(np.where(known, values - centre, 0.0))])
    counts = np.concatenate([[0], np.cumsum(known)])
    low = np.searchsorted(clock, clock - window / 2.0 - 1e-9, side="left")
    high = np.searchsorted(clock, clock + window / 2.0 + 1e-9, side="right")
    number = counts[high] - counts[low]
    return np.where(number > 0, (sums[high] - sums[low]) / np.maximum(number, 1) + centre, np.nan)
