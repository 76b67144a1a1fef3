"""The drawings: sound XML whatever a controller's file says, every land there, nothing beside the sheet."""

from __future__ import annotations

import re
from dataclasses import replace
from types import MappingProxyType
from xml.etree import ElementTree

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.style import LOOKS
from atleak.report.charts.drawing import controller_svg, shortened, spool_svg, upright_svg, wrapped

SVG = "{http://www.w3.org/2000/svg}"


def rectangles(svg: str) -> list[dict[str, str]]:
    return [element.attrib for element in ElementTree.fromstring(svg).iter(f"{SVG}rect")]


def test_every_land_is_drawn_in_the_shade_of_its_verdict():
    controller = load_controller("four_speed_2023")
    order = list(LOOKS)
    verdicts = {land.key: order[number % 5] for number, land in enumerate(controller.lands)}
    fills = [rectangle["fill"] for rectangle in rectangles(controller_svg(controller, verdicts))]
    for verdict in ("watch", "replace", "critical"):
        expected = sum(given == verdict for given in verdicts.values())
        assert fills.count(LOOKS[verdict].fill) == expected > 0


@pytest.mark.parametrize("columns", [1, 5, 6, 50])
def test_nothing_lies_beside_the_sheet(columns):
    svg = controller_svg(load_controller("four_speed_2023"), columns=columns)
    width, height = (float(ElementTree.fromstring(svg).attrib[name]) for name in ("width", "height"))
    for rectangle in rectangles(svg):
        x, y, w, h = (float(rectangle[name]) for name in ("x", "y", "width", "height"))
        assert min(x, y) >= 0.0
        assert x + w <= width
        assert y + h <= height


def test_spool_shows_every_plane_and_diameter():
    controller = load_controller("four_speed_2023")
    texts = [element.text for element in ElementTree.fromstring(spool_svg(controller, "17")).iter(f"{SVG}text")]
    lands = controller.lands_of("17")
    for land in lands:
        assert f"⌀ {land.nominal_diameter * 1e3:.3f}" in texts
        assert set(land.planes) <= set(texts)
    with pytest.raises(KeyError):
        spool_svg(controller, "1")


def test_lands_lie_where_their_positions_say_where_those_of_all_are_known():
    controller = load_controller("minimal_example")
    one, two = controller.lands_of("pressure_regulator")

    def gap_over_length(*positions):
        lands = tuple(replace(land, position=position) for land, position in zip((one, two), positions, strict=True))
        svg = spool_svg(replace(controller, lands=(*lands, *controller.lands[2:])), "pressure_regulator")
        fills = [each for each in rectangles(svg) if each.get("stroke-width")]
        first, second = ((float(each["x"]), float(each["width"])) for each in fills[-2:])
        return (second[0] - first[0] - first[1]) / first[1]

    assert gap_over_length(1.0e-3, 21.0e-3) == pytest.approx(15.0 / 5.0, abs=0.02)  # 20 mm apart, each 5 mm long
    assert gap_over_length(None, 21.0e-3) == pytest.approx(1.0, abs=0.02)


def words_of(svg):
    return [text.text for text in ElementTree.fromstring(svg).iter(f"{SVG}text")]


@pytest.mark.parametrize("columns", [5, 6])
def test_a_name_is_drawn_whole_and_an_id_that_repeats_it_is_left_out(columns):
    controller = load_controller("gm_4l60e")
    drawn = words_of(controller_svg(controller, columns=columns, letters=1.6))
    assert "pressure_regulator" not in drawn
    assert "…" not in "".join(drawn)
    whole = " ".join(drawn).replace("- ", "").replace("-", "")
    names = {controller.components[land.component] for land in controller.lands}
    assert [name for name in names if name.replace("-", "") not in whole] == []


def test_a_word_longer_than_a_line_is_broken_and_a_name_without_end_is_cut():
    controller = load_controller("gm_4l60e")
    long = replace(controller, components=MappingProxyType(dict.fromkeys(controller.components, "Regel" * 20)))
    drawn = words_of(controller_svg(long, columns=6, only=["boost_valve"]))
    assert drawn[-4].endswith("-")
    assert drawn[-1].endswith("…")
    for line in drawn[-4:-1]:
        assert re.fullmatch("(gel)?(Regel)*(Re)?-", line), "broken before a syllable"


@pytest.mark.parametrize(
    ("name", "room", "lines"),
    [
        ("Überdruckventil", 12, ["Überdruck-", "ventil"]),
        ("Leitungsdruck-Verstärkungsventil", 20, ["Leitungsdruck-", "Verstärkungsventil"]),
        ("Begrenzungsventil der Leitung", 16, ["Begrenzungs-", "ventil der", "Leitung"]),
        ("Leitungsdruckregelung", 14, ["Leitungsdruck-", "regelung"]),
        ("Vorwärtskupplung", 13, ["Vorwärtskupp-", "lung"]),
        ("shift valve 1-2", 12, ["shift valve", "1-2"]),
        ("shift valve 1-2", 14, ["shift valve", "1-2"]),
        ("X" * 20, 12, ["X" * 11 + "-", "X" * 9]),
    ],
)
def test_a_name_breaks_at_its_hyphens_and_within_a_word_only_where_it_is_wider_than_its_box(name, room, lines):
    assert wrapped(name, room, 4) == lines


def test_names_from_a_file_stay_text(hostile):
    controller = load_controller("four_speed_2023")
    for text in hostile:
        named = MappingProxyType(dict.fromkeys(controller.components, text))
        svg = controller_svg(replace(controller, name=text, components=named))
        root = ElementTree.fromstring(svg)
        assert root.find(f"{SVG}title").text == text
        assert {re.sub(r"\{.*\}", "", element.tag) for element in root.iter()} <= {
            "svg", "title", "rect", "path", "text", "g", "circle"
        }  # fmt: skip
        assert max(len(element.text or "") for element in root.iter(f"{SVG}text")) <= 40


def test_shortened_keeps_what_fits():
    assert shortened("valve", 5) == "valve"
    assert shortened("valves", 5) == "valv…"


def test_an_upright_spool_names_its_planes_and_is_called_not_to_scale_unless_its_lands_positions_are_known():
    controller = load_controller("four_speed_2023")
    known = tuple(replace(land, position=0.008 * land.land) for land in controller.lands_of("25"))
    others = tuple(land for land in controller.lands if land.component != "25")
    for lands, note in ((controller.lands, ["not to scale"]), ((*others, *known), [])):
        svg = upright_svg(replace(controller, lands=lands), "25", (100.0, 150.0), "not to scale")
        said = [text.text for text in ElementTree.fromstring(svg).iter(f"{SVG}text")]
        assert said == [plane for land in known for plane in land.planes] + note
    drawn = rectangles(svg)[1:]  # the first is the rod
    one_scale = {round(float(each["height"]) / land.nominal_diameter) for each, land in zip(drawn, known, strict=True)}
    along = {round(float(each["width"]) / land.contact_length) for each, land in zip(drawn, known, strict=True)}
    assert max(one_scale | along) - min(one_scale | along) <= 0.01 * max(along)
    with pytest.raises(KeyError):
        upright_svg(controller, "no such", (100.0, 150.0), "")
