"""``docs/source-study.md`` says what the engine gives today, and names functions and tests that exist."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from atleak.analysis.source_study import compare_options, run_variants
from atleak.catalogue.controller import Controller
from atleak.engine.road_leakage import RoadLeakage
from atleak.readers.logs import read_road_test

DM3_MIN = 6e4


@pytest.fixture(scope="module")
def text(root: Path) -> str:
    return (root / "docs" / "source-study.md").read_text(encoding="utf-8")


def rows(text: str, first: str) -> list[list[str]]:
    """Table rows whose first cell matches."""
    matches = re.findall(rf"^\| ({first}) \| (.+) \|$", text, flags=re.MULTILINE)
    return [[head, *rest.split(" | ")] for head, rest in matches]


def test_table_3_of_the_document(text: str, four_speed: Controller, sample_log: Path) -> None:
    results = run_variants(four_speed, read_road_test(sample_log))
    written = rows(text, r"W\d")
    assert [row[0] for row in written] == [result.variant.name for result in results]
    for row, result in zip(written, results, strict=True):
        variant, most = result.variant, result.computed.max_leakage
        assert (row[1], row[3]) == (str(variant.printed_max_leakage), str(variant.printed_max_share))
        shown = [float(row[column]) for column in (2, 4)]
        computed = [most.leakage * DM3_MIN, most.share * 100]
        assert shown == pytest.approx(computed, rel=6e-4, abs=0.0)


def test_options_of_the_document(text: str, four_speed: Controller, sample_log: Path) -> None:
    paper, *others = compare_options(four_speed, read_road_test(sample_log))
    ((_, *names),) = rows(text, "options")

    def most(run: RoadLeakage | None) -> float:
        assert run is not None
        return run.max_leakage.leakage

    for row in others:
        (line,) = rows(text, re.escape(row.label))
        changes = [(most(row.runs[name]) / most(paper.runs[name]) - 1.0) * 100 for name in names]
        assert [float(cell) for cell in line[1:]] == pytest.approx(changes, rel=0.0, abs=0.0051)
    for run in (paper.runs["W8"], others[-1].runs["W8"]):
        assert f" {run.max_leakage.share * 100:.1f} %" in text


def test_named_functions_and_tests_exist(text: str, root: Path) -> None:
    table = text.split("## From equation to function to test")[1].split("All tests named")[0]
    module = ""
    for name in re.findall(r"`([a-z_0-9.A-Z/]+)`", table):
        if name.endswith((".py", ".toml")):
            place = root / "atleak" / name if name.startswith("catalogue") else root / "tests" / "literature" / name
            assert place.is_file(), name
            continue
        module, _, function = name.rpartition(".") if "." in name else (module, "", name)
        whole = module if module.startswith("tests.") else f"atleak.{module}"
        assert hasattr(importlib.import_module(whole), function), name
