"""Define the tables and keys of a controller's TOML file, with the unit in the key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Annotated, Literal

from pydantic import Field, model_validator

from atleak.catalogue.circuit_tables import (
    CircuitTable,
    ConsumerTable,
    LeakTable,
    LineTable,
    Percent,
    PermissiblePressureTable,
    State,
)
from atleak.catalogue.complaints import ComplaintTable
from atleak.catalogue.entries import (
    Entry,
    Evidence,
    Finite,
    Identifier,
    MountingClearance,
    NonEmptyText,
    NonNegative,
    Positive,
    StatedEvidence,
    Strict,
)
from atleak.catalogue.pump_tables import PumpTable
from atleak.catalogue.repairs import RepairTable
from atleak.faults import NotAccepted
from atleak.sentence import Sentence

ContactLength = Annotated[float, Field(gt=0, lt=200)]
LandValue = Literal["nominal_diameter_mm", "contact_length_mm", "mounting_clearance_um"]
PartKind = Literal["spool", "piston", "end_plug"]
PART_NAMES: Mapping[PartKind, Sentence] = MappingProxyType(
    {"spool": Sentence("spool"), "piston": Sentence("piston"), "end_plug": Sentence("end plug")}
)
Seal = Literal["o_ring", "teflon_ring"]  # a ring on the land: it leaks past its ring alone
SEALS: Mapping[Seal, str] = MappingProxyType({"o_ring": "an O-ring", "teflon_ring": "a Teflon ring"})
Bore = Literal["plain", "sleeved"]


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
    expansion_per_k: float = Field(gt=0, lt=1e-3)
    source: NonEmptyText
    evidence: StatedEvidence = None


class LandTable(Strict):
    land: int = Field(ge=1, le=9)
    planes: list[NonEmptyText] | None = None
    nominal_diameter_mm: float = Field(gt=0.5, lt=200)
    contact_length_mm: ContactLength | None = None
    position_mm: NonNegative | None = None  # of its near edge from the spool's end on the left of the drawing
    mounting_clearance_um: MountingClearance | None = None
    mounting_tolerance_um: Positive | None = None
    mounting_clearance_of_used_unit: bool | None = None
    learned_from_units: int | None = Field(default=None, ge=1)
    seal: Seal | None = None
    clearance_limit_um: Positive | None = None
    body: NonEmptyText | None = None
    spool: NonEmptyText | None = None
    published: list[LandValue] = []
    measured: list[LandValue] = []

    @model_validator(mode="after")
    def _known_once(self) -> LandTable:
        if both := [name for name in self.measured if name in self.published]:
            raise NotAccepted(Sentence("{key} either published or measured, not both", key=both[0]))
        return self


class ComponentTable(Strict):
    id: NonEmptyText
    name: NonEmptyText
    part: PartKind = "spool"
    bore: Bore = "plain"
    lands: list[LandTable] = []


class GapTable(Strict):
    component: NonEmptyText
    land: int
    section: NonEmptyText | None = None
    high: NonEmptyText = Field(alias="from")
    low: NonEmptyText = Field(alias="to")
    gears: list[int] = Field(min_length=1)
    ends_in: Literal["sump", "section"] | None = None
    published: bool = False
    evidence: StatedEvidence = None

    @property
    def known_from(self) -> Evidence | None:
        """Return what it is known from; ``published = true`` says so too."""
        return self.evidence or (Evidence.PUBLISHED if self.published else None)


class SpringTable(Strict):
    shear_modulus_mpa: Positive
    wire_diameter_mm: Positive
    active_coils: Positive
    mean_coil_diameter_mm: Positive
    free_length_mm: Positive
    working_length_mm: Positive


@dataclass(frozen=True)
class BalanceValve:
    """The spool and spring of a valve that balances a section's pressure against main pressure."""

    diameter_1_mm: float
    diameter_2_mm: float
    diameter_3_mm: float
    rod_diameter_mm: float
    spring: SpringTable


