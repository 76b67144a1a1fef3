"""The glossary has an anchor for every term that pages link to, and the pages of docs do link to it."""

from __future__ import annotations

from .pages import anchors, links, pages, text_of

GLOSSARY = "docs/nomenclature.md"
TERMS = """
land precision-pair diametral-clearance mounting-clearance contact-length wear growth share pressure-held leakage
verdict decision conditional provisional representative concentric-band hot-idle operating-point controller valve-body
main-pressure circuit feed interval repeatability profile job job-file job-book channel
"""


def test_every_term_has_an_anchor_and_none_has_two() -> None:
    found = anchors(text_of(GLOSSARY))
    assert {term: found[term] for term in TERMS.split()} == dict.fromkeys(TERMS.split(), 1)


def test_every_page_leads_to_the_glossary() -> None:
    own = [page for page in pages() if page.startswith("docs/") and "/reference/" not in page and page != GLOSSARY]
    assert len(own) > 15
    assert [page for page in own if not any("nomenclature.md" in link for link in links(text_of(page)))] == []
