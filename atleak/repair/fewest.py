"""Find the fewest choices whose gains together meet several needs."""

from __future__ import annotations

from collections.abc import Sequence

_NODES = 20_000  # of the search; beyond it a few more than the fewest may be named


def fewest(gains: Sequence[Sequence[float]], needs: Sequence[float]) -> list[int]:
    """Return the numbers of the fewest rows whose gains add up to every need.

    Parameters
    ----------
    gains
        one row for each choice, with its gain towards each need.
    needs
        each within what all gains together give.

    Notes
    -----
    The search looks for one row, then two, and so on, the most useful rows first, and leaves out what the largest
    gains that are left could not complete. After twenty thousand steps it gives up and names rows that suffice: each
    time the most useful one, without those that the later ones made needless.

    Examples
    --------
    >>> fewest([[1.0, 0.0], [0.0, 1.0], [0.6, 0.6], [0.3, 0.3]], [1.0, 1.0])
    [0, 1]
    """
    if not needs:
        return []
    order = sorted(range(len(gains)), key=lambda row: -_use(gains[row], needs))
    enough = _enough(order, gains, needs)
    most = [_largest_sums([gains[row][need] for row in order]) for need in range(len(needs))]
    steps = 0

    def search(start: int, count: int, left: list[float]) -> list[int] | None:
        nonlocal steps
        if max(left) <= 0.0:
            return []
        if count == 0:
            return None
        for place in range(start, len(order) - count + 1):
            steps += 1
            if steps > _NODES or any(most[need][place][count] < each for need, each in enumerate(left)):
                return None
            row = order[place]
            rest = search(place + 1, count - 1, [each - gain for each, gain in zip(left, gains[row], strict=True)])
            if rest is not None:
                return [row, *rest]
        return None

    for count in range(1, len(enough)):
        found = search(0, count, list(needs))
        if found is not None:
            return sorted(found)
    return sorted(enough)


def _use(gains: Sequence[float], needs: Sequence[float]) -> float:
    """Return how much of the needs a row serves; a need that is met asks for nothing."""
    return sum(min(gain, need) / need for gain, need in zip(gains, needs, strict=True) if need > 0.0)


def _enough(order: Sequence[int], gains: Sequence[Sequence[float]], needs: Sequence[float]) -> list[int]:
    """Return rows that meet every need, the most useful one each time, without those that are not needed."""
    chosen: list[int] = []
    left = list(needs)
    while max(left) > 0.0 and len(chosen) < len(order):  # floating point may leave a need open with every row chosen
        rest = [row for row in order if row not in chosen]
        uses = [_use(gains[row], left) for row in rest]
        best = rest[uses.index(max(uses))]
        chosen.append(best)
        left = [each - gain for each, gain in zip(left, gains[best], strict=True)]
    for row in reversed(chosen.copy()):
        spare = [each + gain for each, gain in zip(left, gains[row], strict=True)]
        if max(spare) <= 0.0:
            chosen.remove(row)
            left = spare
    return chosen


def _largest_sums(values: Sequence[float]) -> list[list[float]]:
    """Return, for every place, the sums of the 0, 1, 2 … largest values from there on."""
    table = []
    for start in range(len(values) + 1):
        sums = [0.0]
        for value in sorted(values[start:], reverse=True):
            sums.append(sums[-1] + value)
        table.append(sums)
    return table
