"""Simulated units of one type, all made up: new pairs scatter about their type, some are worn, readings err."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from atleak.catalogue.controller import Controller
from atleak.measurements.readings import Reading, Readings

READING = 1.5e-6  # [m] standard uncertainty of one diameter, read once: that of a radial clearance is 1/√2 of it
OWN = READING / np.sqrt(2.0)
BETWEEN = 1.5e-6  # [m] standard deviation between new pairs of one land
WORN = 3  # row of the worn unit


class Simulated(NamedTuple):
    """Clearances as measured, one row a unit, and the mounting clearances of the type they come from [m]."""

    measured: NDArray[np.float64]
    own: NDArray[np.float64]
    true: NDArray[np.float64]


Simulate = Callable[..., Simulated]


@pytest.fixture(scope="session")
def simulate() -> Simulate:
    """Simulates units: wear of ``depth`` ± 40 % on some lands of one of them; units differ alike by ``shift``."""

    def units(
        random: np.random.Generator,
        units: int = 12,
        lands: int = 29,
        *,
        depth: float = 0.0,
        worn_lands: int | None = None,
        between: float = BETWEEN,
        shift: float = 0.0,
    ) -> Simulated:
        true = random.uniform(10e-6, 20e-6, lands)
        pairs = true + random.normal(0.0, between, (units, lands)) + random.normal(0.0, shift, (units, 1))
        if depth:
            which = random.choice(lands, worn_lands or lands, replace=False)
            pairs[min(WORN, units - 1), which] += depth * random.uniform(0.6, 1.4, which.size)
        measured = pairs + random.normal(0.0, OWN, pairs.shape)
        return Simulated(np.round(measured / 0.5e-6) * 0.5e-6, np.full(pairs.shape, OWN), true)

    return units


@pytest.fixture(scope="session")
def sheet_of() -> Callable[..., Readings]:
    """The measuring sheet of a unit, by the radial clearances [m] of its lands; every diameter read twice."""

    def build(
        controller: Controller,
        clearances: dict[tuple[str, int], float],
        random: np.random.Generator,
        file: str = "unit.xlsx",
        reading: float = READING,
    ) -> Readings:
        found = []
        for (component, land), clearance in clearances.items():
            spool = controller.land(component, land).nominal_diameter
            for part, diameter in (("spool", spool), ("sleeve", spool + 2.0 * clearance)):
                for direction in (0.0, 90.0):
                    for repeat in (1, 2):
                        read = round((diameter + random.normal(0.0, reading)) * 1e6) / 1e6
                        plane = controller.land(component, land).planes[0]
                        found.append(Reading(component, part, plane, direction, repeat, read))  # type: ignore[arg-type]
        return Readings(file, f"sha of {file}", "readings", "mm", False, "tidy", tuple(found))

    return build
