"""Maps of what is tried: shades, borders and marks, in the reader's units."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.analysis.what_if import Map, WhatIf, map_over
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.condition_figures import pressure_map, share_map

JOB, TRIED = (80.0, 1.0), (100.0, 2.0)


@pytest.fixture(scope="module")
def over(worn_clutch: Diagnosis) -> Map:
    return map_over(worn_clutch, WhatIf(), [20.0, 80.0, 140.0, 151.0], [0.0, 1.5, 3.0])


def test_the_shares_are_shaded_and_the_job_and_what_is_tried_are_marked(over: Map) -> None:
    figure = share_map(over, JOB, TRIED, wording("en")).checked()
    shade = figure.data[0]
    assert np.asarray(shade.z)[:, :3] == pytest.approx(100.0 * over.share[:, :3], abs=0.005)
    assert np.isnan(np.asarray(shade.z)[:, 3]).all()
    marks = {trace.name: (trace.x[0], trace.y[0]) for trace in figure.data[1:] if trace.mode == "markers"}
    assert marks == {"the job": JOB, "tried": TRIED}


def test_a_border_is_where_its_level_begins(over: Map) -> None:
    figure = pressure_map(over, "clutch_c1", JOB, TRIED, wording("en")).checked()
    lines = {trace.name: trace for trace in figure.data[1:] if trace.mode == "lines"}
    watch = over.pressure_borders["clutch_c1"][0]
    assert np.asarray(lines["▲ watch from here up"].y) == pytest.approx(
        over.pressure_reaches("clutch_c1", watch), abs=1e-12, nan_ok=True
    )


def test_a_reader_of_us_units_has_fahrenheit_and_psi(over: Map) -> None:
    figure = pressure_map(over, "p_g", JOB, TRIED, wording("de", "us")).checked()
    assert list(figure.data[0].x) == pytest.approx([68.0, 176.0, 284.0, 303.8], abs=1e-9)
    assert np.asarray(figure.data[0].z)[0, 0] == pytest.approx(over.pressures["p_g"][0, 0] / 6894.757, abs=0.01)
    assert figure.layout.xaxis.title.text == "ATF-Temperatur [°F]"
