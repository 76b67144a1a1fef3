"""Show what depends on the condition: totals, the matrix of lands, the customer's complaint."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import Any

import pandas as pd
import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.look import look_of
from atleak.repair import RepairPlan, Total
from atleak.report.estimate_words import open_words
from atleak.verdicts import Verdict
from atleak.views.condition_matrix import leaking_worst_first
from atleak.views.measure_first import head, measure_first, reason
from atleak.views.positions import positions
from atleak.views.repair_options import option_rows
from atleak.views.repair_words import no_help, plan_ends
from atleak.views.sentences import covered_from, shares_add_up
from atleak.wording import signed, wording
from atleak.workshop_units import PERCENT
from pages.shared import show
from pages.shared.show import plain
from pages.shared.state import choose, job, session
from pages.shared.words import land_name, listed, pair

MEASURE_FIRST = 8  # lands named for a complaint; the others are in a fold
_PAIR, _ELSEWHERE, _STEP = "a pair", "leaks elsewhere", "a step"  # no condition's name has a blank
CONDITION_WIDTH = 104  # pixels of a condition: two of them stand beside the pair on a phone


def complaint(diagnosis: Diagnosis) -> None:
    """Show the customer's complaint, the conditions at which it can show, and which lands to measure first."""
    if diagnosis.complaint is None:
        return
    shows = listed([f"**{plain(each.condition.label)}**" for each in diagnosis.complained])
    ranked = measure_first(diagnosis)
    lines = [f"- **{plain(land_name(diagnosis, each.land.key))}**: {plain(reason(each))}" for each in ranked]
    st.subheader(f"Complaint: {plain(diagnosis.complaint.label)}")
    st.markdown("\n".join([f"It shows at {shows}. {plain(head(ranked))}", "", *lines[:MEASURE_FIRST]]))
    if lines[MEASURE_FIRST:]:
        with st.expander(f"{len(lines) - MEASURE_FIRST} more lands that leak there"):
            st.markdown("\n".join(lines[MEASURE_FIRST:]))
    st.caption(f"Conditions and lands of this complaint: {plain(diagnosis.complaint.source)}")


def totals(diagnosis: Diagnosis, record: dict[str, Any]) -> None:
    """Show every condition with its total, and from which speed the pump covers the leakage."""
    rows = {row["name"]: row for row in record["conditions"]}
    for number, point in enumerate(diagnosis.presented, start=1):
        row = rows[point.condition.name]
        worst = " (the worst condition)" if point is diagnosis.worst and len(rows) > 1 else ""
        st.caption(
            f"{number} · **{plain(point.condition.label)}**{worst}: {row['leakage_dm3_min']:.2f} of "
            f"{row['pump_capacity_dm3_min']:.2f} dm³/min at {row['p_g_kpa']:.0f} kPa and {row['engine_rpm']:.0f} rpm, "
            f"{row['leakage_new_dm3_min']:.2f} when new; {positions(diagnosis, point)}; "
            f"{plain(covered_from(diagnosis, point))}. {plain(row['source'])}"
        )


def matrix(diagnosis: Diagnosis) -> None:
    """Show every land that leaks at every condition: its share of the pump's flow with the sign of its verdict."""
    rows = leaking_worst_first(diagnosis, diagnosis.presented)
    if not rows:
        st.write("No land leaks at any condition.")
        return
    names = [each.condition.name for each in diagnosis.presented]
    frame = pd.DataFrame(
        [
            {
                _PAIR: pair(diagnosis.controller, *row.land.key),
                **{
                    name: cell.share * PERCENT if math.isfinite(cell.share) else math.nan
                    for name, cell in zip(names, row.cells, strict=True)
                },
                _ELSEWHERE: row.elsewhere,
            }
            for row in rows
        ]
    )
    style = frame.style
    for number, name in enumerate(names):
        cells = [row.cells[number] for row in rows]
        for level in (*Verdict, None):
            these = [place for place, cell in enumerate(cells) if cell.leakage > 0.0 and cell.verdict == level]
            part = pd.IndexSlice[these, [name]]
            style = style.format(_written(level), subset=part, na_rep=_beyond(level))
            if level is not None:
                style = style.map(partial(_css, level), subset=part)
        silent = [place for place, cell in enumerate(cells) if cell.leakage == 0.0]
        style = style.format(lambda _: "–", subset=pd.IndexSlice[silent, [name]])
    config: dict[str, Any] = {
        each.condition.name: st.column_config.Column(
            f"{number} · {each.condition.label}",
            width=CONDITION_WIDTH,
            help=f"share of the pump's flow [%], {each.condition.label}",
        )
        for number, each in enumerate(diagnosis.presented, start=1)
    }
    config[_PAIR] = st.column_config.TextColumn(
        "Pair", width=show.WIDTHS["Pair"], pinned=True, help="component, land and name"
    )
    config[_ELSEWHERE] = None if not any(frame[_ELSEWHERE]) else st.column_config.TextColumn("Elsewhere", width=300)
    st.dataframe(style, hide_index=True, width="stretch", column_config=config)
    st.caption(
        "What each land draws as a share of the pump's flow [%]; the sign is the verdict of that share alone, at that "
        f"condition. {plain(shares_add_up(diagnosis, wording('en')))}"
    )


