"""Draw lands and totals on the screen: leakage, wear and clearance against their limits, and how sure each is.

A decision shows by its symbol and its words as well as by its colour. Units are those that people read, on the axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from atleak.analysis.repair.totals import Total
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.common.style import DECISION_MARKS, SCREEN, look_of
from atleak.common.units import DM3_MIN, PERCENT, UM
from atleak.common.verdicts import VERDICTS, Band
from atleak.common.wording import Wording, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import LandUncertainty, UnitUncertainty
from atleak.report.charts.figure import Figure, by_land, framed

_NAMED = 0.12  # part of the axis from which on a band has room for its name beside its sign
_NEAR = 0.08  # part of the axis within which a word centred on its mark would be cut by the axis


def land_name(land: LandDiagnosis | LandUncertainty) -> str:
    """Return component and land: ``25 · 1``."""
    component, number = land.key
    return f"{component} · {number}"


def leakage_ranking(diagnosis: Diagnosis, say: Wording | None = None, *, lands: int = 20) -> Figure:
    """Draw the lands by leakage at the stated condition, the largest on top, by verdict, with 95 % intervals.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    say = say or wording("en")
    ranked = diagnosis.ranked[:lands]
    figure, scale, unit = Figure(), say.convert(DM3_MIN, "leak"), say.unit("leak")
    clearance = f"%{{customdata[1]:.{say.digits('clearance')}f}} {say.unit('clearance')}"
    hover = (
        f"%{{y}} %{{customdata[0]}}<br>%{{x:.3f}} {unit}, {say('columns.share')} %{{customdata[2]:.2f}} %<br>"
        f"{say('columns.clearance')} {clearance}"
    )

    def told(land: LandDiagnosis) -> tuple[str, float, float]:
        component = say.name(diagnosis.controller.components[land.key[0]])
        return component, say.convert(land.state.radial_clearance * UM, "clearance"), land.share * PERCENT

    for verdict in VERDICTS:
        leaking = [land for land in ranked if land.verdict == verdict]
        if leaking:
            values, names = [land.leakage for land in leaking], list(map(land_name, leaking))
            said = {"factor": scale, "spans": list(map(_interval, leaking)), "told": list(map(told, leaking))}
            figure.bars(values, names, say.signed(verdict), look_of(verdict), hover=hover, **said)
    ends = [max(land.leakage, *(_interval(land) or (0.0,))) * scale for land in ranked]
    figure.add_scatter(
        x=ends,
        y=list(map(land_name, ranked)),
        mode="text",
        text=[f"  {look_of(land.verdict).sign} {say.number(land.leakage * scale, 3)}" for land in ranked],
        textposition="middle right",
        cliponaxis=False,
        showlegend=False,
        hoverinfo="skip",
    )
    title = f"{say('figures.leaked')} [{unit}]"
    figure.update_xaxes(title=title, range=[0.0, 1.25 * max(ends, default=0.0) or 1.0])
    return by_land(figure, list(map(land_name, ranked)), 22, say, bargap=0.25)


def _interval(land: LandDiagnosis) -> tuple[float, float] | None:
    return land.uncertainty.leakage_interval if land.uncertainty else None


class _Total(NamedTuple):
    """A total share of the pump's flow, as `total_share` draws it; None where something is not known."""

    name: str
    share: float
    interval: tuple[float, float] | None = None
    new: float | None = None  # of the same unit new
    likely: str = ""  # how likely each band is; those below half a percent are left out

    @property
    def ends(self) -> list[float]:
        """Return the share and the ends of its interval [%], where they have an end."""
        return [end * PERCENT for end in (self.share, *(self.interval or ())) if math.isfinite(end)]


def _totals(diagnosis: Diagnosis, say: Wording) -> Iterator[_Total]:
    """Yield the total at each condition, then the worst of the road test."""
    for point in diagnosis.reported:
        name, new = _two_lines(say.condition(point.condition)), diagnosis.total_rule(point).new
        total = diagnosis.uncertainty.total(point.condition.name) if diagnosis.uncertainty else None
        if total is None:
            yield _Total(name, point.share, new=new)
        else:
            likely = (f"{say.level(band)} {say.percent(p, 0)}" for band, p in total.band_probabilities if p >= 0.005)
            yield _Total(name, point.share, total.share_interval, new, ", ".join(likely))
    worst = diagnosis.road.max_share if diagnosis.road else None
    if worst is not None and worst.share is not None:
        yield _Total(_two_lines(say("figures.worst_of_log", time=say.number(worst.time, 1))), worst.share)


