"""Define the job record: whose car it is, what was complained of, what was seen and what was decided.

Every field is optional. The measured diameters and the log are not part of the record: they stay in their own files.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import PurePosixPath
from types import MappingProxyType
from typing import Annotated, Any, Literal

from annotated_types import Ge, GroupedMetadata, Le
from pydantic import (
    AfterValidator,
    AllowInfNan,
    AwareDatetime,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
)

from atleak.catalogue.pump import PumpClearances
from atleak.catalogue.repairs import Goal, currency_code
from atleak.catalogue.written_numbers import (
    HOURS,
    LABOUR_RATE,
    MEASURING_TEMPERATURE,
    MILEAGE,
    PRICE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    TAX,
    AskedNumber,
    read_number,
)
from atleak.common.sentences import Sentence

RepairState = Literal["proposed", "approved", "done", "declined", "deferred"]
Grade = Literal["none", "light", "moderate", "heavy"]

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
_SURROGATES = re.compile("[\ud800-\udfff]")
_NO_PICTURE_NAME = re.compile(r"[:/\\\x00-\x1f]|\.\.")
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")


def without_surrogates(text: str) -> str:
    """Return text that can be encoded: a lone surrogate, as JSON may hold one, becomes a replacement character."""
    return _SURROGATES.sub("\ufffd", text)


def clean_text(text: str) -> str:
    """Return text without what no file can hold: lone surrogates, and control characters but tab and new line."""
    return _CONTROL.sub("", without_surrogates(text))


def _text(value: Any) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool):
        value = str(value)  # a customer number or a year typed without quotes
    return clean_text(value).strip() if isinstance(value, str) else value


def _number(asked: AskedNumber, value: Any) -> Any:
    """Return a number that may be written as text, read as in a field of a page."""
    if not isinstance(value, str):
        return value
    number = read_number(value, asked)
    if number.value is None:
        raise ValueError(number.reason)
    return number.value


@dataclass(frozen=True)
class _Asked(GroupedMetadata):
    """A number of the record as people are asked for it: read as in a field of a page, and within its limits."""

    number: AskedNumber

    def __iter__(self) -> Iterator[object]:
        low, high = self.number.limits
        yield BeforeValidator(partial(_number, self.number))
        yield from (Ge(low), Le(high), AllowInfNan(False))


def picture_name(name: str) -> str:
    """Return a picture's name inside the job: relative, with ``/``, never out of the job's folder.

    Raises
    ------
    ValueError
        for an absolute path, one with ``..``, or a file that is no picture by its name.
    """
    path = PurePosixPath(name.replace("\\", "/"))
    if not name or path.is_absolute() or ".." in path.parts or ":" in name:
        raise ValueError(Sentence("a file beside the job's own, named without '..' or a drive"))
    if path.suffix.lower() not in PICTURE_SUFFIXES:
        raise ValueError(Sentence("a picture: {suffixes}", suffixes=PICTURE_SUFFIXES))
    return str(path)


def _file_name(name: str) -> str:
    """Return the name that a picture handed over has inside the job."""
    safe = _NO_PICTURE_NAME.sub("_", clean_text(name)).strip()
    return picture_name(safe if safe.lower().endswith(PICTURE_SUFFIXES) else f"{safe}{PICTURE_SUFFIXES[0]}")


CleanText = Annotated[str, BeforeValidator(_text)]
_Picture = Annotated[CleanText, AfterValidator(picture_name)]
Kilometres = Annotated[float, _Asked(MILEAGE)]
MeasuringCelsius = Annotated[float, _Asked(MEASURING_TEMPERATURE)]
PumpSideMicrometres = Annotated[float, _Asked(PUMP_SIDE_CLEARANCE)]
PumpTipMicrometres = Annotated[float, _Asked(PUMP_TIP_CLEARANCE)]
Price = Annotated[float, _Asked(PRICE)]
Hours = Annotated[float, _Asked(HOURS)]
LabourRate = Annotated[float, _Asked(LABOUR_RATE)]
TaxPercent = Annotated[float, _Asked(TAX)]


class Record(BaseModel):
    """A table of the job: unknown keys are errors, and it never changes after it was made."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @property
    def empty(self) -> bool:
        """Return whether nothing was filled in."""
        return not self.model_dump(exclude_defaults=True)


class Workshop(Record):
    """The workshop, as its letterhead names it."""

    name: CleanText = ""
    address: CleanText = ""  # over several lines
    phone: CleanText = ""
    email: CleanText = ""
    website: CleanText = ""
    registration: CleanText = ""  # tax or trade register number
    logo: _Picture | None = None  # name of the picture


class Customer(Record):
    name: CleanText = ""
    number: CleanText = ""  # in the workshop's books
    address: CleanText = ""
    phone: CleanText = ""
    email: CleanText = ""


