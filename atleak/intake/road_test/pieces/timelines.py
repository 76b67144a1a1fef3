"""Makes the time base of a large log, as `atleak.intake.road_test.clock.timeline` makes that of one that is held."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from atleak.columns import DiskColumn, median_of, positive, spans, steps_of
from atleak.errors import Place, RoadTestError
from atleak.intake.road_test.blocks import ends_of_steps, steps_over
from atleak.intake.road_test.clock.timeline import (
    Timeline,
    an_end_is_far,
    gap_limit_of,
    restarts,
    stray_ends,
    strays_among,
)
from atleak.intake.road_test.pieces.spool import Spool
from atleak.sentence import Sentence

PIECE = 1 << 19
"""Rows that are looked at together."""
OF_CLOCK = 5
"""Columns that a clock takes at most while the time base is made."""
_FALLS = 1_000_000  # rows before a fall of the clock, at most
_OUT_OF_TURN = 4_000_000  # rows that stand out of turn together, at most


@dataclass(frozen=True, eq=False)
class LargeTimeline:
    """The time base of a large log.

    ``order`` holds the number of the row behind every stamp (None: all rows as they stand), ``begins`` the first stamp
    of every segment. ``told`` is what is to be said of it: neither its stamps nor its segments stand there.
    """

    time: DiskColumn
    order: DiskColumn | None
    begins: np.ndarray
    told: Timeline

    @cached_property
    def stretches(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the first and the last stamp of every segment [s]."""
        firsts, lasts = np.empty(len(self.begins)), np.empty(len(self.begins))
        stops = np.append(self.begins[1:], len(self.time))
        for start, stop in spans(len(self.time), PIECE):
            time = self.time[start:stop]
            for places, stamps in ((self.begins, firsts), (stops - 1, lasts)):
                low, high = np.searchsorted(places, (start, stop))
                stamps[low:high] = time[places[low:high] - start]
        return firsts, lasts

    def begun(self, start: int, stop: int) -> np.ndarray:
        """Return for some stamps when their segment begins [s]."""
        firsts, _ = self.stretches
        begun: np.ndarray = firsts[np.searchsorted(self.begins, np.arange(start, stop), side="right") - 1]
        return begun

    def rows(self, column: DiskColumn, start: int, stop: int) -> np.ndarray:
        """Return what a column of the rows of the file holds at some stamps."""
        if self.order is None:
            part: np.ndarray = column[start:stop]
            return part
        rows = self.order[start:stop]
        low = int(rows.min(initial=len(column)))
        near: np.ndarray = column[low : int(rows.max(initial=-1)) + 1]
        return near[rows - low]


def build(seconds: DiskColumn, spool: Spool) -> LargeTimeline:
    """Build time base and segments from stamps in file order, as `clock.timeline.build` does.

    Raises
    ------
    RoadTestError
        where rows are out of turn by the million.
    """
    ends = ends_of_steps(seconds)
    if ends is not None and ends[0] >= 0 and not an_end_is_far(seconds):
        return _finished(seconds, None, longest=ends[1])
    stamps, rows = _readable(seconds, spool)
    unreadable, readable = len(seconds) - len(stamps), len(stamps)
    stamps, rows = _without_strays(stamps, rows, spool)
    stale = readable - len(stamps)
    ends = ends_of_steps(stamps)
    if ends is None or ends[0] >= 0:
        return _finished(stamps, rows, unreadable=unreadable, stale=stale)
    median, falls = _usual(stamps), _falls(stamps, spool.file)
    starts = restarts(stamps, falls, median)
    time, order, reordered = _in_order(stamps, rows, starts, falls, median, spool)
    return _finished(time, order, unreadable=unreadable, stale=stale, reordered=reordered, breaks=tuple(starts))


def _readable(seconds: DiskColumn, spool: Spool) -> tuple[DiskColumn, DiskColumn]:
    """Return the stamps that are readable, and their rows."""
    stamps, rows = spool.column(), spool.column(np.int64)
    for start, stop in spans(len(seconds), PIECE):
        here = seconds[start:stop]
        good = np.flatnonzero(np.isfinite(here))
        stamps.append(here[good])
        rows.append(start + good)
    return stamps, rows


def _without_strays(stamps: DiskColumn, rows: DiskColumn, spool: Spool) -> tuple[DiskColumn, DiskColumn]:
    """Return the stamps that are not stray, and their rows, in place of these columns."""
    if len(stamps) < 4:
        return stamps, rows
    kept, numbers, median = spool.column(), spool.column(np.int64), _usual(stamps)
    first_is_stray, last_is_stray = stray_ends(stamps[:4], stamps[-4:], median)
    for start, stop in spans(len(stamps), PIECE):
        low = max(start - 1, 0)
        around = stamps[low : stop + 1]
        stray = strays_among(around, median) if len(around) > 2 else np.zeros(len(around), bool)
        if not start:
            stray[0] = first_is_stray
        if stop == len(stamps):
            stray[-1] = last_is_stray
        here = slice(start - low, stop - low)
        kept.append(around[here][~stray[here]])
        numbers.append(rows[start:stop][~stray[here]])
    stamps.remove()
    rows.remove()
    return kept, numbers


