"""Units of which nothing was opened: what they may be like, what gauges show on them, and what can be known of them.

Units are drawn from what `Assumptions` states of a unit before any gauge is read; the engine solves them, many at once.
What gauges tell is worked out by brute force, by other ways than atleak's own: a bank of units is drawn once, and what
each block of a unit (the line with all that acts on it, and every circuit that hangs on it) does there is weighed by
the gauges that tell of it; units put together from such blocks are solved anew and weighed by all gauges together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from atleak.catalogue.circuits import Pressure
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.gauge_card import point_of
from atleak.diagnosis.uncertainty import Assumptions
from atleak.engine.balance import Balance
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import SHARP, network
from atleak.engine.operation import LINE, consumed, fall_to_set_pressure, sections_held
from atleak.engine.profile import WORKSHOP
from atleak.engine.restrictions import Branch, GapBranch, Orifice
from atleak.equations.clearance import effective_clearance
from atleak.equations.fluid import dynamic_viscosity
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import (
    LINE_TAP,
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    applied,
    taps_of,
)

Parts = dict[tuple[Any, ...], np.ndarray]  # what each part of some units is like, shape (units,)
Tap = tuple[OperatingPoint, str]  # "p_g" of the line, or the id of a circuit

LAND, NEW, SEAL, HOLE, FEED = "land", "new", "seal", "hole", "feed"
VISCOSITY, WARMER, CONVERTER, SETTING, SLIP, PUMP = (
    (name,) for name in ("viscosity", "warmer", "converter", "setting", "slip", "pump")
)
MOST_SEAL, MOST_PUMP, MOST_RISE, MOST_FALL = 20.0, 6.0, 5.0, 0.9  # times the mean; of the line's pressure
READ_OFF, LEAST, FINEST = 0.1, 0.25, 1e3  # of a gauge's variance; of the highest pressure; [Pa]
ENOUGH, SPREAD = 300, 200  # units of equal weight
BINS, LIKE = 8, 0.1  # of viscosity; the line of units whose parts are put together, relative
CHUNK = 8_192  # units that are solved at once
STEPS = 60  # of the search for the line pressure that the pump holds


def cells_of(controller: Controller) -> dict[GaugeCell, OperatingPoint]:
    """Return every tap where it is applied, in every range and state that the file's operating points describe."""
    cells: dict[GaugeCell, OperatingPoint] = {}
    for selected in ("D", "R"):
        for engine in (Engine.SLOW_IDLE, Engine.STALL):
            for tap in taps_of(controller):
                cell = GaugeCell(selected, engine, tap)
                point = point_of(controller, cell)
                if point is not None and applied(controller, cell):
                    cells[cell] = point
    return cells


