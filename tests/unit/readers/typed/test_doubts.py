"""Slips are told at the cell in which they were made, and what cannot be a reading does not count."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.measurements.measuring_plan import PlanCell
from atleak.measurements.readings import Readings
from atleak.readers.typed_sheet import JudgedEntry, Typed, judge

WithTexts = Callable[[Mapping[PlanCell, str]], Typed]
PAIR = "pressure_regulator"  # its first land: ⌀ 15 mm, 18 µm when new


def at(part: str, direction: float = 0.0, repeat: int = 1, component: str = PAIR) -> PlanCell:
    return PlanCell(component, part, "1", direction, repeat)


def only(judged: JudgedEntry) -> tuple[PlanCell, str, bool]:
    ((cell, doubt),) = judged.doubts.items()
    return cell, doubt.text, doubt.counts


def test_careful_entries_raise_no_doubt_and_all_count(careful_entries: Typed, minimal: Controller) -> None:
    judged = judge(careful_entries, minimal)
    assert judged.doubts == {}
    assert set(judged.counting) == set(careful_entries.entries)
    assert all(state.status == "measured" for state in judged.states)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("150,01", "10 times the nominal one: a decimal point lost"),
        ("1,5001", "1/10 of the nominal one: a decimal point lost"),
        ("15001", "1000 times the nominal one"),
        ("0,5906", "1/25.4 of the nominal one: inch and millimetre mixed?"),
        ("7,5", "0.5 times the nominal one: a radius?"),
        ("15,O01", "not a number"),
        ("-15,001", "must be positive"),
    ],
)
def test_a_slip_is_told_at_its_cell_alone_and_does_not_count(
    with_texts: WithTexts, minimal: Controller, text: str, said: str
) -> None:
    typed = with_texts({at("spool", 90.0, 2): text})
    judged = judge(typed, minimal)
    cell, doubt, counts = only(judged)
    assert (cell, counts) == (at("spool", 90.0, 2), False)
    assert said in doubt
    assert set(judged.counting) == set(typed.entries) - {cell}


def test_every_entry_in_inches_is_doubted_for_itself(
    careful_texts: Mapping[PlanCell, str], minimal: Controller
) -> None:
    in_inches = {cell: f"{float(text.replace(',', '.')) / 25.4:.5f}" for cell, text in careful_texts.items()}
    judged = judge(Typed().fill(in_inches), minimal)
    assert set(judged.doubts) == set(in_inches)
    assert judged.counting == {}
    typed = replace(Typed().fill(in_inches), unit="inch")
    assert judge(typed, minimal).doubts == {}


def test_a_unit_behind_the_number_counts(with_texts: WithTexts, minimal: Controller) -> None:
    judged = judge(with_texts({at("spool"): "0,59055 in", at("spool", 0.0, 2): "15000 µm"}), minimal)
    assert judged.doubts == {}
    assert judged.counting[at("spool")].diameter == pytest.approx(15e-3, abs=1e-7)


def test_a_spool_typed_under_its_bore_is_told_there_and_the_land_does_not_count(
    with_texts: WithTexts, minimal: Controller
) -> None:
    judged = judge(with_texts({at("sleeve", 90.0, number): "14,990" for number in (1, 2)}), minimal)
    cell, text, counts = only(judged)
    assert (cell.part, cell.direction, counts) == ("sleeve", 90.0, False)
    assert "spool and sleeve swapped there?" in text
    assert "row" not in text
    assert judged.refused == {(PAIR, 1)}
    assert not any(each.component == PAIR and each.plane == "1" for each in judged.counting)
    assert sum(state.measured for state in judged.states) == len(minimal.lands) - 1


@pytest.mark.parametrize(
    ("text", "left_out", "apart"), [("14,992", 1, "8 µm"), ("15,0195", 2, "19.5 µm"), ("14,9705", 1, "29.5 µm")]
)
def test_of_repeats_that_disagree_the_one_that_does_not_count_is_told(
    with_texts: WithTexts, minimal: Controller, text: str, left_out: int, apart: str
) -> None:
    """Which of two is wrong nobody can say: the one that makes the pair widest counts until it is measured again."""
    typed = with_texts({at("spool"): "15,0000", at("spool", 0.0, 2): text})
    cell, said, _ = only(judge(typed, minimal))
    assert cell == at("spool", 0.0, left_out)
    assert f"repeats are {apart} apart" in said
    assert "measure again" in said
    assert judge(typed.put(cell, ""), minimal).doubts == {}


def test_a_diameter_of_another_land_is_doubted_and_counts(with_texts: WithTexts, minimal: Controller) -> None:
    """A nominal diameter can be representative: half a millimetre off is no proof of a slip."""
    cells = [PlanCell("accumulator", part, "1", angle, n) for part in ("spool", "sleeve") for angle in (0.0, 90.0)
             for n in (1, 2)]  # fmt: skip
    judged = judge(with_texts({cell: "18,700" if cell.part == "spool" else "18,740" for cell in cells}), minimal)
    assert set(judged.doubts) == set(cells)
    assert all("is it this land?" in doubt.text and doubt.counts for doubt in judged.doubts.values())


def test_half_a_land_is_no_doubt(careful_texts: Mapping[PlanCell, str], minimal: Controller) -> None:
    spools = {cell: text for cell, text in careful_texts.items() if cell.part == "spool"}
    judged = judge(Typed().fill(spools), minimal)
    assert judged.doubts == {}
    assert {state.status for state in judged.states} == {"spool_only"}


def test_a_dash_is_no_reading_and_no_doubt(with_texts: WithTexts, minimal: Controller) -> None:
    judged = judge(with_texts({at("spool"): "–"}), minimal)
    assert judged.doubts == {}
    assert at("spool") not in judged.counting


def test_a_land_that_only_the_temperature_makes_impossible_is_told_and_left_out(
    with_texts: WithTexts, minimal: Controller
) -> None:
    tight = {
        PlanCell("accumulator", part, "1", angle, number): size
        for part, size in (("spool", "18,0000"), ("sleeve", "18,0010"))
        for angle in (0.0, 90.0)
        for number in (1, 2)
    }
    typed = with_texts(tight)
    assert judge(typed, minimal).refused == frozenset()
    hot = judge(typed, minimal, temperature=45.0)
    assert hot.refused == {("accumulator", 1)}
    assert any("smaller" in doubt.text and not doubt.counts for doubt in hot.doubts.values())


def test_readings_at_unworn_ends_are_weighed_beside_what_is_typed(
    careful_entries: Typed, minimal: Controller, readings_of: Callable[..., Readings]
) -> None:
    sheet = judge(careful_entries, minimal).counting[at("sleeve")]
    unworn = replace(sheet, diameter=14.99e-3)
    base = Readings("a", "", None, "mm", False, "tidy", (), unworn=(unworn,))
    judged = judge(replace(careful_entries, sheet=base), minimal)
    assert judged.refused == {(PAIR, 1)}


@pytest.mark.parametrize("language", [each for each in languages() if each != "en"])
def test_no_english_word_stands_in_a_doubt_of_another_language(
    with_texts: WithTexts, minimal: Controller, language: str
) -> None:
    slips = ("150,01", "0,5906", "7,5", "15,O01", "-15,001", "14,992", "18,700 mm", "3 4")
    cells = [cell for cell in with_texts({}).entries if (cell.direction, cell.repeat) == (90.0, 2)]
    judged = judge(with_texts(dict(zip(cells, slips, strict=False))), minimal)
    assert len(judged.doubts) >= 7
    ids = re.compile("|".join(minimal.components))
    for doubt in judged.doubts.values():
        english, said = ids.sub("", doubt.text), ids.sub("", wording(language).sentence(doubt.text))
        both = set(re.findall(r"[^\W\d_]{2,}", english)) & set(re.findall(r"[^\W\d_]{2,}", said))
        assert both <= {"mm", "in"}, said
        assert not re.search(r"\d\.\d", said.replace("9.939", "")), "but for how a number may be typed"
