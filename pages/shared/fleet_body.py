"""Show what a fleet's summary says of one valve body: pairs, wear, temperatures and conditions, groups side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import streamlit as st

from atleak.figures import fleet_figures as figures
from atleak.fleet.summary_words import NAME, FleetWords, called, within
from atleak.fleet.summed import ConditionSpread, Difference, GroupComparison, ValveBody, WearDifference
from atleak.spreads import Spread
from atleak.verdicts import Band, Verdict
from atleak.views.table import Column
from pages.shared import show
from pages.shared.fleet import counts_table

DRAWN = 15  # most pairs, differences of wear and groups in a figure
SAID = 3  # differences of wear that are told in sentences
_HOUR = 3600.0  # [s]


def draw_about(words: FleetWords, body: ValveBody) -> None:
    """Say what leads among the units of the valve body, and what to know about them."""
    say = words.say
    if body.counts.judged:
        said = say("fleet_summary.headline", rate=words.rate(body.counts.rates[Verdict.REPLACE]))
        st.write(show.plain(f"{said} {words.leading_pair(body)}"))
    show.messages(body.messages, say("about.fleet"), opened=True)


# --- pairs


def draw_pairs(words: FleetWords, body: ValveBody) -> None:
    """Show which pairs are flagged and replaced most often, and what decided the verdicts."""
    say = words.say
    flagged = [pair for pair in body.pairs if pair.flagged.count or pair.deciding.count]
    if not flagged:
        st.write(say("fleet_summary.no_pair_flagged"))
        return
    drawn = flagged[:DRAWN]
    show.chart(figures.pairs(drawn, [words.land(body.controller, each.key) for each in drawn], say), "fleet-pairs")
    st.caption(say("fleet.pairs_note", judged=say.number(body.counts.judged, 0)))
    with st.expander(say("fleet.every_pair", count=len(body.pairs))):
        columns = [
            Column("pair", width=150),
            Column("measured", digits=0, words=say("fleet.measured")),
            *(Column(name, words=say(f"fleet.rate_{name}")) for name in ("flagged", "replace", "deciding")),
            Column("not_measured", digits=0, words=say("fleet.not_measured")),
        ]
        rows = [
            {
                "pair": words.land(body.controller, each.key),
                "measured": each.flagged.of,
                **{name: words.percent(getattr(each, name)) for name in ("flagged", "replace", "deciding")},
                "not_measured": each.not_measured,
            }
            for each in body.pairs
        ]
        show.rows_table(rows, columns)
    others = [each for each in body.deciders if each.land is None]
    if others:
        listed = "\n".join(
            f"- {show.plain(words.decider(body.controller, each))}: {show.plain(words.rate(each.units))}"
            for each in others
        )
        st.markdown(f"{say('fleet.other_deciders')}\n\n{listed}")


# --- wear


def draw_wear(words: FleetWords, body: ValveBody) -> None:
    """Show the wear of one land over mileage: of that which is replaced most often unless another one is chosen."""
    say, wear = words.say, {land.key: land for land in body.wear}
    keys = [pair.key for pair in body.pairs if pair.key in wear]
    with_mileage = [key for key in keys if wear[key].classes]
    if not with_mileage:
        st.write(say("fleet_summary.no_mileage"))
        return
    key = st.selectbox(
        say("columns.land"),
        with_mileage,
        format_func=lambda each: words.land(body.controller, each),
        key=f"fleet-land-{body.controller}-{say.language}",
    )
    land = wear[key]
    show.chart(figures.wear_over_mileage(land, say), "fleet-wear")
    left_out = {name: getattr(land, name) for name in ("without_mileage", "repaired") if getattr(land, name)}
    said = [say("fleet.boxes_note")]
    said += [say(f"fleet.{name}", count=say.number(count, 0)) for name, count in left_out.items()]
    st.caption(show.plain(" ".join(said)))


# --- temperatures and conditions


def draw_temperatures(words: FleetWords, body: ValveBody) -> None:
    """Show share and pressure over the temperature of the logs, and at the stated conditions."""
    say = words.say
    if body.temperatures:
        show.chart(figures.over_temperature(body.temperatures, say), "fleet-temperatures")
        hours = sum(each.seconds for each in body.temperatures) / _HOUR
        st.caption(say("fleet.temperatures_note", hours=say.number(hours, 1 if hours >= 1.0 else 2)))
    else:
        st.write(say("fleet_summary.no_logs"))
    if body.conditions:
        st.markdown(f"**{say('fleet_summary.section_conditions')}**")
        _conditions(words, body.conditions)


def _conditions(words: FleetWords, conditions: Sequence[ConditionSpread]) -> None:
    say = words.say
    columns = [
        Column("condition", width=190),
        Column("units", digits=0),
        Column("share", "percent"),
        Column("share_most", words=f"{say('fleet.nine_of_ten')} [%]"),
        Column("held", "pressure"),
        Column("held_most", words=f"{say('fleet.nine_of_ten')} [{say.unit('pressure')}]", words_of=None),
        Column("required", "pressure"),
        Column("red", words=figures.or_worse(Band.RED, say)),
    ]
    rows = [
        {
            "condition": words.condition(each),
            "units": max((part.units for part in (each.share_percent, each.pressure_held_kpa) if part), default=0),
            "share": each.share_percent.median if each.share_percent else None,
            "share_most": _most(words, each.share_percent, "percent"),
            "held": each.pressure_held_kpa.median if each.pressure_held_kpa else None,
            "held_most": _most(words, each.pressure_held_kpa, "pressure"),
            "required": each.required_kpa,
            "red": _red(words, each),
        }
        for each in conditions
    ]
    show.rows_table(rows, columns)
    partly = max(each.partly for each in conditions)
    said = [say("fleet.conditions_note")]
    if partly:
        said.append(say("fleet_summary.note_partly", count=say.number(partly, 0)))
    st.caption(show.plain(" ".join(said)))


def _most(words: FleetWords, spread: Spread | None, kind: str) -> str | None:
    """Write between which values nine of ten units are; of too few units that there are too few."""
    if spread is None:
        return None
    if spread.quantiles is None:
        return words.say("fleet_summary.too_few")
    return "–".join(words.say.value(end, kind) for end in (spread.quantiles[0], spread.quantiles[-1]))


def _red(words: FleetWords, at: ConditionSpread) -> str:
    red, of = at.bands[Band.RED] + at.bands[Band.CRITICAL], sum(at.bands.values())
    return words.say("fleet_summary.chart_rate", count=words.say.number(red, 0), of=words.say.number(of, 0))


# --- groups


def draw_groups(words: FleetWords, body: ValveBody) -> None:
    """Show the groups of the valve body side by side, and say what differs and what cannot be told."""
    say, comparison = words.say, body.comparison
    if words.summary.by is None:
        st.write(say("fleet.choose_by" if words.summary.headings else "fleet.no_headings"))
        return
    if comparison is None:
        st.write(show.plain(say("fleet_summary.one_group", by=words.heading())))
        return
    how = "in_pairs" if comparison.in_pairs else "with_others"
    said = [say(f"fleet_summary.{how}", by=words.heading(), count=len(comparison.groups))]
    if comparison.not_stated:
        said.append(say("fleet_summary.not_stated", count=say.number(comparison.not_stated, 0)))
    st.write(show.plain(" ".join(said)))
    show.messages(comparison.messages, say("about.comparison"), opened=True)
    _rates(words, comparison)
    _wear_compared(words, body, comparison)


def _rates(words: FleetWords, comparison: GroupComparison) -> None:
    say = words.say
    told = [each for each in comparison.verdicts if each.points is not None and each.points.differs is not None]
    found = [each for each in told if each.points is not None and each.points.differs]
    if not told:
        st.markdown(f"**{say('fleet_summary.rates_too_few')}**")
    elif not found:
        st.markdown(f"**{say('fleet_summary.rates_alike', count=len(told))}**")
    else:
        lines = [f"- {show.plain(words.difference_of_rates(each))}" for each in found[:DRAWN]]
        head = f"**{say('fleet_summary.rates_differ', found=len(found), count=len(told))}**"
        st.markdown("\n".join([head, "", *lines]))
    groups = sorted(comparison.groups, key=lambda group: -group.counts.units)
    show.chart(figures.rates_of_groups(groups[:DRAWN], say), "fleet-groups")
    with st.expander(say("fleet.every_group", count=len(groups))):
        counts_table(say("fleet.group"), [(group.name, group.counts) for group in comparison.groups], words)


def _wear_compared(words: FleetWords, body: ValveBody, comparison: GroupComparison) -> None:
    say = words.say
    told = [each for each in comparison.lands if called(each) is not None]
    found = [each for each in told if called(each)]
    if not told:
        st.markdown(f"**{say('fleet_summary.wear_too_few')}**")
        return
    said = [f"**{say('fleet_summary.wear_alike', count=len(told))}**"]
    if found:
        said = [f"**{say('fleet_summary.wear_differs', found=len(found), count=len(told))}**", ""]
        said += [f"- {show.plain(_wear_sentence(words, body, each))}" for each in found[:SAID]]
    st.markdown("\n".join(said))
    if len(told) < len(comparison.lands):
        st.caption(say("fleet.not_told", count=say.number(len(comparison.lands) - len(told), 0)))
    drawn = (found or told)[:DRAWN]
    show.chart(figures.wear_differences(drawn, [_named(words, body, each) for each in drawn], say), "fleet-differences")
    st.caption(say("fleet.differences_note"))
    with st.expander(say("fleet.every_difference", count=len(told))):
        columns = [
            Column("pair", width=150),
            Column("groups", words=say("fleet.group")),
            Column("means", words=say("fleet.means")),
            Column("mean", words=say("fleet.in_the_mean_points")),
            Column("same_mileage", words=say("fleet.at_same_mileage_points")),
            Column("differs", words=say("fleet.differs")),
        ]
        show.rows_table([_difference(words, body, each) for each in told], columns)


def _wear_sentence(words: FleetWords, body: ValveBody, each: WearDifference) -> str:
    """Say by how much the wear of a land differs: at the same mileage where that tells it, else in the mean."""
    same = each.same_mileage_points
    how, points = ("same", same) if same is not None and same.differs else ("mean", each.mean_points)
    assert points is not None
    return words.say(
        f"fleet.wear_{how}",
        pair=words.land(body.controller, each.key),
        first=within(each.first, NAME),
        second=within(words.second(each.second), NAME),
        points=words.points(points.value),
        interval=words.interval(points.low_of_all, points.high_of_all),
    )


def _named(words: FleetWords, body: ValveBody, each: WearDifference) -> str:
    sides = (within(side, NAME) for side in (each.first, words.second(each.second)))
    return f"{words.land(body.controller, each.key)}: {' − '.join(sides)}"


def _difference(words: FleetWords, body: ValveBody, each: WearDifference) -> dict[str, Any]:
    means = [side.mean if side else None for side in (each.first_percent, each.second_percent)]
    return {
        "pair": words.land(body.controller, each.key),
        "groups": f"{each.first} − {words.second(each.second)}",
        "means": " / ".join(words.say.number(mean, 1) for mean in means),
        "mean": _points(words, each.mean_points),
        "same_mileage": _points(words, each.same_mileage_points),
        "differs": words.differs(called(each)),
    }


def _points(words: FleetWords, found: Difference | None) -> str | None:
    if found is None:
        return None
    within = words.interval(found.low_of_all, found.high_of_all) or words.say("fleet_summary.too_few")
    return f"{words.points(found.value)} ({within})"
