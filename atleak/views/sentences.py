"""Write the sentences that terminal, pages, workbook and PDF share."""

from __future__ import annotations

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.fluid import USED_THINNER
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import PERCENT, RPM


def counted_in_speed(diagnosis: Diagnosis, say: Wording) -> str:
    """Say which consumers are in the lowest engine speed that the pump needs: none where the file states none."""
    consumers = ", ".join(isolated(each.name) for each in diagnosis.controller.consumers)
    return say("texts.counted_in_speed", consumers=consumers) if consumers else say("texts.left_out_of_speed")


def fluid_in_state(diagnosis: Diagnosis, say: Wording) -> str:
    """Return the name of the fluid and the state in which it is taken: ``Mobil ATF 220; used``."""
    fluid, (low, high) = diagnosis.fluid, USED_THINNER
    state = "fresh_assumed" if diagnosis.fluid_state_assumed else "used_estimated" if fluid.estimated else fluid.state
    return f"{isolated(fluid.name)}; {say(f'fluid_states.{state}', low=low, high=high)}"


def measuring_temperature(diagnosis: Diagnosis, say: Wording) -> str:
    """Say at which temperature gauge and parts were measured: assumed, as stated, or corrected for; "" without a sheet.

    In English ``35 °C, diameters corrected to 20 °C``.
    """
    measured_at = diagnosis.measured_at
    if measured_at is None:
        return ""
    said = "assumed" if measured_at.assumed else "corrected" if measured_at.corrects else "stated"
    values = {"temperature": say.plain(measured_at.value), "reference": say.plain(REFERENCE_TEMPERATURE)}
    return say(f"facts.temperature_{said}", **values)


def tighter_than_new(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say how many lands measure tighter than a new pair can be; None where none does."""
    count = sum(land.suspect for land in diagnosis.lands)
    return say("sentences.tighter_than_new", count=count) if count else None


def replace_at(land: LandDiagnosis, say: Wording) -> str | None:
    """Say at which mileage the land reaches the wear limit for replacing, to two digits; None where none is projected.

    A number that nobody can foresee is not given.
    """
    at = land.replace_mileage
    if at is None:
        return None
    if at.value is None or not at.foreseeable:
        return say("texts.not_foreseeable")
    value, low, high = (say.number(float(f"{each:.2g}"), 0) for each in (at.value, at.low, at.high))
    return say("texts.replace_between", value=value, low=low, high=high)


def when_new(diagnosis: Diagnosis, projection: Projection) -> str:
    """Say in English what the same unit draws when new, and what with pairs as wide as these may have been then."""
    new, unworn = (each.share * PERCENT for each in (diagnosis.new_at(projection), diagnosis.unworn_at(projection)))
    as_wide = f" ({unworn:.1f} % with new pairs as wide as these may have been)"
    return f"{new:.1f} % when new" + ("" if f"{unworn:.1f}" == f"{new:.1f}" else as_wide)


def covered_from(diagnosis: Diagnosis, projection: Projection) -> str:
    """Say from which engine speed the pump covers the leakage of a condition, and which consumers that speed counts."""
    speed = f"{projection.minimum_speed * RPM:.0f} rpm"
    return f"the pump covers this leakage and its own slip from {speed}; {counted_in_speed(diagnosis, wording('en'))}"
