"""Compute the source study's variants once, and keep them."""

from __future__ import annotations

from typing import Any

import streamlit as st

from atleak.analysis.source_study import compare_options, run_variants, sample_log, temperature_curves
from atleak.job.case import Case
from atleak.readers.logs import read_road_test
from pages.shared.cases import controller_of

CITED = "Dziubak & Szczepaniak, *Energies* 2023, 16, 7667, [doi 10.3390/en16227667](https://doi.org/10.3390/en16227667)"


@st.cache_resource(max_entries=8, show_spinner="W1 … W8")
def computed(key: str, _controller: Any, _road_test: Any) -> tuple[Any, ...]:
    """Return a controller and a road test (the study's by default) with results, options and temperature curves."""
    if _controller is None:
        _controller, _road_test = controller_of(Case()), read_road_test(sample_log())
    job = _controller, _road_test
    return *job, run_variants(*job), compare_options(*job), temperature_curves(*job)
