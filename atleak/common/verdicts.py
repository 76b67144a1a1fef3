"""What a verdict is: the levels of a land, the bands of a total, their order, and which call for attention.

This is the only place that lists them. A level is added here, in `atleak.common.style` and in the language files of
`atleak/texts`; limits files may then name it.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum


class Verdict(StrEnum):
    """How a land, or a whole unit, stands to its limits; the worst last."""

    NOT_MEASURED = "not_measured"
    OK = "ok"
    WATCH = "watch"
    REPLACE = "replace"
    CRITICAL = "critical"

    @property
    def rank(self) -> int:
        """Place in the order of severity; the worst has the highest."""
        return _RANKS[self]

    @property
    def flagged(self) -> bool:
        """Whether a limit was reached."""
        return self.rank > Verdict.OK.rank

    @property
    def calls_for_repair(self) -> bool:
        """Whether it says to replace the part, not only to watch it."""
        return self.rank >= Verdict.REPLACE.rank


_RANKS = {verdict: rank for rank, verdict in enumerate(Verdict)}
VERDICTS: tuple[Verdict, ...] = tuple(Verdict)
FLAGGED: tuple[Verdict, ...] = tuple(verdict for verdict in Verdict if verdict.flagged)


class Band(StrEnum):
    """How the total share of a unit stands to its limits; the worst last."""

    GREEN = "green"
    AMBER = "amber"
    RED = "red"
    CRITICAL = "critical"

    @property
    def verdict(self) -> Verdict:
        """What the band counts as in the verdict of the unit."""
        return _COUNTS_AS[self]


_COUNTS_AS = {
    Band.GREEN: Verdict.OK,
    Band.AMBER: Verdict.WATCH,
    Band.RED: Verdict.REPLACE,
    Band.CRITICAL: Verdict.CRITICAL,
}
BANDS: tuple[Band, ...] = tuple(Band)


def level_named(word: str) -> Verdict | Band | str:
    """Return the verdict or band of this name, as a result that was kept states it; a word that is none as it is.

    >>> level_named("red"), level_named("green_again")
    (<Band.RED: 'red'>, 'green_again')
    """
    return next((level for level in (*VERDICTS, *BANDS) if level == word), word)


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of some verdicts; ``ok`` of none.

    >>> worst([Verdict.OK, Verdict.REPLACE, Verdict.WATCH]).value
    'replace'
    """
    return max(verdicts, key=lambda verdict: verdict.rank, default=Verdict.OK)
