"""What a report shows an auditor: the rule and every decision, every reading, the budgets, who and when."""

from __future__ import annotations

import datetime as dt
import json
import re
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import pypdfium2
import pytest

from atleak.analysis.pressures import pressures_at
from atleak.catalogue.controller_file import load_controller
from atleak.common.translations import languages
from atleak.common.units import UM
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty.results import MOST_BUDGETS, budget_lines
from atleak.equations.statistics import normal_cdf
from atleak.measurements.job_card import Job
from atleak.report.pdf import write_pdf
from atleak.report.pdf.annex import Annex, Budget
from atleak.report.pdf.body import Body
from atleak.report.pdf.front import Front
from atleak.report.printed_names import PrintedNames

JOB = Job(
    number="2026-0417",
    date="2026-03-14",
    measured_on="2026-03-12",
    issued_on="2026-03-15",
    revision="2",
    replaces="revision 1",
    technician="B. Nowak",
    approved_by="K. Lis",
    vehicle={"registration": "KR 1234"},
)


def names_of(diagnosis: Diagnosis, job: Job = JOB, language: str = "en") -> PrintedNames:
    return PrintedNames(diagnosis, job, wording(language))


def of_kind(blocks: Any, kind: str) -> list[dict[str, Any]]:
    return [block for block in blocks if block and block["kind"] == kind]


def column(table: dict[str, Any], name: str) -> list[str]:
    at = next(number for number, each in enumerate(table["names"]) if each.lower().startswith(name.lower()))
    return [row[at] for row in table["rows"]]


def test_every_measured_land_stands_with_its_decision_the_good_ones_too(worn: Diagnosis) -> None:
    names = names_of(worn)
    (unit,), (lands,) = (of_kind(of(), "table") for of in (Annex(names).decisions, Annex(names).lands))
    decided = [land for land in worn.lands if land.decision is not None]
    assert len(worn.lands) > len(decided) > len(worn.flagged) > 0
    assert column(lands, "land") == [names.land_number(land) for land in worn.lands], "each in one table, once"
    words = [names.say.get("decisions", land.decision) if land.decision else "–" for land in worn.lands]
    assert column(lands, "decision") == words
    for number, at in enumerate(worn.presented, start=1):
        said = [cell["text"] if isinstance(cell, dict) else cell for cell in column(lands, f"share {number}")]
        drawn = [at.share_drawn_by(land.key) for land in worn.lands]
        leaks = [at.leakage_of(land.key) > 0.0 for land in worn.lands]
        wanted = [f"{each * 100.0:.2f}" if any_ else "–" for each, any_ in zip(drawn, leaks, strict=True)]
        assert said == wanted
    totals = [names.rule_name(rule) for rule in worn.total_rules]
    assert set(totals) <= set(column(unit, "rule"))
    first = column(unit, "decision")[column(unit, "rule").index(totals[0])]
    assert first == names.say.get("decisions", worn.uncertainty.totals[0].decision.decision)


@pytest.mark.parametrize("language", languages())
def test_rule_risk_and_expanded_uncertainty_are_said(worn: Diagnosis, language: str) -> None:
    texts = [block["text"] for block in of_kind(Annex(names_of(worn, language=language)).decisions(), "text")]
    said = " ".join(texts)
    assert "ISO/IEC 17025:2017, 7.8.6" in said
    assert wording(language).name(worn.limits.name) in said
    assert f"k = {wording(language).number(1.96, 2)}" in said
    assert wording(language).percent(float(normal_cdf(-worn.uncertainty.guard_factor)), 0) in said


def test_every_reading_is_printed_once_below_its_direction(worn: Diagnosis) -> None:
    (table,) = of_kind(Annex(names_of(worn)).readings(), "table")
    assert len(table["rows"]) == len({(each.component, each.plane) for each in worn.readings.readings})
    for direction in (0.0, 90.0):
        cells = [cell for part in ("sleeve", "spool") for cell in column(table, f"{part}\n{direction:g}°")]
        printed = [number for cell in cells for number in re.findall(r"\d+\.\d{4}", cell)]
        read = [each.diameter * 1e3 for each in worn.readings.readings if each.direction == direction]
        assert len(printed) == len(read) > len(cells) > 0
        assert sorted(map(float, printed)) == sorted(float(f"{each:.4f}") for each in read)


@pytest.mark.parametrize(("directions", "repeats"), [(2, 2), (4, 1), (4, 2), (3, 3), (6, 1)])
def test_all_rows_of_readings_are_of_one_height(worn: Diagnosis, directions: int, repeats: int) -> None:
    plane = [each for each in worn.readings.readings if each.direction == 0.0 and each.repeat == 1]
    readings = [
        replace(each, direction=30.0 * number, repeat=repeat)
        for each in plane
        for number in range(directions)
        for repeat in range(1, repeats + 1)
    ]
    again = replace(worn, readings=replace(worn.readings, readings=tuple(readings)))
    (table,) = of_kind(Annex(names_of(again)).readings(), "table")
    heights = {max(cell.count("\n") for cell in row) for row in table["rows"]}
    assert len(heights) == 1
    letters = sum(
        max(len(line) for cell in column for line in cell.split("\n")) for column in zip(*table["rows"], strict=True)
    )
    assert letters < 115 or directions > 4, "one line of 9 points holds no more"


