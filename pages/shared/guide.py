"""Guide through the steps before anything is opened: what each would add, its form, what came of it, and the next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext

import streamlit as st

from atleak.common.verdicts import Verdict, worst
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.before_opening import before_opening
from atleak.report.tables.evidence import evidence_sections
from atleak.report.tables.gauges import card_notes, card_table, gauge_table, pattern_text
from pages.shared import address, fields, reader, show
from pages.shared.cases import diagnosis_of
from pages.shared.state import job, session

STEPS = ("complaint", "fluid", "gauges", "drive", "jug", "vacuum", "open")
_SKIPPED = "skipped"  # the name in the address; the step stays open to whoever wants to do it after all


def begin() -> None:
    """Open the first step that is neither done nor skipped, where somebody comes to the page."""
    if not any(_key(name) in st.session_state for name in STEPS):
        _open_next(STEPS)


@contextmanager
def step(name: str) -> Iterator[bool]:
    """Draw a step around its form, which is drawn inside this where its fold is open: then this gives True."""
    say, last = reader.say(), name == STEPS[-1]
    st.header(f"{STEPS.index(name) + 1} {say(f'in_the_car.{name}')}", anchor=name)
    head = st.container()
    with fields.fold(say(f"in_the_car.{name}_fold"), key=_key(name)) as fold:
        yield fold.open
        done = name in _results()
        if fold.open and not last:
            label = say(f"in_the_car.{'next' if done or name in _skipped() else 'skip'}")
            st.button(label, key=f"{_key(name)}-on", on_click=_go_on, args=(name,))
    adds = show.plain(say(f"in_the_car.{name}_adds"))
    open_yet = say("in_the_car.skipped" if name in _skipped() else "in_the_car.not_done")
    head.markdown(adds if last else _results().get(name) or f"**○ {open_yet}** · {adds}")


def _key(name: str) -> str:
    return f"step-{name}-{session().generation}"


def _skipped() -> list[str]:
    return address.kept(_SKIPPED).split(",")


def _go_on(name: str) -> None:
    """Leave a step for the next one; one that is not done is skipped; for a callback."""
    if name not in (*_results(), *_skipped()):
        address.keep(_SKIPPED, ",".join(each for each in STEPS if each in (*_skipped(), name)))
    fields.turn(_key(name), opened=False)
    _open_next(STEPS[STEPS.index(name) + 1 :])


def _open_next(names: tuple[str, ...]) -> None:
    left_aside = (*_results(), *_skipped())
    fields.turn(_key(next((name for name in names if name not in left_aside), STEPS[-1])), opened=True)


def _results() -> Mapping[str, str]:
    """Return in short what came of each step that is done."""
    diagnosis, say = diagnosis_of(session().good), reader.say()
    record, case = job(), session().good
    complaint = [] if diagnosis.complaint is None else [say.name(diagnosis.complaint.label)]
    fluid = [diagnosis.fluid.name] if case.fluid is not None else []
    fluid += [*record.fault_codes, *filter(None, vars(record.fluid_condition).values())]
    fluid += [] if case.fluid_state is None else [say(f"settings.fluid_{case.fluid_state}")]
    said = {"complaint": [*complaint, *record.complaint.splitlines()[:1]], "fluid": fluid}
    results = {name: " · ".join(f"**{show.plain(each)}**" for each in words) for name, words in said.items()}
    if (check := diagnosis.pressures) is not None:
        count = say("panel.gauge_readings", count=len(check.readings))
        results["gauges"] = f"{_signed(check.verdict, say)} · {count}"
    if (log := diagnosis.log) is not None:
        rows = say("panel.log_rows", rows=log.road_test.rows, seconds=say.number(log.road_test.duration, 0))
        verdict = worst(rule.verdict for rule in log.rules) if log.rules else None
        results["drive"] = f"{_signed(verdict, say)} · {rows}"
    if diagnosis.flows:
        results["jug"] = f"**{say('panel.flows_read', count=len(diagnosis.flows))}**"
    if diagnosis.vacuum:
        verdict = worst(each.verdict for each in diagnosis.vacuum)
        results["vacuum"] = f"{_signed(verdict, say)} · {say('panel.vacuum_read', count=len(diagnosis.vacuum))}"
    return {name: said for name, said in results.items() if said}


def _signed(verdict: Verdict | None, say: Wording) -> str:
    return f"**{say.signed(verdict or Verdict.NOT_MEASURED)}**"


# --- what came of a step


def card(diagnosis: Diagnosis) -> None:
    """Show in a fold what the gauges should show."""
    say = reader.say()
    with fields.fold(say("gauge_card.on_page"), key=f"gauge-card-{session().generation}") as place:
        if place.open:
            show.table(card_table(diagnosis, say))
            for note in card_notes(diagnosis, say):
                st.caption(show.plain(note))


def gauges(diagnosis: Diagnosis) -> None:
    """Show gauge readings beside what is permitted and expected, and what the table hints at."""
    check, say = diagnosis.pressures, reader.say()
    if check is None:
        return
    show.gauge_banner(check)
    show.table(gauge_table(check, say))
    st.caption(say("gauge_page.beside_help"))
    if check.patterns:
        st.markdown(f"**{say('gauge_page.hints')}**")
        for each in check.patterns:
            hint, source = pattern_text(each, diagnosis.controller, say), say.get("pattern_sources", each.source)
            st.markdown(f"- {show.plain(hint)} *({show.plain(source)})*")
        st.caption(say("gauge_page.hints_help"))
    show.messages(check.messages, say("gauge_page.about"))


def closed(diagnosis: Diagnosis, slot: str) -> None:
    """Show what the flows in a jug tell, or a vacuum test."""
    for section in before_opening(diagnosis, reader.say()):
        if section.name == slot:
            show.section(section, slot)
    table = diagnosis.flow_table if slot == "flows" else diagnosis.vacuum_table
    show.messages(() if table is None else table.messages, reader.say()(f"panel.as_{slot}"))


def likely_worn(diagnosis: Diagnosis) -> None:
    """Show what is likely worn by all that was measured so far, and what to measure next."""
    for name, section in evidence_sections(diagnosis, reader.say()).items():
        if name not in ("title", "assumed"):
            st.markdown(f"**{section.title}**")
        with st.expander(section.title) if name == "assumed" else nullcontext():
            show.section(section, f"evidence-{name}")
