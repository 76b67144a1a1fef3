"""Draw the charts of bars: two visits side by side, pressures held."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes

from atleak.look import PAPER, look_of
from atleak.report.printed_charts import plotting
from atleak.report.printed_charts.plotting import bar_of, interval, places, rows_of, sign, widest, words
from atleak.verdicts import Band, Verdict
from atleak.views.pressures import HeldPressure, PressuresAt
from atleak.wording import Wording
from atleak.workshop_units import KPA


@dataclass(frozen=True)
class TwoBars:
    """One condition in the chart of two visits, shares in percent."""

    label: str
    shares: tuple[float, float]  # before and after
    verdicts: tuple[Verdict, Verdict]
    intervals: tuple[tuple[float, float] | None, tuple[float, float] | None]
    new: float  # of the same unit new
    levels: tuple[tuple[Band, float], ...]  # where each band begins


def _largest(ends: Sequence[float]) -> float:
    return max((end for end in ends if math.isfinite(end)), default=1.0)


def two_visits_chart(visits: Sequence[TwoBars], label: str, say: Wording) -> str:
    """Draw the share at each condition before, on top, and after, each in the shade of its band.

    A line is the 95 % interval, the upright mark is the unit new, signs show where a band begins.
    """
    right = _largest(
        [end for row in visits for end in (*row.shares, row.new, *(e for span in row.intervals for e in span or ()))]
    )
    said = [say(f"comparison.{when}").lower() for when in ("before", "after")]
    with rows_of([row.label for row in visits], 36.0, right, widest(said) + 40.0, label, say) as (figure, axes):
        for place, row in zip(places(visits), visits, strict=True):
            for offset, share, verdict, span, when in zip(
                (0.19, -0.19), row.shares, row.verdicts, row.intervals, said, strict=True
            ):
                at, end = place + offset, min(share, right)
                bar_of(axes, end, at, 0.34, look_of(verdict))
                if span is not None and math.isfinite(span[0]):
                    interval(axes, span[0], min(span[1], right), at)
                    end = max(end, min(span[1], right))
                words(axes, (end, at), f"{when} {say.number(share, 1)} %", (5.0, 0.0))
            axes.plot([row.new] * 2, [place - 0.4, place + 0.4], color=PAPER.ink, lw=1.6, zorder=4)
            for band, begins in row.levels:
                if begins < right:
                    sign(axes, look_of(band), begins, place - 0.5)
        return plotting.svg(figure)


def pressures_chart(at: PressuresAt, say: Wording) -> str:
    """Draw what the line and every applied circuit hold: new as a frame, now in the shade of its verdict, and repaired.

    A bar's line is the 95 % interval of what holds now; short upright marks are what is set or required, triangles
    what is permissible, and signs where a loss reaches a level.
    """
    held, scale = at.applied, say.convert(KPA, "pressure")
    ends = [max(each.now, each.new, *(each.interval or ()), *_permissible(each)) * scale for each in held]
    names = [say("held.line") if each.circuit is None else say.name(each.circuit.name) for each in held]
    said = [_held_words(each, say) for each in held]
    row = 36.0 if any(each.repaired is not None for each in held) else 28.0
    room, title = widest(said) + 14.0, say("charts.pressure")
    with rows_of(names, row, _largest(ends), room, title, say) as (figure, axes):
        for place, each, end, told in zip(places(held), held, ends, said, strict=True):
            _held_bars(axes, each, place, scale)
            words(axes, (end, place), told, (10.0, 0.0))
        return plotting.svg(figure)


def _held_words(each: HeldPressure, say: Wording) -> str:
    held = say.value(each.now * KPA, "pressure", 0)
    return held if each.verdict is None else f"{held} {say.level(each.verdict)}"


def _held_bars(axes: Axes, held: HeldPressure, place: float, scale: float) -> None:
    """Draw the bars of one pressure and what it is judged by; ``scale`` is from Pa to the unit of the axis."""

    def plain(value: float, at: float, fill: str) -> None:
        axes.barh(at, value * scale, height=0.24, color=fill, edgecolor=PAPER.ink, lw=0.7)

    plain(held.new, place + 0.26, "white")
    if held.verdict is None:
        plain(held.now, place, PAPER.metal)
    else:
        bar_of(axes, held.now * scale, place, 0.24, look_of(held.verdict))
    if held.repaired is not None:
        plain(held.repaired, place - 0.26, PAPER.rule)
    if held.interval is not None:
        interval(axes, held.interval[0] * scale, held.interval[1] * scale, place)
    if held.set_pressure is not None:
        axes.plot([held.set_pressure * scale] * 2, [place - 0.42, place + 0.42], color=PAPER.ink, lw=1.6, zorder=4)
    if held.permissible is not None:
        for pressure, marker in ((held.permissible.low, ">"), (held.permissible.high, "<")):
            if pressure is not None:
                axes.plot([pressure * scale], [place], marker, ms=6, color=PAPER.ink, zorder=5, clip_on=False)
    for level, pressure in held.limits if held.circuit else ():
        if pressure > 0.0:
            sign(axes, look_of(level), pressure * scale, place)


def _permissible(held: HeldPressure) -> list[float]:
    """Return between which pressures the line must be [Pa]; none, one or two of them."""
    stated = (held.permissible.low, held.permissible.high) if held.permissible else ()
    return [pressure for pressure in stated if pressure is not None]
