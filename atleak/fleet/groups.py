"""Compare groups of units, such as batches or suppliers: rates of verdicts, and the wear of every land.

If groups do not differ, the labels of their units could as well have been dealt out otherwise. The labels are shuffled
among the units, a unit with all of its lands, and every shuffle gives every difference over its standard error. How
large the largest of them is in all but a few shuffles is what a difference has to be to be called one: the lands are
many, skewed and wear together, and all of that is in the shuffles as it is in the units (single-step max T: P. H.
Westfall, S. S. Young, Resampling-Based Multiple Testing, Wiley 1993). Each difference goes over its own standard
error, which allows for groups of unequal spread (A. Janssen, Stat. Probab. Lett. 36 (1997) 9-21).
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from atleak.analysis.rates import ENOUGH_UNITS, Rate, rate, spread
from atleak.common.errors import Message
from atleak.common.sentences import Sentence, some
from atleak.common.units import PERCENT, Quantity
from atleak.common.verdicts import FLAGGED, Verdict
from atleak.equations.proportions import newcombe_interval
from atleak.fleet.counts import Lands, class_width, classes_of, groups_of
from atleak.fleet.sums import (
    MOST_COMPARED,
    MOST_IN_PAIRS,
    Difference,
    Group,
    GroupComparison,
    RateDifference,
    WearDifference,
)

SHUFFLES = 999  # choice of this project: ends of intervals are then met within some 2 % of their reach
_AT_ONCE = 4_000_000  # labels that are held at once
_TURNS = 5  # after which next to nothing is left of either

Pairing = tuple[int, int | None]  # numbers of two groups, the second None for all others together
Numbers = NDArray[np.float64]
Labels = NDArray[np.integer]


@dataclass(frozen=True)
class MeanDifferences:
    """First mean minus second of every pairing (row) and land (column); NaN where a side has no unit."""

    value: Numbers
    error: Numbers  # standard error
    enough: NDArray[np.bool_]  # whether each side has enough units for an interval
    own_reach: Numbers  # standard errors that make the 95 % interval of each one alone
    reach_of_all: float  # standard errors that make intervals of all at once; NaN where there are none


def mean_differences(
    values: Numbers,
    groups: Labels,
    pairings: Sequence[Pairing],
    *,
    level: float,
    own_level: float = 0.05,
    classes: Labels | None = None,
    shuffles: int = SHUFFLES,
) -> MeanDifferences:
    """Return the differences of the means of groups, land by land, with what makes their intervals.

    Parameters
    ----------
    values
        a row for each unit, a column for each land; NaN where it was not measured.
    groups
        number of every unit's group, from 0.
    pairings
        which groups are compared.
    level
        probability with which any of all intervals may miss zero where nothing differs.
    own_level
        the same of one interval alone.
    classes
        number of every unit's class, from 0, such as of mileage: units are compared within their class only, and their
        labels shuffled there. The differences of the classes count by n₁n₂/(n₁ + n₂), as in the least squares of a
        difference and a mean for each class; their standard error is that of H. White (Econometrica 48 (1980)
        817-838), which asks for no equal spread.

    Notes
    -----
    The shuffles begin at a number that the values give: the same units have the same intervals, and other units are
    not shuffled alike.
    """
    labels = np.zeros(len(groups), dtype=int) if classes is None else classes
    draw = np.random.default_rng(
        [zlib.crc32(np.ascontiguousarray(each).tobytes()) for each in (values, groups.astype(np.int16))]
    )
    values, scale = _scaled(values)
    sums = _Sums([values, _apart(values, groups, labels)], groups, labels)
    value, error, enough = (each[0] for each in _differences(sums.as_they_are, 0, pairings))
    own_reach, of_all = np.zeros(value.shape), 0.0
    for by_chance in sums.by_chance(pairings, draw, shuffles):
        own_reach = np.maximum(own_reach, _reached(by_chance, own_level))
        of_all = max(of_all, float(_reached(by_chance.reshape(shuffles, -1).max(axis=1, initial=0.0), level)))
    return MeanDifferences(
        value * scale,
        error * scale,
        enough,
        np.where(enough, own_reach, math.nan),
        of_all if enough.any() else math.nan,
    )


def _reached(by_chance: Numbers, level: float) -> Numbers:
    """Return what chance alone goes beyond with no more than this probability, what there is counted as one of them."""
    place = math.ceil((1.0 - level) * (len(by_chance) + 1)) - 1
    return np.partition(by_chance, place, axis=0)[place]


def _scaled(values: Numbers) -> tuple[Numbers, Numbers]:
    """Return the values about the mean of their land, over their scatter; and that."""
    known = ~np.isnan(values)
    number = np.maximum(known.sum(axis=0), 1)
    centred = values - np.where(known, values, 0.0).sum(axis=0) / number
    scatter = np.sqrt(np.where(known, centred**2, 0.0).sum(axis=0) / number)
    scale = np.where(scatter > 0.0, scatter, 1.0)
    return centred / scale, scale


def _apart(values: Numbers, groups: Labels, classes: Labels) -> Numbers:
    """Return what is left of the values without the effects of their classes and groups, found by turns."""
    known = ~np.isnan(values)
    left = np.where(known, values, 0.0)
    several = int(classes.max(initial=0)) > 0
    effects = (classes, groups) if several else (groups,)
    within = [_within(labels, int(labels.max(initial=0)) + 1) for labels in effects]
    numbers = [np.maximum(each @ known, 1.0) for each in within]
    for _ in range(_TURNS if several else 1):
        for each, number in zip(within, numbers, strict=True):
            left -= known * (each.T @ (each @ left / number))
    return np.where(known, left, math.nan)


def _within(labels: Labels, number: int) -> Numbers:
    """Return whether each unit (column) has each of so many labels (row), as 1 or 0."""
    return (labels[..., None, :] == np.arange(number)[:, None]).astype(np.float32)


class _Sums:
    """Number of units, and sum and sum of squares of each kind of values, of every land in every class and group.

    They are laid out as shuffles × classes × groups × (number, then sum and squares of each kind) × lands.
    """

    def __init__(self, kinds: Sequence[Numbers], groups: Labels, classes: Labels) -> None:
        """Take several kinds of values that are known of the same units."""
        known = ~np.isnan(kinds[0])
        filled = [np.where(known, values, 0.0) for values in kinds]
        parts = [known, *(part for values in filled for part in (values, values**2))]
        of_units = np.concatenate(parts, axis=1)
        self._kinds, self._lands = len(kinds), known.shape[1]
        self._groups = int(groups.max(initial=0)) + 1
        rows = [np.flatnonzero(classes == each) for each in np.unique(classes)]
        labels = [groups[here].astype(np.int16) for here in rows]
        self.as_they_are = self._of([each[None, :] for each in labels], [of_units[here] for here in rows])
        self._classes = list(zip(labels, [of_units[here].astype(np.float32) for here in rows], strict=True))

    def by_chance(self, pairings: Sequence[Pairing], draw: np.random.Generator, shuffles: int) -> list[Numbers]:
        """Return, of each kind, differences over their standard errors, of shuffles of the labels within their classes.

        What is of too few units for an interval is zero there, as it is left out of what is found.
        """
        found: list[list[Numbers]] = [[] for _ in range(self._kinds)]
        of_units = [each for _, each in self._classes]
        for labels in self._shuffled(draw, shuffles):
            sums = self._of(labels, of_units)
            for number, kind in enumerate(found):
                value, error, enough = _differences(sums, number, pairings)
                kind.append(np.where(enough, _over(np.abs(value), error), 0.0))
        return [np.concatenate(kind) for kind in found]

    def _shuffled(self, draw: np.random.Generator, shuffles: int) -> Iterator[list[Labels]]:
        """Yield the labels of every class, shuffled so many times, some at a time."""
        units = sum(len(labels) for labels, _ in self._classes)
        at_once = max(1, _AT_ONCE // max(units * self._groups, 1))
        for start in range(0, shuffles, at_once):
            number = min(at_once, shuffles - start)
            yield [draw.permuted(np.tile(labels, (number, 1)), axis=1) for labels, _ in self._classes]

    def _of(self, labels: Sequence[Labels], of_units: Sequence[NDArray[Any]]) -> Numbers:
        number, groups = len(labels[0]), self._groups
        sums = np.empty((number, len(labels), groups, (1 + 2 * self._kinds) * self._lands))
        for place, (mine, values) in enumerate(zip(labels, of_units, strict=True)):
            within = _within(mine, groups - 1).reshape(-1, mine.shape[1]).astype(values.dtype)
            sums[:, place, :-1] = (within @ values).reshape(number, groups - 1, -1)
            sums[:, place, -1] = values.sum(axis=0, dtype=np.float64) - sums[:, place, :-1].sum(axis=1)
        return sums.reshape(number, len(labels), groups, 1 + 2 * self._kinds, self._lands)


def _differences(sums: Numbers, kind: int, pairings: Sequence[Pairing]) -> tuple[Numbers, Numbers, NDArray[np.bool_]]:
    """Return differences, their standard errors and whether there are enough units: shuffles × pairings × lands."""
    of_all = sums.sum(axis=2) if any(second is None for _, second in pairings) else sums
    found = []
    for first, second in pairings:
        of_first = sums[:, :, first]
        found.append(_difference(kind, of_first, of_all - of_first if second is None else sums[:, :, second]))
    value, error, enough = (np.stack(each, axis=1) for each in zip(*found, strict=True))
    return value, error, enough


def _difference(kind: int, first: Numbers, second: Numbers) -> tuple[Numbers, Numbers, NDArray[np.bool_]]:
    """Return the same of one pairing, from the sums of both sides.

    The residuals of a side's units in a class are those about its own mean, and how far that is from the common fit.
    """
    n_1, n_2 = np.rint(first[:, :, 0]), np.rint(second[:, :, 0])
    both = (n_1 > 0.0) & (n_2 > 0.0)
    n_1, n_2 = np.where(both, n_1, 0.0), np.where(both, n_2, 0.0)
    n = np.maximum(n_1 + n_2, 1.0)
    mean_1, squares_1 = _mean_and_squares(kind, first, n_1)
    mean_2, squares_2 = _mean_and_squares(kind, second, n_2)
    weight, apart = n_1 * n_2 / n, np.where(both, mean_1 - mean_2, 0.0)
    weights = weight.sum(axis=1)
    with np.errstate(invalid="ignore"):
        value = (weight * apart).sum(axis=1) / weights
    off = np.where(both, apart - value[:, None], 0.0)
    part_1, part_2 = n_2 / n, n_1 / n  # how far a label is from the mean label of its class
    scatter = part_1**2 * (squares_1 + n_1 * (part_1 * off) ** 2) + part_2**2 * (squares_2 + n_2 * (part_2 * off) ** 2)
    with np.errstate(invalid="ignore"):
        error = np.sqrt(np.where(both, scatter, 0.0).sum(axis=1)) / weights
    enough = (n_1.sum(axis=1) >= ENOUGH_UNITS) & (n_2.sum(axis=1) >= ENOUGH_UNITS)
    return value, error, enough


def _mean_and_squares(kind: int, sums: Numbers, number: Numbers) -> tuple[Numbers, Numbers]:
    """Return the mean of a side, and the sum of its squares about that."""
    mean = sums[:, :, 1 + 2 * kind] / np.maximum(number, 1.0)
    return mean, np.maximum(sums[:, :, 2 + 2 * kind] - number * mean**2, 0.0)


def _over(value: Numbers, error: Numbers) -> Numbers:
    """Return values over their standard errors; 0 for none over none, as of a land that is alike in all units."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(value > 0.0, value / error, 0.0)


