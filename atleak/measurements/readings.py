"""Hold measured readings: diameters of a spool (or piston) or of its sleeve, each in one plane and one direction.

Lands have more of their own beside their diameters: lengths as measured, and repairs fitted earlier.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, Literal

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Land
from atleak.catalogue.instruments import Part
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message, Place, ReadingsError, unknown
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.measurements.gauge_readings import FileOfReadings, PressureTable

LENGTHS_MEASURED, REPAIR_FITTED = "contact_length_measured", "repair_fitted"  # codes of the messages that say so


@dataclass(frozen=True)
class OwnLength:
    """The contact length of one land as measured, or where it begins on its spool; None where not measured."""

    component: str
    land: int
    contact_length: float | None  # [m]
    position: float | None  # [m] of its near edge, from the end of the spool that the drawing shows left
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share

    @property
    def key(self) -> LandKey:
        return self.component, self.land


@dataclass(frozen=True)
class FittedRepair:
    """A repair of the controller's file that one component was given earlier, by its id."""

    component: str
    repair: str
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class OwnLands:
    """All of that of one unit, as its measuring sheet says it."""

    lengths: tuple[OwnLength, ...] = ()
    fitted: tuple[FittedRepair, ...] = ()

    def with_fitted(self, controller: Controller) -> Controller:
        """Return the controller with the nominal diameters and mounting clearances of the repairs that are fitted.

        Returns
        -------
        Controller
            the same where no repair is fitted.

        Raises
        ------
        ReadingsError
            a repair that the controller's file does not have for that component.
        """
        if not self.fitted:
            return controller
        lands = {land.key: land for land in controller.lands}
        for fitted in self.fitted:
            options = {repair.id: repair for repair in controller.repairs_of(fitted.component)}
            repair = options.get(fitted.repair)
            if repair is None:
                problem = Sentence(
                    "{controller} has no such repair of component {component}",
                    controller=controller.id,
                    component=fitted.component,
                )
                raise unknown(problem, fitted.repair, options, kind=ReadingsError, place=fitted.place)
            for land in controller.lands_of(fitted.component):
                if repair.changes(land.key):
                    lands[land.key] = land.with_repair(repair)
        return replace(controller, lands=tuple(lands.values()))

    def applied(self, controller: Controller) -> Controller:
        """Return the controller as this unit is: as `with_fitted` does, and with the lengths that were measured."""
        lengths = {length.key: length for length in self.lengths}
        fitted = self.with_fitted(controller)
        lands = tuple(_measured(land, lengths[land.key]) if land.key in lengths else land for land in fitted.lands)
        return replace(fitted, lands=lands) if lengths else fitted


def _measured(land: Land, length: OwnLength) -> Land:
    """Return a land with the contact length and position that were measured of it."""
    if length.position is not None:
        land = replace(land, position=length.position)
    if length.contact_length is None:
        return land
    representative = tuple(key for key in land.representative if key != "contact_length_mm")
    return replace(
        land, contact_length=length.contact_length, contact_length_measured=True, representative=representative
    )


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


class CellKind(StrEnum):
    """What a cell of a measuring sheet became."""

    SPOOL = "spool"
    SLEEVE = "sleeve"
    LABEL = "label"  # of which component, plane, part, direction or repeat a diameter is, or in which unit
    NEW = "new"  # a nominal diameter, or what one was when new
    HEAD = "head"  # temperature, date, clearances of the pump, whose unit it is
    LAND = "land"  # a length or fitted repair of a land
    HEADING = "heading"
    ASIDE = "aside"
    REFUSED = "refused"


@dataclass(frozen=True)
class CellMeaning:
    """What a cell became, and why, or as what; many cells share one."""

    kind: CellKind
    why: Sentence = Sentence("")  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class SheetCells:
    """A sheet as it stands in its file, and what its cells became.

    Attributes
    ----------
    rows
        text, numbers and dates as the file has them; "" where a cell is empty.
    meanings
        of the same cells; None where nothing was to be made of one.
    numbers
        of the rows, as the file's program counts them.
    turned
        whether it was read with rows and columns exchanged.
    """

    name: str | None  # None of a text
    rows: Sequence[Sequence[Any]]
    meanings: Sequence[Sequence[CellMeaning | None]]
    numbers: Sequence[int]
    turned: bool = False


@brief
@dataclass(frozen=True)
class Readings(FileOfReadings):
    """All readings of one measuring sheet.

    Attributes
    ----------
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
    columns
        role and column, where a person said which column is what.
    headings
        of those columns' table.
    sheets
        the visible sheets of the file and what became of their cells, where that was asked for.
    """

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
    own_lands: OwnLands = OwnLands()
    unworn: tuple[Reading, ...] = ()
    columns: tuple[tuple[str, str], ...] = ()
    headings: tuple[str, ...] = ()
    sheets: tuple[SheetCells, ...] = field(default=(), repr=False, compare=False)

    @property
    def one_direction(self) -> bool:
        """Tell whether every part was read in one direction alone, as in a quick pass."""
        stations = {reading.station for reading in self.readings}
        return 0 < len(stations) == len({station[:3] for station in stations})

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

    def measured_at(self, temperature_c: float | None = None) -> MeasuringTemperature:
        """Return the temperature of measuring: as stated for the job, else as in the sheet, else 20 °C.

        Parameters
        ----------
        temperature_c
            that of the job [°C]; None where the job states none.
        """
        if temperature_c is not None:
            return MeasuringTemperature(temperature_c, "job")
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
