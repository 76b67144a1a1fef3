"""What the pages for developers name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGES = ("CONTRIBUTING.md", "docs/architecture.md", "docs/nomenclature.md")
FOLDERS = ("atleak", "tests", "pages", "docs", "benchmarks")
KEY = re.compile(r"`(\w+_(?:um|mm|kpa|percent|dm3_min|rpm|c|mm2_s|g_cm3|mm3|per_k))`")


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_names_is_there(root: Path, page: str) -> None:
    text = (root / page).read_text(encoding="utf-8")
    named = [name for name in re.findall(r"`([\w./*]+)`", text) if name.split("/")[0] in FOLDERS and "/" in name]
    assert named
    for name in named:
        assert list(root.glob(name.rstrip("/"))), name
    links = [link for link in re.findall(r"\]\(([^)#]+)", text) if not link.startswith("http")]
    for link in links:
        assert (root / page).parent.joinpath(link).is_file(), link


def test_every_key_with_a_unit_in_the_nomenclature_is_one_of_the_program(root: Path) -> None:
    keys = set(KEY.findall((root / "docs" / "nomenclature.md").read_text(encoding="utf-8")))
    assert len(keys) > 10
    files = [path for form in ("*.py", "*.toml") for path in (root / "atleak").rglob(form)]
    known = "\n".join(path.read_text(encoding="utf-8") for path in files)
    assert not {key for key in keys if key not in known}


TERMS = """
land precision-pair diametral-clearance mounting-clearance contact-length wear growth share pressure-held leakage
verdict decision conditional provisional representative concentric-band hot-idle operating-point controller valve-body
main-pressure circuit feed interval repeatability profile job job-file job-book channel
"""
INTO_THE_GLOSSARY = re.compile(r"nomenclature\.md#([^)]+)\)")


def anchors(page: Path) -> list[str]:
    """The anchors of a page's headings, as code hosts and the site make them."""
    lines = page.read_text(encoding="utf-8").splitlines()
    headings = [line.lstrip("#").strip().lower() for line in lines if re.match(r"#{1,6} ", line)]
    return [re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in headings]


def test_the_glossary_has_an_anchor_for_every_term_and_no_anchor_twice(root: Path) -> None:
    found = anchors(root / "docs" / "nomenclature.md")
    assert not set(TERMS.split()) - set(found)
    assert len(found) == len(set(found))


def test_every_link_into_the_glossary_leads_to_a_term(root: Path) -> None:
    page = root / "docs" / "nomenclature.md"
    found = set(anchors(page))
    links = [(page, anchor) for anchor in re.findall(r"\]\(#([^)]+)\)", page.read_text(encoding="utf-8"))]
    for other in [root / "README.md", *(root / "docs").rglob("*.md")]:
        links += [(other, anchor) for anchor in INTO_THE_GLOSSARY.findall(other.read_text(encoding="utf-8"))]
    assert len(links) > 40
    assert not [f"{where.name}: {anchor}" for where, anchor in links if anchor not in found]
