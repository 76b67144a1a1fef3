"""Compute the source study's variants once, keep them, and show its tables."""

from __future__ import annotations

from typing import Any

import pandas as pd
import streamlit as st

from atleak.intake.road_test import read_road_test
from atleak.job.case import Case
from atleak.variants import compare_options, run_variants, sample_log, temperature_curves
from pages.shared.cases import controller_of

CITED = "Dziubak & Szczepaniak, *Energies* 2023, 16, 7667, [doi 10.3390/en16227667](https://doi.org/10.3390/en16227667)"


@st.cache_resource(max_entries=8, show_spinner="Running W1 to W8 …")
def computed(key: str, _controller: Any, _road_test: Any) -> tuple[Any, ...]:
    """Return a controller and a road test (the study's by default) with results, options and temperature curves."""
    if _controller is None:
        _controller, _road_test = controller_of(Case()), read_road_test(sample_log())
    job = _controller, _road_test
    return *job, run_variants(*job), compare_options(*job), temperature_curves(*job)


def table(rows: list[dict[str, Any]], digits: str = "{:.4g}") -> None:
    """Show rows with every number in one format; the first column stays in sight."""
    frame = pd.DataFrame(rows)
    style = frame.style.format(digits, subset=frame.select_dtypes("number").columns)
    pinned = {frame.columns[0]: st.column_config.Column(pinned=True)}
    st.dataframe(style, column_config=pinned, hide_index=True, height="content", placeholder="–")
