"""A fleet's summary on paper, read back: its rates with what they are of, its names, its tags, its pages."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any
from unittest.mock import patch

import pikepdf
import pypdfium2
import pytest
from matplotlib.figure import Figure

from atleak.analysis.rates import rate
from atleak.common.style import OK_IN_PART
from atleak.common.translations import languages
from atleak.common.verdicts import FLAGGED, Verdict
from atleak.common.wording import Wording, wording
from atleak.fleet.summary_charts import FleetCharts
from atleak.fleet.summary_pdf import DEPTHS, DETAILED, write_summary_pdf
from atleak.fleet.summary_words import TERMS, FleetWords, within_words
from atleak.fleet.summary_workbook import write_summary_workbook
from atleak.fleet.sums import FleetSummary, VerdictCounts
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.charts.paper_axes import WIDTH
from tests.unit.fleet.made_up import summary

LONG = "Supplier of remanufactured valve bodies with an extraordinarily long name, branch {}"
OWN = "a_description_of_a_workshop_that_no_catalogue_has"
CASES: dict[str, dict[str, Any]] = {
    "many valve bodies, many groups": {
        "controllers": ("four_speed_2023", "five_speed_2005", "gm_4l60e", "zf_6hp26"),
        "units": 400,
        "groups": tuple(f"batch {number:02}" for number in range(12)),
    },
    "long names, sixty lands": {
        "controllers": (OWN,),
        "units": 5000,
        "keys": tuple((f"valve_of_a_long_name_{number}", 1 + number % 3) for number in range(60)),
        "groups": tuple(LONG.format(number) for number in range(3)),
        "name": "a_folder_of_a_long_name/another folder/" + "unit_of_the_customer_" * 4 + "{number}.zip",
    },
    "one unit": {"units": 1, "groups": (), "errors": False},
    "nothing flagged, one group": {"units": 40, "flagged": False, "errors": False, "groups": ("only",)},
    "no logs, no mileage, few units": {"units": 6, "logs": False, "mileage": False, "groups": ("a", "b")},
}


def text_of(content: bytes) -> str:
    with pypdfium2.PdfDocument(content) as document:
        pages = " ".join(page.get_textpage().get_text_range() for page in document)
    return re.sub(r"\s+", " ", pages.replace("\ufffe", "").replace("\u00a0", " "))


def plain(text: str) -> str:
    return text.replace("\u00a0", " ")


@cache
def printed(language: str = "en", units: str = "metric") -> tuple[FleetSummary, bytes, str]:
    made = summary(("five_speed_2005",), units=120)
    content = write_summary_pdf(made, language=language, units=units)
    return made, content, text_of(content)


@cache
def printed_case(case: str) -> tuple[FleetSummary, bytes]:
    made = summary(**CASES[case])
    return made, write_summary_pdf(made)


def assert_rates_stand_there(made: FleetSummary, text: str, say: Wording) -> None:
    words = FleetWords(made, say)
    assert "".join(plain(words.headline()).split()) in "".join(text.split()), "whatever line ends where"
    (body,) = made.bodies
    assert body.comparison is not None
    for counted in (made.counts, *(group.counts for group in body.comparison.groups)):
        for verdict in FLAGGED:
            assert plain(words.percent(counted.rates[verdict])) in text
    leading = body.pairs[0]
    for of_pair in (leading.flagged, leading.replace, leading.deciding):
        assert plain(words.percent(of_pair)) in text
    assert plain(words.counted(leading.replace.count, leading.replace.of)) in text
    counts = made.counts
    bar = (
        *(counts.verdicts[verdict] for verdict in reversed(FLAGGED)),
        counts.ok_throughout,
        *(counts.ok_in_part, counts.verdicts[Verdict.NOT_MEASURED]),
    )
    assert all(bar)
    assert " ".join(map(str, bar)) in text


def test_every_rate_stands_there_with_its_interval_and_its_units() -> None:
    made, content, text = printed()
    say = wording("en")
    assert_rates_stand_there(made, text, say)
    for pair in made.bodies[0].pairs[:3]:
        assert FleetWords(made, say).land("five_speed_2005", pair.key) in text
    for unit in made.worst[: DEPTHS[1].units]:
        assert unit.name in text
    assert made.worst[DEPTHS[1].units].name not in text
    for kind in made.errors:
        assert f"{say('fleet_errors.' + kind.kind)}: {kind.count}" in text
        assert all(name in text for name, _ in kind.first)
    assert all(plain(say(f"fleet_meaning.{term}"))[:40] in text for term in TERMS)
    assert b"<pdfaid:part>2<" in content
    assert b"<pdfuaid:part>1<" in content


def test_a_screen_reader_finds_headings_tables_and_words_for_every_chart() -> None:
    with pikepdf.open(io.BytesIO(printed()[1])) as document:
        assert str(document.Root.Lang) == "en"
        assert str(document.docinfo.Title) == "Fleet summary · results of week 17"
        kinds = [str(each.get("/S", "")) for each in document.objects if isinstance(each, pikepdf.Dictionary)]
        figures = [
            str(each.get("/Alt", ""))
            for each in document.objects
            if isinstance(each, pikepdf.Dictionary) and each.get("/S") == "/Figure"
        ]
    assert len(figures) == len(set(figures)) == 5
    assert all(len(words) > 20 for words in figures)
    assert kinds.count("/Table") >= 6
    assert kinds.count("/H1") == 1, "one valve body: everything is about it"


@pytest.mark.slow
@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("units", ["metric_bar", "us"])
def test_every_language_has_its_words_and_units(language: str, units: str) -> None:
    made, content, text = printed(language, units)
    say = wording(language, units)
    assert_rates_stand_there(made, text, say)
    for name in ("title", "section_pairs", "section_wear", "section_temperatures", "section_comparison"):
        assert plain(say(f"fleet_summary.{name}")) in text
    for kind in ("pressure", "distance", "temperature"):
        assert f"{say.unit(kind)}]" in text
    median = made.bodies[0].conditions[0].pressure_held_kpa
    assert median is not None
    assert say.value(median.median, "pressure", 0) in text
    assert content == write_summary_pdf(made, language=language, units=units)  # the same bytes


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_whatever_a_fleet_is_it_fits_eight_pages_within_their_edges(case: str) -> None:
    _, content = printed_case(case)
    assert b"<pdfuaid:part>1<" in content
    with pypdfium2.PdfDocument(content) as document:
        assert 1 < len(document) <= 8
        for page in document:
            width, height = page.get_size()
            written = page.get_textpage()
            for number in range(written.count_rects()):
                left, bottom, right, top = written.get_rect(number)
                assert left > 30.0
                assert right < width - 30.0
                assert bottom > 20.0
                assert top < height - 20.0


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_words_of_charts_and_tables_are_legible(case: str) -> None:
    from tests.unit.report.test_typography import LEAST, sizes

    _, content = printed_case(case)
    small = sorted({(page, round(size, 1)) for page, size, _ in sizes(content) if size < LEAST})
    assert small == []


@pytest.mark.slow
def test_valve_bodies_beyond_those_with_sections_stand_in_the_table_and_are_told() -> None:
    made, content = printed_case("many valve bodies, many groups")
    text, words = text_of(content), FleetWords(made, wording("en"))
    for body in made.bodies:
        assert words.body(body.controller) in text
    assert wording("en")("fleet_summary.beyond", count=len(made.bodies) - DETAILED, detailed=DETAILED) in text


@pytest.mark.slow
def test_what_is_not_known_is_said() -> None:
    say = wording("en")
    few = text_of(write_summary_pdf(summary(**CASES["no logs, no mileage, few units"])))
    for key in ("no_logs", "no_mileage", "rates_too_few", "wear_too_few"):
        assert say(f"fleet_summary.{key}") in few
    fine = text_of(write_summary_pdf(summary(**CASES["nothing flagged, one group"])))
    for key in ("no_pair_flagged", "none_flagged", "no_errors"):
        assert say(f"fleet_summary.{key}") in fine
    assert say("fleet_summary.one_group", by="supplier") in fine


def test_a_fleet_of_errors_alone_and_one_of_which_nothing_was_measured_can_be_printed() -> None:
    made, say = summary(units=3, groups=(), lands=3, logs=True), wording("en")
    alone = replace(made, bodies=(), worst=(), counts=unjudged(made.counts, 0), visits=0)
    text = text_of(write_summary_pdf(alone))
    assert say("fleet_summary.headline_none") in text
    assert made.errors[1].first[0][0] in text
    nothing = {"share_percent": None, "share_mean_percent": None, "pressure_kpa": None, "pressure_mean_kpa": None}
    body = replace(
        made.bodies[0],
        counts=unjudged(made.counts, 3),
        deciders=(),
        pairs=tuple(replace(pair, flagged=rate(0, 0), replace=rate(0, 0)) for pair in made.bodies[0].pairs),
        wear=tuple(replace(land, classes=(), latest_percent=None) for land in made.bodies[0].wear),
        temperatures=tuple(replace(each, **nothing, bands_percent=None) for each in made.bodies[0].temperatures),
    )
    unmeasured = replace(made, bodies=(body,), counts=body.counts, worst=())
    text = text_of(write_summary_pdf(unmeasured))
    assert say("fleet_summary.headline_unmeasured", count=3) in text
    assert say("fleet_summary.no_logs") in text
    assert say("fleet_summary.section_wear") not in text
    assert len(write_summary_workbook(unmeasured)) > 1000


def unjudged(counted: VerdictCounts, units: int) -> VerdictCounts:
    """The same with so many units, none of which has a verdict."""
    return replace(
        counted,
        units=units,
        verdicts={verdict: units * (verdict is Verdict.NOT_MEASURED) for verdict in Verdict},
        decisions={None: units},
        provisional=0,
        ok_in_part=0,
        rates={verdict: rate(0, 0) for verdict in FLAGGED},
    )


@pytest.mark.slow
@pytest.mark.parametrize("language", languages())
def test_one_unit_is_not_counted_as_several(language: str) -> None:
    said = {"en": "1 unit with a verdict; results: 1.", "de": "1 Gerät mit Befund; Ergebnisse: 1.",
            "pl": "1 egzemplarz z oceną; wyniki: 1."}  # fmt: skip
    bodies = ("five_speed_2005", "four_speed_2023")  # of one valve body alone the page's head says it
    text = text_of(write_summary_pdf(summary(bodies, units=1, groups=(), errors=False, lands=3), language=language))
    assert said[language] in text


@pytest.mark.parametrize("units", ["metric", "us"])
def test_numbers_of_mileage_do_not_run_into_one_another(units: str) -> None:
    made = summary(units=40, lands=1)
    of_each = made.bodies[0].wear[0].classes[:4]  # whose ends stand at the ends of the axis
    mile = 1.0 if units == "metric" else 1.609344
    limits = [(low * mile, (low + 5e3) * mile) for low in (100e3, 105e3, 110e3, 115e3)]
    classes = [replace(each, low_km=low, high_km=high) for each, (low, high) in zip(of_each, limits, strict=True)]
    charts = FleetCharts(FleetWords(made, wording("en", units)))
    small = [charts.wear(made.bodies[0], replace(made.bodies[0].wear[0], classes=classes))] * 2
    reaches = []
    with patch("atleak.report.charts.paper_axes.svg", side_effect=lambda figure: reaches.extend(_reaches(figure))):
        drawn_on_paper(small, wording("en", units))
    assert len(reaches) > 6
    assert all(left_end + 2.0 < right for (_, left_end), (right, _) in pairwise(sorted(reaches)))
    assert max(end for _, end in reaches) < WIDTH


def _reaches(figure: Figure) -> list[tuple[float, float]]:
    """Return from where to where numbers of mileage stand [pt]."""
    figure.canvas.draw()
    boxes = [
        label.get_window_extent() for axes in figure.axes for label in axes.get_xticklabels()
        if axes.get_xlim()[0] <= label.get_position()[0] <= axes.get_xlim()[1]
    ]  # fmt: skip
    return [(box.x0 * 72.0 / figure.dpi, box.x1 * 72.0 / figure.dpi) for box in boxes]


def test_names_that_look_like_markup_are_printed_as_they_are() -> None:
    names = ("#let x = 1", "*bold* $x$", "<svg/>&amp;")
    content = write_summary_pdf(summary(units=30, groups=names, lands=3))
    text = text_of(content)
    assert all(name in text for name in names)
    assert b"<pdfuaid:part>1<" in content


def test_names_keep_their_ends_where_they_are_shortened() -> None:
    names = [within_words(LONG.format(number), 36) for number in range(3)]
    assert [len(name) <= 36 for name in names] == [True] * 3
    assert len(set(names)) == 3
    assert within_words("short", 36) == "short"


def test_units_that_are_ok_in_part_are_not_green_on_paper() -> None:
    made, say = summary(), wording("en")
    counted = replace(unjudged(made.counts, 10), verdicts=dict.fromkeys(Verdict, 0) | {Verdict.OK: 10})
    charts = FleetCharts(FleetWords(made, say))
    whole, part = (
        drawn_on_paper(charts.verdicts([("all units", replace(counted, ok_in_part=in_part))]), say)
        for in_part in (0, 4)
    )
    assert OK_IN_PART.fill.lower() not in whole.lower()
    assert OK_IN_PART.fill.lower() in part.lower()
    assert ">6</text>" in part
    assert ">4</text>" in part


def test_time_in_green_of_units_measured_in_part_is_not_green_on_paper() -> None:
    made, say = summary(), wording("en")
    charts = FleetCharts(FleetWords(made, say))
    classes, partly = (
        [replace(each, green_in_part_percent=part) for each in made.bodies[0].temperatures] for part in (0.0, 10.0)
    )
    whole, part = (drawn_on_paper(charts.temperatures(given), say) for given in (classes, partly))
    assert OK_IN_PART.fill.lower() not in whole.lower()
    assert part.lower().count(OK_IN_PART.fill.lower()) == len(classes)
