"""How likely a land is worn that was new in a range: against units drawn one by one, and as readers see it."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.wear import UnitWear
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.lands import pair_table

RANGE = (6.4e-6, 20e-6)
UM = 1e-6


def a_land(number: int, clearance: float, new: tuple[float, float] = RANGE, u: float = 1.2e-6) -> Any:
    pair = SimpleNamespace(mounting_range=new, seal=None)
    state = SimpleNamespace(shows_wear=True, land=pair, radial_clearance=clearance)
    return SimpleNamespace(key=("1", number), state=state, standard_uncertainty=u, u_mounting=0.5e-6)


def drawn(clearances: list[float], limit: float, least: float, units: int = 4000, pairs: int = 500) -> np.ndarray:
    """The same by brute force: units as assumed, their pairs drawn, each weighed by how near it is to its reading."""
    rng, shape = np.random.default_rng(5), (units, pairs)
    worn_unit = rng.random(units) < 1.25 * DEFAULTS.worn_lands
    part = np.where(worn_unit, rng.random(units) ** 0.25, 0.0)[:, None]
    mean = DEFAULTS.land_wear * 4.0 ** rng.uniform(-1.0, 1.0, (units, 1))
    near, past = [], []
    for clearance in clearances:
        new = rng.uniform(*RANGE, shape)
        wear = np.where(rng.random(shape) < part, rng.exponential(mean, shape), 0.0)
        weight = np.exp(-0.5 * ((clearance - new - wear) / 1.2e-6) ** 2)
        near.append(weight.mean(axis=1))
        past.append((weight * (wear >= np.maximum(limit * new, least))).mean(axis=1))
    of_unit = np.prod(near, axis=0)
    return np.array([np.sum(of_unit * over / each) for over, each in zip(past, near, strict=True)]) / np.sum(of_unit)


def test_probabilities_are_those_of_units_drawn_one_by_one(limits: Limits) -> None:
    clearances = [9e-6, 18e-6, 26e-6]
    found = UnitWear([a_land(*each) for each in enumerate(clearances)], DEFAULTS).past(limits.wear)
    watch, replace = np.array([found["1", number] for number in range(3)]).T
    assert watch == pytest.approx(drawn(clearances, 0.1, 4 * UM), abs=0.02)
    assert replace == pytest.approx(drawn(clearances, 0.5, 0.0), abs=0.02)


def test_what_the_other_lands_show_counts(limits: Limits) -> None:
    def of_first(others: list[float]) -> float:
        lands = [a_land(*each) for each in enumerate([15e-6, *others])]
        return UnitWear(lands, DEFAULTS).past(limits.wear)["1", 0][0]

    new, alone, worn = of_first([8e-6, 11e-6, 14e-6, 17e-6, 19e-6] * 4), of_first([]), of_first([25e-6, 40e-6] * 8)
    assert new < 0.01 < alone < 0.3 < worn < 1.0


def test_a_number_says_nothing_of_itself_and_tells_of_its_unit(limits: Limits) -> None:
    known = [a_land(number, 30e-6, (14e-6, 14e-6)) for number in range(1, 8)]
    assert UnitWear(known, DEFAULTS).past(limits.wear) == {}
    beside = UnitWear([a_land(0, 15e-6), *known], DEFAULTS).past(limits.wear)
    assert set(beside) == {("1", 0)}
    assert beside["1", 0] > UnitWear([a_land(0, 15e-6)], DEFAULTS).past(limits.wear)["1", 0]


@pytest.mark.parametrize("clearance", [-20e-6, 0.0, 6e-6, 23e-6, 60e-6, 900e-6, 5e-3])
@pytest.mark.parametrize("settings", [{}, {"worn_lands_percent": 0}, {"worn_lands_percent": 90}, {"land_wear_um": 0}])
@pytest.mark.parametrize("u", [0.0, 1e-6, 5e-6])
def test_no_less_than_from_the_upper_end_and_never_past_one(
    limits: Limits, clearance: float, settings: dict[str, float], u: float
) -> None:
    assumed = DEFAULTS.with_settings(settings)
    watch, replace = UnitWear([a_land(1, clearance, u=u)], assumed).past(limits.wear)["1", 1]
    assert 0.0 <= replace <= watch <= 1.0
    if clearance > 40e-6:
        assert replace > 0.99
    if clearance < RANGE[0]:
        assert watch < 0.3


@pytest.fixture
def half_worn(hipol: Any, limits: Limits, readings_of: Any) -> Diagnosis:
    """Five lands as new ones are, in a unit of which others have plainly worn."""
    unit = load_controller("five_speed_2005")
    at = dict(zip([land.key for land in unit.lands], [8, 9, 14, 17, 19, 30, 33, 38, 45, 29, 52], strict=False))
    sizes = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2e-6 * at[land.key])
        for land in unit.lands
        if land.key in at
    }
    return diagnose(unit, hipol, limits, readings=readings_of(unit, sizes))


def test_within_the_range_of_new_is_no_plain_pass_and_asks_for_an_unworn_end(half_worn: Diagnosis) -> None:
    within = [land for land in half_worn.lands if land.within_new]
    assert len(within) == 5
    assert {land.verdict for land in within} == {Verdict.OK}
    shown = [land for land in within if land.shown_as == "within_range"]
    assert shown
    html = pair_table(half_worn, shown, wording("en"), at=()).html()
    assert html.count("within the range of new") == len(shown)
    record = json.loads(json.dumps(diagnosis_record(half_worn)))
    for land in shown:
        (one,) = (each for each in record["lands"] if (each["component"], each["land"]) == land.key)
        assert one["decision"] == "conditional_pass"
        assert one["probability_over_limit"] > 0.05
        assert "unworn end first" in one["advice"]
    assert "unworn end" in record["answer"]["text"]["sure"]
    assert not {step.land.key for step in plan_repairs(half_worn).steps} & {land.key for land in shown}
