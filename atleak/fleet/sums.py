"""A fleet in numbers: what `atleak.fleet.summary` finds and workbook, PDF, terminal, pages and JSON show.

Numbers are carried as atleak's records carry them: per cent, kPa, °C, km, s. What a number says of units counts every
unit once: rows of one valve body with one serial number, or else VIN, are visits of one unit. The last visit counts at
which anything was measured, by date and then mileage; the last of all where none was. Valve bodies are never mixed in
what is said of a land, a condition or a temperature.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from atleak.analysis.rates import SHOWN_QUANTILES, Rate, Spread
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message
from atleak.common.units import PERCENT
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.uncertainty import Decision
from atleak.fleet.columns import HASH
from atleak.report.json.conditions import message_record
from atleak.report.json.diagnosis import FORMAT
from atleak.version import __version__

GROUP = "group"  # the heading of what sub-folder, or column of this name, a unit comes from
LISTED = 50  # units that are listed unless more or fewer are asked for
MOST_IN_PAIRS = 4  # groups, from above which on each is compared with all others together: choice of this project
MOST_COMPARED = 30  # groups of a valve body, those of the most units; the rest is counted: choice of this project
MOST_GROUPS = 200  # under one heading; what differs more is no group of units: choice of this project


@dataclass(frozen=True)
class VerdictCounts:
    """How many units have which verdict; each unit once, as it was evaluated last.

    A unit of which nothing was measured is ``not_measured`` and in no rate: what was not measured is not *ok*. One of
    which no land was judged has the verdict of its log and gauges, and is in no rate either.
    """

    units: int
    verdicts: Mapping[Verdict, int]  # every verdict, also those of no unit; they add up to `units`
    decisions: Mapping[Decision | None, int]  # None: units without a decision; they add up to `units`
    provisional: int  # units whose verdict rests on representative values
    ok_in_part: int  # units that are ok as far as they were measured, or by log or gauges: not all of their lands were
    rates: Mapping[Verdict, Rate]  # at this verdict or past it, of the judged units: watch, replace, critical
    without_sheet: int = 0  # units with a verdict by log or gauges alone: no land of theirs was judged

    @property
    def judged(self) -> int:
        """Return how many units have a verdict of their lands: what the rates are of."""
        return self.units - self.verdicts[Verdict.NOT_MEASURED] - self.without_sheet

    @property
    def ok_throughout(self) -> int:
        """Return how many units are ok at every land."""
        return self.verdicts[Verdict.OK] - self.ok_in_part


@dataclass(frozen=True)
class Decider:
    """What decided the verdicts of some flagged units of a valve body, the most frequent first in its tuple."""

    kind: str  # as `decided_by.kind` of a result: land, total, circuit, permissible_pressure, …
    component: str | None  # of a land
    land: int | None
    circuit: str | None  # id, of a circuit
    units: Rate  # of the flagged units


@dataclass(frozen=True)
class PairTrouble:
    """How often one land of a valve body is flagged, past *replace*, and what decides the verdict of its unit.

    Each unit counts once. A unit is in the rates of a land of which both parts were measured; with one part alone, a
    land can be flagged and cannot be ok.
    """

    key: LandKey
    flagged: Rate  # at *watch* or past it, of the units of which it was measured
    replace: Rate  # at *replace* or past it, of the same
    deciding: Rate  # whose verdict it gave, of the judged units of the valve body
    not_measured: int  # units without both of its parts measured, or in which a ring seals it
    flagged_by_one_part: int  # of those


@dataclass(frozen=True)
class MileageClass:
    """The wear of one land in the units of one class of mileage.

    A unit counts once in every class in which it was measured, as it was measured last there.
    """

    low_km: float  # from
    high_km: float  # to below
    wear_percent: Spread


@dataclass(frozen=True)
class LandOverMileage:
    """The wear of one land of a valve body over mileage: all visits at which it was measured count.

    What is left out is counted: measurements without a mileage, and those of a land that was repaired, whose mileage
    is not that of its unit.
    """

    key: LandKey
    classes: tuple[MileageClass, ...]  # rising; classes without a unit are left out
    without_mileage: int  # measurements
    repaired: int  # measurements
    latest_percent: Spread | None  # wear at the visit that counts of every unit, mileage known or not; None of no unit


@dataclass(frozen=True)
class TemperatureSums:
    """What the logs of a valve body's units say between two temperatures; of every unit its last log counts.

    The means of all are weighted by time: an hour of one unit counts as an hour of another. The spreads are over units,
    each by its own mean in this class.
    """

    low_c: float  # from
    high_c: float  # to below
    seconds: float
    share_mean_percent: float | None  # None where no log tells a share
    share_percent: Spread | None
    share_max_percent: float | None  # the largest of any unit
    pressure_mean_kpa: float | None  # main pressure; None where no log tells it
    pressure_kpa: Spread | None
    pressure_min_kpa: float | None  # the lowest of any unit
    bands_percent: Mapping[Band, float] | None  # time in each band, of that with the share in any; None without
    green_in_part_percent: float = 0.0  # of the same time: in green, with lands that were not measured and count as new

    @property
    def units(self) -> int:
        """Return of how many units a log tells share or pressure here."""
        return max((spread.units for spread in (self.share_percent, self.pressure_kpa) if spread), default=0)


@dataclass(frozen=True)
class ConditionSpread:
    """A stated condition over the units of a valve body; each unit once, as it was measured last.

    Conditions of one name are one only where temperature, engine speed and gear agree.
    """

    name: str
    label: str
    temperature_c: float
    engine_rpm: float
    gear: int
    required_kpa: float | None  # main pressure that is required there; None where units were told different ones
    share_percent: Spread | None  # None where no unit has a number
    pressure_held_kpa: Spread | None  # main pressure that the pump holds
    bands: Mapping[Band, int]  # units by the band of their share; every band, also those of no unit
    partly: int  # units of which lands were not measured and count as new: their shares are lower bounds


@dataclass(frozen=True)
class Group:
    """The units of one group."""

    name: str
    counts: VerdictCounts
    mileage_km: Spread | None  # None where no unit has one
    without_mileage: int  # units


@dataclass(frozen=True)
class Difference:
    """First minus second, in percentage points, with two intervals; None where a side has too few units.

    ``low`` … ``high`` is the 95 % interval of this difference alone. ``low_of_all`` … ``high_of_all`` is wider: it
    holds for all differences of the comparison at once, and decides.
    """

    value: float
    low: float | None
    high: float | None
    low_of_all: float | None
    high_of_all: float | None

    @property
    def span_of_all(self) -> tuple[float, float] | None:
        """Return the interval that holds for all at once; None without one."""
        return None if self.low_of_all is None or self.high_of_all is None else (self.low_of_all, self.high_of_all)

    @property
    def differs(self) -> bool | None:
        """Return whether the interval that holds for all at once leaves out zero; None without one."""
        span = self.span_of_all
        return None if span is None else not span[0] <= 0.0 <= span[1]


@dataclass(frozen=True)
class RateDifference:
    """The difference of the rates of a verdict (at it or past it) between two groups."""

    first: str
    second: str | None  # None: all other groups together
    verdict: Verdict  # watch, replace or critical
    first_units: int  # judged
    second_units: int
    points: Difference | None  # of the rates; None where a side has no measured unit


@dataclass(frozen=True)
class WearDifference:
    """The difference of the wear of one land between two groups; repaired lands are left out."""

    first: str
    second: str | None  # None: all other groups together
    key: LandKey
    first_percent: Spread | None  # wear; None of no unit
    second_percent: Spread | None
    mean_points: Difference | None  # of the means; None where a side has no unit
    median_points: float | None  # of the medians
    same_mileage_points: Difference | None  # of the means within classes of mileage; None where none holds both sides


@dataclass(frozen=True)
class GroupComparison:
    """The groups of one valve body side by side.

    Where nothing differs at all, at most one comparison in twenty calls any of its differences one.
    """

    groups: tuple[Group, ...]  # by name
    not_stated: int  # units that state no group, and are in none
    verdicts: tuple[RateDifference, ...]
    lands: tuple[WearDifference, ...]  # those that differ first, by size
    messages: tuple[Message, ...]  # that groups are too small, or of different mileage

    @property
    def in_pairs(self) -> bool:
        """Return whether each is compared with each, rather than with all others together."""
        return len(self.groups) <= MOST_IN_PAIRS


@dataclass(frozen=True)
class SummedUnit:
    """A unit in the list that leads to its own result: as it was evaluated last."""

    input_sha256: str  # of all that its result rests on; no part of a record
    controller: str  # id of the valve body
    reference: str  # by which `atleak.fleet.sources.reopened` opens it
    name: str
    group: str | None
    label: str | None  # what it states under the heading that the summary is by
    number: str | None  # of the job
    date: dt.date | None
    vin: str | None
    serial: str | None
    mileage_km: float | None
    verdict: Verdict
    decision: str | None
    provisional: bool
    decided_by: LandKey | str | None  # a land, or the kind of what else decided; None where nothing did
    lands_past: int  # of its lands at *replace* or past it
    max_share_percent: float | None  # of its log
    visits: int  # rows of this unit
    lands_measured: int | None = None
    lands_total: int | None = None


@dataclass(frozen=True)
class ErrorCount:
    """The files of one kind of error."""

    kind: str  # refused, time limit, ended, fault
    count: int
    first: tuple[tuple[str, str], ...]  # name and message, a few, each message once

    @property
    def messages(self) -> tuple[str, ...]:
        """Return the first messages, each with the name of its file."""
        return tuple(named_message(name, message) for name, message in self.first)


def named_message(name: str, message: str) -> str:
    """Return the message of an error with the unit's name before it, unless it names the unit itself.

    >>> named_message("north/017.zip", "017.zip: is no sound zip"), named_message("table.csv, row 7", "no sheet")
    ('north/017.zip: is no sound zip', 'table.csv, row 7: no sheet')
    """
    if message.startswith(name):
        return message
    end = max(name.rfind("/"), name.rfind("\\")) + 1
    named = 0 < end < len(name) and message.startswith(f"{name[end:]}: ")
    return f"{name[:end]}{message}" if named else f"{name}: {message}"


@dataclass(frozen=True)
class ValveBody:
    """The units of one valve body."""

    controller: str  # id
    visits: int  # rows
    counts: VerdictCounts
    deciders: tuple[Decider, ...]
    pairs: tuple[PairTrouble, ...]  # most often at *replace* first; every land that any unit has
    wear: tuple[LandOverMileage, ...]  # by component and land
    temperatures: tuple[TemperatureSums, ...]  # rising
    conditions: tuple[ConditionSpread, ...]  # as the valve body states them
    comparison: GroupComparison | None  # None where the summary is by nothing, or fewer than two groups have a unit
    messages: tuple[Message, ...]
    name: str | None = None  # as its description calls it; None where no result says


@dataclass(frozen=True)
class FleetSummary:
    """A fleet in numbers."""

    folder: str
    atleak: str  # version that made the results
    by: str | None  # heading by which groups are told; "group" for the sub-folder or the column of this name
    visits: int  # rows
    counts: VerdictCounts  # over all valve bodies
    groups: tuple[Group, ...]  # over all valve bodies; empty where the summary is by nothing
    not_stated: int  # units that state no group
    headings: tuple[str, ...]  # by which a summary of these results can be
    bodies: tuple[ValveBody, ...]  # with the most units first
    errors: tuple[ErrorCount, ...]
    worst: tuple[SummedUnit, ...]  # the worst units first
    messages: tuple[Message, ...]

    def body(self, controller: str) -> ValveBody:
        """Return one valve body by its id."""
        return next(body for body in self.bodies if body.controller == controller)


_QUANTILES = [f"p{part * PERCENT:.0f}" for part in SHOWN_QUANTILES]
_BESIDE = {Rate: ("percent",), Difference: ("differs",)}  # what a record says beside its fields
_KEYS: Mapping[type, Mapping[str, str]] = {  # of those whose keys are not their fields: each key, and what has it
    VerdictCounts: {key: key for key in ("units", "judged", "verdicts", "decisions", "provisional", "ok_in_part",
                                         "without_sheet", "rates")},
    GroupComparison: {"in_pairs": "in_pairs", "groups": "groups", "group_not_stated": "not_stated",
                      "verdicts": "verdicts", "lands": "lands", "messages": "messages"},
    ValveBody: {"controller": "controller", "name": "name", "visits": "visits", "counts": "counts",
                "deciders": "deciders", "lands": "pairs", "wear_over_mileage": "wear", "temperatures": "temperatures",
                "conditions": "conditions", "comparison": "comparison", "messages": "messages"},
    FleetSummary: {"folder": "folder", "results_by": "atleak", "by": "by", "headings": "headings", "visits": "visits",
                   "counts": "counts", "groups": "groups", "group_not_stated": "not_stated", "controllers": "bodies",
                   "errors": "errors", "worst": "worst", "messages": "messages"},
}  # fmt: skip


def summary_record(summary: FleetSummary) -> dict[str, Any]:
    """Return the record of a summary, in the form ``atleak fleet summary --json`` writes."""
    return {"format": FORMAT, "atleak": __version__, **_record(summary)}


def _record(value: Any) -> Any:
    if isinstance(value, Message):
        return message_record(value)
    if isinstance(value, dt.date):
        return value.isoformat()
    if isinstance(value, Mapping):
        return {key or "none": _record(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return [_record(each) for each in value]
    return _fields(value) if is_dataclass(value) else value


def _fields(value: Any) -> dict[str, Any]:
    """Return the record of an object: its fields by their names, a land's key by component and land."""
    own = {each.name: each.name for each in fields(value) if each.name != HASH} | {
        name: name for name in _BESIDE.get(type(value), ())
    }
    made: dict[str, Any] = {}
    for key, name in _KEYS.get(type(value), own).items():
        of_it = getattr(value, name)
        if name == "key":
            made["component"], made["land"] = of_it
        elif isinstance(value, SummedUnit) and name == "decided_by":
            made[key] = _decided_by(of_it)
        elif isinstance(value, Spread) and name == "quantiles":
            made[key] = None if of_it is None else dict(zip(_QUANTILES, of_it, strict=True))
        elif isinstance(value, ErrorCount) and name == "first":
            made[key] = [{"name": file, "message": message} for file, message in of_it]
        else:
            made[key] = _record(of_it)
    return made


def _decided_by(what: tuple[str, int] | str | None) -> dict[str, Any]:
    component, land = what if isinstance(what, tuple) else (None, None)
    return {"kind": "land" if isinstance(what, tuple) else what, "component": component, "land": land}
