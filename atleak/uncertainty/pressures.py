"""Carry the draws of a unit into the pump's reserve, the line pressure that holds and what every circuit holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.balance import Balance
from atleak.engine.circuits import Network
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.line import consumed, fall_to_set_pressure, sections_held, spread_over
from atleak.engine.projection import Projection
from atleak.rules import permissible_steps
from atleak.uncertainty.spread import Interval, Spread, interval_of, spread_of

_GRID = np.linspace(0.0, 1.0, 17)  # fractions of the required pressure at which the demand is worked out
_HALVINGS = 40  # of the pressure that holds


@dataclass(frozen=True)
class PressureSpread:
    """The spread of the pump's reserve and of every pressure at one condition."""

    reserve: Interval
    main_pressure: Interval  # [Pa] that holds of what is required, however well that is known
    circuits: Mapping[str, Interval]  # [Pa] that each holds, by id; without those that are vented
    #: of what a rule limits, by its kind and circuit: the reserve, how far main pressure is below the permissible, and
    #: what a circuit has lost or gained against the same unit unworn
    limited: Mapping[tuple[RuleKind, str | None], Spread]


@dataclass(frozen=True)
class DrawnUnit:
    """One unit with its uncertain factors drawn, at one condition; arrays of shape (draws,)."""

    network: Network
    balance: Balance  # at the required line pressure
    leakage: np.ndarray  # [m³/s] drawn from the pump
    pressures: Mapping[str, Any]  # [Pa] of the sections at the required line pressure
    pump: PumpFlow
    viscosity: Any  # [Pa·s]

    @property
    def demand(self) -> Any:
        """Return all that leaves the pump, its own slip included [m³/s]."""
        required = self.pressures["p_g"]
        slip = self.pump.slip(required, self.viscosity)
        return self.leakage + slip + consumed(self.network, required, required)

    def reserve(self, point: OperatingPoint) -> np.ndarray:
        """Return the pump's supply over it."""
        with np.errstate(divide="ignore"):
            return np.divide(self.pump.per_revolution * point.engine_speed, self.demand)

    def held(self, point: OperatingPoint, demand_at: np.ndarray) -> tuple[np.ndarray, Mapping[str, Any]]:
        """Return the line pressure that holds, and all pressures with it [Pa].

        ``demand_at`` is the part of the leakage at the required line pressure that is left at each fraction of `_GRID`:
        how a demand falls with the pressure is taken from the unit as measured for every draw.
        """
        main = spread_over(self.pressures["p_g"], self.leakage.shape)
        converter = self.pressures["p_k"]
        if not self.network.solves:
            return main, self.balance.pressures

        def lacking(fraction: Any) -> Any:
            supply = self.pump.capacity(point.engine_speed, fraction * main, self.viscosity)
            before_line = consumed(self.network, fraction * main, main, after_line=False)
            return self.leakage * np.interp(fraction, _GRID, demand_at) + before_line - supply

        held, falls = main, lacking(np.ones_like(main)) > 0.0
        if falls.any():
            low, high = np.zeros_like(main), np.ones_like(main)
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                over = lacking(middle) > 0.0
                low, high = np.where(over, low, middle), np.where(over, middle, high)
            held = np.where(falls, low * main, main)

        def at(main: Any, near: Balance) -> Balance:
            return self.network.balance(sections_held(self.network.controller, main, converter), near)

        balance, line = at(held, self.balance) if falls.any() else self.balance, self.network.controller.line
        if line is not None and line.following is not None:
            # what the line is set to is as uncertain as what is required
            factor = main / point.main_pressure
            held, balance, _ = fall_to_set_pressure(line, point, held, balance, at, factor)
        return held, balance.pressures


def demand_shape(model: LeakageModel, point: OperatingPoint) -> np.ndarray:
    """Return the part of a unit's leakage that is left at each fraction of the required line pressure in `_GRID`."""
    network = model.network(point)
    sections = sections_held(model.controller, _GRID * point.main_pressure, point.converter_pressure)
    drawn = np.broadcast_to(network.drawn_from_pump(network.balance(sections)), _GRID.shape)
    return drawn / drawn[-1] if drawn[-1] > 0.0 else _GRID


def pressure_spread(
    projection: Projection,
    model: LeakageModel,
    now: DrawnUnit,
    unworn: DrawnUnit,
    limits: Limits,
    coverage: float,
) -> PressureSpread:
    """Return the spread of reserve and pressures of a unit, judged beside the same unit unworn, draw by draw.

    Parameters
    ----------
    projection
        the unit as measured, at the condition of the draws.
    limits
        whose probabilities of having been reached are wanted.
    """
    point, steps = projection.condition, limits.reserve
    reserve, when_unworn = now.reserve(point), unworn.reserve(point)
    reached: Sequence[Any] = [limit for _, limit in steps.under(when_unworn)] if steps else ()
    of_reserve = spread_of(reserve, reached, coverage, falling=True)
    limited: dict[tuple[RuleKind, str | None], Spread] = {(RuleKind.RESERVE, None): of_reserve}
    shape = demand_shape(model, point)
    main, pressures = now.held(point, shape)
    _, pressures_unworn = unworn.held(point, shape)
    below = _below(projection, main, now.pressures["p_g"], limits, coverage)
    if below is not None:
        limited[RuleKind.PERMISSIBLE_PRESSURE, None] = below
    losses = [limit for _, limit in limits.circuit_loss.levels] if limits.circuit_loss else []
    circuits = {}
    for name in (state.circuit.id for state in projection.circuits if not state.vented):
        pressure, before = (spread_over(each[name], main.shape) for each in (pressures, pressures_unworn))
        circuits[name] = interval_of(pressure, coverage)
        limited[RuleKind.CIRCUIT_LOSS, name] = spread_of(np.abs(before - pressure), losses, coverage)
    main_pressure = interval_of(main / now.pressures["p_g"] * point.main_pressure, coverage)
    return PressureSpread(of_reserve.interval, main_pressure, circuits, limited)


def _below(projection: Projection, main: np.ndarray, required: Any, limits: Limits, coverage: float) -> Spread | None:
    """Return how far the line pressure that holds is below the permissible.

    What is required is required: how well it is known does not count, only how much of it holds.
    """
    permissible = projection.permissible
    steps = None if permissible is None else permissible_steps(permissible, limits)
    if permissible is None or permissible.low is None or steps is None:
        return None
    stated = projection.condition.main_pressure
    below = 1.0 - main / required * stated / max(min(permissible.low, stated), 1.0)
    tiny = 1e-9  # a pressure that equals the permissible is not below it
    return spread_of(below, [max(limit, tiny) for _, limit in steps.levels], coverage)
