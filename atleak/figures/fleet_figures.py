"""Draw a fleet: verdicts, pairs that give trouble, wear over mileage, share and pressure over temperature, groups.

What is spread over units is drawn as boxes: a pale one in which nine of ten units are, a darker one with half of them,
and the median. Of too few units there is a thin line from the least to the most in place of the boxes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.figures.figure import Figure
from atleak.figures.frame import error_bars, framed
from atleak.fleet.summed import (
    Difference,
    Group,
    LandOverMileage,
    PairTrouble,
    TemperatureClass,
    VerdictCounts,
    WearDifference,
)
from atleak.look import FAINT_GRID, HATCHING, OK_IN_PART, SCREEN, SPREADS_ON_SCREEN, look_of
from atleak.spreads import PARTS, Rate, Spread
from atleak.verdicts import BANDS, FLAGGED, VERDICTS, Band, Verdict
from atleak.wording import Wording
from atleak.workshop_units import PERCENT

_HATCH = {"fillmode": "overlay", "fgcolor": HATCHING, "size": 7, "solidity": 0.2}
_WIDTH = 0.86  # of a box, of its class
_ABOVE = 0.27  # the middle of a row, parts of its height: where its name stands
_THICK = 0.5  # of a bar, of its row
_NARROW = 0.3  # of the bar of units past *replace*, over that of units that are flagged
_ROOM = 4.0  # [%] of a bar's length that a number in it takes
_HOUR = 3600.0  # [s]
_MARKS = dict(zip(FLAGGED, np.linspace(0.17, -0.17, len(FLAGGED)), strict=True))  # of a group, above its row's middle


# --- verdicts


def verdicts(rows: Sequence[tuple[str, VerdictCounts]], say: Wording) -> Figure:
    """Draw how the verdicts of the units are parted, a row for each name, the first on top.

    Units that are ok as far as they were measured, and not at every land, stand apart from those that are ok.
    """
    figure = Figure()
    names = [name for name, _ in rows]
    for what, counts, marker in _stacked(rows, say):
        parts = [(PERCENT * count / of.units if of.units else 0.0) for count, (_, of) in zip(counts, rows, strict=True)]
        figure.add_bar(
            y=_places(names),
            x=parts,
            orientation="h",
            width=_THICK,
            name=what,
            marker={**marker, "line": {"width": 0}},
            text=[say.number(count, 0) if part >= _ROOM else "" for count, part in zip(counts, parts, strict=True)],
            textposition="inside",
            insidetextanchor="middle",
            constraintext="none",
            textangle=0,
            customdata=[
                f"{name}<br>{what}: {_counted(count, of.units, say)}"
                for count, (name, of) in zip(counts, rows, strict=True)
            ],
            hovertemplate="%{customdata}, %{x:.1f} %<extra></extra>",
        )
    figure.update_xaxes(title=say("fleet_summary.chart_verdicts"), range=[0.0, PERCENT])
    return _named_rows(figure, names, barmode="stack")


def _places(names: Sequence[str]) -> list[int]:
    """Return the height of every row's middle, the first on top."""
    return list(range(len(names)))[::-1]


def _named_rows(figure: Figure, names: Sequence[str], barmode: str | None = None) -> Figure:
    """Lay out rows, each with its name above it: names are long, and a phone is narrow."""
    for name, place in zip(names, _places(names), strict=True):
        figure.add_annotation(x=0.0, y=place + _ABOVE, xref="x domain", text=name, xanchor="left", yanchor="bottom")
    figure.update_yaxes(range=[-_ABOVE - 0.1, len(names) - 0.2], showticklabels=False, showgrid=False)
    return framed(figure, 170 + 46 * max(len(names), 1), barmode=barmode)


def _stacked(
    rows: Sequence[tuple[str, VerdictCounts]], say: Wording
) -> Iterator[tuple[str, list[int], dict[str, Any]]]:
    """Yield the parts of the bars that any unit is in: name, units of every row, looks."""
    yield from (
        (say.signed(verdict), [counts.verdicts[verdict] for _, counts in rows], _shade(verdict))
        for verdict in reversed(FLAGGED)
        if any(counts.verdicts[verdict] for _, counts in rows)
    )
    whole = [counts.ok_throughout for _, counts in rows]
    if any(whole):
        yield say.signed(Verdict.OK), whole, _shade(Verdict.OK)
    in_part = [counts.ok_in_part for _, counts in rows]
    if any(in_part):
        yield say("fleet.ok_in_part"), in_part, {"color": OK_IN_PART.screen}
    unmeasured = [counts.verdicts[Verdict.NOT_MEASURED] for _, counts in rows]
    if any(unmeasured):
        yield say.signed(Verdict.NOT_MEASURED), unmeasured, _shade(Verdict.NOT_MEASURED)