class RelationTable(Strict):
    """A pressure relation: ``"spool_balance"`` needs the diameters and the spring, ``"line"`` the ratio."""

    relation: Literal["spool_balance", "line"]
    limit_kpa: Positive | None = None
    source: NonEmptyText
    evidence: StatedEvidence = None
    ratio: NonNegative | None = None
    offset_kpa: Finite = 0.0
    diameter_1_mm: Positive | None = None
    diameter_2_mm: Positive | None = None
    diameter_3_mm: Positive | None = None
    rod_diameter_mm: Positive | None = None
    diameter_g1_mm: Positive | None = None
    diameter_g2_mm: Positive | None = None
    spring: SpringTable | None = None

    @property
    def valve(self) -> BalanceValve:
        """Return the valve of a spool balance.

        Raises
        ------
        NotAccepted
            if the table lacks a value of the valve; it names them.
        """
        one, two, three, rod = self.diameter_1_mm, self.diameter_2_mm, self.diameter_3_mm, self.rod_diameter_mm
        if one is None or two is None or three is None or rod is None or self.spring is None:
            wanted = ("diameter_1_mm", "diameter_2_mm", "diameter_3_mm", "rod_diameter_mm", "spring")
            missing = tuple(key for key in wanted if getattr(self, key) is None)
            raise NotAccepted(Sentence("a spool balance with {keys} too", keys=missing))
        return BalanceValve(one, two, three, rod, self.spring)

    @model_validator(mode="after")
    def _complete(self) -> RelationTable:
        if self.relation == "line" and self.ratio is None:
            raise NotAccepted(Sentence("a line with its ratio"))
        if self.relation == "spool_balance":
            _ = self.valve
        return self


class OperatingPointTable(Strict):
    name: Identifier
    label: NonEmptyText
    temperature_c: float = Field(ge=-60, le=200)
    engine_rpm: float = Field(gt=0, le=15_000)
    gear: int
    p_g_kpa: float = Field(gt=0, le=10_000)
    p_k_kpa: float = Field(ge=0, le=5_000)
    state: State | None = None
    solenoid_current_ma: float | None = Field(default=None, ge=0, le=10_000)
    lockup_duty_percent: Percent | None = None
    source: NonEmptyText
    evidence: StatedEvidence = None


class DefaultsTable(Strict):
    contact_length_mm: ContactLength | None = None
    mounting_clearance_um: MountingClearance | None = None
    mounting_tolerance_um: Positive | None = None
    mounting_clearance_of_used_unit: bool = False

    @model_validator(mode="after")
    def _one_way_of_knowing(self) -> DefaultsTable:
        if isinstance(self.mounting_clearance_um, list) and self.mounting_tolerance_um is not None:
            wanted = Sentence("mounting_tolerance_um beside a single mounting_clearance_um, not beside a range")
            raise NotAccepted(wanted)
        return self

    body: NonEmptyText | None = None
    spool: NonEmptyText | None = None
    published: list[LandValue] = []
    measured: list[LandValue] = []


class ControllerFile(Entry):
    representative: str = ""
    representative_values: list[LandValue] = []
    gears: list[int] = Field(min_length=1)
    materials: dict[str, MaterialTable] = Field(min_length=1)
    defaults: DefaultsTable = DefaultsTable()
    pump: PumpTable
    pressures: dict[Literal["p_s", "p_m"], RelationTable] = {}
    operating_points: list[OperatingPointTable] = Field(min_length=1)
    components: list[ComponentTable] = Field(min_length=1)
    gaps: list[GapTable] = []
    circuits: list[CircuitTable] = []
    leaks: list[LeakTable] = []
    consumers: list[ConsumerTable] = []
    line: LineTable | None = None
    permissible_pressure: list[PermissiblePressureTable] = []
    complaints: list[ComplaintTable] = []
    repairs: list[RepairTable] = []

    def known_from(self, land: LandTable, value: LandValue) -> Evidence | None:
        """Return what a value of a land is known from: as the land says, or else the file for all lands."""
        for table in (land, self.defaults):
            if value in table.measured:
                return Evidence.MEASURED
            if value in table.published:
                return Evidence.PUBLISHED
        return Evidence.REPRESENTATIVE if value in self.representative_values else None
