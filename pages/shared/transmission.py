"""The valve body that is being described: its tables and pictures, what it learns, its workbook."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from typing import Any

import streamlit as st

from atleak.analysis.learning.learned_clearances import Learned, learn
from atleak.analysis.learning.learned_words import learned_messages, summary, with_learned
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, written_toml
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.instruments import Part, instruments, load_instruments
from atleak.catalogue.pump_dimensions import other_dimensions
from atleak.catalogue.workbook.draft import Checked, Draft, draft_of
from atleak.catalogue.workbook.subjects import CONTROLLER, sketch
from atleak.common.errors import AtleakError
from atleak.common.units import unit_names
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.job.case import SourceFile
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.readers.remembered_columns import default_path
from atleak.readers.sheets.measuring_sheet import read_several
from atleak.report.charts.drawing import controller_svg
from atleak.report.charts.flows import flow_diagram, flow_svg
from atleak.report.sheets.controller_workbook import SPOOL_PICTURE, write_controller_workbook
from atleak.report.tables.catalogue import evidence_counts, open_values
from atleak.report.tables.learned import learned_lands, learned_outliers, learned_units
from pages.shared import entry_tables, fields, reader, show, workshop_data
from pages.shared.cases import sheets_remembered
from pages.shared.editing import Desk, Editing, ask_step, checked_now, draw_faults
from pages.shared.sheet_form import AS_STATED, unit_said

_TYPES = ["xlsx", "xls", "ods", "csv", "tsv", "txt"]  # of sheets
_BESIDE = 5  # components side by side
_ROW, _HIGHEST = 130, 330  # pixels of one row of components, and of the picture; more of it scrolls
_MEANT = 720  # pixels of the picture that explains
COMPONENTS, NEW_PARTS, PUMP = "components", "new_parts", "pump"
STEPS = {
    "head": ("Head",),
    COMPONENTS: ("Components", "Lands", "Materials"),
    NEW_PARTS: (),  # no tables of its own: sheets of new units, from which mounting clearances are learned
    PUMP: ("Pump",),
    "points": ("Operating points",),
    "circuits": ("Circuits", "Feeds", "Set pressures", "Apply chart"),
    "gaps": ("Gaps", "Section pressures"),
    "pressures": ("Line pressures",),
    "leaks": ("Leaks", "Consumers", "Consumer flows"),
    "repairs": ("Repairs", "Complaints"),
}


def _of_workbook(content: bytes, name: str) -> Draft:
    workbook = read_controller_workbook(content, name=name)
    return draft_of(CONTROLLER, workbook.data, workbook.units)


_UNITS = ("length", "clearance", "pressure")
DESK = Desk(CONTROLLER, "transmission", _UNITS, _of_workbook)


def draw(diagnosis: Diagnosis) -> None:
    """Describe a valve body in tables: from a shipped one, an own one or from nothing, and save it as an own file."""
    say = reader.say()
    st.write(say("transmission.about"))
    editing = DESK.current()
    workshop_data.draw_undo(DESK, say)
    if editing is None:
        workshop_data.choose_start(DESK, say)
        return
    checked = checked_now(editing)
    workshop_data.draw_head(DESK, editing, checked, say, _how_known(checked, say))
    step = ask_step(editing, list(STEPS), lambda name: say(f"transmission.step_{name}"), say)
    draw_faults(editing, checked, say)
    if step == COMPONENTS:
        draw_spools(checked)
    aside = other_dimensions(checked.data.get("pump", {}).get("kind")) if step == PUMP else ()
    entry_tables.draw(editing, STEPS[step], checked, frozenset(aside))
    if step == NEW_PARTS:
        draw_learning(editing, checked)
    elif step != COMPONENTS:
        draw_flow(checked, diagnosis)
    st.header(say("transmission.keep"))
    draw_saving(editing, checked)


def _how_known(found: Checked, say: Wording) -> str:
    if found.entry is None:
        return ""
    known = ", ".join(
        say("transmission.count", count=count, known=say(f"evidence.{name}"))
        for name, count in evidence_counts(found.entry).items()
        if count
    )
    lacking = "; ".join(open_values(found.entry, say)) or say("transmission.nothing")
    return say("transmission.counts", known=known, lacking=lacking)


def draw_spools(found: Checked) -> None:
    """Draw every component with the lands that are typed so far, beside the tables in which they are typed."""
    say = reader.say()
    with st.expander(say("transmission.meant")):
        st.image(SPOOL_PICTURE, width=_MEANT)
    with st.container():
        controller = found.entry or sketch(found.data)
        if controller is None:
            st.caption(say("transmission.no_picture"))
            return
        rows = -(-len({land.component for land in controller.lands}) // _BESIDE)
        with st.container(height=min(rows * _ROW, _HIGHEST), border=False):
            title, note = say("transmission.lands_described"), say("casting.schematic")
            drawing = controller_svg(controller, columns=_BESIDE, title=title, note=note)
            show.svg(drawing, say("transmission.every_spool"))


def draw_flow(found: Checked, job: Diagnosis) -> None:
    """Draw where the flow of the unit as new goes at one of its operating points, with the fluid of the job."""
    say = reader.say()
    st.header(say("transmission.flow"))
    with st.container():
        if found.entry is None:
            st.caption(say("transmission.flow_later"))
            return
        points = {point.name: say.condition(point) for point in found.entry.operating_points}
        chosen = fields.one_of(say("transmission.flow_at"), points, "transmission-at")
        try:
            key = written_toml(found.data), job.fluid.origin.sha256, job.fluid.state, job.limits.origin.sha256
            reader_s = say.language, say.units
            drawing, columns = _flow((*key, *reader_s), chosen, found.entry, job)
        except AtleakError as error:
            st.caption(say("transmission.no_flow", problem=show.plain(error)))
            return
        show.svg(drawing, say("transmission.flow_goes"), columns)


@st.cache_resource(max_entries=8, show_spinner=False)
def _flow(key: tuple[str, ...], point: str, _controller: Controller, _job: Diagnosis) -> tuple[str, int]:
    """Return the drawing of the flows at an operating point, and how many columns it has."""
    diagnosis = diagnose(_controller, _job.fluid, _job.limits)
    projection = next(each for each in diagnosis.presented if each.condition.name == point)
    say = reader.say()
    diagram = flow_diagram(diagnosis, projection, say=say)
    title = say("circuits.flow_title", condition=say.condition(projection.condition))
    return flow_svg(diagram, title, say), diagram.columns


def draw_learning(editing: Editing, found: Checked) -> None:
    """Learn mounting clearances from measuring sheets of new units, into the tables of lands."""
    say = reader.say()
    st.header(say("transmission.learning"))
    if found.entry is None:
        st.caption(say("transmission.learning_later"))
        return
    tables = learn_form(found.data, key=editing.key("learn"))
    if tables is not None:
        editing.put(draft_of(CONTROLLER, tables, editing.draft.units))
        editing.anew()
        st.rerun()


def draw_saving(editing: Editing, found: Checked) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along, as a workbook too."""
    say = reader.say()

    def workbook(name: str) -> None:
        st.download_button(
            say("transmission.workbook"),
            lambda: write_controller_workbook(found.data, editing.draft.units),
            f"{name}.xlsx",
            on_click="ignore",
            disabled=found.entry is None,
            help=say("transmission.workbook_help"),
        )

    workshop_data.draw_saving(DESK, editing, found, say, workbook)


