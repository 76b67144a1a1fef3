"""Draw the valve body that is being described: its spools with their lands, and where its flow goes."""

from __future__ import annotations

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import written_toml
from atleak.catalogue.workbook.draft import Checked
from atleak.catalogue.workbook.subjects import sketch
from atleak.common.errors import AtleakError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.report.charts.drawing import controller_svg
from atleak.report.charts.flows import flow_diagram, flow_svg
from atleak.report.sheets.controller_workbook import SPOOL_PICTURE
from pages.shared import reader, show
from pages.shared.transmission import COMPONENTS, NEW_PARTS

_BESIDE = 5  # components side by side
_ROW, _HIGHEST = 130, 330  # pixels of one row of components, and of the picture; more of it scrolls
_MEANT = 720  # pixels of the picture that explains
_COLUMN = 135  # pixels of a column of the flows, at which its words can be read


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
