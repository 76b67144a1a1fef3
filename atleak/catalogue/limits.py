"""Describe limit sets: where a value becomes watch, replace or critical, and where each limit comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, create_model, model_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import Entry, Headed, NonEmptyText, Origin, Shelf, Strict
from atleak.catalogue.keys import key, made, unit_of
from atleak.common.errors import CatalogueError, Message
from atleak.common.file_faults import NotAccepted, WrongTogether, validated
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.common.units import KPA, PERCENT, UM
from atleak.common.verdicts import BANDS, FLAGGED, Band, Verdict

Level = Verdict | Band
DEFAULT_LIMITS = "project_default"
ROUNDING = 1e-9  # relative: a value that equals its limit but for floating point has reached it


def reaches(value: float, limit: float) -> bool:
    """Tell whether a value is at or past a limit, whatever rounding does to its last digits.

    A limit of zero is passed by what is over zero: what lies below a permissible pressure at all.
    """
    if limit == 0.0:
        return value > ROUNDING
    return value >= limit or value > limit - ROUNDING * abs(limit)


def falls_below(value: float, limit: float) -> bool:
    """Tell whether a value is under a limit by more than rounding."""
    return value < limit - ROUNDING * abs(limit)


class LimitOrigin(StrEnum):
    """The authority behind a limit."""

    PUBLISHED = "published"
    PROJECT = "choice of this project"
    WORKSHOP = "set by the workshop"


_FRACTION, _PRESSURE = (PERCENT, "%", "percent", None), (KPA, "kPa", "kpa", "pressure")
_CLEARANCE, _NUMBER = (UM, "µm", "um", "clearance"), (1.0, "", "", None)


class RuleKind(StrEnum):
    """The quantities that limits are set for."""

    WEAR = "wear", *_FRACTION  # of a land, (c_r − c_m)/c_m
    CLEARANCE = "radial_clearance", *_CLEARANCE  # of a land
    PAIR_SHARE = "pair_share", *_FRACTION  # leakage of one land / pump capacity
    TOTAL_SHARE = "total_share", *_FRACTION  # leakage of the unit / pump capacity
    RESERVE = "reserve", *_NUMBER  # pump supply / (leakage + slip + consumers)
    CIRCUIT_LOSS = "circuit_loss", *_PRESSURE  # that a circuit has lost, or gained, against new
    BELOW_LINE = "below_line", *_PRESSURE  # how far a circuit's gauge is below that of the line; limited as the loss
    BELOW_EXPECTED = "below_expected", *_PRESSURE  # how far the line's gauge is below a new unit's; likewise
    PERMISSIBLE_PRESSURE = "permissible_pressure", *_FRACTION  # how far main pressure is below it, of it
    COMMANDED_PRESSURE = "commanded_pressure", *_PRESSURE  # how far main pressure is from what is commanded
    PUMP_SIDE = "pump_side_clearance", *_CLEARANCE
    PUMP_TIP = "pump_tip_clearance", *_CLEARANCE

    factor: float  # from SI, or a fraction, to the unit that people read
    unit: str  # that people read; none of a plain number
    suffix: str  # that unit as the end of a key
    quantity: str | None  # its kind, where people may read it in another unit; None for a fraction

    def __new__(cls, value: str, factor: float, unit: str, suffix: str, quantity: str | None) -> RuleKind:
        kind = str.__new__(cls, value)
        kind._value_ = value
        kind.factor, kind.unit, kind.suffix, kind.quantity = factor, unit, suffix, quantity
        return kind

    @property
    def in_bands(self) -> bool:
        """Return whether its levels are bands of the whole unit."""
        return self in {RuleKind.TOTAL_SHARE, RuleKind.RESERVE}

    @property
    def is_share(self) -> bool:
        """Return whether it is a share of the pump's flow, which can be judged by its growth over new."""
        return self in {RuleKind.PAIR_SHARE, RuleKind.TOTAL_SHARE}

    @property
    def of_land(self) -> bool:
        """Return whether it judges one land."""
        return self in {RuleKind.WEAR, RuleKind.CLEARANCE, RuleKind.PAIR_SHARE}


