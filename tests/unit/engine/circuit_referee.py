"""A referee for the balance of circuits: every flow by its own formula, one circuit after the other, from above.

It shares nothing with the solver but the network's description.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq, root

from atleak.catalogue.circuits import Circuit, Feed, Following, Pressure, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.network import Network
from atleak.engine.restrictions import Branch, GapBranch, Orifice

VISCOSITY, DENSITY = 6.2e-6, 797.0  # [m²/s, kg/m³]
DRAIN = Pressure(0.0, None)


def line(sections: str | Pressure) -> Pressure:
    return sections if isinstance(sections, Pressure) else Pressure(1.0, sections)


def gap(high: str | Pressure, low: str | Pressure, conductance: Any, bend: Any = 0.0) -> Branch[GapBranch]:
    """A gap as a controller's file would give it: into the sump unless it ends in a whole section."""
    low = line(low)
    into = low.section if low.is_section else None
    return Branch(line(high), low, GapBranch(conductance, bend), into, into is None)


def hole(high: str | Pressure, low: str | Pressure, flow: float, drop: float) -> Branch[Orifice]:
    """A leak through a hole, known by one flow at one drop."""
    low = line(low)
    into = low.section if low.is_section else None
    return Branch(line(high), low, Orifice(flow / math.sqrt(drop), 1e-3), into, into is None)


def orifice(diameter: float, discharge: float = 0.62) -> Orifice:
    """K = C_d A √(2/ρ) and Δp_cr = π ρ / (8 A) · (ν 150 / C_d)²."""
    area = math.pi * diameter**2 / 4.0
    transition = math.pi * DENSITY / (8.0 * area) * (VISCOSITY * 150.0 / discharge) ** 2
    return Orifice(discharge * area * math.sqrt(2.0 / DENSITY), transition)


@dataclass
class Builder:
    """Circuits and branches, put together to a network."""

    controller: Controller
    point: OperatingPoint
    circuits: list[Circuit] = field(default_factory=list)
    branches: list[Branch[GapBranch]] = field(default_factory=list)
    leaks: list[Branch[Any]] = field(default_factory=list)
    feeds: list[Branch[Orifice]] = field(default_factory=list)

    def circuit(
        self, name: str, *feeds: tuple[str, float], limit: SetPressure | float | None = None, vented: bool = False
    ) -> None:
        """Add a circuit with its feeds (source, diameter)."""
        stated = SetPressure(number=limit) if isinstance(limit, float) else limit
        gears = frozenset({self.point.gear + 1} if vented else {self.point.gear})
        through = tuple(Feed(source, diameter, 0.62) for source, diameter in feeds)
        self.circuits.append(Circuit(name, name, gears, through, stated, "test"))
        if not vented:
            self.feeds += [
                Branch(line(source), line(name), orifice(diameter), name, False) for source, diameter in feeds
            ]

    def network(self) -> Network:
        controller = replace(self.controller, circuits=tuple(self.circuits))
        return Network(controller, self.point, tuple(self.branches), tuple(self.leaks), tuple(self.feeds), True)


def random_sections(rng: np.random.Generator) -> dict[str, float]:
    main = float(rng.uniform(1e5, 2e6))
    return {
        "p_g": main,
        "p_s": float(rng.uniform(0, main)),
        "p_m": 0.5 * main,
        "p_k": float(rng.uniform(0, 1.1 * main)),
    }


