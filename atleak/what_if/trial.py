"""Compute a unit as it is tried, beside the job at its own condition, and as each variant of the source study."""

from __future__ import annotations

from dataclasses import dataclass, replace

from atleak.diagnosis import Diagnosis
from atleak.engine.leakage import narrow_gap_messages
from atleak.engine.projection import Projection, project, project_unworn
from atleak.errors import DomainError, InputError, Message
from atleak.rules import Rule, unit_rules
from atleak.sentence import Sentence
from atleak.variants import VARIANTS, Variant
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


STUDY_CONTROLLER = "four_speed_2023"  # the valve body of the source study


@dataclass(frozen=True)
class StudyTrial:
    """One variant of the source study, and this unit tried likewise."""

    variant: Variant
    here: Projection | None  # None where it cannot be tried
    why_not: Sentence  # "" where it can


def like_the_study(diagnosis: Diagnosis, settings: WhatIf) -> tuple[StudyTrial, ...]:
    """Try a unit as each of the source study's variants W1 to W8, at the condition of the settings.

    Taken from a variant are temperature, wear and age of the fluid: every land as new and grown by the variant's
    fraction. Fluid, pressures, engine speed, gear and position of the spools are those of the settings. The article's
    own numbers are of its valve body, and the largest of its road test: they compare with another unit's in how they
    grow from variant to variant, not in size.
    """
    trials = []
    for variant in VARIANTS:
        as_variant = replace(
            settings,
            temperature=variant.temperature,
            wear=0.0,
            growth=variant.wear,
            fluid_state="used" if variant.used_oil else "fresh",
        )
        try:
            here = project(as_variant.model(diagnosis), as_variant.condition(diagnosis))
            trials.append(StudyTrial(variant, here, Sentence("")))
        except (DomainError, InputError) as error:
            trials.append(StudyTrial(variant, None, error.sentence))
    return tuple(trials)


def is_the_study_s(diagnosis: Diagnosis) -> bool:
    """Return whether the unit's valve body is that of the source study."""
    return diagnosis.controller.id == STUDY_CONTROLLER
