"""Say how much air a vacuum stand draws: by its calibrations, as stated, or by its own orifice."""

from __future__ import annotations

import math
from dataclasses import dataclass

from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.equations.statistics import rectangular
from atleak.equations.vacuum import stand_flow_area
from atleak.measurements.vacuum import VacuumReading, VacuumTable

_MOST_DISCHARGE = 1.1  # C_d of an orifice, up to which a calibration is believed: it is under 1, and readings err


@dataclass(frozen=True)
class StandFlow:
    """C_d A of a stand with one of its own orifices."""

    area: float  # [m²]
    relative_uncertainty: float  # standard, of it
    known: bool  # calibrated or stated; else from the orifice's diameter and an assumed C_d


def flow_of_reading(table: VacuumTable, reading: VacuumReading, assumptions: Assumptions = DEFAULTS) -> StandFlow:
    """Return C_d A of the stand as it was fitted for a reading.

    Raises
    ------
    InputError
        where nothing tells it, where one flow area is stated for several orifices, and where a calibration says more
        than an orifice can pass.
    """
    uncalibrated = [each for each in table.readings if each.orifice and not table.calibrations_of(each.orifice)]
    others = [each for each in uncalibrated if each.orifice != reading.orifice]
    if table.stand.flow_area is not None and reading in uncalibrated and others:
        raise InputError(
            Sentence("the stand's flow area is that of one orifice, and readings state several"),
            place=others[0].place,
            value=f"{(others[0].orifice or 0.0) * 1e3:g} mm",
            expected=Sentence("a calibration with each orifice, or no flow area"),
        )
    found = stand_flow(table, reading.orifice, assumptions)
    if found is None:
        expected = Sentence("the diameter of the stand's orifice, a calibration with a known one, or its C_d A")
        problem = Sentence("nothing tells how much air the stand draws")
        raise InputError(problem, place=reading.place, expected=expected)
    whole = math.inf if reading.orifice is None else 0.25 * math.pi * reading.orifice**2
    if found.known and found.area > _MOST_DISCHARGE * whole:
        made = table.calibrations_of(reading.orifice)
        raise InputError(
            Sentence("the stand cannot draw through more than its own orifice"),
            place=made[0].place if made else reading.place,
            value=Sentence("C_d A {area:.2f} mm²", area=found.area * 1e6),
            expected=Sentence(
                "no more than the {whole:.2f} mm² of an orifice of {diameter:g} mm: check orifices and readings of the "
                "calibration",
                whole=whole * 1e6,
                diameter=(reading.orifice or 0.0) * 1e3,
            ),
        )
    return found


def stand_flow(table: VacuumTable, orifice: float | None, assumptions: Assumptions = DEFAULTS) -> StandFlow | None:
    """Return C_d A of a stand: from calibrations, as stated, or from its orifice; None where nothing tells it.

    Parameters
    ----------
    orifice
        its own that was fitted [m]; None where that is not stated.
    """
    stand, coefficient = table.stand, assumptions.discharge_coefficient
    made = table.calibrations_of(orifice)
    if made:
        known, vacua = [each.orifice for each in made], [stand.ambient - each.vacuum for each in made]
        u = float(rectangular(assumptions.vacuum_gauge)) or 1.0
        pressures = stand.ambient - stand.supply, stand.ambient
        area, u_area = stand_flow_area(known, vacua, *pressures, coefficient, u)
        return StandFlow(area, math.hypot(u_area / area, assumptions.discharge), True)
    if stand.flow_area is not None:
        return StandFlow(stand.flow_area, assumptions.discharge, True)
    if orifice is None:
        return None
    return StandFlow(coefficient * 0.25 * math.pi * orifice**2, assumptions.discharge, False)
