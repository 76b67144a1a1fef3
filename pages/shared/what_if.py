"""Show a unit as it is tried: beside the job, over temperature and wear, and beside the source study's variants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import streamlit as st

from atleak.analysis.what_if import (
    Axis,
    Map,
    StudyTrial,
    Tried,
    WhatIf,
    is_the_study_s,
    like_the_study,
    map_over,
    temperatures_to_try,
    tried,
    wears_to_try,
)
from atleak.common.errors import AtleakError
from atleak.common.units import KPA
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.operation import LINE
from atleak.report.charts.condition_figures import MapPlace, pressure_map, share_map
from atleak.report.tables.what_if import study_table, tried_circuit_table, tried_total_table, tried_words
from pages.shared import reader, show, what_if_form
from pages.shared.cases import PageCase, result_key


@st.fragment
@show.faults()
def draw(case: PageCase, diagnosis: Diagnosis) -> None:
    """Show the controls and what follows from them; a change runs this alone, as it touches nothing of the job."""
    settings = what_if_form.draw(case, diagnosis)
    try:
        _beside(diagnosis, settings)
    except AtleakError as error:
        st.error(show.plain(error))
    try:
        _maps(diagnosis, settings)
        _study(case, diagnosis, settings)
    except AtleakError:
        return  # said above


def _beside(diagnosis: Diagnosis, settings: WhatIf) -> None:
    """Show total share, pressures and reserve as they are tried, beside those of the job."""
    say, here = reader.say(), tried(diagnosis, settings)
    now = here.projection
    st.subheader(say("what_if.beside"))
    st.write(say("what_if.same") if now == here.job else say("what_if.changed", condition=tried_words(here, say)))
    share, line, reserve = st.columns(3)
    known = math.isfinite(now.share)
    share.metric(say("what_if.share"), say.percent(now.share) if known else say("what_if.no_flow"))
    line.metric(say("what_if.line"), say.quantity(now.main_pressure_held * KPA, "pressure"))
    reserve.metric(say("what_if.reserve"), say.number(now.reserve, 2))
    show.table(tried_total_table(diagnosis, here, say))
    st.caption(say("what_if.judged") if diagnosis.judged else say("what_if.not_judged"))
    _circuits(diagnosis, here)
    show.messages(here.messages, say("what_if.messages"))


def _circuits(diagnosis: Diagnosis, here: Tried) -> None:
    say = reader.say()
    circuits = tried_circuit_table(diagnosis, here, say)
    with st.container():
        if circuits.rows:
            st.markdown(f"**{say('what_if.circuits')}**")
            show.table(circuits)
        else:
            st.caption(say("what_if.no_circuits"))


def _maps(diagnosis: Diagnosis, settings: WhatIf) -> None:
    """Show share and pressure held over temperature and wear, with the job and what is tried marked."""
    say = reader.say()
    over = map_over(diagnosis, settings, temperatures_to_try(diagnosis, settings), wears_to_try(diagnosis, settings))
    job = settings.base(diagnosis).temperature, 1.0 if over.axis is Axis.WEAR else 0.0
    now = settings.condition(diagnosis).temperature, getattr(settings, over.axis)
    st.subheader(say("what_if.map_share"))
    if over.axis is Axis.GROWTH:
        st.caption(say("what_if.map_growth"))
    show.chart(share_map(over, job, now, say), "what-if-share")
    st.caption(say("what_if.map_about", count=len(over.temperatures)))
    st.subheader(say("what_if.map_pressure"))
    _pressure(diagnosis, over, job, now)


def _pressure(diagnosis: Diagnosis, over: Map, job: MapPlace, now: MapPlace) -> None:
    say = reader.say()
    held = [circuit for circuit in diagnosis.controller.circuits if circuit.id in over.pressures]
    names = {LINE: say("what_if.line_name"), **{circuit.id: say.name(circuit.name) for circuit in held}}
    name = LINE
    if len(names) > 1:
        name = st.selectbox(say("what_if.pressure_of"), list(names), format_func=names.__getitem__, key="what-if-map")
    values = over.pressures[name]
    low, high = np.nanmin(values), np.nanmax(values)
    with st.container():
        if high - low < 1.0:
            st.write(say("what_if.holds_everywhere", pressure=say.quantity(float(high) * KPA, "pressure")))
        else:
            show.chart(pressure_map(over, name, job, now, say), f"what-if-{name}")


def _study(case: PageCase, diagnosis: Diagnosis, settings: WhatIf) -> None:
    """Show the unit tried as each of the source study's variants, beside what the article prints."""
    say = reader.say()
    st.subheader(say("what_if.study"))
    alike = replace(settings, temperature=None, wear=1.0, growth=0.0, fluid_state=None)
    fluid = "" if settings.fluid is None else settings.fluid.origin.sha256
    trials = _trials(f"{result_key(case)} {replace(alike, fluid=None)} {fluid}", diagnosis, alike)
    show.table(study_table(trials, say))
    st.caption(say("what_if.study_about"))
    st.caption(say("what_if.study_own" if is_the_study_s(diagnosis) else "what_if.study_other"))
    for trial in trials:
        if trial.here is None:
            st.caption(say("what_if.why_not", variant=trial.variant.name, why=show.plain(say.sentence(trial.why_not))))


@st.cache_resource(max_entries=16, show_spinner=False)
def _trials(key: str, _diagnosis: Diagnosis, _settings: WhatIf) -> Sequence[StudyTrial]:
    return like_the_study(_diagnosis, _settings)
