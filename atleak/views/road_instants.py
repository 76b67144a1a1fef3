"""List the instants of a road test that people read, the sustained extremes first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from atleak.engine.extremes import Extremes, Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, PERCENT


@dataclass(frozen=True)
class RoadInstant:
    """One instant as it is shown: ``name`` is its key in records and texts."""

    name: str
    instant: Instant
    leads: bool  # read first, and marked in a printed picture: sustained, or without a sustained counterpart
    after_start: bool = False  # in the first moments after a start of the engine

    def label(self, say: Wording) -> str:
        """Return its name in the reader's language."""
        label = say(f"instants.{self.name}")
        return say("instants.after_start", instant=label) if self.after_start else label


def road_instants(road: RoadLeakage) -> tuple[RoadInstant, ...]:
    """Return the instants of a road test in the order in which people read them."""
    rows = [*_of(road.extremes), RoadInstant("min_leakage", road.min_leakage, True)]
    if road.start is not None:
        rows += [RoadInstant(row.name, row.instant, True, True) for row in _of(road.start) if row.leads]
    return tuple(rows)


def _of(extremes: Extremes) -> Iterable[RoadInstant]:
    """Return the largest leakage and share, sustained where that is known, then as single samples."""
    pairs = (
        ("max_leakage", extremes.max_leakage, extremes.max_leakage_sustained),
        ("max_share", extremes.max_share, extremes.max_share_sustained),
    )
    yield from (RoadInstant(f"{name}_sustained", sustained, True) for name, _, sustained in pairs if sustained)
    yield from (RoadInstant(name, single, sustained is None) for name, single, sustained in pairs if single)


def instant_rows(road: RoadLeakage) -> list[dict[str, Any]]:
    """Return one English row for every instant, in workshop units; None where a value is not known."""
    say = wording("en")
    return [
        {
            "instant": row.label(say),
            "time [s]": row.instant.time,
            "leakage [dm³/min]": row.instant.leakage * DM3_MIN,
            "pump capacity [dm³/min]": _scaled(row.instant.pump_capacity, DM3_MIN),
            "share [%]": _scaled(row.instant.share, PERCENT),
        }
        for row in road_instants(road)
    ]


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
