"""Weigh draws of a unit by what gauges, a jug and plugs showed of it, and say what is known then of its parts.

Each draw counts the more the nearer what it would show comes to what was shown:

    w ∝ prior / proposal · exp(−½ rᵀ C⁻¹ r),        r reading less expectation, C the gauges' covariance.

Where few draws carry the weight, more are drawn around them, with the first ones kept beside (a defensive mixture:
Owen & Zhou, J. Am. Stat. Assoc. 95, 2000; all draws share the weights of the mixture: Veach & Guibas, SIGGRAPH 1995).
Circuits act on one another by the line alone, and by what feeds them: each is weighed by what tells of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.missing import Split
from atleak.diagnosis.uncertainty.posterior import LEFT, OF_A_SPLIT, PosteriorUnit, Proposal, UnitDraws
from atleak.engine.operation import LINE

_DRAWS = 8_192  # of units before any gauge is read, and half as many at a time around what was found
ENOUGH = 200  # effective draws
SURELY = 4.0  # standard uncertainties by which a gauge shows more than there can be: choice of this project
_ROUNDS = 4  # of drawing around what was found
_READ_OFF = 0.1  # of a named gauge's variance: what differs from reading to reading
_UNNAMED = 0.7  # the same of gauges that nobody named: which was where is not known
_LEAST = 0.25  # of the highest pressure shown: a gauge errs no less than it does there
_FINEST = 1e3  # [Pa] that a gauge tells apart
_COUNTS = 1e-6  # of the largest weight, from which on a draw is looked at again
_TOLD = 4_096  # draws of equal weight that are kept of every part


@dataclass(frozen=True)
class Shown:
    """One gauge reading as evidence: where it was taken, what it showed, and how its gauge may err."""

    point: OperatingPoint
    tap: str  # "p_g" of the line, or the id of a circuit
    pressure: float  # [Pa]
    gauge: str = ""  # its name; readings of one gauge share its error


@dataclass(frozen=True)
class Lost:
    """What a circuit has lost against the same unit new at one operating point, as far as all gauges tell."""

    draws: np.ndarray  # [Pa]
    expected: np.ndarray  # [Pa] that the circuit holds
    weights: np.ndarray  # their sum is 1
    effective: float  # number of draws that the weights are worth
    highest: float  # [Pa] that it holds in 999 of 1000 units, before any gauge is read
    split: Split  # of all that it lost with the line, by draws of equal weight
    contradicted: frozenset[tuple[str, OperatingPoint]] = frozenset()  # taps that showed what none of the draws expects

    @property
    def standard_uncertainty(self) -> float:
        """Return the standard deviation of the loss [Pa]."""
        mean = float(self.weights @ self.draws)
        return math.sqrt(max(float(self.weights @ (self.draws - mean) ** 2), 0.0))

    def probability_over(self, limit: float) -> float:
        """Return the probability that the loss has reached a limit [Pa]."""
        return float(np.sum(self.weights, where=self.draws >= limit))

    def quantile(self, probability: float, of: np.ndarray | None = None) -> float:
        """Return a quantile of the loss, or of another quantity of the draws."""
        values = self.draws if of is None else of
        order = np.argsort(values)
        return float(
            values[order[np.searchsorted(np.cumsum(self.weights[order]), probability).clip(0, len(order) - 1)]]
        )


@dataclass(frozen=True)
class FlowShown:
    """One flow in a jug as evidence of what the line leaves to it."""

    point: OperatingPoint
    others: float  # [m³/s] that is fed behind the line's regulator beside it
    log_likelihood: Callable[[np.ndarray], np.ndarray]  # of the reading, given what is left for it [m³/s] in each draw


@dataclass(frozen=True, eq=False)
class Told:
    """What the evidence tells of parts that are weighed together, in draws of equal weight, each of shape (draws,).

    Clearances are of single precision: a diagnosis keeps them.
    """

    now: Mapping[LandKey, np.ndarray]  # [m] clearance of each land
    new: Mapping[LandKey, np.ndarray]  # [m] when it was new
    slip: np.ndarray  # growth of the pump's slip as a fraction; 0 of one that was measured
    effective: float  # number of draws that the weights are worth
    one_circuit: bool  # they belong to circuits that gauges read; else to the line, or to what nobody read


class Posterior:
    """A unit once gauges were read, and what else is known of it: every part weighed by what tells of it."""

    def __init__(
        self,
        unit: PosteriorUnit,
        shown: Sequence[Shown],
        flows: Sequence[FlowShown] = (),
        draws: int = _DRAWS,
    ) -> None:
        """Take a unit and what was shown of it.

        Parameters
        ----------
        unit
            before any gauge is read, at all the operating points of ``shown`` and ``flows``.
        shown
            gauge readings. Those of a circuit, of what feeds it and of the line tell of it; what others show acts on
            it by the line alone, which was read.
        flows
            what a jug showed.
        draws
            a power of two.
        """
        self.unit, self.shown, self.flows = unit, shown, flows
        self._prior = _Round(unit.prior, *unit.before(draws))
        self._weighed: dict[frozenset[str], _WeighedDraws] = {}

    def lost(self, section: str, point: OperatingPoint) -> Lost:
        """Return what a circuit has lost against new.

        Parameters
        ----------
        section
            the circuit by its id; or the line, as p_g, whose regulator then counts as new too: it loses what that lets
            it fall, and not what it is set to.
        point
            in whose gear it is applied.
        """
        return self._by(frozenset() if section == LINE else frozenset([section])).lost(section, point)

    def told(self) -> tuple[Told, ...]:
        """Return what is known of every land, those that are weighed together in one; the line's and the pump first."""
        gauged = {each.tap for each in self.shown if each.tap != LINE}
        sections: dict[LandKey, set[str | None]] = {}
        for gap in self.unit.model.controller.gaps:
            sections.setdefault(gap.key, set()).update((gap.high.section, gap.low.section))
        sets: dict[frozenset[str], list[LandKey]] = {frozenset(): []}
        for key in self.unit.lands:
            of_land = sections.get(key, set())
            own = of_land & gauged or {each for each in gauged if self.unit.fed_from(each) & of_land}
            sets.setdefault(self._apart(filter(None, own)), []).append(key)
        return tuple(self._by(each).told(lands) for each, lands in sets.items())

    def _apart(self, circuits: Iterable[str]) -> frozenset[str]:
        """Return circuits without those that another of them, or the line, is weighed with anyhow."""
        own = set(circuits)
        with_others = set().union(*(self.unit.fed_from(each) - {each} for each in own), self.unit.followed)
        return frozenset(own - with_others)

    def _by(self, circuits: frozenset[str]) -> _WeighedDraws:
        """Return the draws as weighed by what tells of some circuits, of none by what tells of the line."""
        if circuits not in self._weighed:
            made = _WeighedDraws(self.unit, circuits, self.shown, self.flows)
            # what the line tells serves every circuit
            made.add(*(self._by(frozenset()).rounds if circuits and made.by_line else [self._prior]))
            for _ in range(_ROUNDS):
                if made.effective < ENOUGH:
                    made.add_around()
            self._weighed[circuits] = made
        return self._weighed[circuits]


