"""Converts time columns to seconds: numbers in any unit, epochs, Excel days, clock strings as loggers write them."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from atleak.common.sentences import Sentence
from atleak.common.units import HHMMSS, Unit, find_unit
from atleak.readers.dates import day_number, half_day, likely_order, sure_date
from atleak.readers.logs.delimited import turned_columns
from atleak.readers.logs.timeline import running, strays_of

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


_DIGITS = "time of day, HHMMSS"
_FACTORS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}


def numeric_clock(values: np.ndarray, unit: str | None, motions: Sequence[Motion] = (), whole: bool = False) -> Clock:
    """Convert numbers to seconds.

    With a unit, that unit. Without: epochs in s, ms, µs or ns and Excel days by their size; otherwise s, or ms
    where whole numbers step by 5 and more and the channels beside it could not move that fast in seconds. ``whole``:
    that all numbers are finite is known.
    """
    values = values.astype(float, copy=False)
    finite = values if whole else values[np.isfinite(values)]
    if not len(finite):
        return Clock(values, unit or "s", unit is None)
    middle = float(np.median(finite[:: max(1, len(finite) // 10_000)]))
    step, epoch = find_unit(unit, "time") if unit else None, _epoch(middle)
    if epoch is not None and (step is None or step.name in ("s", "ms")):
        step = find_unit(epoch, "time")
    if step is not None and step.name == HHMMSS:
        return _clock_of_digits(values)
    if step is not None:
        return _epoch_clock(values, step, middle) if epoch else Clock(_scaled(values, step.factor), step.name)
    part = finite[:_PART]
    part = part[~strays_of(part)]
    if _excel_days(part):
        start = float(part[0])
        day = _FIRST_EXCEL_DAY + dt.timedelta(int(start))
        seconds = np.round(_scaled(values - start, DAY), 6)
        return Clock(seconds, "d", form="Excel days", absolute=True, date=day)
    minutes, leaps = _minutes_of_digits(part)
    if minutes:
        return _clock_of_digits(values)
    name, sure = _guess(finite, values, motions)
    return Clock(_scaled(values, _FACTORS[name]), name, not sure or leaps > 0)


def _scaled(values: np.ndarray, factor: float) -> np.ndarray:
    if factor == 1.0:
        return values
    with np.errstate(over="ignore"):
        seconds = values * factor
    return np.where(np.isinf(seconds), np.nan, seconds)


def _clock_of_digits(values: np.ndarray) -> Clock:
    return Clock(running(_seconds_of_digits(values), DAY), "clock", form=_DIGITS)


def _epoch_clock(values: np.ndarray, unit: Unit, middle: float) -> Clock:
    """Return the clock of an epoch, which counts from the first stamp that lies within a year of the middle one."""
    near = np.flatnonzero(np.abs(values - middle) < YEAR / unit.factor)
    start = float(values[near[0]]) if len(near) else 0.0
    day = dt.date(1970, 1, 1) + dt.timedelta(seconds=start * unit.factor) if len(near) else None
    with np.errstate(over="ignore"):
        # an epoch in double precision is good for a microsecond; far from the others: the clock was not set yet
        seconds = np.round((values - start) * unit.factor, 6)
    seconds = np.where(np.abs(seconds) < YEAR, seconds, np.nan)
    return Clock(seconds, unit.name, form=f"epoch {unit.name}", absolute=True, date=day)


def _epoch(value: float) -> str | None:
    from_then_on = {"s": 1e9, "ms": 1e12, "µs": 1e15, "ns": 1e18}
    return next((unit for unit, low in from_then_on.items() if low <= value < 4 * low), None)


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
    steps, stamps = np.diff(values), _seconds_of_digits(values)
    usual = float(np.median(steps))
    far = np.abs(steps) > 3 * usual
    lone = np.append(far, True) & np.append(True, far)
    if not 0 < usual < 30 or (np.isnan(stamps) & ~lone).any():
        return 0, 0
    good = np.isfinite(stamps)
    steps, true = np.diff(values[good]), np.diff(stamps[good])
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


def _guess(finite: np.ndarray, values: np.ndarray, motions: Sequence[Motion]) -> tuple[str, bool]:
    steps = np.diff(finite[:_PART])
    steps = steps[steps > 0]
    if not len(steps):
        return "s", False
    step = float(np.median(steps))
    whole = all(bool((part == np.round(part)).all()) for part in (finite[:_PART], finite))
    if not whole and step < 2:
        return "s", True
    if step < 2:
        return "s", False
    options = ["ms", "s"] if step >= 20 or (whole and step >= 5) else ["s", "ms"]
    if whole and step >= 3000:
        options = ["µs", "ms", "s"]
    # the slower unit wins only where the faster one is impossible
    for name in options:
        if all(motion.possible(values, _FACTORS[name]) for motion in motions):
            return name, False
    return options[0], False


_THREE = re.compile(r"(?<![\d.,])(\d{1,4}):(\d{1,6}):(\d{1,2})(?:[.,:](\d{1,9}))?")
_TWO = re.compile(r"(?<![\d.,:])(\d{1,3}):(\d{2})(?:[.,](\d{1,6}))?(?![\d:])")


def holds_a_time(text: str) -> bool:
    """Return whether a time of day stands anywhere in a cell.

    >>> holds_a_time("@Wed May  2 10:24:10 2018"), holds_a_time("1:3")
    (True, False)
    """
    return _THREE.search(text) is not None or _TWO.search(text) is not None


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

    def in_halves(self, halves: Sequence[str | None]) -> np.ndarray:
        """Return the hours of a day whose halves the texts name, AM or PM."""
        noon = np.array([{"am": 0.0, "pm": 12.0}.get(half or "", -1.0) for half in halves])[self.dates]
        return np.where(noon >= 0, self.major % 12 + np.maximum(noon, 0), self.major)


_DAMAGED = 1  # cells that cannot be a clock's: of more the column is of another form


def text_clock(column: pd.Series) -> Clock | None:
    """Convert clock strings to seconds from the first one; None when they cannot be read.

    Dates and times of day of every usual form are read, with months and weekdays in seven languages, half days
    (AM, PM), ``hours : total minutes : seconds``, and minutes and seconds whose hour a spreadsheet has cut off: those
    give relative time only.
    """
    read = read_clocks(column)
    three, two = int(np.count_nonzero(read.parts == 3)), int(np.count_nonzero(read.parts == 2))
    if three + two < max(1, 0.5 * int(column.notna().sum())):
        return None
    parts = 3 if three >= two else 2
    good = read.parts == parts
    dates = [re.sub(r"(?<!\d)[+-]\d{2}:?\d{2}\s*$", " ", text) for text in read.texts]  # without a zone
    halves = [half_day(text) for text in read.texts]
    order, beside = likely_order(dates, halves), np.unique(read.dates[good]).tolist()
    days = [day_number(text, order) for text in dates]
    dated = all(days[index] is not None for index in beside)
    form = _three_parts(read, good, dated) if parts == 3 else _two_parts(read, good, dated)
    if form is None:
        return None
    name, (hours, minutes, rest), period, notes = form
    in_halves = (dated or name == _TIME_OF_DAY) and any(halves)
    major = read.in_halves(halves) if in_halves else read.major
    seconds = major * hours + read.minor * minutes + read.seconds * rest
    if parts == 3:
        good = good & (read.seconds < 61) & ((read.minor < 60) | (hours == 0.0))
    seconds = np.where(good, seconds, np.nan)
    absolute = dated and hours > 0.0
    if absolute:
        numbers = np.array([np.nan if day is None else float(day) for day in days])
        seconds += ((numbers - np.nanmin(numbers)) * DAY)[read.dates]
    date = sure_date([read.texts[index] for index in beside]) if dated else None
    return Clock(running(seconds, period), "clock", form=name, notes=notes, absolute=absolute, date=date)


_TIME_OF_DAY = "time of day"
_TextForm = tuple[str, tuple[float, float, float], float | None, tuple[Sentence, ...]]
"""Name of a form of clock, weights [s] of its numbers, the time after which it starts again [s], what is to be said."""


def _three_parts(read: ClockParts, good: np.ndarray, dated: bool) -> _TextForm | None:
    if np.count_nonzero(read.seconds[good] >= 61) > _DAMAGED:
        return None
    if np.count_nonzero(read.minor[good] > 59) > _DAMAGED:
        return "hours : total minutes : seconds", (0.0, 60.0, 1.0), None, ()
    return "date and time" if dated else _TIME_OF_DAY, (3600.0, 60.0, 1.0), None if dated else DAY, ()


def _two_parts(read: ClockParts, good: np.ndarray, dated: bool) -> _TextForm | None:
    if dated:
        note = Sentence(
            "the clock's seconds are lost (a spreadsheet shows hours and minutes only): stamps are 60 s apart"
        )
        return "date and time", (3600.0, 60.0, 0.0), None, (note,)
    if not read.fraction[good].mean() > 0.5 or (read.seconds[good] > 59.9999999).any():
        return None  # hh:mm and mm:ss look the same
    note = Sentence(
        "a spreadsheet has cut the hours off the clock: time runs from the first row, the time of day is not known"
    )
    return "minutes and seconds", (60.0, 0.0, 1.0), 3600.0, (note,)


def read_clocks(column: pd.Series) -> ClockParts:
    """Read the numbers of clock strings, and what stands beside them."""
    size = len(column)
    kinds = {"major": float, "minor": float, "seconds": float, "parts": int, "fraction": bool, "dates": int}
    read = ClockParts(**{name: np.zeros(size, kind) for name, kind in kinds.items()}, texts=[""])
    packed, all_as_long = _packed(column)
    width = packed.dtype.itemsize
    if not width:
        return read
    table = packed.view(np.uint8).reshape(size, width)
    lengths = np.full(size, width) if all_as_long else (table != 0).sum(axis=1)
    for length in np.unique(lengths[lengths > 0]).tolist():
        rows = np.flatnonzero(lengths == length)
        for _ in range(12):  # templates of one length
            rows = _read_alike(read, table, rows, length, column)
            if not len(rows):
                break
    return read


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


class _Form:
    """The form of a clock string: where its numbers and the signs between them stand."""

    def __init__(self, match: re.Match[str]) -> None:
        self.match, self.parts = match, 3 if match.re is _THREE else 2
        groups = [match.span(group) for group in range(1, match.re.groups + 1)]
        self.digits = {place for span in groups for place in range(*span)}
        self.places = range(*match.span())

    @classmethod
    def of(cls, line: str) -> _Form | None:
        """Return the form of a string; None where it holds no clock reading."""
        match = _THREE.search(line) or _TWO.search(line)
        return None if match is None else cls(match)

    def shared_by(self, block: np.ndarray) -> np.ndarray:
        """Return which strings, the columns of a block of bytes, have this form."""
        alike = np.ones(block.shape[1], bool)
        for place in self.places:
            alike &= (block[place] - 48 < 10) if place in self.digits else (block[place] == block[place, 0])
        for edge in (self.places.start - 1, self.places.stop):
            if 0 <= edge < len(block):
                alike &= ~(block[edge] - 48 < 10)
        return alike

    def number(self, block: np.ndarray, group: int) -> np.ndarray:
        """Return the numbers of one group."""
        total = np.zeros(block.shape[1], np.int32)
        for place in range(*self.match.span(group)):
            total = total * np.int32(10) + (block[place] - 48)
        return total

    @property
    def tail_unit(self) -> float | None:
        """Return how many of its last number make a second; None where it is no fraction.

        A fourth number behind a colon counts milliseconds: 10:00:01:3 is 3 ms past 10:00:01.
        """
        fraction = self.match[self.parts + 1]
        if not fraction:
            return None
        counts_ms = self.match.string[self.match.start(self.parts + 1) - 1] == ":" and len(fraction) <= 3
        return 1000.0 if counts_ms else 10.0 ** len(fraction)

    def beside(self, text: str) -> str:
        """Return what stands around the clock reading: the date."""
        return f"{text[: self.places.start]} {text[self.places.stop :]}"


def _read_alike(read: ClockParts, table: np.ndarray, rows: np.ndarray, length: int, raw: pd.Series) -> np.ndarray:
    """Read the rows whose string has the form of the first one's; return the other rows."""
    form = _Form.of(table[rows[0], :length].tobytes().decode("ascii"))
    if form is None:
        return rows[1:] if len(rows) < 64 else rows[:0]
    whole = len(rows) == len(table)
    block = turned_columns(table[:, :length] if whole else table[rows, :length])
    alike = form.shared_by(block)
    if not alike.any():  # not even the first: it holds a digit of no usual kind
        return rows[1:]
    rest = rows[:0]
    if not alike.all():
        block, rows, rest = block[:, alike], rows[alike], rows[~alike]
    target: slice | np.ndarray = slice(None) if whole and not len(rest) else rows
    read.parts[target] = form.parts
    read.major[target] = form.number(block, 1)
    read.minor[target] = form.number(block, 2)
    unit = form.tail_unit
    tail = np.zeros(1) if unit is None else form.number(block, form.parts + 1) / unit
    read.seconds[target] = form.number(block, form.parts) + tail
    read.fraction[target] = unit is not None
    # the rest of the string is the date: it changes seldom, so only its changes are looked at
    outside = [place for place in range(length) if place not in form.places]
    if outside:
        changed = np.zeros(len(rows), bool)
        changed[0] = True
        for place in outside:
            changed[1:] |= block[place, 1:] != block[place, :-1]
        starts = np.flatnonzero(changed)
        texts = [form.beside(str(raw.iloc[row]).strip()) for row in rows[starts]]
        codes, different = pd.factorize(np.array(texts, object))
        read.dates[target] = np.repeat(len(read.texts) + codes, np.diff([*starts, len(rows)]))
        read.texts += different.tolist()
    return rest


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
    return running(seconds, DAY if any(isinstance(value, dt.time) for value in values) else None)
