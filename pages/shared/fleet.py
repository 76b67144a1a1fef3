"""Choose the results of a fleet among those that this computer knows, and show what they sum up to for all units.

Which results, which valve body and by what its groups are told stays in the address, whatever job is shown.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import streamlit as st

from atleak.common.errors import InputError
from atleak.common.wording import Wording
from atleak.fleet.folder import KnownFolder, forget, known_folders, set_aside
from atleak.fleet.results import Results
from atleak.fleet.summary import summed_up
from atleak.fleet.summary_pdf import write_summary_pdf
from atleak.fleet.summary_sections import Depth, FleetSections
from atleak.fleet.summary_tables import by_trouble
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.summary_workbook import write_summary_workbook
from atleak.fleet.sums import GROUP, FleetSummary, ValveBody
from pages.shared import address, fields, font_form, reader, show
from pages.shared.state import job

FOLDER, BODY, BY = "fleet", "body", "by"  # parameters of the address
COMMAND = "atleak fleet run jobs/ --out results/"
SECTIONS = {
    "fleet-units": "fleet.units_of_all",
    "fleet-body": "fleet.one_body",
    "fleet-pairs": "fleet_summary.section_pairs",
    "fleet-wear": "fleet_summary.section_wear",
    "fleet-temperatures": "fleet_summary.section_temperatures",
    "fleet-groups": "fleet_summary.section_comparison",
    "fleet-errors": "fleet_summary.section_errors",
    "fleet-files": "take_along.title",
}
_SEEN = "fleet-seen"  # the state of every folder as this session read it last
_LISTED = 1_000_000  # units: all of them


# --- which results


def choose() -> KnownFolder | None:
    """Let one of the folders be chosen that this computer knows; say which are gone, and how to begin without any."""
    say, damaged, known = reader.say(), set_aside(), known_folders()
    for file in damaged:
        st.warning(say("fleet.set_aside", file=show.plain(file)))
    there = {each.id: each for each in known if each.is_there}
    if not there:
        st.info(say("fleet.none_yet"))
        st.code(COMMAND, language=None)
    asked = address.kept(FOLDER, of_job=False)
    chosen = None
    if there:
        if asked and asked not in there:
            st.warning(say("fleet.not_here"))
        id = _pick(
            say("fleet.which"), list(there), asked, FOLDER,
            lambda id: f"{there[id].path.name} · {there[id].path.parent}",
        )  # fmt: skip
        chosen = there[id]
    with st.container():
        show.refused(FOLDER)
        for each in (each for each in known if each.id not in there):
            text, button = st.columns([5, 1], vertical_alignment="center")
            text.warning(say("fleet.gone", folder=show.plain(each.path)))
            act: Any = partial(show.tried, FOLDER, forget, each)
            button.button(say("remembered.forget"), key=f"fleet-forget-{each.id}", on_click=act)
    return chosen


def _pick(label: str, options: list[str], asked: str, name: str, words: Callable[[str], str]) -> str:
    """Let one of some options be picked: the one that the address names, else the first; the address keeps it."""
    start = asked if asked in options else options[0]
    take = partial(address.keep, name, of_job=False)
    key = f"fleet-{name}-{start}-{reader.say().language}"
    chosen: str = fields.choice(label, options, start, take, words, key=key, disabled=False)
    return chosen


# --- what they are summed up to


def summed(folder: KnownFolder) -> FleetWords:
    """Return the summary of a folder's results, by the heading that is chosen, and its words.

    It stays as this session read it first until somebody asks for what a run has added since.

    Raises
    ------
    AtleakError
        results that cannot be read.
    """
    say, now = reader.say(), Results.open(folder.path).state()
    seen = st.session_state.setdefault(_SEEN, {})
    state = seen.setdefault(folder.id, now)
    with st.container():
        if state != now:
            text, button = st.columns([5, 1], vertical_alignment="center")
            text.info(say("fleet.more_since"))
            button.button(say("fleet.read_anew"), key="fleet-anew", on_click=partial(seen.pop, folder.id, None))
    with st.spinner(say("fleet.summing")):
        try:
            return FleetWords(_summed(str(folder.path), state, address.kept(BY, of_job=False) or None), say)
        except InputError:  # no unit states this heading, which was chosen for other results
            address.keep(BY, "", of_job=False)
            return FleetWords(_summed(str(folder.path), state, None), say)


@st.cache_resource(max_entries=4, show_spinner=False)
def _summed(folder: str, state: str, by: str | None) -> FleetSummary:
    return summed_up(Results.open(folder), by=by, listed=_LISTED)


def reads(folder: KnownFolder) -> str:
    """Return the state of a folder's results that this session shows."""
    return str(st.session_state[_SEEN][folder.id])


