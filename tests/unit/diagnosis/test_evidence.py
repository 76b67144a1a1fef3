"""What is likely worn before anything is opened: from gauges, from plugs, and from nothing at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.catalogue.pump import PumpClearances
from atleak.catalogue.repairs import Complaint, LandKey
from atleak.common.errors import Place
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.evidence import WORTH, evidence_of, readings_by_value
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.posterior import Plug, PosteriorUnit
from atleak.diagnosis.vacuum_card import pass_marks
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.job.case import Case, SourceFile
from atleak.measurements.clearances import clearances
from atleak.measurements.flow_readings import FlowReading, FlowTable
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable
from atleak.measurements.readings import Readings
from atleak.measurements.vacuum import VacuumReading, VacuumStand, VacuumTable
from tests.unit.conftest import first_of

SAMPLES = Path(__file__).parents[3] / "sample_data"
UNITS = {"five_speed_2005": "forward_clutch", "zf_6hp26": "clutch_a", "jatco_jf506e": "low_clutch"}
IDLE, STALL = Engine.SLOW_IDLE, Engine.STALL


def gauged(name: str, worn: Mapping[LandKey, float], taps: tuple[str, ...]) -> Diagnosis:
    """Diagnose a unit of which some lands are worn [m], by gauges alone that show what the engine holds."""
    controller, fluid, limits = load_controller(name), load_fluid("hipol_atf_iid"), load_limits("project_default")
    states = [
        replace(each, radial_clearance=each.radial_clearance + worn.get(each.land.key, 0.0))
        for each in clearances(None, controller)
    ]
    model = LeakageModel(controller, tuple(states), fluid, WORKSHOP)
    readings = []
    for engine in (IDLE, STALL):
        point = next(each for each in controller.operating_points if each.name == _POINTS[engine])
        held = project(model, point)
        for tap in taps:
            pressure = held.main_pressure_held if tap == LINE_TAP else held.circuit(tap).pressure
            readings.append(GaugeReading(GaugeCell("D", engine, tap), pressure))
    return diagnose(
        controller, fluid, limits, pressures=PressureTable("made", "0" * 64, None, ("kPa",), tuple(readings))
    )


_POINTS = {IDLE: "hot_idle", STALL: "stall"}


def lands_of(name: str, circuit: str) -> list[LandKey]:
    return [gap.key for gap in load_controller(name).gaps if gap.high.section == circuit and 1 in gap.gears]


@pytest.mark.parametrize("name", first_of(UNITS))
def test_a_circuit_that_lost_its_pressure_leads_and_its_lands_are_likelier_worn_than_others(name: str) -> None:
    circuit = UNITS[name]
    lands = lands_of(name, circuit)
    evidence = evidence_of(gauged(name, dict.fromkeys(lands, 20e-6), (LINE_TAP, circuit)))
    assert evidence.circuits[0].circuit.id == circuit
    assert evidence.circuits[0].probability > 0.5
    assert evidence.thin is None
    by_key = {each.land.key: each for each in evidence.lands}
    others = [each.probability for key, each in by_key.items() if key not in lands]
    assert max(by_key[key].probability for key in lands) > max(others) + 0.05
    much = evidence_of(gauged(name, dict.fromkeys(lands, 45e-6), (LINE_TAP, circuit)))
    assert (much.seals[0].circuit.id, much.seals[0].probability > 0.9) == (circuit, True), "a seal explains any loss"
    assert evidence.effective_samples > 50.0
    for each in evidence.lands:
        assert 0.0 < each.low <= each.clearance <= each.high


@pytest.mark.parametrize("name", first_of(UNITS))
def test_a_sound_unit_accuses_nothing(name: str) -> None:
    circuit = UNITS[name]
    evidence = evidence_of(gauged(name, {}, (LINE_TAP, circuit)))
    read = next(each for each in evidence.circuits if each.circuit.id == circuit)
    assert read.read
    assert read.probability < 0.05
    assert max(each.probability for each in evidence.lands) < 0.3
    assert evidence.pump is None or evidence.pump.probability < 0.3


def test_what_also_stands_beside_a_gauge_is_the_same_number() -> None:
    circuit = "forward_clutch"
    lands = dict.fromkeys(lands_of("five_speed_2005", circuit), 3e-05)
    diagnosis = gauged("five_speed_2005", lands, (LINE_TAP, circuit))
    said = next(each for each in evidence_of(diagnosis).circuits if each.circuit.id == circuit)
    shown = [each.lost.probability_over(55e3) for each in diagnosis.pressures.readings if each.cell.tap == circuit]
    assert said.probability == max(shown)


def test_with_nothing_read_it_says_that_only_what_is_assumed_stands_there() -> None:
    diagnosis = diagnose(load_controller("zf_6hp26"), load_fluid("hipol_atf_iid"), load_limits("project_default"))
    evidence = evidence_of(diagnosis)
    assert evidence.thin is not None
    assumed = diagnosis.gauge_card.assumptions.worn_lands
    for each in evidence.lands:
        assert each.probability == pytest.approx(assumed * np.exp(-4.0 / 12.0), abs=0.03)


def test_lands_between_the_same_pressures_share_a_group_and_one_that_was_measured_has_none() -> None:
    diagnosis = gauged("five_speed_2005", {}, (LINE_TAP,))
    ways: dict[LandKey, set] = {}
    for gap in diagnosis.controller.gaps:
        ways.setdefault(gap.key, set()).add((gap.high, gap.low, gap.gears))
    groups: dict[int, list[LandKey]] = {}
    for each in evidence_of(diagnosis).lands:
        if each.group is not None:
            groups.setdefault(each.group, []).append(each.land.key)
    assert groups
    for keys in groups.values():
        assert len(keys) > 1
        assert all(ways.get(key, set()) == ways.get(keys[0], set()) for key in keys)
    sheet = SourceFile.at(SAMPLES / "measuring_sheet_five_speed.xlsx")
    diagnosis = Case(controller="five_speed_2005", readings=sheet).diagnose()
    measured = [each for each in evidence_of(diagnosis).lands if each.measured]
    assert measured
    assert all(each.group is None for each in measured)


def test_lands_that_the_complaint_names_are_read_sooner() -> None:
    controller = load_controller("five_speed_2005")
    lands = (("shift_1_2", 2), ("reverse_modulator", 1))
    complaint = Complaint("late", "shifts late", ("hot_idle",), lands, "made for the test")
    catalogue = load_fluid("hipol_atf_iid"), load_limits("project_default")
    orders = [
        [each.land.key for each in readings_by_value(diagnose(controller, *catalogue, complaint=each), 34)]
        for each in (None, complaint)
    ]
    before, with_it = ([order.index(key) for key in lands] for order in orders)
    assert sum(with_it) < sum(before)


@pytest.mark.parametrize("name", first_of(UNITS))
def test_lands_are_read_by_turns_first_of_the_circuit_that_lost_its_pressure(name: str) -> None:
    new, circuit = gauged(name, {}, (LINE_TAP,)), UNITS[name]
    lands = lands_of(name, circuit)
    diagnosis = gauged(name, dict.fromkeys(lands, 20e-6), (LINE_TAP, circuit))
    chosen = readings_by_value(diagnosis, 10)
    keys = [each.land.key for each in chosen]
    assert len(set(keys)) == 10
    assert keys[0] in lands
    assert chosen[0].value > WORTH
    assert readings_by_value(diagnosis, 3) == chosen[:3]
    first = [each.land.key for each in readings_by_value(new, 10)]
    worn = {each.land.key: each.probability for each in evidence_of(new).lands}
    assert max(worn[key] for key in first[:3]) == max(worn.values()), "what is likeliest past its limit"
    leaks = {each.key: each.leakage or 0.0 for each in new.lands}
    leakiest = sorted(leaks, key=lambda key: -leaks[key])
    assert set(leakiest[:3]) & set(first), "what leaks when new can leak most"


@pytest.fixture(scope="module")
def plugged() -> tuple[PosteriorUnit, list[LandKey]]:
    diagnosis = gauged("five_speed_2005", {}, (LINE_TAP,))
    return diagnosis, lands_of("five_speed_2005", "forward_clutch")[:2]


@pytest.mark.parametrize("width", [12e-6, 40e-6])
def test_lands_that_share_a_plug_pass_together_what_it_passes(plugged, width: float) -> None:
    diagnosis, keys = plugged
    states = [each for each in diagnosis.model.clearances if each.land.key in keys]
    passes = 1.5 * sum(each.spool_diameter * width**3 / each.land.contact_length for each in states)
    plug = Plug(tuple(keys), passes, 0.05 * passes)
    card = diagnosis.gauge_card
    unit = PosteriorUnit(card.model, card.sources, card.assumptions, [diagnosis.projection], [plug])
    drawn = unit.clearances(unit.draw(4096))
    now = np.array([drawn[each.land.key][0] for each in states])
    alone = [each.spool_diameter * row**3 / each.land.contact_length for each, row in zip(states, now, strict=True)]
    # the spool lay anywhere in the test: from the middle, F 1, to its bore, F 2.5
    low, high = np.quantile(sum(alone), (0.01, 0.99)) / passes
    assert 1.0 / 2.9 < low < 1.0 / 1.6
    assert 0.75 < high < 1.15
    worn = np.mean(now - np.array([drawn[key][1] for key in keys]) > 4e-6)
    assert worn < 0.05 if width < 20e-6 else worn > 0.5


def test_a_land_beside_its_plug_is_drawn_as_without_it(plugged) -> None:
    diagnosis, keys = plugged
    card = diagnosis.gauge_card
    units = [
        PosteriorUnit(card.model, card.sources, card.assumptions, [diagnosis.projection], plugs)
        for plugs in ((), (Plug((keys[0],), 1e-12, 1e-13),))
    ]
    drawn = [each.clearances(each.draw(512)) for each in units]
    other = next(key for key in units[0].lands if key != keys[0])
    assert np.array_equal(drawn[0][other][0], drawn[1][other][0])
    assert not np.array_equal(drawn[0][keys[0]][0], drawn[1][keys[0]][0])


def with_jug(litres_per_minute: float) -> Diagnosis:
    controller = load_controller("five_speed_2005")
    caught = FlowReading("hot_idle", "cooler", litres_per_minute / 60e3)
    flows = FlowTable("made", "0" * 64, None, (caught,))
    return diagnose(controller, load_fluid("hipol_atf_iid"), load_limits("project_default"), flows=flows)


def test_a_jug_as_full_as_usual_says_little_and_one_that_stays_empty_makes_the_pump_likelier_worn() -> None:
    usual = with_jug(1.0).flows[0].usual * 60e3
    full, empty = (evidence_of(with_jug(part * usual)).pump.probability for part in (1.0, 0.05))
    nothing = diagnose(load_controller("five_speed_2005"), load_fluid("hipol_atf_iid"), load_limits("project_default"))
    before = evidence_of(nothing)
    assert full <= before.pump.probability + 0.02
    assert empty > before.pump.probability + 0.1


@pytest.mark.parametrize(("side", "worn"), [(41.0, False), (150.0, True)])
def test_a_pump_that_was_measured_is_as_worn_as_it_measures(side: float, worn: bool) -> None:
    controller = load_controller("aisin_aw55_50sn")
    diagnosis = diagnose(
        controller,
        load_fluid("hipol_atf_iid"),
        load_limits("project_default"),
        pump_clearances=PumpClearances.of_um(side, None),
    )
    pump = evidence_of(diagnosis).pump
    assert pump is not None
    assert (pump.probability > 0.95) is worn
    assert (pump.probability < 0.05) is not worn
    assert pump.low <= pump.growth <= pump.high


@pytest.mark.parametrize("order", [1, -1])
def test_plugs_that_share_a_land_are_drawn_together(plugged, order: int) -> None:
    diagnosis, (first, second) = plugged
    third = next(land.key for land in diagnosis.controller.lands if land.key not in (first, second))
    card, states = diagnosis.gauge_card, {each.land.key: each for each in diagnosis.model.clearances}

    def passes(*keys: LandKey, width: float) -> float:
        return sum(1.5 * states[key].spool_diameter * width**3 / states[key].land.contact_length for key in keys)

    tight, leaky = (passes(first, second, width=10e-6), passes(second, third, width=50e-6))
    plugs = [Plug((first, second), tight, 0.1 * tight), Plug((second, third), leaky, 0.1 * leaky)][::order]
    unit = PosteriorUnit(card.model, card.sources, card.assumptions, [diagnosis.projection], plugs)
    drawn = unit.clearances(unit.draw(2048))
    worn = {key: float(np.mean(now - new > 4e-6)) for key, (now, new) in drawn.items()}
    assert worn[third] > 0.95
    assert max(worn[first], worn[second]) < 0.1


def test_a_plug_with_hardly_any_vacuum_makes_its_lands_likelier_worn(plugged) -> None:
    diagnosis, keys = plugged
    card, passes = diagnosis.gauge_card, 5e-12
    worn = []
    for plugs in ((), [Plug(tuple(keys), passes, 0.05 * passes, at_least=True)]):
        unit = PosteriorUnit(card.model, card.sources, card.assumptions, [diagnosis.projection], plugs)
        drawn = unit.clearances(unit.draw(2048))
        worn.append(np.mean(np.any([drawn[key][0] - drawn[key][1] > 4e-6 for key in keys], axis=0)))
    assert worn[1] > 0.95 > 0.5 > worn[0]


@pytest.mark.parametrize("name", first_of(["zf_6hp26", "gm_4l60e"]))
def test_a_land_that_the_stand_passes_as_new_is_not_called_worn(name: str) -> None:
    controller = load_controller(name)
    marks = [each for each in pass_marks(controller, by_land=True) if each.orifice is not None][:4]
    readings = [
        VacuumReading(each.name, None, (each.lands[0].key,), each.new, each.orifice, False, Place("made", row=row))
        for row, each in enumerate(marks)
    ]
    table = VacuumTable("made", "0" * 64, None, VacuumStand(), tuple(readings))
    diagnosis = diagnose(controller, load_fluid("hipol_atf_iid"), load_limits("project_default"), vacuum=table)
    found = {each.land.key: each.probability for each in evidence_of(diagnosis).lands}
    for each in marks:
        assert found[each.lands[0].key] < 0.5, "all at the upper end of new"


def test_where_nothing_is_unknown_no_reading_is_worth_its_time() -> None:
    known = replace(DEFAULTS, worn_lands=0.0, mounting_clearance=0.0, worn_pumps=0.0)
    fluid, limits = load_fluid("hipol_atf_iid"), load_limits("project_default")
    diagnosis = diagnose(load_controller("four_speed_2023"), fluid, limits, assumptions=known)
    assert evidence_of(diagnosis).next == ()
    assert all(each.value == pytest.approx(0.0, abs=1e-12) for each in readings_by_value(diagnosis, 3))


def test_a_spool_alone_says_nothing_of_its_bore(readings_of: Callable[..., Readings]) -> None:
    controller = load_controller("five_speed_2005")
    known = load_fluid("hipol_atf_iid"), load_limits("project_default")
    bores = {each.key: each.nominal_diameter for each in controller.lands}
    first = controller.lands[0]
    pair = (first.nominal_diameter, first.nominal_diameter + 2.0 * (first.mounting_range[1] + 1.5e-6))
    both = readings_of(controller, {key: (size, size) for key, size in bores.items()} | {first.key: pair})
    place = first.component, first.planes[0]
    read = (each for each in both.readings if each.part == "spool" or (each.component, each.plane) == place)
    spools = replace(both, readings=tuple(read))
    alone = readings_of(controller, {first.key: pair})
    probabilities = [
        diagnose(controller, *known, readings=sheet).uncertainty.land(first.key).deciding.probability_over_limit
        for sheet in (spools, alone)
    ]
    assert probabilities[0] == pytest.approx(probabilities[1], abs=0.02)
    only = replace(both, readings=tuple(each for each in both.readings if each.part == "spool"))
    evidence = evidence_of(diagnose(controller, *known, readings=only))
    assert not any(each.measured for each in evidence.lands)
    assert evidence.next


@pytest.mark.usefixtures("all_draws")  # from here on in this file
def test_a_nearly_empty_jug_leaves_little_but_a_worn_pump() -> None:
    evidence = [evidence_of(with_jug(litres)) for litres in (0.1, 0.4, 1.2)]
    probabilities = [each.pump.probability for each in evidence]
    assert probabilities == sorted(probabilities, reverse=True)
    assert probabilities[0] > 0.95
    assert min(each.effective_samples for each in evidence) > 100.0
    assert all(each.thin is None for each in evidence)
