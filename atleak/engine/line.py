"""Find the line pressure that holds: what is required, or what the pump keeps up against all that leaves the line.

The pump delivers what it displaces less its slip. Out of the line go what the gaps and leaks draw, through the circuits
or not, and the consumers, but for those behind the line's regulator: these get what is left over and starve first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.engine.balance import Balance
from atleak.engine.circuits import Network
from atleak.engine.leakage import PumpFlow

LINE = "p_g"  # the section that supplies all others
_ROOT = 1e-13  # relative width of the bracket of a line pressure at which the search ends
_STEPS = 200  # of it at the most
SURELY_LESS = 1e-9  # relative: a pressure that is lower than another by more than rounding


@dataclass(frozen=True)
class Held:
    """The line pressure that holds, and all pressures with it; arrays where anything was one."""

    main_pressure: Any  # [Pa]
    required: Any  # [Pa]
    balance: Balance  # at the pressure that holds
    converged: Any

    @property
    def falls(self) -> Any:
        """Return whether less holds than is required."""
        return self.main_pressure < self.required * (1.0 - SURELY_LESS)


def sections_held(controller: Controller, main_pressure: Any, converter_pressure: Any) -> dict[str, Any]:
    """Return the pressures of the sections [Pa], none of them above the line that supplies it."""
    sections = controller.section_pressures(main_pressure, converter_pressure)
    return {name: np.minimum(pressure, main_pressure) for name, pressure in sections.items()}


def consumed(controller: Controller, point: OperatingPoint, *, after_line: bool | None = None) -> float:
    """Return what the consumers take at an operating point [m³/s]: all, or those behind the line or those before it."""
    chosen = (each for each in controller.consumers if after_line is None or each.after_line is after_line)
    return sum(each.at(point) for each in chosen)


def hold(network: Network, point: OperatingPoint, pump: PumpFlow, dynamic_viscosity: Any) -> Held:
    """Find the line pressure that holds in a network at an operating point, coming down from the required one.

    Parameters
    ----------
    network
        of the gear of ``point``; its conductances may be arrays.
    pump, dynamic_viscosity
        the pump, and μ [Pa·s] of the fluid for its slip.

    Returns
    -------
    Held
        with the point's main pressure where the network does not solve.
    """
    controller, required = network.controller, point.main_pressure
    if not network.solves:
        balance = network.balance(controller.section_pressures(required, point.converter_pressure))
        return Held(required, required, balance, True)
    before_line = consumed(controller, point, after_line=False)

    def at(main: Any) -> tuple[Balance, Any]:
        balance = network.balance(sections_held(controller, main, point.converter_pressure))
        supply = pump.capacity(point.engine_speed, main, dynamic_viscosity)
        return balance, network.drawn_from_pump(balance) + before_line - supply

    balance, lacking = at(required)
    main = np.full(np.shape(lacking), float(required)) if np.ndim(lacking) else float(required)
    converged: Any = balance.converged
    if np.any(lacking > 0.0):
        most = _where_balanced(lambda main: at(main)[1], main, lacking)
        main = np.where(lacking > 0.0, most, main) if np.ndim(lacking) else most
        balance = at(main)[0]
    if controller.line is not None and controller.line.following is not None:
        main, balance, settled = _following(network, point, main, balance, lambda main: at(main)[0])
        converged = converged & settled
    return Held(main, required, balance, converged & balance.converged)


def _where_balanced(lacking: Any, main: Any, at_main: Any) -> Any:
    """Return the pressure at which nothing is lacking [Pa]: by false position, with Illinois' halving (Dowell 1971).

    What is lacking rises with the pressure. Where something is lacking even without pressure the result is zero.
    """
    high, f_high = np.array(main, float), np.array(at_main, float)
    low = np.zeros_like(high)
    f_low = np.array(np.broadcast_to(lacking(low if low.ndim else 0.0), high.shape), float)
    open_ = (f_high > 0.0) & (f_low < 0.0)
    for step in range(_STEPS):
        if not open_.any():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            guess = high - f_high * (high - low) / (f_high - f_low)
        guess = np.where(open_ & (step % 8 < 7), guess, 0.5 * (low + high))  # now and then by halves, whatever it does
        guess = np.where(open_ & np.isfinite(guess), guess, low)
        f = np.array(np.broadcast_to(lacking(guess if guess.ndim else float(guess)), high.shape), float)
        over = f > 0.0
        f_low = np.where(over, 0.5 * f_low, f)
        f_high = np.where(over, f, 0.5 * f_high)
        high, low = np.where(over, guess, high), np.where(over, low, guess)
        open_ = open_ & (high - low > _ROOT * high) & (f != 0.0)
    return low if low.ndim else float(low)


def _following(
    network: Network, point: OperatingPoint, main: Any, balance: Balance, at: Any
) -> tuple[Any, Balance, Any]:
    """Bring the line down to its set pressure where that follows a circuit, which the line itself may feed."""
    line = network.controller.line
    assert line is not None
    for _ in range(_STEPS):
        lower = np.minimum(main, line.with_pressures(point, balance.pressures))
        settled = main - lower <= _ROOT * np.maximum(main, 1.0)
        main = lower if np.ndim(lower) else float(lower)
        if np.all(settled):
            return main, balance, True
        balance = at(main)
    return main, balance, settled
