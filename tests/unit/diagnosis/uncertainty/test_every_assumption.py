"""Every assumption moves what it should by what it should: each against a closed form, or draws of the tests' own.

Each is set to its default and to half of it, and must give two results, both as expected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from atleak.catalogue.circuits import Pressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.pump import PumpClearances, PumpGaps
from atleak.common.units import IN_HG
from atleak.diagnosis.flows import find_flows
from atleak.diagnosis.uncertainty import DEFAULTS, NOTHING_ELSE, Assumptions
from atleak.diagnosis.uncertainty.posterior import PosteriorUnit
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.diagnosis.vacuum import with_vacuum
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP, Profile
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.flow_readings import FlowReading, FlowTable
from atleak.measurements.readings import Readings
from atleak.measurements.vacuum import VacuumReading, VacuumStand, VacuumTable
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, new_at, two_instruments
from tests.unit.equations import referees

UM, DRAWS = 1e-6, 8_192
EXACT = two_instruments(calibration=0.0)
LINEAR = WORKSHOP.with_options(entry_loss="off")
RNG = np.random.default_rng(35)
Z, U = RNG.standard_normal(100_000), RNG.random(100_000)
Two = tuple[float, float]  # as found, and as expected
SOUND = replace(
    DEFAULTS, worn_lands=0.0, worn_seals=0.0, worn_pumps=0.0, sticking_regulators=0.0, high_lines=0.0, line_setting=0.0
)
EVEN = replace(SOUND, viscosity=0.0, gauged_temperature=0.0, mounting_clearance=0.0)


@dataclass(frozen=True)
class Bench:
    """A unit of twenty equal lands on the line, the four-speed one, and what assesses them."""

    twenty: Controller
    four_speed: Controller
    fluid: Fluid
    judge: Callable[..., Any]

    def clearance(self, given: Assumptions, sheet: Readings | None, tools: Any = EXACT) -> tuple[float, Any]:
        """Standard uncertainty of the first land's clearance [m], and its state."""
        states = clearances(sheet, self.four_speed)
        land = find_sources(states, sheet, self.four_speed, tools, given)[0][0]
        return land.standard_uncertainty, land.state

    def one(self, given: Assumptions, profile: Profile = LINEAR, worn: float = 1.0, **of_land: Any) -> tuple[Any, Any]:
        """The total of a unit with one land of the line, as assessed, and its only gap."""
        land, gap = replace(self.twenty.lands[0], **of_land), self.twenty.gaps[0]
        unit = replace(self.twenty, lands=(land,), gaps=(gap,))
        case = self.judge(
            a_sheet(unit, clearance=worn * land.mounting_clearance),
            controller=unit, instruments=EXACT, assumptions=given, profile=profile,
        )  # fmt: skip
        return case.unit.totals[0], case.projections[0].gaps[0]

    def relative(self, given: Assumptions, profile: Profile = LINEAR, **of_land: Any) -> float:
        total, _ = self.one(given, profile, **of_land)
        return float(total.u_leakage / total.leakage)

    def share(self, given: Assumptions, pump: Any, profile: Profile = LINEAR) -> float:
        total, _ = replace(self, twenty=replace(self.twenty, pump=pump)).one(given, profile)
        return float(total.u_share / total.share)

    def before(self, given: Assumptions, controller: Controller | None = None) -> tuple[PosteriorUnit, Any, Any]:
        """A unit before any gauge is read, its point of the highest pressure, and draws of it."""
        controller = controller or self.four_speed
        states = clearances(None, controller)
        model = LeakageModel(controller, states, self.fluid, LINEAR)
        sources, _ = find_sources(states, None, controller, load_instruments(), given)
        point = max(controller.operating_points, key=lambda each: each.main_pressure)
        unit = PosteriorUnit(model, sources, given, [project(model, point)])
        return unit, point, unit.draw(DRAWS)

    def leak(self, given: Assumptions) -> Any:
        """What a reading of 12 in-Hg with 0.5 mm tells of a land 14.5 mm across and 5 mm long."""
        land = replace(self.twenty.lands[0], nominal_diameter=14.5e-3, contact_length=5e-3)
        unit = replace(self.twenty, lands=(land,), gaps=self.twenty.gaps[:1])
        reading = VacuumReading("test", None, (land.key,), 12.0 / IN_HG, 0.5e-3)
        table = VacuumTable("own.csv", "0" * 64, None, VacuumStand(), (reading,))
        return with_vacuum(clearances(None, unit), None, unit, table, EXACT, given)[0].leak


# --- of a clearance


