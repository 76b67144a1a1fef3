"""Compute a unit with some of its lands new, for several choices of lands at once: leakage, line, circuits."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.complaints import LandKey
from atleak.catalogue.controller import OperatingPoint
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import LINE, hold
from atleak.engine.restrictions import Gap

WORTH_NAMING = 100.0  # [Pa] that a land costs a circuit at least, to be named as a cause: choice of this project

Losses = Mapping[str, Mapping[LandKey, float]]  # [Pa] by circuit, then by land


@dataclass(frozen=True)
class Repaired:
    """What a unit does at one condition with some of its lands new; arrays of shape (choices,)."""

    leakage: np.ndarray  # [m³/s] drawn from the pump at the required line pressure
    pressures: Mapping[str, np.ndarray]  # [Pa] that the line, as p_g, and every circuit hold


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
    network, lands = model.network(point), []
    for gap, now, then in zip(model.gaps_in(point.gear), network.lands, new.network(point).lands, strict=True):
        as_new = np.array([gap.key in keys for keys in chosen], bool)
        parts = ((each.restriction.conductance, each.restriction.bend) for each in (now, then))
        restriction = Gap(*(np.where(as_new, b, a) for a, b in zip(*parts, strict=True)))
        lands.append(replace(now, restriction=restriction))
    network = replace(network, lands=tuple(lands))
    held = hold(network, point, model.pump, model.dynamic_viscosity(point.temperature))
    sections = model.controller.section_pressures(point.main_pressure, point.converter_pressure)
    leakage = network.drawn_from_pump(network.balance(sections))
    names = (circuit.id for circuit in model.controller.circuits)
    pressures = {LINE: held.main_pressure, **{name: held.balance.pressures[name] for name in names}}

    def each(value: Any) -> np.ndarray:
        return np.broadcast_to(np.asarray(value, float), (len(chosen),))

    return Repaired(each(leakage), {name: each(pressure) for name, pressure in pressures.items()})


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
