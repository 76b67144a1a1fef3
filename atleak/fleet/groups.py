"""Compare groups of units, such as batches or suppliers: rates of verdicts, and the wear of every land."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations

import numpy as np
import pandas as pd

from atleak.equations.proportions import newcombe_interval
from atleak.errors import Message
from atleak.fleet.label_shuffles import SHUFFLES, MeanDifferences, Pairing, mean_differences
from atleak.fleet.lands import Lands
from atleak.fleet.summed import (
    MOST_COMPARED,
    MOST_IN_PAIRS,
    Difference,
    Group,
    GroupComparison,
    RateDifference,
    WearDifference,
)
from atleak.fleet.verdict_counts import groups_of
from atleak.fleet.wear import class_width, classes_of
from atleak.sentence import Sentence, some
from atleak.spreads import ENOUGH_UNITS, Rate, rate, spread
from atleak.unit_systems import Quantity
from atleak.verdicts import FLAGGED, Verdict
from atleak.workshop_units import PERCENT

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
    difference that shuffled labels give decides (`atleak.fleet.label_shuffles`).

    Parameters
    ----------
    units
        a row for each, with the ``label`` that it states.
    lands
        of the same rows.
    shuffles
        of the labels.
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
