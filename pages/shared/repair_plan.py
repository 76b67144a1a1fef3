"""Show the repairs of a unit to tick, what the ticked ones leave of it, and take them into the job's decisions."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import streamlit as st

from atleak.analysis.estimate import decided_repairs, prices_of, with_repairs
from atleak.analysis.repair.choice import Basis, OfferedRepair, OfferedRepairs, choose, ticked
from atleak.analysis.repair.options import MoveKey
from atleak.analysis.repair.totals import Total
from atleak.catalogue.repairs import Goal
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.repairs import effect_sentences, effect_table, offered_words
from pages.shared import address, fields, pairs, reader, show
from pages.shared.cases import result_key
from pages.shared.show import plain
from pages.shared.state import job, job_generation, put_job, remember, session

_ADDRESS = "repairs"  # what is ticked, in the address
_NOTHING = "none"  # there: every tick was taken away
_SAID = "repair-plan-said"


@st.cache_resource(max_entries=2, scope="session", show_spinner=False)
def _offered(key: str, _diagnosis: Diagnosis) -> OfferedRepairs:
    return OfferedRepairs(_diagnosis)


def offered(diagnosis: Diagnosis) -> OfferedRepairs:
    """Return the repairs that are offered of the unit that is shown."""
    repairs: OfferedRepairs = _offered(result_key(session().good), diagnosis)
    return repairs


def ticks(repairs: OfferedRepairs) -> frozenset[MoveKey]:
    """Return the repairs that are ticked: those kept, else those that were decided."""
    written = address.kept(_ADDRESS)
    if not written:
        return decided_repairs(repairs, job())
    names = {_name(each.key): each.key for each in repairs.all}
    return frozenset(names[name] for name in written.split(",") if name in names)


def decided_totals(diagnosis: Diagnosis) -> tuple[Total, ...]:
    """Return the totals with the repairs made that the job's record decides on; none where it decides on none."""
    repairs = offered(diagnosis)
    decided = decided_repairs(repairs, job())
    return repairs.totals(decided) if decided else ()


@st.fragment
@show.faults()
def draw(diagnosis: Diagnosis) -> None:
    """Draw the plan; a tick computes nothing else of the page again."""
    say, repairs = reader.say(), offered(diagnosis)
    if diagnosis.pump.verdict.flagged:
        st.markdown(say("pump.repair_first" if diagnosis.pump_new is None else "pump.planned_first"))
    if not repairs.all:
        st.write(say("repair_plan.nothing_offered"))
        return
    st.caption(say("repair_plan.how"))
    chosen = ticks(repairs)
    _buttons(repairs, chosen, say)
    if said := st.session_state.pop(_SAID, ""):
        st.warning(said)
    draw_ticks = partial(_ticks, repairs, chosen, say)
    draw_ticks(each for each in repairs.all if each.called_for)
    others = [each for each in repairs.all if not each.called_for]
    if others:
        with fields.fold(say("repair_plan.of_limits", count=len(others)), key=f"within-limits-{session().generation}"):
            draw_ticks(others)
    effect = repairs.effect(chosen)
    pairs.table(effect_table(effect, say), "repair-effect")
    st.markdown(plain(" ".join(effect_sentences(repairs, chosen, effect, say))))
    decided = chosen == decided_repairs(repairs, job())
    if st.button(say("repair_plan.take"), help=say("repair_plan.take_help"), type="primary", key="take-repairs"):
        remember(lambda say: say("done.repairs"))
        put_job(with_repairs(repairs, job(), chosen))
        address.keep(_ADDRESS, "")  # from now on the ticks follow the decisions
        st.rerun()  # the whole page: the job's record has changed, and is saved
    if decided and job().repair_decisions:
        st.caption(say("repair_plan.taken"))


def _buttons(repairs: OfferedRepairs, chosen: frozenset[MoveKey], say: Wording) -> None:
    with st.container(horizontal=True):
        for name, fewest in (("fewest", True), ("cheapest", False)):
            st.button(
                say(f"repair_plan.{name}"),
                help=say(f"repair_plan.{name}_help"),
                key=f"repairs-{name}",
                on_click=_tick_best,
                args=(repairs, fewest, say),
            )
        st.button(
            say("repair_plan.nothing"),
            help=say("repair_plan.nothing_help"),
            key="repairs-nothing",
            on_click=_keep,
            args=(frozenset(),),
            disabled=not chosen,
        )


def _tick_best(repairs: OfferedRepairs, fewest: bool, say: Wording) -> None:
    record, diagnosis = job(), repairs.diagnosis
    best = choose(diagnosis, Goal.EVERY_LIMIT, prices_of(record, diagnosis.controller), fewest=fewest)
    _keep(frozenset(move.key for move in best.chosen))
    said = [say("repair_plan.not_priced")] if not fewest and best.basis is Basis.FEWEST else []
    said += [] if best.reached else [say("repair_plan.not_reached")]
    st.session_state[_SAID] = " ".join(said)


def _ticks(
    repairs: OfferedRepairs,
    chosen: frozenset[MoveKey],
    say: Wording,
    offers: Iterable[OfferedRepair],
) -> None:
    for each in offers:
        key = f"repair-{_name(each.key)}-{session().generation}-{job_generation()}"
        st.session_state[key] = each.key in chosen
        words = offered_words(repairs.diagnosis, each, say)
        st.checkbox(plain(words), key=key, on_change=_tick, args=(repairs, each.key, key))


def _tick(repairs: OfferedRepairs, repair: MoveKey, key: str) -> None:
    _keep(ticked(repairs, ticks(repairs), repair, bool(st.session_state[key])))


def _keep(keys: frozenset[MoveKey]) -> None:
    address.keep(_ADDRESS, ",".join(sorted(map(_name, keys))) or _NOTHING)


def _name(key: MoveKey) -> str:
    return key if isinstance(key, str) else f"{key[0]}/{key[1]}"
