"""The lines and sums of an estimate, what the engine says of them, and who shows it."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from typing import Any

import openpyxl
import pytest

from atleak.analysis.estimate import Estimate, estimate, with_line
from atleak.analysis.record_doubts import check_decisions, undecided
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import Repair
from atleak.common.errors import InputError
from atleak.common.wording import begun, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import project
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings
from atleak.report.pdf.body import Body
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.estimate import EstimateWords, open_words
from atleak.report.xlsx import write_workbook

PR, ACC = "pressure_regulator", "accumulator"
SLEEVE = Repair(
    "sleeve", ((PR, 1),), "sleeve", "bore sleeved", "made up",
    part_number="MADE-UP-1", price=10.005, currency="EUR", hours=1.15,
)  # fmt: skip
CASTING = Repair("casting", ((ACC, 1),), "new_casting", "new casting", "made up", price=400.0, currency="USD")
WORN = {(PR, 1): 1.5, (PR, 2): 1.2, (ACC, 1): 1.8}


@pytest.fixture(scope="module")
def unit(minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> Any:
    """Diagnoses the minimal example with some of its lands worn and two repairs in its file."""
    controller = replace(minimal, repairs=(SLEEVE, CASTING))

    def build(growth: dict[tuple[str, int], float]) -> Diagnosis:
        sizes = {key: controller.land(*key) for key in growth}
        diameters = {
            key: (land.nominal_diameter, land.nominal_diameter + 2.0 * (1.0 + growth[key]) * land.mounting_high)
            for key, land in sizes.items()
        }
        return diagnose(controller, hipol, limits, readings=readings_of(controller, diameters))

    return build


@pytest.fixture(scope="module")
def worn(unit: Any) -> Diagnosis:
    diagnosis: Diagnosis = unit(WORN)
    assert {land.key for land in diagnosis.flagged} == set(WORN)
    return diagnosis


def line_of(made: Estimate, key: str) -> Any:
    return next(line for line in made.lines if line.key == key)


def test_every_flagged_land_starts_as_proposed_and_follows_the_measurement_until_it_is_touched(
    unit: Any, worn: Diagnosis
) -> None:
    made = estimate(worn, Job())
    assert {line.key: (line.decision.decision, line.own) for line in made.lines} == {
        "sleeve": ("proposed", False),
        f"{PR}/2": ("proposed", False),
        "casting": ("proposed", False),
    }
    job = with_line(Job(), line_of(made, f"{PR}/2"), decision="approved", price=20.0)
    again = unit({(PR, 1): 1.5, (PR, 2): 0.0, (ACC, 1): 0.0})
    followed = estimate(again, job)
    assert {line.key: line.decision.decision for line in followed.lines} == {
        "sleeve": "proposed",
        f"{PR}/2": "approved",
    }
    assert line_of(followed, f"{PR}/2").own
    job = with_line(job, line_of(followed, f"{PR}/2"), decision="declined", reason="too dear")
    assert [each.decision for each in job.repair_decisions] == ["declined"]


def test_amounts_are_rounded_half_up_and_what_is_unknown_is_named_and_in_no_sum(worn: Diagnosis) -> None:
    """10.005 EUR and 1.15 h at 43.50 EUR/h: 10.01 and 50.03; 23 % of 60.04 is 13.8092."""
    job = Job(estimate={"currency": "EUR", "labour_rate": "43,50", "tax_percent": 23})
    made = estimate(worn, job)
    sleeve = line_of(made, "sleeve")
    assert (sleeve.part, sleeve.work) == (Decimal("10.01"), Decimal("50.03"))
    total = made.total
    assert (total.parts, total.work, total.net) == (Decimal("10.01"), Decimal("50.03"), Decimal("60.04"))
    assert (total.tax, total.gross) == (Decimal("13.81"), Decimal("73.85"))
    assert {line.key for line in total.without_price} == {f"{PR}/2", "casting"}
    words = EstimateWords(made, wording("en"))
    said = " ".join(words.missing())
    assert "Price and hours or labour rate unknown, in no sum" in said
    assert "accumulator piston/1" in said
    assert "the file's price is in USD" in said
    assert words.sum_row("all", total)[1:3] == ("≥ 10.01", "≥ 50.03")
    declined = with_line(job, line_of(made, f"{PR}/2"), decision="declined")
    apart = estimate(worn, declined)
    assert apart.sums["declined"].net is None
    said = " ".join(open_words(worn, declined, wording("en"), closing=True))
    assert "Declined, and no reason is given: pressure regulator valve/2." in said
    yen = estimate(worn, Job(estimate={"currency": "JPY"}, repair_decisions=[{"component": ACC, "price": 1200.5}]))
    assert line_of(yen, ACC).part == Decimal("1201")


def test_a_currency_is_the_files_whether_its_code_is_typed_in_capitals_or_not(worn: Diagnosis) -> None:
    job = Job(estimate={"currency": " eur"})
    assert line_of(estimate(worn, job), "sleeve").part == Decimal("10.01")
    assert Job(estimate={"currency": "zł"}).estimate.currency == "zł"


def test_what_stays_past_a_limit_without_a_line_is_what_the_engine_computes(worn: Diagnosis) -> None:
    made = estimate(worn, Job())
    assert made.past == ()
    for line in made.lines:
        others = {key: state for each in made.lines if each is not line for key, state in each.states.items()}
        states = tuple(others.get(land.key, land.state) for land in worn.lands)
        model = LeakageModel(worn.controller, states, worn.fluid, worn.profile)
        past = [
            replace(rule, value=project(model, at.condition).share, reached=None if others else rule.reached)
            for rule, at in zip(worn.total_rules, worn.projections, strict=True)
        ]
        by_engine = [(rule.condition, rule.level) for rule in past if rule.verdict.flagged]
        totals = [rule for rule in made.stays_past(line) if rule.kind.is_share]
        assert [(rule.condition, rule.level) for rule in totals] == by_engine
        gain = made.gain_of(line)
        assert gain is not None
        job = with_line(Job(), line, decision="declined", reason="later")
        left = estimate(worn, job)
        assert left.past == made.stays_past(line)
        assert {land.key for land in left.lands_past} == set(line.states)
        assert left.gain_of(line_of(left, line.key)) == gain


def test_a_goal_has_no_need_of_every_flagged_land_and_says_so(unit: Any) -> None:
    diagnosis = unit({(PR, 1): 1.5, (PR, 2): 0.0, ("tcc_regulator", 1): 0.6})
    everything = estimate(diagnosis, Job())
    made = estimate(diagnosis, Job(estimate={"goal": "green"}))
    assert {line.key for line in made.lines} == {line.key for line in everything.lines}
    open_ones = [line for line in made.lines if line.decision.decision is None]
    assert open_ones
    assert all(not line.chosen and not line.carried_out for line in open_ones)
    assert made.past == ()
    assert {land.key for land in made.lands_past} == {key for line in open_ones for key in line.states}
    assert all(line.chosen for line in everything.lines)


def test_a_flagged_land_that_is_only_cleaned_stays_past_its_limit(worn: Diagnosis) -> None:
    clean = Repair("clean", ((PR, 1), (PR, 2)), "clean_and_reuse", "clean and reuse", "made up")
    diagnosis = replace(worn, controller=replace(worn.controller, repairs=(*worn.controller.repairs, clean)))
    cleaned = Job(repair_decisions=[{"component": PR, "repair": "clean", "decision": "done"}])
    assert {land.key for land in estimate(diagnosis, cleaned).lands_past} == {(PR, 1), (PR, 2)}


def test_a_land_to_be_replaced_without_a_decision_is_pointed_out(worn: Diagnosis) -> None:
    to_replace = {land.key for land in worn.flagged if land.verdict.calls_for_repair}
    assert len(to_replace) > 1
    assert {land.key for land in undecided(worn, Job())} == to_replace
    proposed = Job(repair_decisions=[{"component": PR, "decision": "proposed"}])
    assert {land.key for land in undecided(worn, proposed)} == {key for key in to_replace if key[0] != PR}
    assert {land.key for land in undecided(worn, proposed, closing=True)} == to_replace
    by_repair = Job(repair_decisions=[{"repair": "casting", "decision": "deferred"}])
    assert (ACC, 1) not in {land.key for land in undecided(worn, by_repair, closing=True)}


@pytest.mark.parametrize(
    ("decision", "said"),
    [
        ({"component": "presure_regulator"}, "pressure_regulator"),
        ({"component": PR, "land": 7}, "one of its lands: 1, 2"),
        ({"component": PR, "repair": "sleve"}, "sleeve"),
        ({"component": ACC, "repair": "sleeve"}, f"component {PR}"),
        ({"land": 2}, "the component that it belongs to"),
    ],
)
def test_a_decision_on_what_the_valve_body_lacks_is_refused_by_name(
    decision: dict[str, Any], said: str, worn: Diagnosis
) -> None:
    check_decisions(Job(repair_decisions=[{"work": "cleaned"}]), worn.controller)
    job = Job(repair_decisions=[{"component": PR, "land": 1}, decision])
    with pytest.raises(InputError) as caught:
        check_decisions(job, worn.controller, "job.toml")
    assert "job.toml" in str(caught.value)
    assert "repair_decisions 2" in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize("language", ["de", "en", "pl"])
def test_the_report_prints_lines_boxes_and_sums_only_where_an_estimate_was_filled_in(
    language: str, worn: Diagnosis
) -> None:
    say = wording(language)

    def sections(job: Job) -> dict[str, list[dict[str, Any]]]:
        body = Body(PrintedNames(worn, job, say), None, {})
        return {each["name"]: each["blocks"] for each in body.parts(["repair", "estimate"], "all")[0]["sections"]}

    bare = sections(Job())
    assert "estimate" not in bare
    assert bare["repair"][0]["text"].startswith(say("estimate.undecided", lands="").split(":")[0])
    job = Job(
        estimate={"currency": "EUR", "labour_rate": 43.5},
        repair_decisions=[{"component": PR, "repair": "sleeve", "decision": "approved"}],
    )
    lines, sums = (block for block in sections(job)["estimate"] if block["kind"] == "table")
    agreed = [row[-1] for row in lines["rows"]]
    assert lines["names"][-2] == begun(say("printed.lacks"))
    assert all("%" in row[-2] and "¹" in row[-2] for row in lines["rows"])
    assert sorted(map(str, agreed)) == sorted(
        [say("job_decisions.approved"), *2 * [str({"boxes": [say("estimate.yes"), say("estimate.no")]})]]
    )
    assert say.number(10.01, 2) in [cell for row in lines["rows"] for cell in row]
    assert sums["rows"][-1][0] == say("estimate.all_due")


def sheet_of(book: Any) -> tuple[list[list[Any]], dict[str, tuple[int, int]]]:
    """The cells of the estimate, and where its inputs stand."""
    rows = [[cell.value for cell in row] for row in book["Estimate"]]
    first = {str(row[0]): number for number, row in enumerate(rows, start=1)}
    of_line = next(number for number, row in enumerate(rows, start=1) if row[1] == "bore sleeved")
    places = {"price": (of_line, 4), "hours": (of_line, 5)}
    return rows, places | {"rate": (first["labour rate per hour"], 4), "tax": (first["tax [%]"], 4)}


@pytest.mark.slow
@pytest.mark.parametrize("change", [{}, {"price": 99.995}, {"hours": 2.25}, {"tax": 7.0}, {"rate": 61.2}])
def test_what_is_changed_in_the_workbook_s_estimate_gives_the_sums_that_atleak_gives(
    worn: Diagnosis, change: dict[str, float], recalculated: Any
) -> None:
    terms = {"currency": "EUR", "labour_rate": 43.5, "tax_percent": 19.0}
    own = {"component": PR, "work": "bore sleeved", "price": 10.0, "hours": 1.15, "decision": "approved"}
    other = {"component": ACC, "work": "new piston", "hours": 0.5, "price": 12.3, "decision": "proposed"}
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(worn, Job(estimate=terms, repair_decisions=[own, other]))))
    cells, places = sheet_of(book)
    for name, value in change.items():
        book["Estimate"].cell(*places[name]).value = value
    value = recalculated(book)
    line = own | {name: value for name, value in change.items() if name in ("price", "hours")}
    names = {"rate": "labour_rate", "tax": "tax_percent"}
    stated = terms | {names[name]: value for name, value in change.items() if name in names}
    expected = Job(estimate=stated, repair_decisions=[line, other])
    wanted, _ = sheet_of(openpyxl.load_workbook(io.BytesIO(write_workbook(worn, expected)), data_only=True))
    formulas = [
        (row, column)
        for row, each in enumerate(cells, start=1)
        for column, cell in enumerate(each, start=1)
        if str(cell).startswith("=")
    ]
    assert len(formulas) >= 2 * 2 + 3 * 6
    for row, column in formulas:
        found = value("Estimate", f"{openpyxl.utils.get_column_letter(column)}{row}")
        asked = wanted[row - 1][column - 1]
        assert found == (asked or "") if isinstance(asked, str | None) else found == pytest.approx(asked, abs=1e-9)


def test_workbook_and_table_hold_the_same_lines_and_sums(worn: Diagnosis) -> None:
    job = Job(
        estimate={"currency": "EUR", "labour_rate": 43.5},
        repair_decisions=[{"component": PR, "land": 2, "work": "=1+1"}],
    )
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(worn, job)), data_only=True)
    cells = [[cell.value for cell in row] for row in book["Estimate"]]
    assert next(row for row in cells if row[2] == "MADE-UP-1")[3:7] == [10.01, 1.15, 50.03, 60.04]
    assert "Estimate" not in openpyxl.load_workbook(io.BytesIO(write_workbook(worn, Job(number="1")))).sheetnames
    text = EstimateWords(estimate(worn, job), wording("en")).csv().decode("utf-8-sig")
    rows = list(csv.reader(io.StringIO(text)))
    sleeve = next(row for row in rows if "MADE-UP-1" in row)
    assert sleeve[5:9] == ["10.01", "1.15", "50.03", "EUR"]
    assert any("'=1+1" in row for row in rows)  # no formula for a spreadsheet