def _shade(level: Verdict | Band) -> dict[str, Any]:
    look = look_of(level)
    return {"color": look.screen, "pattern": {**_HATCH, "shape": look.pattern}}


def or_worse(level: Verdict | Band, say: Wording) -> str:
    """Name a level and those that are worse, with its sign."""
    is_worst = level in (VERDICTS[-1], BANDS[-1])
    return say.signed(level) if is_worst else say("fleet_summary.or_worse", level=say.signed(level))


# --- pairs


def pairs(troubles: Sequence[PairTrouble], names: Sequence[str], say: Wording) -> Figure:
    """Draw in which share of the units pairs are flagged and at *replace* or past it, the most often on top.

    Lines are the 95 % intervals of the latter. Of too few units words beside the bar say so instead, with the count.
    """
    figure, places = Figure(), _places(names)
    for rates, level, width in (
        ([each.flagged for each in troubles], FLAGGED[0], _THICK),
        ([each.replace for each in troubles], Verdict.REPLACE, _NARROW),
    ):
        values, spans = [rate.percent or 0.0 for rate in rates], [_span(rate) for rate in rates]
        figure.add_bar(
            y=places,
            x=values,
            orientation="h",
            width=width,
            name=or_worse(level, say),
            marker=_shade(level),
            error_x=error_bars(values, spans, 1.0) if level is Verdict.REPLACE else None,
            text=["" if rate.enough or level is Verdict.REPLACE else _few(rate, say) for rate in rates],
            textposition="outside",
            customdata=[
                f"{name}<br>{or_worse(level, say)}: {_rate(rate, say)}" for name, rate in zip(names, rates, strict=True)
            ],
            hovertemplate="%{customdata}<extra></extra>",
        )
    deciding = [each for each in zip(troubles, names, places, strict=True) if each[0].deciding.count]
    figure.add_scatter(
        x=[each.deciding.percent or 0.0 for each, _, _ in deciding],
        y=[place for _, _, place in deciding],
        mode="markers",
        name=say("fleet.deciding"),
        marker={"symbol": "diamond", "size": 9, "color": SCREEN.ink, "line": {"width": 1, "color": SCREEN.ink}},
        customdata=[f"{name}<br>{say('fleet.deciding')}: {_rate(each.deciding, say)}" for each, name, _ in deciding],
        hovertemplate="%{customdata}<extra></extra>",
    )
    figure.update_xaxes(title=say("fleet_summary.chart_pairs"), rangemode="tozero")
    return _named_rows(figure, names, barmode="overlay")


def _span(rate: Rate) -> tuple[float, float] | None:
    return None if rate.low_percent is None or rate.high_percent is None else (rate.low_percent, rate.high_percent)


def _rate(rate: Rate, say: Wording) -> str:
    """Return how many of how many, and the share of units with its interval where there are enough."""
    counted = _counted(rate.count, rate.of, say)
    span = _span(rate)
    if span is None:
        return counted
    low, high = (say.number(end, 1) for end in span)
    return f"{counted}: {say.number(rate.percent, 1)} % ({low}–{high})"


def _few(rate: Rate, say: Wording) -> str:
    return say("fleet.too_few", rate=_counted(rate.count, rate.of, say))


def _counted(count: int, of: int, say: Wording) -> str:
    return say("fleet_summary.chart_rate", count=say.number(count, 0), of=say.number(of, 0))


# --- spreads


