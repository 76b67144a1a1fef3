"""What a drive tells of leakage: units of known wear are driven warm by the engine, and the fit must find it again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from atleak.catalogue.circuits import Consumer
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import State
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import PumpClearances, PumpGaps
from atleak.common.units import DM3_MIN, RPM
from atleak.common.wording import wording
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.gauge_card import GaugeCard
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.warm_up import WarmUp, regulator_lands, warm_up
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import Operation
from atleak.engine.profile import WORKSHOP
from atleak.measurements.clearances import clearances
from atleak.measurements.road_test import RoadTest
from atleak.report.tables.road_record import warm_up_record
from atleak.report.tables.road_words import checks_of, warm_up_section
from atleak.report.tables.table import Table, Text

LogOf = Callable[..., RoadTest]
UM = 1e-6
IDLE, NEW_SLIP = 650.0 / RPM, 4e-8  # of the three files
#: bores of the regulator and growths of the pump's slip with which the line falls at hot idle, but not at once
WORN = {
    "five_speed_2005": ((115.0, 180.0), (20.0, 32.0)),
    "ford_4r70w": ((155.0, 210.0), (28.0, 42.0)),
    "jatco_jf506e": ((240.0, 300.0), (42.0, 60.0)),
}


@cache
def unit(name: str) -> tuple[Controller, Fluid, GaugeCard]:
    controller, fluid = load_controller(name), load_fluid("mobil_multi_vehicle_atf")
    return controller, fluid, card_of(controller, fluid)


def card_of(controller: Controller, fluid: Fluid) -> GaugeCard:
    model = LeakageModel(controller, clearances(None, controller), fluid, WORKSHOP)
    return GaugeCard(model, model, None, None, DEFAULTS)


def standing(controller: Controller, state: str) -> OperatingPoint:
    return next(each for each in controller.operating_points if (each.gear, each.state) == (1, state))


@dataclass
class Driven:
    """A unit as it really is, driven warm with a gauge, a thermometer and a description that err."""

    name: str
    bore: float | None = None  # [µm] of the regulator's lands
    slip: float = 1.0  # times what it was when new
    hole: float = 0.0  # [dm³/min] at the required pressure
    setting: float = 1.0  # of the line, over what the file states
    seed: int | None = None  # of all errors; None for none
    hottest: float = 100.0  # [°C]
    minutes: float = 12.0
    stalls: bool = True
    gauge: float = 1.0

    def drive(self, log_of: LogOf, **more: object) -> RoadTest:
        controller, fluid, _ = unit(self.name)
        rng = np.random.default_rng(self.seed)
        err = (lambda *size: 0.0 * rng.standard_normal(*size)) if self.seed is None else rng.standard_normal
        thicker = math.exp(0.05 * err())
        fluid = replace(fluid, points=tuple((at, nu * thicker) for at, nu in fluid.points))
        self.slipped = self.slip * math.exp(0.2 * err())
        pump = replace(
            controller.pump,
            displacement=controller.pump.displacement * (1.0 + 0.02 * err()),
            slip_coefficient=self.slipped * NEW_SLIP,
        )
        consumers = controller.consumers
        if self.hole:
            at = standing(controller, "idle").main_pressure
            consumers += (Consumer("hole", "hole", self.hole / DM3_MIN, False, "test", "orifice", at),)
        really = replace(controller, pump=pump, consumers=consumers)
        lands = {land.key for land in regulator_lands(unit(self.name)[2].model)}
        states = []
        for each in clearances(None, really):
            clearance = each.radial_clearance if self.seed is None else rng.uniform(*each.land.mounting_range)
            if self.bore is not None and each.land.key in lands:
                clearance = self.bore * UM
            states.append(replace(each, radial_clearance=clearance))
        model = LeakageModel(really, tuple(states), fluid, WORKSHOP)

        time = np.arange(0.0, 60.0 * self.minutes, 0.5)
        warm = np.round(30.0 + (self.hottest - 30.0) * (1.0 - np.exp(-3.0 * time / time[-1])) / (1.0 - math.exp(-3.0)))
        cycle = time % 120.0
        stall, rolls = self.stalls & (cycle >= 100.0) & (cycle < 103.0), (cycle >= 40.0) & (cycle < 90.0)
        pressure, speed = np.full(len(time), 900e3), np.full(len(time), 1800.0 / RPM)
        kinds: tuple[tuple[State, np.ndarray], ...] = (("idle", ~stall & ~rolls), ("stall", stall))
        for state, there in kinds:
            point = standing(really, state)
            point = replace(point, main_pressure=point.main_pressure * self.setting)
            speed[there] = IDLE if state == "idle" else point.engine_speed
            celsius = np.unique(warm[there])
            point = replace(point, engine_speed=IDLE if state == "idle" else point.engine_speed, stated_state=state)
            held = np.broadcast_to(Operation.of(model, point, celsius).held.main_pressure, celsius.shape)
            pressure[there] = np.interp(warm[there], celsius, held)
        count = len(time)
        channels = {
            "main_pressure": pressure * self.gauge * (1.0 + 0.02 * err()) * (1.0 + 0.01 * err(count)),
            "atf_temperature": warm + 3.0 * err() + 0.3 * err(count),
            "engine_speed": speed + 5.0 / RPM * err(count),
            "gear": np.where(rolls, 3.0, 1.0),
            "vehicle_speed": np.where(rolls, 15.0, 0.0),
        }
        return log_of(time, **(channels | more))

    def told(self, log_of: LogOf, card: GaugeCard | None = None) -> WarmUp:
        controller, _, usual = unit(self.name)
        told = warm_up(self.drive(log_of), card or usual, controller.operating_points[0])
        assert told is not None
        return told


def holds(amount: tuple[float, float | None, float | None] | None, true: float) -> bool:
    assert amount is not None
    _, low, high = amount
    return low is not None and high is not None and low <= true <= high


def test_intervals_hold_what_is_worn(log_of: LogOf) -> None:
    held = []
    for seed, (name, (bores, slips)) in enumerate(WORN.items()):
        at = (seed + 0.5) / len(WORN)
        lands = Driven(name, bore=bores[0] + at * (bores[1] - bores[0]), seed=seed)
        pump = Driven(name, slip=slips[0] + at * (slips[1] - slips[0]), seed=100 + seed)
        told = lands.told(log_of)
        held += [holds(told.bore, lands.bore * UM)] if told.bore and lands.bore else []
        assert told.told_apart != "pump"
        told = pump.told(log_of)
        held += [holds(told.slip, pump.slipped)] if told.slip else []
        assert told.told_apart != "lands"
    assert len(held) >= 4  # figures are told, not only where that is easy
    assert np.mean(held) >= 0.93


@pytest.mark.slow
@pytest.mark.parametrize("name", WORN)
def test_intervals_of_many_drives(name: str, log_of: LogOf) -> None:
    held, (bores, slips) = [], WORN[name]
    for seed in range(200, 220):
        at = np.random.default_rng(seed).random()
        lands = Driven(name, bore=bores[0] + at * (bores[1] - bores[0]), seed=seed)
        pump = Driven(name, slip=slips[0] + at * (slips[1] - slips[0]), seed=1000 + seed)
        told, of_pump = lands.told(log_of), pump.told(log_of)
        held += [holds(told.bore, lands.bore * UM)] if told.bore and lands.bore else []
        held += [holds(of_pump.slip, pump.slipped)] if of_pump.slip else []
    assert np.mean(held) >= 0.93


def test_a_sound_unit_is_never_accused(log_of: LogOf) -> None:
    for seed, name in enumerate(WORN):
        told = Driven(name, seed=seed).told(log_of)
        assert (told.found, told.gaps, told.holes, told.bore, told.slip) == ("held", None, None, None, None)
        low = Driven(name, setting=0.7, seed=seed).told(log_of)  # nothing leaks, and the line is set low
        assert (low.found, low.gaps, low.holes, low.bore, low.slip) == ("unlike", None, None, None, None)


def test_what_goes_through_a_hole_is_not_called_a_gap(log_of: LogOf) -> None:
    told = Driven("five_speed_2005", hole=12.0).told(log_of)
    assert told.found == "leaks"
    assert told.gaps is None
    assert told.bore is None
    assert told.slip is None
    assert told.at is not None
    required = unit("five_speed_2005")[0].operating_points[1].main_pressure
    assert holds(told.holes, 12.0 / DM3_MIN * math.sqrt(told.at.pressure / required))


def test_a_held_line_bounds_what_leaks(log_of: LogOf) -> None:
    """Half of what the line could lose does not show; the flow that is left is less than that of the unit new."""
    controller, _, card = unit("five_speed_2005")
    told = Driven("five_speed_2005", bore=80.0).told(log_of)
    assert told.found == "held"
    assert told.total is not None
    assert told.at is not None
    worn = Driven("five_speed_2005", bore=80.0)
    states = [
        replace(each, radial_clearance=80.0 * UM) if each.land in told.lands else each
        for each in clearances(None, controller)
    ]
    model = replace(card.model, clearances=tuple(states))
    point = controller.operating_points[0]
    leaves = [Operation.of(each, told.at.point).leakage for each in (model, card.model)]
    assert told.total.high > leaves[0] - leaves[1] > 0.0
    slip = worn.slip * model.pump_slip(point.main_pressure, point.temperature)
    left = model.pump.per_revolution * point.engine_speed - slip - Operation.of(model, point).leakage
    assert told.left is not None
    assert 0.0 < told.left < left


def test_a_measured_pump_leaves_the_lands(log_of: LogOf) -> None:
    """Between steel and steel nothing tells a narrow gap of the pump from one of a land but what was measured."""
    controller, fluid, _ = unit("five_speed_2005")
    described = replace(controller.pump, gaps=PumpGaps(4e5, None, False), clearances=PumpClearances(40 * UM, None))
    measured = replace(controller, pump=described.with_measured(PumpClearances(40 * UM, None)))
    worn = Driven("five_speed_2005", bore=125.0)
    told = worn.told(log_of, card_of(measured, fluid))
    assert told.told_apart == "lands"
    assert told.slip is None
    assert told.side is None
    assert holds(told.bore, 125.0 * UM)


def test_a_described_pump_is_told_by_its_side_clearance(log_of: LogOf) -> None:
    controller, fluid, _ = unit("five_speed_2005")
    per_cube, new, now = 4e5, 40 * UM, 140 * UM  # of Wilson's coefficient
    described = replace(controller.pump, gaps=PumpGaps(per_cube, None, False), clearances=PumpClearances(new, None))
    worn = Driven("five_speed_2005", slip=1.0 + per_cube * (now**3 - new**3) / NEW_SLIP)
    told = worn.told(log_of, card_of(replace(controller, pump=described), fluid))
    assert holds(told.side, now)


def test_a_command_says_what_is_required(log_of: LogOf) -> None:
    """Less than is permitted where so much is commanded is no leak; less than is commanded is one."""
    name = "ford_4r70w"
    controller, _, card = unit(name)
    log = Driven(name, setting=0.5).drive(log_of)
    asked = np.asarray(log.values("main_pressure"))
    commanded = Driven(name, setting=0.5).drive(log_of, commanded_pressure=asked)
    told = warm_up(commanded, card, controller.operating_points[0])
    assert told is not None
    assert told.by_command
    assert told.found == "held"
    rolls = np.asarray(log.values("vehicle_speed")) > 0.0
    stands = np.where(np.asarray(log.values("engine_speed")) > 1400.0 / RPM, 1239e3, 483e3)
    leaky = Driven(name, slip=40.0).drive(log_of, commanded_pressure=np.where(rolls, np.nan, stands))
    told = warm_up(leaky, card, controller.operating_points[0])
    assert told is not None
    assert told.by_command
    assert told.found == "leaks"
    assert holds(told.slip, 40.0)


def test_a_short_or_cold_drive_says_what_to_drive(log_of: LogOf) -> None:
    cold = Driven("five_speed_2005", hottest=60.0).told(log_of)
    assert cold.found == "held"
    assert cold.lacks_range
    assert not Driven("five_speed_2005").told(log_of).lacks_range


@pytest.mark.parametrize("lacking", ["gear", "atf_temperature", "engine_speed", "main_pressure"])
def test_nothing_is_told_without_a_channel(lacking: str, log_of: LogOf) -> None:
    log = Driven("five_speed_2005").drive(log_of)
    rest = {name: log.values(name) for name in log.channels if name != lacking}
    controller, _, card = unit("five_speed_2005")
    assert warm_up(log_of(log.time, **rest), card, controller.operating_points[0]) is None


def test_a_diagnosis_says_it_in_words_and_in_its_record(log_of: LogOf, limits: Limits) -> None:
    controller, fluid, _ = unit("five_speed_2005")
    log = Driven("five_speed_2005", bore=150.0).drive(log_of)
    diagnosis = diagnose(controller, fluid, limits, road_test=log)
    record, section = warm_up_record(diagnosis), warm_up_section(diagnosis, wording("en"))
    assert record is not None
    assert section is not None
    words, table, taken = section.parts
    assert isinstance(words, Text)
    assert isinstance(table, Table)
    assert isinstance(taken, Text)
    bore = [f"{record[f'bore{end}_um']:.0f}" for end in ("", "_low", "_high")]
    assert "radial clearances of {} µm ({} to {})".format(*bore) in words.words
    assert [f"{each}\N{NO-BREAK SPACE}µm" for each in bore] in [[*table.texts(row)[1:]] for row in table.rows]
    assert "displacement 2\N{NO-BREAK SPACE}%" in taken.words
    cold = Driven("five_speed_2005", hottest=60.0).drive(log_of)
    diagnosis = diagnose(controller, fluid, limits, road_test=cold)
    assert "drive_warm" in [check.code for check in checks_of(diagnosis)]
