"""Draw the charts of the printed report: matplotlib figures as SVG, distinct in greyscale by dashes and hatches."""

from __future__ import annotations

import io
import math
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, MaxNLocator

from atleak.look import PAPER, look_of
from atleak.report.drawn_png import FONTS
from atleak.verdicts import Band, Verdict
from atleak.views.drawing import shortened
from atleak.views.pressures import HeldPressure, PressuresAt
from atleak.views.pump_speed import PumpOverSpeed
from atleak.views.road_series import RoadSeries
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, RPM

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

_DASHES = ((5, 2), (2, 1.5), (1, 1.5), (8, 2, 1, 2), (5, 2, 1, 2, 1, 2))  # of curves that differ by temperature
_LETTERS = 40  # of a name that are drawn
_LOCK = threading.Lock()  # matplotlib's settings belong to the whole process
_SETTINGS: dict[RcKeyType, Any] = {
    "svg.hashsalt": "atleak",
    "svg.fonttype": "none",
    "font.family": ["Noto Sans", "DejaVu Sans"],
    "font.size": 9.0,
    "axes.edgecolor": PAPER.ink,
    "axes.labelcolor": PAPER.ink,
    "axes.linewidth": 0.6,
    "xtick.color": PAPER.ink,
    "ytick.color": PAPER.ink,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "hatch.linewidth": 0.5,
    "path.simplify_threshold": 0.2,
}


@dataclass(frozen=True)
class Bar:
    """One land in the chart of shares, in percent; ``low`` and ``high`` where the uncertainty is known."""

    label: str
    share: float
    verdict: Verdict
    low: float | None = None
    high: float | None = None


def road_chart(
    series: RoadSeries,
    marks: Sequence[tuple[float, float | None, float | None]],
    bands: Sequence[tuple[Band, float]],
    say: Wording,
) -> str:
    """Draw leakage and pump capacity over time and, where known, the share with its bands.

    Parameters
    ----------
    series
        the thinned road test.
    marks
        (time [s], leakage [dm³/min], share [%]) of the instants to number, in their order.
    bands
        (name, share [%]) at which each band begins.
    say
        words and decimal sign.
    """
    columns = series.columns
    share = columns.get("share_percent")
    with _drawing():
        figure = Figure(figsize=(7.0, 2.3 if share is None else 3.7), layout="constrained")
        axes = figure.subplots(1 if share is None else 2, 1, sharex=True, squeeze=False)[:, 0]
        flow, time = axes[0], columns["time_s"]
        curves = []
        if share is not None:
            capacity = flow.twinx()  # the pump displaces many times what leaks: each has a scale of its own
            curves += capacity.plot(
                time,
                say.convert(columns["pump_capacity_dm3_min"], "flow"),
                color=PAPER.pump,
                lw=0.9,
                ls=(0, (5, 2)),
                label=say("charts.capacity_right"),
            )
            capacity.set_ylim(bottom=0.0)
            _plain(capacity, say)
            capacity.spines["right"].set_visible(True)
        curves += flow.plot(
            time,
            say.convert(columns["leakage_dm3_min"], "flow"),
            color=PAPER.leakage,
            lw=1.4,
            label=say("charts.leakage"),
        )
        flow.set_ylabel(say("charts.flow"))
        flow.set_ylim(bottom=0.0)
        figure.legend(handles=curves, loc="outside upper left", ncols=2, frameon=False)
        if share is not None:
            below = axes[1]
            below.plot(time, share, color=PAPER.ink, lw=1.0)
            below.set_ylabel(say("charts.share"))
            top = max(float(np.nanmax(share)) * 1.15, 1.0) if np.isfinite(share).any() else 1.0
            below.set_ylim(0.0, top)
            _bands(below, bands, top, say)
        for number, (at, leakage, part) in enumerate(marks, start=1):
            _mark(flow, at, say.convert(leakage, "flow"), number)
            if share is not None:
                _mark(axes[1], at, part, number)
        axes[-1].set_xlabel(say("charts.time"))
        for each in axes:
            _plain(each, say)
            each.grid(color=PAPER.rule, lw=0.5)
            each.margins(x=0.01)
        return _svg(figure)


