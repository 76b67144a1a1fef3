"""Sheets as they come: parts, places and rules missing in every way. Nothing breaks, nothing is made up."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import Limits
from atleak.diagnosis.uncertainty import DECISIONS, DEFAULTS
from tests.unit.diagnosis.uncertainty.conftest import a_sheet

UM = 1e-6


@pytest.mark.parametrize("seed", range(12))
def test_any_part_of_a_sheet_can_be_missing(judge: Callable, four_speed: Controller, limits: Limits, seed: int) -> None:
    rng = np.random.default_rng(seed)
    directions = ((0.0, 90.0), (0.0,), (None,), (0.0, 60.0, 120.0))[seed % 4]
    sheet = a_sheet(
        four_speed,
        clearance=rng.uniform(10.0, 45.0) * UM,
        directions=directions,
        repeats=int(rng.integers(1, 4)),
        noise=0.8 * UM,
        step=1 * UM,
        mirrored=bool(seed % 3 == 0),
        seed=seed,
    )
    kept = tuple(reading for reading in sheet.readings if rng.random() < 0.6)
    rules = replace(
        limits,
        wear=limits.wear if seed % 2 else None,
        pair_share=limits.pair_share if seed % 5 else None,
    )
    tools = load_instruments(*(("workshop_microscope",) * 2 if seed % 2 else ("micrometer", "air_gauge")))
    unit = judge(replace(sheet, readings=kept), limits=rules, instruments=tools, assumptions=DEFAULTS, draws=400).unit
    for land in unit.lands:
        if not land.sources.state.measured:
            assert (land.u_clearance, land.decision, land.advice, land.rules) == (None, None, None, ())
            continue
        assert land.u_clearance > 0.1 * UM
        assert math.fsum(part for _, part in land.budget) == pytest.approx(1.0, rel=1e-9, abs=0.0)
        low, high = land.clearance_interval
        assert low <= land.sources.state.radial_clearance <= high
        assert (land.decision in DECISIONS) == bool(land.rules)
        for rule in land.rules:
            assert 0.0 <= rule.probability_over_limit <= 1.0
            assert (land.advice_on(rule) is None) == (not rule.conditional)
        for at in land.conditions:
            assert at.leakage_interval[0] <= at.leakage_interval[1]
            assert math.isfinite(at.u_share)
