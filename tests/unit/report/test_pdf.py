"""The printed report, read back page by page."""

from __future__ import annotations

import io
import re
import struct
import unicodedata
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import MappingProxyType

import pytest
from PIL import Image

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.cli.shared import PRINTED
from atleak.common.errors import InputError
from atleak.common.pictures import printable_picture
from atleak.common.style import look_of
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import Crossing
from atleak.diagnosis.uncertainty import Assumptions
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.measurements.job_card import Job
from atleak.report.pdf import write_pdf
from atleak.report.pdf.body import DOCUMENTS, PDF_SECTIONS
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.first_sentence import lands_part
from atleak.report.tables.lands import leaking_worst_first
from tests.unit.report.read_back import is_archival, pages_of, squeezed, text_of

# the first of the hostile texts at once, the others in the longer round
FIRST_AND_THE_REST = pytest.mark.parametrize(
    "some", [slice(1), pytest.param(slice(1, None), marks=pytest.mark.slow)], ids=["first", "rest"]
)


def picture(width: int = 300, height: int = 200, form: str = "PNG", **options: object) -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (width, height), "#336699").save(target, form, **options)
    return target.getvalue()


@pytest.fixture(scope="module")
def job() -> Job:
    return Job(
        number="2026-17",
        date="2026-03-14",
        workshop={"name": "Łódź Automaty", "address": "Long Street 12\n00-001 Town", "logo": "logo.png"},
        customer={"name": "Ελένη Παπαδοπούλου"},
        vehicle={"make": "Example", "vin": "WEXAMPLE123456789", "mileage_km": 106_315},
        transmission={"code": "4G-22", "serial": "Привет-7"},
        complaint="Shifts late when hot.",
        contamination={"grade": "moderate"},
        repair_decisions=[
            {"component": "8", "land": 1, "work": "ream", "decision": "done"},
            {"component": "15", "work": "new sleeve", "decision": "declined", "reason": "too dear for an old car"},
            {"component": "22", "work": "polish", "decision": "deferred", "reason": "at the next oil change"},
        ],
        scratches=[{"component": "8", "description": "two long scratches", "photo": "scratch.jpg"}],
        photos=[{"file": "open.jpg", "caption": "controller opened"}],
        instruments=[{"name": "bore gauge", "calibrated": "2025-11-02"}],
        notes="Told the customer about valve 22.",
    ).with_pictures({"logo.png": picture(), "open.jpg": picture(form="JPEG"), "scratch.jpg": picture(form="JPEG")})


@pytest.fixture(scope="module")
def printed(worn, job) -> bytes:
    return write_pdf(worn, job)


@pytest.fixture(scope="module")
def printed_in(worn, job, printed) -> Callable[[str], bytes]:
    """Gives the same report in a language, printed once: the English one on A4, the others on letter."""

    @cache
    def print_in(language: str) -> bytes:
        return printed if language == "en" else write_pdf(worn, job, language=language, paper="letter")

    return print_in


def test_claims_archival_and_accessible(printed):
    assert is_archival(printed)
    assert b"/StructTreeRoot" in printed
    assert b"/Lang" in printed


def test_says_every_flagged_pair_with_its_numbers(worn, printed):
    text = text_of(printed)
    say = wording("en")
    for land in worn.flagged:
        name = worn.controller.components[land.state.land.component]
        assert f"{land.state.land.component} {name}" in text
        assert say.number(land.state.radial_clearance * 1e6, 1) in text
        assert say.number(land.share * 100, 2) in text
    for word in ("replace", "watch", "not measured", "fail", "published"):
        assert word in text
    assert lands_part(worn, say).replace("\u00a0", " ") in text.replace("\u00a0", " ")


