"""Every link of every page leads somewhere: to a file that is there and, where it names one, to an anchor in it."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from tests.unit.docs.pages import ROOT, anchors, links, pages, slug, text_of

PAGES = pages()


def faults(page: str) -> list[str]:
    """Links of a page that lead nowhere."""
    found = []
    for link in links(text_of(page)):
        if re.match(r"[a-z]+:", link):
            parts = urlsplit(link)
            if parts.scheme != "https" or not re.fullmatch(r"([\w-]+\.)+[a-z]{2,}", parts.netloc):
                found.append(f"{link}: no address with https")
            continue
        path, _, anchor = unquote(link).partition("#")
        target = (ROOT / page).parent.joinpath(path).resolve() if path else ROOT / page
        if not target.exists() or (path and not target.is_relative_to(ROOT)):
            found.append(f"{link}: no such file")
        elif anchor and anchors(target.read_text(encoding="utf-8"))[anchor] != 1:
            found.append(f"{link}: no such anchor, or several")
    return found


@pytest.mark.parametrize("page", PAGES)
def test_every_link_leads_somewhere(page: str) -> None:
    assert faults(page) == []


def test_the_readme_leads_to_pages_and_their_parts() -> None:
    led = links(text_of("README.md"))
    assert len([link for link in led if link.startswith("docs/")]) > 5
    assert any("#" in link for link in led)


def test_links_that_lead_nowhere_are_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    lost = '[a](none.md), [b](#no-part), ![c](none.png), [d](http://example.org), <img src="none.svg">, `[e](f.md)`'
    page.write_text(f"# Some part\n\n{lost}, [g](#some-part)\n\n```text\n[h](i.md)\n```\n", encoding="utf-8")
    assert [fault.partition(":")[0] for fault in faults(str(page))] == [
        "none.md", "#no-part", "none.png", "http", "none.svg",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("title", "anchor"),
    [
        ("What is written over?", "what-is-written-over"),
        ("The share, *U_p*, and `p_g`", "the-share-u_p-and-p_g"),
        ("Wear – over mileage (W3 & W4)", "wear--over-mileage-w3--w4"),
        ("Größe äußerer Schlüssel", "größe-äußerer-schlüssel"),
    ],
)
def test_an_anchor_is_made_of_a_heading_as_code_hosts_make_it(title: str, anchor: str) -> None:
    assert slug(title) == anchor
