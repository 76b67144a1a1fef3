"""Name the pages in the order of the navigation, and where an address of earlier versions leads today."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import streamlit as st

from atleak.common.wording import Wording

PAGES = Path(__file__).resolve().parents[1]
START, *EVERY = sorted(PAGES.glob("[0-9]*_*.py"), key=lambda path: int(path.stem.partition("_")[0]))
STEPS = [path for path in EVERY if path.stem[1] == "_"]  # of a job, in their order
MOVED = {  # by the name in an address: the page, and which of its parts
    "Readings": ("Measure", ""),
    **dict.fromkeys(("Pressures", "Road_test"), ("In_the_car", "")),
    "Uncertainty": ("Diagnosis", "lands"),
    "What_if": ("Plan", "what_if"),
    "Estimate": ("Plan", "repairs"),
    "Job_book": ("Jobs", ""),
    "Unit": ("History", "unit"),
    "Compare": ("History", "compare"),
    "Catalogue": ("Library", "catalogue"),
    "Transmission": ("Library", "transmission"),
    "Workshop_data": ("Library", "workshop_data"),
    "Gauge_study": ("Library", "gauge_study"),
    "Source_study": ("Library", "catalogue"),
}


def name_of(path: Path) -> str:
    """Return the name of a page in its address and in the texts."""
    return path.stem.partition("_")[2]


def page(name: str) -> Path:
    """Return the script of a page, by its name in an address of today or before."""
    now = MOVED.get(name, (name, ""))[0]
    return next((path for path in (START, *EVERY) if name_of(path) == now), START)


def every_page(say: Wording) -> list[st.Page]:
    """Return the pages, and one that leads on for each that there was before."""
    pages = [st.Page(path, title=say.get("pages", name_of(path)), default=path == START) for path in (START, *EVERY)]
    moved = [
        st.Page(partial(_lead_on, name), title=say.get("pages", now), url_path=name, visibility="hidden")
        for name, (now, _) in MOVED.items()
    ]
    return pages + moved


def _lead_on(name: str) -> None:
    now, part = MOVED[name]
    parameters = st.query_params.to_dict() | ({now.lower(): part} if part else {})
    st.switch_page(page(name), query_params=parameters)
