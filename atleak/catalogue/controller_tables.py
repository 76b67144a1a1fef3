"""Define the tables and keys of a controller's TOML file, with the unit in the key."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from itertools import pairwise
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, field_validator, model_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.entries import (
    ID_HELP,
    Entry,
    Evidence,
    Finite,
    Identifier,
    MountingClearance,
    NonEmptyText,
    NonNegative,
    Positive,
    Source,
    StatedEvidence,
    Strict,
)
from atleak.catalogue.keys import key
from atleak.catalogue.pump_tables import PumpTable
from atleak.catalogue.repairs import ComplaintTable, RepairTable
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence

State = Literal["idle", "stall", "driving"]
StandingState = Literal["idle", "fast_idle", "stall", "driving"]  # fast idle: of gauge readings alone
SelectorRange = Literal["P", "R", "N", "D", "S", "1", "2", "3", "4", "5", "6", "7", "8", "9"]  # of the lever
Percent = Annotated[float, Field(ge=0, le=100)]
DISCHARGE_COEFFICIENT = 0.62  # of a sharp-edged orifice, where a feed states none
ContactLength = Annotated[float, Field(gt=0, lt=200)]
LandValue = Literal["nominal_diameter_mm", "contact_length_mm", "mounting_clearance_um"]
PartKind = Literal["spool", "piston", "end_plug"]
PART_NAMES: Mapping[PartKind, Sentence] = MappingProxyType(
    {"spool": Sentence("spool"), "piston": Sentence("piston"), "end_plug": Sentence("end plug")}
)
Seal = Literal["o_ring", "teflon_ring"]  # a ring on the land: it leaks past its ring alone
SEALS: Mapping[Seal, str] = MappingProxyType({"o_ring": "an O-ring", "teflon_ring": "a Teflon ring"})
_Bore = Literal["plain", "sleeved"]
_OWN_MATERIAL = "Material, where it is not that of the head"


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


def _viscosity_range(value: object) -> list[float]:
    """Check the range [mm²/s] in which the viscosity of a fluid lies at 100 °C."""
    ends = value if isinstance(value, list) else [value]
    numbers = [end for end in ends if isinstance(end, int | float) and not isinstance(end, bool)]
    if len(ends) != 2 or len(numbers) != 2 or not 1.0 <= numbers[0] < numbers[1] <= 50.0:
        raise NotAccepted(Sentence("mm²/s from 1 to 50, the lower end first, such as [4.5, 7.5]"))
    return [float(end) for end in numbers]


class RequiredFluidTable(Strict):
    """The fluid that the maker requires, and the catalogue's entry that is taken for it unless another is chosen."""

    required: NonEmptyText = key("Fluid required", "By the maker, as the manual calls it: Mercon V, ATF+4")
    entry: Identifier = key("Fluid taken", "Id of that fluid's entry, or else of the nearest one")
    viscosity_100_mm2_s: Annotated[list[float], PlainValidator(_viscosity_range)] | None = key(
        "Viscosity at 100 °C from",
        "Only where the entry is not of that fluid but the nearest: the range of what is sold as the one required",
        up_to=("Viscosity at 100 °C to", "The upper end of that range"),
        default=None,
    )
    source: NonEmptyText = key("Source of the fluid required", "Manual and page; and of the range, where it has one")


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
        "Gears", "R N 1 2 or all; one of both is needed", one="gear", width=16, default=None, min_length=1
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


class NewOrigin(StrEnum):
    """What a land's mounting clearance is known from."""

    PAIR = "pair"  # measured on this very pair when it was new
    TYPE = "type"  # a value of the unit's type, with the tolerance of single pairs around it
    RANGE = "range"  # only the range in which new pairs lie, all of it alike likely
    USED_UNIT = "used_unit"  # measured on a unit that had been used, and taken as new

    @property
    def label(self) -> Sentence:
        """Say it in plain words."""
        return _NEW_ORIGINS[self]


_NEW_ORIGINS = {
    NewOrigin.PAIR: Sentence("measured on this pair when new"),
    NewOrigin.TYPE: Sentence("value of the unit's type with its tolerance"),
    NewOrigin.RANGE: Sentence("only the range of new pairs is known"),
    NewOrigin.USED_UNIT: Sentence("measured on a used unit and taken as new"),
}


class MaterialTable(Strict):
    expansion_per_k: float = key(
        "Expansion", "21.3 for cast aluminium, 12 for steel", usual=usual.USUAL_EXPANSION, gt=0, lt=1e-3
    )
    source: Source
    evidence: StatedEvidence = None


