"""``atleak gauge-study``."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def study(tmp_path: Path) -> Path:
    random = np.random.default_rng(7)
    rows = ["part;operator;trial;reading [mm]"]
    rows += [
        f"{part};{'ABC'[who]};{trial};{12.7 + 0.01 * part + 0.001 * random.standard_normal():.4f}".replace(".", ",")
        for part, who, trial in np.ndindex(5, 3, 3)
    ]
    path = tmp_path / "study.csv"
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def test_a_study_is_shown_with_its_verdict(run: Run, study: Path) -> None:
    status, out, _ = run("gauge-study", study, "--tolerance", "0,02")
    assert status == 0
    assert "of the tolerance is of gauge and people" in " ".join(out.split())
    assert "Measurement Systems Analysis" in " ".join(out.split())


def test_the_record_holds_what_the_study_says(run: Run, study: Path) -> None:
    status, out, err = run("gauge-study", study, "--json", "-")
    assert (status, err) == (0, "")
    record = json.loads(out)
    assert (record["trials"], record["operators"]) == (3, ["A", "B", "C"])
    assert record["grr_of_tolerance_percent"] is None
    named = {row["component"]: row for row in record["components"]}
    assert named["grr"]["of_study_percent"] == record["grr_of_study_percent"]
    assert 0.7 < named["repeatability"]["deviation_um"] < 1.3


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--tolerance", "wide"], "--tolerance is not a number"),
        (["--alpha", "5"], "the level of significance is none"),
        (["--unit", "furlong"], "unknown unit of length"),
    ],
)
def test_an_option_that_cannot_be_used_is_named(run: Run, study: Path, options: list[str], said: str) -> None:
    status, out, err = run("gauge-study", study, *options)
    assert (status, out) == (2, "")
    assert said in err


def test_a_file_that_is_not_there_is_named(run: Run, tmp_path: Path) -> None:
    status, _, err = run("gauge-study", tmp_path / "none.xlsx")
    assert status == 2
    assert "none.xlsx: no such file" in err
