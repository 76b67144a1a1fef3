"""Show what a road-test log says by itself: its main pressure, how it was driven, and what to check next."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice

import streamlit as st

from atleak.common.memory import kept_with
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.engine.road_leakage import RoadLeakage
from atleak.report.charts import log_figures as figures
from atleak.report.tables.road_test import circuit_table, instant_table, leakage_curves, place_table, whole
from atleak.report.tables.road_words import (
    check_sentences,
    deciding_sentence,
    log_sentences,
    pressure_sentences,
    test_sentences,
    warm_up_section,
)
from pages.shared import reader, show
from pages.shared.show import plain

_CURSOR = show.component("log_cursor")
TESTS = 6  # most minimum-acceleration tests that have a sentence of their own


def findings(diagnosis: Diagnosis, *, said_above: bool = False) -> None:
    """Show what the log says by itself, and what to check next, without the sentence that is ``said_above``."""
    log, say = diagnosis.log, reader.say()
    if log is None:
        return
    above = deciding_sentence(log, diagnosis.decided_by, say) if said_above else None
    every = kept_with(log, "sentences", say, lambda: _sentences(log, say))
    sentences = [sentence for sentence in every if sentence != above]
    st.markdown("\n".join(f"- {plain(sentence)}" for sentence in sentences))
    if log.permitted is not None:
        with st.expander(say("road_test.places")):
            show.table(place_table(log.permitted, say))
            st.caption(say("road_test.places_help"))
    section = warm_up_section(diagnosis, say)
    if section is not None:
        st.markdown(f"**{plain(section.title)}**")
        show.section(section, "warm_up")
    checks = check_sentences(diagnosis, say)
    if checks:
        st.markdown(f"**{plain(say('findings.check_next'))}**")
        st.markdown("\n".join(f"{number}. {plain(check)}" for number, check in enumerate(checks, start=1)))


def _sentences(log: RoadFindings, say: Wording) -> list[str]:
    left = sum(event.test is not None for event in log.events) - TESTS
    more = [say("road_test.more_said", count=whole(left, say))] if left > 0 else []
    return [*pressure_sentences(log, say), *islice(test_sentences(log, say), TESTS), *more, *log_sentences(log, say)]


def section(diagnosis: Diagnosis) -> None:
    """Show what the log says, and the leakage over it, or why there is none; of a unit not measured as when new."""
    say = reader.say()
    if diagnosis.log is None:
        st.write(say("diagnosis.no_log"))
        return
    if diagnosis.without_sheet:  # its findings are all there is
        st.header(say("road_test.alone"))
    findings(diagnosis, said_above=diagnosis.without_sheet)
    if diagnosis.without_sheet and diagnosis.road is not None:
        st.header(say("road_test.alone_over"))
    if diagnosis.road is not None:
        as_new(diagnosis)
        road, limits = diagnosis.road, diagnosis.limits

        def figure() -> figures.Figure:
            return figures.log_channels(road.road_test, leakage_curves(road, limits, say), say)

        key = (tuple(limits.fixed_bands), show.dark(), say)
        # what is computed over the log stays the same object where nothing changed that it rests on
        under_cursor(kept_with(road.extremes, "chart", key, figure, most=2), "road")
        extremes(diagnosis.road, diagnosis.uncertainty)
        if diagnosis.road.circuit_ranges:
            show.table(circuit_table(diagnosis.road, say))
            st.caption(say("road_test.circuits_help"))
    show.messages(show.remarks(diagnosis)["log"], say("about.log"))


def under_cursor(figure: figures.Figure, key: str, on_span: Callable[[float, float], None] | None = None) -> None:
    """Show a log's figure, and above it what every curve has at a cursor; see `show.chart`."""
    say = reader.say()
    _CURSOR(key="log-cursor", data={"chart": key, "decimal": say.decimal, "words": say.table("log_cursor")})
    show.chart(figure, key, on_span)


def extremes(road: RoadLeakage, uncertainty: UnitUncertainty | None) -> None:
    """Show the extremes of a road test, the sustained ones first, and how they are to be read."""
    say = reader.say()
    show.table(instant_table(road, uncertainty, say))
    sentences = [say("texts.sustained", seconds=say.plain(road.extremes.window))]
    if uncertainty is not None:
        sentences.append(say("road_test.intervals"))
    if road.lower_bound:
        sentences.append(say("texts.lower_bound"))
    st.caption(plain(" ".join(sentences)))


def as_new(diagnosis: Diagnosis) -> None:
    """Say that a leakage is that of a new unit, where nothing was measured."""
    if not diagnosis.judged:
        st.caption(plain(reader.say()("findings.unmeasured")))
