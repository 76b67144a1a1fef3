"""Charts and drawings as the pages show them."""

from __future__ import annotations

import re

import plotly.graph_objects as plotly_objects
import pytest

from atleak.common.style import PAPER_INKS, look_of
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.drawing import controller_svg, on_dark, spool_svg
from atleak.report.charts.land_figures import land_wear, leakage_ranking


@pytest.mark.parametrize(("theme", "paper"), [("light", "#ffffff"), ("dark", "#10171c")])
def test_a_charts_words_stand_out_from_its_ground(
    sample: Diagnosis, monkeypatch: pytest.MonkeyPatch, theme: str, paper: str
) -> None:
    from pages.shared import show

    def luminance(colour: str) -> float:
        parts = [int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    def contrast(colour: str) -> float:
        low, high = sorted((luminance(colour), luminance(paper)))
        return (high + 0.05) / (low + 0.05)

    drawn = []
    monkeypatch.setattr(show, "dark", lambda: theme == "dark")
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, **_: drawn.append(figure))
    show.chart(leakage_ranking(sample), "any")
    figure = plotly_objects.Figure(drawn[0].to_dict())
    bars = [trace for trace in figure.data if trace.type == "bar"]
    inks = [figure.layout.xaxis.tickfont.color, figure.layout.yaxis.title.font.color, figure.layout.legend.font.color]
    inks += [bar.error_x.color for bar in bars]
    assert len(bars) > 1
    assert min(contrast(ink) for ink in inks) >= 4.5


def test_a_charts_numbers_have_the_readers_decimal_sign_and_no_finger_zooms_it(
    sample: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pages.shared import show

    drawn = []
    monkeypatch.setattr(show, "dark", lambda: False)
    monkeypatch.setattr(show.reader, "say", lambda: wording("de"))
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, **_: drawn.append(figure.to_dict()["layout"]))
    show.chart(leakage_ranking(sample), "any")
    assert drawn[0]["separators"] == ",\u00a0"
    assert drawn[0]["dragmode"] is False


def test_of_a_chart_without_a_point_no_axes_are_drawn(unmeasured: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    from pages.shared import show

    said = []
    monkeypatch.setattr(show, "dark", lambda: False)
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, **_: pytest.fail("empty axes"))
    monkeypatch.setattr(show.st, "caption", said.append)
    show.chart(land_wear(unmeasured), "any", empty="Nothing measured.")
    assert said == ["Nothing measured."]


def test_a_drawing_on_a_dark_ground_has_light_words(four_speed) -> None:
    for drawing in (spool_svg(four_speed, "25"), controller_svg(four_speed)):
        assert PAPER_INKS.ink in drawing
        assert PAPER_INKS.ink not in on_dark(drawing)
        assert 'rx="4" fill="#FFFFFF"' not in on_dark(drawing)


def test_on_a_dark_ground_no_land_is_brighter_than_one_to_be_replaced(four_speed) -> None:
    verdicts = dict.fromkeys((land.key for land in four_speed.lands), Verdict.OK) | {("25", 1): Verdict.REPLACE}
    verdicts |= {("25", 2): Verdict.NOT_MEASURED}

    def brightness(ink: str) -> int:
        return sum(int(ink[place : place + 2], 16) for place in (1, 3, 5))

    fills = set(re.findall(r'<rect[^>]* fill="(#\w+)"', on_dark(spool_svg(four_speed, "25", verdicts, wording("en")))))
    assert max(fills, key=brightness) == look_of(Verdict.REPLACE).fill
