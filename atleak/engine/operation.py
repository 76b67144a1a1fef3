"""Find the line pressure that holds: what is required, or what the pump keeps up against all that leaves the line.

The pump delivers what it displaces less its slip. Out of the line go what the gaps and leaks draw, through the circuits
or not, and the consumers; those behind the line's regulator get what is left over and starve first. Units with some of
their lands repaired are computed for several choices at once.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.circuits import SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.engine.balance import Balance
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.network import Network
from atleak.engine.restrictions import Branch, GapBranch

LINE = "p_g"  # the section that supplies all others
_EXACT = 1e-12  # of the pressure, or of the flow that is lacking: at which a search for the line pressure ends
_STEPS = 200  # of it at the most
_LEAST = 1.0  # [Pa] that no required pressure is below
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


@dataclass(frozen=True)
class Operation:
    """A unit at one condition, or at many of them at once: arrays of one shape wherever anything was one."""

    model: LeakageModel
    point: OperatingPoint
    network: Network
    viscosity: Any  # [Pa·s]

    @classmethod
    def of(
        cls, model: LeakageModel, point: OperatingPoint, temperature: Any = None, network: Network | None = None
    ) -> Operation:
        """Return a unit at a condition.

        Parameters
        ----------
        temperature
            [°C] in place of the condition's; arrays, like clearances that are arrays, give arrays.
        network
            that of the condition, where its gaps are others than the model's.
        """
        given = network or model.network(point, temperature)
        return cls(
            model, point, given, model.dynamic_viscosity(point.temperature if temperature is None else temperature)
        )

    @cached_property
    def sections(self) -> dict[str, Any]:
        """Return the pressures of the sections at the required line pressure [Pa]."""
        return self.model.controller.section_pressures(self.point.main_pressure, self.point.converter_pressure)

    @cached_property
    def demanded(self) -> Balance:
        """Return the balance of the circuits at the required line pressure."""
        return self.network.balance(self.sections)

    @cached_property
    def leakage(self) -> Any:
        """Return what is drawn from the pump at the required line pressure [m³/s]."""
        return self.network.drawn_from_pump(self.demanded)

    @cached_property
    def held(self) -> Held:
        """Return the line pressure that holds, and all pressures with it."""
        return held_pressure(self.network, self.point, self.model.pump, self.viscosity, self.demanded)

    def pressures(self, names: Iterable[str], shape: tuple[int, ...]) -> dict[str, np.ndarray]:
        """Return what the line, as p_g, and some circuits hold [Pa], arrays of a shape."""
        held = {LINE: self.held.main_pressure} | {name: self.held.balance.pressures[name] for name in names}
        return {name: spread_over(pressure, shape) for name, pressure in held.items()}


def spread_over(value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return numbers as an array of a shape."""
    return np.broadcast_to(np.asarray(value, float), shape)


def sections_held(controller: Controller, main_pressure: Any, converter_pressure: Any) -> dict[str, Any]:
    """Return the pressures of the sections [Pa], none of them above the line that supplies it."""
    sections = controller.section_pressures(main_pressure, converter_pressure)
    return {name: np.minimum(pressure, main_pressure) for name, pressure in sections.items()}


def wanted(network: Network, main: Any, required: Any, *, after_line: bool | None = None) -> dict[str, Any]:
    """Return what each consumer takes at a line pressure [m³/s], by id: of all, those behind the line or those before.

    One before the line's regulator is an orifice, ``Q = Q₁ √(p_g/p₁)``, unless its law is constant or no pressures are
    solved; one behind it takes Q₁ as long as so much is left.

    Parameters
    ----------
    main, required
        the line pressure, and the one required there [Pa], which is p₁ unless the consumer states its own; arrays of
        one shape where anything is one.
    """
    flows: dict[str, Any] = {}
    for each in network.controller.consumers:
        if after_line is None or each.after_line is after_line:
            flow: Any = each.at(network.point)
            if network.solves and each.law == "orifice" and not each.after_line:
                stated_at = required if each.pressure is None else each.pressure
                flow = flow * np.sqrt(main / np.maximum(stated_at, _LEAST))
            flows[each.id] = flow
    return flows


def consumed(network: Network, main: Any, required: Any, *, after_line: bool | None = None) -> Any:
    """Return what the consumers take together [m³/s], as `wanted` tells for each."""
    return sum(wanted(network, main, required, after_line=after_line).values())


def held_pressure(
    network: Network, point: OperatingPoint, pump: PumpFlow, dynamic_viscosity: Any, near: Balance | None = None
) -> Held:
    """Find the line pressure that holds in a network at an operating point, coming down from the required one.

    Parameters
    ----------
    network
        of the gear of ``point``; its conductances may be arrays.
    pump, dynamic_viscosity
        the pump, and μ [Pa·s] of the fluid for its slip.
    near
        the network's balance at or near the required line pressure, where it is known: the search starts from it.

    Returns
    -------
    Held
        with the point's main pressure where the network does not solve.
    """
    controller, required = network.controller, point.main_pressure
    if not network.solves:
        balance = network.balance(controller.section_pressures(required, point.converter_pressure))
        return Held(required, required, balance, True)

    def at(main: Any, near: Balance | None) -> Balance:
        return network.balance(sections_held(controller, main, point.converter_pressure), near)

    def lacking(main: Any, balance: Balance) -> Any:
        supply = pump.capacity(point.engine_speed, main, dynamic_viscosity)
        return network.drawn_from_pump(balance) + consumed(network, main, required, after_line=False) - supply

    first = balance = at(required, near)
    lacks = lacking(required, first)
    main = np.full(np.shape(lacks), float(required)) if np.ndim(lacks) else float(required)
    if np.any(lacks > 0.0):

        def lacking_at(main: Any) -> Any:
            nonlocal balance  # each is near to the one before it, and the same where the search has ended
            balance = at(main, balance)
            return lacking(main, balance)

        at_zero = lacking(0.0 * main, at(0.0 * main, first))
        main = _where_balanced(lacking_at, main, lacks, at_zero)
        balance = at(main, balance)
    converged: Any = True
    if controller.line is not None and controller.line.following is not None:
        main, balance, converged = fall_to_set_pressure(controller.line, point, main, balance, at)
    return Held(main, required, balance, converged & np.asarray(balance.converged))


