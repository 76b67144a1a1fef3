"""The figures of uncertainty, by the data of their traces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.limits import LimitOrigin, Limits, Steps
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.uncertainty import DECISIONS, DEFAULTS, UnitUncertainty
from atleak.report.charts import land_figures as figures
from tests.unit.diagnosis.uncertainty.conftest import a_sheet

UM = 1e-6

ENGLISH = wording("en")


@pytest.fixture
def unit(judge: Callable, four_speed: Controller) -> UnitUncertainty:
    sheet = a_sheet(four_speed, clearance=32 * UM)
    return judge(sheet, assumptions=DEFAULTS, draws=1000).unit


def test_clearances_carry_their_intervals_and_limits(unit: UnitUncertainty, limits: Limits) -> None:
    figure = figures.land_clearances(unit, ENGLISH, lands=10)
    traces = {trace.name: trace for trace in figure.data}
    drawn = 0
    for decision in ("pass", "conditional pass", "conditional fail", "fail"):
        trace = traces.get(decision)
        if trace is None:
            continue
        for name, x, above, below in zip(trace.y, trace.x, trace.error_x.array, trace.error_x.arrayminus, strict=True):
            component, _, number = name.partition(" · ")
            land = unit.land((component, int(number)))
            assert land.decision == decision.replace(" ", "_")
            assert x == pytest.approx(32.0, abs=1e-6)
            assert x + above == pytest.approx(land.clearance_interval[1] * 1e6, rel=1e-12, abs=0.0)
            assert x - below == pytest.approx(land.clearance_interval[0] * 1e6, rel=1e-12, abs=0.0)
            drawn += 1
    assert drawn == 10
    assert len(traces["mounting clearance"].x) == 10
    worst = max((land for land in unit.lands if land.deciding), key=lambda land: land.deciding.severity)
    index = list(traces["limit"].y).index(f"{worst.key[0]} · {worst.key[1]}")
    expected = worst.sources.state.land.mounting_clearance * (1.0 + worst.deciding.limit) * 1e6
    assert traces["limit"].x[index] == pytest.approx(expected, rel=1e-12, abs=0.0)


def test_leakages_show_interval_and_eccentricity(unit: UnitUncertainty, four_speed: Controller) -> None:
    line, points = figures.leakages(unit, four_speed.operating_points[0], ENGLISH, lands=5).data
    largest = max(unit.lands, key=lambda land: land.conditions[0].leakage)
    assert points.x[0] == pytest.approx(largest.conditions[0].leakage * 6e4, rel=1e-9, abs=0.0)
    assert points.x[0] + points.error_x.array[0] == pytest.approx(largest.leakage_interval[1] * 6e4, rel=1e-9, abs=0.0)
    assert line.x[0] == points.x[0]
    assert line.x[1] == pytest.approx(largest.conditions[0].eccentric[1] * 6e4, rel=1e-9, abs=0.0)
    assert 2.0 * line.x[0] < line.x[1] < 2.5 * line.x[0]  # entry loss does not depend on where the spool lies
    assert len(points.x) == 5


def test_budget_adds_up(unit: UnitUncertainty) -> None:
    bars = figures.budget(next(land for land in unit.lands if land.conditions[0].share > 0.0), ENGLISH, sources=50).data
    assert [sum(bar.x) for bar in bars] == pytest.approx([100.0, 100.0], rel=1e-9, abs=0.0)


def test_limit_of_a_clearance_is_drawn_where_it_decides(
    judge: Callable, four_speed: Controller, limits: Limits
) -> None:
    steps = Steps(((Verdict.REPLACE, 30 * UM),), LimitOrigin.WORKSHOP, "")
    only = replace(limits, wear=None, clearance=steps, pair_share=None)
    unit = judge(a_sheet(four_speed, clearance=32 * UM), limits=only, draws=500).unit
    limit = next(trace for trace in figures.land_clearances(unit, ENGLISH).data if trace.name == "limit")
    assert list(limit.x) == pytest.approx([30.0] * len(limit.x), rel=1e-12, abs=0.0)


def test_a_decision_is_named_as_the_texts_name_it(unit: UnitUncertainty, monkeypatch: pytest.MonkeyPatch) -> None:
    for decision in DECISIONS:
        monkeypatch.setitem(wording("en").table("decisions"), decision, f"decided: {decision}")
    named = {trace.name for trace in figures.land_clearances(unit, ENGLISH, lands=len(unit.lands)).data}
    assert named >= {f"decided: {land.decision}" for land in unit.lands}