@pytest.mark.parametrize("language", languages())
def test_says_what_each_land_draws_at_each_condition_and_what_repairs_bring(worn, language):
    say = wording(language)
    content = text_of(write_pdf(worn, language=language, sections=["matrix", "repair_order"]))
    for row in leaking_worst_first(worn):
        for cell in row.cells:
            if cell.leakage > 0.0:
                assert say.number(cell.share * 100.0, 2) in content
    assert say("texts.matrix") in content
    assert say("pressures.p_m") in content
    plan = plan_repairs(worn)
    for step in plan.steps:
        for each in step.conditions:
            assert f"{say.number(each.after.share * 100.0, 1)} {say.level(each.after.band)}" in content
    assert say("plan.green") in content
    assert say("plan.unmeasured", count=1) in content


@pytest.mark.parametrize("language", languages())
def test_what_to_measure_for_a_complaint_stands_where_the_annex_begins(worn, language):
    complaint = worn.controller.complaint("slips_hot")
    first = re.sub(
        r"\s+", " ", pages_of(write_pdf(replace(worn, complaint=complaint), language=language, sections=[]))[1]
    )
    say = wording(language)
    name = say.condition(worn.hot_idle.condition)
    shows = say("complaint.shows", label=say.name(complaint.label), conditions=name)
    assert shows.replace("\u00a0", " ") in first
    assert say("complaint.first") in first  # one land of this unit was not measured
    assert say("complaint.no_effect") in first
    driving = say.condition(worn.projection.condition)
    assert first.index(name.replace("\u00a0", " ")) < first.index(driving.replace("\u00a0", " "))


def test_a_mileage_stands_beside_a_repair_only_where_one_visit_tells_it(worn):
    step = plan_repairs(worn).steps[0].land
    foreseen = replace(step, replace_mileage=Crossing(157_861.7, 139_204.0, 184_301.0, 106_315.0))
    lands = tuple(foreseen if land is step else land for land in worn.lands)
    with_it, without = (
        text_of(write_pdf(each, sections=["repair_order"])) for each in (replace(worn, lands=lands), worn)
    )
    say = wording("en")
    assert "160 000 km (140 000 to 180 000)" in with_it
    assert say("texts.replace_at") in with_it
    assert say("printed.replace_at") not in without


def test_many_conditions_are_set_a_few_abreast(worn):
    idle = worn.controller.operating_points[1]
    points = [replace(idle, name=f"point_{number}", label=f"point {number}") for number in range(11)]
    controller = replace(worn.controller, operating_points=tuple(points))
    diagnosis = diagnose(controller, worn.fluid, worn.limits, readings=worn.readings)
    content = write_pdf(diagnosis, sections=["flagged", "matrix", "repair_order"])
    assert is_archival(content)
    assert all(f"point {number}" in text_of(content).lower() for number in range(11))


def test_says_what_the_workshop_wrote(printed):
    text = text_of(printed)
    for said in (
        "Łódź Automaty",
        "Ελένη Παπαδοπούλου",
        "Привет-7",
        "WEXAMPLE123456789",
        "Shifts late when hot.",
        "declined",
        "too dear for an old car",
        "two long scratches",
        "controller opened",
        "calibrated 2025-11-02",
        "Told the customer about valve 22.",
    ):
        assert said in text, said


def test_says_where_everything_comes_from(worn, printed):
    text = squeezed(text_of(printed))
    for digest in (worn.readings.sha256, worn.road.road_test.sha256, worn.controller.sha256, worn.limits.origin.sha256):
        assert digest in text
    assert "10.3390/en16227667" in text
    assert "assumed" in text


def test_nothing_is_printed_for_what_was_not_filled_in(unmeasured):
    text = text_of(write_pdf(unmeasured, sections=[name for name in PDF_SECTIONS if name != "signatures"]))
    for label in (
        "Job",
        "Customer",
        "Vehicle",
        "VIN",
        "Complaint",
        "Repair decisions",
        "Photos",
        "As found",
        "Road test",
    ):
        assert label not in text
    assert "nothing was measured" in text
    assert is_archival(write_pdf(unmeasured))


def test_table_headers_are_repeated(worn):
    pages = pages_of(write_pdf(worn, document="annex", sections=["all", "readings"]))
    assert len([page for page in pages if "c_r ± U" in page]) >= 2


