"""Show the plan: repairs as switches that move the unit's totals at once, what each costs, and what was decided.

The switches are the lines of the estimate. The record of the job holds what was changed; lines that nobody touched
follow the verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, get_args

import streamlit as st

from atleak.analysis.estimate import (
    Estimate,
    Line,
    decided_repairs,
    estimate,
    prices_of,
    with_line,
    with_repair,
    with_repairs,
)
from atleak.analysis.record_doubts import decision_faults
from atleak.analysis.repair.choice import Basis, Choice, OfferedRepair, OfferedRepairs, choose
from atleak.analysis.repair.options import MoveKey, Prices
from atleak.analysis.repair.totals import Total
from atleak.catalogue.repairs import Goal
from atleak.catalogue.written_numbers import HOURS, LABOUR_RATE, PRICE, TAX
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import EstimateTerms, Job, RepairDecision, RepairState, clean_text
from atleak.report.tables.estimate import EstimateWords
from atleak.report.tables.repairs import effect_table, offered_words
from pages.shared import fields, pairs, places, reader, show
from pages.shared.cases import result_key
from pages.shared.job_form import key
from pages.shared.state import RECORD, job, put_job, remember, session

_STATES = ("", *get_args(RepairState))
_SEEN = "estimate-lines"  # what each line was when its fields were drawn: one that changed elsewhere gets fresh fields
_SAID = "plan-said"
_FIRST = 5  # repairs that are offered on the page Diagnosis


@st.cache_resource(max_entries=2, scope="session", show_spinner=False)
def _offered(key: str, _diagnosis: Diagnosis) -> OfferedRepairs:
    return OfferedRepairs(_diagnosis)


def _repairs(diagnosis: Diagnosis) -> OfferedRepairs:
    """Return the repairs that are offered of the unit that is shown."""
    repairs: OfferedRepairs = _offered(result_key(session().good), diagnosis)
    return repairs


def made(diagnosis: Diagnosis) -> Estimate:
    """Return the estimate of the job that is shown, as its record stands."""
    return _estimate_of(diagnosis, job())


def _on(repairs: OfferedRepairs, made: Estimate) -> frozenset[MoveKey]:
    """Return the offered repairs that a line of the estimate carries out."""
    lines = tuple(line.decision for line in made.lines)
    return decided_repairs(repairs, job().model_copy(update={"repair_decisions": lines}))


def ends(diagnosis: Diagnosis) -> Sequence[Total]:
    """Return the totals with the repairs made whose switches are on; none where none is."""
    estimated = made(diagnosis)
    return estimated.ends if any(line.carried_out for line in estimated.lines) else ()


def draw_switches(diagnosis: Diagnosis) -> None:
    """Draw a switch for each of the first repairs that the unit calls for, and say what those that are on leave."""
    say, repairs, estimated = reader.say(), _repairs(diagnosis), made(diagnosis)
    on, words = _on(repairs, estimated), EstimateWords(estimated, say)
    costs = {line.key: words.amount(line) for line in estimated.lines}
    _pump(diagnosis, say)
    offers = [each for each in repairs.all if each.called_for or each.key in on]
    if not offers:
        if diagnosis.passed:
            st.write(say("repair_plan.nothing_called_for"))
        return
    with st.container(gap=None, key="switches"):
        _switches(repairs, offers[:_FIRST], say, costs, short=True)
    at = dict.fromkeys(say.condition(each.best_at.condition) for each in offers[:_FIRST] if each.best_at.saving > 0.0)
    said = [say("repair_plan.shares_at", conditions=", ".join(at))] if at else []
    st.caption(show.plain(" ".join([*said, *words.ends()])))
    more = len(offers) - _FIRST
    label = say("repair_plan.more", count=more) if more > 0 else say("repair_plan.priced")
    st.page_link(places.page("Plan"), label=label, width="content")


def draw(diagnosis: Diagnosis) -> Estimate:
    """Draw switches, what they leave, terms, lines and sums; return the estimate as it now is."""
    say, record, repairs = reader.say(), job(), _repairs(diagnosis)
    for fault in decision_faults(record, diagnosis.controller):
        st.error(show.plain(fault))
    _pump(diagnosis, say)
    on = _on(repairs, made(diagnosis))
    _buttons(repairs, on, say)
    if said := st.session_state.pop(_SAID, ""):
        st.warning(said)
    terms = fields.fold(say("estimate_page.terms"), key=f"estimate-terms-{session().generation}", opened=True)
    with terms:
        changed = record.model_copy(update={"estimate": _terms(record.estimate, diagnosis, say)})
    estimated = _estimate_of(diagnosis, changed)
    words = EstimateWords(estimated, say)
    st.caption(show.plain(" ".join(words.chosen_by())))
    if not estimated.lines:
        st.write(say("estimate_page.no_lines"))
    for line in estimated.lines:
        changed = _line(words, line, changed)
    if changed != record:
        st.session_state[RECORD] = changed
        st.rerun()  # what stands above a changed line was made without it
    others = [each for each in repairs.all if not each.called_for]
    if others:
        label, own = say("repair_plan.of_limits", count=len(others)), f"within-limits-{session().generation}"
        fields.unfold(label, own, _switches, repairs, others, say, {})
    st.header(say("estimate_page.sums"))
    names = [say(f"estimate_page.{name}") for name in ("state", "parts", "work", "net", "tax", "total")]
    if rows := [dict(zip(names, words.sum_row(*each), strict=True)) for each in words.sums]:
        st.dataframe(rows, hide_index=True, width="stretch")
    st.caption(show.plain(words.rounding()))
    for sentence in words.missing():
        st.warning(show.plain(sentence))
    st.header(say("estimate_page.leaves"))
    pairs.table(effect_table(estimated.effect, say), "repair-effect")
    for sentence in words.ends():
        st.write(show.plain(sentence))
    return estimated


def _pump(diagnosis: Diagnosis, say: Wording) -> None:
    if diagnosis.pump.verdict.flagged:
        st.markdown(say("pump.repair_first" if diagnosis.pump_new is None else "pump.planned_first"))


def _buttons(repairs: OfferedRepairs, on: frozenset[MoveKey], say: Wording) -> None:
    with st.container(horizontal=True):
        for name, fewest in (("fewest", True), ("cheapest", False)):
            st.button(
                say(f"repair_plan.{name}"),
                help=say(f"repair_plan.{name}_help"),
                key=f"repairs-{name}",
                on_click=_choose_best,
                args=(repairs, fewest, say),
                disabled=not repairs.all,
            )
        st.button(
            say("repair_plan.nothing"),
            help=say("repair_plan.nothing_help"),
            key="repairs-nothing",
            on_click=_decide,
            args=(repairs, frozenset()),
            disabled=not on,
        )


def _choose_best(repairs: OfferedRepairs, fewest: bool, say: Wording) -> None:
    record, diagnosis = job(), repairs.diagnosis
    best = choose(diagnosis, record.estimate.goal, prices_of(record, diagnosis.controller), fewest=fewest)
    _decide(repairs, frozenset(move.key for move in best.chosen))
    said = [say("repair_plan.not_priced")] if not fewest and best.basis is Basis.FEWEST else []
    said += [] if best.reached else [say("repair_plan.not_reached")]
    st.session_state[_SAID] = " ".join(said)


def _switches(
    repairs: OfferedRepairs,
    offers: Iterable[OfferedRepair],
    say: Wording,
    costs: dict[str, str],
    *,
    short: bool = False,
) -> None:
    on = _on(repairs, made(repairs.diagnosis))
    for each in offers:
        name = each.move.key if isinstance(each.move.key, str) else f"{each.move.key[0]}/{each.move.key[1]}"
        own = f"repair-{name}-{session().generation}"
        st.session_state[own] = each.key in on
        cost = costs.get(name, "–")
        words = offered_words(repairs.diagnosis, each, say, short=short) + (f" · {cost}" if cost != "–" else "")
        st.toggle(
            show.plain(words), key=own, width="stretch", wrap=True, on_change=_switch, args=(repairs, each.key, own)
        )


def _switch(repairs: OfferedRepairs, repair: MoveKey, own: str) -> None:
    remember(lambda say: say("done.repairs"))
    by_now = made(repairs.diagnosis)  # another switch may have been turned since this was drawn
    put_job(with_repair(by_now, repairs, job(), repair, on=bool(st.session_state[own])))


def _decide(repairs: OfferedRepairs, keys: frozenset[MoveKey]) -> None:
    remember(lambda say: say("done.repairs"))
    put_job(with_repairs(repairs, job(), keys))


def _terms(terms: EstimateTerms, diagnosis: Diagnosis, say: Wording) -> EstimateTerms:
    """Draw the terms; return them as they now are."""
    goals = list(Goal)
    goal = st.radio(
        say("estimate_page.goal"),
        goals,
        goals.index(terms.goal),
        format_func=lambda each: say(f"estimate_page.goal_{each}"),
        key=key("estimate-goal"),
    )
    places = st.columns(3)
    file_currency = next((each.currency for each in diagnosis.controller.repairs if each.price is not None), None)
    currency = places[0].text_input(
        say("estimate_page.currency"),
        **fields.kept(key("estimate-currency"), terms.currency),
        placeholder=file_currency or "EUR",
        help=say("estimate_page.currency_help"),
    )
    with places[1]:
        rate = fields.number(
            say("estimate_page.labour_rate"), LABOUR_RATE, terms.labour_rate, key=key("estimate-rate"), optional=True
        )
    with places[2]:
        tax = fields.number(say("estimate_page.tax"), TAX, terms.tax_percent, key=key("estimate-tax"), optional=True)
    return EstimateTerms(currency=currency, labour_rate=rate, tax_percent=tax, goal=goal)


def _line(words: EstimateWords, line: Line, record: Job) -> Job:
    """Draw one line; return the record, with the line as the workshop's own where a field of it was changed."""
    say = words.say
    shown = {
        "price": line.price,
        "hours": line.hours,
        "decision": line.decision.decision,
        "reason": line.decision.reason,
    }
    own = key(f"estimate-{line.key}-{_generation(line)}")
    with st.container(border=True, key=own):
        parts = [words.estimate.diagnosis.pump] if line.of_pump else line.lands
        verdicts = ", ".join(dict.fromkeys(say.signed(each.verdict) for each in parts))
        part = f" ({line.decision.part_number})" if line.decision.part_number else ""
        needed = "" if line.chosen else f" — *{say('estimate_page.not_needed')}*"
        st.toggle(
            f"**{show.plain(words.pair(line))}** · {verdicts}: {show.plain(words.work(line) + part)}{needed}",
            wrap=True,
            **_carried_out(words.estimate.diagnosis, line, own),
        )
        places = st.columns([2, 2, 2, 4])
        currency = words.estimate.currency
        with places[0]:
            price = fields.number(
                say("estimate_page.price"), replace(PRICE, unit=currency), line.price, key=f"{own}-price", optional=True
            )
        with places[1]:
            hours = fields.number(say("estimate_page.work"), HOURS, line.hours, key=f"{own}-hours", optional=True)
        states = {each: say.get("job_decisions", each) for each in _STATES}
        state = fields.one_of(
            say("estimate_page.state"), states, f"{own}-state", shown["decision"] or "", place=places[2],
            persist_state="session",
        )  # fmt: skip
        reason = places[3].text_input(say("estimate_page.reason"), **fields.kept(f"{own}-reason", shown["reason"]))
        typed = {"price": price, "hours": hours, "decision": state or None, "reason": clean_text(reason).strip()}
        asked = st.container()
        if typed["decision"] == "declined" and not typed["reason"] and not line.decision.decided_by:
            asked.warning(say("estimate_page.why_declined"))
        if line.decision.decided_by:
            st.caption(show.plain(words.state(line)))
        without = say("estimate_page.without", lacks=words.lacks(line))
        if past := "; ".join(map(words.past, words.estimate.stays_past(line))):
            without += f" {say('estimate_page.then_past', rules=past)}"
        st.caption(show.plain(without))
    changes = {name: value for name, value in typed.items() if value != shown[name]}
    if not changes:
        return record
    if typed["price"] is not None or typed["hours"] is not None:
        changes |= {"price": typed["price"], "hours": typed["hours"]}
    changed = with_line(record, line, **changes)
    _seen()[line.key] = (_generation(line), changed.repair_decisions[-1 if line.place is None else line.place])
    return changed


