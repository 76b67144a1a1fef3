"""Units with one cause that is known, and the job that a workshop makes of them: a measuring sheet and gauges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances, PumpGaps
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.missing import Cause, Row, split_as_measured
from atleak.engine.operation import LINE
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeReading, PressureTable
from atleak.measurements.readings import Reading, Readings
from simulated.gauged import Faults, TrueUnit, cells_of, file_of, true_unit

UNITS = (
    "aisin_aw55_50sn",
    "chrysler_41te",
    "five_speed_2005",
    "ford_4r70w",
    "gm_4l60e",
    "jatco_jf506e",
    "zf_6hp26",
)
DESCRIBED = "chrysler_41te", "ford_4r70w", "jatco_jf506e"  # whose pump's side clearance is described for the case
FOLLOWING = tuple(unit for unit in UNITS if unit != "chrysler_41te")  # whose line follows a circuit
GAUGE, SHEET, PLAY = 0.01, 1.5e-6, 5e-6  # one standard deviation of a gauge, of a clearance [m], of the pump's [m]
FAST = 1500.0 / 60.0  # [1/s] of a fast idle
WORN, LEAKING = (10e-6, 70e-6), (0.2e-5, 6e-5)  # [m] of a worn land, [m³/s] at 900 kPa out of a seal
MISREAD = (0.5, 0.85), (1.2, 1.5)  # of what a gauge should show
ENOUGH, TRIES = 100e3, 12  # [Pa] that the cause is to cost; other units are taken as they come


@dataclass(frozen=True)
class Case:
    """A kind of cause: what is drawn to be wrong, and which gauges are read."""

    name: str
    cause: Cause | None  # None where no part is at fault
    draw: Callable[[np.random.Generator, Controller], Faults]
    least: float  # [%] of the units that have it named
    bodies: tuple[str, ...] = UNITS
    described: bool = False  # and measured: the pump's side clearance
    fast: bool = False  # gauges at a fast idle too
    one_speed: bool = False  # gauges at slow idle only
    misread: bool = False  # one reading, which contradicts the others


def _slip(rng: np.random.Generator, controller: Controller) -> Faults:
    return Faults(slip=math.exp(rng.uniform(math.log(1.7), math.log(27.0))))


def _lands(count: int, followed: bool, rng: np.random.Generator, controller: Controller) -> Faults:
    setting = _followed(controller)
    lands = [
        land.key
        for land in controller.lands
        if not land.seal and (setting in _sections(controller, land.key)) is followed
    ]
    chosen = rng.choice(len(lands), count, replace=False)
    return Faults({lands[each]: rng.uniform(*WORN) for each in chosen})


def _seal(rng: np.random.Generator, controller: Controller) -> Faults:
    applied = dict.fromkeys(cell.tap for cell in cells_of(controller) if cell.tap != LINE_TAP)
    return Faults(seals={rng.choice([*applied]): math.exp(rng.uniform(*map(math.log, LEAKING)))})


def _regulator(rng: np.random.Generator, controller: Controller) -> Faults:
    return Faults(fall=rng.uniform(0.1, 0.4))


def _filter(rng: np.random.Generator, controller: Controller) -> Faults:
    return Faults(most_speed=math.exp(rng.uniform(math.log(300.0), math.log(1500.0))) / 60.0)


def _sound(rng: np.random.Generator, controller: Controller) -> Faults:
    return Faults()


CASES = (
    Case("pump, measured", Cause.PUMP, _slip, 90.0, DESCRIBED, described=True, fast=True),
    Case("pump, two speeds", Cause.PUMP, _slip, 80.0, fast=True),
    Case("pump, one speed", Cause.PUMP, _slip, 90.0, one_speed=True),
    Case("one land", Cause.LANDS, partial(_lands, 1, False), 90.0),
    Case("two lands", Cause.LANDS, partial(_lands, 2, False), 90.0),
    Case("line setting", Cause.LINE_SETTING, partial(_lands, 1, True), 90.0, FOLLOWING),
    Case("seal", Cause.CLUTCH_SEAL, _seal, 90.0),
    Case("regulator", None, _regulator, 90.0),
    Case("filter", None, _filter, 90.0),
    Case("misread", None, _sound, 90.0, misread=True),
    Case("sound", None, _sound, 90.0),
)


@dataclass(frozen=True)
class Job:
    """A true unit, and what a workshop knows of it."""

    case: Case
    controller: Controller  # as its file describes it
    fluid: Fluid
    true: TrueUnit
    readings: Readings
    table: PressureTable
    pump: PumpClearances

    def __str__(self) -> str:
        faults = self.true.faults
        wear = {key: f"{1e6 * each:.0f} µm in {self.circuit_of(key)}" for key, each in faults.wear.items()}
        seals = {name: f"{60e3 * each:.1f} dm³/min" for name, each in faults.seals.items()}
        costs = {
            f"{point.name} {point.engine_speed * 60:.0f} {tap}": f"{self.lost(point, tap) / 1e3:.0f}"
            for point, tap in dict.fromkeys(self.places)
        }
        return (
            f"{wear or ''}{seals or ''} slip {faults.slip:.1f} fall {faults.fall:.2f} "
            f"most {60 * faults.most_speed:.0f} {costs}"
        )

    def circuit_of(self, key: LandKey) -> str | None:
        """Return a circuit that a land leaks from or into; None where it leaks from the line itself."""
        circuits = {each.id for each in self.controller.circuits}
        return next((each for each in _sections(self.controller, key) if each in circuits), None)

    @property
    def places(self) -> Iterator[tuple[OperatingPoint, str]]:
        """Yield the operating point of the file, and the tap, of every gauge reading."""
        for reading in self.table.readings:
            point = cells_of(self.controller)[replace(reading.cell, engine=_as_idle(reading.cell.engine))]
            tap = LINE if reading.cell.tap == LINE_TAP else reading.cell.tap
            yield replace(point, engine_speed=reading.engine_speed or point.engine_speed), tap

    def lost(self, point: OperatingPoint, tap: str) -> float:
        """Return what a tap truly lost [Pa]."""
        cell = LINE_TAP if tap == LINE else tap
        return self.true.held(point, cell, new=True) - self.true.held(point, cell)

    @cached_property
    def cost(self) -> float:
        """Return the most that the fault truly costs a measured pressure [Pa]: nothing else is wrong."""
        return max(self.lost(*place) for place in self.places)

    def truth(self, point: OperatingPoint, tap: str) -> tuple[float, Mapping[Row, float]]:
        """Return what is truly missing of a pressure, and what each row explains [Pa]."""
        point = replace(point, temperature=self._stated(point).temperature)
        at, now, new = self.true.at(point, new=True), self.true.now, self.true.new
        sound = replace(now, controller=replace(now.controller, leaks=new.controller.leaks, line=new.controller.line))
        rows = {row: float(values[0]) for row, values in split_as_measured(sound, new, at, tap).rows.items()}
        if tap in self.true.faults.seals:
            tight = replace(self.true, now=replace(now, controller=replace(now.controller, leaks=new.controller.leaks)))
            rows[Cause.CLUTCH_SEAL, tap] = tight.held(point, tap) - self.true.held(point, tap)
        return self.lost(point, tap), rows

    def _stated(self, point: OperatingPoint) -> OperatingPoint:
        return next(each for each in self.controller.operating_points if each.name == point.name)


def job_of(case: Case, body: str, number: int) -> Job:
    """Return one unit with its job, the same each time; its cause costs enough where that can be in some tries."""
    rng = np.random.default_rng((20261128, sum(map(ord, case.name + body)), number))
    controller, fluid = _described(body) if case.described else file_of(body)
    seed = int(rng.integers(1 << 31))
    for _ in range(TRIES):
        faults = case.draw(rng, controller)
        true = true_unit(np.random.default_rng(seed), controller, fluid, faults)
        read = sheet_of(rng, true), _table(rng, case, controller, true)
        job = Job(
            case, controller, fluid, true, *read, _told(rng, controller, faults) if case.described else NO_CLEARANCES
        )
        if job.cost >= ENOUGH:
            break
    return job


@cache
def _described(body: str) -> tuple[Controller, Fluid]:
    """Return a shipped valve body with a pump that slips past its sides, 35 µm wide when new and 50 at the most."""
    controller, fluid = file_of(body)
    new, most = PumpClearances.of_um(35.0, None), PumpClearances.of_um(50.0, None)
    pump = replace(controller.pump, gaps=PumpGaps(1.2e6, None), clearances=new, limits=most)
    return replace(controller, pump=pump), fluid


def _told(rng: np.random.Generator, controller: Controller, faults: Faults) -> PumpClearances:
    """Return the side clearance that makes a pump slip as it does, as it was measured."""
    pump = controller.pump
    assert pump.gaps.side
    assert pump.clearances.side
    assert pump.slip_coefficient
    opened = (faults.slip - 1.0) * pump.slip_coefficient / pump.gaps.side
    return PumpClearances(side=math.cbrt(pump.clearances.side**3 + opened) + PLAY * rng.normal())


def sheet_of(rng: np.random.Generator, true: TrueUnit) -> Readings:
    """Return a measuring sheet of all lands."""
    found = []
    for state in true.now.clearances:
        land, clearance = state.land, state.radial_clearance + SHEET * rng.normal()
        sleeve = land.nominal_diameter + 2.0 * max(clearance, 0.5e-6)
        found += [
            Reading(land.component, part, plane, direction, 1, diameter)
            for part, diameter in (("spool", land.nominal_diameter), ("sleeve", sleeve))
            for plane in land.planes
            for direction in (0.0, 90.0)
        ]
    return Readings("simulated", "", None, "mm", False, "tidy", tuple(found))


def _table(rng: np.random.Generator, case: Case, controller: Controller, true: TrueUnit) -> PressureTable:
    """Return what gauges show, each reading with an error of its own."""
    taken = []
    for cell, point in cells_of(controller).items():
        idle = cell.engine is Engine.SLOW_IDLE
        if idle or not case.one_speed:
            taken.append((cell, point, None))
        if idle and case.fast:
            faster = replace(point, engine_speed=FAST)
            taken.append((replace(cell, engine=Engine.FAST_IDLE), faster, FAST))
    taps = [cell.tap for cell, _, _ in taken]
    others = [number for number, tap in enumerate(taps) if tap == LINE_TAP or taps.count(tap) > 1]  # that contradict it
    wrong = rng.choice(others) if case.misread else None
    factor = rng.uniform(*MISREAD[int(rng.integers(2))]) if case.misread else 1.0
    readings = tuple(
        GaugeReading(
            cell,
            true.held(point, cell.tap) * (1.0 + GAUGE * rng.normal()) * (factor if number == wrong else 1.0),
            engine_speed=speed,
        )
        for number, (cell, point, speed) in enumerate(taken)
    )
    return PressureTable("simulated", "0" * 64, None, ("kPa",), readings)


@cache
def instruments() -> Instruments:
    """Return gauges of which it is known that a clearance that they show errs by `SHEET`."""
    usual = load_instruments()
    return Instruments(replace(usual.spool, calibration=2e-6), replace(usual.sleeve, calibration=2e-6))


def _as_idle(engine: Engine) -> Engine:
    return Engine.SLOW_IDLE if engine is Engine.FAST_IDLE else engine


def _sections(controller: Controller, key: LandKey) -> list[str | None]:
    return [end.section for gap in controller.gaps if gap.key == key for end in (gap.high, gap.low)]


def _followed(controller: Controller) -> str | None:
    line = controller.line
    return line.following.section if line is not None and line.following is not None else None
