"""What the terminal shows in US units: no metric unit, and no more digits than a gauge or a micrometer gives."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.common.units import SYSTEMS

Run = Callable[..., tuple[int, str, str]]
US, METRIC = SYSTEMS["us"], SYSTEMS["metric"]
NOT_US = {METRIC[kind].name for kind in METRIC} - {unit.name for unit in US.values()} - {""}
DIGITS = {US[kind].name: US[kind].digits for kind in ("pressure", "temperature", "flow", "leak", "distance")} | {
    "in": 5
}
ONE_MORE = {"psi", "gpm"}  # of a difference, or of what is too small for the usual ones
FIVE = "sample_data/measuring_sheet_five_speed.xlsx"
GAUGES = "sample_data/gauge_readings_five_speed.csv"


@pytest.mark.parametrize(
    "command",
    [
        "diagnose sample --road-test sample --complaint slips_hot",
        f"diagnose {FIVE} --controller five_speed_2005 --pressures {GAUGES}",
        "import-log sample",
        "fluids",
        "instruments",
    ],
)
def test_the_terminal_shows_us_units_with_the_digits_of_their_kind(
    run: Run, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[3])
    monkeypatch.setenv("COLUMNS", "400")
    status, out, err = run(*command.split(), "--units", "us")
    assert (status, err) == (0, "")
    said = re.sub(r"\w+ \[[^\]]+\]|'[^']*'|km \(source", "", out) if command.startswith(("import", "fluids")) else out
    assert not NOT_US & set(re.split(r"[\s\xa0()\[\],;:│]+", said))
    for number, unit in re.findall(r"([\d.]+)[\s\xa0](psi|°F|gpm|in³/min|mi|in)(?![\w/])", said):
        places = len(number.rstrip(".").partition(".")[2])
        assert places <= DIGITS[unit] + (unit in ONE_MORE), (number, unit)
