"""Offer the result as files, and say what it rests on."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import streamlit as st

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.json.diagnosis import to_json
from atleak.report.xlsx import write_workbook
from pages.shared import reader, show
from pages.shared.cases import PageCase
from pages.shared.state import job


def take_along(case: PageCase, diagnosis: Diagnosis, record: dict[str, Any]) -> None:
    """Offer JSON and workbook, and show the basis of the result."""
    say = reader.say()
    st.subheader(say("take_along.title"))
    options = st.columns(2)
    language = reader.pick_language(options[0], "workbook-language")
    paper = reader.pick_paper(options[1], "workbook-paper")
    with st.container(horizontal=True, vertical_alignment="bottom"):
        source = case.readings or case.road_test
        name = named("diagnosis", job().number or (Path(source.name).stem if source else diagnosis.controller.id))
        st.download_button("JSON", lambda: to_json(record), f"{name}.json", on_click="ignore")
        workbook = partial(write_workbook, diagnosis, job(), language=language, paper=paper, units=say.units)
        st.download_button(say("take_along.workbook"), workbook, f"{name}.xlsx", on_click="ignore")
    show.basis(diagnosis, record)


def named(what: str, number: str) -> str:
    """Return a file's name without its ending: what it is, and the workshop's number as far as it can stand."""
    kept = "".join(sign if sign.isalnum() or sign in "-_" else "_" for sign in number.strip())
    return f"{what}_{kept}" if kept else what