@pytest.fixture(scope="module")
def long_names(hipol, limits, readings_of) -> Diagnosis:
    """A unit whose valves have long names and no numbers: two lands are worn, the others not measured."""
    controller = load_controller("five_speed_2005")
    lands = (controller.land("boost_valve", 1), controller.land("manual_valve", 3))
    worn = {land.key: (land.nominal_diameter, land.nominal_diameter + 90e-6) for land in lands}
    return diagnose(controller, hipol, limits, readings=readings_of(controller, worn))


def test_long_names_of_valves_stand_above_rows_of_one_height(hipol, limits, readings_of) -> None:
    small, valve = (
        load_controller("minimal_example"),
        "Leitungsdruck-Verstärkungsventil der Wandlerüberbrückungskupplung",
    )
    called = {name: f"Ventil {number}" if number else valve for number, name in enumerate(small.components)}
    controller = replace(small, components=MappingProxyType(called))
    as_new = {land.key: (land.nominal_diameter, land.nominal_diameter + 20e-6) for land in controller.lands}
    found = diagnose(controller, hipol, limits, readings=readings_of(controller, as_new))
    with pypdfium2.PdfDocument(write_pdf(found, JOB, sections=["readings"], language="de")) as document:
        written = "\n".join(page.get_textpage().get_text_bounded() for page in document)
        page = document[1].get_textpage()
        boxes = [page.get_rect(each) for each in range(page.count_rects())]
        said = ((box, page.get_text_bounded(*box).strip()) for box in boxes)
        rows = {round(box[1], 1) for box, word in said if re.match(r"\d+,\d{4}", word)}
    apart = [round(above - below, 1) for below, above in pairwise(sorted(rows))]
    row = min(apart)
    assert len(apart) >= 3
    assert [each for each in apart if abs(each - row) > 0.3 and abs(each - 2.0 * row) > 0.3] == [], "one line each"
    assert valve in written, "whole, and not broken"


@pytest.mark.parametrize("language", languages())
def test_every_name_on_paper_is_in_words_and_in_the_reader_s_language(long_names: Diagnosis, language: str) -> None:
    names = names_of(long_names, Job(repair_decisions=[{"component": "boost_valve", "decision": "declined"}]), language)
    say, controller = names.say, long_names.controller
    sections = Body(names, None, {}).parts(["repair", "conditions", "assumptions", "messages", "decisions"], "all")
    said = json.dumps([Front(names).facts(), sections], ensure_ascii=False)
    assert not re.search(r"[a-z]_(valve|um|part|mm3|per_k|engagement)", said), "no id of a file"
    assert say.name(controller.name) in said
    assert say.name(long_names.uncertainty.instruments.spool.name) in said
    for rule in long_names.pressure_rules_at(long_names.worst):
        if rule.circuit is not None:
            assert say.name(rule.circuit.name) in names.rule_name(rule)
            assert say.sentence(rule.quantity) in names.rule_name(rule), "as the workbook words it"


def test_the_totals_stand_with_every_condition_that_has_room(long_names: Diagnosis) -> None:
    names = names_of(long_names)
    totals = Front(names).verdict()["totals"]
    titles = [row[0] for row in totals["rows"]]
    assert titles == [names.say.condition(each.condition) for each in long_names.presented]
    assert len(titles) > len(long_names.reported)


def test_a_reading_that_does_not_count_stands_in_brackets(worn: Diagnosis) -> None:
    land = worn.lands[0]
    doubt = next((each for each in land.state.doubts), None)
    assert doubt is None
    readings = list(worn.readings.readings)
    third = replace(readings[0], repeat=3, diameter=readings[0].diameter + 30e-6)
    with_slip = replace(worn.readings, readings=(*readings, third))
    again = judged(worn, with_slip)
    (table,) = of_kind(Annex(names_of(again)).readings(), "table")
    part = readings[0].part
    rows = [place for place, each in enumerate(column(table, "part")) if each == part]
    cell = column(table, "0°")[rows[0]]
    assert f"({third.diameter * 1e3:.4f})" in cell
    assert column(table, "mean")[rows[0]] == of_mean(worn, part)


def judged(worn: Diagnosis, readings: Any) -> Diagnosis:
    return diagnose(worn.controller, worn.fluid, worn.limits, readings=readings)


def of_mean(worn: Diagnosis, part: str) -> str:
    (table,) = of_kind(Annex(names_of(worn)).readings(), "table")
    return column(table, f"{part}\nmean")[0]