@pytest.mark.parametrize("language", languages())
def test_every_language_is_archival_and_says_its_words(worn, printed_in, language):
    content = printed_in(language)
    say, text = wording(language), text_of(content)
    assert is_archival(content)
    assert say("title.report") in text
    assert say("verdicts.replace") in text
    assert say.number(worn.flagged[0].state.radial_clearance * 1e6, 1) in text
    assert say("job_decisions.declined") in text


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", "converter, lubrication and clutch fill are not in it"),
        ("de", "Wandler, Schmierung und Füllen der Kupplungen sind nicht enthalten"),
        ("pl", "przekładnia hydrokinetyczna, smarowanie i napełnianie sprzęgieł nie są wliczone"),
    ],
)
def test_the_speed_that_covers_the_leakage_says_what_is_not_in_it(worn, language, said):
    assert squeezed(said) in squeezed(text_of(write_pdf(worn, language=language, sections=[])))


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", ("taken as fresh (not stated)", "is some 20 to 25 % thinner", "some 20 to 25 % thinner than fresh")),
        (
            "de",
            ("als frisch angenommen (nicht angegeben)", "ist etwa 20 bis 25 % dünner", "20 bis 25 % dünner als"),
        ),
        ("pl", ("przyjęty jako świeży (nie podano)", "o około 20 do 25 % rzadszy", "o około 20 do 25 % rzadszy niż")),
    ],
)
def test_the_state_of_the_fluid_is_said(worn, language, said):
    used = replace(worn, fluid=load_fluid("mobil_atf_220").in_state("used"), fluid_state_assumed=False)
    assumed, stated = (
        squeezed(text_of(write_pdf(each, language=language, sections=["conditions", "messages"])))
        for each in (worn, used)
    )
    assert squeezed(said[0]) in assumed
    assert squeezed(said[1]) in assumed
    assert squeezed(said[2]) in stated
    assert squeezed(said[0]) not in stated


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize(
    ("profile", "said"),
    [
        (WORKSHOP, {"form", "entry_loss"}),
        (WORKSHOP.with_options(eccentricity="unknown"), {"form", "entry_loss", "eccentricity_unknown"}),
        (PAPER, set()),
    ],
    ids=lambda value: getattr(value, "label", ""),
)
def test_the_method_says_what_the_profile_counts(worn, language, profile, said):
    diagnosis = diagnose(worn.controller, worn.fluid, worn.limits, readings=worn.readings, profile=profile)
    say, text = wording(language), squeezed(text_of(write_pdf(diagnosis, language=language, sections=["method"])))
    every = ("form", "entry_loss", "eccentricity_unknown")
    assert {name for name in every if squeezed(say(f"texts.method_{name}")) in text} == said


def test_hostile_text_stays_text(worn, hostile):
    for text in hostile:
        job = Job(customer={"name": text}, workshop={"name": text}, notes=text, technician=text)
        said = squeezed(text_of(write_pdf(replace(worn, road=None), job, sections=["notes", "signatures"])))
        if any(unicodedata.bidirectional(sign) in ("R", "AL") for sign in text):
            assert sum(sign in said for sign in squeezed(text)) == len(squeezed(text))  # order is the reader's business
        else:
            assert said.count(squeezed(text)) >= 4, text


def test_characters_without_a_glyph_make_a_plain_file_that_says_so(unmeasured):
    content = write_pdf(unmeasured, Job(customer={"name": "漢 wrench 🔧"}), sections=["method"])
    assert not is_archival(content)
    text = text_of(content)
    assert "Plain PDF without PDF/A" in text
    assert "U+1F527" in text
    assert "漢 wrench 🔧" in text


def test_long_notes_are_not_cut(unmeasured):
    notes = "\n".join(f"Line {number} of what was seen, heard and smelt on the test drive." for number in range(600))
    text = text_of(write_pdf(unmeasured, Job(notes=notes), sections=["notes"]))
    assert all(f"Line {number} of what" in text for number in range(600))


