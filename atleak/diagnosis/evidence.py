"""Say what is likely worn before anything is opened, and what to measure next, from all that was shown of a unit.

A part is worn in a draw of the unit where its clearance has grown past its first limit for wear. What is said of it are
shares of the draws, weighed by gauges, log, flows and plugs (`atleak.diagnosis.uncertainty.weighing`).

A land that nobody reads may be the one that costs most. Its reading is worth what that costs on average, in first
limits: of a circuit's loss, and of a pair's share of the pump, 1 at most of each. Lands are read by turns, the
likeliest to cost a pressure most, the likeliest to be worn and the likeliest to cost the pump most: gauges that miss
nothing tell little of wear and flow.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Land
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_card import section_of
from atleak.diagnosis.missing import Row
from atleak.diagnosis.uncertainty import Assumptions
from atleak.diagnosis.uncertainty.wear import UnitWear
from atleak.diagnosis.uncertainty.weighing import Lost, Told
from atleak.diagnosis.weighed_evidence import AllEvidence, Beside
from atleak.engine.operation import LINE
from atleak.measurements.gauge_readings import NO_GAUGES
from atleak.measurements.measuring_plan import QUICK_LANDS, Plan

LIKELY = 0.65  # from which probability on a circuit is said to have lost too much: 0.5 % false alarms by simulation
NEXT = 3  # lands that are named to be measured next
_FINEST = 0.1e-6  # [m]
_ENDS = 0.025, 0.5, 0.975
_NAMED = 3.0  # times as much does a land cost that the customer's complaint names: choice of this project
_USUAL_SHARE = 0.02  # of the pump's flow, where no limit is set
_TELLS = 0.1  # of a probability, by which evidence moves it at least: choice of this project
PUMP_WORN = 0.5  # growth of its slip from which on a pump is called worn: choice of this project
WORTH = 0.02  # of a first limit that a reading is worth at least, to be worth its time: choice of this project

_THIN = Sentence(
    "Nothing that was read sets a land or a circuit apart: this is what is assumed of any used unit. Read gauges at "
    "the line and at the taps first."
)


@dataclass(frozen=True)
class LandEvidence:
    """What is known of one land."""

    land: Land
    probability: float  # that it is worn past its first limit
    clearance: float  # [m] as likely more as less
    low: float  # [m] between which it lies in 95 of 100 cases
    high: float
    loss: float  # [Pa] that it costs the pressure that loses most by it of those that gauges read, on average
    group: int | None  # the lands with this number cannot be told apart; None: by itself
    of_group: float  # probability that one of them at least is worn; its own of a land by itself
    measured: bool


@dataclass(frozen=True)
class CircuitEvidence:
    """What is known of a circuit, or of its clutch's seal."""

    circuit: Circuit
    probability: float  # that it has lost more than its first limit; that its seal leaks
    loss: float  # [Pa] as likely more as less; by its seal
    low: float  # [Pa] in 95 of 100 cases
    high: float
    read: bool  # by a gauge


@dataclass(frozen=True)
class PumpEvidence:
    """What is known of the pump."""

    probability: float  # that a measured clearance is past its limit; else that its slip has grown by half or more
    growth: float  # of its slip, as a fraction, as likely more as less
    low: float
    high: float


@dataclass(frozen=True)
class NextReading:
    """A land to measure next."""

    land: Land
    value: float  # what it would cost on average to leave it unread, in first limits


@dataclass(frozen=True)
class Evidence:
    """What is likely worn: lands that cost most on average first, circuits that have most likely lost most."""

    lands: tuple[LandEvidence, ...]
    circuits: tuple[CircuitEvidence, ...]
    pump: PumpEvidence | None  # None where the profile lets no pump slip
    seals: tuple[CircuitEvidence, ...]
    next: tuple[NextReading, ...]
    effective_samples: float  # the least of any part
    assumptions: Assumptions
    thin: Sentence | None  # why what is listed is little more than what is assumed


def evidence_of(diagnosis: Diagnosis) -> Evidence:
    """Return what is likely worn in a unit, from all that was shown of it.

    Parameters
    ----------
    diagnosis
        with any of gauge readings, log, flows, plugs, pump clearances and readings of lands, or none.
    """
    return kept_with(diagnosis, "evidence", "", lambda: _Finder(diagnosis).evidence, most=1)


