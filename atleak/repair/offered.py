"""Offer every repair of a unit one by one, and compute what any set of them leaves of it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.repair.moves import Move, MoveKey, Moves, Prices, together
from atleak.repair.options import Options
from atleak.repair.totals import RepairableUnit, RepairedAt, Total


@dataclass(frozen=True)
class OfferedRepair:
    """One repair that can be chosen, with the lands that it changes, the one that calls for it most first."""

    move: Move
    lands: tuple[LandDiagnosis, ...]
    alone: tuple[RepairedAt, ...]  # what it brings at every condition if nothing else is repaired

    @property
    def key(self) -> MoveKey:
        """Return what names it."""
        return self.move.key

    @property
    def called_for(self) -> bool:
        """Tell whether a land that it treats has reached a limit of its own."""
        return any(land.verdict.flagged and land.key in self.move.treats for land in self.lands)

    @property
    def best_at(self) -> RepairedAt:
        """Return the condition at which it saves most, measured by the limit of that condition."""
        return max(self.alone, key=lambda each: each.saving)


class OfferedRepairs:
    """Every repair that is offered of a diagnosed unit: for flagged lands first, in the order of what each brings.

    Parameters
    ----------
    diagnosis
        the unit.
    prices
        what repairs cost; as the valve body's file states it unless given.
    """

    def __init__(self, diagnosis: Diagnosis, prices: Prices | None = None) -> None:
        self.diagnosis, self.prices = diagnosis, prices or Prices()
        lands = [land for land in diagnosis.lands if land.state.judged]
        self.moves = Moves(Options(diagnosis), lands, self.prices)
        self.unit: RepairableUnit = self.moves.unit()

    @cached_property
    def all(self) -> tuple[OfferedRepair, ...]:
        """Return the repairs, those that flagged lands call for first: the worst verdict, then what saves most."""
        by_key = {land.key: land for land in self.diagnosis.lands}
        now, *after = self._one_by_one
        offered = [
            OfferedRepair(
                move,
                tuple(sorted((by_key[key] for key in move.lands), key=lambda land: -land.verdict.rank)),
                tuple(RepairedAt(one, other) for one, other in zip(now, totals, strict=True)),
            )
            for move, totals in zip(self.moves.all, after, strict=True)
        ]

        def urgency(each: OfferedRepair) -> tuple[bool, int, float]:
            treated = (land.verdict.rank for land in each.lands if land.key in each.move.treats)
            return not each.called_for, -max(treated, default=0) if each.called_for else 0, -each.best_at.saving

        return tuple(sorted(offered, key=urgency))

    def chosen(self, keys: Collection[MoveKey]) -> list[Move]:
        """Return the repairs of some keys that go together; keys that nothing here has are left out."""
        return together(move for move in self.moves.all if move.key in keys)

    def totals(self, keys: Collection[MoveKey]) -> tuple[Total, ...]:
        """Return the totals and pressures with some repairs made, at every condition, the stated one first."""
        return self.unit.totals([self.moves.choice(self.chosen(keys))])[0]

    @cached_property
    def _one_by_one(self) -> list[tuple[Total, ...]]:
        """Return the totals as measured, then with each repair alone."""
        return self.unit.totals([{}, *(self.moves.choice([move]) for move in self.moves.all)])

    def effect(self, keys: Collection[MoveKey]) -> tuple[RepairedAt, ...]:
        """Return what some repairs bring together at every condition, the stated one first."""
        after = self.totals(keys)
        return tuple(RepairedAt(one, other) for one, other in zip(self._one_by_one[0], after, strict=True))

    def excluded_by(self, key: MoveKey) -> frozenset[MoveKey]:
        """Return the other repairs that do not go together with one: no land is changed by two of the file's."""
        mine = next((move for move in self.moves.all if move.key == key), None)
        if mine is None or mine.option is None:
            return frozenset()
        others = (each for each in self.moves.all if each.option is not None and each is not mine)
        return frozenset(each.key for each in others if set(each.lands) & set(mine.lands))


def ticked(repairs: OfferedRepairs, keys: Collection[MoveKey], key: MoveKey, on: bool) -> frozenset[MoveKey]:
    """Return a set of repairs after one was taken in or out: what does not go with it is taken out."""
    if not on:
        return frozenset(keys) - {key}
    return (frozenset(keys) | {key}) - repairs.excluded_by(key)
