"""``atleak evidence``: what is printed first, and from how little it works."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]
FIVE = ("--controller", "five_speed_2005")


@pytest.fixture
def low_clutch(tmp_path: Path) -> Path:
    path = tmp_path / "gauges.csv"
    path.write_text("tap,range,slow idle [kPa]\nline,D,857\nforward clutch,D,610\n", encoding="utf-8")
    return path


def test_with_a_complaint_alone_it_says_that_this_is_what_is_assumed(run: Run) -> None:
    status, out, err = run("evidence", *FIVE, "--complaint", "slips_hot")
    assert (status, err) == (0, "")
    title, first, *_ = filter(None, out.splitlines())
    assert title == "What is likely worn"
    assert first.startswith("Nothing that was read sets a land or a circuit apart")
    assert "Likely worn" not in out
    assert "worn_lands_percent" in out


def test_what_is_likely_stands_first_then_tables_then_what_to_measure(run: Run, low_clutch: Path) -> None:
    out = run("evidence", *FIVE, "--pressures", low_clutch)[1]
    assert out.strip().splitlines()[1].startswith("Forward clutch has lost ")
    places = [out.index(f"\n{title}\n") for title in ("Lands", "What to measure next", "What is assumed")]
    assert places == sorted(places)


def test_an_assumption_that_is_set_counts(run: Run, low_clutch: Path) -> None:
    def worn(*options: str) -> float:
        record = json.loads(run("evidence", *FIVE, "--pressures", low_clutch, *options, "--json", "-")[1])
        return sum(each["probability_worn"] for each in record["lands"])

    assert worn("--assume", "worn_lands_percent=2") < 0.5 * worn()


def test_pressures_are_shown_in_the_readers_units(run: Run, low_clutch: Path) -> None:
    out = run("evidence", *FIVE, "--pressures", low_clutch, "--units", "us")[1]
    assert "psi" in out.splitlines()[2]


def test_a_valve_body_without_circuits_is_taken(run: Run) -> None:
    status, out, _ = run("evidence", "--controller", "four_speed_2023", "--json", "-")
    assert status == 0
    assert json.loads(out)["circuits"] == []
