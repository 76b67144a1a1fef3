"""Hold a vacuum test: what a stand's gauge showed while it drew air from plugged circuits, past their lands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby

from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message, Place
from atleak.common.printable import brief
from atleak.common.units import IN_HG
from atleak.equations.vacuum import STANDARD_ATMOSPHERE
from atleak.measurements.gauge_readings import FileOfReadings

USUAL_SUPPLY = 25.0 / IN_HG  # [Pa] below ambient: to which stands of the trade are set when closed


@dataclass(frozen=True)
class Calibration:
    """What the stand showed while air came in through one known orifice, instead of past lands."""

    orifice: float  # [m] diameter of the known orifice
    vacuum: float  # [Pa] below ambient
    fitted: float | None = None  # [m] the stand's own orifice meanwhile; None: the only one, or not stated
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class VacuumStand:
    """What a table says of the stand that was read."""

    supply: float = USUAL_SUPPLY  # [Pa] below ambient: what its gauge shows while it is closed
    ambient: float = STANDARD_ATMOSPHERE  # [Pa] absolute
    temperature: float = 20.0  # [°C] of the air and the valve body
    calibrations: tuple[Calibration, ...] = ()
    flow_area: float | None = None  # [m²] discharge coefficient times area of its own orifice, where it is stated


@dataclass(frozen=True)
class VacuumReading:
    """What the gauge showed of one plugged circuit, or of lands that share a plug."""

    target: str  # as written: a circuit, or component and land
    circuit: str | None  # the circuit's id, where a circuit was plugged
    lands: tuple[LandKey, ...]  # past which air came in
    vacuum: float  # [Pa] below ambient
    orifice: float | None = None  # [m] diameter of the stand's own orifice that was fitted; None: not stated
    repaired: bool = False  # the bore was read after its repair; else as it was worn
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class LeakClearance:
    """The clearance that a vacuum test tells of one land alone: the even one that leaks as much."""

    clearance: float  # [m] cube root of the mean cube of what it may be
    u_reading: float  # [m] standard uncertainties of it: by the gauge
    u_stand: float  # [m] by C_d A of the stand, the same for all that it read
    u_position: float  # [m] by where the spool lay
    u_length: float  # [m] by the contact length
    reading: VacuumReading  # the last of those it follows from

    @property
    def standard_uncertainty(self) -> float:
        """Return the standard uncertainty [m] of it all."""
        return math.hypot(self.u_reading, self.u_stand, self.u_position, self.u_length)


@brief
@dataclass(frozen=True)
class VacuumTable(FileOfReadings):
    """All readings of one vacuum test."""

    stand: VacuumStand  # that was read
    readings: tuple[VacuumReading, ...]  # in the table's order
    messages: tuple[Message, ...] = ()  # what was assumed

    @property
    def by_lands(self) -> tuple[tuple[VacuumReading, ...], ...]:
        """Return the readings of each set of lands in the table's order, sets in that of their first reading."""
        first: dict[frozenset[LandKey], int] = {}
        for index, reading in enumerate(self.readings):
            first.setdefault(frozenset(reading.lands), index)
        ordered = sorted(self.readings, key=lambda reading: first[frozenset(reading.lands)])
        return tuple(tuple(group) for _, group in groupby(ordered, key=lambda reading: frozenset(reading.lands)))

    def calibrations_of(self, orifice: float | None) -> tuple[Calibration, ...]:
        """Return the calibrations of the stand with one of its own orifices.

        Parameters
        ----------
        orifice
            diameter of the stand's own orifice [m]; None where a reading does not state it.

        Returns
        -------
        tuple of Calibration
            those made with it. One that does not say what was fitted counts for the only orifice that readings state,
            and for readings that state none; for no other, where they state several.
        """
        stated = {reading.orifice for reading in self.readings} - {None}
        unstated = orifice is None or stated == {orifice}
        return tuple(
            calibration
            for calibration in self.stand.calibrations
            if calibration.fitted == orifice or (calibration.fitted is None and unstated)
        )
