"""List the instants of a road test that people read, the sustained extremes first."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from atleak.engine.extremes import Extremes, Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.uncertainty import UnitUncertainty
from atleak.views.table import Column, Table
from atleak.wording import Wording
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


def instant_record(instant: Instant, uncertainty: UnitUncertainty | None) -> dict[str, Any]:
    """Return an instant with its 95 % intervals in workshop units, as records hold it; None where a value is not known.

    Without readings nothing was measured and no interval is known.
    """
    interval = uncertainty.instants.get(instant) if uncertainty else None
    leakage = interval.leakage_interval if interval else (None, None)
    share = (interval.share_interval if interval else None) or (None, None)
    return {
        "time_s": instant.time,
        "leakage_dm3_min": instant.leakage * DM3_MIN,
        "leakage_low_dm3_min": _scaled(leakage[0], DM3_MIN),
        "leakage_high_dm3_min": _scaled(leakage[1], DM3_MIN),
        "pump_capacity_dm3_min": _scaled(instant.pump_capacity, DM3_MIN),
        "share_percent": _scaled(instant.share, PERCENT),
        "share_low_percent": _scaled(share[0], PERCENT),
        "share_high_percent": _scaled(share[1], PERCENT),
    }


def instant_table(road: RoadLeakage, uncertainty: UnitUncertainty | None, say: Wording) -> Table:
    """Return a row for every instant; columns without any value are left out."""
    columns = (
        Column("instant", width=190),
        Column("instant_time", "time", 2, of="time_s"),
        Column("instant_leakage", "flow", 2, of="leakage_dm3_min"),
        Column("instant_leakage_low", "flow", 2, of="leakage_low_dm3_min"),
        Column("instant_leakage_high", "flow", 2, of="leakage_high_dm3_min"),
        Column("instant_pump", "flow", 1, of="pump_capacity_dm3_min"),
        Column("instant_share", "percent", 2, of="share_percent"),
        Column("instant_share_low", "percent", 1, of="share_low_percent"),
        Column("instant_share_high", "percent", 1, of="share_high_percent"),
    )
    rows = [{"instant": row.label(say), **instant_record(row.instant, uncertainty)} for row in road_instants(road)]
    return Table("instants", columns, rows, say).filled


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None or not math.isfinite(value) else value * factor