class _Finder:
    """Finds it out of the draws of one unit."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis, card = diagnosis, diagnosis.gauge_card
        self.controller, self.assumptions = diagnosis.controller, card.assumptions
        check, beside = diagnosis.pressures, Beside(diagnosis.log, diagnosis.flows, diagnosis.vacuum)
        shown = check or AllEvidence(NO_GAUGES, card, beside, diagnosis.projections)
        self.weighed = kept_with(diagnosis, "weighed", "", lambda: shown.weighed, most=1)
        self.read = {each.cell.tap for each in check.readings} if check else set()

    @property
    def evidence(self) -> Evidence:
        lands = sorted(self._lands(), key=lambda each: (-each.loss, -each.probability))
        # less than 1 % is not told apart by the draws, how much may be lost is
        circuits = sorted(self._circuits(), key=lambda each: (-round(each.probability, 2), -each.high))
        pump = self._pump()
        found = Evidence(
            lands=tuple(lands),
            circuits=tuple(circuits),
            pump=pump,
            seals=tuple(sorted(self._seals(), key=lambda each: -each.probability)),
            next=self.worth(NEXT, WORTH),
            effective_samples=min((each.effective for each in self.weighed.told), default=0.0),
            assumptions=self.assumptions,
            thin=None if self._tells(lands, circuits, pump) else _THIN,
        )
        self.weighed.let_go()
        return found

    def _lands(self) -> Iterator[LandEvidence]:
        groups = self._groups()
        for told in self.weighed.told:
            for key, now in told.now.items():
                low, middle, high = np.quantile(now, _ENDS).tolist()
                land = self.controller.land(*key)
                measured = key not in self.diagnosis.open_lands
                group, worn = groups.get(key), self.worn(told, key)
                alike = [self.worn(told, each) for each in told.now if group is not None and groups.get(each) == group]
                usual = self._usual(land, now) if measured else None
                probability = float(np.average(worn, weights=usual))
                of_group = float(np.mean(np.any(alike, axis=0))) if alike else probability
                costs = self.explains(key, read=True)
                yield LandEvidence(land, probability, middle, low, high, costs, group, of_group, measured)

    def _usual(self, land: Land, clearance: np.ndarray) -> np.ndarray:
        """Return how usual a clearance is of this unit: what a measurement cannot tell stays as the others show it.

        It is the density of lands that were new anywhere in their range, some of them worn since.
        """
        (worn, wear), (low, high), now = self._wear, land.mounting_range, np.asarray(clearance, float)
        spread = max(self.assumptions.mounting_clearance, 0.5 * (land.mounting_tolerance or 0.0), _FINEST)
        low, high, mean = low - spread, high + spread, max(wear, _FINEST)
        new = (low <= now) & (now <= high)
        gone = np.exp(-np.maximum(now - high, 0.0) / mean) - np.exp(-np.maximum(now - low, 0.0) / mean)
        density = (1.0 - worn) * new + worn * gone
        return density if density.any() else np.ones_like(density)

    @cached_property
    def _wear(self) -> tuple[float, float]:
        """Return which part of the lands is worn, and how far on average [m], as those that were measured show."""
        unit = self.diagnosis.uncertainty
        return UnitWear([land.sources for land in unit.lands] if unit else (), self.assumptions).usual

    def worn(self, told: Told, key: LandKey) -> np.ndarray:
        """Return in which draws a land is worn: its clearance has grown past its first limit for wear."""
        now, new, steps = told.now[key], told.new[key], self.diagnosis.limits.wear
        if steps is None:
            return np.asarray(now > new)
        level, fraction = steps.levels[0]
        return np.asarray(now - new >= np.maximum(fraction * new, steps.at_least.get(level, 0.0)))

    def explains(self, key: LandKey, *, read: bool = False) -> float:
        """Return what a land costs the pressure that loses most by it, of all or of those that gauges read [Pa]."""
        taps = {section_of(tap) for tap in self.read}
        shown = (each for tap, each in self._pressure if tap in taps or not (read and taps))
        return max((each.get(key, 0.0) for each in shown), default=0.0)

    def worth(self, most: int, least: float = 0.0) -> tuple[NextReading, ...]:
        """Return what to read next: by turns what likeliest costs a pressure most, is worn, and costs the pump most."""
        ways, values = list[list[LandKey]](), defaultdict[LandKey, float](float)
        for costs in (self._by_pressure, self._by_flow):
            worst = self._worst(costs)
            ways.append(sorted(worst, key=lambda key: (-worst[key].size, key)))
            for key, found in worst.items():
                values[key] += float(np.minimum(found, 1.0).sum()) / self._draws
        worn = {key: float(np.mean(self.worn(told, key))) for told in self.weighed.told for key in told.now}
        of_pressure, of_pump = ways
        likely = sorted(self.diagnosis.open_lands & worn.keys(), key=lambda key: (-self._counts(key) * worn[key], key))
        turns = dict.fromkeys(key for turn in zip_longest(of_pressure, likely, of_pump) for key in turn if key)
        chosen = [key for key in turns if values[key] >= least][:most]
        return tuple(NextReading(self.controller.land(*key), values[key]) for key in chosen)

    def _worst(self, costs: Mapping[LandKey, float]) -> dict[LandKey, np.ndarray]:
        """Return what each land that nobody measured costs in the draws in which no land costs more, from averages."""
        keys, in_draws = list[LandKey](), list[np.ndarray]()
        for number, told in enumerate(self.weighed.told):
            any_order = np.random.default_rng(number).permutation(self._draws)  # parts are drawn apart from one another
            for key in told.now:
                growth = np.maximum(told.now[key] ** 3 - told.new[key] ** 3, 0.0)[any_order]
                mean = float(growth.mean())
                keys.append(key)
                in_draws.append(growth * (costs.get(key, 0.0) / mean if mean > 0.0 else 0.0))
        most, worst = np.max(in_draws, axis=0), np.argmax(in_draws, axis=0)
        found = {key: most[(worst == place) & (most > 0.0)] for place, key in enumerate(keys)}
        return {key: each for key, each in found.items() if each.size and key in self.diagnosis.open_lands}

    @property
    def _draws(self) -> int:
        return int(self.weighed.told[0].slip.size)

    @property
    def _by_pressure(self) -> dict[LandKey, float]:
        """Return what each land costs the pressure that loses most by it, on average, in first limits."""
        keys = {key for told in self.weighed.told for key in told.now}
        return {key: self._counts(key) * self.explains(key) / self._limit for key in keys}

    @property
    def _by_flow(self) -> dict[LandKey, float]:
        """Return what each land costs the pump, on average, in first limits of a pair's share."""
        shares, of_pairs = self._flow, self.diagnosis.limits.pair_share
        limit = of_pairs.levels[0][1] if of_pairs is not None else _USUAL_SHARE
        return {key: self._counts(key) * share / limit for key, share in shares.items()}

    def _counts(self, key: LandKey) -> float:
        """Return as how much a land counts that the complaint names."""
        complaint = self.diagnosis.complaint
        return _NAMED if complaint is not None and key in complaint.lands else 1.0

    @property
    def _every(self) -> list[tuple[str, Lost]]:
        return [(section, self.weighed.lost(section, point)) for section, point in self.weighed.wanted]

    @cached_property
    def _pressure(self) -> list[tuple[str, dict[LandKey, float]]]:
        return [(section, _of_lands(lost.split.lands)) for section, lost in self._every]

    @cached_property
    def _flow(self) -> dict[LandKey, float]:
        """Return what the wear of each land adds to the demand on the pump, as a share of its flow."""
        at = next((each for each in self.weighed.wanted if each[0] == LINE), None)
        if at is None:
            return {}
        point = at[1]
        supplied = point.engine_speed, point.main_pressure, point.temperature
        capacity = float(self.diagnosis.model.pump_capacity(*supplied)) or math.inf
        return {key: each / capacity for key, each in _of_lands(self.weighed.lost(*at).split.flows_of_lands).items()}

    def _groups(self) -> dict[LandKey, int]:
        """Return a number for every land that no gauge can tell from others: nobody measured them, and they see alike.

        They leak from and into the same pressures in the same gears.
        """
        ways: dict[LandKey, set[object]] = {}
        for gap in self.controller.gaps:
            ways.setdefault(gap.key, set()).add((gap.high, gap.low, gap.gears))
        alike: dict[frozenset[object], list[LandKey]] = {}
        for key in self.diagnosis.open_lands:
            alike.setdefault(frozenset(ways.get(key, ())), []).append(key)
        several = sorted(sorted(keys) for keys in alike.values() if len(keys) > 1)
        return {key: number for number, keys in enumerate(several, 1) for key in keys}

    @cached_property
    def _lost(self) -> Mapping[str, Lost]:
        """Return what every circuit has lost, there where it has most likely lost more than its first limit."""
        limit, worst = self._limit, dict[str, Lost]()
        for section, lost in self._every:
            known = worst.get(section)
            if section != LINE and (known is None or lost.probability_over(limit) > known.probability_over(limit)):
                worst[section] = lost
        return worst

    @property
    def _limit(self) -> float:
        steps = self.diagnosis.limits.circuit_loss
        return steps.levels[0][1] if steps is not None else math.inf

    def _circuits(self) -> Iterator[CircuitEvidence]:
        judged = self._lost if self.diagnosis.limits.circuit_loss is not None else {}
        for section, lost in judged.items():
            low, middle, high = (lost.quantile(each) for each in _ENDS)
            probability = lost.probability_over(self._limit)
            yield CircuitEvidence(self._circuit(section), probability, middle, low, high, section in self.read)

    def _seals(self) -> Iterator[CircuitEvidence]:
        for section, lost in self._lost.items():
            if lost.split.seal_worn > 0.0:
                low, middle, high = np.quantile(lost.split.seal, _ENDS).tolist()
                worn = lost.split.seal_worn
                yield CircuitEvidence(self._circuit(section), worn, middle, low, high, section in self.read)

    def _circuit(self, section: str) -> Circuit:
        return next(each for each in self.controller.circuits if each.id == section)

    def _pump(self) -> PumpEvidence | None:
        if not self.diagnosis.model.uses_slip:
            return None
        slip = self.weighed.told[0].slip
        low, middle, high = np.quantile(slip, _ENDS).tolist()
        past = [each.probability_over_limit or 0.0 for each in self.diagnosis.pump.decisions]
        return PumpEvidence(max(past, default=float(np.mean(slip >= PUMP_WORN))), middle, low, high)

    def _tells(
        self, lands: Iterable[LandEvidence], circuits: Iterable[CircuitEvidence], pump: PumpEvidence | None
    ) -> bool:
        """Tell whether anything was measured of a land, or the evidence moves the probability of anything."""
        u = self.assumptions
        moved = [each.measured or each.probability > u.worn_lands + _TELLS for each in lands]
        moved += [pump is not None and pump.probability > u.worn_pumps + _TELLS, bool(self.read)]
        moved += [len(each.lands) > 1 for each in self.diagnosis.vacuum]
        return any(moved) or any(each.probability > 0.5 for each in circuits)


def _of_lands(rows: Mapping[Row, Mapping[LandKey, np.ndarray]]) -> dict[LandKey, float]:
    return {key: float(np.mean(values)) for lands in rows.values() for key, values in lands.items()}


def readings_by_value(diagnosis: Diagnosis, most: int) -> tuple[NextReading, ...]:
    """Return which lands to measure, one after the other: by turns for a pressure, for wear and for the pump's flow.

    Parameters
    ----------
    diagnosis
        whose lands that nobody measured are asked for.
    most
        as many at the most. One of less than `WORTH` is not worth its time.
    """
    return _Finder(diagnosis).worth(most)


def quick_pass(diagnosis: Diagnosis) -> Plan | None:
    """Return the plan of the few lands that tell most, the one whose reading is worth most first; None without one."""
    lands = [each.land.key for each in readings_by_value(diagnosis, QUICK_LANDS)]
    return Plan.quick(lands) if lands else None
