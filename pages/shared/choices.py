"""Ask for what a job takes from the catalogue, and how the engine computes.

Each choice is taken as soon as it is made, before anything is drawn: the result above it on the page holds it already.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from functools import partial
from typing import Any, get_args, get_type_hints

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import written_toml
from atleak.catalogue.entries import id_from_name, write_own
from atleak.catalogue.fluid import USED_THINNER, FluidFile, FluidState, checked_fluid, tables_of_two_points
from atleak.catalogue.written_numbers import AskedNumber
from atleak.common.errors import AtleakError, InputError
from atleak.common.sentences import Sentence
from atleak.engine.profile import PROFILES, UNKNOWN, Profile
from atleak.job.case import SLOTS, CaseChoice, SourceFile
from pages.shared import fields, reader, show
from pages.shared.cases import catalogue_names, controller_of, entry_doubts, shown_name
from pages.shared.state import choose, pick, session

OPTIONS = ("diameter", "viscosity", "pump_draw", "pump_efficiency", "entry_loss", "form")


def catalogue_entry(name: str) -> None:
    """Ask which entry of the catalogue the job takes: a shipped one, one of the user's own, or the file given last."""
    say, now, slot = reader.say(), session(), SLOTS[name]
    current = getattr(now.case, name)
    known = catalogue_names(name)
    options: list[CaseChoice | None] = [None] if name == "fluid" else []
    options += [each for each, entry in known.items() if slot.part is None or slot.part in entry.measures]
    given = current if isinstance(current, SourceFile) else now.own.get(name)
    options += [given] if given is not None else [] if current in options else [current]

    def words(option: CaseChoice | None) -> str:
        if option is None:
            usual, required = controller().usual_fluid, controller().fluid
            shown = shown_name(known[usual], say) if usual in known else usual
            if required is None:
                return say("settings.fluid_not_named", name=shown)
            if required.viscosity_100 is None:
                return say("settings.fluid_of_unit", name=shown)
            return f"{shown}; {say('fluid_states.assumed', required=say.name(required.required))}"
        if isinstance(option, SourceFile):
            return say("settings.own_file", name=option.name)
        return shown_name(known[option], say) if option in known else option

    fields.choice(
        say(f"slots.{name}"), options, current, lambda picked: choose(**{name: picked}), words, key=_key(name)
    )
    with st.container():
        for doubt in () if current is None else entry_doubts(name, current):
            st.warning(show.plain(doubt.text))


AT_40 = AskedNumber(Sentence("viscosity"), "mm²/s", 34.0, (0.5, 1e6), (10.0, 80.0), "viscosity")
AT_100 = AskedNumber(Sentence("viscosity"), "mm²/s", 7.2, (0.5, 1e6), (2.7, 14.0), "viscosity")
DENSITY = AskedNumber(Sentence("density"), "g/cm³", 0.85, (0.5, 1.5), (0.75, 0.95), "density")


def own_fluid() -> None:
    """Offer to type a fluid's data sheet, which is kept in the user's own catalogue and chosen for the job."""
    say = reader.say()
    with fields.fold(say("settings.fluid_own"), key="own-fluid"):
        st.caption(say("settings.fluid_own_help"))
        left, right = st.columns(2)
        name = left.text_input(say("settings.fluid_name"), **fields.kept("own-fluid-name", "")).strip()
        source = right.text_input(say("settings.fluid_source"), **fields.kept("own-fluid-source", "")).strip()
        asked, places = {"at_40": AT_40, "at_100": AT_100, "density": DENSITY}, st.columns(3)
        values: dict[str, float | None] = {}
        for column, (key, each) in zip(places, asked.items(), strict=True):
            with column:
                label = say(f"settings.fluid_{key}", temperature=say.plain_quantity(_AT[key], "temperature"))
                values[key] = fields.number(label, each, None, key=f"own-fluid-{key}", optional=True)
        st.button(say("settings.fluid_keep"), on_click=_keep_fluid, args=(name, source, values), key="own-fluid-keep")
        show.refused("own-fluid")


_AT = {"at_40": 40.0, "at_100": 100.0, "density": 15.0}  # °C


