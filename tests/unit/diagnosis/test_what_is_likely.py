"""What is likelier than not to be past a limit counts as past it, and what may be is said with how far it may go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2
import pytest

from atleak.catalogue.circuits import Circuit, Consumer, Feed, Following, PermissiblePressure, Pressure, SetPressure
from atleak.catalogue.controller import Controller, Gap
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind, Steps
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty.decision import decide_rule
from atleak.measurements.readings import Reading, Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.pdf import write_pdf
from atleak.report.tables.first_sentence import first_sentence
from atleak.report.terminal import print_diagnosis
from tests.unit.conftest import by_turns, first_of

Build = Callable[..., Readings]
UM, KPA = 1e-6, 1e3
MODULATOR = "solenoid_modulator"


@pytest.fixture(scope="module")
def modulated(minimal: Controller) -> Controller:
    """A valve body whose line follows a modulating pressure of 900 kPa, fed by itself through a hole of 0.8 mm.

    At 1890 kPa the hole lets some 0.94 dm³/min through: a bore that takes more brings the line down, and so the feed.
    """
    gears = frozenset(minimal.gears)
    (land,) = (each for each in minimal.lands if each.component == MODULATOR)
    land = replace(
        land,
        nominal_diameter=12e-3,
        contact_length=3.2e-3,
        mounting_clearance=14 * UM,
        new_origin=NewOrigin.PAIR,
    )
    sump = Pressure(0.0, None)
    unit = replace(
        minimal,
        lands=(land,),
        gaps=(Gap(MODULATOR, 1, "mod", Pressure(1.0, "mod"), sump, gears, True, False),),
        circuits=(
            Circuit(
                "mod", "modulating pressure", gears, (Feed("p_g", 0.8e-3, 0.62),), SetPressure(number=900e3), "test"
            ),
        ),
        line=SetPressure(following=Following("mod", 2.1, 0.0)),
    )
    return replace(unit, operating_points=tuple(unit.with_line(point) for point in unit.operating_points))


def worn_to_one_side(unit: Controller, around_um: tuple[float, float]) -> Readings:
    """A sheet on which the bore is wider in one direction than in the other."""
    (land,) = unit.lands
    sizes = {("spool", angle): 0.0 for angle in (0.0, 90.0)}
    sizes |= {("sleeve", angle): 2.0 * um * UM for angle, um in zip((0.0, 90.0), around_um, strict=True)}
    found = [
        Reading(land.component, part, plane, angle, 1, land.nominal_diameter + wide)
        for (part, angle), wide in sizes.items()
        for plane in land.planes
    ]
    return Readings("own.csv", "0" * 64, None, "mm", False, "tidy", tuple(found))


@pytest.fixture(scope="module")
def diagnosed(modulated: Controller, hipol: Fluid, limits: Limits) -> Callable[[float], Diagnosis]:
    def build(wide_um: float) -> Diagnosis:
        return diagnose(modulated, hipol, limits, readings=worn_to_one_side(modulated, (24.2, wide_um)))

    return build


def modulating(diagnosis: Diagnosis) -> Rule:
    idle = diagnosis.hot_idle
    assert idle is not None
    rule = diagnosis.pressure_rule(idle, RuleKind.CIRCUIT_LOSS, diagnosis.controller.circuits[0])
    assert rule is not None
    assert rule.value == pytest.approx(0.0, abs=1.0), "by itself it holds what it is set to"
    return rule


def test_a_pressure_that_has_probably_fallen_is_past_its_limit(diagnosed: Callable[[float], Diagnosis]) -> None:
    diagnosis = diagnosed(57.0)
    rule = modulating(diagnosis)
    decided = diagnosis.decided(rule)
    assert decided is not None
    assert (rule.verdict, decided.decision) == (Verdict.REPLACE, "conditional_fail")
    assert decided.probability_over_limit >= 0.5
    (circuit,) = next(
        each["circuits"] for each in diagnosis_record(diagnosis)["conditions"] if each["name"] == "hot_idle"
    )
    assert (circuit["verdict"], circuit["decision"]) == ("replace", "conditional_fail")
    low, line = (f"{circuit['pressure_low_kpa']:.0f} kPa", "then the line is")
    assert f"may fall to {low}" in first_sentence(diagnosis, wording("en"))
    assert line in first_sentence(diagnosis, wording("en"))


@pytest.mark.parametrize("language", languages())
def test_one_that_may_have_fallen_keeps_its_level_and_is_said(
    diagnosed: Callable[[float], Diagnosis], language: str, capsys: pytest.CaptureFixture[str]
) -> None:
    diagnosis, say = diagnosed(40.0), wording(language)
    rule = modulating(diagnosis)
    decided = diagnosis.decided(rule)
    assert decided is not None
    assert (rule.verdict, decided.decision) == (Verdict.OK, "conditional_pass")
    assert diagnosis.uncertainty is not None
    total = diagnosis.uncertainty.total("hot_idle")
    assert total is not None
    fallen = say.value(total.circuit_intervals["mod"][0] / KPA, "pressure", 0)
    line = say.value(total.main_pressure_interval[0] / KPA, "pressure", 0)
    sentence = first_sentence(diagnosis, say)
    assert f"{fallen} kPa" in sentence
    assert f"{line} kPa" in sentence
    print_diagnosis(diagnosis)
    assert "then the line is" in " ".join(capsys.readouterr().out.split())


def test_what_is_surely_held_is_not_said_to_fall(diagnosed: Callable[[float], Diagnosis]) -> None:
    assert "may fall" not in first_sentence(diagnosed(26.0), wording("en"))


@pytest.mark.parametrize(
    ("reached", "level"),
    [((0.7, 0.4, 0.1), "watch"), ((0.5, 0.5, 0.49), "replace"), ((0.2, 0.6, 0.6), "critical"), ((0.4,) * 3, "ok")],
)
def test_the_highest_level_that_is_as_likely_as_not_is_reached(reached: tuple[float, ...], level: str) -> None:
    levels = tuple(zip((Verdict.WATCH, Verdict.REPLACE, Verdict.CRITICAL), (1.0, 2.0, 3.0), strict=True))
    rule = Rule(RuleKind.CIRCUIT_LOSS, None, 2.5, Steps(levels, LimitOrigin.PROJECT, ""))
    assert rule.level == "replace"
    decided = decide_rule(rule, (1.0,) * 3, reached, 1.645, skewed=True)
    assert decided.rule.level == level
    assert ("fail" in decided.decision) == (level != "ok")


# --- a small valve body, and shipped ones

BODIES = (Path(__file__).parents[2] / "three_circuits.toml", "ford_4r70w", "jatco_jf506e")


def sheet(unit: Controller, readings_of: Build, widen: Callable[[int, float], float]) -> Readings:
    """A sheet with each land's clearance [m] made of its number and its new one."""
    wide = {land.key: 2.0 * widen(number, land.new_clearance) for number, land in enumerate(unit.lands)}
    return readings_of(
        unit, {land.key: (land.nominal_diameter, land.nominal_diameter + wide[land.key]) for land in unit.lands}
    )