def test_a_long_cell_runs_over_the_page(unmeasured):
    reason = " ".join(f"word{number}" for number in range(3000))
    job = Job(repair_decisions=[{"component": "8", "work": "ream", "decision": "declined", "reason": reason}])
    content = write_pdf(unmeasured, job, sections=["repair"])
    assert len(pages_of(content)) > 2
    text = text_of(content)
    assert all(f"word{number} " in text for number in range(2999))


def test_sections_can_be_chosen(worn, job):
    text = text_of(write_pdf(worn, job, sections=["flagged", "signatures"]))
    say = wording("en")
    assert say("sections.flagged") in text
    assert say("texts.sign_customer") in pages_of(write_pdf(worn, job, sections=["signatures"]))[0]
    assert say("sections.all") not in text
    assert say("sections.road_test") not in text
    with pytest.raises(InputError, match="did you mean 'road_test'"):
        write_pdf(worn, job, sections=["road_tests"])


def test_unknown_language_and_paper_are_refused(worn):
    with pytest.raises(InputError, match="expected one of de, en, pl"):
        write_pdf(worn, language="fr")
    with pytest.raises(InputError, match="did you mean 'letter'"):
        write_pdf(worn, paper="leter")


def test_every_section_has_a_title():
    assert set(PDF_SECTIONS) == set(wording("en").table("sections"))


def test_same_job_same_bytes_also_from_threads(worn, job, printed):
    with ThreadPoolExecutor(2) as pool:
        copies = list(pool.map(lambda _: write_pdf(worn, job), range(2)))
    assert copies == [printed] * 2


def test_shades_are_told_apart_in_grey():
    def grey(colour: str) -> float:
        red, green, blue = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    greys = [grey(look_of(verdict).fill) for verdict in ("ok", "watch", "replace", "critical")]
    assert all(light - dark > 0.1 for light, dark in pairwise(greys)), greys


def test_a_picture_loses_where_it_was_taken_and_stands_upright():
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a quarter
    exif.get_ifd(0x8825)[1] = "N"  # a place
    suffix, content = printable_picture("a.jpg", picture(400, 100, "JPEG", exif=exif))
    assert suffix == "jpg"
    shown = Image.open(io.BytesIO(content))
    assert shown.size == (100, 400)
    assert not shown.getexif()


@pytest.mark.parametrize("form", ["JPEG", "PNG", "WEBP"])
def test_damaged_notes_of_the_camera_cost_neither_the_picture_nor_a_warning(form):
    entry = struct.pack(">HHII", 0x010F, 2, 80, 16)  # text that should stand behind the end of the notes
    notes = b"Exif\0\0MM\0*" + struct.pack(">IH", 8, 2) + struct.pack(">HHIHH", 0x0112, 3, 1, 6, 0) + entry
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        _, content = printable_picture("a", picture(400, 100, form, exif=notes))
    assert caught == []
    assert Image.open(io.BytesIO(content)).size == (100, 400)


@pytest.mark.parametrize(
    "content", [b"", b"not a picture", b"<svg xmlns='http://www.w3.org/2000/svg'/>", picture()[:200]]
)
def test_a_damaged_picture_is_refused_by_name(worn, content):
    job = Job(photos=[{"file": "a.png"}]).with_pictures({"a.png": content})
    with pytest.raises(InputError, match=r"picture cannot be read \(found 'a\.png'\)"):
        write_pdf(worn, job)


def test_a_picture_that_unfolds_without_end_is_refused():
    target = io.BytesIO()
    Image.new("1", (20_000, 20_000)).save(target, "PNG")
    with pytest.raises(InputError):
        printable_picture("bomb.png", target.getvalue())