def _usual(stamps: DiskColumn) -> float:
    """Return the median step forwards; 0 where there is none."""
    median = median_of(positive(steps_of(stamps, length=PIECE)))
    return 0.0 if np.isnan(median) else median


def _falls(stamps: DiskColumn, file: str) -> np.ndarray:
    """Return the places behind which the clock falls."""
    places: list[np.ndarray] = []
    for start, stop in spans(len(stamps) - 1, PIECE):
        places.append(start + np.flatnonzero(np.diff(stamps[start : stop + 1]) < 0))
        if sum(map(len, places)) > _FALLS:
            raise _out_of_turn(file)
    return np.concatenate(places)


def _out_of_turn(file: str) -> RoadTestError:
    problem = Sentence("its rows stand out of turn by the million")
    return RoadTestError(problem, place=Place(file=file), expected=Sentence("rows in the order of their time"))


def _in_order(
    stamps: DiskColumn, rows: DiskColumn, starts: list[int], falls: np.ndarray, median: float, spool: Spool
) -> tuple[DiskColumn, DiskColumn, int]:
    """Put stretches one behind the other, and the stamps of each in order; return how many stood out of turn."""
    time, order = spool.column(), spool.column(np.int64)
    turns = np.setdiff1d(falls, np.array(starts, int) - 1)  # falls within a stretch
    end: float | None = None
    highest = last = -np.inf
    for low, high in zip([0, *starts], [*starts, len(stamps)], strict=True):
        sorted_ = bool(np.searchsorted(turns, high - 1) - np.searchsorted(turns, low))
        pieces = (
            _sorted_pieces(stamps, rows, low, high, spool.file) if sorted_ else _as_they_are(stamps, rows, low, high)
        )
        shift: float | None = None
        for part, numbers in pieces:
            if shift is None and end is not None:
                shift = end + median - float(part[0])
            moved = part if shift is None else part + shift
            last = float(moved[-1])
            # a stretch that was moved may begin a rounding error too early
            moved = np.maximum(np.maximum.accumulate(moved), highest)
            highest = float(moved[-1])
            time.append(moved)
            order.append(numbers)
        end = last
    stamps.remove()
    rows.remove()
    return time, order, len(turns)


def _as_they_are(stamps: DiskColumn, rows: DiskColumn, low: int, high: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for start, stop in spans(high - low, PIECE):
        yield stamps[low + start : low + stop], rows[low + start : low + stop]


def _sorted_pieces(
    stamps: DiskColumn, rows: DiskColumn, low: int, high: int, file: str
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the stamps of a stretch in ascending order, and their rows; equal ones as they stand."""
    pieces = [(low + start, low + stop) for start, stop in spans(high - low, PIECE)]
    least = [float(stamps[start:stop].min()) for start, stop in pieces]
    behind = np.append(np.minimum.accumulate(least[::-1])[::-1][1:], np.inf)  # the least of all later pieces
    held, numbers = np.empty(0), np.empty(0, np.int64)
    for (start, stop), bound in zip(pieces, behind.tolist(), strict=True):
        held = np.concatenate([held, stamps[start:stop]])
        numbers = np.concatenate([numbers, rows[start:stop]])
        ranks = np.argsort(held, kind="stable")
        held, numbers = held[ranks], numbers[ranks]
        ready = int(np.searchsorted(held, bound, side="right"))
        if len(held) - ready > _OUT_OF_TURN:
            raise _out_of_turn(file)
        if ready:
            yield held[:ready], numbers[:ready]
        held, numbers = held[ready:], numbers[ready:]


def _finished(
    time: DiskColumn,
    order: DiskColumn | None,
    *,
    longest: float = np.inf,
    unreadable: int = 0,
    stale: int = 0,
    reordered: int = 0,
    breaks: tuple[int, ...] = (),
) -> LargeTimeline:
    nothing = np.empty(0)
    if not len(time):
        return LargeTimeline(time, order, np.empty(0, int), Timeline(nothing, None, (), 0.0, unreadable, stale))
    limit = gap_limit_of(time)
    gaps = steps_over(time, limit) + 1 if longest > limit else np.empty(0, int)
    only_gaps = np.setdiff1d(gaps, np.array(breaks, int))
    lengths = tuple(float(time[place] - time[place - 1]) for place in only_gaps.tolist())
    lost = sum(float(time[place] - time[place - 1]) for place in breaks)
    duration = float(time[-1]) - float(time[0]) - lost
    told = Timeline(nothing, None, (), duration, unreadable, stale, reordered, len(breaks), lengths)
    begins = np.unique(np.concatenate([[0], gaps, np.array(breaks, int)])).astype(int)
    return LargeTimeline(time, order, begins, told)
