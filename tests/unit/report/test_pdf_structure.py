"""What a screen reader and an archive find in the printed report: its tags, languages, properties and colours."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import pikepdf
import pytest
from PIL import Image

from atleak.catalogue.limits import LimitOrigin
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.pdf import write_pdf
from atleak.version import __version__


def picture() -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (30, 20), "#336699").save(target, "PNG")
    return target.getvalue()


@pytest.fixture(scope="module")
def worn(worn: Diagnosis) -> Diagnosis:
    """The same of a valve body whose source has no words in German."""
    return replace(worn, controller=replace(worn.controller, source="A handbook of 1998, page 12"))


@pytest.fixture(scope="module")
def document(worn: Diagnosis) -> Iterator[pikepdf.Pdf]:
    """The whole report in German, of which the catalogue's sources are in English."""
    job = Job(
        number="2026-17",
        vehicle={"registration": "KR 1234"},
        workshop={"name": "Example Workshop", "logo": "logo.png"},
        photos=[{"file": "open.png", "caption": "opened"}],
        notes="Told the customer.",
    ).with_pictures({"logo.png": picture(), "open.png": picture()})
    with pikepdf.open(io.BytesIO(write_pdf(worn, job, language="de"))) as opened:
        yield opened


def elements(node: pikepdf.Object) -> Iterator[pikepdf.Dictionary]:
    """Everything that is tagged, in the order of reading."""
    children = node.get("/K", ())
    for child in children if isinstance(children, pikepdf.Array) else (children,):
        if isinstance(child, pikepdf.Dictionary) and "/S" in child:
            yield child
            yield from elements(child)


def of_kind(node: pikepdf.Object, *kinds: str) -> list[pikepdf.Dictionary]:
    return [each for each in elements(node) if str(each.S) in kinds]


def test_every_picture_and_chart_has_words_for_who_cannot_see_it(document: pikepdf.Pdf) -> None:
    figures = of_kind(document.Root.StructTreeRoot, "/Figure")
    words = [str(each.get("/Alt", "")).strip() for each in figures]
    assert all(len(each) > 3 for each in words)
    assert {"Example Workshop", "opened"} < set(words)
    assert len(words) == len(set(words)) > 5


def test_every_table_has_headers_that_say_that_they_head_a_column(document: pikepdf.Pdf) -> None:
    tables = of_kind(document.Root.StructTreeRoot, "/Table")
    assert len(tables) > 10
    for table in tables:
        (head,) = of_kind(table, "/THead")
        cells = of_kind(head, "/TH", "/TD")
        assert {str(cell.S) for cell in cells} == {"/TH"}
        scopes = [[str(each.Scope) for each in cell.A if "/Scope" in each] for cell in cells]
        assert all(scope == ["/Column"] for scope in scopes)
        assert len(of_kind(table, "/TH")) == len(cells), "no row of the body is a header"


def test_names_and_values_are_a_list_and_no_table_without_headers(document: pikepdf.Pdf) -> None:
    root = document.Root.StructTreeRoot
    facts = [each for each in of_kind(root, "/L") if of_kind(each, "/Lbl")]
    assert len(facts) > 4
    for item in of_kind(root, "/LI"):
        assert [str(each.S) for each in item.K] == ["/Lbl", "/LBody"]


def test_headings_lead_down_without_a_gap(document: pikepdf.Pdf) -> None:
    say = wording("de")
    headings = [str(each.S) for each in of_kind(document.Root.StructTreeRoot, "/H1", "/H2", "/H3")]
    assert headings[0] == "/H1"
    assert Counter(headings)["/H1"] == 3, "the customer's page, the workshop's report and the annex"
    with document.open_outline() as outline:
        titles = [entry.title for part in outline.root for entry in (part, *part.children)]
    assert titles[:2] == [say("customer_screen.title"), say("documents.workshop")]
    assert len(titles) == len(headings)


def test_the_document_names_its_language_and_every_passage_in_another_one(
    document: pikepdf.Pdf, worn: Diagnosis
) -> None:
    assert str(document.Root.Lang) == "de"
    spoken = [each for each in elements(document.Root.StructTreeRoot) if "/Lang" in each]
    assert {str(each.Lang) for each in spoken} == {"en"}
    places = Counter(str(each.S) for each in spoken)
    say = wording("de")
    named = {worn.controller.source, worn.fluid.source, worn.limits.source} - {say("texts.source_study")}
    of_limits = [each.source for each in worn.limits.rules.values() if each.origin is not LimitOrigin.WORKSHOP]
    sources, limits = ([each for each in told if say.name(each) == each] for told in (named, of_limits))
    assert sources
    assert places == Counter({"/TD": len(limits), "/LBody": len(sources)})


def test_title_creator_and_colours_are_those_of_this_job(document: pikepdf.Pdf) -> None:
    title = f"{wording('de')('title.report')} · 2026-17 · KR 1234"
    with document.open_metadata() as metadata:
        assert metadata["dc:title"] == title
        assert metadata["xmp:CreatorTool"] == f"atleak {__version__}"
        assert set(metadata["dc:language"]) == {"de"}
        assert metadata["pdfuaid:part"] == "1"
        assert (metadata["pdfaid:part"], metadata["pdfaid:conformance"]) == ("2", "A")
    assert str(document.docinfo.Title) == title
    assert str(document.docinfo.Creator) == f"atleak {__version__}"
    assert bool(document.Root.ViewerPreferences.DisplayDocTitle)
    (intent,) = document.Root.OutputIntents
    assert str(intent.S) == "/GTS_PDFA1"
    assert len(intent.DestOutputProfile.read_bytes()) > 100
    assert bool(document.Root.MarkInfo.Marked)


def test_a_logo_of_a_workshop_without_a_name_has_words_too(worn: Diagnosis) -> None:
    job = Job(workshop={"logo": "logo.png"}).with_pictures({"logo.png": picture()})
    with pikepdf.open(io.BytesIO(write_pdf(worn, job, language="de", sections=[]))) as opened:
        (logo, *_) = of_kind(opened.Root.StructTreeRoot, "/Figure")
        assert str(logo.Alt) == wording("de")("title.logo")
        assert "/OutputIntents" in opened.Root
