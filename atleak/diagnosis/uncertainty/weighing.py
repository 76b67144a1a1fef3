"""Weigh draws of a unit by what gauges, a jug and plugs showed of it, and say what is known then of its parts.

Each draw counts the more the nearer what it would show comes to what was shown:

    w ∝ L / Σ a_k L_k / Z_k,        L = exp(−½ rᵀ C⁻¹ r),  r reading less expectation, C the gauges' covariance.

Where few draws carry the weight, more are drawn around them. Near the readings pressures are nearly linear in what
leaks and in what is shared by all: L_k is L by a linear fit to draws at hand, C grown by what is not linear. From
prior · L_k, the integral of which is Z_k, the next draws come: parts by annealing (Del Moral, Doucet & Jasra, J. R.
Stat. Soc. B 68, 2006), shared quantities, which are normal given the parts, at once. Where a line falls below what it
is set to its slopes jump: each fit is of draws that fall alike, of those first that the draws so far cover worst. All
rounds, a_k of all draws each, share one mixture; those of the prior, with L_0 = Z_0 = 1, are its first (defensive: Owen
& Zhou, J. Am. Stat. Assoc. 95, 2000; mixture: Veach & Guibas, SIGGRAPH 1995).
Circuits act on one another by the line alone, and by what feeds them: each is weighed by what tells of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.missing import Split
from atleak.diagnosis.uncertainty.draws import stream_of
from atleak.diagnosis.uncertainty.posterior import FALLS, LEFT, OF_A_SPLIT, Effects, PosteriorUnit, UnitDraws
from atleak.diagnosis.uncertainty.propagation import SEED
from atleak.engine.operation import LINE

DRAWS = 8_192  # of units before any gauge is read
ENOUGH = 200  # effective draws
_FAR = 5.0  # variances of the gauges: by so much on average expectation is off where nothing that fits is found yet
SURELY = 4.0  # standard uncertainties by which a gauge shows more than there can be: choice of this project
_AROUND, _ROUNDS = 1_024, 4  # draws around what was found, so often
_FITTED = 400  # effective draws to which pressures are fitted
_FEW = 10  # effective draws that tell which are covered worst
_NOT_LINEAR = 1.2  # of the variance about the fit: choice of this project
_ACTS = 0.05  # standard uncertainties: a part that moves all readings by less is not drawn by itself
_SWEEPS = 2  # over the parts at each step of annealing
_KEPT = 0.4  # of the draws: so many are effective at each step
_SLOPES = 1e-3  # of a quantity's variance, by which slopes are held near 0
_READ_OFF = 0.1  # of a named gauge's variance: what differs from reading to reading
_UNNAMED = 0.7  # the same of gauges that nobody named: which was where is not known
_LEAST = 0.25  # of the highest pressure shown: a gauge errs no less than it does there
_FINEST = 1e3  # [Pa] that a gauge tells apart
_FITS, _COUNTS = 1e-3, 1e-6  # of the largest weight, from which on a draw is fitted to, and looked at again
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
        draws: int | None = None,
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
            a power of two; `DRAWS` unless given.
        """
        self.unit, self.shown, self.flows = unit, shown, flows
        drawn, held = unit.before(draws or DRAWS)
        self._prior = _Round(drawn, held, unit.effects(drawn))
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
        return self._by(frozenset({section} - {LINE})).lost(section, point)

    def contradicted(self, section: str) -> frozenset[tuple[str, OperatingPoint]]:
        """Return taps that tell of a section and showed what none of the draws expects, and where."""
        return self._by(frozenset({section} - {LINE})).contradicted

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
                if made.effective < ENOUGH or made.misfit > _FAR:
                    made.add_around(self._prior)
            self._weighed[circuits] = made
        return self._weighed[circuits]


