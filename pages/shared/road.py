"""Show what a road-test log says by itself: its main pressure, how it was driven, and what to check next."""

from __future__ import annotations

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.figures import diagnosis_figures as figures
from atleak.views.road_words import check_sentences, log_sentences, pressure_sentences, test_sentences
from atleak.views.window import place_rows
from atleak.wording import wording
from pages.shared import show
from pages.shared.show import plain


def findings(diagnosis: Diagnosis) -> None:
    """Show what the log says by itself, and what to check next."""
    log, say = diagnosis.log, wording("en")
    if log is None:
        return
    said = (*pressure_sentences(log, say), *test_sentences(log, say), *log_sentences(log, say))
    st.markdown("\n".join(f"- {plain(sentence)}" for sentence in said))
    if log.permitted is not None:
        with st.expander("Main pressure in each gear and state"):
            show.table(place_rows(log.permitted), number=show.rounded)
            st.caption("Pressure and limit where, for a second on end, it came nearest to the limit or fell below it.")
    checks = check_sentences(log, diagnosis.limits, say)
    if checks:
        st.markdown(f"**{plain(say('findings.check_next'))}**")
        st.markdown("\n".join(f"{number}. {plain(check)}" for number, check in enumerate(checks, start=1)))


def alone(diagnosis: Diagnosis) -> None:
    """Show a road test without a measuring sheet: its findings are all there is."""
    st.subheader("What the road test says")
    findings(diagnosis)
    if diagnosis.road is not None:
        st.subheader("Over the road test")
    leakage(diagnosis)


def leakage(diagnosis: Diagnosis) -> None:
    """Show the leakage over the log, or why there is none; of a unit that was not measured as that of a new one."""
    if diagnosis.road is not None:
        if not diagnosis.judged:
            st.caption(plain(wording("en")("findings.unmeasured")))
        show.chart(figures.road_leakage(diagnosis.road, diagnosis.limits), "road")
        show.extremes(diagnosis.road, diagnosis.uncertainty)
    show.log_messages(diagnosis)