@dataclass(frozen=True)
class Steps:
    """Rising limits of one quantity, each with the name of the level that begins there.

    Of wear a level may ask for a least growth of the clearance, ``at_least`` [m], besides its fraction: over the widest
    that a new pair of the type commonly has, where only the type's clearance and its tolerance are known. Of a share a
    level may ask for growth over the same land or unit new: by the fraction ``growth``, and by ``added``, a fraction
    of the pump's flow. A level with no limit of its own is reached by growth alone.

    Of a reserve the limits fall, and a level is reached under its limit. Where the same unit new is itself under one,
    the level begins where the reserve has fallen by the fraction ``fall`` from that of the new one, the worst at 1 at
    the least.
    """

    levels: tuple[tuple[Level, float], ...]  # each with its limit, rising; of a reserve falling
    origin: LimitOrigin  # who stands behind them
    source: str  # where they are stated
    at_least: Mapping[Level, float] = field(default_factory=dict)  # [m] least growth of the clearance, beside the wear
    growth: Mapping[Level, tuple[float, float]] = field(default_factory=dict)  # level → growth, added
    fall: float | None = None  # fraction; None where the limits rise

    @property
    def falling(self) -> bool:
        """Return whether a level is reached under its limit instead of over it."""
        return self.fall is not None

    def has_limit(self, level: Level) -> bool:
        """Return whether a level has a limit of its own, and is not reached by growth alone."""
        return level not in self.growth or bool(self.limit_of(level))

    def under(self, new: Any) -> tuple[tuple[Level, Any], ...]:
        """Return the falling limits where the same unit new has the reserve ``new``, a number or an array.

        Parameters
        ----------
        new
            reserve of the same unit new [-], a number or an array.

        Returns
        -------
        tuple
            each level with its limit [-], falling; arrays where ``new`` is one.

        Examples
        --------
        >>> steps = Steps(((Band.AMBER, 1.5), (Band.CRITICAL, 1.0)), LimitOrigin.PROJECT, "", fall=0.1)
        >>> [(band.value, round(limit, 3)) for band, limit in steps.under(1.4)]
        [('amber', 1.26), ('critical', 1.0)]
        """
        limits: list[tuple[Level, Any]] = []
        least: Any = min(self.levels[-1][1], 1.0)  # under 1 the pump cannot hold the line, whatever a new unit does
        for level, limit in reversed(self.levels):  # a level never begins below a worse one
            fallen = np.where(new < limit, (1.0 - (self.fall or 0.0)) * new, limit)
            least = np.maximum(fallen, least)
            limits.append((level, float(least) if np.ndim(least) == 0 else least))
        return tuple(reversed(limits))

    def over(self, new: Any) -> tuple[tuple[Level, Any], ...]:
        """Return the limits of a share where the same land or unit has the share ``new`` when new.

        Parameters
        ----------
        new
            share of the pump's flow that the same land or unit has when new, a fraction; a number or an array.

        Returns
        -------
        tuple
            each level with its limit, a fraction; one that growth has no part in stays a number.

        Examples
        --------
        >>> growth = {Band.AMBER: (0.25, 0.02)}
        >>> steps = Steps(((Band.AMBER, 0.0), (Band.CRITICAL, 0.5)), LimitOrigin.PROJECT, "", growth=growth)
        >>> [(band.value, round(limit, 3)) for band, limit in steps.over(0.16)]
        [('amber', 0.2), ('critical', 0.5)]
        """
        return tuple((level, self._over(level, limit, new)) for level, limit in self.levels)

    def _over(self, level: Level, limit: float, new: Any) -> Any:
        if level not in self.growth:
            return limit
        fraction, added = self.growth[level]
        grown = np.maximum(np.maximum((1.0 + fraction) * new, new + added), limit)
        return float(grown) if np.ndim(grown) == 0 else grown

    def of_wear(self, mounting_clearance: float, tolerance: float = 0.0) -> tuple[tuple[Level, float], ...]:
        """Return the limits of the wear of a land with that mounting clearance and tolerance [m], a fraction of it.

        A level that begins above another one never has the lower limit of the two.

        Parameters
        ----------
        mounting_clearance
            radial clearance when new, the upper end of a range [m].
        tolerance
            by which a new pair of the type may be wider [m]; 0 of a clearance that is this pair's own.

        Returns
        -------
        tuple
            each level with its limit of (c_r − c_m)/c_m, a fraction; rising.
        """
        limits: list[tuple[Level, float]] = []
        for level, limit in self.levels:
            if level in self.at_least:
                limit = max(limit, (self.at_least[level] + tolerance) / mounting_clearance)
            limits.append((level, max(limit, limits[-1][1]) if limits else limit))
        return tuple(limits)

    def judge(self, value: float, below: Level, reached: Sequence[float] | None = None) -> tuple[Level, float]:
        """Return the level that a value has reached and its limit; ``below`` and the lowest limit under all of them.

        The lowest is not always the first: growth over a unit that draws much when new can begin above a fixed limit.
        Where ``reached`` says how likely the true value has reached each level, the highest counts of which that is as
        likely as not: a value may stand within a limit that the unit has probably passed.

        Parameters
        ----------
        value
            in the unit of the limits: SI, or a fraction.
        below
            the level of a value that has reached none.
        reached
            probability [-] that the true value has reached each level, in their order; by the value alone unless given.

        Examples
        --------
        >>> steps = Steps(((Verdict.WATCH, 10.0), (Verdict.REPLACE, 50.0)), LimitOrigin.PUBLISHED, "")
        >>> level, limit = steps.judge(50.0, Verdict.OK)
        >>> level.value, limit
        ('replace', 50.0)
        >>> steps.judge(9.0, Verdict.OK, (0.6, 0.3))[0].value
        'watch'
        """
        passes, first = (falls_below, max) if self.falling else (reaches, min)
        likely = [passes(value, limit) for _, limit in self.levels] if reached is None else [p >= 0.5 for p in reached]
        past = [each for each, passed in zip(self.levels, likely, strict=True) if passed]
        return past[-1] if past else (below, first(limit for _, limit in self.levels))

    def limit_of(self, level: Level) -> float | None:
        """Return the limit at which a level begins; None where the set does not name it."""
        return next((limit for name, limit in self.levels if name == level), None)