class Prior:
    """A valve body's units before any gauge is read."""

    def __init__(self, controller: Controller, fluid: Fluid, assumptions: Assumptions) -> None:
        self.controller, self.fluid, self.assumptions = controller, fluid, assumptions
        self.model = LeakageModel(controller, clearances(None, controller), fluid, WORKSHOP)
        self.cells = cells_of(controller)
        self.points = tuple(dict.fromkeys(self.cells.values()))
        self.taps: tuple[Tap, ...] = tuple(
            (point, LINE if cell.tap == LINE_TAP else cell.tap) for cell, point in self.cells.items()
        )
        gears = {point.gear for point in self.points}
        leaking = {gap.key for gap in controller.gaps if not gears.isdisjoint(gap.gears)}
        states = clearances(None, controller)
        self.lands = {each.land.key: each for each in states if not each.land.seal and each.land.key in leaking}
        self.fed = [each for each in controller.circuits if each.feeds]
        self.sealed = [each.id for each in self.fed if each.gears != frozenset(controller.gears)]

    def worse(self) -> Prior:
        """Return units whose parts are worn more often and further, out of which more agree with one that lost much."""
        u = self.assumptions
        often = replace(u, worn_lands=2.0 * u.worn_lands, land_wear=1.5 * u.land_wear, worn_seals=2.0 * u.worn_seals)
        return Prior(self.controller, self.fluid, often)

    def log_density(self, name: tuple[Any, ...], gone: np.ndarray) -> Any:
        """Return the logarithm of the density of what can be worn; 0 of other parts, which are never drawn worse."""
        u = self.assumptions
        if name[0] == LAND:
            chance, mean, most = u.worn_lands, u.land_wear, u.most_land_wear
        elif name[0] in (SEAL, HOLE):
            chance, mean, most = 0.5 * u.worn_seals, u.seal_wear, MOST_SEAL * u.seal_wear
        else:
            return 0.0
        far = math.log(-chance / mean / math.expm1(-most / mean)) - gone / mean
        return np.where(gone > 0.0, far, math.log1p(-chance))

    def draw(self, rng: np.random.Generator, count: int) -> Parts:
        """Draw units."""
        u = self.assumptions

        def gone(chance: float, mean: float, most: float) -> np.ndarray:
            far = -mean * np.log1p(rng.random(count) * np.expm1(-most / mean))
            return np.where(rng.random(count) < chance, far, 0.0)

        parts: Parts = {}
        for key, state in self.lands.items():
            low, high = state.land.mounting_range
            new = rng.uniform(low, high, count) if low < high else rng.normal(low, u.mounting_clearance, count)
            parts[NEW, key] = np.maximum(new, 0.0)
            parts[LAND, key] = gone(u.worn_lands, u.land_wear, u.most_land_wear)
        for each in self.fed:
            parts[FEED, each.id] = np.exp(u.feed * rng.standard_normal(count))
        for name in self.sealed:
            for what in (SEAL, HOLE):
                parts[what, name] = gone(0.5 * u.worn_seals, u.seal_wear, MOST_SEAL * u.seal_wear)
        parts[VISCOSITY] = np.exp(u.viscosity * rng.standard_normal(count))
        parts[WARMER] = u.gauged_temperature * rng.standard_normal(count)
        parts[CONVERTER] = 1.0 + u.converter_pressure * rng.standard_normal(count)
        higher = gone(u.high_lines, u.line_rise, MOST_RISE * u.line_rise)
        fall = gone(u.sticking_regulators, u.regulator_fall, MOST_FALL)
        parts[SETTING] = (1.0 + u.line_setting * rng.standard_normal(count) + higher) * (1.0 - fall)
        parts[SLIP] = np.exp(u.slip_coefficient * rng.standard_normal(count))
        parts[PUMP] = gone(u.worn_pumps, u.pump_wear, MOST_PUMP * u.pump_wear)
        return parts

    def held(self, units: Parts) -> np.ndarray:
        """Return what gauges that do not err would show, shape (taps, units) [Pa]."""
        count = len(units[VISCOSITY])
        found = np.empty((len(self.taps), count))
        for start in range(0, count, CHUNK):
            part = {name: values[start : start + CHUNK].astype(float) for name, values in units.items()}
            for point in self.points:
                pressures = self._at(part, point)
                for number, (at, tap) in enumerate(self.taps):
                    if at == point:
                        found[number, start : start + CHUNK] = pressures[tap]
        return found

    def _at(self, units: Parts, point: OperatingPoint, *, short: bool | None = None) -> Mapping[str, Any]:
        """Return what the line, as p_g, and every circuit hold at an operating point [Pa].

        ``short`` says whether the pump falls short of what is required in all of the units, or in none.
        """
        model, controller, law = self.model, self.controller, self.model.law
        temperature = point.temperature + units[WARMER]
        nu = self.fluid.kinematic_viscosity(temperature, model.profile.viscosity) * units[VISCOSITY]
        rho = self.fluid.density(temperature)
        mu, rise = dynamic_viscosity(nu, rho), temperature - REFERENCE_TEMPERATURE
        gaps = []
        for gap, counts in self._gaps[point.gear]:
            state = self.lands[gap.key]
            cold = units[NEW, gap.key] + units[LAND, gap.key]
            clearance = effective_clearance(cold, state.thermal_rate, rise)
            diameter = law.diameter(state.spool_diameter, clearance)
            gaps.append((gap, law.restriction(diameter, clearance, nu, rho, state.land.contact_length), counts))
        made = network(controller, point, gaps, nu, rho, solves=True)
        feeds = tuple(
            each.with_restriction(
                Orifice(each.restriction.coefficient * units[FEED, each.into], each.restriction.transition)
            )
            for each in made.feeds
        )
        seals = tuple(
            Branch(Pressure(1.0, name), Pressure(0.0, None), restriction, None, True)
            for name in self.sealed
            if name in made.solved
            for restriction in (
                GapBranch(units[SEAL, name] * self.open_feed(name) / self.highest * self.nominal / mu),
                Orifice(units[HOLE, name] * self.open_feed(name) / math.sqrt(self.highest), SHARP),
            )
        )
        made = replace(made, feeds=feeds, leaks=(*made.leaks, *seals))
        required, converter = point.main_pressure * units[SETTING], point.converter_pressure * units[CONVERTER]
        slips = replace(model.pump, slip_factor=units[SLIP] * (1.0 + units[PUMP]))

        def at(main: Any, near: Balance | None = None) -> Balance:
            return made.balance(sections_held(controller, main, converter), near)

        def lacking(main: Any, balance: Balance) -> Any:
            before = consumed(made, main, required, after_line=False)
            return made.drawn_from_pump(balance) + before - slips.capacity(point.engine_speed, main, mu)

        balance = at(required)
        main = required
        if short is None:
            which = lacking(required, balance) > 0.0
            short = bool(which.all())
            if which.any() and not short:
                whole, rest = (
                    self._at(taken(units, which), point, short=True),
                    self._at(taken(units, ~which), point, short=False),
                )
                return {name: _placed(which, whole[name], rest[name]) for name in whole}
        if short:
            main, balance = _where_nothing_lacks(lacking, at, required, balance)
        if controller.line is not None and controller.line.following is not None:
            factor = required / point.main_pressure
            main, balance, _ = fall_to_set_pressure(controller.line, point, main, balance, at, factor)
        return {
            name: np.broadcast_to(value, required.shape) for name, value in {**balance.pressures, LINE: main}.items()
        }

    @cached_property
    def _gaps(self) -> dict[int, list[Any]]:
        return {
            point.gear: [(gap, counts) for gap, counts in _counted(self.model, point) if gap.key in self.lands]
            for point in self.points
        }

    @cached_property
    def highest(self) -> float:
        return max(point.main_pressure for point in self.points)

    @cached_property
    def nominal(self) -> float:
        """Return the viscosity at which a seal leaks as it is drawn [Pa·s]."""
        return float(self.model.dynamic_viscosity(max(self.points, key=lambda each: each.main_pressure).temperature))

    def open_feed(self, name: str) -> float:
        """Return what the feeds of a circuit pass at the highest line pressure [m³/s]."""
        point = next(each for each in self.points if name in self.model.network(each).solved)
        feeds = (each for each in self.model.network(point).feeds if each.into == name)
        return float(sum(each.restriction.flow(self.highest) for each in feeds))


