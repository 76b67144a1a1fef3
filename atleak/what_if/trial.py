"""Compute a unit as it is tried, beside the job at its own condition."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.diagnosis import Diagnosis
from atleak.engine.leakage import narrow_gap_messages
from atleak.engine.projection import Projection, project, project_unworn
from atleak.errors import Message
from atleak.rules import Rule, unit_rules
from atleak.what_if.settings import WhatIf


@dataclass(frozen=True)
class Tried:
    """The unit as it is tried, and the job beside it."""

    settings: WhatIf
    projection: Projection  # as it is tried
    job: Projection  # of the job, at the condition from which this departs
    total: Rule  # of the total share as it is tried
    pressures: tuple[Rule, ...]  # of reserve, circuits and permissible pressure as they are tried
    messages: tuple[Message, ...]  # where what was tried is outside of what is known, and what is assumed

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that judges the unit as it is tried."""
        return (self.total, *self.pressures)


def tried(diagnosis: Diagnosis, settings: WhatIf) -> Tried:
    """Compute what a unit would do at other settings; the diagnosis stays as it is.

    Parameters
    ----------
    diagnosis
        of the job.
    settings
        what of it is tried otherwise.

    Returns
    -------
    Tried
        judged by the job's limits, beside the same unit new at the tried condition with the tried fluid.

    Raises
    ------
    DomainError
        a temperature outside the fluid's data.
    InputError
        a setting that cannot be: see `WhatIf`.
    """
    model, condition = settings.model(diagnosis), settings.condition(diagnosis)
    projection = project(model, condition)
    states = [land.state for land in diagnosis.lands]
    unworn = project_unworn(states, model, [projection])
    rules = unit_rules((), [projection], unworn, diagnosis.limits, diagnosis.controller.operating_points)
    temperature = condition.temperature
    return Tried(
        settings=settings,
        projection=projection,
        job=diagnosis.at(settings.base(diagnosis)),
        total=rules.totals[0],
        pressures=rules.pressures,
        messages=(
            *model.fluid.messages(temperature, temperature, model.profile.viscosity),
            *projection.messages,
            *narrow_gap_messages(projection.gaps),
        ),
    )
