"""Sentences that reports share: figures that people can use, and none that nobody can foresee."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import pandas as pd
import pytest

from atleak.diagnosis import Diagnosis, LandDiagnosis, ReplaceMileage
from atleak.report.xlsx import write_workbook
from atleak.views.diagnosis_record import diagnosis_record, to_json
from atleak.views.sentences import replace_at
from atleak.wording import wording

INFINITE = float("inf")


def reaching(sample: Diagnosis, at: ReplaceMileage | None) -> LandDiagnosis:
    return replace(sample.lands[0], replace_mileage=at)


@pytest.mark.parametrize(
    ("at", "said"),
    [
        (ReplaceMileage(157_861.7, 139_204.0, 184_301.0), "160 000 km (140 000 to 180 000)"),
        (ReplaceMileage(432_853.9, 270_000.0, 1_000_000.0), "430 000 km (270 000 to 1 000 000)"),
        (ReplaceMileage(1_144_394.0, 400_000.0, 5_000_000.0), "not foreseeable"),
        (ReplaceMileage(None, 300_000.0, INFINITE), "not foreseeable"),
        (None, None),
    ],
)
def test_a_mileage_is_rounded_with_its_interval_or_not_foreseeable(
    sample: Diagnosis, at: ReplaceMileage | None, said: str | None
) -> None:
    words = replace_at(reaching(sample, at), wording("en"))
    assert (None if words is None else words.replace("\u00a0", " ")) == said


@pytest.mark.parametrize(("language", "said"), [("de", "nicht absehbar"), ("pl", "nie do przewidzenia")])
def test_it_is_said_in_every_language(sample: Diagnosis, language: str, said: str) -> None:
    assert replace_at(reaching(sample, ReplaceMileage(None, 1.0, INFINITE)), wording(language)) == said


def test_the_record_keeps_the_numbers_as_they_are(sample: Diagnosis) -> None:
    at = ReplaceMileage(1_144_394.25, 400_000.5, INFINITE)
    lands = (reaching(sample, at), *sample.lands[1:])
    row = json.loads(to_json(diagnosis_record(replace(sample, lands=lands))))["lands"][0]
    assert row["replace_mileage_km"] == 1_144_394.25
    assert row["replace_mileage_low_km"] == 400_000.5
    assert row["replace_mileage_high_km"] is None


def test_the_workbook_gives_words_and_no_figure_beyond_what_a_vehicle_runs(sample: Diagnosis) -> None:
    lands = pd.read_excel(io.BytesIO(write_workbook(sample)), sheet_name="Lands", engine="calamine")
    column = next(name for name in lands if name.startswith("replace at"))
    said = {str(value).replace("\u00a0", " ") for value in lands[column].dropna()}
    assert "not foreseeable" in said
    assert any(value.endswith(")") and " km (" in value for value in said)
