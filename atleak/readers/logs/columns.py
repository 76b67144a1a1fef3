"""Assigns columns to quantities: what a name suggests is checked against unit, values and the other columns.

Where doubt remains the user is asked; nothing is guessed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from atleak.common.errors import Message, MessageLevel, Place, RoadTestError, one_of, unknown
from atleak.common.sentences import Sentence
from atleak.common.units import KPA, Quantity, unit
from atleak.measurements.road_test import QUANTITIES, ChannelKind
from atleak.readers.dates import words
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.names import Match, Tier, match_name, match_short_name, name_kind
from atleak.readers.logs.units import ATMOSPHERE, Fit, fit, given
from atleak.readers.remembered_columns import NOT_LOGGED

_AT_100 = {  # [rpm] at 100 km/h between which cars with automatic transmissions lie, by gear: choice of this project
    10: (900, 2400), 9: (900, 2400), 8: (1000, 2500), 7: (1100, 2700), 6: (1200, 2900), 5: (1300, 3200),
    4: (1500, 3600),
}  # fmt: skip
_DRIVES, _DRIVES_AT = 30.0, 1000.0  # in either unit of speed, and [rpm], above which a car drives in such a gear
_DRIVEN_ROWS = 20
HELD, BESIDE = 6, 200 << 20
"""How many times the size of its numbers a log takes while it is read and evaluated, and how many bytes beside."""
SMALL = 64 << 20
"""Bytes of a log itself up to which it is read however little memory is free."""


@dataclass(frozen=True)
class Candidate:
    """A column that may hold a quantity."""

    heading: Heading
    quantity: str
    tier: Tier
    kind: ChannelKind
    unit: str | None
    mapped: bool = False

    @property
    def label(self) -> str:
        """Return the column's name in the file."""
        return self.heading.label


OfferedColumn = tuple[Candidate, np.ndarray, np.ndarray | None]
"""A candidate with its numbers and its own stamps (None: the rows')."""


@dataclass(frozen=True)
class Signal:
    """A column taken for a quantity: the file's numbers, the unit, and the stamps if it has its own."""

    candidate: Candidate
    values: np.ndarray
    fit: Fit
    time: np.ndarray | None = None


@dataclass(frozen=True)
class Ambiguous:
    """A quantity for which the file offers more than can be decided: the user must choose."""

    quantity: str  # to choose a column for
    candidates: tuple[str, ...]  # columns that may hold it
    why: Sentence = Sentence("")  # noqa: RUF009  frozen, so safe to share
    guess: str | None = None  # the column that it most likely is, where a single one comes into question


def match_heading(heading: Heading) -> Match | None:
    """Return the quantity a heading stands for: the first of its names that is known."""
    matches = (match_name(name) or match_short_name(name, heading.unit) for name in heading.names)
    return min(filter(None, matches), key=lambda match: match.tier, default=None)


def find_candidates(headings: Sequence[Heading]) -> list[Candidate]:
    """Return every heading that may be a quantity, in file order."""
    result = []
    for heading in headings:
        if match := match_heading(heading):
            tier: Tier = 1 if match.tier == 0 and heading.foreign and match.quantity != "time" else match.tier
            result.append(Candidate(heading, match.quantity, tier, match.kind, heading.unit or match.unit))
    return result


def find_heading(headings: Sequence[Heading], wanted: str, file: str) -> Heading:
    """Return the column that the user names: by its full header, its name without unit, or ``column 3``.

    Of several with one name it is the one with that place: ``Speed (column 3)``.
    """
    tests = (
        lambda heading: heading.label == wanted.strip(),
        lambda heading: heading.numbered == wanted.strip(),
        lambda heading: words(heading.label) == words(wanted),
        lambda heading: wanted.strip() in heading.names,
        lambda heading: any(words(name) == words(wanted) for name in heading.names) and words(wanted) != "",
        lambda heading: words(wanted) == f"column {heading.index + 1}" or wanted.strip() == str(heading.index + 1),
    )
    for test in tests:
        matching = [heading for heading in headings if test(heading)]
        if len(matching) > 1:
            places = one_of(f"'column {heading.index + 1}'" for heading in matching)
            problem = Sentence("several columns bear this name")
            raise RoadTestError(problem, place=Place(file=file), value=wanted, expected=places)
        if matching:
            return matching[0]
    labels = [heading.label for heading in headings]
    raise unknown(Sentence("no column bears this name"), wanted, labels, kind=RoadTestError, place=Place(file=file))


