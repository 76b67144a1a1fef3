"""How lands can be mended by what the controller's file names, what that leaves of each, and what it costs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from atleak.catalogue.repairs import Repair
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import repaired
from atleak.land_diagnosis import LandDiagnosis
from atleak.readings import LandClearance
from atleak.rules import LandKey, clearance_limits
from atleak.verdicts import Verdict


@dataclass(frozen=True)
class Cost:
    """What repairs cost together: parts by currency, and hours of work."""

    prices: Mapping[str, float]  # by currency, in the order in which they come
    hours: float
    repairs: int  # that are counted
    without_price: int  # repairs among them whose file states none
    without_hours: int
    without_option: int  # lands made as new, for which the file names nothing that mends them


@dataclass(frozen=True)
class Option:
    """One repair of the controller's file, and how it leaves the lands that it changes."""

    repair: Repair
    states: Mapping[LandKey, LandClearance]  # of every land that it changes, afterwards
    mending: frozenset[LandKey]  # the lands that are then within their limit of clearance, and tighter than measured

    @property
    def lands(self) -> tuple[LandKey, ...]:
        """Return every land that it changes."""
        return tuple(self.states)

    def mends(self, key: LandKey) -> bool:
        """Tell whether a land is tighter afterwards, and within its limit of clearance."""
        return key in self.mending


class Options:
    """The repairs that a controller's file names, seen from one unit."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis = diagnosis
        by_key = {land.key: land for land in diagnosis.lands}
        self.all = tuple(_option(repair, by_key, diagnosis) for repair in diagnosis.controller.repairs)

    def of(self, key: LandKey) -> tuple[Option, ...]:
        """Return the options for one land, in the order of the file."""
        return tuple(option for option in self.all if key in option.states)

    def wanted(self, key: LandKey) -> Option | None:
        """Return the option that the workshop chose for a land, whether it mends the land or not; None without one."""
        return next((option for option in self.of(key) if option.repair in self.diagnosis.repairs), None)


def cost_of(options: Iterable[Option | None]) -> Cost:
    """Add up what repairs cost; None stands for a land that is made as new without one."""
    listed = list(options)
    repairs = [option.repair for option in listed if option is not None]
    prices: dict[str, float] = defaultdict(float)
    for repair in repairs:
        if repair.price is not None and repair.currency is not None:
            prices[repair.currency] += repair.price
    return Cost(
        prices=dict(prices),
        hours=sum(repair.hours or 0.0 for repair in repairs),
        repairs=len(repairs),
        without_price=sum(repair.price is None for repair in repairs),
        without_hours=sum(repair.hours is None for repair in repairs),
        without_option=len(listed) - len(repairs),
    )


def _option(repair: Repair, lands: Mapping[LandKey, LandDiagnosis], diagnosis: Diagnosis) -> Option:
    mine = [land for land in lands.values() if repair.changes(land.key)]
    states = {land.key: _after(repair, land.state) for land in mine}
    mending = frozenset(
        land.key
        for land in mine
        if states[land.key].radial_clearance < land.state.radial_clearance
        and (not repair.ends or _within_limits(states[land.key], diagnosis))  # new parts are as new
    )
    return Option(repair, states, mending)


def _after(repair: Repair, state: LandClearance) -> LandClearance:
    """Return a land after a repair; one that is only cleaned keeps the clearance that was measured."""
    if repair.keeps_clearance:
        return state
    land = state.land.with_repair(repair)
    if repair.nominal_diameter is not None:
        state = replace(state, spool_diameter=repair.nominal_diameter)
    (after,) = repaired([replace(state, land=land)], [land.key])
    return after


def _within_limits(state: LandClearance, diagnosis: Diagnosis) -> bool:
    """Tell whether even the widest that a repair states to leave is within the limit of the land's clearance."""
    steps = clearance_limits(state, diagnosis.limits)
    return steps is None or steps.judge(state.land.widest_new, Verdict.OK)[0] == Verdict.OK
