"""The printed charts of pressures: words of the language, every circuit named, hatches and signs beside shades."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from atleak.diagnosis import Diagnosis
from atleak.repair import plan_repairs
from atleak.report.printed_charts import Bar, pressures_chart, pump_chart, shares_chart
from atleak.verdicts import Verdict
from atleak.views.pressures import pressures_at
from atleak.views.pump_speed import pump_over_speed
from atleak.wording import languages, wording

SVG = "{http://www.w3.org/2000/svg}"


def words(svg: str) -> str:
    text = " ".join("".join(element.itertext()) for element in ElementTree.fromstring(svg).iter(f"{SVG}text"))
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize("language", languages())
def test_the_pump_over_speed_says_the_speed_from_which_it_covers_what_is_taken(
    worn_clutch: Diagnosis, language: str
) -> None:
    say = wording(language)
    data = pump_over_speed(worn_clutch, worn_clutch.hot_idle)
    said = words(pump_chart(data, say))
    assert f"{data.demand.crossing * 60.0:.0f} 1/min" in said
    assert "hot idle: 700 1/min" in said
    for demand in data.demands:
        assert say("charts.taken_at", temperature=f"{demand.temperature:g}") in said
    assert say("charts.speed") in said


@pytest.mark.parametrize("language", languages())
def test_every_applied_circuit_stands_with_its_pressure_and_the_word_of_its_verdict(
    worn_clutch: Diagnosis, language: str
) -> None:
    say = wording(language)
    at = pressures_at(worn_clutch, worn_clutch.hot_idle, plan_repairs(worn_clutch).ends)
    said = words(pressures_chart(at, say))
    for each in at.applied:
        name = say("held.line") if each.circuit is None else each.circuit.name
        assert name in said
        assert f"{each.now / 1e3:.0f} {say.level(each.verdict)}" in said
    assert "clutch C2" not in said  # empty in this gear
    assert say("charts.pressure") in said


def test_repaired_bars_are_drawn_only_with_a_plan(worn_clutch: Diagnosis) -> None:
    def bars(svg: str) -> int:
        return len(re.findall(r'id="patch_', svg))

    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    planned = pressures_at(worn_clutch, worn_clutch.hot_idle, plan_repairs(worn_clutch).ends)
    say = wording("en")
    assert bars(pressures_chart(planned, say)) - bars(pressures_chart(at, say)) == len(at.applied)


def test_signs_that_no_font_has_are_drawn_as_boxes(worn_clutch: Diagnosis, hostile: tuple[str, ...]) -> None:
    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    names = iter(hostile)
    while named := [
        replace(each, circuit=replace(each.circuit, name=name)) for each, name in zip(at.circuits, names, strict=False)
    ]:
        circuits = (*named, *at.circuits[len(named) :])
        ElementTree.fromstring(pressures_chart(replace(at, circuits=circuits), wording("en")))
    marked = tuple((name, 10.0 + number) for number, name in enumerate(hostile))
    data = replace(pump_over_speed(worn_clutch, worn_clutch.hot_idle), marked=marked)
    ElementTree.fromstring(pump_chart(data, wording("en")))


@pytest.mark.parametrize("low", [3.0, math.inf])
def test_shares_of_a_pump_that_may_deliver_nothing_are_drawn_to_the_edge(low: float) -> None:
    bars = [Bar("8/1", 9.0, Verdict.CRITICAL, low, math.inf), Bar("25/1", 4.0, Verdict.OK, 3.0, 5.0)]
    said = words(shares_chart(bars, "share [%]", wording("en")))
    assert "9.00" in said
    assert "4.00" in said
