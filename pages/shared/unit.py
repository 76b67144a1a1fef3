"""Show a unit's visits, how it wears over them, and how it stands among all units of its valve body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.errors import AtleakError
from atleak.figures import history_figures as figures
from atleak.history.land_wear import WearHistory, wear_over_mileage
from atleak.history.totals import totals_over_mileage
from atleak.job.record import RepairDecision, RepairState
from atleak.jobs.across import ENOUGH_UNITS, PARTS, AcrossUnits, across_units, standing
from atleak.jobs.book import Book, JobRow
from atleak.jobs.search import Query
from atleak.jobs.unit_visits import VisitedJob, left_undone, unit_of_job, visits_of_unit
from atleak.verdicts import Band, Verdict
from atleak.views.history_rows import PER, levels_of, soonest_first, total_rows, wear_rows
from atleak.views.land_names import land_number, land_words
from atleak.views.table import Column
from atleak.wording import Wording
from atleak.workshop_units import PERCENT, UM
from pages.shared import reader, show
from pages.shared.book import job_id, open_from_book
from pages.shared.cases import Kept, diagnosis_of, opened_case

UNIT = "unit"  # the parameter of the address that names a unit
OFFERED = 200  # jobs among which a search offers units
SHOWN = 15  # pairs of a Pareto chart, places among the kind
STATES: tuple[RepairState, ...] = get_args(RepairState)  # of a repair, in their order
_VISITS = (
    Column("verdict", "verdict", width=92),
    Column("date"),
    Column("mileage", "distance"),
    Column("job"),
    Column("measured", digits=0),
)
FRESH = 60.0  # [s] for which what all units of a kind show is kept


@dataclass(frozen=True)
class Seen:
    """What the visits of a unit tell, with the diagnosis of the last one that measured it."""

    history: WearHistory
    diagnosis: Diagnosis


# --- which unit


def choose(jobs: Book) -> int | None:
    """Let a unit be chosen: the one that the address names, else that of the job of this session."""
    say = reader.say()
    text = st.text_input(say("unit.look"), placeholder=say("unit.look_by"))
    named = st.query_params.get(UNIT)
    current = int(named) if named is not None and named.isdecimal() else None
    if current is None and (here := job_id()) is not None:
        current = unit_of_job(jobs, here)
    if text.strip():
        offered = {row.unit: _label(row) for row in reversed(jobs.rows(Query(text=text, limit=OFFERED)))}
        if not offered:
            st.info(say("unit.none_by_that"))
        else:
            current = st.selectbox(say("unit.title"), list(reversed(offered)), format_func=offered.__getitem__)
            st.query_params[UNIT] = str(current)
    if current is None:
        st.info(say("unit.not_in_book"))
    return current


def _label(row: JobRow) -> str:
    known = (row.serial, row.vin, row.plate, row.customer)
    return " · ".join([each for each in known if each] or [row.number or row.id])


def visits(jobs: Book, unit: int) -> tuple[VisitedJob, ...]:
    """Return the jobs of a unit, the earliest first, or say that there are none."""
    say, visited = reader.say(), visits_of_unit(jobs, unit, Kept())
    if not visited:
        st.info(say("unit.no_job"))
        st.stop()
    job = visited[-1].stored.file.job
    known = {
        "serial": job.transmission.serial,
        "vin": job.vehicle.vin,
        "plate": job.vehicle.registration,
        "customer": job.customer.name,
    }
    said = ", ".join(f"{say(f'unit.{name}')} **{show.plain(text)}**" for name, text in known.items() if text)
    st.markdown(said or say("unit.of_its_own"))
    return visited


# --- visits


def draw_visits(visited: tuple[VisitedJob, ...]) -> None:
    """Show the visits, the last one first, and which of their sheets cannot be read any more."""
    say = reader.say()
    rows: list[dict[str, Any]] = []
    for each in reversed(visited):
        decided: dict[str, int | None] = {state: len(each.decided(state)) or None for state in STATES}
        rows.append(
            {
                "verdict": Verdict(each.stored.file.result["verdict"]),
                "date": each.date.isoformat(),
                "mileage": each.visit.mileage,
                "job": each.visit.name or each.stored.id,
                "measured": sum(land.state.can_be_ok for land in each.visit.lands),
                **decided,
            }
        )
        if each.problem:
            st.warning(say("unit.sheet_unread", visit=show.plain(each.visit.label), problem=show.plain(each.problem)))
    by_state = (Column(state, digits=0, words=say(f"job_decisions.{state}")) for state in STATES)
    show.rows_table(rows, [*_VISITS, *by_state])


def goal(visited: tuple[VisitedJob, ...]) -> tuple[str, dict[str, str]] | None:
    """Offer to open the job of a visit, or to put it beside the one before; return the page to go to."""
    say, jobs = reader.say(), {each.stored.id: each for each in visited}
    with st.container(horizontal=True, vertical_alignment="bottom"):
        id = st.selectbox(
            say("unit.visit"), list(reversed(jobs)), format_func=lambda id: jobs[id].visit.label, key="unit-visit"
        )
        opened = st.button(say("unit.open"), on_click=_open, args=(id,))
        place = list(jobs).index(id)
        compared = st.button(say("unit.compare"), disabled=place == 0)
    if compared:
        return "12_Compare", {"before": list(jobs)[place - 1], "after": id}
    return ("4_Diagnosis", {}) if opened and job_id() == id else None


def _open(id: str) -> None:
    open_from_book(id)  # where it cannot be opened, the head of the page says why


def draw_left_undone(visited: tuple[VisitedJob, ...]) -> None:
    """Say what was declined or deferred and not done since, with its reason, and list every decision in a fold."""
    say, undone = reader.say(), left_undone(visited)
    if undone:
        said = (f"- {_decision(decision, say)} ({say.date(each.date)})" for each, decision in undone)
        st.markdown("\n".join([f"**{say('unit.left_undone')}**", "", *said]))
    every = [(each, decision) for each in reversed(visited) for decision in each.decisions]
    if every:
        with st.expander(say("unit.every_repair", count=len(every))):
            show.rows_table(
                [
                    {
                        "date": each.date.isoformat(),
                        "pair": _pair(decision),
                        "repair_decision": say.get("job_decisions", decision.decision or ""),
                        "work": decision.work,
                        "reason": decision.reason,
                    }
                    for each, decision in every
                ],
                [Column(name) for name in ("date", "pair", "repair_decision", "work", "reason")],
            )


def _decision(each: RepairDecision, say: Wording) -> str:
    work = f", {show.plain(each.work)}" if each.work else ""
    reason = f": {show.plain(each.reason)}" if each.reason else f", {say('unit.no_reason')}"
    return f"{show.plain(_pair(each))}{work} **{say.get('job_decisions', each.decision or '')}**{reason}"


def _pair(each: RepairDecision) -> str:
    return each.component if each.land is None else f"{each.component}/{each.land}"


# --- wear


def seen(visited: tuple[VisitedJob, ...]) -> Seen | None:
    """Return what the visits tell of wear; None where no sheet measured anything."""
    measured = [each for each in visited if each.visit.lands]
    if not measured:
        return None
    try:
        diagnosis = diagnosis_of(opened_case(measured[-1].stored.file.case))
    except AtleakError as error:
        st.error(reader.say()("unit.last_sheet", problem=show.plain(error)))
        return None
    # one without a sheet tells the mileage, and what was repaired at it
    return Seen(wear_over_mileage([each.visit for each in visited], diagnosis.limits), diagnosis)


def draw_clearance(now: Seen) -> None:
    """Show the clearance of one land over mileage, that which reaches a limit first unless another one is chosen."""
    say, keys = reader.say(), [land.key for land in soonest_first(now.history)]
    if not keys:
        st.info(say("unit.no_land"))
        return
    controller = now.diagnosis.controller
    key = st.selectbox(
        say("columns.land"), keys, format_func=lambda each: land_words(controller, each, say), key="unit-land"
    )
    land = now.history.land(key)
    figure = figures.clearance_over_mileage(land, now.history.visits, now.history.present, say)
    show.chart(figure, "unit-clearance")
    show.messages(now.history.messages, say("about.visits"))


def draw_wear(now: Seen) -> None:
    """Show how fast every land wears and when it reaches its limits."""
    say = reader.say()
    if not now.history.with_rate:
        st.info(say("unit.no_rate"))
        return
    rate = say(
        "history.rate_heading", unit=say.unit("clearance"), distance=f"{say.number(PER, 0)} {say.unit('distance')}"
    )
    columns = [
        Column("pair", width=150),
        Column("clearance", "clearance"),
        Column("rate", words=rate),
        *(_at(level, say) for level in levels_of(now.history)),
        Column("visits", digits=0),
        Column("since"),
    ]
    show.rows_table(wear_rows(now.history, now.diagnosis.controller, say), columns)
    st.caption(say("unit.wear_note"))


def draw_totals(now: Seen) -> None:
    """Show what the whole unit will draw at later mileages, at the condition that is chosen."""
    say, totals = reader.say(), totals_over_mileage(now.history, now.diagnosis)
    if not totals.totals:
        st.info(say("unit.no_totals"))
        return
    by_name = {total.condition.name: total for total in totals.totals}
    name = st.selectbox(
        say("columns.condition"),
        list(by_name),
        format_func=lambda each: say.condition(by_name[each].condition),
        key="unit-condition",
    )
    show.chart(figures.total_over_mileage(by_name[name], say), "unit-total")
    levels = dict.fromkeys(limit.level for total in totals.totals for limit in total.limits)
    ahead = say("history.ahead", mileage=say.quantity(totals.totals[0].mileages[-1], "distance", 0))
    columns = [
        Column("condition", width=150),
        Column("now", "percent"),
        Column("ahead", words=f"{ahead} [%]"),
        *(_at(level, say) for level in levels),
    ]
    show.rows_table(total_rows(totals.totals, say), columns)
    show.messages(totals.messages, say("about.totals"))
    st.caption(say("unit.totals_note"))


def _at(level: Verdict | Band, say: Wording) -> Column:
    return Column(level, words=say("history.at", level=say.signed(level)))


# --- among its kind


@st.cache_resource(max_entries=8, ttl=FRESH, show_spinner=False)
def _across(name: str, controller: str, _jobs: Book) -> AcrossUnits:
    return across_units(_jobs, controller)


def draw_kind(jobs: Book, unit: int, now: Seen) -> None:
    """Show all units of the valve body: where this one stands, and what is flagged and replaced most often."""
    controller = now.diagnosis.controller
    across = _across(jobs.name, controller.id, jobs)
    say = reader.say()
    st.write(say("unit.of_kind", count=across.units, controller=f"**{show.plain(say.name(controller.name))}**"))
    places = [each for each in standing(jobs, across, unit) if each.enough]
    if places:
        spread = {land.key: land for land in across.lands}
        rows = [
            {
                "pair": land_words(controller, each.key, say),
                "this_unit": each.clearance * UM,
                "wider_than": each.part * PERCENT,
                "units": each.others,
                **{f"{part:.0%}": value * UM for part, value in zip(PARTS, spread[each.key].clearances, strict=True)},
            }
            for each in places
        ]
        columns = [
            Column("pair", width=150),
            Column("this_unit", "clearance"),
            Column("wider_than", "percent", 0),
            Column("units", digits=0),
            *(Column(f"{part:.0%}", "clearance", words=say.percent(part, 0)) for part in PARTS),
        ]
        show.rows_table(rows[:SHOWN], columns)
        st.caption(say("unit.widest", count=len(rows[:SHOWN])))
    else:
        st.info(say("unit.not_enough", count=ENOUGH_UNITS))
    flagged = [(land_number(controller, each.key, say), each.flagged) for each in across.flagged]
    _pareto("flagged", flagged, across.units)
    _pareto("repaired", [(pair.name, pair.units) for pair in across.replaced], across.units)


def _pareto(what: str, counted: list[tuple[str, int]], of: int) -> None:
    if counted:
        names, counts = zip(*counted[:SHOWN], strict=True)
        show.chart(figures.pareto(names, counts, of, what, reader.say()), f"unit-{what}")
