"""The engine behind a diagnosis, for what a report says of it."""

from __future__ import annotations

from atleak.diagnosis import Diagnosis
from atleak.leakage import LeakageModel


def engine_of(diagnosis: Diagnosis) -> LeakageModel:
    """Controller, clearances, fluid and profile as they were when the unit was diagnosed."""
    states = tuple(found.state for found in diagnosis.lands)
    return LeakageModel(diagnosis.controller, states, diagnosis.fluid, diagnosis.profile)