class Vehicle(Record):
    make: CleanText = ""
    model: CleanText = ""
    year: CleanText = ""
    engine: CleanText = ""
    registration: CleanText = ""  # plate
    vin: CleanText = ""
    mileage_km: Kilometres | None = None


class Transmission(Record):
    maker: CleanText = ""
    code: CleanText = ""  # of the type
    serial: CleanText = ""
    note: CleanText = ""


class InstrumentUsed(Record):
    """An instrument that was used for measuring; ``calibrated`` is the date of its last calibration."""

    name: CleanText = ""
    serial: CleanText = ""
    calibrated: dt.date | None = None  # date of its last calibration
    note: CleanText = ""


class FluidCondition(Record):
    """The state of the oil in the car."""

    product: CleanText = ""  # name of the oil
    changed_at_km: Kilometres | None = None  # mileage of the last change
    level: CleanText = ""
    colour: CleanText = ""
    smell: CleanText = ""
    note: CleanText = ""


class Contamination(Record):
    grade: Grade | None = None
    particles: CleanText = ""
    note: CleanText = ""


class Scratch(Record):
    component: CleanText = ""  # its number
    land: Annotated[int, Field(ge=1, le=9)] | None = None
    part: CleanText = ""  # spool or bore
    description: CleanText = ""
    photo: _Picture | None = None  # name of the picture


class Photo(Record):
    file: _Picture  # name of the picture
    caption: CleanText = ""
    component: CleanText = ""  # that it shows


class RepairDecision(Record):
    """A repair that was proposed for a pair, and what became of it."""

    component: CleanText = ""  # its number
    land: Annotated[int, Field(ge=1, le=9)] | None = None  # None: every land that the repair changes
    repair: CleanText = ""  # id of one of the repairs of the valve body's file
    work: CleanText = ""  # what is done
    part_number: CleanText = ""  # of the part that is fitted
    price: Price | None = None  # of the part, in the currency of the estimate
    hours: Hours | None = None  # [h] of work
    decision: RepairState | None = None  # what became of it
    reason: CleanText = ""  # for that
    date: dt.date | None = None  # of the decision
    decided_by: CleanText = ""  # the customer who said so on his screen
    decided_at: AwareDatetime | None = None  # when he said yes or no there last

    @property
    def pair(self) -> str:
        """Name what it is about by component and land, or by the component alone."""
        return self.component if self.land is None else f"{self.component}/{self.land}"

    def changed(self, **changes: Any) -> RepairDecision:
        """Return it as the workshop changes it: another decision or price is no longer what the customer said."""
        now = self.model_dump() | changes
        same = all(now[name] == getattr(self, name) for name in ("repair", "work", "price", "hours"))
        same &= now["decision"] == self.decision or (self.decision, now["decision"]) == ("approved", "done")
        return RepairDecision.model_validate(now if same else {**now, "decided_by": changes.get("decided_by", "")})


class LogFormula(Record):
    """A channel that is computed from those of the road-test log, by a formula as it was typed."""

    name: CleanText = ""  # of the channel
    formula: CleanText = ""  # as it was typed


class EstimateTerms(Record):
    """The terms of the estimate: in which money, at what labour rate, with what tax, and for what goal."""

    currency: Annotated[CleanText, AfterValidator(currency_code)] = ""  # such as EUR
    labour_rate: LabourRate | None = None  # per hour
    tax_percent: TaxPercent | None = None  # on top of the sum
    goal: Goal = Goal.EVERY_LIMIT  # of the repairs that are proposed