def total_share(diagnosis: Diagnosis, say: Wording | None = None, *, repaired: Sequence[Total] = ()) -> Figure:
    """Draw the total share at each condition over the bands that apply there, and the worst of the road test.

    With totals of the ``repaired`` unit a star stands where the repairs take each.

    An open mark is the same unit new. A unit that nobody measured has no bands. Bars are the 95 % intervals of the
    measurement, where readings are there; the hover says how likely each band is. English unless ``say`` is given.
    """
    say = say or wording("en")
    totals = list(_totals(diagnosis, say))
    shown = [total for total in totals if math.isfinite(total.share)]
    new = [(total.new, total.name) for total in totals if total.new is not None and math.isfinite(total.new)]
    rules = map(diagnosis.total_rule, diagnosis.reported if diagnosis.judged else ())
    figure = Figure()
    right = _bands(figure, list(rules), max((end for total in totals for end in total.ends), default=0.0), say)
    figure.marks(
        [total.share for total in shown],
        [total.name for total in shown],
        say("figures.as_measured" if diagnosis.judged else "figures.as_new"),
        (SCREEN.leakage, "diamond", 14, 1.5),
        factor=PERCENT,
        spans=[total.interval for total in shown],
        text=[f"<b>{say.percent(total.share)}</b>" for total in shown],
        textposition=["top right" if total.share * PERCENT < _NEAR * right else "top center" for total in shown],
        told=[total.likely for total in shown],
        hover="%{y}: %{x:.2f} %<br>%{customdata}",
    )
    mark, hover = (SCREEN.leakage, "circle-open", 12, 2.0), f"%{{y}}: %{{x:.2f}} % {say('figures.new')}"
    shares, names = zip(*new, strict=True) if new else ((), ())
    figure.marks(shares, names, say("figures.same_unit_new"), mark, factor=PERCENT, hover=hover)
    after = {each.condition.name: each.share for each in repaired}
    ends = [(_two_lines(say.condition(at.condition)), after.get(at.condition.name)) for at in diagnosis.reported]
    known = [(name, share) for name, share in ends if share is not None and math.isfinite(share)]
    if known:
        names, shares = zip(*known, strict=True)
        mark, hover = (SCREEN.ink, "star-diamond", 14, 1.5), f"%{{y}}: %{{x:.2f}} % {say('figures.with_repairs')}"
        figure.marks(shares, names, say("figures.with_repairs"), mark, factor=PERCENT, hover=hover)
    figure.update_xaxes(title=say("figures.drawn_share"), range=[0.0, right])
    order = [total.name for total in totals]
    figure.update_yaxes(type="category", categoryarray=order, range=[len(order) - 0.4, -0.8])
    return framed(figure, 130 + 56 * len(order), top=40)


def _two_lines(label: str) -> str:
    return label.replace(", ", ",<br>")


def _bands(figure: Figure, rules: Sequence[Rule], largest: float, say: Wording) -> float:
    """Draw each condition's own bands behind its bar, with signs and words; return the right end of the axis [%]."""
    limits = [[min(limit, 10.0) * PERCENT for _, limit in rule.steps.levels] for rule in rules]
    right = max([1.1 * largest, *(1.2 * edge for edges in limits for edge in edges)])
    for place, (rule, begins) in enumerate(zip(rules, limits, strict=True)):
        edges = [0.0, *np.minimum.accumulate(begins[::-1])[::-1], right]  # a band ends where a worse one begins
        names = [Band.GREEN, *(name for name, _ in rule.steps.levels)]
        for name, low, high in zip(names, edges[:-1], edges[1:], strict=True):
            if low >= high:
                continue
            look = look_of(name)
            figure.add_shape(
                type="rect", x0=low, x1=high, y0=place - 0.45, y1=place + 0.45,
                fillcolor=look.screen, opacity=0.28, line={"width": 0}, layer="below",
            )  # fmt: skip
            figure.add_annotation(
                x=low, y=place + 0.45, xanchor="left", yanchor="bottom", xshift=2,
                text=f"{look.sign} {say.level(name)}" if high - low > _NAMED * right else look.sign, font={"size": 10},
            )  # fmt: skip
    return right


