"""Draw how sure a unit's numbers are: intervals, limits, and the sources of the uncertainty.

A decision shows by its symbol and its words as well as by its colour. Units are those that people read.
"""

from __future__ import annotations

import math

from atleak.catalogue.limits import RuleKind
from atleak.figures.figure import Figure
from atleak.figures.frame import by_land, error_bars, framed
from atleak.look import DECISION_MARKS, SCREEN
from atleak.uncertainty import DECISIONS, LandUncertainty, UnitUncertainty
from atleak.wording import wording
from atleak.workshop_units import DM3_MIN, PERCENT, UM


def clearances(unit: UnitUncertainty, lands: int = 20) -> Figure:
    """Draw radial clearances with their intervals, beside the mounting clearance and the limit that decides.

    Parameters
    ----------
    lands
        how many are drawn: those likeliest to be over a limit.
    """
    chosen = _chosen(unit, lands)
    figure = Figure()
    marks: dict[str, tuple[str, list[float | None]]] = {  # drawn first, open, so that they cover no value
        "mounting clearance": ("line-ns-open", [land.sources.state.land.mounting_high for land in chosen]),
        "limit": ("triangle-down-open", [_clearance_limit(land) for land in chosen]),
    }
    for name, (symbol, limits) in marks.items():
        if any(limit is not None for limit in limits):
            figure.add_scatter(
                x=[None if limit is None else limit * UM for limit in limits],
                y=[_name(land) for land in chosen],
                mode="markers",
                name=name,
                marker={"color": SCREEN.rule, "symbol": symbol, "size": 13, "line": {"width": 1.5}},
                hovertemplate=f"%{{y}}: {name} %{{x:.1f}} µm<extra></extra>",
            )
    for decision in DECISIONS:
        shown = [land for land in chosen if land.decision == decision]
        if not shown:
            continue
        values = [land.sources.state.radial_clearance for land in shown]
        colour, symbol = DECISION_MARKS[decision]
        figure.add_scatter(
            x=[value * UM for value in values],
            y=[_name(land) for land in shown],
            mode="markers",
            name=wording("en").get("decisions", decision),
            marker={"color": colour, "symbol": symbol, "size": 10, "line": {"width": 2}},
            error_x=error_bars(values, [land.clearance_interval for land in shown], UM, colour),
            customdata=[
                ((land.u_clearance or 0.0) * UM, PERCENT * (land.probability_over_limit or 0.0), land.advice or "")
                for land in shown
            ],
            hovertemplate="%{y}: %{x:.1f} µm, u = %{customdata[0]:.2f} µm<br>"
            "over its limit with %{customdata[1]:.0f} %<br>%{customdata[2]}<extra></extra>",
        )
    figure.update_xaxes(title=f"radial clearance [µm], {_coverage(unit)} interval", rangemode="tozero")
    return by_land(figure, [_name(land) for land in chosen], 24)


def leakages(unit: UnitUncertainty, lands: int = 20) -> Figure:
    """Draw leakages at the stated condition with intervals; a thin line ends where a spool that touches would leak.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    chosen = sorted((land for land in unit.lands if land.conditions), key=lambda land: -land.conditions[0].leakage)
    chosen = chosen[:lands]
    figure = Figure()
    ends = [
        value
        for land in chosen
        for value in (land.conditions[0].leakage * DM3_MIN, land.conditions[0].eccentric[1] * DM3_MIN, None)
    ]
    figure.add_scatter(
        x=ends,
        y=[name for land in chosen for name in (_name(land), _name(land), None)],
        mode="lines",
        name="up to a spool that touches its bore",
        line={"color": SCREEN.rule, "width": 1, "dash": "dot"},
        hoverinfo="skip",
    )
    values = [land.conditions[0].leakage for land in chosen]
    figure.add_scatter(
        x=[value * DM3_MIN for value in values],
        y=[_name(land) for land in chosen],
        mode="markers",
        name=f"leakage, {_coverage(unit)} interval",
        marker={"color": SCREEN.leakage, "symbol": "diamond", "size": 9},
        error_x=error_bars(values, [land.leakage_interval for land in chosen], DM3_MIN, SCREEN.leakage),
        customdata=[tuple(end * DM3_MIN for end in land.leakage_interval or (math.nan, math.nan)) for land in chosen],
        hovertemplate="%{y}: %{x:.3f} dm³/min, %{customdata[0]:.3f} to %{customdata[1]:.3f}<extra></extra>",
    )
    label = chosen[0].conditions[0].label if chosen else ""
    figure.update_xaxes(title=f"leakage [dm³/min], {label}", rangemode="tozero")
    return by_land(figure, [_name(land) for land in chosen], 24)


def budget(land: LandUncertainty, sources: int = 12) -> Figure:
    """Draw the sources of one land's uncertainty: each source's part of the variance of clearance and share."""
    of_clearance = dict(land.budget)
    of_share = dict(land.conditions[0].budget) if land.conditions else {}
    names = sorted(
        dict.fromkeys([*of_share, *of_clearance]),
        key=lambda name: max(of_share.get(name, 0.0), of_clearance.get(name, 0.0)),
    )[-sources:]
    figure = Figure()
    for title, parts, colour, shape in (
        ("of the clearance", of_clearance, SCREEN.leakage, ""),
        ("of the share", of_share, SCREEN.share, "/"),
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
    return framed(figure, 110 + 30 * max(len(names), 3), barmode="group")


# --- shared


def _chosen(unit: UnitUncertainty, lands: int) -> list[LandUncertainty]:
    decided = [(land.deciding.severity, land) for land in unit.lands if land.deciding is not None]
    return [land for _, land in sorted(decided, key=lambda pair: pair[0], reverse=True)[:lands]]


def _clearance_limit(land: LandUncertainty) -> float | None:
    """Return the limit that decides, as a clearance [m]; None where it limits the share."""
    decided = land.deciding
    if decided is None or decided.rule.kind is RuleKind.PAIR_SHARE:
        return None
    if decided.rule.kind is RuleKind.WEAR:
        return land.sources.state.land.mounting_high * (1.0 + decided.limit)
    return decided.limit


def _name(land: LandUncertainty) -> str:
    return f"{land.key[0]} · {land.key[1]}"


def _coverage(unit: UnitUncertainty) -> str:
    return f"{PERCENT * unit.coverage:g} %"
