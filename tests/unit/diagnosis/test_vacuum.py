"""A vacuum test as a measurement: alone, beside diameters, of several lands, before and after, and what to expect."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from atleak.analysis.answer import answer_of
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.errors import InputError, Place
from atleak.common.units import IN_HG
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis import vacuum
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.missing import Cause
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.draws import interval_of
from atleak.diagnosis.vacuum_card import GROWN, pass_marks
from atleak.engine.profile import WORKSHOP
from atleak.equations.vacuum import air_viscosity, circuit_pressure
from atleak.measurements.clearances import clearances, with_leak
from atleak.measurements.readings import Readings
from atleak.measurements.vacuum import Calibration, LeakClearance, VacuumReading, VacuumStand, VacuumTable
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.first_sentence import first_sentence
from atleak.report.tables.table import Table
from atleak.report.tables.vacuum import vacuum_section
from tests.unit.conftest import first_of

STAND = VacuumStand()
UNITS = ("five_speed_2005", "zf_6hp26", "gm_4l60e")
ANYWHERE = 1.5  # mean of 1 + 1.5 e²


def shown(lands: Sequence[Land], clearances: Sequence[float], orifice: float, factor: float = ANYWHERE) -> float:
    """The reading of a stand with C_d 0.8 [Pa]."""
    sizes = ([getattr(land, name) for land in lands] for name in ("nominal_diameter", "contact_length"))
    diameters, lengths = sizes
    area = 0.8 * math.pi / 4.0 * orifice**2
    supply = STAND.ambient - STAND.supply
    pressure = circuit_pressure(
        supply, STAND.ambient, area, diameters, clearances, lengths, 20.0, air_viscosity(20.0), factor
    )
    return STAND.ambient - float(pressure)


def plug(
    lands: Sequence[Land],
    clearances: Sequence[float],
    *,
    factor: float = ANYWHERE,
    row: int = 2,
    circuit: str | None = None,
    repaired: bool = False,
) -> VacuumReading:
    """Those lands read with the orifice that brings the gauge nearest to its middle."""
    orifice = min((0.25e-3, 0.5e-3, 1e-3), key=lambda each: abs(shown(lands, clearances, each, factor) * IN_HG - 13))
    return VacuumReading(
        circuit or f"{lands[0].component}/{lands[0].land}",
        circuit,
        tuple(land.key for land in lands),
        shown(lands, clearances, orifice, factor),
        orifice,
        repaired,
        Place("vacuum.csv", row=row),
    )


def table(*readings: VacuumReading, stand: VacuumStand = STAND) -> VacuumTable:
    return VacuumTable("vacuum.csv", "0" * 64, None, stand, readings)


@pytest.fixture(scope="module")
def five_speed() -> Controller:
    return load_controller("five_speed_2005")


@pytest.fixture(scope="module")
def diagnosed(five_speed: Controller, hipol: Fluid, limits: Limits) -> Callable[..., Diagnosis]:
    def run(*readings: VacuumReading, stand: VacuumStand = STAND, **options: object) -> Diagnosis:
        return diagnose(five_speed, hipol, limits, vacuum=table(*readings, stand=stand), **options)

    return run


@pytest.mark.parametrize("unit", first_of(UNITS))
def test_a_new_unit_is_green_where_it_was_tested_and_nowhere_else(unit: str, hipol: Fluid, limits: Limits) -> None:
    controller = load_controller(unit)
    lands = [land for land in controller.lands if not land.seal][:8]
    readings = [plug([land], [land.new_clearance], row=row) for row, land in enumerate(lands, 2)]
    circuits = [
        (circuit.id, [land for land in controller.lands_around(circuit.id) if not land.seal])
        for circuit in controller.circuits[:2]
    ]
    readings += [
        plug(several, [land.new_clearance for land in several], circuit=name, row=50) for name, several in circuits
    ]
    diagnosis = diagnose(controller, hipol, limits, vacuum=table(*readings))
    tested = {land.key for land in lands} | {several[0].key for _, several in circuits if len(several) == 1}
    for land in diagnosis.lands:
        expected = Verdict.OK if land.key in tested else Verdict.NOT_MEASURED
        assert land.verdict == expected, land.key
    assert diagnosis.measured == len(tested)
    assert diagnosis.verdict == Verdict.OK
    assert not diagnosis.passed  # most of it was not measured
    assert {finding.verdict for finding in diagnosis.vacuum} == {Verdict.OK}
    assert len(diagnosis.vacuum) == len({reading.lands for reading in readings})


def test_a_worn_land_is_flagged_with_an_interval_that_holds_wherever_the_spool_lay(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    land = five_speed.land("boost_valve", 2)
    for factor in (1.0, 1.5, 2.5):
        worn = plug([land], [42e-6], factor=factor)
        found = diagnosed(worn).vacuum[0]
        low, high = found.interval
        assert low * 0.99 <= 42e-6 <= high * 1.01, factor
        assert found.verdict.flagged, factor
    state = next(each for each in diagnosed(worn).lands if each.key == land.key)
    assert state.state.status == "vacuum"
    assert state.verdict.flagged
    assert {source.kind for source in state.uncertainty.sources.sources} == {
        "vacuum gauge", "vacuum stand", "spool position in the vacuum test", "contact length in the vacuum test",
    }  # fmt: skip


def test_a_concentric_spool_halves_the_interval(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    land = five_speed.land("boost_valve", 2)
    reading = plug([land], [30e-6], factor=1.0)
    wide = diagnosed(reading).vacuum[0]
    narrow = diagnosed(reading, assumptions=DEFAULTS.with_settings({"tested_position_percent": 0})).vacuum[0]
    assert narrow.clearance == pytest.approx(30e-6, rel=5e-3, abs=0.0)
    assert np.ptp(narrow.interval) < 0.5 * np.ptp(wide.interval)
    # in service the spool lies anywhere again, unless the profile states where
    stated = diagnosed(
        reading,
        assumptions=DEFAULTS.with_settings({"tested_position_percent": 0}),
        profile=WORKSHOP.with_options(eccentricity=0.5),
    ).vacuum[0]
    assert narrow.leakage == pytest.approx(1.5 / 1.375 * stated.leakage, rel=0.02, abs=0.0)
    assert np.ptp(stated.leakage_interval) / stated.leakage < 0.6 * np.ptp(narrow.leakage_interval) / narrow.leakage


def test_a_flow_in_service_is_that_of_the_engine(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    anywhere = WORKSHOP.with_options(eccentricity="unknown")
    diagnosis = diagnosed(plug([five_speed.land("boost_valve", 2)], [30e-6]), profile=anywhere)
    found = diagnosis.vacuum[0]
    assert found.leakage == pytest.approx(diagnosis.hot_idle.leakage_of(found.lands[0].key), rel=0.02, abs=0.0)


# --- beside diameters


def of_diameters(
    land: Land, clearance: float, readings_of: Callable[..., Readings], controller: Controller
) -> Readings:
    size = land.nominal_diameter
    return readings_of(controller, {land.key: (size, size + 2.0 * clearance)})


def test_cubes_of_diameters_and_vacuum_are_weighed_by_the_inverse_variance_of_the_clearance(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller, readings_of: Callable[..., Readings]
) -> None:
    land = five_speed.land("boost_valve", 2)
    sheet = of_diameters(land, 24e-6, readings_of, five_speed)
    both = diagnosed(plug([land], [27e-6]), readings=sheet)
    alone = diagnosed(plug([land], [27e-6]))
    state, by_leak = (next(each for each in of.lands if each.key == land.key) for of in (both, alone))
    cubes = []
    for clearance, u in (
        (24e-6, both_u(both, land)),
        (by_leak.state.radial_clearance, by_leak.uncertainty.u_clearance),
    ):
        cubes.append((clearance**3, u**-2))
    expected = np.average([cube for cube, _ in cubes], weights=[weight for _, weight in cubes]) ** (1 / 3)
    assert state.state.status == "measured"
    assert state.state.radial_clearance == pytest.approx(expected, rel=1e-3, abs=0.0)
    assert 24e-6 < state.state.radial_clearance < by_leak.state.radial_clearance
    assert state.uncertainty.u_clearance == pytest.approx(sum(weight for _, weight in cubes) ** -0.5, rel=1e-3, abs=0.0)


@pytest.mark.parametrize(
    ("own", "u_own", "by_leak", "u_leak"), [(10, 3, 18, 2), (4, 4, 12, 1.5), (-2, 3, 5, 1), (14, 1.5, 8, 3)]
)
def test_the_narrower_of_two_clearances_does_not_win_for_being_narrow(
    own: float, u_own: float, by_leak: float, u_leak: float, five_speed: Controller
) -> None:
    new = clearances(None, five_speed, temperature_c=20.0)[0]
    measured = replace(new, status="measured", radial_clearance=own * 1e-6)
    reading = VacuumReading("", None, (new.land.key,), 5e4)
    found = with_leak(measured, u_own * 1e-6, LeakClearance(by_leak * 1e-6, u_leak * 1e-6, 0.0, 0.0, 0.0, reading))
    weight = u_own**2 / (u_own**2 + u_leak**2)
    assert not found.contradicted
    assert found.leak_weight == pytest.approx(weight, rel=1e-9, abs=0.0)
    mean = (1.0 - weight) * own + weight * by_leak
    assert mean * 0.99 <= found.radial_clearance * 1e6 <= mean + 2.5  # the mean of cubes is a little wider


def both_u(diagnosis: Diagnosis, land: Land) -> float:
    """The uncertainty that the diameters alone leave."""
    bare = replace(diagnosis.vacuum_table, readings=())
    alone = diagnose(diagnosis.controller, diagnosis.fluid, diagnosis.limits, readings=diagnosis.readings, vacuum=bare)
    return float(alone.uncertainty.land(land.key).u_clearance)


@pytest.mark.parametrize(("by_diameters", "by_leak"), [(24e-6, 48e-6), (48e-6, 24e-6)])
def test_a_contradiction_is_told_and_the_wider_counts(
    by_diameters: float,
    by_leak: float,
    diagnosed: Callable[..., Diagnosis],
    five_speed: Controller,
    readings_of: Callable[..., Readings],
) -> None:
    land = five_speed.land("boost_valve", 2)
    sheet = of_diameters(land, by_diameters, readings_of, five_speed)
    diagnosis = diagnosed(plug([land], [by_leak], row=7), readings=sheet)
    found = next(each for each in diagnosis.lands if each.key == land.key)
    message = next(each for each in diagnosis.messages if each.code == "vacuum_contradicts")
    for words in ("boost_valve", "vacuum.csv", "row 7", f"tell {by_diameters * 1e6:g} µm"):
        assert words in str(message.text), words
    assert message.place == Place("vacuum.csv", row=7)
    assert found.state.radial_clearance == pytest.approx(48e-6, rel=0.05, abs=0.0)
    assert found.in_doubt
    assert not diagnosis.passed


def test_a_repaired_bore_counts_beside_the_diameters_it_had_before(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller, readings_of: Callable[..., Readings]
) -> None:
    land = five_speed.land("boost_valve", 2)
    sheet = of_diameters(land, 45e-6, readings_of, five_speed)
    diagnosis = diagnosed(plug([land], [45e-6]), plug([land], [14e-6], repaired=True, row=3), readings=sheet)
    found = next(each for each in diagnosis.lands if each.key == land.key)
    assert found.state.radial_clearance == pytest.approx(14e-6, rel=0.05, abs=0.0)
    assert found.verdict == Verdict.OK
    assert not found.in_doubt
    assert [each.level for each in diagnosis.messages if each.code == "vacuum_after_repair"] == ["info"]
    worse = diagnosed(
        plug([land], [45e-6], repaired=True, row=3), readings=of_diameters(land, 14e-6, readings_of, five_speed)
    )
    assert any(each.code == "vacuum_contradicts" for each in worse.messages)


def test_a_spool_alone_tells_nothing_beside_its_leak(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller, readings_of: Callable[..., Readings]
) -> None:
    land = five_speed.land("boost_valve", 2)
    sheet = readings_of(five_speed, {land.key: (land.nominal_diameter, None)})
    found = next(each for each in diagnosed(plug([land], [14e-6]), readings=sheet).lands if each.key == land.key)
    assert found.state.status == "vacuum"
    assert found.verdict == Verdict.OK
    assert not [each for each in found.messages if each.code == "sleeve_missing"]
    assert found.state.radial_clearance == pytest.approx(14e-6, rel=0.05, abs=0.0)


# --- several lands under one plug


def test_several_lands_say_what_they_leak_together_and_what_each_can_be(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    lands = [land for land in five_speed.lands_around(five_speed.circuits[0].id) if not land.seal]
    assert len(lands) == 3
    worn = [45e-6, *(land.new_clearance for land in lands[1:])]
    diagnosis = diagnosed(plug(lands, worn, circuit=five_speed.circuits[0].id))
    found = diagnosis.vacuum[0]
    weights = [land.nominal_diameter / land.contact_length for land in lands]
    even = np.average([c**3 for c in worn], weights=weights) ** (1 / 3)
    assert found.clearance == pytest.approx(even, rel=0.05, abs=0.0)
    assert found.interval[0] <= even <= found.interval[1]
    assert found.verdict.flagged
    assert not any(land.state.measured for land in diagnosis.lands)  # evidence, not a measurement of any
    assert diagnosis.verdict == found.verdict
    assert diagnosis.decided_by in diagnosis.vacuum_rules
    assert diagnosis.decision in ("fail", "conditional_fail")
    assert diagnosis_record(diagnosis)["unit"]["decided_by"]["kind"] == "vacuum"
    assert answer_of(diagnosis).cause is Cause.NONE
    assert "3 lands leak together" in first_sentence(diagnosis, wording("en"))
    first, *others = found.each  # of each: if it alone is worn
    assert 30e-6 < first.low < 45e-6 < first.high
    assert all(30e-6 < share.low < share.high for share in others)  # any one may be it
    assert any(each.code == "vacuum_shared_leak" for each in diagnosis.messages)
    # a little less: entry loss takes more of an eccentric land's flow than of a concentric one's
    assert found.passes == pytest.approx(ANYWHERE * sum(weights) * even**3, rel=0.1, abs=0.0)
    assert 0.02 < found.u_passes / found.passes < 0.15
    low, high = found.leakage_interval
    assert low < found.leakage < high


def test_a_circuit_within_its_limits_makes_no_unit_green(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    lands = five_speed.lands_around(five_speed.circuits[0].id)
    diagnosis = diagnosed(plug(lands, [land.new_clearance for land in lands], circuit=five_speed.circuits[0].id))
    assert diagnosis.vacuum[0].verdict == Verdict.OK
    assert diagnosis.verdict == Verdict.NOT_MEASURED
    assert diagnosis.decided_by is None


# --- before and after


def test_a_repair_is_told_from_the_stand_s_errors(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    land = five_speed.land("boost_valve", 2)
    found = diagnosed(plug([land], [40e-6]), plug([land], [14e-6], repaired=True, row=3)).vacuum
    (finding,) = found
    assert finding.clearance == pytest.approx(14e-6, rel=0.05, abs=0.0)  # the last state counts
    assert finding.change.significant
    assert finding.change.interval[0] <= -26e-6 <= finding.change.interval[1]
    same = diagnosed(plug([land], [20e-6]), plug([land], [19.5e-6], repaired=True, row=3)).vacuum[0]
    assert not same.change.significant
    assert diagnosed(plug([land], [20e-6])).vacuum[0].change is None


def test_repeats_of_one_state_are_one_finding(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    land = five_speed.land("boost_valve", 2)
    three = diagnosed(*(plug([land], [30e-6], row=row) for row in (2, 3, 4)))
    assert len(three.vacuum) == 1
    assert len(three.vacuum[0].readings) == 3


@pytest.mark.parametrize(
    ("several", "orifice"), first_of([(True, 0.5e-3), (True, 1e-3), (False, 0.5e-3), (False, 1e-3)])
)
def test_intervals_hold_what_was_drawn(several: bool, orifice: float, five_speed: Controller) -> None:
    """Lands new or worn, spools anywhere, a stand and a gauge that err: 95 of 100 intervals hold the clearance."""
    lands = five_speed.lands_around(five_speed.circuits[0].id) if several else [five_speed.land("boost_valve", 2)]
    random, inside, trials = np.random.default_rng(3), 0, 200
    for _ in range(trials):
        worn = random.exponential(12e-6, len(lands)) * (random.random(len(lands)) < 0.4)
        clearances = random.uniform(6.4e-6, 20e-6, len(lands)) + worn
        factors = {land.component: 1.0 + 1.5 * random.random() ** 2 for land in lands}
        lengths = [land.contact_length + random.normal(0.0, 0.1e-3) for land in lands]
        diameters = [land.nominal_diameter for land in lands]
        area = 0.2 * math.pi * orifice**2 * math.exp(random.normal(0.0, 0.05))
        pressure = circuit_pressure(
            STAND.ambient - STAND.supply, STAND.ambient, area,
            diameters, clearances, lengths, 20.0, air_viscosity(20.0), [factors[land.component] for land in lands],
        )  # fmt: skip
        shows = STAND.ambient - float(pressure) + random.uniform(-0.5, 0.5) / IN_HG
        reading = VacuumReading("", None, tuple(land.key for land in lands), shows, orifice)
        tests = vacuum._Tests(table(reading), five_speed, DEFAULTS)
        factor = tests.together(0, lands, tests.split(0, lands))
        drawn = np.cbrt(vacuum._cubes(tests, [reading], lands, 0, tests.length(0, lands), factor))
        low, high = interval_of(drawn, 0.95)
        inside += low <= np.average(clearances**3, weights=np.divide(diameters, lengths)) ** (1 / 3) <= high
    assert inside / trials >= 0.91  # 95 % less three standard deviations of the count


# --- the stand


def test_a_calibrated_stand_needs_no_assumed_coefficient(five_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    land = five_speed.land("boost_valve", 2)
    reading = replace(plug([land], [30e-6]), orifice=None)
    with pytest.raises(InputError, match="row 2: nothing tells how much air the stand draws"):
        diagnose(five_speed, hipol, limits, vacuum=table(reading))
    area = 0.8 * math.pi / 4.0 * plug([land], [30e-6]).orifice ** 2
    stated = diagnose(five_speed, hipol, limits, vacuum=table(reading, stand=replace(STAND, flow_area=area)))
    assert stated.vacuum[0].stand.known
    assert not [each for each in stated.messages if each.code == "vacuum_not_calibrated"]
    # a stand of 1 mm with C_d 0.75, calibrated with 0.5 and 1 mm
    inches = (101_325.0 - 27_407.8, 101_325.0 - 83_799.0)
    supply = 101_325.0 - 16_665.25
    made = tuple(Calibration(d, p) for d, p in zip((0.5e-3, 1e-3), inches, strict=True))
    calibrated = VacuumStand(supply=supply, calibrations=made)
    found = diagnose(five_speed, hipol, limits, vacuum=table(reading, stand=calibrated)).vacuum[0].stand
    assert found.area == pytest.approx(0.75 * math.pi / 4.0 * 1e-6, rel=1e-3, abs=0.0)
    assert found.known


def test_a_flow_area_holds_for_one_orifice(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    first, second = (plug([five_speed.land("boost_valve", number)], [25e-6], row=number + 1) for number in (1, 2))
    first, second = replace(first, orifice=1e-3), replace(second, orifice=0.5e-3)
    stand = replace(STAND, flow_area=0.15e-6)
    with pytest.raises(InputError, match=r"row 3: the stand's flow area is that of one orifice.*found '0\.5 mm'"):
        diagnosed(first, second, stand=stand)
    for other in (replace(second, orifice=1e-3), replace(second, orifice=None)):
        assert {each.stand.area for each in diagnosed(first, other, stand=stand).vacuum} == {0.15e-6}
    calibrated = replace(stand, calibrations=(Calibration(0.5e-3, 5.7 / IN_HG, 0.5e-3),))
    of_first, of_second = (each.stand.area for each in diagnosed(first, second, stand=calibrated).vacuum)
    assert of_first == 0.15e-6 != of_second


def test_a_circuit_without_pressure_at_hot_idle_leaks_nothing_to_tell(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    names = ("epc", "direct_clutch")
    plugs = [plug(five_speed.lands_around(name), [20e-6] * 3, circuit=name, row=row) for row, name in enumerate(names)]
    diagnosis = diagnosed(*plugs)
    keys = ("leakage_dm3_min", "leakage_low_dm3_min", "leakage_high_dm3_min")
    epc, direct = ([each[key] for key in keys] for each in diagnosis_record(diagnosis)["vacuum"])
    assert all(epc)
    assert direct == [None] * 3
    rows = next(part for part in vacuum_section(diagnosis, wording("en")).parts if isinstance(part, Table))
    assert [" to " in rows.texts(row)[-1] for row in rows.rows] == [True, False], rows.texts(rows.rows[1])


def test_the_stand_s_error_is_one_for_all_lands(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    lands = [five_speed.land("boost_valve", number) for number in (1, 2)]
    diagnosis = diagnosed(*(plug([land], [25e-6], row=row) for row, land in enumerate(lands, 2)))
    shared = [diagnosis.uncertainty.land(land.key).sources.groups for land in lands]
    assert [list(each) for each in shared] == [["vacuum stand"]] * 2


@pytest.mark.parametrize(
    ("clearance", "orifice", "code"), [(3e-6, 1e-3, "vacuum_tight"), (200e-6, 0.25e-3, "vacuum_open")]
)
def test_a_gauge_at_its_end_is_a_bound(
    clearance: float, orifice: float, code: str, diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    land = five_speed.land("boost_valve", 2)
    reading = replace(plug([land], [clearance]), vacuum=shown([land], [clearance], orifice), orifice=orifice)
    assert [each.code for each in diagnosed(reading).messages if each.code in ("vacuum_tight", "vacuum_open")] == [code]


@pytest.mark.parametrize("gauge", [0.5, 0.0])
@pytest.mark.parametrize("several", [False, True])
def test_more_than_the_supply_is_an_upper_bound(
    several: bool, gauge: float, diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    lands = five_speed.lands_around(five_speed.circuits[0].id) if several else [five_speed.land("boost_valve", 2)]
    keys = tuple(land.key for land in lands)
    assumptions = DEFAULTS.with_settings({"vacuum_gauge_in_hg": gauge})
    supply, above = (
        diagnosed(VacuumReading("", None, keys, STAND.supply + over / IN_HG, 1e-3), assumptions=assumptions)
        for over in (0.0, 0.9)
    )
    (found,) = above.vacuum
    assert found.tight
    assert found.passes > 0.0
    assert found.u_passes > 0.0
    assert found.interval[0] == 0.0 < found.interval[1]
    assert found.interval == supply.vacuum[0].interval
    if not several:
        land = above.uncertainty.land(lands[0].key)
        assert land.u_clearance > 0.1 * found.clearance > 0.0


def test_hardly_any_vacuum_tells_what_lands_pass_at_least(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    keys = tuple(land.key for land in five_speed.lands_around(five_speed.circuits[0].id))
    none, least = (
        diagnosed(VacuumReading("", None, keys, shows / IN_HG, 1e-3)).vacuum[0] for shows in (0.3, 0.8)
    )  # a gauge that shows 0.3 in-Hg errs by no more than the half that makes 0.8 of it
    assert none.open
    assert not least.open
    assert none.passes == pytest.approx(least.passes, rel=0.35, abs=0.0)
    assert none.passes < least.passes
    assert none.u_passes < 0.1 * none.passes


def test_a_land_that_the_valve_body_does_not_have_is_refused(diagnosed: Callable[..., Diagnosis]) -> None:
    reading = VacuumReading("x/1", None, (("x", 1),), 5e4, 1e-3, place=Place("vacuum.csv", row=4))
    with pytest.raises(InputError, match="row 4: no such land"):
        diagnosed(reading)


# --- what a stand should show


@pytest.mark.parametrize("unit", [*UNITS, "four_speed_2023"])
def test_pass_marks_are_what_lands_with_a_fifth_more_leak_show(unit: str) -> None:
    controller = load_controller(unit)
    marks = pass_marks(controller)
    assert len(marks) == (len(controller.circuits) or len({land.component for land in controller.lands}))
    for mark in marks:
        widest = [land.widest_new for land in mark.lands]
        grown = [c * (1.0 + GROWN) ** (1 / 3) for c in widest]
        assert mark.new == pytest.approx(shown(mark.lands, widest, mark.orifice), rel=1e-9, abs=0.0)
        assert mark.mark == pytest.approx(shown(mark.lands, grown, mark.orifice), rel=1e-9, abs=0.0)
        assert mark.doubtful == pytest.approx(shown(mark.lands, grown, mark.orifice, 2.5), rel=1e-9, abs=0.0)
        others = [shown(mark.lands, widest, each) - shown(mark.lands, grown, each) for each in (0.25e-3, 0.5e-3, 1e-3)]
        assert mark.new - mark.mark == pytest.approx(max(others), rel=1e-9, abs=0.0)
        assert mark.resolved is (mark.new - mark.mark > 0.5 / IN_HG)


def test_pass_marks_of_a_calibrated_stand_are_with_its_own_orifices(five_speed: Controller) -> None:
    stand = VacuumStand(calibrations=(Calibration(0.5e-3, 60e3, 0.7e-3), Calibration(1e-3, 25e3, 0.7e-3)))
    assert {mark.orifice for mark in pass_marks(five_speed, stand)} == {0.7e-3}
    assert {mark.orifice for mark in pass_marks(five_speed, replace(STAND, flow_area=5e-7))} == {None}


@pytest.mark.parametrize(("known", "refused"), [(0.5e-3, False), (1.0e-3, True)])
def test_a_calibration_that_the_stands_orifice_cannot_have_is_refused(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller, known: float, refused: bool
) -> None:
    land = five_speed.lands[0]
    reading = replace(plug([land], [14e-6]), orifice=0.5e-3)
    # air is choked in the stand's orifice: before it like ones in a row hold four fifths of the ambient pressure
    stand = replace(STAND, calibrations=(Calibration(known, 5.7 / IN_HG, 0.5e-3, Place("vacuum.csv", row=4)),))
    if refused:
        with pytest.raises(InputError, match=r"row 4.*cannot draw through more than its own orifice.*C_d A 0\.6"):
            diagnosed(reading, stand=stand)
    else:
        assert diagnosed(reading, stand=stand).vacuum[0].stand.known


def test_a_calibration_that_fits_no_reading_is_told(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    readings = [plug([land], [width]) for land, width in zip(five_speed.lands[:2], (8e-6, 45e-6), strict=True)]
    assert readings[0].orifice != readings[1].orifice
    stand = replace(STAND, calibrations=(Calibration(0.5e-3, 5.7 / IN_HG),))
    told = [each.text for each in diagnosed(*readings, stand=stand).messages if each.code == "vacuum_not_calibrated"]
    assert len(told) == 1
    assert "no calibration says" in told[0]


def test_hardly_any_vacuum_is_a_lower_bound_and_measures_no_land(
    diagnosed: Callable[..., Diagnosis], five_speed: Controller
) -> None:
    land = five_speed.lands[0]
    diagnosis = diagnosed(replace(plug([land], [14e-6]), vacuum=0.1 / IN_HG, orifice=0.5e-3))
    found = diagnosis.vacuum[0]
    assert found.open
    assert found.clearance == found.interval[0]
    assert not any(each.state.measured for each in diagnosis.lands)
    assert found.verdict.flagged
    assert diagnosis.verdict.flagged
    assert any("check that the plug seals" in each.text for each in diagnosis.messages)


def test_a_land_read_twice_names_both_readings(diagnosed: Callable[..., Diagnosis], five_speed: Controller) -> None:
    first = plug([five_speed.lands[0]], [14e-6])
    diagnosis = diagnosed(first, replace(first, vacuum=first.vacuum - 1.0 / IN_HG))
    told = next(each.text for each in diagnosis.messages if each.code == "vacuum_read_again")
    assert f"{first.vacuum * IN_HG:.1f}, {first.vacuum * IN_HG - 1.0:.1f} in-Hg" in told
