"""Describe how components, or the pump, can be repaired, and what customers complain of.

A repair has a part, a price and the clearance that it leaves, of one component or of all that a kit mends; a complaint
points to the operating points and lands that can explain it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import AfterValidator, PlainValidator, model_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.entries import (
    ID_HELP,
    Evidence,
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
from atleak.common.errors import InputError, unknown
from atleak.common.file_faults import NotAccepted, WrongTogether
from atleak.common.sentences import Name, Sentence

LandKey = tuple[str, int]
ALL = "all"  # components of a valve body
RepairKind = Literal[
    "clean_and_reuse", "oversize_valve", "sleeve", "new_valve", "new_casting", "new_pump", "overhaul", "other"
]
PUMP = "pump"
"""What a repair names in place of a component where it is one of the pump: that leaves it as new."""
PUMP_KINDS: tuple[RepairKind, ...] = ("new_pump", "overhaul", "other")


class Goal(StrEnum):
    """What a choice of repairs is to reach."""

    EVERY_LIMIT = "every_limit"  # every flagged land repaired, totals and pressures green at every condition
    GREEN = "green"  # totals and pressures green at every condition: of the flagged lands those that are worth it


def currency_code(text: str) -> str:
    """Return a currency as it is compared: a code of three letters in capitals, anything else as it is written."""
    return text.upper() if re.fullmatch("[A-Za-z]{3}", text) else text


def _components(value: object) -> list[str] | str:
    """Check the components that a kit mends: their names, each once, or the word for all."""
    if value == ALL:
        return ALL
    names = [name.strip() if isinstance(name, str) else "" for name in value] if isinstance(value, list) else []
    if not names or not all(names) or len(set(names)) < len(names):
        raise NotAccepted(Sentence('a list of components, each once, such as ["8", "9"], or "all"'))
    return names


Components = Annotated[list[str] | str, PlainValidator(_components)]


class RepairTable(Strict):
    id: Identifier = key("Id", ID_HELP, width=20)
    component: NonEmptyText | None = None
    components: Components | None = key(
        "Component",
        "Of a kit several, with commas between, or all; or pump",
        names="repaired part",
        one="component",
        width=20,
        default=None,
    )
    lands: list[int] | None = key("Lands", "Of one component; all of it unless stated", default=None, min_length=1)
    kind: RepairKind = key("Kind", width=16)
    name: NonEmptyText = key("Name", width=30)
    part_number: NonEmptyText | None = key("Part number", default=None)
    price: NonNegative | None = key("Price", default=None)
    currency: Annotated[NonEmptyText, AfterValidator(currency_code)] | None = key("Currency", default=None)
    hours: NonNegative | None = key("Hours", unit="h", default=None)
    tool: NonEmptyText | None = key("Tool", width=20, default=None)
    nominal_diameter_mm: float | None = key(
        "New diameter", "Of an oversize valve", usual=usual.LAND_DIAMETER, default=None, gt=0.5, lt=200
    )
    mounting_clearance_um: MountingClearance | None = key(
        "New clearance",
        "Afterwards; the lower end of a range",
        up_to=("Up to", ""),
        radial=True,
        usual=usual.USUAL_CLEARANCE,
        default=None,
    )
    mounting_tolerance_um: Positive | None = key("Tolerance", radial=True, usual=usual.TOLERANCE, default=None)
    source: Source
    evidence: StatedEvidence = None

    @model_validator(mode="after")
    def _complete(self) -> RepairTable:
        if (self.component is None) == (self.components is None):
            raise WrongTogether(Sentence("either component or components"), "component")
        if self.lands is not None and self.component is None:
            raise WrongTogether(Sentence("lands beside a single component alone"), "lands")
        if self.price is not None and self.currency is None:
            raise NotAccepted(Sentence("the currency of the price"))
        new, tolerance = self.mounting_clearance_um, self.mounting_tolerance_um
        if tolerance is not None and not (isinstance(new, float) and tolerance < new):
            wanted = Sentence("mounting_tolerance_um beside a single mounting_clearance_um, and less than that")
            raise NotAccepted(wanted)
        return self


@dataclass(frozen=True)
class Repair:
    """One way to repair some lands, of one component or of all that a kit mends, or the pump."""

    id: str  # by which choices name it
    lands: tuple[LandKey, ...]  # that it changes; none: it is one of the pump
    kind: RepairKind  # what is done
    name: str  # what people see
    source: str  # who states this
    part_number: str | None = None  # of the part that is fitted
    price: float | None = None  # of the part, in its currency
    currency: str | None = None  # of the price, as EUR
    hours: float | None = None  # of work
    tool: str | None = None  # that it takes
    nominal_diameter: float | None = None  # [m] of the land afterwards; None: as before
    mounting_clearance: float | tuple[float, float] | None = None  # [m] radial afterwards; None: as of new parts
    mounting_tolerance: float | None = None  # [m]
    evidence: Evidence | None = None  # who says what it leaves

    @property
    def components(self) -> tuple[str, ...]:
        """Return the numbers of the components that it mends, or the word for the pump."""
        return tuple(dict.fromkeys(component for component, _ in self.lands)) or (PUMP,)

    @property
    def label(self) -> str:
        """Name it with its part number."""
        return f"{self.name} ({self.part_number})" if self.part_number else self.name

    @property
    def ends(self) -> tuple[float, ...]:
        """Return the clearance that it leaves [m]: one number, the two ends of a range, or nothing where not stated."""
        new = self.mounting_clearance
        return new if isinstance(new, tuple) else () if new is None else (new,)

    @property
    def of_pump(self) -> bool:
        """Tell whether it is one of the pump, which it leaves as new."""
        return not self.lands

    @property
    def keeps_clearance(self) -> bool:
        """Tell whether a land keeps the clearance that was measured: it is cleaned, and nothing else is stated."""
        return self.kind == "clean_and_reuse" and self.mounting_clearance is None

    def changes(self, key: LandKey) -> bool:
        """Tell whether it is a repair of that land."""
        return key in self.lands


def find_repairs(repairs: Sequence[Repair], wanted: Iterable[str], controller: str) -> tuple[Repair, ...]:
    """Return the repairs of those ids, as a workshop chooses them for a plan.

    Raises
    ------
    InputError
        an id that the controller's file does not have, or two repairs of the same land or of the pump.
    """
    known = {repair.id: repair for repair in repairs}
    chosen: list[Repair] = []
    for name in dict.fromkeys(wanted):
        if name not in known:
            otherwise = None if known else Sentence("no repair: the file has no table [[repairs]]")
            problem = Sentence("{controller} names no such repair", controller=Name(controller))
            raise unknown(problem, name, known, otherwise=otherwise)
        for other in chosen:
            if known[name].of_pump and other.of_pump:
                problem = Sentence("{repair} and {other} both repair the pump", repair=name, other=other.id)
                raise InputError(problem, expected=Sentence("one repair of the pump"))
            both = [key for key in known[name].lands if other.changes(key)]
            if both:
                component, land = both[0]
                problem = Sentence(
                    "{repair} and {other} both repair component {component} land {land}",
                    repair=name,
                    other=other.id,
                    component=component,
                    land=land,
                )
                raise InputError(problem, expected=Sentence("one repair of each land"))
        chosen.append(known[name])
    return tuple(chosen)


class ComplaintTable(Strict):
    """A complaint as a controller's file states it; lands are written ``"8/1"``, component and land."""

    id: Identifier = key("Id", ID_HELP, width=20)
    label: NonEmptyText = key("Label", "What people see", width=30)
    conditions: list[Identifier] = key("Operating points", "Their names, with commas", width=28, min_length=1)
    lands: list[NonEmptyText] | None = key(
        "Lands", "That can explain it: boost_valve/2, 8/1", width=24, default=None, min_length=1
    )
    source: Source | None = key("Source", "Manual and page, or who measured it", width=40, default=None)


@dataclass(frozen=True)
class Complaint:
    """What a customer says, and where the leakage behind it shows."""

    id: str  # by which a job names it
    label: str  # in the customer's words
    conditions: tuple[str, ...]  # names of operating points
    lands: tuple[LandKey, ...]  # that can explain it; none where every land that leaks in those conditions can
    source: str  # who states where it shows

    @property
    def record(self) -> dict[str, str | list[str]]:
        """Return the complaint as the catalogue lists it."""
        return {
            "id": self.id,
            "label": self.label,
            "conditions": list(self.conditions),
            "lands": [written_land(key) for key in self.lands],
            "source": self.source,
        }


def written_land(key: LandKey) -> str:
    """Write a land as complaints name it: ``8/1``."""
    component, land = key
    return f"{component}/{land}"
