"""Show a unit's visits, how it wears over them, and how it stands among all units of its valve body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

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
from atleak.views.history_rows import land_name, soonest_first, total_rows, wear_rows
from atleak.wording import wording
from atleak.workshop_units import PERCENT, UM
from pages.shared import show
from pages.shared.book import job_id, open_from_book
from pages.shared.cases import Kept, diagnosis_of, opened_case

UNIT = "unit"  # the parameter of the address that names a unit
OFFERED = 200  # jobs among which a search offers units
SHOWN = 15  # pairs of a Pareto chart, places among the kind
STATES: tuple[RepairState, ...] = get_args(RepairState)  # of a repair, in their order
NARROW = {name: st.column_config.Column(width=width) for name, width in (("Pair", 150), ("Condition", 150))}
FRESH = 60.0  # [s] for which what all units of a kind show is kept


@dataclass(frozen=True)
class Seen:
    """What the visits of a unit tell, with the diagnosis of the last one that measured it."""

    history: WearHistory
    diagnosis: Diagnosis


# --- which unit


def choose(jobs: Book) -> int | None:
    """Let a unit be chosen: the one that the address names, else that of the job of this session."""
    text = st.text_input("Look for another unit", placeholder="VIN, plate, serial, customer or job number")
    named = st.query_params.get(UNIT)
    current = int(named) if named is not None and named.isdecimal() else None
    if current is None and (here := job_id()) is not None:
        current = unit_of_job(jobs, here)
    if text.strip():
        offered = {row.unit: _label(row) for row in reversed(jobs.rows(Query(text=text, limit=OFFERED)))}
        if not offered:
            st.info("No job of the book is found by that.")
        else:
            current = st.selectbox("Unit", list(reversed(offered)), format_func=offered.__getitem__)
            st.query_params[UNIT] = str(current)
    if current is None:
        st.info("The job that is shown is not in the job book yet. Look for a unit, or begin a job.")
    return current


def _label(row: JobRow) -> str:
    known = (row.serial, row.vin, row.plate, row.customer)
    return " · ".join([each for each in known if each] or [row.number or row.id])


def visits(jobs: Book, unit: int) -> tuple[VisitedJob, ...]:
    """Return the jobs of a unit, the earliest first, or say that there are none."""
    visited = visits_of_unit(jobs, unit, Kept())
    if not visited:
        st.info("The job book has no job of this unit that is not archived.")
        st.stop()
    job = visited[-1].stored.file.job
    known = {
        "serial": job.transmission.serial,
        "VIN": job.vehicle.vin,
        "plate": job.vehicle.registration,
        "customer": job.customer.name,
    }
    said = ", ".join(f"{name} **{show.plain(text)}**" for name, text in known.items() if text)
    st.markdown(said or "Neither serial, VIN nor plate is written down: this job is a unit of its own.")
    return visited


# --- visits


def draw_visits(visited: tuple[VisitedJob, ...]) -> None:
    """Show the visits, the last one first, and which of their sheets cannot be read any more."""
    rows = []
    for each in reversed(visited):
        mileage = each.visit.mileage
        rows.append(
            {
                "Verdict": str(each.stored.file.result["verdict"]),
                "Date": each.date.isoformat(),
                "Mileage [km]": None if mileage is None else wording("en").number(mileage, 0),
                "Job": each.visit.name or each.stored.id,
                "Measured": sum(land.state.can_be_ok for land in each.visit.lands),
                **{state.capitalize(): len(each.decided(state)) or None for state in STATES},
            }
        )
        if each.problem:
            st.warning(f"The sheet of {show.plain(each.visit.label)} cannot be read: {show.plain(each.problem)}")
    show.verdict_table(rows, {state.capitalize(): 0 for state in STATES})


def goal(visited: tuple[VisitedJob, ...]) -> tuple[str, dict[str, str]] | None:
    """Offer to open the job of a visit, or to put it beside the one before; return the page to go to."""
    jobs = {each.stored.id: each for each in visited}
    with st.container(horizontal=True, vertical_alignment="bottom"):
        id = st.selectbox("Visit", list(reversed(jobs)), format_func=lambda id: jobs[id].visit.label, key="unit-visit")
        opened = st.button("Open its job", on_click=_open, args=(id,))
        place = list(jobs).index(id)
        compared = st.button("Compare with the visit before", disabled=place == 0)
    if compared:
        return "12_Compare", {"before": list(jobs)[place - 1], "after": id}
    return ("4_Diagnosis", {}) if opened and job_id() == id else None


def _open(id: str) -> None:
    open_from_book(id)  # where it cannot be opened, the head of the page says why


def draw_left_undone(visited: tuple[VisitedJob, ...]) -> None:
    """Say what was declined or deferred and not done since, with its reason, and list every decision in a fold."""
    undone = left_undone(visited)
    if undone:
        said = (f"- {_decision(decision)} ({each.date.isoformat()})" for each, decision in undone)
        st.markdown("\n".join(["**Left undone so far:**", "", *said]))
    every = [(each, decision) for each in reversed(visited) for decision in each.decisions]
    if every:
        with st.expander(f"Every repair that was decided on ({len(every)})"):
            show.table(
                [
                    {
                        "Date": each.date.isoformat(),
                        "Pair": _pair(decision),
                        "Decision": decision.decision,
                        "Work": decision.work,
                        "Reason": decision.reason,
                    }
                    for each, decision in every
                ]
            )


def _decision(each: RepairDecision) -> str:
    work = f", {show.plain(each.work)}" if each.work else ""
    reason = f": {show.plain(each.reason)}" if each.reason else ", no reason written down"
    return f"{show.plain(_pair(each))}{work} **{each.decision}**{reason}"


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
        st.error(f"The last sheet cannot be computed: {show.plain(error)}")
        return None
    # one without a sheet tells the mileage, and what was repaired at it
    return Seen(wear_over_mileage([each.visit for each in visited], diagnosis.limits), diagnosis)


def draw_clearance(now: Seen) -> None:
    """Show the clearance of one land over mileage, that which reaches a limit first unless another one is chosen."""
    keys = [land.key for land in soonest_first(now.history)]
    if not keys:
        st.info("No land was measured on both of its parts.")
        return
    controller = now.diagnosis.controller
    key = st.selectbox("Land", keys, format_func=lambda each: land_name(controller, each), key="unit-land")
    land = now.history.land(key)
    show.chart(figures.clearance_over_mileage(land, now.history.visits, now.history.present), "unit-clearance")
    show.messages(now.history.messages, "the visits")


def draw_wear(now: Seen) -> None:
    """Show how fast every land wears and when it reaches its limits."""
    if not now.history.with_rate:
        st.info(
            "Nothing tells how fast this unit wears: that takes two visits with their mileages, or one and mounting "
            "clearances that were measured."
        )
        return
    show.table(wear_rows(now.history, now.diagnosis.controller), number=show.rounded, column_config=NARROW)
    st.caption(
        "Wear is taken as proportional to mileage. Brackets: 90 % intervals, by the uncertainty of measuring alone."
    )


def draw_totals(now: Seen) -> None:
    """Show what the whole unit will draw at later mileages, at the condition that is chosen."""
    totals = totals_over_mileage(now.history, now.diagnosis)
    if not totals.totals:
        st.info("Without a rate of any land there is no total over mileage.")
        return
    by_name = {total.condition.name: total for total in totals.totals}
    name = st.selectbox(
        "Condition", list(by_name), format_func=lambda each: by_name[each].condition.label, key="unit-condition"
    )
    show.chart(figures.total_over_mileage(by_name[name]), "unit-total")
    show.table(total_rows(totals.totals), number=show.rounded, column_config=NARROW)
    show.messages(totals.messages, "the total over mileage")
    st.caption("Fluid, pressures and pump as at the last visit; each land at its own line, through the engine.")


# --- among its kind


@st.cache_resource(max_entries=8, ttl=FRESH, show_spinner=False)
def _across(name: str, controller: str, _jobs: Book) -> AcrossUnits:
    return across_units(_jobs, controller)


def draw_kind(jobs: Book, unit: int, now: Seen) -> None:
    """Show all units of the valve body: where this one stands, and what is flagged and replaced most often."""
    controller = now.diagnosis.controller
    across = _across(jobs.name, controller.id, jobs)
    counted = f"{across.units} unit{'s' * (across.units != 1)}"
    st.write(f"{counted} of **{show.plain(controller.name)}** in the job book, each as it was measured last.")
    places = [each for each in standing(jobs, across, unit) if each.enough]
    if places:
        spread = {land.key: land for land in across.lands}
        rows = [
            {
                "Pair": land_name(controller, each.key),
                "This unit [µm]": each.clearance * UM,
                "Wider than [%]": each.part * PERCENT,
                "Units": each.others,
                **{
                    f"{part:.0%} [µm]": value * UM
                    for part, value in zip(PARTS, spread[each.key].clearances, strict=True)
                },
            }
            for each in places
        ]
        show.table(rows[:SHOWN], number=show.rounded, column_config=NARROW)
        st.caption(f"The {len(rows[:SHOWN])} widest among their kind; the right columns are quantiles of all units.")
    else:
        st.info(f"Where this unit stands among its kind is shown from {ENOUGH_UNITS} other units on.")
    flagged = [(f"{component}/{land}", each.flagged) for each in across.flagged for component, land in [each.key]]
    _pareto("flagged", flagged, across.units)
    _pareto("repaired", [(pair.name, pair.units) for pair in across.replaced], across.units)


def _pareto(what: str, counted: list[tuple[str, int]], of: int) -> None:
    if counted:
        names, counts = zip(*counted[:SHOWN], strict=True)
        show.chart(figures.pareto(names, counts, of, what), f"unit-{what}")