def random_builder(controller: Controller, point: OperatingPoint, seed: int, scale: float = 1.0) -> Builder:
    """One to six circuits, fed by the line and by one another, with every kind of set pressure and leak."""
    rng = np.random.default_rng(seed)
    builder = Builder(controller, point)

    def conductance() -> float:
        kind = rng.random()
        size = 10.0 ** rng.uniform(-13.5, -10.0)
        return float(0.0 if kind < 0.1 else 1e3 * size if kind > 0.9 else size) * scale

    def bend() -> float:
        return float(rng.choice([0.0, 10.0 ** rng.uniform(-9, -5)]))

    count = int(rng.integers(1, 7))
    names = [f"c{number}" for number in range(count)]
    for number, name in enumerate(names):
        sources = ["p_g", "p_g", "p_g", "p_s", "p_k", *names[:number]]
        feeds = [(str(rng.choice(sources)), float(rng.uniform(0.3e-3, 2.5e-3))) for _ in range(rng.integers(1, 4))]
        kind, pressure = rng.random(), float(rng.uniform(0.0, 1.2e6))
        limit: SetPressure | float | None = None
        if kind < 0.2:
            limit = pressure
        elif kind < 0.3:
            limit = SetPressure(gears={point.gear: pressure})
        elif kind < 0.4:
            limit = SetPressure(points={point.name: pressure})
        elif kind < 0.5:
            limit = SetPressure(currents=((0.0, 2.0), (pressure, 0.0)))
        elif kind < 0.6:
            followed = str(rng.choice(["p_g", "p_k", *names[:number]]))
            limit = SetPressure(following=Following(followed, float(rng.uniform(0, 1)), float(rng.uniform(-1e5, 2e5))))
        if limit is not None and rng.random() < 0.15:
            feeds = []
        builder.circuit(name, *feeds, limit=limit, vented=rng.random() < 0.1)
        for _ in range(rng.integers(0, 4)):
            low = [DRAIN, DRAIN, Pressure(0.0, None, 35e3), Pressure(0.1, "p_g"), "p_k", "p_s"][rng.integers(6)]
            builder.branches.append(gap(name, low, conductance(), bend()))
        if rng.random() < 0.3:
            builder.branches.append(gap(str(rng.choice(["p_g", "p_k"])), name, conductance(), bend()))
        if rng.random() < 0.3:
            builder.leaks.append(gap(name, DRAIN, conductance()))
        if rng.random() < 0.3:
            builder.leaks.append(hole(name, DRAIN, 10.0 ** rng.uniform(-9, -5.5), 4e5))
        if rng.random() < 0.2:
            builder.branches.append(gap(Pressure(0.5, name), DRAIN, conductance(), bend()))
    for _ in range(rng.integers(0, 4)):
        one, other = (str(name) for name in rng.choice(names, 2))
        if one != other:
            builder.branches.append(gap(one, other, conductance(), bend()))
            if rng.random() < 0.3:
                builder.branches.append(gap(one, Pressure(0.3, other), conductance()))
    builder.branches.append(gap("p_g", DRAIN, 1e-12))
    builder.branches.append(gap("p_g", "p_s", 1e-12))
    return builder


