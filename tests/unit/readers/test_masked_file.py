"""The form of a file, without what it says: no value, name, date, plate or vehicle number stays."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak import cli
from atleak.common.errors import InputError
from atleak.readers.masked_file import masked, masked_file

LOG = """# Nowak Automatik GmbH, Herr Kowalski, KR 7AB12
# VIN WVWZZZ1JZ3W386752, plate W-KX 4711, 2026-03-04 10:22
time [s];engine speed [rpm];TFT_Sensor [°C];note
0.00;812.4;78.31;Kowalski drove
0.02;815.9;78.33;
"""
PRIVATE = "Nowak", "Kowalski", "7AB12", "KR", "WVW", "386752", "4711", "KX", "2026", "812", "78", "drove"


def test_of_a_log_headings_and_form_stay_and_nothing_else() -> None:
    told = masked_file(LOG.encode(), "Kowalski.csv")
    assert [word for word in PRIVATE if word in told] == []
    assert "3: time [s];engine speed [rpm];TFT_Sensor [°C];note" in told
    assert "4: 9.99;999.9;99.99;" in told


def test_of_a_sheet_too(sample_readings: Path) -> None:
    told = masked_file(sample_readings)
    assert "sheet Measurements" in told
    assert "Component | Part | Plane | Direction | Repeat" in told
    assert "99.999" in told
    assert len(told.splitlines()) < 200
    rows = [line.split(": ", 1)[1] for line in told.splitlines() if ": " in line]
    assert not set("012345678") & set("".join(rows))


@given(st.text(max_size=80))
def test_no_digit_but_nine_stays(text: str) -> None:
    assert not set("012345678") & set(masked(text))


@pytest.mark.parametrize("number", ["WVWZZZ1JZ3W386752", "1HGCM82633A004352", "KR7AB12", "oil123"])
def test_signs_of_letters_and_digits_are_masked_whole(number: str) -> None:
    assert set(masked(number)) <= set("Aa9")


def test_the_command_writes_it_and_reads_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.csv"
    log.write_text(LOG, encoding="utf-8")
    assert cli.main(["import-log", str(log), "--report", "-"]) == 0
    said = capsys.readouterr()
    assert said.out == masked_file(log)
    assert said.err == ""


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be opened"):
        masked_file(tmp_path / "none.csv")