def _counted(model: LeakageModel, point: OperatingPoint) -> Iterator[tuple[Any, bool]]:
    return zip(model.gaps_in(point.gear), (branch.counts for branch in model.network(point).lands), strict=True)


def _where_nothing_lacks(lacking: Any, at: Any, highest: Any, balance: Balance) -> tuple[Any, Balance]:
    """Return the line pressure at which the pump covers all that leaves it: false position with Illinois' halving."""
    low, high = np.zeros_like(highest), highest
    f_low, f_high, side = lacking(low, at(low)), lacking(highest, balance), np.zeros_like(highest)
    for _ in range(STEPS):
        main = high - f_high * (high - low) / (f_high - f_low)
        balance = at(main, balance)
        f = lacking(main, balance)
        over = f > 0.0
        f_low = np.where(over, np.where(side == 1, 0.5 * f_low, f_low), f)
        f_high = np.where(over, f, np.where(side == -1, 0.5 * f_high, f_high))
        low, high, side = np.where(over, low, main), np.where(over, main, high), np.where(over, 1, -1)
        if np.all((high - low < 1.0) | (np.abs(f) < 1e-12)):
            break
    return main, balance


def _placed(where: np.ndarray, some: Any, rest: Any) -> np.ndarray:
    whole = np.empty(where.shape)
    whole[where], whole[~where] = some, rest
    return whole


