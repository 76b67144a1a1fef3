"""What the pages for developers name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from atleak.diagnosis.uncertainty.assumptions import DEFAULTS
from atleak.version import __version__

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


def test_every_assumption_that_can_be_set_is_named(root: Path) -> None:
    text = (root / "docs" / "uncertainty.md").read_text(encoding="utf-8")
    assert {name for name in DEFAULTS.settings if f"`{name}`" not in text} == set()


def test_what_is_to_be_cited_is_this_version(root: Path) -> None:
    lines = (root / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {__version__}" in lines
