"""Bring what a job's record says of the measuring into the choices of its case."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from atleak.job.case import CaseKind
from atleak.job.record import Job


def with_record(case: CaseKind, job: Job) -> CaseKind:
    """Return a case with the mileage, the measuring temperature and the pump's clearances that the record states.

    Parameters
    ----------
    case
        what it says of these counts.
    job
        what the workshop wrote down.
    """
    stated: dict[str, Any] = {"mileage": job.vehicle.mileage_km, "measuring_temperature": job.measuring_temperature_c}
    missing = {name: value for name, value in stated.items() if getattr(case, name) is None}
    return replace(case, **missing, pump_clearances=case.pump_clearances.or_else(job.pump_clearances))