def taken(units: Parts, which: Any) -> Parts:
    """Return some of the units."""
    return {name: values[which] for name, values in units.items()}


def made_new(units: Parts, *names: tuple[Any, ...]) -> Parts:
    """Return units with some parts as when new; unless named, all lands, seals and the pump."""
    worn = names or tuple(name for name in units if name[0] in (LAND, SEAL, HOLE, PUMP[0]))
    return units | {name: np.zeros_like(units[name]) for name in worn}


@dataclass(frozen=True)
class Unit:
    """A true unit: what its taps hold and have lost against new, and what the wear of each land costs a tap [Pa]."""

    number: int
    parts: Parts  # of one unit each
    held: np.ndarray
    lost: np.ndarray
    costs: Mapping[LandKey, float]  # the most that a pressure would regain if the land alone were made new

    @property
    def worst(self) -> LandKey:
        """Return the land that costs most."""
        return max(self.costs, key=lambda key: self.costs[key])


def costs_of(prior: Prior, units: Parts, held: np.ndarray) -> np.ndarray:
    """Return what the wear of each land costs the tap that it costs most, shape (lands, units) [Pa]."""
    worn = [np.flatnonzero(units[LAND, key]) for key in prior.lands]
    repaired = [made_new(taken(units, which), (LAND, key)) for key, which in zip(prior.lands, worn, strict=True)]
    joined = {name: np.concatenate([each[name] for each in repaired]) for name in units}
    regained, costs, start = prior.held(joined), np.zeros((len(worn), held.shape[1])), 0
    for row, which in zip(costs, worn, strict=True):
        row[which] = (regained[:, start : start + len(which)] - held[:, which]).max(axis=0)
        start += len(which)
    return costs


def faulty(prior: Prior, fault: float, tried: int) -> list[Unit]:
    """Return those of some units in which a land costs so much [Pa]."""
    units = prior.draw(np.random.default_rng(20261128), tried)
    held = prior.held(units)
    costs = costs_of(prior, units, held)
    kept = np.flatnonzero(costs.max(axis=0) >= fault)
    lost = prior.held(made_new(taken(units, kept))) - held[:, kept]
    return [
        Unit(
            int(number),
            taken(units, number),
            held[:, number],
            lost[:, place],
            dict(zip(prior.lands, costs[:, number], strict=True)),
        )
        for place, number in enumerate(kept)
    ]


@dataclass(frozen=True)
class Gauges:
    """How gauges err: relative standard uncertainty, which one sits at a tap, and how much of it they share."""

    relative: float
    moved: Literal["one", "two", "each"]  # one gauge for all, one on the line and one on the taps, a new one each time

    def name(self, tap: str) -> str:
        return "" if self.moved == "each" else "line" if self.moved == "two" and tap == LINE else "tap"

    def errs(self, pressures: np.ndarray) -> np.ndarray:
        """Return the standard uncertainty of readings [Pa]."""
        return np.maximum(self.relative * np.maximum(pressures, LEAST * pressures.max()), FINEST)

    def table(self, prior: Prior, showed: np.ndarray) -> PressureTable:
        """Return readings as a workshop hands them in."""
        readings = (
            GaugeReading(cell, float(pressure), gauge=self.name(LINE if cell.tap == LINE_TAP else cell.tap))
            for cell, pressure in zip(prior.cells, showed, strict=True)
        )
        return PressureTable("simulated", "0" * 64, None, ("kPa",), tuple(readings))

    def read(self, rng: np.random.Generator, taps: Sequence[Tap], held: np.ndarray) -> np.ndarray:
        """Return what gauges show [Pa]."""
        shared = {name: rng.standard_normal() for name in ("line", "tap")}
        own = rng.standard_normal(len(taps))
        if self.moved == "each":
            return held + self.errs(held) * own
        alike = np.array([shared[self.name(tap)] for _, tap in taps])
        return held + self.errs(held) * (math.sqrt(READ_OFF) * own + math.sqrt(1.0 - READ_OFF) * alike)

    def covariance(self, taps: Sequence[Tap], showed: np.ndarray) -> np.ndarray:
        """Return the covariance of the errors of readings [Pa²]."""
        names = [self.name(tap) for _, tap in taps]
        alike = np.array([[bool(a) and a == b for b in names] for a in names])
        part = (1.0 - READ_OFF) * alike + np.diag([READ_OFF if name else 1.0 for name in names])
        errs = self.errs(showed)
        return np.outer(errs, errs) * part

    def whitening(self, taps: Sequence[Tap], showed: np.ndarray) -> np.ndarray:
        """Return what makes the errors of readings independent and of unit variance."""
        return np.linalg.inv(np.linalg.cholesky(self.covariance(taps, showed)))


