"""Converts time columns to seconds: numbers in any unit, epochs, Excel days, clock strings as loggers write them."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from atleak.intake.dates import day_number, half_day, likely_order, sure_date
from atleak.intake.road_test.blocks import blocks_of, turned
from atleak.intake.road_test.clock.timeline import Running, strays_of
from atleak.intake.units import HHMMSS, Unit, find_unit
from atleak.sentence import Sentence

DAY = 86400.0
YEAR = 365 * DAY
_PART = 200_000  # samples that show what a clock counts
_FIRST_EXCEL_DAY = dt.date(1899, 12, 30)


@dataclass(frozen=True)
class Clock:
    """A time column in seconds (NaN where unreadable), with the unit and form it was read in."""

    seconds: np.ndarray
    unit: str
    unit_assumed: bool = False
    form: str = "number"
    notes: tuple[Sentence, ...] = ()
    absolute: bool = False
    date: dt.date | None = None  # of the first stamp, where it cannot be mistaken


@dataclass(frozen=True)
class Motion:
    """A channel that cannot change faster than ``limit`` per second: it shows whether stamps are s or ms."""

    values: np.ndarray
    limit: float

    def possible(self, stamps: np.ndarray, factor: float) -> bool:
        """Return whether the channel's changes are possible with stamps in a unit of so many seconds."""
        step, change = np.diff(stamps * factor), np.abs(np.diff(self.values))
        use = (step > 0) & (change > 0)
        rates = change[use] / step[use]
        return len(rates) < 5 or float(np.percentile(rates, 75)) <= self.limit


@dataclass(frozen=True)
class _Finite:
    """What of a column's finite numbers decides what they count."""

    middle: float
    part: np.ndarray  # the first of them
    column: np.ndarray

    @classmethod
    def of(cls, values: np.ndarray, whole: bool) -> _Finite | None:
        """Look through a column; None where no number is finite. ``whole``: that all are is known."""
        if whole and len(values):
            return cls(float(np.median(_sample(values))), values[:_PART], values)
        finite = values[np.isfinite(values)]
        return cls.of(finite, True) if len(finite) else None

    def all_whole(self) -> bool:
        """Return whether every number is a whole one."""
        return all(bool(np.all((block == np.round(block)) | ~np.isfinite(block))) for block in blocks_of(self.column))


_SAMPLE = 10_000


