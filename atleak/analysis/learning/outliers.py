"""Name the pairs and the units among several that are no new ones: wider than the others, or tighter.

The pairs of one land, from several units, scatter about the clearance of their type. How far is pooled over all lands,
because one process makes them, unless the lands themselves show that they differ. Each pair is compared with the other
units' pairs of its land by Student's t with itself left out, and every unit with the others as a whole. Whoever is left
out does not count for the next round; the first round starts from medians, so that a worn unit cannot hide itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from atleak.equations.statistics import normal_quantile

OutlierTable = NDArray[np.float64]  # one row for each unit, one column for each land; NaN where nothing was measured
Mask = NDArray[np.bool_]

MOST_DEGREES = 1e5  # of freedom, from where on Student's distribution is the normal one to five digits
# All choices of this project; the tests say how often they are right.
FALSE_ALARM = 0.05  # chance that any pair or unit of a set is left out though all are new
FEWEST_DEGREES = 5.0  # of freedom of the pooled spread; with fewer nothing is called an outlier
UNITS_TO_NAME_ONE = 3  # with fewer a pair can be left out, but no unit as a whole
UNITS_TO_JUDGE_A_SHIFT = 4  # with fewer a unit that is wider in all lands alike is not told from another zero
LANDS_TO_SHOW_A_SHIFT = 5  # of a unit with fewer nothing is taken as common to all its lands
WIDE_LANDS_OF_A_WORN_UNIT = 2  # from so many on a unit is no new one, and none of its pairs counts
_KINDS_OF_TEST = 3  # among which the chance of a false alarm is shared: pairs, shifts, sums over a unit
_CUT = 2.5  # spreads from the median, beyond which a pair waits for the second round
_CUT_VARIANCE = 0.911  # of a normal distribution cut there, relative to the whole one
_CUT_SHIFT = 3.0
_ROUNDS = 12
_MANY_DEGREES = 20.0  # of freedom, from which on a sum over a unit's lands is trusted
_FEWEST_PRIOR = 4.5  # degrees of freedom: under 4 the variance of an F distribution does not exist
_SAME = 1e-12  # [m]


class WhyUnit(StrEnum):
    """Why a whole unit is left out."""

    WIDE_THROUGHOUT = "wide_throughout"  # all its lands by the same amount
    TIGHT_THROUGHOUT = "tight_throughout"
    WIDE_LANDS = "wide_lands"  # several of its lands
    WIDER_TOGETHER = "wider_together"  # its wider lands together, though none by itself


@dataclass(frozen=True)
class Outliers:
    """What is left out, and against what it was judged."""

    wide: Mask  # pairs wider than those of the other units, of units left out too
    tight: Mask
    units: Mapping[int, WhyUnit]  # left out as a whole, by row
    kept: Mask  # the pairs that count
    shifts: NDArray[np.float64]  # [m] of each unit: by how much all its lands are wider than the others'
    expected: OutlierTable  # [m] what each pair was expected to be, from the others; NaN where there are none


def find_outliers(clearances: OutlierTable, own: OutlierTable) -> Outliers:
    """Return which pairs and units are left out, by their radial clearances [m].

    The tables have a row for each unit and a column for each land, NaN where none was measured. ``own`` is the standard
    uncertainty [m] that the units do not share: no spread is taken as smaller than it.
    """
    measured = ~np.isnan(clearances)
    least = _typical(own, measured)
    kept, units = _start(clearances, measured, least)
    fit = _compared(clearances, measured, kept & units[:, None], least, cut=True)
    seen: set[tuple[bytes, bytes]] = set()
    why: dict[int, WhyUnit] = {}
    for _ in range(_ROUNDS):
        if fit.degrees < FEWEST_DEGREES:
            kept, units, why = measured, np.ones(len(clearances), dtype=bool), {}
            fit = _compared(clearances, measured, kept, least)
            break
        kept = measured & (fit.probability > FALSE_ALARM / _KINDS_OF_TEST / measured.sum())
        why = _units_left_out(fit, measured, kept, units)
        units = np.array([row not in why for row in range(len(clearances))])
        state = kept.tobytes(), units.tobytes()
        if state in seen:
            break
        seen.add(state)
        fit = _compared(clearances, measured, kept & units[:, None], least)
    away = measured & ~kept
    return Outliers(
        wide=away & (fit.deviation > 0.0),
        tight=away & (fit.deviation < 0.0),
        units=MappingProxyType(why),
        kept=kept & units[:, None],
        shifts=fit.shifts,
        expected=np.where(measured, clearances - fit.deviation, np.nan),
    )


class _Fit(NamedTuple):
    """Every pair beside the others that are kept."""

    shifts: NDArray[np.float64]  # [m] of units
    shift_error: NDArray[np.float64]  # [m] standard uncertainty that it has from the scatter of its lands
    deviation: OutlierTable  # [m] of each pair from what the others make expected; NaN where there are none
    deviate: OutlierTable  # the same in normal deviates: as improbable as Student's t is
    probability: OutlierTable  # of one as far off by chance; 1 where there is nothing to compare
    degrees: float  # of freedom of the pooled spread


def _typical(own: OutlierTable, measured: Mask) -> float:
    known = own[measured]
    return float(np.sqrt(np.mean(known * known))) if known.size else 0.0


def _start(clearances: OutlierTable, measured: Mask, least: float) -> tuple[Mask, Mask]:
    """Return the pairs and units to start from: those near the medians of lands and units.

    Medians are swept out of rows and columns in turn (Tukey's median polish); the spread is that of the differences
    between the units' pairs of one land, by their lower quartile (Rousseeuw and Croux, J. Am. Stat. Assoc. 88 (1993)
    1273), which a worn unit can hardly change. Of two units only the wider can be worn.
    """
    count = len(clearances)
    enough = _show_shift(measured)
    shifts = np.zeros(count)
    for _ in range(_ROUNDS):
        centres = _nan_median(clearances - shifts[:, None], axis=0)
        moved = _nan_median(clearances - centres, axis=1)
        moved = np.where(enough, moved, np.nan)
        moved = np.nan_to_num(moved - _nan_median(moved, axis=0))
        done = np.max(np.abs(moved - shifts), initial=0.0) < _SAME
        shifts = moved
        if done:
            break
    level = clearances - shifts[:, None]
    apart = np.abs(level[:, None, :] - level[None, :, :])[np.triu_indices(count, 1)]
    apart = apart[~np.isnan(apart)]
    few = count < UNITS_TO_JUDGE_A_SHIFT
    part = 0.5 if few else 0.25
    scale = math.sqrt(2.0) * float(normal_quantile(0.5 + 0.5 * part))
    spread = max(float(np.quantile(apart, part)) / scale if apart.size else 0.0, least)
    residual = level - _nan_median(level, axis=0)
    kept = measured & ((residual if count < UNITS_TO_NAME_ONE else np.abs(residual)) <= _CUT * spread)
    for land in np.flatnonzero(measured.any(axis=0) & ~kept.any(axis=0)):
        kept[np.nanargmin(np.abs(residual[:, land])), land] = True
    units = np.ones(count, dtype=bool)
    if not few:
        usual = float(np.median(np.abs(shifts))) / float(normal_quantile(0.75))
        by_lands = spread * np.sqrt(0.5 * math.pi / np.maximum(measured.sum(axis=1), 1))
        units = np.abs(shifts) <= _CUT_SHIFT * np.maximum(usual, by_lands)
    return kept, units


def _compared(clearances: OutlierTable, measured: Mask, kept: Mask, least: float, *, cut: bool = False) -> _Fit:
    """Compare every pair with those that are kept, itself left out; ``cut`` where these were cut at 2.5 spreads."""
    shifts, centres = _two_way(clearances, kept)
    for row in np.flatnonzero(~kept.any(axis=1) & _show_shift(measured)):
        shifts[row] = np.nan_to_num(_nan_median(clearances[row] - centres, axis=0))
    level = clearances - shifts[:, None]
    here = np.where(kept, level, 0.0)
    pairs = kept.sum(axis=0)
    lands = int((pairs > 0).sum())
    free = np.maximum(pairs - 1, 0)
    all_free = max(float(kept.sum()) - lands - max(float(_show_shift(kept).sum()) - 1.0, 0.0), 0.0)
    degrees = free * all_free / max(free.sum(), 1)  # of each land, less its part of what the shifts take
    squares = np.where(kept, (level - centres) ** 2, 0.0).sum(axis=0)
    pooled = max(squares.sum() / max(all_free, 1.0) / (_CUT_VARIANCE if cut else 1.0), least**2)

    others = pairs - kept
    with np.errstate(divide="ignore", invalid="ignore"):
        expected = np.where(others > 0, (here.sum(axis=0) - here) / others, np.nan)
    deviation = level - expected
    factor = 1.0 + 1.0 / np.maximum(others, 1)
    taken = np.where(kept, np.nan_to_num(deviation) ** 2 / factor, 0.0)  # of the squares, with the pair itself
    prior = prior_degrees(squares, degrees)
    if math.isinf(prior):
        left = np.maximum(all_free - kept, 1.0)
        variance = np.maximum(squares.sum() - taken, 0.0) / left / (_CUT_VARIANCE if cut else 1.0)
    else:
        own_degrees = np.maximum(degrees - kept, 0.0)
        left = prior + own_degrees
        variance = (prior * pooled + np.maximum(squares - taken, 0.0)) / left
    t = deviation / np.sqrt(np.maximum(variance, least**2) * factor)
    comparable = measured & ~np.isnan(t)
    tail = np.where(comparable, _student_tail(np.where(comparable, np.abs(t), 0.0), np.maximum(left, 1.0)), 0.5)
    deviate = np.where(comparable, np.sign(t) * normal_quantile(1.0 - np.clip(tail, 1e-15, 0.5)), 0.0)
    # of two the wider is the worn one
    probability = np.where(t > 0.0, tail, 1.0) if len(clearances) < UNITS_TO_NAME_ONE else 2.0 * tail
    return _Fit(
        shifts,
        np.sqrt(pooled / np.maximum(measured.sum(axis=1), 1)),
        deviation,
        deviate,
        np.where(comparable, probability, 1.0),
        all_free,
    )


def _units_left_out(fit: _Fit, measured: Mask, kept: Mask, units: Mask) -> dict[int, WhyUnit]:
    """Return the units that are left out as a whole; none where fewer than two would stay."""
    count = len(measured)
    if count < UNITS_TO_NAME_ONE:
        return {}
    limit = FALSE_ALARM / _KINDS_OF_TEST / count
    wide = (measured & ~kept & (fit.deviation > 0.0)).sum(axis=1)
    shifted = _show_shift(measured)
    why: dict[int, WhyUnit] = {}
    for row in map(int, np.flatnonzero(measured.any(axis=1))):
        over = np.maximum(fit.deviate[row][kept[row]], 0.0)
        if shifted[row] and _shift_probability(fit, shifted & units, row) <= limit:
            why[row] = WhyUnit.WIDE_THROUGHOUT if fit.shifts[row] > 0.0 else WhyUnit.TIGHT_THROUGHOUT
        elif wide[row] >= WIDE_LANDS_OF_A_WORN_UNIT:
            why[row] = WhyUnit.WIDE_LANDS
        elif fit.degrees >= _MANY_DEGREES and _one_sided_squares_tail(float(over @ over), over.size) <= limit:
            why[row] = WhyUnit.WIDER_TOGETHER
    return why if count - len(why) >= 2 else {}


def _student_tail(deviate: Any, degrees_of_freedom: Any) -> Any:
    """Return the probability that a variable of Student's distribution is above a deviate."""
    from scipy.special import stdtr  # dear to import, and seldom needed

    return stdtr(np.minimum(degrees_of_freedom, MOST_DEGREES), -deviate)


