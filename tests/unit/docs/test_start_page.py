"""The start page leads everywhere, and to the README for the set-up."""

from __future__ import annotations

import re

from tests.unit.docs.pages import ROOT, links, pages, split, text_of


def set_up(page: str) -> list[str]:
    """The command lines with which a page has atleak installed."""
    lines = [line for block in split(text_of(page))[1] for line in block.text.splitlines()]
    return [line for line in lines if line.startswith("python -m pip install")]


def test_the_readme_has_the_set_up_and_the_start_page_leads_there() -> None:
    assert len(set_up("README.md")) == 2
    assert set_up("docs/index.md") == []
    assert "../README.md" in links(text_of("docs/index.md"))


def test_every_page_is_in_the_navigation_of_the_site_and_on_its_start_page() -> None:
    there = {page.removeprefix("docs/") for page in pages() if page.startswith("docs/")}
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("\nnav:\n")[1]
    assert set(re.findall(r"[\w./-]+\.md", navigation)) == there
    led = {link.partition("#")[0] for link in links(text_of("docs/index.md"))}
    assert {page for page in there - led if not page.startswith("reference/")} == {"index.md"}
