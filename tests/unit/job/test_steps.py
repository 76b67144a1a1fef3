"""How far a job is, step by step."""

from __future__ import annotations

from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.job.result import job_steps
from atleak.measurements.job_card import Job, Vehicle

PISTON = "component;part;plane;direction;diameter [mm]\naccumulator;piston;1;0;17,999\naccumulator;piston;1;90;17,999\n"
SLEEVE = "accumulator;sleeve;1;0;18,028\naccumulator;sleeve;1;90;18,028\n"


def said(diagnosis: Diagnosis, job: Job) -> dict[str, tuple[bool, str]]:
    return {step.name: (step.complete, step.state) for step in job_steps(diagnosis, job, wording("en"))}


def diagnosed(sheet: str) -> Diagnosis:
    return Case(readings=SourceFile("a.csv", sheet.encode()), controller="minimal_example").diagnose()


def test_an_empty_job_says_what_is_missing_of_each_step() -> None:
    steps = said(Case(controller="minimal_example").diagnose(), Job())
    assert steps["job"] == (False, "no number yet")
    assert steps["measure"] == (False, "none yet")
    assert steps["in_the_car"] == (False, "none yet")
    assert steps["diagnosis"] == (False, "○ not measured")
    assert list(steps) == ["job", "measure", "in_the_car", "diagnosis", "plan", "report"]


def test_one_good_land_of_several_is_good_so_far_only() -> None:
    steps = said(diagnosed(PISTON + SLEEVE), Job(vehicle=Vehicle(registration="KR 12345")))
    assert steps["job"] == (True, "KR 12345")
    assert steps["measure"][1].startswith("1 of ")
    assert steps["diagnosis"] == (True, "● ok so far")


def test_a_part_alone_measures_no_land() -> None:
    assert said(diagnosed(PISTON), Job(number="7"))["diagnosis"] == (False, "○ not measured")


def test_gauges_within_their_limits_are_good_so_far_only() -> None:
    gauges = SourceFile("g.csv", b"range;condition;pressure [kPa]\nD;slow idle;450\n")
    steps = said(Case(pressures=gauges, controller="four_speed_2023").diagnose(), Job())
    assert steps["diagnosis"] == (True, "● ok so far")
