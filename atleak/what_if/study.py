"""Put the source study's variants beside a unit: the same temperatures, wear and age of the fluid, tried with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection, project
from atleak.errors import DomainError, InputError
from atleak.sentence import Sentence
from atleak.variants import VARIANTS, Variant
from atleak.what_if.settings import WhatIf

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
    return tuple(_trials(diagnosis, settings))


def _trials(diagnosis: Diagnosis, settings: WhatIf) -> Iterator[StudyTrial]:
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
            yield StudyTrial(variant, here, Sentence(""))
        except (DomainError, InputError) as error:
            yield StudyTrial(variant, None, error.sentence)


def is_the_study_s(diagnosis: Diagnosis) -> bool:
    """Return whether the unit's valve body is that of the source study."""
    return diagnosis.controller.id == STUDY_CONTROLLER
