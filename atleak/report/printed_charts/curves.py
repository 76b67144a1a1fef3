"""Draw the charts of curves: leakage over a road test, the pump over engine speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from atleak.look import PAPER
from atleak.report.printed_charts.surface import SIZE, SMALL, WIDTH, Scale, Surface, points, widest
from atleak.report.printed_fonts import fitting, width_of
from atleak.verdicts import Band
from atleak.views.pump_speed import PumpOverSpeed
from atleak.views.road_series import RoadSeries
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, RPM

_RIGHT = WIDTH - 14.0
_BETWEEN = 10.0  # two fields
_HIGH, _LOW = 96.0, 62.0  # heights of fields
_BELOW = 32.0
_PUMP = 150.0  # height of the pump's field
_DASHES = ((5.0, 2.0), (2.0, 1.5), (1.0, 1.5), (8.0, 2.0, 1.0, 2.0), (5.0, 2.0, 1.0, 2.0, 1.0, 2.0))
_SOLID: tuple[float, ...] = ()
_ROW = 12.0  # of the words of engine speeds, above the field
_SAMPLE = 22.0  # length of a line in a legend

Mark = tuple[float, float | None, float | None]


def road_chart(series: RoadSeries, marks: Sequence[Mark], bands: Sequence[tuple[Band, float]], say: Wording) -> str:
    """Draw leakage over time and, where they are known, the pump's capacity and the share, each over its own axis.

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
    time, unit = columns["time_s"], say.unit("flow")
    leakage, share = say.convert(columns["leakage_dm3_min"], "flow"), columns.get("share_percent")
    fields = [(say("charts.leakage_in", unit=unit), leakage, _HIGH, PAPER.leakage)]
    if share is not None:
        capacity = say.convert(columns["pump_capacity_dm3_min"], "flow")
        fields.append((say("charts.capacity_in", unit=unit), capacity, _LOW, PAPER.pump))
        fields.append((say("charts.share"), share, _HIGH, PAPER.ink))
    surface = Surface(sum(height + _BETWEEN for _, _, height, _ in fields) + _BELOW)
    scales, top = [], 8.0
    for _, values, height, _ in fields:
        known = values[np.isfinite(values)]
        high = 1.12 * float(known.max()) if len(known) else 1.0
        scales.append(Scale(0.0, high or 1.0, top + height, top))
        top += height + _BETWEEN
    left = 28.0 + max(widest((say.plain(value, 5) for value in each.ticks()), SIZE) for each in scales)
    over = Scale(float(time[0]), max(float(time[-1]), float(time[0]) + 1.0), left, _RIGHT)
    for number, ((title, values, _, colour), scale) in enumerate(zip(fields, scales, strict=True)):
        last = number == len(fields) - 1
        surface.across(over, scale.stop, scale.start, lambda value: say.plain(value, 5), say("charts.time") * last)
        surface.up(scale, left, _RIGHT, lambda value: say.plain(value, 5), title)
        surface.line(points(over, scale, time, values), colour, 1.2)
    if share is not None:
        _bands(surface, scales[-1], left, bands, say)
    for number, (at, leaks, part) in enumerate(marks, start=1):
        _mark(surface, over(at), scales[0], None if leaks is None else say.convert(leaks, "flow"), number)
        if share is not None:
            _mark(surface, over(at), scales[-1], part, number)
    return surface.svg()


def _bands(surface: Surface, scale: Scale, left: float, bands: Sequence[tuple[Band, float]], say: Wording) -> None:
    for name, begins in bands:
        if begins < scale.high:
            y = scale(begins)
            surface.line([(left, y), (_RIGHT, y)], width=0.7, dashes=(1.5, 1.5))
            surface.words(
                (_RIGHT - 2.0, y - 6.0), f"{say.level(name)} ≥ {say.plain(begins)} %", size=SMALL, anchor="end"
            )


def _mark(surface: Surface, x: float, scale: Scale, value: float | None, number: int) -> None:
    if value is not None and math.isfinite(value):
        surface.disc((x, scale(value)), 5.5, "#FFFFFF")
        surface.words((x, scale(value)), str(number), size=SMALL, anchor="middle")


