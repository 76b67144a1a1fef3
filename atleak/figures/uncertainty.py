"""How sure a unit's numbers are, as plotly figures: intervals, limits, and what the uncertainty is made of.

A decision is told by its symbol and its words as well as by its colour. Units are those people read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import plotly.graph_objects as go

from atleak.equations.gap import FULLY_ECCENTRIC
from atleak.figures.diagnosis import BAND_COLOURS, BAND_SYMBOLS
from atleak.limits import Limits, Steps
from atleak.uncertainty import DECISIONS, Decision, LandUncertainty, UnitUncertainty
from atleak.workshop_units import DM3_MIN, PERCENT, UM

COLOURS: dict[Decision, str] = {
    "pass": "#2f9e62",
    "conditional_pass": "#7aa621",
    "conditional_fail": "#e07b00",
    "fail": "#d1383d",
}
SYMBOLS: dict[Decision, str] = {
    "pass": "circle",
    "conditional_pass": "circle-open",
    "conditional_fail": "square-open",
    "fail": "square",
}
_NEUTRAL = "#8793a0"


def decision_words(decision: Decision) -> str:
    """For people: ``"conditional pass"``."""
    return decision.replace("_", " ")


def clearances(unit: UnitUncertainty, limits: Limits, lands: int = 20) -> go.Figure:
    """Radial clearances with their intervals, beside the mounting clearance and the limit that decides.

    Parameters
    ----------
    limits
        the set the unit was assessed with.
    lands
        how many are drawn: those likeliest to be over a limit.
    """
    chosen = _chosen(unit, lands)
    figure = go.Figure()
    marks = {  # drawn first, open, so that they cover no value
        "mounting clearance": ("line-ns-open", [land.sources.state.land.mounting_clearance for land in chosen]),
        "limit": ("triangle-down-open", [_clearance_limit(land, limits) for land in chosen]),
    }
    for name, (symbol, values) in marks.items():
        if any(value is not None for value in values):
            figure.add_scatter(
                x=[None if value is None else value * UM for value in values],
                y=[_name(land) for land in chosen],
                mode="markers",
                name=name,
                marker={"color": _NEUTRAL, "symbol": symbol, "size": 13, "line": {"width": 1.5}},
                hovertemplate=f"%{{y}}: {name} %{{x:.1f}} µm<extra></extra>",
            )
    for decision in DECISIONS:
        found = [land for land in chosen if land.decision == decision]
        if not found:
            continue
        values = [land.sources.state.radial_clearance * UM for land in found]
        figure.add_scatter(
            x=values,
            y=[_name(land) for land in found],
            mode="markers",
            name=decision_words(decision),
            marker={"color": COLOURS[decision], "symbol": SYMBOLS[decision], "size": 10, "line": {"width": 2}},
            error_x=_error_bars(values, [land.clearance_interval for land in found], UM, COLOURS[decision]),
            customdata=[
                (land.u_clearance * UM, PERCENT * (land.probability_over_limit or 0.0), land.advice or "")
                for land in found
            ],
            hovertemplate="%{y}: %{x:.1f} µm, u = %{customdata[0]:.2f} µm<br>"
            "over its limit with %{customdata[1]:.0f} %<br>%{customdata[2]}<extra></extra>",
        )
    figure.update_xaxes(title=f"radial clearance [µm], {_coverage(unit)} interval", rangemode="tozero")
    return _by_land(figure, chosen)


def leakages(unit: UnitUncertainty, lands: int = 20) -> go.Figure:
    """Leakage at the stated condition with its interval; a thin line runs to what a fully eccentric spool would leak.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    chosen = sorted((land for land in unit.lands if land.conditions), key=lambda land: -land.conditions[0].leakage)
    chosen = chosen[:lands]
    figure = go.Figure()
    ends = [
        value
        for land in chosen
        for value in (land.conditions[0].leakage * DM3_MIN, land.conditions[0].eccentric[1] * DM3_MIN, None)
    ]
    figure.add_scatter(
        x=ends,
        y=[name for land in chosen for name in (_name(land), _name(land), None)],
        mode="lines",
        name=f"up to fully eccentric, × {FULLY_ECCENTRIC:g}",
        line={"color": _NEUTRAL, "width": 1, "dash": "dot"},
        hoverinfo="skip",
    )
    values = [land.conditions[0].leakage * DM3_MIN for land in chosen]
    figure.add_scatter(
        x=values,
        y=[_name(land) for land in chosen],
        mode="markers",
        name=f"leakage, {_coverage(unit)} interval",
        marker={"color": "#2a86d1", "symbol": "diamond", "size": 9},
        error_x=_error_bars(values, [land.leakage_interval for land in chosen], DM3_MIN, "#2a86d1"),
        customdata=[tuple(end * DM3_MIN for end in land.leakage_interval or (math.nan, math.nan)) for land in chosen],
        hovertemplate="%{y}: %{x:.3f} dm³/min, %{customdata[0]:.3f} to %{customdata[1]:.3f}<extra></extra>",
    )
    label = chosen[0].conditions[0].label if chosen else ""
    figure.update_xaxes(title=f"leakage [dm³/min], {label}", rangemode="tozero")
    return _by_land(figure, chosen)


