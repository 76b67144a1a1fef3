"""What the pump's reserve, the circuits and the line pressure are judged by, and what their repair brings."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import pytest

from atleak.analysis.repair.plan import plan_repairs
from atleak.catalogue.circuits import Circuit, Consumer, Feed, Leak, PermissiblePressure, Pressure, SetPressure
from atleak.catalogue.controller import Controller, Gap, Land
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.profile import PAPER
from atleak.engine.projection import project, repaired
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record

Build = Callable[..., Readings]
UM, KPA = 1e-6, 1e3
DRAIN, LINE = Pressure(0.0, None), Pressure(1.0, "p_g")
REGULATOR, CLUTCH = "pressure_regulator", "tcc_regulator"


@pytest.fixture
def fed(minimal: Controller) -> Controller:
    """A unit whose clutch is fed through an orifice of 0.5 mm and leaks at two lands of ⌀ 14.5 mm, 13 µm when new."""
    first = next(land for land in minimal.lands if land.component == CLUTCH)
    new = {"mounting_clearance": 13 * UM, "nominal_diameter": 14.5e-3, "new_origin": NewOrigin.PAIR}
    clutch = [replace(first, land=number, planes=(str(number),), **new) for number in (1, 2)]
    regulator = [replace(land, mounting_clearance=13 * UM) for land in minimal.lands if land.component == REGULATOR]
    gears = frozenset(minimal.gears)
    gaps = [Gap(CLUTCH, land.land, "c1", Pressure(1.0, "c1"), DRAIN, gears, True, False) for land in clutch]
    gaps += [Gap(REGULATOR, land.land, "p_g", LINE, DRAIN, gears, True, False) for land in regulator]
    return replace(
        minimal,
        lands=(*clutch, *regulator),
        gaps=tuple(gaps),
        circuits=(Circuit("c1", "clutch C1", gears, (Feed("p_g", 0.5e-3, 0.62),), None, "test"),),
        permissible=(PermissiblePressure(gears, "idle", 414 * KPA, None, "test"),),
    )


def as_new(lands: Iterable[Land]) -> dict[tuple[str, int], tuple[float, float]]:
    """Return the diameters [m] of new lands."""
    return {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.new_clearance) for land in lands}


def judged(
    controller: Controller, clearances_um: Mapping[str, float], readings_of: Build, fluid: Fluid, limits: Limits
) -> Diagnosis:
    """The diagnosis of a unit as new but for the lands of some components."""
    diameters = {
        land.key: (
            land.nominal_diameter,
            land.nominal_diameter + 2.0 * clearances_um.get(land.component, land.new_clearance / UM) * UM,
        )
        for land in controller.lands
    }
    even = replace(DEFAULTS, one_sided_wear=0.0)  # the levels are asked for, not how the wear lies
    return diagnose(controller, fluid, limits, readings=readings_of(controller, diameters), assumptions=even)


def rule_of(diagnosis: Diagnosis, kind: RuleKind, point: str = "hot_idle") -> Rule:
    return next(
        each
        for each in diagnosis.pressure_rules
        if each.kind == kind and each.condition and each.condition.name == point
    )


def test_new_parts_lose_no_pressure(fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> None:
    diagnosis = judged(fed, {}, readings_of, hipol, limits)
    assert {rule.verdict for rule in diagnosis.unit_rules} == {Verdict.OK}
    assert rule_of(diagnosis, RuleKind.CIRCUIT_LOSS).value == pytest.approx(0.0, abs=1e-6)
    assert diagnosis.verdict == Verdict.OK


@pytest.mark.parametrize(
    ("clearance", "verdict"), [(13.0, Verdict.OK), (17.0, Verdict.OK), (26.0, Verdict.WATCH), (35.0, Verdict.REPLACE)]
)
def test_a_clutch_circuit_is_judged_by_what_it_lost(
    clearance: float, verdict: Verdict, fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """A leak that no share of the pump's flow shows lowers the pressure of its circuit."""
    diagnosis = judged(fed, {CLUTCH: clearance}, readings_of, hipol, limits)
    rule = rule_of(diagnosis, RuleKind.CIRCUIT_LOSS)
    assert rule.verdict == verdict
    assert rule.circuit is not None
    assert diagnosis.band(diagnosis.projections[0]) == Band.GREEN
    decided = diagnosis.decided(rule)
    assert decided is not None
    assert decided.decision in {"pass", "conditional_pass"} if verdict == Verdict.OK else "fail" in decided.decision