_LEVEL = 0.05  # probability that a comparison calls any difference one where nothing differs: choice of this project
_NAMED = 6  # groups that a message lists


@dataclass(frozen=True)
class _Compared:
    """The units of one valve body that state a group, and which groups are compared with which."""

    units: pd.DataFrame
    lands: Lands
    groups: tuple[Group, ...]
    all_groups: tuple[Group, ...]
    pairings: tuple[Pairing, ...]

    @cached_property
    def numbers(self) -> np.ndarray:
        """Return the number of every unit's group; those that are not compared have one together, the last."""
        numbers = pd.Index([group.name for group in self.groups]).get_indexer(pd.Index(self.units["label"]))
        return np.where(numbers < 0, len(self.groups), numbers)

    def names(self, pairing: Pairing) -> tuple[str, str | None]:
        """Return the names of two groups; None for all others together."""
        first, second = pairing
        return self.groups[first].name, None if second is None else self.groups[second].name

    def sides(self, pairing: Pairing) -> tuple[np.ndarray, np.ndarray]:
        """Return which units are on each side."""
        first, second = pairing
        of_first = self.numbers == first
        return of_first, ~of_first if second is None else self.numbers == second


def compared(units: pd.DataFrame, lands: Lands, *, shuffles: int = SHUFFLES) -> GroupComparison | None:
    """Compare the groups of one valve body; None where fewer than two have a unit.

    Rates, wear, and wear at the same mileage share the probability of calling anything a difference where nothing
    differs, in equal parts. Within rates it is shared among all of them (Bonferroni); within wear the largest
    difference that shuffled labels give decides (`atleak.fleet.groups`). Units have a row each, with their ``label``.
    """
    stated = units["label"].notna().to_numpy()
    groups = groups_of(units)
    if len(groups) < 2:
        return None
    most = sorted(sorted(groups, key=lambda group: -group.counts.units)[:MOST_COMPARED], key=lambda group: group.name)
    here = _Compared(units[stated], lands.at(stated), tuple(most), groups, _pairings(len(most)))
    mileages = here.units["mileage_km"].to_numpy(float)
    kinds = 2 + bool(np.isfinite(mileages).any())
    return GroupComparison(
        groups=groups,
        not_stated=int((~stated).sum()),
        verdicts=tuple(_rates(here, _LEVEL / kinds)),
        lands=_wear(here, _LEVEL / kinds, mileages, shuffles),
        messages=tuple(_messages(here, mileages)),
    )


