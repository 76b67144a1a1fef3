"""Tell from a drive what leaks as narrow gaps do and what as holes do: by main pressure where the line was not held.

Where main pressure is surely below what is required, the line's regulator lets nothing go: what the pump displaces is
what it slips and what leaves the line. What the unit as measured does not explain of that has grown,

    V n − slip − leakage − consumers = a(T) p/μ + b √p.

Gaps of lands and pump go with p/μ, sharp-edged holes and consumers with √p. Lands and pump differ only in that a gap
between steel and aluminium widens as it warms. Where the line was held, less leaves it than the pump displaces.

What is not known of the unit errs alike over the whole drive, in errors that the stretches share; the engine draws
them. Intervals are those of the profile of χ² (Venzon & Moolgavkar, Applied Statistics 37, 1988).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, cast

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Land
from atleak.catalogue.controller_tables import State
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import DomainError
from atleak.common.memory import kept_with
from atleak.diagnosis.gauge_card import GaugeCard, standing_point
from atleak.diagnosis.missing import Amount
from atleak.diagnosis.uncertainty.posterior import PosteriorUnit
from atleak.engine.extremes import CountedSamples, Lasting, smoothed
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LINE, Operation, consumed
from atleak.engine.projection import Projection, project
from atleak.engine.road_pressure import standing_states
from atleak.equations.clearance import effective_clearance
from atleak.equations.pump import slip_flow
from atleak.measurements.clearances import LandClearance
from atleak.measurements.events.event import gear_engaged
from atleak.measurements.road_test import RoadTest

# choices of this project
_SURELY = 1.645  # standard uncertainties of main pressure by which it is below what is required
_HELD_ONCE = 0.9  # quantile of main pressure in a gear and state that the line surely held at times
_CLASS = 2.0, 100.0 / 60.0  # [K], [1/s]: samples of one gear and state within these count as one stretch
_SHORTEST = 1.0  # [s] of a stretch
_MOST, _MOST_HELD = 32, 8  # stretches in which the line was not held, and in which it was
_MOST_GROWTH = 1.5  # of what the pump displaces
_READ = 0.01  # of the flow: by which one stretch errs that no other does
_SHARED = 16  # kinds of shared error
_WIDEST = 400e-6  # [m] radial clearance that is tried
_U_95 = 1.96
_APART = 6.63  # of χ², from which on two explanations are told apart
_UNLIKE = 4.0  # χ² over its degrees of freedom from which on pressure does not go as leaks make it
_TELLING = 8.0  # high over low end of an interval beyond which no figure is told
_BROKEN = 16.0  # rise of χ² where the line was held although, by what it was elsewhere, it could not have been
SPAN, HOT = 25.0, 80.0  # [K] that a drive has to pass through, and [°C] that it has to reach

Found = Literal["leaks", "held", "thin", "unlike", "not_there"]
Explanation = Literal["lands", "pump"]


@dataclass(frozen=True)
class Stretch:
    """Samples of one gear and state, alike in temperature and speed, in which it is known what is required: means."""

    like: OperatingPoint  # of the valve body's file
    temperature: float  # [°C]
    engine_speed: float  # [1/s]
    pressure: float  # [Pa]
    required: float  # [Pa] as commanded, or at the point that is like it
    seconds: float
    held: bool  # not surely below what was commanded, or is permitted at least

    @cached_property
    def point(self) -> OperatingPoint:
        """Return the condition with what was logged."""
        return replace(
            self.like,
            temperature=self.temperature,
            engine_speed=self.engine_speed,
            main_pressure=self.pressure,
            converter_pressure=min(self.like.converter_pressure, self.pressure),
            stated_state=self.like.state,
        )


@dataclass(frozen=True)
class WarmUp:
    """What a drive tells of leakage by main pressure; flows are those at `at`, more than of the unit as measured."""

    found: Found
    by_command: bool = False  # whether what is required was commanded; else it is what is permitted at idle and stall
    temperatures: tuple[float, float] | None = None  # [°C] of the samples in which it is known
    at: Stretch | None = None  # where most leaks of what the pump displaces
    total: Amount | None = None  # [m³/s] of all leaks; only `high` where the line was held throughout
    gaps: Amount | None = None  # [m³/s] of those that go with p/μ; None where there are not surely any
    holes: Amount | None = None  # [m³/s] of those that go with √p, likewise
    lands: tuple[Land, ...] = ()  # of the main regulator that drain the line
    bore: Amount | None = None  # [m] their clearance that leaks as much as `gaps`
    side: Amount | None = None  # [m] side clearance of the pump that does
    slip: Amount | None = None  # [-] the pump's slip that does, over that as measured
    told_apart: Explanation | None = None
    left: float | None = None  # [m³/s] at least, at the stated condition; None unless the line was held throughout

    @property
    def lacks_range(self) -> bool:
        """Tell whether a drive through more temperatures would say more."""
        low, high = self.temperatures or (0.0, 0.0)
        return high < HOT or (self.found == "thin" and high - low < SPAN)


def warm_up(road_test: RoadTest, card: GaugeCard, stated: OperatingPoint) -> WarmUp | None:
    """Tell what a drive shows of leakage; None where its log, or the valve body's file, does not say enough for that.

    Parameters
    ----------
    road_test
        the log: with a measured main pressure, temperature, engine speed and gear.
    card
        the unit as measured, with all that is uncertain of it.
    stated
        condition for which it is told how much is left, where the line was held throughout.
    """
    model, main = card.model, road_test.channel("main_pressure")
    measured = main is not None and main.source == "logged" and main.kind != "commanded"
    whole = all(road_test.channel(name) is not None for name in ("engine_speed", "gear", "atf_temperature"))
    if not (measured and whole and model.uses_slip and model.profile.circuits == "on"):
        return None
    command = _commanded(road_test) is not None
    if not (command or model.controller.permissible_in_gear):
        return None
    controller, relative = model.controller, card.assumptions.main_pressure
    shown = kept_with(
        road_test, "stretches", (controller, relative), lambda: [*stretches(controller, road_test, relative)], most=1
    )
    fit = _Fit.of(card, shown)
    if fit is None:
        return WarmUp("not_there", command)
    warm = [each.temperature for each in shown]
    return replace(fit.told(stated), by_command=command, temperatures=(min(warm), max(warm)))


def _commanded(road_test: RoadTest) -> np.ndarray | None:
    channel = road_test.channel("commanded_pressure")
    return road_test.values("commanded_pressure") if channel is not None and channel.source == "logged" else None


def stretches(controller: Controller, road_test: RoadTest, relative: float) -> Iterator[Stretch]:
    """Yield the samples in which it is known what is required: idle and stall in gear, or whatever was commanded.

    Parameters
    ----------
    relative
        standard uncertainty of main pressure [-].
    """
    counted, gear = CountedSamples(road_test), np.asarray(gear_engaged(road_test))
    pressure, commanded = smoothed(road_test, "main_pressure"), _commanded(road_test)
    temperature, speed = (np.asarray(road_test.values(name)) for name in ("atf_temperature", "engine_speed"))
    known = np.isfinite(pressure) & np.isfinite(temperature) & np.isfinite(speed) & (pressure > 0.0)
    least, required = (np.full(len(pressure), np.nan) for _ in range(2))
    found: list[tuple[OperatingPoint, np.ndarray]] = []
    for state, there in standing_states(road_test, gear).items():
        if state == "driving" and commanded is None:
            continue  # nothing tells what is required
        for number in (each for each in controller.gears if each != 0):
            here, point = there & (gear == number) & known, standing_point(controller, number, state)
            permissible = controller.permissible_at(number, cast("State", state))
            low = permissible.low if permissible is not None else None
            if commanded is not None:
                point = point or replace(controller.operating_points[0], gear=number)
                least[here] = required[here] = np.where(commanded[here] > 0.0, commanded[here], np.nan)
            elif point is not None and low is not None and here.any():
                highest = float(np.quantile(pressure[here], _HELD_ONCE))
                required[here], least[here] = point.main_pressure, max(low, min(highest, point.main_pressure))
            if point is not None and here.any():
                found.append((point, here & np.isfinite(least)))
    below = Lasting(counted, (1.0 - _SURELY * relative) - pressure / least).outside
    for point, here in found:
        for held in (False, True):
            part = here & (below != held)
            for t, n, p, needed, seconds in _alike(part, counted.steps, (temperature, speed, pressure, required)):
                yield Stretch(point, t, n, p, needed, seconds, held)


def _alike(here: np.ndarray, steps: np.ndarray, channels: Sequence[np.ndarray]) -> Iterator[tuple[float, ...]]:
    """Yield the means over time of some samples, put together by temperature and speed, and how long they last [s]."""
    parts, seconds = [each[here] for each in channels], steps[here]
    warm, fast = (np.floor(part / width) for part, width in zip(parts, _CLASS, strict=False))
    numbers = np.unique(warm + 1e4 * fast, return_inverse=True)[1]
    lasts = np.bincount(numbers, seconds)
    sums = [np.bincount(numbers, seconds * part) for part in parts]
    for total, *of_parts in zip(lasts.tolist(), *sums, strict=True):
        if total >= _SHORTEST:
            yield *(float(each / total) for each in of_parts), total


def regulator_lands(model: LeakageModel) -> tuple[Land, ...]:
    """Return the lands of the main regulator that let the line leak to the sump in every gear.

    That is the component whose id or name says that it regulates; of several, or of none, the one that leaks most when
    new.
    """
    controller = model.controller
    draining = {
        gap.key
        for gap in controller.gaps
        if gap.high.section == LINE and gap.low.section is None and gap.gears.issuperset(controller.gears)
    }
    of_component: dict[str, list[Land]] = {}
    for land in controller.lands:
        if land.key in draining and land.seal is None:
            of_component.setdefault(land.component, []).append(land)

    def rank(item: tuple[str, list[Land]]) -> tuple[bool, float]:
        named = f"{item[0]} {controller.components[item[0]]}".lower()
        return "regulator" in named, sum(each.new_clearance**3 * each.nominal_diameter for each in item[1])

    return tuple(max(of_component.items(), key=rank, default=("", []))[1])


def _through_regulator(model: LeakageModel, widths: Any, temperature: Any, pressure: Any, viscosity: Any) -> Any:
    """Return what the regulator's lands let through [m³/s] with clearances of at least so much [m].

    Temperature [°C] and pressure [Pa] are those of the fluid, of that dynamic viscosity [Pa·s]; arrays broadcast.
    """
    keys, flow = {land.key for land in regulator_lands(model)}, 0.0 * pressure * widths
    density = model.fluid.density(temperature, model.profile.viscosity)
    for each in model.geometries:
        if each.gap.key in keys:
            cold, rise = np.maximum(widths, each.radial_clearance), temperature - REFERENCE_TEMPERATURE
            clearance = effective_clearance(cold, each.thermal_rate, rise)
            sizes = model.law.diameter(each.spool_diameter, clearance), clearance
            flow = flow + model.law.flow(pressure, *sizes, viscosity / density, density, each.contact_length)
    return flow


def _most_telling(model: LeakageModel, shown: Iterable[Stretch]) -> list[Stretch]:
    """Return the longest stretches in which the line was not held, and those of the others with most demand."""

    def demand(each: Stretch) -> float:
        return -each.pressure / float(model.dynamic_viscosity(each.temperature)) / each.engine_speed

    every = [each for each in shown if np.isfinite(demand(each))]
    low = sorted((each for each in every if not each.held), key=lambda each: -each.seconds)
    return [*low[:_MOST], *sorted((each for each in every if each.held), key=demand)[:_MOST_HELD]]


@dataclass(frozen=True)
class _Fit:
    """What is known of every stretch; arrays of shape (stretches,), or (stretches, draws)."""

    model: LeakageModel
    stretches: tuple[Stretch, ...]
    supply: np.ndarray  # [m³/s] that the pump displaces
    demand: np.ndarray  # [m³/s] of the unit as measured, its slip included, in each draw
    main: np.ndarray  # [Pa] in each draw
    viscosity: np.ndarray  # [Pa·s] likewise
    displacement: float  # relative standard uncertainty

    @classmethod
    def of(cls, card: GaugeCard, shown: Iterable[Stretch]) -> _Fit | None:
        """Draw what the unit as measured takes in every stretch; None where there is none."""
        model, u, projections = card.model, card.assumptions, dict[Stretch, Projection]()
        for each in _most_telling(model, shown):
            try:
                projections[each] = project(model, each.point)
            except DomainError:
                continue  # outside the fluid's data
        if not projections:
            return None
        unit = PosteriorUnit(model, card.sources, replace(u, line_setting=u.main_pressure), projections.values())
        rows = [unit.demand(unit.as_measured, each.point, each.required) for each in projections]
        demand, main, viscosity = (np.array(part) for part in zip(*rows, strict=True))
        supply = model.pump.per_revolution * np.array([each.engine_speed for each in projections])
        return cls(model, tuple(projections), supply, demand, main, viscosity, u.volumetric_efficiency)

    @cached_property
    def held(self) -> np.ndarray:
        return np.array([each.held for each in self.stretches])

    @cached_property
    def grown(self) -> np.ndarray:
        """Return what the unit as measured does not take of what the pump displaces [m³/s]."""
        return np.asarray(self.supply - self.demand.mean(axis=1))

    @cached_property
    def laminar(self) -> np.ndarray:
        """Return p/μ [1/s]."""
        return np.array([s.pressure / float(self.model.dynamic_viscosity(s.temperature)) for s in self.stretches])

    @cached_property
    def temperature(self) -> np.ndarray:
        """Return that of the fluid [°C], shape (stretches, 1)."""
        return np.array([[each.temperature] for each in self.stretches])

    @cached_property
    def at(self) -> int:
        """Return the stretch in which most leaks of what the pump displaces, where the line was low if it ever was."""
        counts = ~self.held if not self.held.all() else self.held
        return int(np.argmin(np.where(counts, self.supply / self.laminar, np.inf)))

    @cached_property
    def most(self) -> float:
        """Return the largest growth that is tried there [m³/s]."""
        return _MOST_GROWTH * float(self.supply[self.at])

    @cached_property
    def root(self) -> np.ndarray:
        """Return the flow through a hole over that at `at` [-]."""
        pressure = np.array([each.pressure for each in self.stretches])
        return np.asarray(np.sqrt(pressure / pressure[self.at]))

    @cached_property
    def regulator(self) -> tuple[np.ndarray, np.ndarray]:
        """Return clearances of the regulator's lands [m], and by how much more than now these leak [m³/s]."""
        keys = {land.key for land in regulator_lands(self.model)}
        now = max((each.radial_clearance for each in self.model.geometries if each.gap.key in keys), default=_WIDEST)
        widths = np.geomspace(max(now, 1e-6), _WIDEST, 300)
        pressure = np.array([[each.pressure] for each in self.stretches])
        viscosity = self.model.dynamic_viscosity(self.temperature)
        flow = _through_regulator(self.model, widths, self.temperature, pressure, viscosity)
        return widths, flow - flow[:, :1]

    @cached_property
    def variances(self) -> Mapping[Explanation, np.ndarray]:
        """Return the covariance of `grown` [m⁶/s²] where all of it goes with p/μ: it errs with pressure and fluid."""
        widths, more = self.regulator
        total, own = max(float(self.grown[self.at]), 0.0), np.diag((_READ * self.supply) ** 2)
        wide, pump = float(np.interp(total, more[self.at], widths)), self.main / self.viscosity
        channels = self.temperature, self.main, self.viscosity
        now, then = (_through_regulator(self.model, each, *channels) for each in (0.0, wide))
        of_gaps: dict[Explanation, Any] = {"lands": then - now, "pump": total * pump / pump[self.at].mean()}
        off = {name: self.demand + each for name, each in of_gaps.items()}
        displaced = self.displacement * self.supply
        return {name: np.cov(each) + np.outer(displaced, displaced) + own for name, each in off.items()}

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Return what may have grown unseen: not what was measured."""
        lands = {land.key for land in regulator_lands(self.model)}
        seen = {state.land.key for state in cast("Sequence[LandClearance]", self.model.clearances) if state.measured}
        found: list[Explanation] = ["lands"] if lands - seen else []
        return (*found, *(("pump",) if self.model.pump_open else ()))

    @property
    def shapes(self) -> tuple[Explanation, ...]:
        """Return by the shapes of which a growth with p/μ is looked for."""
        return self.explanations or ("pump",)

    def growth(self, explanation: Explanation, at: np.ndarray) -> np.ndarray:
        """Return the growth of gaps in every stretch from that at `at` [m³/s], shape (stretches, growths)."""
        if explanation == "pump":
            return np.outer(self.laminar / self.laminar[self.at], at)
        widths, more = self.regulator
        clearance = np.interp(at, more[self.at], widths)
        return np.array([np.interp(clearance, widths, row) for row in more])

    def misfit(
        self, explanation: Explanation, gaps: np.ndarray, holes: np.ndarray, *, with_held: bool = True
    ) -> np.ndarray:
        """Return χ² of growths of gaps and holes at `at` [m³/s], shape (gaps, holes).

        Of the stretches in which the line was held only one counts: where most more would leave than is displaced.
        """
        left = self.grown[:, None] - self.growth(explanation, gaps)
        left = (left[:, :, None] - self.root[:, None, None] * holes).reshape(len(self.supply), -1)
        variance, low, held = self.variances[explanation], ~self.held, self.held
        gain = variance[:, low] @ np.linalg.inv(variance[np.ix_(low, low)])
        by_low = gain @ left[low]
        chi = np.sum(left[low] * np.linalg.solve(variance[np.ix_(low, low)], left[low]), axis=0)
        if held.any() and with_held:
            spread = np.sqrt(np.diag(variance - gain @ variance[low])[held])
            chi += np.minimum((left - by_low)[held] / spread[:, None], 0.0).min(axis=0) ** 2
        return np.asarray(chi.reshape(len(gaps), len(holes)))

    def told(self, stated: OperatingPoint) -> WarmUp:
        """Return what the stretches tell; where the line was held throughout also of a condition."""
        known, at = WarmUp("thin", at=self.stretches[self.at], lands=regulator_lands(self.model)), self.at
        if self.held.all():
            return self._bounded(known, stated)
        total, displaced = float(self.grown[at]), (self.displacement + _READ) * self.supply[at]
        u = _U_95 * float(np.hypot(self.demand[at].std(), displaced))
        known, freedom = replace(known, total=Amount(total, total - u, total + u)), int(np.sum(~self.held)) - 2
        if freedom < 1:
            return known
        from scipy.special import stdtrit  # most runs need none

        axes = self._near()
        tables = {each: self.misfit(each, *axes) for each in self.shapes}
        both = np.minimum.reduce(list(tables.values()))
        low_alone = min(float(self.misfit(each, *axes, with_held=False).min()) for each in self.shapes)
        scale = max(low_alone / freedom, 1.0)
        if scale > _UNLIKE or both.min() - low_alone > _BROKEN * scale:
            return replace(known, found="unlike")
        within = scale * float(stdtrit(freedom, 0.975)) ** 2  # of which the error of few stretches is not well known
        gaps, holes = (_sure(_interval(axes[n], both.min(axis=1 - n), within)) for n in range(2))
        most = total + u
        known = replace(
            known,
            gaps=gaps and _through(gaps, lambda flow: min(flow, most)),
            holes=holes and _through(holes, lambda flow: min(flow, most)),
            found="leaks" if gaps or holes else "thin",
        )
        if gaps is None:
            return known
        least = {each: float(table.min()) for each, table in tables.items()}
        worse = {each: min((least[other] for other in least if other != each), default=np.inf) for each in least}
        surely = [each for each in self.explanations if worse[each] - least[each] > _APART * scale]
        likely = surely or self.explanations
        amounts = {each: _sure(_interval(axes[0], tables[each].min(axis=1), within)) for each in likely}
        return replace(self._with_equivalents(known, amounts), told_apart=surely[0] if surely else None)

    def _near(self) -> tuple[np.ndarray, ...]:
        """Return growths of gaps and of holes at `at` that are worth trying [m³/s]."""
        axes: tuple[np.ndarray, ...] = (np.linspace(0.0, self.most, 61),) * 2
        for _ in range(2):
            table = np.minimum.reduce([self.misfit(each, *axes) for each in self.shapes])
            near = table - table.min() < 25.0 * max(1.0, table.min() / len(self.supply))
            inside = [np.flatnonzero(near.any(axis=1 - n)) for n in range(2)]
            axes = tuple(
                np.linspace(axis[max(each[0] - 1, 0)], axis[min(each[-1] + 1, len(axis) - 1)], 101)
                for axis, each in zip(axes, inside, strict=True)
            )
        return axes

    def _with_equivalents(self, known: WarmUp, amounts: Mapping[Explanation, Amount | None]) -> WarmUp:
        """Add which clearances of the regulator's lands or of the pump leak as much as growths at `at` [m³/s]."""
        of_lands, of_pump = amounts.get("lands"), amounts.get("pump")
        widths, more = self.regulator
        if of_lands is not None:
            known = replace(known, bore=_through(of_lands, lambda flow: np.interp(flow, more[self.at], widths)))
        if of_pump is None:
            return known
        pump, here = self.model.controller.pump, self.stretches[self.at]
        viscosity = float(self.model.dynamic_viscosity(here.temperature))
        slips = float(pump.slip(here.pressure, viscosity))
        known = replace(known, slip=_through(of_pump, lambda flow: 1.0 + flow / slips))
        before, per_cube = pump.measured.or_else(pump.clearances).side, pump.gaps.side
        if before is None or per_cube is None:
            return known
        unit = float(slip_flow(pump.displacement, per_cube, here.pressure, viscosity))  # [m³/s] per cubed clearance
        return replace(known, side=_through(of_pump, lambda flow: np.cbrt(before**3 + flow / unit)))

    def _bounded(self, known: WarmUp, stated: OperatingPoint) -> WarmUp:
        """Return how much can have grown at most, and what is left at least at a condition."""
        axis, none, model = np.linspace(0.0, self.most, 401), np.zeros(1), self.model
        by_gaps = max(_at_most(axis, self.misfit(each, axis, none)[:, 0]) for each in self.shapes)
        by_holes, here = _at_most(axis, self.misfit(self.shapes[0], none, axis)[0]), self.stretches[self.at]
        required, unit = stated.main_pressure, Operation.of(model, stated)
        rise = required / here.pressure
        thinner = float(model.dynamic_viscosity(here.temperature) / model.dynamic_viscosity(stated.temperature))
        leaves = float(unit.leakage) + consumed(unit.network, required, required, after_line=False)
        supply = float(model.pump_capacity(stated.engine_speed, required, stated.temperature))
        left = supply - leaves - max(by_gaps * rise * thinner, by_holes * rise**0.5)
        return replace(
            known, found="held", total=Amount(0.0, None, max(by_gaps, by_holes)), left=left if left > 0.0 else None
        )


def _interval(axis: np.ndarray, chi: np.ndarray, within: float) -> Amount:
    """Return where χ² is least along an axis, and the ends of all where it is little more."""
    over = chi - chi.min() - within
    inside, ends = np.flatnonzero(over <= 0.0), []
    for edge, beyond in ((inside[0], inside[0] - 1), (inside[-1], inside[-1] + 1)):
        pair = [beyond, edge] if 0 <= beyond < len(axis) else [edge, edge]
        ends.append(float(np.interp(0.0, -over[pair], axis[pair])))
    return Amount(float(axis[np.argmin(chi)]), *ends)


def _at_most(axis: np.ndarray, chi: np.ndarray) -> float:
    high = _interval(axis, chi, _U_95**2).high
    return float(axis[-1]) if high is None else high


def _sure(amount: Amount) -> Amount | None:
    """Return an amount that is surely more than nothing, and known well enough to be told; else None."""
    return amount if amount.low and amount.high and amount.high <= _TELLING * amount.low else None


def _through(amount: Amount, of: Callable[[float], Any]) -> Amount:
    """Return what rises with an amount."""
    return Amount(*(None if each is None else float(of(each)) for each in amount))  # type: ignore[arg-type]
