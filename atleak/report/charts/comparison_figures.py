"""Draw two visits of one unit: clearances before and after against their limits, and two logs over one another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from atleak.analysis.comparison import Comparison, EventPair, LandComparison, LogComparison
from atleak.catalogue.limits import RuleKind
from atleak.common.style import SCREEN, look_of
from atleak.common.thinning import thinned
from atleak.common.unit_systems import UM
from atleak.common.verdicts import VERDICTS
from atleak.common.wording import Wording
from atleak.diagnosis.land import LandDiagnosis
from atleak.measurements.road_test import QUANTITIES, Channel
from atleak.report.charts.figure import Figure, by_land, framed
from atleak.report.tables.road_test import Scales

_POINTS = 1500  # samples of a channel that are drawn of each log
_STEPS = ("gear", "selector", "lock_up")  # channels that hold their value until the next sample


def compared_clearances(comparison: Comparison, lands: Sequence[LandComparison], say: Wording) -> Figure:
    """Draw the clearances of lands before (open) and after (filled), a line between them, with their 95 % intervals.

    Marks are the mounting clearance and the lowest limit of wear or clearance, as they stand after.
    """
    names = {land.key: f"{land.key[0]} · {land.key[1]}" for land in lands}
    latest = {names[each.key]: each for land in lands if (each := land.after or land.before) is not None}
    figure, um, unit = Figure(), say.convert(UM, "clearance"), say.unit("clearance")
    number = f"%{{x:.{say.digits('clearance', 1)}f}} {unit}"
    new = {name: land.state.land.mounting_high for name, land in latest.items()}
    limits = {name: limit for name, land in latest.items() if (limit := _limit(land)) is not None}
    for key, symbol, marked in (("mounting", "line-ns-open", new), ("first_limit", "triangle-down-open", limits)):
        open_mark(figure, [*marked.values()], [*marked], say(f"figures.{key}"), symbol, um, number)
    both = [(names[land.key], land.change) for land in lands if land.change is not None]
    ends = [end for _, change in both for end in (change.before * um, change.after * um, None)]
    figure.line(ends, [end for name, _ in both for end in (name, name, None)], SCREEN.soft, 2)
    named: set[str] = set()
    for side, opened in (("before", "-open"), ("after", "")):
        sides = [each for land in lands if (each := getattr(land, side)) is not None and each.state.measured]
        for verdict in VERDICTS:
            these = [land for land in sides if land.verdict == verdict]
            if not these:
                continue
            look, hover = look_of(verdict), f"%{{y}} {say(f'compare.{side}')}: {number}"
            mark = (look.screen, f"{look.marker.removesuffix('-open')}{opened}", 11, 2.0)
            spans = [land.uncertainty.clearance_interval if land.uncertainty else None for land in these]
            legend = {"legendgroup": verdict, "showlegend": verdict not in named}
            values, places = [each.state.radial_clearance for each in these], [names[each.key] for each in these]
            figure.marks(values, places, say.level(verdict), mark, factor=um, spans=spans, hover=hover, **legend)
            named.add(verdict)
    figure.update_xaxes(title=say("figures.clearance", unit=unit, coverage=say.percent(0.95, 0)), rangemode="tozero")
    return by_land(figure, [*names.values()], 32, say)


def open_mark(
    figure: Figure, values: Sequence[float | None], lands: Sequence[str], name: str, symbol: str, um: float, number: str
) -> None:
    """Draw what clearances stand against, open, so that it covers no value; nothing without any."""
    if any(value is not None for value in values):
        mark = (SCREEN.rule, symbol, 13, 1.5)
        figure.marks(values, lands, name, mark, factor=um, hover=f"%{{y}}: {name} {number}")


def _limit(land: LandDiagnosis) -> float | None:
    """Return the clearance at which the land first reaches a limit of wear or clearance [m]; None without one."""
    new, levels = (
        land.state.land.mounting_high,
        [(rule.kind, limit) for rule in land.rules for _, limit in rule.steps.levels],
    )
    limits = [new * (1.0 + limit) for kind, limit in levels if kind is RuleKind.WEAR]
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