def room(bench: Bench, given: Assumptions) -> Two:
    u, state = bench.clearance(given, a_sheet(bench.four_speed), two_instruments(calibration=0.0, expansion=8e-6))
    body, spool = state.land.body_expansion - 8e-6, state.land.spool_expansion - 8e-6
    rate = 0.5 * abs(body * state.sleeve_diameter - spool * state.spool_diameter)
    return u, rate * given.room_temperature / math.sqrt(3.0)


def mounting(bench: Bench, given: Assumptions) -> Two:
    return bench.clearance(given, None)[0], given.mounting_clearance


def nominal(bench: Bench, given: Assumptions) -> Two:
    sheet = a_sheet(bench.four_speed)
    sleeves = replace(sheet, readings=tuple(each for each in sheet.readings if each.part == "sleeve"))
    return bench.clearance(given, sleeves)[0], 0.5 * given.nominal_diameter


def ovality(bench: Bench, given: Assumptions) -> Two:
    """Of each diameter a two-lobe form at any phase, mean square a quarter of half the ovality squared."""
    one = np.std(0.5 * given.unseen_ovality * np.cos(2.0 * math.pi * U))
    return bench.clearance(given, a_sheet(bench.four_speed, directions=(0.0,)))[0], float(0.5 * math.hypot(one, one))


def form(bench: Bench, given: Assumptions) -> Two:
    return bench.clearance(given, a_sheet(bench.four_speed, ovality=10 * UM))[0], 0.5 * given.form_residual * 10 * UM


# --- of a flow


def length(bench: Bench, given: Assumptions, measured: bool = False) -> Two:
    u, nominal = given.of_contact_length(measured=measured), bench.twenty.lands[0].contact_length
    found = bench.relative(given, contact_length_measured=measured)
    return found, float(np.std(nominal / (nominal + u * Z)))


def viscosity(bench: Bench, given: Assumptions) -> Two:
    return bench.relative(given), float(np.std(np.exp(given.viscosity * Z)))


def temperature(bench: Bench, given: Assumptions) -> Two:
    total, gap = bench.one(given)
    land = bench.twenty.lands[0]
    at = bench.twenty.operating_points[0].temperature + given.temperature * Z
    grows = 0.5 * (land.body_expansion - land.spool_expansion) * gap.diameter * given.temperature * Z
    flow = (gap.effective_clearance + grows) ** 3 / referees.walther(at) / (826.0 - 0.73 * (at - 20.0))
    return total.u_leakage / total.leakage, float(np.std(flow) / np.mean(flow))


def main(bench: Bench, given: Assumptions) -> Two:
    return bench.relative(given), given.main_pressure


def converter(bench: Bench, given: Assumptions) -> Two:
    gap = replace(bench.twenty.gaps[0], high=Pressure(1.0, "p_k"), low=Pressure(0.0, None), section="p_k")
    return replace(bench, twenty=replace(bench.twenty, gaps=(gap,))).relative(given), given.converter_pressure


def efficiency(bench: Bench, given: Assumptions) -> Two:
    pump = replace(bench.twenty.pump, volumetric_efficiency=0.9)
    found = bench.share(given, pump, LINEAR.with_options(pump_efficiency="constant"))
    return found, float(np.std(0.9 / (0.9 + given.volumetric_efficiency * Z)))


def of_slip(bench: Bench, coefficient: float, relative: float) -> float:
    """How a share spreads where the slip does."""
    point = bench.twenty.operating_points[0]
    mu = referees.walther(point.temperature) * (826.0 - 0.73 * (point.temperature - 20.0))
    slip = coefficient * point.main_pressure / (2.0 * math.pi * mu)
    return float(np.std((point.engine_speed - slip) / (point.engine_speed - slip * np.exp(relative * Z))))


def slip(bench: Bench, given: Assumptions) -> Two:
    pump = replace(bench.twenty.pump, slip_coefficient=2e-7)
    return bench.share(given, pump), of_slip(bench, 2e-7, given.slip_coefficient)


def pump_clearance(bench: Bench, given: Assumptions) -> Two:
    side = 60 * UM
    pump = replace(
        bench.twenty.pump, slip_coefficient=2e-7, gaps=PumpGaps(2e-7 / side**3, None, has_tips=False),
        counted=PumpClearances(side),
    )  # fmt: skip
    return bench.share(given, pump), of_slip(bench, 2e-7, 3.0 * given.pump_clearance / side)