def _keep_fluid(name: str, source: str, values: dict[str, float | None]) -> None:
    """Keep the fluid that was typed, and choose it; or say what is missing or wrong."""
    with show.refusing("own-fluid"):
        at_40, at_100 = values["at_40"], values["at_100"]
        if not id_from_name(name) or not source or at_40 is None or at_100 is None:
            expected = Sentence("a name, where the numbers come from, and the viscosities at 40 and 100 °C")
            raise InputError(Sentence("the fluid is not complete"), expected=expected)
        if at_100 >= at_40:
            expected = Sentence("less at 100 °C than at 40 °C")
            raise InputError(Sentence("the two viscosities do not go together"), expected=expected)
        tables = tables_of_two_points(name, source, dt.date.today().isoformat(), at_40, at_100, values["density"])
        checked_fluid(tables, name)
        write_own("fluids", tables["id"], written_toml(tables, FluidFile))
        pick("fluid", tables["id"])


def controller() -> Controller:
    """Return the controller as chosen or, while that is refused, the one that is shown."""
    try:
        return controller_of(session().case)
    except AtleakError:
        return controller_of(session().good)


def complaint(place: str) -> None:
    """Ask what the customer complains of, at a place that is one of several on a page."""
    say, now = reader.say(), session()
    chosen = controller()
    labels = {each.id: each.label for each in chosen.complaints}
    if now.case.complaint not in labels:
        choose(complaint=None)
    current = now.case.complaint or ""
    fields.choice(
        say("facts.complaint"), ["", *labels], current, lambda name: choose(complaint=name or None),
        lambda name: say.name(labels[name]) if name else say("panel.none_chosen"),
        key=_key(f"complaint-{place}-{chosen.sha256[:12]}-{current}"),
        help=say("panel.complaint_help" if labels else "panel.no_complaints"),
    )  # fmt: skip


def fluid_state() -> None:
    """Ask whether the fluid in the transmission is fresh or used."""
    say, key, states = reader.say(), _key("fluid_state"), (None, *get_args(FluidState))
    low, high = USED_THINNER
    st.radio(
        say("settings.fluid_is"),
        states,
        states.index(session().case.fluid_state),
        key=key,
        format_func=lambda state: say(f"settings.fluid_{state or 'unknown'}"),
        horizontal=True,
        help=say("settings.fluid_help", low=low, high=high),
        on_change=lambda: choose(fluid_state=st.session_state[key]),
    )


def engine() -> None:
    """Ask for the profile, and for every option in which the job may differ from it."""
    say, case, hints = reader.say(), session().case, get_type_hints(Profile)
    fields.choice(
        say("facts.profile"), list(PROFILES), case.profile, lambda name: choose(profile=name, options=()),
        partial(say.get, "profile_names"), key=_key("profile"),
    )  # fmt: skip
    base = PROFILES[case.profile].options
    chosen = base | dict(case.options)

    def take(option: str, value: Any) -> None:
        now = session().case
        values = PROFILES[now.profile].options | dict(now.options) | {option: value}
        differing = ((name, each) for name, each in values.items() if each != PROFILES[now.profile].options[name])
        choose(options=tuple(differing))

    named = partial(say.get, "option_values")
    for option in OPTIONS:
        values = list(get_args(hints[option]))
        tip = "; ".join(f"{named(value)}: `{option}={value}`" for value in values)
        label, key = say(f"options.{option}"), _key(option)
        fields.choice(label, values, chosen[option], partial(take, option), named, key=key, help=tip)
    _eccentricity(chosen["eccentricity"], partial(take, "eccentricity"))
    st.caption(say("settings.profiles"))


def _eccentricity(current: float | str, take: Callable[[float | str], None]) -> None:
    say, unknown, ratio = reader.say(), _key("position"), _key("eccentricity")
    fixed = st.session_state.get("fixed-eccentricity", 0.0) if isinstance(current, str) else current

    def changed() -> None:
        st.session_state["fixed-eccentricity"] = st.session_state[ratio]
        take(UNKNOWN if st.session_state[unknown] else st.session_state[ratio])

    st.toggle(
        say("settings.position_unknown"),
        current == UNKNOWN,
        key=unknown,
        help=say("settings.position_help", factor=say.number(1.5, 1)),
        on_change=changed,
    )
    label = say("settings.eccentricity")
    st.slider(label, 0.0, 1.0, fixed, 0.05, "localized", key=ratio, disabled=current == UNKNOWN, on_change=changed)


def _key(name: str) -> str:
    """Return a widget's key: one of another language is a widget of its own, since a browser keeps the words chosen."""
    now = session()
    return f"{name}-{now.generation}-{now.turns}-{reader.say().language}"