@brief
@dataclass(frozen=True)
class Limits(Headed):
    """A set of limits; a rule that is None is not applied.

    Attributes
    ----------
    wear
        of (c_r − c_m)/c_m, as a fraction.
    clearance
        of the radial clearance [m].
    pair_share
        of leakage / pump capacity of one land, as a fraction.
    total_share
        of the whole valve body, likewise.
    origin
        the file.
    reserve
        of the pump, as a ratio; falling: less is worse.
    circuit_loss
        of the pressure lost against new [Pa].
    below_permissible
        of how far main pressure is below the permissible, as a fraction of it.
    commanded_pressure
        of how far main pressure is from what is commanded [Pa].
    doubts
        values that are possible and unusual.
    """

    wear: Steps | None
    clearance: Steps | None
    pair_share: Steps | None
    total_share: Steps
    origin: Origin
    reserve: Steps | None = None
    circuit_loss: Steps | None = None
    below_permissible: Steps | None = None
    commanded_pressure: Steps | None = None
    doubts: tuple[Message, ...] = field(default=(), repr=False, compare=False)

    @property
    def fixed_bands(self) -> tuple[tuple[Band, float], ...]:
        """Return the bands that begin at a fixed total share (a fraction), whatever the unit drew when new."""
        total = self.total_share
        return tuple((Band(level), limit) for level, limit in total.levels if level not in total.growth)

    @property
    def rules(self) -> MappingProxyType[RuleKind, Steps]:
        """Return the rules that are applied, by the quantity they limit."""
        stated = {
            RuleKind.WEAR: self.wear,
            RuleKind.CLEARANCE: self.clearance,
            RuleKind.PAIR_SHARE: self.pair_share,
            RuleKind.TOTAL_SHARE: self.total_share,
            RuleKind.RESERVE: self.reserve,
            RuleKind.CIRCUIT_LOSS: self.circuit_loss,
            RuleKind.PERMISSIBLE_PRESSURE: self.below_permissible,
            RuleKind.COMMANDED_PRESSURE: self.commanded_pressure,
        }
        return MappingProxyType({kind: steps for kind, steps in stated.items() if steps is not None})