class _Round(NamedTuple):
    """Draws of units of one kind, with what they hold where that was asked for."""

    drawn: UnitDraws
    held: dict[OperatingPoint, Mapping[str, np.ndarray]]
    effects: Effects
    linear: _Linear | None = None  # as which pressures were taken; None of the prior
    log_whole: float = 0.0  # of the integral of prior · likelihood, pressures taken so

    @property
    def draws(self) -> int:
        return int(self.drawn.wear.shape[1])

    def log_density(self, rows: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density from which it is drawn, over that of the prior."""
        return np.zeros(rows.shape[1]) if self.linear is None else self.linear.log_likelihood(rows) - self.log_whole


@dataclass(frozen=True)
class _Linear:
    """Readings as linear in the effects of what is drawn."""

    apart: np.ndarray  # what was shown, less the constant [Pa]
    shared: np.ndarray  # slopes, shape (readings, shared)
    parts: np.ndarray  # slopes, shape (readings, parts)
    covariance: np.ndarray  # of the gauges, and of what is not linear [Pa²]

    @classmethod
    def fitted(cls, showed: np.ndarray, covariance: np.ndarray, *draws: np.ndarray, shared: int) -> _Linear:
        """Fit what is expected to the effects: ``draws`` are the rows of these, what is expected, and weights."""
        counts = draws[-1] > _FITS * draws[-1].max()
        rows, expected, weights = (each[..., counts] for each in draws)
        weights = weights / weights.sum()
        middle, mean = rows @ weights, expected @ weights
        rows, expected = rows - middle[:, None], expected - mean[:, None]
        square = (rows * weights) @ rows.T
        held = square + np.diag(_SLOPES * rows.var(axis=1) + 1e-12)
        slopes = np.linalg.solve(held, (rows * weights) @ expected.T).T
        rest = expected - slopes @ rows
        free = 1.0 - float(np.trace(np.linalg.solve(held, square)) * (weights @ weights))  # of the degrees of freedom
        curved = covariance + _NOT_LINEAR / max(free, 0.1) * (rest * weights) @ rest.T
        return cls(showed - mean + slopes @ middle, slopes[:, :shared], slopes[:, shared:], curved)

    def log_likelihood(self, rows: np.ndarray) -> np.ndarray:
        left = self.apart[:, None] - np.concatenate([self.shared, self.parts], axis=1) @ rows
        return np.asarray(-0.5 * np.sum((_whitening(self.covariance) @ left) ** 2, axis=0))

    def drawn(
        self, start: Effects, alone: Sequence[int], stream: np.random.Generator
    ) -> tuple[np.ndarray, dict[int, np.ndarray], np.ndarray, float]:
        """Draw units by annealing: from the prior's draws, with more and more of the likelihood.

        Returns
        -------
        tuple
            from which place of ``start`` each unit is, from which those of its parts are that move the readings, its
            shared deviates, and the logarithm of the integral of prior · likelihood.
        """
        whiten = _whitening(self.covariance + self.shared @ self.shared.T)  # the readings given the parts
        slopes, whole = whiten @ self.parts, start.positions * start.parts
        left = (whiten @ self.apart)[:, None] - slopes @ whole
        acts = np.linalg.norm(slopes, axis=0) * np.std(whole, axis=1) > _ACTS
        places = np.arange(whole.shape[1])
        own = {row: places for row in alone if acts[row]}
        power, log_whole = 0.0, 0.5 * float(np.log(np.linalg.det(whiten @ self.covariance @ whiten.T)))
        while power < 1.0:
            half = -0.5 * np.sum(left * left, axis=0)
            for step in (1.0 - power) * 0.7 ** np.arange(40):
                weights = _normed(step * half)
                if float(weights @ weights) * _KEPT * len(places) <= 1.0:
                    break
            power += step
            log_whole += float(step * half.max() + np.log(np.mean(np.exp(step * (half - half.max())))))
            chosen = _equally(weights, _AROUND, stream.random())
            left, places, own = left[:, chosen], places[chosen], {row: each[chosen] for row, each in own.items()}
            for row in [*own] * _SWEEPS:
                other, along = stream.integers(0, whole.shape[1], _AROUND), slopes[:, row]
                change = start.positions[row, places] * (start.parts[row, other] - start.parts[row, own[row]])
                worse = change * (change * (along @ along) - 2.0 * (along @ left))
                taken = np.log(stream.random(_AROUND)) < -0.5 * power * worse
                own[row] = np.where(taken, other, own[row])
                left = left - np.outer(along, np.where(taken, change, 0.0))
        gain = (whiten @ self.shared).T
        spread = np.linalg.cholesky(np.eye(len(gain)) - gain @ gain.T)
        return places, own, gain @ left + spread @ stream.standard_normal((len(gain), _AROUND)), log_whole


class _WeighedDraws:
    """Draws of a unit from one round after the other, weighed by what tells of some circuits, or of the line."""

    def __init__(
        self, unit: PosteriorUnit, circuits: frozenset[str], shown: Sequence[Shown], flows: Sequence[FlowShown]
    ) -> None:
        self.unit, self.circuits, self.flows = unit, circuits, flows
        taps = {LINE, *unit.followed.union(*map(unit.fed_from, circuits))}
        self.by_line = any(each.tap == LINE for each in shown) or bool(flows)
        # where nobody read the line, it shows in every circuit
        self.evidence = [each for each in shown if each.tap in taps or not (circuits or self.by_line)]
        self._covariance = _covariance(self.evidence, unit.assumptions.main_pressure)
        self._showed = np.array([each.pressure for each in self.evidence])
        self.rounds: list[_Round] = []
        self._expected = np.empty((len(self.evidence), 0))
        self._log_likely = self._falls = np.empty(0)

    def add(self, *rounds: _Round) -> None:
        """Add rounds of draws, that from the prior first, and weigh all anew."""
        for each in rounds:
            expected = np.reshape([self._held(each, one.point, one.tap) for one in self.evidence], (-1, each.draws))
            apart = _whitening(self._covariance) @ (self._showed[:, None] - expected)
            likely = -0.5 * np.sum(apart**2, axis=0)
            for one in self.flows:
                likely += one.log_likelihood(np.maximum(self._held(each, one.point, LEFT) - one.others, 0.0))
            falls = np.zeros(each.draws)  # one bit for each operating point
            for number, point in enumerate(dict.fromkeys(one.point for one in self.evidence)):
                falls += 2.0**number * self._held(each, point, FALLS)
            self._expected = np.concatenate([self._expected, expected], axis=1)
            self._log_likely = np.concatenate([self._log_likely, likely])
            self._falls = np.concatenate([self._falls, falls])
        self.rounds += rounds
        self._rows = np.concatenate([each.effects.rows for each in self.rounds], axis=1)
        parts = np.log([each.draws / self._rows.shape[1] for each in self.rounds])
        densities = [part + each.log_density(self._rows) for part, each in zip(parts, self.rounds, strict=True)]
        self._log_weight = self._log_likely - np.logaddexp.reduce(densities, axis=0)

    def _held(self, each: _Round, point: OperatingPoint, tap: str) -> np.ndarray:
        """Return what a tap holds in each draw of a round [Pa]."""
        if point not in each.held:
            each.held[point] = self.unit.pressures(each.drawn, point)
        return np.broadcast_to(each.held[point][tap], each.draws)

    def add_around(self, prior: _Round) -> None:
        """Add draws around those that carry the weight, put together out of those of the prior."""
        weights = _flattened(self._log_weight, _FEW)
        _, way = np.unique(self._falls, return_inverse=True)
        worst = way == np.argmax(np.bincount(way, weights**2))
        weights = _flattened(np.where(worst, self._log_weight, -np.inf), min(_FITTED, 0.5 * np.sum(worst)))
        shared = len(prior.effects.shared)
        linear = _Linear.fitted(self._showed, self._covariance, self._rows, self._expected, weights, shared=shared)
        alone = [row for row, part in enumerate(self.unit.parts) if part is not None]
        places, own, deviates, log_whole = linear.drawn(prior.effects, alone, stream_of(SEED, 17, len(self.rounds)))
        drawn = self.unit.put_together(prior.drawn, places, own, deviates)
        self.add(_Round(drawn, {}, self.unit.effects(drawn), linear, log_whole))

    @property
    def effective(self) -> float:
        """Return how many draws of equal weight they are worth."""
        weights = _normed(self._log_weight)
        return 1.0 / float(np.sum(weights * weights))

    @property
    def misfit(self) -> float:
        """Return by how many variances of the gauges expectation is off in a reading, on average."""
        off = -2.0 * float(_normed(self._log_weight) @ self._log_likely)
        return off / max(len(self.evidence) + len(self.flows), 1)

    @cached_property
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
        return self._chosen(_equally(_flattened(self._log_weight), draws))

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


def _equally(weights: np.ndarray, draws: int, start: float = 0.5) -> np.ndarray:
    """Return places of draws of equal weight."""
    return np.searchsorted(np.cumsum(weights), (np.arange(draws) + start) / draws).clip(0, len(weights) - 1)


def _flattened(log_weight: np.ndarray, worth: float = 0.25 * ENOUGH) -> np.ndarray:
    """Return weights flattened until they are worth some draws: one that carries all would draw all others to it."""
    for power in 0.7 ** np.arange(30):
        weights = _normed(power * log_weight)
        if float(np.sum(weights * weights)) * worth <= 1.0:
            break
    return weights


def _whitening(covariance: np.ndarray) -> np.ndarray:
    """Return what makes errors independent and of unit variance."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _covariance(shown: Sequence[Shown], relative: float) -> np.ndarray:
    """Return the covariance of the readings' errors [Pa²].

    A gauge that is named errs alike in all that it showed, but for what is read off it. Of others nobody knows which
    was where: part of their variance is shared by the readings of one tap.
    """
    errs = _errs(shown, relative)
    own = np.array([_READ_OFF if each.gauge else _UNNAMED for each in shown])
    alike = np.array([[_one_gauge(a, b) for b in shown] for a in shown])
    return np.asarray(np.outer(errs, errs) * (np.diag(own) + alike * np.sqrt(np.outer(1.0 - own, 1.0 - own))))


def _errs(shown: Sequence[Shown], relative: float) -> np.ndarray:
    """Return the standard uncertainty of every reading [Pa]."""
    showed = np.array([each.pressure for each in shown])
    return np.maximum(relative * np.maximum(showed, _LEAST * showed.max(initial=0.0)), _FINEST)


def _one_gauge(a: Shown, b: Shown) -> bool:
    return a.gauge == b.gauge and (bool(a.gauge) or a.tap == b.tap)