def shares_chart(bars: Sequence[Bar], label: str, say: Wording) -> str:
    """Draw the lands that leak most, the largest on top, each in the shade of its verdict."""
    with _drawing():
        figure = Figure(figsize=(7.0, 0.55 + 0.21 * max(len(bars), 3)), layout="constrained")
        axes = figure.subplots()
        places = np.arange(len(bars))[::-1]
        ends = [end for bar in bars for end in (bar.share, bar.high or 0.0) if math.isfinite(end)]
        right = 1.12 * max(ends, default=1.0) or 1.0
        for place, bar in zip(places, bars, strict=True):
            look = look_of(bar.verdict)
            axes.barh(
                place,
                bar.share,
                height=0.68,
                color=look.fill,
                edgecolor=look.line,
                lw=0.8,
                hatch=look.hatch,
            )
            end = bar.share
            if bar.low is not None and bar.high is not None and math.isfinite(bar.low):
                high = min(bar.high, right)  # the interval of a pump that may deliver nothing has no end
                axes.plot([bar.low, high], [place, place], color=PAPER.ink, lw=1.1, marker="|", ms=5)
                end = max(end, high) if math.isfinite(bar.high) else end
            axes.annotate(
                say.number(bar.share, 2),
                (end, place),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
        axes.set_yticks(places, [""] * len(bars))
        for place, bar in zip(places, bars, strict=True):
            axes.annotate(
                _drawable(bar.label),
                (0.0, place),
                xytext=(-5, 0),
                textcoords="offset points",
                ha="right",
                va="center",
                fontsize=8,
                parse_math=False,
            )
        axes.tick_params(axis="y", length=0)
        axes.set_ylim(-0.6, max(len(bars), 3) - 0.4)
        axes.set_xlabel(_drawable(label), parse_math=False)
        axes.set_xlim(0.0, right)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value, 4)))
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(axis="x", color=PAPER.rule, lw=0.5)
        axes.set_axisbelow(True)
        return _svg(figure)


@dataclass(frozen=True)
class TwoBars:
    """One condition in the chart of two visits, shares in percent."""

    label: str
    shares: tuple[float, float]  # before and after
    verdicts: tuple[Verdict, Verdict]
    intervals: tuple[tuple[float, float] | None, tuple[float, float] | None]
    new: float  # of the same unit new
    levels: tuple[tuple[Band, float], ...]  # where each band begins


def two_visits_chart(rows: Sequence[TwoBars], label: str, say: Wording) -> str:
    """Draw the share at each condition before, on top, and after, each in the shade of its band.

    A line is the 95 % interval, the upright mark is the unit new, signs show where a band begins.
    """
    with _drawing():
        figure = Figure(figsize=(7.0, 0.45 + 0.5 * len(rows)), layout="constrained")
        axes = figure.subplots()
        ends = [
            end for row in rows for end in (*row.shares, row.new, *(e for span in row.intervals for e in span or ()))
        ]
        right = 1.2 * max((end for end in ends if math.isfinite(end)), default=1.0) or 1.0
        for place, row in zip(range(len(rows))[::-1], rows, strict=True):
            for offset, share, verdict, span, when in zip(
                (0.19, -0.19), row.shares, row.verdicts, row.intervals, ("before", "after"), strict=True
            ):
                look, at = look_of(verdict), place + offset
                shown = min(share, right)
                axes.barh(at, shown, height=0.34, color=look.fill, edgecolor=look.line, lw=0.8, hatch=look.hatch)
                end = shown
                if span is not None and math.isfinite(span[0]):
                    end = max(end, min(span[1], right))
                    axes.plot([span[0], min(span[1], right)], [at, at], color=PAPER.ink, lw=1.1, marker="|", ms=5)
                axes.annotate(
                    f"{say(f'comparison.{when}').lower()} {say.number(share, 1)} %",
                    (end, at),
                    xytext=(5, 0),
                    textcoords="offset points",
                    va="center",
                    fontsize=8,
                )
            axes.plot([row.new] * 2, [place - 0.4, place + 0.4], color=PAPER.ink, lw=1.6, zorder=4)
            for band, begins in row.levels:
                if begins < right:
                    _sign(axes, band, begins, place - 0.5)
            _row_name(axes, row.label, place)
        axes.set_yticks([])
        axes.set_ylim(-0.65, len(rows) - 0.55)
        axes.set_xlim(0.0, right)
        axes.set_xlabel(_drawable(label), parse_math=False)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value, 4)))
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(axis="x", color=PAPER.rule, lw=0.5)
        axes.set_axisbelow(True)
        return _svg(figure)