def _limits(data: Mapping[str, Any], origin: Origin) -> Limits:
    entry = validated(LimitsFile, data, origin.file, kind=CatalogueError)
    doubts = doubts_of("limits", LimitsFile, data, origin.file)
    tables = {name: getattr(entry, name) for name in LimitsFile.model_fields}
    steps = {
        unit_of(name)[0]: table.steps(unit_of(name)[1].size)
        for name, table in tables.items()
        if isinstance(table, LevelTable | ReserveTable)
    }
    return made(Limits, entry, origin=origin, doubts=doubts, **steps)


_HIGHEST = 10_000.0  # of any limit, in the unit of its table; nothing that is measured or computed gets there
_MOST = {  # of those whose quantity ends before: what lies beyond would switch the rule off without a word
    "clearance_um": 500.0,  # readings further apart are refused
    "pair_share_percent": 1000.0,
    "total_share_percent": 1000.0,
    "below_permissible_percent": 100.0,
}


_OF_SHARES = ("growth_percent", "added_points")
BESIDE_LIMIT: Mapping[str, tuple[str, ...]] = MappingProxyType(  # by table: keys of a level beside its limit
    {"wear_percent": ("at_least_um",), "pair_share_percent": _OF_SHARES, "total_share_percent": _OF_SHARES}
)


class LevelLimit(Strict):
    """Where one level begins; all that is stated is asked for."""

    percent: float | None = key(default=None, ge=0, le=_HIGHEST)  # the limit itself, in the unit of its table
    at_least_um: float | None = key("at least", usual=usual.AT_LEAST, default=None, gt=0, le=500)  # of wear
    growth_percent: float | None = key(
        "growth over new", usual=usual.GROWTH, default=None, gt=0, le=_HIGHEST
    )  # of a share
    added_points: float = key(
        "added points", unit="%", usual=usual.ADDED_POINTS, default=0.0, ge=0, le=1000
    )  # of a share, to a new one's

    @property
    def growth(self) -> tuple[float, float] | None:
        """Return growth over a new one and what it adds, as fractions; None where growth is not asked for."""
        return None if self.growth_percent is None else (self.growth_percent * 1e-2, self.added_points * 1e-2)


def _a_number_or_a_table(value: object) -> object:
    """Take a plain number as the limit itself."""
    if value is None or isinstance(value, dict | LevelLimit):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotAccepted(Sentence("a number greater than 0, or a table such as { percent = 10.0 }"))
    if not 0.0 <= value <= _HIGHEST:
        raise NotAccepted(Sentence("a number greater than 0, up to {most:.15g}", most=_HIGHEST))
    return {"percent": value}


_Stated = Annotated[LevelLimit | None, BeforeValidator(_a_number_or_a_table)]


_Whose = Annotated[LimitOrigin, key("Limit is", "Published, chosen by atleak or set by you", strict=False)]
_SourceOfLimit = Annotated[NonEmptyText, key("Source of the limit", "Manual and page, or whose experience")]