def pump_chart(data: PumpOverSpeed, say: Wording) -> str:
    """Draw the pump's supply over engine speed against what is taken from it at each temperature.

    The crossing at the condition's own temperature carries its engine speed and its 95 % interval; upright lines are
    the engine speeds that are marked.
    """
    flow = say.convert(DM3_MIN, "flow")
    entries = [(say("charts.supply"), PAPER.pump, 1.6, _SOLID)]
    for number, demand in enumerate(data.demands):
        own = demand.of_condition
        colour, width = (PAPER.leakage, 1.4) if own else (PAPER.soft, 0.9)
        named = say("charts.taken_at", temperature=say.plain_value(demand.temperature, "temperature"))
        entries.append((named, colour, width, _SOLID if own else _DASHES[number % len(_DASHES)]))
    places, top = _legend([name for name, *_ in entries])
    top += _ROW * len(data.marked)
    highest = max(float(data.supply[-1]), *(demand.flow for demand in data.demands)) * flow
    surface = Surface(top + _PUMP + _BELOW)
    up = Scale(0.0, 1.05 * highest or 1.0, top + _PUMP, top)
    left = 28.0 + widest((say.plain(value, 5) for value in up.ticks()), SIZE)
    over = Scale(0.0, float(data.speeds[-1]) * RPM, left, _RIGHT)
    surface.across(over, top, up.start, lambda value: say.plain(value, 5), say("charts.speed"))
    surface.up(up, left, _RIGHT, lambda value: say.plain(value, 5), say("charts.flow"))
    for (x, y), (name, colour, width, dashes) in zip(places, entries, strict=True):
        surface.line([(x, y), (x + _SAMPLE, y)], colour, width, dashes)
        surface.words((x + _SAMPLE + 5.0, y), name, size=SMALL)
    surface.line(points(over, up, data.speeds * RPM, data.supply * flow), *entries[0][1:])
    for demand, (_, colour, width, dashes) in zip(data.demands, entries[1:], strict=True):
        y = up(demand.flow * flow)
        surface.line([(left, y), (_RIGHT, y)], colour, width, dashes)
    for number, (label, speed) in enumerate(sorted(data.marked, key=itemgetter(1)), start=1):
        height = top - _ROW * (number - 0.5)
        _marked(surface, (over(speed * RPM), height), up.start, f"{label}: {say.number(speed * RPM, 0)} 1/min")
    _crossings(surface, data, over, up, say)
    return surface.svg()


def _crossings(surface: Surface, data: PumpOverSpeed, over: Scale, up: Scale, say: Wording) -> None:
    """Mark where the supply meets what is taken, with the speed and its interval at the condition's temperature."""
    flow = say.convert(DM3_MIN, "flow")
    for demand in data.demands:
        speed, y = demand.crossing * RPM, up(demand.flow * flow)
        if not speed <= over.high:
            continue
        surface.disc((over(speed), y), 2.6 if demand.of_condition else 1.2)
        if demand.of_condition:
            if data.interval is not None:
                low, high = (over(min(end * RPM, over.high)) for end in data.interval)
                surface.interval(low, high, y)
            words = f"{say.number(speed, 0)} 1/min"
            beside = over(speed) - 4.0 - width_of(words, SIZE) * 1.1 > over.start
            x, anchor = (over(speed) - 4.0, "end") if beside else (over.start + 4.0, "start")
            surface.words((x, y - 9.0), words, anchor=anchor, bold=True)


def _marked(surface: Surface, at: tuple[float, float], bottom: float, words: str) -> None:
    """Draw an engine speed as an upright line with its words at its upper end, on the side that has more room."""
    x, y = at
    surface.line([(x, bottom), (x, y - 4.0)], width=0.8, dashes=(6.0, 2.0))
    right = x < WIDTH / 2.0
    words = fitting(words, SMALL, WIDTH - x - 4.0 if right else x - 4.0)
    surface.words((x + 4.0 if right else x - 4.0, y), words, size=SMALL, anchor="start" if right else "end")


def _legend(names: Sequence[str]) -> tuple[list[tuple[float, float]], float]:
    """Return where the entries of a legend stand, in rows, and where the field below them begins."""
    places: list[tuple[float, float]] = []
    x, y = 8.0, 7.0
    for name in names:
        width = _SAMPLE + 5.0 + width_of(name, SMALL) + 14.0
        if x + width > WIDTH and places:
            x, y = 8.0, y + 13.0
        places.append((x, y))
        x += width
    return places, y + 14.0
