"""Carry measurement uncertainty through the cube of a clearance to every flow, the total and every decision.

`assess` is the one function to call; the other names are the types of its result.
"""

from __future__ import annotations

from atleak.diagnosis.uncertainty.assess import assess
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS, NOTHING_ELSE, Assumptions
from atleak.diagnosis.uncertainty.decision import (
    DECISIONS,
    GUARD_FACTOR,
    Decision,
    LevelDecision,
    Remedy,
    RuleDecision,
    certainty,
    decide,
)
from atleak.diagnosis.uncertainty.results import (
    AtCondition,
    InstantUncertainty,
    LandUncertainty,
    Shape,
    TotalUncertainty,
    UnitUncertainty,
)
from atleak.diagnosis.uncertainty.sources import LandSources, RepeatSpread, UncertaintySource

__all__ = [
    "DECISIONS",
    "DEFAULTS",
    "GUARD_FACTOR",
    "NOTHING_ELSE",
    "Assumptions",
    "AtCondition",
    "Decision",
    "InstantUncertainty",
    "LandSources",
    "LandUncertainty",
    "LevelDecision",
    "Remedy",
    "RepeatSpread",
    "RuleDecision",
    "Shape",
    "TotalUncertainty",
    "UncertaintySource",
    "UnitUncertainty",
    "assess",
    "certainty",
    "decide",
]