def _sample(values: np.ndarray) -> np.ndarray:
    sample: np.ndarray = values[:: max(1, len(values) // _SAMPLE)]
    return sample


@dataclass(frozen=True)
class NumericForm:
    """What the numbers of a time column count, and how they become seconds."""

    unit: str
    assumed: bool = False
    form: str = "number"
    factor: float = 1.0  # [s]
    start: float | None = None  # number of the first stamp, where time counts from it
    absolute: bool = False
    date: dt.date | None = None

    def seconds(self, values: np.ndarray, runs: Running) -> np.ndarray:
        """Convert the next numbers, NaN where they are no stamps; ``runs`` carries on from those before them."""
        if self.as_is:
            return values
        if self.form == _DIGITS:
            return runs.on(_seconds_of_digits(values))
        with np.errstate(over="ignore"):
            if self.form == _EXCEL:
                seconds = np.round((values - (self.start or 0.0)) * DAY, 6)
            elif self.form.startswith("epoch"):
                # an epoch in double precision is good for a microsecond; far from the others: the clock was not set yet
                seconds = np.round((values - (self.start or 0.0)) * self.factor, 6)
                return np.where(np.abs(seconds) < YEAR, seconds, np.nan)
            else:
                seconds = values * self.factor
        return np.where(np.isinf(seconds), np.nan, seconds)

    def clock(self, seconds: np.ndarray) -> Clock:
        """Return the clock of these seconds."""
        return Clock(seconds, self.unit, self.assumed, self.form, (), self.absolute, self.date)

    @property
    def period(self) -> float | None:
        """Return after which time the clock starts again [s]; None where it runs on."""
        return DAY if self.form == _DIGITS else None

    @property
    def as_is(self) -> bool:
        """Return whether the numbers are the seconds."""
        return self.form == "number" and self.factor == 1.0


_EXCEL, _DIGITS = "Excel days", "time of day, HHMMSS"


def numeric_clock(values: np.ndarray, unit: str | None, motions: Sequence[Motion] = (), whole: bool = False) -> Clock:
    """Convert numbers to seconds.

    With a unit, that unit. Without: epochs in s, ms, µs or ns and Excel days by their size; otherwise s, or ms
    where whole numbers step by 5 and more and the channels beside it could not move that fast in seconds. ``whole``:
    that all numbers are finite is known.
    """
    values = values.astype(float, copy=False)
    form = numeric_form(values, unit, motions, whole)
    return form.clock(form.seconds(values, Running(form.period)))


def numeric_form(
    values: np.ndarray, unit: str | None, motions: Sequence[Motion] = (), whole: bool = False
) -> NumericForm:
    """Tell what numbers count; parameters are those of `numeric_clock`."""
    finite = _Finite.of(values, whole)
    if finite is None:
        return NumericForm(unit or "s", unit is None)
    known = find_unit(unit, "time") if unit else None
    epoch = _epoch(finite.middle)
    if known is not None and known.name in ("s", "ms") and epoch not in (None, known.name):
        known = find_unit(str(epoch), "time")
    if known is None and epoch:
        known = find_unit(epoch, "time")
        assert known is not None
        return _epoch_form(values, known, finite.middle)
    if known is not None and known.name == HHMMSS:
        return NumericForm("clock", False, _DIGITS)
    if known is not None:
        return _epoch_form(values, known, finite.middle) if epoch else NumericForm(known.name, factor=known.factor)
    part = finite.part[~strays_of(finite.part)]
    if _excel_days(part):
        start = float(part[0])
        return NumericForm("d", False, _EXCEL, DAY, start, True, _FIRST_EXCEL_DAY + dt.timedelta(int(start)))
    minutes, leaps = _minutes_of_digits(part)
    if minutes:
        return NumericForm("clock", False, _DIGITS)
    name, sure = _guess(finite, values, motions)
    return NumericForm(name, not sure or leaps > 0, factor={"s": 1.0, "ms": 1e-3, "µs": 1e-6}[name])


def _epoch_form(values: np.ndarray, unit: Unit, middle: float) -> NumericForm:
    """Return how an epoch is read: from the first stamp that lies within a year of the middle one."""
    near = YEAR / unit.factor
    begun = (block[np.abs(block - middle) < near] for block in blocks_of(values))
    start = next((float(block[0]) for block in begun if len(block)), 0.0)
    day = dt.date(1970, 1, 1) + dt.timedelta(seconds=start * unit.factor) if start else None
    return NumericForm(unit.name, False, f"epoch {unit.name}", unit.factor, start, True, day)


def _epoch(value: float) -> str | None:
    for low, unit in ((1e9, "s"), (1e12, "ms"), (1e15, "µs"), (1e18, "ns")):
        if low <= value < 4e9 * low / 1e9:
            return unit
    return None


def _seconds_of_digits(values: np.ndarray) -> np.ndarray:
    """Return the seconds since midnight of numbers whose digits are a clock's, 100059.5 being 10:00:59.5; else NaN."""
    minutes, hours = values // 100 % 100, values // 10_000
    good = (hours >= 0) & (hours < 24) & (minutes < 60) & (values % 100 < 60)
    return np.where(good, hours * 3600 + minutes * 60 + np.round(values % 100, 6), np.nan)


def _minutes_of_digits(values: np.ndarray) -> tuple[int, int]:
    """Return how often a minute begins in numbers that may be the digits HHMMSS of a clock, and how often they leap.

    They may be where none has 60 seconds or minutes, but for one that is far from both its neighbours. Where the digits
    leap, and the time they tell goes on as usual, a minute begins: seconds with pauses do not go on so.
    """
    if len(values) < 3:
        return 0, 0
    steps, told = np.diff(values), _seconds_of_digits(values)
    usual = float(np.median(steps))
    far = np.abs(steps) > 3 * usual
    lone = np.append(far, True) & np.append(True, far)
    if not 0 < usual < 30 or (np.isnan(told) & ~lone).any():
        return 0, 0
    known = np.isfinite(told)
    steps, true = np.diff(values[known]), np.diff(told[known])
    true = np.where(true < -DAY / 2, true + DAY, true)  # past midnight
    leaps = np.abs(steps - true) > 1
    return int(np.count_nonzero(leaps & (true >= 0) & (true <= 3 * usual))), int(np.count_nonzero(leaps))


_LONGEST_STEP_IN_DAYS = 60 / DAY


def _excel_days(values: np.ndarray) -> bool:
    middle = np.median(values)
    steps = np.diff(values)
    steps = steps[steps > 0]
    return bool(
        25000 < middle < 80000
        and len(steps)
        and np.median(steps) < _LONGEST_STEP_IN_DAYS
        and np.ptp(values) < 30
        and not np.allclose(values * 1000, np.round(values * 1000), rtol=0, atol=1e-7)
    )


def _guess(finite: _Finite, values: np.ndarray, motions: Sequence[Motion]) -> tuple[str, bool]:
    steps = np.diff(finite.part)
    steps = steps[steps > 0]
    if not len(steps):
        return "s", False
    step = float(np.median(steps))
    whole = finite.all_whole()
    if not whole and step < 2:
        return "s", True
    if step < 2:
        return "s", False
    options = ["ms", "s"] if step >= 20 or (whole and step >= 5) else ["s", "ms"]
    if whole and step >= 3000:
        options = ["µs", "ms", "s"]
    # the slower unit wins only where the faster one is impossible
    for name in options:
        factor = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}[name]
        if all(motion.possible(values, factor) for motion in motions):
            return name, False
    return options[0], False


# --- clock strings ------------------------------------------------------------------------------------------

_TIME_OF_DAY = re.compile(r"(?<![\d.,])(\d{1,4}):(\d{1,6}):(\d{1,2})(?:[.,:](\d{1,9}))?")
_SHORT = re.compile(r"(?<![\d.,:])(\d{1,3}):(\d{2})(?:[.,](\d{1,6}))?(?![\d:])")


def holds_a_time(text: str) -> bool:
    """Return whether a time of day stands anywhere in a cell.

    >>> holds_a_time("@Wed May  2 10:24:10 2018"), holds_a_time("1:3")
    (True, False)
    """
    return _TIME_OF_DAY.search(text) is not None or _SHORT.search(text) is not None


@dataclass
class ClockParts:
    """The numbers of a column of clock strings, row by row."""

    major: np.ndarray  # hours, or minutes of a two-part clock
    minor: np.ndarray
    seconds: np.ndarray
    parts: np.ndarray  # 3, 2, or 0 where unreadable
    fraction: np.ndarray  # whether a fraction was written
    dates: np.ndarray  # index into texts
    texts: list[str] = field(default_factory=list)


def text_clock(column: pd.Series) -> Clock | None:
    """Convert clock strings to seconds from the first one; None when they cannot be read.

    Dates and times of day of every usual form are read, with months and weekdays in seven languages, half days
    (AM, PM), ``hours : total minutes : seconds``, and minutes and seconds whose hour a spreadsheet has cut off: those
    give relative time only.
    """
    read = read_clocks(column)
    told = ClockTally()
    told.add(read, int(column.notna().sum()))
    form = told.form()
    return None if form is None else form.clock(form.seconds(read, Running(form.period)))


@dataclass
class ClockTally:
    """What of clock strings decides how they are read; those of the parts of a column add up."""

    filled: int = 0  # cells
    texts: dict[str, int] = field(default_factory=lambda: {"": 0})  # what stands beside the clock → its number
    kinds: dict[int, _KindOfClock] = field(default_factory=lambda: {3: _KindOfClock(), 2: _KindOfClock()})  # by parts

    def add(self, read: ClockParts, filled: int) -> None:
        """Add the next cells, of which so many are filled; their texts are numbered as those of all cells."""
        self.filled += filled
        numbers = np.array([self.texts.setdefault(text, len(self.texts)) for text in read.texts])
        read.dates = numbers[read.dates]
        for parts, kind in self.kinds.items():
            kind.add(read, read.parts == parts)

    def form(self) -> TextForm | None:
        """Return how the cells are read; None where they cannot be."""
        three, two = self.kinds[3], self.kinds[2]
        if three.cells + two.cells < max(1, 0.5 * self.filled):
            return None
        parts = 3 if three.cells >= two.cells else 2
        kind, texts = self.kinds[parts], list(self.texts)
        dates = [_date_text(text) for text in texts]
        order = likely_order(dates, [half_day(text) for text in texts])
        days = [day_number(text, order) for text in dates]
        dated = bool(kind.dates) and all(days[index] is not None for index in kind.dates)
        form = (_three_parts if parts == 3 else _two_parts)(
            kind, days if dated else None, [half_day(text) for text in texts]
        )
        if form is None or not dated:
            return form
        return replace(form, date=sure_date([texts[index] for index in sorted(kind.dates)]))


@dataclass
class _KindOfClock:
    """What is known of the cells with so many parts."""

    cells: int = 0
    hours_of_minutes: int = 0  # cells with 60 minutes and more
    late: int = 0  # cells with 61 seconds and more
    no_minute: bool = False  # whether one has 60 seconds
    fractions: int = 0  # cells with a fraction
    dates: set[int] = field(default_factory=set)  # numbers of the texts beside them

    def add(self, read: ClockParts, good: np.ndarray) -> None:
        if not good.any():
            return
        seconds = read.seconds[good]
        self.cells += len(seconds)
        self.hours_of_minutes += int(np.count_nonzero(read.minor[good] > 59))
        self.late += int(np.count_nonzero(seconds >= 61))
        self.no_minute = self.no_minute or bool((seconds > 59.9999999).any())
        self.fractions += int(np.count_nonzero(read.fraction[good]))
        self.dates |= set(np.flatnonzero(np.bincount(read.dates[good])).tolist())


@dataclass(frozen=True)
class TextForm:
    """How clock strings become seconds: by the weights of their numbers, and the days and halves beside them."""

    parts: int
    weights: tuple[float, float, float]  # [s] of the first and second number, and of the seconds
    form: str
    period: float | None = None  # [s] after which the clock starts again
    days: np.ndarray | None = None  # [s] by the number of the text beside it
    noon: np.ndarray | None = None  # hours to add to those of half a day, by the same; negative where not
    notes: tuple[Sentence, ...] = ()
    date: dt.date | None = None

    def seconds(self, read: ClockParts, runs: Running) -> np.ndarray:
        """Convert the next clocks; ``runs`` carries on from those before them."""
        major = read.major
        if self.noon is not None:
            noon = self.noon[read.dates]
            major = np.where(noon >= 0, major % 12 + np.maximum(noon, 0), major)
        hours, minutes, rest = self.weights
        seconds = major * hours + read.minor * minutes + read.seconds * rest
        good = read.parts == self.parts
        if self.parts == 3:
            good = good & (read.seconds < 61) & ((read.minor < 60) | (hours == 0.0))
        seconds = np.where(good, seconds, np.nan)
        if self.days is not None:
            seconds = seconds + self.days[read.dates]
        return runs.on(seconds)

    def clock(self, seconds: np.ndarray) -> Clock:
        """Return the clock of these seconds."""
        return Clock(seconds, "clock", False, self.form, self.notes, self.days is not None, self.date)


_DAMAGED = 1  # cells that cannot be a clock's: of more the column is of another form


def _three_parts(kind: _KindOfClock, days: list[int | None] | None, halves: list[str | None]) -> TextForm | None:
    if kind.late > _DAMAGED:
        return None
    if kind.hours_of_minutes > _DAMAGED:
        return TextForm(3, (0.0, 60.0, 1.0), "hours : total minutes : seconds")
    noon = _noon(halves)
    if days is not None:
        return TextForm(3, (3600.0, 60.0, 1.0), "date and time", days=_days_of(days), noon=noon)
    return TextForm(3, (3600.0, 60.0, 1.0), "time of day", DAY, noon=noon)


def _two_parts(kind: _KindOfClock, days: list[int | None] | None, halves: list[str | None]) -> TextForm | None:
    if days is not None:
        note = Sentence(
            "the clock's seconds are lost (a spreadsheet shows hours and minutes only): stamps are 60 s apart"
        )
        weights = 3600.0, 60.0, 0.0
        return TextForm(2, weights, "date and time", days=_days_of(days), noon=_noon(halves), notes=(note,))
    if not kind.fractions > 0.5 * kind.cells or kind.no_minute:
        return None  # hh:mm and mm:ss look the same
    note = Sentence(
        "a spreadsheet has cut the hours off the clock: time runs from the first row, the time of day is not known"
    )
    return TextForm(2, (60.0, 0.0, 1.0), "minutes and seconds", 3600.0, notes=(note,))


def _noon(halves: list[str | None]) -> np.ndarray | None:
    if not any(halves):
        return None
    return np.array([{"am": 0.0, "pm": 12.0}.get(half or "", -1.0) for half in halves])


def _days_of(days: list[int | None]) -> np.ndarray:
    numbers = np.array([np.nan if day is None else float(day) for day in days])
    counted: np.ndarray = (numbers - np.nanmin(numbers)) * DAY
    return counted


def read_clocks(column: pd.Series) -> ClockParts:
    """Read the numbers of clock strings, and what stands beside them."""
    size = len(column)
    read = ClockParts(
        major=np.zeros(size),
        minor=np.zeros(size),
        seconds=np.zeros(size),
        parts=np.zeros(size, int),
        fraction=np.zeros(size, bool),
        dates=np.zeros(size, int),
        texts=[""],
    )
    packed, all_as_long = _packed(column)
    width = packed.dtype.itemsize
    if not width:
        return read
    table = packed.view(np.uint8).reshape(size, width)
    alike = {width: np.arange(size)} if all_as_long else _by_length(table)
    for length, rows in alike.items():
        for _ in range(12):  # templates of one length
            rows = _read_alike(read, table, rows, length, column)
            if not len(rows):
                break
    return read


def _by_length(table: np.ndarray) -> dict[int, np.ndarray]:
    """Return the rows of strings of each length."""
    lengths = (table != 0).sum(axis=1)
    return {int(length): np.flatnonzero(lengths == length) for length in np.unique(lengths[lengths > 0])}


def _packed(column: pd.Series) -> tuple[np.ndarray, bool]:
    """Return the strings as a fixed-width array of bytes, one for each character, and whether all are as long."""
    try:
        import pyarrow as pa

        strings = pa.array(column, type=pa.large_string())
        if isinstance(strings, pa.ChunkedArray):
            strings = strings.combine_chunks()
    except (ImportError, TypeError, ValueError):
        strings = None
    if strings is not None and not strings.null_count and len(strings):
        offsets = np.frombuffer(strings.buffers()[1], np.int64)[strings.offset : strings.offset + len(strings) + 1]
        width = int(offsets[1] - offsets[0])
        data = strings.buffers()[2]
        if width and data is not None and bool((np.diff(offsets) == width).all()):
            table = np.frombuffer(data, np.uint8)[offsets[0] : offsets[-1]]
            if table.min() > 0 and table.max() < 0x80:
                return table.view(f"S{width}"), True
    raw = column.to_numpy(dtype=object)
    missing = column.isna().to_numpy()
    if missing.any():
        raw = np.where(missing, "", raw)
    try:
        return np.array(raw, dtype="S"), False
    except UnicodeEncodeError:
        return np.array([str(cell).encode("ascii", "replace") for cell in raw], dtype="S"), False


def _read_alike(read: ClockParts, table: np.ndarray, rows: np.ndarray, length: int, raw: pd.Series) -> np.ndarray:
    """Read the rows whose string has the form of the first one's; return the other rows."""
    line = table[rows[0], :length].tobytes().decode("ascii")
    match, parts = _TIME_OF_DAY.search(line), 3
    if match is None:
        match, parts = _SHORT.search(line), 2
    if match is None:
        return rows[1:] if len(rows) < 64 else rows[:0]
    whole = len(rows) == len(table)
    block = turned(table[:, :length] if whole else table[rows, :length])
    digits = np.zeros(length, bool)
    for group in range(1, match.re.groups + 1):
        if match[group] is not None:
            digits[match.start(group) : match.end(group)] = True
    span = np.zeros(length, bool)
    span[match.start() : match.end()] = True
    first = block[:, 0]
    alike = np.ones(len(rows), bool)
    for position in np.flatnonzero(span):
        cell = block[position]
        alike &= (cell - 48 < 10) if digits[position] else (cell == first[position])
    for edge in (match.start() - 1, match.end()):
        if 0 <= edge < length:
            alike &= ~(block[edge] - 48 < 10)
    if not alike.any():  # not even the first: it holds a digit of no usual kind
        return rows[1:]
    if not alike.all():
        block, chosen, rest = block[:, alike], rows[alike], rows[~alike]
    else:
        chosen, rest = rows, rows[:0]

    def number(group: int) -> np.ndarray:
        total = np.zeros(len(chosen), np.int32)
        for position in range(match.start(group), match.end(group)):
            total = total * np.int32(10) + (block[position] - 48)
        return total

    target: slice | np.ndarray = slice(None) if whole and not len(rest) else chosen
    read.parts[target] = parts
    read.major[target] = number(1)
    read.minor[target] = number(2)
    last = parts if parts == 3 else 2
    fraction, tail = match[last + 1], np.zeros(1)
    if fraction:  # a fourth number behind a colon counts milliseconds: 10:00:01:3 is 3 ms past 10:00:01
        counts_ms = line[match.start(last + 1) - 1] == ":" and len(fraction) <= 3
        tail = number(last + 1) / (1000.0 if counts_ms else 10.0 ** len(fraction))
    read.seconds[target] = number(last) + tail
    read.fraction[target] = bool(fraction)
    # the rest of the string is the date: it changes seldom, so only its changes are looked at
    outside = np.flatnonzero(~span)
    if len(outside):
        changed = np.zeros(len(chosen), bool)
        changed[0] = True
        for position in outside:
            cell = block[position]
            changed[1:] |= cell[1:] != cell[:-1]
        starts = np.flatnonzero(changed)
        known: dict[str, int] = {}
        indices = []
        for start in starts:
            text = str(raw.iloc[chosen[start]]).strip()
            text = f"{text[: match.start()]} {text[match.end() :]}"
            if text not in known:
                known[text] = len(read.texts)
                read.texts.append(text)
            indices.append(known[text])
        read.dates[target] = np.repeat(indices, np.diff([*starts, len(chosen)]))
    return rest


def _date_text(text: str) -> str:
    return re.sub(r"(?<!\d)[+-]\d{2}:?\d{2}\s*$", " ", text)


def from_datetimes(values: Sequence[object]) -> np.ndarray:
    """Convert date, time and duration cells of a spreadsheet to seconds from the first."""
    seconds = np.full(len(values), np.nan)
    for index, value in enumerate(values):
        if isinstance(value, dt.datetime):
            seconds[index] = (value - dt.datetime(1900, 1, 1)).total_seconds()
        elif isinstance(value, dt.timedelta):
            seconds[index] = value.total_seconds()
        elif isinstance(value, dt.time):
            seconds[index] = value.hour * 3600 + value.minute * 60 + value.second + value.microsecond / 1e6
    return Running(DAY if any(isinstance(value, dt.time) for value in values) else None).on(seconds)
