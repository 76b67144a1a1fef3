"""Show the steps of the job, each a way to its page, with what is there and what is missing."""

from __future__ import annotations

from pathlib import Path

import streamlit as st

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.result import Step, job_steps
from pages.shared import reader, show
from pages.shared.state import job

_PAGES = {path.stem.partition("_")[2].lower(): path for path in Path(__file__).resolve().parents[1].glob("[1-9]_*.py")}


def draw(diagnosis: Diagnosis) -> None:
    """Draw a line of the job's steps."""
    with st.container(horizontal=True, gap="small", key="steps"):
        steps = [step for step in job_steps(diagnosis, job(), reader.say()) if step.name in _PAGES]
        for number, step in enumerate(steps, 1):
            st.page_link(_PAGES[step.name], label=_label(number, step), width="content")


def _label(number: int, step: Step) -> str:
    state = show.plain(step.state)
    name = f"{number} {reader.say()(f'steps.{step.name}')}"
    return f"{name} · {state if step.complete else f'**{state}**'}" if state else name
