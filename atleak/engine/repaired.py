"""Compute a unit with some of its lands repaired, for several choices at once: leakage, line, circuits."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from atleak.catalogue.complaints import LandKey
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.circuits import Network
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import Operation, spread_over
from atleak.engine.restrictions import Branch, Gap

WORTH_NAMING = 100.0  # [Pa] that a land costs a circuit at least, to be named as a cause: choice of this project

Losses = Mapping[str, Mapping[LandKey, float]]  # [Pa] by circuit, then by land


@dataclass(frozen=True)
class Repaired:
    """What a unit does at one condition with some of its lands repaired; arrays of shape (choices,)."""

    leakage: np.ndarray  # [m³/s] drawn from the pump at the required line pressure
    pressures: Mapping[str, np.ndarray]  # [Pa] that the line, as p_g, and every circuit hold


@dataclass(frozen=True)
class LandStates:
    """A unit at one condition, of which each land can be in one of several states: as it is, or as a repair leaves it.

    A choice names the state of each land by its number; a land that it does not name is in state 0, as it is.
    """

    model: LeakageModel  # of the unit as it is
    point: OperatingPoint
    networks: tuple[Network, ...]  # one for each number of a state; all the same but for the restrictions of gaps

    @classmethod
    def of(cls, models: Sequence[LeakageModel], point: OperatingPoint) -> LandStates:
        """Return a unit whose models differ in their clearances, the unit as it is first.

        Raises
        ------
        DomainError
            temperature outside the fluid's data.
        """
        return cls(models[0], point, tuple(model.network(point) for model in models))

    @cached_property
    def keys(self) -> tuple[LandKey, ...]:
        """Return the land of every gap of the network."""
        return tuple(gap.key for gap in self.model.gaps_in(self.point.gear))

    @cached_property
    def gaps(self) -> tuple[Branch[Gap], ...]:
        """Return the gaps of the network in every state at once: arrays of shape (states,)."""
        return self.network([dict.fromkeys(self.keys, state) for state in range(len(self.networks))]).lands

    @cached_property
    def _numbers(self) -> tuple[np.ndarray, np.ndarray]:
        """Return conductance and bend of every gap in every state, shapes (states, gaps)."""
        restricted = [[land.restriction for land in network.lands] for network in self.networks]
        return (
            np.array([[each.conductance for each in row] for row in restricted], float),
            np.array([[each.bend for each in row] for row in restricted], float),
        )

    def network(self, choices: Sequence[Mapping[LandKey, int]]) -> Network:
        """Return the network of several choices at once: restrictions of shape (choices,)."""
        lands = self.networks[0].lands
        states = np.array([[choice.get(key, 0) for choice in choices] for key in self.keys], int)
        of_gap = np.arange(len(lands))[:, None]
        conductances, bends = (part[states, of_gap] if lands else () for part in self._numbers)
        restricted = (Gap(*each) for each in zip(conductances, bends, strict=True))
        return replace(
            self.networks[0],
            lands=tuple(land.with_restriction(each) for land, each in zip(lands, restricted, strict=True)),
        )

    def repaired(self, choices: Sequence[Mapping[LandKey, int]]) -> Repaired:
        """Compute the unit for several choices of the states of its lands."""
        at, shape = Operation.of(self.model, self.point, network=self.network(choices)), (len(choices),)
        circuits = (circuit.id for circuit in self.model.controller.circuits)
        return Repaired(spread_over(at.leakage, shape), at.pressures(circuits, shape))


def with_new(
    model: LeakageModel, new: LeakageModel, point: OperatingPoint, chosen: Sequence[Collection[LandKey]]
) -> Repaired:
    """Compute a unit at one condition, for several choices of lands that are new.

    Parameters
    ----------
    model, new
        of the unit as it is, and with every land new.
    chosen
        for each choice the lands that are as in ``new``.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    return LandStates.of((model, new), point).repaired([dict.fromkeys(keys, 1) for keys in chosen])


def pressure_losses(model: LeakageModel, new: LeakageModel, point: OperatingPoint, lands: Sequence[LandKey]) -> Losses:
    """Return what the line and every circuit would gain with one of some lands new [Pa], the largest first.

    Parameters
    ----------
    model, new
        of the unit as measured, and with every land new.
    lands
        which are tried; those that gain a circuit less than `WORTH_NAMING` are not in the result.

    Notes
    -----
    A pressure does not fall in proportion to the leaks: what two lands cost together is more or less than the sum.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    if model.profile.circuits != "on" or not lands:
        return {}
    held = with_new(model, new, point, [(), *((key,) for key in lands)])
    losses: dict[str, Mapping[LandKey, float]] = {}
    for name, pressure in held.pressures.items():
        gained = zip(lands, (pressure[1:] - pressure[0]).tolist(), strict=True)
        named = sorted(((key, gain) for key, gain in gained if abs(gain) >= WORTH_NAMING), key=lambda each: -each[1])
        losses[name] = MappingProxyType(dict(named))
    return MappingProxyType(losses)
