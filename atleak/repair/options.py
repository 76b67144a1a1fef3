"""How lands can be mended by what the controller's file names, what that leaves of each, and what it costs."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.repairs import Repair
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import repaired
from atleak.readings import LandClearance
from atleak.rules import LandKey, clearance_limits
from atleak.verdicts import Verdict

Chosen = Mapping[LandKey, "Option | None"]


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

    def cheapest(self, keys: Sequence[LandKey]) -> Option | None:
        """Return the cheapest option that mends all of some lands; None where none does.

        Notes
        -----
        Those with a price come before those without; of one price that with fewer hours of work, then the first of the
        file. Prices in several currencies are not compared: the first of the file is taken.
        """
        able = [option for option in self.all if all(option.mends(key) for key in keys)]
        comparable = len({option.repair.currency for option in able if option.repair.price is not None}) < 2
        return min(able, key=_expense, default=None) if comparable else able[0]

    def wanted(self, key: LandKey) -> Option | None:
        """Return the option that the workshop chose for a land, whether it mends the land or not; None without one."""
        return next((option for option in self.of(key) if option.repair in self.diagnosis.repairs), None)

    @cached_property
    def single(self) -> Chosen:
        """Return for every land the option that is chosen where it is mended alone."""
        return {land.key: self.wanted(land.key) or self.cheapest([land.key]) for land in self.diagnosis.lands}

    def by_component(self, lands: Sequence[LandDiagnosis]) -> Chosen:
        """Return the option for each of some lands in their order, those of one component mended together if cheaper.

        What the workshop chose comes first. An option that is taken for one land counts for every other land that it
        mends. Where one option mends all of a component's lands and is not dearer, it is taken instead.
        """
        chosen: dict[LandKey, Option | None] = {land.key: None for land in lands}
        components: dict[str, list[LandKey]] = defaultdict(list)
        for land in lands:
            components[land.key[0]].append(land.key)
        for keys in components.values():
            taken: list[Option] = []
            for key in keys:
                option = self.wanted(key) or next((each for each in taken if each.mends(key)), None) or self.single[key]
                chosen[key] = option
                if option is not None and option not in taken:
                    taken.append(option)
            whole = self.cheapest(keys)
            free = not any(self.wanted(key) for key in keys)
            if free and whole is not None and len(taken) > 1 and _not_dearer(whole, taken):
                chosen.update(dict.fromkeys(keys, whole))
        return chosen

    def model(self, chosen: Chosen) -> LeakageModel:
        """Return the unit with every land as its chosen option leaves it; one without an option is as new.

        A land for which nothing is chosen is as the option of another one leaves it, where that changes it too.
        """
        states: dict[LandKey, LandClearance] = {}
        for option in filter(None, chosen.values()):
            states |= {key: state for key, state in option.states.items() if key not in chosen}
        states |= {key: option.states[key] for key, option in chosen.items() if option is not None}
        if not states:
            return self.diagnosis.as_new
        as_new = self.diagnosis.as_new
        return replace(as_new, clearances=tuple(states.get(each.land.key, each) for each in as_new.clearances))


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


def _expense(option: Option) -> tuple[bool, float, float]:
    repair = option.repair
    hours = math.inf if repair.hours is None else repair.hours
    return repair.price is None, repair.price or 0.0, hours


def _not_dearer(whole: Option, several: Sequence[Option]) -> bool:
    """Tell whether one option costs no more than several, as far as their prices can be compared."""
    repairs = [whole.repair, *(option.repair for option in several)]
    prices = [repair.price for repair in repairs if repair.price is not None]
    if len(prices) < len(repairs) or len({repair.currency for repair in repairs}) > 1:
        return whole in several
    return prices[0] <= sum(prices[1:])