def _carried_out(diagnosis: Diagnosis, line: Line, own: str) -> dict[str, Any]:
    """Return what makes a line's switch follow its state, and propose the line or leave it open."""
    switch = f"{own}-on"
    st.session_state[switch] = line.carried_out

    def turn() -> None:
        state = "proposed" if st.session_state[switch] else None
        remember(lambda say: say("done.repairs"))
        now = next((each for each in made(diagnosis).lines if each.key == line.key), line)  # turned twice before drawn
        changed = with_line(job(), now, decision=state)
        # the fields beside it stay, with what is typed in them just now
        _seen()[now.key] = (_generation(now), changed.repair_decisions[-1 if now.place is None else now.place])
        st.session_state[RECORD] = changed
        st.session_state[f"{own}-state"] = state or ""

    return {"key": switch, "on_change": turn}


def _seen() -> dict[str, tuple[int, RepairDecision]]:
    seen: dict[str, tuple[int, RepairDecision]] = st.session_state.setdefault(_SEEN, {})
    return seen


def _generation(line: Line) -> int:
    """Return the part of the keys of a line's fields that changes when the line was changed elsewhere."""
    number, decision = _seen().get(line.key, (0, line.decision))
    if decision != line.decision:
        number += 1
    _seen()[line.key] = (number, line.decision)
    return number


def _estimate_of(diagnosis: Diagnosis, record: Job) -> Estimate:
    own = record.model_dump_json(include={"estimate", "repair_decisions"})
    with st.spinner(reader.say()("estimate_page.computing")):
        return _estimate(f"{result_key(session().good)} {own}", diagnosis, record)


@st.cache_resource(max_entries=4, scope="session", show_spinner=False)
def _estimate(key: str, _diagnosis: Diagnosis, _record: Job) -> Estimate:
    def kept_choice(diagnosis: Diagnosis, goal: Goal, prices: Prices, *, kept: Any) -> Choice:
        return _choice(f"{result_key(session().good)} {goal} {prices} {kept}", diagnosis, goal, prices, tuple(kept))

    return estimate(_diagnosis, _record, kept_choice)


@st.cache_resource(max_entries=8, scope="session", show_spinner=False)
def _choice(key: str, _diagnosis: Diagnosis, _goal: Goal, _prices: Prices, _kept: tuple[str, ...]) -> Choice:
    return choose(_diagnosis, _goal, _prices, kept=_kept)
