"""Show a table of fields for gauge readings. What is typed lives in the job's own file, sign for sign."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import ENGINE_SPEED, TEMPERATURE, read_number
from atleak.common.errors import PressureTableError
from atleak.common.units import unit, unit_names
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_check import PressureCheck
from atleak.job.case import SourceFile
from atleak.measurements.gauge_readings import Engine, GaugeCell, ranges_of, tap_name, taps_of
from atleak.readers.gauges.gauge_table import asked_pressure, read_pressure_table
from atleak.readers.gauges.typed_gauges import TYPED_GAUGES_FILE, TypedGauges, typed_gauges
from atleak.report.tables.gauges import card_notes, card_table, pattern_text
from pages.shared import fields, reader, show
from pages.shared.cases import PageCase, controller_of
from pages.shared.state import put_file, session

UNITS = [name for name in unit_names("pressure") if name in ("kPa", "bar", "psi", "MPa")]
_BESIDE = {"temperature": TEMPERATURE, "fast_idle": ENGINE_SPEED}  # fields beside the readings


def pending(case: PageCase) -> SourceFile | None:
    """Return the file to show: the one refused last, else that of the job."""
    refused = session().refused.get("pressures")
    return refused.file if refused is not None else case.pressures


def draw(case: PageCase, controller: Controller) -> None:
    """Draw the fields of one tap, or say that the readings come from a file."""
    file, say = pending(case), reader.say()
    typed = _typed()
    if file is not None and typed_gauges(file.content) is None:
        st.caption(say("gauge_page.read_from", file=show.plain(file.name)))
        return
    owner, faults = f"gauges{session().generation}-{controller.sha256[:12]}", _faults(typed)
    both = (typed, _counted())

    def text_field(place: DeltaGenerator, part: GaugeCell | str, label: str, shown: str) -> None:
        text, last = (each.cells.get(part, "") if isinstance(part, GaugeCell) else getattr(each, part) for each in both)
        key = f"{owner}-{part}"
        with place:
            st.text_input(f"{label} [{shown}]", text, key=key, on_change=_put, args=(part, key))
            with st.container():
                if part in faults:
                    asked = (
                        asked_pressure(unit(typed.unit, "pressure")) if isinstance(part, GaugeCell) else _BESIDE[part]
                    )
                    fields.fault(read_number(text, asked).doubt, asked.name, f"{last} {shown}" if last else "")

    places = st.columns(4)
    tap = places[0].selectbox(
        say("gauge_page.gauge_at"), taps_of(controller), format_func=partial(_tap, controller), key=f"{owner}-tap"
    )
    key, first = f"{owner}-unit", UNITS.index(typed.unit) if typed.unit in UNITS else 0
    places[1].selectbox(say("gauge_page.unit"), UNITS, first, key=key, on_change=_put, args=("unit", key))
    for place, name, shown in zip(places[2:], _BESIDE, ("°C", say.unit("engine_speed")), strict=True):
        text_field(place, name, say(f"gauge_page.{name}"), shown)
    for selected in ranges_of(controller):
        for place, engine in zip(st.columns(3), Engine, strict=True):
            label = say("gauge_page.cell", range=selected, engine=say.sentence(engine.label))
            text_field(place, GaugeCell(selected, engine, tap), label, typed.unit)


def card(diagnosis: Diagnosis) -> None:
    """Show in a fold what the gauges should show."""
    say = reader.say()
    place = fields.fold(say("gauge_card.on_page"), key=f"gauge-card-{session().generation}")
    if place.open:
        with place:
            show.table(card_table(diagnosis, say))
            for note in card_notes(diagnosis, say):
                st.caption(show.plain(note))


def result(diagnosis: Diagnosis, check: PressureCheck) -> None:
    """Show gauge readings beside what is permitted and expected, and what the table hints at."""
    say = reader.say()
    show.gauge_banner(check)
    show.gauges(check)
    st.caption(say("gauge_page.beside_help"))
    if check.patterns:
        st.markdown(f"**{say('gauge_page.hints')}**")
        for each in check.patterns:
            hint, source = pattern_text(each, diagnosis.controller, say), say.get("pattern_sources", each.source)
            st.markdown(f"- {show.plain(hint)} *({show.plain(source)})*")
        st.caption(say("gauge_page.hints_help"))
    show.messages(check.messages, say("gauge_page.about"))


def _tap(controller: Controller, tap: str) -> str:
    return tap_name(controller, tap)


def _counted() -> TypedGauges:
    """Return what of the typed readings is in the job; without any, none yet in the reader's unit."""
    file = pending(session().case)
    return (None if file is None else typed_gauges(file.content)) or TypedGauges(unit=reader.say().unit("pressure"))


def _in_job() -> tuple[int, str | None]:
    """Return what tells the job's gauge readings from others."""
    file = pending(session().case)
    return session().generation, None if file is None else file.sha256


def _typed() -> TypedGauges:
    """Return what was typed so far, with what does not count."""
    of, typed = st.session_state.get("typed-gauges", (None, None))
    return typed if typed is not None and of == _in_job() else _counted()


def _faults(typed: TypedGauges) -> set[GaugeCell | str]:
    """Return the fields in which something stands that cannot be read, those beside the readings even without one."""
    controller = controller_of(session().case)
    judged = replace(typed, cells={GaugeCell(ranges_of(controller)[0], Engine.FAST_IDLE): "1", **typed.cells})
    try:
        read_pressure_table(judged.written() or b"", controller, name=TYPED_GAUGES_FILE)
    except PressureTableError as error:
        parts = (judged.part_at(each.place) for each in (error, *error.others))
        return {part for part in parts if part is not None}
    return set()


def _put(part: GaugeCell | str, key: str) -> None:
    """Put what was typed into the job; what cannot be read waits at its field, and the value before it stays."""
    before, text = _typed(), st.session_state[key].strip()
    typed = before.with_cell(part, text) if isinstance(part, GaugeCell) else replace(before, **{part: text})
    counting, last = typed, _counted()
    for fault in _faults(typed):
        if isinstance(fault, GaugeCell):
            counting = counting.with_cell(fault, last.cells.get(fault, "") if last.unit == typed.unit else "")
        else:
            counting = replace(counting, **{fault: getattr(last, fault)})
    content = counting.written()
    if content is None:
        session().refused.pop("pressures", None)
    if content is not None or session().case.pressures is not None:
        put_file("pressures", None if content is None else SourceFile(TYPED_GAUGES_FILE, content))
    st.session_state["typed-gauges"] = (_in_job(), typed)
