"""Show the estimate as a form: its terms, its lines to decide on, its sums, and what they leave of the unit.

The record of the job holds what was changed, and the lines that nobody touched follow the verdict.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import streamlit as st

from atleak.analysis.estimate import Estimate, Line, estimate, with_line
from atleak.analysis.record_doubts import decision_faults
from atleak.analysis.repair.choice import Choice, choose
from atleak.analysis.repair.options import Prices
from atleak.catalogue.repairs import Goal
from atleak.catalogue.written_numbers import HOURS, LABOUR_RATE, PRICE, TAX
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import EstimateTerms, Job, RepairDecision, RepairState, clean_text
from atleak.report.tables.estimate import EstimateWords
from pages.shared import fields, reader, show
from pages.shared.cases import result_key
from pages.shared.job_form import key
from pages.shared.state import RECORD, job, session

_STATES = ("", *get_args(RepairState))
_SEEN = "estimate-lines"  # what each line was when its fields were drawn: one that changed elsewhere gets fresh fields


def draw(diagnosis: Diagnosis) -> Estimate:
    """Draw terms, lines and sums; return the estimate as it now is."""
    say, record = reader.say(), job()
    for fault in decision_faults(record, diagnosis.controller):
        st.error(show.plain(fault))
    changed = record.model_copy(update={"estimate": _terms(record.estimate, diagnosis, say)})
    made = _estimate_of(diagnosis, changed)
    words = EstimateWords(made, say)
    st.subheader(say("estimate_page.lines"))
    st.caption(show.plain(" ".join(words.chosen_by())))
    if not made.lines:
        st.write(say("estimate_page.no_lines"))
    for line in made.lines:
        changed = _line(words, line, changed)
    if changed != record:
        st.session_state[RECORD] = changed
        st.rerun()  # what stands above a changed line was made without it
    st.subheader(say("estimate_page.sums"))
    _sums(words)
    return made


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
        st.markdown(f"**{show.plain(words.pair(line))}** · {verdicts}: {show.plain(words.work(line) + part)}{needed}")
        places = st.columns([2, 2, 2, 4])
        currency = words.estimate.currency
        with places[0]:
            price = fields.number(
                say("estimate_page.price"), replace(PRICE, unit=currency), line.price, key=f"{own}-price", optional=True
            )
        with places[1]:
            hours = fields.number(say("estimate_page.work"), HOURS, line.hours, key=f"{own}-hours", optional=True)
        start = fields.kept(f"{own}-state", shown["decision"] or "")
        state = places[2].selectbox(
            say("estimate_page.state"),
            _STATES,
            _STATES.index(start.pop("value")),
            format_func=lambda each: say.get("job_decisions", each),
            **start,
        )
        reason = places[3].text_input(say("estimate_page.reason"), **fields.kept(f"{own}-reason", shown["reason"]))
        typed = {"price": price, "hours": hours, "decision": state or None, "reason": clean_text(reason).strip()}
        asked = st.container()
        if typed["decision"] == "declined" and not typed["reason"]:
            asked.warning(say("estimate_page.why_declined"))
        st.caption(show.plain(_without(words, line)))
    changes = {name: value for name, value in typed.items() if value != shown[name]}
    if not changes:
        return record
    if typed["price"] is not None or typed["hours"] is not None:
        changes |= {"price": typed["price"], "hours": typed["hours"]}
    changed = with_line(record, line, **changes)
    _seen()[line.key] = (_generation(line), changed.repair_decisions[-1 if line.place is None else line.place])
    return changed


def _without(words: EstimateWords, line: Line) -> str:
    """Say what is worse without a line, and what then stays past a limit."""
    say, past = words.say, words.estimate.stays_past(line)
    sentence = say("estimate_page.without", lacks=words.lacks(line))
    return f"{sentence} {say('estimate_page.then_past', rules='; '.join(map(words.past, past)))}" if past else sentence


def _sums(words: EstimateWords) -> None:
    say = words.say
    names = [say(f"estimate_page.{name}") for name in ("state", "parts", "work", "net", "tax", "total")]
    rows = [dict(zip(names, words.sum_row(*each), strict=True)) for each in words.sums]
    if rows:
        show.records(rows)
    st.caption(show.plain(words.rounding()))
    for sentence in words.missing():
        st.warning(show.plain(sentence))
    st.subheader(say("estimate_page.leaves"))
    for sentence in words.ends():
        st.write(show.plain(sentence))


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
