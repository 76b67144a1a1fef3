"""The lists of the catalogue."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.catalogue.entries import KINDS, catalogue_files

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


def test_names_stay_legible_in_a_terminal_of_eighty_columns(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    _, out, _ = run("controllers")
    table = out[: out.index("└")]
    assert "…" not in table
    assert "0, 52, 158" in table


def test_a_long_source_leaves_a_name_more_than_a_word_a_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    _, out, _ = run("limits")
    assert "atleak default" in out
    assert len([line for line in out.splitlines() if line.startswith("│ ")]) <= 5


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


def test_the_own_catalogue_is_made_where_it_is_said_to_be(run: Run, home: Path) -> None:
    status, out, err = run("catalogue", "path")
    assert (status, out, err) == (0, f"{home / 'catalogue'}\n", "")
    assert sorted(path.name for path in (home / "catalogue").iterdir()) == sorted(KINDS)


def test_lists_show_own_entries_and_name_those_that_cannot_be_used(run: Run, home: Path) -> None:
    run("catalogue", "path")
    text = catalogue_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    folder = home / "catalogue" / "controllers"
    (folder / "my_box.toml").write_text(text.replace('id = "minimal_example"', 'id = "my_box"'), encoding="utf-8")
    (folder / "torn.toml").write_text("[", encoding="utf-8")
    status, out, err = run("controllers", "--json", "-")
    assert status == 0
    assert [row["id"] for row in json.loads(out) if row["own"]] == ["my_box"]
    assert err.startswith("atleak: left aside: torn.toml: is not valid TOML")
    _, out, _ = run("controllers")
    assert next(line for line in out.splitlines() if "my_box" in line).split("│")[-2].strip() == "yes"
