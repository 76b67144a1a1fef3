"""Draw the charts of bars: shares of lands, two visits side by side, pressures held."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from atleak.look import PAPER, look_of
from atleak.report.printed_charts.surface import SMALL, WIDTH, Scale, Surface, widest
from atleak.report.printed_fonts import fitting
from atleak.verdicts import Band, Verdict
from atleak.views.pressures import HeldPressure, PressuresAt
from atleak.wording import Wording
from atleak.workshop_units import KPA

_TOP = 4.0
_BELOW = 32.0  # of the field, for the axis and its title
_NAMES = 220.0  # most that the names of rows take


@dataclass(frozen=True)
class Bar:
    """One land in the chart of shares, in percent; ``low`` and ``high`` where the uncertainty is known."""

    label: str
    share: float
    verdict: Verdict
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class TwoBars:
    """One condition in the chart of two visits, shares in percent."""

    label: str
    shares: tuple[float, float]  # before and after
    verdicts: tuple[Verdict, Verdict]
    intervals: tuple[tuple[float, float] | None, tuple[float, float] | None]
    new: float  # of the same unit new
    levels: tuple[tuple[Band, float], ...]  # where each band begins


class _Rows:
    """A surface of rows, each with its name, over one axis; ``words`` is the room that is kept right of the axis."""

    def __init__(self, names: Sequence[str], height: float, ends: Sequence[float], words: float) -> None:
        left = min(widest(names), _NAMES) + 7.0
        high = max((end for end in ends if math.isfinite(end)), default=0.0)
        self.height, self.bottom = height, _TOP + height * max(len(names), 1)
        self.scale = Scale(0.0, high or 1.0, left, WIDTH - words)
        self.surface = Surface(self.bottom + _BELOW)
        self._names = names

    def draw(self, title: str, say: Wording) -> None:
        """Draw the axis and the names, before anything else."""
        self.surface.across(self.scale, _TOP, self.bottom, lambda value: say.plain(value, 5), title)
        self.surface.line([(self.scale.start, _TOP), (self.scale.start, self.bottom)], width=0.6)
        for row, name in enumerate(self._names):
            at = (self.scale.start - 5.0, self.middle(row))
            self.surface.words(at, fitting(name, SMALL, _NAMES), size=SMALL, anchor="end")

    def middle(self, row: int) -> float:
        """Return the middle of a row."""
        return _TOP + self.height * (row + 0.5)

    def interval(self, low: float, high: float, middle: float) -> float:
        """Draw an interval, to the edge where it has no end; return where it ends."""
        end = self.scale(min(high, self.scale.high))
        self.surface.interval(self.scale(low), end, middle)
        return end


def shares_chart(bars: Sequence[Bar], label: str, say: Wording) -> str:
    """Draw the lands that leak most, the largest on top, each in the shade of its verdict."""
    ends = [end for bar in bars for end in (bar.share, bar.high or 0.0)]
    rows = _Rows([bar.label for bar in bars], 15.0, ends, words=34.0)
    rows.draw(label, say)
    for row, bar in enumerate(bars):
        middle = rows.middle(row)
        end = rows.scale(bar.share)
        rows.surface.bar(rows.scale.start, end, middle, 10.0, look_of(bar.verdict))
        if bar.low is not None and bar.high is not None and math.isfinite(bar.low):
            end = max(end, rows.interval(bar.low, bar.high, middle))
        rows.surface.words((end + 5.0, middle), say.number(bar.share, 2), size=SMALL)
    return rows.surface.svg()


def two_visits_chart(visits: Sequence[TwoBars], label: str, say: Wording) -> str:
    """Draw the share at each condition before, on top, and after, each in the shade of its band.

    A line is the 95 % interval, the upright mark is the unit new, signs show where a band begins.
    """
    ends = [end for row in visits for end in (*row.shares, row.new, *(e for span in row.intervals for e in span or ()))]
    said = {when: say(f"comparison.{when}").lower() for when in ("before", "after")}
    rows = _Rows([row.label for row in visits], 36.0, ends, words=widest(said.values()) + 40.0)
    rows.draw(label, say)
    for number, row in enumerate(visits):
        middle = rows.middle(number)
        bars = zip((-7.0, 7.0), row.shares, row.verdicts, row.intervals, said.values(), strict=True)
        for offset, share, verdict, span, when in bars:
            at = middle + offset
            end = rows.scale(min(share, rows.scale.high))
            rows.surface.bar(rows.scale.start, end, at, 12.0, look_of(verdict))
            if span is not None and math.isfinite(span[0]):
                end = max(end, rows.interval(*span, at))
            rows.surface.words((end + 5.0, at), f"{when} {say.number(share, 1)} %", size=SMALL)
        if math.isfinite(row.new):
            x = rows.scale(row.new)
            rows.surface.line([(x, middle - 15.0), (x, middle + 15.0)], width=1.6)
        for band, begins in row.levels:
            if begins < rows.scale.high:
                rows.surface.sign(look_of(band), (rows.scale(begins), middle + 18.0))
    return rows.surface.svg()


def pressures_chart(at: PressuresAt, say: Wording) -> str:
    """Draw what the line and every applied circuit hold: new as a frame, now in the shade of its verdict, and repaired.

    A bar's line is the 95 % interval of what holds now; short upright marks are what is set or required, triangles
    what is permissible, and signs where a loss reaches a level.
    """
    held = at.applied
    scale = say.convert(KPA, "pressure")
    ends = [scale * end for each in held for end in (each.now, each.new, *(each.interval or ()), *_permissible(each))]
    repaired = any(each.repaired is not None for each in held)
    names = [say("held.line") if each.circuit is None else say.name(each.circuit.name) for each in held]
    words = [_held_words(each, say) for each in held]
    rows = _Rows(names, 36.0 if repaired else 28.0, ends, words=widest(words) + 14.0)
    rows.draw(say("charts.pressure"), say)
    for row, (each, said) in enumerate(zip(held, words, strict=True)):
        _held_bars(rows, each, rows.middle(row), scale)
        end = max(each.now, each.new, *(each.interval or ()), *_permissible(each))
        rows.surface.words((rows.scale(min(end * scale, rows.scale.high)) + 10.0, rows.middle(row)), said, size=SMALL)
    return rows.surface.svg()


def _held_words(each: HeldPressure, say: Wording) -> str:
    held = say.value(each.now * KPA, "pressure", 0)
    return held if each.verdict is None else f"{held} {say.level(each.verdict)}"


def _held_bars(rows: _Rows, held: HeldPressure, middle: float, scale: float) -> None:
    """Draw the bars of one pressure and what it is judged by; ``scale`` is from Pa to the unit of the axis."""
    surface, left = rows.surface, rows.scale.start

    def plain(value: float, offset: float, fill: str) -> None:
        size = (rows.scale(value * scale) - left, 8.0)
        surface.box((left, middle + offset - 4.0), size, fill, PAPER.ink, 0.7)

    plain(held.new, -9.0, "#FFFFFF")
    if held.verdict is None:
        plain(held.now, 0.0, PAPER.metal)
    else:
        surface.bar(left, rows.scale(held.now * scale), middle, 8.0, look_of(held.verdict))
    if held.repaired is not None:
        plain(held.repaired, 9.0, PAPER.rule)
    if held.interval is not None:
        rows.interval(held.interval[0] * scale, held.interval[1] * scale, middle)
    if held.set_pressure is not None:
        x = rows.scale(min(held.set_pressure * scale, rows.scale.high))
        surface.line([(x, middle - 14.0), (x, middle + 14.0)], width=1.6)
    if held.permissible is not None:
        for pressure, way in ((held.permissible.low, 1.0), (held.permissible.high, -1.0)):
            if pressure is not None:
                surface.triangle((rows.scale(pressure * scale), middle), way)
    for level, pressure in held.limits if held.circuit else ():
        if pressure > 0.0:
            surface.sign(look_of(level), (rows.scale(min(pressure * scale, rows.scale.high)), middle))


def _permissible(held: HeldPressure) -> list[float]:
    """Return between which pressures the line must be [Pa]; none, one or two of them."""
    stated = (held.permissible.low, held.permissible.high) if held.permissible else ()
    return [pressure for pressure in stated if pressure is not None]