class LevelTable(Strict):
    """The limits of one quantity as a file states them."""

    origin: _Whose  # a file writes it as text
    source: _SourceOfLimit

    def stated(self) -> dict[str, LevelLimit]:
        """Return the levels that are set, in rising order of severity."""
        named = {name: getattr(self, name) for name in type(self).model_fields if name not in LevelTable.model_fields}
        return {name: limit for name, limit in named.items() if limit is not None}

    def steps(self, unit: float) -> Steps:
        """Return the same limits in SI or as fractions; ``unit`` is the size of one unit of the file."""
        kind = Band if isinstance(self, BandTable) else Verdict
        stated = {kind(name): limit for name, limit in self.stated().items()}
        return Steps(
            tuple((level, (each.percent or 0.0) * unit) for level, each in stated.items()),
            self.origin,
            self.source,
            {level: each.at_least_um * 1e-6 for level, each in stated.items() if each.at_least_um},
            {level: each.growth for level, each in stated.items() if each.growth},
        )

    @model_validator(mode="after")
    def _rising(self) -> LevelTable:
        stated = self.stated()
        if not stated:
            raise NotAccepted(Sentence("at least one limit"))
        for (low_name, low_level), (high_name, high_level) in pairwise(
            (name, each.growth) for name, each in stated.items() if each.growth is not None
        ):
            if any(high < low for low, high in zip(low_level, high_level, strict=True)):
                wanted = Sentence(
                    "growth and added points of {high} not below those of {low}", high=high_name, low=low_name
                )
                raise WrongTogether(wanted, high_name)
        limits = {name: each.percent for name, each in stated.items() if each.percent is not None}
        for (low_name, low), (high_name, high) in pairwise(limits.items()):
            if high <= low:
                wanted = Sentence("{high} above {low} ({limit:g})", high=high_name, low=low_name, limit=low)
                raise WrongTogether(wanted, high_name)
        for name, each in stated.items():
            if each.added_points and each.growth is None:
                raise WrongTogether(Sentence("{level}: growth_percent beside added_points", level=name), name)
        return self


if TYPE_CHECKING:

    class VerdictTable(LevelTable): ...

    class BandTable(LevelTable): ...

else:
    # a field for every level there is: a land's may be left out, a total's bands are all stated
    _some: dict[str, Any] = {level.value: (_Stated, None) for level in FLAGGED}
    _every: dict[str, Any] = {level.value: (_Stated, ...) for level in BANDS if level.verdict.flagged}
    VerdictTable = create_model("VerdictTable", __base__=LevelTable, __module__=__name__, **_some)
    BandTable = create_model("BandTable", __base__=LevelTable, __module__=__name__, **_every)


def _reserve(band: Band) -> Any:
    """Return the field of a limit; a reserve that falls under a tenth leaves no pressure to speak of."""
    return key(band.value.capitalize(), usual=usual.RESERVE, ge=0.1, le=100)


class ReserveTable(Strict):
    """The falling limits of the pump's reserve as a file states them."""

    origin: _Whose
    source: _SourceOfLimit
    amber: float = _reserve(Band.AMBER)
    red: float = _reserve(Band.RED)
    critical: float = _reserve(Band.CRITICAL)
    fall_percent: float = key(
        "Fall from new",
        "Of a unit that has less than a limit when new: its level begins where the reserve has fallen by this",
        usual=usual.FALL,
        default=10.0,
        ge=0,
        lt=100,
    )

    @model_validator(mode="after")
    def _falling(self) -> ReserveTable:
        if not self.amber > self.red > self.critical:
            wrong = "red" if self.red >= self.amber else "critical"
            wanted = Sentence("amber above red above critical: a reserve is worse the smaller it is")
            raise WrongTogether(wanted, wrong)
        return self

    def steps(self, unit: float) -> Steps:
        """Return the same limits as steps."""
        levels = ((Band(name), getattr(self, name) * unit) for name in ("amber", "red", "critical"))
        return Steps(tuple(levels), self.origin, self.source, fall=self.fall_percent * 1e-2)


