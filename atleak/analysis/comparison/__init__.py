"""Put two diagnoses of one unit side by side: before and after a repair, or two visits.

`compare` is the one function to call; the other names are the types of its result.
"""

from __future__ import annotations

from atleak.analysis.comparison.compare import compare
from atleak.analysis.comparison.results import (
    Change,
    CircuitComparison,
    Comparison,
    ConditionComparison,
    DifferingChoice,
    EventPair,
    LandComparison,
    LogComparison,
)

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