def _one_sided_squares_tail(value: float, number: int) -> float:
    """Return the probability that Σ max(zᵢ, 0)² of so many independent standard normal zᵢ is above a value.

    Each zᵢ counts with probability ½: ``Σ_k C(n, k) 2⁻ⁿ P(χ²_k > q)`` (A. Shapiro, Biometrika 72 (1985) 133-144).
    """
    from scipy.special import bdtr, chdtrc

    counting = np.arange(1, number + 1)
    weights = bdtr(counting, number, 0.5) - bdtr(counting - 1, number, 0.5)
    return float(weights @ chdtrc(counting, value))


def _shift_probability(fit: _Fit, units: Mask, row: int) -> float:
    """Return how probable it is by chance that all lands of a unit are off together by so much."""
    others = fit.shifts[units & (np.arange(len(units)) != row)]
    if others.size < UNITS_TO_JUDGE_A_SHIFT - 1:
        return 1.0
    spread = max(float(np.std(others, ddof=1)), float(fit.shift_error[row]))
    t = (fit.shifts[row] - float(others.mean())) / (spread * math.sqrt(1.0 + 1.0 / others.size))
    return 2.0 * float(_student_tail(abs(t), others.size - 1))


def _show_shift(pairs: Mask) -> Mask:
    """Tell which units have enough pairs to show what all their lands have in common."""
    return pairs.sum(axis=1) >= LANDS_TO_SHOW_A_SHIFT


