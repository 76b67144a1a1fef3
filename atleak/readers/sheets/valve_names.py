"""Which valve a sheet means by a name of its own: by the sizes measured under it, and by words, numbers and letters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np

from atleak.common.errors import ReadingsError
from atleak.readers.sheets.controller_names import UNITS, ControllerNames, Sizes
from atleak.readers.sheets.words import plain

_WITHIN = 0.2e-3  # [m] of the nominal diameter: no land wears further
_TOKEN = re.compile(r"\d+|[^\W\d_]+")
_NEVER = -1e6
_OF_LANDS = 0.25  # of a word, at most: how many of the lands were measured tells less than a word does
_SURE = 0.3  # of a word, by which another pairing agrees less
_ALIKE, _SHORTEST = 5, 3  # letters with which two words begin that are one, or fewer of one that is cut short


def valves_by_name(names: ControllerNames, measured: Mapping[str, Mapping[str, Iterable[float]]]) -> dict[str, str]:
    """Return the component of each name of a sheet's own that can be no other, whatever the other names mean.

    Names and components are paired so that sizes fit and words agree most; a pair is sure where every other way to pair
    them agrees less.

    Parameters
    ----------
    measured
        by name and by plane, "" where none is said, the diameters under it, in any unit.
    """
    sizes, own = Sizes(names.controller), [name for name in measured if names.component(name) is None]
    taken = {names.component(name) for name in measured}
    free = [component for component in names.with_lands if component not in taken]
    if not own or len(own) > len(free):
        return {}
    agree = np.full((len(own), len(free)), _NEVER)
    for (row, name), (column, component) in product(enumerate(own), enumerate(free)):
        if (lands := _fits(measured[name], component, names, sizes)) is not None:
            agree[row, column] = max(_agreement(name, spelled) for spelled in names.spelled(component)) + lands
    best, pairs = _best(agree)
    found = {}
    for row, column in pairs:
        without = agree.copy()
        without[row, column] = _NEVER
        if agree[row, column] > _NEVER and best - _best(without)[0] >= _SURE:
            found[own[row]] = free[column]
    return found


def _best(agree: np.ndarray) -> tuple[float, list[tuple[int, int]]]:
    from scipy.optimize import linear_sum_assignment  # of sheets with names of their own alone

    rows, columns = linear_sum_assignment(agree, maximize=True)
    return float(agree[rows, columns].sum()), list(zip(rows.tolist(), columns.tolist(), strict=True))


def _fits(
    measured: Mapping[str, Iterable[float]], component: str, names: ControllerNames, sizes: Sizes
) -> float | None:
    """Return how much of a component was measured, if all that was has the size of its lands; None where it has not."""
    planes = [plane for land in names.controller.lands_of(component) for plane in land.planes]
    for said, diameters in measured.items():
        try:
            at = [names.plane(component, said)] if said else planes
        except ReadingsError:
            return None
        near = (any(sizes.near_plane(value, UNITS, component, plane, _WITHIN) for plane in at) for value in diameters)
        if not all(near):
            return None
    known = len(measured) if "" not in measured else sum(1 for _ in measured[""]) / 2
    return _OF_LANDS * min(known / len(planes), 1.0)


def _agreement(name: str, spelled: str) -> float:
    """Return how many words, numbers and letters of two names agree, less those numbers and letters that do not."""
    short = {plain(token) for token in _TOKEN.findall(name) if token.isupper()}  # UD, TCC
    one, other = (_TOKEN.findall(plain(text)) for text in (name, spelled))
    exact = [{token for token in tokens if token.isdigit() or len(token) == 1} for tokens in (one, other)]
    words = [[token for token in tokens if token not in exact[at]] for at, tokens in enumerate((one, other))]
    alike = sum(any(_alike(a, b) for b in words[1]) or (a in short and _is_short_for(a, words[1])) for a in words[0])
    return alike + 2.0 * len(exact[0] & exact[1]) - 2.0 * len(exact[0] ^ exact[1]) * bool(exact[1] and exact[0])


def _alike(one: str, other: str) -> bool:
    """Return whether one word is the other cut short, or both begin with the same letters, as in two languages."""
    least = min(len(one), len(other))
    return least >= _SHORTEST and one[: min(least, _ALIKE)] == other[: min(least, _ALIKE)]


def _is_short_for(letters: str, words: Sequence[str]) -> bool:
    """Return whether letters are the initials of words, or stand in one from its beginning: UD, of underdrive."""
    if letters in "".join(word[0] for word in words):
        return len(letters) > 1
    inside = (iter(word) for word in words if word.startswith(letters[0]))
    return any(all(letter in signs for letter in letters) for signs in inside)