def map_columns(
    candidates: list[Candidate], headings: Sequence[Heading], mapping: Mapping[str, str], file: str
) -> list[Candidate]:
    """Return the candidates after the user has named columns: a named column replaces what the names suggest."""
    for quantity, column in mapping.items():
        if quantity not in QUANTITIES:
            problem = Sentence("unknown quantity")
            raise unknown(problem, quantity, QUANTITIES, kind=RoadTestError, place=Place(file=file))
        if column == NOT_LOGGED:
            candidates = [candidate for candidate in candidates if candidate.quantity != quantity]
            continue
        heading = find_heading(headings, column, file)
        kind = name_kind(heading.label) if QUANTITIES[quantity].unit_kind == "pressure" else "unknown"
        match = match_heading(heading)
        stated = heading.unit or (match.unit if match and match.quantity == quantity else None)
        if match and match.quantity == quantity:
            kind = match.kind
        others = (each for each in candidates if each.quantity != quantity and each.heading.index != heading.index)
        candidates = [*others, Candidate(heading, quantity, 0, kind, stated, mapped=True)]
    return candidates


def own_part_of(room: float) -> float:
    """Return how many bytes a log itself may take where this many may be taken in all."""
    return max(room - BESIDE, SMALL)


@dataclass
class Assigner:
    """Collects the decisions about one file: chosen signals, open questions, messages."""

    file: str
    units: Mapping[str, str]
    neighbours: Sequence[str] = ()  # units that the file states
    interval: float | None = None  # [s] between rows, as the user states it
    every: int = 1  # of how many rows one is read
    room: float = math.inf  # bytes of memory that may be taken
    signals: dict[str, Signal] = field(default_factory=dict)
    ambiguous: list[Ambiguous] = field(default_factory=list)
    refused: dict[str, Sentence] = field(default_factory=dict)  # by quantity, why a column of its name was not taken
    unreadable: set[str] = field(default_factory=set)  # columns whose cells are no numbers, which has been said
    messages: list[Message] = field(default_factory=list)
    base: np.ndarray | None = None  # stamps of signals that have none of their own

    def error(
        self, problem: Sentence, value: object = None, expected: Sentence | None = None, column: str | None = None
    ) -> RoadTestError:
        """Return an error about the file, or about a column of it."""
        return RoadTestError(problem, place=Place(file=self.file, column=column), value=value, expected=expected)

    def say(
        self, code: str, text: Sentence, level: MessageLevel = "info", column: str | None = None, **values: object
    ) -> None:
        """Add a message, filled in with values and the column of which it speaks."""
        values = {"column": column, **text.values, **values}
        self.messages.append(Message(level, code, text.of(**values), Place(file=self.file, column=column)))

    def refuse(
        self, candidate: Candidate, code: str, why: Sentence, level: MessageLevel = "warning", **values: object
    ) -> None:
        """Add a message that a column is not taken for its quantity, and why; values fill it in."""
        quantity = QUANTITIES[candidate.quantity].said
        why = why.of(**{"column": candidate.label, "quantity": quantity, **why.values, **values})
        self.refused.setdefault(candidate.quantity, why)
        if code == "column_refused":
            self.unreadable.add(candidate.label)
        self.say(code, why, level, candidate.label)

    def assume_unit(self, column: str, unit: str, quantity: str, doubt: Sentence | None = None) -> None:
        """Add a message that a column states no unit, and which is assumed."""
        text = Sentence("{column!r} states no unit; {unit} is assumed for {quantity}")
        text = text.of(column=column, unit=unit, quantity=QUANTITIES[quantity].said)
        if doubt:
            text = Sentence("{problem} ({doubt})", problem=text, doubt=doubt)
        text = Sentence("{problem}: confirm or name the unit", problem=text)
        self.say("unit_assumed", text, "warning", column)

    def refuse_too_large(self, rows: float, wide: float, *, thins: bool = True) -> None:
        """Refuse a log that would take more memory than there is, before it is read.

        It has some ``rows``, of which each takes ``wide`` bytes; ``thins``: where one of some is read, fewer are kept.
        """
        whole, most = HELD * wide * rows, own_part_of(self.room)
        held = whole / (self.every if thins else 1)
        if held <= most:
            return
        expected = Sentence("part of the drive")
        if thins:
            fits = math.ceil(whole / most)
            expected = Sentence("part of the drive, or one row in {every}: --every {every}", every=fits)
        problem = Sentence("would take {needed:.1f} GB of memory with its evaluation, and {room:.1f} GB are free")
        raise self.error(problem.of(needed=(BESIDE + held) / 1e9, room=self.room / 1e9), expected=expected)

    def leave_out(self, mapping: Mapping[str, str]) -> None:
        """Note which quantities the user says are not logged: nothing is asked about them."""
        for quantity, column in mapping.items():
            if column == NOT_LOGGED:
                self.refused[quantity] = Sentence("it is stated that no column of this log holds it")

    def decide_all(self, offered: Iterable[OfferedColumn]) -> None:
        """Choose a column for every quantity that is offered."""
        offered = list(offered)
        for quantity in QUANTITIES:
            if of_quantity := [each for each in offered if each[0].quantity == quantity]:
                self._decide(quantity, of_quantity)

    def _decide(self, quantity: str, offered: Sequence[OfferedColumn]) -> None:
        """Choose one of the candidates for a quantity, or list them as ambiguous."""
        signals = [signal for each in offered if (signal := self._fit(*each)) is not None]
        fitting = [signal for signal in signals if not signal.fit.problem]
        misfits = [signal for signal in signals if signal.fit.problem]
        for signal in misfits:
            text = Sentence("{column!r} is not taken for {quantity}: {problem}")
            self.refuse(signal.candidate, "column_misfit", text, problem=signal.fit.problem)
        chosen = self._choose(quantity, fitting)
        if chosen is None:
            doubtful = [signal for signal in misfits if signal.candidate.tier < 2 and not signal.fit.foreign]
            if doubtful and not fitting:
                labels = tuple(signal.candidate.label for signal in doubtful)
                self.ambiguous.append(Ambiguous(quantity, labels, doubtful[0].fit.problem or Sentence("")))
            return
        doubt = self._speed_by_gear(chosen) if quantity == "vehicle_speed" and chosen.fit.assumed else None
        if doubt is not None:
            label = chosen.candidate.label
            self.ambiguous.append(Ambiguous(quantity, (label,), doubt, label))
            return
        self.signals[quantity] = chosen
        self._comment(chosen)

    def _speed_by_gear(self, speed: Signal) -> Sentence | None:
        """Return how fast the engine would turn at 100 km/h where that is against the assumed unit, and for the other.

        The highest gear that is driven for a while tells it; None where nothing does, or both may be.
        """
        rows = [self.signals.get(name) for name in ("gear", "engine_speed")]
        if any(each is None or each.time is not speed.time or len(each.values) != len(speed.values) for each in rows):
            return None
        stride = max(1, len(speed.values) // 20_000)
        gear, engine = (each.fit.to_si(each.values[::stride]) for each in rows if each is not None)
        there = speed.values[::stride]
        driving = (there > _DRIVES) & (engine * 60 > _DRIVES_AT)
        top = next((each for each in _AT_100 if np.count_nonzero(driving & (gear == each)) >= _DRIVEN_ROWS), None)
        if top is None or speed.fit.unit is None:
            return None
        in_top = driving & (gear == top)
        low, middle, high = np.percentile(engine[in_top] * 60 / there[in_top], (25, 50, 75)).tolist()
        at_100 = {name: 100 / 3.6 / unit(name, "speed").factor * middle for name in ("km/h", "mph")}
        right = {name for name, rpm in at_100.items() if _AT_100[top][0] <= rpm <= _AT_100[top][1]}
        if high - low > 0.15 * middle or speed.fit.unit.name in right or not right:
            return None
        return Sentence(
            "its unit is not stated and must be named, as at 100 km/h in gear {gear} the engine turns at {kmh:.0f} rpm "
            "if it is km/h and at {mph:.0f} rpm if it is mph",
            gear=top, kmh=at_100["km/h"], mph=at_100["mph"],
        )  # fmt: skip

    def _fit(self, candidate: Candidate, values: np.ndarray, time: np.ndarray | None) -> Signal | None:
        kind = QUANTITIES[candidate.quantity].unit_kind
        sample = values[:: max(1, len(values) // 10_000)]
        if not np.isfinite(sample).any() and not np.isfinite(values).any():
            if candidate.label in self.unreadable:
                return None
            self.refuse(candidate, "column_empty", Sentence("{column!r} holds no values"), "info")
            return None
        if not candidate.mapped and (dead_value := _dead_value(kind, sample)) is not None and _only(values, dead_value):
            text = Sentence("{column!r} is {value:g} throughout: the car or logger does not deliver it")
            self.refuse(candidate, "column_empty", text, value=dead_value)
            return None
        if candidate.quantity in self.units:
            return Signal(candidate, values, given(candidate.quantity, self.units[candidate.quantity]), time)
        commanded = candidate.mapped or candidate.kind == "commanded"
        column_fit = fit(candidate.quantity, candidate.unit, values, self.neighbours, commanded=commanded)
        return Signal(candidate, values, column_fit, time)

    def _choose(self, quantity: str, fitting: list[Signal]) -> Signal | None:
        """Return the column that the user names or its name tells best; None, and a question, where several may be."""
        if not fitting:
            return None
        if mapped := [signal for signal in fitting if signal.candidate.mapped]:
            return mapped[0]
        tiers = {signal.candidate.tier for signal in fitting}
        best = min(tiers)
        tied = _measured_of([signal for signal in fitting if signal.candidate.tier == best])
        resembling = best > 0 and 2 in tiers
        if len(tied) == 1 and not resembling:
            chosen = tied[0].candidate
            if others := tuple(repr(each.candidate.label) for each in fitting if each is not tied[0]):
                text, said = Sentence("{quantity} is {column!r}; also there: {others}"), QUANTITIES[quantity].said
                self.say("other_candidates", text, "info", chosen.label, quantity=said, others=others)
            return tied[0]
        if not resembling and (same := self._same(tied)):
            return same
        labels = _told_apart([signal for signal in fitting if resembling or signal.candidate.tier == best])
        if best < 2:
            self.ambiguous.append(Ambiguous(quantity, labels, Sentence("several columns may be meant")))
        else:
            guess = labels[0] if len(labels) == 1 else None
            self.ambiguous.append(Ambiguous(quantity, labels, Sentence("the name only resembles it"), guess))
        return None

    def _same(self, tied: list[Signal]) -> Signal | None:
        """Return the first of several columns if all hold the same values, perhaps in other units; else None."""
        first = tied[0]
        for other in tied[1:]:
            if other.time is not first.time or len(other.values) != len(first.values):
                if not self._same_name_elsewhere(first, other):
                    return None
                continue
            if not _hold_the_same(first, other):
                return None
            text, label = Sentence("{first!r} and {other!r} hold the same; the first is used"), first.candidate.label
            self.say("same_twice", text, "info", label, first=label, other=other.candidate.label)
        return first

    def _same_name_elsewhere(self, first: Signal, other: Signal) -> bool:
        """Return whether a channel of another group, with its own clock, is the same: name and course must agree."""
        own, time = self.base if first.time is None else first.time, other.time
        base, values = first.fit.to_si(first.values), other.fit.to_si(other.values)
        if first.candidate.label != other.candidate.label or own is None or time is None or len(own) != len(base):
            return False
        if len(base) < 3 or len(values) < 3 or not np.all(np.diff(time) >= 0):
            return False
        difference = np.abs(np.interp(own, time, values) - base)
        if np.nanmedian(difference) > 0.03 * max(float(np.nanmax(base) - np.nanmin(base)), 1e-9):
            return False
        self.say("same_twice", Sentence("{column!r} stands twice; the first is used"), "info", first.candidate.label)
        return True

    def _comment(self, signal: Signal) -> None:
        candidate, column_fit = signal.candidate, signal.fit
        quantity, label = QUANTITIES[candidate.quantity], candidate.label
        if column_fit.assumed and column_fit.unit:
            self.assume_unit(label, column_fit.unit.name, candidate.quantity, column_fit.doubt)
        if candidate.tier == 1:
            text = Sentence("{quantity} is taken from {column!r}, for want of a better")
            self.say("second_choice", text, "warning", label, quantity=quantity.said)
        if quantity.unit_kind == "pressure":
            if candidate.kind == "commanded":
                text = Sentence(
                    "{column!r} is commanded by the gearbox computer, not measured by a gauge: no leak shows in it"
                )
                self.say("pressure_commanded", text, "warning", label)
            elif candidate.kind == "unknown":
                text = Sentence("{column!r}: nothing says whether this pressure is measured or commanded")
                self.say("pressure_unknown", text, "warning", label)
            if column_fit.absolute:
                text = Sentence("{column!r} is absolute; {air:.3f} {air.unit} are taken off")
                self.say("pressure_absolute", text, "info", label, air=Quantity(ATMOSPHERE * KPA, "pressure"))
            else:
                self.say("pressure_gauge", Sentence("{column!r} is taken as gauge pressure"), "info", label)


def _hold_the_same(first: Signal, other: Signal) -> bool:
    """Return whether two columns of the same rows hold the same values, perhaps in other units."""
    base, values = first.fit.to_si(first.values), other.fit.to_si(other.values)
    here = np.isfinite(values) & np.isfinite(base)
    scale = float(np.max(np.abs(base[here]), initial=0.0))
    apart = float(np.max(np.abs(values[here] - base[here]), initial=0.0))
    return here.sum() >= max(1, 0.9 * np.isfinite(base).sum()) and apart <= 0.006 * scale


def _measured_of(tied: list[Signal]) -> list[Signal]:
    """Return the measured column alone where all others are commanded; any other columns as they are."""
    kinds = Counter(signal.candidate.kind for signal in tied)
    if kinds["measured"] == 1 and not kinds["unknown"]:
        return [signal for signal in tied if signal.candidate.kind == "measured"]
    return tied


def _told_apart(signals: Sequence[Signal]) -> tuple[str, ...]:
    """Return the columns' names, with their places where several bear the same."""
    names = [signal.candidate.label for signal in signals]
    return tuple(
        signal.candidate.heading.numbered if names.count(name) > 1 else name
        for signal, name in zip(signals, names, strict=True)
    )


def _dead_value(kind: str | None, sample: np.ndarray) -> float | None:
    """Return the one value that fills a sample of the column, if that value means *no sensor*; else None."""
    dead_values = {"temperature": (0.0, -40.0, 215.0, 255.0), "pressure": (0.0,)}.get(kind or "", ())
    return next((value for value in dead_values if _only(sample, value)), None)


def _only(values: np.ndarray, value: float) -> bool:
    """Return whether a column holds nothing but one value, and cells without any."""
    return bool(((values == value) | np.isnan(values)).all())


def stated_units(headings: Sequence[Heading]) -> list[str]:
    """Return every unit that the headings state."""
    return [heading.unit for heading in headings if heading.unit]
