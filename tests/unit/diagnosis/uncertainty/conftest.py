"""A unit to be uncertain about: measuring sheets made to order, assessed at the controller's conditions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import Instrument, Instruments
from atleak.catalogue.limits import Limits
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import NOTHING_ELSE, Assumptions, UnitUncertainty, assess
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP, Profile
from atleak.engine.projection import Projection, project, project_unworn
from atleak.measurements.clearances import LandClearance, clearances
from atleak.measurements.readings import Reading, Readings


def an_instrument(**changed: Any) -> Instrument:
    given = {
        "id": "bench",
        "name": "Bench",
        "source": "test",
        "date": "2026-01-01",
        "note": "",
        "measures": ("spool", "sleeve"),
        "resolution": 1e-9,
        "calibration": 1.5e-6,
        "common_part": 0.0,
        "repeatability": 0.0,
        "alike_inside_and_outside": True,
        "representative": (),
    }
    return Instrument(**{**given, **changed})


def two_instruments(**changed: Any) -> Instruments:
    """Two of a kind: their common errors are two errors."""
    return Instruments(an_instrument(id="outside", **changed), an_instrument(id="inside", **changed))


def new_at(controller: Controller, clearance: float) -> Controller:
    """The same controller with one mounting clearance [m] for all its lands."""
    return replace(controller, lands=tuple(replace(land, mounting_clearance=clearance) for land in controller.lands))


def a_sheet(
    controller: Controller,
    *,
    clearance: float | None = None,
    directions: tuple[float | None, ...] = (0.0, 90.0),
    repeats: int = 1,
    noise: float = 0.0,
    step: float = 0.0,
    mirrored: bool = False,
    ovality: float = 0.0,
    leave_out: tuple[tuple[str, int], ...] = (),
    seed: int = 1,
) -> Readings:
    """Every land at one radial clearance (else its mounting clearance), read as asked."""
    rng = np.random.default_rng(seed)
    readings = []
    for land in controller.lands:
        if land.key in leave_out:
            continue
        c = land.mounting_clearance if clearance is None else clearance
        spool = land.nominal_diameter
        if not step:  # no two lands the same, or the sheet would look as if written in coarse steps
            spool += rng.uniform(0.0, 1e-6)
        for part, diameter in (("spool", spool), ("sleeve", spool + 2.0 * c)):
            for plane in land.planes:
                for direction in directions:
                    form = ovality if part == "sleeve" and direction == directions[0] else 0.0
                    for repeat in range(repeats):
                        read = diameter + form + rng.normal(0.0, noise)
                        read = round(read / step) * step if step else read
                        ends = (0.02, 0.02 + read) if repeat % 2 == 0 else (0.02 + read, 0.02)
                        readings.append(
                            Reading(
                                land.component,
                                part,
                                plane,
                                direction,
                                repeat + 1,
                                read,
                                coordinates=ends if mirrored else None,
                            )
                        )
    return Readings("sheet.csv", "", None, "mm", False, "tidy", tuple(readings))


@pytest.fixture(scope="module", autouse=True)
def as_for_users(all_draws: None) -> None:
    """Draw as often as for users: the draws are what is tested here."""


@dataclass(frozen=True)
class Case:
    model: LeakageModel
    states: tuple[LandClearance, ...]
    projections: tuple[Projection, ...]
    unit: UnitUncertainty


@pytest.fixture
def judge(four_speed: Controller, hipol: Fluid, limits: Limits) -> Callable[..., Case]:
    """Assess a sheet of the four-speed controller; only the instruments err unless told otherwise."""

    def run(
        sheet: Readings,
        *,
        controller: Controller = four_speed,
        instruments: Instruments | None = None,
        assumptions: Assumptions = NOTHING_ELSE,
        profile: Profile = WORKSHOP,
        limits: Limits = limits,
        **more: Any,
    ) -> Case:
        states = clearances(sheet, controller)
        model = LeakageModel(controller, states, hipol, profile)
        projections = tuple(project(model, point) for point in controller.operating_points)
        unit = assess(
            model,
            states,
            projections,
            unit_rules(states, projections, project_unworn(states, model, projections), limits),
            readings=sheet,
            instruments=instruments or two_instruments(),
            assumptions=assumptions,
            **more,
        )
        return Case(model, states, projections, unit)

    return run


@pytest.fixture(scope="session")
def twenty_lands(four_speed: Controller) -> Controller:
    """Twenty equal lands that leak from main pressure to the sump."""
    gap = next(gap for gap in four_speed.gaps_in(2) if gap.into_sump and gap.section == "p_g")
    land = four_speed.land(*gap.key)
    numbers = range(1, 21)
    return replace(
        four_speed,
        lands=tuple(replace(land, component=str(n), land=1, planes=("1",), clearance_limit=None) for n in numbers),
        gaps=tuple(replace(gap, component=str(n), land=1) for n in numbers),
        operating_points=four_speed.operating_points[:1],
    )
