"""Say what is likely worn before anything is opened, and what to measure next, from all that was shown of a unit.

A part is worn in a draw of the unit where its clearance has grown past its first limit for wear. What is said of it are
shares of the draws, weighed by gauges, log, flows and plugs (`atleak.diagnosis.uncertainty.weighing`).

A reading is worth the expected fall of what wrong decisions cost when it becomes known with its own uncertainty: the
draws fall into bins of it, and in each bin every land is repaired where that is the likelier to be right. To leave a
land costs what its wear takes from the unit, 1 where that reaches a first limit of a circuit's loss or of a pair's
share of the pump; to open it costs what is left of 1. Readings are chosen one after the other, each beside those before
it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Land
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_check import Beside, Weighed, weigh
from atleak.diagnosis.missing import Row
from atleak.diagnosis.uncertainty import Assumptions
from atleak.diagnosis.uncertainty.weighing import Lost, Told
from atleak.engine.operation import LINE
from atleak.measurements.gauge_readings import LINE_TAP
from atleak.measurements.measuring_plan import QUICK_LANDS, Plan

LIKELY = 0.65  # from which probability on a circuit is said to have lost too much: 0.5 % false alarms by simulation
NEXT = 3  # lands that are named to be measured next
_FINEST = 0.1e-6  # [m]
_ENDS = 0.025, 0.5, 0.975
_EDGES = 0.5, 0.75, 0.88, 0.95  # of the bins of a reading, as parts of all that it may be; fine where lands are worn
_BINS = len(_EDGES) + 1
_NONE = 1e-9  # draws: of a cell that holds none
_SMOOTH = 4.0  # effective draws that the draws around a bin stand for beside its own
_BESIDE = 2  # readings before, beside which the value of one is worked out
_NAMED = 3.0  # times as much does a land cost that the customer's complaint names: choice of this project
_USUAL_SHARE = 0.02  # of the pump's flow, where no limit is set
_TELLS = 0.1  # of a probability, by which evidence moves it at least: choice of this project
PUMP_WORN = 0.5  # growth of its slip from which on a pump is called worn: choice of this project
WORTH = 0.02  # wrong decisions that a reading spares at least, to be worth its time: choice of this project

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
    value: float  # wrong decisions that its reading spares on average


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
        without = partial(weigh, card, diagnosis.limits, beside, diagnosis.projections)
        self.weighed: Weighed = check.weighed if check else kept_with(diagnosis, "weighed", "", without, most=1)
        self.read = {each.cell.tap for each in check.readings} if check else set()

    @property
    def evidence(self) -> Evidence:
        lands = sorted(self._lands(), key=lambda each: (-each.loss, -each.probability))
        circuits = sorted(self._circuits(), key=lambda each: (-each.probability, -each.loss))
        pump, worth = self._pump(), readings_by_value(self.diagnosis, NEXT)
        return Evidence(
            lands=tuple(lands),
            circuits=tuple(circuits),
            pump=pump,
            seals=tuple(sorted(self._seals(), key=lambda each: -each.probability)),
            next=tuple(each for each in worth if each.value >= WORTH),
            effective_samples=min((each.effective for each in self.weighed.told), default=0.0),
            assumptions=self.assumptions,
            thin=None if self._tells(lands, circuits, pump) else _THIN,
        )

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
        """Return how usual a clearance is of a used unit: what a measurement cannot tell stays as it was assumed.

        It is the density of lands that were new anywhere in their range, some of them worn since.
        """
        u, (low, high), now = self.assumptions, land.mounting_range, np.asarray(clearance, float)
        spread = max(u.mounting_clearance, 0.5 * (land.mounting_tolerance or 0.0), _FINEST)
        low, high, mean = low - spread, high + spread, max(u.land_wear, _FINEST)
        new = (low <= now) & (now <= high)
        gone = np.exp(-(now - np.clip(now, low, high)) / mean) - np.exp(-np.maximum(now - low, 0.0) / mean)
        density = (1.0 - u.worn_lands) * new + u.worn_lands * gone
        return density if density.any() else np.ones_like(density)

    def worn(self, told: Told, key: LandKey) -> np.ndarray:
        """Return in which draws a land is worn: its clearance has grown past its first limit for wear."""
        now, new, steps = told.now[key], told.new[key], self.diagnosis.limits.wear
        if steps is None:
            return np.asarray(now > new)
        level, fraction = steps.levels[0]
        return np.asarray(now - new >= np.maximum(fraction * new, steps.at_least.get(level, 0.0)))

    def explains(self, key: LandKey, *, read: bool = False) -> float:
        """Return what a land costs the pressure that loses most by it, of all or of those that gauges read [Pa]."""
        taps = {LINE if tap == LINE_TAP else tap for tap in self.read}
        shown = (each for tap, each in self._pressure if tap in taps or not (read and taps))
        return max((each.get(key, 0.0) for each in shown), default=0.0)

    def costs(self, told: Told, key: LandKey) -> np.ndarray:
        """Return what the wear of a land costs the unit in each draw, in first limits: as its clearance cubed grows."""
        growth = np.maximum(told.now[key] ** 3 - told.new[key] ** 3, 0.0)
        mean = float(growth.mean())
        return growth * (self.cost(key) / mean) if mean > 0.0 else growth

    def cost(self, key: LandKey) -> float:
        """Return what a land costs the unit on average, in first limits; one that the complaint names costs more."""
        share, of_pairs = self._flow.get(key, 0.0), self.diagnosis.limits.pair_share
        limit = of_pairs.levels[0][1] if of_pairs is not None else _USUAL_SHARE
        complaint = self.diagnosis.complaint
        named = complaint is not None and key in complaint.lands
        return (self.explains(key) / self._limit + share / limit) * (_NAMED if named else 1.0)

    @cached_property
    def _pressure(self) -> list[tuple[str, dict[LandKey, float]]]:
        return [(section, _of_lands(lost.split.lands)) for (section, _), lost in self.weighed.lost.items()]

    @cached_property
    def _flow(self) -> dict[LandKey, float]:
        """Return what the wear of each land adds to the demand on the pump, as a share of its flow."""
        at = next((each for each in self.weighed.lost if each[0] == LINE), None)
        if at is None:
            return {}
        point = at[1]
        supplied = point.engine_speed, point.main_pressure, point.temperature
        capacity = float(self.diagnosis.model.pump_capacity(*supplied)) or math.inf
        return {key: each / capacity for key, each in _of_lands(self.weighed.lost[at].split.flows_of_lands).items()}

    @property
    def error_of_a_reading(self) -> float:
        """Return the standard uncertainty of a clearance that is read once, in one direction [m]."""
        card = self.diagnosis.gauge_card
        variance = sum(each.calibration**2 + (each.repeatability or 0.0) ** 2 for each in vars(card.gauges).values())
        return 0.5 * math.sqrt(variance + card.assumptions.unseen_ovality**2)

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
        for (section, _), lost in self.weighed.lost.items():
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
    """Return which lands to measure, in one direction and once, one after the other: the one worth most first.

    Parameters
    ----------
    diagnosis
        whose lands that nobody measured are asked for.
    most
        as many at the most. One of less than `WORTH` is not worth its time.
    """
    finder, found = _Finder(diagnosis), list[NextReading]()
    parts = [_Part(finder, told) for told in finder.weighed.told]
    while len(found) < most:
        worth = [(value, finder.cost(key), key, part) for part in parts for key, value in part.values.items()]
        if not worth:
            break
        value, _, key, part = max(worth, key=lambda each: each[:3])
        found.append(NextReading(diagnosis.controller.land(*key), value))
        part.read(key)
    return tuple(found)


def quick_pass(diagnosis: Diagnosis) -> Plan | None:
    """Return the plan of the few lands that tell most, the one whose reading is worth most first; None without one."""
    lands = [each.land.key for each in readings_by_value(diagnosis, QUICK_LANDS)]
    return Plan.quick(lands) if lands else None


class _Part:
    """Lands that are weighed together, while one after the other of them is read."""

    def __init__(self, finder: _Finder, told: Told) -> None:
        self._keys = [key for key in told.now if key in finder.diagnosis.open_lands]
        size, error = told.slip.size, finder.error_of_a_reading
        costs = [np.minimum(finder.costs(told, key), 1.0) for key in self._keys]
        self._costs = np.array(costs, float).reshape(-1, size)
        self._bins = {
            key: _binned(told.now[key] + error * np.random.default_rng(number).standard_normal(size))
            for number, key in enumerate(self._keys)
        }
        self._one_circuit, self._read = told.one_circuit, list[LandKey]()
        alike = next(iter(told.now.values()), np.zeros(size))  # of the same draw, chosen more than once
        self._fold = np.unique(alike, return_inverse=True)[1] % 2 == 0
        self._counts = min(told.effective / size, 1.0)  # of a draw

    @property
    def values(self) -> dict[LandKey, float]:
        """Return what the reading of each land spares."""
        return {key: self._value(key) for key in self._keys if key not in self._read}

    def read(self, key: LandKey) -> None:
        """Take a land as read."""
        self._read.append(key)

    def _value(self, key: LandKey) -> float:
        """Return what the reading of a land spares beside those of the lands read before that tell most of the same."""
        place = self._keys.index(key)
        own = self._costs[place]
        costs = self._costs if self._one_circuit else self._costs[[place]]  # elsewhere it tells of itself alone
        telling = sorted(self._read, key=lambda each: -abs(_covariance(self._bins[each], own)))[:_BESIDE]
        cells = np.zeros((1, own.size), int)
        for each in (*telling, key):
            cells = np.vstack([cells, cells[-1] * _BINS + self._bins[each]])
        return self._lost(costs, cells[:-1]) - self._lost(costs, cells)

    def _lost(self, costs: np.ndarray, cells: np.ndarray) -> float:
        """Return what decisions cost on average, each taken by what lands cost in a cell of other draws than it meets.

        ``cells`` of shape (levels, draws), each level finer than the one before it; where few draws are in a cell, what
        a land costs in it is near what it costs in the cell around it.
        """
        lost = 0.0
        for fold in (True, False):
            taken, met = self._fold == fold, self._fold != fold
            around = np.zeros((len(costs), 1))
            for level, cell in enumerate(cells):
                around = np.repeat(around, _BINS if level else 1, axis=1)
                draws = self._counts * np.bincount(cell[taken], minlength=around.shape[1])
                sums = [self._counts * np.bincount(cell[taken], each[taken], around.shape[1]) for each in costs]
                smooth = _SMOOTH if level else 0.0
                around = (np.array(sums) + smooth * around) / np.maximum(draws + smooth, _NONE)
            lost += float(np.sum(np.where(around[:, cells[-1][met]] > 0.5, 1.0 - costs[:, met], costs[:, met])))
        return lost / self._fold.size


def _binned(shown: np.ndarray) -> np.ndarray:
    """Return the bin of what a reading shows in each draw."""
    return np.searchsorted(np.quantile(shown, _EDGES), shown)


def _covariance(bins: np.ndarray, cost: np.ndarray) -> float:
    """Return the covariance of a reading's bin with what a land costs."""
    return float(np.mean(bins * cost) - np.mean(bins) * np.mean(cost))
