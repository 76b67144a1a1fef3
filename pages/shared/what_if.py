"""Try a unit otherwise, beside the job, and over temperature and wear; what is tried never reaches the job."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, get_args

import numpy as np
import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from atleak.analysis.what_if import Axis, Map, WhatIf, map_over, temperatures_to_try, tried, wears_to_try
from atleak.catalogue.fluid import FluidState
from atleak.catalogue.written_numbers import ENGINE_SPEED, TEMPERATURE, AskedNumber, decimal_number
from atleak.common.errors import AtleakError
from atleak.common.units import KPA, PERCENT, RPM, gear_name
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.operation import LINE
from atleak.engine.profile import UNKNOWN
from atleak.report.charts.condition_figures import MapPlace, pressure_map, share_map
from atleak.report.tables.what_if import tried_circuit_table, tried_total_table, tried_words
from pages.shared import address, fields, reader, show
from pages.shared.cases import PageCase, catalogue_entry, catalogue_names, shown_name
from pages.shared.state import session

_MOST_WEAR, _MOST_GROWTH = 5.0, 200  # that can be tried: times as measured, and %
_CORNER = 0.03  # of a map: what falls there alone is said, as a picture of it would be empty
_POSITIONS: tuple[float | str | None, ...] = (None, 0.0, 0.25, 0.5, 0.75, 1.0, UNKNOWN)
_AS_IN_JOB: dict[str, Any] = {
    "point": None, "temperature": None, "speed": None, "gear": None, "wear": 1.0, "growth": 0, "fluid": None,
    "state": None, "position": None,
}  # fmt: skip
_RESETS = "what-if-resets"  # how often what is tried was reset
_ADDRESS = "tried"  # what is tried, in the address: ``wear:2.0;gear:3``
_LABELS = {"temperature": "temperature", "speed": "engine_speed"}
_NUMBERS: dict[str, tuple[type[float] | type[int], tuple[float, float]]] = {  # of an address, each with its range
    "temperature": (float, TEMPERATURE.limits),
    "speed": (float, ENGINE_SPEED.limits),
    "gear": (int, (-9, 99)),
    "wear": (float, (0.0, _MOST_WEAR)),
    "growth": (int, (0.0, _MOST_GROWTH)),
    "position": (float, (-math.inf, math.inf)),
}


@st.fragment
@show.faults()
def draw(case: PageCase, diagnosis: Diagnosis) -> None:
    """Show the controls and what follows from them; a change runs this alone, as it touches nothing of the job."""
    settings = _settings(case, diagnosis)
    try:
        _beside(diagnosis, settings)
    except AtleakError as error:
        st.error(show.plain(error))
    try:
        _maps(diagnosis, settings)
    except AtleakError:
        return  # said above


def _beside(diagnosis: Diagnosis, settings: WhatIf) -> None:
    """Show total share, pressures and reserve as they are tried, beside those of the job."""
    say, here = reader.say(), tried(diagnosis, settings)
    now = here.projection
    st.header(say("what_if.beside"))
    st.write(say("what_if.same") if now == here.job else say("what_if.changed", condition=tried_words(here, say)))
    share, line, reserve = st.columns(3)
    known = math.isfinite(now.share)
    share.metric(say("what_if.share"), say.percent(now.share) if known else say("what_if.no_flow"))
    line.metric(say("what_if.line"), say.quantity(now.main_pressure_held * KPA, "pressure"))
    reserve.metric(say("what_if.reserve"), say.number(now.reserve, 2))
    show.table(tried_total_table(diagnosis, here, say))
    st.caption(say("what_if.judged") if diagnosis.judged else say("what_if.not_judged"))
    circuits = tried_circuit_table(diagnosis, here, say)
    with st.container():
        if circuits.rows:
            st.markdown(f"**{say('what_if.circuits')}**")
            show.table(circuits)
        else:
            st.caption(say("what_if.no_circuits"))
    show.messages(here.messages, say("what_if.messages"))


def _maps(diagnosis: Diagnosis, settings: WhatIf) -> None:
    """Show share and pressure held over temperature and wear, with the job and what is tried marked."""
    say = reader.say()
    over = map_over(diagnosis, settings, temperatures_to_try(diagnosis, settings), wears_to_try(diagnosis, settings))
    job = settings.base(diagnosis).temperature, 1.0 if over.axis is Axis.WEAR else 0.0
    now = settings.condition(diagnosis).temperature, getattr(settings, over.axis)
    st.header(say("what_if.map_share"))
    if over.axis is Axis.GROWTH:
        st.caption(say("what_if.map_growth"))
    show.chart(share_map(over, job, now, say), "what-if-share")
    st.caption(say("what_if.map_about", count=len(over.temperatures)))
    st.header(say("what_if.map_pressure"))
    _pressure(diagnosis, over, job, now)


def _pressure(diagnosis: Diagnosis, over: Map, job: MapPlace, now: MapPlace) -> None:
    say = reader.say()
    held = [circuit for circuit in diagnosis.controller.circuits if circuit.id in over.pressures]
    names = {LINE: say("what_if.line_name"), **{circuit.id: say.name(circuit.name) for circuit in held}}
    name = LINE
    if len(names) > 1:
        name = fields.one_of(say("what_if.pressure_of"), names, "what-if-map")
    values = over.pressures[name]
    low, high = (say.quantity(float(end(values)) * KPA, "pressure") for end in (np.nanmin, np.nanmax))
    with st.container():
        if np.nanmean(values < 0.99 * np.nanmax(values)) < _CORNER:
            st.write(
                say("what_if.holds_everywhere", pressure=high)
                if low == high
                else say("what_if.holds_but", pressure=high, low=low)
            )
        else:
            show.chart(pressure_map(over, name, job, now, say), f"what-if-{name}")


# --- what is tried


def read_tried(written: str) -> dict[str, Any]:
    """Return what an address says is tried; what cannot be read, or is out of range, is as in the job."""
    tried: dict[str, Any] = {}
    for name, _, text in (part.partition(":") for part in written.split(";")):
        value: Any = text
        if name in _NUMBERS and (name, text) != ("position", UNKNOWN):
            number, (kind, (low, high)) = decimal_number(text), _NUMBERS[name]
            if number is None or not low <= number <= high:
                continue
            value = kind(number)
        if name in _AS_IN_JOB and text:
            tried[name] = value
    return tried


def _tried() -> dict[str, Any]:
    """Return what is tried; temperature [°C] and speed [1/min] only where they are not those of the operating point."""
    return _AS_IN_JOB | read_tried(address.kept(_ADDRESS))


def _keep(chosen: Mapping[str, Any]) -> None:
    """Keep in the address what differs from the job."""
    differing = (f"{name}:{chosen[name]}" for name, own in _AS_IN_JOB.items() if chosen[name] != own)
    address.keep(_ADDRESS, ";".join(differing))


def _reset() -> None:
    st.session_state[_RESETS] = st.session_state.get(_RESETS, 0) + 1
    _keep(_AS_IN_JOB)


def _settings(case: PageCase, diagnosis: Diagnosis) -> WhatIf:
    """Show the controls and return what is tried."""
    say, chosen = reader.say(), _tried()
    first, second, third = st.columns(4), st.columns(2), st.columns(3)

    def number(place: DeltaGenerator, name: str, asked: AskedNumber, own: float) -> float | None:
        """Ask for a number; None where it is ``own``, that of the operating point."""
        start = own if chosen[name] is None else chosen[name]
        with place:
            value = fields.number(
                say(f"what_if.{_LABELS[name]}"), asked, start, key=f"{_key('at', diagnosis)}-{point}-{name}"
            )
        chosen[name] = None if value == own else value
        return None if value == own else value

    def select(place: DeltaGenerator, name: str, labels: dict[Any, str], otherwise: Any = None) -> Any:
        """Ask for a choice; ``otherwise`` is what the job has."""
        options, key = list(labels), f"{_key(name, diagnosis)}-{otherwise}"
        if chosen[name] not in options:  # of an address that was written for another unit, or by hand
            chosen[name] = _AS_IN_JOB[name]
        return place.selectbox(
            say(f"what_if.{name}"), options, options.index(otherwise if chosen[name] is None else chosen[name]),
            labels.__getitem__, key, say.table("what_if").get(f"{name}_help"), on_change=_taken, args=(name, key),
        )  # fmt: skip

    def slide(place: DeltaGenerator, name: str, high: Any, step: Any) -> Any:
        key = _key(name, diagnosis)
        return place.slider(
            say(f"what_if.{name}"), type(high)(0), high, chosen[name], step, "localized",
            key=key, help=say(f"what_if.{name}_help"), on_change=_taken, args=(name, key),
        )  # fmt: skip

    points = {each.condition.name: each.condition for each in diagnosis.presented}
    stated = diagnosis.projection.condition
    labels = {name: say.condition(point) for name, point in points.items()}
    labels[stated.name] = say("what_if.stated", label=labels[stated.name])
    point = select(first[0], "point", labels, stated.name)
    base = points[point]
    temperature = number(first[1], "temperature", TEMPERATURE, base.temperature)
    speed = number(first[2], "speed", ENGINE_SPEED, round(base.engine_speed * RPM, 6))
    gears = dict.fromkeys([*diagnosis.controller.gears, base.gear])
    gear = select(first[3], "gear", {each: gear_name(each) for each in gears}, base.gear)
    wear = slide(second[0], "wear", _MOST_WEAR, 0.05)
    growth = slide(second[1], "growth", _MOST_GROWTH, 5)
    fluids = {name: shown_name(entry, say) for name, entry in catalogue_names("fluid").items()}
    of_job = say("what_if.fluid_job", name=say.name(diagnosis.fluid.name))
    fluid = select(third[0], "fluid", {None: of_job, **fluids})
    states = {state: say(f"what_if.{state}") for state in get_args(FluidState)}
    of_job = say("what_if.state_job", state=states[diagnosis.fluid.state])
    state = select(third[1], "state", {None: of_job, **states})
    position = select(third[2], "position", _positions(diagnosis))
    st.button(say("what_if.reset"), on_click=_reset, key="what-if-reset")
    _keep(chosen)
    return WhatIf(
        point=point,
        temperature_c=base.temperature if temperature is None else temperature,
        engine_speed_rpm=speed,
        gear=gear,
        wear=wear,
        growth=growth / PERCENT,
        fluid=catalogue_entry("fluid", fluid or case.fluid or diagnosis.controller.usual_fluid),
        fluid_state=state,
        eccentricity=position,
    )


def _key(name: str, diagnosis: Diagnosis) -> str:
    """Return a widget's key: another job and a reset give fresh ones."""
    of = diagnosis.controller.sha256[:12]
    return f"what-if-{name}-{session().generation}-{of}-{st.session_state.get(_RESETS, 0)}"


def _taken(name: str, key: str) -> None:
    chosen = _tried() | {name: st.session_state[key]}
    if name == "point":
        chosen |= {"temperature": None, "speed": None, "gear": None}  # begin with those of the point
    _keep(chosen)


def _positions(diagnosis: Diagnosis) -> dict[float | str | None, str]:
    say = reader.say()
    words = {0.0: "centred", 1.0: "touching", UNKNOWN: "unknown"}

    def named(position: Any) -> str:
        return say(f"what_if.position_{words[position]}") if position in words else say.plain(position)

    own = say("what_if.position_job", position=named(diagnosis.profile.eccentricity))
    return {each: own if each is None else named(each) for each in _POSITIONS}
