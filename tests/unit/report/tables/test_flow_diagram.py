"""Where the pump's flow goes: laid out once, drawn as ribbons, and read as a table."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from xml.etree import ElementTree

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.style import LOOKS
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.flows import FlowKind
from atleak.measurements.readings import Readings
from atleak.report.charts.flows import FlowDiagram, flow_diagram, flow_svg, flow_table, flow_words
from tests.unit.conftest import with_clearances

Build = Callable[..., Readings]
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module", params=["five_speed_2005", "four_speed_2023", "minimal_example"])
def unit(request: pytest.FixtureRequest, hipol: Fluid, limits: Limits, readings_of: Build) -> Diagnosis:
    """A shipped unit of which every fourth land is worn."""
    controller = load_controller(request.param)
    clearances = {land.key: 45e-6 for land in controller.lands[::4]}
    return diagnose(controller, hipol, limits, readings=with_clearances(controller, readings_of, clearances))


def at_each(diagram: FlowDiagram) -> list[tuple[float, float]]:
    """What comes to and goes from each place."""
    into, out = [0.0] * len(diagram.places), [0.0] * len(diagram.places)
    for each in diagram.flows:
        into[each.target] += each.flow
        out[each.source] += each.flow
    return list(zip(into, out, strict=True))


def ribbons(svg: str) -> list[dict[str, float]]:
    """Both ends of every ribbon: their heights on the drawing, and the flow it stands for."""
    found = []
    for path in ElementTree.fromstring(svg).iter(f"{SVG}path"):
        numbers = [float(each) for each in re.findall(r"-?[\d.]+", path.attrib["d"])]
        x0, y0, x1, y1, below_1, below_0 = numbers[0], numbers[1], numbers[6], numbers[7], numbers[8], numbers[14]
        found.append(
            {"x0": x0, "x1": x1, "left": below_0 - y0, "right": below_1 - y1, "flow": float(path.attrib["data-flow"])}
        )
    return found


@pytest.mark.parametrize("leaks_only", [False, True])
def test_as_much_comes_to_every_place_as_goes_however_many_lands_stand_together(
    unit: Diagnosis, leaks_only: bool
) -> None:
    for projection in unit.projections:
        for lands in (0, 3, 12, 100):
            diagram = flow_diagram(unit, projection, lands=lands, leaks_only=leaks_only)
            for place, (into, out) in zip(diagram.places, at_each(diagram), strict=True):
                if into and out:
                    assert into == pytest.approx(out, abs=1e-8 * projection.pump_supply), place.name
                assert place.flow == max(into, out)
            first = sum(place.flow for place in diagram.places if place.column == 0)
            sump = next(place.flow for place in diagram.places if place.place.kind is FlowKind.SUMP)
            assert sump == pytest.approx(projection.leakage, rel=1e-7, abs=0.0)
            if not leaks_only:
                assert first == pytest.approx(projection.pump_supply, rel=1e-7, abs=0.0)
            assert (FlowKind.PUMP in {place.place.kind for place in diagram.places}) is not leaks_only


def test_every_flow_leads_to_a_later_column_and_the_sump_is_last(unit: Diagnosis) -> None:
    for projection in unit.projections:
        diagram = flow_diagram(unit, projection)
        for each in diagram.flows:
            assert diagram.places[each.source].column < diagram.places[each.target].column
        last = {place.place.kind for place in diagram.places if place.column == diagram.columns - 1}
        assert FlowKind.SUMP in last


def test_the_worst_lands_stand_by_themselves_and_the_others_are_counted(unit: Diagnosis) -> None:
    projection = unit.projection
    full = flow_diagram(unit, projection, lands=100)
    few = flow_diagram(unit, projection, lands=2)

    def lands(diagram: FlowDiagram) -> list[str]:
        return [place.name for place in diagram.places if place.place.kind is FlowKind.LAND]

    def counted(name: str) -> int:
        together = re.match(r"(\d+) more lands$", name)
        return int(together[1]) if together else 1

    assert sum(map(counted, lands(few))) == len(lands(full))
    ranked = sorted(
        (place for place in full.places if place.place.kind is FlowKind.LAND),
        key=lambda place: (-place.verdict.rank, -place.flow),
    )
    assert {place.name for place in ranked[:2]} <= set(lands(few))
    together = [place for place in few.places if "more lands" in place.name]
    assert all(place.verdict is not None for place in together)


def test_a_land_and_a_circuit_carry_their_verdict_and_what_is_not_judged_has_none(worn_clutch: Diagnosis) -> None:
    diagram = flow_diagram(worn_clutch, worn_clutch.hot_idle)
    verdicts = {place.words: place.verdict for place in diagram.places}
    assert verdicts["clutch C1"] == verdicts["2 · 1"] == Verdict.REPLACE
    assert verdicts["lock-up"] == Verdict.OK
    assert {verdicts[name] for name in ("cooler", "lubrication", "left over", "sump", "slip of the pump")} == {None}
    into_clutch = [each for each in diagram.flows if diagram.places[each.target].words == "clutch C1"]
    assert {each.verdict for each in into_clutch} == {Verdict.REPLACE}


def test_nothing_that_was_not_measured_is_ok(three_circuits: Controller, hipol: Fluid, limits: Limits) -> None:
    diagnosis = diagnose(three_circuits, hipol, limits)
    diagram = flow_diagram(diagnosis, diagnosis.projection)
    assert {place.verdict for place in diagram.places} == {Verdict.NOT_MEASURED, None}


def test_ribbons_are_as_wide_as_their_flow_and_lie_on_the_sheet(unit: Diagnosis) -> None:
    for leaks_only in (False, True):
        diagram = flow_diagram(unit, unit.projection, leaks_only=leaks_only)
        svg = flow_svg(diagram, "flows")
        sheet = ElementTree.fromstring(svg)
        drawn = ribbons(svg)
        assert sorted(each["flow"] for each in drawn) == pytest.approx(
            sorted(each.flow * 6e4 for each in diagram.flows), rel=1e-5, abs=0.0
        )
        wide = max(drawn, key=lambda each: each["flow"])
        for each in drawn:
            assert each["left"] == pytest.approx(each["right"], abs=0.021)
            expected = max(each["flow"] / wide["flow"] * wide["left"], 1.0)
            assert each["left"] == pytest.approx(expected, rel=1e-3, abs=0.03)
            assert 0.0 <= each["x0"] < each["x1"] <= float(sheet.attrib["width"])
        for box in sheet.iter(f"{SVG}rect"):
            assert float(box.attrib["y"]) >= 0.0
            assert float(box.attrib["y"]) + float(box.attrib["height"]) <= float(sheet.attrib["height"]) + 0.1


def test_words_of_a_column_do_not_lie_over_one_another(unit: Diagnosis) -> None:
    svg = ElementTree.fromstring(flow_svg(flow_diagram(unit, unit.projection), "flows"))
    by_left: dict[str, list[float]] = {}
    for text in svg.iter(f"{SVG}text"):
        by_left.setdefault(text.attrib["x"], []).append(float(text.attrib["y"]))
    for heights in by_left.values():
        heights.sort()
        assert all(below - above >= 11.0 for above, below in pairwise(heights))
    grounds = [
        [float(box.attrib[name]) for name in ("x", "y", "width", "height")]
        for box in svg.iter(f"{SVG}rect")
        if "fill-opacity" in box.attrib
    ]
    for text in svg.iter(f"{SVG}text"):  # which no edge of a ribbon strikes through
        x, y = float(text.attrib["x"]), float(text.attrib["y"])
        assert any(
            left < x < left + width and top < y - 8.0 and y < top + height for left, top, width, height in grounds
        )


def test_a_verdict_shows_by_sign_and_weight_and_not_by_colour_alone(worn_clutch: Diagnosis) -> None:
    svg = ElementTree.fromstring(flow_svg(flow_diagram(worn_clutch, worn_clutch.hot_idle), "flows"))
    signs = [sign.attrib for sign in svg.iter(f"{SVG}polygon")]
    replace_sign = [sign for sign in signs if sign["fill"] == LOOKS[Verdict.REPLACE].screen]
    square = " ".join(f"{x:g},{y:g}" for x, y in LOOKS[Verdict.REPLACE].shape.points)
    assert replace_sign
    assert {sign["points"] for sign in replace_sign} == {square}
    bold = {text.text.split(" 0")[0] for text in svg.iter(f"{SVG}text") if text.attrib.get("font-weight") == "bold"}
    assert {"clutch C1", "2 · 1", "2 · 2"} <= bold
    assert "lock-up" not in bold


def test_names_from_a_file_stay_text(worn_clutch: Diagnosis, hostile: tuple[str, ...]) -> None:
    controller = worn_clutch.controller
    for name in hostile:
        named = replace(
            controller,
            components=MappingProxyType(dict.fromkeys(controller.components, name)),
            circuits=tuple(replace(each, name=name) for each in controller.circuits),
            consumers=tuple(replace(each, name=name) for each in controller.consumers),
        )
        diagnosis = replace(worn_clutch, controller=named)
        root = ElementTree.fromstring(flow_svg(flow_diagram(diagnosis, worn_clutch.hot_idle), name))
        assert root.find(f"{SVG}title").text == name
        assert max(len(element.text or "") for element in root.iter(f"{SVG}text")) <= 60


def test_the_table_holds_every_flow_the_largest_first(worn_clutch: Diagnosis) -> None:
    diagram = flow_diagram(worn_clutch, worn_clutch.hot_idle)
    rows = flow_table(diagram, wording("en")).records()
    flows = [row["flow"] for row in rows]
    assert flows == sorted(flows, reverse=True)
    assert len(rows) == len(diagram.flows)
    clutch = next(row for row in rows if row["flows_to"] == "clutch C1 254 kPa")
    assert clutch["flows_from"] == "main pressure p_g 500 kPa"
    assert clutch["verdict"] == Verdict.REPLACE


@pytest.mark.parametrize("language", languages())
def test_words_and_numbers_are_those_of_the_language(worn_clutch: Diagnosis, language: str) -> None:
    say = wording(language)
    svg = ElementTree.fromstring(flow_svg(flow_diagram(worn_clutch, worn_clutch.hot_idle, say=say), "x", say))
    said = " ".join(text.text or "" for text in svg.iter(f"{SVG}text"))
    assert f"{say('flows.sump')} {flow_words(worn_clutch.hot_idle.leakage, say)}" in said
    decimal = say.decimal
    assert f"{say('flows.pump')} 12{decimal}6" in said


@pytest.mark.parametrize("language", languages())
def test_words_where_the_leakage_goes_are_legible_on_paper(unit: Diagnosis, language: str) -> None:
    say = wording(language)
    drawn = flow_svg(flow_diagram(unit, unit.projection, leaks_only=True, lands=4, say=say), "flows", say)
    width, height = (float(ElementTree.fromstring(drawn).attrib[side]) for side in ("width", "height"))
    points = min(180.0 / width, 120.0 / height) * 72.0 / 25.4  # of the drawing's unit, on the paper's width
    assert 11.0 * points >= 7.5
    assert not [each for each in unit.controller.components if "_" in each and each in drawn], "ids"


def test_small_flows_keep_digits() -> None:
    say = wording("en")
    assert [flow_words(flow / 6e4, say) for flow in (12.64, 0.53, 0.0881)] == ["12.6", "0.53", "0.088"]
