"""Say what is likely worn before anything is opened, and what to measure next, from all that was shown of a unit.

A part is worn in a draw of the unit where its clearance has grown past its first limit for wear. What is said of it are
shares of the draws, weighed by gauges, log, flows and plugs (`atleak.diagnosis.uncertainty.weighing`).

A reading is worth the expected fall of what is lost by wrong decisions, a worn land left or a sound one opened, when
it becomes known with its own uncertainty: the draws fall into bins of it, and in each bin every land is repaired where
that is the likelier to be right. Readings are chosen one after the other, each beside those before it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Land
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_check import Weighed, weigh
from atleak.diagnosis.uncertainty import Assumptions
from atleak.diagnosis.uncertainty.weighing import Lost, Told
from atleak.engine.operation import LINE

NEXT = 3  # lands that are named to be measured next
_ENDS = 0.025, 0.5, 0.975
_BINS = 6  # of a reading, alike likely
_SMOOTH = 8.0  # effective draws that all draws stand for beside those of a bin
_TELLS = 0.1  # of a probability, by which evidence moves it at least: choice of this project
PUMP_WORN = 0.5  # growth of its slip from which on a pump is called worn: choice of this project
_WORTH = 0.02  # wrong decisions that a further reading spares at least: choice of this project

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
    group: int | None  # the lands with this number cannot be told apart; None: by itself
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

    probability: float  # that its slip has grown by half or more
    growth: float  # of its slip, as a fraction, as likely more as less
    low: float
    high: float


@dataclass(frozen=True)
class NextReading:
    """A land to measure next."""

    land: Land
    value: float  # wrong decisions, of worn lands left and sound ones opened, that its reading spares on average


@dataclass(frozen=True)
class Evidence:
    """What is likely worn, the likeliest first."""

    lands: tuple[LandEvidence, ...]
    circuits: tuple[CircuitEvidence, ...]
    pump: PumpEvidence | None  # None of a pump that was measured
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
        check = diagnosis.pressures
        self.weighed: Weighed = (
            check.weighed if check else weigh(card, diagnosis.limits, diagnosis.log, diagnosis.projections)
        )
        self.read = {each.cell.tap for each in check.readings} if check else set()

    @property
    def evidence(self) -> Evidence:
        lands = sorted(self._lands(), key=lambda each: -each.probability)
        circuits = sorted(self._circuits(), key=lambda each: -each.probability)
        return Evidence(
            lands=tuple(lands),
            circuits=tuple(circuits),
            pump=self._pump(),
            seals=tuple(sorted(self._seals(), key=lambda each: -each.probability)),
            next=readings_by_value(self.diagnosis, NEXT),
            effective_samples=min((each.effective for each in self.weighed.told), default=0.0),
            assumptions=self.assumptions,
            thin=None if self._tells(lands, circuits) else _THIN,
        )

    def _lands(self) -> Iterator[LandEvidence]:
        groups = self._groups()
        for told in self.weighed.told:
            for key, now in told.now.items():
                low, middle, high = np.quantile(now, _ENDS).tolist()
                land = self.controller.land(*key)
                measured = key not in self.diagnosis.open_lands
                probability = float(np.mean(worn(self.diagnosis, told, key)))
                yield LandEvidence(land, probability, middle, low, high, groups.get(key), measured)

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

    @property
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
        return steps.levels[0][1] if steps is not None else np.inf

    def _circuits(self) -> Iterator[CircuitEvidence]:
        for section, lost in self._lost.items():
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
        if not self.diagnosis.model.pump_open:
            return None
        slip = self.weighed.told[0].slip
        low, middle, high = np.quantile(slip, _ENDS).tolist()
        return PumpEvidence(float(np.mean(slip >= PUMP_WORN)), middle, low, high)

    def _tells(self, lands: Iterable[LandEvidence], circuits: Iterable[CircuitEvidence]) -> bool:
        """Tell whether anything was measured of a land, or the evidence moves the probability of anything."""
        prior = self.assumptions.worn_lands
        moved = any(each.measured or each.probability > prior + _TELLS for each in lands)
        return moved or bool(self.read) or any(each.probability > 0.5 for each in circuits)


def worn(diagnosis: Diagnosis, told: Told, key: LandKey) -> np.ndarray:
    """Return in which draws a land is worn: its clearance has grown past its first limit for wear."""
    now, new, steps = told.now[key], told.new[key], diagnosis.limits.wear
    if steps is None:
        return np.asarray(now > new)
    level, fraction = steps.levels[0]
    return np.asarray(now - new >= np.maximum(fraction * new, steps.at_least.get(level, 0.0)))


def readings_by_value(diagnosis: Diagnosis, most: int) -> tuple[NextReading, ...]:
    """Return which lands to measure, in one direction and once, one after the other: the one worth most first.

    Parameters
    ----------
    diagnosis
        whose lands that nobody measured are asked for.
    most
        as many at the most; fewer where a further one spares no wrong decision.
    """
    finder, found = _Finder(diagnosis), list[NextReading]()
    parts = [_Part(diagnosis, told) for told in finder.weighed.told]
    while len(found) < most:
        worth = [(part, key, value) for part in parts for key, value in part.values.items()]
        part, key, value = max(worth, key=lambda each: each[2], default=(None, None, 0.0))
        if part is None or key is None or value < _WORTH:
            break
        found.append(NextReading(diagnosis.controller.land(*key), value))
        part.read(key)
    return tuple(found)


class _Part:
    """Lands that are weighed together, while one after the other of them is read."""

    def __init__(self, diagnosis: Diagnosis, told: Told) -> None:
        self._keys = [key for key in told.now if key in diagnosis.open_lands]
        self._worn = np.array([worn(diagnosis, told, key) for key in self._keys], float).reshape(len(self._keys), -1)
        self._shown = {key: _binned(diagnosis, told.now[key], number) for number, key in enumerate(self._keys)}
        self._cells = np.zeros(self._worn.shape[1], int)
        self._counts = min(told.effective / max(self._worn.shape[1], 1), 1.0)  # of a draw

    @property
    def values(self) -> dict[LandKey, float]:
        """Return how many wrong decisions the reading of each land spares."""
        if not self._keys:
            return {}
        before = self._lost(self._cells)
        return {key: before - self._lost(self._cells * _BINS + shown) for key, shown in self._shown.items()}

    def read(self, key: LandKey) -> None:
        """Take a land as read: the draws fall into bins of what it would show."""
        _, self._cells = np.unique(self._cells * _BINS + self._shown.pop(key), return_inverse=True)

    def _lost(self, cells: np.ndarray) -> float:
        """Return how many lands are decided wrongly on average, each by the draws of its cell."""
        counts = self._counts * np.bincount(cells)
        whole = self._worn.mean(axis=1)
        sums = np.array([self._counts * np.bincount(cells, each) for each in self._worn])
        chance = (sums + _SMOOTH * whole[:, None]) / (counts + _SMOOTH)
        return float(np.sum(np.minimum(chance, 1.0 - chance) @ (counts / counts.sum())))


def _binned(diagnosis: Diagnosis, clearance: np.ndarray, seed: int) -> np.ndarray:
    """Return the bin of what a reading of a land would show in each draw."""
    instruments = diagnosis.gauge_card.gauges
    variance = sum(each.calibration**2 + (each.repeatability or 0.0) ** 2 for each in vars(instruments).values())
    error = 0.5 * np.sqrt(variance + diagnosis.gauge_card.assumptions.unseen_ovality**2)
    shown = clearance + error * np.random.default_rng(seed).standard_normal(clearance.size)
    return np.searchsorted(np.quantile(shown, np.arange(1, _BINS) / _BINS), shown)
