"""Show what depends on the condition: totals, the matrix of lands, the customer's complaint, the order of repair."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import Any

import pandas as pd
import streamlit as st

from atleak.analysis.repair.plan import RepairPlan, Total
from atleak.common.style import look_of
from atleak.common.unit_systems import DM3_MIN, KPA, PERCENT, RPM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.complaint import finding, measure_first, reason
from atleak.report.tables.estimate import open_words
from atleak.report.tables.lands import leaking_worst_first
from atleak.report.tables.repairs import option_table, order_table, plan_ends, repair_name
from atleak.report.tables.sentences import counted_in_speed, land_in_words, position_sentence, shares_add_up
from pages.shared import reader, show
from pages.shared.show import plain
from pages.shared.state import choose, job, session

MEASURE_FIRST = 8  # lands named for a complaint; the others are in a fold
PAIR_WIDTH = 150  # pixels of a land's name, its number first
_LETTER, _PADDING = 7, 20  # pixels of a letter, and of a cell's sides
_TWO_LINES = 52  # pixels of a row
CONDITION_WIDTH = 104  # pixels of a condition: two of them stand beside the pair on a phone
_PAIR, _ELSEWHERE, _STEP = "a pair", "leaks elsewhere", "a step"  # no condition's name has a blank


def complaint(diagnosis: Diagnosis) -> None:
    """Show the customer's complaint, where it can show, what explains it, and which lands to measure first."""
    if diagnosis.complaint is None:
        return
    say = reader.say()
    shows = ", ".join(f"**{plain(say.condition(each.condition))}**" for each in diagnosis.complained)
    ranked = measure_first(diagnosis)
    lines = [
        f"- **{plain(land_in_words(diagnosis, each.land.key, say))}**: {plain(reason(each, say))}" for each in ranked
    ]
    st.subheader(say("diagnosis.complaint", label=plain(say.name(diagnosis.complaint.label))))
    said = f"{say('diagnosis.complaint_shows', conditions=shows)} {plain(finding(diagnosis, say))}"
    st.markdown("\n".join([said, "", *lines[:MEASURE_FIRST]]))
    if lines[MEASURE_FIRST:]:
        with st.expander(say("diagnosis.complaint_more", count=len(lines) - MEASURE_FIRST)):
            st.markdown("\n".join(lines[MEASURE_FIRST:]))
    st.caption(plain(say("diagnosis.complaint_source", source=diagnosis.complaint.source)))


def totals(diagnosis: Diagnosis, record: dict[str, Any]) -> None:
    """Show every condition with its total, and from which speed the pump covers the leakage."""
    say = reader.say()
    sources = {row["name"]: row["source"] for row in record["conditions"]}
    for number, point in enumerate(diagnosis.presented, start=1):
        label = say.condition(point.condition)
        if point is diagnosis.worst and len(sources) > 1:
            label = say("diagnosis.total_worst", condition=label)
        st.caption(
            plain(
                say(
                    "diagnosis.total_line",
                    number=number,
                    condition=label,
                    leakage=say.quantity(point.leakage * DM3_MIN, "flow"),
                    capacity=say.quantity(point.pump_capacity * DM3_MIN, "flow"),
                    pressure=say.quantity(point.condition.main_pressure * KPA, "pressure"),
                    speed=say.number(point.condition.engine_speed * RPM, 0),
                    new=say.quantity(diagnosis.new_at(point).leakage * DM3_MIN, "flow"),
                    covered=say.number(point.minimum_speed * RPM, 0),
                    counted=counted_in_speed(diagnosis, say),
                    positions=position_sentence(diagnosis, point, say),
                    source=sources[point.condition.name],
                )
            )
        )


def matrix(diagnosis: Diagnosis) -> None:
    """Show every land that leaks at every condition: its share of the pump's flow with the sign of its verdict."""
    say = reader.say()
    rows = leaking_worst_first(diagnosis, diagnosis.presented)
    if not rows:
        st.write(say("diagnosis.matrix_none"))
        return
    names = [each.condition.name for each in diagnosis.presented]
    frame = pd.DataFrame(
        [
            {
                _PAIR: land_in_words(diagnosis, row.land.key, say),
                **{
                    name: cell.share * PERCENT if math.isfinite(cell.share) else math.nan
                    for name, cell in zip(names, row.cells, strict=True)
                },
                _ELSEWHERE: say.sentence(row.elsewhere),
            }
            for row in rows
        ]
    )
    style = frame.style
    for number, name in enumerate(names):
        cells = [row.cells[number] for row in rows]
        for level in dict.fromkeys(cell.verdict for cell in cells if cell.leakage > 0.0):
            these = [place for place, cell in enumerate(cells) if cell.leakage > 0.0 and cell.verdict == level]
            part = pd.IndexSlice[these, [name]]
            style = style.format(partial(_written, say, level), subset=part, na_rep=_beyond(say, level))
            if level is not None:
                style = style.map(lambda _, level=level: show.colours(level), subset=part)
        if silent := [place for place, cell in enumerate(cells) if cell.leakage == 0.0]:
            style = style.format(lambda _: "–", subset=pd.IndexSlice[silent, [name]])
    config = _condition_columns(diagnosis, say)
    wide, height = _room_for(frame[_PAIR])
    config[_PAIR] = st.column_config.TextColumn(say("diagnosis.matrix_pair"), width=wide, pinned=True)
    elsewhere = st.column_config.TextColumn(say("diagnosis.matrix_elsewhere"), width=300)
    config[_ELSEWHERE] = elsewhere if any(frame[_ELSEWHERE]) else None
    st.dataframe(style, hide_index=True, width="stretch", column_config=config, row_height=height)
    added = shares_add_up(diagnosis, say)
    st.caption(plain(say("diagnosis.matrix_caption", added=added)))


