"""Repairs that are ticked: what any set of them leaves of the unit, and the decisions they become."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.analysis.estimate import decided_repairs, estimate, prices_of, with_repair, with_repairs
from atleak.analysis.repair.choice import Basis, OfferedRepairs, choose
from atleak.analysis.repair.options import MoveKey
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import Goal, Repair
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import project
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings

PR, TCC, ACC = "pressure_regulator", "tcc_regulator", "accumulator"
SLEEVE, SPOOL = (
    Repair(kind, ((PR, 1),), kind, f"{kind} as made up", "made up", price=price, currency="EUR", hours=1.0)
    for kind, price in (("sleeve", 60.0), ("oversize_spool", 25.0))
)
WORN = {(PR, 1): 1.5, (PR, 2): 1.2, (TCC, 1): 0.05, (ACC, 1): 1.8}


@pytest.fixture(scope="module")
def repairs(minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]) -> OfferedRepairs:
    """The minimal example with three lands past their limits, one worn a little, and two ways to mend one of them."""
    controller = replace(minimal, repairs=(SLEEVE, SPOOL))
    diameters = {}
    for key, growth in WORN.items():
        land = controller.land(*key)
        clearance = (1.0 + growth) * land.mounting_high
        diameters[key] = (land.nominal_diameter, land.nominal_diameter + 2.0 * clearance)
    diagnosis: Diagnosis = diagnose(controller, hipol, limits, readings=readings_of(controller, diameters))
    return OfferedRepairs(diagnosis)


def states_of(repairs: OfferedRepairs) -> dict[object, str | None]:
    made = estimate(repairs.diagnosis, Job())
    return {line.key: line.decision.decision for line in made.lines}


def turned(repairs: OfferedRepairs, job: Job, key: MoveKey, *, on: bool) -> Job:
    return with_repair(estimate(repairs.diagnosis, job), repairs, job, key, on=on)


def test_what_flagged_lands_call_for_is_offered_first_and_all_ways_of_it(repairs: OfferedRepairs) -> None:
    called_for = [each.key for each in repairs.all if each.called_for]
    assert set(called_for) == {"sleeve", "oversize_spool", (PR, 2), (ACC, 1)}
    assert [each.key for each in repairs.all][len(called_for) :] == [(TCC, 1)]
    ranks = [max(land.verdict.rank for land in each.lands) for each in repairs.all if each.called_for]
    assert ranks == sorted(ranks, reverse=True)


def test_a_set_of_repairs_is_what_the_engine_computes_of_the_unit_with_those_lands_new(
    repairs: OfferedRepairs,
) -> None:
    chosen = {(PR, 2), (ACC, 1), "a repair that nobody offers"}
    diagnosis = repairs.diagnosis
    mended = dict(zip([each.state.land.key for each in diagnosis.lands], diagnosis.as_new.clearances, strict=True))
    states = tuple(mended[land.key] if land.key in chosen else land.state for land in diagnosis.lands)
    model = LeakageModel(diagnosis.controller, states, diagnosis.fluid, diagnosis.profile)
    for at in estimate(diagnosis, with_repairs(repairs, Job(), chosen)).effect:
        expected = project(model, at.condition)
        assert at.after.share == pytest.approx(expected.share, rel=1e-9, abs=0.0)
        assert at.after.pressures["p_g"] == pytest.approx(expected.main_pressure_held, rel=1e-9, abs=0.0)
        assert at.before.share == pytest.approx(diagnosis.at(at.condition).share, rel=1e-9, abs=0.0)


def test_two_ways_to_mend_one_land_exclude_each_other(repairs: OfferedRepairs) -> None:
    assert repairs.excluded_by("sleeve") == {"oversize_spool"}
    assert repairs.excluded_by((ACC, 1)) == frozenset()
    sleeved = turned(repairs, with_repairs(repairs, Job(), {(ACC, 1)}), "sleeve", on=True)
    assert decided_repairs(repairs, sleeved) == {"sleeve", (ACC, 1)}
    oversize = turned(repairs, sleeved, "oversize_spool", on=True)
    assert decided_repairs(repairs, oversize) == {"oversize_spool", (ACC, 1)}
    assert decided_repairs(repairs, turned(repairs, sleeved, (ACC, 1), on=False)) == {"sleeve"}


def test_a_repair_that_is_taken_out_leaves_every_other_line_to_the_verdict(repairs: OfferedRepairs) -> None:
    job = turned(repairs, Job(), (ACC, 1), on=False)
    assert [(each.pair, each.decision) for each in job.repair_decisions] == [(f"{ACC}/1", None)]
    back = turned(repairs, job, (ACC, 1), on=True)
    assert [(each.pair, each.decision) for each in back.repair_decisions] == [(f"{ACC}/1", "proposed")]
    worn_little = turned(repairs, Job(), (TCC, 1), on=True)
    assert [(each.pair, each.decision) for each in worn_little.repair_decisions] == [(f"{TCC}/1", "proposed")]
    assert turned(repairs, worn_little, (TCC, 1), on=True) == worn_little


def test_the_estimate_carries_out_what_was_ticked_and_nothing_else(repairs: OfferedRepairs) -> None:
    assert set(states_of(repairs).values()) == {"proposed"}
    for keys in ({"sleeve", (TCC, 1)}, {"oversize_spool"}, set(), {(PR, 2), (ACC, 1), "sleeve"}):
        job = with_repairs(repairs, Job(), keys)
        made = estimate(repairs.diagnosis, job)
        assert {line.key for line in made.lines if line.carried_out} == {
            key if isinstance(key, str) else f"{key[0]}/{key[1]}" for key in keys
        }
        assert decided_repairs(repairs, job) == keys
        assert with_repairs(repairs, job, keys) == job


def test_decisions_that_agree_stay_as_they_are(repairs: OfferedRepairs) -> None:
    record = Job(
        repair_decisions=[
            {"component": ACC, "land": 1, "decision": "approved", "price": 12.5},
            {"component": PR, "land": 2, "decision": "declined", "reason": "too dear"},
            {"component": TCC, "land": 1, "decision": "done"},
            {"work": "clean the strainer", "decision": "done"},
        ]
    )
    assert decided_repairs(repairs, record) == {(ACC, 1), (TCC, 1)}
    accumulator, declined, converter, strainer, *others = with_repairs(repairs, record, {(ACC, 1)}).repair_decisions
    assert (accumulator, declined, strainer) == tuple(record.repair_decisions[place] for place in (0, 1, 3))
    assert converter.decision is None
    assert {each.decision for each in others} == {None}


def test_fewest_asks_for_no_price_and_cheapest_takes_the_cheaper_way(repairs: OfferedRepairs) -> None:
    terms = {"currency": "EUR", "labour_rate": 50.0}
    own = [{"component": key[0], "land": key[1], "price": 5.0, "hours": 0.5} for key in ((PR, 2), (ACC, 1))]
    prices = prices_of(Job(estimate=terms, repair_decisions=own), repairs.diagnosis.controller)
    cheapest = choose(repairs.diagnosis, Goal.EVERY_LIMIT, prices)
    assert cheapest.basis is Basis.CHEAPEST
    assert {move.key for move in cheapest.chosen} == {"oversize_spool", (PR, 2), (ACC, 1)}
    fewest = choose(repairs.diagnosis, Goal.EVERY_LIMIT, prices, fewest=True)
    assert fewest.basis is Basis.FEWEST
    assert len(fewest.chosen) == len(cheapest.chosen)
