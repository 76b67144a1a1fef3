"""Do for one unit what a worker does: diagnose it, and make the rows that are kept of it."""

from __future__ import annotations

from typing import Any


def evaluate(unit: Any, *, tries: int = 1) -> Any:
    """Return the rows of a unit: those of its diagnosis, or the one row that says why there is none; never raises.

    Parameters
    ----------
    unit
        a `FleetUnit`.
    tries
        how many times it was tried, this time with it.
    """
    raise NotImplementedError
