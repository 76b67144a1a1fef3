"""Say of each step of a job how far it is: what it holds, or what is missing."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.diagnosis import Diagnosis
from atleak.job.record import Job
from atleak.verdicts import Verdict
from atleak.wording import Wording


@dataclass(frozen=True)
class Step:
    """A step on a job's way: its name in the texts, whether anything is missing, and what is there or is missing."""

    name: str
    complete: bool
    said: str = ""


def job_steps(diagnosis: Diagnosis, job: Job, say: Wording) -> tuple[Step, ...]:
    """Return the steps of a job in their order.

    Parameters
    ----------
    diagnosis
        the job's result.
    job
        its record.
    say
        the reader's language.
    """
    lands, measured = len(diagnosis.lands), diagnosis.measured
    named = job.number or job.vehicle.registration or job.vehicle.vin
    readings = "all" if measured == lands else "some" if measured else "none"
    log = diagnosis.log
    verdict = say.signed(diagnosis.verdict)
    if measured < lands and not diagnosis.verdict.flagged and measured:
        verdict = say("steps.so_far", verdict=verdict)
    driven = say("steps.no_log") if log is None else f"{say.number(log.road_test.duration, 0)} s"
    return (
        Step("job", bool(named), named or say("steps.no_number")),
        Step("readings", measured == lands, say(f"steps.readings_{readings}", measured=measured, lands=lands)),
        Step("road_test", log is not None, driven),
        Step("diagnosis", diagnosis.verdict is not Verdict.NOT_MEASURED, verdict),
        Step("what_if", True),
        Step("report", True),
    )