class LandTable(Strict):
    land: int = key("Land", "Its number on this component, 1 to 9", width=7, ge=1, le=9)
    planes: list[NonEmptyText] | None = key(
        "Planes", "Measurement planes, with commas; the land's number unless stated", default=None
    )
    nominal_diameter_mm: float = key(
        "Diameter",
        "Of the spool, not of the bore",
        known="Diameter is",
        known_of_all="Diameters are",
        usual=usual.LAND_DIAMETER,
        gt=0.5,
        lt=200,
    )
    contact_length_mm: ContactLength | None = key(
        "Contact length",
        "Over which spool and bore face each other",
        known="Length is",
        known_of_all="Contact lengths are",
        usual=usual.CONTACT_LENGTH,
        default=None,
    )
    position_mm: NonNegative | None = key(
        "Position", "Near edge from the end that the drawing shows left", default=None
    )
    mounting_clearance_um: MountingClearance | None = key(
        "Mounting clearance",
        "When new; the lower end of a range",
        up_to=("Up to", "The upper end, where it is a range"),
        known="Clearance is",
        known_of_all="New clearances are",
        radial=True,
        usual=usual.USUAL_CLEARANCE,
        default=None,
    )
    mounting_tolerance_um: Positive | None = key(
        "Tolerance", "± that holds 95 % of new pairs of this type", radial=True, usual=usual.TOLERANCE, default=None
    )
    mounting_clearance_of_used_unit: bool | None = key("Of a used unit", "Measured used and taken as new", default=None)
    learned_from_units: int | None = key(
        "Learned from", "How many new units gave the clearance", unit="units", default=None, ge=1
    )
    seal: Seal | None = key("Seal", default=None)
    clearance_limit_um: Positive | None = key(
        "Limit",
        "Your own: at or past it the verdict is replace",
        radial=True,
        usual=usual.CLEARANCE_LIMIT,
        default=None,
    )
    body: NonEmptyText | None = key("Body", _OWN_MATERIAL, names="material", default=None)
    spool: NonEmptyText | None = key("Spool", _OWN_MATERIAL, names="material", default=None)
    published: list[LandValue] = []
    measured: list[LandValue] = []
    representative: list[LandValue] = []

    @model_validator(mode="after")
    def _known_once(self) -> LandTable:
        if both := [name for name in self.measured if name in self.published]:
            raise NotAccepted(Sentence("{key} either published or measured, not both", key=both[0]))
        return self


class ComponentTable(Strict):
    id: NonEmptyText = key("Id", "As on the drawing: 8, 12', boost_valve", width=28)
    name: NonEmptyText = key("Name", width=34)
    part: PartKind = key("Part", "Spool unless stated", default="spool")
    bore: _Bore = key("Bore", "Plain unless stated", default="plain")
    lands: list[LandTable] = []


class GapTable(Strict):
    component: NonEmptyText = key("Component", names="component", width=28)
    land: int = key("Land", width=7)
    section: NonEmptyText | None = key("Section", "Need not be said: follows from From", default=None)
    high: NonEmptyText = key("From", "Also a share of one: 0.5*p_m", names="pressure", width=18, alias="from")
    low: NonEmptyText = key("To", "Also 0.1*p_g, 35 kPa or drain", names="pressure", width=18, alias="to")
    gears: list[int] = key("Gears", "Such as R N 1 2, 1-5 or all", width=18, min_length=1)
    ends_in: Literal["sump", "section"] | None = key("Ends in", "Follows from To unless stated", default=None)
    published: bool = key("Published", "Of older files: yes is published", default=False)
    evidence: StatedEvidence = None

    @property
    def known_from(self) -> Evidence | None:
        """Return what it is known from; ``published = true`` says so too."""
        return self.evidence or (Evidence.PUBLISHED if self.published else None)


class SpringTable(Strict):
    shear_modulus_mpa: Positive = key("Shear modulus of the spring")
    wire_diameter_mm: Positive = key("Wire diameter")
    active_coils: Positive = key("Active coils")
    mean_coil_diameter_mm: Positive = key("Mean coil diameter")
    free_length_mm: Positive = key("Free length")
    working_length_mm: Positive = key("Working length")


class RelationTable(Strict):
    """A pressure relation: ``"spool_balance"`` needs the diameters and the spring, ``"line"`` the ratio."""

    relation: Literal["line", "spool_balance"] = key("Relation")
    limit_kpa: Positive | None = key("Limit", "It does not rise above", default=None)
    source: Source
    evidence: StatedEvidence = None
    ratio: NonNegative | None = key("Ratio", "Of a line", default=None)
    offset_kpa: Finite = key("Offset", "Of a line", default=0.0)
    diameter_1_mm: Positive | None = key("Diameter 1", "Of a spool balance: full end face", default=None)
    diameter_2_mm: Positive | None = key("Diameter 2", default=None)
    diameter_3_mm: Positive | None = key("Diameter 3", default=None)
    rod_diameter_mm: Positive | None = key("Rod diameter", default=None)
    diameter_g1_mm: Positive | None = key("Diameter g1", default=None)
    diameter_g2_mm: Positive | None = key("Diameter g2", default=None)
    spring: SpringTable | None = key(default=None)

    @model_validator(mode="after")
    def _complete(self) -> RelationTable:
        if self.relation == "line" and self.ratio is None:
            raise NotAccepted(Sentence("a line with its ratio"))
        wanted = ("diameter_1_mm", "diameter_2_mm", "diameter_3_mm", "rod_diameter_mm", "spring")
        missing = tuple(key for key in wanted if getattr(self, key) is None)
        if self.relation == "spool_balance" and missing:
            raise NotAccepted(Sentence("a spool balance with {keys} too", keys=missing))
        return self