def pump_chart(data: PumpOverSpeed, say: Wording) -> str:
    """Draw the pump's supply over engine speed against what is taken from it at each temperature.

    The crossing at the condition's own temperature carries its engine speed and its 95 % interval; upright lines are
    the engine speeds that are marked.
    """
    flow = say.convert(DM3_MIN, "flow")
    with _drawing():
        figure = Figure(figsize=(7.0, 2.9), layout="constrained")
        axes = figure.subplots()
        axes.plot(data.speeds * RPM, data.supply * flow, color=PAPER.pump, lw=1.6, label=say("charts.supply"))
        for number, demand in enumerate(data.demands):
            own = demand.of_condition
            axes.axhline(
                demand.flow * flow,
                color=PAPER.leakage if own else PAPER.soft,
                lw=1.4 if own else 0.8,
                ls="-" if own else (0, _DASHES[number % len(_DASHES)]),
                label=say("charts.taken_at", temperature=say.plain_value(demand.temperature, "temperature")),
            )
            axes.plot([demand.crossing * RPM], [demand.flow * flow], "o", ms=6 if own else 3, color=PAPER.ink, zorder=5)
        demand = data.demand
        if data.interval is not None:
            ends = [end * RPM for end in data.interval]
            axes.plot(ends, [demand.flow * flow] * 2, color=PAPER.ink, lw=1.1, marker="|", ms=7, zorder=4)
        axes.annotate(
            f"{say.number(demand.crossing * RPM, 0)} 1/min",
            (demand.crossing * RPM, demand.flow * flow),
            xytext=(-4, 5),
            textcoords="offset points",
            ha="right",
            fontweight="bold",
        )
        for label, speed in data.marked:
            axes.axvline(speed * RPM, color=PAPER.ink, lw=0.8, ls=(0, (6, 2)))
            axes.annotate(
                _drawable(f"{shortened(label, _LETTERS)}: {say.number(speed * RPM, 0)} 1/min"),
                (speed * RPM, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(-3, -2),
                textcoords="offset points",
                rotation=90,
                ha="right",
                va="top",
                fontsize=8,
                parse_math=False,
            )
        axes.set_xlim(0.0, float(data.speeds[-1]) * RPM)
        axes.set_ylim(0.0, 1.05 * float(data.supply[-1]) * flow or 1.0)
        axes.set_xlabel(say("charts.speed"))
        axes.set_ylabel(say("charts.flow"))
        _plain(axes, say)
        axes.grid(color=PAPER.rule, lw=0.5)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=3, frameon=False, fontsize=8)
        return _svg(figure)


def pressures_chart(at: PressuresAt, say: Wording) -> str:
    """Draw what the line and every applied circuit hold: new as a frame, now in the shade of its verdict, and repaired.

    A bar's line is the 95 % interval of what holds now; short upright marks are what is set or required, triangles
    what is permissible, and signs where a loss reaches a level.
    """
    held, scale = at.applied, say.convert(KPA, "pressure")
    repaired = any(each.repaired is not None for each in held)
    with _drawing():
        figure = Figure(figsize=(7.0, 0.9 + (0.5 if repaired else 0.38) * len(held)), layout="constrained")
        axes = figure.subplots()
        for place, each in zip(range(len(held))[::-1], held, strict=True):
            look = None if each.verdict is None else look_of(each.verdict)
            axes.barh(place + 0.26, each.new * scale, height=0.24, color="white", edgecolor=PAPER.ink, lw=0.7)
            axes.barh(
                place,
                each.now * scale,
                height=0.24,
                color=PAPER.metal if look is None else look.fill,
                edgecolor=PAPER.ink if look is None else look.line,
                lw=0.8,
                hatch="" if look is None else look.hatch,
            )
            if each.repaired is not None:
                axes.barh(
                    place - 0.26, each.repaired * scale, height=0.24, color=PAPER.rule, edgecolor=PAPER.ink, lw=0.5
                )
            end = each.now
            if each.interval is not None:
                ends = [end * scale for end in each.interval]
                axes.plot(ends, [place, place], color=PAPER.ink, lw=1.1, marker="|", ms=5)
                end = max(end, each.interval[1])
            _marks(axes, each, place, scale)
            words = f"{say.value(each.now * KPA, 'pressure', 0)}" + (
                "" if each.verdict is None else f" {say.level(each.verdict)}"
            )
            axes.annotate(
                words,
                (max(end, each.new, *_permissible(each)) * scale, place),
                xytext=(10, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
            name = say("held.line") if each.circuit is None else each.circuit.name
            _row_name(axes, name, place)
        axes.set_yticks([])
        axes.set_ylim(-0.6, len(held) - 0.4)
        largest = max(max(each.now, each.new, *(each.interval or ()), *_permissible(each)) for each in held)
        axes.set_xlim(0.0, 1.18 * largest * scale or 1.0)
        axes.set_xlabel(say("charts.pressure"))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value, 5)))
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(axis="x", color=PAPER.rule, lw=0.5)
        axes.set_axisbelow(True)
        return _svg(figure)


