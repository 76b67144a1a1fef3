"""Figures of pressures by their trace data."""

from __future__ import annotations

import json

import pytest

from atleak.analysis.pressures import HeldPressure, pressures_at
from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.style import LOOKS
from atleak.common.units import DM3_MIN, KPA, RPM
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.report.charts.condition_figures import pump_speed_chart
from atleak.report.charts.screen import drawn as drawn_on_screen
from atleak.report.tables.pressures import pressure_chart
from atleak.report.tables.pressures import pump_over_speed as speeds


def trace(figure, name: str):
    return next(one for one in figure.data if one.name == name)


def held(diagnosis: Diagnosis, *, planned: bool = True):
    plan = plan_repairs(diagnosis)
    return pressures_at(diagnosis, diagnosis.hot_idle, plan.ends if planned and plan.steps else ())


def test_they_are_transparent_and_say_their_units(worn_clutch: Diagnosis) -> None:
    over_speed = pump_speed_chart(speeds(worn_clutch, worn_clutch.hot_idle, wording("en")))
    for drawn in (drawn_on_screen(pressure_chart(held(worn_clutch), wording("en")), wording("en")), over_speed):
        figure = drawn.checked()
        assert figure.layout.paper_bgcolor == figure.layout.plot_bgcolor == "rgba(0,0,0,0)"
        titles = [axis.title.text or "" for axis in (*figure.select_xaxes(), *figure.select_yaxes())]
        assert any("[" in title for title in titles)
        json.dumps(figure.to_plotly_json(), default=lambda array: array.tolist())


def rows(one) -> list[str]:
    """What the pointer says of the rows that a trace draws: their names come first."""
    return [told.split(":")[0] for told in one.customdata]


def name_of(each: HeldPressure) -> str:
    return "main pressure" if each.circuit is None else each.circuit.name


def test_bars_are_what_holds_new_now_and_repaired(worn_clutch: Diagnosis) -> None:
    at = held(worn_clutch)
    figure = drawn_on_screen(pressure_chart(at, wording("en")), wording("en"))
    for name, value in (("new", "new"), ("after repair", "repaired")):
        bars = trace(figure, name)
        drawn = dict(zip(rows(bars), bars.x, strict=True))
        assert drawn == {name_of(each): getattr(each, value) * KPA for each in at.applied}
    now = [one for one in figure.data if one.type == "bar" and one.name.startswith("now")]
    drawn = {name: value for one in now for name, value in zip(rows(one), one.x, strict=True)}
    assert drawn == {name_of(each): each.now * KPA for each in at.applied}
    for one in now:
        for name, low, high in zip(rows(one), one.error_x.arrayminus, one.error_x.array, strict=True):
            each = next(each for each in at.applied if name_of(each) == name)
            ends = [(each.now * KPA) - low, (each.now * KPA) + high]
            assert ends == pytest.approx([end * KPA for end in each.interval], rel=1e-9, abs=0.0)


def test_a_verdict_is_in_the_word_the_sign_and_the_hatch_of_its_bar(worn_clutch: Diagnosis) -> None:
    figure = drawn_on_screen(pressure_chart(held(worn_clutch), wording("en")), wording("en"))
    bad, good = (trace(figure, f"now: {name}") for name in ("■ replace", "● ok"))
    assert rows(bad) == ["clutch C1"]
    assert bad.marker.color == LOOKS[Verdict.REPLACE].screen
    assert bad.marker.pattern.shape != good.marker.pattern.shape
    assert "lock-up" in rows(good)


def test_limits_stand_beside_the_bars_they_apply_to(worn_clutch: Diagnosis) -> None:
    at = held(worn_clutch)
    figure = drawn_on_screen(pressure_chart(at, wording("en")), wording("en"))
    clutch = next(each for each in at.circuits if each.id == "clutch_c1")
    for name, below in (("▲ watch from here down", 55.0), ("■ replace from here down", 103.0)):
        marks = trace(figure, name)
        drawn = dict(zip(rows(marks), marks.x, strict=True))
        assert drawn["clutch C1"] == pytest.approx(clutch.new * KPA - below, rel=1e-9, abs=0.0)
        assert "main pressure" not in drawn
    permitted = [one for one in figure.data if one.name == "permissible, from and up to"]
    assert [(one.x[0], one.marker.symbol[0]) for one in permitted] == [
        (400.0, "triangle-right"), (539.0, "triangle-left"),
    ]  # fmt: skip
    stated = trace(figure, "set, or required")
    assert dict(zip(rows(stated), stated.x, strict=True)) == {
        name_of(each): each.set_pressure * KPA for each in at.applied if each.set_pressure is not None
    }
    assert "clutch C1" not in rows(stated)


def test_without_readings_nothing_is_green_repaired_or_within_an_interval(
    three_circuits: Controller, hipol: Fluid, limits: Limits
) -> None:
    figure = drawn_on_screen(
        pressure_chart(held(diagnose(three_circuits, hipol, limits)), wording("en")), wording("en")
    )
    names = {one.name for one in figure.data}
    assert "after repair" not in names
    assert not any("ok" in name for name in names if name)
    assert not any(one.error_x.array for one in figure.data)


def test_the_pumps_line_crosses_what_is_taken_at_the_marked_speeds(worn_clutch: Diagnosis) -> None:
    data = speeds(worn_clutch, worn_clutch.hot_idle, wording("en"))
    figure = pump_speed_chart(data)
    assert list(trace(figure, "pump").y) == pytest.approx(list(data.supply * DM3_MIN), rel=1e-12, abs=0.0)
    for demand in data.demands:
        taken = trace(figure, f"taken at {demand.temperature:g}\u00a0°C")
        assert list(taken.y) == [demand.flow * DM3_MIN] * 2
    crossings = trace(figure, "covered from here")
    assert list(crossings.x) == [demand.crossing * RPM for demand in data.demands]
    assert [text for text in crossings.text if text] == [f"<b>{data.demand.crossing * RPM:.0f}\u00a0rpm</b>"]
    assert [round(value, 6) for value in crossings.error_x.array][:3] == [0.0] * 3
    assert crossings.error_x.array[3] > 0.0
    assert [shape.x0 for shape in figure.layout.shapes] == [700.0]
    assert "hot idle: 700\u00a0rpm" in {note.text for note in figure.layout.annotations}
    dashes = [trace(figure, f"taken at {demand.temperature:g}\u00a0°C").line.dash for demand in data.demands]
    assert len(set(dashes)) == len(dashes)