@dataclass(frozen=True)
class Known:
    """What can be known of a unit: units that are weighed by what gauges showed."""

    units: Parts
    held: np.ndarray
    weights: np.ndarray
    effective: float

    def equally_likely(self, count: int) -> tuple[Parts, np.ndarray]:
        """Return units of equal weight, and what they hold."""
        chosen = np.searchsorted(np.cumsum(self.weights), (np.arange(count) + 0.5) / count).clip(
            0, len(self.weights) - 1
        )
        return taken(self.units, chosen), self.held[:, chosen]


class Bank:
    """Units drawn once, out of which those that agree with gauges are put together block by block.

    They are sorted by the viscosity of their fluid and cut into bins of it: parts are put together of units of one bin.
    """

    def __init__(self, prior: Prior, count: int, seed: int = 5) -> None:
        self.prior, self.in_bin = prior, count // BINS
        self.count = BINS * self.in_bin
        worse = prior.worse()
        units = worse.draw(np.random.default_rng(seed), self.count)
        at = prior.points[0].temperature + units[WARMER]
        order = np.argsort(prior.fluid.kinematic_viscosity(at, WORKSHOP.viscosity) * units[VISCOSITY])
        self.units = {name: values[order].astype(np.float32) for name, values in units.items()}
        self.held = prior.held(self.units).astype(np.float32)
        self.blocks = blocks_of(prior)
        #: of the parts of each block, for the prior over that from which the bank was drawn
        self.log_ratios = [
            np.zeros(self.count)
            + sum(
                prior.log_density(name, self.units[name]) - worse.log_density(name, self.units[name]) for name in parts
            )
            for parts in (block.parts for block in self.blocks)
        ]

    def known(self, rng: np.random.Generator, gauges: Gauges, showed: np.ndarray, *, draws: int, most: int) -> Known:
        """Return units that are weighed by gauges, more of them until they are worth `ENOUGH` or the most are drawn."""
        line, *others = self.blocks
        of_line, chances = self._log_likelihood(line, gauges, showed) + self.log_ratios[0], []
        for block, log_ratio in zip(others, self.log_ratios[1:], strict=True):
            logs = self._log_likelihood(block, gauges, showed) + log_ratio
            of_line += np.repeat(np.log(np.exp(logs - logs.max()).reshape(BINS, -1).sum(axis=1) + 1e-30), self.in_bin)
            chances.append(_in_bins(_flattened(logs) + 1e-12))
        of_line = _flattened(of_line)
        whole = gauges.whitening(self.prior.taps, showed)
        units, held, logs_ = [], [], []
        while True:
            chosen = [_drawn(rng, of_line, draws)]
            bins = chosen[0] // self.in_bin
            log_weight = -np.log(of_line[chosen[0]])
            for chance in chances:
                place = np.empty(draws, int)
                for number in np.unique(bins):
                    here = np.flatnonzero(bins == number)
                    place[here] = _drawn(rng, chance[number], len(here))
                log_weight -= np.log(chance[bins, place])
                chosen.append(bins * self.in_bin + place)
            made = {
                name: self.units[name][at]
                for block, at in zip(self.blocks, chosen, strict=True)
                for name in block.parts
            }
            units.append(made)
            held.append(self.prior.held(made))
            log_weight += sum(ratio[at] for ratio, at in zip(self.log_ratios, chosen, strict=True))
            logs_.append(log_weight - 0.5 * np.sum((whole @ (held[-1] - showed[:, None])) ** 2, axis=0))
            weights = _normed(np.concatenate(logs_))
            effective = 1.0 / float(weights @ weights)
            if effective >= ENOUGH or len(weights) >= most:
                joined = {name: np.concatenate([each[name] for each in units]) for name in made}
                return Known(joined, np.concatenate(held, axis=1), weights, effective)

    def _log_likelihood(self, block: Block, gauges: Gauges, showed: np.ndarray) -> np.ndarray:
        """Return how well the bank agrees with the gauges that tell of a block first.

        A circuit that hangs on the line counts by its part of that, whatever the line was.
        """
        taps = self.prior.taps
        covariance = gauges.covariance(taps, showed)
        logs, rows, residuals = np.zeros(self.count, np.float32), [], []
        for number, (point, tap) in enumerate(taps):
            row, beside = np.eye(len(taps))[number], taps.index((point, LINE))
            if block.line and (tap == LINE or tap in block.circuits):
                residuals.append(self.held[number] - np.float32(showed[number]))
            elif tap == LINE:
                logs -= np.square((self.held[number] / np.float32(showed[number]) - 1.0) / LIKE).astype(np.float32)
                continue
            elif tap in block.circuits:
                part = self.held[number] / np.maximum(self.held[beside], 1e3)
                residuals.append(part * np.float32(showed[beside]) - np.float32(showed[number]))
                row = row - showed[number] / showed[beside] * np.eye(len(taps))[beside]
            else:
                continue
            rows.append(row)
        if not rows:
            return np.zeros(self.count)
        turned = np.array(rows)
        whiten = np.linalg.inv(np.linalg.cholesky(turned @ covariance @ turned.T)).astype(np.float32)
        for row in whiten:
            logs -= 0.5 * np.square(sum(part * one for part, one in zip(row, residuals, strict=True) if part))
        return logs.astype(float)


