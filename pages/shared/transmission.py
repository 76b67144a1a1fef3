"""The valve body that is being described: its tables and pictures, what it learns, its workbook."""

from __future__ import annotations

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import written_toml
from atleak.catalogue.pump_dimensions import other_dimensions
from atleak.catalogue.workbook.draft import Checked, Draft, draft_of
from atleak.catalogue.workbook.subjects import CONTROLLER, sketch
from atleak.common.errors import AtleakError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.report.charts.drawing import controller_svg
from atleak.report.charts.flows import flow_diagram, flow_svg
from atleak.report.sheets.controller_workbook import SPOOL_PICTURE, write_controller_workbook
from atleak.report.tables.catalogue import evidence_counts, open_values
from pages.shared import entry_tables, reader, show, workshop_data
from pages.shared.editing import Desk, Editing
from pages.shared.learn_form import learn_form

_BESIDE = 5  # components side by side
_ROW, _HIGHEST = 130, 330  # pixels of one row of components, and of the picture; more of it scrolls
_MEANT = 720  # pixels of the picture that explains
_COLUMN = 135  # pixels of a column of the flows, at which its words can be read
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


def draw_head(editing: Editing, found: Checked) -> None:
    """Show what is described and how its values are known, and ask in which units its numbers are typed."""
    say, told = reader.say(), ""
    if found.entry is not None:
        counts = evidence_counts(found.entry)
        known = ", ".join(
            say("transmission.count", count=count, known=say(f"evidence.{name}"))
            for name, count in counts.items()
            if count
        )
        lacking = "; ".join(open_values(found.entry, say)) or say("transmission.nothing")
        told = say("transmission.counts", known=known, lacking=lacking)
    workshop_data.draw_head(DESK, editing, found, say, told)


def draw_tables(editing: Editing, step: str, found: Checked) -> None:
    """Draw the tables and fields of a step; a pump's dimensions of other kinds in a fold."""
    kind = found.data.get("pump", {}).get("kind")
    entry_tables.draw(editing, STEPS[step], found, frozenset(other_dimensions(kind)) if step == PUMP else ())


def draw_spools(step: str, found: Checked) -> None:
    """Draw every component with the lands that are typed so far, beside the tables in which they are typed."""
    say = reader.say()
    if step == COMPONENTS:
        with st.expander(say("transmission.meant")):
            st.image(SPOOL_PICTURE, width=_MEANT)
    with st.container():
        if step != COMPONENTS:
            return
        controller = found.entry or sketch(found.data)
        if controller is None:
            st.caption(say("transmission.no_picture"))
        else:
            rows = -(-len({land.component for land in controller.lands}) // _BESIDE)
            with st.container(height=min(rows * _ROW, _HIGHEST), border=False):
                drawing = controller_svg(controller, columns=_BESIDE, title=say("transmission.lands_described"))
                show.svg(drawing, say("transmission.every_spool"))


def draw_flow(step: str, found: Checked, job: Diagnosis) -> None:
    """Draw where the flow of the unit as new goes at one of its operating points, with the fluid of the job."""
    if step in (COMPONENTS, NEW_PARTS):
        return
    say = reader.say()
    st.subheader(say("transmission.flow"))
    with st.container():
        if found.entry is None:
            st.caption(say("transmission.flow_later"))
            return
        points = {point.name: say.condition(point) for point in found.entry.operating_points}
        chosen = st.selectbox(
            say("transmission.flow_at"),
            list(points),
            format_func=lambda name: points.get(name, name),
            key="transmission-at",
        )
        try:
            key = written_toml(found.data), job.fluid.origin.sha256, job.fluid.state, job.limits.origin.sha256
            reader_s = say.language, say.units
            drawing, columns = _flow((*key, *reader_s), chosen or next(iter(points)), found.entry, job)
        except AtleakError as error:
            st.caption(say("transmission.no_flow", problem=show.plain(error)))
            return
        show.svg(drawing, say("transmission.flow_goes"), least_width=_COLUMN * columns)


@st.cache_resource(max_entries=8, show_spinner=False)
def _flow(key: tuple[str, ...], point: str, _controller: Controller, _job: Diagnosis) -> tuple[str, int]:
    """Return the drawing of the flows at an operating point, and how many columns it has."""
    diagnosis = diagnose(_controller, _job.fluid, _job.limits)
    projection = next(each for each in diagnosis.presented if each.condition.name == point)
    say = reader.say()
    diagram = flow_diagram(diagnosis, projection, say=say)
    title = say("circuits.flow_title", condition=say.condition(projection.condition))
    return flow_svg(diagram, title, say), diagram.columns


def draw_learning(editing: Editing, step: str, found: Checked) -> None:
    """Learn mounting clearances from measuring sheets of new units, into the tables of lands."""
    if step != NEW_PARTS:
        return
    say = reader.say()
    st.subheader(say("transmission.learning"))
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