def land_wear(diagnosis: Diagnosis, lands: Sequence[LandDiagnosis] | None = None, say: Wording | None = None) -> Figure:
    """Draw the wear of every measured land against the limits that apply to it, the most worn on top.

    English unless ``say`` is given.

    Parameters
    ----------
    lands
        some of its lands; all unless given.

    Returns
    -------
    Figure
        wear in %, with the limits of each land.
    """
    say = say or wording("en")
    chosen = diagnosis.lands if lands is None else lands
    worn = [(0.0 if land.within_new else land.wear, land) for land in chosen if land.wear is not None]
    worn.sort(key=lambda pair: pair[0])
    marked: dict[tuple[str, tuple[str, str, int, float]], list[tuple[float, str]]] = {
        (say.level(verdict), (look_of(verdict).screen, look_of(verdict).marker, 11, 0.0)): [
            (wear, land_name(land)) for wear, land in worn if land.verdict == verdict
        ]
        for verdict in VERDICTS
    }
    rules = ((rule, land_name(land)) for _, land in worn for rule in land.rules if rule.kind is RuleKind.WEAR)
    for rule, name in rules:
        for level, limit in rule.steps.levels:
            named, look = say("figures.from_here", level=say.level(level)), look_of(level)
            marked.setdefault((named, (look.screen, f"{look.marker}-open", 9, 1.0)), []).append((limit, name))
    figure = Figure()
    for (named, mark), places in marked.items():
        if places:
            values, names = zip(*places, strict=True)
            figure.marks(values, names, named, mark, factor=PERCENT, hover="%{y}: %{x:.1f} %")
    figure.update_xaxes(title=f"{say('figures.wear')} [%]")
    return by_land(figure, [land_name(land) for _, land in reversed(worn)], 18, say)


def land_clearances(
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
    names, number = list(map(land_name, chosen)), f"%{{x:.{digits}f}} {name_of}"
    new = [land.sources.state.land.mounting_high for land in chosen]
    _open_mark(figure, new, names, say("figures.mounting"), "line-ns-open", um, number)
    limits = list(map(_clearance_limit, chosen))
    _open_mark(figure, limits, names, say("figures.limit"), "triangle-down-open", um, number)
    for decision, (colour, symbol) in DECISION_MARKS.items():
        shown = [land for land in chosen if land.shown_as == decision]
        if not shown:
            continue
        figure.marks(
            [land.sources.state.radial_clearance for land in shown],
            list(map(land_name, shown)),
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
    return by_land(figure, list(map(land_name, chosen)), 24, say)


def _open_mark(
    figure: Figure, values: Sequence[float | None], lands: Sequence[str], name: str, symbol: str, um: float, number: str
) -> None:
    """Draw what clearances stand against, open, so that it covers no value; nothing without any."""
    if any(value is not None for value in values):
        mark = (SCREEN.rule, symbol, 13, 1.5)
        figure.marks(values, lands, name, mark, factor=um, hover=f"%{{y}}: {name} {number}")


def leakages(unit: UnitUncertainty, at: OperatingPoint, say: Wording, lands: int = 20) -> Figure:
    """Draw leakages at the stated condition with intervals; a thin line ends where a spool that touches would leak.

    Parameters
    ----------
    lands
        how many of the largest are drawn.
    """
    chosen = sorted((land for land in unit.lands if land.conditions), key=lambda land: -land.conditions[0].leakage)
    chosen = chosen[:lands]
    figure, flow, name_of = Figure(), say.convert(DM3_MIN, "leak"), say.unit("leak")
    at_first = [land.conditions[0] for land in chosen]
    ends = [end for each in at_first for end in (each.leakage * flow, each.eccentric[1] * flow, None)]
    names = [end for land in chosen for end in (land_name(land), land_name(land), None)]
    figure.line(ends, names, SCREEN.rule, 1, "dot", name=say("figures.touching"))
    figure.marks(
        [each.leakage for each in at_first],
        list(map(land_name, chosen)),
        say("figures.leakage_interval", coverage=_coverage(unit, say)),
        (SCREEN.leakage, "diamond", 9, 0.0),
        factor=flow,
        spans=[land.leakage_interval for land in chosen],
        told=[tuple(end * flow for end in land.leakage_interval or (math.nan, math.nan)) for land in chosen],
        hover=f"%{{y}}: %{{x:.3f}} {name_of}, %{{customdata[0]:.3f}} – %{{customdata[1]:.3f}}",
    )
    figure.update_xaxes(title=say("figures.leakage", unit=name_of, condition=say.condition(at)), rangemode="tozero")
    return by_land(figure, list(map(land_name, chosen)), 24, say)


def budget(land: LandUncertainty, say: Wording, sources: int = 12) -> Figure:
    """Draw the sources of one land's uncertainty: each source's part of the variance of clearance and share.

    Parameters
    ----------
    sources
        how many are drawn at most: the largest.

    Returns
    -------
    Figure
        parts of the variance in %; that of the share is at the first condition.
    """
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


def _coverage(unit: UnitUncertainty, say: Wording) -> str:
    return say.percent(unit.coverage, 0)
