"""Show what a road-test log says by itself: its main pressure, how it was driven, and what to check next."""

from __future__ import annotations

from itertools import islice

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.engine.road_leakage import RoadLeakage
from atleak.figures import log_figures as figures
from atleak.keeping import kept_with
from atleak.road_findings import RoadFindings
from atleak.uncertainty import UnitUncertainty
from atleak.views.log_rows import circuit_rows, place_rows, whole
from atleak.views.road_instants import instant_record, road_instants
from atleak.views.road_words import (
    check_sentences,
    deciding_sentence,
    log_sentences,
    pressure_sentences,
    test_sentences,
)
from atleak.views.table import Column
from atleak.wording import Wording
from pages.shared import reader, show
from pages.shared.show import plain

TESTS = 6  # most minimum-acceleration tests that have a sentence of their own
_PLACES = (
    Column("place_gear"),
    Column("place_state"),
    Column("place_judged", "time", 1),
    Column("place_lowest", "pressure", 0),
    Column("place_limit", "pressure", 0),
    Column("place_below_by", "percent", 1),
    Column("place_below", "time", 1),
    Column("place_above", "time", 1),
    Column("place_source"),
)
_CIRCUITS = (
    Column("circuit"),
    Column("circuit_lowest", "pressure", 0),
    Column("circuit_at_main", "pressure", 0),
    Column("circuit_at", "time", 1),
    Column("circuit_mean", "pressure", 0),
)

_INSTANTS = {  # by the name in the record
    "time_s": Column("instant_time", "time", 2),
    "leakage_dm3_min": Column("instant_leakage", "flow", 2),
    "leakage_low_dm3_min": Column("instant_leakage_low", "flow", 2),
    "leakage_high_dm3_min": Column("instant_leakage_high", "flow", 2),
    "pump_capacity_dm3_min": Column("instant_pump", "flow", 1),
    "share_percent": Column("instant_share", "percent", 2),
    "share_low_percent": Column("instant_share_low", "percent", 1),
    "share_high_percent": Column("instant_share_high", "percent", 1),
}


def findings(diagnosis: Diagnosis, *, said_above: bool = False) -> None:
    """Show what the log says by itself, and what to check next, without the sentence that is ``said_above``."""
    log, say = diagnosis.log, reader.say()
    if log is None:
        return
    above = deciding_sentence(log, diagnosis.decided_by, say) if said_above else None
    every = kept_with(log, "sentences", say, lambda: _sentences(log, say))
    said = [sentence for sentence in every if sentence != above]
    st.markdown("\n".join(f"- {plain(sentence)}" for sentence in said))
    if log.permitted is not None:
        with st.expander(say("road_test.places")):
            show.rows_table(place_rows(log.permitted, say), _PLACES)
            st.caption(say("road_test.places_help"))
    checks = check_sentences(diagnosis, say)
    if checks:
        st.markdown(f"**{plain(say('findings.check_next'))}**")
        st.markdown("\n".join(f"{number}. {plain(check)}" for number, check in enumerate(checks, start=1)))


def _sentences(log: RoadFindings, say: Wording) -> list[str]:
    left = sum(event.test is not None for event in log.events) - TESTS
    more = [say("road_test.more_said", count=whole(left, say))] if left > 0 else []
    return [*pressure_sentences(log, say), *islice(test_sentences(log, say), TESTS), *more, *log_sentences(log, say)]


def alone(diagnosis: Diagnosis) -> None:
    """Show a road test without a measuring sheet: its findings are all there is."""
    st.subheader(reader.say()("road_test.alone"))
    findings(diagnosis, said_above=True)
    if diagnosis.road is not None:
        st.subheader(reader.say()("road_test.alone_over"))
    leakage(diagnosis)


def leakage(diagnosis: Diagnosis) -> None:
    """Show the leakage over the log, or why there is none; of a unit that was not measured as that of a new one."""
    if diagnosis.road is not None:
        as_new(diagnosis)
        leakage_chart(diagnosis.road, diagnosis)
        extremes(diagnosis.road, diagnosis.uncertainty)
        if diagnosis.road.circuit_ranges:
            show.rows_table(circuit_rows(diagnosis.road), _CIRCUITS)
            st.caption(reader.say()("road_test.circuits_help"))
    show.log_messages(diagnosis)


def leakage_chart(road: RoadLeakage, diagnosis: Diagnosis) -> None:
    """Draw leakage, pump flow and share over a log, or over a part of it."""
    limits, say = diagnosis.limits, reader.say()
    key = (tuple(limits.fixed_bands), show.dark(), say)
    # what is computed over the log stays the same object where nothing changed that it rests on
    show.chart(kept_with(road.extremes, "chart", key, lambda: figures.road_leakage(road, limits, say), most=2), "road")


def extremes(road: RoadLeakage, uncertainty: UnitUncertainty | None) -> None:
    """Show the extremes of a road test, the sustained ones first, and how they are to be read."""
    say, rows = reader.say(), road_instants(road)
    records = [instant_record(row.instant, uncertainty) for row in rows]
    shown = [(name, column) for name, column in _INSTANTS.items() if any(each[name] is not None for each in records)]
    cells = [
        {"instant": row.label(say), **{column.key: record[name] for name, column in shown}}
        for row, record in zip(rows, records, strict=True)
    ]
    show.rows_table(cells, [Column("instant"), *(column for _, column in shown)])
    said = [say("texts.sustained", seconds=say.plain(road.extremes.window))]
    if uncertainty is not None:
        said.append(say("road_test.intervals"))
    if road.lower_bound:
        said.append(say("texts.lower_bound"))
    st.caption(plain(" ".join(said)))


def as_new(diagnosis: Diagnosis) -> None:
    """Say that a leakage is that of a new unit, where nothing was measured."""
    if not diagnosis.judged:
        st.caption(plain(reader.say()("findings.unmeasured")))