@FIRST_AND_THE_REST
def test_names_of_a_workshops_own_controller_stay_text(worn, hostile, some):
    controller = worn.controller
    for text in hostile[some]:
        named = MappingProxyType(dict.fromkeys(controller.components, text))
        other = replace(worn, road=None, controller=replace(controller, name=text, components=named))
        sections = ["picture", "flagged", "shares", "conditions"]
        said = squeezed(text_of(write_pdf(other, sections=sections)))
        if not any(unicodedata.bidirectional(sign) in ("R", "AL") for sign in text):
            assert said.count(squeezed(text)) > len(worn.flagged), text


@pytest.mark.parametrize("language", languages())
def test_a_doubtful_verdict_says_what_would_settle_it(worn, language):
    doubtful = [land for land in worn.flagged if land.decision == "conditional_fail"]
    assert doubtful
    text = text_of(write_pdf(worn, language=language, sections=["again"]))
    say = wording(language)
    assert say("sections.again") in text
    for land in doubtful:
        assert PrintedNames(worn, Job(), say).land_number(land) in text
    ways = [land.uncertainty.remedy(land.uncertainty.deciding) for land in doubtful]
    assert not all(way.decides for way in ways)
    for way in ways:
        if way.decides:
            assert say.percent(way.fraction, 0).replace("\u00a0", " ") in text
    assert text.count(say("advice.judgement")) == 1, "one sentence for all that only judgement decides"


def in_doubt_for_its_form(worn, ovality, residual):
    """The worn unit with oval bores of which two directions leave so much open, and the remedies its PDF prints."""
    readings = tuple(
        replace(each, diameter=each.diameter + ovality * (each.part == "sleeve" and each.direction > 0.0))
        for each in worn.readings.readings
    )
    oval = diagnose(
        worn.controller,
        worn.fluid,
        worn.limits,
        readings=replace(worn.readings, readings=readings),
        assumptions=Assumptions(form_residual=residual),
    )
    doubtful = [land for land in oval.flagged if land.decision in {"conditional_pass", "conditional_fail"}]
    return oval, [land.uncertainty.remedy(land.uncertainty.deciding) for land in doubtful]


@pytest.mark.parametrize("language", languages())
def test_a_verdict_that_the_form_leaves_open_asks_for_more_directions(worn, language):
    oval, remedies = in_doubt_for_its_form(worn, 6e-6, 0.4)
    say = wording(language)
    formed = [each for each in remedies if each.directions or (each.form > 0.5 and not each.instruments)]
    assert formed
    text = text_of(write_pdf(oval, language=language, sections=["again"]))
    advised = {each.directions or say.percent(each.form, 0) for each in formed}
    assert 0 < text.count("(0, 45, 90") <= len(advised) < len(formed), "lands of which the same is advised together"


@pytest.mark.parametrize("language", languages())
def test_a_limit_finer_than_the_gauge_is_called_so_in_print(worn, language):
    oval, remedies = in_doubt_for_its_form(worn, 6e-6, 1.2)
    too_fine = [each for each in remedies if not each.measurable]
    assert too_fine
    text = text_of(write_pdf(oval, language=language, sections=["again"]))
    begins = wording(language)("advice.not_measurable", rule="#", limit="#", guard="#").split("#")[2].strip()
    begins = " ".join(begins.split()[:4])  # a page may end within the sentence
    assert text.count(begins) == len(too_fine)


def test_a_pump_that_delivers_nothing_and_another_controller(worn):
    standing = replace(worn.projection.condition, name="stated", engine_speed=1e-3)
    still = diagnose(worn.controller, worn.fluid, worn.limits, readings=worn.readings, condition=standing)
    assert still.projection.pump_capacity == 0.0
    text = text_of(write_pdf(still))
    assert "∞" in text
    minimal = load_controller("minimal_example")
    other = diagnose(minimal, worn.fluid, worn.limits, profile=PAPER)
    assert minimal.name in text_of(write_pdf(other, paper="letter"))
    for each in (still, other):
        assert is_archival(write_pdf(each, language="de"))