# --- the whole


def draw_whole(words: FleetWords) -> None:
    """Show how many units have which verdict, over all valve bodies and of each."""
    say, summary = words.say, words.summary
    st.markdown(f"**{show.plain(words.headline())}** {show.plain(' '.join(words.findings()))}")
    show.section(sections(words).section("verdicts"), "fleet")
    show.messages(summary.messages, say("about.fleet"), opened=True)
    st.caption(show.plain(say("fleet.made_by", count=summary.visits, version=summary.atleak)))


def sections(words: FleetWords) -> FleetSections:
    """Return the sections of a summary, as much of each as the screen has room for."""
    return FleetSections(words, Depth())


def draw_body(words: FleetWords, body: ValveBody) -> None:
    """Show what leads among the units of one valve body, then its sections."""
    say, of = words.say, sections(words)
    show.section(of.intro(body), "fleet")
    _heading("fleet-pairs")
    show.section(of.section("pairs", body), "fleet")
    show.section(of.section("deciders", body), "fleet")
    _heading("fleet-wear")
    show.section(of.section("wear", _with_land(words, body)), "fleet")
    _heading("fleet-temperatures")
    show.section(of.section("temperatures", body), "fleet")
    show.section(of.section("conditions", body), "fleet")
    _heading("fleet-groups")
    if words.summary.by is None:
        st.write(say("fleet.choose_by" if words.summary.headings else "fleet.no_headings"))
    show.section(of.section("comparison", body), "fleet")


def _heading(anchor: str) -> None:
    st.header(reader.say()(SECTIONS[anchor]), anchor=anchor)


def _with_land(words: FleetWords, body: ValveBody) -> ValveBody:
    """Let one of the lands be chosen whose wear over mileage is known; return the valve body with that alone."""
    lands = {land.key: land for land in by_trouble(body) if land.classes}
    if not lands:
        return body
    names = {key: words.land(body.controller, key) for key in lands}
    own = f"fleet-land-{body.controller}-{words.say.language}"
    return replace(body, wear=(lands[fields.one_of(words.say("columns.land"), names, own)],))


def choose_body(words: FleetWords) -> ValveBody:
    """Let one of the valve bodies be chosen, and a heading by which its units are compared."""
    say, summary = words.say, words.summary
    bodies = {body.controller: body for body in summary.bodies}
    first, second = st.columns(2)
    with first:
        chosen = _pick(
            say("columns.controller"), list(bodies), address.kept(BODY, of_job=False), BODY,
            lambda each: f"{words.body(each)} · {say('fleet.units', count=bodies[each].counts.units)}",
        )  # fmt: skip
    with second:
        headings = ["", *summary.headings]
        if len(headings) > 1:
            _pick(say("fleet.by"), headings, summary.by or "", BY, lambda each: heading_words(each, say))
    return bodies[chosen]


def heading_words(heading: str, say: Wording) -> str:
    """Name a heading by which groups are told."""
    return say("fleet.by_nothing") if not heading else say("fleet.group") if heading == GROUP else heading


# --- files


def draw_files(words: FleetWords) -> None:
    """Offer the summary as PDF and workbook, each written when it is asked for."""
    say, (language, paper) = words.say, reader.pick_print("fleet")
    name = show.named("fleet", words.summary.folder.replace("\\", "/").rpartition("/")[2])
    of_pdf = partial(
        write_summary_pdf, words.summary, language=language, paper=paper, units=say.units, letterhead=job()
    )
    workbook = partial(write_summary_workbook, words.summary, language=language, units=say.units)
    files = {"pdf": ("pdf", font_form.printing(of_pdf)), "workbook": ("xlsx", workbook)}
    show.downloads(name, "fleet", {say(f"take_along.{what}"): each for what, each in files.items()}, {})
