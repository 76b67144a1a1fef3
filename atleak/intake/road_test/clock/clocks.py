"""Converts time columns to seconds: numbers in any unit, epochs, Excel days, clock strings as loggers write them."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from atleak.intake.dates import day_number, half_day, likely_order, sure_date
from atleak.intake.road_test.blocks import turned
from atleak.intake.units import Unit, find_unit
from atleak.sentence import Sentence

DAY = 86400.0
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

    def possible(self, seconds: np.ndarray) -> bool:
        """Return whether the channel's changes are possible in that time."""
        step, change = np.diff(seconds), np.abs(np.diff(self.values))
        use = (step > 0) & (change > 0)
        if use.sum() < 5:
            return True
        return bool(np.percentile(change[use] / step[use], 75) <= self.limit)


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
    first = float(finite[0])
    known = find_unit(unit, "time") if unit else None
    middle = float(np.median(finite[:: max(1, len(finite) // 10_000)]))
    if known is not None and known.name in ("s", "ms") and _epoch(middle) not in (None, known.name):
        known = find_unit(str(_epoch(middle)), "time")
    epoch = _epoch(middle)
    if known is None and epoch:
        known = find_unit(epoch, "time")
        assert known is not None
        return _epoch_clock(values, known)
    part = finite[:_PART]
    if known is None and _excel_days(part):
        day = _FIRST_EXCEL_DAY + dt.timedelta(int(first))
        return Clock(np.round((values - first) * DAY, 6), "d", False, "Excel days", (), True, day)
    if known is not None:
        if epoch:
            return _epoch_clock(values, known)
        return Clock(values if known.factor == 1.0 else values * known.factor, known.name)
    if _digits_of_a_clock(part):
        return Clock(_relative(_unwrap(_seconds_of_digits(values), DAY)), "clock", False, "time of day, HHMMSS")
    name, sure = _guess(finite, values, motions)
    factor = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}[name]
    return Clock(values if factor == 1.0 else values * factor, name, not sure)


def _epoch_clock(values: np.ndarray, unit: Unit) -> Clock:
    finite = values[np.isfinite(values) & (values > 0)]
    start = float(finite[0]) if len(finite) else 0.0
    seconds = np.round((values - start) * unit.factor, 6)  # an epoch in double precision is good for a microsecond
    seconds = np.where(values > 0, seconds, np.nan)  # an epoch of zero: the clock was not set yet
    day = dt.date(1970, 1, 1) + dt.timedelta(seconds=start * unit.factor) if start else None
    return Clock(seconds, unit.name, False, f"epoch {unit.name}", (), True, day)


def _epoch(value: float) -> str | None:
    for low, unit in ((1e9, "s"), (1e12, "ms"), (1e15, "µs"), (1e18, "ns")):
        if low <= value < 4e9 * low / 1e9:
            return unit
    return None


def _seconds_of_digits(values: np.ndarray) -> np.ndarray:
    """Return the seconds since midnight of numbers whose digits are those of a clock: 100059.5 is 10:00:59.5."""
    minutes, hours = values // 100 % 100, values // 10_000
    return hours * 3600 + minutes * 60 + np.round(values % 100, 6)


def _digits_of_a_clock(values: np.ndarray) -> bool:
    """Return whether numbers are the digits HHMMSS of a clock: none has 60 seconds or minutes, and they leap there."""
    if len(values) < 3 or values.min() < 0 or values.max() >= 240_000 or (values % 100 >= 60).any():
        return False
    if (values // 100 % 100 >= 60).any():
        return False
    steps, true = np.diff(values), np.diff(_seconds_of_digits(values))
    true = np.where(true < -DAY / 2, true + DAY, true)  # past midnight
    usual = float(np.median(steps))
    leaps = np.abs(steps - true) > 1
    if not 0 < usual < 30 or not leaps.any():
        return False
    # where the number leaps, the clock goes on as usual: a recording with gaps does not
    return bool(np.mean((true[leaps] >= 0) & (true[leaps] <= 3 * usual)) > 0.7)


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
    whole = bool(np.all(finite == np.round(finite)))
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
        if all(motion.possible(values * factor) for motion in motions):
            return name, False
    return options[0], False


# --- clock strings ------------------------------------------------------------------------------------------

_TIME_OF_DAY = re.compile(r"(?<![\d.,])(\d{1,4}):(\d{1,6}):(\d{1,2})(?:[.,:](\d{1,9}))?")
_SHORT = re.compile(r"(?<![\d.,:])(\d{1,3}):(\d{2})(?:[.,](\d{1,6}))?(?![\d:])")


@dataclass
class _ClockParts:
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
    read = _read(column)
    good = read.parts > 0
    if good.sum() < max(1, 0.5 * column.notna().sum()):
        return None
    parts = 3 if (read.parts == 3).sum() >= (read.parts == 2).sum() else 2
    good &= read.parts == parts
    dates = [_date_text(text) for text in read.texts]
    order = likely_order(dates, [half_day(text) for text in read.texts])
    days = [day_number(text, order) for text in dates]
    halves = [half_day(text) for text in read.texts]
    used = set(np.flatnonzero(np.bincount(read.dates[good])).tolist())
    dated = bool(used) and all(days[index] is not None for index in used)
    as_parts = _three_parts if parts == 3 else _two_parts
    clock = as_parts(read, good, days if dated else None, halves)
    if clock is None or not dated:
        return clock
    return replace(clock, date=sure_date([read.texts[index] for index in sorted(used)]))


def _three_parts(
    read: _ClockParts, good: np.ndarray, days: list[int | None] | None, halves: list[str | None]
) -> Clock | None:
    minor_max = read.minor[good].max()
    if (read.seconds[good] >= 61).any():
        return None
    if minor_max > 59:  # hours : total minutes : seconds
        seconds = np.where(good, read.minor * 60.0 + read.seconds, np.nan)
        return Clock(_relative(seconds), "clock", False, "hours : total minutes : seconds")
    hours = _with_half_days(read, halves)
    seconds = np.where(good, hours * 3600.0 + read.minor * 60.0 + read.seconds, np.nan)
    if days is not None:
        seconds = seconds + _days_of(read, days)
        return Clock(_relative(seconds), "clock", False, "date and time", (), True)
    return Clock(_relative(_unwrap(seconds, DAY)), "clock", False, "time of day")


def _two_parts(
    read: _ClockParts, good: np.ndarray, days: list[int | None] | None, halves: list[str | None]
) -> Clock | None:
    if days is not None:
        hours = _with_half_days(read, halves)
        seconds = np.where(good, hours * 3600.0 + read.minor * 60.0, np.nan) + _days_of(read, days)
        note = Sentence(
            "the clock's seconds are lost (a spreadsheet shows hours and minutes only): stamps are 60 s apart"
        )
        return Clock(_relative(seconds), "clock", False, "date and time", (note,), True)
    if not read.fraction[good].mean() > 0.5 or (read.seconds[good] > 59.9999999).any():
        return None  # hh:mm and mm:ss look the same
    seconds = np.where(good, read.major * 60.0 + read.seconds, np.nan)
    note = Sentence(
        "a spreadsheet has cut the hours off the clock: time runs from the first row, the time of day is not known"
    )
    return Clock(_relative(_unwrap(seconds, 3600.0)), "clock", False, "minutes and seconds", (note,))


def _with_half_days(read: _ClockParts, halves: list[str | None]) -> np.ndarray:
    if not any(halves):
        return read.major
    noon = np.array([{"am": 0.0, "pm": 12.0}.get(half or "", -1.0) for half in halves])[read.dates]
    return np.where(noon >= 0, read.major % 12 + np.maximum(noon, 0), read.major)


def _days_of(read: _ClockParts, days: list[int | None]) -> np.ndarray:
    numbers = np.array([np.nan if day is None else float(day) for day in days])
    first = np.nanmin(numbers)
    return (numbers - first)[read.dates] * DAY


def _relative(seconds: np.ndarray) -> np.ndarray:
    finite = seconds[np.isfinite(seconds)]
    return np.round(seconds - finite[0], 9) if len(finite) else seconds


def _unwrap(seconds: np.ndarray, period: float) -> np.ndarray:
    """Continue a clock that starts again after each period: a fall by more than half a period adds one."""
    good = np.isfinite(seconds)
    values = seconds[good]
    falls = np.concatenate([[0], np.cumsum(np.diff(values) < -period / 2)])
    result = seconds.copy()
    result[good] = values + falls * period
    return result


def _read(column: pd.Series) -> _ClockParts:
    size = len(column)
    read = _ClockParts(
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


def _read_alike(read: _ClockParts, table: np.ndarray, rows: np.ndarray, length: int, raw: pd.Series) -> np.ndarray:
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
    fraction = match[last + 1]
    tail = number(last + 1) / 10.0 ** len(fraction) if fraction else 0.0
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
    if any(isinstance(value, dt.time) for value in values):
        seconds = _unwrap(seconds, DAY)
    return _relative(seconds)