@dataclass(frozen=True)
class Block:
    """Parts of a unit that act first on some taps: of the line with what it follows, or of one circuit."""

    circuits: frozenset[str]
    parts: tuple[tuple[Any, ...], ...]
    line: bool


def blocks_of(prior: Prior) -> list[Block]:
    """Return the blocks of a unit, that of the line first."""
    controller = prior.controller
    gears = {point.gear for point in prior.points}
    following = controller.line.following if controller.line is not None else None
    line = {following.section} if following is not None else set()
    line |= {each.id for each in controller.circuits if each.set_pressure is not None}  # does not hang on the line
    names, blocks = {each.id for each in controller.circuits}, dict[LandKey, str]()
    for gap in controller.gaps:
        for end in (gap.high.section, gap.low.section) if not gears.isdisjoint(gap.gears) else ():
            if end in names and blocks.get(gap.key, end) in line | {end}:
                blocks[gap.key] = end
    shared = (VISCOSITY, WARMER, CONVERTER, SETTING, SLIP, PUMP)
    others = [each.id for each in controller.circuits if each.id not in line]
    found = []
    for circuits in (frozenset(line), *(frozenset([name]) for name in others)):
        first = circuits == line
        own = [key for key in prior.lands if (blocks[key] in circuits if key in blocks else first)]
        parts: list[tuple[Any, ...]] = [(what, key) for key in own for what in (LAND, NEW)]
        parts += [(FEED, each.id) for each in prior.fed if each.id in circuits]
        parts += [(what, name) for name in prior.sealed if name in circuits for what in (SEAL, HOLE)]
        found.append(Block(circuits, (*parts, *(shared if first else ())), first))
    return found


def _drawn(rng: np.random.Generator, chance: np.ndarray, count: int) -> np.ndarray:
    return np.searchsorted(np.cumsum(chance), rng.random(count) * chance.sum()).clip(0, len(chance) - 1)


def _in_bins(chance: np.ndarray) -> np.ndarray:
    """Return chances whose sum is 1 in each bin, shape (bins, units of a bin)."""
    rows = chance.reshape(BINS, -1)
    return np.asarray(rows / rows.sum(axis=1, keepdims=True))


def _normed(logs: np.ndarray) -> np.ndarray:
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())


def _flattened(logs: np.ndarray) -> np.ndarray:
    """Return weights whose sum is 1, flattened until they are worth `SPREAD` units."""
    for power in 0.8 ** np.arange(30):
        weights = _normed(power * logs)
        if float(weights @ weights) * SPREAD <= 1.0:
            break
    return weights
