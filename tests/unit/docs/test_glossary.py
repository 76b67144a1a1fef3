"""The glossary has an anchor for every term that pages link to."""

from __future__ import annotations

from .pages import anchors, text_of

GLOSSARY = "docs/nomenclature.md"
TERMS = """
land precision-pair diametral-clearance mounting-clearance contact-length wear growth share pressure-held leakage
verdict decision conditional provisional representative concentric-band hot-idle operating-point controller valve-body
main-pressure circuit feed interval repeatability profile job job-file job-book channel
"""


def test_every_term_has_an_anchor_and_none_has_two() -> None:
    found = anchors(text_of(GLOSSARY))
    assert {term: found[term] for term in TERMS.split()} == dict.fromkeys(TERMS.split(), 1)
