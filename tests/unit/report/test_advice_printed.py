"""What a report advises where the measurement leaves a verdict open."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.catalogue.limits import LimitOrigin, Steps
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.job_card import Job
from atleak.report.printed_names import PrintedNames


@pytest.fixture(scope="module")
def near(worn: Diagnosis) -> Diagnosis:
    """The worn unit judged by a limit at what one of its lands measured: no measurement can decide that one."""
    at = max(land.state.radial_clearance for land in worn.lands if land.state.measured)
    steps = Steps(((Verdict.WATCH, 0.9995 * at),), LimitOrigin.WORKSHOP, "")
    limits = replace(worn.limits, wear=None, clearance=steps, pair_share=None)
    return diagnose(worn.controller, worn.fluid, limits, readings=worn.readings)


@pytest.mark.parametrize("language", languages())
def test_lands_that_only_judgement_decides_stand_together_with_one_advice(near: Diagnosis, language: str) -> None:
    say = wording(language)
    names = PrintedNames(near, Job(), say)
    judged = [land for land in near.flagged if land.decision == "conditional_fail"]
    assert judged
    twice = [*judged, *judged[:1]]
    (said,) = names.advice_by_group(twice)
    assert said.count(say("advice.judgement")) == 1
    named = names.land_number if len(twice) > 3 else names.land_name  # many are named in short
    assert all(said.count(named(land)) >= twice.count(land) for land in judged)
    for part in ("spool", "sleeve"):
        again = say("advice.first", part=say(f"advice.{part}"), fraction="#").split("#")[0]
        assert again not in said