def _pairings(groups: int) -> tuple[Pairing, ...]:
    if groups <= MOST_IN_PAIRS:
        return tuple(combinations(range(groups), 2))
    return tuple((number, None) for number in range(groups))


def _rates(here: _Compared, level: float) -> Iterator[RateDifference]:
    compared = [(pairing, verdict, *_both(here, pairing, verdict)) for pairing in here.pairings for verdict in FLAGGED]
    with_interval = sum(_enough(first.of, second.of) for *_, first, second in compared)
    for pairing, verdict, first, second in compared:
        points = _rate_points(first, second, level / max(with_interval, 1)) if first.of and second.of else None
        yield RateDifference(*here.names(pairing), verdict, first.of, second.of, points)


def _both(here: _Compared, pairing: Pairing, verdict: Verdict) -> tuple[Rate, Rate]:
    """Return the rates of both sides."""
    first, second = pairing
    mine = here.groups[first]
    others = [group for group in here.all_groups if group != mine] if second is None else [here.groups[second]]
    rates = [group.counts.rates[verdict] for group in others]
    return mine.counts.rates[verdict], rate(sum(each.count for each in rates), sum(each.of for each in rates))


def _enough(*units: int) -> bool:
    return min(units) >= ENOUGH_UNITS


def _rate_points(first: Rate, second: Rate, level: float) -> Difference:
    """Return the difference of two rates, of which each has units."""
    value = (first.count / first.of - second.count / second.of) * PERCENT
    if not _enough(first.of, second.of):
        return Difference(value, None, None, None, None)
    counts = second.count, second.of, first.count, first.of
    ends = (newcombe_interval(*counts, coverage) for coverage in (1.0 - _LEVEL, 1.0 - level))
    return Difference(value, *(end * PERCENT for interval in ends for end in interval))