# --- mounting clearances from sheets of new units


def learn_form(data: Mapping[str, Any], *, key: str = "learn") -> dict[str, Any] | None:
    """Ask for measuring sheets of new units, and show what they tell of a valve body when new.

    Parameters
    ----------
    data
        the tables of the valve body's file, without a fault.

    Returns
    -------
    dict or None
        the tables with the learned clearances, once, when the button that takes them over was pressed.
    """
    say = reader.say()
    st.write(say("learning.about"))
    files = st.file_uploader(say("learning.sheets"), _TYPES, accept_multiple_files=True, key=f"{key}-sheets")
    places = st.columns(2)
    units = [AS_STATED, *unit_names("length")]
    unit = places[0].selectbox(say("sheet_form.unit"), units, format_func=unit_said, key=f"{key}-unit")
    bodies, tip = list(dict.fromkeys([data["id"], *catalogue_files("controllers")])), say("learning.made_for_help")
    made_for = places[1].selectbox(say("learning.made_for"), bodies, key=f"{key}-made-for", help=tip)
    gauges = {"spool": _gauge(places[0], "spool", key), "sleeve": _gauge(places[1], "sleeve", key)}
    if not files:
        return None
    sources = tuple((file.name, file.getvalue()) for file in files)
    try:
        with st.spinner(say("learning.comparing")):
            known = [(name, SourceFile(name, content).sha256) for name, content in sources]
            digest = repr((written_toml(data), known, sheets_remembered()))
            learned = _learned(digest, data, sources, unit or None, made_for, gauges)
        tables = with_learned(data, learned, dt.date.today())
        checked_controller(tables)
    except AtleakError as error:
        st.error(show.plain(error))
        return None
    _show(learned)
    taken = st.button(say("learning.take"), type="primary", key=f"{key}-take")
    return tables if taken else None


def _gauge(place: Any, part: Part, key: str) -> str:
    say = reader.say()
    able = {gauge.id: say.name(gauge.name) for gauge in instruments() if part in gauge.measures}
    usual = load_instruments().of(part).id
    chosen: str = fields.one_of(say(f"slots.{part}_instrument"), able, f"{key}-{part}", usual, place=place)
    return chosen


@st.cache_resource(max_entries=4, show_spinner=False)
def _learned(
    digest: str,
    _data: Mapping[str, Any],
    _sources: tuple[tuple[str, bytes], ...],
    unit: str | None,
    made_for: str,
    gauges: dict[str, str],
) -> Learned:
    """Learn once for the same tables, sheets and choices; ``digest`` stands for all but the choices."""
    controller = checked_controller(_data)
    return learn(
        controller,
        read_several(_sources, controller, unit=unit, made_for=made_for, remembered=default_path()),
        instruments=load_instruments(**gauges),
    )


def _show(learned: Learned) -> None:
    say = reader.say()
    st.markdown(show.plain(say.sentence(summary(learned))))
    for message in learned_messages(learned):
        (st.warning if message.level == "warning" else st.info)(show.plain(say.sentence(message.text)))
    show.table(learned_lands(learned, say))
    outliers = learned_outliers(learned, say)
    if outliers.rows:
        st.markdown(f"**{say('learning.left_out')}**")
        show.table(outliers)
    with st.expander(say("learning.units")):
        show.table(learned_units(learned, say))
