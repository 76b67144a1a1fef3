"""The extremes of a log and their intervals against a loop of its own: sample by sample, its own laws and draws.

From the product come the unit's data, and p_s and p_m as they follow from p_g.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS, NOTHING_ELSE
from atleak.engine.profile import WORKSHOP
from atleak.measurements.road_test import RoadTest, Segment
from tests.unit.diagnosis.uncertainty.conftest import two_instruments
from tests.unit.equations import referees

DRAWS = 20_000
NAN = math.nan
CALIBRATION = 1.5e-6  # [m] half of its variance common to all readings of an instrument
FLOWS = ("contact_length", "viscosity", "temperature", "main_pressure", "converter_pressure", "slip_coefficient")
ASSUMED = replace(NOTHING_ELSE, **{name: getattr(DEFAULTS, name) for name in FLOWS})


@pytest.fixture(scope="module", autouse=True)
def as_for_users(all_draws: None) -> None:
    """Draw as often as for users."""


class Unit:
    """Every land worn by an amount of its own; flows and shares at one sample, or at the draws of one."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        generator = np.random.default_rng(12)
        self.sizes = {
            land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.new_clearance * factor)
            for land, factor in zip(controller.lands, generator.uniform(1.0, 2.2, len(controller.lands)), strict=True)
        }

    def at(self, sample: dict[str, Any], drawn: bool = False) -> tuple[Any, Any]:
        """Leakage [m³/s] and share."""
        rng = np.random.default_rng(5)
        of_all = {name: rng.standard_normal(DRAWS) * drawn for name in ("spool", "sleeve", *FLOWS)}

        def error() -> Any:
            return rng.standard_normal(DRAWS) * drawn if drawn else 0.0

        def off(part: str) -> Any:
            return CALIBRATION * math.sqrt(0.5) * (of_all[part] + error()) if drawn else 0.0

        z = {name: of_all[name] if drawn else 0.0 for name in FLOWS}
        temperature = sample["atf_temperature"] + 1.0 * z["temperature"]
        nu = referees.walther(temperature) * np.exp(0.05 * z["viscosity"])
        rho = 826.0 - 0.73 * (temperature - 20.0)
        main = sample["main_pressure"] * (1.0 + 0.02 * z["main_pressure"])
        converter = sample["converter_pressure"] * (1.0 + 0.02 * z["converter_pressure"])
        held = self.controller.section_pressures(main, converter)
        spreads = {key: (off("spool"), off("sleeve"), 0.1e-3 * error()) for key in self.sizes}
        total = 0.0
        for gap in self.controller.gaps:
            if sample["gear"] not in gap.gears or not gap.into_sump:
                continue
            land, (d, bore), (off_d, off_bore, longer) = (
                self.controller.land(*gap.key), self.sizes[gap.key], spreads[gap.key],
            )  # fmt: skip
            high, low = (end.coefficient * held[end.section] if end.section else 0.0 for end in (gap.high, gap.low))
            drop = np.maximum(high - low, 0.0)
            grows = 0.5 * (land.body_expansion * bore - land.spool_expansion * d) * (temperature - 20.0)
            c = np.maximum(0.5 * (bore - d + off_bore - off_d) + grows, 1e-9)
            friction = 12.0 * nu * rho * (land.contact_length + longer) / c**2
            u = (np.sqrt(friction**2 + 3.0 * rho * drop) - friction) / (1.5 * rho)
            total = total + math.pi * (d + c) * c * u
        pump = self.controller.pump
        slip = 5e-8 * main / (2.0 * math.pi * nu * rho) * np.exp(0.2 * z["slip_coefficient"])
        return total, total / (pump.displacement * (sample["engine_speed"] - slip))