def one_sided(bench: Bench, given: Assumptions) -> Two:
    """Nothing, half or all of what wore, to a side at any phase as cos, cos² or cos³, all alike likely."""
    worn, rng = 1.6, np.random.default_rng(2)
    total, gap = bench.one(given, worn=worn)
    new = bench.twenty.lands[0].mounting_clearance
    warm, shown = gap.effective_clearance - worn * new, (worn - 1.0) * new
    part = given.one_sided_wear * rng.choice([0.0, 0.5, 1.0], (4_000, 1))
    power, phase = rng.integers(1, 4, (4_000, 1)), 0.5 * math.pi * rng.random((4_000, 1))
    worn_to = np.maximum(np.cos(np.arange(180) * math.pi / 90.0), 0.0) ** power
    mean = np.mean(worn_to, axis=1, keepdims=True)
    seen = 0.25 * (np.cos(phase) ** power + np.sin(phase) ** power) / mean
    wear = shown / np.maximum(1.0 - part + part * seen, 0.5)
    flow = np.mean((new + warm + wear * (1.0 - part + part * worn_to / mean)) ** 3, axis=1)
    return total.u_leakage / total.leakage, float(np.std(flow)) / (worn * new + warm) ** 3


# --- of a unit before anything was read


def truncated(mean: float, most: float) -> float:
    """The mean of an exponential that ends."""
    return mean - most / math.expm1(most / mean)


def growth(bench: Bench, given: Assumptions) -> np.ndarray:
    unit, _, drawn = bench.before(given)
    return np.concatenate([now - new for now, new in unit.clearances(drawn).values()])


def worn_lands(bench: Bench, given: Assumptions) -> Two:
    return float(np.mean(growth(bench, given) > 0.0)), given.worn_lands


def land_wear(bench: Bench, given: Assumptions) -> Two:
    grown = growth(bench, given)
    return float(np.mean(grown[grown > 0.0])), truncated(given.land_wear, given.most_land_wear)


def worn_pumps(bench: Bench, given: Assumptions) -> Two:
    unit, _, drawn = bench.before(given)
    return float(np.mean(unit.growth_of_slip(drawn) > 0.0)), given.worn_pumps


def pump_wear(bench: Bench, given: Assumptions) -> Two:
    unit, _, drawn = bench.before(given)
    grown = unit.growth_of_slip(drawn)
    return float(np.mean(grown[grown > 0.0])), truncated(given.pump_wear, 6.0 * given.pump_wear)


def line(bench: Bench, given: Assumptions) -> np.ndarray:
    """What the line holds, over what is required."""
    unit, point, drawn = bench.before(given)
    return np.asarray(unit.pressures(drawn, point)["p_g"]) / point.main_pressure - 1.0


def line_setting(bench: Bench, given: Assumptions) -> Two:
    return float(np.std(line(bench, given))), given.line_setting


def high_lines(bench: Bench, given: Assumptions) -> Two:
    return float(np.mean(line(bench, given) > 1e-9)), given.high_lines


def line_rise(bench: Bench, given: Assumptions) -> Two:
    off = line(bench, given)
    return float(np.mean(off[off > 1e-9])), truncated(given.line_rise, 5.0 * given.line_rise)


def sticking(bench: Bench, given: Assumptions) -> Two:
    return float(np.mean(line(bench, given) < -1e-9)), given.sticking_regulators


def regulator_fall(bench: Bench, given: Assumptions) -> Two:
    off = line(bench, given)
    return -float(np.mean(off[off < -1e-9])), truncated(given.regulator_fall, 0.9)


def brake(bench: Bench, given: Assumptions) -> tuple[np.ndarray, float]:
    """What a brake of which nothing but its lands to the sump leaks holds, over the line; and with a sound one."""
    unit = new_at(load_controller("zf_6hp26"), 40 * UM)
    gaps = [gap for gap in unit.gaps if gap.high == Pressure(1.0, "brake_d") and gap.into_sump]
    unit = replace(unit, gaps=tuple(gaps), line=None)
    known, point, drawn = bench.before(given, unit)
    pressure = np.asarray(known.pressures(drawn, point)["brake_d"]) / point.main_pressure
    return pressure, project(known.model, point).circuit("brake_d").pressure / point.main_pressure


def of_feed(feed: Any, lands: float, gap: Any = 0.0, hole: Any = 0.0) -> np.ndarray:
    """The part of the line that a brake keeps: feed √(1 − x) = (lands + gap) x + hole √x."""
    low, high = np.zeros(np.shape(Z[:20_000])), np.ones(np.shape(Z[:20_000]))
    for _ in range(40):
        x = 0.5 * (low + high)
        enough = feed * np.sqrt(1.0 - x) > (lands + gap) * x + hole * np.sqrt(x)
        low, high = np.where(enough, x, low), np.where(enough, high, x)
    return low