@dataclass(frozen=True)
class _Boxes:
    """Spreads over classes of a quantity, in the units of the axes."""

    figure: Figure
    row: int
    edges: Sequence[tuple[float, float]]
    spreads: Sequence[Spread | None]
    names: Sequence[str]  # of the classes
    say: Wording
    kind: str  # of quantity

    def draw(self, *, legend: bool) -> None:
        """Draw boxes where there are enough units, thin lines elsewhere, and the medians."""
        here = [each for each in zip(self.edges, self.spreads, self.names, strict=True) if each[1] is not None]
        enough = [each for each in here if each[1] is not None and each[1].quantiles is not None]
        for number, shade in enumerate(SPREADS_ON_SCREEN):
            low, high = number, len(PARTS) - 1 - number
            quantiles = [(spread.quantiles or ()) if spread else () for _, spread, _ in enough]
            ends = [[self._shown(each[place]) for each in quantiles] for place in (low, high)]
            self.figure.add_bar(
                row=self.row,
                x=[_middle(edge) for edge, _, _ in enough],
                base=ends[0],
                y=[top - bottom for bottom, top in zip(*ends, strict=True)],
                width=[(edge[1] - edge[0]) * (_WIDTH - 0.3 * number) for edge, _, _ in enough],
                name=self.say(f"fleet.{'most' if number == 0 else 'half'}"),
                legendgroup=f"spread-{number}",
                showlegend=legend,
                marker={"color": shade, "line": {"width": 0}},
                hoverinfo="skip",
            )
        few = [each for each in here if each not in enough]
        self.figure.add_scatter(
            row=self.row,
            x=[at for edge, _, _ in few for at in (_middle(edge), _middle(edge), None)],
            y=[end for _, spread, _ in few if spread for end in (*map(self._shown, (spread.least, spread.most)), None)],
            mode="lines",
            name=self.say("fleet.few"),
            legendgroup="few",
            showlegend=legend and bool(few),
            line={"color": SCREEN.leakage, "width": 1.5},
            hoverinfo="skip",
        )
        self.figure.add_scatter(
            row=self.row,
            x=[_middle(edge) for edge, _, _ in here],
            y=[self._shown(spread.median) for _, spread, _ in here if spread],
            mode="markers+lines",
            name=self.say("fleet.median"),
            legendgroup="median",
            showlegend=legend,
            line={"color": SCREEN.leakage, "width": 2},
            marker={
                "size": 9,
                "color": SCREEN.leakage,
                "symbol": ["circle" if each in enough else "circle-open" for each in here],
                "line": {"width": 2, "color": SCREEN.leakage},
            },
            customdata=[f"{name}<br>{_spread_words(spread, self.kind, self.say)}" for _, spread, name in here],
            hovertemplate="%{customdata}<extra></extra>",
        )

    def _shown(self, value: float) -> float:
        return float(self.say.convert(value, self.kind))


def _middle(edges: tuple[float, float]) -> float:
    return 0.5 * (edges[0] + edges[1])


def _spread_words(spread: Spread | None, kind: str, say: Wording) -> str:
    if spread is None:
        return ""
    units = say("fleet.one_unit") if spread.units == 1 else say("fleet.units", count=say.number(spread.units, 0))
    median = say("fleet.median_of", value=say.quantity(spread.median, kind))
    if spread.quantiles is None:
        ends = say("fleet.from_to", ends=say.span([spread.least, spread.most], kind))
        return f"{median}, {ends}<br>{say('fleet.few_of', units=units)}"
    most, half = (say.span([spread.quantiles[at], spread.quantiles[-1 - at]], kind) for at in range(2))
    return f"{median}<br>{say('fleet.most')}: {most}<br>{say('fleet.half')}: {half}<br>{units}"


def _units_below(
    figure: Figure, row: int, edges: Sequence[tuple[float, float]], units: Sequence[int], say: Wording
) -> None:
    """Draw how many units each class has."""
    figure.add_bar(
        row=row,
        x=[_middle(edge) for edge in edges],
        y=list(units),
        width=[(edge[1] - edge[0]) * _WIDTH for edge in edges],
        name=say("fleet_summary.over_units"),
        marker={"color": SCREEN.rule, "opacity": 0.5, "line": {"width": 0}},
        showlegend=False,
        hovertemplate="%{y:,.0f}<extra></extra>",
    )
    figure.update_yaxes(row=row, title=say("fleet_summary.over_units"), rangemode="tozero", nticks=3)


# --- wear


def wear_over_mileage(land: LandOverMileage, say: Wording) -> Figure:
    """Draw how the wear of a land is spread over the units of each class of mileage, and how many those are."""
    figure = Figure(rows=2, spacing=0.06, heights=(0.78, 0.22))
    edges = [_shown_span(each.low_km, each.high_km, "distance", say) for each in land.classes]
    names = [say.span([each.low_km, each.high_km], "distance", 0) for each in land.classes]
    spreads = [each.wear_percent for each in land.classes]
    _Boxes(figure, 1, edges, spreads, names, say, "percent").draw(legend=True)
    _units_below(figure, 2, edges, [spread.units for spread in spreads], say)
    figure.update_yaxes(row=1, title=say("fleet_summary.chart_wear"), gridcolor=FAINT_GRID)
    figure.update_xaxes(row=2, title=say("fleet_summary.chart_mileage"))
    figure.update_xaxes(tickformat=",.0f", range=[0.0, max((edge[1] for edge in edges), default=1.0)])
    return framed(figure, 440, barmode="overlay")