def totals(unit: UnitUncertainty, limits: Limits) -> go.Figure:
    """Total share of each condition with its interval, over the bands, with how likely each band is."""
    edges = [0.0, *(limit * PERCENT for _, limit in limits.total_share.levels)]
    highs = [total.share_interval[1] * PERCENT for total in unit.totals]
    right = max([1.1 * edges[-1], *(1.1 * high for high in highs if math.isfinite(high))])
    names = ["green", *(name for name, _ in limits.total_share.levels)]
    figure = go.Figure()
    for name, low, high in zip(names, edges, [*edges[1:], right], strict=True):
        figure.add_vrect(x0=low, x1=high, fillcolor=BAND_COLOURS[name], opacity=0.28, line_width=0, layer="below")
        figure.add_annotation(
            x=0.5 * (low + high), y=1.0, yref="paper", yanchor="bottom", showarrow=False,
            text=f"{BAND_SYMBOLS[name]}<br>{name}", font={"size": 11},
        )  # fmt: skip
    finite = [total for total in unit.totals if math.isfinite(total.share)]
    values = [total.share * PERCENT for total in finite]
    figure.add_scatter(
        x=values,
        y=[total.label.replace(", ", ",<br>") for total in finite],
        mode="markers",
        name=f"share, {_coverage(unit)} interval",
        marker={"color": "#2a86d1", "symbol": "diamond", "size": 12, "line": {"width": 1.5, "color": "white"}},
        error_x=_error_bars(values, [total.share_interval for total in finite], PERCENT, "#2a86d1"),
        customdata=[
            ", ".join(f"{name} {PERCENT * p:.0f} %" for name, p in total.band_probabilities if p >= 0.005)
            for total in finite
        ],
        hovertemplate="%{y}: %{x:.1f} %<br>%{customdata}<extra></extra>",
        showlegend=False,
    )
    figure.update_xaxes(title="leakage as a share of the pump's flow [%]", range=[0.0, right])
    figure.update_yaxes(type="category", autorange="reversed")
    return _dressed(figure, 110 + 50 * len(unit.totals))


def budget(land: LandUncertainty, sources: int = 12) -> go.Figure:
    """What one land's uncertainty is made of: each source's part of the variance of clearance and share."""
    of_clearance = dict(land.budget)
    of_share = dict(land.conditions[0].budget) if land.conditions else {}
    names = sorted(
        dict.fromkeys([*of_share, *of_clearance]),
        key=lambda name: max(of_share.get(name, 0.0), of_clearance.get(name, 0.0)),
    )[-sources:]
    figure = go.Figure()
    for title, parts, colour, shape in (
        ("of the clearance", of_clearance, "#2a86d1", ""),
        ("of the share", of_share, "#e07b00", "/"),
    ):
        figure.add_bar(
            x=[PERCENT * parts.get(name, 0.0) for name in names],
            y=names,
            orientation="h",
            name=title,
            marker={"color": colour, "pattern": {"shape": shape}},
            hovertemplate=f"%{{y}}: %{{x:.1f}} % {title}<extra></extra>",
        )
    figure.update_xaxes(title="part of the variance [%]", rangemode="tozero")
    figure.update_yaxes(type="category")
    return _dressed(figure, 110 + 30 * max(len(names), 3), barmode="group")


# --- shared


def _chosen(unit: UnitUncertainty, lands: int) -> list[LandUncertainty]:
    measured = [land for land in unit.lands if land.deciding is not None]
    return sorted(measured, key=lambda land: land.deciding.severity, reverse=True)[:lands]


def _clearance_limit(land: LandUncertainty, limits: Limits) -> float | None:
    """The limit that decides, as a clearance [m]; None where it is one of share."""
    rule = land.deciding
    if rule is None or rule.rule.startswith("share"):
        return None
    if rule.rule == "wear":
        steps: Steps | None = limits.wear
        return None if steps is None else land.sources.state.land.mounting_clearance * (1.0 + rule.limit)
    return rule.limit


def _error_bars(
    values: Sequence[float], intervals: Sequence[tuple[float, float] | None], factor: float, colour: str
) -> dict[str, object]:
    ends = [(value, value) if end is None else (end[0] * factor, end[1] * factor) for value, end in zip(
        values, intervals, strict=True
    )]  # fmt: skip
    return {
        "type": "data",
        "symmetric": False,
        "array": [high - value for value, (_, high) in zip(values, ends, strict=True)],
        "arrayminus": [value - low for value, (low, _) in zip(values, ends, strict=True)],
        "color": colour,
        "thickness": 1.8,
        "width": 5,
    }


def _name(land: LandUncertainty) -> str:
    return f"{land.key[0]} · {land.key[1]}"


def _coverage(unit: UnitUncertainty) -> str:
    return f"{PERCENT * unit.coverage:g} %"


def _by_land(figure: go.Figure, chosen: Sequence[LandUncertainty]) -> go.Figure:
    order = [_name(land) for land in reversed(chosen)]
    figure.update_yaxes(title="component · land", type="category", categoryorder="array", categoryarray=order)
    return _dressed(figure, 110 + 24 * max(len(chosen), 3))


def _dressed(figure: go.Figure, height: int, **layout: object) -> go.Figure:
    figure.update_layout(
        height=height,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        margin={"l": 8, "r": 8, "t": 40, "b": 8},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "xanchor": "left"},
        **layout,
    )
    figure.update_xaxes(automargin=True, zeroline=False, gridcolor="rgba(128,128,128,0.25)")
    figure.update_yaxes(automargin=True, zeroline=False)
    return figure