def seals(bench: Bench, given: Assumptions) -> Two:
    held, sound = brake(bench, given)
    u = RNG.random((4, 20_000))
    mean, chance = given.seal_wear, 0.5 * given.worn_seals
    gone = -mean * np.log1p(u[:2] * math.expm1(-20.0))
    gap, hole = np.where(u[2:] < chance, gone, 0.0)
    return sound - float(np.mean(held)), sound - float(np.mean(of_feed(1.0, math.sqrt(1.0 - sound) / sound, gap, hole)))


def feed(bench: Bench, given: Assumptions) -> Two:
    held, sound = brake(bench, given)
    expected = of_feed(np.exp(given.feed * Z[:20_000]), math.sqrt(1.0 - sound) / sound)
    return float(np.std(held)), float(np.std(expected))


def gauged_temperature(bench: Bench, given: Assumptions) -> Two:
    unit, point, drawn = bench.before(given)
    _, _, mu = unit.demand(drawn, point, point.main_pressure)
    at = point.temperature + given.gauged_temperature * Z
    own = referees.walther(at) * (826.0 - 0.73 * (at - 20.0))
    return float(np.std(mu)), float(np.std(own))


# --- of a jug, and of a vacuum test


def jug(bench: Bench, given: Assumptions, parts: Sequence[float]) -> list[Any]:
    """What flows in a jug say, each a part of the consumer's usual one."""
    unit = load_controller("five_speed_2005")
    model, point = LeakageModel(unit, clearances(None, unit), bench.fluid, WORKSHOP), unit.operating_points[0]
    consumer = next(each for each in unit.consumers if each.after_line)

    def found(flows: Sequence[float]) -> Sequence[Any]:
        readings = tuple(FlowReading(point.name, consumer.id, flow) for flow in flows)
        return find_flows(FlowTable("own.csv", "0" * 64, None, readings), model, given)

    usual = found([1e-6])[0].usual
    return [*found([part * usual for part in parts])]


def caught(bench: Bench, given: Assumptions) -> Two:
    """Both ends together are wrong in 5 of 100."""
    (found,) = jug(bench, given, [0.4])
    return found.left_high - found.left_low, 2.0 * 2.2414 * given.caught_flow * 0.4 * found.usual


def usual_flow(bench: Bench, given: Assumptions) -> Two:
    """From where on a flow that the consumer may take by itself bounds nothing: 97.5 of 100 take more."""
    expected = 1.95996 * given.consumer_flow
    parts = 1.0 - expected + np.linspace(-0.02, 0.02, 11)
    free = [math.isinf(each.left_high) for each in jug(bench, given, parts)]
    return 1.0 - float(parts[free.index(True)]) + 0.002, expected


def air(vacuum: Any, coefficient: Any = 0.8, factor: Any = 1.0) -> np.ndarray:
    """The clearance of the land by `Bench.leak` [m]: own formulas, laminar gap with its ends against an orifice."""
    stand, kelvin = VacuumStand(), 293.15
    gas, mu = 287.0 * kelvin, 1.81e-5
    p, supply = stand.ambient - vacuum, stand.ambient - stand.supply
    r = np.maximum(supply / p, 0.5283)
    flux = np.sqrt(2.0 * 1.4 / 0.4 / gas * (r ** (2.0 / 1.4) - r ** (2.4 / 1.4)))
    mass = coefficient * math.pi / 4.0 * 0.5e-3**2 * p * flux
    low, high = 1e-6 * np.ones_like(mass), 1e-3 * np.ones_like(mass)
    for _ in range(50):
        c = np.sqrt(low * high)
        g = mass / (math.pi * 14.5e-3 * c)
        tight = 24.0 * mu * gas * 5e-3 * g / (factor * c**2) + 1.5 * gas * g**2 > stand.ambient**2 - p**2
        low, high = np.where(tight, c, low), np.where(tight, high, c)
    return c


def spread_of_air(clearance: np.ndarray) -> float:
    """Standard deviation of the cube, as one of the clearance."""
    return float(np.std(clearance**3) / (3.0 * np.mean(clearance**3) ** (2.0 / 3.0)))


READ = 12.0 / IN_HG


def vacuum_gauge(bench: Bench, given: Assumptions) -> Two:
    return bench.leak(given).u_reading, spread_of_air(air(READ + given.vacuum_gauge * (2.0 * U[:20_000] - 1.0)))


