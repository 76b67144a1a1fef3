"""Which repairs are chosen: as good as the best of all sets that there are, and green by the engine."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.analysis.estimate import Estimate, decided_repairs, estimate, with_repair, with_repairs
from atleak.analysis.record_doubts import record_doubts
from atleak.analysis.repair.choice import Basis, Choice, OfferedRepairs, choose
from atleak.analysis.repair.options import Move, Moves, Options, Prices, StatedPrice, together
from atleak.analysis.repair.plan import plan_repairs
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
from atleak.measurements.job_card import EstimateTerms, Job
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.estimate import EstimateWords
from atleak.report.tables.repairs import offered_words, option_record, step_in_words
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
    """Every set of the repairs that are offered, with one option for a land at the most, and none besides as new."""
    moves = choice.moves.all
    for chosen in itertools.product((False, True), repeat=len(moves)):
        kept = list(itertools.compress(moves, chosen))
        changed = [key for move in kept if move.option is not None for key in move.lands]
        mended = {key for move in kept if move.option is not None for key in move.option.mending}
        if len(changed) == len(set(changed)) and not any(move.key in mended for move in kept):
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


def rediagnosed(diagnosis: Diagnosis, choice: Choice) -> bool:
    """Whether the repaired unit is green where everything is computed anew, one condition after the other."""
    states = choice.moves.choice(choice.chosen)
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
    assert rediagnosed(diagnosis, choice)
    assert 1 < len(choice.chosen) < 12
    assert len(choice.chosen) == min(map(len, green_sets(choice)))
    everything = choose(diagnosis)
    assert {move.key for move in everything.chosen} == {land.key for land in diagnosis.flagged}


def option(number: int, component: str, lands: tuple[int, ...], price: float | None, hours: float | None) -> Repair:
    return kit(number, tuple((component, land) for land in lands), price, hours)


def kit(number: int, lands: tuple[LandKey, ...], price: float | None, hours: float | None = None) -> Repair:
    return Repair(
        f"option_{number}", lands, "sleeve", f"option {number}", "made up",
        price=price, currency=None if price is None else "EUR", hours=hours,
    )  # fmt: skip


WORN = (("1", 1), ("1", 2), ("2", 1), ("2", 2), ("3", 2), ("4", 1))  # some leak from one circuit into the next
GROWTH = st.fixed_dictionaries({key: st.floats(0.0, 3.0) for key in WORN})
PRICE = st.one_of(st.none(), st.integers(1, 200).map(float))
ALL = tuple(sorted(WORN))
COVERED = (ALL[:1], ALL[:2], ALL[2:3], ALL[3:4], ALL[2:4], ALL[5:], ALL[:4], ALL[1:3], ALL[3:5], ALL)  # kits last
LEAVES = st.sampled_from([None, None, 18e-6, 25e-6])
OPTIONS = st.lists(st.tuples(st.sampled_from(COVERED), PRICE, LEAVES), max_size=6)


@settings(max_examples=max(settings().max_examples // 6, 1))  # each computes up to 256 sets
@given(growth=GROWTH, options=OPTIONS, goal=st.sampled_from(Goal), rate=st.sampled_from([None, 60.0]))
def test_a_choice_is_as_good_as_the_best_of_all_sets_and_green_where_any_is(
    growth: dict[LandKey, float],
    options: list[tuple[tuple[LandKey, ...], float | None, float | None]],
    goal: Goal,
    rate: float | None,
    worn_unit: Callable[..., Diagnosis],
    three_circuits: Controller,
) -> None:
    repairs = tuple(
        replace(kit(number, lands, price, 0.5 * number), mounting_clearance=leaves)
        for number, (lands, price, leaves) in enumerate(options)
    )
    diagnosis = worn_unit(replace(three_circuits, repairs=repairs), growth)
    choice = choose(diagnosis, goal, Prices(labour_rate=rate))
    flagged = {land.key for land in diagnosis.flagged}
    asked = flagged if goal is Goal.EVERY_LIMIT else set()
    assert choice.proven
    plan = plan_repairs(diagnosis)
    planned = {step.chosen.repair for step in plan.steps if step.chosen is not None}
    if plan.cost is not None:
        known = sum(repair.price or 0.0 for repair in planned), sum(repair.hours or 0.0 for repair in planned)
        assert (sum(plan.cost.prices.values()), plan.cost.hours) == known
        assert plan.cost.repairs == len(planned)
    good = [each for each in green_sets(choice) if {key for move in each for key in move.treats} >= asked]
    assert choice.reached == bool(good) == rediagnosed(diagnosis, choice)
    assert {key for move in choice.chosen for key in move.treats} >= asked
    cost = choice.moves.prices.cost
    if not good:  # kits that overlap leave a land worn
        return
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
    diagnosis = priced(*repairs)
    choice = choose(diagnosis, rounds=0)
    assert choice.chosen
    assert choice.reached
    assert not choice.proven
    assert choose(diagnosis).proven
    made = Estimate(diagnosis, EstimateTerms(), choice, (), "")
    assert "The search was ended after 0 proposals" in " ".join(EstimateWords(made, wording("en")).chosen_by())


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


@pytest.fixture(scope="module")
def body_and_sleeves(three_circuits: Controller, worn_unit: Callable[..., Diagnosis]) -> Callable[..., Diagnosis]:
    """Diagnoses the three circuits with some lands worn, a body of 650 EUR in the file and a sleeve for each land."""
    lands = [land.key for land in three_circuits.lands]

    def build(worn: int, sleeve: float) -> Diagnosis:
        sleeves = (option(number, key[0], (key[1],), sleeve, 1.0) for number, key in enumerate(lands))
        body = replace(kit(99, tuple(lands), 650.0, 6.0), id="body", name="remanufactured body")
        return worn_unit(replace(three_circuits, repairs=(body, *sleeves)), dict.fromkeys(lands[:worn], 2.0))

    return build


def test_a_body_is_chosen_where_it_costs_less_than_the_sleeves_that_it_saves(
    body_and_sleeves: Callable[..., Diagnosis],
) -> None:
    one = choose(body_and_sleeves(1, 38.0))
    assert (one.basis, keys(one)) == (Basis.CHEAPEST, {"option_0"})
    diagnosis = body_and_sleeves(9, 90.0)
    assert len(diagnosis.flagged) == 9
    assert keys(choose(diagnosis)) == {"body"}
    plan = plan_repairs(diagnosis)
    (step,) = plan.steps
    assert {step.land.key, *(land.key for land in step.together)} == {land.key for land in diagnosis.lands}
    assert plan.cost is not None
    assert (plan.cost.prices, plan.cost.hours, plan.cost.repairs) == ({"EUR": 650.0}, 6.0, 1)
    assert plan.cost.without_option == 0
    assert step_in_words(diagnosis, step, wording("en")).endswith(", one repair of the whole valve body")
    (body, sleeve) = (option_record(each, step.land.key) for each in step.options)
    assert body["components"] == ["1", "2", "3", "4"]
    assert sleeve["components"] is None


def test_a_body_without_a_price_takes_the_place_of_no_sleeve_that_has_one(
    three_circuits: Controller, worn_unit: Callable[..., Diagnosis]
) -> None:
    """The third land is within its limits and only the body makes it tighter: nothing asks for that."""
    growth = {("1", 1): 2.0, ("1", 2): 2.0, ("2", 1): 0.05}
    sleeves = option(1, "1", (1,), 38.0, 1.0), option(2, "1", (2,), 38.0, 1.0)
    diagnosis = worn_unit(replace(three_circuits, repairs=(kit(3, tuple(growth), None), *sleeves)), growth)
    assert {land.key for land in diagnosis.flagged} == {("1", 1), ("1", 2)}
    choice = choose(diagnosis)
    assert (choice.basis, keys(choice)) == (Basis.CHEAPEST, {"option_1", "option_2"})


def test_a_land_that_two_kits_cover_is_in_one_state_and_none_that_one_mends_is_as_new(
    three_circuits: Controller, worn_unit: Callable[..., Diagnosis]
) -> None:
    """Each kit alone mends one of the flagged lands, both the one between: the second is as new beside the first."""
    kits = kit(1, (("1", 1), ("2", 1)), 50.0), kit(2, (("2", 1), ("4", 1)), 40.0)
    diagnosis = worn_unit(replace(three_circuits, repairs=kits), {("1", 1): 2.0, ("2", 1): 2.0, ("4", 1): 2.0})
    choice = choose(diagnosis)
    assert keys(choice) in ({"option_1", ("4", 1)}, {"option_2", ("1", 1)})
    assert sorted(key for _, lands in choice.lands for key in lands) == sorted(choice.states)
    lands = [land for land in diagnosis.lands if land.state.judged]
    moves = Moves(Options(diagnosis), lands, Prices(), as_new=True).all
    new = [move for move in moves if move.option is None]
    for move in moves:
        beside = {each.key for each in new if each is not move and move.goes_with(each)}
        mended = set() if move.option is None else move.option.mending
        assert beside == {each.key for each in new if each is not move} - mended
    assert [move.key for move in together(moves)] == ["option_1", ("4", 1)]


def test_what_was_decided_for_one_component_of_a_kit_is_decided_for_all_and_costs_once(
    body_and_sleeves: Callable[..., Diagnosis],
) -> None:
    diagnosis = body_and_sleeves(2, 90.0)
    assert {line.key for line in estimate(diagnosis, Job()).lines} == {"option_0", "option_1"}
    body = {"repair": "body", "decision": "approved"}
    once = estimate(diagnosis, Job(repair_decisions=[{"component": "3", **body}]))
    (line,) = once.lines
    assert set(line.states) == {land.key for land in diagnosis.lands}
    assert EstimateWords(once, wording("en")).pair(line) == "the whole valve body"
    twice = estimate(diagnosis, Job(repair_decisions=[{"component": name, **body} for name in "31"]))
    for made in (once, twice):
        assert (made.total.parts, sum(line.hours or 0.0 for line in made.lines)) == (Decimal(650), 6.0)
        assert not made.lands_past
    others = {"component": "1", "repair": "body", "decision": "declined"}, {"repair": "option_0", "decision": "done"}
    sleeved = estimate(diagnosis, Job(repair_decisions=others))
    assert {line.key: line.decision.decision for line in sleeved.lines} == {
        "body": "declined", "option_0": "done", "option_1": "proposed",
    }  # fmt: skip
    assert sleeved.total.parts == Decimal(180)


def test_a_body_that_is_ticked_takes_the_single_repairs_out(body_and_sleeves: Callable[..., Diagnosis]) -> None:
    repairs = OfferedRepairs(body_and_sleeves(2, 90.0))
    sleeved = with_repairs(repairs, Job(), {"option_0", "option_1"})
    whole = with_repair(estimate(repairs.diagnosis, sleeved), repairs, sleeved, "body", on=True)
    assert decided_repairs(repairs, whole) == {"body"}
    job = with_repairs(repairs, Job(), {"body"})
    assert [(each.repair, each.land, each.decision) for each in job.repair_decisions] == [("body", None, "proposed")]
    assert decided_repairs(repairs, job) == {"body"}
    said = [offered_words(repairs.diagnosis, each, wording("en")) for each in repairs.all if each.key == "body"]
    assert "one repair of the whole valve body: remanufactured body" in said[0]


def test_the_answer_and_a_needless_kit_name_every_component(
    body_and_sleeves: Callable[..., Diagnosis], three_circuits: Controller, worn_unit: Callable[..., Diagnosis]
) -> None:
    record = diagnosis_record(body_and_sleeves(9, 90.0))
    (step,) = record["answer"]["do"]
    assert (step["components"], step["repair"], step["price"]) == (["1", "2", "3", "4"], "body", 650.0)
    assert record["answer"]["cost"] == 650.0
    two = kit(1, (("2", 1), ("3", 1)), 50.0)
    sound = worn_unit(replace(three_circuits, repairs=(two,)), {("1", 1): 0.0})
    job = Job(repair_decisions=[{"component": "2", "repair": two.id, "decision": "approved"}])
    (doubt,) = record_doubts(job, sound)
    assert str(doubt.text).startswith("valve of clutch C1, valve of clutch C2 (2/1, 3/1): work is decided here")