class LimitsFile(Entry):
    """A limits file as it is read."""

    wear_percent: VerdictTable | None = key(
        "Wear", "Growth of a land's radial clearance over that when new", usual=usual.WEAR, default=None
    )
    clearance_um: VerdictTable | None = key(
        "Clearance", "Radial clearance of a land, whatever it was when new", usual=usual.WEAR_LIMIT, default=None
    )
    pair_share_percent: VerdictTable | None = key(
        "Share of a pair",
        "What one pair draws of the pump's flow; growth is over the same pair new",
        usual=usual.PAIR_SHARE,
        default=None,
    )
    total_share_percent: BandTable = key(
        "Share of the unit",
        "What the whole unit draws of the pump's flow; growth is over the same unit new",
        usual=usual.TOTAL_SHARE,
    )
    reserve: ReserveTable | None = key(
        "Reserve", "What the pump displaces over all that leaves the line: the smaller, the worse", default=None
    )
    circuit_loss_kpa: VerdictTable | None = key(
        "Loss of a circuit",
        "Pressure that a circuit has lost, or gained, against the same unit new",
        usual=usual.CIRCUIT_LOSS,
        default=None,
    )
    below_permissible_percent: VerdictTable | None = key(
        "Below the permissible",
        "How far main pressure is below what the valve body's file permits",
        usual=usual.BELOW_PERMISSIBLE,
        default=None,
    )
    commanded_pressure_kpa: VerdictTable | None = key(
        "Off the commanded",
        "How far main pressure is from what the control unit commands",
        usual=usual.OFF_COMMANDED,
        default=None,
    )

    @model_validator(mode="after")
    def _judges_lands(self) -> LimitsFile:
        if self.wear_percent is None and self.clearance_um is None and self.pair_share_percent is None:
            wanted = Sentence("at least one rule for a land: wear_percent, clearance_um or pair_share_percent")
            raise NotAccepted(wanted)
        return self

    @model_validator(mode="after")
    def _of_its_own_quantity(self) -> LimitsFile:
        for name in LimitsFile.model_fields:
            table = getattr(self, name)
            for level, each in table.stated().items() if isinstance(table, LevelTable) else ():
                where, beside = f"{name}.{level}", BESIDE_LIMIT.get(name, ())
                wanted = None
                if each.at_least_um is not None and "at_least_um" not in beside:
                    wanted = Sentence("at_least_um in wear_percent only, not in {where}", where=where)
                elif each.growth is not None and "growth_percent" not in beside:
                    wanted = Sentence("growth_percent of a share only, not in {where}", where=where)
                elif (each.percent or 0.0) > _MOST.get(name, _HIGHEST):
                    wanted = Sentence(
                        "at most {most:.15g} in {where}, not {value:.15g}",
                        most=_MOST[name],
                        where=where,
                        value=each.percent,
                    )
                elif each.percent == 0.0 and name != "below_permissible_percent":
                    wanted = Sentence("a number greater than 0 in {where}", where=where)
                elif each.percent is None and (each.growth is None or name == "wear_percent"):
                    wanted = Sentence("a limit in {where}: a number, or growth_percent of a share", where=where)
                if wanted is not None:
                    raise WrongTogether(wanted, name, level)
        return self


LIMIT_SETS = Shelf("limits", LimitsFile, _limits)
checked_limits, limit_sets = LIMIT_SETS.checked, LIMIT_SETS.usable


def load_limits(id_or_path: str | Path) -> Limits:
    """Load a set of limits from its file.

    Parameters
    ----------
    id_or_path
        the id of one that is shipped or in the workshop's own catalogue, or the path of a file.

    Returns
    -------
    Limits
        checked; ``doubts`` say what is unusual.

    Raises
    ------
    CatalogueError
        if the file is missing or wrong; the message names file, table, key and value, and lists every other fault.
    """
    return LIMIT_SETS.load(id_or_path)
