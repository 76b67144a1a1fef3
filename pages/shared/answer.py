"""Show what people read first: whose unit it is, which part it is, what to do, and how sure that is."""

from __future__ import annotations

import streamlit as st

from atleak.common.style import look_of
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.answer import answer_facts
from atleak.report.tables.first_sentence import first_sentence, shown_verdict
from atleak.report.tables.sentences import caveat_marks
from pages.shared import customer, places, reader, show
from pages.shared.state import job

_COLOURS = {"success": "green", "warning": "orange", "error": "red", "info": "blue"}


def draw_head(diagnosis: Diagnosis) -> None:
    """Name vehicle, mileage, unit and complaint in a line, with the customer's screen and the report beside it."""
    say, record = reader.say(), job()
    vehicle, unit = record.vehicle, record.transmission
    known = [
        vehicle.registration or vehicle.vin,
        " ".join(filter(None, (vehicle.make, vehicle.model, vehicle.year))),
        say.quantity(vehicle.mileage_km, "distance", 0) if vehicle.mileage_km is not None else "",
        say.name(diagnosis.controller.name),
        unit.serial,
        say.name(diagnosis.complaint.label) if diagnosis.complaint is not None else "",
    ]
    with st.container(horizontal=True, horizontal_alignment="distribute", vertical_alignment="center", key="head"):
        st.markdown(" · ".join(f"**{show.plain(each)}**" for each in known if each))
        with st.container(horizontal=True, vertical_alignment="center", width="content"):
            customer.draw_button(diagnosis)
            st.page_link(places.page("Report"), label=say("pages.Report"), width="content")


def draw_verdict(diagnosis: Diagnosis) -> None:
    """Show the verdict in a word, with what is in doubt of it."""
    say, level = reader.say(), shown_verdict(diagnosis)
    good_in_the_car = level == Verdict.OK and diagnosis.without_sheet  # which says little of the valve body
    level = Verdict.NOT_MEASURED if good_in_the_car else level
    open_ones = level == Verdict.NOT_MEASURED and (diagnosis.judged or good_in_the_car)
    word = f"{look_of(level).sign} {say('diagnosis.open')}" if open_ones else say.signed(level)
    marks = "".join(f" · {mark}" for mark in caveat_marks(diagnosis, say))
    st.title(f":{_COLOURS[look_of(level).box]}[{show.plain(word)}]{show.plain(marks)}", anchor=False)


def draw(diagnosis: Diagnosis) -> None:
    """Show the answer in three lines."""
    say = reader.say()
    with st.container(key="answer", gap="xsmall"):
        for name, said in answer_facts(diagnosis, say).rows:
            st.markdown(f"**{show.plain(name)}:** {show.plain(said)}")


def draw_reason(diagnosis: Diagnosis) -> None:
    """Say in one sentence what decides, what the unit leaks, and what was not measured or is in doubt."""
    say = reader.say()
    said = [first_sentence(diagnosis, say)]
    if any("mounting_clearance_um" in land.state.land.representative for land in diagnosis.flagged):
        said.append(say("diagnosis.new_assumed"))
    st.caption(show.plain(" ".join(said)))
