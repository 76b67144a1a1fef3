"""Hold measured readings: diameters of a spool (or piston) or of its sleeve, each in one plane and one direction."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass, replace
from typing import Literal

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.instruments import Part
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.common.errors import Message, Place
from atleak.common.sentences import Sentence
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.own_lands import OwnLands


@dataclass(frozen=True)
class SheetIdentity:
    """Whose unit was measured, by whom and with what, as the sheet's head says it; empty where it does not."""

    job: str = ""  # number of the job
    vehicle: str = ""  # in the words of whoever wrote it
    vin: str = ""  # of the vehicle
    serial: str = ""  # of the transmission
    technician: str = ""  # who measured
    instruments: tuple[str, ...] = ()  # where the head names two, that for spools and then that for bores
    mileage: float | None = None  # [km]

    @property
    def empty(self) -> bool:
        """Tell whether the head says nothing of this."""
        return self == SheetIdentity()


NOMINAL_HEADING = Sentence("Nominal\ndiameter")  # of the printed form, a unit behind it: it marks a sheet made from it
TYPED_MARK = "atleak: readings typed in"  # the first cell of a sheet that was: it may hold nothing yet that counts


@dataclass(frozen=True)
class Reading:
    """One measured diameter."""

    component: str  # its number
    part: Part  # spool or sleeve
    plane: str  # letter or number of the plane
    direction: float | None  # [°] angle around the axis, 0 to 180; None where the sheet does not say
    repeat: int  # counted from 1 within one part, plane and direction
    diameter: float  # [m]
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share
    coordinates: tuple[float, float] | None = None  # [m] the two positions whose distance is the diameter

    @property
    def station(self) -> tuple[str, Part, str, float | None]:
        """Return what repeats have in common: component, part, plane and direction."""
        return self.component, self.part, self.plane, self.direction


@dataclass(frozen=True)
class Readings:
    """All readings of one measuring sheet.

    Attributes
    ----------
    file
        its name.
    sha256
        of its bytes.
    sheet
        the workbook's sheet; None for text files.
    unit
        of the diameters as written: ``mm``, or several joined by ``", "``.
    unit_assumed
        whether the unit was inferred from the nominal diameters, not written in the sheet.
    layout
        ``table``: coordinates; ``tidy``: one diameter a row; ``columns``: several diameters a row.
    readings
        in the sheet's order.
    messages
        what was assumed.
    temperature
        of gauge and parts, as the sheet's head states it [°C].
    date
        of the measurement, as the sheet's head states it.
    identity
        whose unit, and by whom measured.
    pressures
        of the sheet's own tab, where it is filled in.
    pump
        clearances of the pump, as the sheet's head states them.
    own_lands
        lengths measured, repairs fitted.
    unworn
        readings marked as taken at an unworn end: of the pair when new, none of ``readings``.
    """

    file: str
    sha256: str
    sheet: str | None
    unit: str
    unit_assumed: bool
    layout: Literal["table", "tidy", "columns"]
    readings: tuple[Reading, ...]
    messages: tuple[Message, ...] = ()
    temperature: float | None = None
    date: dt.date | None = None
    identity: SheetIdentity = SheetIdentity()
    pressures: PressureTable | None = None
    pump: PumpClearances = NO_CLEARANCES
    own_lands: OwnLands = OwnLands()  # noqa: RUF009  frozen, so safe to share
    unworn: tuple[Reading, ...] = ()

    @property
    def when_new(self) -> Readings:
        """Return the readings that tell what pairs were when new.

        Those of a sheet without marks are of a new unit, all of them. Of a used unit they are those at unworn ends,
        and of lands whose bore has such readings also the spool as it is, where it has no unworn end of its own.
        """
        if not self.unworn:
            return self
        bores = {(reading.component, reading.plane) for reading in self.unworn if reading.part == "sleeve"}
        spools = {(reading.component, reading.plane) for reading in self.unworn if reading.part == "spool"}
        beside = (reading for reading in self.readings if reading.part == "spool")
        beside = (reading for reading in beside if (reading.component, reading.plane) in bores - spools)
        taken = (reading for reading in self.unworn if (reading.component, reading.plane) in bores)
        return replace(self, readings=(*beside, *taken), unworn=())

    def measured_at(self, stated: float | None = None) -> MeasuringTemperature:
        """Return the temperature of measuring: as stated for the job, else as in the sheet, else 20 °C.

        Parameters
        ----------
        stated
            that of the job [°C]; None where the job states none.
        """
        if stated is not None:
            return MeasuringTemperature(stated, "job")
        if self.temperature is not None:
            return MeasuringTemperature(self.temperature, "sheet")
        return MeasuringTemperature(REFERENCE_TEMPERATURE, "assumed")


@dataclass(frozen=True)
class MeasuringTemperature:
    """The temperature that gauge and parts had when they were measured, and who states it."""

    value: float  # [°C]
    origin: Literal["job", "sheet", "assumed"]  # who states it

    @property
    def assumed(self) -> bool:
        """Return whether nobody stated it."""
        return self.origin == "assumed"

    @property
    def corrects(self) -> bool:
        """Return whether diameters change by being corrected to the reference temperature."""
        return self.value != REFERENCE_TEMPERATURE
