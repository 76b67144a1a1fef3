"""Write the sentences that terminal, pages, workbook and PDF share."""

from __future__ import annotations

from atleak.catalogue.fluid import USED_THINNER
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import RPM

LEFT_OUT_OF_SPEED = wording("en")("texts.left_out_of_speed")


def fluid_in_state(diagnosis: Diagnosis, say: Wording) -> str:
    """Return the name of the fluid and the state in which it is taken: ``Mobil ATF 220; used``."""
    fluid, (low, high) = diagnosis.fluid, USED_THINNER
    state = "fresh_assumed" if diagnosis.fluid_state_assumed else "used_estimated" if fluid.estimated else fluid.state
    return f"{isolated(fluid.name)}; {say(f'fluid_states.{state}', low=low, high=high)}"


def covered_from(projection: Projection) -> str:
    """Say from which engine speed the pump covers the leakage of a condition, and what that speed leaves out."""
    speed = f"{projection.minimum_speed * RPM:.0f} rpm"
    return f"the pump covers this leakage and its own slip from {speed}; {LEFT_OUT_OF_SPEED}"