def _wear(here: _Compared, level: float, mileages: np.ndarray, shuffles: int) -> tuple[WearDifference, ...]:
    """Return the differences of every land's wear: those called one first, then those of enough units, by size."""
    wear, numbers = here.lands.wear, here.numbers
    found = partial(mean_differences, pairings=here.pairings, level=level, own_level=_LEVEL, shuffles=shuffles)
    of_all = found(wear, numbers)
    known = np.isfinite(mileages)
    classes = classes_of(mileages[known], class_width(mileages)).astype(int)
    same_mileage = found(wear[known], numbers[known], classes=classes) if known.any() else None
    differences = []
    for place, pairing in enumerate(here.pairings):
        sides = here.sides(pairing)
        for column, key in enumerate(here.lands.keys):
            first, second = (spread(wear[side, column]) for side in sides)
            differences.append(
                WearDifference(
                    *here.names(pairing),
                    key,
                    first,
                    second,
                    mean_points=_mean_points(of_all, place, column),
                    median_points=first.median - second.median if first and second else None,
                    same_mileage_points=_mean_points(same_mileage, place, column),
                )
            )
    return tuple(sorted(differences, key=_clearest_first))


def _mean_points(found: MeanDifferences | None, pairing: int, land: int) -> Difference | None:
    if found is None or np.isnan(found.value[pairing, land]):
        return None
    value, error = float(found.value[pairing, land]), float(found.error[pairing, land])
    own, of_all = float(found.own_reach[pairing, land]), found.reach_of_all
    if not found.enough[pairing, land] or not (math.isfinite(own) and math.isfinite(of_all)):
        return Difference(value, None, None, None, None)
    return Difference(value, value - own * error, value + own * error, value - of_all * error, value + of_all * error)


