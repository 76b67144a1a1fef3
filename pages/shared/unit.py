"""Show a unit's visits, how it wears over them, and how it stands among all units of its valve body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, get_args

import streamlit as st

from atleak.analysis.history.wear import WearHistory, totals_over_mileage, wear_over_mileage
from atleak.analysis.rates import ENOUGH_UNITS, SHOWN_QUANTILES
from atleak.analysis.record_doubts import components_of
from atleak.common.errors import AtleakError
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job_book.book import Book, JobRow
from atleak.job_book.search import Query
from atleak.job_book.unit_history import (
    AcrossUnits,
    Standing,
    VisitedJob,
    across_units,
    left_undone,
    standing,
    unit_of_visit,
    visits_of_unit,
)
from atleak.measurements.job_card import RepairDecision, RepairState
from atleak.report.charts import history_figures as figures
from atleak.report.tables.history import soonest_first, total_table, wear_table
from atleak.report.tables.names import components_words, land_number, land_words
from atleak.report.tables.table import VERDICT, Column, Table
from pages.shared import fields, reader, show
from pages.shared.book import job_id, open_from_book
from pages.shared.cases import Kept, diagnosis_of, opened_case

UNIT = "unit"  # the parameter of the address that names a unit
OFFERED = 200  # jobs among which a search offers units
SHOWN = 15  # pairs of a Pareto chart, places among the kind
STATES: tuple[RepairState, ...] = get_args(RepairState)  # of a repair, in their order
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
        current = unit_of_visit(jobs, here)
    if text.strip():
        offered = {row.unit: _label(row) for row in reversed(jobs.rows(Query(text=text, limit=OFFERED)))}
        if not offered:
            st.info(say("unit.none_by_that"))
        else:
            current = fields.one_of(say("unit.title"), dict(reversed(offered.items())), f"unit-{text}")
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
    for each in reversed(visited):
        if each.problem:
            st.warning(say("unit.sheet_unread", visit=show.plain(each.visit.label), problem=show.plain(each.problem)))
    columns = (
        Column("verdict", VERDICT, width=92, of=lambda each: Verdict(each.stored.file.result["verdict"])),
        Column("date", of=lambda each: each.date.isoformat()),
        Column("mileage", "distance", of=lambda each: each.visit.mileage),
        Column("job", of=lambda each: each.visit.name or each.stored.id),
        Column("measured", digits=0, of=lambda each: sum(land.state.can_be_ok for land in each.visit.lands)),
        *(
            Column(state, digits=0, words=say(f"job_decisions.{state}"), of=partial(_decided, state))
            for state in STATES
        ),
    )
    show.table(Table("visits", columns, visited[::-1], say))


def _decided(state: RepairState, each: VisitedJob) -> int | None:
    return len(each.decided(state)) or None


def goal(visited: tuple[VisitedJob, ...]) -> tuple[str, dict[str, str]] | None:
    """Offer to open the job of a visit, or to put it beside the one before; return the page to go to."""
    say, jobs = reader.say(), {each.stored.id: each for each in visited}
    with st.container(horizontal=True, vertical_alignment="bottom"):
        labels = {id: each.visit.label for id, each in reversed(jobs.items())}
        id = fields.one_of(say("unit.visit"), labels, "unit-visit")
        show_it: Any = partial(open_from_book, id)
        opened = st.button(say("unit.open"), on_click=show_it)
        place = list(jobs).index(id)
        compared = st.button(say("unit.compare"), disabled=place == 0)
    if compared:
        return "History", {"history": "compare", "before": list(jobs)[place - 1], "after": id}
    return ("Diagnosis", {}) if opened and job_id() == id else None


def draw_left_undone(visited: tuple[VisitedJob, ...]) -> None:
    """Say what was declined or deferred and not done since, with its reason, and list every decision in a fold."""
    say, undone = reader.say(), left_undone(visited)
    if undone:
        lines = [f"**{say('unit.left_undone')}**", ""]
        for each, decision in undone:
            work = f", {show.plain(decision.work)}" if decision.work else ""
            reason = f": {show.plain(decision.reason)}" if decision.reason else f", {say('unit.no_reason')}"
            state = f"**{say.get('job_decisions', decision.decision or '')}**"
            lines.append(f"- {show.plain(_about(each, decision, say))}{work} {state}{reason} ({say.date(each.date)})")
        st.markdown("\n".join(lines))
    every = [(each, decision) for each in reversed(visited) for decision in each.decisions]
    if every:
        with st.expander(say("unit.every_repair", count=len(every))):
            columns = (
                Column("date", of=lambda row: row[0].date.isoformat()),
                Column("pair", of=lambda row: _about(row[0], row[1], say)),
                Column("repair_decision", of=lambda row: say.get("job_decisions", row[1].decision or "")),
                Column("work", of=lambda row: row[1].work),
                Column("reason", of=lambda row: row[1].reason),
            )
            show.table(Table("repairs", columns, every, say))


def _about(visited: VisitedJob, each: RepairDecision, say: Wording) -> str:
    controller = visited.controller
    components = () if controller is None else components_of(each, controller)
    return each.pair if controller is None or len(components) < 2 else components_words(controller, components, say)


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
    names = {key: land_words(controller, key, say) for key in keys}
    land = now.history.land(fields.one_of(say("columns.land"), names, "unit-land"))
    figure = figures.clearance_over_mileage(land, now.history.visits, now.history.present, say)
    show.chart(figure, "unit-clearance")
    show.messages(now.history.messages, say("about.visits"))


def draw_wear(now: Seen) -> None:
    """Show how fast every land wears and when it reaches its limits."""
    say = reader.say()
    if not now.history.with_rate:
        st.info(say("unit.no_rate"))
        return
    show.table(wear_table(now.history, now.diagnosis, say))
    st.caption(say("unit.wear_note"))


def draw_totals(now: Seen) -> None:
    """Show what the whole unit will draw at later mileages, at the condition that is chosen."""
    say, totals = reader.say(), totals_over_mileage(now.history, now.diagnosis)
    if not totals.totals:
        st.info(say("unit.no_totals"))
        return
    by_name = {total.condition.name: total for total in totals.totals}
    names = {name: say.condition(each.condition) for name, each in by_name.items()}
    name = fields.one_of(say("columns.condition"), names, "unit-condition")
    show.chart(figures.total_over_mileage(by_name[name], say), "unit-total")
    show.table(total_table(totals.totals, say))
    show.messages(totals.messages, say("about.totals"))
    st.caption(say("unit.totals_note"))


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

        def clearance(place: int, each: Standing) -> float:
            return spread[each.key].clearances[place]

        columns = (
            Column("pair", width=150, of=lambda each: land_words(controller, each.key, say)),
            Column("this_unit", "clearance", of="clearance", times=UM),
            Column("wider_than", "percent", 0, of="part", times=PERCENT),
            Column("units", digits=0, of="others"),
            *(
                Column(f"{part:.0%}", "clearance", words=say.percent(part, 0), of=partial(clearance, place), times=UM)
                for place, part in enumerate(SHOWN_QUANTILES)
            ),
        )
        show.table(Table("standing", columns, places[:SHOWN], say))
        st.caption(say("unit.widest", count=len(places[:SHOWN])))
    else:
        st.info(say("unit.not_enough", count=ENOUGH_UNITS))
    flagged = [(land_number(controller, each.key, say), each.flagged) for each in across.flagged]
    _pareto("flagged", flagged, across.units)
    _pareto("repaired", [(pair.name, pair.units) for pair in across.replaced], across.units)


def _pareto(what: str, counted: list[tuple[str, int]], of: int) -> None:
    if counted:
        names, counts = zip(*counted[:SHOWN], strict=True)
        show.chart(figures.pareto(names, counts, of, what, reader.say()), f"unit-{what}")
