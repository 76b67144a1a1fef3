"""Which repairs are chosen: as good as the best of all sets that there are, and green by the engine."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.analysis.estimate import Estimate
from atleak.analysis.repair.choice import Basis, Choice, choose
from atleak.analysis.repair.options import Move, Prices, StatedPrice
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.repairs import Goal, LandKey, Repair
from atleak.common.verdicts import Band
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import unit_rules
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import project
from atleak.measurements.job_card import EstimateTerms
from atleak.measurements.readings import Readings
from atleak.report.tables.estimate import EstimateWords
from tests.unit.conftest import first_of

Build = Callable[..., Readings]
ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def worn_unit(hipol: Fluid, limits: Limits, readings_of: Build) -> Callable[..., Diagnosis]:
    """Diagnoses a unit of which some lands are worn by a fraction of their clearance when new."""

    def build(controller: Controller, growth: dict[LandKey, float]) -> Diagnosis:
        lands = [controller.land(*key) for key in growth]
        diameters = {
            land.key: (
                land.nominal_diameter,
                land.nominal_diameter + 2.0 * (1.0 + growth[land.key]) * land.mounting_high,
            )
            for land in lands
        }
        return diagnose(controller, hipol, limits, readings=readings_of(controller, diameters))

    return build


def sets_of(choice: Choice) -> Iterator[list[Move]]:
    """Every set of the repairs that are offered, with one option for a land at the most."""
    moves = choice.moves.all
    for chosen in itertools.product((False, True), repeat=len(moves)):
        kept = list(itertools.compress(moves, chosen))
        changed = [key for move in kept if move.option is not None for key in move.lands]
        if len(changed) == len(set(changed)):
            yield kept


def green_sets(choice: Choice) -> list[list[Move]]:
    """Those that bring every total and pressure to green, by the engine, all computed at once."""
    sets = list(sets_of(choice))
    states = [choice.moves.choice(each) for each in sets]
    green = np.ones(len(sets), bool)
    for at, rules in zip(choice.unit.conditions, choice.unit.judged, strict=True):
        done = at.repaired(states)
        for judged in rules:
            first = [limit for _, limit in judged.rule.steps.levels]
            value = judged.value(done.leakage, done.pressures) * judged.likely
            green &= value >= max(first) if judged.rule.steps.falling else value < min(first)
    return list(itertools.compress(sets, green))


def rediagnosed(choice: Choice) -> bool:
    """Whether the repaired unit is green where everything is computed anew, one condition after the other."""
    diagnosis, states = choice.unit.diagnosis, choice.moves.choice(choice.chosen)
    after = tuple(
        choice.unit.states[land.key][states[land.key] - 1] if land.key in states else land.state
        for land in diagnosis.lands
    )
    model = LeakageModel(diagnosis.controller, after, diagnosis.fluid, diagnosis.profile)
    projections = [project(model, each.condition) for each in diagnosis.projections]
    rules = unit_rules(after, projections, diagnosis.unworn_projections, diagnosis.limits)
    return not any(rule.verdict.flagged for rule in (*rules.totals, *rules.pressures))


@pytest.mark.parametrize(("name", "seed"), [("chrysler_41te", 3), pytest.param("gm_4l60e", 3, marks=pytest.mark.slow)])
def test_the_fewest_repairs_of_twelve_flagged_lands_are_those_of_all_4096_sets(
    name: str, seed: int, worn_unit: Callable[..., Diagnosis]
) -> None:
    """Lands of a shipped unit with circuits, so worn that circuits lose more than they may at several conditions."""
    controller = replace(load_controller(name), repairs=())
    drawn, used = random.Random(seed), {gap.key for gap in controller.gaps}
    lands = [land.key for land in controller.lands if land.seal is None and land.key in used]
    diagnosis = worn_unit(controller, {key: drawn.uniform(0.5, 2.5) for key in drawn.sample(lands, 12)})
    assert len(diagnosis.flagged) == 12
    choice = choose(diagnosis, Goal.GREEN)
    past = [rule for total in choice.totals_of([[]])[0] for rule in total.past]
    assert sum(rule.circuit is not None for rule in past) >= 3
    assert len(choice.moves.all) == 12
    assert choice.proven
    assert choice.reached
    assert rediagnosed(choice)
    assert 1 < len(choice.chosen) < 12
    assert len(choice.chosen) == min(map(len, green_sets(choice)))
    everything = choose(diagnosis)
    assert {move.key for move in everything.chosen} == {land.key for land in diagnosis.flagged}


def option(number: int, component: str, lands: tuple[int, ...], price: float | None, hours: float | None) -> Repair:
    return Repair(
        f"option_{number}", component, frozenset(lands), "sleeve", f"option {number}", "made up",
        price=price, currency=None if price is None else "EUR", hours=hours,
    )  # fmt: skip


WORN = (("1", 1), ("1", 2), ("2", 1), ("2", 2), ("3", 2), ("4", 1))  # some leak from one circuit into the next
GROWTH = st.fixed_dictionaries({key: st.floats(0.0, 3.0) for key in WORN})
PRICE = st.one_of(st.none(), st.integers(1, 200).map(float))
OPTIONS = st.lists(
    st.tuples(
        st.sampled_from([("1", (1,)), ("1", (1, 2)), ("2", (1,)), ("2", (2,)), ("2", (1, 2)), ("4", (1,))]), PRICE
    ),
    max_size=6,
)


@settings(max_examples=max(settings().max_examples // 6, 1))  # each computes up to 256 sets
@given(growth=GROWTH, options=OPTIONS, goal=st.sampled_from(Goal), rate=st.sampled_from([None, 60.0]))
def test_a_choice_is_as_good_as_the_best_of_all_sets_and_green_where_any_is(
    growth: dict[LandKey, float],
    options: list[tuple[tuple[str, tuple[int, ...]], float | None]],
    goal: Goal,
    rate: float | None,
    worn_unit: Callable[..., Diagnosis],
    three_circuits: Controller,
) -> None:
    repairs = tuple(
        option(number, component, lands, price, 0.5 * number)
        for number, ((component, lands), price) in enumerate(options)
    )
    diagnosis = worn_unit(replace(three_circuits, repairs=repairs), growth)
    choice = choose(diagnosis, goal, Prices(labour_rate=rate))
    flagged = {land.key for land in diagnosis.flagged}
    asked = flagged if goal is Goal.EVERY_LIMIT else set()
    assert choice.proven
    good = [each for each in green_sets(choice) if {key for move in each for key in move.treats} >= asked]
    assert choice.reached == bool(good) == rediagnosed(choice)
    assert {key for move in choice.chosen for key in move.treats} >= asked
    cost = choice.moves.prices.cost
    if choice.basis is Basis.CHEAPEST:
        priced = [each for each in good if all(cost(move) is not None for move in each)]
        best = min((sum(cost(move) for move in each), len(each)) for each in priced)
        assert (sum(cost(move) for move in choice.chosen), len(choice.chosen)) == best
    else:
        assert len(choice.chosen) == min(map(len, good))


@pytest.fixture(scope="module")
def priced(three_circuits: Controller, worn_unit: Callable[..., Diagnosis]) -> Callable[..., Diagnosis]:
    """Diagnoses the three circuits with the lands of one valve worn and some repairs in the file."""

    def build(*repairs: Repair) -> Diagnosis:
        return worn_unit(replace(three_circuits, repairs=repairs), {("2", 1): 2.0, ("2", 2): 1.0, ("1", 1): 0.0})

    return build


def keys(choice: Choice) -> set[object]:
    return {move.key for move in choice.chosen}


def test_the_cheapest_is_chosen_where_every_price_is_known_and_the_fewest_where_one_is_not(
    priced: Callable[..., Diagnosis],
) -> None:
    single = option(1, "2", (1,), 40.0, 1.0), option(2, "2", (2,), 50.0, 1.0)
    both = option(3, "2", (1, 2), 120.0, 1.0)
    cheapest = choose(priced(*single, both))
    assert (cheapest.basis, keys(cheapest)) == (Basis.CHEAPEST, {"option_1", "option_2"})
    with_work = choose(priced(*single, both), prices=Prices(labour_rate=60.0))  # 180 for the one, 210 for the two
    assert (with_work.basis, keys(with_work)) == (Basis.CHEAPEST, {"option_3"})
    typed = choose(priced(*single, both), prices=Prices(60.0, "EUR", {"option_3": StatedPrice(300.0, 1.0)}))
    assert keys(typed) == {"option_1", "option_2"}
    unknown = choose(priced(single[0], both))  # land 2 alone has no price, and no option of its own
    assert keys(unknown) == {"option_3"}
    no_price = choose(priced(option(1, "2", (1,), None, 1.0), option(2, "2", (2,), 50.0, 1.0)))
    assert (no_price.basis, keys(no_price)) == (Basis.FEWEST, {"option_1", "option_2"})


def test_what_the_workshop_chose_is_taken_whatever_it_costs(priced: Callable[..., Diagnosis]) -> None:
    repairs = option(1, "2", (1,), 40.0, 1.0), option(2, "2", (2,), 50.0, 1.0), option(3, "2", (1, 2), 120.0, 1.0)
    diagnosis = priced(*repairs)
    assert keys(choose(replace(diagnosis, repairs=repairs[2:]))) == {"option_3"}
    assert keys(choose(replace(diagnosis, repairs=repairs[2:]), Goal.GREEN)) >= {"option_3"}
    assert keys(choose(diagnosis, kept=["option_3"])) == {"option_3"}


def test_where_the_search_is_ended_the_repairs_suffice_and_nobody_says_that_they_are_the_fewest(
    priced: Callable[..., Diagnosis],
) -> None:
    repairs = [option(number, "2", lands, None, None) for number, lands in enumerate([(1,), (2,), (1, 2)])]
    choice = choose(priced(*repairs), rounds=0)
    assert choice.chosen
    assert choice.reached
    assert not choice.proven
    assert choose(priced(*repairs)).proven
    assert "The search was ended after 0 proposals" in " ".join(said_of(choice))


def said_of(choice: Choice) -> Iterator[str]:
    made = Estimate(choice.unit.diagnosis, EstimateTerms(), choice, (), "")
    return EstimateWords(made, wording("en")).chosen_by()


def test_a_gain_is_the_rule_that_comes_nearest_to_its_limit_without_a_repair(priced: Callable[..., Diagnosis]) -> None:
    choice = choose(priced())
    gain = choice.gains["2", 1]
    assert gain is not None
    without = [move for move in choice.chosen if move.key != ("2", 1)]
    every = [rule for total in choice.totals_of([without])[0] for rule in (total.rule, *total.pressure_rules)]
    (same,) = [rule for rule in every if rule.id == gain.without.id]
    assert gain.without.value == pytest.approx(same.value, rel=1e-9, abs=0.0)
    assert gain.within.id == gain.without.id
    assert gain.without.circuit is not None
    assert gain.without.circuit.id == "clutch_c1"
    assert gain.without.value > gain.within.value


@pytest.mark.parametrize("name", first_of(["five_speed_2005", "chrysler_41te", "gm_4l60e"]))
def test_a_repair_for_the_permissible_pressure_is_named_so(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    controller = load_controller(name)
    lenient = replace(limits.total_share, levels=((Band.AMBER, 1e3), (Band.CRITICAL, 2e3)), growth={})
    bare = dict.fromkeys(("wear", "clearance", "pair_share", "reserve", "circuit_loss"))
    only_line = replace(limits, total_share=lenient, **bare)
    new = diagnose(controller, hipol, limits).projections
    keys = [land.key for land in controller.lands if not land.seal]
    keys.sort(key=lambda key: max(at.share_drawn_by(key) for at in new), reverse=True)
    sizes = {key: controller.land(*key).nominal_diameter for key in keys[:4]}
    readings = readings_of(controller, {key: (size, size + 2.0 * 180e-6) for key, size in sizes.items()})
    chosen = choose(diagnose(controller, hipol, only_line, readings=readings), Goal.GREEN)
    assert chosen.chosen
    named = [gain for gain in chosen.gains.values() if gain is not None]
    assert len(named) == len(chosen.chosen)
    assert all(gain.without.kind is RuleKind.PERMISSIBLE_PRESSURE for gain in named)
    assert all(gain.within.value <= 0.0 < gain.without.value for gain in named)
