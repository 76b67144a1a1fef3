"""Draw the charts of a fleet's summary: verdicts, pairs, wear over mileage, temperatures, groups side by side."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from atleak.fleet.summed import MileageClass, TemperatureClass
from atleak.look import LOOKS, OK_IN_PART, PAPER, SPREADS, Look, look_of
from atleak.report.printed_charts import plotting
from atleak.report.printed_charts.plotting import (
    BELOW,
    SIZE,
    WIDTH,
    bar_of,
    interval,
    places,
    rows_of,
    sign,
    widest,
    words,
)
from atleak.report.printed_fonts import fitting, width_of
from atleak.spreads import Rate, Spread
from atleak.verdicts import BANDS, FLAGGED, VERDICTS, Band, Verdict
from atleak.wording import Wording

STACKED = (*(verdict for verdict in VERDICTS if verdict is not Verdict.NOT_MEASURED), Verdict.NOT_MEASURED)
_LEFT, _RIGHT = 48.0, 14.0  # [pt] of a field: for its values and title, and to the edge
_ACROSS, _BETWEEN = 2, 20.0  # fields of wear beside one another
_TICKS, _THOUSAND = 5, 1000.0  # of mileage: written whole, numbers of neighbouring fields would run into one another
_TITLE, _UNITS, _WEAR = 15.0, 11.0, 62.0  # [pt] heights: a field's title, the numbers of units below it, the field
_FIELDS = {"share": 92.0, "pressure": 74.0, "bands": 54.0, "units": 34.0}  # [pt] heights over temperature
_LOW = 0.7  # of these heights, where there is little room
_GROUND = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85}  # behind words on a grid
_BOLD = 1.1  # how much wider bold letters are than plain ones, at most
_GAP = 12.0  # [pt] between fields that stand below one another
_MARKS = dict(zip(FLAGGED, np.linspace(0.27, -0.27, len(FLAGGED)), strict=True))  # of a group, in its row


@dataclass(frozen=True)
class VerdictRow:
    """How many of some units have which verdict."""

    name: str
    verdicts: Mapping[Verdict, int]
    ok_in_part: int = 0  # of those that are ok: as far as they were measured, not at every land


@dataclass(frozen=True)
class PairRow:
    """How often a pair is at *watch* or past it, and at *replace* or past it."""

    name: str
    flagged: Rate
    replace: Rate


@dataclass(frozen=True)
class WearField:
    """The wear of a pair in classes of mileage."""

    name: str
    classes: Sequence[MileageClass]


@dataclass(frozen=True)
class GroupRow:
    """The rates of a group at each level that calls for attention, or past it."""

    name: str
    rates: Mapping[Verdict, Rate]


def verdicts_chart(rows: Sequence[VerdictRow], title: str, say: Wording) -> str:
    """Draw what part of the units has which verdict, a row for each set of units; counts stand in the bars."""
    said = [say("fleet_summary.chart_units", count=say.number(sum(row.verdicts.values()), 0)) for row in rows]
    room = widest(said) + 12.0
    with rows_of([row.name for row in rows], 19.0, 100.0, room, title, say) as (figure, axes):
        point = (axes.get_position().width * WIDTH) / 100.0  # [pt] of a per cent
        for place, row, told in zip(places(rows), rows, said, strict=True):
            units, begin = sum(row.verdicts.values()) or 1, 0.0
            for count, look in _parts_of(row):
                end = begin + 100.0 * count / units
                if count:
                    bar_of(axes, end, place, 0.72, look, begin)
                if width_of(str(count), SIZE) + 5.0 < (end - begin) * point:
                    _on(axes, (0.5 * (begin + end), place), say.number(count, 0), look)
                begin = end
            words(axes, (100.0, place), told, (5.0, 0.0))
        return plotting.svg(figure)


def _parts_of(row: VerdictRow) -> Iterator[tuple[int, Look]]:
    """Yield how many units each part of a bar stands for, and its looks: what is ok in part is not green."""
    for verdict in STACKED:
        if verdict is Verdict.OK:
            yield row.verdicts[verdict] - row.ok_in_part, LOOKS[verdict]
            yield row.ok_in_part, OK_IN_PART
        else:
            yield row.verdicts[verdict], LOOKS[verdict]


def _on(axes: Axes, at: tuple[float, float], text: str, look: Look) -> None:
    """Write words on a bar; strokes of its hatch stand back from them."""
    ground = {"boxstyle": "square,pad=0.12", "fc": look.fill, "ec": "none"} if look.hatch else None
    words(axes, at, text, ha="center", color=look.on_fill, bbox=ground, zorder=4)


def pairs_chart(rows: Sequence[PairRow], title: str, say: Wording) -> str:
    """Draw how often pairs are flagged, and before it how often they are past *replace*, with its 95 % interval."""
    said = [_rate_words(row.replace, say) for row in rows]
    ends = [end for row in rows for end in (row.flagged.percent, row.replace.percent, row.replace.high_percent) if end]
    room = widest(said) + 12.0
    with rows_of([row.name for row in rows], 15.0, max(ends, default=1.0), room, title, say) as (figure, axes):
        for place, row, told in zip(places(rows), rows, said, strict=True):
            end = 0.0
            for rate, verdict in ((row.flagged, FLAGGED[0]), (row.replace, Verdict.REPLACE)):
                if rate.count and rate.percent:
                    bar_of(axes, rate.percent, place, 0.68, LOOKS[verdict])
                    end = max(end, rate.percent)
            if row.replace.low_percent is not None and row.replace.high_percent is not None:
                interval(axes, row.replace.low_percent, row.replace.high_percent, place)
                end = max(end, row.replace.high_percent)
            words(axes, (end, place), told, (5.0, 0.0), bbox=_GROUND)
        return plotting.svg(figure)


def _rate_words(rate: Rate, say: Wording) -> str:
    counted = say("fleet_summary.chart_rate", count=say.number(rate.count, 0), of=say.number(rate.of, 0))
    return f"{say.number(rate.percent, 1)} %, {counted}" if rate.enough else counted


def wear_chart(fields: Sequence[WearField], say: Wording) -> str:
    """Draw the wear of pairs in classes of mileage, all over the same axes, with the number of units of each class.

    A wide box holds nine of ten units, a narrow one half of them; the line in it is the median. Fewer than ten units
    are a line from the least to the most.
    """
    classes = [each for field in fields for each in field.classes]
    low, high = (say.convert(end, "distance") for end in _ends(classes))
    bottom, top = _reach(each.wear_percent for each in classes)
    rows = math.ceil(len(fields) / _ACROSS)
    height = _TITLE + _UNITS + _WEAR + _GAP
    wide = (WIDTH - _LEFT - _RIGHT - _BETWEEN * (_ACROSS - 1)) / _ACROSS
    with plotting.drawing():
        figure = plotting.figure_of(rows * height + BELOW)
        for number, field in enumerate(fields):
            row, column = divmod(number, _ACROSS)
            left = _LEFT + column * (wide + _BETWEEN)
            axes = plotting.field(figure, left, left + wide, row * height + _TITLE + _UNITS, _WEAR)
            axes.set_xlim(low, high)
            axes.set_ylim(bottom, top)
            plotting.number_axes(axes, say, "x", "y", most=5)
            last = number + _ACROSS >= len(fields)
            axes.xaxis.set_major_locator(MaxNLocator(_TICKS, steps=(1, 2, 5, 10)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value / _THOUSAND, 5)))
            axes.tick_params(labelbottom=last, labelleft=column == 0)
            if last:
                axes.set_xlabel(say("fleet_summary.chart_mileage_thousand", thousand=say.number(_THOUSAND, 0)))
            if column == 0:
                _title(axes, say("fleet_summary.chart_wear"))
            name = fitting(field.name, SIZE, wide / _BOLD)
            words(axes, (low, top), name, (0.0, _UNITS + 6.0), fontweight="bold", va="center")
            for each in field.classes:
                begin, end = (say.convert(limit, "distance") for limit in (each.low_km, each.high_km))
                _spread(axes, begin, end, each.wear_percent)
            _units_above(axes, field.classes, wide / (high - low), say)
        return plotting.svg(figure)


def _units_above(axes: Axes, classes: Sequence[MileageClass], point: float, say: Wording) -> None:
    """Write the number of units over each class, or over every so many classes where they are narrow.

    ``point`` is the width on paper of a unit of the axis [pt].
    """
    (_, top), units = axes.get_ylim(), [str(each.wear_percent.units) for each in classes]
    ends = [[say.convert(limit, "distance") for limit in (each.low_km, each.high_km)] for each in classes]
    narrowest = min(((end - begin) * point for begin, end in ends), default=1.0)
    step = max(math.ceil((widest(units) + 5.0) / narrowest), 1)
    for (begin, end), number in list(zip(ends, units, strict=True))[::step]:
        words(axes, (0.5 * (begin + end), top), number, (0.0, 6.0), ha="center", color=PAPER.soft)


def _ends(classes: Sequence[MileageClass]) -> tuple[float, float]:
    return min((each.low_km for each in classes), default=0.0), max((each.high_km for each in classes), default=1.0)


def _reach(
    spreads: Iterable[Spread | None], beside: Iterable[float | None] = (), *, from_zero: bool = True
) -> tuple[float, float]:
    """Return between which values an axis shows spreads and what is drawn beside them."""
    known = [each for each in spreads if each is not None]
    ends = [end for each in known for end in _extent(each)] + [each for each in beside if each is not None]
    low, high = min(ends, default=0.0), max(ends, default=0.0)
    if from_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    room = 0.06 * (high - low) or 1.0
    return (low if low == 0.0 else low - room), high + room


def _extent(spread: Spread) -> tuple[float, float]:
    """Return between which values a spread is drawn."""
    return (spread.least, spread.most) if spread.quantiles is None else (spread.quantiles[0], spread.quantiles[-1])


def _title(axes: Axes, title: str) -> None:
    """Write what an upright axis shows along it, at the edge of the paper."""
    axes.annotate(
        title, (0.0, 0.5), xycoords="axes fraction", xytext=(8.0 - _LEFT, 0.0), textcoords="offset points",
        rotation=90, ha="center", va="center", fontsize=SIZE,
    )  # fmt: skip


def _spread(axes: Axes, begin: float, end: float, spread: Spread, scale: float = 1.0) -> None:
    """Draw how values of units are spread, over a stretch of the axis."""
    middle, wide = 0.5 * (begin + end), end - begin
    low, high = _extent(spread)
    if spread.quantiles is None:
        axes.plot([middle, middle], [low * scale, high * scale], color=PAPER.soft, lw=0.8, marker="_", ms=4, zorder=3)
        part = 0.3
    else:
        _, lower, _, upper, _ = spread.quantiles
        for reach, part, colour in ((low, high), 0.8, SPREADS[0]), ((lower, upper), 0.5, SPREADS[1]):
            axes.bar(
                middle, (reach[1] - reach[0]) * scale, bottom=reach[0] * scale, width=part * wide, color=colour,
                edgecolor=PAPER.ink, lw=0.5, zorder=2,
            )  # fmt: skip
    median = spread.median * scale
    axes.plot([middle - 0.5 * part * wide, middle + 0.5 * part * wide], [median] * 2, color=PAPER.ink, lw=1.6, zorder=4)


def temperatures_chart(classes: Sequence[TemperatureClass], say: Wording, *, low: bool = False) -> str:
    """Draw share and main pressure over temperature, the time in each band, and the number of units.

    A chart may be ``low``, for paper with little room. Boxes are as over mileage, of the units' own means; a diamond
    is the mean of all their time.
    """
    kinds = [kind for kind, values in _shown(classes).items() if values]
    heights = {kind: _FIELDS[kind] * (_LOW if low else 1.0) for kind in kinds}
    height = sum(heights.values()) + _GAP * (len(kinds) - 1)
    with plotting.drawing():
        figure = plotting.figure_of(6.0 + height + BELOW)
        above = 6.0
        for kind in kinds:
            axes = plotting.field(figure, _LEFT, WIDTH - _RIGHT, above, heights[kind])
            _over_temperature(axes, kind, classes, say)
            axes.set_xlim(*(say.convert(end, "temperature") for end in (classes[0].low_c, classes[-1].high_c)))
            plotting.number_axes(axes, say, "x", most=10)
            plotting.number_axes(axes, say, "y", most=max(int(heights[kind] / 18.0), 2))
            _title(axes, say(f"fleet_summary.over_{kind}"))
            axes.tick_params(labelbottom=kind == kinds[-1], bottom=kind == kinds[-1])
            above += heights[kind] + _GAP
        axes.set_xlabel(say("fleet_summary.chart_temperature"))
        return plotting.svg(figure)


def _shown(classes: Sequence[TemperatureClass]) -> dict[str, bool]:
    """Return which fields have anything to show."""
    return {
        "share": any(each.share_percent for each in classes),
        "pressure": any(each.pressure_kpa for each in classes),
        "bands": any(each.bands_percent for each in classes),
        "units": True,
    }


def _over_temperature(axes: Axes, kind: str, classes: Sequence[TemperatureClass], say: Wording) -> None:
    """Draw one field of `temperatures_chart`."""
    ends = [tuple(say.convert(end, "temperature") for end in (each.low_c, each.high_c)) for each in classes]
    if kind in ("share", "pressure"):
        scale = 1.0 if kind == "share" else say.convert(1.0, "pressure")
        drawn = [
            (each.share_percent, each.share_mean_percent)
            if kind == "share"
            else (each.pressure_kpa, each.pressure_mean_kpa)
            for each in classes
        ]
        known = ([spread for spread, _ in drawn], [mean for _, mean in drawn])
        low, high = _reach(*known, from_zero=kind == "share")
        axes.set_ylim(low * scale, high * scale)
        for (begin, end), (spread, mean) in zip(ends, drawn, strict=True):
            if spread is not None:
                _spread(axes, begin, end, spread, scale)
            if mean is not None:
                axes.plot(
                    [0.5 * (begin + end)], [mean * scale], "D", ms=3.5, color=PAPER.leakage, mec="white", zorder=5
                )
    elif kind == "bands":
        axes.set_ylim(0.0, 100.0)
        for (begin, end), each in zip(ends, classes, strict=True):
            bottom = 0.0
            for part, look in _bands_of(each):
                if part:
                    axes.bar(
                        0.5 * (begin + end), part, bottom=bottom, width=0.8 * (end - begin), color=look.fill,
                        edgecolor=look.line, lw=0.5, hatch=look.hatch,
                    )  # fmt: skip
                bottom += part
    else:
        for (begin, end), each in zip(ends, classes, strict=True):
            units = max((spread.units for spread in (each.share_percent, each.pressure_kpa) if spread), default=0)
            axes.bar(
                0.5 * (begin + end), units, width=0.8 * (end - begin), color=PAPER.metal, edgecolor=PAPER.ink, lw=0.5
            )


def _bands_of(each: TemperatureClass) -> Iterator[tuple[float, Look]]:
    """Yield the parts of the time in each band, and their looks: of units measured in part none is green."""
    for band in BANDS:
        part = (each.bands_percent or {}).get(band, 0.0)
        if band is Band.GREEN:
            yield part - each.green_in_part_percent, look_of(band)
            yield each.green_in_part_percent, OK_IN_PART
        else:
            yield part, look_of(band)


def groups_chart(rows: Sequence[GroupRow], title: str, say: Wording) -> str:
    """Draw the rates of groups below one another, each with its 95 % interval: a level is told by its sign."""
    rates = [rate for row in rows for rate in row.rates.values()]
    ends = [end for rate in rates for end in (rate.percent, rate.high_percent) if end is not None]
    judged = [max(rate.of for rate in row.rates.values()) for row in rows]
    said = [say("fleet_summary.chart_units", count=say.number(units, 0)) for units in judged]
    room, right = widest(said) + 12.0, min(max(ends, default=1.0) * 1.04, 100.0)
    with rows_of([row.name for row in rows], 24.0, right, room, title, say) as (figure, axes):
        for place, row, told in zip(places(rows), rows, said, strict=True):
            for verdict in FLAGGED:
                rate, at = row.rates[verdict], place + _MARKS[verdict]
                if rate.low_percent is not None and rate.high_percent is not None:
                    interval(axes, rate.low_percent, rate.high_percent, at)
                if rate.percent is not None:
                    sign(axes, LOOKS[verdict], rate.percent, at)
            words(axes, (right, place), told, (7.0, 0.0))
        _part_rows(figure, axes, len(rows))
        return plotting.svg(figure)


def _part_rows(figure: Figure, axes: Axes, rows: int) -> None:
    """Draw a thin line between rows that hold several marks."""
    for number in range(1, rows):
        axes.axhline(number - 0.5, color=PAPER.rule, lw=0.5)