@pytest.fixture(scope="module")
def log(log_of: Callable[..., RoadTest]) -> RoadTest:
    """Two stretches with noise, holes and a gear that the unit does not have."""
    rng = np.random.default_rng(8)
    count = 240
    time = np.cumsum(rng.uniform(0.1, 0.2, count))
    time[140:] += 20.0
    channels = {
        "main_pressure": 700e3 + 300e3 * np.sin(time / 3.0) + rng.normal(0.0, 40e3, count),
        "converter_pressure": rng.uniform(250e3, 400e3, count),
        "atf_temperature": np.linspace(55.0, 97.0, count) + rng.normal(0.0, 1.0, count),
        "engine_speed": 25.0 + 12.0 * np.cos(time / 2.0) + rng.normal(0.0, 1.0, count),
        "gear": np.repeat([1.0, 2.0, 3.0, 2.0, 4.0, 9.0], count // 6),
    }
    for name in ("main_pressure", "atf_temperature"):
        channels[name][rng.random(count) < 0.05] = NAN
    halves = ((0, 140), (140, count - 140))
    parts = tuple(Segment(at, rows, time[at], time[at + rows - 1] - time[at]) for at, rows in halves)
    return replace(log_of(time, **channels), segments=parts)


def test_extremes_of_a_log_and_their_intervals(
    four_speed: Controller, hipol: Fluid, limits: Limits, log: RoadTest, readings_of: Callable[..., Any]
) -> None:
    unit = Unit(four_speed)
    diagnosis = diagnose(
        four_speed, hipol, limits, readings=readings_of(four_speed, unit.sizes), road_test=log,
        profile=WORKSHOP.with_options(entry_loss="on"), assumptions=ASSUMED,
        instruments=two_instruments(calibration=CALIBRATION, common_part=0.5),
    )  # fmt: skip
    samples = [{name: float(log.values(name)[row]) for name in log.channels} for row in range(len(log.time))]
    known = [row for row, each in enumerate(samples) if each["gear"] < 9 and not any(map(math.isnan, each.values()))]
    flows, shares = np.full((2, len(samples)), NAN)
    for row in known:
        flows[row], shares[row] = unit.at(samples[row])
    window = 0.5 * max(0.5, 5.0 * float(np.median(np.diff(log.time))))

    def sustained(values: np.ndarray) -> tuple[float, list[int]]:
        """The largest median, and the samples that it was taken of."""
        found = []
        for row in range(len(samples)):
            first = 0 if row < 140 else 140
            stretch = range(first, 140 if first == 0 else len(samples))
            near = [at for at in stretch if abs(log.time[at] - log.time[row]) <= window and at in known]
            if len(near) >= 5:
                found.append((float(np.median(values[near])), near))
        return max(found)

    road = diagnosis.road
    for single, place in (
        (road.max_leakage, np.nanargmax(flows)),
        (road.min_leakage, np.nanargmin(flows)),
        (road.max_share, np.nanargmax(shares)),
    ):
        assert (single.sample, single.time) == (place, log.time[place])
        assert (single.leakage, single.share) == pytest.approx((flows[place], shares[place]), rel=1e-9, abs=0.0)
    for lasting, values in (
        (road.extremes.max_leakage_sustained, flows),
        (road.extremes.max_share_sustained, shares),
    ):
        most, near = sustained(values)
        assert (lasting.leakage if values is flows else lasting.share) == pytest.approx(most, rel=1e-9, abs=0.0)
        assert lasting.sample in near
        assert abs(values[lasting.sample] - most) == pytest.approx(np.min(np.abs(values[near] - most)), abs=1e-12)
    assert len(road.instants) == 5
    for instant in road.instants:
        drawn, interval = unit.at(samples[instant.sample], drawn=True), diagnosis.uncertainty.instants[instant]
        for own, nominal, stated, ends in (
            (drawn[0], flows[instant.sample], instant.leakage, interval.leakage_interval),
            (drawn[1], shares[instant.sample], instant.share, interval.share_interval),
        ):
            expected = np.quantile(own, (0.025, 0.975)) / nominal
            assert np.array(ends) / stated == pytest.approx(expected, abs=0.006)