def _permissible(held: HeldPressure) -> list[float]:
    """Return between which pressures the line must be [Pa]; none, one or two of them."""
    stated = (held.permissible.low, held.permissible.high) if held.permissible else ()
    return [pressure for pressure in stated if pressure is not None]


def _marks(axes: Axes, held: HeldPressure, place: float, scale: float) -> None:
    """Mark the limits that apply to one pressure; ``scale`` is from Pa to the unit of the axis."""
    if held.set_pressure is not None:
        axes.plot([held.set_pressure * scale] * 2, [place - 0.42, place + 0.42], color=PAPER.ink, lw=1.6, zorder=4)
    if held.permissible is not None:
        for pressure, marker in ((held.permissible.low, ">"), (held.permissible.high, "<")):
            if pressure is not None:
                axes.plot([pressure * scale], [place], marker, ms=6, color=PAPER.ink, zorder=5)
    for level, pressure in held.limits if held.circuit else ():
        if pressure > 0.0:
            _sign(axes, level, pressure * scale, place)


def _row_name(axes: Axes, name: str, place: float) -> None:
    """Write the name of a row to the left of the axis."""
    axes.annotate(
        _drawable(shortened(name, _LETTERS)),
        (0.0, place),
        xytext=(-5, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        fontsize=8,
        parse_math=False,
    )


def _sign(axes: Axes, level: Verdict | Band | str, x: float, y: float) -> None:
    """Draw the sign of a level."""
    look = look_of(level)
    outline = Outline([(x, -y) for x, y in (*look.shape.points, look.shape.points[0])], closed=True)
    axes.plot([x], [y], marker=outline, ms=7, mfc=look.fill, mec=look.line, zorder=5, clip_on=False)


def _bands(axes: Axes, bands: Sequence[tuple[Band, float]], top: float, say: Wording) -> None:
    for name, begins in bands:
        if begins < top:
            axes.axhline(begins, color=PAPER.ink, lw=0.7, ls=(0, (1.5, 1.5)))
            axes.annotate(
                f"{say.level(name)} ≥ {say.plain(begins)} %",
                (1.0, begins),
                xycoords=("axes fraction", "data"),
                xytext=(-2, 1.5),
                textcoords="offset points",
                ha="right",
                va="bottom",
                fontsize=8,
                bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85},
                zorder=4,
            )


def _mark(axes: Axes, time: float, value: float | None, number: int) -> None:
    if value is None:
        return
    axes.plot(
        [time], [value], marker="o", ms=10.5, mfc="white", mec=PAPER.ink, mew=0.9, ls="none", zorder=5, clip_on=False
    )
    axes.annotate(
        str(number), (time, value), ha="center", va="center_baseline", fontsize=8, zorder=6, annotation_clip=False
    )


def _plain(axes: Axes, say: Wording) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6))
        axis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value, 5)))


def _drawable(text: str) -> str:
    """Return the text with a box for every character that the charts' fonts lack: matplotlib would warn of each."""
    return "".join(sign if ord(sign) in glyphs() else "\u25a1" for sign in text)


@cache
def glyphs() -> frozenset[int]:
    """Return the code points that the bundled fonts have."""
    characters: set[int] = set()
    for path in sorted(FONTS.glob("*.ttf")):
        font_manager.fontManager.addfont(path)
        characters |= set(font_manager.get_font(str(path)).get_charmap())
    return frozenset(characters)


@contextmanager
def _drawing() -> Iterator[None]:
    """Draw with the report's settings of matplotlib, one thread at a time."""
    with _LOCK, mpl.rc_context(_SETTINGS):
        glyphs()
        yield


def _svg(figure: Figure) -> str:
    target = io.StringIO()
    figure.savefig(target, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    return target.getvalue()
