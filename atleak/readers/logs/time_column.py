"""Chooses a table's time column and reads it."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from atleak.common.errors import RoadTestError
from atleak.common.sentences import Sentence, in_a_row
from atleak.readers.logs import clock as clocks
from atleak.readers.logs.clock import Clock, Motion
from atleak.readers.logs.columns import Assigner, Candidate
from atleak.readers.logs.delimited import Cells, numbers
from atleak.readers.logs.headings import nameless
from atleak.readers.logs.log_cells import HOLDS, TEXT, cause, is_clock, is_destroyed, to_float
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.names import split_unit
from atleak.readers.logs.rows import LogRows
from atleak.readers.logs.units import given


def motions_beside(channels: list[Candidate], columns: Mapping[int, np.ndarray]) -> list[Motion]:
    """Return the speeds in the log, whose changes show whether a unit of time is possible."""
    limits = {"engine_speed": 12000.0, "vehicle_speed": 60.0}
    return [
        Motion(columns[candidate.heading.index], limits[candidate.quantity])
        for candidate in channels
        if candidate.quantity in limits
    ]


def clock_of(
    candidate: Candidate, frame: pd.DataFrame, table: LogTable, assigner: Assigner, motions: Sequence[Motion]
) -> Clock | None:
    """Read a time column; None where it cannot be read, which a message explains where a spreadsheet has spoilt it."""
    column = frame[candidate.heading.index]
    if column.dtype.kind == "M":  # dates with times, as Parquet files and workbooks hold them
        stamps = column.dropna()
        if not len(stamps):
            return Clock(np.full(len(column), np.nan), "clock", form="date and time")
        seconds = np.round((column - stamps.iloc[0]).dt.total_seconds().to_numpy(), 9)
        return Clock(seconds, "clock", form="date and time", date=stamps.iloc[0].date())
    some = column.head(50).dropna().tolist() if column.dtype == object else []
    if some and isinstance(some[0], dt.datetime | dt.time | dt.timedelta):
        cells = column.tolist()
        # a cell of a time alone is a datetime in the year 1899 or 1900
        first = next((cell.date() for cell in cells if isinstance(cell, dt.datetime) and cell.year > 1900), None)
        return Clock(clocks.from_datetimes(cells), "clock", False, "date and time", date=first)
    if column.dtype.kind not in "fiub":
        texts = column.dropna().astype("str")
        probe = [*texts.iloc[:200].tolist(), *texts.iloc[-50:].tolist()]
        reads = clocks.holds_a_time if candidate.mapped else is_clock
        if sum(map(reads, probe)) > 0.5 * len(probe):
            return clocks.text_clock(column)
        if (destroyed := next(filter(is_destroyed, probe), None)) is not None:
            text = Sentence("{column!r}: a spreadsheet has destroyed its numbers ({found})")
            assigner.say("column_refused", text, "warning", candidate.label, found=destroyed)
            return None
    read = numbers(frame, candidate.heading.index, table.decimal)
    return _clock_of_numbers(candidate, read, table, assigner, motions)


def _clock_of_numbers(
    candidate: Candidate, cells: Cells, table: LogTable, assigner: Assigner, motions: Sequence[Motion]
) -> Clock | None:
    values, words = cells
    whole = len(values) > 0 and bool(np.isfinite(values).all())
    if len(words) > 0.05 * len(values) or (not whole and np.isfinite(values).sum() < 0.5 * len(values)):
        if len(words):  # say what is wrong with its numbers, where they are any
            what, example = cause(words, values[:: max(1, len(values) // 50_000)], table.decimal)
            if what != TEXT:
                assigner.say("column_refused", HOLDS, "warning", candidate.label, what=what, found=example)
        return None
    sampled = [cell for cell in table.sampled(candidate.heading.index) if cell]
    destroyed = list(filter(is_destroyed, sampled))
    if len(destroyed) > 0.3 * len(sampled):  # only three digits of a long number are left, such as 1,51E+12
        text = Sentence("{column!r}: a spreadsheet has cut its numbers short ({found})")
        assigner.say("column_refused", text, "warning", candidate.label, found=destroyed[0])
        return None
    unit = assigner.units.get("time", candidate.unit)
    if "time" in assigner.units and (stated := given("time", assigner.units["time"]).unit) is not None:
        unit = stated.name
    clock = clocks.numeric_clock(values, unit, motions if whole else [], whole)
    if clock.form.startswith("epoch") and _rounded(clock.seconds):
        text = Sentence("{column!r}: a spreadsheet has cut its numbers short: few stamps differ")
        assigner.say("column_refused", text, "warning", candidate.label)
        return None
    return clock


_COARSE = 600.0  # [s] between stamps that only rounding explains


def _rounded(seconds: np.ndarray) -> bool:
    """Return whether an epoch keeps so few digits that many rows share each stamp and the next is far off."""
    steps = np.diff(seconds)
    onward = steps[steps > 0]
    return len(seconds) >= 8 and 4 * len(onward) < len(seconds) and not (onward < _COARSE).any()


def best_clock(
    times: list[Candidate], rows: LogRows, table: LogTable, assigner: Assigner, motions: Sequence[Motion]
) -> tuple[str, Clock]:
    """Return the name and the clock of the time column that serves best, or a clock counted from the interval.

    The interval is the one that the user states, else that of the lines above the table.
    """
    readable: list[tuple[Candidate, Clock]] = []
    for candidate in times:
        before = len(assigner.messages)
        clock = clock_of(candidate, rows.frame, table, assigner, motions)
        if clock is not None and runs_of_rows(clock.seconds):
            readable.append((candidate, clock))
            if candidate.mapped:
                break
        elif clock is not None and _starts_again(clock.seconds):
            text = Sentence("{column!r} starts again every few rows")
            assigner.say("column_refused", text, "warning", candidate.label)
        elif candidate.mapped and len(assigner.messages) == before:
            cell = next(iter(table.sampled(candidate.heading.index)), "")
            text = Sentence("{column!r} tells no time that runs on ({found})")
            assigner.say("column_refused", text, "warning", candidate.label, found=cell)
    if not readable:
        return "", _counted(table, assigner, rows)
    best = _best(readable)
    if len(readable) > 1:
        _compare_clocks(best, readable, assigner)
    _ask_where_it_cannot_be(*best, table, assigner)
    for note in best[1].notes:
        assigner.say("clock", note, "warning", best[0].label)
    if best[1].unit_assumed:
        assigner.assume_unit(best[0].label, best[1].unit, "time")
    return best[0].label, best[1]


def _best(readable: list[tuple[Candidate, Clock]]) -> tuple[Candidate, Clock]:
    """Return the clock that serves best: what the user names, no counter of rows, no coarse or second clock."""
    if len(readable) == 1:
        return readable[0]
    rises = [int(np.count_nonzero(np.diff(clock.seconds[np.isfinite(clock.seconds)]) > 0)) for _, clock in readable]

    def worth(place: int) -> tuple[bool, bool, int, bool, int]:
        candidate, clock = readable[place]
        part = clock.seconds[:10_000]
        counts_rows = len(part) > 2 and bool((np.diff(part) == 1).all())  # no time, perhaps
        return candidate.mapped, 2 * rises[place] >= max(rises), -candidate.tier, not counts_rows, rises[place]

    return readable[max(range(len(readable)), key=worth)]


def _counted(table: LogTable, assigner: Assigner, rows: LogRows) -> Clock:
    """Return a clock that counts rows by the interval that is stated."""
    stated = assigner.interval
    interval = _interval_in_preamble(table) if stated is None else stated
    if interval is None:
        raise no_time(table, assigner)
    text = Sentence("no time column: time is counted from the interval in the file's head ({interval:g} s)")
    if stated is not None:
        text = Sentence("no time column: time is counted from the stated interval ({interval:g} s)")
    assigner.say("time_counted", text, interval=interval)
    return Clock(rows.places * interval, "s", False, "counted")


_BRIEF = 1.0  # [s]: no road test is shorter
_LEAST_ROWS = 8


def _ask_where_it_cannot_be(candidate: Candidate, clock: Clock, table: LogTable, assigner: Assigner) -> None:
    """Ask about a clock in ms by which the whole log takes less than a second: it may be another time, of injection."""
    if candidate.mapped or "time" in assigner.units or clock.unit not in ("ms", "µs", "ns"):
        return
    part, other, span = clock.seconds[:_SOME], rising_without_name(table), _span(clock.seconds)
    if clock.absolute or np.isfinite(part).sum() < _LEAST_ROWS or not (span < _BRIEF or (other and span < 10 * _BRIEF)):
        return
    problem = Sentence(
        "by {column!r}, in {unit}, the whole log takes {span:g} s: that may be another time than the clock's"
    )
    problem = problem.of(column=candidate.label, unit=clock.unit, span=span)
    expected = Sentence("the column of the time, such as time = {column!r}", column=other or candidate.label)
    raise assigner.error(problem, expected=expected, column=candidate.label)


def rising_without_name(table: LogTable) -> str | None:
    """Return the first column without a name whose numbers rise from row to row, other than by one; else None."""
    for heading in table.headings[: table.width]:
        if nameless(heading):
            cells = [to_float(cell, table.decimal) for cell in table.sampled(heading.index)]
            steps = np.diff([cell for cell in cells if cell == cell])
            if len(steps) >= _LEAST_ROWS and bool((steps > 0).all()) and not (steps == 1).all():
                return f"column {heading.index + 1}"
    return None


_SOME = 1_000_000  # rows that show it


def _span(seconds: np.ndarray) -> float:
    """Return the time from the least stamp to the greatest [s]."""
    finite = seconds[np.isfinite(seconds)]
    return float(np.ptp(finite)) if len(finite) else 0.0


def _starts_again(seconds: np.ndarray) -> bool:
    """Return whether a clock rises and falls back to where it began, again and again."""
    finite = seconds[:_SOME][np.isfinite(seconds[:_SOME])]
    falls = np.diff(finite) < 0
    return len(finite) > _LEAST_ROWS and bool(np.mean(falls) > 0.1 and np.ptp(finite[1:][falls]) < 0.1 * np.ptp(finite))


def runs_of_rows(seconds: np.ndarray) -> bool:
    """Return whether a clock runs on: its time passes, and seldom steps back."""
    if len(seconds) < 2:
        return len(seconds) == 1 and bool(np.isfinite(seconds[0]))
    onward = bool(seconds[-1] > seconds[0])  # usually saves comparing all stamps
    if not onward and not _span(seconds) > 0.0:
        return False
    steps = np.diff(seconds[:200_000])
    return bool(np.count_nonzero(steps < 0) <= 0.3 * len(steps))


def _compare_clocks(best: tuple[Candidate, Clock], readable: list[tuple[Candidate, Clock]], assigner: Assigner) -> None:
    span = _span(best[1].seconds)
    for candidate, clock in readable:
        other = _span(clock.seconds)
        if candidate is not best[0] and abs(other - span) > max(2.0, 0.02 * span):
            text = Sentence(
                "the clocks {first!r} and {second!r} disagree ({span:.1f} s and {other:.1f} s): the first is used"
            )
            text = text.of(first=best[0].label, second=candidate.label, span=span, other=other)
            assigner.say("clocks_disagree", text, "warning", best[0].label)


_INTERVAL = re.compile(
    r"^(delta[_ ]?[xt]|wf_increment|sample ?interval|sampling ?interval|interval|increment|dt|abtastintervall"
    r"|messintervall|okres próbkowania)\b",
    re.IGNORECASE,
)
_RATE = re.compile(
    r"^(sample[_ ]?rate|sampling[_ ]?rate|sampling[_ ]?frequency|sample[_ ]?frequency|abtastrate|abtastfrequenz"
    r"|częstotliwość próbkowania)\b",
    re.IGNORECASE,
)


def _interval_in_preamble(table: LogTable) -> float | None:
    """Return the sampling interval [s] that the lines above the table state, or None."""
    for row in table.layout.preamble:
        cells = [*re.split(r"[:=]", row[0], maxsplit=1), *row[1:]] if row else []
        cells = [cell.strip() for cell in cells if cell.strip()]
        if len(cells) < 2:
            continue
        number = next((to_float(cell.split()[0], table.decimal) for cell in cells[1:] if cell.split()), float("nan"))
        if not number > 0:
            continue
        name = split_unit(cells[0])
        unit = name.unit or (cells[1].split()[1] if len(cells[1].split()) > 1 else "")
        if _INTERVAL.match(name.text):
            return number * (1e-3 if unit.lower() in ("ms", "msec") else 1.0)
        if _RATE.match(name.text):
            return 1.0 / (number * (1e3 if unit.lower() == "khz" else 1.0))
    return None


def no_time(table: LogTable, assigner: Assigner) -> RoadTestError:
    """Return the error that says why the table has no time."""
    refused = [message.text for message in assigner.messages if message.code == "column_refused"]
    problem = Sentence("no time column")
    if refused:
        problem = Sentence("{problem}: {why}", problem=problem, why=in_a_row(refused))
    expected = Sentence(
        "a column such as 'Time (s)', the name of the one that tells the time, or the interval between rows"
    )
    return assigner.error(problem, ", ".join(heading.label for heading in table.headings[:12]), expected)
