"""Split the pressure that is missing, and what the pump has to deliver more than when new, by what causes it.

For one pressure at one condition let p(S) be what the engine holds there with the parts in S made new and all else as
it is. The parts on its way (pump, line setting, lands of the line, of its own circuit, of its supply, of all other
circuits) share what is lost between p(∅) and p(all) as Shapley (Contributions to the Theory of Games II, 1953) shares
a game: each gets what it adds, averaged over all orders in which the parts can be made new,

    φ_i = Σ over S not holding i of |S|! (n − |S| − 1)! / n! · (p(S ∪ i) − p(S)),        Σ φ_i = p(all) − p(∅).

Within a part its lands share by what each leaks more than when new. What a gauge shows beyond p(∅) is unexplained.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LandStates, Operation
from atleak.equations.statistics import normal_quantile


class Cause(StrEnum):
    """What can cost a pressure."""

    PUMP = "pump"
    LINE_SETTING = "line_setting"  # the pressure that the line follows has fallen
    LANDS = "lands"
    CLUTCH_SEAL = "clutch_seal"
    UNEXPLAINED = "unexplained"  # none of what was measured: a regulator that sticks, filter, level
    NONE = "none"


Row = tuple[Cause, str | None]  # with the id of its circuit; None of the pump and of lands on the line itself
PUMP_PART, _SETTING, _LINE, _OWN, _SUPPLY, _OTHERS = "pump", "setting", "line", "own", "supply", "others"
_ORDER = _OWN, _SETTING, _SUPPLY, _LINE, _OTHERS  # a land of several belongs to the first
SURE_OF_A_SEAL = 0.95  # probability from which on a clutch's seal is called worn
PUMP_ROW: Row = (Cause.PUMP, None)

#: [Pa, m³/s] of a tap and of the demand on the pump with some parts made new, shapes (sets, draws).
Made = Callable[[Sequence[frozenset[str]]], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Path:
    """What can cost the pressure of a tap in one gear: the lands of each part, and the circuit each belongs to."""

    tap: str  # the line, as p_g, or the id of a circuit
    parts: Mapping[str, tuple[LandKey, ...]]  # the pump has no land
    circuits: Mapping[LandKey, str | None]

    @classmethod
    def of(cls, controller: Controller, gear: int, tap: str) -> Path:
        """Return the parts on the way of a tap, the pump always among them."""
        following = controller.line.following if controller.line is not None else None
        followed = following.section if following is not None else None
        supply = _supply(controller, tap)
        fed = {circuit.id for circuit in controller.circuits}
        found: dict[LandKey, tuple[int, str | None]] = {}
        for gap in controller.gaps:
            if gear not in gap.gears:
                continue
            touched = [each.section for each in (gap.high, gap.low) if each.section in fed]
            ways: dict[str, Sequence[str | None]] = {
                _OWN: [tap],
                _SETTING: [followed],
                _SUPPLY: supply,
                _OTHERS: touched,
            }
            circuit, part = next(
                ((each, name) for name, ids in ways.items() for each in touched if each in ids), (None, _LINE)
            )
            known = found.get(gap.key)
            if known is None or _ORDER.index(part) < known[0]:
                found[gap.key] = _ORDER.index(part), circuit
        parts = {name: tuple(key for key, (place, _) in found.items() if _ORDER[place] == name) for name in _ORDER}
        kept = {name: lands for name, lands in parts.items() if lands}
        return cls(tap, {PUMP_PART: (), **kept}, {key: circuit for key, (_, circuit) in found.items()})

    def without(self, same: Iterable[LandKey], *, pump: bool) -> Path:
        """Return it without the lands that are as when new, and without the pump where that is."""
        left = set(self.circuits) - set(same)
        parts = {name: tuple(key for key in lands if key in left) for name, lands in self.parts.items()}
        kept = {name: lands for name, lands in parts.items() if lands or (name == PUMP_PART and pump)}
        return replace(self, parts=kept)

    @property
    def nearest(self) -> tuple[LandKey, ...]:
        """Return the lands of the circuit itself; of the line those on it, and of what it follows."""
        return self.parts.get(_OWN) or (*self.parts.get(_LINE, ()), *self.parts.get(_SETTING, ()))

    def row(self, part: str, land: LandKey | None = None) -> Row:
        """Return the row that a part, or one of its lands, counts in."""
        if part == PUMP_PART:
            return PUMP_ROW
        return Cause.LINE_SETTING if part == _SETTING else Cause.LANDS, self.circuits[land] if land else None

    def lands_of(self, made: Iterable[str]) -> frozenset[LandKey]:
        """Return the lands of some parts."""
        return frozenset(key for name in made for key in self.parts[name])


def _supply(controller: Controller, tap: str) -> list[str]:
    """Return the circuits that feed a tap's circuit, or that its set pressure follows, and those that feed them."""
    by_id = {circuit.id: circuit for circuit in controller.circuits}
    found: list[str] = []
    waiting = [tap]
    while waiting:
        circuit = by_id.get(waiting.pop())
        if circuit is None:
            continue
        stated = circuit.set_pressure.following if circuit.set_pressure is not None else None
        near = [*(feed.source for feed in circuit.feeds), *([stated.section] if stated is not None else [])]
        new = [each for each in near if each in by_id and each not in (*found, tap)]
        found += new
        waiting += new
    return found