def _clearest_first(difference: WearDifference) -> tuple[int, float]:
    found = [each for each in (difference.mean_points, difference.same_mileage_points) if each is not None]
    called = [each.differs for each in found]
    order = 0 if any(called) else 1 if False in called else 2 if found else 3
    return order, -abs(found[0].value) if found else 0.0


def _messages(here: _Compared, mileages: np.ndarray) -> Iterator[Message]:
    if len(here.groups) < len(here.all_groups):
        text = Sentence(
            "Only the {number} groups of the most units, of {all}, are each compared with all others.",
            number=len(here.groups),
            all=len(here.all_groups),
        )
        yield Message("info", "many_groups", text)
    few = [group.name for group in here.groups if not _enough(group.counts.judged)]
    if few:
        text = Sentence(
            "{groups}: fewer than {number} units with a verdict, too few for an interval.",
            groups=some(few, _NAMED),
            number=ENOUGH_UNITS,
        )
        yield Message("info", "few_units", text)
    for pairing in here.pairings:
        first, second = here.names(pairing)
        sides = [mileages[side & np.isfinite(mileages)] for side in here.sides(pairing)]
        further = float(np.mean(sides[0]) - np.mean(sides[1])) if _enough(*map(len, sides)) else 0.0
        if abs(further) > _chance(sides[0], sides[1]):
            yield Message("warning", "other_mileage", _driven_further(first, second, further))


def _chance(first: np.ndarray, second: np.ndarray) -> float:
    """Return how far two means are apart by chance, with enough units in both (B. L. Welch, Biometrika 34 (1947))."""
    if not _enough(len(first), len(second)):
        return math.inf
    of_first, of_second = (float(np.var(each, ddof=1)) / len(each) for each in (first, second))
    both = of_first + of_second
    if not both:
        return 0.0
    from scipy.special import stdtrit  # dear to import, and seldom needed

    freedom = both**2 / (of_first**2 / (len(first) - 1) + of_second**2 / (len(second) - 1))
    return float(stdtrit(freedom, 1.0 - 0.5 * _LEVEL)) * math.sqrt(both)


def _driven_further(first: str, second: str | None, further: float) -> Sentence:
    others = Sentence("all others") if second is None else second
    more, less = (first, others) if further > 0.0 else (others, first)
    return Sentence(
        "{more}: driven {distance} {distance.unit} further on average than {less}. What their wear and their verdicts "
        "differ by may be due to that; wear at the same mileage is free of it.",
        more=more,
        less=less,
        distance=Quantity(abs(further), "distance"),
    )
