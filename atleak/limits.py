"""Limit sets: where a value becomes watch, replace or critical, and where each limit comes from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from pydantic import model_validator

from atleak import catalogue
from atleak.catalogue import Entry, Origin, Positive, Strict, Text

Verdict = Literal["ok", "watch", "replace", "critical", "not_measured"]
VERDICTS: tuple[Verdict, ...] = ("not_measured", "ok", "watch", "replace", "critical")  # the worst last
Band = Literal["green", "amber", "red", "critical"]
ROUNDING = 1e-9  # relative: a value that equals its limit but for floating point has reached it


def worst(verdicts: list[Verdict]) -> Verdict:
    """The worst of some verdicts; ``"ok"`` of none.

    >>> worst(["ok", "replace", "watch"])
    'replace'
    """
    return max(verdicts, key=VERDICTS.index, default="ok")


def reaches(value: float, limit: float) -> bool:
    """Whether a value is at or past a limit, rounding of the last digits aside."""
    return value >= limit - ROUNDING * abs(limit)


@dataclass(frozen=True)
class Steps:
    """Rising limits of one quantity, each with the name of what begins there."""

    levels: tuple[tuple[str, float], ...]
    origin: str  # "published", "choice of this project" or "set by the workshop"
    source: str

    def judge(self, value: float, below: str) -> tuple[str, float | None]:
        """The level that a value has reached and its limit; ``below`` and the first limit under all of them.

        >>> Steps((("watch", 10.0), ("replace", 50.0)), "published", "").judge(50.0, "ok")
        ('replace', 50.0)
        """
        reached, limit = below, self.levels[0][1]
        for name, level in self.levels:
            if reaches(value, level):
                reached, limit = name, level
        return reached, limit


@dataclass(frozen=True)
class Limits:
    """A set of limits; a rule that is None is not applied."""

    id: str
    name: str
    source: str
    date: str
    note: str
    wear: Steps | None  # of the fraction (c_r − c_m)/c_m
    clearance: Steps | None  # of the radial clearance [m]
    pair_share: Steps | None  # of leakage / pump capacity of one land, as a fraction
    total_share: Steps  # of the whole controller, as a fraction
    origin: Origin

    def band(self, share: float) -> Band:
        """The band of a total share (a fraction)."""
        return self.total_share.judge(share, "green")[0]  # type: ignore[return-value]

    @property
    def rules(self) -> MappingProxyType[str, Steps]:
        """The rules that are applied, by name."""
        found = {
            "wear": self.wear,
            "radial_clearance": self.clearance,
            "pair_share": self.pair_share,
            "total_share": self.total_share,
        }
        return MappingProxyType({name: steps for name, steps in found.items() if steps is not None})


def load_limits(id_or_path: str | Path) -> Limits:
    """A shipped limit set by id, or a workshop's own by path.

    Raises
    ------
    CatalogueError
        naming file, table, key and value.
    """
    entry, origin = catalogue.read_entry("limits", id_or_path, LimitsFile)
    return Limits(
        id=entry.id,
        name=entry.name,
        source=entry.source,
        date=entry.date,
        note=entry.note,
        wear=_steps(entry.wear_percent, 1e-2),
        clearance=_steps(entry.clearance_um, 1e-6),
        pair_share=_steps(entry.pair_share_percent, 1e-2),
        total_share=_steps(entry.total_share_percent, 1e-2),  # type: ignore[arg-type]
        origin=origin,
    )


def limit_sets() -> list[Limits]:
    """Every shipped limit set."""
    return [load_limits(found) for found in catalogue.catalogue_files("limits")]


def _steps(table: VerdictTable | BandTable | None, unit: float) -> Steps | None:
    if table is None:
        return None
    levels = tuple((name, limit * unit) for name, limit in table.levels().items())
    return Steps(levels, table.origin, table.source)


class _LevelTable(Strict):
    origin: Literal["published", "choice of this project", "set by the workshop"]
    source: Text

    def levels(self) -> dict[str, float]:
        """The limits that are set, in rising order of severity."""
        severity = [name for name in type(self).model_fields if name not in {"origin", "source"}]
        order = ["watch", "amber", "replace", "red", "critical"]
        return {
            name: getattr(self, name) for name in sorted(severity, key=order.index) if getattr(self, name) is not None
        }

    @model_validator(mode="after")
    def _rising(self) -> _LevelTable:
        levels = self.levels()
        if not levels:
            raise ValueError("at least one limit")
        for (low_name, low), (high_name, high) in pairwise(levels.items()):
            if high <= low:
                raise ValueError(f"{high_name} above {low_name} ({low:g})")
        return self


class VerdictTable(_LevelTable):
    watch: Positive | None = None
    replace: Positive | None = None
    critical: Positive | None = None


class BandTable(_LevelTable):
    amber: Positive
    red: Positive
    critical: Positive


class LimitsFile(Entry):
    wear_percent: VerdictTable | None = None
    clearance_um: VerdictTable | None = None
    pair_share_percent: VerdictTable | None = None
    total_share_percent: BandTable

    @model_validator(mode="after")
    def _judges_lands(self) -> LimitsFile:
        if self.wear_percent is None and self.clearance_um is None and self.pair_share_percent is None:
            raise ValueError("at least one rule for a land: wear_percent, clearance_um or pair_share_percent")
        return self
