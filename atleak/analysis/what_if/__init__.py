"""Try a unit at another temperature, wear, fluid, speed, gear or position of its spools; the job stays as it is."""

from __future__ import annotations

from atleak.analysis.what_if.maps import Border, Map, map_over, temperatures_to_try, wears_to_try
from atleak.analysis.what_if.trial import Axis, StudyTrial, Tried, WhatIf, is_the_study_s, like_the_study, tried

__all__ = [
    "Axis",
    "Border",
    "Map",
    "StudyTrial",
    "Tried",
    "WhatIf",
    "is_the_study_s",
    "like_the_study",
    "map_over",
    "temperatures_to_try",
    "tried",
    "wears_to_try",
]
