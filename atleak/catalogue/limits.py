"""Describe limit sets: where a value becomes watch, replace or critical, and where each limit comes from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, create_model, model_validator

from atleak.catalogue.entries import Entry, NonEmptyText, Origin, Positive, Strict, catalogue_files, read_entry
from atleak.verdicts import BANDS, FLAGGED, Band, Verdict
from atleak.workshop_units import PERCENT, UM

Level = Verdict | Band
ROUNDING = 1e-9  # relative: a value that equals its limit but for floating point has reached it


def reaches(value: float, limit: float) -> bool:
    """Tell whether a value is at or past a limit, whatever rounding does to its last digits."""
    return value >= limit - ROUNDING * abs(limit)


class LimitOrigin(StrEnum):
    """The authority behind a limit."""

    PUBLISHED = "published"
    PROJECT = "choice of this project"
    WORKSHOP = "set by the workshop"


class RuleKind(StrEnum):
    """The quantities that limits are set for."""

    WEAR = "wear"  # of a land, (c_r − c_m)/c_m
    CLEARANCE = "radial_clearance"  # of a land [m]
    PAIR_SHARE = "pair_share"  # leakage of one land / pump capacity
    TOTAL_SHARE = "total_share"  # leakage of the unit / pump capacity

    @property
    def factor(self) -> float:
        """Return the factor from SI, or a fraction, to the unit that people read."""
        return UM if self is RuleKind.CLEARANCE else PERCENT

    @property
    def unit(self) -> str:
        """Return the unit that people read."""
        return "µm" if self is RuleKind.CLEARANCE else "%"

    @property
    def suffix(self) -> str:
        """Return that unit as the end of a key."""
        return "um" if self is RuleKind.CLEARANCE else "percent"


@dataclass(frozen=True)
class Steps:
    """Rising limits of one quantity, each with the name of the level that begins there."""

    levels: tuple[tuple[Level, float], ...]
    origin: LimitOrigin
    source: str

    def judge(self, value: float, below: Level) -> tuple[Level, float]:
        """Return the level that a value has reached and its limit; ``below`` and the lowest limit under all of them.

        >>> steps = Steps(((Verdict.WATCH, 10.0), (Verdict.REPLACE, 50.0)), LimitOrigin.PUBLISHED, "")
        >>> level, limit = steps.judge(50.0, Verdict.OK)
        >>> level.value, limit
        ('replace', 50.0)
        """
        reached, limit = below, self.levels[0][1]
        for name, level in self.levels:
            if reaches(value, level):
                reached, limit = name, level
        return reached, limit

    def limit_of(self, level: Level) -> float | None:
        """Return the limit at which a level begins; None where the set does not name it."""
        return next((limit for name, limit in self.levels if name == level), None)


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
        """Return the band of a total share (a fraction)."""
        return Band(self.total_share.judge(share, Band.GREEN)[0])

    @property
    def bands(self) -> tuple[tuple[Band, float], ...]:
        """Return the limits of the total share (a fraction), each with the band that begins there."""
        return tuple((Band(level), limit) for level, limit in self.total_share.levels)

    @property
    def rules(self) -> MappingProxyType[RuleKind, Steps]:
        """Return the rules that are applied, by the quantity they limit."""
        stated = {
            RuleKind.WEAR: self.wear,
            RuleKind.CLEARANCE: self.clearance,
            RuleKind.PAIR_SHARE: self.pair_share,
            RuleKind.TOTAL_SHARE: self.total_share,
        }
        return MappingProxyType({kind: steps for kind, steps in stated.items() if steps is not None})


def load_limits(id_or_path: str | Path) -> Limits:
    """Load a shipped limit set by id, or a workshop's own by path.

    Raises
    ------
    CatalogueError
        if the file is missing or wrong; the message names file, table, key and value.
    """
    entry, origin = read_entry("limits", id_or_path, LimitsFile)
    return Limits(
        **entry.heading(),
        wear=_steps(entry.wear_percent, 1e-2),
        clearance=_steps(entry.clearance_um, 1e-6),
        pair_share=_steps(entry.pair_share_percent, 1e-2),
        total_share=entry.total_share_percent.steps(1e-2),
        origin=origin,
    )


def _steps(table: LevelTable | None, unit: float) -> Steps | None:
    return None if table is None else table.steps(unit)


def limit_sets() -> list[Limits]:
    """Return every shipped limit set."""
    return [load_limits(name) for name in catalogue_files("limits")]


class LevelTable(Strict):
    """The limits of one quantity as a file states them."""

    origin: Annotated[LimitOrigin, Field(strict=False)]  # a file writes it as text
    source: NonEmptyText

    def levels(self) -> dict[str, float]:
        """Return the limits that are set, in rising order of severity."""
        named = {name: getattr(self, name) for name in type(self).model_fields if name not in LevelTable.model_fields}
        return {name: limit for name, limit in named.items() if limit is not None}

    def steps(self, unit: float) -> Steps:
        """Return the same limits in SI or as fractions; ``unit`` is the size of one unit of the file."""
        kind = Band if isinstance(self, BandTable) else Verdict
        levels = tuple((kind(name), limit * unit) for name, limit in self.levels().items())
        return Steps(levels, self.origin, self.source)

    @model_validator(mode="after")
    def _rising(self) -> LevelTable:
        levels = self.levels()
        if not levels:
            raise ValueError("at least one limit")
        for (low_name, low), (high_name, high) in pairwise(levels.items()):
            if high <= low:
                raise ValueError(f"{high_name} above {low_name} ({low:g})")
        return self


if TYPE_CHECKING:

    class VerdictTable(LevelTable): ...

    class BandTable(LevelTable): ...

else:
    # a field for every level there is: a land's may be left out, a total's bands are all stated
    _some: dict[str, Any] = {level.value: (Positive | None, None) for level in FLAGGED}
    _every: dict[str, Any] = {level.value: (Positive, ...) for level in BANDS if level.verdict.flagged}
    VerdictTable = create_model("VerdictTable", __base__=LevelTable, __module__=__name__, **_some)
    BandTable = create_model("BandTable", __base__=LevelTable, __module__=__name__, **_every)


class LimitsFile(Entry):
    """A limits file as it is read."""

    wear_percent: VerdictTable | None = None
    clearance_um: VerdictTable | None = None
    pair_share_percent: VerdictTable | None = None
    total_share_percent: BandTable

    @model_validator(mode="after")
    def _judges_lands(self) -> LimitsFile:
        if self.wear_percent is None and self.clearance_um is None and self.pair_share_percent is None:
            raise ValueError("at least one rule for a land: wear_percent, clearance_um or pair_share_percent")
        return self