@dataclass(frozen=True, eq=False)
class Split:
    """What each row costs a pressure, and adds to the demand on the pump, in each draw; arrays of shape (draws,)."""

    path: Path
    new: np.ndarray  # [Pa] that is held with every cause new
    now: np.ndarray  # [Pa] that is held as measured
    rows: Mapping[Row, np.ndarray]  # [Pa]
    lands: Mapping[Row, Mapping[LandKey, np.ndarray]]  # [Pa]; parts of their row
    flows: Mapping[Row, np.ndarray]  # [m³/s]
    flows_of_lands: Mapping[Row, Mapping[LandKey, np.ndarray]]  # [m³/s]
    growth: np.ndarray  # [m³/s] of the demand over new
    seal: np.ndarray | float = 0.0  # [Pa] that the clutch's own seal costs, beside the parts of the path
    seal_worn: float = 0.0  # probability that it is worn


def split(path: Path, made: Made, excess: Mapping[LandKey, np.ndarray]) -> Split:
    """Split what a tap has lost among the parts of its path, in rows that add up to it.

    Parameters
    ----------
    path
        the parts; with at most six of them 64 sets are asked for.
    made
        what the tap holds [Pa], and what the pump has to deliver [m³/s], with some parts made new.
    excess
        what each land leaks more than when new, at the pressures that are held [m³/s]; shape (draws,).
    """
    parts = tuple(path.parts)
    sets = [frozenset(each for at, each in enumerate(parts) if number >> at & 1) for number in range(1 << len(parts))]
    pressure, demand = made(sets)
    rows: dict[Row, np.ndarray] = {}
    flows: dict[Row, np.ndarray] = {}
    lands: dict[Row, dict[LandKey, np.ndarray]] = {}
    flows_of_lands: dict[Row, dict[LandKey, np.ndarray]] = {}
    for at, part in enumerate(parts):
        cost, drawn = _shapley(pressure, at), -_shapley(demand, at)
        if part == PUMP_PART:
            rows[PUMP_ROW], flows[PUMP_ROW] = cost, drawn
            continue
        for key, fraction in _fractions(path.parts[part], excess).items():
            row = path.row(part, key)
            for total, of_lands, value in ((rows, lands, cost), (flows, flows_of_lands, drawn)):
                total[row] = total.get(row, 0.0) + fraction * value
                of_lands.setdefault(row, {})[key] = fraction * value
    return Split(path, pressure[-1], pressure[0], rows, lands, flows, flows_of_lands, demand[0] - demand[-1])


def _shapley(values: np.ndarray, part: int) -> Any:
    """Return what one part adds, averaged over all orders; ``values`` by sets as binary numbers, the draws behind."""
    count = len(values).bit_length() - 1
    total: Any = 0.0
    for number in range(len(values)):
        if not number >> part & 1:
            size = number.bit_count()
            weight = math.factorial(size) * math.factorial(count - size - 1) / math.factorial(count)
            total = total + weight * (values[number | 1 << part] - values[number])
    return total


def _fractions(lands: Sequence[LandKey], excess: Mapping[LandKey, np.ndarray]) -> dict[LandKey, np.ndarray]:
    """Return which fraction of their part's cost each land has: by what it leaks more than when new, else alike."""
    more = np.array([np.maximum(excess[key], 0.0) for key in lands])
    total = more.sum(axis=0)
    fractions = np.where(total > 0.0, more / np.where(total > 0.0, total, 1.0), 1.0 / len(lands))
    return dict(zip(lands, fractions, strict=True))


def split_as_measured(model: LeakageModel, new: LeakageModel, point: OperatingPoint, tap: str) -> Split:
    """Split what a tap of a unit has lost at one condition, everything at its best estimate: one draw.

    Parameters
    ----------
    model, new
        of the unit as measured, and as it was when new, its pump too.
    """
    path = Path.of(model.controller, point.gear, tap)
    widths = [{each.land.key: each for each in of.clearances} for of in (model, new)]
    same = [key for key in path.circuits if _alike(*(each[key] for each in widths))]
    path = path.without(same, pump=model.controller.pump != new.controller.pump)
    states = LandStates.of((model, new), point)
    with_new_pump = replace(states, model=replace(model, controller=new.controller))

    def made(sets: Sequence[frozenset[str]]) -> tuple[np.ndarray, np.ndarray]:
        pressure, demand = np.empty(len(sets)), np.empty(len(sets))
        for pump, each in ((False, states), (True, with_new_pump)):
            here = [number for number, chosen in enumerate(sets) if (PUMP_PART in chosen) is pump]
            if here:
                held = each.repaired([dict.fromkeys(path.lands_of(sets[number]), 1) for number in here])
                pressure[here] = held.pressures[tap]
                slip = each.model.pump_slip(point.main_pressure, point.temperature)
                demand[here] = held.leakage + slip
        return pressure[:, None], demand[:, None]

    held, networks = Operation.of(model, point).held.balance.pressures, [states.networks[0], states.networks[1]]
    excess: dict[LandKey, Any] = {}
    for key, *branches in zip(states.keys, *(each.lands for each in networks), strict=True):
        more = networks[0].flow(branches[0], held) - networks[1].flow(branches[1], held)
        excess[key] = excess.get(key, 0.0) + np.array([float(more)])
    return split(path, made, excess)


