"""Gather what a road-test log says by itself, whether or not the valve body was measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.engine.lasting import CountedSamples
from atleak.engine.road_pressure import (
    CommandedPressure,
    NotJudged,
    RoadPressure,
    compare_with_commanded,
    judge_pressure,
)
from atleak.events import Event, events
from atleak.road_test import RoadTest


@dataclass(frozen=True)
class RoadFindings:
    """What a log says by itself: its events, gears and temperatures, and its main pressure beside what it should be."""

    road_test: RoadTest
    events: tuple[Event, ...]
    gears: dict[int, float]  # gear → time in it with the engine running [s]; none where no gear is logged
    temperatures: tuple[float, float] | None  # lowest and highest of the fluid [°C]; None where not logged
    pressure: RoadPressure | NotJudged
    commanded: CommandedPressure | None

    @property
    def permitted(self) -> RoadPressure | None:
        """Return main pressure beside what is permitted; None where it could not be judged."""
        return self.pressure if isinstance(self.pressure, RoadPressure) else None

    @property
    def not_judged(self) -> NotJudged | None:
        """Return why main pressure could not be judged; None where it was."""
        return None if isinstance(self.pressure, RoadPressure) else self.pressure


def road_findings(controller: Controller, road_test: RoadTest) -> RoadFindings:
    """Return what a log says by itself.

    Parameters
    ----------
    controller
        the valve body, with its gears and what it permits of main pressure.
    road_test
        any log: what it lacks is left out.
    """
    return RoadFindings(
        road_test=road_test,
        events=events(road_test, gears=controller.gears),
        gears=_gears(road_test),
        temperatures=_temperatures(road_test),
        pressure=judge_pressure(controller, road_test),
        commanded=compare_with_commanded(road_test),
    )


def _gears(road_test: RoadTest) -> dict[int, float]:
    gear = road_test.values("gear")
    if gear is None:
        return {}
    counted = CountedSamples(road_test)
    return {int(each): counted.time_of(gear == each) for each in np.unique(gear[np.isfinite(gear)])}


def _temperatures(road_test: RoadTest) -> tuple[float, float] | None:
    logged = road_test.values("atf_temperature")
    if logged is None or not np.isfinite(logged).any():
        return None
    return float(np.nanmin(logged)), float(np.nanmax(logged))