def test_the_interval_holds_the_pressure_and_is_wider_on_the_side_of_wear(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = judged(fed, {CLUTCH: 30.0}, readings_of, hipol, limits)
    assert diagnosis.hot_idle is not None
    assert diagnosis.uncertainty is not None
    total = diagnosis.uncertainty.total("hot_idle")
    assert total is not None
    low, high = total.circuit_intervals["c1"]
    pressure = diagnosis.hot_idle.circuit("c1").pressure
    assert low < pressure < high
    assert pressure - low > high - pressure  # wear to one side, which two directions show in part, leaks more
    assert total.reserve_interval[0] < diagnosis.hot_idle.reserve < total.reserve_interval[1]


def test_a_circuit_names_the_lands_that_cost_it_pressure(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = judged(fed, {CLUTCH: 35.0}, readings_of, hipol, limits)
    assert diagnosis.hot_idle is not None
    assert diagnosis.new_at(diagnosis.hot_idle) is not None
    losses = diagnosis.losses_at(diagnosis.hot_idle)["c1"]
    assert set(losses) == {(CLUTCH, 1), (CLUTCH, 2)}
    one_new = repaired([land.state for land in diagnosis.lands], [(CLUTCH, 1)])
    point = diagnosis.hot_idle.condition
    gained = project(replace(diagnosis.model, clearances=one_new), point).circuit("c1").pressure
    gained -= diagnosis.hot_idle.circuit("c1").pressure
    assert losses[CLUTCH, 1] == pytest.approx(gained, rel=1e-9, abs=1e-3)
    clean = next(land for land in diagnosis.lands if land.key == (REGULATOR, 1))
    assert diagnosis.loss_by(clean, diagnosis.hot_idle) == 0.0


@pytest.mark.parametrize("measured", [(), ((CLUTCH, 1),)], ids=["none of its lands", "one of its lands"])
def test_a_circuit_that_was_not_measured_whole_is_never_ok(
    measured: tuple[tuple[str, int], ...], fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """Lands that nobody measured are computed as new, so that their circuit seems to have lost nothing."""
    read = [land for land in fed.lands if land.component == REGULATOR or land.key in measured]
    diagnosis = diagnose(fed, hipol, limits, readings=readings_of(fed, as_new(read)))
    for record in diagnosis_record(diagnosis)["conditions"]:
        (circuit,) = record["circuits"]
        (rule,) = (each for each in record["rules"] if each["circuit"] == "c1")
        assert (circuit["verdict"], circuit["decision"]) == (Verdict.NOT_MEASURED, None)
        assert (rule["verdict"], rule["decision"]) == (Verdict.NOT_MEASURED, None)
    whole = diagnosis_record(diagnose(fed, hipol, limits, readings=readings_of(fed, as_new(fed.lands))))
    assert [circuit["verdict"] for each in whole["conditions"] for circuit in each["circuits"]] == [
        Verdict.OK for _ in whole["conditions"]
    ]


def test_a_circuit_with_lands_that_nobody_measured_can_be_past_a_limit(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    worn = {(CLUTCH, 1): (14.5e-3, 14.5e-3 + 2.0 * 60 * UM)}
    diagnosis = diagnose(fed, hipol, limits, readings=readings_of(fed, worn))
    rule = rule_of(diagnosis, RuleKind.CIRCUIT_LOSS)
    assert diagnosis.verdict_on(rule) == rule.verdict
    assert rule.verdict.flagged


def test_the_loss_that_is_shown_is_the_one_that_is_judged(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """Where only a range is known of new pairs, both are against the widest that these may have been when new."""
    of_type = tuple(
        replace(land, mounting_clearance=(6 * UM, 20 * UM), new_origin=NewOrigin.RANGE)
        if land.component == CLUTCH
        else land
        for land in fed.lands
    )
    worn = judged(replace(fed, lands=of_type), {CLUTCH: 25.0}, readings_of, hipol, limits)
    rule = rule_of(worn, RuleKind.CIRCUIT_LOSS)
    record = next(each for each in diagnosis_record(worn)["conditions"] if each["name"] == "hot_idle")
    (circuit,) = record["circuits"]
    assert circuit["loss_kpa"] == pytest.approx(rule.value / KPA, rel=1e-9, abs=0.0)
    assert circuit["loss_kpa"] == pytest.approx(circuit["pressure_new_kpa"] - circuit["pressure_kpa"], abs=1e-9)
    assert worn.hot_idle is not None
    assert circuit["pressure_new_kpa"] < worn.new_at(worn.hot_idle).circuit("c1").pressure / KPA - 1.0


def test_a_rise_is_judged_too(fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> None:
    """A worn land between the line and a circuit that a hole drains raises what that circuit holds."""
    gears = frozenset(fed.gears)
    into = Gap(REGULATOR, 2, "p_g", LINE, Pressure(1.0, "c1"), gears, False, False)
    gaps = tuple(into if (gap.component, gap.land) == (REGULATOR, 2) else gap for gap in fed.gaps)
    bleed = Leak(
        "bleed", "bleed", Pressure(1.0, "c1"), DRAIN, "orifice", 0.2 / 60e3, 200 * KPA, None, 800.0, gears, True, ""
    )
    diagnosis = judged(replace(fed, gaps=gaps, leaks=(bleed,)), {REGULATOR: 80.0}, readings_of, hipol, limits)
    rule, now = rule_of(diagnosis, RuleKind.CIRCUIT_LOSS), diagnosis.hot_idle
    assert now is not None
    assert rule.new is not None
    assert now.circuit("c1").pressure > rule.new + 55 * KPA
    assert rule.verdict.flagged


@pytest.mark.parametrize(
    ("consumed", "worn", "band"),
    [(3.0, 13.0, Band.GREEN), (6.5, 60.0, Band.AMBER), (6.5, 85.0, Band.RED), (6.5, 110.0, Band.CRITICAL)],
)
def test_the_reserve_counts_consumers(
    consumed: float, worn: float, band: Band, fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    thirsty = replace(fed, consumers=(Consumer("cooler", "cooler", consumed / 60e3, False, "test"),))
    diagnosis = judged(thirsty, {REGULATOR: worn}, readings_of, hipol, limits)
    rule, now = rule_of(diagnosis, RuleKind.RESERVE), diagnosis.hot_idle
    assert now is not None
    assert rule.level == band
    demand = now.leakage + now.slip + consumed / 60e3
    assert now.reserve == pytest.approx(now.pump_supply / demand, rel=1e-12, abs=0.0)
    assert (now.main_pressure_held < now.condition.main_pressure) == (now.reserve < 1.0)
    at_minimum = replace(now.condition, engine_speed=now.minimum_speed)
    assert project(diagnosis.model, at_minimum).reserve == pytest.approx(1.0, rel=1e-9, abs=0.0)


def test_a_new_unit_with_little_reserve_is_green(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    thirsty = replace(fed, consumers=(Consumer("cooler", "cooler", 8.6 / 60e3, False, "test"),))
    diagnosis = judged(thirsty, {}, readings_of, hipol, limits)
    rule = rule_of(diagnosis, RuleKind.RESERVE)
    assert 1.0 < rule.value < 1.5
    assert rule.level == Band.GREEN
    assert rule_of(judged(thirsty, {REGULATOR: 60.0}, readings_of, hipol, limits), RuleKind.RESERVE).verdict.flagged


def test_a_pump_that_cannot_hold_the_line_is_critical_because_of_pressure(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = judged(fed, {REGULATOR: 200.0}, readings_of, hipol, replace(limits, pair_share=None, wear=None))
    now = diagnosis.hot_idle
    assert now is not None
    rule = rule_of(diagnosis, RuleKind.PERMISSIBLE_PRESSURE)
    assert rule.value == pytest.approx(1.0 - now.main_pressure_held / (414 * KPA), rel=1e-12, abs=0.0)
    assert rule.verdict == Verdict.CRITICAL
    assert diagnosis.verdict == Verdict.CRITICAL
    assert rule_of(diagnosis, RuleKind.CIRCUIT_LOSS).verdict.flagged  # the circuit falls with its line
    # what flows at the pressure that holds is what the pump delivers there
    model, point = diagnosis.model, replace(now.condition, main_pressure=now.main_pressure_held)
    there = project(model, point)
    assert there.leakage == pytest.approx(there.pump_capacity, rel=1e-9, abs=0.0)


def test_an_assumed_line_pressure_is_not_judged(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    """The point itself assumes less than is permissible: that says nothing of the unit."""
    points = [
        replace(point, main_pressure=350 * KPA) if point.name == "hot_idle" else point for point in fed.operating_points
    ]
    assuming = replace(fed, operating_points=tuple(points))
    diagnosis = judged(assuming, {}, readings_of, hipol, limits)
    assert RuleKind.PERMISSIBLE_PRESSURE not in {rule.kind for rule in diagnosis.pressure_rules}
    # where the pump does not hold even that, it is judged by no more than that
    diagnosis = judged(assuming, {REGULATOR: 200.0}, readings_of, hipol, limits)
    assert diagnosis.hot_idle is not None
    missing = 1.0 - diagnosis.hot_idle.main_pressure_held / (350 * KPA)
    rule = rule_of(diagnosis, RuleKind.PERMISSIBLE_PRESSURE)
    assert rule.value == pytest.approx(missing, rel=1e-12, abs=0.0)


def test_a_circuit_decides_where_no_land_is_past_a_limit(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = judged(fed, {CLUTCH: 30.0}, readings_of, hipol, replace(limits, wear=None))
    decided_by = diagnosis.decided_by
    assert isinstance(decided_by, Rule)
    assert decided_by.circuit is not None
    record = diagnosis_record(diagnosis)
    json.dumps(record, allow_nan=False)
    deciding = record["unit"]["decided_by"]
    assert (deciding["kind"], deciding["circuit"], deciding["component"]) == ("circuit", "c1", None)
    circuit = next(each for each in record["conditions"] if each["name"] == deciding["condition"])["circuits"][0]
    assert circuit["loss_kpa"] == pytest.approx(
        circuit["pressure_new_kpa"] - circuit["pressure_kpa"], rel=1e-12, abs=0.0
    )
    assert circuit["pressure_low_kpa"] < circuit["pressure_kpa"] < circuit["pressure_high_kpa"]
    assert [cause["component"] for cause in circuit["causes"]] == [CLUTCH, CLUTCH]


def test_the_plan_repairs_lands_for_the_sake_of_a_circuit(
    fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = judged(fed, {CLUTCH: 30.0}, readings_of, hipol, replace(limits, wear=None))
    plan = plan_repairs(diagnosis)
    assert {step.land.key[0] for step in plan.steps} == {CLUTCH}
    assert all(step.for_total for step in plan.steps)
    assert plan.reached
    assert not plan.pressures_past
    states = [land.state for land in diagnosis.lands]
    after = repaired(states, [step.land.key for step in plan.steps])
    for end in plan.ends:
        alone = project(replace(diagnosis.model, clearances=after), end.condition)
        assert end.pressures["c1"] == pytest.approx(alone.circuit("c1").pressure, rel=1e-9, abs=0.0)
        assert end.leakage == pytest.approx(alone.leakage, rel=1e-9, abs=0.0)
        assert end.reserve == pytest.approx(alone.reserve, rel=1e-9, abs=0.0)


def test_without_readings_no_circuit_is_ok(fed: Controller, hipol: Fluid, limits: Limits) -> None:
    record = diagnosis_record(diagnose(fed, hipol, limits))
    assert {each["circuits"][0]["verdict"] for each in record["conditions"]} == {Verdict.NOT_MEASURED}


def test_a_circuit_that_no_operating_point_applies_is_named(fed: Controller, hipol: Fluid, limits: Limits) -> None:
    elsewhere = replace(fed.circuits[0], gears=frozenset({5}))
    diagnosis = diagnose(replace(fed, circuits=(elsewhere,)), hipol, limits)
    (message,) = (each for each in diagnosis.messages if each.code == "circuit_nowhere_applied")
    assert "clutch C1" in message.text
    assert "circuit_nowhere_applied" not in {each.code for each in diagnose(fed, hipol, limits).messages}


def test_paper_solves_no_pressures(fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> None:
    diameters = {land.key: (land.nominal_diameter, land.nominal_diameter + 160 * UM) for land in fed.lands}
    diagnosis = diagnose(fed, hipol, limits, readings=readings_of(fed, diameters), profile=PAPER)
    for each in diagnosis.projections:
        assert each.main_pressure_held == each.condition.main_pressure
        assert each.circuit("c1").pressure == each.condition.main_pressure


def test_a_regulator_caps_its_circuit(fed: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> None:
    capped = replace(fed.circuits[0], set_pressure=SetPressure(number=300 * KPA))
    diagnosis = judged(replace(fed, circuits=(capped,)), {CLUTCH: 20.0}, readings_of, hipol, limits)
    assert {each.circuit("c1").pressure for each in diagnosis.projections} == {300 * KPA}
    assert rule_of(diagnosis, RuleKind.CIRCUIT_LOSS).value == 0.0