def test_the_budget_of_every_flagged_land_adds_up_to_its_uncertainty(worn: Diagnosis) -> None:
    flagged = [land for land in worn.flagged if land.uncertainty.u_clearance][:MOST_BUDGETS]
    common, table = of_kind(Budget(names_of(worn)).blocks(), "table")
    assert len(flagged) > 1
    shared = list(map(float, column(common, "c · u(x)")))
    assert len(shared) > 2
    starts = [place for place, row in enumerate(table["rows"]) if len(row) == 1]
    assert len(starts) == len(flagged)
    for land, start, end in zip(flagged, starts, [*starts[1:], None], strict=True):
        (title,), *rows = table["rows"][start:end]
        own, whole = {**table, "rows": rows}, land.uncertainty.u_clearance * UM
        assert f"with u = {whole:.2f}\xa0µm" in title
        parts = [*map(float, column(own, "c · u(x)"))]
        assert sum(part**2 for part in (*shared, *parts)) ** 0.5 == pytest.approx(whole, abs=0.02)
        assert len(shared) + len(parts) == len(budget_lines(land.uncertainty.sources))
        share = sum(part**2 for part in parts) / whole**2
        assert sum(map(float, column(own, "part"))) == pytest.approx(100.0 * share, abs=2.0)


def test_dates_revision_and_who_are_told_apart_and_the_end_is_marked(worn: Diagnosis) -> None:
    content = write_pdf(worn, JOB, sections=["readings", "provenance"])
    with pypdfium2.PdfDocument(content) as document:
        pages = [page.get_textpage().get_text_bounded() for page in document]
        assert document.get_metadata_dict()["Title"] == "Internal leakage of a valve body · 2026-0417 · KR 1234"
        assert document.get_metadata_dict()["Creator"].startswith("atleak")
    text = "\n".join(pages)
    assert len(pages) > 1
    for said in (
        "Measured on",
        "2026-03-12",
        "Measured by",
        "B. Nowak",
        "Issued on",
        "2026-03-15",
        "Approved by",
        "K. Lis",
    ):
        assert said in text
    assert "revision 1" in text
    assert ["– End of report 2026-0417 · 2 –" in page for page in pages] == [*(False for _ in pages[1:]), True]
    assert content.count(b"<xmp:CreatorTool>atleak") == 1


def test_the_sheet_s_own_date_is_that_of_the_measurement_unless_the_record_has_one(worn: Diagnosis) -> None:
    dated = replace(worn, readings=replace(worn.readings, date=dt.date(2026, 2, 1)))
    for job, said in ((JOB, "2026-03-12"), (Job(), "2026-02-01")):
        (facts,) = of_kind(Annex(names_of(dated, job)).readings(), "facts")
        assert ["Measured on", said] in facts["rows"]
    (facts,) = of_kind(Annex(names_of(worn, Job())).readings(), "facts")
    assert ["Measured by", "not stated"] in facts["rows"]


@pytest.mark.parametrize("language", languages())
def test_what_was_decided_names_its_valve_in_the_reader_s_language(worn: Diagnosis, language: str) -> None:
    decisions = [{"component": "25", "land": 1, "work": "ream"}, {"component": "unknown", "work": "clean"}]
    names = names_of(worn, Job(repair_decisions=decisions), language)
    (section,) = Body(names, None, {}).parts(["repair"], "all")[0]["sections"]
    (table,) = of_kind(section["blocks"], "table")
    valve = names.say.name(worn.controller.components["25"])
    assert [row[0] for row in table["rows"]] == [f"25 {valve}, {names.say('printed.land')}\u00a01", "unknown"]


def test_a_loss_that_may_be_far_more_but_hardly_less_has_its_interval_instead_of_u(worn_clutch: Diagnosis) -> None:
    (unit, *_) = of_kind(Annex(names_of(worn_clutch)).decisions(), "table")
    known = [decision for rule in worn_clutch.unit_rules if (decision := worn_clutch.decided(rule)) is not None]
    decided = [each for each in known if each.value or each.probability_over_limit or any(each.interval or ())]
    (text,) = (block["text"] for block in of_kind(Annex(names_of(worn_clutch)).decisions(), "text") if block["small"])
    assert wording("en")("annex.left_out", count=len(known) - len(decided)) in text
    assert len(known) > len(decided)
    shown = [row[unit["names"].index(wording("en")("annex.u_or_interval"))] for row in unit["rows"]]
    assert len(shown) == len(decided)
    skewed = [each for each in decided if each.skewed]
    assert skewed
    for each, said in zip(decided, shown, strict=True):
        assert ("–" in said and said != "–") == each.skewed


def test_main_pressure_has_the_interval_by_which_it_is_judged(worn: Diagnosis) -> None:
    """What is required is required: where it is held, neither the interval nor u is more than nothing."""
    for point in worn.projections:
        at = pressures_at(worn, point)
        assert not at.projection.pressure_falls
        required = point.condition.main_pressure
        assert at.line.interval[1] == pytest.approx(required, rel=1e-9, abs=0.0)
        may_fall = at.line.interval[0] < required * (1.0 - 1e-9)
        assert may_fall == (at.line.decided.standard_uncertainty > 0.03)