def _css(level: Verdict, _: object) -> str:
    return show.colours(level)


def _written(level: Verdict | None) -> str:
    return "{:z.2f}" if level is None else f"{look_of(level).sign} {{:z.2f}}"


def _beyond(level: Verdict | None) -> str:
    """Say, in place of a number, that the pump delivers nothing."""
    return f"{look_of(level or Verdict.CRITICAL).sign} no flow"


def repairs(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    """Show the order of repair with what each step brings, and where the plan ends."""
    if plan.steps:
        rows = [
            {
                "No.": number,
                "Pair": pair(diagnosis.controller, *step.land.key),
                "Before [%]": _percent(step.at.before.share) if step.helps else None,
                "After [%]": _percent(step.at.after.share) if step.helps else None,
                "Then": signed(step.at.after.band) if step.helps else None,
                "Helps most at": step.at.condition.label if step.helps else no_help(step),
                "Verdict": step.land.verdict,
            }
            for number, step in enumerate(plan.steps, start=1)
        ]
        show.verdict_table(rows, dict.fromkeys(("Before [%]", "After [%]"), 1))
        as_left = "is as its repair leaves it" if plan.cost else "is made as new"
        st.caption(f"Total share before and after, when each land {as_left}, one after another.")
        _options(diagnosis, plan)
    st.markdown("  \n".join(plain(sentence) for sentence in plan_ends(plan)))
    if plan.steps and len(diagnosis.projections) > 1:
        with st.expander("Every step at every condition"):
            _steps_at_conditions(diagnosis, plan)


def undecided(diagnosis: Diagnosis, *, closing: bool) -> None:
    """Point out the lands that are to be replaced and about which nothing was decided, and reasons that lack."""
    said = " ".join(open_words(diagnosis, job(), wording("en"), closing=closing))
    if said:
        st.warning(f"{plain(said)} The page Estimate is the place for it.")


def _options(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    """Show the repairs that the valve body's file names for the plan's lands."""
    say = wording("en")
    rows = [
        {
            "No.": row.number,
            "Repair": row.name(say),
            "Use": row.use(say),
            "Leaves [µm]": row.leaves(say),
            "Price": row.price(say),
            "Hours": row.hours(say),
            "Tool": row.option.repair.tool or "",
            "Lands": row.lands,
        }
        for row in option_rows(plan)
    ]
    if not rows:
        return
    show.table(rows)
    st.caption("Planned is the cheapest repair of the valve body's file that leaves a land within its limit.")
    names = {repair.id: repair.label for repair in diagnosis.controller.repairs}
    now = session()
    key = f"planned-repairs-{diagnosis.controller.sha256}-{now.generation}"
    st.multiselect(
        "Plan with these repairs",
        list(names),
        default=[repair.id for repair in diagnosis.repairs],
        key=key,
        format_func=names.__getitem__,
        on_change=lambda: choose(repairs=tuple(st.session_state[key])),
        help="One of each land; for the others the cheapest is planned. Report, workbook and job file keep them.",
    )


def _steps_at_conditions(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    first = plan.steps[0]
    rows: list[dict[str, Any]] = [{_STEP: "as measured", **_totals(each.before for each in first.conditions)}]
    for number, step in enumerate(plan.steps, start=1):
        name = f"{number}. {pair(diagnosis.controller, *step.land.key)}"
        rows.append({_STEP: name, **_totals(each.after for each in step.conditions)})
    config: dict[str, Any] = {
        each.condition.name: st.column_config.TextColumn(
            f"{number} · {each.condition.label}", width=CONDITION_WIDTH, help=each.condition.label
        )
        for number, each in enumerate(diagnosis.presented, start=1)
    }
    config[_STEP] = st.column_config.TextColumn("After step", width=150, pinned=True)
    frame = pd.DataFrame(rows)[[_STEP, *(each.condition.name for each in diagnosis.presented)]]
    st.dataframe(frame, hide_index=True, width="stretch", column_config=config)
    st.caption("Total share of the pump's flow after each step, with its band.")


def _totals(totals: Iterable[Total]) -> dict[str, str]:
    return {
        total.condition.name: f"{total.share * PERCENT:.1f} % {signed(total.band)}"
        if math.isfinite(total.share)
        else f"no flow {signed(total.band)}"
        for total in totals
    }


def _percent(share: float) -> float | None:
    return share * PERCENT if math.isfinite(share) else None
