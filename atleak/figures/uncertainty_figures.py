"""Draw how sure a unit's numbers are: intervals, limits, and the sources of the uncertainty.

A decision shows by its symbol and its words as well as by its colour. Units are those that people read.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from atleak.catalogue.limits import RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.figures.comparison_figures import open_mark
from atleak.figures.figure import Figure
from atleak.figures.frame import by_land, framed
from atleak.look import DECISION_MARKS, SCREEN
from atleak.rules import LandKey
from atleak.uncertainty import DECISIONS, LandUncertainty, UnitUncertainty
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, PERCENT, UM


def clearances(
    unit: UnitUncertainty, say: Wording, lands: int = 20, advised: Callable[[LandKey], str] = lambda _: ""
) -> Figure:
    """Draw radial clearances with their intervals, beside the mounting clearance and the limit that decides.

    Parameters
    ----------
    lands
        how many are drawn: those likeliest to be over a limit.
    advised
        says in the reader's language what would make the verdict of a land clear, under the pointer.
    """
    chosen = _chosen(unit, lands)
    figure, um, name_of = Figure(), say.convert(UM, "clearance"), say.unit("clearance")
    digits = say.digits("clearance", 1)
    names, number = list(map(_name, chosen)), f"%{{x:.{digits}f}} {name_of}"
    new = [land.sources.state.land.mounting_high for land in chosen]
    open_mark(figure, new, names, say("figures.mounting"), "line-ns-open", um, number)
    limits = list(map(_clearance_limit, chosen))
    open_mark(figure, limits, names, say("figures.limit"), "triangle-down-open", um, number)
    for decision in DECISIONS:
        shown = [land for land in chosen if land.decision == decision]
        if not shown:
            continue
        colour, symbol = DECISION_MARKS[decision]
        figure.marks(
            [land.sources.state.radial_clearance for land in shown],
            list(map(_name, shown)),
            say.get("decisions", decision),
            (colour, symbol, 10, 2.0),
            factor=um,
            spans=[land.clearance_interval for land in shown],
            told=[
                ((land.u_clearance or 0.0) * um, PERCENT * (land.probability_over_limit or 0.0), advised(land.key))
                for land in shown
            ],
            hover=f"%{{y}}: {number}, u = %{{customdata[0]:.{digits + 1}f}} {name_of}<br>"
            f"{say('columns.over_limit')}: %{{customdata[1]:.0f}} %<br>%{{customdata[2]}}",
        )
    figure.update_xaxes(title=say("figures.clearance", unit=name_of, coverage=_coverage(unit, say)), rangemode="tozero")
    return by_land(figure, list(map(_name, chosen)), 24, say)


def leakages(unit: UnitUncertainty, at: OperatingPoint, say: Wording, lands: int = 20) -> Figure:
    """Draw leakages at the stated condition with intervals; a thin line ends where a spool that touches would leak.

    Parameters
    ----------
    at
        the stated condition.
    lands
        how many of the largest are drawn.
    """
    chosen = sorted((land for land in unit.lands if land.conditions), key=lambda land: -land.conditions[0].leakage)
    chosen = chosen[:lands]
    figure, flow, name_of = Figure(), say.convert(DM3_MIN, "flow"), say.unit("flow")
    at_first = [land.conditions[0] for land in chosen]
    ends = [end for each in at_first for end in (each.leakage * flow, each.eccentric[1] * flow, None)]
    names = [end for land in chosen for end in (_name(land), _name(land), None)]
    figure.line(ends, names, SCREEN.rule, 1, "dot", name=say("figures.touching"))
    figure.marks(
        [each.leakage for each in at_first],
        list(map(_name, chosen)),
        say("figures.leakage_interval", coverage=_coverage(unit, say)),
        (SCREEN.leakage, "diamond", 9, 0.0),
        factor=flow,
        spans=[land.leakage_interval for land in chosen],
        told=[tuple(end * flow for end in land.leakage_interval or (math.nan, math.nan)) for land in chosen],
        hover=f"%{{y}}: %{{x:.3f}} {name_of}, %{{customdata[0]:.3f}} – %{{customdata[1]:.3f}}",
    )
    figure.update_xaxes(title=say("figures.leakage", unit=name_of, condition=say.condition(at)), rangemode="tozero")
    return by_land(figure, list(map(_name, chosen)), 24, say)


def budget(land: LandUncertainty, say: Wording, sources: int = 12) -> Figure:
    """Draw the sources of one land's uncertainty: each source's part of the variance of clearance and share."""
    of_clearance = dict(land.budget)
    of_share = dict(land.conditions[0].budget) if land.conditions else {}
    names = sorted(
        dict.fromkeys([*of_share, *of_clearance]),
        key=lambda name: max(of_share.get(name, 0.0), of_clearance.get(name, 0.0)),
    )[-sources:]
    figure = Figure()
    for title, parts, colour, shape in (
        (say("columns.of_clearance"), of_clearance, SCREEN.leakage, ""),
        (say("columns.of_share"), of_share, SCREEN.share, "/"),
    ):
        values, named = (
            [parts.get(name, 0.0) for name in names],
            [say.get("uncertainty_sources", name) for name in names],
        )
        figure.bars(values, named, title, (colour, shape), factor=PERCENT, hover=f"%{{y}}: %{{x:.1f}} % {title}")
    figure.update_xaxes(title=say("figures.variance"), rangemode="tozero")
    figure.update_yaxes(type="category")
    return framed(figure, 110 + 30 * max(len(names), 3), barmode="group")


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


def _coverage(unit: UnitUncertainty, say: Wording) -> str:
    return say.percent(unit.coverage, 0)
