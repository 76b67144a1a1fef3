"""Define the tables of circuits, leaks, consumers and permissible pressures in a controller's TOML file."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, field_validator, model_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.entries import (
    ID_HELP,
    Finite,
    Identifier,
    NonEmptyText,
    NonNegative,
    Positive,
    Source,
    StatedEvidence,
    Strict,
)
from atleak.catalogue.keys import key
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence

State = Literal["idle", "stall", "driving"]
StandingState = Literal["idle", "fast_idle", "stall", "driving"]  # fast idle: of gauge readings alone
SelectorRange = Literal["P", "R", "N", "D", "S", "1", "2", "3", "4", "5", "6", "7", "8", "9"]  # of the lever
Percent = Annotated[float, Field(ge=0, le=100)]
DISCHARGE_COEFFICIENT = 0.62  # of a sharp-edged orifice, where a feed states none


class FeedTable(Strict):
    source: NonEmptyText = key("Fed from", "p_g is the line", names="section", width=20, alias="from")
    diameter_mm: float = key("Diameter", usual=usual.ORIFICE, gt=0, lt=50)
    discharge_coefficient: float = key(
        "Discharge coefficient", "0.62 unless stated", default=DISCHARGE_COEFFICIENT, gt=0, le=1
    )
    evidence: StatedEvidence = None  # of its diameter


class FollowingTable(Strict):
    """A set pressure that follows another section or circuit: ratio times its pressure plus an offset."""

    source: NonEmptyText = Field(alias="from")
    ratio: NonNegative
    offset_kpa: Finite = 0.0


class SignalTable(Strict):
    """A set pressure by the signal of a solenoid: straight lines between the points."""

    kpa: list[NonNegative] = Field(min_length=2)

    @model_validator(mode="after")
    def _rising(self) -> SignalTable:
        (key,) = type(self).model_fields.keys() - {"kpa"}
        values = getattr(self, key)
        if len(values) != len(self.kpa):
            currents = Sentence("as many pressures as currents ({count})", count=len(values))
            duties = Sentence("as many pressures as duties ({count})", count=len(values))
            raise NotAccepted(currents if key == "current_ma" else duties)
        if any(high <= low for low, high in pairwise(values)):
            raise NotAccepted(Sentence("{key} rising", key=key))
        return self


class CurrentTable(SignalTable):
    current_ma: list[NonNegative] = Field(min_length=2)


class DutyTable(SignalTable):
    duty_percent: list[Percent] = Field(min_length=2)  # of a pulsed solenoid, as lock-up has one


class ByGearTable(Strict):
    gear: dict[str, NonNegative] = Field(min_length=1)

    @field_validator("gear")
    @classmethod
    def _whole(cls, gears: dict[str, float]) -> dict[str, float]:
        for name in gears:
            try:
                int(name)
            except ValueError:
                raise NotAccepted(Sentence("gears as whole numbers, not {name!r}", name=name)) from None
        return gears


SetTable = float | FollowingTable | CurrentTable | DutyTable | ByGearTable | dict[str, float]


def _kpa(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 10_000.0:
        raise NotAccepted(Sentence("a pressure in kPa from 0 to 10000"))
    return float(value)


def _set_table(value: object) -> SetTable:
    """Take a number, a table by operating point, by gear, by current or duty, or one that follows another circuit."""
    if isinstance(value, dict):
        if "from" in value or "ratio" in value:
            return FollowingTable.model_validate(value)
        if "current_ma" in value:
            return CurrentTable.model_validate(value)
        if "duty_percent" in value:
            return DutyTable.model_validate(value)
        if isinstance(value.get("gear"), dict):
            return ByGearTable.model_validate(value)
        if not value:
            raise NotAccepted(Sentence("a pressure for every operating point"))
        return {str(name): _kpa(pressure) for name, pressure in value.items()}
    return _kpa(value)


SetKpa = Annotated[Any, PlainValidator(_set_table)]


class CircuitTable(Strict):
    id: Identifier = key("Id", ID_HELP, width=20)
    name: NonEmptyText = key("Name", width=30)
    gears: list[int] | None = Field(default=None, min_length=1)
    feeds: list[FeedTable] = []
    set_kpa: SetKpa | None = key(usual=usual.SET_PRESSURE, default=None)
    set_evidence: StatedEvidence = key("Set pressure is", "Empty: not stated", width=15, default=None)
    source: Source
    evidence: StatedEvidence = key("Gears are", "Empty: not stated", width=15, default=None)

    @model_validator(mode="after")
    def _supplied(self) -> CircuitTable:
        if not self.feeds and self.set_kpa is None:
            raise NotAccepted(Sentence("feeds or set_kpa, from which its pressure comes"))
        return self


class LineTable(Strict):
    set_kpa: SetKpa
    source: NonEmptyText = key(
        "Source of the line's set pressure", "Only where the sheet Set pressures has rows of p_g"
    )
    evidence: StatedEvidence = key("How that is known", default=None)


class LeakTable(Strict):
    id: Identifier = key("Id", ID_HELP, width=20)
    name: NonEmptyText | None = key("Name", width=30, default=None)
    high: NonEmptyText = key("From", names="pressure", width=18, alias="from")
    low: NonEmptyText = key("To", "Drain unless stated", names="pressure", alias="to", default="drain")
    law: Literal["laminar", "orifice"] = key("Law", "Rings, or holes")
    flow_dm3_min: NonNegative = key("Flow")
    at_kpa: Positive = key("At pressure", becomes="pressure_drop")
    at_viscosity_mm2_s: Positive | None = key("At viscosity", "Needed where laminar", default=None)
    at_density_g_cm3: Positive = key(  # of automatic transmission fluid, about; a laminar leak depends on it little
        "At density", "0.83 unless stated", becomes="density", default=0.83
    )
    gears: list[int] | None = key("Gears", "All unless stated", width=16, default=None, min_length=1)
    source: Source
    evidence: StatedEvidence = None

    @model_validator(mode="after")
    def _complete(self) -> LeakTable:
        if self.law == "laminar" and self.at_viscosity_mm2_s is None:
            raise NotAccepted(Sentence("at_viscosity_mm2_s, at which a laminar leak was measured"))
        return self


def _flows(value: object) -> float | dict[str, float]:
    """Take one flow [dm³/min], or one for every operating point."""
    flows = list(value.values()) if isinstance(value, dict) else [value]
    for flow in flows:
        if isinstance(flow, bool) or not isinstance(flow, int | float) or not 0.0 <= flow <= 1000.0:
            raise NotAccepted(Sentence("dm³/min, a number from 0 to 1000, or one for every operating point"))
    if isinstance(value, dict):
        return {str(name): float(flow) for name, flow in value.items()}
    return float(flows[0])  # type: ignore[arg-type]  # checked above


class ConsumerTable(Strict):
    id: Identifier = key("Id", ID_HELP, width=24)
    name: NonEmptyText | None = key("Name", width=30, default=None)
    flow_dm3_min: Annotated[Any, PlainValidator(_flows)] = key("Flow")
    law: Literal["orifice", "constant"] | None = key("Law", "Orifice unless stated or after the line", default=None)
    at_kpa: Annotated[float, Field(gt=0, le=10_000)] | None = key(
        "At pressure", "The required main pressure unless stated", becomes="pressure", default=None
    )
    after_line: bool = key("After the line", "Supplied with what the regulator leaves over", default=False)
    source: Source
    evidence: StatedEvidence = None

    @model_validator(mode="after")
    def _follows_the_line(self) -> ConsumerTable:
        if self.after_line and (self.law == "orifice" or self.at_kpa is not None):
            raise NotAccepted(Sentence("neither law nor at_kpa beside after_line: it takes its flow or what is left"))
        if self.law == "constant" and self.at_kpa is not None:
            raise NotAccepted(Sentence("no at_kpa beside a constant law: it takes its flow at any pressure"))
        return self


class PermissiblePressureTable(Strict):
    gear: int | None = None
    gears: list[int] | None = key(
        "Gears", "R N 1 2 or all; one of both is needed", width=16, default=None, min_length=1
    )
    ranges: list[SelectorRange] | None = key(
        "Ranges", "Of the lever, such as P N", width=12, default=None, min_length=1
    )
    state: StandingState = key("State")
    low_kpa: Positive | None = key("Lowest", default=None)
    high_kpa: Positive | None = key("Highest", default=None)
    source: Source
    evidence: StatedEvidence = None

    @model_validator(mode="after")
    def _complete(self) -> PermissiblePressureTable:
        if self.gear is not None and self.gears is not None:
            raise NotAccepted(Sentence("either gear or gears"))
        if self.gear is None and self.gears is None and self.ranges is None:
            raise NotAccepted(Sentence("gear, gears or ranges"))
        if self.low_kpa is None and self.high_kpa is None:
            raise NotAccepted(Sentence("low_kpa, high_kpa or both"))
        if self.low_kpa is not None and self.high_kpa is not None and self.high_kpa <= self.low_kpa:
            raise NotAccepted(Sentence("high_kpa above low_kpa ({low:g})", low=self.low_kpa))
        return self
