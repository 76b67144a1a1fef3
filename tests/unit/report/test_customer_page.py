"""The first page of the printed report: what a customer who repairs no cars can read off it, whatever was typed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pypdfium2
import pytest

from atleak.catalogue.controller_reading import load_controller
from atleak.catalogue.section_pressures import Pressure
from atleak.diagnosis import Diagnosis, diagnose
from atleak.job.case import Case, SourceFile
from atleak.job.record import Job
from atleak.readings import Reading, Readings
from atleak.repair import plan_repairs
from atleak.report.pdf import write_pdf
from atleak.report.pdf.customer import CustomerPage, digits_apart
from atleak.report.pdf.printed_names import PrintedNames
from atleak.verdicts import Band, Verdict
from atleak.views.diagnosis_record import diagnosis_record
from atleak.views.worn_valves import WORTH_SAYING, End, part_of_leakage, worn_valves
from atleak.wording import languages, wording

SIGNED = ("signatures",)
LONG = " ".join(["Once it is hot it waits at the lights before it moves, and then it goes with a jerk."] * 24)
ESTIMATE = {"currency": "EUR", "labour_rate": 80.0, "tax_percent": 23.0}


def pages_of(content: bytes) -> list[str]:
    with pypdfium2.PdfDocument(content) as document:
        return [re.sub(r"\s+", " ", page.get_textpage().get_text_range()) for page in document]


def worn_everywhere(name: str, fluid, limits, *, clearances: float = 3.0) -> Diagnosis:
    """Every land of a valve body so many times as wide as when new."""
    controller = load_controller(name)
    readings = [
        Reading(land.component, part, land.planes[0], direction, 1, diameter)
        for land in controller.lands
        for part, diameter in (
            ("spool", land.nominal_diameter),
            ("sleeve", land.nominal_diameter + 2.0 * clearances * land.mounting_high),
        )
        for direction in (0.0, 90.0)
    ]
    sheet = Readings("sheet.xlsx", "0" * 64, "readings", "mm", False, "tidy", tuple(readings))
    return diagnose(controller, fluid, limits, readings=sheet, complaint=controller.complaint("slips_hot"))


@pytest.fixture(scope="module")
def all_worn(hipol, limits) -> Callable[[str], Diagnosis]:
    return cache(lambda name: worn_everywhere(name, hipol, limits))


@pytest.mark.parametrize("language", languages())
def test_the_first_page_says_what_is_wrong_how_bad_it_is_and_what_to_do(worn, language):
    say, plan = wording(language), plan_repairs(worn)
    complaint = worn.controller.complaint("slips_hot")
    job = Job(complaint="It waits at the lights.", customer={"name": "A. Customer"})
    first, *_ = pages_of(write_pdf(replace(worn, complaint=complaint), job, language=language, sections=SIGNED))
    valves = worn_valves(worn, plan.choice)
    brought = valves[0].brings(worn.worst)
    said = [
        say(f"customer.{worn.verdict}"),
        say(f"customer.urgent_{worn.verdict}"),
        "It waits at the lights.",
        say.percent(worn.worst.share),
        say.name(worn.controller.components[valves[0].component]),
        say.name(complaint.label),
        say.percent(brought.after.share),
        say("texts.sign_customer"),
    ]
    assert [words for words in said if words.replace("\u00a0", " ") not in first] == []
    assert first.index(say(f"customer.{worn.verdict}")) < first.index("It waits at the lights.")


def test_a_complaint_of_400_words_leaves_the_first_page_one_page_and_stands_whole_in_the_annex(worn):
    assert len(LONG.split()) > 400
    first, *annex = pages_of(write_pdf(worn, Job(complaint=LONG), sections=SIGNED))
    say = wording("en")
    assert say("customer.replace") in first
    assert say("texts.sign_customer") in first
    assert LONG not in first
    assert LONG in annex[0]
    assert say("customer.annex") in annex[0]


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["gm_4l60e", "five_speed_2005"])
@pytest.mark.parametrize("language", languages())
def test_many_worn_valves_a_long_complaint_and_an_estimate_stay_on_one_page(all_worn, controller, language):
    job = Job(
        complaint=LONG,
        estimate=ESTIMATE,
        workshop={"name": "Łódź Automaty", "address": "Long Street 12\n00-001 Town", "phone": "1", "email": "a@b"},
    )
    content = write_pdf(all_worn(controller), job, language=language, paper="letter", sections=SIGNED)
    first, annex, *_ = pages_of(content)
    say = wording(language)
    assert say("texts.sign_customer") in first
    assert say("estimate.yes") in first
    assert say("customer.annex") in annex


def test_lines_of_the_estimate_have_a_price_and_boxes_to_agree_on_the_first_page(worn):
    component, land = worn.flagged[0].key
    work = {"component": component, "land": land, "work": "ream", "price": 180.0, "hours": 2.0, "decision": "proposed"}
    first = pages_of(write_pdf(worn, Job(estimate=ESTIMATE, repair_decisions=[work]), sections=SIGNED))[0]
    say = wording("en")
    assert "ream 340.00 yes no" in first
    assert say("customer.sum_with_tax", amount="≥ 418.20", currency="EUR", tax="78.20") in first
    assert say("customer.cost") not in pages_of(write_pdf(worn, sections=SIGNED))[0]


@pytest.mark.slow
def test_the_pressure_that_a_worn_valve_takes_is_said_where_circuits_are_described(all_worn):
    found = all_worn("five_speed_2005")
    first = pages_of(write_pdf(found, sections=SIGNED))[0]
    valves = worn_valves(found, plan_repairs(found).choice)
    costs = [(held, loss) for valve in valves for held, loss in valve.costs]
    assert costs
    assert re.search(r"By calculation the pressure at “.+?” is [\d ]+ instead of [\d ]+ kPa", first)


def test_a_complaint_is_named_for_a_valve_only_where_it_carries_a_part_of_what_leaks(worn):
    for valve in worn_valves(worn, plan_repairs(worn).choice):
        keys = {land.key for land in valve.lands}
        for complaint in worn.controller.complaints:
            parts = [part_of_leakage(keys, each) for each in worn.complained_of(complaint)]
            assert (max(parts) >= WORTH_SAYING) == (complaint in valve.complaints)


def test_what_one_valve_brings_alone_is_what_the_engine_says_with_its_lands_repaired(worn):
    choice = plan_repairs(worn).choice
    for valve in worn_valves(worn, choice):
        mine = [move for move in choice.chosen if any(key[0] == valve.component for key in move.treats)]
        (totals,) = choice.totals_of([mine])
        assert [each.after.share for each in valve.alone] == [total.share for total in totals]
        assert valve.brings(worn.worst).before.share == pytest.approx(worn.worst.share, abs=1e-12)


@pytest.mark.parametrize("name", ["unmeasured", "within"])
def test_a_unit_without_worn_valves_has_a_first_page_without_them(unmeasured, hipol, limits, name):
    found = unmeasured if name == "unmeasured" else worn_everywhere("minimal_example", hipol, limits, clearances=1.0)
    assert not found.flagged
    first = pages_of(write_pdf(found, sections=SIGNED))[0]
    say = wording("en")
    verdict = Verdict.NOT_MEASURED if name == "unmeasured" else found.verdict
    assert say(f"customer.{verdict}") in first
    assert say("customer.valves") not in first


@pytest.mark.parametrize("beside_a_sheet", [False, True])
@pytest.mark.parametrize(("drive", "verdict"), [(350.0, Verdict.REPLACE), (200.0, Verdict.CRITICAL)])
def test_a_limit_that_gauges_alone_show_passed_calls_no_valve_body_worn(hipol, limits, drive, verdict, beside_a_sheet):
    table = SourceFile("gauges.csv", f"range;slow idle [kPa]\nD;{drive}\n".encode())
    found = Case(pressures=table).diagnose()
    if beside_a_sheet:
        sheet = worn_everywhere("four_speed_2023", hipol, limits, clearances=1.0)
        found = replace(sheet, pressures=found.pressures)
    assert found.verdict is verdict
    assert not any(land.verdict.calls_for_repair for land in found.flagged)
    first, say = pages_of(write_pdf(found, sections=SIGNED))[0], wording("en")
    assert say("customer.past_unexplained") in first
    assert say(f"customer.urgent_past_{verdict}") in first
    assert say("customer.do_look") in first
    assert say(f"customer.{verdict}") not in first


@pytest.fixture(scope="module")
def grown(hipol, limits, readings_of) -> Callable[[dict], Diagnosis]:
    """Diagnoses a unit of which some lands have grown by a fraction of their clearance; None for a spool alone."""

    def build(growths: dict[tuple[str, int], float | None]) -> Diagnosis:
        controller = load_controller("four_speed_2023")
        diameters = {}
        for key, growth in growths.items():
            land = controller.land(*key)
            sleeve = None if growth is None else land.nominal_diameter + 2.0 * (1.0 + growth) * land.mounting_high
            diameters[key] = (land.nominal_diameter, sleeve)
        sheet = readings_of(controller, diameters)
        return diagnose(controller, hipol, limits, readings=sheet, complaint=controller.complaint("slips_in_second"))

    return build


@pytest.fixture(scope="module")
def aside(grown) -> Diagnosis:
    """A valve past the limit for repair and one to be watched, which leak nothing where the complaint shows."""
    return grown({("6", 1): 2.0, ("10", 1): 0.3, ("6", 2): None})


def test_valves_that_leak_nothing_where_the_complaint_shows_are_not_said_to_be_within_their_limits(aside):
    say, complaint = wording("en"), aside.complaint
    first = pages_of(write_pdf(aside, sections=SIGNED))[0]
    condition = say.condition(aside.complained[0].condition)
    values = {"label": say.name(complaint.label), "condition": condition}
    assert say("customer.explains_elsewhere", **values).replace("\u00a0", " ") in first
    assert say("customer.explains_nothing", **values).replace("\u00a0", " ") not in first


def test_a_place_of_which_one_part_was_measured_is_not_counted_as_not_measured(aside):
    say, lands = wording("en"), len(aside.lands)
    first = pages_of(write_pdf(aside, sections=SIGNED))[0]
    assert aside.judged == 3
    sealed = sum(land.state.land.seal is not None for land in aside.lands)
    assert say("customer.open", missing=lands - sealed - aside.judged, lands=lands) in first
    assert say("customer.half", half=1, lands=lands) in first


def test_a_valve_that_is_the_only_one_to_repair_is_not_called_one_of_several(grown):
    found = grown({("25", 1): 2.0, ("10", 1): 0.3})
    plan = plan_repairs(found)
    assert [land.key[0] for land in found.flagged if land.verdict.calls_for_repair] == ["25"]
    assert {step.land.key[0] for step in plan.steps} == {"25", "10"}
    assert worn_valves(found, plan.choice)[0].brings(found.worst).saving > 0.0
    first, say = pages_of(write_pdf(found, sections=SIGNED))[0], wording("en")
    assert say.texts["customer"]["do_first"].split("{")[0] not in first


def test_oil_leaks_into_a_section_the_sump_or_a_fixed_pressure_and_each_is_told_apart(aside):
    gap = next(gap for gap in aside.controller.gaps if gap.key == ("6", 1))
    ends = {
        "p_m": replace(gap, low=Pressure.parse("p_m"), into_sump=False),
        End.SUMP: replace(gap, low=Pressure.parse("drain"), into_sump=True),
        End.FIXED_PRESSURE: replace(gap, low=Pressure.parse("35 kPa"), into_sump=True),
        End.ANOTHER_SECTION: replace(gap, low=Pressure.parse("drain"), into_sump=False),
    }
    choice = plan_repairs(aside).choice
    found = replace(aside, controller=replace(aside.controller, gaps=tuple(ends.values())))
    valve = next(each for each in worn_valves(found, choice) if each.component == "6")
    assert [low for _, low in valve.paths] == [*ends]


@pytest.mark.parametrize(
    ("shares", "bands", "digits"),
    [
        ((0.1174, 0.0922), (Band.RED, Band.GREEN), 1),
        ((0.1153, 0.1154), (Band.AMBER, Band.AMBER), 1),
        ((0.1153, 0.1154), (Band.AMBER, Band.RED), 2),
        ((0.15, 0.15), (Band.AMBER, Band.RED), 3),
    ],
)
def test_shares_of_different_bands_are_printed_as_different_numbers(shares, bands, digits):
    totals = [SimpleNamespace(share=share, band=band) for share, band in zip(shares, bands, strict=True)]
    assert digits_apart(totals) == digits


def test_a_loss_after_all_repairs_that_is_under_that_of_a_new_unit_is_explained(grown):
    found = grown({("25", 1): 2.0, ("26", 2): -0.6})
    end = next(each for each in plan_repairs(found).ends if each.condition == found.worst.condition)
    page = CustomerPage(PrintedNames(found, diagnosis_record(found), Job(), wording("en")), signed=False)
    said = page.data()["do"]["texts"][0]
    assert end.share < found.new_at(found.worst).share
    assert f"less than the {wording('en').percent(found.new_at(found.worst).share)} of a new unit" in said


@pytest.mark.parametrize("language", languages())
def test_more_oil_than_the_pump_delivers_is_not_said_to_be_lost(unmeasured, language):
    slow = replace(unmeasured.projection.condition, name="stated", engine_speed=2.0)
    found = diagnose(unmeasured.controller, unmeasured.fluid, unmeasured.limits, condition=slow)
    share, say = found.new_at(found.worst).share, wording(language)
    assert 1.0 < share < float("inf")
    names = PrintedNames(found, diagnosis_record(found), Job(), say)
    (_, texts) = CustomerPage(names, signed=False).data()["found"].values()
    values = {"condition": names.condition(found.worst.condition), "new": say.percent(share)}
    assert say("customer.lost_new_over", **values) in texts[0]
    assert say("customer.lost_new", **values) not in texts[0]


def test_who_approves_signs_between_technician_and_customer_where_somebody_is_named(worn):
    for approver, roles in (("", ["technician", "customer"]), ("K. Lis", ["technician", "approver", "customer"])):
        names = PrintedNames(
            worn, diagnosis_record(worn), Job(approved_by=approver, technician="B. Nowak"), wording("en")
        )
        people = CustomerPage(names, signed=True).data()["signatures"]["people"]
        assert [role for role, _ in people] == [wording("en")(f"texts.sign_{role}") for role in roles]
        assert people[0][1] == "B. Nowak"
