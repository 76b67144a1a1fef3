"""Visits of one small unit, made from readings of chosen clearances without diagnosing it."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Iterable, Mapping

import pytest

from atleak.analysis.history.series import Visit
from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings

VisitAt = Callable[..., Visit]


def visit_from(
    controller: Controller,
    readings: Readings,
    year: int,
    mileage: float | None,
    repaired: Iterable[LandKey] = (),
    instruments: Instruments | None = None,
) -> Visit:
    """The visit of the first of May at which a sheet with these readings was measured."""
    gauges = instruments or load_instruments()
    states = clearances(readings, controller)
    lands, _ = find_sources(states, readings, controller, gauges, DEFAULTS)
    return Visit(dt.date(year, 5, 1), mileage, controller.id, lands, frozenset(repaired), str(year))


@pytest.fixture(scope="session")
def visit_at(minimal: Controller, readings_of: Callable[..., Readings]) -> VisitAt:
    """A visit of a unit of which some lands have these clearances [µm]; of the smallest valve body unless given."""

    def build(
        year: int,
        mileage: float | None,
        um: Mapping[LandKey, float],
        *,
        controller: Controller = minimal,
        repaired: Iterable[LandKey] = (),
        instruments: Instruments | None = None,
    ) -> Visit:
        diameters = {}
        for key, clearance in um.items():
            spool = controller.land(*key).nominal_diameter
            diameters[key] = (spool, spool + 2e-6 * clearance)
        readings = readings_of(controller, diameters)
        return visit_from(controller, readings, year, mileage, repaired, instruments)

    return build
