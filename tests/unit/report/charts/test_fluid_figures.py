"""The curve of a fluid's viscosity by its trace data."""

from __future__ import annotations

import math

import pytest

from atleak.catalogue.fluid import fluids, load_fluid
from atleak.common.wording import wording
from atleak.report.charts.condition_figures import viscosity_curve

BETWEEN, BEYOND, POINTS, TABLE = "between the data sheet's points", "beyond them", "data sheet", "table of the source"


def test_the_curve_goes_through_the_data_sheet_and_is_dashed_beyond_it() -> None:
    fluid = load_fluid("mobil_atf_220")
    traces = {trace.name: trace for trace in viscosity_curve(fluid, wording("en")).data}
    between, beyond, points = traces[BETWEEN], traces[BEYOND], traces[POINTS]
    (first, nu_first), *_, (last, nu_last) = fluid.points
    assert list(points.x) == [at for at, _ in fluid.points]
    assert (between.x[0], between.x[-1]) == (first, last)
    assert between.y[0] == pytest.approx(nu_first * 1e6, abs=1e-9)
    assert between.y[-1] == pytest.approx(nu_last * 1e6, abs=1e-9)
    assert (between.line.dash, beyond.line.dash) == ("solid", "dash")
    assert all(not first < at < last for at in beyond.x if not math.isnan(at))
    assert min(at for at in beyond.x if not math.isnan(at)) == fluid.span()[0]


def test_every_fluid_can_be_drawn_and_a_table_of_the_source_is_marked() -> None:
    for fluid in fluids():
        traces = {trace.name: trace for trace in viscosity_curve(fluid, wording("en")).data}
        assert (TABLE in traces) == bool(fluid.table)
        assert all(y > 0.0 or math.isnan(y) for trace in traces.values() for y in trace.y)
