"""How lands can be mended by what the controller's file names, what that leaves of each, and what it costs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from atleak.catalogue.repairs import LandKey, Repair
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import land_rules
from atleak.engine.projection import project, repaired, with_even_clearance
from atleak.measurements.clearances import LandClearance


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
    mending: frozenset[LandKey]  # the lands that are then within their limits, and tighter than measured

    @property
    def lands(self) -> tuple[LandKey, ...]:
        """Return every land that it changes."""
        return tuple(self.states)

    def mends(self, key: LandKey) -> bool:
        """Tell whether a land is tighter afterwards, and within its limits."""
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
    tighter = [land for land in mine if states[land.key].radial_clearance < land.state.radial_clearance]
    mending = frozenset(land.key for land in tighter)
    if repair.ends and tighter:  # new parts are as new
        mending &= _within_limits([_widest(land.state, states[land.key]) for land in mine], diagnosis)
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


def _widest(before: LandClearance, after: LandClearance) -> LandClearance:
    """Return a land as wide as its repair may leave it, still worn from what it had when new."""
    return replace(with_even_clearance(after, after.land.widest_new), land=before.land)


def _within_limits(states: Iterable[LandClearance], diagnosis: Diagnosis) -> frozenset[LandKey]:
    """Return which lands are within all of their limits, in a unit that is otherwise as it was measured.

    Where the pump delivers nothing no clearance has a share that is within a limit, and none is judged by it.
    """
    by_key = {state.land.key: state for state in states}
    clearances = tuple(by_key.get(each.land.key, each) for each in diagnosis.model.clearances)
    model = replace(diagnosis.model, clearances=clearances)
    delivering = (now for now in diagnosis.projections if now.pump_capacity > 0.0)
    at = [(project(model, now.condition), diagnosis.unworn_at(now)) for now in delivering]
    rules = {key: land_rules(state, at, diagnosis.limits) for key, state in by_key.items()}
    return frozenset(key for key, judged in rules.items() if worst(rule.verdict for rule in judged) is Verdict.OK)