def _shown_span(low: float, high: float, kind: str, say: Wording) -> tuple[float, float]:
    return float(say.convert(low, kind)), float(say.convert(high, kind))


# --- temperatures


def over_temperature(classes: Sequence[TemperatureClass], say: Wording) -> Figure:
    """Draw share, main pressure and time in the bands of the share over the temperature of the fluid in the logs.

    A row that no log tells anything of is left out.
    """
    shares = [each.share_percent for each in classes]
    pressures = [each.pressure_kpa for each in classes]
    parts = [
        *([("share", 0.4)] if any(shares) else []),
        *([("pressure", 0.34)] if any(pressures) else []),
        *([("bands", 0.26)] if any(each.bands_percent for each in classes) else []),
    ]
    figure = Figure(rows=max(len(parts), 1), spacing=0.05, heights=[height for _, height in parts] or None)
    edges = [_shown_span(each.low_c, each.high_c, "temperature", say) for each in classes]
    names = [say.span([each.low_c, each.high_c], "temperature", 0) for each in classes]
    for row, (part, _) in enumerate(parts, start=1):
        if part == "bands":
            _bands(figure, row, classes, edges, say)
        elif part == "share":
            _Boxes(figure, row, edges, shares, names, say, "percent").draw(legend=row == 1)
            means = [each.share_mean_percent for each in classes]
            extremes = [each.share_max_percent for each in classes]
            _means(figure, row, edges, means, extremes, "percent", say)
        else:
            _Boxes(figure, row, edges, pressures, names, say, "pressure").draw(legend=row == 1)
            means = [each.pressure_mean_kpa for each in classes]
            extremes = [each.pressure_min_kpa for each in classes]
            _means(figure, row, edges, means, extremes, "pressure", say)
        figure.update_yaxes(row=row, title=say(f"fleet_summary.over_{part}"), gridcolor=FAINT_GRID)
    if edges:
        figure.update_xaxes(range=[edges[0][0], edges[-1][1]])
    figure.update_xaxes(row=figure.rows, title=say("fleet_summary.chart_temperature"))
    return framed(figure, 140 + 170 * figure.rows, barmode="overlay")


def _means(
    figure: Figure,
    row: int,
    edges: Sequence[tuple[float, float]],
    means: Sequence[float | None],
    extremes: Sequence[float | None],
    kind: str,
    say: Wording,
) -> None:
    """Draw the mean of all the time, and the largest share or the lowest pressure of any unit."""
    extreme, symbol = ("largest", "triangle-up-open") if kind == "percent" else ("lowest", "triangle-down-open")
    for what, values, mark in (("mean", means, "diamond"), (extreme, extremes, symbol)):
        here = [(edge, value) for edge, value in zip(edges, values, strict=True) if value is not None]
        figure.add_scatter(
            row=row,
            x=[_middle(edge) for edge, _ in here],
            y=[float(say.convert(value, kind)) for _, value in here],
            mode="markers",
            name=say(f"fleet.{what}"),
            legendgroup=what,
            showlegend=what != "mean" or row == 1,
            marker={"symbol": mark, "size": 8, "color": SCREEN.ink, "line": {"width": 1.5, "color": SCREEN.ink}},
            customdata=[say.quantity(value, kind) for _, value in here],
            hovertemplate=f"{say(f'fleet.{what}')}: %{{customdata}}<extra></extra>",
        )


def _bands(
    figure: Figure,
    row: int,
    classes: Sequence[TemperatureClass],
    edges: Sequence[tuple[float, float]],
    say: Wording,
) -> None:
    """Draw which part of the time the share was in each band, one above the other."""
    here = [each for each in zip(classes, edges, strict=True) if each[0].bands_percent]
    base = [0.0] * len(here)
    for name, parts, marker in _parts_of_time([each for each, _ in here], say):
        figure.add_bar(
            row=row,
            x=[_middle(edge) for _, edge in here],
            y=parts,
            base=list(base),
            width=[(edge[1] - edge[0]) * _WIDTH for _, edge in here],
            name=name,
            showlegend=any(parts),
            marker={**marker, "line": {"width": 0}},
            customdata=[say("fleet.hours", hours=say.number(each.seconds / _HOUR, 1)) for each, _ in here],
            hovertemplate=f"{name}: %{{y:.1f}} %<br>%{{customdata}}<extra></extra>",
        )
        base = [below + part for below, part in zip(base, parts, strict=True)]
    figure.update_yaxes(row=row, range=[0.0, PERCENT])


