"""List the instants of a road test that people read, the sustained extremes first."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from atleak.engine.extremes import Extremes, Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.sentence import Sentence
from atleak.uncertainty import UnitUncertainty
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


_HEADINGS = {
    "time_s": Sentence("time [s]"),
    "leakage_dm3_min": Sentence("leakage [dm³/min]"),
    "leakage_low_dm3_min": Sentence("leakage from"),
    "leakage_high_dm3_min": Sentence("leakage to"),
    "pump_capacity_dm3_min": Sentence("pump capacity [dm³/min]"),
    "share_percent": Sentence("share [%]"),
    "share_low_percent": Sentence("share from"),
    "share_high_percent": Sentence("share to"),
}


def instant_rows(
    road: RoadLeakage, uncertainty: UnitUncertainty | None, say: Wording | None = None
) -> list[dict[str, Any]]:
    """Return one row for every instant, in workshop units; columns without any value are left out.

    Parameters
    ----------
    say
        the words of a language; English unless given.
    """
    say, rows = say or wording("en"), road_instants(road)
    records = [instant_record(row.instant, uncertainty) for row in rows]
    known = {name: heading for name, heading in _HEADINGS.items() if any(each[name] is not None for each in records)}
    return [
        {Sentence("instant"): row.label(say), **{heading: record[name] for name, heading in known.items()}}
        for row, record in zip(rows, records, strict=True)
    ]


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None or not math.isfinite(value) else value * factor