class _Round(NamedTuple):
    """Draws of units from one proposal, with what they hold where that was asked for."""

    proposal: Proposal
    drawn: UnitDraws
    held: dict[OperatingPoint, Mapping[str, np.ndarray]]

    @property
    def draws(self) -> int:
        return int(self.drawn.wear.shape[1])


class _WeighedDraws:
    """Draws of a unit from one proposal after the other, weighed by what tells of some circuits, or of the line."""

    def __init__(
        self, unit: PosteriorUnit, circuits: frozenset[str], shown: Sequence[Shown], flows: Sequence[FlowShown]
    ) -> None:
        self.unit, self.circuits, self.flows, self.near = unit, circuits, flows, unit.near(circuits)
        feeds = zip(unit.quantities, self.near[0], strict=True)
        taps = {*circuits, LINE, *(each[1] for each, acts in feeds if acts and each[0] == "feed")}
        self.by_line = any(each.tap == LINE for each in shown) or bool(flows)
        # where nobody read the line, it shows in every circuit
        self.evidence = [each for each in shown if each.tap in taps or not (circuits or self.by_line)]
        self._likely = _likelihood(self.evidence, unit.assumptions.main_pressure)
        self.rounds: list[_Round] = []
        self._expected = np.empty((len(self.evidence), 0))
        self._by_flows = np.empty(0)

    def add(self, *rounds: _Round) -> None:
        """Add rounds of draws, that from the prior first, and weigh all anew."""
        for each in rounds:
            expected = [self._held(each, one.point, one.tap) for one in self.evidence]
            self._expected = np.concatenate([self._expected, np.reshape(expected, (-1, each.draws))], axis=1)
            likely = [
                one.log_likelihood(np.maximum(self._held(each, one.point, LEFT) - one.others, 0.0))
                for one in self.flows
            ]
            self._by_flows = np.concatenate([self._by_flows, sum(likely, np.zeros(each.draws))])
        self.rounds += rounds
        self._deviates = np.concatenate([each.drawn.deviates for each in self.rounds], axis=1)
        self._wear = np.concatenate([each.drawn.wear for each in self.rounds], axis=1)
        sizes = np.array([each.draws for each in self.rounds])
        prior = self.rounds[0].proposal
        logs = np.array([each.proposal.log_ratio(prior, self._deviates, self._wear) for each in self.rounds])
        mixture = np.logaddexp.reduce(logs + np.log(sizes / sum(sizes))[:, None], axis=0)
        self._log_weight = self._likely(self._expected) + self._by_flows - mixture

    def _held(self, each: _Round, point: OperatingPoint, tap: str) -> np.ndarray:
        """Return what a tap holds in each draw of a round [Pa]."""
        if point not in each.held:
            each.held[point] = self.unit.pressures(each.drawn, point)
        return np.broadcast_to(each.held[point][tap], each.draws)

    def add_around(self) -> None:
        """Add half as many draws as there were at first, around those that carry the weight."""
        around = self.unit.prior.around(self._deviates, self._wear, _flattened(self._log_weight), self.near)
        self.add(_Round(around, self.unit.draw(around, self.rounds[0].draws // 2, len(self.rounds)), {}))

    @property
    def effective(self) -> float:
        """Return how many draws of equal weight they are worth."""
        weights = _normed(self._log_weight)
        return 1.0 / float(np.sum(weights * weights))

    @property
    def contradicted(self) -> frozenset[tuple[str, OperatingPoint]]:
        """Return where a gauge showed surely more, or less, than the units do that agree best with all gauges."""
        weights, errs = _flattened(self._log_weight), _errs(self.evidence, self.unit.assumptions.main_pressure)
        found = set()
        for each, expected, err in zip(self.evidence, self._expected, errs, strict=True):
            order = np.argsort(expected)
            ends = np.searchsorted(np.cumsum(weights[order]), (0.025, 0.975)).clip(0, len(order) - 1)
            low, high = expected[order][ends]
            if not low - SURELY * err <= each.pressure <= high + SURELY * err:
                found.add((each.tap, each.point))
        return frozenset(found)

    def equally_likely(self, draws: int) -> UnitDraws:
        """Return draws of equal weight out of all of them."""
        places = np.searchsorted(np.cumsum(_flattened(self._log_weight)), (np.arange(draws) + 0.5) / draws)
        return self._chosen(np.minimum(places, self._wear.shape[1] - 1))

    def _chosen(self, places: np.ndarray) -> UnitDraws:
        """Return some of all draws, by their places."""
        return UnitDraws.chosen([each.drawn for each in self.rounds], places)

    def told(self, lands: Sequence[LandKey]) -> Told:
        """Return what is known of lands and of the pump."""
        drawn = self.equally_likely(_TOLD)
        clearances = self.unit.clearances(drawn)
        now, new = ({key: clearances[key][place].astype(np.float32) for key in lands} for place in (0, 1))
        return Told(now, new, self.unit.growth_of_slip(drawn), self.effective, bool(self.circuits))

    def lost(self, circuit: str, point: OperatingPoint) -> Lost:
        """Return what a circuit has lost against new at an operating point."""
        weights = _flattened(self._log_weight)
        kept = np.flatnonzero(weights > _COUNTS * weights.max())
        weights, drawn = weights[kept] / weights[kept].sum(), self._chosen(kept)
        sound = replace(drawn, wear=np.zeros_like(drawn.wear)) if circuit == LINE else drawn
        now = np.concatenate([self._held(each, point, circuit) for each in self.rounds])[kept]
        new = np.broadcast_to(self.unit.pressures(sound, point, new=True)[circuit], kept.shape)
        highest = float(np.quantile(self._held(self.rounds[0], point, circuit), 0.999))
        by_cause = self.unit.split(self.equally_likely(OF_A_SPLIT), point, circuit)
        return Lost(new - now, now, weights, self.effective, highest, by_cause, self.contradicted)


def _normed(log_weight: np.ndarray) -> np.ndarray:
    weights = np.exp(log_weight - log_weight.max())
    return np.asarray(weights / weights.sum())


def _flattened(log_weight: np.ndarray) -> np.ndarray:
    """Return weights flattened until they are worth some draws: one that carries all would draw all others to it."""
    for power in 0.7 ** np.arange(20):
        weights = _normed(power * log_weight)
        if float(np.sum(weights * weights)) * ENOUGH <= 4.0:
            break
    return weights


def _likelihood(shown: Sequence[Shown], relative: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return what gives the logarithm of the likelihood of the readings from what is expected, shape (readings, draws).

    A gauge that is named errs alike in all that it showed, but for what is read off it. Of others nobody knows which
    was where: part of their variance is shared by the readings of one tap.
    """
    showed, errs = np.array([each.pressure for each in shown]), _errs(shown, relative)
    own = np.array([_READ_OFF if each.gauge else _UNNAMED for each in shown])
    alike = np.array([[_one_gauge(a, b) for b in shown] for a in shown])
    covariance = np.outer(errs, errs) * (np.diag(own) + alike * np.sqrt(np.outer(1.0 - own, 1.0 - own)))
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def log_likelihood(expected: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.sum((whiten @ (showed[:, None] - expected)) ** 2, axis=0))

    return log_likelihood


def _errs(shown: Sequence[Shown], relative: float) -> np.ndarray:
    """Return the standard uncertainty of every reading [Pa]."""
    showed = np.array([each.pressure for each in shown])
    return np.maximum(relative * np.maximum(showed, _LEAST * showed.max(initial=0.0)), _FINEST)


def _one_gauge(a: Shown, b: Shown) -> bool:
    return a.gauge == b.gauge and (bool(a.gauge) or a.tap == b.tap)