class OperatingPointTable(Strict):
    name: Identifier = key("Name", ID_HELP, width=18)
    label: NonEmptyText = key("Label", "What people see", width=28)
    temperature_c: float = key("Fluid temperature", usual=usual.USUAL_TEMPERATURE, ge=-60, le=200)
    engine_rpm: float = key("Engine speed", becomes="engine_speed", usual=usual.USUAL_ENGINE_SPEED, gt=0, le=15_000)
    gear: int = key("Gear", "R, N or a number", width=7)
    p_g_kpa: float = key(
        "Main pressure",
        "That a sound unit has there, gauge",
        becomes="main_pressure",
        usual=usual.MAIN_PRESSURE,
        gt=0,
        le=10_000,
    )
    p_k_kpa: float = key(
        "Converter pressure", "Likewise", becomes="converter_pressure", usual=usual.CONVERTER_PRESSURE, ge=0, le=5_000
    )
    state: State | None = key(
        "State", "Idle under 1000 rpm, else driving, unless stated", becomes="stated_state", default=None
    )
    solenoid_current_ma: float | None = key(
        "Solenoid current", "Where a set pressure follows it", default=None, ge=0, le=10_000
    )
    lockup_duty_percent: Percent | None = key("Lock-up duty", "Where a set pressure follows it", default=None)
    source: Source
    evidence: StatedEvidence = None


class DefaultsTable(Strict):
    contact_length_mm: ContactLength | None = key(
        "Contact length unless stated", "Of lands that state none", usual=usual.CONTACT_LENGTH, default=None
    )
    mounting_clearance_um: MountingClearance | None = key(
        "Mounting clearance unless stated",
        "Of lands that state none, when new. Bore minus spool where diametral, half of it where radial",
        up_to=("Up to, where it is a range", "Its upper end"),
        radial=True,
        usual=usual.USUAL_CLEARANCE,
        default=None,
    )
    mounting_tolerance_um: Positive | None = key(
        "Tolerance of mounting clearances",
        "± that holds 95 % of new pairs, where it is a value of the unit's type",
        radial=True,
        usual=usual.TOLERANCE,
        default=None,
    )
    mounting_clearance_of_used_unit: bool = key(
        "Clearances are of a used unit", "Measured on a used unit and taken as new", default=False
    )

    @model_validator(mode="after")
    def _one_way_of_knowing(self) -> DefaultsTable:
        if isinstance(self.mounting_clearance_um, list) and self.mounting_tolerance_um is not None:
            wanted = Sentence("mounting_tolerance_um beside a single mounting_clearance_um, not beside a range")
            raise NotAccepted(wanted)
        return self

    body: NonEmptyText | None = key(
        "Material of the body", "A name of the sheet Materials", names="material", default=None
    )
    spool: NonEmptyText | None = key(
        "Material of spools", "A name of the sheet Materials", names="material", default=None
    )
    published: list[LandValue] = []
    measured: list[LandValue] = []


class ControllerFile(Entry):
    representative: str = key("Representative", "In a sentence: what of it is representative", default="")
    representative_values: list[LandValue] = []
    gears: list[int] = key("Gears", "Such as R N 1 2 3 4; P counts as N", min_length=1)
    fluid: RequiredFluidTable | None = key(default=None)
    materials: dict[str, MaterialTable] = Field(min_length=1)
    defaults: DefaultsTable = key(default=DefaultsTable())
    pump: PumpTable
    pressures: dict[Literal["p_s", "p_m"], RelationTable] = {}
    operating_points: list[OperatingPointTable] = Field(min_length=1)
    components: list[ComponentTable] = Field(min_length=1)
    gaps: list[GapTable] = []
    circuits: list[CircuitTable] = []
    leaks: list[LeakTable] = []
    consumers: list[ConsumerTable] = []
    line: LineTable | None = key(default=None)
    permissible_pressure: list[PermissiblePressureTable] = []
    complaints: list[ComplaintTable] = []
    repairs: list[RepairTable] = []

    def known_from(self, land: LandTable, value: LandValue) -> Evidence | None:
        """Return what a value of a land is known from: as the land says, or else the file for all lands."""
        for table in (land, self.defaults):
            for evidence in Evidence:
                if value in getattr(table, evidence, ()):
                    return evidence
        return Evidence.REPRESENTATIVE if value in self.representative_values else None