class Job(Record):
    """Everything that a workshop writes down about one controller."""

    number: CleanText = ""  # of the workshop
    date: dt.date | None = None  # of the job
    measured_on: dt.date | None = None  # as the measuring sheet says unless given
    issued_on: dt.date | None = None  # of the report
    revision: CleanText = ""  # of the report
    replaces: CleanText = ""  # number, revision or date of the report that this one takes the place of
    technician: CleanText = ""  # who measured
    approved_by: CleanText = ""  # who released the report
    workshop: Workshop = Workshop()  # as on its letterhead
    customer: Customer = Customer()  # who brings the car
    vehicle: Vehicle = Vehicle()  # the car
    transmission: Transmission = Transmission()  # as its plate names it
    complaint: CleanText = ""  # in the customer's words
    fault_codes: tuple[CleanText, ...] = ()  # as the gearbox computer gave them
    fluid_condition: FluidCondition = FluidCondition()  # of the oil in the car
    contamination: Contamination = Contamination()  # found in oil and pan
    measuring_temperature_c: MeasuringCelsius | None = None  # of gauge and parts
    pump_side_clearance_um: PumpSideMicrometres | None = None  # axial play of this job's pump
    pump_tip_clearance_um: PumpTipMicrometres | None = None  # of this job's pump
    instruments: tuple[InstrumentUsed, ...] = ()  # that were used
    scratches: tuple[Scratch, ...] = ()  # and other damage that was seen
    photos: tuple[Photo, ...] = ()  # with their captions
    repair_decisions: tuple[RepairDecision, ...] = ()  # what was proposed, and what became of it
    estimate: EstimateTerms = EstimateTerms()  # its terms
    log_formulas: tuple[LogFormula, ...] = ()  # drawn with the log, in this order
    notes: CleanText = ""  # anything else

    _pictures: Mapping[str, bytes] = PrivateAttr(default_factory=lambda: MappingProxyType({}))

    def __reduce__(self) -> tuple[Any, ...]:
        """Let the record be pickled, which a mapping that cannot be changed does not allow."""
        return _unpickled, (self.record(), dict(self._pictures))

    @property
    def pump_clearances(self) -> PumpClearances:
        """Return what was measured of this job's pump."""
        return PumpClearances.of_um(self.pump_side_clearance_um, self.pump_tip_clearance_um)

    @property
    def identity(self) -> dict[str, Any]:
        """Return what tells this job from others, and who measured; None for what nobody wrote down."""
        return {
            "number": self.number or None,
            "date": self.date.isoformat() if self.date else None,
            "vin": self.vehicle.vin or None,
            "plate": self.vehicle.registration or None,
            "serial": self.transmission.serial or None,
            "mileage_km": self.vehicle.mileage_km,
            "measured_by": self.technician or None,
        }

    def mileage_or(self, computed: float | None) -> float | None:
        """Return the mileage with which the result was computed [km], or else the one that the record states."""
        return self.vehicle.mileage_km if computed is None else computed

    @property
    def estimated(self) -> bool:
        """Tell whether anything of an estimate was filled in: its terms, a price or hours."""
        return not self.estimate.empty or any(
            decision.price is not None or decision.hours is not None for decision in self.repair_decisions
        )

    @property
    def pictures(self) -> Mapping[str, bytes]:
        """Return the bytes of the pictures that were loaded, by name."""
        return self._pictures

    @property
    def picture_names(self) -> tuple[str, ...]:
        """Return the name of every picture in the record: logo, photos, scratches."""
        names = [self.workshop.logo, *(photo.file for photo in self.photos), *(s.photo for s in self.scratches)]
        return tuple(dict.fromkeys(name for name in names if name))

    @property
    def letterhead(self) -> Job:
        """Return the workshop with its logo, and nothing else of the job."""
        logo = {name: content for name, content in self.pictures.items() if name == self.workshop.logo}
        return Job(workshop=self.workshop).with_pictures(logo)

    def with_pictures(self, pictures: Mapping[str, bytes]) -> Job:
        """Return the same record with the bytes of its pictures; those it does not name are left out."""
        job = self.model_copy()
        job._pictures = MappingProxyType({name: pictures[name] for name in self.picture_names if name in pictures})
        return job

    def with_photo(self, name: str, content: bytes) -> Job:
        """Return the same record with one more photo, under a name of its own; one that it holds is not added again.

        Parameters
        ----------
        name
            of the file that was handed over; what no file may be called becomes ``_``.

        Returns
        -------
        Job
            with the photo in ``photos``, as ``photos/NAME``, and its bytes in `pictures`.
        """
        files = {photo.file for photo in self.photos}
        if any(self.pictures.get(file) == content for file in files):
            return self
        stem, dot, suffix = f"photos/{_file_name(name)}".rpartition(".")
        names = (f"{stem}{number}{dot}{suffix}" for number in ("", *(f"-{n}" for n in range(2, len(files) + 2))))
        file = next(candidate for candidate in names if candidate not in files)
        photos = (*self.photos, Photo(file=file))
        return self.model_copy(update={"photos": photos}).with_pictures({**self.pictures, file: content})

    def without_photo(self, file: str) -> Job:
        """Return the same record without one of its photos."""
        photos = tuple(photo for photo in self.photos if photo.file != file)
        return self.model_copy(update={"photos": photos}).with_pictures(self.pictures)

    def with_logo(self, name: str, content: bytes) -> Job:
        """Return the same record with the workshop's logo.

        Returns
        -------
        Job
            with its name in ``workshop.logo`` and its bytes in `pictures`.
        """
        file = _file_name(name)
        workshop = self.workshop.model_copy(update={"logo": file})
        return self.model_copy(update={"workshop": workshop}).with_pictures({**self.pictures, file: content})

    def without_logo(self) -> Job:
        """Return the same record without the workshop's logo."""
        workshop = self.workshop.model_copy(update={"logo": None})
        return self.model_copy(update={"workshop": workshop}).with_pictures(self.pictures)

    def record(self) -> dict[str, Any]:
        """Return what was filled in, as JSON values."""
        return self.model_dump(mode="json", exclude_defaults=True)


def _unpickled(record: dict[str, Any], pictures: dict[str, bytes]) -> Job:
    return Job.model_validate(record).with_pictures(pictures)