@pytest.mark.parametrize(
    ("language", "assumed", "corrected"),
    [
        ("en", "assumed 20 °C, none is stated", "35.5 °C, diameters corrected to 20 °C"),
        ("pl", "przyjęto 20 °C, brak danych", "35,5 °C, średnice przeliczone na 20 °C"),
        ("de", "20 °C angenommen, keine Angabe", "35,5 °C, Durchmesser auf 20 °C umgerechnet"),
    ],
)
def test_the_measuring_temperature_is_assumed_or_corrected_for(worn, unmeasured, language, assumed, corrected):
    def printed(temperature):
        warm = diagnose(
            worn.controller, worn.fluid, worn.limits, readings=worn.readings, measuring_temperature_c=temperature
        )
        return text_of(write_pdf(warm, language=language, sections=["conditions"]))

    label = wording(language)("facts.measuring_temperature")
    assert f"{label} {assumed}" in printed(None)
    assert f"{label} {corrected}" in printed(35.5)
    assert f"{label} 20 °C" in printed(20.0)
    assert label not in text_of(write_pdf(unmeasured, language=language, sections=["conditions"]))


def test_numbers_beside_a_name_from_right_to_left_keep_their_order(worn):
    job = Job(
        number="2026-0417",
        workshop={"name": "شركة النور للسيارات"},
        customer={"name": "محمد علي", "number": "44-17", "email": "somebody@example.org"},
        vehicle={"registration": "12-345-67"},
        transmission={"maker": "אבג", "code": "4G-22"},
    )
    first, annex, *others = pages_of(write_pdf(worn, job))
    assert "Job 2026-0417 · " in first
    assert len(others) > 2
    for page in (annex, *others):
        assert page.splitlines()[0].split(" · ")[1:3] == ["2026-0417", "12-345-67 Internal leakage of a valve body"]
    for numbers in (", 44-17, somebody@example.org", "Transmission אבג 4G-22"):
        assert numbers in annex


@pytest.mark.parametrize(
    ("units", "there", "gone"),
    [
        ("us", ("psi", "°F", "gpm", "0.0001 in", "mi"), ("kPa", "°C", "dm³/min", "µm", "km")),
        ("metric_bar", ("bar", "°C", "l/min", "µm"), ("kPa", "dm³/min", "psi")),
    ],
)
def test_the_readers_units_stand_in_tables_sentences_and_charts(worn, units, there, gone):
    sections = ["flagged", "matrix", "pressures", "repair_order", "all", "shares"]  # others quote files and sources
    said = text_of(write_pdf(replace(worn, mileage=100_000.0), units=units, sections=sections))
    for unit in there:
        assert unit in said
    for unit in gone:
        assert not re.search(rf"(?<![\w/]){re.escape(unit)}(?![\w/])", said), unit


def test_each_document_prints_its_own_part_and_all_of_them_the_whole(worn) -> None:
    said = {name: text_of(write_pdf(worn, document=name)).replace("\u00a0", " ") for name in DOCUMENTS}
    heads = {"What your transmission needs": "customer", "Workshop report": "workshop", "Technical annex": "annex"}
    holds = {name: {part for head, part in heads.items() if head in text} for name, text in said.items()}
    assert holds == {
        "report": {"customer", "workshop"},
        "customer": {"customer"},
        "workshop": {"workshop"},
        "annex": {"annex"},
        "all": {"customer", "workshop", "annex"},
    }
    for part in ("workshop", "annex"):
        assert "Behind this page" not in said[part]
    assert "Behind this page: Workshop report." in said["report"]
    assert set(DOCUMENTS["workshop"]) | set(DOCUMENTS["annex"]) | set(DOCUMENTS["customer"]) == set(DOCUMENTS["all"])
    assert set(PDF_SECTIONS) - set(DOCUMENTS["all"]) == {"matrix"}, "printed by its name alone"
    assert list(PRINTED) == list(DOCUMENTS)


def test_an_unknown_document_is_refused_with_the_known_ones(worn) -> None:
    with pytest.raises(InputError, match=r"no such document.*'workshop'"):
        write_pdf(worn, document="workshp")
