"""The mileage at which a land is to be replaced: where one visit tells it, and where it does not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import NO_RATE
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.measurements.readings import Readings, SheetIdentity
from tests.unit.conftest import at_wear, codes

Edited = Callable[..., Path]
Build = Callable[..., Readings]
REGULATOR, SECOND, TCC, PISTON = (
    ("pressure_regulator", 1),
    ("pressure_regulator", 2),
    ("tcc_regulator", 1),
    ("accumulator", 1),
)


def measured_when_new(controller: Controller) -> Controller:
    """The same valve body, of whose pairs somebody measured the mounting clearance when they were new."""
    return replace(controller, lands=tuple(replace(land, mounting_measured=True) for land in controller.lands))


def test_mileage_at_which_a_land_reaches_its_limit(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = readings_of(minimal, at_wear(minimal, pressure_regulator=0.3, tcc_regulator=0.7, accumulator=-0.01))
    measured = measured_when_new(minimal)
    diagnosis = diagnose(measured, hipol, limits, readings=readings, mileage_km=100_000.0)
    lands = {land.key: land for land in diagnosis.lands}
    at = lands[REGULATOR].replace_mileage
    assert at.value == pytest.approx(100_000.0 * 0.5 / 0.3, rel=1e-6, abs=0.0)
    assert 100_000.0 < at.low < at.value < at.high
    assert at.foreseeable
    # the interval ends where the band of the line from 0 km through the reading crosses the limit
    new, now = minimal.land(*REGULATOR).mounting_high, lands[REGULATOR].state.radial_clearance
    u = lands[REGULATOR].uncertainty.u_clearance
    for end, sign in ((at.low, 1.0), (at.high, -1.0)):
        part = end / 100_000.0
        spread = math.hypot((1.0 - part) * DEFAULTS.mounting_clearance, part * u)
        edge = new + part * (now - new) + sign * 1.6448536 * spread
        assert edge == pytest.approx(1.5 * new, rel=1e-6, abs=0.0)
    assert lands[TCC].replace_mileage is None  # reached already
    assert not lands[PISTON].replace_mileage.foreseeable  # perhaps it does not wear at all
    assert lands[SECOND].replace_mileage is None  # not measured
    assert NO_RATE not in codes(diagnosis)


def test_one_visit_and_a_mounting_clearance_that_nobody_measured_give_no_projection(sample: Diagnosis) -> None:
    assert sample.mileage == 106_315.0
    assert {land.replace_mileage for land in sample.lands} == {None}
    said = next(message.text for message in sample.messages if message.code == NO_RATE)
    assert "of 47 of 47 measured lands" in said


def test_a_land_that_was_repaired_since_has_no_point_at_0_km(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    measured = measured_when_new(minimal)
    fitted = tuple(replace(land, fitted="sleeve") if land.key == REGULATOR else land for land in measured.lands)
    readings = readings_of(minimal, at_wear(minimal, pressure_regulator=0.3, accumulator=0.3))
    diagnosis = diagnose(replace(measured, lands=fitted), hipol, limits, readings=readings, mileage_km=100_000.0)
    lands = {land.key: land.replace_mileage for land in diagnosis.lands}
    assert lands[REGULATOR] is None
    assert lands[PISTON] is not None
    assert "of 1 of 2 measured lands" in next(each.text for each in diagnosis.messages if each.code == NO_RATE)


def test_a_file_says_whether_its_mounting_clearances_were_measured(edited: Edited) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        ("mounting_clearance_um = 16.0 }", 'mounting_clearance_um = 16.0, measured = ["mounting_clearance_um"] }'),
        (
            "mounting_clearance_um = 14.0 }",
            'mounting_clearance_um = [10.0, 14.0], measured = ["mounting_clearance_um"] }',
        ),
    )
    said = {land.key: land.mounting_measured for land in load_controller(path).lands}
    assert {key for key, measured in said.items() if measured} == {TCC}


def test_without_mileage_none_is_projected(sample: Diagnosis, limits: Limits, hipol: Fluid) -> None:
    assert sample.readings is not None
    unstated = replace(sample.readings, identity=SheetIdentity())
    diagnosis = diagnose(measured_when_new(sample.controller), hipol, limits, readings=unstated)
    assert {land.replace_mileage for land in diagnosis.lands} == {None}
    assert NO_RATE not in codes(diagnosis)
