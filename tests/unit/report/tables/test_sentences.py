"""Sentences that reports share: figures that people can use, and none that nobody can foresee."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace

import pandas as pd
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import Crossing, LandDiagnosis
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.tables.sentences import readings_in_doubt, replace_at, wear_words
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook

INFINITE = float("inf")
NOW = 106_315.0  # [km]


def reaching(sample: Diagnosis, at: Crossing | None) -> LandDiagnosis:
    return reaching_of(sample.lands[0], at)


def reaching_of(land: LandDiagnosis, at: Crossing | None) -> LandDiagnosis:
    return replace(land, replace_mileage=at)


@pytest.mark.parametrize(
    ("at", "said"),
    [
        (Crossing(157_861.7, 139_204.0, 184_301.0, NOW), "160 000 km (140 000 to 180 000)"),
        (Crossing(432_853.9, 270_000.0, 1_000_000.0, NOW), "430 000 km (270 000 to 1 000 000)"),
        (Crossing(1_144_394.0, 408_000.0, 5_000_000.0, NOW), "not before 400 000 km"),
        (Crossing(5e6, 3e6, INFINITE, NOW), "not before 1 000 000 km"),
        (Crossing(5e6, 203_456.0, INFINITE, 201_900.0), "not before 203 456 km"),  # 200 000 km are behind it
        (Crossing(260_000.0, 201_900.0, 380_000.0, 201_900.0), "260 000 km (201 900 to 380 000)"),
        (Crossing(800_000.0, NOW, INFINITE, NOW), "not foreseeable"),
        (None, None),
    ],
)
def test_a_mileage_is_rounded_with_its_interval_or_not_foreseeable(
    sample: Diagnosis, at: Crossing | None, said: str | None
) -> None:
    words = replace_at(reaching(sample, at), wording("en"))
    assert (None if words is None else words.replace("\u00a0", " ")) == said


@pytest.mark.parametrize(
    ("language", "said"),
    [("de", ["nicht absehbar", "nicht vor 410"]), ("pl", ["nie do przewidzenia", "nie wcześniej"])],
)
def test_it_is_said_in_every_language(sample: Diagnosis, language: str, said: list[str]) -> None:
    for low, words in zip((NOW, 4.1e5), said, strict=True):
        at = Crossing(INFINITE, low, INFINITE, NOW)
        assert replace_at(reaching(sample, at), wording(language)).startswith(words)


def test_the_record_keeps_the_numbers_as_they_are(sample: Diagnosis) -> None:
    at = Crossing(1_144_394.25, 400_000.5, 2e6, NOW)
    lands = (reaching(sample, at), *sample.lands[1:])
    row = json.loads(to_json(diagnosis_record(replace(sample, lands=lands))))["lands"][0]
    assert row["replace_mileage_km"] == 1_144_394.25
    assert row["replace_mileage_low_km"] == 400_000.5
    assert row["replace_mileage_high_km"] == 2e6
    lands = (reaching(sample, replace(at, high=INFINITE)), *sample.lands[1:])
    row = json.loads(to_json(diagnosis_record(replace(sample, lands=lands))))["lands"][0]
    assert (row["replace_mileage_km"], row["replace_mileage_high_km"]) == (None, None)


def test_the_workbook_gives_words_and_no_figure_beyond_what_a_vehicle_runs(sample: Diagnosis) -> None:
    reached = Crossing(157_861.7, 139_204.0, 184_301.0, NOW), Crossing(800_000.0, NOW, INFINITE, NOW)
    projected = [reaching_of(land, at) for land, at in zip(sample.lands, reached, strict=False)]
    unit = replace(sample, lands=(*projected, *sample.lands[2:]))
    lands = pd.read_excel(io.BytesIO(write_workbook(unit)), sheet_name="Lands", engine="calamine")
    column = next(name for name in lands if name.startswith("replace at"))
    said = {str(value).replace("\u00a0", " ") for value in lands[column].dropna()}
    assert said == {"not foreseeable", "160 000 km (140 000 to 180 000)"}


def test_a_verdict_on_pairs_tighter_than_new_says_so_at_once(
    sample: Diagnosis,
    four_speed: Controller,
    hipol: Fluid,
    limits: Limits,
    readings_of: Callable,
    capsys: pytest.CaptureFixture[str],
) -> None:
    half = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 1.04 * land.new_clearance)
        for land in four_speed.lands
    }
    tight = diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, half))
    said = "Measured lands tighter than new ones: 47. Wear cannot do that, so they are not passed"
    assert (readings_in_doubt(tight, wording("en")) or "").startswith(said)
    assert "47" in (readings_in_doubt(tight, wording("de")) or "")
    print_diagnosis(tight)
    head = " ".join(capsys.readouterr().out.split())
    assert head.index("unit: ▲ watch") < head.index(said) < head.index("driving in second")
    assert readings_in_doubt(sample, wording("en")) is None


@pytest.mark.parametrize("language", languages())
def test_a_clearance_that_new_pairs_have_is_no_negative_wear(hipol, limits, readings_of, language: str) -> None:
    for name in ("five_speed_2005", "gm_4l60e", "jatco_jf506e"):  # known new as a range
        unit, say = load_controller(name), wording(language)
        within, tight, wide = unit.lands[:3]
        low, high = within.mounting_range
        assert low < high
        clearances = {within.key: 0.5 * (low + high), tight.key: 0.5 * low, wide.key: 1.3 * high}
        sizes = {
            land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * clearances[land.key])
            for land in (within, tight, wide)
        }
        found = diagnose(unit, hipol, limits, readings=readings_of(unit, sizes))
        lands = {land.key: land for land in found.lands}
        assert wear_words(lands[within.key], say) == say("texts.within_new")
        assert wear_words(lands[tight.key], say) == say.percent(lands[tight.key].wear, 0)
        assert wear_words(lands[wide.key], say, unit=False) == "30"
        assert wear_words(lands[unit.lands[4].key], say) == "–"