def coefficient(bench: Bench, given: Assumptions) -> Two:
    return bench.leak(given).clearance, float(air(np.array([READ]), given.discharge_coefficient)[0])


def discharge(bench: Bench, given: Assumptions) -> Two:
    return bench.leak(given).u_stand, spread_of_air(air(READ, 0.8 * np.exp(given.discharge * Z[:20_000])))


def position(bench: Bench, given: Assumptions) -> Two:
    factor = 1.0 + 1.5 * (given.tested_position * U[:20_000]) ** 2
    return bench.leak(given).u_position, spread_of_air(air(READ, np.full(20_000, 0.8), factor))


# --- all of them


#: What else is assumed beside each, what is looked at, and how far it may be off: draws of the product are few.
ALL: dict[str, tuple[Assumptions, Callable[[Bench, Assumptions], Two], float]] = {
    "room_temperature_k": (NOTHING_ELSE, room, 1e-3),
    "contact_length_mm": (NOTHING_ELSE, length, 0.02),
    "measured_contact_length_mm": (NOTHING_ELSE, lambda *at: length(*at, measured=True), 0.02),
    "mounting_clearance_um": (NOTHING_ELSE, mounting, 1e-9),
    "nominal_diameter_um": (NOTHING_ELSE, nominal, 1e-4),
    "unseen_ovality_um": (NOTHING_ELSE, ovality, 0.01),
    "form_residual_percent": (NOTHING_ELSE, form, 1e-3),
    "one_sided_wear_percent": (NOTHING_ELSE, one_sided, 0.05),
    "viscosity_percent": (NOTHING_ELSE, viscosity, 0.02),
    "temperature_k": (NOTHING_ELSE, temperature, 0.02),
    "main_pressure_percent": (NOTHING_ELSE, main, 0.02),
    "converter_pressure_percent": (NOTHING_ELSE, converter, 0.02),
    "volumetric_efficiency_percent": (NOTHING_ELSE, efficiency, 0.02),
    "slip_coefficient_percent": (NOTHING_ELSE, slip, 0.02),
    "pump_clearance_um": (NOTHING_ELSE, pump_clearance, 0.02),
    "worn_lands_percent": (DEFAULTS, worn_lands, 0.02),
    "land_wear_um": (DEFAULTS, land_wear, 0.02),
    "most_land_wear_um": (DEFAULTS, land_wear, 0.02),
    "worn_seals_percent": (EVEN, seals, 0.1),
    "seal_wear_percent": (replace(EVEN, worn_seals=0.9), seals, 0.03),
    "worn_pumps_percent": (DEFAULTS, worn_pumps, 0.08),
    "pump_wear_percent": (DEFAULTS, pump_wear, 0.08),
    "sticking_regulators_percent": (SOUND, sticking, 0.1),
    "regulator_fall_percent": (replace(SOUND, sticking_regulators=0.5), regulator_fall, 0.05),
    "line_setting_percent": (SOUND, line_setting, 0.03),
    "high_lines_percent": (SOUND, high_lines, 0.1),
    "line_rise_percent": (replace(SOUND, high_lines=0.5), line_rise, 0.05),
    "feed_percent": (EVEN, feed, 0.03),
    "consumer_flow_percent": (NOTHING_ELSE, usual_flow, 0.02),
    "caught_flow_percent": (DEFAULTS, caught, 1e-3),
    "gauged_temperature_k": (replace(DEFAULTS, viscosity=0.0), gauged_temperature, 0.03),
    "vacuum_gauge_in_hg": (NOTHING_ELSE, vacuum_gauge, 0.02),
    "discharge_coefficient_percent": (NOTHING_ELSE, coefficient, 1e-3),
    "discharge_percent": (NOTHING_ELSE, discharge, 0.03),
    "tested_position_percent": (NOTHING_ELSE, position, 0.02),
}


@pytest.mark.parametrize("name", DEFAULTS.settings)
def test_each_assumption_moves_what_it_should_by_what_it_should(
    name: str, twenty_lands: Controller, four_speed: Controller, hipol: Fluid, judge: Callable[..., Any]
) -> None:
    base, look, tolerance = ALL[name]
    bench, seen = Bench(twenty_lands, four_speed, hipol, judge), list[float]()
    for times in (1.0, 0.5):
        found, expected = look(bench, base.with_settings({name: times * DEFAULTS.settings[name]}))
        assert found == pytest.approx(expected, rel=tolerance, abs=0.0), times
        seen.append(found)
    assert abs(seen[1] / seen[0] - 1.0) > 2.0 * tolerance