@pytest.mark.parametrize("name", first_of(BODIES))
def test_every_part_of_a_result_has_the_level_that_is_likely(
    name: str | Path, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = load_controller(name)
    worn = sheet(unit, readings_of, lambda number, new: new * (3.0 if number % 3 == 0 else 1.0))
    diagnosis = diagnose(unit, hipol, limits, readings=worn)
    assert diagnosis.uncertainty is not None
    judged = 0
    for total in diagnosis.uncertainty.totals:
        for decided in (total.decision, *total.pressures):
            likely = [each.level for each in decided.levels if each.probability_over >= 0.5]
            if decided.rule.reached is not None:
                judged += 1
                assert decided.rule.verdict.flagged == bool(likely)
                assert not likely or decided.rule.level == likely[-1]
            assert decided.rule in diagnosis.unit_rules
    assert judged > 5
    for land in diagnosis.lands:
        assert land.verdict == max((rule.verdict for rule in land.rules), key=lambda each: each.rank)
    assert diagnosis.verdict == max(
        (each.verdict for each in (*diagnosis.lands, *diagnosis.unit_rules)), key=lambda each: each.rank
    )


@pytest.mark.parametrize(
    ("unit", "seed"), first_of(by_turns(controllers(), (1, 2, 3))), ids=lambda each: getattr(each, "id", each)
)
def test_a_new_unit_read_with_noise_is_green(
    unit: Controller, seed: int, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """Pairs anywhere in what is known of new ones, read with a standard error of 0.7 µm."""
    random = np.random.default_rng(seed)
    new = {
        land.key: random.uniform(*land.mounting_range) + random.normal(0.0, 0.25) * (land.mounting_tolerance or 0.0)
        for land in unit.lands
    }
    read = sheet(unit, readings_of, lambda number, _: new[unit.lands[number].key] + random.normal(0.0, 0.7 * UM))
    diagnosis = diagnose(unit, hipol, limits, readings=read)
    assert [land.key for land in diagnosis.flagged] == []
    assert [rule.id for rule in diagnosis.unit_rules if rule.verdict.flagged] == []
    assert diagnosis.verdict == Verdict.OK


# --- readings and descriptions that cannot be


@pytest.mark.parametrize("name", first_of(BODIES))
def test_bores_without_clearance_are_not_ok(name: str | Path, hipol: Fluid, limits: Limits, readings_of: Build) -> None:
    unit = load_controller(name)
    for widen in (lambda number, new: 0.0, lambda number, new: new if number else 0.0):
        diagnosis = diagnose(unit, hipol, limits, readings=sheet(unit, readings_of, widen))
        record = diagnosis_record(diagnosis)["unit"]
        assert (record["verdict"], record["decided_by"]["kind"]) == ("watch", "readings")
        assert not diagnosis.flagged


@pytest.mark.parametrize(("name", "part"), first_of((name, part) for name in BODIES for part in (0.5, 0.12)))
def test_a_description_by_which_no_new_unit_holds_its_pressure_is_not_judged(
    name: str | Path, part: float, hipol: Fluid, limits: Limits, readings_of: Build, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = load_controller(name)
    unit = replace(unit, pump=replace(unit.pump, displacement=part * unit.pump.displacement))
    diagnosis = diagnose(unit, hipol, limits, readings=sheet(unit, readings_of, lambda number, new: new))
    record = diagnosis_record(diagnosis)
    cannot = any(each["reserve_new"] < 1.0 for each in record["conditions"])
    assert bool(diagnosis.impossible) == cannot == (part < 0.2)
    assert [land.key for land in diagnosis.flagged] == []
    codes = [message["code"] for message in record["messages"]]
    if not cannot:
        assert (record["unit"]["verdict"], "description_impossible" in codes) == ("ok", False)
        return
    assert (record["unit"]["verdict"], record["unit"]["decision"]) == ("critical", None)
    assert codes[0] == "description_impossible"
    assert record["repair_plan"] == []
    assert first_sentence(diagnosis, wording("en")).startswith("not judged: the description cannot be right")
    print_diagnosis(diagnosis)
    assert "not judged: the description cannot be right" in " ".join(capsys.readouterr().out.split())
    with pypdfium2.PdfDocument(write_pdf(diagnosis)) as document:
        text = " ".join(" ".join(page.get_textpage().get_text_range() for page in document).split())
    assert "what describes this unit cannot be right" in text
    assert "Not judged: the description cannot be right" in text


@pytest.mark.parametrize("name", first_of(BODIES[1:]))
def test_a_condition_set_by_hand_that_no_new_unit_holds_hides_no_verdict(
    name: str, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = load_controller(name)
    stated = replace(
        unit.operating_points[0],
        name="stated",
        values_of=unit.operating_points[0].name,
        engine_speed=unit.operating_points[0].engine_speed / 20.0,
    )
    for part in (0.0, 0.02):
        read = sheet(unit, readings_of, lambda number, new, part=part: new * (1.0 + part))
        usual = diagnose(unit, hipol, limits, readings=read)
        diagnosis = diagnose(unit, hipol, limits, readings=read, condition=stated)
        record = diagnosis_record(diagnosis)
        codes = [message["code"] for message in record["messages"]]
        assert diagnosis.impossible == ()
        assert ("description_impossible" in codes, "condition_impossible" in codes) == (False, True)
        assert diagnosis.verdict == usual.verdict
        assert diagnosis.decided_by is None or getattr(diagnosis.decided_by, "condition", None) != stated
        assert "of the required" not in first_sentence(diagnosis, wording("en"))


@pytest.mark.parametrize("permissible", [(), (PermissiblePressure(frozenset({1}), "idle", 350 * KPA, None, "manual"),)])
def test_a_line_that_falls_to_nothing_is_critical_though_it_does_when_new(
    permissible: tuple[PermissiblePressure, ...], minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    thirsty = (Consumer("cooler", "converter and cooler", 12.0 / 60e3, False, "test", "constant"),)
    unit = replace(minimal, consumers=thirsty, permissible=permissible)
    diagnosis = diagnose(unit, hipol, limits, readings=sheet(unit, readings_of, lambda number, new: new))
    assert (diagnosis.verdict, diagnosis.decision) == (Verdict.CRITICAL, None)
    assert not diagnosis.flagged
    idle = diagnosis.hot_idle
    assert idle is not None
    rules = {rule.kind: rule.verdict for rule in diagnosis.pressure_rules_at(idle)}
    assert rules[RuleKind.RESERVE] == Verdict.CRITICAL
    if permissible:
        assert rules[RuleKind.PERMISSIBLE_PRESSURE] == Verdict.CRITICAL
