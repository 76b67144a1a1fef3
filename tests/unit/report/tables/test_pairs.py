"""Tables of lands, the opened pair and the effect of repairs, in words and units of the reader."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from atleak.analysis.estimate import estimate, with_repairs
from atleak.analysis.repair.choice import OfferedRepairs
from atleak.catalogue.controller_file import load_controller
from atleak.common.style import LOOKS
from atleak.common.translations import languages
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.charts.drawing import component_svgs
from atleak.report.tables.estimate import EstimateWords
from atleak.report.tables.lands import (
    ON_PAPER,
    clearance,
    component_verdict,
    components_worst_first,
    opened_lands,
    pair_table,
)
from atleak.report.tables.repairs import effect_table, offered_words

EN = wording("en")
SVG = "{http://www.w3.org/2000/svg}"


def test_each_flagged_land_stands_with_its_share_at_every_condition_that_reports_show(worn: Diagnosis) -> None:
    table = pair_table(worn, worn.flagged, EN)
    assert len(table.headings) == len(set(table.headings)), "every column has words"
    table = table.without(*ON_PAPER)
    shown = [f"Share, {each.condition.label}" for each in worn.reported]
    others = ["Clearance [µm]", "Wear [%]", "Consequence", "Decided by", "Decision"]
    assert list(table.headings) == ["Verdict", "Pair", *shown, *others]
    assert list(table.rows) == list(worn.flagged)
    for land in worn.flagged:
        verdict, pair, *texts = table.texts(land)
        assert verdict == EN.signed(land.verdict)
        assert pair.startswith(f"{land.key[0]}/{land.key[1]} ")
        for at, column, text in zip(worn.reported, table.columns[2:], texts, strict=False):
            if at.leakage_of(land.key) > 0.0:
                assert text == f"{EN.number(at.share_drawn_by(land.key) * PERCENT, 2)}\u00a0%"
            else:
                assert (text, column.judged(land).level) == ("–", None)


def test_a_share_stands_in_the_colour_of_its_own_verdict_not_of_the_land(worn: Diagnosis) -> None:
    verdict, _, *others = pair_table(worn, worn.flagged, EN).without(*ON_PAPER).columns
    shares = others[: len(worn.reported)]
    own = {(verdict.judged(land).level, share.judged(land).level) for land in worn.flagged for share in shares}
    assert (Verdict.REPLACE, Verdict.OK) in own


@pytest.mark.parametrize("units", ["metric", "us"])
def test_the_opened_pair_shows_clearance_ovality_shares_and_limits_in_the_readers_units(
    worn: Diagnosis, units: str
) -> None:
    say = wording("en", units)
    component = worn.flagged[0].key[0]
    opened = opened_lands(worn, component, say)
    assert [each.land.key for each in opened] == [land.key for land in worn.controller.lands_of(component)]
    first = next(each for each in opened if each.land.verdict.flagged)
    facts = dict(first.facts)
    state = first.land.state
    assert facts["Radial clearance, 95 %"].startswith(say.quantity(state.radial_clearance * UM, "clearance"))
    assert facts["Ovality of the bore"] == say.quantity((state.sleeve_ovality or 0.0) * UM, "clearance")
    shown = [first.shares.texts(row)[0] for row in first.shares.rows]
    assert shown == [say.condition(each.condition) for each in worn.presented]
    assert first.rules.columns[1].judged(first.rules.rows[0]).level == first.land.verdict
    assert first.why[0].startswith(EN(f"rules.{first.land.deciding.kind}"))  # type: ignore[union-attr]


def test_the_opened_pair_says_which_complaints_it_can_cause_and_where_it_leaks(worn: Diagnosis) -> None:
    (first, *_) = opened_lands(worn, worn.flagged[0].key[0], EN)
    leaking = {at.condition.name for at in worn.projections if at.leakage_of(first.land.key) > 0.0}
    causes = [
        each.label
        for each in worn.controller.complaints
        if first.land.key in each.lands or (not each.lands and leaking & set(each.conditions))
    ]
    assert causes
    assert [line for line in first.does if line.startswith("can cause")] == [f"can cause: {each}" for each in causes]
    assert any(line.startswith("leaks from ") for line in first.does)


def test_a_component_with_a_land_that_was_not_measured_is_not_ok(worn: Diagnosis) -> None:
    last = worn.controller.lands[-1].key[0]
    assert component_verdict(worn, last) == Verdict.NOT_MEASURED or any(
        land.verdict.flagged for land in worn.lands if land.key[0] == last
    )
    order = components_worst_first(worn)
    assert order[0] == worn.flagged[0].key[0]
    assert len(order) == len(set(order)) == len({land.key[0] for land in worn.lands})


def test_every_component_is_drawn_by_itself_in_the_shade_of_its_lands():
    controller = load_controller("four_speed_2023")
    key = controller.lands[0].key
    drawings = component_svgs(controller, {key: Verdict.CRITICAL})
    assert list(drawings) == [name for name in controller.components if controller.lands_of(name)]
    fills = {
        name: [each.attrib["fill"] for each in ElementTree.fromstring(svg).iter(f"{SVG}rect")]
        for name, svg in drawings.items()
    }
    assert [name for name, found in fills.items() if LOOKS[Verdict.CRITICAL].fill in found] == [key[0]]
    for svg in drawings.values():
        width = float(ElementTree.fromstring(svg).attrib["width"])
        for rectangle in ElementTree.fromstring(svg).iter(f"{SVG}rect"):
            assert float(rectangle.attrib["x"]) >= 0.0
            assert float(rectangle.attrib["x"]) + float(rectangle.attrib["width"]) <= width


@pytest.mark.parametrize("language", languages())
def test_what_ticked_repairs_bring_is_said_at_every_condition(worn: Diagnosis, language: str) -> None:
    say, repairs = wording(language), OfferedRepairs(worn)
    keys = {each.key for each in repairs.all if each.called_for}
    none, made = (estimate(worn, with_repairs(repairs, Job(), each)) for each in ((), keys))
    table = effect_table(made.effect, say)
    for at in made.effect:
        condition, before, after, *_ = table.texts(at)
        assert condition == say.condition(at.condition)
        assert before == f"{say.percent(at.before.share)} {say.signed(at.before.band)}"
        assert after == f"{say.percent(at.after.share)} {say.signed(at.after.band)}"
    assert not any("{" in sentence for sentence in EstimateWords(made, say).ends())
    left = list(EstimateWords(none, say).ends())
    assert all(f"{land.key[0]}/{land.key[1]}" in left[-1] for land in worn.flagged)


def test_an_offered_repair_says_its_land_and_what_it_brings_alone(worn: Diagnosis) -> None:
    first = OfferedRepairs(worn).all[0]
    words = offered_words(worn, first, EN)
    assert words.startswith(f"{EN.signed(first.lands[0].verdict)} · {first.lands[0].key[0]}/{first.lands[0].key[1]} ")
    at = first.best_at
    assert f"{EN.percent(at.before.share, 2)} → {EN.percent(at.after.share, 2)}" in words


def test_a_clearance_and_its_interval_stand_in_the_same_unit(worn: Diagnosis) -> None:
    """In inches as US readers have a single clearance, not in tenths of a thousandth beside inches."""
    land = next(each for each in worn.flagged if each.uncertainty is not None)
    said = clearance(land, wording("en", "us"))
    value, low, high = (float(number) for number in re.findall(r"\d+\.\d+", said))
    assert low < value < high
    assert value == pytest.approx(land.state.radial_clearance / 0.0254, abs=5e-6)
