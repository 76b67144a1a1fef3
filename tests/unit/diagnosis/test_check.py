"""Gauge readings judged: against what the file permits, against the line, and beside what the engine expects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

from atleak.catalogue.circuits import Circuit, Feed, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.gauge_check import CheckedReading
from atleak.diagnosis.gauge_patterns import Pattern
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.job.case import Case, SourceFile
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.tables.gauges import gauge_record, gauge_table, pattern_text
from atleak.report.tables.names import land_words
from atleak.report.terminal import print_diagnosis
from tests.unit.conftest import first_of

SLOW, FAST, STALL = Engine.SLOW_IDLE, Engine.FAST_IDLE, Engine.STALL
PERMISSIBLE = """
[[permissible_pressure]]
gear = 1
state = "idle"
low_kpa = 400.0
high_kpa = 539.0
source = "own manual"
evidence = "representative"

[[permissible_pressure]]
gear = 1
state = "stall"
low_kpa = 1000.0
high_kpa = 1200.0
source = "own manual"
evidence = "representative"

[[permissible_pressure]]
ranges = ["R"]
state = "idle"
low_kpa = 700.0
source = "own manual"
evidence = "representative"
"""


@pytest.fixture
def unit(permitting: Callable[[str], Path]) -> Controller:
    return load_controller(permitting(PERMISSIBLE))


@pytest.fixture
def judged(hipol: Fluid, limits: Limits) -> Callable[..., Diagnosis]:
    def judge(unit: Controller, *readings: GaugeReading, **options) -> Diagnosis:
        table = PressureTable("gauges.csv", "0" * 64, None, ("kPa",), readings)
        return diagnose(unit, hipol, limits, pressures=table, **options)

    return judge


def at(selected: str, engine: Engine, kpa: float, tap: str = LINE_TAP, **more) -> GaugeReading:
    return GaugeReading(GaugeCell(selected, engine, tap), kpa * 1e3, **more)


def checked(diagnosis: Diagnosis) -> Sequence[CheckedReading]:
    assert diagnosis.pressures is not None
    return diagnosis.pressures.readings


@pytest.mark.parametrize(
    ("kpa", "verdict"),
    [
        (539.0, "ok"),
        (400.0, "ok"),
        (399.0, "watch"),
        (361.0, "watch"),
        (360.0, "replace"),
        (301.0, "replace"),
        (300.0, "critical"),
        (0.0, "critical"),
    ],
)
def test_main_pressure_is_judged_by_how_far_it_is_below_the_permissible(unit, judged, kpa, verdict) -> None:
    diagnosis = judged(unit, at("D", SLOW, kpa))
    assert checked(diagnosis)[0].verdict == verdict
    assert diagnosis.verdict == verdict
    assert diagnosis.pressures.verdict == verdict
    if verdict != "ok":
        assert diagnosis.decided_by.label == "main pressure below the permissible, D, slow idle"


@pytest.mark.parametrize(
    ("kpa", "decision"),
    [(420.0, "pass"), (405.0, "conditional_pass"), (398.0, "conditional_fail"), (380.0, "fail")],
)
def test_the_gauges_uncertainty_says_how_sure_a_verdict_is(unit, judged, kpa, decision) -> None:
    # 2 % of 400 kPa is 8 kPa: plain from 1.645 times that on
    assert checked(judged(unit, at("D", SLOW, kpa)))[0].deciding.decision == decision
    exact = replace(DEFAULTS, main_pressure=0.0)
    assert checked(judged(unit, at("D", SLOW, kpa), assumptions=exact))[0].deciding.decision in ("pass", "fail")


@pytest.mark.parametrize("name", first_of(["five_speed_2005", "four_speed_2023", "gm_4l60e"]))
def test_main_pressure_under_a_published_least_is_critical(judged, name: str) -> None:
    unit = load_controller(name)
    stated = next(each for each in unit.permissible if each.low and each.state == "idle" and 1 in each.gears)
    unit = replace(unit, permissible=(replace(stated, published=True, ranges=frozenset()),))
    for part, published, verdict in ((0.95, True, "critical"), (0.95, False, "watch"), (1.0, True, "ok")):
        its = replace(unit, permissible=(replace(unit.permissible[0], published=published),))
        (line,) = checked(judged(its, at("D", SLOW, part * stated.low / 1e3)))
        assert line.verdict == verdict
        assert (line.deciding.rule.origin == "published") == published
    assert checked(judged(unit, at("D", FAST, 0.95 * stated.low / 1e3)))[0].verdict == Verdict.WATCH, "not published"


def test_forward_ranges_stand_in_first_gear_and_a_range_goes_by_its_name(unit, judged) -> None:
    diagnosis = judged(unit, *(at(each, SLOW, 650.0) for each in ("P", "R", "N", "D", "2")))
    assert {each.cell.range: each.stands for each in checked(diagnosis)} == {
        "P": None, "R": "low", "N": None, "D": "high", "2": "high",
    }  # fmt: skip
    text = next(message.text for message in diagnosis.messages if message.code == "ranges_as_gears")
    assert "D, 2 as gear 1" in text


def test_what_nothing_is_permitted_for_is_not_judged_and_never_ok(unit, judged) -> None:
    diagnosis = judged(unit, at("P", SLOW, 400.0), at("N", STALL, 400.0))
    assert {each.verdict for each in checked(diagnosis)} == {None}
    assert diagnosis.pressures.verdict is None
    assert diagnosis.verdict == Verdict.NOT_MEASURED
    (message,) = [each.text for each in diagnosis.messages if each.code == "pressure_not_judged"]
    assert message.startswith("2 of 2 gauge readings cannot be judged")


def test_over_the_permissible_is_said_with_its_place(unit, judged) -> None:
    diagnosis = judged(unit, at("D", STALL, 1250.0))
    assert checked(diagnosis)[0].over == pytest.approx(50e3, abs=1e-6)
    (message,) = [each for each in diagnosis.messages if each.code == "over_permissible"]
    assert "1250 of at most 1200 kPa" in message.text
    assert diagnosis.verdict == Verdict.OK


def test_at_a_fast_idle_the_low_limit_of_idle_holds_unless_the_file_states_another(permitting, unit, judged) -> None:
    low, high = checked(judged(unit, at("D", FAST, 380.0), at("D", FAST, 900.0, repeat=2)))
    assert (low.verdict, high.stands, high.permissible.high) == (Verdict.WATCH, "normal", None)
    assert "choice of this project" in low.permissible.source
    stated = '\n[[permissible_pressure]]\ngear = 1\nstate = "fast_idle"\nlow_kpa = 350.0\nsource = "own"\n'
    own = load_controller(permitting(PERMISSIBLE + stated))
    assert checked(judged(own, at("D", FAST, 380.0)))[0].verdict == Verdict.OK


# --- what the engine expects


def test_the_engine_says_what_the_pump_holds_at_the_operating_point_of_that_gear(unit, judged) -> None:
    idle = next(point for point in unit.operating_points if point.name == "hot_idle")
    diagnosis = judged(unit, at("D", SLOW, 400.0), at("R", SLOW, 400.0), at("D", STALL, 400.0), at("D", FAST, 400.0))
    expected = {(each.cell.range, each.cell.engine): each.expected for each in checked(diagnosis)}
    assert expected == {
        ("D", SLOW): diagnosis.at(idle).main_pressure_held,
        ("R", SLOW): None,
        ("D", STALL): None,
        ("D", FAST): None,
    }


def test_stated_temperature_and_speed_are_expected_at(unit, judged) -> None:
    idle = next(point for point in unit.operating_points if point.name == "hot_idle")
    reading = at("D", FAST, 400.0, temperature=120.0, engine_speed=3.0)
    diagnosis = judged(unit, reading)
    there = project(diagnosis.model, replace(idle, temperature=120.0, engine_speed=3.0))
    assert there.main_pressure_held < idle.main_pressure  # 180 rpm: the pump cannot hold it
    assert checked(diagnosis)[0].expected == pytest.approx(there.main_pressure_held, abs=1e-6)


def test_a_temperature_outside_the_fluids_data_leaves_out_what_is_expected_and_says_so(unit, judged) -> None:
    diagnosis = judged(unit, at("D", SLOW, 380.0, temperature=199.0))
    assert checked(diagnosis)[0].expected is None
    assert checked(diagnosis)[0].verdict == Verdict.WATCH
    assert any(message.code == "pressure_not_expected" for message in diagnosis.messages)


# --- taps of circuits


def with_circuit(unit: Controller, **changes) -> Controller:
    feed = Feed("p_g", 1.0e-3, 0.62)
    circuit = Circuit("clutch_c1", "clutch C1", frozenset({1}), (feed,), None, "own")
    return replace(unit, circuits=(replace(circuit, **changes),))


STANDING = {"five_speed_2005": "forward_clutch", "zf_6hp26": "clutch_a", "chrysler_41te": "underdrive_clutch"}


def standing(name: str, tap_by: float, line_by: float = 0.0, **more) -> tuple[Controller, list[GaugeReading]]:
    """Return a shipped unit and gauges in drive, so many kPa off what a new one holds at stall, at idle less.

    One whose line is as high at idle loses as much there.
    """
    unit, readings = load_controller(name), []
    points = {each.state: each for each in reversed(unit.operating_points) if each.gear == 1}
    at_idle = 0.4 if points["stall"].main_pressure > 1.2 * points["idle"].main_pressure else 1.0
    for engine, state, part in ((SLOW, "idle", at_idle), (STALL, "stall", 1.0)):
        point = points[state]
        new = project(LeakageModel(unit, clearances(None, unit), load_fluid("hipol_atf_iid"), WORKSHOP), point)
        held = new.circuit(STANDING[name]).pressure
        readings.append(at("D", engine, new.main_pressure_held / 1e3 + line_by * part, **more))
        readings.append(at("D", engine, held / 1e3 + tap_by * part, STANDING[name], **more))
    return unit, readings


@pytest.mark.parametrize("name", first_of(STANDING))
@pytest.mark.parametrize(("tap_by", "line_by"), [(0.0, 0.0), (-35.0, 35.0), (30.0, -30.0)])
def test_what_gauges_err_by_is_no_fault(judged, name: str, tap_by: float, line_by: float) -> None:
    unit, readings = standing(name, tap_by, line_by)  # up to 70 kPa below the line, by two gauges within their 2 %
    of_circuit = [each for each in checked(judged(unit, *readings)) if each.cell.tap != LINE_TAP]
    assert [each.verdict for each in of_circuit] == ["ok", "ok"]
    assert all(each.over_limit < 0.5 and each.loss_interval[0] <= each.loss for each in of_circuit)


@pytest.mark.parametrize("name", first_of(STANDING))
def test_a_circuit_that_lost_its_pressure_is_found_with_what_may_leak(judged, name: str) -> None:
    unit, readings = standing(name, -250.0)
    diagnosis = judged(unit, *readings)
    worst = next(each for each in checked(diagnosis) if each.cell == GaugeCell("D", STALL, STANDING[name]))
    assert worst.verdict == Verdict.REPLACE
    assert worst.deciding.decision == "fail"
    low, high = worst.loss_interval
    assert 103e3 < low < worst.loss < high
    (pattern,) = (each for each in diagnosis.pressures.patterns if each.kind == "circuit_loss")
    assert pattern.circuits == (STANDING[name],)
    assert ("seal", STANDING[name]) in pattern.causes
    assert list(pattern.causes.values()) == sorted(pattern.causes.values(), reverse=True)
    assert sum(pattern.causes.values()) == pytest.approx(1.0, abs=1e-6)
    assert diagnosis.decided_by.label.startswith("pressure lost against new of ")
    assert diagnosis.decided_by.circuit.id == STANDING[name]
    record = next(each for each in gauge_record(diagnosis)["patterns"] if each["kind"] == "circuit_loss")
    assert {land["component"] for land in record["lands"]} <= set(unit.components)


def test_what_may_be_a_loss_and_may_not_keeps_its_level_and_passes_on_condition(judged) -> None:
    decisions = set()
    for lower in (-60.0, -75.0, -90.0):
        unit, readings = standing("five_speed_2005", lower)
        *_, each = checked(judged(unit, *readings))
        assert (each.cell.tap, each.cell.engine) == ("forward_clutch", STALL)
        assert each.verdict.flagged == (each.deciding.levels[0].probability_over >= 0.5)
        if 0.05 < each.deciding.levels[0].probability_over < 0.5:
            decisions.add((each.verdict, each.deciding.decision))
    assert decisions == {(Verdict.OK, "conditional_pass")}


def test_one_gauge_on_two_taps_errs_alike_in_both(judged) -> None:
    apart = checked(judged(*_flat("five_speed_2005")))
    same = checked(judged(*_flat("five_speed_2005", gauge="1")))
    widths = [each[-1].loss_interval[1] - each[-1].loss_interval[0] for each in (apart, same)]
    assert widths[1] < widths[0]


def _flat(name: str, **more) -> tuple:
    unit, readings = standing(name, -150.0, **more)
    return unit, *readings


def test_a_line_that_is_set_otherwise_is_no_loss_of_its_circuits(judged) -> None:
    unit = load_controller("five_speed_2005")
    for kpa in (780.0, 1020.0):  # both are permitted, and the file states 890
        of_line, of_circuit = checked(judged(unit, at("D", SLOW, kpa), at("D", SLOW, kpa - 6.0, "forward_clutch")))
        assert (of_line.verdict, of_circuit.verdict) == ("ok", "ok")
    low = checked(judged(unit, at("D", SLOW, 1020.0), at("D", SLOW, 850.0, "forward_clutch")))[1]
    assert low.verdict == Verdict.REPLACE, "it is 170 below its own line"


@pytest.mark.parametrize(
    ("line", "tap", "why"),
    [
        (("D", 890.0), ("D", 3000.0), "higher than the valve body's file says"),
        (("D", 2500.0), ("D", 880.0), "higher than the valve body's file says"),
        (("D", 0.0), ("D", 0.0), "shows no pressure"),
        (("R", 1265.0), ("R", 1260.0), "not applied"),
    ],
)
def test_readings_that_tell_nothing_are_not_judged_and_say_why(judged, line, tap, why: str) -> None:
    unit = load_controller("five_speed_2005")
    diagnosis = judged(unit, at(line[0], SLOW, line[1]), at(tap[0], SLOW, tap[1], "forward_clutch"))
    assert checked(diagnosis)[1].verdict is None
    assert any(why in each.text for each in diagnosis.messages if each.code == "pressure_not_judged")
    assert why in gauge_record(diagnosis)["readings"][1]["not_judged"]


def test_where_the_file_has_no_operating_point_only_what_is_surely_below_the_line_counts(judged) -> None:
    unit = load_controller("five_speed_2005")  # it states none of a stall in reverse
    for kpa, verdict in ((2150.0, "ok"), (2060.0, "ok"), (1800.0, "replace")):
        of_circuit = checked(judged(unit, at("R", STALL, 2200.0), at("R", STALL, kpa, "direct_clutch")))[1]
        assert (of_circuit.verdict, of_circuit.lost) == (verdict, None)
        assert of_circuit.deciding.decision != "pass"


def test_a_tap_alone_is_judged_and_what_that_cannot_tell_is_said(judged) -> None:
    unit = load_controller("five_speed_2005")
    sound, low = (judged(unit, at("D", SLOW, kpa, "forward_clutch")) for kpa in (880.0, 500.0))
    assert checked(sound)[0].verdict == Verdict.OK
    assert checked(low)[0].verdict == Verdict.REPLACE
    assert any(each.code == "line_not_read" for each in low.messages)


def test_lands_that_were_measured_count_as_measured(judged, tmp_path: Path) -> None:
    unit, readings = standing("five_speed_2005", -150.0)
    before = judged(unit, *readings).pressures.patterns[0].causes
    likeliest = next(which for what, *which in before if what == "land")[0]
    rows = ["component,part,plane,direction,repeat,diameter_mm"]
    land = unit.land(*likeliest)
    for part, diameter in (("spool", land.nominal_diameter), ("sleeve", land.nominal_diameter + 2 * 12e-6)):
        rows += [f"{land.component},{part},{land.planes[0]},{angle},1,{diameter * 1e3:.4f}" for angle in (0, 90)]
    sheet = tmp_path / "sheet.csv"
    sheet.write_text("\n".join(rows), encoding="utf-8")
    (pattern,) = judged(unit, *readings, readings=read_readings(sheet, unit)).pressures.patterns
    after = pattern.causes
    assert pattern.measured
    assert after.get(("land", likeliest), 0.0) < 0.3 * before["land", likeliest]


# --- the line beside a tap


def timed(text: str, tmp_path: Path, unit: Controller) -> PressureTable:
    path = tmp_path / "g.csv"
    path.write_text("range;state;tap;time [s];pressure [kPa]\n" + text, encoding="utf-8")
    return read_pressure_table(path, unit)


@pytest.mark.parametrize(
    ("rows", "below", "verdict"),
    [
        ("D;slow idle;line;0;900\nD;slow idle;forward_clutch;5;700\nD;slow idle;line;60;690\n", 200.0, "replace"),
        ("D;slow idle;line;0;690\nD;slow idle;forward_clutch;5;684\nD;slow idle;line;60;900\n", 6.0, "ok"),
        ("D;slow idle;line;0;690\nD;slow idle;forward_clutch;55;700\nD;slow idle;line;60;900\n", 200.0, "replace"),
        ("D;slow idle;line;0;900\nD;slow idle;forward_clutch;31;700\n", None, None),
        ("D;slow idle;line;0;900\nD;slow idle;forward_clutch;30;700\n", 200.0, "replace"),
        ("D;slow idle;line;09:00:00;900\nD;slow idle;forward_clutch;09:01:00;700\n", None, None),
    ],
)
def test_a_tap_is_judged_beside_the_line_as_it_was_at_its_time(hipol, limits, tmp_path, rows, below, verdict) -> None:
    unit = load_controller("five_speed_2005")
    diagnosis = diagnose(unit, hipol, limits, pressures=timed(rows, tmp_path, unit))
    tap = next(each for each in checked(diagnosis) if each.cell.tap == "forward_clutch")
    assert tap.verdict == verdict
    if below is None:
        assert tap.below_line is None
        assert any("30 s before or after" in each.text for each in diagnosis.messages)
    else:
        assert tap.below_line == pytest.approx(below * 1e3, abs=1e-6)


def test_a_line_that_falls_while_it_is_read_is_not_the_clutchs_fault(hipol, limits, tmp_path) -> None:
    unit, rows = load_controller("five_speed_2005"), ""
    for number, kpa in enumerate((900, 800, 700)):
        rows += f"D;slow idle;line;{60 * number};{kpa}\nD;slow idle;forward_clutch;{60 * number + 5};{kpa - 10}\n"
    diagnosis = diagnose(unit, hipol, limits, pressures=timed(rows, tmp_path, unit))
    taps = [each for each in checked(diagnosis) if each.cell.tap == "forward_clutch"]
    assert [each.below_line for each in taps] == pytest.approx([10e3] * 3, abs=1e-6)
    assert {each.verdict for each in taps} == {"ok"}
    assert diagnosis.verdict == Verdict.CRITICAL, "the line itself is below what is published"
    assert "falling" in {each.kind for each in diagnosis.pressures.patterns}


@pytest.mark.parametrize(
    ("changes", "below"),
    [
        ({"set_pressure": SetPressure(number=350e3)}, 50e3),  # regulated below the line
        ({"set_pressure": SetPressure(gears=MappingProxyType({1: 320e3}))}, 20e3),
        ({"set_pressure": SetPressure(number=900e3)}, 200e3),
        ({"feeds": (Feed("p_s", 1e-3, 0.62),)}, None),  # not fed from the line
        ({"gears": frozenset({2})}, None),  # not applied while standing
    ],
)
def test_a_circuit_is_held_to_its_regulator_and_only_where_it_is_fed_from_the_line(
    unit, judged, changes, below
) -> None:
    diagnosis = judged(with_circuit(unit, **changes), at("D", SLOW, 500.0), at("D", SLOW, 300.0, "clutch_c1"))
    got = checked(diagnosis)[1].below_line
    assert got is None if below is None else got == pytest.approx(below, abs=1e-6)


def test_a_circuit_is_held_against_the_line_as_it_was_read_with_it_or_else_last(unit, judged) -> None:
    line = [at("D", SLOW, kpa, repeat=number, round=float(number)) for number, kpa in ((1, 520.0), (2, 500.0))]
    taps = [at("D", SLOW, 450.0, "clutch_c1", repeat=1, round=1.0), at("D", SLOW, 450.0, "clutch_c1", repeat=2)]
    *_, with_first, alone = checked(judged(with_circuit(unit), *line, *taps))
    assert with_first.below_line == pytest.approx(70e3, abs=1e-6)
    assert alone.below_line == pytest.approx(50e3, abs=1e-6)


# --- beside everything else


def test_gauges_and_lands_decide_together(unit, judged, sample_readings) -> None:
    readings = read_readings(sample_readings, unit)
    alone = judged(unit, at("D", SLOW, 450.0), readings=readings)
    assert alone.verdict == Verdict.REPLACE
    worse = judged(unit, at("D", SLOW, 200.0), readings=readings)
    assert worse.verdict == Verdict.CRITICAL
    assert worse.decision == "fail"
    assert worse.flagged == alone.flagged or [land.key for land in worse.flagged] == [
        land.key for land in alone.flagged
    ]


def test_the_record_holds_every_reading_with_its_rule(unit, judged) -> None:
    diagnosis = judged(unit, at("D", SLOW, 380.0), at("P", SLOW, 400.0))
    record = gauge_record(diagnosis)
    assert (record["verdict"], record["decision"], record["decided_by"]) == ("watch", "fail", "D, slow idle")
    of_park, of_drive = record["readings"]
    assert (of_park["range"], of_park["verdict"], of_park["rules"]) == ("P", None, [])
    assert (of_drive["pressure_kpa"], of_drive["permissible_low_kpa"]) == (380.0, 400.0)
    assert of_drive["rules"][0]["value"] == pytest.approx(5.0, abs=1e-9)
    assert gauge_record(replace(diagnosis, pressures=None)) is None
    assert "Lost [kPa]" not in gauge_table(diagnosis.pressures, wording("en")).headings


def test_a_terminal_shows_gauges_and_patterns_beside_what_is_permissible(unit, judged, capsys) -> None:
    slow = [at(each, SLOW, 330.0) for each in ("D", "3", "2")]
    print_diagnosis(judged(unit, *slow, *(at(each, FAST, 750.0) for each in ("D", "3", "2", "R", "P"))))
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "the vehicle standing: ■ replace" in shown
    assert "● ok D fast idle 750 " in shown
    assert "not judged P fast idle" in shown
    assert "from 400" in shown
    assert "→ Main pressure is low in all ranges at slow idle (D, 3, 2)" in shown


@pytest.mark.parametrize("language", languages())
def test_a_circuit_that_lost_pressure_names_what_may_leak_the_likeliest_first(language: str) -> None:
    shipped, say = load_controller("five_speed_2005"), wording(language)
    cell = at("D", SLOW, 735.0).cell
    keys = ("manual_valve", 3), ("forward_engagement", 1)
    causes = {("land", keys[0]): 0.5, ("seal", "forward_clutch"): 0.3, ("land", keys[1]): 0.18, ("line",): 0.02}
    pattern = Pattern(
        "circuit_loss", "computed", (cell,), circuits=("forward_clutch",), worst=cell, amount=210e3, causes=causes
    )
    text = pattern_text(pattern, shipped, say)
    first, second = (text.index(land_words(shipped, key, say)) for key in keys)
    assert first < second
    assert say.name("forward clutch") in text
    assert say("patterns.cause_seal") in text
    assert say("patterns.cause_line") not in text, "a fiftieth is not worth naming"
    assert say.percent(0.3, 0) not in text, "no land of the circuit was measured: it rests on assumed rates"
    assert say.percent(0.3, 0) in pattern_text(replace(pattern, measured=True), shipped, say)


def test_every_pattern_has_its_sentence_in_every_language(unit, judged) -> None:
    slow = [at(each, SLOW, 300.0) for each in ("D", "3", "2", "1")]
    diagnosis = judged(with_circuit(unit), *slow, *(at(each, FAST, 500.0) for each in ("D", "3", "2", "1")))
    (pattern,) = diagnosis.pressures.patterns
    texts = {language: pattern_text(pattern, diagnosis.controller, wording(language)) for language in languages()}
    assert len(set(texts.values())) == len(texts)
    assert all("D, 3, 2, 1" in text for text in texts.values())
    for language in languages():
        assert {"practice", "project", "computed"} <= set(wording(language).table("pattern_sources"))


# --- a line for which nothing is permitted


@pytest.mark.usefixtures("all_draws")
@pytest.mark.parametrize("name", first_of(["zf_6hp26", "chrysler_41te", "aisin_aw55_50sn"]))
def test_a_line_without_a_permissible_pressure_is_judged_by_what_a_new_unit_holds(judged, capsys, name: str) -> None:
    unit, readings = replace(load_controller(name), permissible=()), {}
    for engine, state in ((SLOW, "idle"), (STALL, "stall")):
        point = next(each for each in unit.operating_points if (each.gear, each.state) == (1, state))
        new = project(LeakageModel(unit, clearances(None, unit), load_fluid("hipol_atf_iid"), WORKSHOP), point)
        readings[engine] = new.main_pressure_held / 1e3
    for part in (0.97, 1.0, 1.03, 1.1):  # set within its tolerance, read with a gauge of 2 %, or set high
        sound = judged(unit, *(at("D", engine, part * kpa) for engine, kpa in readings.items()))
        assert {each.verdict for each in checked(sound)} == {Verdict.OK}, part
    low = judged(unit, *(at("D", engine, 0.5 * kpa) for engine, kpa in readings.items()))
    assert {each.verdict for each in checked(low)} == {Verdict.REPLACE}
    assert low.decided_by.label.startswith("main pressure below that of a new unit, D, ")
    print_diagnosis(low)
    assert "decided by the main pressure below that of a new unit" in " ".join(capsys.readouterr().out.split())


def test_a_line_and_a_tap_that_hangs_on_it_are_low_by_the_line(judged) -> None:
    rows = (("D", SLOW, 300.0), ("D", SLOW, 298.0, "clutch_a"), ("D", STALL, 800.0), ("D", STALL, 797.0, "clutch_a"))
    diagnosis = judged(load_controller("zf_6hp26"), *(at(*row) for row in rows))
    assert [(each.cell.tap, each.verdict) for each in checked(diagnosis)] == [
        (LINE_TAP, "replace"), (LINE_TAP, "replace"), ("clutch_a", "ok"), ("clutch_a", "ok"),
    ]  # fmt: skip
    assert diagnosis.decided_by.circuit is None
    assert "operating_point" in diagnosis.provisional


def test_of_a_line_that_fell_while_it_was_read_each_reading_is_judged(judged) -> None:
    unit = load_controller("zf_6hp26")
    readings = checked(judged(unit, *(at("D", STALL, kpa, repeat=no) for no, kpa in ((1, 1553.0), (2, 900.0)))))
    assert [each.verdict for each in readings] == ["ok", "replace"]


@pytest.mark.parametrize(
    ("taps", "said"),
    [
        ({"clutch_a": 1550.0}, "by the circuit pressures of gauges alone"),
        ({"clutch_a": 1550.0, LINE_TAP: 1553.0}, "by the main and circuit pressures of gauges alone"),
        ({LINE_TAP: 1553.0}, "by the main pressure of gauges alone"),
    ],
)
def test_a_terminal_names_what_gauges_judged(judged, capsys, taps, said: str) -> None:
    print_diagnosis(judged(load_controller("zf_6hp26"), *(at("D", STALL, kpa, tap) for tap, kpa in taps.items())))
    assert said in " ".join(capsys.readouterr().out.split())


def test_a_reading_that_others_contradict_is_not_called_higher_than_can_be(judged) -> None:
    rows = (("D", SLOW, 0.0, "clutch_a"), ("D", STALL, 1550.0, "clutch_a"))
    *_, stall = checked(judged(load_controller("zf_6hp26"), *(at(*row) for row in rows)))
    assert "contradict one another" in str(stall.unjudged)


@pytest.mark.parametrize(
    ("unit", "typed", "shown"),
    [
        ("kPa", ("870", "1240"), ["870", "1\u00a0240"]),
        ("kPa", ("870", "450,5"), ["870.0", "450.5"]),
        ("bar", ("8,7", "12,4"), ["870", "1\u00a0240"]),
        ("psi", ("120", "180"), ["827", "1\u00a0241"]),
    ],
)
def test_a_gauge_reading_has_the_decimals_that_were_typed(unit: str, typed: Sequence[str], shown: list[str]) -> None:
    rows = [f"{place};slow idle;line;{each}" for place, each in zip("PR", typed, strict=True)]
    table = "\n".join([f"range;state;tap;pressure [{unit}]", *rows]).encode()
    check = Case(controller="four_speed_2023", pressures=SourceFile("typed.csv", table)).diagnose().pressures
    column = next(each for each in gauge_table(check, wording("en")).columns if each.key == "gauge")
    assert [column.text(each, wording("en")) for each in check.readings] == shown