def _alike(now: Any, new: Any) -> bool:
    return bool(now.radial_clearance == new.radial_clearance and now.form_moments == new.form_moments)


@cache
def _spread_evenly(draws: int) -> np.ndarray:
    """Return standard deviates at even steps of probability, in an order that nothing else follows."""
    return np.asarray(normal_quantile((np.random.default_rng(draws).permutation(draws) + 0.5) / draws))


class Amount(NamedTuple):
    """A number with its 95 % interval, which is open where nobody measured the pressure."""

    value: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, eq=False)
class Missing:
    """What is missing of one pressure at one condition, and what explains it."""

    point: OperatingPoint
    tap: str  # the line, as p_g, or the id of a circuit
    split: Split  # by draws, or everything at its best estimate: one draw
    measured: float | None = None  # [Pa]; None where nobody measured it: what it holds by the clearances is taken
    seconds: float | None = None  # for which a log showed it; None of a gauge
    best: Split | None = None  # at its best estimate, beside draws of what nobody measured
    error: float = 0.0  # [Pa] standard uncertainty of what was measured
    doubted: bool = False  # other gauges contradict what was measured: it tells of no part

    @cached_property
    def missing(self) -> np.ndarray:
        """Return what is missing in each draw [Pa]; the gauge errs in each by itself."""
        if self.measured is None:
            return np.asarray(self.split.new - self.split.now)
        errs = self.error * _spread_evenly(len(self.split.new)) if self.error else 0.0
        return np.asarray(self.split.new - self.measured - errs)

    @property
    def expected(self) -> float:
        """Return what is held with every cause new [Pa]."""
        return self.amount(lambda each: each.split.new).value

    @cached_property
    def rows(self) -> Mapping[Row, np.ndarray]:
        """Return what each row explains [Pa], the largest first; a seal only where it is surely worn."""
        rows = dict(self.split.rows)
        if self.split.seal_worn >= SURE_OF_A_SEAL and not self.doubted:
            rows[Cause.CLUTCH_SEAL, self.tap] = np.asarray(self.split.seal)
        flows = self.split.flows

        def cost(row: Row) -> tuple[float, float]:
            return float(np.mean(rows[row])), float(np.mean(flows.get(row, 0.0)))

        return {row: rows[row] for row in sorted(rows, key=cost, reverse=True)}

    @cached_property
    def unexplained(self) -> np.ndarray:
        """Return what of it no row explains [Pa]."""
        return np.asarray(self.missing - sum(self.rows.values(), np.zeros_like(self.missing)))

    def of_row(self, row: Row, land: LandKey | None = None) -> np.ndarray:
        """Return what a row, or one of its lands, explains [Pa]."""
        values = self.rows.get(row) if land is None else self.split.lands.get(row, {}).get(land)
        return np.zeros_like(self.missing) if values is None else values

    def flow_of(self, row: Row, land: LandKey | None = None) -> np.ndarray:
        """Return what a row, or one of its lands, adds to the demand on the pump [m³/s]."""
        split = self.split
        values = split.flows.get(row) if land is None else split.flows_of_lands.get(row, {}).get(land)
        return np.zeros_like(self.missing) if values is None else values

    def of(self, cause: Cause) -> np.ndarray:
        """Return what a cause explains over all its rows [Pa]."""
        if cause is Cause.UNEXPLAINED:
            return self.unexplained
        rows = [values for (each, _), values in self.rows.items() if each is cause]
        return np.asarray(sum(rows, np.zeros_like(self.missing)))

    def lands_behind(self, allowed: float) -> list[LandKey]:
        """Return the fewest lands without whose wear only so much [Pa] is missing; none where that takes more."""
        lands = [each for of_row in self.split.lands.values() for each in of_row.items()]
        behind, left = [], float(np.mean(self.missing)) - allowed
        for key, values in sorted(lands, key=lambda each: -float(np.mean(each[1]))):
            if left > 0.0:
                behind.append(key)
                left -= float(np.mean(values))
        return behind if left <= 0.0 else []

    def amount(self, of: Callable[[Missing], np.ndarray]) -> Amount:
        """Return a quantity: at its best estimate, or the mean of its draws, with its interval.

        Parameters
        ----------
        of
            gives it [Pa, m³/s] in each draw of a pressure like this one, shape (draws,).
        """
        values = of(self)
        value = float(np.mean(values if self.best is None else of(replace(self, split=self.best, best=None))))
        if values.size < 2:
            return Amount(value)
        low, high = np.quantile(values, (0.025, 0.975)).tolist()
        return Amount(value, min(low, value), max(high, value))
