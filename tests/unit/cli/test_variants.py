"""The source study."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

Run = Callable[..., tuple[int, str, str]]


def test_the_tables_of_the_variants_have_titles_and_their_columns_are_explained(run: Run) -> None:
    _, out, _ = run("variants")
    for said in ("Table 2: the variants", "Table 3: most leakage", "at its maximum over the log", "U largest: of the"):
        assert said in out
    assert "*" not in out


def test_eighty_columns_break_headings_at_spaces_and_cut_none(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    _, out, _ = run("variants")
    heads = [line for line in out.splitlines() if line.startswith("┃")]
    assert max(map(len, heads)) <= 80
    assert "…" not in out
    words = {word for line in heads for cell in line.split("┃") for word in cell.split()}
    assert {"variant", "printed", "computed", "largest", "digits", "[dm³/min]", "[mm²/s]"} <= words


def test_variants_has_the_promised_keys(run: Run) -> None:
    status, out, err = run("variants", "--json", "-")
    assert (status, err) == (0, "")
    rows = json.loads(out)["variants"]
    assert [row["variant"] for row in rows] == [f"W{number}" for number in range(1, 9)]
    promised = (
        "variant temperature_c wear_percent kinematic_viscosity_mm2_s density_g_cm3 kinematic_viscosity_used_mm2_s "
        "printed computed as_tabulated note"
    )
    for row in rows:
        assert [key for key in promised.split() if key not in row] == []
        both = {"max_leakage_dm3_min", "max_share_percent"}
        assert both <= set(row["printed"])
        assert both <= set(row["as_tabulated"])
        assert both | {"min_leakage_dm3_min", "share_at_max_leakage_percent"} <= set(row["computed"])
