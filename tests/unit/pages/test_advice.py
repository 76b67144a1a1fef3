"""Sentences that several pages show."""

from __future__ import annotations

from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.printed_names import PrintedNames
from pages.shared import pairs


def test_every_open_verdict_that_is_listed_says_how_it_can_be_decided(sample_diagnoses: dict[str, Diagnosis]) -> None:
    sample, say = sample_diagnoses["workshop"], wording("en")
    lines = pairs.advice(sample, PrintedNames(sample, Job(), say).advice, say)
    assert any(line.startswith("- **26/2 manual selector valve**: wear 56.8") for line in lines)
    assert not [line for line in lines if line.rstrip().endswith("**:")]
