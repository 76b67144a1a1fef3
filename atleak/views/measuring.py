"""Say at which temperature gauge and parts were measured, and what was made of it."""

from __future__ import annotations

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.readings import MeasuringTemperature
from atleak.wording import Wording


def measuring_temperature(measured_at: MeasuringTemperature, say: Wording) -> str:
    """Return the measuring temperature in a reader's language: assumed, as stated, or corrected for.

    >>> from atleak.wording import wording
    >>> measuring_temperature(MeasuringTemperature(35.0, "job"), wording("en"))
    '35 °C, diameters corrected to 20 °C'
    """
    said = "assumed" if measured_at.assumed else "corrected" if measured_at.corrects else "stated"
    values = {"temperature": say.plain(measured_at.value), "reference": say.plain(REFERENCE_TEMPERATURE)}
    return say(f"facts.temperature_{said}", **values)
