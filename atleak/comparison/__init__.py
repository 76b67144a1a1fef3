"""Put two diagnoses of one unit side by side: before and after a repair, or two visits.

`compare` is the one function to call; the other names are the types of its result.
"""

from __future__ import annotations

from atleak.comparison.changes import Change
from atleak.comparison.choices import DifferingChoice
from atleak.comparison.compare import compare
from atleak.comparison.logs import EventPair, LogComparison
from atleak.comparison.results import CircuitComparison, Comparison, ConditionComparison, LandComparison

__all__ = [
    "Change",
    "CircuitComparison",
    "Comparison",
    "ConditionComparison",
    "DifferingChoice",
    "EventPair",
    "LandComparison",
    "LogComparison",
    "compare",
]
