"""Show a table of fields for gauge readings. What is typed lives in the job's own file, sign for sign."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.intake.gauge_table.typed import TYPED_FILE, TypedGauges, typed_gauges
from atleak.intake.units import unit_names
from atleak.job.case import SourceFile
from atleak.pressure_table import Cell, Engine, ranges_of, tap_name, taps_of
from pages.shared import reader, show
from pages.shared.cases import PageCase
from pages.shared.state import put_file, session

UNITS = [name for name in unit_names("pressure") if name in ("kPa", "bar", "psi", "MPa")]


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
    owner = f"gauges{session().generation}-{controller.sha256[:12]}"
    places = st.columns(4)
    tap = places[0].selectbox(
        say("gauge_page.gauge_at"), taps_of(controller), format_func=partial(_tap, controller), key=f"{owner}-tap"
    )
    unit, first = f"{owner}-unit", UNITS.index(typed.unit) if typed.unit in UNITS else 0
    places[1].selectbox(say("gauge_page.unit"), UNITS, first, key=unit, on_change=_put, args=("unit", unit))
    for place, name, label in (
        (places[2], "temperature", f"{say('gauge_page.temperature')} [°C]"),
        (places[3], "fast_idle", f"{say('gauge_page.fast_idle')} [{say.unit('engine_speed')}]"),
    ):
        key = f"{owner}-{name}"
        place.text_input(label, getattr(typed, name), key=key, on_change=_put, args=(name, key))
    for selected in ranges_of(controller):
        for place, engine in zip(st.columns(3), Engine, strict=True):
            cell, key = Cell(selected, engine, tap), f"{owner}-{tap}-{selected}-{engine}"
            label = say("gauge_page.cell", range=selected, engine=say.sentence(engine.label))
            place.text_input(
                f"{label} [{typed.unit}]", typed.cells.get(cell, ""), key=key, on_change=_put_cell, args=(cell, key)
            )


def _tap(controller: Controller, tap: str) -> str:
    return tap_name(controller, tap)


def _typed() -> TypedGauges:
    """Return what was typed so far, with what was chosen before the first reading."""
    file = pending(session().case)
    typed = None if file is None else typed_gauges(file.content)
    return typed or st.session_state.get(_before(), TypedGauges())


def _before() -> str:
    """Return the key under which unit, temperature and speed are kept while no reading is typed."""
    return f"typed-gauges-{session().generation}"


def _put_cell(cell: Cell, key: str) -> None:
    _keep(_typed().with_cell(cell, st.session_state[key]))


def _put(name: str, key: str) -> None:
    _keep(replace(_typed(), **{name: st.session_state[key].strip()}))


def _keep(typed: TypedGauges) -> None:
    """Put what was typed into the job; a job of which the last reading was taken away has no such file."""
    st.session_state[_before()] = replace(typed, cells={})
    content = typed.written()
    if content is None:
        session().refused.pop("pressures", None)
    if content is not None or session().case.pressures is not None:
        put_file("pressures", None if content is None else SourceFile(TYPED_FILE, content))