def _parts_of_time(
    classes: Sequence[TemperatureClass], say: Wording
) -> Iterator[tuple[str, list[float], dict[str, Any]]]:
    """Yield the parts of the time from below: green, green as far as it was measured, the other bands; with looks."""
    for band in BANDS:
        parts = [(each.bands_percent or {})[band] for each in classes]
        if band is Band.GREEN:
            in_part = [each.green_in_part_percent for each in classes]
            parts = [whole - part for whole, part in zip(parts, in_part, strict=True)]
            yield say.signed(band), parts, _shade(band)
            yield say("fleet.green_in_part"), in_part, {"color": OK_IN_PART.screen}
        else:
            yield say.signed(band), parts, _shade(band)


# --- groups


def rates_of_groups(groups: Sequence[Group], say: Wording) -> Figure:
    """Draw which share of each group's units is at a verdict or past it, with 95 % intervals, the first group on top.

    Of a group with too few units there are no marks: words say how many of how many are at *replace* or past it.
    """
    figure = Figure()
    names = [group.name for group in groups]
    height = dict(zip(names, _places(names), strict=True))
    for verdict in FLAGGED:
        look = look_of(verdict)
        rates = [(group, group.counts.rates[verdict]) for group in groups if group.counts.rates[verdict].enough]
        values = [rate.percent or 0.0 for _, rate in rates]
        figure.add_scatter(
            x=values,
            y=[height[group.name] + _MARKS[verdict] for group, _ in rates],
            mode="markers",
            cliponaxis=False,
            name=or_worse(verdict, say),
            marker={
                "symbol": look.marker,
                "size": 10,
                "color": look.screen,
                "line": {"width": 1, "color": look.screen},
            },
            error_x=error_bars(values, [_span(rate) for _, rate in rates], 1.0, look.screen) if rates else None,
            customdata=[f"{group.name}: {_rate(rate, say)}" for group, rate in rates],
            hovertemplate=f"%{{customdata}}<br>{or_worse(verdict, say)}<extra></extra>",
        )
    few = [group for group in groups if not group.counts.rates[Verdict.REPLACE].enough]
    if few:
        figure.add_scatter(
            x=[0.0 for _ in few],
            y=[height[group.name] for group in few],
            mode="text",
            text=[_few(group.counts.rates[Verdict.REPLACE], say) for group in few],
            textposition="middle right",
            showlegend=False,
            hoverinfo="skip",
        )
    figure.update_xaxes(title=say("fleet_summary.chart_groups"), rangemode="tozero")
    return _named_rows(figure, names)


def wear_differences(found: Sequence[WearDifference], names: Sequence[str], say: Wording) -> Figure:
    """Draw by how much the wear of lands differs between two groups, with intervals that hold for all at once.

    Marks are filled where the interval leaves out zero: in the mean, and within classes of mileage. A difference
    without an interval is not drawn.
    """
    figure = Figure()
    for what, offset, symbol, colour in (
        ("in_the_mean", 0.1, "circle", SCREEN.leakage),
        ("at_same_mileage", -0.1, "diamond", SCREEN.share),
    ):
        of_each = [each.mean_points if what == "in_the_mean" else each.same_mileage_points for each in found]
        rows = list(_with_interval(of_each, names))
        values = [points.value for _, _, points in rows]
        spans = [(points.low_of_all or 0.0, points.high_of_all or 0.0) for _, _, points in rows]
        figure.add_scatter(
            x=values,
            y=[len(names) - 1 - place + offset for place, _, _ in rows],
            mode="markers",
            name=say(f"fleet.{what}"),
            marker={
                "symbol": [symbol if points.differs else f"{symbol}-open" for _, _, points in rows],
                "size": 10,
                "color": colour,
                "line": {"width": 2, "color": colour},
            },
            error_x=error_bars(values, spans, 1.0, colour) if rows else None,
            customdata=[
                f"{name}<br>{say.number(points.value, 1)} ({say.number(low, 1)} … {say.number(high, 1)})"
                for (_, name, points), (low, high) in zip(rows, spans, strict=True)
            ],
            hovertemplate=f"%{{customdata}}<br>{say(f'fleet.{what}')}<extra></extra>",
        )
    figure.add_vline(x=0.0, line={"color": SCREEN.rule, "width": 1.5, "dash": "dot"})
    figure.update_xaxes(title=say("fleet.difference_of_wear"))
    return _named_rows(figure, names)


def _with_interval(
    differences: Iterable[Difference | None], names: Sequence[str]
) -> Iterator[tuple[int, str, Difference]]:
    for place, (points, name) in enumerate(zip(differences, names, strict=True)):
        if points is not None and points.differs is not None:
            yield place, name, points
