"""Find which lands cost which pressure: what the line and every circuit would hold with one land new."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from atleak.catalogue.complaints import LandKey
from atleak.catalogue.controller import OperatingPoint
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import held_with

LINE = "p_g"  # the section that supplies all others
WORTH_NAMING = 100.0  # [Pa] that a land costs a circuit at least, to be named as a cause: choice of this project

Losses = Mapping[str, Mapping[LandKey, float]]  # [Pa] by circuit, then by land


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
    held = held_with(model, new, point, [(), *((key,) for key in lands)])
    losses: dict[str, Mapping[LandKey, float]] = {}
    for name in (LINE, *(circuit.id for circuit in model.controller.circuits)):
        pressure = np.broadcast_to(held.balance.pressures[name], (len(lands) + 1,))
        gained = zip(lands, (pressure[1:] - pressure[0]).tolist(), strict=True)
        named = sorted(((key, gain) for key, gain in gained if abs(gain) >= WORTH_NAMING), key=lambda each: -each[1])
        losses[name] = MappingProxyType(dict(named))
    return MappingProxyType(losses)