def _where_balanced(lacking: Callable[[Any], Any], main: Any, at_main: Any, at_zero: Any) -> Any:
    """Return the pressure at which nothing is lacking [Pa], by false position with Illinois' halving.

    What is lacking rises with the pressure (Dowell & Jarratt, BIT 11, 1971). Where nothing is lacking at the highest
    pressure that one is the result; zero where something is even without pressure.
    """
    high, f_high = np.atleast_1d(np.array(main, float)), np.atleast_1d(np.array(at_main, float))
    low = np.zeros_like(high)

    def at(pressure: np.ndarray) -> np.ndarray:
        return np.broadcast_to(lacking(pressure if np.ndim(main) else pressure.item()), pressure.shape)

    f_low = np.broadcast_to(at_zero, high.shape).copy()
    root = np.where(f_high <= 0.0, high, low)
    exact = _EXACT * (f_high - f_low)
    open_, side = (f_high > 0.0) & (f_low < 0.0), np.zeros_like(high)
    for _ in range(_STEPS):
        if not open_.any():
            break
        guess = high - f_high * (high - low) / np.where(open_, f_high - f_low, 1.0)
        root = np.where(open_, guess, root)
        f = at(root)
        over = f > 0.0
        f_low = np.where(over, np.where(side > 0.0, 0.5 * f_low, f_low), f)
        f_high = np.where(over, f, np.where(side < 0.0, 0.5 * f_high, f_high))
        high, low, side = np.where(over, root, high), np.where(over, low, root), np.where(over, 1.0, -1.0)
        open_ &= (high - low > _EXACT * high) & (np.abs(f) > exact)
    return root if np.ndim(main) else root.item()


def fall_to_set_pressure(
    line: SetPressure,
    point: OperatingPoint,
    main: Any,
    balance: Balance,
    at: Callable[[Any, Balance], Balance],
    factor: Any = 1.0,
) -> tuple[Any, Balance, Any]:
    """Bring the line down to its set pressure where that follows a circuit, which the line itself may feed.

    Parameters
    ----------
    main, balance
        the line pressure that the pump holds [Pa], and the balance there.
    at
        gives the balance at a lower line pressure, near to another one.
    factor
        on the set pressure, where that is uncertain.

    Returns
    -------
    tuple
        the line pressure [Pa], the balance there, and whether the search came to its end.

    Notes
    -----
    The line falls until its set pressure falls no more. Secants hasten this; where one leads too far, the line falls
    to its set pressure and no further. A circuit's pressure rises ever less with that of the line, so that hardly one
    does.
    """
    one, highest = np.ndim(main) == 0, np.asarray(main, float)

    def set_pressure(balance: Balance) -> Any:
        return np.minimum(line.with_pressures(point, balance.pressures) * factor, highest)

    before: tuple[Any, Any] | None = None
    main, slope = highest, np.asarray(np.inf)
    plain = lower = set_pressure(balance)
    for _ in range(_STEPS):
        settled = np.abs(main - lower) <= _EXACT * np.maximum(main, 1.0)
        if np.all(settled):
            break
        too_far = ~settled & (lower > main)
        if before is not None:
            moved = before[0] - main
            slope = np.where(moved > 0.0, (before[1] - lower) / np.where(moved > 0.0, moved, 1.0), np.inf)
        with_secant = ~too_far & (slope < 1.0)
        secant = main - (main - lower) / np.where(with_secant, 1.0 - slope, 1.0)
        target = np.where(too_far, plain, np.where(with_secant, np.clip(secant, 0.0, lower), lower))
        before, plain = (main, lower), np.where(too_far, plain, lower)
        main = np.where(settled, main, target)
        balance = at(main.item() if one else main, balance)
        lower = set_pressure(balance)
    return main.item() if one else main, balance, settled


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
        """Return a unit whose models differ in their clearances, the unit as it is first."""
        return cls(models[0], point, tuple(model.network(point) for model in models))

    @cached_property
    def keys(self) -> tuple[LandKey, ...]:
        """Return the land of every gap of the network."""
        return tuple(gap.key for gap in self.model.gaps_in(self.point.gear))

    @cached_property
    def gaps_of(self) -> Mapping[LandKey, Sequence[Branch[GapBranch]]]:
        """Return the gaps of every land in every state at once: arrays of shape (states,)."""
        network = self.network([dict.fromkeys(self.keys, state) for state in range(len(self.networks))])
        gaps: dict[LandKey, list[Branch[GapBranch]]] = {}
        for key, gap in zip(self.keys, network.lands, strict=True):
            gaps.setdefault(key, []).append(gap)
        return gaps

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
        restricted = (GapBranch(*each) for each in zip(conductances, bends, strict=True))
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
    """Compute a unit at one condition, for several choices of lands that are as in ``new``, where every land is."""
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