def _room_for(names: Iterable[str]) -> tuple[int, int | None]:
    """Return the width of a column in which no word of a name is cut, and the height of rows in which names wrap."""
    words = [len(word) for name in names for word in name.split()]
    wide = max(PAIR_WIDTH, _LETTER * max(words, default=0) + _PADDING)
    return wide, _TWO_LINES if max(map(len, names), default=0) * _LETTER + _PADDING > wide else None


def _condition_columns(diagnosis: Diagnosis, say: Wording) -> dict[str, Any]:
    return {
        each.condition.name: st.column_config.Column(
            f"{number} · {say.condition(each.condition)}",
            width=CONDITION_WIDTH,
            help=say("diagnosis.matrix_help", condition=say.condition(each.condition)),
        )
        for number, each in enumerate(diagnosis.presented, start=1)
    }


def _written(say: Wording, level: Verdict | None, share: float) -> str:
    number = say.number(share, 2)
    return number if level is None else f"{look_of(level).sign} {number}"


def _beyond(say: Wording, level: Verdict | None) -> str:
    """Say, in place of a number, that the pump delivers nothing."""
    return f"{look_of(level or Verdict.CRITICAL).sign} {say('diagnosis.no_flow')}"


def repairs(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    """Show the order of repair with what each step brings, and where the plan ends."""
    say = reader.say()
    ends = [plain(sentence) for sentence in plan_ends(plan, say)]
    if plan.pump_first:
        st.markdown(ends.pop(0))
    if plan.steps:
        show.table(order_table(diagnosis, plan, say))
        st.caption(say(f"repair_plan.order_caption_{'cost' if plan.cost else 'new'}"))
        _options(diagnosis, plan, say)
    st.markdown("  \n".join(ends))
    if plan.steps and len(diagnosis.projections) > 1:
        st.markdown(f"**{say('repair_plan.every_step')}**")
        _steps_at_conditions(diagnosis, plan, say)


def undecided(diagnosis: Diagnosis, *, closing: bool) -> None:
    """Point out the lands that are to be replaced and about which nothing was decided, and reasons that lack."""
    say = reader.say()
    said = " ".join(open_words(diagnosis, job(), say, closing=closing))
    if said:
        st.warning(plain(say("repair_plan.estimate_place", said=said)))


def _options(diagnosis: Diagnosis, plan: RepairPlan, say: Wording) -> None:
    """Show the repairs that the valve body's file names for the plan's lands."""
    options = option_table(plan, say)
    if not options.rows:
        return
    show.table(options)
    st.caption(say("repair_plan.planned"))
    names = {repair.id: repair_name(repair, say) for repair in diagnosis.controller.repairs}
    key = f"planned-repairs-{diagnosis.controller.sha256}-{session().generation}"
    st.multiselect(
        say("repair_plan.plan_with"),
        list(names),
        default=[repair.id for repair in diagnosis.repairs],
        key=key,
        format_func=names.__getitem__,
        on_change=lambda: choose(repairs=tuple(st.session_state[key])),
        help=say("repair_plan.plan_with_help"),
    )


def _steps_at_conditions(diagnosis: Diagnosis, plan: RepairPlan, say: Wording) -> None:
    first = plan.steps[0]
    before = _totals((each.before for each in first.conditions), say)
    rows: list[dict[str, Any]] = [{_STEP: say("repair_plan.as_measured"), **before}]
    for number, step in enumerate(plan.steps, start=1):
        name = f"{number}. {land_in_words(diagnosis, step.land.key, say)}"
        rows.append({_STEP: name, **_totals((each.after for each in step.conditions), say)})
    config = _condition_columns(diagnosis, say)
    frame = pd.DataFrame(rows)[[_STEP, *(each.condition.name for each in diagnosis.presented)]]
    wide, height = _room_for(frame[_STEP])
    config[_STEP] = st.column_config.TextColumn(say("repair_plan.after_step"), width=wide, pinned=True)
    st.dataframe(frame, hide_index=True, width="stretch", column_config=config, row_height=height)
    st.caption(say("repair_plan.every_step_caption"))


def _totals(totals: Iterable[Total], say: Wording) -> dict[str, str]:
    return {total.condition.name: f"{_share(total, say)} {say.signed(total.band)}" for total in totals}


def _share(total: Total, say: Wording) -> str:
    return say.percent(total.share) if math.isfinite(total.share) else say("diagnosis.no_flow")
