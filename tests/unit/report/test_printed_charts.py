"""The printed charts: words of the language, every circuit named, hatches and signs beside shades, axes apart."""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from atleak.analysis.pressures import pressures_at
from atleak.analysis.repair.plan import plan_repairs
from atleak.common.style import PAPER_INKS
from atleak.common.translations import languages
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.charts.paper_curves import pump_chart, road_chart
from atleak.report.pdf.body import Body
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.pressures import pressure_chart, pump_over_speed
from atleak.report.tables.road_test import road_series

NEEDS_PUMP = ("share_percent", "pump_capacity_dm3_min")
SVG = "{http://www.w3.org/2000/svg}"


def words(svg: str) -> str:
    text = " ".join("".join(element.itertext()) for element in ElementTree.fromstring(svg).iter(f"{SVG}text"))
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize("language", languages())
def test_the_pump_over_speed_says_the_speed_from_which_it_covers_what_is_taken(
    worn_clutch: Diagnosis, language: str
) -> None:
    say = wording(language)
    data = pump_over_speed(worn_clutch, worn_clutch.hot_idle, wording("en"))
    said = words(pump_chart(data, say))
    assert f"{data.demand.crossing * 60.0:.0f} {say.unit('engine_speed')}" in said
    assert f"hot idle: 700 {say.unit('engine_speed')}" in said
    for demand in data.demands:
        assert say("charts.taken_at", temperature=f"{demand.temperature:g}") in said
    assert say("charts.speed") in said


def test_the_legend_of_the_pump_is_read_along_its_rows(worn: Diagnosis) -> None:
    say = wording("en")
    data = pump_over_speed(worn, worn.hot_idle, say)
    texts = [each for each in ElementTree.fromstring(pump_chart(data, say)).iter(f"{SVG}text") if "taken" in each.text]
    texts.sort(key=lambda each: (float(each.attrib["y"]), float(each.attrib["x"])))
    assert len({each.attrib["y"] for each in texts}) == 2, "more than one row"
    temperatures = [float(re.search(r"[\d.]+", each.text)[0]) for each in texts]
    assert temperatures == sorted(temperatures)
    assert len(temperatures) == len(data.demands) > 3


@pytest.mark.parametrize("language", languages())
def test_every_applied_circuit_stands_with_its_pressure_and_the_word_of_its_verdict(
    worn_clutch: Diagnosis, language: str
) -> None:
    say = wording(language)
    at = pressures_at(worn_clutch, worn_clutch.hot_idle, plan_repairs(worn_clutch).ends)
    said = words(drawn_on_paper(pressure_chart(at, say), say))
    for each in at.applied:
        name = say("held.line") if each.circuit is None else each.circuit.name
        assert name in said
        assert f"{each.now / 1e3:.0f} {say.level(each.verdict)}" in said
    assert "clutch C2" not in said  # empty in this gear
    assert say("figures.pressure") in said


def test_repaired_bars_are_drawn_only_with_a_plan(worn_clutch: Diagnosis) -> None:
    def bars(svg: str) -> int:
        return len(re.findall(rf"fill: {PAPER_INKS.rule.lower()}[^\"]*stroke: {PAPER_INKS.ink.lower()}", svg))

    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    planned = pressures_at(worn_clutch, worn_clutch.hot_idle, plan_repairs(worn_clutch).ends)
    say = wording("en")
    assert bars(drawn_on_paper(pressure_chart(at, say), say)) == 0
    assert bars(drawn_on_paper(pressure_chart(planned, say), say)) == len(at.applied)


def test_names_from_a_file_stay_text_in_charts(worn_clutch: Diagnosis, hostile: tuple[str, ...]) -> None:
    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    usual = {
        element.tag
        for element in ElementTree.fromstring(drawn_on_paper(pressure_chart(at, wording("en")), wording("en"))).iter()
    }
    names = iter(hostile)
    while named := [
        replace(each, circuit=replace(each.circuit, name=name)) for each, name in zip(at.circuits, names, strict=False)
    ]:
        circuits = (*named, *at.circuits[len(named) :])
        shown = ElementTree.fromstring(
            drawn_on_paper(pressure_chart(replace(at, circuits=circuits), wording("en")), wording("en"))
        )
        assert {element.tag for element in shown.iter()} == usual, "no name became an element of the drawing"
    marked = tuple((name, 10.0 + number) for number, name in enumerate(hostile))
    data = replace(pump_over_speed(worn_clutch, worn_clutch.hot_idle, wording("en")), marked=marked)
    ElementTree.fromstring(pump_chart(data, wording("en")))


def shares_of(worn: Diagnosis, *lands: SimpleNamespace) -> str:
    say = wording("en")
    chart = Body(PrintedNames(worn, Job(), say), None, {})._share_chart(lands, "share [%]")
    return words(drawn_on_paper(chart, say))


def leaking(key: tuple[str, int], share: float, verdict: Verdict, *interval: float) -> SimpleNamespace:
    return SimpleNamespace(
        key=key, share=share, verdict=verdict, uncertainty=SimpleNamespace(share_interval=interval or None)
    )


@pytest.mark.parametrize("low", [0.03, math.inf])
def test_shares_of_a_pump_that_may_deliver_nothing_are_drawn_to_the_edge(worn: Diagnosis, low: float) -> None:
    said = shares_of(
        worn,
        leaking(("8", 1), 0.09, Verdict.CRITICAL, low, math.inf),
        leaking(("25", 1), 0.04, Verdict.OK, 0.03, 0.05),
    )
    assert "9.00" in said
    assert "4.00" in said


def test_bars_of_shares_are_sorted_by_what_they_show_and_end_in_their_intervals(worn: Diagnosis) -> None:
    drawing = [land.share for land in worn.drawing_most]
    assert drawing == sorted(drawing, reverse=True)
    assert min(drawing) > 0.0
    assert {land.key for land in worn.drawing_most} == {land.key for land in worn.lands if land.share > 0.0}
    assert "3.21 (2.52–7.20)" in shares_of(worn, leaking(("25", 1), 0.0321, Verdict.REPLACE, 0.0252, 0.072))


@pytest.mark.parametrize("share", [True, False])
def test_leakage_pump_and_share_are_each_drawn_over_an_axis_of_their_own(worn: Diagnosis, share: bool) -> None:
    series, say = road_series(worn.road, 200), wording("de")
    if not share:
        known = {name: values for name, values in series.columns.items() if name not in NEEDS_PUMP}
        series = replace(series, columns=known)
    chart = road_chart(series, [(1.0, 2.0, 10.0)], [(Band.RED, 5.0)], say)
    said = words(chart)
    titles = [say(f"charts.{name}", unit=say.unit("flow")) for name in ("leakage_in", "capacity_in", "share")]
    assert [title in said for title in titles] == [True, share, share]
    curves = [path for path in ElementTree.fromstring(chart).iter(f"{SVG}path") if path.attrib["d"].count("L") > 15]
    heights = [[float(y) for y in re.findall(r"[ML] \S+ ([\d.]+)", path.attrib["d"])] for path in curves]
    assert len(heights) == (3 if share else 1)
    assert all(max(above) < min(below) for above, below in pairwise(heights)), "no curve reaches into another field"
    upright = re.findall(r"M ([\d.]+) ([\d.]+)\s+L \1 ([\d.]+)", chart)
    grid = Counter(x for x, top, bottom in upright if abs(float(top) - float(bottom)) > 50.0)
    assert len(grid) > 3
    assert [x for x, count in grid.items() if count % len(heights)] == [], "the same lines in each field"
