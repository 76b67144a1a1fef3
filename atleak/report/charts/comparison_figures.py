"""Draw two visits of one unit: clearances and totals before and after, and two logs over one another."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from atleak.analysis.changes import Comparison, ConditionComparison, EventPair, LandComparison, LogComparison
from atleak.catalogue.limits import RuleKind
from atleak.common.style import MOST, SCREEN, STATED_INKS, look_of
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import VERDICTS, Band, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.engine.projection import Projection
from atleak.measurements.road_test import QUANTITIES, Channel, thinned
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.charts.figure import Figure, framed
from atleak.report.tables.road_test import Scales

_POINTS = 1500  # samples of a channel that are drawn of each log
_STEPS = ("gear", "selector", "lock_up")  # channels that hold their value until the next sample


def clearance_chart(lands: Sequence[LandComparison], names: Sequence[str], say: Wording) -> RowChart:
    """Return the clearances of lands before (open) and after (filled), each by its verdict, with 95 % intervals.

    Marks are the mounting clearance and the lowest limit of wear or clearance, as they stand after.
    """
    um = say.convert(UM, "clearance")
    latest = [each for land in lands if (each := land.after or land.before) is not None]  # every land has one
    marks: list[LayerOf] = [
        (say("figures.mounting"), STATED_INKS, [each.state.land.mounting_high * um for each in latest], {}),
        (say("figures.first_limit"), MOST, [(limit := _limit(each)) and limit * um for each in latest], {}),
    ]
    sides = (("after", -0.2), ("before", 0.2))
    marks += [_at_visit(lands, side, lift, verdict, say) for side, lift in sides for verdict in VERDICTS]
    axis = say("figures.clearance", unit=say.unit("clearance"), coverage=say.percent(0.95, 0))
    return RowChart(names, layers_of(marks), axis)


def _at_visit(lands: Sequence[LandComparison], side: str, lift: float, verdict: Verdict, say: Wording) -> LayerOf:
    """Return the clearances of those lands that a visit found with one verdict."""
    um = say.convert(UM, "clearance")
    at: list[LandDiagnosis | None] = [getattr(land, side) for land in lands]
    here = [each if each and each.state.measured and each.verdict == verdict else None for each in at]
    intervals = [each and each.uncertainty and each.uncertainty.clearance_interval for each in here]
    more = {
        "spans": [each and (each[0] * um, each[1] * um) for each in intervals],
        "lift": lift,
        "open": [side == "before"] * len(lands),
    }
    values = [None if each is None else each.state.radial_clearance * um for each in here]
    return f"{say(f'compare.{side}')}: {say.level(verdict)}", look_of(verdict), values, more


def total_chart(comparison: Comparison, shown: Sequence[ConditionComparison], say: Wording) -> RowChart:
    """Return the total before and after at each condition, in the shade of its band, beside that of the unit new.

    Signs show where a band begins. An interval without an end reaches as far as anything that has one.
    """
    unit, alike = comparison.before, comparison.alike
    rows = [
        (each, side, diagnosis, at)
        for each in shown
        for side, diagnosis, at in (("before", unit, each.before), ("after", alike, each.alike))
        if at is not None
    ]
    shares = [at.share * PERCENT for *_, at in rows]
    new = [unit.new_at(each.projection).share * PERCENT for each, *_ in rows]
    spans = [_share_interval(diagnosis, at) for _, _, diagnosis, at in rows]
    ends = (*shares, *new, *(end for span in spans for end in span or ()))
    right = max(filter(math.isfinite, ends), default=1.0)
    drawn = [span and (min(span[0], right), min(span[1], right)) for span in spans]
    bands = [diagnosis.band(at) or Band.GREEN for _, _, diagnosis, at in rows]
    steps = [None if each.before is None else unit.total_rule(each.before).steps for each, *_ in rows]

    def bar(band: Band) -> LayerOf:
        values = [min(share, right) if own is band else None for share, own in zip(shares, bands, strict=True)]
        return say.level(band), look_of(band), values, {"spans": drawn, "thick": 0.6}

    def begins(band: Band) -> LayerOf:
        limits = [None if each is None else each.limit_of(band) for each in steps]
        values = [None if each is None or each * PERCENT >= right else each * PERCENT for each in limits]
        return say.level(band), look_of(band), values, {"lift": -0.5}

    layers = layers_of((*map(bar, Band), (say("comparison.new"), STATED_INKS, new, {}), *map(begins, Band)))
    names = [
        f"{say.condition(each.projection.condition)}, {say(f'comparison.{side}').lower()}" for each, side, *_ in rows
    ]
    return RowChart(names, layers, say("comparison.axis"), [f"{say.number(share, 1)} %" for share in shares])


def _share_interval(diagnosis: Diagnosis, at: Projection) -> tuple[float, float] | None:
    total = diagnosis.uncertainty.total(at.condition.name) if diagnosis.uncertainty else None
    return None if total is None else (total.share_interval[0] * PERCENT, total.share_interval[1] * PERCENT)


def _limit(land: LandDiagnosis) -> float | None:
    """Return the clearance at which the land first reaches a limit of wear or clearance [m]; None without one."""
    levels = [(rule.kind, limit) for rule in land.rules for _, limit in rule.steps.levels]
    limits = [land.state.land.mounting_high * (1.0 + limit) for kind, limit in levels if kind is RuleKind.WEAR]
    limits += [limit for kind, limit in levels if kind is RuleKind.CLEARANCE]
    return min(limits, default=None)


def logs_over_one_another(logs: LogComparison, pair: EventPair, scales: Scales, say: Wording) -> Figure:
    """Draw the channels that both logs hold around an event, each log from the event's own start.

    ``scales`` has, by quantity, the unit's name and the function from SI to that unit, where one is shown in another.
    """
    parts = [(name, *window) for name, window in zip(("before", "after"), logs.windows(pair), strict=True)]
    common = [
        quantity
        for quantity in parts[0][1].channels
        if all((channel := test.channel(quantity)) is not None and channel.samples for _, test, _ in parts)
    ]
    rows = max(len(common), 1)
    figure = Figure(rows, 0.03)
    looks = {"before": (SCREEN.share, "dash"), "after": (SCREEN.leakage, "solid")}
    for row, quantity in enumerate(common, start=1):
        unit, convert = scales.get(quantity, ("", np.asarray))
        for side, test, start in parts:
            channel = test.channel(quantity)
            assert channel is not None
            time, values = _samples(channel, test.time, start)
            keep, name, (colour, dash) = thinned([values], _POINTS), say(f"compare.{side}"), looks[side]
            legend = {"name": name, "legendgroup": side, "showlegend": row == 1, "hover": f"{name}: %{{y:.5g}}"}
            shape = "hv" if quantity in _STEPS else "linear"
            figure.line(time[keep], convert(values[keep]), colour, 2, dash, shape=shape, row=row, **legend)
        label = QUANTITIES[quantity].label.replace(" (", "<br>(")
        figure.update_yaxes(title=f"{label}<br>[{unit}]" if unit else label, row=row)
    figure.add_vline(x=0.0, line={"dash": "dot", "width": 1, "color": SCREEN.soft})
    figure.update_xaxes(title=say("figures.time_from_event"), row=rows)
    return framed(figure, 110 + 140 * rows, hovermode="x unified")


def _samples(channel: Channel, time: np.ndarray, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a channel's own stamps from the start of the event on, and its good samples; of a constant both ends."""
    if channel.source == "constant":
        return time[[0, -1]] - start, np.full(2, channel.values[0])
    return channel.time - start, channel.good
