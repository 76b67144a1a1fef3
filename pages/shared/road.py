"""Show what a road-test log says by itself: its main pressure, how it was driven, and what to check next."""

from __future__ import annotations

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.figures import diagnosis_figures as figures
from atleak.views.road_words import (
    check_sentences,
    deciding_sentence,
    log_sentences,
    pressure_sentences,
    test_sentences,
)
from atleak.views.window import circuit_rows, place_rows
from atleak.wording import wording
from pages.shared import show
from pages.shared.show import plain


def findings(diagnosis: Diagnosis, *, said_above: bool = False) -> None:
    """Show what the log says by itself, and what to check next, without the sentence that is ``said_above``."""
    log, say = diagnosis.log, wording("en")
    if log is None:
        return
    above = deciding_sentence(log, diagnosis.decided_by, say) if said_above else None
    every = (*pressure_sentences(log, say), *test_sentences(log, say), *log_sentences(log, say))
    said = [sentence for sentence in every if sentence != above]
    st.markdown("\n".join(f"- {plain(sentence)}" for sentence in said))
    if log.permitted is not None:
        with st.expander("Main pressure in each gear and state"):
            show.table(place_rows(log.permitted), number=show.rounded)
            st.caption("Pressure and limit where, for a second on end, it came nearest to the limit or fell below it.")
    checks = check_sentences(diagnosis, say)
    if checks:
        st.markdown(f"**{plain(say('findings.check_next'))}**")
        st.markdown("\n".join(f"{number}. {plain(check)}" for number, check in enumerate(checks, start=1)))


def alone(diagnosis: Diagnosis) -> None:
    """Show a road test without a measuring sheet: its findings are all there is."""
    st.subheader("What the road test says")
    findings(diagnosis, said_above=True)
    if diagnosis.road is not None:
        st.subheader("Over the road test")
    leakage(diagnosis)


def leakage(diagnosis: Diagnosis) -> None:
    """Show the leakage over the log, or why there is none; of a unit that was not measured as that of a new one."""
    if diagnosis.road is not None:
        as_new(diagnosis)
        show.chart(figures.road_leakage(diagnosis.road, diagnosis.limits), "road")
        show.extremes(diagnosis.road, diagnosis.uncertainty)
        if diagnosis.road.circuit_ranges:
            show.table(circuit_rows(diagnosis.road), number=show.rounded)
            st.caption("What each circuit holds at the measured main pressure, computed, while it is applied.")
    show.log_messages(diagnosis)


def as_new(diagnosis: Diagnosis) -> None:
    """Say that a leakage is that of a new unit, where nothing was measured."""
    if not diagnosis.judged:
        st.caption(plain(wording("en")("findings.unmeasured")))
