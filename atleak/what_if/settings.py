"""Say what of a job is tried otherwise: its condition, its fluid, its wear, where its spools lie."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal

from atleak.catalogue.fluid import Fluid, FluidState
from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis import Diagnosis
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import stated_condition
from atleak.errors import InputError, unknown
from atleak.sentence import Sentence
from atleak.what_if.wear import worn


class Axis(StrEnum):
    """Which of the two kinds of wear is varied."""

    WEAR = "wear"  # the growth that was measured, times a factor
    GROWTH = "growth"  # of every land, on top of that


@dataclass(frozen=True)
class WhatIf:
    """What is tried; None, like the defaults of wear and growth, leaves it as the job has it.

    Attributes
    ----------
    point
        name of the operating point whose pressures hold, and whose temperature, speed and gear where none is given;
        the stated condition unless given.
    temperature, engine_speed, gear
        [°C], [1/s] and the gear.
    wear
        factor on the growth of every measured land over a new one: 0 is as new, 1 as measured, 2 twice the wear.
    growth
        of every land's clearance on top of that, as a fraction of its clearance when new: the wear of the source
        study's variants is 0.1 or 0.5 of it.
    fluid
        as its data are; the job's unless given.
    fluid_state
        whether it is fresh or used; as in the job unless given.
    eccentricity
        e/c of every spool, 0 to 1, or ``unknown``.
    """

    point: str | None = None
    temperature: float | None = None
    engine_speed: float | None = None
    gear: int | None = None
    wear: float = 1.0
    growth: float = 0.0
    fluid: Fluid | None = None
    fluid_state: FluidState | None = None
    eccentricity: float | Literal["unknown"] | None = None

    def base(self, diagnosis: Diagnosis) -> OperatingPoint:
        """Return the condition of the job from which this departs.

        Raises
        ------
        InputError
            a point that the job does not have.
        """
        if self.point is None:
            return diagnosis.projection.condition
        points = {each.condition.name: each.condition for each in diagnosis.projections}
        if self.point not in points:
            raise unknown(Sentence("no such condition of the job"), self.point, points)
        return points[self.point]

    def condition(self, diagnosis: Diagnosis) -> OperatingPoint:
        """Return the condition that is tried; that of the job itself where nothing of it differs.

        Raises
        ------
        InputError
            a gear the valve body does not have, or a speed that is not positive.
        """
        base = self.base(diagnosis)
        asked = {"temperature": self.temperature, "engine_speed": self.engine_speed, "gear": self.gear}
        other = {name: value for name, value in asked.items() if value is not None and value != getattr(base, name)}
        return stated_condition(diagnosis.controller, base=base, **other) if other else base  # type: ignore[arg-type]

    def fluid_of(self, diagnosis: Diagnosis) -> Fluid:
        """Return the fluid that is tried, in its state.

        Raises
        ------
        InputError
            data of a used fluid, asked for fresh.
        """
        fluid = diagnosis.fluid if self.fluid is None else self.fluid
        state = self.fluid_state or ("used" if fluid.state == "used" else diagnosis.fluid.state)
        return fluid.in_state(state)

    def model(self, diagnosis: Diagnosis) -> LeakageModel:
        """Return the engine with the job's lands, fluid and profile as they are tried.

        Raises
        ------
        InputError
            a wear or growth below zero, an eccentricity outside 0 to 1, data of a used fluid asked for fresh.
        """
        for problem, value in (
            (Sentence("wear not accepted"), self.wear),
            (Sentence("growth not accepted"), self.growth),
        ):
            if not value >= 0.0:
                raise InputError(problem, value=value, expected=Sentence("0 or more"))
        model = diagnosis.model
        profile = model.profile
        if self.eccentricity is not None:
            profile = profile.with_options(eccentricity=self.eccentricity)
        states = tuple(land.state for land in diagnosis.lands)
        return replace(
            model,
            clearances=worn(states, self.wear, self.growth),
            fluid=self.fluid_of(diagnosis),
            profile=profile,
        )
