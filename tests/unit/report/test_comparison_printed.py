"""The page for the customer, read back: what was wrong, what was done, what it brought."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest

from atleak.analysis.changes import Comparison
from atleak.analysis.comparison import compare
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.examination import diagnose
from atleak.measurements.job_card import Job
from atleak.report.charts.comparison_figures import total_chart
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.pdf.comparison import write_comparison_pdf
from atleak.report.tables import comparison as comparison_words
from tests.unit.report.read_back import pages_of

BEFORE = Job(number="17", date="2026-03-02", customer={"name": "Łucja Example"}, complaint="Slips when hot.")
AFTER = Job(
    number="18",
    date="2026-03-09",
    workshop={"name": "Example Workshop"},
    repair_decisions=[
        {"component": "2", "land": 1, "work": "bore sleeved", "decision": "done"},
        {"component": "2", "land": 2, "work": "bore sleeved", "decision": "done"},
        {"component": "4", "land": 1, "work": "ream", "decision": "declined", "reason": "too dear"},
    ],
)


@pytest.fixture(scope="module")
def repaired(worn_clutch, three_circuits, hipol, limits, readings_of) -> Comparison:
    """The small valve body: both lands of the valve of clutch C1 repaired, component 4 found worn at both visits."""
    diagnoses = []
    for worn in ({("2", 1): 35e-6, ("2", 2): 35e-6, ("4", 1): 30e-6}, {("4", 1): 30e-6}):
        radial = {land.key: worn.get(land.key, land.new_clearance) for land in three_circuits.lands}
        sizes = {land.key: (land.nominal_diameter,) * 2 for land in three_circuits.lands}
        diameters = {key: (spool, sleeve + 2.0 * radial[key]) for key, (spool, sleeve) in sizes.items()}
        readings = replace(readings_of(three_circuits, diameters), sha256=f"{len(worn)}" * 64)
        diagnoses.append(diagnose(three_circuits, hipol, limits, readings=readings))
    return compare(*diagnoses)


@pytest.fixture(scope="module")
def printed(repaired: Comparison) -> Callable[[str], bytes]:
    """Gives the page in a language, printed once."""
    return cache(lambda language: write_comparison_pdf(repaired, BEFORE, AFTER, language=language))


def text_of(content: bytes) -> str:
    (page,) = pages_of(content)
    return re.sub(r"\s+", " ", page)


def test_a_caveat_of_one_visit_says_which_and_one_of_both_stands_once(
    repaired: Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, after = ["on clearances", "on lengths"], ["on clearances", "on the pump"]
    monkeypatch.setattr(
        comparison_words, "caveats", lambda diagnosis, _: before if diagnosis is repaired.before else after
    )
    said = comparison_words.visit_caveats(repaired, wording("de"))
    assert said == ["on clearances", "Vorher: on lengths", "Nachher: on the pump"]


@pytest.mark.parametrize("language", languages())
def test_one_page_says_what_was_wrong_done_and_brought(printed, repaired: Comparison, language: str) -> None:
    say, content = wording(language), printed(language)
    text = text_of(content)
    for name in ("title", "wrong", "done", "result", "pairs", "totals"):
        assert say(f"comparison.{name}") in text
    assert text.count(say("customer.seal")) == 1, "the sentence of the report's own first page"
    first, second = (each.verdict for each in (repaired.before, repaired.after))
    assert say.level(first).capitalize() in text
    assert say.level(second).capitalize() in text
    assert "bore sleeved" in text
    assert "too dear" in text
    share = repaired.leading.share
    for side in (share.before, share.after):
        assert say.percent(side).replace("\u00a0", " ") in text
    for land in repaired.changed:
        for side in (land.before, land.after):
            assert say.number(side.state.radial_clearance * 1e6, 1) in text
    assert say("comparison.uncertain") in text  # of component 4, which nobody touched
    for written in ("Łucja Example", "Example Workshop", "17", "18", say.date(dt.date(2026, 3, 9))):
        assert written in text
    assert b"<pdfaid:part>2<" in content
    assert b"<pdfuaid:part>1<" in content


def test_valves_have_their_names_in_the_reader_s_language(worn) -> None:
    text = text_of(write_comparison_pdf(compare(worn, worn), BEFORE, Job(), language="de"))
    named = {land.key[0] for land in worn.flagged[:3]}
    for name in (worn.controller.components[component] for component in named):
        assert wording("de").name(name) in text.replace("- ", "-").replace("\ufffe", "-")
        assert name not in text


def test_nothing_noted_as_done_is_said_instead_of_left_out(repaired: Comparison) -> None:
    content = write_comparison_pdf(repaired, BEFORE, Job())
    assert content == write_comparison_pdf(repaired, BEFORE, Job())  # the same jobs give the same bytes
    text, say = text_of(content), wording("en")
    assert say("comparison.done_none") in text
    valve = say.name(repaired.after.controller.components["2"])
    assert {land.key for land in repaired.changed} == {("2", 1), ("2", 2)}
    for noted, offered in ((Job(), (1, 2)), (AFTER, ()), (one_of(AFTER), (2,))):
        text = text_of(write_comparison_pdf(repaired, BEFORE, noted))
        pairs = "; ".join(say("comparison.land", name=valve, land=land) for land in offered)
        assert (say("comparison.done_measured", pairs=pairs) in text) == bool(offered)
        assert (say("comparison.done_measured", pairs="").rstrip(". ") in text) == bool(offered)


def one_of(job: Job) -> Job:
    """The same with the first of its works alone."""
    return job.model_copy(update={"repair_decisions": job.repair_decisions[:1]})


def test_many_flagged_pairs_stay_on_one_page_and_are_counted(worn) -> None:
    content = write_comparison_pdf(compare(worn, worn), BEFORE, AFTER)
    assert len(worn.flagged) > 12
    more = re.search(r"And (\d+) more\. Radial", text_of(content))
    assert more is not None
    assert len(worn.flagged) - 12 <= int(more[1]) < len(worn.flagged)


def test_bars_of_a_pump_that_delivers_nothing_can_be_drawn(repaired: Comparison) -> None:
    (first, *_) = repaired.on_both_sides
    dry = replace(first, before=replace(first.before, pump_capacity=0.0))
    drawn = drawn_on_paper(total_chart(repaired, [dry], wording("en")), wording("en"))
    assert f"{100.0 * first.alike.share:.1f} %" in drawn
