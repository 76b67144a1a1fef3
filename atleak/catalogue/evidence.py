"""Say what the values of a controller's file are known from, and count them."""

from __future__ import annotations

from enum import StrEnum


class Evidence(StrEnum):
    """What a value is known from, the surest first."""

    MEASURED = "measured"  # by the workshop, on such a unit
    PUBLISHED = "published"  # in the source that stands beside it
    REPRESENTATIVE = "representative"  # of such units in general: to be measured or looked up
