"""The glossary has an anchor for every term that pages link to, and the pages of docs do link to it."""

from __future__ import annotations

from tests.unit.docs.pages import anchors, links, text_of

GLOSSARY = "docs/nomenclature.md"
TERMS = """
land precision-pair diametral-clearance mounting-clearance contact-length wear growth share pressure-held leakage
verdict decision conditional provisional representative concentric-band hot-idle operating-point controller valve-body
main-pressure circuit feed interval repeatability profile job job-file job-book channel
"""
#: Pages in which a newcomer stumbles over a word.
EXPLAINED = """
before-and-after cookbook describing-a-controller faq fleet gauge-study job-book json measuring-sheet model
pressure-table reports road-test-logs source-study uncertainty wear-over-mileage workshop-data
"""


def test_every_term_has_an_anchor_and_none_has_two() -> None:
    found = anchors(text_of(GLOSSARY))
    assert {term: found[term] for term in TERMS.split()} == dict.fromkeys(TERMS.split(), 1)


def test_pages_lead_to_the_glossary() -> None:
    for page in EXPLAINED.split():
        assert any("nomenclature.md#" in link for link in links(text_of(f"docs/{page}.md"))), page