def _two_way(clearances: OutlierTable, kept: Mask) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the shifts of units and the means of lands [m] that fit the kept pairs best by least squares."""
    values = np.where(kept, clearances, 0.0)
    of_land, of_unit = np.maximum(kept.sum(axis=0), 1), np.maximum(kept.sum(axis=1), 1)
    there = _show_shift(kept)
    shifts = np.zeros(len(clearances))
    centres = np.zeros(clearances.shape[1])
    for _ in range(100):
        centres = np.where(kept, values - shifts[:, None], 0.0).sum(axis=0) / of_land
        moved = np.where(kept, values - centres, 0.0).sum(axis=1) / of_unit
        moved = np.where(there, moved - (moved[there].mean() if there.any() else 0.0), 0.0)
        done = np.max(np.abs(moved - shifts), initial=0.0) < _SAME
        shifts = moved
        if done:
            break
    return shifts, np.where(kept.any(axis=0), centres, np.nan)


def prior_degrees(squares: NDArray[np.float64], degrees: NDArray[np.float64]) -> float:
    """Return how many degrees of freedom the pooled spread is worth beside a land's own; infinite where lands agree.

    The variances of lands that scatter alike differ by chance alone: their squared coefficient of variation is 2/ν.
    What is beyond it is taken as that of an F distribution, whose second number of degrees of freedom follows from it
    (moments; the idea of moderated variances: Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) 3).

    Parameters
    ----------
    squares
        sum of squares of each land [m²].
    degrees
        its degrees of freedom.
    """
    of = degrees > 0.0
    if of.sum() < 3 or squares[of].sum() <= 0.0:
        return math.inf
    variances, free = squares[of] / degrees[of], float(degrees[of].mean())
    scatter = float(np.var(variances, ddof=1)) / float(np.mean(variances)) ** 2
    if scatter * free <= 2.0:
        return math.inf
    return max((4.0 * scatter * free + 2.0 * free - 4.0) / (scatter * free - 2.0), _FEWEST_PRIOR)


def _nan_median(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Return the median of what is measured; NaN, without a warning, where nothing is."""
    known = ~np.isnan(values)
    filled = np.where(known.any(axis=axis, keepdims=True), values, 0.0)
    median = np.nanmedian(filled, axis=axis)
    return np.where(known.any(axis=axis), median, np.nan)
