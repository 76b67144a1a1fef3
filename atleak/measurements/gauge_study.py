"""The readings of a gauge study: every person measures every part the same number of times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from atleak.common.errors import InputError, Message

FEWEST = 2  # parts, people and readings of each: with one of them a component of variance cannot be estimated


class GaugeStudyError(InputError):
    """A workbook of repeated readings that cannot be used."""


@dataclass(frozen=True)
class StudyReadings:
    """Repeated readings [m], by part, operator and trial; a `ValueError` refuses what does not fit or is too few."""

    parts: tuple[str, ...]
    operators: tuple[str, ...]
    values: np.ndarray  # [m], of shape (parts, operators, trials)
    file: str
    sha256: str = ""
    messages: tuple[Message, ...] = ()

    def __post_init__(self) -> None:
        if self.values.shape[:2] != (len(self.parts), len(self.operators)):
            raise ValueError("a row for each part and a column for each operator")
        if min(self.values.shape) < FEWEST:
            raise ValueError(f"at least {FEWEST} parts, {FEWEST} operators and {FEWEST} readings of each")

    @property
    def trials(self) -> int:
        """Return how often every operator measured every part."""
        return int(self.values.shape[2])

    @cached_property
    def step(self) -> float | None:
        """Return the smallest step between two different readings [m]; None where all are the same.

        A gauge's resolution is this or smaller: readings of enough parts show it.
        """
        steps = np.diff(np.unique(np.round(self.values, 9)))  # nanometres: below them stand errors of rounding
        return float(steps.min()) if steps.size else None
