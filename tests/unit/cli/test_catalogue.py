"""The lists of the catalogue."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.catalogue.entries import catalogue_files

Run = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("kind", ["controllers", "fluids", "limits", "instruments"])
def test_the_catalogue_as_json_and_as_a_table(run: Run, kind: str) -> None:
    status, out, err = run(kind, "--json", "-")
    assert (status, err) == (0, "")
    rows = json.loads(out)
    assert [row["id"] for row in rows] == list(catalogue_files(kind))
    assert all(row["source"] for row in rows)
    status, out, err = run(kind)
    assert (status, err) == (0, "")
    assert "id" in out


def test_the_catalogue_into_a_file_is_shown_too(run: Run, tmp_path: Path) -> None:
    status, out, _ = run("limits", "--json", tmp_path / "limits.json")
    assert status == 0
    rows = json.loads((tmp_path / "limits.json").read_text(encoding="utf-8"))
    assert "project_default" in {row["id"] for row in rows}
    assert "project_default" in out


def test_a_controller_lists_its_complaints(run: Run) -> None:
    _, out, _ = run("controllers", "--json", "-")
    study = next(row for row in json.loads(out) if row["id"] == "four_speed_2023")
    assert [complaint["id"] for complaint in study["complaints"]] == ["slips_hot", "slips_in_second"]
    for complaint in study["complaints"]:
        assert set(complaint["conditions"]) <= set(study["operating_points"])
