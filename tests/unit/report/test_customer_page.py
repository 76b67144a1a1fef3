"""The first page of the printed report: what a customer who repairs no cars can read off it, whatever was typed."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pikepdf
import pytest
from PIL import Image

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.repairs import Repair
from atleak.common.translations import languages
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import wording
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.job.case import Case, SourceFile
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Reading, Readings
from atleak.report.pdf import write_pdf
from atleak.report.pdf.customer import CustomerPage
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.complaint import worn_valves
from tests.unit.conftest import first_of, with_clearances
from tests.unit.report import read_back

SIGNED = ("signatures",)
LONG = " ".join(["Once it is hot it waits at the lights before it moves, and then it goes with a jerk."] * 24)
ESTIMATE = {"currency": "EUR", "labour_rate": 80.0, "tax_percent": 23.0}


def pages_of(content: bytes) -> list[str]:
    return [re.sub(r"\s+", " ", page) for page in read_back.pages_of(content)]


def answered(names: PrintedNames, name: str) -> str:
    """One line of the answer on the first page, where there is room for all of it."""
    rows = CustomerPage(names, signed=False).data()["answer"][0]
    return dict(map(tuple, rows)).get(names.say(f"answer.{name}"), "")


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


@pytest.fixture(scope="module")
def as_new(hipol, limits) -> Callable[[str], Diagnosis]:
    return cache(lambda name: worn_everywhere(name, hipol, limits, clearances=1.0))


@pytest.mark.parametrize("language", languages())
def test_the_first_page_says_what_is_wrong_how_bad_it_is_and_what_to_do(worn, language):
    say, plan = wording(language), plan_repairs(worn)
    complaint = worn.controller.complaint("slips_hot")
    job = Job(complaint="It waits at the lights.", customer={"name": "A. Customer"})
    first, *_ = pages_of(write_pdf(replace(worn, complaint=complaint), job, language=language, sections=SIGNED))
    valves = worn_valves(worn, plan)
    after = next(each.share for each in plan.ends if each.condition == worn.worst.condition)
    said = [
        say(f"customer.{worn.verdict}"),
        say(f"customer.urgent_{worn.verdict}"),
        "It waits at the lights.",
        say.name(worn.controller.components[valves[0].component]),
        say.name(complaint.label),
        *(
            f"{say(f'customer_screen.{name}')} {share * 100:.0f}"
            for name, share in (("now", worn.worst.share), ("planned", after), ("new", worn.new_at(worn.worst).share))
        ),
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
    assert say("documents.workshop") in annex[0]


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["gm_4l60e", "five_speed_2005"])
@pytest.mark.parametrize("language", languages())
def test_many_worn_valves_a_long_complaint_and_an_estimate_take_two_pages_at_the_most(all_worn, controller, language):
    keys = [land.key for land in all_worn(controller).flagged[:6]]
    job = Job(
        complaint=LONG,
        estimate=ESTIMATE,
        repair_decisions=[{"component": key[0], "land": key[1], "price": 90.0, "decision": "proposed"} for key in keys],
        workshop={"name": "Łódź Automaty", "address": "Long Street 12\n00-001 Town", "phone": "1", "email": "a@b"},
    )
    content = write_pdf(all_worn(controller), job, language=language, paper="letter", sections=SIGNED)
    say, pages = wording(language), pages_of(content)
    behind = say("customer.follows", part=say("documents.workshop"))
    last = next(text for text in pages[:2] if behind in text)
    assert say("texts.sign_customer") in last
    assert last.count(f"{say('estimate.yes')} {say('estimate.no')}") == len(keys)


def test_lines_of_the_estimate_have_a_price_and_boxes_to_agree_or_say_that_a_price_is_missing(worn):
    component, land = worn.flagged[0].key
    work = {"component": component, "land": land, "work": "ream", "price": 180.0, "hours": 2.0, "decision": "proposed"}
    first, second, *_ = pages_of(write_pdf(worn, Job(estimate=ESTIMATE, repair_decisions=[work]), sections=SIGNED))
    say = wording("en")
    assert "ream 340.00 yes no" in second
    due = {each.component for each in worn_valves(worn, plan_repairs(worn)) if each.urgency.calls_for_repair}
    assert second.count("not priced yet") >= len(due - {component})
    assert "not priced yet yes" not in second
    total = say("customer.sum_with_tax", amount="at least 418.20", currency="EUR", net="at least 340.00")
    assert f"{total} {say('customer.lacking', valves='')[:-2]}" in first
    assert total in second
    assert say("customer.no_price") in pages_of(write_pdf(worn, sections=SIGNED))[0]


@pytest.mark.slow
def test_the_pressure_that_a_worn_valve_takes_is_said_where_circuits_are_described(all_worn):
    found = all_worn("five_speed_2005")
    first = pages_of(write_pdf(found, sections=SIGNED))[0]
    assert re.search(r"the pressure at “[^”]+” is [\d ]+ instead of [\d ]+ kPa \(", first)


@pytest.mark.parametrize("language", languages())
def test_a_band_that_is_not_sure_is_just_reached_on_the_first_page(worn, language):
    """Red of the sample at 11.7 %, where red begins at 11.5 %."""
    say, rule = wording(language), worn.worst_total
    page = CustomerPage(PrintedNames(worn, Job(), say), signed=False)
    for decision, just in (("conditional_fail", True), ("conditional_pass", True), ("fail", False), ("pass", False)):
        decided = replace(worn.decided(rule), decision=decision)
        uncertainty = SimpleNamespace(on=lambda _, decided=decided: decided)
        sure = replace(worn, uncertainty=uncertainty, log=None, pressures=None)
        page.diagnosis = sure
        said = " ".join(page.lost())
        band = say.level(Band(rule.level))
        assert (f"({say('customer.just', band=band)})" in said) == just
        assert (f"({band})" in said) != just


def test_lines_with_a_price_come_before_those_without_and_what_can_wait_stands_in_one_line(worn):
    first, second = (land.key for land in worn.flagged[-2:])
    works = [
        {"component": first[0], "land": first[1], "work": "swap", "decision": "declined", "reason": "too dear"},
        {"component": second[0], "land": second[1], "work": "ream", "price": 180.0, "decision": "proposed"},
    ]
    names = PrintedNames(worn, Job(estimate=ESTIMATE, repair_decisions=works), wording("en"))
    cost = CustomerPage(names, signed=False).data()["cost"]
    rows = cost["tables"][0]["rows"]
    assert [row[1] for row in rows if row[2] != "not priced yet"] == ["ream", "swap"]
    assert [row[2:] for row in rows].count(["not priced yet", ""]) == len(rows) - 2 > 0
    assert "Not priced yet, and can wait: " in cost["notes"][0]
    unpriced = {line.decision.component for line in names.estimate.estimate.lines} - {first[0], second[0]}
    assert unpriced
    bars = {bar["name"]: bar["litres"] for bar in CustomerPage(names, signed=False).bars()}
    end = next(each for each in names.estimate.estimate.ends if each.condition == worn.worst.condition)
    assert bars["with these repairs"] == f"{end.share * 100:.0f}", "the number of the estimate"


def test_a_line_that_is_left_open_says_that_a_price_is_missing_and_not_that_it_can_wait(worn):
    valve = next(each.component for each in worn_valves(worn, plan_repairs(worn)) if each.urgency.calls_for_repair)
    other = next(land.key[0] for land in worn.flagged if land.key[0] != valve)
    works = [
        {"component": valve, "work": "ream", "decision": None},
        {"component": other, "work": "swap", "price": 90.0, "hours": 1.0, "decision": "proposed"},
    ]
    names = PrintedNames(worn, Job(estimate=ESTIMATE, repair_decisions=works), wording("en"))
    page = CustomerPage(names, signed=False)
    rows = page.data()["cost"]["tables"][0]["rows"]
    assert [row[2:] for row in rows if row[1] == "ream"] == [["not priced yet", ""]]
    assert names.say.name(worn.controller.components[valve]) in page.data()["answer"][0][2][1]


def test_the_estimate_of_a_wreck_names_the_kits_that_have_no_price(all_worn):
    unit = all_worn("gm_4l60e")
    text = " ".join(" ".join(pages_of(write_pdf(unit, Job(estimate=ESTIMATE), document="workshop"))).split())
    repairs = [step.chosen.repair for step in plan_repairs(unit).steps if step.chosen is not None]
    numbers = [each.part_number for each in repairs if each.part_number]
    assert len(numbers) > 2
    assert [each for each in numbers if each not in text] == []


def test_of_equally_worn_valves_the_one_that_is_repaired_first_is_named_first(all_worn):
    unit = all_worn("gm_4l60e")
    planned = [step.land.key[0] for step in plan_repairs(unit).steps]
    worst = [each for each in worn_valves(unit, plan_repairs(unit)) if each.urgency is each.verdict is unit.urgency]
    assert len(worst) > 2
    turns = [planned.index(each.component) for each in worst]
    assert turns == sorted(turns)


@pytest.mark.parametrize("name", ["unmeasured", "within"])
def test_a_unit_without_worn_valves_has_a_first_page_without_them(unmeasured, hipol, limits, name):
    found = unmeasured if name == "unmeasured" else worn_everywhere("minimal_example", hipol, limits, clearances=1.0)
    found = replace(found, complaint=None)
    assert not found.flagged
    first = pages_of(write_pdf(found, sections=SIGNED))[0]
    say = wording("en")
    verdict = Verdict.NOT_MEASURED if name == "unmeasured" else found.verdict
    assert say(f"customer.{verdict}") in first
    assert say("customer.valves") not in first


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("name", first_of(["four_speed_2023", "five_speed_2005", "gm_4l60e", "jatco_jf506e"]))
def test_a_sound_valve_body_is_not_the_cause_of_a_complaint_and_work_on_it_is_doubted(as_new, name, language):
    found = as_new(name)
    assert found.verdict is Verdict.OK
    component = found.controller.lands[0].component
    work = {"component": component, "work": "ream", "price": 180.0, "hours": 2.0, "decision": "approved"}
    job, say = Job(complaint="Slips when hot", estimate=ESTIMATE, repair_decisions=[work]), wording(language)
    names = PrintedNames(found, job, say)
    data = CustomerPage(names, signed=False).data()
    assert data["headline"] == say("customer.ok_complaint")
    assert data["urgency"][1] == say("customer.urgent_ok_complaint") != say("customer.urgent_ok")
    assert answered(names, "do") == say("customer.do_elsewhere")
    assert say("customer.needless", valves="").rstrip(".") in data["cost"]["notes"][-1]
    silent = PrintedNames(replace(found, complaint=None), Job(), say)
    assert CustomerPage(silent, signed=False).data()["headline"] == say("customer.ok")
    assert answered(silent, "do") == say("customer.do_nothing")


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
    assert say("customer.do_find") in first
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
    assert say("customer.no_effect", **values).replace("\u00a0", " ") in first
    assert say("customer.within", measured=aside.judged) not in first
    assert say("customer.do_elsewhere") in first


def test_a_valve_to_be_watched_does_not_hide_that_the_complaint_is_not_explained(grown):
    found, say = grown({("10", 1): 0.3}), wording("en")
    assert found.verdict is Verdict.WATCH
    for profile, said in ((WORKSHOP, True), (PAPER, False)):  # which solves no pressure
        names = PrintedNames(replace(found, profile=profile), Job(), say)
        assert (say("customer.do_elsewhere") in answered(names, "do")) == said


def test_a_place_of_which_one_part_was_measured_is_not_counted_as_not_measured(aside):
    say, lands = wording("en"), len(aside.lands)
    first = pages_of(write_pdf(aside, sections=SIGNED))[0]
    assert aside.judged == 3
    sealed = sum(land.state.land.seal is not None for land in aside.lands)
    assert say("customer.open", missing=lands - sealed - aside.judged, lands=lands) in first
    assert say("customer.half", half=1, lands=lands) in first
    drawn = " ".join(pages_of(write_pdf(aside, sections=["picture"]))[1:])
    missing = lands - sealed - aside.judged
    assert f"not measured: {missing}" in drawn, "the numbers of the first page"
    assert say("charts.half_measured", count=1) in drawn


@pytest.fixture(scope="module")
def wide(hipol, limits, readings_of) -> Callable[..., Diagnosis]:
    """Diagnoses a unit with circuits, of which some lands are so many times as wide as the widest new ones."""
    described = load_controller("chrysler_41te")
    lands = (replace(each, mounting_clearance=each.widest_new, mounting_measured=True) for each in described.lands)
    unit = replace(described, lands=tuple(lands))

    def build(times: dict[tuple[str, int], float], mileage: float | None = None) -> Diagnosis:
        clearances = {key: unit.land(*key).widest_new * each for key, each in times.items()}
        sheet = with_clearances(unit, readings_of, clearances)
        return diagnose(unit, hipol, limits, readings=sheet, mileage_km=mileage)

    return build


WAITS, DUE = ("regulator", 2), ("manual_valve", 1)


@pytest.mark.parametrize("language", languages())
def test_a_valve_whose_wear_does_nothing_is_not_to_be_repaired_on_this_visit(wide, language):
    found, say = wide({WAITS: 1.9}), wording(language)
    assert (found.verdict, found.urgency) == (Verdict.REPLACE, Verdict.WATCH)
    first = pages_of(write_pdf(found, language=language))[0]
    valve = say.name(found.controller.components["regulator"])
    said = [say("customer.watch"), say("customer.urgent_watch")]
    said += [say("customer.waits", valves=valve), say("customer.do_watch", valves=valve)]
    said += [say("customer.worn", measured=len(found.lands), repair=0, watch=1)]
    assert [words for words in said if words.replace("\u00a0", " ") not in first] == []
    for words in (say("customer.urgent_replace"), say("customer_screen.escapes"), say.level(Verdict.REPLACE)):
        assert words not in first


def test_of_two_worn_valves_the_one_that_does_nothing_can_wait(wide):
    found, say = wide({WAITS: 1.9, DUE: 1.9}), wording("en")
    assert found.urgency is Verdict.REPLACE
    first = pages_of(write_pdf(found))[0]
    due, waits = (say.name(found.controller.components[component]) for component, _ in (DUE, WAITS))
    said = say("customer.do_repair", valves=due), say("customer.do_wait", valves=waits), say("customer.urgent_replace")
    assert [words for words in said if words not in first] == []
    now, waiting = plan_repairs(found).steps
    assert [(step.land.key, step.consequence) for step in (now, waiting)] == [
        (DUE, Consequence.NOW),
        (WAITS, Consequence.NONE),
    ]


@pytest.mark.parametrize(("units", "mileage"), [("metric", "120 000 km"), ("us", "74 000 mi")])
def test_a_valve_that_fails_before_the_next_service_says_at_which_mileage_and_that_it_is_assumed(wide, units, mileage):
    found, say = wide({DUE: 1.5}, 60_000.0), wording("en", units)
    first = pages_of(write_pdf(found, units=units))[0]
    amount, unit = mileage.rsplit(" ", 1)
    assert say("customer.urgent_before_service", mileage=amount) in first
    assert f"Nothing has to be repaired now, but before {amount} {unit}: manual valve." in first
    assert "How often it is serviced is assumed." in first
    assert say("customer.urgent_replace") not in first


def test_a_loss_after_all_repairs_that_is_under_that_of_a_new_unit_is_explained(grown):
    found = grown({("25", 1): 2.0, **{(valve, 2): -0.6 for valve in ("17", "25", "26")}})
    end = next(each for each in plan_repairs(found).ends if each.condition == found.worst.condition)
    assert end.share < found.new_at(found.worst).share
    bars = CustomerPage(PrintedNames(found, Job(), wording("en")), signed=False).data()["bars"]
    assert bars["note"] == wording("en")("customer.tighter")


@pytest.mark.parametrize("language", languages())
def test_more_oil_than_the_pump_delivers_is_not_said_to_be_lost(unmeasured, language):
    slow = replace(unmeasured.projection.condition, name="stated", engine_speed=2.0)
    found = diagnose(unmeasured.controller, unmeasured.fluid, unmeasured.limits, condition=slow)
    share, say = found.new_at(found.worst).share, wording(language)
    assert 1.0 < share < float("inf")
    names = PrintedNames(found, Job(), say)
    (_, texts) = CustomerPage(names, signed=False).data()["found"].values()
    values = {"condition": names.say.condition(found.worst.condition), "new": say.percent(share)}
    assert say("customer.lost_new_over", **values) in texts[0]
    assert say("customer.lost_new", **values) not in texts[0]


def test_who_approves_signs_between_technician_and_customer_where_somebody_is_named(worn):
    for approver, roles in (("", ["technician", "customer"]), ("K. Lis", ["technician", "approver", "customer"])):
        names = PrintedNames(worn, Job(approved_by=approver, technician="B. Nowak"), wording("en"))
        people = CustomerPage(names, signed=True).data()["signatures"]["people"]
        assert [role for role, _ in people] == [wording("en")(f"texts.sign_{role}") for role in roles]
        assert people[0][1] == "B. Nowak"


def test_a_body_is_one_line_of_the_estimate_and_each_valve_is_named(all_worn):
    worn = all_worn("five_speed_2005")
    lands = tuple(land.key for land in worn.controller.lands)
    body = Repair("body", lands, "other", "new body", "made up", price=650.0, currency="EUR", hours=6.0)
    unit = replace(worn, controller=replace(worn.controller, repairs=(body,)))
    names = PrintedNames(unit, Job(estimate=ESTIMATE), wording("en"))
    assert [row[:3] for row in CustomerPage(names, signed=False).data()["cost"]["tables"][0]["rows"]] == [
        ["the whole valve body", "new body", "1\u00a0130.00"]
    ]
    assert len(worn_valves(unit, names.plan)) > 9


def test_a_photo_of_a_worn_valve_takes_no_line_that_is_agreed_to_and_needs_no_bars(worn, monkeypatch):
    picture = io.BytesIO()
    Image.new("RGB", (80, 60)).save(picture, "PNG")
    flagged = list(dict.fromkeys(land.key[0] for land in worn.flagged))
    works = [{"component": each, "price": 90.0, "hours": 1.0, "decision": "proposed"} for each in flagged[:3]]
    bare = Job(estimate=ESTIMATE, repair_decisions=works, complaint=LONG, workshop={"address": "A\nB\nC"})
    photographed = bare.model_copy(update={"photos": Job(photos=[{"file": "a.png", "component": flagged[0]}]).photos})
    photographed = photographed.with_pictures({"a.png": picture.getvalue()})
    printed = [write_pdf(worn, job, document="customer") for job in (bare, photographed)]
    agreed = ["".join(pages_of(each)).count("yes no") for each in printed]
    assert agreed == [3, 3]
    assert [len(pages_of(each)) for each in printed] == [2, 2]
    monkeypatch.setattr(CustomerPage, "bars", lambda self: iter(()))
    alone = Job(photos=photographed.photos).with_pictures(photographed.pictures)
    with pikepdf.open(io.BytesIO(write_pdf(worn, alone, document="customer"))) as pdf:
        assert any(each.get("/Subtype") == "/Image" for each in pdf.pages[0].Resources.XObject.values())


def test_of_100_litres_no_more_than_all_are_lost_and_the_share_is_said(hipol, limits):
    lost = worn_everywhere("gm_4l60e", hipol, limits, clearances=8.0)
    assert lost.worst.share > 1.0
    data = CustomerPage(PrintedNames(lost, Job(), wording("en")), signed=False).data()
    assert next(bar for bar in data["bars"]["rows"] if bar["now"])["litres"] == "> 100"
    assert any("more than there is, so the pressure falls" in each for each in data["found"]["texts"][0])


def test_a_log_within_its_limits_is_nothing_wrong(sample_log):
    found = Case(road_test=SourceFile("drive.csv", sample_log.read_bytes())).diagnose()
    names = PrintedNames(found, Job(), wording("en"))
    assert found.verdict is Verdict.OK
    assert not answered(names, "wrong")
    said = CustomerPage(names, signed=False).data()["found"]["texts"][0]
    assert any("nowhere below what is permitted" in each for each in said)


def test_that_a_limit_stays_passed_is_said_before_where_else_to_look(sample_diagnoses):
    sample, say = sample_diagnoses["workshop"], wording("en")
    found = replace(sample, complaint=sample.controller.complaint("slips_hot"))
    names = PrintedNames(found, Job(estimate=ESTIMATE), say)
    said = answered(names, "do")
    key = "past" if names.estimate.estimate.past else "green"
    assert 0 < said.index(say(f"customer.do_{key}_estimate")) < said.index(say("customer.do_elsewhere"))


def test_an_estimate_of_which_all_is_declined_is_priced(worn):
    works = [
        {"component": each, "price": 90.0, "hours": 1.0, "decision": "declined"}
        for each in dict.fromkeys(land.key[0] for land in worn.flagged)
    ]
    say = wording("en")
    names = PrintedNames(worn, Job(estimate=ESTIMATE, repair_decisions=works), say)
    assert not CustomerPage(names, signed=False).data()["cost"]["sum"]
    assert (
        say("customer.no_price") == CustomerPage(PrintedNames(worn, Job(), say), signed=False).data()["answer"][0][2][1]
    )


def test_how_sure_is_said_of_a_cause_and_not_of_no_verdict(worn, unmeasured):
    assert answered(PrintedNames(worn, Job(), wording("en")), "sure").startswith("With ")
    assert not answered(PrintedNames(unmeasured, Job(), wording("en")), "sure")
