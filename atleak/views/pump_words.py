"""Say what was measured of this job's pump and what it slips, and what the shares of a pump held at demand are of."""

from __future__ import annotations

from collections.abc import Iterator

from atleak.diagnosis import Diagnosis
from atleak.views.pump_record import slips
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN


def full_stroke(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say that shares, reserve and speed are of the full stroke; None for a pump whose stroke is fixed."""
    return f"{say('pump.full_stroke')}." if diagnosis.controller.pump.held_at_demand else None


def pump_sentence(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say which clearances of this job's pump were measured, beside new ones and limits, and what they make it slip.

    The slip is that at hot idle, or else at the stated condition. None where nothing was measured of the pump.
    """
    pump = diagnosis.controller.pump
    if not pump.measured.known:
        return None
    measured = say("pump.measured", clearances=say("pump.and").join(_clearances(diagnosis, say)))
    if not (pump.counted.known and diagnosis.model.uses_slip):
        return f"{measured} {say('pump.counts_nowhere')}"
    projection = diagnosis.hot_idle or diagnosis.projection
    slip, new = slips(diagnosis, projection)
    words = {"condition": say.condition(projection.condition), "slip": say.value(slip * DM3_MIN, "flow", 2)}
    if new is None:
        return f"{measured} {say('pump.slips', **words)}"
    return f"{measured} {say('pump.slips_more', new=say.value(new * DM3_MIN, 'flow', 2), **words)}"


def _clearances(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    pump = diagnosis.controller.pump
    for name, now, new, most in zip(("side", "tip"), pump.measured.um, pump.clearances.um, pump.limits.um, strict=True):
        if now is not None:
            beside = [
                say(f"pump.{word}", clearance=say.plain_quantity(um, "clearance"))
                for word, um in (("new", new), ("most", most))
                if um is not None
            ]
            said = say(f"pump.{name}", clearance=say.plain_quantity(now, "clearance"))
            yield f"{said} ({', '.join(beside)})" if beside else said
