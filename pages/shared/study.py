"""Compute the source study's variants once, keep them, and show its tables."""

from __future__ import annotations

from typing import Any

import pandas as pd
import streamlit as st

from atleak.intake.road_test import read_road_test
from atleak.job.case import Case
from atleak.variants import compare_options, run_variants, sample_log, temperature_curves
from pages.shared import reader
from pages.shared.cases import controller_of

CITED = "Dziubak & Szczepaniak, *Energies* 2023, 16, 7667, [doi 10.3390/en16227667](https://doi.org/10.3390/en16227667)"


@st.cache_resource(max_entries=8, show_spinner="W1 … W8")
def computed(key: str, _controller: Any, _road_test: Any) -> tuple[Any, ...]:
    """Return a controller and a road test (the study's by default) with results, options and temperature curves."""
    if _controller is None:
        _controller, _road_test = controller_of(Case()), read_road_test(sample_log())
    job = _controller, _road_test
    return *job, run_variants(*job), compare_options(*job), temperature_curves(*job)


def said(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with the headings and words of the article's tables in the reader's language."""
    words = reader.say().texts["study_words"]
    return {
        words.get(heading, heading): words.get(cell, cell) if isinstance(cell, str) else cell
        for heading, cell in row.items()
    }


def table(rows: list[dict[str, Any]], places: int | None = None, *, signed: bool = False) -> None:
    """Show rows with every number alike, with four digits unless ``places`` are given; the first column stays."""
    say = reader.say()

    def written(value: Any) -> str:
        if pd.isna(value):
            return "–"
        sign = "+" if signed and value > 0.0 else ""
        return sign + (say.plain(value, 4) if places is None else say.number(value, places))

    frame = pd.DataFrame([said(row) for row in rows])
    style = frame.style.format(written, subset=frame.select_dtypes("number").columns)
    pinned = {frame.columns[0]: st.column_config.Column(pinned=True)}
    st.dataframe(style, column_config=pinned, hide_index=True, height="content", placeholder="–")
