"""Draw two visits of one unit: clearances before and after against their limits, and two logs over one another."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from atleak.catalogue.limits import RuleKind
from atleak.comparison import Comparison, EventPair, LandComparison, LogComparison
from atleak.figures.figure import Figure
from atleak.figures.frame import by_land, error_bars, framed
from atleak.land_diagnosis import LandDiagnosis
from atleak.look import SCREEN, look_of
from atleak.road_test import QUANTITIES, Channel
from atleak.thinning import thinned
from atleak.verdicts import VERDICTS
from atleak.views.log_rows import Scales
from atleak.wording import Wording
from atleak.workshop_units import UM

POINTS = 1500  # samples of a channel that are drawn of each log
_STEPS = ("gear", "selector", "lock_up")  # channels that hold their value until the next sample


def clearances(comparison: Comparison, lands: Sequence[LandComparison], say: Wording) -> Figure:
    """Draw the clearances of lands before (open) and after (filled), a line between them, with their 95 % intervals.

    Marks are the mounting clearance and the lowest limit of wear or clearance, as they stand after.
    """
    names = [_name(land) for land in lands]
    figure, um, unit = Figure(), say.convert(UM, "clearance"), say.unit("clearance")
    number = f"%{{x:.{say.digits('clearance', 1)}f}} {unit}"
    for name, symbol, value in (
        (say("figures.mounting"), "line-ns-open", _mounting),
        (say("figures.first_limit"), "triangle-down-open", _limit),
    ):
        marks = [(mark * um, _name(land)) for land in lands if (mark := value(land)) is not None]
        if marks:
            figure.add_scatter(
                x=[mark for mark, _ in marks],
                y=[land for _, land in marks],
                mode="markers",
                name=name,
                marker={"color": SCREEN.rule, "symbol": symbol, "size": 13, "line": {"width": 1.5}},
                hovertemplate=f"%{{y}}: {name} {number}<extra></extra>",
            )
    both = [land for land in lands if land.change is not None]
    figure.add_scatter(
        x=[end for land in both if land.change for end in (land.change.before * um, land.change.after * um, None)],
        y=[end for land in both for end in (_name(land), _name(land), None)],
        mode="lines",
        line={"color": SCREEN.soft, "width": 2},
        hoverinfo="skip",
        showlegend=False,
    )
    named: set[str] = set()
    for side, opened in (("before", "-open"), ("after", "")):
        sides = [(land, each) for land in lands if (each := getattr(land, side)) is not None and each.state.measured]
        for verdict in VERDICTS:
            these = [(land, each) for land, each in sides if each.verdict == verdict]
            if not these:
                continue
            look = look_of(verdict)
            values = [each.state.radial_clearance for _, each in these]
            spans = [each.uncertainty.clearance_interval if each.uncertainty else None for _, each in these]
            figure.add_scatter(
                x=[value * um for value in values],
                y=[_name(land) for land, _ in these],
                mode="markers",
                name=say.level(verdict),
                legendgroup=verdict,
                showlegend=verdict not in named,
                marker={
                    "color": look.screen,
                    "symbol": f"{look.marker.removesuffix('-open')}{opened}",
                    "size": 11,
                    "line": {"width": 2, "color": look.screen},
                },
                error_x=error_bars(values, spans, um, look.screen),
                hovertemplate=f"%{{y}} {say(f'compare.{side}')}: {number}<extra></extra>",
            )
            named.add(verdict)
    figure.update_xaxes(title=say("figures.clearance", unit=unit, coverage=say.percent(0.95, 0)), rangemode="tozero")
    return by_land(figure, names, 32, say)


def _name(land: LandComparison) -> str:
    component, number = land.key
    return f"{component} · {number}"


def _latest(land: LandComparison) -> LandDiagnosis:
    latest = land.after or land.before
    assert latest is not None
    return latest


def _mounting(land: LandComparison) -> float | None:
    return _latest(land).state.land.mounting_high


def _limit(land: LandComparison) -> float | None:
    """Return the clearance at which the land first reaches a limit of wear or clearance [m]; None without one."""
    new, limits = _latest(land).state.land.mounting_high, []
    for rule in _latest(land).rules:
        for _, limit in rule.steps.levels:
            if rule.kind is RuleKind.WEAR:
                limits.append(new * (1.0 + limit))
            elif rule.kind is RuleKind.CLEARANCE:
                limits.append(limit)
    return min(limits, default=None)


def logs_over_one_another(
    logs: LogComparison, pair: EventPair, scales: Scales, say: Wording, points: int = POINTS
) -> Figure:
    """Draw the channels that both logs hold around an event, each log from the event's own start.

    Parameters
    ----------
    scales
        quantity → unit's name and the function from SI to that unit, for quantities shown in another unit than SI.
    points
        of a channel that are drawn of each log; its lowest and highest samples stay.
    """
    parts = [(name, *window) for name, window in zip(("before", "after"), logs.windows(pair), strict=True)]
    common = [
        quantity
        for quantity in parts[0][1].channels
        if all((channel := test.channel(quantity)) is not None and channel.samples for _, test, _ in parts)
    ]
    figure = Figure(max(len(common), 1), 0.03)
    looks = {"before": {"color": SCREEN.share, "dash": "dash"}, "after": {"color": SCREEN.leakage}}
    for row, quantity in enumerate(common, start=1):
        unit, convert = scales.get(quantity, ("", _as_it_is))
        for name, test, start in parts:
            channel = test.channel(quantity)
            assert channel is not None
            time, values = _samples(channel, test.time, start)
            keep = thinned([values], points)
            figure.add_scatter(
                x=time[keep],
                y=convert(values[keep]),
                name=say(f"compare.{name}"),
                legendgroup=name,
                showlegend=row == 1,
                mode="lines",
                line={"width": 2, "shape": "hv" if quantity in _STEPS else "linear", **looks[name]},
                connectgaps=False,
                hovertemplate=f"{say(f'compare.{name}')}: %{{y:.5g}}<extra></extra>",
                row=row,
            )
        label = QUANTITIES[quantity].label.replace(" (", "<br>(")
        figure.update_yaxes(title=f"{label}<br>[{unit}]" if unit else label, row=row)
    figure.add_vline(x=0.0, line={"dash": "dot", "width": 1, "color": SCREEN.soft})
    figure.update_xaxes(title=say("figures.time_from_event"), row=max(len(common), 1))
    return framed(figure, 110 + 140 * max(len(common), 1), hovermode="x unified")


def _samples(channel: Channel, time: np.ndarray, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a channel's own stamps from the start of the event on, and its good samples; of a constant both ends."""
    if channel.source == "constant":
        return time[[0, -1]] - start, np.full(2, channel.values[0])
    return channel.time - start, channel.good


_as_it_is: Callable[[np.ndarray], np.ndarray] = np.asarray
