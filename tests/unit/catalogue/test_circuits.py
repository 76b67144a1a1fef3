"""What a controller's file says of circuits, leaks, consumers and permissible pressures, and what it may not say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import CatalogueError, InputError

Edited = Callable[..., Path]

CLUTCH = """
[[circuits]]
id = "clutch_c1"
name = "clutch C1"
gears = [1, 2, 3]
feeds = [{ from = "p_g", diameter_mm = 0.5 }, { from = "p_g", diameter_mm = 0.8, discharge_coefficient = 0.7 }]
set_kpa = 400.0
source = "drill gauge"
"""
RINGS = """
[[leaks]]
id = "c1_rings"
from = "clutch_c1"
law = "laminar"
flow_dm3_min = 0.06
at_kpa = 400.0
at_viscosity_mm2_s = 7.0
source = "own test"
"""
CONVERTER = """
[[consumers]]
id = "converter_and_cooler"
flow_dm3_min = { hot_idle = 3.0, driving_second = 6.0 }
after_line = true
source = "own test"
"""
PERMISSIBLE = """
[[permissible_pressure]]
gears = [1, 2]
state = "idle"
low_kpa = 412.0
source = "manual"
"""
LINE = """
[line]
set_kpa = { from = "clutch_c1", ratio = 1.5, offset_kpa = 100.0 }
source = "diagram"
"""
EVERYTHING = CLUTCH + RINGS + CONVERTER + PERMISSIBLE + LINE


def with_circuits(edited: Edited, *changes: tuple[str, str], text: str = EVERYTHING) -> Path:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = edited("controllers", "minimal_example")
    with path.open("a", encoding="utf-8") as file:
        file.write(text)
    return path


def loaded(edited: Edited, *changes: tuple[str, str]) -> Controller:
    return load_controller(with_circuits(edited, *changes))


# --- what it says


def test_a_circuit_has_its_feeds_in_metres_and_its_set_pressure_in_pascals(edited: Edited) -> None:
    controller = loaded(edited)
    (clutch,) = controller.circuits
    assert [feed.diameter for feed in clutch.feeds] == pytest.approx([0.5e-3, 0.8e-3], rel=1e-12, abs=0.0)
    assert [feed.discharge_coefficient for feed in clutch.feeds] == [0.62, 0.7]
    assert clutch.set_pressure is not None
    assert clutch.set_pressure.at(controller.operating_points[0]) == pytest.approx(400e3, rel=1e-12, abs=0.0)
    assert clutch.gears == {1, 2, 3}


def test_a_circuit_without_gears_is_applied_in_all(edited: Edited) -> None:
    controller = loaded(edited, ("gears = [1, 2, 3]\n", ""))
    assert controller.circuits[0].gears == set(controller.gears)


def test_a_laminar_leak_keeps_the_dynamic_viscosity_of_its_measurement(edited: Edited) -> None:
    (rings,) = loaded(edited).leaks
    assert (rings.name, rings.into_sump) == ("c1 rings", True)
    assert rings.flow == pytest.approx(1e-6, rel=1e-12, abs=0.0)
    assert rings.viscosity == pytest.approx(7e-6 * 830.0, rel=1e-12, abs=0.0)


@pytest.mark.parametrize(
    ("keys", "law", "pressure"),
    [
        ("", "orifice", None),
        ('law = "orifice"\n', "orifice", None),
        ("at_kpa = 350\n", "orifice", 350e3),
        ('law = "constant"\n', "constant", None),
    ],
)
def test_a_consumer_before_the_line_is_an_orifice_unless_it_says_otherwise(
    edited: Edited, keys: str, law: str, pressure: float | None
) -> None:
    (converter,) = load_controller(with_circuits(edited, ("after_line = true\n", keys))).consumers
    assert (converter.after_line, converter.law, converter.pressure) == (False, law, pressure)


def test_a_consumer_takes_its_flow_by_operating_point(edited: Edited) -> None:
    controller = loaded(edited)
    (converter,) = controller.consumers
    assert converter.after_line
    assert {point.name: converter.at(point) * 60e3 for point in controller.operating_points} == pytest.approx(
        {"driving_second": 6.0, "hot_idle": 3.0}, rel=1e-12, abs=0.0
    )


def test_a_permissible_pressure_holds_in_its_gears_and_its_state(edited: Edited) -> None:
    controller = loaded(edited)
    permissible = controller.permissible_at(2, "idle")
    assert permissible is not None
    assert (permissible.low, permissible.high) == (pytest.approx(412e3, rel=1e-12, abs=0.0), None)
    assert controller.permissible_at(3, "idle") is None
    assert controller.permissible_at(2, "driving") is None


def test_a_point_idles_below_a_thousand_revolutions_unless_it_says_what_it_is(edited: Edited) -> None:
    driving, idle = loaded(edited).operating_points
    assert (driving.state, idle.state) == ("driving", "idle")
    assert replace(idle, engine_speed=999.9 / 60.0).state == "idle"
    assert replace(idle, engine_speed=1000.0 / 60.0).state == "driving"
    assert replace(driving, stated_state="stall").state == "stall"


@pytest.mark.parametrize(
    ("stated", "at_idle_kpa", "driving_kpa"),
    [
        ("{ hot_idle = 150.0, driving_second = 400.0 }", 150.0, 400.0),
        ("{ gear = { 1 = 300.0, 2 = 450.0, 3 = 500.0 } }", 300.0, 450.0),
    ],
)
def test_a_set_pressure_by_operating_point_or_gear(
    edited: Edited, stated: str, at_idle_kpa: float, driving_kpa: float
) -> None:
    controller = loaded(edited, ("set_kpa = 400.0", f"set_kpa = {stated}"))
    regulator = controller.circuits[0].set_pressure
    assert regulator is not None
    driving, idle = controller.operating_points
    assert (regulator.at(idle), regulator.at(driving)) == pytest.approx(
        (at_idle_kpa * 1e3, driving_kpa * 1e3), abs=1e-6
    )


def test_a_set_pressure_by_current_runs_straight_between_its_points(edited: Edited) -> None:
    path = with_circuits(edited, ("set_kpa = 400.0", "set_kpa = { current_ma = [0, 500, 1000], kpa = [600, 300, 20] }"))
    text = path.read_text(encoding="utf-8").replace("p_k_kpa", "solenoid_current_ma = 250.0\np_k_kpa")
    path.write_text(text, encoding="utf-8")
    controller = load_controller(path)
    regulator = controller.circuits[0].set_pressure
    assert regulator is not None
    assert regulator.at(controller.operating_points[0]) == pytest.approx(450e3, abs=1e-6)
    strong = replace(controller.operating_points[0], solenoid_current=2.0)
    assert regulator.at(strong) == pytest.approx(20e3, abs=1e-6)


def test_a_set_pressure_by_duty_runs_straight_between_its_points(edited: Edited) -> None:
    path = with_circuits(edited, ("set_kpa = 400.0", "set_kpa = { duty_percent = [0, 100], kpa = [0, 600] }"))
    with pytest.raises(CatalogueError, match="lockup_duty_percent in every table"):
        load_controller(path)
    text = path.read_text(encoding="utf-8").replace("p_k_kpa", "lockup_duty_percent = 35.0\np_k_kpa")
    path.write_text(text, encoding="utf-8")
    controller = load_controller(path)
    regulator = controller.circuits[0].set_pressure
    assert regulator is not None
    assert regulator.at(controller.operating_points[0]) == pytest.approx(210e3, abs=1e-6)
    open_wide = replace(controller.operating_points[0], lockup_duty=1.0)
    assert regulator.at(open_wide) == pytest.approx(600e3, abs=1e-6)


def test_the_line_follows_a_circuit(edited: Edited) -> None:
    controller = loaded(edited)
    assert controller.line is not None
    assert controller.line_source == "diagram"
    pressures = {"clutch_c1": 400e3}
    assert controller.line.with_pressures(controller.operating_points[0], pressures) == pytest.approx(700e3, abs=1e-6)


def test_a_point_of_one_s_own_for_which_nothing_is_stated_is_refused_by_name(edited: Edited) -> None:
    controller = loaded(edited)
    own = replace(controller.operating_points[0], name="stall")
    with pytest.raises(InputError, match=r"nothing for this operating point .*stall.*hot_idle"):
        controller.consumers[0].at(own)
    like = replace(own, values_of="hot_idle")
    assert controller.consumers[0].at(like) == pytest.approx(3.0 / 60e3, rel=1e-12, abs=0.0)


# --- what it may not say


@pytest.mark.parametrize(
    ("change", "table", "words"),
    [
        (('id = "clutch_c1"', 'id = "p_g"'), "circuits[1]", ["p_g", "another id"]),
        (('id = "clutch_c1"', 'id = "7"'), "circuits", ["7"]),
        (('from = "p_g", diameter_mm = 0.5', 'from = "p_h", diameter_mm = 0.5'), "circuits[1]", ["p_h", "one of p_g"]),
        (('from = "p_g", diameter_mm = 0.5', 'from = "clutch_c1", diameter_mm = 0.5'), "circuits[1]", ["feeds itself"]),
        (("diameter_mm = 0.5", "diameter_mm = 0.0"), "circuits", ["diameter_mm", "0"]),
        (("discharge_coefficient = 0.7", "discharge_coefficient = 1.7"), "circuits", ["discharge_coefficient", "1.7"]),
        (("gears = [1, 2, 3]", "gears = [1, 9]"), "circuits[1]", ["unknown gear", "9"]),
        (("set_kpa = 400.0", 'set_kpa = "400"'), "circuits", ["set_kpa", "0 to 10000"]),
        (("set_kpa = 400.0", "set_kpa = -5.0"), "circuits", ["set_kpa", "0 to 10000"]),
        (("set_kpa = 400.0", "set_kpa = { hot_idle = 150.0 }"), "circuits[1]", ["driving_second", "too"]),
        (("set_kpa = 400.0", "set_kpa = { stall = 150.0 }"), "circuits[1]", ["no such operating point", "stall"]),
        (("set_kpa = 400.0", "set_kpa = { gear = { 1 = 300.0 } }"), "circuits[1]", ["gears 2, 3 too"]),
        (
            ("set_kpa = 400.0", "set_kpa = { current_ma = [0, 500], kpa = [600, 20] }"),
            "circuits[1]",
            ["solenoid_current_ma in every"],
        ),
        (("set_kpa = 400.0", "set_kpa = { current_ma = [500, 0], kpa = [600, 20] }"), "circuits", ["rising"]),
        (
            ("set_kpa = 400.0", "set_kpa = { current_ma = [0, 500], kpa = [600, 300, 20] }"),
            "circuits",
            ["as many pressures"],
        ),
        (("set_kpa = 400.0", 'set_kpa = { from = "clutch_c1", ratio = 2.0 }'), "circuits[1]", ["follows itself"]),
        (("set_kpa = 400.0", 'set_kpa = { from = "p_g", ratio = -1.0 }'), "circuits", ["ratio"]),
        (('law = "laminar"', 'law = "turbulent"'), "leaks", ["law", "laminar"]),
        (("at_viscosity_mm2_s = 7.0\n", ""), "leaks", ["at_viscosity_mm2_s"]),
        (('from = "clutch_c1"\nlaw', 'from = "clutch_c2"\nlaw'), "leaks[1]", ["clutch_c2", "clutch_c1"]),
        (("flow_dm3_min = 0.06", "flow_dm3_min = -0.06"), "leaks", ["flow_dm3_min"]),
        (('from = "clutch_c1"\nlaw', 'from = "drain"\nlaw'), "leaks[1]", ["from no section", "drain"]),
        (('from = "clutch_c1"\nlaw', 'from = "clutch_c1"\nto = "clutch_c1"\nlaw'), "leaks[1]", ["where it begins"]),
        (("{ hot_idle = 3.0, driving_second = 6.0 }", "{ hot_idle = 3.0 }"), "consumers[1]", ["driving_second too"]),
        (("{ hot_idle = 3.0, driving_second = 6.0 }", '"3"'), "consumers", ["flow_dm3_min"]),
        (('state = "idle"', 'state = "parked"'), "permissible_pressure", ["state", "parked"]),
        (("low_kpa = 412.0\n", ""), "permissible_pressure", ["low_kpa, high_kpa or both"]),
        (("low_kpa = 412.0", "low_kpa = 412.0\nhigh_kpa = 400.0"), "permissible_pressure", ["high_kpa above low_kpa"]),
        (
            ("gears = [1, 2]\nstate", "gear = 1\ngears = [1, 2]\nstate"),
            "permissible_pressure",
            ["either gear or gears"],
        ),
        (('from = "clutch_c1", ratio = 1.5', 'from = "p_g", ratio = 1.5'), "line", ["p_g", "the id of a circuit"]),
        ((", offset_kpa = 100.0 }\nsource", " }\nsource"), "line", ["no pressure in gear 4", "more than 0 kPa"]),
        (("after_line = true", "before_line = true"), "consumers", ["before_line", "after_line"]),
        (("after_line = true", "at_kpa = 0.0"), "consumers", ["at_kpa", "0", "greater than 0"]),
        (("after_line = true", "after_line = true\nat_kpa = 400.0"), "consumers", ["beside after_line"]),
        (("after_line = true", 'after_line = true\nlaw = "orifice"'), "consumers", ["beside after_line"]),
        (("after_line = true", 'law = "constant"\nat_kpa = 400.0'), "consumers", ["no at_kpa beside a constant law"]),
        (("after_line = true", 'law = "laminar"'), "consumers", ["law", "laminar"]),
    ],
)
def test_what_cannot_be_is_refused_where_it_stands(
    edited: Edited, change: tuple[str, str], table: str, words: list[str]
) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_controller(with_circuits(edited, change))
    message = str(caught.value)
    assert "own.toml" in message
    assert table in message
    for word in words:
        assert word in message, message


@pytest.mark.parametrize(
    ("twice", "words"),
    [
        (CLUTCH, "circuit given twice"),
        (RINGS, "leak given twice"),
        (CONVERTER, "consumer given twice"),
        (PERMISSIBLE, "gear given twice for the state idle"),
    ],
)
def test_nothing_is_given_twice(edited: Edited, twice: str, words: str) -> None:
    with pytest.raises(CatalogueError, match=words):
        load_controller(with_circuits(edited, text=EVERYTHING + twice))


def test_circuits_may_not_feed_one_another_in_a_circle(edited: Edited) -> None:
    first = CLUTCH.replace('from = "p_g"', 'from = "clutch_c2"')
    other = CLUTCH.replace("clutch_c1", "clutch_c2").replace('from = "p_g"', 'from = "clutch_c1"')
    with pytest.raises(CatalogueError, match="feed one another in a circle") as caught:
        load_controller(with_circuits(edited, text=first + other))
    assert caught.value.place.table == "circuits[1] (clutch_c1)"


def test_circuits_may_not_follow_one_another_in_a_circle(edited: Edited) -> None:
    other = CLUTCH.replace("clutch_c1", "clutch_c2").replace("400.0", '{ from = "clutch_c1", ratio = 1.0 }')
    first = CLUTCH.replace("400.0", '{ from = "clutch_c2", ratio = 1.0 }')
    with pytest.raises(CatalogueError, match="follows itself"):
        load_controller(with_circuits(edited, text=first + other))
