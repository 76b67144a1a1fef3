"""Write the English sentences that terminal, pages and workbook share."""

from __future__ import annotations

from atleak.engine.projection import Projection
from atleak.wording import wording
from atleak.workshop_units import RPM

LEFT_OUT_OF_SPEED = wording("en")("texts.left_out_of_speed")


def covered_from(projection: Projection) -> str:
    """Say from which engine speed the pump covers the leakage of a condition, and what that speed leaves out."""
    speed = f"{projection.minimum_speed * RPM:.0f} rpm"
    return f"the pump covers this leakage and its own slip from {speed}; {LEFT_OUT_OF_SPEED}"