class Referee:
    """The flows of a network at any pressures, in plain numbers."""

    def __init__(self, network: Network, sections: dict[str, float]) -> None:
        self.network, self.sections = network, sections
        self.circuits = {each.id: each for each in network.controller.circuits}
        self.live = [each.id for each in network.controller.circuits if network.point.gear in each.gears]
        self.vented = [name for name in self.circuits if name not in self.live]
        self.top = max(*sections.values(), 0.0)

    def through(self, restriction: GapBranch | Orifice, drop: float) -> float:
        size = abs(drop)
        if isinstance(restriction, Orifice):
            flow = restriction.coefficient * size / (size**2 + restriction.transition**2) ** 0.25
        elif restriction.bend * size > 1e-6:  # the root of Δp = q/G + B q²/4G²
            flow = 2.0 * restriction.conductance * (math.sqrt(1.0 + restriction.bend * size) - 1.0) / restriction.bend
        else:
            flow = restriction.conductance * size * (1.0 - restriction.bend * size / 4.0)
        return math.copysign(flow, drop)

    def pressure(self, end: Pressure, pressures: dict[str, float]) -> float:
        return end.constant if end.section is None else end.coefficient * pressures[end.section]

    def flow(self, branch: Branch[Any], pressures: dict[str, float]) -> float:
        drop = self.pressure(branch.high, pressures) - self.pressure(branch.low, pressures)
        solved = {name for name in self.live if self.circuits[name].feeds}
        live = {branch.high.section, branch.low.section} & solved
        if not (live and branch.high.coefficient == branch.low.coefficient == 1.0 and branch.into is not None):
            drop = max(drop, 0.0)
        return self.through(branch.restriction, drop)

    def limit(self, name: str, pressures: dict[str, float]) -> float:
        circuit, point = self.circuits[name], self.network.point
        limit = math.inf
        if circuit.set_pressure is not None:
            following = circuit.set_pressure.following
            if following is not None:
                limit = max(following.ratio * pressures[following.section] + following.offset, 0.0)
            else:
                stated = circuit.set_pressure.at(point)
                assert stated is not None
                limit = stated
        return limit if circuit.feeds else min(limit, pressures["p_g"])

    def account(self, pressures: dict[str, float]) -> dict[str, dict[str, float]]:
        """What every section and circuit lets out and takes in at these pressures, by kind."""
        zero = dict.fromkeys([*self.sections, *self.circuits, "sump"], 0.0)
        out, inward, supply, relief, fed, surplus = (dict(zero) for _ in range(6))
        largest = 0.0
        for branch in self.network.branches:
            flow = self.flow(branch, pressures)
            largest = max(largest, abs(flow))
            out[branch.high.section or "sump"] += flow
            inward[branch.into or "sump"] += flow
        for name in reversed(self.live):  # the circuits come in the order in which they feed one another
            feeds = [
                (feed.high.section, self.through(feed.restriction, pressures[feed.high.section] - pressures[name]))
                for feed in self.network.feeds
                if feed.into == name
            ]
            need, limit = out[name] - inward[name], self.limit(name, pressures)
            forward, back = sum(max(flow, 0.0) for _, flow in feeds), sum(min(flow, 0.0) for _, flow in feeds)
            if not feeds:
                fed[name], relief[name] = max(need, 0.0), max(-need, 0.0)
                out["p_g"] += fed[name]
                continue
            supply[name] = forward + back
            surplus[name] = need - supply[name]
            part = 1.0
            if pressures[name] >= limit * (1.0 - 1e-12):
                relief[name] = max(back - need, 0.0)
                part = min(max((need - back) / forward, 0.0), 1.0) if forward else 0.0
            fed[name] = forward * part + back
            for source, flow in feeds:
                passed = flow * part if flow > 0.0 else flow
                out[source] += passed
                largest = max(largest, abs(passed))
        for name in self.vented:
            relief[name] = inward[name] - out[name]
        return {
            "out": out, "in": inward, "fed": fed, "relief": relief, "surplus": surplus, "largest": {"": largest},
        }  # fmt: skip

    def errors(self, pressures: dict[str, float]) -> dict[str, float]:
        """How far every circuit is from its balance, over the largest flow."""
        account = self.account(pressures)
        largest = account["largest"][""] or 1.0
        errors = {}
        for name in self.live:
            limit, pressure = self.limit(name, pressures), pressures[name]
            if not self.circuits[name].feeds:
                errors[name] = abs(pressure - limit) / max(limit, 1.0)
            elif pressure > limit * (1.0 + 1e-12):
                errors[name] = math.inf
            elif pressure >= limit * (1.0 - 1e-12):  # a regulator takes what is too much, and nothing else
                errors[name] = max(account["surplus"][name], 0.0) / largest
            else:
                errors[name] = abs(account["surplus"][name]) / largest
        return errors

    def from_above(self, sweeps: int = 2000) -> dict[str, float] | None:
        """Bring down one circuit after the other; None where that takes too long."""
        pressures = dict(self.sections) | dict.fromkeys(self.vented, 0.0)
        for name in self.live:
            pressures[name] = self.top
        for _ in range(sweeps):
            before = dict(pressures)
            for name in self.live:
                limit = min(self.limit(name, pressures), self.top)
                pressures[name] = self.root(name, limit, pressures) if self.circuits[name].feeds else limit
            if all(abs(pressures[name] - before[name]) <= 1e-13 * self.top for name in self.live):
                return pressures
        return None

    def root(self, name: str, highest: float, pressures: dict[str, float]) -> float:
        def surplus(pressure: float) -> float:
            return self.account({**pressures, name: pressure})["surplus"][name]

        if highest <= 0.0 or surplus(highest) <= 0.0:
            return highest
        return float(brentq(surplus, 0.0, highest, xtol=1e-9, rtol=1e-15)) if surplus(0.0) < 0.0 else 0.0

    def by_scipy(self, start: dict[str, float]) -> dict[str, float]:
        """Solve the circuits that are under their set pressure at once, the others at it."""
        free = [
            name
            for name in self.live
            if self.circuits[name].feeds and start[name] < self.limit(name, start) * (1.0 - 1e-9)
        ]
        pressures = dict(start)

        def surpluses(values: np.ndarray) -> list[float]:
            pressures.update(zip(free, values * self.top, strict=True))
            for name in self.live:
                if name not in free:
                    pressures[name] = self.limit(name, pressures)
            account = self.account(pressures)
            return [account["surplus"][name] / account["largest"][""] for name in free]

        solution = root(surpluses, [start[name] / self.top for name in free], tol=1e-13)
        surpluses(solution.x)
        return pressures
