"""Pressures at a condition: gathered once for page, terminal, PDF and workbook, and said in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.analysis.pressures import lowest_first, pressures_at, worst_pressure
from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.circuits import Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER
from atleak.measurements.readings import Readings
from atleak.report.tables.sentences import (
    because_of,
    circuit_sentence,
    land_in_words,
    permissible_words,
    pressure_sentence,
    reserve_sentence,
    unsolved,
)
from tests.unit.conftest import with_clearances

Build = Callable[..., Readings]
SAY = wording("en")


def plainly(text: str | None) -> str:
    return (text or "").replace("\u00a0", " ")


@pytest.fixture(scope="session")
def falling(three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> Diagnosis:
    """The same valve body with a small pump and a regulator so worn that the line falls at hot idle."""
    small = replace(three_circuits, pump=replace(three_circuits.pump, displacement=7.5e-6))
    return diagnose(small, hipol, limits, readings=with_clearances(small, readings_of, {("1", 1): 200e-6}))


def test_they_are_those_of_the_engine_with_interval_new_and_repair(worn_clutch: Diagnosis) -> None:
    plan = plan_repairs(worn_clutch)
    for number, projection in enumerate(worn_clutch.projections):
        at = pressures_at(worn_clutch, projection, plan.ends)
        new, end = worn_clutch.new_projections[number], plan.ends[number]
        total = worn_clutch.uncertainty.total(projection.condition.name)
        assert (at.line.now, at.line.new) == (projection.main_pressure_held, new.main_pressure_held)
        assert at.line.interval == total.main_pressure_interval
        assert at.reserve_interval == total.reserve_interval
        assert at.reserve_repaired == end.reserve
        for held, state, before in zip(at.circuits, projection.circuits, new.circuits, strict=True):
            assert (held.id, held.now, held.new, held.vented) == (
                state.circuit.id, state.pressure, before.pressure, state.vented,
            )  # fmt: skip
            assert held.repaired == end.pressures[held.id]
            assert held.loss == before.pressure - state.pressure
        assert [each.id for each in at.applied] == ["p_g", *(each.id for each in at.circuits if not each.vented)]


def test_a_worn_circuit_names_its_lands_and_the_limits_of_its_pressure(worn_clutch: Diagnosis) -> None:
    idle = worn_clutch.hot_idle
    clutch = next(each for each in pressures_at(worn_clutch, idle).circuits if each.id == "clutch_c1")
    assert clutch.verdict == Verdict.REPLACE
    assert [key for key, _ in clutch.costly] == [("2", 1), ("2", 2)]
    assert [(level, round(clutch.new - pressure)) for level, pressure in clutch.limits] == [
        (Verdict.WATCH, 55_000), (Verdict.REPLACE, 103_000),
    ]  # fmt: skip
    line = pressures_at(worn_clutch, idle).line
    assert [(level, round(pressure)) for level, pressure in line.limits] == [(Verdict.CRITICAL, 400_000)]  # published


def test_without_a_plan_nothing_is_repaired(worn_clutch: Diagnosis) -> None:
    at = pressures_at(worn_clutch, worn_clutch.projection)
    assert {each.repaired for each in at.applied} == {None}
    assert at.reserve_repaired is None


def test_nothing_that_was_not_measured_is_ok(three_circuits: Controller, hipol: Fluid, limits: Limits) -> None:
    diagnosis = diagnose(three_circuits, hipol, limits)
    for projection in diagnosis.projections:
        at = pressures_at(diagnosis, projection)
        assert {at.reserve_verdict, *(each.verdict for each in at.applied)} <= {Verdict.NOT_MEASURED, None}
    assert worst_pressure(diagnosis) is None


def test_the_worst_condition_comes_first(worn_clutch: Diagnosis, falling: Diagnosis) -> None:
    assert lowest_first(worn_clutch)[0] is worn_clutch.hot_idle
    assert worst_pressure(worn_clutch).circuit.id == "clutch_c1"
    assert lowest_first(falling)[0] is falling.hot_idle
    assert worst_pressure(falling).verdict == Verdict.CRITICAL


def test_sentences_of_a_line_that_holds(worn_clutch: Diagnosis) -> None:
    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    said = plainly(pressure_sentence(at, SAY))
    assert at.line.interval == pytest.approx((500e3, 500e3), abs=1e-3), "what is required is required"
    assert said == "Main pressure at “hot idle”: the required 500 kPa is held. Permissible: 400 to 539 kPa."
    reserve = plainly(reserve_sentence(at, SAY))
    assert reserve.startswith(f"Reserve: the pump supplies {at.projection.reserve:.2f} times what leakage, slip and")
    assert reserve.endswith(f"{at.reserve_new:.2f} times when new.")


def test_sentences_of_a_line_that_falls(falling: Diagnosis) -> None:
    at = pressures_at(falling, falling.hot_idle)
    assert at.projection.pressure_falls
    held = f"only {at.line.now / 1e3:.0f} of the required 500 kPa is held"
    assert held in plainly(pressure_sentence(at, SAY))
    assert plainly(reserve_sentence(at, SAY)).endswith(
        f"Consumers behind the line's regulator lack {at.projection.starved * 6e4:.1f} dm³/min."
    )


def test_a_line_that_a_worn_circuit_sets_says_which(
    three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    follows = SetPressure(following=Following("epc", 2.0, 100e3))
    first, *others = three_circuits.circuits
    narrow = replace(first, feeds=(replace(first.feeds[0], diameter=0.4e-3),))
    controller = replace(three_circuits, line=follows, circuits=(narrow, *others))
    readings = with_clearances(controller, readings_of, {("4", 1): 120e-6})
    diagnosis = diagnose(controller, hipol, limits, readings=readings)
    at = pressures_at(diagnosis, diagnosis.hot_idle)
    assert at.projection.pressure_falls
    assert at.projection.reserve > 1.0
    held, new = at.followed.now / 1e3, at.followed.new / 1e3
    said = f"It is set by electronic pressure control, which holds {held:.0f} of {new:.0f} kPa."
    assert said in plainly(pressure_sentence(at, SAY))


def test_the_land_that_costs_most_is_always_named(worn_clutch: Diagnosis) -> None:
    clutch = pressures_at(worn_clutch, worn_clutch.hot_idle).circuits[1]
    many = {("1", number): 1e3 * number for number in range(1, 4)}
    assert [key for key, _ in replace(clutch, now=clutch.new - 90e3, causes=many).costly] == [("1", 3)]


def test_one_end_of_the_permissible_pressure_is_said_alone(worn_clutch: Diagnosis) -> None:
    line = pressures_at(worn_clutch, worn_clutch.hot_idle).line
    low_only, high_only = (
        replace(line, permissible=replace(line.permissible, **{end: None})) for end in ("high", "low")
    )
    assert permissible_words(low_only, SAY) == "Permissible: at least 400 kPa."
    assert permissible_words(high_only, SAY) == "Permissible: at most 539 kPa."
    assert permissible_words(replace(line, permissible=None), SAY) == ""


def test_a_required_pressure_below_the_permissible_says_that_it_is_not_judged(
    three_circuits: Controller, hipol: Fluid, limits: Limits
) -> None:
    least = 600e3  # more than the 500 kPa of hot idle
    strict = replace(
        three_circuits, permissible=tuple(replace(p, low=least, high=None) for p in three_circuits.permissible)
    )
    diagnosis = diagnose(strict, hipol, limits)
    line = pressures_at(diagnosis, diagnosis.hot_idle).line
    assert line.rule is None
    assert permissible_words(line, SAY) == (
        "Permissible: at least 600 kPa. Not judged by it: the required pressure itself is below it."
    )


def test_a_circuit_says_what_it_holds_and_which_lands_cost_it_that(worn_clutch: Diagnosis) -> None:
    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    clutch, lock_up = (next(each for each in at.circuits if each.id == name) for name in ("clutch_c1", "lock_up"))
    said = plainly(circuit_sentence(worn_clutch, clutch, SAY))
    assert said.startswith(f"clutch C1 holds {clutch.now / 1e3:.0f} of {clutch.new / 1e3:.0f} kPa (")
    first, second = (f"{loss / 1e3:.0f} kPa" for _, loss in clutch.costly)
    name = land_in_words(worn_clutch, ("2", 1), SAY)
    assert said.endswith(f": ■ replace; {name} costs {first}; {name.replace('/1', '/2')} costs {second}")
    assert plainly(circuit_sentence(worn_clutch, lock_up, SAY)) == "lock-up holds 150 of 150 kPa: ● ok"


def test_the_rule_that_decided_says_its_numbers_and_where_to_look(worn_clutch: Diagnosis, falling: Diagnosis) -> None:
    clutch = plainly(because_of(worn_clutch, worst_pressure(worn_clutch), SAY))
    assert clutch.startswith(
        "because of the pressure lost by clutch C1 at “hot idle”: 254 of 471 kPa. Look first at 2/1"
    )
    rules = {rule.kind: rule for rule in falling.pressure_rules_at(falling.hot_idle)}
    reserve, permissible = (rules[kind] for kind in (RuleKind.RESERVE, RuleKind.PERMISSIBLE_PRESSURE))
    assert plainly(because_of(falling, reserve, SAY)) == (
        f"because of the pump's reserve at “hot idle”: {reserve.value:.2f}, where {reserve.limit:.2f} is the limit. "
        "Look first at 1/1 pressure regulator."
    )
    held = falling.hot_idle.main_pressure_held / 1e3
    assert plainly(because_of(falling, permissible, SAY)) == (
        f"because of main pressure at “hot idle”: {held:.0f} kPa, where at least 400 kPa is permissible. "
        "Look first at 1/1 pressure regulator."
    )


def test_a_circuit_whose_pressure_rises_says_so(worn_clutch: Diagnosis) -> None:
    rule = worst_pressure(worn_clutch)
    projection = worn_clutch.at(rule.condition)
    higher = tuple(
        replace(state, pressure=600e3) if state.circuit == rule.circuit else state for state in projection.circuits
    )
    risen = replace(worn_clutch, projections=(replace(projection, circuits=higher), *worn_clutch.projections[1:]))
    said = plainly(because_of(risen, rule, SAY))
    assert said.startswith("because of the pressure gained by clutch C1 at “hot idle”: 600 instead of 471 kPa")


def test_the_lands_that_raise_a_circuit_are_named_where_it_rose(worn_clutch: Diagnosis) -> None:
    at = pressures_at(worn_clutch, worn_clutch.hot_idle)
    clutch = next(each for each in at.circuits if each.id == "clutch_c1")
    causes = {("2", 1): 30e3, ("1", 2): -20e3, ("2", 2): -90e3, ("3", 1): -1e3}
    risen = replace(clutch, now=clutch.new + 110e3, causes=causes)
    assert [key for key, _ in risen.costly] == [("2", 2), ("1", 2)]
    said = plainly(circuit_sentence(worn_clutch, risen, SAY))
    assert said.endswith("2/2 valve of clutch C1 raises it by 90 kPa; 1/2 pressure regulator raises it by 20 kPa")
    assert [key for key, _ in replace(risen, now=clutch.new - 40e3).costly] == [("2", 1)]


def test_other_rules_are_left_to_others(worn_clutch: Diagnosis) -> None:
    assert because_of(worn_clutch, worn_clutch.total_rules[0], SAY) is None


@pytest.mark.parametrize("language", languages())
def test_every_language_has_every_sentence(worn_clutch: Diagnosis, falling: Diagnosis, language: str) -> None:
    say = wording(language)
    for diagnosis in (worn_clutch, falling):
        at = pressures_at(diagnosis, diagnosis.hot_idle)
        every = [pressure_sentence(at, say), reserve_sentence(at, say)]
        every += [circuit_sentence(diagnosis, held, say) for held in at.applied]
        every += [because_of(diagnosis, rule, say) or "" for rule in at.rules]
        assert all(sentence and "{" not in sentence for sentence in every)
        assert ("Reserve: the pump" in every[1]) is (language == "en")


def test_a_file_without_circuits_and_a_profile_that_solves_none_say_so(
    worn_clutch: Diagnosis, worn: Diagnosis, three_circuits: Controller, hipol: Fluid, limits: Limits
) -> None:
    assert unsolved(worn_clutch, SAY) is None
    assert unsolved(worn, SAY) == "This valve body's file describes no circuits: only the line is judged."
    paper = diagnose(three_circuits, hipol, limits, profile=PAPER)
    assert "none is solved" in unsolved(paper, SAY)
    given = pressure_sentence(pressures_at(paper, paper.hot_idle), SAY)
    assert given.startswith("Main pressure at “hot idle”: 500 kPa, taken as given. Permissible: ")
